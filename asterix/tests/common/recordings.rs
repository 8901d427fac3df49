//! Real recordings, which are not part of the project.

use std::path::PathBuf;

/// The folder of recordings; `None`, with a message, if none is given.
pub fn shared_data() -> Option<PathBuf> {
    let folder = std::env::var_os("UTM_FUSION_SHARED_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: UTM_FUSION_SHARED_DATA names no folder of recordings");
    }
    folder
}

/// The UDP datagrams of a capture (Ethernet, IPv4 without options), each with its time of reception in microseconds. UDP states
/// the length, because padding may follow.
pub fn datagrams(pcap: &[u8]) -> Vec<(u64, &[u8])> {
    let (mut found, mut rest) = (Vec::new(), &pcap[24..]);
    while let Some((header, after)) = rest.split_at_checked(16) {
        let word =
            |index: usize| u32::from_le_bytes(header[index..index + 4].try_into().expect("four octets"));
        let (packet, next) = after.split_at(word(8) as usize);
        rest = next;
        let udp = &packet[14 + 20..];
        let datagram = &udp[8..usize::from(u16::from_be_bytes([udp[4], udp[5]]))];
        found.push((u64::from(word(0)) * 1_000_000 + u64::from(word(4)), datagram));
    }
    found
}
