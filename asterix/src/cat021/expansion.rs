//! The reserved expansion field of category 021, edition 1.5 (EUROCONTROL-SPEC-0149-12, appendix A). Edition 1.4 is the same
//! with fewer bits defined.

mod mode_5;
mod status;

use crate::item::items;
use crate::record::expansion_field;

pub use crate::aircraft::{FigureOfMerit, XPulses};
pub use mode_5::{ExtendedMode1, MilitarySquitter, Mode2, Mode5Summary, NationalOrigin};
pub use status::AircraftStatus;

items! {
    /// The reserved expansion field; an absent part is `None`.
    expansion pub struct ReservedExpansion {
        /// BPS, barometric pressure setting.
        "bps" pressure_setting: PressureSetting,
        /// SH, selected heading.
        "sh" selected_heading: SelectedHeading,
        /// NAV, navigation mode.
        "nav" navigation_mode: NavigationMode,
        /// GAO, offset of the GPS antenna.
        "gao" antenna_offset: AntennaOffset,
        /// SGV, ground vector of a target on the surface.
        "sgv" surface_vector: SurfaceVector,
        /// STA, aircraft status.
        "sta" status: AircraftStatus,
        /// TNH, true north heading.
        "tnh" true_heading: TrueHeading,
        /// MES, military extended squitter.
        "mes" military: MilitarySquitter,
    }

    /// BPS in RE: pressure setting of the altimeter.
    pub struct PressureSetting(2) {
        spare 4 "spare";
        /// Hectopascals minus 800: LSB 0.1 hPa, 0 to 409.5 hPa.
        unsigned 12 "bps_hpa" above_800_hpa / with_above_800_hpa = 0.1, 1;
    }

    /// SH in RE: the heading that the crew selected.
    pub struct SelectedHeading(2) {
        spare 4 "spare";
        /// HDR: from magnetic north; not set: from true north.
        flag 1 "hdr" is_magnetic / with_magnetic;
        /// STAT: the heading is valid.
        flag 1 "stat" is_valid / with_valid;
        /// Degrees, clockwise: LSB 45/64 degrees (about 0.7), 0 to 719.3 degrees.
        unsigned 10 "sh_deg" heading_deg / with_heading_deg = 45.0 / 64.0, 2;
    }

    /// NAV in RE: navigation mode.
    pub struct NavigationMode(1) {
        /// AP: the autopilot is engaged.
        flag 1 "ap" is_autopilot / with_autopilot;
        /// VN: vertical navigation is active.
        flag 1 "vn" is_vertical / with_vertical;
        /// AH: altitude hold is engaged.
        flag 1 "ah" is_altitude_held / with_altitude_held;
        /// AM: approach mode is active.
        flag 1 "am" is_approach / with_approach;
        count 1 "mfm_ep";
        /// MFM: the mode bits of the control unit are populated; from edition 1.5 on.
        populated_flag 1 "mfm" are_mode_bits_populated;
        spare 2 "spare";
    }

    /// GAO in RE: position of the GPS antenna on the aircraft.
    /// Code of ED-102A: 3 bits for the lateral, 5 for the longitudinal offset.
    pub struct AntennaOffset(1) = count 8 "" code / with_code: u8;

    /// SGV in RE: ground vector of a target on the surface.
    parts pub struct SurfaceVector {
        first {
            /// STP: it has stopped.
            flag 1 "stp" is_stopped / with_stopped;
            /// HTS: heading or ground track is valid.
            flag 1 "hts" is_direction_valid / with_direction_valid;
            /// HTT: the ground track; not set: the heading.
            flag 1 "htt" is_ground_track / with_ground_track;
            /// HRD: from magnetic north; not set: from true north.
            flag 1 "hrd" is_magnetic / with_magnetic;
            /// GSS, ground speed in metres per second: LSB 1/8 kt (0.064 m/s), 0 to 131.6 m/s.
            unsigned 11 "gss_m_s" speed_m_s / with_speed_m_s = 1852.0 / 3600.0 / 8.0, 2;
        }
        extension {
            /// HGT, heading or ground track in degrees, clockwise: LSB 45/16 degrees (2.8125), 0 to below 360 degrees.
            unsigned 7 "hgt_deg" direction_deg / with_direction_deg = 45.0 / 16.0, 1;
        }
    }

    /// TNH in RE: heading.
    pub struct TrueHeading(2) {
        /// Degrees, clockwise from true north: LSB 360/65536 degrees (about 0.0055), 0 to below 360 degrees.
        angle 16 "heading_deg" heading_deg / with_heading_deg = 360.0 / 65536.0, 3;
    }
}

expansion_field! { ReservedExpansion }
