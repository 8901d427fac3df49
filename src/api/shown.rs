//! A slot as readers get it: its JSON is made once, and everybody's answer is that or pieces of it.

use std::ops::Range;
use std::sync::Arc;

use axum::body::Bytes;
use serde::Serialize;

use super::filter::Filter;
use crate::json::rounded;
use crate::live::Frame;
use crate::picture::{PictureMaker, Track, TrackJson};
use crate::time::Time;

/// A published slot with its JSON.
#[derive(Clone, Debug)]
pub struct Shown {
    /// As the engine put it out.
    pub frame: Arc<Frame>,
    /// Its tracks, in the order of the picture.
    pub pieces: Vec<Piece>,
    site: String,
    /// The `tracks` event of the stream; the feature collection is a part of it.
    event: Bytes,
    collection: Range<usize>,
}

/// A track's feature, and what filters ask of it.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Where it stands in the picture.
    index: usize,
    /// The track's id.
    pub id: Arc<str>,
    /// `fused`, `radar` or `transponder`.
    pub source: &'static str,
    /// Degrees.
    pub lng: f64,
    /// Degrees.
    pub lat: f64,
    /// Metres above mean sea level, where it was measured.
    pub alt_msl: Option<f64>,
    radar: Option<usize>,
    transponder: Option<usize>,
    /// The GeoJSON feature.
    pub feature: Bytes,
}

impl Piece {
    /// The sensors that took part, as indices.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.radar.into_iter().chain(self.transponder)
    }
}

#[derive(Serialize)]
struct Feature<'a> {
    r#type: &'static str,
    id: &'a str,
    geometry: Point,
    properties: Properties<'a>,
}

/// Longitude, latitude and, where it was measured, ellipsoidal height.
#[derive(Serialize)]
struct Point {
    r#type: &'static str,
    coordinates: Vec<f64>,
}

#[derive(Serialize)]
struct Properties<'a> {
    #[serde(flatten)]
    track: TrackJson<'a>,
    age_s: f64,
}

/// What stands in front of the features.
#[derive(Serialize)]
struct Head<'a> {
    r#type: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    published_at: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_s: Option<f64>,
    seq: u64,
    site: &'a str,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
}

impl Shown {
    /// Writes the JSON of a slot into the event that begins with these lines.
    pub fn new(frame: &Arc<Frame>, maker: &PictureMaker, site: &str, event_head: &str) -> Self {
        let age_s = rounded(frame.published_at.seconds_since(frame.picture.time), 3);
        // A place that is no number has no place on a map; the engine gives none, and none is passed on.
        let placed = |(_, track): &(usize, &Track)| {
            track.position.latitude_deg().is_finite() && track.position.longitude_deg().is_finite()
        };
        let tracks: Vec<(usize, &Track)> = frame.picture.tracks.iter().enumerate().filter(placed).collect();
        let mut out = event_head.as_bytes().to_vec();
        let start = out.len();
        write_head(&mut out, Some(frame), site, tracks.len(), tracks.len());
        let mut places = Vec::with_capacity(tracks.len());
        for &(_, track) in &tracks {
            if !places.is_empty() {
                out.push(b',');
            }
            let from = out.len();
            write_feature(&mut out, track, maker, age_s);
            places.push(from..out.len());
        }
        out.extend_from_slice(b"]}");
        let end = out.len();
        out.extend_from_slice(b"\n\n");
        let event = Bytes::from(out);
        // Filters compare what readers see: the rounded values.
        let piece = |(&(index, track), place): (&(usize, &Track), Range<usize>)| Piece {
            index,
            id: maker.track_id(track).into(),
            source: track.source_name(),
            lng: rounded(track.position.longitude_deg(), 9),
            lat: rounded(track.position.latitude_deg(), 9),
            alt_msl: track.altitude_amsl_m.map(|metres| rounded(metres, 3)),
            radar: track.point.source.radar().map(|radar| usize::from(radar.track.sensor.0)),
            transponder: track.point.source.transponder().map(|part| usize::from(part.sensor.0)),
            feature: event.slice(place),
        };
        let pieces = tracks.iter().zip(places).map(piece).collect();
        Self { frame: frame.clone(), pieces, site: site.to_owned(), event, collection: start..end }
    }

    /// The feature collection of all its tracks.
    pub fn collection(&self) -> Bytes {
        self.event.slice(self.collection.clone())
    }

    /// The `tracks` event of all its tracks.
    pub fn event(&self) -> Bytes {
        self.event.clone()
    }

    /// The feature collection of what a filter lets through.
    pub fn filtered(&self, filter: &Filter) -> Bytes {
        if filter.is_all() { self.collection() } else { self.join(self.pieces.iter(), filter) }
    }

    /// The feature collection, with the head of this slot, of what a filter lets through of other pieces.
    pub fn join<'a>(&self, pieces: impl Iterator<Item = &'a Piece>, filter: &Filter) -> Bytes {
        let wanted: Vec<&Piece> = pieces.filter(|piece| filter.wants(piece)).collect();
        let returned = &wanted[..wanted.len().min(filter.limit())];
        let mut out =
            Vec::with_capacity(512 + returned.iter().map(|piece| piece.feature.len() + 1).sum::<usize>());
        write_head(&mut out, Some(&self.frame), &self.site, wanted.len(), returned.len());
        for (index, piece) in returned.iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            out.extend_from_slice(&piece.feature);
        }
        out.extend_from_slice(b"]}");
        out.into()
    }

    /// The track of a piece.
    pub fn track(&self, piece: &Piece) -> &Track {
        &self.frame.picture.tracks[piece.index]
    }

    /// When its tracks were there.
    pub fn time(&self) -> Time {
        self.frame.picture.time
    }

    /// From there to its publication, seconds.
    pub fn latency_s(&self) -> f64 {
        rounded(self.frame.published_at.seconds_since(self.time()), 3)
    }
}

/// The picture before the first slot: nothing.
pub fn nothing_yet(site: &str) -> Bytes {
    let mut out = Vec::new();
    write_head(&mut out, None, site, 0, 0);
    out.extend_from_slice(b"]}");
    out.into()
}

fn write_head(out: &mut Vec<u8>, frame: Option<&Frame>, site: &str, matched: usize, returned: usize) {
    let head = Head {
        r#type: "FeatureCollection",
        time: frame.map(|frame| frame.picture.time.to_string()),
        published_at: frame.map(|frame| frame.published_at.to_string()),
        latency_s: frame.map(|frame| rounded(frame.published_at.seconds_since(frame.picture.time), 3)),
        seq: frame.map_or(0, |frame| frame.seq),
        site,
        matched,
        returned,
    };
    append(out, &head);
    out.pop();
    out.extend_from_slice(b",\"features\":[");
}

fn write_feature(out: &mut Vec<u8>, track: &Track, maker: &PictureMaker, age_s: f64) {
    let id = maker.track_id(track);
    let json = TrackJson::new(track, maker);
    let mut coordinates = vec![json.lng(), json.lat()];
    coordinates.extend(json.alt());
    let geometry = Point { r#type: "Point", coordinates };
    append(
        out,
        &Feature { r#type: "Feature", id: &id, geometry, properties: Properties { track: json, age_s } },
    );
}

/// Appends a value of which every part can be written.
fn append(out: &mut Vec<u8>, value: &impl Serialize) {
    serde_json::to_writer(out, value)
        .expect("texts, numbers and lists are written to memory without failing");
}
