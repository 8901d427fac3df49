//! Past trails and pictures, from the history: one picture per second.

use std::fmt::Write as _;

use axum::http::StatusCode;
use jiff::SignedDuration;
use schemars::JsonSchema;
use serde::Serialize;

use super::antimeridian;
use super::geometry::{CollectionType, Feature, GeoJsonGeometry, GeoPosition, Point};
use super::problem::Problem;
use super::request::{ApiRequest, ApiResult, GEO_JSON, json, live};
use super::trails::PLACES_OF_A_REQUEST;
use fusion::time::Time;
use input::json::rounded;
use picture::xml;
use picture::{Rfc3339, TrackSource};
use service::history::{HistoryStore, HistoryTrack};

/// Default duration of a trail.
const TRAIL: SignedDuration = SignedDuration::from_mins(10);
/// Maximum number of positions of a trail: one day.
const PLACES: usize = 86_400;
/// Maximum difference of a snapshot's time from the requested one. One picture per second is kept.
const WITHIN: SignedDuration = SignedDuration::from_secs(2);

/// Cost of a trail in requests, by the number of positions that its time span may contain.
pub fn trail_weight(request: &ApiRequest) -> u32 {
    let seconds = span(request).map_or(0.0, |(since, until)| until.seconds_since(since));
    1 + seconds.clamp(0.0, PLACES as f64) as u32 / PLACES_OF_A_REQUEST
}

/// Start and end time in the parameters of a request.
fn span(request: &ApiRequest) -> Result<(Time, Time), Problem> {
    let until = request.query.time("until")?.unwrap_or_else(|| request.state.now());
    Ok((request.query.time("since")?.unwrap_or(until + -TRAIL), until))
}

/// Media types of a trail other than GeoJSON.
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
pub fn trail(request: &ApiRequest) -> ApiResult {
    let (since, until) = span(request)?;
    let format = request.query.text("format").unwrap_or(TrailFormat::GeoJson.name());
    let format = TrailFormat::ALL.into_iter().find(|known| known.name() == format);
    type Write = fn(&str, &[(Time, HistoryTrack)]) -> String;
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
    let places = store(request)?.trail(&request.id, since, until, PLACES).map_err(|error| failed(&error))?;
    if places.is_empty() {
        return Err(Problem::not_found("the history has no place of this id in that time"));
    }
    match written {
        Some((content_type, write)) => Ok(live(content_type, write(&request.id, &places))),
        None => json(GEO_JSON, &geojson(&request.id, &places, request.state.hub.maker.geoid_undulation_m())),
    }
}

/// The picture at a past time: GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Snapshot")]
pub struct PastPicture {
    r#type: CollectionType,
    time: Rfc3339,
    /// Configured name of the site.
    site: String,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    features: Vec<Feature<'static, Point, PastProperties>>,
}

/// Properties of a track from the history.
#[derive(Serialize, JsonSchema)]
struct PastProperties {
    id: String,
    #[schemars(extend("enum" = TrackSource::NAMES))]
    source: &'static str,
    track_number: u32,
    time: Rfc3339,
    lat: f64,
    lng: f64,
    /// Height above mean sea level, in metres, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    alt_msl: Option<f64>,
}

/// `/api/v1/snapshot`.
pub fn snapshot(request: &ApiRequest) -> Result<PastPicture, Problem> {
    let at = request
        .query
        .time("time")?
        .ok_or_else(|| Problem::parameter("time", "it has to be given, RFC 3339"))?;
    let store = store(request)?;
    let Some(snapshot) = store.snapshot(at, WITHIN).map_err(|error| failed(&error))? else {
        let kept = store.span().map_err(|error| failed(&error))?;
        let kept =
            kept.map_or("it is empty".to_owned(), |(first, last)| format!("it goes from {first} to {last}"));
        return Err(Problem::not_found(format!("the history has no picture of that time; {kept}")));
    };
    let undulation_m = request.state.hub.maker.geoid_undulation_m();
    let feature = |track: &HistoryTrack| {
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
    Ok(PastPicture {
        r#type: CollectionType::default(),
        time: snapshot.time.into(),
        site: request.state.hub.config.site.name.clone(),
        matched: snapshot.tracks.len(),
        returned: snapshot.tracks.len(),
        features: snapshot.tracks.iter().map(feature).collect(),
    })
}

fn store(request: &ApiRequest) -> Result<&HistoryStore, Problem> {
    let none = || Problem::not_found("no history is kept; state.history_hours sets how long it is");
    request.state.options.history.as_ref().ok_or_else(none)
}

fn failed(error: &redb::Error) -> Problem {
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the history cannot be read: {error}"))
}

fn alt_msl(track: &HistoryTrack) -> Option<f64> {
    track.altitude_amsl_m.map(|metres| rounded(metres, 2))
}

/// Longitude, latitude, and the ellipsoidal height if it was measured.
fn position(track: &HistoryTrack, undulation_m: f64) -> (f64, f64, Option<f64>) {
    let height_m = track.altitude_amsl_m.map(|metres| rounded(metres + undulation_m, 2));
    (rounded(track.longitude_deg, 7), rounded(track.latitude_deg, 7), height_m)
}

/// Trail of a track: a line, or a point if there is only one position; several lines if it crossed the antimeridian.
pub type Trail<'a> = Feature<'a, GeoJsonGeometry, TrailProperties<'a>>;

#[derive(Serialize, JsonSchema)]
pub struct TrailProperties<'a> {
    id: &'a str,
    /// Time of each position.
    times: Vec<Rfc3339>,
    /// Source of each position.
    #[schemars(extend("items" = { "type": "string", "enum": TrackSource::NAMES }))]
    sources: Vec<&'static str>,
    /// Height of each position above mean sea level, in metres; null if none was measured.
    alt_msl: Vec<Option<f64>>,
}

fn geojson<'a>(id: &'a str, places: &[(Time, HistoryTrack)], undulation_m: f64) -> Trail<'a> {
    // All positions of a line have the same dimension. If one height is missing, all are left out.
    let all_high = places.iter().all(|(_, place)| place.altitude_amsl_m.is_some());
    let position = |(_, place): &(Time, HistoryTrack)| {
        let (lng, lat, height_m) = position(place, undulation_m);
        GeoPosition::new(lng, lat, height_m.filter(|_| all_high))
    };
    let parts = antimeridian::cut(places);
    let mut lines: Vec<Vec<GeoPosition>> =
        parts.iter().map(|part| part.iter().map(position).collect()).collect();
    let geometry = match (lines.len(), lines[0].len()) {
        (1, 1) => GeoJsonGeometry::Point(lines.remove(0).remove(0)),
        (1, _) => GeoJsonGeometry::LineString(lines.remove(0)),
        _ => GeoJsonGeometry::MultiLineString(lines),
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

/// GPX 1.1. Its elevations are above mean sea level.
fn gpx(id: &str, places: &[(Time, HistoryTrack)]) -> String {
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

/// KML 2.3. Its heights are above mean sea level. A KML track is either in the air or on the ground, so a trail with heights in
/// parts only becomes several tracks. Parts without a height are on the ground, and no line joins the parts.
fn kml(id: &str, places: &[(Time, HistoryTrack)]) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Placemark><name>{}</name>",
        xml::escape(id)
    );
    let is_high = |(_, place): &(Time, HistoryTrack)| place.altitude_amsl_m.is_some();
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

/// A KML track of positions that all have a height, or all have none.
fn kml_track(places: &[(Time, HistoryTrack)]) -> String {
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

fn csv(_: &str, places: &[(Time, HistoryTrack)]) -> String {
    let mut text = String::from("time,source,track_number,lat,lon,alt_msl\n");
    for (time, place) in places {
        let altitude = place.altitude_amsl_m.map_or(String::new(), |metres| format!("{metres:.2}"));
        let HistoryTrack { source, number, latitude_deg, longitude_deg, .. } = place;
        let _ = writeln!(text, "{time},{source},{number},{latitude_deg:.7},{longitude_deg:.7},{altitude}");
    }
    text
}
