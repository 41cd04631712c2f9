//! The step of the moving-horizon estimator.

use std::fmt::Write;

use luenberger_observers::moving_horizon::{FRACTION_TO_BOUNDARY, INTERIOR_POINT_STEPS};

use super::kernels::{self, Macros};
use super::{filter, plant, scalar};
use crate::exportable_observer::Maps;
use crate::moving_horizon::{Bound, MovingHorizon, bounds};
use crate::scalar::Scalar;
use crate::{Export, number};

pub(super) fn step(text: &mut String, export: &Export, maps: &Maps, estimator: &MovingHorizon<f64>) {
    let bounds = bounds(estimator);
    constants(text, export, &bounds);
    plant::functions(text, export, maps);
    let mut macros = Macros::of(export);
    let horizon = estimator.horizon();
    macros.option("SEVERAL_SAMPLES", horizon.window > 1);
    macros.integer("ITERATIONS", horizon.iterations);
    let (timed, driven) = (export.observer.uses_time(), !export.names.inputs.is_empty());
    macros.option("DRIVEN", timed || driven);
    macros.set("AT_TIME", if timed { "at->t".to_owned() } else { number::c(0.0, export.scalar) });
    macros.set("AT_INPUTS", if driven { "at->u" } else { "NULL" });
    macros.option("HAS_BOUNDS", !bounds.is_empty());
    macros.integer("BOUND_COUNT", bounds.len());
    macros.integer("INTERIOR_POINT_STEPS", INTERIOR_POINT_STEPS);
    let names = ["LEAST_MU", "LEAST_VARIANCE", "SMALL_STEP", "FRACTION_TO_BOUNDARY", "LEFT_AT_BOUNDARY"];
    for (name, x) in names.into_iter().zip(interior_point(export.scalar)).chain([("TENTH", 0.1)]) {
        macros.number(name, x);
    }
    filter::transition(text, export, &macros);
    macros.write(text, kernels::INNOVATION);
    filter::angles(text, export, &macros);
    macros.write(text, kernels::GAUSS_NEWTON);
    if !bounds.is_empty() {
        macros.write(text, kernels::INTERIOR_POINT);
    }
    macros.write(text, kernels::MOVING_HORIZON);
    macros.write(text, kernels::FILTER_STEP);
}

/// The factor of V, and the bounds.
fn constants(text: &mut String, export: &Export, bounds: &[Bound]) {
    text.push('\n');
    super::matrix(text, export, "ROOT_V", &export.observer.root_of_v(export.scalar));
    if bounds.is_empty() {
        return;
    }
    let count = bounds.len();
    let list = |of: &dyn Fn(&Bound) -> String| bounds.iter().map(of).collect::<Vec<_>>().join(", ");
    _ = write!(
        text,
        "
/* The states that have the bounds, counted from 0; 1 for a lower bound and -1 for an upper one. */
static const int BOUNDED[{count}] = {{ {} }};
static const {} SIDE[{count}] = {{ {} }};
",
        list(&|bound| bound.axis.to_string()),
        scalar(export),
        list(&|bound| number::c(if bound.is_lower { 1.0 } else { -1.0 }, export.scalar)),
    );
}

/// The constants of the interior-point method, as they are computed in the format: the least mu, the least variance,
/// the step after which it ends, the share of the way to a bound, and what is left of it.
fn interior_point(scalar: Scalar) -> [f64; 5] {
    match scalar {
        Scalar::Binary32 => {
            let (least, share) = (f32::EPSILON * 1e3, FRACTION_TO_BOUNDARY as f32);
            [least, least * least, f32::EPSILON.sqrt(), share, 1.0 - share].map(f64::from)
        }
        Scalar::Binary64 => {
            let least = f64::EPSILON * 1e3;
            [least, least * least, f64::EPSILON.sqrt(), FRACTION_TO_BOUNDARY, 1.0 - FRACTION_TO_BOUNDARY]
        }
    }
}
