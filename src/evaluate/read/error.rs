//! Why a file cannot be scored.

use thiserror::Error;

use crate::capture::{OpenError, ReadError};

/// What is wrong with a file, where, and what to do.
#[derive(Debug, Error)]
pub enum FileError {
    /// A line cannot be read.
    #[error("{name}:{line}: {what}")]
    Line {
        /// The file.
        name: String,
        /// Counted from 1.
        line: u64,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The file as a whole is of no use.
    #[error("{name}: {what}")]
    Whole {
        /// The file.
        name: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A capture that cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A capture that cannot be read to its end.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl FileError {
    pub(super) fn at(name: &str, line: u64, what: impl Into<String>) -> Self {
        Self::Line { name: name.to_owned(), line, what: what.into() }
    }

    pub(super) fn whole(name: &str, what: impl Into<String>) -> Self {
        Self::Whole { name: name.to_owned(), what: what.into() }
    }
}
