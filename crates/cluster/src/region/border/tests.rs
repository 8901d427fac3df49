mod unowned;

use super::*;
use crate::region::cell_message::AircraftOffer;
use fusion::frames::Geodetic;
use fusion::time::Time;
use site::territory::Territory;

fn cell_name(name: &str) -> CellName {
    CellName::new(name).unwrap()
}

fn border() -> Border {
    let names = ["n512-e0043", "n512-e0044"].map(cell_name);
    let territory = Territory::grid(0.1).unwrap();
    Border::new(Region::new(territory, names.to_vec(), names[0].clone(), 1000.0, 150.0).unwrap())
}

fn message(slot: i64, index: u16, content: CellMessageContent) -> CellMessage {
    CellMessage {
        from: cell_name("n512-e0044"),
        to: cell_name("n512-e0043"),
        slot: Slot(slot),
        index,
        content,
    }
}

fn offer() -> CellMessageContent {
    let seen = Sighting {
        identity: None,
        radar: None,
        slot: Slot(7),
        time: Time::default(),
        position: Geodetic::from_degrees(51.25, 4.39, 100.0),
        velocity: [0.0; 2],
        covariance: None,
    };
    let id = "U-n512-e0044-1".to_owned();
    CellMessageContent::Offer(AircraftOffer {
        id,
        number: 40_970_000,
        first_seen: Time::default(),
        transponder_number: None,
        seen,
    })
}

#[test]
fn repeated_message_is_handled_once() {
    let mut border = border();
    for _ in 0..3 {
        border.handle_message(&message(7, 0, offer()));
    }
    assert_eq!((border.counts.unknown, border.counts.repeated), (1, 2));
    border.handle_message(&message(7, 1, offer()));
    assert_eq!(border.counts.unknown, 2, "another letter of the same slot");
    // A message older than the period remembered counts as handled.
    border.handle_message(&message(7 + REMEMBERED_SLOTS + 1, 0, offer()));
    border.handle_message(&message(7, 0, offer()));
    assert_eq!((border.counts.unknown, border.counts.repeated), (3, 3));
    // A message to another cell is ignored.
    let other = CellMessage { to: cell_name("n512-e0044"), ..message(1000, 0, offer()) };
    border.handle_message(&other);
    assert_eq!(border.counts.unknown, 3);
}

#[test]
fn checkpoint_of_another_cell_is_rejected() {
    let mut known = border();
    known.handle_message(&message(7, 0, CellMessageContent::Block { first: 4096 }));
    let octets = known.checkpoint();
    let mut same = border();
    assert!(same.restore(&octets));
    assert_eq!(same.state, known.state);
    let territory = Territory::grid(0.1).unwrap();
    let names = ["n512-e0043", "n512-e0044"].map(cell_name);
    let other = Region::new(territory, names.to_vec(), names[1].clone(), 1000.0, 150.0).unwrap();
    assert!(!Border::new(other).restore(&octets));
    for cut in 0..octets.len() {
        assert!(!border().restore(&octets[..cut]), "cut at {cut}");
    }
}

#[test]
fn aircraft_ids_count_in_base_32() {
    let text: Vec<String> = [0, 31, 32, 1023, u64::MAX].map(base_32).into();
    assert_eq!(text, ["0", "v", "10", "vv", "fvvvvvvvvvvvv"]);
}

#[test]
fn message_round_trips_and_truncation_is_an_error() {
    let messages = [
        offer(),
        CellMessageContent::RequestBlock,
        CellMessageContent::Accept { id: "U-a-1".into(), from: Slot(9) },
    ];
    for content in messages {
        let message = message(7, 3, content);
        let body = message.body();
        assert_eq!(CellMessage::parse(&body), Ok(message));
        for cut in 0..body.len() {
            assert!(CellMessage::parse(&body[..cut]).is_err(), "cut at {cut}");
        }
        assert!(CellMessage::parse(&[&body[..], &[0]].concat()).is_err(), "something behind it");
    }
}
