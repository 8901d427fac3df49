//! Contents of a service message: I034/000, 020, 041, 070, 090, 100, 110, 120.

use crate::item::items;

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;

items! {
    /// The kinds of service messages in I034/000.
    pub enum MessageKind {
        /// north marker: the antenna passes north.
        NorthMarker = 1,
        /// sector crossing.
        SectorCrossing = 2,
        /// geographical filtering.
        GeographicalFiltering = 3,
        /// jamming strobe.
        JammingStrobe = 4,
        /// solar storm.
        SolarStorm = 5,
        /// SSR jamming strobe.
        SsrJammingStrobe = 6,
        /// Mode S jamming strobe.
        ModeSJammingStrobe = 7,
    }

    /// I034/000 (5.2.1), message type.
    /// Kind of the message.
    pub struct MessageType(1) = code 8 "" kind / with_kind: MessageKind;

    /// I034/020 (5.2.3), sector number: azimuth at the start of the sector that the antenna enters.
    /// Azimuth in degrees from north, clockwise: LSB 360/256 degrees (about 1.41), 0 to below 360 degrees.
    pub struct SectorNumber(1) = unsigned 8 "azimuth_deg" azimuth_deg / with_azimuth_deg = 360.0 / 256.0, 6;

    /// I034/041 (5.2.5), antenna rotation speed, as the time of one turn.
    /// Seconds per turn: LSB 1/128 s, 0 to below 512 s.
    pub struct RotationPeriod(2) = unsigned 16 "period_s" period_s / with_period_s = 1.0 / 128.0, 7;

    /// TYP in I034/070: subject of the count.
    pub enum CounterKind {
        /// misses: no detection.
        NoDetection = 0,
        /// PSR reports.
        Psr = 1,
        /// SSR reports, not Mode S.
        Ssr = 2,
        /// SSR and PSR reports, not Mode S.
        SsrAndPsr = 3,
        /// Mode S all-call reports.
        AllCall = 4,
        /// Mode S roll-call reports.
        RollCall = 5,
        /// Mode S all-call and PSR reports.
        AllCallAndPsr = 6,
        /// Mode S roll-call and PSR reports.
        RollCallAndPsr = 7,
        /// filter for weather data.
        WeatherFilter = 8,
        /// filter for jamming strobes.
        JammingStrobeFilter = 9,
        /// filter for PSR data.
        PsrFilter = 10,
        /// filter for SSR and Mode S data.
        SsrFilter = 11,
        /// filter for SSR or Mode S and PSR data.
        SsrAndPsrFilter = 12,
        /// filter for enhanced surveillance data.
        EnhancedFilter = 13,
        /// filter for PSR and enhanced surveillance.
        PsrAndEnhancedFilter = 14,
        /// filter for PSR, enhanced surveillance, and SSR or Mode S data outside the area of prime interest.
        PsrEnhancedAndOutsideSsrFilter = 15,
        /// filter for PSR, enhanced surveillance and all SSR or Mode S data.
        PsrEnhancedAndAllSsrFilter = 16,
        /// re-interrogations in a sector.
        Reinterrogations = 17,
        /// BDS swaps and wrong DF replies in a sector.
        BdsSwaps = 18,
        /// Mode A/C FRUIT in a sector.
        ModeACFruit = 19,
        /// Mode S FRUIT in a sector.
        ModeSFruit = 20,
    }

    /// A part of I034/070 (5.2.8), message count values.
    pub struct MessageCount(2) {
        /// TYP, subject of the count.
        code 5 "typ" kind / with_kind: CounterKind;
        /// The count, 0 to 2047.
        count 11 "count" count / with_count: u16;
    }

    /// I034/090 (5.2.9), collimation error: mean difference between PSR and SSR plots.
    pub struct CollimationError(2) {
        /// Range error in metres: LSB 1/128 NM (14.46875 m), -1852 to 1837.5 m.
        signed 8 "range_m" range_m / with_range_m = NAUTICAL_MILE_M / 128.0, 1;
        /// Azimuth error in degrees: LSB 360/16384 degrees (about 0.022), -2.8125 to 2.7905 degrees.
        signed 8 "azimuth_deg" azimuth_deg / with_azimuth_deg = 360.0 / 16384.0, 3;
    }

    /// I034/100 (5.2.10), generic polar window.
    pub struct PolarWindow(8) {
        /// Rho start, slant range in metres: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
        unsigned 16 "rho_start_m" rho_start_m / with_rho_start_m = NAUTICAL_MILE_M / 256.0, 1;
        /// Rho end, slant range in metres: LSB 1/256 NM (7.234375 m), 0 to below 256 NM.
        unsigned 16 "rho_end_m" rho_end_m / with_rho_end_m = NAUTICAL_MILE_M / 256.0, 1;
        /// Theta start, azimuth in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "theta_start_deg" theta_start_deg / with_theta_start_deg = 360.0 / 65536.0, 3;
        /// Theta end, azimuth in degrees: LSB 360/65536 degrees (about 0.0055).
        unsigned 16 "theta_end_deg" theta_end_deg / with_theta_end_deg = 360.0 / 65536.0, 3;
    }

    /// Data filtered in I034/110.
    pub enum Filter {
        /// invalid.
        Invalid = 0,
        /// weather data.
        Weather = 1,
        /// jamming strobes.
        JammingStrobe = 2,
        /// PSR data.
        Psr = 3,
        /// SSR and Mode S data.
        Ssr = 4,
        /// SSR or Mode S and PSR data.
        SsrAndPsr = 5,
        /// enhanced surveillance data.
        Enhanced = 6,
        /// PSR and enhanced surveillance data.
        PsrAndEnhanced = 7,
        /// PSR, enhanced surveillance, and SSR or Mode S data outside the area of prime interest.
        PsrEnhancedAndOutsideSsr = 8,
        /// PSR, enhanced surveillance and all SSR or Mode S data.
        PsrEnhancedAndAllSsr = 9,
    }

    /// I034/110 (5.2.11), data filter.
    /// The filtered data.
    pub struct DataFilter(1) = code 8 "" filter / with_filter: Filter;

    /// I034/120 (5.2.12), position of the data source in WGS-84.
    pub struct SourcePosition(8) {
        /// Height in metres above mean sea level: LSB 1 m, -32768 to 32767 m.
        signed 16 "height_m" height_m / with_height_m = 1.0, 0;
        /// Latitude in degrees, north positive: LSB 180/2^23 degrees (2.4 m), -90 to 90 degrees; the bits hold -180 to below
        /// 180.
        signed 24 "latitude_deg" latitude_deg / with_latitude_deg = 180.0 / 8_388_608.0, 5;
        /// Longitude in degrees, east positive: LSB 180/2^23 degrees (2.4 m), -180 to below 180 degrees.
        signed 24 "longitude_deg" longitude_deg / with_longitude_deg = 180.0 / 8_388_608.0, 5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_marker_and_sector() {
        assert_eq!(MessageType::from_octets([1]).kind(), MessageKind::NorthMarker);
        assert_eq!(MessageType::default().with_kind(MessageKind::SectorCrossing).octets(), [2]);
        assert_eq!(MessageType::from_octets([9]).kind(), MessageKind::Other(9));
        assert_eq!(SectorNumber::from_octets([0x40]).azimuth_deg(), 90.0);
        assert_eq!(SectorNumber::default().with_azimuth_deg(360.0), None);
        assert_eq!(RotationPeriod::from_octets([0x02, 0x00]).period_s(), 4.0);
    }

    #[test]
    fn numbers_of_odd_widths_and_signs() {
        let count = MessageCount::from_octets([0x2f, 0xff]);
        assert_eq!((count.kind(), count.count()), (CounterKind::RollCall, 2047));
        let error = CollimationError::from_octets([0xff, 0x80]);
        assert_eq!((error.range_m(), error.azimuth_deg()), (-14.468_75, -2.8125));
        let position = SourcePosition::default()
            .with_height_m(-3.0)
            .and_then(|position| position.with_latitude_deg(-45.0))
            .and_then(|position| position.with_longitude_deg(90.0))
            .unwrap();
        assert_eq!(position.octets(), [0xff, 0xfd, 0xe0, 0, 0, 0x40, 0, 0]);
        assert_eq!(
            (position.height_m(), position.latitude_deg(), position.longitude_deg()),
            (-3.0, -45.0, 90.0)
        );
        assert_eq!(position.with_longitude_deg(180.0), None);
    }
}
