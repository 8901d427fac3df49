//! The command line of `utm-fusion`.

use std::env;
use std::ffi::OsString;
use std::io::{self, IsTerminal};

use clap::{Parser, Subcommand};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::FormatTime;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

#[cfg(feature = "completions")]
use super::completions;
use super::{
    assess, check, decode, demo, encode, evaluate, exit_code, info, is_closed_pipe, locate, record, replay,
    run, simulate, tip::with_tip,
};
use service::live::now;

/// One air picture of drone traffic from radar (ASTERIX CAT048) and transponders (CAT129).
#[derive(Parser)]
#[command(
    version,
    after_help = "Exit codes: 0 done, 1 failure, 2 wrong usage, 3 configuration invalid, 4 the input could not all be read, 5 an evaluation threshold was missed.\nThe variable RUST_LOG sets what is logged to standard error (default: info)."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Run(run::Args),
    Replay(replay::Args),
    Decode(decode::Args),
    Encode(encode::Args),
    Info(info::Args),
    Locate(locate::Args),
    Simulate(simulate::Args),
    Evaluate(evaluate::Args),
    Assess(assess::Args),
    Check(check::Args),
    #[cfg(feature = "cluster")]
    Cluster(super::cluster::Args),
    Record(record::Args),
    #[cfg(feature = "completions")]
    Completions(completions::Args),
    /// Prints the manual page, utm-fusion(1).
    #[cfg(feature = "completions")]
    Man,
}

impl Command {
    /// Whether the command serves until it is stopped. Its log lines then have a time.
    const fn is_service(&self) -> bool {
        match self {
            Self::Run(_) | Self::Record(_) => true,
            Self::Demo(args) => args.http.is_some(),
            Self::Replay(args) => args.serve,
            _ => false,
        }
    }
}

/// Time of a log line: RFC 3339 in UTC, with milliseconds.
struct LogTime;

impl FormatTime for LogTime {
    fn format_time(&self, line: &mut Writer<'_>) -> std::fmt::Result {
        write!(line, "{}", now())
    }
}

/// Log levels from `RUST_LOG`: a level, or levels of modules such as `warn,utm_service::live=debug`. An invalid value is ignored.
fn wanted_logs(said: Option<&str>) -> Targets {
    let usual =
        || Targets::new().with_default(LevelFilter::INFO).with_target("async_nats", LevelFilter::ERROR);
    said.filter(|said| !said.is_empty()).and_then(|said| said.parse().ok()).unwrap_or_else(usual)
}

/// Runs the command given by the arguments, the first of which is the program's name. Returns the exit code. Wrong usage ends the
/// process.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = Cli::try_parse_from(&arguments)
        .unwrap_or_else(|error| with_tip(error, arguments.into_iter().skip(1)).exit());
    let logs = tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_max_level(LevelFilter::TRACE)
        .with_target(false)
        .with_timer(LogTime);
    let wanted = wanted_logs(env::var("RUST_LOG").ok().as_deref());
    match &cli.command {
        Command::Run(run::Args { log_format: run::LogFormat::Json, .. }) => {
            logs.json().flatten_event(true).finish().with(wanted).init();
        }
        command if command.is_service() => logs.finish().with(wanted).init(),
        _ => logs.without_time().finish().with(wanted).init(),
    }
    let result = match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Run(args) => run::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Decode(args) => decode::run(args, &mut io::stdout().lock()),
        Command::Encode(args) => encode::run(args),
        Command::Info(args) => info::run(args, &mut io::stdout().lock()),
        Command::Locate(args) => locate::run(args, &mut io::stdout().lock()),
        Command::Simulate(args) => simulate::run(args),
        Command::Evaluate(args) => evaluate::run(args, &mut io::stdout().lock()),
        Command::Assess(args) => assess::run(args, &mut io::stdout().lock()),
        Command::Check(args) => check::run(args),
        #[cfg(feature = "cluster")]
        Command::Cluster(args) => super::cluster::run(args),
        Command::Record(args) => record::run(args),
        #[cfg(feature = "completions")]
        Command::Completions(args) => {
            completions::run(args, <Cli as clap::CommandFactory>::command(), &mut io::stdout().lock())
        }
        #[cfg(feature = "completions")]
        Command::Man => completions::man(<Cli as clap::CommandFactory>::command(), &mut io::stdout().lock()),
    };
    if let Err(error) = &result
        && !is_closed_pipe(error.as_ref())
    {
        eprintln!("utm-fusion: {error}");
    }
    exit_code(&result)
}

#[cfg(test)]
mod tests {
    use tracing_subscriber::filter::LevelFilter as Level;

    use super::*;

    #[test]
    fn demo_without_an_address_serves_the_usual_one() {
        for (arguments, address) in [
            (&["utm-fusion", "demo", "--http"][..], Some("127.0.0.1:8080")),
            (&["utm-fusion", "demo", "--http", "--seed", "2"], Some("127.0.0.1:8080")),
            (&["utm-fusion", "demo", "--http", "8081"], Some("127.0.0.1:8081")),
            (&["utm-fusion", "demo"], None),
        ] {
            let Command::Demo(args) = Cli::try_parse_from(arguments).unwrap().command else {
                panic!("another command")
            };
            assert_eq!(args.http.map(|address| address.to_string()).as_deref(), address, "{arguments:?}");
        }
    }

    #[test]
    fn log_filter_is_the_requested_one_or_the_default() {
        let logged = |said: Option<&str>| {
            let wanted = wanted_logs(said);
            ["utm_service::live", "utm_api", "async_nats"].map(|module| {
                let levels = [Level::ERROR, Level::WARN, Level::INFO, Level::DEBUG];
                let is_logged = |level: &&Level| {
                    level.into_level().is_some_and(|level| wanted.would_enable(module, &level))
                };
                levels.iter().rev().find(is_logged).copied()
            })
        };
        let usual = [Some(Level::INFO), Some(Level::INFO), Some(Level::ERROR)];
        for said in [None, Some(""), Some("utm_fusion=loud")] {
            assert_eq!(logged(said), usual, "{said:?}");
        }
        assert_eq!(logged(Some("debug")), [Some(Level::DEBUG); 3]);
        assert_eq!(
            logged(Some("warn,utm_service::live=debug")),
            [Some(Level::DEBUG), Some(Level::WARN), Some(Level::WARN)]
        );
        assert_eq!(logged(Some("off")), [None; 3]);
    }
}
