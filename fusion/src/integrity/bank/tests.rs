//! The bank on flights that are written down, and its filter against the density of all looks at once.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use proptest::prelude::*;

use super::row::{Passage, Row, Sight};
use super::{Bank, Delay, Look, Slow, radius_95_m};
use crate::report::SensorIndex;
use crate::time::Time;

const DELAY: Delay = Delay { mean_s: 0.0, sigma_s: 0.08 };
const SLOW: Slow = Slow { range_m: 4.0, azimuth: 0.02, lasts_s: 20.0 };
const ALIGNMENT: [f64; 2] = [1.5, 0.004];

fn at(second: f64) -> Time {
    Time::from_nanos((second * 1e9) as i64)
}

/// A look at 1.5 km, in a direction that turns slowly, at an aircraft that flies past.
fn look(second: f64, track: u64, offset_m: [f64; 2], turned: f64) -> Look {
    let azimuth = turned + 0.01 * second;
    let outward = Vector2::new(azimuth.sin(), azimuth.cos());
    Look {
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

/// Log-likelihood of a look of another aircraft: as of one that is anywhere within a few tens of metres.
const OTHER: f64 = -8.0;
/// The same of one that flies just so: about the density of a look that a row expects.
const AS_LIKELY: f64 = -3.5;

/// Offsets of an honest transponder: what a radar's slow error makes of them.
fn honest(second: f64) -> [f64; 2] {
    [3.0 * (second / 15.0).sin(), 25.0 * (second / 18.0).cos()]
}

/// The index after a minute of looks at one track after another, each of 20 s.
fn index(offset_m: impl Fn(f64) -> [f64; 2], turned: f64) -> (f64, Bank) {
    let mut bank = Bank::new(at(0.0), DELAY);
    for second in 0..60 {
        let second = f64::from(second);
        bank.take(&look(second, 1 + (second / 20.0) as u64, offset_m(second), turned), 0.9, OTHER);
    }
    (bank.index(), bank)
}

#[test]
fn an_honest_row_is_the_density_of_all_its_looks() {
    let offsets: Vec<[f64; 2]> = (0..12).map(|second| honest(f64::from(second) * 1.7)).collect();
    let looks: Vec<Look> =
        offsets.iter().zip(0..).map(|(&offset, i)| look(f64::from(i) * 1.7, 1, offset, 0.4)).collect();
    let mut row = Row::honest(looks[0].time, DELAY);
    row.meet_radar(&looks[0]);
    row.meet_track(&looks[0]);
    let mut filtered = 0.0;
    for look in &looks {
        Passage::between(row.at, look.time, SLOW).iter().for_each(|passage| row.turn(passage));
        let sights = Sight::of_look(look);
        filtered += row.observe(look, &sights, 0) + row.observe(look, &sights, 1);
    }
    // The same from the covariance of every look with every other: exponentials of the time between them.
    let all: Vec<(&Look, usize)> = looks.iter().flat_map(|look| [(look, 0), (look, 1)]).collect();
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
    // The transponder is further out by what the radar sees it nearer.
    let (offset, covariance) = bank.offset(at(59.0)).unwrap();
    assert!((offset.norm() - 82.0).abs() < 20.0 && offset.y > 0.0, "{offset} {covariance}");
}

#[test]
fn one_track_that_walks_off_and_ends_is_no_lie() {
    let mut bank = Bank::new(at(0.0), DELAY);
    for second in 0..20 {
        let second = f64::from(second);
        let off_m = 6.0 * (second - 11.0).max(0.0);
        bank.take(&look(second, 1, [honest(second)[0] + off_m, honest(second)[1]], 0.0), 0.9, OTHER);
    }
    for second in 25..40 {
        let second = f64::from(second);
        bank.take(&look(second, 2, honest(second), 0.0), 0.9, OTHER);
    }
    assert!(bank.index() < 2.0, "{}", bank.index());
}

#[test]
fn what_is_likelier_another_aircraft_costs_honesty_no_more_than_the_odds() {
    let mut bank = Bank::new(at(0.0), DELAY);
    for second in 0..20 {
        // 140 m away: by the row that it is honest this is not the aircraft.
        bank.take(&look(f64::from(second), 1, [140.0, 0.0], 0.0), 0.35, AS_LIKELY);
    }
    assert!(bank.index() < 8.5, "{}", bank.index());
}

/// Another aircraft that is seen as two radar tracks is no twofold evidence.
#[test]
fn whose_an_aircraft_is_is_asked_once() {
    let index = |go_on: bool| {
        let mut bank = Bank::new(at(0.0), DELAY);
        for second in 0..40_u32 {
            let look = look(f64::from(second), 1 + u64::from(second / 20), [60.0, 0.0], 0.0);
            match second == 20 && go_on {
                true => bank.go_on(&look, -9.0),
                false => bank.take(&look, 0.35, -9.0),
            }
        }
        bank.index()
    };
    let (once, twice) = (index(true), index(false));
    assert!(once + 1.0 < twice, "{once} {twice}");
}

#[test]
fn late_stamps_are_told_from_a_place_that_is_off() {
    let mut bank = Bank::new(at(0.0), DELAY);
    for second in 0..60 {
        let mut look = look(f64::from(second), 1 + (second / 20) as u64, [0.0, 0.0], 0.0);
        // It flies to and fro, and is 2 s behind.
        let speed = if (second / 15) % 2 == 0 { 14.0 } else { -14.0 };
        look.velocity = Vector2::new(0.0, speed);
        let late_s = if second < 15 { 0.0 } else { 2.0 };
        look.offset_m = [0, 1].map(|axis| look.axes[axis].dot(&look.velocity) * late_s);
        bank.take(&look, 0.9, OTHER);
    }
    let late = bank.late_index().unwrap();
    assert!(late > 9.0 && late > bank.index(), "{late} {}", bank.index());
}

#[test]
fn without_a_look_any_lie_could_hide() {
    let bank = Bank::new(at(0.0), DELAY);
    assert_eq!((bank.protection_level_m(at(1.0)), bank.late_index(), bank.index()), (None, None, 0.0));
}

/// A lie may have begun before anybody looked: looks bound it better and better, and no worse than the first; once nobody has
/// looked for long it is as at first.
#[test]
fn what_could_hide_begins_before_anybody_looked() {
    let mut bank = Bank::new(at(0.0), DELAY);
    let level_m = |bank: &mut Bank, second: u32, track| {
        bank.take(&look(f64::from(second), track, [0.0, 0.0], 0.0), 0.9, OTHER);
        bank.protection_level_m(at(f64::from(second))).unwrap()
    };
    // A slow error of 0.02 at 1.5 km is 30 m, to both sides.
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
        let mut bank = Bank::new(at(0.0), DELAY);
        assert!(!bank.agrees());
        (0..20).for_each(|second| bank.take(&look(f64::from(second), 1, [3.0, offset_m], 0.0), 0.7, OTHER));
        bank.agrees()
    };
    assert_eq!([20.0, 300.0].map(agrees), [true, false]);
}

/// Probability that a normal variable is nearer to nothing than a radius: over the angle x = r sin t.
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
        // Whichever way it lies.
        let turn = nalgebra::Rotation2::new(turned).into_inner();
        let other = radius_95_m(&(turn * mean), &(turn * covariance * turn.transpose()));
        prop_assert!((other / radius_m - 1.0).abs() < 1e-9);
    }
}

proptest! {
    /// Where north is does not matter.
    #[test]
    fn the_index_is_the_same_however_the_site_is_turned(turned in 0.0..6.0, drift_m_s in 0.0..3.0_f64) {
        let offset = |second: f64| [honest(second)[0] - drift_m_s * (second - 10.0).max(0.0), honest(second)[1]];
        let (plain, _) = index(offset, 0.0);
        let (other, _) = index(offset, turned);
        prop_assert!((plain - other).abs() < 1e-6, "{plain} {other}");
    }
}
