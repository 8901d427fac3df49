//! Rows of the integrity table.

use fusion::integrity::Reason;
use utm_fusion::evaluate::{AttackDetection, AttackKind, FlaggedCoverage, JammingScore, UncooperativeScore};

use super::flights::FlightKind;
use super::flown::FlightOutcome;
use super::shares::{median, rate, ratio, share};
use crate::results::{ResultRow, measured};
use crate::summary::MeanValue;

/// Reasons for results that fall short.
const BY_RADAR: &str = "one radar track is seldom sufficient evidence, and in 10 to 20 % of attacks the radar detects the \
                        drone for less than five seconds after the attack becomes visible.";
const FALSE_FLAGS: &str = "slow errors in azimuth can exceed their learnt size, in turns and at long range.";
const SWAPPED: &str =
    "drones within 100 m of each other, silent transponders and noisy receivers hide the exchange.";
const SHIFT: &str = "a late time stamp is an offset along the track, which shows only where the drone turns or changes its \
                     speed.";
const FLAGGED: &str = "a radar track elsewhere is withheld until it is associated with the drone.";
const UNCOOPERATIVE: &str =
    "a silent drone explains the likeliest aircraft around, which may be another one.";
const JAMMING: &str = "a drone that was silent before it was jammed does not count as jammed.";

/// Hours to which the rate of false flags refers.
const FALSE_H: f64 = 12.0;
/// Hours of equipped drones to which the rate of false marks as uncooperative refers.
const UNCOOPERATIVE_H: f64 = 8.0;

/// All rows.
pub fn rows(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let mut rows = by_radar(outcomes, AttackKind::Drift, None);
    rows.push(clean(outcomes));
    rows.extend(jump(outcomes));
    rows.extend(named(outcomes));
    rows.extend(shift(outcomes));
    rows.extend(shown(outcomes));
    rows.extend(uncooperative(outcomes));
    rows.extend(jamming(outcomes));
    rows
}

fn is_of(outcome: &FlightOutcome, kind: AttackKind) -> bool {
    outcome.what == FlightKind::Attack(kind)
}

fn is_clean(outcome: &FlightOutcome) -> bool {
    matches!(outcome.what, FlightKind::Clean(_))
}

/// Attacks of a kind that count.
fn of(outcomes: &[FlightOutcome], kind: AttackKind) -> impl Iterator<Item = &AttackDetection> + Clone {
    let of_kind = outcomes.iter().filter(move |outcome| is_of(outcome, kind));
    of_kind.flat_map(|outcome| &outcome.integrity.attacks).filter(|attack| attack.begin.is_some())
}

pub fn row(figure: impl Into<String>, result: Option<MeanValue>) -> ResultRow {
    ResultRow::new(figure, measured(result, None)).decimals(0)
}

/// Detection with a radar, with any reason or with this one.
fn by_radar(outcomes: &[FlightOutcome], kind: AttackKind, reason: Option<Reason>) -> Vec<ResultRow> {
    let delay_s = move |attack: &AttackDetection| match reason {
        Some(reason) => attack.delay_by_s(reason),
        None => attack.delay_s,
    };
    let within =
        move |limit_s: f64| move |attack: &AttackDetection| delay_s(attack).is_some_and(|s| s <= limit_s);
    let all = of(outcomes, kind);
    let observable = all.clone().filter(|attack| attack.is_observable);
    let name = match reason {
        Some(reason) => format!("{} by `{}` alone", kind.name(), reason.name()),
        None => kind.name().to_owned(),
    };
    vec![
        row(
            format!("{name}, observable: flagged within 60 s, percent"),
            share(observable.clone().map(within(60.0))),
        )
        .limitation(BY_RADAR),
        row(format!("{name}, observable: flagged within 45 s, percent"), share(observable.map(within(45.0))))
            .limitation(BY_RADAR),
        row(
            format!("{name}, all: flagged before the flight ends, percent"),
            share(all.clone().map(|attack| delay_s(attack).is_some())),
        ),
        row(format!("{name}, all: flagged within 60 s, percent"), share(all.clone().map(within(60.0)))),
        row(format!("{name}, all: flagged within 45 s, percent"), share(all.clone().map(within(45.0)))),
        row(format!("{name}, all: median delay, s"), median(all.map(delay_s))),
    ]
}

/// False flags in flights without an attack, and in those of `spoof` before the drift.
fn clean(outcomes: &[FlightOutcome]) -> ResultRow {
    let is_spoof = |outcome: &FlightOutcome| is_of(outcome, AttackKind::Drift);
    let clean = outcomes.iter().filter(|outcome| is_clean(outcome) || is_spoof(outcome));
    let (mut flags, mut hours) = (0, 0.0);
    for outcome in clean {
        flags += outcome.integrity.clean.flags.len();
        hours += outcome.integrity.clean.identity_h;
    }
    row("false flags in 12 h of honest identities (n: hours)", rate(flags, hours, FALSE_H))
        .decimals(2)
        .limitation(FALSE_FLAGS)
}

/// Share of attacks that rules on reports alone identify in time; attacks with a silent transponder are excluded.
fn by_name(outcomes: &[FlightOutcome], kind: AttackKind, limit_s: f64) -> Option<MeanValue> {
    let reporting = of(outcomes, kind).filter(|attack| !attack.is_silent);
    share(reporting.map(|attack| attack.named_delay_s().is_some_and(|s| s <= limit_s)))
}

fn jump(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let by_rule = row("jump of 100 m: named within 15 s, percent", by_name(outcomes, AttackKind::Jump, 15.0));
    let mut rows = vec![by_rule];
    rows.extend(by_radar(outcomes, AttackKind::Jump, Some(Reason::Radar)));
    rows
}

fn named(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let kinds = [AttackKind::Frozen, AttackKind::Replay, AttackKind::Duplicate, AttackKind::Swapped];
    let named = kinds.map(|kind| {
        let figure = match kind {
            AttackKind::Swapped => "swapped: named within 30 s at each identity, percent".to_owned(),
            _ => format!("{}: named within 30 s, percent", kind.name()),
        };
        let row = row(figure, by_name(outcomes, kind, 30.0));
        if kind == AttackKind::Swapped { row.limitation(SWAPPED) } else { row }
    });
    let hours: f64 = outcomes.iter().map(|outcome| outcome.integrity.clean.identity_h).sum();
    let false_flags = outcomes.iter().flat_map(|outcome| &outcome.integrity.clean.flags);
    let rules = kinds.into_iter().filter_map(AttackKind::reason).collect::<Vec<_>>();
    let of_rules = false_flags.filter(|flag| rules.iter().any(|&rule| flag.reasons.contains(rule)));
    let mut rows = Vec::from(named);
    rows.push(
        row("false flags by these names in 100 h (n: hours)", rate(of_rules.count(), hours, 100.0))
            .decimals(2),
    );
    rows
}

fn shift(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let observable = of(outcomes, AttackKind::Time).filter(|attack| attack.is_observable);
    let named = |limit_s: f64| {
        move |attack: &AttackDetection| attack.named_delay_s().is_some_and(|delay_s| delay_s <= limit_s)
    };
    let flagged = |attack: &AttackDetection| attack.delay_s.is_some_and(|delay_s| delay_s <= 90.0);
    vec![
        row(
            "time shift of 2 s, observable: named within 90 s, percent",
            share(observable.clone().map(named(90.0))),
        )
        .limitation(SHIFT),
        row(
            "time shift of 2 s, observable: named within 60 s, percent",
            share(observable.clone().map(named(60.0))),
        ),
        row(
            "time shift of 2 s, observable: flagged within 90 s for whatever reason, percent",
            share(observable.map(flagged)),
        ),
    ]
}

/// Output for a drone whose drifting transponder is flagged.
fn shown(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let each: Vec<FlaggedCoverage> = of(outcomes, AttackKind::Drift).map(|attack| attack.shown).collect();
    let near: Vec<(f64, f64)> =
        each.iter().map(|shown| (100.0 * shown.near_slots as f64, shown.seen_slots as f64)).collect();
    let squares: Vec<(f64, f64)> = each.iter().map(|shown| (shown.squares, shown.points as f64)).collect();
    vec![
        row(
            "drift, flagged: slots with a point within 60 m of the drone / slots with a plot of it, percent",
            ratio(&near),
        )
        .limitation(FLAGGED),
        row("drift, flagged: NEES over ground of its points", ratio(&squares)).decimals(2),
    ]
}

/// Marks of drones with and without a transponder, in flights without an attack and in those of `spoof`.
fn uncooperative(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let flights = outcomes.iter().filter(|outcome| is_clean(outcome) || is_of(outcome, AttackKind::Drift));
    let each: Vec<UncooperativeScore> = flights.map(|outcome| outcome.integrity.uncooperative).collect();
    let marked = each.iter().flat_map(|found| (0..found.aircraft).map(|aircraft| aircraft < found.marked));
    let false_marks: usize = each.iter().map(|found| found.false_marks).sum();
    let marked_liars: usize = each.iter().map(|found| found.marked_liars).sum();
    let hours = each.iter().map(|found| found.equipped_h).sum();
    vec![
        row("`uncooperative` within 20 s: drones without transponder, percent (n: aircraft)", share(marked)),
        row(
            "`uncooperative` in 8 h of drones with a transponder (n: hours)",
            rate(false_marks, hours, UNCOOPERATIVE_H),
        )
        .decimals(2)
        .limitation(UNCOOPERATIVE),
        row(
            "the same, with marks on drones while their transponders are attacked",
            rate(false_marks + marked_liars, hours, UNCOOPERATIVE_H),
        )
        .decimals(2),
    ]
}

fn jamming(outcomes: &[FlightOutcome]) -> Vec<ResultRow> {
    let of = |outcome: &FlightOutcome| outcome.integrity.jamming;
    let jammed: Vec<JammingScore> =
        outcomes.iter().filter(|outcome| is_of(outcome, AttackKind::Jammed)).filter_map(of).collect();
    let in_time = |jamming: &JammingScore| jamming.delay_s.is_some_and(|delay_s| delay_s <= 30.0);
    let others = || outcomes.iter().filter(|outcome| !is_of(outcome, AttackKind::Jammed));
    let false_alerts = others().filter_map(of).map(|jamming| jamming.false_alerts).sum();
    let hours = others().map(|outcome| outcome.integrity.clean.identity_h).sum();
    vec![
        row("3 of 8 jammed: alert within 30 s, percent", share(jammed.iter().map(in_time)))
            .limitation(JAMMING),
        row("alerts of jamming in 100 h without any (n: hours)", rate(false_alerts, hours, 100.0))
            .decimals(2),
    ]
}
