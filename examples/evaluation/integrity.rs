//! Measures how well the `operational` profile detects false transponder reports.

mod attacked;
mod compared;
mod coverage;
mod flights;
mod flown;

mod real;
mod rows;
mod shares;

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::Path;

use fusion::integrity::Reason;

use crate::flights::EvaluationFailure;
use crate::results::ResultRow;
pub use flights::NAMES;
use flown::FlightOutcome;
pub use flown::{configured, labels};

/// Results of all flights.
pub struct IntegrityResults {
    simulated: Vec<FlightOutcome>,
    compared: Vec<compared::ComparedFlight>,
    real: Vec<FlightOutcome>,
}

/// Selection of flights.
pub struct IntegrityRequest<'a> {
    /// Seeds of each scenario without an attack; each attack has as many or more.
    pub seeds: RangeInclusive<u64>,
    /// Only these of the [`NAMES`]; empty: all.
    pub names: &'a [String],
    /// Folder of the real flights.
    pub recordings: Option<&'a Path>,
    pub threads: usize,
}

impl IntegrityRequest<'_> {
    fn names(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|wanted| wanted == name)
    }
}

/// Flies the selected flights.
pub fn measure(order: &IntegrityRequest<'_>) -> Result<IntegrityResults, EvaluationFailure> {
    let (seeds, threads) = (&order.seeds, order.threads);
    let flights: Vec<_> =
        flights::all(seeds)?.into_iter().filter(|flight| order.names(flight.what.name())).collect();
    eprintln!("transponders that lie: {} flights", flights.len());
    let simulated = flown::all(&flights, threads)?;
    let compared = if order.names(flights::COMPARED) { compared::all(seeds, threads)? } else { Vec::new() };
    let recordings = order.recordings.filter(|_| order.names(flights::REAL));
    let real = recordings.map(|folder| real::all(folder, threads)).transpose()?.unwrap_or_default();
    Ok(IntegrityResults { simulated, compared, real })
}

/// Rows of the table.
pub fn rows(measured: &IntegrityResults) -> Vec<ResultRow> {
    let IntegrityResults { simulated, compared, real } = measured;
    let mut rows = rows::rows(simulated);
    rows.extend(compared::rows(compared));
    rows.extend(real::rows(real));
    rows
}

/// A line for each attack, and for each false flag.
pub fn each(measured: &IntegrityResults) -> String {
    let mut text = String::new();
    for FlightOutcome { what, seed, integrity } in measured.simulated.iter().chain(&measured.real) {
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
