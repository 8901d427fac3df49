//! Random octets as data of other receivers.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use asterix::{DataSource, Record, blocks, cat021, cat048, cat129};
use fusion::Time;
use remote_id::{Link, Listener};
use utm_fusion::config::{Config, KnownSystem};
use utm_fusion::gateways::{adsb, lines as text_lines, mavlink, remote_id as lines};

const SOURCE: DataSource = DataSource { sac: 25, sic: 21 };
const START: i64 = 1_800_000_000_000_000_000;

/// Checks that every datagram is a valid record of the sensor, that every frame is translated, noted or dropped, and that
/// splitting the input makes no difference.
pub fn adsb(data: &[u8]) {
    for framing in [adsb::ReceiverFraming::Beast, adsb::ReceiverFraming::Avr] {
        let run = |step: usize| {
            let mut translator = adsb::AdsbTranslator::new(framing, SOURCE, Some([50.0, 8.0]));
            let mut datagrams = Vec::new();
            for part in data.chunks(step) {
                translator.take(part, Time::from_nanos(START), |datagram| datagrams.push(datagram));
            }
            translator.end();
            let counts = translator.counts();
            assert_eq!(counts.frames, counts.translated + counts.noted + counts.dropped.total());
            datagrams
        };
        let datagrams = run(usize::MAX);
        assert_eq!(datagrams, run(3));
        datagrams
            .iter()
            .for_each(|datagram| is_a_record::<cat021::Record>(datagram, cat021::Edition::default()));
    }
}

/// Checks MAVLink in the same way as ADS-B, one datagram per call.
pub fn mavlink(data: &[u8]) {
    let systems = (0..=255).filter_map(|number| Some((number, KnownSystem::new("DRONE")?)));
    let mut translator = mavlink::MavlinkTranslator::new(mavlink::MavlinkSensors {
        drones: Some((SOURCE, systems.collect::<BTreeMap<_, _>>())),
        aircraft: Some(SOURCE),
        remote_id: Some(mavlink::RemoteIdReceiver { id: Some("roof".to_owned()) }),
    });
    let mut datagrams = Vec::new();
    translator.take(data, Time::from_nanos(START), |datagram| datagrams.push(datagram));
    let counts = translator.counts();
    assert_eq!(counts.frames, counts.translated + counts.heartbeats + counts.dropped.total());
    for datagram in &datagrams {
        match datagram[0] {
            129 => is_a_record::<cat129::Record>(datagram, ()),
            21 => is_a_record::<cat021::Record>(datagram, cat021::Edition::default()),
            _ => assert!(lines::BroadcastLine::parse(datagram).is_ok()),
        }
    }
}

/// Checks that each line of a sensor that sends text is one sound record, or dropped by its reason.
pub fn text(data: &[u8]) {
    const SITE: &str = r#"
[site]
name = "fuzz"
sac = 25
sic = 1
[[sensors]]
kind = "radar"
id = "hill"
sac = 25
sic = 21
latitude_deg = 52.0
longitude_deg = 4.0
height_amsl_m = 20.0
connections = [{ format = "json", address = "127.0.0.1:15048", fields = { time = "t ms", track = "id", latitude = "p.lat", longitude = "p.lon", height = "p.h ft", speed = "v kt", course = "c", probability = "u %" } }]
[[sensors]]
kind = "transponder"
id = "beacons"
sac = 25
sic = 21
connections = [{ format = "csv", address = "127.0.0.1:15129", columns = ["t", "sn", "lat", "lon", "h"], fields = { time = "t", serial_number = "sn", latitude = "lat", longitude = "lon", height = "-h" } }]
"#;
    static CONFIG: LazyLock<Config> =
        LazyLock::new(|| Config::parse(SITE, "site.toml", std::iter::empty()).expect("the site is valid"));
    for (index, sensor) in CONFIG.sensors.iter().enumerate() {
        let translator = text_lines::LineTranslator::new(&CONFIG, index, &sensor.connections[0]);
        let mut translator = translator.expect("the sensor has lines");
        let mut datagrams = Vec::new();
        translator.take(data, Time::from_nanos(START), |datagram| datagrams.push(datagram));
        let count = datagrams.len() as u64 + translator.dropped().total();
        assert_eq!(count, lines::lines(data).count() as u64);
        for datagram in &datagrams {
            match datagram[0] {
                48 => is_a_record::<cat048::Record>(datagram, ()),
                _ => is_a_record::<cat129::Record>(datagram, ()),
            }
        }
    }
}

/// Lines are accepted or refused; received frames yield valid lines.
pub fn remote_id(data: &[u8]) {
    let (mut counts, mut taken) = (lines::RemoteIdLineCounts::default(), 0);
    counts.lines(data, &lines::ReceiverIds::default(), |line| {
        assert!(lines::BroadcastLine::parse(line).is_ok());
        taken += 1;
    });
    assert_eq!((counts.taken, counts.lines), (taken, taken + counts.refused.total()));
    for link in Link::ALL {
        let heard = lines::heard(&mut Listener::default(), link, data, Some(Time::from_nanos(START)))
            .unwrap_or_default();
        for line in lines::lines(&heard) {
            let read = lines::BroadcastLine::parse(line).expect("a line of our own");
            assert_eq!(read.time, Some(Time::from_nanos(START)));
        }
    }
}

fn is_a_record<R: Record>(datagram: &[u8], edition: R::Edition) {
    let mut all = blocks(datagram);
    let block = all.next().expect("a block").expect("a sound one");
    assert!(all.next().is_none() && block.category == R::CATEGORY);
    let records: Vec<_> = block.records_in::<R>(edition).collect();
    assert!(matches!(&records[..], [Ok(located)] if located.record.data_source() == Some(SOURCE)));
}
