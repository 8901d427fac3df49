//! A drone's transponder: its reports, with errors in position and time.

use nalgebra::Vector3;

use crate::attack::AttackInterval;
use crate::motion::FlightPath;
use crate::scenario::{Span, Transponder};
use crate::streams::{GaussMarkov, RandomStream};
pub use crate::transponder_report::TransponderReport;

/// Attack on a transponder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransponderRole {
    /// No attack.
    Honest,
    /// Reports are false from some time on.
    Spoofed,
    /// Reports are not received for a while.
    Jammed,
}

/// Output of one transponder.
#[derive(Clone, Debug)]
pub struct Transmissions {
    /// Reports, in order of measurement.
    pub reports: Vec<TransponderReport>,
    /// The attack, if the transponder is spoofed.
    pub attack: Option<AttackInterval>,
    /// Interval of silence, s since take-off, if the transponder is jammed.
    pub jammed_s: Option<Span>,
}

/// All reports of drone number `drone` within `duration_s` seconds. Faults that are off by default draw from `faults`,
/// so that they change nothing that `stream` draws.
pub fn reports(
    model: &Transponder,
    drone: usize,
    path: &FlightPath,
    role: TransponderRole,
    duration_s: f64,
    (mut stream, mut faults): (RandomStream, RandomStream),
) -> Transmissions {
    let stream = &mut stream;
    let errors = TransponderErrors::new(model, &mut faults);
    let period_s = stream.within(model.period_s);
    let late_s = stream.within(model.stamped_late_s);
    let first_s = stream.within(model.starts_after_s);
    let last_s = duration_s - stream.within(model.ends_before_s);
    let accuracy_m = stream
        .chance(model.accuracy_share)
        .then(|| errors.stated_m.unwrap_or_else(|| stated_accuracy_m(model)));
    let gaps = episodes(model.gap_every_s, model.gap_s, duration_s, stream);
    let jumps = episodes(model.jump_every_s, model.jump_s, duration_s, stream);
    let jump_offsets: Vec<Vector3<f64>> =
        jumps.iter().map(|_| horizontal(stream.heading(), stream.within(model.jump_m))).collect();
    // Keep this order of draws: a change would alter the flight of every seed.
    let attack_s = match role {
        TransponderRole::Honest => None,
        TransponderRole::Spoofed => {
            let from_s = stream.within(model.spoof_after_s);
            let until_s = if model.spoof_lasts_s > 0.0 { from_s + model.spoof_lasts_s } else { duration_s };
            Some(Span::new(from_s, until_s))
        }
        TransponderRole::Jammed => {
            let from_s = stream.within(model.jam_after_s);
            Some(Span::new(from_s, from_s + stream.within(model.jam_s)))
        }
    };
    let away = horizontal(stream.heading(), 1.0);
    let jammed_s = attack_s.filter(|_| role == TransponderRole::Jammed);
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
        let stamped_s = time_s + late_s + faults.within(model.stamp_jitter_s);
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
                position: state.position + error + jump.unwrap_or_default() + errors.height(),
                velocity: state.velocity,
                accuracy_m,
            });
        }
        time_s += period_s * (1.0 + model.jitter * stream.within(Span::new(-1.0, 1.0)));
    }
    let attack = attack_s.filter(|_| role == TransponderRole::Spoofed).map(|span| AttackInterval {
        attack: model.attack,
        span,
        away,
        period_s,
    });
    let reports = match &attack {
        Some(attack) => attack.apply(model, reports),
        None => reports,
    };
    Transmissions { reports, attack, jammed_s }
}

/// Model of a drone's second transponder.
pub fn second(model: &Transponder) -> Transponder {
    Transponder {
        period_s: model.second_period_s,
        gnss_horizontal_m: model.gnss_horizontal_m * model.second_errors,
        gnss_vertical_m: model.gnss_vertical_m * model.second_errors,
        gnss_white_m: model.gnss_white_m * model.second_errors,
        ..model.clone()
    }
}

/// Errors of a transponder that are constant over a flight.
struct TransponderErrors {
    /// Reported accuracy, metres, if it is not derived from the errors.
    stated_m: Option<f64>,
    /// Error of the heights, metres.
    height_m: f64,
}

impl TransponderErrors {
    fn new(model: &Transponder, stream: &mut RandomStream) -> Self {
        // All values are drawn whatever the model says, so that one key does not change the effect of another.
        let stated_m = stream.within(model.stated_m);
        let is_barometric = stream.chance(model.barometric_share);
        let barometric_m = stream.within(model.barometric_m);
        Self {
            stated_m: (model.stated_m.high > 0.0).then_some(stated_m),
            height_m: if is_barometric { barometric_m } else { 0.0 },
        }
    }

    fn height(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.height_m)
    }
}

/// Radius that holds half of the positions: 1.18 standard deviations (Rayleigh's median), in whole metres.
fn stated_accuracy_m(model: &Transponder) -> f64 {
    (1.18 * model.gnss_horizontal_m.hypot(model.gnss_white_m)).ceil()
}

fn horizontal(heading: f64, distance_m: f64) -> Vector3<f64> {
    Vector3::new(heading.sin(), heading.cos(), 0.0) * distance_m
}

fn within(span: Span, time_s: f64) -> bool {
    (span.low..span.high).contains(&time_s)
}

/// Random episodes; the mean time from the end of one to the beginning of the next is `every_s` seconds.
pub fn episodes(every_s: f64, lasting_s: Span, duration_s: f64, stream: &mut RandomStream) -> Vec<Span> {
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
