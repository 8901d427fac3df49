//! The assignment problem: who goes with whom, so that the sum of the costs is least.
//!
//! Shortest augmenting paths with dual prices (R. Jonker and A. Volgenant, *A Shortest Augmenting Path Algorithm for
//! Dense and Sparse Linear Assignment Problems*, Computing 38, 1987), in its sparse form: only pairs that can be are
//! looked at, because a gate leaves few.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A column that a row can have, and what that costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The column.
    pub column: usize,
    /// The cost of the pair; finite.
    pub cost: f64,
}

/// The column of each row in an assignment of least total cost, no column twice.
///
/// `rows` are the candidates of each row; a row without a column (`None`) costs `alone`, a column without a row nothing.
/// A full matrix is the case in which each row has every column for a candidate; with `alone` above the sum of all
/// other costs there are as many pairs as there can be.
///
/// # Panics
/// Where a candidate is not below `columns`.
pub fn assign(rows: &[Vec<Candidate>], columns: usize, alone: f64) -> Vec<Option<usize>> {
    let mut search = Search::new(rows, columns, alone);
    for row in 0..rows.len() {
        search.add(row);
    }
    search.column_of
}

/// The best assignment of the rows so far, and the search for the next row's way into it.
struct Search<'a> {
    rows: &'a [Vec<Candidate>],
    alone: f64,
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
    /// Dual prices: `cost - row_price - column_price` is never negative, and zero for every pair.
    row_price: Vec<f64>,
    column_price: Vec<f64>,
    /// Of the current search, by column.
    reached: Vec<Option<Way>>,
    /// Columns on the edge of the search, nearest first; some twice, of which the nearer counts.
    edge: BinaryHeap<Reverse<Step>>,
    /// Columns whose way is final.
    settled: Vec<usize>,
    /// Columns that have been reached.
    touched: Vec<usize>,
}

/// The shortest way to a column that is known.
#[derive(Clone, Copy)]
struct Way {
    /// Sum of reduced costs.
    distance: f64,
    /// The row it comes from.
    from: usize,
    /// Whether there is no shorter one. Rounding may seem to find one, which would go round in circles.
    is_final: bool,
}

/// A column and how far it is.
#[derive(Clone, Copy, PartialEq)]
struct Step {
    distance: f64,
    column: usize,
}

/// Where a search ends.
enum End {
    /// At a column that no row has.
    Free { column: usize, distance: f64 },
    /// At a row that had better be alone.
    Alone { row: usize, distance: f64 },
}

impl<'a> Search<'a> {
    fn new(rows: &'a [Vec<Candidate>], columns: usize, alone: f64) -> Self {
        Self {
            rows,
            alone,
            column_of: vec![None; rows.len()],
            row_of: vec![None; columns],
            row_price: vec![0.0; rows.len()],
            column_price: vec![0.0; columns],
            reached: vec![None; columns],
            edge: BinaryHeap::new(),
            settled: Vec::new(),
            touched: Vec::new(),
        }
    }

    /// Takes one more row in: finds the cheapest way to a free column or to a row that is left alone; the rows on the
    /// way move on by one column.
    fn add(&mut self, new: usize) {
        self.edge.clear();
        self.settled.clear();
        for column in self.touched.drain(..) {
            self.reached[column] = None;
        }
        match self.end(new) {
            End::Free { column, distance } => {
                self.reprice(new, distance);
                self.shift(new, column);
            }
            End::Alone { row, distance } => {
                self.reprice(new, distance);
                if let Some(column) = self.column_of[row].take() {
                    self.shift(new, column);
                }
            }
        }
    }

    fn end(&mut self, new: usize) -> End {
        let (mut row, mut so_far) = (new, 0.0);
        let mut loneliest = (f64::INFINITY, new);
        loop {
            let lonely = so_far + self.alone - self.row_price[row];
            if lonely < loneliest.0 {
                loneliest = (lonely, row);
            }
            self.look_around(row, so_far);
            let Some(Step { distance, column }) = self.nearest().filter(|step| step.distance < loneliest.0)
            else {
                return End::Alone { row: loneliest.1, distance: loneliest.0 };
            };
            match self.row_of[column] {
                None => return End::Free { column, distance },
                Some(next) => (row, so_far) = (next, distance),
            }
            self.settled.push(column);
        }
    }

    /// Reaches the candidates of a row that is `so_far` away.
    fn look_around(&mut self, row: usize, so_far: f64) {
        for &Candidate { column, cost } in &self.rows[row] {
            let distance = so_far + cost - self.row_price[row] - self.column_price[column];
            match self.reached[column] {
                Some(known) if known.is_final || known.distance <= distance => continue,
                Some(_) => {}
                None => self.touched.push(column),
            }
            self.reached[column] = Some(Way { distance, from: row, is_final: false });
            self.edge.push(Reverse(Step { distance, column }));
        }
    }

    /// The column on the edge that is nearest, which leaves it.
    fn nearest(&mut self) -> Option<Step> {
        loop {
            let Reverse(step) = self.edge.pop()?;
            // One that was reached again, on a shorter way, has been here before.
            if let Some(way) = self.reached[step.column].as_mut().filter(|way| !way.is_final) {
                way.is_final = true;
                return Some(step);
            }
        }
    }

    /// Keeps the prices valid for the assignment that is about to change.
    fn reprice(&mut self, new: usize, end: f64) {
        self.row_price[new] += end;
        for &column in &self.settled {
            let Some(Way { distance, .. }) = self.reached[column] else { continue };
            self.column_price[column] -= end - distance;
            if let Some(row) = self.row_of[column] {
                self.row_price[row] += end - distance;
            }
        }
    }

    /// Moves each row on the way from `new` to `column`, which is free by now, one column on.
    fn shift(&mut self, new: usize, mut column: usize) {
        while let Some(Way { from, .. }) = self.reached[column] {
            self.row_of[column] = Some(from);
            match self.column_of[from].replace(column) {
                Some(left) if from != new => column = left,
                _ => return,
            }
        }
    }
}

impl Eq for Step {}

impl Ord for Step {
    /// By distance, then by column, so that the same input gives the same assignment.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.column.cmp(&other.column))
    }
}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least sum, by trying every assignment of the rows from `row` on.
    fn brute_force(rows: &[Vec<Candidate>], row: usize, taken: &mut Vec<bool>, alone: f64) -> f64 {
        let Some(candidates) = rows.get(row) else { return 0.0 };
        let mut least = alone + brute_force(rows, row + 1, taken, alone);
        for candidate in candidates {
            if !taken[candidate.column] {
                taken[candidate.column] = true;
                least = least.min(candidate.cost + brute_force(rows, row + 1, taken, alone));
                taken[candidate.column] = false;
            }
        }
        least
    }

    /// Rows over so many columns, each pair with one chance in two or three; or a full matrix.
    fn problems() -> impl Strategy<Value = (usize, Vec<Vec<Candidate>>)> {
        // Whole numbers below 6 make many ties; the others make none.
        let cost = prop_oneof![(0..6_i32).prop_map(f64::from), -50.0..50.0_f64];
        (0..7_usize, 0..7_usize, 0.2..1.3_f64).prop_flat_map(move |(rows, columns, chance)| {
            let pair = prop::option::weighted(chance.min(0.9999), cost.clone());
            let matrix = prop::collection::vec(prop::collection::vec(pair, columns), rows);
            matrix.prop_map(move |matrix| {
                let candidates = |row: Vec<Option<f64>>| {
                    let pairs = row.into_iter().enumerate();
                    pairs.filter_map(|(column, cost)| Some(Candidate { column, cost: cost? })).collect()
                };
                (columns, matrix.into_iter().map(candidates).collect())
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn no_assignment_costs_less(
            (columns, rows) in problems(), alone in prop_oneof![Just(1e6), Just(3.0), -10.0..60.0_f64],
        ) {
            let assigned = assign(&rows, columns, alone);
            prop_assert_eq!(assigned.len(), rows.len());
            let mut sum = 0.0;
            for (candidates, column) in rows.iter().zip(&assigned) {
                let cost = column.map(|column| candidates.iter().find(|c| c.column == column).unwrap().cost);
                sum += cost.unwrap_or(alone);
            }
            let least = brute_force(&rows, 0, &mut vec![false; columns], alone);
            prop_assert!((sum - least).abs() < 1e-6, "{} is not {}", sum, least);
            let mut used: Vec<usize> = assigned.iter().flatten().copied().collect();
            let pairs = used.len();
            used.sort_unstable();
            used.dedup();
            prop_assert_eq!(used.len(), pairs, "a column is taken twice");
        }
    }

    fn row(costs: &[f64]) -> Vec<Candidate> {
        costs.iter().enumerate().map(|(column, &cost)| Candidate { column, cost }).collect()
    }

    #[test]
    fn the_cheapest_column_is_given_up_where_the_sum_gains() {
        // Both rows like column 0; row 1 has nowhere else to go.
        assert_eq!(assign(&[row(&[1.0, 2.0]), row(&[1.0, 8.0])], 2, 100.0), [Some(1), Some(0)]);
        // Column 1 costs more than being alone.
        assert_eq!(assign(&[row(&[1.0, 5.0]), row(&[2.0, 5.0])], 2, 3.0), [Some(0), None]);
        // The row that is alone is the one that loses least by it.
        assert_eq!(assign(&[row(&[4.0]), row(&[1.0]), row(&[2.0])], 1, 100.0), [None, Some(0), None]);
        assert_eq!(assign(&[vec![], vec![]], 0, 1.0), [None, None]);
    }
}
