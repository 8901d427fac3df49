//! Memory does not grow with the length of a replay, in any profile.

mod traffic;

use fusion::time::SECOND;
use fusion::{Engine, Settings};
use peak_alloc::PeakAlloc;
use traffic::{SLOT_NS, Traffic, feed};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Present and maximum memory, in bytes.
#[derive(Clone, Copy, Debug)]
struct Taken {
    live: usize,
    peak: usize,
}

/// Memory of an engine after two minutes of flight, and after `minutes`.
fn fly(settings: Settings, minutes: i64) -> [Taken; 2] {
    let before = MEMORY.current_usage();
    let mut engine = Engine::new(settings).expect("the settings are right");
    // The traffic repeats every two minutes; only the errors of the radar differ.
    [(0, 2), (2, minutes)].map(|(from, to)| {
        MEMORY.reset_peak_usage();
        let slot = |minute: i64| minute * 60 * SECOND / SLOT_NS;
        let points: usize =
            (slot(from)..slot(to)).map(|slot| feed(&mut engine, slot, Traffic::DENSE.reports(slot))).sum();
        let taken = Taken { live: MEMORY.current_usage() - before, peak: MEMORY.peak_usage() - before };
        println!("after {to} minutes: {points} points more, {taken:?}");
        assert!(points as i64 > 10_000 * (to - from), "it publishes what it should");
        taken
    })
}

/// A single test, because memory is measured for the whole process.
#[test]
fn many_minutes_take_the_memory_of_two() {
    println!("reference");
    let [two, twenty] = fly(Traffic::DENSE.reference(), 20);
    // Allows one more doubling of a vector; growth by a byte per report would be 25 times this.
    assert!(twenty.live <= two.live + 20_000 && twenty.peak <= two.peak + 20_000, "{two:?} {twenty:?}");
    println!("operational");
    let [two, ten] = fly(Traffic::DENSE.operational(), 10);
    // Data of a pair remain as long as one of the two does, and the pairs that are near depend on the errors.
    assert!(
        ten.live as f64 <= 1.10 * two.live as f64 && ten.peak as f64 <= 1.10 * two.peak as f64,
        "{two:?} {ten:?}"
    );
}
