//! The command line of `utm-fusion`.

use std::env;
use std::ffi::OsString;
use std::io::{self, IsTerminal};

use clap::{CommandFactory, Parser, Subcommand};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use super::{
    check, completions, decode, demo, encode, evaluate, exit_code, info, is_closed_pipe, record, replay, run,
    simulate, tip::with_tip,
};

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
    Simulate(simulate::Args),
    Evaluate(evaluate::Args),
    Check(check::Args),
    #[cfg(feature = "cluster")]
    Cluster(super::cluster::Args),
    Record(record::Args),
    Completions(completions::Args),
    /// Prints the manual page, utm-fusion(1).
    Man,
}

/// What is logged, by `RUST_LOG`: a level, or levels of modules, `warn,utm_fusion::live=debug`. What cannot be read is as good as none.
fn wanted_logs(said: Option<&str>) -> Targets {
    let usual =
        || Targets::new().with_default(LevelFilter::INFO).with_target("async_nats", LevelFilter::ERROR);
    said.filter(|said| !said.is_empty()).and_then(|said| said.parse().ok()).unwrap_or_else(usual)
}

/// Does what the arguments ask for, the first of which is the program's name; the exit code. Wrong usage ends the process.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = Cli::try_parse_from(&arguments)
        .unwrap_or_else(|error| with_tip(error, arguments.into_iter().skip(1)).exit());
    let logs = tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_max_level(LevelFilter::TRACE)
        .with_target(false);
    let wanted = wanted_logs(env::var("RUST_LOG").ok().as_deref());
    match &cli.command {
        // Who collects these has no other time.
        Command::Run(run::Args { log_format: run::LogFormat::Json, .. }) => {
            logs.json().flatten_event(true).finish().with(wanted).init();
        }
        _ => logs.without_time().finish().with(wanted).init(),
    }
    let result = match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Run(args) => run::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Decode(args) => decode::run(args, &mut io::stdout().lock()),
        Command::Encode(args) => encode::run(args),
        Command::Info(args) => info::run(args, &mut io::stdout().lock()),
        Command::Simulate(args) => simulate::run(args),
        Command::Evaluate(args) => evaluate::run(args, &mut io::stdout().lock()),
        Command::Check(args) => check::run(args),
        #[cfg(feature = "cluster")]
        Command::Cluster(args) => super::cluster::run(args),
        Command::Record(args) => record::run(args),
        Command::Completions(args) => completions::run(args, Cli::command(), &mut io::stdout().lock()),
        Command::Man => completions::man(Cli::command(), &mut io::stdout().lock()),
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
    fn what_is_logged_is_what_was_asked_for_or_the_usual() {
        let logged = |said: Option<&str>| {
            let wanted = wanted_logs(said);
            ["utm_fusion::live", "utm_fusion::api", "async_nats"].map(|module| {
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
            logged(Some("warn,utm_fusion::live=debug")),
            [Some(Level::DEBUG), Some(Level::WARN), Some(Level::WARN)]
        );
        assert_eq!(logged(Some("off")), [None; 3]);
    }
}
