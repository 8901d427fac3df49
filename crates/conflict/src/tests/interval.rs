//! Intervals inside volumes, compared with motion in small steps and with figures by hand.

use nalgebra::Vector2;
use proptest::prelude::*;

use super::*;

/// State of an aircraft relative to another at the origin, at rest.
fn relative(position: [f64; 3], velocity: [f64; 3]) -> Relative {
    Relative::of(&aircraft(1, [0.0; 3], [0.0; 3]), &aircraft(2, position, velocity))
}

/// Whether the volume is violated after `t` seconds, by its definition.
fn is_violated(volume: &Volume, start: &Relative, t: f64) -> bool {
    let vertical = start.vertical.unwrap();
    let position: Vector2<f64> = start.position + start.velocity * t;
    let closing = position.dot(&start.velocity);
    let miss_m = position.perp(&start.velocity).abs() / start.velocity.norm().max(1e-12);
    let square_m2 = volume.horizontal_m.powi(2) - position.norm_squared();
    let is_soon = closing < 0.0 && miss_m <= volume.horizontal_m && square_m2 / closing <= volume.tau_s;
    (vertical.height_m + vertical.climb * t).abs() <= volume.vertical_m && (square_m2 >= 0.0 || is_soon)
}

fn volumes() -> impl Strategy<Value = Volume> {
    prop_oneof![
        Just(drones()),
        Just(Preset::F3442.volume()),
        Just(Preset::Do365Enroute.volume()),
        Just(Preset::Do365Noncooperative.volume()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn interval_is_that_of_motion_in_small_steps(
        volume in volumes(), place in prop::array::uniform2(-3.0..3.0_f64), up in -3.0..3.0_f64,
        velocity in prop::array::uniform2(-60.0..60.0_f64), climb in -6.0..6.0_f64,
        slow in prop_oneof![4 => Just(1.0), 1 => Just(0.01), 1 => Just(0.0)],
        level in prop_oneof![3 => Just(1.0), 1 => Just(0.0)],
    ) {
        let [east, north] = place.map(|share| share * (volume.horizontal_m + 300.0));
        let start = relative(
            [east, north, up * volume.vertical_m], [slow * velocity[0], slow * velocity[1], level * climb],
        );
        let found = volume.interval(&start, 60.0);
        let step_s = 0.02;
        for step in 0..=3000 {
            let t = f64::from(step) * step_s;
            let is_inside = found.is_some_and(|found| (found.entry_s..=found.exit_s).contains(&t));
            let is_at_rim = found
                .is_some_and(|found| (t - found.entry_s).abs() < 1e-6 || (t - found.exit_s).abs() < 1e-6);
            prop_assert!(is_at_rim || is_inside == is_violated(&volume, &start, t), "{found:?} at {t} s");
        }
        // The time of an alert is that of the interval.
        let passage = start.passage(&volume, &ahead(60.0, 0.0), 0.0);
        if let Some(found) = found {
            prop_assert_eq!((passage.entry_s, passage.exit_s), (found.entry_s, Some(found.exit_s)));
        } else {
            prop_assert!((0.0..=60.0).contains(&passage.entry_s) && passage.exit_s.is_none());
        }
    }

    /// An interval that another aircraft sees is the same, and a second later it is a second nearer.
    #[test]
    fn interval_is_symmetric_and_moves_with_time(
        volume in volumes(), place in prop::array::uniform3(-900.0..900.0_f64),
        velocity in prop::array::uniform3(-30.0..30.0_f64),
    ) {
        let (one, other) = (aircraft(1, [0.0; 3], [0.0; 3]), aircraft(2, place, velocity));
        let found = volume.interval(&Relative::of(&one, &other), 60.0);
        let reverse = volume.interval(&Relative::of(&other, &one), 60.0);
        prop_assert_eq!(found.is_some(), reverse.is_some());
        let later = other.clone().moved(1.0, &ahead(60.0, 0.0));
        if let Some((found, later)) = found.zip(volume.interval(&Relative::of(&one, &later), 59.0)) {
            prop_assert!((found.entry_s - later.entry_s - 1.0).abs() < 1e-6 || found.entry_s < 1.0);
            prop_assert!((found.exit_s - later.exit_s - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn descent_onto_a_hovering_drone_is_an_interval_in_height() {
    // 60 m above, 3 m/s down: the lid of 15 m is reached after 15 s, the floor after 25 s.
    let found = drones().interval(&relative([10.0, 0.0, 60.0], [0.0, 0.0, -3.0]), 60.0).unwrap();
    assert!((found.entry_s - 15.0).abs() < 1e-9 && (found.exit_s - 25.0).abs() < 1e-9, "{found:?}");
}

#[test]
fn slow_drift_towards_a_hovering_drone_is_foreseen() {
    // 0.05 m/s: the radius of 50 m is reached after 40 s.
    let found = drones().interval(&relative([52.0, 0.0, 0.0], [-0.05, 0.0, 0.0]), 60.0).unwrap();
    assert!((found.entry_s - 40.0).abs() < 1e-9 && found.exit_s == 60.0, "{found:?}");
}

#[test]
fn touch_at_one_instant_is_no_entry() {
    assert_eq!(drones().interval(&relative([-100.0, 50.0, 0.0], [10.0, 0.0, 0.0]), 60.0), None);
    assert_eq!(
        drones().interval(&relative([50.0, 0.0, 0.0], [10.0, 0.0, 0.0]), 60.0),
        None,
        "on the rim, leaving"
    );
    let closing = drones().interval(&relative([50.0, 0.0, 0.0], [-10.0, 0.0, 0.0]), 60.0).unwrap();
    assert_eq!((closing.entry_s, closing.exit_s), (0.0, 10.0));
}

/// Modified tau reaches 35 s before the cylinder is entered: (4000² - 1222.32²) / (4000 · 100) is 36.26 s.
#[test]
fn tau_entry_is_when_modified_tau_is_reached() {
    let volume = Preset::Do365Enroute.volume();
    let found = volume.interval(&relative([-4000.0, 0.0, 0.0], [100.0, 0.0, 0.0]), 60.0).unwrap();
    let range_m = 4000.0 - 100.0 * found.entry_s;
    let tau_s = (range_m * range_m - volume.horizontal_m.powi(2)) / (range_m * 100.0);
    assert!((tau_s - 35.0).abs() < 1e-9, "{tau_s} s");
    assert!((found.exit_s - 52.2232).abs() < 1e-9, "{found:?}");
}
