//! The service without its threads and sockets: its engine, its clock and its file, and what becomes of them.

use std::collections::BTreeMap;
use std::fs;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use fusion::numbering::{Given, NumberChange};
use fusion::time::Time;
use jiff::SignedDuration;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Feed};
use utm_fusion::formats::Encoders;
use utm_fusion::live::{Driver, Made};
use utm_fusion::pipeline::Event;
use utm_fusion::state::{Frame, StateHealth, Warm, WarmKeeper, WarmQueue};

use crate::book::{Book, Broken};

type Result<T> = std::result::Result<T, Broken>;

/// The name of the file in `[state] dir` that the engine goes on from.
const WARM: &str = "engine.warm";
/// Who sends everything.
const FROM: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 40_000);

/// What a slot was sent as, by its centre.
type Sent = BTreeMap<Time, Vec<Vec<u8>>>;

/// From a start of the service to its end.
struct Life {
    driver: Driver,
    encoders: Encoders,
    disk: Option<(WarmQueue, WarmKeeper)>,
    next_checkpoint: Time,
    /// Whether the file is its own, and not the one that it went on from.
    has_a_file: bool,
    /// Datagrams that it was handed, and those that it had counted before.
    offered: u64,
    counted: u64,
    /// How it began, what it has handled since, and what it has sent: a recording.
    began: (Bytes, Encoders),
    handled: Vec<Reception>,
    sent: Sent,
    /// Whether the clock has made it start afresh, which a recording cannot tell from a silence.
    is_afresh: bool,
}

/// A service that may be killed and started again.
pub struct Service {
    config: Arc<Config>,
    directory: PathBuf,
    life: Option<Life>,
    /// Numbers as the file of the state holds them.
    numbers: BTreeMap<u32, Given>,
    /// What it published.
    pub book: Book,
    /// Starts, and those of them that went on from the file.
    pub starts: (u64, u64),
    /// Slots that were made once more from what was handled, and are the same.
    pub replayed: u64,
}

impl Service {
    /// One that does not run yet, with an empty directory of its own.
    pub fn new(config: Arc<Config>, directory: &Path) -> Self {
        let _ = fs::remove_dir_all(directory);
        Self {
            book: Book::of(config.fusion.profile),
            config,
            directory: directory.to_owned(),
            life: None,
            numbers: BTreeMap::new(),
            starts: (0, 0),
            replayed: 0,
        }
    }

    fn lines(&self) -> usize {
        self.config.sensors.iter().map(|sensor| sensor.inputs.len()).sum()
    }

    /// Starts it, as `run` does.
    pub fn start(&mut self, now: Time) {
        let mut driver = Driver::new(&self.config, Masks::default(), now, self.lines());
        let mut encoders = Encoders::new(&self.config);
        let warm = Warm::load(&self.directory, now, self.config.fusion.window());
        let warm = warm.filter(|warm| driver.go_on(&self.config, Masks::default(), warm, now).is_ok());
        match &warm {
            Some(warm) => _ = encoders.go_on(&warm.encoders),
            None => {
                driver.remember(&mut self.numbers.values().copied().collect());
                if Warm::is_there(&self.directory) || !self.numbers.is_empty() {
                    driver.publish_after(now);
                }
            }
        }
        self.starts.0 += 1;
        self.starts.1 += u64::from(warm.is_some());
        self.life = Some(Life {
            counted: driver.pipeline().tally().received,
            began: (driver.checkpoint(&self.config), encoders.clone()),
            driver,
            encoders,
            disk: WarmKeeper::start(&self.directory, &StateHealth::default()).ok(),
            next_checkpoint: Time::default(),
            has_a_file: false,
            offered: 0,
            handled: Vec::new(),
            sent: Sent::new(),
            is_afresh: false,
        });
    }

    /// Whether it runs.
    pub fn runs(&self) -> bool {
        self.life.is_some()
    }

    /// When it makes the next slot, if it runs and has received anything.
    pub fn next_made(&self) -> Option<Time> {
        self.life.as_ref()?.driver.next_made()
    }

    /// Hands it a datagram.
    ///
    /// # Errors
    /// Something did not hold.
    pub fn receive(&mut self, line: usize, now: Time, payload: &[u8]) -> Result<()> {
        let Some(life) = &mut self.life else { return Ok(()) };
        let reception = Reception {
            received: Some(life.driver.reception(now, now)),
            input: line,
            from: Some(FROM),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: payload.to_vec(),
        };
        life.offered += 1;
        if let Some((queue, _)) = &mut life.disk {
            queue.offer(|| Frame::Input {
                received: reception.received.unwrap_or_default(),
                line,
                from: FROM,
                payload: reception.payload.clone(),
            });
        }
        life.driver.receive(&reception);
        life.handled.push(reception);
        self.hand_out()
    }

    /// Tells it the time.
    ///
    /// # Errors
    /// Something did not hold.
    pub fn tick(&mut self, now: Time) -> Result<()> {
        let Some(life) = &mut self.life else { return Ok(()) };
        life.driver.tick(now);
        self.hand_out()?;
        self.keep(now, false);
        Ok(())
    }

    fn keep(&mut self, now: Time, is_end: bool) {
        let Some(life) = &mut self.life else { return };
        let period = SignedDuration::from_secs_f64(self.config.state.checkpoint_s);
        let is_due = is_end || now >= life.next_checkpoint || life.next_checkpoint - now > period;
        let Some((queue, _)) = life.disk.as_mut().filter(|_| is_due) else { return };
        if life.driver.next_made().is_none() {
            return;
        }
        let engine = life.driver.checkpoint(&self.config);
        let (encoders, published) = (life.encoders.checkpoint().into(), life.driver.published());
        if queue.begin(Frame::Checkpoint { at: now, engine, encoders, published }) {
            life.next_checkpoint = now + period;
            life.has_a_file = true;
        }
    }

    /// Takes what the driver has made.
    fn hand_out(&mut self) -> Result<()> {
        let Some(life) = &mut self.life else { return Ok(()) };
        while let Some(made) = life.driver.poll() {
            match made {
                Made::Slot(frame) => {
                    let picture = &frame.picture;
                    self.book.note(picture)?;
                    let within = picture.within(self.config.output.max_accuracy_m);
                    let sent = life.encoders.picture(Feed::RECORDED, picture.time, within);
                    life.sent.insert(picture.time, sent);
                }
                Made::Number(NumberChange::Heard(given)) => {
                    self.book.numbered(&given)?;
                    self.numbers.insert(given.number, given);
                }
                Made::Number(NumberChange::Returned(given)) => _ = self.numbers.remove(&given.number),
                Made::Event(Event::Restarted) => life.is_afresh = true,
                Made::Event(_) => {}
            }
        }
        Ok(())
    }

    /// The disk takes nothing, and what was there is gone; or takes it again.
    pub fn disk(&mut self, is_well: bool) {
        let Some(life) = &mut self.life else { return };
        if is_well {
            if life.disk.is_none() {
                life.disk = WarmKeeper::start(&self.directory, &StateHealth::default()).ok();
                life.next_checkpoint = Time::default();
            }
        } else if let Some((queue, keeper)) = life.disk.take() {
            drop(queue);
            keeper.join();
            life.has_a_file = false;
            let _ = fs::remove_file(self.directory.join(WARM));
        }
    }

    /// Stops it in order.
    ///
    /// # Errors
    /// Something did not hold.
    pub fn stop(&mut self, now: Time) -> Result<()> {
        self.keep(now, true);
        let Some(life) = &mut self.life else { return Ok(()) };
        if self.config.output.flush_on_stop {
            life.driver.finish();
            self.hand_out()?;
        }
        let Some(life) = &mut self.life else { return Ok(()) };
        if let (Some(until), Some((queue, _))) = (life.driver.published(), &life.disk) {
            queue.end(Frame::Published(until));
        }
        self.end()
    }

    /// Kills it; what it has written itself may be damaged then.
    ///
    /// # Errors
    /// Something had not held.
    pub fn kill(&mut self, damage: Option<&mut ChaCha8Rng>) -> Result<()> {
        let Some(life) = &self.life else { return Ok(()) };
        let damage = damage.filter(|_| life.has_a_file);
        self.end()?;
        let file = self.directory.join(WARM);
        let (Some(random), Ok(mut octets)) = (damage, fs::read(&file)) else { return Ok(()) };
        if octets.is_empty() {
            return Ok(());
        }
        let place = random.random_range(0..octets.len());
        if random.random_bool(0.5) {
            octets.truncate(place);
        } else {
            octets[place] ^= 1 << random.random_range(0..8);
        }
        fs::write(&file, octets).map_err(|error| Broken(format!("{}: {error}", file.display())))
    }

    /// The end of a life: was everything counted, and is a recording of it the same?
    fn end(&mut self) -> Result<()> {
        let Some(life) = self.life.take() else { return Ok(()) };
        if let Some((queue, keeper)) = life.disk {
            drop(queue);
            keeper.join();
        }
        let counted = life.driver.pipeline().tally().received - life.counted;
        if counted != life.offered {
            return Err(Broken(format!("{} datagrams came, {counted} were counted", life.offered)));
        }
        if life.is_afresh {
            return Ok(());
        }
        let (state, mut encoders) = life.began;
        let mut again = Driver::new(&self.config, Masks::default(), Time::default(), self.lines());
        again.restore(&self.config, Masks::default(), &state).map_err(|error| Broken(error.to_string()))?;
        for reception in &life.handled {
            again.receive(reception);
            while let Some(made) = again.poll() {
                let Made::Slot(frame) = made else { continue };
                let picture = &frame.picture;
                let within = picture.within(self.config.output.max_accuracy_m);
                let sent = encoders.picture(Feed::RECORDED, picture.time, within);
                if let Some(published) = life.sent.get(&picture.time) {
                    if *published != sent {
                        return Err(Broken(format!("slot {} replays to another one", picture.time)));
                    }
                    self.replayed += 1;
                }
            }
        }
        Ok(())
    }
}
