//! Tests of the site, the sensors and their connections.

use super::*;

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
            &with("classification = { source = \"special-purpose\", scale = 2.0 }"),
            "14: sensors[0].classification.scale = 2.0",
            "between -1 and 1",
        ),
        (
            radar,
            &with("classification = { source = \"special-purpose-category\", octet = 1 }"),
            "14: sensors[0].classification.drones",
            "missing",
        ),
        (
            radar,
            &with("classification = { source = \"special-purpose-category\", drones = [] }"),
            "14: sensors[0].classification.drones",
            "no target would be a drone",
        ),
        (
            radar,
            &with("classification = { source = \"special-purpose-category\", drones = [20], scale = 0.01 }"),
            "14: sensors[0].classification.scale",
            "unknown",
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
    const FIELDS: &str =
        "fields = { serial_number = \"sn\", latitude = \"lat\", longitude = \"lon\", height = \"alt ft\" }";
    let json_at = |address: &str, rest: &str| {
        with("transponder", &format!("format = \"json\", address = \"{address}\", {rest}"))
    };
    let lines = |format: &str, rest: &str| {
        with("transponder", &format!("format = \"{format}\", address = \"0.0.0.0:15129\", {rest}"))
    };
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
            "only a connection to a broker",
        ),
        (with("remote-id", "format = \"mqtt\""), "this key is missing"),
        (with("remote-id", "format = \"http\", address = \"127.0.0.1:8080\""), "where http.listen says"),
        (with("remote-id", "format = \"http\", topic = \"a\""), "only a connection to a broker"),
        (with("adsb", "format = \"http\""), "belongs to a sensor with kind = \"remote-id\""),
        (mavlink(""), "no drone would be known"),
        (
            with("adsb", &format!("format = \"mavlink\", address = \"0.0.0.0:14550\", systems = [{drone}]")),
            "remove systems",
        ),
        (mavlink(&format!("{drone}, {drone}")), "the same system_id"),
        (mavlink("{ system_id = 0, serial_number = \"A\" }"), "1 to 255"),
        (mavlink("{ system_id = 1, serial_number = \"123456789012345678901\" }"), "1 to 20 printable"),
        (mavlink("{ system_id = 1, serial_number = \"A\", country = \"nl\" }"), "two capital letters"),
        (lines("json", ""), "add fields = { … }"),
        (json_at("mqtt://127.0.0.1", FIELDS), "where the sensor publishes its lines"),
        (json_at("127.0.0.1:15129", &format!("topic = \"a\", {FIELDS}")), "only a connection to a broker"),
        (json_at("mqtt://", &format!("topic = \"a\", {FIELDS}")), "a broker is mqtt://host:port"),
        (lines("csv", FIELDS), "columns = [\"time\", …]"),
        (lines("csv", &format!("columns = [\"sn\", \"lat\"], {FIELDS}")), "names none of the columns"),
        (lines("json", &format!("columns = [\"sn\"], {FIELDS}")), "only a connection with format = \"csv\""),
        (lines("json", &FIELDS.replace("alt ft", "alt deg")), "a name, and m, km, ft or NM"),
        (lines("json", &FIELDS.replace(", height = \"alt ft\"", "")), "fields.height is missing"),
        (lines("json", &FIELDS.replace("serial_number", "track")), "a transponder has no fields.track"),
        (lines("json", &FIELDS.replace("latitude = \"lat\", ", "")), "needs both latitude and longitude"),
        (lines("json", &FIELDS.replace("{", "{ speed = \"v\",")), "speed and course go together"),
        (lines("json", &format!("drone_classes = [\"a\"], {FIELDS}")), "class and drone_classes go together"),
        (
            with("adsb", &format!("format = \"json\", address = \"127.0.0.1:15129\", {FIELDS}")),
            "belongs to a sensor",
        ),
    ] {
        let errors = parse(&BASE.replace(kind, &text)).unwrap_err();
        let shown = errors.to_string();
        assert_eq!(errors.iter().count(), 1, "{shown}");
        assert!(shown.contains("sensors[1].connections") && shown.contains(message), "{text}: {shown}");
    }
    let http = with("remote-id", "format = \"http\"");
    let heard = with("remote-id", "format = \"mavlink\", address = \"0.0.0.0:14550\"");
    for text in [
        adsb("127.0.0.1:30005"),
        http,
        mqtt("\"mqtts://[::1]:8884/\", ca = \"a.pem\""),
        mavlink(drone),
        heard,
        lines("json", FIELDS),
        json_at("mqtt://127.0.0.1", &format!("topic = \"radars/hill\", username = \"fusion\", {FIELDS}")),
        lines("csv", &format!("columns = [\"sn\", \"lat\", \"lon\", \"alt\"], {FIELDS}")),
    ] {
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
