use proptest::prelude::*;

use super::rivals::RIVALS;
use super::*;
use crate::config::Input;

/// The demonstration site: a radar (0), whose inputs name these sources, and a transponder receiver (1).
fn senders(sources: &[&str]) -> Senders {
    let site = include_str!("../../../config/demo.toml");
    let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let input = config.sensors[0].inputs[0];
    let pinned = sources.iter().map(|source| Input { source: Some(source.parse().unwrap()), ..input });
    config.sensors[0].inputs.extend(pinned);
    Senders::new(&config)
}

fn at(second: f64) -> Time {
    Time::from_nanos((second * 1e9).round() as i64)
}

fn from(text: &str) -> SocketAddr {
    text.parse().unwrap()
}

const PLOTS: Subject = Subject { sensor: SensorIndex(0), category: 48, identity: None };

fn transponder(serial: &[u8; 12]) -> Subject {
    Subject { sensor: SensorIndex(1), category: 129, identity: Identity::new(serial, None) }
}

impl Senders {
    /// Judges a record in a datagram of its own; the contests that are to be reported.
    fn say(&mut self, subject: Subject, sender: &str, second: f64) -> (bool, Vec<Contest>) {
        let contests = self.hear(from(sender), at(second));
        (matches!(self.judge(subject, from(sender), &[], at(second)), Judged::Counts(_)), contests)
    }

    fn counts(&mut self, subject: Subject, sender: &str, second: f64) -> bool {
        self.say(subject, sender, second).0
    }

    /// The owner's copy of a datagram that was refused from another sender.
    fn copies(&mut self, subject: Subject, sender: &str, second: f64, earlier: (&str, f64)) -> bool {
        self.hear(from(sender), at(second));
        let earlier = [(from(earlier.0), at(earlier.1))];
        matches!(self.judge(subject, from(sender), &earlier, at(second)), Judged::Counts(_))
    }

    /// The takeover with a record.
    fn takeover(&mut self, subject: Subject, sender: &str, second: f64) -> Option<(SocketAddr, SocketAddr)> {
        self.hear(from(sender), at(second));
        match self.judge(subject, from(sender), &[], at(second)) {
            Judged::Counts(takeover) => takeover.map(|takeover| (takeover.before, takeover.after)),
            Judged::Refused => panic!("{sender} is refused at {second} s"),
        }
    }
}

const A: &str = "10.0.0.1:4000";
const B: &str = "10.0.0.2:5000";

const SERVICES: Subject = Subject { category: 34, ..PLOTS };

#[test]
fn the_first_counts_while_it_speaks_and_the_contest_is_told_once() {
    let mut senders = senders(&[]);
    let mut told = Vec::new();
    for step in 0..40 {
        let second = 100.0 + 0.25 * f64::from(step);
        let (counts, contests) = senders.say(PLOTS, A, second);
        assert!(counts);
        told.extend(contests.into_iter().map(|contest| (second, contest)));
        let (counts, contests) = senders.say(PLOTS, B, second + 0.1);
        assert!(!counts, "two count");
        told.extend(contests.into_iter().map(|contest| (second, contest)));
    }
    let [(second, contest)] = told[..] else { panic!("{told:?}") };
    assert!((102.0..=103.5).contains(&second), "{second}");
    assert_eq!((contest.counts, contest.refused, contest.category), (from(A), from(B), 48));
    assert_eq!(contest.source, DataSource { sac: 70, sic: 41 });
    assert_eq!(senders.contests(at(110.0)), [contest]);
    assert_eq!(senders.contests(at(117.0)), [], "the second one is silent");
    // The first one falls silent: after 3 s the second one counts.
    assert!(!senders.counts(PLOTS, B, 112.7));
    assert_eq!(senders.takeover(PLOTS, B, 112.8), Some((from(A), from(B))));
    assert!(!senders.counts(PLOTS, A, 112.9), "it comes back too late");
}

#[test]
fn a_sender_that_starts_again_on_another_port_is_no_contest() {
    let mut senders = senders(&[]);
    for step in 0..20 {
        assert!(senders.counts(PLOTS, "10.0.0.1:4000", 0.25 * f64::from(step)));
    }
    for step in 20..60 {
        let second = 0.25 * f64::from(step);
        let (counts, contests) = senders.say(PLOTS, "10.0.0.1:4001", second);
        assert_eq!((counts, contests), (second > 7.75, vec![]), "{second}");
        assert_eq!(senders.contests(at(second)), []);
    }
}

#[test]
fn copying_line_is_no_rival_until_it_brings_more() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..80 {
        // The copying line is ahead of the one that counts.
        let second = 0.25 * f64::from(step);
        assert!(!senders.counts(PLOTS, B, second), "{second}");
        assert!(senders.copies(PLOTS, A, second + 0.1, (B, second)), "{second}");
        assert_eq!(senders.contests(at(second + 0.2)), [], "{second}");
    }
    // One datagram that the other line does not bring.
    assert!(!senders.counts(PLOTS, B, 20.0));
    let mut named = Vec::new();
    for step in 1..40 {
        let second = 20.0 + 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        named.extend(senders.contests(at(second)).iter().map(|contest| (second, contest.refused)));
    }
    assert_eq!(named.first(), Some(&(22.25, from(B))), "as soon as it cannot come any more");
    assert!(named.last().is_some_and(|(second, _)| *second >= 26.5), "{named:?}");
}

#[test]
fn two_rivals_do_not_excuse_each_other() {
    let mut senders = senders(&[]);
    let third = "10.0.0.3:1";
    for step in 0..40 {
        let second = 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        assert!(!senders.counts(PLOTS, B, second + 0.1));
        assert!(!senders.copies(PLOTS, third, second + 0.2, (B, second + 0.1)));
    }
    let refused: Vec<SocketAddr> = senders.contests(at(10.0)).iter().map(|contest| contest.refused).collect();
    assert_eq!(refused, [from(B), from(third)]);
}

#[test]
fn lines_named_as_sources_complete_each_other() {
    let mut senders = senders(&["10.0.0.1", "10.0.0.2", "10.0.0.3"]);
    assert!(senders.counts(PLOTS, A, 0.0));
    assert!(!senders.counts(PLOTS, B, 0.2), "not known yet");
    let same = |senders: &mut Senders, one: &str, other: &str, second: f64| {
        senders.bring_the_same(from(one).ip(), from(other).ip(), at(second));
    };
    same(&mut senders, B, A, 0.3);
    for step in 1..100 {
        let second = 0.3 * f64::from(step);
        assert!(senders.counts(PLOTS, if step % 3 == 0 { A } else { B }, second + 0.3), "{second}");
        if step % 5 == 0 {
            same(&mut senders, A, B, second + 0.3);
        }
    }
    assert_eq!(senders.contests(at(30.0)), []);
    // A third line is known through the second.
    senders.hear(from("10.0.0.3:1"), at(31.0));
    same(&mut senders, "10.0.0.3:1", B, 31.0);
    assert!(senders.counts(PLOTS, A, 31.1) && senders.counts(PLOTS, "10.0.0.3:1", 31.2));
    // For a minute nothing is the same.
    for step in 0..260 {
        let second = 32.0 + 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        let counts = senders.counts(PLOTS, B, second);
        assert!(if second < 88.0 { counts } else { second < 93.0 || !counts }, "{second}");
    }
}

#[test]
fn redundant_line_ahead_of_the_other_takes_nothing_over() {
    let mut senders = senders(&["10.0.0.1", "10.0.0.2"]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..60 {
        let second = 0.25 * f64::from(step);
        senders.bring_the_same(from(A).ip(), from(B).ip(), at(second));
        assert_eq!(senders.takeover(PLOTS, B, second), None, "{second}");
        // The other's copy is not handled again.
        senders.hear(from(A), at(second + 0.1));
    }
    // The line that counts by then is cut.
    let after = (60..90).find_map(|step| senders.takeover(PLOTS, A, 0.25 * f64::from(step)));
    assert_eq!(after, Some((from(B), from(A))));
}

#[test]
fn copies_without_a_source_make_no_redundant_line() {
    let mut senders = senders(&[]);
    for step in 0..400 {
        let second = 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        if step % 80 == 0 {
            senders.bring_the_same(from(A).ip(), from(B).ip(), at(second));
        }
        assert!(!senders.counts(PLOTS, B, second + 0.1), "{second}");
    }
    assert_eq!(senders.contests(at(100.0)).len(), 1);
}

#[test]
fn source_binds_the_sensor_and_the_stranger_is_named_at_once() {
    let mut senders = senders(&["10.0.0.1"]);
    let radar = (SensorIndex(0), 48);
    let first = senders.admit(radar, from(B), at(0.0)).unwrap_err().unwrap();
    assert_eq!((first.counts, first.refused), (from("10.0.0.1:0"), from(B)));
    assert_eq!(first.reason, ContestReason::ForeignSource);
    assert_eq!(senders.admit(radar, from(B), at(0.5)), Err(None), "told once");
    assert_eq!(senders.admit(radar, from(A), at(0.5)), Ok(()));
    assert!(senders.counts(PLOTS, A, 0.5));
    let contests = senders.contests(at(1.0));
    assert_eq!(contests.len(), 1);
    assert_eq!((contests[0].counts, contests[0].refused), (from(A), from(B)));
    assert_eq!(senders.contests(at(6.0)), []);
    assert!(senders.admit(radar, from(B), at(20.0)).unwrap_err().is_some(), "it is back");
    // A receiver whose inputs name no source takes what any host sends.
    assert_eq!(senders.admit((SensorIndex(1), 129), from(B), at(20.0)), Ok(()));
    // A flood of hosts is one of a few.
    for host in 0..1_000_u32 {
        let _ = senders.admit(radar, SocketAddr::new(Ipv4Addr::from(0x0b00_0000 + host).into(), 1), at(21.0));
    }
    assert!(senders.strangers.len() <= STRANGERS);
}

#[test]
fn connection_counts_beside_the_named_source() {
    let site = include_str!("../../../config/demo.toml");
    let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let sensor = &mut config.sensors[0];
    sensor.inputs[0].source = Some("10.0.0.1".parse().unwrap());
    let of = |format, address: &str| crate::config::Connection {
        format,
        address: address.to_owned(),
        ..crate::config::Connection::default()
    };
    sensor.connections = vec![
        of(ConnectionFormat::Beast, "10.0.0.7:30005"),
        of(ConnectionFormat::Mqtt, "mqtt://broker.example:1883"),
    ];
    let mut senders = Senders::new(&config);
    let admits = |sender: &str| senders.admit((SensorIndex(0), 48), from(sender), at(1.0)).is_ok();
    let said = [A, "10.0.0.7:30005", "0.0.0.0:1883", "10.0.0.7:30006", B].map(admits);
    assert_eq!(said, [true, true, true, false, false]);
}

#[test]
fn stranger_takes_no_part_of_a_radar_that_speaks() {
    let mut senders = senders(&[]);
    let other_port = "10.0.0.1:4009";
    // Service messages of another host while the radar has sent plots alone, and the reverse.
    for (own, foreign) in [(PLOTS, SERVICES), (SERVICES, PLOTS)] {
        for step in 0..20 {
            let second = f64::from(step);
            assert!(senders.counts(own, A, second));
            assert!(!senders.counts(foreign, B, second + 0.5), "{foreign:?}");
        }
        let contests = senders.contests(at(20.0));
        assert_eq!(contests.iter().map(|one| one.refused).collect::<Vec<_>>(), [from(B)]);
        assert!(senders.counts(foreign, other_port, 20.0), "another port of its host may");
        senders = self::senders(&[]);
    }
}

#[test]
fn takeover_of_a_dead_radar_names_both_however_late() {
    let mut senders = senders(&[]);
    for step in 0..20 {
        assert_eq!(senders.takeover(PLOTS, A, 0.25 * f64::from(step)), None);
        assert_eq!(senders.takeover(SERVICES, A, 0.25 * f64::from(step)), None);
    }
    assert_eq!(senders.takeover(SERVICES, B, 5_000.0), Some((from(A), from(B))));
    assert_eq!(senders.takeover(PLOTS, B, 5_000.1), None, "once for both");
    // The first transponder's receiver may change: drones fly from one to the next.
    let drone = transponder(b"ONE         ");
    assert_eq!(senders.takeover(drone, A, 5_001.0), None);
    assert_eq!(senders.takeover(drone, B, 5_101.0), None);
}

#[test]
fn a_port_for_each_datagram_is_one_sender() {
    let mut senders = senders(&[]);
    for step in 0..2_000_u32 {
        let second = 0.1 * f64::from(step);
        assert!(senders.counts(PLOTS, &format!("10.0.0.1:{}", 10_000 + step), second));
        assert!(!senders.counts(PLOTS, &format!("10.0.0.2:{}", 10_000 + step), second), "another host");
    }
    let contests = senders.contests(at(200.0));
    assert_eq!(contests.len(), 1, "{contests:?}");
    assert_eq!(contests[0].refused, from("10.0.0.2:11999"), "by its latest port");
    assert!(senders.ports.len() <= ports::ADDRESSES && senders.heard[&PLOTS].rivals.len() <= RIVALS);
}

#[test]
fn a_host_that_is_named_as_source_is_one_sender() {
    for (sources, both) in [(&[][..], false), (&["10.0.0.1"], true)] {
        let mut senders = senders(sources);
        for step in 0..40 {
            let second = 0.25 * f64::from(step);
            assert!(senders.counts(PLOTS, "10.0.0.1:4000", second));
            // A port that is younger than 2 s stands for its host.
            assert!(step < 9 || senders.counts(PLOTS, "10.0.0.1:4001", second) == both, "{sources:?}");
        }
    }
}

#[test]
fn transponders_are_judged_one_by_one() {
    let mut senders = senders(&[]);
    let (one, two) = (transponder(b"ONE         "), transponder(b"TWO         "));
    for step in 0..10 {
        let second = 2.0 * f64::from(step);
        // Two drones that send for themselves, and a third sender that says it is the second one.
        assert!(senders.counts(one, A, second));
        assert!(senders.counts(two, B, second + 0.1));
        assert!(!senders.counts(two, "10.0.0.3:7", second + 0.2));
    }
    let contests = senders.contests(at(18.5));
    assert_eq!(contests.len(), 1);
    let [contest] = contests[..] else { panic!("{contests:?}") };
    let serial = contest.identity.map(|identity| identity.name().to_vec());
    assert_eq!((contest.category, contest.counts, serial), (129, from(B), Some(b"TWO".to_vec())));
}

#[test]
fn a_sender_whose_reports_are_not_used_still_speaks() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..40 {
        let second = 0.25 * f64::from(step);
        senders.hear(from(A), at(second));
        senders.still_speaks(PLOTS, from(A), at(second));
        senders.still_speaks(PLOTS, from(B), at(second));
        assert!(!senders.counts(PLOTS, B, second));
    }
}

#[test]
fn a_radar_with_nothing_in_sight_still_speaks_of_itself() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for second in 1..20 {
        assert!(senders.counts(SERVICES, A, f64::from(second)));
        assert!(!senders.counts(PLOTS, B, f64::from(second) + 0.5));
    }
}

proptest! {
    /// Whatever the order: a sender counts only where it is the one that counted last, or that one has been silent.
    #[test]
    fn who_counts_changes_only_after_a_silence(
        said in proptest::collection::vec((0..3_usize, 1..2_500_u32), 1..200),
    ) {
        let hosts = [A, B, "10.0.0.3:6000"];
        let mut senders = senders(&[]);
        let (mut milliseconds, mut counted): (u32, Option<(usize, u32)>) = (0, None);
        for (host, after) in said {
            milliseconds += after;
            let counts = senders.counts(PLOTS, hosts[host], f64::from(milliseconds) * 1e-3);
            let may = counted.is_none_or(|(owner, last)| owner == host || milliseconds - last > 3_000);
            prop_assert_eq!(counts, may);
            if counts {
                counted = Some((host, milliseconds));
            }
            for contest in senders.contests(at(f64::from(milliseconds) * 1e-3)) {
                prop_assert_eq!(counted.map(|(owner, _)| from(hosts[owner])), Some(contest.counts));
            }
        }
    }
}
