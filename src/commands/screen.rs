//! Updates of lines in place on a terminal, and word wrap.

use std::env;
use std::fmt::Write as _;

use console::Term;

/// Size of a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TerminalSize {
    /// Number of lines.
    pub(super) rows: usize,
    /// Number of characters in a line.
    pub(super) columns: usize,
}

impl TerminalSize {
    /// Current size of the terminal on standard output, which may have been resized. `None` if standard output is not a terminal,
    /// or the cursor cannot be moved.
    pub(super) fn of_stdout() -> Option<Self> {
        let can_move = env::var_os("TERM").is_some_and(|name| name != "dumb");
        let (rows, columns) = Some(Term::stdout()).filter(|term| can_move && term.is_term())?.size();
        // A terminal that does not know its size reports 0.
        Some(if rows == 0 || columns == 0 {
            Self { rows: 24, columns: 80 }
        } else {
            Self { rows: rows.into(), columns: columns.into() }
        })
    }
}

/// Lines painted above the cursor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TerminalPainter {
    lines: usize,
    /// Size of the terminal when the lines were painted.
    size: Option<TerminalSize>,
}

impl TerminalPainter {
    /// Text that replaces the previous lines by `lines`. Lines are cut at the width of the terminal, because a wrapped line would
    /// take two. The last lines are left out if the terminal is too low.
    pub(super) fn paint(&mut self, lines: &[String], size: TerminalSize) -> String {
        let mut out = String::new();
        match self.size {
            // Resizing moves the lines to an unknown position, so the screen is cleared.
            Some(before) if before != size => out.push_str("\x1b[2J\x1b[H"),
            Some(_) if self.lines > 0 => _ = write!(out, "\x1b[{}A\r", self.lines), // moves up
            _ => {}
        }
        // The cursor ends in the line below.
        let shown = &lines[..lines.len().min(size.rows.saturating_sub(1))];
        for line in shown {
            out.push_str("\x1b[2K"); // clears the line
            out.extend(line.chars().take(size.columns));
            out.push_str("\r\n");
        }
        out.push_str("\x1b[J"); // clears the rest of a longer painting
        *self = Self { lines: shown.len(), size: Some(size) };
        out
    }
}

/// Wraps `text` at `columns` between words; further lines are indented by `indent`. A longer word stays whole.
pub(super) fn wrap(text: &str, columns: usize, indent: usize) -> String {
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

/// First word with the blanks before it, which align columns, and the rest. `None` if there is no word.
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

    /// Lines that a terminal shows, without blank lines at the end.
    fn shown(terminal: &vt100::Parser) -> Vec<String> {
        terminal.screen().contents().lines().map(str::to_owned).collect()
    }

    fn terminal(size: TerminalSize) -> vt100::Parser {
        let (rows, columns) = cells(size);
        vt100::Parser::new(rows, columns, 0)
    }

    fn cells(size: TerminalSize) -> (NonZero<u16>, NonZero<u16>) {
        let cells = |number: usize| NonZero::new(number as u16).unwrap();
        (cells(size.rows), cells(size.columns))
    }

    #[test]
    fn terminal_shows_only_the_last_lines() {
        for columns in [40, 80, 132] {
            for rows in [2, 10, 24, 50] {
                let size = TerminalSize { rows, columns };
                let (mut terminal, mut painting) = (terminal(size), TerminalPainter::default());
                // A shell leaves text, so the table begins in the middle of the screen.
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
    fn resized_terminal_is_repainted() {
        let (wide, narrow) = (TerminalSize { rows: 24, columns: 100 }, TerminalSize { rows: 9, columns: 30 });
        let (mut terminal, mut painting) = (terminal(wide), TerminalPainter::default());
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
    fn text_is_wrapped_between_words() {
        let text = "aircraft   1 (serial 7): 405 points fused\nshort\n";
        assert_eq!(wrap(text, 80, 11), text);
        assert_eq!(
            wrap(text, 24, 11),
            "aircraft   1 (serial 7):\n           405 points\n           fused\nshort\n"
        );
        assert_eq!(wrap("a-word-that-is-too-long b", 9, 2), "a-word-that-is-too-long\n  b\n");
    }
}
