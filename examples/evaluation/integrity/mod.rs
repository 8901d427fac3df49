//! How well the `operational` profile finds transponders that lie.

mod flights;
mod flown;
mod rows;
mod shares;

use std::ops::RangeInclusive;

use utm_fusion::evaluate::AttackKind;

use crate::asked::Asked;
use crate::flights::Failure;
pub use flights::NAMES;
use flown::Outcome;

/// Everything that was flown for it.
pub struct Measured(Vec<Outcome>);

/// Flies what has one of these names, or everything; `seeds` of each scenario without an attack, and of each attack as many
/// or more.
pub fn measure(seeds: &RangeInclusive<u64>, names: &[String], threads: usize) -> Result<Measured, Failure> {
    let flights = flights::all(seeds)?;
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    let wanted: Vec<_> = flights.into_iter().filter(|flight| is_wanted(flight.what.name())).collect();
    Ok(Measured(flown::all(&wanted, threads)?))
}

/// The rows of the table.
pub fn asked(measured: &Measured) -> Vec<Asked> {
    rows::asked(&measured.0)
}

/// A line for each attack, and for each false flag.
pub fn each(measured: &Measured) -> String {
    let mut text = String::new();
    for Outcome { flight, integrity, .. } in &measured.0 {
        for attack in &integrity.attacks {
            let said: Vec<String> =
                attack.reasons.iter().map(|(reason, s)| format!("{} {s:.1}", reason.name())).collect();
            let kind = attack.kind.name();
            let begin = attack.begin.map_or("-".to_owned(), |begin| begin.to_string());
            let delay = attack.delay_s.map_or("never".to_owned(), |s| format!("{s:.1} s"));
            let silent = if attack.is_silent { ", silent" } else { "" };
            text += &format!(
                "{kind} seed {}: number {} from {begin}, seen {} s{silent}: {delay} ({})\n",
                flight.seed,
                attack.number,
                attack.seen_s,
                said.join(", ")
            );
        }
        for flag in &integrity.clean.flags {
            let said: Vec<&str> = flag.reasons.iter().map(|reason| reason.name()).collect();
            text += &format!(
                "FALSE in {} seed {}: number {} from {} for {:.1} s ({})\n",
                flight.what.name(),
                flight.seed,
                flag.number,
                flag.from,
                flag.until.seconds_since(flag.from),
                said.join(", ")
            );
        }
    }
    text
}

/// Whether an outcome is of a flight with this attack.
fn is_of(outcome: &Outcome, kind: AttackKind) -> bool {
    outcome.flight.what == flights::What::Attack(kind)
}
