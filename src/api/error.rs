//! Why the API cannot start.

use std::path::PathBuf;

use crate::areas::AreaError;

/// Why the API cannot start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartError {
    /// A file of `[[areas]]`.
    #[error(transparent)]
    Area(#[from] AreaError),
    /// The tokens.
    #[error("{}: {problem}", file.display())]
    Tokens {
        /// Their file.
        file: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// The certificate or the key.
    #[error("{}: {problem}", file.display())]
    Tls {
        /// The file that cannot be used.
        file: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
}
