//! `[[output.sapient]]`: SAPIENT over TCP, to a fusion node or a middleware that takes nodes.
//!
//! A connection begins with a Registration. Once it is acknowledged a DetectionReport goes out per track and second, and a
//! StatusReport every few seconds.

use std::collections::BTreeMap;
use std::sync::Arc;

use jiff::SignedDuration;

use super::Sink;
use super::desk::Desk;
use super::second::Second;
use super::stream::{Dialogue, Peer, Said};
use crate::config::{self, Config};
use crate::formats::sapient::SapientWriter;
use crate::formats::sapient::frames::{Frames, append};
use crate::formats::sapient::messages::{Content, DetectionReport, Info, System};
use crate::live::Level;
use crate::net::dial::Dial;
use crate::net::peers::is_local;
use fusion::time::Time;

/// A receiver that has not acknowledged the registration by then does not want it.
const PATIENCE: SignedDuration = SignedDuration::from_secs(10);

/// Opens a sink; nobody is connected to yet.
pub(super) fn open(sapient: &config::Sapient, config: &Config) -> Sink {
    let desk = Arc::new(Desk::new(format!("sapient:{}", sapient.id), sapient.picture));
    let writer = SapientWriter {
        node_id: sapient.node_id.clone(),
        site: config.site.name.clone(),
        status_interval_s: sapient.status_interval.as_secs_f32(),
        latency_s: config.fusion.latency_of(sapient.picture).as_secs_f32(),
    };
    let dialogue = Conversation::new(writer, sapient.status_interval);
    let dial = Dial::plain(&sapient.url.host, sapient.url.port);
    Sink::Peer(Peer { desk, dial, dialogue: Box::new(dialogue) })
}

/// For people.
pub(super) fn line(sapient: &config::Sapient) -> String {
    format!("picture to sapient:{}: {}, {}", sapient.id, sapient.url, sapient.picture.name())
}

/// What works and should not stay so.
pub(super) fn warning(sapient: &config::Sapient) -> Option<String> {
    let travels = !is_local(&sapient.url.host);
    travels.then(|| format!("sapient:{}: the picture travels beyond this machine without TLS", sapient.id))
}

/// What is said on a connection, and where it stands.
#[derive(Debug)]
struct Conversation {
    writer: SapientWriter,
    interval: SignedDuration,
    frames: Frames,
    /// When the registration was sent, on this connection.
    asked: Time,
    is_registered: bool,
    /// The last status report, and what it said.
    told: Option<(Time, System)>,
    /// The last report of each track that was in the picture a second ago.
    shown: BTreeMap<String, DetectionReport>,
}

impl Conversation {
    fn new(writer: SapientWriter, interval: SignedDuration) -> Self {
        Self {
            writer,
            interval,
            frames: Frames::default(),
            asked: Time::default(),
            is_registered: false,
            told: None,
            shown: BTreeMap::new(),
        }
    }

    fn append(&self, at: Time, content: Content, said: &mut Said) {
        append(&self.writer.message(at, content), &mut said.octets);
        said.messages += 1;
    }

    /// A status report where one is due, or has something new to say.
    fn tell_status(&mut self, at: Time, level: Level, said: &mut Said) {
        let system = match level {
            Level::Ok => System::Ok,
            Level::Degraded => System::Warning,
            Level::NotReady => System::Error,
        };
        let info = match self.told {
            Some((told, before)) if before == system => {
                // A second early rather than late: seconds are not quite equally long.
                if at - told < self.interval && at >= told {
                    return;
                }
                Info::Unchanged
            }
            _ => Info::New,
        };
        self.told = Some((at, system));
        self.append(at, Content::StatusReport(self.writer.status(at, system, info)), said);
    }
}

impl Dialogue for Conversation {
    fn begin(&mut self, now: Time) -> Vec<u8> {
        (self.asked, self.is_registered, self.told) = (now, false, None);
        self.frames = Frames::default();
        self.shown.clear();
        let mut said = Said::default();
        self.append(now, Content::Registration(self.writer.registration()), &mut said);
        said.octets
    }

    fn say(&mut self, second: &Second) -> Result<Said, String> {
        let (mut said, at) = (Said::default(), second.due);
        if !self.is_registered {
            if at - self.asked > PATIENCE {
                return Err(format!("no RegistrationAck within {} s", PATIENCE.as_secs()));
            }
            said.is_withheld = true;
            return Ok(said);
        }
        self.tell_status(at, second.level, &mut said);
        let mut before = std::mem::take(&mut self.shown);
        for track in second.tracks() {
            let Some(report) = self.writer.detection(track, &second.maker) else {
                said.left_out += 1;
                continue;
            };
            let object = report.object_id.clone().unwrap_or_default();
            before.remove(&object);
            self.shown.insert(object, report.clone());
            self.append(at, Content::DetectionReport(report), &mut said);
        }
        for last in before.into_values() {
            let report = self.writer.lost(at, last);
            self.append(at, Content::DetectionReport(report), &mut said);
        }
        Ok(said)
    }

    fn hear(&mut self, octets: &[u8], now: Time) -> Result<Vec<u8>, String> {
        self.frames.take(octets);
        let mut said = Said::default();
        while let Some(message) = self.frames.next()? {
            match message.content {
                Some(Content::RegistrationAck(ack)) if ack.acceptance == Some(true) => {
                    self.is_registered = true;
                }
                Some(Content::RegistrationAck(ack)) => {
                    let why = ack.ack_response_reason.join("; ");
                    return Err(format!("the registration is refused: {}", or_nothing(&why)));
                }
                Some(Content::Error(error)) => {
                    let why = error.error_message.join("; ");
                    return Err(format!("the receiver reports an error: {}", or_nothing(&why)));
                }
                Some(Content::Task(task)) => {
                    let refusal = self.writer.refusal(task.task_id);
                    self.append(now, Content::TaskAck(refusal), &mut said);
                }
                // Reports of others, and what newer versions have.
                _ => {}
            }
        }
        Ok(said.octets)
    }

    fn end(&mut self, now: Time) -> Vec<u8> {
        let mut said = Said::default();
        if self.is_registered {
            let status = self.writer.status(now, System::Goodbye, Info::New);
            self.append(now, Content::StatusReport(status), &mut said);
        }
        said.octets
    }
}

/// What a receiver says goes to log and alerts: one line, not endless.
fn or_nothing(why: &str) -> String {
    let line: String = why.chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect();
    if line.trim().is_empty() { "it does not say why".to_owned() } else { line }
}
