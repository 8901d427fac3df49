//! The state from which a service goes on after a restart: `engine.warm`, a checkpoint and what was received since.
//!
//! The file is a row of frames, each the length of its contents (4 octets, little endian), the first 8 octets of their SHA-256,
//! and the contents. The first frame is a checkpoint; the next checkpoint begins the file anew. A frame that is not whole, which
//! a crash leaves at the end, ends it.

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
use crate::capture::{Reception, ReceptionKind};
use crate::live::now;
use fusion::time::Time;

/// The file's name in the directory of `[state]`.
const NAME: &str = "engine.warm";
/// Description of its contents, for people.
const CONTENTS: &str = "state of the engine";
/// Its name while its checkpoint is written.
const PART: &str = "engine.warm.part";
/// Frames that may wait for the disk: some seconds of the busiest site.
const QUEUE: usize = 16_384;

/// A frame of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Frame {
    /// The state.
    Checkpoint {
        /// When it was written.
        at: Time,
        /// Of the encoders.
        encoders: Bytes,
        /// Slots up to this centre are published, or an earlier service's.
        published: Option<Time>,
        /// Of the engine ([`EngineState`](super::EngineState)). It is the last, so that it can be written from where it is.
        engine: Bytes,
    },
    /// A datagram that was handled since, without its trailer.
    Input {
        /// The time at which it was handled.
        received: Time,
        /// Its line.
        line: usize,
        /// Its sender.
        from: std::net::SocketAddr,
        /// Its octets.
        payload: Vec<u8>,
    },
    /// On stopping slots were published ahead, up to the one of this centre.
    Published(Time),
}

/// What a service goes on from.
#[derive(Debug)]
pub struct Warm {
    /// Of the engine ([`EngineState`](super::EngineState)).
    pub engine: Bytes,
    /// Of the encoders.
    pub encoders: Bytes,
    /// What was handled since, in order.
    pub inputs: Vec<Reception>,
    /// Slots up to this centre are published.
    pub published: Option<Time>,
    /// When it ends.
    pub until: Time,
}

impl Warm {
    /// What the file in `directory` holds, where it is no older than `oldest`; `None`: nothing of use.
    pub fn load(directory: &Path, now: Time, oldest: SignedDuration) -> Option<Self> {
        Self::restore(directory, now, oldest, &StateHealth::default())
    }

    /// The same; a damaged file is set aside and noted. One that a crash has cut short is not damaged.
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
            info!(age_s, "state of the engine is too old to go on from: begun anew");
            return None;
        }
        Some(warm)
    }

    /// Whether an earlier service has left a state in `directory`, of use or not.
    pub fn is_there(directory: &Path) -> bool {
        directory.join(NAME).exists()
    }

    fn of(octets: &[u8]) -> Option<Self> {
        let mut frames = Frames(octets);
        let Some(Frame::Checkpoint { at, encoders, published, engine }) = frames.next() else { return None };
        let mut warm = Self { engine, encoders, inputs: Vec::new(), published, until: at };
        for frame in frames {
            match frame {
                Frame::Input { received, line, from, payload } => {
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
                Frame::Published(until) => warm.published = Some(until),
                // It would begin another file.
                Frame::Checkpoint { .. } => return None,
            }
        }
        Some(warm)
    }
}

/// The whole frames of a file.
struct Frames<'a>(&'a [u8]);

impl Iterator for Frames<'_> {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
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

fn write_frame(file: &mut impl Write, frame: &Frame) -> io::Result<()> {
    let (head, engine) = match frame {
        Frame::Checkpoint { at, encoders, published, engine } => {
            let encoders = encoders.clone();
            let bare = Frame::Checkpoint { at: *at, encoders, published: *published, engine: Bytes::new() };
            let mut head = postcard::to_stdvec(&bare).map_err(io::Error::other)?;
            // The length of nothing.
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

/// Where the engine's thread hands its state. It never waits.
#[derive(Debug)]
pub struct WarmQueue {
    frames: SyncSender<Frame>,
    /// Something did not fit: until the next checkpoint nothing more is of use.
    is_broken: bool,
}

impl WarmQueue {
    /// To a test, and not to a file.
    #[cfg(test)]
    pub(crate) fn to(frames: SyncSender<Frame>) -> Self {
        Self { frames, is_broken: true }
    }

    /// Hands over a frame; one that does not fit is lost, with what would follow it.
    pub fn offer(&mut self, frame: impl FnOnce() -> Frame) {
        if self.is_broken {
            return;
        }
        if let Err(TrySendError::Full(_)) = self.frames.try_send(frame()) {
            self.is_broken = true;
            warn!("the disk is slower than the inputs: a restart now would go on from an older state");
        }
    }

    /// Hands over a checkpoint, behind which frames count again; whether there was room.
    pub fn begin(&mut self, checkpoint: Frame) -> bool {
        let has_room = self.frames.try_send(checkpoint).is_ok();
        self.is_broken &= !has_room;
        has_room
    }

    /// Hands over the last frames, and waits for room.
    pub fn end(&self, frame: Frame) {
        // Where the thread has ended nobody goes on from it.
        let _ = self.frames.send(frame);
    }
}

/// The thread that writes the file; it ends when its queue is gone.
#[derive(Debug)]
pub struct WarmKeeper(JoinHandle<()>);

impl WarmKeeper {
    /// Starts it, in this directory; whether the file can be written is noted in `health`.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(directory: &Path, health: &StateHealth) -> io::Result<(WarmQueue, Self)> {
        let (sender, frames) = mpsc::sync_channel(QUEUE);
        let (directory, health) = (directory.to_owned(), health.clone());
        let writer = Writer { directory, file: None, health, is_ahead: false };
        let thread = std::thread::Builder::new()
            .name("engine state".to_owned())
            .spawn(move || writer.follow(&frames))?;
        Ok((WarmQueue { frames: sender, is_broken: true }, Self(thread)))
    }

    /// Waits until everything is written; the queue must be gone.
    pub fn join(self) {
        if self.0.join().is_err() {
            error!("the thread of the engine's state panicked: this is a bug");
        }
    }
}

struct Writer {
    directory: PathBuf,
    /// `None`: nothing is of use until the next checkpoint.
    file: Option<BufWriter<File>>,
    health: StateHealth,
    /// The last frame says what was published ahead.
    is_ahead: bool,
}

impl Writer {
    fn follow(mut self, frames: &Receiver<Frame>) {
        while let Ok(frame) = frames.recv() {
            self.take(&frame);
            let ended = loop {
                match frames.try_recv() {
                    Ok(frame) => self.take(&frame),
                    Err(error) => break error == TryRecvError::Disconnected,
                }
            };
            // What nobody waits to follow is safe from a crash of the process.
            let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
            self.note(flushed);
            if ended {
                break;
            }
        }
        let synced = self.file.as_ref().map_or(Ok(()), |file| file.get_ref().sync_all());
        self.note(synced);
        if self.is_ahead && self.file.is_none() {
            // Whoever went on from what is there would publish again what it does not know of.
            let _ = fs::remove_file(self.directory.join(NAME));
        }
    }

    fn take(&mut self, frame: &Frame) {
        let written = match frame {
            Frame::Checkpoint { .. } => self.begin(frame),
            _ => self.file.as_mut().map_or(Ok(()), |file| write_frame(file, frame)),
        };
        self.note(written);
        self.is_ahead = matches!(frame, Frame::Published(_));
    }

    /// Begins the file anew: until the checkpoint is on the disk the one before stays.
    fn begin(&mut self, checkpoint: &Frame) -> io::Result<()> {
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

    fn checkpoint(second: i64) -> Frame {
        Frame::Checkpoint {
            at: at(second),
            engine: vec![second as u8; 9].into(),
            encoders: vec![7].into(),
            published: Some(at(second - 6)),
        }
    }

    fn input(second: i64) -> Frame {
        let from = "127.0.0.1:5000".parse().unwrap();
        Frame::Input { received: at(second), line: 1, from, payload: vec![second as u8; 40] }
    }

    const OLDEST: SignedDuration = SignedDuration::from_secs(25);

    #[test]
    fn what_was_handled_since_the_last_checkpoint_comes_back() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-warm-{}", std::process::id()));
        assert!(Warm::load(&directory, at(0), OLDEST).is_none());
        let (mut queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        queue.offer(|| unreachable!("nothing is of use before the first checkpoint"));
        assert!(queue.begin(checkpoint(0)));
        queue.offer(|| input(1));
        assert!(queue.begin(checkpoint(2)));
        queue.offer(|| input(3));
        queue.offer(|| input(5));
        queue.end(Frame::Published(at(4)));
        drop(queue);
        keeper.join();
        let warm = Warm::load(&directory, at(20), OLDEST).unwrap();
        assert_eq!((&warm.engine[..], &warm.encoders[..]), (&[2; 9][..], &[7][..]));
        assert_eq!((warm.published, warm.until), (Some(at(4)), at(5)));
        let received: Vec<_> = warm.inputs.iter().map(|input| (input.received, input.payload[0])).collect();
        assert_eq!(received, [(Some(at(3)), 3), (Some(at(5)), 5)]);
        // Too old, and of a clock that has been set back since.
        assert!(Warm::load(&directory, at(31), OLDEST).is_none());
        assert!(Warm::load(&directory, at(4), OLDEST).is_none());
        fs::remove_dir_all(&directory).unwrap();
    }

    /// A disk that is full when the service stops must not leave a state that knows nothing of what was published ahead.
    #[test]
    fn what_was_published_ahead_is_known_or_nobody_goes_on() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-warm-full-{}", std::process::id()));
        let (mut queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        assert!(queue.begin(checkpoint(0)));
        queue.offer(|| input(1));
        drop(queue);
        keeper.join();
        assert!(Warm::load(&directory, at(2), OLDEST).is_some());
        // A directory of the part's name: no checkpoint can be written, the earlier state stays.
        fs::create_dir(directory.join(PART)).unwrap();
        let (queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        queue.end(checkpoint(3));
        queue.end(Frame::Published(at(4)));
        drop(queue);
        keeper.join();
        assert!(!Warm::is_there(&directory));
        fs::remove_dir_all(&directory).unwrap();
    }

    /// Whatever a crash has left: what is whole in front counts, and nothing else.
    #[test]
    fn a_file_may_end_anywhere() {
        let mut octets = Vec::new();
        let mut ends = Vec::new();
        for frame in [checkpoint(0), input(1), input(2)] {
            write_frame(&mut octets, &frame).unwrap();
            ends.push(octets.len());
        }
        for cut in 0..=octets.len() {
            let warm = Warm::of(&octets[..cut]);
            assert!(warm.as_ref().is_none_or(|warm| warm.published == Some(at(-6))));
            let inputs = warm.map(|warm| warm.inputs.len());
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            assert_eq!(inputs, whole.checked_sub(1), "{cut}");
        }
        for place in 0..octets.len() {
            let mut damaged = octets.clone();
            damaged[place] ^= 0x10;
            let inputs = Warm::of(&damaged).map(|warm| warm.inputs.len());
            let whole = ends.iter().filter(|&&end| end <= place).count();
            assert_eq!(inputs, whole.checked_sub(1), "{place}");
        }
    }
}
