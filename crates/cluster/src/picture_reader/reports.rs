//! Merging of the reports of all cells' owners into one. Sans-IO.

use std::collections::BTreeMap;

use crate::report::CellReport;
use service::live::TrustAssessments;
use site::territory::CellName;

/// Merges the reports of several cells. `homes` lists the home cell of each sensor. `None` if there are no reports.
///
/// All sensor data is delivered to every cell, so the tally of the cell that received most is used for the region. The state of a
/// sensor is the one reported by its home or, without a report of the home, the best one reported.
pub(super) fn merge_reports(homes: &[CellName], reports: Vec<(CellName, CellReport)>) -> Option<CellReport> {
    let most = reports.iter().max_by_key(|(_, report)| report.status.tally.received)?;
    let mut joined = most.1.clone();
    if reports.len() == 1 {
        return Some(joined);
    }
    let tally = &mut joined.status.tally;
    for (sensor, elsewhere) in std::mem::take(&mut tally.elsewhere) {
        *tally.accepted.entry(sensor).or_default() += elsewhere;
    }
    let tally = &mut joined.status.tally;
    tally.shed.clear();
    for (sensor, shed) in reports.iter().flat_map(|(_, report)| &report.status.tally.shed) {
        *tally.shed.entry(*sensor).or_default() += shed;
    }
    tally.jumping_tracks.clear();
    for (sensor, jumping) in reports.iter().flat_map(|(_, report)| &report.status.tally.jumping_tracks) {
        *tally.jumping_tracks.entry(*sensor).or_default() += jumping;
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
            // Each cell assesses its own aircraft. For an aircraft that changed cells, use the newest assessment.
            let known = assessments.entry(assessment.identity).or_insert_with(|| assessment.clone());
            if assessment.heard > known.heard {
                *known = assessment;
            }
        }
    }
    let words = joined.integrities.words;
    joined.integrities =
        TrustAssessments { at, assessments: assessments.into_values().collect(), words, flags };
    Some(joined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::SensorIndex;
    use fusion::time::Time;
    use service::live::{SensorState, ServiceFault, Severity, Status};

    fn report(
        states: [SensorState; 2],
        received: u64,
        accepted: u64,
        elsewhere: u64,
        trouble: &str,
    ) -> CellReport {
        let config = lab::simulate::simulate(
            &lab::simulate::Scenario::parse("name = \"x\"\nduration_s = 20\n", "x.toml").unwrap(),
            1,
            Some(Time::from_nanos(1_800_000_000_000_000_000)),
        )
        .unwrap()
        .config;
        let at = Time::from_nanos(1_800_000_000_000_000_000);
        let mut driver = service::live::Driver::new(&config, site::areas::Masks::default(), at, 2);
        let mut sensors = driver.sensors(at, |_| Vec::new());
        sensors.iter_mut().zip(states).for_each(|(sensor, state)| sensor.state = state);
        let mut tally = driver.pipeline().tally().clone();
        tally.received = received;
        tally.accepted.insert(SensorIndex(0), accepted);
        tally.elsewhere.insert(SensorIndex(0), elsewhere);
        let trouble =
            ServiceFault { about: "x".into(), severity: Severity::Warning, text: trouble.to_owned() };
        let status = Status {
            at,
            sensors,
            unknown: Vec::new(),
            tally,
            numbers_used: 3,
            lateness_s: None,
            failed_sends: 0,
            troubles: vec![trouble],
        };
        let integrities = TrustAssessments::default();
        CellReport { node: "n".to_owned(), epoch: 1, status, integrities, correlations: Vec::new() }
    }

    #[test]
    fn sensor_state_is_of_its_home_and_datagrams_count_once() {
        use SensorState::{Degraded, Operational, Outage};
        let [east, west] = ["east", "west"].map(|name| CellName::new(name).unwrap());
        let homes = [west.clone(), east.clone()];
        let of_east = || report([Outage, Operational], 90, 10, 70, "same");
        let of_west = || report([Degraded, Outage], 100, 60, 30, "same");
        let both = merge_reports(&homes, vec![(east.clone(), of_east()), (west, of_west())]).unwrap();
        let states: Vec<SensorState> =
            both.status.sensors.iter().take(2).map(|sensor| sensor.state).collect();
        assert_eq!(states, [Degraded, Operational]);
        assert_eq!((both.status.tally.received, both.status.numbers_used), (100, 6));
        assert_eq!(both.status.tally.accepted[&SensorIndex(0)], 90, "what is for others is accepted, too");
        assert!(both.status.tally.elsewhere.is_empty() && both.status.troubles.len() == 1);
        // Without a report of the home the other cell's is used.
        let alone = merge_reports(&homes, vec![(east, of_east())]).unwrap();
        assert_eq!(alone.status.sensors[0].state, Outage);
        assert_eq!(merge_reports(&homes, Vec::new()), None);
    }
}
