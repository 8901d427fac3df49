//! How fast it is, on one core of the machine that makes the document.

use std::time::Instant;

use utm_fusion::areas::Masks;
use utm_fusion::config::Profile;
use utm_fusion::picture::PictureMaker;
use utm_fusion::pipeline::Pipeline;
use utm_fusion::simulate::{Scenario, simulate};

use crate::flights::Failure;

/// What a flight took.
pub struct Speed {
    /// Seconds of flight that a second is enough for: from datagrams to pictures.
    pub times_real: f64,
    /// What a slot and its picture take, milliseconds: ninety-nine of a hundred take no more.
    pub p99_ms: f64,
}

/// Of the first seed of a scenario.
pub fn measure(scenario: &Scenario, profile: Profile) -> Result<Speed, Failure> {
    let simulation = simulate(scenario, 1, None)?;
    let mut config = simulation.config.clone();
    config.fusion.profile = profile;
    let mut pipeline = Pipeline::new(&config, Masks::default());
    let maker = PictureMaker::new(&config, pipeline.normaliser());
    let mut slots_ms = Vec::new();
    let begin = now();
    for reception in simulation.receptions() {
        // A reception has one slot as a rule; where it has several, each is as slow as all of them on average.
        let since = now();
        pipeline.receive(&reception);
        let mut slots = 0;
        for emission in pipeline.emissions() {
            std::hint::black_box(maker.picture(emission));
            slots += 1;
        }
        let slot_ms = since.elapsed().as_secs_f64() * 1e3 / slots.max(1) as f64;
        slots_ms.extend(std::iter::repeat_n(slot_ms, slots));
    }
    pipeline.finish();
    pipeline.emissions().for_each(|emission| _ = std::hint::black_box(maker.picture(emission)));
    let times_real = scenario.duration_s / begin.elapsed().as_secs_f64();
    slots_ms.sort_by(f64::total_cmp);
    let place = (slots_ms.len() * 99).div_ceil(100).saturating_sub(1);
    let p99_ms = slots_ms.get(place).copied().ok_or("no slot was published")?;
    Ok(Speed { times_real, p99_ms })
}

#[expect(clippy::disallowed_methods, reason = "how long it takes is what is measured")]
fn now() -> Instant {
    Instant::now()
}
