//! A replay that readers see as they see the live service: it can be paused, sped up, and taken to another time.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tracing::{error, info, warn};

use super::driver::{Driver, Made};
use super::hub::HubWriter;
use super::published::{PublishedPicture, Status};
use crate::areas::Masks;
use crate::capture::{Capture, Merged, OpenError};
use crate::config::Config;
use crate::conflicts::{ConflictWatch, Outlook};
use crate::integrity::Lookout;
use crate::pipeline::Event;
use crate::state::CorrelationPlan;
use fusion::time::{SECOND, Time};

/// An order of a reader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Go on.
    Play,
    /// Stop where it is.
    Pause,
    /// Go to this time of the recording.
    Seek(Time),
    /// This speed, as a multiple of real time; above 0.
    Speed(f64),
}

/// State of a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayerState {
    /// Whether it goes on.
    pub playing: bool,
    /// Speed, as a multiple of real time.
    pub speed: f64,
    /// The slot shown last.
    pub time: Option<Time>,
    /// The first reception of the recording.
    pub first: Option<Time>,
    /// Its last reception; the recording is read through for it in the background.
    pub last: Option<Time>,
    /// Whether the recording has come to its end.
    pub ended: bool,
}

/// Opens the captures anew: going back begins at their beginning.
pub type OpenCaptures = Arc<dyn Fn() -> Result<Vec<Capture>, OpenError> + Send + Sync>;

/// The handle of a replay; cheap to clone. It ends when the last handle is gone.
#[derive(Clone, Debug)]
pub struct Player {
    orders: Sender<Order>,
    state: watch::Receiver<PlayerState>,
}

impl Player {
    /// Starts a replay on a thread of its own, at this speed, once or `again` and again. `correlated` are the decisions of
    /// the flight; those made during the replay are added. Another thread reads how long the recording is.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        open: OpenCaptures,
        date: jiff::civil::Date,
        config: Arc<Config>,
        (masks, lookout): (Masks, Lookout),
        hub: HubWriter,
        (speed, again): (f64, bool),
        correlated: CorrelationPlan,
    ) -> io::Result<(Self, JoinHandle<()>)> {
        let (orders, ordered) = mpsc::channel();
        let begin = PlayerState { playing: true, speed, time: None, first: None, last: None, ended: false };
        let (state, watched) = watch::channel(begin);
        let (survey, told) = (open.clone(), state.clone());
        // It ends by itself at the end of the recording.
        std::thread::Builder::new().name("survey".to_owned()).spawn(move || {
            let (first, last) = span(&survey, date).unzip();
            told.send_modify(|state| (state.first, state.last) = (state.first.or(first), last));
        })?;
        let show = Show {
            conflicts: None,
            config,
            masks,
            lookout,
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

    /// Gives an order; it is carried out at the next slot.
    pub fn order(&self, order: Order) {
        // A replay that failed has said why.
        let _ = self.orders.send(order);
    }

    /// The state now.
    pub fn state(&self) -> PlayerState {
        *self.state.borrow()
    }

    /// The state, whenever it changes.
    pub fn states(&self) -> watch::Receiver<PlayerState> {
        self.state.clone()
    }
}

/// First and last reception, from reading the recording to its end. The replay itself reports what is wrong with a file.
fn span(open: &OpenCaptures, date: jiff::civil::Date) -> Option<(Time, Time)> {
    let mut receptions = Merged::new(open().ok()?, date).flatten().filter_map(|reception| reception.received);
    let first = receptions.next()?;
    Some((first, receptions.last().unwrap_or(first)))
}

/// What to do after an order.
#[derive(Clone, Copy, PartialEq)]
enum Next {
    GoOn,
    /// Begin anew, for a time that is past.
    Again,
    /// Nobody is left to see it.
    End,
}

/// A slot, with the conflicts that were found in it.
type Seen = (PublishedPicture, Option<Outlook>);

struct Show {
    config: Arc<Config>,
    masks: Masks,
    lookout: Lookout,
    hub: HubWriter,
    /// From the beginning of the recording on.
    conflicts: Option<ConflictWatch>,
    state: watch::Sender<PlayerState>,
    orders: Receiver<Order>,
    /// Whether it begins again at the end.
    again: bool,
    /// Operators' decisions, with the slots from which they count: going back shows them again.
    correlated: CorrelationPlan,
    /// A slot's time, and when it was shown: later slots keep their distance to it.
    anchor: Option<(Time, Instant)>,
    /// Slots before this time are passed over.
    from: Option<Time>,
    /// The last of them: shown where the recording ends before that time.
    passed_over: Option<Seen>,
    /// Slots shown so far. Readers count on a number that only rises, also when the recording begins anew.
    shown: u64,
}

impl Show {
    fn run(mut self, open: &OpenCaptures, date: jiff::civil::Date) {
        loop {
            match self.once(open, date) {
                Ok(Next::Again) => {}
                Ok(_) => return,
                Err(error) => {
                    error!(%error, "the replay has ended");
                    self.state.send_modify(|state| (state.playing, state.ended) = (false, true));
                    return;
                }
            }
        }
    }

    /// From the beginning to the end, or to an order that leads back.
    fn once(&mut self, open: &OpenCaptures, date: jiff::civil::Date) -> Result<Next, OpenError> {
        let mut merged = Merged::new(open()?, date).with_editions(self.config.editions()).peekable();
        // The sensors' rates and silences count from the recording's start, not from today.
        let started = merged.peek().and_then(|first| first.as_ref().ok()?.received).unwrap_or_default();
        let mut driver =
            Driver::new(&self.config, self.masks.clone(), started, 0).with_lookout(self.lookout.clone());
        driver.engine_mut().plan(self.correlated.correlated.clone());
        driver.engine_mut().resume(self.correlated.kept.clone());
        driver.engine_mut().plan_words(self.correlated.words.clone());
        self.conflicts = ConflictWatch::of(&self.config);
        self.anchor = None;
        let shown_before = self.shown;
        self.state.send_modify(|state| state.ended = false);
        let mut next_status = Time::default();
        for reception in merged {
            let reception = match reception {
                Ok(reception) => reception,
                // What was read before is still there to be seen.
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
                if received >= next_status {
                    next_status = Time::from_nanos(received.nanos() + SECOND);
                    self.tell(&mut driver, received);
                }
            }
            driver.receive(&reception);
            match self.show_all(&mut driver) {
                Next::GoOn => {}
                other => return Ok(other),
            }
            let made = self.hub.correlations.obey(&mut driver);
            self.correlated.correlated.extend(made);
            let said = self.hub.integrity.obey(&mut driver);
            self.correlated.words.extend(said);
        }
        driver.finish();
        match self.show_all(&mut driver) {
            Next::GoOn => {}
            other => return Ok(other),
        }
        if let (Some(_), Some(seen)) = (self.from.take(), self.passed_over.take()) {
            self.publish(seen);
        }
        // A recording without a slot would go round without a pause.
        if self.again && self.shown > shown_before {
            self.from = None;
            let slot = self.config.fusion.slot.unsigned_abs();
            let speed = self.state.borrow().speed;
            match self.orders.recv_timeout(slot.div_f64(speed)) {
                Ok(order) => _ = self.obey(order, None),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(Next::End),
            }
            return Ok(Next::Again);
        }
        info!("the recording has come to its end");
        self.state.send_modify(|state| (state.playing, state.ended) = (false, true));
        loop {
            match self.orders.recv() {
                Err(_) => return Ok(Next::End),
                Ok(Order::Play) => {
                    self.from = None;
                    self.state.send_modify(|state| state.playing = true);
                    return Ok(Next::Again);
                }
                Ok(order) => {
                    if self.obey(order, None) == Next::Again {
                        return Ok(Next::Again);
                    }
                }
            }
        }
    }

    /// Shows the slots that the driver has made, and the decisions then in force.
    fn show_all(&mut self, driver: &mut Driver) -> Next {
        let mut is_new = false;
        while let Some(made) = driver.poll() {
            match made {
                Made::Slot(picture) => {
                    is_new = true;
                    let watch = self.conflicts.as_mut();
                    let outlook = watch.and_then(|watch| picture.conflicts(watch, driver.maker()));
                    match self.show((picture, outlook)) {
                        Next::GoOn => {}
                        other => return other,
                    }
                }
                Made::Event(Event::Accepted { report, .. }) => self.hub.inputs.note(&report),
                Made::Event(_) | Made::Number(_) => {}
            }
        }
        if is_new {
            self.hub.correlations.tell(&driver.pipeline().engine().correlations());
            self.hub.integrity.tell(driver);
        }
        Next::GoOn
    }

    /// Shows a slot at its time, unless it is passed over; carries out orders meanwhile.
    fn show(&mut self, seen: Seen) -> Next {
        let time = seen.0.picture.time;
        loop {
            if self.from.is_some_and(|from| time < from) {
                let (picture, outlook) = seen;
                self.passed_over = Some((picture, outlook.or_else(|| self.passed_over.take()?.1)));
                return Next::GoOn;
            }
            // What was asked for is shown at once, also while paused.
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
                Ok(order) => match self.obey(order, Some(time)) {
                    Next::GoOn => {}
                    other => return other,
                },
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Next::End,
            }
        }
        self.publish(seen);
        Next::GoOn
    }

    /// As if it had been published when it was due: every time in a replay is one of the recording.
    fn publish(&mut self, (mut picture, outlook): Seen) {
        // Between two evaluations the last of those that were passed over still holds.
        let outlook = outlook.or_else(|| self.passed_over.take()?.1);
        self.passed_over = None;
        self.shown += 1;
        picture.seq = self.shown;
        self.state.send_modify(|state| state.time = Some(picture.picture.time));
        self.hub.publish(picture);
        outlook.into_iter().for_each(|outlook| self.hub.outlooks.publish(outlook));
    }

    /// Time until a slot is to be shown.
    fn until(&mut self, time: Time, speed: f64) -> Duration {
        #[expect(clippy::disallowed_methods, reason = "the pace of a replay")]
        let clock = Instant::now();
        let (from, shown) = *self.anchor.get_or_insert((time, clock));
        let due = shown + Duration::from_secs_f64(time.seconds_since(from).max(0.0) / speed);
        due.saturating_duration_since(clock)
    }

    /// Carries out an order; `time` is that of the slot about to be shown.
    fn obey(&mut self, order: Order, time: Option<Time>) -> Next {
        self.anchor = None;
        match order {
            Order::Play => self.state.send_modify(|state| state.playing = true),
            Order::Pause => self.state.send_modify(|state| state.playing = false),
            Order::Speed(speed) => self.state.send_modify(|state| state.speed = speed),
            Order::Seek(to) => {
                self.from = Some(to);
                if time.is_none_or(|time| to < time) {
                    return Next::Again;
                }
            }
        }
        Next::GoOn
    }

    fn tell(&self, driver: &mut Driver, at: Time) {
        self.hub.tell(Status {
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
    use crate::picture::PictureMaker;
    use crate::pipeline::Pipeline;

    fn started(speed: f64, again: bool) -> (Player, Hub, JoinHandle<()>) {
        let site = include_str!("../../testdata/demo/site.toml");
        let config = Arc::new(Config::parse(site, "site.toml", std::iter::empty()).unwrap());
        let maker = PictureMaker::new(&config, Pipeline::new(&config, Masks::default()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
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

    /// Waits for something that must come soon.
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
    fn it_plays_to_the_end_pauses_and_seeks_both_ways() {
        let (player, hub, thread) = started(1000.0, false);
        wait(|| player.state().ended);
        let end = player.state();
        let (first, last) = (end.first.unwrap(), end.time.unwrap());
        assert!(last.seconds_since(first) > 60.0 && !end.playing);
        assert_eq!(hub.latest().unwrap().picture.time, last);
        // Back to the middle; it is not playing, so it stays where it was asked to be.
        let middle = Time::from_nanos(first.nanos() + 30 * SECOND);
        player.order(Order::Seek(middle));
        wait(|| player.state().time.is_some_and(|time| (time.nanos() - middle.nanos()).abs() < SECOND / 2));
        let stood = player.state().time;
        player.order(Order::Seek(Time::from_nanos(first.nanos() + 40 * SECOND)));
        wait(|| player.state().time > stood);
        player.order(Order::Speed(2000.0));
        player.order(Order::Play);
        wait(|| player.state().ended && player.state().time == Some(last));
        drop(player);
        thread.join().unwrap();
    }

    #[test]
    fn it_begins_again_and_goes_on_counting() {
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
