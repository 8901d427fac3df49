//! UDP lines: `inputs` of a sensor and `output.asterix`.

use std::net::Ipv4Addr;

use super::reader::{Item, Section};
use super::types::{Address, Input, Sink};
use crate::capture::LONGEST_TRAILER;

/// One entry of `inputs`.
pub(super) fn read_input(mut section: Section<'_>) -> Option<Input> {
    let (address, _) = read_address(&mut section);
    let port = read_port(&mut section);
    let source = section.item("source").and_then(|item| {
        let source = item.ipv4()?;
        let host = !source.is_multicast() && !source.is_broadcast() && !source.is_unspecified();
        if !host {
            item.refuse("the source is the address of one host; a group belongs into group");
        }
        host.then_some(source)
    });
    let trailer_octets = section.item("trailer_octets").and_then(|item| {
        item.whole(0..=LONGEST_TRAILER as u8, "a trailer has at most 32 octets; 0: there is none")
    });
    section.finish();
    Some(Input { address: address?, port: port?, source, trailer_octets })
}

/// One entry of `output.asterix`.
pub(super) fn read_sink(mut section: Section<'_>) -> Option<Sink> {
    let (address, item) = read_address(&mut section);
    if let (Some(Address::Unicast(Ipv4Addr::UNSPECIFIED)), Some(item)) = (address, item) {
        item.refuse("nothing can be sent to 0.0.0.0; write the address of the receiver");
    }
    let port = read_port(&mut section);
    let ttl = section.item("ttl").and_then(|item| item.whole(0..=255u8, "a time to live is 0 to 255 hops"));
    section.finish();
    let address = address?;
    // A group stays in its network unless somebody says otherwise; a host may be anywhere.
    let usual = if matches!(address, Address::Multicast { .. }) { 1 } else { 64 };
    Some(Sink { address, port: port?, ttl: ttl.unwrap_or(usual) })
}

fn read_port(section: &mut Section<'_>) -> Option<u16> {
    section
        .need("port", "the UDP port, such as port = 8048")?
        .whole(1..=65535u16, "a UDP port is a whole number from 1 to 65535")
}

/// `group` with `interface`, or `address`; and the item that names it.
fn read_address<'a>(section: &mut Section<'a>) -> (Option<Address>, Option<Item<'a>>) {
    let (group, address) = (section.item("group"), section.item("address"));
    let interface = section.item("interface");
    let read = match (&group, &address) {
        (Some(group), None) => {
            let interface = match &interface {
                Some(item) => read_interface(item),
                None => Some(Ipv4Addr::UNSPECIFIED),
            };
            read_group(group).zip(interface).map(|(group, interface)| Address::Multicast { group, interface })
        }
        (None, Some(address)) => {
            if let Some(interface) = interface {
                interface.refuse("an interface goes with a group; remove it, the address says where");
            }
            read_host(address).map(Address::Unicast)
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
    };
    (read, group.or(address))
}

fn read_group(item: &Item<'_>) -> Option<Ipv4Addr> {
    let group = item.ipv4()?;
    if !group.is_multicast() {
        item.refuse("a multicast group is 224.0.0.0 to 239.255.255.255; for unicast write address");
    }
    Some(group)
}

fn read_interface(item: &Item<'_>) -> Option<Ipv4Addr> {
    let interface = item.ipv4()?;
    if interface.is_multicast() || interface.is_broadcast() {
        item.refuse("the interface is named by this machine's own address on it, such as \"127.0.0.1\"");
    }
    Some(interface)
}

fn read_host(item: &Item<'_>) -> Option<Ipv4Addr> {
    let host = item.ipv4()?;
    if host.is_multicast() {
        item.refuse("this is a multicast group; write group instead of address");
    } else if host.is_broadcast() {
        item.refuse("broadcast is not used; write the address of one host, or a group");
    }
    Some(host)
}
