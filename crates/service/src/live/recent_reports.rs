//! Latest reports of the sensors, for readers that show them beside the picture. Without requests no reports are kept, and
//! the engine's thread reads one number per report.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use fusion::Report;

/// Maximum number of reports kept: some seconds at the busiest site.
const KEPT: usize = 20_000;
/// Time for which reports are kept after the last request, in seconds.
const FORGET_S: u32 = 10;

/// Latest reports that the engine accepted, each with a number.
#[derive(Debug)]
pub struct RecentReports {
    /// Seconds since the last request, up to [`FORGET_S`]; then no reports are kept.
    unasked_s: AtomicU32,
    memory: Mutex<ReportBuffer>,
}

#[derive(Debug, Default)]
struct ReportBuffer {
    reports: VecDeque<Report>,
    /// Number of the newest report; the first is 1.
    last: u64,
}

impl Default for RecentReports {
    fn default() -> Self {
        Self { unasked_s: AtomicU32::new(FORGET_S), memory: Mutex::default() }
    }
}

impl RecentReports {
    /// Keeps a report if there are requests. Never waits: while a reader holds the lock, the report is left out.
    pub fn note(&self, report: &Report) {
        if self.unasked_s.load(Ordering::Relaxed) >= FORGET_S {
            return;
        }
        if let Ok(mut memory) = self.memory.try_lock() {
            if memory.reports.len() == KEPT {
                memory.reports.pop_front();
            }
            memory.reports.push_back(*report);
            memory.last += 1;
        }
    }

    /// Kept reports with a greater number, and the number of the newest. Counts as a request.
    pub fn after(&self, number: u64) -> (Vec<Report>, u64) {
        self.unasked_s.store(0, Ordering::Relaxed);
        let Ok(memory) = self.memory.lock() else { return (Vec::new(), number) };
        let new = usize::try_from(memory.last.saturating_sub(number)).unwrap_or(usize::MAX);
        let old = memory.reports.len().saturating_sub(new);
        (memory.reports.range(old..).copied().collect(), memory.last)
    }

    /// Advances the time since the last request; to be called once a second.
    pub fn second_passed(&self) {
        let unasked_s = self.unasked_s.load(Ordering::Relaxed);
        if unasked_s < FORGET_S {
            self.unasked_s.store(unasked_s + 1, Ordering::Relaxed);
        } else if let Ok(mut memory) = self.memory.lock() {
            memory.reports = VecDeque::new();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::Time;
    use fusion::{Enu, Plot, RadarTrackKey, SensorIndex};

    fn report(second: i64) -> Report {
        Report::Plot(Plot {
            track: RadarTrackKey { sensor: SensorIndex(0), number: 7 },
            time: Time::from_nanos(second),
            position: Enu::new(0.0, 0.0, 0.0),
            height_measured: false,
            slant_range_m: 0.0,
            uav_probability: None,
            velocity: None,
        })
    }

    #[test]
    fn reports_are_kept_only_while_requested() {
        let inputs = RecentReports::default();
        inputs.note(&report(1));
        assert_eq!(inputs.after(0), (vec![], 0), "nobody had asked");
        inputs.note(&report(2));
        inputs.note(&report(3));
        assert_eq!(inputs.after(0), (vec![report(2), report(3)], 2));
        assert_eq!(inputs.after(1), (vec![report(3)], 2));
        assert_eq!(inputs.after(9), (vec![], 2), "of another run of the service");
        for _ in 0..=FORGET_S {
            inputs.second_passed();
        }
        inputs.note(&report(4));
        assert_eq!(inputs.after(0), (vec![], 2), "nobody had asked for a while");
        for second in 0..=KEPT as i64 {
            inputs.note(&report(second));
        }
        assert_eq!(inputs.after(2).0.len(), KEPT);
    }
}
