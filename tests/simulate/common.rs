//! Shared helpers: scenarios, flights with decoded records, running the program.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;

use asterix::{Record, blocks, cat048, cat129};
use fusion::frames::Geodetic;
use fusion::time::Time;
use nalgebra::Vector3;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::normalise::Normaliser;
use utm_fusion::simulate::{Scenario, Simulation, simulate};

pub(crate) use crate::program::{Scratch, utm_fusion};

/// A scenario in `config/scenarios`.
pub(crate) fn kept(name: &str) -> Scenario {
    Scenario::load(&kept_path(name)).unwrap()
}

pub(crate) fn kept_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios").join(format!("{name}.toml"))
}

/// Parses a scenario.
pub(crate) fn scenario(toml: &str) -> Scenario {
    Scenario::parse(toml, "test.toml").unwrap()
}

/// Scenario with perfect sensors; each test adds the error that it examines. Multirotors, fixed wings and birds may
/// pass through each other.
pub(crate) fn perfect(multirotors: u32, fixed_wings: u32, birds: u32) -> Scenario {
    scenario(&format!(
        r#"
        name = "perfect"
        duration_s = 300
        [drones]
        multirotors = {multirotors}
        fixed_wings = {fixed_wings}
        equipped = {}
        separation_m = 0
        [birds]
        count = {birds}
        [[radars]]
        bias_azimuth_deg = 0
        bias_range_m = 0
        bias_height_m = 0
        track_azimuth_deg = 0
        track_range_m = 0
        track_height_m = 0
        turn_factor = 1
        plot_azimuth_deg = 0
        plot_range_m = 0
        plot_height_m = 0
        plot_velocity_m_s = 0
        seen_s = 1e9
        unseen_s = 0
        hover_factor = 1
        detection = 1
        confirmed_by = 1
        seduction_every_s = 0
        swap_share = 0
        track_probability = 0
        plot_probability = 0
        [transponder]
        jitter = 0
        dropped = 0
        gap_every_s = 0
        starts_after_s = [0, 0]
        ends_before_s = [0, 0]
        gnss_horizontal_m = 0
        gnss_vertical_m = 0
        gnss_white_m = 0
        stamped_late_s = [0, 0]
        held_up = 0
        "#,
        multirotors + fixed_wings,
    ))
}

/// A plot as it arrived, and its drone.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    pub(crate) time: Time,
    pub(crate) received: Time,
    /// Index of the radar among the sensors of the configuration.
    pub(crate) sensor: usize,
    pub(crate) number: u16,
    /// Position in the service: east, north, up at the first radar, metres.
    pub(crate) position: Vector3<f64>,
    pub(crate) record: cat048::Record,
    /// Index into the flights; `None`: not a drone.
    pub(crate) drone: Option<usize>,
    pub(crate) seduced: bool,
}

/// A transponder's report as it arrived.
#[derive(Clone, Debug)]
pub(crate) struct Fix {
    pub(crate) time: Time,
    pub(crate) received: Time,
    pub(crate) position: Vector3<f64>,
    pub(crate) record: cat129::Record,
    pub(crate) drone: usize,
}

/// True state of a drone: metres east, north, up at the first radar, and height above mean sea level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub(crate) position: Vector3<f64>,
    pub(crate) altitude_m: f64,
    /// Velocity east, north, up, metres per second.
    pub(crate) velocity: Vector3<f64>,
}

impl Truth {
    /// Slant range in metres and azimuth in degrees at the first radar.
    pub(crate) fn polar(&self) -> (f64, f64) {
        (self.position.norm(), self.position.x.atan2(self.position.y).to_degrees())
    }
}

/// A decoded flight.
pub(crate) struct Flown {
    pub(crate) simulation: Simulation,
    /// Plots, in order of arrival.
    pub(crate) plots: Vec<Plot>,
    /// Reports, in order of arrival.
    pub(crate) fixes: Vec<Fix>,
    truth: Vec<Vec<Truth>>,
}

pub(crate) fn fly(scenario: &Scenario, seed: u64) -> Flown {
    Flown::new(simulate(scenario, seed, None).unwrap())
}

impl Flown {
    fn new(simulation: Simulation) -> Self {
        let normaliser = Normaliser::new(&simulation.config, Masks::default());
        let drones: HashMap<&str, usize> = simulation
            .flights
            .iter()
            .enumerate()
            .map(|(index, flight)| (flight.id.as_str(), index))
            .collect();
        let labels: HashMap<(&str, Time, u32), _> = simulation
            .labels
            .iter()
            .map(|label| ((label.sensor.as_str(), label.time, label.number), label))
            .collect();
        let (mut plots, mut fixes) = (Vec::new(), Vec::new());
        for datagram in &simulation.datagrams {
            let received = datagram.received;
            for block in blocks(&datagram.payload).map(Result::unwrap) {
                if block.category == cat048::Record::CATEGORY {
                    for record in block.records::<cat048::Record>().map(|located| located.unwrap().record) {
                        let Ok(plot) = normaliser.plot(&record, received) else { continue };
                        let sensor = usize::from(plot.track.sensor.0);
                        let key = (
                            simulation.config.sensors[sensor].id.as_str(),
                            plot.time,
                            u32::from(plot.track.number),
                        );
                        let label = labels[&key];
                        plots.push(Plot {
                            time: plot.time,
                            received,
                            sensor,
                            number: plot.track.number,
                            position: plot.position.0,
                            record,
                            drone: label.id.as_deref().map(|id| drones[id]),
                            seduced: label.seduced,
                        });
                    }
                }
                if block.category == cat129::Record::CATEGORY {
                    for record in block.records::<cat129::Record>().map(|located| located.unwrap().record) {
                        let fix = normaliser.fix(&record, received).unwrap();
                        let number: u32 = str::from_utf8(fix.identity.name()).unwrap().parse().unwrap();
                        let label = labels[&("drone-it", fix.time, number)];
                        // Reports of an attacker have no drone in the labels; use the drone with that serial number.
                        let drone = label.id.as_deref().map_or(number as usize - 1, |id| drones[id]);
                        fixes.push(Fix { time: fix.time, received, position: fix.position.0, record, drone });
                    }
                }
            }
        }
        let undulation_m = normaliser.undulation_m();
        let truth = simulation.flights.iter().map(|flight| {
            let states = flight.samples.iter().map(|sample| {
                let height_m = sample.altitude_amsl_m + undulation_m;
                let place = Geodetic::from_degrees(sample.latitude_deg, sample.longitude_deg, height_m);
                let [north, east, down] = sample.velocity_ned_m_s;
                Truth {
                    position: normaliser.frame().from_geodetic(place).0,
                    altitude_m: sample.altitude_amsl_m,
                    velocity: Vector3::new(east, north, -down),
                }
            });
            states.collect()
        });
        let truth = truth.collect();
        Self { plots, fixes, truth, simulation }
    }

    /// Time of take-off.
    pub(crate) fn start(&self) -> Time {
        self.simulation.flights[0].samples[0].time
    }

    /// Duration, seconds.
    pub(crate) fn duration_s(&self) -> f64 {
        (self.truth[0].len() - 1) as f64 / 10.0
    }

    /// Seconds after take-off.
    pub(crate) fn seconds(&self, time: Time) -> f64 {
        time.seconds_since(self.start())
    }

    /// All samples of a drone, 10 per second.
    pub(crate) fn samples(&self, drone: usize) -> &[Truth] {
        &self.truth[drone]
    }

    /// True state, linear between samples.
    pub(crate) fn truth(&self, drone: usize, seconds: f64) -> Truth {
        let samples = &self.truth[drone];
        let place = (seconds * 10.0).clamp(0.0, (samples.len() - 1) as f64);
        let (before, part) = (place as usize, place.fract());
        let (a, b) = (&samples[before], &samples[(before + 1).min(samples.len() - 1)]);
        Truth {
            position: a.position.lerp(&b.position, part),
            altitude_m: a.altitude_m + (b.altitude_m - a.altitude_m) * part,
            velocity: a.velocity.lerp(&b.velocity, part),
        }
    }

    /// Plots of each drone, in order of time.
    pub(crate) fn plots_by_drone(&self) -> BTreeMap<usize, Vec<&Plot>> {
        by_time(self.plots.iter().filter_map(|plot| Some((plot.drone?, plot))), |plot| plot.time)
    }

    /// Plots of each track number of a radar, in order of time. Reused numbers combine distant plots.
    pub(crate) fn plots_by_number(&self) -> BTreeMap<u16, Vec<&Plot>> {
        by_time(self.plots.iter().map(|plot| (plot.number, plot)), |plot| plot.time)
    }

    /// Reports of each drone, in order of time.
    pub(crate) fn fixes_by_drone(&self) -> BTreeMap<usize, Vec<&Fix>> {
        by_time(self.fixes.iter().map(|fix| (fix.drone, fix)), |fix| fix.time)
    }

    /// Arriving datagrams of one category, as receptions.
    pub(crate) fn receptions(&self, category: u8) -> impl Iterator<Item = Reception> {
        let wanted = self.simulation.datagrams.iter().filter(move |datagram| datagram.payload[0] == category);
        wanted.map(|datagram| Reception {
            received: Some(datagram.received),
            input: 0,
            from: None,
            kind: ReceptionKind::Datagram,
            origin: 0,
            payload: datagram.payload.clone(),
        })
    }
}

fn by_time<K: Ord, T>(
    entries: impl Iterator<Item = (K, T)>,
    time: impl Fn(&T) -> Time,
) -> BTreeMap<K, Vec<T>> {
    let mut sorted: BTreeMap<K, Vec<T>> = BTreeMap::new();
    entries.for_each(|(key, entry)| sorted.entry(key).or_default().push(entry));
    sorted.values_mut().for_each(|list| list.sort_by_key(|entry| time(entry)));
    sorted
}

/// Errors of a plot at the first radar: range in metres, azimuth in degrees and height in metres.
pub(crate) fn errors(flown: &Flown, plot: &Plot) -> [f64; 3] {
    let truth = flown.truth(plot.drone.unwrap(), flown.seconds(plot.time));
    let (range_m, azimuth_deg) = truth.polar();
    let polar = plot.record.polar_position.unwrap();
    let azimuth = (polar.azimuth_deg() - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
    let height_m = plot.record.height_3d.map_or(f64::NAN, |height| height.height_m() - truth.altitude_m);
    [polar.range_m() - range_m, azimuth, height_m]
}

/// UAV probability in the radar's record.
pub(crate) fn probability(plot: &Plot) -> f64 {
    f64::from(plot.record.special_purpose.as_ref().unwrap().contents()[0]) / 255.0
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Asserts the range, and prints the measured value (`--nocapture`).
#[track_caller]
pub(crate) fn between(what: &str, low: f64, value: f64, high: f64) {
    println!("{what}: {value:.4} (wanted {low} to {high})");
    assert!((low..=high).contains(&value), "{what}: {value} is not between {low} and {high}");
}

/// Runs the command to its end: exit code, standard output, standard error.
pub(crate) fn ran(command: &mut Command) -> (i32, String, String) {
    let output = command.output().unwrap();
    let text = |octets| String::from_utf8(octets).unwrap();
    (output.status.code().expect("it was not killed"), text(output.stdout), text(output.stderr))
}

/// `simulate SCENARIO --seed SEED --out DIRECTORY`, which must succeed.
pub(crate) fn files(scenario: &Path, seed: u64, directory: &Path) {
    let mut command = utm_fusion("simulate");
    command.arg(scenario).args(["--seed", &seed.to_string(), "--out"]).arg(directory);
    let (code, _, errors) = ran(&mut command);
    assert_eq!(code, 0, "{errors}");
}
