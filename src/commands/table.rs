//! Text tables, and formats of numbers.

use std::fmt;

/// Rows of cells. A column is as wide as its widest cell.
pub(super) struct TextTable {
    /// Alignment of each column: `l` left, `r` right.
    columns: &'static str,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// Creates a table with these column names.
    pub(super) fn new(columns: &'static str, names: &[&str]) -> Self {
        debug_assert_eq!(columns.len(), names.len());
        Self { columns, rows: vec![names.iter().map(|&name| name.to_owned()).collect()] }
    }

    /// Adds a row; missing cells at its end are blank.
    pub(super) fn row(&mut self, cells: impl Into<Vec<String>>) {
        self.rows.push(cells.into());
    }

    /// Whether the table has no rows.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.len() == 1
    }
}

/// Writes two blanks between columns, and none at the end of a row.
impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |column| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell: &String| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<_> = (0..self.columns.len()).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for ((cell, &width), side) in row.iter().zip(&widths).zip(self.columns.chars()) {
                line += &if side == 'r' { format!("{cell:>width$}  ") } else { format!("{cell:<width$}  ") };
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Formats 1234567 as 1,234,567.
pub(super) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Formats a non-negative number with three significant digits, a large one in full.
pub(super) fn short(number: f64) -> String {
    match number {
        ..0.1 => format!("{number:.3}"),
        ..10.0 => format!("{number:.2}"),
        ..1000.0 => format!("{number:.1}"),
        _ => grouped(number.round() as u64),
    }
}

/// Formats a duration: `0.062 s`, `75.3 s`, `12 min 34 s`, `26 h 03 min`.
pub(super) fn duration(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "-" } else { "" };
    let length = seconds.abs();
    match length {
        ..1.0 => format!("{sign}{length:.3} s"),
        ..10.0 => format!("{sign}{length:.2} s"),
        ..120.0 => format!("{sign}{length:.1} s"),
        ..7200.0 => {
            let whole = length.round() as u64;
            format!("{sign}{} min {:02} s", whole / 60, whole % 60)
        }
        _ => {
            let minutes = (length / 60.0).round() as u64;
            format!("{sign}{} h {:02} min", minutes / 60, minutes % 60)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_durations_are_formatted() {
        assert_eq!([0, 999, 1000, 44_085, 1_234_567].map(grouped).join(" "), "0 999 1,000 44,085 1,234,567");
        assert_eq!([0.0, 0.5, 4.0, 15.86, 1_234.6].map(short).join(" "), "0.000 0.50 4.00 15.9 1,235");
        assert_eq!(
            [0.062, -30.0, 4.0, 75.28, 754.0, 3_599.0, 93_780.0].map(duration).join(", "),
            "0.062 s, -30.0 s, 4.00 s, 75.3 s, 12 min 34 s, 59 min 59 s, 26 h 03 min"
        );
    }

    #[test]
    fn columns_are_aligned_and_lines_end_with_their_text() {
        let mut table = TextTable::new("lr", &["name", "n"]);
        table.row(["a".to_owned(), "10".to_owned()]);
        table.row(["longer".to_owned()]);
        assert_eq!(table.to_string(), "name     n\na       10\nlonger\n");
    }
}
