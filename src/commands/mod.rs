//! The command line, one file per subcommand. Data go to standard output, everything else to standard error.

pub mod address;
mod alert_file;
mod broadcast;
pub mod check;
pub mod cli;
#[cfg(feature = "cluster")]
pub mod cluster;
pub mod completions;
pub mod decode;
pub mod demo;
pub mod edition;
pub mod encode;
pub mod evaluate;
pub mod info;
mod line_file;
pub mod moment;
mod notify;
mod own_ports;
pub mod pace;
pub mod progress;
pub mod record;
mod reload;
pub mod replay;
pub mod run;
mod screen;
pub mod simulate;
mod stage;
pub mod summary;
mod table;
pub mod tip;
pub mod unmatched;
mod verdict;
mod zones;

use std::error::Error;
use std::io;
use std::path::Path;

use crate::api::StartError;
use crate::areas::AreaError;
use crate::config::{Config, ConfigError, ConfigErrors, Place};
use crate::notices::Unusable;
use crate::simulate::Crowded;

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All of it.
    Done,
    /// Octets of a raw file or a FINAL recording could not be read, or with `--strict` any input had errors: exit code 4.
    InputErrors,
    /// An input could not be read to its end: exit code 1, already reported.
    InputUnreadable,
    /// Part of the input was omitted: exit code 1, already reported.
    Incomplete,
    /// A threshold of `evaluate` was missed: exit code 5, already reported.
    ThresholdMissed,
}

/// What a command returns; [`exit_code`] distinguishes the errors.
pub type CommandResult = Result<Outcome, Box<dyn Error + Send + Sync>>;

/// Arguments that contradict each other: exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// The process's exit code: 0 done, 1 run-time failure, 2 wrong usage, 3 configuration invalid, 4 input not all read,
/// 5 an evaluation threshold was missed.
///
/// A closed pipe is no failure: the reader has read enough.
pub fn exit_code(result: &CommandResult) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::InputErrors) => 4,
        Ok(Outcome::ThresholdMissed) => 5,
        Ok(Outcome::InputUnreadable | Outcome::Incomplete) => 1,
        Err(error) if is_closed_pipe(error.as_ref()) => 0,
        Err(error) if error.is::<Usage>() => 2,
        Err(error)
            if error.is::<ConfigErrors>()
                || error.is::<AreaError>()
                || error.is::<StartError>()
                || error.is::<Unusable>()
                || error.is::<Crowded>() =>
        {
            3
        }
        #[cfg(feature = "cluster")]
        Err(error) if error.is::<crate::app::Refused>() => 3,
        Err(_) => 1,
    }
}

/// The configuration of a command that listens, which needs an input.
fn load_live(file: &Path) -> Result<Config, ConfigErrors> {
    let config = Config::load(file)?;
    if config.sensors.iter().any(|sensor| !sensor.inputs.is_empty() || !sensor.connections.is_empty()) {
        return Ok(config);
    }
    Err(ConfigErrors::from(ConfigError {
        file: file.display().to_string(),
        place: Place::File,
        key: "sensors".to_owned(),
        value: None,
        message: "no sensor has inputs, so there is nothing to listen to; add inputs = [ … ] to them"
            .to_owned(),
    }))
}

/// Why an API is not served at the address of `--http`.
fn needs_tokens(config: &Config) -> Usage {
    let listen = config.http.listen;
    Usage(format!("{listen}: without tokens (http.auth) only a loopback address is served"))
}

/// Whether the reader of our output has closed it.
pub fn is_closed_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
