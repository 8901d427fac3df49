//! Encodings of pictures: CAT129 and CAT062 records and datagrams, the service status, and the file formats of `replay`. Also
//! tables, of pictures and of records.

mod cat062;
mod cat063;
mod cat129;
mod cot;
mod csv;
mod datagrams;
mod encoders;
mod f3623;
mod files;
mod mcap;
mod pcap;
pub mod records;
pub mod sapient;
mod status;
pub mod table;
mod track_numbers;
mod tracks;

pub use cat062::Cat062Encoder;
pub use cat129::Cat129Encoder;
pub use cot::{CotSecond, CotWriter};
pub use datagrams::{DATAGRAM_MAX, pack};
pub use encoders::Encoders;
pub use f3623::observations;
pub use files::{OutputFormat, PictureWriter, flow};
pub use pcap::MAGIC_NANOSECONDS;
pub use pcap::{PcapWriter, UdpFlow};
pub use status::status_block;
pub use tracks::{track_columns, write_track};
