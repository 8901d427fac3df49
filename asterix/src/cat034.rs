//! Category 034, monoradar service messages, edition 1.29 (EUROCONTROL-SPEC-0149-2b).

mod message;
mod status;

use crate::record::record;
use crate::{DataSource, Explicit, Repeated, TimeOfDay};

pub use message::{
    CollimationError, CounterKind, DataFilter, Filter, MessageCount, MessageKind, MessageType, PolarWindow,
    RotationPeriod, SectorNumber, SourcePosition,
};
pub use status::{
    Channels, CommonMode, CommonStatus, ModeSMode, ModeSStatus, PsrMode, SensorStatus, SsrMode, SystemMode,
    SystemStatus,
};

record! {
    /// A CAT034 record: the items in the order of [`UAP`]; an absent item is `None`. RE precedes SP, unlike in category 048.
    pub struct Record(34) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        /// Kind of the message: a north marker, a sector crossing, …
        must 2 "000" "Message Type" message_type: MessageType;
        must 3 "030" "Time of Day" time_of_day: TimeOfDay;
        /// The sector that the antenna enters.
        may 4 "020" "Sector Number" sector_number: SectorNumber;
        /// Expressed as the time of one turn of the antenna.
        may 5 "041" "Antenna Rotation Speed" rotation_period: RotationPeriod;
        may 6 "050" "System Configuration and Status" system_status: SystemStatus;
        /// Load reduction and other modes of processing.
        may 7 "060" "System Processing Mode" system_mode: SystemMode;
        /// Number of reports of each kind.
        may 8 "070" "Message Count Values" message_counts: Repeated<MessageCount>;
        /// The part of the coverage to which the message applies.
        may 9 "100" "Generic Polar Window" polar_window: PolarWindow;
        /// The data that are filtered there.
        may 10 "110" "Data Filter" data_filter: DataFilter;
        /// Position of the radar, accurate to 2.4 m.
        may 11 "120" "3D-Position of Data Source" source_position: SourcePosition;
        /// Difference between PSR and SSR.
        may 12 "090" "Collimation Error" collimation_error: CollimationError;
        may 13 "RE" "Reserved Expansion Field" reserved_expansion: Explicit;
        may 14 "SP" "Special Purpose Field" special_purpose: Explicit;
    }
}
