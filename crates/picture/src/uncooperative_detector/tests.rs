//! Drones inside and outside of an area where transponders are received.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use fusion::point::{RadarPart, TransponderPart};
use fusion::report::UasItems;
use fusion::slots::Slot;
use fusion::{Emission, Enu, Point, SensorIndex, Source};
use input::pipeline::Pipeline;

/// Length of a slot: a quarter of a second.
const SLOT_NS: i64 = SECOND / 4;

/// A detector for a square of about 1 km around the radar, with a mask in its corner.
struct Field {
    detector: UncooperativeDetector,
    maker: PictureMaker,
    slot: i64,
    /// Ids that were marked in the latest slot, and those resolved.
    marked: Vec<String>,
    resolved: Vec<Resolved>,
}

/// Number of tests with files of their own.
static FIELDS: AtomicUsize = AtomicUsize::new(0);

impl Field {
    fn new() -> Self {
        let own = format!("{}-{}", std::process::id(), FIELDS.fetch_add(1, Ordering::Relaxed));
        let site = include_str!("../../../../testdata/demo/site.toml");
        let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        config.fusion.profile = site::config::Profile::Operational;
        let (_, radar) = config.radars().next().unwrap();
        let (lng, lat) = (radar.longitude_deg, radar.latitude_deg);
        let square = |name: &str, west: f64, south: f64, size: f64| {
            let file = std::env::temp_dir().join(format!("utm-fusion-uncooperative-{own}-{name}"));
            let (east, north) = (west + size, south + size);
            let ring = format!(
                "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
            );
            std::fs::write(&file, format!("{{\"type\":\"Polygon\",\"coordinates\":[{ring}]}}")).unwrap();
            file
        };
        let receiver = |sensor: &&site::config::Sensor| sensor.kind.is_transponder();
        let sensor = config.sensors.iter().find(receiver).unwrap().id.clone();
        let area = |kind, file| site::config::Area { kind, file };
        config.areas = vec![
            area(site::config::AreaKind::Coverage { sensor }, square("heard", lng - 0.01, lat - 0.01, 0.02)),
            area(site::config::AreaKind::Mask, square("mask", lng + 0.005, lat + 0.005, 0.01)),
        ];
        let pipeline = Pipeline::new(&config, Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let areas = Areas::load(&config.areas).unwrap();
        let detector = UncooperativeDetector::new(&config, &areas);
        assert_eq!(detector.heard, HeardAreas::load(&config).unwrap());
        config.areas.iter().for_each(|area| std::fs::remove_file(&area.file).unwrap());
        Self { detector, maker, slot: 0, marked: Vec::new(), resolved: Vec::new() }
    }

    /// Processes this number of slots with the same points.
    fn pass(&mut self, slots: i64, points: &[Point]) -> &[String] {
        for _ in 0..slots {
            self.slot += 1;
            let mut picture = self.maker.picture(Emission {
                now: None,
                slot: Slot(self.slot),
                time: Time::from_nanos(self.slot * SLOT_NS),
                points: points.to_vec(),
                numbers: Vec::new(),
                newcomers: Vec::new(),
                jumping: Vec::new(),
                concerns: Vec::new(),
            });
            self.detector.look(&mut picture, &self.maker);
            let marked = picture.tracks.iter().filter(|track| track.is_uncooperative);
            self.marked = marked.map(|track| self.maker.track_id(track)).collect();
            self.resolved.extend(picture.resolved);
        }
        &self.marked
    }
}

/// A drone seen by radar only and without an explanation; position in metres east and north of the radar.
fn drone(number: u32, east_m: f64, north_m: f64) -> Point {
    let track = RadarTrackKey { sensor: SensorIndex(0), number: number as u16 };
    let part = RadarPart { track, time: Time::default(), height_measured: true, uav_probability: Some(0.9) };
    Point {
        is_unexplained: true,
        ..Point::new(number, Enu::new(east_m, north_m, 50.0), Time::default(), Source::Radar(part))
    }
}

fn transponder(number: u32) -> TransponderPart {
    TransponderPart {
        identity: Identity::new(b"ALPHA       ", None).unwrap(),
        number,
        sensor: SensorIndex(1),
        time: None,
        items: UasItems { serial_number: *b"ALPHA       ", ..UasItems::default() },
        aircraft: Default::default(),
        height_measured: true,
    }
}

#[test]
fn track_is_uncooperative_after_15_s_in_coverage() {
    let mut field = Field::new();
    assert_eq!(field.pass(59, &[drone(7, 0.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1);
    // From then on it stays uncooperative outside of the coverage and with an explanation.
    let elsewhere = Point { is_unexplained: false, ..drone(7, 5000.0, 0.0) };
    assert_eq!(field.pass(100, &[elsewhere]).len(), 1);
    assert_eq!(field.resolved, []);
}

#[test]
fn restart_keeps_the_time_in_coverage() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    assert_eq!(field.pass(30, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 1);
    let written = field.detector.checkpoint();
    let mut again = Field::new();
    assert!(again.detector.restore(&written) && !again.detector.restore(&written[..written.len() - 1]));
    again.slot = field.slot;
    assert_eq!(again.pass(29, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 1);
    assert_eq!(again.pass(1, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 2);
}

#[test]
fn uncovered_masked_or_explained_track_is_not_flagged() {
    let mut field = Field::new();
    let explained = Point { is_unexplained: false, ..drone(9, 0.0, 0.0) };
    assert_eq!(field.pass(400, &[drone(7, 3000.0, 0.0), drone(8, 500.0, 700.0), explained]).len(), 0);
    // Time inside the coverage adds up.
    assert_eq!(field.pass(40, &[drone(7, 0.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(20, &[drone(7, 3000.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(20, &[drone(7, 0.0, 0.0)]).len(), 1);
}

#[test]
fn flag_is_resolved_when_a_transponder_is_associated() {
    for joined in [7, 70_000] {
        let mut field = Field::new();
        field.pass(60, &[drone(7, 0.0, 0.0)]);
        let radar = drone(7, 0.0, 0.0).source.radar().copied().unwrap();
        let pair = fusion::point::Association {
            distance_m: 0.0,
            because: fusion::point::AssociationEvidence::Likelihood { score: 9.0 },
        };
        let source = Source::Fused(radar, transponder(joined), pair);
        let known = Point { number: joined, source, is_unexplained: false, ..drone(7, 0.0, 0.0) };
        assert_eq!(field.pass(1, &[known]).len(), 0);
        let identity = Some(transponder(joined).identity);
        assert_eq!(field.resolved, [Resolved { id: "R-halfmoon-7-0".to_owned(), identity }]);
        // Counting starts again after the transponder has disappeared.
        assert_eq!(field.pass(59, &[drone(7, 0.0, 0.0)]).len(), 0);
        assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1);
    }
}

#[test]
fn twin_of_a_false_position_is_not_flagged() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    let liar = Point { source: Source::Transponder(transponder(70_000)), ..drone(70_000, 100.0, 0.0) };
    let twin = Point { disputed: vec![70_000], is_unexplained: false, ..drone(7, 0.0, 0.0) };
    assert_eq!(field.pass(1, &[liar, twin]).len(), 0);
    assert_eq!(field.resolved.iter().map(|resolved| resolved.identity).collect::<Vec<_>>(), [None]);
}

#[test]
fn ended_track_is_forgotten() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    field.pass(199, &[]);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1, "a gap of fifty seconds");
    field.pass(202, &[]);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 0);
}
