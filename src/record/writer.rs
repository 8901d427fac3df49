//! The recorder's thread: when files begin and end, and what to do where they cannot.

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

use super::leftovers;
use super::queue::Counters;
use super::recorded::Recorded;
use super::retention::{self, LONGEST, Retention};
use super::segment::{Beginning, Segment};
use crate::config::{Config, Feed, Record};
use crate::formats::{UdpFlow, flow};
use crate::live::now;
use crate::net::listen as udp;
use crate::state::{Registrations, registration_text};
use fusion::numbering::{Given, NOTED};
use fusion::slots::SlotGrid;
use fusion::time::Time;

/// Longest time that a kill may cost.
const FLUSH: Duration = Duration::from_secs(1);
/// Pause before a disk that failed is tried again.
const RETRY: Duration = Duration::from_secs(5);
/// Time between two looks at whether recordings are too old or too large.
const RETAIN: Duration = Duration::from_secs(60);
/// A file that is full waits no longer for a checkpoint that the next could begin with.
const CHECKPOINT_AWAITED: SignedDuration = SignedDuration::from_secs(60);
/// Time for which copies of a datagram are known: what was handled before a file began is not handled again in it.
const DUPLICATES: SignedDuration = SignedDuration::from_secs(2);
/// A disk that failed is used again when it takes this many octets: less is full again in a moment.
const TRIAL: usize = 1 << 20;
/// Only one recorder writes into a directory: it holds a lock on this file.
const LOCK: &str = ".recorder.lock";

/// The recorder's thread.
pub(super) struct Writer {
    directory: PathBuf,
    /// Octets.
    rotate: u64,
    retention: Retention,
    with_output: bool,
    site: String,
    /// Where the datagrams of each line went.
    lines: Vec<SocketAddrV4>,
    output: UdpFlow,
    grid: SlotGrid,
    latency_slots: i64,
    window_slots: i64,
    max_future: SignedDuration,
    /// By number, those of transponders that may fly.
    numbers: BTreeMap<u32, Given>,
    /// The text of its file.
    registration: Arc<str>,
    /// The lines of the decisions that are in force.
    held: Arc<str>,
    /// The state before the next datagram, where there is one.
    checkpoint: Option<Bytes>,
    /// Where there are checkpoints a full file waits for one; since when it is full.
    has_checkpoints: bool,
    /// Slots up to this centre are not in the output: an earlier service's.
    published: Option<Time>,
    full_since: Option<Time>,
    /// The latest reception, recorded or not, or the latest time of what did not fit the queue.
    latest: Option<Time>,
    lock: Option<File>,
    segment: Option<Segment>,
    /// Where the disk failed, when it is tried again.
    retry: Option<Instant>,
    failing: bool,
    lost_told: u64,
    counters: Arc<Counters>,
}

impl Writer {
    /// Writes nothing yet.
    pub(super) fn new(
        config: &Config,
        record: &Record,
        numbers: Vec<Given>,
        with_output: bool,
        counters: Arc<Counters>,
    ) -> Self {
        let grid = SlotGrid::new(config.fusion.slot);
        Self {
            directory: record.dir.clone(),
            rotate: u64::from(record.rotate_mib) << 20,
            retention: Retention::of(record),
            with_output,
            site: config.to_string(),
            lines: udp::lines(config).iter().map(udp::Line::destination).collect(),
            output: flow(config.output.sink(Feed::RECORDED)),
            grid,
            latency_slots: config.fusion.latency_slots.into(),
            window_slots: config.fusion.window_slots.into(),
            max_future: config.fusion.max_future,
            numbers: numbers.into_iter().map(|given| (given.number, given)).collect(),
            registration: registration_text(&Registrations::default()).into(),
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
    pub(super) fn run(&mut self, queue: &Receiver<Recorded>) {
        // A disk that cannot be written is heard of at once, not with the first datagram.
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

    fn take(&mut self, recorded: Recorded) {
        let is_datagram = matches!(recorded, Recorded::Input { .. } | Recorded::Output { .. });
        let written = self.write(recorded);
        if is_datagram {
            let counter = match written {
                Ok(true) => &self.counters.written,
                // Sent after a gap and before anything was received again: it belongs to what the gap cost.
                Ok(false) if !self.failing => &self.counters.lost,
                Ok(false) | Err(_) => &self.counters.unwritten,
            };
            counter.fetch_add(1, Ordering::Relaxed);
        }
        if let Err(error) = written {
            self.fail(&error);
        }
    }

    /// Whether there was a segment to write it to.
    fn write(&mut self, recorded: Recorded) -> io::Result<bool> {
        let segment = self.segment.as_mut();
        let written = match recorded {
            Recorded::Input { received, line, from, payload } => {
                let written = self.input(received, line, from, &payload);
                self.checkpoint = None;
                self.latest = self.latest.max(Some(received));
                return written;
            }
            Recorded::Output { due, payload } => {
                segment.map(|segment| segment.output(self.output, due, &payload))
            }
            Recorded::Numbered(given) => {
                self.numbers.insert(given.number, given);
                segment.map(|segment| segment.numbered(&given))
            }
            Recorded::Decided(line) => segment.map(|segment| segment.decided(&line)),
            Recorded::Checkpoint(state) => {
                self.checkpoint = Some(state);
                self.has_checkpoints = true;
                None
            }
            Recorded::Registered(text) => {
                self.registration = text;
                None
            }
            Recorded::Correlations(text) => {
                self.held = text;
                None
            }
            Recorded::Published(until) => {
                self.published = Some(until);
                None
            }
            // A new segment says from where on a replay is exact again.
            Recorded::Gap(until) => {
                // A state of before it is not that of what follows.
                self.checkpoint = None;
                self.latest = self.latest.max(Some(until));
                Some(self.end())
            }
        };
        written.transpose().map(|written| written.is_some())
    }

    /// Ends the segment. Where it cannot be written it is still there: its end by [`Writer::fail`] counts what is lost.
    fn end(&mut self) -> io::Result<()> {
        if let Some(segment) = &mut self.segment {
            segment.flush()?;
        }
        self.segment.take().map_or(Ok(()), Segment::finish)
    }

    /// Whether it was written; not while a failed disk is left alone.
    fn input(&mut self, at: Time, line: usize, from: SocketAddrV4, payload: &[u8]) -> io::Result<bool> {
        let now = self.latest.max(Some(at)).unwrap_or(at);
        let rotate = self.rotate;
        let is_full = |segment: &mut Segment| segment.size() >= rotate || now - segment.began >= LONGEST;
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

    /// Ends the segment, and begins one at `now`, the latest reception. Does nothing while a failed disk is left alone.
    fn begin(&mut self, now: Time) -> io::Result<()> {
        self.full_since = None;
        self.end()?;
        if !self.may_try() {
            return Ok(());
        }
        self.open()?;
        let complete_from = match (&self.checkpoint, self.latest) {
            // The next slot but one: the next may be made already.
            (Some(_), _) => self.grid.open(self.grid.of(now).plus(2 - self.latency_slots)),
            // The engine began with this datagram.
            (None, None) => self.grid.open(self.grid.of(now).plus(1 - self.latency_slots)),
            // The slots of the window are those of reports that were received in this file.
            (None, Some(latest)) => {
                let whole = latest.max(now) + DUPLICATES + self.max_future;
                self.grid.open(self.grid.of(whole).plus(1 + self.window_slots - self.latency_slots))
            }
        };
        // The first slot whose centre lies behind.
        let own = self.published.map(|until| self.grid.open(self.grid.of(until + self.grid.slot() / 2)));
        let complete_from = own.map_or(complete_from, |own| complete_from.max(own));
        // Who has had no point for longer than that is announced again with the next. Slots lag by less than a window.
        let lag_ns = self.window_slots * self.grid.slot().as_nanos() as i64;
        let flies = Time::from_nanos(now.nanos() - lag_ns) - NOTED;
        self.numbers.retain(|_, given| given.heard.is_none_or(|heard| heard >= flies));
        let numbers: Vec<Given> = self.numbers.values().copied().collect();
        self.segment = Some(Segment::begin(&Beginning {
            directory: &self.directory,
            began: now,
            complete_from,
            site: &self.site,
            numbers: &numbers,
            registration: &self.registration,
            held: &self.held,
            checkpoint: self.checkpoint.as_deref(),
            with_output: self.with_output,
        })?);
        // A trial that may fail again costs no recording.
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

    /// Whether the disk works, or has been left alone for long enough.
    #[expect(clippy::disallowed_methods, reason = "a failed disk is tried again by the clock of the machine")]
    fn may_try(&self) -> bool {
        self.retry.is_none_or(|retry| Instant::now() >= retry)
    }

    /// Takes the directory for this recorder alone, and gives the files that an earlier one left their names.
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

    /// Writes what waits; a failed disk is tried again, also where nothing comes.
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

    /// The disk has taken what waited.
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
            // The next files say from when on a replay equals what was sent.
            warn!(lost = lost - self.lost_told, since_start = lost, "the recorder did not keep up");
            self.lost_told = lost;
        }
    }

    /// Leaves the disk alone for a while; logged once, and again when it works.
    #[expect(clippy::disallowed_methods, reason = "a failed disk is tried again by the clock of the machine")]
    fn fail(&mut self, error: &io::Error) {
        let waited = self.segment.take().map_or(0, Segment::abandon);
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
