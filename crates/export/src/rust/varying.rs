//! The observer at varying periods as Rust.

use std::fmt::Write;

use luenberger_observers::{MatrixName, VaryingPeriodStep};
use nalgebra::{DMatrix, Dyn};

use super::{matrix, of};
use crate::{Export, number};

/// The body of `observer()`. The step takes (u, dt): the inputs applied since the last step, and the time since then.
pub(super) fn observer(text: &mut String, export: &Export, step: &VaryingPeriodStep<f64, Dyn, Dyn, Dyn>) {
    let stored = |m: &DMatrix<f64>| matrix(export, &m.map(|x| export.scalar.round(x)));
    let literal = |x: f64| number::rust(export.scalar.round(x), export.scalar);
    let (observer, nominal) = (step.observer(), step.observer().nominal());
    let constructor = if nominal.coupling().is_some() { "semi_implicit" } else { "new" };
    _ = writeln!(text, "    // The last input is the time since the last step; its columns of B and D are zero.");
    _ = writeln!(text, "    let nominal = StaticSampledCubicObserver::{constructor}(SampledCubicGains {{");
    for (field, m) in [
        ("ad", nominal.ad()),
        ("bd", nominal.bd()),
        ("c", nominal.c()),
        ("ld", nominal.ld()),
        ("n", nominal.n()),
        ("theta", nominal.theta()),
    ] {
        _ = writeln!(text, "        {field}: {},", stored(m));
    }
    _ = writeln!(text, "        w: {},\n        period: {},", literal(nominal.w()), literal(export.observer.period()));
    let coupling = nominal.coupling().map_or_else(String::new, |coupling| format!(", {}", stored(coupling)));
    let feedthrough = of(export, MatrixName::D).map_or_else(String::new, |d| format!("?.with_feedthrough({d})"));
    let longest = literal(observer.longest());
    let (a, b, k) = (stored(observer.a()), stored(observer.b()), stored(observer.k()));
    _ = write!(
        text,
        "    }}{coupling}){feedthrough}?;
    let (a, b, k) = ({a}, {b}, {k});
    StaticVaryingPeriodStep::new(VaryingPeriodObserver::new(nominal, a, b, k, {longest})?)
"
    );
}
