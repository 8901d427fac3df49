//! An aircraft as the service knows it, whichever sensor sees it.

use std::cell::OnceCell;
use std::f64::consts::{LN_2, SQRT_2};

use super::pairing::Evidence;
use super::settings::{self, Radar, Settings};
use super::tracklet::{TargetId, Tracklet, TrackletId};
use super::{DAWN, EVER};
use crate::filter::{Bias, By, LineOfSight, Measurement, Owner, StateEstimate, TargetFilter};
use crate::frames::Enu;
use crate::interpolation::{self, Knot};
use crate::numbering::Numbered;
use crate::point::{RadarPart, TransponderPart};
use crate::report::{Fix, Identity, Plot, SensorIndex, UasItems};
use crate::slots::Slot;
use crate::time::Time;

/// From report to report a transponder's position errs by this share of its accuracy: most of a satellite receiver's error
/// lasts for a minute.
const FRESH: f64 = 0.3;
/// Deviation of a transponder's velocity on each axis over ground, metres a second: it comes from the Doppler shift of
/// satellites, which a receiver knows better than it knows places,
const DOPPLER: f64 = 0.3;
/// and of its climb: satellites are all above it.
const DOPPLER_UP: f64 = 0.5;
/// Deviation of a radar track's velocity on each axis, metres a second: what the radar's own tracker makes of its plots,
const TRACK_VELOCITY: f64 = 1.5;
/// of which an error lasts for so many seconds.
const TRACK_VELOCITY_LASTS_S: f64 = 3.0;
/// A drone may accelerate by so much between two reports, metres a second squared.
const BETWEEN: f64 = 1.5;
/// Radar plots are used for the position where a transponder is silent for longer than this, seconds: where it speaks they
/// would only add their own error.
const SILENCE_S: f64 = 5.0;

/// Transponders differ in how late their reports are stamped by this, one standard deviation, seconds.
const DELAYS_S: f64 = 0.08;
/// Reports of one transponder so near in time are one report, of which the last received counts, nanoseconds.
pub(super) const SAME_NS: i64 = 20_000_000;

/// The part of a transponder's error that lasts, and so cannot be seen from report to report.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lasting {
    /// Of the position over ground, each axis, m².
    pub(super) horizontal_m2: f64,
    /// Of the height, m².
    pub(super) vertical_m2: f64,
    /// Of the time, s².
    pub(super) time_s2: f64,
}

/// An aircraft.
#[derive(Clone, Debug)]
pub(super) struct Target {
    /// Who its transponder says it is.
    pub(super) transponder: Option<Transponder>,
    /// The radar track that it is followed by, if any.
    pub(super) tracklet: Option<TrackletId>,
    /// A radar's latest part in it, and how far its plot may be off, metres.
    pub(super) radar: Option<(RadarPart, f64)>,
    pub(super) filter: TargetFilter,
    /// The published number and the slot in which it was given.
    pub(super) number: Option<(u32, Slot)>,
    /// When it was heard of last.
    newest: Time,
}

/// A target's transponder.
#[derive(Clone, Debug)]
pub(super) struct Transponder {
    pub(super) identity: Identity,
    pub(super) items: UasItems,
    pub(super) sensor: SensorIndex,
    pub(super) numbered: Option<Numbered>,
    /// By time; at the time at which the position was measured.
    fixes: Vec<Fix>,
    /// The same as knots of the curve.
    knots: Vec<Knot>,
}

/// A place on a transponder's curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnCurve {
    pub(super) position: Enu,
    /// How far it may be off, metres.
    pub(super) sigma_m: f64,
}

impl Transponder {
    fn new(fix: &Fix) -> Self {
        Self {
            identity: fix.identity,
            items: fix.items,
            sensor: fix.sensor,
            numbered: None,
            fixes: Vec::new(),
            knots: Vec::new(),
        }
    }

    fn insert(&mut self, fix: Fix) {
        self.items = fix.items;
        self.sensor = fix.sensor;
        let first = Time::from_nanos(fix.time.nanos() - SAME_NS);
        let index = self.fixes.partition_point(|earlier| earlier.time < first);
        let knot = Knot { time: fix.time, position: fix.position.0 };
        match self.fixes.get_mut(index) {
            Some(same) if same.time.nanos() - fix.time.nanos() <= SAME_NS => {
                *same = fix;
                self.knots[index] = knot;
            }
            _ => {
                self.fixes.insert(index, fix);
                self.knots.insert(index, knot);
            }
        }
    }

    /// Forgets reports before `time`, but for the last two of them.
    fn forget_before(&mut self, time: Time) {
        let old = self.fixes.partition_point(|fix| fix.time < time).saturating_sub(2);
        self.fixes.drain(..old);
        self.knots.drain(..old);
    }

    /// Where it was; `None` outside its reports, and between two that are further apart than `max_gap_ns`.
    fn on_curve(&self, time: Time, max_gap_ns: i64, accuracy_m: f64) -> Option<OnCurve> {
        let after = self.knots.partition_point(|knot| knot.time < time);
        let next = self.knots.get(after)?;
        let mut between_m = 0.0;
        if next.time != time {
            let before = &self.knots[after.checked_sub(1)?];
            if next.time.nanos() - before.time.nanos() > max_gap_ns {
                return None;
            }
            between_m = 0.5 * BETWEEN * time.seconds_since(before.time) * next.time.seconds_since(time);
        }
        let position = Enu(interpolation::evaluate(&self.knots, time)?);
        Some(OnCurve { position, sigma_m: between_m.hypot(accuracy_m * FRESH) })
    }

    /// Its part in a point of a slot that ends at `end`.
    pub(super) fn part(&self, end: Time) -> Option<TransponderPart> {
        let heard = self.fixes.partition_point(|fix| fix.time < end).checked_sub(1);
        Some(TransponderPart {
            number: self.numbered?.number,
            identity: self.identity,
            sensor: self.sensor,
            time: heard.map(|index| self.fixes[index].time),
            items: self.items,
        })
    }
}

impl Target {
    pub(super) fn new(newest: Time, settings: &Settings) -> Self {
        Self {
            transponder: None,
            tracklet: None,
            radar: None,
            filter: TargetFilter::new(&settings.motion),
            number: None,
            newest,
        }
    }

    /// A report of its transponder.
    pub(super) fn hear(&mut self, fix: Fix) {
        self.newest = self.newest.max(fix.time);
        self.transponder.get_or_insert_with(|| Transponder::new(&fix)).insert(fix);
    }

    /// A plot of its radar track, for the slot that is put out.
    pub(super) fn see(&mut self, plot: &Plot, settings: &Settings) {
        let Some(radar) = settings.radar(plot.track.sensor) else { return };
        let part = RadarPart {
            track: plot.track,
            time: plot.time,
            height_measured: plot.height_measured,
            uav_probability: plot.uav_probability,
        };
        self.radar = Some((part, plot_sigma_m(radar, plot.position)));
    }

    /// Forgets reports before `time`, but for the last; when it was heard of last.
    pub(super) fn forget_before(&mut self, time: Time) -> Time {
        if let Some(transponder) = &mut self.transponder {
            transponder.forget_before(time);
        }
        self.newest
    }

    /// The part of its transponder's error that lasts.
    pub(super) fn lasting(&self, settings: &Settings) -> Lasting {
        let Some(transponder) = &self.transponder else { return Lasting::default() };
        let Some(receiver) = settings.transponder(transponder.sensor) else { return Lasting::default() };
        let stated_m = transponder.fixes.last().and_then(|fix| fix.accuracy_m);
        let share = 1.0 - FRESH * FRESH;
        let delay_s = DELAYS_S.hypot(receiver.delay_sigma_s);
        Lasting {
            horizontal_m2: axis_m(stated_m, receiver).powi(2) * share,
            vertical_m2: receiver.vertical_m.powi(2) * share,
            time_s2: delay_s * delay_s,
        }
    }

    /// Where its transponder says it was.
    pub(super) fn on_curve(&self, time: Time, settings: &Settings) -> Option<OnCurve> {
        let transponder = self.transponder.as_ref()?;
        let accuracy_m = settings.transponder(transponder.sensor)?.horizontal_m;
        transponder.on_curve(time, settings.max_gap_ns, accuracy_m)
    }

    /// Brings the filter to what is known now; what lies up to `since` is settled. `own`: by what its radar track knows it.
    pub(super) fn measure(
        &mut self,
        own: TargetId,
        (since, now): (Time, Time),
        tracklet: Option<&Tracklet>,
        settings: &Settings,
    ) {
        let mut measurements: Vec<Measurement> = Vec::new();
        // Of a target that was let in just now nothing is settled, however long its first report has waited.
        let is_new = self.transponder.is_some() && self.filter.newest().is_none();
        let settled = if is_new { DAWN } else { since };
        if let Some(transponder) = &self.transponder {
            let from = transponder.fixes.partition_point(|fix| fix.time <= settled);
            measurements.extend(transponder.fixes[from..].iter().filter_map(|fix| heard(fix, settings)));
        }
        if let Some(tracklet) = tracklet
            && let Some(radar) = settings.radar(tracklet.key.sensor)
        {
            // Few plots are used, so that is seldom asked for.
            let evidence = OnceCell::new();
            let evidence = || *evidence.get_or_init(|| tracklet.evidence_of(own, self, now, settings));
            let plots = tracklet.between(since, EVER);
            measurements.extend(plots.filter_map(|plot| {
                let (last, silence_s) = self.silence(plot.time, tracklet.last());
                (silence_s > SILENCE_S).then(|| seen(plot, tracklet.id, radar, last, evidence()))
            }));
        }
        // Stable: of one time, the transponder comes first.
        measurements.sort_by_key(|measurement| measurement.time);
        self.filter.measure(settled, &measurements);
        self.newest = self.newest.max(self.filter.newest().map_or(self.newest, |newest| newest.time));
    }

    /// The transponder's last report up to a time, and how long it is silent then: to the next one or, where there is none
    /// yet, to `until`; seconds.
    fn silence(&self, time: Time, until: Time) -> (Option<Time>, f64) {
        let fixes = self.transponder.as_ref().map_or(&[][..], |transponder| &transponder.fixes);
        let after = fixes.partition_point(|fix| fix.time <= time);
        let Some(last) = after.checked_sub(1).map(|last| fixes[last].time) else {
            return (None, f64::INFINITY);
        };
        let next = fixes.get(after).map_or(until, |fix| fix.time);
        (Some(last), next.seconds_since(last))
    }

    /// Where it is.
    pub(super) fn estimate(&self, time: Time) -> Option<StateEstimate> {
        self.filter.at(time)
    }
}

/// How far a radar's plots of a place are off for a while, metres: of each axis in the mean.
pub(super) fn plot_sigma_m(radar: &Radar, place: Enu) -> f64 {
    let spread =
        LineOfSight::from(radar.position, place).spread(radar.errors.bias_range_m, radar.errors.bias_azimuth);
    (spread.trace() / 2.0).sqrt()
}

/// Deviation of a position over ground on each axis, metres: of what the transponder states, else of what the data sheet does.
fn axis_m(stated_m: Option<f64>, receiver: &settings::Transponder) -> f64 {
    // Half of the errors lie within 1.177 deviations; a data sheet's deviation is that of the distance.
    stated_m.map_or(receiver.horizontal_m / SQRT_2, |half_m| half_m / (2.0 * LN_2).sqrt())
}

fn heard(fix: &Fix, settings: &Settings) -> Option<Measurement> {
    let receiver = settings.transponder(fix.sensor)?;
    Some(Measurement {
        time: fix.time,
        position: fix.position,
        height_measured: true,
        by: By::Transponder {
            horizontal_m: receiver.horizontal_m * FRESH,
            vertical_m: receiver.vertical_m * FRESH,
        },
        velocity: fix.velocity.map(|velocity| (velocity, DOPPLER)),
        climb: fix.climb_m_s.map(|climb| (climb, DOPPLER_UP)),
    })
}

/// A plot, after the transponder's report of `last`, up to which `evidence` tells the radar's slow error.
fn seen(
    plot: &Plot,
    tracklet: TrackletId,
    radar: &Radar,
    last: Option<Time>,
    evidence: Option<Evidence>,
) -> Measurement {
    let seen = LineOfSight::from(radar.position, plot.position);
    let known = evidence.zip(last).and_then(|(evidence, last)| {
        evidence.bias(seen.range_m, plot.time.seconds_since(last), &radar.errors)
    });
    Measurement {
        time: plot.time,
        position: plot.position,
        height_measured: plot.height_measured,
        by: By::Radar {
            owner: Owner { tracklet: tracklet.0, since: last },
            known: known.unwrap_or(Bias::of(&radar.errors)),
            seen,
            errors: radar.errors,
        },
        velocity: plot.velocity.map(|velocity| (velocity, track_velocity(radar.period_s))),
        climb: None,
    }
}

/// The deviation with which a radar track's velocity is taken that comes every `period_s` seconds, above zero. Its errors
/// are correlated, and the filter takes each as new: the mean of many that go by x' = ρx + w, ρ = exp(-T/τ), has
/// (1+ρ)/(1-ρ) = coth(T/2τ) times the variance that it would have of new ones.
fn track_velocity(period_s: f64) -> f64 {
    TRACK_VELOCITY / (period_s / (2.0 * TRACK_VELOCITY_LASTS_S)).tanh().sqrt()
}
