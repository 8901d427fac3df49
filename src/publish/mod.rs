//! Pictures out: CAT129 records, and files in the formats of `replay`.

mod cat129;
mod csv;
mod datagrams;
mod files;
mod pcap;

pub use cat129::Cat129Encoder;
pub use datagrams::{DATAGRAM_MAX, pack};
pub use files::{OutputFormat, PictureWriter};
pub use pcap::{PcapWriter, UdpFlow};
