//! The steps of the extended and of the unscented Kalman filter.

use std::fmt::Write;

use luenberger_expression::ExpressionPlant;
use luenberger_observers::UnscentedKalmanFilter;
use nalgebra::Dyn;

use super::kernels::{self, Macros};
use super::{plant, root, scalar};
use crate::exportable_observer::Maps;
use crate::{Export, number};

pub(super) fn extended(text: &mut String, export: &Export, maps: &Maps) {
    plant::functions(text, export, maps);
    let macros = Macros::of(export);
    transition(text, export, &macros);
    macros.write(text, kernels::KALMAN);
    macros.write(text, kernels::FILTER_STEP);
}

/// The plant over a period.
pub(super) fn transition(text: &mut String, export: &Export, macros: &Macros) {
    macros.write(text, kernels::SYMMETRIC);
    if export.observer.substeps().is_some() {
        macros.write(text, kernels::CLASSICAL);
    }
    macros.write(text, kernels::TRANSITION);
}

type Unscented = UnscentedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>;

pub(super) fn unscented(text: &mut String, export: &Export, maps: &Maps, filter: &Unscented) {
    plant::functions(text, export, maps);
    let mut macros = Macros::of(export);
    let weights = filter.weights();
    macros.option("NEGATIVE_CENTRE", weights.is_negative);
    let noise = export.observer.noise_weight(export.scalar);
    for (name, x) in [
        ("DISTANCE", weights.distance),
        ("OUTER_WEIGHT", weights.outer),
        ("HALF_WEIGHT", weights.half),
        ("CENTRE_WEIGHT", weights.centre),
        ("NOISE_WEIGHT", noise),
        ("TWICE_NOISE_WEIGHT", 2.0 * noise),
    ] {
        macros.number(name, x);
    }
    macros.set("MOTION", "centre");
    macros.set("SLOPE", "motion");
    macros.set("LENGTH", export.observer.dimensions().estimate.to_string());
    macros.write(text, kernels::COLUMNS);
    if filter.substeps().is_some() {
        macros.write(text, kernels::RUNGE_KUTTA);
        macros.write(text, kernels::CLASSICAL);
        macros.write(text, kernels::NOISE);
    }
    macros.write(text, kernels::UNSCENTED);
    macros.write(text, kernels::FILTER_STEP);
}

/// The factor of s in place of its lower triangle; `definite` becomes 0 where a pivot is not positive.
pub(super) fn factor(text: &mut String, export: &Export, p: &str) {
    let (number, root, zero) = (scalar(export), root(export), number::c(0.0, export.scalar));
    _ = write!(
        text,
        "    for (j = 0; (j < {p}) && (definite != 0); ++j) {{
        for (i = j; (i < {p}) && (definite != 0); ++i) {{
            {number} entry = s[i][j];
            for (k = 0; k < j; ++k) {{
                entry = entry - (s[i][k] * s[j][k]);
            }}
            if (i > j) {{
                s[i][j] = entry / s[j][j];
            }} else if (entry > {zero}) {{
                s[j][j] = {root}(entry);
            }} else {{
                definite = 0;
            }}
        }}
    }}
"
    );
}
