//! UDP lines: `inputs` of a sensor and `output.asterix`.

use std::net::Ipv4Addr;

use super::kinds::{Kind, ipv4, whole};
use super::reader::Section;
use super::table::{ByHand, Entry, Row, absent, depends, need, section};
use super::tree::quoted;
use crate::capture::LONGEST_TRAILER;

section! {
    /// A UDP line to listen on.
    #[derive(Copy, Eq, Hash)]
    Input {
        /// UDP port.
        port: u16 = need("the UDP port, such as port = 8048"), whole("a UDP port is a whole number from 1 to 65535", 1..=65535);
        /// The only host whose datagrams count, one sender whatever its ports; a group is joined source-specifically. Without
        /// it, of contradicting senders the one heard first counts (docs/OPERATIONS.md, Two senders).
        source: Option<Ipv4Addr> = absent("any host"), ipv4(
            "the source is the address of one host; a group belongs into group",
            |source| !source.is_multicast() && !source.is_broadcast() && !source.is_unspecified(),
        );
        /// Octets that the sender appends to the blocks of each datagram; used in a replay of such datagrams as well.
        trailer_octets: Option<u8> =
            absent("recognised where four datagrams in a row end in the same number of octets that are no block"),
            whole("a trailer has at most 32 octets; 0: there is none", 0..=LONGEST_TRAILER as u8);
    } by hand {
        /// The group to join, or the local address to bind (`0.0.0.0`: all).
        address: Address = Address::Unicast(Ipv4Addr::UNSPECIFIED);
    }
}

section! {
    /// A UDP destination.
    #[derive(Copy, Eq, Hash)]
    Sink {
        /// UDP port.
        port: u16 = need("the UDP port, such as port = 8048"), whole("a UDP port is a whole number from 1 to 65535", 1..=65535);
        /// Time to live, hops.
        ttl: u8 = depends("1 for a group, 64 for an address", 64), whole("a time to live is 0 to 255 hops", 0..=255);
    } by hand {
        /// The group or host to send to.
        address: Address = Address::Unicast(Ipv4Addr::UNSPECIFIED);
    }
}

/// A multicast group or a single address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// `group`, 224.0.0.0/4.
    Multicast {
        /// The group.
        group: Ipv4Addr,
        /// Address of the network interface to use; `0.0.0.0` leaves it to the routing table.
        interface: Ipv4Addr,
    },
    /// `address`.
    Unicast(Ipv4Addr),
}

impl Sink {
    /// `239.192.129.2:8130 from 127.0.0.1`, for people.
    pub fn name(&self) -> String {
        match self.address {
            Address::Multicast { group, interface } => format!("{group}:{} from {interface}", self.port),
            Address::Unicast(address) => format!("{address}:{}", self.port),
        }
    }
}

impl ByHand for Input {
    fn more(&mut self, section: &mut Section<'_>) {
        self.address = Address::read(section).unwrap_or(self.address);
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        self.address.arrange(entries);
    }

    fn explain(rows: &mut Vec<Row>) {
        Address::explain(rows, "Local unicast address to listen on, `0.0.0.0` for all; instead of `group`.");
    }
}

impl ByHand for Sink {
    fn more(&mut self, section: &mut Section<'_>) {
        let address = Address::read(section);
        if address == Some(Address::Unicast(Ipv4Addr::UNSPECIFIED)) {
            section.contradict(
                &["address"],
                "nothing can be sent to 0.0.0.0; write the address of the receiver",
            );
        }
        self.address = address.unwrap_or(self.address);
        if section.written("ttl").is_none() {
            // A group stays in its network unless somebody says otherwise; a host may be anywhere.
            self.ttl = if matches!(self.address, Address::Multicast { .. }) { 1 } else { 64 };
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        self.address.arrange(entries);
    }

    fn explain(rows: &mut Vec<Row>) {
        Address::explain(rows, "Unicast address to send to; instead of `group`.");
    }
}

fn a_group() -> Kind<Ipv4Addr> {
    ipv4("a multicast group is 224.0.0.0 to 239.255.255.255; for unicast write address", |group| {
        group.is_multicast()
    })
}

fn an_interface() -> Kind<Ipv4Addr> {
    let rule = "the interface is named by this machine's own address on it, such as \"127.0.0.1\"";
    ipv4(rule, |interface| !interface.is_multicast() && !interface.is_broadcast())
}

fn a_host() -> Kind<Ipv4Addr> {
    let rule =
        "the address is that of one host, not of a broadcast; for a multicast group write group instead";
    ipv4(rule, |host| !host.is_multicast() && !host.is_broadcast())
}

impl Address {
    /// `group` with `interface`, or `address`.
    fn read(section: &mut Section<'_>) -> Option<Self> {
        let (group, address) = (section.item("group"), section.item("address"));
        let interface = section.item("interface");
        match (group, address) {
            (Some(group), None) => {
                let interface =
                    interface.map_or(Some(Ipv4Addr::UNSPECIFIED), |item| (an_interface().read)(&item));
                let group = (a_group().read)(&group);
                group.zip(interface).map(|(group, interface)| Self::Multicast { group, interface })
            }
            (None, Some(address)) => {
                if let Some(interface) = interface {
                    interface.refuse("an interface goes with a group; remove it, the address says where");
                }
                (a_host().read)(&address).map(Self::Unicast)
            }
            (Some(_), Some(address)) => {
                address.refuse(
                    "group and address exclude each other; keep group for multicast, address for unicast",
                );
                None
            }
            (None, None) => {
                section.refuse(
                    "group or address is missing; add group = \"239.…\" for multicast, or address = \"…\"",
                );
                None
            }
        }
    }

    /// Around the port.
    fn arrange(self, entries: &mut Vec<Entry>) {
        match self {
            Self::Multicast { group, interface } => {
                entries.insert(0, Entry::new("group", quoted(&group.to_string())));
                entries.insert(2, Entry::new("interface", quoted(&interface.to_string())));
            }
            Self::Unicast(address) => entries.insert(0, Entry::new("address", quoted(&address.to_string()))),
        }
    }

    fn explain(rows: &mut Vec<Row>, address: &'static str) {
        let instead = "none; `group` or `address` is needed";
        let interface = "This machine's own address on the network of the group; `0.0.0.0` leaves it to the routing table.";
        let address = [
            Row::by_hand("group", Some(instead), &a_group().values, "Multicast group."),
            Row::by_hand("interface", Some("`\"0.0.0.0\"`"), &an_interface().values, interface),
            Row::by_hand("address", Some(instead), &a_host().values, address),
        ];
        rows.splice(0..0, address);
    }
}
