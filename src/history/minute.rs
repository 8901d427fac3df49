//! A minute of history, track by track and column by column: of what flies evenly little is left to be written down.

use serde::{Deserialize, Serialize};

use super::SavedTrack;
use super::codec::{self, Units};

/// Where a track was within a minute.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Columns {
    /// How many of the minute's pictures it is not in, how many then it is in, and so on.
    runs: Vec<u16>,
    /// What seldom changes: how many rows are alike, and [`Units::kind`] and the number of these.
    alike: Vec<(u16, u8, u32)>,
    /// 1e-7 degrees.
    latitudes: Vec<i64>,
    /// 1e-7 degrees.
    longitudes: Vec<i64>,
    /// Centimetres, of the rows that have a height.
    heights: Vec<i64>,
}

/// What is left of numbers that go on as the two before them did.
pub(super) fn bends(numbers: impl Iterator<Item = i64>) -> Vec<i64> {
    let (mut last, mut step) = (0_i64, 0_i64);
    let bend = |(index, number): (usize, i64)| {
        let left = number.wrapping_sub(last.wrapping_add(step));
        // The first one says where they begin, and not how they go on.
        step = if index == 0 { 0 } else { number.wrapping_sub(last) };
        last = number;
        left
    };
    numbers.enumerate().map(bend).collect()
}

/// The inverse.
pub(super) fn straightened(bends: &[i64]) -> impl Iterator<Item = i64> {
    let (mut last, mut step) = (0_i64, 0_i64);
    bends.iter().enumerate().map(move |(index, bend)| {
        let number = last.wrapping_add(step).wrapping_add(*bend);
        step = if index == 0 { 0 } else { number.wrapping_sub(last) };
        last = number;
        number
    })
}

/// A track's rows, each with the place of its picture within the minute, in order.
pub(super) fn octets(rows: &[(usize, &SavedTrack)]) -> Vec<u8> {
    let mut columns = Columns::default();
    let mut next = 0;
    for &(place, _) in rows {
        match columns.runs.last_mut() {
            Some(run) if place == next => *run += 1,
            _ => columns.runs.extend([(place - next) as u16, 1]),
        }
        next = place + 1;
    }
    let units: Vec<Units> = rows.iter().map(|(_, track)| codec::units(track)).collect();
    for of in &units {
        match columns.alike.last_mut() {
            Some((count, kind, number)) if (*kind, *number) == (of.kind(), of.number) => *count += 1,
            _ => columns.alike.push((1, of.kind(), of.number)),
        }
    }
    columns.latitudes = bends(units.iter().map(|of| of.latitude.into()));
    columns.longitudes = bends(units.iter().map(|of| of.longitude.into()));
    columns.heights = bends(units.iter().filter_map(|of| of.height).map(i64::from));
    postcard::to_stdvec(&columns).expect("numbers can be written down")
}

/// The inverse; `None` for octets of something else.
pub(super) fn rows(id: &str, octets: &[u8]) -> Option<Vec<(usize, SavedTrack)>> {
    let columns: Columns = postcard::from_bytes(octets).ok()?;
    let count: usize = columns.runs.iter().skip(1).step_by(2).copied().map(usize::from).sum();
    if count != columns.latitudes.len() {
        return None;
    }
    let mut places = Vec::with_capacity(count);
    let mut next = 0;
    for run in columns.runs.chunks_exact(2) {
        next += usize::from(run[0]);
        places.extend(next..next + usize::from(run[1]));
        next += usize::from(run[1]);
    }
    let mut alike =
        columns.alike.iter().flat_map(|&(count, kind, number)| (0..count).map(move |_| (kind, number)));
    let mut latitudes = straightened(&columns.latitudes);
    let mut longitudes = straightened(&columns.longitudes);
    let mut heights = straightened(&columns.heights);
    let row = |place| {
        let (kind, number) = alike.next()?;
        let units = Units::of(kind, number, latitudes.next()?, longitudes.next()?, || heights.next())?;
        Some((place, codec::track(id, units)?))
    };
    places.into_iter().map(row).collect()
}
