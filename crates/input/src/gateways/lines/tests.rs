use asterix::blocks;
use fusion::report::Plot;
use proptest::prelude::*;
use site::areas::Masks;

use super::*;
use crate::normalise::Normaliser;

const NOON: Time = Time::from_nanos(1_800_014_400_000_000_000);

/// A site whose only sensor has this kind and connection.
fn site(kind: &str, connection: &str) -> Config {
    let place = "latitude_deg = 52.0\nlongitude_deg = 4.0\nheight_amsl_m = 20.0\n";
    let (of_site, of_sensor) = if kind == "radar" { ("", place) } else { (place, "") };
    let text = format!(
        "[site]\nname = \"t\"\nsac = 70\nsic = 1\n{of_site}\
         [[sensors]]\nkind = \"{kind}\"\nid = \"s\"\nsac = 70\nsic = 2\n{of_sensor}\
         connections = [{{ address = \"127.0.0.1:15000\", {connection} }}]\n"
    );
    Config::parse(&text, "site.toml", std::iter::empty()).unwrap()
}

fn translator(config: &Config) -> LineTranslator {
    LineTranslator::new(config, 0, &config.sensors[0].connections[0]).unwrap()
}

/// The plot that a radar's line becomes.
fn plot(fields: &str, line: &str) -> Plot {
    let config = site("radar", &format!("format = \"json\", fields = {{ track = \"id\", {fields} }}"));
    let datagram = translator(&config).line(line.as_bytes(), NOON).unwrap();
    let record = record::<cat048::Record>(&datagram);
    Normaliser::new(&config, Masks::default()).plot(&record, NOON).unwrap()
}

fn record<R: asterix::Record<Edition = ()>>(datagram: &[u8]) -> R {
    blocks(datagram).next().unwrap().unwrap().records::<R>().next().unwrap().unwrap().record
}

/// The same target in polar, local and geodetic form, and in other units and axes.
#[test]
fn position_is_the_same_in_every_form() {
    let (range_m, azimuth_deg, elevation_deg): (f64, f64, f64) = (3000.0, 30.0, 4.0);
    let ground_m = range_m * elevation_deg.to_radians().cos();
    let up_m = range_m * elevation_deg.to_radians().sin();
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let (east_m, north_m) = (ground_m * sin, ground_m * cos);
    let config =
        site("radar", "format = \"json\", fields = { track = \"id\", range = \"r\", azimuth = \"a\" }");
    let SensorKind::Radar(radar) = &config.sensors[0].kind else { panic!() };
    let undulation_m = undulation_m(&config);
    let place = RadarPlace::new(radar, undulation_m).frame.to_geodetic(Enu::new(east_m, north_m, up_m));
    let amsl_m = place.height_m - undulation_m;
    let (latitude_deg, longitude_deg) = (place.latitude_deg(), place.longitude_deg());
    let (range_km, azimuth, elevation) =
        (range_m / 1000.0, azimuth_deg.to_radians(), elevation_deg.to_radians());
    let south_ft = -north_m / 0.3048;
    let forms = [
        (
            r#"range = "r", azimuth = "a", elevation = "e""#,
            format!(r#"{{"id": 7, "r": {range_m}, "a": {azimuth_deg}, "e": {elevation_deg}}}"#),
        ),
        (
            r#"range = "p.r km", azimuth = "p.a rad", elevation = "-p.down rad""#,
            format!(r#"{{"id": "7", "p": {{"r": "{range_km}", "a": {azimuth}, "down": -{elevation}}}}}"#),
        ),
        (
            r#"range = "r", azimuth = "a", height = "h ft""#,
            format!(r#"{{"id": 7, "r": {range_m}, "a": {azimuth_deg}, "h": {}}}"#, amsl_m / 0.3048),
        ),
        (
            r#"east = "x", north = "-y ft", up = "z""#,
            format!(r#"{{"id": 7, "x": {east_m}, "y": {south_ft}, "z": {up_m}}}"#),
        ),
        (
            r#"latitude = "lat", longitude = "lon", height = "h""#,
            format!(r#"{{"id": 7, "lat": {latitude_deg}, "lon": {longitude_deg}, "h": {amsl_m}}}"#),
        ),
    ];
    for (fields, line) in forms {
        let plot = plot(fields, &line);
        let off = [plot.position.east() - east_m, plot.position.north() - north_m, plot.position.up() - up_m];
        // Steps of I048/040 and I048/110: 7.2 m, 0.0055 degrees, 25 ft.
        assert!(off.iter().all(|off| off.abs() < 4.5), "{fields}: {off:?}");
        assert_eq!((plot.track.number, plot.height_measured, plot.time), (7, true, NOON), "{fields}");
    }
}

#[test]
fn time_velocity_and_class_are_read() {
    let fields = r#"range = "r", azimuth = "a", time = "t ms", speed = "v km/h", course = "c", class = "k""#;
    let config = site(
        "radar",
        &format!("format = \"json\", drone_classes = [\"uav\"], fields = {{ track = \"id\", {fields} }}"),
    );
    let mut translator = translator(&config);
    let mut read = |class: &str| {
        let line = format!(
            r#"{{"id": 9, "r": 900, "a": -90, "t": 1800014399500, "v": 36, "c": 90, "k": "{class}"}}"#
        );
        record::<cat048::Record>(&translator.line(line.as_bytes(), NOON).unwrap())
    };
    let record = read("uav");
    assert!((record.polar_position.unwrap().azimuth_deg() - 270.0).abs() < 0.01);
    assert_eq!(record.time_of_day.unwrap().count(), 43_199 * 128 + 64);
    let velocity = record.track_velocity.unwrap();
    assert!((velocity.speed_m_s() - 10.0).abs() < 0.1 && (velocity.heading_deg() - 90.0).abs() < 0.01);
    assert_eq!(record.special_purpose.unwrap().contents(), [255]);
    assert_eq!(record.height_3d, None);
    assert_eq!(read("bird").special_purpose.unwrap().contents(), [0]);
}

#[test]
fn columns_become_a_transponders_report() {
    let config = site(
        "transponder",
        "format = \"csv\", columns = [\"t\", \"sn\", \"lat\", \"lon\", \"alt\"], fields = { time = \"t\", \
         serial_number = \"sn\", latitude = \"lat\", longitude = \"lon\", height = \"alt ft\" }",
    );
    let mut translator = translator(&config);
    let line = br#"2027-01-15T12:00:00.25Z, "1581F4BND23500001234", 52.5, -4.25, 1000"#;
    let record = record::<cat129::Record>(&translator.line(line, NOON).unwrap());
    assert_eq!(record.serial_number, Some(*b"F4BND23500001234".last_chunk().unwrap()));
    let whole = WholeSerial::read(&record.special_purpose.unwrap()).unwrap();
    assert_eq!(whole.octets(), b"1581F4BND23500001234");
    let position = record.position.unwrap();
    assert!((position.latitude_deg() - 52.5).abs() < 1e-6 && (position.longitude_deg() + 4.25).abs() < 1e-6);
    assert!((record.altitude_amsl.unwrap().metres() - 304.8).abs() < 0.1);
}

#[test]
fn invalid_line_is_dropped_by_its_reason() {
    let config = site(
        "radar",
        "format = \"json\", fields = { track = \"id\", range = \"r\", azimuth = \"a\", time = \"t\", probability = \"p %\" }",
    );
    let mut translator = translator(&config);
    for (line, reason) in [
        ("", None),
        (r#"{"id": 1, "r": 100, "a": 1, "t": 1800014400}"#, None),
        (r#"{"id": 1, "r": 100, "a": 1, "t": "2027-01-15T12:00:00+01:00", "p": 100, "other": [1]}"#, None),
        ("nonsense", Some(LineDropReason::NotAnObject)),
        ("[1]", Some(LineDropReason::NotAnObject)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": 1800014400"#, Some(LineDropReason::NotAnObject)),
        (r#"{"id": 1, "a": 1, "t": 1800014400}"#, Some(LineDropReason::Value)),
        (r#"{"id": 1, "r": "far", "a": 1, "t": 1800014400}"#, Some(LineDropReason::Value)),
        (r#"{"id": 1, "r": "inf", "a": 1, "t": 1800014400}"#, Some(LineDropReason::Value)),
        (r#"{"id": 1, "r": null, "a": 1, "t": 1800014400}"#, Some(LineDropReason::Value)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": 1800014400, "p": "x"}"#, Some(LineDropReason::Value)),
        (r#"{"id": 1, "r": 100, "a": 1}"#, Some(LineDropReason::Time)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": "noon"}"#, Some(LineDropReason::Time)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": 1e300}"#, Some(LineDropReason::Time)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": "2027-01-14T12:00:00Z"}"#, Some(LineDropReason::Time)),
        (r#"{"id": "", "r": 100, "a": 1, "t": 1800014400}"#, Some(LineDropReason::Name)),
        (r#"{"id": 1, "r": -5, "a": 1, "t": 1800014400}"#, Some(LineDropReason::OutOfRange)),
        (r#"{"id": 1, "r": 1e9, "a": 1, "t": 1800014400}"#, Some(LineDropReason::OutOfRange)),
        (r#"{"id": 1, "r": 100, "a": 1, "t": 1800014400, "p": 101}"#, Some(LineDropReason::OutOfRange)),
        (&format!(r#"{{"id": "{}"}}"#, "x".repeat(LINE_MAX)), Some(LineDropReason::TooLong)),
    ] {
        let before = translator.dropped().clone();
        // The lines before and after are translated.
        let good = r#"{"id": 2, "r": 100, "a": 1, "t": 1800014400}"#;
        let mut count = 0;
        translator.take(format!("{good}\r\n{line}\n{good}").as_bytes(), NOON, |_| count += 1);
        let is_line = reason.is_none() && !line.is_empty();
        assert_eq!(count, 2 + usize::from(is_line), "{line:.80}");
        let dropped: Vec<usize> = (0..REASONS.len())
            .filter(|&reason| translator.dropped().of(reason) > before.of(reason))
            .collect();
        assert_eq!(
            dropped,
            reason.map(|reason| reason as usize).into_iter().collect::<Vec<_>>(),
            "{line:.80}"
        );
    }
}

proptest! {
    #[test]
    fn any_octets_are_translated_or_counted(octets in proptest::collection::vec(any::<u8>(), 0..200)) {
        let radar = site("radar", "format = \"csv\", columns = [\"a\", \"b\", \"c\"], fields = { track = \"a\", east = \"b\", north = \"c\" }");
        let mut translator = translator(&radar);
        let mut count = 0;
        translator.take(&octets, NOON, |_| count += 1);
        prop_assert_eq!(count + translator.dropped().total(), lines(&octets).count() as u64);
    }

    #[test]
    fn any_numbers_are_translated_or_counted(values in proptest::array::uniform4(any::<f64>()), id in "[0-9a-z,{}\"]{0,6}") {
        let radar = site("radar", "format = \"json\", fields = { track = \"id\", latitude = \"a\", longitude = \"b\", height = \"c\", speed = \"d\", course = \"a\" }");
        let mut translator = translator(&radar);
        let [a, b, c, d] = values;
        let line = serde_json::json!({ "id": id, "a": a, "b": b, "c": c, "d": d }).to_string();
        let mut count = 0;
        translator.take(line.as_bytes(), NOON, |datagram| {
            let block = blocks(&datagram).next().unwrap().unwrap();
            assert!(block.records::<cat048::Record>().all(|record| record.is_ok()));
            count += 1;
        });
        prop_assert_eq!(count + translator.dropped().total(), 1);
    }
}
