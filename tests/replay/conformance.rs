//! Compares every point with an independent implementation of the `reference` profile.

use std::collections::BTreeMap;
use std::fs;

use asterix::cat129::fusion_report::{Deviation, Flags, Source, UavProbability};
use asterix::cat129::{self, FusionReport};
use asterix::{DataSource, blocks, cat048};
use utm_fusion::config::{Classification, Config, Sensor, SensorKind};
use utm_fusion::normalise::nearest_day;
use utm_fusion::pipeline::Tally;

use super::common::{Flight, SLOT_NS, bundled, contents, fly, ran, three_radars, trials};

/// Slots in a day.
const DAY_SLOTS: i64 = 86_400 * 4;
/// Number of time-of-day counts in a slot.
const SLOT_COUNTS: i64 = 32;

/// An output point.
#[derive(Clone, Debug)]
struct Point {
    key: Key,
    latitude_deg: f64,
    longitude_deg: f64,
    altitude_amsl_m: Option<f64>,
}

/// Slot, kind, number, radar track and transponder.
type Key = (i64, String, u32, Option<u16>, Option<u32>);

impl Point {
    /// `kind,number,radar_track,transponder,lat,lon,alt_msl`.
    fn of_columns(slot: i64, columns: &[&str]) -> Self {
        let &[kind, number, radar_track, transponder, lat, lon, alt_msl] = columns else {
            panic!("{columns:?}");
        };
        let key = (
            slot,
            kind.to_owned(),
            number.parse().unwrap(),
            (!radar_track.is_empty()).then(|| radar_track.parse().unwrap()),
            (!transponder.is_empty()).then(|| transponder.parse().unwrap()),
        );
        Self {
            key,
            latitude_deg: lat.parse().unwrap(),
            longitude_deg: lon.parse().unwrap(),
            altitude_amsl_m: (!alt_msl.is_empty()).then(|| alt_msl.parse().unwrap()),
        }
    }

    /// `slot,time,kind,…`.
    fn of_expected(line: &str) -> Self {
        let columns: Vec<_> = line.split(',').collect();
        Self::of_columns(columns[0].parse().unwrap(), &columns[2..])
    }

    /// `time,id,source,…,flags`; the time is the centre of a slot.
    fn of_csv(line: &str) -> Self {
        let columns: Vec<_> = line.split(',').collect();
        let slots = columns[0].parse::<f64>().unwrap() * 4.0;
        assert_eq!(slots.fract(), 0.5, "{line}");
        Self::of_columns(slots as i64, &columns[2..9])
    }

    /// A record has no day, so the day of slot `near` is used.
    fn of_record(record: &cat129::Record, report: &FusionReport, near: i64) -> Self {
        let count = i64::from(record.time_of_day.unwrap().count());
        assert_eq!(count % SLOT_COUNTS, SLOT_COUNTS / 2, "a time is a slot's centre");
        let slot = near - near.rem_euclid(DAY_SLOTS) + count / SLOT_COUNTS;
        let kind = match report.source {
            Source::Fused => "fused",
            Source::Radar => "radar",
            Source::Transponder => "transponder",
            Source::Camera => "camera",
        };
        let position = record.position.unwrap();
        Self {
            key: (slot, kind.to_owned(), report.track_number, report.radar_track, report.transponder),
            latitude_deg: position.latitude_deg(),
            longitude_deg: position.longitude_deg(),
            altitude_amsl_m: record.altitude_amsl.map(cat129::Altitude::metres),
        }
    }
}

fn expected(flight: &Flight) -> Vec<Point> {
    let text = String::from_utf8(fs::read(flight.path("expected.csv")).unwrap()).unwrap();
    text.lines().skip(1).map(Point::of_expected).collect()
}

/// Checks that the points are the same, in the same order, with positions within these distances.
fn assert_agree(name: &str, got: &[Point], expected: &[Point], horizontal_m: f64, vertical_m: f64) {
    for (got, expected) in got.iter().zip(expected) {
        assert_eq!(got.key, expected.key, "{name}");
        let metres = |degrees: f64| degrees.to_radians() * 6_371_000.0;
        let north = metres(got.latitude_deg - expected.latitude_deg);
        let east =
            metres(got.longitude_deg - expected.longitude_deg) * expected.latitude_deg.to_radians().cos();
        assert!(north.hypot(east) <= horizontal_m, "{name}: {got:?} is not {expected:?}");
        let up = match (got.altitude_amsl_m, expected.altitude_amsl_m) {
            (Some(got), Some(expected)) => got - expected,
            (None, None) => 0.0,
            _ => f64::NAN,
        };
        assert!(up.abs() <= vertical_m, "{name}: {got:?} is not {expected:?}");
    }
    assert_eq!(got.len(), expected.len(), "{name}");
}

/// Checks the flight's `-o x.csv`.
fn assert_table_conforms(flight: &Flight, expected: &[Point]) {
    assert!(!expected.is_empty());
    let csv: Vec<_> = flight.csv().iter().map(|line| Point::of_csv(line)).collect();
    assert_agree(&flight.name, &csv, expected, 0.001, 0.001);
}

/// Checks the flight's `-o x.csv` and `-o x.ast`, and the points in its summary.
fn assert_conforms(flight: &Flight) {
    let (name, inputs, expected) = (&flight.name, [&*flight.capture()], expected(flight));
    assert_table_conforms(flight, &expected);

    let said = RemoteIdOutcome::by_sensors(flight);
    let octets = flight.output(&inputs, "ast");
    let mut got = Vec::new();
    for (block, expected) in blocks(&octets).zip(&expected) {
        let mut records = block.unwrap().records::<cat129::Record>();
        let record = records.next().unwrap().unwrap().record;
        assert!(records.next().is_none(), "one record a block");
        let report = FusionReport::read(record.special_purpose.as_ref().unwrap()).unwrap();
        got.push(Point::of_record(&record, &report, expected.key.0));
        said.assert_said(&record, &report, expected);
    }
    assert_eq!(blocks(&octets).count(), expected.len(), "{name}");
    assert_agree(name, &got, &expected, 0.06, 0.11);

    let of_kind = |kind| expected.iter().filter(|point| point.key.1 == kind).count();
    let points = format!(
        "slots: {} fused, {} radar, {} transponder points\n",
        of_kind("fused"),
        of_kind("radar"),
        of_kind("transponder")
    );
    let summary = ran(&mut flight.replay(&inputs));
    assert!(summary.text().contains(&points), "{name}: {points}is not in\n{}", summary.text());
}

#[test]
fn every_point_of_three_radars_is_as_expected() {
    let flight = three_radars();
    let expected = expected(&flight);
    assert_table_conforms(&flight, &expected);
    let json = String::from_utf8(flight.output(&[&flight.capture()], "ndjson")).unwrap();
    for radar in ["alpha", "bravo", "charlie"] {
        let contributor = format!(r#"{{"kind":"radar","sensor":"{radar}","#);
        let fused = |line: &str| line.contains(r#""source":"fused""#) && line.contains(&contributor);
        assert!(json.lines().any(fused), "{radar}");
    }
}

#[test]
fn every_point_of_the_bundled_flights_is_as_expected() {
    for flight in bundled() {
        assert_conforms(&flight);
    }
}

#[test]
fn every_point_of_the_trials_is_as_expected() {
    for flight in trials() {
        assert_conforms(&flight);
    }
}

/// Sensor data that records must contain, from the capture and the decoder alone.
struct RemoteIdOutcome {
    service: DataSource,
    /// By radar track and slot: the plot that counts.
    plots: BTreeMap<(u16, i64), Plot>,
    /// I129/020, 030 and 050, by serial number.
    items: BTreeMap<[u8; 12], Items>,
    numbers: BTreeMap<String, u32>,
}

type Items = (Option<[u8; 3]>, Option<[u8; 3]>, Option<[u8; 2]>);

struct Plot {
    /// Time in nanoseconds.
    at: i64,
    has_height: bool,
    probability: Option<f64>,
}

impl RemoteIdOutcome {
    fn by_sensors(flight: &Flight) -> Self {
        let config = flight.config();
        let mut said = Self {
            service: DataSource { sac: config.site.sac, sic: config.site.sic },
            plots: BTreeMap::new(),
            items: BTreeMap::new(),
            numbers: config.fusion.transponder_numbers.clone(),
        };
        let is = |sensor: &Sensor, source| Some(DataSource { sac: sensor.sac, sic: sensor.sic }) == source;
        let [radar, transponder] = &config.sensors[..] else { panic!("one radar, one transponder") };
        for reception in flight.receptions() {
            let (received, contents) = (reception.received.unwrap(), contents(&reception.payload));
            for record in contents.plots.iter().filter(|record| is(radar, record.data_source)) {
                let at = nearest_day(record.time_of_day.unwrap().count(), received).unwrap().nanos();
                let slot = at.div_euclid(SLOT_NS);
                // Later plots miss their slot; these flights have no plots from the future.
                if received.nanos() < (slot + 25) * SLOT_NS {
                    let plot =
                        Plot { at, has_height: record.height_3d.is_some(), probability: uav(radar, record) };
                    let track = record.track_number.unwrap().number();
                    let kept = said.plots.remove(&(track, slot)).filter(|kept| kept.at > at);
                    said.plots.insert((track, slot), kept.unwrap_or(plot));
                }
            }
            for record in contents.fixes.iter().filter(|record| is(transponder, record.data_source)) {
                let items = (record.manufacturer, record.model, record.registration_country);
                let before = said.items.insert(record.serial_number.unwrap(), items);
                assert!(before.is_none_or(|before| before == items), "in these flights nobody changes them");
            }
        }
        said
    }

    /// Checks a record against `docs/CAT129.md`, except its position and numbers.
    fn assert_said(&self, record: &cat129::Record, report: &FusionReport, expected: &Point) {
        let &(slot, _, number, radar_track, transponder) = &expected.key;
        let plot = radar_track.map(|track| &self.plots[&(track, slot)]);
        assert_eq!(record.data_source, Some(self.service));

        let (serial, country) = (record.serial_number.unwrap(), record.registration_country);
        let items = (record.manufacturer, record.model, country);
        if let Some(transponder) = transponder {
            let (manufacturer, model, country) = self.items[&serial];
            assert_eq!(items, (manufacturer, model, country.or(Some(*b"ZZ"))));
            // In these flights, a serial number has a configured track number, or is itself an unused one.
            let serial = str::from_utf8(&serial).unwrap().trim_matches([' ', '\0']);
            let number = self.numbers.get(serial).copied().or_else(|| serial.parse().ok());
            assert!(number.is_none_or(|number| number == transponder), "{serial} is no {transponder}");
        } else {
            assert_eq!(items, (Some(*b"RDR"), Some(*b"UNK"), Some(*b"ZZ")));
            assert_eq!(serial.as_slice(), format!("{number:012}").as_bytes());
        }

        let flag = |set, flag| if set { flag } else { Flags::default() };
        assert_eq!(
            report.flags,
            flag(transponder.is_some(), Flags::INTERPOLATED)
                .with(flag(plot.is_some_and(|plot| !plot.has_height), Flags::HEIGHT_NOT_MEASURED))
        );
        let probability = plot.and_then(|plot| plot.probability);
        let probability = probability.map_or(255, |probability| (254.0 * probability).round() as u8);
        let octets = record.special_purpose.as_ref().unwrap().contents();
        assert_eq!(octets[..3], *b"UF\x01");
        assert_eq!(octets[14..18], [0xff; 4], "no deviation is known");
        assert_eq!(octets[19..], [probability, 0], "octets 21 and 22");
        assert_eq!(report.horizontal_deviation, Deviation::UNKNOWN);
        assert_eq!(report.uav_probability == UavProbability::UNKNOWN, probability == 255);

        // No further items: no velocity, no accuracy.
        let nothing_more = cat129::Record {
            data_source: record.data_source,
            manufacturer: record.manufacturer,
            model: record.model,
            serial_number: record.serial_number,
            registration_country: country,
            time_of_day: record.time_of_day,
            position: record.position,
            altitude_amsl: record.altitude_amsl,
            special_purpose: record.special_purpose.clone(),
            ..cat129::Record::default()
        };
        assert_eq!(*record, nothing_more);
    }
}

/// Probability in a radar's record.
fn uav(radar: &Sensor, record: &cat048::Record) -> Option<f64> {
    let SensorKind::Radar(radar) = &radar.kind else { panic!("the first sensor is the radar") };
    match radar.classification {
        Classification::SpecialPurpose(stated) => {
            let field = record.special_purpose.as_ref()?.contents();
            field.get(stated.octet).map(|&octet| f64::from(octet) / 255.0)
        }
        Classification::SpecialPurposeCategory(_) => panic!("no radar of the flights states a category"),
        Classification::TargetClassification => {
            let codes = record.warnings.iter().flat_map(cat048::Warnings::codes);
            let none_but_uav = codes.into_iter().all(|code| ![5, 6, 7, 19, 20, 23].contains(&code));
            Some(if none_but_uav { 1.0 } else { 0.0 })
        }
        Classification::Constant { value } => Some(value),
    }
}

/// `{'fused': 270, …}`.
fn counts(line: &str) -> BTreeMap<String, u64> {
    serde_json::from_str(&line.replace('\'', "\"")).unwrap()
}

/// All counters of a tally except sums and remarks, with the names of `counts.txt`.
fn in_their_words(tally: &Tally, config: &Config) -> BTreeMap<String, u64> {
    let mut words = BTreeMap::new();
    let mut count = |word: &str, count: u64| *words.entry(word.to_owned()).or_default() += count;
    count("identical datagram", tally.duplicates);
    count("jump", tally.restarts);
    count("the clock stepped back", tally.clock_behind);
    for ((_, kind), &faults) in &tally.faults {
        let word = match *kind {
            "block_too_short" => "LEN below 3",
            "block_past_end" => "LEN past the end",
            "item_past_end" => "item runs past the end",
            "fspec_past_end" => "FSPEC runs past the end",
            "primary_subfield_extended" => "primary subfield extended",
            "no_repetition_count" => "no repetition count",
            other => other,
        };
        count(word, faults);
    }
    count("CAT034", tally.service.values().sum());
    for (category, &blocks) in &tally.skipped {
        count(&format!("skipped category {category}"), blocks);
    }
    for (sensor, &reports) in &tally.accepted {
        let is_radar = config.sensors[usize::from(sensor.0)].kind.is_radar();
        count(if is_radar { "plots" } else { "fixes" }, reports);
    }
    for ((_, reason), &records) in &tally.refused {
        count(reason, records);
    }
    for ((category, _), &records) in &tally.unknown_sources {
        count(&format!("CAT{category:03} of an unknown source"), records);
    }
    words.retain(|_, count| *count > 0);
    words
}

#[test]
fn every_point_and_every_drop_is_counted_as_expected() {
    for flight in bundled().into_iter().filter(|flight| flight.name != "demo") {
        let text = String::from_utf8(fs::read(flight.path("counts.txt")).unwrap()).unwrap();
        let (points, drops) = text.split_once('\n').unwrap();
        let (config, receptions) = (flight.config(), flight.receptions());
        let flown = fly(&config, &receptions);

        let (total, by_kind) = points.split_once(" points ").unwrap();
        assert_eq!(total, flown.emissions.iter().map(|e| e.points.len()).sum::<usize>().to_string());
        let by_kind = counts(by_kind);
        let [fused, radar, transponder] = ["fused", "radar", "transponder"].map(|kind| by_kind[kind]);
        let summary = ran(&mut flight.replay(&[&flight.capture()]));
        let line = format!("slots: {fused} fused, {radar} radar, {transponder} transponder points\n");
        assert!(summary.text().contains(&line), "{}: {line}", flight.name);

        assert_eq!(in_their_words(&flown.tally, &config), counts(drops), "{}", flight.name);
        assert_eq!(flown.tally.received, receptions.len() as u64);
    }
}
