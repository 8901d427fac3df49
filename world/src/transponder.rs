//! A drone's transponder: its reports, with errors in position and time.

use nalgebra::Vector3;

use crate::attack::Lie;
use crate::motion::Path;
use crate::scenario::{Span, Transponder};
use crate::streams::{GaussMarkov, Stream};

/// One report, errors included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransponderReport {
    /// The drone.
    pub drone: usize,
    /// The drone whose identity is sent: its own, unless transponders are swapped.
    pub identity: usize,
    /// Whether the drone sent it where it was: false of what an attacker sends in its name.
    pub is_own: bool,
    /// When its position was measured, s since take-off.
    pub measured_s: f64,
    /// Its time stamp, s since take-off.
    pub stamped_s: f64,
    /// Arrival at the receiver, s since take-off.
    pub arrives_s: f64,
    /// Reported east, north and height above ground, metres.
    pub position: Vector3<f64>,
    /// Velocity, m/s.
    pub velocity: Vector3<f64>,
    /// Stated accuracy (I129/110), metres.
    pub accuracy_m: Option<f64>,
}

/// What happens to a transponder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Nothing.
    Honest,
    /// Its reports are false from some moment on.
    Spoofed,
    /// It is not received for a while.
    Jammed,
}

/// What one transponder sends.
#[derive(Clone, Debug)]
pub struct Transmissions {
    /// In order of measurement.
    pub reports: Vec<TransponderReport>,
    /// How it lies, where it is spoofed.
    pub lie: Option<Lie>,
    /// When it is silent, where it is jammed, s since take-off.
    pub jammed_s: Option<Span>,
}

/// All reports of drone number `drone` within `duration_s` seconds.
pub fn reports(
    model: &Transponder,
    drone: usize,
    path: &Path,
    role: Role,
    duration_s: f64,
    mut stream: Stream,
) -> Transmissions {
    let stream = &mut stream;
    let period_s = stream.within(model.period_s);
    let late_s = stream.within(model.stamped_late_s);
    let first_s = stream.within(model.starts_after_s);
    let last_s = duration_s - stream.within(model.ends_before_s);
    let accuracy_m = stream.chance(model.accuracy_share).then(|| stated_accuracy_m(model));
    let gaps = episodes(model.gap_every_s, model.gap_s, duration_s, stream);
    let jumps = episodes(model.jump_every_s, model.jump_s, duration_s, stream);
    let jump_offsets: Vec<Vector3<f64>> =
        jumps.iter().map(|_| horizontal(stream.heading(), stream.within(model.jump_m))).collect();
    // Drawn in this order since the first version: a seed stays the same flight.
    let attack_s = match role {
        Role::Honest => None,
        Role::Spoofed => {
            let from_s = stream.within(model.spoof_after_s);
            let until_s = if model.spoof_lasts_s > 0.0 { from_s + model.spoof_lasts_s } else { duration_s };
            Some(Span::new(from_s, until_s))
        }
        Role::Jammed => {
            let from_s = stream.within(model.jam_after_s);
            Some(Span::new(from_s, from_s + stream.within(model.jam_s)))
        }
    };
    let away = horizontal(stream.heading(), 1.0);
    let jammed_s = attack_s.filter(|_| role == Role::Jammed);
    let mut bias = [model.gnss_horizontal_m, model.gnss_horizontal_m, model.gnss_vertical_m]
        .map(|sigma_m| GaussMarkov::new(sigma_m, model.gnss_time_s, 0.0, stream));

    let mut reports = Vec::new();
    let mut time_s = first_s;
    while time_s < last_s {
        let state = path.at(time_s);
        let error = Vector3::from(bias.each_mut().map(|axis| axis.at(time_s, stream)))
            + Vector3::from_fn(|_, _| stream.normal(model.gnss_white_m));
        let jump = jumps.iter().position(|jump| within(*jump, time_s)).map(|jump| jump_offsets[jump]);
        let silent = gaps.iter().any(|gap| within(*gap, time_s))
            || jammed_s.is_some_and(|jammed_s| within(jammed_s, time_s))
            || stream.chance(model.dropped);
        let stamped_s = time_s + late_s;
        let held_s = if stream.chance(model.held_up) { stream.within(model.held_up_s) } else { 0.0 };
        let arrives_s = stamped_s + stream.within(model.latency_s) + held_s;
        if !silent {
            reports.push(TransponderReport {
                drone,
                identity: drone,
                is_own: true,
                measured_s: time_s,
                stamped_s,
                arrives_s,
                position: state.position + error + jump.unwrap_or_default(),
                velocity: state.velocity,
                accuracy_m,
            });
        }
        time_s += period_s * (1.0 + model.jitter * stream.within(Span::new(-1.0, 1.0)));
    }
    let lie = attack_s.filter(|_| role == Role::Spoofed).map(|span| Lie {
        attack: model.attack,
        span,
        away,
        period_s,
    });
    let reports = match &lie {
        Some(lie) => lie.apply(model, reports),
        None => reports,
    };
    Transmissions { reports, lie, jammed_s }
}

/// The radius that holds half of the positions: 1.18 standard deviations (Rayleigh's median), in whole metres.
fn stated_accuracy_m(model: &Transponder) -> f64 {
    (1.18 * model.gnss_horizontal_m.hypot(model.gnss_white_m)).ceil()
}

fn horizontal(heading: f64, distance_m: f64) -> Vector3<f64> {
    Vector3::new(heading.sin(), heading.cos(), 0.0) * distance_m
}

fn within(span: Span, time_s: f64) -> bool {
    (span.low..span.high).contains(&time_s)
}

/// Episodes, each beginning `every_s` seconds after the end of the one before, on average.
pub fn episodes(every_s: f64, lasting_s: Span, duration_s: f64, stream: &mut Stream) -> Vec<Span> {
    let mut episodes = Vec::new();
    if every_s <= 0.0 {
        return episodes;
    }
    let mut time_s = stream.exponential(every_s);
    while time_s < duration_s {
        let end_s = time_s + stream.within(lasting_s);
        episodes.push(Span::new(time_s, end_s));
        time_s = end_s + stream.exponential(every_s);
    }
    episodes
}
