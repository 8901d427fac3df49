//! Flights with faults, and the conditions that must hold despite them.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use fusion::Identity;
use fusion::time::Time;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion::config::{Config, Profile};
use utm_fusion::simulate::{Scenario, simulate};

use crate::picture_log::{PublishedPosition, Violation};
use crate::plan::{FaultKind, PlannedFault, WELL_S, draw, seconds};
use crate::service::CheckedService;

/// Two drones with transponders, one without, birds, and an imperfect network.
const SCENARIO: &str = "name = \"faults\"\nduration_s = 130\n[drones]\nmultirotors = 3\nequipped = 2\n[birds]\ncount = 3\n\
                        [network]\nlost = 0.01\nreordered = 0.05\nduplicated = 0.02\n";
/// Number of different flights, which the schedules share.
const FLIGHTS: u64 = 16;
/// Time from the end of the last fault until the picture must equal that of an undisturbed service, seconds: the
/// window, the latency, and the largest clock error.
const RECOVERS_S: f64 = 25.0 + 6.25 + 15.0;
/// Pictures after this time of the flight are not compared, seconds.
const END_S: f64 = 122.0;
/// Tolerance for the times at which an aircraft without reports appears and disappears, seconds. These times also
/// depend on what was learnt of its transponder.
const EDGE_S: f64 = 2.0;
/// Maximum time between two ticks of the program, seconds.
const TICK_S: f64 = 1.0;

#[derive(clap::Args)]
pub struct Args {
    /// Number of schedules.
    #[arg(long, default_value_t = 1000)]
    schedules: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    from: u64,
    /// Number of schedules flown at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

/// A datagram that arrives at a socket.
struct ArrivedDatagram {
    at_s: f64,
    line: usize,
    payload: Vec<u8>,
}

/// A flight, and its pictures without faults.
struct FaultlessFlight {
    config: Arc<Config>,
    start: Time,
    arrivals: Vec<ArrivedDatagram>,
    undisturbed: BTreeMap<Time, BTreeMap<Identity, PublishedPosition>>,
}

/// Totals over schedules.
#[derive(Debug, Default)]
struct ScheduleTotals {
    faults: u64,
    starts: u64,
    warm: u64,
    slots: u64,
    replayed: u64,
    compared: u64,
}

impl FaultlessFlight {
    fn new(
        seed: u64,
        profile: Profile,
        directory: &std::path::Path,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let scenario = Scenario::parse(SCENARIO, "faults.toml").map_err(|error| error.to_string())?;
        let simulation = simulate(&scenario, seed, None)?;
        let mut config = simulation.config;
        config.fusion.profile = profile;
        config.state.checkpoint_s = 5.0;
        let start = scenario.start_time();
        let radar = config.sensors[0].inputs[0].port;
        let arrivals = simulation.datagrams.into_iter().map(|datagram| ArrivedDatagram {
            at_s: (datagram.received - start).as_secs_f64(),
            line: usize::from(datagram.flow.port != radar),
            payload: datagram.payload,
        });
        let mut flight = Self {
            config: Arc::new(config),
            start,
            arrivals: arrivals.collect(),
            undisturbed: BTreeMap::new(),
        };
        let random = &mut ChaCha8Rng::seed_from_u64(0);
        let service = flight.fly(&[], random, directory).map_err(|Violation(what)| what)?;
        flight.undisturbed = service.picture_log.shown;
        Ok(flight)
    }

    /// Whether the picture `now` agrees with the undisturbed picture `shown`: the same positions, and the same
    /// aircraft, within [`EDGE_S`].
    fn is(
        &self,
        time: Time,
        shown: &BTreeMap<Identity, PublishedPosition>,
        now: &BTreeMap<Identity, PublishedPosition>,
    ) -> bool {
        let about = time + seconds(-EDGE_S)..=time + seconds(EDGE_S);
        now.keys().chain(shown.keys()).all(|who| match (now.get(who), shown.get(who)) {
            (Some(here), Some(there)) => here.agrees(there),
            (here, _) => {
                let mut about = self.undisturbed.range(about.clone());
                about.any(|(_, shown)| shown.contains_key(who) == here.is_some())
            }
        })
    }

    /// Flies the flight with these faults.
    fn fly(
        &self,
        faults: &[PlannedFault],
        random: &mut ChaCha8Rng,
        directory: &std::path::Path,
    ) -> Result<CheckedService, Violation> {
        let mut service = CheckedService::new(self.config.clone(), directory);
        let mut arrivals = disturbed(&self.arrivals, faults, random).into_iter().peekable();
        let mut edges = edges(faults).into_iter().peekable();
        let mut clock = SiteClock { start: self.start, ahead_s: 0.0 };
        let (mut now_s, mut told_s) = (0.0, 0.0);
        service.start(clock.at(0.0));
        loop {
            let edge_s = edges.peek().map_or(f64::MAX, |edge| edge.at_s);
            let arrival_s = arrivals.peek().map_or(f64::MAX, |arrival| arrival.at_s);
            let due_s = service.next_made().map_or(f64::MAX, |made| {
                (made - clock.at(0.0)).as_secs_f64() + random.random_range(0.0..0.004)
            });
            let tick_s = awake(faults, due_s.min(told_s + TICK_S).max(now_s));
            if edge_s <= arrival_s && edge_s <= tick_s {
                let Some(edge) = edges.next() else { break };
                now_s = edge.at_s;
                edge.happen(&mut service, &mut clock, faults, random)?;
            } else if arrival_s <= tick_s {
                let Some(arrival) = arrivals.next() else { break };
                now_s = now_s.max(arrival.at_s);
                service.receive(arrival.line, clock.at(arrival.at_s), &arrival.payload)?;
            } else if edge_s.min(arrival_s) < f64::MAX {
                now_s = tick_s;
                told_s = now_s;
                service.tick(clock.at(now_s))?;
            } else {
                break;
            }
        }
        service.stop(clock.at(now_s))?;
        Ok(service)
    }
}

/// Clock of the machine.
struct SiteClock {
    start: Time,
    ahead_s: f64,
}

impl SiteClock {
    fn at(&self, at_s: f64) -> Time {
        self.start + seconds(at_s + self.ahead_s)
    }
}

/// Beginning or end of a fault.
struct FaultEdge<'a> {
    at_s: f64,
    fault: &'a PlannedFault,
    begins: bool,
}

/// All beginnings and ends, in order.
fn edges(faults: &[PlannedFault]) -> Vec<FaultEdge<'_>> {
    let begin = faults.iter().map(|fault| FaultEdge { at_s: fault.from_s, fault, begins: true });
    let end = faults.iter().map(|fault| FaultEdge { at_s: fault.until_s, fault, begins: false });
    let mut edges: Vec<_> = begin.chain(end).collect();
    edges.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    edges
}

impl FaultEdge<'_> {
    fn happen(
        &self,
        service: &mut CheckedService,
        clock: &mut SiteClock,
        faults: &[PlannedFault],
        random: &mut ChaCha8Rng,
    ) -> Result<(), Violation> {
        match self.fault.kind {
            FaultKind::Clock(by_s) => {
                let by_s = if self.begins { by_s } else { -by_s };
                if by_s < 0.0 {
                    service.picture_log.set_back(clock.at(self.at_s));
                }
                clock.ahead_s += by_s;
            }
            FaultKind::Disk => service.disk(!self.begins),
            FaultKind::Stop if self.begins => service.stop(clock.at(self.at_s))?,
            FaultKind::Kill { damaged } if self.begins => service.kill(damaged.then_some(random))?,
            FaultKind::Stop | FaultKind::Kill { .. } => {
                // Another fault may keep the program down.
                let is_down = faults.iter().any(|fault| fault.is_down() && fault.holds(self.at_s));
                if !is_down && !service.runs() {
                    service.start(clock.at(self.at_s));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// First time from `at_s` on at which no pause is active.
fn awake(faults: &[PlannedFault], at_s: f64) -> f64 {
    let pauses = || faults.iter().filter(|fault| fault.kind == FaultKind::Pause);
    let mut at_s = at_s;
    // One pause may follow another.
    while let Some(pause) = pauses().find(|pause| pause.holds(at_s)) {
        at_s = pause.until_s;
    }
    at_s
}

/// Applies the faults to the arriving datagrams.
fn disturbed(
    arrivals: &[ArrivedDatagram],
    faults: &[PlannedFault],
    random: &mut ChaCha8Rng,
) -> Vec<ArrivedDatagram> {
    let mut arrived = Vec::new();
    for arrival in arrivals {
        let ArrivedDatagram { mut at_s, line, ref payload } = *arrival;
        let mut payload = payload.clone();
        let (mut is_lost, mut copies) = (false, 1);
        for fault in faults.iter().filter(|fault| fault.holds(arrival.at_s)) {
            match fault.kind {
                FaultKind::Lost(share) => is_lost |= random.random_bool(share),
                FaultKind::Late(by_s) => at_s += random.random_range(0.0..by_s),
                FaultKind::Twice => copies = 2,
                FaultKind::Torn(share) if random.random_bool(share) && !payload.is_empty() => {
                    let place = random.random_range(0..payload.len());
                    if random.random_bool(0.5) {
                        payload.truncate(place);
                    } else {
                        payload[place] = random.random_range(0..=255);
                    }
                }
                _ => {}
            }
        }
        if !is_lost {
            arrived.extend((0..copies).map(|_| ArrivedDatagram { at_s, line, payload: payload.clone() }));
        }
    }
    for fault in faults {
        let FaultKind::Noise(a_second) = fault.kind else { continue };
        let count = (a_second * (fault.until_s - fault.from_s)) as usize;
        arrived.extend((0..count).map(|_| ArrivedDatagram {
            at_s: random.random_range(fault.from_s..fault.until_s),
            line: random.random_range(0..2),
            payload: (0..random.random_range(0..200)).map(|_| random.random_range(0..=255)).collect(),
        }));
    }
    // During a pause, the sockets keep what arrives.
    arrived.iter_mut().for_each(|arrival| arrival.at_s = awake(faults, arrival.at_s));
    arrived.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    arrived
}

/// Flies the schedule of one seed.
fn schedule(
    seed: u64,
    flights: &[FaultlessFlight],
    directory: &std::path::Path,
) -> Result<ScheduleTotals, Violation> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let flight = &flights[(seed % flights.len() as u64) as usize];
    let faults = draw(&mut random);
    let service = flight.fly(&faults, &mut random, directory)?;
    let [from, until] = [WELL_S + RECOVERS_S, END_S].map(|at_s| flight.start + seconds(at_s) - seconds(6.25));
    let slots: Vec<_> = flight.undisturbed.range(from..until).collect();
    let now = |time| service.picture_log.shown.get(time);
    let mut others =
        slots.iter().filter(|(time, shown)| !now(time).is_some_and(|now| flight.is(**time, shown, now)));
    if let Some((time, shown)) = others.next() {
        let (now, more) = (now(*time), others.count());
        return Err(Violation(format!(
            "slot {time} shows {now:?}, and would show {shown:?}; {more} later ones are others"
        )));
    }
    let compared = slots.len() as u64;
    if compared == 0 {
        return Err(Violation("nothing was compared".to_owned()));
    }
    Ok(ScheduleTotals {
        faults: faults.len() as u64,
        starts: service.starts.0,
        warm: service.starts.1,
        slots: service.picture_log.slots,
        replayed: service.replayed,
        compared,
    })
}

/// Flies all schedules. Returns whether all conditions held.
pub fn fly(args: &Args) -> Result<bool, Box<dyn Error + Send + Sync>> {
    let began = Instant::now();
    let directory = std::env::temp_dir().join(format!("utm-fusion-endurance-{}", std::process::id()));
    let profiles = [Profile::Operational, Profile::Reference];
    let flights =
        (0..FLIGHTS).map(|seed| FaultlessFlight::new(seed, profiles[usize::from(seed % 8 == 7)], &directory));
    let flights = flights.collect::<Result<Vec<_>, _>>()?;
    let next = AtomicU64::new(args.from);
    let end = args.from + args.schedules;
    let (sums, failed) = (Mutex::new(ScheduleTotals::default()), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for thread in 0..args.threads {
            let directory: PathBuf = directory.join(thread.to_string());
            let (next, sums, failed, flights) = (&next, &sums, &failed, &flights);
            scope.spawn(move || {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= end {
                        break;
                    }
                    match schedule(seed, flights, &directory) {
                        Ok(of) => {
                            let Ok(mut sums) = sums.lock() else { break };
                            sums.faults += of.faults;
                            sums.starts += of.starts;
                            sums.warm += of.warm;
                            sums.slots += of.slots;
                            sums.replayed += of.replayed;
                            sums.compared += of.compared;
                        }
                        Err(Violation(what)) => {
                            failed.fetch_add(1, Ordering::Relaxed);
                            println!("seed {seed}: {what}");
                            for fault in draw(&mut ChaCha8Rng::seed_from_u64(seed)) {
                                println!("    {fault}");
                            }
                        }
                    }
                }
            });
        }
    });
    let _ = std::fs::remove_dir_all(&directory);
    let failed = failed.into_inner();
    println!(
        "{} schedules, {failed} failed: {:?}, {:.0} s",
        args.schedules,
        sums.into_inner()?,
        began.elapsed().as_secs_f64()
    );
    Ok(failed == 0)
}
