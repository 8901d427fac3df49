//! A segment of the recording: an input file, an output file, and the files that a replay needs beside them.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use super::RecordedContents;
use super::names::{self, Series};
use crate::state::{CORRELATIONS, ENGINE, NUMBERS_END, number_line, numbers_text, write_atomically};
use fusion::numbering::Given;
use fusion::time::Time;
use picture::formats::{PcapWriter, UdpFlow};

/// Number of octets gathered before they are written; less than a second at most sites.
const GATHERED: usize = 1 << 16;

/// A file to which only whole datagrams are written.
struct DatagramFile {
    file: File,
    waiting: Vec<u8>,
    /// Octets in the file.
    written: u64,
}

impl Write for DatagramFile {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(octets);
        Ok(octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        // Written at an explicit position, because a full disk may have accepted a part the last time.
        if let Err(error) = self.file.write_all_at(&self.waiting, self.written) {
            // If this fails too, readers report the capture as truncated.
            let _ = self.file.set_len(self.written);
            return Err(error);
        }
        self.written += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }
}

/// One of the two captures.
struct PcapFile {
    path: PathBuf,
    pcap: PcapWriter<DatagramFile>,
    /// Datagrams in the file, and datagrams waiting to be written.
    datagrams: u64,
    waiting: u64,
}

impl PcapFile {
    fn begin(path: PathBuf) -> io::Result<Self> {
        let file = fs::OpenOptions::new().write(true).create_new(true).open(names::part(&path))?;
        let gathered = DatagramFile { file, waiting: Vec::with_capacity(2 * GATHERED), written: 0 };
        let mut pcap = PcapWriter::new(gathered)?;
        pcap.flush()?;
        Ok(Self { path, pcap, datagrams: 0, waiting: 0 })
    }

    fn write(&mut self, sender: u16, flow: UdpFlow, time: Time, payload: &[u8]) -> io::Result<()> {
        // A time that the format cannot represent is not a fault of the disk: the frame is left out.
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
        // Writing to a removed file succeeds, but the data would be lost.
        names::part(&self.path).symlink_metadata().map(drop)
    }

    /// Completes the file and gives it its final name.
    fn finish(mut self) -> io::Result<()> {
        let flushed = self.write_out();
        self.pcap.get_mut().file.sync_all()?;
        fs::rename(names::part(&self.path), &self.path)?;
        flushed
    }
}

/// Numbers of the transponders with points in a segment; each is written once, at the end of the file.
struct NumbersFile {
    file: File,
    /// Position of the next line, which overwrites the closing text.
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

    /// Adds a number. A number that passes to another transponder keeps its first one: this happens only when all numbers
    /// are used, and a replay then differs anyway.
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
pub(super) struct RecordingSegment {
    directory: PathBuf,
    /// Stamp in the names of its files.
    stamp: String,
    /// Time of the first reception.
    pub(super) began: Time,
    input: PcapFile,
    output: Option<PcapFile>,
    numbers: Option<NumbersFile>,
    decisions_path: PathBuf,
}

/// Contents of a segment at its beginning.
pub(super) struct SegmentStart<'a> {
    /// Directory of the files.
    pub(super) directory: &'a Path,
    /// Time of reception of its first datagram.
    pub(super) began: Time,
    /// Opening of the first slot whose replay equals the output.
    pub(super) complete_from: Time,
    /// The effective configuration.
    pub(super) site: &'a str,
    /// Numbers of transponders that may be in flight.
    pub(super) numbers: &'a [Given],
    /// Text of the registration's file.
    pub(super) registration: &'a str,
    /// Lines of the decisions in force.
    pub(super) held: &'a str,
    /// State of the pipeline, if available.
    pub(super) checkpoint: Option<&'a [u8]>,
    /// Contents of the recording.
    pub(super) contents: RecordedContents,
}

impl RecordingSegment {
    /// Begins the files of a segment.
    pub(super) fn begin(beginning: &SegmentStart<'_>) -> io::Result<Self> {
        let directory = beginning.directory;
        let stamp = names::free_stamp(directory, beginning.began);
        let path =
            |series: Series, extension: &str| directory.join(format!("{}.{extension}", series.name(&stamp)));
        let begun = Self::begin_files(beginning, &stamp, &path);
        if begun.is_err() {
            // A full disk must not collect the remains of each attempt.
            names::remove(directory, &stamp);
        }
        begun
    }

    fn begin_files(
        beginning: &SegmentStart<'_>,
        stamp: &str,
        path: &dyn Fn(Series, &str) -> PathBuf,
    ) -> io::Result<Self> {
        let SegmentStart {
            directory,
            began,
            complete_from,
            site,
            numbers,
            registration,
            held,
            checkpoint,
            ..
        } = *beginning;
        let name = Series::Input.name(stamp);
        let mut numbers_file = None;
        if beginning.contents != RecordedContents::Datagrams {
            write_atomically(
                &path(Series::Input, "site.toml"),
                format!(
                    "# The configuration in force while {name}.pcap was recorded. To replay it:\n\
                     #   utm-fusion replay {name}.pcap --config {name}.site.toml --state {name}\n\
                     # From this slot on the replay equals what was sent:\n\
                     # complete_from = {complete_from}\n\n{site}"
                ),
            )?;
            numbers_file = Some(NumbersFile::begin(&path(Series::Input, "numbers.json"), numbers)?);
            write_atomically(&path(Series::Input, "registration.json"), registration)?;
        }
        let decisions_path = path(Series::Input, CORRELATIONS);
        if !held.is_empty() {
            write_atomically(&decisions_path, held)?;
        }
        if let Some(state) = checkpoint {
            write_atomically(&path(Series::Input, ENGINE), state)?;
        }
        let input = PcapFile::begin(path(Series::Input, "pcap"))?;
        let is_service = beginning.contents == RecordedContents::Service;
        let output = is_service.then(|| PcapFile::begin(path(Series::Output, "pcap"))).transpose()?;
        Ok(Self {
            directory: directory.to_owned(),
            stamp: stamp.to_owned(),
            began,
            input,
            output,
            numbers: numbers_file,
            decisions_path,
        })
    }

    /// Records a received datagram.
    pub(super) fn input(&mut self, sender: u16, flow: UdpFlow, at: Time, payload: &[u8]) -> io::Result<()> {
        self.input.write(sender, flow, at, payload)
    }

    /// Records a sent datagram.
    pub(super) fn output(&mut self, flow: UdpFlow, due: Time, payload: &[u8]) -> io::Result<()> {
        self.output.as_mut().map_or(Ok(()), |file| file.write(flow.port, flow, due, payload))
    }

    /// Records a transponder's number: without it a replay, which does not see data before the file, would assign others.
    pub(super) fn numbered(&mut self, given: &Given) -> io::Result<()> {
        self.numbers.as_mut().map_or(Ok(()), |numbers| numbers.add(given))
    }

    /// Records a decision; the line includes its line feed.
    pub(super) fn decided(&self, line: &str) -> io::Result<()> {
        let mut file = fs::OpenOptions::new().create(true).append(true).open(&self.decisions_path)?;
        file.write_all(line.as_bytes())
    }

    /// Octets of the larger file.
    pub(super) fn size(&mut self) -> u64 {
        self.input.size().max(self.output.as_mut().map_or(0, PcapFile::size))
    }

    /// Passes all data to the operating system: it survives the end of the process, but not of the machine.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.input.flush()?;
        self.output.as_mut().map_or(Ok(()), PcapFile::flush)
    }

    /// Syncs its files to the disk, and gives them their final names.
    pub(super) fn finish(self) -> io::Result<()> {
        let output = self.output.map_or(Ok(()), PcapFile::finish);
        self.input.finish().and(output)
    }
    /// Ends the segment after a failure of the disk; returns the number of datagrams not written. Files with datagrams are
    /// kept; a segment without any is removed.
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
