//! What a configuration holds, with units. Every value here has passed the rules of its reader.

use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::str::FromStr;

use jiff::SignedDuration;

/// Slots of the window and of `max_future` together: the engine keeps sets of slots in 128-bit words, and needs room
/// for the slot that leaves the window and for one that a waiting report has just begun.
pub const MAX_WINDOW_SLOTS: u32 = 126;

/// `[site]`: the service itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Shown on the interfaces.
    pub name: String,
    /// System area code of what the service sends (I129/010).
    pub sac: u8,
    /// System identification code of what the service sends (I129/010).
    pub sic: u8,
    /// Geoid above the ellipsoid, metres; `None`: EGM96 at the first radar.
    pub geoid_undulation_m: Option<f64>,
}

/// `[[sensors]]`: a source of reports. (kind, SAC, SIC) is unique, and never the service's own SAC and SIC.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Unique, of letters, digits, `_` and `-`: it becomes part of track ids.
    pub id: String,
    /// System area code of its records.
    pub sac: u8,
    /// System identification code of its records.
    pub sic: u8,
    /// Seconds between two reports of one target; `None`: not stated (0.25 where a radar's is needed).
    pub period_s: Option<f64>,
    /// Where to listen for it live; several are redundant lines. A replay does not need any.
    pub inputs: Vec<Input>,
    /// What kind it is, and what only that kind has.
    pub kind: SensorKind,
}

/// Radar (CAT048) or transponder receiver (CAT129).
#[derive(Clone, Debug, PartialEq)]
pub enum SensorKind {
    /// Plots, CAT048.
    Radar(Radar),
    /// Position reports of equipped drones, CAT129.
    Transponder(Transponder),
}

/// What only a radar has.
#[derive(Clone, Debug, PartialEq)]
pub struct Radar {
    /// WGS-84 latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// WGS-84 longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height of the antenna above mean sea level, metres.
    pub height_amsl_m: f64,
    /// Added to every azimuth, degrees clockwise.
    pub bearing_correction_deg: f64,
    /// Instrumented range, metres; not used by the `reference` profile.
    pub max_range_m: Option<f64>,
    /// Height above mean sea level, metres, that gives a plot without I048/110 its horizontal position; by default
    /// the radar's own.
    pub assumed_height_amsl_m: f64,
    /// Where a plot states its UAV probability.
    pub classification: Classification,
    /// One standard deviation of a plot.
    pub accuracy: Option<RadarAccuracy>,
    /// What is done about its being set up wrongly; not used by the `reference` profile.
    pub registration: Registration,
}

/// What is done about a radar's being set up wrongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Registration {
    /// Nothing.
    Off,
    /// It is estimated and shown; plots stay as they are.
    Propose,
    /// Plots are put right by what is estimated.
    #[default]
    Apply,
}

impl Registration {
    /// As the configuration has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Propose => "propose",
            Self::Apply => "apply",
        }
    }
}

/// Where a plot states how likely it is a UAV: CAT048 has no item for it.
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

/// Standard deviations of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarAccuracy {
    /// Slant range, metres.
    pub range_m: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Height, metres; `None` for a radar that measures none.
    pub height_m: Option<f64>,
}

/// What only a transponder receiver has.
#[derive(Clone, Debug, PartialEq)]
pub struct Transponder {
    /// One standard deviation of a report.
    pub accuracy: Option<TransponderAccuracy>,
    /// Reports are stamped so long after their position was measured, seconds; `None`: not known. Not used by the `reference`
    /// profile.
    pub delay_s: Option<f64>,
    /// So many identities that were not known before are let in a second, in the long run; above 0. Not used by the
    /// `reference` profile.
    pub max_new_per_s: u32,
}

impl Transponder {
    /// Where `max_new_per_s` is left out: with what gathers in 20 s, a city of 1,000 drones is let in at once.
    pub const MAX_NEW_PER_S: u32 = 50;
}

/// Standard deviations of a transponder report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransponderAccuracy {
    /// Horizontal, metres.
    pub horizontal_m: f64,
    /// Vertical, metres.
    pub vertical_m: f64,
}

/// A UDP line to listen on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Input {
    /// The group to join, or the local address to bind (`0.0.0.0`: all).
    pub address: Address,
    /// UDP port.
    pub port: u16,
    /// Only datagrams from here count; a group is joined source-specifically.
    pub source: Option<Ipv4Addr>,
    /// Octets that the sender puts behind the blocks of each datagram; `None`: recognised.
    pub trailer_octets: Option<u8>,
}

/// A UDP destination.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sink {
    /// The group or host to send to.
    pub address: Address,
    /// UDP port.
    pub port: u16,
    /// Time to live, hops; by default 1 for a group and 64 for a host.
    pub ttl: u8,
}

impl Sink {
    /// `239.192.129.2:8130 from 127.0.0.1`, for people.
    pub fn name(&self) -> String {
        match self.address {
            Address::Multicast { group, interface } => format!("{group}:{} from {interface}", self.port),
            Address::Unicast(address) => format!("{address}:{}", self.port),
        }
    }
}

/// A multicast group or a single address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// `group`, 224.0.0.0/4.
    Multicast {
        /// The group.
        group: Ipv4Addr,
        /// Address of the network interface to use; `0.0.0.0` leaves it to the routing table.
        interface: Ipv4Addr,
    },
    /// `address`.
    Unicast(Ipv4Addr),
}

/// Which rules the engine follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Profile {
    /// The published algorithm and nothing else.
    Reference,
    /// Better estimation from the same inputs; `docs/OPERATIONAL.md`.
    #[default]
    Operational,
}

/// There is no profile of that name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no such profile; use \"operational\" or \"reference\"")]
pub struct UnknownProfile;

impl Profile {
    /// The profile's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Operational => "operational",
        }
    }
}

/// By name.
impl FromStr for Profile {
    type Err = UnknownProfile;

    fn from_str(name: &str) -> Result<Self, UnknownProfile> {
        match name {
            "reference" => Ok(Self::Reference),
            "operational" => Ok(Self::Operational),
            _ => Err(UnknownProfile),
        }
    }
}

/// How the `operational` profile takes aircraft to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Motion {
    /// Interacting multiple models: straight on, and turns.
    #[default]
    Imm,
    /// An acceleration that lasts for a while (R. A. Singer, 1970).
    Singer,
}

/// There is no model of motion of that name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no such model of motion; use \"imm\" or \"singer\"")]
pub struct UnknownMotion;

impl Motion {
    /// As the configuration has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Imm => "imm",
            Self::Singer => "singer",
        }
    }
}

/// By name.
impl FromStr for Motion {
    type Err = UnknownMotion;

    fn from_str(name: &str) -> Result<Self, UnknownMotion> {
        match name {
            "imm" => Ok(Self::Imm),
            "singer" => Ok(Self::Singer),
            _ => Err(UnknownMotion),
        }
    }
}

/// `[fusion]`: the engine. Its [`Default`] is that of an empty section.
#[derive(Clone, Debug, PartialEq)]
pub struct Fusion {
    /// The rules it follows.
    pub profile: Profile,
    /// How aircraft are taken to move; not used by the `reference` profile.
    pub motion: Motion,
    /// Length of a slot: whole milliseconds.
    pub slot: SignedDuration,
    /// A slot is emitted this many slots after it opened; at least 1, below `window_slots`.
    pub latency_slots: u32,
    /// Slots of the window, newest included; with `max_future` at most
    /// [`MAX_WINDOW_SLOTS`].
    pub window_slots: u32,
    /// A report further ahead of its reception is dropped; 0 to the latency.
    pub max_future: SignedDuration,
    /// Nothing is interpolated between two transponder reports further apart.
    pub max_gap: SignedDuration,
    /// Association distance in metres over slant range in metres: rows (range, distance) of rising range, linear
    /// between them and constant beyond the ends.
    pub threshold_m: Vec<(f64, f64)>,
    /// Share of a pair's common slots within the threshold that associates it; above 0, at most 1.
    pub ratio_min: f64,
    /// Common slots that a pair needs; 1 to `window_slots`.
    pub min_samples: u32,
    /// Weight of the radar's position in the mean.
    pub weight_radar: f64,
    /// Weight of the transponder's position in the mean.
    pub weight_transponder: f64,
    /// A radar track alone is put out after more than this time with UAV probability, seconds.
    pub radar_only_min_s: f64,
    /// A transponder alone is held back this many slots before and after an association.
    pub suppress_slots: u32,
    /// Transponder number of a serial (I129/040, trimmed).
    pub transponder_numbers: BTreeMap<String, u32>,
}

impl Fusion {
    /// How long after it opened a slot is emitted.
    pub fn latency(&self) -> SignedDuration {
        self.slot.saturating_mul(self.latency_slots as i32)
    }

    /// The length of the window.
    pub fn window(&self) -> SignedDuration {
        self.slot.saturating_mul(self.window_slots as i32)
    }

    /// How long before and after an association a transponder alone is held back.
    pub fn suppress(&self) -> SignedDuration {
        self.slot.saturating_mul(self.suppress_slots as i32)
    }
}

impl Default for Fusion {
    fn default() -> Self {
        Self {
            profile: Profile::default(),
            motion: Motion::default(),
            slot: SignedDuration::from_millis(250),
            latency_slots: 25,
            window_slots: 100,
            max_future: SignedDuration::from_secs(1),
            max_gap: SignedDuration::from_secs(25),
            threshold_m: vec![(0.0, 60.0), (333.33, 60.0), (4333.33, 300.0)],
            ratio_min: 0.9,
            min_samples: 4,
            weight_radar: 1.0,
            weight_transponder: 10.0,
            radar_only_min_s: 8.0,
            suppress_slots: 16,
            transponder_numbers: BTreeMap::new(),
        }
    }
}

/// `[[areas]]`: a file of polygons and what they are for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area {
    /// What the polygons are for.
    pub kind: AreaKind,
    /// GeoJSON; an absolute path (in the file it is relative to the configuration).
    pub file: PathBuf,
}

/// What the polygons of an area are for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AreaKind {
    /// Plots inside are dropped.
    Mask,
    /// Where a sensor sees.
    Coverage {
        /// The id of that sensor.
        sensor: String,
    },
    /// Tracks inside raise an alert.
    Alert,
}

/// `[output]`: what is sent and recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Where the fused CAT129 goes.
    pub asterix: Vec<Sink>,
    /// What I129/040 holds.
    pub serial: SerialSource,
    /// A CAT065 service status each second on the sinks.
    pub status: bool,
    /// What the window still holds is emitted when the service stops.
    pub flush_on_stop: bool,
    /// Recording of what arrives.
    pub record: Option<Record>,
}

/// What I129/040 of a fused or transponder-only record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SerialSource {
    /// The aircraft's own serial.
    Uas,
    /// The track number, for readers that know only this item.
    TrackNumber,
}

/// Recording into rotating capture files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    /// Directory, relative to the working directory.
    pub dir: PathBuf,
    /// A new file starts at this size, MiB.
    pub rotate_mib: u32,
    /// The newest files that are kept.
    pub keep: u32,
}

/// `[state]`: what outlives a restart.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Directory, relative to the working directory.
    pub dir: PathBuf,
    /// The history goes back this far, hours; 0: none is kept.
    pub history_hours: f64,
    /// The history takes at most about this much of the disk, MiB.
    pub history_mib: u32,
}
