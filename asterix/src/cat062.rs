//! Category 062, system track data, edition 1.21 (EUROCONTROL-SPEC-0149-9). All editions from 1.16 on have the same layout;
//! items and bits that older ones do not define are spare in them.

mod accuracy;
mod ages;
mod composed;
mod derived;
pub mod expansion;
mod measured;
mod mode_5;
mod motion;
mod plan;
mod status;
mod track;

use crate::cat129::FusionReport;
use crate::record::record;
use crate::{DataSource, Explicit, TimeOfDay};

pub use crate::aircraft::{
    AirSpeed, AircraftAddress, AircraftIdentification, AltitudeSource, BarometricLevel, BdsRegister,
    CoarsePosition, FinalAltitude, GeometricHeight, IntentStatus, MagneticHeading, PointType, RollAngle,
    SelectedAltitude, TrajectoryPoint, TurnDirection,
};
pub use accuracy::{
    AccelerationAccuracy, ClimbAccuracy, Covariance, EstimatedAccuracies, HeightAccuracy, LevelAccuracy,
    PositionAccuracy, VelocityAccuracy, Wgs84Accuracy,
};
pub use ages::{Age, LongAge, TrackDataAges, UpdateAges};
pub use composed::{ComposedTrackNumber, UnitTrack};
pub use derived::{
    AdsbStatus, AircraftDerivedData, Capability, EmitterCategory, GroundSpeed, IndicatedAirspeed, MachNumber,
    Meteorology, PositionUncertainty, PressureSetting, Resolution, TrackAngle, TrueAirspeed, TurnIndicator,
    TurnRate, VelocityUncertainty,
};
pub use expansion::ReservedExpansion;
pub use measured::{
    MeasuredHeight, MeasuredInformation, MeasuredMode3A, MeasuredModeC, MeasuredPosition, ReportType,
};
pub use mode_5::{ExtendedMode1, Mode5, Mode5Altitude, Mode5Summary, NationalOrigin, TimeOffset, XPulses};
pub use motion::{
    Acceleration, ClimbRate, LongitudinalMode, ModeOfMovement, TransversalMode, Velocity, VerticalMode,
};
pub use plan::{
    AircraftType, Airport, ClearedLevel, ControlPosition, FlightCategory, FlightIdentification, FlightPlan,
    FlightTime, PlanCallsign, PreEmergencyCode, Runway, Stand, StandStatus, WakeCategory,
};
pub use status::{HeightSource, TrackStatus};
pub use track::{
    BarometricAltitude, CartesianPosition, Fleet, FleetIdentification, IdentificationSource, Mode2, Mode3A,
    Position, ServiceIdentification, TargetIdentification, TargetSize, TrackNumber,
};

record! {
    /// A CAT062 record: the items in the order of [`UAP`]; an absent item is `None`. FRN 2 and 29 to 33 are not defined.
    pub struct Record(62) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        may 3 "015" "Service Identification" service_identification: ServiceIdentification;
        /// Time to which the track data apply.
        must 4 "070" "Time of Track Information" time_of_day: TimeOfDay;
        may 5 "105" "Calculated Position in WGS-84 Co-ordinates" position: Position;
        may 6 "100" "Calculated Track Position (Cartesian)" cartesian_position: CartesianPosition;
        may 7 "185" "Calculated Track Velocity (Cartesian)" velocity: Velocity;
        may 8 "210" "Calculated Acceleration (Cartesian)" acceleration: Acceleration;
        may 9 "060" "Track Mode 3/A Code" mode_3a: Mode3A;
        may 10 "245" "Target Identification" target_identification: TargetIdentification;
        may 11 "380" "Aircraft Derived Data" aircraft_derived: AircraftDerivedData;
        must 12 "040" "Track Number" track_number: TrackNumber;
        must 13 "080" "Track Status" track_status: TrackStatus;
        may 14 "290" "System Track Update Ages" update_ages: UpdateAges;
        may 15 "200" "Mode of Movement" mode_of_movement: ModeOfMovement;
        may 16 "295" "Track Data Ages" data_ages: TrackDataAges;
        may 17 "136" "Measured Flight Level" flight_level: BarometricLevel;
        may 18 "130" "Calculated Track Geometric Altitude" geometric_altitude: GeometricHeight;
        may 19 "135" "Calculated Track Barometric Altitude" barometric_altitude: BarometricAltitude;
        may 20 "220" "Calculated Rate of Climb/Descent" climb_rate: ClimbRate;
        may 21 "390" "Flight Plan Related Data" flight_plan: FlightPlan;
        may 22 "270" "Target Size and Orientation" target_size: TargetSize;
        may 23 "300" "Vehicle Fleet Identification" fleet: FleetIdentification;
        may 24 "110" "Mode 5 Data Reports and Extended Mode 1 Code" mode_5: Mode5;
        may 25 "120" "Track Mode 2 Code" mode_2: Mode2;
        may 26 "510" "Composed Track Number" composed_track: ComposedTrackNumber;
        may 27 "500" "Estimated Accuracies" accuracies: EstimatedAccuracies;
        may 28 "340" "Measured Information" measured: MeasuredInformation;
        /// Decoded as [`ReservedExpansion`], edition 1.3 of the appendix.
        may 34 "RE" "Reserved Expansion Field" reserved_expansion: Explicit as ReservedExpansion;
        /// One of its layouts is [`FusionReport`].
        may 35 "SP" "Special Purpose Field" special_purpose: Explicit as FusionReport;
    }
}
