//! Every constant of the `operational` rules: unit, meaning, source.
//!
//! *LLR* is the natural logarithm of a likelihood ratio; positive values favour the hypothesis. *Sigma* is one standard
//! deviation. A constant without a source was set by judgement. `docs/EVALUATION.md` measures the accuracy that all of them give
//! together.

use jiff::SignedDuration;

// --- Drones and other aircraft

/// Maximum ground speed of a drone, metres a second.
pub(super) const DRONE_SPEED_MAX_M_S: f64 = 40.0;
/// Fixed part of the gate, metres: size of the drone and errors of the transponder. Speed and radar errors are added.
pub(super) const GATE_M: f64 = 60.0;
/// Gate in standard deviations of a radar's bias, between a plot and an aircraft.
pub(super) const GATE_SIGMAS: f64 = 4.0;
/// Gate in standard deviations of a radar's bias, between plots of one radar track. A larger jump begins another track.
pub(super) const TRACK_GATE_SIGMAS: f64 = 8.0;
/// Acceleration of a drone between two reports of its transponder, metres a second squared.
pub(super) const BETWEEN_REPORTS_M_S2: f64 = 1.5;

/// Distance along one axis between two aircraft that are near each other; one sigma each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    pub(super) distance_m: f64,
    /// Rate of the distance, metres a second.
    pub(super) rate_m_s: f64,
    /// Power spectral density of the relative acceleration, m²/s³.
    pub(super) acceleration_m2_s3: f64,
}
/// Separation over ground, each axis.
pub(super) const SEPARATION_OVER_GROUND: Separation =
    Separation { distance_m: 300.0, rate_m_s: 14.0, acceleration_m2_s3: 4.0 };
/// Separation in height.
pub(super) const SEPARATION_IN_HEIGHT: Separation =
    Separation { distance_m: 40.0, rate_m_s: 2.0, acceleration_m2_s3: 0.5 };

// --- Retention of reports

/// Minimum silence of a radar's track number after which the number means another track. The longer of this and
/// [`TRACK_BREAK_PERIODS`] applies.
pub(super) const TRACK_BREAK: SignedDuration = SignedDuration::from_secs(5);
/// Minimum silence of a radar's track number after which the number means another track, in radar periods.
pub(super) const TRACK_BREAK_PERIODS: f64 = 5.0;
/// Age up to which plots are kept, before the published slot.
pub(super) const PLOTS_KEPT: SignedDuration = SignedDuration::from_secs(12);
/// Age up to which transponder reports are kept, before the published slot.
pub(super) const FIXES_KEPT: SignedDuration = SignedDuration::from_secs(20);
/// Time without a measurement after which a target is dropped.
pub(super) const TARGET_SILENT_MAX: SignedDuration = SignedDuration::from_secs(50);
/// Maximum time between two reports of one transponder that are copies of one report.
pub(super) const SAME_REPORT: SignedDuration = SignedDuration::from_millis(20);

// --- Transponders

/// Share of a transponder's position error that is independent in each report. The rest is a GNSS error, which lasts about a
/// minute.
pub(super) const FRESH_SHARE: f64 = 0.3;
/// Time after a radar's last measured height during which that height is used for an aircraft, seconds.
pub(super) const RADAR_HEIGHT_S: f64 = 5.0;
/// Time after a report with a height during which a transponder counts as stating its height, seconds.
pub(super) const HEIGHT_KEPT_S: f64 = 5.0;
/// Ratio of position errors above which the poorer of two sources of one identity is ignored while the better one reports. A
/// curve that alternates between both is worse than either.
pub(super) const POORER: f64 = 2.0;
/// Time in which evidence of a transponder's white noise decays to 1/e, seconds.
pub(super) const NOISE_CHANGE_S: f64 = 900.0;
/// Flying time in which evidence of the white noise of a transponder type decays to 1/e, seconds.
pub(super) const TYPE_NOISE_CHANGE_S: f64 = 14_400.0;
/// Maximum number of transponder types that are remembered. A new type replaces the one without reports for longest.
pub(super) const TYPES_MAX: usize = 64;
/// Factor on the formal deviation of the delay of a type or a transponder. Radar errors depend on the motion, as a delay does;
/// the formal deviation ignores this. On simulated flights delays were 1.5 to 2.6 times as far off.
pub(super) const DELAY_DEVIATIONS: f64 = 2.0;
/// A constant offset of a transponder's heights is applied from this probability on, and no longer below the second.
pub(super) const HEIGHT_APPLIED: f64 = 0.7;
pub(super) const HEIGHT_RELEASED: f64 = 0.4;
/// From this probability on a transponder's heights contradict a radar's.
pub(super) const HEIGHT_CONTRADICTS: f64 = 0.5;
/// Probability of an offset before radars have shown anything: the published accuracy holds only what exceeds it.
pub(super) const HEIGHT_PRIOR: f64 = 0.19;
/// Radar tracks are judged for such offsets this often, seconds.
pub(super) const HEIGHT_JUDGED_S: f64 = 5.0;
/// Fastest change of the applied offset, metres a second: a step would part aircraft and radar track. And its resolution, metres.
pub(super) const HEIGHT_SLEW_M_S: f64 = 0.5;
pub(super) const HEIGHT_STEP_M: f64 = 0.1;
/// Fastest change of the applied share of a radar's height alignment, per second: the alignment of 30 m takes as long as an
/// offset of 30 m at [`HEIGHT_SLEW_M_S`].
pub(super) const HEIGHT_SHARE_SLEW_HZ: f64 = 1.0 / 60.0;
/// Maximum number of transponders whose delays and heights are remembered. A new one replaces the one not seen by a radar for longest.
pub(super) const TRANSPONDERS_MAX: usize = 1024;
/// Sigma of a transponder's velocity on each axis over ground, metres a second. GNSS velocity comes from Doppler, so it is more
/// accurate than differences of positions.
pub(super) const TRANSPONDER_VELOCITY_M_S: f64 = 0.3;
/// Sigma of a transponder's climb rate, metres a second. It exceeds the horizontal one because all satellites are above.
pub(super) const TRANSPONDER_CLIMB_M_S: f64 = 0.5;
/// Sigma of the delay between transponders of one type, seconds.
pub(super) const DELAY_BETWEEN_TRANSPONDERS_S: f64 = 0.08;
/// Sigma of the delay between types of transponders, seconds.
pub(super) const DELAY_BETWEEN_TYPES_S: f64 = 0.08;
/// Delay of transponder reports before radar evidence: mean and sigma, seconds. Receivers that stamp a report when they send it
/// are late by up to 0.25 s; others stamp the measurement, without delay. The mean assumes that both are common. No report is
/// stamped early.
pub(super) const DELAY_PRIOR_S: (f64, f64) = (0.08, 0.12);

// --- Latency

// --- Admission of transponder identities

/// Maximum speed of an unmanned aircraft between two reports of one identity that agree, metres a second.
pub(super) const ADMISSION_SPEED_MAX_M_S: f64 = 100.0;
/// Maximum speed of a crewed aircraft between two reports of one identity that agree, metres a second (`adsb`: airliners).
pub(super) const ADMISSION_CREWED_SPEED_MAX_M_S: f64 = 350.0;
/// Distance added to that flown at maximum speed, for two reports of one identity that agree, metres.
pub(super) const ADMISSION_GATE_M: f64 = 100.0;
/// Time for which a first report waits for a second, and for which a silent identity stays admitted. The longer of this and
/// [`ADMISSION_WAIT_PERIODS`] applies.
pub(super) const ADMISSION_WAIT: SignedDuration = SignedDuration::from_secs(60);
/// Time for which a first report waits for a second, in periods of the receiver.
pub(super) const ADMISSION_WAIT_PERIODS: f64 = 3.0;
/// Time over which unused admission permits accumulate, seconds. A service that starts in a busy city admits all aircraft at
/// once.
pub(super) const PERMITS_ACCUMULATE_S: i64 = 20;
/// Maximum number of waiting identities per receiver; the oldest are dropped.
pub(super) const WAITING_MAX: usize = 1 << 16;
/// Maximum number of waiting reports per identity; the oldest are dropped.
pub(super) const WAITING_REPORTS_MAX: usize = 4;
/// Time after the last excess of new identities at which a flood ends.
pub(super) const FLOOD_LASTS: SignedDuration = SignedDuration::from_secs(10);

// --- Likelihood that a radar track and a transponder are one aircraft

/// Bound of the summed LLR of a pair, so that old evidence does not outweigh recent evidence.
pub(super) const PAIR_LLR_MAX: f64 = 12.0;
/// Probability per second that a radar track begins to follow another object: it walks off, or exchanges its number with another
/// track.
pub(super) const CHANGE_OVER_HZ: f64 = 0.02;
/// Bound of the LLR of one axis of one plot: a radar's bias sometimes changes fast.
pub(super) const PLOT_LLR_MAX: f64 = 2.0;
/// Maximum LLR counted against a pair for the size of the bias that would explain its offset.
pub(super) const BIAS_PENALTY_MAX_LLR: f64 = 20.0;
/// Bias that counts nothing against a pair, in sigmas squared.
pub(super) const BIAS_FREE_SIGMAS2: f64 = 9.0;
/// Minimum LLR at which a pair is likely to be one aircraft.
pub(super) const PAIR_LIKELY_LLR: f64 = 1.0;
/// Multiples of the data sheet's errors that a radar may have, each with its prior probability. The largest is a compromise: a
/// larger one also explains tracks of other aircraft that pass. Seeds of `crossing`: with 1.5, 982 of 1000 pairs were right
/// instead of 988. Without a multiple above 1, a radar twice as bad as configured lost one plot in a hundred more.
pub(super) const ERROR_SCALES: [(f64, f64); 3] = [(0.1, 0.2), (0.3, 0.2), (1.1, 0.6)];
/// Minimum exponent applied to the multiples below 1 of [`ERROR_SCALES`] where the errors are learnt; it moves them towards 1. A
/// radar's errors differ between tracks, above all in turns.
pub(super) const SCALES_UNSURE_MIN: f64 = 0.6;
/// Minimum probability of a model in a mixture. Turns increase errors and change the motion for a while.
pub(super) const MODEL_PROBABILITY_MIN: f64 = 1e-3;

// --- Likelihood that tracks of two radars are one aircraft

/// Time over which plots count as one independent look, seconds. Biases change over longer times.
pub(super) const MUTUAL_LOOK_S: f64 = 4.0;
/// Time in which the evidence on two radar tracks decays to 1/e, seconds.
pub(super) const MUTUAL_MEMORY_S: f64 = 15.0;
/// Minimum LLR of one plot: a track may follow another object for a while.
pub(super) const MUTUAL_LOOK_MIN_LLR: f64 = -8.0;
/// Share of offsets between two radars that exceed their errors, and the factor on the errors then. Turns make the bias of an
/// azimuth 1.7 times as large. By judgement.
pub(super) const MUTUAL_WIDE: (f64, f64) = (0.2, 1.7);
/// Minimum LLR from tracks of other radars at which a radar track is associated with a target.
pub(super) const MUTUAL_ASSOCIATE_LLR: f64 = 3.0;
/// LLR below which a radar track begins a target of its own, apart from a target that other radars see.
pub(super) const MUTUAL_APART_LLR: f64 = -4.0;
/// Minimum LLR at which two radar tracks are likely to be one aircraft.
pub(super) const MUTUAL_LIKELY_LLR: f64 = 1.0;

// --- Association

/// Minimum LLR at which a radar track is associated with a target.
pub const ASSOCIATE_LLR: f64 = 6.0;
/// LLR at which a radar track and a target are dissociated.
pub const DISSOCIATE_LLR: f64 = -4.0;
/// Hysteresis: minimum LLR advantage of another pair that replaces an existing one.
pub(super) const HYSTERESIS_LLR: f64 = 4.0;
/// Maximum LLR that the log-odds of being a drone add to a pair.
pub(super) const CLASS_LLR_MAX: f64 = 4.0;
/// Maximum time between a plot and a transponder report that are compared, seconds.
pub(super) const COMPARE_WITHIN_S: f64 = 2.0;
/// Time after its last plot for which a radar track takes part, in radar periods.
pub(super) const TRACK_LASTS_PERIODS: f64 = 3.0;

// --- Reacquisition of targets that no sensor sees

/// Minimum LLR at which a radar track that has begun is an unseen target, and not a new one.
pub(super) const REACQUIRE_LLR: f64 = 4.0;
/// Minimum LLR at which a radar track that begins after the slot is an unseen target. It is lower than [`REACQUIRE_LLR`], because
/// no other target remains as a candidate.
pub(super) const REACQUIRE_AHEAD_LLR: f64 = 3.0;
/// LLR above which an unseen target is a candidate for a radar track that begins after the slot.
pub(super) const PLAUSIBLE_LLR: f64 = 0.0;
/// Maximum time from a slot to the beginning of a radar track that is considered for it, seconds.
pub(super) const LOOK_AHEAD_S: f64 = 4.0;
/// Sigma of the position up to which an unseen target can be reacquired, metres. Eight seeds of `gaps`: with 120 m the track
/// number changed 0.17 times a minute in gaps instead of 0.14.
pub(super) const REACQUIRE_SIGMA_MAX_M: f64 = 500.0;
/// Gate of a reacquisition: squared Mahalanobis distance in three dimensions.
pub(super) const REACQUIRE_GATE: f64 = 16.0;

/// LLR of the class below which a radar track is not taken for an unseen target.
pub(super) const PLAUSIBLE_CLASS_LLR: f64 = -1.5;
/// Sigma of the mean class probability between radar tracks of one aircraft, as simulated. Values of 0.06 to 0.11 made no
/// difference.
pub(super) const OWN_CLASS_SIGMA: f64 = 0.09;
/// Share of radar tracks whose class probability is an outlier.
pub(super) const OWN_CLASS_ELSE: f64 = 0.01;
/// Weight of the uniform prior on the distribution of class probabilities, in tracks.
pub(super) const CLASS_EVEN_TRACKS: f64 = 10.0;
/// LLR that a new radar track is the aircraft of known class that was lost there, before position and class count. Measured on 24
/// seeds of `crossing` and `gaps`: with 2, reacquisitions with an LLR of 3 to 12 are wrong as often as the LLR predicts.
pub(super) const OWN_CLASS_LLR: f64 = 2.0;
/// Time over which the class of an aircraft is averaged, seconds.
pub(super) const OWN_CLASS_MEMORY_S: f64 = 12.5;
/// Maximum sigma of the distance, on each axis, between an aircraft and a radar track wrongly taken for it, metres. The aircraft
/// is in the same airspace.
pub(super) const DOUBT_SIGMA_MAX_M: f64 = 200.0;

// --- Existence: drone or not

/// Minimum log-odds at which a radar track is confirmed as a drone.
pub(super) const CONFIRM_LOG_ODDS: f64 = 3.0;
/// Mean class probability with log-odds of zero, for the frequencies of birds and drones in the simulations.
pub(super) const CLASS_NEUTRAL: f64 = 0.57;
/// Log-odds per unit of mean class probability above [`CLASS_NEUTRAL`].
pub(super) const CLASS_SLOPE: f64 = 30.0;
/// Bound of the log-odds from the class probability.
pub(super) const CLASS_LOG_ODDS_MAX: f64 = 6.0;
/// Duration of plots after which the class has its full weight, seconds. Successive class probabilities are correlated.
pub(super) const CLASS_SETTLED_S: f64 = 2.0;
/// Time over which the class probability is averaged, seconds.
pub(super) const CLASS_MEMORY_S: f64 = 60.0;
/// Maximum duration that one plot represents, seconds; otherwise it represents the radar's period.
pub(super) const CLASS_PLOT_MAX_S: f64 = 1.0;
/// Veto: mean class probability below which a radar track is certainly not a drone.
pub(super) const CLASS_NEVER: f64 = 0.01;

/// Number of bins of the class probability in the statistics of a site's own tracks.
pub(super) const CLASS_BINS: usize = 20;
/// Sigma of the class probability between radar tracks of one target, as kernel of the statistics.
pub(super) const CLASS_KERNEL: f64 = 0.03;
/// Time in which the site's class statistics decay to 1/e, seconds.
pub(super) const CLASS_EVIDENCE_S: f64 = 7200.0;
/// Duration of plots after which a radar track enters the site's class statistics, once, seconds.
pub(super) const CLASS_SETTLES_AFTER_S: f64 = 5.0;
/// Mean class probability above which tracks count as drones in the ratio of drones without to drones with a transponder.
pub(super) const CLASS_SURE: f64 = 0.7;
/// Prior number of tracks of drones without and with a transponder.
pub(super) const CLASS_SHARE_PRIOR: (f64, f64) = (2.0, 8.0);
/// Number of tracks per bin attributed to a few drones without a transponder that return again and again.
pub(super) const CLASS_SPARE_TRACKS: f64 = 5.0;
/// LLR of a pair above which a radar track is undecided, and left out of the background statistics.
pub(super) const CLASS_UNDECIDED_LLR: f64 = -6.0;

/// Rate of change of the range: a critically damped second-order Gauss–Markov process.
#[derive(Clone, Copy, Debug)]
pub(super) struct RangeMotion {
    /// Sigma of the range rate, metres a second.
    pub(super) rate_m_s: f64,
    /// Natural frequency of the range rate, radians a second.
    pub(super) turn_rad_s: f64,
    /// Prior probability among drones, or among birds.
    pub(super) share: f64,
}
/// Motions of drones: straight flight or hover; faster flight with turns.
pub(super) const DRONE_MOTIONS: [RangeMotion; 2] = [
    RangeMotion { rate_m_s: 12.0, turn_rad_s: 0.01, share: 0.75 },
    RangeMotion { rate_m_s: 16.0, turn_rad_s: 0.2, share: 0.25 },
];
/// Motion of birds: a wandering course.
pub(super) const BIRD_MOTION: RangeMotion = RangeMotion { rate_m_s: 8.0, turn_rad_s: 0.15, share: 1.0 };
/// Mean time between changes of a drone from one motion to the other, seconds.
pub(super) const MOTION_CHANGE_S: f64 = 15.0;
/// Resolution of the range, metres: 1/256 NM (CAT048, I048/040).
pub(super) const RANGE_STEP_M: f64 = 1852.0 / 256.0;
/// Bound of the log-odds from the motion in one plot.
pub(super) const MOTION_PLOT_LOG_ODDS_MAX: f64 = 1.0;
/// Bound of the summed log-odds from the motion.
pub(super) const MOTION_LOG_ODDS_MAX: f64 = 3.0;

// --- Walk-off: a radar track leaves its aircraft

/// Share of radar tracks that end by walking off their aircraft.
pub(super) const WALK_OFF_SHARE: f64 = 0.2;
/// Root mean square of the speed of a walk-off, metres a second.
pub(super) const WALK_OFF_SPEED_M_S: f64 = 10.0;
/// Minimum and maximum duration of a walk-off before the track ends, seconds.
pub(super) const WALK_OFF_LASTS_S: [f64; 2] = [4.0, 10.0];
/// Rate of walk-offs of a radar track, per second.
pub(super) const WALK_OFFS_HZ: f64 = 1.0 / 70.0;
/// Time without a plot after which a radar track has ended, seconds. The longer of this and [`TRACK_LASTS_PERIODS`] applies.
pub(super) const ENDED_AFTER_S: f64 = 2.5;
/// Maximum time after a slot from which reports count as known when the slot is computed, seconds.
pub(super) const KNOWN_AHEAD_S: f64 = 6.0;

// --- Initiation

/// LLR with every nearby transponder below which a radar track becomes a target of its own. A second track of a known aircraft
/// would be a ghost.
pub(super) const NOBODYS_LLR: f64 = -8.0;
/// Time for which a radar track that was likely a known target does not become a target of its own. It has most often walked off,
/// which takes 4 to 10 s.
pub(super) const INITIATION_HOLD: SignedDuration = SignedDuration::from_secs(10);
/// Maximum time after the last plot and before the first one for which a target that only radars see is published, seconds.
pub(super) const COAST_MAX_S: f64 = 2.0;

// --- Filter

/// Transponder silence after which radar plots enter a target's filter, seconds. While the transponder reports, plots increase
/// the error by up to 10 % (measured).
pub(super) const TRANSPONDER_SILENT_S: f64 = 5.0;
/// Minimum sigma of a radar track's velocity on each axis, metres a second, as computed by the radar's tracker.
pub(super) const RADAR_VELOCITY_M_S: f64 = 1.5;
/// Correlation time of the error of a radar track's velocity, seconds.
pub(super) const RADAR_VELOCITY_CORRELATION_S: f64 = 3.0;

// --- Cameras

/// Age up to which bearings of a camera are kept, before the published slot.
pub(super) const CAMERA_KEPT: SignedDuration = SignedDuration::from_secs(12);
/// Minimum time between two bearings of one camera track that are used, seconds. A camera's error lasts for a few frames.
pub(super) const CAMERA_LOOK_S: f64 = 0.45;
/// Time without a bearing after which a camera's track has ended, seconds.
pub(super) const CAMERA_ENDS_S: f64 = 10.0;
/// Width of the field in which another object would appear with uniform probability, radians (20°).
pub(super) const CAMERA_FIELD: f64 = 0.349;
/// Bound of the LLR of one bearing.
pub(super) const CAMERA_LOOK_LLR_MAX: f64 = 2.0;
/// Bound of the summed LLR of a camera's track and a target.
pub(super) const CAMERA_LLR_MAX: f64 = 12.0;
/// Minimum summed LLR at which a camera's track follows a target.
pub(super) const CAMERA_FOLLOW_LLR: f64 = 6.0;
/// Minimum LLR advantage of the followed target over all others.
pub(super) const CAMERA_MARGIN_LLR: f64 = 3.0;
/// Minimum angle over which a target has moved before its looks determine an orientation, radians (3°). Any hovering target explains
/// any hovering track.
pub(super) const CAMERA_SPAN: f64 = 0.052;
/// Minimum number of looks of a pair that determines an orientation.
pub(super) const CAMERA_WITNESS_LOOKS: u64 = 30;
/// Minimum number of looks, and angle, radians (10°), of a pair that determines one alone.
pub(super) const CAMERA_ALONE_LOOKS: u64 = 120;
pub(super) const CAMERA_ALONE_SPAN: f64 = 0.175;
/// Maximum squared distance of two orientations that agree: 99 % with three degrees of freedom.
pub(super) const CAMERA_AGREE2: f64 = 11.3;
/// LLR of a pair against a camera's known orientation, and for its own one, at which it may have turned.
pub(super) const CAMERA_TURNED_LLR: f64 = 10.0;
/// Minimum time without a look that fits, after which a camera may have turned, seconds.
pub(super) const CAMERA_TURNED_S: f64 = 15.0;
/// Minimum ground distance from a camera at which its angles are used, metres.
pub(super) const CAMERA_NEAR_M: f64 = 5.0;
/// Ratio between quantised distances of a bearing, so that nearly equal distances do not repeat the filtering.
pub(super) const CAMERA_RANGE_STEP: f64 = 1.05;
/// Ratio between quantised distances where another camera looks from another side, so that the distance is known well.
pub(super) const CAMERA_CROSSED_STEP: f64 = 1.001;

/// Maximum time between two looks of a camera's track between which its direction is interpolated, seconds.
pub(super) const CAMERA_BETWEEN_S: f64 = 1.5;
/// Error of an interpolated direction, as a share of its change between the two looks: with one look on either side, and with two.
pub(super) const CAMERA_BETWEEN_SHARE: [f64; 2] = [0.03, 0.01];
/// Standard deviation of the time stamps of a camera, seconds.
pub(super) const CAMERA_CLOCK_S: f64 = 0.02;
/// Variance of an angle that no learning of the orientation removes, radians² (0.03°).
pub(super) const CAMERA_LASTING2: f64 = 2.7e-7;
/// Bound of the standard deviation of a position by lasting errors, metres: for lines that are nearly parallel.
pub(super) const CAMERA_LASTING_MAX_M: f64 = 100.0;
/// Minimum sine of the angle over ground between two lines of sight that cross (8°). Below it lasting errors shift the crossing by more than
/// a linear error model covers.
pub(super) const CAMERA_CROSSING_SINE: f64 = 0.14;
/// Maximum elevation of a line of sight that crosses another, radians (80°). Azimuths mean little near the zenith.
pub(super) const CAMERA_ELEVATION_MAX: f64 = 1.396;
/// Maximum time between the looks of two cameras that together measure a position, seconds.
pub(super) const CAMERA_TOGETHER_S: f64 = 1.0;
/// Correlation time of the lasting errors of a camera, seconds.
pub(super) const CAMERA_CORRELATION_S: f64 = 20.0;
/// Maximum number of tracks of one camera that may begin targets at a time.
pub(super) const CAMERA_FREE_MAX: usize = 16;
/// Maximum number of pairs of tracks that may begin targets at a time.
pub(super) const CAMERA_PAIRS_MAX: usize = 2048;
/// Minimum LLR, number of looks, and time from the first to the last of them, seconds, at which a pair of tracks begins a target.
pub(super) const CAMERA_START_LLR: f64 = 4.0;
pub(super) const CAMERA_START_LOOKS: u32 = 8;
pub(super) const CAMERA_START_S: f64 = 4.0;
/// Maximum standard deviation of the position at which a pair of tracks begins a target: mean of the axes, metres.
pub(super) const CAMERA_START_SIGMA_M: f64 = 20.0;
/// LLR of the pair below which a target that only its two cameras see ends.
pub(super) const CAMERA_END_LLR: f64 = -2.0;
/// Maximum climb of a drone, metres a second, and its acceleration, metres a second squared.
pub(super) const DRONE_CLIMB_MAX_M_S: f64 = 12.0;
pub(super) const DRONE_ACCELERATION_MAX_M_S2: f64 = 12.0;
/// Time over which a speed is measured from crossings, seconds.
pub(super) const CAMERA_SPEED_S: f64 = 1.5;
/// Time between looks of a third camera that decide between pairs, seconds, and the bounds of the LLR of one of them and of all.
pub(super) const CAMERA_THIRD_S: f64 = 2.0;
pub(super) const CAMERA_THIRD_LLR: [f64; 2] = [-4.0, 3.0];
pub(super) const CAMERA_THIRD_LLR_MAX: f64 = 8.0;

// --- Radar tracks whose numbers jump

/// Maximum number of radar tracks that begin under one number in one slot. A radar gives a number to one object at a time.
pub(super) const BEGUN_MAX: usize = 4;
/// Maximum number of unassigned tracks of a radar whose numbers already belong to later tracks. A radar that ends all its
/// tracks at once stays below it, unless it has many.
pub(super) const SUPERSEDED_MAX: usize = 256;

// --- Threads

/// Minimum number of radar tracks or targets that are shared between threads. One takes microseconds, as does the start of a
/// thread.
pub(super) const THREAD_LEAST: usize = 100;

// --- Output

/// Sigma of the position up to which an aircraft with a silent transponder, unseen by radar, is published, metres. The radius
/// that holds 95 % of its positions is then 250 m: by judgement the most that is useful to a client.
pub(super) const UNSEEN_SIGMA_MAX_M: f64 = 102.0;
/// Sigma of the position up to which an aircraft is shown in the picture "now", metres. The radius that holds 95 % of its
/// positions is then 61 m. By judgement.
pub(super) const NOW_SIGMA_MAX_M: f64 = 25.0;
/// Maximum sigma in the picture "now" of an aircraft that only radars see, in sigmas of its plots; [`NOW_RADAR_SIGMA_M`] is
/// added. It also applies to the accuracy that a transponder states.
pub(super) const NOW_RADAR_SIGMAS: f64 = 1.1;
/// Addition to the maximum sigma by [`NOW_RADAR_SIGMAS`], metres.
pub(super) const NOW_RADAR_SIGMA_M: f64 = 10.0;
/// Maximum number of published competitors of each kind.
pub(super) const COMPETITORS_MAX: usize = 3;
/// Track numbers per transponder number T: a fused track has the number T · this + R, with the radar's track number R.
pub(super) const NUMBERS_PER_TRANSPONDER: u32 = 10_000;
/// Lowest track number above those of radars (0 to 4095, I048/161).
pub(super) const FIRST_FREE_NUMBER: u32 = 4096;

// --- Registration

/// Number of independent samples of a bias at which half of an improvement over the data sheet is applied (as logarithm).
pub(super) const CAUTIOUS_SAMPLES: f64 = 10.0;

/// Length of the segments in which a radar track contributes to the registration, seconds. A wrong association spoils one
/// segment.
pub(super) const SEGMENT_S: f64 = 10.0;
/// Prior sigma of a radar's range misalignment, metres; the radar is set up by compass and spirit level.
pub(super) const MISALIGNMENT_RANGE_M: f64 = 5.0;
/// Prior sigma of a radar's azimuth misalignment, radians.
pub(super) const MISALIGNMENT_AZIMUTH_RAD: f64 = 1.0_f64.to_radians();
/// Prior sigma of a radar's height misalignment, metres.
pub(super) const MISALIGNMENT_HEIGHT_M: f64 = 5.0;
/// Distance north of a radar at which its remaining misalignment is evaluated for all its tracks, metres.
pub(super) const REMAINING_AT_NORTH_M: f64 = 1500.0;
/// Height above a radar at which its remaining misalignment is evaluated for all its tracks, metres.
pub(super) const REMAINING_AT_UP_M: f64 = 100.0;
/// Relative step of a radar's errors, so that nearly equal errors do not repeat the filtering.
pub(super) const ERROR_STEP: f64 = 0.01;
/// Half of the interval over which a transponder's velocity is computed from its positions, seconds.
pub(super) const VELOCITY_HALF_BASE_S: f64 = 0.5;
/// Minimum ground distance from a radar at which its azimuth is compared, metres.
pub(super) const NEAR_M: f64 = 100.0;
/// Maximum ratio of height to ground distance at which a radar's azimuth is compared.
pub(super) const STEEP: f64 = 2.0;

// --- Transponder identities of one aircraft

/// Maximum distance between transponders that are compared, metres.
pub(super) const SAME_NEAR_M: f64 = 60.0;
/// Maximum number of nearest transponders that each one is compared with.
pub(super) const SAME_CANDIDATES_MAX: usize = 4;
/// Minimum speed of both transponders at which a comparison begins, metres a second. Slower motion adds no distance flown.
pub(super) const SAME_SPEED_MIN_M_S: f64 = 2.0;
/// Minimum time of agreement before two identities are linked, seconds.
pub(super) const SAME_SPAN_S: f64 = 45.0;
/// Minimum number of looks in agreement before two identities are linked.
pub(super) const SAME_LOOKS: u32 = 25;
/// Minimum distance flown in agreement before two identities are linked, metres.
pub(super) const SAME_FLOWN_M: f64 = 100.0;
/// Minimum LLR at which two identities are linked. In random draws with slow errors of 1.8 m on each axis, 2 % of aircraft were
/// not linked after a minute, and 0.6 % of the time later. Pairs 5 m apart were linked for 60 % of the time, 8 m apart for 9 %,
/// 15 m apart never.
pub(super) const SAME_LINK_LLR: f64 = 2.0;
/// LLR below which the link of two identities ends.
pub(super) const SAME_LEAVE_LLR: f64 = 1.0;
/// Maximum distance between two linked identities, in sigmas of the errors of both.
pub(super) const SAME_APART_SIGMAS: f64 = 5.0;
/// Number of successive looks beyond [`SAME_APART_SIGMAS`] at which the link ends.
pub(super) const SAME_APART_LOOKS: u32 = 3;
/// Time with a track of each identity by one radar after which the link ends, in looks of a second.
pub(super) const SAME_TWO_TRACKS_S: u32 = 10;
/// Difference of heights, in sigmas, above which two identities are two aircraft or use two height references.
pub(super) const SAME_HEIGHT_SIGMAS: f64 = 3.0;
/// Sigma of the distance between two antennas of one aircraft, each axis, metres.
pub(super) const SAME_MOUNT_M: f64 = 1.0;
/// Maximum sigma of interpolation and white noise, on each axis, of a look that counts, metres.
pub(super) const SAME_LOOK_SIGMA_MAX_M: f64 = 5.0;
/// Time constant of the slow errors of a GNSS receiver, seconds.
pub(super) const SAME_SLOW_S: f64 = 60.0;
/// Time constant of the mean over the looks, in looks of a second.
pub(super) const SAME_MEMORY_S: f64 = 300.0;
/// Prior density of aircraft that fly alongside another: one within 40 m, 1/m². Aircraft observed within [`SAME_CROWD_M`] are
/// added.
pub(super) const SAME_NEIGHBOURS_PER_M2: f64 = 2e-4;
/// Radius within which the aircraft around a pair are counted, metres.
pub(super) const SAME_CROWD_M: f64 = 40.0;
/// Approximate distance that aircraft keep from each other, metres.
pub(super) const SAME_SPACING_M: f64 = 5.0;
/// Time without a look after which evidence on two unlinked identities is dropped, seconds.
pub(super) const SAME_FORGOTTEN_S: f64 = 30.0;
/// Ratio of sigmas up to which a poorer position is weighted by 1/sigma; beyond it, far less. Three seeds of ten drones with
/// CAT129 and Remote ID: the error relative to the better transponder was 0.86, at worst 0.98. With weights by the squared
/// variance and without gaps it was 1.02 and 1.75.
pub(super) const SAME_COMPARABLE: f64 = 2.0;
/// Gap between reports beyond which a position has hardly any weight, seconds.
pub(super) const SAME_GAP_S: f64 = 2.0;
/// Maximum gap between reports that reduces the weight further, seconds.
pub(super) const SAME_GAP_MAX_S: f64 = 100.0;
/// Silence of the leading identity after which another one represents the aircraft, seconds.
pub(super) const SAME_LEADER_SILENT_S: f64 = 10.0;
