//! The observers of the template `cuk-observers`, given as expressions, beside those of Table I as
//! `luenberger-reproduce` has them in Rust: along the run of section V.C of Yi, Ortega and Zhang, two set-points long,
//! the estimates are the same.

use std::sync::atomic::AtomicBool;

use luenberger_observers::Observer;
use luenberger_plants::{Column, CukConverter};
use luenberger_reproduce::kkl::cuk::{self, Tuning};
use luenberger_sim::{Integrator, Scenario, Signal};
use luenberger_study::design::design;
use luenberger_study::study::SamplingSpec;
use luenberger_study::{Format, Study, template};
use nalgebra::{Vector1, Vector2, Vector4};

/// The set-points |Vd| in V, 0.2 s each, the equilibrium of the start, and lambda, as in `reproduce::kkl::converter`.
const SET_POINTS: [f64; 2] = [15.0, 25.0];
const START: f64 = 5.0;
const LAMBDA: f64 = 0.2;

/// The states of the paper, (i1, v2, i3, v4), from those of the template.
fn paper(x: &[f64]) -> Vector4<f64> {
    Vector4::new(x[1], x[0], x[2], x[3])
}

/// The estimate of (i1, v4) with all dynamic extensions at 0.
fn at_rest<O>(observer: &O, u: f64, x: &Vector4<f64>) -> [f64; 2]
where
    O: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
{
    let zero = O::State::from_slice(&vec![0.0; observer.dimensions().state]);
    let estimate = observer.estimate(0.0, &zero, &Vector1::new(u), &Vector2::new(x[1], x[2]));
    [estimate[0], estimate[1]]
}

#[test]
fn the_observers_of_a_study_are_those_of_table_i_along_the_papers_run() {
    let text = template::text("cuk-observers").unwrap();
    let study = Study::from_text("cuk-observers.toml", text, Format::Toml, ".".as_ref()).unwrap();
    let (plant, tuning) = (CukConverter::default(), Tuning::default());
    let x0 = plant.equilibrium(START);
    let first = plant.control(&x0, SET_POINTS[0], LAMBDA);
    let (kklo, pebo) = (cuk::kklo(plant).unwrap(), cuk::pebo(plant, &tuning).unwrap());
    let (both, immersion) =
        (cuk::kkl_pebo(plant, &tuning).unwrap(), cuk::immersion_invariance(plant, &tuning).unwrap());
    let starts = [
        at_rest(&kklo, first, &x0),
        at_rest(&pebo, first, &x0),
        at_rest(&both, first, &x0),
        at_rest(&immersion, first, &x0),
    ];
    let cancel = AtomicBool::new(false);
    let designed: Vec<_> = study.observers.iter().map(|spec| design(&study, spec, &cancel).unwrap()).collect();
    let names: Vec<&str> = study.observers.iter().map(|spec| spec.name.as_str()).collect();
    assert_eq!(names, ["KKL", "PEB", "KKL+PEB", "I&I", "high-gain"]);

    let times: Vec<f64> = (0..=400).map(|k| f64::from(k) / 1000.0).collect();
    let mut scenario = Scenario::new(&study.plant.model)
        .initial_state(&[x0[1], x0[0], x0[2], x0[3]])
        .input(Signal::law(move |view, u| {
            let set_point = SET_POINTS[usize::from(view.t >= 0.2)];
            u[0] = plant.control(&paper(view.x), set_point, LAMBDA);
        }))
        .breakpoints(&times[1..])
        .integrator(Integrator::Explicit)
        .tolerances(1e-11, 1e-12)
        .times(&times);
    for ((name, designed), [i1, v4]) in names.iter().zip(&designed).zip(starts) {
        scenario = designed.runnable.join(scenario, name, &[x0[1], i1, x0[2], v4], &SamplingSpec::default());
    }
    let estimated = [1, 3];
    scenario = scenario
        .partial_observer("table KKL", kklo, &starts[0], &estimated)
        .partial_observer("table PEB", pebo, &starts[1], &estimated)
        .partial_observer("table KKL+PEB", both, &starts[2], &estimated)
        .partial_observer("table I&I", immersion, &starts[3], &estimated);
    let run = scenario.run().unwrap();
    // The gains of the study's high-gain observer are constant, those of the table's vary with the duty cycle.
    for name in names.into_iter().filter(|name| *name != "high-gain") {
        let own = &run.observer(name).unwrap().estimate;
        let table = &run.observer(&format!("table {name}")).unwrap().estimate;
        let mut largest = [0.0_f64; 2];
        for k in 0..times.len() {
            for (largest, (from, of)) in largest.iter_mut().zip([(1, 0), (3, 1)]) {
                *largest = largest.max((own[(k, from)] - table[(k, of)]).abs());
            }
        }
        // Amperes and volts of the order of 1 and 10, integrated to 1e-11; constants round differently.
        assert!(largest[0] < 1e-8 && largest[1] < 1e-7, "{name}: {largest:?}");
        // Nearly gone before the set-point changes: time constants of 22, 31, 31 and 45 ms for i1.
        let error = |k: usize| (own[(k, 1)] - run.x[(k, 1)]).abs();
        let (begin, end) = (error(0), error(190));
        let left = if name == "I&I" { 0.03 } else { 0.004 };
        assert!(begin > 0.05 && end < left * begin, "{name}: {begin} {end}");
    }
}
