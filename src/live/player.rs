//! A replay that readers see as they see the live service: it can be paused, sped up, and taken to another time.

use std::error::Error;
use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tokio::sync::watch;
use tracing::{error, info};

use super::driver::{Driver, Made};
use super::hub::{Frame, HubWriter, Status};
use super::service::now;
use crate::areas::Masks;
use crate::config::Config;
use crate::ingest::{Capture, Merged, OpenError, ReadError, Reception};
use crate::time::{SECOND, Time};

/// What a reader may ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Go on.
    Play,
    /// Stop where it is.
    Pause,
    /// Go to this time of the recording.
    Seek(Time),
    /// So many times faster than it happened; above 0.
    Speed(f64),
}

/// How the replay is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayerState {
    /// Whether it goes on.
    pub playing: bool,
    /// How many times faster than it happened.
    pub speed: f64,
    /// The slot shown last.
    pub time: Option<Time>,
    /// The first reception of the recording.
    pub first: Option<Time>,
    /// Whether the recording has come to its end.
    pub ended: bool,
}

/// Opens the captures anew: going back begins at their beginning.
pub type OpenCaptures = Box<dyn Fn() -> Result<Vec<Capture>, OpenError> + Send>;

/// The handle of a replay; cheap to clone. It ends when the last handle is gone.
#[derive(Clone, Debug)]
pub struct Player {
    orders: Sender<Order>,
    state: watch::Receiver<PlayerState>,
    last: Arc<OnceLock<Time>>,
}

impl Player {
    /// Starts a replay on a thread of its own; it begins at once, at that speed, and again at the end where that is `true`.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn start(
        open: OpenCaptures,
        date: jiff::civil::Date,
        config: Arc<Config>,
        masks: Masks,
        hub: HubWriter,
        (speed, again): (f64, bool),
    ) -> io::Result<(Self, JoinHandle<()>)> {
        let (orders, ordered) = mpsc::channel();
        let begin = PlayerState { playing: true, speed, time: None, first: None, ended: false };
        let (state, watched) = watch::channel(begin);
        let last = Arc::new(OnceLock::new());
        let show = Show {
            config,
            masks,
            hub,
            state,
            orders: ordered,
            again,
            seq: 0,
            shown: false,
            anchor: None,
            from: None,
            last: last.clone(),
        };
        let thread =
            std::thread::Builder::new().name("replay".to_owned()).spawn(move || show.run(&open, date))?;
        Ok((Self { orders, state: watched, last }, thread))
    }

    /// Asks for something; it is done at the next slot.
    pub fn order(&self, order: Order) {
        // A replay that failed has said why.
        let _ = self.orders.send(order);
    }

    /// How the replay is.
    pub fn state(&self) -> PlayerState {
        *self.state.borrow()
    }

    /// The last slot of the recording, once it has been seen to its end.
    pub fn last(&self) -> Option<Time> {
        self.last.get().copied()
    }

    /// Told whenever that changes.
    pub fn states(&self) -> watch::Receiver<PlayerState> {
        self.state.clone()
    }
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

struct Show {
    config: Arc<Config>,
    masks: Masks,
    hub: HubWriter,
    state: watch::Sender<PlayerState>,
    orders: Receiver<Order>,
    /// Whether it begins again at the end.
    again: bool,
    /// Counts the slots that were shown, also when it goes back: readers tell by it what is new.
    seq: u64,
    /// Whether one was shown since it began.
    shown: bool,
    /// A slot's time, and when it was shown: what follows keeps its distance to it.
    anchor: Option<(Time, Instant)>,
    /// Slots before this time are passed over.
    from: Option<Time>,
    last: Arc<OnceLock<Time>>,
}

impl Show {
    fn run(mut self, open: &OpenCaptures, date: jiff::civil::Date) {
        loop {
            match self.once(open, date) {
                Ok(Next::Again) => {}
                Ok(_) => return,
                Err(error) => {
                    error!("the replay has ended: {error}");
                    self.state.send_modify(|state| (state.playing, state.ended) = (false, true));
                    return;
                }
            }
        }
    }

    /// From the beginning to the end, or to an order that leads back.
    fn once(
        &mut self,
        open: &OpenCaptures,
        date: jiff::civil::Date,
    ) -> Result<Next, Box<dyn Error + Send + Sync>> {
        let mut driver = Driver::new(&self.config, self.masks.clone(), now(), 0);
        let merged = Merged::new(open()?, date);
        (self.anchor, self.shown) = (None, false);
        self.state.send_modify(|state| state.ended = false);
        let mut next_status = Time::default();
        for reception in merged {
            let reception: Reception = reception.map_err(|damage: ReadError| damage.to_string())?;
            if let Some(received) = reception.received {
                self.state.send_if_modified(|state| {
                    let is_first = state.first.is_none();
                    state.first.get_or_insert(received);
                    is_first
                });
                if received >= next_status {
                    next_status = Time::from_nanos(received.nanos() + SECOND);
                    self.tell(&driver, received);
                }
            }
            let mut slots = Vec::new();
            driver.receive(&reception, |made| {
                if let Made::Slot(frame) = made {
                    slots.push(frame);
                }
            });
            for frame in slots {
                match self.show(frame) {
                    Next::GoOn => {}
                    other => return Ok(other),
                }
            }
        }
        let mut owed = Vec::new();
        driver.finish(|frame| owed.push(frame));
        for frame in owed {
            match self.show(frame) {
                Next::GoOn => {}
                other => return Ok(other),
            }
        }
        info!("the recording has come to its end");
        if let Some(time) = self.state.borrow().time {
            self.last.get_or_init(|| time);
        }
        // A recording without a slot would go round without a pause.
        if self.again && self.shown {
            self.from = None;
            let slot = self.config.fusion.slot.unsigned_abs();
            let speed = self.state.borrow().speed;
            return Ok(match self.orders.recv_timeout(slot.div_f64(speed)) {
                Ok(order) => {
                    self.obey(order, None);
                    Next::Again
                }
                Err(RecvTimeoutError::Timeout) => Next::Again,
                Err(RecvTimeoutError::Disconnected) => Next::End,
            });
        }
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

    /// Shows a slot at its time, unless it is passed over; orders are heard meanwhile.
    fn show(&mut self, mut frame: Frame) -> Next {
        let time = frame.picture.time;
        loop {
            if self.from.is_some_and(|from| time < from) {
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
        (self.seq, self.shown) = (self.seq + 1, true);
        (frame.seq, frame.published_at) = (self.seq, now());
        self.hub.publish(frame);
        self.state.send_modify(|state| state.time = Some(time));
        Next::GoOn
    }

    /// How long it is until a slot is to be shown.
    fn until(&mut self, time: Time, speed: f64) -> Duration {
        #[expect(clippy::disallowed_methods, reason = "the pace of a replay")]
        let clock = Instant::now();
        let (from, shown) = *self.anchor.get_or_insert((time, clock));
        let due = shown + Duration::from_secs_f64(time.seconds_since(from).max(0.0) / speed);
        due.saturating_duration_since(clock)
    }

    /// Does what is asked; `time`: the slot that is about to be shown.
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

    fn tell(&self, driver: &Driver, at: Time) {
        self.hub.tell(Status {
            at,
            sensors: driver.health().sensors(at, |_| Vec::new()),
            unknown: driver.health().unknown(),
            tally: driver.pipeline().tally().clone(),
            lateness_s: None,
            failed_sends: 0,
        });
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::live::Hub;
    use crate::picture::PictureMaker;
    use crate::pipeline::Pipeline;

    fn started(speed: f64, again: bool) -> (Player, Hub, JoinHandle<()>) {
        let site = include_str!("../../testdata/demo/site.toml");
        let config = Arc::new(Config::parse(site, "site.toml", std::iter::empty()).unwrap());
        let maker = PictureMaker::new(&config, Pipeline::new(&config, Masks::default()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/capture.pcap");
        let open: OpenCaptures = Box::new(move || Ok(vec![Capture::open(&capture)?]));
        let date = jiff::civil::Date::default();
        let (player, thread) =
            Player::start(open, date, config, Masks::default(), writer, (speed, again)).unwrap();
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
        let slots = || hub.latest().map_or(0, |frame| frame.seq);
        // 75 s have some 300 slots.
        wait(|| slots() > 1000);
        assert!(!player.state().ended && player.last().is_some());
        let before = slots();
        wait(|| slots() > before);
        drop(player);
        thread.join().unwrap();
    }
}
