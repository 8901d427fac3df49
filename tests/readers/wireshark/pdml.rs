//! Wireshark's dissection of a capture, from `tshark -T pdml`.

use std::path::Path;
use std::process::{Command, Stdio};

use roxmltree::{Document, Node, ParsingOptions};

use crate::program::Scratch;

/// A displayed field: its value and its octets.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Name with its item, without `cat129.`: `080.latitude_deg`.
    pub name: String,
    /// Displayed value.
    pub show: String,
    /// Octets in hexadecimal.
    pub octets: String,
}

/// Content of a datagram.
#[derive(Clone, Debug)]
pub enum RemoteIdOutcome {
    /// A record with its fields, the FSPEC and notes.
    Record(Vec<Shown>),
    /// Octets that cannot be read: name of the fault, and offset in the frame.
    Fault(String, usize),
}

/// A packet.
#[derive(Debug, Default)]
pub struct Packet {
    /// CAT129 content of the packet, in order.
    pub said: Vec<RemoteIdOutcome>,
    /// Names of its protocols.
    pub protocols: Vec<String>,
    /// Notes and warnings.
    pub notes: Vec<String>,
}

/// Output of tshark with the dissector, without the user's settings.
pub fn tshark(scratch: &Scratch, capture: &Path, arguments: &[&str]) -> String {
    let lua = concat!("lua_script:", env!("CARGO_MANIFEST_DIR"), "/wireshark/cat129.lua");
    let mut command = Command::new("tshark");
    command.env("HOME", scratch.path("")).env("WIRESHARK_CONFIG_DIR", scratch.path("settings"));
    command.args(["-n", "-X", lua, "-r"]).arg(capture).args(arguments).stdin(Stdio::null());
    let output = command.output().unwrap();
    let (out, errors) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{errors}");
    for text in ["Lua Error", "Lua: "] {
        assert!(!out.contains(text) && !errors.contains(text), "{errors}\n{out}");
    }
    out
}

/// Packets of a capture.
pub fn packets(scratch: &Scratch, capture: &Path, arguments: &[&str]) -> Vec<Packet> {
    let text = tshark(scratch, capture, &[arguments, &["-T", "pdml"]].concat());
    let options = ParsingOptions { nodes_limit: u32::MAX, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).unwrap();
    document.descendants().filter(|node| node.has_tag_name("packet")).map(packet).collect()
}

fn packet(node: Node<'_, '_>) -> Packet {
    let mut packet = Packet::default();
    for proto in node.children().filter(|node| node.has_tag_name("proto")) {
        packet.protocols.push(name(proto).to_owned());
        if name(proto) != "cat129" {
            continue;
        }
        for part in proto.children().filter(Node::is_element) {
            if name(part) == "cat129.block" {
                let records = part.children().filter(|node| name(*node) == "cat129.record");
                packet.said.extend(records.map(|record| fault(record).unwrap_or_else(|| said(record))));
            } else {
                packet.said.extend(fault(part));
            }
        }
        packet.notes.extend(
            experts(proto).into_iter().filter(|(_, _, severity)| *severity != ERROR).map(|(name, ..)| name),
        );
    }
    packet
}

fn name<'a>(node: Node<'a, '_>) -> &'a str {
    node.attribute("name").unwrap_or_default()
}

/// Severity of unreadable data, in Wireshark's numbering.
const ERROR: &str = "8388608";

/// Expert information of a node: name, offset, and severity.
fn experts<'a>(node: Node<'a, '_>) -> Vec<(String, usize, &'a str)> {
    let of = |expert: Node<'a, '_>| {
        let about = expert.parent().unwrap().attribute("pos").unwrap().parse().unwrap();
        let named = expert.children().find_map(|node| name(node).strip_prefix("cat129."));
        let severity = expert.children().find(|node| name(*node) == "_ws.expert.severity").unwrap();
        (named.unwrap().to_owned(), about, severity.attribute("show").unwrap())
    };
    node.descendants().filter(|node| name(*node) == "_ws.expert").map(of).collect()
}

fn fault(node: Node<'_, '_>) -> Option<RemoteIdOutcome> {
    let mut all = experts(node).into_iter().filter(|(_, _, severity)| *severity == ERROR);
    let (name, at, _) = all.next()?;
    assert!(all.next().is_none(), "one fault ends a block");
    Some(RemoteIdOutcome::Fault(name, at))
}

fn said(record: Node<'_, '_>) -> RemoteIdOutcome {
    let of = |node: Node<'_, '_>| {
        let name = name(node).strip_prefix("cat129.")?.to_owned();
        let attribute = |name| node.attribute(name).unwrap_or_default().to_owned();
        let is_expert = self::name(node.parent().unwrap()) == "_ws.expert";
        // A node that only contains others has no value.
        let says = !is_expert && node.attribute("value").is_some_and(|octets| !octets.is_empty());
        says.then(|| Shown { name, show: attribute("show"), octets: attribute("value") })
    };
    RemoteIdOutcome::Record(
        record.descendants().skip(1).filter(|node| node.has_tag_name("field")).filter_map(of).collect(),
    )
}
