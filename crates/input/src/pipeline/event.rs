//! Events of the pipeline: one type serves as log line and counter.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use asterix::{DataSource, Fault};
use serde::{Deserialize, Serialize};
use tracing::warn;

use super::remote_id::LineFault;
use super::senders::{Contest, ContestReason, Takeover};
use crate::names::known;
use crate::normalise::{Refusal, Service};
use fusion::point::{JumpingTracks, Newcomers};
use fusion::{Report, SensorIndex};

/// An event in the handling of received data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A datagram, or a record of a file without reception times, was received.
    Received {
        /// Octets of the payload.
        octets: usize,
    },
    /// A copy of a datagram that was handled at most 2 s earlier: dropped.
    DuplicateDatagram,
    /// A block or record cannot be read; the rest of its block or datagram is lost with it.
    Faulty {
        /// The fault; its offset is relative to the start of the payload.
        fault: Fault,
    },
    /// A line of a Remote ID gateway, or a message, cannot be read; the others of the datagram are used.
    FaultyLine {
        /// The fault.
        fault: LineFault,
    },
    /// A block of a category that is not used: skipped by its LEN.
    SkippedBlock {
        /// Its category.
        category: u8,
    },
    /// A CAT129 block holds more than the one record that its edition allows; all are read.
    SeveralRecords,
    /// A record became a report.
    Accepted {
        /// The sensor.
        sensor: SensorIndex,
        /// The report passed to the engine.
        report: Report,
    },
    /// A record became a report that belongs to other cells.
    Elsewhere {
        /// The sensor.
        sensor: SensorIndex,
        /// The report.
        report: Report,
    },
    /// A record became a report that is not passed to the engine, because the node is overloaded.
    Shed {
        /// The sensor.
        sensor: SensorIndex,
        /// The report.
        report: Report,
    },
    /// A service message of a radar (CAT034), or an identification of a drone or operator (Remote ID).
    Service {
        /// The sensor.
        sensor: SensorIndex,
        /// Content of the radar's message.
        service: Service,
        /// The sender, if known.
        from: Option<SocketAddr>,
    },
    /// A record yielded no report.
    Refused {
        /// The sensor, if known.
        sensor: Option<SensorIndex>,
        /// The reason.
        refusal: Refusal,
    },
    /// A sender is refused for a SAC/SIC. Reported once; each refused record is also a [`Event::Refused`].
    Contested(Contest),
    /// A sender has replaced another sender of a radar or camera, which had fallen silent.
    TookOver(Takeover),
    /// New identities of a transponder receiver admitted or dropped, reported with a slot.
    Newcomers(Newcomers),
    /// Radar tracks discarded because their numbers jump, reported with a slot.
    JumpingTracks(JumpingTracks),
    /// No data was received for longer than the window, or the clock of reception was set by more than that: the engine
    /// restarted with an empty window.
    Restarted,
    /// The clock of reception stepped back by more than 1 s. The engine waits until the clock has caught up, or until it is
    /// certain that the clock was set back by more than the window.
    ClockBehind {
        /// Size of the step, in nanoseconds.
        behind_ns: i64,
    },
}

impl Event {
    /// Whether the event is logged as a warning.
    pub fn is_warning(&self) -> bool {
        self.kind() != "other"
    }

    /// Kind of a warning, in words. Warnings of the same kind may represent one another.
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

    /// Logs a warning; other events are only counted.
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

/// Counts of events. All data dropped is counted here by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Number of datagrams (or records of files without reception times).
    pub received: u64,
    /// Number of octets in them.
    pub octets: u64,
    /// Number of repeated datagrams.
    pub duplicates: u64,
    /// Unreadable blocks and records, by category and reason.
    #[serde(deserialize_with = "known")]
    pub faults: BTreeMap<(Option<u8>, &'static str), u64>,
    /// Blocks skipped by their LEN, by category.
    pub skipped: BTreeMap<u8, u64>,
    /// CAT129 blocks with more than one record.
    pub several_records: u64,
    /// Reports accepted, by sensor.
    pub accepted: BTreeMap<SensorIndex, u64>,
    /// Reports for other cells, by sensor.
    pub elsewhere: BTreeMap<SensorIndex, u64>,
    /// Plots not passed to the engine because of overload, by sensor.
    pub shed: BTreeMap<SensorIndex, u64>,
    /// Service messages (CAT034) and Basic IDs (Remote ID), by sensor.
    pub service: BTreeMap<SensorIndex, u64>,
    /// Records without a report, by sensor and reason.
    #[serde(deserialize_with = "known")]
    pub refused: BTreeMap<(Option<SensorIndex>, &'static str), u64>,
    /// Records of sensors that are not configured, by category and source; they are not in `refused`.
    pub unknown_sources: BTreeMap<(u8, DataSource), u64>,
    /// New identities by transponder receiver and fate ([`Newcomers::fates`]).
    #[serde(deserialize_with = "known")]
    pub newcomers: BTreeMap<(SensorIndex, &'static str), u64>,
    /// Radar tracks discarded because their numbers jump, by sensor; their plots count as accepted.
    pub jumping_tracks: BTreeMap<SensorIndex, u64>,
    /// Restarts of the engine after a silence longer than the window, or after a step of the clock by more than that.
    pub restarts: u64,
    /// Number of times the clock of reception stepped back by more than 1 s.
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
            // The refusals of a contest are counted record by record.
            Event::Contested(_) | Event::TookOver(_) => {}
            Event::Newcomers(newcomers) => {
                for (fate, count) in newcomers.fates().into_iter().filter(|&(_, count)| count > 0) {
                    *self.newcomers.entry((newcomers.sensor, fate)).or_default() += u64::from(count);
                }
            }
            Event::JumpingTracks(JumpingTracks { sensor, discarded }) => {
                *self.jumping_tracks.entry(sensor).or_default() += u64::from(discarded);
            }
            Event::Restarted => self.restarts += 1,
            Event::ClockBehind { .. } => self.clock_behind += 1,
        }
    }

    /// Identities dropped without having been admitted; their reports count as accepted.
    pub fn newcomers_dropped(&self) -> u64 {
        let is_dropped = |fate: &str| !matches!(fate, "heard" | "admitted");
        self.newcomers.iter().map(|((_, fate), &count)| if is_dropped(fate) { count } else { 0 }).sum()
    }

    /// Number of datagrams, blocks and records dropped for any reason, of identities not admitted, and of radar tracks discarded.
    pub fn dropped(&self) -> u64 {
        self.dropped_by_reason().values().sum()
    }

    /// The number of [`Self::dropped`] by reason, without the reasons that did not occur.
    pub fn dropped_by_reason(&self) -> BTreeMap<&'static str, u64> {
        let faults = self.faults.iter().map(|(&(_, kind), &count)| (kind, count));
        let refused = self.refused.iter().map(|(&(_, reason), &count)| (reason, count));
        let newcomers = self.newcomers.iter().map(|(&(_, fate), &count)| (fate, count));
        let others = [
            ("duplicate", self.duplicates),
            ("unused_category", self.skipped.values().sum()),
            ("unknown_source", self.unknown_sources.values().sum()),
            ("overload", self.shed.values().sum()),
            ("jumping_track", self.jumping_tracks.values().sum()),
        ];
        let newcomers = newcomers.filter(|(fate, _)| !matches!(*fate, "heard" | "admitted"));
        let mut reasons = BTreeMap::new();
        for (reason, count) in faults.chain(refused).chain(newcomers).chain(others).filter(|&(_, n)| n > 0) {
            *reasons.entry(reason).or_default() += count;
        }
        reasons
    }
}

fn add<K: Ord>(counters: &mut BTreeMap<K, u64>, key: K) {
    *counters.entry(key).or_default() += 1;
}
