//! Data from the aircraft: I062/380.

use super::ClimbRate;
use crate::Repeated;
use crate::aircraft::{
    AirSpeed, AircraftAddress, AircraftIdentification, BdsRegister, CoarsePosition, FinalAltitude,
    GeometricHeight, IntentStatus, MagneticHeading, RollAngle, SelectedAltitude, TrajectoryPoint,
};
use crate::cat048::{Communications, FlightStatus};
use crate::item::items;

/// Metres per second in a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

items! {
    /// I062/380, aircraft derived data.
    padded pub struct AircraftDerivedData {
        /// ADR, target address.
        "adr" address: AircraftAddress,
        /// ID, target identification.
        "id" identification: AircraftIdentification,
        /// MHG, magnetic heading.
        "mhg" magnetic_heading: MagneticHeading,
        /// IAS, indicated airspeed or Mach number.
        "ias" air_speed: AirSpeed,
        /// TAS, true airspeed.
        "tas_m_s" true_airspeed: TrueAirspeed,
        /// SAL, selected altitude.
        "sal" selected_altitude: SelectedAltitude,
        /// FSS, final state selected altitude.
        "fss" final_altitude: FinalAltitude,
        /// TIS, trajectory intent status.
        "tis" intent_status: IntentStatus,
        /// TID, trajectory intent.
        "tid" intent: Repeated<TrajectoryPoint>,
        /// COM, capability and flight status.
        "com" capability: Capability,
        /// SAB, status reported by ADS-B.
        "sab" adsb_status: AdsbStatus,
        /// ACS, resolution advisory.
        "acs" resolution: Resolution,
        /// BVR, barometric vertical rate.
        "bvr" barometric_rate: ClimbRate,
        /// GVR, geometric vertical rate.
        "gvr" geometric_rate: ClimbRate,
        /// RAN, roll angle.
        "ran" roll_angle: RollAngle,
        /// TAR, track angle rate.
        "tar" turn_rate: TurnRate,
        /// TAN, track angle.
        "tan_deg" track_angle: TrackAngle,
        /// GS, ground speed.
        "gs_m_s" ground_speed: GroundSpeed,
        /// VUN, velocity uncertainty.
        "vun" velocity_uncertainty: VelocityUncertainty,
        /// MET, meteorological data.
        "met" meteorology: Meteorology,
        /// EMC, emitter category.
        "emc" emitter: EmitterCategory,
        /// POS, position.
        "pos" position: CoarsePosition,
        /// GAL, geometric altitude.
        "gal" geometric_altitude: GeometricHeight,
        /// PUN, position uncertainty.
        "pun" position_uncertainty: PositionUncertainty,
        /// BDSDATA, registers of the transponder.
        "bdsdata" bds_registers: Repeated<BdsRegister>,
        /// IAR, indicated airspeed.
        "iar_m_s" indicated_airspeed: IndicatedAirspeed,
        /// MAC, Mach number.
        "mac_mach" mach: MachNumber,
        /// BPS, barometric pressure setting.
        "bps" pressure_setting: PressureSetting,
    }

    /// TAS in I062/380.
    /// Metres per second: LSB 1 kt (0.514 m/s), 0 to 2046 kt; the bits hold 65,535 kt.
    pub struct TrueAirspeed(2) = unsigned 16 "" speed_m_s / with_speed_m_s = KNOT_M_S, 1;

    /// COM in I062/380: communications and ACAS capability, flight status.
    pub struct Capability(2) {
        /// COM, communications capability of the transponder.
        code 3 "com" communications / with_communications: Communications;
        /// STAT, flight status.
        code 3 "stat" flight_status / with_flight_status: FlightStatus;
        spare 2 "spare";
        /// SSC: capable of Mode S specific services.
        flag 1 "ssc" has_specific_services / with_specific_services;
        /// ARC: altitude is reported in steps of 25 ft; not set: of 100 ft.
        flag 1 "arc" reports_25_ft / with_25_ft;
        /// AIC: the aircraft can report its identification.
        flag 1 "aic" has_identification / with_identification;
        /// B1A: bit 16 of BDS register 1,0.
        flag 1 "b1a" bds_10_bit_16 / with_bds_10_bit_16;
        /// B1B: bits 37 to 40 of BDS register 1,0.
        count 4 "b1b" bds_10_bits_37_to_40 / with_bds_10_bits_37_to_40: u8;
    }

    /// SAB in I062/380: status reported by ADS-B.
    pub struct AdsbStatus(2) {
        /// AC, collision avoidance: 0 unknown, 1 off, 2 on.
        count 2 "ac" collision_avoidance / with_collision_avoidance: u8;
        /// MN, several navigational aids: 0 unknown, 1 off, 2 on.
        count 2 "mn" navigational_aids / with_navigational_aids: u8;
        /// DC, differential correction: 0 unknown, 1 yes, 2 no.
        count 2 "dc" differential_correction / with_differential_correction: u8;
        /// GBS: the ground bit is set.
        flag 1 "gbs" is_on_ground / with_on_ground;
        spare 6 "spare";
        /// STAT, emergency: 0 none, 1 general, 2 medical, 3 minimum fuel, 4 no communications, 5 unlawful interference,
        /// 6 downed, 7 unknown.
        count 3 "stat" emergency / with_emergency: u8;
    }

    /// ACS in I062/380: BDS register 3,0.
    /// The 56 bits of the register.
    pub struct Resolution(7) = hex 56 "" data / with_data: u64;

    /// TI in TAR.
    pub enum TurnIndicator {
        /// not available.
        Unavailable = 0,
        /// left.
        Left = 1,
        /// right.
        Right = 2,
        /// straight on.
        Straight = 3,
    }

    /// TAR in I062/380: track angle rate.
    pub struct TurnRate(2) {
        /// TI, direction of the turn.
        code 2 "ti" indicator / with_indicator: TurnIndicator;
        spare 6 "spare";
        /// ROT in degrees per second, clockwise positive: LSB 0.25 degrees per second, -16 to 15.75.
        signed 7 "rot_deg_s" rate_deg_s / with_rate_deg_s = 0.25, 2;
        spare 1 "spare_2";
    }

    /// TAN in I062/380.
    /// Degrees, clockwise from true north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
    pub struct TrackAngle(2) = angle 16 "" track_deg / with_track_deg = 360.0 / 65536.0, 3;

    /// GS in I062/380.
    /// Metres per second: LSB 2^-14 NM/s (0.113 m/s), -3704 to below 3704 m/s.
    pub struct GroundSpeed(2) = signed 16 "" speed_m_s / with_speed_m_s = 1852.0 / 16_384.0, 2;

    /// VUN in I062/380.
    /// Category, 0 to 255.
    pub struct VelocityUncertainty(1) = count 8 "" category / with_category: u8;

    /// MET in I062/380.
    pub struct Meteorology(8) {
        /// WS: the wind speed is valid.
        flag 1 "ws" has_wind_speed / with_wind_speed_valid;
        /// WD: the wind direction is valid.
        flag 1 "wd" has_wind_direction / with_wind_direction_valid;
        /// TMP: the temperature is valid.
        flag 1 "tmp" has_temperature / with_temperature_valid;
        /// TRB: the turbulence is valid.
        flag 1 "trb" has_turbulence / with_turbulence_valid;
        spare 4 "spare";
        /// Wind speed in metres per second: LSB 1 kt (0.514 m/s), 0 to 300 kt; the bits hold 65,535 kt.
        unsigned 16 "wsd_m_s" wind_speed_m_s / with_wind_speed_m_s = KNOT_M_S, 1;
        /// Direction in degrees from which the wind blows: LSB 1 degree, 1 to 360 degrees; the bits hold 0 to 65,535.
        count 16 "wdd_deg" wind_direction_deg / with_wind_direction_deg: u16;
        /// Temperature in degrees Celsius: LSB 0.25 degrees, -100 to 100 degrees; the bits hold -8192 to 8191.75.
        signed 16 "tmpd_c" celsius / with_celsius = 0.25, 2;
        /// Turbulence, 0 to 15; the bits hold 0 to 255.
        count 8 "trbd" turbulence / with_turbulence: u8;
    }

    /// EMC in I062/380.
    /// Code of I021/020 with different weight limits: [`crate::cat021::EmitterCategory`].
    pub struct EmitterCategory(1) = count 8 "" code / with_code: u8;

    /// PUN in I062/380.
    pub struct PositionUncertainty(1) {
        spare 4 "spare";
        /// Category, 0 to 15.
        count 4 "pun" category / with_category: u8;
    }

    /// IAR in I062/380.
    /// Metres per second: LSB 1 kt (0.514 m/s), 0 to 1100 kt; the bits hold 65,535 kt.
    pub struct IndicatedAirspeed(2) = unsigned 16 "" speed_m_s / with_speed_m_s = KNOT_M_S, 1;

    /// MAC in I062/380.
    /// Mach number: LSB 0.008, 0 to 4.096; the bits hold 524.28.
    pub struct MachNumber(2) = unsigned 16 "" mach / with_mach = 0.008, 3;

    /// BPS in I062/380: pressure setting of the altimeter.
    pub struct PressureSetting(2) {
        spare 4 "spare";
        /// Hectopascals minus 800: LSB 0.1 hPa, 0 to 409.5 hPa.
        unsigned 12 "bps_hpa" above_800_hpa / with_above_800_hpa = 0.1, 1;
    }
}
