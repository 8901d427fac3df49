//! Alerts about conflicts: one for each situation, and none that follows from a lie.

use nalgebra::{Matrix2, Vector3};

use super::*;
use conflict::Level;
use fusion::declaration::{Declaration, DeclaredHeight};
use fusion::integrity::PointIntegrity;
use fusion::point::{Association, AssociationEvidence, Basis, Estimate, TransponderPart};
use picture::conflicts::{ConflictJson, ConflictWatch, Outlook};

/// Aircraft of one second, and what follows from it.
struct Sky {
    maker: PictureMaker,
    watch: ConflictWatch,
    alerts: AlertMonitor,
    second: i64,
    outlook: Option<Outlook>,
}

type Changes = Vec<(AlertChange, Value)>;

impl Sky {
    fn new() -> Self {
        Self::ruled("")
    }

    /// With these lines at the end of the configuration.
    fn ruled(lines: &str) -> Self {
        let site = include_str!("../../../../../../testdata/demo/site.toml");
        let site = format!("{site}\n{lines}");
        let config = site::config::Config::parse(&site, "site.toml", std::iter::empty()).unwrap();
        let pipeline = input::pipeline::Pipeline::new(&config, site::areas::Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let settings = AlertSettings::new(&config.alerts, &Areas::default()).unwrap();
        let alerts = AlertMonitor::new(settings, Time::default());
        Self { maker, watch: ConflictWatch::new(&config), alerts, second: 100, outlook: None }
    }

    /// Time of the present second.
    fn now(&self) -> Time {
        Time::from_nanos(self.second * SECOND)
    }

    /// Passes one second with these aircraft. Returns the changes of alerts about conflicts.
    fn pass(&mut self, points: &[Point], concerns: &[Concern]) -> Changes {
        self.second += 1;
        let time = self.now();
        let mut points = points.to_vec();
        let rank = |source: &Source| match source {
            Source::Fused(..) => 0,
            Source::Radar(_) => 1,
            Source::Transponder(_) => 2,
            Source::Cameras => 3,
        };
        points.sort_by_key(|point| (rank(&point.source), point.number));
        let mut picture = self.maker.picture(Emission {
            now: None,
            slot: fusion::slots::Slot(4 * self.second),
            time,
            points,
            numbers: Vec::new(),
            newcomers: Vec::new(),
            jumping: Vec::new(),
            concerns: concerns.to_vec(),
        });
        picture::TrackNames::default().name(&mut picture);
        self.alerts.note_picture(&picture, &self.maker);
        let outlook = self.watch.look(&picture, &self.maker).unwrap();
        self.alerts.note_outlook(&outlook);
        self.outlook = Some(outlook);
        let changes = self.alerts.take_changes();
        let changes = changes.iter().filter(|(_, alert)| alert.kind == AlertKind::Conflict);
        changes.map(|(change, alert)| (*change, json!(AlertJson::from(alert)))).collect()
    }

    /// Passes seconds with these aircraft.
    fn fly(&mut self, seconds: usize, points: &[Point]) -> Changes {
        (0..seconds).flat_map(|_| self.pass(points, &[])).collect()
    }

    fn conflicts(&self) -> Vec<(Option<Level>, Value)> {
        let conflicts = &self.outlook.as_ref().unwrap().conflicts;
        conflicts.iter().map(|one| (one.level(), json!(ConflictJson::from(one)))).collect()
    }

    fn aircraft(&self) -> usize {
        self.outlook.as_ref().unwrap().aircraft
    }
}

/// A drone with a transponder `DRONE<number>` that hovers 50 m above the site.
fn drone(number: u32, east_m: f64) -> Point {
    let part = TransponderPart {
        number,
        identity: identity(number),
        sensor: SensorIndex(1),
        time: None,
        items: Default::default(),
        aircraft: Default::default(),
        height_measured: true,
    };
    point(number, east_m, Source::Transponder(part))
}

fn identity(number: u32) -> Identity {
    Identity::new(format!("DRONE{number}").as_bytes(), None).unwrap()
}

/// A drone that only radar sees.
fn seen(number: u32, east_m: f64) -> Point {
    point(number, east_m, Source::Radar(radar_part(0)))
}

fn radar_part(second: i64) -> RadarPart {
    RadarPart {
        track: RadarTrackKey { sensor: SensorIndex(0), number: 9 },
        time: Time::from_nanos(second * SECOND),
        height_measured: true,
        uav_probability: None,
    }
}

fn point(number: u32, east_m: f64, source: Source) -> Point {
    let estimate = Estimate {
        velocity: Vector3::zeros(),
        horizontal: Matrix2::identity() * 4.0,
        vertical_m2: 4.0,
        velocity_covariance: Matrix2::identity() * 0.1,
        position_velocity: Matrix2::zeros(),
        climb_m2s2: 0.1,
        height_climb: 0.0,
        lie_m2: 0.0,
        basis: Basis::Measured,
        last_measurement: None,
    };
    Point {
        estimate: Some(estimate),
        ..Point::new(number, Enu::new(east_m, 0.0, 50.0), Time::default(), source)
    }
}

fn with_state(state: State, point: Point) -> Point {
    let reasons = Default::default();
    let integrity = PointIntegrity { state, index: 0.0, protection_level_m: None, offset_m: None, reasons };
    Point { integrity: Some(integrity), ..point }
}

fn at_height(height_m: f64, mut point: Point) -> Point {
    point.position = Enu::new(point.position.east(), point.position.north(), height_m);
    point
}

fn declared(declaration: Declaration, mut point: Point) -> Point {
    let Source::Transponder(part) = &mut point.source else { panic!("it has no transponder") };
    part.aircraft.declared = declaration;
    point
}

fn moving(speed: f64, mut point: Point) -> Point {
    let estimate = point.estimate.as_mut().unwrap();
    estimate.velocity.x = speed;
    point
}

/// Without a measured height, of which the standard deviation is this.
fn coarse(sigma_m: f64, mut point: Point) -> Point {
    point.estimate.as_mut().unwrap().vertical_m2 = sigma_m * sigma_m;
    match &mut point.source {
        Source::Transponder(part) => part.height_measured = false,
        Source::Radar(part) | Source::Fused(part, ..) => part.height_measured = false,
        Source::Cameras => panic!("cameras measure the height"),
    }
    point
}

fn names(changes: &Changes) -> Vec<(AlertChange, &str)> {
    changes.iter().map(|(change, alert)| (*change, alert["id"].as_str().unwrap())).collect()
}

#[test]
fn aircraft_near_one_another_are_one_alert() {
    let mut sky = Sky::new();
    // The outer two are not in conflict with each other.
    let three = [drone(1, 0.0), drone(2, 40.0), drone(3, 80.0)];
    let changes = sky.fly(3, &three);
    let [(AlertChange::Began, alert)] = &changes[..] else { panic!("{changes:#?}") };
    assert_eq!((&alert["severity"], &alert["entered"]), (&json!("critical"), &json!(true)));
    assert_eq!(alert["tracks"].as_array().unwrap().len(), 3);
    let text = alert["text"].as_str().unwrap();
    assert!(text.starts_with("RONE1, RONE2 and RONE3 are near one another: RONE"), "{text}");
    assert!(text.ends_with("too close (drone): 40 m apart and 0 m in height"), "{text}");
    assert_eq!(sky.conflicts().iter().filter(|(level, _)| *level == Some(Level::Violation)).count(), 2);
}

#[test]
fn situations_that_meet_become_one_alert() {
    let mut sky = Sky::new();
    let pairs = |between_m: f64| {
        [drone(1, 0.0), drone(2, 40.0), drone(3, 40.0 + between_m), drone(4, 80.0 + between_m)]
    };
    let began = sky.fly(3, &pairs(400.0));
    assert_eq!(names(&began), [(AlertChange::Began, "conflict-1"), (AlertChange::Began, "conflict-2")]);
    let acknowledge = AlertRequest {
        id: "conflict-1".to_owned(),
        action: AlertAction::Acknowledge,
        by: "tower".to_owned(),
        note: None,
    };
    sky.alerts.decide(&acknowledge, sky.now()).unwrap();
    sky.alerts.take_changes();
    let changes = sky.fly(3, &pairs(40.0));
    assert_eq!(names(&changes), [(AlertChange::Ended, "conflict-2"), (AlertChange::Amended, "conflict-1")]);
    let [(_, part), (_, whole)] = &changes[..] else { unreachable!() };
    assert_eq!(part["text"], format!("part of conflict-1 since 00:01:{} UTC", sky.second - 61));
    assert!(part.get("latched").is_none(), "the other one continues it: {part}");
    assert!(whole.get("acknowledged").is_none(), "nobody has seen the second pair: {whole}");
    assert_eq!(whole["tracks"].as_array().unwrap().len(), 4);
}

#[test]
fn ended_violation_is_latched_until_acknowledged() {
    let mut sky = Sky::new();
    let pair = |apart_m: f64| [drone(1, 0.0), drone(2, apart_m)];
    sky.fly(3, &pair(44.0));
    sky.fly(1, &pair(17.0));
    let apart_s = sky.second;
    assert_eq!(sky.fly(4, &pair(300.0)), [(AlertChange::Amended, sky.fly_shown())]);
    let shown = sky.fly_shown();
    assert!(
        shown["text"]
            .as_str()
            .unwrap()
            .ends_with("17 m apart and 0 m in height; now 300 m apart and 0 m in height")
    );
    let changes = sky.fly(30, &pair(300.0));
    let [(AlertChange::Ended, over)] = &changes[..] else { panic!("{changes:#?}") };
    assert_eq!((&over["latched"], &over["closest"]["horizontal_m"]), (&json!(true), &json!(17.0)));
    let text = over["text"].as_str().unwrap();
    let closest = format!("RONE1 and RONE2 were closest at 00:01:{} UTC (drone): 17 m apart", apart_s - 60);
    assert!(text.starts_with(&closest) && text.contains("; over since 00:01:"), "{text}");

    let acknowledge = |id: &str| AlertRequest {
        id: id.to_owned(),
        action: AlertAction::Acknowledge,
        by: "tower".to_owned(),
        note: None,
    };
    let (_, alert) = sky.alerts.decide(&acknowledge("conflict-1"), sky.now()).unwrap();
    assert!(!alert.is_latched && alert.acknowledged.is_some());
    let refused = sky.alerts.decide(&acknowledge("conflict-1"), sky.now());
    assert_eq!(refused.unwrap_err(), AlertRequestError::Ended);

    // A further violation of the same pair takes the place of a latched one.
    sky.fly(4, &pair(44.0));
    sky.fly(30, &pair(300.0));
    let latched = |sky: &Sky| {
        let all = sky.alerts.all().into_iter().filter(|alert| alert.is_latched);
        all.map(|alert| alert.name()).collect::<Vec<_>>()
    };
    assert_eq!(latched(&sky), ["conflict-2"]);
    sky.fly(4, &pair(44.0));
    assert_eq!(latched(&sky), Vec::<String>::new());
    sky.fly(30, &pair(300.0));
    assert_eq!(latched(&sky), ["conflict-3"]);
}

impl Sky {
    /// The active alert about a conflict.
    fn fly_shown(&self) -> Value {
        let all = self.alerts.all();
        let alert = all.iter().find(|alert| alert.kind == AlertKind::Conflict && alert.until.is_none());
        json!(AlertJson::from(&**alert.unwrap()))
    }
}

#[test]
fn text_of_a_conflict_is_that_of_the_last_second() {
    let mut sky = Sky::new();
    let (mut apart_m, mut revisions) = (300.0, Vec::new());
    for _ in 0..20 {
        apart_m -= 10.0;
        sky.pass(&[drone(1, 0.0), moving(-10.0, drone(2, apart_m))], &[]);
        let all = sky.alerts.all();
        let Some(alert) = all.iter().find(|alert| alert.kind == AlertKind::Conflict) else { continue };
        let due = format!("come close in {:.0} s (drone): then 0 m apart", apart_m / 10.0);
        assert!(alert.text.contains(&due), "{due}: {}", alert.text);
        revisions.push(alert.revision);
    }
    assert!(revisions.len() > 5 && revisions.windows(2).all(|pair| pair[0] < pair[1]), "{revisions:?}");
}

#[test]
fn lie_covers_its_conflicts_but_not_those_of_the_twin() {
    let concern = Concern::Integrity {
        identity: identity(2),
        track: Some(2),
        twin: Some(5),
        state: State::Failed,
        reasons: [Reason::Radar].into_iter().collect(),
        offset_m: Some(1000.0),
    };
    let liar = Point { disputed: vec![5], ..with_state(State::Failed, drone(2, 30.0)) };
    let twin = Point { disputed: vec![2], ..seen(5, 1030.0) };
    let mut sky = Sky::new();
    let concerns = [concern];
    // Tracks are taken for one aircraft for a while after one begins beside the other.
    let both = |sky: &mut Sky, points: &[Point]| -> Changes {
        (0..30).flat_map(|_| sky.pass(points, &concerns)).collect()
    };
    assert_eq!(both(&mut sky, &[drone(1, 0.0), liar.clone(), twin.clone()]), []);
    let [(level, listed)] = &sky.conflicts()[..] else { panic!("{:?}", sky.conflicts()) };
    assert_eq!((*level, &listed["integrity"]), (Some(Level::Violation), &json!("failed")), "still listed");

    let changes = both(&mut sky, &[drone(1, 0.0), liar, twin, drone(3, 1000.0)]);
    let [(AlertChange::Began, alert), ..] = &changes[..] else { panic!("{changes:#?}") };
    assert!(alert["text"].as_str().unwrap().starts_with("RONE3 and R 5 are too close"), "{alert}");
}

#[test]
fn lie_that_raises_no_alert_covers_nothing() {
    let failed = with_state(State::Failed, drone(2, 30.0));
    for (rule, count) in [("enabled = false", 1), ("allow = [\"DRONE2\"]", 1), ("allow = [\"DRONE1\"]", 0)] {
        let mut sky = Sky::ruled(&format!("[[alerts.rules]]\nkind = \"integrity\"\n{rule}\n"));
        assert_eq!(sky.fly(3, &[drone(1, 0.0), failed.clone()]).len(), count, "{rule}");
    }
}

#[test]
fn conflict_of_a_suspect_or_supported_transponder_is_raised() {
    let mut sky = Sky::new();
    let suspect = with_state(State::Suspect, drone(2, 30.0));
    assert_eq!(names(&sky.fly(3, &[drone(1, 0.0), suspect])), [(AlertChange::Began, "conflict-1")]);

    // A radar sees an aircraft where the transponder that is not to be trusted says it is.
    for (age_s, count) in [(2, 1), (30, 0)] {
        let mut sky = Sky::new();
        let mut changes = Vec::new();
        for _ in 0..4 {
            let Source::Transponder(part) = drone(2, 30.0).source else { unreachable!() };
            let because = AssociationEvidence::Likelihood { score: 9.0 };
            let source =
                Source::Fused(radar_part(sky.second - age_s), part, Association { distance_m: 1.0, because });
            let failed = with_state(State::Failed, point(2, 30.0, source));
            changes.extend(sky.pass(&[drone(1, 0.0), failed], &[]));
        }
        assert_eq!(changes.len(), count, "{age_s} s: {changes:#?}");
    }
}

#[test]
fn unknown_height_is_at_most_an_advisory() {
    let mut sky = Sky::new();
    assert_eq!(sky.fly(3, &[drone(1, 0.0), coarse(70.0, drone(2, 30.0))]), []);
    let [(level, listed)] = &sky.conflicts()[..] else { panic!("{:?}", sky.conflicts()) };
    assert_eq!(*level, Some(Level::Advisory));
    assert_eq!((&listed["vertical_known"], listed.get("vertical_coarse")), (&json!(false), None));
    assert_eq!((listed.get("entered"), listed.get("d_now_v_m")), (None, None), "that is not known");

    // A coarse height bounds the conflict.
    let mut sky = Sky::new();
    assert_eq!(sky.fly(3, &[drone(1, 0.0), at_height(300.0, coarse(50.0, drone(2, 30.0)))]), []);
    assert_eq!(sky.conflicts().len(), 0);
    assert_eq!(sky.fly(3, &[drone(1, 0.0), at_height(60.0, coarse(50.0, drone(2, 30.0)))]), []);
    let [(level, listed)] = &sky.conflicts()[..] else { panic!("{:?}", sky.conflicts()) };
    assert_eq!((*level, &listed["vertical_coarse"]), (Some(Level::Advisory), &json!(true)));
}

#[test]
fn aircraft_that_states_the_ground_and_rests_takes_no_part() {
    let ground = Declaration { status: Some(1), ..Declaration::default() };
    let mut sky = Sky::new();
    sky.fly(6, &[drone(1, 0.0), declared(ground, drone(2, 30.0))]);
    assert_eq!(sky.aircraft(), 1);
    // It does not rest.
    sky.fly(6, &[drone(1, 0.0), moving(3.0, declared(ground, drone(2, 30.0)))]);
    assert_eq!(sky.aircraft(), 2);
}

#[test]
fn landed_aircraft_takes_no_part_but_a_hovering_one_does() {
    let stated = |half_metres| Declaration {
        height: Some(DeclaredHeight { half_metres, is_above_ground: true }),
        ..Declaration::default()
    };
    // First height, last height, what it states, whether it takes part.
    for (from_m, to_m, declaration, takes_part) in [
        (80.0, 0.0, Declaration::default(), false),
        (80.0, 0.0, stated(2), false),
        (80.0, 0.0, stated(80), true),
        (10.0, 0.0, Declaration::default(), true),
        // Another aircraft has been lower.
        (80.0, 30.0, Declaration::default(), true),
    ] {
        let mut sky = Sky::new();
        let other = at_height(0.0, drone(1, 5000.0));
        sky.fly(2, &[other.clone(), moving(3.0, at_height(from_m, drone(2, 30.0)))]);
        let landed = declared(declaration, at_height(to_m, drone(2, 30.0)));
        sky.fly(4, &[other.clone(), landed.clone()]);
        assert_eq!(sky.aircraft(), 2, "it has not rested for long");
        sky.fly(6, &[other, landed]);
        assert_eq!(sky.aircraft(), 1 + usize::from(takes_part), "{from_m} {to_m} {declaration:?}");
    }
}

#[test]
fn names_of_aircraft_in_a_text_are_unique() {
    let mut sky = Sky::new();
    let changes = sky.fly(3, &[drone(12_345, 0.0), drone(912_345, 30.0)]);
    let [(AlertChange::Began, alert)] = &changes[..] else { panic!("{changes:#?}") };
    assert!(alert["text"].as_str().unwrap().starts_with("E12345 and 912345 are too close"), "{alert}");
}

#[test]
fn text_states_the_closest_approach_of_the_pair_it_names() {
    let mut sky = Sky::new();
    sky.fly(5, &[drone(1, 0.0), drone(2, 17.0), drone(3, 300.0)]);
    let joined = sky.fly(5, &[drone(1, -500.0), drone(2, 300.0), drone(3, 340.0)]);
    assert!(!joined.is_empty() && joined.iter().all(|(_, alert)| alert["id"] == "conflict-1"), "{joined:?}");
    let apart = sky.fly(3, &[drone(1, -500.0), drone(2, 300.0), drone(3, 380.0)]);
    let text = apart.last().unwrap().1["text"].as_str().unwrap();
    assert!(text.contains("RONE2 and RONE3 were closest at 00:01:"), "{text}");
    assert!(text.contains(" UTC (drone): 40 m apart and 0 m in height; now 80 m apart"), "{text}");
}
