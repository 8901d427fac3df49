//! Tables with results of other implementations, and the largest error relative to them.

/// The rows of a table, after a comment and the names of its columns.
pub fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    table.lines().skip(2).map(|line| line.split(',').collect())
}

/// Numbers; an empty field is `None`.
pub fn numbers<const N: usize>(row: &[&str]) -> [Option<f64>; N] {
    std::array::from_fn(|i| (!row[i].is_empty()).then(|| row[i].parse().unwrap()))
}

/// Number of comparisons, and the largest error, which must not exceed the bound.
#[derive(Default)]
pub struct Largest {
    count: usize,
    error: f64,
}

impl Largest {
    pub fn add(&mut self, error: f64) {
        assert!(!error.is_nan());
        self.count += 1;
        self.error = self.error.max(error);
    }

    pub fn check(&self, what: &str, count: usize, bound: f64) {
        println!("{what}: {} queries, maximum error {:.2e} m", self.count, self.error);
        assert_eq!(self.count, count, "{what}");
        assert!(self.error <= bound, "{what}: {:e} m", self.error);
    }
}
