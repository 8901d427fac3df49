//! The settings of the engine from the configuration.

use std::num::NonZeroUsize;
use std::thread;

use crate::normalise::{Normaliser, camera_place};
use fusion::frames::{Geodetic, RadarFrame};
use fusion::settings::{
    Action, Camera, Dynamics, IntegrityRules, Models, OperationalRules, Radar, RadarErrors, Receiver,
    ReferenceRules, RegistrationMode, Sensor, Singer, Threshold, Weights,
};
use fusion::slots::SlotGrid;
use fusion::{Profile, Settings};
use site::config::{self, Config, Motion, Registration, SensorKind};

/// Accuracy of a radar without a configured one: range (metres), azimuth (degrees), height (metres).
const RADAR_ACCURACY: (f64, f64, f64) = (5.0, 1.0, 10.0);
/// Accuracy of a transponder without a configured one: horizontal and vertical, in metres.
const TRANSPONDER_ACCURACY: (f64, f64) = (3.0, 5.0);
/// Accuracy of ADS-B: a NACp of 10 or better is usual (10 m and 15 m contain 95 %), and its times are coarse.
const ADS_B_ACCURACY: (f64, f64) = (7.0, 10.0);
/// Accuracy of Remote ID that states none.
const REMOTE_ID_ACCURACY: (f64, f64) = (10.0, 10.0);
/// Accuracy of a camera without a configured one, in degrees.
const CAMERA_ACCURACY_DEG: [f64; 2] = [0.2, 0.2];

/// The engine's settings from the configuration.
pub(super) fn settings(config: &Config, normaliser: &Normaliser) -> Settings {
    let fusion = &config.fusion;
    Settings {
        grid: SlotGrid::new(fusion.slot),
        latency_slots: fusion.latency_slots.into(),
        window_slots: fusion.window_slots.into(),
        max_future: fusion.max_future,
        sensors: config.sensors.iter().map(|sensor| self::sensor(sensor, config, normaliser)).collect(),
        transponder_numbers: fusion
            .transponder_numbers
            .iter()
            .map(|(serial, &number)| (serial.as_bytes().to_vec(), number))
            .collect(),
        profile: match fusion.profile {
            config::Profile::Reference => Profile::Reference(reference(fusion)),
            config::Profile::Operational => Profile::Operational(operational(config)),
        },
    }
}

fn reference(fusion: &config::Fusion) -> ReferenceRules {
    ReferenceRules {
        max_gap: fusion.max_gap,
        threshold: Threshold::new(fusion.threshold_m.clone())
            .expect("a configured threshold table has rows that increase"),
        min_ratio_ppm: (fusion.ratio_min * 1e6).round() as u64,
        min_samples: fusion.min_samples,
        weights: Weights { radar: fusion.weight_radar, transponder: fusion.weight_transponder },
        radar_only_min_s: fusion.radar_only_min_s,
        suppress_slots: fusion.suppress_slots.into(),
    }
}

fn operational(config: &Config) -> OperationalRules {
    let fusion = &config.fusion;
    let dynamics = match fusion.motion {
        Motion::Imm => Dynamics::Imm(Models::default()),
        Motion::Singer => Dynamics::Singer(Singer::default()),
    };
    OperationalRules {
        dynamics,
        now: fusion.now,
        threads: threads(fusion.threads),
        integrity: integrity(&config.integrity),
        ..OperationalRules::default()
    }
}

fn integrity(integrity: &config::Integrity) -> IntegrityRules {
    let config::Integrity { action, on, off, alert_limit_m, accuracy, show_twin, protect } = *integrity;
    let action = match action {
        config::Action::Off => Action::Off,
        config::Action::Flag => Action::Flag,
        config::Action::Split => Action::Split,
    };
    IntegrityRules { action, on, off, alert_limit_m, accuracy, show_twin, protect }
}

/// Number of threads for the work of a slot: as configured, or one per processor.
fn threads(configured: u32) -> NonZeroUsize {
    let all = || thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    NonZeroUsize::new(configured as usize).unwrap_or_else(all)
}

/// Properties of a sensor, as on its data sheet.
fn sensor(sensor: &config::Sensor, config: &Config, normaliser: &Normaliser) -> Sensor {
    let period_s = sensor.period_s;
    match &sensor.kind {
        SensorKind::Radar(radar) => {
            let height_m = radar.height_amsl_m + normaliser.undulation_m();
            let place = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m);
            let (range_m, azimuth_deg, height_m) = radar.accuracy.map_or(RADAR_ACCURACY, |accuracy| {
                (accuracy.range_m, accuracy.azimuth_deg, accuracy.height_m.unwrap_or(RADAR_ACCURACY.2))
            });
            Sensor::Radar(Radar {
                frame: RadarFrame::new(normaliser.frame(), place),
                errors: RadarErrors::of_data_sheet(range_m, azimuth_deg, height_m),
                learns_accuracy: radar.learn_accuracy,
                registration: match radar.registration {
                    Registration::Off => RegistrationMode::Off,
                    Registration::Propose => RegistrationMode::Propose,
                    Registration::Apply => RegistrationMode::Apply,
                },
                period_s: period_s.unwrap_or(config.fusion.slot.as_secs_f64()),
            })
        }
        SensorKind::Transponder(receiver) => self::receiver(receiver, TRANSPONDER_ACCURACY, period_s),
        SensorKind::AdsB(adsb) => receiver(&adsb.receiver, ADS_B_ACCURACY, period_s),
        SensorKind::RemoteId(of) => receiver(of, REMOTE_ID_ACCURACY, period_s),
        SensorKind::Camera(camera) => {
            let config::Camera {
                latitude_deg, longitude_deg, height_amsl_m, orientation_deg, accuracy, ..
            } = camera;
            let stated = accuracy.map(|accuracy| [accuracy.azimuth_deg, accuracy.elevation_deg]);
            let [azimuth, elevation] = stated.unwrap_or(CAMERA_ACCURACY_DEG).map(f64::to_radians);
            let position = camera_place(*latitude_deg, *longitude_deg, *height_amsl_m, normaliser);
            Sensor::Camera(Camera { position, azimuth, elevation, orientation: orientation_deg.to_radians() })
        }
    }
}

/// Properties of a receiver's reports. `usual`: their accuracy if none is configured.
fn receiver(receiver: &config::Transponder, usual: (f64, f64), period_s: Option<f64>) -> Sensor {
    let stated = receiver.accuracy.map(|accuracy| (accuracy.horizontal_m, accuracy.vertical_m));
    let (horizontal_m, vertical_m) = stated.unwrap_or(usual);
    Sensor::Receiver(Receiver {
        horizontal_m,
        vertical_m,
        delay_s: receiver.delay_s,
        period_s: period_s.unwrap_or(0.0),
        max_new_per_s: receiver.max_new_per_s,
    })
}
