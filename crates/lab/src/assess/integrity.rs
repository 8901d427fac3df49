//! Flags of the engine: transponders, and aircraft without one.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::AssessmentScene;
use super::types::{AssessmentFigure, FigureTable};
use crate::evaluate::OutputPoint;
use fusion::integrity::Reason;
use fusion::time::Time;

/// Flags of a transponder.
#[derive(Default)]
struct FlaggedTransponder {
    slots: BTreeSet<Time>,
    reasons: BTreeSet<&'static str>,
}

/// Flags in the picture.
pub(super) fn flags(scene: &AssessmentScene<'_>, picture: &[OutputPoint]) -> FigureTable {
    let mut assessed: BTreeSet<&str> = BTreeSet::new();
    let mut flagged: BTreeMap<&str, FlaggedTransponder> = BTreeMap::new();
    let mut uncooperative: BTreeSet<u32> = BTreeSet::new();
    for point in picture {
        if point.flags.is_uncooperative {
            uncooperative.insert(point.number);
        }
        let (Some(identity), Some((state, reasons))) = (point.identity.as_deref(), point.flags.integrity)
        else {
            continue;
        };
        assessed.insert(identity);
        if state.is_flagged() {
            let of_identity = flagged.entry(identity).or_default();
            of_identity.slots.insert(point.time);
            of_identity.reasons.extend(reasons.iter().map(Reason::name));
        }
    }
    let figure = |key: String, name: &str, unit, digits, value: f64| {
        AssessmentFigure::plain(format!("picture.integrity.{key}"), name, unit, digits, Some(value))
    };
    let mut figures = vec![
        figure("assessed".to_owned(), "transponders assessed", "", 0, assessed.len() as f64),
        figure(
            "flagged".to_owned(),
            "transponders flagged as suspect or failed",
            "",
            0,
            flagged.len() as f64,
        ),
        figure(
            "uncooperative".to_owned(),
            "tracks marked as flying without a transponder",
            "",
            0,
            uncooperative.len() as f64,
        ),
    ];
    for (identity, of) in &flagged {
        let reasons = of.reasons.iter().copied().collect::<Vec<_>>().join(", ");
        let name = format!("time flagged: {identity} ({reasons})");
        let seconds = of.slots.len() as f64 * scene.grid.slot_s();
        figures.push(figure(format!("time.{identity}"), &name, "s", 2, seconds));
    }
    FigureTable { title: "picture".to_owned(), figures }
}
