//! Tracks inside areas, and tracks about to enter.

use jiff::SignedDuration;
use nalgebra::{Matrix2, Vector3};

use super::*;
use fusion::integrity::PointIntegrity;
use fusion::point::{Basis, Estimate, NowPicture, TransponderPart};
use fusion::slots::Slot;
use site::config::AlertArea;

/// The demo site, with a zone of 1 km by 1 km whose near edge is 1 km to the east.
struct Site {
    maker: PictureMaker,
    alerts: AlertMonitor,
    /// State of the only aircraft.
    velocity: Vector3<f64>,
    height: f64,
    is_height_known: bool,
    state: State,
}

/// Changes, each with its alert.
type Changes = Vec<(AlertChange, Value)>;

impl Site {
    fn new(properties: &Value, change: impl FnOnce(&mut AlertArea)) -> Self {
        let site = include_str!("../../../../../../testdata/demo/site.toml");
        let config = site::config::Config::parse(site, "site.toml", std::iter::empty()).unwrap();
        let pipeline = input::pipeline::Pipeline::new(&config, site::areas::Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let corners =
            [(1000.0, -500.0), (2000.0, -500.0), (2000.0, 500.0), (1000.0, 500.0), (1000.0, -500.0)];
        let corner = |(east_m, north_m)| {
            let place = maker.place(Enu::new(east_m, north_m, 0.0));
            [place.longitude_deg(), place.latitude_deg()]
        };
        let zone = json!({ "type": "Feature", "properties": properties,
            "geometry": { "type": "Polygon", "coordinates": [corners.map(corner)],
                "layer": { "lower": 0, "lowerReference": "AGL", "upper": 300, "upperReference": "AMSL" } } });
        let areas = areas_of(&zone.to_string(), change).alerts();
        let alerts = AlertMonitor::new(AlertSettings::of(areas), Time::default());
        let velocity = Vector3::new(20.0, 0.0, 0.0);
        Self { maker, alerts, velocity, height: 50.0, is_height_known: true, state: State::Unverified }
    }

    fn closed() -> Self {
        Self::new(&json!({ "identifier": "EDR1", "name": "Field", "type": "PROHIBITED" }), |settings| {
            settings.allow = vec!["BRAVO".to_owned()];
        })
    }

    fn point(&self, east_m: f64) -> Point {
        let part = TransponderPart {
            number: 1,
            identity: alpha(),
            sensor: SensorIndex(1),
            time: None,
            items: Default::default(),
            aircraft: Default::default(),
            height_measured: true,
        };
        let track = RadarTrackKey { sensor: SensorIndex(0), number: 9 };
        let flat = RadarPart { track, time: Time::default(), height_measured: false, uav_probability: None };
        let known_m2 = if self.is_height_known { 25.0 } else { 3600.0 };
        let estimate = Estimate {
            velocity: self.velocity,
            horizontal: Matrix2::identity() * 25.0,
            vertical_m2: known_m2,
            velocity_covariance: Matrix2::identity(),
            position_velocity: Matrix2::zeros(),
            climb_m2s2: 0.1,
            height_climb: 0.0,
            lie_m2: 0.0,
            basis: Basis::Measured,
            last_measurement: None,
        };
        let integrity = PointIntegrity {
            state: self.state,
            index: 0.0,
            protection_level_m: None,
            offset_m: None,
            reasons: Default::default(),
        };
        Point {
            estimate: Some(estimate),
            integrity: Some(integrity),
            ..Point::new(
                10_007,
                Enu::new(east_m, 0.0, self.height),
                Time::default(),
                if self.is_height_known { Source::Transponder(part) } else { Source::Radar(flat) },
            )
        }
    }

    fn taken(&mut self) -> Changes {
        let changes = self.alerts.take_changes();
        changes.iter().map(|(change, alert)| (*change, json!(AlertJson::from(alert)))).collect()
    }

    /// Predicts from a picture of the present at a slot, with the aircraft `east_m` to the east. Returns the changes.
    fn now(&mut self, slot: i64, east_m: f64) -> Changes {
        let time = Time::from_nanos(slot * SECOND / 4);
        let points = vec![self.point(east_m)];
        let mut picture = self.maker.now(NowPicture { slot: Slot(slot), time, points });
        picture::TrackNames::default().name(&mut picture);
        self.alerts.note_approaches(PredictionPicture::Now(&picture), &self.maker);
        self.taken()
    }

    /// Publishes a picture.
    fn lagged(&mut self, slot: i64, east_m: f64) -> (Picture, Changes) {
        let mut picture = self.maker.picture(Emission {
            now: None,
            slot: Slot(slot),
            time: Time::from_nanos(slot * SECOND / 4),
            points: vec![self.point(east_m)],
            numbers: Vec::new(),
            newcomers: Vec::new(),
            jumping: Vec::new(),
            concerns: Vec::new(),
        });
        picture::TrackNames::default().name(&mut picture);
        self.alerts.note_picture(&picture, &self.maker);
        (picture, self.taken())
    }
}

fn kinds(changes: &Changes) -> Vec<(AlertChange, &str)> {
    changes.iter().map(|(change, alert)| (*change, alert["kind"].as_str().unwrap())).collect()
}

#[test]
fn entry_predicted_by_two_of_four_becomes_an_area_alert() {
    let mut site = Site::closed();
    assert_eq!(site.now(400, 0.0), []);
    assert_eq!(site.now(401, 5.0), [], "once a second");
    let changes = site.now(404, 20.0);
    let [(AlertChange::Began, began)] = &changes[..] else { panic!("{changes:?}") };
    // 980 m at 20 m/s. A course one standard deviation (1/20) off lengthens the way, so the straight course is the
    // earliest.
    assert_eq!(
        *began,
        json!({
            "id": "area-predicted-1", "kind": "area-predicted", "severity": "warning", "since": "1970-01-01T00:01:41.000Z",
            "text": "ALPHA is 49 s away from entering Field (EDR1), where flights \
                     are prohibited",
            "track": "U-10007", "area": { "name": "Field", "identifier": "EDR1", "type": "prohibited" },
            "time_to_entry_s": 49.0, "earliest_s": 49.0,
        })
    );
    assert_eq!(site.now(408, 40.0), [], "as time goes on it is no news");
    assert_eq!(json!(AlertJson::from(&*site.alerts.all()[0]))["time_to_entry_s"], 48.0);
    // Predicted to be inside; the published picture does not show it yet.
    assert_eq!(site.now(604, 1020.0), []);
    assert!(site.alerts.all()[0].text.contains("is by now inside Field (EDR1)"), "{:?}", site.alerts.all());
    let (_, changes) = site.lagged(604, 1020.0);
    assert_eq!(kinds(&changes), [(AlertChange::Began, "area")]);
    assert_eq!(
        (&changes[0].1["severity"], &changes[0].1["text"]),
        (&json!("critical"), &json!("ALPHA is inside Field (EDR1), where flights are prohibited"))
    );
    assert_eq!(kinds(&site.now(604, 1020.0)), [(AlertChange::Ended, "area-predicted")], "one at a time");
    assert_eq!(site.now(608, 1040.0), []);
    assert_eq!(site.now(612, 1060.0), [], "it is inside, and enters no more");
}

/// An aircraft first seen inside raises a prediction before the published picture shows it, and only one alert at a time.
#[test]
fn track_first_seen_inside_is_predicted_until_published() {
    let mut site = Site::closed();
    assert_eq!(site.now(0, 1100.0), [], "a single one may be chance");
    let began = site.now(4, 1120.0);
    assert_eq!(kinds(&began), [(AlertChange::Began, "area-predicted")]);
    assert!(began[0].1["text"].as_str().unwrap().contains("is by now inside"), "{began:?}");
    assert_eq!(began[0].1["time_to_entry_s"], 0.0);
    assert_eq!(site.now(8, 1140.0), []);
    assert_eq!(kinds(&site.lagged(9, 1120.0).1), [(AlertChange::Began, "area")]);
    assert_eq!(kinds(&site.now(9, 1145.0)), [(AlertChange::Ended, "area-predicted")]);
}

/// The published picture shows the aircraft inside between two predictions: one alert ends in the slot in which the other
/// begins.
#[test]
fn area_alert_replaces_the_prediction_in_the_same_slot() {
    let mut site = Site::closed();
    site.now(0, 0.0);
    assert_eq!(kinds(&site.now(4, 20.0)), [(AlertChange::Began, "area-predicted")]);
    assert_eq!(kinds(&site.lagged(201, 1001.0).1), [(AlertChange::Began, "area")]);
    let ended = site.now(201, 1010.0);
    assert_eq!(kinds(&ended), [(AlertChange::Ended, "area-predicted")]);
    assert_eq!(ended[0].1["until"], "1970-01-01T00:00:50.250Z");
}

#[test]
fn single_predictions_raise_none_and_turning_away_ends_it() {
    let mut site = Site::closed();
    let (east, away) = (site.velocity, -site.velocity);
    let mut fly = |second: i64, velocity: Vector3<f64>| {
        site.velocity = velocity;
        kinds(&site.now(4 * second, 0.0)).iter().map(|(change, _)| *change).collect::<Vec<_>>()
    };
    // One prediction in five.
    for second in 0..20 {
        assert_eq!(fly(second, if second % 5 == 0 { east } else { away }), [], "{second}");
    }
    // Two predictions of four, not adjacent.
    assert_eq!([fly(20, east), fly(21, away), fly(22, away)], [[], [], []] as [[AlertChange; 0]; 3]);
    assert_eq!(fly(23, east), [AlertChange::Began]);
    for second in 24..28 {
        assert_eq!(fly(second, away), [], "{second}");
    }
    assert_eq!(fly(28, away), [AlertChange::Ended]);
    assert_eq!(fly(29, east), [], "anew");
}

/// A course that just misses a corner raises no alert, but keeps an active one while a course one deviation beside it
/// enters.
#[test]
fn course_off_by_some_degrees_holds_but_does_not_raise() {
    let mut site = Site::closed();
    let (inside, past) = (Vector3::new(20.0, 9.5, 0.0), Vector3::new(20.0, 10.5, 0.0));
    let mut fly = |second: i64, velocity: Vector3<f64>| {
        site.velocity = velocity;
        let changes = kinds(&site.now(4 * second, 0.0)).iter().map(|(change, _)| *change).collect::<Vec<_>>();
        (changes, site.alerts.all().first().map(|alert| json!(AlertJson::from(&**alert))))
    };
    for second in 0..10 {
        assert_eq!(fly(second, past), (vec![], None), "{second}");
    }
    assert_eq!(fly(10, inside).0, []);
    assert_eq!(fly(11, inside).0, [AlertChange::Began]);
    for second in 12..30 {
        let (changes, alert) = fly(second, past);
        let alert = alert.unwrap();
        assert_eq!(changes, []);
        assert!(
            alert.get("time_to_entry_s").is_none() && alert["earliest_s"].as_f64() > Some(45.0),
            "{alert}"
        );
        assert!(alert["text"].as_str().unwrap().contains("unless it passes by, Field"), "{alert}");
    }
    for second in 30..34 {
        assert_eq!(fly(second, -past).0, []);
    }
    assert_eq!(fly(34, -past).0, [AlertChange::Ended]);
}

/// A prediction from a picture that is 6 s old accounts for 6 s of flight.
#[test]
fn prediction_from_a_lagged_picture_adds_its_age() {
    let mut site = Site::closed();
    site.velocity *= 2.0;
    for (slot, east_m, told) in [(0, 0.0, 19.0), (4, 40.0, 18.0)] {
        let (picture, changes) = site.lagged(slot, east_m);
        assert_eq!(changes, []);
        site.alerts
            .note_approaches(PredictionPicture::Lagged(&picture, SignedDuration::from_secs(6)), &site.maker);
        let known: Vec<Value> =
            site.alerts.all().iter().map(|alert| json!(AlertJson::from(&**alert))).collect();
        assert_eq!(known.len(), usize::from(slot == 4), "the second time");
        assert!(known.iter().all(|alert| alert["time_to_entry_s"] == told && alert["since"] == "1970-01-01T00:00:07.000Z"));
    }
}

#[test]
fn prediction_considers_height_and_climb() {
    for (height, climb, is_raised) in
        [(50.0, 0.0, true), (400.0, 0.0, false), (400.0, -5.0, true), (50.0, 8.0, false)]
    {
        let mut site = Site::closed();
        (site.velocity.z, site.height) = (climb, height);
        site.now(0, 0.0);
        assert_eq!(site.now(4, 20.0).len(), usize::from(is_raised), "{height} m, {climb} m/s");
    }
    // An unknown height counts as inside, and the alert states it.
    let mut site = Site::closed();
    (site.is_height_known, site.height) = (false, 400.0);
    site.now(0, 0.0);
    assert_eq!(kinds(&site.now(4, 20.0)), [(AlertChange::Began, "area-predicted")]);
    let (_, changes) = site.lagged(4, 1500.0);
    let [(AlertChange::Began, inside)] = &changes[..] else { panic!("{changes:?}") };
    assert!(
        inside["text"].as_str().unwrap().ends_with("are prohibited; its height is not known"),
        "{inside}"
    );
    assert_eq!(inside["height_unknown"], true);
}

/// An exempt transponder raises no alert, unless it is suspect. The alert about a failed one covers its false position.
#[test]
fn allowed_serial_is_exempt_while_trusted() {
    for (state, count) in
        [(State::Unverified, 0), (State::Verified, 0), (State::Suspect, 1), (State::Failed, 0)]
    {
        let allowed = |settings: &mut AlertArea| settings.allow = vec!["ALPHA".to_owned()];
        let mut site = Site::new(&json!({ "identifier": "EDR1", "type": "REQ_AUTHORIZATION" }), allowed);
        site.state = state;
        site.now(0, 0.0);
        assert_eq!(site.now(4, 20.0).len(), count, "{state:?}");
        assert_eq!(site.lagged(4, 1500.0).1.len(), count, "{state:?}");
    }
}

#[test]
fn prediction_is_off_at_zero_and_in_open_areas() {
    let off = |settings: &mut AlertArea| settings.predict_s = SignedDuration::ZERO;
    let mut site = Site::new(&json!({ "identifier": "EDR1", "type": "PROHIBITED" }), off);
    assert_eq!([site.now(0, 0.0), site.now(4, 20.0)].concat(), []);
    assert_eq!(kinds(&site.lagged(4, 1500.0).1), [(AlertChange::Began, "area")]);
    let mut free = Site::new(&json!({ "identifier": "EDR1", "type": "NO_RESTRICTION" }), |_| {});
    assert_eq!([free.now(0, 0.0), free.now(4, 20.0), free.lagged(4, 1500.0).1].concat(), []);
}
