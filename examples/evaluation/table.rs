//! Tables of Markdown: a row of flights a line, a figure a column.

use std::fmt::Write as _;

use crate::figures::{Each, Figure, Group};
use crate::summary::{Mean, Seeds, show};

/// What stands in a row.
type Cell = Box<dyn Fn(&Seeds<'_>) -> Option<Mean>>;

/// A column of a table.
pub struct Column {
    head: String,
    of: Cell,
    decimals: usize,
}

impl Column {
    /// A figure of one stream and group.
    pub fn of(head: &str, group: Group, figure: Figure, decimals: usize) -> Self {
        Self::new(head, decimals, move |seeds| seeds.of_group(group, figure))
    }

    /// The one's figure over the other's.
    pub fn ratio(head: &str, of: Group, over: Group, figure: Figure) -> Self {
        Self::new(head, 2, move |seeds| seeds.ratio(of, over, figure))
    }

    /// A figure of drones, each of which counts once.
    pub fn of_drones(head: &str, drones: Each, figure: Figure) -> Self {
        Self::new(head, 2, move |seeds| seeds.of_drones(drones, figure))
    }

    fn new(head: &str, decimals: usize, of: impl Fn(&Seeds<'_>) -> Option<Mean> + 'static) -> Self {
        Self { head: head.to_owned(), of: Box::new(of), decimals }
    }
}

/// With a line for each of the rows.
pub fn table<'a>(
    first: &str,
    rows: impl IntoIterator<Item = (String, Seeds<'a>)>,
    columns: &[Column],
) -> String {
    let heads: Vec<&str> = columns.iter().map(|column| column.head.as_str()).collect();
    let mut text = format!("| {first} | {} |\n|---|{}\n", heads.join(" | "), "---:|".repeat(columns.len()));
    for (name, seeds) in rows {
        let cells: Vec<String> =
            columns.iter().map(|column| show((column.of)(&seeds), column.decimals)).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    text
}
