//! File formats of `replay`.

use std::io::{self, Write};
use std::net::Ipv4Addr;
use std::path::Path;

use serde::Serialize;

use super::csv::CsvWriter;
use super::mcap::{MarkerStyle, McapWriter};
use super::table::{Parquet, TableWriter};
use super::{Cat062Encoder, Cat129Encoder, PcapWriter, UdpFlow, pack, track_columns, write_track};
use crate::{Picture, PictureMaker, PictureTrack, TrackJson};
use fusion::time::Time;
use site::config::{Address, Category, Config, Feed, PictureKind, Sink};

/// Format of an output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum OutputFormat {
    /// CAT129 data blocks, one after another.
    Asterix,
    /// CAT129 datagrams as the service would send them, with the times of transmission.
    Pcap,
    /// CAT062 data blocks, one after another.
    Cat062,
    /// CAT062 datagrams as the service would send them, with the times of transmission.
    #[value(name = "cat062-pcap")]
    Cat062Pcap,
    /// One JSON object per line and track.
    Ndjson,
    /// One GeoJSON feature collection (RFC 7946), with a point per track and slot.
    Geojson,
    /// Comma-separated values.
    Csv,
    /// Apache Parquet, one row per track and slot.
    Parquet,
    /// MCAP for Foxglove, one GeoJSON feature collection per slot.
    Mcap,
}

impl OutputFormat {
    /// Format by file extension: `.ast .pcap .ndjson .geojson .csv .parquet .mcap`.
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

/// Writer of pictures in one format.
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

/// Default destination if the configuration has none.
const DEFAULT_FLOW: UdpFlow =
    UdpFlow { from: Ipv4Addr::LOCALHOST, to: Ipv4Addr::new(239, 192, 129, 2), port: 8130, ttl: 1 };

impl<W: Write + Send> PictureWriter<W> {
    /// Writes the header of the format. `picture` is the kind of the pictures to write.
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
        // A slot is sent this time after its centre.
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
                Ok(serde_json::to_writer(&mut *out, &GeoJsonTrack::new(track, maker, None))?)
            }),
            Form::Csv(writer) => writer.picture(picture, maker),
            Form::Parquet(table) => {
                picture.tracks.iter().try_for_each(|track| write_track(&mut **table, track, maker))
            }
            Form::Mcap(writer) => writer.picture(picture, maker),
        }
    }

    /// Writes the end of the file, and all buffered data.
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

/// Addresses of a destination's datagrams; the example of the documentation if there is none.
pub fn flow(sink: Option<&Sink>) -> UdpFlow {
    let Some(sink) = sink else { return DEFAULT_FLOW };
    let (from, to) = match sink.address {
        Address::Multicast { group, interface } => (interface, group),
        Address::Unicast(address) => (Ipv4Addr::LOCALHOST, address),
    };
    UdpFlow { from, to, port: sink.port, ttl: sink.ttl }
}

/// A track as a GeoJSON feature.
#[derive(Serialize)]
pub(super) struct GeoJsonTrack<'a> {
    r#type: &'static str,
    geometry: TrackPoint,
    properties: Properties<'a>,
}

/// Longitude, latitude and, if measured, ellipsoidal height.
#[derive(Serialize)]
struct TrackPoint {
    r#type: &'static str,
    coordinates: Vec<f64>,
}

/// Properties of the track, and its appearance if a map needs it.
#[derive(Serialize)]
struct Properties<'a> {
    #[serde(flatten)]
    look: Option<MarkerStyle>,
    #[serde(flatten)]
    track: TrackJson<'a>,
}

impl<'a> GeoJsonTrack<'a> {
    pub(super) fn new(track: &'a PictureTrack, maker: &'a PictureMaker, look: Option<MarkerStyle>) -> Self {
        let track = TrackJson::new(track, maker);
        let mut coordinates = vec![track.lng(), track.lat()];
        coordinates.extend(track.alt());
        Self {
            r#type: "Feature",
            geometry: TrackPoint { r#type: "Point", coordinates },
            properties: Properties { look, track },
        }
    }
}
