//! The source: constants, start, step.

use std::fmt::Write;

use super::kernels::{self, Macros};
use super::{
    cubic, extension, feedback, filter, kkl, lengths, linear, matrix, moving_horizon, plant, sampled_nonlinear, scalar,
    varying,
};
use crate::exportable_observer::{ExportableObserver, Maps};
use crate::{Export, number};

pub(super) fn source(export: &Export) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let (upper, _) = lengths(export);
    let n = format!("{upper}_STATES");
    let mut text = format!("/** @file {name}.c\n * See {name}.h. */\n#include \"{name}.h\"\n\n#include <float.h>\n");
    let maps = export.observer.maps();
    if maps.is_some() || matches!(export.observer, ExportableObserver::Cubic(_) | ExportableObserver::Varying(_)) {
        text.push_str("#include <math.h>\n");
    }
    if maps.is_some() {
        text.push_str("#include <stdbool.h>\n");
    }
    text.push_str("#include <stddef.h>\n");
    if maps.as_ref().is_some_and(Maps::calls_functions) {
        text.push_str("#include <stdint.h>\n#include <string.h>\n");
    }
    text.push_str(
        "
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error \"operations have to be rounded to their type: FLT_EVAL_METHOD must be 0\"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

",
    );
    for (name, values) in export.matrices() {
        if values.ncols() > 0 {
            matrix(&mut text, export, name, &values);
        }
    }
    let initial: Vec<String> = export.initial.iter().map(|x| number::c(*x, export.scalar)).collect();
    _ = writeln!(text, "static const {number} INITIAL[{n}] = {{ {} }};", initial.join(", "));
    if matches!(export.observer, ExportableObserver::Cubic(_) | ExportableObserver::Varying(_)) {
        cubic::flow(&mut text, export);
    }
    match (&export.observer, &maps) {
        (ExportableObserver::Kkl(observer), Some(maps)) => {
            plant::functions(&mut text, export, maps);
            kkl::start(&mut text, export, observer);
        }
        (ExportableObserver::Extension(observer), Some(maps)) => {
            let own = observer.observer().routines();
            plant::functions(&mut text, export, maps);
            extension::functions(&mut text, export, own);
            extension::start(&mut text, export, (maps, own));
        }
        _ => start(&mut text, export),
    }
    Macros::of(export).write(&mut text, kernels::RESET);
    match (&export.observer, &maps) {
        (ExportableObserver::Kalman(_), Some(maps)) => filter::extended(&mut text, export, maps),
        (ExportableObserver::Unscented(filter), Some(maps)) => filter::unscented(&mut text, export, maps, filter),
        (ExportableObserver::MovingHorizon(estimator), Some(maps)) => {
            moving_horizon::step(&mut text, export, maps, estimator);
        }
        (ExportableObserver::Kkl(observer), _) => kkl::step(&mut text, export, observer),
        (ExportableObserver::Extension(observer), Some(maps)) => {
            extension::step(&mut text, export, observer, (maps, observer.observer().routines()));
        }
        (ExportableObserver::Discrete(_), Some(maps)) => sampled_nonlinear::discrete_step(&mut text, export, maps),
        (ExportableObserver::Step(_), Some(maps)) => super::step::step(&mut text, export, maps),
        (ExportableObserver::Varying(_), _) => varying::step(&mut text, export),
        (ExportableObserver::SampledNonlinear(_), Some(maps)) => sampled_nonlinear::step(&mut text, export, maps),
        _ => linear::step(&mut text, export),
    }
    feedback::block(&mut text, export);
    text
}

/// The start from a first estimate.
fn start(text: &mut String, export: &Export) {
    let mut macros = Macros::of(export);
    macros.option("FILTER_FORM", export.is_filter());
    macros.option(
        "HAS_COVARIANCE",
        matches!(export.observer, ExportableObserver::Kalman(_) | ExportableObserver::MovingHorizon(_)),
    );
    macros.option("HAS_FACTOR", matches!(export.observer, ExportableObserver::Unscented(_)));
    macros.option("HAS_WINDOW", matches!(export.observer, ExportableObserver::MovingHorizon(_)));
    macros.write(text, kernels::START);
}
