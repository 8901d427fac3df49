//! Horizontal accuracy: the circle that contains a share of the errors, and the classes of the standards.

use std::sync::LazyLock;

use nalgebra::Matrix2;

/// A share of normally distributed errors: radius of the circle that contains it, as a function of the flatness of the error
/// ellipse.
pub struct Share(LazyLock<[f64; KNOTS]>);

/// 50 % of the errors.
pub static HALF: Share =
    Share(LazyLock::new(|| Circle { share: 0.5, line: 0.674_489_750_2, disc: 1.177_410_022_5 }.table()));
/// 95 % of the errors.
pub static MOST: Share =
    Share(LazyLock::new(|| Circle { share: 0.95, line: 1.959_963_984_5, disc: 2.447_746_830_7 }.table()));

/// Number of flatness steps from a line to a disc. The radius is interpolated between them, with a relative error of about 1e-10.
const FLATNESSES: usize = 512;
const KNOTS: usize = FLATNESSES + 1;

impl Share {
    /// Radius about the mean that contains this share of a normal error with this covariance, in the square root of the
    /// covariance's unit.
    pub fn radius(&self, covariance: &Matrix2<f64>) -> f64 {
        let (east, north, both) = (covariance.m11, covariance.m22, covariance.m21);
        let (mean, half) = ((east + north) / 2.0, f64::hypot((east - north) / 2.0, both));
        let (least, greatest) = ((mean - half).max(0.0), mean + half);
        // A NaN is not an accuracy either.
        if !(greatest > 0.0 && greatest.is_finite()) {
            return 0.0;
        }
        self.of_flatness(least / greatest) * greatest.sqrt()
    }

    /// Radius for an ellipse with the larger variance 1 and the smaller variance `flatness`, by the cubic through the four
    /// nearest knots.
    fn of_flatness(&self, flatness: f64) -> f64 {
        let at = flatness * FLATNESSES as f64;
        let first = (at as usize).clamp(1, FLATNESSES - 2) - 1;
        let [a, b, c, d] = [0, 1, 2, 3].map(|index| at - (first + index) as f64);
        let knots = &self.0[first..first + 4];
        (knots[3] * a * b * c - knots[0] * b * c * d) / 6.0
            + (knots[1] * a * c * d - knots[2] * a * b * d) / 2.0
    }
}

/// A share of the errors, with the radii that contain it if the error is along a line (`line`) and if it is equal in all
/// directions (`disc`), in standard deviations.
#[derive(Clone, Copy, Debug)]
struct Circle {
    share: f64,
    line: f64,
    disc: f64,
}

/// Number of directions in a quarter of the circle at which the error is evaluated.
const DIRECTIONS: usize = 16;
/// Number of Newton steps. The first guess is within 9 %.
const STEPS: usize = 4;

impl Circle {
    fn table(self) -> [f64; KNOTS] {
        std::array::from_fn(|index| self.of_flatness(index as f64 / FLATNESSES as f64))
    }

    /// Radius if the variances along the axes of the ellipse are 1 and `flatness`.
    ///
    /// With standard deviations a and b along the axes, the circle of radius r contains 1 - the mean of exp(-r² / 2s²) over all
    /// directions t, where s² = a² cos² t + b² sin² t (normal distribution in polar coordinates of the ellipse). Newton's method
    /// solves for r.
    fn of_flatness(self, flatness: f64) -> f64 {
        let variances: [f64; DIRECTIONS] = std::array::from_fn(|index| {
            let direction = (index as f64 + 0.5) * std::f64::consts::FRAC_PI_2 / DIRECTIONS as f64;
            direction.cos().powi(2) + flatness * direction.sin().powi(2)
        });
        let mut radius = self.line + (self.disc - self.line) * flatness;
        for _ in 0..STEPS {
            let (mut outside, mut density) = (0.0, 0.0);
            for variance in variances {
                let beyond = (-radius * radius / (2.0 * variance)).exp();
                outside += beyond / DIRECTIONS as f64;
                density += radius / variance * beyond / DIRECTIONS as f64;
            }
            radius += (outside - (1.0 - self.share)) / density;
        }
        radius
    }
}

/// A class of accuracy: 95 % of the errors are below its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracyClass {
    below: f64,
    /// Name in ASTM F3411.
    pub name: &'static str,
    /// Category of ADS-B from which F3411 took the class: NACp, GVA or NACv; 0 if there is none.
    pub category: u8,
}

const fn class(below: f64, name: &'static str, category: u8) -> AccuracyClass {
    AccuracyClass { below, name, category }
}

/// HorizontalAccuracy, in metres, with NACp up to 11.
pub const HORIZONTAL: [AccuracyClass; 13] = [
    class(1.0, "HA1m", 11),
    class(3.0, "HA3m", 11),
    class(10.0, "HA10m", 10),
    class(30.0, "HA30m", 9),
    class(92.6, "HA005NM", 8),
    class(185.2, "HA01NM", 7),
    class(555.6, "HA03NM", 6),
    class(926.0, "HA05NM", 5),
    class(1_852.0, "HA1NM", 4),
    class(3_704.0, "HA2NM", 3),
    class(7_408.0, "HA4NM", 2),
    class(18_520.0, "HA10NM", 1),
    class(f64::INFINITY, "HA10NMPlus", 0),
];

/// VerticalAccuracy, in metres, with GVA up to 2.
pub const VERTICAL: [AccuracyClass; 7] = [
    class(1.0, "VA1m", 2),
    class(3.0, "VA3m", 2),
    class(10.0, "VA10m", 2),
    class(25.0, "VA25m", 2),
    class(45.0, "VA45m", 2),
    class(150.0, "VA150m", 1),
    class(f64::INFINITY, "VA150mPlus", 0),
];

/// SpeedAccuracy, in metres per second, with NACv.
pub const SPEED: [AccuracyClass; 5] = [
    class(0.3, "SA03mps", 4),
    class(1.0, "SA1mps", 3),
    class(3.0, "SA3mps", 2),
    class(10.0, "SA10mps", 1),
    class(f64::INFINITY, "SA10mpsPlus", 0),
];

/// Names of these classes.
pub fn class_names<const N: usize>(classes: &[AccuracyClass; N]) -> [&'static str; N] {
    classes.map(|class| class.name)
}

/// Class of a 95 % accuracy.
pub fn class_of<const N: usize>(classes: &'static [AccuracyClass; N], accuracy: f64) -> AccuracyClass {
    classes.iter().find(|class| accuracy < class.below).copied().unwrap_or(classes[N - 1])
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation2, Vector2};

    use super::*;

    fn ellipse(long: f64, short: f64, turned: f64) -> Matrix2<f64> {
        let turn = Rotation2::new(turned);
        turn.matrix() * Matrix2::new(long * long, 0.0, 0.0, short * short) * turn.matrix().transpose()
    }

    /// Probability within the circle: the density summed over strips in east and north.
    fn within(covariance: &Matrix2<f64>, radius: f64) -> f64 {
        const STRIPS: i32 = 400;
        let inverse = covariance.try_inverse().unwrap();
        let scale = 1.0 / (std::f64::consts::TAU * covariance.determinant().sqrt());
        let middle = |index: i32, half: f64| half * (f64::from(2 * index + 1) / f64::from(STRIPS) - 1.0);
        let mut sum = 0.0;
        for row in 0..STRIPS {
            let north = middle(row, radius);
            let half = (radius * radius - north * north).sqrt();
            let area = 4.0 * radius * half / f64::from(STRIPS * STRIPS);
            for column in 0..STRIPS {
                let place = Vector2::new(middle(column, half), north);
                sum += scale * (-0.5 * place.dot(&(inverse * place))).exp() * area;
            }
        }
        sum
    }

    #[test]
    fn circle_contains_its_share_for_any_ellipse() {
        for (long, short) in [(1.0, 1.0), (3.0, 2.5), (10.0, 5.0), (7.0, 2.0), (100.0, 12.0), (0.02, 0.001)] {
            for (circle, share) in [(&HALF, 0.5), (&MOST, 0.95)] {
                let expected = circle.radius(&ellipse(long, short, 0.0));
                for turned in [0.3, 0.8, 2.0, 3.1] {
                    let covariance = ellipse(long, short, turned);
                    let found = circle.radius(&covariance);
                    assert!((found / expected - 1.0).abs() < 1e-9, "{long} {short} {turned}");
                    let held = within(&covariance, found);
                    assert!((held - share).abs() < 5e-4, "{long} {short} {turned}: {held}");
                }
            }
        }
    }

    #[test]
    fn circle_and_line_match_the_closed_form() {
        for (circle, share, line) in [(&HALF, 0.5, 0.674_489_750_2), (&MOST, 0.95, 1.959_963_984_5)] {
            let round = circle.radius(&ellipse(2.0, 2.0, 0.0));
            assert!((round - 2.0 * (-2.0 * f64::ln(1.0 - share)).sqrt()).abs() < 1e-8, "{round}");
            let flat = circle.radius(&ellipse(2.0, 0.0, 1.0));
            assert!((flat - 2.0 * line).abs() < 1e-3, "{flat}");
        }
    }

    proptest::proptest! {
        #[test]
        fn table_matches_the_solution(flatness in 0.0..=1.0_f64) {
            let circle = Circle { share: 0.95, line: 1.959_963_984_5, disc: 2.447_746_830_7 };
            let (tabulated, solved) = (MOST.of_flatness(flatness), circle.of_flatness(flatness));
            proptest::prop_assert!((tabulated - solved).abs() < 2e-10, "{tabulated} {solved}");
        }
    }

    #[test]
    fn invalid_covariance_has_no_circle() {
        for number in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(MOST.radius(&(Matrix2::identity() * number)), 0.0);
        }
    }

    #[test]
    fn accuracy_class_matches_its_name() {
        let name = |metres| class_of(&HORIZONTAL, metres).name;
        assert_eq!([name(0.0), name(0.99), name(1.0), name(29.9)], ["HA1m", "HA1m", "HA3m", "HA30m"]);
        assert_eq!([name(30.0), name(18_519.0), name(18_520.0)], ["HA005NM", "HA10NM", "HA10NMPlus"]);
        assert_eq!(class_of(&VERTICAL, 44.0).name, "VA45m");
        assert_eq!(class_of(&VERTICAL, 150.0).name, "VA150mPlus");
        assert_eq!(class_of(&SPEED, 0.3).name, "SA1mps");
        assert_eq!(class_of(&SPEED, f64::INFINITY).name, "SA10mpsPlus");
    }
}
