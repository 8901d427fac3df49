//! Where tracks were, and what the picture was: from the history, a picture a second.

use std::fmt::Write as _;

use axum::http::StatusCode;
use jiff::{SignedDuration, Timestamp};
use serde_json::{Value, json};

use super::ask::{Answer, Ask, GEO_JSON, json, live};
use super::problem::Problem;
use crate::history::{SavedTrack, Store};
use crate::json::rounded;
use fusion::time::Time;

/// A trail goes back this far where it is not said how far.
const TRAIL: SignedDuration = SignedDuration::from_mins(10);
/// Places of a trail: a day of them.
const PLACES: usize = 86_400;
/// A snapshot is the latest picture at most this much before the time asked for: one a second is kept.
const WITHIN: SignedDuration = SignedDuration::from_secs(2);

/// `/api/v1/tracks/{id}/trail`.
pub fn trail(ask: &Ask) -> Answer {
    let until = time(ask, "until")?.unwrap_or_else(|| ask.state.now());
    let since = time(ask, "since")?.unwrap_or(until + -TRAIL);
    let format = ask.text("format").unwrap_or("geojson");
    let write: fn(&str, &[(Time, SavedTrack)], f64) -> String = match format {
        "geojson" => geojson,
        "gpx" => gpx,
        "kml" => kml,
        "csv" => csv,
        _ => return Err(Problem::parameter("format", "it is geojson, gpx, kml or csv")),
    };
    let content_type = match format {
        "gpx" => "application/gpx+xml",
        "kml" => "application/vnd.google-earth.kml+xml",
        "csv" => "text/csv; charset=utf-8",
        _ => GEO_JSON,
    };
    let places = store(ask)?.trail(&ask.id, since, until, PLACES).map_err(|error| failed(&error))?;
    if places.is_empty() {
        return Err(Problem::not_found("the history has no place of this id in that time"));
    }
    let undulation_m = ask.state.hub().maker.geoid_undulation_m();
    Ok(live(content_type, write(&ask.id, &places, undulation_m)))
}

/// `/api/v1/snapshot`.
pub fn snapshot(ask: &Ask) -> Answer {
    let at = time(ask, "time")?.ok_or_else(|| Problem::parameter("time", "it has to be given, RFC 3339"))?;
    let store = store(ask)?;
    let Some(snapshot) = store.snapshot(at, WITHIN).map_err(|error| failed(&error))? else {
        let kept = store.span().map_err(|error| failed(&error))?;
        let kept =
            kept.map_or("it is empty".to_owned(), |(first, last)| format!("it goes from {first} to {last}"));
        return Err(Problem::not_found(format!("the history has no picture of that time; {kept}")));
    };
    let undulation_m = ask.state.hub().maker.geoid_undulation_m();
    let feature = |track: &SavedTrack| {
        json!({
            "type": "Feature",
            "id": track.id,
            "geometry": { "type": "Point", "coordinates": position(track, undulation_m) },
            "properties": properties(track, snapshot.time),
        })
    };
    json(
        GEO_JSON,
        &json!({
            "type": "FeatureCollection",
            "time": snapshot.time.to_string(),
            "site": ask.state.hub().config.site.name,
            "numberMatched": snapshot.tracks.len(),
            "numberReturned": snapshot.tracks.len(),
            "features": snapshot.tracks.iter().map(feature).collect::<Vec<_>>(),
        }),
    )
}

fn store(ask: &Ask) -> Result<&Store, Problem> {
    let none = || Problem::not_found("no history is kept; state.history_hours sets how long it is");
    ask.state.options().history.as_ref().ok_or_else(none)
}

fn failed(error: &redb::Error) -> Problem {
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the history cannot be read: {error}"))
}

/// A time in a parameter.
pub(super) fn time(ask: &Ask, name: &str) -> Result<Option<Time>, Problem> {
    let Some(text) = ask.text(name) else { return Ok(None) };
    let stamp = text.parse::<Timestamp>().ok();
    let time = stamp.and_then(|stamp| i64::try_from(stamp.as_nanosecond()).ok()).map(Time::from_nanos);
    time.map(Some).ok_or_else(|| Problem::parameter(name, "a time is RFC 3339, such as 2026-03-14T09:00:00Z"))
}

/// Longitude, latitude, and the ellipsoidal height where one was measured.
fn position(track: &SavedTrack, undulation_m: f64) -> Vec<f64> {
    let mut position = vec![rounded(track.longitude_deg, 7), rounded(track.latitude_deg, 7)];
    position.extend(track.altitude_amsl_m.map(|metres| rounded(metres + undulation_m, 2)));
    position
}

fn properties(track: &SavedTrack, time: Time) -> Value {
    let mut properties = json!({
        "id": track.id,
        "source": track.source,
        "track_number": track.number,
        "time": time.to_string(),
        "lat": rounded(track.latitude_deg, 7),
        "lng": rounded(track.longitude_deg, 7),
    });
    if let Some(metres) = track.altitude_amsl_m {
        properties["alt_msl"] = json!(rounded(metres, 2));
    }
    properties
}

/// A line (a point where there is only one place) with the time and source of each place.
fn geojson(id: &str, places: &[(Time, SavedTrack)], undulation_m: f64) -> String {
    // A line's positions are all of one dimension: without a height everywhere there is none.
    let all_high = places.iter().all(|(_, place)| place.altitude_amsl_m.is_some());
    let positions: Vec<Vec<f64>> = places
        .iter()
        .map(|(_, place)| {
            let mut position = position(place, undulation_m);
            position.truncate(if all_high { 3 } else { 2 });
            position
        })
        .collect();
    let geometry = match &positions[..] {
        [one] => json!({ "type": "Point", "coordinates": one }),
        more => json!({ "type": "LineString", "coordinates": more }),
    };
    json!({
        "type": "Feature",
        "id": id,
        "geometry": geometry,
        "properties": {
            "id": id,
            "times": places.iter().map(|(time, _)| time.to_string()).collect::<Vec<_>>(),
            "sources": places.iter().map(|(_, place)| place.source).collect::<Vec<_>>(),
            "alt_msl": places.iter().map(|(_, place)| place.altitude_amsl_m.map(|m| rounded(m, 2))).collect::<Vec<_>>(),
        },
    })
    .to_string()
}

/// GPX 1.1; its elevations are above mean sea level.
fn gpx(id: &str, places: &[(Time, SavedTrack)], _: f64) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"utm-fusion\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><name>{}</name><trkseg>\n",
        escaped(id)
    );
    for (time, place) in places {
        let ele = place.altitude_amsl_m.map_or(String::new(), |metres| format!("<ele>{metres:.2}</ele>"));
        let (lat, lon) = (place.latitude_deg, place.longitude_deg);
        // Writing to a String does not fail.
        let _ = writeln!(text, "<trkpt lat=\"{lat:.7}\" lon=\"{lon:.7}\">{ele}<time>{time}</time></trkpt>");
    }
    text + "</trkseg></trk>\n</gpx>\n"
}

/// KML 2.3 with a track; its heights are above mean sea level. A track is either in the air or on the ground, so a trail
/// of which only parts have a height is several: those without lie on the ground, and no line joins the two.
fn kml(id: &str, places: &[(Time, SavedTrack)], _: f64) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Placemark><name>{}</name>",
        escaped(id)
    );
    let is_high = |(_, place): &(Time, SavedTrack)| place.altitude_amsl_m.is_some();
    let parts: Vec<String> =
        places.chunk_by(|one, next| is_high(one) == is_high(next)).map(kml_track).collect();
    match &parts[..] {
        [one] => text += one,
        parts => {
            text += "<gx:MultiTrack>\n";
            for part in parts {
                let _ = writeln!(text, "{part}");
            }
            text += "</gx:MultiTrack>";
        }
    }
    text + "</Placemark>\n</kml>\n"
}

/// Places of which all have a height or none has.
fn kml_track(places: &[(Time, SavedTrack)]) -> String {
    let is_high = places.iter().all(|(_, place)| place.altitude_amsl_m.is_some());
    let mode = if is_high { "absolute" } else { "clampToGround" };
    let mut text = format!("<gx:Track><altitudeMode>{mode}</altitudeMode>\n");
    for (time, _) in places {
        let _ = writeln!(text, "<when>{time}</when>");
    }
    for (_, place) in places {
        let height = place.altitude_amsl_m.map_or(String::new(), |metres| format!(" {metres:.2}"));
        let (longitude_deg, latitude_deg) = (place.longitude_deg, place.latitude_deg);
        let _ = writeln!(text, "<gx:coord>{longitude_deg:.7} {latitude_deg:.7}{height}</gx:coord>");
    }
    text + "</gx:Track>"
}

fn csv(_: &str, places: &[(Time, SavedTrack)], _: f64) -> String {
    let mut text = String::from("time,source,track_number,lat,lon,alt_msl\n");
    for (time, place) in places {
        let altitude = place.altitude_amsl_m.map_or(String::new(), |metres| format!("{metres:.2}"));
        let SavedTrack { source, number, latitude_deg, longitude_deg, .. } = place;
        let _ = writeln!(text, "{time},{source},{number},{latitude_deg:.7},{longitude_deg:.7},{altitude}");
    }
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
