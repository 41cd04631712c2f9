//! An observer whose step is straight-line code, as Rust.

use std::fmt::Write;

use luenberger_observers::SampledObserver;

use super::plant;
use crate::exportable_observer::tables;
use crate::step::RecordedStep;
use crate::{Export, number};

/// The type `Step` with its function.
pub(super) fn model(text: &mut String, export: &Export, observer: &RecordedStep<f64>) {
    let scalar = export.scalar.name();
    let size = observer.dimensions();
    let (n, m, p) = (size.estimate, size.inputs, size.outputs);
    let zero = number::rust(0.0, export.scalar);
    let period = number::rust(export.scalar.round(observer.period()), export.scalar);
    let known = m + p;
    _ = write!(
        text,
        "
/// The observer z+ = g(t, z, u, y), which estimates its whole state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step;

impl luenberger_observers::SampledObserver<{scalar}> for Step {{
    type State = SVector<{scalar}, {n}>;
    type Input = SVector<{scalar}, {m}>;
    type Output = SVector<{scalar}, {p}>;
    type Estimate = SVector<{scalar}, {n}>;

    fn dimensions(&self) -> ObserverDimensions {{
        ObserverDimensions {{ state: {n}, inputs: {m}, outputs: {p}, estimate: {n} }}
    }}

    fn period(&self) -> {scalar} {{
        {period}
    }}

    fn step(&self, t: {scalar}, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {{
        let mut known = [{zero}; {known}];
        known.iter_mut().zip(u.iter().chain(y.iter())).for_each(|(entry, x)| *entry = *x);
        let mut out = [{zero}; {n}];
        next_state(t, &state.data.0[0], &known, &mut out);
        *state = SVector::from(out);
    }}

    fn estimate(&self, state: &Self::State) -> Self::Estimate {{
        *state
    }}

    fn initial(&self, _t: {scalar}, xhat: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {{
        *xhat
    }}
}}
"
    );
    let dialect = plant::dialect(export.scalar);
    let (next, _) = observer.routines();
    plant::function(text, ("next_state", "g(t, z, u, y)"), &next, &dialect, (n, known));
    for (index, table, used) in tables(&[&next]) {
        _ = write!(text, "\n{}", table.source(index, &dialect, used));
    }
}
