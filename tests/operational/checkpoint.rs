//! A pipeline restored from a checkpoint continues as if it had not been interrupted, with any sensors.

use fusion::{CheckpointError, Emission};
use utm_fusion::areas::Masks;
use utm_fusion::capture::Reception;
use utm_fusion::config::{Config, Profile};
use utm_fusion::pipeline::{NotRestored, Pipeline};

use super::{flight, site};

/// The emissions and counters as text, exact to the bit.
fn emitted(pipeline: &mut Pipeline, slots: &mut Vec<String>) {
    slots.extend(pipeline.emissions().map(|emission: Emission| format!("{emission:?}")));
}

fn run(receptions: &[Reception], config: &Config, every: usize) -> Vec<String> {
    let mut pipeline = Pipeline::new(config, Masks::default());
    let (mut slots, mut written) = (Vec::new(), 0);
    for reception in receptions {
        pipeline.receive(reception);
        emitted(&mut pipeline, &mut slots);
        if slots.len() >= written + every {
            written = slots.len();
            let octets = pipeline.checkpoint(config);
            pipeline = Pipeline::restored(config, Masks::default(), &octets).unwrap();
            assert!(pipeline.checkpoint(config) == octets, "another state");
        }
    }
    pipeline.finish();
    emitted(&mut pipeline, &mut slots);
    slots
}

/// Spoofed and jammed transponders; all kinds of sensors together; no radar; several radars; gaps.
#[test]
fn at_every_tenth_slot_of_any_scenario_it_may_stop_and_go_on() {
    for name in ["spoof", "event", "airfield", "two-radars", "gaps"] {
        let simulation = flight(name, 1001);
        let receptions: Vec<Reception> = simulation.receptions().take(2_000).collect();
        for profile in [Profile::Operational, Profile::Reference] {
            let config = site(&simulation, profile);
            let kept = run(&receptions, &config, usize::MAX);
            let reloaded = run(&receptions, &config, 10);
            let differs = kept.iter().zip(&reloaded).position(|(kept, reloaded)| kept != reloaded);
            assert_eq!((differs, kept.len()), (None, reloaded.len()), "{name}, {profile:?}");
            assert!(kept.len() > 200, "{name}: {}", kept.len());
        }
    }
}

#[test]
fn a_site_that_is_another_one_begins_anew() {
    let simulation = flight("crossing", 1001);
    let config = site(&simulation, Profile::Operational);
    let written = Pipeline::new(&config, Masks::default()).checkpoint(&config);
    let restored = |config: &Config| Pipeline::restored(config, Masks::default(), &written).err();
    assert_eq!(restored(&config), None);
    let mut other = config.clone();
    other.sensors[0].sic = other.sensors[0].sic.wrapping_add(1);
    assert_eq!(restored(&other), Some(NotRestored::Site));
    let mut other = config.clone();
    other.fusion.profile = Profile::Reference;
    assert!(matches!(restored(&other), Some(NotRestored::Engine(_))));
    let cut = |length: usize| Pipeline::restored(&config, Masks::default(), &written[..length]).err();
    assert_eq!(cut(10), Some(NotRestored::Unreadable));
    for length in [written.len() / 2, written.len() - 1] {
        assert_eq!(cut(length), Some(NotRestored::Engine(CheckpointError::Damaged)));
    }
}
