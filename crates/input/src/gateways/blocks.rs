//! ASTERIX over TCP, as readsb sends CAT021: consecutive data blocks without further framing. Each block becomes a
//! datagram.

/// Length of a block's header in octets: category and length.
const HEADER: usize = 3;

/// Error for a stream that is not a sequence of ASTERIX blocks: a block's length is below that of its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not ASTERIX: a block of category {category} states a length of {length} octets; the least is 3")]
pub struct NotAsterix {
    /// Category of the block.
    pub category: u8,
    /// Length stated by the block.
    pub length: u16,
}

/// Splits a stream into blocks. At most one block, 65,535 octets, is held.
#[derive(Clone, Debug, Default)]
pub struct BlockStream {
    /// The beginning of an incomplete block.
    partial: Vec<u8>,
}

impl BlockStream {
    /// Takes octets of the stream, cut anywhere, and passes on each complete block.
    ///
    /// # Errors
    /// The stream is not ASTERIX; the connection has to be opened again.
    pub fn take(&mut self, octets: &[u8], mut hand_on: impl FnMut(Vec<u8>)) -> Result<(), NotAsterix> {
        self.partial.extend_from_slice(octets);
        let mut rest = &self.partial[..];
        while let [category, high, low, ..] = *rest {
            let length = u16::from_be_bytes([high, low]);
            if usize::from(length) < HEADER {
                self.partial.clear();
                return Err(NotAsterix { category, length });
            }
            let Some((block, behind)) = rest.split_at_checked(length.into()) else { break };
            hand_on(block.to_vec());
            rest = behind;
        }
        let done = self.partial.len() - rest.len();
        self.partial.drain(..done);
        Ok(())
    }

    /// Ends the stream; the next one begins with a block.
    pub fn end(&mut self) {
        self.partial.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream() -> (Vec<Vec<u8>>, Vec<u8>) {
        let block = |category: u8, length: usize| {
            let mut block = vec![category, (length >> 8) as u8, length as u8];
            block.resize(length, 0x55);
            block
        };
        let blocks = vec![block(21, 3), block(21, 300), block(48, 17), block(21, 65_535), block(21, 9)];
        let octets = blocks.concat();
        (blocks, octets)
    }

    #[test]
    fn blocks_are_the_same_at_any_split() {
        let (blocks, octets) = stream();
        for size in [1, 2, 3, 7, 299, 4096, octets.len()] {
            let (mut stream, mut found) = (BlockStream::default(), Vec::new());
            for chunk in octets.chunks(size) {
                stream.take(chunk, |block| found.push(block)).unwrap();
            }
            assert!(found == blocks, "chunks of {size}");
            assert!(stream.partial.is_empty());
        }
    }

    #[test]
    fn length_below_header_is_refused_after_blocks_before_it() {
        let (mut stream, mut found) = (BlockStream::default(), Vec::new());
        let octets = [21, 0, 4, 9, 72, 0, 2, 1, 2, 3];
        let refused = stream.take(&octets, |block| found.push(block));
        assert_eq!(refused, Err(NotAsterix { category: 72, length: 2 }));
        assert_eq!(found, [[21, 0, 4, 9]]);
        assert_eq!(stream.take(&[21, 0, 3], |block| found.push(block)), Ok(()));
        assert_eq!(found.len(), 2);
    }
}
