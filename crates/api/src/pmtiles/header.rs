//! The first 127 octets of a PMTiles file.

use super::Span;

/// The fields of the header that are used.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) root: Span,
    /// The metadata, which is JSON.
    pub(super) metadata: Span,
    pub(super) leaves: Span,
    pub(super) tiles: Span,
    /// Compression of directories and metadata.
    pub(super) internal: Compression,
    /// Compression of tiles.
    pub(super) tile: Compression,
    /// Minimum and maximum zoom.
    pub(super) zooms: (u8, u8),
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Compression {
    None,
    Gzip,
}

/// Type code of vector tiles.
const VECTOR: u8 = 1;

impl Header {
    pub(super) const LENGTH: usize = 127;

    /// Decodes the header; the error message is for the author of the configuration.
    pub(super) fn parse(octets: &[u8; Self::LENGTH]) -> Result<Self, String> {
        if !octets.starts_with(b"PMTiles") {
            return Err("it is no PMTiles file".to_owned());
        }
        if octets[7] != 3 {
            return Err(format!("it is PMTiles of version {}; version 3 is read", octets[7]));
        }
        if octets[99] != VECTOR {
            return Err("its tiles are pictures; vector tiles (MVT) are read".to_owned());
        }
        let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| octets[at + i]));
        let span = |at: usize| Span { at: number(at), length: number(at + 8) };
        Ok(Self {
            root: span(8),
            metadata: span(24),
            leaves: span(40),
            tiles: span(56),
            internal: compression(octets[97])?,
            tile: compression(octets[98])?,
            zooms: (octets[100], octets[101]),
        })
    }
}

fn compression(kind: u8) -> Result<Compression, String> {
    match kind {
        1 => Ok(Compression::None),
        2 => Ok(Compression::Gzip),
        3 => Err("it is packed with Brotli; gzip and unpacked files are read".to_owned()),
        4 => Err("it is packed with Zstandard; gzip and unpacked files are read".to_owned()),
        _ => Err("how it is packed is not known; gzip and unpacked files are read".to_owned()),
    }
}
