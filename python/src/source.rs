//! Input of the functions, and errors and warnings about it.

use std::ffi::CString;
use std::fmt::Display;
use std::io::Cursor;
use std::path::PathBuf;

use pyo3::exceptions::{PyException, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use pyo3::{PyErr, create_exception};
use utm_fusion::capture::{Capture, OpenError, ReadError};
use utm_fusion::commands::edition::{EditionOf, editions};
use utm_fusion::decode::{Decoder, Faults};
use utm_fusion::json::Editions;

create_exception!(utm_fusion, Error, PyException, "What the program would say, and end with.");
create_exception!(utm_fusion, InputWarning, PyUserWarning, "Some of the input could not be read.");

/// An Error with this message.
pub(crate) fn error(error: impl Display) -> PyErr {
    Error::new_err(error.to_string())
}

/// Issues an InputWarning.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    // An octet 0 would end the message. It could only come from a file name, which cannot contain one.
    let text = CString::new(text.replace('\0', " ")).map_err(error)?;
    PyErr::warn(py, &py.get_type::<InputWarning>(), &text, 1)
}

/// Raises KeyboardInterrupt if the user has requested it; for work with the interpreter released.
#[expect(clippy::redundant_closure_for_method_calls, reason = "the method itself is of one lifetime only")]
pub(crate) fn check_signals() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}

/// A file, or the contents of one.
pub(crate) enum Source {
    Path(PathBuf),
    Octets(Vec<u8>),
}

impl<'py> FromPyObject<'_, 'py> for Source {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(octets) = object.cast::<PyBytes>() {
            return Ok(Self::Octets(octets.as_bytes().to_vec()));
        }
        Ok(Self::Path(object.extract()?))
    }
}

impl Source {
    /// Opens the source.
    pub(crate) fn open(self) -> Result<Capture, OpenError> {
        match self {
            Self::Path(path) => Capture::open(&path),
            Self::Octets(octets) => {
                let size = octets.len() as u64;
                Capture::from_reader("bytes".to_owned(), Box::new(Cursor::new(octets)), Some(size))
            }
        }
    }
}

/// One edition or several.
#[derive(FromPyObject)]
pub(crate) enum EditionNames {
    One(String),
    Several(Vec<String>),
}

/// The decoder for these options, as `decode` interprets them.
pub(crate) fn decoder(category: Option<u8>, names: Option<EditionNames>, untyped: bool) -> PyResult<Decoder> {
    let names = match names {
        None => Vec::new(),
        Some(EditionNames::One(name)) => vec![name],
        Some(EditionNames::Several(names)) => names,
    };
    let given = names.iter().map(|name| name.parse::<EditionOf>()).collect::<Result<Vec<_>, _>>();
    let chosen = if untyped { Editions::untyped() } else { Editions::default() };
    let editions = editions(chosen, &given.map_err(error)?, category).map_err(error)?;
    Ok(Decoder { editions, category })
}

/// Summary of what could not be read, in the words of `decode`; `None` if everything could.
pub(crate) fn complaint(
    capture: &Capture,
    faults: &mut Faults,
    damage: Option<&ReadError>,
) -> Option<String> {
    let unread = faults.end(capture);
    let mut said = Vec::new();
    if !unread.is_empty() {
        said.push(format!("{}: {unread} could not be read", capture.name()));
    }
    if !faults.is_empty() {
        said.push(faults.to_string());
    }
    said.extend(damage.map(ToString::to_string));
    if said.is_empty() { None } else { Some(said.join("; ")) }
}
