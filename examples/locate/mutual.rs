//! How well two radars align each other by aircraft without transponders.

use std::error::Error;

use fusion::operational::Registered;
use fusion::registration::BiasValue;
use input::capture::{Reception, ReceptionKind};
use lab::simulate::{random, simulate};
use service::live::Driver;
use site::areas::Masks;
use site::config::Profile;

/// Result of one site.
pub struct Aligned {
    /// Absolute errors of both bearings, degrees.
    pub bearings_deg: [f64; 2],
    /// Absolute error of the difference of both bearings, degrees.
    pub mutual_deg: f64,
    /// Squared normalised errors: bearings, ranges.
    pub squares: [[f64; 2]; 2],
    /// Minutes of aircraft that both radars saw.
    pub minutes: f64,
}

/// Lets two radars of a random world see its drones, which have no transponders, for these minutes of one aircraft.
pub fn align(seed: u64, minutes: f64) -> Result<Option<Aligned>, Box<dyn Error>> {
    let mut scenario = random::random_world(seed);
    scenario.drones.equipped = 0;
    scenario.radars.truncate(1);
    let mut second = scenario.radars[0].clone();
    (second.id, second.sic) = ("second".to_owned(), second.sic + 1);
    scenario.radars.push(second);
    let first_direction = std::f64::consts::TAU * super::uniform(seed, 2);
    // The radars stand 60 to 120 degrees apart, seen from the centre of the airspace.
    let apart = (60.0 + 60.0 * super::uniform(seed, 5)).to_radians();
    for (index, radar) in scenario.radars.iter_mut().enumerate() {
        let number = index as u64;
        let direction = first_direction + apart * index as f64;
        let distance_m = 1000.0 + 1500.0 * super::uniform(seed, 6 + number);
        radar.east_m = scenario.airspace.east_m + distance_m * direction.sin();
        radar.north_m = scenario.airspace.north_m + distance_m * direction.cos();
        radar.bias_azimuth_deg = 4.0 * super::uniform(seed, 10 + number) - 2.0;
        radar.bias_range_m = 10.0 * super::uniform(seed, 20 + number) - 5.0;
    }
    scenario.duration_s = 1200.0;
    let truth = [0, 1].map(|index: usize| {
        let radar = &scenario.radars[index];
        [radar.bias_azimuth_deg.to_radians(), radar.bias_range_m]
    });
    let simulation = simulate(&scenario, seed, None)?;
    let mut config = simulation.config.clone();
    config.fusion.profile = Profile::Operational;
    let mut driver = Driver::new(&config, Masks::default(), simulation.datagrams[0].received, 1);
    for datagram in &simulation.datagrams {
        driver.tick(datagram.received);
        driver.receive(&Reception {
            received: Some(datagram.received),
            input: 0,
            from: None,
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: datagram.payload.clone(),
        });
        if driver.pipeline().engine().registered().any(|(_, radar)| minutes_of(radar) >= minutes) {
            break;
        }
    }
    let engine = driver.pipeline().engine();
    let radars: Vec<&Registered> = engine.registered().map(|(_, registered)| registered).collect();
    let shared = radars.iter().map(|radar| minutes_of(radar)).fold(0.0, f64::max);
    if shared == 0.0 {
        return Ok(None);
    }
    let error = |value: &BiasValue, truth: f64| (value.value - truth, value.deviation);
    let of = [0, 1].map(|radar: usize| {
        let estimate = &radars[radar].estimate;
        [error(&estimate.bearing, truth[radar][0]), error(&estimate.range_m, truth[radar][1])]
    });
    let degrees = |radar: usize| of[radar][0].0.to_degrees();
    Ok(Some(Aligned {
        bearings_deg: [degrees(0).abs(), degrees(1).abs()],
        mutual_deg: (degrees(0) - degrees(1)).abs(),
        squares: of.map(|values| values.map(|(error, deviation)| (error / deviation).powi(2))),
        minutes: shared,
    }))
}

fn minutes_of(radar: &Registered) -> f64 {
    radar.by_radars().map_or(0.0, |learnt| learnt.minutes)
}
