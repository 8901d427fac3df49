//! Both trackers in one encounter, and the errors of their outputs, ten per second.

use fusion::settings::Singer;
use tracker::{Flight, Tracker, TrackerEstimate};

use crate::approach::closest;
use crate::encounter::{RelativeGeometry, SimulatedEncounter};
use crate::experiment::{Draws, mean, rms};
use crate::sensors::{SensorDetection, TICK_S, detections, time};

/// Singer model of both trackers: time constant, and standard deviation per axis. The paper does not state them; chosen
/// on seeds 1 to 60.
pub const LASTS_S: f64 = 5.0;
pub const ACCELERATION: f64 = 1.6;
/// Standard deviations of an intruder's initial velocity, over ground per axis, and vertical, metres per second.
pub const FIRST_SPEED: f64 = 30.0;
pub const FIRST_CLIMB: f64 = 5.0;
/// Range from which a track is firm, metres. `NEAR_M` is the range at which the statistics end.
pub const FIRM_M: f64 = 2600.0;
pub const NEAR_M: f64 = 350.0;
/// Ellipsoidal gate: squared Mahalanobis distance that contains 99.9 %, for two and for three measured values.
const GATE: [f64; 2] = [13.82, 16.27];

/// Output of a tracker at one time.
#[derive(Clone, Copy)]
pub struct TrackerOutput {
    pub at: f64,
    pub relative: RelativeGeometry,
    /// Time to the closest point, seconds, and distance there, metres.
    pub closest: (f64, f64),
}

/// One encounter: detections and the output of each tracker.
pub struct EncounterRun {
    pub detections: Vec<SensorDetection>,
    /// Outputs with radar alone; with radar and camera.
    pub outputs: [Vec<TrackerOutput>; 2],
}

/// Mean and standard deviation of the errors, in the columns of Table 2, and rms error of the time to the closest
/// point.
#[derive(Clone, Copy, Debug)]
pub struct EncounterErrors {
    pub mean: [f64; 6],
    pub std: [f64; 6],
    pub time_s: f64,
}

impl EncounterRun {
    pub fn fly(encounter: &SimulatedEncounter, seed: u64) -> Self {
        let detections = detections(encounter, &mut Draws::of(seed));
        let outputs = [false, true].map(|camera| track(encounter, &detections, camera));
        Self { detections, outputs }
    }

    /// Errors of a tracker (0: radar alone, 1: both), from the firm track on and beyond 350 m.
    pub fn errors(&self, encounter: &SimulatedEncounter, tracker: usize) -> EncounterErrors {
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
        EncounterErrors { mean, std, time_s: rms(&times.collect::<Vec<_>>()) }
    }
}

/// True time to the closest point, and distance there.
pub fn reference(encounter: &SimulatedEncounter, at: f64) -> (f64, f64) {
    let (line, rate) = encounter.line(at);
    let closest = closest(&line, &rate);
    (closest.time_s, closest.miss.norm())
}

fn track(encounter: &SimulatedEncounter, detections: &[SensorDetection], camera: bool) -> Vec<TrackerOutput> {
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
                    tracker = TrackerEstimate::first(&reading, FIRST_SPEED).and_then(|mut first| {
                        first.covariance[(5, 5)] = FIRST_CLIMB * FIRST_CLIMB;
                        Tracker::begin(&flight, &first)
                    });
                }
                Some(tracker) => {
                    let gate = |(distance, count): (f64, usize)| distance <= GATE[count.clamp(2, 3) - 2];
                    if tracker.distance(&reading).is_some_and(gate) && tracker.update(reading).is_ok() {
                        // No detection arrives later than one second.
                        tracker.forget_before(time(now - 1.2));
                    }
                }
            }
        }
        let Some(estimate) = tracker.as_ref().and_then(|tracker| tracker.at(time(now))) else { continue };
        let own = encounter.own(now);
        let (line, rate) = (estimate.position.0 - own.position, estimate.velocity - own.velocity);
        let closest = closest(&line, &rate);
        outputs.push(TrackerOutput {
            at: now,
            relative: RelativeGeometry::of(&line, &rate),
            closest: (closest.time_s, closest.miss.norm()),
        });
    }
    outputs
}
