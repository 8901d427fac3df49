//! Replay of a recording, which readers see like the live service. It can be paused, sped up, and moved to another time.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tracing::{error, info, warn};

use super::driver::{Driver, DriverEvent};
use super::hub::HubWriter;
use super::published::{PublishedPicture, Status};
use crate::state::CorrelationPlan;
use fusion::time::{SECOND, Time};
use input::capture::{Capture, MergedCaptures, OpenError};
use input::pipeline::Event;
use picture::UncooperativeDetector;
use picture::conflicts::{ConflictWatch, Outlook};
use site::areas::Masks;
use site::config::Config;

/// A command to the replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReplayCommand {
    /// Resumes the replay.
    Play,
    /// Pauses the replay.
    Pause,
    /// Moves to this time of the recording.
    Seek(Time),
    /// Sets the speed, as a multiple of real time; above 0.
    Speed(f64),
}

/// State of a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayerState {
    /// Whether the replay is running.
    pub playing: bool,
    /// Speed, as a multiple of real time.
    pub speed: f64,
    /// Time of the last slot shown.
    pub time: Option<Time>,
    /// First reception of the recording.
    pub first: Option<Time>,
    /// Last reception of the recording, which is read to its end in the background.
    pub last: Option<Time>,
    /// Whether the recording has ended.
    pub ended: bool,
}

/// Opens the captures again: going back starts from their beginning.
pub type OpenCaptures = Arc<dyn Fn() -> Result<Vec<Capture>, OpenError> + Send + Sync>;

/// Handle of a replay; cheap to clone. The replay ends when the last handle is dropped.
#[derive(Clone, Debug)]
pub struct Player {
    orders: Sender<ReplayCommand>,
    state: watch::Receiver<PlayerState>,
}

impl Player {
    /// Starts a replay on its own thread, at this speed; `again` repeats it without end. `correlated` holds the operators'
    /// decisions of the flight; those made during the replay are added. Another thread reads the length of the recording.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        open: OpenCaptures,
        date: jiff::civil::Date,
        config: Arc<Config>,
        (masks, detector): (Masks, UncooperativeDetector),
        hub: HubWriter,
        (speed, again): (f64, bool),
        correlated: CorrelationPlan,
    ) -> io::Result<(Self, JoinHandle<()>)> {
        let (orders, ordered) = mpsc::channel();
        let begin = PlayerState { playing: true, speed, time: None, first: None, last: None, ended: false };
        let (state, watched) = watch::channel(begin);
        let (survey, told) = (open.clone(), state.clone());
        // This thread ends at the end of the recording.
        std::thread::Builder::new().name("survey".to_owned()).spawn(move || {
            let (first, last) = span(&survey, date).unzip();
            told.send_modify(|state| (state.first, state.last) = (state.first.or(first), last));
        })?;
        let show = Playback {
            conflicts: None,
            config,
            masks,
            detector,
            hub,
            state,
            orders: ordered,
            again,
            correlated,
            anchor: None,
            from: None,
            passed_over: None,
            shown: 0,
        };
        let thread =
            std::thread::Builder::new().name("replay".to_owned()).spawn(move || show.run(&open, date))?;
        Ok((Self { orders, state: watched }, thread))
    }

    /// Sends a command, which is carried out at the next slot.
    pub fn order(&self, order: ReplayCommand) {
        // A failed replay has logged the reason.
        let _ = self.orders.send(order);
    }

    /// Present state.
    pub fn state(&self) -> PlayerState {
        *self.state.borrow()
    }

    /// Subscribes to the state.
    pub fn states(&self) -> watch::Receiver<PlayerState> {
        self.state.clone()
    }
}

/// First and last reception of the recording, read to its end. Faults of the files are logged by the replay itself.
fn span(open: &OpenCaptures, date: jiff::civil::Date) -> Option<(Time, Time)> {
    let mut receptions =
        MergedCaptures::new(open().ok()?, date).flatten().filter_map(|reception| reception.received);
    let first = receptions.next()?;
    Some((first, receptions.last().unwrap_or(first)))
}

/// Action after a command.
#[derive(Clone, Copy, PartialEq)]
enum PlaybackAction {
    GoOn,
    /// Starts again from the beginning, to go back in time.
    Again,
    /// Ends: all handles were dropped.
    End,
}

/// A slot, with its evaluation of conflicts.
type EvaluatedSlot = (PublishedPicture, Option<Outlook>);

struct Playback {
    config: Arc<Config>,
    masks: Masks,
    detector: UncooperativeDetector,
    hub: HubWriter,
    /// Evaluates conflicts, from the beginning of the recording.
    conflicts: Option<ConflictWatch>,
    state: watch::Sender<PlayerState>,
    orders: Receiver<ReplayCommand>,
    /// Whether the replay repeats at the end.
    again: bool,
    /// Operators' decisions, with the slots from which they apply; going back applies them again.
    correlated: CorrelationPlan,
    /// Time of a slot, and when it was shown: later slots are timed relative to it.
    anchor: Option<(Time, Instant)>,
    /// Slots before this time are skipped.
    from: Option<Time>,
    /// The last skipped slot; shown if the recording ends before that time.
    passed_over: Option<EvaluatedSlot>,
    /// Number of slots shown so far. It only rises, also when the recording starts again, because readers rely on it.
    shown: u64,
}

impl Playback {
    fn run(mut self, open: &OpenCaptures, date: jiff::civil::Date) {
        loop {
            match self.play(open, date) {
                Ok(PlaybackAction::Again) => {}
                Ok(_) => return,
                Err(error) => {
                    error!(%error, "the replay has ended");
                    self.state.send_modify(|state| (state.playing, state.ended) = (false, true));
                    return;
                }
            }
        }
    }

    /// Plays from the beginning to the end, or to a command that goes back.
    fn play(&mut self, open: &OpenCaptures, date: jiff::civil::Date) -> Result<PlaybackAction, OpenError> {
        let mut merged = MergedCaptures::new(open()?, date).with_editions(self.config.editions()).peekable();
        // Rates and silences of the sensors count from the recording's start, not from the present.
        let started = merged.peek().and_then(|first| first.as_ref().ok()?.received).unwrap_or_default();
        let mut driver =
            Driver::new(&self.config, self.masks.clone(), started, 0).with_detector(self.detector.clone());
        driver.engine_mut().plan(self.correlated.correlated.clone());
        driver.engine_mut().resume(self.correlated.kept.clone());
        driver.engine_mut().plan_trust_overrides(self.correlated.words.clone());
        driver.engine_mut().plan_relocations(self.correlated.relocations.clone());
        self.conflicts = ConflictWatch::of(&self.config);
        self.anchor = None;
        let shown_before = self.shown;
        self.state.send_modify(|state| state.ended = false);
        let mut next_status = Time::default();
        for reception in merged {
            let reception = match reception {
                Ok(reception) => reception,
                // Data read before the damage is still shown.
                Err(damage) => {
                    warn!(%damage, "an input cannot be read on");
                    continue;
                }
            };
            if let Some(received) = reception.received {
                self.state.send_if_modified(|state| {
                    let is_first = state.first.is_none();
                    state.first.get_or_insert(received);
                    is_first
                });
                driver.begin(received);
                if received >= next_status {
                    next_status = Time::from_nanos(received.nanos() + SECOND);
                    self.publish_status(&mut driver, received);
                }
            }
            driver.receive(&reception);
            match self.show_all(&mut driver) {
                PlaybackAction::GoOn => {}
                other => return Ok(other),
            }
            let decided = self.hub.correlation_requests.carry_out_all(&mut driver);
            self.correlated.correlated.extend(decided);
            let words = self.hub.trust_requests.carry_out_all(&mut driver);
            self.correlated.words.extend(words);
            let relocations = self.hub.relocation_requests.carry_out_all(&mut driver);
            self.correlated.relocations.extend(relocations);
        }
        driver.finish();
        match self.show_all(&mut driver) {
            PlaybackAction::GoOn => {}
            other => return Ok(other),
        }
        if let (Some(_), Some(seen)) = (self.from.take(), self.passed_over.take()) {
            self.publish(seen);
        }
        // A recording without a slot would repeat without a pause.
        if self.again && self.shown > shown_before {
            self.from = None;
            let slot = self.config.fusion.slot.unsigned_abs();
            let speed = self.state.borrow().speed;
            match self.orders.recv_timeout(slot.div_f64(speed)) {
                Ok(order) => _ = self.carry_out(order, None),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(PlaybackAction::End),
            }
            return Ok(PlaybackAction::Again);
        }
        info!("the recording has come to its end");
        self.state.send_modify(|state| (state.playing, state.ended) = (false, true));
        loop {
            match self.orders.recv() {
                Err(_) => return Ok(PlaybackAction::End),
                Ok(ReplayCommand::Play) => {
                    self.from = None;
                    self.state.send_modify(|state| state.playing = true);
                    return Ok(PlaybackAction::Again);
                }
                Ok(order) => {
                    if self.carry_out(order, None) == PlaybackAction::Again {
                        return Ok(PlaybackAction::Again);
                    }
                }
            }
        }
    }

    /// Shows the slots that the driver has made, and the decisions then in force.
    fn show_all(&mut self, driver: &mut Driver) -> PlaybackAction {
        let mut is_new = false;
        while let Some(event) = driver.poll() {
            match event {
                DriverEvent::Slot(picture) => {
                    is_new = true;
                    let watch = self.conflicts.as_mut();
                    let outlook = watch.and_then(|watch| picture.conflicts(watch, driver.maker()));
                    match self.show((picture, outlook)) {
                        PlaybackAction::GoOn => {}
                        other => return other,
                    }
                }
                DriverEvent::Event(Event::Accepted { report, .. }) => self.hub.recent_reports.note(&report),
                DriverEvent::Event(_) | DriverEvent::Number(_) => {}
            }
        }
        if is_new {
            self.hub.correlation_requests.publish_if_changed(&driver.pipeline().engine().correlations());
            self.hub.trust_requests.publish_if_changed(driver);
            let relocations = driver.pipeline().engine().relocations();
            self.hub.relocation_requests.publish_if_changed(&relocations);
        }
        PlaybackAction::GoOn
    }

    /// Shows a slot at its time, unless it is skipped; carries out commands meanwhile.
    fn show(&mut self, seen: EvaluatedSlot) -> PlaybackAction {
        let time = seen.0.picture.time;
        loop {
            if self.from.is_some_and(|from| time < from) {
                let (picture, outlook) = seen;
                self.passed_over = Some((picture, outlook.or_else(|| self.passed_over.take()?.1)));
                return PlaybackAction::GoOn;
            }
            // The slot requested by a seek is shown at once, also while paused.
            if self.from.take().is_some() {
                break;
            }
            let PlayerState { playing, speed, .. } = *self.state.borrow();
            let wait = if playing { self.until(time, speed) } else { Duration::MAX };
            if wait.is_zero() {
                break;
            }
            let order = match wait {
                Duration::MAX => self.orders.recv().map_err(|_| RecvTimeoutError::Disconnected),
                wait => self.orders.recv_timeout(wait),
            };
            match order {
                Ok(order) => match self.carry_out(order, Some(time)) {
                    PlaybackAction::GoOn => {}
                    other => return other,
                },
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return PlaybackAction::End,
            }
        }
        self.publish(seen);
        PlaybackAction::GoOn
    }

    /// Publishes a slot as if on time: a replay uses the times of its recording.
    fn publish(&mut self, (mut picture, outlook): EvaluatedSlot) {
        // Between two evaluations the last skipped one applies.
        let outlook = outlook.or_else(|| self.passed_over.take()?.1);
        self.passed_over = None;
        self.shown += 1;
        picture.seq = self.shown;
        self.state.send_modify(|state| state.time = Some(picture.picture.time));
        self.hub.publish(picture);
        outlook.into_iter().for_each(|outlook| self.hub.conflict_reports.publish(outlook));
    }

    /// Time until a slot is to be shown.
    fn until(&mut self, time: Time, speed: f64) -> Duration {
        #[expect(clippy::disallowed_methods, reason = "the pace of a replay")]
        let clock = Instant::now();
        let (from, shown) = *self.anchor.get_or_insert((time, clock));
        let due = shown + Duration::from_secs_f64(time.seconds_since(from).max(0.0) / speed);
        due.saturating_duration_since(clock)
    }

    /// Carries out a command; `time` is that of the slot about to be shown.
    fn carry_out(&mut self, order: ReplayCommand, time: Option<Time>) -> PlaybackAction {
        self.anchor = None;
        match order {
            ReplayCommand::Play => self.state.send_modify(|state| state.playing = true),
            ReplayCommand::Pause => self.state.send_modify(|state| state.playing = false),
            ReplayCommand::Speed(speed) => self.state.send_modify(|state| state.speed = speed),
            ReplayCommand::Seek(to) => {
                self.from = Some(to);
                if time.is_none_or(|time| to < time) {
                    return PlaybackAction::Again;
                }
            }
        }
        PlaybackAction::GoOn
    }

    fn publish_status(&self, driver: &mut Driver, at: Time) {
        self.hub.publish_status(Status {
            at,
            sensors: driver.sensors(at, |_| Vec::new()),
            unknown: driver.health().unknown(),
            tally: driver.pipeline().tally().clone(),
            numbers_used: driver.pipeline().engine().numbers().used(),
            lateness_s: None,
            failed_sends: 0,
            troubles: Vec::new(),
        });
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::live::{Hub, now};
    use input::pipeline::Pipeline;
    use picture::PictureMaker;

    fn started(speed: f64, again: bool) -> (Player, Hub, JoinHandle<()>) {
        let site = include_str!("../../../../testdata/demo/site.toml");
        let config = Arc::new(Config::parse(site, "site.toml", std::iter::empty()).unwrap());
        let maker = PictureMaker::new(&config, Pipeline::new(&config, Masks::default()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/demo/capture.pcap");
        let open: OpenCaptures = Arc::new(move || Ok(vec![Capture::open(&capture)?]));
        let date = jiff::civil::Date::default();
        let (player, thread) = Player::start(
            open,
            date,
            config,
            Default::default(),
            writer,
            (speed, again),
            CorrelationPlan::default(),
        )
        .unwrap();
        (player, hub, thread)
    }

    /// Waits up to 5 s for a condition.
    fn wait(what: impl Fn() -> bool) {
        for _ in 0..1000 {
            if what() {
                return;
            }
            #[expect(clippy::disallowed_methods, reason = "another thread has to get there")]
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("it did not happen");
    }

    #[test]
    fn player_plays_pauses_and_seeks_both_ways() {
        let (player, hub, thread) = started(1000.0, false);
        wait(|| player.state().ended);
        let end = player.state();
        let (first, last) = (end.first.unwrap(), end.time.unwrap());
        assert!(last.seconds_since(first) > 60.0 && !end.playing);
        assert_eq!(hub.latest().unwrap().picture.time, last);
        // Back to the middle; the replay has ended, so it stays there.
        let middle = Time::from_nanos(first.nanos() + 30 * SECOND);
        player.order(ReplayCommand::Seek(middle));
        wait(|| player.state().time.is_some_and(|time| (time.nanos() - middle.nanos()).abs() < SECOND / 2));
        let stood = player.state().time;
        player.order(ReplayCommand::Seek(Time::from_nanos(first.nanos() + 40 * SECOND)));
        wait(|| player.state().time > stood);
        player.order(ReplayCommand::Speed(2000.0));
        player.order(ReplayCommand::Play);
        wait(|| player.state().ended && player.state().time == Some(last));
        drop(player);
        thread.join().unwrap();
    }

    #[test]
    fn repeated_replay_continues_the_slot_count() {
        let (player, hub, thread) = started(1e6, true);
        let slots = || hub.latest().map_or(0, |picture| picture.seq);
        // 75 s have some 300 slots.
        wait(|| slots() > 1000);
        assert!(!player.state().ended && player.state().last.is_some());
        let before = slots();
        wait(|| slots() > before);
        drop(player);
        thread.join().unwrap();
    }
}
