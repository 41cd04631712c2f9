//! The extension module of the Python package `luenberger`: the library on numpy's arrays.
//!
//! Functions here take arrays that `python/luenberger/_arrays.py` has checked, and return dictionaries; the classes
//! that users see are in Python. A design is that of a study with one observer, which Python writes as JSON: what a
//! study can do, the package can, and it is written once.
//!
//! | file | subject |
//! |---|---|
//! | `linalg` | matrix equations, placement, observability |
//! | `observer` | a designed observer: its numbers, runs and files |
//! | `stepper` | an observer stepped sample by sample |
//! | `certificate` | facts, certificate files, verification |
//! | `run` | study files, trajectories, the fit of a filter to a log |
//! | `stream` | an observer on rows that arrive |
//! | `blocks` | sweeps that several processes compute |
//! | `export` | code for the target |
//! | `kinds` | the kinds of observers |
//! | `words` | messages in the words of Python |
//! | `work` | long computations: without the interpreter's lock, with progress, ended by Ctrl-C |
//! | `argument`, `array`, `error` | arguments, arrays as matrices; errors as exceptions with numbers |

mod argument;
mod array;
mod blocks;
mod certificate;
mod error;
mod export;
mod kinds;
mod linalg;
mod observer;
mod run;
mod stepper;
mod stream;
mod words;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _luenberger(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<blocks::Blocks>()?;
    module.add_class::<certificate::Certificate>()?;
    module.add_class::<observer::Design>()?;
    module.add_class::<stepper::Stepper>()?;
    module.add_class::<run::StudyFile>()?;
    module.add_class::<stream::RowStream>()?;
    module.add_function(wrap_pyfunction!(certificate::verify, module)?)?;
    module.add_function(wrap_pyfunction!(kinds::kinds, module)?)?;
    module.add_function(wrap_pyfunction!(run::check, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::status, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::reduce, module)?)?;
    linalg::register(module)
}
