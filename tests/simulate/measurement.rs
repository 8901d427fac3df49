//! Measurement errors of a radar: registration, slow errors of a track, white errors of a plot, turns.

use utm_fusion::simulate::Scenario;

use crate::common::{Flown, Plot, between, deviation, errors, fly, kept, mean, perfect};

const PARTS: [&str; 3] = ["range, m", "azimuth, degrees", "height, m"];

/// Errors of one track per drone over the whole flight: a list for range, azimuth and height.
fn by_drone(flown: &Flown) -> Vec<[Vec<f64>; 3]> {
    let drones = flown.plots_by_drone();
    let of_drone = |plots: &Vec<&Plot>| {
        let mut lists = [const { Vec::new() }; 3];
        for plot in plots {
            errors(flown, plot).into_iter().zip(&mut lists).for_each(|(error, list)| list.push(error));
        }
        lists
    };
    drones.values().map(of_drone).collect()
}

/// All errors of one part.
fn pooled(drones: &[[Vec<f64>; 3]], part: usize) -> Vec<f64> {
    drones.iter().flat_map(|lists| &lists[part]).copied().collect()
}

/// Autocorrelation of an error after this many plots; its mean is known to be 0.
fn autocorrelation(drones: &[[Vec<f64>; 3]], part: usize, later: usize) -> f64 {
    let pairs = || drones.iter().flat_map(|lists| lists[part].iter().zip(&lists[part][later..]));
    pairs().map(|(a, b)| a * b).sum::<f64>() / pairs().map(|(a, _)| a * a).sum::<f64>()
}

#[test]
fn registration_is_what_remains_of_the_mean() {
    let mut scenario = perfect(10, 0, 0);
    let radar = &mut scenario.radars[0];
    (radar.bias_range_m, radar.bias_azimuth_deg, radar.bias_height_m) = (-50.0, 3.0, 20.0);
    let drones = by_drone(&fly(&scenario, 1));
    for (part, (bias, tolerance)) in [(-50.0, 0.3), (3.0, 0.001), (20.0, 0.3)].into_iter().enumerate() {
        between(PARTS[part], bias - tolerance, mean(&pooled(&drones, part)), bias + tolerance);
    }
}

#[test]
fn the_default_registration_shows_through_all_other_errors() {
    let scenario = Scenario { radars: kept("single").radars, ..perfect(60, 60, 0) };
    let flown = fly(&scenario, 1);
    let honest: Vec<[f64; 3]> = flown
        .plots
        .iter()
        .filter(|plot| plot.drone.is_some() && !plot.seduced)
        .map(|plot| errors(&flown, plot))
        .collect();
    let all = |part: usize| mean(&honest.iter().map(|error| error[part]).collect::<Vec<f64>>());
    between("range, m", 3.0, all(0), 5.0);
    between("azimuth, degrees", 0.3, all(1), 0.5);
    between("height, m", 0.8, all(2), 3.2);
}

#[test]
fn slow_errors_fade_within_20_s() {
    let mut scenario = perfect(150, 0, 0);
    scenario.radars[0].period_s = 1.0;
    let radar = &mut scenario.radars[0];
    (radar.track_range_m, radar.track_azimuth_deg, radar.track_height_m) = (60.0, 5.0, 90.0);
    let drones = by_drone(&fly(&scenario, 1));
    for (part, size) in [60.0, 5.0, 90.0].into_iter().enumerate() {
        let errors = pooled(&drones, part);
        between(PARTS[part], 0.94, deviation(&errors) / size, 1.06);
        for later in [5, 20, 40] {
            let correlation = autocorrelation(&drones, part, later);
            let expected = (-(later as f64) / 20.0).exp();
            between(&format!("after {later} s"), expected - 0.08, correlation, expected + 0.08);
        }
    }
}

#[test]
fn white_errors_are_independent_between_plots() {
    let mut scenario = perfect(10, 0, 0);
    let radar = &mut scenario.radars[0];
    (radar.plot_range_m, radar.plot_azimuth_deg, radar.plot_height_m) = (60.0, 5.0, 90.0);
    let drones = by_drone(&fly(&scenario, 1));
    for (part, size) in [60.0, 5.0, 90.0].into_iter().enumerate() {
        between(PARTS[part], 0.97, deviation(&pooled(&drones, part)) / size, 1.03);
        between("after one plot", -0.03, autocorrelation(&drones, part, 1), 0.03);
    }
}

#[test]
fn the_slow_azimuth_error_is_larger_in_turns() {
    let mut scenario = perfect(0, 60, 0);
    let radar = &mut scenario.radars[0];
    (radar.track_azimuth_deg, radar.turn_factor) = (3.0, 1.7);
    let flown = fly(&scenario, 1);
    let (mut straight, mut turning) = (Vec::new(), Vec::new());
    for plot in &flown.plots {
        let (drone, time_s) = (plot.drone.unwrap(), flown.seconds(plot.time));
        // Whether the drone turned in the last 5 s.
        let rates: Vec<f64> = (0..5)
            .map(|back| {
                let [a, b] =
                    [0.5, -0.5].map(|off| flown.truth(drone, time_s - f64::from(back) + off).velocity.xy());
                a.angle(&b).to_degrees()
            })
            .collect();
        let error = errors(&flown, plot)[1];
        match () {
            () if time_s < 6.0 => {}
            () if rates.iter().all(|rate| *rate > 5.0) => turning.push(error),
            () if rates.iter().all(|rate| *rate < 2.0) => straight.push(error),
            () => {}
        }
    }
    println!("{} plots in turns, {} on straight legs", turning.len(), straight.len());
    between("straight, degrees", 2.7, deviation(&straight), 3.3);
    between("in turns / straight", 1.5, deviation(&turning) / deviation(&straight), 1.9);
}
