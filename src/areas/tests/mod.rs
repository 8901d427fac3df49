//! What files say, and what is refused.

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

/// The areas of a text that is configured so.
fn areas(text: &str, area: &Area) -> Areas {
    Areas(vec![(area.clone(), contents(text, area).unwrap_or_else(|problem| panic!("{problem}\n{text}")))])
}

/// Why a text is refused.
fn refusal(text: &str, area: &Area) -> String {
    match contents(text, area) {
        Ok(contents) => panic!("understood: {contents:?}"),
        Err(problem) => problem,
    }
}

/// Areas of kind `alert` of a text, for tests of what is shown of them.
pub(crate) fn areas_of(text: &str, change: impl FnOnce(&mut AlertArea)) -> Areas {
    areas(text, &alert(change))
}

/// The same for tests of what they raise.
pub(crate) fn alert_areas(text: &str, change: impl FnOnce(&mut AlertArea)) -> AlertAreas {
    areas(text, &alert(change)).alerts()
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
