//! Influence of a spoofed transponder on the estimates for radars and delays.

use fusion::registration::Misalignment;
use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Attack, Span, simulate};

use crate::{scenario, site};

/// The misalignment learnt in some minutes of five equipped drones, of which one is attacked from the second minute on: with and
/// without the rule.
fn told(attack: Attack) -> [Misalignment; 2] {
    let mut scenario = scenario("spoof");
    (scenario.duration_s, scenario.drones.jammed) = (400.0, 0);
    scenario.transponder.attack = attack;
    scenario.transponder.spoof_after_s = Span::new(60.0, 60.0);
    let simulation = simulate(&scenario, 7, None).unwrap();
    [true, false].map(|protect| {
        let mut config = site(&simulation, Profile::Operational);
        config.integrity.protect = protect;
        let mut pipeline = Pipeline::new(&config, Masks::default());
        for reception in simulation.receptions() {
            pipeline.receive(&reception);
            pipeline.emissions().for_each(drop);
        }
        pipeline.engine().registered().next().unwrap().1.estimate
    })
}

#[test]
fn who_is_suspect_tells_nothing_of_registration_and_delays() {
    let [[drifting, believed_drifting], [shifted, believed_shifted]] =
        [Attack::Drift, Attack::Time].map(told);
    // A transponder without influence has none under either attack.
    let off = (drifting.samples - shifted.samples).abs();
    assert!(off < 1e-3, "{drifting:#?}\n{shifted:#?}");
    for value in [
        |of: &Misalignment| of.bearing,
        |of: &Misalignment| of.tilt_east,
        |of: &Misalignment| of.range_m,
        |of: &Misalignment| of.time_s,
    ] {
        let (one, other) = (value(&drifting), value(&shifted));
        let off = (one.value - other.value).abs() / one.deviation;
        assert!(off < 0.2, "{drifting:#?}\n{shifted:#?}");
    }
    // Without the rule the transponder contributes samples and does some harm.
    for (believed, protected) in [(&believed_drifting, &drifting), (&believed_shifted, &shifted)] {
        assert!(believed.samples > protected.samples + 0.5, "{believed:#?}\n{protected:#?}");
    }
    let turned = (believed_shifted.bearing.value - shifted.bearing.value).abs() / shifted.bearing.deviation;
    assert!(turned > 0.4, "{believed_shifted:#?}\n{shifted:#?}");
}
