//! `/api/v1/raw`: what the sensors said, before anything was made of it.

use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::geometry::{CollectionType, Point, Unnamed};
use super::problem::Problem;
use crate::json::rounded;
use crate::picture::{PictureMaker, Rfc3339, serial_text};
use fusion::Report;

/// The largest number that is asked for: JSON's numbers are exact to about here.
const LARGEST: u64 = 9_000_000_000_000_000;

/// GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
pub struct Raw {
    r#type: CollectionType,
    /// Number of the last report, for the next request's `after`.
    last: u64,
    features: Vec<Unnamed<Point, ReportProperties>>,
}

/// A report of a radar or a transponder.
#[derive(Serialize, JsonSchema)]
struct ReportProperties {
    /// Its configured id.
    sensor: String,
    time: Rfc3339,
    #[serde(flatten)]
    of: Origin,
}

#[derive(Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Origin {
    Radar {
        track_number: u16,
        /// That it is a drone, according to the radar.
        #[serde(skip_serializing_if = "Option::is_none")]
        uav_probability: Option<f64>,
    },
    Transponder {
        serial_number: String,
    },
}

/// The reports after a number, as the engine took them.
pub fn all(ask: &Ask) -> Result<Raw, Problem> {
    let rule = "a whole number: last of the answer before";
    let after = ask.query.value("after", rule, |after| *after <= LARGEST)?;
    let hub = &ask.state.hub;
    let (reports, last) = hub.inputs.after(after.unwrap_or(0));
    let features = reports.iter().filter_map(|report| feature(&hub.maker, report)).collect();
    Ok(Raw { r#type: CollectionType::default(), last, features })
}

/// `None` of a bearing, which is no place.
fn feature(maker: &PictureMaker, report: &Report) -> Option<Unnamed<Point, ReportProperties>> {
    let (sensor, position, is_high, of) = match report {
        Report::Plot(plot) => {
            let uav_probability = plot.uav_probability.map(|probability| rounded(probability, 4));
            let of = Origin::Radar { track_number: plot.track.number, uav_probability };
            (plot.track.sensor, plot.position, plot.height_measured, of)
        }
        Report::Fix(fix) => {
            let of = Origin::Transponder { serial_number: serial_text(fix.identity) };
            (fix.sensor, fix.position, fix.height_measured, of)
        }
        Report::Bearing(_) => return None,
    };
    let place = maker.place(position);
    let [lng, lat] = [place.longitude_deg(), place.latitude_deg()].map(|degrees| rounded(degrees, 7));
    let sensor = maker.sensor(sensor).to_owned();
    Some(Unnamed::new(
        Point::new(lng, lat, is_high.then(|| rounded(place.height_m, 2))),
        ReportProperties { sensor, time: report.time().into(), of },
    ))
}
