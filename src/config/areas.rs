//! `[[areas]]`.

use std::path::PathBuf;

use jiff::SignedDuration;
use jiff::tz::TimeZone;

use tables::kinds::{Kind, beside, list, named, number, parsed, seconds, text};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, Table, absent, need};
use tables::tree::quoted;
use tables::{names, written_by_name};

section! {
    /// Files of areas: UAS zones as authorities publish them (ED-318, ED-269), or polygons (GeoJSON, RFC 7946);
    /// [ZONES.md](ZONES.md). SIGHUP reads the files again, but masks change with a restart only, and so does where a drone is
    /// uncooperative.
    Area {
        /// What the areas are for. An area of kind `alert` has keys of its own, below.
        kind: AreaKind = need("kind = \"mask\", \"coverage\" or \"alert\""), named(), reloaded;
        /// The file. A polygon is called what its feature's property `name` says, or else as the file.
        file: PathBuf = need("file = …, a GeoJSON file of polygons, or a file of UAS zones"), beside(), reloaded;
    } by hand {}
}

names! {
    /// What an area is for.
    AreaKind, "kind of area" {
        /// Plots inside are dropped.
        Mask = "mask",
        /// Where a sensor sees, shown instead of the circle of `max_range_m`; of a transponder receiver also where a drone without a transponder is uncooperative.
        Coverage {
            /// The id of that sensor.
            sensor: String
        } = "coverage",
        /// Tracks inside raise an alert, and so do those that are about to enter.
        Alert(AlertArea) = "alert",
    }
}
written_by_name!(AreaKind, AreaSeverity);

/// A blank.
impl Default for AreaKind {
    fn default() -> Self {
        Self::Mask
    }
}

names! {
    /// How bad it is to be inside.
    #[derive(Copy, Eq)]
    AreaSeverity, "severity" {
        /// To look at.
        Warning = "warning",
        /// To act on.
        Critical = "critical",
    }
}

fn height() -> Kind<f64> {
    number(
        "a height is between -500 and 50000 metres above mean sea level; leave the key out for no limit",
        |v| (-500.0..=50_000.0).contains(&v),
    )
}

section! {
    /// The keys of an area with `kind = "alert"`.
    AlertArea {
        /// Where polygons begin whose file says nothing of heights, metres above mean sea level.
        floor_m: Option<f64> = absent("from the ground up"), height(), reloaded;
        /// Where they end, metres above mean sea level.
        ceiling_m: Option<f64> = absent("no upper limit"), height(), reloaded;
        /// Height of the ground that limits above ground (AGL) are counted from, metres above mean sea level.
        ground_m: Option<f64> = absent("not known: limits above ground are refused"), number(
            "a ground is between -500 and 9000 metres above mean sea level",
            |v| (-500.0..=9000.0).contains(&v),
        ), reloaded;
        /// How long ahead a track that is about to enter raises an alert, seconds; 0: not at all. Not in the `reference`
        /// profile.
        predict_s: SignedDuration = SignedDuration::from_secs(60),
            seconds("an entry is predicted 0 (not at all) to 300 seconds ahead", |s| s <= 300.0), reloaded;
        /// How bad it is to be inside.
        severity: Option<AreaSeverity> = absent("as the type of the zone says"), named::<AreaSeverity>(), reloaded;
        /// Serial numbers of transponders that raise no alert inside, while nothing speaks against them.
        allow: Vec<String> = Vec::new(), list(text(
            "a serial number is as the alerts and /api/v1/tracks have it, at most 80 characters",
            |serial| serial.trim() == serial && serial.chars().count() <= 80,
        )), reloaded;
        /// Language of zones' names, where a file has several. Of a language that it has not, the first one.
        language: String = "en".to_owned(), text(
            "a language is a tag such as \"en\" or \"fr-CH\"",
            |tag| tag.split('-').all(|part| matches!(part.len(), 1..=8) && part.chars().all(|c| c.is_ascii_alphanumeric())),
        ), reloaded;
        /// Time zone of hours that are given without one.
        time_zone: Option<String> = absent("not known: such hours are refused"), parsed(
            "a name of the IANA time zone database, such as \"Europe/Zurich\", or \"UTC\"",
            |name| match TimeZone::get(name) {
                Ok(_) => Ok(name.to_owned()),
                Err(_) => Err("there is no such time zone; write a name such as \"Europe/Zurich\", or \"UTC\""),
            },
        ), reloaded;
    } by hand {}
}

impl ByHand for AlertArea {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.floor_m.zip(self.ceiling_m).is_some_and(|(floor_m, ceiling_m)| floor_m >= ceiling_m) {
            section.contradict(&["ceiling_m", "floor_m"], "the ceiling is not above the floor");
        }
    }
}

impl ByHand for Area {
    fn more(&mut self, section: &mut Section<'_>) {
        if !self.file.is_file() {
            let file = self.file.display();
            section.contradict(
                &["file"],
                format!("there is no file {file}; paths are relative to the configuration file"),
            );
        }
        if !section.is_sound(&["kind"]) {
            return section.abandon();
        }
        match &mut self.kind {
            AreaKind::Coverage { sensor } => {
                let item = section.need("sensor", "sensor = …, the id of the sensor that covers this area");
                *sensor = item.and_then(|item| item.text()).unwrap_or_default().to_owned();
            }
            AreaKind::Alert(alert) => *alert = AlertArea::read_keys(section),
            AreaKind::Mask => {}
        }
        let is_coverage = matches!(self.kind, AreaKind::Coverage { .. });
        if let Some(item) = section.stray("sensor").filter(|_| !is_coverage) {
            item.refuse("only an area of kind = \"coverage\" belongs to a sensor; remove the key");
        }
        if !matches!(self.kind, AreaKind::Alert(_)) {
            for row in AlertArea::rows() {
                if let Some(item) = section.stray(row.key) {
                    item.refuse("only an area of kind = \"alert\" has this key; remove it");
                }
            }
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        match &self.kind {
            AreaKind::Mask => {}
            AreaKind::Coverage { sensor } => entries.push(Entry::new("sensor", quoted(sensor))),
            AreaKind::Alert(alert) => entries.extend(alert.entries()),
        }
    }

    fn explain(rows: &mut Vec<Row>) {
        let about = " The sensor whose coverage it is; only with `kind = \"coverage\"`, and needed there.";
        rows.push(Row { reloaded: true, ..Row::by_hand("sensor", None, "the id of a sensor", about) });
    }
}

impl Area {
    /// Finds fault with a sensor that is none of `ids`.
    pub(super) fn check(&self, section: &Section<'_>, ids: &[&str]) {
        if let AreaKind::Coverage { sensor } = &self.kind
            && !ids.contains(&&**sensor)
        {
            let ids = ids.join(", ");
            section.contradict(&["sensor"], format!("no sensor has this id; the sensors are: {ids}"));
        }
    }

    /// What is set of an area of kind `alert`.
    pub fn alert(&self) -> Option<&AlertArea> {
        match &self.kind {
            AreaKind::Alert(alert) => Some(alert),
            AreaKind::Mask | AreaKind::Coverage { .. } => None,
        }
    }
}
