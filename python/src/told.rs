//! Log messages of the program as Python warnings.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use tracing::Level;
use tracing::subscriber::with_default;

use crate::source::warn;

/// Captured log lines.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(octets);
        Ok(octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Runs `work` with the interpreter released, then issues its log warnings and errors as Python warnings.
pub(crate) fn told<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    let lines = Lines::default();
    let writer = lines.clone();
    let log = tracing_subscriber::fmt()
        .with_writer(move || writer.clone())
        .with_ansi(false)
        .with_max_level(Level::WARN)
        .with_level(false)
        .with_target(false)
        .without_time()
        .finish();
    let done = py.detach(|| with_default(log, work));
    let said = std::mem::take(&mut *lines.0.lock().unwrap_or_else(PoisonError::into_inner));
    for line in String::from_utf8_lossy(&said).lines() {
        warn(py, line.trim())?;
    }
    done
}
