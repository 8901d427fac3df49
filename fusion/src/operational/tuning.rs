//! Every number of the rules: unit, meaning, source.
//!
//! *LLR* is a natural logarithm of a likelihood ratio, positive in favour; *sigma* one standard deviation. A number without a
//! source was set by judgement; what all of them together reach is measured in `docs/EVALUATION.md`.

use jiff::SignedDuration;

// --- Drones, and aircraft that are not one

/// Ground speed that no drone exceeds, metres a second.
pub(super) const DRONE_SPEED_MAX_M_S: f64 = 40.0;
/// Gate beside speed and radar errors: extent of the drone and errors of the transponder, metres.
pub(super) const GATE_M: f64 = 60.0;
/// Gate in standard deviations of a radar's bias.
pub(super) const GATE_SIGMAS: f64 = 4.0;
/// The same for a plot of a radar track that is already known: a larger jump makes it another track.
pub(super) const TRACK_GATE_SIGMAS: f64 = 8.0;
/// Acceleration of a drone between two reports, metres a second squared.
pub(super) const BETWEEN_REPORTS_M_S2: f64 = 1.5;

/// How two different aircraft that are near each other lie apart along one axis; one sigma each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    pub(super) distance_m: f64,
    /// Rate of the distance, metres a second.
    pub(super) rate_m_s: f64,
    /// Power spectral density of the relative acceleration, m²/s³.
    pub(super) acceleration_m2_s3: f64,
}
/// Over ground, each axis.
pub(super) const SEPARATION_OVER_GROUND: Separation =
    Separation { distance_m: 300.0, rate_m_s: 14.0, acceleration_m2_s3: 4.0 };
/// In height.
pub(super) const SEPARATION_IN_HEIGHT: Separation =
    Separation { distance_m: 40.0, rate_m_s: 2.0, acceleration_m2_s3: 0.5 };

// --- Histories

/// A radar's track number heard again after a longer silence is another track; the longer of this and
pub(super) const TRACK_BREAK: SignedDuration = SignedDuration::from_secs(5);
/// so many periods of the radar.
pub(super) const TRACK_BREAK_PERIODS: f64 = 5.0;
/// Plots are kept this long behind the published slot.
pub(super) const PLOTS_KEPT: SignedDuration = SignedDuration::from_secs(12);
/// Reports of transponders are kept this long behind it.
pub(super) const FIXES_KEPT: SignedDuration = SignedDuration::from_secs(20);
/// A target without a measurement for longer is dropped.
pub(super) const TARGET_SILENT_MAX: SignedDuration = SignedDuration::from_secs(50);
/// Reports of one transponder this near in time are one report, received twice.
pub(super) const SAME_REPORT: SignedDuration = SignedDuration::from_millis(20);

// --- Transponders

/// Share of a transponder's position error that is new with each report: most of a GNSS receiver's lasts for a minute.
pub(super) const FRESH_SHARE: f64 = 0.3;
/// A radar's height of an aircraft counts for this time after the last plot that measured it, seconds.
pub(super) const RADAR_HEIGHT_S: f64 = 5.0;
/// A transponder's height counts as stated for this time after the last report that states it, seconds.
pub(super) const HEIGHT_KEPT_S: f64 = 5.0;
/// Of two sources of one identity the one whose positions are this many times better counts alone while it speaks: positions
/// from a curve that runs from the one to the other and back are worse than either.
pub(super) const POORER: f64 = 2.0;
/// How large a transponder's white noise is, is forgotten to 1/e in this time, seconds; that of its type in this flying time.
pub(super) const NOISE_CHANGE_S: f64 = 900.0;
pub(super) const TYPE_NOISE_CHANGE_S: f64 = 14_400.0;
/// The types of transponders that are remembered; one that is new then takes the place of the one not heard for longest.
pub(super) const TYPES_MAX: usize = 64;
/// Factor on the formal deviation of the delay of a type, or of one transponder: the errors of a radar depend on the motion, as
/// a delay does, and the formal deviation leaves that out. On simulated flights delays were 1.5 to 2.6 times as far off.
pub(super) const DELAY_DEVIATIONS: f64 = 2.0;
/// The transponders whose delays are remembered; one that is new then takes the place of the one not seen for longest.
pub(super) const TRANSPONDERS_MAX: usize = 1024;
/// Sigma of a transponder's velocity on each axis over ground, metres a second: from Doppler, so better than its positions.
pub(super) const TRANSPONDER_VELOCITY_M_S: f64 = 0.3;
/// Sigma of its climb rate: satellites are all above it.
pub(super) const TRANSPONDER_CLIMB_M_S: f64 = 0.5;
/// Sigma by which transponders of one type differ in their delay, and types from one another, seconds.
pub(super) const DELAY_BETWEEN_TRANSPONDERS_S: f64 = 0.08;
pub(super) const DELAY_BETWEEN_TYPES_S: f64 = 0.08;
/// Delay of transponder reports before any radar tells of it: mean and sigma, seconds. Receivers that stamp a report when they
/// send it are late by up to a quarter of a second; others stamp the measurement, and are not late at all.
pub(super) const DELAY_PRIOR_S: (f64, f64) = (0.0, 0.1);

// --- Latency

/// Who is which aircraft is decided of a slot so long after its opening, however soon it is published: what walks off or changes
/// over shows by what comes after it, and reports that come late are in time. With 3.25 s, eight seeds of `crossing` and `dense` had
/// errors larger by 2 to 6 % at every shorter latency.
pub(crate) const DECIDED_AFTER: SignedDuration = SignedDuration::from_millis(6250);

// --- Admission of transponder identities

/// Two reports of an identity agree if an aircraft this fast could fly from one to the other, metres a second,
pub(super) const ADMISSION_SPEED_MAX_M_S: f64 = 100.0;
/// of one with somebody on board this fast (`adsb`: airliners),
pub(super) const ADMISSION_CREWED_SPEED_MAX_M_S: f64 = 350.0;
/// and this far, metres.
pub(super) const ADMISSION_GATE_M: f64 = 100.0;
/// How long a first report waits for a second, and a silent identity stays known; the longer of this and
pub(super) const ADMISSION_WAIT: SignedDuration = SignedDuration::from_secs(60);
/// so many periods of the receiver.
pub(super) const ADMISSION_WAIT_PERIODS: f64 = 3.0;
/// Permits accumulate for this long, seconds: a service that starts into a city admits all of it at once.
pub(super) const PERMITS_ACCUMULATE_S: i64 = 20;
/// Waiting identities of one receiver; the oldest give way.
pub(super) const WAITING_MAX: usize = 1 << 16;
/// Waiting reports of one identity; the oldest give way.
pub(super) const WAITING_REPORTS_MAX: usize = 4;
/// A flood ends this long after new identities were last too many.
pub(super) const FLOOD_LASTS: SignedDuration = SignedDuration::from_secs(10);

// --- Likelihood that a radar track and a transponder are one aircraft

/// Bound of the summed LLR, so that what was long ago does not outweigh what is now.
pub(super) const PAIR_LLR_MAX: f64 = 12.0;
/// Chance a second that a radar track begins to follow something else: walks off, or exchanges its number with another one's.
pub(super) const CHANGE_OVER_HZ: f64 = 0.02;
/// Bound of one axis of one plot: a radar's bias is not always slow.
pub(super) const PLOT_LLR_MAX: f64 = 2.0;
/// Bound of what the size of the bias that would explain an offset counts against a pair.
pub(super) const BIAS_PENALTY_MAX_LLR: f64 = 20.0;
/// A bias within this many sigmas counts nothing against a pair; squared.
pub(super) const BIAS_FREE_SIGMAS2: f64 = 9.0;
/// A pair with this LLR is likely to be one aircraft.
pub(super) const PAIR_LIKELY_LLR: f64 = 1.0;
/// A radar's true errors as multiples of those of its data sheet, and the prior probability of each. The largest is a
/// compromise, since a larger one also explains tracks of other aircraft that pass. Seeds of `crossing`: with 1.5, 982 of 1000
/// pairs were right instead of 988; without any above 1 a radar twice as bad as configured lost one plot in a hundred more.
pub(super) const ERROR_SCALES: [(f64, f64); 3] = [(0.1, 0.2), (0.3, 0.2), (1.1, 0.6)];
/// Where the size of the errors is learnt the multiples below 1 come nearer to it, as powers of themselves; the least power. A
/// radar differs from track to track, turns most of all.
pub(super) const SCALES_UNSURE_MIN: f64 = 0.6;
/// Least probability of a model in a mixture: turns make errors larger, and drones fly otherwise, for a while.
pub(super) const MODEL_PROBABILITY_MIN: f64 = 1e-3;

// --- Likelihood that tracks of two radars are one aircraft

/// Plots of this long count as much as a first one, seconds: for longer biases do not stay the same.
pub(super) const MUTUAL_LOOK_S: f64 = 4.0;
/// What was told before is forgotten to 1/e in this time, seconds.
pub(super) const MUTUAL_MEMORY_S: f64 = 15.0;
/// Least LLR of one plot: a track may be seduced for a while.
pub(super) const MUTUAL_LOOK_MIN_LLR: f64 = -8.0;
/// How often the offset between two radars is larger than their errors, and how many times as large their errors are then:
/// turns make the bias of an azimuth 1.7 times as large. By judgement.
pub(super) const MUTUAL_WIDE: (f64, f64) = (0.2, 1.7);
/// A radar track becomes a target by the tracks of other radars from this LLR on.
pub(super) const MUTUAL_ASSOCIATE_LLR: f64 = 3.0;
/// A radar track that could be such a target is one of its own below this LLR.
pub(super) const MUTUAL_APART_LLR: f64 = -4.0;
/// Two tracks with this LLR are likely to be one aircraft.
pub(super) const MUTUAL_LIKELY_LLR: f64 = 1.0;

// --- Association

/// A radar track and a target become one from this LLR on.
pub const ASSOCIATE_LLR: f64 = 6.0;
/// They part at this LLR.
pub const DISSOCIATE_LLR: f64 = -4.0;
/// Hysteresis: a pair stays unless another is better by this LLR.
pub(super) const HYSTERESIS_LLR: f64 = 4.0;
/// Log-odds that a radar track is a drone count for any pair up to this.
pub(super) const CLASS_LLR_MAX: f64 = 4.0;
/// A transponder this near in time to a plot is compared with it, seconds.
pub(super) const COMPARE_WITHIN_S: f64 = 2.0;
/// A radar track takes part for so many of its radar's periods after its last plot.
pub(super) const TRACK_LASTS_PERIODS: f64 = 3.0;

// --- Reacquisition of targets that no sensor sees now

/// A radar track that has begun is such a target from this LLR on: it is that one or a new one.
pub(super) const REACQUIRE_LLR: f64 = 4.0;
/// One that is still to begin, from this: no other target is left that it could be.
pub(super) const REACQUIRE_AHEAD_LLR: f64 = 3.0;
/// A radar track that is still to begin could be a target from this LLR on.
pub(super) const PLAUSIBLE_LLR: f64 = 0.0;
/// Radar tracks that begin this long after the slot are looked at, seconds.
pub(super) const LOOK_AHEAD_S: f64 = 4.0;
/// A target is looked for while the sigma of its position is below this, metres. Eight seeds of `gaps`: with 120 m, 0.17
/// changes of number a minute in gaps instead of 0.14.
pub(super) const REACQUIRE_SIGMA_MAX_M: f64 = 500.0;
/// Gate: squared Mahalanobis distance in three dimensions.
pub(super) const REACQUIRE_GATE: f64 = 16.0;

/// A radar track whose class speaks against a target by more than this is not found to be it, LLR.
pub(super) const PLAUSIBLE_CLASS_LLR: f64 = -1.5;
/// Sigma of the mean class probability between radar tracks of one aircraft; as simulated, where it was 0.06 to 0.11 that made
/// no difference.
pub(super) const OWN_CLASS_SIGMA: f64 = 0.09;
/// Share of tracks that look otherwise for once.
pub(super) const OWN_CLASS_ELSE: f64 = 0.01;
/// How common a class probability is, is known of an even spread before any tracks: as if so many had shown it.
pub(super) const CLASS_EVEN_TRACKS: f64 = 10.0;
/// Of a new radar track where an aircraft was lost that is known by its class: LLR that it is the aircraft's, before place and class
/// tell. Measured on 24 seeds of `crossing` and `gaps`: with 2, finds of an LLR of 3 to 12 are as often wrong as that says.
pub(super) const OWN_CLASS_LLR: f64 = 2.0;
/// The class of an aircraft is a mean over this, seconds.
pub(super) const OWN_CLASS_MEMORY_S: f64 = 12.5;
/// An aircraft is no further than this from a radar track for which it was wrongly taken, sigma of each axis, metres: it is
/// somewhere in the same airspace.
pub(super) const DOUBT_SIGMA_MAX_M: f64 = 200.0;

// --- Existence: drone or not

/// A radar track is confirmed as a drone from these log-odds on.
pub(super) const CONFIRM_LOG_ODDS: f64 = 3.0;
/// Mean class probability that says nothing, where birds and drones are as frequent as they are.
pub(super) const CLASS_NEUTRAL: f64 = 0.57;
/// Log-odds per unit of mean class probability above that.
pub(super) const CLASS_SLOPE: f64 = 30.0;
/// Bound of the log-odds of the class.
pub(super) const CLASS_LOG_ODDS_MAX: f64 = 6.0;
/// The class has its whole weight after plots of so many seconds: successive ones say much the same.
pub(super) const CLASS_SETTLED_S: f64 = 2.0;
/// The mean of the class probability is one over this, seconds.
pub(super) const CLASS_MEMORY_S: f64 = 60.0;
/// A plot stands for its radar's period, but for no longer than this, seconds.
pub(super) const CLASS_PLOT_MAX_S: f64 = 1.0;
/// Veto: a mean class probability below this is certain that it is no drone.
pub(super) const CLASS_NEVER: f64 = 0.01;

/// Bins of the class probability in what a site's own tracks tell of it.
pub(super) const CLASS_BINS: usize = 20;
/// Sigma of the class probability between radar tracks of one target.
pub(super) const CLASS_KERNEL: f64 = 0.03;
/// What tracks tell is forgotten to 1/e in this time, seconds.
pub(super) const CLASS_EVIDENCE_S: f64 = 7200.0;
/// A radar track tells of the class once, after plots of so many seconds.
pub(super) const CLASS_TOLD_AFTER_S: f64 = 5.0;
/// Tracks with a higher mean class probability are taken for drones when those without a transponder are counted.
pub(super) const CLASS_SURE: f64 = 0.7;
/// Tracks of drones without and with a transponder before there are any.
pub(super) const CLASS_SHARE_PRIOR: (f64, f64) = (2.0, 8.0);
/// So many tracks of a bin may be a few drones without a transponder that come again and again.
pub(super) const CLASS_SPARE_TRACKS: f64 = 5.0;
/// A track whose transponder is not decided tells nothing of the background: one with a pair above this LLR.
pub(super) const CLASS_UNDECIDED_LLR: f64 = -6.0;

/// How the rate of the range changes: a critically damped second-order Gauss–Markov process.
#[derive(Clone, Copy, Debug)]
pub(super) struct RangeMotion {
    /// Sigma of the rate, metres a second.
    pub(super) rate_m_s: f64,
    /// How fast the rate changes, radians a second.
    pub(super) turn_rad_s: f64,
    /// Prior probability among drones, or among birds.
    pub(super) share: f64,
}
/// Drones: straight on or in hover; faster than birds, and turning.
pub(super) const DRONE_MOTIONS: [RangeMotion; 2] = [
    RangeMotion { rate_m_s: 12.0, turn_rad_s: 0.01, share: 0.75 },
    RangeMotion { rate_m_s: 16.0, turn_rad_s: 0.2, share: 0.25 },
];
/// Birds: a course that wanders.
pub(super) const BIRD_MOTION: RangeMotion = RangeMotion { rate_m_s: 8.0, turn_rad_s: 0.15, share: 1.0 };
/// Mean time between a drone's changes from one motion to the other, seconds.
pub(super) const MOTION_CHANGE_S: f64 = 15.0;
/// Resolution of the range, metres: 1/256 NM (CAT048, I048/040).
pub(super) const RANGE_STEP_M: f64 = 1852.0 / 256.0;
/// Bound of one plot's log-odds of how it flies.
pub(super) const MOTION_PLOT_LOG_ODDS_MAX: f64 = 1.0;
/// Bound of their sum.
pub(super) const MOTION_LOG_ODDS_MAX: f64 = 3.0;

// --- Walking off

/// Share of radar tracks that end by walking off their aircraft.
pub(super) const WALK_OFF_SHARE: f64 = 0.2;
/// Root mean square of the speed at which they do, metres a second.
pub(super) const WALK_OFF_SPEED_M_S: f64 = 10.0;
/// How long that lasts before the track ends, from and to, seconds.
pub(super) const WALK_OFF_LASTS_S: [f64; 2] = [4.0, 10.0];
/// How often a radar track walks off, a second.
pub(super) const WALK_OFFS_HZ: f64 = 1.0 / 70.0;
/// A radar track has ended that has shown nothing for so long, seconds; or for as many periods as it lasts.
pub(super) const ENDED_AFTER_S: f64 = 2.5;
/// How much of what comes after a slot is known at most when that is made, seconds.
pub(super) const KNOWN_AHEAD_S: f64 = 6.0;

// --- Initiation

/// A radar track becomes a target of its own where its LLR with every transponder near it is below this: a second track of a
/// known aircraft would be its ghost.
pub(super) const NOBODYS_LLR: f64 = -8.0;
/// A radar track that was likely to be a known target has most often walked off it: no target of its own for this long after.
/// What walks off does so for 4 to 10 s.
pub(super) const INITIATION_HOLD: SignedDuration = SignedDuration::from_secs(10);
/// A target that only a radar sees is published no longer than this after its last plot and before its first, seconds.
pub(super) const COAST_MAX_S: f64 = 2.0;

// --- Filter

/// Radar plots enter a target's filter only where its transponder is silent for longer, seconds. Measured: where it
/// reports, they add up to 10 % to its error.
pub(super) const TRANSPONDER_SILENT_S: f64 = 5.0;
/// Sigma of a radar track's velocity on each axis, metres a second: what the radar's own tracker makes of its plots.
pub(super) const RADAR_VELOCITY_M_S: f64 = 1.5;
/// Correlation time of its error, seconds.
pub(super) const RADAR_VELOCITY_CORRELATION_S: f64 = 3.0;

// --- Cameras

/// Bearings of a camera are kept this long behind the published slot.
pub(super) const CAMERA_KEPT: SignedDuration = SignedDuration::from_secs(12);
/// Looks of one track are used that are this far apart, seconds: what a camera sees wrong it sees wrong for a few frames.
pub(super) const CAMERA_LOOK_S: f64 = 0.45;
/// A camera's track without a look for longer has ended, seconds.
pub(super) const CAMERA_ENDS_S: f64 = 10.0;
/// Field in which anything else would be seen with even chance, radians (20°).
pub(super) const CAMERA_FIELD: f64 = 0.349;
/// Bounds of one look's LLR, and of their sum.
pub(super) const CAMERA_LOOK_LLR_MAX: f64 = 2.0;
pub(super) const CAMERA_LLR_MAX: f64 = 12.0;
/// A camera's track follows a target from this sum on,
pub(super) const CAMERA_FOLLOW_LLR: f64 = 6.0;
/// where no other target is as likely by this much.
pub(super) const CAMERA_MARGIN_LLR: f64 = 3.0;
/// Nearer to a camera its angles say little, metres over ground.
pub(super) const CAMERA_NEAR_M: f64 = 5.0;
/// Steps of the distance at which a look is taken: what was filtered with nearly the same one is not filtered again.
pub(super) const CAMERA_RANGE_STEP: f64 = 1.05;

// --- Threads

/// Fewer radar tracks or targets than this are not worth a thread: each costs microseconds, and so does a start.
pub(super) const THREAD_LEAST: usize = 100;

// --- Output

/// An aircraft whose transponder is silent and that no radar sees is published while the sigma of its position is below
/// this, metres: the radius that holds 95 % of its positions is then 250 m. By judgement the most that any reader has a use
/// for; which of it a reader wants is its own choice.
pub(super) const UNSEEN_SIGMA_MAX_M: f64 = 102.0;
/// In the picture "now" an aircraft is shown while the sigma of its position is at most this, metres. By judgement: the radius
/// that holds 95 % of its positions is then 61 m.
pub(super) const NOW_SIGMA_MAX_M: f64 = 25.0;
/// One that only radars see: this many sigmas of its plots' places, and so many metres more; likewise a transponder that states
/// that its reports are as wrong.
pub(super) const NOW_RADAR_SIGMAS: f64 = 1.1;
pub(super) const NOW_RADAR_SIGMA_M: f64 = 10.0;
/// Published competitors of each kind.
pub(super) const COMPETITORS_MAX: usize = 3;
/// Track number T · this + R.
pub(super) const NUMBERS_PER_TRANSPONDER: u32 = 10_000;
/// Numbers from here on are no radar's (0 to 4095, I048/161).
pub(super) const FIRST_FREE_NUMBER: u32 = 4096;

// --- Registration

/// That a radar is better than its data sheet is half believed with so many independent samples of its bias.
pub(super) const CAUTIOUS_SAMPLES: f64 = 10.0;

/// A radar track contributes in segments of this length, seconds: what turns out to be another drone spoils one of them.
pub(super) const SEGMENT_S: f64 = 10.0;
/// Misalignment of a radar set up by compass and spirit level, before its tracks tell of it; sigmas of range, azimuth, height.
pub(super) const MISALIGNMENT_RANGE_M: f64 = 5.0;
pub(super) const MISALIGNMENT_AZIMUTH_RAD: f64 = 1.0_f64.to_radians();
pub(super) const MISALIGNMENT_HEIGHT_M: f64 = 5.0;
/// Where a radar's remaining misalignment is taken for all its tracks: metres north and up of it.
pub(super) const REMAINING_AT_NORTH_M: f64 = 1500.0;
pub(super) const REMAINING_AT_UP_M: f64 = 100.0;
/// Relative step of a radar's errors: what was filtered with nearly the same ones is not filtered again.
pub(super) const ERROR_STEP: f64 = 0.01;
/// A transponder's velocity is its change of position from this long before to this long after, seconds.
pub(super) const VELOCITY_HALF_BASE_S: f64 = 0.5;
/// Nearer to a radar, azimuth means little, metres over ground;
pub(super) const NEAR_M: f64 = 100.0;
/// steeper, likewise: height over distance over ground.
pub(super) const STEEP: f64 = 2.0;
