//! Rules by kind: what is raised, how bad it is, and for how long it is held.

use super::*;
use crate::areas::tests::areas_of;
use crate::config::Config;

/// The demonstration with these lines behind it.
fn config(lines: &str) -> Config {
    let site = include_str!("../../../../testdata/demo/site.toml");
    Config::parse(&format!("{site}\n{lines}"), "site.toml", std::iter::empty()).unwrap()
}

/// Pictures of a site with these rules, and an area `Field` around everything within 300 m.
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
    // Who is inside is no matter here.
    settings.areas = Default::default();
    slots.alerts = Alerts::new(settings, Time::default());
    slots
}

fn silent() -> Concern {
    Concern::Silent { identity: alpha(), track: Some(9), heard: Time::default() }
}

/// What becomes of a transponder whose silence comes and goes, second by second.
fn flown(slots: &mut Slots, is_silent: impl Fn(i64) -> bool) -> Vec<(i64, Change)> {
    let concern = |second| if is_silent(second) { vec![silent()] } else { Vec::new() };
    let pass = |second| {
        let changes = slots.pass(second, &concern(second), |_| {});
        changes.into_iter().map(move |(change, _)| (second, change))
    };
    (60..100).flat_map(pass).collect()
}

#[test]
fn what_comes_and_goes_is_one_alert_for_as_long_as_it_is_held() {
    // Each second slot, and from the twentieth second on no more: ten seconds are passed at the thirtieth after 78.
    let flaps = |second: i64| second < 80 && second % 2 == 0;
    assert_eq!(flown(&mut ruled(""), flaps), [(60, Change::Began), (89, Change::Ended)]);
    let rule = "[[alerts.rules]]\nkind = \"silent\"\nhold_s = 3.0\n";
    assert_eq!(flown(&mut ruled(rule), flaps), [(60, Change::Began), (82, Change::Ended)]);
    let rule = "[[alerts.rules]]\nkind = \"silent\"\nhold_s = 0.0\n";
    assert_eq!(flown(&mut ruled(rule), flaps).len(), 20, "each by itself");
}

#[test]
fn a_rule_says_whether_there_are_any_how_bad_they_are_and_who_raises_none() {
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
fn a_rule_holds_in_its_areas() {
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
    let unknown = AlertSettings::new(&config(rule).alerts, &crate::areas::Areas::default()).unwrap_err();
    assert!(unknown.to_string().contains("kind \"uncooperative\": no area is called \"Field\""), "{unknown}");
}

#[test]
fn rules_that_make_no_sense_are_refused() {
    let refused = |rules: &str| {
        let site = include_str!("../../../../testdata/demo/site.toml");
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
