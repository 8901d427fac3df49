//! `[[sensors]]`.

use super::error::Faults;
use super::kinds::{Inline, Kind, Name, Number, Tables, Text, Whole, is_plain, tables};
use super::names::names;
use super::network::Input;
use super::reader::{Item, Section};
use super::site::{SAC, SIC, Site};
use super::table::{ByHand, Entry, Row, Table, absent, depends, need, section};

section! {
    /// The sources of reports. The pair of SAC and SIC tells the sensors of a kind apart, and is never the service's own.
    /// At least one sensor is a radar; the first radar is the origin of the local frame.
    Sensor {
        /// Name of the sensor, unique among the sensors; part of track ids.
        id: String = need("a name for the sensor, such as id = \"north\""), Text(
            "an id becomes part of track ids; use only letters A-Z a-z, digits, _ and -",
            is_plain,
        );
        /// What the sensor is. Each kind has keys of its own, below.
        kind: SensorKind = need("kind = \"radar\" (CAT048) or kind = \"transponder\" (CAT129)"), KindOfSensor;
        /// System area code of its records.
        sac: u8 = need("sac = …, the system area code (SAC) of its records"), SAC;
        /// System identification code of its records.
        sic: u8 = need("sic = …, the system identification code (SIC) of its records"), SIC;
        /// Time between two reports of one target, seconds.
        period_s: Option<f64> = absent("not stated, 0.25 is assumed"), Number(
            "a period is above 0 and at most 3600 seconds",
            |s| s > 0.0 && s <= 3600.0,
        );
        /// UDP lines to listen on; several are redundant, and copies of a report are handled once. A replay needs none.
        inputs: Vec<Input> = Vec::new(), Tables;
    } by hand {}
}

/// Radar (CAT048) or transponder receiver (CAT129).
#[derive(Clone, Debug, PartialEq)]
pub enum SensorKind {
    /// Plots, CAT048.
    Radar(Radar),
    /// Position reports of equipped drones, CAT129.
    Transponder(Transponder),
}

/// A blank radar.
impl Default for SensorKind {
    fn default() -> Self {
        Self::Radar(Radar::default())
    }
}

section! {
    /// The keys of a sensor with `kind = "radar"`.
    Radar {
        /// WGS-84 latitude of the antenna, degrees, north positive.
        latitude_deg: f64 = need("latitude_deg = …, where the radar stands (WGS-84, north positive)"), Number(
            "a latitude is between -90 and 90 degrees; south is negative",
            |v| v.abs() <= 90.0,
        );
        /// WGS-84 longitude of the antenna, degrees, east positive.
        longitude_deg: f64 = need("longitude_deg = …, where the radar stands (WGS-84, east positive)"), Number(
            "a longitude is between -180 and 180 degrees; west is negative",
            |v| v.abs() <= 180.0,
        );
        /// Height of the antenna above mean sea level, metres.
        height_amsl_m: f64 =
            need("height_amsl_m = …, the antenna's height above mean sea level in metres"),
            Number(
                "the antenna is between -500 and 9000 metres above mean sea level",
                |v| (-500.0..=9000.0).contains(&v),
            );
        /// Added to every azimuth, degrees clockwise.
        bearing_correction_deg: f64 = 0.0, Number(
            "a bearing correction is between -180 and 180 degrees, clockwise positive",
            |v| v.abs() <= 180.0,
        );
        /// Instrumented range, metres. Not used by the `reference` profile.
        max_range_m: Option<f64> = absent("no limit"), Number(
            "a range is above 0 metres; leave the key out for no limit",
            |v| v > 0.0,
        );
        /// Height above mean sea level, metres, at which a plot without I048/110 is placed.
        assumed_height_amsl_m: f64 = depends("that of the antenna, `height_amsl_m`", 0.0), Number(
            "an assumed height is between -500 and 20000 metres above mean sea level",
            |v| (-500.0..=20_000.0).contains(&v),
        );
        /// Where a plot states its UAV probability, for which CAT048 has no item.
        classification: Classification = Classification::SpecialPurpose { octet: 0 }, ProbabilitySource;
        /// What is done about misalignment of the radar, as drones with transponders reveal it. Not used by the `reference`
        /// profile.
        registration: Registration = Registration::Apply, Name;
        /// Standard deviations of a plot.
        accuracy: Option<RadarAccuracy> = absent("not stated"), Inline;
    } by hand {}
}

names! {
    /// What is done about misalignment of a radar.
    pub Registration, "mode of registration" {
        /// Plots are corrected by the estimated misalignment.
        Apply = "apply",
        /// The misalignment is estimated and shown; plots stay as they are.
        Propose = "propose",
        /// Nothing.
        Off = "off",
    }
}

/// Values of a standard deviation.
const DEVIATION: Number =
    Number("a standard deviation is above 0; leave accuracy out when it is not known", |v| v > 0.0);

section! {
    /// Standard deviations of a plot.
    #[derive(Copy)]
    RadarAccuracy {
        /// Slant range, metres.
        range_m: f64 = need("range_m = …, in metres"), DEVIATION;
        /// Azimuth, degrees.
        azimuth_deg: f64 = need("azimuth_deg = …, in degrees"), DEVIATION;
        /// Height, metres.
        height_m: Option<f64> = absent("the radar measures no height"), DEVIATION;
    }
}

section! {
    /// The keys of a sensor with `kind = "transponder"`.
    Transponder {
        /// Standard deviations of a report.
        accuracy: Option<TransponderAccuracy> = absent("not stated"), Inline;
        /// Delay from the measurement of a position to the time stamp of its report, seconds. State it only where it is known.
        /// Not used by the `reference` profile.
        delay_s: Option<f64> = absent("not known"), Number(
            "a delay is between 0 and 5 seconds",
            |v| (0.0..=5.0).contains(&v),
        );
        /// Long-run limit of previously unknown identities admitted, per second; the allowance of 20 s may be used at once, so
        /// that the default admits a city of 1000 drones. Not used by the `reference` profile.
        max_new_per_s: u32 = 50, Whole(
            "a rate of new transponders is a whole number a second, from 1 to 100000",
            1..=100_000,
        );
    }
}

section! {
    /// Standard deviations of a transponder's report.
    #[derive(Copy)]
    TransponderAccuracy {
        /// Horizontal, metres per axis.
        horizontal_m: f64 = need("horizontal_m = …, in metres"), DEVIATION;
        /// Vertical, metres.
        vertical_m: f64 = need("vertical_m = …, in metres"), DEVIATION;
    }
}

names! {
    SensorName, "kind of sensor" {
        /// Plots, CAT048.
        Radar = "radar",
        /// Position reports of equipped drones, CAT129.
        Transponder = "transponder",
    }
}

impl SensorKind {
    const fn name(&self) -> SensorName {
        match self {
            Self::Radar(_) => SensorName::Radar,
            Self::Transponder(_) => SensorName::Transponder,
        }
    }
}

struct KindOfSensor;

/// Its keys are read by the sensor.
impl Kind<SensorKind> for KindOfSensor {
    fn read(&self, item: &Item<'_>) -> Option<SensorKind> {
        Some(match Name.read(item)? {
            SensorName::Radar => SensorKind::default(),
            SensorName::Transponder => SensorKind::Transponder(Transponder::default()),
        })
    }

    fn show(&self, kind: &SensorKind) -> Option<String> {
        Name.show(&kind.name())
    }

    fn values(&self) -> String {
        Kind::<SensorName>::values(&Name)
    }
}

impl ByHand for Sensor {
    fn more(&mut self, section: &mut Section<'_>) {
        if !section.is_sound(&["kind"]) {
            return section.abandon();
        }
        match &mut self.kind {
            SensorKind::Radar(radar) => *radar = Radar::read_keys(section),
            SensorKind::Transponder(transponder) => {
                *transponder = Transponder::read_keys(section);
                let own = Transponder::rows();
                for row in Radar::rows().iter().filter(|row| own.iter().all(|own| own.key != row.key)) {
                    if let Some(item) = section.stray(row.key) {
                        item.refuse(
                            "only a radar has this key, and this is a transponder; remove it, or set kind = \"radar\"",
                        );
                    }
                }
            }
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        let inputs = entries.pop();
        match &self.kind {
            SensorKind::Radar(radar) => entries.extend(radar.entries()),
            SensorKind::Transponder(transponder) => {
                if let Some(Entry { value: Err(absent), .. }) = entries.last_mut() {
                    *absent = "not stated";
                }
                entries.extend(transponder.entries());
            }
        }
        entries.extend(inputs);
    }
}

impl ByHand for Radar {
    fn more(&mut self, section: &mut Section<'_>) {
        if section.written("assumed_height_amsl_m").is_none() {
            self.assumed_height_amsl_m = self.height_amsl_m;
        }
    }
}

/// The sensors. They are told apart by their ids, and their records by kind, SAC and SIC.
pub(super) fn read(top: &mut Section<'_>, site: &Site, faults: &Faults) -> Vec<Sensor> {
    let is_site_sound = faults.none_of("site.sac") && faults.none_of("site.sic");
    let list = top.need("sensors", "[[sensors]], at least one with kind = \"radar\"");
    // Of those before: the id, and what tells the records apart, where that is known, with the path of the sensor.
    let mut ids = Vec::new();
    let mut codes = Vec::new();
    let mut is_radar_missing = true;
    let sensors = tables(list.clone(), |sensor: &Sensor, section| {
        let Sensor { id, sac, sic, .. } = sensor;
        let (kind, own) = (sensor.kind.name(), (site.sac, site.sic));
        // One of unknown kind may have been meant as the radar.
        is_radar_missing &= section.is_sound(&["kind"]) && kind != SensorName::Radar;
        if ids.contains(id) {
            section.contradict(&["id"], "another sensor has this id already; give each its own");
        }
        ids.push(id.clone());
        if !section.is_sound(&["kind", "sac", "sic"]) {
            return;
        }
        let (code, name) = ((kind, *sac, *sic), kind.name());
        if let Some((_, other)) = codes.iter().find(|(other, _)| *other == code) {
            section.contradict(
                &["sic"],
                format!(
                    "{other} is already the {name} with SAC {sac}, SIC {sic}, and records are told apart by them; \
                     give each {name} its own"
                ),
            );
        } else if is_site_sound && (*sac, *sic) == own {
            section.contradict(
                &["sic"],
                format!(
                    "SAC {sac}, SIC {sic} is the service's own ([site]), whose records are refused at the inputs; \
                     change [site] or the sensor"
                ),
            );
        }
        codes.push((code, section.key().to_owned()));
    });
    // What is no list of sensors has been refused as such.
    let is_list = !sensors.is_empty() || top.is_sound(&["sensors"]);
    if let (Some(list), true) = (list, is_radar_missing && is_list) {
        list.refuse("there is no radar, and the frame needs one as its origin; add one, kind = \"radar\"");
    }
    sensors
}

/// Where a plot states its UAV probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Classification {
    /// An octet n of I048/SP, counted from 0 after the length octet: n / 255.
    SpecialPurpose {
        /// 0 to 253.
        octet: usize,
    },
    /// The codes of I048/030: birds, vehicles, wind turbines and the like are 0, everything else 1.
    TargetClassification,
    /// One probability for every plot.
    Constant {
        /// 0 to 1.
        value: f64,
    },
}

names! {
    SourceName, "source of probabilities" {
        /// An octet n of I048/SP states n / 255.
        SpecialPurpose = "special-purpose",
        /// The codes of I048/030 state it: 0 for birds, vehicles, wind turbines and the like, 1 for everything else.
        TargetClassification = "target-classification",
        /// One probability for every plot.
        Constant = "constant",
    }
}

struct ProbabilitySource;

/// Values of `octet`.
const OCTET: Whole<u8> = Whole("octets of I048/SP are counted from 0 after the length, to 253", 0..=253);
/// Values of `value`.
const PROBABILITY: Number = Number("a probability is between 0 and 1", |v| (0.0..=1.0).contains(&v));

impl Kind<Classification> for ProbabilitySource {
    fn read(&self, item: &Item<'_>) -> Option<Classification> {
        let mut section = item.section()?;
        let source =
            section.need("source", "source = \"special-purpose\", \"target-classification\" or \"constant\"");
        let read = match source.and_then(|item| Name.read(&item))? {
            SourceName::SpecialPurpose => {
                let octet = section.item("octet").map_or(Some(0), |item| OCTET.read(&item));
                octet.map(|octet| Classification::SpecialPurpose { octet: octet.into() })
            }
            SourceName::TargetClassification => Some(Classification::TargetClassification),
            SourceName::Constant => section
                .need("value", "value = …, the probability from 0 to 1")
                .and_then(|item| PROBABILITY.read(&item))
                .map(|value| Classification::Constant { value }),
        };
        section.finish();
        read
    }

    fn show(&self, value: &Classification) -> Option<String> {
        Some(match value {
            Classification::SpecialPurpose { octet } => {
                format!("{{ source = \"special-purpose\", octet = {octet} }}")
            }
            Classification::TargetClassification => "{ source = \"target-classification\" }".to_owned(),
            Classification::Constant { value } => format!("{{ source = \"constant\", value = {value:?} }}"),
        })
    }

    fn values(&self) -> String {
        "a table with `source`".to_owned()
    }

    fn keys(&self) -> Vec<Row> {
        vec![
            Row::by_hand(
                "source",
                None,
                &Kind::<SourceName>::values(&Name),
                " Where the probability is stated.",
            ),
            Row::by_hand(
                "octet",
                Some("`0`"),
                OCTET.0,
                " Octet of I048/SP, with `source = \"special-purpose\"`.",
            ),
            Row::by_hand(
                "value",
                None,
                PROBABILITY.0,
                " The probability, with `source = \"constant\"`, and needed there.",
            ),
        ]
    }
}
