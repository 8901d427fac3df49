//! The rows of the table.

use fusion::integrity::Reason;
use utm_fusion::evaluate::{AttackKind, Detection, Jamming, Shown, Uncooperative};

use super::flights::What;
use super::flown::Outcome;
use super::shares::{median, rate, ratio, share};
use crate::asked::Bound::{AtLeast, AtMost, Between};
use crate::asked::{Asked, measured};
use crate::summary::Mean;

/// What is beyond the figures that are not reached.
const WHY_BY_RADAR: &str = "one radar track seldom says enough, and in 10 to 20 % of attacks the radar shows the drone for less \
                            than five seconds after the lie shows; a track that begins elsewhere later is one of several \
                            that could be the drone's, and is believed only by the way it flies.";
const WHY_FALSE: &str = "slow errors in azimuth beyond their learnt size, in turns and far out; drones without a transponder that \
                         fly alike for half a minute.";
const WHY_NAMED: &str = "drones within 100 m of each other when they exchange identities, or one that is silent then; receivers of \
                         several metres of noise.";
const WHY_SHIFT: &str = "a late stamp is an offset along the track, which interpolation between reports has, too; two seconds of \
                         it show only where the drone turns or changes its speed under a radar track that is its own. With a \
                         lower threshold honest ones were flagged, a real one among them.";
const WHY_SHOWN: &str =
    "until a radar track elsewhere is believed to be the drone's it is held back as one that has walked off.";
const WHY_UNCOOPERATIVE: &str = "a silent drone explains the likeliest aircraft around, which may be another; a drone that is jammed \
                                 for more than two minutes is one without a transponder.";
const WHY_JAMMING: &str = "a drone that was silent before it was jammed counts for none.";

/// Hours in which one false flag is allowed.
const FALSE_H: f64 = 12.0;
/// The same of drones with a transponder that count as uncooperative.
const UNCOOPERATIVE_H: f64 = 8.0;

/// Every row.
pub fn asked(outcomes: &[Outcome]) -> Vec<Asked> {
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

fn is_of(outcome: &Outcome, kind: AttackKind) -> bool {
    outcome.what == What::Attack(kind)
}

fn is_clean(outcome: &Outcome) -> bool {
    matches!(outcome.what, What::Clean(_))
}

/// Attacks of a kind that count.
fn of(outcomes: &[Outcome], kind: AttackKind) -> impl Iterator<Item = &Detection> + Clone {
    let of_kind = outcomes.iter().filter(move |outcome| is_of(outcome, kind));
    of_kind.flat_map(|outcome| &outcome.integrity.attacks).filter(|attack| attack.begin.is_some())
}

pub fn row(figure: impl Into<String>, reached: Option<Mean>) -> Asked {
    Asked::new(figure, measured(reached, None)).decimals(0)
}

/// What a radar has to find, with any reason or with this one.
fn by_radar(outcomes: &[Outcome], kind: AttackKind, reason: Option<Reason>) -> Vec<Asked> {
    let delay_s = move |attack: &Detection| match reason {
        Some(reason) => attack.delay_by_s(reason),
        None => attack.delay_s,
    };
    let within = move |limit_s: f64| move |attack: &Detection| delay_s(attack).is_some_and(|s| s <= limit_s);
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
        .required(AtLeast(60.0))
        .why(WHY_BY_RADAR)
        .ambition(AtLeast(85.0)),
        row(format!("{name}, observable: flagged within 45 s, percent"), share(observable.map(within(45.0))))
            .required(AtLeast(40.0))
            .why(WHY_BY_RADAR)
            .ambition(AtLeast(65.0)),
        row(
            format!("{name}, all: flagged before the flight ends, percent"),
            share(all.clone().map(|attack| delay_s(attack).is_some())),
        )
        .required(AtLeast(75.0))
        .why(WHY_BY_RADAR)
        .ambition(AtLeast(92.0)),
        row(format!("{name}, all: flagged within 60 s, percent"), share(all.clone().map(within(60.0)))),
        row(format!("{name}, all: flagged within 45 s, percent"), share(all.clone().map(within(45.0)))),
        row(format!("{name}, all: median delay, s"), median(all.map(delay_s)))
            .required(AtMost(75.0))
            .why(WHY_BY_RADAR)
            .ambition(AtMost(35.0)),
    ]
}

/// Flags where nobody lies: in the flights without attack, in those of `spoof`, and there before the drift.
fn clean(outcomes: &[Outcome]) -> Asked {
    let is_spoof = |outcome: &Outcome| is_of(outcome, AttackKind::Drift);
    let clean = outcomes.iter().filter(|outcome| is_clean(outcome) || is_spoof(outcome));
    let (mut flags, mut hours) = (0, 0.0);
    for outcome in clean {
        flags += outcome.integrity.clean.flags.len();
        hours += outcome.integrity.clean.identity_h;
    }
    row("false flags in 12 h of identities that do not lie (n: hours)", rate(flags, hours, FALSE_H))
        .decimals(2)
        .required(AtMost(1.0))
        .why(WHY_FALSE)
        .ambition(AtMost(0.5))
}

/// What rules on reports alone have to find by its name, unless a silence keeps them from it.
fn by_name(outcomes: &[Outcome], kind: AttackKind, limit_s: f64) -> Option<Mean> {
    let heard = of(outcomes, kind).filter(|attack| !attack.is_silent);
    share(heard.map(|attack| attack.named_delay_s().is_some_and(|s| s <= limit_s)))
}

fn jump(outcomes: &[Outcome]) -> Vec<Asked> {
    let by_rule = row("jump of 100 m: named within 15 s, percent", by_name(outcomes, AttackKind::Jump, 15.0))
        .required(AtLeast(95.0))
        .why(WHY_NAMED)
        .ambition(AtLeast(99.0));
    let mut rows = vec![by_rule];
    rows.extend(by_radar(outcomes, AttackKind::Jump, Some(Reason::Radar)));
    rows
}

fn named(outcomes: &[Outcome]) -> Vec<Asked> {
    let kinds = [AttackKind::Frozen, AttackKind::Replay, AttackKind::Duplicate, AttackKind::Swapped];
    let named = kinds.map(|kind| {
        let figure = match kind {
            AttackKind::Swapped => "swapped: named within 30 s at each identity, percent".to_owned(),
            _ => format!("{}: named within 30 s, percent", kind.name()),
        };
        row(figure, by_name(outcomes, kind, 30.0))
            .required(AtLeast(95.0))
            .why(WHY_NAMED)
            .ambition(AtLeast(99.0))
    });
    let hours: f64 = outcomes.iter().map(|outcome| outcome.integrity.clean.identity_h).sum();
    let false_flags = outcomes.iter().flat_map(|outcome| &outcome.integrity.clean.flags);
    let rules = kinds.into_iter().filter_map(AttackKind::reason).collect::<Vec<_>>();
    let of_rules = false_flags.filter(|flag| rules.iter().any(|&rule| flag.reasons.contains(rule)));
    let mut rows = Vec::from(named);
    rows.push(
        row("false flags by these names in 100 h (n: hours)", rate(of_rules.count(), hours, 100.0))
            .decimals(2)
            .required(AtMost(0.0))
            .why(WHY_NAMED),
    );
    rows
}

fn shift(outcomes: &[Outcome]) -> Vec<Asked> {
    let observable = of(outcomes, AttackKind::Time).filter(|attack| attack.is_observable);
    let named = |limit_s: f64| {
        move |attack: &Detection| attack.named_delay_s().is_some_and(|delay_s| delay_s <= limit_s)
    };
    let flagged = |attack: &Detection| attack.delay_s.is_some_and(|delay_s| delay_s <= 90.0);
    vec![
        row(
            "time shift of 2 s, observable: named within 90 s, percent",
            share(observable.clone().map(named(90.0))),
        )
        .required(AtLeast(70.0))
        .why(WHY_SHIFT),
        row(
            "time shift of 2 s, observable: named within 60 s, percent",
            share(observable.clone().map(named(60.0))),
        )
        .ambition(AtLeast(90.0)),
        row(
            "time shift of 2 s, observable: flagged within 90 s for whatever reason, percent",
            share(observable.map(flagged)),
        ),
    ]
}

/// What is shown of a drone whose drifting transponder is flagged.
fn shown(outcomes: &[Outcome]) -> Vec<Asked> {
    let each: Vec<Shown> = of(outcomes, AttackKind::Drift).map(|attack| attack.shown).collect();
    let near: Vec<(f64, f64)> =
        each.iter().map(|shown| (100.0 * shown.near_slots as f64, shown.seen_slots as f64)).collect();
    let squares: Vec<(f64, f64)> = each.iter().map(|shown| (shown.squares, shown.points as f64)).collect();
    vec![
        row(
            "drift, flagged: slots with a point within 60 m of the drone / slots with a plot of it, percent",
            ratio(&near),
        )
        .required(AtLeast(80.0))
        .why(WHY_SHOWN)
        .ambition(AtLeast(95.0)),
        row("drift, flagged: NEES over ground of its points", ratio(&squares))
            .decimals(2)
            .required(AtMost(4.0))
            .why(WHY_SHOWN)
            .ambition(Between(0.5, 2.0)),
    ]
}

/// Drones without a transponder, and those with one, in flights without an attack and in those of `spoof`.
fn uncooperative(outcomes: &[Outcome]) -> Vec<Asked> {
    let flights = outcomes.iter().filter(|outcome| is_clean(outcome) || is_of(outcome, AttackKind::Drift));
    let each: Vec<Uncooperative> = flights.map(|outcome| outcome.integrity.uncooperative).collect();
    let marked = each.iter().flat_map(|found| (0..found.aircraft).map(|aircraft| aircraft < found.marked));
    let false_marks: usize = each.iter().map(|found| found.false_marks).sum();
    let marked_liars: usize = each.iter().map(|found| found.marked_liars).sum();
    let hours = each.iter().map(|found| found.equipped_h).sum();
    vec![
        row("`uncooperative` within 20 s: drones without transponder, percent (n: aircraft)", share(marked))
            .required(AtLeast(90.0))
            .why(WHY_UNCOOPERATIVE)
            .ambition(AtLeast(98.0)),
        row(
            "`uncooperative` in 8 h of drones with a transponder (n: hours)",
            rate(false_marks, hours, UNCOOPERATIVE_H),
        )
        .decimals(2)
        .required(AtMost(1.0))
        .why(WHY_UNCOOPERATIVE)
        .ambition(AtMost(0.33)),
        row(
            "the same, with marks on drones while their transponders lie",
            rate(false_marks + marked_liars, hours, UNCOOPERATIVE_H),
        )
        .decimals(2),
    ]
}

fn jamming(outcomes: &[Outcome]) -> Vec<Asked> {
    let of = |outcome: &Outcome| outcome.integrity.jamming;
    let jammed: Vec<Jamming> =
        outcomes.iter().filter(|outcome| is_of(outcome, AttackKind::Jammed)).filter_map(of).collect();
    let in_time = |jamming: &Jamming| jamming.delay_s.is_some_and(|delay_s| delay_s <= 30.0);
    let others = || outcomes.iter().filter(|outcome| !is_of(outcome, AttackKind::Jammed));
    let false_alerts = others().filter_map(of).map(|jamming| jamming.false_alerts).sum();
    let hours = others().map(|outcome| outcome.integrity.clean.identity_h).sum();
    vec![
        row("3 of 8 jammed: alert within 30 s, percent", share(jammed.iter().map(in_time)))
            .required(AtLeast(95.0))
            .why(WHY_JAMMING),
        row("alerts of jamming in 100 h without any (n: hours)", rate(false_alerts, hours, 100.0))
            .decimals(2)
            .required(AtMost(0.0))
            .why(WHY_JAMMING),
    ]
}
