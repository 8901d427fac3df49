//! From reports to points: half a minute of one drone, detected by a radar and received by a transponder receiver.

use jiff::SignedDuration;
use utm_fusion_engine::settings::{Radar, Receiver};
use utm_fusion_engine::{Emission, Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, Settings, Time};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut settings = Settings::default();
    let track = RadarTrackKey { sensor: settings.add_radar(Radar::default()), number: 7 };
    let receiver = settings.add_receiver(Receiver::default());
    let mut engine = Engine::new(settings)?;
    let identity = Identity::new(b"DRONE-1     ", None).ok_or("a blank serial number")?;
    let start: Time = Time::from_nanos(1_800_000_000_000_000_000);

    for tick in 0..120 {
        // First the time, which returns the slots that are due. Then the reports that were received at that time.
        let time = start + SignedDuration::from_millis(250) * tick;
        engine.advance(time).for_each(print);
        let place = Enu::new(2.5 * f64::from(tick), 1000.0, 80.0);
        let plot = Plot::new(track, time, place, place.0.norm());
        engine.handle(Report::Plot(Plot { uav_probability: Some(0.9), ..plot }))?;
        engine.handle(Report::Fix(Fix::new(receiver, identity, time, place)))?;
    }
    engine.finish().for_each(print);
    Ok(())
}

fn print(emission: Emission) {
    for point in emission.points {
        let [east, north, up] = point.position.0.into();
        println!("{} track {}: {east:.1} {north:.1} {up:.1} m", emission.time, point.number);
    }
}
