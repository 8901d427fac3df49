//! Zone files that are read, and zone files that are refused.

mod entries;
mod files;
mod national;
mod schedules;

use super::*;
use fusion::frames::Geodetic;

/// An area of kind `alert` with these keys.
fn alert(change: impl FnOnce(&mut AlertArea)) -> Area {
    let mut settings = AlertArea::default();
    change(&mut settings);
    Area { kind: AreaKind::Alert(settings), file: PathBuf::from("secret/field.geojson") }
}

/// The areas of a file with that text, configured as `area`.
fn areas(text: &str, area: &Area) -> Areas {
    Areas::parse(text, area.clone()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The error message for a file with that text.
fn refusal(text: &str, area: &Area) -> String {
    match contents(text, area) {
        Ok(contents) => panic!("understood: {contents:?}"),
        Err(problem) => problem,
    }
}

fn at(text: &str) -> Time {
    let nanos = text.parse::<jiff::Timestamp>().unwrap().as_nanosecond();
    Time::from_nanos(nanos as i64)
}

fn visitor(longitude_deg: f64, latitude_deg: f64, altitude_amsl_m: Option<f64>) -> Visitor<'static> {
    let place = Geodetic {
        latitude: latitude_deg.to_radians(),
        longitude: longitude_deg.to_radians(),
        height_m: altitude_amsl_m.unwrap_or(0.0),
    };
    Visitor { place, altitude_amsl_m, serial: None, at: at("2026-11-23T12:00:00Z") }
}
