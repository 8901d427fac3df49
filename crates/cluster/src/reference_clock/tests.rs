use super::*;

const AT_S: i64 = 1_795_168_800;

fn at(seconds: f64) -> Time {
    Time::from_nanos(AT_S * 1_000_000_000 + (seconds * 1e9) as i64)
}

fn ends(sent: Time) -> Time {
    sent + -SignedDuration::from_millis(10)
}

/// Clocks of the reader; its wall clock is off by `off_s`.
fn moment(true_s: f64, off_s: f64) -> ClockReading {
    ClockReading { steady: SignedDuration::from_secs_f64(1_000.0 + true_s), wall: at(true_s + off_s) }
}

/// A second of messages with a delay of 20 ms each. The arguments are the errors of the log's clock, of the gateways' and of the
/// reader's, in seconds.
fn second(clock: &mut NodeTime, from_s: f64, log_s: f64, gateways: &[(&str, f64)], own_s: f64) -> Vec<bool> {
    let mut refused = Vec::new();
    for quarter in 0..4 {
        for (name, off_s) in gateways {
            let true_s = from_s + 0.25 * f64::from(quarter);
            let (stamp, sent) = (at(true_s + 0.02 + log_s), at(true_s + off_s));
            let read = moment(true_s + 0.03, own_s);
            refused.push(clock.read(Some((name, sent)), stamp, ends(sent), read).is_some());
        }
    }
    refused
}

/// Time by which reference time is ahead of true time.
fn error_s(clock: &NodeTime) -> f64 {
    (clock.now(moment(0.0, 0.0)) - at(0.0)).as_secs_f64()
}

#[test]
fn one_of_two_gateways_and_a_log_may_be_wrong() {
    for off_s in [3.0, -3.0, 600.0, -600.0] {
        for liar in 0..3 {
            let mut clock = NodeTime::default();
            let off = |of| if liar == of { off_s } else { 0.0 };
            let gateways = [("g0", off(0)), ("g1", off(1))];
            let mut refused = Vec::new();
            for seconds in 0..4 {
                refused = second(&mut clock, f64::from(seconds), off(2), &gateways, 0.0);
            }
            let expected: Vec<bool> = (0..8).map(|message| liar < 2 && message % 2 == liar).collect();
            assert_eq!(refused, expected, "{liar} is off by {off_s} s");
            assert!(error_s(&clock).abs() < 0.1, "{}", error_s(&clock));
            let ahead_s = |name| clock.0.ahead(name).unwrap().as_secs_f64();
            assert!((ahead_s("g0") - off(0)).abs() < 0.1 && (ahead_s("g1") - off(1)).abs() < 0.1);
        }
    }
}

#[test]
fn readers_clock_decides_between_log_and_only_gateway() {
    for (log_s, gateway_s, own_s) in
        [(30.0, 0.0, 0.0), (0.0, 30.0, 0.0), (0.0, 0.0, 30.0), (-30.0, 0.0, 0.0), (0.0, -30.0, 0.0)]
    {
        let mut clock = NodeTime::default();
        for seconds in 0..3 {
            second(&mut clock, f64::from(seconds), log_s, &[("g0", gateway_s)], own_s);
        }
        assert!(error_s(&clock).abs() < 0.1, "{}", error_s(&clock));
    }
}

/// The reader catches up and reads all messages at one moment. A gateway whose clock was wrong is right again, and the other
/// one's clock becomes wrong.
#[test]
fn wrong_clock_before_the_window_has_no_vote_in_a_catch_up() {
    let mut clock = NodeTime::default();
    let now = moment(20.0, 0.0);
    for quarter in 0..80 {
        let true_s = 0.25 * f64::from(quarter);
        let off_s = [if true_s < 16.0 { 10.0 } else { 0.0 }, if true_s < 19.0 { 0.0 } else { 30.0 }];
        for (name, off_s) in ["g0", "g1"].into_iter().zip(off_s) {
            let (stamp, sent) = (at(true_s + 0.02), at(true_s + off_s));
            clock.read(Some((name, sent)), stamp, ends(sent), now);
        }
    }
    let now_s = (clock.now(now) - at(20.0)).as_secs_f64();
    assert!(now_s.abs() < 0.5, "{now_s}");
}

/// Another server leads the log: the timestamps jump, and no gateway's clock has changed.
#[test]
fn step_of_the_logs_clock_refuses_no_gateway() {
    for log_s in [-600.0, -30.0, -1.5, 1.5, 30.0, 600.0] {
        for gateways in [&[("g0", 0.0)][..], &[("g0", 0.0), ("g1", 0.0)]] {
            let mut clock = NodeTime::default();
            for seconds in 0..3 {
                second(&mut clock, f64::from(seconds), 0.0, gateways, 0.0);
            }
            for seconds in 3..7 {
                let refused = second(&mut clock, f64::from(seconds), log_s, gateways, 0.0);
                assert!(!refused.contains(&true), "{log_s} s, after {seconds} s: {refused:?}");
            }
            assert!(error_s(&clock).abs() < 0.1, "{log_s} s: {}", error_s(&clock));
            // The log's clock steps back.
            for seconds in 7..10 {
                let refused = second(&mut clock, f64::from(seconds), 0.0, gateways, 0.0);
                assert!(!refused.contains(&true), "{log_s} s, back after {seconds} s: {refused:?}");
            }
        }
    }
}

#[test]
fn delayed_messages_are_used() {
    let mut clock = NodeTime::default();
    let both = [("g0", 0.0), ("g1", 0.0)];
    second(&mut clock, 0.0, 0.0, &both, 0.0);
    // One gateway was cut off for 20 s; all its waiting messages arrive at once.
    for seconds in 1..21 {
        second(&mut clock, f64::from(seconds), 0.0, &both[..1], 0.0);
    }
    for message in 0..80 {
        let (stamp, sent) = (at(21.0 + 0.001 * f64::from(message)), at(1.0 + 0.25 * f64::from(message)));
        let read = moment(21.01 + 0.001 * f64::from(message), 0.0);
        assert_eq!(clock.read(Some(("g1", sent)), stamp, ends(sent), read), None, "message {message}");
    }
    assert!(!second(&mut clock, 21.25, 0.0, &both, 0.0).contains(&true));
}

#[test]
fn corrected_clock_is_used_at_once() {
    for off_s in [600.0, -600.0] {
        let mut clock = NodeTime::default();
        let gateways = |off_s| [("g0", 0.0), ("g1", off_s)];
        for seconds in 0..5 {
            second(&mut clock, f64::from(seconds), 0.0, &gateways(off_s), 0.0);
        }
        for seconds in 5..8 {
            let refused = second(&mut clock, f64::from(seconds), 0.0, &gateways(0.0), 0.0);
            assert!(!refused.contains(&true), "{off_s}: {refused:?}");
        }
    }
}

#[test]
fn slot_not_over_or_of_another_day_is_refused() {
    let mut clock = NodeTime::default();
    second(&mut clock, 0.0, 0.0, &[("g0", 0.0), ("g1", 0.0)], 0.0);
    let mut refusal =
        |ends| clock.read(Some(("g0", at(1.0))), at(1.0), ends, moment(1.0, 0.0)).map(|(why, _)| why);
    assert_eq!(refusal(at(1.9)), None);
    assert_eq!(refusal(at(2.1)), Some(InputRefusal::Slot));
    assert_eq!(refusal(Time::from_nanos(i64::MAX)), Some(InputRefusal::Slot));
    assert_eq!(refusal(at(-3_600.0)), None, "what waited for an hour");
    assert_eq!(refusal(at(-90_000.0)), Some(InputRefusal::Slot));
    assert_eq!(refusal(Time::from_nanos(i64::MIN)), Some(InputRefusal::Slot));
}

#[test]
fn number_of_known_gateways_is_bounded() {
    let mut clock = NodeTime::default();
    for message in 0..10_000 {
        let (stamp, sent) = (at(0.01 * f64::from(message)), Time::from_nanos(i64::from(message)));
        let read = moment(0.01 * f64::from(message), 0.0);
        clock.read(Some((&message.to_string(), sent)), stamp, stamp, read);
    }
    assert!(clock.0.gateways.len() <= MAX_GATEWAYS);
}

/// One report a second of gateways and of nodes whose clocks are off.
#[test]
fn node_detects_its_wrong_clock_within_3_s() {
    use crate::{MemberClock, ReportTime};
    for off_s in [3.0, -3.0, 30.0, -30.0] {
        let mut own = MemberClock::default();
        let mut look = |second: i32, off_s: f64| {
            let true_s = f64::from(second);
            let word = |member: &str, is_gateway, sent_s: f64| ReportTime {
                member: member.to_owned(),
                is_gateway,
                stamp: at(true_s + 0.05),
                sent: at(sent_s),
            };
            let words = vec![
                word("g0", true, true_s + 0.04),
                word("g1", true, true_s + 0.03),
                word("n0", false, true_s + off_s),
                word("n1", false, true_s + 100.0),
            ];
            let moment =
                ClockReading { steady: SignedDuration::from_secs(second.into()), wall: at(true_s + off_s) };
            own.update(("n0", false), words, moment);
            (own.is_wrong(), own.ahead_s().unwrap())
        };
        for second in 0..10 {
            assert!(!look(second, 0.0).0);
        }
        let wrong: Vec<bool> = (10..14).map(|second| look(second, off_s).0).collect();
        assert_eq!(wrong, [false, true, true, true], "{off_s}");
        let right: Vec<bool> = (14..18).map(|second| look(second, 0.0).0).collect();
        assert_eq!(right, [true, false, false, false], "{off_s}");
        assert!((look(18, off_s).1 - off_s).abs() < 0.1);
    }
}
