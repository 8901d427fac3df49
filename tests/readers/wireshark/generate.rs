//! Generates the items of the dissector, and a definition in the form of the asterix-specs project, from the codec's description
//! of CAT129.

use std::fmt::Write;

use asterix::cat129::fusion_report::{Deviation, Flags, Source, UavProbability};
use asterix::cat129::{FusionReport, RiskCategories, UAP};
use asterix::{Contents, Field, Kind, Layout, UapItem};

/// First of the two lines that enclose the items in the dissector.
const BEGIN: &str = "-- items: made of asterix/src/cat129 by tests/readers/wireshark/generate.rs; UPDATE=1 makes them anew.\n";
const END: &str = "-- end of items\n";

/// Number of field reference numbers of the edition, including reserved ones.
const FRNS: u8 = 21;

/// The dissector with its items generated again.
pub fn dissector(kept: &str) -> String {
    let (head, rest) = kept.split_once(BEGIN).unwrap();
    let (_, tail) = rest.split_once(END).unwrap();
    format!("{head}{BEGIN}{}{END}{tail}", items())
}

fn items() -> String {
    let mut out = "local ITEMS = {\n".to_owned();
    for item in UAP {
        let (is, fields, more) = match item.layout {
            Layout::Fields(fields @ [field]) if field.key.is_empty() => ("value", fields, String::new()),
            Layout::Fields(fields) => ("fields", fields, String::new()),
            Layout::OneOrThree(fields) => ("one_or_three", fields, String::new()),
            Layout::Explicit(Contents::Known(_)) => {
                ("explicit", &[][..], ", known_title = \"of the fusion service\"".to_owned())
            }
            other => panic!("the dissector knows no {other:?}"),
        };
        let UapItem { frn, item: number, name, .. } = item;
        let _ = writeln!(
            out,
            "    [{frn}] = {{ number = {number:?}, title = {name:?}, is = {is:?}{more}, parts = {{"
        );
        for field in fields {
            let _ = writeln!(out, "        {{ {} }},", part(item, field));
        }
        out.push_str("    }");
        if let Layout::Explicit(Contents::Known(forms)) = item.layout {
            out.push_str(", forms = {\n");
            for form in forms {
                let _ = writeln!(out, "        {{ known = {:?}, parts = {{", form.key);
                for field in form.fields {
                    let _ = writeln!(out, "            {{ {} }},", part(item, field));
                }
                out.push_str("        } },\n");
            }
            out.push_str("    }");
        }
        out.push_str(" },\n");
    }
    out + "}\n"
}

/// A field as members of a Lua table.
fn part(item: &UapItem, field: &Field) -> String {
    let name = name_of(field);
    let mut out = format!("key = {:?}, title = {:?}, bits = {}, is = ", field.key, name.title, field.bits);
    let is = match field.kind {
        Kind::Spare => "\"spare\"".to_owned(),
        Kind::Constant(value) => format!("\"constant\", value = {value}"),
        Kind::Ascii => "\"text\"".to_owned(),
        Kind::Count => "\"count\"".to_owned(),
        Kind::CountFrom(first) => format!("\"count\", first = {first}"),
        // Shown as a quantity if it has a unit, otherwise as a number.
        Kind::CountOr(unknown) if name.unit.is_empty() => format!("\"count\", unknown = {unknown}"),
        Kind::CountOr(unknown) => {
            format!("\"quantity\", lsb = 1, decimals = 0, unit = {:?}, unknown = {unknown}", name.lua_unit())
        }
        Kind::Quantity(quantity) => {
            let mut text = format!("\"quantity\", lsb = {}", fraction(quantity.lsb));
            let _ = write!(text, ", decimals = {}, unit = {:?}", quantity.decimals, name.lua_unit());
            if quantity.signed {
                text += ", signed = true";
            }
            if let Some(unknown) = quantity.unknown {
                let _ = write!(text, ", unknown = {unknown}");
            }
            if field.key.is_empty() {
                text += ", clock = true";
            }
            text
        }
        other => panic!("the dissector knows no {other:?}"),
    };
    out += &is;
    let codes = codes(item.item, field);
    if !codes.is_empty() {
        let codes: Vec<String> = codes.iter().map(|(code, name)| format!("[{code}] = {name:?}")).collect();
        let _ = write!(out, ", codes = {{ {} }}", codes.join(", "));
    }
    out
}

/// Human-readable form of a key.
struct Name {
    /// Name without unit: `"Air risk category"`.
    title: String,
    /// Unit, such as `°`, `m`, `m/s`, `s`; empty if there is none.
    unit: &'static str,
    /// Name in capitals, as in asterix-specs: `"AIR_RISK_CATEGORY"`.
    capitals: String,
}

impl Name {
    /// Unit as written after a number.
    fn lua_unit(&self) -> String {
        if matches!(self.unit, "" | "°") { self.unit.to_owned() } else { format!(" {}", self.unit) }
    }
}

fn name_of(field: &Field) -> Name {
    const UNITS: [(&str, &str); 3] = [("_m_s", "m/s"), ("_deg", "°"), ("_m", "m")];
    let found = UNITS.iter().find_map(|(end, unit)| Some((field.key.strip_suffix(end)?, *unit)));
    let (plain, unit) = match (found, field.kind) {
        (Some(found), _) => found,
        // The only quantity without a key is the time of day.
        (None, Kind::Quantity(_)) if field.key.is_empty() => ("", "s"),
        (None, _) => (field.key, ""),
    };
    let title = match plain {
        "sac" => "System Area Code".to_owned(),
        "sic" => "System Identification Code".to_owned(),
        "dac" => "Destination Area Code".to_owned(),
        "dic" => "Destination Identification Code".to_owned(),
        "uav_probability" => "UAV probability".to_owned(),
        _ => {
            let words = plain.replace('_', " ");
            let (first, rest) = words.split_at(words.len().min(1));
            first.to_uppercase() + rest
        }
    };
    Name { title, unit, capitals: plain.to_uppercase() }
}

/// Names of the codes of a field, if it has any.
fn codes(item: &str, field: &Field) -> Vec<(u64, String)> {
    match (item, field.key) {
        ("120", "certification_category") => (0..4)
            .map(|code| {
                (code.into(), format!("{:?}", RiskCategories::from_octets([code << 6]).certification()))
            })
            .collect(),
        ("SP", "source") => [Source::Fused, Source::Radar, Source::Transponder, Source::Camera]
            .map(|source| (said_source(source), format!("{source:?}")))
            .to_vec(),
        ("SP", _) if field.bits == 1 => vec![(0, "no".to_owned()), (1, "yes".to_owned())],
        _ => Vec::new(),
    }
}

/// Code of a source in the special purpose field.
fn said_source(source: Source) -> u64 {
    let report = FusionReport {
        source,
        track_number: 0,
        radar_track: None,
        transponder: None,
        horizontal_deviation: Deviation::UNKNOWN,
        vertical_deviation: Deviation::UNKNOWN,
        flags: Flags::default(),
        uav_probability: UavProbability::UNKNOWN,
    };
    let place: u16 =
        FusionReport::FIELDS.iter().take_while(|field| field.key != "source").map(|f| f.bits).sum();
    report.to_field().contents()[usize::from(place / 8)].into()
}

/// An LSB in the notation of the specification.
fn fraction(lsb: f64) -> String {
    for over in [1.0, 180.0] {
        let under = (over / lsb).round();
        if over / under == lsb {
            return match (under, under.log2()) {
                (1.0, _) => over.to_string(),
                (_, power) if power.fract() == 0.0 => format!("{over}/2^{power}"),
                _ => format!("{over}/{under}"),
            };
        }
    }
    panic!("{lsb} is no fraction that a specification would have");
}

/// The category in the form of asterix-specs.
pub fn definition() -> String {
    let mut out =
        "asterix 129 \"UAS Identification Reports\"\nedition 1.2\ndate 2019-06-12\npreamble\n".to_owned();
    out += "    Surveillance data exchange.\n\n    Made of the layouts of utm-fusion by tests/readers/wireshark/generate.rs.\n\nitems\n";
    for item in UAP {
        let _ = writeln!(out, "\n    {} {:?}", item.item, item.name);
        match item.layout {
            Layout::Fields([field]) => element(&mut out, 8, item, field),
            Layout::Fields(fields) => group(&mut out, item, fields),
            Layout::OneOrThree(fields) => {
                group(&mut out, item, fields);
                out += "        remark\n            Edition 1.2 contradicts itself: its table of items says one octet, its section 5.2.12\n            three, of which it describes the first.\n";
            }
            Layout::Explicit(_) => out += "        explicit sp\n",
            other => panic!("no form for {other:?}"),
        }
    }
    out += "\nuap\n";
    for frn in 1..=FRNS {
        let item = UAP.iter().find(|item| item.frn == frn);
        let _ = writeln!(out, "    {}", item.map_or("-", |item| item.item));
    }
    out
}

fn group(out: &mut String, item: &UapItem, fields: &[Field]) {
    out.push_str("        group\n");
    for field in fields {
        if field.kind == Kind::Spare {
            let _ = writeln!(out, "            spare {}", field.bits);
        } else {
            let name = name_of(field);
            let _ = writeln!(out, "            {} {:?}", name.capitals, name.title);
            element(out, 16, item, field);
        }
    }
}

fn element(out: &mut String, indent: usize, item: &UapItem, field: &Field) {
    let unit = name_of(field).unit;
    let content = match field.kind {
        Kind::Ascii => "string ascii".to_owned(),
        Kind::CountOr(_) => format!("unsigned quantity 1 {unit:?}"),
        Kind::Quantity(quantity) => {
            let sign = if quantity.signed { "signed" } else { "unsigned" };
            format!("{sign} quantity {} {unit:?}", fraction(quantity.lsb))
        }
        Kind::CountFrom(first) => {
            table((0..1 << field.bits).map(|code| (code, (code + first).to_string())), indent)
        }
        Kind::Count => match codes(item.item, field) {
            codes if codes.is_empty() => "raw".to_owned(),
            codes => table(codes, indent),
        },
        other => panic!("no form for {other:?}"),
    };
    let _ = writeln!(out, "{:indent$}element {}\n{:indent$}    {content}", "", field.bits, "");
}

fn table(codes: impl IntoIterator<Item = (u64, String)>, indent: usize) -> String {
    codes.into_iter().fold("table".to_owned(), |mut table, (code, name)| {
        let _ = write!(table, "\n{:indent$}        {code}: {name}", "");
        table
    })
}
