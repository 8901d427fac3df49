//! Flights in which things fail, and what must hold all the same.

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

use crate::book::{Broken, Place};
use crate::plan::{Fault, Kind, WELL_S, draw, seconds};
use crate::service::Service;

/// Two drones with transponders, one without, birds, and a network that is never perfect.
const SCENARIO: &str = "name = \"faults\"\nduration_s = 130\n[drones]\nmultirotors = 3\nequipped = 2\n[birds]\ncount = 3\n\
                        [network]\nlost = 0.01\nreordered = 0.05\nduplicated = 0.02\n";
/// Flights that schedules share.
const FLIGHTS: u64 = 16;
/// From the end of the last fault on until the picture must be that of an undisturbed service, seconds: the window, the latency,
/// and what the clock was ahead.
const RECOVERS_S: f64 = 25.0 + 6.25 + 15.0;
/// That is looked at up to the end of the flight but this, seconds.
const END_S: f64 = 122.0;
/// An aircraft that no sensor sees may be shown so much longer or shorter, seconds: when it is known too poorly to be shown goes by
/// what was learnt of its transponder, too.
const EDGE_S: f64 = 2.0;
/// The program is told the time so often at least, seconds.
const TICK_S: f64 = 1.0;

#[derive(clap::Args)]
pub struct Args {
    /// How many.
    #[arg(long, default_value_t = 1000)]
    schedules: u64,
    /// The first seed.
    #[arg(long, default_value_t = 1)]
    from: u64,
    /// How many at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

/// What arrives at a socket.
struct Arrival {
    at_s: f64,
    line: usize,
    payload: Vec<u8>,
}

/// A flight, and who is shown when nothing fails.
struct Flight {
    config: Arc<Config>,
    start: Time,
    arrivals: Vec<Arrival>,
    undisturbed: BTreeMap<Time, BTreeMap<Identity, Place>>,
}

/// What came of schedules.
#[derive(Debug, Default)]
struct Sums {
    faults: u64,
    starts: u64,
    warm: u64,
    slots: u64,
    replayed: u64,
    compared: u64,
}

impl Flight {
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
        let arrivals = simulation.datagrams.into_iter().map(|datagram| Arrival {
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
        let service = flight.fly(&[], random, directory).map_err(|Broken(what)| what)?;
        flight.undisturbed = service.book.shown;
        Ok(flight)
    }

    /// Whether what is shown now is where it would be, and is what would be, or was just before or just after.
    fn is(&self, time: Time, shown: &BTreeMap<Identity, Place>, now: &BTreeMap<Identity, Place>) -> bool {
        let about = time + seconds(-EDGE_S)..=time + seconds(EDGE_S);
        now.keys().chain(shown.keys()).all(|who| match (now.get(who), shown.get(who)) {
            (Some(here), Some(there)) => here.agrees(there),
            (here, _) => {
                let mut about = self.undisturbed.range(about.clone());
                about.any(|(_, shown)| shown.contains_key(who) == here.is_some())
            }
        })
    }

    /// Flies it with these faults.
    fn fly(
        &self,
        faults: &[Fault],
        random: &mut ChaCha8Rng,
        directory: &std::path::Path,
    ) -> Result<Service, Broken> {
        let mut service = Service::new(self.config.clone(), directory);
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

/// What the clock of the machine shows.
struct SiteClock {
    start: Time,
    ahead_s: f64,
}

impl SiteClock {
    fn at(&self, at_s: f64) -> Time {
        self.start + seconds(at_s + self.ahead_s)
    }
}

/// A fault begins or ends.
struct Edge<'a> {
    at_s: f64,
    fault: &'a Fault,
    begins: bool,
}

/// All of them, in order.
fn edges(faults: &[Fault]) -> Vec<Edge<'_>> {
    let begin = faults.iter().map(|fault| Edge { at_s: fault.from_s, fault, begins: true });
    let end = faults.iter().map(|fault| Edge { at_s: fault.until_s, fault, begins: false });
    let mut edges: Vec<_> = begin.chain(end).collect();
    edges.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    edges
}

impl Edge<'_> {
    fn happen(
        &self,
        service: &mut Service,
        clock: &mut SiteClock,
        faults: &[Fault],
        random: &mut ChaCha8Rng,
    ) -> Result<(), Broken> {
        match self.fault.kind {
            Kind::Clock(by_s) => {
                let by_s = if self.begins { by_s } else { -by_s };
                if by_s < 0.0 {
                    service.book.set_back(clock.at(self.at_s));
                }
                clock.ahead_s += by_s;
            }
            Kind::Disk => service.disk(!self.begins),
            Kind::Stop if self.begins => service.stop(clock.at(self.at_s))?,
            Kind::Kill { damaged } if self.begins => service.kill(damaged.then_some(random))?,
            Kind::Stop | Kind::Kill { .. } => {
                // Another fault may keep it down.
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

/// When the program runs again that is to do something at that time.
fn awake(faults: &[Fault], at_s: f64) -> f64 {
    let pauses = || faults.iter().filter(|fault| fault.kind == Kind::Pause);
    let mut at_s = at_s;
    // One pause may follow another.
    while let Some(pause) = pauses().find(|pause| pause.holds(at_s)) {
        at_s = pause.until_s;
    }
    at_s
}

/// What arrives of these.
fn disturbed(arrivals: &[Arrival], faults: &[Fault], random: &mut ChaCha8Rng) -> Vec<Arrival> {
    let mut arrived = Vec::new();
    for arrival in arrivals {
        let Arrival { mut at_s, line, ref payload } = *arrival;
        let mut payload = payload.clone();
        let (mut is_lost, mut copies) = (false, 1);
        for fault in faults.iter().filter(|fault| fault.holds(arrival.at_s)) {
            match fault.kind {
                Kind::Lost(share) => is_lost |= random.random_bool(share),
                Kind::Late(by_s) => at_s += random.random_range(0.0..by_s),
                Kind::Twice => copies = 2,
                Kind::Torn(share) if random.random_bool(share) && !payload.is_empty() => {
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
            arrived.extend((0..copies).map(|_| Arrival { at_s, line, payload: payload.clone() }));
        }
    }
    for fault in faults {
        let Kind::Noise(a_second) = fault.kind else { continue };
        let count = (a_second * (fault.until_s - fault.from_s)) as usize;
        arrived.extend((0..count).map(|_| Arrival {
            at_s: random.random_range(fault.from_s..fault.until_s),
            line: random.random_range(0..2),
            payload: (0..random.random_range(0..200)).map(|_| random.random_range(0..=255)).collect(),
        }));
    }
    // While it stands still its sockets keep what comes.
    arrived.iter_mut().for_each(|arrival| arrival.at_s = awake(faults, arrival.at_s));
    arrived.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    arrived
}

/// A schedule, whole.
fn schedule(seed: u64, flights: &[Flight], directory: &std::path::Path) -> Result<Sums, Broken> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let flight = &flights[(seed % flights.len() as u64) as usize];
    let faults = draw(&mut random);
    let service = flight.fly(&faults, &mut random, directory)?;
    let [from, until] = [WELL_S + RECOVERS_S, END_S].map(|at_s| flight.start + seconds(at_s) - seconds(6.25));
    let slots: Vec<_> = flight.undisturbed.range(from..until).collect();
    let now = |time| service.book.shown.get(time);
    let mut others =
        slots.iter().filter(|(time, shown)| !now(time).is_some_and(|now| flight.is(**time, shown, now)));
    if let Some((time, shown)) = others.next() {
        let (now, more) = (now(*time), others.count());
        return Err(Broken(format!(
            "slot {time} shows {now:?}, and would show {shown:?}; {more} later ones are others"
        )));
    }
    let compared = slots.len() as u64;
    if compared == 0 {
        return Err(Broken("nothing was compared".to_owned()));
    }
    Ok(Sums {
        faults: faults.len() as u64,
        starts: service.starts.0,
        warm: service.starts.1,
        slots: service.book.slots,
        replayed: service.replayed,
        compared,
    })
}

/// Flies all of them; whether everything held.
pub fn fly(args: &Args) -> Result<bool, Box<dyn Error + Send + Sync>> {
    let began = Instant::now();
    let directory = std::env::temp_dir().join(format!("utm-fusion-endurance-{}", std::process::id()));
    let profiles = [Profile::Operational, Profile::Reference];
    let flights =
        (0..FLIGHTS).map(|seed| Flight::new(seed, profiles[usize::from(seed % 8 == 7)], &directory));
    let flights = flights.collect::<Result<Vec<_>, _>>()?;
    let next = AtomicU64::new(args.from);
    let end = args.from + args.schedules;
    let (sums, failed) = (Mutex::new(Sums::default()), AtomicU64::new(0));
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
                        Err(Broken(what)) => {
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
