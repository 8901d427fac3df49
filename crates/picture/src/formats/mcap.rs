//! Pictures as MCAP, the container of Foxglove: a GeoJSON feature collection per slot on the channel `/tracks`.
//!
//! The format is a sequence of records followed by an index (mcap.dev/spec). It is simple enough to need no crate. Chunks are not
//! compressed, because readers support LZ4 and Zstandard only. A file without its last record and magic is incomplete for every
//! reader.

use std::collections::BTreeMap;
use std::io::{self, Write};

use flate2::Crc;
use serde::Serialize;

use super::files::GeoJsonTrack;
use crate::{Picture, PictureMaker, PictureTrack};
use fusion::Source;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Octets of messages after which a chunk is complete.
const CHUNK: usize = 1 << 20;

const SCHEMA: &str = r#"{"title":"foxglove.GeoJSON","type":"object","properties":{"geojson":{"type":"string","description":"A feature collection (RFC 7946): the tracks of a slot"}},"required":["geojson"]}"#;
const TOPIC: &str = "/tracks";

/// Id of the only schema and the only channel.
const ID: u16 = 1;

/// Kinds of records.
mod opcode {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0b;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0e;
    pub(super) const DATA_END: u8 = 0x0f;
}

/// Writer of pictures, one message each.
pub(super) struct McapWriter<W> {
    out: W,
    /// Number of octets written.
    at: u64,
    /// Records of the current chunk.
    chunk: Vec<u8>,
    /// Messages of the current chunk: time, and offset in the chunk.
    messages: Vec<(u64, u64)>,
    /// Index of the chunks written.
    index: Vec<u8>,
    chunks: u32,
    count: u32,
    /// First and last time.
    times: Option<(u64, u64)>,
}

/// Content of a record. Numbers are little-endian; texts are preceded by their length.
#[derive(Default)]
struct RecordContent(Vec<u8>);

impl RecordContent {
    fn u16(mut self, number: u16) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn u32(mut self, number: u32) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn u64(mut self, number: u64) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn text(mut self, text: &str) -> Self {
        self = self.u32(text.len() as u32);
        self.0.extend_from_slice(text.as_bytes());
        self
    }

    /// Appends a record with this content.
    fn record(self, opcode: u8, out: &mut Vec<u8>) {
        out.push(opcode);
        out.extend((self.0.len() as u64).to_le_bytes());
        out.extend(self.0);
    }
}

/// JSON of a message.
#[derive(Serialize)]
struct McapMessage<'a> {
    geojson: &'a str,
}

/// Tracks of a slot.
#[derive(Serialize)]
struct TrackCollection<'a> {
    r#type: &'static str,
    features: Vec<GeoJsonTrack<'a>>,
}

/// Label and colour of a marker.
#[derive(Serialize)]
pub(super) struct MarkerStyle {
    name: String,
    style: Colour,
}

#[derive(Serialize)]
struct Colour {
    color: &'static str,
}

impl MarkerStyle {
    /// Label: identity of the transponder if there is one, otherwise the id. Colours are those of the figures of `evaluate`.
    fn of(track: &PictureTrack, maker: &PictureMaker) -> Self {
        let source = &track.point.source;
        let serial = source.transponder().map(|part| crate::serial_text(part.identity));
        let color = match source {
            Source::Fused(..) => "#154f9c",
            Source::Radar(_) => "#ecab38",
            Source::Transponder(_) => "#cf5f88",
            Source::Cameras => "#3f9a57",
        };
        Self { name: serial.unwrap_or_else(|| maker.track_id(track)), style: Colour { color } }
    }
}

impl<W: Write> McapWriter<W> {
    /// Writes the beginning of the file.
    pub(super) fn new(out: W) -> io::Result<Self> {
        let mut writer = Self {
            out,
            at: 0,
            chunk: Vec::new(),
            messages: Vec::new(),
            index: Vec::new(),
            chunks: 0,
            count: 0,
            times: None,
        };
        let mut start = MAGIC.to_vec();
        RecordContent::default().text("").text("utm-fusion").record(opcode::HEADER, &mut start);
        writer.put(&start)?;
        Ok(writer)
    }

    /// Adds a picture. An empty one is added too, because it clears the map.
    pub(super) fn picture(&mut self, picture: &Picture, maker: &PictureMaker) -> io::Result<()> {
        let feature = |track| GeoJsonTrack::new(track, maker, Some(MarkerStyle::of(track, maker)));
        let features = picture.tracks.iter().map(feature).collect();
        let geojson = serde_json::to_string(&TrackCollection { r#type: "FeatureCollection", features })?;
        // The format has no time before 1970.
        let time = u64::try_from(picture.time.nanos()).unwrap_or(0);
        if self.chunk.is_empty() {
            definitions(&mut self.chunk);
        }
        self.messages.push((time, self.chunk.len() as u64));
        let mut content = RecordContent::default().u16(ID).u32(self.count).u64(time).u64(time);
        serde_json::to_writer(&mut content.0, &McapMessage { geojson: &geojson })?;
        content.record(opcode::MESSAGE, &mut self.chunk);
        self.count = self.count.wrapping_add(1);
        let (first, last) = self.times.unwrap_or((time, time));
        self.times = Some((first.min(time), last.max(time)));
        if self.chunk.len() >= CHUNK { self.end_chunk() } else { Ok(()) }
    }

    /// Writes the buffered data, the index and the end of the file.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.end_chunk()?;
        let mut end = Vec::new();
        RecordContent::default().u32(0).record(opcode::DATA_END, &mut end);
        self.put(&end)?;

        let start = self.at;
        let mut summary = Vec::new();
        let mut groups = BTreeMap::new();
        let mut group = |opcode: u8, summary: &mut Vec<u8>, add: &mut dyn FnMut(&mut Vec<u8>)| {
            let from = summary.len() as u64;
            add(summary);
            groups.insert(opcode, (start + from, summary.len() as u64 - from));
        };
        group(opcode::SCHEMA, &mut summary, &mut schema);
        group(opcode::CHANNEL, &mut summary, &mut channel);
        let (first, last) = self.times.unwrap_or_default();
        group(opcode::STATISTICS, &mut summary, &mut |out| {
            let of_channel = RecordContent::default().u16(ID).u64(self.count.into());
            let counts =
                RecordContent::default().u64(self.count.into()).u16(1).u32(1).u32(0).u32(0).u32(self.chunks);
            let mut content = counts.u64(first).u64(last).u32(of_channel.0.len() as u32);
            content.0.extend(of_channel.0);
            content.record(opcode::STATISTICS, out);
        });
        group(opcode::CHUNK_INDEX, &mut summary, &mut |out| out.extend_from_slice(&self.index));
        let offsets = start + summary.len() as u64;
        for (group, (from, length)) in groups {
            let mut content = RecordContent(vec![group]);
            content = content.u64(from).u64(length);
            content.record(opcode::SUMMARY_OFFSET, &mut summary);
        }
        // The checksum covers the footer up to the checksum itself.
        let mut footer = Vec::new();
        RecordContent::default().u64(start).u64(offsets).u32(0).record(opcode::FOOTER, &mut footer);
        summary.extend_from_slice(&footer[..footer.len() - 4]);
        let sum = crc(&summary);
        summary.extend(sum.to_le_bytes());
        summary.extend_from_slice(MAGIC);
        self.put(&summary)?;
        self.out.flush()
    }

    /// Writes the current chunk with the index of its messages, if there is one.
    fn end_chunk(&mut self) -> io::Result<()> {
        let times = || self.messages.iter().map(|message| message.0);
        let (Some(first), Some(last)) = (times().min(), times().max()) else { return Ok(()) };
        let (start, size) = (self.at, self.chunk.len() as u64);
        let mut content =
            RecordContent::default().u64(first).u64(last).u64(size).u32(crc(&self.chunk)).text("").u64(size);
        content.0.append(&mut self.chunk);
        let mut record = Vec::new();
        content.record(opcode::CHUNK, &mut record);
        self.put(&record)?;

        let (index_at, length) = (self.at, record.len() as u64);
        let mut content = RecordContent::default().u16(ID).u32(self.messages.len() as u32 * 16);
        for (time, at) in self.messages.drain(..) {
            content = content.u64(time).u64(at);
        }
        record.clear();
        content.record(opcode::MESSAGE_INDEX, &mut record);
        self.put(&record)?;

        let content = RecordContent::default().u64(first).u64(last).u64(start).u64(length);
        let content = content.u32(10).u16(ID).u64(index_at).u64(record.len() as u64);
        content.text("").u64(size).u64(size).record(opcode::CHUNK_INDEX, &mut self.index);
        self.chunks += 1;
        Ok(())
    }

    fn put(&mut self, octets: &[u8]) -> io::Result<()> {
        self.at += octets.len() as u64;
        self.out.write_all(octets)
    }
}

/// Schema and channel of the messages. They are repeated in each chunk, so that each can be read by itself.
fn definitions(out: &mut Vec<u8>) {
    schema(out);
    channel(out);
}

fn schema(out: &mut Vec<u8>) {
    let content = RecordContent::default().u16(ID).text("foxglove.GeoJSON").text("jsonschema").text(SCHEMA);
    content.record(opcode::SCHEMA, out);
}

fn channel(out: &mut Vec<u8>) {
    let content = RecordContent::default().u16(ID).u16(ID).text(TOPIC).text("json").u32(0);
    content.record(opcode::CHANNEL, out);
}

fn crc(octets: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(octets);
    crc.sum()
}
