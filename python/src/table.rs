//! `table`: records of a category as columns.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow_array::RecordBatchIterator;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_schema::ffi::FFI_ArrowSchema;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use utm_fusion::capture::{Capture, ReadError};
use utm_fusion::decode::{Decoder, Tables};

use crate::columns::{Frame, Gatherer, Shelf, take};
use crate::source::{EditionNames, Source, check_signals, complaint, decoder, error, warn};

/// Number of datagrams between checks for an interrupt.
const AT_ONCE: usize = 4096;

/// The columns of `plots`: columns of CAT048 with a radar's measurements, and their names in the table.
const PLOT: &[(&str, &str)] = &[
    ("time", "time"),
    ("I048_140_s", "time_of_day_s"),
    ("sac", "sac"),
    ("sic", "sic"),
    ("I048_020_typ", "type"),
    ("I048_161_track_number", "track_number"),
    ("I048_040_rho_m", "range_m"),
    ("I048_040_theta_deg", "azimuth_deg"),
    ("I048_110_height_m", "height_m"),
    ("I048_090_flight_level", "flight_level"),
    ("I048_200_speed_m_s", "speed_m_s"),
    ("I048_200_heading_deg", "heading_deg"),
    ("I048_070_mode_3a", "mode_3a"),
    ("I048_220", "address"),
    ("I048_240", "callsign"),
];

/// Columns for any library with Arrow's PyCapsule interface: pyarrow.table(t), polars.DataFrame(t). They can be exported several
/// times.
///
/// `unread` is a table of the data that could not be read or were not decoded (None if there are none); `faults` has the number
/// of errors by reason; `damage` describes the damage that ends the capture, if any.
#[pyclass(module = "utm_fusion", frozen)]
pub(crate) struct Table {
    frame: Frame,
    #[pyo3(get)]
    unread: Option<Py<Table>>,
    #[pyo3(get)]
    faults: BTreeMap<String, u64>,
    #[pyo3(get)]
    damage: Option<String>,
}

impl Table {
    /// A table, with the damage that ended its capture, if any.
    pub(crate) fn new(frame: Frame, damage: Option<ReadError>) -> Self {
        let damage = damage.map(|damage| damage.to_string());
        Self { frame, unread: None, faults: BTreeMap::new(), damage }
    }
}

#[pymethods]
impl Table {
    fn __len__(&self) -> usize {
        self.frame.batches.iter().map(arrow_array::RecordBatch::num_rows).sum()
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.frame.schema.fields().iter().map(|field| field.name().as_str()).collect()
    }

    fn __repr__(&self) -> String {
        format!("<utm_fusion.Table of {} rows, {} columns>", self.__len__(), self.frame.schema.fields().len())
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.frame.schema.as_ref()).map_err(error)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The protocol allows ignoring the requested types; the consumer converts.
        drop(requested_schema);
        let batches = self.frame.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, Arc::clone(&self.frame.schema));
        let stream = FFI_ArrowArrayStream::new(Box::new(reader));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    /// Converts the table to a data frame of pandas.
    fn to_pandas<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let pyarrow = this.py().import("pyarrow")?;
        pyarrow.call_method1("table", (this,))?.call_method0("to_pandas")
    }
}

/// The records of a category as columns, one row each, as in `utm-fusion decode --format parquet`. Names of columns include the
/// unit (I048_040_rho_m). Null is an item that is absent, or a value that means "unknown".
///
/// `columns` selects columns and their order. The other parameters are those of `records`. Data that cannot be read are in the
/// table's `unread` and `faults` and cause an InputWarning. So does a truncated or damaged capture, which `damage` describes.
#[pyfunction]
#[pyo3(signature = (source, cat, *, columns=None, edition=None, untyped=false, hex=false))]
pub(crate) fn table(
    py: Python<'_>,
    source: Source,
    cat: u8,
    columns: Option<Vec<String>>,
    edition: Option<EditionNames>,
    untyped: bool,
    hex: bool,
) -> PyResult<Table> {
    let decoder = decoder(Some(cat), edition, untyped)?;
    let wanted: Option<Vec<_>> =
        columns.as_ref().map(|names| names.iter().map(|name| (name.as_str(), name.as_str())).collect());
    py.detach(|| read(source, &decoder, cat, wanted.as_deref(), hex))
}

/// The target reports of radars (CAT048) as columns: `time` (UTC), `time_of_day_s`, `sac`, `sic`, `type` (I048/020 TYP),
/// `track_number`, `range_m` (slant), `azimuth_deg`, `height_m` (I048/110), `flight_level` (hundreds of feet), `speed_m_s`,
/// `heading_deg`, `mode_3a`, `address`, `callsign`. Null is a value that the plot does not have. Errors are reported as by
/// `table`.
#[pyfunction]
pub(crate) fn plots(py: Python<'_>, source: Source) -> PyResult<Table> {
    let decoder = decoder(Some(48), None, false)?;
    py.detach(|| read(source, &decoder, 48, Some(PLOT), false))
}

fn read(
    source: Source,
    decoder: &Decoder,
    cat: u8,
    wanted: Option<&[(&str, &str)]>,
    hex: bool,
) -> PyResult<Table> {
    let mut capture = source.open().map_err(error)?;
    let shelf = Shelf::default();
    let records = format!("cat{cat:03}");
    let mut tables = Tables::new(hex, |name, columns| {
        let gatherer = match wanted {
            Some(wanted) if name == records => Gatherer::only(name, columns, wanted, &shelf)?,
            _ => Gatherer::new(name, columns, &shelf),
        };
        let table: Box<dyn utm_fusion::formats::table::TableWriter> = Box::new(gatherer);
        Ok(Some(table))
    });
    tables.begin(cat, &decoder.editions).map_err(error)?;
    let damage = fill(&mut capture, decoder, &mut tables)?;
    let complaint = complaint(&capture, tables.faults(), damage.as_ref());
    let faults = tables.faults().counts().clone();
    tables.finish().map_err(error)?;
    if let Some(text) = complaint {
        Python::attach(|py| warn(py, &text))?;
    }
    let unread = take(&shelf, "unread");
    let unread = unread.map(|frame| Python::attach(|py| Py::new(py, Table::new(frame, None)))).transpose()?;
    let frame = take(&shelf, &records).ok_or_else(|| error("the table was not made"))?;
    Ok(Table { frame, unread, faults, damage: damage.map(|damage| damage.to_string()) })
}

/// Reads a capture into tables, up to its end or to the damage that ends it.
fn fill(capture: &mut Capture, decoder: &Decoder, tables: &mut Tables<'_>) -> PyResult<Option<ReadError>> {
    for count in 0_usize.. {
        if count.is_multiple_of(AT_ONCE) {
            check_signals()?;
        }
        match capture.next() {
            Some(Ok(datagram)) => decoder.datagram(&datagram, None, tables).map_err(error)?,
            Some(Err(damage)) => return Ok(Some(damage)),
            None => break,
        }
    }
    Ok(None)
}
