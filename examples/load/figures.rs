//! Figures of a run, and the requirements that they miss.

use std::fmt;
use std::time::Duration;

use serde_json::{Value, json};

use crate::readers::ReaderResult;
use crate::stage::ResourceUse;

/// Measurements of a run.
pub struct LoadFigures {
    /// Duration of the measurement.
    pub measured: Duration,
    /// Lateness of slots at a member of the output's multicast group.
    pub lateness: DelayQuantiles,
    /// Lateness of the current picture at a member of its multicast group.
    pub now: DelayQuantiles,
    /// Lateness of a thread that only sleeps until each slot is due.
    pub timer: DelayQuantiles,
    /// Result of each reader.
    pub read: Vec<ReaderResult>,
    /// Whether each reader asked for every slot.
    pub whole: bool,
    /// Number of single requests.
    pub polled: u64,
    /// Resources of the service at the beginning, in the middle and at the end.
    pub use_s: [ResourceUse; 3],
    /// Maximum memory of the service at any time, including mapped files, octets.
    pub most_memory: u64,
    /// Metrics of the service at the beginning and at the end.
    pub metrics: [String; 2],
}

/// Quantiles of a set of times in seconds.
pub struct DelayQuantiles {
    count: usize,
    /// Median, 99th and 99.9th percentile, maximum.
    values: [f64; 4],
}

impl DelayQuantiles {
    /// Quantiles of these times.
    pub fn of(seconds: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = seconds.collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        let at = |share: f64| sorted.get((share * last as f64).ceil() as usize).copied().unwrap_or(f64::NAN);
        Self { count: sorted.len(), values: [0.5, 0.99, 0.999, 1.0].map(at) }
    }

    /// The 99th percentile.
    pub fn p99_s(&self) -> f64 {
        self.values[1]
    }

    /// The maximum.
    pub fn most_s(&self) -> f64 {
        self.values[3]
    }

    /// Milliseconds, by name.
    fn to_json(&self) -> Value {
        let [median, p99, p999, max] = self.values.map(|seconds| seconds * 1e3);
        json!({ "median": median, "p99": p99, "p99.9": p999, "max": max, "count": self.count })
    }

    /// Number of values.
    pub fn count(&self) -> usize {
        self.count
    }
}

impl fmt::Display for DelayQuantiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, p99, p999, most] = self.values.map(|seconds| seconds * 1e3);
        write!(f, "{median:8.2} {p99:8.2} {p999:8.2} {most:8.2}   of {}", self.count)
    }
}

impl LoadFigures {
    fn counted(&self, name: &str) -> f64 {
        counted(&self.metrics[1], name)
    }

    /// Number of slots that the service published during the measurement. Slots without aircraft are not sent.
    fn published(&self) -> f64 {
        let [before, after] =
            self.metrics.each_ref().map(|metrics| counted(metrics, "utm_fusion_slots_published_total"));
        after - before
    }

    fn delays(&self) -> DelayQuantiles {
        DelayQuantiles::of(
            self.read.iter().flat_map(|read| &read.delays_s).map(|&delay_s| f64::from(delay_s)),
        )
    }

    fn sum(&self, of: impl Fn(&ReaderResult) -> u64) -> u64 {
        self.read.iter().map(of).sum()
    }

    /// JSON for other programs, in milliseconds and MiB.
    pub fn to_json(&self) -> Value {
        let [.., last] = self.use_s;
        json!({
            "measured_s": self.measured.as_secs_f64(),
            "lateness_ms": self.lateness.to_json(),
            "now_ms": self.now.to_json(),
            "timer_ms": self.timer.to_json(),
            "lateness_beyond_timer_p99.9_ms": (self.lateness.values[2] - self.timer.values[2]) * 1e3,
            "now_beyond_timer_p99.9_ms": (self.now.values[2] - self.timer.values[2]) * 1e3,
            "memory_mib": mib(last.anonymous),
            "resident_mib": mib(last.resident),
            "most_resident_mib": mib(self.most_memory),
        })
    }

    /// Requirements that are missed; `late_s` is the maximum lateness in seconds, `growth` the maximum ratio of memory.
    pub fn missed(&self, late_s: f64, growth: f64) -> Vec<String> {
        let mut missed = Vec::new();
        let mut must = |holds: bool, miss: &str| {
            if !holds {
                missed.push(miss.to_owned());
            }
        };
        must(self.lateness.values[2] <= late_s, "slots were too late");
        must(self.now.values[2] <= late_s, "pictures of now were too late");
        // All slots of the measurement, except those at its ends.
        must(self.published() >= 4.0 * self.measured.as_secs_f64() - 2.0, "slots were not published");
        must(self.counted("utm_fusion_line_kernel_dropped_total") == 0.0, "the kernel dropped datagrams");
        must(self.counted("utm_fusion_line_queue_full_total") == 0.0, "the queue was full");
        must(self.counted("utm_fusion_failed_sends_total") == 0.0, "sends failed");
        // The history's cache fills during the first half.
        let [_, middle, last] = self.use_s;
        must(last.anonymous as f64 <= growth * middle.anonymous as f64, "memory grew");
        let failed: Vec<&String> = self.read.iter().filter_map(|read| read.failed.as_ref()).collect();
        let first = failed.first().map_or("", |why| why.as_str());
        must(failed.is_empty(), &format!("{} readers failed, the first: {first}", failed.len()));
        if self.whole {
            must(self.sum(|read| read.missing) == 0, "readers missed slots without being told");
            let fewest = self.read.iter().map(|read| read.slots).min().unwrap_or(0);
            must(fewest as f64 >= 4.0 * self.measured.as_secs_f64(), "a reader got too few slots");
        }
        missed
    }
}

/// Sum of the counters with that name.
fn counted(metrics: &str, name: &str) -> f64 {
    let is_one = |line: &&str| line.starts_with(name) && !line.starts_with('#');
    let values =
        metrics.lines().filter(is_one).filter_map(|line| line.rsplit(' ').next()?.parse::<f64>().ok());
    values.sum()
}

fn mib(octets: u64) -> f64 {
    octets as f64 / f64::from(1 << 20)
}

impl fmt::Display for LoadFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, middle, last] = self.use_s;
        let share = |from: ResourceUse, to: ResourceUse| {
            100.0 * (to.processor_s - from.processor_s) / (to.at - from.at).as_secs_f64()
        };
        writeln!(f, "measured for                      {} s", self.measured.as_secs())?;
        writeln!(f, "milliseconds                        median      p99    p99.9      max")?;
        writeln!(f, "slot at a member of the group     {}", self.lateness)?;
        writeln!(f, "picture of now                    {}", self.now)?;
        writeln!(f, "idle timer of the same run        {}", self.timer)?;
        let beyond_ms = (self.lateness.values[2] - self.timer.values[2]) * 1e3;
        writeln!(f, "slot beyond the timer, p99.9      {beyond_ms:8.2}")?;
        let beyond_ms = (self.now.values[2] - self.timer.values[2]) * 1e3;
        writeln!(f, "now beyond the timer, p99.9       {beyond_ms:8.2}")?;
        writeln!(f, "published to read, all readers    {}", self.delays())?;
        writeln!(
            f,
            "readers                           {}: {} events, {:.1} MB, {} resyncs, {} slots missing",
            self.read.len(),
            self.sum(|read| read.slots),
            self.sum(|read| read.octets) as f64 * 1e-6,
            self.sum(|read| read.resyncs),
            if self.whole {
                self.sum(|read| read.missing).to_string()
            } else {
                "(not each wanted)".to_owned()
            },
        )?;
        writeln!(f, "slots published                   {}", self.published())?;
        writeln!(f, "pictures asked for                {}", self.polled)?;
        writeln!(f, "tracks in the last slot           {}", self.counted("utm_fusion_tracks "))?;
        for (what, name) in [
            ("datagrams received", "utm_fusion_datagrams_received_total"),
            ("dropped by the kernel", "utm_fusion_line_kernel_dropped_total"),
            ("dropped by the queue", "utm_fusion_line_queue_full_total"),
        ] {
            writeln!(f, "{what:33} {}", self.counted(name))?;
        }
        writeln!(
            f,
            "service, of one core              {:.1} % and {:.1} % (first and second half)",
            share(first, middle),
            share(middle, last)
        )?;
        let memory = [first, middle, last].map(|used| mib(used.anonymous));
        writeln!(f, "most at any time                  {:.1} MiB with mapped files", mib(self.most_memory))?;
        write!(
            f,
            "its memory, begin, middle, end    {:.1}, {:.1}, {:.1} MiB of its own ({:.1} MiB with mapped files)",
            memory[0],
            memory[1],
            memory[2],
            mib(last.resident)
        )
    }
}
