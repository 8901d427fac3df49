//! The two trackers in one encounter, and the errors of what they state ten times a second.

use fusion::measurement::{Estimate, Flight, Tracker};
use fusion::settings::Singer;

use crate::approach::closest;
use crate::encounter::{Encounter, Relative};
use crate::experiment::{Draws, mean, rms};
use crate::sensors::{Detection, TICK_S, detections, time};

/// Singer's model, the same for both trackers: the time constant, and the standard deviation of each axis. Neither is
/// printed; chosen on seeds 1 to 60.
pub const LASTS_S: f64 = 5.0;
pub const ACCELERATION: f64 = 1.6;
/// What an intruder's velocity may be when it is seen first, one standard deviation over ground, each axis, and upward,
/// metres a second.
pub const FIRST_SPEED: f64 = 30.0;
pub const FIRST_CLIMB: f64 = 5.0;
/// Firm track from here on, metres, and statistics down to there.
pub const FIRM_M: f64 = 2600.0;
pub const NEAR_M: f64 = 350.0;
/// The ellipsoidal gate holds 99.9 % of two and of three numbers: squared Mahalanobis distance.
const GATE: [f64; 2] = [13.82, 16.27];

/// What a tracker stated at an instant.
#[derive(Clone, Copy)]
pub struct Output {
    pub at: f64,
    pub relative: Relative,
    /// Time until the closest point, seconds, and the distance then, metres.
    pub closest: (f64, f64),
}

/// One encounter: what was detected, and what each tracker stated.
pub struct Run {
    pub detections: Vec<Detection>,
    /// Radar alone; radar and camera.
    pub outputs: [Vec<Output>; 2],
}

/// Mean and standard deviation of the errors, as the columns of Table 2, and rms error of the time until the closest point.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    pub mean: [f64; 6],
    pub std: [f64; 6],
    pub time_s: f64,
}

impl Run {
    pub fn fly(encounter: &Encounter, seed: u64) -> Self {
        let detections = detections(encounter, &mut Draws::of(seed));
        let outputs = [false, true].map(|camera| track(encounter, &detections, camera));
        Self { detections, outputs }
    }

    /// Of a tracker, radar alone or both, from the firm track on and beyond 350 m.
    pub fn errors(&self, encounter: &Encounter, tracker: usize) -> Errors {
        let (from, to) = (encounter.when_apart(FIRM_M), encounter.when_apart(NEAR_M));
        let counted = || self.outputs[tracker].iter().filter(|output| (from..to).contains(&output.at));
        let errors: Vec<[f64; 6]> =
            counted().map(|output| output.relative.errors(&encounter.relative(output.at))).collect();
        let column = |column: usize| errors.iter().map(|errors| errors[column]).collect::<Vec<_>>();
        let times = counted().map(|output| output.closest.0 - reference(encounter, output.at).0);
        let mean = std::array::from_fn(|index| mean(&column(index)));
        let std = std::array::from_fn(|index| {
            rms(&column(index).into_iter().map(|error| error - mean[index]).collect::<Vec<_>>())
        });
        Errors { mean, std, time_s: rms(&times.collect::<Vec<_>>()) }
    }
}

/// Time until the closest point, and the distance then, as they are.
pub fn reference(encounter: &Encounter, at: f64) -> (f64, f64) {
    let (line, rate) = encounter.line(at);
    let closest = closest(&line, &rate);
    (closest.time_s, closest.miss.norm())
}

fn track(encounter: &Encounter, detections: &[Detection], camera: bool) -> Vec<Output> {
    let flight =
        Flight::Singer(Singer { lasts_s: LASTS_S, horizontal: ACCELERATION, vertical: ACCELERATION });
    let mut tracker: Option<Tracker> = None;
    let mut coming = detections.iter().filter(|detection| camera || detection.range.is_some()).peekable();
    let mut outputs = Vec::new();
    let first = (encounter.when_apart(3000.0) / TICK_S).round() as i32;
    for tick in first..=0 {
        let now = f64::from(tick) * TICK_S;
        while let Some(detection) = coming.next_if(|detection| detection.known <= now) {
            let Some(reading) = detection.reading(encounter) else { continue };
            match &mut tracker {
                None => {
                    tracker = Estimate::first(&reading, FIRST_SPEED).and_then(|mut first| {
                        first.covariance[(5, 5)] = FIRST_CLIMB * FIRST_CLIMB;
                        Tracker::begin(&flight, &first)
                    });
                }
                Some(tracker) => {
                    let gate = |(distance, count): (f64, usize)| distance <= GATE[count.clamp(2, 3) - 2];
                    if tracker.distance(&reading).is_some_and(gate) && tracker.take(reading).is_ok() {
                        // Nothing comes later than a second.
                        tracker.forget_before(time(now - 1.2));
                    }
                }
            }
        }
        let Some(estimate) = tracker.as_ref().and_then(|tracker| tracker.at(time(now))) else { continue };
        let own = encounter.own(now);
        let (line, rate) = (estimate.position.0 - own.position, estimate.velocity - own.velocity);
        let closest = closest(&line, &rate);
        outputs.push(Output {
            at: now,
            relative: Relative::of(&line, &rate),
            closest: (closest.time_s, closest.miss.norm()),
        });
    }
    outputs
}
