//! Lines of `check` about the areas.

use super::table::TextTable;
use fusion::time::Time;
use site::areas::{Areas, BandAmsl, ZoneKind};

/// Columns of a terminal.
const WIDTH: usize = 80;
/// Maximum width of a name, and of an identifier.
const NAME: usize = 20;
const IDENTIFIER: usize = 10;

/// Lines about the areas valid at `now`, empty if there are none. `undulation_m` is the height of the geoid above the ellipsoid.
pub(super) fn lines(areas: &Areas, now: Time, undulation_m: f64) -> String {
    let names = ["area", "id", "type", "m AMSL", "now", "allowed", "hours"];
    let mut table = TextTable::new("lllllrl", &names);
    for (area, zone) in areas.zones() {
        let kind = zone.kind.map_or(area.kind.name(), ZoneKind::name);
        let identifier = zone.identifier.as_deref().unwrap_or("-");
        let now = if zone.schedule.is_active(now) { "active" } else { "off" };
        let allowed = area.alert().map_or_else(|| "-".to_owned(), |set| set.allow.len().to_string());
        table.row([
            cut(&zone.name, NAME),
            cut(identifier, IDENTIFIER),
            kind.to_owned(),
            heights(zone.band_above_sea(undulation_m)),
            now.to_owned(),
            allowed,
            zone.schedule.to_string(),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    table.to_string().lines().map(|line| cut(&format!("# {line}"), WIDTH) + "\n").collect()
}

/// Heights such as `560-620`; `gnd` is the ground, `unl` no limit.
fn heights(band: BandAmsl) -> String {
    let metres =
        |limit: Option<f64>, none: &str| limit.map_or(none.to_owned(), |metres| format!("{metres:.0}"));
    format!("{}-{}", metres(band.floor_m, "gnd"), metres(band.ceiling_m, "unl"))
}

/// Text cut to at most `most` characters.
fn cut(text: &str, most: usize) -> String {
    let clean = |c: char| if c.is_control() { ' ' } else { c };
    match text.chars().count() > most {
        true => text.chars().take(most - 1).map(clean).chain(['…']).collect(),
        false => text.chars().map(clean).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use site::config::{AlertArea, Area, AreaKind};

    #[test]
    fn zones_are_listed_one_per_line() {
        let zone = |identifier: &str, name: &str, more: &str, layer: &str| {
            format!(
                r#"{{"type": "Feature", "properties": {{"identifier": "{identifier}", "name": "{name}"{more}}}, "geometry":
                {{"type": "Polygon", "coordinates": [[[10, 50], [11, 50], [11, 51], [10, 50]]], "layer": {{{layer}}}}}}}"#
            )
        };
        let hours = r#", "type": "CONDITIONAL", "limitedApplicability": [{"startDateTime": "2026-11-24T00:00:00Z", "schedule":
            [{"day": ["SAT", "SUN"], "startTime": "17:00:00Z", "endTime": "23:00:00Z"}]}]"#;
        let zones = [
            zone(
                "LSZB003",
                "Bern-Belp with a name that is far too long",
                r#", "type": "PROHIBITED""#,
                r#""lower": 100, "lowerReference": "WGS84""#,
            ),
            zone(
                "EDR1",
                "Field\\nand wood",
                hours,
                r#""lower": 0, "lowerReference": "AGL", "upper": 120, "upperReference": "AGL""#,
            ),
        ];
        let text = format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, zones.join(","));
        let settings = AlertArea {
            allow: vec!["A".to_owned(), "B".to_owned()],
            ground_m: Some(500.0),
            ..AlertArea::default()
        };
        let area = Area { kind: AreaKind::Alert(settings), file: "field.geojson".into() };
        let areas = Areas::parse(&text, area).unwrap();
        let shown = lines(&areas, Time::from_nanos(1_795_435_200_000_000_000), 46.6);
        assert_eq!(
            shown,
            "\
# area                  id       type         m AMSL   now     allowed  hours
# Bern-Belp with a na…  LSZB003  prohibited   53-unl   active        2  always
# Field and wood        EDR1     conditional  gnd-620  off           2  Sat Sun…
"
        );
        assert!(shown.lines().all(|line| line.chars().count() <= WIDTH));
        assert_eq!(lines(&Areas::default(), Time::default(), 0.0), "");
    }
}
