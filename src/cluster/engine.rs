//! The engine of a cell: a site's driver, whose pictures are published as octets.

use std::collections::VecDeque;
use std::net::SocketAddr;

use fusion::numbering::Given;
use fusion::slots::Slot;
use fusion::time::Time;

use super::cell::Fusing;
use super::message::Heard;
use super::report::CellReport;
use crate::areas::Masks;
use crate::capture::{Reception, ReceptionKind};
use crate::config::Config;
use crate::live::{Driver, Integrities, Made, PublishedPicture, Status};
use crate::net::listen::lines;
use crate::picture::Picture;
use crate::pipeline::NotRestored;
use crate::state::Registrations;

/// A site's driver as a cell's engine.
#[derive(Debug)]
pub struct SiteEngine {
    config: Config,
    driver: Driver,
    /// Where the datagrams of each line go.
    lines: Vec<SocketAddr>,
    made: VecDeque<(Slot, Vec<u8>)>,
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
        }
    }

    /// The state, where no slot waits to be polled.
    pub fn checkpoint(&self) -> Vec<u8> {
        self.driver.checkpoint(&self.config)
    }

    /// The same as the one that wrote a checkpoint was then.
    ///
    /// # Errors
    /// It is of another version, or the site or its settings are others now.
    pub fn restored(mut self, masks: Masks, checkpoint: &[u8]) -> Result<Self, NotRestored> {
        self.driver.restore(&self.config, masks, checkpoint)?;
        Ok(self)
    }

    /// Takes what outlives a gap from a state that is too old to go on with: numbers, registration, decisions.
    pub fn remember(&mut self, masks: Masks, checkpoint: &[u8], now: Time) {
        let mut before = Driver::new(&self.config, masks.clone(), now, self.lines.len());
        if before.restore(&self.config, masks, checkpoint).is_err() {
            return;
        }
        let engine = before.pipeline().engine();
        let mut numbers = engine.numbers().given().collect();
        self.driver.remember(&mut numbers);
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
        let integrities = Integrities::of(&self.driver, self.driver.latest());
        CellReport { node: node.to_owned(), epoch, status, integrities, correlations: engine.correlations() }
    }

    /// Transponder numbers that are in use.
    pub fn numbers(&self) -> Vec<Given> {
        self.driver.pipeline().engine().numbers().given().collect()
    }

    /// The line whose datagrams go to this address. What came on no line of the configuration is judged by what it says.
    pub(super) fn line(&self, to: SocketAddr) -> usize {
        self.lines.iter().position(|line| *line == to).unwrap_or_default()
    }

    fn gather(&mut self) {
        while let Some(made) = self.driver.poll() {
            if let Made::Slot(PublishedPicture { picture, now, .. }) = made {
                let slot = picture.slot;
                self.made.push_back((slot, octets(&picture, now.get().as_deref())));
            }
        }
    }
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
        self.driver.tick(now);
        self.gather();
    }

    fn next_due(&self) -> Option<Time> {
        self.driver.next_made()
    }

    fn poll(&mut self) -> Option<(Slot, Vec<u8>)> {
        self.made.pop_front()
    }
}
