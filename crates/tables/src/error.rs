//! Errors of a configuration, with their places.

use std::cell::RefCell;
use std::fmt::{self, Display};
use std::path::Path;

/// The place where a value is written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The file as a whole, where something is missing from it.
    File,
    /// A line of the file, counted from 1.
    Line(usize),
    /// An environment variable, by its name.
    Variable(String),
}

/// One error: `site.toml:12: sensors[0].latitude_deg = 152.5: a latitude is between -90 and 90 degrees`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ConfigError {
    /// The file, by the name it was given.
    pub file: String,
    /// The line or the variable.
    pub place: Place,
    /// The path of the key, `sensors[0].latitude_deg`; empty for an error of the whole text.
    pub key: String,
    /// The refused value as TOML, if it is short enough to show.
    pub value: Option<String>,
    /// The problem and its remedy.
    pub message: String,
}

impl Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Place::File => write!(f, "{}: ", self.file)?,
            Place::Line(line) => write!(f, "{}:{line}: ", self.file)?,
            Place::Variable(name) => write!(f, "environment variable {name}: ")?,
        }
        match (self.key.is_empty(), &self.value) {
            (true, _) => {}
            (false, None) => write!(f, "{}: ", self.key)?,
            (false, Some(value)) => write!(f, "{} = {value}: ", self.key)?,
        }
        f.write_str(&self.message)
    }
}

/// All errors, those of the file first, then those of the variables; never empty. Displays one error a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ConfigErrors(Vec<ConfigError>);

impl ConfigErrors {
    /// `errors` sorted by place; `None` if there are none.
    fn of(mut errors: Vec<ConfigError>) -> Option<Self> {
        errors.sort_by(|a, b| a.place.cmp(&b.place));
        (!errors.is_empty()).then_some(Self(errors))
    }

    /// The errors, at least one.
    pub fn iter(&self) -> std::slice::Iter<'_, ConfigError> {
        self.0.iter()
    }
}

/// Reads the file at `path`; `what` names its kind in the error.
///
/// # Errors
/// The file cannot be read.
pub fn read_file(path: &Path, what: &str) -> Result<String, ConfigErrors> {
    #[expect(clippy::disallowed_methods, reason = "the one place that reads configurations and scenarios")]
    std::fs::read_to_string(path).map_err(|error| {
        ConfigErrors::from(ConfigError {
            file: path.display().to_string(),
            place: Place::File,
            key: String::new(),
            value: None,
            message: format!("cannot be read: {error}; give the path of a {what} (TOML, UTF-8)"),
        })
    })
}

impl From<ConfigError> for ConfigErrors {
    fn from(error: ConfigError) -> Self {
        Self(vec![error])
    }
}

impl Display for ConfigErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{error}")?;
        }
        Ok(())
    }
}

/// Collects the errors found so far.
pub struct Faults {
    file: String,
    found: RefCell<Vec<ConfigError>>,
}

impl Faults {
    /// No errors yet; they will name the file `file`.
    pub fn new(file: &str) -> Self {
        Self { file: file.to_owned(), found: RefCell::default() }
    }

    /// Adds an error of the key at path `key`; `value` is the refused value.
    pub fn add(&self, place: &Place, key: &str, value: Option<String>, message: impl Display) {
        self.found.borrow_mut().push(ConfigError {
            file: self.file.clone(),
            place: place.clone(),
            key: key.to_owned(),
            value,
            message: message.to_string(),
        });
    }

    /// The file, by the name it was given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Whether there is no error of the key at `path`, of a key inside it, or of a table around it.
    pub fn none_of(&self, path: &str) -> bool {
        let is_in = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.found.borrow().iter().all(|fault| !is_in(&fault.key, path) && !is_in(path, &fault.key))
    }

    /// Whether there is an error.
    pub fn any(&self) -> bool {
        !self.found.borrow().is_empty()
    }

    /// The errors so far as an error.
    ///
    /// # Errors
    /// At least one error was added.
    pub fn check(&self) -> Result<(), ConfigErrors> {
        ConfigErrors::of(self.found.borrow().clone()).map_or(Ok(()), Err)
    }
}
