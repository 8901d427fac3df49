//! A restart does not change the registration.

use super::World;
use crate::registration::{Registration, RegistrationState, RegistrationStateError};

fn after(tracks: usize) -> (World, Registration) {
    let mut world = World::wrong(11);
    let mut registration = Registration::default();
    for _ in 0..tracks {
        registration.add(&world.sample(30.0, 2.0));
    }
    (world, registration)
}

#[test]
fn saved_state_is_restored_bit_for_bit() {
    for tracks in [0, 1, 60] {
        let (mut world, mut registration) = after(tracks);
        let text = serde_json::to_string(&registration.to_state()).unwrap();
        let state: RegistrationState = serde_json::from_str(&text).unwrap();
        assert_eq!(state, registration.to_state());
        let mut again = Registration::from_state(&state).unwrap();
        assert_eq!(serde_json::to_string(&again.to_state()).unwrap(), text);
        // Both continue identically.
        for _ in 0..5 {
            let sample = world.sample(30.0, 2.0);
            assert_eq!(again.add(&sample), registration.add(&sample));
        }
        assert_eq!(again.estimate(), registration.estimate());
        assert_eq!(again.to_state(), registration.to_state());
        println!("{tracks} tracks: {} octets", text.len());
    }
}

#[test]
fn invalid_state_is_refused() {
    let (_, registration) = after(3);
    let text = serde_json::to_string(&registration.to_state()).unwrap();
    let read = |text: &str| {
        let state: RegistrationState = serde_json::from_str(text).map_err(|error| error.to_string())?;
        Registration::from_state(&state).map_err(|error| error.to_string())
    };
    assert!(read(&text).is_ok());
    let later = text.replacen("\"version\":1", "\"version\":2", 1);
    assert_eq!(read(&later).unwrap_err(), RegistrationStateError::Version(2).to_string());
    assert!(read(&text.replacen("0.0 0.0", "0.0", 1)).unwrap_err().contains("41 numbers"));
    assert!(read(&text.replacen("0.0 0.0", "0.0 inf", 1)).unwrap_err().contains("42 numbers"));
    assert!(read(&text.replacen("0.0 0.0", "0.0 zero", 1)).is_err());
    assert!(read(&text.replacen("\"now\"", "\"then\"", 1)).is_err());
}
