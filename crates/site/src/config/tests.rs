//! Tests of every rule, with the line, key and message of its error.

mod cluster;
mod fusion;
mod outputs;
mod sensors;

use jiff::SignedDuration;

use super::*;

/// A minimal configuration. The tables of rules below rely on its line numbers.
const BASE: &str = r#"[site]
name = "test"
sac = 25
sic = 1

[[sensors]]
id = "north"
kind = "radar"
sac = 25
sic = 200
latitude_deg = 52.5
longitude_deg = -0.5
height_amsl_m = 105
inputs = [{ group = "239.192.48.1", port = 8048, interface = "127.0.0.1" }]

[[sensors]]
id = "air"
kind = "transponder"
sac = 0
sic = 0

[fusion]
slot_s = 0.25

[output]
asterix = [{ group = "239.192.129.2", port = 8130 }]

[http]
listen = "127.0.0.1:8080"
"#;

fn parse(text: &str) -> Result<Config, ConfigErrors> {
    Config::parse(text, "site.toml", std::iter::empty())
}

/// A replacement in `BASE` and the single error it causes: location ("line: key = value"; " key" for the whole file) and a part
/// of the message.
type Rule<'a> = (&'a str, &'a str, &'a str, &'a str);

fn check(rules: &[Rule<'_>]) {
    let wrong: Vec<_> = rules.iter().filter_map(broken).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

fn broken(&(old, new, place, message): &Rule<'_>) -> Option<String> {
    assert_eq!(BASE.matches(old).count(), 1, "{old:?} has to be in the base file once");
    let Err(errors) = parse(&BASE.replace(old, new)) else { return Some(format!("{new:?} was accepted")) };
    let shown = errors.to_string();
    let rest = shown.strip_prefix(&format!("site.toml:{place}"));
    let found = rest.is_some_and(|rest| rest.starts_with([':', ' ']) && rest.contains(message));
    let good = found && errors.iter().count() == 1;
    (!good).then(|| format!("{new:?} gives\n  {shown}\nand not\n  {place} … {message}"))
}

#[test]
fn base_is_valid_and_has_reference_defaults() {
    let config = parse(BASE).unwrap();
    assert_eq!(config.fusion, Fusion::default());
    assert_eq!(config.fusion.latency(), SignedDuration::from_millis(6250));
    let (sensor, radar) = config.radars().next().unwrap();
    assert_eq!((sensor.id.as_str(), sensor.period_s), ("north", None));
    assert_eq!(radar.assumed_height_amsl_m, 105.0);
    assert_eq!(radar.classification, Classification::of_octet(0));
    assert_eq!(config.output.asterix[0].ttl, 1);
    assert_eq!((config.output.status, config.output.flush_on_stop), (true, true));
    assert_eq!(config.output.max_accuracy_m, 100.0);
    assert_eq!(config.state.dir.to_str(), Some("state"));
    assert!(config.http.listen.ip().is_loopback());
}
