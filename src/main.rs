//! The program `utm-fusion`.

use std::env;
use std::process::ExitCode;

use mimalloc::MiMalloc;
use utm_fusion::commands::cli;

/// Gives back what a checkpoint or a picture has taken for a moment; the C library's keeps most of it, for each thread.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    ExitCode::from(cli::main(env::args_os()))
}
