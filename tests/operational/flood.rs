//! Thousands of invented identities per second.

use fusion::time::{SECOND, Time};
use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::Profile;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::Simulation;

use crate::invented::{admit, invented, received};
use crate::{flight, points, site};

/// The first minute, with `per_s` invented reports per second from second 20 to 30, from `of` identities.
fn flooded(simulation: &Simulation, per_s: u64, of: u64) -> Vec<Reception> {
    let start = simulation.datagrams[0].received;
    let like = simulation.datagrams.iter().find(|datagram| datagram.payload[0] == 129).unwrap();
    let mut receptions: Vec<Reception> = simulation.receptions().collect();
    receptions.retain(|reception| reception.received.unwrap().seconds_since(start) < 60.0);
    let from = start.nanos() + 20 * SECOND;
    receptions.extend((0..10 * per_s).map(|number| {
        let at = Time::from_nanos(from + number as i64 * SECOND / per_s as i64);
        let payload = invented(&like.payload, number % of, at);
        received(at, payload)
    }));
    receptions.sort_by_key(|reception| reception.received);
    receptions
}

fn is_flooded(reception: &Reception) -> bool {
    crate::invented::is_invented(&reception.payload)
}

#[test]
fn identities_heard_once_change_nothing_of_what_is_put_out() {
    let simulation = flight("crossing", 1);
    let config = site(&simulation, Profile::Operational);
    let receptions = flooded(&simulation, 6_000, u64::MAX);
    let without = points(receptions.iter().filter(|reception| !is_flooded(reception)).cloned(), &config);
    assert!(without.len() > 1000);

    let mut pipeline = Pipeline::new(&config, Masks::default());
    let mut most = 0;
    for reception in &receptions {
        pipeline.receive(reception);
        most = pipeline.emissions().map(|emission| emission.points.len()).fold(most, usize::max);
    }
    assert!(most < 30, "{most} aircraft in a slot");
    assert!(pipeline.engine().numbers().used() <= 8, "numbers were given");
    assert_eq!(pipeline.engine().transponders().count(), 8);
    let heard: u64 =
        pipeline.tally().newcomers.iter().filter(|((_, fate), _)| *fate == "heard").map(|(_, n)| n).sum();
    assert_eq!(heard, 60_008);
    assert_eq!(points(receptions.into_iter(), &config), without);
}

#[test]
fn identity_decisions_in_any_order_between_deadlines_agree() {
    let simulation = flight("crossing", 1);
    let mut config = site(&simulation, Profile::Operational);
    admit(&mut config, 3);
    // Each identity is received every second or two, which is more than may be admitted.
    let mut receptions = flooded(&simulation, 150, 300);
    const SLOT_NS: i64 = SECOND / 4;
    let slot = |reception: &Reception| reception.received.unwrap().nanos().div_euclid(SLOT_NS);
    for reception in &mut receptions {
        reception.received = Some(Time::from_nanos(slot(reception) * SLOT_NS));
    }
    let forward = points(receptions.iter().cloned(), &config);
    receptions.chunk_by_mut(|a, b| a.received == b.received).for_each(<[Reception]>::reverse);
    assert_eq!(points(receptions.iter().cloned(), &config), forward);
    let mut pipeline = Pipeline::new(&config, Masks::default());
    receptions.iter().for_each(|reception| pipeline.receive(reception));
    let numbers = pipeline.engine().numbers().used();
    // 8 drones, 60 accumulated permits, and 3 per second during the flood.
    assert!((60..=60 + 8 + 3 * 45).contains(&numbers), "{numbers}");
}
