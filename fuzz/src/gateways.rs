//! Random octets as data of other receivers.

use std::collections::BTreeMap;

use asterix::{DataSource, Record, blocks, cat021, cat129};
use fusion::Time;
use remote_id::{Link, Listener};
use utm_fusion::config::KnownSystem;
use utm_fusion::gateways::{adsb, mavlink, remote_id as lines};

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
