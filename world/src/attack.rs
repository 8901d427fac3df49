//! Attacks on transponders: what becomes of the reports of one that lies. Truth stays what it is.

use nalgebra::Vector3;

use crate::scenario::{Attack, Span, Transponder};
use crate::transponder::TransponderReport;

/// What is done to a transponder, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lie {
    /// What.
    pub attack: Attack,
    /// From when to when, by the time of measurement, s since take-off.
    pub span: Span,
    /// Unit vector over ground in which a false position lies.
    pub away: Vector3<f64>,
    /// Reports follow each other so far apart, seconds.
    pub period_s: f64,
}

impl Lie {
    /// What is sent instead of the honest reports of one drone, in order of measurement. [`Attack::Swapped`] takes two drones:
    /// see [`swap`].
    pub fn apply(&self, model: &Transponder, honest: Vec<TransponderReport>) -> Vec<TransponderReport> {
        match self.attack {
            Attack::Drift => self.each(honest, |report| {
                let share = (report.measured_s - self.span.low) / model.spoof_drift_s;
                report.position += self.away * (model.spoof_drift_m * share.min(1.0));
                if share < 1.0 {
                    report.velocity += self.away * (model.spoof_drift_m / model.spoof_drift_s);
                }
            }),
            Attack::Jump => self.each(honest, |report| report.position += self.away * model.spoof_drift_m),
            Attack::Time => self.each(honest, |report| {
                report.stamped_s += model.time_shift_s;
                report.arrives_s += model.time_shift_s.max(0.0);
            }),
            Attack::Frozen => {
                let last = honest.iter().rfind(|report| report.measured_s < self.span.low).copied();
                self.each(honest, |report| {
                    if let Some(last) = last {
                        (report.position, report.velocity) = (last.position, last.velocity);
                    }
                })
            }
            Attack::Replay => self.replay(model.replay_s, &honest),
            Attack::Duplicate => self.duplicate(model.duplicate_m, honest),
            Attack::Swapped => honest,
        }
    }

    /// Whether it lies then.
    fn holds(&self, report: &TransponderReport) -> bool {
        (self.span.low..self.span.high).contains(&report.measured_s)
    }

    /// With each report changed while it lies.
    fn each(
        &self,
        mut reports: Vec<TransponderReport>,
        change: impl Fn(&mut TransponderReport),
    ) -> Vec<TransponderReport> {
        reports.iter_mut().filter(|report| self.holds(report)).for_each(change);
        reports
    }

    /// The reports of the last `back_s` seconds before it again and again, instead of its own.
    fn replay(&self, back_s: f64, honest: &[TransponderReport]) -> Vec<TransponderReport> {
        let end_s = honest.last().map_or(0.0, |last| last.measured_s.min(self.span.high));
        let before = |report: &&TransponderReport| {
            (self.span.low - back_s..self.span.low).contains(&report.measured_s)
        };
        let heard: Vec<&TransponderReport> = honest.iter().filter(before).collect();
        let rounds = ((end_s - self.span.low) / back_s).ceil().max(0.0) as usize;
        let again = (1..=rounds).flat_map(|round| {
            let shift_s = round as f64 * back_s;
            heard.iter().map(move |&&report| TransponderReport {
                measured_s: report.measured_s + shift_s,
                stamped_s: report.stamped_s + shift_s,
                arrives_s: report.arrives_s + shift_s,
                is_own: false,
                ..report
            })
        });
        let mut reports: Vec<TransponderReport> =
            honest.iter().filter(|report| !self.holds(report)).copied().collect();
        reports.extend(again.filter(|report| report.measured_s < end_s));
        reports.sort_by(|a, b| a.measured_s.total_cmp(&b.measured_s));
        reports
    }

    /// A second transmitter of the same identity flies beside it, `away_m` away, and reports between its reports.
    fn duplicate(&self, away_m: f64, honest: Vec<TransponderReport>) -> Vec<TransponderReport> {
        let second = |report: &TransponderReport| {
            let later_s = self.period_s / 2.0;
            TransponderReport {
                measured_s: report.measured_s + later_s,
                stamped_s: report.stamped_s + later_s,
                arrives_s: report.arrives_s + later_s,
                position: report.position + report.velocity * later_s + self.away * away_m,
                is_own: false,
                ..*report
            }
        };
        let mut reports = honest;
        let others: Vec<TransponderReport> =
            reports.iter().filter(|report| self.holds(report)).map(second).collect();
        reports.extend(others);
        reports.sort_by(|a, b| a.measured_s.total_cmp(&b.measured_s));
        reports
    }
}

/// Two transponders send each other's identity within the span.
pub fn swap(span: Span, one: &mut [TransponderReport], other: &mut [TransponderReport]) {
    let identity = |reports: &[TransponderReport]| reports.first().map(|report| report.identity);
    let (Some(first), Some(second)) = (identity(one), identity(other)) else { return };
    let change = |reports: &mut [TransponderReport], identity: usize| {
        let within = |report: &&mut TransponderReport| (span.low..span.high).contains(&report.measured_s);
        reports.iter_mut().filter(within).for_each(|report| report.identity = identity);
    };
    change(one, second);
    change(other, first);
}
