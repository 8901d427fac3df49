//! Assignment of numbers to transponders.

use super::*;

const GRID: SlotGrid = SlotGrid::new(SignedDuration::from_millis(250));

fn identity(serial: &str, country: &[u8; 2]) -> Identity {
    let mut octets = [b' '; 12];
    octets[..serial.len()].copy_from_slice(serial.as_bytes());
    Identity::new(&octets, Some(country)).unwrap()
}

#[test]
fn configured_then_the_serial_itself_then_the_lowest_free() {
    let configured = BTreeMap::from([(b"ALPHA".to_vec(), 2), (b"BRAVO".to_vec(), 7)]);
    let mut numbers = Numbers::new(GRID, Keeping::ForGood, configured);
    let mut slot = 0;
    let mut of = |serial, country| {
        slot += 1;
        numbers.of(identity(serial, country), Slot(slot)).unwrap().number
    };
    assert_eq!(of("ALPHA", b"NO"), 2);
    assert_eq!(of("X", b"NO"), 1);
    assert_eq!(of("Y", b"NO"), 3, "2 is taken");
    assert_eq!(of("ALPHA", b"SE"), 4, "its configured number is taken");
    assert_eq!(of("0007", b"NO"), 5, "7 is configured for another");
    assert_eq!(of("000429496", b"NO"), 429_496);
    assert_eq!(of("429497", b"NO"), 6);
    assert_eq!(of("Z", b"NO"), 8, "7 is kept for BRAVO");
    assert_eq!(of("X", b"NO"), 1, "a number given stays");
    assert_eq!(of("BRAVO", b"NO"), 7);
    let alpha = numbers.of(identity("ALPHA", b"NO"), Slot(99));
    assert_eq!(alpha, Some(Numbered { number: 2, since: Slot(1) }), "and so does its first slot");
}

#[test]
fn numbers_of_before_are_kept_and_bad_ones_refused() {
    let configured = BTreeMap::from([(b"ALPHA".to_vec(), 2)]);
    let mut numbers = Numbers::new(GRID, Keeping::ForGood, configured);
    let heard = Some(GRID.open(Slot(0)));
    let given = |number, serial| Given { number, identity: identity(serial, b"NO"), heard };
    assert!(numbers.remember(given(1, "X")));
    assert!(numbers.remember(given(2, "Y")), "although it is configured for another now");
    assert!(!numbers.remember(given(2, "Z")), "taken");
    assert!(!numbers.remember(given(3, "X")), "X has one");
    assert!(
        !numbers.remember(given(0, "Z")) && !numbers.remember(given(LARGEST_TRANSPONDER_NUMBER + 1, "Z"))
    );
    let mut of = |serial, slot| numbers.of(identity(serial, b"NO"), Slot(slot));
    assert_eq!(of("X", 5), Some(Numbered { number: 1, since: Slot(5) }));
    assert_eq!(of("X", 6), Some(Numbered { number: 1, since: Slot(5) }));
    assert_eq!(of("ALPHA", 7), Some(Numbered { number: 3, since: Slot(7) }), "1 and 2 are taken");
    assert_eq!(of("Y", 8), Some(Numbered { number: 2, since: Slot(8) }));
    let new = Given { heard: Some(GRID.open(Slot(7))), ..given(3, "ALPHA") };
    assert_eq!(numbers.take_changes(), [NumberChange::Heard(new)]);
    assert_eq!(numbers.take_changes(), []);
}

/// All numbers are in use by transponders whose last points are a second apart; number 1 has the oldest.
fn used_up(keeping: Keeping) -> Numbers {
    let mut numbers = Numbers::new(GRID, keeping, BTreeMap::from([(b"ALPHA".to_vec(), 2)]));
    for number in 1..=LARGEST_TRANSPONDER_NUMBER {
        let heard = Some(GRID.open(Slot(4 * i64::from(number))));
        assert!(numbers.remember(Given { number, identity: identity(&format!("S{number}"), b"NO"), heard }));
    }
    numbers
}

/// About half a million seconds: every transponder had a point, at least one a day ago.
const LATER: Slot = Slot(4 * (LARGEST_TRANSPONDER_NUMBER as i64 + 60));

#[test]
fn numbers_for_good_end() {
    let mut numbers = used_up(Keeping::ForGood);
    numbers.begin_slot(Slot(i64::MAX / 1_000_000_000));
    assert_eq!(numbers.of(identity("A", b"NO"), LATER), None);
    assert_eq!(numbers.of(identity("S7", b"NO"), LATER).unwrap().number, 7);
    assert_eq!(numbers.used(), LARGEST_TRANSPONDER_NUMBER as usize);
}

#[test]
fn every_track_gets_a_number_if_one_is_free() {
    let mut numbers = used_up(Keeping::ADay);
    // The transponder with the oldest point loses its number, except for the number reserved for ALPHA.
    assert_eq!(numbers.of(identity("S1", b"NO"), LATER).unwrap().number, 1);
    assert_eq!(numbers.of(identity("A", b"NO"), LATER).unwrap().number, 3);
    assert_eq!(numbers.of(identity("B", b"NO"), LATER).unwrap().number, 4);
    assert_eq!(numbers.of(identity("A", b"NO"), LATER).unwrap().number, 3);
    // When it returns, it is treated as new.
    assert_eq!(numbers.of(identity("S3", b"NO"), LATER).unwrap().number, 5);
    let returned: Vec<u32> = numbers
        .take_changes()
        .iter()
        .filter(|change| matches!(change, NumberChange::Returned(_)))
        .map(|change| change.given().number)
        .collect();
    assert_eq!(
        (returned, numbers.used(), numbers.unnumbered()),
        (vec![3, 4, 5], LARGEST_TRANSPONDER_NUMBER as usize, 0)
    );
}

#[test]
fn a_number_goes_back_a_day_after_its_aircraft_ended() {
    let slots = |seconds: i64| Slot(4 * seconds);
    let mut numbers = Numbers::new(GRID, Keeping::ADay, BTreeMap::new());
    let fly = |numbers: &mut Numbers, serial, from: i64, to: i64| {
        for second in from..=to {
            numbers.begin_slot(slots(second));
            assert!(numbers.of(identity(serial, b"NO"), slots(second)).is_some());
        }
    };
    // One flies for an hour, the other for about a day.
    fly(&mut numbers, "A", 0, 3600);
    fly(&mut numbers, "B", 3600, 3600 + 86_000);
    let told = numbers.take_changes();
    assert_eq!(told.iter().filter(|change| change.given().number == 1).count(), 7, "every ten minutes");
    fly(&mut numbers, "B", 3600 + 86_001, 3600 + 86_400 - 1);
    assert_eq!(numbers.used(), 2, "less than a day");
    fly(&mut numbers, "B", 3600 + 86_400, 3600 + 86_400 + 600);
    assert_eq!(numbers.used(), 1, "a day, and what was not noted");
    let changes = numbers.take_changes();
    let a = changes.iter().find(|change| matches!(change, NumberChange::Returned(_))).unwrap().given();
    assert_eq!((a.number, a.identity), (1, identity("A", b"NO")));
    let now = slots(3600 + 86_400 + 601);
    assert_eq!(numbers.of(identity("B", b"NO"), now).unwrap().number, 2);
    assert_eq!(numbers.of(identity("C", b"NO"), now).unwrap(), Numbered { number: 1, since: now });

    // After a restart the same numbers are released at the same time.
    let kept: Vec<Given> = numbers.given().collect();
    let mut again = Numbers::new(GRID, Keeping::ADay, BTreeMap::new());
    assert!(kept.iter().all(|&given| again.remember(given)));
    again.begin_slot(now.plus(4 * 86_000));
    assert_eq!(again.used(), 2);
    again.begin_slot(now.plus(4 * 87_000));
    assert_eq!(again.used(), 0);
    // Numbers of an old file without times are counted from the first slot on.
    let mut old = Numbers::new(GRID, Keeping::ADay, BTreeMap::new());
    assert!(kept.iter().all(|&given| old.remember(Given { heard: None, ..given })));
    old.begin_slot(now);
    old.begin_slot(now.plus(4 * 86_400));
    assert_eq!(old.used(), 2);
    old.begin_slot(now.plus(4 * 87_000));
    assert_eq!(old.used(), 0);
}

/// An aircraft without a serial number.
fn aircraft(address: u32) -> Identity {
    Identity::of_address(address)
}

#[test]
fn identity_without_serial_is_numbered_from_the_other_end() {
    // The second highest is reserved for a drone, and the third highest is the serial number of another.
    let configured = BTreeMap::from([(b"ALPHA".to_vec(), LARGEST_TRANSPONDER_NUMBER - 1)]);
    let mut numbers = Numbers::new(GRID, Keeping::ForGood, configured);
    let mut of = |identity| numbers.of(identity, Slot(1)).unwrap().number;
    assert_eq!(of(identity("429494", b"NO")), 429_494);
    assert_eq!(of(aircraft(0x4B_0001)), 429_496);
    assert_eq!(of(aircraft(0x4B_0002)), 429_493, "429495 is ALPHA's, and 429494 is taken");
    assert_eq!(of(Identity::of_name(crate::report::Space::Session, b"01234").unwrap()), 429_492);
    assert_eq!(of(aircraft(0x4B_0001)), 429_496, "a number given stays");
    assert_eq!(of(identity("ALPHA", b"NO")), 429_495);
    // A drone whose serial number is an aircraft's number gets the lowest free number, like all others.
    assert_eq!(of(identity("429496", b"NO")), 1);
    assert_eq!(of(identity("X", b"NO")), 2);
}

/// A drone's number does not depend on which aircraft without serial numbers are received, nor on their order.
#[test]
fn an_airliner_in_range_changes_no_drones_number() {
    let serials = ["X", "7", "Y", "2", "Z", "ALPHA", "0003"];
    let drones = |numbers: &mut Numbers, aircraft_between: u32| -> Vec<u32> {
        let mut address = 0;
        let mut of = |serial| {
            for _ in 0..aircraft_between {
                address += 1;
                let number = numbers.of(aircraft(address), Slot(1)).unwrap().number;
                assert_eq!(number, LARGEST_TRANSPONDER_NUMBER + 1 - address, "downward, one by one");
            }
            numbers.of(identity(serial, b"NO"), Slot(1)).unwrap().number
        };
        serials.map(&mut of).to_vec()
    };
    let new = || Numbers::new(GRID, Keeping::ADay, BTreeMap::from([(b"ALPHA".to_vec(), 4)]));
    let alone = drones(&mut new(), 0);
    assert_eq!(alone, [1, 7, 2, 3, 5, 4, 6]);
    for aircraft_between in [1, 5, 300] {
        assert_eq!(drones(&mut new(), aircraft_between), alone);
    }
}

#[test]
fn an_aircrafts_number_is_given_again_only_once_it_is_free() {
    let mut numbers = Numbers::new(GRID, Keeping::ADay, BTreeMap::new());
    let day = |days: i64| Slot(4 * (86_400 + 600) * days);
    let number = |numbers: &mut Numbers, address, slot| numbers.of(aircraft(address), slot).unwrap().number;
    assert_eq!([1, 2, 3].map(|address| number(&mut numbers, address, day(0))), [429_496, 429_495, 429_494]);
    // The second aircraft continues to fly; the other two are not received any more.
    let half = Slot(day(1).0 / 2);
    numbers.begin_slot(half);
    assert_eq!(number(&mut numbers, 2, half), 429_495);
    assert_eq!(number(&mut numbers, 4, half), 429_493, "none is free before a day is over");
    numbers.begin_slot(day(1));
    assert_eq!(numbers.used(), 2);
    // The highest free numbers come first, and never one that is in use.
    assert_eq!([5, 6, 7].map(|address| number(&mut numbers, address, day(1))), [429_496, 429_494, 429_492]);
    assert_eq!(number(&mut numbers, 1, day(1)), 429_491, "who comes again is as new");
    let given: BTreeSet<u32> = numbers.given().map(|given| given.number).collect();
    assert_eq!((given.len(), numbers.used()), (6, 6));
}

/// Assignment from both ends: no number is assigned twice.
#[test]
fn numbers_from_both_ends_never_meet_in_one() {
    let mut numbers = Numbers::new(GRID, Keeping::ForGood, BTreeMap::new());
    for number in 4..=LARGEST_TRANSPONDER_NUMBER {
        let given = Given { number, identity: identity(&format!("S{number}"), b"NO"), heard: None };
        assert!(numbers.remember(given));
    }
    let mut of = |identity| numbers.of(identity, Slot(1)).map(|numbered| numbered.number);
    assert_eq!(of(aircraft(1)), Some(3));
    assert_eq!(of(identity("X", b"NO")), Some(1));
    assert_eq!(of(aircraft(2)), Some(2));
    assert_eq!((of(aircraft(3)), of(identity("Y", b"NO"))), (None, None), "all are used up");
    assert_eq!(of(aircraft(1)), Some(3));
}
