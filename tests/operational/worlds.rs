//! Honest aircraft with unusual flights: they neither vanish nor are accused.

use std::collections::BTreeSet;

use fusion::integrity::State;
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Simulation, simulate};

use crate::{scenario, scored, site};

/// Identities that were suspect or failed at any time.
fn accused(simulation: &Simulation) -> BTreeSet<String> {
    let config = site(simulation, Profile::Operational);
    let mut pipeline = Pipeline::new(&config, Masks::default());
    let mut accused = BTreeSet::new();
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        pipeline.emissions().for_each(drop);
        let not_trusted = pipeline
            .engine()
            .assessments()
            .filter(|known| matches!(known.integrity.state, State::Suspect | State::Failed));
        accused.extend(not_trusted.map(|known| format!("{:?}", known.identity)));
    }
    accused
}

/// The transponders are received every 1 to 2 s.
#[test]
fn braking_drones_are_never_absent() {
    for seed in 301..=304 {
        let simulation = simulate(&scenario("braking"), seed, None).unwrap();
        let evaluation = scored(&simulation, Profile::Operational);
        let pu_percent = evaluation.fused.equipped.pu_percent.unwrap();
        assert!(pu_percent > 99.9, "seed {seed}: PU {pu_percent} %");
        assert_eq!(accused(&simulation), BTreeSet::new(), "seed {seed}");
    }
}

#[test]
fn fast_aircraft_are_rarely_flagged() {
    let of = |seed| accused(&simulate(&scenario("fast"), seed, None).unwrap());
    let accused: Vec<_> = (301..=306).map(of).collect();
    // There are 36 transponders and three hours of flight.
    let count: usize = accused.iter().map(BTreeSet::len).sum();
    assert!(count <= 4, "{accused:?}");
}

/// A radar does not resolve the members of a swarm, so its tracks are no evidence against one of them.
#[test]
fn swarm_members_are_rarely_flagged() {
    let of = |seed| accused(&simulate(&scenario("swarm"), seed, None).unwrap());
    let accused: Vec<_> = (301..=304).map(of).collect();
    let count: usize = accused.iter().map(BTreeSet::len).sum();
    assert!(count <= 4, "{accused:?}");
}
