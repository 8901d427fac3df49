//! Errors in files to be scored.

use thiserror::Error;

use input::capture::{OpenError, ReadError};

/// An error in a file: what is wrong, where, and what to do.
#[derive(Debug, Error)]
pub enum InputFileError {
    /// A line cannot be read.
    #[error("{name}:{line}: {what}")]
    Line {
        /// Name of the file.
        name: String,
        /// Line number, from 1.
        line: u64,
        /// The problem, and how to solve it.
        what: String,
    },
    /// The file as a whole cannot be used.
    #[error("{name}: {what}")]
    Whole {
        /// Name of the file.
        name: String,
        /// The problem, and how to solve it.
        what: String,
    },
    /// A capture that cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A capture that cannot be read to its end.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl InputFileError {
    pub(super) fn at(name: &str, line: u64, what: impl Into<String>) -> Self {
        Self::Line { name: name.to_owned(), line, what: what.into() }
    }

    pub(super) fn whole(name: &str, what: impl Into<String>) -> Self {
        Self::Whole { name: name.to_owned(), what: what.into() }
    }
}
