//! An engine that is restored from a checkpoint continues like one that was never stopped.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use utm_fusion_engine::report::{Bearing, CameraTrackKey};
use utm_fusion_engine::settings::{Camera, OperationalRules};
use utm_fusion_engine::{CheckpointError, Emission, Engine, Enu, Profile, Report, Settings};

use crate::scenario::{self, Arrival, Scenario, run, settings};

/// Position of the camera.
const NOWHERE: Enu = Enu::new(0.0, 0.0, 0.0);

/// The same settings in both profiles.
fn profiles(scenario: &Scenario) -> [Settings; 2] {
    let reference = settings(scenario);
    let operational =
        Settings { profile: Profile::Operational(OperationalRules::default()), ..reference.clone() };
    [reference, operational]
}

/// Runs the engine over the arrivals. It is restored from its own checkpoint after every `every` slots, in the middle
/// of a slot's arrivals, and must write the same checkpoint again.
pub fn reloaded(settings: &Settings, arrivals: &[Arrival], every: usize) -> Vec<Emission> {
    let mut engine = Engine::new(settings.clone()).unwrap();
    let mut emissions: Vec<Emission> = Vec::new();
    let mut written = 0;
    for arrival in arrivals {
        emissions.extend(engine.advance(arrival.received));
        if emissions.len() >= written + every {
            written = emissions.len();
            let octets = engine.checkpoint();
            engine = Engine::restored(settings.clone(), &octets).unwrap();
            assert!(engine.checkpoint() == octets, "another state");
        }
        let _ = engine.handle(arrival.report);
    }
    emissions.extend(engine.finish());
    emissions
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn to_go_on_from_a_checkpoint_is_not_to_have_stopped(scenario in scenario::any(), every in 1..16_usize) {
        for settings in profiles(&scenario) {
            let kept = run(&settings, &scenario.arrivals);
            let emitted = reloaded(&settings, &scenario.arrivals, every);
            prop_assert_eq!(emitted.len(), kept.len());
            for (emitted, kept) in emitted.iter().zip(&kept) {
                prop_assert_eq!(emitted, kept);
            }
        }
    }

    /// An incomplete or damaged checkpoint is an error, and never a panic.
    #[test]
    fn damage_is_found(scenario in scenario::any(), at in any::<prop::sample::Index>(), bit in 0..8_u32) {
        let [_, settings] = profiles(&scenario);
        let mut engine = Engine::new(settings.clone()).unwrap();
        for arrival in scenario.arrivals.iter().take(40) {
            drop(engine.advance(arrival.received));
            let _ = engine.handle(arrival.report);
        }
        let whole = engine.checkpoint();
        let read = |octets: &[u8]| Engine::restored(settings.clone(), octets).map(|_| ());
        prop_assert_eq!(read(&whole), Ok(()));
        let cut = at.index(whole.len());
        prop_assert!(read(&whole[..cut]).is_err());
        let mut changed = whole.clone();
        changed[cut] ^= 1 << bit;
        prop_assert!(read(&changed).is_err());
        prop_assert!(read(&[whole, vec![0]].concat()).is_err());
    }
}

#[test]
fn checkpoint_of_other_settings_or_version_is_discarded() {
    let written = Engine::new(Settings::default()).unwrap().checkpoint();
    let other = Settings { latency_slots: 24, ..Settings::default() };
    assert_eq!(Engine::restored(other, &written).err(), Some(CheckpointError::Settings));
    let mut later = written.clone();
    later[9] = later[9].wrapping_add(1);
    let found = u16::from_be_bytes([later[8], later[9]]);
    assert_eq!(Engine::restored(Settings::default(), &later).err(), Some(CheckpointError::Layout { found }));
    assert_eq!(Engine::restored(Settings::default(), b"{}").err(), Some(CheckpointError::NotOne));
    assert!(Engine::restored(Settings::default(), &written).is_ok());
}

/// The types of the state and their fields belong to the layout's number. A change requires another number (`LAYOUT` in
/// `src/checkpoint.rs`); then `UPDATE=1` writes the list again.
#[test]
fn the_number_of_the_layout_is_that_of_its_types() {
    let mut runner = TestRunner::deterministic();
    let mut fields = BTreeSet::new();
    let mut number = 0;
    for _ in 0..10 {
        let scenario = scenario::any().new_tree(&mut runner).unwrap().current();
        for mut settings in profiles(&scenario) {
            let sensor = settings.add_camera(Camera {
                position: NOWHERE,
                azimuth: 0.01,
                elevation: 0.01,
                orientation: 0.05,
            });
            let mut engine = Engine::new(settings).unwrap();
            for arrival in &scenario.arrivals {
                drop(engine.advance(arrival.received));
                let _ = engine.handle(arrival.report);
                let track = CameraTrackKey { sensor, number: 1 };
                let (time, azimuth) = (arrival.received, 0.3);
                let _ = engine.handle(Report::Bearing(Bearing { track, time, azimuth, elevation: None }));
            }
            note_fields(&format!("{engine:#?}"), &mut fields);
            let written = engine.checkpoint();
            number = u16::from_be_bytes([written[8], written[9]]);
        }
    }
    let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
    let now = format!("layout {number}\n{}\n", fields.join("\n"));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/engine/layout.txt");
    let kept = include_str!("layout.txt");
    if now == kept {
        return;
    }
    assert!(
        now.lines().next() != kept.lines().next(),
        "types of the state have changed: LAYOUT needs another number"
    );
    assert!(std::env::var_os("UPDATE").is_some(), "UPDATE=1 writes {} anew", path.display());
    fs::write(&path, now).unwrap();
}

/// Collects each `Type.field` of a value's debug format.
fn note_fields(debug: &str, fields: &mut BTreeSet<String>) {
    let mut within: Vec<&str> = Vec::new();
    for line in debug.lines().map(str::trim) {
        let mut rest = line;
        if let Some(behind) = rest.strip_prefix(['}', ')', ']']) {
            within.pop();
            rest = behind.trim_start_matches([',', ':', ' ']);
        }
        let is_name = |name: &&str| name.starts_with(|first: char| first.is_ascii_lowercase());
        if let Some((field, value)) = rest.split_once(": ").filter(|(name, _)| is_name(name)) {
            if let Some(of) = within.last().filter(|of| !of.is_empty()) {
                fields.insert(format!("{of}.{field}"));
            }
            rest = value;
        }
        if let Some(name) = rest.strip_suffix(['{', '(', '[']) {
            within.push(name.trim());
        }
    }
}
