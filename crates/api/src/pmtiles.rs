//! The base map of the map page: vector tiles from one PMTiles file (version 3) that the site provides.
//!
//! A file has a header, directories with the position of each tile, and the tiles. A tile's number is its position on a Hilbert
//! curve, all coarser zooms before it. Specification: PMTiles version 3, <https://github.com/protomaps/PMTiles>.

mod directory;
mod header;
#[cfg(test)]
mod tests;

use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use flate2::read::GzDecoder;
use serde_json::Value;

use directory::{Directory, Found};
use header::{Compression, Header};

/// Maximum decompressed length of a directory or the metadata, in octets; real ones have less than a tenth of it.
const MOST_OF_A_DIRECTORY: u64 = 32 << 20;
/// Maximum decompressed length of a tile, in octets; tiles of whole cities have less than 1 MB.
const MOST_OF_A_TILE: u64 = 8 << 20;
/// Maximum number of leaf directories between the root directory and a tile (specification).
const DEEPEST: usize = 3;
/// Number of leaf directories that are cached: a view of the map needs neighbouring ones.
const KEPT: usize = 16;

/// An open file of vector tiles, or one that is part of the program.
pub struct Basemap {
    file: Mutex<Box<dyn Octets>>,
    length: u64,
    header: Header,
    root: Directory,
    /// Cached directories by position, the most recently read last.
    kept: Mutex<Vec<(u64, Arc<Directory>)>>,
    attribution: String,
}

/// Octets that are read at positions.
trait Octets: Read + Seek + Send {}

impl<T: Read + Seek + Send> Octets for T {}

impl fmt::Debug for Basemap {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { length, header, attribution, .. } = self;
        formatter
            .debug_struct("Basemap")
            .field("length", length)
            .field("header", header)
            .field("attribution", attribution)
            .finish_non_exhaustive()
    }
}

impl Basemap {
    /// Opens a file, and reads its header, root directory and metadata.
    ///
    /// # Errors
    /// The file cannot be read, or is not a PMTiles file of vector tiles that are plain or compressed by gzip.
    pub fn open(path: &Path) -> io::Result<Self> {
        #[expect(clippy::disallowed_methods, reason = "the one place that reads base maps")]
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Self::read_from(Box::new(file), length)
    }

    /// Reads header, root directory and metadata of a file that is part of the program.
    ///
    /// # Errors
    /// It is not a PMTiles file of vector tiles that are plain or compressed by gzip.
    pub fn embedded(octets: &'static [u8]) -> io::Result<Self> {
        Self::read_from(Box::new(Cursor::new(octets)), octets.len() as u64)
    }

    fn read_from(mut file: Box<dyn Octets>, length: u64) -> io::Result<Self> {
        let mut start = [0; Header::LENGTH];
        file.read_exact(&mut start)
            .map_err(|_| refused("it is shorter than the header of a PMTiles file"))?;
        let header = Header::parse(&start).map_err(refused)?;
        let mut map = Self {
            file: Mutex::new(file),
            length,
            root: Directory::default(),
            kept: Mutex::default(),
            attribution: String::new(),
            header,
        };
        map.root = map.directory(map.header.root)?;
        let metadata = map.read(map.header.metadata, map.header.internal, MOST_OF_A_DIRECTORY)?;
        let metadata: Value = serde_json::from_slice(&metadata).unwrap_or_default();
        map.attribution = plain(metadata["attribution"].as_str().unwrap_or_default());
        Ok(map)
    }

    /// Minimum and maximum zoom.
    pub fn zooms(&self) -> (u8, u8) {
        self.header.zooms
    }

    /// Attribution of the map, as plain text.
    pub fn attribution(&self) -> &str {
        &self.attribution
    }

    /// A tile as an encoded protocol buffer; `None` if the file does not have it.
    ///
    /// # Errors
    /// The file cannot be read, or contradicts itself.
    pub fn tile(&self, zoom: u8, x: u32, y: u32) -> io::Result<Option<Vec<u8>>> {
        let Some(number) = tile_number(zoom, x, y) else { return Ok(None) };
        let mut found = self.root.find(number);
        for _ in 0..DEEPEST {
            match found {
                None => return Ok(None),
                Some(Found::Tile(span)) => {
                    let span = self.header.tiles.part(span).map_err(refused)?;
                    return self.read(span, self.header.tile, MOST_OF_A_TILE).map(Some);
                }
                Some(Found::Directory(span)) => {
                    let span = self.header.leaves.part(span).map_err(refused)?;
                    found = self.leaf(span)?.find(number);
                }
            }
        }
        Err(refused("its directories lead nowhere"))
    }

    /// A leaf directory, from the cache or the file.
    fn leaf(&self, span: Span) -> io::Result<Arc<Directory>> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = kept().iter().find(|(at, _)| *at == span.at) {
            return Ok(known.clone());
        }
        let leaf = Arc::new(self.directory(span)?);
        let mut kept = kept();
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push((span.at, leaf.clone()));
        Ok(leaf)
    }

    fn directory(&self, span: Span) -> io::Result<Directory> {
        Directory::parse(&self.read(span, self.header.internal, MOST_OF_A_DIRECTORY)?).map_err(refused)
    }

    /// A part of the file, decompressed.
    fn read(&self, span: Span, compression: Compression, most: u64) -> io::Result<Vec<u8>> {
        if span.length > most || span.at.checked_add(span.length).is_none_or(|end| end > self.length) {
            return Err(refused("it is cut short, or contradicts itself"));
        }
        let mut packed = vec![0; usize::try_from(span.length).map_err(refused)?];
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(span.at))?;
            file.read_exact(&mut packed)?;
        }
        match compression {
            Compression::None => Ok(packed),
            Compression::Gzip => {
                let mut octets = Vec::new();
                GzDecoder::new(&*packed).take(most + 1).read_to_end(&mut octets)?;
                if octets.len() as u64 > most {
                    return Err(refused("a part of it is too large"));
                }
                Ok(octets)
            }
        }
    }
}

/// A part of the file, in octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Span {
    at: u64,
    length: u64,
}

impl Span {
    /// The part of this span at `part`, whose position is relative to this span.
    fn part(self, part: Self) -> Result<Self, &'static str> {
        let end = part.at.checked_add(part.length).filter(|end| *end <= self.length);
        end.and_then(|_| self.at.checked_add(part.at))
            .map(|at| Self { at, length: part.length })
            .ok_or("a directory points outside of the file")
    }
}

fn refused(cause: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, cause)
}

/// Number of a tile: the count of tiles at all coarser zooms plus its position on the Hilbert curve of its zoom. `None`: there
/// is no such tile.
pub fn tile_number(zoom: u8, mut x: u32, mut y: u32) -> Option<u64> {
    // Up to zoom 31 the tile numbers fit into 64 bits, and x and y into 32.
    let side = 1_u32.checked_shl(u32::from(zoom)).filter(|side| x < *side && y < *side)?;
    let coarser = ((1_u64 << (2 * u32::from(zoom))) - 1) / 3;
    let mut place = 0;
    let mut half = side / 2;
    while half > 0 {
        let (right, lower) = (x & half != 0, y & half != 0);
        let quarter = (3 * u64::from(right)) ^ u64::from(lower);
        place += u64::from(half) * u64::from(half) * quarter;
        (x, y) = (x & (half - 1), y & (half - 1));
        if !lower {
            if right {
                (x, y) = (half - 1 - x, half - 1 - y);
            }
            (x, y) = (y, x);
        }
        half /= 2;
    }
    Some(coarser + place)
}

/// Text without HTML tags, which attributions often contain.
fn plain(text: &str) -> String {
    let mut is_tag = false;
    let kept = text.chars().filter(|&character| {
        let is_text = !is_tag && character != '<';
        is_tag = if is_tag { character != '>' } else { character == '<' };
        is_text
    });
    kept.collect::<String>().replace("&copy;", "©").replace("&amp;", "&").trim().to_owned()
}
