//! The source: constants, start, step.

use std::fmt::Write;

use super::kernels::{self, Macros};
use super::{filter, kkl, matrix, moving_horizon, plant, recorded, scalar, varying};
use crate::error::ExportError;
use crate::exportable_observer::{ExportableObserver, Maps};
use crate::scalar::Scalar;
use crate::{Export, number, program};

pub(super) fn source(export: &Export) -> Result<String, ExportError> {
    let (name, number) = (&export.identifier, scalar(export));
    let upper = name.to_uppercase();
    let mut text = format!("/** @file {name}.c\n * See {name}.h. */\n#include \"{name}.h\"\n\n#include <float.h>\n");
    let maps = export.observer.maps();
    text.push_str("#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n");
    if !export.functions_of_target && export.functions().is_some() {
        text.push_str("#include <stdint.h>\n#include <string.h>\n");
    }
    // A method of 16 and 32 is that of smaller types (C23, H.3), 1 and 64 that of float as double.
    let (bits, digits, exact) = match export.scalar {
        Scalar::Binary32 => ("FLT_MANT_DIG", 24, &[0, 16, 32][..]),
        Scalar::Binary64 => ("DBL_MANT_DIG", 53, &[0, 1, 16, 32, 64][..]),
    };
    let others: Vec<String> = exact.iter().map(|method| format!("(FLT_EVAL_METHOD != {method})")).collect();
    let listed: Vec<String> = exact.iter().map(i32::to_string).collect();
    _ = write!(
        text,
        "
#if {bits} != {digits}
#error \"{number} is not the format of the design, whose numbers have {digits} bits\"
#endif

#if defined(FLT_EVAL_METHOD) && {}
#error \"operations have to be rounded to their type: FLT_EVAL_METHOD must be one of {}\"
#endif

#if defined(__FAST_MATH__)
#error \"-ffast-math reorders operations and takes no number for NAN\"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize (\"fp-contract=off\")
#endif

",
        others.join(" && "),
        listed.join(", "),
    );
    let body = body(export, maps.as_ref())?;
    for (which, values) in export.matrices() {
        // The program may have the numbers that follow from a matrix in its place.
        if values.ncols() > 0 && is_named(&body, which.name()) {
            matrix(&mut text, export, which.name(), &values);
        }
    }
    let initial: Vec<String> = export.initial.iter().map(|x| number::c(*x, export.scalar)).collect();
    _ = writeln!(text, "static const {number} INITIAL[{upper}_STATES] = {{ {} }};", initial.join(", "));
    Ok(text + &body)
}

/// Whether a program has entries of the matrix of this name.
fn is_named(body: &str, name: &str) -> bool {
    let is_whole = |at: usize| !body[..at].ends_with(|letter: char| letter.is_ascii_alphanumeric() || letter == '_');
    body.match_indices(&format!("{name}[")).any(|(at, _)| is_whole(at))
}

/// The functions.
fn body(export: &Export, maps: Option<&Maps>) -> Result<String, ExportError> {
    let mut text = String::new();
    start(&mut text, export, maps);
    let macros = Macros::of(export);
    macros.write(&mut text, kernels::RESET);
    match (&export.observer, maps, program::step(export)?) {
        (_, _, Some(next)) => recorded::step(&mut text, export, &next),
        (ExportableObserver::Linear(observer), ..) => {
            if let Some(k) = &export.update {
                recorded::stationary(&mut text, export, &program::stationary(export, observer, k)?);
            }
        }
        (ExportableObserver::Kalman(filter), Some(maps), _) => filter::extended(&mut text, export, maps, filter),
        (ExportableObserver::Unscented(filter), Some(maps), _) => filter::unscented(&mut text, export, maps, filter),
        (ExportableObserver::MovingHorizon(estimator), Some(maps), _) => {
            moving_horizon::step(&mut text, export, maps, estimator);
        }
        (ExportableObserver::Kkl(observer), ..) => kkl::step(&mut text, export, observer),
        (ExportableObserver::Extension(observer), ..) => {
            recorded::flow(&mut text, export, observer, observer.observer().routines());
        }
        (ExportableObserver::SampledNonlinear(observer), ..) => {
            recorded::copy(&mut text, export, &program::slope(export, observer)?);
        }
        (ExportableObserver::Varying(step), ..) => varying::step(&mut text, export, step)?,
        _ => {}
    }
    if export.feedback.is_some() {
        macros.write(&mut text, kernels::FEEDBACK);
    }
    Ok(text)
}

/// The start from a first estimate, with what it needs.
fn start(text: &mut String, export: &Export, maps: Option<&Maps>) {
    match (&export.observer, maps) {
        (ExportableObserver::Kkl(observer), Some(maps)) => {
            plant::functions(text, export, maps);
            kkl::start(text, export, observer);
        }
        (ExportableObserver::Extension(observer), Some(maps)) => {
            recorded::start(text, export, maps, observer.observer().routines());
        }
        (observer, _) => {
            let mut macros = Macros::of(export);
            let has_window = matches!(observer, ExportableObserver::MovingHorizon(_));
            macros.option("HAS_COVARIANCE", has_window || matches!(observer, ExportableObserver::Kalman(_)));
            macros.option("HAS_FACTOR", matches!(observer, ExportableObserver::Unscented(_)));
            macros.option("HAS_WINDOW", has_window);
            if export.observer.unit_vectors().is_some() {
                macros.write(text, kernels::SYMMETRIC);
                macros.write(text, kernels::UNIT_VECTORS);
            }
            macros.write(text, kernels::START);
        }
    }
}
