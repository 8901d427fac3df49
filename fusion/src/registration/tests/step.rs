//! Rejection of tracks, and detection of steps.

use super::super::tracks::{Registration, SampleOutcome};
use super::{PRIOR, World, values};

fn registration() -> Registration {
    Registration::default()
}

/// A radar with this number of earlier tracks.
fn settled(world: &mut World, tracks: usize) -> Registration {
    let mut registration = registration();
    for _ in 0..tracks {
        let taken = registration.add(&world.sample(60.0, 2.0));
        assert!(!matches!(taken, SampleOutcome::Step { .. }));
    }
    registration
}

/// Number of tracks until a step is detected; `None`: more than sixty.
fn delay(world: &mut World, registration: &mut Registration) -> Option<usize> {
    (1..=60).find(|_| matches!(registration.add(&world.sample(60.0, 2.0)), SampleOutcome::Step { .. }))
}

#[test]
fn no_step_is_found_where_there_is_none() {
    let mut world = World::wrong(1);
    let mut registration = registration();
    let mut rejected = 0;
    for index in 0..10_000 {
        match registration.add(&world.sample(24.0, 3.0)) {
            SampleOutcome::Kept => {}
            SampleOutcome::Rejected => rejected += 1,
            SampleOutcome::Step { before, after } => panic!("{index}: {before:?} {after:?}"),
        }
    }
    println!("{rejected} of 10,000 rejected");
    assert!(rejected < 20, "{rejected}");
}

#[test]
fn a_step_of_a_degree_is_found_within_about_fifteen_tracks() {
    let mut delays: Vec<usize> = (0..60)
        .map(|seed| {
            let mut world = World::new(100 + seed);
            let mut registration = settled(&mut world, 60);
            world.bias[0] += 1_f64.to_radians();
            delay(&mut world, &mut registration).unwrap_or(61)
        })
        .collect();
    delays.sort_unstable();
    println!("delays: {delays:?}");
    assert!(delays[0] >= 6, "least {}", delays[0]);
    assert!(delays[30] <= 15, "median {}", delays[30]);
    assert!(delays[54] <= 25, "nine in ten {}", delays[54]);
}

#[test]
fn large_steps_are_found_as_soon_as_eight_tracks_tell() {
    let steps = [(0, 3_f64.to_radians()), (0, -90_f64.to_radians()), (3, 40.0), (4, -25.0)];
    for (parameter, step) in steps {
        let mut world = World::new(300);
        let mut registration = settled(&mut world, 60);
        world.bias[parameter] += step;
        let mut found = None;
        for index in 1..=12 {
            if let SampleOutcome::Step { before, after } = registration.add(&world.sample(60.0, 2.0)) {
                found = Some((index, values(&before)[parameter], values(&after)[parameter]));
                break;
            }
        }
        let (index, before, after) = found.unwrap();
        assert!(index <= 9, "{parameter}: {index}");
        assert!(before.value.abs() < 4.0 * before.deviation, "{before:?}");
        // Eight tracks do not separate height and tilts yet.
        assert!((after.value - step).abs() < 4.5 * after.deviation, "{parameter}: {after:?}");
        // The earlier tracks have no influence any more.
        for _ in 0..40 {
            let taken = registration.add(&world.sample(60.0, 2.0));
            assert!(!matches!(taken, SampleOutcome::Step { .. }));
        }
        let now = values(&registration.estimate())[parameter];
        assert!((now.value - step).abs() < 4.0 * now.deviation, "{parameter}: {now:?}");
    }
}

/// Errors larger than stated cause no steps, and few rejections.
#[test]
fn errors_given_wrongly_are_no_step() {
    for (scale, runs, most) in [(1.3, 20, 8), (2.0, 10, 20)] {
        let mut rejected = 0;
        for seed in 0..runs {
            let mut world = World::wrong(800 + seed);
            world.scale = scale;
            let mut registration = registration();
            for index in 0..150 {
                let taken = registration.add(&world.sample(60.0, 2.0));
                assert!(!matches!(taken, SampleOutcome::Step { .. }), "{scale} {seed} {index}: {taken:?}");
                rejected += usize::from(taken == SampleOutcome::Rejected);
            }
        }
        println!("{scale}: {rejected} of {} rejected", 150 * runs);
        assert!(rejected <= most, "{scale}: {rejected}");
    }
}

/// Birds, and a transponder with false positions: occasionally, and from the first track on.
#[test]
fn strays_are_rejected_and_are_no_step() {
    for seed in 0..5 {
        let mut world = World::wrong(400 + seed);
        let truth = world.bias;
        let mut registration = registration();
        let mut wrong = 0;
        for index in 0..300 {
            let stray = index % 10 == 0;
            world.bias = truth;
            if stray {
                world.bias[0] += if index % 20 == 0 { 0.3 } else { -0.6 };
                world.bias[3] += 60.0;
            }
            let taken = registration.add(&world.sample(60.0, 2.0));
            assert!(!matches!(taken, SampleOutcome::Step { .. }), "{seed} {index}: {taken:?}");
            wrong += usize::from((taken == SampleOutcome::Rejected) != stray);
        }
        assert!(wrong <= 3, "{wrong}");
        let bearing = registration.estimate().bearing;
        assert!((bearing.value - truth[0]).abs() < 4.0 * bearing.deviation);
    }
}

/// One track, however long, is not a step: its transponder may report false positions.
#[test]
fn one_track_in_many_pieces_is_no_step() {
    let mut world = World::new(500);
    let mut registration = settled(&mut world, 40);
    let known = registration.estimate();
    world.bias[0] += 0.2;
    let plots = world.plots(900.0, 1.0);
    let mut along = super::TrackComparison::new(&super::ERRORS);
    for residual in &plots {
        along.add(residual);
        if along.gathered_s() >= 20.0
            && let Some(piece) = along.take_sample()
        {
            assert_eq!(registration.add(&piece), SampleOutcome::Rejected);
        }
    }
    assert!((registration.estimate().bearing.value - known.bearing.value).abs() < 1e-6);
}

#[test]
fn old_steps_are_discarded() {
    let mut world = World::new(600);
    let mut registration = settled(&mut world, 60);
    let many = registration.estimate();
    world.now_s += 7200.0;
    registration.add(&world.sample(60.0, 2.0));
    let fewer = registration.estimate();
    assert!((fewer.samples - (1.0 + 60.0 * (-1.0_f64).exp())).abs() < 1.5, "{}", fewer.samples);
    assert!(fewer.bearing.deviation > 1.4 * many.bearing.deviation);
    world.now_s += 1e6;
    registration.add(&world.sample(60.0, 2.0));
    assert!(registration.estimate().samples < 1.01);
}

#[test]
fn nothing_is_known_of_a_new_radar() {
    let estimate = registration().estimate();
    assert_eq!(estimate.samples, 0.0);
    assert_eq!(estimate.residual, None);
    for (value, prior) in values(&estimate).iter().zip(PRIOR) {
        assert!(
            value.value.abs() < 1e-12 && (value.deviation / prior - 1.0).abs() < 1e-9 && !value.observable
        );
    }
}

/// The residual is the scatter relative to the stated deviations.
#[test]
fn residual_reveals_errors_above_the_data_sheet() {
    let residual = |scale: f64| {
        let mut world = World::wrong(700);
        world.scale = scale;
        let estimate = world.estimate(80);
        println!("{scale}: {:?}", estimate.residual);
        (estimate.residual.unwrap(), estimate.doubtful())
    };
    let ((as_said, doubtful), (larger, larger_doubtful)) = (residual(1.0), residual(2.5));
    assert!((0.6..1.5).contains(&as_said) && !doubtful, "{as_said}");
    assert!((3.5..8.0).contains(&larger) && larger_doubtful, "{larger}");
}
