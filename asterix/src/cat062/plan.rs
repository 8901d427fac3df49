//! Flight plan of the track: I062/390.

use crate::item::items;
use crate::{DataSource, Repeated};

items! {
    /// I062/390, flight plan related data.
    padded pub struct FlightPlan {
        /// TAG, the flight plan processing system.
        "tag" system: DataSource,
        /// CS, call sign.
        "cs" callsign: PlanCallsign,
        /// IFI, identification of the flight.
        "ifi" flight: FlightIdentification,
        /// FCT, category of the flight.
        "fct" category: FlightCategory,
        /// TAC, type of the aircraft.
        "tac" aircraft_type: AircraftType,
        /// WTC, wake turbulence category.
        "wtc" wake: WakeCategory,
        /// DEP, departure airport.
        "dep" departure: Airport,
        /// DST, destination airport.
        "dst" destination: Airport,
        /// RDS, runway.
        "rds" runway: Runway,
        /// CFL, cleared flight level.
        "cfl_flight_level" cleared_level: ClearedLevel,
        /// CTL, control position.
        "ctl" control: ControlPosition,
        /// TOD, times of departure and arrival.
        "tod" times: Repeated<FlightTime>,
        /// AST, stand.
        "ast" stand: Stand,
        /// STS, status of the stand.
        "sts" stand_status: StandStatus,
        /// STD, standard instrument departure.
        "std" departure_route: PlanCallsign,
        /// STA, standard instrument arrival.
        "sta" arrival_route: PlanCallsign,
        /// PEM, Mode 3/A code before the emergency.
        "pem" former_code: PreEmergencyCode,
        /// PEC, call sign before the emergency.
        "pec" former_callsign: PlanCallsign,
        _,
        _,
        _,
    }

    /// CS, STD, STA and PEC in I062/390.
    /// Seven ASCII characters.
    pub struct PlanCallsign(7) = ascii 56 "";

    /// IFI in I062/390: identification of the flight.
    pub struct FlightIdentification(4) {
        /// TYP: 0 plan number, 1 to 3 number of unit 1 to 3.
        count 2 "typ" number_type / with_number_type: u8;
        spare 3 "spare";
        /// NBR, 0 to 99,999,999; the bits hold 134,217,727.
        count 27 "nbr" number / with_number: u32;
    }

    /// FCT in I062/390: category of the flight.
    pub struct FlightCategory(1) {
        /// GAT/OAT: 0 unknown, 1 general, 2 operational air traffic, 3 not applicable.
        count 2 "gatoat" traffic / with_traffic: u8;
        /// FR1/FR2: 0 instrument flight rules, 1 visual, 2 not applicable, 3 controlled visual.
        count 2 "fr1fr2" rules / with_rules: u8;
        /// RVSM: 0 unknown, 1 approved, 2 exempt, 3 not approved.
        count 2 "rvsm" reduced_separation / with_reduced_separation: u8;
        /// HPR: high priority.
        flag 1 "hpr" is_priority / with_priority;
        spare 1 "spare";
    }

    /// TAC in I062/390.
    /// Four ASCII characters.
    pub struct AircraftType(4) = ascii 32 "";

    /// WTC in I062/390.
    /// One ASCII character: L, M, H or J.
    pub struct WakeCategory(1) = ascii 8 "";

    /// DEP and DST in I062/390.
    /// Four ASCII characters of ICAO's location indicators.
    pub struct Airport(4) = ascii 32 "";

    /// RDS in I062/390: runway, three ASCII characters.
    pub struct Runway(3) {
        ascii 8 "nu1";
        ascii 8 "nu2";
        ascii 8 "ltr";
    }

    /// CFL in I062/390.
    /// Flight level: LSB 1/4 (25 ft), 0 to 16,383.75.
    pub struct ClearedLevel(2) = unsigned 16 "" flight_level / with_flight_level = 0.25, 2;

    /// CTL in I062/390: control position.
    pub struct ControlPosition(2) {
        /// Centre, 0 to 255.
        count 8 "centre" centre / with_centre: u8;
        /// Control position in the centre, 0 to 255.
        count 8 "position" position / with_position: u8;
    }

    /// A part of TOD in I062/390: a time of the flight.
    pub struct FlightTime(4) {
        /// TYP, event: 0 to 13 as in the specification's table, from off-block to on-block.
        count 5 "typ" event / with_event: u8;
        /// DAY: 0 today, 1 yesterday, 2 tomorrow.
        count 2 "day" day / with_day: u8;
        spare 4 "spare";
        /// HOR, hour, 0 to 23; the bits hold 31.
        count 5 "hor" hour / with_hour: u8;
        spare 2 "spare_2";
        /// MIN, minute, 0 to 59; the bits hold 63.
        count 6 "min" minute / with_minute: u8;
        /// AVS: the second is not available.
        flag 1 "avs" lacks_second / with_second_lacking;
        spare 1 "spare_3";
        /// SEC, second, 0 to 59; the bits hold 63.
        count 6 "sec" second / with_second: u8;
    }

    /// AST in I062/390.
    /// Six ASCII characters.
    pub struct Stand(6) = ascii 48 "";

    /// STS in I062/390: status of the stand.
    pub struct StandStatus(1) {
        /// EMP: 0 empty, 1 occupied, 2 unknown.
        count 2 "emp" occupancy / with_occupancy: u8;
        /// AVL: 0 available, 1 not available, 2 unknown.
        count 2 "avl" availability / with_availability: u8;
        spare 4 "spare";
    }

    /// PEM in I062/390: Mode 3/A code before the emergency.
    pub struct PreEmergencyCode(2) {
        spare 3 "spare";
        /// VA: the code is valid.
        flag 1 "va" is_valid / with_valid;
        /// The code, 0 to octal 7777.
        octal 12 "mode_3a" code / with_code: u16;
    }
}
