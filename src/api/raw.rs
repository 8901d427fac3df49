//! `/api/v1/raw`: what the sensors said, before anything was made of it.

use serde_json::{Value, json};

use super::ask::{Answer, Ask, GEO_JSON, json};
use crate::json::rounded;
use fusion::Report;

/// The largest number that is asked for: JSON's numbers are exact to about here.
const LARGEST: u64 = 9_000_000_000_000_000;

/// The reports after a number, as the engine took them.
pub fn all(ask: &Ask) -> Answer {
    let after = ask.value("after", "a whole number: last of the answer before", |after| *after <= LARGEST)?;
    let (reports, last) = ask.state.hub().inputs.after(after.unwrap_or(0));
    let features: Vec<Value> = reports.iter().map(|report| feature(ask, report)).collect();
    json(GEO_JSON, &json!({ "type": "FeatureCollection", "last": last, "features": features }))
}

fn feature(ask: &Ask, report: &Report) -> Value {
    let maker = &ask.state.hub().maker;
    let (sensor, position, is_high) = match report {
        Report::Plot(plot) => (plot.track.sensor, plot.position, plot.height_measured),
        Report::Fix(fix) => (fix.sensor, fix.position, true),
    };
    let place = maker.place(position);
    let mut coordinates = vec![rounded(place.longitude_deg(), 7), rounded(place.latitude_deg(), 7)];
    coordinates.extend(is_high.then(|| rounded(place.height_m, 2)));
    let mut properties = json!({ "sensor": maker.sensor(sensor), "time": report.time().to_string() });
    match report {
        Report::Plot(plot) => {
            properties["kind"] = json!("radar");
            properties["track_number"] = json!(plot.track.number);
            if let Some(probability) = plot.uav_probability {
                properties["uav_probability"] = json!(rounded(probability, 4));
            }
        }
        Report::Fix(fix) => {
            properties["kind"] = json!("transponder");
            properties["serial_number"] = json!(fix.identity.serial().escape_ascii().to_string());
        }
    }
    let geometry = json!({ "type": "Point", "coordinates": coordinates });
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}
