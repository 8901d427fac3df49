//! Lines that are painted over and over at one place of a terminal, and text that is broken at its width.

use std::env;
use std::fmt::Write as _;

use console::Term;

/// The size of a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    /// Lines.
    pub(super) rows: usize,
    /// Characters in a line.
    pub(super) columns: usize,
}

impl Size {
    /// That of the terminal on standard output, now: windows are resized. `None` where standard output is no terminal,
    /// or one whose cursor cannot be moved.
    pub(super) fn of_stdout() -> Option<Self> {
        let can_move = env::var_os("TERM").is_some_and(|name| name != "dumb");
        let (rows, columns) = Some(Term::stdout()).filter(|term| can_move && term.is_term())?.size();
        // A terminal that does not know its size says 0.
        Some(if rows == 0 || columns == 0 {
            Self { rows: 24, columns: 80 }
        } else {
            Self { rows: rows.into(), columns: columns.into() }
        })
    }
}

/// What stands in the terminal, just above the cursor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Painting {
    lines: usize,
    /// The terminal's size when it was painted.
    size: Option<Size>,
}

impl Painting {
    /// What to write so that these lines replace the last ones. Lines are cut at the terminal's width, since one that
    /// wraps would take two; the last ones are left out where the terminal is too low.
    pub(super) fn paint(&mut self, lines: &[String], size: Size) -> String {
        let mut out = String::new();
        match self.size {
            // Whoever resizes a terminal moves what stands in it: nobody knows where it is now.
            Some(before) if before != size => out.push_str("\x1b[2J\x1b[H"),
            Some(_) if self.lines > 0 => _ = write!(out, "\x1b[{}A\r", self.lines), // up
            _ => {}
        }
        // The cursor ends in the line below.
        let shown = &lines[..lines.len().min(size.rows.saturating_sub(1))];
        for line in shown {
            out.push_str("\x1b[2K"); // cleared first
            out.extend(line.chars().take(size.columns));
            out.push_str("\r\n");
        }
        out.push_str("\x1b[J"); // what is left below of a longer one
        *self = Self { lines: shown.len(), size: Some(size) };
        out
    }
}

/// The text with no line longer than `columns`, broken between words; what follows is indented by `indent`. A word that
/// is longer stays whole.
pub(super) fn broken(text: &str, columns: usize, indent: usize) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let (mut rest, mut length) = (line, 0);
        while let Some((piece, after)) = first_word(rest) {
            let width = piece.chars().count();
            if length > indent && length + width > columns {
                let word = piece.trim_start();
                _ = write!(out, "\n{:indent$}{word}", "");
                length = indent + word.chars().count();
            } else {
                out.push_str(piece);
                length += width;
            }
            rest = after;
        }
        out.push('\n');
    }
    out
}

/// The first word with the blanks before it, which align columns; and what follows. `None` where there is no word.
fn first_word(text: &str) -> Option<(&str, &str)> {
    let start = text.find(|c| c != ' ')?;
    let end = text[start..].find(' ').map_or(text.len(), |length| start + length);
    Some(text.split_at(end))
}

#[cfg(test)]
mod tests {
    use std::num::NonZero;

    use super::*;

    fn lines(count: usize, length: usize) -> Vec<String> {
        (0..count).map(|line| format!("{line:02}{}", "°".repeat(length - 2))).collect()
    }

    /// What a terminal shows, without blank lines at its end.
    fn shown(terminal: &vt100::Parser) -> Vec<String> {
        terminal.screen().contents().lines().map(str::to_owned).collect()
    }

    fn terminal(size: Size) -> vt100::Parser {
        let (rows, columns) = cells(size);
        vt100::Parser::new(rows, columns, 0)
    }

    fn cells(size: Size) -> (NonZero<u16>, NonZero<u16>) {
        let cells = |number: usize| NonZero::new(number as u16).unwrap();
        (cells(size.rows), cells(size.columns))
    }

    #[test]
    fn a_terminal_shows_the_last_lines_and_nothing_else() {
        for columns in [40, 80, 132] {
            for rows in [2, 10, 24, 50] {
                let size = Size { rows, columns };
                let (mut terminal, mut painting) = (terminal(size), Painting::default());
                // As a shell leaves it: something is there, and the table begins in the middle.
                terminal.process(b"$ utm-fusion demo\r\n");
                // Longer and shorter than the terminal, growing and shrinking.
                for (count, length) in [(5, 70), (30, 100), (12, 200), (3, 40), (20, 80)] {
                    terminal.process(painting.paint(&lines(count, length), size).as_bytes());
                    let expected: Vec<String> = lines(count, length)
                        .iter()
                        .take(rows - 1)
                        .map(|line| line.chars().take(columns).collect())
                        .collect();
                    let shown = shown(&terminal);
                    assert!(shown.ends_with(&expected), "{size:?}: {shown:#?}");
                    let above = &shown[..shown.len() - expected.len()];
                    assert!(above.is_empty() || above == ["$ utm-fusion demo"], "{size:?}: {shown:#?}");
                }
            }
        }
    }

    #[test]
    fn a_resized_terminal_is_painted_anew() {
        let (wide, narrow) = (Size { rows: 24, columns: 100 }, Size { rows: 9, columns: 30 });
        let (mut terminal, mut painting) = (terminal(wide), Painting::default());
        for size in [wide, narrow, wide] {
            let (rows, columns) = cells(size);
            terminal.screen_mut().set_size(rows, columns);
            for _ in 0..2 {
                terminal.process(painting.paint(&lines(12, 60), size).as_bytes());
            }
            let expected: Vec<String> = lines(12, 60)
                .iter()
                .take(size.rows - 1)
                .map(|line| line.chars().take(size.columns).collect())
                .collect();
            assert_eq!(shown(&terminal), expected, "{size:?}");
        }
    }

    #[test]
    fn text_is_broken_between_words() {
        let text = "aircraft   1 (serial 7): 405 points fused\nshort\n";
        assert_eq!(broken(text, 80, 11), text);
        assert_eq!(
            broken(text, 24, 11),
            "aircraft   1 (serial 7):\n           405 points\n           fused\nshort\n"
        );
        assert_eq!(broken("a-word-that-is-too-long b", 9, 2), "a-word-that-is-too-long\n  b\n");
    }
}
