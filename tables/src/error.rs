//! What is wrong with a configuration, and where.

use std::cell::RefCell;
use std::fmt::{self, Display};
use std::path::Path;

/// Where a value was written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The file as a whole: something that should be in it is not.
    File,
    /// A line of the file, from 1.
    Line(usize),
    /// An environment variable, by its name.
    Variable(String),
}

/// One thing that is wrong: `site.toml:12: sensors[0].latitude_deg = 152.5: a latitude is between -90 and 90 degrees`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ConfigError {
    /// The file, as it was named.
    pub file: String,
    /// The line or the variable.
    pub place: Place,
    /// The path of the key, `sensors[0].latitude_deg`; empty for the text itself.
    pub key: String,
    /// The value that was refused, as TOML, where it is short enough to help.
    pub value: Option<String>,
    /// What is wrong and what to do.
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

/// Everything that is wrong, in the order of the file, then of the variables; never empty. Displayed one a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ConfigErrors(Vec<ConfigError>);

impl ConfigErrors {
    /// `errors` sorted by place, or `None` when there are none.
    fn of(mut errors: Vec<ConfigError>) -> Option<Self> {
        errors.sort_by(|a, b| a.place.cmp(&b.place));
        (!errors.is_empty()).then_some(Self(errors))
    }

    /// The errors, one or more.
    pub fn iter(&self) -> std::slice::Iter<'_, ConfigError> {
        self.0.iter()
    }
}

/// The text of the file at `path`, which is a `what`.
///
/// # Errors
/// It cannot be read.
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

/// What has been found wrong so far.
pub struct Faults {
    file: String,
    found: RefCell<Vec<ConfigError>>,
}

impl Faults {
    /// Of the file that errors name so.
    pub fn new(file: &str) -> Self {
        Self { file: file.to_owned(), found: RefCell::default() }
    }

    /// Finds fault with the key at path `key`; `value` is what was refused.
    pub fn add(&self, place: &Place, key: &str, value: Option<String>, message: impl Display) {
        self.found.borrow_mut().push(ConfigError {
            file: self.file.clone(),
            place: place.clone(),
            key: key.to_owned(),
            value,
            message: message.to_string(),
        });
    }

    /// The file, as it was named.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Whether nothing is wrong with the key at `path`, with one inside it, or with a table around it.
    pub fn none_of(&self, path: &str) -> bool {
        let is_in = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.found.borrow().iter().all(|fault| !is_in(&fault.key, path) && !is_in(path, &fault.key))
    }

    /// Whether something is wrong.
    pub fn any(&self) -> bool {
        !self.found.borrow().is_empty()
    }

    /// The faults so far as an error.
    ///
    /// # Errors
    /// There are some.
    pub fn check(&self) -> Result<(), ConfigErrors> {
        ConfigErrors::of(self.found.borrow().clone()).map_or(Ok(()), Err)
    }
}
