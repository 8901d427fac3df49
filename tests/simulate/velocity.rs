//! Velocities that a radar reports: those of its targets, or misleading ones.

use nalgebra::Vector2;
use utm_fusion::simulate::{Scenario, Span, VelocityModel};

use crate::common::{Flown, Plot, between, deviation, fly, mean, perfect};

/// Radars without errors, whose tracks last for some seconds, with velocities of this kind without noise.
fn velocities(model: VelocityModel) -> Scenario {
    let mut scenario = perfect(40, 20, 0);
    let radar = &mut scenario.radars[0];
    (radar.velocities, radar.velocity_model) = (true, model);
    (radar.seen_s, radar.unseen_s) = (6.0, 6.0);
    scenario
}

/// Reported velocity, east and north, m/s.
fn told(plot: &Plot) -> Vector2<f64> {
    let velocity = plot.record.track_velocity.unwrap();
    let heading = velocity.heading_deg().to_radians();
    Vector2::new(heading.sin(), heading.cos()) * velocity.speed_m_s()
}

fn flown(flown: &Flown, plot: &Plot) -> Vector2<f64> {
    flown.truth(plot.drone.unwrap(), flown.seconds(plot.time)).velocity.xy()
}

/// CAT048 rounds speeds to 0.11 m/s; within the 1/256 s to which a time is rounded, a drone's velocity changes by 0.02
/// m/s.
const ROUNDED_M_S: f64 = 0.1;

#[test]
fn true_velocities_are_those_of_the_targets() {
    let flight = fly(&velocities(VelocityModel::True), 1);
    for plot in &flight.plots {
        assert!((told(plot) - flown(&flight, plot)).norm() < ROUNDED_M_S, "{plot:?}");
    }
}

#[test]
fn scaled_velocities_are_too_slow_or_too_fast() {
    for scale in [0.5, -2.0] {
        let mut scenario = velocities(VelocityModel::Scaled);
        scenario.radars[0].velocity_scale = scale;
        let flight = fly(&scenario, 1);
        for plot in &flight.plots {
            assert!((told(plot) - flown(&flight, plot) * scale).norm() < 2.0 * ROUNDED_M_S, "{plot:?}");
        }
    }
}

#[test]
fn frozen_velocity_is_constant_per_track() {
    let mut scenario = velocities(VelocityModel::Frozen);
    scenario.radars[0].velocity_frozen_m_s = Span::new(5.0, 20.0);
    let flight = fly(&scenario, 1);
    let tracks = flight.plots_by_number();
    let of_tracks: Vec<Vector2<f64>> = tracks
        .values()
        .map(|plots| {
            let first = told(plots[0]);
            assert!(plots.iter().all(|plot| told(plot) == first), "it stays for the life of a track");
            first
        })
        .collect();
    let speeds: Vec<f64> = of_tracks.iter().map(Vector2::norm).collect();
    assert!(speeds.iter().all(|speed| (4.9..20.1).contains(speed)));
    println!("{} tracks", speeds.len());
    between("mean speed", 12.0, mean(&speeds), 13.0);
    between("its deviation, of 15 / sqrt(12)", 4.1, deviation(&speeds), 4.5);
    // Neither a preferred direction nor that of the flight.
    for axis in 0..2 {
        let parts: Vec<f64> = of_tracks.iter().map(|velocity| velocity[axis]).collect();
        between("mean of an axis", -1.0, mean(&parts), 1.0);
    }
    let with_flight: Vec<f64> =
        flight.plots.iter().map(|plot| told(plot).dot(&flown(&flight, plot))).collect();
    let squares: Vec<f64> = flight.plots.iter().map(|plot| flown(&flight, plot).norm_squared()).collect();
    between("share of the flight's velocity in it", -0.1, mean(&with_flight) / mean(&squares), 0.1);
}

#[test]
fn noise_is_added_to_every_kind() {
    for model in [VelocityModel::True, VelocityModel::Frozen, VelocityModel::Scaled] {
        let of_noise = |noise_m_s: f64| {
            let mut scenario = velocities(model);
            scenario.radars[0].plot_velocity_m_s = noise_m_s;
            fly(&scenario, 1)
        };
        let (without, with) = (of_noise(0.0), of_noise(2.0));
        let noise: Vec<Vector2<f64>> =
            with.plots.iter().zip(&without.plots).map(|(with, without)| told(with) - told(without)).collect();
        for axis in 0..2 {
            let parts: Vec<f64> = noise.iter().map(|noise| noise[axis]).collect();
            between("deviation of an axis, m/s", 1.95, deviation(&parts), 2.05);
        }
    }
}

#[test]
fn velocity_model_changes_only_velocities() {
    let flights = [VelocityModel::True, VelocityModel::Frozen, VelocityModel::Scaled]
        .map(|model| fly(&velocities(model), 1));
    let rest = |flight: &Flown| -> Vec<_> {
        let stripped = |plot: &Plot| {
            let mut record = plot.record.clone();
            record.track_velocity = None;
            (plot.received, format!("{record:?}"))
        };
        flight.plots.iter().map(stripped).collect()
    };
    assert!(flights[1..].iter().all(|flight| rest(flight) == rest(&flights[0])));
    assert!(flights[1..].iter().all(|flight| flight.simulation.labels == flights[0].simulation.labels));
}
