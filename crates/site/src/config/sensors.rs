//! `[[sensors]]`.

use serde::{Deserialize, Serialize};

use super::adsb::AdsB;
use super::classification::{Classification, probability_source};
use super::connections::{Connection, ConnectionFormat};
use super::network::Input;
use super::site::{Site, area_code, check_origin, identification_code};
use tables::error::Faults;
use tables::kinds::{Kind, checked_tables, flag, inline, is_plain, named, number, tables, text, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Table, absent, depends, need};
use tables::{names, written_by_name};

section! {
    /// Sources of reports. Sensors of one kind are distinguished by SAC and SIC, which must differ from those of the service. The
    /// first radar is the origin of the local frame; without a radar, `[site]` sets the origin.
    Sensor {
        /// Name of the sensor, unique among the sensors; part of track ids.
        id: String = need("a name for the sensor, such as id = \"north\""),
            text("an id becomes part of track ids; use only letters A-Z a-z, digits, _ and -", is_plain);
        /// Kind of sensor. Each kind has more keys, below.
        kind: SensorKind = need(
            "kind = \"radar\" (CAT048), \"transponder\" (CAT129), \"adsb\" (CAT021), \"remote-id\" or \"camera\" (CAT015)",
        ), named();
        /// System area code of the sensor's records. For a sensor that does not send ASTERIX, the service uses it to name the
        /// sensor in its outputs.
        sac: u8 = need("sac = …, the system area code (SAC) of its records"), area_code();
        /// System identification code of the sensor's records, used like `sac`.
        sic: u8 = need("sic = …, the system identification code (SIC) of its records"), identification_code();
        /// Time between two reports of one target, in seconds.
        period_s: Option<f64> = absent("not stated, 0.25 is assumed"),
            number("a period is above 0 and at most 3600 seconds", |s| s > 0.0 && s <= 3600.0);
        /// UDP inputs to listen on. Several inputs are redundant: copies of a report are processed once. Inputs with different
        /// senders complement each other if each names its `source`. A replay needs none.
        inputs: Vec<Input> = Vec::new(), tables();
        /// Receivers and gateways with other protocols than ASTERIX over UDP (docs/INPUTS.md). Their data are translated to
        /// ASTERIX or Remote ID lines on reception, and recorded in that form. For a radar only the format `"asterix"` is
        /// possible.
        connections: Vec<Connection> = depends("none", Vec::new()), tables();
    } by hand {}
}

names! {
    /// Kind of sensor: a radar, or a receiver of reports from aircraft or cameras.
    SensorKind, "kind of sensor" {
        /// Plots, CAT048.
        Radar(Radar) = "radar",
        /// Position reports of equipped drones, CAT129.
        Transponder(Transponder) = "transponder",
        /// Position reports of aircraft with ADS-B, CAT021.
        AdsB(AdsB) = "adsb",
        /// Remote ID broadcasts of drones (ASTM F3411), as messages or as a gateway's lines.
        RemoteId(Transponder) = "remote-id",
        /// Bearings of an EO/IR camera head, CAT015. They improve the tracks of other sensors; the bearings of two cameras create tracks.
        Camera(Camera) = "camera",
    }
}
written_by_name!(SensorKind, Registration);

impl SensorKind {
    /// Keys of a radar.
    pub fn radar(&self) -> Option<&Radar> {
        match self {
            Self::Radar(radar) => Some(radar),
            Self::Transponder(_) | Self::AdsB(_) | Self::RemoteId(_) | Self::Camera(_) => None,
        }
    }

    /// Whether the sensor is a radar.
    pub fn is_radar(&self) -> bool {
        self.radar().is_some()
    }

    /// Keys shared by receivers.
    pub fn receiver(&self) -> Option<&Transponder> {
        match self {
            Self::Radar(_) | Self::Camera(_) => None,
            Self::Transponder(receiver) | Self::AdsB(AdsB { receiver, .. }) | Self::RemoteId(receiver) => {
                Some(receiver)
            }
        }
    }

    /// Position of a sensor whose position matters: latitude and longitude in degrees, and height above mean sea level in metres.
    pub fn place(&self) -> Option<(f64, f64, f64)> {
        match self {
            Self::Radar(Radar { latitude_deg, longitude_deg, height_amsl_m, .. })
            | Self::Camera(Camera { latitude_deg, longitude_deg, height_amsl_m, .. }) => {
                Some((*latitude_deg, *longitude_deg, *height_amsl_m))
            }
            Self::Transponder(_) | Self::AdsB(_) | Self::RemoteId(_) => None,
        }
    }

    /// Whether the sensor is a camera.
    pub fn is_camera(&self) -> bool {
        matches!(self, Self::Camera(_))
    }

    /// Whether the sensor receives CAT129.
    pub fn is_transponder(&self) -> bool {
        matches!(self, Self::Transponder(_))
    }

    /// Default time between two reports of one target, in seconds.
    pub const fn usual_period_s(&self) -> f64 {
        match self {
            Self::Radar(_) | Self::Camera(_) => 0.25,
            Self::Transponder(_) => 2.0,
            Self::AdsB(_) | Self::RemoteId(_) => 1.0,
        }
    }

    /// Format of the sensor's data.
    pub const fn language(&self) -> &'static str {
        match self {
            Self::Radar(_) => "CAT048",
            Self::Transponder(_) => "CAT129",
            Self::AdsB(_) => "CAT021",
            Self::RemoteId(_) => "Remote ID",
            Self::Camera(_) => "CAT015",
        }
    }
}

/// Placeholder of a sensor whose kind is not read yet: a radar without values.
impl Default for SensorKind {
    fn default() -> Self {
        Self::Radar(Radar::default())
    }
}

section! {
    /// Keys of a sensor with `kind = "radar"`.
    Radar {
        /// WGS-84 latitude of the antenna, in degrees, north positive.
        latitude_deg: f64 = need("latitude_deg = …, where the radar stands (WGS-84, north positive)"), latitude();
        /// WGS-84 longitude of the antenna, in degrees, east positive.
        longitude_deg: f64 = need("longitude_deg = …, where the radar stands (WGS-84, east positive)"), longitude();
        /// Height of the antenna above mean sea level, in metres.
        height_amsl_m: f64 =
            need("height_amsl_m = …, the antenna's height above mean sea level in metres"), height_amsl();
        /// Correction added to every azimuth, in degrees clockwise.
        bearing_correction_deg: f64 = 0.0,
            number("a bearing correction is between -180 and 180 degrees, clockwise positive", |v| v.abs() <= 180.0);
        /// Instrumented range, in metres. Not used by the `reference` profile.
        max_range_m: Option<f64> = absent("no limit"),
            number("a range is above 0 metres; leave the key out for no limit", |v| v > 0.0);
        /// Height above mean sea level assumed for plots without I048/110, in metres.
        assumed_height_amsl_m: f64 = depends("that of the antenna, `height_amsl_m`", 0.0), number(
            "an assumed height is between -500 and 20000 metres above mean sea level",
            |v| (-500.0..=20_000.0).contains(&v),
        );
        /// How a plot states its UAV probability, for which CAT048 has no item.
        classification: Classification = Classification::of_octet(0), probability_source();
        /// Treatment of a misalignment of the radar, estimated from drones with transponders. Not used by the `reference`
        /// profile.
        registration: Registration = Registration::Apply, named();
        /// Standard deviations of a plot.
        accuracy: Option<RadarAccuracy> = absent("not stated"), inline::<RadarAccuracy>();
        /// Whether the errors of the radar and of its velocities are learnt from drones with transponders, starting from
        /// `accuracy`. If false, `accuracy` is used unchanged and velocities are trusted. Needs `registration` other than
        /// `"off"`. Not used by the `reference` profile.
        learn_accuracy: bool = true, flag();
    } by hand {}
}

/// Kind of a latitude, in degrees.
pub(super) fn latitude() -> Kind<f64> {
    number("a latitude is between -90 and 90 degrees; south is negative", |v| v.abs() <= 90.0)
}

/// Kind of a longitude, in degrees.
pub(super) fn longitude() -> Kind<f64> {
    number("a longitude is between -180 and 180 degrees; west is negative", |v| v.abs() <= 180.0)
}

/// Kind of the height of a fixed installation, in metres above mean sea level.
pub(super) fn height_amsl() -> Kind<f64> {
    number("the antenna is between -500 and 9000 metres above mean sea level", |v| {
        (-500.0..=9000.0).contains(&v)
    })
}

names! {
    /// Treatment of a misalignment of a radar.
    #[derive(Copy, Eq, Serialize, Deserialize)]
    Registration, "mode of registration" {
        /// Plots are corrected by the estimated misalignment.
        Apply = "apply",
        /// The misalignment is estimated and published; plots stay unchanged.
        Propose = "propose",
        /// The misalignment is not estimated.
        Off = "off",
    }
}

fn deviation() -> Kind<f64> {
    number(
        "a standard deviation is above 0, from 0.000001 to 1000000; leave accuracy out when it is not known",
        |v| (1e-6..=1e6).contains(&v),
    )
}

section! {
    /// Standard deviations of a plot.
    #[derive(Copy)]
    RadarAccuracy {
        /// Standard deviation of the slant range, in metres.
        range_m: f64 = need("range_m = …, in metres"), deviation();
        /// Standard deviation of the azimuth, in degrees.
        azimuth_deg: f64 = need("azimuth_deg = …, in degrees"), deviation();
        /// Standard deviation of the height, in metres.
        height_m: Option<f64> = absent("the radar measures no height"), deviation();
    }
}

section! {
    /// Keys of a sensor with `kind = "transponder"` or `"remote-id"`.
    Transponder {
        /// Standard deviations of a report.
        accuracy: Option<TransponderAccuracy> = absent("not stated"), inline::<TransponderAccuracy>();
        /// Delay from the measurement of a position to the time stamp of its report, in seconds. Set it only if it is known. Not
        /// used by the `reference` profile.
        delay_s: Option<f64> = absent("not known"),
            number("a delay is between 0 and 5 seconds", |v| (0.0..=5.0).contains(&v));
        /// Maximum long-term rate of new identities, per second. The allowance of 20 s may be used at once: the default admits
        /// 1000 drones in one burst. Not used by the `reference` profile.
        max_new_per_s: u32 = 50,
            whole("a rate of new transponders is a whole number a second, from 1 to 100000", 1..=100_000);
    }
}

section! {
    /// Keys of a sensor with `kind = "camera"`.
    Camera {
        /// WGS-84 latitude of the camera head, in degrees, north positive.
        latitude_deg: f64 = need("latitude_deg = …, where the camera stands (WGS-84, north positive)"), latitude();
        /// WGS-84 longitude of the camera head, in degrees, east positive.
        longitude_deg: f64 = need("longitude_deg = …, where the camera stands (WGS-84, east positive)"), longitude();
        /// Height of the camera head above mean sea level, in metres.
        height_amsl_m: f64 = need("height_amsl_m = …, the camera's height above mean sea level in metres"), height_amsl();
        /// Correction added to every azimuth, in degrees clockwise.
        bearing_correction_deg: f64 = 0.0,
            number("a bearing correction is between -180 and 180 degrees, clockwise positive", |v| v.abs() <= 180.0);
        /// Standard deviation of the configured orientation about each axis, in degrees. The orientation is learnt from aircraft
        /// with transponders, and the camera improves no track before. 0: the orientation is exact, and nothing is learnt.
        orientation_deg: f64 = 3.0,
            number("the deviation of an orientation is between 0 and 30 degrees", |v| (0.0..=30.0).contains(&v));
        /// Standard deviations of a bearing.
        accuracy: Option<CameraAccuracy> = absent("not stated, 0.2 degrees are assumed"), inline::<CameraAccuracy>();
    }
}

section! {
    /// Standard deviations of a bearing.
    #[derive(Copy)]
    CameraAccuracy {
        /// Standard deviation of the azimuth, in degrees.
        azimuth_deg: f64 = need("azimuth_deg = …, in degrees"), deviation();
        /// Standard deviation of the elevation, in degrees.
        elevation_deg: f64 = need("elevation_deg = …, in degrees"), deviation();
    }
}

section! {
    /// Standard deviations of a transponder's report.
    #[derive(Copy)]
    TransponderAccuracy {
        /// Horizontal standard deviation per axis, in metres.
        horizontal_m: f64 = need("horizontal_m = …, in metres"), deviation();
        /// Vertical standard deviation, in metres.
        vertical_m: f64 = need("vertical_m = …, in metres"), deviation();
    }
}

impl ByHand for Sensor {
    fn more(&mut self, section: &mut Section<'_>) {
        if !section.is_sound(&["kind"]) {
            return section.abandon();
        }
        let own = match &mut self.kind {
            SensorKind::Radar(radar) => read_into(radar, section),
            SensorKind::Transponder(transponder) => read_into(transponder, section),
            SensorKind::AdsB(adsb) => read_into(adsb, section),
            SensorKind::RemoteId(remote_id) => read_into(remote_id, section),
            SensorKind::Camera(camera) => read_into(camera, section),
        };
        let this = self.kind.name();
        if let Some(stray) = self.connections.iter().find(|of| !of.format.kinds().contains(&this)) {
            let (format, kind) = (stray.format.name(), stray.format.kinds()[0]);
            section.contradict(
                &["connections"],
                format!("a connection with format = \"{format}\" belongs to a sensor with kind = \"{kind}\", and this is \"{this}\""),
            );
        }
        self.check_systems(section);
        self.check_lines(section);
        let is_pinned = self.inputs.iter().any(|input| input.source.is_some());
        let is_open = |of: &&Connection| of.format == ConnectionFormat::Http || of.is_listener();
        if let Some(open) = self.connections.iter().find(is_open).filter(|_| is_pinned) {
            section.contradict(
                &["connections"],
                format!(
                    "a connection with format = \"{}\" takes what any host sends, and an input of this sensor names the only \
                     source; give the connection a sensor of its own",
                    open.format.name()
                ),
            );
        }
        let others = [("radar", Radar::rows()), ("transponder", Transponder::rows()), ("adsb", AdsB::rows())];
        let mut known = own;
        for (kind, rows) in others {
            for row in rows {
                if known.contains(&row.key) {
                    continue;
                }
                known.push(row.key);
                if let Some(item) = section.stray(row.key) {
                    item.refuse(format!(
                        "only a sensor of kind \"{kind}\" has this key, and this is a sensor of kind \"{this}\"; remove it, or \
                         set kind = \"{kind}\""
                    ));
                }
            }
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        let connections = entries.pop().filter(|_| !self.connections.is_empty());
        let inputs = entries.pop();
        if !self.kind.is_radar()
            && let Some(Entry { value: Err(absent), .. }) = entries.last_mut()
        {
            *absent = "not stated";
        }
        entries.extend(match &self.kind {
            SensorKind::Radar(radar) => radar.entries(),
            SensorKind::Transponder(transponder) => transponder.entries(),
            SensorKind::AdsB(adsb) => adsb.entries(),
            SensorKind::RemoteId(remote_id) => remote_id.entries(),
            SensorKind::Camera(camera) => camera.entries(),
        });
        entries.extend(inputs);
        entries.extend(connections);
    }
}

/// Reads the keys of a kind into `kind`, and returns their names.
fn read_into<T: Table>(kind: &mut T, section: &mut Section<'_>) -> Vec<&'static str> {
    *kind = T::read_keys(section);
    T::rows().iter().map(|row| row.key).collect()
}

impl ByHand for Radar {
    fn more(&mut self, section: &mut Section<'_>) {
        if section.written("assumed_height_amsl_m").is_none() {
            self.assumed_height_amsl_m = self.height_amsl_m;
        }
    }
}

/// Reads the sensors. Ids are unique, and so are SAC and SIC among the sensors of a kind.
pub(super) fn read(top: &mut Section<'_>, site: &Site, faults: &Faults) -> Vec<Sensor> {
    let is_site_sound = faults.none_of("site.sac") && faults.none_of("site.sic");
    let list = top.need("sensors", "[[sensors]], at least one");
    // Ids and source codes of the previous sensors, where valid, with the path of the sensor.
    let mut ids = Vec::new();
    let mut codes = Vec::new();
    let mut ports = Vec::new();
    let mut is_radar_missing = true;
    let sensors = checked_tables(list.clone(), |sensor: &Sensor, section| {
        let Sensor { id, sac, sic, .. } = sensor;
        let (name, own) = (sensor.kind.name(), (site.sac, site.sic));
        // A sensor of unknown kind may have been meant as a radar.
        is_radar_missing &= section.is_sound(&["kind"]) && !matches!(sensor.kind, SensorKind::Radar(_));
        if ids.contains(id) {
            section.contradict(&["id"], "another sensor has this id already; give each its own");
        }
        ids.push(id.clone());
        for socket in sensor.connections.iter().filter(|of| of.has_lines()).filter_map(Connection::socket) {
            if ports.contains(&socket.port()) {
                let message = "another sensor listens for lines on this port already; give each its own";
                section.contradict(&["connections"], message);
            }
            ports.push(socket.port());
        }
        if !section.is_sound(&["kind", "sac", "sic"]) {
            return;
        }
        let code = (name, *sac, *sic);
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
    // A value that is not a list of sensors has been refused already.
    let is_list = !sensors.is_empty() || top.is_sound(&["sensors"]);
    match list {
        Some(list) if sensors.is_empty() && is_list => list.refuse("there is no sensor; add one"),
        _ if is_list => check_origin(top, !is_radar_missing, faults),
        _ => {}
    }
    sensors
}
