//! `demo`: the bundled flight through the engine, with a live table in the terminal.

use super::{CommandResult, Outcome};

/// Shows the main job on a bundled flight: radar and transponders in, one air picture out.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
pub fn run(_args: &Args) -> CommandResult {
    Ok(Outcome::Done)
}
