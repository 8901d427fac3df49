//! `[site]`.

use super::kinds::{Kind, any_text, number, whole};
use super::table::{absent, need, section};

/// A system area code.
pub(super) fn area_code() -> Kind<u8> {
    whole("a SAC is a whole number from 0 to 255", 0..=255)
}

/// A system identification code.
pub(super) fn identification_code() -> Kind<u8> {
    whole("a SIC is a whole number from 0 to 255", 0..=255)
}

section! {
    /// The service itself.
    Site {
        /// Name of the service, shown on its interfaces.
        name: String = need("name = …, how the interfaces call this service"), any_text();
        /// System area code of what the service sends (I129/010). No sensor may have both this SAC and this SIC.
        sac: u8 = need("sac = …, the system area code (SAC) of what the service sends"), area_code();
        /// System identification code of what the service sends (I129/010).
        sic: u8 = need("sic = …, the system identification code (SIC) of what the service sends"), identification_code();
        /// Height of the geoid above the WGS-84 ellipsoid, metres.
        geoid_undulation_m: Option<f64> = absent("EGM96 at the first radar"), number(
            "a geoid undulation is between -120 and 100 metres; leave the key out for EGM96",
            |v| (-120.0..=100.0).contains(&v),
        );
    }
}
