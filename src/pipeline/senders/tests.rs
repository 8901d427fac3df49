use proptest::prelude::*;

use super::*;

/// The demonstration site: a radar (0) and a transponder receiver (1).
fn senders(source: Option<&str>) -> Senders {
    let site = include_str!("../../../config/demo.toml");
    let named = source.map_or(String::new(), |source| format!(", source = \"{source}\""));
    let site = site.replace(
        "interface = \"127.0.0.1\" }]\n\n[[sensors]]",
        &format!("interface = \"127.0.0.1\"{named} }}]\n\n[[sensors]]"),
    );
    let config = Config::parse(&site, "site.toml", std::iter::empty()).unwrap();
    assert_eq!(config.sensors[0].inputs[0].source.is_some(), source.is_some());
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
    fn say(&mut self, subject: Subject, sender: &str, second: f64) -> Judged {
        self.hear(from(sender), at(second));
        self.judge(subject, from(sender), at(second))
    }

    fn counts(&mut self, subject: Subject, sender: &str, second: f64) -> bool {
        self.say(subject, sender, second) == Judged::Counts
    }
}

const A: &str = "10.0.0.1:4000";
const B: &str = "10.0.0.2:5000";

#[test]
fn the_first_counts_while_it_speaks_and_the_contest_is_told_once() {
    let mut senders = senders(None);
    let mut told = Vec::new();
    for step in 0..40 {
        let second = 100.0 + 0.25 * f64::from(step);
        assert!(senders.counts(PLOTS, A, second));
        match senders.say(PLOTS, B, second + 0.1) {
            Judged::Counts => panic!("two count"),
            Judged::Refused(contest) => told.extend(contest.map(|contest| (second, contest))),
        }
    }
    let [(second, contest)] = told[..] else { panic!("{told:?}") };
    assert!((101.0..=102.0).contains(&second), "{second}");
    assert_eq!((contest.counts, contest.refused, contest.category), (from(A), from(B), 48));
    assert_eq!(contest.source, DataSource { sac: 70, sic: 41 });
    assert_eq!(senders.contests(at(110.0)), [contest]);
    assert_eq!(senders.contests(at(115.0)), [], "the second one is silent");
    // The first one falls silent: after 3 s the second one counts.
    assert!(!senders.counts(PLOTS, B, 112.7));
    assert!(senders.counts(PLOTS, B, 112.8));
    assert!(!senders.counts(PLOTS, A, 112.9), "it comes back too late");
}

#[test]
fn a_sender_that_starts_again_on_another_port_is_no_contest() {
    let mut senders = senders(None);
    for step in 0..20 {
        assert!(senders.counts(PLOTS, "10.0.0.1:4000", 0.25 * f64::from(step)));
    }
    for step in 20..60 {
        let second = 0.25 * f64::from(step);
        let judged = senders.say(PLOTS, "10.0.0.1:4001", second);
        assert!(if second < 7.75 {
            judged == Judged::Refused(None)
        } else {
            second < 8.0 || judged == Judged::Counts
        });
        assert_eq!(senders.contests(at(second)), []);
    }
}

#[test]
fn redundant_lines_complete_each_other() {
    let mut senders = senders(None);
    assert!(senders.counts(PLOTS, A, 0.0));
    assert!(!senders.counts(PLOTS, B, 0.2), "not known yet");
    senders.bring_the_same(from(B), from(A), at(0.3));
    for step in 1..100 {
        let second = 0.3 * f64::from(step);
        assert!(senders.counts(PLOTS, if step % 3 == 0 { A } else { B }, second + 0.3), "{second}");
        if step % 5 == 0 {
            senders.bring_the_same(from(A), from(B), at(second + 0.3));
        }
    }
    assert_eq!(senders.contests(at(30.0)), []);
    // A third line is known through the second.
    senders.hear(from("10.0.0.3:1"), at(31.0));
    senders.bring_the_same(from("10.0.0.3:1"), from(B), at(31.0));
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
fn a_port_for_each_datagram_is_one_sender() {
    let mut senders = senders(None);
    for step in 0..2_000_u32 {
        let second = 0.1 * f64::from(step);
        assert!(senders.counts(PLOTS, &format!("10.0.0.1:{}", 10_000 + step), second));
        assert!(!senders.counts(PLOTS, &format!("10.0.0.2:{}", 10_000 + step), second), "another host");
    }
    let contests = senders.contests(at(200.0));
    assert_eq!(contests.len(), 1, "{contests:?}");
    assert_eq!(contests[0].refused, from("10.0.0.2:11999"), "by its latest port");
    assert!(senders.ports.0.len() <= ADDRESSES && senders.heard[&PLOTS].rivals.len() <= RIVALS);
}

#[test]
fn a_host_that_is_named_as_source_is_one_sender() {
    for (source, both) in [(None, false), (Some("10.0.0.1"), true)] {
        let mut senders = senders(source);
        for step in 0..40 {
            let second = 0.25 * f64::from(step);
            assert!(senders.counts(PLOTS, "10.0.0.1:4000", second));
            // A port that is younger than 2 s stands for its host.
            assert!(step < 9 || senders.counts(PLOTS, "10.0.0.1:4001", second) == both, "{source:?}");
        }
    }
}

#[test]
fn transponders_are_judged_one_by_one() {
    let mut senders = senders(None);
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
    // A radar's service messages may come from another port than its plots.
    assert!(senders.counts(PLOTS, A, 20.0));
    assert!(senders.counts(Subject { category: 34, ..PLOTS }, B, 20.0));
}

#[test]
fn a_sender_whose_reports_are_not_used_still_speaks() {
    let mut senders = senders(None);
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
    let mut senders = senders(None);
    let services = Subject { category: 34, ..PLOTS };
    assert!(senders.counts(PLOTS, A, 0.0));
    for second in 1..20 {
        assert!(senders.counts(services, A, f64::from(second)));
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
        let mut senders = senders(None);
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
