//! The recorder's thread: begins and ends files, and handles failures of the disk.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use bytes::Bytes;
use jiff::SignedDuration;
use tracing::{error, info, warn};

use super::RecordedContents;
use super::leftovers;
use super::queue::RecorderCounters;
use super::recorded::RecordingItem;
use super::retention::{self, LONGEST, Retention};
use super::segment::{RecordingSegment, SegmentStart};
use crate::clock::now;
use crate::net::listen as udp;
use crate::state::{SavedRegistrations, registration_text};
use fusion::numbering::{Given, NOTED};
use fusion::slots::SlotGrid;
use fusion::time::Time;
use picture::formats::{UdpFlow, flow};
use site::config::{Config, Feed, Record};

/// Maximum time of data lost when the process is killed.
const FLUSH: Duration = Duration::from_secs(1);
/// Pause before a failed disk is tried again.
const RETRY: Duration = Duration::from_secs(5);
/// Time between two checks of the retention limits.
const RETAIN: Duration = Duration::from_secs(60);
/// Maximum time for which a full file waits for a checkpoint, with which the next file can begin.
const CHECKPOINT_AWAITED: SignedDuration = SignedDuration::from_secs(60);
/// Time for which copies of a datagram are recognised: copies of datagrams before a file are not handled again in it.
const DUPLICATES: SignedDuration = SignedDuration::from_secs(2);
/// Number of octets that a failed disk has to accept before it is used again: less would be full again at once.
const TRIAL: usize = 1 << 20;
/// Locked file of a directory, so that only one recorder writes into it.
const LOCK: &str = ".recorder.lock";

/// State of the recorder's thread.
pub(super) struct RecordingWriter {
    directory: PathBuf,
    /// Size of a full file, in octets.
    rotate: u64,
    retention: Retention,
    contents: RecordedContents,
    site: String,
    /// Destination address of each line's datagrams.
    lines: Vec<SocketAddrV4>,
    output: UdpFlow,
    grid: SlotGrid,
    latency_slots: i64,
    window_slots: i64,
    max_future: SignedDuration,
    /// Numbers of transponders that may be in flight.
    numbers: BTreeMap<u32, Given>,
    /// Text of the registration's file.
    registration: Arc<str>,
    /// Lines of the decisions in force.
    held: Arc<str>,
    /// State before the next datagram, if available.
    checkpoint: Option<Bytes>,
    /// Whether there are checkpoints: then a full file waits for one.
    has_checkpoints: bool,
    /// Slots up to this centre are not in the output, because an earlier run published them.
    published: Option<Time>,
    full_since: Option<Time>,
    /// Latest time of reception, recorded or not, or of a gap.
    latest: Option<Time>,
    lock: Option<File>,
    segment: Option<RecordingSegment>,
    /// Time at which a failed disk is tried again.
    retry: Option<Instant>,
    failing: bool,
    lost_told: u64,
    counters: Arc<RecorderCounters>,
}

impl RecordingWriter {
    /// Recorder that has not written yet.
    pub(super) fn new(
        config: &Config,
        record: &Record,
        numbers: Vec<Given>,
        contents: RecordedContents,
        counters: Arc<RecorderCounters>,
    ) -> Self {
        let grid = SlotGrid::new(config.fusion.slot);
        Self {
            directory: record.dir.clone(),
            rotate: u64::from(record.rotate_mib) << 20,
            retention: Retention::of(record),
            contents,
            site: config.to_string(),
            lines: udp::lines(config).iter().map(udp::ConfiguredLine::destination).collect(),
            output: flow(config.output.sink(Feed::RECORDED)),
            grid,
            latency_slots: config.fusion.latency_slots.into(),
            window_slots: config.fusion.window_slots.into(),
            max_future: config.fusion.max_future,
            numbers: numbers.into_iter().map(|given| (given.number, given)).collect(),
            registration: registration_text(&SavedRegistrations::default()).into(),
            held: "".into(),
            checkpoint: None,
            has_checkpoints: false,
            published: None,
            full_since: None,
            latest: None,
            lock: None,
            segment: None,
            retry: None,
            failing: false,
            lost_told: 0,
            counters,
        }
    }

    #[expect(clippy::disallowed_methods, reason = "once a second by the clock of the machine")]
    pub(super) fn run(&mut self, queue: &Receiver<RecordingItem>) {
        // A disk that cannot be written is reported at once, not with the first datagram.
        if let Err(error) = self.open() {
            self.fail(&error);
        }
        let (mut flushed, mut retained) = (Instant::now(), Instant::now());
        loop {
            match queue.recv_timeout(FLUSH) {
                Ok(recorded) => {
                    self.counters.taken();
                    self.take(recorded);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if flushed.elapsed() >= FLUSH {
                flushed = Instant::now();
                self.each_second();
            }
            if retained.elapsed() >= RETAIN && !self.failing {
                retained = Instant::now();
                self.remove_oldest();
            }
        }
        self.tell_lost();
        if let Err(error) = self.end() {
            self.fail(&error);
        }
    }

    fn take(&mut self, recorded: RecordingItem) {
        let is_datagram = matches!(recorded, RecordingItem::Input { .. } | RecordingItem::Output { .. });
        let written = self.write(recorded);
        if is_datagram {
            let counter = match written {
                Ok(true) => &self.counters.written,
                // Sent after a gap, before anything was received again: part of the gap.
                Ok(false) if !self.failing => &self.counters.lost,
                Ok(false) | Err(_) => &self.counters.unwritten,
            };
            counter.fetch_add(1, Ordering::Relaxed);
        }
        if let Err(error) = written {
            self.fail(&error);
        }
    }

    /// Writes an item; returns whether there was a segment for it.
    fn write(&mut self, recorded: RecordingItem) -> io::Result<bool> {
        let segment = self.segment.as_mut();
        let written = match recorded {
            RecordingItem::Input { received, line, from, payload } => {
                let written = self.input(received, line, from, &payload);
                self.checkpoint = None;
                self.latest = self.latest.max(Some(received));
                return written;
            }
            RecordingItem::Output { due, payload } => {
                segment.map(|segment| segment.output(self.output, due, &payload))
            }
            RecordingItem::Numbered(given) => {
                self.numbers.insert(given.number, given);
                segment.map(|segment| segment.numbered(&given))
            }
            RecordingItem::Decided(line) => segment.map(|segment| segment.decided(&line)),
            RecordingItem::Checkpoint(state) => {
                self.checkpoint = Some(state);
                self.has_checkpoints = true;
                None
            }
            RecordingItem::Registered(text) => {
                self.registration = text;
                None
            }
            RecordingItem::Correlations(text) => {
                self.held = text;
                None
            }
            RecordingItem::Published(until) => {
                self.published = Some(until);
                None
            }
            // A new segment states from which slot on a replay is exact again.
            RecordingItem::Gap(until) => {
                // A state from before the gap is not that of the following items.
                self.checkpoint = None;
                self.latest = self.latest.max(Some(until));
                Some(self.end())
            }
        };
        written.transpose().map(|written| written.is_some())
    }

    /// Ends the segment. If it cannot be written it stays open, so that [`RecordingWriter::fail`] counts the losses.
    fn end(&mut self) -> io::Result<()> {
        if let Some(segment) = &mut self.segment {
            segment.flush()?;
        }
        self.segment.take().map_or(Ok(()), RecordingSegment::finish)
    }

    /// Records a received datagram; returns whether it was written. It is not while a failed disk is suspended.
    fn input(&mut self, at: Time, line: usize, from: SocketAddrV4, payload: &[u8]) -> io::Result<bool> {
        let now = self.latest.max(Some(at)).unwrap_or(at);
        let rotate = self.rotate;
        let is_full =
            |segment: &mut RecordingSegment| segment.size() >= rotate || now - segment.began >= LONGEST;
        if self.segment.as_mut().is_none_or(is_full) {
            let waits = self.segment.is_some() && self.has_checkpoints && self.checkpoint.is_none();
            let since = *self.full_since.get_or_insert(now);
            if !waits || now - since > CHECKPOINT_AWAITED {
                self.begin(now)?;
            }
        }
        let to = self.lines.get(line).copied().unwrap_or(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, 0));
        let flow = UdpFlow { from: *from.ip(), to: *to.ip(), port: to.port(), ttl: 1 };
        let written = self.segment.as_mut().map(|segment| segment.input(from.port(), flow, at, payload));
        written.transpose().map(|written| written.is_some())
    }

    /// Ends the segment, and begins one at `now`, the latest reception. Does nothing while a failed disk is suspended.
    fn begin(&mut self, now: Time) -> io::Result<()> {
        self.full_since = None;
        self.end()?;
        if !self.may_try() {
            return Ok(());
        }
        self.open()?;
        let complete_from = match (&self.checkpoint, self.latest) {
            // The next slot but one, because the next may already be made.
            (Some(_), _) => self.grid.open(self.grid.of(now).plus(2 - self.latency_slots)),
            // The engine began with this datagram.
            (None, None) => self.grid.open(self.grid.of(now).plus(1 - self.latency_slots)),
            // All reports in the slot's window were received in this file.
            (None, Some(latest)) => {
                let whole = latest.max(now) + DUPLICATES + self.max_future;
                self.grid.open(self.grid.of(whole).plus(1 + self.window_slots - self.latency_slots))
            }
        };
        // The first slot whose centre is later.
        let own = self.published.map(|until| self.grid.open(self.grid.of(until + self.grid.slot() / 2)));
        let complete_from = own.map_or(complete_from, |own| complete_from.max(own));
        // A transponder without a point for longer is recorded again with its next point. Slots lag by less than a window.
        let lag_ns = self.window_slots * self.grid.slot().as_nanos() as i64;
        let flies = Time::from_nanos(now.nanos() - lag_ns) - NOTED;
        self.numbers.retain(|_, given| given.heard.is_none_or(|heard| heard >= flies));
        let numbers: Vec<Given> = self.numbers.values().copied().collect();
        self.segment = Some(RecordingSegment::begin(&SegmentStart {
            directory: &self.directory,
            began: now,
            complete_from,
            site: &self.site,
            numbers: &numbers,
            registration: &self.registration,
            held: &self.held,
            checkpoint: self.checkpoint.as_deref(),
            contents: self.contents,
        })?);
        // An attempt that may fail again must not remove recordings.
        if !self.failing {
            self.remove_oldest();
        }
        Ok(())
    }

    fn remove_oldest(&self) {
        let now = self.latest.max(Some(now())).unwrap_or_default();
        if let Err(error) = retention::remove_oldest(&self.directory, &self.retention, now) {
            error!(%error, "an old recording cannot be removed");
        }
    }

    /// Whether the disk works, or its suspension is over.
    #[expect(clippy::disallowed_methods, reason = "a failed disk is tried again by the clock of the machine")]
    fn may_try(&self) -> bool {
        self.retry.is_none_or(|retry| Instant::now() >= retry)
    }

    /// Locks the directory for this recorder, and completes the files that an earlier one left.
    fn open(&mut self) -> io::Result<()> {
        let path = self.directory.join(LOCK);
        if self.lock.is_some() && path.exists() {
            return Ok(());
        }
        self.lock = None;
        fs::create_dir_all(&self.directory)?;
        let lock = fs::OpenOptions::new().create(true).append(true).open(&path)?;
        lock.try_lock().map_err(|error| match error {
            fs::TryLockError::WouldBlock => io::Error::other("another process records into this directory"),
            fs::TryLockError::Error(error) => error,
        })?;
        self.lock = Some(lock);
        if self.failing {
            let trial = self.directory.join(".recorder.trial");
            let written = fs::write(&trial, vec![0; TRIAL]);
            let _ = fs::remove_file(trial);
            written?;
        }
        let count = leftovers::complete(&self.directory)?;
        if count > 0 {
            info!(recordings = count, "recordings were cut short by the end of a process");
        }
        Ok(())
    }

    fn each_second(&mut self) {
        self.tell_lost();
        if let Err(error) = self.flush() {
            self.fail(&error);
        }
    }

    /// Writes the waiting data; a failed disk is tried again, even without input.
    fn flush(&mut self) -> io::Result<()> {
        if self.failing && self.segment.is_none() && self.may_try() {
            match self.latest {
                Some(latest) => self.begin(latest)?,
                None => self.open()?,
            }
        }
        if let Some(segment) = &mut self.segment {
            segment.flush()?;
        }
        if self.failing && self.lock.is_some() {
            self.recover();
        }
        Ok(())
    }

    /// Resumes: the disk accepts data again.
    fn recover(&mut self) {
        self.retry = None;
        self.failing = false;
        self.counters.failing.store(false, Ordering::Relaxed);
        let unwritten = self.counters.unwritten.load(Ordering::Relaxed);
        warn!(unwritten, "recording again");
        self.remove_oldest();
    }

    fn tell_lost(&mut self) {
        let lost = self.counters.lost.load(Ordering::Relaxed);
        if lost > self.lost_told {
            // The next files state from which slot on a replay equals the output.
            warn!(lost = lost - self.lost_told, since_start = lost, "the recorder did not keep up");
            self.lost_told = lost;
        }
    }

    /// Suspends the disk for some time. The failure is logged once, and again when the disk works.
    #[expect(clippy::disallowed_methods, reason = "a failed disk is tried again by the clock of the machine")]
    fn fail(&mut self, error: &io::Error) {
        let waited = self.segment.take().map_or(0, RecordingSegment::abandon);
        self.counters.written.fetch_sub(waited, Ordering::Relaxed);
        self.counters.unwritten.fetch_add(waited, Ordering::Relaxed);
        self.counters.failing.store(true, Ordering::Relaxed);
        self.lock = None;
        self.retry = Some(Instant::now() + RETRY);
        if !std::mem::replace(&mut self.failing, true) {
            error!(%error, retry_s = RETRY.as_secs(), "cannot be recorded: tried again, the service goes on");
        }
    }
}
