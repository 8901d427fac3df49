//! Category 015, target reports of independent non-cooperative surveillance (INCS) systems, edition 1.2
//! (EUROCONTROL-SPEC-0149-15B): radars, cameras and direction finders, some of which measure angles only.

mod angles;
mod position;
mod range;
mod report;
mod rise;
mod shape;
mod velocity;

use crate::record::record;
use crate::{DataSource, Explicit, Repeated, TimeOfDay};

pub use crate::cat048::Warnings;
pub use crate::cat065::ServiceIdentification;
pub use angles::{
    Angle, AngleDeviation, AngleRate, AngleRateDeviation, AzimuthExtent, AzimuthInformation, ElevationExtent,
    ElevationInformation, SignedAngle,
};
pub use position::{
    ConfidenceInterval, Height, HeightDeviation, HeightInformation, PairCorrelation, PositionInformation,
    PositionPrecision, PositionResolution, Wgs84Position,
};
pub use range::{
    Correlation, DopplerAcceleration, DopplerAccelerationPrecision, DopplerDeviation, DopplerInformation,
    DopplerVelocity, PathQuality, Power, Range, RangeAcceleration, RangeAccelerationPrecision,
    RangeDeviation, RangeInformation, RangeRate, RangeRatePrecision, RangeRateResolution, ReflectedPower,
};
pub use report::{
    Association, MeasurementIdentifier, MessageKind, MessageType, NumberOfSites, ReportNumber, ReportStatus,
    ScanDirection, TargetReport, TargetTaxonomy, UpdatePeriod,
};
pub use rise::{
    VerticalAcceleration, VerticalAccelerationInformation, VerticalAccelerationPrecision, VerticalVelocity,
    VerticalVelocityInformation, VerticalVelocityPrecision, VerticalVelocityResolution,
};
pub use shape::{Classification, ContourPoint, Orientation, Size, SizeAndOrientation};
pub use velocity::{
    Acceleration, AccelerationInformation, AccelerationPrecision, CrossCorrelation, Velocity,
    VelocityInformation, VelocityPrecision, VelocityResolution,
};

record! {
    /// A CAT015 record: the items in the order of [`UAP`]; an absent item is `None`.
    pub struct Record(15) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        must 2 "000" "Message Type" message_type: MessageType;
        may 3 "015" "Service Identification" service_identification: ServiceIdentification;
        may 4 "020" "Target Report Descriptor" target_report: TargetReport;
        may 5 "030" "Warning/Error Conditions" warnings: Warnings;
        /// Time to which the values of the record apply.
        must 6 "145" "Time of Applicability" time_of_day: TimeOfDay;
        may 7 "161" "Track/Plot Number" number: ReportNumber;
        may 8 "170" "Track/Plot Status" status: ReportStatus;
        may 9 "050" "Update Period" update_period: UpdatePeriod;
        may 10 "270" "Target Size and Orientation" size: SizeAndOrientation;
        may 11 "300" "Object Classification" classifications: Repeated<Classification>;
        may 12 "400" "Measurement Identifier" measurement: MeasurementIdentifier;
        may 13 "600" "Horizontal Position Information" position: PositionInformation;
        may 14 "601" "Geometric Height Information" height: HeightInformation;
        may 15 "602" "Horizontal Velocity Information" velocity: VelocityInformation;
        may 16 "603" "Horizontal Acceleration Information" acceleration: AccelerationInformation;
        may 17 "604" "Vertical Velocity Information" vertical_velocity: VerticalVelocityInformation;
        may 18 "605" "Vertical Acceleration Information" vertical_acceleration: VerticalAccelerationInformation;
        may 19 "480" "Associations" associations: Repeated<Association>;
        may 20 "625" "Range Information" range: RangeInformation;
        may 21 "626" "Doppler Information" doppler: DopplerInformation;
        may 22 "627" "Azimuth Information" azimuth: AzimuthInformation;
        may 23 "628" "Elevation Information" elevation: ElevationInformation;
        may 24 "630" "Path Quality" path_quality: PathQuality;
        may 25 "631" "Contour" contour: Repeated<ContourPoint>;
        may 26 "SP" "Special Purpose Field" special_purpose: Explicit;
    }
}
