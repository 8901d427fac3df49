//! The layouts compared with the machine-readable definitions of the asterix-specs project, which are not part of this project.
//! They are in the folder `../asterix` next to the one that `UTM_FUSION_SHARED_DATA` names.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

#[path = "common/definition.rs"]
mod definition;
#[path = "common/recordings.rs"]
#[allow(dead_code, reason = "the definitions lie beside the recordings")]
mod recordings;

use definition::{Complaints, category, compare, expansion, table};
use serde_json::{Value, json};
use utm_asterix::cat021::{self, Edition};
use utm_asterix::cat034::{self, Channels, CounterKind, Filter};
use utm_asterix::cat048::expansion::{
    DataLinkOrigin, DataLinkState, ExtendedMode4, ReplyType, TrackAcquisition,
};
use utm_asterix::cat048::{self, Communications, DetectionType, FlightStatus, Height3D, warning_name};
use utm_asterix::{
    Contents, Describe, Field, Kind, Layout, Quantity, Subfield, UapItem, cat015, cat062, cat063,
};

/// A definition; `None`, with a message, if it is not available.
fn definition(file: &str) -> Option<Value> {
    let folder = recordings::shared_data()?;
    let path = folder.join("../asterix/specs").join(format!("{file}.gz"));
    let Ok(packed) = std::fs::read(&path) else {
        eprintln!("skipped: there is no {}", path.display());
        return None;
    };
    Some(serde_json::from_reader(flate2::read::GzDecoder::new(packed.as_slice())).unwrap())
}

/// Compares the definition of the reserved expansion field of a category.
fn expansion_of(definition: &Value, uap: &[UapItem]) -> Complaints {
    let field = uap.iter().find(|item| item.item == "RE").unwrap();
    let Layout::Explicit(Contents::Expansion(subfields)) = field.layout else { panic!() };
    expansion(definition, subfields)
}

/// Differences between our layouts and the definition of each edition of CAT021: later additions in spare or absent bits, and a
/// changed name.
const LATER: [(Edition, &[&str]); 7] = [
    (Edition::V2_1, &["040", "090", "200", "295/ISA"]),
    (Edition::V2_2, &["040", "090", "295/ISA"]),
    (Edition::V2_3, &["040", "090", "295/ISA"]),
    (Edition::V2_4, &["040", "090", "295/ISA"]),
    (Edition::V2_5, &["040", "090", "295/ISA"]),
    (Edition::V2_6, &["090"]),
    (Edition::V2_7, &[]),
];

#[test]
fn editions_differ_where_they_are_said_to() {
    for (edition, later) in LATER {
        let Some(definition) = definition(&format!("cat021-{edition}.json")) else { return };
        let complaints = category(&definition, edition.profile());
        let is_later = |complaint: &String| later.iter().any(|place| complaint.starts_with(place));
        assert!(complaints.iter().all(is_later), "{edition}: {complaints:?}");
        assert!(later.iter().all(|place| complaints.iter().any(|complaint| complaint.starts_with(place))));
    }
    // In the wrong edition I021/271 differs, too.
    let definition = definition("cat021-2.1.json").unwrap();
    let complaints = category(&definition, Edition::V2_2.profile());
    assert!(complaints.iter().any(|complaint| complaint.starts_with("271")));
}

/// A comparison of a definition with our layouts.
type Comparison = fn(&Value) -> Complaints;

const COMPARISONS: [(&str, Comparison); 9] = [
    ("cat015-1.2.json", |definition| category(definition, cat015::UAP)),
    ("cat021-2.7.json", |definition| category(definition, cat021::UAP)),
    ("cat021-ref-1.5.json", |definition| expansion_of(definition, cat021::UAP)),
    ("cat062-1.21.json", |definition| category(definition, cat062::UAP)),
    ("cat062-ref-1.3.json", |definition| expansion_of(definition, cat062::UAP)),
    ("cat063-1.7.json", |definition| category(definition, cat063::UAP)),
    ("cat034-1.29.json", |definition| category(definition, cat034::UAP)),
    ("cat048-1.32.json", |definition| category(definition, cat048::UAP)),
    ("cat048-ref-1.13.json", |definition| expansion_of(definition, cat048::UAP)),
];

#[test]
fn layouts_are_those_of_the_definitions() {
    for (file, compare) in COMPARISONS {
        let Some(definition) = definition(file) else { return };
        assert_eq!(compare(&definition), Complaints::default(), "{file}");
    }
}

/// The tables of categories without types are what `make.py` makes of the definitions.
#[test]
fn tables_are_those_of_the_definitions() {
    let Some(folder) = recordings::shared_data() else { return };
    let make = concat!(env!("CARGO_MANIFEST_DIR"), "/definitions/make.py");
    let mut command = std::process::Command::new("python3");
    let Ok(done) = command.arg(make).arg(folder.join("../asterix/specs")).arg("--check").output() else {
        return eprintln!("skipped: there is no python3");
    };
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
}

/// Whether our table names a code.
type Named = fn(u8) -> bool;

/// The place of a table of codes, the number of bits of a code, and the codes that we name.
const TABLES: [(&str, &[&str], u32, Named); 27] = [
    ("cat015-1.2.json", &["000", "MT"], 7, |code| {
        !matches!(cat015::MessageKind::from_code(code), cat015::MessageKind::Other(_))
    }),
    ("cat021-2.7.json", &["008", "TC"], 2, |code| {
        !matches!(cat021::TrajectoryCapability::from_code(code), cat021::TrajectoryCapability::Other(_))
    }),
    ("cat021-2.7.json", &["020"], 8, |code| {
        !matches!(cat021::EmitterCategory::from_code(code), cat021::EmitterCategory::Other(_))
    }),
    ("cat021-2.7.json", &["040", "ATP"], 3, |code| {
        !matches!(cat021::AddressType::from_code(code), cat021::AddressType::Other(_))
    }),
    ("cat021-2.7.json", &["040", "CL"], 2, |code| {
        !matches!(cat021::Confidence::from_code(code), cat021::Confidence::Other(_))
    }),
    ("cat021-2.7.json", &["074", "FSI"], 2, |code| {
        !matches!(cat021::SecondIndication::from_code(code), cat021::SecondIndication::Other(_))
    }),
    ("cat021-2.7.json", &["110", "TID", "PT"], 4, |code| {
        !matches!(cat021::PointType::from_code(code), cat021::PointType::Other(_))
    }),
    ("cat021-2.7.json", &["200", "PS"], 3, |code| {
        !matches!(cat021::PriorityStatus::from_code(code), cat021::PriorityStatus::Other(_))
    }),
    ("cat021-2.7.json", &["210", "VN"], 3, |code| {
        !matches!(cat021::Standard::from_code(code), cat021::Standard::Other(_))
    }),
    ("cat021-2.7.json", &["210", "LTT"], 3, |code| {
        !matches!(cat021::LinkTechnology::from_code(code), cat021::LinkTechnology::Other(_))
    }),
    ("cat062-1.21.json", &["245", "STI"], 2, |code| {
        !matches!(cat062::IdentificationSource::from_code(code), cat062::IdentificationSource::Other(_))
    }),
    ("cat062-1.21.json", &["300"], 8, |code| {
        !matches!(cat062::Fleet::from_code(code), cat062::Fleet::Other(_))
    }),
    ("cat062-1.21.json", &["380", "TAR", "TI"], 2, |code| {
        !matches!(cat062::TurnIndicator::from_code(code), cat062::TurnIndicator::Other(_))
    }),
    ("cat062-ref-1.3.json", &["CST", "TYP"], 4, |code| {
        !matches!(
            cat062::expansion::SensorDetection::from_code(code),
            cat062::expansion::SensorDetection::Other(_)
        )
    }),
    ("cat034-1.29.json", &["000"], 8, |code| {
        !matches!(cat034::MessageKind::from_code(code), cat034::MessageKind::Other(_))
    }),
    ("cat034-1.29.json", &["050", "PSR", "CHAB"], 2, |code| {
        !matches!(Channels::from_code(code), Channels::Other(_))
    }),
    ("cat034-1.29.json", &["070", "TYP"], 5, |code| {
        !matches!(CounterKind::from_code(code), CounterKind::Other(_))
    }),
    ("cat034-1.29.json", &["110"], 8, |code| !matches!(Filter::from_code(code), Filter::Other(_))),
    ("cat048-1.32.json", &["020", "TYP"], 3, |code| code <= DetectionType::ModeSRollCallAndPrimary as u8),
    ("cat048-1.32.json", &["030"], 7, |code| warning_name(code).is_some()),
    ("cat048-1.32.json", &["230", "COM"], 3, |code| {
        !matches!(Communications::from_code(code), Communications::Other(_))
    }),
    ("cat048-1.32.json", &["230", "STAT"], 3, |code| {
        !matches!(FlightStatus::from_code(code), FlightStatus::Other(_))
    }),
    ("cat048-ref-1.13.json", &["RTC", "DLK", "ORIGIN"], 2, |code| {
        !matches!(DataLinkOrigin::from_code(code), DataLinkOrigin::Other(_))
    }),
    ("cat048-ref-1.13.json", &["RTC", "DLK", "STATE"], 2, |code| {
        !matches!(DataLinkState::from_code(code), DataLinkState::Other(_))
    }),
    ("cat048-ref-1.13.json", &["RTC", "TLC", "ACQI"], 2, |code| {
        !matches!(TrackAcquisition::from_code(code), TrackAcquisition::Other(_))
    }),
    ("cat048-ref-1.13.json", &["CPC", "RPL", "TYPE"], 8, |code| {
        !matches!(ReplyType::from_code(code), ReplyType::Other(_))
    }),
    ("cat048-ref-1.13.json", &["M4E", "FOEFRI"], 2, |code| ExtendedMode4::new(code).is_some()),
];

#[test]
fn codes_are_those_of_the_definitions() {
    for (file, path, bits, named) in TABLES {
        let Some(definition) = definition(file) else { return };
        let theirs = table(&definition, path, 1 << bits).unwrap_or_else(|| panic!("{file}: no {path:?}"));
        let ours: Vec<u64> = (0..1 << bits).filter(|&code| named(code as u8)).collect();
        assert_eq!(theirs, ours, "{file}: {path:?}");
    }
}

/// Pointers to every value in `value`.
fn pointers(value: &Value, here: &str, found: &mut Vec<String>) {
    found.push(here.to_owned());
    match value {
        Value::Object(members) => {
            for (name, member) in members {
                pointers(member, &format!("{here}/{name}"), found);
            }
        }
        Value::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                pointers(element, &format!("{here}/{index}"), found);
            }
        }
        _ => {}
    }
}

/// A changed value for this one, if it concerns the octets.
fn changed(pointer: &str, value: &Value) -> Option<Value> {
    let last = pointer.rsplit('/').next()?;
    Some(match (last, value) {
        ("bitSize" | "byteSize" | "fspecByteSize" | "exponent" | "base", Value::Number(number)) => {
            json!(number.as_u64()? + 1)
        }
        ("unit", Value::String(unit)) => json!(format!("1000 {unit}")),
        (_, Value::Object(members)) => match (members.get("tag")?.as_str()?, members.get("contents")?) {
            ("Signed", _) => json!({"tag": "Unsigned", "contents": []}),
            ("Unsigned", _) => json!({"tag": "Signed", "contents": []}),
            ("Spare", bits) => json!({"tag": "Spare", "contents": bits.as_u64()? + 1}),
            ("NumInt", number) if !pointer.contains("/constraints/") => {
                json!({"tag": "NumInt", "contents": number.as_i64()? + 1})
            }
            ("UapItem", _) => json!({"tag": "UapItem", "contents": "999"}),
            ("Group", Value::Array(members)) if members.len() > 1 => {
                let turned: Vec<_> = members.iter().rev().collect();
                if turned.iter().copied().eq(members) {
                    return None;
                }
                json!({"tag": "Group", "contents": turned})
            }
            ("Compound", Value::Array(members)) => {
                let turned: Vec<_> = members.iter().rev().collect();
                json!({"tag": "Compound", "contents": turned})
            }
            ("StringOctal", _) => json!({"tag": "StringICAO", "contents": []}),
            ("StringICAO", _) => json!({"tag": "StringAscii", "contents": []}),
            _ => return None,
        },
        _ => return None,
    })
}

/// A change of the definition in any single place is detected.
#[test]
fn every_difference_is_noticed() {
    for (file, compare) in COMPARISONS {
        let Some(mut definition) = definition(file) else { return };
        let (mut all, mut tried) = (Vec::new(), 0);
        pointers(&definition, "", &mut all);
        for pointer in all
            .iter()
            .filter(|pointer| !["/constraints/", "/cases/"].iter().any(|part| pointer.contains(part)))
        {
            let original = definition.pointer(pointer).unwrap().clone();
            let Some(other) = changed(pointer, &original) else { continue };
            *definition.pointer_mut(pointer).unwrap() = other;
            assert_ne!(compare(&definition), Complaints::default(), "{file} {pointer}");
            *definition.pointer_mut(pointer).unwrap() = original;
            tried += 1;
        }
        assert_eq!(compare(&definition), Complaints::default(), "{file}");
        eprintln!("{file}: {tried} changes, all noticed");
        assert!(tried > 50);
    }
}

const fn field(key: &'static str, bits: u16, kind: Kind) -> Field {
    Field::new(key, bits, kind)
}

const fn quantity(signed: bool, lsb: f64) -> Kind {
    Kind::Quantity(Quantity { signed, lsb, decimals: 2, unknown: None })
}

const SPARE: Field = field("spare", 2, Kind::Spare);
const RIGHT: Kind = quantity(true, 7.62);

/// Layouts of I048/110 with one error each.
const WRONG: [Layout; 14] = [
    Layout::Fields(&[field("height_m", 14, RIGHT), SPARE]),
    Layout::Fields(&[field("spare", 2, Kind::Count), field("height_m", 14, RIGHT)]),
    Layout::Fields(&[field("spare", 3, Kind::Spare), field("height_m", 13, RIGHT)]),
    Layout::Fields(&[SPARE, field("height_ft", 14, RIGHT)]),
    Layout::Fields(&[SPARE, field("width_m", 14, RIGHT)]),
    Layout::Fields(&[SPARE, field("height_m", 14, quantity(false, 7.62))]),
    Layout::Fields(&[SPARE, field("height_m", 14, quantity(true, 7.6))]),
    Layout::Fields(&[SPARE, field("height_m", 14, Kind::Count)]),
    Layout::Fields(&[SPARE, field("height_m", 7, RIGHT), field("more_m", 7, RIGHT)]),
    Layout::Fields(&[SPARE]),
    Layout::Fields(&[SPARE, field("height_m", 14, RIGHT), field("more", 8, Kind::Count)]),
    Layout::Repetitive(&[SPARE, field("height_m", 14, RIGHT)]),
    Layout::Extended(&[&[SPARE, field("height_m", 14, RIGHT)]]),
    Layout::Compound(&[Subfield::new("3dh", Height3D::LAYOUT)]),
];

#[test]
fn wrong_layouts_are_noticed() {
    let element = |bits: u8, content: Value| {
        let rule = json!({"tag": "ContextFree", "contents": content});
        json!({"tag": "Element", "contents": {"bitSize": bits, "rule": rule}})
    };
    let named = |name: &str, variation: Value| {
        let rule = json!({"tag": "ContextFree", "contents": variation});
        json!({"tag": "Item", "contents": {"name": name, "rule": rule}})
    };
    let feet = json!({"tag": "ContentQuantity", "contents": {
        "lsb": {"tag": "NumInt", "contents": 25}, "unit": "ft", "signedness": {"tag": "Signed", "contents": []},
    }});
    let spare = json!({"tag": "Spare", "contents": 2});
    let height = json!({"tag": "Group", "contents": [spare, named("3DH", element(14, feet))]});
    assert_eq!(compare(&height, Height3D::LAYOUT, "", "110"), Complaints::default());

    for wrong in WRONG {
        assert_ne!(compare(&height, wrong, "", "110"), Complaints::default(), "{wrong:?}");
    }
}
