//! Learning of a simulated radar with known errors.

use nalgebra::Vector2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::axis::AXES;
use super::model::{change_variance, mean_variance};
use super::pyramid::{OffsetSample, Pyramid};
use super::range_rate::{RangeRate, RatePlot};
use super::sizes::SizeHistogram;
use super::*;
use crate::filter::RadarErrors;
use crate::time::Time;

fn at(second: f64) -> Time {
    Time::from_nanos((second * 1e9).round() as i64)
}

fn sheet() -> RadarErrors {
    RadarErrors::of_data_sheet(5.0, 1.0, 10.0)
}

/// Drones that fly straight on, one after another, for 30 s each, with four plots a second and transponders without
/// errors.
struct World {
    random: ChaCha8Rng,
    now_s: f64,
    /// Standard deviations of bias and noise in range (metres), azimuth (milliradians), height (metres); correlation
    /// time, seconds.
    bias: [f64; AXES],
    noise: [f64; AXES],
    correlation_s: f64,
    /// Standard deviation of the radar's velocities, m/s; `None`: it reports none.
    velocity_m_s: Option<f64>,
}

impl World {
    /// A radar with `scale` times the usual errors.
    fn new(scale: f64, correlation_s: f64, seed: u64) -> Self {
        let [bias, noise] = [[4.0, 22.0, 8.0], [2.5, 3.1, 3.3]].map(|axes| axes.map(|sigma| scale * sigma));
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self { random, now_s: 1000.0, bias, noise, correlation_s, velocity_m_s: None }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn track(&mut self, learning: &mut RadarLearning) {
        let mut track = TrackLearning::new(20.0);
        let mut bias = self.bias.map(|sigma| sigma * self.normal());
        let kept = (-0.25 / self.correlation_s).exp();
        let velocity = Vector2::new(9.0, 5.0);
        for plot in 0..120 {
            let time = at(self.now_s + 0.25 * f64::from(plot));
            let offsets = std::array::from_fn(|axis| {
                bias[axis] = kept * bias[axis] + (1.0 - kept * kept).sqrt() * self.bias[axis] * self.normal();
                Some(bias[axis] + self.noise[axis] * self.normal())
            });
            let reported_velocity = self
                .velocity_m_s
                .map(|sigma| velocity + Vector2::new(sigma * self.normal(), sigma * self.normal()));
            let nothing = [0.0; AXES];
            let (slow, curve, constant) = (nothing, nothing, nothing);
            track.add(&ComparedPlot { time, offsets, slow, curve, constant, velocity, reported_velocity });
        }
        self.now_s += 40.0;
        learning.add_evidence(&mut track, at(self.now_s - 10.0));
    }

    fn learning(&mut self, tracks: usize) -> RadarLearning {
        let mut learning = RadarLearning::default();
        (0..tracks).for_each(|_| self.track(&mut learning));
        learning
    }
}

#[test]
fn without_evidence_a_radar_is_as_its_data_sheet_says() {
    let learnt = RadarLearning::default().learnt(&sheet());
    let (errors, sheet) = (learnt.errors, sheet());
    for (learnt, sheet) in [
        (errors.bias_range_m, sheet.bias_range_m),
        (errors.bias_azimuth, sheet.bias_azimuth),
        (errors.bias_height_m, sheet.bias_height_m),
        (errors.noise_range_m, sheet.noise_range_m),
        (errors.noise_azimuth, sheet.noise_azimuth),
        (errors.noise_height_m, sheet.noise_height_m),
        (errors.correlation_s, sheet.correlation_s),
    ] {
        assert!((learnt / sheet - 1.0).abs() < 1e-12, "{learnt} {sheet}");
    }
    assert!((learnt.unsure - 1.0).abs() < 1e-12);
    assert_eq!((learnt.velocity, learnt.azimuth.tracks), (VelocityVerdict::Unknown, 0.0));
}

/// Mean squared errors of the learnt values in their stated deviations, as logarithms: bias, correlation time, noise.
fn squares(scale: f64, correlation_s: f64, tracks: usize) -> [f64; 3] {
    const RUNS: u64 = 30;
    let mut sums = [0.0; 3];
    for seed in 0..RUNS {
        let mut world = World::new(scale, correlation_s, seed);
        let mut learning = world.learning(tracks);
        let LearntRadar { range_m, .. } = learning.learnt(&sheet());
        for (sum, (learnt, truth)) in sums.iter_mut().zip([
            (range_m.bias, world.bias[0]),
            (range_m.correlation_s, correlation_s),
            (range_m.noise, world.noise[0]),
        ]) {
            let unsure = learnt.deviation / learnt.value;
            *sum += ((learnt.value / truth).ln() / unsure).powi(2) / RUNS as f64;
        }
    }
    println!("{scale} {correlation_s} {tracks}: {sums:.2?}");
    sums
}

#[test]
fn learnt_values_are_within_their_deviations() {
    for scale in [0.1, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0] {
        for square in squares(scale, 20.0, 40) {
            assert!(square < 1.6, "{scale}: {square}");
        }
    }
    for correlation_s in [5.0, 60.0] {
        for square in squares(1.0, correlation_s, 40) {
            assert!(square < 2.0, "{correlation_s} s: {square}");
        }
    }
}

#[test]
fn more_tracks_reduce_the_variance() {
    let deviation = |tracks| {
        let learnt = World::new(0.4, 20.0, 1).learning(tracks).learnt(&sheet());
        let share = learnt.range_m.of_data_sheet;
        (share.value, share.deviation / share.value)
    };
    let [(_, few), (_, some), (value, many)] = [2, 10, 60].map(deviation);
    assert!(few > some && some > many && many < 0.12, "{few} {some} {many}");
    // With a data sheet of 5 m: bias of 1.6 m and noise of 1 m.
    let truth = 1.6_f64.hypot(1.0) / 4.5_f64.hypot(2.0);
    assert!((value / truth - 1.0).abs() < 0.25, "{value} {truth}");
}

#[test]
fn a_radar_that_changes_is_learnt_anew_within_hours() {
    let mut world = World::new(0.3, 20.0, 4);
    let mut learning = world.learning(200);
    assert!(learning.learnt(&sheet()).range_m.of_data_sheet.value < 0.5);
    (world.bias, world.noise) = (world.bias.map(|sigma| 5.0 * sigma), world.noise.map(|sigma| 5.0 * sigma));
    (0..270).for_each(|_| world.track(&mut learning));
    let share = learning.learnt(&sheet()).range_m.of_data_sheet.value;
    assert!((1.0..1.7).contains(&share), "{share}");
    // A pause of days forgets almost nothing.
    world.now_s += 1e6;
    let before = learning.learnt(&sheet()).range_m.tracks;
    world.track(&mut learning);
    assert!(learning.learnt(&sheet()).range_m.tracks > 0.97 * before);
}

/// Reference for the closed forms: dense covariances of up to 30 samples.
#[test]
fn mean_and_change_variances_match_dense_covariances() {
    for (spacing_s, correlation_s) in [(0.25, 20.0), (4.0, 5.0), (0.1, 600.0)] {
        for count in [1_i32, 2, 8, 15] {
            let covariance = |a: i32, b: i32| (-f64::from((a - b).abs()) * spacing_s / correlation_s).exp();
            let weight = |index: i32| f64::from(if index < count { -1 } else { 1 }) / f64::from(count);
            let dense = |from: i32, to: i32, weight: &dyn Fn(i32) -> f64| -> f64 {
                let all = (from..to).flat_map(|a| (from..to).map(move |b| (a, b)));
                all.map(|(a, b)| weight(a) * weight(b) * covariance(a, b)).sum()
            };
            let mean = dense(0, count, &weight);
            let change = dense(0, 2 * count, &weight);
            let own = f64::from(count);
            assert!((mean_variance(own, spacing_s, correlation_s) / mean - 1.0).abs() < 1e-9);
            assert!((change_variance(own, spacing_s, correlation_s) / change - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn pyramid_yields_each_change_of_means_once() {
    let mut pyramid = Pyramid::default();
    let mut found = Vec::new();
    for (index, offset) in [1.0, 3.0, 2.0, 8.0, 0.0, 0.0, 4.0].into_iter().enumerate() {
        let sample = OffsetSample { time: at(index as f64), offset, slow: 0.0, curve: 0.0 };
        pyramid.add(&sample, |change| found.push((change.level, change.size, change.spacing_s)));
    }
    assert_eq!(found, [(0, 2.0, 1.0), (0, 6.0, 1.0), (1, 3.0, 1.0), (0, 0.0, 1.0)]);
}

#[test]
fn few_outliers_hardly_count() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut sizes = SizeHistogram::NONE;
    for _ in 0..5000 {
        let number: f64 = StandardNormal.sample(&mut random);
        sizes.add(7.0 * number);
    }
    let clean = sizes.variance().unwrap().sqrt();
    assert!((clean / 7.0 - 1.0).abs() < 0.03, "{clean}");
    (0..150).for_each(|_| sizes.add(210.0));
    let soiled = sizes.variance().unwrap().sqrt();
    assert!(soiled < 1.15 * clean, "{soiled}");
    assert_eq!(SizeHistogram::NONE.variance(), None);
}

#[test]
fn velocities_are_judged_by_transponders() {
    let verdict = |sigma, tracks| {
        let mut world = World::new(1.0, 20.0, 3);
        world.velocity_m_s = sigma;
        world.learning(tracks).learnt(&sheet()).velocity
    };
    assert_eq!(verdict(None, 20), VelocityVerdict::Unknown);
    assert_eq!(verdict(Some(1.0), 0), VelocityVerdict::Unknown);
    let VelocityVerdict::Used(errors) = verdict(Some(1.5), 20) else { panic!("not used") };
    assert!((errors.sigma_m_s - 1.5).abs() < 4.0 * errors.deviation_m_s, "{errors:?}");
    let VelocityVerdict::Ignored(errors) = verdict(Some(9.0), 3) else { panic!("not ignored") };
    assert!((errors.sigma_m_s - 9.0).abs() < 4.0 * errors.deviation_m_s, "{errors:?}");
}

/// A drone without a transponder flies away at 12 m/s.
#[test]
fn velocities_are_judged_by_plots_where_no_transponder_tells() {
    let verdict = |reported_m_s: f64| {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let mut learning = RadarLearning::default();
        let mut rate = RangeRate::default();
        assert!(learning.asks_for_rates());
        for plot in 0..160 {
            let second = 0.25 * f64::from(plot);
            let noise: f64 = StandardNormal.sample(&mut random);
            let seen =
                RatePlot { time: at(second), range_m: 900.0 + 12.0 * second + 2.0 * noise, reported_m_s };
            if let Some(off) = rate.add(seen, &sheet()) {
                learning.take_rate(&off);
            }
        }
        learning.learnt(&sheet()).velocity
    };
    assert!(matches!(verdict(12.0), VelocityVerdict::Used(errors) if errors.sigma_m_s < 1.5));
    assert!(matches!(verdict(-3.0), VelocityVerdict::Ignored(errors) if errors.sigma_m_s > 9.0));
}

/// A circle of 20 s, then straight on: evidence from turns is separated.
#[test]
fn turns_are_learnt_separately() {
    let mut world = World::new(1.0, 20.0, 6);
    let mut learning = RadarLearning::default();
    for _ in 0..120 {
        let mut track = TrackLearning::new(20.0);
        let mut bias = world.bias.map(|sigma| sigma * world.normal());
        let kept = (-0.25_f64 / 20.0).exp();
        for plot in 0..160 {
            let second = 0.25 * f64::from(plot);
            let course = if second < 20.0 { 0.3 * second } else { 6.0 };
            let factor = if second < 20.0 { 2.0 } else { 1.0 };
            let offsets = std::array::from_fn(|axis| {
                let change = (1.0 - kept * kept).sqrt() * world.bias[axis];
                bias[axis] = kept * bias[axis] + change * world.normal();
                Some(factor * bias[axis] + world.noise[axis] * world.normal())
            });
            let (slow, curve, constant) = ([0.0; AXES], [0.0; AXES], [0.0; AXES]);
            let velocity = Vector2::new(12.0 * f64::sin(course), 12.0 * f64::cos(course));
            let time = at(world.now_s + second);
            track.add(&ComparedPlot {
                time,
                offsets,
                slow,
                curve,
                constant,
                velocity,
                reported_velocity: None,
            });
        }
        world.now_s += 45.0;
        learning.add_evidence(&mut track, at(world.now_s));
    }
    let learnt = learning.learnt(&sheet());
    for axis in [learnt.range_m, learnt.azimuth, learnt.height_m] {
        assert!((1.4..2.4).contains(&axis.turn_factor.value), "{axis:?}");
    }
}

#[test]
fn saved_state_is_restored_bit_for_bit() {
    for tracks in [0, 1, 30] {
        let mut world = World::new(0.6, 20.0, 5);
        world.velocity_m_s = Some(2.0);
        let mut learning = world.learning(tracks);
        let text = serde_json::to_string(&learning.to_state()).unwrap();
        let state: LearningState = serde_json::from_str(&text).unwrap();
        assert_eq!(state, learning.to_state());
        let mut again = RadarLearning::from_state(&state).unwrap();
        assert_eq!(serde_json::to_string(&again.to_state()).unwrap(), text);
        // Both continue alike.
        let mut other = World { random: world.random.clone(), ..world };
        world.random = other.random.clone();
        for _ in 0..3 {
            world.track(&mut learning);
            other.track(&mut again);
        }
        assert_eq!(again.to_state(), learning.to_state());
        println!("{tracks} tracks: {} octets", text.len());
    }
}

#[test]
fn invalid_state_is_refused() {
    let text = serde_json::to_string(&World::new(1.0, 20.0, 2).learning(3).to_state()).unwrap();
    let read = |text: &str| {
        let state: LearningState = serde_json::from_str(text).map_err(|error| error.to_string())?;
        state.check().map_err(|error| error.to_string())
    };
    assert_eq!(read(&text), Ok(()));
    let later = text.replacen("\"version\":1", "\"version\":2", 1);
    assert_eq!(read(&later).unwrap_err(), LearningStateError::Version(2).to_string());
    assert!(read(&text.replacen("\"now\"", "\"then\"", 1)).is_err());
    let plots = text.find("\"plots\":\"").unwrap() + 9;
    let end = plots + text[plots..].find('"').unwrap();
    for bad in ["", "1.0", "1.0 inf", "1.0 NaN", "1.0 -1.0", "1.0 1e300", "1.0 two"] {
        let bad = format!("{}{bad}{}", &text[..plots], &text[end..]);
        assert!(read(&bad).is_err(), "{bad}");
    }
    let first = text.find("\"straight\":\"").unwrap() + 12;
    let end = first + text[first..].find('"').unwrap();
    for bad in [
        "",
        "1.0 1.0 1.0 1.0 1.0",
        "1.0 1.0 1.0 1.0 1.0 0.0 0.5",
        "0.0 1.0 1.0 1.0 1.0 0.0",
        "1.0 1.0 1.0 1.0 1.0 56.0 1.0",
        "1.0 1.0 1.0 1.0 1.0 1e11 1.0",
        "1e-300 1.0 1.0 1.0 1.0 3.0 1e-300",
        "1.0 -1.0 1.0 1.0 1.0 3.0 1.0",
    ] {
        let bad = format!("{}{bad}{}", &text[..first], &text[end..]);
        assert!(read(&bad).is_err(), "{bad}");
    }
}

/// Any numbers that pass as a state give errors that a filter can use.
#[test]
fn nothing_that_is_accepted_makes_errors_that_are_no_errors() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let text = serde_json::to_string(&World::new(1.0, 20.0, 2).learning(3).to_state()).unwrap();
    let octets = ["0", "9", "e", ".", " ", "-"];
    let mut accepted = 0;
    for _ in 0..3000 {
        let mut hurt = text.clone();
        let place = rand::RngExt::random_range(&mut random, 0..hurt.len());
        let with = octets[rand::RngExt::random_range(&mut random, 0..octets.len())];
        hurt.replace_range(place..=place, with);
        let Ok(state) = serde_json::from_str::<LearningState>(&hurt) else { continue };
        let Ok(mut learning) = RadarLearning::from_state(&state) else { continue };
        accepted += 1;
        let RadarErrors { bias_range_m, bias_azimuth, noise_range_m, noise_azimuth, correlation_s, .. } =
            learning.learnt(&sheet()).errors;
        for error in [bias_range_m, bias_azimuth, noise_range_m, noise_azimuth, correlation_s] {
            assert!(error.is_finite() && error > 0.0, "{hurt}");
        }
    }
    assert!(accepted > 100, "{accepted}");
}
