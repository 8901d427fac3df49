//! The assignment problem: who goes with whom, so that the sum of the costs is least.
//!
//! Shortest augmenting paths with dual prices (the Hungarian method as R. Jonker and A. Volgenant, *A Shortest
//! Augmenting Path Algorithm for Dense and Sparse Linear Assignment Problems*, Computing 38, 1987, use it).

/// The column of each row in an assignment of least total cost: `rows.min(columns)` pairs, no column twice; `None`
/// for the rows that are left over where there are more rows than columns.
///
/// `cost` is asked for every row and column, some more than once; it must be finite. The work grows with
/// `small² · large` at worst, and with `small · large` where most rows get one of their cheapest columns.
pub fn assign(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<Option<usize>> {
    if rows <= columns {
        return augmented(rows, columns, cost);
    }
    let mut of_rows = vec![None; rows];
    for (column, row) in augmented(columns, rows, |column, row| cost(row, column)).into_iter().enumerate() {
        if let Some(row) = row {
            of_rows[row] = Some(column);
        }
    }
    of_rows
}

/// [`assign`] where no row is left over.
fn augmented(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<Option<usize>> {
    let mut search = Search::new(rows, columns);
    for row in 0..rows {
        search.add(row, &cost);
    }
    search.column_of
}

/// The best assignment of the rows so far, and the search for the next row's way into it.
struct Search {
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
    /// Dual prices: `cost - row_price - column_price` is never negative, and zero for every pair.
    row_price: Vec<f64>,
    column_price: Vec<f64>,
    /// Of the current search, by column: least reduced cost of a path to it, and the row that path comes from.
    distance: Vec<f64>,
    from: Vec<usize>,
    /// Columns whose distance is final, in the order they became so; and the others.
    settled: Vec<usize>,
    open: Vec<usize>,
}

impl Search {
    fn new(rows: usize, columns: usize) -> Self {
        Self {
            column_of: vec![None; rows],
            row_of: vec![None; columns],
            row_price: vec![0.0; rows],
            column_price: vec![0.0; columns],
            distance: vec![0.0; columns],
            from: vec![0; columns],
            settled: Vec::with_capacity(columns),
            open: Vec::with_capacity(columns),
        }
    }

    /// Takes one more row in: finds the cheapest way to a free column, over columns whose rows then move on.
    fn add(&mut self, new: usize, cost: &impl Fn(usize, usize) -> f64) {
        self.distance.fill(f64::INFINITY);
        self.settled.clear();
        self.open.clear();
        self.open.extend(0..self.row_of.len());
        let (mut row, mut reached) = (new, 0.0);
        let free = loop {
            let column = self.nearest(row, reached, cost);
            reached = self.distance[column];
            match self.row_of[column] {
                None => break column,
                Some(next) => row = next,
            }
            self.settled.push(column);
        };
        self.reprice(new, reached);
        self.shift(new, free);
    }

    /// Goes on from `row`, whose own distance is `reached`: the open column that is nearest now, which is closed.
    fn nearest(&mut self, row: usize, reached: f64, cost: &impl Fn(usize, usize) -> f64) -> usize {
        let mut best = 0;
        for (place, &column) in self.open.iter().enumerate() {
            let through = reached + cost(row, column) - self.row_price[row] - self.column_price[column];
            if through < self.distance[column] {
                self.distance[column] = through;
                self.from[column] = row;
            }
            if self.distance[column] < self.distance[self.open[best]] {
                best = place;
            }
        }
        self.open.swap_remove(best)
    }

    /// Keeps the prices valid for the assignment that is about to change.
    fn reprice(&mut self, new: usize, reached: f64) {
        self.row_price[new] += reached;
        for &column in &self.settled {
            let spare = reached - self.distance[column];
            self.column_price[column] -= spare;
            if let Some(row) = self.row_of[column] {
                self.row_price[row] += spare;
            }
        }
    }

    /// Moves each row on the way from `new` to the column `free` one column on.
    fn shift(&mut self, new: usize, free: usize) {
        let mut column = free;
        loop {
            let row = self.from[column];
            self.row_of[column] = Some(row);
            let left = self.column_of[row].replace(column);
            match left {
                Some(left) if row != new => column = left,
                _ => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least sum, by trying every assignment of the rows from `row` on.
    fn brute_force(costs: &[Vec<f64>], row: usize, taken: &mut Vec<bool>, skips: usize) -> f64 {
        let Some(of_row) = costs.get(row) else { return 0.0 };
        let mut least = if skips > 0 { brute_force(costs, row + 1, taken, skips - 1) } else { f64::INFINITY };
        for column in 0..of_row.len() {
            if !taken[column] {
                taken[column] = true;
                least = least.min(of_row[column] + brute_force(costs, row + 1, taken, skips));
                taken[column] = false;
            }
        }
        least
    }

    fn costs() -> impl Strategy<Value = (usize, Vec<Vec<f64>>)> {
        // Whole numbers below 6 make many ties; the others make none.
        let cost = prop_oneof![(0..6_i32).prop_map(f64::from), -50.0..50.0_f64];
        (0..7_usize, 0..7_usize).prop_flat_map(move |(rows, columns)| {
            (Just(columns), prop::collection::vec(prop::collection::vec(cost.clone(), columns), rows))
        })
    }

    proptest! {
        #[test]
        fn no_assignment_costs_less((columns, costs) in costs()) {
            let rows = costs.len();
            let assigned = assign(rows, columns, |row, column| costs[row][column]);
            prop_assert_eq!(assigned.len(), rows);
            let mut used: Vec<usize> = assigned.iter().flatten().copied().collect();
            prop_assert_eq!(used.len(), rows.min(columns));
            let sum: f64 = assigned.iter().enumerate().filter_map(|(row, c)| c.map(|c| costs[row][c])).sum();
            let least = brute_force(&costs, 0, &mut vec![false; columns], rows.saturating_sub(columns));
            prop_assert!((sum - least).abs() < 1e-9, "{} is not {}", sum, least);
            used.sort_unstable();
            used.dedup();
            prop_assert_eq!(used.len(), rows.min(columns), "a column is taken twice");
        }
    }

    #[test]
    fn the_cheapest_column_is_given_up_where_the_sum_gains() {
        // Both rows like column 0; row 1 has nowhere else to go.
        let costs = [[1.0, 2.0, 9.0], [1.0, 8.0, 9.0]];
        assert_eq!(assign(2, 3, |row, column| costs[row][column]), [Some(1), Some(0)]);
        assert_eq!(assign(3, 2, |row, column| costs[column][row]), [Some(1), Some(0), None]);
        assert_eq!(assign(2, 0, |_, _| 0.0), [None, None]);
        assert!(assign(0, 2, |_, _| 0.0).is_empty());
    }
}
