//! UDP endpoints: `inputs` of a sensor and `output.asterix`.

use std::net::Ipv4Addr;

use tables::kinds::{Kind, Toml, ipv4, named, whole};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, Entry, Row, Table, absent, depends, need};
use tables::tree::quoted;
use tables::{names, written_by_name};

/// Maximum length of a trailer, recognised or configured, in octets.
pub const LONGEST_TRAILER: usize = 32;

section! {
    /// A UDP input.
    #[derive(Copy, Eq, Hash)]
    Input {
        /// UDP port.
        port: u16 = need("the UDP port, such as port = 8048"), whole("a UDP port is a whole number from 1 to 65535", 1..=65535);
        /// The only host whose datagrams are accepted; all its ports count as one sender. A group is joined as source-specific
        /// multicast. If any input of a sensor has this key, records of the sensor are accepted only from hosts named by its
        /// inputs, on every input. Without it, the sender received first is used when two senders contradict each other
        /// (docs/OPERATIONS.md, Two senders).
        source: Option<Ipv4Addr> = absent("any host"), ipv4(
            "the source is the address of one host; a group belongs into group",
            |source| !source.is_multicast() && !source.is_broadcast() && !source.is_unspecified(),
        );
        /// Number of octets that the sender appends to the blocks of each datagram. A replay of such datagrams uses it too.
        trailer_octets: Option<u8> =
            absent("recognised where four datagrams in a row end in the same number of octets that are no block"),
            whole("a trailer has at most 32 octets; 0: there is none", 0..=LONGEST_TRAILER as u8);
    } by hand {
        /// Group to join, or local address to bind (`0.0.0.0` for all).
        address: Address = Address::Unicast(Ipv4Addr::UNSPECIFIED);
    }
}

section! {
    /// A UDP destination.
    #[derive(Copy, Eq, Hash)]
    Sink {
        /// UDP port.
        port: u16 = need("the UDP port, such as port = 8048"), whole("a UDP port is a whole number from 1 to 65535", 1..=65535);
        /// Time to live, in hops.
        ttl: u8 = depends("1 for a group, 64 for an address", 64), whole("a time to live is 0 to 255 hops", 0..=255);
        /// Picture to send. `now` needs `fusion.now`.
        picture: PictureKind = PictureKind::Lagged, named();
        /// ASTERIX category of the tracks. With `62`, the status of each sensor is sent too, as CAT063 once a second
        /// (docs/CAT062.md).
        category: Category = Category::Cat129, of_tracks();
    } by hand {
        /// Group or host to send to.
        address: Address = Address::Unicast(Ipv4Addr::UNSPECIFIED);
    }
}

names! {
    /// One of the two pictures, by the time of publication.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash)]
    PictureKind, "picture" {
        /// Picture of the slot that started `latency_s` ago.
        Lagged = "lagged",
        /// Predicted picture of the slot that starts now.
        Now = "now",
    }
}

written_by_name!(PictureKind);

/// ASTERIX category of the tracks sent to a destination.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Category {
    /// CAT129, unmanned aircraft.
    Cat129,
    /// CAT062, system tracks.
    Cat062,
}

impl Category {
    /// Number of the category.
    pub const fn number(self) -> u8 {
        match self {
            Self::Cat129 => 129,
            Self::Cat062 => 62,
        }
    }
}

/// Kind of a category in which tracks can be sent.
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

/// Content sent to a destination: a picture in a category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Feed {
    /// Picture to send.
    pub picture: PictureKind,
    /// Category of the tracks.
    pub category: Category,
}

impl Feed {
    /// Content of a recording of the output.
    pub const RECORDED: Self = Self { picture: PictureKind::Lagged, category: Category::Cat129 };

    /// All combinations of picture and category.
    pub const ALL: [Self; 4] = [
        Self::RECORDED,
        Self { picture: PictureKind::Now, category: Category::Cat129 },
        Self { picture: PictureKind::Lagged, category: Category::Cat062 },
        Self { picture: PictureKind::Now, category: Category::Cat062 },
    ];
}

/// A multicast group or a unicast address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// Multicast: key `group`, within 224.0.0.0/4.
    Multicast {
        /// Address of the group.
        group: Ipv4Addr,
        /// Address of the network interface to use; `0.0.0.0` leaves the choice to the routing table.
        interface: Ipv4Addr,
    },
    /// Unicast: key `address`.
    Unicast(Ipv4Addr),
}

impl Sink {
    /// Content sent to this destination.
    pub const fn feed(&self) -> Feed {
        Feed { picture: self.picture, category: self.category }
    }

    /// Name for messages, such as `239.192.129.2:8130 from 127.0.0.1`.
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
            // By default multicast stays in its network; a unicast receiver may be anywhere.
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
    /// Address of a UDP endpoint: `group` and `interface`, or `address`.
    AddressKeys {
        /// Multicast group.
        group: Option<Ipv4Addr> = absent("none; `group` or `address` is needed"),
            ipv4("a multicast group is 224.0.0.0 to 239.255.255.255; for unicast write address", |v| v.is_multicast());
        /// This machine's own address on the network of the group; `0.0.0.0` leaves the choice to the routing table.
        interface: Ipv4Addr = Ipv4Addr::UNSPECIFIED, ipv4(
            "the interface is named by this machine's own address on it, such as \"127.0.0.1\"",
            |interface| !interface.is_multicast() && !interface.is_broadcast(),
        );
        /// Unicast address, instead of `group`. For an input: address of this machine to listen on (`0.0.0.0` for all). For an
        /// output: address of the receiver.
        address: Option<Ipv4Addr> = absent("none; `group` or `address` is needed"), ipv4(
            "the address is that of one host, not of a broadcast; for a multicast group write group instead",
            |host| !host.is_multicast() && !host.is_broadcast(),
        );
    }
}

impl Address {
    /// Reads the keys of `section` into `self`.
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

    /// Orders the entries in TOML: address keys before and after the port.
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
