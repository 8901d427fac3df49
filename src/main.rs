//! The program `utm-fusion`.

use std::env;
use std::process::ExitCode;

use mimalloc::MiMalloc;
use utm_fusion::commands::cli;

/// Returns memory to the system after a short peak such as a checkpoint or a picture. The C library's allocator keeps most of it,
/// per thread.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    ExitCode::from(cli::main(env::args_os()))
}
