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
    /// Files of areas: UAS zones as published by authorities (ED-318, ED-269), or polygons (GeoJSON, RFC 7946); see
    /// [ZONES.md](ZONES.md). SIGHUP reads the files again. Changes to masks, and to the areas where drones are uncooperative,
    /// need a restart.
    Area {
        /// Purpose of the areas. An area of kind `alert` has more keys, below.
        kind: AreaKind = need("kind = \"mask\", \"coverage\" or \"alert\""), named(), reloaded;
        /// File of the areas. A polygon is named by the property `name` of its feature, or else by the file name.
        file: PathBuf = need("file = …, a GeoJSON file of polygons, or a file of UAS zones"), beside(), reloaded;
    } by hand {}
}

names! {
    /// Purpose of an area.
    AreaKind, "kind of area" {
        /// Plots inside the area are dropped.
        Mask = "mask",
        /// Coverage of a sensor, shown instead of the circle of `max_range_m`. For a transponder receiver it is also where a
        /// drone without a transponder is uncooperative.
        Coverage {
            /// Id of the sensor.
            sensor: String
        } = "coverage",
        /// Tracks inside the area, or about to enter it, raise an alert.
        Alert(AlertArea) = "alert",
    }
}
written_by_name!(AreaKind, AreaSeverity);

/// Placeholder of an area whose kind is not read yet.
impl Default for AreaKind {
    fn default() -> Self {
        Self::Mask
    }
}

names! {
    /// Severity of an alert for a track inside the area.
    #[derive(Copy, Eq)]
    AreaSeverity, "severity" {
        /// Needs attention.
        Warning = "warning",
        /// Needs action.
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
    /// Keys of an area with `kind = "alert"`.
    AlertArea {
        /// Lower limit of polygons whose file gives no heights, in metres above mean sea level.
        floor_m: Option<f64> = absent("from the ground up"), height(), reloaded;
        /// Upper limit of polygons whose file gives no heights, in metres above mean sea level.
        ceiling_m: Option<f64> = absent("no upper limit"), height(), reloaded;
        /// Height of the ground for limits above ground (AGL), in metres above mean sea level.
        ground_m: Option<f64> = absent("not known: limits above ground are refused"), number(
            "a ground is between -500 and 9000 metres above mean sea level",
            |v| (-500.0..=9000.0).contains(&v),
        ), reloaded;
        /// Prediction time, in seconds: a track that will enter the area within this time raises an alert. 0 disables
        /// predictions. Not used by the `reference` profile.
        predict_s: SignedDuration = SignedDuration::from_secs(60),
            seconds("an entry is predicted 0 (not at all) to 300 seconds ahead", |s| s <= 300.0), reloaded;
        /// Severity of an alert for a track inside the area.
        severity: Option<AreaSeverity> = absent("as the type of the zone says"), named::<AreaSeverity>(), reloaded;
        /// Serial numbers of transponders that raise no alert inside the area, as long as their integrity is not in doubt.
        allow: Vec<String> = Vec::new(), list(text(
            "a serial number is as the alerts and /api/v1/tracks have it, at most 80 characters",
            |serial| serial.trim() == serial && serial.chars().count() <= 80,
        )), reloaded;
        /// Language of the zone names, where a file has several. The first language of a zone is used if it lacks this one.
        language: String = "en".to_owned(), text(
            "a language is a tag such as \"en\" or \"fr-CH\"",
            |tag| tag.split('-').all(|part| matches!(part.len(), 1..=8) && part.chars().all(|c| c.is_ascii_alphanumeric())),
        ), reloaded;
        /// Time zone of hours that the file gives without one.
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
    /// Reports the id of a coverage area that is not among the sensors' `ids`.
    pub(super) fn check(&self, section: &Section<'_>, ids: &[&str]) {
        if let AreaKind::Coverage { sensor } = &self.kind
            && !ids.contains(&&**sensor)
        {
            let ids = ids.join(", ");
            section.contradict(&["sensor"], format!("no sensor has this id; the sensors are: {ids}"));
        }
    }

    /// Settings of the area if its kind is `alert`.
    pub fn alert(&self) -> Option<&AlertArea> {
        match &self.kind {
            AreaKind::Alert(alert) => Some(alert),
            AreaKind::Mask | AreaKind::Coverage { .. } => None,
        }
    }
}
