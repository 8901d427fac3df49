//! Category 065, service status reports of a surveillance data processing system, edition 1.6
//! (EUROCONTROL-SPEC-0149-15).

use crate::item::items;
use crate::record::record;
use crate::{DataSource, Explicit, TimeOfDay};

items! {
    /// The kinds of reports in I065/000.
    pub enum MessageKind {
        /// status of the system, with I065/040.
        SystemStatus = 1,
        /// end of a batch of tracks, with I065/020.
        EndOfBatch = 2,
        /// service status, with I065/050.
        ServiceStatus = 3,
    }

    /// I065/000 (5.2.1), message type.
    /// Kind of the report.
    pub struct MessageType(1) = code 8 "" kind / with_kind: MessageKind;

    /// I065/015 (5.2.3), service identification, assigned by the system.
    /// The number, 0 to 255.
    pub struct ServiceIdentification(1) = count 8 "" number / with_number: u8;

    /// I065/020 (5.2.4), batch number: the part of a cycle of track reports that has been sent.
    /// The number, 0 to the number of batches in a cycle minus 1.
    pub struct BatchNumber(1) = count 8 "" number / with_number: u8;

    /// NOGO in I065/040: operational status.
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

    /// PSS in I065/040: selected processing system.
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

    /// I065/040 (5.2.6), configuration and status of the system.
    pub struct SystemStatus(1) {
        /// NOGO, operational status.
        code 2 "nogo" operational_status / with_operational_status: OperationalStatus;
        /// OVL: overloaded.
        flag 1 "ovl" is_overloaded / with_overloaded;
        /// TSV: the time source is invalid.
        flag 1 "tsv" is_time_invalid / with_time_invalid;
        /// PSS, selected processing system.
        code 2 "pss" processing_system / with_processing_system: ProcessingSystem;
        /// STTN: toggled whenever the system starts to assign track numbers again.
        flag 1 "sttn" renumbering / with_renumbering;
        spare 1 "spare";
    }

    /// Event of the service in I065/050.
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

    /// I065/050 (5.2.7), service status report.
    /// Event of the service.
    pub struct ServiceStatus(1) = code 8 "" event / with_event: ServiceEvent;
}

record! {
    /// A CAT065 record: the items in the order of [`UAP`]; an absent item is `None`. FRN 8 to 12 are not defined.
    pub struct Record(65) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        must 2 "000" "Message Type" message_type: MessageType;
        may 3 "015" "Service Identification" service_identification: ServiceIdentification;
        must 4 "030" "Time of Message" time_of_day: TimeOfDay;
        /// The batch of tracks that has been sent.
        may 5 "020" "Batch Number" batch_number: BatchNumber;
        may 6 "040" "SDPS Configuration and Status" system_status: SystemStatus;
        /// Event of the service.
        may 7 "050" "Service Status Report" service_status: ServiceStatus;
        may 13 "RE" "Reserved Expansion Field" reserved_expansion: Explicit;
        may 14 "SP" "Special Purpose Field" special_purpose: Explicit;
    }
}
