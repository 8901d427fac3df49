//! The state of a target at one instant, and its update by a measurement.

use nalgebra::{Matrix2, SVector, Vector1, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::bias::{Bias, SlowChange};
use super::departure::{Cause, Departure};
use super::errors::RadarErrors;
use super::gaussian::{Bridge, Gaussian};
use super::height::{self, AboveGround};
use super::imm::Mixture;
use super::measurement::{By, Measurement, Owner, StateEstimate};
use super::plane::{self, OverGround};
use super::symmetric::Rows;
use crate::frames::Enu;
use crate::time::Time;

/// Squared Mahalanobis distance from the prediction above which a transponder report is a departure: the aircraft has
/// turned or stopped hard, or its receiver has jumped. Usual turns and stops stay below half of it.
const LEAP: f64 = 100.0;
/// Time constant with which the doubt of a receiver's jump fades (to 1/e), seconds.
const JUMP_LASTS_S: f64 = 30.0;
/// Doubt below which a jump is forgotten, metres.
const JUMP_SHOWS_M: f64 = 1.0;
/// Squared Mahalanobis distance above which a position, velocity or climb gets less weight.
const FAR: f64 = 16.0;

/// A radar track whose bias is estimated.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct BiasSlot {
    owner: Owner,
    errors: RadarErrors,
    /// Time of its last plot.
    last: Time,
}

/// Motion of a target: `M` models of a state of `P` variables over ground, one of `H` variables in height.
pub(super) trait StateMotion<const P: usize, const M: usize, const H: usize>:
    OverGround<P, M> + AboveGround<H>
{
}

impl<K, const P: usize, const M: usize, const H: usize> StateMotion<P, M, H> for K where
    K: OverGround<P, M> + AboveGround<H>
{
}

/// State at one instant, with the biases of up to `S` radars.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct FilterState<const P: usize, const M: usize, const H: usize, const S: usize> {
    #[serde(with = "crate::checkpoint::array")]
    held: [Option<BiasSlot>; S],
    plane: Mixture<P, M>,
    /// The Gaussian that approximates `plane`.
    pub(super) combined: Gaussian<P>,
    pub(super) height: Gaussian<H>,
    pub(super) jumps: Jumps,
}

/// Jumps of the transponder from the predicted position: its receiver is wrong now, or was before.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Jumps {
    over_ground: JumpedAxes<2>,
    in_height: JumpedAxes<1>,
    /// Time of the last report that was a jump.
    pub(super) last: Option<Time>,
    /// Time of the transponder's last report.
    heard: Option<Time>,
    /// Whether the cause of the last report's departure depends on the next report.
    pub(super) rests_on_next: bool,
}

/// Jumps on some axes, metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct JumpedAxes<const D: usize> {
    /// Sum of all jumps: zero once the receiver is back at its true position.
    all: SVector<f64, D>,
    /// Possible error of the receiver due to the jumps; it fades with time.
    doubt: SVector<f64, D>,
}

impl Jumps {
    fn decay(&mut self, dt: f64) {
        self.over_ground.decay(dt);
        self.in_height.decay(dt);
    }

    /// Records a departure at `time`, and returns its cause; `next` as in [`Departure::cause`].
    fn cause<const D: usize>(
        &mut self,
        time: Time,
        departure: &Departure<D>,
        next: Option<(SVector<f64, D>, f64)>,
    ) -> Cause {
        self.rests_on_next |= departure.is_in_reach();
        let cause = departure.cause(next);
        if cause != Cause::Motion {
            self.last = Some(time);
        }
        cause
    }

    /// Doubt at a time between two states: the larger of theirs.
    pub(super) fn between(before: &Self, after: &Self) -> Self {
        let over_ground = JumpedAxes::larger(&before.over_ground, &after.over_ground);
        Self { over_ground, in_height: JumpedAxes::larger(&before.in_height, &after.in_height), ..*after }
    }
}

impl<const D: usize> Default for JumpedAxes<D> {
    fn default() -> Self {
        Self { all: SVector::zeros(), doubt: SVector::zeros() }
    }
}

impl<const D: usize> JumpedAxes<D> {
    fn decay(&mut self, dt: f64) {
        self.doubt *= (-dt / JUMP_LASTS_S).exp();
        if self.doubt.norm() < JUMP_SHOWS_M {
            self.all = self.doubt;
        }
    }

    /// Adds a jump. The doubt is the sum of all jumps or the fading doubt with this jump, whichever is smaller: a
    /// receiver that returns from a false position is right again.
    fn add(&mut self, away: SVector<f64, D>) {
        self.all += away;
        self.doubt += away;
        if self.all.norm() < self.doubt.norm() {
            self.doubt = self.all;
        }
    }

    /// Limits the doubt to `most_m`, in metres, and the sum of the jumps with it.
    fn bound(&mut self, most_m: f64) {
        let doubt_m = self.doubt.norm();
        if doubt_m > most_m {
            self.doubt *= most_m / doubt_m;
            self.all = self.doubt;
        }
    }

    fn larger(one: &Self, other: &Self) -> Self {
        if other.doubt.norm() > one.doubt.norm() { *other } else { *one }
    }
}

/// The bridges back from a later state.
pub(super) type Bridges<const P: usize, const H: usize> = (Bridge<P>, Bridge<H>);

impl<const P: usize, const M: usize, const H: usize, const S: usize> FilterState<P, M, H, S> {
    /// Prior state of a target, before its first measurement, which is the given one.
    pub(super) fn unmeasured(measurement: &Measurement, models: &impl StateMotion<P, M, H>) -> Self {
        let mut held = [None; S];
        let mut biases = [Bias::NONE; S];
        if let By::Radar { owner, errors, .. } = measurement.by {
            held[0] = Some(BiasSlot { owner, errors, last: measurement.time });
            biases[0] = Bias::of(&errors);
        }
        let Measurement { position, height_measured, .. } = *measurement;
        let mut plane = OverGround::first(models, position.0.xy());
        plane.parts.iter_mut().for_each(|part| plane::begin(part, &biases));
        let mut height = AboveGround::first(models, position.0.z, height_measured);
        height::begin(&mut height, &biases);
        Self { held, combined: plane.combined(), plane, height, jumps: Jumps::default() }
    }

    /// The first state, after the first measurement.
    pub(super) fn first(measurement: &Measurement, models: &impl StateMotion<P, M, H>) -> Self {
        let mut state = Self::unmeasured(measurement, models);
        let before = state.combined;
        state.observe(measurement, &before);
        let (plane, height) = (state.plane.combined(), state.height);
        state.observe_motion(measurement, &plane, &height);
        state.combined = state.plane.combined();
        state
    }

    /// The state `dt` seconds later, without a measurement.
    pub(super) fn moved_to(&self, dt: f64, models: &impl StateMotion<P, M, H>) -> Self {
        let changes = self.changes(dt);
        let (plane, combined) = self.plane_at(dt, &changes, models, None);
        let above = self.height.predicted(&models.motion(dt), &height::slow(&changes));
        Self { held: self.held, plane, combined, height: above.predicted, jumps: self.jumps }
    }

    /// The bridges to this state from that at the next measurement.
    pub(super) fn bridges(
        &self,
        next: &Measurement,
        dt: f64,
        models: &impl StateMotion<P, M, H>,
    ) -> Bridges<P, H> {
        let (_, changes) = self.changes_to(next, dt);
        let mut across = [[0.0; P]; P];
        let (_, predicted) = self.plane_at(dt, &changes, models, Some(&mut across));
        let above = self.height.predicted(&models.motion(dt), &height::slow(&changes));
        (Bridge { predicted, across }, above)
    }

    /// The state after the next measurement, and the bridges back. `later` are the measurements after that, in order of
    /// time.
    pub(super) fn next(
        &self,
        measurement: &Measurement,
        later: &[Measurement],
        dt: f64,
        models: &impl StateMotion<P, M, H>,
    ) -> (Self, Bridges<P, H>) {
        let (mut state, mut bridges) = self.ahead_to(measurement, dt, models);
        state.jumps.decay(dt);
        state.check_for_jump(measurement, later, &mut bridges);
        state.limit_jump_doubt(measurement, &bridges.0.predicted, &bridges.1.predicted);
        let height = state.height;
        state.observe(measurement, &bridges.0.predicted);
        state.observe_motion(measurement, &bridges.0.predicted, &height);
        state.combined = state.plane.combined();
        (state, bridges)
    }

    /// Index of a radar track's bias among the estimated ones: that of its radar, a free one, or that of the radar
    /// whose last plot is oldest.
    fn place(&self, owner: &Owner) -> usize {
        let of_radar = |held: &Option<BiasSlot>| held.is_some_and(|held| held.owner.radar == owner.radar);
        let least = || (0..S).min_by_key(|&place| self.held[place].map(|held| held.last)).unwrap_or(0);
        self.held.iter().position(of_radar).unwrap_or_else(least)
    }

    /// Change of the biases in `dt` seconds.
    fn changes(&self, dt: f64) -> [SlowChange; S] {
        self.held.map(|held| held.map_or(SlowChange::NONE, |held| SlowChange::after(&held.errors, dt)))
    }

    /// The radars whose biases are estimated, and the change of the biases up to the next measurement. If that is of another radar
    /// track, its bias starts there.
    fn changes_to(&self, next: &Measurement, dt: f64) -> ([Option<BiasSlot>; S], [SlowChange; S]) {
        let (mut held, mut changes) = (self.held, self.changes(dt));
        if let By::Radar { owner, errors, known, .. } = next.by {
            let place = self.place(&owner);
            let is_same = held[place].is_some_and(|held| held.owner == owner);
            changes[place] = if is_same { SlowChange::after(&errors, dt) } else { SlowChange::reset(known) };
            held[place] = Some(BiasSlot { owner, errors, last: next.time });
        }
        (held, changes)
    }

    /// The state at the next measurement, and the bridges back.
    fn ahead_to(
        &self,
        next: &Measurement,
        dt: f64,
        models: &impl StateMotion<P, M, H>,
    ) -> (Self, Bridges<P, H>) {
        let (held, changes) = self.changes_to(next, dt);
        let mut across = [[0.0; P]; P];
        let (plane, predicted) = self.plane_at(dt, &changes, models, Some(&mut across));
        let above = self.height.predicted(&models.motion(dt), &height::slow(&changes));
        let state = Self { held, plane, combined: predicted, height: above.predicted, jumps: self.jumps };
        (state, (Bridge { predicted, across }, above))
    }

    /// The state over ground `dt` seconds later, and the Gaussian that approximates it; `across` as in
    /// [`Mixture::advanced`].
    fn plane_at(
        &self,
        dt: f64,
        changes: &[SlowChange; S],
        models: &impl StateMotion<P, M, H>,
        across: Option<&mut Rows<P, P>>,
    ) -> (Mixture<P, M>, Gaussian<P>) {
        let speed_m_s = self.combined.mean[2].hypot(self.combined.mean[3]);
        self.plane.advanced(
            &self.combined,
            &models.motions(dt, speed_m_s),
            &plane::slow(changes),
            &OverGround::switch(models, dt),
            across,
        )
    }

    /// Checks a transponder's report for a jump of its receiver, over ground or in height. A jump enlarges the
    /// covariance of the position, and leaves the velocity unchanged.
    fn check_for_jump(
        &mut self,
        measurement: &Measurement,
        later: &[Measurement],
        bridges: &mut Bridges<P, H>,
    ) {
        let By::Transponder { horizontal_m, vertical_m } = measurement.by else { return };
        let heard = self.jumps.heard.replace(measurement.time);
        self.jumps.rests_on_next = false;
        let within_s = heard.map_or(0.0, |heard| measurement.time.seconds_since(heard));
        let next = later.iter().find(|later| matches!(later.by, By::Transponder { .. }));
        if let Some(away) = self.jumped(measurement, next, (horizontal_m, within_s), &bridges.0.predicted) {
            plane::spread(&mut bridges.0.predicted, away);
            self.plane.parts.iter_mut().for_each(|part| plane::spread(part, away));
        }
        if let Some(away_m) = self.jumped_in_height(measurement, next, (vertical_m, within_s)) {
            bridges.1.predicted.covariance.add_at(0, 0, away_m * away_m);
            self.height.covariance.add_at(0, 0, away_m * away_m);
        }
    }

    /// Displacement of a jump over ground; `None` without one. An undecided departure adds doubt, but is followed as
    /// motion.
    fn jumped(
        &mut self,
        measurement: &Measurement,
        next: Option<&Measurement>,
        (sigma_m, within_s): (f64, f64),
        predicted: &Gaussian<P>,
    ) -> Option<Vector2<f64>> {
        let place = measurement.position.0.xy();
        if predicted.distance(&plane::fix(place, sigma_m)) <= LEAP {
            return None;
        }
        let [east, north, east_rate, north_rate] = std::array::from_fn(|at| predicted.mean[at]);
        let away = place - Vector2::new(east, north);
        let sigma_m = predicted.covariance.at(0, 0).max(predicted.covariance.at(1, 1)).sqrt();
        let departure = Departure { away, sigma_m, velocity: Vector2::new(east_rate, north_rate), within_s };
        let next = next.map(|next| {
            let after_s = next.time.seconds_since(measurement.time);
            ((next.position.0.xy() - place) / after_s, after_s)
        });
        let cause = self.jumps.cause(measurement.time, &departure, next);
        if cause != Cause::Motion {
            self.jumps.over_ground.add(away);
        }
        (cause == Cause::Receiver).then_some(away)
    }

    /// Displacement of a jump in height; `None` without one. Jumps over ground and in height are independent.
    fn jumped_in_height(
        &mut self,
        measurement: &Measurement,
        next: Option<&Measurement>,
        (sigma_m, within_s): (f64, f64),
    ) -> Option<f64> {
        let [height_m, climb] = [self.height.mean[0], self.height.mean[1]];
        let away_m = measurement.position.0.z - height_m;
        let variance_m2 = self.height.covariance.at(0, 0);
        if !measurement.height_measured || away_m * away_m <= LEAP * (variance_m2 + sigma_m * sigma_m) {
            return None;
        }
        let (away, velocity) = (Vector1::new(away_m), Vector1::new(climb));
        let departure = Departure { away, sigma_m: variance_m2.sqrt(), velocity, within_s };
        let next = next.filter(|next| next.height_measured).map(|next| {
            let after_s = next.time.seconds_since(measurement.time);
            (Vector1::new((next.position.0.z - measurement.position.0.z) / after_s), after_s)
        });
        let cause = self.jumps.cause(measurement.time, &departure, next);
        if cause != Cause::Motion {
            self.jumps.in_height.add(away);
        }
        (cause == Cause::Receiver).then_some(away_m)
    }

    /// Limits the doubt of a jumped transponder by a radar's plot: to the plot's distance from the predicted position,
    /// combined with the radar's errors.
    fn limit_jump_doubt(&mut self, measurement: &Measurement, predicted: &Gaussian<P>, above: &Gaussian<H>) {
        let By::Radar { seen, errors, .. } = &measurement.by else { return };
        if measurement.height_measured {
            let away_m = measurement.position.0.z - above.mean[0];
            self.jumps.in_height.bound(away_m.hypot(errors.bias_height_m.hypot(errors.noise_height_m)));
        }
        let Some(along) = self.jumps.over_ground.doubt.try_normalize(0.0) else { return };
        let away = measurement.position.0.xy() - Vector2::new(predicted.mean[0], predicted.mean[1]);
        let errors = seen.spread(
            errors.bias_range_m.hypot(errors.noise_range_m),
            errors.bias_azimuth.hypot(errors.noise_azimuth),
        );
        self.jumps.over_ground.bound(away.norm().hypot(along.dot(&(errors * along)).sqrt()));
    }

    fn observe(&mut self, measurement: &Measurement, predicted: &Gaussian<P>) {
        let Measurement { position, height_measured, by, .. } = measurement;
        let place = position.0.xy();
        let (over_ground, sigma_m, radar) = match by {
            By::Transponder { horizontal_m, vertical_m } => {
                (Some(plane::fix(place, *horizontal_m)), *vertical_m, None)
            }
            By::Radar { owner, seen, errors, .. } => {
                let radar = self.place(owner);
                (Some(plane::plot::<P, S>(place, seen, errors, radar)), errors.noise_height_m, Some(radar))
            }
            By::Camera { clockwise, across_m, height_m, .. } => {
                (Some(plane::line(place, *clockwise, *across_m)), *height_m, None)
            }
            By::Height { sigma_m, .. } => (None, *sigma_m, None),
        };
        if let Some(mut over_ground) = over_ground {
            let distance = predicted.distance(&over_ground);
            if distance > FAR {
                over_ground = over_ground.coarser(distance / FAR);
            }
            self.plane.observe(&over_ground);
        }
        if *height_measured {
            self.height.observe(&height::height::<H, S>(position.0.z, sigma_m, radar));
        }
    }

    /// Updates the state by a measured velocity and climb. Their distance is that to the state before this
    /// measurement's position, which may be the one that is wrong.
    fn observe_motion(&mut self, measurement: &Measurement, plane: &Gaussian<P>, height: &Gaussian<H>) {
        let Measurement { velocity, climb, .. } = measurement;
        if let Some((velocity, deviation)) = velocity.filter(|(v, _)| v.iter().all(|rate| rate.is_finite())) {
            self.plane.observe(&plane.bounded(plane::velocity(velocity, deviation), FAR));
        }
        if let Some((climb, deviation)) = climb.filter(|(climb, _)| climb.is_finite()) {
            self.height.observe(&height.bounded_scalar(height::climb(climb, deviation), FAR));
        }
    }
}

impl StateEstimate {
    /// Combines a state over ground and a vertical state.
    pub(super) fn of<const P: usize, const H: usize>(
        plane: &Gaussian<P>,
        height: &Gaussian<H>,
        jumps: &Jumps,
        since_s: Option<f64>,
        until_s: Option<f64>,
    ) -> Self {
        let block = |rows: usize, columns: usize| {
            Matrix2::from_fn(|row, column| plane.covariance.at(rows + row, columns + column))
        };
        let (over_ground, in_height) = (&jumps.over_ground.doubt, &jumps.in_height.doubt);
        Self {
            position: Enu::new(plane.mean[0], plane.mean[1], height.mean[0]),
            velocity: Vector3::new(plane.mean[2], plane.mean[3], height.mean[1]),
            horizontal: block(0, 0) + over_ground * over_ground.transpose(),
            vertical: height.covariance.at(0, 0) + in_height.norm_squared(),
            velocity_covariance: block(2, 2),
            position_velocity: block(0, 2),
            height_climb: height.covariance.at(0, 1),
            climb: height.covariance.at(1, 1),
            since_s,
            until_s,
        }
    }
}
