//! `/api/v1/raw`: reports of the sensors before fusion.

use schemars::JsonSchema;
use serde::Serialize;

use super::geometry::{CollectionType, Point, UnnamedFeature};
use super::problem::Problem;
use super::request::ApiRequest;
use fusion::Report;
use input::json::rounded;
use picture::{PictureMaker, Rfc3339, serial_text};

/// Largest valid number: JSON numbers are exact up to about this.
const LARGEST: u64 = 9_000_000_000_000_000;

/// Reports as GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Raw")]
pub struct RawReports {
    r#type: CollectionType,
    /// Number of the last report, for `after` in the next request.
    last: u64,
    features: Vec<UnnamedFeature<Point, ReportProperties>>,
}

/// A report of a radar or a transponder.
#[derive(Serialize, JsonSchema)]
struct ReportProperties {
    /// Configured id of the sensor.
    sensor: String,
    time: Rfc3339,
    #[serde(flatten)]
    of: ReportOrigin,
}

#[derive(Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[schemars(rename = "Origin")]
enum ReportOrigin {
    Radar {
        track_number: u16,
        /// Probability that the target is a drone, as stated by the radar.
        #[serde(skip_serializing_if = "Option::is_none")]
        uav_probability: Option<f64>,
    },
    Transponder {
        serial_number: String,
    },
}

/// Reports after a given number, as taken by the engine.
pub fn all(request: &ApiRequest) -> Result<RawReports, Problem> {
    let rule = "a whole number: last of the answer before";
    let after = request.query.value("after", rule, |after| *after <= LARGEST)?;
    let hub = &request.state.hub;
    let (reports, last) = hub.recent_reports.after(after.unwrap_or(0));
    let features = reports.iter().filter_map(|report| feature(&hub.maker, report)).collect();
    Ok(RawReports { r#type: CollectionType::default(), last, features })
}

/// A report as a feature; `None` for a bearing, which has no position.
fn feature(maker: &PictureMaker, report: &Report) -> Option<UnnamedFeature<Point, ReportProperties>> {
    let (sensor, position, is_high, of) = match report {
        Report::Plot(plot) => {
            let uav_probability = plot.uav_probability.map(|probability| rounded(probability, 4));
            let of = ReportOrigin::Radar { track_number: plot.track.number, uav_probability };
            (plot.track.sensor, plot.position, plot.height_measured, of)
        }
        Report::Fix(fix) => {
            let of = ReportOrigin::Transponder { serial_number: serial_text(fix.identity) };
            (fix.sensor, fix.position, fix.height_measured, of)
        }
        Report::Bearing(_) => return None,
    };
    let place = maker.place(position);
    let [lng, lat] = [place.longitude_deg(), place.latitude_deg()].map(|degrees| rounded(degrees, 7));
    let sensor = maker.sensor(sensor).to_owned();
    Some(UnnamedFeature::new(
        Point::new(lng, lat, is_high.then(|| rounded(place.height_m, 2))),
        ReportProperties { sensor, time: report.time().into(), of },
    ))
}
