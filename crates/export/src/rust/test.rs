//! The test with golden vectors.

use std::fmt::Write;

use crate::golden::Step;
use crate::{Export, number};

pub(super) fn test(export: &Export, steps: &[Step]) -> String {
    let scalar = export.scalar.name();
    let size = export.observer.dimensions();
    let (name, fed) = (&export.identifier, export.feedback.is_some());
    let mut text = format!(
        "//! Golden vectors: {} steps of the design, compared bit by bit.\n\nuse {name}::luenberger_observers::SampledObserver;\nuse {name}::luenberger_observers::nalgebra::SVector;\n",
        steps.len(),
    );
    let mut table = |what: &str, length: usize, of: fn(&Step) -> &Vec<f64>| {
        _ = writeln!(text, "\nconst {what}: [[{scalar}; {length}]; {}] = [", steps.len());
        for step in steps {
            let row: Vec<String> = of(step).iter().map(|x| number::rust(*x, export.scalar)).collect();
            _ = writeln!(text, "    [{}],", row.join(", "));
        }
        text.push_str("];\n");
    };
    table(if fed { "R" } else { "U" }, size.inputs, |step| &step.u);
    table("Y", size.outputs, |step| &step.y);
    table("EXPECTED", size.estimate, |step| &step.estimate);
    let step = if fed {
        table("APPLIED", size.inputs, |step| &step.applied);
        "    let block = {name}::observer().unwrap();
    let observer = block.observer();
    let mut state = observer.initial(0.0, &{name}::initial(), &{input}, &SVector::zeros());
    for (k, (((r, y), expected), applied)) in R.iter().zip(&Y).zip(&EXPECTED).zip(&APPLIED).enumerate() {
        let t = k as {scalar} * observer.period();
        let u = block.step(t, &mut state, &SVector::from(*r), &SVector::from(*y));
        let bits = |x: &[{scalar}]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(u.as_slice()), bits(applied));
"
    } else if export.is_filter() {
        "    let observer = {name}::observer().unwrap();
    let mut state = observer.initial(0.0, &{name}::initial(), &{input}, &SVector::zeros());
    let mut halves = state;
    for ((u, y), expected) in U.iter().zip(&Y).zip(&EXPECTED) {
        let (u, y) = (SVector::from(*u), SVector::from(*y));
        let estimate = observer.estimate_at(&state, &u, &y);
        observer.step(0.0, &mut state, &u, &y);
        let bits = |x: &[{scalar}]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        // The same by update and prediction.
        let innovation = observer.innovation(&halves, &u, &y);
        assert_eq!(bits(observer.update(&halves, &innovation).as_slice()), bits(expected));
        observer.predict(&mut halves, &u, &innovation);
        assert_eq!(bits(halves.as_slice()), bits(state.as_slice()));
"
    } else {
        "    let observer = {name}::observer().unwrap();
    let mut state = observer.initial(0.0, &{name}::initial(), &{input}, &SVector::zeros());
{start}    for (k, ((u, y), expected)) in U.iter().zip(&Y).zip(&EXPECTED).enumerate() {
        let t = k as {scalar} * observer.period();
        observer.step(t, &mut state, &SVector::from(*u), &SVector::from(*y));
        let bits = |x: &[{scalar}]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
{halves}"
    };
    let (start, halves) = if export.has_halves() { halves(export) } else { ("", "") };
    let step = step.replace("{start}", start).replace("{halves}", halves);
    let input = super::input_at_start(export, name);
    let step = step.replace("{input}", &input).replace("{name}", name).replace("{scalar}", scalar);
    let estimate = if export.is_filter() { "estimate" } else { "observer.estimate(&state)" };
    _ = write!(
        text,
        "
#[test]
fn the_steps_are_those_of_the_design() {{
{step}        assert_eq!(bits({estimate}.as_slice()), bits(expected));
    }}
}}
"
    );
    text
}

/// The start and the steps by update and prediction.
fn halves(export: &Export) -> (&'static str, &'static str) {
    if export.observer.takes_time() {
        (
            "    let mut halves = state;\n",
            "        // The same by prediction and correction; the last input is the time.
        let dt = u[u.len() - 1];
        observer.observer().predict(&mut halves, &SVector::from(*u), dt);
        observer.observer().correct(&mut halves, &SVector::from(*u), &SVector::from(*y), dt);
        assert_eq!(bits(halves.as_slice()), bits(expected));
",
        )
    } else {
        (
            "    let mut halves = state.clone();\n",
            "        // The same by update and prediction.
        _ = observer.update(t, &mut halves, &SVector::from(*u), &SVector::from(*y));
        observer.finish(t, &mut halves, &SVector::from(*u));
        assert_eq!(bits(observer.estimate(&halves).as_slice()), bits(expected));
",
        )
    }
}
