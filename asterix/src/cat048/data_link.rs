//! Mode S data of the aircraft: I048/230, 260. Registers are in [`aircraft`](crate::aircraft).

use crate::item::items;

items! {
    /// COM in I048/230: communications capability of the transponder.
    pub enum Communications {
        /// none, surveillance only.
        Surveillance = 0,
        /// Comm. A and Comm. B.
        CommAB = 1,
        /// Comm. A, Comm. B and uplink ELM.
        UplinkElm = 2,
        /// Comm. A, Comm. B, uplink and downlink ELM.
        UplinkAndDownlinkElm = 3,
        /// a transponder of level 5.
        Level5 = 4,
    }

    /// STAT in I048/230: flight status.
    pub enum FlightStatus {
        /// no alert, no SPI, airborne.
        Airborne = 0,
        /// no alert, no SPI, on the ground.
        OnGround = 1,
        /// alert, no SPI, airborne.
        AlertAirborne = 2,
        /// alert, no SPI, on the ground.
        AlertOnGround = 3,
        /// alert, SPI, airborne or on the ground.
        AlertSpecialPosition = 4,
        /// no alert, SPI, airborne or on the ground.
        SpecialPosition = 5,
        /// unknown.
        Unknown = 7,
    }

    /// I048/230 (5.2.23), communications and ACAS capability, flight status.
    pub struct Capability(2) {
        /// COM, communications capability of the transponder.
        code 3 "com" communications / with_communications: Communications;
        /// STAT, flight status.
        code 3 "stat" flight_status / with_flight_status: FlightStatus;
        /// SI: the transponder is capable of II codes only; not set: of SI codes.
        flag 1 "si" is_interrogator_identifier_only / with_interrogator_identifier_only;
        spare 1 "spare";
        /// MSSC: capable of Mode S specific services.
        flag 1 "mssc" has_specific_services / with_specific_services;
        /// ARC: altitude is reported in steps of 25 ft; not set: of 100 ft.
        flag 1 "arc" reports_25_ft / with_25_ft;
        /// AIC: the aircraft can report its identification.
        flag 1 "aic" has_identification / with_identification;
        /// B1A: bit 16 of BDS register 1,0.
        flag 1 "b1a" bds_10_bit_16 / with_bds_10_bit_16;
        /// B1B: bits 37 to 40 of BDS register 1,0.
        count 4 "b1b" bds_10_bits_37_to_40 / with_bds_10_bits_37_to_40: u8;
    }

    /// I048/260 (5.2.26), the ACAS resolution advisory: BDS register 3,0.
    /// The 56 bits of the register (ICAO Annex 10, volume IV, section 4.3.8.4.2.2).
    pub struct AcasAdvisory(7) = hex 56 "" data / with_data: u64;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capability() {
        let capability = Capability::from_octets([0x20, 0xfd]);
        assert_eq!(capability.communications(), Communications::CommAB);
        assert_eq!(capability.flight_status(), FlightStatus::Airborne);
        assert!(capability.has_specific_services() && capability.reports_25_ft());
        assert!(capability.has_identification() && capability.bds_10_bit_16());
        assert!(!capability.is_interrogator_identifier_only());
        assert_eq!(capability.bds_10_bits_37_to_40(), 13);
        let other = capability.with_flight_status(FlightStatus::Other(6));
        assert_eq!((other.octets(), other.flight_status()), ([0x38, 0xfd], FlightStatus::Other(6)));
        assert_eq!(capability.with_bds_10_bits_37_to_40(16), None);
    }

    #[test]
    fn registers() {
        use crate::aircraft::BdsRegister;
        let register = BdsRegister::from_octets([0xc8, 0x4e, 0x28, 0x30, 0xa8, 0, 0, 0x40]);
        assert_eq!((register.data(), register.bds1(), register.bds2()), (0xc8_4e28_30a8_0000, 4, 0));
        assert_eq!(BdsRegister::default().with_data(1 << 56), None);
        assert_eq!(AcasAdvisory::from_octets([0x30, 0, 0, 0, 0, 0, 1]).data(), 0x30_0000_0000_0001);
    }
}
