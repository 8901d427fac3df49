//! What it costs on the machine that makes the document: processor time, and how long a slot takes.

use std::time::Instant;

use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile, SensorKind};
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, Simulation, Span, simulate};

use crate::flights::{self, CITY, Failure};
use crate::runs::{Files, Pictures, Run};
use crate::summary::Mean;

/// The profiles, in the order of every pair of figures.
pub const PROFILES: [Profile; 2] = [Profile::Reference, Profile::Operational];
/// Flights of `dense` of which the processor time is taken.
const DENSE_FLIGHTS: u64 = 4;
/// Targets over which the exponent is taken, half of them birds.
const TARGETS: [u32; 4] = [500, 1000, 2000, 4000];
/// How long these fly, seconds: the window of 25 s fills, and slots are published from 6.25 s on.
const GROWTH_S: f64 = 30.0;
/// Drones of the crowd, all of them equipped and always seen, and how long they fly, seconds.
const CROWD: u32 = 2000;
const CROWD_S: f64 = 75.0;

/// Of so many runs over the same datagrams, each slot's least time: what it takes is the same in all, what else the machine does
/// is not, and the slowest of a few hundred slots would be that.
const RUNS: usize = 3;

/// What was measured; pairs are of `reference` and `operational`.
#[derive(Debug)]
pub struct Speed {
    /// Seconds of flight of `dense` per second of processor time.
    pub times_real: [f64; 2],
    /// Processor time of a run of `operational` over that of one of `reference`, on `dense`: with the pictures written,
    /// and without.
    pub processor: [Option<Mean>; 2],
    /// The same of `operational` with integrity over that without, no pictures written.
    pub integrity: Option<Mean>,
    /// What a slot of `city` and its picture take, milliseconds: ninety-nine of a hundred take no more.
    pub city_p99_ms: [f64; 2],
    /// Of the processor time of a run over the number of targets, at constant density.
    pub exponents: [Option<Mean>; 2],
    /// What a slot of 2,000 radar tracks and 2,000 transponders takes under `operational`, milliseconds: 999 of a thousand take
    /// no more.
    pub crowd_p999_ms: Option<Mean>,
    /// `city` live, as the example `load` measured it last: lateness beyond a sleeping timer, 999 of a thousand slots,
    /// milliseconds, memory, MB, and the same lateness of the picture of now.
    pub live: [Option<Mean>; 3],
}

/// Where `cargo run --release --example load -- city` leaves its figures.
const LIVE: &str = "target/load-city.json";

/// What was measured live, where it was.
fn live() -> [Option<Mean>; 3] {
    const MIB_IN_MB: f64 = 1.048_576;
    let figures =
        std::fs::read(LIVE).ok().and_then(|octets| serde_json::from_slice::<serde_json::Value>(&octets).ok());
    let figure = |name: &str, unit: f64| Mean::of(&[figures.as_ref()?.get(name)?.as_f64()? * unit]);
    [
        figure("lateness_beyond_timer_p99.9_ms", 1.0),
        figure("most_resident_mib", MIB_IN_MB),
        figure("now_beyond_timer_p99.9_ms", 1.0),
    ]
}

/// Measures everything, on flights with seeds from this one on.
pub fn measure(first_seed: u64) -> Result<Speed, Failure> {
    let dense = flights::scenario("dense")?;
    let (mut ratios, mut integrity, mut spent_s) = ([Vec::new(), Vec::new()], Vec::new(), [0.0; 2]);
    for seed in first_seed..first_seed + DENSE_FLIGHTS {
        let files = Files::of(&flown(&dense, seed)?)?;
        let [flag_s, off_s] = files.processor_s(Run::of_integrity())?;
        integrity.push(flag_s / off_s);
        for (ratios, pictures) in ratios.iter_mut().zip([Pictures::Written, Pictures::NotWritten]) {
            let [reference_s, operational_s] = files.processor_s(Run::of_profiles(pictures))?;
            ratios.push(operational_s / reference_s);
            if pictures == Pictures::Written {
                spent_s = [spent_s[0] + reference_s, spent_s[1] + operational_s];
            }
        }
    }
    let city = Recorded::of(&flown(&flights::scenario(CITY)?, first_seed)?);
    let city_p99_ms =
        PROFILES.map(|profile| city.slots_ms(profile)).map(|slots_ms| quantile(&slots_ms, 0.99));

    let mut costs = [Vec::new(), Vec::new()];
    for targets in TARGETS {
        let spent_s =
            Files::of(&grown(targets, first_seed)?)?.processor_s(Run::of_profiles(Pictures::Written))?;
        for (costs, spent_s) in costs.iter_mut().zip(spent_s) {
            costs.push((f64::from(targets), spent_s));
        }
    }
    let crowd_ms = Recorded::of(&crowd(first_seed)?).slots_ms(Profile::Operational);
    Ok(Speed {
        live: live(),
        times_real: spent_s.map(|spent_s| DENSE_FLIGHTS as f64 * dense.duration_s / spent_s),
        integrity: Mean::of(&integrity),
        processor: ratios.map(|ratios| Mean::of(&ratios)),
        city_p99_ms,
        exponents: costs.map(|costs| Mean::of(&[exponent(&costs)])),
        crowd_p999_ms: Mean::of(&[quantile(&crowd_ms, 0.999)]),
    })
}

/// Slope of the straight line through the logarithms, by least squares.
fn exponent(costs: &[(f64, f64)]) -> f64 {
    let logs = || costs.iter().map(|&(targets, cost_s)| (targets.ln(), cost_s.ln()));
    let count = costs.len() as f64;
    let (mean_x, mean_y) = logs().fold((0.0, 0.0), |(x, y), log| (x + log.0 / count, y + log.1 / count));
    let products = logs().map(|(x, y)| (x - mean_x) * (y - mean_y));
    products.sum::<f64>() / logs().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

/// The least of which so large a share is not above; infinite of none.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = ((sorted.len() as f64 * share).ceil() as usize).saturating_sub(1);
    sorted.get(place).copied().unwrap_or(f64::INFINITY)
}

/// So many targets as dense as those of `city`, half of them birds. What the radar errs by in metres stays the same: a larger
/// area is no harder, only larger.
fn grown(targets: u32, seed: u64) -> Result<Simulation, Failure> {
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

/// Two thousand drones, each with a transponder without gaps and always on the radar.
fn crowd(seed: u64) -> Result<Simulation, Failure> {
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

/// The scenario over an airspace that is so many times as wide, by a radar that sees so many times as far.
fn widened(mut scenario: Scenario, by: f64, seed: u64) -> Result<Simulation, Failure> {
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

fn flown(scenario: &Scenario, seed: u64) -> Result<Simulation, Failure> {
    eprintln!("{} seed {seed}: how fast it is", scenario.name);
    Ok(simulate(scenario, seed, None)?)
}

/// A flight as it is received, in this process.
struct Recorded {
    receptions: Vec<Reception>,
    config: Config,
}

impl Recorded {
    fn of(simulation: &Simulation) -> Self {
        Self { receptions: simulation.receptions().collect(), config: simulation.config.clone() }
    }

    /// How long each slot and its picture take, milliseconds: the least of several runs.
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

    /// From datagrams to pictures. Each slot's time goes to `note`.
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
            // A reception has one slot as a rule; where it has several, each is as slow as all of them on average.
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
    fn the_exponent_is_that_of_a_power() {
        let power = |exponent: f64| {
            TARGETS.map(|targets| (f64::from(targets), 3e-6 * f64::from(targets).powf(exponent)))
        };
        for expected in [1.0, 1.35, 2.0] {
            assert!((exponent(&power(expected)) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!([0.5, 0.99, 0.999].map(|share| quantile(&values, share)), [500.0, 990.0, 999.0]);
        assert_eq!(quantile(&[7.0], 0.999), 7.0);
    }
}
