//! Past trails and pictures, from the history: one picture per second.

use std::fmt::Write as _;

use axum::http::StatusCode;
use jiff::SignedDuration;
use schemars::JsonSchema;
use serde::Serialize;

use super::antimeridian;
use super::ask::{Answer, Ask, GEO_JSON, json, live};
use super::geometry::{CollectionType, Feature, Geometry, Point, Position};
use super::problem::Problem;
use super::trails::PLACES_OF_A_REQUEST;
use crate::history::{SavedTrack, Store};
use crate::json::rounded;
use crate::picture::{Rfc3339, TrackSource};
use crate::xml;
use fusion::time::Time;

/// Default duration of a trail.
const TRAIL: SignedDuration = SignedDuration::from_mins(10);
/// Most positions of a trail: a day of them.
const PLACES: usize = 86_400;
/// Greatest age of a snapshot at the time asked for: one picture per second is kept.
const WITHIN: SignedDuration = SignedDuration::from_secs(2);

/// Cost of a trail in requests, by the number of positions that its time span may have.
pub fn trail_weight(ask: &Ask) -> u32 {
    let seconds = span(ask).map_or(0.0, |(since, until)| until.seconds_since(since));
    1 + seconds.clamp(0.0, PLACES as f64) as u32 / PLACES_OF_A_REQUEST
}

/// From when to when.
fn span(ask: &Ask) -> Result<(Time, Time), Problem> {
    let until = ask.query.time("until")?.unwrap_or_else(|| ask.state.now());
    Ok((ask.query.time("since")?.unwrap_or(until + -TRAIL), until))
}

/// Media types of a trail that is no GeoJSON.
pub const GPX: &str = "application/gpx+xml";
pub const KML: &str = "application/vnd.google-earth.kml+xml";
pub const CSV: &str = "text/csv; charset=utf-8";

/// Format of a trail.
#[derive(Clone, Copy)]
pub enum TrailFormat {
    GeoJson,
    Gpx,
    Kml,
    Csv,
}

fusion::interface_names!(TrailFormat { GeoJson = "geojson", Gpx = "gpx", Kml = "kml", Csv = "csv" });

/// `/api/v1/tracks/{id}/trail`.
pub fn trail(ask: &Ask) -> Answer {
    let (since, until) = span(ask)?;
    let format = ask.query.text("format").unwrap_or(TrailFormat::GeoJson.name());
    let format = TrailFormat::ALL.into_iter().find(|known| known.name() == format);
    type Write = fn(&str, &[(Time, SavedTrack)]) -> String;
    let written: Option<(&'static str, Write)> = match format {
        Some(TrailFormat::GeoJson) => None,
        Some(TrailFormat::Gpx) => Some((GPX, gpx)),
        Some(TrailFormat::Kml) => Some((KML, kml)),
        Some(TrailFormat::Csv) => Some((CSV, csv)),
        None => {
            let rule = format!("one of {}", TrailFormat::NAMES.join(", "));
            return Err(Problem::parameter("format", &rule));
        }
    };
    let places = store(ask)?.trail(&ask.id, since, until, PLACES).map_err(|error| failed(&error))?;
    if places.is_empty() {
        return Err(Problem::not_found("the history has no place of this id in that time"));
    }
    match written {
        Some((content_type, write)) => Ok(live(content_type, write(&ask.id, &places))),
        None => json(GEO_JSON, &geojson(&ask.id, &places, ask.state.hub.maker.geoid_undulation_m())),
    }
}

/// The picture at a past time: GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
pub struct Snapshot {
    r#type: CollectionType,
    time: Rfc3339,
    /// Its configured name.
    site: String,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    features: Vec<Feature<'static, Point, PastProperties>>,
}

/// A track as the history has it.
#[derive(Serialize, JsonSchema)]
struct PastProperties {
    id: String,
    #[schemars(extend("enum" = TrackSource::NAMES))]
    source: &'static str,
    track_number: u32,
    time: Rfc3339,
    lat: f64,
    lng: f64,
    /// Metres above mean sea level, where a height was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_msl: Option<f64>,
}

/// `/api/v1/snapshot`.
pub fn snapshot(ask: &Ask) -> Result<Snapshot, Problem> {
    let at =
        ask.query.time("time")?.ok_or_else(|| Problem::parameter("time", "it has to be given, RFC 3339"))?;
    let store = store(ask)?;
    let Some(snapshot) = store.snapshot(at, WITHIN).map_err(|error| failed(&error))? else {
        let kept = store.span().map_err(|error| failed(&error))?;
        let kept =
            kept.map_or("it is empty".to_owned(), |(first, last)| format!("it goes from {first} to {last}"));
        return Err(Problem::not_found(format!("the history has no picture of that time; {kept}")));
    };
    let undulation_m = ask.state.hub.maker.geoid_undulation_m();
    let feature = |track: &SavedTrack| {
        let (lng, lat, height_m) = position(track, undulation_m);
        let properties = PastProperties {
            id: track.id.clone(),
            source: track.source,
            track_number: track.number,
            time: snapshot.time.into(),
            lat,
            lng,
            alt_msl: alt_msl(track),
        };
        Feature::new(track.id.clone(), Point::new(lng, lat, height_m), properties)
    };
    Ok(Snapshot {
        r#type: CollectionType::default(),
        time: snapshot.time.into(),
        site: ask.state.hub.config.site.name.clone(),
        matched: snapshot.tracks.len(),
        returned: snapshot.tracks.len(),
        features: snapshot.tracks.iter().map(feature).collect(),
    })
}

fn store(ask: &Ask) -> Result<&Store, Problem> {
    let none = || Problem::not_found("no history is kept; state.history_hours sets how long it is");
    ask.state.options.history.as_ref().ok_or_else(none)
}

fn failed(error: &redb::Error) -> Problem {
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the history cannot be read: {error}"))
}

fn alt_msl(track: &SavedTrack) -> Option<f64> {
    track.altitude_amsl_m.map(|metres| rounded(metres, 2))
}

/// Longitude, latitude, and the ellipsoidal height where one was measured.
fn position(track: &SavedTrack, undulation_m: f64) -> (f64, f64, Option<f64>) {
    let height_m = track.altitude_amsl_m.map(|metres| rounded(metres + undulation_m, 2));
    (rounded(track.longitude_deg, 7), rounded(track.latitude_deg, 7), height_m)
}

/// Where a track was: a line, or a point where there is only one place; several lines where it crossed the antimeridian.
pub type Trail<'a> = Feature<'a, Geometry, TrailProperties<'a>>;

#[derive(Serialize, JsonSchema)]
pub struct TrailProperties<'a> {
    id: &'a str,
    /// Of each place.
    times: Vec<Rfc3339>,
    /// Of each place.
    #[schemars(extend("items" = { "type": "string", "enum": TrackSource::NAMES }))]
    sources: Vec<&'static str>,
    /// Of each place, metres above mean sea level; null where no height was measured.
    alt_msl: Vec<Option<f64>>,
}

fn geojson<'a>(id: &'a str, places: &[(Time, SavedTrack)], undulation_m: f64) -> Trail<'a> {
    // A line's positions are all of one dimension: without a height everywhere there is none.
    let all_high = places.iter().all(|(_, place)| place.altitude_amsl_m.is_some());
    let position = |(_, place): &(Time, SavedTrack)| {
        let (lng, lat, height_m) = position(place, undulation_m);
        Position::new(lng, lat, height_m.filter(|_| all_high))
    };
    let parts = antimeridian::cut(places);
    let mut lines: Vec<Vec<Position>> =
        parts.iter().map(|part| part.iter().map(position).collect()).collect();
    let geometry = match (lines.len(), lines[0].len()) {
        (1, 1) => Geometry::Point(lines.remove(0).remove(0)),
        (1, _) => Geometry::LineString(lines.remove(0)),
        _ => Geometry::MultiLineString(lines),
    };
    let places = || parts.iter().flatten();
    let properties = TrailProperties {
        id,
        times: places().map(|&(time, _)| time.into()).collect(),
        sources: places().map(|(_, place)| place.source).collect(),
        alt_msl: places().map(|(_, place)| alt_msl(place)).collect(),
    };
    Feature::new(id, geometry, properties)
}

/// GPX 1.1; its elevations are above mean sea level.
fn gpx(id: &str, places: &[(Time, SavedTrack)]) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"utm-fusion\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><name>{}</name><trkseg>\n",
        xml::escape(id)
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
fn kml(id: &str, places: &[(Time, SavedTrack)]) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Placemark><name>{}</name>",
        xml::escape(id)
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

fn csv(_: &str, places: &[(Time, SavedTrack)]) -> String {
    let mut text = String::from("time,source,track_number,lat,lon,alt_msl\n");
    for (time, place) in places {
        let altitude = place.altitude_amsl_m.map_or(String::new(), |metres| format!("{metres:.2}"));
        let SavedTrack { source, number, latitude_deg, longitude_deg, .. } = place;
        let _ = writeln!(text, "{time},{source},{number},{latitude_deg:.7},{longitude_deg:.7},{altitude}");
    }
    text
}
