//! Compares the recursive filter and smoother with the one-step solution of the same problem: all states at once,
//! conditioned on all measurements, with dense matrices.

use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector2};
use proptest::prelude::*;

use super::bias::{Bias, SlowChange};
use super::errors::{LineOfSight, RadarErrors};
use super::gaussian::{BiasTransition, Gaussian, LinearMotion, PairObservation};
use super::measurement::{By, Measurement, Owner};
use super::motion::{MODELS, Model, Models};
use super::plane::{self, OverGround};
use super::singer::Singer;
use super::symmetric::Symmetric;
use super::target::{Dynamics, TargetFilter};
use crate::frames::Enu;
use crate::report::SensorIndex;
use crate::time::Time;

mod jumps;
mod singer;

const ERRORS: RadarErrors = RadarErrors {
    bias_range_m: 5.0,
    bias_azimuth: 0.02,
    bias_height_m: 8.0,
    noise_range_m: 2.0,
    noise_azimuth: 0.003,
    noise_height_m: 3.0,
    correlation_s: 20.0,
};

/// Identical models: there is nothing to mix, and the filter is a Kalman filter.
fn alike(model: Model) -> Models {
    Models { each: [model; MODELS], ..Models::default() }
}

/// Both kinds of motion models.
fn dynamics() -> [Dynamics; 2] {
    [Dynamics::Imm(Models::default()), Dynamics::Singer(Singer::default())]
}

/// F of a motion.
pub(crate) fn transition_of<const D: usize>(motion: &impl LinearMotion<D>) -> SMatrix<f64, D, D> {
    let mut rows =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(u8::from(row == column))));
    motion.carry::<D>(&mut rows);
    SMatrix::from_fn(|row, column| rows[row][column])
}

/// Q of a motion.
pub(crate) fn noise_of<const D: usize>(motion: &impl LinearMotion<D>) -> SMatrix<f64, D, D> {
    let mut noise = Symmetric::ZERO;
    motion.add_noise(&mut noise);
    dense(&noise)
}

fn dense<const D: usize>(matrix: &Symmetric<D>) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|row, column| matrix.at(row, column))
}

/// A filter with these measurements.
fn tracked(measurements: &[Measurement], dynamics: &Dynamics) -> TargetFilter {
    let mut track = TargetFilter::new(dynamics, 2);
    track.measure(Time::from_nanos(i64::MIN), measurements);
    track
}

fn seconds(at: f64) -> Time {
    Time::from_nanos((at * 1e9).round() as i64)
}

/// Positions of the radars.
const RADARS: [Enu; 2] = [Enu::new(0.0, 0.0, 0.0), Enu::new(2000.0, -300.0, 10.0)];

/// Measurements at increasing times: of a transponder (0) or of a track of one of the radars.
fn measurements(rows: &[(f64, f64, f64, usize)]) -> Vec<Measurement> {
    let mut at = 0.0;
    let measured = |&(later, east, north, by): &(f64, f64, f64, usize)| {
        at += later;
        let position = Enu::new(1000.0 + 10.0 * at + east, 800.0 + north, 50.0);
        let is_transponder = by == 0;
        let by = match by.checked_sub(1) {
            Some(radar) => By::Radar {
                owner: Owner {
                    radar: SensorIndex(radar as u16),
                    tracklet: (Time::default(), 1),
                    since: None,
                },
                known: Bias::of(&ERRORS),
                seen: LineOfSight::from(RADARS[radar], position),
                errors: ERRORS,
            },
            None => By::Transponder { horizontal_m: 1.0, vertical_m: 2.0 },
        };
        // Some of the transponder's reports have a velocity.
        let velocity =
            (is_transponder && east > 0.0).then(|| (Vector2::new(10.0 + 0.5 * north, 0.2 * east), 0.4));
        Measurement { time: seconds(at), position, height_measured: true, by, velocity, climb: None }
    };
    rows.iter().map(measured).collect()
}

/// F, the shift and Q of a whole state: the moving variables, and the biases after them.
fn linear<const D: usize>(
    motion: &impl LinearMotion<D>,
    slow: &BiasTransition<D>,
) -> (SMatrix<f64, D, D>, SVector<f64, D>, SMatrix<f64, D, D>) {
    let predicted = |mean: [f64; D]| {
        SVector::from(Gaussian { mean, covariance: Symmetric::ZERO }.predicted(motion, slow).predicted.mean)
    };
    let shift = predicted([0.0; D]);
    let unit = |index| std::array::from_fn(|at| f64::from(u8::from(at == index)));
    let columns: [SVector<f64, D>; D] = std::array::from_fn(|index| predicted(unit(index)) - shift);
    let still = Gaussian { mean: [0.0; D], covariance: Symmetric::ZERO };
    (SMatrix::from_columns(&columns), shift, dense(&still.predicted(motion, slow).predicted.covariance))
}

/// Position at `time` by conditioning the joint Gaussian of all states, the first of them before any measurement; with
/// the biases of `S` radars, in the order in which they begin.
fn at_once<const STATES: usize, const M: usize, const S: usize>(
    measurements: &[Measurement],
    time: Time,
    models: &impl OverGround<STATES, M>,
) -> (Vector2<f64>, SMatrix<f64, 2, 2>) {
    let mut times: Vec<Time> = measurements.iter().map(|measurement| measurement.time).collect();
    times.push(time);
    times.sort_unstable();
    times.dedup();
    let radar_of = |measurement: &Measurement| match measurement.by {
        By::Radar { owner, .. } => Some(owner.radar),
        By::Transponder { .. } | By::Camera { .. } | By::Height { .. } => None,
    };
    let mut radars: Vec<(SensorIndex, Time)> = Vec::new();
    for measurement in measurements {
        if let Some(radar) = radar_of(measurement)
            && radars.iter().all(|known| known.0 != radar)
        {
            radars.push((radar, measurement.time));
        }
    }
    let first = &measurements[0];
    let mut begin = models.first(first.position.0.xy()).combined();
    let biases = [0; S].map(|_| Bias::NONE);
    plane::begin(&mut begin, &biases);
    if radar_of(first).is_some() {
        let mut biases = biases;
        biases[0] = Bias::of(&ERRORS);
        plane::begin(&mut begin, &biases);
    }
    // Joint mean and covariance of the states, in order.
    let size = STATES * times.len();
    let (mut mean, mut covariance) = (DVector::zeros(size), DMatrix::zeros(size, size));
    mean.rows_mut(0, STATES).copy_from(&SVector::from(begin.mean));
    covariance.view_mut((0, 0), (STATES, STATES)).copy_from(&dense(&begin.covariance));
    for index in 1..times.len() {
        let dt = times[index].seconds_since(times[index - 1]);
        let change = |place: usize| match radars.get(place) {
            Some((_, begins)) if *begins == times[index] => SlowChange::reset(Bias::of(&ERRORS)),
            Some((_, begins)) if *begins < times[index] => SlowChange::after(&ERRORS, dt),
            // The bias of a radar that measures first exists before its measurement.
            Some(_) if place == 0 && radar_of(first).is_some() => SlowChange::after(&ERRORS, dt),
            _ => SlowChange::NONE,
        };
        let changes: [SlowChange; S] = std::array::from_fn(change);
        let (transition, shift, noise) = linear(&models.motions(dt, 0.0)[0], &plane::slow(&changes));
        let (before, here) = (STATES * (index - 1), STATES * index);
        let next = transition * mean.fixed_rows::<STATES>(before) + shift;
        mean.rows_mut(here, STATES).copy_from(&next);
        let across = transition * covariance.view((before, 0), (STATES, here));
        covariance.view_mut((here, 0), (STATES, here)).copy_from(&across);
        covariance.view_mut((0, here), (here, STATES)).copy_from(&across.transpose());
        let own = across.columns(before, STATES) * transition.transpose() + noise;
        covariance.view_mut((here, here), (STATES, STATES)).copy_from(&own);
    }
    let mut observe = |time: Time, observation: &PairObservation| {
        let place = STATES * times.iter().position(|&known| known == time).unwrap();
        let mut matrix = DMatrix::zeros(2, size);
        for (index, row) in observation.rows.iter().enumerate() {
            row.iter().for_each(|&(column, factor)| matrix[(index, place + column)] += factor);
        }
        let [first, both, second] = observation.noise;
        let noise = DMatrix::from_row_slice(2, 2, &[first, both, both, second]);
        let innovation = DVector::from_row_slice(&observation.values) - &matrix * &mean;
        let spread = &matrix * &covariance * matrix.transpose() + noise;
        let gain = &covariance * matrix.transpose() * spread.try_inverse().unwrap();
        mean += &gain * innovation;
        covariance -= &gain * &matrix * &covariance.clone();
    };
    for Measurement { time, position, by, velocity, .. } in measurements {
        match by {
            By::Transponder { horizontal_m, .. } => {
                observe(*time, &plane::fix(position.0.xy(), *horizontal_m));
            }
            By::Radar { owner, seen, errors, .. } => {
                let place = radars.iter().position(|radar| radar.0 == owner.radar).unwrap();
                observe(*time, &plane::plot::<STATES, S>(position.0.xy(), seen, errors, place));
            }
            By::Camera { clockwise, across_m, .. } => {
                observe(*time, &plane::line(position.0.xy(), *clockwise, *across_m));
            }
            By::Height { .. } => {}
        }
        if let Some((velocity, deviation)) = velocity {
            observe(*time, &plane::velocity(*velocity, *deviation));
        }
    }
    let place = STATES * times.iter().position(|&known| known == time).unwrap();
    (mean.fixed_rows::<2>(place).into_owned(), covariance.fixed_view::<2, 2>(place, place).into_owned())
}

fn rows(radars: usize) -> impl Strategy<Value = Vec<(f64, f64, f64, usize)>> {
    // So near to a straight flight that no measurement is an outlier.
    prop::collection::vec((0.1..2.0, -1.5..1.5, -1.5..1.5, 0..=radars), 3..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Before, between and after the measurements, with a radar's bias and without.
    #[test]
    fn filter_and_smoother_are_the_one_step_solution(rows in rows(2), share in 0.0..1.2_f64) {
        let measurements = measurements(&rows);
        let last = measurements.last().unwrap().time;
        let time = seconds(0.1 + share * last.as_seconds());
        let (one, singer) = (alike(Model::ConstantVelocity { noise: 2.0 }), Singer::default());
        for (dynamics, expected) in [
            (Dynamics::Imm(one), at_once::<{ plane::states(2) }, MODELS, 2>(&measurements, time, &one)),
            (
                Dynamics::Singer(singer),
                at_once::<{ plane::states_singer(2) }, 1, 2>(&measurements, time, &singer),
            ),
        ] {
            let estimate = tracked(&measurements, &dynamics).at(time).unwrap();
            let (place, covariance) = expected;
            // The filter assumes the prior speed at the first measurement, and not before it.
            let before = time < measurements[0].time;
            let near_m = if before { 0.2 * covariance.norm().sqrt() } else { 1e-6 };
            let off_m = (estimate.position.0.xy() - place).norm();
            prop_assert!(off_m < near_m, "{} {place}", estimate.position.0);
            let near = if before { 0.2 } else { 1e-6 };
            let off = (estimate.horizontal - covariance).norm() / covariance.norm().max(1.0);
            prop_assert!(off < near, "{} {covariance}", estimate.horizontal);
        }
    }

    /// A late measurement gives the same result, bit for bit, as one in time.
    #[test]
    fn the_order_of_arrival_plays_no_part(rows in rows(2), late in 1..3usize, at in 0.0..1.5_f64) {
        let all = measurements(&rows);
        let held_up = 1 + late % (all.len() - 1);
        let without: Vec<Measurement> =
            all.iter().enumerate().filter(|(index, _)| *index != held_up).map(|(_, m)| *m).collect();
        let time = seconds(at * all.last().unwrap().time.as_seconds());
        for dynamics in dynamics() {
            let mut track = tracked(&without, &dynamics);
            track.measure(all[0].time, &all[1..]);
            prop_assert_eq!(track.at(time), tracked(&all, &dynamics).at(time));
        }
    }

    /// Reports far from the prediction, whose cause only the next reports show.
    #[test]
    fn order_of_arrival_is_irrelevant_to_stops_and_jumps(
        moves in prop::collection::vec((0.5..2.0, prop::sample::select(vec![0.0, 0.0, 0.0, 25.0, -40.0]), 0..=1_usize), 6..20),
        pieces in prop::collection::vec(1..4_usize, 20),
        late in 0..20_usize,
    ) {
        let mut away = 0.0;
        let rows: Vec<_> = moves.iter().map(|&(later, by, radar)| {
            away += by;
            (later, 0.0, away, radar)
        }).collect();
        let all = measurements(&rows);
        let held_up = 1 + late % (all.len() - 1);
        let last = all.last().unwrap().time;
        for dynamics in dynamics() {
            let mut track = TargetFilter::new(&dynamics, 2);
            let mut known = 0;
            for piece in &pieces {
                known = (known + piece).min(all.len());
                let mut so_far: Vec<Measurement> = all[..known].to_vec();
                if known < all.len() && held_up < known {
                    so_far.remove(held_up);
                }
                track.measure(Time::from_nanos(i64::MIN), &so_far);
                let time = so_far.last().unwrap().time;
                prop_assert_eq!(track.at(time), tracked(&so_far, &dynamics).at(time));
            }
            track.measure(Time::from_nanos(i64::MIN), &all);
            for at in [last, all[held_up].time, all[0].time] {
                prop_assert_eq!(track.at(at), tracked(&all, &dynamics).at(at));
            }
        }
    }
}

/// On a circle of 60 m at 15 m/s, its centre at (0, 0, 50): a report every 2.5 s.
const TURN: f64 = 0.25;

fn on_the_circle(at: f64) -> Enu {
    let (sin, cos) = (TURN * at).sin_cos();
    Enu::new(60.0 * cos, 60.0 * sin, 50.0)
}

fn rate_on_the_circle(at: f64) -> Vector2<f64> {
    let (sin, cos) = (TURN * at).sin_cos();
    Vector2::new(-sin, cos) * (60.0 * TURN)
}

fn round(told: impl Fn(f64) -> Option<Vector2<f64>>) -> Vec<Measurement> {
    let measured = |index| {
        let at = 2.5 * f64::from(index);
        let by = By::Transponder { horizontal_m: 0.5, vertical_m: 0.5 };
        let velocity = told(at).map(|velocity| (velocity, 0.3));
        let position = on_the_circle(at);
        Measurement { time: seconds(at), position, height_measured: true, by, velocity, climb: None }
    };
    (0..12).map(measured).collect()
}

/// Mean error over ground between two times, metres.
fn error(measurements: &[Measurement], dynamics: &Dynamics, from: f64, to: f64) -> f64 {
    let track = tracked(measurements, dynamics);
    let count = ((to - from) / 0.25) as u32;
    let sum: f64 = (0..count)
        .map(|slot| {
            let at = from + 0.25 * f64::from(slot) + 0.125;
            (track.at(seconds(at)).unwrap().position.0 - on_the_circle(at).0).xy().norm()
        })
        .sum();
    sum / f64::from(count)
}

/// A turning drone is followed better by models with turns or acceleration than by straight ones alone.
#[test]
fn a_turn_is_followed() {
    let measurements = round(|_| None);
    let straight = Dynamics::Imm(alike(Model::ConstantVelocity { noise: 0.05 }));
    let straight = error(&measurements, &straight, 10.0, 25.0);
    for dynamics in dynamics() {
        let mixed = error(&measurements, &dynamics, 10.0, 25.0);
        assert!(mixed < 0.5 * straight && mixed < 1.0, "{mixed} m, straight on {straight} m, {dynamics:?}");
    }
}

/// Between the reports, and after the last.
#[test]
fn a_velocity_sharpens_a_turn() {
    let (without, with) = (round(|_| None), round(|at| Some(rate_on_the_circle(at))));
    for dynamics in dynamics() {
        for (reports, from, to) in [(12, 10.0, 25.0), (2, 2.5, 5.0)] {
            let [without, with] = [&without, &with].map(|all| error(&all[..reports], &dynamics, from, to));
            assert!(with < 0.7 * without, "{with} m, without velocities {without} m, {from} s, {dynamics:?}");
        }
    }
}

/// The velocity also follows from the positions: one that is wrong by 107 m/s has little effect, and one that is not
/// finite has none.
#[test]
fn a_velocity_that_cannot_be_is_given_little_weight() {
    let once = |wrong| round(move |at| (at == 15.0).then_some(wrong));
    let (without, wrong) = (round(|_| None), once(Vector2::new(90.0, -60.0)));
    for dynamics in dynamics() {
        let of = |measurements| error(measurements, &dynamics, 10.0, 25.0);
        let (without_m, wrong_m) = (of(&without), of(&wrong));
        assert!(wrong_m < without_m + 0.1, "{wrong_m} m, without {without_m} m, {dynamics:?}");
        let none = of(&once(Vector2::new(f64::NAN, 1.0)));
        assert_eq!(none.to_bits(), without_m.to_bits());
    }
}

/// A new target: its velocity and climb are known from its first report.
#[test]
fn target_with_reported_velocity_is_known_from_first_report() {
    let first = round(|at| Some(rate_on_the_circle(at)))[0];
    for dynamics in dynamics() {
        let estimate =
            |climb| tracked(&[Measurement { climb, ..first }], &dynamics).at(seconds(1.0)).unwrap();
        let climbing = estimate(Some((-3.0, 0.5)));
        assert!((climbing.velocity - nalgebra::Vector3::new(0.0, 15.0, -3.0)).norm() < 1.5);
        assert!((climbing.position.0.z - 47.0).abs() < 0.5, "{}", climbing.position.0.z);
        assert_eq!(estimate(Some((f64::NAN, 0.5))), estimate(None));
    }
}
