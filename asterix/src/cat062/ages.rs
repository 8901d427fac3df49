//! Ages of the track and its data: I062/290, 295.

use crate::item::items;

items! {
    /// A part of I062/290 and 295.
    /// Seconds: LSB 0.25 s, 0 to 63.75 s; the maximum means this or more.
    pub struct Age(1) = unsigned 8 "" seconds / with_seconds = 0.25, 2;

    /// ADS in I062/290.
    /// Seconds: LSB 0.25 s, 0 to 16,383.75 s; the maximum means this or more.
    pub struct LongAge(2) = unsigned 16 "" seconds / with_seconds = 0.25, 2;
}

/// Constructor of both ages, limited to the maximum of the item.
macro_rules! of_seconds {
    ($($name:ident $most_s:literal)*) => {$(
        impl $name {
            /// The nearest age, limited to the maximum; `None` for negative numbers and NaN.
            pub fn from_seconds(seconds: f64) -> Option<Self> {
                // `min` returns its other argument for NaN.
                if seconds.is_nan() { None } else { Self::default().with_seconds(seconds.min($most_s)) }
            }
        }
    )*};
}

of_seconds! { Age 63.75 LongAge 16_383.75 }

items! {
    /// I062/290, update ages: time since each kind of sensor last updated the track.
    padded pub struct UpdateAges {
        /// TRK, of the track itself.
        "trk_s" track: Age,
        /// PSR, primary.
        "psr_s" psr: Age,
        /// SSR, secondary.
        "ssr_s" ssr: Age,
        /// MDS, Mode S.
        "mds_s" mode_s: Age,
        /// ADS, ADS-C.
        "ads_s" ads_c: LongAge,
        /// ES, ADS-B, extended squitter.
        "es_s" squitter: Age,
        /// VDL, ADS-B, VDL mode 4.
        "vdl_s" vdl_4: Age,
        /// UAT, ADS-B, UAT.
        "uat_s" uat: Age,
        /// LOP, loop.
        "lop_s" magnetic_loop: Age,
        /// MLT, multilateration.
        "mlt_s" multilateration: Age,
        _,
        _,
        _,
        _,
    }

    /// I062/295, data ages: age of each part of the track.
    padded pub struct TrackDataAges {
        /// MFL, measured flight level.
        "mfl_s" flight_level: Age,
        /// MD1, Mode 1.
        "md1_s" mode_1: Age,
        /// MD2, Mode 2.
        "md2_s" mode_2: Age,
        /// MDA, Mode 3/A.
        "mda_s" mode_3a: Age,
        /// MD4, Mode 4.
        "md4_s" mode_4: Age,
        /// MD5, Mode 5.
        "md5_s" mode_5: Age,
        /// MHG, magnetic heading.
        "mhg_s" magnetic_heading: Age,
        /// IAS, indicated airspeed or Mach number.
        "ias_s" air_speed: Age,
        /// TAS, true airspeed.
        "tas_s" true_airspeed: Age,
        /// SAL, selected altitude.
        "sal_s" selected_altitude: Age,
        /// FSS, final state selected altitude.
        "fss_s" final_altitude: Age,
        /// TID, trajectory intent.
        "tid_s" intent: Age,
        /// COM, capability and flight status.
        "com_s" capability: Age,
        /// SAB, status reported by ADS-B.
        "sab_s" adsb_status: Age,
        /// ACS, resolution advisory.
        "acs_s" resolution: Age,
        /// BVR, barometric vertical rate.
        "bvr_s" barometric_rate: Age,
        /// GVR, geometric vertical rate.
        "gvr_s" geometric_rate: Age,
        /// RAN, roll angle.
        "ran_s" roll_angle: Age,
        /// TAR, track angle rate.
        "tar_s" turn_rate: Age,
        /// TAN, track angle.
        "tan_s" track_angle: Age,
        /// GSP, ground speed.
        "gsp_s" ground_speed: Age,
        /// VUN, velocity uncertainty.
        "vun_s" velocity_uncertainty: Age,
        /// MET, meteorological data.
        "met_s" meteorology: Age,
        /// EMC, emitter category.
        "emc_s" emitter: Age,
        /// POS, position.
        "pos_s" position: Age,
        /// GAL, geometric altitude.
        "gal_s" geometric_altitude: Age,
        /// PUN, position uncertainty.
        "pun_s" position_uncertainty: Age,
        /// MB, registers of the transponder.
        "mb_s" bds_registers: Age,
        /// IAR, indicated airspeed.
        "iar_s" indicated_airspeed: Age,
        /// MAC, Mach number.
        "mac_s" mach: Age,
        /// BPS, barometric pressure setting.
        "bps_s" pressure_setting: Age,
        _,
        _,
        _,
        _,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_beyond_the_last_count_are_the_last() {
        assert_eq!(Age::from_seconds(1.1).map(Age::seconds), Some(1.0));
        assert_eq!(Age::from_seconds(1e9).map(Age::octets), Some([0xff]));
        assert_eq!(LongAge::from_seconds(1e9).map(LongAge::octets), Some([0xff; 2]));
        assert_eq!((Age::from_seconds(-1.0), Age::from_seconds(f64::NAN)), (None, None));
    }
}
