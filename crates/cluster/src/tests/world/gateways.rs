//! Gateways of the virtual world, and clocks that are wrong for a while.

use std::collections::VecDeque;

use asterix::DataSource;
use fusion::slots::{Slot, SlotGrid};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{BEGINS_MS, Engine, FAULTS_MS, GATEWAYS, NODES, World, time};
use crate::message::{CellOutput, GatewayInput, InputHeader, InputOrigin, LoggedMessage, ReceivedDatagram};
use crate::region::{CellMessage, CellMessageContent};
use site::territory::CellName;

const SLOT_MS: i64 = 250;
/// Clock errors, in milliseconds.
const ERRORS_MS: [i64; 6] = [1_600, 3_000, 10_000, 30_000, 120_000, 600_000];

/// Owner of a clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum ClockOwner {
    Gateway(usize),
    Node(usize),
    /// Another server leads the log, and stamps the messages.
    Log,
}

/// Wrong clocks, one at a time: owner, start, end, and error, all in milliseconds.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Clocks(pub(in super::super) Vec<(ClockOwner, i64, i64, i64)>);

impl Clocks {
    pub(in super::super) fn any(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xc10c);
        let (mut from, mut wrong) = (random.random_range(0..8_000), Vec::new());
        while from < FAULTS_MS.end {
            let who = match random.random_range(0..7) {
                0..3 => ClockOwner::Gateway(random.random_range(0..GATEWAYS)),
                3..5 => ClockOwner::Log,
                _ => ClockOwner::Node(random.random_range(0..NODES)),
            };
            let until = from + random.random_range(500..15_000);
            let error_ms =
                ERRORS_MS[random.random_range(0..ERRORS_MS.len())] + random.random_range(-100..100);
            wrong.push((who, from, until, if random.random_bool(0.5) { -error_ms } else { error_ms }));
            from = until + random.random_range(3_500..8_000);
        }
        Self(wrong)
    }

    pub(super) fn error_ms(&self, of: ClockOwner, at: i64) -> i64 {
        let wrong = self.0.iter().find(|(who, from, until, _)| *who == of && (*from..*until).contains(&at));
        wrong.map_or(0, |(.., error_ms)| *error_ms)
    }

    /// Whether the clock of the log or of a gateway is wrong at some time within `time`.
    pub(super) fn is_wrong_within(&self, time: std::ops::Range<i64>) -> bool {
        let is_within = |(who, from, until, _): &(ClockOwner, i64, i64, i64)| {
            !matches!(who, ClockOwner::Node(_)) && *from < time.end && time.start < *until
        };
        self.0.iter().any(is_within)
    }

    /// Time of that clock's last change.
    fn since(&self, of: ClockOwner, at: i64) -> i64 {
        let changes =
            self.0.iter().filter(|(who, ..)| *who == of).flat_map(|(_, from, until, _)| [*from, *until]);
        changes.filter(|change| *change <= at).max().unwrap_or(0)
    }
}

/// True values of a gateway's message.
#[derive(Clone, Debug)]
pub(in super::super) struct Sent {
    pub(in super::super) gateway: usize,
    pub(in super::super) error_ms: i64,
    /// Whether the clock was set between the end of the slot and the sending.
    pub(in super::super) is_set: bool,
    /// Time since the last change of its clock or the log's, and time of writing, in milliseconds.
    pub(in super::super) lasts_ms: i64,
    pub(in super::super) at: i64,
}

/// A message on its way.
#[derive(Debug)]
pub(super) struct InTransit {
    arrives: i64,
    sent: i64,
    gateway: usize,
    input: GatewayInput,
}

#[derive(Clone, Debug, Default)]
pub(super) struct SimulatedGateway {
    pub(super) down_until: i64,
    /// Last slot that was sent, by the gateway's clock.
    slot: i64,
    /// True time up to which datagrams were received.
    heard: i64,
}

/// Header of an input; `None` for other messages.
pub(super) fn header(logged: &LoggedMessage) -> Option<InputHeader> {
    match logged {
        LoggedMessage::Input(input) => InputHeader::of(&input.body()).unwrap(),
        LoggedMessage::Message(_) => None,
    }
}

impl<E: Engine> World<E> {
    /// Adds wrong clocks.
    pub(in super::super) fn with(self, clocks: Clocks) -> Self {
        Self { clocks, ..self }
    }

    /// Adds odd messages: inputs and cell messages of slots that are far away.
    pub(in super::super) fn odd(self) -> Self {
        Self { is_odd: true, ..self }
    }

    /// Messages of gateways, with their sequences.
    pub(in super::super) fn sent(&self) -> impl Iterator<Item = (u64, Option<&Sent>)> {
        (1..).zip(self.log.sent.iter().map(Option::as_ref))
    }

    /// Greatest time by which a slot was written before it was due, in milliseconds of true time.
    pub(in super::super) fn early_ms(&self) -> i64 {
        let due_ms = |output: &CellOutput| {
            SlotGrid::default().open(output.slot.plus(25)).nanos() / 1_000_000 - BEGINS_MS
        };
        let early = self.log.outputs.iter().zip(&self.log.written_at).map(|(output, at)| due_ms(output) - at);
        early.max().unwrap_or_default()
    }

    /// Gateways receive the sensors, and write a message per sensor and slot.
    pub(super) fn gather(&mut self) {
        for gateway in 0..GATEWAYS {
            self.receive_feed(gateway);
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
        for InTransit { arrives, sent, gateway, mut input } in arrived {
            let of_slot_ms = self.clocks.error_ms(ClockOwner::Gateway(gateway), sent);
            // An unacknowledged message is sent again, with a new sending time.
            let is_again = now - arrives > super::STEP_MS;
            let sent = if is_again { now - self.random.random_range(1..40) } else { sent };
            let error_ms = self.clocks.error_ms(ClockOwner::Gateway(gateway), sent);
            let name = format!("g{gateway}");
            input.origin = Some(InputOrigin { gateway: name, sent: time(sent + error_ms), config: 0 });
            let since = |of| self.clocks.since(of, sent);
            let lasts_ms = sent - since(ClockOwner::Gateway(gateway)).max(since(ClockOwner::Log));
            let is_set = of_slot_ms != error_ms;
            let truth = Sent { gateway, error_ms, is_set, lasts_ms, at: now };
            self.log.write(LoggedMessage::Input(input), Some(truth), &mut self.random);
        }
    }

    fn receive_feed(&mut self, index: usize) {
        let error_ms = self.clocks.error_ms(ClockOwner::Gateway(index), self.now);
        let over = (BEGINS_MS + self.now + error_ms).div_euclid(SLOT_MS) - 1;
        let gateway = &mut self.gateways[index];
        if self.now < gateway.down_until || gateway.slot == 0 || (over - gateway.slot).abs() > 8 {
            if self.now < gateway.down_until {
                gateway.heard = self.now;
            }
            // Its clock was set, or it was down: continue from the current slot.
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
        let mut datagrams = Vec::new();
        for (at_ms, from, payload) in &self.feed {
            // A gateway misses some datagrams.
            if within.contains(at_ms) && *from == sensor && self.random.random_bool(0.97) {
                datagrams.push(ReceivedDatagram {
                    received: time(at_ms + error_ms + index as i64),
                    from: "127.0.0.1:5000".parse().unwrap(),
                    to: "239.1.1.1:8048".parse().unwrap(),
                    payload: payload.clone(),
                });
            }
        }
        let input =
            GatewayInput { origin: None, sensor, slot: Slot(slot), part: 0, is_last: true, datagrams };
        let delay = if self.random.random_bool(0.02) { 400 } else { 40 };
        let arrives = self.now + self.random.random_range(1..delay);
        self.sent.push_back(InTransit { arrives, sent: self.now, gateway: index, input });
    }

    /// Writes messages that no member would write: inputs and cell messages of slots that are far away.
    fn intrude(&mut self) {
        let far = [14_400, 40, -14_400, -400_000_000, i64::MAX - 1, i64::MIN][self.random.random_range(0..6)];
        let slot = Slot(((BEGINS_MS + self.now) / SLOT_MS).saturating_add(far));
        let name = CellName::new("toy").unwrap();
        let content = CellMessageContent::Reject { id: "x".to_owned() };
        let logged = match self.random.random_range(0..3) {
            0 if far > 1_000 => LoggedMessage::Message(
                CellMessage { from: name.clone(), to: name, slot, index: 9, content }.into(),
            ),
            kind => {
                let gateway = format!("x{}", self.random.random_range(0..1000));
                let sent = time(self.now + self.random.random_range(-900_000..900_000));
                let origin = (kind == 1).then_some(InputOrigin { gateway, sent, config: 0 });
                let sensor = DataSource { sac: 9, sic: self.random.random_range(0..3) };
                LoggedMessage::Input(GatewayInput {
                    origin,
                    sensor,
                    slot,
                    part: 0,
                    is_last: true,
                    datagrams: Vec::new(),
                })
            }
        };
        self.log.write(logged, None, &mut self.random);
    }
}
