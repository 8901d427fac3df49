//! Inputs of the limit from a simulated flight: decoded plots and reports with their drones, true paths, and true
//! delays.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use asterix::{Record as _, blocks, cat048, cat129};
use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::config::Config;
use utm_fusion::evaluate::Label;
use utm_fusion::normalise::Normaliser;
use utm_fusion::picture::serial_text;
use utm_fusion::simulate::{Radar, Scenario, Simulation};
use world::ground::Ground;
use world::motion::{self, FlightPath, RATE_HZ};
use world::streams::{Entity, RandomStreams};
use world::transponder::{self, TransponderRole};

use super::smoother::{LimitMeasurement, LinearMeasurement, MeasurementKind};
use crate::flights::EvaluationFailure;

/// Minimum distance of a report from the truth that counts as a jump, in standard deviations.
const JUMPED: f64 = 6.0;
/// Time constant with which a radar's azimuths react to a turn, seconds (`docs/SIMULATION.md`).
const FELT_S: f64 = 1.0;

/// A drone, with its measurements in order of time.
pub struct LimitDrone {
    pub path: FlightPath,
    /// Delay of its transponder, seconds; `None` without a transponder.
    pub delay_s: Option<f64>,
    pub measured: Vec<LimitMeasurement>,
}

/// Drones of a flight, and the frame of their measurements.
pub struct LimitInputs {
    pub drones: Vec<LimitDrone>,
    normaliser: Normaliser,
    ground: Ground,
    /// Height of the radar's antenna above mean sea level, metres.
    pub antenna_m: f64,
    start: Time,
}

impl LimitInputs {
    /// Inputs from a flight with one radar.
    pub fn of(
        scenario: &Scenario,
        radar: &Radar,
        seed: u64,
        simulation: &Simulation,
    ) -> Result<Self, EvaluationFailure> {
        let streams = RandomStreams::new(&scenario.name, seed);
        let steps = (scenario.duration_s * RATE_HZ as f64) as usize + 1;
        let paths = motion::fleet(scenario, steps, &streams)?;
        let delay_s = |drone: usize, path: &FlightPath| {
            let number = motion::number(&scenario.drones, drone);
            let drawn =
                [Entity::Transponder, Entity::TransponderFault].map(|entity| streams.of(entity, number));
            let (model, duration_s) = (&scenario.transponder, scenario.duration_s);
            let sends =
                transponder::reports(model, drone, path, TransponderRole::Honest, duration_s, drawn.into());
            sends.reports.first().map(|report| report.stamped_s - report.measured_s)
        };
        let drone = |(number, path): (usize, FlightPath)| {
            let is_equipped = simulation.flights.get(number).is_some_and(|flight| flight.equipped);
            let delay_s = if is_equipped { delay_s(number, &path) } else { None };
            LimitDrone { path, delay_s, measured: Vec::new() }
        };
        let mut inputs = Self {
            drones: paths.into_iter().enumerate().map(drone).collect(),
            normaliser: Normaliser::new(&simulation.config, Masks::default()),
            ground: Ground::new(&scenario.place),
            antenna_m: scenario.place.ground_amsl_m + radar.antenna_agl_m,
            start: scenario.start_time(),
        };
        inputs.decode(scenario, radar, simulation);
        Ok(inputs)
    }

    /// Seconds from the beginning of the flight.
    pub fn seconds(&self, time: Time) -> f64 {
        time.seconds_since(self.start)
    }

    /// True position of a drone: east, north and height above mean sea level, metres.
    pub fn truth_m(&self, drone: usize, time_s: f64) -> [f64; 3] {
        let position = self.drones[drone].path.at(time_s).position;
        let place = self.normaliser.frame().from_geodetic(self.ground.geodetic(&position));
        [place.east(), place.north(), self.ground.altitude_amsl_m(&position)]
    }

    fn decode(&mut self, scenario: &Scenario, radar: &Radar, simulation: &Simulation) {
        let labels: BTreeMap<_, &Label> = simulation.labels.iter().map(|label| (key(label), label)).collect();
        let mut plots: BTreeMap<usize, Vec<PlotSeduction>> = BTreeMap::new();
        for datagram in &simulation.datagrams {
            let received = datagram.received;
            for block in blocks(&datagram.payload).flatten() {
                if block.category == cat048::Record::CATEGORY {
                    for record in block.records::<cat048::Record>().flatten() {
                        let seen = self.plot(&record.record, received, radar, &labels, &simulation.config);
                        if let Some((drone, seen)) = seen {
                            plots.entry(drone).or_default().push(seen);
                        }
                    }
                }
                if block.category == cat129::Record::CATEGORY {
                    for record in block.records::<cat129::Record>().flatten() {
                        let taken =
                            self.report(&record.record, received, scenario, &labels, &simulation.config);
                        if let Some((drone, measured)) = taken {
                            self.drones[drone].measured.push(measured);
                        }
                    }
                }
            }
        }
        for (drone, mut seen) in plots {
            seen.sort_by(|a, b| a.measured.time_s.total_cmp(&b.measured.time_s));
            let drone = &mut self.drones[drone];
            tracks(&mut seen, radar, &drone.path);
            drone.measured.extend(seen.iter().filter(|seen| !seen.is_seduced).map(|seen| seen.measured));
        }
        for drone in &mut self.drones {
            drone.measured.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            // A duplicated datagram is one measurement, at its first arrival.
            drone.measured.dedup_by(|later, first| {
                let is_same = later.time_s == first.time_s && later.kind == first.kind;
                if is_same {
                    first.arrives_s = first.arrives_s.min(later.arrives_s);
                }
                is_same
            });
        }
    }

    /// Decodes a plot of a drone; track and turn are added later.
    fn plot(
        &self,
        record: &cat048::Record,
        received: Time,
        radar: &Radar,
        labels: &BTreeMap<PlotKey<'_>, &Label>,
        config: &Config,
    ) -> Option<(usize, PlotSeduction)> {
        let plot = self.normaliser.plot(record, received).ok()?;
        let sensor = config.sensors.get(usize::from(plot.track.sensor.0))?;
        let label = labels.get(&(sensor.id.as_str(), plot.time, plot.track.number.to_string()))?;
        let height_m = self.normaliser.frame().to_geodetic(plot.position).height_m;
        let height_m = height_m - self.normaliser.undulation_m() - radar.bias_height_m;
        let drone = drone_of(label.id.as_deref()?)?;
        let time_s = self.seconds(plot.time);
        let azimuth = plot.position.east().atan2(plot.position.north()) - radar.bias_azimuth_deg.to_radians();
        let range_m = plot.slant_range_m - radar.bias_range_m;
        let (azimuth, range) = self.lines(drone, time_s, azimuth, range_m)?;
        let measured = LimitMeasurement {
            time_s,
            arrives_s: self.seconds(received),
            height_m: plot.height_measured.then_some(height_m),
            kind: MeasurementKind::Plot {
                place_m: [plot.position.east(), plot.position.north()],
                azimuth,
                range,
                turning: 1.0,
                track: 0,
            },
        };
        Some((drone, PlotSeduction { measured, is_seduced: label.seduced }))
    }

    /// Azimuth (radians) and slant range (metres), linearised at the drone's true position.
    fn lines(
        &self,
        drone: usize,
        time_s: f64,
        azimuth: f64,
        range_m: f64,
    ) -> Option<(LinearMeasurement, LinearMeasurement)> {
        self.drones.get(drone)?;
        let [east, north, height_m] = self.truth_m(drone, time_s);
        let above_m = height_m - self.antenna_m;
        let (squared, slant_m) = (east * east + north * north, east.hypot(north).hypot(above_m));
        let of = |factors: [f64; 2], off: f64| LinearMeasurement {
            factors,
            value: off + factors[0] * east + factors[1] * north,
        };
        let off = azimuth - east.atan2(north);
        let off = (off + PI).rem_euclid(2.0 * PI) - PI;
        let azimuth = of([north / squared, -east / squared], off);
        Some((azimuth, of([east / slant_m, north / slant_m], range_m - slant_m)))
    }

    /// Decodes a report that the drone sends itself; a report that has jumped is omitted.
    fn report(
        &self,
        record: &cat129::Record,
        received: Time,
        scenario: &Scenario,
        labels: &BTreeMap<PlotKey<'_>, &Label>,
        config: &Config,
    ) -> Option<(usize, LimitMeasurement)> {
        let fix = self.normaliser.fix(record, received).ok()?;
        let sensor = config.sensors.get(usize::from(fix.sensor.0))?;
        let label = labels.get(&(sensor.id.as_str(), fix.time, serial_text(fix.identity)))?;
        let drone = drone_of(label.id.as_deref()?)?;
        let time_s = self.seconds(fix.time);
        let delay_s = self.drones.get(drone)?.delay_s?;
        let place_m = [fix.position.east(), fix.position.north()];
        let truth_m = self.truth_m(drone, time_s - delay_s);
        let model = &scenario.transponder;
        let jumped_m = JUMPED * model.gnss_horizontal_m.hypot(model.gnss_white_m);
        let off_m = (place_m[0] - truth_m[0]).hypot(place_m[1] - truth_m[1]);
        if model.jump_every_s > 0.0 && off_m > jumped_m {
            return None;
        }
        let height_m = self.normaliser.frame().to_geodetic(fix.position).height_m;
        let path = &self.drones[drone].path;
        let velocity = if delay_s > 0.0 {
            (path.at(time_s).position - path.at(time_s - delay_s).position) / delay_s
        } else {
            path.at(time_s).velocity
        };
        let measured = LimitMeasurement {
            time_s,
            arrives_s: self.seconds(received),
            height_m: fix.height_measured.then_some(height_m - self.normaliser.undulation_m()),
            kind: MeasurementKind::Report { place_m, velocity_m_s: [velocity.x, velocity.y] },
        };
        Some((drone, measured))
    }
}

/// A plot, and whether its track is seduced.
struct PlotSeduction {
    measured: LimitMeasurement,
    is_seduced: bool,
}

/// Key of a label: sensor, time, and number or name.
type PlotKey<'a> = (&'a str, Time, String);

fn key(label: &Label) -> PlotKey<'_> {
    let name = label.identity.clone().unwrap_or_else(|| label.number.to_string());
    (label.sensor.as_str(), label.time, name)
}

/// Index of a drone from its id: D1 has index 0.
pub fn drone_of(id: &str) -> Option<usize> {
    id.strip_prefix('D')?.parse::<usize>().ok()?.checked_sub(1)
}

/// Separates the radar's tracks of one drone, and computes how far each plot is affected by turns. The plots are in
/// order of time. Track numbers are not reliable, because radars swap them.
fn tracks(seen: &mut [PlotSeduction], radar: &Radar, path: &FlightPath) {
    let share = 1.0 - (-radar.period_s / FELT_S).exp();
    let feel = |felt: &mut f64, time_s: f64| {
        let to = if path.turns(time_s) { radar.turn_factor } else { 1.0 };
        *felt += (to - *felt) * share;
    };
    let (mut felt, mut track) = (1.0, 0);
    let mut last: Option<(f64, bool)> = None;
    for one in seen {
        let time_s = one.measured.time_s;
        let goes_on = last.is_some_and(|(before_s, was_seduced)| {
            time_s - before_s <= radar.drop_after_s && (one.is_seduced || !was_seduced)
        });
        if !goes_on {
            track += 1;
            felt = 1.0;
            // The detections that confirmed the track are not reported.
            for before in (1..radar.confirmed_by).rev() {
                feel(&mut felt, time_s - f64::from(before) * radar.period_s);
            }
        }
        feel(&mut felt, time_s);
        if let MeasurementKind::Plot { turning, track: of, .. } = &mut one.measured.kind {
            (*turning, *of) = (felt, track);
        }
        last = Some((time_s, one.is_seduced));
    }
}
