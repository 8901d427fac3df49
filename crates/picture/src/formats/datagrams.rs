//! Packing of a slot's blocks into datagrams.

use asterix::{Record, encode_block};

use super::Cat129Encoder;
use crate::PictureTrack;

/// Maximum length of a datagram, in octets: it fits an Ethernet frame with space for tunnels.
pub const DATAGRAM_MAX: usize = 1400;

/// Length of CAT and LEN of a block, in octets.
const HEADER: usize = 3;

/// Packs the blocks of the tracks in order into the fewest datagrams of at most [`DATAGRAM_MAX`] octets.
pub fn pack<'a>(tracks: impl IntoIterator<Item = &'a PictureTrack>, encoder: &Cat129Encoder) -> Vec<Vec<u8>> {
    let mut datagrams: Vec<Vec<u8>> = Vec::new();
    let mut block = Vec::new();
    for track in tracks {
        block.clear();
        if !encoder.encode(track, &mut block) {
            continue;
        }
        match datagrams.last_mut() {
            Some(datagram) if datagram.len() + block.len() <= DATAGRAM_MAX => {
                datagram.extend_from_slice(&block);
            }
            _ => datagrams.push(block.clone()),
        }
    }
    datagrams
}

/// Packs records in order into the fewest datagrams of at most [`DATAGRAM_MAX`] octets, each with one block.
pub(super) fn pack_records<R: Record>(records: impl IntoIterator<Item = R>) -> Vec<Vec<u8>> {
    let mut blocks: Vec<Vec<R>> = Vec::new();
    let mut room = 0;
    let mut octets = Vec::new();
    for record in records {
        octets.clear();
        record.encode_into(&mut octets);
        match blocks.last_mut() {
            Some(block) if octets.len() <= room => block.push(record),
            _ => {
                blocks.push(vec![record]);
                room = DATAGRAM_MAX - HEADER;
            }
        }
        room = room.saturating_sub(octets.len());
    }
    let encoded = |block: &Vec<R>| {
        let mut datagram = Vec::new();
        encode_block(block, &mut datagram).is_ok().then_some(datagram)
    };
    blocks.iter().filter_map(encoded).collect()
}
