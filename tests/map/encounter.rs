//! Two drones fly towards each other through a closed zone in which one of them is allowed.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::service::{self, Service};

/// Both fly straight to the point between them. With this seed they meet 37 s after the start.
const SCENARIO: &str = "name = \"encounter\"\nduration_s = 240\n\
    [airspace]\nradius_m = 700\nheight_agl_m = [80, 95]\n\
    [drones]\npattern = \"crossing\"\nmultirotors = 2\nfixed_wings = 0\nequipped = 2\nseparation_m = 0\n";
const SEED: u32 = 3;

/// Meeting point: longitude and latitude, in degrees.
pub const PLACE: (f64, f64) = (-0.5716, 52.5158);
/// Radius of the zone around the meeting point, in metres.
pub const RADIUS_M: f64 = 110.0;
pub const ALLOWED: &str = "000000000001";
pub const NOT_ALLOWED: &str = "000000000002";

/// Tokens with all scopes, and for reading only. Each token is its name spelled backwards.
const TOKENS: [(&str, &str); 2] =
    [("desk", r#"["read", "stream", "control"]"#), ("guest", r#"["read", "stream"]"#)];
pub const DESK: &str = "ksed";
pub const GUEST: &str = "tseug";

/// Captures and site of the encounter, with a prohibited zone in ED-318; with `tokens` the service requires one.
pub fn fly(folder: &Path, tokens: bool) {
    let scenario = folder.join("encounter.toml");
    fs::write(&scenario, SCENARIO).unwrap();
    service::simulate_file(folder, &scenario, SEED);
    let (longitude, latitude) = PLACE;
    let properties = r#"{"identifier": "CLOSED1", "country": "GBR", "name": [{"text": "Hospital", "lang": "en-GB"}], "type": "PROHIBITED", "variant": "COMMON", "zoneAuthority": [{"purpose": "AUTHORIZATION"}]}"#;
    let geometry = format!(
        "{{\"type\": \"Point\", \"coordinates\": [{longitude}, {latitude}], \
            \"extent\": {{\"subType\": \"Circle\", \"radius\": {RADIUS_M}}}, \
            \"layer\": {{\"lower\": 0, \"lowerReference\": \"AGL\", \"upper\": 150, \"upperReference\": \"AGL\", \"uom\": \"m\"}}}}"
    );
    let zone = format!("{{\"type\": \"Feature\", \"properties\": {properties}, \"geometry\": {geometry}}}");
    let zones = format!("{{\"type\": \"FeatureCollection\", \"features\": [{zone}]}}");
    fs::write(folder.join("closed.json"), zones).unwrap();

    let site = fs::read_to_string(folder.join("site.toml")).unwrap();
    assert_eq!(site.matches("enabled = false").count(), 1, "{site}");
    let mut site = site.replace("enabled = false", "enabled = true");
    if tokens {
        let lines = TOKENS.map(|(name, scopes)| {
            let token: String = name.chars().rev().collect();
            let hash = Sha256::digest(token).iter().fold(String::new(), |mut hash, octet| {
                write!(hash, "{octet:02x}").unwrap();
                hash
            });
            format!("{name} = {{ sha256 = \"{hash}\", scopes = {scopes} }}\n")
        });
        fs::write(folder.join("tokens.toml"), lines.concat()).unwrap();
        let asks = "auth = { mode = \"tokens\", tokens_file = \"tokens.toml\" }";
        site = site.replace("auth = { mode = \"none\" }", asks);
    }
    let area = format!(
        "\n[[areas]]\nkind = \"alert\"\nfile = \"closed.json\"\nground_m = 59.0\nallow = [\"{ALLOWED}\"]\n"
    );
    fs::write(folder.join("site.toml"), site + &area).unwrap();
}

/// The encounter as a recording, paused some seconds before the warning.
pub fn paused(folder: &Path, tokens: bool) -> Service {
    fly(folder, tokens);
    let mut service = Service::replay_in("operational", folder, 0);
    service.token = tokens.then_some(DESK);
    service.order("pause");
    service.seek("09:00:05");
    service
}
