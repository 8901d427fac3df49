//! The file formats of `replay`.

use std::io::{self, Write};
use std::net::Ipv4Addr;
use std::path::Path;

use serde::Serialize;

use super::csv::CsvWriter;
use super::mcap::{Look, McapWriter};
use super::table::{Parquet, Table};
use super::{Cat062Encoder, Cat129Encoder, PcapWriter, UdpFlow, pack, track_columns, write_track};
use crate::config::{Address, Category, Config, Feed, PictureKind, Sink};
use crate::picture::{Picture, PictureMaker, PictureTrack, TrackJson};
use fusion::time::Time;

/// Format of an output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum OutputFormat {
    /// CAT129 data blocks, one after another.
    Asterix,
    /// CAT129 datagrams as the service would send them, with the times at which it would.
    Pcap,
    /// CAT062 data blocks, one after another.
    Cat062,
    /// CAT062 datagrams as the service would send them, with the times at which it would.
    #[value(name = "cat062-pcap")]
    Cat062Pcap,
    /// One JSON object per line and track.
    Ndjson,
    /// One GeoJSON feature collection (RFC 7946), a point per track and slot.
    Geojson,
    /// Comma-separated values.
    Csv,
    /// Apache Parquet, a row per track and slot.
    Parquet,
    /// MCAP for Foxglove, a GeoJSON feature collection per slot.
    Mcap,
}

impl OutputFormat {
    /// By the extension of a file's name: `.ast .pcap .ndjson .geojson .csv .parquet .mcap`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ast" => Some(Self::Asterix),
            "pcap" => Some(Self::Pcap),
            "ndjson" => Some(Self::Ndjson),
            "geojson" => Some(Self::Geojson),
            "csv" => Some(Self::Csv),
            "parquet" => Some(Self::Parquet),
            "mcap" => Some(Self::Mcap),
            _ => None,
        }
    }
}

/// Writes pictures in one format.
pub struct PictureWriter<W: Write + Send> {
    form: Form<W>,
    encoder: Cat129Encoder,
    system_tracks: Cat062Encoder,
    latency: jiff::SignedDuration,
}

enum Form<W: Write + Send> {
    Asterix { out: W, block: Vec<u8> },
    Pcap { out: PcapWriter<W>, flow: UdpFlow, category: Category },
    Cat062 { out: W },
    Ndjson { out: W, lines: Vec<u8> },
    Geojson { out: W, features: u64 },
    Csv(CsvWriter<W>),
    Parquet(Box<Parquet<W>>),
    Mcap(McapWriter<W>),
}

impl<W: Write + Send> Form<W> {
    fn pcap(out: W, config: &Config, feed: Feed) -> io::Result<Self> {
        let flow = flow(config.output.sink(feed));
        Ok(Self::Pcap { out: PcapWriter::new(out)?, flow, category: feed.category })
    }
}

/// Where the service sends when the configuration names no sink.
const DEFAULT_FLOW: UdpFlow =
    UdpFlow { from: Ipv4Addr::LOCALHOST, to: Ipv4Addr::new(239, 192, 129, 2), port: 8130, ttl: 1 };

impl<W: Write + Send> PictureWriter<W> {
    /// Writes the format's header. `picture`: which ones will be written.
    pub fn new(format: OutputFormat, mut out: W, config: &Config, picture: PictureKind) -> io::Result<Self> {
        let form = match format {
            OutputFormat::Asterix => Form::Asterix { out, block: Vec::new() },
            OutputFormat::Pcap => Form::pcap(out, config, Feed { picture, category: Category::Cat129 })?,
            OutputFormat::Cat062 => Form::Cat062 { out },
            OutputFormat::Cat062Pcap => {
                Form::pcap(out, config, Feed { picture, category: Category::Cat062 })?
            }
            OutputFormat::Ndjson => Form::Ndjson { out, lines: Vec::new() },
            OutputFormat::Geojson => {
                out.write_all(b"{\"type\":\"FeatureCollection\",\"features\":[")?;
                Form::Geojson { out, features: 0 }
            }
            OutputFormat::Csv => Form::Csv(CsvWriter::new(out, config)?),
            OutputFormat::Parquet => Form::Parquet(Box::new(Parquet::new(out, &track_columns())?)),
            OutputFormat::Mcap => Form::Mcap(McapWriter::new(out)?),
        };
        let encoder = Cat129Encoder::of(config);
        // A slot is sent this long after its centre.
        let latency = config.fusion.latency_of(picture) - config.fusion.slot / 2;
        Ok(Self { form, encoder, system_tracks: Cat062Encoder::new(config, picture), latency })
    }

    /// Writes a picture.
    pub fn write(&mut self, picture: &Picture, maker: &PictureMaker) -> io::Result<()> {
        match &mut self.form {
            Form::Asterix { out, block } => {
                block.clear();
                for track in &picture.tracks {
                    self.encoder.encode(track, block);
                }
                out.write_all(block)
            }
            Form::Cat062 { out } => {
                let blocks = self.system_tracks.encode(picture.time, &picture.tracks);
                blocks.iter().try_for_each(|block| out.write_all(block))
            }
            Form::Pcap { out, flow, category } => {
                let sent: Time = picture.time + self.latency;
                let datagrams = match category {
                    Category::Cat129 => pack(&picture.tracks, &self.encoder),
                    Category::Cat062 => self.system_tracks.encode(picture.time, &picture.tracks),
                };
                datagrams.iter().try_for_each(|datagram| out.write(*flow, sent, datagram))
            }
            Form::Ndjson { out, lines } => {
                lines.clear();
                for track in &picture.tracks {
                    serde_json::to_writer(&mut *lines, &TrackJson::new(track, maker))?;
                    lines.push(b'\n');
                }
                out.write_all(lines)
            }
            Form::Geojson { out, features } => picture.tracks.iter().try_for_each(|track| {
                out.write_all(if *features == 0 { b"\n" } else { b",\n" })?;
                *features += 1;
                Ok(serde_json::to_writer(&mut *out, &Feature::new(track, maker, None))?)
            }),
            Form::Csv(writer) => writer.picture(picture, maker),
            Form::Parquet(table) => {
                picture.tracks.iter().try_for_each(|track| write_track(&mut **table, track, maker))
            }
            Form::Mcap(writer) => writer.picture(picture, maker),
        }
    }

    /// Writes the format's end, and everything buffered.
    pub fn finish(self) -> io::Result<()> {
        match self.form {
            Form::Asterix { mut out, .. } | Form::Cat062 { mut out } | Form::Ndjson { mut out, .. } => {
                out.flush()
            }
            Form::Csv(writer) => writer.finish(),
            Form::Pcap { mut out, .. } => out.flush(),
            Form::Geojson { mut out, .. } => {
                out.write_all(b"\n]}\n")?;
                out.flush()
            }
            Form::Parquet(table) => table.finish(),
            Form::Mcap(writer) => writer.finish(),
        }
    }
}

/// The flow of a sink's datagrams; without one, that of the documentation.
pub fn flow(sink: Option<&Sink>) -> UdpFlow {
    let Some(sink) = sink else { return DEFAULT_FLOW };
    let (from, to) = match sink.address {
        Address::Multicast { group, interface } => (interface, group),
        Address::Unicast(address) => (Ipv4Addr::LOCALHOST, address),
    };
    UdpFlow { from, to, port: sink.port, ttl: sink.ttl }
}

/// A track as GeoJSON has it.
#[derive(Serialize)]
pub(super) struct Feature<'a> {
    r#type: &'static str,
    geometry: Geometry,
    properties: Properties<'a>,
}

/// Longitude, latitude and, where it was measured, ellipsoidal height.
#[derive(Serialize)]
struct Geometry {
    r#type: &'static str,
    coordinates: Vec<f64>,
}

/// Those of the track and, for a map that asks for it, how it is to be drawn.
#[derive(Serialize)]
struct Properties<'a> {
    #[serde(flatten)]
    look: Option<Look>,
    #[serde(flatten)]
    track: TrackJson<'a>,
}

impl<'a> Feature<'a> {
    pub(super) fn new(track: &'a PictureTrack, maker: &'a PictureMaker, look: Option<Look>) -> Self {
        let track = TrackJson::new(track, maker);
        let mut coordinates = vec![track.lng(), track.lat()];
        coordinates.extend(track.alt());
        Self {
            r#type: "Feature",
            geometry: Geometry { r#type: "Point", coordinates },
            properties: Properties { look, track },
        }
    }
}
