//! Pictures out: CAT129 records, and files in the formats of `replay`.

mod cat129;
mod csv;
mod datagrams;
mod files;
mod pcap;
mod recorder;
mod status;
mod udp;

pub use cat129::Cat129Encoder;
pub use datagrams::{DATAGRAM_MAX, pack};
pub use files::{OutputFormat, PictureWriter};
pub use pcap::{PcapWriter, UdpFlow};
pub use recorder::{Recorded, Recorder, RecorderCounts, RecorderMeter, RecorderQueue, record_into};
pub use status::status_block;
pub use udp::{Sinks, socket};
