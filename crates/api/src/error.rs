//! Errors at the start of the API.

use std::path::PathBuf;

use site::areas::AreaError;

/// Reason why the API cannot start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartError {
    /// A file of `[[areas]]` cannot be used.
    #[error(transparent)]
    Area(#[from] AreaError),
    /// The file of the tokens cannot be used.
    #[error("{}: {problem}", file.display())]
    Tokens {
        /// Path of the file.
        file: PathBuf,
        /// Problem and remedy.
        problem: String,
    },
    /// The certificate or the key cannot be used.
    #[error("{}: {problem}", file.display())]
    Tls {
        /// Path of the file that cannot be used.
        file: PathBuf,
        /// Problem and remedy.
        problem: String,
    },
}
