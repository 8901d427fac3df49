//! A slot with its JSON, which is made once and shared by all answers.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use axum::body::Bytes;
use schemars::JsonSchema;
use serde::Serialize;

use super::filter::TrackFilter;
use super::geometry::{CollectionType, Feature, Point};
use super::payload::Payload;
use super::track_slice::TrackSlice;
use super::trails::RecentTrail;
use fusion::time::Time;
use input::json::rounded;
use picture::{Picture, PictureMaker, PictureTrack, Rfc3339, TrackJson};
use service::live::{Hub, PublishedPicture};
use site::config::{Config, PictureKind};

/// A published slot, with its JSON for as long as most readers need it.
#[derive(Debug)]
pub struct SlotJson {
    /// Output of the engine.
    pub frame: Arc<PublishedPicture>,
    /// Picture to show, if it is the predicted one of the slot's deadline instead of the slot's own.
    predicted: Option<Arc<Picture>>,
    /// The predicted picture, made on the first request and kept for a while.
    now: Mutex<Option<Arc<Self>>>,
    /// All tracks, in the order of the picture.
    pub slices: Vec<TrackSlice>,
    config: Arc<Config>,
    maker: Arc<PictureMaker>,
    /// First lines of the event of this slot.
    event_head: String,
    encoded: RwLock<Option<EncodedSlot>>,
}

/// JSON of a slot. Collection and event share the same octets, unless some tracks are not new.
#[derive(Clone, Debug)]
struct EncodedSlot {
    octets: Bytes,
    /// Position of each track's feature in these octets, without competitors.
    features: Arc<[Range<usize>]>,
    /// Feature collection of the default selection.
    collection: Payload,
    /// Event with the new tracks of that collection.
    event: Payload,
}

/// Tracks as GeoJSON, RFC 7946.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Tracks")]
pub struct TrackCollection<'a> {
    r#type: CollectionType,
    /// `now` for the predicted picture of the deadline; left out for the picture of the slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = [PictureKind::Now.name()]))]
    at: Option<&'static str>,
    /// Time of the tracks: the centre of the slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Time of publication of the slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    published_at: Option<Rfc3339>,
    /// Time from the start of the slot to its publication, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_s: Option<f64>,
    seq: u64,
    /// Configured name of the site.
    site: &'a str,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    /// Value of `after` for the next page, if `limit` has left out some tracks.
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<&'a str>,
    /// Tracks, after all other members.
    features: Vec<TrackFeature<'a>>,
}

/// A track as a GeoJSON feature, RFC 7946.
pub type TrackFeature<'a> = Feature<'a, Point, TrackProperties<'a>>;

#[derive(Serialize, JsonSchema)]
pub struct TrackProperties<'a> {
    #[serde(flatten)]
    track: &'a TrackJson<'a>,
    /// Time from the track's time to its publication, in seconds.
    age_s: f64,
    /// Recent trail; with the parameter `trail_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    trail: Option<&'a RecentTrail>,
}

impl SlotJson {
    /// Makes the JSON of a slot, and its event, which starts with `event_head` and has the tracks that changed since `before`.
    pub fn new(frame: &Arc<PublishedPicture>, hub: &Hub, before: Option<&Self>, event_head: String) -> Self {
        let tracks: Vec<(usize, &PictureTrack)> =
            frame.picture.tracks.iter().enumerate().filter(|(_, track)| is_placed(track)).collect();
        let previous = PreviousTracks::of(before, &tracks);
        let slice = |&(index, track): &(usize, &PictureTrack)| {
            TrackSlice::new((index, track), &hub.maker, !previous.has(track))
        };
        let slot = Self {
            frame: frame.clone(),
            predicted: None,
            now: Mutex::default(),
            slices: tracks.iter().map(slice).collect(),
            config: hub.config.clone(),
            maker: hub.maker.clone(),
            event_head,
            encoded: RwLock::default(),
        };
        slot.encode();
        slot
    }

    /// Picture `kind` of the slot's deadline. `None` if it is not made, or is no longer kept; it is kept as long as the JSON of
    /// the slot.
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
        let slot = Self {
            slices: tracks.map(|track| TrackSlice::new(track, &self.maker, true)).collect(),
            frame: self.frame.clone(),
            predicted: Some(picture),
            now: Mutex::default(),
            config: self.config.clone(),
            maker: self.maker.clone(),
            event_head: self.event_head.clone(),
            encoded: RwLock::default(),
        };
        slot.encode();
        Some(slot)
    }

    /// Picture to show.
    fn picture(&self) -> &Picture {
        self.predicted.as_deref().unwrap_or(&self.frame.picture)
    }

    /// Head of a collection of tracks of this slot.
    fn head(&self) -> CollectionHead<'static> {
        CollectionHead {
            at: self.predicted.as_ref().map(|_| PictureKind::Now.name()),
            time: Some(self.time().into()),
            published_at: Some(self.frame.published_at.into()),
            latency_s: Some(self.latency_s()),
            seq: self.frame.seq,
            next: None,
        }
    }

    /// Drops the JSON and the predicted picture. A later request makes the JSON again.
    pub fn discard_json(&self) {
        *self.encoded.write().unwrap_or_else(PoisonError::into_inner) = None;
        self.frame.now.forget();
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn encoded(&self) -> EncodedSlot {
        let encoded = self.encoded.read().unwrap_or_else(PoisonError::into_inner).clone();
        encoded.unwrap_or_else(|| self.encode())
    }

    fn encode(&self) -> EncodedSlot {
        let default_tracks = self.default_tracks().count();
        let mut out = Vec::with_capacity(512 + FEATURE * self.slices.len());
        out.extend_from_slice(self.event_head.as_bytes());
        let start = out.len();
        write_head(&mut out, self.head(), &self.config, default_tracks, default_tracks);
        let mut features = vec![0..0; self.picture().tracks.len()];
        let mut write = |out: &mut Vec<u8>, slice: &TrackSlice| {
            let (track, from) = (self.track(slice), out.len());
            write_feature(
                out,
                &self.frame,
                &TrackJson::lean(track, &self.maker).named(track),
                track.time,
                None,
            );
            features[slice.index] = from..out.len();
        };
        for (index, slice) in self.default_tracks().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            write(&mut out, slice);
        }
        out.extend_from_slice(b"]}");
        let collection = start..out.len();
        out.extend_from_slice(b"\n\n");
        let event = 0..out.len();
        // Tracks outside the default selection follow behind it.
        let filter = TrackFilter::default();
        self.slices.iter().filter(|slice| !filter.wants(slice)).for_each(|slice| write(&mut out, slice));
        out.shrink_to_fit();
        let octets = Bytes::from(out);
        let mut encoded = EncodedSlot {
            features: features.into(),
            collection: octets.slice(collection).into(),
            event: octets.slice(event).into(),
            octets,
        };
        let keep = |encoded: &EncodedSlot| {
            *self.encoded.write().unwrap_or_else(PoisonError::into_inner) = Some(encoded.clone());
        };
        keep(&encoded);
        if self.default_tracks().any(|slice| !slice.is_new) {
            encoded.event = [self.event_head.as_bytes(), &self.changes(&filter), b"\n\n"].concat().into();
            keep(&encoded);
        }
        encoded
    }

    /// The `tracks` event with the changes of this slot.
    pub fn event(&self) -> Payload {
        self.encoded().event
    }

    /// Feature collection of the tracks selected by a filter.
    pub fn filtered(&self, filter: &TrackFilter) -> Payload {
        if filter.is_default() { self.encoded().collection } else { self.join(self.all(), filter).into() }
    }

    /// Tracks of the default selection.
    pub fn default_tracks(&self) -> impl Iterator<Item = &TrackSlice> {
        let default_tracks = TrackFilter::default();
        self.slices.iter().filter(move |slice| default_tracks.wants(slice))
    }

    /// All tracks, each with its slot.
    pub fn all(&self) -> impl Iterator<Item = (&Self, &TrackSlice)> {
        self.slices.iter().map(move |slice| (self, slice))
    }

    /// Tracks that changed in this slot, each with its slot.
    pub fn changed_tracks(&self) -> impl Iterator<Item = (&Self, &TrackSlice)> {
        self.all().filter(|(_, slice)| slice.is_new)
    }

    /// GeoJSON feature of a track of this slot, with or without competitors.
    pub fn feature(&self, slice: &TrackSlice, competitors: bool) -> Bytes {
        let track = self.track(slice);
        let write = |json: &TrackJson<'_>| {
            let mut out = Vec::new();
            write_feature(&mut out, &self.frame, json, track.time, None);
            out.into()
        };
        if competitors && !track.point.competitors.is_empty() {
            return slice
                .full
                .get_or_init(|| write(&TrackJson::new(track, &self.maker).named(track)))
                .clone();
        }
        let encoded = self.encoded.read().unwrap_or_else(PoisonError::into_inner);
        let cut = |encoded: &EncodedSlot| encoded.octets.slice(encoded.features[slice.index].clone());
        encoded.as_ref().map_or_else(|| write(&TrackJson::lean(track, &self.maker).named(track)), cut)
    }

    /// Feature collection of the changed tracks selected by a filter.
    pub fn changes(&self, filter: &TrackFilter) -> Bytes {
        self.join(self.changed_tracks(), filter)
    }

    /// Feature collection of the tracks selected by a filter, each with its trail.
    pub fn with_trails(&self, filter: &TrackFilter, trails: &HashMap<Arc<str>, RecentTrail>) -> Payload {
        let encoded = self.write(self.all(), filter, |out, _, slice| {
            let track = self.track(slice);
            let json = if filter.competitors() { TrackJson::new } else { TrackJson::lean };
            write_feature(
                out,
                &self.frame,
                &json(track, &self.maker).named(track),
                track.time,
                trails.get(&slice.id),
            );
        });
        encoded.into()
    }

    /// Feature collection, with the head of this slot, of selected tracks of any slots.
    pub fn join<'a>(
        &self,
        slices: impl Iterator<Item = (&'a Self, &'a TrackSlice)>,
        filter: &TrackFilter,
    ) -> Bytes {
        self.write(slices, filter, |out, slot, slice| {
            out.extend_from_slice(&slot.feature(slice, filter.competitors()));
        })
    }

    fn write<'a>(
        &self,
        slices: impl Iterator<Item = (&'a Self, &'a TrackSlice)>,
        filter: &TrackFilter,
        mut feature: impl FnMut(&mut Vec<u8>, &Self, &TrackSlice),
    ) -> Bytes {
        let page = filter.page(slices, |(_, slice)| slice);
        let mut out = Vec::with_capacity(512 + FEATURE * page.tracks.len());
        let head = CollectionHead { next: page.next.as_deref(), ..self.head() };
        write_head(&mut out, head, &self.config, page.matched, page.tracks.len());
        for (index, (slot, slice)) in page.tracks.iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            feature(&mut out, slot, slice);
        }
        out.extend_from_slice(b"]}");
        out.into()
    }

    /// Track of a slice.
    pub fn track(&self, slice: &TrackSlice) -> &PictureTrack {
        &self.picture().tracks[slice.index]
    }

    /// Time of the tracks.
    pub fn time(&self) -> Time {
        self.picture().time
    }

    /// Time from the start of the slot to its publication, in seconds: the configured latency if on time, and 0 for the picture
    /// "now".
    pub fn latency_s(&self) -> f64 {
        let opened = self.time() + -(self.config.fusion.slot / 2);
        rounded(self.frame.published_at.seconds_since(opened), 3)
    }
}

/// Approximate length of a feature, in octets.
const FEATURE: usize = 1024;

/// Tracks of the previous slot, to find unchanged ones. A track that reports its time again counts as new.
struct PreviousTracks<'a>(HashMap<(&'static str, u32), Vec<&'a PictureTrack>>);

impl<'a> PreviousTracks<'a> {
    fn of(before: Option<&'a SlotJson>, tracks: &[(usize, &PictureTrack)]) -> Self {
        let mut previous: HashMap<_, Vec<_>> = HashMap::new();
        let before = before.filter(|before| tracks.iter().any(|(_, track)| track.time <= before.time()));
        for track in before.into_iter().flat_map(|before| &before.frame.picture.tracks) {
            previous.entry((track.source_name(), track.point.number)).or_default().push(track);
        }
        Self(previous)
    }

    fn has(&self, track: &PictureTrack) -> bool {
        self.0
            .get(&(track.source_name(), track.point.number))
            .is_some_and(|previous| previous.contains(&track))
    }
}

/// Whether the position is finite, so that it can be shown on a map. The engine publishes no other.
fn is_placed(track: &PictureTrack) -> bool {
    track.position.latitude_deg().is_finite() && track.position.longitude_deg().is_finite()
}

/// Head of a collection; empty before the first slot.
#[derive(Default)]
struct CollectionHead<'a> {
    at: Option<&'static str>,
    time: Option<Rfc3339>,
    published_at: Option<Rfc3339>,
    latency_s: Option<f64>,
    seq: u64,
    next: Option<&'a str>,
}

/// Empty picture, before the first slot.
pub fn empty_collection(config: &Config, kind: PictureKind) -> Payload {
    let mut out = Vec::new();
    let at = (kind == PictureKind::Now).then(|| kind.name());
    write_head(&mut out, CollectionHead { at, ..CollectionHead::default() }, config, 0, 0);
    out.extend_from_slice(b"]}");
    out.into()
}

fn write_head(
    out: &mut Vec<u8>,
    CollectionHead { at, time, published_at, latency_s, seq, next }: CollectionHead<'_>,
    config: &Config,
    matched: usize,
    returned: usize,
) {
    let head = TrackCollection {
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
    // Reopens the object to append the features.
    out.truncate(out.len() - b"]}".len());
}

/// Writes the feature of a track; `time` is the time of the track.
fn write_feature(
    out: &mut Vec<u8>,
    frame: &PublishedPicture,
    track: &TrackJson<'_>,
    time: Time,
    trail: Option<&RecentTrail>,
) {
    let age_s = rounded(frame.published_at.seconds_since(time), 3);
    let geometry = Point::new(track.lng(), track.lat(), track.alt());
    append(out, &TrackFeature::new(track.id(), geometry, TrackProperties { track, age_s, trail }));
}

/// Appends a value that can always be written.
fn append(out: &mut Vec<u8>, value: &impl Serialize) {
    serde_json::to_writer(out, value)
        .expect("texts, numbers and lists are written to memory without failing");
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use fusion::point::Basis;
    use input::capture::{Capture, MergedCaptures};
    use input::pipeline::Pipeline;
    use service::live::PresentPicture;
    use site::areas::Masks;
    use site::config::Profile;

    /// Slots of the demo, the latest last.
    fn slots() -> (Vec<Arc<PublishedPicture>>, Hub) {
        let site = include_str!("../../../testdata/demo/site.toml");
        let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        config.fusion.profile = Profile::Operational;
        let config = Arc::new(config);
        let mut pipeline = Pipeline::new(&config, Masks::default());
        let maker = Arc::new(PictureMaker::new(&config, pipeline.normaliser()));
        let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/demo/capture.pcap");
        let receptions =
            MergedCaptures::new(vec![Capture::open(&capture).unwrap()], jiff::civil::Date::default());
        let mut slots = Vec::new();
        for reception in receptions {
            pipeline.receive(&reception.unwrap());
            slots.extend(pipeline.emissions().map(|emission| {
                let mut picture = maker.picture(emission);
                // Every third track is too inaccurate for the default selection.
                for motion in picture.tracks.iter_mut().step_by(3).filter_map(|track| track.motion.as_mut()) {
                    (motion.basis, motion.accuracy_h_m) = (Basis::Extrapolated, 500.0);
                }
                Arc::new(PublishedPicture {
                    seq: 1,
                    due: picture.time,
                    published_at: picture.time,
                    picture,
                    now: PresentPicture::default(),
                })
            }));
        }
        let (_, hub) = Hub::new(config, maker, Time::default());
        (slots, hub)
    }

    #[test]
    fn discarded_json_is_encoded_again_unchanged() {
        let (slots, hub) = slots();
        let mut before: Option<SlotJson> = None;
        let mut unusual = 0;
        for frame in &slots {
            let slot = SlotJson::new(frame, &hub, before.as_ref(), format!("id: {}\ndata: ", frame.seq));
            let all = |slot: &SlotJson| {
                let features: Vec<Bytes> =
                    slot.slices.iter().map(|slice| slot.feature(slice, false)).collect();
                (features, slot.filtered(&TrackFilter::default()).plain(), slot.event().plain())
            };
            let (features, collection, event) = all(&slot);
            slot.discard_json();
            let again: Vec<Bytes> = slot.slices.iter().map(|slice| slot.feature(slice, false)).collect();
            assert_eq!(again, features, "one by one");
            assert_eq!(all(&slot), (features, collection.clone(), event.clone()));
            assert_eq!(collection, slot.join(slot.all(), &TrackFilter::default()));
            let changes = slot.changes(&TrackFilter::default());
            assert_eq!(event, [slot.event_head.as_bytes(), &changes, b"\n\n"].concat());
            unusual += slot.slices.len() - slot.default_tracks().count();
            before = Some(slot);
        }
        assert!(slots.len() > 100 && unusual > 0, "{unusual} of {} slots", slots.len());
    }
}
