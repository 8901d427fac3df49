//! `completions` and `man`, for packagers.

use std::io::{self, Write};

use super::{CommandResult, Outcome};

/// Prints the completions of a shell.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Name of the shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Runs `completions` for the program's `command`.
pub fn run(args: &Args, mut command: clap::Command, out: &mut impl Write) -> CommandResult {
    let name = command.get_name().to_owned();
    // The generator panics if standard output is closed, so it writes to memory first.
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut text);
    out.write_all(&text)?;
    Ok(Outcome::Done)
}

/// Runs `man`: one page, utm-fusion(1), with all subcommands and options, so that a search finds all of them.
pub fn man(mut command: clap::Command, out: &mut impl Write) -> CommandResult {
    command.build();
    let page = clap_mangen::Man::new(command.clone());
    let mut text = Vec::new();
    page.render_title(&mut text)?;
    page.render_name_section(&mut text)?;
    page.render_synopsis_section(&mut text)?;
    page.render_description_section(&mut text)?;
    page.render_options_section(&mut text)?;
    for subcommand in command.get_subcommands().filter(|of| of.get_name() != "help") {
        section(subcommand, &mut text)?;
    }
    page.render_extra_section(&mut text)?;
    out.write_all(&text)?;
    Ok(Outcome::Done)
}

/// A subcommand: heading with its name, and its sections one level below.
fn section(subcommand: &clap::Command, out: &mut Vec<u8>) -> io::Result<()> {
    writeln!(out, ".SH \"UTM\\-FUSION {}\"", subcommand.get_name().to_uppercase())?;
    let page = clap_mangen::Man::new(subcommand.clone());
    let mut text = Vec::new();
    page.render_synopsis_section(&mut text)?;
    page.render_description_section(&mut text)?;
    page.render_options_section(&mut text)?;
    out.write_all(String::from_utf8_lossy(&text).replace(".SH ", ".SS ").as_bytes())
}
