//! Hints for a command line without a configuration.

use std::ffi::OsString;
use std::path::Path;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// Adds a corrected command line to the error, if `arguments` (without the program's name) make it evident.
pub fn with_tip(mut error: Error, arguments: impl IntoIterator<Item = OsString>) -> Error {
    let kinds =
        [ErrorKind::MissingRequiredArgument, ErrorKind::UnknownArgument, ErrorKind::InvalidSubcommand];
    if kinds.contains(&error.kind()) {
        let arguments: Vec<String> =
            arguments.into_iter().map(|argument| argument.to_string_lossy().into_owned()).collect();
        if let Some(tip) = tip(&arguments) {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
        }
    }
    error
}

/// Commands of features, and whether the program was built with them.
const FEATURES: [(&str, &str, bool); 3] = [
    ("cluster", "cluster", cfg!(feature = "cluster")),
    ("completions", "completions", cfg!(feature = "completions")),
    ("man", "completions", cfg!(feature = "completions")),
];

fn tip(arguments: &[String]) -> Option<String> {
    let (command, rest) = arguments.split_first()?;
    if let Some((_, feature, false)) = FEATURES.iter().find(|(of, ..)| of == command) {
        return Some(format!("`{command}` is part of a program that was built with --features {feature}"));
    }
    let is_named = rest.iter().any(|argument| argument == "--config" || argument.starts_with("--config="));
    if is_named || !["replay", "record"].contains(&command.as_str()) {
        return None;
    }
    if let Some(file) = rest.iter().find(|argument| argument.ends_with(".toml")) {
        return Some(format!("a configuration is named with --config: --config {file}"));
    }
    // A word after an option may be its value.
    let is_input = |place: &usize| {
        let after_option = *place > 0 && rest[place - 1].starts_with('-');
        !rest[*place].starts_with('-') && !after_option && Path::new(&rest[*place]).is_file()
    };
    let input = (0..rest.len()).find(is_input).map_or("CAPTURE", |place| &rest[place]);
    (command == "replay").then(|| {
        format!(
            "`utm-fusion info {input} --config-out site.toml` writes a configuration for it, to be filled in"
        )
    })
}
