//! The command line, one file per subcommand. Data are written to standard output, everything else to standard error.

pub mod address;
mod alert_file;
pub mod assess;
mod broadcast;
pub mod check;
pub mod cli;
#[cfg(feature = "cluster")]
pub mod cluster;
#[cfg(feature = "completions")]
pub mod completions;
pub mod decode;
pub mod demo;
mod demo_score;
pub mod edition;
pub mod encode;
pub mod evaluate;
pub mod info;
mod line_file;
pub mod locate;
pub mod moment;
mod notify;
pub mod pace;
pub mod progress;
pub mod record;
mod reload;
pub mod replay;
mod replay_output;
mod reserved_ports;
pub mod run;
mod screen;
pub mod simulate;
pub mod summary;
mod table;
pub mod tip;
pub mod unmatched;
mod zones;

use std::error::Error;
use std::io;
use std::path::Path;

use api::StartError;
use lab::simulate::Crowded;
use service::notices::UnusableReceiver;
use site::areas::AreaError;
use site::config::{Config, ConfigError, ConfigErrors, Place};

/// Result of a command that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The command was completed.
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

/// Result of a command; [`exit_code`] distinguishes the errors.
pub type CommandResult = Result<Outcome, Box<dyn Error + Send + Sync>>;

/// Arguments that contradict each other: exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Refuses Parquet in a program that was built without it, before a file is made.
fn check_parquet() -> Result<(), Usage> {
    match cfg!(feature = "parquet") {
        true => Ok(()),
        false => Err(Usage(
            "this program was built without Parquet; choose csv, or build it with --features parquet"
                .to_owned(),
        )),
    }
}

/// Refuses `keys` that need MQTT in a program that was built without it, before anything starts.
fn check_mqtt(file: &Path, keys: impl Iterator<Item = String>) -> Result<(), ConfigErrors> {
    let keys = keys.collect::<Vec<_>>().join(", ");
    if cfg!(feature = "mqtt") || keys.is_empty() {
        return Ok(());
    }
    let remedy = format!("build it with --features mqtt, or remove {keys}");
    Err(refusal(file, &keys, format!("this program was built without MQTT; {remedy}")))
}

/// Keys of sensors that are read from a broker.
fn mqtt_inputs(config: &Config) -> impl Iterator<Item = String> {
    config.sensors.iter().enumerate().flat_map(|(sensor, of)| {
        let connections = of.connections.iter().enumerate();
        connections
            .filter(|(_, connection)| connection.is_subscription())
            .map(move |(index, _)| format!("sensors[{sensor}].connections[{index}]"))
    })
}

/// Keys of brokers to which alerts and tracks are published.
fn mqtt_receivers(config: &Config) -> impl Iterator<Item = String> {
    let alerts = config.alerts.mqtt.iter().map(|_| "alerts.mqtt".to_owned());
    alerts.chain((0..config.output.mqtt.len()).map(|index| format!("output.mqtt[{index}]")))
}

/// Exit code of the process: 0 done, 1 run-time failure, 2 wrong usage, 3 invalid configuration, 4 input not completely read, 5
/// an evaluation threshold was missed.
///
/// A closed pipe is not a failure: its reader has read enough.
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
                || error.is::<UnusableReceiver>()
                || error.is::<Crowded>() =>
        {
            3
        }
        #[cfg(feature = "cluster")]
        Err(error) if error.is::<crate::app::JoinRefused>() => 3,
        Err(_) => 1,
    }
}

/// Loads the configuration of a command that listens, which needs an input.
fn load_live(file: &Path) -> Result<Config, ConfigErrors> {
    let config = Config::load(file)?;
    if config.sensors.iter().any(|sensor| !sensor.inputs.is_empty() || !sensor.connections.is_empty()) {
        return Ok(config);
    }
    let message = "no sensor has inputs, so there is nothing to listen to; add inputs = [ … ] to them";
    Err(refusal(file, "sensors", message.to_owned()))
}

/// Error about a key of a configuration that the command cannot use.
fn refusal(file: &Path, key: &str, message: String) -> ConfigErrors {
    let (file, key) = (file.display().to_string(), key.to_owned());
    ConfigErrors::from(ConfigError { file, place: Place::File, key, value: None, message })
}

/// Error about an API address that other machines can reach without a token.
fn needs_tokens(config: &Config) -> Usage {
    let listen = config.http.listen;
    Usage(format!("{listen}: without tokens (http.auth) only a loopback address is served"))
}

/// Whether the error means that the reader of the output has closed it.
pub fn is_closed_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SITE: &str = r#"
        [site]
        name = "north"
        sac = 25
        sic = 1
        latitude_deg = 52.0
        longitude_deg = -0.5
        height_amsl_m = 90.0
        [[sensors]]
        id = "gateway"
        kind = "remote-id"
        sac = 25
        sic = 2
        connections = [
            { format = "http" },
            { format = "mqtt", address = "mqtt://127.0.0.1:1883" },
        ]
    "#;

    #[test]
    fn keys_that_need_mqtt_are_found() {
        let config =
            |more: &str| Config::parse(&format!("{SITE}{more}"), "/site.toml", std::iter::empty()).unwrap();
        let site = config(
            "[[output.mqtt]]\nid = \"city\"\nhost = \"b.example\"\n[alerts.mqtt]\nhost = \"b.example\"\n",
        );
        assert_eq!(mqtt_inputs(&site).collect::<Vec<_>>(), ["sensors[0].connections[1]"]);
        assert_eq!(mqtt_receivers(&site).collect::<Vec<_>>(), ["alerts.mqtt", "output.mqtt[0]"]);
        assert_eq!(mqtt_receivers(&config("")).count(), 0);
    }

    #[test]
    fn mqtt_is_refused_only_without_its_feature() {
        let checked = check_mqtt(Path::new("site.toml"), ["alerts.mqtt".to_owned()].into_iter());
        let refused = "site.toml: alerts.mqtt: this program was built without MQTT; build it with --features mqtt, or remove alerts.mqtt";
        match cfg!(feature = "mqtt") {
            true => assert_eq!(checked, Ok(())),
            false => assert_eq!(checked.unwrap_err().to_string(), refused),
        }
        assert_eq!(check_mqtt(Path::new("site.toml"), std::iter::empty()), Ok(()));
    }
}
