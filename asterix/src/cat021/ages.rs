//! Ages of the data in the report: I021/295.

use crate::item::items;

items! {
    /// A part of I021/295.
    /// Seconds: LSB 0.1 s, 0 to 25.4 s; 25.5 s means 25.5 s or more.
    pub struct Age(1) = unsigned 8 "" seconds / with_seconds = 0.1, 1;

    /// I021/295, data ages: age of each item when the record was sent.
    padded pub struct DataAges {
        /// AOS, of I021/008.
        "aos_s" operational_status: Age,
        /// TRD, of I021/040.
        "trd_s" target_report: Age,
        /// M3A, of I021/070.
        "m3a_s" mode_3a: Age,
        /// QI, of I021/090.
        "qi_s" quality: Age,
        /// TI1, of I021/110.
        "ti1_s" trajectory_intent: Age,
        /// MAM, of I021/132.
        "mam_s" message_amplitude: Age,
        /// GH, of I021/140.
        "gh_s" geometric_height: Age,
        /// FL, of I021/145.
        "fl_s" flight_level: Age,
        /// SAL, of I021/146; ISA before edition 2.6.
        "sal_s" selected_altitude: Age,
        /// FSA, of I021/148.
        "fsa_s" final_altitude: Age,
        /// AS, of I021/150.
        "as_s" air_speed: Age,
        /// TAS, of I021/151.
        "tas_s" true_airspeed: Age,
        /// MH, of I021/152.
        "mh_s" magnetic_heading: Age,
        /// BVR, of I021/155.
        "bvr_s" barometric_rate: Age,
        /// GVR, of I021/157.
        "gvr_s" geometric_rate: Age,
        /// GV, of I021/160.
        "gv_s" ground_vector: Age,
        /// TAR, of I021/165.
        "tar_s" track_angle_rate: Age,
        /// TI2, of I021/170.
        "ti2_s" target_identification: Age,
        /// TS, of I021/200.
        "ts_s" target_status: Age,
        /// MET, of I021/220.
        "met_s" met_information: Age,
        /// ROA, of I021/230.
        "roa_s" roll_angle: Age,
        /// ARA, of I021/260.
        "ara_s" resolution_advisory: Age,
        /// SCC, of I021/271.
        "scc_s" surface: Age,
        _,
        _,
        _,
        _,
        _,
    }
}
