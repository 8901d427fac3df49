//! Engine of a cell: a site's driver, whose pictures are published as octets.

use std::collections::VecDeque;
use std::net::SocketAddr;

use bytes::Bytes;
use fusion::Identity;
use fusion::numbering::Given;
use fusion::point::Source;
use fusion::slots::Slot;
use fusion::time::Time;

use super::cell::CellEngine;
use super::message::ReceivedDatagram;
use super::overload::SheddingLevel;
use super::region::{Border, CellMessage, CellMessageContent, EngineView, ValueSharing};
use super::report::CellReport;
use input::capture::{Reception, ReceptionKind};
use input::pipeline::{NotRestored, Selection};
use picture::Picture;
use service::live::{Driver, DriverEvent, PublishedPicture, Status, TrustAssessments};
use service::net::listen::lines;
use service::state::SavedRegistrations;
use site::areas::Masks;
use site::config::Config;

/// Content of a checkpoint: driver, border, pending decisions, level of load shedding.
type CheckpointContent = (Bytes, Option<Vec<u8>>, Vec<CellMessageContent>, u8);

/// A site's driver as a cell's engine.
#[derive(Debug)]
pub struct SiteEngine {
    config: Config,
    driver: Driver,
    /// Destination address of each line.
    lines: Vec<SocketAddr>,
    slots: VecDeque<(Slot, Vec<u8>, Vec<CellMessage>)>,
    /// Messages to other cells, written by the slot that was polled last.
    messages: Vec<CellMessage>,
    /// Border of the cell; `None` if there are no other cells.
    border: Option<Border>,
    value_sharing: ValueSharing,
    /// Level of load shedding.
    level: SheddingLevel,
    /// Operator decisions that take effect at later slots, in order of arrival.
    pending_decisions: Vec<CellMessageContent>,
}

impl SiteEngine {
    /// Creates an engine for a site, without data. `started` is the current time.
    pub fn new(config: Config, masks: Masks, started: Time) -> Self {
        let lines = lines(&config);
        Self {
            driver: Driver::new(&config, masks, started, lines.len()),
            lines: lines.iter().map(|line| line.destination().into()).collect(),
            config,
            slots: VecDeque::new(),
            messages: Vec::new(),
            border: None,
            value_sharing: ValueSharing::default(),
            level: SheddingLevel::default(),
            pending_decisions: Vec::new(),
        }
    }

    /// Makes this the engine of a cell among others: it uses data in and around the cell, and publishes the cell's own aircraft.
    #[must_use]
    pub fn bordering(self, border: Border) -> Self {
        let region = border.region();
        let selection = Selection::new(region.outline().clone(), region.halo_m);
        let value_sharing = ValueSharing::new(&self.config, region);
        let driver = self.driver.selecting(selection);
        Self { driver, border: Some(border), value_sharing, ..self }.sharing()
    }

    /// Uses the sensor values that other cells share instead of those that this engine learns.
    #[must_use]
    pub fn sharing(mut self) -> Self {
        self.driver.engine_mut().share_values();
        self
    }

    /// Border of the cell, if there are other cells.
    pub const fn border(&self) -> Option<&Border> {
        self.border.as_ref()
    }

    /// Serialises the state. No slot may be waiting to be polled.
    pub fn checkpoint(&self) -> Vec<u8> {
        let border = self.border.as_ref().map(Border::checkpoint);
        postcard::to_stdvec(&(
            self.driver.checkpoint(&self.config),
            border,
            &self.pending_decisions,
            self.level.0,
        ))
        .expect("every state can be written down")
    }

    /// Restores the state from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another version, or the site or its settings have changed.
    pub fn restored(mut self, masks: Masks, checkpoint: &[u8]) -> Result<Self, NotRestored> {
        let written: CheckpointContent =
            postcard::from_bytes(checkpoint).map_err(|_| NotRestored::Unreadable)?;
        let (driver, border, pending_decisions, level) = written;
        self.driver.restore(&self.config, masks, &driver)?;
        let is_whole = match (&mut self.border, border) {
            (Some(own), Some(octets)) => own.restore(&octets),
            (own, octets) => own.is_none() && octets.is_none(),
        };
        (self.pending_decisions, self.level) = (pending_decisions, SheddingLevel(level));
        if is_whole { Ok(self) } else { Err(NotRestored::Site) }
    }

    /// Extracts the driver's state from a checkpoint, as [`Driver::restore`] takes it. `None` if it is not of this version.
    pub fn driver_in(checkpoint: &[u8]) -> Option<Bytes> {
        let written: CheckpointContent = postcard::from_bytes(checkpoint).ok()?;
        Some(written.0)
    }

    /// Applies the operator decisions that take effect at the next slot or earlier.
    fn apply_decisions(&mut self) {
        let Some(next) = self.driver.next_slot() else { return };
        let driver = &mut self.driver;
        self.pending_decisions.retain(|content| match *content {
            // The decision has no effect if its subject has ended.
            CellMessageContent::Correlate { from, correlation } if from <= next => {
                _ = driver.correlate(correlation);
                false
            }
            CellMessageContent::SetTrust { from, decision } if from <= next => {
                _ = driver.set_trust(decision);
                false
            }
            _ => true,
        });
    }

    /// Takes from a state that is too old to continue what survives a gap: numbers, registration, decisions.
    pub fn restore_lasting(&mut self, masks: Masks, checkpoint: &[u8], now: Time) {
        let mut before = Driver::new(&self.config, masks.clone(), now, self.lines.len());
        let Ok((driver, border, ..)) = postcard::from_bytes::<CheckpointContent>(checkpoint) else { return };
        self.border.iter_mut().zip(border).for_each(|(own, octets)| own.restore_numbers(&octets));
        if before.restore(&self.config, masks, &driver).is_err() {
            return;
        }
        let engine = before.pipeline().engine();
        let mut numbers = engine.numbers().given().collect();
        self.driver.remember(&mut numbers);
        self.driver.engine_mut().remember_track_numbers(engine.track_numbers());
        SavedRegistrations::of(&self.config, engine).restore(
            &self.config,
            Some(now),
            self.driver.engine_mut(),
        );
        self.driver.engine_mut().resume(engine.saved_associations());
        self.driver.engine_mut().plan_trust_overrides(
            engine.trust_overrides().iter().map(|held| (held.since, held.word)).collect(),
        );
    }

    /// The owner's report of the cell.
    pub fn report(&mut self, node: &str, epoch: u64, at: Time) -> CellReport {
        let sensors = self.driver.sensors(at, |_| Vec::new());
        let engine = self.driver.pipeline().engine();
        let status = Status {
            at,
            sensors,
            unknown: self.driver.health().unknown(),
            tally: self.driver.pipeline().tally().clone(),
            numbers_used: engine.numbers().used(),
            lateness_s: None,
            failed_sends: 0,
            troubles: Vec::new(),
        };
        let mut integrities = TrustAssessments::of(&self.driver, self.driver.latest());
        if let Some(border) = &self.border {
            integrities.assessments.retain_mut(|assessment| border.to_public(assessment));
        }
        CellReport { node: node.to_owned(), epoch, status, integrities, correlations: engine.correlations() }
    }

    /// The next slot to be made.
    pub fn next_slot(&self) -> Option<Slot> {
        self.driver.next_slot()
    }

    /// Transponder numbers in use.
    pub fn numbers(&self) -> Vec<Given> {
        self.driver.pipeline().engine().numbers().given().collect()
    }

    /// This cell's share of the region's numbers ([`Border::claims`]); empty if there is only one cell.
    pub fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        self.border.as_ref().map(Border::claims).unwrap_or_default()
    }

    /// Index of the line with this destination address. A datagram from a line that is not configured is assigned by its content.
    pub(super) fn line(&self, to: SocketAddr) -> usize {
        self.lines.iter().position(|line| *line == to).unwrap_or_default()
    }

    fn collect_slots(&mut self) {
        while let Some(slots) = self.driver.poll() {
            if let DriverEvent::Slot(PublishedPicture { mut picture, now, .. }) = slots {
                let slot = picture.slot;
                let mut now = now.get().map(|now| Picture::clone(&now));
                if self.level >= SheddingLevel::COMPETITORS {
                    [Some(&mut picture), now.as_mut()].into_iter().flatten().for_each(remove_competitors);
                }
                if let Some(shedding) = self.driver.shedding_mut() {
                    shedding.join(picture.tracks.iter().filter_map(|track| match &track.point.source {
                        Source::Fused(radar, ..) => Some(radar.track),
                        Source::Radar(_) | Source::Transponder(_) | Source::Cameras => None,
                    }));
                    shedding.forget(picture.time);
                }
                let frame = self.driver.pipeline().normaliser().frame().clone();
                let words = self.value_sharing.exchange(slot, &frame, self.driver.engine_mut());
                let pipeline = self.driver.pipeline();
                let view = EngineView { engine: pipeline.engine(), frame: pipeline.normaliser().frame() };
                let publish = |border: &mut Border| border.publish(&mut picture, now.as_mut(), &view, words);
                let messages = self.border.as_mut().map(publish).unwrap_or_default();
                self.slots.push_back((slot, octets(&picture, now.as_ref()), messages));
            }
        }
    }
}

/// Removes the competitors, which are not needed to act on a track.
fn remove_competitors(picture: &mut Picture) {
    picture.tracks.iter_mut().for_each(|track| track.point.competitors.clear());
}

/// Serialises the two pictures of a deadline.
fn octets(lagged: &Picture, now: Option<&Picture>) -> Vec<u8> {
    postcard::to_stdvec(&(lagged, now)).expect("every picture can be written down")
}

/// Parses both pictures: the regular one, and the picture of now if there is one. `None` if the octets are invalid.
pub fn pictures(octets: &[u8]) -> Option<(Picture, Option<Picture>)> {
    postcard::from_bytes(octets).ok()
}

impl CellEngine for SiteEngine {
    fn receive(&mut self, datagram: &ReceivedDatagram, at: Time) {
        let line = self.line(datagram.to);
        self.driver.receive(&Reception {
            received: Some(at),
            input: line,
            from: Some(datagram.from),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: datagram.payload.clone(),
        });
        self.collect_slots();
    }

    fn tick(&mut self, now: Time) {
        self.apply_decisions();
        self.driver.tick(now);
        self.collect_slots();
    }

    fn next_due(&self) -> Option<Time> {
        self.driver.next_made()
    }

    fn set_level(&mut self, level: SheddingLevel) {
        if level != self.level {
            self.level = level;
            self.driver.shed(level.shed());
        }
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, picture, messages) = self.slots.pop_front()?;
        self.messages = messages;
        Some((slot, picture))
    }

    fn handle_message(&mut self, message: &CellMessage) {
        let content = match &mut self.border {
            Some(border) => border.handle_message(message),
            None => Some(message.content.clone()),
        };
        match content {
            Some(CellMessageContent::Values { from, values }) => {
                self.driver.engine_mut().use_values(from, *values);
            }
            Some(CellMessageContent::Labelled(tracks)) => {
                let engine = self.driver.engine_mut();
                tracks.iter().for_each(|track| engine.count_labelled(track));
            }
            Some(CellMessageContent::Handover(values)) => self.driver.engine_mut().receive_handover(*values),
            Some(decision @ (CellMessageContent::Correlate { .. } | CellMessageContent::SetTrust { .. })) => {
                self.pending_decisions.push(decision);
            }
            // The other messages are for regions of several cells.
            Some(_) | None => {}
        }
    }

    fn recent_messages(&self) -> Vec<CellMessage> {
        self.border.as_ref().map(Border::recent_messages).unwrap_or_default()
    }

    fn take_messages(&mut self) -> Vec<CellMessage> {
        std::mem::take(&mut self.messages)
    }
}
