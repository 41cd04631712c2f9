//! A recorded observer as Rust.

use std::fmt::Write;

use luenberger_observers::{Observer, SampledObserver};

use super::plant;
use crate::extension::SampledExtension;
use crate::{Export, number};

/// The type of the observer.
pub(super) fn kind(export: &Export, observer: &SampledExtension<f64>) -> String {
    let own = Observer::<f64>::dimensions(observer.observer());
    let scalar = export.scalar.name();
    let sizes = [own.state, own.estimate, own.inputs, own.outputs, own.state + own.estimate];
    let sizes = sizes.map(|size| format!("Const<{size}>")).join(", ");
    format!("InterSampleObserver<Model, Extension, {scalar}, {sizes}>")
}

/// The body of `observer()`.
pub(super) fn observer(text: &mut String, export: &Export, observer: &SampledExtension<f64>) {
    let period = number::rust(export.scalar.round(observer.period()), export.scalar);
    _ = writeln!(text, "    InterSampleObserver::new(Model, Extension, {period}, {})", observer.substeps());
}

/// The type `Extension`: the observer in continuous time.
pub(super) fn model(text: &mut String, export: &Export, observer: &SampledExtension<f64>) {
    let scalar = export.scalar.name();
    let own = Observer::<f64>::dimensions(observer.observer());
    let (z, n, m, p) = (own.state, own.estimate, own.inputs, own.outputs);
    let zero = number::rust(0.0, export.scalar);
    let maps = observer.observer().routines();
    let known = m + p;
    _ = write!(
        text,
        "
/// The observer z' = g(t, z, u, y), xhat = k(t, z, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extension;

/// (u, y).
fn known(u: &SVector<{scalar}, {m}>, y: &SVector<{scalar}, {p}>) -> [{scalar}; {known}] {{
    let mut all = [{zero}; {known}];
    all.iter_mut().zip(u.iter().chain(y.iter())).for_each(|(entry, x)| *entry = *x);
    all
}}

impl luenberger_observers::Observer<{scalar}> for Extension {{
    type State = SVector<{scalar}, {z}>;
    type Input = SVector<{scalar}, {m}>;
    type Output = SVector<{scalar}, {p}>;
    type Estimate = SVector<{scalar}, {n}>;

    fn dimensions(&self) -> ObserverDimensions {{
        ObserverDimensions {{ state: {z}, inputs: {m}, outputs: {p}, estimate: {n} }}
    }}

    fn derivative(&self, t: {scalar}, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {{
        let mut out = [{zero}; {z}];
        rate(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }}

    fn estimate(&self, t: {scalar}, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {{
        let mut out = [{zero}; {n}];
        estimate(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }}

{jump}    fn initial(&self, t: {scalar}, xhat: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {{
        let mut out = [{zero}; {z}];
        start(t, &xhat.data.0[0], y.as_slice(), &mut out);
        SVector::from(out)
    }}
}}
",
        jump = if maps.jump.is_some() { jump(scalar, z, &zero) } else { String::new() }
    );
    let dialect = plant::dialect(export.scalar);
    let all = [
        ("rate", "g(t, z, u, y)", &maps.rate, (z, known)),
        ("estimate", "k(t, z, y)", &maps.estimate, (z, known)),
        ("start", "z for an estimate and the output that it predicts", &maps.start, (n, p)),
    ];
    let jump = maps.jump.iter().map(|jump| ("after", "The state after the jump at a sample", jump, (z, known)));
    for (name, what, routine, sizes) in all.into_iter().chain(jump) {
        plant::function(text, (name, what), routine, &dialect, sizes);
    }
}

/// The jump of the state at a sample.
fn jump(scalar: &str, z: usize, zero: &str) -> String {
    format!(
        "    fn jump(&self, t: {scalar}, z: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {{
        let mut out = [{zero}; {z}];
        after(t, &z.data.0[0], &known(u, y), &mut out);
        SVector::from(out)
    }}

"
    )
}
