//! Two drones side by side, each with a transponder and a radar track: the flight of the tests of this module.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::frames::Enu;
use crate::report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex};
use crate::settings::{
    OperationalRules, Profile, Radar, RadarErrors, Receiver, ReferenceRules, RegistrationMode, Sensor,
    Settings,
};
use crate::time::{SECOND, Time};

pub(in crate::operational) const START: i64 = 1_700_000_000;
/// Distance of the two, metres.
pub(in crate::operational) const APART_M: f64 = 150.0;
/// Radar tracks of the first and of the second drone.
pub(in crate::operational) const TRACKS: [u16; 2] = [7, 8];

pub(in crate::operational) fn settings(is_operational: bool) -> Settings {
    let radar = Radar {
        errors: radar_errors(),
        registration: RegistrationMode::Off,
        period_s: 0.5,
        ..Radar::default()
    };
    let receiver = Receiver { delay_s: Some(0.0), period_s: 3.0, ..Receiver::default() };
    let profile = match is_operational {
        true => Profile::Operational(OperationalRules::default()),
        false => Profile::Reference(ReferenceRules::default()),
    };
    let sensors = vec![Sensor::Radar(radar), Sensor::Receiver(receiver)];
    Settings { sensors, profile, ..Settings::default() }
}

pub(in crate::operational) fn identity(which: usize) -> Identity {
    let serial = [*b"FIRST       ", *b"SECOND      "][which];
    Identity::new(&serial, None).unwrap()
}

pub(in crate::operational) fn radar(number: u16) -> RadarTrackKey {
    RadarTrackKey { sensor: SensorIndex(0), number }
}

/// Positions of the drones.
pub(in crate::operational) fn place(which: usize, time: Time) -> Enu {
    let seconds = time.seconds_since(Time::from_nanos(START * SECOND));
    Enu::new(12.0 * seconds - 300.0, 1500.0 + (APART_M + seconds) * which as f64, 100.0)
}

/// Reports of a flight, with their times of reception.
pub(in crate::operational) fn reports(seconds: i64) -> Vec<(Time, Report)> {
    let mut reports = Vec::new();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut normal = || (0..12).map(|_| random.random_range(0.0..1.0_f64)).sum::<f64>() - 6.0;
    let errors = radar_errors();
    let kept = (-0.5 / errors.correlation_s).exp();
    let across_m = 1500.0 * errors.bias_azimuth;
    let mut slow = [[0.0; 3]; 2];
    for half in 0..2 * seconds {
        let time = Time::from_nanos(START * SECOND + half * SECOND / 2);
        let received = Time::from_nanos(time.nanos() + SECOND / 5);
        for (which, number) in TRACKS.into_iter().enumerate() {
            let at = |error: [f64; 3]| Enu::from(place(which, time).0 + Vector3::from(error));
            for (error, size) in
                slow[which].iter_mut().zip([across_m, errors.bias_range_m, errors.bias_height_m])
            {
                *error = *error * kept + normal() * size * (1.0 - kept * kept).sqrt();
            }
            let plot = Plot {
                track: radar(number),
                time,
                position: at(slow[which].map(|error| error + normal())),
                height_measured: true,
                slant_range_m: 1500.0,
                uav_probability: Some(0.95),
                velocity: None,
            };
            reports.push((received, Report::Plot(plot)));
            if half % 2 == 0 {
                let place = at([0, 1, 2].map(|_| 0.3 * normal()));
                let fix = Fix::new(SensorIndex(1), identity(which), time, place);
                reports.push((received, Report::Fix(fix)));
            }
        }
    }
    reports
}

fn radar_errors() -> RadarErrors {
    RadarErrors::of_data_sheet(5.0, 0.5, 8.0)
}
