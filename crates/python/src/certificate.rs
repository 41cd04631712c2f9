//! Certificates: facts, files, verification.

use luenberger_proof::certificate::{Certificate as Proof, Fact, verify as check};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::{self, dictionary};

/// The theorems of a design, each decided.
#[pyclass(frozen, module = "luenberger._luenberger")]
pub(crate) struct Certificate {
    pub(crate) proof: Proof,
    pub(crate) title: String,
}

fn facts<'py, 'a>(py: Python<'py>, facts: impl Iterator<Item = &'a Fact>) -> PyResult<Bound<'py, PyList>> {
    let one = |fact: &Fact| -> PyResult<Bound<'py, PyDict>> {
        Ok(dictionary!(py;
            inequality = fact.inequality.as_str(),
            verdict = fact.verdict.word().to_lowercase(),
            margin = fact.verdict.margin(),
            words = fact.to_string(),
        ))
    };
    PyList::new(py, facts.map(one).collect::<PyResult<Vec<_>>>()?)
}

#[pymethods]
impl Certificate {
    /// The inequalities of all theorems.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        facts(py, self.proof.facts())
    }

    /// What each proved theorem states.
    fn statements(&self) -> Vec<String> {
        self.proof.theorems().iter().map(luenberger_proof::certificate::ProvedTheorem::words).collect()
    }

    /// `proved` or `undecided`: a false inequality is one of its P, and refutes no observer.
    fn verdict(&self) -> &'static str {
        if self.proof.is_proved() { "proved" } else { "undecided" }
    }

    /// The certificate file.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        let file = py.detach(|| self.proof.file(&self.title));
        file.map(|file| file.to_json()).map_err(|why| error::plain(py, "NotProved", why))
    }
}

/// What a certificate file proves; everything is derived again from its data.
#[pyfunction]
#[pyo3(signature = (data, /))]
pub(crate) fn verify(py: Python<'_>, data: Vec<u8>) -> PyResult<Bound<'_, PyDict>> {
    let proved = py.detach(|| check(&data)).map_err(|why| error::plain(py, "Rejected", why))?;
    Ok(dictionary!(py;
        title = proved.title.as_str(),
        statement = proved.statement.as_str(),
        facts = facts(py, proved.facts.iter())?,
    ))
}
