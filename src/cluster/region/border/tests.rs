mod nobodys;

use super::*;
use crate::cluster::region::letter::Offer;
use crate::territory::Territory;
use fusion::frames::Geodetic;
use fusion::time::Time;

fn named(name: &str) -> CellName {
    CellName::new(name).unwrap()
}

fn border() -> Border {
    let names = ["n512-e0043", "n512-e0044"].map(named);
    let territory = Territory::grid(0.1).unwrap();
    Border::new(Region::new(territory, names.to_vec(), names[0].clone(), 1000.0, 150.0).unwrap())
}

fn letter(slot: i64, index: u16, word: Word) -> Letter {
    Letter { from: named("n512-e0044"), to: named("n512-e0043"), slot: Slot(slot), index, word }
}

fn offer() -> Word {
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
    Word::Offer(Offer { id, number: 40_970_000, first_seen: Time::default(), transponder_number: None, seen })
}

#[test]
fn a_letter_counts_once() {
    let mut border = border();
    for _ in 0..3 {
        border.letter(&letter(7, 0, offer()));
    }
    assert_eq!((border.counts.unknown, border.counts.repeated), (1, 2));
    border.letter(&letter(7, 1, offer()));
    assert_eq!(border.counts.unknown, 2, "another letter of the same slot");
    // One that is older than what is remembered is one that was handled.
    border.letter(&letter(7 + REMEMBERED + 1, 0, offer()));
    border.letter(&letter(7, 0, offer()));
    assert_eq!((border.counts.unknown, border.counts.repeated), (3, 3));
    // What is not for this cell is none of its business.
    let other = Letter { to: named("n512-e0044"), ..letter(1000, 0, offer()) };
    border.letter(&other);
    assert_eq!(border.counts.unknown, 3);
}

#[test]
fn a_checkpoint_is_of_one_cell() {
    let mut known = border();
    known.letter(&letter(7, 0, Word::Block { first: 4096 }));
    let octets = known.checkpoint();
    let mut same = border();
    assert!(same.go_on(&octets));
    assert_eq!(same.state, known.state);
    let territory = Territory::grid(0.1).unwrap();
    let names = ["n512-e0043", "n512-e0044"].map(named);
    let other = Region::new(territory, names.to_vec(), names[1].clone(), 1000.0, 150.0).unwrap();
    assert!(!Border::new(other).go_on(&octets));
    for cut in 0..octets.len() {
        assert!(!border().go_on(&octets[..cut]), "cut at {cut}");
    }
}

#[test]
fn ids_count_in_32_digits() {
    let text: Vec<String> = [0, 31, 32, 1023, u64::MAX].map(base_32).into();
    assert_eq!(text, ["0", "v", "10", "vv", "fvvvvvvvvvvvv"]);
}

#[test]
fn a_letter_comes_back_and_a_cut_one_does_not() {
    let letters = [offer(), Word::Wanted, Word::Take { id: "U-a-1".into(), from: Slot(9) }];
    for word in letters {
        let letter = letter(7, 3, word);
        let body = letter.body();
        assert_eq!(Letter::parse(&body), Ok(letter));
        for cut in 0..body.len() {
            assert!(Letter::parse(&body[..cut]).is_err(), "cut at {cut}");
        }
        assert!(Letter::parse(&[&body[..], &[0]].concat()).is_err(), "something behind it");
    }
}
