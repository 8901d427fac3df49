use super::*;

const KIND: TransponderType =
    TransponderType { receiver: SensorIndex(1), manufacturer: Some(*b"NAT"), model: None };

/// Reports whose noise is a quarter of the configured one.
fn known() -> TypeLearning {
    let mut learning = TypeLearning::default();
    for second in 1..=40 {
        let report = [std::array::from_fn(|index| -0.1 * (index as f64 - 4.0).abs()); 2];
        learning.take_report(Time::from_nanos(second * 1_000_000_000), &report, 1.0, 3600.0);
    }
    for radar in [0, 2] {
        let sums = DelaySums::from_numbers(&[0.0, 0.1, -0.1, 2.0, 0.0, 40.0, f64::from(radar)]);
        learning.delays.insert(SensorIndex(radar), sums);
    }
    learning
}

fn text(learning: &TypeLearning) -> String {
    serde_json::to_string(&TypeState::of(&KIND, learning)).unwrap()
}

fn read(text: &str) -> Result<(TransponderType, TypeLearning), String> {
    let state: TypeState = serde_json::from_str(text).map_err(|error| error.to_string())?;
    state.restored().map_err(|error| error.to_string())
}

#[test]
fn saved_state_is_restored() {
    let before = known();
    let (kind, after) = read(&text(&before)).unwrap();
    assert_eq!(kind, KIND);
    assert_eq!((after.reports, after.heard), (40, Time::from_nanos(40_000_000_000)));
    assert_eq!(after.noise.each_ref().map(WhiteNoise::scale), before.noise.each_ref().map(WhiteNoise::scale));
    assert!(after.noise[0].scale().0 < 0.5);
    assert_eq!(after.delays, before.delays);
}

#[test]
fn sensors_may_stand_elsewhere_after_a_restart() {
    let state = TypeState::of(&KIND, &known());
    let moved = state.clone().renumbered(|sensor| match sensor.0 {
        0 => Some(SensorIndex(5)),
        1 => Some(SensorIndex(0)),
        _ => None,
    });
    let (kind, learning) = moved.unwrap().restored().unwrap();
    assert_eq!(kind.receiver, SensorIndex(0));
    assert_eq!(learning.delays.keys().collect::<Vec<_>>(), [&SensorIndex(5)]);
    assert_eq!(state.renumbered(|sensor| (sensor.0 != 1).then_some(sensor)), None);
}

#[test]
fn invalid_state_is_refused() {
    let sound = text(&known());
    assert!(read(&sound).is_ok());
    let noise = sound.find("\"noise\":[\"").unwrap() + 10;
    let end = noise + sound[noise..].find('"').unwrap();
    let numbers = &sound[noise..end];
    let short = numbers.rsplit_once(' ').unwrap().0;
    for bad in [
        String::new(),
        short.to_owned(),
        format!("{short} inf"),
        format!("{short} NaN"),
        format!("{short} 1.0"),
        format!("{short} -1e300"),
        ["-1.0"; COUNT].join(" "),
    ] {
        let hurt = format!("{}{bad}{}", &sound[..noise], &sound[end..]);
        assert!(read(&hurt).is_err(), "{bad}");
    }
    assert!(read(&sound.replacen("\"version\":1", "\"version\":7", 1)).unwrap_err().contains("version 7"));
    assert!(read(&sound.replacen("\"heard\"", "\"seen\"", 1)).is_err());
}
