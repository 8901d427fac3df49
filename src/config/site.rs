//! `[site]` and `[[areas]]`.

use std::path::PathBuf;

use super::kinds::{Kind, any_text, beside, named, number, whole};
use super::names::{names, written_by_name};
use super::reader::Section;
use super::table::{ByHand, Entry, Row, absent, need, section};
use super::tree::quoted;

/// A system area code.
pub(super) fn area_code() -> Kind<u8> {
    whole("a SAC is a whole number from 0 to 255", 0..=255)
}

/// A system identification code.
pub(super) fn identification_code() -> Kind<u8> {
    whole("a SIC is a whole number from 0 to 255", 0..=255)
}

section! {
    /// The service itself.
    Site {
        /// Name of the service, shown on its interfaces.
        name: String = need("name = …, how the interfaces call this service"), any_text();
        /// System area code of what the service sends (I129/010). No sensor may have both this SAC and this SIC.
        sac: u8 = need("sac = …, the system area code (SAC) of what the service sends"), area_code();
        /// System identification code of what the service sends (I129/010).
        sic: u8 = need("sic = …, the system identification code (SIC) of what the service sends"), identification_code();
        /// Height of the geoid above the WGS-84 ellipsoid, metres.
        geoid_undulation_m: Option<f64> = absent("EGM96 at the first radar"), number(
            "a geoid undulation is between -120 and 100 metres; leave the key out for EGM96",
            |v| (-120.0..=100.0).contains(&v),
        );
    }
}

section! {
    /// Files of polygons (GeoJSON, RFC 7946). An area holds at every height and at all times: a file of UAS zones (ED-318,
    /// ED-269) with limits of height or time, circles or conditions is refused. SIGHUP reads the files again, but masks
    /// change with a restart only, and so does where a drone is uncooperative.
    #[derive(Eq)]
    Area {
        /// What the polygons are for.
        kind: AreaKind = need("kind = \"mask\", \"coverage\" or \"alert\""), named(), reloaded;
        /// The file of polygons. A feature's property `name` is the name of an area, or else the file's name.
        file: PathBuf = need("file = …, a GeoJSON file of polygons"), beside(), reloaded;
    } by hand {}
}

names! {
    /// What the polygons of an area are for.
    #[derive(Eq)]
    AreaKind, "kind of area" {
        /// Plots inside are dropped.
        Mask = "mask",
        /// Where a sensor sees, shown instead of the circle of `max_range_m`; of a transponder receiver also where a drone without a transponder is uncooperative.
        Coverage {
            /// The id of that sensor.
            sensor: String
        } = "coverage",
        /// Tracks inside raise an alert.
        Alert = "alert",
    }
}
written_by_name!(AreaKind);

/// A blank.
impl Default for AreaKind {
    fn default() -> Self {
        Self::Mask
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
            section.abandon();
        } else if let AreaKind::Coverage { sensor } = &mut self.kind {
            let item = section.need("sensor", "sensor = …, the id of the sensor that covers this area");
            *sensor = item.and_then(|item| item.text()).unwrap_or_default().to_owned();
        } else if let Some(item) = section.stray("sensor") {
            item.refuse("only an area of kind = \"coverage\" belongs to a sensor; remove the key");
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        if let AreaKind::Coverage { sensor } = &self.kind {
            entries.push(Entry::new("sensor", quoted(sensor)));
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
}
