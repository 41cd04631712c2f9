//! A plant as a page stores it: expressions or matrices.

use std::collections::BTreeMap;

use luenberger_plants::StateSpace;
use serde::{Deserialize, Serialize};

use crate::rows::{Rows, rows};

/// A plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum StoredPlant {
    /// `x' = f`, `y = h` as expressions.
    Expressions {
        /// Names of the states.
        states: Vec<String>,
        /// Names of the inputs.
        inputs: Vec<String>,
        /// The right-hand sides.
        f: Vec<String>,
        /// The outputs.
        h: Vec<String>,
        /// Its parameters, if they are not those of the experiment.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        parameters: Option<BTreeMap<String, f64>>,
    },
    /// `x' = A x + B u`, `y = C x + D u`.
    Linear {
        /// A.
        a: Rows,
        /// B.
        b: Rows,
        /// C.
        c: Rows,
        /// D, if it is not 0.
        d: Option<Rows>,
    },
}

impl StoredPlant {
    /// A linear plant.
    pub fn linear(plant: &StateSpace) -> Self {
        let [a, b, c] = [&plant.a, &plant.b, &plant.c].map(rows);
        Self::Linear { a, b, c, d: plant.d.as_ref().map(rows) }
    }

    /// The number of inputs.
    pub(crate) fn inputs(&self) -> usize {
        match self {
            Self::Expressions { inputs, .. } => inputs.len(),
            Self::Linear { b, .. } => b.first().map_or(0, Vec::len),
        }
    }
}
