//! utm-fusion for Python: the compiled part of the package `utm_fusion`. Types are declared in `utm_fusion/_native.pyi`.

mod columns;
mod commands;
mod objects;
mod records;
mod replay;
mod source;
mod table;
mod told;

use pyo3::prelude::*;

use source::{Error, InputWarning};

/// The compiled part of `utm_fusion`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Error", py.get_type::<Error>())?;
    module.add("InputWarning", py.get_type::<InputWarning>())?;
    module.add_class::<records::Records>()?;
    module.add_class::<table::Table>()?;
    module.add_function(wrap_pyfunction!(records::records, module)?)?;
    module.add_function(wrap_pyfunction!(table::table, module)?)?;
    module.add_function(wrap_pyfunction!(table::plots, module)?)?;
    module.add_function(wrap_pyfunction!(commands::main, module)?)?;
    module.add_function(wrap_pyfunction!(commands::encode, module)?)?;
    module.add_function(wrap_pyfunction!(replay::replay, module)?)?;
    module.add_function(wrap_pyfunction!(commands::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(commands::evaluate, module)?)?;
    Ok(())
}
