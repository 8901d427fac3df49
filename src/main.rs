//! The program `utm-fusion`.

use std::env;
use std::process::ExitCode;

use utm_fusion::commands::cli;

fn main() -> ExitCode {
    ExitCode::from(cli::main(env::args_os()))
}
