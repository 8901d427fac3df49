//! Compares interpolation and geodesy with SciPy and PROJ. The tables and the scripts that created them are in
//! `testdata/oracle/`.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

mod oracle;

use std::str::FromStr;

use nalgebra::Vector3;
use oracle::{Largest, numbers, rows};
use utm_fusion_engine::frames::{Ecef, Enu, Geodetic, TangentPlane};
use utm_fusion_engine::interpolation::{Knot, evaluate};
use utm_fusion_engine::time::Time;

const PCHIP: &str = include_str!("../../testdata/oracle/pchip.csv");
const GEODESY: &str = include_str!("../../testdata/oracle/geodesy.csv");

fn list<T: FromStr<Err: std::fmt::Debug>>(field: &str) -> Vec<T> {
    field.split(' ').map(|number| number.parse().unwrap()).collect()
}

/// A decimal number of seconds, read exactly.
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
            // The three axes are independent: the second is the mirrored curve, the third is constant.
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
        let frame = TangentPlane::at_site(Geodetic::from_degrees(lat0, lon0, h0));
        let target = Geodetic::from_degrees(lat, lon, h);
        let expected = Vector3::new(x, y, z);
        ecef.add((target.to_ecef().0 - expected).norm());
        enu.add((frame.from_geodetic(target).0 - Vector3::new(e, n, u)).norm());
        // In metres: to geodetic coordinates, and back again.
        back.add((frame.to_geodetic(Enu::new(e, n, u)).to_ecef().0 - expected).norm());
        back.add((Ecef(expected).to_geodetic().height_m - h).abs());
    }
    // An `f64` at the Earth's radius has a resolution of 1e-9 m, and PROJ's own error is 1e-8 m.
    ecef.check("geodetic to ECEF", 504, 1e-8);
    enu.check("geodetic to ENU", 504, 1e-8);
    back.check("ENU to geodetic", 1008, 1e-8);
}
