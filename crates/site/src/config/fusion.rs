//! `[fusion]`.

use std::collections::BTreeMap;

use jiff::SignedDuration;

use super::network::PictureKind;
use tables::kinds::{Kind, flag, named, number, seconds, whole};
use tables::reader::{Item, Section};
use tables::section;
use tables::table::{ByHand, Entry, depends};
use tables::{names, written_by_name};

/// Maximum number of slots of the window and `max_future` together. The engine keeps sets of slots in 128-bit words; two bits are
/// for the slot that leaves the window and for one that a waiting report has just started.
pub const MAX_WINDOW_SLOTS: u32 = 126;

/// Highest transponder number: T * 10000 + R has to fit 32 bits.
const MAX_TRANSPONDER_NUMBER: u32 = 429_496;

/// Length of I129/040, in octets.
const SERIAL_OCTETS: usize = 12;

fn weight() -> Kind<f64> {
    number("a weight is at least 0, and at most 1000000", |v| (0.0..=1e6).contains(&v))
}

section! {
    /// The fusion engine. `window_s` and `max_future_s` together are at most 126 slots.
    Fusion {
        /// Tracking rules (docs/OPERATIONAL.md).
        profile: Profile = Profile::Operational, named();
        /// Motion model of aircraft (docs/OPERATIONAL.md). Not used by the `reference` profile.
        motion: Motion = Motion::Imm, named();
        /// Length of a slot, in seconds.
        slot as "slot_s": SignedDuration = SignedDuration::from_millis(250), seconds(
            "a slot is a whole number of milliseconds, 0.001 to 60 seconds",
            |s| s > 0.0 && s <= 60.0 && (s * 1e9).round() % 1e6 == 0.0,
        );
        /// Time from the start of a slot to its publication, in seconds; less than `window_s`. A shorter latency leaves fewer
        /// later reports to use (docs/OPERATIONAL.md). At least one slot in the `reference` profile.
        latency_slots as "latency_s": u32 = 25, whole_slots();
        /// Whether the picture "now" is published too: aircraft at their predicted positions at the time of publication
        /// (docs/OPERATIONAL.md). Not available in the `reference` profile.
        now: bool = depends("true; false in the `reference` profile", true), flag();
        /// Length of the window including the newest slot, in seconds.
        window_slots as "window_s": u32 = 100, whole_slots();
        /// Maximum time by which a report may be ahead of its reception, in seconds. Reports further ahead are dropped.
        max_future as "max_future_s": SignedDuration =
            depends("1, or `latency_s` where that is less", SignedDuration::from_secs(1)),
            seconds("max_future_s is at least 0, and at most latency_s", |s| s >= 0.0);
        /// Longest gap between two reports of a transponder that is interpolated, in seconds.
        max_gap as "max_gap_s": SignedDuration = SignedDuration::from_secs(25),
            seconds("the longest gap is above 0 and at most 86400 seconds", |s| s > 0.0);
        /// Association distance as a function of slant range, both in metres: linear between the rows, constant beyond the ends.
        threshold_m: Vec<(f64, f64)> = vec![(0.0, 60.0), (333.33, 60.0), (4333.33, 300.0)], threshold();
        /// Minimum share of a pair's common slots within the association distance for the pair to be associated.
        ratio_min: f64 = 0.9, number("the ratio is above 0 and at most 1", |v| v > 0.0 && v <= 1.0);
        /// Minimum number of common slots for a pair to be associated; at most the slots of `window_s`.
        min_samples: u32 = 4, whole("min_samples is a whole number, at least 1", 1..=u32::MAX);
        /// Weight of the radar's position in the fused position (weighted mean).
        weight_radar: f64 = 1.0, weight();
        /// Weight of the transponder's position in the fused position. At least one of the two weights is above 0.
        weight_transponder: f64 = 10.0, weight();
        /// Time as a likely UAV after which a radar-only track is published, in seconds.
        radar_only_min_s: f64 = 8.0,
            number("a time is between 0 and 86400 seconds", |s| (0.0..=86_400.0).contains(&s));
        /// Time before and after an association during which the transponder-only track is not published, in seconds; at most
        /// `window_s`.
        suppress_slots as "suppress_s": u32 = 16, whole_slots();
        /// Number of threads for the work of a slot. 0 uses as many as the machine runs in parallel. The output does not depend
        /// on the number. Not used by the `reference` profile.
        threads: u32 = 0, whole("threads is a whole number from 0, all there are, to 64", 0..=64);
        /// Transponder number of each serial (I129/040, trimmed). Other serials get free numbers.
        transponder_numbers: BTreeMap<String, u32> = BTreeMap::new(), numbers();
    } by hand {}
}

names! {
    /// Tracking rules of the engine.
    #[derive(Copy, Eq)]
    Profile, "profile" {
        /// Improved estimation from the same inputs (docs/OPERATIONAL.md).
        Operational = "operational",
        /// The published algorithm only.
        Reference = "reference",
    }
}

names! {
    /// Motion model of aircraft in the `operational` profile.
    #[derive(Copy, Eq)]
    Motion, "model of motion" {
        /// Interacting multiple models: straight flight and turns.
        Imm = "imm",
        /// Time-correlated acceleration (R. A. Singer, 1970).
        Singer = "singer",
    }
}

written_by_name!(Profile, Motion);

impl Fusion {
    /// Time from the start of a slot to its publication.
    pub fn latency(&self) -> SignedDuration {
        self.slot.saturating_mul(self.latency_slots as i32)
    }

    /// Time from the start of a slot to its publication in the picture `picture`.
    pub fn latency_of(&self, picture: PictureKind) -> SignedDuration {
        match picture {
            PictureKind::Lagged => self.latency(),
            PictureKind::Now => SignedDuration::ZERO,
        }
    }

    /// These settings with the rules of another profile.
    ///
    /// # Errors
    /// The profile does not allow the latency.
    pub fn with_profile(self, profile: Profile) -> Result<Self, &'static str> {
        if profile == self.profile {
            return Ok(self);
        }
        match profile {
            Profile::Reference if self.latency_slots == 0 => {
                Err("the reference profile needs a latency_s of at least one slot")
            }
            _ => Ok(Self { now: profile == Profile::Operational, profile, ..self }),
        }
    }

    /// Length of the window.
    pub fn window(&self) -> SignedDuration {
        self.slot.saturating_mul(self.window_slots as i32)
    }

    /// Time before and after an association during which the transponder-only track is not published.
    pub fn suppress(&self) -> SignedDuration {
        self.slot.saturating_mul(self.suppress_slots as i32)
    }
}

/// Number of slots in the time of `key`, which has to be a whole number of slots.
fn slots(section: &Section<'_>, key: &'static str, usual: SignedDuration, slot: SignedDuration) -> u32 {
    let item = section.written(key);
    let time = item.as_ref().and_then(Item::any_seconds).unwrap_or(usual).as_nanos();
    let slot = slot.as_nanos();
    if let (Some(item), true) = (item.or_else(|| section.written("slot_s")), time % slot != 0) {
        let below = (time / slot * slot) as f64 / 1e9;
        let [time, slot] = [time, slot].map(|nanos| nanos as f64 / 1e9);
        let above = below + slot;
        item.refuse(format!(
            "{key} is a whole number of slots (slot_s = {slot}), and {time} is none; set it to {below} or {above}"
        ));
    }
    // Times are at most one day, so their number of milliseconds fits.
    u32::try_from(time / slot).unwrap_or(u32::MAX)
}

/// Rejects keys that contradict each other.
impl ByHand for Fusion {
    fn more(&mut self, section: &mut Section<'_>) {
        let usual = Self::default();
        if section.is_sound(&["slot_s"]) {
            let [latency, window, suppress] = [
                ("latency_s", usual.latency()),
                ("window_s", usual.window()),
                ("suppress_s", usual.suppress()),
            ]
            .map(
                |(key, time)| if section.is_sound(&[key]) { slots(section, key, time, self.slot) } else { 1 },
            );
            (self.latency_slots, self.window_slots, self.suppress_slots) = (latency, window, suppress);
        }
        let is_reference = self.profile == Profile::Reference;
        if is_reference && section.is_sound(&["profile"]) {
            if section.written("now").is_some() && self.now {
                section.contradict(
                    &["now"],
                    "the reference profile has no picture of now; remove this, or the profile",
                );
            }
            self.now = false;
        }
        if section.written("max_future_s").is_none() {
            self.max_future = usual.max_future.min(self.latency());
        }
        let contradict = |is_wrong: bool, keys: &[&str], message: &str| {
            if is_wrong && section.is_sound(&["slot_s"]) {
                section.contradict(keys, message);
            }
        };
        contradict(
            self.latency_slots == 0 && is_reference,
            &["latency_s", "slot_s"],
            "latency_s is at least one slot in the reference profile: before, the slot is not over",
        );
        contradict(
            self.latency_slots >= self.window_slots,
            &["latency_s", "slot_s", "window_s"],
            "latency_s is shorter than window_s; shorten it or lengthen window_s",
        );
        contradict(
            self.suppress_slots > self.window_slots,
            &["suppress_s", "slot_s", "window_s"],
            "suppress_s is at most window_s: nothing older is known; shorten it",
        );
        contradict(
            self.min_samples > self.window_slots,
            &["min_samples", "window_s", "slot_s"],
            "min_samples is at most the slots of window_s, or no pair ever has them; lower it",
        );
        contradict(
            self.max_future > self.latency(),
            &["max_future_s", "latency_s", "slot_s"],
            "max_future_s is at most latency_s (by default 6.25); lower it or raise latency_s",
        );
        let slots = i128::from(self.window_slots) + self.max_future.as_nanos() / self.slot.as_nanos();
        let most = self.slot.saturating_mul(MAX_WINDOW_SLOTS as i32).as_secs_f64();
        contradict(
            slots > i128::from(MAX_WINDOW_SLOTS) && section.is_sound(&["max_future_s"]),
            &["window_s", "slot_s"],
            &format!(
                "window_s and max_future_s together are at most {MAX_WINDOW_SLOTS} slots, here {most} seconds; \
                 shorten one or lengthen slot_s"
            ),
        );
        contradict(
            (self.weight_radar, self.weight_transponder) == (0.0, 0.0),
            &["weight_transponder", "weight_radar"],
            "both weights are 0, so there is no mean; raise weight_radar or weight_transponder",
        );
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        for entry in entries {
            let value = match entry.key {
                "latency_s" => format!("{:?}", self.latency().as_secs_f64()),
                "window_s" => format!("{:?}", self.window().as_secs_f64()),
                "suppress_s" => format!("{:?}", self.suppress().as_secs_f64()),
                "now" => (self.now && self.profile == Profile::Operational).to_string(),
                _ => continue,
            };
            *entry = Entry::new(entry.key, value);
        }
    }
}

/// Kind of a time of whole slots. The number of slots is set later, when the length of a slot is known.
fn whole_slots() -> Kind<u32> {
    Kind::new("a whole number of slots, between 0 and 86400 seconds", |item| {
        item.seconds("this is between 0 and 86400 seconds", |_| true)?;
        None
    })
}

fn threshold() -> Kind<Vec<(f64, f64)>> {
    Kind::new("a list of rows [slant range in metres, distance in metres], the slant ranges rising", |item| {
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
    })
}

fn numbers() -> Kind<BTreeMap<String, u32>> {
    let rule = format!("a transponder number is a whole number from 1 to {MAX_TRANSPONDER_NUMBER}");
    Kind::new(format!("a table; {rule}"), move |item| {
        let mut numbers: BTreeMap<String, u32> = BTreeMap::new();
        for (written, item) in item.section()?.all() {
            // Trimmed as the serials of reports are.
            let serial = written.trim_matches([' ', '\0']);
            if serial.is_empty() {
                item.refuse("the serial is blank; write the serial that the transponder sends (I129/040)");
            } else if serial.len() > SERIAL_OCTETS {
                item.refuse(format!("a serial has at most {SERIAL_OCTETS} octets (I129/040); shorten it"));
            }
            let Some(number) = item.whole(1..=MAX_TRANSPONDER_NUMBER, &rule) else { continue };
            if let Some((other, _)) = numbers.iter().find(|(_, other)| **other == number) {
                item.refuse(format!("{other} has this number already; give each serial its own"));
            }
            if numbers.insert(serial.to_owned(), number).is_some() {
                item.refuse("this serial is there twice, apart from blanks; remove one");
            }
        }
        Some(numbers)
    })
}
