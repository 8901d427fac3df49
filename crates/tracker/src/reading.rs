//! Measurement of one sensor at one instant, with the covariance of its noise.

use nalgebra::{Matrix2, Matrix3, Matrix4, Vector3};

use super::quantity::{Observer, Quantity};
use fusion::frames::Enu;
use fusion::report::SensorIndex;
use fusion::time::Time;

/// Maximum number of values in a reading: those of a radar with range rate.
pub(super) const MOST: usize = 4;

/// Minimum angle at which two lines of sight determine a distance, radians.
const CROSSING: f64 = 5.0_f64.to_radians();

/// Time and sensor of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingOrigin {
    /// Time of the measurement.
    pub time: Time,
    /// Sensor of the measurement. Readings of one instant are filtered in the order of their sensors.
    pub sensor: SensorIndex,
    /// Position and velocity of the sensor at that time.
    pub observer: Observer,
}

/// One measured value with independent noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredValue {
    /// Measured quantity.
    pub quantity: Quantity,
    /// Value, in metres, radians or metres a second.
    pub value: f64,
    /// Standard deviation of the noise, in the same unit.
    pub sigma: f64,
}

/// Simultaneous values of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    taken: ReadingOrigin,
    values: Vec<(Quantity, f64)>,
    /// Covariance of the noise, with a row and a column for each value.
    noise: Matrix4<f64>,
}

impl Reading {
    /// Creates a reading of values with independent noise. `None` without values, with more than four, or with a value
    /// that is not finite or has no noise.
    pub fn independent(taken: ReadingOrigin, measured: &[MeasuredValue]) -> Option<Self> {
        let mut noise = Matrix4::zeros();
        for (index, MeasuredValue { sigma, .. }) in measured.iter().enumerate().take(MOST) {
            noise[(index, index)] = sigma * sigma;
        }
        let values = measured.iter().map(|MeasuredValue { quantity, value, .. }| (*quantity, *value));
        Self::checked(taken, values.collect(), noise)
    }

    /// Creates a reading of a position over ground with the covariance of its noise, m², and an optional altitude with
    /// its standard deviation, metres. `None` if a value is not finite, or the covariance is not positive definite.
    pub fn place_reported(
        taken: ReadingOrigin,
        place: [f64; 2],
        covariance: &Matrix2<f64>,
        altitude: Option<(f64, f64)>,
    ) -> Option<Self> {
        let mut values = vec![(Quantity::East, place[0]), (Quantity::North, place[1])];
        let mut noise = Matrix4::zeros();
        noise.fixed_view_mut::<2, 2>(0, 0).copy_from(covariance);
        if let Some((altitude_m, sigma_m)) = altitude {
            values.push((Quantity::Altitude, altitude_m));
            noise[(2, 2)] = sigma_m * sigma_m;
        }
        Self::checked(taken, values, noise)
    }

    fn checked(taken: ReadingOrigin, values: Vec<(Quantity, f64)>, noise: Matrix4<f64>) -> Option<Self> {
        let Observer { position, velocity } = &taken.observer;
        let finite = values.iter().all(|(_, value)| value.is_finite())
            && position.0.iter().chain(velocity).all(|coordinate| coordinate.is_finite());
        let reading = Self { taken, values, noise };
        let count = reading.values.len();
        ((1..=MOST).contains(&count) && finite && reading.whitening([true; MOST]).is_some())
            .then_some(reading)
    }

    /// Time and sensor.
    pub fn origin(&self) -> &ReadingOrigin {
        &self.taken
    }

    /// The measured values.
    pub fn values(&self) -> &[(Quantity, f64)] {
        &self.values
    }

    /// The position given by this reading alone, and its covariance, m². `None` if it is incomplete: a position in
    /// space requires a range, an azimuth and an elevation or altitude, or a position over ground and an altitude.
    pub fn place(&self) -> Option<(Enu, Matrix3<f64>)> {
        use Quantity::{Altitude, Azimuth, East, Elevation, North, Range};
        let sensor = self.taken.observer.position.0;
        let find = |wanted| self.values.iter().position(|(quantity, _)| *quantity == wanted);
        let value = |index: usize| self.values[index].1;
        let (places, position) =
            if let (Some(east), Some(north), Some(up)) = (find(East), find(North), find(Altitude)) {
                ([east, north, up], Vector3::new(value(east), value(north), value(up)))
            } else {
                let (range, azimuth) = (find(Range)?, find(Azimuth)?);
                let third = find(Elevation).or_else(|| find(Altitude))?;
                let up = match self.values[third] {
                    (Elevation, elevation) => value(range) * elevation.sin(),
                    (_, altitude_m) => altitude_m - sensor.z,
                };
                // A coarse altitude may be further above or below the sensor than the range allows: the aircraft is
                // then overhead.
                let ground = (value(range) * value(range) - up * up).max(0.0).sqrt();
                let (sin, cos) = value(azimuth).sin_cos();
                ([range, azimuth, third], sensor + Vector3::new(ground * sin, ground * cos, up))
            };
        let mut rows = Matrix3::zeros();
        for (row, &index) in places.iter().enumerate() {
            let (quantity, _) = self.values[index];
            let expected = quantity.expected(&self.taken.observer, &position, &Vector3::zeros())?;
            rows.set_row(row, &expected.by_position.transpose());
        }
        let inverse = rows.try_inverse()?;
        let noise = Matrix3::from_fn(|row, column| self.noise[(places[row], places[column])]);
        let covariance = inverse * noise * inverse.transpose();
        covariance.iter().all(|value| value.is_finite()).then_some((position.into(), covariance))
    }

    /// Intersection of this line of sight with that of another sensor at the same instant, and its covariance, m²: the
    /// middle between the two lines where they are closest. `None` if one is no line of sight, if they meet behind a
    /// sensor, or at less than 5 degrees: their distance is then not observable.
    pub fn crossing(&self, other: &Self) -> Option<(Enu, Matrix3<f64>)> {
        let [(from, along), (from_other, along_other)] = [self.line_of_sight()?, other.line_of_sight()?];
        let (cosine, between) = (along.dot(&along_other), from_other - from);
        let sine2 = along.cross(&along_other).norm_squared();
        if sine2 < CROSSING.sin().powi(2) {
            return None;
        }
        let far = (between.dot(&along) - cosine * between.dot(&along_other)) / sine2;
        let far_other = (cosine * between.dot(&along) - between.dot(&along_other)) / sine2;
        if far <= 0.0 || far_other <= 0.0 {
            return None;
        }
        let position = (from + along * far + from_other + along_other * far_other) / 2.0;
        let mut information = Matrix3::zeros();
        for reading in [self, other] {
            for (index, (quantity, _)) in reading.values.iter().enumerate() {
                let row =
                    quantity.expected(&reading.taken.observer, &position, &Vector3::zeros())?.by_position;
                information += row * row.transpose() / reading.noise[(index, index)];
            }
        }
        Some((position.into(), information.try_inverse()?))
    }

    /// Origin and unit vector of the line of sight of an azimuth and an elevation.
    fn line_of_sight(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let [(Quantity::Azimuth, azimuth), (Quantity::Elevation, elevation)] = self.values[..] else {
            return None;
        };
        let ((east, north), (up, over_ground)) = (azimuth.sin_cos(), elevation.sin_cos());
        let along = Vector3::new(east * over_ground, north * over_ground, up);
        Some((self.taken.observer.position.0, along))
    }

    /// Transformation of the noise of these values to white noise of variance 1; `None` if its covariance is not
    /// positive definite.
    pub(super) fn whitening(&self, used: [bool; MOST]) -> Option<Whitening> {
        let mut whitening = Whitening { places: [0; MOST], count: 0, lower: [[0.0; MOST]; MOST] };
        for (place, _) in used.iter().enumerate().take(self.values.len()).filter(|(_, used)| **used) {
            whitening.places[whitening.count] = place;
            whitening.count += 1;
        }
        let Whitening { places, count, ref mut lower } = whitening;
        for row in 0..count {
            for column in 0..=row {
                let before: f64 = (0..column).map(|index| lower[row][index] * lower[column][index]).sum();
                let left = self.noise[(places[row], places[column])] - before;
                if column < row {
                    lower[row][column] = left / lower[column][column];
                } else if left > 0.0 && left.is_finite() {
                    lower[row][row] = left.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(whitening)
    }
}

/// Cholesky factor of the covariance of the values used.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whitening {
    /// Indices of the values in the reading; the first `count` are valid.
    places: [usize; MOST],
    count: usize,
    lower: [[f64; MOST]; MOST],
}

impl Whitening {
    /// Indices of the values used.
    pub(super) fn places(&self) -> &[usize] {
        &self.places[..self.count]
    }

    /// Solves L y = x, for the values used.
    pub(super) fn apply<const N: usize>(&self, rows: &mut [[f64; N]; MOST]) {
        for row in 0..self.count {
            let (done, rest) = rows.split_at_mut(row);
            for (before, factor) in done.iter().zip(self.lower[row]) {
                rest[0].iter_mut().zip(before).for_each(|(value, before)| *value -= factor * before);
            }
            rest[0].iter_mut().for_each(|value| *value /= self.lower[row][row]);
        }
    }
}
