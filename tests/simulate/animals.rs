//! Birds, vehicles and clutter as seen by a perfect radar.

use utm_fusion::simulate::Scenario;

use crate::common::{Plot, between, deviation, fly, mean, perfect, probability};

/// Scenario with a radar that misses nothing, so that a track is a target.
fn watched(mut scenario: Scenario) -> Scenario {
    scenario.duration_s = 60.0;
    let radar = &mut scenario.radars[0];
    (radar.velocities, radar.min_range_m, radar.max_range_m) = (true, 0.0, 20_000.0);
    scenario
}

fn speed_m_s(plot: &Plot) -> f64 {
    plot.record.track_velocity.unwrap().speed_m_s()
}

#[test]
fn birds_fly_6_to_16_m_s_and_65_percent_have_zero_probability() {
    let mut scenario = watched(perfect(0, 0, 1000));
    scenario.radars[0].period_s = 1.0;
    let flown = fly(&scenario, 1);
    let tracks = flown.plots_by_number();
    assert_eq!(tracks.len(), 1000);
    let mut probabilities = Vec::new();
    let (mut slowest, mut fastest) = (f64::MAX, f64::MIN);
    for plots in tracks.values() {
        assert!(plots.iter().all(|plot| plot.drone.is_none()));
        let speed = speed_m_s(plots[0]);
        // Each bird has a constant speed, except for the resolution of I048/200.
        assert!(plots.iter().all(|plot| (speed_m_s(plot) - speed).abs() < 0.12));
        (slowest, fastest) = (slowest.min(speed), fastest.max(speed));
        let way = plots[1].position - plots[0].position;
        assert!((way.norm() - speed).abs() < 20.0, "{way:?}");
        let likely = probability(plots[0]);
        assert!(plots.iter().all(|plot| (probability(plot) - likely).abs() < 1e-9));
        probabilities.push(likely);
    }
    between("slowest bird, m/s", 5.9, slowest, 6.2);
    between("fastest bird, m/s", 15.8, fastest, 16.1);
    let count =
        |low: f64, high: f64| probabilities.iter().filter(|p| (low..=high).contains(*p)).count() as f64;
    between("share that is always 0", 0.61, count(0.0, 0.0) / 1000.0, 0.69);
    let others = 1000.0 - count(0.0, 0.0);
    between("share of the others from 0.05 to 0.35", 0.92, count(0.048, 0.352) / others, 0.98);
    between("share of the others from 0.4 to 0.7", 0.02, count(0.398, 0.702) / others, 0.08);
    assert_eq!(count(0.048, 0.352) + count(0.398, 0.702), others);
}

#[test]
fn the_birds_of_a_flock_stay_together() {
    let mut scenario = watched(perfect(0, 0, 0));
    (scenario.birds.flocks, scenario.birds.flock_size) = (2, 200);
    let flown = fly(&scenario, 1);
    let tracks: Vec<Vec<&Plot>> = flown.plots_by_number().into_values().collect();
    assert_eq!(tracks.len(), 400);
    // The first turn numbers them in order: one flock, then the other.
    for flock in tracks.chunks(200) {
        for turn in [0, 40, 200] {
            for (axis, spread_m) in [15.0, 15.0, 5.0].into_iter().enumerate() {
                let places: Vec<f64> = flock.iter().map(|plots| plots[turn].position[axis]).collect();
                between("spread, m", 0.85 * spread_m, deviation(&places), 1.15 * spread_m + 0.5);
            }
        }
    }
}

#[test]
fn vehicles_drive_and_clutter_stands_on_the_ground() {
    let mut scenario = watched(perfect(0, 0, 0));
    (scenario.clutter.vehicles, scenario.clutter.points) = (60, 40);
    let flown = fly(&scenario, 1);
    let tracks = flown.plots_by_number();
    assert_eq!(tracks.len(), 100);
    let ground_m = scenario.place.ground_amsl_m;
    let height_m = |plot: &Plot| plot.record.height_3d.unwrap().height_m() - ground_m;
    let (vehicles, points): (Vec<_>, Vec<_>) = tracks.values().partition(|plots| speed_m_s(plots[0]) > 1.0);
    assert_eq!((vehicles.len(), points.len()), (60, 40));
    let speeds: Vec<f64> = vehicles.iter().map(|plots| speed_m_s(plots[0])).collect();
    between("slowest vehicle, m/s", 7.9, speeds.iter().copied().fold(f64::MAX, f64::min), 9.5);
    between("fastest vehicle, m/s", 23.5, speeds.iter().copied().fold(f64::MIN, f64::max), 25.1);
    for plots in vehicles {
        assert!(plots.iter().all(|plot| height_m(plot).abs() < 6.0));
    }
    for plots in points {
        assert!(plots.iter().all(|plot| (plot.position - plots[0].position).norm() < 1e-6));
        assert!((-4.0..=19.0).contains(&height_m(plots[0])));
    }
    let probabilities: Vec<f64> = tracks.values().map(|plots| probability(plots[0])).collect();
    between("mean UAV probability", 0.08, mean(&probabilities), 0.12);
    assert!(probabilities.iter().all(|p| *p <= 0.2));
}
