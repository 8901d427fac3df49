//! Folding of pictures into minutes in the database, and reading them again.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use redb::{ReadableTable, ReadableTableMetadata, Table};

use super::{HistoryTrack, MINUTE, codec, cost, minute};
use fusion::time::Time;

/// Table of pictures by time.
type PictureTable<'t> = Table<'t, i64, &'static [u8]>;
/// Table of minutes, by minute and track.
type MinuteTable<'t> = Table<'t, (i64, &'static str), &'static [u8]>;

/// Moves the pictures of a minute to the table of minutes; returns the increase of the size in octets.
pub(super) fn fold(
    minute: i64,
    recent: &mut PictureTable<'_>,
    minutes: &mut MinuteTable<'_>,
) -> Result<i64, redb::Error> {
    let mut grown = 0_i64;
    // A clock that was set back may have written into this minute before.
    let (mut pictures, before) = whole(minutes, minute)?;
    grown -= before as i64;
    let span = minute * MINUTE..(minute + 1) * MINUTE;
    for picture in recent.extract_from_if(span, |_, _| true)? {
        let (time, octets) = picture?;
        grown -= cost("", octets.value()) as i64;
        pictures.insert(time.value(), codec::tracks(octets.value()).unwrap_or_default());
    }
    let mut tracks = BTreeMap::<&str, Vec<(usize, &HistoryTrack)>>::new();
    for (place, picture) in pictures.values().enumerate() {
        picture.iter().for_each(|track| tracks.entry(&track.id).or_default().push((place, track)));
    }
    let times = minute::bends(pictures.keys().map(|time| time - minute * MINUTE));
    let times = postcard::to_stdvec(&times).expect("numbers can be written down");
    let tracks = tracks.iter().map(|(id, rows)| (*id, minute::octets(rows)));
    for (id, octets) in std::iter::once(("", times)).chain(tracks) {
        grown += cost(id, &octets) as i64;
        minutes.insert((minute, id), octets.as_slice())?;
    }
    Ok(grown)
}

/// Pictures of a minute by time, and their size in octets.
fn whole(
    minutes: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
    minute: i64,
) -> Result<(BTreeMap<i64, Vec<HistoryTrack>>, u64), redb::Error> {
    let (mut times, mut pictures, mut octets) = (Vec::new(), BTreeMap::new(), 0);
    for entry in minutes.range((minute, "")..(minute + 1, ""))? {
        let (key, value) = entry?;
        let (_, id) = key.value();
        octets += cost(id, value.value());
        if id.is_empty() {
            times = self::times(minute, value.value());
            pictures.extend(times.iter().map(|time| (*time, Vec::new())));
            continue;
        }
        for (place, track) in minute::rows(id, value.value()).unwrap_or_default() {
            let picture = times.get(place).and_then(|time| pictures.get_mut(time));
            picture.into_iter().for_each(|picture| picture.push(track.clone()));
        }
    }
    // In the order of pictures.
    for picture in pictures.values_mut() {
        picture.sort_by_key(|track| (codec::units(track).kind() >> 1, track.number));
    }
    Ok((pictures, octets))
}

/// Times of a minute's pictures.
fn times(minute: i64, octets: &[u8]) -> Vec<i64> {
    let bends: Vec<i64> = postcard::from_bytes(octets).unwrap_or_default();
    minute::straightened(&bends).map(|since| minute * MINUTE + since).collect()
}

/// Removes the oldest minute or picture if it ends before `oldest`, or `is_too_much`; returns its size in octets.
pub(super) fn forget(
    oldest: i64,
    is_too_much: bool,
    recent: &mut PictureTable<'_>,
    minutes: &mut MinuteTable<'_>,
) -> Result<Option<u64>, redb::Error> {
    if let Some((minute, _)) = bounds(minutes)? {
        if (minute + 1) * MINUTE > oldest && !is_too_much {
            return Ok(None);
        }
        let mut removed = 0;
        for entry in minutes.extract_from_if((minute, "")..(minute + 1, ""), |_, _| true)? {
            let (key, value) = entry?;
            removed += cost(key.value().1, value.value());
        }
        return Ok(Some(removed));
    }
    let first = recent.first()?.map(|(time, picture)| (time.value(), cost("", picture.value())));
    // The newest picture is kept.
    let is_last = recent.len()? == 1;
    let Some((time, removed)) = first.filter(|(time, _)| !is_last && (*time < oldest || is_too_much)) else {
        return Ok(None);
    };
    recent.remove(time)?;
    Ok(Some(removed))
}

/// The latest picture from `from` to `until`, with its time.
pub(super) fn picture(
    minutes: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
    from: i64,
    until: i64,
) -> Result<Option<(i64, Vec<HistoryTrack>)>, redb::Error> {
    let span = from.div_euclid(MINUTE)..=until.div_euclid(MINUTE);
    for minute in span.rev() {
        let Some(value) = minutes.get((minute, ""))? else { continue };
        let latest = times(minute, value.value()).into_iter().rfind(|time| (from..=until).contains(time));
        let Some(latest) = latest else { continue };
        return Ok(whole(minutes, minute)?.0.remove_entry(&latest));
    }
    Ok(None)
}

/// Places of a track in order of time; at least the `limit` latest.
pub(super) fn trail(
    minutes: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
    id: &str,
    span: &RangeInclusive<i64>,
    limit: usize,
) -> Result<Vec<(Time, HistoryTrack)>, redb::Error> {
    let Some((first, last)) = bounds(minutes)? else { return Ok(Vec::new()) };
    let from = first.max(span.start().div_euclid(MINUTE));
    let until = last.min(span.end().div_euclid(MINUTE));
    let mut places = Vec::new();
    for minute in (from..=until).rev() {
        if places.len() >= limit {
            break;
        }
        let Some(rows) = minutes.get((minute, id))? else { continue };
        let Some(times) = minutes.get((minute, ""))? else { continue };
        let times = self::times(minute, times.value());
        for (place, track) in minute::rows(id, rows.value()).into_iter().flatten().rev() {
            let time = times.get(place).filter(|time| span.contains(time));
            places.extend(time.map(|time| (Time::from_nanos(*time), track)));
        }
    }
    places.reverse();
    Ok(places)
}

/// First and last minute.
fn bounds(
    minutes: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
) -> Result<Option<(i64, i64)>, redb::Error> {
    let first = minutes.first()?.map(|(key, _)| key.value().0);
    Ok(first.zip(minutes.last()?.map(|(key, _)| key.value().0)))
}

/// Times in the first and the last minute.
pub(super) fn ends(
    minutes: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
) -> Result<Vec<i64>, redb::Error> {
    let Some((first, last)) = bounds(minutes)? else { return Ok(Vec::new()) };
    let mut ends = Vec::new();
    for minute in [first, last] {
        let times = minutes.get((minute, ""))?.map(|value| times(minute, value.value()));
        ends.extend(times.into_iter().flatten());
    }
    Ok(ends)
}
