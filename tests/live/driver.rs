//! A driver with a virtual clock, and the replay of its recording.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;

use asterix::cat048::{self, TrackNumber};
use asterix::{blocks, encode_block};
use fusion::integrity::{Concern, Trust, TrustOverride};
use fusion::numbering::{Given, LARGEST_TRANSPONDER_NUMBER, NumberChange};
use fusion::operational::{ActiveAssociation, ManualAssociation, RadarRelocation, Relocation, Verdict};
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use fusion::{Identity, SensorIndex, Source};
use jiff::SignedDuration;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Profile, Record};
use utm_fusion::formats::{Cat129Encoder, pack};
use utm_fusion::live::{Driver, DriverEvent};
use utm_fusion::pipeline::Event;
use utm_fusion::record::{RecordedContents, Recorder, RecorderQueue, RecordingItem};
use utm_fusion::simulate::SimulatedDatagram;
use utm_fusion::state::{
    SavedRegistrations, correlation_line, registration_text, relocation_line, word_line,
};

use crate::common::{
    Scratch, complete_from, datagrams, files, flight, only, replayed, replayed_datagrams, replayed_now,
};

/// Two drones with transponders, one without, and birds.
pub(crate) const SCENARIO: &str = "name = \"live\"\nduration_s = 60\n[drones]\nmultirotors = 3\nequipped = 2\n\
                        [birds]\ncount = 3\n[network]\nlost = 0.02\nreordered = 0.1\nduplicated = 0.05\n";

/// Disturbances of the flight on its way to the driver.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fate {
    pub(crate) seed: u64,
    /// Maximum time for which some of the datagrams wait in the queue, in milliseconds.
    pub(crate) queue_ms: i64,
    /// Maximum delay of ticks after they are due, in milliseconds.
    pub(crate) tick_ms: i64,
    /// Time of the flight at which reception stops, and its duration, in seconds.
    pub(crate) silence_s: Option<(i64, i64)>,
    /// Time of the flight at which the wall clock steps, and the size of the step, in seconds.
    pub(crate) step_s: Option<(i64, i64)>,
    /// Time of the flight at which the clock steps back, in seconds.
    pub(crate) undone_s: Option<i64>,
    /// Time of the flight at which the service pauses, and the duration, in seconds.
    pub(crate) pause_s: Option<(i64, i64)>,
    /// Numbers from an earlier run.
    pub(crate) numbers: Vec<Given>,
    /// Registration from an earlier run.
    pub(crate) registrations: SavedRegistrations,
    /// Times of the flight at which an operator decides on a correlation, in seconds.
    pub(crate) decide_s: Vec<i64>,
    /// Times of the flight at which an operator sets the trust in a transponder, in seconds.
    pub(crate) say_s: Vec<i64>,
    /// Whether an operator moves the radar to where its tracks show it, once they do, and revokes that at this time, in seconds.
    pub(crate) relocate_until_s: Option<i64>,
    /// Number of datagrams between two checkpoints; 0: no checkpoints.
    pub(crate) checkpoint_every: usize,
}

fn seconds(seconds: i64) -> SignedDuration {
    SignedDuration::from_secs(seconds)
}

/// Sender of all datagrams.
const FROM: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 40_000);

/// A datagram as the engine's thread passes it on.
fn reception(line: usize, received: Time, payload: Vec<u8>) -> Reception {
    Reception {
        received: Some(received),
        input: line,
        from: Some(FROM.into()),
        kind: ReceptionKind::Datagram,
        origin: 0,
        payload,
    }
}

/// Result of a flight whose arrivals and ticks come in the order of the service's engine thread.
pub(crate) struct Flown {
    slots: u64,
    alarms: u64,
    /// Number of slots with the alert `jamming`.
    jammed: u64,
    /// For each point with a radar part: its time, whether it is fused, and the radar's track number.
    radar: Vec<(Time, bool, u16)>,
    /// Registration of the radars at the end.
    pub(crate) registrations: SavedRegistrations,
    /// Number of decisions on correlations.
    pub(crate) correlations: usize,
    /// Number of trust settings.
    pub(crate) words: usize,
    /// Slots from which the radar was relocated, with the relocation.
    pub(crate) relocations: Vec<(Slot, Option<Relocation>)>,
    /// Datagrams of the present pictures, each with its deadline.
    now: Vec<(Time, Vec<u8>)>,
}

pub(crate) fn fly(
    config: &Config,
    arrivals: &[SimulatedDatagram],
    fate: &Fate,
    recorder: &RecorderQueue,
) -> Flown {
    let mut random = ChaCha8Rng::seed_from_u64(fate.seed);
    let encoder = Cat129Encoder::of(config);
    let start = arrivals[0].received;
    let mut driver = Driver::new(config, Masks::default(), start, 2);
    assert_eq!(driver.remember(&mut fate.numbers.clone()), 0);
    let unused = fate.registrations.restore(config, Some(start), driver.engine_mut());
    assert!(unused.is_empty(), "{unused:?}");
    let text = registration_text(&fate.registrations).into();
    assert!(recorder.add(RecordingItem::Registered(text)));
    let registrations = SavedRegistrations::default();
    let mut flown = Flown {
        slots: 0,
        alarms: 0,
        jammed: 0,
        radar: Vec::new(),
        registrations,
        correlations: 0,
        words: 0,
        relocations: Vec::new(),
        now: Vec::new(),
    };
    let shown = RefCell::new(Vec::new());
    let mut held = Vec::new();
    let mut hand_out = |driver: &mut Driver| {
        while let Some(made) = driver.poll() {
            match made {
                DriverEvent::Slot(frame) => {
                    flown.slots += 1;
                    let is_jamming = |concern: &Concern| matches!(concern, Concern::Jamming { .. });
                    flown.jammed += u64::from(frame.picture.concerns.iter().any(is_jamming));
                    shown.replace(
                        frame.picture.tracks.iter().map(|track| track.point.source.clone()).collect(),
                    );
                    for track in &frame.picture.tracks {
                        let source = &track.point.source;
                        if let Some(part) = source.radar() {
                            let is_fused = source.transponder().is_some();
                            flown.radar.push((frame.picture.time, is_fused, part.track.number));
                        }
                    }
                    if let Some(now) = frame.now.get() {
                        let payloads = pack(now.within(config.output.max_accuracy_m), &encoder);
                        flown.now.extend(payloads.into_iter().map(|payload| (frame.due, payload)));
                    }
                    for payload in pack(frame.picture.within(config.output.max_accuracy_m), &encoder) {
                        assert!(recorder.add(RecordingItem::Output { due: frame.due, payload }));
                    }
                }
                DriverEvent::Number(NumberChange::Heard(given)) => {
                    assert!(recorder.add(RecordingItem::Numbered(given)));
                }
                DriverEvent::Number(NumberChange::Returned(_)) => {}
                DriverEvent::Event(event) => flown.alarms += u64::from(event.is_warning()),
            }
        }
        let now = driver.pipeline().engine().correlations();
        if now != held {
            let line = |held: &ActiveAssociation| correlation_line(held.since, &held.correlation, config);
            let text = now.iter().map(line).collect::<String>().into();
            assert!(recorder.add(RecordingItem::Correlations(text)));
            held = now;
        }
    };
    let mut wishes = fate.decide_s.iter().enumerate().peekable();
    let mut correlations = 0;
    let mut sayings = fate.say_s.iter().enumerate().peekable();
    let mut words = 0;
    let mut relocations = Vec::new();
    // The wall clock at a steady time.
    let wall = |steady: Time| match fate.step_s {
        Some((at, by))
            if steady >= start + seconds(at)
                && fate.undone_s.is_none_or(|undone| steady < start + seconds(undone)) =>
        {
            steady + seconds(by)
        }
        _ => steady,
    };
    let within = |span: Option<(i64, i64)>, steady: Time| {
        span.and_then(|(at, length)| {
            let (from, to) = (start + seconds(at), start + seconds(at + length));
            (from <= steady && steady < to).then_some(to)
        })
    };
    let heard = arrivals.iter().filter(|datagram| within(fate.silence_s, datagram.received).is_none());
    // Time at which each datagram is read from its socket, and at which the engine takes it; the queue keeps the order.
    let mut taken = start;
    let mut steady = start;
    for (index, datagram) in heard.enumerate() {
        let waits = if random.random_bool(0.3) { random.random_range(0..=fate.queue_ms) } else { 0 };
        taken = taken.max(datagram.received + SignedDuration::from_millis(waits));
        taken = within(fate.pause_s, taken).unwrap_or(taken);
        // Ticks until then, each when it is due or some time later.
        while let Some(deadline) = driver.next_made() {
            let late = SignedDuration::from_micros(random.random_range(0..=fate.tick_ms * 1000));
            let early = deadline - wall(steady);
            let at = steady + early.max(SignedDuration::ZERO) + late;
            let at = within(fate.pause_s, at).unwrap_or(at);
            if at >= taken {
                break;
            }
            steady = at;
            driver.tick(wall(at));
            hand_out(&mut driver);
            // If a step of the clock has moved a deadline away, further ticks do not reach it.
            if early < SignedDuration::ZERO && driver.next_made() == Some(deadline) {
                break;
            }
        }
        steady = steady.max(taken);
        while let Some((index, _)) = wishes.next_if(|(_, at)| steady >= start + seconds(**at)) {
            let correlation = wish(index, &shown.borrow(), &driver.pipeline().engine().correlations());
            if let Some(correlation) = correlation
                && let Ok(slot) = driver.correlate(correlation)
            {
                let line = correlation_line(slot, &correlation, config).into();
                assert!(recorder.add(RecordingItem::Decided(line)));
                correlations += 1;
            }
        }
        while let Some((index, _)) = sayings.next_if(|(_, at)| steady >= start + seconds(**at)) {
            // First distrusts two transponders, then resets the first one.
            let trust = if index < 2 { Trust::Distrusted } else { Trust::Automatic };
            let identity = driver.pipeline().engine().transponders().nth(index % 2).unwrap();
            let word = TrustOverride { identity, trust };
            let slot = driver.set_trust(word).unwrap();
            assert!(recorder.add(RecordingItem::Decided(word_line(slot, &word, config).into())));
            words += 1;
        }
        if let Some(until_s) = fate.relocate_until_s
            && let Some(to) = relocation(&driver, steady >= start + seconds(until_s))
        {
            let decided = RadarRelocation { radar: SensorIndex(0), to };
            let slot = driver.relocate(decided).unwrap();
            assert!(recorder.add(RecordingItem::Decided(relocation_line(slot, &decided, config).into())));
            relocations.push((slot, to));
        }
        if random.random_bool(0.1) {
            driver.tick(wall(steady));
            hand_out(&mut driver);
        }
        let from = FROM;
        let line = usize::from(datagram.flow.port != 8048);
        let received = driver.reception(wall(datagram.received), wall(steady));
        let payload = datagram.payload.clone();
        if fate.checkpoint_every > 0 && index % fate.checkpoint_every == 0 {
            assert!(recorder.add(RecordingItem::Checkpoint(driver.checkpoint(config))));
        }
        assert!(recorder.add(RecordingItem::Input { received, line, from, payload: payload.clone() }));
        driver.receive(&reception(line, received, payload));
        hand_out(&mut driver);
    }
    driver.finish();
    hand_out(&mut driver);
    (flown.correlations, flown.words, flown.relocations) = (correlations, words, relocations);
    flown.registrations = SavedRegistrations::of(config, driver.pipeline().engine());
    flown
}

/// Decision on the position of the first radar, if there is one to take: to apply what its tracks show or, later, to revoke it.
fn relocation(driver: &Driver, is_over: bool) -> Option<Option<Relocation>> {
    let engine = driver.pipeline().engine();
    let active = engine.relocations().first().map(|active| active.to);
    if is_over {
        return active.map(|_| None);
    }
    let (_, registered) = engine.registered().find(|(sensor, _)| *sensor == SensorIndex(0))?;
    let found = registered.place().filter(|found| found.contradicts)?;
    active.is_none().then(|| Some(Relocation::default().beyond(found)))
}

/// Decisions of an operator who sees these tracks: first separates a pair, then joins one, then returns to automatic.
fn wish(index: usize, shown: &[Source], held: &[ActiveAssociation]) -> Option<ManualAssociation> {
    let transponder = |source: &Source| source.transponder().map(|part| part.identity);
    let fused = shown.iter().find(|source| matches!(source, Source::Fused(..)));
    match index % 3 {
        0 => fused.map(|pair| (pair, transponder(pair), Verdict::Decorrelated)),
        1 => {
            let alone = shown.iter().find(|source| matches!(source, Source::Radar(_)));
            alone
                .or(fused)
                .map(|radar| (radar, shown.iter().rev().find_map(transponder), Verdict::Correlated))
        }
        _ => {
            let ActiveAssociation { correlation, .. } = held.first()?;
            return Some(ManualAssociation { verdict: Verdict::Automatic, ..*correlation });
        }
    }
    .and_then(|(source, transponder, verdict)| {
        Some(ManualAssociation { radar: source.radar()?.track, transponder: transponder?, verdict })
    })
}

/// Simulates the flight, and records it into `directory`.
pub(crate) fn record(
    scenario: &str,
    start: Option<Time>,
    fate: &Fate,
    directory: &Path,
    rotate_mib: u32,
) -> Flown {
    let profile = Profile::Operational;
    record_as(profile, scenario, start, fate, directory, rotate_mib)
}

fn record_as(
    profile: Profile,
    scenario: &str,
    start: Option<Time>,
    fate: &Fate,
    directory: &Path,
    rotate_mib: u32,
) -> Flown {
    let mut simulation = flight(scenario, fate.seed, start);
    simulation.config.fusion.profile = profile;
    let record = Record { dir: directory.to_owned(), rotate_mib, keep: 1000, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&simulation.config, &record, fate.numbers.clone(), RecordedContents::Service)
            .unwrap();
    let flown = fly(&simulation.config, &simulation.datagrams, fate, &queue);
    drop(queue);
    assert_eq!(recorder.join().unwritten, 0);
    flown
}

fn recorded_equals_replayed(scenario: &str, start: Option<Time>, fate: &Fate) -> Flown {
    let scratch = Scratch::new();
    let directory = scratch.path("recordings");
    let flown = record(scenario, start, fate, &directory, 256);
    // A step of the clock by an hour begins another file, which is covered by another test.
    let inputs = files(&directory, "input-", ".pcap");
    if let [input] = &inputs[..] {
        let output = fs::read(only(&directory, "output-", ".pcap")).unwrap();
        assert!(output.len() > 1000, "{fate:?}: nothing was sent");
        assert!(output == replayed(input), "{fate:?}");
        assert!(flown.now.len() > 10, "{fate:?}: nothing is shown of now");
        assert!(flown.now == replayed_now(input), "{fate:?}: of now");
    }
    flown
}

/// Half a minute before midnight.
fn before_midnight() -> Time {
    Time::midnight(jiff::civil::date(2026, 11, 21)).unwrap() + seconds(-30)
}

#[test]
fn midnight_has_no_effect_on_the_output() {
    let fly_at = |start: Time| {
        let flown = recorded_equals_replayed(SCENARIO, Some(start), &Fate { seed: 7, ..Fate::default() });
        assert_eq!(flown.alarms, 0);
        let since = |(time, is_fused, number): &(Time, bool, u16)| (*time - start, *is_fused, *number);
        (flown.slots, flown.radar.iter().map(since).collect::<Vec<_>>())
    };
    let over_midnight = before_midnight() + seconds(-10);
    let flown = fly_at(over_midnight);
    assert!(flown.1.iter().any(|(since, ..)| *since < seconds(40)), "nothing before");
    assert!(flown.1.iter().any(|(since, is_fused, _)| *since > seconds(40) && *is_fused), "nothing after");
    assert!(flown == fly_at(over_midnight + seconds(-36_000)), "the same flight in the afternoon");
}

#[test]
fn datagrams_delayed_beyond_the_window_follow_the_restart() {
    // The service pauses for 26 s, and reads the clock before it has handled all earlier data: the engine restarts,
    // although the clock was not set back.
    let decide_s = vec![27, 29];
    let (silence_s, pause_s) = (Some((17, 14)), Some((16, 26)));
    let fate = Fate { seed: 20, silence_s, pause_s, decide_s, ..Fate::default() };
    let flown = recorded_equals_replayed(SCENARIO, None, &fate);
    assert_eq!(flown.correlations, 2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn recording_replays_to_the_sent_output(
        seed in 0..1000_u64,
        queue_ms in prop::sample::select(vec![0, 5, 300, 3000]),
        tick_ms in prop::sample::select(vec![0, 1, 400, 2000]),
        silence_s in prop::option::of((10..30_i64, 5..29_i64)),
        pause_s in prop::option::of((10..30_i64, 1..29_i64)),
        midnight: bool,
        mut decide_s in prop::collection::vec(12..55_i64, 0..4),
    ) {
        decide_s.sort_unstable();
        let fate = Fate { seed, queue_ms, tick_ms, silence_s, pause_s, decide_s, ..Fate::default() };
        recorded_equals_replayed(SCENARIO, midnight.then(before_midnight), &fate);
    }

    #[test]
    fn recording_with_a_clock_step_replays_to_the_sent_output(
        seed in 0..1000_u64,
        at in 15..40_i64,
        by in prop::sample::select(vec![-1, 1, -3, 3, -20, 24, 25, 26, 3600, -3600]),
    ) {
        let fate = Fate { seed, queue_ms: 50, tick_ms: 5, step_s: Some((at, by)), ..Fate::default() };
        let flown = recorded_equals_replayed(SCENARIO, None, &fate);
        if by > 25 {
            prop_assert!(flown.alarms >= 1, "nobody heard of it");
        }
        prop_assert!(flown.slots < 1000, "{} slots: an hour was published", flown.slots);
    }
}

/// Eight drones with transponders.
const FLEET: &str = "name = \"fleet\"\nduration_s = 130\n[drones]\nmultirotors = 8\nequipped = 8\n";

#[test]
fn step_of_the_clock_raises_no_jamming() {
    for by in [-24, -6, 6, 20, 24, 26, 40, 3600] {
        let fate = Fate { seed: 3, queue_ms: 50, tick_ms: 5, step_s: Some((40, by)), ..Fate::default() };
        let scratch = Scratch::new();
        let flown = record(FLEET, None, &fate, &scratch.path("r"), 256);
        assert_eq!(flown.jammed, 0, "{by} s");
    }
}

#[test]
fn clock_excursion_ends_within_the_window_after_its_undoing() {
    for by in [26, 40, 3600, -40, -3600] {
        let fate = Fate {
            seed: 3,
            queue_ms: 50,
            tick_ms: 5,
            step_s: Some((40, by)),
            undone_s: Some(60),
            ..Fate::default()
        };
        let start = flight(FLEET, fate.seed, None).datagrams[0].received;
        let flown = recorded_equals_replayed(FLEET, None, &fate);
        assert_eq!(flown.jammed, 0, "{by} s");
        let fused = |from: i64, to: i64| {
            let within = |time: Time| start + seconds(from) <= time && time < start + seconds(to);
            flown.radar.iter().any(|&(time, is_fused, _)| is_fused && within(time))
        };
        assert!(fused(20, 35), "{by} s: nothing before");
        assert!(fused(80, 86), "{by} s: dark after it was undone");
    }
}

#[test]
fn each_file_alone_replays_to_the_output_from_its_mark_on() {
    each_file_alone(Profile::Reference, 0);
}

/// The memory of this profile is longer than the window, so each file has to begin with a saved state.
#[test]
fn recording_with_a_checkpoint_replays_in_operational_profile() {
    each_file_alone(Profile::Operational, 40);
}

fn each_file_alone(profile: Profile, checkpoint_every: usize) {
    let scratch = Scratch::new();
    let directory = scratch.path("recordings");
    // Radars with many plots fill a mebibyte in less than a minute.
    let scenario =
        "name = \"long\"\nduration_s = 240\n[drones]\nmultirotors = 12\nequipped = 9\n[birds]\ncount = 250\n";
    let fate = Fate { seed: 3, queue_ms: 300, tick_ms: 5, checkpoint_every, ..Fate::default() };
    record_as(profile, scenario, None, &fate, &directory, 1);
    let inputs = files(&directory, "input-", ".pcap");
    let sent: Vec<_> =
        files(&directory, "output-", ".pcap").iter().flat_map(|file| datagrams(file)).collect();
    assert!(inputs.len() >= 3, "{} files", inputs.len());
    let due_after = seconds(6) + SignedDuration::from_millis(250);
    for (index, input) in inputs.iter().enumerate() {
        let last = datagrams(input).last().unwrap().0;
        let is_last = index + 1 == inputs.len();
        // A slot due after the file's end lacks later data.
        let whole = |due: Time| due >= complete_from(input) + due_after && (is_last || due <= last);
        let pick = |from: Vec<(Time, Vec<u8>)>| -> Vec<_> {
            from.into_iter().filter(|(due, _)| whole(*due)).collect()
        };
        let (expected, replayed) = (pick(sent.clone()), pick(replayed_datagrams(input)));
        assert!(expected.len() > 20 || is_last, "{}: {} datagrams", input.display(), expected.len());
        assert!(expected == replayed, "{}", input.display());
    }
    // All files together are the whole flight.
    let all = scratch.path("all.pcap");
    let output = crate::common::utm_fusion("replay")
        .args(&inputs)
        .arg("--config")
        .arg(crate::common::beside(&inputs[0], "site.toml"))
        .arg("-o")
        .arg(&all)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(datagrams(&all) == sent);
}

/// A radar that restarts numbers its tracks again: the same flight, with other numbers from the middle on.
#[test]
fn recording_with_a_radar_restart_replays_to_the_output() {
    let simulation = flight(SCENARIO, 7, None);
    let start = simulation.datagrams[0].received;
    let restart = start + seconds(42);
    let renumbered: Vec<SimulatedDatagram> = simulation
        .datagrams
        .iter()
        .map(|datagram| {
            let mut datagram = datagram.clone();
            if datagram.received > restart {
                let payload = std::mem::take(&mut datagram.payload);
                for block in blocks(&payload).map(Result::unwrap) {
                    if block.category != 48 {
                        datagram.payload.extend_from_slice(block.octets);
                        continue;
                    }
                    let mut records: Vec<cat048::Record> =
                        block.records().map(|located| located.unwrap().record).collect();
                    for record in &mut records {
                        let number = record.track_number.unwrap().number();
                        record.track_number = TrackNumber::new((number + 1000) % 4096);
                    }
                    encode_block(&records, &mut datagram.payload).unwrap();
                }
            }
            datagram
        })
        .collect();
    assert!(renumbered != simulation.datagrams);
    let scratch = Scratch::new();
    let record = Record { dir: scratch.path("r"), rotate_mib: 256, keep: 9, keep_mib: 0, keep_hours: 0 };
    let (queue, recorder) =
        Recorder::start(&simulation.config, &record, Vec::new(), RecordedContents::Service).unwrap();
    let flown = fly(
        &simulation.config,
        &renumbered,
        &Fate { seed: 7, queue_ms: 100, tick_ms: 3, ..Fate::default() },
        &queue,
    );
    drop(queue);
    assert_eq!(recorder.join().unwritten, 0);
    let output = fs::read(only(&record.dir, "output-", ".pcap")).unwrap();
    assert!(output.len() > 1000 && output == replayed(&only(&record.dir, "input-", ".pcap")));
    // The old numbers end with the restart, except between a last plot and a first one. A new one is fused like the old
    // one.
    let of = |from: Time, to: Time| -> BTreeSet<(bool, bool)> {
        let within = flown.radar.iter().filter(|(time, ..)| from < *time && *time < to);
        within.map(|&(_, is_fused, number)| (number >= 1000, is_fused)).collect()
    };
    let (before, after) = (of(start, restart + -seconds(1)), of(restart + seconds(5), start + seconds(60)));
    assert_eq!(before, [(false, false), (false, true)].into());
    assert!(after.contains(&(true, true)) && after.iter().all(|&(is_new, _)| is_new), "{after:?}");
}

#[test]
fn own_output_received_back_is_counted_and_rejected() {
    let simulation = flight(SCENARIO, 2, None);
    let config = &simulation.config;
    let encoder = Cat129Encoder::of(config);
    let mut driver = Driver::new(config, Masks::default(), simulation.datagrams[0].received, 2);
    let (mut echoed, mut accepted) = (0, 0);
    for datagram in &simulation.datagrams {
        let received = datagram.received;
        let mut sent = Vec::new();
        driver.receive(&reception(0, received, datagram.payload.clone()));
        while let Some(made) = driver.poll() {
            if let DriverEvent::Slot(frame) = made {
                sent.extend(pack(&frame.picture.tracks, &encoder));
            }
        }
        for payload in sent {
            echoed += blocks(&payload).count() as u64;
            driver.receive(&reception(1, received, payload));
            while let Some(made) = driver.poll() {
                accepted += u64::from(matches!(made, DriverEvent::Event(Event::Accepted { .. })));
            }
        }
    }
    assert_eq!(accepted, 0);
    let unknown = driver.health().unknown();
    let [own] = &unknown[..] else { panic!("{unknown:?}") };
    assert!(own.own && own.category == 129 && own.records == echoed && echoed > 100, "{own:?}, {echoed}");
}

#[test]
fn earlier_numbers_are_reused_and_recorded() {
    let first = Scratch::new();
    let fate = Fate { seed: 5, ..Fate::default() };
    record(SCENARIO, None, &fate, &first.path("r"), 256);
    let numbers = |directory: &Path| {
        utm_fusion::state::read_numbers(&only(directory, "input-", ".numbers.json")).unwrap()
    };
    let given = numbers(&first.path("r"));
    assert_eq!(given.len(), 2, "those of the transponders in the file");

    // Both drones had other numbers in an earlier run.
    let scratch = Scratch::new();
    let before: Vec<Given> =
        given.iter().map(|given| Given { number: given.number + 70, ..*given }).collect();
    let fate = Fate { numbers: before.clone(), ..fate };
    let directory = scratch.path("r");
    record(SCENARIO, None, &fate, &directory, 256);
    let input = only(&directory, "input-", ".pcap");
    let output = fs::read(only(&directory, "output-", ".pcap")).unwrap();
    assert!(output == replayed(&input));
    let without = fs::read(only(&first.path("r"), "output-", ".pcap")).unwrap();
    assert!(output != without, "the numbers of before were not used");
    let recorded: BTreeSet<_> =
        numbers(&directory).iter().map(|given| (given.number, given.identity)).collect();
    assert_eq!(recorded, before.iter().map(|given| (given.number, given.identity)).collect());
}

/// All 429,496 numbers are assigned: transponders in flight still get theirs, and the recording replays to the data sent.
#[test]
fn exhausted_numbers_leave_no_transponder_out() {
    let start = flight(SCENARIO, 5, None).datagrams[0].received;
    let numbers: Vec<Given> = (1..=LARGEST_TRANSPONDER_NUMBER)
        .map(|number| {
            let mut serial = *b"TAKEN       ";
            serial[5..11].copy_from_slice(format!("{number:06}").as_bytes());
            let heard = Some(start + seconds(i64::from(number) - 80_000).min(seconds(-3600)));
            Given { number, identity: Identity::new(&serial, None).unwrap(), heard }
        })
        .collect();
    let fate = Fate { seed: 5, numbers, ..Fate::default() };
    let scratch = Scratch::new();
    let directory = scratch.path("recordings");
    record(SCENARIO, None, &fate, &directory, 256);
    let recorded = utm_fusion::state::read_numbers(&only(&directory, "input-", ".numbers.json")).unwrap();
    let given: Vec<u32> = recorded.iter().map(|given| given.number).collect();
    assert_eq!(given, [1, 2], "of those who were heard longest ago");
    let output = fs::read(only(&directory, "output-", ".pcap")).unwrap();
    let input = only(&directory, "input-", ".pcap");
    assert!(output.len() > 1000 && output == replayed(&input));
}

#[test]
fn tick_shortens_no_memory() {
    // A copy 1.95 s after its original, handled after a tick 2.1 s after it, is still a copy, as in a replay without ticks.
    let simulation = flight(SCENARIO, 6, None);
    let datagram = &simulation.datagrams[0];
    let second = datagram.received.nanos() / SECOND * SECOND;
    let at = |seconds: f64| Time::from_nanos(second + (seconds * 1e9) as i64);
    let mut driver = Driver::new(&simulation.config, Masks::default(), at(0.0), 1);
    driver.receive(&reception(0, at(0.22), datagram.payload.clone()));
    driver.tick(at(2.32));
    let received = driver.reception(at(2.17), at(2.32));
    assert_eq!(received, at(2.17), "no slot was made since");
    driver.receive(&reception(0, received, datagram.payload.clone()));
    assert_eq!(driver.pipeline().tally().duplicates, 1);
}
