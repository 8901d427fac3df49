//! Straight flights of two aircraft, and many.

mod chance;
mod levels;
mod normal;
mod searched;

use super::*;
use crate::time::SECOND;

fn at(seconds: i64) -> Time {
    Time::from_nanos(seconds * SECOND)
}

/// Sigma of each axis: 3 m and 0.5 m/s over ground, 4 m and 0.3 m/s above it.
fn aircraft(number: u32, [east, north, up]: [f64; 3], velocity: [f64; 3]) -> Aircraft {
    Aircraft {
        key: (number, Time::default()),
        position: Enu::new(east, north, up),
        velocity: velocity.into(),
        covariance: Matrix4::from_diagonal(&[9.0, 9.0, 0.25, 0.25].into()),
        vertical: Some([16.0, 0.0, 0.09]),
        kind: Kind::Drone,
        disputed: Vec::new(),
    }
}

fn drones() -> Volume {
    Volume {
        name: "drone".to_owned(),
        horizontal_m: 50.0,
        vertical_m: 15.0,
        tau_s: 0.0,
        between: [Side::Only(Kind::Drone); 2],
    }
}

fn rules(volumes: Vec<Volume>) -> Rules {
    Rules {
        volumes,
        ahead: Ahead { straight_s: 30.0, steady: Steady::MEASURED, ..ahead(60.0, 1.0) },
        advisory: Threshold { probability: 0.1, time_s: 60.0 },
        warning: Threshold { probability: 0.2, time_s: 20.0 },
    }
}

/// As the covariances say it, which are those of aircraft that turn.
fn ahead(horizon_s: f64, acceleration: f64) -> Ahead {
    let steady = Steady { place: 1.0, velocity: 1.0, height: 1.0, climb: 1.0 };
    Ahead { horizon_s, acceleration, straight_s: 1e-9, steady }
}
