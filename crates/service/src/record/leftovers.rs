//! Completes recordings that an interrupted service left: its captures get their final names, without a torn last datagram.

use std::fs::{self, OpenOptions};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::names;
use picture::formats::MAGIC_NANOSECONDS;

/// Size of the head of a capture, and of the head of each datagram in it, in octets.
const FILE_HEAD: u64 = 24;
const HEAD: u64 = 16;
/// Range of the length of a recorded frame: Ethernet, IPv4 and UDP headers, and the datagram.
const FRAMES: std::ops::RangeInclusive<u32> = 42..=42 + 65_507;

/// Renames the captures that an interrupted recorder left; returns their number. Recordings without a datagram are removed.
///
/// # Errors
/// The directory cannot be read, or a file cannot be renamed.
pub(super) fn complete(directory: &Path) -> io::Result<usize> {
    let mut stamps = Vec::new();
    let mut count = 0;
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        let Some((series, stamp, "pcap.part")) = name.to_str().and_then(names::parts) else { continue };
        let file = directory.join(series.name(stamp) + ".pcap");
        // A file that cannot be repaired can still be read up to the damage.
        let _ = cut_torn_end(&names::part(&file));
        fs::rename(names::part(&file), &file)?;
        stamps.push(stamp.to_owned());
        count += 1;
    }
    for stamp in stamps {
        let is_empty = |path: &Path| {
            fs::metadata(path).map_or_else(
                |error| error.kind() == io::ErrorKind::NotFound,
                |metadata| metadata.is_file() && metadata.len() <= FILE_HEAD,
            )
        };
        let captures = [names::Series::Input, names::Series::Output]
            .map(|series| directory.join(series.name(&stamp) + ".pcap"));
        if captures.iter().all(|path| is_empty(path)) {
            names::remove(directory, &stamp);
        }
    }
    Ok(count)
}

/// Cuts off the octets after the last whole datagram of a capture: a part of the next one, or zeros left by a power
/// failure.
fn cut_torn_end(path: &Path) -> io::Result<()> {
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    let length = file.metadata()?.len();
    let mut reader = BufReader::with_capacity(1 << 16, &file);
    let mut magic = [0; 4];
    reader.read_exact(&mut magic)?;
    if u32::from_le_bytes(magic) != MAGIC_NANOSECONDS {
        return Ok(());
    }
    reader.seek(SeekFrom::Start(FILE_HEAD))?;
    let mut whole = FILE_HEAD;
    while whole + HEAD <= length {
        let mut head = [0; HEAD as usize];
        reader.read_exact(&mut head)?;
        let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (captured, original) = (word(8), word(12));
        let end = whole + HEAD + u64::from(captured);
        if !FRAMES.contains(&captured) || captured != original || end > length {
            break;
        }
        reader.seek_relative(i64::from(captured))?;
        whole = end;
    }
    if whole < length { file.set_len(whole) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::{SECOND, Time};
    use input::capture::Capture;
    use picture::formats::{PcapWriter, UdpFlow};

    const NAME: &str = "input-20261120T100000.250Z.pcap";

    fn capture(datagrams: u8) -> Vec<u8> {
        let group = std::net::Ipv4Addr::new(239, 192, 48, 1);
        let flow = UdpFlow { from: std::net::Ipv4Addr::LOCALHOST, to: group, port: 8048, ttl: 1 };
        let mut pcap = PcapWriter::new(Vec::new()).unwrap();
        for index in 0..datagrams {
            let time = Time::from_nanos((1_795_168_800 + i64::from(index)) * SECOND);
            pcap.write(flow, time, &vec![index; usize::from(index)]).unwrap();
        }
        pcap.get_mut().clone()
    }

    #[test]
    fn torn_datagram_is_cut_off_wherever_it_ends() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-torn-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let (file, part) = (directory.join(NAME), directory.join(format!("{NAME}.part")));
        let four = capture(4);
        for cut in 0..=four.len() {
            // Zeros within a datagram would be taken for its octets.
            let is_boundary = (0..4).any(|count| capture(count).len() == cut);
            for zeros in [0, 100].into_iter().take(1 + usize::from(is_boundary)) {
                let mut octets = four[..cut].to_vec();
                octets.resize(cut + zeros, 0);
                fs::write(&part, &octets).unwrap();
                assert_eq!(complete(&directory).unwrap(), 1);
                assert!(!part.exists());
                if cut < FILE_HEAD as usize {
                    // The head is too short to be read, so there is no datagram.
                    let _ = fs::remove_file(&file);
                    continue;
                }
                let Ok(opened) = Capture::open(&file) else {
                    assert!(cut < capture(1).len(), "{cut}");
                    continue;
                };
                let datagrams: Vec<_> = opened.map(|datagram| datagram.unwrap().payload.len()).collect();
                let whole = (0..=4).rfind(|&count| capture(count).len() <= cut).unwrap();
                assert_eq!(datagrams, (0..usize::from(whole)).collect::<Vec<_>>(), "{cut} {zeros}");
                fs::remove_file(&file).unwrap();
            }
        }
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn recording_without_a_datagram_is_removed() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-empty-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join(format!("{NAME}.part")), capture(0)).unwrap();
        fs::write(directory.join(NAME.replace("input", "output") + ".part"), capture(0)).unwrap();
        fs::write(directory.join(NAME.replace("pcap", "site.toml")), "site").unwrap();
        fs::write(directory.join("notes.txt"), "mine").unwrap();
        assert_eq!(complete(&directory).unwrap(), 2);
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        fs::remove_dir_all(&directory).unwrap();
    }
}
