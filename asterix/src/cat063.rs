//! Category 063, sensor status reports, edition 1.7 (EUROCONTROL-SPEC-0149-10).

mod bias;
mod status;

use crate::record::record;
use crate::{DataSource, Explicit, TimeOfDay};

pub use crate::cat062::ServiceIdentification;
pub use bias::{AzimuthBias, ElevationBias, RangeBias, TimeBias};
pub use status::{Connection, SensorStatus};

record! {
    /// A CAT063 record: the items in the order of [`UAP`]; an absent item is `None`. FRN 12 is not defined.
    pub struct Record(63) {
        must 1 "010" "Data Source Identifier" data_source: DataSource;
        may 2 "015" "Service Identification" service_identification: ServiceIdentification;
        must 3 "030" "Time of Message" time_of_day: TimeOfDay;
        /// The sensor that the record describes.
        must 4 "050" "Sensor Identifier" sensor: DataSource;
        may 5 "060" "Sensor Configuration and Status" status: SensorStatus;
        may 6 "070" "Time Stamping Bias" time_bias: TimeBias;
        may 7 "080" "SSR/Mode S Range Gain and Bias" ssr_range_bias: RangeBias;
        may 8 "081" "SSR/Mode S Azimuth Bias" ssr_azimuth_bias: AzimuthBias;
        may 9 "090" "PSR Range Gain and Bias" psr_range_bias: RangeBias;
        may 10 "091" "PSR Azimuth Bias" psr_azimuth_bias: AzimuthBias;
        may 11 "092" "PSR Elevation Bias" psr_elevation_bias: ElevationBias;
        may 13 "RE" "Reserved Expansion Field" reserved_expansion: Explicit;
        may 14 "SP" "Special Purpose Field" special_purpose: Explicit;
    }
}
