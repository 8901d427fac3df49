//! Cost on the machine that runs the evaluation: processor time, and time per slot.

use std::time::Instant;

use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile, SensorKind};
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, Simulation, Span, simulate};

use crate::flights::{self, CITY, EvaluationFailure};
use crate::runs::{FlightFiles, PictureOutput, ProgramRun};
use crate::summary::MeanValue;

/// The profiles, in the order of every pair of figures.
pub const PROFILES: [Profile; 2] = [Profile::Reference, Profile::Operational];
/// Number of flights of `dense` for processor time.
const DENSE_FLIGHTS: u64 = 4;
/// Numbers of targets for the exponent; half of them are birds.
const TARGETS: [u32; 4] = [500, 1000, 2000, 4000];
/// Duration of these flights, seconds: the window of 25 s fills, and slots are published from 6.25 s on.
const GROWTH_S: f64 = 30.0;
/// Number of drones of the crowd, all of them equipped and always visible. `CROWD_S` is the duration of the flight,
/// seconds.
const CROWD: u32 = 2000;
const CROWD_S: f64 = 75.0;

/// Number of runs over the same datagrams. The shortest time of each slot counts, which excludes other load of the
/// machine; the slowest of a few hundred slots would show that load.
const RUNS: usize = 3;

/// Measurements; pairs are `reference` and `operational`.
#[derive(Debug)]
pub struct SpeedResults {
    /// Seconds of flight of `dense` per second of processor time.
    pub times_real: [f64; 2],
    /// Ratio of the processor time of `operational` to that of `reference`, on `dense`: with pictures written, and
    /// without.
    pub processor: [Option<MeanValue>; 2],
    /// Ratio of the processor time of `operational` with integrity to that without, without pictures written.
    pub integrity: Option<MeanValue>,
    /// Time for a slot of `city` and its picture, 99th percentile, milliseconds.
    pub city_p99_ms: [f64; 2],
    /// Exponent of the processor time of a run as a function of the number of targets, at constant density.
    pub exponents: [Option<MeanValue>; 2],
    /// Time for a slot of 2,000 radar tracks and 2,000 transponders with `operational`, 99.9th percentile,
    /// milliseconds.
    pub crowd_p999_ms: Option<MeanValue>,
    /// Latest results of the example `load` for `city`: lateness beyond a sleeping timer, 99.9th percentile,
    /// milliseconds; memory, MB; and the same lateness of the current picture.
    pub live: [Option<MeanValue>; 3],
}

/// Results of `cargo run --release --example load -- city`.
const LIVE: &str = "target/load-city.json";

/// Live results, if available.
fn live() -> [Option<MeanValue>; 3] {
    const MIB_IN_MB: f64 = 1.048_576;
    let figures =
        std::fs::read(LIVE).ok().and_then(|octets| serde_json::from_slice::<serde_json::Value>(&octets).ok());
    let figure = |name: &str, unit: f64| MeanValue::of(&[figures.as_ref()?.get(name)?.as_f64()? * unit]);
    [
        figure("lateness_beyond_timer_p99.9_ms", 1.0),
        figure("most_resident_mib", MIB_IN_MB),
        figure("now_beyond_timer_p99.9_ms", 1.0),
    ]
}

/// Measures everything, on flights with seeds from this one on.
pub fn measure(first_seed: u64) -> Result<SpeedResults, EvaluationFailure> {
    let dense = flights::scenario("dense")?;
    let (mut ratios, mut integrity, mut spent_s) = ([Vec::new(), Vec::new()], Vec::new(), [0.0; 2]);
    for seed in first_seed..first_seed + DENSE_FLIGHTS {
        let files = FlightFiles::of(&flown(&dense, seed)?)?;
        let [flag_s, off_s] = files.processor_s(ProgramRun::of_integrity())?;
        integrity.push(flag_s / off_s);
        for (ratios, pictures) in ratios.iter_mut().zip([PictureOutput::Written, PictureOutput::NotWritten]) {
            let [reference_s, operational_s] = files.processor_s(ProgramRun::of_profiles(pictures))?;
            ratios.push(operational_s / reference_s);
            if pictures == PictureOutput::Written {
                spent_s = [spent_s[0] + reference_s, spent_s[1] + operational_s];
            }
        }
    }
    let city = RecordedReceptions::of(&flown(&flights::scenario(CITY)?, first_seed)?);
    let city_p99_ms =
        PROFILES.map(|profile| city.slots_ms(profile)).map(|slots_ms| quantile(&slots_ms, 0.99));

    let mut costs = [Vec::new(), Vec::new()];
    for targets in TARGETS {
        let spent_s = FlightFiles::of(&grown(targets, first_seed)?)?
            .processor_s(ProgramRun::of_profiles(PictureOutput::Written))?;
        for (costs, spent_s) in costs.iter_mut().zip(spent_s) {
            costs.push((f64::from(targets), spent_s));
        }
    }
    let crowd_ms = RecordedReceptions::of(&crowd(first_seed)?).slots_ms(Profile::Operational);
    Ok(SpeedResults {
        live: live(),
        times_real: spent_s.map(|spent_s| DENSE_FLIGHTS as f64 * dense.duration_s / spent_s),
        integrity: MeanValue::of(&integrity),
        processor: ratios.map(|ratios| MeanValue::of(&ratios)),
        city_p99_ms,
        exponents: costs.map(|costs| MeanValue::of(&[exponent(&costs)])),
        crowd_p999_ms: MeanValue::of(&[quantile(&crowd_ms, 0.999)]),
    })
}

/// Slope of the least-squares line through the logarithms.
fn exponent(costs: &[(f64, f64)]) -> f64 {
    let logs = || costs.iter().map(|&(targets, cost_s)| (targets.ln(), cost_s.ln()));
    let count = costs.len() as f64;
    let (mean_x, mean_y) = logs().fold((0.0, 0.0), |(x, y), log| (x + log.0 / count, y + log.1 / count));
    let products = logs().map(|(x, y)| (x - mean_x) * (y - mean_y));
    products.sum::<f64>() / logs().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

/// The smallest value that at least this share does not exceed; infinite without values.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = ((sorted.len() as f64 * share).ceil() as usize).saturating_sub(1);
    sorted.get(place).copied().unwrap_or(f64::INFINITY)
}

/// Flight with this number of targets at the density of `city`; half of them are birds. The radar's errors in metres
/// stay the same, so that a larger area is not harder.
fn grown(targets: u32, seed: u64) -> Result<Simulation, EvaluationFailure> {
    let mut scenario = flights::scenario(CITY)?;
    let city =
        scenario.drone_count() + scenario.birds.count + scenario.birds.flocks * scenario.birds.flock_size;
    let share = f64::from(targets) / f64::from(city);
    let of = |count: u32| (f64::from(count) * share).round() as u32;
    scenario.name = format!("city-{targets}");
    scenario.duration_s = GROWTH_S;
    let drones = &mut scenario.drones;
    (drones.multirotors, drones.fixed_wings) = (of(drones.multirotors), of(drones.fixed_wings));
    drones.equipped = of(drones.equipped);
    (scenario.birds.count, scenario.birds.flocks) = (of(scenario.birds.count), of(scenario.birds.flocks));
    let clutter = &mut scenario.clutter;
    (clutter.vehicles, clutter.points) = (of(clutter.vehicles), of(clutter.points));
    widened(scenario, share.sqrt(), seed)
}

/// Flight of 2,000 drones, each with a transponder without gaps and always visible to the radar.
fn crowd(seed: u64) -> Result<Simulation, EvaluationFailure> {
    let mut scenario = flights::scenario(CITY)?;
    let share = f64::from(CROWD) / f64::from(scenario.drone_count());
    scenario.name = "crowd".to_owned();
    scenario.duration_s = CROWD_S;
    (scenario.drones.multirotors, scenario.drones.fixed_wings) = (CROWD * 7 / 10, CROWD * 3 / 10);
    scenario.drones.equipped = CROWD;
    (scenario.birds.count, scenario.birds.flocks) = (0, 0);
    (scenario.clutter.vehicles, scenario.clutter.points) = (0, 0);
    for radar in &mut scenario.radars {
        (radar.unseen_s, radar.seduction_every_s) = (0.0, 0.0);
    }
    let transponder = &mut scenario.transponder;
    transponder.gap_every_s = 0.0;
    (transponder.starts_after_s, transponder.ends_before_s) = (Span::new(0.0, 4.0), Span::new(0.0, 0.0));
    widened(scenario, share.sqrt(), seed)
}

/// Simulates the scenario with airspace and radar range multiplied by this factor.
fn widened(mut scenario: Scenario, by: f64, seed: u64) -> Result<Simulation, EvaluationFailure> {
    scenario.airspace.radius_m *= by;
    for radar in &mut scenario.radars {
        radar.max_range_m *= by;
        radar.bias_azimuth_deg /= by;
        radar.track_azimuth_deg /= by;
        radar.plot_azimuth_deg /= by;
    }
    let mut simulation = flown(&scenario, seed)?;
    for sensor in &mut simulation.config.sensors {
        if let SensorKind::Radar(radar) = &mut sensor.kind
            && let Some(accuracy) = &mut radar.accuracy
        {
            accuracy.azimuth_deg /= by;
        }
    }
    simulation.config.fusion.threshold_m.iter_mut().for_each(|(range_m, _)| *range_m *= by);
    Ok(simulation)
}

fn flown(scenario: &Scenario, seed: u64) -> Result<Simulation, EvaluationFailure> {
    eprintln!("{} seed {seed}: how fast it is", scenario.name);
    Ok(simulate(scenario, seed, None)?)
}

/// Datagrams of a flight, received in this process.
struct RecordedReceptions {
    receptions: Vec<Reception>,
    config: Config,
}

impl RecordedReceptions {
    fn of(simulation: &Simulation) -> Self {
        Self { receptions: simulation.receptions().collect(), config: simulation.config.clone() }
    }

    /// Time for each slot and its picture, milliseconds: the minimum of several runs.
    fn slots_ms(&self, profile: Profile) -> Vec<f64> {
        let mut least_ms = self.run_ms(profile);
        for _ in 1..RUNS {
            for (least_ms, slot_ms) in least_ms.iter_mut().zip(self.run_ms(profile)) {
                *least_ms = least_ms.min(slot_ms);
            }
        }
        least_ms
    }

    fn run_ms(&self, profile: Profile) -> Vec<f64> {
        let mut slots_ms = Vec::new();
        self.replay(profile, |slot_ms| slots_ms.push(slot_ms));
        slots_ms
    }

    /// Replays datagrams to pictures, and passes the time of each slot to `note`.
    fn replay(&self, profile: Profile, mut note: impl FnMut(f64)) {
        let mut config = self.config.clone();
        config.fusion.profile = profile;
        let mut pipeline = Pipeline::new(&config, Masks::default());
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        for reception in &self.receptions {
            let since = now();
            pipeline.receive(reception);
            let mut slots = 0;
            for emission in pipeline.emissions() {
                std::hint::black_box(maker.picture(emission));
                slots += 1;
            }
            // A reception usually completes one slot. If it completes several, their time is divided equally.
            let slot_ms = since.elapsed().as_secs_f64() * 1e3 / f64::from(slots.max(1));
            (0..slots).for_each(|_| note(slot_ms));
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "how long it takes is what is measured")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponent_of_a_power_is_found() {
        let power = |exponent: f64| {
            TARGETS.map(|targets| (f64::from(targets), 3e-6 * f64::from(targets).powf(exponent)))
        };
        for expected in [1.0, 1.35, 2.0] {
            assert!((exponent(&power(expected)) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn quantile_is_one_of_the_values() {
        let values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!([0.5, 0.99, 0.999].map(|share| quantile(&values, share)), [500.0, 990.0, 999.0]);
        assert_eq!(quantile(&[7.0], 0.999), 7.0);
    }
}
