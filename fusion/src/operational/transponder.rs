//! A transponder's reports, and the curve through them.

use std::f64::consts::{LN_2, SQRT_2};

use serde::{Deserialize, Serialize};

use super::cycle::EARLIEST;
use super::settings::{self, OperationalSettings};
use super::transponder_types::TransponderTypes;
use super::tuning::{
    BETWEEN_REPORTS_M_S2, FRESH_SHARE, HEIGHT_KEPT_S, NOISE_CHANGE_S, POORER, SAME_REPORT,
    TRANSPONDER_SILENT_S,
};
use crate::filter::speed_factor;
use crate::frames::Enu;
use crate::interpolation::{CubicPiece, HermiteCurve, Knot};
use crate::learning::{Likelihoods, WhiteNoise, likelihoods};
use crate::numbering::Numbered;
use crate::point::TransponderPart;
use crate::report::{Aircraft, Fix, Host, Identity, SensorIndex, TransponderType, UasItems};
use crate::time::Time;

/// A transponder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Transponder {
    pub(super) identity: Identity,
    /// Receiver of the latest report.
    pub(super) sensor: SensorIndex,
    /// Host that sent the latest report.
    pub(super) host: Host,
    pub(super) numbered: Option<Numbered>,
    items: UasItems,
    aircraft: Aircraft,
    /// Reports in order of measurement time.
    fixes: Vec<Fix>,
    /// Number of reports without a height, or with a coarse one.
    unheighted: usize,
    /// Curve through the reported positions.
    curve: HermiteCurve,
    noise: PositionNoise,
}

/// White noise of a transponder's positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PositionNoise {
    /// Over ground, and in height.
    axes: [WhiteNoise; 2],
    /// Time up to which reports are included; [`EARLIEST`]: none, not even the prior from the type.
    until: Time,
}

/// A position on the curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvePosition {
    pub(super) position: Enu,
    /// Sigma of interpolation and white noise, metres.
    pub(super) sigma_m: f64,
    /// Time between the reports before and after, seconds; 0 at a report.
    pub(super) spacing_s: f64,
    /// Whether all kept reports state a height that is not coarse.
    pub(super) height_measured: bool,
}

/// Variances of a transponder's bias, which is common to successive reports.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TransponderBias {
    /// Variance of the position over ground, each axis, m².
    pub(super) horizontal_m2: f64,
    pub(super) vertical_m2: f64,
    /// Variance of the time stamp, s².
    pub(super) time_s2: f64,
}

/// Evaluation of a transponder's curve at successive times. It caches the piece between two reports.
#[derive(Debug)]
pub(super) struct CurveCursor<'a> {
    curve: &'a HermiteCurve,
    /// Sigma of the white noise over ground, metres.
    white_m: f64,
    height_measured: bool,
    /// Taken off its heights, metres.
    height_offset_m: f64,
    /// Maximum time between two reports that are connected, nanoseconds.
    max_gap_ns: i64,
    /// Piece of the curve that contains the last time.
    piece: Option<CubicPiece>,
}

impl CurveCursor<'_> {
    /// Position at a time; `None` outside the reports, and between two reports that are too far apart.
    pub(super) fn at(&mut self, time: Time) -> Option<CurvePosition> {
        if self.piece.as_ref().is_none_or(|piece| !piece.spans(time)) {
            match CurveLocation::of(time, self.curve.knots(), self.max_gap_ns)? {
                CurveLocation::After(index) => self.piece = Some(self.curve.piece(index)),
                CurveLocation::At(index) => {
                    let Self { white_m: sigma_m, height_measured, .. } = *self;
                    let position = self.corrected(Enu::from(self.curve.knots()[index].position));
                    return Some(CurvePosition { position, sigma_m, spacing_s: 0.0, height_measured });
                }
            }
        }
        let piece = self.piece.as_ref()?;
        let (since_s, until_s) = piece.apart_s(time);
        let acceleration_m_s2 = BETWEEN_REPORTS_M_S2 * speed_factor(piece.speed_m_s()).powi(2);
        let between_m = 0.5 * acceleration_m_s2 * since_s * until_s;
        Some(CurvePosition {
            position: self.corrected(Enu::from(piece.at(time))),
            sigma_m: between_m.hypot(self.white_m),
            spacing_s: since_s + until_s,
            height_measured: self.height_measured,
        })
    }

    fn corrected(&self, position: Enu) -> Enu {
        lowered(position, self.height_offset_m)
    }
}

/// A position with this taken off its height.
pub(super) fn lowered(position: Enu, by_m: f64) -> Enu {
    Enu::new(position.east(), position.north(), position.up() - by_m)
}

/// Location of a time on the curve: index of the report at that time, or of the one before.
enum CurveLocation {
    At(usize),
    After(usize),
}

impl CurveLocation {
    /// `None` outside the reports, and between two that are more than `max_gap_ns` apart.
    fn of(time: Time, knots: &[Knot], max_gap_ns: i64) -> Option<Self> {
        if knots.len() < 2 {
            return None;
        }
        let after = knots.partition_point(|knot| knot.time < time);
        let next = knots.get(after)?;
        if next.time == time {
            return Some(Self::At(after));
        }
        let index = after.checked_sub(1)?;
        let is_apart = next.time.nanos() - knots[index].time.nanos() > max_gap_ns;
        (!is_apart).then_some(Self::After(index))
    }
}

impl Transponder {
    pub(super) fn new(fix: &Fix) -> Self {
        Self {
            identity: fix.identity,
            sensor: fix.sensor,
            host: fix.host,
            numbered: None,
            items: fix.items,
            aircraft: fix.aircraft,
            fixes: Vec::new(),
            unheighted: 0,
            curve: HermiteCurve::default(),
            noise: PositionNoise { axes: Default::default(), until: EARLIEST },
        }
    }

    /// Adds a report. It replaces an earlier one of the same time.
    pub(super) fn insert(&mut self, fix: Fix) {
        self.items = fix.items;
        self.aircraft = fix.aircraft.or(self.aircraft);
        self.sensor = fix.sensor;
        self.host = fix.host;
        let first = fix.time + -SAME_REPORT;
        let index = self.fixes.partition_point(|earlier| earlier.time < first);
        let knot = Knot { time: fix.time, position: fix.position.0 };
        self.unheighted += usize::from(!fix.has_fine_height());
        match self.fixes.get_mut(index) {
            Some(same) if same.time - fix.time <= SAME_REPORT => {
                self.unheighted -= usize::from(!same.has_fine_height());
                *same = fix;
                self.curve.replace(index, knot);
            }
            _ => {
                self.fixes.insert(index, fix);
                self.curve.insert(index, knot);
            }
        }
    }

    /// Drops reports before `time`, except for the last two of them.
    pub(super) fn forget_before(&mut self, time: Time) {
        let old = self.fixes.partition_point(|fix| fix.time < time).saturating_sub(2);
        self.unheighted -= self.fixes.drain(..old).filter(|fix| !fix.has_fine_height()).count();
        self.curve.forget(old);
    }

    /// The reports after `time`.
    pub(super) fn after(&self, time: Time) -> &[Fix] {
        &self.fixes[self.fixes.partition_point(|fix| fix.time <= time)..]
    }

    /// Time of the last report up to `time`.
    pub(super) fn last_until(&self, time: Time) -> Option<Time> {
        let after = self.fixes.partition_point(|fix| fix.time <= time);
        Some(self.fixes[after.checked_sub(1)?].time)
    }

    /// Times of the first and last report that shape the curve at `time`: two before, and two after.
    pub(super) fn shaped_at(&self, time: Time) -> Option<(Time, Time)> {
        let after = self.fixes.partition_point(|fix| fix.time <= time);
        let shaping = &self.fixes[after.saturating_sub(2)..self.fixes.len().min(after + 2)];
        Some((shaping.first()?.time, shaping.last()?.time))
    }

    /// Last report up to `time`, and the silence after it, seconds: until the next report or, if there is none yet, until
    /// `until`.
    pub(super) fn silence(&self, time: Time, until: Time) -> Option<(Time, f64)> {
        let after = self.fixes.partition_point(|fix| fix.time <= time);
        let last = self.fixes[after.checked_sub(1)?].time;
        let next = self.fixes.get(after).map_or(until, |fix| fix.time);
        Some((last, next.seconds_since(last)))
    }

    /// Whether a silence of more than `seconds`, as in [`Self::silence`], covers some of the time from `since` to `until`.
    pub(super) fn is_silent_within(&self, since: Time, until: Time, seconds: f64) -> bool {
        let after = self.fixes.partition_point(|fix| fix.time <= since);
        let Some(first) = after.checked_sub(1) else { return true };
        let heard = self.fixes[first..].iter().take_while(|fix| fix.time <= until).map(|fix| fix.time);
        let next = self.fixes[first + 1..].iter().map(|fix| fix.time).chain([until]);
        heard.zip(next).any(|(last, next)| next.seconds_since(last) > seconds)
    }

    /// Time of the newest report.
    pub(super) fn last_heard(&self) -> Option<Time> {
        self.fixes.last().map(|fix| fix.time)
    }

    /// Type of the transponder.
    pub(super) fn kind(&self) -> TransponderType {
        TransponderType::of(self.sensor, &self.items)
    }

    /// Learns the white noise of the transponder and of its type from the reports up to `until`.
    pub(super) fn learn(
        &mut self,
        until: Time,
        types: &mut TransponderTypes,
        settings: &OperationalSettings,
    ) {
        let Some(receiver) = settings.transponder(self.sensor) else { return };
        let kind = self.kind();
        if self.noise.until == EARLIEST {
            self.noise.axes = types.noise(&kind);
        }
        let configured_m = [receiver.horizontal_m, receiver.vertical_m].map(|sigma_m| sigma_m * FRESH_SHARE);
        for three in self.fixes.windows(3) {
            let [before, at, after] = three else { continue };
            if after.time <= self.noise.until || after.time > until {
                continue;
            }
            self.noise.until = after.time;
            if let Some(mut report) = likelihoods([before, at, after], configured_m) {
                if !three.iter().all(Fix::has_fine_height) {
                    // An assumed height has no noise, and is no evidence on that of measured heights.
                    report[1] = Likelihoods::default();
                }
                let dt = after.time.seconds_since(at.time);
                for (noise, report) in self.noise.axes.iter_mut().zip(&report) {
                    noise.add(report, dt, NOISE_CHANGE_S);
                }
                types.take_report(kind, after.time, &report, dt);
            }
        }
    }

    /// Sigma of the white noise of the positions: each axis over ground, and in height, metres.
    pub(super) fn white_m(&self, receiver: &settings::ReceiverSettings) -> [f64; 2] {
        let [over_ground, in_height] = &self.noise.axes;
        [over_ground.scale().0 * receiver.horizontal_m, in_height.scale().0 * receiver.vertical_m]
            .map(|sigma_m| sigma_m * FRESH_SHARE)
    }

    /// Position at a time; `None` outside the reports, and between two reports that are too far apart.
    pub(super) fn on_curve(&self, time: Time, settings: &OperationalSettings) -> Option<CurvePosition> {
        self.walk(settings)?.at(time)
    }

    /// Whether [`Self::on_curve`] has a position at a time.
    pub(super) fn is_on_curve(&self, time: Time, settings: &OperationalSettings) -> bool {
        settings.transponder(self.sensor).is_some()
            && CurveLocation::of(time, self.curve.knots(), settings.max_gap_ns).is_some()
    }

    /// An evaluator of the curve for successive times.
    pub(super) fn walk(&self, settings: &OperationalSettings) -> Option<CurveCursor<'_>> {
        let [white_m, _] = self.white_m(settings.transponder(self.sensor)?);
        let height_measured = self.unheighted == 0;
        Some(CurveCursor {
            curve: &self.curve,
            white_m,
            height_measured,
            height_offset_m: settings.height_offset_m(&self.identity),
            max_gap_ns: settings.max_gap_ns,
            piece: None,
        })
    }

    /// Bias from the stated accuracy (I129/110), or else from the receiver's configuration.
    pub(super) fn bias(&self, settings: &OperationalSettings) -> Option<TransponderBias> {
        let receiver = settings.transponder(self.sensor)?;
        let share = 1.0 - FRESH_SHARE * FRESH_SHARE;
        let delay_s = settings.delay(&self.identity, &self.kind())?.sigma_s;
        Some(TransponderBias {
            horizontal_m2: self.axis_sigma_m(receiver).powi(2) * share,
            vertical_m2: self.height_sigma_m(receiver).powi(2) * share,
            time_s2: delay_s * delay_s,
        })
    }

    /// Sigma of a position on each axis over ground, metres.
    fn axis_sigma_m(&self, receiver: &settings::ReceiverSettings) -> f64 {
        let stated_m = self.fixes.last().and_then(|fix| fix.accuracy_m);
        // A stated radius contains half of the errors (1.177 sigma). A configured sigma applies to the distance.
        stated_m.map_or(receiver.horizontal_m / SQRT_2, |half_m| half_m / (2.0 * LN_2).sqrt())
    }

    /// Sigma of a height, metres.
    fn height_sigma_m(&self, receiver: &settings::ReceiverSettings) -> f64 {
        self.fixes.last().and_then(|fix| fix.height_sigma_m).unwrap_or(receiver.vertical_m)
    }

    /// Whether the reports state no height, or a coarse one; a radar's height is better.
    pub(super) fn lacks_height(&self) -> bool {
        self.fixes.last().is_some_and(|last| !last.has_fine_height())
    }

    /// Variance of a coarse height, which is not in the filter, m².
    pub(super) fn coarse_height_m2(&self) -> f64 {
        let coarse = self.fixes.last().filter(|fix| fix.height_measured && !fix.has_fine_height());
        coarse.and_then(|fix| fix.height_sigma_m).map_or(0.0, |sigma_m| sigma_m * sigma_m)
    }

    /// Whether a report is ignored because another receiver with far better positions reported last, and is not silent.
    pub(super) fn has_better(&self, fix: &Fix, settings: &OperationalSettings) -> bool {
        let sigma_m = |sensor| settings.transponder(sensor).map(|receiver| receiver.horizontal_m);
        let Some((own_m, other_m)) = sigma_m(self.sensor).zip(sigma_m(fix.sensor)) else { return false };
        let last = self.last_heard();
        other_m > POORER * own_m
            && last.is_some_and(|last| fix.time.seconds_since(last).abs() <= TRANSPONDER_SILENT_S)
    }

    /// Whether a report or one of the last seconds before it states a height; reports may alternate between heights and none.
    fn states_height(&self, index: usize) -> bool {
        let Some(last) = self.fixes.get(index) else { return false };
        let mut lately = self.fixes[..=index]
            .iter()
            .rev()
            .take_while(|fix| last.time.seconds_since(fix.time) <= HEIGHT_KEPT_S);
        lately.any(|fix| fix.height_measured)
    }

    /// Contribution to a point of a slot that ends at `end`.
    pub(super) fn part(&self, end: Time) -> Option<TransponderPart> {
        let heard = self.fixes.partition_point(|fix| fix.time < end).checked_sub(1);
        Some(TransponderPart {
            number: self.numbered?.number,
            identity: self.identity,
            sensor: heard.map_or(self.sensor, |index| self.fixes[index].sensor),
            time: heard.map(|index| self.fixes[index].time),
            items: self.items,
            aircraft: self.aircraft,
            // Before the first report, the height of that report is published.
            height_measured: self.states_height(heard.unwrap_or(0)),
        })
    }
}
