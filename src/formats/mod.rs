//! Pictures as octets: CAT129 records and datagrams, and the file formats of `replay`.

mod cat129;
mod csv;
mod datagrams;
mod files;
mod pcap;
mod status;

pub use cat129::Cat129Encoder;
pub use datagrams::{DATAGRAM_MAX, pack};
pub use files::{OutputFormat, PictureWriter, flow};
pub use pcap::{PcapWriter, UdpFlow};
pub use status::status_block;
