use super::*;

/// A site with a camera, a receiver of Remote ID, and a fixed transponder number.
const SITE: &str = r#"[site]
name = "test"
sac = 25
sic = 1
latitude_deg = 52.0
longitude_deg = 4.0
height_amsl_m = 10
geoid_undulation_m = 40

[[sensors]]
id = "camera"
kind = "camera"
sac = 25
sic = 15
latitude_deg = 52.0
longitude_deg = 4.0
height_amsl_m = 12

[[sensors]]
id = "remote-id"
kind = "remote-id"
sac = 25
sic = 220

[fusion]
transponder_numbers = { SMTR70000002 = 2 }

[http]
listen = "127.0.0.1:8080"
"#;

fn label(time: i64, sensor: &str, number: u32, id: &str, seduced: bool) -> Label {
    let id = (!id.is_empty()).then(|| id.to_owned());
    Label { time: Time::from_nanos(time), sensor: sensor.to_owned(), number, id, seduced, identity: None }
}

fn named(sensor: &str, number: u32, id: &str, identity: &str) -> Label {
    Label { identity: Some(identity.to_owned()), ..label(1, sensor, number, id, false) }
}

fn span(from: i64, until: i64) -> Range<Time> {
    Time::from_nanos(from)..Time::from_nanos(until)
}

fn attribution(id: Option<&str>, seduced: bool) -> Option<Attribution<'_>> {
    Some(Attribution { id, seduced })
}

#[test]
fn latest_plot_in_span_determines_the_drone() {
    let labels = Labels::new(vec![
        label(14, "radar", 5, "B", true),
        label(10, "radar", 5, "A", false),
        label(14, "radar", 5, "", false),
        label(20, "radar", 5, "C", false),
    ]);
    assert_eq!(labels.radar_track(5, None, &span(10, 14)), attribution(Some("A"), false));
    assert_eq!(labels.radar_track(5, None, &span(10, 20)), attribution(None, false), "of one time the last");
    assert_eq!(labels.radar_track(5, Some("radar"), &span(20, 30)), attribution(Some("C"), false));
    assert_eq!(labels.radar_track(5, Some("other"), &span(20, 30)), None);
    assert_eq!(labels.radar_track(5, None, &span(15, 20)), None);
    assert_eq!(labels.radar_track(6, None, &span(10, 30)), None);
}

#[test]
fn neighbouring_plots_determine_drone_without_plot() {
    let labels = Labels::new(vec![
        label(10, "radar", 5, "A", false),
        label(20, "radar", 5, "", false),
        label(21, "radar", 6, "A", false),
    ]);
    let near = |time, before_ns, after_ns| {
        let span = Time::from_nanos(time - before_ns)..=Time::from_nanos(time + after_ns);
        labels.radar_track_near(5, None, Time::from_nanos(time), &span)
    };
    assert_eq!(near(8, 2, 2), attribution(Some("A"), false), "before it began");
    assert_eq!(near(14, 5, 5), attribution(Some("A"), false));
    assert_eq!(near(16, 5, 5), attribution(None, false));
    assert_eq!(near(15, 5, 5), None, "of one that was another's");
    assert_eq!(near(15, 5, 4), attribution(Some("A"), false), "who took part last");
    assert_eq!(near(23, 3, 0), attribution(None, false), "after its end");
    assert_eq!(near(24, 3, 9), None);
    assert_eq!(near(7, 9, 2), None);
}

#[test]
fn disagreeing_radars_leave_the_drone_open() {
    let rows = vec![
        label(1, "east", 5, "A", false),
        label(1, "west", 5, "", false),
        label(2, "east", 6, "A", false),
        label(2, "west", 6, "A", false),
    ];
    let labels = Labels::with_receivers(rows, &BTreeSet::new());
    assert_eq!(labels.radar_track(5, None, &span(0, 2)), None);
    assert_eq!(labels.radar_track(5, Some("west"), &span(0, 2)), attribution(None, false));
    assert_eq!(labels.radar_track(6, None, &span(2, 3)), attribution(Some("A"), false));
}

#[test]
fn receiver_is_a_sensor_with_constant_numbers() {
    let labels = Labels::new(vec![
        label(1, "squitter", 7, "A", false),
        label(2, "squitter", 7, "A", false),
        label(2, "squitter", 9, "B", false),
        label(1, "radar", 7, "B", false),
        label(2, "radar", 8, "B", false),
    ]);
    assert_eq!(labels.transponder(None, 7), attribution(Some("A"), false));
    assert_eq!(labels.transponder(Some("N-17"), 7), attribution(Some("A"), false), "rows state no identity");
    assert_eq!(labels.transponder(None, 8), None);
    assert_eq!(labels.equipped(), BTreeSet::from(["A", "B"]));
    assert_eq!(labels.radar_track(7, None, &span(1, 2)), attribution(Some("B"), false));
}

#[test]
fn disagreeing_receivers_leave_the_drone_open() {
    let rows = vec![label(1, "one", 7, "A", false), label(1, "two", 7, "B", false)];
    assert_eq!(Labels::new(rows).transponder(None, 7), None);
}

#[test]
fn points_with_identity_are_attributed_by_it() {
    let labels = Labels::new(vec![
        named("drone-it", 3, "D3", "000000000003"),
        named("remote-id", 2, "D2", "SMTR70000002"),
        named("remote-id", 9_000_001, "", "SMTR79000001"),
        named("adsb", 4_292_615, "H1", "418007"),
        label(1, "camera", 5, "D5", false), // one to one, but not a receiver
    ]);
    assert_eq!(labels.equipped(), BTreeSet::from(["D2", "D3", "H1"]));
    let of = |identity, number| labels.transponder(Some(identity), number);
    assert_eq!(of("SMTR70000002", 7), attribution(Some("D2"), false));
    assert_eq!(of("smtr70000002", 7), attribution(Some("D2"), false), "whatever its case");
    assert_eq!(
        of("SMTR79000001", 3),
        attribution(None, false),
        "nobody's, though its number is a drone's serial"
    );
    assert_eq!(of("418007", 429_496), attribution(Some("H1"), false));
    assert_eq!(of("SMTR70000099", 3), None, "who is not labelled is not who is");
    // Lookups by number only.
    assert_eq!(labels.transponder(None, 3), attribution(Some("D3"), false), "its serial is its number");
    assert_eq!(labels.transponder(None, 2), None, "its number is the service's to give");
    assert_eq!((labels.reports_of(3).count(), labels.reports_of(2).count()), (1, 0));
}

#[test]
fn disagreeing_identities_leave_the_drone_open() {
    let labels = Labels::new(vec![named("one", 3, "A", "3"), named("two", 3, "B", "3")]);
    assert_eq!(labels.transponder(Some("3"), 3), None);
}

#[test]
fn long_serial_number_is_found_by_its_cat129_part() {
    let labels = Labels::new(vec![
        named("remote-id", 1, "A", "1581F45T7223J00A0042"),
        named("remote-id", 2, "B", "1581F45T7223J00A0043"),
    ]);
    assert_eq!(labels.transponder(Some("7223J00A0043"), 7), attribution(Some("B"), false));
    assert_eq!(labels.transponder(Some("1581F45T7223J00A0042"), 7), attribution(Some("A"), false));
}

#[test]
fn site_labels_exclude_cameras_and_use_configured_numbers() {
    let config = Config::parse(SITE, "site.toml", std::iter::empty()).unwrap();
    let rows = vec![
        label(1, "camera", 2, "D5", false),
        label(1, "radar", 2, "D7", false),
        named("remote-id", 2, "D2", "SMTR70000002"),
        named("remote-id", 4, "D4", "SMTR70000004"),
    ];
    let labels = Labels::of_site(rows, &config);
    assert_eq!(labels.transponder(None, 2), attribution(Some("D2"), false));
    assert_eq!(labels.transponder(None, 4), None);
    assert_eq!(labels.equipped(), BTreeSet::from(["D2", "D4"]));
    assert_eq!(
        labels.radar_track(2, None, &span(1, 2)),
        attribution(Some("D7"), false),
        "no camera's number"
    );
    assert_eq!(labels.plots_of("D5").count(), 0);
}
