//! A small writer of captures, independent of the crates that the reader uses, so that both do not share an error.

/// A classic pcap file under construction.
pub(crate) struct PcapWriter {
    pub(crate) octets: Vec<u8>,
    big_endian: bool,
}

/// The four magic numbers: byte order, and whether fractions are in nanoseconds.
pub(crate) const MAGICS: [(bool, bool); 4] = [(false, false), (false, true), (true, false), (true, true)];

impl PcapWriter {
    pub(crate) fn new(big_endian: bool, nanoseconds: bool, link: u32) -> Self {
        let mut file = Self { octets: Vec::new(), big_endian };
        file.u32(if nanoseconds { 0xA1B2_3C4D } else { 0xA1B2_C3D4 });
        file.u16(2);
        file.u16(4);
        for field in [0, 0, 65_535, link] {
            file.u32(field);
        }
        file
    }

    pub(crate) fn record(&mut self, seconds: u32, fraction: u32, frame: &[u8]) {
        self.record_of(seconds, fraction, frame, frame.len());
    }

    /// A record with `original` octets on the wire, of which only `frame` was captured.
    pub(crate) fn record_of(&mut self, seconds: u32, fraction: u32, frame: &[u8], original: usize) {
        for field in [seconds, fraction, frame.len() as u32, original as u32] {
            self.u32(field);
        }
        self.octets.extend_from_slice(frame);
    }

    fn u16(&mut self, value: u16) {
        self.octets.extend(if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
    }

    fn u32(&mut self, value: u32) {
        self.octets.extend(if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
    }
}

/// A pcapng file under construction.
pub(crate) struct PcapngWriter {
    pub(crate) octets: Vec<u8>,
    big_endian: bool,
}

impl PcapngWriter {
    /// A file with one section and no interface.
    pub(crate) fn new(big_endian: bool) -> Self {
        let mut file = Self { octets: Vec::new(), big_endian };
        file.section(big_endian);
        file
    }

    pub(crate) fn section(&mut self, big_endian: bool) {
        self.big_endian = big_endian;
        let body = [self.u32(0x1A2B_3C4D), self.u16(1), self.u16(0), vec![0xFF; 8]].concat();
        self.block(0x0A0D_0D0A, &body);
    }

    /// A block of any type, with its body padded.
    pub(crate) fn block(&mut self, kind: u32, body: &[u8]) {
        let padding = vec![0; body.len().wrapping_neg() % 4];
        let length = self.u32((12 + body.len() + padding.len()) as u32);
        let block = [&self.u32(kind), &length, body, &padding, &length].concat();
        self.octets.extend(block);
    }

    pub(crate) fn interface(&mut self, link: u16, snap_length: u32, options: &[(u16, &[u8])]) {
        let body = [self.u16(link), self.u16(0), self.u32(snap_length), self.options(options)].concat();
        self.block(1, &body);
    }

    pub(crate) fn packet(&mut self, interface: u32, time: u64, frame: &[u8]) {
        self.packet_of(interface, time, frame, frame.len(), &[]);
    }

    /// An enhanced packet block that states this number of captured octets.
    pub(crate) fn packet_of(
        &mut self,
        interface: u32,
        time: u64,
        frame: &[u8],
        captured: usize,
        options: &[(u16, &[u8])],
    ) {
        let interface = self.u32(interface);
        let body = [interface, self.packet_body(time, frame, captured), self.options(options)].concat();
        self.block(6, &body);
    }

    /// The packet block used before 2009, after 3 lost packets.
    pub(crate) fn obsolete_packet(&mut self, interface: u16, time: u64, frame: &[u8]) {
        let body = [self.u16(interface), self.u16(3), self.packet_body(time, frame, frame.len())].concat();
        self.block(2, &body);
    }

    pub(crate) fn simple_packet(&mut self, original: usize, frame: &[u8]) {
        let body = [&self.u32(original as u32), frame].concat();
        self.block(3, &body);
    }

    fn packet_body(&self, time: u64, frame: &[u8], captured: usize) -> Vec<u8> {
        let times = [self.u32((time >> 32) as u32), self.u32(time as u32)].concat();
        let padding = vec![0xDD; frame.len().wrapping_neg() % 4];
        [times, self.u32(captured as u32), self.u32(captured as u32), frame.to_vec(), padding].concat()
    }

    fn options(&self, options: &[(u16, &[u8])]) -> Vec<u8> {
        let option = |(code, value): &(u16, &[u8])| {
            let padding = vec![0; value.len().wrapping_neg() % 4];
            [self.u16(*code), self.u16(value.len() as u16), value.to_vec(), padding].concat()
        };
        options.iter().flat_map(option).collect()
    }

    fn u16(&self, value: u16) -> Vec<u8> {
        if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() }.to_vec()
    }

    fn u32(&self, value: u32) -> Vec<u8> {
        if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() }.to_vec()
    }
}

/// A record of a FINAL recording, received this number of hundredths of a second after midnight.
pub(crate) fn final_record(hundredths: u32, data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u16 + 12).to_be_bytes();
    [&length, &[1, 2, 3][..], &hundredths.to_be_bytes()[1..], data, &[0xA5; 4]].concat()
}

/// A UDP datagram from port 8048 to 8049.
pub(crate) fn udp(payload: &[u8]) -> Vec<u8> {
    let length = (8 + payload.len() as u16).to_be_bytes();
    [&[0x1F, 0x70, 0x1F, 0x71], &length[..], &[0, 0], payload].concat()
}

pub(crate) const UDP: u8 = 17;

/// An IPv4 packet from 127.0.0.1 to 239.192.48.1.
pub(crate) fn ipv4(protocol: u8, fragment: u16, payload: &[u8]) -> Vec<u8> {
    let mut packet = vec![0x45, 0];
    packet.extend((20 + payload.len() as u16).to_be_bytes());
    packet.extend([0, 1]);
    packet.extend(fragment.to_be_bytes());
    packet.extend([64, protocol, 0, 0, 127, 0, 0, 1, 239, 192, 48, 1]);
    packet.extend_from_slice(payload);
    packet
}

/// An IPv6 packet from ::1 to ff02::30.
pub(crate) fn ipv6(next_header: u8, payload: &[u8]) -> Vec<u8> {
    let mut packet = vec![0x60, 0, 0, 0];
    packet.extend((payload.len() as u16).to_be_bytes());
    packet.extend([next_header, 64]);
    packet.extend([&[0; 15][..], &[1, 0xFF, 2], &[0; 13], &[0x30]].concat());
    packet.extend_from_slice(payload);
    packet
}

/// The encapsulation of a capture's frames: number of the link type, name, and the octets before an IP packet of each version.
pub(crate) struct Wrapping {
    pub(crate) link: u32,
    pub(crate) shown: &'static str,
    pub(crate) versions: &'static [u8],
    pub(crate) header: fn(u8) -> Vec<u8>,
}

fn ether_type(version: u8) -> [u8; 2] {
    if version == 4 { [0x08, 0x00] } else { [0x86, 0xDD] }
}

pub(crate) fn ethernet(between: &[u8], ether_type: [u8; 2]) -> Vec<u8> {
    [&[1, 0, 0x5E, 0x40, 0x30, 1], &[2, 0, 0, 0, 0, 1], between, &ether_type[..]].concat()
}

fn cooked(version: u8) -> Vec<u8> {
    [&[0, 0, 3, 4, 0, 6, 2, 0, 0, 0, 0, 1, 0, 0], &ether_type(version)[..]].concat()
}

fn cooked_2(version: u8) -> Vec<u8> {
    [&ether_type(version)[..], &[0, 0, 0, 0, 0, 2, 3, 4, 0, 6, 2, 0, 0, 0, 0, 1, 0, 0]].concat()
}

const BOTH: &[u8] = &[4, 6];

/// Every supported link type; Ethernet with each kind of tag.
pub(crate) const WRAPPINGS: &[Wrapping] = &[
    Wrapping { link: 1, shown: "Ethernet", versions: BOTH, header: |v| ethernet(&[], ether_type(v)) },
    Wrapping {
        link: 1,
        shown: "Ethernet",
        versions: BOTH,
        header: |v| ethernet(&[0x81, 0, 0, 7], ether_type(v)),
    },
    Wrapping {
        link: 1,
        shown: "Ethernet",
        versions: BOTH,
        header: |v| ethernet(&[0x88, 0xA8, 0, 7, 0x81, 0, 0, 8], ether_type(v)),
    },
    // States a frame check sequence of 4 octets in the upper half of the field.
    Wrapping {
        link: 0x4400_0001,
        shown: "Ethernet",
        versions: BOTH,
        header: |v| ethernet(&[], ether_type(v)),
    },
    Wrapping { link: 113, shown: "Linux cooked", versions: BOTH, header: cooked },
    Wrapping { link: 276, shown: "Linux cooked v2", versions: BOTH, header: cooked_2 },
    Wrapping { link: 101, shown: "raw IP", versions: BOTH, header: |_| Vec::new() },
    Wrapping { link: 12, shown: "raw IP", versions: BOTH, header: |_| Vec::new() },
    Wrapping { link: 14, shown: "raw IP", versions: BOTH, header: |_| Vec::new() },
    Wrapping { link: 228, shown: "raw IP", versions: &[4], header: |_| Vec::new() },
    Wrapping { link: 229, shown: "raw IP", versions: &[6], header: |_| Vec::new() },
    Wrapping {
        link: 0,
        shown: "loopback",
        versions: BOTH,
        header: |v| vec![if v == 4 { 2 } else { 30 }, 0, 0, 0],
    },
    Wrapping {
        link: 108,
        shown: "loopback",
        versions: BOTH,
        header: |v| vec![0, 0, 0, if v == 4 { 2 } else { 24 }],
    },
];

impl Wrapping {
    /// A frame with one UDP datagram, followed by two octets of padding.
    pub(crate) fn frame(&self, version: u8, payload: &[u8]) -> Vec<u8> {
        let packet = if version == 4 { ipv4(UDP, 0, &udp(payload)) } else { ipv6(UDP, &udp(payload)) };
        [(self.header)(version), packet, vec![0xEE, 0xEE]].concat()
    }
}
