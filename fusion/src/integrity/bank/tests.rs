//! The bank on constructed flights, and its filter compared with the joint density of all observations.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use proptest::prelude::*;

use super::hypothesis::{AxisRow, ElapsedTime, Hypothesis};
use super::{HypothesisBank, PersistentErrors, StampDelay, TrackObservation, radius_95_m};
use crate::report::SensorIndex;
use crate::time::Time;

const DELAY: StampDelay = StampDelay { mean_s: 0.0, sigma_s: 0.08 };
const SLOW: PersistentErrors = PersistentErrors { range_m: 4.0, azimuth: 0.02, lasts_s: 20.0 };
const ALIGNMENT: [f64; 2] = [1.5, 0.004];

fn at(second: f64) -> Time {
    Time::from_nanos((second * 1e9) as i64)
}

/// An observation at 1.5 km, in a slowly turning direction, of an aircraft that flies past.
fn look(second: f64, track: u64, offset_m: [f64; 2], turned: f64) -> TrackObservation {
    let azimuth = turned + 0.01 * second;
    let outward = Vector2::new(azimuth.sin(), azimuth.cos());
    TrackObservation {
        time: at(second),
        radar: SensorIndex(0),
        track: (Time::from_nanos(track as i64), 1),
        offset_m,
        white_m2: [1.0, 9.0],
        axes: [outward, Vector2::new(outward.y, -outward.x)],
        range_m: 1500.0,
        velocity: Vector2::new(12.0 * turned.cos(), -12.0 * turned.sin()),
        slow: SLOW,
        alignment: ALIGNMENT,
    }
}

/// Log-likelihood of an observation of another aircraft that is anywhere within a few tens of metres.
const OTHER: f64 = -8.0;
/// Log-likelihood of an observation of another aircraft that flies alike: about the density that a hypothesis expects.
const AS_LIKELY: f64 = -3.5;

/// Offsets of an honest transponder, caused by a radar's persistent error.
fn honest(second: f64) -> [f64; 2] {
    [3.0 * (second / 15.0).sin(), 25.0 * (second / 18.0).cos()]
}

/// The index after a minute of observations, with a new track every 20 s.
fn index(offset_m: impl Fn(f64) -> [f64; 2], turned: f64) -> (f64, HypothesisBank) {
    let mut bank = HypothesisBank::new(at(0.0), DELAY);
    for second in 0..60 {
        let second = f64::from(second);
        bank.observe(&look(second, 1 + (second / 20.0) as u64, offset_m(second), turned), 0.9, OTHER);
    }
    (bank.index(), bank)
}

#[test]
fn an_honest_row_is_the_density_of_all_its_looks() {
    let offsets: Vec<[f64; 2]> = (0..12).map(|second| honest(f64::from(second) * 1.7)).collect();
    let looks: Vec<TrackObservation> =
        offsets.iter().zip(0..).map(|(&offset, i)| look(f64::from(i) * 1.7, 1, offset, 0.4)).collect();
    let mut row = Hypothesis::honest(looks[0].time, DELAY);
    row.reset_radar(&looks[0]);
    row.reset_track(&looks[0]);
    let mut filtered = 0.0;
    for look in &looks {
        ElapsedTime::between(row.at, look.time, SLOW).iter().for_each(|passage| row.predict(passage));
        let sights = AxisRow::of_look(look);
        filtered += row.observe(look, &sights, 0) + row.observe(look, &sights, 1);
    }
    // Reference from the joint covariance of all observations, which decays exponentially with the time between them.
    let all: Vec<(&TrackObservation, usize)> = looks.iter().flat_map(|look| [(look, 0), (look, 1)]).collect();
    let covariance = DMatrix::from_fn(all.len(), all.len(), |one, other| {
        let ((a, i), (b, j)) = (all[one], all[other]);
        let dt = a.time.seconds_since(b.time).abs();
        let receiver = a.axes[i].dot(&b.axes[j]) * 2.2 * 2.2 * (-dt / 60.0).exp();
        let late = a.axes[i].dot(&a.velocity) * b.axes[j].dot(&b.velocity) * 0.08 * 0.08;
        let arm = |axis: usize| [1.0, 1500.0][axis];
        let slow = [SLOW.range_m, SLOW.azimuth][i].powi(2) * (-dt / SLOW.lasts_s).exp();
        let radar = if i == j { arm(i) * arm(j) * (slow + ALIGNMENT[i].powi(2)) } else { 0.0 };
        let white = if one == other { a.white_m2[i] } else { 0.0 };
        receiver + late + radar + white
    });
    let seen = DVector::from_iterator(all.len(), all.iter().map(|(look, axis)| look.offset_m[*axis]));
    let determinant = covariance.determinant().ln();
    let solved = covariance.lu().solve(&seen).unwrap();
    let count = all.len() as f64;
    let at_once = -0.5 * (seen.dot(&solved) + determinant + count * std::f64::consts::TAU.ln());
    assert!((filtered - at_once).abs() < 1e-6, "{filtered} {at_once}");
}

#[test]
fn a_drift_shows_and_an_honest_receiver_does_not() {
    let (clean, _) = index(honest, 0.0);
    assert!(clean < 1.0, "{clean}");
    let drift = |second: f64| {
        let off_m = 1.67 * (second - 10.0).max(0.0);
        [honest(second)[0] - off_m, honest(second)[1]]
    };
    let (lies, bank) = index(drift, 0.0);
    assert!(lies > 9.0, "{lies}");
    // The transponder is further out by as much as the radar sees it nearer.
    let (offset, covariance) = bank.offset(at(59.0)).unwrap();
    assert!((offset.norm() - 82.0).abs() < 20.0 && offset.y > 0.0, "{offset} {covariance}");
}

#[test]
fn track_that_walks_off_and_ends_is_no_attack() {
    let mut bank = HypothesisBank::new(at(0.0), DELAY);
    for second in 0..20 {
        let second = f64::from(second);
        let off_m = 6.0 * (second - 11.0).max(0.0);
        bank.observe(&look(second, 1, [honest(second)[0] + off_m, honest(second)[1]], 0.0), 0.9, OTHER);
    }
    for second in 25..40 {
        let second = f64::from(second);
        bank.observe(&look(second, 2, honest(second), 0.0), 0.9, OTHER);
    }
    assert!(bank.index() < 2.0, "{}", bank.index());
}

#[test]
fn likely_other_aircraft_lowers_honesty_by_at_most_the_odds() {
    let mut bank = HypothesisBank::new(at(0.0), DELAY);
    for second in 0..20 {
        // At 140 m this is not the aircraft if the transponder is honest.
        bank.observe(&look(f64::from(second), 1, [140.0, 0.0], 0.0), 0.35, AS_LIKELY);
    }
    assert!(bank.index() < 8.5, "{}", bank.index());
}

/// Another aircraft with two radar tracks counts as evidence only once.
#[test]
fn aircraft_is_explained_by_one_transponder_only() {
    let index = |go_on: bool| {
        let mut bank = HypothesisBank::new(at(0.0), DELAY);
        for second in 0..40_u32 {
            let look = look(f64::from(second), 1 + u64::from(second / 20), [60.0, 0.0], 0.0);
            match second == 20 && go_on {
                true => bank.observe_continuation(&look, -9.0),
                false => bank.observe(&look, 0.35, -9.0),
            }
        }
        bank.index()
    };
    let (once, twice) = (index(true), index(false));
    assert!(once + 1.0 < twice, "{once} {twice}");
}

#[test]
fn late_stamps_are_distinguished_from_an_offset() {
    let mut bank = HypothesisBank::new(at(0.0), DELAY);
    for second in 0..60 {
        let mut look = look(f64::from(second), 1 + (second / 20) as u64, [0.0, 0.0], 0.0);
        // It flies to and fro, and its stamps are 2 s late.
        let speed = if (second / 15) % 2 == 0 { 14.0 } else { -14.0 };
        look.velocity = Vector2::new(0.0, speed);
        let late_s = if second < 15 { 0.0 } else { 2.0 };
        look.offset_m = [0, 1].map(|axis| look.axes[axis].dot(&look.velocity) * late_s);
        bank.observe(&look, 0.9, OTHER);
    }
    let late = bank.late_index().unwrap();
    assert!(late > 9.0 && late > bank.index(), "{late} {}", bank.index());
}

#[test]
fn any_attack_could_hide_without_radar_observations() {
    let bank = HypothesisBank::new(at(0.0), DELAY);
    assert_eq!((bank.protection_level_m(at(1.0)), bank.late_index(), bank.index()), (None, None, 0.0));
}

/// A false position may have begun before the first observation. Observations tighten its bound, which never exceeds
/// the first; after a long time without observations it is as at first.
#[test]
fn hidden_attack_may_begin_before_the_first_observation() {
    let mut bank = HypothesisBank::new(at(0.0), DELAY);
    let level_m = |bank: &mut HypothesisBank, second: u32, track| {
        bank.observe(&look(f64::from(second), track, [0.0, 0.0], 0.0), 0.9, OTHER);
        bank.protection_level_m(at(f64::from(second))).unwrap()
    };
    // A persistent error of 0.02 at 1.5 km is 30 m to either side.
    let first = level_m(&mut bank, 0, 1);
    assert!((58.0..63.0).contains(&first), "{first}");
    let mut then = first;
    for second in 1..90 {
        let now = level_m(&mut bank, second, 1);
        assert!(now < then + 1.5 && now < first + 0.5, "{second} {now} {then} {first}");
        then = now;
    }
    for rest in [61, 100, 149, 151, 400] {
        let mut bank = bank.clone();
        let again = level_m(&mut bank, 89 + rest, 2);
        assert!((0.9 * first..1.1 * first).contains(&again), "{rest} {again} {first}");
        for second in 1..90 {
            let later = level_m(&mut bank, 89 + rest + second, 2);
            assert!(later > 0.9 * then, "{rest} {second} {later} {then}");
        }
    }
}

#[test]
fn a_track_agrees_that_is_the_aircrafts_own_if_it_is_honest() {
    let agrees = |offset_m: f64| {
        let mut bank = HypothesisBank::new(at(0.0), DELAY);
        assert!(!bank.agrees());
        (0..20)
            .for_each(|second| bank.observe(&look(f64::from(second), 1, [3.0, offset_m], 0.0), 0.7, OTHER));
        bank.agrees()
    };
    assert_eq!([20.0, 300.0].map(agrees), [true, false]);
}

/// Probability that a normal variable lies within a radius of the origin, integrated over the angle x = r sin t.
fn within(radius_m: f64, mean: &Vector2<f64>, sigmas_m: [f64; 2]) -> f64 {
    let below = |deviations: f64| 0.5 * libm::erfc(-deviations / std::f64::consts::SQRT_2);
    let step = std::f64::consts::PI / 2000.0;
    (0..2000)
        .map(|index| {
            let angle = (f64::from(index) + 0.5) * step - std::f64::consts::FRAC_PI_2;
            let (x, half) = (radius_m * angle.sin(), radius_m * angle.cos());
            let along = (x - mean.x) / sigmas_m[0];
            let density = (-0.5 * along * along).exp() / (sigmas_m[0] * std::f64::consts::TAU.sqrt());
            density
                * (below((half - mean.y) / sigmas_m[1]) - below((-half - mean.y) / sigmas_m[1]))
                * half
                * step
        })
        .sum()
}

proptest! {
    #[test]
    fn the_radius_holds_95_of_100(
        long_m in 1.0..200.0_f64,
        share in 0.05..1.0_f64,
        away in 0.0..6.0_f64,
        (from, turned) in (0.0..6.3_f64, 0.0..3.2_f64),
    ) {
        let sigmas_m = [long_m, share * long_m];
        let mean = Vector2::new(from.sin(), from.cos()) * (away * long_m);
        let covariance = Matrix2::new(sigmas_m[0].powi(2), 0.0, 0.0, sigmas_m[1].powi(2));
        let radius_m = radius_95_m(&mean, &covariance);
        let held = within(radius_m, &mean, sigmas_m);
        prop_assert!((0.944..0.957).contains(&held), "{held}");
        // Independent of the orientation.
        let turn = nalgebra::Rotation2::new(turned).into_inner();
        let other = radius_95_m(&(turn * mean), &(turn * covariance * turn.transpose()));
        prop_assert!((other / radius_m - 1.0).abs() < 1e-9);
    }
}

proptest! {
    /// The index is independent of the direction of north.
    #[test]
    fn the_index_is_the_same_however_the_site_is_turned(turned in 0.0..6.0, drift_m_s in 0.0..3.0_f64) {
        let offset = |second: f64| [honest(second)[0] - drift_m_s * (second - 10.0).max(0.0), honest(second)[1]];
        let (plain, _) = index(offset, 0.0);
        let (other, _) = index(offset, turned);
        prop_assert!((plain - other).abs() < 1e-6, "{plain} {other}");
    }
}
