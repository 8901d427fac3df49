//! Two drones side by side, each with a transponder and a radar track: what the tests of this room fly.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::filter::{Dynamics, Models, RadarErrors};
use crate::frames::Enu;
use crate::operational::settings::{Mode, Radar, Settings, Transponder};
use crate::report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, UasItems};
use crate::time::{SECOND, Time};
use crate::{Gate, SlotGrid};

pub(in crate::operational) const START: i64 = 1_700_000_000;
/// The two are so far apart, metres.
pub(in crate::operational) const APART_M: f64 = 150.0;
/// Radar tracks of the first and of the second.
pub(in crate::operational) const TRACKS: [u16; 2] = [7, 8];

/// A radar and a transponder receiver.
pub(in crate::operational) fn profile() -> Settings {
    let errors = radar_errors();
    let radar = Radar {
        position: Enu::new(0.0, 0.0, 0.0),
        track_errors: errors,
        errors,
        registration: Mode::Off,
        period_s: 0.5,
    };
    let receiver = Transponder {
        horizontal_m: 3.0,
        vertical_m: 5.0,
        delay_s: Some(0.0),
        delay_sigma_s: 0.0,
        period_s: 3.0,
        max_new_per_s: 50,
    };
    Settings {
        radars: vec![Some(radar), None],
        transponders: vec![None, Some(receiver)],
        max_gap_ns: 8 * SECOND,
        motion: Dynamics::Imm(Models::default()),
    }
}

pub(in crate::operational) fn settings(is_operational: bool) -> crate::Settings {
    crate::Settings {
        grid: SlotGrid::new(SECOND / 4),
        latency_slots: 25,
        window_slots: 100,
        max_future_ns: SECOND,
        max_gap_ns: 25 * SECOND,
        gate: Gate::new(vec![(0.0, 60.0)]).unwrap(),
        ratio_min_ppm: 900_000,
        min_samples: 4,
        weight_radar: 1.0,
        weight_transponder: 10.0,
        radar_only_min_s: 8.0,
        suppress_slots: 16,
        period_s: vec![0.5, 0.0],
        transponder_numbers: BTreeMap::new(),
        operational: is_operational.then(profile),
    }
}

pub(in crate::operational) fn identity(which: usize) -> Identity {
    let serial = [*b"FIRST       ", *b"SECOND      "][which];
    Identity::new(&serial, None).unwrap()
}

pub(in crate::operational) fn radar(number: u16) -> RadarTrackKey {
    RadarTrackKey { sensor: SensorIndex(0), number }
}

/// Where they are.
pub(in crate::operational) fn place(which: usize, time: Time) -> Enu {
    let seconds = time.seconds_since(Time::from_nanos(START * SECOND));
    Enu::new(12.0 * seconds - 300.0, 1500.0 + (APART_M + seconds) * which as f64, 100.0)
}

/// What comes in a flight, with the second at which it is received.
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
            let at = |error: [f64; 3]| Enu(place(which, time).0 + Vector3::from(error));
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
                let items = UasItems {
                    manufacturer: None,
                    model: None,
                    serial_number: *b"            ",
                    registration_country: None,
                };
                let fix = Fix {
                    sensor: SensorIndex(1),
                    identity: identity(which),
                    items,
                    time,
                    position: at([0, 1, 2].map(|_| 0.3 * normal())),
                    accuracy_m: None,
                    velocity: None,
                    climb_m_s: None,
                };
                reports.push((received, Report::Fix(fix)));
            }
        }
    }
    reports
}

fn radar_errors() -> RadarErrors {
    RadarErrors::of_data_sheet(5.0, 0.5, 8.0)
}
