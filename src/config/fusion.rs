//! `[fusion]`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use jiff::SignedDuration;

use super::reader::{Item, Section};
use super::types::{Fusion, MAX_WINDOW_SLOTS};

/// The highest transponder number: T * 10000 + R has to fit 32 bits.
const MAX_TRANSPONDER_NUMBER: u32 = 429_496;

/// Octets of I129/040.
const SERIAL_OCTETS: usize = 12;

pub(super) fn read(mut section: Section<'_>) -> Option<Fusion> {
    let default = Fusion::default();
    let profile = read_word(&mut section, "profile", default.profile);
    let motion = read_word(&mut section, "motion", default.motion);
    let slots = read_slots(&mut section, &default);
    let max_gap = section
        .item("max_gap_s")
        .and_then(|i| i.seconds("the longest gap is above 0 and at most 86400 seconds", |s| s > 0.0));
    let threshold_m = section.item("threshold_m").map(|item| read_threshold(&item));
    let ratio_min = section
        .item("ratio_min")
        .and_then(|i| i.number("the ratio is above 0 and at most 1", |v| v > 0.0 && v <= 1.0));
    let (weight_radar, weight_transponder) = read_weights(&mut section, &default);
    let radar_only_min_s = section
        .item("radar_only_min_s")
        .and_then(|i| i.number("a time is between 0 and 86400 seconds", |s| (0.0..=86_400.0).contains(&s)));
    let transponder_numbers = read_numbers(&section.section("transponder_numbers"));
    section.finish();

    let slots = slots?;
    Some(Fusion {
        profile: profile?,
        motion: motion?,
        slot: slots.slot,
        latency_slots: slots.latency,
        window_slots: slots.window,
        max_future: slots.max_future,
        max_gap: max_gap.unwrap_or(default.max_gap),
        threshold_m: threshold_m.unwrap_or(Some(default.threshold_m))?,
        ratio_min: ratio_min.unwrap_or(default.ratio_min),
        min_samples: slots.min_samples,
        weight_radar,
        weight_transponder,
        radar_only_min_s: radar_only_min_s.unwrap_or(default.radar_only_min_s),
        suppress_slots: slots.suppress,
        transponder_numbers,
    })
}

/// One of several words.
fn read_word<T: FromStr<Err: Display>>(
    section: &mut Section<'_>,
    name: &'static str,
    default: T,
) -> Option<T> {
    let Some(item) = section.item(name) else { return Some(default) };
    item.text()?.parse().map_err(|error| item.refuse(error)).ok()
}

/// The settings that are measured in slots or bounded by them.
struct Slots {
    slot: SignedDuration,
    latency: u32,
    window: u32,
    suppress: u32,
    min_samples: u32,
    max_future: SignedDuration,
}

fn read_slots(section: &mut Section<'_>, default: &Fusion) -> Option<Slots> {
    const SLOT: &str = "a slot is a whole number of milliseconds, 0.001 to 60 seconds";
    let slot_item = section.item("slot_s");
    let slot = match &slot_item {
        Some(item) => item.seconds(SLOT, |s| s > 0.0 && s <= 60.0).and_then(|slot| {
            let whole = slot.subsec_nanos() % 1_000_000 == 0;
            if !whole {
                item.refuse(SLOT);
            }
            whole.then_some(slot)
        }),
        None => Some(default.slot),
    };
    let mut read = |name, default| Span::read(section, name, default, slot, slot_item.as_ref());
    let latency = read("latency_s", default.latency());
    let window = read("window_s", default.window());
    let suppress = read("suppress_s", default.suppress());

    if latency.slots == Some(0) {
        latency.refuse("latency_s is at least one slot: before, the slot is not over");
    }
    if latency.slots.zip(window.slots).is_some_and(|(latency, window)| latency >= window) {
        latency.or(&window).refuse("latency_s is shorter than window_s; shorten it or lengthen window_s");
    }
    if suppress.slots.zip(window.slots).is_some_and(|(suppress, window)| suppress > window) {
        suppress.or(&window).refuse("suppress_s is at most window_s: nothing older is known; shorten it");
    }

    let samples_item = section.item("min_samples");
    let min_samples = samples_item.as_ref().map_or(Some(default.min_samples), |item| {
        item.whole(1..=u32::MAX, "min_samples is a whole number, at least 1")
    });
    if min_samples.zip(window.slots).is_some_and(|(samples, window)| samples > window) {
        let message = "min_samples is at most the slots of window_s, or no pair ever has them; lower it";
        Span { item: samples_item, ..Span::default() }.or(&window).refuse(message);
    }

    let future = section.item("max_future_s");
    let max_future = future.as_ref().map_or(Some(default.max_future), |item| {
        item.seconds("max_future_s is at least 0, and at most latency_s", |s| s >= 0.0)
    });
    if max_future.zip(latency.time).is_some_and(|(future, latency)| future > latency) {
        let message =
            "max_future_s is at most latency_s (by default 1 and 6.25); lower it or raise latency_s";
        Span { item: future, ..Span::default() }.or(&latency).refuse(message);
    }
    if let (Some(future), Some(slots), Some(slot)) = (max_future, window.slots, slot)
        && i128::from(slots) + future.as_nanos() / slot.as_nanos() > i128::from(MAX_WINDOW_SLOTS)
    {
        window.refuse(format!(
            "window_s and max_future_s together are at most {MAX_WINDOW_SLOTS} slots, here {} seconds; shorten one or lengthen slot_s",
            slot.saturating_mul(MAX_WINDOW_SLOTS as i32).as_secs_f64()
        ));
    }
    Some(Slots {
        slot: slot?,
        latency: latency.slots?,
        window: window.slots?,
        suppress: suppress.slots?,
        min_samples: min_samples?,
        max_future: max_future?,
    })
}

/// A time that is a whole number of slots.
#[derive(Clone, Default)]
struct Span<'a> {
    /// What was written; where nothing was, what made the default wrong.
    item: Option<Item<'a>>,
    time: Option<SignedDuration>,
    slots: Option<u32>,
}

impl<'a> Span<'a> {
    fn read(
        section: &mut Section<'a>,
        name: &'static str,
        default: SignedDuration,
        slot: Option<SignedDuration>,
        slot_item: Option<&Item<'a>>,
    ) -> Self {
        let item = section.item(name);
        let time = item.as_ref().map_or(Some(default), |item| {
            item.seconds(&format!("{name} is between 0 and 86400 seconds"), |s| s >= 0.0)
        });
        let slots = time.zip(slot).map(|(time, slot)| (time.as_nanos(), slot.as_nanos()));
        let mut span = Self { item: item.or(slot_item.cloned()), time, slots: None };
        match slots {
            // A day of milliseconds fits.
            Some((time, slot)) if time % slot == 0 => span.slots = u32::try_from(time / slot).ok(),
            Some((time, slot)) => {
                let below = (time / slot * slot) as f64 / 1e9;
                span.refuse(format!(
                    "{name} is a whole number of slots (slot_s = {}), and {} is none; set it to {below} or {}",
                    slot as f64 / 1e9,
                    time as f64 / 1e9,
                    below + slot as f64 / 1e9
                ));
            }
            None => {}
        }
        span
    }

    /// `self`, or `other` to be blamed where `self` was not written.
    fn or(&self, other: &Self) -> Self {
        Self { item: self.item.clone().or_else(|| other.item.clone()), ..*self }
    }

    /// Two defaults never contradict each other, so there is an item.
    fn refuse(&self, message: impl Display) {
        if let Some(item) = &self.item {
            item.refuse(message);
        }
    }
}

fn read_threshold(item: &Item<'_>) -> Option<Vec<(f64, f64)>> {
    let rows = item.list()?;
    if rows.is_empty() {
        item.refuse("the table has no row; add one, such as [[0, 60]], or leave the key out");
    }
    let mut table = Vec::with_capacity(rows.len());
    for row in &rows {
        let cells = row.list()?;
        let [range, distance] = &cells[..] else {
            row.refuse("a row is [slant range in metres, distance in metres]");
            return None;
        };
        let range_m = range.number("a slant range is at least 0 metres", |v| v >= 0.0)?;
        let distance_m = distance.number("a distance is above 0 metres", |v| v > 0.0)?;
        if table.last().is_some_and(|&(before, _)| before >= range_m) {
            row.refuse("the slant ranges rise from row to row; sort the rows and remove doubles");
        }
        table.push((range_m, distance_m));
    }
    Some(table)
}

fn read_weights(section: &mut Section<'_>, default: &Fusion) -> (f64, f64) {
    let (radar, transponder) = (section.item("weight_radar"), section.item("weight_transponder"));
    let read = |item: &Option<Item<'_>>, default| {
        let weight = item.as_ref().map(|i| i.number("a weight is at least 0", |v| v >= 0.0));
        weight.flatten().unwrap_or(default)
    };
    let weights = (read(&radar, default.weight_radar), read(&transponder, default.weight_transponder));
    if let ((0.0, 0.0), Some(item)) = (weights, transponder.or(radar)) {
        item.refuse("both weights are 0, so there is no mean; raise weight_radar or weight_transponder");
    }
    weights
}

fn read_numbers(section: &Section<'_>) -> BTreeMap<String, u32> {
    let mut numbers: BTreeMap<String, u32> = BTreeMap::new();
    for (written, item) in section.all() {
        // As the serials of reports are trimmed.
        let serial = written.trim_matches([' ', '\0']);
        if serial.is_empty() {
            item.refuse("the serial is blank; write the serial that the transponder sends (I129/040)");
        } else if serial.len() > SERIAL_OCTETS {
            item.refuse(format!("a serial has at most {SERIAL_OCTETS} octets (I129/040); shorten it"));
        }
        let rule = format!("a transponder number is a whole number from 1 to {MAX_TRANSPONDER_NUMBER}");
        let Some(number) = item.whole(1..=MAX_TRANSPONDER_NUMBER, &rule) else { continue };
        if let Some((other, _)) = numbers.iter().find(|(_, other)| **other == number) {
            item.refuse(format!("{other} has this number already; give each serial its own"));
        }
        if numbers.insert(serial.to_owned(), number).is_some() {
            item.refuse("this serial is there twice, apart from blanks; remove one");
        }
    }
    numbers
}
