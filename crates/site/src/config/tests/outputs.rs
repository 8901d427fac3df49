//! Tests of UDP endpoints, outputs, the HTTP server, state and areas.

use super::*;

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
            under("record = { dir = \"r\", keep_hours = -1 }"),
            "26: output.record.keep_hours = -1",
            "recordings are kept for a whole number of hours",
        ),
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
