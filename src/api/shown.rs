//! A slot as readers get it: its JSON is made once, and everybody's answer is that or pieces of it.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use axum::body::Bytes;
use schemars::JsonSchema;
use serde::Serialize;

use super::filter::Filter;
use super::geometry::{CollectionType, Feature, Point};
use super::payload::Payload;
use super::piece::Piece;
use super::trails::Trail;
use crate::config::{Config, PictureKind};
use crate::json::rounded;
use crate::live::{Hub, PublishedPicture};
use crate::picture::{Picture, PictureMaker, PictureTrack, Rfc3339, TrackJson};
use fusion::time::Time;

/// A published slot, and its JSON for as long as most readers ask for it.
#[derive(Debug)]
pub struct Shown {
    /// As the engine put it out.
    pub frame: Arc<PublishedPicture>,
    /// The picture that is shown, where it is not the slot's but that of its deadline.
    predicted: Option<Arc<Picture>>,
    /// That one as readers get it, once somebody has asked for it, and while it is remembered.
    now: Mutex<Option<Arc<Self>>>,
    /// All its tracks, in the order of the picture.
    pub pieces: Vec<Piece>,
    config: Arc<Config>,
    maker: Arc<PictureMaker>,
    /// The lines with which its event begins.
    event_head: String,
    written: RwLock<Option<Written>>,
}

/// The JSON of a slot. All of it is in the same octets, unless something is not new.
#[derive(Clone, Debug)]
struct Written {
    octets: Bytes,
    /// Where the feature of each track of the picture stands in them, without competitors.
    features: Arc<[Range<usize>]>,
    /// The feature collection of what readers get who ask for nothing else.
    collection: Payload,
    /// The event of what is new in that.
    event: Payload,
}

/// GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
pub struct Tracks<'a> {
    r#type: CollectionType,
    /// `now`: the picture of the deadline itself, predicted; left out where it is the slot's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [PictureKind::Now.name()]))]
    at: Option<&'static str>,
    /// Of the tracks: the centre of the slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// When the slot was published.
    #[serde(skip_serializing_if = "Option::is_none")]
    published_at: Option<Rfc3339>,
    /// From the opening of the slot to its publication, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_s: Option<f64>,
    seq: u64,
    /// Its configured name.
    site: &'a str,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    /// Where `limit` has left some out: what `after` takes for the next page.
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<&'a str>,
    /// Written one by one, behind all others.
    features: Vec<TrackFeature<'a>>,
}

/// A track: GeoJSON, RFC 7946.
pub type TrackFeature<'a> = Feature<'a, Point, TrackProperties<'a>>;

#[derive(Serialize, JsonSchema)]
pub struct TrackProperties<'a> {
    #[serde(flatten)]
    track: &'a TrackJson<'a>,
    /// From its time to its publication.
    age_s: f64,
    /// With trail_s.
    #[serde(skip_serializing_if = "Option::is_none")]
    trail: Option<&'a Trail>,
}

impl Shown {
    /// Writes the JSON of a slot, and its event, which begins with these lines, with what is new since the slot before.
    pub fn new(frame: &Arc<PublishedPicture>, hub: &Hub, before: Option<&Self>, event_head: String) -> Self {
        let tracks: Vec<(usize, &PictureTrack)> =
            frame.picture.tracks.iter().enumerate().filter(|(_, track)| is_placed(track)).collect();
        let known = Known::of(before, &tracks);
        let piece = |&(index, track): &(usize, &PictureTrack)| {
            Piece::new((index, track), &hub.maker, !known.has(track))
        };
        let shown = Self {
            frame: frame.clone(),
            predicted: None,
            now: Mutex::default(),
            pieces: tracks.iter().map(piece).collect(),
            config: hub.config.clone(),
            maker: hub.maker.clone(),
            event_head,
            written: RwLock::default(),
        };
        shown.write_all();
        shown
    }

    /// This picture of the slot's deadline; `None` where it is not made, or forgotten: it is as old as the JSON of the slot may
    /// become.
    pub fn of(self: &Arc<Self>, kind: PictureKind) -> Option<Arc<Self>> {
        match kind {
            PictureKind::Lagged => Some(self.clone()),
            PictureKind::Now => {
                let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
                if now.is_none() {
                    *now = self.predict().map(Arc::new);
                }
                now.clone()
            }
        }
    }

    fn predict(&self) -> Option<Self> {
        let picture = self.frame.now.get()?;
        let tracks = picture.tracks.iter().enumerate().filter(|(_, track)| is_placed(track));
        let shown = Self {
            pieces: tracks.map(|track| Piece::new(track, &self.maker, true)).collect(),
            frame: self.frame.clone(),
            predicted: Some(picture),
            now: Mutex::default(),
            config: self.config.clone(),
            maker: self.maker.clone(),
            event_head: self.event_head.clone(),
            written: RwLock::default(),
        };
        shown.write_all();
        Some(shown)
    }

    /// The picture that is shown.
    fn picture(&self) -> &Picture {
        self.predicted.as_deref().unwrap_or(&self.frame.picture)
    }

    /// What stands at the head of a collection of its tracks.
    fn head(&self) -> Head<'static> {
        Head {
            at: self.predicted.as_ref().map(|_| PictureKind::Now.name()),
            time: Some(self.time().into()),
            published_at: Some(self.frame.published_at.into()),
            latency_s: Some(self.latency_s()),
            seq: self.frame.seq,
            next: None,
        }
    }

    /// Forgets its JSON, and the picture of its deadline; who still asks for the first has it written once more.
    pub fn forget(&self) {
        *self.written.write().unwrap_or_else(PoisonError::into_inner) = None;
        self.frame.now.forget();
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn written(&self) -> Written {
        let written = self.written.read().unwrap_or_else(PoisonError::into_inner).clone();
        written.unwrap_or_else(|| self.write_all())
    }

    fn write_all(&self) -> Written {
        let usual = self.usual().count();
        let mut out = Vec::with_capacity(512 + FEATURE * self.pieces.len());
        out.extend_from_slice(self.event_head.as_bytes());
        let start = out.len();
        write_head(&mut out, self.head(), &self.config, usual, usual);
        let mut features = vec![0..0; self.picture().tracks.len()];
        let mut write = |out: &mut Vec<u8>, piece: &Piece| {
            let (track, from) = (self.track(piece), out.len());
            write_feature(out, &self.frame, &TrackJson::lean(track, &self.maker), track.time, None);
            features[piece.index] = from..out.len();
        };
        for (index, piece) in self.usual().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            write(&mut out, piece);
        }
        out.extend_from_slice(b"]}");
        let collection = start..out.len();
        out.extend_from_slice(b"\n\n");
        let event = 0..out.len();
        // Behind it what only those get who ask for it.
        let filter = Filter::default();
        self.pieces.iter().filter(|piece| !filter.wants(piece)).for_each(|piece| write(&mut out, piece));
        out.shrink_to_fit();
        let octets = Bytes::from(out);
        let mut written = Written {
            features: features.into(),
            collection: octets.slice(collection).into(),
            event: octets.slice(event).into(),
            octets,
        };
        let keep = |written: &Written| {
            *self.written.write().unwrap_or_else(PoisonError::into_inner) = Some(written.clone());
        };
        keep(&written);
        if self.usual().any(|piece| !piece.is_new) {
            written.event = [self.event_head.as_bytes(), &self.changes(&filter), b"\n\n"].concat().into();
            keep(&written);
        }
        written
    }

    /// The `tracks` event of what is new in it.
    pub fn event(&self) -> Payload {
        self.written().event
    }

    /// The feature collection of what a filter lets through.
    pub fn filtered(&self, filter: &Filter) -> Payload {
        if filter.is_default() { self.written().collection } else { self.join(self.all(), filter).into() }
    }

    /// What readers get who ask for nothing else.
    pub fn usual(&self) -> impl Iterator<Item = &Piece> {
        let usual = Filter::default();
        self.pieces.iter().filter(move |piece| usual.wants(piece))
    }

    /// Its pieces, each with the slot that it is of.
    pub fn all(&self) -> impl Iterator<Item = (&Self, &Piece)> {
        self.pieces.iter().map(move |piece| (self, piece))
    }

    /// The pieces that are new in it, each with the slot that it is of.
    pub fn new_ones(&self) -> impl Iterator<Item = (&Self, &Piece)> {
        self.all().filter(|(_, piece)| piece.is_new)
    }

    /// The GeoJSON feature of a piece of this slot, with competitors or without.
    pub fn feature(&self, piece: &Piece, competitors: bool) -> Bytes {
        let track = self.track(piece);
        let write = |json: &TrackJson<'_>| {
            let mut out = Vec::new();
            write_feature(&mut out, &self.frame, json, track.time, None);
            out.into()
        };
        if competitors && !track.point.competitors.is_empty() {
            return piece.full.get_or_init(|| write(&TrackJson::new(track, &self.maker))).clone();
        }
        let written = self.written.read().unwrap_or_else(PoisonError::into_inner);
        let slice = |written: &Written| written.octets.slice(written.features[piece.index].clone());
        written.as_ref().map_or_else(|| write(&TrackJson::lean(track, &self.maker)), slice)
    }

    /// The feature collection of what a filter lets through and is new.
    pub fn changes(&self, filter: &Filter) -> Bytes {
        self.join(self.new_ones(), filter)
    }

    /// The feature collection of what a filter lets through, each track with its trail.
    pub fn with_trails(&self, filter: &Filter, trails: &HashMap<Arc<str>, Trail>) -> Payload {
        let written = self.write(self.all(), filter, |out, _, piece| {
            let track = self.track(piece);
            let json = if filter.competitors() { TrackJson::new } else { TrackJson::lean };
            write_feature(out, &self.frame, &json(track, &self.maker), track.time, trails.get(&piece.id));
        });
        written.into()
    }

    /// The feature collection, with the head of this slot, of what a filter lets through of pieces of any slots.
    pub fn join<'a>(&self, pieces: impl Iterator<Item = (&'a Self, &'a Piece)>, filter: &Filter) -> Bytes {
        self.write(pieces, filter, |out, shown, piece| {
            out.extend_from_slice(&shown.feature(piece, filter.competitors()));
        })
    }

    fn write<'a>(
        &self,
        pieces: impl Iterator<Item = (&'a Self, &'a Piece)>,
        filter: &Filter,
        mut feature: impl FnMut(&mut Vec<u8>, &Self, &Piece),
    ) -> Bytes {
        let page = filter.page(pieces, |(_, piece)| piece);
        let mut out = Vec::with_capacity(512 + FEATURE * page.tracks.len());
        let head = Head { next: page.next.as_deref(), ..self.head() };
        write_head(&mut out, head, &self.config, page.matched, page.tracks.len());
        for (index, (shown, piece)) in page.tracks.iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            feature(&mut out, shown, piece);
        }
        out.extend_from_slice(b"]}");
        out.into()
    }

    /// The track of a piece.
    pub fn track(&self, piece: &Piece) -> &PictureTrack {
        &self.picture().tracks[piece.index]
    }

    /// When its tracks were there.
    pub fn time(&self) -> Time {
        self.picture().time
    }

    /// From the opening of the slot to its publication, seconds: on time it is the one that the configuration says, and 0 of
    /// the picture of now.
    pub fn latency_s(&self) -> f64 {
        let opened = self.time() + -(self.config.fusion.slot / 2);
        rounded(self.frame.published_at.seconds_since(opened), 3)
    }
}

/// Octets of a feature, about.
const FEATURE: usize = 1024;

/// The tracks of the slot before, where any of them could be as it was. By then a track that says its time anew is new.
struct Known<'a>(HashMap<(&'static str, u32), Vec<&'a PictureTrack>>);

impl<'a> Known<'a> {
    fn of(before: Option<&'a Shown>, tracks: &[(usize, &PictureTrack)]) -> Self {
        let mut known: HashMap<_, Vec<_>> = HashMap::new();
        let before = before.filter(|before| tracks.iter().any(|(_, track)| track.time <= before.time()));
        for track in before.into_iter().flat_map(|before| &before.frame.picture.tracks) {
            known.entry((track.source_name(), track.point.number)).or_default().push(track);
        }
        Self(known)
    }

    fn has(&self, track: &PictureTrack) -> bool {
        self.0.get(&(track.source_name(), track.point.number)).is_some_and(|known| known.contains(&track))
    }
}

/// A place that is no number has no place on a map; the engine gives none, and none is passed on.
fn is_placed(track: &PictureTrack) -> bool {
    track.position.latitude_deg().is_finite() && track.position.longitude_deg().is_finite()
}

/// What a collection says of its slot; of none before the first.
#[derive(Default)]
struct Head<'a> {
    at: Option<&'static str>,
    time: Option<Rfc3339>,
    published_at: Option<Rfc3339>,
    latency_s: Option<f64>,
    seq: u64,
    next: Option<&'a str>,
}

/// The picture before the first slot: nothing.
pub fn nothing_yet(config: &Config, kind: PictureKind) -> Payload {
    let mut out = Vec::new();
    let at = (kind == PictureKind::Now).then(|| kind.name());
    write_head(&mut out, Head { at, ..Head::default() }, config, 0, 0);
    out.extend_from_slice(b"]}");
    out.into()
}

fn write_head(
    out: &mut Vec<u8>,
    Head { at, time, published_at, latency_s, seq, next }: Head<'_>,
    config: &Config,
    matched: usize,
    returned: usize,
) {
    let head = Tracks {
        r#type: CollectionType::default(),
        at,
        time,
        published_at,
        latency_s,
        seq,
        site: &config.site.name,
        matched,
        returned,
        next,
        features: Vec::new(),
    };
    append(out, &head);
    // Open again, for the features.
    out.truncate(out.len() - b"]}".len());
}

/// `time` is the track's.
fn write_feature(
    out: &mut Vec<u8>,
    frame: &PublishedPicture,
    track: &TrackJson<'_>,
    time: Time,
    trail: Option<&Trail>,
) {
    let age_s = rounded(frame.published_at.seconds_since(time), 3);
    let geometry = Point::new(track.lng(), track.lat(), track.alt());
    append(out, &TrackFeature::new(track.id(), geometry, TrackProperties { track, age_s, trail }));
}

/// Appends a value of which every part can be written.
fn append(out: &mut Vec<u8>, value: &impl Serialize) {
    serde_json::to_writer(out, value)
        .expect("texts, numbers and lists are written to memory without failing");
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::areas::Masks;
    use crate::capture::{Capture, Merged};
    use crate::config::Profile;
    use crate::live::Fleeting;
    use crate::pipeline::Pipeline;
    use fusion::point::Basis;

    /// The slots of the demo, the latest last.
    fn slots() -> (Vec<Arc<PublishedPicture>>, Hub) {
        let site = include_str!("../../testdata/demo/site.toml");
        let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        config.fusion.profile = Profile::Operational;
        let config = Arc::new(config);
        let mut pipeline = Pipeline::new(&config, Masks::default());
        let maker = Arc::new(PictureMaker::new(&config, pipeline.normaliser()));
        let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
        let receptions = Merged::new(vec![Capture::open(&capture).unwrap()], jiff::civil::Date::default());
        let mut slots = Vec::new();
        for reception in receptions {
            pipeline.receive(&reception.unwrap());
            slots.extend(pipeline.emissions().map(|emission| {
                let mut picture = maker.picture(emission);
                // Every third is known too poorly for who asks for nothing else.
                for motion in picture.tracks.iter_mut().step_by(3).filter_map(|track| track.motion.as_mut()) {
                    (motion.basis, motion.accuracy_h_m) = (Basis::Extrapolated, 500.0);
                }
                Arc::new(PublishedPicture {
                    seq: 1,
                    due: picture.time,
                    published_at: picture.time,
                    picture,
                    now: Fleeting::default(),
                })
            }));
        }
        let (_, hub) = Hub::new(config, maker, Time::default());
        (slots, hub)
    }

    #[test]
    fn what_is_forgotten_is_written_once_more_as_it_was() {
        let (slots, hub) = slots();
        let mut before: Option<Shown> = None;
        let mut unusual = 0;
        for frame in &slots {
            let shown = Shown::new(frame, &hub, before.as_ref(), format!("id: {}\ndata: ", frame.seq));
            let all = |shown: &Shown| {
                let features: Vec<Bytes> =
                    shown.pieces.iter().map(|piece| shown.feature(piece, false)).collect();
                (features, shown.filtered(&Filter::default()).plain(), shown.event().plain())
            };
            let (features, collection, event) = all(&shown);
            shown.forget();
            let again: Vec<Bytes> = shown.pieces.iter().map(|piece| shown.feature(piece, false)).collect();
            assert_eq!(again, features, "one by one");
            assert_eq!(all(&shown), (features, collection.clone(), event.clone()));
            assert_eq!(collection, shown.join(shown.all(), &Filter::default()));
            let changes = shown.changes(&Filter::default());
            assert_eq!(event, [shown.event_head.as_bytes(), &changes, b"\n\n"].concat());
            unusual += shown.pieces.len() - shown.usual().count();
            before = Some(shown);
        }
        assert!(slots.len() > 100 && unusual > 0, "{unusual} of {} slots", slots.len());
    }
}
