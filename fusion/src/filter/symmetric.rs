//! Small symmetric matrices as plain arrays, modified in place.
//!
//! Loops run from 0 to a length known to the compiler, so that it unrolls them; iterators over arrays would leave
//! calls.

use serde::{Deserialize, Serialize};

/// A vector of `D` elements.
pub type Vector<const D: usize> = [f64; D];

/// `D` rows of `N` elements.
pub type Rows<const N: usize, const D: usize> = [[f64; N]; D];

/// Adds b · factor to a, element by element.
#[inline]
pub(super) fn add_scaled<const N: usize>(a: &mut [f64; N], b: &[f64; N], factor: f64) {
    for index in 0..N {
        a[index] += b[index] * factor;
    }
}

/// Multiplies a by a factor.
#[inline]
pub(super) fn scale<const N: usize>(a: &mut [f64; N], factor: f64) {
    for index in 0..N {
        a[index] *= factor;
    }
}

/// Returns a - b.
#[inline]
pub(super) fn difference<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut difference = *a;
    add_scaled(&mut difference, b, -1.0);
    difference
}

/// The transposed matrix.
#[inline]
pub(super) fn transposed<const D: usize>(rows: &Rows<D, D>) -> Rows<D, D> {
    let mut transposed = [[0.0; D]; D];
    for row in 0..D {
        for column in 0..D {
            transposed[row][column] = rows[column][row];
        }
    }
    transposed
}

/// A symmetric matrix: a covariance. Both halves are stored, so that a row is also a column; they agree except for
/// rounding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Symmetric<const D: usize>(#[serde(with = "crate::checkpoint::rows")] Rows<D, D>);

impl<const D: usize> Symmetric<D> {
    /// The zero matrix.
    pub const ZERO: Self = Self([[0.0; D]; D]);

    /// Makes a matrix symmetric by copying its lower half. The halves must already agree except for rounding.
    #[inline]
    pub fn of_lower(mut rows: Rows<D, D>) -> Self {
        for row in 1..D {
            for column in 0..row {
                rows[column][row] = rows[row][column];
            }
        }
        Self(rows)
    }

    #[inline]
    /// All elements, row by row.
    pub fn rows(&self) -> &Rows<D, D> {
        &self.0
    }

    #[inline]
    /// The element at a row and a column.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.0[row][column]
    }

    /// Adds to an element and its mirror image.
    #[inline]
    pub fn add_at(&mut self, row: usize, column: usize, value: f64) {
        self.0[row][column] += value;
        if row != column {
            self.0[column][row] += value;
        }
    }

    #[inline]
    pub(super) fn set_diagonal(&mut self, index: usize, value: f64) {
        self.0[index][index] = value;
    }

    /// Adds another matrix times a factor.
    #[inline]
    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        for row in 0..D {
            add_scaled(&mut self.0[row], &other.0[row], factor);
        }
    }

    /// Adds v vᵀ times a factor.
    #[inline]
    pub(super) fn add_square(&mut self, v: &Vector<D>, factor: f64) {
        for row in 0..D {
            add_scaled(&mut self.0[row], v, v[row] * factor);
        }
    }

    /// Adds Aᵀ S A for a symmetric S.
    #[inline]
    pub(super) fn add_between(&mut self, a: &Rows<D, D>, s: &Self) {
        let mut product = [[0.0; D]; D];
        for row in 0..D {
            for index in 0..D {
                add_scaled(&mut product[row], &a[index], s.0[row][index]);
            }
        }
        let mut sum = self.0;
        for row in 0..D {
            for index in 0..D {
                add_scaled(&mut sum[row], &product[index], a[index][row]);
            }
        }
        *self = Self::of_lower(sum);
    }

    /// Solves S X = B by Cholesky decomposition; returns X, or `None` if S is not positive definite.
    pub(super) fn solve(&self, mut b: Rows<D, D>) -> Option<Rows<D, D>> {
        let mut lower = self.0;
        let mut inverse = [0.0; D];
        for column in 0..D {
            let mut square = lower[column][column];
            for before in 0..column {
                square -= lower[column][before] * lower[column][before];
            }
            if square <= 0.0 || !square.is_finite() {
                return None;
            }
            inverse[column] = square.sqrt().recip();
            for row in column + 1..D {
                let mut value = lower[row][column];
                for before in 0..column {
                    value -= lower[row][before] * lower[column][before];
                }
                lower[row][column] = value * inverse[column];
            }
        }
        for row in 0..D {
            let mut solved = b[row];
            for before in 0..row {
                add_scaled(&mut solved, &b[before], -lower[row][before]);
            }
            scale(&mut solved, inverse[row]);
            b[row] = solved;
        }
        for row in (0..D).rev() {
            let mut solved = b[row];
            for below in row + 1..D {
                add_scaled(&mut solved, &b[below], -lower[below][row]);
            }
            scale(&mut solved, inverse[row]);
            b[row] = solved;
        }
        Some(b)
    }
}

#[cfg(test)]
mod tests {
    //! Compares with nalgebra.

    use nalgebra::{SMatrix, SVector};
    use proptest::prelude::*;

    use super::*;

    const D: usize = 5;
    type Dense = SMatrix<f64, D, D>;

    fn dense(rows: &Rows<D, D>) -> Dense {
        Dense::from_fn(|row, column| rows[row][column])
    }

    fn rows() -> impl Strategy<Value = Rows<D, D>> {
        prop::array::uniform(prop::array::uniform(-2.0..2.0_f64))
    }

    /// A covariance: Aᵀ A plus a diagonal matrix.
    fn covariance(a: &Rows<D, D>) -> Symmetric<D> {
        let diagonal = |value: f64| {
            let mut diagonal = Symmetric::ZERO;
            (0..D).for_each(|index| diagonal.set_diagonal(index, value));
            diagonal
        };
        let mut square = diagonal(0.1);
        square.add_between(a, &diagonal(1.0));
        square
    }

    proptest! {
        #[test]
        fn symmetric_solution_matches_nalgebra(a in rows(), b in rows(), v in prop::array::uniform(-3.0..3.0_f64)) {
            let mut s = covariance(&a);
            let expected = dense(&a).transpose() * dense(&a) + Dense::identity() * 0.1;
            prop_assert!((dense(s.rows()) - expected).norm() < 1e-12);
            let solved = s.solve(b).unwrap();
            let scale = expected.try_inverse().unwrap().norm();
            prop_assert!((expected * dense(&solved) - dense(&b)).norm() < 1e-12 * scale.max(1.0));
            let square = SVector::<f64, D>::from(v) * SVector::<f64, D>::from(v).transpose() * 0.7;
            let other = covariance(&b);
            s.add_square(&v, 0.7);
            s.add(&other, -0.3);
            prop_assert!((dense(s.rows()) - expected - square + dense(other.rows()) * 0.3).norm() < 1e-12);
            prop_assert!((dense(&transposed(s.rows())) - dense(s.rows())).norm() < 1e-12);
        }
    }

    #[test]
    fn invalid_covariance_is_not_solved() {
        let mut s = Symmetric::<D>::ZERO;
        assert_eq!(s.solve([[1.0; D]; D]), None);
        (0..D).for_each(|index| s.set_diagonal(index, 1.0));
        s.add_at(0, 1, 1.5);
        assert_eq!(s.solve([[1.0; D]; D]), None);
    }
}
