use asterix::blocks;
use asterix::cat021::{AddressType, Edition, Record};
use proptest::prelude::*;

use super::cpr::tests::compact;
use super::frames::written;
use super::squitter::sealed;
use super::*;

const SOURCE: DataSource = DataSource { sac: 25, sic: 21 };
const START: i64 = 1_800_000_000 * SECOND;

fn at(seconds: f64) -> Time {
    Time::from_nanos(START + (seconds * 1e9) as i64)
}

/// A position in the air at 1000 ft.
fn airborne(place: LatLonDeg, odd: bool) -> u64 {
    let frame = compact(place, odd, false);
    // 11: barometric altitude, in 25 ft steps.
    11 << 51
        | 0x0b0 << 36
        | u64::from(odd) << 34
        | u64::from(frame.latitude) << 17
        | u64::from(frame.longitude)
}

fn on_ground(place: LatLonDeg, odd: bool) -> u64 {
    let frame = compact(place, odd, true);
    7 << 51 | u64::from(odd) << 34 | u64::from(frame.latitude) << 17 | u64::from(frame.longitude)
}

fn squitter(first: u8, address: u32, me: u64) -> Vec<u8> {
    sealed(first, address, me).to_vec()
}

fn record(datagram: &[u8]) -> Record {
    let block = blocks(datagram).next().unwrap().unwrap();
    let records: Vec<_> =
        block.records_in::<Record>(Edition::default()).map(|located| located.unwrap().record).collect();
    assert_eq!(records.len(), 1);
    records.into_iter().next().unwrap()
}

/// Datagrams that a translator makes from messages, each with its time, and the counts.
fn translated(
    framing: ReceiverFraming,
    receiver: Option<LatLonDeg>,
    messages: &[(f64, Vec<u8>)],
) -> (Vec<Vec<u8>>, AdsbCounts) {
    let mut translator = AdsbTranslator::new(framing, SOURCE, receiver);
    let mut datagrams = Vec::new();
    for (number, (seconds, message)) in messages.iter().enumerate() {
        translator.take(&written(framing, number as u64 + 1, message), at(*seconds), |datagram| {
            datagrams.push(datagram);
        });
    }
    let counts = translator.counts();
    assert_eq!(counts.frames, counts.translated + counts.noted + counts.dropped.total());
    assert_eq!(counts.translated, datagrams.len() as u64);
    (datagrams, counts)
}

fn dropped(counts: &AdsbCounts, reason: &str) -> u64 {
    counts.dropped.iter().find(|(name, _)| *name == reason).unwrap().1
}

#[test]
fn aircraft_with_all_squitters_is_a_full_record() {
    let place = [59.7, 30.6];
    let messages = [
        // TEST1 3: light aircraft.
        (0.0, squitter(0x8d, 7, 0x0021_4d14_f160_c820)),
        // The velocity from the Mode S book: 159 kt to the south, 550 ft above the barometric altitude.
        (0.1, squitter(0x8d, 7, 0x0099_4409_9408_3817)),
        (0.2, squitter(0x8d, 7, 0x00e1_1815_0000_0000)),
        // Version 2, NACp 10, SIL 3, GVA 2.
        (0.3, squitter(0x8d, 7, 0x00f8_0000_0000_4abe)),
        (1.0, squitter(0x8d, 7, airborne(place, false))),
        (1.5, squitter(0x8d, 7, airborne(place, true))),
        (2.0, squitter(0x8d, 7, airborne(place, false))),
    ];
    for framing in [ReceiverFraming::Beast, ReceiverFraming::Avr] {
        let (datagrams, counts) = translated(framing, None, &messages);
        assert_eq!((counts.translated, counts.noted, dropped(&counts, "no_pair")), (2, 4, 1));
        let record = record(&datagrams[0]);
        assert_eq!(record.data_source, Some(SOURCE));
        assert_eq!(record.target_report.unwrap().address_type(), AddressType::Icao);
        assert_eq!(record.target_address.unwrap().address(), 7);
        let position = record.fine_position.unwrap();
        assert!(
            (position.latitude_deg() - place[0]).abs() < 5e-5
                && (position.longitude_deg() - place[1]).abs() < 5e-5
        );
        assert_eq!(record.flight_level.unwrap().flight_level(), 10.0);
        assert!((record.geometric_height.unwrap().height_m() - 1550.0 * 0.3048).abs() < 1.0);
        assert!((record.ground_vector.unwrap().speed_m_s() - 159.2 * 1852.0 / 3600.0).abs() < 0.2);
        assert!((record.ground_vector.unwrap().track_deg() - 182.88).abs() < 0.01);
        assert!((record.geometric_rate.unwrap().up_m_s() - -832.0 * 0.3048 / 60.0).abs() < 0.02);
        assert_eq!(record.barometric_rate, None);
        assert_eq!(record.mode_3a.unwrap().to_string(), "1017");
        let quality = record.quality.unwrap();
        assert_eq!((quality.position_category(), quality.horizontal_accuracy_m()), (8, Some(10.0)));
        assert_eq!((quality.integrity_level(), quality.vertical_accuracy_m()), (3, Some(45.0)));
        assert_eq!(record.mops_version.unwrap().standard(), asterix::cat021::Standard::Do260B);
        let [reception, velocity] =
            [record.position_reception, record.velocity_reception].map(|time| time.unwrap().seconds());
        let seconds_of_day = (at(1.5).since_midnight() as f64) / 1e9;
        assert!((reception - seconds_of_day).abs() < 0.005 && (reception - velocity - 1.4).abs() < 0.01);
    }
}

#[test]
fn outdated_items_are_omitted() {
    let place = [59.7, 30.6];
    let position = |seconds, odd| (seconds, squitter(0x8d, 7, airborne(place, odd)));
    let velocity = (0.0, squitter(0x8d, 7, 0x0099_4409_9408_3817));
    let (datagrams, _) = translated(
        ReceiverFraming::Beast,
        None,
        &[
            velocity,
            position(1.0, false),
            position(9.9, true),
            position(10.2, false),
            position(69.0, true),
            position(131.0, false),
        ],
    );
    let has_velocity: Vec<bool> =
        datagrams.iter().map(|datagram| record(datagram).ground_vector.is_some()).collect();
    // A single frame near a place 59 s old; then one 62 s later, which cannot be placed.
    assert_eq!(has_velocity, [true, false, false]);
}

#[test]
fn surface_positions_need_a_reference_nearby() {
    let place = [59.8, 30.3];
    let messages: Vec<_> = (0..3)
        .map(|number| (f64::from(number), squitter(0x8c, 9, on_ground(place, number % 2 == 1))))
        .collect();
    assert_eq!(translated(ReceiverFraming::Beast, None, &messages).1.translated, 0);
    let (datagrams, _) = translated(ReceiverFraming::Beast, Some([59.0, 31.0]), &messages);
    assert_eq!(datagrams.len(), 2);
    let record = record(&datagrams[1]);
    let position = record.fine_position.unwrap();
    assert!(
        (position.latitude_deg() - place[0]).abs() < 2e-5
            && (position.longitude_deg() - place[1]).abs() < 2e-5
    );
    assert!(record.target_report.unwrap().is_on_ground());
    assert_eq!((record.flight_level, record.geometric_height), (None, None));
}

#[test]
fn jump_is_accepted_after_two_agreeing_pairs() {
    let (here, there) = ([50.0, 8.0], [50.0, 9.0]);
    let frame = |seconds, place, odd| (seconds, squitter(0x8d, 7, airborne(place, odd)));
    let messages = [
        frame(0.0, here, false),
        frame(0.5, here, true),
        // A pair far away, twice.
        frame(1.0, there, false),
        frame(1.5, there, true),
        frame(2.0, there, false),
        frame(2.5, there, true),
    ];
    let (datagrams, counts) = translated(ReceiverFraming::Beast, None, &messages);
    assert!(dropped(&counts, "implausible") >= 1);
    let longitude = record(datagrams.last().unwrap()).fine_position.unwrap().longitude_deg();
    assert!((longitude - 9.0).abs() < 1e-4, "{longitude}");
    // Out of the receiver's range.
    let (_, counts) = translated(ReceiverFraming::Beast, Some([40.0, 8.0]), &messages[..2]);
    assert_eq!((counts.translated, dropped(&counts, "implausible")), (0, 1));
}

#[test]
fn dropped_frames_are_counted_by_reason() {
    let position = airborne([50.0, 8.0], false);
    let mut damaged = squitter(0x8d, 7, position);
    damaged[6] ^= 1;
    let messages = [
        (0.0, vec![1, 2]),
        (0.0, vec![0x5f; 7]),
        (0.0, squitter(0xa0, 7, 0)),
        (0.0, squitter(18 << 3 | 2, 7, position)),
        (0.0, damaged),
        (0.0, squitter(0x8d, 7, 0)),
    ];
    let (_, counts) = translated(ReceiverFraming::Beast, None, &messages);
    assert_eq!(
        counts.dropped.to_string(),
        "1 mode_ac, 2 mode_s_reply, 1 damaged, 1 tis_b, 1 unused_squitter"
    );
    // The same frame twice.
    let mut translator = AdsbTranslator::new(ReceiverFraming::Beast, SOURCE, None);
    let frame = written(ReceiverFraming::Beast, 5, &squitter(0x8d, 7, position));
    (0..2).for_each(|_| translator.take(&frame, at(0.0), |_| ()));
    assert_eq!(dropped(&translator.counts(), "copy"), 1);
}

#[test]
fn address_flood_evicts_the_longest_silent_aircraft() {
    let mut translator = AdsbTranslator::new(ReceiverFraming::Beast, SOURCE, None);
    for address in 0..AIRCRAFT_MOST as u32 + 100 {
        let frame = written(
            ReceiverFraming::Beast,
            u64::from(address) + 1,
            &squitter(0x8d, address, airborne([50.0, 8.0], false)),
        );
        translator.take(&frame, at(f64::from(address) * 1e-3), |_| ());
    }
    assert_eq!((translator.aircraft.len(), translator.counts().displaced), (AIRCRAFT_MOST, 100));
    assert!(translator.aircraft.contains_key(&100) && !translator.aircraft.contains_key(&99));
}

proptest! {
    #[test]
    fn arbitrary_octets_are_only_counted(octets: Vec<u8>, beast: bool) {
        let framing = if beast { ReceiverFraming::Beast } else { ReceiverFraming::Avr };
        let mut translator = AdsbTranslator::new(framing, SOURCE, Some([50.0, 8.0]));
        translator.take(&octets, at(0.0), |datagram| { record(&datagram); });
        translator.end();
        let counts = translator.counts();
        prop_assert_eq!(counts.frames, counts.translated + counts.noted + counts.dropped.total());
    }

    #[test]
    fn arbitrary_squitters_give_valid_records(contents in prop::collection::vec((any::<u64>(), 0..3_u32, 0..8_u8), 1..60)) {
        let messages: Vec<_> = contents
            .iter()
            .enumerate()
            .map(|(number, (me, address, field))| {
                let first = if field % 2 == 0 { 17 << 3 } else { 18 << 3 } | field;
                (number as f64 * 0.3, squitter(first, *address, *me))
            })
            .collect();
        let (datagrams, _) = translated(ReceiverFraming::Beast, Some([50.0, 8.0]), &messages);
        for datagram in datagrams {
            let record = record(&datagram);
            prop_assert!(record.fine_position.unwrap().in_range());
        }
    }

    /// Eight aircraft in turn; one frame is damaged, which may also cost the next one.
    #[test]
    fn damaged_frame_affects_at_most_its_neighbour(damaged in 0..64_usize, at_octet in 0..23_usize, becomes: u8, beast: bool) {
        let framing = if beast { ReceiverFraming::Beast } else { ReceiverFraming::Avr };
        let frame = |number: usize| {
            let (address, odd) = (number % 8, number / 8 % 2 == 1);
            let place = [50.0, 8.0 + address as f64 * 0.1];
            written(framing, number as u64 + 1, &squitter(0x8d, address as u32, airborne(place, odd)))
        };
        let run = |damage: bool| {
            let mut translator = AdsbTranslator::new(framing, SOURCE, None);
            let mut datagrams = Vec::new();
            for number in 0..64 {
                let mut octets = frame(number);
                if damage && number == damaged {
                    octets[at_octet] = becomes;
                }
                translator.take(&octets, at(number as f64 * 0.05), |datagram| datagrams.push(datagram));
            }
            datagrams
        };
        let of_others = |datagrams: Vec<Vec<u8>>| -> Vec<Vec<u8>> {
            let hurt = |address: u32| [damaged % 8, (damaged + 1) % 8].contains(&(address as usize));
            datagrams.into_iter().filter(|datagram| !hurt(record(datagram).target_address.unwrap().address())).collect()
        };
        let expected = of_others(run(false));
        prop_assert!(!expected.is_empty());
        prop_assert_eq!(of_others(run(true)), expected);
    }
}

#[test]
fn copies_from_several_receivers_count_once() {
    // Two receivers with delays of 0.1 and 0.3 s.
    let place = |seconds: f64| [50.0 + 250.0 * seconds / 111_195.0, 8.0];
    let sent: Vec<f64> = (0..40).map(|count| f64::from(count) * 0.5).collect();
    let message = |seconds: f64| squitter(0x8d, 7, airborne(place(seconds), (2.0 * seconds) as u64 % 2 == 1));
    let mut messages: Vec<_> = sent.iter().map(|seconds| (seconds + 0.1, message(*seconds))).collect();
    messages.extend(sent.iter().map(|seconds| (seconds + 0.3, message(*seconds))));
    messages.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (_, counts) = translated(ReceiverFraming::Beast, None, &messages);
    assert_eq!(counts.dropped.to_string(), "40 copy, 1 no_pair");
    // Each receiver receives one parity only, and one of them is late.
    let late = |seconds: f64| if (2.0 * seconds) as u64 % 2 == 1 { 0.05 } else { 0.95 };
    let fast = |seconds: f64| [50.0 + 2.0 * 700.0 * (2.0 * seconds % 2.0) / 111_195.0, 8.0];
    let message = |seconds: f64| squitter(0x8d, 7, airborne(fast(seconds), (2.0 * seconds) as u64 % 2 == 1));
    let mut messages: Vec<_> =
        sent.iter().map(|seconds| (seconds + late(*seconds), message(*seconds))).collect();
    messages.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (_, counts) = translated(ReceiverFraming::Beast, None, &messages);
    assert_eq!(counts.dropped.to_string(), "1 no_pair");
}
