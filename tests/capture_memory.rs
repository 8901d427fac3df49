//! Memory does not grow with the length of a capture.

#[path = "captures/writer.rs"]
#[expect(dead_code, reason = "other tests write other formats")]
mod writer;

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use peak_alloc::PeakAlloc;
use utm_fusion::capture::Capture;
use writer::{PcapngWriter, WRAPPINGS, final_record};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// A beginning, followed by endless repetitions: a long file that is not stored.
struct Endless {
    beginning: io::Cursor<Vec<u8>>,
    again: io::Cursor<Vec<u8>>,
    times: usize,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.beginning.read(buffer)?;
        if read > 0 {
            return Ok(read);
        }
        if self.again.position() == self.again.get_ref().len() as u64 && self.times > 1 {
            self.times -= 1;
            self.again.set_position(0);
        }
        self.again.read(buffer)
    }
}

fn gzip(octets: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(octets).expect("memory takes it");
    encoder.finish().expect("memory takes it")
}

#[test]
fn a_quarter_of_a_gigabyte_takes_less_than_a_megabyte() {
    let frame = WRAPPINGS[0].frame(4, &[&[48, 4, 0][..], &[7; 1021]].concat());
    let mut pcapng = PcapngWriter::new(true);
    pcapng.interface(1, 0, &[]);
    let beginning = pcapng.octets.split_off(0);
    for time in 0..900 {
        pcapng.packet(0, time, &frame);
    }
    pcapng.block(0x0BAD, &[0; 3 << 20]);
    let recording = final_record(1, &[48; 1000]).repeat(4000);
    let recording_begins = final_record(0, &[48, 0, 4, 0x80]);
    let cases = [
        ("pcapng", &beginning, pcapng.octets.clone(), 900),
        ("pcapng, gzip-compressed", &gzip(&beginning), gzip(&pcapng.octets), 900),
        ("FINAL, gzip-compressed", &gzip(&recording_begins), gzip(&recording), 4000),
    ];
    for (name, beginning, again, datagrams) in cases {
        let times = 64;
        let reader =
            Endless { beginning: io::Cursor::new(beginning.clone()), again: io::Cursor::new(again), times };
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let mut capture = Capture::from_reader(name.to_owned(), Box::new(reader), None).expect(name);
        let mut count = 0;
        let mut octets = 0;
        for datagram in capture.by_ref() {
            octets = datagram.expect(name).origin;
            count += 1;
        }
        let peak = MEMORY.peak_usage() - before;
        println!("{name}: {count} datagrams, {} MiB, peak {} KiB", octets >> 20, peak >> 10);
        assert!(count >= datagrams * times && octets > 230 << 20, "{name}: {count}, {octets}");
        assert!(peak < 1 << 20, "{name}: {peak} bytes");
    }
}
