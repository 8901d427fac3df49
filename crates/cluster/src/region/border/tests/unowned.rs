//! Aircraft without an owner are found anywhere and are not published twice.

use std::collections::BTreeSet;

use super::*;
use crate::region::test_tracks::{BORDER, track};
use fusion::Settings;
use fusion::slots::SlotGrid;

/// Ids under which an aircraft is published, slot by slot. `sees_from` states from which slots on the engines of the western and
/// the eastern cell see it; a message takes `delay` slots.
fn published(
    sees_from: [i64; 2],
    delay: i64,
    slots: i64,
    east_m: impl Fn(i64) -> f64,
) -> Vec<BTreeSet<String>> {
    let names = ["n512-e0043", "n512-e0044"].map(cell_name);
    let mut borders = names.clone().map(|name| {
        let territory = Territory::grid(0.1).unwrap();
        Border::new(Region::new(territory, names.to_vec(), name, 1000.0, 150.0).unwrap())
    });
    for (border, first) in borders.iter_mut().zip([4096, 4160]) {
        border.state.numbers.add_block(first);
    }
    let engine = Engine::new(Settings::default()).unwrap();
    let frame = TangentPlane::at_site(Geodetic::from_degrees(51.25, BORDER, 0.0));
    let mut in_transit: Vec<(i64, CellMessage)> = Vec::new();
    let slot = |at| {
        let (now, later) = in_transit.drain(..).partition(|(due, _): &(i64, CellMessage)| *due <= at);
        in_transit = later;
        let mut ids = BTreeSet::new();
        for (index, border) in borders.iter_mut().enumerate() {
            let now: &Vec<(i64, CellMessage)> = &now;
            now.iter().filter(|(_, message)| message.to == names[index]).for_each(|(_, message)| {
                border.handle_message(message);
            });
            let since = Slot(sees_from[index]);
            let seen = (at >= since.0).then(|| track(7 + index as u32, since, Slot(at), east_m(at)));
            let mut picture = Picture {
                slot: Slot(at),
                time: SlotGrid::default().centre(Slot(at)),
                tracks: seen.into_iter().collect(),
                concerns: Vec::new(),
                resolved: Vec::new(),
            };
            let view = EngineView { engine: &engine, frame: &frame };
            let messages = border.publish(&mut picture, None, &view, Vec::new());
            in_transit.extend(messages.into_iter().map(|message| (at + delay, message)));
            ids.extend(picture.tracks.into_iter().filter_map(|track| track.id));
        }
        ids
    };
    (0..slots).map(slot).collect()
}

/// Number of slots in which no cell published it, and all its ids.
fn of(published: &[BTreeSet<String>]) -> (usize, BTreeSet<&String>) {
    let missing = published.iter().filter(|ids| ids.is_empty()).count();
    (missing, published.iter().flatten().collect())
}

#[test]
fn unowned_aircraft_near_a_border_is_soon_published() {
    // The eastern cell has seen it west of the border, where the engine of the western cell never does.
    let found = published([i64::MAX, 0], 1, 120, |at| if at < 20 { -30.0 } else { 60.0 });
    let (missing, ids) = of(&found);
    assert_eq!(ids.len(), 1, "{found:?}");
    assert!(missing <= 20 + 24, "{missing}");
    // The aircraft moves back and forth on the border.
    for from in [[0, i64::MAX], [i64::MAX, 0]] {
        let found = published(from, 1, 120, |at| if at / 3 % 2 == 0 { -2.0 } else { 2.0 });
        let (missing, ids) = of(&found);
        assert!(ids.len() == 1 && missing <= 32, "{found:?}");
    }
}

#[test]
fn owned_aircraft_near_a_border_keeps_its_owner() {
    for delay in [1, 2, 6] {
        // Started in the west, a minute just inside the east, then farther away.
        let found = published([0, 0], delay, 400, |at| match at {
            ..20 => -30.0,
            20..260 => 100.0,
            260.. => 100.0 + 2.0 * (at - 260) as f64,
        });
        let (missing, ids) = of(&found);
        assert!(missing == 0 && ids.len() == 1, "{delay}: {found:?}");
        assert!(found.iter().all(|ids| ids.len() == 1), "{delay}");
    }
}

#[test]
fn mutual_question_starts_the_aircraft_in_one_cell() {
    // Each cell has seen it only inside the other cell.
    let found = published([1, 0], 1, 200, |at| match at {
        0 => -10.0,
        1 => 10.0,
        _ if at / 3 % 2 == 0 => -2.0,
        _ => 2.0,
    });
    let (missing, ids) = of(&found);
    assert!(ids.len() == 1 && missing <= 40, "{found:?}");
}
