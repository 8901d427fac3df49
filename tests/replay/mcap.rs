//! MCAP: records from a simple reader, and their places in the index.

use std::collections::BTreeMap;

use flate2::Crc;
use serde_json::{Value, json};

use super::common::{SLOT_NS, demo};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Reads numbers and texts of a record's content.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take(2).try_into().unwrap())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take(8).try_into().unwrap())
    }

    fn text(&mut self) -> &'a str {
        let length = self.u32() as usize;
        str::from_utf8(self.take(length)).unwrap()
    }
}

/// Kind, offset and content of each record.
fn records(octets: &[u8], from: usize) -> Vec<(u8, usize, &[u8])> {
    let mut reader = Reader(octets);
    let mut records = Vec::new();
    while !reader.0.is_empty() {
        let at = from + octets.len() - reader.0.len();
        let opcode = reader.take(1)[0];
        let length = reader.u64() as usize;
        records.push((opcode, at, reader.take(length)));
    }
    records
}

fn crc(octets: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(octets);
    crc.sum()
}

#[test]
fn each_slot_is_a_message_and_the_index_finds_it() {
    let flight = demo();
    let file = flight.output(&[&flight.capture()], "mcap");
    let inner = file.strip_prefix(MAGIC).unwrap().strip_suffix(MAGIC).unwrap();
    let records = records(inner, MAGIC.len());
    let opcodes: Vec<u8> = records.iter().map(|record| record.0).collect();
    assert_eq!(opcodes, [1, 6, 7, 15, 3, 4, 11, 8, 14, 14, 14, 14, 2]);
    let at = |opcode: u8| *records.iter().find(|record| record.0 == opcode).unwrap();

    let mut header = Reader(at(1).2);
    assert_eq!((header.text(), header.text()), ("", "utm-fusion"));
    let mut chunk = Reader(at(6).2);
    let (first, last, size) = (chunk.u64(), chunk.u64(), chunk.u64());
    let sum = chunk.u32();
    assert_eq!((chunk.text(), chunk.u64()), ("", size));
    assert_eq!((chunk.0.len() as u64, crc(chunk.0)), (size, sum));
    let within = self::records(chunk.0, 0);
    assert_eq!((within[0].0, within[0].2, within[1].0, within[1].2), (3, at(3).2, 4, at(4).2));
    let mut schema = Reader(at(3).2);
    assert_eq!((schema.u16(), schema.text(), schema.text()), (1, "foxglove.GeoJSON", "jsonschema"));
    let schema: Value = serde_json::from_str(schema.text()).unwrap();
    assert_eq!(schema["properties"]["geojson"]["type"], "string");
    let mut channel = Reader(at(4).2);
    assert_eq!((channel.u16(), channel.u16(), channel.text(), channel.text()), (1, 1, "/tracks", "json"));

    // All features of the GeoJSON, slot by slot.
    let features = flight.output(&[&flight.capture()], "geojson");
    let features: Value = serde_json::from_slice(&features).unwrap();
    let mut expected = BTreeMap::<String, Vec<Value>>::new();
    for feature in features["features"].as_array().unwrap() {
        let time = feature["properties"]["time"].as_str().unwrap().to_owned();
        expected.entry(time).or_default().push(feature.clone());
    }
    let mut times = Vec::new();
    for (number, (opcode, at, content)) in within[2..].iter().enumerate() {
        assert_eq!(*opcode, 5);
        let mut message = Reader(content);
        assert_eq!((message.u16(), message.u32()), (1, number as u32));
        let time = message.u64();
        assert_eq!(time, message.u64());
        times.push((time, *at as u64));
        let message: Value = serde_json::from_slice(message.0).unwrap();
        let collection: Value = serde_json::from_str(message["geojson"].as_str().unwrap()).unwrap();
        assert_eq!(collection["type"], "FeatureCollection");
        let mut tracks = collection["features"].as_array().unwrap().clone();
        for track in &mut tracks {
            let properties = track["properties"].as_object_mut().unwrap();
            let (name, style) = (properties.remove("name").unwrap(), properties.remove("style").unwrap());
            let said = properties.get("uas_id").map_or(&properties["id"], |uas_id| &uas_id["serial_number"]);
            assert_eq!(&name, said);
            let colour = match properties["source"].as_str().unwrap() {
                "fused" => "#154f9c",
                "radar" => "#ecab38",
                _ => "#cf5f88",
            };
            assert_eq!(style, json!({ "color": colour }));
        }
        let stamp = jiff::Timestamp::from_nanosecond(time.into()).unwrap();
        let wanted = expected.remove(&format!("{stamp:.3}")).unwrap_or_default();
        assert_eq!(tracks, wanted, "{stamp}");
    }
    assert!(expected.is_empty(), "{:?}", expected.keys());
    assert!(times.windows(2).all(|pair| pair[1].0 - pair[0].0 == SLOT_NS as u64), "a message for every slot");
    assert_eq!((first, last), (times[0].0, times[times.len() - 1].0));

    let mut index = Reader(at(7).2);
    assert_eq!((index.u16(), index.u32() as usize), (1, 16 * times.len()));
    assert!(times.iter().all(|&(time, at)| (index.u64(), index.u64()) == (time, at)));
    let mut index = Reader(at(8).2);
    assert_eq!((index.u64(), index.u64()), (first, last));
    assert_eq!((index.u64() as usize, index.u64() as usize), (at(6).1, at(7).1 - at(6).1));
    assert_eq!((index.u32(), index.u16(), index.u64() as usize), (10, 1, at(7).1));
    let mut statistics = Reader(at(11).2);
    let counts = (statistics.u64() as usize, statistics.u16(), statistics.u32());
    assert_eq!(counts, (times.len(), 1, 1));

    for (_, _, offset) in records.iter().filter(|record| record.0 == 14) {
        let mut offset = Reader(offset);
        let (opcode, from) = (offset.take(1)[0], offset.u64() as usize);
        assert_eq!(from, at(opcode).1);
    }
    let mut footer = Reader(at(2).2);
    let (summary, offsets) = (footer.u64() as usize, footer.u64() as usize);
    assert_eq!((summary, offsets), (at(3).1, at(14).1));
    assert_eq!(footer.u32(), crc(&file[summary..file.len() - MAGIC.len() - 4]));
}
