//! The fused picture of three aircraft: one with plots and a transponder, one with only a transponder, and one with
//! only plots. The last slot is printed as a table, and one point as JSON.
//!
//!     cargo run -p utm-fusion-engine --example picture

use jiff::SignedDuration;
use utm_fusion_engine::settings::{Radar, Receiver};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, Settings, Source, Time,
};

/// Position of an aircraft this many seconds after the start, in metres east, north and up of the site.
type FlightPlan = fn(f64) -> Enu;

const BOTH: FlightPlan = |seconds| Enu::new(10.0 * seconds, 1000.0, 80.0);
const HEARD: FlightPlan = |seconds| Enu::new(-800.0, 1200.0 - 8.0 * seconds, 60.0);
const SEEN: FlightPlan = |seconds| Enu::new(600.0 - 12.0 * seconds, -900.0, 100.0);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let picture = fly(45)?.pop().ok_or("no slot was due")?;
    println!("{}", picture.time);
    for point in &picture.points {
        let [east, north, up] = point.position.0.into();
        let kind = match &point.source {
            Source::Fused(..) => "fused",
            Source::Radar(_) => "radar",
            Source::Transponder(_) => "transponder",
            Source::Cameras => "cameras",
        };
        print!("{:>8} {kind:<11} {east:8.1} {north:8.1} {up:6.1} m", point.number);
        match point.estimate {
            Some(estimate) => {
                let [east, north, _] = estimate.velocity.into();
                println!(" {east:6.1} {north:6.1} m/s, within {:.1} m", estimate.sigma_m());
            }
            None => println!(),
        }
    }
    if let Some(point) = picture.points.first() {
        println!("{}", serde_json::to_string(point)?);
    }
    Ok(())
}

/// All emissions of a flight of this duration, in seconds.
fn fly(seconds: i32) -> Result<Vec<Emission>, Box<dyn std::error::Error>> {
    let mut settings = Settings::default();
    let radar = settings.add_radar(Radar::default());
    let receiver = settings.add_receiver(Receiver::default());
    let mut engine = Engine::new(settings)?;
    let names = [b"DRONE-1", b"DRONE-2"].map(|name| Identity::new(name, None));
    let [Some(both), Some(heard)] = names else { return Err("a blank serial number".into()) };

    let start: Time = Time::from_nanos(1_800_000_000_000_000_000);
    let mut emissions = Vec::new();
    for tick in 0..4 * seconds {
        let (since, time) = (f64::from(tick) / 4.0, start + SignedDuration::from_millis(250) * tick);
        emissions.extend(engine.advance(time));
        // The radar rotates once a second; transponders report twice a second.
        if tick % 4 == 0 {
            engine.handle(plot(radar, 7, time, BOTH(since)))?;
            engine.handle(plot(radar, 8, time, SEEN(since)))?;
        }
        if tick % 2 == 0 {
            engine.handle(Report::Fix(Fix::new(receiver, both, time, BOTH(since))))?;
            engine.handle(Report::Fix(Fix::new(receiver, heard, time, HEARD(since))))?;
        }
    }
    Ok(emissions)
}

/// A plot that the radar classifies as a drone.
fn plot(sensor: SensorIndex, number: u16, time: Time, place: Enu) -> Report {
    let plot = Plot::new(RadarTrackKey { sensor, number }, time, place, place.0.norm());
    Report::Plot(Plot { uav_probability: Some(0.9), ..plot })
}

#[test]
fn it_runs_and_there_is_one_point_an_aircraft() {
    main().expect("nothing is wrong");
    let picture = fly(45).expect("nothing is wrong").pop().expect("slots were due");
    let seconds = (picture.time - Time::from_nanos(1_800_000_000_000_000_000)).as_secs_f64();
    assert_eq!(picture.points.len(), 3);
    for point in &picture.points {
        let flight = match &point.source {
            Source::Fused(..) => BOTH,
            Source::Transponder(_) => HEARD,
            Source::Radar(_) => SEEN,
            Source::Cameras => unreachable!("there is no camera"),
        };
        assert!((point.position.0 - flight(seconds).0).norm() < 1.0, "{point:?} at {seconds} s");
    }
}
