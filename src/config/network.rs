//! UDP lines: `inputs` of a sensor and `output.asterix`.

use std::net::Ipv4Addr;

use tables::kinds::{Kind, Toml, ipv4, named, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, Table, absent, depends, need};
use tables::tree::quoted;
use tables::{names, written_by_name};

/// Longest trailer that is recognised or may be configured, octets.
pub const LONGEST_TRAILER: usize = 32;

section! {
    /// A UDP line to listen on.
    #[derive(Copy, Eq, Hash)]
    Input {
        /// UDP port.
        port: u16 = need("the UDP port, such as port = 8048"), whole("a UDP port is a whole number from 1 to 65535", 1..=65535);
        /// The only host whose datagrams count, one sender whatever its ports; a group is joined source-specifically. Where an
        /// input of a sensor has it, the sensor's records count from the hosts that its inputs name and from no other, on every
        /// line. Without it, of contradicting senders the one heard first counts (docs/OPERATIONS.md, Two senders).
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
        /// Which picture is sent. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
        /// The category of its tracks. `62` goes with the state of each sensor, CAT063, once a second (docs/CAT062.md).
        category: Category = Category::Cat129, of_tracks();
    } by hand {
        /// The group or host to send to.
        address: Address = Address::Unicast(Ipv4Addr::UNSPECIFIED);
    }
}

names! {
    /// Which of the pictures of a deadline.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash)]
    PictureKind, "picture" {
        /// Of the slot that opened `latency_s` before.
        Lagged = "lagged",
        /// Where aircraft are predicted to be in the slot that opens.
        Now = "now",
    }
}

written_by_name!(PictureKind);

/// The ASTERIX category in which a destination gets its tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Category {
    /// CAT129, of unmanned aircraft.
    Cat129,
    /// CAT062, of system tracks.
    Cat062,
}

impl Category {
    /// Its number.
    pub const fn number(self) -> u8 {
        match self {
            Self::Cat129 => 129,
            Self::Cat062 => 62,
        }
    }
}

/// The categories that tracks can be sent in.
fn of_tracks() -> Kind<Category> {
    const RULE: &str = "the category of the tracks is 129 or 62";
    Kind::new("`129`: CAT129; `62`: CAT062 and CAT063", |item| {
        let number = item.whole(0..=255_u8, RULE)?;
        let known = [Category::Cat129, Category::Cat062].into_iter().find(|known| known.number() == number);
        if known.is_none() {
            item.refuse(RULE);
        }
        known
    })
}

impl Toml for Category {
    fn toml(&self) -> Option<String> {
        Some(self.number().to_string())
    }
}

/// What a destination gets: a picture, in a category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Feed {
    /// The picture.
    pub picture: PictureKind,
    /// The category.
    pub category: Category,
}

impl Feed {
    /// That of which a recording of the output is made.
    pub const RECORDED: Self = Self { picture: PictureKind::Lagged, category: Category::Cat129 };

    /// Every one there is.
    pub const ALL: [Self; 4] = [
        Self::RECORDED,
        Self { picture: PictureKind::Now, category: Category::Cat129 },
        Self { picture: PictureKind::Lagged, category: Category::Cat062 },
        Self { picture: PictureKind::Now, category: Category::Cat062 },
    ];
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
    /// What it gets.
    pub const fn feed(&self) -> Feed {
        Feed { picture: self.picture, category: self.category }
    }

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
        self.address.read(section);
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        self.address.arrange(entries);
    }

    fn explain(rows: &mut Vec<Row>) {
        rows.splice(0..0, AddressKeys::rows());
    }
}

impl ByHand for Sink {
    fn more(&mut self, section: &mut Section<'_>) {
        self.address.read(section);
        if self.address == Address::Unicast(Ipv4Addr::UNSPECIFIED) {
            section.contradict(
                &["address"],
                "nothing can be sent to 0.0.0.0; write the address of the receiver",
            );
        }
        if section.written("ttl").is_none() {
            // A group stays in its network unless somebody says otherwise; a host may be anywhere.
            self.ttl = if matches!(self.address, Address::Multicast { .. }) { 1 } else { 64 };
        }
    }

    fn arrange(&self, entries: &mut Vec<Entry>) {
        self.address.arrange(entries);
    }

    fn explain(rows: &mut Vec<Row>) {
        rows.splice(0..0, AddressKeys::rows());
    }
}

section! {
    /// Where a line listens or sends: `group` and `interface`, or `address`.
    AddressKeys {
        /// Multicast group.
        group: Option<Ipv4Addr> = absent("none; `group` or `address` is needed"),
            ipv4("a multicast group is 224.0.0.0 to 239.255.255.255; for unicast write address", |v| v.is_multicast());
        /// This machine's own address on the network of the group; `0.0.0.0` leaves it to the routing table.
        interface: Ipv4Addr = Ipv4Addr::UNSPECIFIED, ipv4(
            "the interface is named by this machine's own address on it, such as \"127.0.0.1\"",
            |interface| !interface.is_multicast() && !interface.is_broadcast(),
        );
        /// Unicast address instead of `group`: of this machine to listen on (`0.0.0.0` for all), of the receiver to send to.
        address: Option<Ipv4Addr> = absent("none; `group` or `address` is needed"), ipv4(
            "the address is that of one host, not of a broadcast; for a multicast group write group instead",
            |host| !host.is_multicast() && !host.is_broadcast(),
        );
    }
}

impl Address {
    /// Reads the keys into `self`.
    fn read(&mut self, section: &mut Section<'_>) {
        let keys = AddressKeys::read_keys(section);
        let given = ["group", "address", "interface"].map(|name| section.written(name));
        match given {
            [Some(_), Some(address), _] => address.refuse(
                "group and address exclude each other; keep group for multicast, address for unicast",
            ),
            [None, Some(_), Some(interface)] => {
                interface.refuse("an interface goes with a group; remove it, the address says where");
            }
            [None, None, _] => section.refuse(
                "group or address is missing; add group = \"239.…\" for multicast, or address = \"…\"",
            ),
            _ => {}
        }
        if let Some(group) = keys.group {
            *self = Self::Multicast { group, interface: keys.interface };
        } else if let Some(address) = keys.address {
            *self = Self::Unicast(address);
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
}
