//! Category 065, service status reports of a surveillance data processing system, edition 1.6
//! (EUROCONTROL-SPEC-0149-15).

use deku::{DekuRead, DekuWrite};

use crate::builder::builder;
use crate::item::{Describe, codes, item};
use crate::uap::{self, item, read, record};
use crate::{Contents, DataSource, Explicit, Fspec, Layout, TimeOfDay, UapItem};

codes! {
    /// The kinds of reports in I065/000.
    pub enum MessageKind {
        /// status of the system: I065/040 is in it.
        SystemStatus = 1,
        /// end of a batch of tracks: I065/020 is in it.
        EndOfBatch = 2,
        /// service status: I065/050 is in it.
        ServiceStatus = 3,
    }
}

item! {
    /// I065/000 (5.2.1), message type.
    pub struct MessageType(1) {
        /// What is said.
        code 8 "" kind / with_kind: MessageKind;
    }
}

item! {
    /// I065/015 (5.2.3), service identification: which of the system's services, as the system numbers them.
    pub struct ServiceIdentification(1) {
        /// The number, 0 to 255.
        count 8 "" number / with_number: u8;
    }
}

item! {
    /// I065/020 (5.2.4), batch number: which part of a cycle of track reports has been sent.
    pub struct BatchNumber(1) {
        /// The number, 0 to the number of batches in a cycle less 1.
        count 8 "" number / with_number: u8;
    }
}

codes! {
    /// NOGO in I065/040: may the data be used?
    pub enum OperationalStatus {
        /// operational.
        Operational = 0,
        /// degraded.
        Degraded = 1,
        /// not connected.
        NotConnected = 2,
        /// unknown.
        Unknown = 3,
    }
}

codes! {
    /// PSS in I065/040: which processing system is selected.
    pub enum ProcessingSystem {
        /// not applicable.
        NotApplicable = 0,
        /// the first.
        First = 1,
        /// the second.
        Second = 2,
        /// the third.
        Third = 3,
    }
}

item! {
    /// I065/040 (5.2.6), configuration and status of the system.
    pub struct SystemStatus(1) {
        /// NOGO: may the data be used?
        code 2 "nogo" operational_status / with_operational_status: OperationalStatus;
        /// OVL: overloaded.
        flag "ovl" is_overloaded / with_overloaded;
        /// TSV: the time source is invalid.
        flag "tsv" is_time_invalid / with_time_invalid;
        /// PSS, the processing system that is selected.
        code 2 "pss" processing_system / with_processing_system: ProcessingSystem;
        /// STTN: changes whenever the system begins to number its tracks anew.
        flag "sttn" renumbering / with_renumbering;
        spare 1 "spare";
    }
}

codes! {
    /// What happened to the service in I065/050.
    pub enum ServiceEvent {
        /// service degradation.
        Degraded = 1,
        /// service degradation ended.
        DegradationEnded = 2,
        /// main radar out of service.
        MainRadarOut = 3,
        /// service interrupted by the operator.
        InterruptedByOperator = 4,
        /// service interrupted due to contingency.
        InterruptedByContingency = 5,
        /// ready for a restart of the service after contingency.
        ReadyAfterContingency = 6,
        /// service ended by the operator.
        EndedByOperator = 7,
        /// failure of the user's main radar.
        UserMainRadarFailed = 8,
        /// service restarted by the operator.
        RestartedByOperator = 9,
        /// main radar becomes operational.
        MainRadarOperational = 10,
        /// main radar becomes degraded.
        MainRadarDegraded = 11,
        /// service continuity interrupted: the adjacent unit is disconnected.
        ContinuityInterrupted = 12,
        /// service continuity restarted.
        ContinuityRestarted = 13,
        /// service synchronised on the backup radar.
        OnBackupRadar = 14,
        /// service synchronised on the main radar.
        OnMainRadar = 15,
        /// main and backup radar, if any, failed.
        RadarsFailed = 16,
    }
}

item! {
    /// I065/050 (5.2.7), service status report.
    pub struct ServiceStatus(1) {
        /// What happened to the service.
        code 8 "" event / with_event: ServiceEvent;
    }
}

/// The items of category 065, edition 1.6, in the order of the record. FRN 8 to 12 are not defined.
pub const UAP: [UapItem; 9] = [
    item(1, "010", "Data Source Identifier", DataSource::LAYOUT),
    item(2, "000", "Message Type", MessageType::LAYOUT),
    item(3, "015", "Service Identification", ServiceIdentification::LAYOUT),
    item(4, "030", "Time of Message", TimeOfDay::LAYOUT),
    item(5, "020", "Batch Number", BatchNumber::LAYOUT),
    item(6, "040", "SDPS Configuration and Status", SystemStatus::LAYOUT),
    item(7, "050", "Service Status Report", ServiceStatus::LAYOUT),
    item(13, "RE", "Reserved Expansion Field", Layout::Explicit(Contents::Opaque)),
    item(14, "SP", "Special Purpose Field", Layout::Explicit(Contents::Opaque)),
];

/// A CAT065 record: the items in the order of [`UAP`]; an absent item is `None`.
#[derive(Clone, Debug, Default, PartialEq, DekuRead, DekuWrite)]
#[deku(ctx = "fspec: Fspec")]
pub struct Record {
    /// I065/010, the system.
    #[deku(reader = "read(deku::reader, fspec, 1)")]
    pub data_source: Option<DataSource>,
    /// I065/000, what is said.
    #[deku(reader = "read(deku::reader, fspec, 2)")]
    pub message_type: Option<MessageType>,
    /// I065/015, which service.
    #[deku(reader = "read(deku::reader, fspec, 3)")]
    pub service_identification: Option<ServiceIdentification>,
    /// I065/030, when it was said.
    #[deku(reader = "read(deku::reader, fspec, 4)")]
    pub time_of_day: Option<TimeOfDay>,
    /// I065/020, which batch of tracks has been sent.
    #[deku(reader = "read(deku::reader, fspec, 5)")]
    pub batch_number: Option<BatchNumber>,
    /// I065/040, configuration and status of the system.
    #[deku(reader = "read(deku::reader, fspec, 6)")]
    pub system_status: Option<SystemStatus>,
    /// I065/050, what happened to the service.
    #[deku(reader = "read(deku::reader, fspec, 7)")]
    pub service_status: Option<ServiceStatus>,
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
    65,
    must {
        data_source: DataSource = "010",
        message_type: MessageType = "000",
        time_of_day: TimeOfDay = "030",
    }
    may {
        service_identification: ServiceIdentification = "015",
        batch_number: BatchNumber = "020",
        system_status: SystemStatus = "040",
        service_status: ServiceStatus = "050",
        reserved_expansion: Explicit = "RE",
        special_purpose: Explicit = "SP",
    }
}

record! {
    65 {
        1 data_source,
        2 message_type,
        3 service_identification,
        4 time_of_day,
        5 batch_number,
        6 system_status,
        7 service_status,
        13 reserved_expansion,
        14 special_purpose,
    }
    uap::decode, uap::encode
}
