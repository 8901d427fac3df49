//! Drones over a field in which transponders are heard, and beside it.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::pipeline::Pipeline;
use fusion::point::{RadarPart, TransponderPart};
use fusion::report::UasItems;
use fusion::slots::Slot;
use fusion::{Emission, Enu, Point, SensorIndex, Source};

/// Slots of a quarter of a second.
const SLOT_NS: i64 = SECOND / 4;

/// A lookout over a square of about 1 km around the radar, with a mask in its corner.
struct Field {
    lookout: Lookout,
    maker: PictureMaker,
    slot: i64,
    /// The ids that were marked in the latest slot, and who was resolved.
    marked: Vec<String>,
    resolved: Vec<Resolved>,
}

/// Each test has files of its own.
static FIELDS: AtomicUsize = AtomicUsize::new(0);

impl Field {
    fn new() -> Self {
        let own = format!("{}-{}", std::process::id(), FIELDS.fetch_add(1, Ordering::Relaxed));
        let site = include_str!("../../../testdata/demo/site.toml");
        let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        config.fusion.profile = crate::config::Profile::Operational;
        let (_, radar) = config.radars().next().unwrap();
        let (lng, lat) = (radar.longitude_deg, radar.latitude_deg);
        let square = |name: &str, west: f64, south: f64, size: f64| {
            let file = std::env::temp_dir().join(format!("utm-fusion-lookout-{own}-{name}"));
            let (east, north) = (west + size, south + size);
            let ring = format!(
                "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
            );
            std::fs::write(&file, format!("{{\"type\":\"Polygon\",\"coordinates\":[{ring}]}}")).unwrap();
            file
        };
        let receiver = |sensor: &&crate::config::Sensor| sensor.kind.is_transponder();
        let sensor = config.sensors.iter().find(receiver).unwrap().id.clone();
        let area = |kind, file| crate::config::Area { kind, file };
        config.areas = vec![
            area(crate::config::AreaKind::Coverage { sensor }, square("heard", lng - 0.01, lat - 0.01, 0.02)),
            area(crate::config::AreaKind::Mask, square("mask", lng + 0.005, lat + 0.005, 0.01)),
        ];
        let pipeline = Pipeline::new(&config, Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let areas = Areas::load(&config.areas).unwrap();
        let lookout = Lookout::new(&config, &areas);
        assert_eq!(lookout.heard, HeardAreas::load(&config).unwrap());
        config.areas.iter().for_each(|area| std::fs::remove_file(&area.file).unwrap());
        Self { lookout, maker, slot: 0, marked: Vec::new(), resolved: Vec::new() }
    }

    /// So many slots with these points.
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
                concerns: Vec::new(),
            });
            self.lookout.look(&mut picture, &self.maker);
            let marked = picture.tracks.iter().filter(|track| track.is_uncooperative);
            self.marked = marked.map(|track| self.maker.track_id(track)).collect();
            self.resolved.extend(picture.resolved);
        }
        &self.marked
    }
}

/// A drone that radar alone sees, metres east and north of the radar, and that nothing explains.
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
fn fifteen_seconds_in_the_coverage_of_a_receiver_are_enough_and_less_is_not() {
    let mut field = Field::new();
    assert_eq!(field.pass(59, &[drone(7, 0.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1);
    // From then on wherever it is, and while it can be explained.
    let elsewhere = Point { is_unexplained: false, ..drone(7, 5000.0, 0.0) };
    assert_eq!(field.pass(100, &[elsewhere]).len(), 1);
    assert_eq!(field.resolved, []);
}

#[test]
fn a_restart_begins_no_one_s_time_anew() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    assert_eq!(field.pass(30, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 1);
    let written = field.lookout.checkpoint();
    let mut again = Field::new();
    assert!(again.lookout.go_on(&written) && !again.lookout.go_on(&written[..written.len() - 1]));
    again.slot = field.slot;
    assert_eq!(again.pass(29, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 1);
    assert_eq!(again.pass(1, &[drone(7, 0.0, 0.0), drone(8, 90.0, 0.0)]).len(), 2);
}

#[test]
fn outside_it_in_a_mask_and_explained_nobody_is_uncooperative() {
    let mut field = Field::new();
    let explained = Point { is_unexplained: false, ..drone(9, 0.0, 0.0) };
    assert_eq!(field.pass(400, &[drone(7, 3000.0, 0.0), drone(8, 500.0, 700.0), explained]).len(), 0);
    // Time inside adds up.
    assert_eq!(field.pass(40, &[drone(7, 0.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(20, &[drone(7, 3000.0, 0.0)]).len(), 0);
    assert_eq!(field.pass(20, &[drone(7, 0.0, 0.0)]).len(), 1);
}

#[test]
fn it_is_resolved_when_an_identity_joins_it() {
    for joined in [7, 70_000] {
        let mut field = Field::new();
        field.pass(60, &[drone(7, 0.0, 0.0)]);
        let radar = drone(7, 0.0, 0.0).source.radar().copied().unwrap();
        let pair = fusion::point::Association {
            distance_m: 0.0,
            because: fusion::point::Because::Likelihood { score: 9.0 },
        };
        let source = Source::Fused(radar, transponder(joined), pair);
        let known = Point { number: joined, source, is_unexplained: false, ..drone(7, 0.0, 0.0) };
        assert_eq!(field.pass(1, &[known]).len(), 0);
        let identity = Some(transponder(joined).identity);
        assert_eq!(field.resolved, [Resolved { id: "R-halfmoon-7-0".to_owned(), identity }]);
        // It begins anew when the transponder is gone.
        assert_eq!(field.pass(59, &[drone(7, 0.0, 0.0)]).len(), 0);
        assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1);
    }
}

#[test]
fn the_twin_of_a_transponder_that_lies_is_none() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    let liar = Point { source: Source::Transponder(transponder(70_000)), ..drone(70_000, 100.0, 0.0) };
    let twin = Point { disputed: vec![70_000], is_unexplained: false, ..drone(7, 0.0, 0.0) };
    assert_eq!(field.pass(1, &[liar, twin]).len(), 0);
    assert_eq!(field.resolved.iter().map(|resolved| resolved.identity).collect::<Vec<_>>(), [None]);
}

#[test]
fn what_has_ended_is_forgotten() {
    let mut field = Field::new();
    field.pass(60, &[drone(7, 0.0, 0.0)]);
    field.pass(199, &[]);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 1, "a gap of fifty seconds");
    field.pass(202, &[]);
    assert_eq!(field.pass(1, &[drone(7, 0.0, 0.0)]).len(), 0);
}
