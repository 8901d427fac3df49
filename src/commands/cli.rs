//! The command line of `utm-fusion`.

use std::ffi::OsString;
use std::io::{self, IsTerminal};

use clap::{CommandFactory, Parser, Subcommand};
use tracing_subscriber::EnvFilter;

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

/// Does what the arguments ask for, the first of which is the program's name; the exit code. Wrong usage ends the process.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = Cli::try_parse_from(&arguments)
        .unwrap_or_else(|error| with_tip(error, arguments.into_iter().skip(1)).exit());
    let filter =
        EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info,async_nats=error"));
    let logs = tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_env_filter(filter)
        .with_target(false);
    match &cli.command {
        // Who collects these has no other time.
        Command::Run(run::Args { log_format: run::LogFormat::Json, .. }) => {
            logs.json().flatten_event(true).init();
        }
        _ => logs.without_time().init(),
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
