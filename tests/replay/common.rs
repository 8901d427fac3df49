//! Shared helpers: flights, running the program, and simple decoding of datagrams.

use std::fs;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::Command;

use asterix::{Block, Record, blocks, cat034, cat048, cat129, profile};
use fusion::Emission;
use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Capture, CapturedDatagram, MergedCaptures, Reception};
use utm_fusion::config::Config;
use utm_fusion::formats::{PcapWriter, UdpFlow};
use utm_fusion::pipeline::{Event, Output, Pipeline, Tally};

pub(crate) use crate::program::{Scratch, utm_fusion};

/// Nanoseconds in a slot.
pub(crate) const SLOT_NS: i64 = 250_000_000;

/// Every output format, by file extension.
pub(crate) const EXTENSIONS: [&str; 7] = ["ast", "pcap", "ndjson", "geojson", "csv", "parquet", "mcap"];

/// A directory with a capture, its site configuration, and the expected output.
pub(crate) struct Flight {
    pub(crate) name: String,
    dir: PathBuf,
}

/// The demonstration flight: short, across midnight, with all kinds of input.
pub(crate) fn demo() -> Flight {
    bundled().swap_remove(0)
}

/// The flights in `testdata`.
pub(crate) fn bundled() -> Vec<Flight> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata");
    ["demo", "conformance/bias", "conformance/crossing", "conformance/hostile"]
        .map(|name| Flight { name: name.to_owned(), dir: root.join(name) })
        .into()
}

/// A random site with three radars that classify differently, and two receivers.
pub(crate) fn three_radars() -> Flight {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/three-radars");
    Flight { name: "three-radars".to_owned(), dir }
}

/// Flights of a real drone radar, if `UTM_FUSION_SHARED_DATA` is set.
pub(crate) fn trials() -> Vec<Flight> {
    let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return Vec::new();
    };
    ["1_1", "1_4", "2_1", "1_1/degraded", "1_4/degraded", "2_1/degraded"]
        .map(|name| Flight {
            name: format!("drone-trial/{name}"),
            dir: Path::new(&root).join("drone-trial").join(name),
        })
        .into()
}

impl Flight {
    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.dir.join(file)
    }

    pub(crate) fn capture(&self) -> PathBuf {
        self.path("capture.pcap")
    }

    pub(crate) fn site(&self) -> PathBuf {
        self.path("site.toml")
    }

    pub(crate) fn config(&self) -> Config {
        Config::load(self.site()).unwrap()
    }

    pub(crate) fn receptions(&self) -> Vec<Reception> {
        let capture = Capture::open(&self.capture()).unwrap();
        MergedCaptures::new(vec![capture], jiff::civil::date(1970, 1, 1)).map(Result::unwrap).collect()
    }

    /// `replay` of these inputs with this flight's site.
    pub(crate) fn replay(&self, inputs: &[&Path]) -> Command {
        let mut command = utm_fusion("replay");
        command.args(inputs).arg("--config").arg(self.site());
        command
    }

    /// Output of `replay INPUTS -o x.EXTENSION`, which must succeed.
    pub(crate) fn output(&self, inputs: &[&Path], extension: &str) -> Vec<u8> {
        let scratch = Scratch::new();
        let file = scratch.path(format!("out.{extension}"));
        let ran = ran(self.replay(inputs).arg("-o").arg(&file));
        assert_eq!(ran.code, 0, "{}: {}", self.name, ran.stderr);
        fs::read(file).unwrap()
    }

    /// Lines of this flight's output as CSV, without the header.
    pub(crate) fn csv(&self) -> Vec<String> {
        csv_lines(self.output(&[&self.capture()], "csv"))
    }
}

pub(crate) fn csv_lines(octets: Vec<u8>) -> Vec<String> {
    let text = String::from_utf8(octets).unwrap();
    let mut lines = text.lines();
    let columns = "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags";
    assert_eq!(lines.next(), Some(columns));
    lines.map(str::to_owned).collect()
}

pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Ran {
    pub(crate) fn text(&self) -> &str {
        str::from_utf8(&self.stdout).unwrap()
    }
}

/// Runs the command to its end.
pub(crate) fn ran(command: &mut Command) -> Ran {
    let output = command.output().unwrap();
    Ran {
        code: output.status.code().expect("it was not killed"),
        stdout: output.stdout,
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A capture of these datagrams, with exact time stamps.
pub(crate) fn pcap<'a>(datagrams: impl IntoIterator<Item = (Time, &'a [u8])>) -> Vec<u8> {
    let mut octets = Vec::new();
    let flow = UdpFlow { from: Ipv4Addr::LOCALHOST, to: Ipv4Addr::new(239, 192, 0, 1), port: 8000, ttl: 1 };
    let mut writer = PcapWriter::new(&mut octets).unwrap();
    for (time, payload) in datagrams {
        writer.write(flow, time, payload).unwrap();
    }
    octets
}

/// Datagrams of a complete capture.
pub(crate) fn datagrams(path: &Path) -> Vec<CapturedDatagram> {
    Capture::open(path).unwrap().map(Result::unwrap).collect()
}

/// Output of the library for receptions.
pub(crate) struct Flown {
    pub(crate) emissions: Vec<Emission>,
    /// Events for each reception.
    pub(crate) events: Vec<Vec<Event>>,
    pub(crate) tally: Tally,
}

pub(crate) fn fly(config: &Config, receptions: &[Reception]) -> Flown {
    let mut pipeline = Pipeline::new(config, Masks::default());
    let (mut emissions, mut events) = (Vec::new(), Vec::new());
    for reception in receptions {
        let mut happened = Vec::new();
        pipeline.receive(reception);
        while let Some(output) = pipeline.poll() {
            match output {
                Output::Emission(emission) => emissions.push(emission),
                Output::Event(event) => happened.push(event),
            }
        }
        events.push(happened);
    }
    pipeline.finish();
    emissions.extend(pipeline.emissions());
    Flown { emissions, events, tally: pipeline.tally().clone() }
}

/// Contents of a datagram, from the decoder alone.
#[derive(Default)]
pub(crate) struct Contents {
    pub(crate) plots: Vec<cat048::Record>,
    pub(crate) fixes: Vec<cat129::Record>,
    pub(crate) services: Vec<cat034::Record>,
    pub(crate) faults: usize,
    /// Number of well-formed blocks of unused categories.
    pub(crate) others: usize,
}

pub(crate) fn contents(payload: &[u8]) -> Contents {
    fn records<R: Record<Edition: Default>>(block: Block<'_>, faults: &mut usize) -> Vec<R> {
        let (whole, bad): (Vec<_>, Vec<_>) =
            block.records_in::<R>(Default::default()).partition(Result::is_ok);
        *faults += bad.len();
        whole.into_iter().map(|located| located.unwrap().record).collect()
    }
    let mut contents = Contents::default();
    for block in blocks(payload) {
        match block {
            Ok(block) if block.category == 48 => {
                contents.plots.extend(records::<cat048::Record>(block, &mut contents.faults));
            }
            Ok(block) if block.category == 129 => {
                contents.fixes.extend(records::<cat129::Record>(block, &mut contents.faults));
            }
            Ok(block) if block.category == 34 => {
                contents.services.extend(records::<cat034::Record>(block, &mut contents.faults));
            }
            // A service status must also be well formed.
            Ok(block)
                if block.category == 65 && profile(65).is_some_and(|uap| block.measure(uap).is_err()) =>
            {
                contents.faults += 1;
            }
            Ok(_) => contents.others += 1,
            Err(_) => contents.faults += 1,
        }
    }
    contents
}
