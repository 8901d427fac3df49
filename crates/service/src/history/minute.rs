//! Encoding of a minute of history by track and column. For aircraft in steady flight little data remains.

use serde::{Deserialize, Serialize};

use super::HistoryTrack;
use super::codec::{self, Units};

/// Rows of a track within a minute.
#[derive(Debug, Default, Serialize, Deserialize)]
struct TrackColumns {
    /// Alternating numbers of the minute's pictures without and with the track.
    runs: Vec<u16>,
    /// Values that seldom change: number of equal rows, with their [`Units::kind`] and number.
    alike: Vec<(u16, u8, u32)>,
    /// Second differences of the latitudes, in 1e-7 degrees.
    latitudes: Vec<i64>,
    /// Second differences of the longitudes, in 1e-7 degrees.
    longitudes: Vec<i64>,
    /// Second differences of the heights, in centimetres, for the rows with a height.
    heights: Vec<i64>,
}

/// Differences of numbers from the linear extrapolation of the two before them.
pub(super) fn bends(numbers: impl Iterator<Item = i64>) -> Vec<i64> {
    let (mut last, mut step) = (0_i64, 0_i64);
    let bend = |(index, number): (usize, i64)| {
        let left = number.wrapping_sub(last.wrapping_add(step));
        // The first number sets the position, but no step.
        step = if index == 0 { 0 } else { number.wrapping_sub(last) };
        last = number;
        left
    };
    numbers.enumerate().map(bend).collect()
}

/// Inverse of [`bends`].
pub(super) fn straightened(bends: &[i64]) -> impl Iterator<Item = i64> {
    let (mut last, mut step) = (0_i64, 0_i64);
    bends.iter().enumerate().map(move |(index, bend)| {
        let number = last.wrapping_add(step).wrapping_add(*bend);
        step = if index == 0 { 0 } else { number.wrapping_sub(last) };
        last = number;
        number
    })
}

/// Encodes a track's rows in order, each with the index of its picture within the minute.
pub(super) fn octets(rows: &[(usize, &HistoryTrack)]) -> Vec<u8> {
    let mut columns = TrackColumns::default();
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

/// Inverse of [`octets`]; `None` for invalid octets.
pub(super) fn rows(id: &str, octets: &[u8]) -> Option<Vec<(usize, HistoryTrack)>> {
    let columns: TrackColumns = postcard::from_bytes(octets).ok()?;
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
