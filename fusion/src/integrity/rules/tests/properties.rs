//! Invariance: to the order of reports between two slots, the position of the site, and the time.

use proptest::prelude::*;

use super::*;

/// Findings of every slot, with times relative to the first.
fn findings(batches: &[Vec<Fix>], from_s: f64) -> Vec<(Vec<Finding>, Option<Vec<Identity>>)> {
    let mut rules = ReportRules::default();
    let mut found = Vec::new();
    let from_begin = |time: Time| at(0.0) + (time - at(from_s));
    for (slot, batch) in (1..).zip(batches) {
        rules.add_reports(batch);
        rules.evaluate(at(from_s + f64::from(slot) * SLOT_S));
        let all = (1..=3).map(|number| {
            let finding = rules.finding(identity(number));
            let still_since = finding.still_since.map(from_begin);
            Finding { still_since, silent_since: finding.silent_since.map(from_begin), ..finding }
        });
        found.push((all.collect(), rules.jammed().map(|jammed| jammed.identities.clone())));
    }
    found
}

/// Reports by slot, as the service passes them.
fn batches(reports: &[Arrival], from_s: f64) -> Vec<Vec<Fix>> {
    let mut batches = vec![Vec::new(); 1000];
    for (arrives_s, fix) in reports {
        let slot = ((arrives_s - from_s) / SLOT_S).ceil() as usize;
        batches[slot.saturating_sub(1).min(999)].push(*fix);
    }
    batches
}

/// Three flights with jumps, a frozen position, a replay, two transmitters and late reports, all with stamps in whole
/// seconds so that times coincide.
fn mixed(seed: u64) -> Vec<Arrival> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut reports: Vec<Arrival> = Vec::new();
    let (period_s, jump_m) = ([1.0, 2.0, 3.0][random.random_range(0..3)], random.random_range(0.0..200.0));
    for number in 1..=3 {
        let (from_s, kind) = (random.random_range(40.0..80.0), random.random_range(0..4));
        let mut own = flight(number, period_s, (0.0, 200.0), 0.5, move |seconds| {
            let off_m = if kind == 0 && seconds > from_s { jump_m } else { 0.0 };
            [12.0 * seconds, 200.0 * f64::from(number) + off_m, 80.0]
        });
        let last = own[20].1;
        for index in 0..own.len() {
            let seconds = own[index].1.time.seconds_since(at(0.0));
            match kind {
                1 if seconds > from_s => own[index].1.position = last.position,
                2 if seconds > from_s && index >= 20 => own[index].1.position = own[index - 20].1.position,
                3 if seconds > from_s => {
                    let mut second = own[index];
                    second.1.position.0.y += 500.0;
                    own.push(second);
                }
                _ => {}
            }
        }
        for (arrives_s, _) in &mut own {
            *arrives_s += if random.random_range(0..20) == 0 { 4.0 } else { 0.0 };
        }
        reports.extend(own);
    }
    reports
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn the_order_of_reports_within_a_slot_changes_nothing(seed in any::<u64>()) {
        let mut one = batches(&mixed(seed), 0.0);
        let mut other = one.clone();
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 1);
        for batch in &mut other {
            for index in (1..batch.len()).rev() {
                batch.swap(index, random.random_range(0..=index));
            }
        }
        for batch in one.iter_mut().chain(&mut other) {
            batch.sort_by_key(|fix| (fix.time, fix.identity));
        }
        prop_assert_eq!(findings(&one, 0.0), findings(&other, 0.0));
    }

    #[test]
    fn neither_place_nor_time_of_all_matters(seed in any::<u64>(), slots in 0_i32..400_000, east in -64_i32..64, north in -64_i32..64) {
        // Values that are exact in floating point: positions in 1/1024 m, shifts in whole metres.
        let mut reports = mixed(seed);
        for (_, fix) in &mut reports {
            fix.position.0 = fix.position.0.map(|axis| (axis * 1024.0).round() / 1024.0);
        }
        let shift_s = f64::from(slots) * SLOT_S;
        let shift = Vector3::new(f64::from(east), f64::from(north), 16.0);
        let moved: Vec<Arrival> = reports
            .iter()
            .map(|&(arrives_s, mut fix)| {
                fix.time = fix.time + SignedDuration::from_millis((shift_s * 1e3) as i64);
                fix.position.0 += shift;
                (arrives_s + shift_s, fix)
            })
            .collect();
        let here = findings(&batches(&reports, 0.0), 0.0);
        let there = findings(&batches(&moved, shift_s), shift_s);
        prop_assert_eq!(&here, &there);
    }

    #[test]
    fn a_report_twice_is_a_report_once(seed in any::<u64>()) {
        let reports = mixed(seed);
        let twice: Vec<Arrival> = reports.iter().chain(reports.iter().step_by(3)).copied().collect();
        let ordered = |reports: &[Arrival]| {
            let mut batches = batches(reports, 0.0);
            batches.iter_mut().for_each(|batch| batch.sort_by_key(|fix| (fix.time, fix.identity)));
            batches
        };
        prop_assert_eq!(findings(&ordered(&reports), 0.0), findings(&ordered(&twice), 0.0));
    }
}
