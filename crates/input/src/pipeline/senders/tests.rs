use proptest::prelude::*;

use super::rivals::RIVALS;
use super::*;
use site::config::Input;

/// The demonstration site: a radar (0), whose inputs name these sources, and a transponder receiver (1).
fn senders(sources: &[&str]) -> Senders {
    let site = include_str!("../../../../../config/demo.toml");
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
    /// Decides on a record in a datagram of its own; also returns the contests to report.
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

    /// The takeover that a record causes.
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
fn first_sender_is_used_and_contest_reported_once() {
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
    // The owner falls silent: after 3 s the second sender is accepted.
    assert!(!senders.counts(PLOTS, B, 112.7));
    assert_eq!(senders.takeover(PLOTS, B, 112.8), Some((from(A), from(B))));
    assert!(!senders.counts(PLOTS, A, 112.9), "it comes back too late");
}

#[test]
fn restarted_sender_on_another_port_is_no_contest() {
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
fn duplicate_line_is_no_rival_until_it_sends_more() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..80 {
        // The copying line is ahead of the accepted sender.
        let second = 0.25 * f64::from(step);
        assert!(!senders.counts(PLOTS, B, second), "{second}");
        assert!(senders.copies(PLOTS, A, second + 0.1, (B, second)), "{second}");
        assert_eq!(senders.contests(at(second + 0.2)), [], "{second}");
    }
    // One datagram that the owner does not send.
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
fn two_rivals_do_not_clear_each_other() {
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
fn configured_source_lines_complement_each_other() {
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
    // A third line is recognised through the second.
    senders.hear(from("10.0.0.3:1"), at(31.0));
    same(&mut senders, "10.0.0.3:1", B, 31.0);
    assert!(senders.counts(PLOTS, A, 31.1) && senders.counts(PLOTS, "10.0.0.3:1", 31.2));
    // For a minute the lines send different datagrams.
    for step in 0..260 {
        let second = 32.0 + 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        let counts = senders.counts(PLOTS, B, second);
        assert!(if second < 88.0 { counts } else { second < 93.0 || !counts }, "{second}");
    }
}

#[test]
fn faster_redundant_line_takes_nothing_over() {
    let mut senders = senders(&["10.0.0.1", "10.0.0.2"]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..60 {
        let second = 0.25 * f64::from(step);
        senders.bring_the_same(from(A).ip(), from(B).ip(), at(second));
        assert_eq!(senders.takeover(PLOTS, B, second), None, "{second}");
        // The other line's copy is not handled again.
        senders.hear(from(A), at(second + 0.1));
    }
    // The accepted line is cut.
    let after = (60..90).find_map(|step| senders.takeover(PLOTS, A, 0.25 * f64::from(step)));
    assert_eq!(after, Some((from(B), from(A))));
}

#[test]
fn copies_without_configured_source_are_not_redundant() {
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
fn foreign_sender_is_reported_at_once_with_a_source() {
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
    // A receiver whose inputs name no source accepts any host.
    assert_eq!(senders.admit((SensorIndex(1), 129), from(B), at(20.0)), Ok(()));
    // Only a few hosts of a flood are distinguished.
    for host in 0..1_000_u32 {
        let _ = senders.admit(radar, SocketAddr::new(Ipv4Addr::from(0x0b00_0000 + host).into(), 1), at(21.0));
    }
    assert!(senders.strangers.len() <= STRANGERS);
}

#[test]
fn connection_is_accepted_beside_the_configured_source() {
    let site = include_str!("../../../../../config/demo.toml");
    let mut config = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let sensor = &mut config.sensors[0];
    sensor.inputs[0].source = Some("10.0.0.1".parse().unwrap());
    let of = |format, address: &str| site::config::Connection {
        format,
        address: address.to_owned(),
        ..site::config::Connection::default()
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
fn foreign_sender_is_ignored_while_the_radar_sends() {
    let mut senders = senders(&[]);
    let other_port = "10.0.0.1:4009";
    // Service messages from another host while the radar has sent only plots, and the reverse.
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
fn late_takeover_of_a_dead_radar_names_both_senders() {
    let mut senders = senders(&[]);
    for step in 0..20 {
        assert_eq!(senders.takeover(PLOTS, A, 0.25 * f64::from(step)), None);
        assert_eq!(senders.takeover(SERVICES, A, 0.25 * f64::from(step)), None);
    }
    assert_eq!(senders.takeover(SERVICES, B, 5_000.0), Some((from(A), from(B))));
    assert_eq!(senders.takeover(PLOTS, B, 5_000.1), None, "once for both");
    // The receiver of a transponder may change: drones fly from one to the next.
    let drone = transponder(b"ONE         ");
    assert_eq!(senders.takeover(drone, A, 5_001.0), None);
    assert_eq!(senders.takeover(drone, B, 5_101.0), None);
}

#[test]
fn changing_ports_are_one_sender() {
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
fn configured_source_host_is_one_sender() {
    for (sources, both) in [(&[][..], false), (&["10.0.0.1"], true)] {
        let mut senders = senders(sources);
        for step in 0..40 {
            let second = 0.25 * f64::from(step);
            assert!(senders.counts(PLOTS, "10.0.0.1:4000", second));
            // A port used for less than 2 s represents its host.
            assert!(step < 9 || senders.counts(PLOTS, "10.0.0.1:4001", second) == both, "{sources:?}");
        }
    }
}

#[test]
fn transponders_are_checked_one_by_one() {
    let mut senders = senders(&[]);
    let (one, two) = (transponder(b"ONE         "), transponder(b"TWO         "));
    for step in 0..10 {
        let second = 2.0 * f64::from(step);
        // Two drones that send directly, and a third sender with the identity of the second drone.
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
fn sender_with_unused_reports_stays_active() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for step in 1..40 {
        let second = 0.25 * f64::from(step);
        senders.hear(from(A), at(second));
        senders.keep_active(PLOTS, from(A), at(second));
        senders.keep_active(PLOTS, from(B), at(second));
        assert!(!senders.counts(PLOTS, B, second));
    }
}

#[test]
fn radar_without_targets_stays_active() {
    let mut senders = senders(&[]);
    assert!(senders.counts(PLOTS, A, 0.0));
    for second in 1..20 {
        assert!(senders.counts(SERVICES, A, f64::from(second)));
        assert!(!senders.counts(PLOTS, B, f64::from(second) + 0.5));
    }
}

proptest! {
    /// In any order, a sender is accepted only if it was accepted last, or the last accepted one has been silent.
    #[test]
    fn sender_changes_only_after_a_silence(
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
