//! `[[sensors]]`.

use super::network::read_input;
use super::reader::{Item, Section, each};
use super::types::{
    Classification, Radar, RadarAccuracy, Registration, Sensor, SensorKind, Transponder, TransponderAccuracy,
};

/// Keys that only a radar has.
const RADAR_KEYS: [&str; 8] = [
    "latitude_deg",
    "longitude_deg",
    "height_amsl_m",
    "bearing_correction_deg",
    "max_range_m",
    "assumed_height_amsl_m",
    "classification",
    "registration",
];

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Radar,
    Transponder,
}

impl Kind {
    const fn name(self) -> &'static str {
        match self {
            Self::Radar => "radar",
            Self::Transponder => "transponder",
        }
    }
}

/// What no other sensor may have as well, with the key of the sensor that has it.
#[derive(Default)]
struct Taken {
    ids: Vec<String>,
    addresses: Vec<(Kind, u8, u8, String)>,
    radar: bool,
    /// A sensor of unknown kind may have been meant as the radar.
    unknown_kind: bool,
}

/// The sensors and, also where something is wrong, the ids that were read. `own` is the service's SAC and SIC.
pub(super) fn read(top: &mut Section<'_>, own: Option<(u8, u8)>) -> (Option<Vec<Sensor>>, Vec<String>) {
    let list = top.need("sensors", "[[sensors]], at least one with kind = \"radar\"");
    let mut taken = Taken::default();
    let sensors = each(list.clone(), |section| read_sensor(section, own, &mut taken));
    // Something that is no list of sensors has been refused as such.
    let is_list = sensors.is_some() || !taken.ids.is_empty();
    if let (Some(list), true, false) = (list, is_list, taken.radar || taken.unknown_kind) {
        list.refuse("there is no radar, and the frame needs one as its origin; add one, kind = \"radar\"");
    }
    (sensors, taken.ids)
}

fn read_sensor(mut section: Section<'_>, own: Option<(u8, u8)>, taken: &mut Taken) -> Option<Sensor> {
    let id = section.need("id", "a name for the sensor, such as id = \"north\"").and_then(|item| {
        let id = item.text()?;
        if !id.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') {
            item.refuse("an id becomes part of track ids; use only letters A-Z a-z, digits, _ and -");
        } else if taken.ids.iter().any(|other| other == id) {
            item.refuse("another sensor has this id already; give each its own");
        }
        taken.ids.push(id.to_owned());
        Some(id.to_owned())
    });
    let kind = section
        .need("kind", "kind = \"radar\" (CAT048) or kind = \"transponder\" (CAT129)")
        .and_then(|item| item.word(&[("radar", Kind::Radar), ("transponder", Kind::Transponder)]));
    taken.radar |= kind == Some(Kind::Radar);
    taken.unknown_kind |= kind.is_none();

    let sac = section.need("sac", "sac = …, the system area code (SAC) of its records");
    let sac = sac.and_then(|item| item.whole(0..=255u8, "a SAC is a whole number from 0 to 255"));
    let sic_item = section.need("sic", "sic = …, the system identification code (SIC) of its records");
    let sic =
        sic_item.as_ref().and_then(|item| item.whole(0..=255u8, "a SIC is a whole number from 0 to 255"));
    if let (Some(item), Some(kind), Some(sac), Some(sic)) = (sic_item, kind, sac, sic) {
        check_address(&item, kind, (sac, sic), own, taken);
    }

    let period_s = section.item("period_s").and_then(|item| {
        item.number("a period is above 0 and at most 3600 seconds", |s| s > 0.0 && s <= 3600.0)
    });
    let inputs = each(section.item("inputs"), read_input);
    let kind = match kind {
        Some(Kind::Radar) => read_radar(&mut section).map(SensorKind::Radar),
        Some(Kind::Transponder) => Some(SensorKind::Transponder(read_transponder(&mut section))),
        None => {
            section.abandon();
            None
        }
    };
    section.finish();
    Some(Sensor { id: id?, sac: sac?, sic: sic?, period_s, inputs: inputs?, kind: kind? })
}

fn check_address(item: &Item<'_>, kind: Kind, code: (u8, u8), own: Option<(u8, u8)>, taken: &mut Taken) {
    let (sac, sic) = code;
    let name = kind.name();
    let other = taken.addresses.iter().find(|(k, a, i, _)| (*k, *a, *i) == (kind, sac, sic));
    if let Some((.., other)) = other {
        item.refuse(format!(
            "{other} is already the {name} with SAC {sac}, SIC {sic}, and records are told apart by them; \
             give each {name} its own"
        ));
    } else if own == Some(code) {
        item.refuse(format!(
            "SAC {sac}, SIC {sic} is the service's own ([site]), whose records are refused at the inputs; \
             change [site] or the sensor"
        ));
    }
    let key = item.key().trim_end_matches(".sic").to_owned();
    taken.addresses.push((kind, sac, sic, key));
}

fn read_radar(section: &mut Section<'_>) -> Option<Radar> {
    let latitude_deg = section
        .need("latitude_deg", "latitude_deg = …, where the radar stands (WGS-84, north positive)")
        .and_then(|i| {
            i.number("a latitude is between -90 and 90 degrees; south is negative", |v| v.abs() <= 90.0)
        });
    let longitude_deg = section
        .need("longitude_deg", "longitude_deg = …, where the radar stands (WGS-84, east positive)")
        .and_then(|i| {
            i.number("a longitude is between -180 and 180 degrees; west is negative", |v| v.abs() <= 180.0)
        });
    let height_amsl_m = section
        .need("height_amsl_m", "height_amsl_m = …, the antenna's height above mean sea level in metres")
        .and_then(|i| {
            i.number("the antenna is between -500 and 9000 metres above mean sea level", |v| {
                (-500.0..=9000.0).contains(&v)
            })
        });
    let bearing_correction_deg = section.item("bearing_correction_deg").and_then(|i| {
        i.number("a bearing correction is between -180 and 180 degrees, clockwise positive", |v| {
            v.abs() <= 180.0
        })
    });
    let max_range_m = section
        .item("max_range_m")
        .and_then(|i| i.number("a range is above 0 metres; leave the key out for no limit", |v| v > 0.0));
    let assumed_height_amsl_m = section.item("assumed_height_amsl_m").and_then(|i| {
        i.number("an assumed height is between -500 and 20000 metres above mean sea level", |v| {
            (-500.0..=20_000.0).contains(&v)
        })
    });
    let classification = section.item("classification").map(|item| read_classification(item.section()?));
    let accuracy = section.item("accuracy").map(|item| {
        let mut section = item.section()?;
        let range_m = read_deviation(section.need("range_m", "range_m = …, in metres"));
        let azimuth_deg = read_deviation(section.need("azimuth_deg", "azimuth_deg = …, in degrees"));
        let height_m = read_deviation(section.item("height_m"));
        section.finish();
        Some(RadarAccuracy { range_m: range_m?, azimuth_deg: azimuth_deg?, height_m })
    });
    let modes =
        [Registration::Off, Registration::Propose, Registration::Apply].map(|mode| (mode.name(), mode));
    let registration = section.item("registration").map(|item| item.word(&modes));
    Some(Radar {
        latitude_deg: latitude_deg?,
        longitude_deg: longitude_deg?,
        height_amsl_m: height_amsl_m?,
        bearing_correction_deg: bearing_correction_deg.unwrap_or(0.0),
        max_range_m,
        assumed_height_amsl_m: assumed_height_amsl_m.or(height_amsl_m)?,
        classification: classification.unwrap_or(Some(Classification::SpecialPurpose { octet: 0 }))?,
        accuracy: accuracy.flatten(),
        registration: registration.unwrap_or(Some(Registration::default()))?,
    })
}

fn read_transponder(section: &mut Section<'_>) -> Transponder {
    for name in RADAR_KEYS {
        if let Some(item) = section.stray(name) {
            item.refuse(
                "only a radar has this key, and this is a transponder; remove it, or set kind = \"radar\"",
            );
        }
    }
    let accuracy = section.item("accuracy").and_then(|item| {
        let mut section = item.section()?;
        let horizontal_m = read_deviation(section.need("horizontal_m", "horizontal_m = …, in metres"));
        let vertical_m = read_deviation(section.need("vertical_m", "vertical_m = …, in metres"));
        section.finish();
        Some(TransponderAccuracy { horizontal_m: horizontal_m?, vertical_m: vertical_m? })
    });
    let delay_s = section
        .item("delay_s")
        .and_then(|item| item.number("a delay is between 0 and 5 seconds", |v| (0.0..=5.0).contains(&v)));
    let max_new_per_s = section.item("max_new_per_s").and_then(|item| {
        item.whole(1..=100_000u32, "a rate of new transponders is a whole number a second, from 1 to 100000")
    });
    Transponder { accuracy, delay_s, max_new_per_s: max_new_per_s.unwrap_or(Transponder::MAX_NEW_PER_S) }
}

fn read_deviation(item: Option<Item<'_>>) -> Option<f64> {
    item?.number("a standard deviation is above 0; leave accuracy out when it is not known", |v| v > 0.0)
}

fn read_classification(mut section: Section<'_>) -> Option<Classification> {
    #[derive(Clone, Copy)]
    enum Source {
        SpecialPurpose,
        TargetClassification,
        Constant,
    }
    let sources = [
        ("special-purpose", Source::SpecialPurpose),
        ("target-classification", Source::TargetClassification),
        ("constant", Source::Constant),
    ];
    let source =
        section.need("source", "source = \"special-purpose\", \"target-classification\" or \"constant\"");
    let Some(source) = source.and_then(|item| item.word(&sources)) else {
        section.abandon();
        return None;
    };
    let read = match source {
        Source::SpecialPurpose => {
            let rule = "octets of I048/SP are counted from 0 after the length, to 253";
            let octet = section.item("octet").map(|item| item.whole(0..=253u8, rule));
            octet.unwrap_or(Some(0)).map(|octet| Classification::SpecialPurpose { octet: octet.into() })
        }
        Source::TargetClassification => Some(Classification::TargetClassification),
        Source::Constant => section
            .need("value", "value = …, the probability from 0 to 1")
            .and_then(|item| item.number("a probability is between 0 and 1", |v| (0.0..=1.0).contains(&v)))
            .map(|value| Classification::Constant { value }),
    };
    section.finish();
    read
}
