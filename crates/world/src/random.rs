//! Random worlds: scenarios whose parameters are drawn from stated ranges, most of them near their usual values.

use std::fmt::Write as _;

use crate::motion::{self, RATE_HZ};
use crate::scenario::{Pattern, Radar, Scenario, Span};
use crate::streams::{Entity, RandomStream, RandomStreams};

/// A parameter of a random world.
pub struct WorldParameter {
    /// Name and unit.
    pub name: &'static str,
    /// Usual values.
    pub usual: (f64, f64),
    /// Possible values.
    pub range: (f64, f64),
    /// Sets the value in a scenario.
    set: fn(&mut Scenario, f64),
}

/// Minimum and maximum number of parameters of a world with an unusual value.
pub const UNUSUAL: (usize, usize) = (3, 4);

/// Number of the stream that draws which parameters are unusual.
const CHOICE: usize = 1 << 16;

/// Distance between adjacent drones in a formation, metres.
const FORMATION_M: f64 = 15.0;
/// Minimum radius of the airspace, in seconds of a fixed wing's flight.
const RADIUS_S: f64 = 20.0;
/// Ratio of the radius that holds half of the positions (Rayleigh's median) to the standard deviation per axis.
const HALF_WITHIN: f64 = 1.18;

const fn parameter(
    name: &'static str,
    usual: (f64, f64),
    range: (f64, f64),
    set: fn(&mut Scenario, f64),
) -> WorldParameter {
    WorldParameter { name, usual, range, set }
}

/// All parameters, set in this order.
#[rustfmt::skip]
pub static PARAMETERS: [WorldParameter; 48] = [
    parameter("multirotors", (3.0, 8.0), (1.0, 14.0), |s, v| s.drones.multirotors = whole(v)),
    parameter("fixed wings", (0.0, 3.0), (0.0, 6.0), |s, v| s.drones.fixed_wings = whole(v)),
    parameter("share of drones without a transponder", (0.0, 0.3), (0.0, 0.6), |s, v| {
        let count = f64::from(s.drone_count());
        s.drones.equipped = whole((1.0 - v) * count).max(1);
    }),
    parameter("pattern: 0 free, 1 crossing, 2 formation", (0.0, 0.0), (0.0, 2.0), |s, v| {
        s.drones.pattern = [Pattern::Free, Pattern::Crossing, Pattern::Formation][whole(v).min(2) as usize];
    }),
    parameter("radius of the airspace, m", (500.0, 800.0), (400.0, 1500.0), |s, v| s.airspace.radius_m = v),
    parameter("highest waypoints, m above ground", (100.0, 140.0), (60.0, 300.0), |s, v| {
        s.airspace.height_agl_m = Span::new(30.0, v);
    }),
    parameter("multirotors: highest cruise, m/s", (12.0, 17.0), (6.0, 25.0), |s, v| {
        s.multirotor.speed_m_s = up_to(v, 0.6);
    }),
    parameter("multirotors: highest acceleration, m/s²", (3.0, 4.5), (1.0, 9.0), |s, v| {
        s.multirotor.acceleration_m_s2 = up_to(v, 0.5);
    }),
    parameter("share of waypoints at which multirotors hover", (0.3, 0.6), (0.0, 1.0), |s, v| {
        s.multirotor.hover_share = v;
    }),
    parameter("fixed wings: highest speed, m/s", (22.0, 30.0), (16.0, 65.0), |s, v| {
        s.fixed_wing.speed_m_s = up_to(v, 0.75);
    }),
    parameter("fixed wings: steepest bank, °", (30.0, 40.0), (20.0, 65.0), |s, v| s.fixed_wing.bank_deg = v),
    parameter("climb at most, m/s", (2.0, 4.0), (1.0, 8.0), |s, v| {
        (s.multirotor.climb_m_s, s.fixed_wing.climb_m_s) = (v, v);
    }),
    parameter("radar: random errors over the defaults'", (0.8, 1.2), (0.3, 2.0), |s, v| {
        on_radar(s, |radar| {
            let slow = [&mut radar.track_azimuth_deg, &mut radar.track_range_m, &mut radar.track_height_m];
            let white = [&mut radar.plot_azimuth_deg, &mut radar.plot_range_m, &mut radar.plot_height_m];
            slow.into_iter().chain(white).for_each(|error| *error = rounded(*error * v));
        });
    }),
    parameter("radar: period, s", (0.25, 0.3), (0.25, 2.0), |s, v| {
        on_radar(s, |radar| (radar.period_s, radar.drop_after_s) = (v, rounded(4.0 * v).max(2.5)));
    }),
    parameter("radar: detection", (0.9, 0.98), (0.4, 1.0), |s, v| on_radar(s, |radar| radar.detection = v)),
    parameter("radar: mean time seen, s", (15.0, 25.0), (6.0, 60.0), |s, v| on_radar(s, |radar| radar.seen_s = v)),
    parameter("radar: mean time unseen, s", (15.0, 25.0), (4.0, 45.0), |s, v| {
        on_radar(s, |radar| radar.unseen_s = v);
    }),
    parameter("radar: mean time between seductions, s", (60.0, 90.0), (20.0, 300.0), |s, v| {
        on_radar(s, |radar| radar.seduction_every_s = v);
    }),
    parameter("radar: bias in azimuth, °", (-0.5, 0.5), (-3.0, 3.0), |s, v| {
        on_radar(s, |radar| radar.bias_azimuth_deg = v);
    }),
    parameter("radar: bias in range, m", (-5.0, 5.0), (-25.0, 25.0), |s, v| {
        on_radar(s, |radar| radar.bias_range_m = v);
    }),
    parameter("radar: bias in height, m", (-3.0, 3.0), (-15.0, 15.0), |s, v| {
        on_radar(s, |radar| radar.bias_height_m = v);
    }),
    parameter("radar: clock, s", (-0.02, 0.02), (-0.4, 0.4), |s, v| on_radar(s, |radar| radar.clock_s = v)),
    parameter("radar: drift of its clock, ms/s", (-0.05, 0.05), (-1.0, 1.0), |s, v| {
        on_radar(s, |radar| radar.clock_drift_ms_s = v);
    }),
    parameter("radar: share of drones with ghosts", (0.0, 0.0), (0.0, 0.6), |s, v| {
        on_radar(s, |radar| radar.ghost_share = v);
    }),
    parameter("radar: swaps in an encounter", (0.2, 0.4), (0.0, 1.0), |s, v| on_radar(s, |radar| radar.swap_share = v)),
    parameter("transponders: longest period, s", (2.0, 4.0), (0.6, 8.0), |s, v| {
        s.transponder.period_s = up_to(v, 0.5);
    }),
    parameter("transponders: share dropped", (0.02, 0.08), (0.0, 0.4), |s, v| s.transponder.dropped = v),
    parameter("transponders: mean time between gaps, s", (70.0, 120.0), (25.0, 600.0), |s, v| {
        s.transponder.gap_every_s = v;
    }),
    parameter("transponders: longest gap, s", (15.0, 25.0), (5.0, 60.0), |s, v| {
        s.transponder.gap_s = up_to(v, 0.3);
    }),
    parameter("transponders: longest time to the stamp, s", (0.1, 0.3), (0.0, 1.0), |s, v| {
        s.transponder.stamped_late_s = Span::new(0.0, v);
    }),
    parameter("transponders: further time to the stamp, at most, by report, s", (0.0, 0.05), (0.0, 1.0), |s, v| {
        s.transponder.stamp_jitter_s = Span::new(0.0, v);
    }),
    parameter("transponders: longest time to arrival, s", (1.0, 1.8), (0.4, 3.5), |s, v| {
        s.transponder.latency_s = Span::new(0.3, v);
    }),
    parameter("GNSS: slow error over ground, m an axis", (1.2, 2.2), (0.3, 5.0), |s, v| {
        s.transponder.gnss_horizontal_m = v;
    }),
    parameter("GNSS: slow error in height, m", (1.8, 3.2), (0.5, 8.0), |s, v| s.transponder.gnss_vertical_m = v),
    parameter("GNSS: time constant of the slow errors, s", (40.0, 90.0), (10.0, 400.0), |s, v| {
        s.transponder.gnss_time_s = v;
    }),
    parameter("GNSS: white error, m an axis", (0.3, 0.7), (0.05, 2.5), |s, v| s.transponder.gnss_white_m = v),
    parameter("stated accuracy over the true one", (0.8, 1.25), (0.4, 2.5), |s, v| {
        let model = &mut s.transponder;
        let true_m = HALF_WITHIN * model.gnss_horizontal_m.hypot(model.gnss_white_m);
        model.stated_m = Span::new(rounded(0.9 * v * true_m), rounded(1.1 * v * true_m));
    }),
    parameter("share of drones that state their accuracy", (0.4, 0.7), (0.0, 1.0), |s, v| {
        s.transponder.accuracy_share = v;
    }),
    parameter("step of latitude and longitude, °", (0.0, 1e-7), (0.0, 1e-5), |s, v| s.transponder.rounded_deg = v),
    parameter("share of drones with barometric heights", (0.0, 0.0), (0.0, 1.0), |s, v| {
        s.transponder.barometric_share = v;
    }),
    parameter("barometric heights: error of all, m", (-40.0, 40.0), (-40.0, 40.0), |s, v| {
        s.transponder.barometric_m = Span::new(v, v);
    }),
    parameter("barometric heights: further error of one, at most, m", (1.0, 5.0), (0.0, 10.0), |s, v| {
        let all_m = s.transponder.barometric_m.low;
        s.transponder.barometric_m = Span::new(rounded(all_m - v), rounded(all_m + v));
    }),
    parameter("share of drones with two transponders", (0.0, 0.0), (0.0, 1.0), |s, v| {
        s.transponder.second_share = v;
    }),
    parameter("errors of a second transponder over those of the first", (1.0, 2.0), (0.5, 3.0), |s, v| {
        s.transponder.second_errors = v;
    }),
    parameter("birds alone", (4.0, 15.0), (0.0, 60.0), |s, v| s.birds.count = whole(v)),
    parameter("flocks", (0.0, 1.0), (0.0, 3.0), |s, v| s.birds.flocks = whole(v)),
    parameter("birds of a flock", (8.0, 15.0), (5.0, 40.0), |s, v| s.birds.flock_size = whole(v)),
    parameter("share of birds that look like drones", (0.03, 0.08), (0.0, 0.4), |s, v| s.birds.high_share = v),
];

/// A parameter with its value in one world.
pub struct DrawnParameter {
    /// The parameter.
    pub parameter: &'static WorldParameter,
    /// Value, to three significant digits.
    pub value: f64,
    /// Whether the value was drawn at an end of its range.
    pub is_unusual: bool,
}

/// Parameters of the world with this seed, in the order of [`PARAMETERS`].
pub fn drawn(seed: u64) -> Vec<DrawnParameter> {
    let streams = RandomStreams::new("random-world", seed);
    let unusual = choose(&mut streams.of(Entity::RandomWorld, CHOICE));
    let draw = |(index, parameter): (usize, &'static WorldParameter)| {
        let stream = &mut streams.of(Entity::RandomWorld, index);
        let is_unusual = unusual.contains(&index);
        let value = if is_unusual { parameter.at_an_end(stream) } else { parameter.near(stream) };
        DrawnParameter { parameter, value: rounded(value), is_unusual }
    };
    PARAMETERS.iter().enumerate().map(draw).collect()
}

/// The world with this seed: a valid scenario of 300 s, flown with the same seed.
pub fn random_world(seed: u64) -> Scenario {
    let mut scenario =
        Scenario { name: format!("random-{seed}"), radars: vec![Radar::default()], ..Scenario::default() };
    for DrawnParameter { parameter, value, .. } in drawn(seed) {
        (parameter.set)(&mut scenario, value);
    }
    agree(&mut scenario);
    let flies = |scenario: &Scenario| {
        let steps = (scenario.duration_s * RATE_HZ as f64) as usize + 1;
        motion::fleet(scenario, steps, &RandomStreams::new(&scenario.name, seed)).is_ok()
    };
    while scenario.drones.separation_m > 0.0 && !flies(&scenario) {
        let half_m = scenario.drones.separation_m / 2.0;
        scenario.drones.separation_m = if half_m < 1.0 { 0.0 } else { half_m };
    }
    scenario
}

/// Table of the parameters, their usual values and their ranges, for `docs/SIMULATION.md`.
pub fn table() -> String {
    let mut text = "| parameter | usual | range |\n|---|---|---|\n".to_owned();
    for WorldParameter { name, usual, range, .. } in &PARAMETERS {
        let span = |(low, high): (f64, f64)| {
            if low == high { format!("{low}") } else { format!("{low} to {high}") }
        };
        let _ = writeln!(text, "| {name} | {} | {} |", span(*usual), span(*range));
    }
    text
}

/// Indices of the parameters that are drawn at an end of their range.
fn choose(stream: &mut RandomStream) -> Vec<usize> {
    let count = UNUSUAL.0 + stream.below(UNUSUAL.1 - UNUSUAL.0 + 1);
    let mut chosen = Vec::new();
    while chosen.len() < count {
        let index = stream.below(PARAMETERS.len());
        if PARAMETERS[index].usual != PARAMETERS[index].range && !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    chosen
}

/// Sets the keys that depend on several parameters.
fn agree(scenario: &mut Scenario) {
    let Scenario { drones, airspace, fixed_wing, .. } = scenario;
    if drones.fixed_wings > 0 {
        airspace.radius_m = airspace.radius_m.max(rounded(RADIUS_S * fixed_wing.speed_m_s.high));
    }
    if drones.pattern == Pattern::Formation {
        (drones.formation_m, drones.separation_m) = (FORMATION_M, FORMATION_M / 2.0);
    }
}

impl WorldParameter {
    /// Draws a usual value.
    fn near(&self, stream: &mut RandomStream) -> f64 {
        stream.within(Span::new(self.usual.0, self.usual.1))
    }

    /// Draws an unusual value, in the outer half of the range below or above the usual values.
    fn at_an_end(&self, stream: &mut RandomStream) -> f64 {
        let (below, above) = (self.usual.0 - self.range.0, self.range.1 - self.usual.1);
        let is_below = stream.chance(0.5);
        if below > 0.0 && (is_below || above <= 0.0) {
            stream.within(Span::new(self.range.0, self.range.0 + below / 2.0))
        } else {
            stream.within(Span::new(self.range.1 - above / 2.0, self.range.1))
        }
    }
}

fn on_radar(scenario: &mut Scenario, change: impl Fn(&mut Radar)) {
    scenario.radars.iter_mut().for_each(change);
}

/// Span from this share of a value to the value.
fn up_to(value: f64, share: f64) -> Span {
    Span::new(rounded(value * share), value)
}

fn whole(value: f64) -> u32 {
    value.round() as u32
}

/// Rounds to three significant digits.
fn rounded(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(digits.abs());
    if digits >= 0 { (value * scale).round() / scale } else { (value / scale).round() * scale }
}
