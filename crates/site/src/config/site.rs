//! `[site]`.

use super::sensors::{height_amsl, latitude, longitude};
use tables::error::Faults;
use tables::kinds::{Kind, any_text, number, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{absent, need};

/// Kind of a system area code.
pub(super) fn area_code() -> Kind<u8> {
    whole("a SAC is a whole number from 0 to 255", 0..=255)
}

/// Kind of a system identification code.
pub(super) fn identification_code() -> Kind<u8> {
    whole("a SIC is a whole number from 0 to 255", 0..=255)
}

section! {
    /// Identity and location of the service.
    Site {
        /// Name of the service, shown on its interfaces.
        name: String = need("name = …, how the interfaces call this service"), any_text();
        /// System area code of the service in its outputs (I129/010). No sensor may have both this SAC and this SIC.
        sac: u8 = need("sac = …, the system area code (SAC) of what the service sends"), area_code();
        /// System identification code of the service in its outputs (I129/010).
        sic: u8 = need("sic = …, the system identification code (SIC) of what the service sends"), identification_code();
        /// Height of the geoid above the WGS-84 ellipsoid at the site, in metres.
        geoid_undulation_m: Option<f64> = absent("EGM96 at the origin of the local frame"), number(
            "a geoid undulation is between -120 and 100 metres; leave the key out for EGM96",
            |v| (-120.0..=100.0).contains(&v),
        );
        /// WGS-84 latitude of the origin of the local frame, in degrees, north positive. Only for a site without a radar.
        latitude_deg: Option<f64> = absent("that of the first radar"), latitude();
        /// WGS-84 longitude of the origin, in degrees, east positive. Only for a site without a radar.
        longitude_deg: Option<f64> = absent("that of the first radar"), longitude();
        /// Height of the origin above mean sea level, in metres, also assumed for reports without a height. Only for a site
        /// without a radar.
        height_amsl_m: Option<f64> = absent("that of the first radar"), height_amsl();
    }
}

/// Keys of the origin: all are needed if there is no radar, and none may be set if there is one.
const ORIGIN: [&str; 3] = ["latitude_deg", "longitude_deg", "height_amsl_m"];

/// Reports an origin that is missing without a radar, or present beside one.
pub(super) fn check_origin(top: &Section<'_>, has_radar: bool, faults: &Faults) {
    let Some(site) = top.written("site").and_then(|item| item.section()) else { return };
    let written = ORIGIN.map(|key| site.written(key));
    if has_radar {
        written.into_iter().flatten().for_each(|item| {
            item.refuse(
                "the first radar is the origin of the local frame; remove it: a site says where it is only without a radar",
            );
        });
    } else if written.iter().any(Option::is_none) && faults.none_of("site") {
        site.refuse(
            "without a radar the site says where its local frame begins; add latitude_deg, longitude_deg and height_amsl_m, \
             or a sensor with kind = \"radar\"",
        );
    }
}
