//! Coverage of the intervals: how often they contain the value of the whole population, over many simulated recordings.

use std::collections::{BTreeMap, BTreeSet};

use lab::assess::{AssessedRecording, Assessment, AssessmentReference, assess};
use lab::simulate::{Scenario, simulate};
use picture::UncooperativeDetector;
use site::areas::Masks;
use site::config::Profile;

use crate::SCENARIO;

/// Seed of the first recording; nothing was tuned on it and those that follow.
const FIRST_SEED: u64 = 5001;
/// Number of recordings.
const RECORDINGS: u64 = 200;

/// Value, interval, and weight of a figure in one recording.
type Found = (f64, Option<[f64; 2]>, f64);

/// Assesses a simulated recording.
fn assessed(scenario: &Scenario, seed: u64) -> Assessment {
    let mut simulation = simulate(scenario, seed, None).unwrap();
    if std::env::var_os("ASSESS_REFERENCE").is_some() {
        let fusion = simulation.config.fusion.clone().with_profile(Profile::Reference);
        simulation.config.fusion = fusion.unwrap();
    }
    let detector = UncooperativeDetector::load(&simulation.config, Masks::default()).unwrap();
    let receptions = simulation.receptions().map(Ok);
    let recording =
        AssessedRecording::read(receptions, &simulation.config, Masks::default(), detector).unwrap();
    let (truth, classes) = (simulation.truth(), BTreeMap::new());
    let reference = AssessmentReference { truth: Some(&truth), classes: &classes, seed: 1 };
    assess(&recording, &simulation.config, reference)
}

/// Run it alone, with `--ignored --nocapture`: it simulates 200 recordings. `ASSESS_SCENARIO` names another scenario (TOML),
/// `ASSESS_RECORDINGS` another number, `ASSESS_SEED` another first seed, and `ASSESS_REFERENCE` the other profile.
#[test]
#[ignore = "simulates and assesses 200 recordings"]
fn intervals_contain_the_value_of_the_population() {
    let text = std::env::var("ASSESS_SCENARIO")
        .map_or_else(|_| SCENARIO.to_owned(), |path| std::fs::read_to_string(path).unwrap());
    let number = |name: &str, usual: u64| std::env::var(name).map_or(usual, |text| text.parse().unwrap());
    let (recordings, first) = (number("ASSESS_RECORDINGS", RECORDINGS), number("ASSESS_SEED", FIRST_SEED));
    let scenario = Scenario::parse(&text, "assessed.toml").unwrap();
    let mut found: BTreeMap<String, Vec<Found>> = BTreeMap::new();
    for seed in first..first + recordings {
        for figure in assessed(&scenario, seed)
            .sections
            .iter()
            .flat_map(|section| &section.tables)
            .flat_map(|table| &table.figures)
        {
            // Registration has the deviation of the engine, and no blocks.
            let (Some(value), Some(_)) = (figure.value, figure.blocks) else { continue };
            // Rates and clocks: recordings of equal length count the same.
            let is_rate = figure.unit.contains('/') || figure.unit == "1/h";
            let weight = figure.count.filter(|_| !is_rate).map_or(1.0, |count| count as f64);
            found.entry(figure.key.clone()).or_default().push((value, figure.interval, weight));
        }
    }
    let (mut inside, mut all) = (0, 0);
    let mut by_section: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    let mut shares = BTreeSet::new();
    for (key, found) in &found {
        let with_interval = found.iter().filter(|found| found.1.is_some()).count() as u64;
        if with_interval < 3 * recordings / 4 {
            continue;
        }
        let power = if key.contains(".rms") { 2 } else { 1 };
        let weight: f64 = found.iter().map(|found| found.2).sum();
        let mean = found.iter().map(|found| found.0.powi(power) * found.2).sum::<f64>() / weight;
        let population = if power == 2 { mean.sqrt() } else { mean };
        let contains = |found: &&Found| found.1.is_some_and(|[low, high]| (low..=high).contains(&population));
        let hits = found.iter().filter(contains).count() as u64;
        println!("{key}: population {population:.3}, {hits} of {with_interval} intervals contain it");
        inside += hits;
        all += with_interval;
        shares.insert(1000 * hits / with_interval);
        let section = key
            .split('.')
            .find(|part| !["sensor", "picture", "gamekeeper", "drone-it"].contains(part))
            .unwrap();
        let sum = by_section.entry(section.to_owned()).or_default();
        *sum = [sum[0] + hits, sum[1] + with_interval];
    }
    for (section, [hits, of]) in &by_section {
        println!("{section}: {:.1} % of {of}", 100.0 * *hits as f64 / *of as f64);
    }
    let share = 100.0 * f64::from(inside as u32) / f64::from(all as u32);
    println!(
        "all: {share:.1} % of {all} intervals of {recordings} recordings; per figure {:?} to {:?} per mille",
        shares.first(),
        shares.last()
    );
    assert!((92.0..=98.0).contains(&share), "{share}");
}
