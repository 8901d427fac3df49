//! Attacks on transponders: they change the reports and leave the truth unchanged.

use nalgebra::Vector3;

use crate::scenario::{Attack, Span, Transponder};
use crate::transponder_report::TransponderReport;

/// An attack on a transponder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttackInterval {
    /// Kind of attack.
    pub attack: Attack,
    /// Interval of the attack, by time of measurement, seconds since take-off.
    pub span: Span,
    /// Horizontal unit vector from the true to the false position.
    pub away: Vector3<f64>,
    /// Time between two reports, seconds.
    pub period_s: f64,
}

impl AttackInterval {
    /// Replaces the honest reports of one drone, in order of measurement. [`Attack::Swapped`] involves two drones: see
    /// [`swap`].
    pub fn apply(&self, model: &Transponder, honest: Vec<TransponderReport>) -> Vec<TransponderReport> {
        match self.attack {
            Attack::Drift => self.change_active(honest, |report| {
                let share = (report.measured_s - self.span.low) / model.spoof_drift_s;
                report.position += self.away * (model.spoof_drift_m * share.min(1.0));
                if share < 1.0 {
                    report.velocity += self.away * (model.spoof_drift_m / model.spoof_drift_s);
                }
            }),
            Attack::Jump => {
                self.change_active(honest, |report| report.position += self.away * model.spoof_drift_m)
            }
            Attack::Time => self.change_active(honest, |report| {
                report.stamped_s += model.time_shift_s;
                report.arrives_s += model.time_shift_s.max(0.0);
            }),
            Attack::Frozen => {
                let last = honest.iter().rfind(|report| report.measured_s < self.span.low).copied();
                self.change_active(honest, |report| {
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

    /// Whether the attack is active when `report` is measured.
    fn is_active(&self, report: &TransponderReport) -> bool {
        (self.span.low..self.span.high).contains(&report.measured_s)
    }

    /// Changes each report within the interval of the attack.
    fn change_active(
        &self,
        mut reports: Vec<TransponderReport>,
        change: impl Fn(&mut TransponderReport),
    ) -> Vec<TransponderReport> {
        reports.iter_mut().filter(|report| self.is_active(report)).for_each(change);
        reports
    }

    /// Replaces the reports within the interval by those of the last `back_s` seconds before it, repeated.
    fn replay(&self, back_s: f64, honest: &[TransponderReport]) -> Vec<TransponderReport> {
        let end_s = honest.last().map_or(0.0, |last| last.measured_s.min(self.span.high));
        let before = |report: &&TransponderReport| {
            (self.span.low - back_s..self.span.low).contains(&report.measured_s)
        };
        let recorded: Vec<&TransponderReport> = honest.iter().filter(before).collect();
        let rounds = ((end_s - self.span.low) / back_s).ceil().max(0.0) as usize;
        let again = (1..=rounds).flat_map(|round| {
            let shift_s = round as f64 * back_s;
            recorded.iter().map(move |&&report| TransponderReport {
                measured_s: report.measured_s + shift_s,
                stamped_s: report.stamped_s + shift_s,
                arrives_s: report.arrives_s + shift_s,
                is_own: false,
                ..report
            })
        });
        let mut reports: Vec<TransponderReport> =
            honest.iter().filter(|report| !self.is_active(report)).copied().collect();
        reports.extend(again.filter(|report| report.measured_s < end_s));
        reports.sort_by(|a, b| a.measured_s.total_cmp(&b.measured_s));
        reports
    }

    /// Adds reports of a second transmitter with the same identity, `away_m` away and midway in time between the
    /// drone's own.
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
            reports.iter().filter(|report| self.is_active(report)).map(second).collect();
        reports.extend(others);
        reports.sort_by(|a, b| a.measured_s.total_cmp(&b.measured_s));
        reports
    }
}

/// Exchanges the identities of two transponders within the span.
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
