//! Compares machine-readable definitions in the form of the asterix-specs project with layouts.

use serde_json::Value;
use utm_asterix::{Contents, Field, Kind, Layout, Subfield, UapItem};

/// Differences with their places.
pub type Complaints = Vec<String>;

/// Names of the definitions that differ from our keys, with ours; without units, capitals and underscores.
const RENAMED: &str = "3dh=height altfl=flightlevel altm2=code altm3=code amb=ambiguity azm=azimuth cal=speed d1=day
    dop=doppler fl=flightlevel frq=frequency ga=altitude gsp=speed hdg=heading hgt=height lasttrkupd=lastupdate
    lat=latitude loctim=time lon=longitude m1=month m3a=mode3aage mbdata=data modec=modecgray plotnr=plotnumber
    predrho=rho predtheta=theta predtime=time qa4=lowquality qc1=lowquality rcsdb=dbm2 rcsm=m2 replynbr=replynumber
    rhost=rhostart rng=range sacadjs=sac sicadjs=sic sigh=sigmah sigv=sigmav sigx=sigmax sigy=sigmay tcode1=code1
    tcode2=code2 tcode3=code3 tcount1=count1 tcount2=count2 tcount3=count3 thetast=thetastart timeofdayscn=time
    alt=altitude as=airspeed bvr=rate ctb=flightlevel gs=speed gvr=rate ias=airspeed ident=unit lmc=flightlevel
    prb=bias prg=gain s=source src=source srb=bias srg=gain ta=track tar=rate track=tracknumber
    trkupdctr=updates trnum=tracknumber trn=tracknumber y1=year
    uci6=upper lci6=lower uci9=upper lci9=lower cohvxhpx=xx cohvxhpy=xy cohvyhpx=yx cohvyhpy=yy cohaxhpx=xx
    cohaxhpy=xy cohayhpx=yx coayhpy=yy cohaxhvx=xx cohaxhvy=xy cohayhvx=yx cohayhvy=yy sdazr=deviation
    sdelr=deviation coazraz=correlation coelrel=correlation s=start e=end";

/// Units of the definitions, our suffix (or whole key), and the factor to our unit.
const UNITS: &[(&str, &str, f64)] = &[
    ("", "gain", 1.0),
    ("%", "_percent", 1.0),
    ("Mach", "mach", 1.0),
    ("ALTFL", "flight_level", 1.0),
    ("FL", "flight_level", 1.0),
    ("MHz", "_mhz", 1.0),
    ("NM", "_m", 1852.0),
    ("NM/s", "_m_s", 1852.0),
    ("dB", "_db", 1.0),
    ("dBm", "_dbm", 1.0),
    ("dBm²", "dbm2", 1.0),
    ("ft", "_ft", 1.0),
    ("ft/min", "_m_s", 0.3048 / 60.0),
    ("hPa", "_hpa", 1.0),
    ("kt", "_m_s", 1852.0 / 3600.0),
    ("ft", "_m", 0.3048),
    ("m", "_m", 1.0),
    ("m/s", "_m_s", 1.0),
    ("m/s²", "_m_s2", 1.0),
    ("mb", "_hpa", 1.0),
    ("ms", "_ms", 1.0),
    ("m²", "m2", 1.0),
    ("s", "_s", 1.0),
    ("°", "_deg", 1.0),
    ("°/s", "_deg_s", 1.0),
    ("°C", "_c", 1.0),
    // Correlations have no unit; the rates of I015/627 are in degrees in the definition.
    ("", "", 1.0),
    ("°", "_deg_s", 1.0),
];

/// Pulses of low quality, which are the bits of an octal code.
const OCTAL_PULSES: [&str; 12] =
    ["QA4", "QA2", "QA1", "QB4", "QB2", "QB1", "QC4", "QC2", "QC1", "QD4", "QD2", "QD1"];

/// A line of a group in a definition: a name with its content, or spare bits.
struct Line<'a> {
    name: Option<String>,
    bits: u64,
    content: &'a Value,
}

fn tag(value: &Value) -> &str {
    value["tag"].as_str().unwrap_or("")
}

/// The content of a rule that does not depend on other items, or else its default.
fn free(rule: &Value) -> &Value {
    match tag(rule) {
        "ContextFree" => &rule["contents"],
        "Dependent" => &rule["contents"]["default"],
        other => panic!("unknown rule {other}"),
    }
}

fn number(value: &Value) -> f64 {
    let contents = &value["contents"];
    match tag(value) {
        "NumInt" => contents.as_f64().unwrap_or(f64::NAN),
        "NumDiv" => number(&contents["numerator"]) / number(&contents["denominator"]),
        "NumPow" => {
            let exponent = contents["exponent"].as_i64().unwrap_or(0) as i32;
            contents["base"].as_f64().unwrap_or(f64::NAN).powi(exponent)
        }
        other => panic!("no number: {other}"),
    }
}

/// The lines of an item in a group or extended item; nested groups are flattened.
fn lines<'a>(item: &'a Value, group: &str, found: &mut Vec<Line<'a>>) {
    if tag(item) == "Spare" {
        let bits = item["contents"].as_u64().unwrap_or(0);
        found.push(Line { name: None, bits, content: &Value::Null });
        return;
    }
    let name = match item["contents"]["name"].as_str().unwrap_or("") {
        "VAL" => group.to_owned(),
        name => format!("{group}{name}"),
    };
    of_variation(free(&item["contents"]["rule"]), &name, found);
}

/// The lines of an element or group with this name; the name of a whole item is empty.
fn of_variation<'a>(variation: &'a Value, name: &str, found: &mut Vec<Line<'a>>) {
    let contents = &variation["contents"];
    match tag(variation) {
        "Element" => {
            let bits = contents["bitSize"].as_u64().unwrap_or(0);
            let content = free(&contents["rule"]);
            if tag(&content["contents"]) == "BdsWithAddress" && bits == 64 {
                let parts = [("MBDATA", 56), ("BDS1", 4), ("BDS2", 4)];
                found.extend(parts.map(|(name, bits)| Line { name: Some(name.to_owned()), bits, content }));
                return;
            }
            found.push(Line { name: Some(name.to_owned()), bits, content: free(&contents["rule"]) });
        }
        "Group" => {
            for item in contents.as_array().into_iter().flatten() {
                lines(item, name, found);
            }
        }
        other => panic!("{name} has fields, but is {other}"),
    }
}

/// A key or name in a common spelling.
fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', '-'], "")
}

fn same_name(name: &str, key: &str) -> bool {
    let name = plain(name);
    let ours = [key].into_iter().chain(UNITS.iter().filter_map(|(_, suffix, _)| key.strip_suffix(suffix)));
    let is = |wanted: &str| ours.clone().any(|ours| plain(ours) == wanted);
    let long = name.replace("evol", "evolution");
    is(&name)
        || is(&long)
        || RENAMED
            .split_whitespace()
            .filter_map(|pair| pair.split_once('='))
            .any(|(theirs, ours)| theirs == name && is(ours))
}

/// Compares a field with its content; `unit_key` is the key with the unit.
fn compare_content(content: &Value, field: &Field, unit_key: &str) -> Option<String> {
    let contents = &content["contents"];
    let signed = tag(&contents["signedness"]) == "Signed";
    let (lsb, unit) = match tag(content) {
        "ContentRaw" | "ContentTable" | "ContentBds" => (None, ""),
        "ContentInteger" => (signed.then_some(1.0), ""),
        "ContentQuantity" => (Some(number(&contents["lsb"])), contents["unit"].as_str().unwrap_or("")),
        "ContentString" => {
            let same = match tag(contents) {
                "StringOctal" => field.kind == Kind::Octal,
                "StringICAO" => field.kind == Kind::Icao,
                "StringAscii" => field.kind == Kind::Ascii,
                _ => false,
            };
            return (!same).then(|| format!("{} is not {:?}", tag(contents), field.kind));
        }
        other => return Some(format!("unknown content {other}")),
    };
    // A time of day has a key without a name.
    let factor = (UNITS.iter())
        .find(|&&(theirs, suffix, _)| theirs == unit && (unit_key.ends_with(suffix) || unit_key.is_empty()))
        .map(|&(_, _, factor)| factor);
    match (lsb, field.kind) {
        (None, Kind::Count | Kind::Hex | Kind::Octal | Kind::Address) => None,
        (Some(_), _) if factor.is_none() => Some(format!("unit {unit:?} under key {unit_key:?}")),
        (Some(lsb), Kind::Quantity(ours)) => {
            let wanted = lsb * factor.unwrap_or(f64::NAN);
            let same = (ours.lsb / wanted - 1.0).abs() < 1e-12 && ours.signed == signed;
            (!same).then(|| format!("LSB {wanted}, signed: {signed}, is not {ours:?}"))
        }
        (Some(1.0), Kind::Count) if !signed && factor == Some(1.0) => None,
        (lsb, kind) => Some(format!("LSB {lsb:?} {unit} is not {kind:?}")),
    }
}

/// Compares fields with lines in order.
fn compare_fields(wanted: &[Line<'_>], fields: &[Field], subfield_key: &str, path: &str) -> Complaints {
    let mut complaints = Complaints::new();
    let mut rest = wanted;
    for field in fields {
        let place = format!("{path} {:?}", field.key);
        let bits = u64::from(field.bits);
        let Some((line, after)) = rest.split_first() else {
            complaints.push(format!("{place}: not in the definition"));
            return complaints;
        };
        rest = after;
        let Some(name) = &line.name else {
            if field.kind != Kind::Spare || bits != line.bits {
                complaints.push(format!("{place}: {} spare bits", line.bits));
            }
            continue;
        };
        if field.kind == Kind::Spare {
            complaints.push(format!("{place}: spare, but {name} of {} bits", line.bits));
            continue;
        }
        let unit_key = if field.key.is_empty() { subfield_key } else { field.key };
        if line.bits == bits {
            let content = compare_content(line.content, field, unit_key);
            complaints.extend(content.map(|content| format!("{place}: {content}")));
        } else {
            // Pulses of one bit each are one field here, as are decimal digits of four bits each.
            let count = (bits / line.bits.max(1)) as usize;
            let together: Vec<_> = [line].into_iter().chain(rest).take(count).collect();
            let names: Vec<&str> = together.iter().filter_map(|line| line.name.as_deref()).collect();
            let of_bits = |width| together.iter().all(|line| line.bits == width);
            let pulses = of_bits(1) && names.iter().all(|name| name.starts_with('Q'));
            let digits = of_bits(4)
                && names.iter().all(|digit| digit[..1] == name[..1])
                && together.iter().all(|line| tag(&line.content["contents"]["signedness"]) == "Unsigned");
            let kind = match field.kind {
                Kind::Octal => pulses && names == OCTAL_PULSES,
                Kind::Hex => pulses || digits,
                Kind::Count => pulses,
                _ => false,
            };
            if !kind || names.len() as u64 * line.bits != bits {
                complaints.push(format!("{place}: {bits} bits, but {name} has {}", line.bits));
            }
            rest = &rest[names.len().saturating_sub(1).min(rest.len())..];
        }
        if !name.is_empty() && !field.key.is_empty() && !same_name(name, field.key) {
            complaints.push(format!("{place}: is called {name}"));
        }
    }
    if !rest.is_empty() {
        complaints.push(format!("{path}: {} more in the definition", rest.len()));
    }
    complaints
}

/// Compares a variation (the structure of an item) with a layout.
pub fn compare(variation: &Value, layout: Layout, key: &str, path: &str) -> Complaints {
    let contents = &variation["contents"];
    let members = || contents.as_array().map_or(&[][..], Vec::as_slice);
    let fields_of = |variation, fields| {
        let mut wanted = Vec::new();
        of_variation(variation, "", &mut wanted);
        compare_fields(&wanted, fields, key, path)
    };
    match (tag(variation), layout) {
        ("Element" | "Group", Layout::Fields(fields)) => fields_of(variation, fields),
        ("Extended", Layout::Extended(octets)) => {
            let parts: Vec<&[Value]> = members().split_inclusive(Value::is_null).collect();
            if parts.len() != octets.len() || !members().last().is_some_and(Value::is_null) {
                return vec![format!("{path}: {} octets of seven bits", parts.len())];
            }
            let mut complaints = Complaints::new();
            for (index, (part, &fields)) in parts.iter().zip(octets).enumerate() {
                let mut wanted = Vec::new();
                part[..part.len() - 1].iter().for_each(|item| lines(item, "", &mut wanted));
                complaints.extend(compare_fields(&wanted, fields, "", &format!("{path}[{index}]")));
                if wanted.iter().map(|line| line.bits).sum::<u64>() != 7 {
                    complaints.push(format!("{path}[{index}]: not seven bits"));
                }
            }
            complaints
        }
        ("Extended", Layout::Parts(ours)) => {
            let parts: Vec<&[Value]> = members().split_inclusive(Value::is_null).collect();
            if parts.len() != ours.len() {
                return vec![format!("{path}: {} parts", parts.len())];
            }
            let mut complaints = Complaints::new();
            for (index, (part, &fields)) in parts.iter().zip(ours).enumerate() {
                let (mut wanted, extends) = (Vec::new(), part.last().is_some_and(Value::is_null));
                part.iter().filter(|item| !item.is_null()).for_each(|item| lines(item, "", &mut wanted));
                complaints.extend(compare_fields(&wanted, fields, "", &format!("{path}[{index}]")));
                let bits = wanted.iter().map(|line| line.bits).sum::<u64>();
                if (bits + u64::from(extends)) % 8 != 0 {
                    complaints.push(format!("{path}[{index}]: no whole octets"));
                }
            }
            complaints
        }
        ("Repetitive", Layout::Chained(fields)) => {
            if tag(&contents["type"]) != "RepetitiveFx" {
                return vec![format!("{path}: has no FX")];
            }
            fields_of(&contents["variation"], fields)
        }
        ("Repetitive", Layout::Codes) => {
            let seven = contents["variation"]["contents"]["bitSize"] == 7;
            let fx = tag(&contents["type"]) == "RepetitiveFx";
            if seven && fx { vec![] } else { vec![format!("{path}: no codes of seven bits")] }
        }
        ("Repetitive", Layout::Repetitive(fields)) => {
            if contents["type"]["contents"]["byteSize"] != 1 {
                return vec![format!("{path}: the count is not one octet")];
            }
            fields_of(&contents["variation"], fields)
        }
        ("Compound", Layout::Compound(subfields)) => compare_subfields(members(), subfields, path),
        ("Explicit", Layout::Explicit(ours)) => {
            // The contents of a special purpose field are agreed on by its users.
            let described = match tag(contents) {
                "ReservedExpansion" => true,
                "SpecialPurpose" => matches!(ours, Contents::Known(..)),
                _ => false,
            };
            let same = described || ours == Contents::Opaque;
            if same { vec![] } else { vec![format!("{path}: {ours:?}")] }
        }
        (other, layout) => vec![format!("{path}: {other} is not {layout:?}")],
    }
}

fn compare_subfields(wanted: &[Value], subfields: &[Subfield], path: &str) -> Complaints {
    let mut complaints = Complaints::new();
    for index in 0..wanted.len().max(subfields.len()) {
        let theirs = wanted.get(index).filter(|subfield| !subfield.is_null());
        let ours = subfields.get(index).filter(|subfield| !subfield.key.is_empty());
        match (theirs, ours) {
            (None, None) => {}
            (Some(theirs), Some(ours)) => {
                let name = theirs["name"].as_str().unwrap_or("");
                let path = format!("{path}/{name}");
                if !name.is_empty() && !same_name(name, ours.key) {
                    complaints.push(format!("{path}: is called {:?}", ours.key));
                }
                complaints.extend(compare(free(&theirs["rule"]), ours.layout, ours.key, &path));
            }
            (theirs, ours) => complaints.push(format!("{path}[{index}]: {theirs:?} is not {ours:?}")),
        }
    }
    complaints
}

/// Compares the definition of a category with its profile.
pub fn category(definition: &Value, uap: &[UapItem]) -> Complaints {
    let definition = &definition["contents"];
    let order = definition["uap"]["contents"].as_array().map_or(&[][..], Vec::as_slice);
    let mut complaints = Complaints::new();
    for frn in 1..=order.len().max(uap.last().map_or(0, |item| usize::from(item.frn))) {
        let theirs = order.get(frn - 1).and_then(|item| item["contents"].as_str());
        let ours = uap.iter().find(|item| usize::from(item.frn) == frn);
        if theirs != ours.map(|item| item.item) {
            complaints.push(format!("FRN {frn}: {theirs:?} is not {ours:?}"));
        }
    }
    for item in uap {
        let catalogue = definition["catalogue"].as_array().map_or(&[][..], Vec::as_slice);
        match catalogue.iter().find(|theirs| theirs["name"] == item.item) {
            Some(theirs) => complaints.extend(compare(free(&theirs["rule"]), item.layout, "", item.item)),
            None => complaints.push(format!("{}: not in the catalogue", item.item)),
        }
    }
    complaints
}

/// Compares the definition of a reserved expansion field with its subfields.
pub fn expansion(definition: &Value, subfields: &[Subfield]) -> Complaints {
    let definition = &definition["contents"];
    let mut complaints = Complaints::new();
    if definition["fspecByteSize"] != 1 {
        complaints.push("the primary subfield is not one octet".to_owned());
    }
    let items = definition["items"].as_array().map_or(&[][..], Vec::as_slice);
    complaints.extend(compare_subfields(items, subfields, "RE"));
    complaints
}

/// The codes below `end` defined by the table at the end of `path` (names of items and of their parts).
pub fn table(value: &Value, path: &[&str], end: u64) -> Option<Vec<u64>> {
    if path.is_empty() && tag(value) == "ContentTable" {
        let codes = value["contents"].as_array()?.iter();
        // Tables also list reserved and invalid values.
        let defined = codes.filter(|code| {
            let meaning = code[1].as_str().unwrap_or("");
            !["Invalid ASTERIX value", "Not defined", "Not assigned", "Reserved"]
                .iter()
                .any(|none| meaning.starts_with(none))
        });
        let mut codes: Vec<u64> =
            defined.filter_map(|code| code[0].as_u64()).filter(|&code| code < end).collect();
        codes.sort_unstable();
        return Some(codes);
    }
    let path = match (value["name"].as_str(), path) {
        (Some(name), [first, rest @ ..]) if name == *first => rest,
        _ => path,
    };
    match value {
        Value::Object(members) => members.values().find_map(|member| table(member, path, end)),
        Value::Array(elements) => elements.iter().find_map(|element| table(element, path, end)),
        _ => None,
    }
}
