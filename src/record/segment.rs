//! A stretch of the recording: an input file, an output file, and what a replay needs beside them.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use super::names::{self, Series};
use crate::formats::{PcapWriter, UdpFlow};
use crate::state::{CORRELATIONS, ENGINE, NUMBERS_END, number_line, numbers_text, write_atomically};
use fusion::numbering::Given;
use fusion::time::Time;

/// Datagrams are gathered to about this many octets before they are written, less than a second of most sites.
const GATHERED: usize = 1 << 16;

/// A file that datagrams reach whole: between two writes it ends with one.
struct Gathered {
    file: File,
    waiting: Vec<u8>,
    /// Octets that the file has.
    written: u64,
}

impl Write for Gathered {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(octets);
        Ok(octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        // At its place, not at the file's own: a full disk may have taken a part the last time.
        if let Err(error) = self.file.write_all_at(&self.waiting, self.written) {
            // What cannot be cut off either is what a reader calls truncated.
            let _ = self.file.set_len(self.written);
            return Err(error);
        }
        self.written += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }
}

/// One of the two files.
struct PcapFile {
    path: PathBuf,
    pcap: PcapWriter<Gathered>,
    /// Datagrams that the file has, and those that wait.
    datagrams: u64,
    waiting: u64,
}

impl PcapFile {
    fn begin(path: PathBuf) -> io::Result<Self> {
        let file = fs::OpenOptions::new().write(true).create_new(true).open(names::part(&path))?;
        let gathered = Gathered { file, waiting: Vec::with_capacity(2 * GATHERED), written: 0 };
        let mut pcap = PcapWriter::new(gathered)?;
        pcap.flush()?;
        Ok(Self { path, pcap, datagrams: 0, waiting: 0 })
    }

    fn write(&mut self, sender: u16, flow: UdpFlow, time: Time, payload: &[u8]) -> io::Result<()> {
        // A time that the format cannot hold is the datagram's fault, not the disk's: the frame is left out.
        if u32::try_from(time.nanos().div_euclid(fusion::time::SECOND)).is_err() {
            return Ok(());
        }
        self.pcap.write_from(sender, flow, time, payload)?;
        if self.pcap.get_mut().waiting.len() >= GATHERED {
            self.write_out()?;
            self.datagrams += 1;
        } else {
            self.waiting += 1;
        }
        Ok(())
    }

    fn write_out(&mut self) -> io::Result<()> {
        self.pcap.flush()?;
        self.datagrams += std::mem::take(&mut self.waiting);
        Ok(())
    }

    fn size(&mut self) -> u64 {
        let gathered = self.pcap.get_mut();
        gathered.written + gathered.waiting.len() as u64
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_out()?;
        // Writing to a file that was removed succeeds, and nobody will ever read it.
        names::part(&self.path).symlink_metadata().map(drop)
    }

    /// Gives the file its name.
    fn finish(mut self) -> io::Result<()> {
        let flushed = self.write_out();
        self.pcap.get_mut().file.sync_all()?;
        fs::rename(names::part(&self.path), &self.path)?;
        flushed
    }
}

/// The numbers of the transponders that have points in a segment: each is written once, at the end of the file.
struct NumbersFile {
    file: File,
    /// Where the next line goes, over the end.
    end: u64,
    written: BTreeSet<u32>,
}

impl NumbersFile {
    fn begin(path: &Path, numbers: &[Given]) -> io::Result<Self> {
        let text = numbers_text(numbers);
        write_atomically(path, &text)?;
        let file = fs::OpenOptions::new().write(true).open(path)?;
        let end = (text.len() - NUMBERS_END.len()) as u64;
        Ok(Self { file, end, written: numbers.iter().map(|given| given.number).collect() })
    }

    /// A number that passes to somebody else stays the first one's: that takes all numbers, and a replay gives others.
    fn add(&mut self, given: &Given) -> io::Result<()> {
        let parted = if self.written.is_empty() { "" } else { ",\n" };
        if self.written.insert(given.number) {
            let line = format!("{parted}{}", number_line(given));
            self.file.write_all_at(format!("{line}{NUMBERS_END}").as_bytes(), self.end)?;
            self.end += line.len() as u64;
        }
        Ok(())
    }
}

/// The files being written.
pub(super) struct Segment {
    directory: PathBuf,
    /// What the names of its files have in common.
    stamp: String,
    /// The first reception.
    pub(super) began: Time,
    input: PcapFile,
    output: Option<PcapFile>,
    numbers: NumbersFile,
    decisions_path: PathBuf,
}

/// The beginning of a segment.
pub(super) struct Beginning<'a> {
    /// Where.
    pub(super) directory: &'a Path,
    /// The reception of its first datagram.
    pub(super) began: Time,
    /// The opening of the first slot whose replay equals the output.
    pub(super) complete_from: Time,
    /// The effective configuration.
    pub(super) site: &'a str,
    /// The numbers of transponders that may fly.
    pub(super) numbers: &'a [Given],
    /// The text of the registration's file.
    pub(super) registration: &'a str,
    /// The lines of the decisions that are in force.
    pub(super) held: &'a str,
    /// The state of the pipeline, where it is known.
    pub(super) checkpoint: Option<&'a [u8]>,
    /// Whether the output is recorded, too.
    pub(super) with_output: bool,
}

impl Segment {
    /// Begins its files.
    pub(super) fn begin(beginning: &Beginning<'_>) -> io::Result<Self> {
        let directory = beginning.directory;
        let stamp = names::free_stamp(directory, beginning.began);
        let path =
            |series: Series, extension: &str| directory.join(format!("{}.{extension}", series.name(&stamp)));
        let begun = Self::begin_files(beginning, &stamp, &path);
        if begun.is_err() {
            // A disk that stays full must not gather what is left of every trial.
            names::remove(directory, &stamp);
        }
        begun
    }

    fn begin_files(
        beginning: &Beginning<'_>,
        stamp: &str,
        path: &dyn Fn(Series, &str) -> PathBuf,
    ) -> io::Result<Self> {
        let Beginning {
            directory, began, complete_from, site, numbers, registration, held, checkpoint, ..
        } = *beginning;
        let name = Series::Input.name(stamp);
        write_atomically(
            &path(Series::Input, "site.toml"),
            format!(
                "# The configuration in force while {name}.pcap was recorded. To replay it:\n\
                 #   utm-fusion replay {name}.pcap --config {name}.site.toml --state {name}\n\
                 # From this slot on the replay equals what was sent:\n\
                 # complete_from = {complete_from}\n\n{site}"
            ),
        )?;
        let numbers = NumbersFile::begin(&path(Series::Input, "numbers.json"), numbers)?;
        write_atomically(&path(Series::Input, "registration.json"), registration)?;
        let decisions_path = path(Series::Input, CORRELATIONS);
        if !held.is_empty() {
            write_atomically(&decisions_path, held)?;
        }
        if let Some(state) = checkpoint {
            write_atomically(&path(Series::Input, ENGINE), state)?;
        }
        let input = PcapFile::begin(path(Series::Input, "pcap"))?;
        let output =
            beginning.with_output.then(|| PcapFile::begin(path(Series::Output, "pcap"))).transpose()?;
        Ok(Self {
            directory: directory.to_owned(),
            stamp: stamp.to_owned(),
            began,
            input,
            output,
            numbers,
            decisions_path,
        })
    }

    /// Records what was received.
    pub(super) fn input(&mut self, sender: u16, flow: UdpFlow, at: Time, payload: &[u8]) -> io::Result<()> {
        self.input.write(sender, flow, at, payload)
    }

    /// Records what was sent.
    pub(super) fn output(&mut self, flow: UdpFlow, due: Time, payload: &[u8]) -> io::Result<()> {
        self.output.as_mut().map_or(Ok(()), |file| file.write(flow.port, flow, due, payload))
    }

    /// Notes a transponder's number: the engine of a replay, which has not seen what came before the file, would give
    /// others.
    pub(super) fn numbered(&mut self, given: &Given) -> io::Result<()> {
        self.numbers.add(given)
    }

    /// Notes a decision; its line ends itself.
    pub(super) fn decided(&self, line: &str) -> io::Result<()> {
        let mut file = fs::OpenOptions::new().create(true).append(true).open(&self.decisions_path)?;
        file.write_all(line.as_bytes())
    }

    /// Octets of the larger file.
    pub(super) fn size(&mut self) -> u64 {
        self.input.size().max(self.output.as_mut().map_or(0, PcapFile::size))
    }

    /// Hands everything to the system: it outlives the process, though not the machine.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.input.flush()?;
        self.output.as_mut().map_or(Ok(()), PcapFile::flush)
    }

    /// Makes its files durable and gives them their names.
    pub(super) fn finish(self) -> io::Result<()> {
        let output = self.output.map_or(Ok(()), PcapFile::finish);
        self.input.finish().and(output)
    }
    /// Ends it where the disk failed; how many of its datagrams have not been written. What has been written keeps its
    /// worth; where that is nothing, nothing is left.
    pub(super) fn abandon(mut self) -> u64 {
        let (mut datagrams, mut waiting) = (0, 0);
        for file in std::iter::once(&mut self.input).chain(&mut self.output) {
            let _ = file.write_out();
            datagrams += file.datagrams;
            waiting += file.waiting;
        }
        let (directory, stamp) = (self.directory.clone(), self.stamp.clone());
        let _ = self.finish();
        if datagrams == 0 {
            names::remove(&directory, &stamp);
        }
        waiting
    }
}
