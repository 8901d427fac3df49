//! Measures predictions of entries into areas: drones with transponders on straight flight, and drones of a scenario.
//!
//! ```sh
//! cargo run --release --example entries -- --seeds 20 --first-seed 1001
//! ```
//!
//! Prints three numbers for each scenario: entries of drones on straight flight for 15 s with an active warning 10 s
//! ahead; warnings without an entry; and the error of the predicted time 10 to 30 s ahead.

use std::collections::BTreeMap;
use std::error::Error;

use clap::Parser;
use fusion::time::{SECOND, Time};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use utm_fusion::areas::{Areas, Masks};
use utm_fusion::config::{AlertArea, Area, AreaKind};
use utm_fusion::live::{
    AlertChange, AlertDetails, AlertKind, AlertMonitor, AlertSettings, PredictionPicture,
};
use utm_fusion::picture::{Picture, PictureMaker};
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, SimulatedFlight, Simulation, simulate};

type EntriesFailure = Box<dyn Error + Send + Sync>;

/// Number of areas per flight.
const AREAS: usize = 12;
/// An entry counts if the drone was outside and flew straight for this time before, seconds.
const STRAIGHT_S: f64 = 15.0;
/// Maximum change of velocity in straight flight, metres per second.
const STEADY: f64 = 1.5;
/// Required warning time before an entry, seconds.
const AHEAD_S: f64 = 10.0;
/// A warning is false if no entry follows within this time after its end, seconds.
const FOLLOWS_S: f64 = 15.0;
/// Time after which aircraft are published, seconds.
const SETTLE_S: f64 = 30.0;

const STRAIGHT: &str = r#"
name = "straight"
duration_s = 300

[airspace]
radius_m = 1400

[drones]
pattern = "crossing"
multirotors = 4
fixed_wings = 4
equipped = 8
separation_m = 0

[multirotor]
hover_share = 0.0

[fixed_wing]
loiter_share = 0.0
"#;

#[derive(Parser)]
struct Args {
    #[arg(long, default_value_t = 20)]
    seeds: u64,
    #[arg(long, default_value_t = 1001)]
    first_seed: u64,
}

/// A box: west, south, east and north, degrees; floor and ceiling, metres above mean sea level.
struct Cuboid {
    sides_deg: [f64; 4],
    floor_m: f64,
    ceiling_m: f64,
}

impl Cuboid {
    fn random(scenario: &Scenario, random: &mut ChaCha8Rng) -> Self {
        let (place, airspace) = (&scenario.place, &scenario.airspace);
        let reach_m = 0.8 * airspace.radius_m;
        let east_m = airspace.east_m + random.random_range(-reach_m..reach_m);
        let north_m = airspace.north_m + random.random_range(-reach_m..reach_m);
        let half_m = random.random_range(60.0..200.0);
        // An approximation is sufficient: areas and truth use the same coordinates.
        let degree_m = 111_200.0;
        let lng =
            |metres: f64| place.longitude_deg + metres / degree_m / place.latitude_deg.to_radians().cos();
        let lat = |metres: f64| place.latitude_deg + metres / degree_m;
        let sides_deg =
            [lng(east_m - half_m), lat(north_m - half_m), lng(east_m + half_m), lat(north_m + half_m)];
        let (floor_m, ceiling_m) = match random.random_bool(0.5) {
            true => (-1000.0, 10_000.0),
            false => (place.ground_amsl_m + 60.0, place.ground_amsl_m + 300.0),
        };
        Self { sides_deg, floor_m, ceiling_m }
    }

    fn contains(&self, lng: f64, lat: f64, altitude_m: f64) -> bool {
        let [west, south, east, north] = self.sides_deg;
        (west..=east).contains(&lng)
            && (south..=north).contains(&lat)
            && (self.floor_m..=self.ceiling_m).contains(&altitude_m)
    }

    fn zone(&self, name: &str) -> Value {
        let [west, south, east, north] = self.sides_deg;
        json!({ "type": "Feature", "properties": { "identifier": name, "type": "PROHIBITED" },
            "geometry": { "type": "Polygon",
                "coordinates": [[[west, south], [east, south], [east, north], [west, north], [west, south]]],
                "layer": { "lower": self.floor_m, "lowerReference": "AMSL",
                    "upper": self.ceiling_m, "upperReference": "AMSL" } } })
    }
}

/// A true entry of a flight into an area.
struct TrueEntry {
    flight: usize,
    area: String,
    time: Time,
    is_straight: bool,
}

/// A warning of a flight's entry into an area, from its beginning to its end.
struct EntryWarning {
    flight: Option<usize>,
    area: String,
    from: Time,
    until: Time,
    /// Times of predictions, with the predicted time to the entry, seconds.
    foretold: Vec<(Time, f64)>,
}

#[derive(Default)]
struct EntryScore {
    entries: usize,
    warned: usize,
    warnings: usize,
    false_warnings: usize,
    drone_hours: f64,
    squared_s2: f64,
    foretold: usize,
}

fn main() -> Result<(), EntriesFailure> {
    let args = Args::parse();
    let crossing = include_str!("../../config/scenarios/crossing.toml");
    for text in [STRAIGHT, crossing] {
        let scenario = Scenario::parse(text, "scenario")?;
        let mut score = EntryScore::default();
        for seed in args.first_seed..args.first_seed + args.seeds {
            add(&scenario, seed, &mut score)?;
        }
        let rms_s = (score.squared_s2 / score.foretold.max(1) as f64).sqrt();
        println!(
            "{}: seeds {} to {}: {} entries on straight flight, {:.1} % warned {AHEAD_S} s ahead; {} warnings, {:.1} false a \
             drone-hour; time to entry 10 to 30 s ahead off by {rms_s:.1} s rms",
            scenario.name,
            args.first_seed,
            args.first_seed + args.seeds - 1,
            score.entries,
            100.0 * score.warned as f64 / score.entries.max(1) as f64,
            score.warnings,
            score.false_warnings as f64 / score.drone_hours,
        );
    }
    Ok(())
}

fn add(scenario: &Scenario, seed: u64, score: &mut EntryScore) -> Result<(), EntriesFailure> {
    let simulation = simulate(scenario, seed, None)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let areas: BTreeMap<String, Cuboid> =
        (0..AREAS).map(|number| (format!("Z{number}"), Cuboid::random(scenario, &mut random))).collect();
    let entries = entries(&simulation, &areas);
    let warnings = warnings(&simulation, &areas)?;
    let equipped = simulation.flights.iter().filter(|flight| flight.equipped).count();
    score.drone_hours += equipped as f64 * scenario.duration_s / 3600.0;
    let is_of = |warning: &EntryWarning, entry: &TrueEntry| {
        warning.flight == Some(entry.flight) && warning.area == entry.area
    };
    for entry in entries.iter().filter(|entry| entry.is_straight) {
        let is_warned = |warning: &&EntryWarning| {
            is_of(warning, entry)
                && entry.time.seconds_since(warning.from) >= AHEAD_S
                && entry.time.seconds_since(warning.until) < AHEAD_S
        };
        score.entries += 1;
        let Some(warning) = warnings.iter().find(is_warned) else { continue };
        score.warned += 1;
        for (time, foretold_s) in &warning.foretold {
            let left_s = entry.time.seconds_since(*time);
            if (10.0..=30.0).contains(&left_s) {
                score.squared_s2 += (foretold_s - left_s).powi(2);
                score.foretold += 1;
            }
        }
    }
    for warning in warnings.iter().filter(|warning| warning.flight.is_some()) {
        let follows = |entry: &TrueEntry| {
            is_of(warning, entry)
                && entry.time >= warning.from
                && entry.time.seconds_since(warning.until) <= FOLLOWS_S
        };
        score.warnings += 1;
        score.false_warnings += usize::from(!entries.iter().any(follows));
    }
    Ok(())
}

/// True entries of drones with transponders.
fn entries(simulation: &Simulation, areas: &BTreeMap<String, Cuboid>) -> Vec<TrueEntry> {
    let mut found = Vec::new();
    for (number, flight) in simulation.flights.iter().enumerate().filter(|(_, flight)| flight.equipped) {
        let before = (STRAIGHT_S * 10.0) as usize;
        for (name, area) in areas {
            let inside: Vec<bool> = flight
                .samples
                .iter()
                .map(|sample| {
                    area.contains(sample.longitude_deg, sample.latitude_deg, sample.altitude_amsl_m)
                })
                .collect();
            for step in 1..inside.len() {
                if inside[step] && !inside[step - 1] {
                    let past = step.saturating_sub(before);
                    let now = flight.samples[step].velocity_ned_m_s;
                    let is_steady = flight.samples[past..step].iter().all(|sample| {
                        let apart = sample.velocity_ned_m_s.iter().zip(now).map(|(a, b)| (a - b).powi(2));
                        apart.sum::<f64>().sqrt() < STEADY
                    });
                    found.push(TrueEntry {
                        flight: number,
                        area: name.clone(),
                        time: flight.samples[step].time,
                        is_straight: step as f64 > SETTLE_S * 10.0
                            && is_steady
                            && inside[past..step].iter().all(|inside| !inside),
                    });
                }
            }
        }
    }
    found
}

/// Warnings of the service for the simulated datagrams.
fn warnings(
    simulation: &Simulation,
    areas: &BTreeMap<String, Cuboid>,
) -> Result<Vec<EntryWarning>, EntriesFailure> {
    let zones: Vec<Value> = areas.iter().map(|(name, area)| area.zone(name)).collect();
    let file = std::env::temp_dir().join(format!("utm-fusion-entries-{}.geojson", std::process::id()));
    std::fs::write(&file, json!({ "type": "FeatureCollection", "features": zones }).to_string())?;
    let kind = AreaKind::Alert(AlertArea::default());
    let loaded = Areas::load(&[Area { kind, file: file.clone() }])?;
    std::fs::remove_file(&file)?;

    let config = &simulation.config;
    let mut pipeline = Pipeline::new(config, Masks::default());
    let maker = PictureMaker::new(config, pipeline.normaliser());
    let mut alerts =
        AlertMonitor::new(AlertSettings::new(&simulation.config.alerts, &loaded)?, Time::default());
    let (mut lasting, mut over) = (BTreeMap::<u64, EntryWarning>::new(), Vec::new());
    let mut look = |emission: fusion::Emission| {
        let mut emission = emission;
        let now = emission.now.take().map(|now| maker.now(now));
        alerts.note_picture(&maker.picture(emission), &maker);
        let Some(now) = now else { return };
        alerts.note_approaches(PredictionPicture::Now(&now), &maker);
        for (change, alert) in alerts.take_changes() {
            let AlertDetails::AreaPredicted { area, .. } = &alert.details else { continue };
            match change {
                AlertChange::Began => {
                    let flight = whose(&simulation.flights, &now, &maker, &alert.subject);
                    let warning = EntryWarning {
                        flight,
                        area: area.name.clone(),
                        from: now.time,
                        until: now.time,
                        foretold: Vec::new(),
                    };
                    lasting.insert(alert.id, warning);
                }
                AlertChange::Ended => over.extend(
                    lasting.remove(&alert.id).map(|warning| EntryWarning { until: now.time, ..warning }),
                ),
                // There are no operator decisions on alerts in this program.
                _ => {}
            }
        }
        if now.slot.0 % 4 == 0 {
            for alert in alerts.all().iter().filter(|alert| alert.kind == AlertKind::AreaPredicted) {
                if let (AlertDetails::AreaPredicted { time_to_entry_s, .. }, Some(warning)) =
                    (&alert.details, lasting.get_mut(&alert.id))
                {
                    warning.foretold.extend(time_to_entry_s.map(|seconds| (now.time, seconds)));
                }
            }
        }
    };
    for reception in simulation.receptions() {
        pipeline.receive(&reception);
        pipeline.emissions().for_each(&mut look);
    }
    pipeline.finish();
    pipeline.emissions().for_each(&mut look);
    let end = Time::from_nanos(i64::MAX / 2);
    over.extend(lasting.into_values().map(|warning| EntryWarning { until: end, ..warning }));
    Ok(over)
}

/// The drone with a transponder that is nearest to the track.
fn whose(flights: &[SimulatedFlight], now: &Picture, maker: &PictureMaker, id: &str) -> Option<usize> {
    /// Maximum distance of the drone from the track, metres.
    const NEAR_M: f64 = 100.0;
    let track = now.tracks.iter().find(|track| maker.track_id(track) == id)?;
    track.point.source.transponder()?;
    let (lng, lat) = (track.position.longitude_deg(), track.position.latitude_deg());
    let distance_m = |flight: &SimulatedFlight| {
        let first = flight.samples.first()?.time;
        let step = ((now.time.nanos() - first.nanos()) / (SECOND / 10)).max(0) as usize;
        let sample = flight.samples.get(step)?;
        let east = (sample.longitude_deg - lng) * lat.to_radians().cos();
        Some(111_200.0 * east.hypot(sample.latitude_deg - lat))
    };
    let near = flights.iter().enumerate().filter(|(_, flight)| flight.equipped);
    let near = near.filter_map(|(number, flight)| Some((number, distance_m(flight)?)));
    let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.filter(|(_, metres)| *metres < NEAR_M).map(|(number, _)| number)
}
