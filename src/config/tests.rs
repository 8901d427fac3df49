//! Every rule with the line, the key and the message of its violation.

use jiff::SignedDuration;

use super::*;

/// The smallest useful file; the tables below count on its line numbers.
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

/// A replacement in `BASE` and the one fault it makes: where ("line: key = value", " key" for the whole file) and a
/// part of the message.
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
fn the_base_is_valid_and_its_defaults_are_those_of_the_reference() {
    let config = parse(BASE).unwrap();
    assert_eq!(config.fusion, Fusion::default());
    assert_eq!(config.fusion.latency(), SignedDuration::from_millis(6250));
    let (sensor, radar) = config.radars().next().unwrap();
    assert_eq!((sensor.id.as_str(), sensor.period_s), ("north", None));
    assert_eq!(radar.assumed_height_amsl_m, 105.0);
    assert_eq!(radar.classification, Classification::SpecialPurpose { octet: 0 });
    assert_eq!(config.output.asterix[0].ttl, 1);
    assert_eq!((config.output.status, config.output.flush_on_stop), (true, true));
    assert_eq!(config.output.max_accuracy_m, 100.0);
    assert_eq!(config.state.dir.to_str(), Some("state"));
    assert!(config.http.listen.ip().is_loopback());
}

#[test]
fn site_and_sensors() {
    let radar = "height_amsl_m = 105";
    let with = |line: &str| format!("{radar}\n{line}");
    check(&[
        ("[site]\nname = \"test\"\nsac = 25\nsic = 1\n", "", " site", "key is missing; add [site]"),
        ("name = \"test\"\n", "", "1: site.name", "missing; add name"),
        ("name = \"test\"", "name = \" \"", "2: site.name = \" \"", "blank"),
        ("name = \"test\"", "name = 5", "2: site.name = 5", "expected text in quotes, found a whole number"),
        ("sic = 1\n", "sic = 256\n", "4: site.sic = 256", "0 to 255"),
        ("sic = 1\n", "sic = 1.0\n", "4: site.sic = 1.0", "0 to 255"),
        ("sic = 1\n", "sic = 99999999999999999999\n", "4: site.sic = 1e20", "0 to 255"),
        (
            "sic = 1\n",
            "sic = 1\ngeoid_undulation_m = 469\n",
            "5: site.geoid_undulation_m = 469",
            "-120 and 100",
        ),
        (
            "sic = 1\n",
            "sic = 1\ngeoid_undulation = 46\n",
            "5: site.geoid_undulation",
            "did you mean geoid_und",
        ),
        ("id = \"north\"\n", "", "6: sensors[0].id", "missing"),
        ("\"north\"", "\"a/b\"", "7: sensors[0].id = \"a/b\"", "letters A-Z a-z, digits, _ and -"),
        ("\"air\"", "\"\"", "17: sensors[1].id = \"\"", "blank"),
        ("\"air\"", "\"north\"", "17: sensors[1].id = \"north\"", "another sensor has this id"),
        ("\"transponder\"", "\"sonar\"", "18: sensors[1].kind = \"sonar\"", "\"radar\" or \"transponder\""),
        ("sac = 0\nsic = 0", "sac = 25\nsic = 1", "20: sensors[1].sic = 1", "service's own"),
        ("sic = 200", "sic = 1", "10: sensors[0].sic = 1", "service's own"),
        ("52.5", "152.5", "11: sensors[0].latitude_deg = 152.5", "between -90 and 90"),
        ("52.5", "nan", "11: sensors[0].latitude_deg = NaN", "between -90 and 90"),
        ("52.5", "\"52.5\"", "11: sensors[0].latitude_deg", "number without quotes"),
        ("latitude_deg = 52.5\n", "", "6: sensors[0].latitude_deg", "missing; add latitude_deg"),
        ("-0.5", "-180.5", "12: sensors[0].longitude_deg", "between -180 and 180"),
        (radar, "height_amsl_m = 9001", "13: sensors[0].height_amsl_m = 9001", "-500 and 9000"),
        (
            radar,
            &with("bearing_correction_deg = 181"),
            "14: sensors[0].bearing_correction_deg",
            "-180 and 180",
        ),
        (radar, &with("max_range_m = 0"), "14: sensors[0].max_range_m = 0", "above 0"),
        (radar, &with("assumed_height_amsl_m = 1e9"), "14: sensors[0].assumed_height_amsl_m", "20000"),
        (radar, &with("period_s = 0"), "14: sensors[0].period_s = 0", "above 0"),
        (radar, &with("period = 1"), "14: sensors[0].period", "did you mean period_s?"),
        (
            radar,
            &with("accuracy = { range_m = 0, azimuth_deg = 1 }"),
            "14: sensors[0].accuracy.range_m",
            "above 0",
        ),
        (radar, &with("accuracy = { range_m = 1 }"), "14: sensors[0].accuracy.azimuth_deg", "missing"),
        (radar, &with("accuracy = 5"), "14: sensors[0].accuracy = 5", "expected a table"),
        (radar, &with("classification = {}"), "14: sensors[0].classification.source", "missing"),
        (
            radar,
            &with("classification = { source = \"guess\" }"),
            "14: sensors[0].classification.source = \"guess\"",
            "\"special-purpose\" or",
        ),
        (
            radar,
            &with("classification = { source = \"special-purpose\", octet = 254 }"),
            "14: sensors[0].classification.octet = 254",
            "253",
        ),
        (
            radar,
            &with("classification = { source = \"constant\", value = 1.1 }"),
            "14: sensors[0].classification.value = 1.1",
            "between 0 and 1",
        ),
        (
            radar,
            &with("classification = { source = \"constant\" }"),
            "14: sensors[0].classification.value",
            "missing",
        ),
        (
            radar,
            &with("classification = { source = \"target-classification\", octet = 0 }"),
            "14: sensors[0].classification.octet",
            "unknown",
        ),
        (
            "sic = 0",
            "sic = 0\nmax_range_m = 5",
            "21: sensors[1].max_range_m = 5",
            "only a sensor of kind \"radar\" has this key",
        ),
        (
            radar,
            &with("accuracy = { range_m = 5, azimuth_deg = 1, vertical_m = 1 }"),
            "14: sensors[0].accuracy.vertical_m",
            "expected here: range_m, azimuth_deg, height_m",
        ),
    ]);
}

#[test]
fn sensors_as_a_whole() {
    let start = BASE.find("[[sensors]]").unwrap();
    let end = BASE.find("[fusion]").unwrap();
    let air = BASE.find("[[sensors]]\nid = \"air\"").unwrap();
    check(&[
        (&BASE[start..end], "", " sensors", "add [[sensors]]"),
        (&BASE[start..end], "[sensors]\n", "6: sensors", "expected a list"),
        (&BASE[start..air], "", "1: site", "without a radar the site says where its local frame begins"),
    ]);
    let more = |kind: &str, sic: u8| {
        let place = "latitude_deg = 1\nlongitude_deg = 1\nheight_amsl_m = 1\n";
        let place = if kind == "radar" { place } else { "" };
        format!("[[sensors]]\nid = \"south\"\nkind = \"{kind}\"\nsac = 25\nsic = {sic}\n{place}\n[fusion]")
    };
    check(&[(
        "[fusion]",
        &more("radar", 200),
        "26: sensors[2].sic = 200",
        "sensors[0] is already the radar with",
    )]);
    for (kind, sic) in [("radar", 201), ("transponder", 200)] {
        parse(&BASE.replace("[fusion]", &more(kind, sic))).unwrap();
    }
}

#[test]
fn lines_to_listen_on_and_to_send_to() {
    let (input, sink) = (
        r#"{ group = "239.192.48.1", port = 8048, interface = "127.0.0.1" }"#,
        "[output]\nasterix = [{ group = \"239.192.129.2\", port = 8130 }]",
    );
    let send = |entry: &str| format!("[output]\nasterix = [{{ {entry} }}]");
    for (new, key, message) in [
        (r#"{ port = 1 }"#, "", "group or address is missing"),
        (r#"{ group = "239.0.0.1", address = "127.0.0.1", port = 1 }"#, ".address", "exclude each other"),
        (r#"{ group = "127.0.0.1", port = 1 }"#, ".group", "224.0.0.0 to 239.255.255.255"),
        (r#"{ group = "radar.local", port = 1 }"#, ".group", "IPv4 address"),
        (r#"{ group = "239.0.0.1", port = 1, interface = "eth0" }"#, ".interface = \"eth0\"", "IPv4 address"),
        (r#"{ group = "239.0.0.1", port = 1, interface = "239.0.0.1" }"#, ".interface", "machine's own"),
        (
            r#"{ address = "127.0.0.1", port = 1, interface = "127.0.0.1" }"#,
            ".interface",
            "goes with a group",
        ),
        (r#"{ address = "239.0.0.1", port = 1 }"#, ".address", "write group"),
        (r#"{ address = "255.255.255.255", port = 1 }"#, ".address", "broadcast"),
        (r#"{ address = "127.0.0.1" }"#, ".port", "missing; add the UDP port"),
        (r#"{ address = "127.0.0.1", port = 0 }"#, ".port = 0", "1 to 65535"),
        (r#"{ address = "127.0.0.1", port = 65536 }"#, ".port = 65536", "1 to 65535"),
        (r#"{ address = "127.0.0.1", port = 1, source = "239.0.0.1" }"#, ".source", "one host"),
        (r#"{ address = "127.0.0.1", port = 1, ttl = 1 }"#, ".ttl", "unknown"),
        (
            r#"{ address = "127.0.0.1", port = 1, trailer_octets = 33 }"#,
            ".trailer_octets = 33",
            "at most 32 octets",
        ),
        (r#"5"#, " = 5", "expected a table"),
    ] {
        check(&[(input, new, &format!("14: sensors[0].inputs[0]{key}"), message)]);
    }
    for (entry, key, message) in [
        (r#"group = "239.0.0.1", port = 1, ttl = 256"#, ".ttl = 256", "0 to 255"),
        (r#"address = "0.0.0.0", port = 1"#, ".address", "nothing can be sent"),
        (r#"address = "127.0.0.1", port = 1, category = 48"#, ".category = 48", "129 or 62"),
        (r#"address = "127.0.0.1", port = 1, category = "62""#, ".category", "a whole number without quotes"),
        (r#"group = "239.0.0.1", port = 1, source = "127.0.0.1""#, ".source", "unknown"),
    ] {
        check(&[(sink, &send(entry), &format!("26: output.asterix[0]{key}"), message)]);
    }
}

#[test]
fn fusion_rules() {
    let slot = "slot_s = 0.25";
    for (new, place, message) in [
        ("profile = \"best\"", "23: fusion.profile = \"best\"", "use \"operational\" or \"reference\""),
        ("motion = \"kalman\"", "23: fusion.motion = \"kalman\"", "use \"imm\" or \"singer\""),
        ("motion = 1", "23: fusion.motion = 1", "expected text in quotes"),
        ("slot_s = 0", "23: fusion.slot_s = 0", "whole number of milliseconds"),
        ("slot_s = 0.0005", "23: fusion.slot_s", "whole number of milliseconds"),
        ("slot_s = -1", "23: fusion.slot_s", "whole number of milliseconds"),
        (
            "slot_s = 0.5",
            "23: fusion.slot_s = 0.5",
            "latency_s is a whole number of slots (slot_s = 0.5), and 6.25",
        ),
        ("latency_s = 6.3", "23: fusion.latency_s = 6.3", "set it to 6.25 or 6.5"),
        ("latency_s = 0\nprofile = \"reference\"", "23: fusion.latency_s = 0", "at least one slot"),
        ("now = true\nprofile = \"reference\"", "23: fusion.now = true", "no picture of now"),
        ("now = 1", "23: fusion.now = 1", "true or false"),
        ("latency_s = 25", "23: fusion.latency_s = 25", "shorter than window_s"),
        ("window_s = 6.25", "23: fusion.window_s = 6.25", "shorter than window_s"),
        ("window_s = 25.1", "23: fusion.window_s", "whole number of slots"),
        ("window_s = 30.75", "23: fusion.window_s", "at most 126 slots, here 31.5 seconds"),
        ("slot_s = 0.125", "23: fusion.slot_s", "at most 126 slots, here 15.75 seconds"),
        ("suppress_s = 0.1", "23: fusion.suppress_s", "whole number of slots"),
        ("suppress_s = 25.25", "23: fusion.suppress_s", "at most window_s"),
        ("max_future_s = 6.5", "23: fusion.max_future_s", "at most latency_s"),
        ("max_future_s = -1", "23: fusion.max_future_s", "at least 0"),
        ("latency_s = 0.75\nmax_future_s = 1", "24: fusion.max_future_s", "at most latency_s"),
        ("max_gap_s = 0", "23: fusion.max_gap_s", "above 0"),
        ("max_gap_s = inf", "23: fusion.max_gap_s", "at most 86400"),
        ("threshold_m = []", "23: fusion.threshold_m = []", "no row"),
        ("threshold_m = [[1, 2],\n [1, 3]]", "24: fusion.threshold_m[1] = [1, 3]", "rise from row to row"),
        ("threshold_m = [[0, 0]]", "23: fusion.threshold_m[0][1] = 0", "above 0"),
        ("threshold_m = [[-1, 2]]", "23: fusion.threshold_m[0][0]", "at least 0"),
        ("threshold_m = [[1, 2, 3]]", "23: fusion.threshold_m[0] = [1, 2, 3]", "a row is [slant range"),
        ("threshold_m = 60", "23: fusion.threshold_m = 60", "expected a list"),
        ("ratio_min = 0", "23: fusion.ratio_min = 0", "above 0 and at most 1"),
        ("ratio_min = 1.01", "23: fusion.ratio_min", "above 0 and at most 1"),
        ("min_samples = 0", "23: fusion.min_samples = 0", "at least 1"),
        ("min_samples = 101", "23: fusion.min_samples = 101", "at most the slots of window_s"),
        ("weight_radar = -1", "23: fusion.weight_radar = -1", "at least 0"),
        (
            "weight_radar = 0\nweight_transponder = 0",
            "24: fusion.weight_transponder = 0",
            "both weights are 0",
        ),
        ("radar_only_min_s = -1", "23: fusion.radar_only_min_s", "between 0 and 86400"),
        ("transponder_numbers = { A = 0 }", "23: fusion.transponder_numbers.A = 0", "1 to 429496"),
        ("transponder_numbers = { A = 429497 }", "23: fusion.transponder_numbers.A", "1 to 429496"),
        (
            "transponder_numbers = { A = 1, B = 1 }",
            "23: fusion.transponder_numbers.B = 1",
            "A has this number",
        ),
        ("transponder_numbers = { \" \" = 1 }", "23: fusion.transponder_numbers.\" \"", "serial is blank"),
        (
            "transponder_numbers = { A = 1, \"A \" = 2 }",
            "23: fusion.transponder_numbers.\"A \"",
            "there twice",
        ),
        (
            "transponder_numbers = { A234567890123 = 1 }",
            "23: fusion.transponder_numbers.A234567890123",
            "12 octets",
        ),
        ("latency = 5", "23: fusion.latency", "did you mean latency_s?"),
        ("ratoi_min = 1", "23: fusion.ratoi_min", "did you mean ratio_min?"),
        ("colour = 1", "23: fusion.colour", "unknown; expected here: profile, motion, slot_s, latency_s"),
    ] {
        check(&[(slot, new, place, message)]);
    }
    let operational = parse(&BASE.replace(slot, "profile = \"operational\"")).unwrap();
    assert_eq!(operational.fusion.profile, Profile::Operational);
    assert_eq!(operational.fusion.motion, Motion::Imm);
    let singer = parse(&BASE.replace(slot, "motion = \"singer\"")).unwrap();
    assert_eq!(singer.fusion.motion, Motion::Singer);
    assert!(singer.to_string().contains("\nmotion = \"singer\"\n"));
    let trimmed = parse(&BASE.replace(slot, "transponder_numbers = { \" DRONE 1 \" = 429496 }")).unwrap();
    assert_eq!(trimmed.fusion.transponder_numbers["DRONE 1"], 429_496);
}

#[test]
fn output_http_state_and_areas() {
    let (output, listen) = ("[output]", "listen = \"127.0.0.1:8080\"");
    let under = |line: &str| format!("{output}\n{line}");
    let end = |line: &str| format!("{listen}\n{line}");
    for (old, new, place, message) in [
        (output, under("serial = \"uav\""), "26: output.serial = \"uav\"", "\"uas\" or \"track-number\""),
        (output, under("status = \"yes\""), "26: output.status = \"yes\"", "true or false, without quotes"),
        (output, under("flush_on_stop = 1"), "26: output.flush_on_stop = 1", "true or false"),
        (
            output,
            under("max_accuracy_m = 0.5"),
            "26: output.max_accuracy_m = 0.5",
            "a radius of 1 to 10000 metres",
        ),
        (output, under("max_accuracy_m = 10001"), "26: output.max_accuracy_m = 10001", "1 to 10000"),
        (output, under("record = {}"), "26: output.record.dir", "missing"),
        (
            output,
            under("record = { dir = \"r\", rotate_mib = 0 }"),
            "26: output.record.rotate_mib = 0",
            "1 to",
        ),
        (output, under("record = { dir = \"r\", keep = 0 }"), "26: output.record.keep = 0", "1 to"),
        (listen, "listen = \"localhost:80\"".into(), "29: http.listen", "such as \"127.0.0.1:8080\""),
        (listen, "listen = \"0.0.0.0:80\"".into(), "29: http.listen = \"0.0.0.0:80\"", "mode = \"tokens\""),
        (
            listen,
            end("auth = { mode = \"basic\" }"),
            "30: http.auth.mode = \"basic\"",
            "\"none\" or \"tokens\"",
        ),
        (listen, end("auth = {}"), "30: http.auth.mode", "missing"),
        (listen, end("auth = { mode = \"tokens\" }"), "30: http.auth.tokens_file", "missing"),
        (
            listen,
            end("auth = { mode = \"none\", tokens_file = \"t\" }"),
            "30: http.auth.tokens_file = \"t\"",
            "nobody reads",
        ),
        (listen, end("tiles = {}"), "30: http.tiles.url", "missing"),
        (
            listen,
            end("tiles = { url = \"https://a.example/{z}/{x}.png\" }"),
            "30: http.tiles.url",
            "{z}, {x} and {y}",
        ),
        (
            listen,
            end("tiles = { url = \"https://*.example/{z}/{x}/{y}.png\" }"),
            "30: http.tiles.url",
            "https://host/…",
        ),
        (listen, end("cors = [\"*\"]"), "30: http.cors[0] = \"*\"", "an origin is"),
        (listen, end("requests_per_s = -1"), "30: http.requests_per_s = -1", "0 (no limit) to"),
        (listen, end("requests_burst = 0"), "30: http.requests_burst = 0", "1 to 1000000"),
        (
            listen,
            end("requests_per_s = 0\nrequests_burst = 9"),
            "31: http.requests_burst = 9",
            "there is no limit; remove this key",
        ),
        (listen, end("cors = [\"https://a/b\"]"), "30: http.cors[0] = \"https://a/b\"", "an origin is"),
        (
            listen,
            end("connections_per_address = -1"),
            "30: http.connections_per_address = -1",
            "0 (no limit) to",
        ),
        (listen, end("tls = { key = \"k\" }"), "30: http.tls.certificate", "missing"),
        (listen, end("hosts = [\"Fusion:80\"]"), "30: http.hosts[0] = \"Fusion:80\"", "a name in lower case"),
        (listen, end("hosts = [\"10.0.0.1\"]"), "30: http.hosts[0] = \"10.0.0.1\"", "accepted anyway"),
        (
            listen,
            end("trusted_proxies = [\"proxy\"]"),
            "30: http.trusted_proxies[0] = \"proxy\"",
            "names are not looked up",
        ),
        (
            listen,
            end("trusted_proxies = [\"10.1.0.0/8\"]"),
            "30: http.trusted_proxies[0] = \"10.1.0.0/8\"",
            "the network is \"10.0.0.0/8\"",
        ),
        (listen, end("[state]\ndir = \"\""), "31: state.dir = \"\"", "blank"),
        (listen, end("[stat]\ndir = \"x\""), "30: stat", "did you mean state?"),
        (listen, end("[[areas]]\nkind = \"mask\""), "30: areas[0].file", "missing"),
        (
            listen,
            end("[[areas]]\nkind = \"wall\"\nfile = \"Cargo.toml\""),
            "31: areas[0].kind",
            "\"mask\" or",
        ),
        (
            listen,
            end("[[areas]]\nkind = \"alert\"\nfile = \"no.geojson\""),
            "32: areas[0].file",
            "there is no file",
        ),
        (
            listen,
            end("[[areas]]\nkind = \"coverage\"\nfile = \"Cargo.toml\""),
            "30: areas[0].sensor",
            "missing",
        ),
        (
            listen,
            end("[[areas]]\nkind = \"coverage\"\nfile = \"Cargo.toml\"\nsensor = \"east\""),
            "33: areas[0].sensor = \"east\"",
            "the sensors are: north, air",
        ),
        (
            listen,
            end("[[areas]]\nkind = \"mask\"\nfile = \"Cargo.toml\"\nsensor = \"north\""),
            "33: areas[0].sensor",
            "only an area of kind = \"coverage\"",
        ),
        (listen, "listen = ".into(), "29", "this is not TOML"),
        (listen, end(listen), "30", "this is not TOML: duplicate key"),
    ] {
        check(&[(old, &new, place, message)]);
    }
    let open = parse(&BASE.replace(listen, "listen = \"[::]:80\"\nauth = { mode = \"tokens\", tokens_file = \"/etc/tokens\" }\ncors = [\"https://a.example:8443\"]")).unwrap();
    assert_eq!(open.http.auth, Auth::Tokens { tokens_file: "/etc/tokens".into() });
    assert_eq!(open.http.cors, ["https://a.example:8443"]);
    assert_eq!(open.http.limit(), Some(RateLimit { requests_per_s: 50, burst: 200 }));
    let limit = |keys: &str| parse(&BASE.replace(listen, keys)).unwrap().http.limit();
    assert_eq!(limit("requests_per_s = 3"), Some(RateLimit { requests_per_s: 3, burst: 12 }));
    assert_eq!(limit("requests_burst = 7"), Some(RateLimit { requests_per_s: 50, burst: 7 }));
    assert_eq!(limit("requests_per_s = 0"), None);
    assert_eq!(open.http.connections_per_address, std::num::NonZeroU32::new(64));
    let door = "connections_per_address = 0\ntls = { certificate = \"/c.pem\", key = \"/k.pem\" }\nhosts = [\"fusion.example\"]\ntrusted_proxies = [\"127.0.0.1\", \"10.0.0.0/8\"]";
    let door = parse(&BASE.replace(listen, &end(door))).unwrap();
    assert_eq!(
        (door.http.connections_per_address, &*door.http.hosts),
        (None, &["fusion.example".to_owned()][..])
    );
    assert_eq!(
        door.http.trusted_proxies.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["127.0.0.1", "10.0.0.0/8"]
    );
    assert_eq!(parse(&door.to_string()).unwrap(), door);
    let tiles = "tiles = { url = \"https://t.example:8443/a/{z}/{x}/{y}.png\" }";
    let tiles = parse(&BASE.replace(listen, &format!("{listen}\n{tiles}"))).unwrap().http.tiles.unwrap();
    assert_eq!(tiles.origin(), "https://t.example:8443");
    assert_eq!(parse(&open.to_string()).unwrap(), open);
}

#[test]
fn connections() {
    let kind = "kind = \"transponder\"";
    let with =
        |kind: &str, connection: &str| format!("kind = \"{kind}\"\nconnections = [{{ {connection} }}]");
    let adsb = |address: &str| with("adsb", &format!("format = \"beast\", address = \"{address}\""));
    let mqtt = |rest: &str| with("remote-id", &format!("format = \"mqtt\", address = {rest}"));
    let mavlink = |systems: &str| {
        with(
            "transponder",
            &format!("format = \"mavlink\", address = \"0.0.0.0:14550\", systems = [{systems}]"),
        )
    };
    let drone = "{ system_id = 1, serial_number = \"A\" }";
    for (text, message) in [
        (
            with("transponder", "format = \"avr\", address = \"127.0.0.1:1\""),
            "belongs to a sensor with kind = \"adsb\"",
        ),
        (with("adsb", "format = \"sbs\", address = \"127.0.0.1:1\""), "\"beast\""),
        (adsb("127.0.0.1"), "an IPv4 address and a port"),
        (adsb("0.0.0.0:30005"), "nothing can be connected to"),
        (mqtt("\"127.0.0.1:1883\""), "mqtt://host:port"),
        (mqtt("\"mqtt://user:word@host\""), "keys of their own"),
        (mqtt("\"mqtt://host\", password_env = \"X\""), "belongs to a username"),
        (mqtt("\"mqtt://host\", ca = \"a.pem\""), "without TLS"),
        (
            with("adsb", "format = \"avr\", address = \"127.0.0.1:1\", topic = \"a\""),
            "only a connection with format = \"mqtt\"",
        ),
        (with("remote-id", "format = \"mqtt\""), "this key is missing"),
        (with("remote-id", "format = \"http\", address = \"127.0.0.1:8080\""), "where http.listen says"),
        (with("remote-id", "format = \"http\", topic = \"a\""), "only a connection with format = \"mqtt\""),
        (with("adsb", "format = \"http\""), "belongs to a sensor with kind = \"remote-id\""),
        (mavlink(""), "no drone would be known"),
        (mavlink(&format!("{drone}, {drone}")), "the same system_id"),
        (mavlink("{ system_id = 0, serial_number = \"A\" }"), "1 to 255"),
        (mavlink("{ system_id = 1, serial_number = \"1234567890123\" }"), "1 to 12 printable"),
        (mavlink("{ system_id = 1, serial_number = \"A\", country = \"nl\" }"), "two capital letters"),
    ] {
        let errors = parse(&BASE.replace(kind, &text)).unwrap_err();
        let shown = errors.to_string();
        assert_eq!(errors.iter().count(), 1, "{shown}");
        assert!(shown.contains("sensors[1].connections") && shown.contains(message), "{text}: {shown}");
    }
    let http = with("remote-id", "format = \"http\"");
    for text in
        [adsb("127.0.0.1:30005"), http, mqtt("\"mqtts://[::1]:8884/\", ca = \"a.pem\""), mavlink(drone)]
    {
        let config = parse(&BASE.replace(kind, &text)).unwrap();
        let again = parse(&config.to_string()).unwrap();
        assert_eq!(again.sensors, config.sensors, "what is shown reads back");
    }
    let broker = |address: &str| {
        let connection = Connection { address: address.to_owned(), ..Connection::default() };
        connection.broker().map(|broker| (broker.host, broker.port, broker.tls))
    };
    assert_eq!(broker("mqtt://a.example"), Some(("a.example".to_owned(), 1883, false)));
    assert_eq!(broker("mqtts://10.0.0.1"), Some(("10.0.0.1".to_owned(), 8883, true)));
    assert_eq!(broker("mqtts://[::1]:8884/"), Some(("[::1]".to_owned(), 8884, true)));
    assert_eq!(["mqtt://", "mqtt://a:0", "mqtt://a:x", "http://a"].map(broker), [None, None, None, None]);
}
