//! The header.

use std::fmt::Write;

use super::{columns, feedback, harmless, lengths, macros, scalar, varying, wrapped};
use crate::Export;
use crate::exportable_observer::ExportableObserver;
use crate::scalar::Scalar;

pub(crate) fn header(export: &Export) -> String {
    let (name, number, names) = (&export.identifier, scalar(export), &export.names);
    let (upper, _) = lengths(export);
    let mut text = format!("/**\n * @file {name}.h\n * @brief {}, one step per sample.\n *\n", export.kind());
    let period = export.observer.period();
    let unit = if names.time_unit.is_empty() { String::new() } else { format!(" {}", harmless(&names.time_unit)) };
    let nominally =
        if export.observer.takes_time() { ", nominally: the step takes the time that has passed" } else { "" };
    _ = writeln!(text, " * Period:  {period}{unit}{nominally}");
    _ = writeln!(text, " * States:  {}", columns(&names.states, &names.units));
    let fed = if export.feedback.is_some() { ", u = r - K xhat with a reference r for each" } else { "" };
    _ = writeln!(text, " * Inputs:  {}{fed}", columns(&names.inputs, &names.input_units));
    _ = writeln!(text, " * Outputs: {}", columns(&names.outputs, &names.output_units));
    _ = writeln!(text, " *\n * Numbers: {number} ({}). {}", export.scalar.name(), cost(export));
    if let ExportableObserver::Kkl(observer) = &export.observer {
        _ = writeln!(text, " * {}", super::kkl::sizes(export, observer));
    }
    for line in export.functions().iter().flat_map(|sentence| wrapped(sentence, 100)) {
        _ = writeln!(text, " * {line}");
    }
    text.push_str(" *\n");
    for sentence in &export.statement {
        for line in wrapped(&harmless(sentence), 100) {
            _ = writeln!(text, " * {line}");
        }
    }
    text.push_str(" *\n");
    for line in export.digests() {
        _ = writeln!(text, " * {}", harmless(&line));
    }
    text.push_str(if export.calls_target() {
        " *\n * The other operations are those of the design if the compiler neither contracts nor reorders\n"
    } else {
        " *\n * The results are those of the design to the last bit if the compiler neither contracts nor reorders\n"
    });
    text.push_str(" * floating-point operations: -std=c99 or -ffp-contract=off, and not -ffast-math.\n");
    text.push_str(" * This file belongs to whoever generated it.\n */\n");
    let timed = export.observer.uses_time();
    let includes = if timed { "#include <stdint.h>\n\n" } else { "" };
    _ = writeln!(
        text,
        "#ifndef {upper}_H\n#define {upper}_H\n\n{includes}#ifdef __cplusplus\nextern \"C\" {{\n#endif\n"
    );
    text.push_str(&macros(export, &export.digest()));
    let (mut fields, mut sample) = (String::new(), String::new());
    if let ExportableObserver::MovingHorizon(estimator) = &export.observer {
        _ = writeln!(text, "#define {upper}_WINDOW {}", estimator.horizon().window);
        (sample, fields) = window(export);
    }
    if matches!(export.observer, ExportableObserver::Kalman(_)) {
        _ = writeln!(fields, "    {number} P[{upper}_STATES][{upper}_STATES]; /**< Covariance of its error. */");
    }
    if matches!(export.observer, ExportableObserver::Unscented(_)) {
        let size = format!("[{upper}_STATES][{upper}_STATES]");
        _ = writeln!(
            fields,
            "    {number} S{size}; /**< Lower triangular factor of the covariance S S' of its error. */"
        );
    }
    if export.is_filter() {
        _ = writeln!(fields, "    {number} prediction[{upper}_STATES]; /**< Prediction for the next sample. */");
        _ = writeln!(
            fields,
            "    {number} innovation[{upper}_OUTPUTS]; /**< Innovation of an update, until the prediction. */"
        );
    }
    if let ExportableObserver::Kkl(observer) = &export.observer {
        _ = writeln!(fields, "    {number} z[{}]; /**< Target states. */", super::kkl::targets(observer));
    }
    if let ExportableObserver::Extension(observer) = &export.observer {
        _ = writeln!(fields, "    {number} z[{}]; /**< State of the observer. */", super::recorded::order(observer));
    }
    if timed {
        // Three roundings: of the number, of the period and of their product.
        let rounded = if export.scalar == Scalar::Binary32 { ", rounded by up to 1.8e-7 of itself" } else { "" };
        _ = writeln!(
            fields,
            "    uint64_t sample; /**< Number of the next sample, from 0; its time is that many periods{rounded}. */"
        );
    }
    let is_fed = export.feedback.is_some();
    let is_varying = export.observer.takes_time();
    let (known, more, step) = match (is_fed, is_varying) {
        (true, _) => ("r", format!("{number} *u, "), feedback::declarations(export)),
        (false, true) => ("u", format!("{number} dt, "), varying::declarations(export)),
        (false, false) => ("u", String::new(), observer_step(export, &upper)),
    };
    let estimate = if is_varying {
        "Estimate at the last sample, or prediction."
    } else if export.is_of_sample() {
        "Estimate at the last sample, with its measurement."
    } else if export.has_halves() {
        "Estimate for the next sample; after an update that at this one."
    } else {
        "Estimate for the next sample."
    };
    _ = write!(
        text,
        "{sample}
/** State of the observer. */
typedef struct {{
    {number} xhat[{upper}_STATES]; /**< {estimate} */
{fields}}} {name}_state;

/** Starts from a given estimate{at}. */
void {name}_init({name}_state *state, const {number} *xhat);

/** Starts from the first estimate of the design. */
void {name}_reset({name}_state *state);
{step} *
{angles}{unit_vectors}{not_finite} call {name}_reset or {name}_init.
 */
void {name}_step({name}_state *state, const {number} *{known}, const {number} *y, {more}{number} *xhat);
{halves}
#ifdef __cplusplus
}}
#endif

#endif
",
        angles = angles(export),
        unit_vectors = unit_vectors(export),
        halves = halves(export, &upper),
        not_finite = not_finite(export),
        at = match &export.observer {
            ExportableObserver::Kkl(observer) if observer.held_inputs() > 0 =>
                ", with z as it is at the first input of the study",
            _ => "",
        },
    );
    text
}

/// What a step costs.
fn cost(export: &Export) -> String {
    let operations = export.operations();
    let Some(stack) = export.stack_of_window() else {
        return format!("One step takes {operations} floating-point operations.");
    };
    let within = export.operations_within_bounds();
    let within = within.map_or_else(String::new, |within| format!(", {within} without active bounds"));
    format!(
        "One step takes at most {operations} floating-point operations{within}.\n * The state has {} bytes; the arrays of the window take {stack} bytes of the stack during a step,\n * and the frames of its functions more (-fstack-usage).",
        export.observer.state_bytes(export.scalar)
    )
}

/// The type of a sample of the window, and the fields of the state of a moving-horizon estimator.
fn window(export: &Export) -> (String, String) {
    let (name, number) = (&export.identifier, scalar(export));
    let upper = name.to_uppercase();
    let inputs = if export.names.inputs.is_empty() {
        String::new()
    } else {
        format!("    {number} u[{upper}_INPUTS]; /**< Inputs from it to the next. */\n")
    };
    let time = if export.observer.uses_time() { format!("    {number} t; /**< Its time. */\n") } else { String::new() };
    let sample = format!(
        "
/** A sample of the window. */
typedef struct {{
    {number} x[{upper}_STATES]; /**< Estimate. */
{inputs}    {number} y[{upper}_OUTPUTS]; /**< Measured outputs. */
{time}    int measured[{upper}_OUTPUTS]; /**< 1 for an output that counts. */
}} {name}_sample;
"
    );
    let fields = format!(
        "    {number} P[{upper}_STATES][{upper}_STATES]; /**< Covariance of its error, without regard to bounds. */
    {number} prior[{upper}_STATES]; /**< First state of the window by the samples before it. */
    {number} prior_P[{upper}_STATES][{upper}_STATES]; /**< Covariance of its error. */
    {name}_sample samples[{upper}_WINDOW]; /**< The window, the oldest sample first. */
    int count; /**< Samples in the window. */
"
    );
    (sample, fields)
}

/// The comment of the step.
fn observer_step(export: &Export, upper: &str) -> String {
    let has_inputs = !export.names.inputs.is_empty();
    let (about, estimate) = if export.is_filter() {
        ("One step: the estimate at this sample, with its measurement, and the prediction for the next one.", "at this")
    } else if export.is_of_sample() {
        (
            "One step: the estimate at this sample, with its measurement, and the internal state for the next one.",
            "at this",
        )
    } else {
        ("One step, from the sample at t to the estimate at t + period.", "for the next")
    };
    format!(
        "
/**
 * {about}
 *
 * @param state  State, read and written.
 * @param u      Inputs held from this sample to the next, {upper}_INPUTS entries{}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries.
 * @param xhat   Estimate {estimate} sample, {upper}_STATES entries; may be a null pointer.
",
        if has_inputs { "" } else { "; not read, may be a null pointer" }
    )
}

/// Which outputs are angles.
fn angles(export: &Export) -> String {
    let turns = export.observer.turns().map(|(outputs, _)| outputs);
    let names = turns.iter().flatten().zip(&export.names.outputs).filter(|(turn, _)| **turn > 0.0);
    let names: Vec<&str> = names.map(|(_, name)| name.as_str()).collect();
    if names.is_empty() {
        return String::new();
    }
    let text = format!(
        "Angles, on any turn: {}. Their differences are taken within half a turn; xhat is not wrapped.",
        harmless(&names.join(", "))
    );
    let lines: Vec<String> = wrapped(&text, 110).iter().map(|line| format!(" * {line}\n")).collect();
    format!("{} *\n", lines.concat())
}

/// Which states form unit vectors.
fn unit_vectors(export: &Export) -> String {
    let Some(vectors) = export.observer.unit_vectors() else { return String::new() };
    let named = |vector: usize| {
        let names = vectors.iter().zip(&export.names.states).filter(|(number, _)| **number as usize == vector);
        format!("({})", names.map(|(_, name)| name.as_str()).collect::<Vec<_>>().join(", "))
    };
    let all: Vec<String> = (1..=vectors.max() as usize).map(named).collect();
    let text = format!(
        "Unit vectors: {}. Their norms are 1 after each update and prediction, and P says nothing of their lengths.",
        harmless(&all.join(", "))
    );
    let lines: Vec<String> = wrapped(&text, 110).iter().map(|line| format!(" * {line}\n")).collect();
    format!("{} *\n", lines.concat())
}

/// What a value of u or y that is not finite does.
fn not_finite(export: &Export) -> String {
    let known = if export.feedback.is_some() { "r" } else { "u" };
    match &export.observer {
        ExportableObserver::Varying(_) => partial(export, &format!("{known} or dt"), "", &overflow(export)),
        ExportableObserver::Linear(_) | ExportableObserver::Cubic(_) => partial(export, known, "", &overflow(export)),
        ExportableObserver::SampledNonlinear(_) | ExportableObserver::Discrete(_) => {
            partial(export, known, ", unless the plant does not depend on it or limits it", OUT_OF_THE_PLANT)
        }
        ExportableObserver::Kkl(observer) if observer.held_inputs() > 0 => {
            format!(" * A value of {known} or y that is not finite makes the target states not finite, for good, and the estimate\n * meaningless, although it stays in its box; one of {known} only if the plant depends on it:")
        }
        ExportableObserver::Kkl(_) => {
            " * A value of y that is not finite makes the target states not finite, for good, and the estimate meaningless,\n * although it stays in its box:".to_owned()
        }
        ExportableObserver::Kalman(_) | ExportableObserver::Unscented(_) => {
            of_filter(export.names.outputs.len() > 1, known)
        }
        ExportableObserver::MovingHorizon(_) => format!(
            "{} A value of {known} that is not finite makes the estimate not finite\n * until the next sample, which then takes its place in the window, unless the plant does not depend on it or\n * limits it. To start anew,",
            missing(export.names.outputs.len() > 1)
        ),
        ExportableObserver::Extension(_) | ExportableObserver::Step(_) => {
            let lost = format!(
                "A value of {known} or y that is not finite makes the estimate not finite, for good, unless the plant does not depend on it or limits it. {OUT_OF_THE_PLANT}:"
            );
            wrapped(&lost, 110).iter().map(|line| format!(" * {line}")).collect::<Vec<_>>().join("\n")
        }
    }
}

/// How a finite value loses the estimate of a nonlinear plant.
const OUT_OF_THE_PLANT: &str = "So does a finite value that takes the estimate to where the plant has no finite result, such as the root of a negative number";

/// How a finite value loses the estimate of a linear plant.
fn overflow(export: &Export) -> String {
    format!("So do finite values so large that a sum leaves the range of {}", scalar(export))
}

/// The same for a constant gain, which leaves out what was not measured.
fn partial(export: &Export, known: &str, unless: &str, finite: &str) -> String {
    let measured = if export.names.outputs.len() > 1 {
        "An output that is not finite, such as NAN, counts as not measured: its column of the gain is left out, and the others correct as they always do."
    } else {
        "A value of y that is not finite, such as NAN, counts as not measured: the step then only predicts."
    };
    let proved = "Nothing is proved of such a sample; what is proved of convergence holds anew after the last one, from the error that there is then.";
    let not_measured = wrapped(&format!("{measured} {proved}"), 110);
    let lost =
        format!("A value of {known} that is not finite makes the estimate not finite, for good{unless}. {finite}:");
    let lines: Vec<String> =
        not_measured.into_iter().chain(wrapped(&lost, 110)).map(|line| format!(" * {line}")).collect();
    lines.join("\n")
}

/// The declarations of update and prediction, of a step that has them apart.
fn halves(export: &Export, upper: &str) -> String {
    if !export.has_halves() {
        return String::new();
    }
    let (name, number) = (&export.identifier, scalar(export));
    let unread = if export.names.inputs.is_empty() { "; not read, may be a null pointer" } else { "" };
    if export.observer.takes_time() {
        return format!(
            "
/**
 * The correction alone, at a sample that has arrived: {name}_step is {name}_predict and then this, to the last bit.
 *
 * @param state  State, read and written: then xhat is the estimate at this sample.
 * @param u      Inputs applied before the sample, {upper}_INPUTS entries{unread}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries; as in {name}_step.
 * @param dt     The time since the last sample that arrived.
 */
void {name}_update({name}_state *state, const {number} *u, const {number} *y, {number} dt);
"
        );
    }
    let (then, predicted) = if export.is_filter() {
        ("xhat is the estimate at this sample", "prediction is the estimate for the next sample")
    } else {
        ("xhat is the estimate at this sample", "xhat is the estimate for the next sample")
    };
    format!(
        "
/**
 * The update alone, when the measurements of a sample arrive: {name}_step is this and then {name}_predict, to the last
 * bit. Called again for further outputs of the same sample, with NAN for those that it has had.
 *
 * @param state  State, read and written: then {then}.
 * @param u      Inputs held from this sample to the next, {upper}_INPUTS entries{unread}.
 * @param y      Outputs measured at this sample, {upper}_OUTPUTS entries; as in {name}_step.
 */
void {name}_update({name}_state *state, const {number} *u, const {number} *y);

/**
 * The prediction alone, once for each sample.
 *
 * @param state  State, read and written: then {predicted}.
 * @param u      Inputs held from this sample to the next, {upper}_INPUTS entries{unread}.
 */
void {name}_predict({name}_state *state, const {number} *u);
"
    )
}

/// The samples that a filter with a covariance passes over.
fn missing(has_several: bool) -> &'static str {
    if has_several {
        " * An output that is not finite, such as NAN, counts as not measured: sensors of different rates share y. A sample\n * without any is passed over."
    } else {
        " * A sample with a value of y that is not finite is passed over, as if it were missed."
    }
}

/// The same for a filter with a covariance.
fn of_filter(has_several: bool, known: &str) -> String {
    format!(
        "{} A value of\n * {known} that is not finite makes the estimate not finite, for good, unless the plant does not depend on it or limits\n * it. So does a finite value that takes the estimate to where the plant has no finite result, such as the root of a\n * negative number:",
        missing(has_several)
    )
}
