//! Interpolation, geodesy, the polar formula and the geoid against tables of other libraries (`testdata/oracle`).
//!
//! `cargo test --test oracles -- --nocapture` prints the largest difference of each.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::str::FromStr;

use fusion::Enu;
use fusion::frames::{Ecef, Geodetic, TangentPlane};
use fusion::interpolation::{Knot, evaluate};
use fusion::time::Time;
use nalgebra::Vector3;
use utm_fusion::areas::Masks;
use utm_fusion::config::{Config, SensorKind};
use utm_fusion::normalise::{Normaliser, RadarSite};

const PCHIP: &str = include_str!("../testdata/oracle/pchip.csv");
const GEODESY: &str = include_str!("../testdata/oracle/geodesy.csv");
const POLAR: &str = include_str!("../testdata/oracle/polar.csv");
const EGM96: &str = include_str!("../testdata/oracle/egm96.csv");
const SITE: &str = include_str!("../testdata/demo/site.toml");

/// The rows of a table, under a comment and the names of its columns.
fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    table.lines().skip(2).map(|line| line.split(',').collect())
}

/// Numbers; an empty field is `None`.
fn numbers<const N: usize>(row: &[&str]) -> [Option<f64>; N] {
    std::array::from_fn(|i| (!row[i].is_empty()).then(|| row[i].parse().unwrap()))
}

fn list<T: FromStr<Err: std::fmt::Debug>>(field: &str) -> Vec<T> {
    field.split(' ').map(|number| number.parse().unwrap()).collect()
}

/// How many queries, and the largest error, which must not pass the bound.
#[derive(Default)]
struct Largest {
    count: usize,
    error: f64,
}

impl Largest {
    fn add(&mut self, error: f64) {
        assert!(!error.is_nan());
        self.count += 1;
        self.error = self.error.max(error);
    }

    fn check(&self, what: &str, count: usize, bound: f64) {
        println!("{what}: {} queries, maximum error {:.2e} m", self.count, self.error);
        assert_eq!(self.count, count, "{what}");
        assert!(self.error <= bound, "{what}: {:e} m", self.error);
    }
}

/// A decimal number of seconds, exactly.
struct Seconds(Time);

impl FromStr for Seconds {
    type Err = std::num::ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let nanos = text.parse::<f64>()? * 1e9;
        assert!((nanos - nanos.round()).abs() < 1e-3, "{text} s is no whole number of nanoseconds");
        Ok(Self(Time::from_nanos(nanos.round() as i64)))
    }
}

#[test]
fn interpolation_is_scipys_pchip() {
    let mut largest = Largest::default();
    for row in rows(PCHIP) {
        let values = list::<f64>(row[3]);
        let knots: Vec<Knot> = list::<Seconds>(row[2])
            .iter()
            .zip(&values)
            // The three axes are independent: the second is the curve upside down, the third a flat one.
            .map(|(time, &value)| Knot { time: time.0, position: Vector3::new(value, -value, 0.0) })
            .collect();
        let scale = values.iter().fold(1000.0_f64, |scale, value| scale.max(value.abs())) / 1000.0;
        for (at, result) in list::<Seconds>(row[4]).iter().zip(list::<f64>(row[5])) {
            let point = evaluate(&knots, at.0).unwrap();
            let error = (point - Vector3::new(result, -result, 0.0)).amax();
            assert!(error <= 1e-10 * scale, "case {}, {}: {error:e} m", row[0], row[1]);
            largest.add(error);
        }
    }
    largest.check("PCHIP", 2376, 1e-9);
}

#[test]
fn geodesy_is_projs() {
    let (mut ecef, mut enu, mut back) = (Largest::default(), Largest::default(), Largest::default());
    for row in rows(GEODESY) {
        let [lat0, lon0, h0, lat, lon, h, x, y, z, e, n, u] = numbers(&row).map(Option::unwrap);
        let frame = TangentPlane::at(Geodetic::from_degrees(lat0, lon0, h0));
        let target = Geodetic::from_degrees(lat, lon, h);
        let expected = Vector3::new(x, y, z);
        ecef.add((target.to_ecef().0 - expected).norm());
        enu.add((frame.from_geodetic(target).0 - Vector3::new(e, n, u)).norm());
        // In metres: the way back to geodetic, then forward again.
        back.add((frame.to_geodetic(Enu::new(e, n, u)).to_ecef().0 - expected).norm());
        back.add((Ecef(expected).to_geodetic().height_m - h).abs());
    }
    // A double at the Earth's radius is spaced by 1e-9 m, and PROJ's own error is 1e-8 m.
    ecef.check("geodetic to ECEF", 504, 1e-8);
    enu.check("geodetic to ENU", 504, 1e-8);
    back.check("ENU to geodetic", 1008, 1e-8);
}

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
