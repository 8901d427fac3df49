//! Identity and kind of the target, and data source: I021/008, 015, 016, 020, 070, 132, 161, 200, 210, 400.

use core::fmt;

use crate::item::items;

items! {
    /// TC in I021/008: trajectory change reports that the aircraft can send.
    pub enum TrajectoryCapability {
        /// none.
        None = 0,
        /// TC+0 only.
        Single = 1,
        /// several.
        Multiple = 2,
    }

    /// I021/008, aircraft operational status.
    pub struct OperationalStatus(1) {
        /// RA: a resolution advisory is active.
        flag 1 "ra" has_advisory / with_advisory;
        /// TC, trajectory change reports that the aircraft can send.
        code 2 "tc" trajectory_capability / with_trajectory_capability: TrajectoryCapability;
        /// TS: can send target state reports.
        flag 1 "ts" has_target_state / with_target_state;
        /// ARV: can send air-referenced velocity.
        flag 1 "arv" has_air_velocity / with_air_velocity;
        /// CDTI/A: the airborne cockpit display of traffic information is operational.
        flag 1 "cdtia" has_traffic_display / with_traffic_display;
        /// NOT TCAS: the collision avoidance system is not operational.
        flag 1 "nottcas" is_tcas_off / with_tcas_off;
        /// SA: single antenna.
        flag 1 "sa" has_single_antenna / with_single_antenna;
    }

    /// I021/015, service identification, assigned by the ground station.
    /// The number, 0 to 255.
    pub struct ServiceIdentification(1) = count 8 "" number / with_number: u8;

    /// I021/016, service management.
    pub struct ServiceManagement(1) {
        /// Period of the reports in seconds: LSB 0.5 s, 0 to 127.5 s; 0 if each message is reported.
        unsigned 8 "period_s" period_s / with_period_s = 0.5, 1;
    }

    /// I021/020: kind of the target.
    pub enum EmitterCategory {
        /// no information.
        Unknown = 0,
        /// light aircraft, up to 15,500 lb.
        Light = 1,
        /// small aircraft, up to 75,000 lb.
        Small = 2,
        /// medium aircraft, up to 300,000 lb.
        Medium = 3,
        /// large aircraft with strong vortex.
        HighVortex = 4,
        /// heavy aircraft, from 300,000 lb on.
        Heavy = 5,
        /// highly manoeuvrable and fast.
        HighPerformance = 6,
        /// helicopter.
        Rotorcraft = 10,
        /// glider.
        Glider = 11,
        /// lighter than air.
        LighterThanAir = 12,
        /// unmanned aircraft.
        Unmanned = 13,
        /// spacecraft.
        Space = 14,
        /// ultralight, hang glider or paraglider.
        Ultralight = 15,
        /// parachutist.
        Parachutist = 16,
        /// emergency vehicle on the ground.
        EmergencyVehicle = 20,
        /// service vehicle on the ground.
        ServiceVehicle = 21,
        /// fixed or tethered obstruction.
        Obstruction = 22,
        /// cluster of obstacles.
        ObstacleCluster = 23,
        /// line of obstacles.
        ObstacleLine = 24,
    }

    /// I021/020, emitter category.
    /// Kind of the target.
    pub struct Emitter(1) = code 8 "" category / with_category: EmitterCategory;

    /// I021/070, Mode 3/A code.
    pub struct Mode3A(2) {
        spare 4 "spare";
        /// The code, 0 to octal 7777: four octal digits, as `Display` writes them.
        octal 12 "mode_3a" code / with_code: u16;
    }
}

impl fmt::Display for Mode3A {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04o}", self.code())
    }
}

items! {
    /// I021/132, message amplitude: strength of the weakest message used for the record.
    pub struct MessageAmplitude(1) {
        /// dBm: LSB 1 dBm, -128 to 127 dBm.
        signed 8 "amplitude_dbm" dbm / with_dbm = 1.0, 0;
    }

    /// I021/161, track number assigned by the ground station.
    pub struct TrackNumber(2) {
        spare 4 "spare";
        /// The number, 0 to 4095.
        count 12 "track_number" number / with_number: u16;
    }

    /// PS in I021/200: priority status.
    pub enum PriorityStatus {
        /// no emergency, or nothing reported.
        None = 0,
        /// general emergency.
        General = 1,
        /// medical emergency.
        Medical = 2,
        /// minimum fuel.
        MinimumFuel = 3,
        /// no communications.
        NoCommunications = 4,
        /// unlawful interference.
        UnlawfulInterference = 5,
        /// downed.
        Downed = 6,
    }

    /// SS in I021/200: surveillance status.
    all pub enum SurveillanceStatus {
        /// 0: nothing.
        None,
        /// 1: permanent alert, an emergency.
        PermanentAlert,
        /// 2: temporary alert, code change.
        TemporaryAlert,
        /// 3: special position identification.
        SpecialPosition,
    }

    /// I021/200, target status.
    pub struct TargetStatus(1) {
        /// ICF: the intent changed.
        flag 1 "icf" is_intent_changed / with_intent_changed;
        /// LNAV: lateral navigation is not engaged.
        flag 1 "lnav" is_lateral_off / with_lateral_off;
        /// ME: military emergency; from edition 2.2 on.
        flag 1 "me" is_military_emergency / with_military_emergency;
        /// PS, priority status.
        code 3 "ps" priority / with_priority: PriorityStatus;
        /// SS, surveillance status.
        code 2 "ss" surveillance / with_surveillance: SurveillanceStatus;
    }

    /// VN in I021/210: standard of the aircraft's equipment.
    pub enum Standard {
        /// ED-102, DO-260.
        Do260 = 0,
        /// DO-260A.
        Do260A = 1,
        /// ED-102A, DO-260B.
        Do260B = 2,
        /// ED-102B, DO-260C; from edition 2.5 on.
        Do260C = 3,
    }

    /// LTT in I021/210: link technology.
    pub enum LinkTechnology {
        /// another way.
        Unspecified = 0,
        /// universal access transceiver, 978 MHz.
        Uat = 1,
        /// extended squitter on 1090 MHz.
        ExtendedSquitter = 2,
        /// VDL mode 4.
        Vdl4 = 3,
    }

    /// I021/210, MOPS version.
    pub struct MopsVersion(1) {
        spare 1 "spare";
        /// VNS: the ground station does not know the version.
        flag 1 "vns" is_unsupported / with_unsupported;
        /// VN, standard of the aircraft's equipment.
        code 3 "vn" standard / with_standard: Standard;
        /// LTT, link technology.
        code 3 "ltt" technology / with_technology: LinkTechnology;
    }

    /// I021/400, receiver of the message within a distributed ground station.
    /// The number, 0 to 255.
    pub struct ReceiverId(1) = count 8 "" number / with_number: u8;
}
