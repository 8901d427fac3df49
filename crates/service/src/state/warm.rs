//! State from which a service resumes after a restart: `engine.warm`, a checkpoint and the data received since.
//!
//! The file is a sequence of frames. Each has the length of its contents (4 octets, little endian), the first 8 octets of
//! their SHA-256, and the contents. The first frame is a checkpoint; the next checkpoint starts a new file. An incomplete
//! frame, as a crash leaves it, ends the file.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, SyncSender, TryRecvError, TrySendError};
use std::thread::JoinHandle;

use bytes::Bytes;
use jiff::SignedDuration;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tracing::{error, info, warn};

use super::StateHealth;
use crate::clock::now;
use fusion::time::Time;
use input::capture::{Reception, ReceptionKind};

/// Name of the file in the directory of `[state]`.
const NAME: &str = "engine.warm";
/// Description of the contents for the log.
const CONTENTS: &str = "state of the engine";
/// Name of the file while its checkpoint is written.
const PART: &str = "engine.warm.part";
/// Maximum number of frames waiting for the disk: some seconds at the busiest site.
const QUEUE: usize = 16_384;

/// A frame of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum WarmFrame {
    /// The state.
    Checkpoint {
        /// Time of writing.
        at: Time,
        /// State of the encoders.
        encoders: Bytes,
        /// Slots up to this centre were published by this run, or left to an earlier one.
        published: Option<Time>,
        /// State of the engine ([`EngineState`](super::EngineState)); the last field, so that it is written without a copy.
        engine: Bytes,
    },
    /// A datagram handled since, without its trailer.
    Input {
        /// Time of handling.
        received: Time,
        /// Index of its line.
        line: usize,
        /// Sender.
        from: std::net::SocketAddr,
        /// Payload of the datagram.
        payload: Vec<u8>,
    },
    /// At the stop, slots up to this centre were published early.
    Published(Time),
}

/// State from which a service resumes.
#[derive(Debug)]
pub struct WarmState {
    /// State of the engine ([`EngineState`](super::EngineState)).
    pub engine: Bytes,
    /// State of the encoders.
    pub encoders: Bytes,
    /// Datagrams handled since, in order.
    pub inputs: Vec<Reception>,
    /// Slots up to this centre are published.
    pub published: Option<Time>,
    /// Time of the last data in the state.
    pub until: Time,
}

impl WarmState {
    /// State in `directory`, if it is no older than `oldest`; `None` if there is no usable one.
    pub fn load(directory: &Path, now: Time, oldest: SignedDuration) -> Option<Self> {
        Self::restore(directory, now, oldest, &StateHealth::default())
    }

    /// Like [`WarmState::load`], but sets a damaged file aside and records it in `health`. A file that a crash cut short is not
    /// damaged.
    pub fn restore(
        directory: &Path,
        now: Time,
        oldest: SignedDuration,
        health: &StateHealth,
    ) -> Option<Self> {
        health.clear_obstacles(directory, NAME, CONTENTS, now);
        let path = directory.join(NAME);
        let read = match fs::metadata(&path) {
            Ok(metadata) if !metadata.is_file() => Err(io::Error::other("it is no file")),
            Ok(_) => fs::read(&path),
            Err(error) => Err(error),
        };
        let warm = match read {
            Ok(octets) => {
                Self::of(&octets).ok_or_else(|| "it does not begin with a whole checkpoint".to_owned())
            }
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            Err(error) => Err(error.to_string()),
        };
        let warm = match warm {
            Ok(warm) => warm,
            Err(error) => {
                health.set_aside(directory, NAME, CONTENTS, &error, now);
                return None;
            }
        };
        let age = now - warm.until;
        if age > oldest || age < SignedDuration::ZERO {
            let age_s = age.as_secs();
            info!(age_s, "engine state discarded: older than the window");
            return None;
        }
        Some(warm)
    }

    /// Whether an earlier run has left a state in `directory`, usable or not.
    pub fn is_there(directory: &Path) -> bool {
        directory.join(NAME).exists()
    }

    fn of(octets: &[u8]) -> Option<Self> {
        let mut frames = WarmFrames(octets);
        let Some(WarmFrame::Checkpoint { at, encoders, published, engine }) = frames.next() else {
            return None;
        };
        let mut warm = Self { engine, encoders, inputs: Vec::new(), published, until: at };
        for frame in frames {
            match frame {
                WarmFrame::Input { received, line, from, payload } => {
                    warm.until = warm.until.max(received);
                    warm.inputs.push(Reception {
                        received: Some(received),
                        input: line,
                        from: Some(from),
                        kind: ReceptionKind::Datagram,
                        origin: 0,
                        payload,
                    });
                }
                WarmFrame::Published(until) => warm.published = Some(until),
                // A further checkpoint would have started a new file.
                WarmFrame::Checkpoint { .. } => return None,
            }
        }
        Some(warm)
    }
}

/// Iterates over the whole frames of a file.
struct WarmFrames<'a>(&'a [u8]);

impl Iterator for WarmFrames<'_> {
    type Item = WarmFrame;

    fn next(&mut self) -> Option<WarmFrame> {
        let (length, rest) = self.0.split_first_chunk::<4>()?;
        let (hash, rest) = rest.split_first_chunk::<8>()?;
        let (contents, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        if *hash != hash_of([contents, &[]]) {
            return None;
        }
        self.0 = rest;
        postcard::from_bytes(contents).ok()
    }
}

fn hash_of(parts: [&[u8]; 2]) -> [u8; 8] {
    let hash = parts.iter().fold(Sha256::new(), Sha256::chain_update).finalize();
    *hash.first_chunk().expect("32 octets")
}

fn write_frame(file: &mut impl Write, frame: &WarmFrame) -> io::Result<()> {
    let (head, engine) = match frame {
        WarmFrame::Checkpoint { at, encoders, published, engine } => {
            let encoders = encoders.clone();
            let bare =
                WarmFrame::Checkpoint { at: *at, encoders, published: *published, engine: Bytes::new() };
            let mut head = postcard::to_stdvec(&bare).map_err(io::Error::other)?;
            // Removes the encoded length of the empty state.
            head.pop();
            (postcard::to_extend(&engine.len(), head).map_err(io::Error::other)?, &engine[..])
        }
        _ => (postcard::to_stdvec(frame).map_err(io::Error::other)?, &[][..]),
    };
    let length = u32::try_from(head.len() + engine.len());
    let length = length.map_err(|_| io::Error::other("a state of more than 4 GiB"))?;
    file.write_all(&length.to_le_bytes())?;
    file.write_all(&hash_of([&head, engine]))?;
    file.write_all(&head)?;
    file.write_all(engine)
}

/// The engine's end of the queue to the keeper. It never waits.
#[derive(Debug)]
pub struct WarmQueue {
    frames: SyncSender<WarmFrame>,
    /// A frame was lost: no frame is usable until the next checkpoint.
    is_broken: bool,
}

impl WarmQueue {
    /// Queue to a test instead of a file.
    #[cfg(test)]
    pub fn to(frames: SyncSender<WarmFrame>) -> Self {
        Self { frames, is_broken: true }
    }

    /// Adds a frame. If the queue is full it is lost, and with it the following ones.
    pub fn offer(&mut self, frame: impl FnOnce() -> WarmFrame) {
        if self.is_broken {
            return;
        }
        if let Err(TrySendError::Full(_)) = self.frames.try_send(frame()) {
            self.is_broken = true;
            warn!("the disk is slower than the inputs: a restart now would go on from an older state");
        }
    }

    /// Adds a checkpoint, after which frames are usable again; returns whether there was space.
    pub fn begin(&mut self, checkpoint: WarmFrame) -> bool {
        let has_room = self.frames.try_send(checkpoint).is_ok();
        self.is_broken &= !has_room;
        has_room
    }

    /// Adds the last frames; waits for space.
    pub fn end(&self, frame: WarmFrame) {
        // Fails only if the thread has ended, and then no state is left.
        let _ = self.frames.send(frame);
    }
}

/// The thread that writes the file; it ends when its queue is dropped.
#[derive(Debug)]
pub struct WarmKeeper(JoinHandle<()>);

impl WarmKeeper {
    /// Starts the thread for this directory. Failures to write are recorded in `health`.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(directory: &Path, health: &StateHealth) -> io::Result<(WarmQueue, Self)> {
        let (sender, frames) = mpsc::sync_channel(QUEUE);
        let (directory, health) = (directory.to_owned(), health.clone());
        let writer = WarmWriter { directory, file: None, health, is_ahead: false };
        let thread = std::thread::Builder::new()
            .name("engine state".to_owned())
            .spawn(move || writer.follow(&frames))?;
        Ok((WarmQueue { frames: sender, is_broken: true }, Self(thread)))
    }

    /// Waits until everything is written; the queue must have been dropped.
    pub fn join(self) {
        if self.0.join().is_err() {
            error!("the thread of the engine's state panicked: this is a bug");
        }
    }
}

struct WarmWriter {
    directory: PathBuf,
    /// `None`: no frame is usable until the next checkpoint.
    file: Option<BufWriter<File>>,
    health: StateHealth,
    /// Whether the last frame was [`WarmFrame::Published`].
    is_ahead: bool,
}

impl WarmWriter {
    fn follow(mut self, frames: &Receiver<WarmFrame>) {
        while let Ok(frame) = frames.recv() {
            self.take(&frame);
            let ended = loop {
                match frames.try_recv() {
                    Ok(frame) => self.take(&frame),
                    Err(error) => break error == TryRecvError::Disconnected,
                }
            };
            // Once the queue is empty, the data is flushed, and survives a crash of the process.
            let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
            self.note(flushed);
            if ended {
                break;
            }
        }
        let synced = self.file.as_ref().map_or(Ok(()), |file| file.get_ref().sync_all());
        self.note(synced);
        if self.is_ahead && self.file.is_none() {
            // A service that resumed from this file would publish the same slots again.
            let _ = fs::remove_file(self.directory.join(NAME));
        }
    }

    fn take(&mut self, frame: &WarmFrame) {
        let written = match frame {
            WarmFrame::Checkpoint { .. } => self.begin(frame),
            _ => self.file.as_mut().map_or(Ok(()), |file| write_frame(file, frame)),
        };
        self.note(written);
        self.is_ahead = matches!(frame, WarmFrame::Published(_));
    }

    /// Starts a new file. Until its checkpoint is on the disk the old file stays.
    fn begin(&mut self, checkpoint: &WarmFrame) -> io::Result<()> {
        self.file = None;
        fs::create_dir_all(&self.directory)?;
        let part = self.directory.join(PART);
        #[expect(clippy::disallowed_methods, reason = "the state is a file")]
        let mut file = BufWriter::new(File::create(&part)?);
        write_frame(&mut file, checkpoint)?;
        file.flush()?;
        file.get_ref().sync_data()?;
        fs::rename(&part, self.directory.join(NAME))?;
        self.file = Some(file);
        if self.health.note_success(NAME) {
            info!(file = NAME, "state of the engine is written again");
        }
        Ok(())
    }

    fn note(&mut self, result: io::Result<()>) {
        if let Err(error) = result {
            self.file = None;
            if self.health.note_failure(NAME, &error) {
                warn!(file = NAME, %error, "state of the engine cannot be written: tried again");
            }
            self.health.clear_obstacles(&self.directory, NAME, CONTENTS, now());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::time::SECOND;

    fn at(second: i64) -> Time {
        Time::from_nanos((1_795_168_800 + second) * SECOND)
    }

    fn checkpoint(second: i64) -> WarmFrame {
        WarmFrame::Checkpoint {
            at: at(second),
            engine: vec![second as u8; 9].into(),
            encoders: vec![7].into(),
            published: Some(at(second - 6)),
        }
    }

    fn input(second: i64) -> WarmFrame {
        let from = "127.0.0.1:5000".parse().unwrap();
        WarmFrame::Input { received: at(second), line: 1, from, payload: vec![second as u8; 40] }
    }

    const OLDEST: SignedDuration = SignedDuration::from_secs(25);

    #[test]
    fn inputs_after_the_last_checkpoint_are_restored() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-warm-{}", std::process::id()));
        assert!(WarmState::load(&directory, at(0), OLDEST).is_none());
        let (mut queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        queue.offer(|| unreachable!("nothing is of use before the first checkpoint"));
        assert!(queue.begin(checkpoint(0)));
        queue.offer(|| input(1));
        assert!(queue.begin(checkpoint(2)));
        queue.offer(|| input(3));
        queue.offer(|| input(5));
        queue.end(WarmFrame::Published(at(4)));
        drop(queue);
        keeper.join();
        let warm = WarmState::load(&directory, at(20), OLDEST).unwrap();
        assert_eq!((&warm.engine[..], &warm.encoders[..]), (&[2; 9][..], &[7][..]));
        assert_eq!((warm.published, warm.until), (Some(at(4)), at(5)));
        let received: Vec<_> = warm.inputs.iter().map(|input| (input.received, input.payload[0])).collect();
        assert_eq!(received, [(Some(at(3)), 3), (Some(at(5)), 5)]);
        // Too old, and from a clock that was set back since.
        assert!(WarmState::load(&directory, at(31), OLDEST).is_none());
        assert!(WarmState::load(&directory, at(4), OLDEST).is_none());
        fs::remove_dir_all(&directory).unwrap();
    }

    /// A disk that is full when the service stops must not leave a state that misses the slots published early.
    #[test]
    fn state_without_its_published_mark_is_not_resumed() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-warm-full-{}", std::process::id()));
        let (mut queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        assert!(queue.begin(checkpoint(0)));
        queue.offer(|| input(1));
        drop(queue);
        keeper.join();
        assert!(WarmState::load(&directory, at(2), OLDEST).is_some());
        // A directory with the part's name: no checkpoint can be written, and the earlier state stays.
        fs::create_dir(directory.join(PART)).unwrap();
        let (queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        queue.end(checkpoint(3));
        queue.end(WarmFrame::Published(at(4)));
        drop(queue);
        keeper.join();
        assert!(!WarmState::is_there(&directory));
        fs::remove_dir_all(&directory).unwrap();
    }

    /// After a crash, exactly the whole frames at the beginning are used.
    #[test]
    fn file_truncated_anywhere_is_readable() {
        let mut octets = Vec::new();
        let mut ends = Vec::new();
        for frame in [checkpoint(0), input(1), input(2)] {
            write_frame(&mut octets, &frame).unwrap();
            ends.push(octets.len());
        }
        for cut in 0..=octets.len() {
            let warm = WarmState::of(&octets[..cut]);
            assert!(warm.as_ref().is_none_or(|warm| warm.published == Some(at(-6))));
            let inputs = warm.map(|warm| warm.inputs.len());
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            assert_eq!(inputs, whole.checked_sub(1), "{cut}");
        }
        for place in 0..octets.len() {
            let mut damaged = octets.clone();
            damaged[place] ^= 0x10;
            let inputs = WarmState::of(&damaged).map(|warm| warm.inputs.len());
            let whole = ends.iter().filter(|&&end| end <= place).count();
            assert_eq!(inputs, whole.checked_sub(1), "{place}");
        }
    }
}
