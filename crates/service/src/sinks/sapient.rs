//! `[[output.sapient]]`: SAPIENT over TCP, to a fusion node or to middleware that accepts nodes.
//!
//! A connection begins with a Registration. Once it is acknowledged, a DetectionReport is sent per track and second, and a
//! StatusReport every few seconds.

use std::collections::BTreeMap;
use std::sync::Arc;

use jiff::SignedDuration;

use super::PictureSink;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use super::stream::{Dialogue, EncodedSecond, StreamSink};
use crate::live::ServiceLevel;
use crate::net::dial::Dialer;
use crate::net::peers::is_local;
use fusion::time::Time;
use picture::formats::sapient::SapientWriter;
use picture::formats::sapient::frames::{SapientFrames, append};
use picture::formats::sapient::messages::{DetectionReport, ReportInfo, SapientContent, SapientSystemState};
use site::config::{self, Config};

/// Timeout for the acknowledgement of the registration; after it the registration counts as refused.
const PATIENCE: SignedDuration = SignedDuration::from_secs(10);

/// Opens a sink; no connection is made yet.
pub(super) fn open(sapient: &config::Sapient, config: &Config) -> PictureSink {
    let queue = Arc::new(SinkQueue::new(format!("sapient:{}", sapient.id), sapient.picture));
    let writer = SapientWriter {
        node_id: sapient.node_id.clone(),
        site: config.site.name.clone(),
        status_interval_s: sapient.status_interval.as_secs_f32(),
        latency_s: config.fusion.latency_of(sapient.picture).as_secs_f32(),
    };
    let dialogue = SapientDialogue::new(writer, sapient.status_interval);
    let dial = Dialer::plain(&sapient.url.host, sapient.url.port);
    PictureSink::Peer(StreamSink { queue, dial, dialogue: Box::new(dialogue) })
}

/// A description of the sink.
pub(super) fn line(sapient: &config::Sapient) -> String {
    format!("picture to sapient:{}: {}, {}", sapient.id, sapient.url, sapient.picture.name())
}

/// A weakness of the configuration that the operator should remove.
pub(super) fn warning(sapient: &config::Sapient) -> Option<String> {
    let travels = !is_local(&sapient.url.host);
    travels.then(|| format!("sapient:{}: the picture travels beyond this machine without TLS", sapient.id))
}

/// Protocol state of a connection.
#[derive(Debug)]
struct SapientDialogue {
    writer: SapientWriter,
    interval: SignedDuration,
    frames: SapientFrames,
    /// Time at which the registration was sent on this connection.
    asked: Time,
    is_registered: bool,
    /// Time and state of the last status report.
    told: Option<(Time, SapientSystemState)>,
    /// Last report of each track in the previous second's picture.
    shown: BTreeMap<String, DetectionReport>,
}

impl SapientDialogue {
    fn new(writer: SapientWriter, interval: SignedDuration) -> Self {
        Self {
            writer,
            interval,
            frames: SapientFrames::default(),
            asked: Time::default(),
            is_registered: false,
            told: None,
            shown: BTreeMap::new(),
        }
    }

    fn append(&self, at: Time, content: SapientContent, said: &mut EncodedSecond) {
        append(&self.writer.message(at, content), &mut said.octets);
        said.messages += 1;
    }

    /// Sends a status report if one is due, or the state has changed.
    fn tell_status(&mut self, at: Time, level: ServiceLevel, said: &mut EncodedSecond) {
        let system = match level {
            ServiceLevel::Ok => SapientSystemState::Ok,
            ServiceLevel::Degraded => SapientSystemState::Warning,
            ServiceLevel::NotReady => SapientSystemState::Error,
        };
        let info = match self.told {
            Some((told, before)) if before == system => {
                // Seconds differ a little in length: better a second early than late.
                if at - told < self.interval && at >= told {
                    return;
                }
                ReportInfo::Unchanged
            }
            _ => ReportInfo::New,
        };
        self.told = Some((at, system));
        self.append(at, SapientContent::StatusReport(self.writer.status(at, system, info)), said);
    }
}

impl Dialogue for SapientDialogue {
    fn begin(&mut self, now: Time) -> Vec<u8> {
        (self.asked, self.is_registered, self.told) = (now, false, None);
        self.frames = SapientFrames::default();
        self.shown.clear();
        let mut said = EncodedSecond::default();
        self.append(now, SapientContent::Registration(self.writer.registration()), &mut said);
        said.octets
    }

    fn encode(&mut self, second: &PictureSecond) -> Result<EncodedSecond, String> {
        let (mut said, at) = (EncodedSecond::default(), second.due);
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
            self.append(at, SapientContent::DetectionReport(report), &mut said);
        }
        for last in before.into_values() {
            let report = self.writer.lost(at, last);
            self.append(at, SapientContent::DetectionReport(report), &mut said);
        }
        Ok(said)
    }

    fn handle(&mut self, octets: &[u8], now: Time) -> Result<Vec<u8>, String> {
        self.frames.take(octets);
        let mut said = EncodedSecond::default();
        while let Some(message) = self.frames.next_message()? {
            match message.content {
                Some(SapientContent::RegistrationAck(ack)) if ack.acceptance == Some(true) => {
                    self.is_registered = true;
                }
                Some(SapientContent::RegistrationAck(ack)) => {
                    let why = ack.ack_response_reason.join("; ");
                    return Err(format!("the registration is refused: {}", or_nothing(&why)));
                }
                Some(SapientContent::Error(error)) => {
                    let why = error.error_message.join("; ");
                    return Err(format!("the receiver reports an error: {}", or_nothing(&why)));
                }
                Some(SapientContent::Task(task)) => {
                    let refusal = self.writer.refusal(task.task_id);
                    self.append(now, SapientContent::TaskAck(refusal), &mut said);
                }
                // Reports of other nodes, and messages of newer versions.
                _ => {}
            }
        }
        Ok(said.octets)
    }

    fn end(&mut self, now: Time) -> Vec<u8> {
        let mut said = EncodedSecond::default();
        if self.is_registered {
            let status = self.writer.status(now, SapientSystemState::Goodbye, ReportInfo::New);
            self.append(now, SapientContent::StatusReport(status), &mut said);
        }
        said.octets
    }
}

/// Makes a receiver's text safe for log and alerts: one line of limited length.
fn or_nothing(why: &str) -> String {
    let line: String = why.chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect();
    if line.trim().is_empty() { "it does not say why".to_owned() } else { line }
}
