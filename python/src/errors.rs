//! What went wrong, for Python.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;

create_exception!(sil_host, SilError, PyValueError, "A file, a log or a choice that can't be used; the text says why.");

/// With the library's own words.
pub(crate) fn refused(error: impl Display) -> PyErr {
    SilError::new_err(error.to_string())
}
