//! The engine of a cell: a site's driver, whose pictures are published as octets.

use std::collections::VecDeque;
use std::net::SocketAddr;

use bytes::Bytes;
use fusion::Identity;
use fusion::numbering::Given;
use fusion::point::Source;
use fusion::slots::Slot;
use fusion::time::Time;

use super::cell::Fusing;
use super::message::Heard;
use super::region::{Border, Letter, Teaching, View, Word};
use super::relief::Step;
use super::report::CellReport;
use crate::areas::Masks;
use crate::capture::{Reception, ReceptionKind};
use crate::config::Config;
use crate::live::{Driver, Integrities, Made, PublishedPicture, Status};
use crate::net::listen::lines;
use crate::picture::Picture;
use crate::pipeline::{NotRestored, Selection};
use crate::state::Registrations;

/// A checkpoint: driver, border, decisions to come, what is left out.
type Written = (Bytes, Option<Vec<u8>>, Vec<Word>, u8);

/// A site's driver as a cell's engine.
#[derive(Debug)]
pub struct SiteEngine {
    config: Config,
    driver: Driver,
    /// Where the datagrams of each line go.
    lines: Vec<SocketAddr>,
    made: VecDeque<(Slot, Vec<u8>, Vec<Letter>)>,
    /// Of the slot that was polled last.
    letters: Vec<Letter>,
    /// Of a cell among others.
    border: Option<Border>,
    teaching: Teaching,
    /// What is left out.
    step: Step,
    /// What operators have decided for slots that are still to come, in the order in which it came.
    decided: Vec<Word>,
}

impl SiteEngine {
    /// Of a site, with nothing received; `started` is now.
    pub fn new(config: Config, masks: Masks, started: Time) -> Self {
        let lines = lines(&config);
        Self {
            driver: Driver::new(&config, masks, started, lines.len()),
            lines: lines.iter().map(|line| line.destination().into()).collect(),
            config,
            made: VecDeque::new(),
            letters: Vec::new(),
            border: None,
            teaching: Teaching::default(),
            step: Step::default(),
            decided: Vec::new(),
        }
    }

    /// The same for a cell among others: it sees what is in the cell and around it, and publishes what is the cell's.
    #[must_use]
    pub fn bordering(self, border: Border) -> Self {
        let region = border.region();
        let selection = Selection::new(region.outline().clone(), region.halo_m);
        let teaching = Teaching::new(&self.config, region);
        let driver = self.driver.selecting(selection);
        Self { driver, border: Some(border), teaching, ..self }.sharing()
    }

    /// The same that uses what it is told of sensors, and not what it learns itself.
    #[must_use]
    pub fn sharing(mut self) -> Self {
        self.driver.engine_mut().share_values();
        self
    }

    /// The border of its cell, where there is one.
    pub const fn border(&self) -> Option<&Border> {
        self.border.as_ref()
    }

    /// The state, where no slot waits to be polled.
    pub fn checkpoint(&self) -> Vec<u8> {
        let border = self.border.as_ref().map(Border::checkpoint);
        postcard::to_stdvec(&(self.driver.checkpoint(&self.config), border, &self.decided, self.step.0))
            .expect("every state can be written down")
    }

    /// The same as the one that wrote a checkpoint was then.
    ///
    /// # Errors
    /// It is of another version, or the site or its settings are others now.
    pub fn restored(mut self, masks: Masks, checkpoint: &[u8]) -> Result<Self, NotRestored> {
        let written: Written = postcard::from_bytes(checkpoint).map_err(|_| NotRestored::Unreadable)?;
        let (driver, border, decided, step) = written;
        self.driver.restore(&self.config, masks, &driver)?;
        let is_whole = match (&mut self.border, border) {
            (Some(own), Some(octets)) => own.go_on(&octets),
            (own, octets) => own.is_none() && octets.is_none(),
        };
        (self.decided, self.step) = (decided, Step(step));
        if is_whole { Ok(self) } else { Err(NotRestored::Site) }
    }

    /// The state of the driver in a checkpoint, as [`Driver::restore`] takes it. `None`: it is none of this version.
    pub fn driver_in(checkpoint: &[u8]) -> Option<Bytes> {
        let written: Written = postcard::from_bytes(checkpoint).ok()?;
        Some(written.0)
    }

    /// Carries out what was decided for the slot that is made next, or before.
    fn carry_out(&mut self) {
        let Some(next) = self.driver.next_slot() else { return };
        let driver = &mut self.driver;
        self.decided.retain(|word| match *word {
            // What it is about may have ended meanwhile: then it says nothing.
            Word::Correlate { from, correlation } if from <= next => {
                _ = driver.correlate(correlation);
                false
            }
            Word::Say { from, word } if from <= next => {
                _ = driver.say(word);
                false
            }
            _ => true,
        });
    }

    /// Takes what outlives a gap from a state that is too old to go on with: numbers, registration, decisions.
    pub fn remember(&mut self, masks: Masks, checkpoint: &[u8], now: Time) {
        let mut before = Driver::new(&self.config, masks.clone(), now, self.lines.len());
        let Ok((driver, border, ..)) = postcard::from_bytes::<Written>(checkpoint) else { return };
        self.border.iter_mut().zip(border).for_each(|(own, octets)| own.remember(&octets));
        if before.restore(&self.config, masks, &driver).is_err() {
            return;
        }
        let engine = before.pipeline().engine();
        let mut numbers = engine.numbers().given().collect();
        self.driver.remember(&mut numbers);
        self.driver.engine_mut().remember_track_numbers(engine.track_numbers());
        Registrations::of(&self.config, engine).restore(&self.config, Some(now), self.driver.engine_mut());
        self.driver.engine_mut().resume(engine.kept());
        self.driver
            .engine_mut()
            .plan_words(engine.words().iter().map(|held| (held.since, held.word)).collect());
    }

    /// How the cell is, as its owner says it.
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
        let mut integrities = Integrities::of(&self.driver, self.driver.latest());
        if let Some(border) = &self.border {
            integrities.assessments.retain_mut(|assessment| border.publicise(assessment));
        }
        CellReport { node: node.to_owned(), epoch, status, integrities, correlations: engine.correlations() }
    }

    /// The slot that is made next.
    pub fn next_slot(&self) -> Option<Slot> {
        self.driver.next_slot()
    }

    /// Transponder numbers that are in use.
    pub fn numbers(&self) -> Vec<Given> {
        self.driver.pipeline().engine().numbers().given().collect()
    }

    /// What of the region's numbers is this cell's ([`Border::claims`]); nothing where there is one cell.
    pub fn claims(&self) -> (Vec<u32>, Vec<(Identity, u32)>) {
        self.border.as_ref().map(Border::claims).unwrap_or_default()
    }

    /// The line whose datagrams go to this address. What came on no line of the configuration is judged by what it says.
    pub(super) fn line(&self, to: SocketAddr) -> usize {
        self.lines.iter().position(|line| *line == to).unwrap_or_default()
    }

    fn gather(&mut self) {
        while let Some(made) = self.driver.poll() {
            if let Made::Slot(PublishedPicture { mut picture, now, .. }) = made {
                let slot = picture.slot;
                let mut now = now.get().map(|now| Picture::clone(&now));
                if self.step >= Step::COMPETITORS {
                    [Some(&mut picture), now.as_mut()].into_iter().flatten().for_each(spare);
                }
                if let Some(shedding) = self.driver.shedding_mut() {
                    shedding.join(picture.tracks.iter().filter_map(|track| match &track.point.source {
                        Source::Fused(radar, ..) => Some(radar.track),
                        Source::Radar(_) | Source::Transponder(_) => None,
                    }));
                    shedding.forget(picture.time);
                }
                let frame = self.driver.pipeline().normaliser().frame().clone();
                let words = self.teaching.turn(slot, &frame, self.driver.engine_mut());
                let pipeline = self.driver.pipeline();
                let view = View { engine: pipeline.engine(), frame: pipeline.normaliser().frame() };
                let turn = |border: &mut Border| border.turn(&mut picture, now.as_mut(), &view, words);
                let letters = self.border.as_mut().map(turn).unwrap_or_default();
                self.made.push_back((slot, octets(&picture, now.as_ref()), letters));
            }
        }
    }
}

/// Leaves out what nobody needs in order to act.
fn spare(picture: &mut Picture) {
    picture.tracks.iter_mut().for_each(|track| track.point.competitors.clear());
}

/// The two pictures of a deadline as octets.
fn octets(lagged: &Picture, now: Option<&Picture>) -> Vec<u8> {
    postcard::to_stdvec(&(lagged, now)).expect("every picture can be written down")
}

/// Both again: the usual one, and that of now where it is made. `None`: the octets are something else.
pub fn pictures(octets: &[u8]) -> Option<(Picture, Option<Picture>)> {
    postcard::from_bytes(octets).ok()
}

impl Fusing for SiteEngine {
    fn receive(&mut self, heard: &Heard, at: Time) {
        let line = self.line(heard.to);
        self.driver.receive(&Reception {
            received: Some(at),
            input: line,
            from: Some(heard.from),
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: heard.payload.clone(),
        });
        self.gather();
    }

    fn tick(&mut self, now: Time) {
        self.carry_out();
        self.driver.tick(now);
        self.gather();
    }

    fn next_due(&self) -> Option<Time> {
        self.driver.next_made()
    }

    fn relieve(&mut self, step: Step) {
        if step != self.step {
            self.step = step;
            self.driver.shed(step.shed());
        }
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        let (slot, picture, letters) = self.made.pop_front()?;
        self.letters = letters;
        Some((slot, picture))
    }

    fn letter(&mut self, letter: &Letter) {
        let word = match &mut self.border {
            Some(border) => border.letter(letter),
            None => Some(letter.word.clone()),
        };
        match word {
            Some(Word::Values { from, values }) => self.driver.engine_mut().use_values(from, *values),
            Some(Word::Labelled(tracks)) => {
                let engine = self.driver.engine_mut();
                tracks.iter().for_each(|track| engine.count_labelled(track));
            }
            Some(Word::Known(values)) => self.driver.engine_mut().meet(*values),
            Some(word @ (Word::Correlate { .. } | Word::Say { .. })) => self.decided.push(word),
            // Between cells, of which there is one here.
            Some(_) | None => {}
        }
    }

    fn recent_letters(&self) -> Vec<Letter> {
        self.border.as_ref().map(Border::recent_letters).unwrap_or_default()
    }

    fn letters(&mut self) -> Vec<Letter> {
        std::mem::take(&mut self.letters)
    }
}
