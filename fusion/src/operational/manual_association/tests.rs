//! Two drones side by side, each with a transponder and a radar track, and an operator's correlations.

use super::*;
use crate::operational::ASSOCIATE_LLR;
use crate::operational::tests::two_drones::{APART_M, START, TRACKS, identity, radar, reports, settings};
use crate::point::{AssociationEvidence, Rival};
use crate::report::{Plot, Report, SensorIndex};
use crate::time::SECOND;
use crate::{Emission, Engine, Point, Source};

/// Flies the reports of the flight that `keep` accepts, with these decisions, each at its second. Returns everything
/// published, and the decisions with their first slots.
fn fly(
    keep: impl Fn(i64, &Report) -> bool,
    correlations: &[(i64, ManualAssociation)],
) -> (Engine, Vec<Emission>, Vec<(Slot, ManualAssociation)>) {
    let mut engine = Engine::new(settings(true)).unwrap();
    let (mut emissions, mut made) = (Vec::new(), Vec::new());
    let mut waiting = correlations.iter();
    let mut next = waiting.next();
    for (received, report) in reports(60) {
        let second = received.nanos() / SECOND - START;
        while let Some((_, correlation)) = next.filter(|(at, _)| *at <= second) {
            engine.correlate(*correlation).unwrap();
            made.push((engine.next_slot().unwrap(), *correlation));
            next = waiting.next();
        }
        emissions.extend(engine.advance(received));
        if keep(second, &report) {
            engine.handle(report).unwrap();
        }
    }
    emissions.extend(engine.finish());
    (engine, emissions, made)
}

fn correlation(track: u16, which: usize, verdict: Verdict) -> ManualAssociation {
    ManualAssociation { radar: radar(track), transponder: identity(which), verdict }
}

/// Radar track and transponder of each point.
fn parts(emission: &Emission) -> Vec<(Option<u16>, Option<Identity>)> {
    let part = |point: &Point| {
        let transponder = point.source.transponder().map(|part| part.identity);
        (point.source.radar().map(|part| part.track.number), transponder)
    };
    emission.points.iter().map(part).collect()
}

/// The emissions from that slot on until that second of the flight.
fn between(emissions: &[Emission], from: Slot, until: i64) -> &[Emission] {
    let first = emissions.partition_point(|emission| emission.slot < from);
    let last = emissions.partition_point(|emission| emission.time.nanos() < (START + until) * SECOND);
    &emissions[first..last]
}

fn of_track(emission: &Emission, number: u16) -> Option<&Point> {
    emission.points.iter().find(|point| point.source.radar().is_some_and(|part| part.track.number == number))
}

const EVERYTHING: fn(i64, &Report) -> bool = |_, _| true;
const FIRST: Option<u16> = Some(TRACKS[0]);

#[test]
fn nearest_pairs_associate_and_rivals_are_reported() {
    let (_, emissions, _) = fly(EVERYTHING, &[]);
    let late = between(&emissions, emissions[100].slot, 50);
    assert!(late.len() > 60);
    for emission in late {
        assert_eq!(parts(emission), [0, 1].map(|which| (Some(TRACKS[which]), Some(identity(which)))));
        for (which, point) in emission.points.iter().enumerate() {
            let Source::Fused(_, _, pair) = &point.source else { panic!("{point:?}") };
            let AssociationEvidence::Likelihood { score } = pair.because else { panic!("{pair:?}") };
            assert!(score > ASSOCIATE_LLR);
            for competitor in &point.competitors {
                assert!(competitor.score < score && !competitor.decorrelated, "{competitor:?}");
                match competitor.who {
                    Rival::Radar(track) => assert_eq!(track, radar(TRACKS[1 - which])),
                    Rival::Transponder { identity: other, .. } => assert_eq!(other, identity(1 - which)),
                }
            }
        }
    }
}

#[test]
fn correlated_pair_is_fused_despite_a_nearer_track() {
    let (engine, emissions, made) = fly(EVERYTHING, &[(30, correlation(TRACKS[0], 1, Verdict::Correlated))]);
    let since = made[0].0;
    let before = &emissions[emissions.partition_point(|emission| emission.slot < since) - 1];
    assert_eq!(parts(before)[0], (FIRST, Some(identity(0))));
    let correlated = between(&emissions, since, 55);
    assert_eq!(correlated[0].slot, since, "from the next slot on");
    assert!(correlated.len() > 100);
    for emission in correlated {
        let fused = of_track(emission, TRACKS[0]).unwrap();
        let Source::Fused(_, transponder, pair) = &fused.source else { panic!("{fused:?}") };
        assert_eq!(transponder.identity, identity(1));
        assert!(pair.distance_m > APART_M);
        assert!(matches!(pair.because, AssociationEvidence::Manual { .. }), "{pair:?}");
        assert!(parts(emission).contains(&(None, Some(identity(0)))), "the other is alone: {emission:?}");
        assert_eq!(of_track(emission, TRACKS[1]), None, "the second track has lost its transponder");
    }
    // The competitors are published.
    let last = correlated.last().unwrap();
    let fused = of_track(last, TRACKS[0]).unwrap();
    let who: Vec<Rival> = fused.competitors.iter().map(|competitor| competitor.who).collect();
    let transponder = Rival::Transponder { sensor: SensorIndex(1), number: Some(1), identity: identity(0) };
    assert!(
        who.len() == 2 && who.contains(&Rival::Radar(radar(TRACKS[1]))) && who.contains(&transponder),
        "{who:?}"
    );
    assert!(fused.competitors.iter().all(|competitor| competitor.score > ASSOCIATE_LLR), "{fused:?}");
    assert!(fused.competitors.is_sorted_by(|a, b| a.score >= b.score), "{fused:?}");
    let alone = last.points.iter().find(|point| point.source.radar().is_none()).unwrap();
    assert_eq!(alone.competitors.len(), 1, "{alone:?}");
    assert_eq!(alone.competitors[0].who, Rival::Radar(radar(TRACKS[0])));
    let held = ActiveAssociation { correlation: correlation(TRACKS[0], 1, Verdict::Correlated), since };
    assert_eq!(engine.correlations(), [held]);
}

#[test]
fn correlation_overrides_a_bird_classification() {
    let (_, mut emissions, _) = fly(EVERYTHING, &[]);
    assert_eq!(parts(emissions.last().unwrap()).len(), 2);
    let mut engine = Engine::new(settings(true)).unwrap();
    let birds = |report| match report {
        Report::Plot(plot) => Report::Plot(Plot { uav_probability: Some(0.0), ..plot }),
        fix => fix,
    };
    emissions.clear();
    for (received, report) in reports(60) {
        emissions.extend(engine.advance(received));
        engine.handle(birds(report)).unwrap();
        if received.nanos() == (START + 30) * SECOND + SECOND / 5 {
            engine.correlate(correlation(TRACKS[0], 0, Verdict::Correlated)).unwrap();
        }
    }
    let (since, until) = (engine.correlations()[0].since, START + 50);
    for emission in emissions.iter().filter(|emission| emission.time.nanos() < until * SECOND) {
        let is_fused = parts(emission).contains(&(FIRST, Some(identity(0))));
        assert_eq!(is_fused, emission.slot >= since, "{emission:?}");
    }
}

#[test]
fn decorrelated_pair_stays_apart_until_left_to_the_evidence() {
    let pair = |verdict| correlation(TRACKS[0], 0, verdict);
    let correlations = [(25, pair(Verdict::Decorrelated)), (45, pair(Verdict::Automatic))];
    let (engine, emissions, made) = fly(EVERYTHING, &correlations);
    let (apart, together) = (made[0].0, made[1].0);
    for emission in between(&emissions, apart, 100).iter().take_while(|emission| emission.slot < together) {
        let parts = parts(emission);
        assert!(parts.contains(&(FIRST, None)) && parts.contains(&(None, Some(identity(0)))), "{parts:?}");
        assert!(parts.contains(&(Some(TRACKS[1]), Some(identity(1)))), "the others go on: {parts:?}");
        // The evidence favours it nevertheless.
        let alone = of_track(emission, TRACKS[0]).unwrap();
        let competitor = alone.competitors.first().unwrap();
        assert!(competitor.score > ASSOCIATE_LLR && competitor.decorrelated, "{competitor:?}");
        assert!(matches!(competitor.who, Rival::Transponder { identity: other, .. } if other == identity(0)));
    }
    let again = between(&emissions, together, 55);
    assert!(again.len() > 20);
    assert!(again.iter().all(|emission| parts(emission).contains(&(FIRST, Some(identity(0))))));
    assert_eq!(engine.correlations(), []);
}

#[test]
fn withdrawn_correlation_splits_the_aircraft() {
    // The radar detects one drone, and the receiver hears the other, which was never near.
    let keep = |_, report: &Report| match report {
        Report::Plot(plot) => plot.track.number == TRACKS[0],
        Report::Fix(fix) => fix.identity == identity(1),
        Report::Bearing(_) => false,
    };
    let pair = |verdict| correlation(TRACKS[0], 1, verdict);
    let (_, emissions, made) = fly(keep, &[(25, pair(Verdict::Correlated)), (40, pair(Verdict::Automatic))]);
    for emission in between(&emissions, made[0].0, 53) {
        let is_fused = parts(emission).contains(&(FIRST, Some(identity(1))));
        assert_eq!(is_fused, emission.slot < made[1].0, "{emission:?}");
    }
    let last = &emissions[emissions.partition_point(|emission| emission.slot < made[1].0)];
    assert!(parts(last).contains(&(FIRST, None)), "{last:?}");
}

#[test]
fn a_decision_ends_with_the_track_number() {
    // Longer than the break of the track number.
    let keep = |second: i64, report: &Report| !matches!(report, Report::Plot(plot) if plot.track.number == TRACKS[0] && (26..33).contains(&second));
    let correlated = [(20, correlation(TRACKS[0], 0, Verdict::Decorrelated))];
    let (engine, emissions, made) = fly(keep, &correlated);
    let before = between(&emissions, made[0].0, 25);
    assert!(before.iter().all(|emission| parts(emission).contains(&(FIRST, None))));
    assert_eq!(engine.correlations(), []);
    let after = between(&emissions, emissions[160].slot, 55);
    assert!(after.len() > 40);
    assert!(after.iter().all(|emission| parts(emission).contains(&(FIRST, Some(identity(0))))));

    // Shorter than the break: the same track.
    let keep = |second: i64, report: &Report| !matches!(report, Report::Plot(plot) if plot.track.number == TRACKS[0] && (26..30).contains(&second));
    let (engine, emissions, _) = fly(keep, &correlated);
    assert_eq!(engine.correlations().len(), 1);
    let after = between(&emissions, emissions[160].slot, 55);
    assert!(after.iter().all(|emission| parts(emission).contains(&(FIRST, None))));
}

#[test]
fn one_radar_track_is_one_transponder_and_the_last_word_counts() {
    use Verdict::{Automatic, Correlated, Decorrelated};
    let held = |correlations: &[(u16, usize, Verdict)]| {
        let correlations: Vec<_> =
            correlations.iter().map(|&(track, which, v)| (30, correlation(track, which, v))).collect();
        let (engine, ..) = fly(EVERYTHING, &correlations);
        let told = |held: &ActiveAssociation| {
            let ManualAssociation { radar, transponder, verdict } = held.correlation;
            (radar.number, usize::from(transponder == identity(1)), verdict)
        };
        engine.correlations().iter().map(told).collect::<Vec<_>>()
    };
    assert_eq!(held(&[(7, 0, Correlated), (7, 1, Correlated)]), [(7, 1, Correlated)], "the same radar track");
    assert_eq!(held(&[(7, 0, Correlated), (8, 0, Correlated)]), [(8, 0, Correlated)], "the same transponder");
    let both = [(7, 1, Correlated), (8, 0, Correlated)];
    assert_eq!(held(&both), both);
    assert_eq!(held(&[(7, 0, Correlated), (7, 0, Decorrelated)]), [(7, 0, Decorrelated)]);
    let apart = [(7, 0, Decorrelated), (7, 1, Decorrelated)];
    assert_eq!(held(&apart), apart);
    assert_eq!(held(&[(7, 0, Decorrelated), (8, 0, Automatic), (7, 0, Automatic)]), []);
}

#[test]
fn correlation_of_an_absent_track_is_refused() {
    let pair = correlation(TRACKS[0], 0, Verdict::Correlated);
    let mut engine = Engine::new(settings(true)).unwrap();
    assert_eq!(engine.correlate(pair), Err(AssociationRefusal::NoRadarTrack), "nothing has come");
    let (mut engine, ..) = fly(EVERYTHING, &[]);
    assert_eq!(
        engine.correlate(correlation(9, 0, Verdict::Correlated)),
        Err(AssociationRefusal::NoRadarTrack)
    );
    let stranger = Identity::new(b"NOBODY      ", None).unwrap();
    let unknown = ManualAssociation { transponder: stranger, ..pair };
    assert_eq!(engine.correlate(unknown), Err(AssociationRefusal::NoTransponder));
    assert_eq!(engine.correlate(pair), Ok(()));
    // Silent for longer than the break, although its plots are still kept.
    let keep = |second: i64, report: &Report| {
        second < 50 || !matches!(report, Report::Plot(plot) if plot.track.number == TRACKS[0])
    };
    let (mut engine, ..) = fly(keep, &[]);
    assert_eq!(engine.correlate(pair), Err(AssociationRefusal::NoRadarTrack));
    assert_eq!(engine.correlate(correlation(TRACKS[1], 0, Verdict::Correlated)), Ok(()));

    let mut reference = Engine::new(settings(false)).unwrap();
    assert_eq!(reference.correlate(pair), Err(AssociationRefusal::Reference));
    assert!(!reference.knows_correlations() && engine.knows_correlations());
}

#[test]
fn a_silence_of_all_ends_decisions() {
    let (mut engine, ..) = fly(EVERYTHING, &[(30, correlation(TRACKS[0], 0, Verdict::Decorrelated))]);
    assert_eq!(engine.correlations().len(), 1);
    engine.advance(Time::from_nanos((START + 200) * SECOND)).for_each(drop);
    assert_eq!(engine.correlations(), []);
}

#[test]
fn the_same_decisions_at_the_same_slots_give_the_same_points() {
    let correlations = [
        (20, correlation(TRACKS[0], 1, Verdict::Correlated)),
        (35, correlation(TRACKS[0], 0, Verdict::Correlated)),
        (35, correlation(TRACKS[1], 1, Verdict::Decorrelated)),
        (45, correlation(TRACKS[1], 1, Verdict::Automatic)),
    ];
    let (live, expected, made) = fly(EVERYTHING, &correlations);
    let replay = |plan: Vec<(Slot, ManualAssociation)>| {
        let mut engine = Engine::new(settings(true)).unwrap();
        engine.plan(plan);
        let mut emissions = Vec::new();
        for (received, report) in reports(60) {
            emissions.extend(engine.advance(received));
            engine.handle(report).unwrap();
        }
        emissions.extend(engine.finish());
        (engine, emissions)
    };
    let (engine, emissions) = replay(made.clone());
    assert!(emissions == expected);
    assert_eq!((engine.correlations(), engine.missed()), (live.correlations(), 0));
    assert!(replay(Vec::new()).1 != expected, "decisions change nothing");

    // Decisions from before the recording apply as soon as the track is present. Those without a track are counted.
    let early = (Slot(made[0].0.0 - 10_000), made[0].1);
    let (engine, emissions) = replay(vec![early, (early.0, correlation(9, 0, Verdict::Correlated))]);
    assert_eq!(engine.correlations(), [ActiveAssociation { correlation: early.1, since: early.0 }]);
    assert_eq!(engine.missed(), 1);
    let late = between(&emissions, emissions[60].slot, 50);
    assert!(late.iter().all(|emission| parts(emission).contains(&(FIRST, Some(identity(1))))));
}

/// The service ends at one second of the flight and starts again at another. Returns the outcome of a decision of
/// second 30, and the engine after the restart.
fn over_a_restart(ends: i64, starts: i64) -> (Vec<RestoredAssociation>, Engine, Vec<Emission>) {
    let correlated = correlation(TRACKS[0], 1, Verdict::Correlated);
    let mut before = Engine::new(settings(true)).unwrap();
    let mut is_decided = false;
    for (received, report) in reports(60) {
        let second = received.nanos() / SECOND - START;
        if second >= ends {
            break;
        }
        before.advance(received).for_each(drop);
        before.handle(report).unwrap();
        if second >= 30 && !is_decided {
            before.correlate(correlated).unwrap();
            is_decided = true;
        }
    }
    before.finish().for_each(drop);
    let kept = before.saved_associations();
    assert_eq!((kept.len(), kept[0].held.correlation), (1, correlated));
    assert!((START + ends) * SECOND - kept[0].heard.nanos() < 3 * SECOND, "{kept:?}");

    let mut after = Engine::new(settings(true)).unwrap();
    after.resume(kept.clone());
    assert_eq!(after.saved_associations(), kept, "a restart soon after would know it, too");
    let mut emissions = Vec::new();
    for (received, report) in reports(60) {
        if received.nanos() / SECOND - START >= starts {
            emissions.extend(after.advance(received));
            // Reports from before the restart are not received again.
            if report.time().nanos() >= (START + starts) * SECOND {
                after.handle(report).unwrap();
            }
        }
    }
    emissions.extend(after.finish());
    (after.resumed(), after, emissions)
}

#[test]
fn decision_survives_restart_if_radar_track_returns_in_time() {
    let (resumed, engine, emissions) = over_a_restart(36, 38);
    let [RestoredAssociation::Holds(held)] = resumed[..] else { panic!("{resumed:?}") };
    assert_eq!((engine.correlations(), engine.missed()), (vec![held], 0));
    assert_eq!(engine.saved_associations()[0].held, held);
    // From the first point of that track on, as it was decided.
    let fused: Vec<_> = emissions.iter().filter(|emission| of_track(emission, TRACKS[0]).is_some()).collect();
    assert!(fused.len() > 20, "{}", fused.len());
    assert!(fused.iter().all(|emission| !parts(emission).contains(&(FIRST, Some(identity(0))))));
    assert!(fused.iter().any(|emission| parts(emission).contains(&(FIRST, Some(identity(1))))));
}

#[test]
fn a_restart_that_takes_longer_than_the_break_ends_it() {
    let (resumed, engine, _) = over_a_restart(36, 44);
    assert!(matches!(resumed[..], [RestoredAssociation::Ended(_)]), "{resumed:?}");
    assert_eq!((engine.correlations(), engine.saved_associations(), engine.missed()), (vec![], vec![], 1));
    // Immediately in a profile without decisions.
    let mut reference = Engine::new(settings(false)).unwrap();
    let held =
        ActiveAssociation { correlation: correlation(TRACKS[0], 1, Verdict::Correlated), since: Slot(1) };
    reference.resume(vec![SavedAssociation { held, heard: Time::default() }]);
    assert_eq!(reference.resumed(), [RestoredAssociation::Ended(held)]);
}
