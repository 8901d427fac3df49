//! RTC in RE: radar track characteristics.

use crate::Repeated;
use crate::item::items;

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;

items! {
    /// RTC in RE: radar track characteristics.
    compound pub struct TrackCharacteristics {
        /// PTL, the plot linked to the track.
        "ptl" plot_link: PlotLink,
        /// ATL, the ADS-B reports linked to the track.
        "atl" adsb_links: Repeated<AdsbLink>,
        /// TRN, turn state.
        "trn_percent" turn_state: TurnState,
        /// NPP, next predicted position.
        "npp" prediction: Prediction,
        /// DLK, data link characteristics.
        "dlk" data_links: Repeated<DataLink>,
        /// LCK, lockout characteristics.
        "lck" lockout: Lockout,
        /// TC, transition codes.
        "tc" transition_code: TransitionCode,
        /// TLC, life cycle of the track.
        "tlc" life: TrackLife,
        /// ASI, information of adjacent sensors.
        "asi" adjacent_sensors: Repeated<AdjacentSensor>,
        /// TES, source of the extrapolation.
        "tes" extrapolation_source: ExtrapolationSource,
        /// IR, identity requested.
        "ir" identity_request: IdentityRequest,
        _,
        _,
        _,
    }

    /// PTL in RTC: the plot linked to the track.
    pub struct PlotLink(3) {
        spare 3 "spare";
        /// SCN: the track is associated with a plot of the surveillance cluster network.
        flag 1 "scn" has_network_plot / with_network_plot;
        /// RC: the plot has a roll-call part.
        flag 1 "rc" has_roll_call / with_roll_call;
        /// AC: the plot has an all-call part.
        flag 1 "ac" has_all_call / with_all_call;
        /// SSR: the plot has an SSR part.
        flag 1 "ssr" has_ssr / with_ssr;
        /// PSR: the plot has a PSR part.
        flag 1 "psr" has_psr / with_psr;
        /// Plot number, 0 to 65535.
        count 16 "plot_number" plot_number / with_plot_number: u16;
    }

    /// A part of ATL in RTC: an ADS-B report linked to the track.
    /// Number of the report, 0 to 65535.
    pub struct AdsbLink(2) = count 16 "" number / with_number: u16;

    /// TRN in RTC: turn state.
    /// Probability of a turn in percent: LSB 1 %, 0 to 100 %; the bits hold 0 to 255.
    pub struct TurnState(1) = count 8 "" percent / with_percent: u8;

    /// NPP in RTC: predicted position of the target, and the window in which the target is searched.
    pub struct Prediction(22) {
        /// Predicted slant range in metres: LSB 1/128 NM (14.46875 m), 0 to below 512 NM.
        unsigned 16 "rho_m" rho_m / with_rho_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Predicted azimuth in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "theta_deg" theta_deg / with_theta_deg = 360.0 / 65536.0, 3;
        /// Smallest slant range by evolution in metres: LSB 1/128 NM (14.46875 m).
        unsigned 16 "evolution_rho_start_m" evolution_rho_start_m / with_evolution_rho_start_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Largest slant range by evolution in metres: LSB 1/128 NM (14.46875 m).
        unsigned 16 "evolution_rho_end_m" evolution_rho_end_m / with_evolution_rho_end_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Smallest azimuth by evolution in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "evolution_theta_start_deg" evolution_theta_start_deg / with_evolution_theta_start_deg = 360.0 / 65536.0, 3;
        /// Largest azimuth by evolution in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "evolution_theta_end_deg" evolution_theta_end_deg / with_evolution_theta_end_deg = 360.0 / 65536.0, 3;
        /// Smallest slant range by noise in metres: LSB 1/128 NM (14.46875 m).
        unsigned 16 "noise_rho_start_m" noise_rho_start_m / with_noise_rho_start_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Largest slant range by noise in metres: LSB 1/128 NM (14.46875 m).
        unsigned 16 "noise_rho_end_m" noise_rho_end_m / with_noise_rho_end_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Smallest azimuth by noise in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "noise_theta_start_deg" noise_theta_start_deg / with_noise_theta_start_deg = 360.0 / 65536.0, 3;
        /// Largest azimuth by noise in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "noise_theta_end_deg" noise_theta_end_deg / with_noise_theta_end_deg = 360.0 / 65536.0, 3;
        /// Predicted time of detection in seconds: LSB 1/128 s, 0 to below 512 s.
        unsigned 16 "time_s" time_s / with_time_s = 1.0 / 128.0, 7;
    }

    /// ORIGIN in DLK.
    pub enum DataLinkOrigin {
        /// from a previous scan.
        PreviousScan = 0,
        /// new in this scan.
        CurrentScan = 1,
        /// requested in the beam by the transponder.
        Transponder = 2,
    }

    /// STATE in DLK.
    pub enum DataLinkState {
        /// in progress.
        InProgress = 0,
        /// completed.
        Completed = 1,
        /// cancelled.
        Cancelled = 2,
    }

    /// A part of DLK in RTC: a data link transaction.
    pub struct DataLink(1) {
        /// TYPE: 0 surveillance Mode A, 1 Comm-A, 2 ground-initiated Comm-B, 3 air-initiated Comm-B, 4 broadcast Comm-B,
        /// 5 Comm-C, 6 Comm-D; to 15 reserved.
        count 4 "type" transaction / with_transaction: u8;
        /// ORIGIN, origin of the transaction.
        code 2 "origin" origin / with_origin: DataLinkOrigin;
        /// STATE, progress of the transaction.
        code 2 "state" state / with_state: DataLinkState;
    }

    /// LCK in RTC: lockout.
    pub struct Lockout(2) {
        /// LS: this radar locks the target out.
        flag 1 "ls" is_locked_out / with_locked_out;
        /// LOCTIM, lockout time in milliseconds: LSB 1 ms, 0 to 32767 ms.
        count 15 "time_ms" time_ms / with_time_ms: u16;
    }

    /// TC in RTC: changes of the Mode 1, 2 and 3/A codes.
    pub struct TransitionCode(6) {
        spare 7 "spare";
        /// TCOUNT1, scans since the last change of the Mode 1 code, 0 to 15.
        count 4 "count_1" count_1 / with_count_1: u8;
        /// TCODE1, previous Mode 1 code, as [`Mode1::code_bits`](crate::cat048::Mode1::code_bits).
        count 5 "code_1" code_1 / with_code_1: u8;
        /// TCOUNT2, scans since the last change of the Mode 2 code, 0 to 15.
        count 4 "count_2" count_2 / with_count_2: u8;
        /// TCODE2, previous Mode 2 code, 0 to octal 7777.
        octal 12 "code_2" code_2 / with_code_2: u16;
        /// TCOUNT3, scans since the last change of the Mode 3/A code, 0 to 15.
        count 4 "count_3" count_3 / with_count_3: u8;
        /// TCODE3, previous Mode 3/A code, 0 to octal 7777.
        octal 12 "code_3" code_3 / with_code_3: u16;
    }

    /// ACQI in TLC: state of acquisition.
    pub enum TrackAcquisition {
        /// tentative with one plot.
        OnePlot = 0,
        /// tentative with two plots or more.
        TwoPlots = 1,
        /// pre-confirmed.
        PreConfirmed = 2,
        /// confirmed.
        Confirmed = 3,
    }

    /// TLC in RTC: life cycle of the track.
    pub struct TrackLife(4) {
        /// ACQI, state of acquisition.
        code 2 "acqi" acquisition / with_acquisition: TrackAcquisition;
        /// TRKUPDCTR, updates of the track, 0 to 16383.
        count 14 "updates" updates / with_updates: u16;
        /// LASTTRKUPD, milliseconds since the last update: LSB 1 ms, 0 to 65535 ms.
        count 16 "last_update_ms" last_update_ms / with_last_update_ms: u16;
    }

    /// A part of ASI in RTC: information from an adjacent sensor.
    pub struct AdjacentSensor(7) {
        /// SAC of the sensor.
        count 8 "sac" sac / with_sac: u8;
        /// SIC of the sensor.
        count 8 "sic" sic / with_sic: u8;
        /// Time stamp of the network in seconds, UTC: LSB 1/128 s, 0 to below 512 s, the lowest 16 bits of the time of day.
        unsigned 16 "time_s" time_s / with_time_s = 1.0 / 128.0, 7;
        /// DATAUSE: 0 used by the tracker, 1 not used; to 127 reserved.
        count 7 "data_use" data_use / with_data_use: u8;
        /// DRNA: the DRN is available.
        flag 1 "drna" has_drn / with_drn_available;
        /// DRN, 0 to 65535.
        count 16 "drn" drn / with_drn: u16;
    }

    /// TES in RTC: source of the extrapolation.
    /// 0 the radar's tracker, 1 integrated ADS-B, 2 external ADS-B, 3 the surveillance cluster network.
    pub struct ExtrapolationSource(1) = count 8 "" source / with_source: u8;

    /// IR in RTC: request of the identity.
    pub struct IdentityRequest(1) {
        /// IR: the identity is requested.
        flag 1 "ir" is_requested / with_requested;
        /// M3A, age of the Mode 3/A code in seconds: LSB 1 s, 0 to 127 s.
        count 7 "mode_3a_age_s" mode_3a_age_s / with_mode_3a_age_s: u8;
    }
}
