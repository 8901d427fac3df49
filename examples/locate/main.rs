//! How well `utm-fusion locate` finds radars: random worlds, standard scenarios, and the drone trial's radar.
//!
//! `cargo run --release --features full --example locate -- --first 1001 --count 40`
//!
//! In each world the radar stands at a random place, 0.5 to 2.5 km from the centre of the airspace, with a random bearing; the
//! recording ends after about 15 drone-minutes of transponders. Nothing of the radar is known beforehand. Two thirds of the sites
//! are random worlds, the others standard scenarios of `config/scenarios`.

mod moved;
mod mutual;

use std::error::Error;
use std::path::Path;

use clap::Parser;
use fusion::frames::{AtRadar, Geodetic, TangentPlane};
use input::capture::{Capture, CapturedDatagram};
use lab::simulate::{Scenario, random, simulate};
use locate::AlignmentData;
use locate::{LocatedRadar, NotLocated, locate};

#[derive(Parser)]
struct Args {
    /// First seed.
    #[arg(long, default_value_t = 1001)]
    first: u64,
    /// Number of sites.
    #[arg(long, default_value_t = 40)]
    count: u64,
    /// Drone-minutes of each recording.
    #[arg(long, default_value_t = 15.0)]
    minutes: f64,
    /// Prints each site.
    #[arg(long)]
    each: bool,
    /// Moves the radar by these metres after half of each flight, and prints how soon the live check notices it.
    #[arg(long, conflicts_with = "turned")]
    moved: Option<f64>,
    /// Turns it by these degrees instead.
    #[arg(long)]
    turned: Option<f64>,
    /// Lets two radars align each other by drones without transponders, with the minutes of drones that both see.
    #[arg(long)]
    mutual: bool,
}

/// Standard scenarios with transponders and one radar.
const STANDARD: [&str; 12] = [
    "crossing",
    "paper",
    "bias",
    "fast",
    "braking",
    "legs",
    "gaps",
    "swarm",
    "radar-clock",
    "slow-gnss",
    "late-stamps",
    "ghosts",
];

/// A uniform number from 0 to 1 (SplitMix64).
fn uniform(seed: u64, number: u64) -> f64 {
    let mut z =
        seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// The scenario of a site, and the bias of its bearing in degrees.
fn scenario(seed: u64, minutes: f64) -> Result<(Scenario, f64), Box<dyn Error>> {
    let mut scenario = if seed.is_multiple_of(3) {
        let name = STANDARD[(seed / 3) as usize % STANDARD.len()];
        Scenario::load(&Path::new("config/scenarios").join(format!("{name}.toml")))?
    } else {
        random::random_world(seed)
    };
    scenario.radars.truncate(1);
    let radar = &mut scenario.radars[0];
    let (distance_m, direction) =
        (500.0 + 2000.0 * uniform(seed, 1), std::f64::consts::TAU * uniform(seed, 2));
    radar.east_m = scenario.airspace.east_m + distance_m * direction.sin();
    radar.north_m = scenario.airspace.north_m + distance_m * direction.cos();
    radar.bias_azimuth_deg = 360.0 * uniform(seed, 3) - 180.0;
    let bias_deg = radar.bias_azimuth_deg;
    scenario.duration_s = (minutes * 60.0 / f64::from(scenario.drones.equipped)).clamp(90.0, 1800.0);
    Ok((scenario, bias_deg))
}

/// Errors of one site, and the errors over their deviations.
struct Score {
    position_m: f64,
    bearing_deg: f64,
    clock_s: f64,
    /// Squared normalised errors: position (two values), bearing, clock, height, range offset.
    squares: [f64; 5],
}

fn score(located: &LocatedRadar, antenna: Geodetic, bearing_deg: f64, clock_s: f64, offset_m: f64) -> Score {
    let plane = TangentPlane::<AtRadar>::at(antenna);
    let off = plane.from_geodetic(located.antenna).0;
    let off_en = off.xy();
    let weights = located.covariance_m2.try_inverse().unwrap_or_default();
    let square = off_en.dot(&(weights * off_en));
    let turned = (located.bearing_deg.value - bearing_deg + 540.0).rem_euclid(360.0) - 180.0;
    let late = located.clock_s.value - clock_s;
    let range = located.range_offset_m.value - offset_m;
    Score {
        position_m: off_en.norm(),
        bearing_deg: turned.abs(),
        clock_s: late.abs(),
        squares: [
            square / 2.0,
            (turned / located.bearing_deg.sigma).powi(2),
            (late / located.clock_s.sigma).powi(2),
            (off.z / located.height_m.sigma).powi(2),
            (range / located.range_offset_m.sigma).powi(2),
        ],
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// A simulated site: what `locate` makes of it, its name, its bearing (degrees), clock (seconds) and range offset (metres), and
/// its antenna.
type Site = (Result<LocatedRadar, NotLocated>, String, [f64; 3], Geodetic);

fn simulated(seed: u64, minutes: f64) -> Result<Site, Box<dyn Error>> {
    let (scenario, bias_deg) = scenario(seed, minutes)?;
    let simulation = simulate(&scenario, seed, None)?;
    let mut data = AlignmentData::default().with_undulation(Some(scenario.place.geoid_undulation_m));
    for datagram in &simulation.datagrams {
        data.datagram(&CapturedDatagram {
            received: Some(datagram.received),
            payload: datagram.payload.clone(),
            ..CapturedDatagram::default()
        });
    }
    let radar = &scenario.radars[0];
    let ground = world::ground::Ground::new(&scenario.place);
    let antenna = ground.antenna(radar).position;
    let of = data.radars.values().max_by_key(|radar| radar.plots.len()).ok_or("no plots")?;
    // I034/120 states the true place: left out.
    let located = locate(&data.plots_of(of), &data.reports, None);
    let clock_s = radar.clock_s + radar.clock_drift_ms_s * 1e-3 * scenario.duration_s / 2.0;
    Ok((located, scenario.name.clone(), [bias_deg, clock_s, radar.bias_range_m], antenna))
}

fn trial(flight: &str) -> Result<(), Box<dyn Error>> {
    let Some(shared) = std::env::var_os("UTM_FUSION_SHARED_DATA") else { return Ok(()) };
    let folder = Path::new(&shared).join("drone-trial").join(flight);
    if !folder.exists() {
        return Ok(());
    }
    let mut data = AlignmentData::default().with_undulation(Some(45.9));
    Capture::open(&folder.join("capture.pcap"))?.flatten().for_each(|datagram| data.datagram(&datagram));
    let antenna = Geodetic::from_degrees(51.521_263_91, 5.858_627_34, 35.0 + 45.9);
    for radar in data.radars.values() {
        match locate(&data.plots_of(radar), &data.reports, None) {
            Ok(located) => {
                let of = score(&located, antenna, 0.0, 0.0, 0.0);
                println!(
                    "trial {flight}: {:.1} m (deviation {:.1}), {:.2}° ({:.2}), clock {:+.2} s ({:.2}), range offset {:+.1} ({:.1}), azimuth {:.2}°, range {:.1} m, runner-up {:.2}, {:.0} s in common, {} tracks; {:?}",
                    of.position_m,
                    located.position_sigma_m(),
                    of.bearing_deg,
                    located.bearing_deg.sigma,
                    located.clock_s.value,
                    located.clock_s.sigma,
                    located.range_offset_m.value,
                    located.range_offset_m.sigma,
                    located.azimuth_sigma_deg,
                    located.range_sigma_m,
                    located.evidence.runner_up,
                    located.evidence.common_s,
                    located.evidence.tracks,
                    of.squares.map(|value| (value * 10.0).round() / 10.0)
                );
            }
            Err(reason) => println!("trial {flight}: not located: {reason}"),
        }
    }
    Ok(())
}

/// How soon a radar that is moved or turned in flight is noticed.
fn moved(args: &Args) -> Result<(), Box<dyn Error>> {
    let fate = moved::Fate { moved_m: args.moved.unwrap_or(0.0), turned_deg: args.turned.unwrap_or(0.0) };
    let (mut after, mut errors, mut squares, mut false_alerts, mut minutes) =
        (Vec::new(), Vec::new(), Vec::new(), 0, 0.0);
    for seed in args.first..args.first + args.count {
        let (name, noticed) = match moved::notice(seed, args.minutes, fate) {
            Ok(noticed) => noticed,
            Err(error) => {
                println!("{seed}: no flight: {error}");
                continue;
            }
        };
        if args.each {
            println!(
                "{seed} {name}: noticed after {:.1?} drone-minutes, false {}, {:.1?}",
                noticed.after, noticed.false_alert, noticed.error
            );
        }
        after.push(noticed.after.unwrap_or(f64::INFINITY));
        let (square, error_m) = noticed.error.unzip();
        errors.extend(error_m);
        squares.extend(square);
        false_alerts += u32::from(noticed.false_alert);
        minutes += noticed.minutes;
    }
    let missed = after.iter().filter(|minutes| minutes.is_infinite()).count();
    println!(
        "{} sites, {minutes:.0} drone-minutes: noticed after {:.1} drone-minutes (median), {missed} not at all; {false_alerts} false; error at \
         the end {:.1} m (median), NEES {:.2}",
        after.len(),
        median(after.clone()),
        median(errors),
        mean(squares.into_iter()),
    );
    Ok(())
}

/// How well two radars align each other by drones without transponders.
fn mutual(args: &Args) -> Result<(), Box<dyn Error>> {
    let mut sites = Vec::new();
    for seed in args.first..args.first + args.count {
        let Some(aligned) = mutual::align(seed, args.minutes)? else {
            println!("{seed}: no aircraft in common");
            continue;
        };
        if args.each {
            println!(
                "{seed}: {:.1} min, bearings {:.2?}°, mutual {:.2}°, squares {:.1?}",
                aligned.minutes, aligned.bearings_deg, aligned.mutual_deg, aligned.squares
            );
        }
        sites.push(aligned);
    }
    let squares = |value: usize| mean(sites.iter().flat_map(|site| site.squares.map(|of| of[value])));
    println!(
        "{} sites, {:.1} min (median): bearing {:.2}° (median), difference of the bearings {:.2}°; NEES bearing {:.2}, range {:.2}; beyond \
         four deviations {}",
        sites.len(),
        median(sites.iter().map(|site| site.minutes).collect()),
        median(sites.iter().flat_map(|site| site.bearings_deg).collect()),
        median(sites.iter().map(|site| site.mutual_deg).collect()),
        squares(0),
        squares(1),
        sites.iter().filter(|site| site.squares.iter().any(|of| of[0] > 16.0)).count(),
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    if args.mutual {
        return mutual(&args);
    }
    if args.moved.is_some() || args.turned.is_some() {
        return moved(&args);
    }
    for flight in ["1_1", "1_4", "2_1"] {
        trial(flight)?;
    }
    let mut scores = Vec::new();
    let mut refused = 0;
    let mut wrong = 0;
    for seed in args.first..args.first + args.count {
        let (located, name, [bias_deg, clock_s, offset_m], antenna) = simulated(seed, args.minutes)?;
        match located {
            Ok(located) => {
                let of = score(&located, antenna, bias_deg, clock_s, offset_m);
                // Position: the square of both values beyond four deviations of one.
                let is_wrong = of.squares[0] * 2.0 > 19.3 || of.squares[1] > 16.0;
                wrong += u32::from(is_wrong);
                if args.each {
                    println!(
                        "{seed} {name}: {:.1} m ({:.1}), {:.2}° ({:.2}), clock {:.2} s ({:.2}), az {:.2}° range {:.1} m, runner-up {:.2}, common {:.0} s, {} tracks, {} transponders; {:?}{}",
                        of.position_m,
                        located.position_sigma_m(),
                        of.bearing_deg,
                        located.bearing_deg.sigma,
                        of.clock_s,
                        located.clock_s.sigma,
                        located.azimuth_sigma_deg,
                        located.range_sigma_m,
                        located.evidence.runner_up,
                        located.evidence.common_s,
                        located.evidence.tracks,
                        located.evidence.transponders,
                        of.squares.map(|value| (value * 10.0).round() / 10.0),
                        if is_wrong { " WRONG" } else { "" }
                    );
                }
                scores.push(of);
            }
            Err(reason) => {
                refused += 1;
                if args.each {
                    println!("{seed} {name}: not located: {reason}");
                }
            }
        }
    }
    let medians = [
        median(scores.iter().map(|of| of.position_m).collect()),
        median(scores.iter().map(|of| of.bearing_deg).collect()),
        median(scores.iter().map(|of| of.clock_s).collect()),
    ];
    let squares: Vec<f64> = (0..5).map(|index| mean(scores.iter().map(|of| of.squares[index]))).collect();
    println!(
        "sites {}, located {}, not located {refused}, wrong but confident {wrong}\nmedian {:.1} m, {:.2}°, {:.3} s\nNEES position {:.2}, bearing {:.2}, clock {:.2}, height {:.2}, range offset {:.2}",
        args.count,
        scores.len(),
        medians[0],
        medians[1],
        medians[2],
        squares[0],
        squares[1],
        squares[2],
        squares[3],
        squares[4]
    );
    Ok(())
}
