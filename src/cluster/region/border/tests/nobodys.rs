//! Whoever nobody publishes is found wherever that is, and nobody twice.

use std::collections::BTreeSet;

use super::*;
use crate::cluster::region::made::{BORDER, track};
use fusion::Settings;
use fusion::slots::SlotGrid;

/// The ids under which an aircraft is published, slot by slot, where the engines of the western and the eastern cell see it from
/// these slots on; a letter takes so many slots.
fn published(
    sees_from: [i64; 2],
    delay: i64,
    slots: i64,
    east_m: impl Fn(i64) -> f64,
) -> Vec<BTreeSet<String>> {
    let names = ["n512-e0043", "n512-e0044"].map(named);
    let mut borders = names.clone().map(|name| {
        let territory = Territory::grid(0.1).unwrap();
        Border::new(Region::new(territory, names.to_vec(), name, 1000.0, 150.0).unwrap())
    });
    for (border, first) in borders.iter_mut().zip([4096, 4160]) {
        border.state.numbers.add_block(first);
    }
    let engine = Engine::new(Settings::default()).unwrap();
    let frame = TangentPlane::at_site(Geodetic::from_degrees(51.25, BORDER, 0.0));
    let mut mail: Vec<(i64, Letter)> = Vec::new();
    let slot = |at| {
        let (now, later) = mail.drain(..).partition(|(due, _): &(i64, Letter)| *due <= at);
        mail = later;
        let mut ids = BTreeSet::new();
        for (index, border) in borders.iter_mut().enumerate() {
            let now: &Vec<(i64, Letter)> = &now;
            now.iter().filter(|(_, letter)| letter.to == names[index]).for_each(|(_, letter)| {
                border.letter(letter);
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
            let view = View { engine: &engine, frame: &frame };
            let letters = border.turn(&mut picture, None, &view, Vec::new());
            mail.extend(letters.into_iter().map(|letter| (at + delay, letter)));
            ids.extend(picture.tracks.into_iter().filter_map(|track| track.id));
        }
        ids
    };
    (0..slots).map(slot).collect()
}

/// The slots in which nobody published it, and all its ids.
fn of(published: &[BTreeSet<String>]) -> (usize, BTreeSet<&String>) {
    let missing = published.iter().filter(|ids| ids.is_empty()).count();
    (missing, published.iter().flatten().collect())
}

#[test]
fn who_is_nobodys_near_a_border_is_published_soon() {
    // The eastern cell has seen it west of the border, where the engine of the western cell never does.
    let found = published([i64::MAX, 0], 1, 120, |at| if at < 20 { -30.0 } else { 60.0 });
    let (missing, ids) = of(&found);
    assert_eq!(ids.len(), 1, "{found:?}");
    assert!(missing <= 20 + 24, "{missing}");
    // The same on the border, back and forth.
    for from in [[0, i64::MAX], [i64::MAX, 0]] {
        let found = published(from, 1, 120, |at| if at / 3 % 2 == 0 { -2.0 } else { 2.0 });
        let (missing, ids) = of(&found);
        assert!(ids.len() == 1 && missing <= 32, "{found:?}");
    }
}

#[test]
fn who_is_somebodys_near_a_border_stays_that_ones() {
    for delay in [1, 2, 6] {
        // Born in the west, for a minute just inside the east, and farther on.
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
fn where_both_cells_ask_one_begins_it() {
    // Either has seen it only where it was the other's.
    let found = published([1, 0], 1, 200, |at| match at {
        0 => -10.0,
        1 => 10.0,
        _ if at / 3 % 2 == 0 => -2.0,
        _ => 2.0,
    });
    let (missing, ids) = of(&found);
    assert!(ids.len() == 1 && missing <= 40, "{found:?}");
}
