//! A slot's blocks as datagrams.

use super::Cat129Encoder;
use crate::picture::PictureTrack;

/// No datagram is longer, octets: it fits an Ethernet frame with room for tunnels.
pub const DATAGRAM_MAX: usize = 1400;

/// The tracks' blocks in order, packed into as few datagrams of at most [`DATAGRAM_MAX`] octets as keep the order.
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
