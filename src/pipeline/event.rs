//! Events on the way in: one type is both the log line and the counter.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use asterix::{DataSource, Fault};
use serde::{Deserialize, Serialize};
use tracing::warn;

use super::remote_id::LineFault;
use super::senders::{Contest, ContestReason, Takeover};
use crate::names::known;
use crate::normalise::{Refusal, Service};
use fusion::point::Newcomers;
use fusion::{Report, SensorIndex};

/// Something that happened to what was received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A datagram, or a record of a file without reception times, of this many octets came.
    Received {
        /// Octets of the payload.
        octets: usize,
    },
    /// The same datagram as one handled at most 2 s before: dropped.
    DuplicateDatagram,
    /// A block or record that cannot be read; the rest of its block or datagram is lost with it.
    Faulty {
        /// What is wrong; its offset counts from the start of the payload.
        fault: Fault,
    },
    /// A line of a Remote ID gateway, or a message, that cannot be read; those beside it stand.
    FaultyLine {
        /// What is wrong.
        fault: LineFault,
    },
    /// A block of a category that is not used: skipped by its LEN.
    SkippedBlock {
        /// Its category.
        category: u8,
    },
    /// A CAT129 block with more than the one record its edition allows; all are read.
    SeveralRecords,
    /// A record became a report.
    Accepted {
        /// From this sensor.
        sensor: SensorIndex,
        /// What the engine was given.
        report: Report,
    },
    /// A record became a report that is for other cells.
    Elsewhere {
        /// From this sensor.
        sensor: SensorIndex,
        /// What they are given.
        report: Report,
    },
    /// A record became a report that is left out, because the machine cannot keep up.
    Shed {
        /// From this sensor.
        sensor: SensorIndex,
        /// What the engine is not given.
        report: Report,
    },
    /// A service message of a radar (CAT034), or who a drone is (Remote ID).
    Service {
        /// The sensor.
        sensor: SensorIndex,
        /// What a radar said of itself.
        service: Service,
        /// The sender, where it is known.
        from: Option<SocketAddr>,
    },
    /// A record gave no report.
    Refused {
        /// From this sensor, where it is known.
        sensor: Option<SensorIndex>,
        /// Why.
        refusal: Refusal,
    },
    /// A sender is refused under a SAC/SIC: noted once, each refused record is a [`Event::Refused`].
    Contested(Contest),
    /// A sender speaks for a radar or a camera in place of another one, which had fallen silent.
    TookOver(Takeover),
    /// Fates of a transponder receiver's new identities, with a slot.
    Newcomers(Newcomers),
    /// Nothing came for longer than the window, or the clock of reception was set by more: the engine started afresh with
    /// an empty window.
    Restarted,
    /// The clock of reception stepped back by more than 1 s: the engine waits until it is caught up, or until it
    /// is certain that the clock was set back by more than the window.
    ClockBehind {
        /// How far, nanoseconds.
        behind_ns: i64,
    },
}

impl Event {
    /// Whether an operator should hear of it.
    pub fn is_warning(&self) -> bool {
        self.kind() != "other"
    }

    /// The kind of a warning, for people: warnings of one kind may stand for one another.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Faulty { fault } => fault.kind.name(),
            Self::FaultyLine { fault } => fault.name(),
            Self::Contested(Contest { reason: ContestReason::OtherSender, .. }) => "two_senders",
            Self::Contested(_) => "foreign_source",
            Self::TookOver(_) => "took_over",
            Self::Restarted => "restarted",
            Self::ClockBehind { .. } => "clock_behind",
            _ => "other",
        }
    }

    /// Writes a warning to the log; what is no warning is only counted.
    pub fn log(&self) {
        match self {
            Self::Faulty { fault: Fault { category, item, offset, kind } } => {
                warn!(octet = offset, category, item, reason = kind.name(), detail = %kind, "unreadable ASTERIX");
            }
            Self::FaultyLine { fault } => {
                warn!(reason = fault.name(), detail = %fault, "unreadable Remote ID");
            }
            Self::Contested(contest) => {
                let Contest { source: DataSource { sac, sic }, category, counts, refused, identity, .. } =
                    contest;
                let transponder = identity.map(|identity| identity.name().escape_ascii().to_string());
                match contest.reason {
                    ContestReason::OtherSender => warn!(
                        sac, sic, category, transponder, first = %counts, %refused,
                        "two senders say different things under one SAC/SIC: the one heard first counts"
                    ),
                    ContestReason::ForeignSource => warn!(
                        sac, sic, category, %counts, %refused,
                        "a host that is not the sensor's source sends under its SAC/SIC: it is refused"
                    ),
                }
            }
            Self::TookOver(Takeover { source: DataSource { sac, sic }, before, after, .. }) => {
                warn!(sac, sic, %before, %after, "the sender of a sensor fell silent, and another one took its place");
            }
            Self::Restarted => {
                warn!(
                    "started afresh with an empty window: nothing came for longer than it lasts, or the clock was set by more"
                );
            }
            Self::ClockBehind { behind_ns } => {
                let behind_s = *behind_ns as f64 * 1e-9;
                warn!(
                    behind_s,
                    "the clock of reception stepped back: nothing is published until it is caught up, or has stayed 25 s behind for 5 s"
                );
            }
            _ => {}
        }
    }
}

/// Counts of events. Everything dropped is in here by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Datagrams (or records of files without reception times).
    pub received: u64,
    /// Their octets.
    pub octets: u64,
    /// Repeated datagrams.
    pub duplicates: u64,
    /// Unreadable blocks and records, by category and reason.
    #[serde(deserialize_with = "known")]
    pub faults: BTreeMap<(Option<u8>, &'static str), u64>,
    /// Blocks skipped by their LEN, by category.
    pub skipped: BTreeMap<u8, u64>,
    /// CAT129 blocks with more than one record.
    pub several_records: u64,
    /// Reports, by sensor.
    pub accepted: BTreeMap<SensorIndex, u64>,
    /// Reports for other cells, by sensor.
    pub elsewhere: BTreeMap<SensorIndex, u64>,
    /// Plots that were left out because the machine could not keep up, by sensor.
    pub shed: BTreeMap<SensorIndex, u64>,
    /// Service messages (CAT034) and Basic IDs (Remote ID), by sensor.
    pub service: BTreeMap<SensorIndex, u64>,
    /// Records without a report, by sensor and reason.
    #[serde(deserialize_with = "known")]
    pub refused: BTreeMap<(Option<SensorIndex>, &'static str), u64>,
    /// Records of no configured sensor, by category and source; these are not in `refused`.
    pub unknown_sources: BTreeMap<(u8, DataSource), u64>,
    /// New identities by transponder receiver and fate ([`Newcomers::fates`]).
    #[serde(deserialize_with = "known")]
    pub newcomers: BTreeMap<(SensorIndex, &'static str), u64>,
    /// Fresh starts after a silence longer than the window.
    pub restarts: u64,
    /// Times the clock of reception stepped back by more than 1 s.
    pub clock_behind: u64,
}

impl Tally {
    /// Counts an event.
    pub fn count(&mut self, event: &Event) {
        match *event {
            Event::Received { octets } => {
                self.received += 1;
                self.octets += octets as u64;
            }
            Event::DuplicateDatagram => self.duplicates += 1,
            Event::Faulty { fault } => add(&mut self.faults, (fault.category, fault.kind.name())),
            Event::FaultyLine { fault } => add(&mut self.faults, (None, fault.name())),
            Event::SkippedBlock { category } => add(&mut self.skipped, category),
            Event::SeveralRecords => self.several_records += 1,
            Event::Accepted { sensor, .. } => add(&mut self.accepted, sensor),
            Event::Elsewhere { sensor, .. } => add(&mut self.elsewhere, sensor),
            Event::Shed { sensor, .. } => add(&mut self.shed, sensor),
            Event::Service { sensor, .. } => add(&mut self.service, sensor),
            Event::Refused { refusal: Refusal::UnknownSource { category, source }, .. } => {
                add(&mut self.unknown_sources, (category, source));
            }
            Event::Refused { sensor, refusal, .. } => add(&mut self.refused, (sensor, refusal.name())),
            // What is refused for it is counted record by record.
            Event::Contested(_) | Event::TookOver(_) => {}
            Event::Newcomers(newcomers) => {
                for (fate, count) in newcomers.fates().into_iter().filter(|&(_, count)| count > 0) {
                    *self.newcomers.entry((newcomers.sensor, fate)).or_default() += u64::from(count);
                }
            }
            Event::Restarted => self.restarts += 1,
            Event::ClockBehind { .. } => self.clock_behind += 1,
        }
    }

    /// Identities that were dropped without having been admitted; their reports count as accepted.
    pub fn newcomers_dropped(&self) -> u64 {
        let is_dropped = |fate: &str| !matches!(fate, "heard" | "admitted");
        self.newcomers.iter().map(|((_, fate), &count)| if is_dropped(fate) { count } else { 0 }).sum()
    }

    /// Datagrams, blocks and records dropped for whatever reason, and identities that were not admitted.
    pub fn dropped(&self) -> u64 {
        self.duplicates
            + self.faults.values().sum::<u64>()
            + self.skipped.values().sum::<u64>()
            + self.refused.values().sum::<u64>()
            + self.unknown_sources.values().sum::<u64>()
            + self.shed.values().sum::<u64>()
            + self.newcomers_dropped()
    }
}

fn add<K: Ord>(counters: &mut BTreeMap<K, u64>, key: K) {
    *counters.entry(key).or_default() += 1;
}
