//! The network between sensors and service: loss, duplication, reordering, a second line, foreign traffic.

use std::net::Ipv4Addr;

use asterix::cat048::{self, DetectionType, PolarPosition, TargetReport, TrackNumber};
use asterix::{DataSource, TimeOfDay, encode_block};

use super::wire::{SentDatagram, after};
use fusion::time::Time;
use input::normalise::time_of_day_count;
use picture::formats::UdpFlow;
use site::config::{Address, Input};
use world::scenario::{Network, Span};
use world::streams::RandomStream;

/// A datagram as the service receives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimulatedDatagram {
    /// Time of reception.
    pub received: Time,
    /// Addresses and ports.
    pub flow: UdpFlow,
    /// Payload.
    pub payload: Vec<u8>,
}

/// Categories of foreign traffic, with random contents.
const FOREIGN_CATEGORIES: [u8; 6] = [1, 2, 8, 21, 62, 240];
/// SAC/SIC that no sensor has.
const FOREIGN_SOURCE: DataSource = DataSource { sac: 99, sic: 98 };

/// Returns the datagrams that arrive, in order of arrival. `lines` lists the inputs of each sensor.
pub fn arrivals(
    network: &Network,
    lines: &[&[Input]],
    sent: &[SentDatagram],
    (start, duration_s): (Time, f64),
    stream: &mut RandomStream,
) -> Vec<SimulatedDatagram> {
    let mut arrived = Vec::new();
    for datagram in sent {
        for (line, input) in lines[datagram.sensor].iter().enumerate() {
            let mut behind_s = if line == 0 { 0.0 } else { stream.within(network.second_line_behind_s) };
            if stream.chance(network.lost) {
                continue;
            }
            if stream.chance(network.reordered) {
                behind_s += stream.within(network.behind_s);
            }
            let flow = flow(input);
            let mut arrive = |behind_s| {
                arrived.push(SimulatedDatagram {
                    received: after(datagram.arrives, behind_s),
                    flow,
                    payload: datagram.payload.clone(),
                });
            };
            arrive(behind_s);
            if stream.chance(network.duplicated) {
                arrive(behind_s + stream.within(network.behind_s));
            }
        }
    }
    let inputs: Vec<&Input> = lines.iter().filter_map(|lines| lines.first()).collect();
    let mut foreign = |per_s: f64, make: fn(&mut RandomStream, Time) -> Option<Vec<u8>>| {
        // At a rate of 0, the first one is infinitely far away.
        let mut time_s = stream.exponential(1.0 / per_s);
        while time_s < duration_s && !inputs.is_empty() {
            let received = after(start, time_s);
            let flow = flow(inputs[stream.below(inputs.len())]);
            arrived.extend(make(stream, received).map(|payload| SimulatedDatagram {
                received,
                flow,
                payload,
            }));
            time_s += stream.exponential(1.0 / per_s);
        }
    };
    foreign(network.foreign_source_per_s, foreign_source);
    foreign(network.foreign_category_per_s, foreign_category);
    // Stable sort: datagrams that arrive at the same time stay in the order in which they were sent.
    arrived.sort_by_key(|datagram| datagram.received);
    arrived
}

/// Plot of an unknown radar.
fn foreign_source(stream: &mut RandomStream, time: Time) -> Option<Vec<u8>> {
    let range_m = stream.within(Span::new(200.0, 4000.0));
    let azimuth_deg = stream.within(Span::new(0.0, 359.0));
    let time_of_day = TimeOfDay::from_count(time_of_day_count(time));
    let record =
        cat048::Record::builder(FOREIGN_SOURCE, time_of_day, TargetReport::new(DetectionType::Primary))
            .polar_position(PolarPosition::new(range_m, azimuth_deg))
            .track_number(TrackNumber::new(1 + stream.below(9) as u16))
            .build()
            .ok()?;
    let mut payload = Vec::new();
    encode_block(&[record], &mut payload).ok()?;
    Some(payload)
}

/// Block of an unknown category.
fn foreign_category(stream: &mut RandomStream, _: Time) -> Option<Vec<u8>> {
    let category = FOREIGN_CATEGORIES[stream.below(FOREIGN_CATEGORIES.len())];
    let octets = 5 + stream.below(60);
    let mut payload = vec![category, 0, (octets + 3) as u8];
    payload.extend(stream.octets(octets));
    Some(payload)
}

/// Flow from a sensor on this machine to one of the service's inputs.
fn flow(input: &Input) -> UdpFlow {
    let (from, to) = match input.address {
        Address::Multicast { group, interface } => (interface, group),
        Address::Unicast(address) => (Ipv4Addr::LOCALHOST, address),
    };
    UdpFlow { from, to, port: input.port, ttl: 1 }
}
