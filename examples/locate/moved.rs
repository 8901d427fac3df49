//! How soon a radar that is moved or turned in flight is noticed.

use std::error::Error;

use asterix::cat048::{self, PolarPosition};
use asterix::{blocks, encode_block};
use fusion::time::Time;
use input::capture::{Reception, ReceptionKind};
use lab::simulate::simulate;
use service::live::{Driver, DriverEvent};
use site::areas::Masks;
use site::config::Profile;

/// Change of the radar after half of the flight.
#[derive(Clone, Copy)]
pub struct Fate {
    /// Metres, in a direction that depends on the seed.
    pub moved_m: f64,
    /// Degrees.
    pub turned_deg: f64,
}

/// Minutes of drones with a transponder, seen by the radar or not, until the position was contradicted or a step was found; before the fate: a false contradiction.
pub struct Noticed {
    pub false_alert: bool,
    pub after: Option<f64>,
    /// Squared normalised error of the displacement at the end, per component, and its error in metres.
    pub error: Option<(f64, f64)>,
    pub minutes: f64,
}

pub fn notice(seed: u64, minutes: f64, fate: Fate) -> Result<(String, Noticed), Box<dyn Error>> {
    let (mut scenario, _) = super::scenario(seed, 2.0 * minutes)?;
    scenario.radars[0].bias_azimuth_deg = super::uniform(seed, 3) - 0.5;
    let simulation = simulate(&scenario, seed, None)?;
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    let start = simulation.datagrams[0].received;
    let half = start + jiff::SignedDuration::from_secs_f64(scenario.duration_s / 2.0);
    let direction = std::f64::consts::TAU * super::uniform(seed, 4);
    let moved_m = [fate.moved_m * direction.sin(), fate.moved_m * direction.cos()];
    let mut driver = Driver::new(&config, Masks::default(), start, 1);
    let mut noticed = Noticed { false_alert: false, after: None, error: None, minutes: 0.0 };
    let (mut before, mut since) = (0.0, 0.0);
    for datagram in &simulation.datagrams {
        let is_moved = datagram.received >= half;
        let payload = if is_moved {
            seen_from(&datagram.payload, moved_m, fate.turned_deg)?
        } else {
            datagram.payload.clone()
        };
        let mut count = |driver: &mut Driver| {
            while let Some(event) = driver.poll() {
                let DriverEvent::Slot(slot) = event else { continue };
                let tracks = slot.picture.tracks.iter();
                let count = tracks.filter(|track| track.point.source.transponder().is_some()).count();
                *(if slot.picture.time >= half { &mut since } else { &mut before }) +=
                    count as f64 * 0.25 / 60.0;
            }
        };
        driver.tick(datagram.received);
        count(&mut driver);
        driver.receive(&Reception {
            received: Some(datagram.received),
            input: 0,
            from: None,
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload,
        });
        count(&mut driver);
        let engine = driver.pipeline().engine();
        let Some((_, registered)) = engine.registered().next() else { continue };
        let is_step = |since: Time| registered.step.is_some_and(|step| step.time >= since);
        let is_contradicted = registered.place().is_some_and(|place| place.contradicts);
        if !is_moved {
            noticed.false_alert |= is_contradicted;
        } else if noticed.after.is_none() && (is_contradicted || is_step(half)) {
            noticed.after = Some(since);
        }
    }
    let engine = driver.pipeline().engine();
    if let Some(place) = engine.registered().next().and_then(|(_, registered)| registered.place()) {
        let off = nalgebra::Vector2::new(place.east_m - moved_m[0], place.north_m - moved_m[1]);
        if let Some(weights) = place.covariance_m2.try_inverse() {
            noticed.error = Some((off.dot(&(weights * off)) / 2.0, off.norm()));
        }
    }
    noticed.minutes = before + since;
    Ok((scenario.name.clone(), noticed))
}

/// The plots of a datagram as the radar sees them from another place, and turned.
fn seen_from(
    payload: &[u8],
    [east_m, north_m]: [f64; 2],
    turned_deg: f64,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut seen = Vec::new();
    for block in blocks(payload) {
        let block = block?;
        if block.category != 48 {
            seen.extend_from_slice(block.octets);
            continue;
        }
        let mut records: Vec<cat048::Record> =
            block.records().flatten().map(|located| located.record).collect();
        for record in &mut records {
            let Some(polar) = record.polar_position else { continue };
            let (range_m, azimuth) = (polar.range_m(), polar.azimuth_deg().to_radians());
            let (east, north) = (range_m * azimuth.sin() - east_m, range_m * azimuth.cos() - north_m);
            record.polar_position =
                PolarPosition::new(east.hypot(north), east.atan2(north).to_degrees() + turned_deg);
            record.cartesian_position = None;
        }
        encode_block(&records, &mut seen)?;
    }
    Ok(seen)
}
