//! The latest reports of the sensors, for readers that show them beside the picture. Where nobody asks, nothing is kept,
//! and the engine's thread looks at one number per report.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use fusion::Report;

/// Most reports kept: some seconds of the busiest site.
const KEPT: usize = 20_000;
/// Reports are kept for this long after somebody asked, seconds.
const FORGET_S: u32 = 10;

/// The last reports that the engine took, each with its number.
#[derive(Debug)]
pub struct Inputs {
    /// Seconds since somebody asked, up to [`FORGET_S`]: then nothing is kept.
    unasked_s: AtomicU32,
    memory: Mutex<Memory>,
}

#[derive(Debug, Default)]
struct Memory {
    reports: VecDeque<Report>,
    /// Of the newest report; the first is 1.
    last: u64,
}

impl Default for Inputs {
    fn default() -> Self {
        Self { unasked_s: AtomicU32::new(FORGET_S), memory: Mutex::default() }
    }
}

impl Inputs {
    /// Keeps a report, if somebody asks for them. Never waits: while a reader holds the lock, the report is left out.
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

    /// The reports that are kept and came after that number, and the number of the newest; from now on they are kept.
    pub fn after(&self, number: u64) -> (Vec<Report>, u64) {
        self.unasked_s.store(0, Ordering::Relaxed);
        let Ok(memory) = self.memory.lock() else { return (Vec::new(), number) };
        let new = usize::try_from(memory.last.saturating_sub(number)).unwrap_or(usize::MAX);
        let old = memory.reports.len().saturating_sub(new);
        (memory.reports.range(old..).copied().collect(), memory.last)
    }

    /// To be called once a second, so that nothing is kept when nobody asks any more.
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
    fn only_who_asks_has_them_kept_and_no_longer_than_that() {
        let inputs = Inputs::default();
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
