//! What the engine is told once, from the configuration.

use crate::config::{Config, Motion, Profile, Registration, Sensor, SensorKind};
use crate::normalise::Normaliser;
use fusion::Geodetic;
use fusion::filter::{Dynamics, Models, RadarErrors, Singer};
use fusion::operational::{self, Mode, Radar, Transponder};
use fusion::{Gate, Settings, SlotGrid};

/// Accuracy of a radar that is configured without one: metres, degrees, metres.
const RADAR_ACCURACY: (f64, f64, f64) = (5.0, 1.0, 10.0);
/// Accuracy of a transponder that is configured without one, metres over ground and in height.
const TRANSPONDER_ACCURACY: (f64, f64) = (3.0, 5.0);

/// The engine's settings from the configuration.
pub(super) fn settings(config: &Config, normaliser: &Normaliser) -> Settings {
    let fusion = &config.fusion;
    let grid = SlotGrid::new(fusion.slot.as_nanos() as i64);
    let period_s = |sensor: &Sensor| match sensor.kind {
        SensorKind::Radar(_) => sensor.period_s.unwrap_or(0.0).max(grid.slot_s()),
        SensorKind::Transponder(_) => 0.0,
    };
    Settings {
        grid,
        latency_slots: fusion.latency_slots.into(),
        window_slots: fusion.window_slots.into(),
        max_future_ns: fusion.max_future.as_nanos() as i64,
        max_gap_ns: fusion.max_gap.as_nanos() as i64,
        gate: Gate::new(fusion.threshold_m.clone())
            .expect("a configured threshold table has rows that increase"),
        ratio_min_ppm: (fusion.ratio_min * 1e6).round() as u64,
        min_samples: fusion.min_samples,
        weight_radar: fusion.weight_radar,
        weight_transponder: fusion.weight_transponder,
        radar_only_min_s: fusion.radar_only_min_s,
        suppress_slots: fusion.suppress_slots.into(),
        period_s: config.sensors.iter().map(period_s).collect(),
        transponder_numbers: fusion
            .transponder_numbers
            .iter()
            .map(|(serial, &number)| (serial.as_bytes().to_vec(), number))
            .collect(),
        operational: (fusion.profile == Profile::Operational).then(|| operational(config, normaliser)),
    }
}

/// What the sensors' data sheets say.
fn operational(config: &Config, normaliser: &Normaliser) -> operational::Settings {
    let radar = |sensor: &Sensor| {
        let SensorKind::Radar(radar) = &sensor.kind else { return None };
        let height_m = radar.height_amsl_m + normaliser.undulation_m();
        let place = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m);
        let (range_m, azimuth_deg, height_m) = radar.accuracy.map_or(RADAR_ACCURACY, |accuracy| {
            (accuracy.range_m, accuracy.azimuth_deg, accuracy.height_m.unwrap_or(RADAR_ACCURACY.2))
        });
        let errors = RadarErrors::of_data_sheet(range_m, azimuth_deg, height_m);
        Some(Radar {
            position: normaliser.frame().from_geodetic(place),
            track_errors: errors,
            errors,
            registration: match radar.registration {
                Registration::Off => Mode::Off,
                Registration::Propose => Mode::Propose,
                Registration::Apply => Mode::Apply,
            },
            period_s: sensor.period_s.unwrap_or(config.fusion.slot.as_secs_f64()),
        })
    };
    let transponder = |sensor: &Sensor| {
        let SensorKind::Transponder(transponder) = &sensor.kind else { return None };
        let (horizontal_m, vertical_m) = transponder
            .accuracy
            .map_or(TRANSPONDER_ACCURACY, |accuracy| (accuracy.horizontal_m, accuracy.vertical_m));
        Some(Transponder {
            horizontal_m,
            vertical_m,
            delay_s: transponder.delay_s,
            delay_sigma_s: 0.0,
            period_s: sensor.period_s.unwrap_or(0.0),
            max_new_per_s: transponder.max_new_per_s,
        })
    };
    operational::Settings {
        radars: config.sensors.iter().map(radar).collect(),
        transponders: config.sensors.iter().map(transponder).collect(),
        max_gap_ns: 8_000_000_000,
        motion: match config.fusion.motion {
            Motion::Imm => Dynamics::Imm(Models::default()),
            Motion::Singer => Dynamics::Singer(Singer::default()),
        },
    }
}
