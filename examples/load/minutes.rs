//! Figures of a run for each minute: a table, and a figure of it.

use std::fmt::Write as _;
use std::fs;
use std::time::Duration;

use fusion::time::Time;
use utm_fusion::evaluate::plot::curves::{Panel, panels};

use crate::output::LatenessByTime;
use crate::stage::{LoadResult, ResourceUse};

/// Interval between samples.
pub const EVERY: Duration = Duration::from_secs(60);

/// Resources of the service at one time.
#[derive(Clone, Copy, Debug)]
pub struct ResourceSample {
    pub at: Time,
    pub used: ResourceUse,
    /// Number of open files, sockets and timers.
    pub open: usize,
    /// Size of its recordings and its state, octets.
    pub on_disk: u64,
}

/// One minute of a run.
struct LoadMinute {
    /// Time of its end since the first sample, hours.
    at_h: f64,
    /// Anonymous memory, MiB.
    memory_mib: f64,
    open: usize,
    disk_mib: f64,
    /// Share of one core.
    processor: f64,
    /// Largest lateness of a slot and of the current picture, milliseconds.
    late_ms: f64,
    now_late_ms: f64,
    slots: usize,
}

const HEAD: &str = "hour,memory_mib,open_files,disk_mib,processor,slot_late_ms,now_late_ms,slots\n";

/// Writes `target/load-SCENARIO.csv` and `.svg`.
pub fn report(
    scenario: &str,
    samples: &[ResourceSample],
    slots: &LatenessByTime,
    of_now: &LatenessByTime,
) -> LoadResult<()> {
    let minutes: Vec<LoadMinute> =
        samples.windows(2).map(|pair| minute(samples, pair, slots, of_now)).collect();
    let mut table = HEAD.to_owned();
    for minute in &minutes {
        let LoadMinute { at_h, memory_mib, open, disk_mib, processor, late_ms, now_late_ms, slots } = minute;
        writeln!(
            table,
            "{at_h:.3},{memory_mib:.1},{open},{disk_mib:.1},{processor:.3},{late_ms:.2},{now_late_ms:.2},{slots}"
        )?;
    }
    let path = format!("target/load-{scenario}");
    fs::write(format!("{path}.csv"), table)?;
    let panel = |label, of: fn(&LoadMinute) -> f64| {
        Panel::from_zero(label, minutes.iter().map(|minute| (minute.at_h, of(minute))).collect())
    };
    let figure = panels(
        "load",
        "A site in real time, minute by minute",
        "Memory of the service, files and sockets that it has open, its recordings and state on the disk, the latest slot of each minute.",
        "Hours",
        &[
            panel("Memory (MiB)", |minute| minute.memory_mib),
            panel("Open files", |minute| minute.open as f64),
            panel("On the disk (MiB)", |minute| minute.disk_mib),
            panel("Latest slot (ms)", |minute| minute.late_ms),
        ],
    );
    fs::write(format!("{path}.svg"), figure.svg)?;
    println!("{path}.csv, {path}.svg");
    Ok(())
}

fn minute(
    all: &[ResourceSample],
    pair: &[ResourceSample],
    slots: &LatenessByTime,
    of_now: &LatenessByTime,
) -> LoadMinute {
    let (from, to) = (pair[0], pair[1]);
    let most_ms = |lateness: &LatenessByTime| 1e3 * lateness.between(from.at, to.at).fold(0.0, f64::max);
    LoadMinute {
        at_h: to.at.seconds_since(all[0].at) / 3600.0,
        memory_mib: to.used.anonymous as f64 / f64::from(1 << 20),
        open: to.open,
        disk_mib: to.on_disk as f64 / f64::from(1 << 20),
        processor: (to.used.processor_s - from.used.processor_s) / to.at.seconds_since(from.at),
        late_ms: most_ms(slots),
        now_late_ms: most_ms(of_now),
        slots: slots.between(from.at, to.at).count(),
    }
}
