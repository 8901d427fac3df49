use super::*;

#[test]
fn a_flood_of_identities_is_bounded_and_drives_no_other_out() {
    let mut rules = ReportRules::default();
    let honest = flight(1, 1.0, (0.0, 30.0), 0.5, eastward);
    for (step, (_, fix)) in honest.iter().enumerate() {
        rules.add_reports(&[*fix]);
        let seconds = step as f64;
        let invented: Vec<Fix> = (0..4_000)
            .map(|number| {
                super::fix(10_000 + 4_000 * step as u32 + number, seconds, [f64::from(number), 0.0, 50.0])
            })
            .collect();
        rules.add_reports(&invented);
        rules.evaluate(at(seconds + 0.5));
        assert!(rules.ledgers.len() <= IDENTITIES_MAX);
    }
    assert_eq!(rules.ledgers.len(), IDENTITIES_MAX);
    assert_eq!(rules.ledgers[&identity(1)].streams[0].history.len(), 30);
}

#[test]
fn identity_silent_for_an_hour_is_evicted() {
    let mut rules = ReportRules::default();
    rules.add_reports(&[fix(1, 0.0, [0.0; 3])]);
    rules.evaluate(at(3600.0));
    assert_eq!(rules.ledgers.len(), 1);
    rules.evaluate(at(3600.25));
    assert!(rules.ledgers.is_empty());
}

#[test]
fn one_identity_cannot_grow_without_bound() {
    let mut rules = ReportRules::default();
    for report in 0..20_000 {
        rules.add_reports(&[fix(1, f64::from(report) * 0.001, [f64::from(report), 0.0, 50.0])]);
    }
    assert!(rules.ledgers[&identity(1)].streams[0].history.len() <= 160);
}
