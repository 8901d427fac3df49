//! Rules by kind: which alerts are raised, their severity and their hold time.

use super::*;
use site::config::Config;

/// The demo configuration with these lines appended.
fn config(lines: &str) -> Config {
    let site = include_str!("../../../../../../testdata/demo/site.toml");
    Config::parse(&format!("{site}\n{lines}"), "site.toml", std::iter::empty()).unwrap()
}

/// Pictures of a site with these rules, and an area `Field` of 300 m around the origin.
fn ruled(lines: &str) -> Slots {
    let mut slots = Slots::new();
    let corners = [(-300.0, -300.0), (300.0, -300.0), (300.0, 300.0), (-300.0, 300.0), (-300.0, -300.0)];
    let corner = |(east_m, north_m)| {
        let place = slots.maker.place(Enu::new(east_m, north_m, 0.0));
        [place.longitude_deg(), place.latitude_deg()]
    };
    let field = json!({ "type": "Feature", "properties": { "name": "Field" },
        "geometry": { "type": "Polygon", "coordinates": [corners.map(corner)] } });
    let areas = areas_of(&field.to_string(), |_| {});
    let mut settings = AlertSettings::new(&config(lines).alerts, &areas).unwrap();
    // Alerts about areas are off in these tests.
    settings.areas = Default::default();
    slots.alerts = AlertMonitor::new(settings, Time::default());
    slots
}

fn silent() -> Concern {
    Concern::Silent { identity: alpha(), track: Some(9), heard: Time::default() }
}

/// Changes for a transponder whose silence comes and goes, second by second.
fn flown(slots: &mut Slots, is_silent: impl Fn(i64) -> bool) -> Vec<(i64, AlertChange)> {
    let concern = |second| if is_silent(second) { vec![silent()] } else { Vec::new() };
    let pass = |second| {
        let changes = slots.pass(second, &concern(second), |_| {});
        changes.into_iter().map(move |(change, _)| (second, change))
    };
    (60..100).flat_map(pass).collect()
}

#[test]
fn intermittent_cause_is_one_alert_within_its_hold_time() {
    // Silent at every even second up to 78; 89 is the first second more than 10 s later.
    let flaps = |second: i64| second < 80 && second % 2 == 0;
    assert_eq!(flown(&mut ruled(""), flaps), [(60, AlertChange::Began), (89, AlertChange::Ended)]);
    let rule = "[[alerts.rules]]\nkind = \"silent\"\nhold_s = 3.0\n";
    assert_eq!(flown(&mut ruled(rule), flaps), [(60, AlertChange::Began), (82, AlertChange::Ended)]);
    let rule = "[[alerts.rules]]\nkind = \"silent\"\nhold_s = 0.0\n";
    assert_eq!(flown(&mut ruled(rule), flaps).len(), 20, "each by itself");
}

#[test]
fn rule_sets_enabled_severity_and_allowed_serials() {
    let raised = |rule: &str| {
        let mut slots = ruled(&format!("[[alerts.rules]]\nkind = \"silent\"\n{rule}\n"));
        let changes = slots.pass(60, &[silent()], |_| {});
        changes.into_iter().map(|(_, alert)| alert["severity"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(raised(""), [json!("warning")]);
    assert_eq!(raised("severity = \"critical\""), [json!("critical")]);
    assert_eq!(raised("enabled = false"), Vec::<Value>::new());
    assert_eq!(raised("allow = [\"ALPHA\"]"), Vec::<Value>::new());
    assert_eq!(raised("allow = [\"BRAVO\"]"), [json!("warning")]);
}

#[test]
fn rule_applies_within_its_areas() {
    let rule = "[[alerts.rules]]\nkind = \"uncooperative\"\nareas = [\"Field\"]\n";
    for (lines, east_m, count) in [(rule, 100.0, 1), (rule, 400.0, 0), ("", 400.0, 1)] {
        let mut slots = ruled(lines);
        let place = slots.maker.place(Enu::new(east_m, 0.0, 50.0));
        let changes = slots.pass(60, &[], |picture| {
            picture.tracks[0].is_uncooperative = true;
            picture.tracks[0].position = place;
        });
        assert_eq!(changes.len(), count, "{east_m}");
    }
    let unknown = AlertSettings::new(&config(rule).alerts, &Areas::default()).unwrap_err();
    assert!(unknown.to_string().contains("kind \"uncooperative\": no area is called \"Field\""), "{unknown}");
}

#[test]
fn invalid_rules_are_rejected() {
    let refused = |rules: &str| {
        let site = include_str!("../../../../../../testdata/demo/site.toml");
        Config::parse(&format!("{site}\n{rules}"), "site.toml", std::iter::empty()).unwrap_err().to_string()
    };
    let rule = |lines: &str| refused(&format!("[[alerts.rules]]\n{lines}\n"));
    assert!(rule("kind = \"loud\"").contains("there is no such kind of alert"));
    assert!(rule("enabled = false").contains("add kind ="));
    assert!(rule("kind = \"silent\"\nhold_s = 4000.0").contains("between 0 and 3600"));
    assert!(rule("kind = \"sensor\"\nallow = [\"A\"]").contains("no transponder"));
    assert!(rule("kind = \"sensor\"\nareas = [\"A\"]").contains("limited to areas"));
    let twice = "[[alerts.rules]]\nkind = \"silent\"\n".repeat(2);
    assert!(refused(&twice).contains("two rules of kind \"silent\""));
}
