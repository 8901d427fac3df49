//! The assignment problem: a one-to-one pairing of rows and columns with the least sum of costs.
//!
//! Shortest augmenting paths with dual prices (R. Jonker and A. Volgenant, *A Shortest Augmenting Path Algorithm for
//! Dense and Sparse Linear Assignment Problems*, Computing 38, 1987), in its sparse form: only possible pairs are
//! searched, because a gate leaves few.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A column that may be assigned to a row, and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The column.
    pub column: usize,
    /// The cost of the pair; finite.
    pub cost: f64,
}

/// Assigns columns to rows with the least total cost; no column is used twice.
///
/// `rows` lists the candidates of each row. A row without a column (`None`) costs `alone`; a column without a row costs
/// nothing. A full matrix gives every row every column as a candidate. With `alone` above the sum of all other costs,
/// as many pairs as possible are assigned.
///
/// # Panics
/// If a candidate's column is not below `columns`.
pub fn assign(rows: &[Vec<Candidate>], columns: usize, alone: f64) -> Vec<Option<usize>> {
    let mut search = AssignmentSearch::new(rows, columns, alone);
    for row in 0..rows.len() {
        search.add(row);
    }
    search.column_of
}

/// The best assignment of the rows so far, and the search for the next row's augmenting path.
struct AssignmentSearch<'a> {
    rows: &'a [Vec<Candidate>],
    alone: f64,
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
    /// Dual prices: `cost - row_price - column_price` is never negative, and is zero for every assigned pair.
    row_price: Vec<f64>,
    column_price: Vec<f64>,
    /// Shortest known path to each column in the current search.
    reached: Vec<Option<ColumnPath>>,
    /// Columns on the edge of the search, nearest first. A column may occur twice; the nearer entry counts.
    edge: BinaryHeap<Reverse<ColumnDistance>>,
    /// Columns whose shortest path is final.
    settled: Vec<usize>,
    /// Columns that have been reached.
    touched: Vec<usize>,
}

/// The shortest known path to a column.
#[derive(Clone, Copy)]
struct ColumnPath {
    /// Sum of the reduced costs.
    distance: f64,
    /// The previous row on the path.
    from: usize,
    /// Whether the path is final. Rounding could otherwise seem to find a shorter one and create a cycle.
    is_final: bool,
}

/// A column and its distance.
#[derive(Clone, Copy, PartialEq)]
struct ColumnDistance {
    distance: f64,
    column: usize,
}

/// End of a search.
enum SearchEnd {
    /// At a column that has no row.
    Free { column: usize, distance: f64 },
    /// At a row for which having no column costs less.
    Alone { row: usize, distance: f64 },
}

impl<'a> AssignmentSearch<'a> {
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

    /// Adds a row: finds the cheapest path to a free column, or to a row that is left without one. Each row on the path
    /// gets the next column of the path.
    fn add(&mut self, new: usize) {
        self.edge.clear();
        self.settled.clear();
        for column in self.touched.drain(..) {
            self.reached[column] = None;
        }
        match self.end(new) {
            SearchEnd::Free { column, distance } => {
                self.update_prices(new, distance);
                self.shift(new, column);
            }
            SearchEnd::Alone { row, distance } => {
                self.update_prices(new, distance);
                if let Some(column) = self.column_of[row].take() {
                    self.shift(new, column);
                }
            }
        }
    }

    fn end(&mut self, new: usize) -> SearchEnd {
        let (mut row, mut so_far) = (new, 0.0);
        let mut loneliest = (f64::INFINITY, new);
        loop {
            let lonely = so_far + self.alone - self.row_price[row];
            if lonely < loneliest.0 {
                loneliest = (lonely, row);
            }
            self.extend_paths(row, so_far);
            let Some(ColumnDistance { distance, column }) =
                self.nearest().filter(|step| step.distance < loneliest.0)
            else {
                return SearchEnd::Alone { row: loneliest.1, distance: loneliest.0 };
            };
            match self.row_of[column] {
                None => return SearchEnd::Free { column, distance },
                Some(next) => (row, so_far) = (next, distance),
            }
            self.settled.push(column);
        }
    }

    /// Updates the paths to the candidates of a row at the distance `so_far`.
    fn extend_paths(&mut self, row: usize, so_far: f64) {
        for &Candidate { column, cost } in &self.rows[row] {
            let distance = so_far + cost - self.row_price[row] - self.column_price[column];
            match self.reached[column] {
                Some(known) if known.is_final || known.distance <= distance => continue,
                Some(_) => {}
                None => self.touched.push(column),
            }
            self.reached[column] = Some(ColumnPath { distance, from: row, is_final: false });
            self.edge.push(Reverse(ColumnDistance { distance, column }));
        }
    }

    /// Removes and returns the nearest column on the edge.
    fn nearest(&mut self) -> Option<ColumnDistance> {
        loop {
            let Reverse(step) = self.edge.pop()?;
            // A column that was reached again by a shorter path is already final.
            if let Some(way) = self.reached[step.column].as_mut().filter(|way| !way.is_final) {
                way.is_final = true;
                return Some(step);
            }
        }
    }

    /// Updates the prices so that they stay valid for the assignment that is about to change.
    fn update_prices(&mut self, new: usize, end: f64) {
        self.row_price[new] += end;
        for &column in &self.settled {
            let Some(ColumnPath { distance, .. }) = self.reached[column] else { continue };
            self.column_price[column] -= end - distance;
            if let Some(row) = self.row_of[column] {
                self.row_price[row] += end - distance;
            }
        }
    }

    /// Moves each row on the path from `new` to `column`, which is free, to the next column.
    fn shift(&mut self, new: usize, mut column: usize) {
        while let Some(ColumnPath { from, .. }) = self.reached[column] {
            self.row_of[column] = Some(from);
            match self.column_of[from].replace(column) {
                Some(left) if from != new => column = left,
                _ => return,
            }
        }
    }
}

impl Eq for ColumnDistance {}

impl Ord for ColumnDistance {
    /// Orders by distance, then by column, so that the same input gives the same assignment.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.column.cmp(&other.column))
    }
}

impl PartialOrd for ColumnDistance {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Least sum of costs over every assignment of the rows from `row` on.
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

    /// Rows and the number of columns. Each pair exists with a probability of 0.2 to 1: sparse to full matrices.
    fn problems() -> impl Strategy<Value = (usize, Vec<Vec<Candidate>>)> {
        // Whole numbers below 6 cause many ties; the other costs cause none.
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
        // Both rows prefer column 0; the alternative of row 1 costs more.
        assert_eq!(assign(&[row(&[1.0, 2.0]), row(&[1.0, 8.0])], 2, 100.0), [Some(1), Some(0)]);
        // Column 1 costs more than having no column.
        assert_eq!(assign(&[row(&[1.0, 5.0]), row(&[2.0, 5.0])], 2, 3.0), [Some(0), None]);
        // The row without a column is the one that loses least by it.
        assert_eq!(assign(&[row(&[4.0]), row(&[1.0]), row(&[2.0])], 1, 100.0), [None, Some(0), None]);
        assert_eq!(assign(&[vec![], vec![]], 0, 1.0), [None, None]);
    }
}
