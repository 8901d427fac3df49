//! Measurement of the plot: I048/120, 130.

use crate::Repeated;
use crate::item::items;

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;

items! {
    /// I048/130 (5.2.16), radar plot characteristics.
    compound pub struct PlotCharacteristics {
        /// SRL, run length of the SSR plot.
        "srl_deg" ssr_run_length: RunLength,
        /// SRR, number of replies received.
        "srr" ssr_replies: Replies,
        /// SAM, amplitude of the SSR or Mode S reply.
        "sam_dbm" ssr_amplitude: Amplitude,
        /// PRL, run length of the primary plot.
        "prl_deg" psr_run_length: RunLength,
        /// PAM, amplitude of the primary plot.
        "pam_dbm" psr_amplitude: Amplitude,
        /// RPD, range of the PSR plot minus that of the SSR plot.
        "rpd_m" range_difference: RangeDifference,
        /// APD, azimuth of the PSR plot minus that of the SSR plot.
        "apd_deg" azimuth_difference: AzimuthDifference,
    }

    /// SRL, PRL in I048/130: azimuth over which the antenna detected the target.
    /// Degrees of azimuth: LSB 360/8192 degrees (about 0.044), 0 to 11.21 degrees.
    pub struct RunLength(1) = unsigned 8 "" degrees / with_degrees = 360.0 / 8192.0, 2;

    /// SRR in I048/130: number of replies used for the plot.
    /// Replies, 0 to 255.
    pub struct Replies(1) = count 8 "" number / with_number: u8;

    /// SAM, PAM in I048/130: amplitude of the reply or echo.
    /// dBm: LSB 1 dBm, -128 to 127 dBm.
    pub struct Amplitude(1) = signed 8 "" dbm / with_dbm = 1.0, 0;

    /// RPD in I048/130: difference in range between the PSR and the SSR plot.
    /// Metres: LSB 1/256 NM (7.234375 m), -926 to 918.8 m.
    pub struct RangeDifference(1) = signed 8 "" metres / with_metres = NAUTICAL_MILE_M / 256.0, 1;

    /// APD in I048/130: difference in azimuth between the PSR and the SSR plot.
    /// Degrees: LSB 360/16384 degrees (about 0.022), -2.8125 to 2.7905 degrees.
    pub struct AzimuthDifference(1) = signed 8 "" degrees / with_degrees = 360.0 / 16384.0, 3;

    /// I048/120 (5.2.15), radial Doppler speed. The specification allows only one of the subfields; both are decoded.
    compound pub struct RadialDoppler {
        /// CAL, calculated.
        "cal" calculated: CalculatedDoppler,
        /// RDS, raw, one part per measurement.
        "rds" raw: Repeated<RawDoppler>,
        _,
        _,
        _,
        _,
        _,
    }

    /// CAL in I048/120: calculated Doppler speed.
    pub struct CalculatedDoppler(2) {
        /// D: the speed is doubtful.
        flag 1 "d" is_doubtful / with_doubtful;
        spare 5 "spare";
        /// Radial speed in metres per second: LSB 1 m/s, -512 to 511 m/s.
        signed 10 "speed_m_s" speed_m_s / with_speed_m_s = 1.0, 0;
    }

    /// A part of RDS in I048/120: raw Doppler speed.
    pub struct RawDoppler(6) {
        /// DOP, Doppler speed in metres per second: LSB 1 m/s, 0 to 65535 m/s. The specification states neither sign nor
        /// direction.
        count 16 "doppler_m_s" doppler_m_s / with_doppler_m_s: u16;
        /// AMB, ambiguity range in metres per second: LSB 1 m/s, 0 to 65535 m/s.
        count 16 "ambiguity_m_s" ambiguity_m_s / with_ambiguity_m_s: u16;
        /// FRQ, transmitter frequency in megahertz: LSB 1 MHz, 0 to 65535 MHz.
        count 16 "frequency_mhz" frequency_mhz / with_frequency_mhz: u16;
    }
}
