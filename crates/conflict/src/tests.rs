//! Straight flights of two aircraft, and of many.

mod chance;
mod histories;
mod interval;
mod levels;
mod normal;
mod searched;

use nalgebra::Matrix4;

use super::*;
use fusion::frames::Enu;
use fusion::time::SECOND;

fn at(seconds: i64) -> Time {
    Time::from_nanos(seconds * SECOND)
}

/// Standard deviation of each axis: 3 m and 0.5 m/s over ground, 4 m and 0.3 m/s in height.
fn aircraft(number: u32, [east, north, up]: [f64; 3], velocity: [f64; 3]) -> ConflictAircraft {
    ConflictAircraft {
        key: (number, Time::default()),
        position: Enu::new(east, north, up),
        velocity: velocity.into(),
        covariance: Matrix4::from_diagonal(&[9.0, 9.0, 0.25, 0.25].into()),
        vertical: Some([16.0, 0.0, 0.09]),
        kind: TrafficKind::Drone,
        disputed: Vec::new(),
        has_transponder: true,
        is_shown: true,
    }
}

fn drones() -> Volume {
    Volume {
        name: "drone".to_owned(),
        horizontal_m: 50.0,
        vertical_m: 15.0,
        tau_s: 0.0,
        between: [AcceptedKinds::Only(TrafficKind::Drone); 2],
    }
}

/// A cylinder for any two aircraft.
fn cylinder(horizontal_m: f64, vertical_m: f64) -> Volume {
    Volume { horizontal_m, vertical_m, between: [AcceptedKinds::Any; 2], ..drones() }
}

fn rules(volumes: Vec<Volume>) -> ConflictRules {
    ConflictRules {
        volumes,
        ahead: Extrapolation { straight_s: 30.0, steady: SteadyFlightRatios::MEASURED, ..ahead(60.0, 1.0) },
        advisory: LevelThreshold { probability: 0.1, time_s: 60.0 },
        warning: LevelThreshold { probability: 0.2, time_s: 20.0 },
    }
}

/// Motion with the stated covariances of turning aircraft.
fn ahead(horizon_s: f64, acceleration: f64) -> Extrapolation {
    let steady = SteadyFlightRatios { place: 1.0, velocity: 1.0, height: 1.0, climb: 1.0 };
    Extrapolation { horizon_s, acceleration, straight_s: 1e-9, steady }
}
