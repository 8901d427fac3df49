//! Tests that every track gives a valid event.

use nalgebra::{Matrix2, Vector3};
use proptest::prelude::*;

use super::*;
use fusion::integrity::PointIntegrity;
use fusion::point::{Association, AssociationEvidence, Basis, Estimate, RadarPart, TransponderPart};
use fusion::report::{Aircraft, AircraftKind, UasItems};
use fusion::slots::Slot;
use fusion::{Emission, Enu, Identity, Point, RadarTrackKey, SensorIndex, Source};
use input::normalise::Normaliser;
use site::areas::Masks;
use site::config::Config;

const SITE: &str = "[site]\nname = \"<North> & \\\"West\\\"\"\nsac = 25\nsic = 1\n\n[[sensors]]\nid = \"radar\"\nkind = \"radar\"\n\
                    sac = 25\nsic = 200\nlatitude_deg = 52.0\nlongitude_deg = -0.5\nheight_amsl_m = 90.0\n\n[[sensors]]\n\
                    id = \"receiver\"\nkind = \"transponder\"\nsac = 25\nsic = 201\n\n[conflicts]\ncrewed = [\"PILOT\"]\n";

const SECOND: CotSecond =
    CotSecond { due: Time::from_nanos(1_763_000_006_250_000_000), is_predicted: false, is_degraded: false };

fn site() -> (Config, PictureMaker) {
    let config = Config::parse(SITE, "site.toml", std::iter::empty()).unwrap();
    let maker = PictureMaker::new(&config, &Normaliser::new(&config, Masks::default()));
    (config, maker)
}

fn writer() -> CotWriter {
    CotWriter { site: site().0.site.name, stale: SignedDuration::from_secs(5) }
}

/// Source of a track: a radar, a transponder with this serial, or both.
fn source(radar: Option<Option<f64>>, serial: Option<&[u8; 12]>) -> Source {
    let time = Time::from_nanos(1_763_000_000_000_000_000);
    let radar = radar.map(|uav_probability| RadarPart {
        track: RadarTrackKey { sensor: SensorIndex(0), number: 7 },
        time,
        height_measured: true,
        uav_probability,
    });
    let identity = serial.and_then(|serial| Identity::new(serial, None));
    let transponder = identity.map(|identity| TransponderPart {
        number: 3,
        identity,
        sensor: SensorIndex(1),
        time: Some(time),
        items: UasItems::default(),
        aircraft: Aircraft::default(),
        height_measured: true,
    });
    let because = Association { distance_m: 3.0, because: AssociationEvidence::Likelihood { score: 12.0 } };
    match (radar, transponder) {
        (Some(radar), Some(transponder)) => Source::Fused(radar, transponder, because),
        (None, Some(transponder)) => Source::Transponder(transponder),
        (Some(radar), None) => Source::Radar(radar),
        (None, None) => panic!("of nobody"),
    }
}

/// A track 1 km east of the site, 100 m up, flying east.
fn track(source: Source, speed: Option<f64>) -> PictureTrack {
    let time = Time::from_nanos(1_763_000_000_125_000_000);
    let estimate = speed.map(|speed| Estimate {
        velocity: Vector3::new(speed, 0.0, 1.0),
        horizontal: Matrix2::identity() * 16.0,
        vertical_m2: 9.0,
        velocity_covariance: Matrix2::identity() * 0.04,
        position_velocity: Matrix2::zeros(),
        height_climb: 0.0,
        climb_m2s2: 1.0,
        lie_m2: 0.0,
        basis: Basis::Measured,
        last_measurement: Some(time),
    });
    let point = Point { estimate, ..Point::new(10_007, Enu::new(1000.0, 0.0, 100.0), time, source) };
    let emission = Emission {
        slot: Slot(0),
        time,
        points: vec![point],
        numbers: Vec::new(),
        newcomers: Vec::new(),
        jumping: Vec::new(),
        concerns: Vec::new(),
        now: None,
    };
    site().1.picture(emission).tracks.remove(0)
}

fn doubted(track: &mut PictureTrack, state: State) {
    track.point.integrity = Some(PointIntegrity {
        state,
        index: 9.0,
        protection_level_m: None,
        offset_m: Some(400.0),
        reasons: [Reason::Radar, Reason::Jump].into_iter().collect(),
    });
}

/// Fields of an event as read by an XML parser.
struct Seen {
    text: String,
}

impl Seen {
    fn of(track: &PictureTrack) -> Self {
        Self { text: writer().event(track, &site().1, SECOND).unwrap() }
    }

    fn attribute(&self, element: &str, name: &str) -> Option<String> {
        let document = roxmltree::Document::parse(&self.text).unwrap();
        let node = document.descendants().find(|node| node.has_tag_name(element))?;
        Some(node.attribute(name)?.to_owned())
    }

    fn text_of(&self, element: &str) -> String {
        let document = roxmltree::Document::parse(&self.text).unwrap();
        let node = document.descendants().find(|node| node.has_tag_name(element)).unwrap();
        node.text().unwrap_or_default().to_owned()
    }

    fn event(&self, name: &str) -> String {
        self.attribute("event", name).unwrap()
    }
}

/// 1 km east is 1000 m / (6,391.9 km cos 52°) in longitude, 0.1 m south of the parallel, and 8 cm above the plane.
#[test]
fn fused_drone_is_encoded_octet_by_octet() {
    let track = track(source(Some(Some(0.9)), Some(b"DRONE-1     ")), Some(12.5));
    let wanted = concat!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
        "<event version=\"2.0\" uid=\"&lt;North&gt; &amp; &quot;West&quot;.U-10007\" type=\"a-n-A-M-H-Q\" how=\"m-f\" ",
        "time=\"2025-11-13T02:13:26.250Z\" start=\"2025-11-13T02:13:20.125Z\" stale=\"2025-11-13T02:13:31.250Z\">",
        "<point lat=\"51.9999991\" lon=\"-0.4854398\" hae=\"237.1\" ce=\"4.0\" le=\"3.0\"/>",
        "<detail><contact callsign=\"DRONE-1\"/><track course=\"90.0\" speed=\"12.50\"/>",
        "<remarks>Fused from radar and transponder. 95 % within 10 m.</remarks></detail></event>\n",
    );
    assert_eq!(writer().event(&track, &site().1, SECOND).unwrap(), wanted);
}

#[test]
fn type_and_how_state_class_and_position_source() {
    for (source, kind, how) in [
        (source(Some(Some(0.9)), Some(b"DRONE-1     ")), "a-n-A-M-H-Q", "m-f"),
        (source(None, Some(b"DRONE-1     ")), "a-n-A-M-H-Q", "m-g"),
        (source(None, Some(b"PILOT       ")), "a-n-A-C", "m-g"),
        (source(Some(Some(0.9)), None), "a-u-A-M-H-Q", "m-r"),
        (source(Some(Some(0.1)), None), "a-u-A", "m-r"),
        (source(Some(None), None), "a-u-A", "m-r"),
    ] {
        let track = track(source, Some(10.0));
        let seen = Seen::of(&track);
        assert_eq!((&*seen.event("type"), &*seen.event("how")), (kind, how));
        let predicted = CotSecond { is_predicted: true, ..SECOND };
        let seen = Seen { text: writer().event(&track, &site().1, predicted).unwrap() };
        assert_eq!(seen.event("how"), "m-p");
        assert!(seen.text_of("remarks").contains("Predicted"), "{}", seen.text);
    }
}

#[test]
fn adsb_identity_and_altitude_are_shown() {
    let said = |kind, emitter_category| {
        let mut flown = track(source(None, Some(b"DRONE-1     ")), Some(60.0));
        if let Source::Transponder(part) = &mut flown.point.source {
            part.identity = Identity::of_address(0x4B_1A_2C);
            part.aircraft =
                Aircraft { kind, callsign: *b"HELI1   ", emitter_category, ..Aircraft::default() };
        }
        let seen = Seen::of(&flown);
        (seen.event("type"), seen.attribute("contact", "callsign").unwrap())
    };
    for (kind, category, wanted) in [
        (AircraftKind::Crewed, Some(10), "a-n-A-C-H"),
        (AircraftKind::Crewed, Some(1), "a-n-A-C-F"),
        (AircraftKind::Crewed, Some(6), "a-n-A-C-F"),
        (AircraftKind::Crewed, Some(11), "a-n-A-C"),
        (AircraftKind::Crewed, None, "a-n-A-C"),
        (AircraftKind::Unmanned, Some(13), "a-n-A-M-H-Q"),
        (AircraftKind::Vehicle, Some(21), "a-n-G-E-V"),
    ] {
        assert_eq!(said(kind, category), (wanted.to_owned(), "HELI1".to_owned()));
    }
}

#[test]
fn unknown_values_are_stated_as_unknown() {
    // The reference profile has no velocity and no accuracy.
    let mut flown = track(source(Some(None), None), None);
    flown.altitude_amsl_m = None;
    let seen = Seen::of(&flown);
    let point = |name| seen.attribute("point", name).unwrap();
    assert_eq!([point("hae"), point("ce"), point("le")], ["9999999.0", "9999999.0", "9999999.0"]);
    assert_eq!(seen.attribute("track", "speed"), None);
    // A speed without a certain direction.
    let mut hovering = track(source(Some(None), None), Some(0.1));
    assert_eq!(Seen::of(&hovering).attribute("track", "speed"), None);
    hovering.altitude_amsl_m = None;
    let seen = Seen::of(&hovering);
    let point = |name| seen.attribute("point", name).unwrap();
    assert_eq!([point("hae"), point("ce"), point("le")], ["9999999.0", "4.0", "9999999.0"]);
    assert!(seen.text_of("remarks").contains("Height not known"));
}

#[test]
fn untrusted_track_is_marked() {
    let mut flown = track(source(Some(Some(0.9)), Some(b"DRONE-1     ")), Some(10.0));
    for (state, is_doubted) in
        [(State::Unverified, false), (State::Verified, false), (State::Suspect, true), (State::Failed, true)]
    {
        doubted(&mut flown, state);
        let seen = Seen::of(&flown);
        assert_eq!(seen.event("type") == "a-u-A-M-H-Q", is_doubted, "{state:?}");
        assert_eq!(seen.attribute("contact", "callsign").unwrap() == "? DRONE-1", is_doubted, "{state:?}");
        assert_eq!(seen.text_of("remarks").starts_with("DOUBTED: "), is_doubted, "{state:?}");
        assert_eq!(seen.text_of("remarks").contains("(radar, jump)"), is_doubted, "{state:?}");
    }
    let mut disputed = track(source(None, Some(b"DRONE-1     ")), Some(10.0));
    disputed.disputed = vec!["U-10008".to_owned()];
    let seen = Seen::of(&disputed);
    assert_eq!(seen.event("type"), "a-u-A-M-H-Q");
    assert!(seen.text_of("remarks").starts_with("DISPUTED: U-10008 "));
    let mut dark = track(source(Some(Some(0.9)), None), Some(10.0));
    dark.is_uncooperative = true;
    assert!(Seen::of(&dark).text_of("remarks").contains("Without a transponder"));
    let degraded = CotSecond { is_degraded: true, ..SECOND };
    let text = writer().event(&dark, &site().1, degraded).unwrap();
    assert!(text.contains("<remarks>Without a transponder where one would be heard."), "{text}");
    assert!(text.contains("The service reports that it is degraded.</remarks>"), "{text}");
}

proptest! {
    /// For any identity of a transponder and any numbers: one well-formed event in one piece, with values allowed by its schema.
    /// The uid does not depend on the transponder's data.
    #[test]
    fn any_track_is_one_event(
        serial in prop::array::uniform12(any::<u8>()),
        speed in prop::num::f64::ANY,
        altitude in prop::option::of(prop::num::f64::ANY),
        nanos in any::<i64>(),
        state in prop::sample::select(&State::ALL[..]),
        seen_by_radar in any::<bool>(),
    ) {
        let serial = if serial[0] == 0 || serial.iter().all(|&octet| octet == b' ') { *b"<&>\"'\n\0\x1b\xff]]>" } else { serial };
        let Some(_) = Identity::new(&serial, None) else { return Ok(()) };
        let mut flown = track(source(seen_by_radar.then_some(Some(0.9)), Some(&serial)), Some(speed));
        flown.altitude_amsl_m = altitude;
        flown.time = Time::from_nanos(nanos);
        doubted(&mut flown, state);
        let text = writer().event(&flown, &site().1, SECOND).unwrap();
        prop_assert_eq!(text.matches("<event ").count(), 1);
        prop_assert_eq!(text.matches("</event>").count(), 1);
        prop_assert!(text.ends_with("</event>\n") && text.is_ascii() && text.len() < 2_000);
        let seen = Seen { text };
        prop_assert_eq!(seen.event("uid"), "<North> & \"West\".U-10007");
        for (element, name) in [("point", "lat"), ("point", "lon"), ("point", "hae"), ("point", "ce"), ("point", "le")] {
            let value = seen.attribute(element, name).unwrap();
            prop_assert!(value.parse::<f64>().is_ok_and(f64::is_finite) && !value.contains(['e', 'E']), "{}", value);
        }
        if let Some(course) = seen.attribute("track", "course") {
            prop_assert!((0.0..360.0).contains(&course.parse::<f64>().unwrap()), "{}", course);
        }
        let callsign = seen.attribute("contact", "callsign").unwrap();
        prop_assert!(!callsign.trim().is_empty());
        prop_assert_eq!(callsign.starts_with("? "), state.is_flagged());
    }
}
