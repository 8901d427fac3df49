//! Category 034, monoradar service messages, edition 1.29 (EUROCONTROL-SPEC-0149-2b).

mod message;
mod status;

use deku::{DekuRead, DekuWrite};

use crate::builder::builder;
use crate::item::{Describe, Repeated};
use crate::uap::{self, item, read, record};
use crate::{Contents, DataSource, Explicit, Fspec, Layout, TimeOfDay, UapItem};

pub use message::{
    CollimationError, CounterKind, DataFilter, Filter, MessageCount, MessageKind, MessageType, PolarWindow,
    RotationPeriod, SectorNumber, SourcePosition,
};
pub use status::{
    Channels, CommonMode, CommonStatus, ModeSMode, ModeSStatus, PsrMode, SensorStatus, SsrMode, SystemMode,
    SystemStatus,
};

/// The items of category 034, edition 1.29, in the order of the record: `UAP[n]` has FRN n + 1. RE stands before SP, the
/// reverse of category 048.
pub const UAP: [UapItem; 14] = [
    item(1, "010", "Data Source Identifier", DataSource::LAYOUT),
    item(2, "000", "Message Type", MessageType::LAYOUT),
    item(3, "030", "Time of Day", TimeOfDay::LAYOUT),
    item(4, "020", "Sector Number", SectorNumber::LAYOUT),
    item(5, "041", "Antenna Rotation Speed", RotationPeriod::LAYOUT),
    item(6, "050", "System Configuration and Status", SystemStatus::LAYOUT),
    item(7, "060", "System Processing Mode", SystemMode::LAYOUT),
    item(8, "070", "Message Count Values", Repeated::<MessageCount>::LAYOUT),
    item(9, "100", "Generic Polar Window", PolarWindow::LAYOUT),
    item(10, "110", "Data Filter", DataFilter::LAYOUT),
    item(11, "120", "3D-Position of Data Source", SourcePosition::LAYOUT),
    item(12, "090", "Collimation Error", CollimationError::LAYOUT),
    item(13, "RE", "Reserved Expansion Field", Layout::Explicit(Contents::Opaque)),
    item(14, "SP", "Special Purpose Field", Layout::Explicit(Contents::Opaque)),
];

/// A CAT034 record: the items in the order of [`UAP`]; an absent item is `None`.
#[derive(Clone, Debug, Default, PartialEq, DekuRead, DekuWrite)]
#[deku(ctx = "fspec: Fspec")]
pub struct Record {
    /// I034/010, the radar.
    #[deku(reader = "read(deku::reader, fspec, 1)")]
    pub data_source: Option<DataSource>,
    /// I034/000, what is said: a north marker, a sector crossing, …
    #[deku(reader = "read(deku::reader, fspec, 2)")]
    pub message_type: Option<MessageType>,
    /// I034/030, when it was said.
    #[deku(reader = "read(deku::reader, fspec, 3)")]
    pub time_of_day: Option<TimeOfDay>,
    /// I034/020, the sector that the antenna enters.
    #[deku(reader = "read(deku::reader, fspec, 4)")]
    pub sector_number: Option<SectorNumber>,
    /// I034/041, time of one turn of the antenna.
    #[deku(reader = "read(deku::reader, fspec, 5)")]
    pub rotation_period: Option<RotationPeriod>,
    /// I034/050, configuration and status of the radar.
    #[deku(reader = "read(deku::reader, fspec, 6)")]
    pub system_status: Option<SystemStatus>,
    /// I034/060, what the radar leaves out under load.
    #[deku(reader = "read(deku::reader, fspec, 7)")]
    pub system_mode: Option<SystemMode>,
    /// I034/070, how many reports of each kind were sent.
    #[deku(reader = "read(deku::reader, fspec, 8)")]
    pub message_counts: Option<Repeated<MessageCount>>,
    /// I034/100, the part of the coverage that the message is about.
    #[deku(reader = "read(deku::reader, fspec, 9)")]
    pub polar_window: Option<PolarWindow>,
    /// I034/110, what is filtered there.
    #[deku(reader = "read(deku::reader, fspec, 10)")]
    pub data_filter: Option<DataFilter>,
    /// I034/120, where the radar stands: to 2.4 m.
    #[deku(reader = "read(deku::reader, fspec, 11)")]
    pub source_position: Option<SourcePosition>,
    /// I034/090, how far PSR and SSR are apart.
    #[deku(reader = "read(deku::reader, fspec, 12)")]
    pub collimation_error: Option<CollimationError>,
    /// RE, the reserved expansion field.
    #[deku(reader = "read(deku::reader, fspec, 13)")]
    pub reserved_expansion: Option<Explicit>,
    /// SP, the special purpose field.
    #[deku(reader = "read(deku::reader, fspec, 14)")]
    pub special_purpose: Option<Explicit>,
    /// FSPEC octets beyond the minimal ones, which announce nothing; 0 in a record built anew. The whole FSPEC never gets
    /// longer than [`Fspec::MAX_OCTETS`].
    #[deku(skip, default = "fspec.padding()")]
    pub fspec_padding: u8,
}

builder! {
    34,
    must {
        data_source: DataSource = "010",
        message_type: MessageType = "000",
        time_of_day: TimeOfDay = "030",
    }
    may {
        sector_number: SectorNumber = "020",
        rotation_period: RotationPeriod = "041",
        system_status: SystemStatus = "050",
        system_mode: SystemMode = "060",
        message_counts: Repeated<MessageCount> = "070",
        polar_window: PolarWindow = "100",
        data_filter: DataFilter = "110",
        source_position: SourcePosition = "120",
        collimation_error: CollimationError = "090",
        reserved_expansion: Explicit = "RE",
        special_purpose: Explicit = "SP",
    }
}

record! {
    34 {
        1 data_source,
        2 message_type,
        3 time_of_day,
        4 sector_number,
        5 rotation_period,
        6 system_status,
        7 system_mode,
        8 message_counts,
        9 polar_window,
        10 data_filter,
        11 source_position,
        12 collimation_error,
        13 reserved_expansion,
        14 special_purpose,
    }
    uap::decode, uap::encode
}
