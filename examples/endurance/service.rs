//! The service without its threads and sockets: engine, clock, and checkpoint file.

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
use utm_fusion::live::{Driver, DriverEvent};
use utm_fusion::pipeline::Event;
use utm_fusion::state::{StateHealth, WarmFrame, WarmKeeper, WarmQueue, WarmState};

use crate::picture_log::{PictureLog, Violation};

type CheckResult<T> = Result<T, Violation>;

/// Name of the engine's checkpoint in `[state] dir`.
const WARM: &str = "engine.warm";
/// Source address of all datagrams.
const FROM: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 40_000);

/// Datagrams sent for each slot, by its centre.
type SentBySlot = BTreeMap<Time, Vec<Vec<u8>>>;

/// One run of the service, from start to end.
struct ServiceRun {
    driver: Driver,
    encoders: Encoders,
    disk: Option<(WarmQueue, WarmKeeper)>,
    next_checkpoint: Time,
    /// Whether this run has written a checkpoint; otherwise the file is the one that it was restored from.
    has_a_file: bool,
    /// Number of datagrams passed to this run. `counted` is the number that its counters had at the start.
    offered: u64,
    counted: u64,
    /// Checkpoint at the start and the encoders; then the datagrams handled since and sent since. Together these are a
    /// recording.
    began: (Bytes, Encoders),
    handled: Vec<Reception>,
    sent: SentBySlot,
    /// Whether a change of the clock made the engine start afresh, which a recording cannot distinguish from a silence.
    is_afresh: bool,
}

/// A service that can be killed and started again.
pub struct CheckedService {
    config: Arc<Config>,
    directory: PathBuf,
    run: Option<ServiceRun>,
    /// Numbers as the state file holds them.
    numbers: BTreeMap<u32, Given>,
    /// Published pictures.
    pub picture_log: PictureLog,
    /// Number of starts, and of starts with a restored checkpoint.
    pub starts: (u64, u64),
    /// Number of slots that a replay reproduced identically.
    pub replayed: u64,
}

impl CheckedService {
    /// A service that is not yet running, with an empty directory.
    pub fn new(config: Arc<Config>, directory: &Path) -> Self {
        let _ = fs::remove_dir_all(directory);
        Self {
            picture_log: PictureLog::of(config.fusion.profile),
            config,
            directory: directory.to_owned(),
            run: None,
            numbers: BTreeMap::new(),
            starts: (0, 0),
            replayed: 0,
        }
    }

    fn lines(&self) -> usize {
        self.config.sensors.iter().map(|sensor| sensor.inputs.len()).sum()
    }

    /// Starts the service, as `run` does.
    pub fn start(&mut self, now: Time) {
        let mut driver = Driver::new(&self.config, Masks::default(), now, self.lines());
        let mut encoders = Encoders::new(&self.config);
        let warm = WarmState::load(&self.directory, now, self.config.fusion.window());
        let warm = warm.filter(|warm| driver.resume(&self.config, Masks::default(), warm, now).is_ok());
        match &warm {
            Some(warm) => _ = encoders.resume(&warm.encoders),
            None => {
                driver.remember(&mut self.numbers.values().copied().collect());
                if WarmState::is_there(&self.directory) || !self.numbers.is_empty() {
                    driver.publish_after(now);
                }
            }
        }
        self.starts.0 += 1;
        self.starts.1 += u64::from(warm.is_some());
        self.run = Some(ServiceRun {
            counted: driver.pipeline().tally().received,
            began: (driver.checkpoint(&self.config), encoders.clone()),
            driver,
            encoders,
            disk: WarmKeeper::start(&self.directory, &StateHealth::default()).ok(),
            next_checkpoint: Time::default(),
            has_a_file: false,
            offered: 0,
            handled: Vec::new(),
            sent: SentBySlot::new(),
            is_afresh: false,
        });
    }

    /// Whether the service runs.
    pub fn runs(&self) -> bool {
        self.run.is_some()
    }

    /// Time of the next slot, if the service runs and has received anything.
    pub fn next_made(&self) -> Option<Time> {
        self.run.as_ref()?.driver.next_made()
    }

    /// Passes a datagram to the service.
    ///
    /// # Errors
    /// A condition was violated.
    pub fn receive(&mut self, line: usize, now: Time, payload: &[u8]) -> CheckResult<()> {
        let Some(run) = &mut self.run else { return Ok(()) };
        let reception = Reception {
            received: Some(run.driver.reception(now, now)),
            input: line,
            from: Some(FROM),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: payload.to_vec(),
        };
        run.offered += 1;
        if let Some((queue, _)) = &mut run.disk {
            queue.offer(|| WarmFrame::Input {
                received: reception.received.unwrap_or_default(),
                line,
                from: FROM,
                payload: reception.payload.clone(),
            });
        }
        run.driver.receive(&reception);
        run.handled.push(reception);
        self.hand_out()
    }

    /// Passes the current time to the service.
    ///
    /// # Errors
    /// A condition was violated.
    pub fn tick(&mut self, now: Time) -> CheckResult<()> {
        let Some(run) = &mut self.run else { return Ok(()) };
        run.driver.tick(now);
        self.hand_out()?;
        self.keep(now, false);
        Ok(())
    }

    fn keep(&mut self, now: Time, is_end: bool) {
        let Some(run) = &mut self.run else { return };
        let period = SignedDuration::from_secs_f64(self.config.state.checkpoint_s);
        let is_due = is_end || now >= run.next_checkpoint || run.next_checkpoint - now > period;
        let Some((queue, _)) = run.disk.as_mut().filter(|_| is_due) else { return };
        if run.driver.next_made().is_none() {
            return;
        }
        let engine = run.driver.checkpoint(&self.config);
        let (encoders, published) = (run.encoders.checkpoint().into(), run.driver.published());
        if queue.begin(WarmFrame::Checkpoint { at: now, engine, encoders, published }) {
            run.next_checkpoint = now + period;
            run.has_a_file = true;
        }
    }

    /// Takes the output of the driver.
    fn hand_out(&mut self) -> CheckResult<()> {
        let Some(run) = &mut self.run else { return Ok(()) };
        while let Some(made) = run.driver.poll() {
            match made {
                DriverEvent::Slot(frame) => {
                    let picture = &frame.picture;
                    self.picture_log.note(picture)?;
                    let within = picture.within(self.config.output.max_accuracy_m);
                    let sent = run.encoders.picture(Feed::RECORDED, picture.time, within);
                    run.sent.insert(picture.time, sent);
                }
                DriverEvent::Number(NumberChange::Heard(given)) => {
                    self.picture_log.numbered(&given)?;
                    self.numbers.insert(given.number, given);
                }
                DriverEvent::Number(NumberChange::Returned(given)) => _ = self.numbers.remove(&given.number),
                DriverEvent::Event(Event::Restarted) => run.is_afresh = true,
                DriverEvent::Event(_) => {}
            }
        }
        Ok(())
    }

    /// Makes the disk fail, with loss of the checkpoint, or work again.
    pub fn disk(&mut self, is_well: bool) {
        let Some(run) = &mut self.run else { return };
        if is_well {
            if run.disk.is_none() {
                run.disk = WarmKeeper::start(&self.directory, &StateHealth::default()).ok();
                run.next_checkpoint = Time::default();
            }
        } else if let Some((queue, keeper)) = run.disk.take() {
            drop(queue);
            keeper.join();
            run.has_a_file = false;
            let _ = fs::remove_file(self.directory.join(WARM));
        }
    }

    /// Stops the service in an orderly way.
    ///
    /// # Errors
    /// A condition was violated.
    pub fn stop(&mut self, now: Time) -> CheckResult<()> {
        self.keep(now, true);
        let Some(run) = &mut self.run else { return Ok(()) };
        if self.config.output.flush_on_stop {
            run.driver.finish();
            self.hand_out()?;
        }
        let Some(run) = &mut self.run else { return Ok(()) };
        if let (Some(until), Some((queue, _))) = (run.driver.published(), &run.disk) {
            queue.end(WarmFrame::Published(until));
        }
        self.end()
    }

    /// Kills the service; its own checkpoint may then be damaged.
    ///
    /// # Errors
    /// A condition was violated before.
    pub fn kill(&mut self, damage: Option<&mut ChaCha8Rng>) -> CheckResult<()> {
        let Some(run) = &self.run else { return Ok(()) };
        let damage = damage.filter(|_| run.has_a_file);
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
        fs::write(&file, octets).map_err(|error| Violation(format!("{}: {error}", file.display())))
    }

    /// Ends a run: checks that everything was counted, and that a replay of the recording gives the same output.
    fn end(&mut self) -> CheckResult<()> {
        let Some(run) = self.run.take() else { return Ok(()) };
        if let Some((queue, keeper)) = run.disk {
            drop(queue);
            keeper.join();
        }
        let counted = run.driver.pipeline().tally().received - run.counted;
        if counted != run.offered {
            return Err(Violation(format!("{} datagrams came, {counted} were counted", run.offered)));
        }
        if run.is_afresh {
            return Ok(());
        }
        let (state, mut encoders) = run.began;
        let mut again = Driver::new(&self.config, Masks::default(), Time::default(), self.lines());
        again
            .restore(&self.config, Masks::default(), &state)
            .map_err(|error| Violation(error.to_string()))?;
        for reception in &run.handled {
            again.receive(reception);
            while let Some(made) = again.poll() {
                let DriverEvent::Slot(frame) = made else { continue };
                let picture = &frame.picture;
                let within = picture.within(self.config.output.max_accuracy_m);
                let sent = encoders.picture(Feed::RECORDED, picture.time, within);
                if let Some(published) = run.sent.get(&picture.time) {
                    if *published != sent {
                        return Err(Violation(format!("slot {} replays to another one", picture.time)));
                    }
                    self.replayed += 1;
                }
            }
        }
        Ok(())
    }
}
