use super::*;

/// Drones from second 0 up to their last seconds, with a period of 2 s.
fn fleet(lasts_s: &[f64]) -> Vec<Arrival> {
    let flights = (1..).zip(lasts_s).flat_map(|(number, &last_s)| {
        let north_m = 200.0 * f64::from(number);
        flight(number, 2.0, (0.1 * f64::from(number), last_s), 0.5, move |seconds| {
            [12.0 * seconds, north_m, 80.0]
        })
    });
    flights.collect()
}

/// First and last time of an alert, and its largest number of identities.
fn jammed(reports: &[Arrival]) -> Option<(f64, f64, usize)> {
    let mut lasts: Option<(f64, f64, usize)> = None;
    run(reports, |at_s, rules| {
        if let Some(jammed) = rules.jammed() {
            assert_eq!(jammed.identities.len(), jammed.places.len());
            let (from_s, _, most) = lasts.unwrap_or((at_s, at_s, 0));
            lasts = Some((from_s, at_s, most.max(jammed.identities.len())));
        }
    });
    lasts
}

#[test]
fn silent_after_three_periods_or_10_s() {
    for (period_s, after_s) in [(0.5, 10.0), (2.0, 10.0), (4.0, 12.0), (8.0, 24.0)] {
        let mut reports = flight(1, period_s, (0.0, 80.0), 0.5, eastward);
        let last_s = reports[reports.len() - 1].1.time.seconds_since(at(0.0));
        reports.extend(flight(2, 1.0, (0.0, 200.0), 0.5, eastward));
        let mut since = Vec::new();
        run(&reports, |at_s, rules| {
            assert_eq!(rules.finding(identity(2)).silent_since, None);
            assert_eq!(rules.finding(identity(3)).silent_since, None);
            if let Some(newest) = rules.finding(identity(1)).silent_since {
                assert_eq!(newest, at(last_s));
                since.push(at_s);
            }
        });
        assert_eq!(since[0], ((last_s + after_s) / SLOT_S).floor() * SLOT_S + SLOT_S, "{period_s}");
    }
}

#[test]
fn transponder_silent_for_six_periods_or_27_s_is_missed() {
    for (period_s, after_s) in [(0.5, 27.0), (4.0, 27.0), (6.0, 36.0)] {
        let mut reports = flight(1, period_s, (0.0, 80.0), 0.5, eastward);
        let last_s = reports[reports.len() - 1].1.time.seconds_since(at(0.0));
        reports.extend(flight(2, 1.0, (0.0, 200.0), 0.5, eastward));
        let mut since = Vec::new();
        run(&reports, |at_s, rules| {
            assert!(!rules.is_missed(identity(2)) && !rules.is_missed(identity(3)));
            since.extend(rules.is_missed(identity(1)).then_some(at_s));
        });
        assert_eq!(since[0], ((last_s + after_s) / SLOT_S).floor() * SLOT_S + SLOT_S, "{period_s}");
    }
    let mut lasts_s = [300.0; 8];
    lasts_s[..4].copy_from_slice(&[100.0, 101.0, 103.0, 200.0]);
    run(&fleet(&lasts_s), |at_s, rules| {
        let missed = (1..=8).filter(|&number| rules.is_missed(identity(number))).collect::<Vec<_>>();
        match at_s {
            // Jamming is not detected until three are silent.
            125.0..131.0 => {}
            ..225.0 => assert!(missed.is_empty(), "{at_s} {missed:?}"),
            _ => assert!(at_s < 228.0 || missed == [4], "{at_s} {missed:?}"),
        }
    });
}

#[test]
fn three_of_eight_silent_at_once_are_jammed_within_30_s() {
    let mut lasts_s = [300.0; 8];
    lasts_s[..3].copy_from_slice(&[100.0, 101.0, 103.0]);
    let (from_s, until_s, count) = jammed(&fleet(&lasts_s)).unwrap();
    assert!((100.0..130.0).contains(&from_s) && until_s > 290.0 && count == 3, "{from_s} {until_s}");
}

#[test]
fn all_of_them_at_once_are_worth_an_alert_too() {
    let mut reports = fleet(&[100.0; 4]);
    reports.extend(flight(9, 2.0, (90.0, 200.0), 0.5, eastward));
    assert!(jammed(&reports).is_some_and(|(from_s, _, count)| from_s < 130.0 && count == 4));
}

#[test]
fn jamming_ends_when_half_report_again() {
    let mut reports = fleet(&[100.0, 100.0, 100.0, 100.0, 300.0, 300.0]);
    for number in [1, 2] {
        reports.extend(flight(number, 2.0, (150.0 + 20.0 * f64::from(number), 300.0), 0.5, eastward));
    }
    let (_, until_s, count) = jammed(&reports).unwrap();
    assert!((190.0..192.0).contains(&until_s) && count == 4, "{until_s} {count}");
}

#[test]
fn two_or_few_of_many_or_one_after_the_other_are_none() {
    let mut lasts_s = [300.0; 12];
    lasts_s[..2].copy_from_slice(&[100.0, 101.0]);
    assert_eq!(jammed(&fleet(&lasts_s)), None);
    lasts_s[2] = 102.0;
    assert_eq!(jammed(&fleet(&lasts_s)), None, "three of twelve");
    let spread: Vec<f64> = (0..8).map(|number| 80.0 + 20.0 * f64::from(number)).collect();
    assert_eq!(jammed(&fleet(&spread)), None);
}

#[test]
fn landing_together_is_no_jamming() {
    let lands = |seconds: f64| {
        let up_m = (2.0 * seconds).min(60.0).min(2.0 * (110.0 - seconds)).max(0.0);
        [12.0 * (seconds - 15.0).clamp(0.0, 70.0), 300.0, up_m]
    };
    let mut reports: Vec<Arrival> =
        (1..=4).flat_map(|number| flight(number, 2.0, (0.0, 120.0), 0.3, lands)).collect();
    reports.extend(flight(9, 2.0, (0.0, 300.0), 0.5, eastward));
    assert_eq!(jammed(&reports), None);
}

#[test]
fn three_silent_are_not_jammed_where_silences_are_common() {
    // Each is silent for 40 s of every 100 s, at its own time: occasionally three begin together.
    let mut reports = Vec::new();
    for number in 1..=6_u32 {
        let mut from_s = 0.0;
        let mut random = ChaCha8Rng::seed_from_u64(number.into());
        while from_s < 1800.0 {
            let until_s = from_s + random.random_range(30.0..90.0);
            reports.extend(flight(number, 2.0, (from_s, until_s), 0.5, move |seconds| {
                [12.0 * seconds, 200.0 * f64::from(number), 80.0]
            }));
            from_s = until_s + random.random_range(32.0..48.0);
        }
    }
    reports.retain(|(_, fix)| fix.time < at(1800.0));
    // The rate is learnt in the first minutes.
    run(&reports, |at_s, rules| assert!(at_s < 300.0 || rules.jammed().is_none(), "{at_s}"));
}

/// A clock that is set ahead makes every report late, but all are still received.
#[test]
fn reports_that_become_late_together_are_no_jamming() {
    for late_s in [10.0, 20.0, 24.9] {
        let mut reports = fleet(&[300.0; 8]);
        reports.iter_mut().filter(|(at_s, _)| *at_s > 100.0).for_each(|(at_s, _)| *at_s += late_s);
        assert_eq!(jammed(&reports), None, "{late_s} s");
    }
}

/// After a restart of the engine only identities that were received since then can fall silent.
#[test]
fn restart_ends_every_silence() {
    let mut rules = ReportRules::default();
    for (_, fix) in fleet(&[100.0; 8]) {
        rules.add_reports(&[fix]);
    }
    rules.evaluate(at(101.0));
    rules.restart();
    rules.evaluate(at(150.0));
    assert!(rules.jammed().is_none() && (1..=8).all(|number| !rules.is_missed(identity(number))));
    rules.add_reports(&[fix(1, 150.0, [0.0; 3])]);
    rules.evaluate(at(151.0));
    rules.evaluate(at(190.0));
    let missed: Vec<u32> = (1..=8).filter(|&number| rules.is_missed(identity(number))).collect();
    assert_eq!(missed, [1]);
}
