//! The polar formula and the geoid compared with tables of other libraries (`testdata/oracle`). Interpolation and geodesy are in
//! `fusion/tests/oracles.rs`.
//!
//! `cargo test --test oracles -- --nocapture` prints the maximum differences.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

#[path = "../fusion/tests/oracle/mod.rs"]
mod oracle;

use fusion::frames::Geodetic;
use nalgebra::Vector3;
use oracle::{Largest, numbers, rows};
use utm_fusion::areas::Masks;
use utm_fusion::config::{Config, SensorKind};
use utm_fusion::normalise::{Normaliser, RadarSite};

const POLAR: &str = include_str!("../testdata/oracle/polar.csv");
const EGM96: &str = include_str!("../testdata/oracle/egm96.csv");
const SITE: &str = include_str!("../testdata/demo/site.toml");

#[test]
fn polar_is_the_formula_and_near_the_ellipsoid() {
    let mut formula = Largest::default();
    let (mut to_5_km, mut to_20_km) = (Largest::default(), Largest::default());
    for row in rows(POLAR) {
        let [lat0, lon0, h0, rho, theta, h, e, n, u, exact_e, exact_n, exact_u] = numbers(&row);
        let radar = Geodetic::from_degrees(lat0.unwrap(), lon0.unwrap(), h0.unwrap());
        let rho = rho.unwrap();
        let site = RadarSite::new(radar, 0.0);
        let position = site.position(rho, theta.unwrap().to_radians(), h.unwrap()).0;
        formula.add((position - Vector3::new(e.unwrap(), n.unwrap(), u.unwrap())).norm());
        if let (Some(e), Some(n), Some(u)) = (exact_e, exact_n, exact_u) {
            let difference = (position - Vector3::new(e, n, u)).norm();
            if rho <= 5000.0 {
                to_5_km.add(difference);
            } else if rho <= 20_010.0 {
                to_20_km.add(difference);
            }
        }
    }
    formula.check("polar to ENU", 256, 1e-8);
    to_5_km.check("polar to ENU against the ellipsoid, to 5 km", 126, 0.007);
    to_20_km.check("polar to ENU against the ellipsoid, 5 to 20 km", 84, 0.104);
}

/// The table is rounded to centimetres.
#[test]
fn the_default_undulation_is_egm96() {
    let mut largest = Largest::default();
    let mut config = Config::parse(SITE, "site.toml", std::iter::empty()).unwrap();
    config.site.geoid_undulation_m = None;
    for row in rows(EGM96) {
        let [latitude, longitude, undulation] = numbers(&row).map(Option::unwrap);
        let SensorKind::Radar(radar) = &mut config.sensors[0].kind else { unreachable!() };
        (radar.latitude_deg, radar.longitude_deg) = (latitude, longitude);
        largest.add((Normaliser::new(&config, Masks::default()).undulation_m() - undulation).abs());
    }
    largest.check("EGM96", 15, 0.006);
}
