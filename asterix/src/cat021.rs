//! Category 021, ADS-B target reports, editions 2.1 to 2.7 (EUROCONTROL-SPEC-0149-12). A record does not state the edition of
//! its sender: see [`Edition`].

mod ages;
mod descriptor;
mod edition;
pub mod expansion;
mod general;
mod intent;
mod met;
mod motion;
mod quality;
mod resolution;
mod surface;
mod time;

use deku::DekuReader;

use crate::record::{explain, read, read_fspec, record};
use crate::{DataSource, Explicit, Fault, Repeated, TimeOfDay};

pub use crate::aircraft::{
    AirSpeed, AircraftAddress, AircraftIdentification, AltitudeSource, BarometricLevel, BdsRegister,
    CoarsePosition, FinalAltitude, GeometricHeight, IntentStatus, MagneticHeading, PointType, Position,
    RollAngle, SelectedAltitude, TrajectoryPoint, TurnDirection,
};
pub use ages::{Age, DataAges};
pub use descriptor::{AddressType, AltitudeReporting, Confidence, TargetReport};
pub use edition::{Edition, UnknownEdition};
pub use expansion::ReservedExpansion;
pub use general::{
    Emitter, EmitterCategory, LinkTechnology, MessageAmplitude, Mode3A, MopsVersion, OperationalStatus,
    PriorityStatus, ReceiverId, ServiceIdentification, ServiceManagement, Standard, SurveillanceStatus,
    TargetStatus, TrackNumber, TrajectoryCapability,
};
pub use intent::TrajectoryIntent;
pub use met::{MetInformation, Temperature, Turbulence, WindDirection, WindSpeed};
pub use motion::{GroundVector, TrackAngleRate, TrueAirspeed, VerticalRate};
pub use quality::{QualityIndicators, ValidationState};
pub use resolution::ResolutionAdvisory;
pub use surface::{Surface, SurfaceCharacteristics, SurfaceCharacteristics21};
pub use time::{PreciseTime, SecondIndication};

record! {
    /// A CAT021 record: the items in the order of [`UAP`], that of edition 2.7; an absent item is `None`. FRN 43 to 47 are not
    /// defined.
    pub struct Record(21) in (Edition) with (edition: Edition) decode {
        must 1 "010" "Data Source Identification" data_source: DataSource;
        /// Origin of the report, and confidence in it.
        must 2 "040" "Target Report Descriptor" target_report: TargetReport;
        may 3 "161" "Track Number" track_number: TrackNumber;
        may 4 "015" "Service Identification" service_identification: ServiceIdentification;
        /// Time to which the position applies.
        may 5 "071" "Time of Applicability for Position" position_time: TimeOfDay;
        may 6 "130" "Position in WGS-84 Co-ordinates" position: CoarsePosition;
        may 7 "131" "High-Resolution Position in WGS-84 Co-ordinates" fine_position: Position;
        /// Time to which the velocity applies.
        may 8 "072" "Time of Applicability for Velocity" velocity_time: TimeOfDay;
        may 9 "150" "Air Speed" air_speed: AirSpeed;
        may 10 "151" "True Airspeed" true_airspeed: TrueAirspeed;
        /// Target address; [`TargetReport::address_type`] states its kind.
        must 11 "080" "Target Address" target_address: AircraftAddress;
        /// Time at which the ground station received the position.
        may 12 "073" "Time of Message Reception for Position" position_reception: TimeOfDay;
        may 13 "074" "Time of Message Reception of Position, High Precision" precise_position_reception: PreciseTime;
        /// Time at which the ground station received the velocity.
        may 14 "075" "Time of Message Reception for Velocity" velocity_reception: TimeOfDay;
        may 15 "076" "Time of Message Reception of Velocity, High Precision" precise_velocity_reception: PreciseTime;
        may 16 "140" "Geometric Height" geometric_height: GeometricHeight;
        /// Quality of the position.
        may 17 "090" "Quality Indicators" quality: QualityIndicators;
        may 18 "210" "MOPS Version" mops_version: MopsVersion;
        may 19 "070" "Mode 3/A Code" mode_3a: Mode3A;
        may 20 "230" "Roll Angle" roll_angle: RollAngle;
        may 21 "145" "Flight Level" flight_level: BarometricLevel;
        may 22 "152" "Magnetic Heading" magnetic_heading: MagneticHeading;
        may 23 "200" "Target Status" target_status: TargetStatus;
        may 24 "155" "Barometric Vertical Rate" barometric_rate: VerticalRate;
        may 25 "157" "Geometric Vertical Rate" geometric_rate: VerticalRate;
        may 26 "160" "Airborne Ground Vector" ground_vector: GroundVector;
        may 27 "165" "Track Angle Rate" track_angle_rate: TrackAngleRate;
        /// Time at which the record was sent.
        may 28 "077" "Time of Report Transmission" transmission_time: TimeOfDay;
        may 29 "170" "Target Identification" target_identification: AircraftIdentification;
        /// Kind of the target.
        may 30 "020" "Emitter Category" emitter: Emitter;
        may 31 "220" "Met Information" met_information: MetInformation;
        may 32 "146" "Selected Altitude" selected_altitude: SelectedAltitude;
        may 33 "148" "Final State Selected Altitude" final_altitude: FinalAltitude;
        may 34 "110" "Trajectory Intent" trajectory_intent: TrajectoryIntent;
        may 35 "016" "Service Management" service_management: ServiceManagement;
        may 36 "008" "Aircraft Operational Status" operational_status: OperationalStatus;
        /// In the form of the edition in which it was read or created.
        may 37 "271" "Surface Capabilities and Characteristics" surface: Surface as SurfaceCharacteristics
            = |reader| Surface::from_reader_with_ctx(reader, (edition,));
        may 38 "132" "Message Amplitude" message_amplitude: MessageAmplitude;
        may 39 "250" "Mode S MB Data" bds_registers: Repeated<BdsRegister>;
        may 40 "260" "ACAS Resolution Advisory Report" resolution_advisory: ResolutionAdvisory;
        may 41 "400" "Receiver ID" receiver: ReceiverId;
        may 42 "295" "Data Ages" data_ages: DataAges;
        /// Decoded as [`ReservedExpansion`], edition 1.5 of the appendix.
        may 48 "RE" "Reserved Expansion Field" reserved_expansion: Explicit as ReservedExpansion;
        may 49 "SP" "Special Purpose Field" special_purpose: Explicit;
    }
    time Record::first_time;
}

impl Record {
    /// The first time present of: position, velocity, transmission. For position and velocity the time of applicability precedes
    /// the time of reception.
    fn first_time(&self) -> Option<TimeOfDay> {
        self.position_time
            .or(self.position_reception)
            .or(self.velocity_time)
            .or(self.velocity_reception)
            .or(self.transmission_time)
    }
}

/// Decodes a record in the edition of its sender.
fn decode(record: &mut Record, octets: &[u8], edition: Edition) -> Result<usize, Fault> {
    let fspec = read_fspec::<Record>(octets, edition)?;
    read(record, octets, fspec, (fspec, edition)).map_err(|_| explain::<Record>(octets, edition))
}
