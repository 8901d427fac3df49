//! What the owners of all cells say, as one service says it. Sans-IO.

use std::collections::BTreeMap;

use crate::cluster::report::CellReport;
use crate::live::Integrities;
use crate::territory::CellName;

/// One report of those of several cells; `homes`: of each sensor the cell that knows it best. `None`: there is none.
///
/// Every cell is told what every sensor sends, so whoever has received the most counts for all. A sensor is as its home says or,
/// while that says nothing, as the cell says in which it is best.
pub(super) fn joined(homes: &[CellName], reports: Vec<(CellName, CellReport)>) -> Option<CellReport> {
    let most = reports.iter().max_by_key(|(_, report)| report.status.tally.received)?;
    let mut joined = most.1.clone();
    if reports.len() == 1 {
        return Some(joined);
    }
    let tally = &mut joined.status.tally;
    for (sensor, elsewhere) in std::mem::take(&mut tally.elsewhere) {
        *tally.accepted.entry(sensor).or_default() += elsewhere;
    }
    for (index, sensor) in joined.status.sensors.iter_mut().enumerate() {
        let of = reports.iter().filter_map(|(cell, report)| Some((cell, report.status.sensors.get(index)?)));
        let home = homes.get(index);
        if let Some((_, best)) = of.min_by_key(|(cell, status)| (Some(*cell) != home, status.state)) {
            *sensor = best.clone();
        }
    }
    joined.status.at = reports.iter().map(|(_, report)| report.status.at).max()?;
    joined.status.numbers_used = reports.iter().map(|(_, report)| report.status.numbers_used).sum();
    let mut assessments = BTreeMap::new();
    let (mut flags, mut at) = (BTreeMap::new(), None);
    (joined.status.troubles, joined.correlations, joined.integrities.words) = Default::default();
    for (_, CellReport { status, integrities, correlations, .. }) in reports {
        let new = status.troubles.into_iter().filter(|trouble| !joined.status.troubles.contains(trouble));
        joined.status.troubles.extend(new.collect::<Vec<_>>());
        let new = correlations.into_iter().filter(|held| !joined.correlations.contains(held));
        joined.correlations.extend(new.collect::<Vec<_>>());
        let new = integrities.words.into_iter().filter(|held| !joined.integrities.words.contains(held));
        joined.integrities.words.extend(new.collect::<Vec<_>>());
        for (reason, count) in integrities.flags {
            *flags.entry(reason).or_default() += count;
        }
        at = at.max(integrities.at);
        for assessment in integrities.assessments {
            // Each cell says it of its own aircraft; of who was somewhere before, whoever heard it last.
            let known = assessments.entry(assessment.identity).or_insert_with(|| assessment.clone());
            if assessment.heard > known.heard {
                *known = assessment;
            }
        }
    }
    let words = joined.integrities.words;
    joined.integrities = Integrities { at, assessments: assessments.into_values().collect(), words, flags };
    Some(joined)
}
