use asterix::DataSource;
use fusion::slots::SlotGrid;
use fusion::time::Time;
use jiff::SignedDuration;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::{GatewayCounts, InputBatcher};
use service::live::ClockSource;

fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn state(is_synchronised: Option<bool>, bound_s: Option<f64>) -> ClockState {
    ClockState { is_synchronised, bound_s, by: Some(ClockSource::Chrony) }
}

const GOOD: Option<bool> = Some(true);
const BAD: Option<bool> = Some(false);

fn line(sensors: &[usize], received: u64) -> (Vec<usize>, LineStatus) {
    (sensors.to_vec(), LineStatus { joined: true, received, ..LineStatus::default() })
}

fn report(
    node: &str,
    report_number: u64,
    is_synchronised: Option<bool>,
    lines: &[(Vec<usize>, LineStatus)],
) -> GatewayReport {
    let clock = GatewayClock { state: state(is_synchronised, None), ..GatewayClock::default() };
    let (counts, heard) = (GatewayCounts::default(), Vec::new());
    GatewayReport {
        node: node.to_owned(),
        counts,
        lines: lines.to_vec(),
        report_number,
        clock,
        recent_datagrams: heard,
        config: 0,
        sent: Time::default(),
        ahead_s: None,
    }
}

#[test]
fn clock_standing_has_hysteresis_and_unknown_is_not_good() {
    let mut rule = ClockRule::default();
    let mut standing =
        |bound_ms: f64| rule.update_clock(state(GOOD, Some(bound_ms * 1e-3)), Duration::ZERO).standing;
    let bounds_ms = [3.0, 20.0, 20.1, 17.0, 15.9, 19.0, 100.0, 101.0, 81.0, 79.0, 17.0, 15.0, 500.0, 1.0];
    use ClockStanding::{Degraded, Good, Warning};
    let expected = [
        Good, Good, Warning, Warning, Good, Good, Warning, Degraded, Degraded, Warning, Warning, Good,
        Degraded, Good,
    ];
    assert_eq!(bounds_ms.map(&mut standing), expected);
    let mut standing =
        |is_synchronised| rule.update_clock(state(is_synchronised, None), Duration::ZERO).standing;
    assert_eq!(standing(GOOD), ClockStanding::Unbounded);
    assert_eq!(standing(BAD), ClockStanding::Unsynchronised);
    assert_eq!(standing(None), ClockStanding::Unknown);
    assert_eq!(
        ClockRule::default().update_clock(ClockState::default(), Duration::ZERO),
        GatewayClock::default()
    );
}

/// A gateway with two lines and a lost clock, and another gateway. Both are evaluated each second.
struct TwoGateways {
    rule: ClockRule,
    now_s: f64,
    own: [u64; 2],
    other: [u64; 2],
    report_number: u64,
}

impl TwoGateways {
    fn new() -> Self {
        Self { rule: ClockRule::default(), now_s: 0.0, own: [0; 2], other: [0; 2], report_number: 0 }
    }

    /// Simulates a second. `hears` states for each gateway and line whether a datagram arrives; `other` is the other gateway's
    /// report, if any.
    fn second(
        &mut self,
        own: Option<bool>,
        hears: [[bool; 2]; 2],
        other: Option<Option<bool>>,
    ) -> GatewayClock {
        self.now_s += 1.0;
        for (received, heard) in [(&mut self.own, hears[0]), (&mut self.other, hears[1])] {
            received.iter_mut().zip(heard).for_each(|(received, heard)| *received += u64::from(heard));
        }
        self.report_number += u64::from(other.is_some());
        let lines = |received: [u64; 2]| [line(&[0], received[0]), line(&[1, 2], received[1])];
        self.rule.update_clock(state(own, None), seconds(self.now_s));
        let others: Vec<_> = other
            .map(|is_good| report("g0", self.report_number, is_good, &lines(self.other)))
            .into_iter()
            .collect();
        self.rule.decide(&lines(self.own), Some(&others), seconds(self.now_s))
    }

    /// Simulates `count` such seconds. Returns the last result.
    fn seconds(
        &mut self,
        count: usize,
        own: Option<bool>,
        hears: [[bool; 2]; 2],
        other: Option<Option<bool>>,
    ) -> GatewayClock {
        (0..count).map(|_| self.second(own, hears, other)).last().expect("a second at least")
    }
}

const ALL: [[bool; 2]; 2] = [[true; 2]; 2];

/// The log answers late on a busy machine, and not at all while the servers elect a leader.
#[test]
fn unanswered_check_keeps_other_gateways() {
    let mut pair = TwoGateways::new();
    assert!(pair.seconds(61, BAD, ALL, Some(GOOD)).is_silent);
    let unanswered = |pair: &mut TwoGateways, seconds_more: u32| {
        let silent = (0..seconds_more).map(|_| {
            pair.now_s += 1.0;
            pair.rule.update_clock(state(BAD, None), seconds(pair.now_s));
            pair.rule.decide(&[line(&[0], 90), line(&[1, 2], 90)], None, seconds(pair.now_s)).is_silent
        });
        silent.collect::<Vec<_>>()
    };
    assert_eq!(unanswered(&mut pair, 9), [true; 9]);
    // The other gateway has 3 s from the next answer on, and counts as alive after its next report.
    assert!(pair.seconds(2, BAD, ALL, None).is_silent);
    assert!(pair.second(BAD, ALL, Some(GOOD)).is_silent);
    let silent = unanswered(&mut pair, 13);
    assert_eq!(
        silent,
        [vec![true; 11], vec![false; 2]].concat(),
        "10 s without an answer, and the usual 3 s"
    );
}

#[test]
fn unfit_gateway_is_silent_while_another_carries_its_lines() {
    let mut pair = TwoGateways::new();
    for second in 0..60 {
        let clock = pair.second(BAD, ALL, Some(GOOD));
        assert!(!clock.is_unfit && !clock.is_silent, "after {second} s: {clock:?}");
    }
    let clock = pair.second(BAD, ALL, Some(GOOD));
    assert!(clock.is_unfit && clock.is_silent, "{clock:?}");
    // An unknown state of the clock does not end the condition.
    assert!(pair.second(None, ALL, Some(GOOD)).is_silent);
    // The other gateway is gone, and comes back.
    assert!(pair.seconds(2, BAD, ALL, None).is_silent, "the log may not have answered");
    let clock = pair.second(BAD, ALL, None);
    assert!(clock.is_unfit && !clock.is_silent, "{clock:?}");
    pair.seconds(10, BAD, ALL, None);
    assert!(!pair.second(BAD, ALL, Some(GOOD)).is_silent, "what is found may be what it left behind");
    assert!(pair.second(BAD, ALL, Some(GOOD)).is_silent);
    // The other gateway's clock is lost, too: a wrong clock is better than no data.
    assert!(!pair.second(BAD, ALL, Some(BAD)).is_silent);
    assert!(!pair.second(BAD, ALL, Some(None)).is_silent);
    assert!(pair.second(BAD, ALL, Some(GOOD)).is_silent);
    // The clock is good again at once, and unfit a minute after it is lost again.
    let clock = pair.second(GOOD, ALL, Some(GOOD));
    assert!(!clock.is_unfit && !clock.is_silent, "{clock:?}");
    assert!(!pair.seconds(60, BAD, ALL, Some(GOOD)).is_silent);
    assert!(pair.second(BAD, ALL, Some(GOOD)).is_silent);
}

#[test]
fn gateway_with_old_report_is_gone_after_3_s() {
    let mut pair = TwoGateways::new();
    assert!(pair.seconds(61, BAD, ALL, Some(GOOD)).is_silent);
    let report_number = pair.report_number;
    let silent: Vec<bool> = (0..4)
        .map(|_| {
            pair.report_number = report_number - 1;
            pair.second(BAD, [[true; 2], [false; 2]], Some(GOOD)).is_silent
        })
        .collect();
    assert_eq!(silent, [true, true, false, false]);
}

#[test]
fn silence_requires_every_line_at_other_gateways() {
    let mut pair = TwoGateways::new();
    assert!(pair.seconds(61, BAD, ALL, Some(GOOD)).is_silent);
    // Neither line receives anything, so nothing is missed.
    assert!(pair.seconds(30, BAD, [[false; 2]; 2], Some(GOOD)).is_silent);
    // A rare datagram is reported one second later.
    assert!(pair.second(BAD, [[true, true], [true, false]], Some(GOOD)).is_silent);
    assert!(pair.seconds(30, BAD, [[true, false], [true, true]], Some(GOOD)).is_silent);
    // The other gateway no longer receives one of the lines.
    let deaf = [[true, true], [true, false]];
    assert!(pair.seconds(3, BAD, deaf, Some(GOOD)).is_silent);
    assert!(!pair.second(BAD, deaf, Some(GOOD)).is_silent);
    assert!(
        !pair.seconds(30, BAD, [[true, false], [true, false]], Some(GOOD)).is_silent,
        "it still owes one"
    );
    assert!(pair.second(BAD, ALL, Some(GOOD)).is_silent);
}

#[test]
fn lines_are_carried_by_several_gateways_none_silent() {
    let decide = |others: &dyn Fn(u64) -> Vec<GatewayReport>| {
        let mut rule = ClockRule::default();
        let mut silent = false;
        for second in 0..62 {
            rule.update_clock(state(BAD, None), seconds(second as f64));
            let lines = [line(&[0], second), line(&[0], second), line(&[1], second)];
            silent = rule.decide(&lines, Some(&others(second)), seconds(second as f64)).is_silent;
        }
        silent
    };
    let one = |second| report("g0", second, GOOD, &[line(&[0], second), line(&[0], second)]);
    let other = |second| report("g2", second, GOOD, &[line(&[1], second)]);
    assert!(decide(&|second| vec![one(second), other(second)]));
    assert!(!decide(&|second| vec![one(second)]));
    // A second line of the same sensor is a separate line.
    let half = |second| report("g0", second, GOOD, &[line(&[0], second)]);
    assert!(!decide(&|second| vec![half(second), other(second)]));
    let silent = |second| {
        let mut silent = other(second);
        silent.clock.is_silent = true;
        silent
    };
    assert!(!decide(&|second| vec![one(second), silent(second)]));
    // A line that the other gateway has not opened.
    let closed = |second| {
        let mut closed = other(second);
        closed.lines[0].1.joined = false;
        closed
    };
    assert!(!decide(&|second| vec![one(second), closed(second)]));
}

/// Two gateways that receive the same two lines and each miss 3 % of the datagrams. The second gateway's clock can be stepped.
struct SharedFeed {
    random: ChaCha8Rng,
    batches: [InputBatcher; 2],
    stamps: [DatagramStamps; 2],
    now_ms: i64,
    step_ms: i64,
}

const SENSORS: [DataSource; 2] = [DataSource { sac: 25, sic: 1 }, DataSource { sac: 25, sic: 2 }];

impl SharedFeed {
    fn new(step_ms: i64) -> Self {
        let to = "239.1.1.1:8048".parse().unwrap();
        let batches = [0, step_ms]
            .map(|by| InputBatcher::new(SlotGrid::default(), SENSORS.map(|sensor| (sensor, to)), at(by)));
        let stamps = [DatagramStamps::default(), DatagramStamps::default()];
        Self { random: ChaCha8Rng::seed_from_u64(1), batches, stamps, now_ms: 0, step_ms }
    }

    /// Receives for `for_ms` a datagram every `every_ms`, which arrives up to 2 ms later at either gateway.
    fn receive(&mut self, for_ms: i64, every_ms: i64) {
        let ends = self.now_ms + for_ms;
        while self.now_ms < ends {
            self.now_ms += every_ms;
            let mut payload = vec![48; 40];
            self.random.fill(&mut payload[..]);
            for gateway in 0..2 {
                let clock_ms = self.now_ms + if gateway == 1 { self.step_ms } else { 0 };
                for input in self.batches[gateway].close_slots(at(clock_ms)) {
                    self.stamps[gateway].note(&input);
                }
                if self.random.random_bool(0.03) {
                    continue;
                }
                let received = at(clock_ms) + SignedDuration::from_micros(self.random.random_range(0..2_000));
                let line = (payload[0] % 2).into();
                let full = self.batches[gateway].add(
                    line,
                    received,
                    "127.0.0.1:5000".parse().unwrap(),
                    payload.clone(),
                );
                full.iter().for_each(|input| self.stamps[gateway].note(input));
            }
        }
    }

    fn reports(&self) -> [GatewayReport; 2] {
        [0, 1].map(|gateway| {
            let recent_datagrams = self.stamps[gateway].recent();
            GatewayReport { recent_datagrams, ..report(["g0", "g1"][gateway], 0, GOOD, &[]) }
        })
    }
}

fn at(ms: i64) -> Time {
    Time::from_nanos(1_795_168_800_000_000_000 + ms * 1_000_000)
}

#[test]
fn gateways_report_the_same_datagrams_despite_wrong_clocks() {
    for every_ms in [1, 7, 40, 900] {
        for step_ms in [0, 50, -50, 130, -4_000, 86_400_000] {
            let mut feed = SharedFeed::new(step_ms);
            feed.receive(20_000, every_ms);
            let reports = feed.reports();
            assert!(reports.iter().all(|report| report.recent_datagrams.len() <= 128));
            let found = differences(&reports);
            let [found] = &found[..] else { panic!("{every_ms} {step_ms}: {found:?}") };
            let off_ms = found.difference_s * 1e3 + step_ms as f64;
            assert!(off_ms.abs() < 2.0, "{every_ms} {step_ms}: {found:?}");
            let least = match every_ms {
                900 => 8,
                // Slots that end at different times differ a little in their lowest hashes.
                _ => 24,
            };
            assert!(found.datagrams >= least, "{every_ms} {step_ms}: {found:?}");
        }
    }
}

#[test]
fn clocks_change_state_after_three_checks() {
    let (mut feed, mut comparison) = (SharedFeed::new(0), ClockComparison::default());
    let mut look = |feed: &mut SharedFeed| {
        feed.receive(1_000, 10);
        comparison.update(&feed.reports())
    };
    for _ in 0..5 {
        assert!(look(&mut feed).iter().all(|clock| !clock.apart));
    }
    feed.step_ms = 50;
    let apart: Vec<bool> = (0..8).map(|_| look(&mut feed)[0].apart).collect();
    let first = apart.iter().position(|is_apart| *is_apart).unwrap();
    // Half of two seconds of datagrams has to follow the step, and then three checks.
    assert!((2..=5).contains(&first) && apart[first..].iter().all(|is_apart| *is_apart), "{apart:?}");
    // Between the limits the state does not change.
    feed.step_ms = 17;
    assert!((0..8).all(|_| look(&mut feed)[0].apart));
    feed.step_ms = 10;
    let apart: Vec<bool> = (0..8).map(|_| look(&mut feed)[0].apart).collect();
    assert!(apart[..2].iter().all(|is_apart| *is_apart) && !apart[7], "{apart:?}");
    feed.step_ms = 17;
    assert!((0..8).all(|_| !look(&mut feed)[0].apart));
}

#[test]
fn too_few_common_datagrams_give_no_difference() {
    let mut feed = SharedFeed::new(50);
    feed.receive(5_000, 10);
    let mut comparison = ClockComparison::default();
    let [one, other] = feed.reports();
    let is_known = |reports: &[GatewayReport]| !differences(reports).is_empty();
    assert!(is_known(&[one.clone(), other.clone()]) && !is_known(std::slice::from_ref(&one)));
    let deaf = GatewayReport { recent_datagrams: other.recent_datagrams[..4].to_vec(), ..other.clone() };
    assert!(!is_known(&[one.clone(), deaf.clone()]));
    // Copies of a datagram are ambiguous and not compared.
    let twice = GatewayReport {
        recent_datagrams: [&other.recent_datagrams[..], &other.recent_datagrams].concat(),
        ..other.clone()
    };
    assert!(!is_known(&[one.clone(), twice]));
    // One check without common datagrams does not forget the pair; ten do.
    assert!((0..3).all(|_| comparison.update(&[one.clone(), other.clone()]).len() == 1));
    let known: Vec<usize> = (0..12).map(|_| comparison.update(&[one.clone(), deaf.clone()]).len()).collect();
    assert_eq!(known, [1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0]);
}
