//! Gateways of the virtual world, and clocks that are wrong for a while.

use std::collections::VecDeque;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{BEGINS_MS, Engine, FAULTS_MS, GATEWAYS, NODES, World, time};
use crate::cluster::message::{Header, Heard, Input, Logged, Origin, Output};
use crate::cluster::region::{Letter, Word};
use crate::territory::CellName;

const SLOT_MS: i64 = 250;
/// Errors of clocks, milliseconds.
const ERRORS_MS: [i64; 6] = [1_600, 3_000, 10_000, 30_000, 120_000, 600_000];

/// Whose clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Who {
    Gateway(usize),
    Node(usize),
    /// Another server leads the log, and stamps what comes.
    Log,
}

/// Whose clock is wrong, from when, until when, by how much, milliseconds: one at a time.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Clocks(pub(in super::super) Vec<(Who, i64, i64, i64)>);

impl Clocks {
    pub(in super::super) fn any(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xc10c);
        let (mut from, mut wrong) = (random.random_range(0..8_000), Vec::new());
        while from < FAULTS_MS.end {
            let who = match random.random_range(0..7) {
                0..3 => Who::Gateway(random.random_range(0..GATEWAYS)),
                3..5 => Who::Log,
                _ => Who::Node(random.random_range(0..NODES)),
            };
            let until = from + random.random_range(500..15_000);
            let error_ms =
                ERRORS_MS[random.random_range(0..ERRORS_MS.len())] + random.random_range(-100..100);
            wrong.push((who, from, until, if random.random_bool(0.5) { -error_ms } else { error_ms }));
            from = until + random.random_range(3_500..8_000);
        }
        Self(wrong)
    }

    pub(super) fn error_ms(&self, of: Who, at: i64) -> i64 {
        let wrong = self.0.iter().find(|(who, from, until, _)| *who == of && (*from..*until).contains(&at));
        wrong.map_or(0, |(.., error_ms)| *error_ms)
    }

    /// Whether the clock of the log, or of a gateway, is wrong at some time within.
    pub(super) fn is_wrong_within(&self, time: std::ops::Range<i64>) -> bool {
        let is_within = |(who, from, until, _): &(Who, i64, i64, i64)| {
            !matches!(who, Who::Node(_)) && *from < time.end && time.start < *until
        };
        self.0.iter().any(is_within)
    }

    /// Since when that clock is as it is.
    fn since(&self, of: Who, at: i64) -> i64 {
        let changes =
            self.0.iter().filter(|(who, ..)| *who == of).flat_map(|(_, from, until, _)| [*from, *until]);
        changes.filter(|change| *change <= at).max().unwrap_or(0)
    }
}

/// The true values of a message of a gateway.
#[derive(Clone, Debug)]
pub(in super::super) struct Sent {
    pub(in super::super) gateway: usize,
    pub(in super::super) error_ms: i64,
    /// Whether its clock was set between the end of its slot and the sending.
    pub(in super::super) is_set: bool,
    /// Time since its clock and the log's are so, milliseconds, and when it was written.
    pub(in super::super) lasts_ms: i64,
    pub(in super::super) at: i64,
}

/// A message on its way.
#[derive(Debug)]
pub(super) struct OnItsWay {
    arrives: i64,
    sent: i64,
    gateway: usize,
    input: Input,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Gateway {
    pub(super) down_until: i64,
    /// The last slot that was sent, by its own clock.
    slot: i64,
    /// Datagrams up to this true time were heard.
    heard: i64,
}

/// The header of an input.
pub(super) fn header(logged: &Logged) -> Option<Header> {
    match logged {
        Logged::Input(input) => Header::of(&input.body()).unwrap(),
        Logged::Letter(_) => None,
    }
}

impl<E: Engine> World<E> {
    /// The same with clocks that are wrong.
    pub(in super::super) fn with(self, clocks: Clocks) -> Self {
        Self { clocks, ..self }
    }

    /// The same with odd messages: inputs and letters of slots that are far away.
    pub(in super::super) fn odd(self) -> Self {
        Self { is_odd: true, ..self }
    }

    /// Messages of gateways, with their sequences.
    pub(in super::super) fn sent(&self) -> impl Iterator<Item = (u64, Option<&Sent>)> {
        (1..).zip(self.log.sent.iter().map(Option::as_ref))
    }

    /// How much earlier than it was due a slot was written at most, milliseconds of true time.
    pub(in super::super) fn early_ms(&self) -> i64 {
        let due_ms =
            |output: &Output| SlotGrid::default().open(output.slot.plus(25)).nanos() / 1_000_000 - BEGINS_MS;
        let early = self.log.outputs.iter().zip(&self.log.written_at).map(|(output, at)| due_ms(output) - at);
        early.max().unwrap_or_default()
    }

    /// Gateways hear the sensors, and write a message a sensor and slot.
    pub(super) fn gather(&mut self) {
        for gateway in 0..GATEWAYS {
            self.hear(gateway);
        }
        if self.is_odd && self.random.random_bool(0.02) {
            self.intrude();
        }
        if self.is_leaderless() {
            return;
        }
        let now = self.now;
        let (arrived, waiting): (VecDeque<_>, _) =
            std::mem::take(&mut self.sent).into_iter().partition(|message| message.arrives <= now);
        self.sent = waiting;
        for OnItsWay { arrives, sent, gateway, mut input } in arrived {
            let of_slot_ms = self.clocks.error_ms(Who::Gateway(gateway), sent);
            // What was not acknowledged is sent again, and states when.
            let is_again = now - arrives > super::STEP_MS;
            let sent = if is_again { now - self.random.random_range(1..40) } else { sent };
            let error_ms = self.clocks.error_ms(Who::Gateway(gateway), sent);
            let name = format!("g{gateway}");
            input.origin = Some(Origin { gateway: name, sent: time(sent + error_ms), config: 0 });
            let since = |of| self.clocks.since(of, sent);
            let lasts_ms = sent - since(Who::Gateway(gateway)).max(since(Who::Log));
            let is_set = of_slot_ms != error_ms;
            let truth = Sent { gateway, error_ms, is_set, lasts_ms, at: now };
            self.log.write(Logged::Input(input), Some(truth), &mut self.random);
        }
    }

    fn hear(&mut self, index: usize) {
        let error_ms = self.clocks.error_ms(Who::Gateway(index), self.now);
        let over = (BEGINS_MS + self.now + error_ms).div_euclid(SLOT_MS) - 1;
        let gateway = &mut self.gateways[index];
        if self.now < gateway.down_until || gateway.slot == 0 || (over - gateway.slot).abs() > 8 {
            if self.now < gateway.down_until {
                gateway.heard = self.now;
            }
            // Its clock was set, or it was down: from there on.
            gateway.slot = over - i64::from(gateway.slot != 0);
        }
        let first = gateway.slot + 1;
        if first > over || self.now < gateway.down_until {
            return;
        }
        gateway.slot = over;
        for slot in first..=over {
            let end = (slot + 1) * SLOT_MS - BEGINS_MS - error_ms;
            let within = std::mem::replace(&mut self.gateways[index].heard, end)..end;
            for sensor in self.sensors.clone() {
                self.send(index, (slot, sensor), within.clone(), error_ms);
            }
        }
    }

    fn send(
        &mut self,
        index: usize,
        (slot, sensor): (i64, DataSource),
        within: std::ops::Range<i64>,
        error_ms: i64,
    ) {
        let mut heard = Vec::new();
        for (at_ms, from, payload) in &self.feed {
            // A gateway does not hear all of it.
            if within.contains(at_ms) && *from == sensor && self.random.random_bool(0.97) {
                heard.push(Heard {
                    received: time(at_ms + error_ms + index as i64),
                    from: "127.0.0.1:5000".parse().unwrap(),
                    to: "239.1.1.1:8048".parse().unwrap(),
                    payload: payload.clone(),
                });
            }
        }
        let input = Input { origin: None, sensor, slot: Slot(slot), part: 0, is_last: true, heard };
        let delay = if self.random.random_bool(0.02) { 400 } else { 40 };
        let arrives = self.now + self.random.random_range(1..delay);
        self.sent.push_back(OnItsWay { arrives, sent: self.now, gateway: index, input });
    }

    /// Writes what no member would: slots, and letters of slots, that are far away.
    fn intrude(&mut self) {
        let far = [14_400, 40, -14_400, -400_000_000, i64::MAX - 1, i64::MIN][self.random.random_range(0..6)];
        let slot = Slot(((BEGINS_MS + self.now) / SLOT_MS).saturating_add(far));
        let name = CellName::new("toy").unwrap();
        let word = Word::Unknown { id: "x".to_owned() };
        let logged = match self.random.random_range(0..3) {
            0 if far > 1_000 => {
                Logged::Letter(Letter { from: name.clone(), to: name, slot, index: 9, word }.into())
            }
            kind => {
                let gateway = format!("x{}", self.random.random_range(0..1000));
                let sent = time(self.now + self.random.random_range(-900_000..900_000));
                let origin = (kind == 1).then_some(Origin { gateway, sent, config: 0 });
                let sensor = DataSource { sac: 9, sic: self.random.random_range(0..3) };
                Logged::Input(Input { origin, sensor, slot, part: 0, is_last: true, heard: Vec::new() })
            }
        };
        self.log.write(logged, None, &mut self.random);
    }
}
