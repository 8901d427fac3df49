//! The scenario: the own ship flies straight towards two intruders, which fly straight and then turn left.
//!
//! East, north, up, metres. The own ship begins at the origin, at its altitude, and flies north.

use fusion::Enu;
use nalgebra::Vector3;
use tracker::Observer;

const OWN_SPEED: f64 = 60.0;
const OWN_ALTITUDE_M: f64 = 3000.0;
const ALTITUDE_M: f64 = 3100.0;
/// Lateral distance at which the intruders would pass, metres.
const ABEAM_M: f64 = 1000.0;

/// An intruder.
#[derive(Clone, Copy, Debug)]
pub struct Intruder {
    pub name: &'static str,
    pub speed: f64,
    /// Initial distance ahead, metres.
    ahead_m: f64,
    /// Rate of its turn to the left, radians per second.
    pub turn: f64,
    /// Process noise that the tracker assumes for it, m²/s³.
    pub noise: f64,
}

/// A slowly manoeuvring unmanned aircraft, and a combat aircraft.
pub const INTRUDERS: [Intruder; 2] = [
    Intruder { name: "intruder 1", speed: 60.0, ahead_m: 8000.0, turn: 3.0_f64.to_radians(), noise: 1.0 },
    Intruder { name: "intruder 2", speed: 260.0, ahead_m: 16_000.0, turn: 7.0_f64.to_radians(), noise: 9.0 },
];

impl Intruder {
    /// Time at which it would pass the own ship in straight flight: the end, seconds.
    pub fn end_s(&self) -> f64 {
        self.ahead_m / (self.speed + OWN_SPEED)
    }

    /// Time at which it begins to turn: half way.
    pub fn turn_s(&self) -> f64 {
        self.end_s() / 2.0
    }

    /// Position and velocity.
    pub fn at(&self, at: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (straight, turned) = (at.min(self.turn_s()), (at - self.turn_s()).max(0.0) * self.turn);
        let radius = self.speed / self.turn;
        // It flies south, so east is to its left.
        let (sin, cos) = turned.sin_cos();
        let position = Vector3::new(
            ABEAM_M + radius * (1.0 - cos),
            self.ahead_m - self.speed * straight - radius * sin,
            ALTITUDE_M,
        );
        (position, Vector3::new(sin, -cos, 0.0) * self.speed)
    }
}

/// The own ship.
pub fn observer(at: f64) -> Observer {
    Observer {
        position: Enu::new(0.0, OWN_SPEED * at, OWN_ALTITUDE_M),
        velocity: Vector3::new(0.0, OWN_SPEED, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_intruder_turns_left_at_its_rate() {
        for intruder in INTRUDERS {
            for at in [1.0, intruder.turn_s() + 3.0] {
                let ((before, _), (after, _)) = (intruder.at(at - 0.01), intruder.at(at + 0.01));
                let (_, velocity) = intruder.at(at);
                assert!(((after - before) / 0.02 - velocity).norm() < 0.01, "{}", intruder.name);
                assert!((velocity.norm() - intruder.speed).abs() < 1e-9);
            }
            let (_, straight) = intruder.at(0.0);
            let (_, turned) = intruder.at(intruder.turn_s() + 1.0);
            // Anticlockwise, seen from above.
            let angle = straight.cross(&turned).z.atan2(straight.dot(&turned));
            assert!((angle - intruder.turn).abs() < 1e-9);
        }
    }
}
