//! `records`: a capture as dicts.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use asterix::Fault;
use fusion::time::Time;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use utm_fusion::capture::{Capture, CapturedDatagram, ReadError};
use utm_fusion::decode::{Decoder, Faults, Sink};
use utm_fusion::gateways::remote_id::BroadcastLine;
use utm_fusion::json::{
    Entry, Place, REMOTE_ID, SKIPPED, write_block, write_fault, write_messages, write_record, write_refused,
    write_skipped, write_trailer,
};
use utm_fusion::pipeline::LineFault;

use crate::objects::{Keys, Objects};
use crate::source::{EditionNames, Source, complaint, decoder, error, warn};

/// Number of datagrams read at a time, with the interpreter released.
const AT_ONCE: usize = 64;

/// Iterator over the records of a capture; returned by `records`.
#[pyclass(module = "utm_fusion")]
pub(crate) struct Records(Mutex<Reading>);

struct Reading {
    capture: Capture,
    decoder: Decoder,
    chosen: Chosen,
    /// Records read ahead.
    ready: VecDeque<Py<PyDict>>,
    keys: Keys,
    faults: Faults,
    end: End,
}

/// Which records are returned.
#[derive(Clone, Copy)]
struct Chosen {
    hex: bool,
    errors_only: bool,
}

enum End {
    NotYet,
    /// The end is reached and has not been reported.
    Reached(Option<ReadError>),
    Told,
}

/// Iterates over the records of a capture in order. Each is a dict with the content of a line of `utm-fusion decode`: `time`
/// (UTC, of the record; None in files without reception times), `offset` and `block` (its place in the file), `cat`, `sac`,
/// `sic`, `items`.
///
/// `source` is a path, or the contents of a file as bytes. `cat` selects one category. `edition` is the senders' edition: "1.31"
/// for the category `cat`, or else CAT021; "48:1.31"; or a list of these. `untyped` reads all categories with one rule for keys.
/// `errors_only` leaves out all that can be read. `hex` adds the octets of each record.
///
/// Data that cannot be read are returned as a dict with `error`, are counted in `faults`, and cause an InputWarning at the end.
/// Raises Error if the source is no capture, and after the last record if the capture is truncated or damaged.
#[pyfunction]
#[pyo3(signature = (source, *, cat=None, edition=None, untyped=false, errors_only=false, hex=false))]
pub(crate) fn records(
    source: Source,
    cat: Option<u8>,
    edition: Option<EditionNames>,
    untyped: bool,
    errors_only: bool,
    hex: bool,
) -> PyResult<Records> {
    let decoder = decoder(cat, edition, untyped)?;
    let capture = source.open().map_err(error)?;
    Ok(Records(Mutex::new(Reading {
        capture,
        decoder,
        chosen: Chosen { hex, errors_only },
        ready: VecDeque::new(),
        keys: Keys::default(),
        faults: Faults::default(),
        end: End::NotYet,
    })))
}

#[pymethods]
impl Records {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<Py<PyDict>>> {
        let reading = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(record) = reading.ready.pop_front() {
                return Ok(Some(record));
            }
            match std::mem::replace(&mut reading.end, End::Told) {
                End::NotYet => {
                    reading.end = End::NotYet;
                    reading.go_on(py)?;
                }
                End::Reached(damage) => reading.tell(py, damage)?,
                End::Told => return Ok(None),
            }
        }
    }

    /// Number of errors so far, by reason.
    #[getter]
    fn faults(&mut self) -> std::collections::BTreeMap<String, u64> {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).faults.counts().clone()
    }
}

impl Reading {
    /// Reads some datagrams and builds their records.
    fn go_on(&mut self, py: Python<'_>) -> PyResult<()> {
        py.check_signals()?;
        let Self { capture, decoder, chosen, ready, keys, faults, end } = self;
        let datagrams: Vec<CapturedDatagram> = py.detach(|| {
            let mut datagrams = Vec::with_capacity(AT_ONCE);
            while datagrams.len() < AT_ONCE {
                match capture.next() {
                    Some(Ok(datagram)) => datagrams.push(datagram),
                    Some(Err(damage)) => {
                        *end = End::Reached(Some(damage));
                        break;
                    }
                    None => {
                        *end = End::Reached(None);
                        break;
                    }
                }
            }
            datagrams
        });
        let mut done = |record: Bound<'_, PyDict>| ready.push_back(record.unbind());
        let out = Objects::new(py, keys, &mut done);
        let mut maker = Maker { out, chosen: *chosen, faults };
        for datagram in &datagrams {
            // Errors of Python are returned by `finish`.
            let Ok(()) = decoder.datagram(datagram, None, &mut maker);
        }
        maker.out.finish()
    }

    /// Reports errors in the input after the last record.
    fn tell(&mut self, py: Python<'_>, damage: Option<ReadError>) -> PyResult<()> {
        if let Some(text) = complaint(&self.capture, &mut self.faults, None) {
            warn(py, &text)?;
        }
        damage.map_or(Ok(()), |damage| Err(error(damage)))
    }
}

/// Builds a dict for everything that is found.
struct Maker<'a, 'py> {
    out: Objects<'a, 'py>,
    chosen: Chosen,
    faults: &'a mut Faults,
}

impl Sink for Maker<'_, '_> {
    type Error = std::convert::Infallible;

    fn record(&mut self, entry: &Entry<'_>) -> Result<(), Self::Error> {
        if !self.chosen.errors_only {
            write_record(&mut self.out, entry, self.chosen.hex);
        }
        Ok(())
    }

    fn block(&mut self, category: u8, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error> {
        if !self.chosen.errors_only {
            write_block(&mut self.out, category, octets, place);
        }
        Ok(())
    }

    fn fault(
        &mut self,
        fault: Fault,
        octets: &[u8],
        origin: u64,
        place: Place<'_>,
    ) -> Result<(), Self::Error> {
        self.faults.note(fault.kind.name(), place, octets);
        write_fault(&mut self.out, fault, octets, origin, place);
        Ok(())
    }

    fn skipped(&mut self, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error> {
        self.faults.note(SKIPPED, place, octets);
        write_skipped(&mut self.out, octets, place);
        Ok(())
    }

    fn trailer(&mut self, octets: &[u8], place: Place<'_>) -> Result<(), Self::Error> {
        if !self.chosen.errors_only {
            write_trailer(&mut self.out, octets, place);
        }
        Ok(())
    }

    fn remote_id(
        &mut self,
        line: Result<&BroadcastLine, LineFault>,
        octets: &[u8],
        received: Option<Time>,
        place: Place<'_>,
    ) -> Result<(), Self::Error> {
        let faults = &mut *self.faults;
        match line {
            Ok(line) => {
                let note = |_: &mut Objects<'_, '_>, sound: Result<(), String>| {
                    if sound.is_err() {
                        faults.note(REMOTE_ID, place, &line.octets);
                    }
                };
                write_messages(&mut self.out, line, received, place, self.chosen.errors_only, note);
            }
            Err(refusal) => {
                faults.note(REMOTE_ID, place, octets);
                write_refused(&mut self.out, &refusal.to_string(), octets, place);
            }
        }
        Ok(())
    }
}
