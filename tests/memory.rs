//! Memory does not grow with the length of a replay.

mod traffic;

use peak_alloc::PeakAlloc;
use traffic::{SLOT_NS, Traffic, feed};
use utm_fusion::fusion::Engine;
use utm_fusion::time::SECOND;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

#[test]
fn twenty_minutes_take_the_memory_of_two() {
    let mut engine = Engine::new(Traffic::DENSE.settings());
    let mut fly = |from_s: i64, to_s: i64| {
        MEMORY.reset_peak_usage();
        let slots = from_s * SECOND / SLOT_NS..to_s * SECOND / SLOT_NS;
        let points: usize = slots.map(|slot| feed(&mut engine, slot, Traffic::DENSE.reports(slot))).sum();
        (points, MEMORY.current_usage(), MEMORY.peak_usage())
    };
    // The traffic repeats itself every two minutes; only the errors of the radar differ.
    let (points, live, peak) = fly(0, 120);
    let (later_points, later_live, later_peak) = fly(120, 1200);
    println!("after 2 min: {points} points, {live} bytes, peak {peak}");
    println!("after 20 min: {later_points} more, {later_live} bytes, peak {later_peak}");
    assert!(points > 50_000 && later_points > 9 * 50_000);
    // A vector that doubles once more; a growth of a byte for every report would be 25 times this.
    assert!(later_live <= live + 20_000, "{live} then {later_live} bytes");
    assert!(later_peak <= peak + 20_000, "{peak} then {later_peak} bytes");
}
