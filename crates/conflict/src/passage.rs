//! Probability that two aircraft are inside a volume at any time within the horizon.
//!
//! The aircraft fly straight on with probability s, and turn otherwise. Each part is a line with normal errors. For each distance across the relative velocity, the chord of
//! the volume at that distance is the time spent inside over ground. The probability is the integral, over that distance,
//! of the probability that the aircraft are on the chord within the horizon and, meanwhile, within the volume's height.

use nalgebra::{Matrix2, Vector2};

use super::encounter::{Relative, Vertical};
use super::extrapolation::Extrapolation;
use super::interval::{Course, CrossSection};
use super::motion::PairMotion;
use super::normal::{HALF_RULE, TAIL, above_both, at_most_beyond, at_most_within, below, within};
use super::volume::Volume;

/// Part of a probability that is neglected.
const NEGLIGIBLE: f64 = 1e-5;
/// Standard deviations beyond which an end of the horizon has no influence.
const CERTAIN: f64 = 3.1;
/// Ratio of the climb to its standard deviation above which its sign is certain.
const CERTAIN_CLIMB: f64 = 2.5;
/// Effect of the climb's error on the height during a passage, as a share of the error of the height, up to which the
/// heights at both ends count as equal but for the expected climb.
const SHORT: f64 = 0.3;
/// Ratio of the error along the velocity to the radius from which on the chord at the middle stands for all.
const SOFT: f64 = 0.7;
/// Ratio of the relative speed to the standard deviation of each axis below which its direction is uncertain.
const SLOW: f64 = 4.0;

/// Rings on which velocities of uncertain direction are sampled: radii in standard deviations, and weights.
const RINGS: [(f64, f64); 2] =
    [(1.082_392_200_292_394, 0.853_553_390_593_273_8), (2.613_125_929_752_753, 0.146_446_609_406_726_24)];
/// Number of velocities on each ring.
const STEPS: u32 = 6;

/// Whether a relative speed of this square, m²/s², has an uncertain direction. `rate_m2s2` is the sum of the variances of
/// both axes.
pub(super) fn is_slow(square: f64, rate_m2s2: f64) -> bool {
    square < SLOW * SLOW * rate_m2s2 / 2.0
}

/// The expected passage of two aircraft through a volume, and its probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Probability of being inside the volume at any time within the horizon; 0 if it is less than the minimum asked for.
    pub probability: f64,
    /// Time to the expected entry, seconds, from 0 to the horizon. If the expected motion misses the volume: to the time at
    /// which it comes nearest.
    pub entry_s: f64,
    /// Time to the expected exit, seconds, at most the horizon; `None`: the expected motion misses the volume.
    pub exit_s: Option<f64>,
}

impl Relative {
    /// The passage through a volume of a pair of which only the present state is known. Probabilities below `least` count
    /// as 0.
    pub fn passage(&self, volume: &Volume, ahead: &Extrapolation, least: f64) -> Passage {
        PairMotion::unknown(self, ahead).passage(volume, ahead, least)
    }

    /// Time at which an expected motion that misses the volume is nearest to it: over ground it is `near_s` at the
    /// earliest; while the aircraft are that near, a climb may bring them nearer.
    fn nearest_s(&self, volume: &Volume, course: &Course, near_s: f64, horizon_s: f64) -> f64 {
        let section = volume.section();
        let leaves_s = section
            .chord(course.across_m, course.speed)
            .map_or(near_s, |chord| course.time_at(chord.behind_m).clamp(near_s, horizon_s));
        let Some(Vertical { height_m, climb, .. }) = self.vertical else { return near_s };
        match super::interval::interval_in_height(height_m, climb, volume.vertical_m) {
            Some(inside) if inside.exit_s >= near_s => inside.entry_s.clamp(near_s, leaves_s),
            _ => near_s,
        }
    }
}

/// Time of the expected entry over ground, seconds: that of the closest approach (and with tau, that time ahead of it) if
/// the aircraft pass outside.
fn nearest_s(course: &Course, section: &CrossSection, horizon_s: f64) -> f64 {
    if course.speed <= 0.0 {
        return 0.0;
    }
    let across_m = course.across_m.clamp(-section.radius_m, section.radius_m);
    let ahead_m = section.chord(across_m, course.speed).map_or(0.0, |chord| chord.ahead_m);
    course.time_at(-ahead_m).clamp(0.0, horizon_s)
}

impl PairMotion {
    /// The passage through a volume. Probabilities below `least` count as 0.
    pub(super) fn passage(&self, volume: &Volume, ahead: &Extrapolation, least: f64) -> Passage {
        let horizon_s = ahead.horizon_s;
        let section = volume.section();
        let steady = &self.steady;
        let course = Course::of(&steady.position, &steady.velocity);
        let near_s = nearest_s(&course, &section, horizon_s);
        let probability = self.probability(volume, ahead, course, near_s, least);
        let (entry_s, exit_s) = match volume.interval(steady, horizon_s) {
            Some(inside) => (inside.entry_s, Some(inside.exit_s)),
            None => (steady.nearest_s(volume, &course, near_s, horizon_s), None),
        };
        Passage { probability, entry_s, exit_s }
    }

    /// Probability of the passage; `near_s` is the time of the expected entry over ground in straight flight, seconds.
    fn probability(
        &self,
        volume: &Volume,
        ahead: &Extrapolation,
        course: Course,
        near_s: f64,
        least: f64,
    ) -> f64 {
        let Self { steady, ratios: [place, rate], level, turning, away, .. } = self;
        let share = self.share_at(near_s);
        let straight = |relative| {
            let errors = Errors::of(relative, *place, *rate, 0.0);
            Chances::of(relative, volume, ahead.horizon_s, course, errors, true)
        };
        let levels_off = level.as_ref().map_or(0.0, |(levels_off, _)| *levels_off);
        let turned = Course::of(&turning.position, &turning.velocity);
        let turned_s = nearest_s(&turned, &volume.section(), ahead.horizon_s);
        // Added for each of the two aircraft.
        let errors = Errors::of(turning, 1.0, 1.0, 2.0 * ahead.grown_m2(turned_s));
        let parts = [
            Some(((1.0 - levels_off) * share, straight(steady))),
            level.as_ref().map(|(levels_off, level)| (levels_off * share, straight(level))),
            Some((
                (1.0 - share) * away,
                Chances::of(turning, volume, ahead.horizon_s, turned, errors, false),
            )),
        ];
        // Upper bounds, so that negligible probabilities are not computed.
        let bounds = parts
            .each_ref()
            .map(|part| part.as_ref().map_or(0.0, |(weight, chances)| weight * chances.at_most()));
        if bounds.iter().sum::<f64>() < least {
            return 0.0;
        }
        let of_part = |(part, bound): (&Option<(f64, Chances<'_>)>, f64)| {
            part.as_ref()
                .filter(|_| bound >= NEGLIGIBLE)
                .map_or(0.0, |(weight, part)| weight * part.probability())
        };
        let probability: f64 = parts.iter().zip(bounds).map(of_part).sum();
        if probability < least { 0.0 } else { probability.min(1.0) }
    }
}

/// Everything from which the probability of a passage in a straight line follows.
struct Chances<'a> {
    relative: &'a Relative,
    volume: &'a Volume,
    horizon_s: f64,
    course: Course,
    errors: Errors,
    flight: Flight,
    /// Heights and their errors; `None`: the height of one aircraft is not known.
    heights: Option<Heights>,
    /// Whether the direction of the relative velocity is uncertain.
    is_slow: bool,
}

impl<'a> Chances<'a> {
    /// The direction of the velocity matters only if both fly straight on.
    fn of(
        relative: &'a Relative,
        volume: &'a Volume,
        horizon_s: f64,
        course: Course,
        errors: Errors,
        is_straight: bool,
    ) -> Self {
        let flight = Flight::of(&course, &errors, horizon_s);
        let heights = relative.vertical.map(Heights);
        let is_slow = is_straight && is_slow(course.speed * course.speed, errors.rate.trace());
        Self { relative, volume, horizon_s, course, errors, flight, heights, is_slow }
    }

    /// Upper bound of the probability.
    fn at_most(&self) -> f64 {
        let over_ground = if self.is_slow { 1.0 } else { self.flight.at_most(self.volume.horizontal_m) };
        let above = self.heights.as_ref().map_or(1.0, |heights| {
            let [from_s, until_s] = self.longest_s();
            heights.at_most(self.volume.vertical_m, from_s, until_s, self.most_early_s2())
        });
        over_ground * above
    }

    fn probability(&self) -> f64 {
        let section = self.volume.section();
        let heights = self.heights.as_ref().map(|heights| (heights, self.volume.vertical_m));
        if self.is_slow {
            return self.errors.slow(self.relative, &section, heights, self.horizon_s);
        }
        self.flight.inside(&section, heights)
    }

    /// Upper bound of the variance of the time of the passage, s².
    fn most_early_s2(&self) -> f64 {
        let Self { course, horizon_s, errors: Errors { place, both, rate, grown_m2 }, .. } = self;
        let closest_s = course.time_at(0.0).clamp(0.0, *horizon_s);
        let both = (2.0 * both.trace()).max(0.0);
        let most_m2 = place.trace() + closest_s * (both + closest_s * rate.trace()) + grown_m2;
        (most_m2 / (course.speed * course.speed)).min(closest_s * closest_s / 4.0)
    }

    /// Begin and end of the longest passage over ground, through the centre of the volume, seconds.
    fn longest_s(&self) -> [f64; 2] {
        let Self { volume, horizon_s, course, .. } = self;
        let chord = volume.section().chord_of(volume.horizontal_m, course.speed);
        [-chord.ahead_m, chord.behind_m].map(|along_m| course.time_at(along_m).clamp(0.0, *horizon_s))
    }
}

/// Errors of relative position and velocity over ground: covariances in m², m²/s and m²/s².
#[derive(Clone, Copy)]
struct Errors {
    place: Matrix2<f64>,
    both: Matrix2<f64>,
    rate: Matrix2<f64>,
    /// Variance that random acceleration adds until the entry, on each axis, m².
    grown_m2: f64,
}

impl Errors {
    /// The stated errors, with these ratios of the deviations of position and velocity.
    fn of(relative: &Relative, place: f64, rate: f64, grown_m2: f64) -> Self {
        let block = |row: usize, column: usize| relative.covariance.fixed_view::<2, 2>(row, column);
        Self {
            place: block(0, 0) * (place * place),
            both: block(0, 2) * (place * rate),
            rate: block(2, 2) * (rate * rate),
            grown_m2,
        }
    }

    /// Covariance along `a` and `b` after `t` seconds of straight flight, m².
    fn after(&self, t: f64, a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
        let both = a.dot(&(self.both * b)) + b.dot(&(self.both * a));
        a.dot(&(self.place * b)) + t * (both + t * a.dot(&(self.rate * b)))
    }

    /// Probability of being inside for a velocity of uncertain direction: the mean over twelve velocities, six on each of
    /// two rings (the Gauss-Laguerre rule with two points), each with the errors of the position given that velocity.
    fn slow(
        &self,
        relative: &Relative,
        section: &CrossSection,
        heights: Option<(&Heights, f64)>,
        horizon_s: f64,
    ) -> f64 {
        let Some((root, inverse)) = self.rate.cholesky().map(|root| (root.l(), root.inverse())) else {
            return 0.0;
        };
        let gain = self.both * inverse;
        let given = Self {
            place: self.place - gain * self.both.transpose(),
            both: Matrix2::zeros(),
            rate: Matrix2::zeros(),
            grown_m2: 0.0,
        };
        let of = |away: Vector2<f64>| {
            let away = root * away;
            let course = Course::of(&(relative.position + gain * away), &(relative.velocity + away));
            Flight::of(&course, &given, horizon_s).inside(section, heights)
        };
        let ring = |&(radius, weight): &(f64, f64)| {
            let on_ring = |step: u32| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(step) / f64::from(STEPS));
                of(Vector2::new(cos, sin) * radius)
            };
            weight / f64::from(STEPS) * (0..STEPS).map(on_ring).sum::<f64>()
        };
        RINGS.iter().map(ring).sum()
    }
}

/// Position along the velocity at one time, given the distance across it.
#[derive(Clone, Copy)]
struct Along {
    /// Expected coordinate at the expected distance across, metres.
    mean_m: f64,
    /// Change of the coordinate with the distance across.
    slope: f64,
    /// Standard deviation, metres.
    sigma_m: f64,
}

impl Along {
    fn at(&self, across_m: f64) -> f64 {
        self.mean_m + self.slope * across_m
    }
}

/// Motion over ground with its errors, in axes along and across the velocity.
struct Flight {
    course: Course,
    horizon_s: f64,
    /// Variance of the distance across at the closest approach, m².
    across_m2: f64,
    /// Position along now and at the horizon.
    now: Along,
    then: Along,
    /// Variance of the position along at the closest approach, m².
    timing_m2: f64,
}

impl Flight {
    fn of(course: &Course, errors: &Errors, horizon_s: f64) -> Self {
        let (along, across) = (course.along, course.across());
        let closest_s =
            if course.speed > 0.0 { (-course.along_m / course.speed).clamp(0.0, horizon_s) } else { 0.0 };
        let end = |t: f64, grown_m2: f64| {
            let across_m2 = errors.after(t, &across, &across) + grown_m2;
            let both_m2 = errors.after(t, &along, &across);
            let slope = if across_m2 > 0.0 { both_m2 / across_m2 } else { 0.0 };
            let along_m2 = errors.after(t, &along, &along) + grown_m2 - slope * both_m2;
            Along { mean_m: course.along_m + course.speed * t, slope, sigma_m: along_m2.max(0.0).sqrt() }
        };
        Self {
            course: *course,
            horizon_s,
            across_m2: errors.after(closest_s, &across, &across) + errors.grown_m2,
            now: end(0.0, 0.0),
            then: end(horizon_s, errors.grown_m2),
            timing_m2: errors.after(closest_s, &along, &along) + errors.grown_m2,
        }
    }

    /// Upper bound of [`Self::inside`].
    fn at_most(&self, radius_m: f64) -> f64 {
        at_most_within(radius_m, self.course.across_m, self.across_m2)
    }

    /// Probability of being inside over ground and in height.
    fn inside(&self, section: &CrossSection, heights: Option<(&Heights, f64)>) -> f64 {
        let Self { course, across_m2, now, then, .. } = self;
        let has_begun = now.mean_m + CERTAIN * now.sigma_m < 0.0;
        let is_over = then.mean_m - CERTAIN * then.sigma_m > -section.tau_s * course.speed;
        let middle_m = course.across_m.clamp(-0.7 * section.radius_m, 0.7 * section.radius_m);
        let is_short = heights.is_none_or(|(heights, _)| {
            let [from_s, until_s] = self.passage_s(section, middle_m);
            heights.is_short(from_s, until_s)
        });
        // No end of the horizon and no climb distinguishes one chord from another.
        if has_begun && is_over && is_short {
            let over_ground = within(section.radius_m, course.across_m, *across_m2);
            return over_ground * self.in_height(section, heights, middle_m);
        }
        // Where the errors along the velocity are as large as the chords, the chord at the middle stands for all.
        let is_soft = |is_certain: bool, end: &Along| is_certain || end.sigma_m >= SOFT * section.radius_m;
        if is_short && is_soft(has_begun, now) && is_soft(is_over, then) {
            let over_ground = within(section.radius_m, course.across_m, *across_m2);
            return if over_ground < NEGLIGIBLE {
                0.0
            } else {
                over_ground * self.on_chord(section, heights, middle_m)
            };
        }
        let sigma_m = across_m2.max(0.0).sqrt();
        let radius_m = section.radius_m;
        if sigma_m <= 0.0 {
            return if course.across_m.abs() <= radius_m {
                self.on_chord(section, heights, course.across_m)
            } else {
                0.0
            };
        }
        let (low, high) = (
            (course.across_m - TAIL * sigma_m).max(-radius_m),
            (course.across_m + TAIL * sigma_m).min(radius_m),
        );
        if low >= high {
            return 0.0;
        }
        // Over the angle at which the circle is seen, in which the chord is smooth.
        let (low, high) = (libm::asin(low / radius_m), libm::asin(high / radius_m));
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        let slice = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            let away = (radius_m * sin - course.across_m) / sigma_m;
            cos * libm::exp(-away * away / 2.0) * self.on_chord(section, heights, radius_m * sin)
        };
        let sum: f64 = HALF_RULE
            .iter()
            .map(|&(at, weight)| weight * (slice(middle - half * at) + slice(middle + half * at)))
            .sum();
        half * radius_m * sum / (sigma_m * std::f64::consts::TAU.sqrt())
    }

    /// Probability of being on the chord within the horizon and meanwhile within the height.
    fn on_chord(&self, section: &CrossSection, heights: Option<(&Heights, f64)>, across_m: f64) -> f64 {
        let Self { course, now, then, .. } = self;
        let Some(chord) = section.chord(across_m, course.speed) else { return 0.0 };
        let away_m = across_m - course.across_m;
        let has_passed = 1.0 - below(chord.behind_m, now.at(away_m), now.sigma_m);
        let is_ahead = below(-chord.ahead_m, then.at(away_m), then.sigma_m);
        let over_ground = (1.0 - has_passed - is_ahead).max(0.0);
        if over_ground < NEGLIGIBLE { 0.0 } else { over_ground * self.in_height(section, heights, across_m) }
    }

    /// Probability of being within the height during the passage at this distance across.
    fn in_height(&self, section: &CrossSection, heights: Option<(&Heights, f64)>, across_m: f64) -> f64 {
        heights.map_or(1.0, |(heights, half_m)| {
            let [from_s, until_s] = self.passage_s(section, across_m);
            // An early or late passage finds the aircraft at another height, but not beyond the limits of the horizon.
            let limit_s = from_s.min(self.horizon_s - until_s) / 2.0;
            let early_s2 = if limit_s > 0.0 {
                (self.timing_m2 / (self.course.speed * self.course.speed)).min(limit_s * limit_s)
            } else {
                0.0
            };
            heights.within(half_m, from_s, until_s, early_s2)
        })
    }

    /// Expected begin and end of the passage at this distance across, seconds.
    fn passage_s(&self, section: &CrossSection, across_m: f64) -> [f64; 2] {
        let chord = section.chord(across_m, self.course.speed);
        let [from_m, until_m] = chord.map_or([0.0; 2], |chord| [-chord.ahead_m, chord.behind_m]);
        [from_m, until_m].map(|along_m| self.course.time_at(along_m).clamp(0.0, self.horizon_s))
    }
}

/// Relative height in straight flight, with its real errors.
struct Heights(Vertical);

impl Heights {
    fn at(&self, t: f64) -> f64 {
        self.0.height_m + self.0.climb * t
    }

    /// Covariance of the heights at two times, m².
    fn between_m2(&self, one: f64, other: f64) -> f64 {
        let [hh, hc, cc] = self.0.covariance;
        hh + (one + other) * hc + one * other * cc
    }

    /// Whether an error of the climb matters little during a passage.
    fn is_short(&self, from_s: f64, until_s: f64) -> bool {
        let middle_s = (from_s + until_s) / 2.0;
        let half_s = (until_s - from_s) / 2.0;
        let [.., cc] = self.0.covariance;
        half_s * half_s * cc <= SHORT * SHORT * self.between_m2(middle_s, middle_s)
            && half_s * self.0.climb.abs() <= SHORT * self.between_m2(middle_s, middle_s).max(0.0).sqrt()
    }

    /// Upper bound of [`Self::within`].
    fn at_most(&self, half_m: f64, from_s: f64, until_s: f64, early_s2: f64) -> f64 {
        let (from_m, until_m) = (self.at(from_s), self.at(until_s));
        let away_m = if from_m * until_m <= 0.0 { 0.0 } else { from_m.abs().min(until_m.abs()) };
        // Between two times, the variance is at most that at one of them.
        let most_m2 = self.between_m2(from_s, from_s).max(self.between_m2(until_s, until_s));
        let most_m2 =
            if self.0.climb == 0.0 { most_m2 } else { most_m2 + self.0.climb * self.0.climb * early_s2 };
        // The heights can come near at the begin and at the end.
        (2.0 * at_most_beyond(away_m - half_m, most_m2)).min(1.0)
    }

    /// Probability that the heights differ by at most `half_m` at any time from `from_s` to `until_s`, with an error of
    /// both times of this variance, s².
    fn within(&self, half_m: f64, from_s: f64, until_s: f64, early_s2: f64) -> f64 {
        let early_m2 = self.0.climb * self.0.climb * early_s2;
        let sigma = |t: f64| (self.between_m2(t, t) + early_m2).max(0.0).sqrt();
        let [.., cc] = self.0.covariance;
        // The height is a line over time: it stays outside if it is above, or below, at both ends.
        if self.0.climb * self.0.climb >= CERTAIN_CLIMB * CERTAIN_CLIMB * cc || self.is_short(from_s, until_s)
        {
            let (low_s, high_s) = if self.0.climb >= 0.0 { (from_s, until_s) } else { (until_s, from_s) };
            let not_above = below(half_m, self.at(low_s), sigma(low_s));
            return (not_above - below(-half_m, self.at(high_s), sigma(high_s))).max(0.0);
        }
        let sigmas = [sigma(from_s), sigma(until_s)];
        let correlation = (self.between_m2(from_s, until_s) + early_m2) / (sigmas[0] * sigmas[1]);
        let means = [self.at(from_s), self.at(until_s)];
        let beyond = |sign: f64| {
            let [one, other] = [0, 1].map(|end| (half_m - sign * means[end]) / sigmas[end]);
            above_both(one, other, correlation)
        };
        (1.0 - beyond(1.0) - beyond(-1.0)).max(0.0)
    }
}
