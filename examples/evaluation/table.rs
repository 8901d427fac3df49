//! Markdown tables: a line per row of flights, a column per figure.

use std::fmt::Write as _;

use crate::figures::{DroneScores, ScoreFigure, ScoreGroup};
use crate::summary::{MeanValue, SeedScores, show};

/// Value of a cell.
type CellValue = Box<dyn Fn(&SeedScores<'_>) -> Option<MeanValue>>;

/// A column of a table.
pub struct TableColumn {
    head: String,
    of: CellValue,
    decimals: usize,
}

impl TableColumn {
    /// Column for a figure of one stream and group.
    pub fn of(head: &str, group: ScoreGroup, figure: ScoreFigure, decimals: usize) -> Self {
        Self::new(head, decimals, move |seeds| seeds.of_group(group, figure))
    }

    /// Column for the ratio of a figure between two groups.
    pub fn ratio(head: &str, of: ScoreGroup, over: ScoreGroup, figure: ScoreFigure) -> Self {
        Self::new(head, 2, move |seeds| seeds.ratio(of, over, figure))
    }

    /// Column for a figure of drones; each drone counts once.
    pub fn of_drones(head: &str, drones: DroneScores, figure: ScoreFigure) -> Self {
        Self::new(head, 2, move |seeds| seeds.of_drones(drones, figure))
    }

    fn new(head: &str, decimals: usize, of: impl Fn(&SeedScores<'_>) -> Option<MeanValue> + 'static) -> Self {
        Self { head: head.to_owned(), of: Box::new(of), decimals }
    }
}

/// Table with a line for each of the rows.
pub fn table<'a>(
    first: &str,
    rows: impl IntoIterator<Item = (String, SeedScores<'a>)>,
    columns: &[TableColumn],
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
