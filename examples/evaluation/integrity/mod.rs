//! How well the `operational` profile finds transponders that lie.

mod compared;
mod coverage;
mod flights;
mod flown;
mod lies;
mod real;
mod rows;
mod shares;

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::Path;

use fusion::integrity::Reason;

use crate::asked::Asked;
use crate::flights::Failure;
pub use flights::NAMES;
use flown::Outcome;
pub use flown::{configured, labels};

/// Everything that was flown for it.
pub struct Measured {
    simulated: Vec<Outcome>,
    compared: Vec<compared::Compared>,
    real: Vec<Outcome>,
}

/// What is flown.
pub struct Order<'a> {
    /// Seeds of each scenario without an attack; of each attack there are as many or more.
    pub seeds: RangeInclusive<u64>,
    /// Only these of the [`NAMES`]; none: everything.
    pub names: &'a [String],
    /// The folder of the real flights.
    pub recordings: Option<&'a Path>,
    pub threads: usize,
}

impl Order<'_> {
    fn names(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|wanted| wanted == name)
    }
}

/// Flies it.
pub fn measure(order: &Order<'_>) -> Result<Measured, Failure> {
    let (seeds, threads) = (&order.seeds, order.threads);
    let flights: Vec<_> =
        flights::all(seeds)?.into_iter().filter(|flight| order.names(flight.what.name())).collect();
    eprintln!("transponders that lie: {} flights", flights.len());
    let simulated = flown::all(&flights, threads)?;
    let compared = if order.names(flights::COMPARED) { compared::all(seeds, threads)? } else { Vec::new() };
    let recordings = order.recordings.filter(|_| order.names(flights::REAL));
    let real = recordings.map(|folder| real::all(folder, threads)).transpose()?.unwrap_or_default();
    Ok(Measured { simulated, compared, real })
}

/// The rows of the table.
pub fn asked(measured: &Measured) -> Vec<Asked> {
    let Measured { simulated, compared, real } = measured;
    let mut rows = rows::asked(simulated);
    rows.extend(compared::asked(compared));
    rows.extend(real::asked(real));
    rows
}

/// A line for each attack, and for each false flag.
pub fn each(measured: &Measured) -> String {
    let mut text = String::new();
    for Outcome { what, seed, integrity } in measured.simulated.iter().chain(&measured.real) {
        let name = what.name();
        for attack in &integrity.attacks {
            let said: Vec<String> =
                attack.reasons.iter().map(|(reason, s)| format!("{} {s:.1}", reason.name())).collect();
            let begin = attack.begin.map_or("-".to_owned(), |begin| begin.to_string());
            let delay = attack.delay_s.map_or("never".to_owned(), |s| format!("{s:.1} s"));
            let silent = if attack.is_silent { ", silent" } else { "" };
            let _ = writeln!(
                text,
                "{name} {} seed {seed}: number {} from {begin}, seen {} s{silent}: {delay} ({})",
                attack.kind.name(),
                attack.number,
                attack.seen_s,
                said.join(", ")
            );
        }
        for flag in &integrity.clean.flags {
            let said: Vec<&str> = flag.reasons.iter().map(Reason::name).collect();
            let _ = writeln!(
                text,
                "FALSE in {name} seed {seed}: number {} from {} for {:.1} s ({})",
                flag.number,
                flag.from,
                flag.until.seconds_since(flag.from),
                said.join(", ")
            );
        }
    }
    text
}
