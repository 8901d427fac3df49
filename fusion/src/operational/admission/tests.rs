use super::*;
use crate::frames::Enu;

const SENSOR: SensorIndex = SensorIndex(1);
const SLOT: i64 = SECOND / 4;

fn receiver(max_new_per_s: u32) -> ReceiverSettings {
    ReceiverSettings { horizontal_m: 3.0, vertical_m: 5.0, delay_s: Some(0.0), period_s: 3.0, max_new_per_s }
}

fn at(seconds: f64) -> Time {
    Time::from_nanos((seconds * SECOND as f64) as i64)
}

/// A report of the identity with this number at this distance east, metres.
fn fix(identity: u64, seconds: f64, east_m: f64) -> Fix {
    let identity = Identity::new(format!("{identity:09}").as_bytes(), None).unwrap();
    Fix::new(SENSOR, identity, at(seconds), Enu::new(east_m, 0.0, 100.0))
}

struct Gate {
    admission: Admission,
    receiver: ReceiverSettings,
    next: u64,
    total: BTreeMap<&'static str, u64>,
    flood: Option<u32>,
}

impl Gate {
    fn new(max_new_per_s: u32) -> Self {
        let (total, receiver) = (BTreeMap::new(), receiver(max_new_per_s));
        Self { admission: Admission::default(), receiver, next: 0, total, flood: None }
    }

    fn turn(&mut self, seconds: f64) {
        for newcomers in self.admission.take_counts() {
            for (fate, count) in newcomers.fates() {
                *self.total.entry(fate).or_default() += u64::from(count);
            }
            self.flood = newcomers.flood;
        }
        let receiver = self.receiver;
        self.admission.begin_slot(at(seconds), |_| Some(receiver));
    }

    fn admit(&mut self, fix: &Fix) -> Option<AdmittedIdentity> {
        self.next += 1;
        self.admission.offer(fix, &self.receiver, TargetId::nth(self.next))
    }

    fn offer(&mut self, fix: &Fix) -> Option<usize> {
        self.admit(fix).map(|admitted| admitted.waited.len())
    }

    fn count(&self, fate: &str) -> u64 {
        self.total.get(fate).copied().unwrap_or(0)
    }
}

#[test]
fn the_second_report_that_agrees_lets_an_identity_in() {
    let mut gate = Gate::new(50);
    gate.turn(0.0);
    assert_eq!(gate.offer(&fix(1, 0.0, 0.0)), None, "the first");
    assert_eq!(gate.offer(&fix(1, 0.01, 0.0)), None, "the same, by another receiver");
    assert_eq!(gate.offer(&fix(1, 3.0, 5000.0)), None, "nobody flies that fast");
    assert_eq!(gate.offer(&fix(1, 6.0, 150.0)), Some(1), "with the one of the two that agrees");
    assert_eq!(gate.offer(&fix(1, 9.0, 9999.0)), Some(0), "it is known");
    // Targets are ordered by their first reports.
    assert_eq!(gate.offer(&fix(2, 9.0, 0.0)), None);
    assert_eq!(gate.offer(&fix(3, 9.0, 0.0)), None);
    let admitted = gate.admit(&fix(3, 10.0, 0.0)).unwrap();
    let earlier = gate.admit(&fix(2, 10.0, 0.0)).unwrap();
    assert!(earlier.target < admitted.target);
    // An admitted identity is remembered for a minute.
    gate.turn(59.0);
    assert_eq!(gate.offer(&fix(1, 59.0, 0.0)), Some(0));
    gate.turn(119.0);
    assert_eq!(gate.offer(&fix(1, 119.0, 0.0)), Some(0));
    gate.turn(179.5);
    assert_eq!(gate.offer(&fix(1, 179.5, 0.0)), None);
}

/// An identity that continues to report its position is admitted, whatever positions are forged for it.
#[test]
fn contradictory_position_does_not_block_an_identity() {
    let mut gate = Gate::new(50);
    gate.turn(0.0);
    let mut lies = 0..;
    for (second, at_m) in [(0.0, 0.0), (3.0, 50.0)] {
        assert_eq!(gate.offer(&fix(1, second + 0.5, 50_000.0 * f64::from(lies.next().unwrap() + 1))), None);
        let let_in = gate.offer(&fix(1, second, at_m));
        assert_eq!(let_in, (second > 0.0).then_some(1));
    }
}

#[test]
fn a_million_invented_identities_cost_a_bounded_table() {
    let mut gate = Gate::new(50);
    let mut identity = 1_000_000;
    for slot in 0..600 {
        let seconds = f64::from(slot) * 0.25;
        gate.turn(seconds);
        for _ in 0..1500 {
            assert_eq!(gate.offer(&fix(identity, seconds, 0.0)), None);
            identity += 1;
        }
        // An identity that reports its position every 3 s, from the middle on.
        if slot >= 300 && slot % 12 == 0 {
            assert_eq!(gate.offer(&fix(7, seconds, 30.0 * seconds)).is_some(), slot > 300, "{slot}");
        }
        assert!(gate.admission.waiting.len() <= WAITING_MAX, "{}", gate.admission.waiting.len());
        let queued: usize = gate.admission.receivers.values().map(|of| of.queue.len()).sum();
        assert!(queued <= WAITING_MAX + 1, "{queued}");
    }
    assert_eq!(gate.admission.admitted.len(), 1);
    assert_eq!(gate.flood, Some(6001));
    for slot in 600..1200 {
        gate.turn(f64::from(slot) * 0.25);
    }
    assert_eq!(gate.flood, None, "it is over");
    assert!(gate.admission.waiting.is_empty() && gate.admission.receivers[&SENSOR].queue.is_empty());
    let gone = ["heard_once", "inconsistent", "rate_limited", "crowded_out"].map(|fate| gate.count(fate));
    assert_eq!(gone.iter().sum::<u64>() + gate.count("admitted"), gate.count("heard"));
    assert_eq!((gate.count("heard"), gate.count("admitted"), gone[1], gone[2]), (900_001, 1, 0, 0));
    assert_eq!(gone[0], WAITING_MAX as u64, "who waited at the end; the others gave way");
}

#[test]
fn identities_received_twice_are_admitted_at_a_limited_rate() {
    let mut gate = Gate::new(50);
    let mut let_in = Vec::new();
    for second in 0..40 {
        let seconds = f64::from(second);
        gate.turn(seconds);
        let mut count = 0;
        for of in 0..500 {
            let identity = 1000 * (second as u64) + of;
            assert_eq!(gate.offer(&fix(identity, seconds, 0.0)), None);
            count += usize::from(gate.offer(&fix(identity, seconds + 0.1, 0.0)).is_some());
        }
        let_in.push(count);
    }
    assert_eq!(let_in[..2], [500, 500], "a city at once");
    assert!(let_in[2..].iter().all(|&count| count <= 101), "{let_in:?}");
    assert_eq!(let_in.iter().sum::<usize>(), 1000 + 39 * 50);
    assert!(gate.admission.receivers[&SENSOR].flood.is_some());
    gate.turn(200.0);
    gate.turn(200.25);
    assert_eq!(gate.count("rate_limited"), gate.count("heard") - gate.count("admitted"));
}

#[test]
fn usual_rate_is_no_flood() {
    let mut gate = Gate::new(50);
    // A city that is present when the service starts, then forty new identities a second.
    gate.turn(0.0);
    (0..900).for_each(|identity| assert_eq!(gate.offer(&fix(identity, 0.0, 0.0)), None));
    for slot in 1..400 {
        let seconds = slot as f64 * SLOT as f64 / SECOND as f64;
        gate.turn(seconds);
        (0..10).for_each(|of| assert_eq!(gate.offer(&fix(10_000 + 10 * slot + of, seconds, 0.0)), None));
        assert_eq!(gate.flood, None, "{seconds}");
    }
}

/// Airliners fly faster than any drone.
#[test]
fn crewed_aircraft_may_be_faster() {
    let mut identity = 0;
    // Whether an identity is admitted with its second report, at this distance from the first, a second later.
    let mut is_let_in = |kind: AircraftKind, away_m: f64| {
        let mut gate = Gate::new(50);
        gate.turn(0.0);
        identity += 1;
        let of_kind = |seconds, east_m| {
            let mut fix = fix(identity, seconds, east_m);
            fix.aircraft.kind = kind;
            fix
        };
        assert_eq!(gate.offer(&of_kind(0.0, 0.0)), None);
        gate.offer(&of_kind(1.0, away_m)).is_some()
    };
    // Including 100 m for the errors of the positions.
    assert!(is_let_in(AircraftKind::Crewed, 449.0) && !is_let_in(AircraftKind::Crewed, 451.0));
    for kind in [AircraftKind::Unmanned, AircraftKind::Vehicle] {
        assert!(is_let_in(kind, 199.0) && !is_let_in(kind, 201.0), "{kind:?}");
    }
}
