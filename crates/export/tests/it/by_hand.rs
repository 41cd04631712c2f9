//! What an export has, says and replays, by hand: numbers and texts that no compiler of C looks at.

use std::io::{Cursor, Read};

use luenberger_export::fmu::{Version, compilers as libraries};
use luenberger_export::golden::{self, Stepper};
use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::names::{check, identifier};
use luenberger_export::step::RecordedStep;
use luenberger_export::{
    Export, ExportError, ExportableObserver, FixedPointFormat, FixedPointFormats, Names, Scalar, sha256,
};
use luenberger_observers::{
    DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter, Horizon, NoiseModel, ObserverDimensions,
    Prediction, SampledObserver, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::StateSpace;
use luenberger_random::Random;
use nalgebra::{DMatrix, dmatrix, dvector};

use crate::compiled::{self, folder, program, with_feedback};
use crate::moving_horizon::plant;
use crate::rows::Rows;
use crate::{fuzz, kkl, operations};

fn scalar_observer(format: Scalar) -> Export {
    let plant = StateSpace::new(dmatrix![0.3], dmatrix![0.7], dmatrix![1.1]).unwrap();
    let observer = DiscreteLinearObserver::new(plant, dmatrix![0.2], 0.1).unwrap();
    let names = Names { time_unit: "ms".to_owned(), ..Names::numbered(1, 1, 1) };
    Export::new("plant", ExportableObserver::Linear(observer), format, &[0.1], names).unwrap()
}

#[test]
fn names_are_made_of_letters_digits_and_single_underscores() {
    for (name, expected) in [
        ("EKF at 100 Hz", "ekf_at_100_hz"),
        ("2nd", "observer_2nd"),
        ("", "observer"),
        ("---", "observer"),
        ("for", "observer_for"),
        (" - Beobachter f\u{fc}r  Winkel!", "beobachter_f_r_winkel"),
        ("a__b_", "a_b"),
        ("X9", "x9"),
    ] {
        assert_eq!(identifier(name), expected);
    }
    for name in [&"a".repeat(48), "A_9", "a", "forx"] {
        assert_eq!(check(name), Ok(()));
    }
    for (name, why) in [
        ("", "1 to 48 characters"),
        (&"a".repeat(49), "1 to 48 characters"),
        ("a-b", "letters, digits and underscores"),
        ("_a", "begin with a letter"),
        ("9a", "begin with a letter"),
        ("while", "reserved word"),
    ] {
        assert!(check(name).unwrap_err().to_string().contains(why), "{name}");
    }
}

#[test]
fn an_export_has_what_it_was_made_of() {
    let export = scalar_observer(Scalar::Binary32);
    assert_eq!((export.identifier(), export.period_text().as_str()), ("plant", "0.1 ms"));
    assert_eq!((export.first_estimate(), export.states()), (&[f64::from(0.1_f32)][..], &["x1".to_owned()][..]));
    assert_eq!((export.has_feedback(), export.is_filter(), export.update_gain()), (false, false, None));
    let fed = export.clone().with_feedback(&dmatrix![0.5]).unwrap();
    assert!(fed.has_feedback() && !fed.is_of_sample());
    let filter = export.with_update(&dmatrix![0.5]).unwrap();
    assert!(filter.is_filter() && filter.is_of_sample() && !filter.has_feedback());
    assert_eq!(filter.update_gain(), Some(&dmatrix![0.5]));
    let named = Names { time_unit: String::new(), ..Names::numbered(1, 1, 1) };
    let other = Export::new("a", fed.observer().clone(), Scalar::Binary64, &[0.0], named).unwrap();
    assert_eq!(other.period_text(), "0.1 time units");
}

/// `x+ = 0.3 x + 0.7 u + 0.2 (y - 1.1 x)` in the arithmetic of each format.
#[test]
fn a_replay_computes_in_the_format() {
    let samples = [(vec![0.1], vec![2.3]), (vec![-0.7], vec![1e-3]), (vec![0.4], vec![-5.1])];
    let (mut single, mut double) = (0.1_f32, 0.1_f64);
    for scalar in [Scalar::Binary32, Scalar::Binary64] {
        let export = scalar_observer(scalar);
        let mut stepper = Stepper::new(&export).unwrap();
        let found = golden::replay(&export, &samples).unwrap();
        assert_eq!(found.len(), 3);
        for ((u, y), estimate) in samples.iter().zip(&found) {
            let expected = if scalar == Scalar::Binary32 {
                single = (0.3 * single + 0.7 * u[0] as f32) + 0.2 * (y[0] as f32 - 1.1 * single);
                f64::from(single)
            } else {
                double = (0.3 * double + 0.7 * u[0]) + 0.2 * (y[0] - 1.1 * double);
                double
            };
            assert_eq!(estimate, &[expected]);
            assert_eq!(stepper.step(u, y), [expected]);
            assert_eq!(stepper.estimate(), [expected]);
        }
    }
}

/// The golden outputs of a loop are those of its plant `x+ = A x + B u, y = C x + D u` from 0, and the numbers that
/// they would be without the loop.
#[test]
fn golden_outputs_of_a_loop_are_those_of_its_plant() {
    for (is_cubic, fed) in [(false, false), (false, true), (true, true)] {
        let observer = program(13, (3, 2, 2), is_cubic, fed);
        let export = compiled::export(observer.clone(), Scalar::Binary64);
        let alone = golden::steps(&export, 40).unwrap();
        let block = golden::steps(&with_feedback(export), 40).unwrap();
        let (a, b, c, d) = match &observer {
            ExportableObserver::Linear(observer) => {
                let plant = observer.plant();
                (&plant.a, &plant.b, &plant.c, plant.d.as_ref())
            }
            ExportableObserver::Cubic(observer) => (observer.ad(), observer.bd(), observer.c(), observer.d()),
            _ => unreachable!("a linear plant"),
        };
        let mut x = dvector![0.0, 0.0, 0.0];
        for (k, (alone, block)) in alone.iter().zip(&block).enumerate() {
            let u = nalgebra::DVector::from_column_slice(&block.applied);
            let feedthrough = d.map_or_else(|| dvector![0.0, 0.0], |d| d * &u);
            let outputs = c * &x + feedthrough;
            for j in 0..2 {
                let expected = alone.y[j] + outputs[j];
                assert!((block.y[j] - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{k}: {block:?}");
            }
            assert_eq!(alone.u, block.u, "{k}");
            x = a * &x + b * &u;
        }
        // Numbers up to 2, and once in 16 steps up to 2000.
        let largest = |step: &golden::Step| step.u.iter().chain(&step.y).fold(0.0_f64, |most, x| most.max(x.abs()));
        let large: Vec<usize> = (0..40).filter(|k| largest(&alone[*k]) > 2.0).collect();
        assert_eq!(large, [7, 23, 39]);
        assert!(alone.iter().all(|step| largest(step) <= 2000.0) && largest(&alone[7]) > 20.0);
    }
}

/// Sentences are broken where a line would have more than 100 characters.
#[test]
fn lines_of_a_sentence_have_at_most_a_hundred_characters() {
    let [a, b, c, d] = [("a", 49), ("b", 50), ("c", 49), ("d", 51)].map(|(letter, count)| letter.repeat(count));
    let export = scalar_observer(Scalar::Binary64).statement(&[format!("{a} {b} {c} {d}")]);
    let header = export.c().unwrap().remove(0).text;
    let lines: Vec<&str> = header.lines().filter(|line| [&a, &c, &d].iter().any(|word| line.contains(*word))).collect();
    assert_eq!(lines, [format!(" * {a} {b}"), format!(" * {c}"), format!(" * {d}")]);
}

/// A gain takes a product and a sum for each entry, beside the step.
#[test]
fn gains_take_two_operations_for_each_entry() {
    let export = || compiled::export(program(13, (3, 2, 1), false, false), Scalar::Binary64);
    assert_eq!(with_feedback(export()).operations(), export().operations() + 2 * 6);
    assert_eq!(export().with_update(&DMatrix::zeros(3, 1)).unwrap().operations(), export().operations() + 2 * 3);
    let mut random = Random(1);
    let export = std::iter::repeat_with(|| ExportableObserver::MovingHorizon(fuzz::moving_horizon(&mut random)))
        .map(|estimator| fuzz::export("plant", estimator, Scalar::Binary64))
        .find(|export| export.operations_within_bounds().is_some() && export.observer().plant_inputs() > 0)
        .unwrap();
    let (size, within) = (export.observer().dimensions(), export.operations_within_bounds().unwrap());
    assert_eq!(with_feedback(export).operations_within_bounds(), Some(within + 2 * size.inputs * size.estimate));
}

/// The samples of a nonlinear plant are taken there and back; of a single one all steps are.
#[test]
fn golden_samples_go_there_and_back() {
    let copy = DiscreteNonlinearObserver::new(plant(&["0.5*x1 + u1"], &["x1"], 1), dmatrix![0.1], 0.1).unwrap();
    let export = fuzz::export("plant", ExportableObserver::Discrete(copy), Scalar::Binary64);
    let sample = |k: usize| (vec![0.01 * k as f64], vec![0.1 * k as f64]);
    for (count, expected) in [(1, [0; 9]), (2, [0, 1, 0, 1, 0, 1, 0, 1, 0]), (4, [0, 1, 2, 3, 2, 1, 0, 1, 2])] {
        let steps = golden::steps(&export.clone().samples((0..count).map(sample).collect()), 9).unwrap();
        let found: Vec<_> = steps.into_iter().map(|step| (step.u, step.y)).collect();
        assert_eq!(found, expected.map(sample));
    }
    // Without samples inputs are up to 0.1, and outputs by as much from what the estimate predicts.
    let steps = golden::steps(&export, 50).unwrap();
    let mut predicted = -0.3;
    for step in &steps {
        assert!(step.u[0].abs() <= 0.1 && (step.y[0] - predicted).abs() <= 0.1, "{step:?}");
        predicted = step.estimate[0];
    }
    assert!(steps.iter().any(|step| step.u[0].abs() > 0.05));
}

/// With n = 2, m = 1 and p = 1: 4 + 2 + 2 + 2 products, the first estimate, the state, and the count of saturations.
#[test]
fn fixed_point_is_counted_and_digested_by_hand() {
    let q = |integer, fraction| FixedPointFormat::new(integer, fraction).unwrap();
    let of = |seed| compiled::export(program(seed, (2, 1, 1), false, false), Scalar::Binary64);
    let (design, other) = (of(3), of(4));
    let export = design.fixed_point(q(4, 12).into()).unwrap();
    assert_eq!((export.products(), export.bytes()), (10, 4 * (10 + 2 + 2 + 1)));
    let digests: Vec<String> = [
        (&design, FixedPointFormats::from(q(4, 12))),
        (&other, q(4, 12).into()),
        (&design, q(5, 12).into()),
        (&design, FixedPointFormats { gains: q(4, 13), signals: q(4, 12) }),
    ]
    .into_iter()
    .map(|(design, formats)| design.fixed_point(formats).unwrap().digest())
    .collect();
    for (k, digest) in digests.iter().enumerate() {
        assert!(digest.len() == 64 && digest.chars().all(|c| c.is_ascii_hexdigit()), "{digest}");
        assert!(!digests[..k].contains(digest));
    }
    let files = export.c();
    let text = |name: &str| &files.iter().find(|file| file.name == name).unwrap().text;
    assert!(text("plant.h").contains(&digests[0]));
    // The numbers of the golden vectors: up to 2, or 2^13 as an integer; at step 7 of 16 up to the end of the range,
    // and at step 15 beyond it, which is clamped to the ends.
    let u = text("test_plant.c").split("u[64]").nth(1).unwrap().split(';').next().unwrap();
    let u: Vec<i32> = u
        .split(|c: char| c != '-' && !c.is_ascii_digit())
        .filter_map(|word| word.parse().ok())
        .skip_while(|x| *x == 1)
        .collect();
    assert_eq!(u.len(), 64, "{u:?}");
    for (k, x) in u.iter().enumerate() {
        assert!((-32768..=32767).contains(x) && (k % 8 == 7 || (-8192..8192).contains(x)), "{k}: {x}");
    }
    let is_end = |x: &i32| *x == -32768 || *x == 32767;
    assert!(u.iter().skip(7).step_by(16).any(|x| x.abs() > 8192), "{u:?}");
    assert!(!u.iter().skip(7).step_by(16).any(is_end), "{u:?}");
    assert!(u.iter().skip(15).step_by(16).any(is_end), "{u:?}");
}

fn description(export: &Export, version: Version, name: &str) -> String {
    let archive = export.fmu(version).unwrap().archive().unwrap();
    let mut text = String::new();
    zip::ZipArchive::new(Cursor::new(archive)).unwrap().by_name(name).unwrap().read_to_string(&mut text).unwrap();
    text
}

/// Three states, two inputs and two outputs with feedback, numbered from 1: u 1 and 2, y 3 and 4, xhat 5 to 7, the
/// innovations 8 and 9, initial 10 to 12, r 13 and 14. `u = r - K xhat` depends on r of its own row, and at the start
/// on all first estimates.
#[test]
fn what_depends_on_what_in_an_fmu() {
    let export = with_feedback(compiled::export(program(11, (3, 2, 2), false, false), Scalar::Binary64));
    let outputs = [(1, "13"), (2, "14"), (5, ""), (6, ""), (7, ""), (8, ""), (9, "")];
    let initial = [(1, "10 11 12 13"), (2, "10 11 12 14"), (5, "10"), (6, "11"), (7, "12")];
    let line = |head: &str, (k, on): &(usize, &str)| format!("{head}=\"{k}\" dependencies=\"{on}\"/>");
    for version in [Version::Two, Version::Three] {
        let text = description(&export, version, "modelDescription.xml");
        let structure = text.split("<ModelStructure>\n").nth(1).unwrap().split("  </ModelStructure>").next().unwrap();
        let found: Vec<&str> = structure.lines().map(str::trim).collect();
        let expected: Vec<String> = match version {
            Version::Two => {
                let all = |of: &[(usize, &str)]| of.iter().map(|one| line("<Unknown index", one)).collect::<Vec<_>>();
                let tags =
                    |tag: &str, of: Vec<String>| [vec![format!("<{tag}>")], of, vec![format!("</{tag}>")]].concat();
                [tags("Outputs", all(&outputs)), tags("InitialUnknowns", all(&initial))].concat()
            }
            Version::Three => outputs
                .iter()
                .map(|one| line("<Output valueReference", one))
                .chain(initial.iter().map(|one| line("<InitialUnknown valueReference", one)))
                .collect(),
        };
        assert_eq!(found, expected, "{version:?}");
    }
}

/// FMI 2.0.2, 2.2.7, and 3.0, 2.4.7: each variable with its causality, and in 3.0 the time. Estimates are calculated
/// from parameters, so that they have no start.
#[test]
fn the_variables_of_an_fmu() {
    let mut export = scalar_observer(Scalar::Binary64);
    let units = Names { units: vec!["m".to_owned()], ..Names::numbered(1, 1, 1) };
    export = Export::new("plant", export.observer().clone(), Scalar::Binary64, &[0.1], units).unwrap();
    let rows = [
        ("u.u1", "input\" variability=\"continuous", "input held until the next sample: u1", "", Some("0.0")),
        ("y.y1", "input\" variability=\"continuous", "measured output: y1", "", Some("0.0")),
        ("xhat.x1", "output\" variability=\"discrete\" initial=\"calculated", "estimate of the state x1", "m", None),
        (
            "innovation.y1",
            "output\" variability=\"discrete\" initial=\"exact",
            "innovation of the last step, measured minus expected output: y1",
            "",
            Some("0.0"),
        ),
        (
            "initial.x1",
            "parameter\" variability=\"fixed\" initial=\"exact",
            "first estimate of the state x1",
            "m",
            Some("0.1"),
        ),
    ];
    for version in [Version::Two, Version::Three] {
        let text = description(&export, version, "modelDescription.xml");
        let found = text.split("<ModelVariables>\n").nth(1).unwrap().split("  </ModelVariables>").next().unwrap();
        let mut expected = String::new();
        if version == Version::Three {
            expected += "    <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\"/>\n";
        }
        for (k, (name, causality, about, unit, start)) in rows.into_iter().enumerate() {
            let key =
                |key: &str, value: &str| if value.is_empty() { String::new() } else { format!(" {key}=\"{value}\"") };
            let head = format!(
                "name=\"{name}\" valueReference=\"{}\" causality=\"{causality}\" description=\"{about}\"",
                k + 1
            );
            let of = format!("{}{}", key("unit", unit), key("start", start.unwrap_or_default()));
            let line = match version {
                Version::Two => format!("    <ScalarVariable {head}><Real{of}/></ScalarVariable>\n"),
                Version::Three => format!("    <Float64 {head}{of}/>\n"),
            };
            expected.push_str(&line);
        }
        assert_eq!(found, expected, "{version:?}");
        let key = if version == Version::Two { "  guid=\"{" } else { "  instantiationToken=\"{" };
        assert!(
            text.contains(key)
                && text.contains("description=\"Sampled linear observer, one step every 0.1 s, computed in f64. \"")
        );
        assert_eq!(text.matches("<Unit ").count(), 1);
    }
    let without = scalar_observer(Scalar::Binary64);
    assert!(!description(&without, Version::Two, "modelDescription.xml").contains("Unit"));
}

/// Names are structured if each is a letter or an underscore with letters, digits and underscores after it.
#[test]
fn names_of_an_fmu_are_structured_or_flat() {
    for (name, expected) in
        [("_v1", "structured"), ("v_1", "structured"), ("1v", "flat"), ("a b", "flat"), ("", "flat")]
    {
        let names = Names { states: vec![name.to_owned()], ..Names::numbered(1, 1, 1) };
        let export =
            Export::new("plant", scalar_observer(Scalar::Binary64).observer().clone(), Scalar::Binary64, &[0.0], names);
        let text = description(&export.unwrap(), Version::Two, "modelDescription.xml");
        assert!(text.contains(&format!("variableNamingConvention=\"{expected}\"")), "{name:?}");
    }
}

#[test]
fn the_page_of_an_fmu_says_what_it_is() {
    let export =
        scalar_observer(Scalar::Binary64).statement(&["e < 1 & f".to_owned()]).titled("Reduced-order observer");
    let page = |export: &Export| description(export, Version::Two, "documentation/index.html");
    assert_eq!(
        page(&export),
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>plant</title></head>\n<body>\n\
             <h1>plant</h1>\n<p>Reduced-order observer, one step per sample.</p>\n<p>e &lt; 1 &amp; f</p>\n<p>The \
             communication step has to be a multiple of the sampling period; the inputs are held over it. The \
             estimate\nis that for the end of the step.</p>\n<p>SHA-256 of the numbers: {}</p>\n</body>\n</html>\n",
            export.digest()
        )
    );
    let filter = scalar_observer(Scalar::Binary64).with_update(&dmatrix![0.5]).unwrap();
    assert!(page(&filter).contains("is that at the last sample, with its measurement.</p>"));
    assert!(page(&filter).contains("<p>Stationary Kalman filter, one step per sample.</p>"));
}

/// The digest of a linear observer: format, matrices with their sizes and bits, period, first estimate.
#[test]
fn the_digest_is_that_of_the_numbers() {
    let of = |x: f64| x.to_le_bytes();
    let mut bytes = b"f64".to_vec();
    for (name, x) in [("A", 0.3), ("B", 0.7), ("C", 1.1), ("L", 0.2)] {
        bytes.extend(format!("{name} 1 1").as_bytes());
        bytes.extend(of(x));
    }
    bytes.extend(of(0.1));
    bytes.extend(of(0.1));
    assert_eq!(scalar_observer(Scalar::Binary64).digest(), sha256(&bytes));
}

/// Each number that a format cannot store is named.
#[test]
fn what_a_format_cannot_store_is_named() {
    let refused = |observer, scalar, initial: &[f64]| {
        let size = ExportableObserver::dimensions(&observer);
        let names = Names::numbered(size.estimate, observer.plant_inputs(), size.outputs);
        Export::new("plant", observer, scalar, initial, names).unwrap_err().to_string()
    };
    let linear = |l: DMatrix<f64>, period: f64| {
        let plant =
            StateSpace::new(DMatrix::identity(2, 2) * 0.5, dmatrix![0.0; 1.0], DMatrix::identity(2, 2)).unwrap();
        ExportableObserver::Linear(DiscreteLinearObserver::new(plant, l, period).unwrap())
    };
    // In the second column, of the first row.
    let large = dmatrix![0.1, 1e39; 0.2, 0.1];
    assert_eq!(
        refused(linear(large, 0.1), Scalar::Binary32, &[0.0; 2]),
        format!("L(1, 2) = {} is beyond the range of f32", 1e39)
    );
    let period = refused(linear(dmatrix![0.1, 0.0; 0.0, 0.1], 1e39), Scalar::Binary32, &[0.0; 2]);
    assert_eq!(period, format!("PERIOD = {} is beyond the range of f32", 1e39));
    let good = linear(dmatrix![0.1, 0.0; 0.0, 0.1], 0.1);
    let second = refused(good, Scalar::Binary32, &[0.0, 1e39]);
    assert_eq!(second, "entry 2 of the first estimate is beyond the range of f32");
    let copy = |f: &str| {
        let plant = plant(&[f], &["x1"], 0);
        ExportableObserver::Discrete(DiscreteNonlinearObserver::new(plant, dmatrix![0.1], 0.1).unwrap())
    };
    let constant = refused(copy("x1/1e39"), Scalar::Binary32, &[0.0]);
    assert!(
        constant.starts_with("the constant ") && constant.ends_with(" of the plant is beyond the range of f32"),
        "{constant}"
    );
}

/// A target takes a fixed number of steps.
#[test]
fn a_prediction_with_control_of_its_error_is_refused() {
    let plant = || plant(&["-x1"], &["x1"], 0);
    let noises = || NoiseModel { w: dmatrix![0.1], v: dmatrix![0.1], p0: dmatrix![1.0] };
    let controlled = Prediction::ErrorControlled;
    let extended = ExtendedKalmanFilter::new(plant(), noises(), 0.1, 1).unwrap().with_prediction(controlled);
    let unscented = UnscentedKalmanFilter::new(plant(), noises(), SigmaPoints::default(), 0.1, 1).unwrap();
    let horizon = Horizon { window: 2, iterations: 1 };
    let moving = MovingHorizon::new(plant(), noises(), horizon, 0.1, 1).unwrap();
    for observer in [
        ExportableObserver::Kalman(extended.unwrap()),
        ExportableObserver::Unscented(unscented.with_prediction(controlled).unwrap()),
        ExportableObserver::MovingHorizon(moving.with_prediction(controlled).unwrap()),
    ] {
        let refused = Export::new("plant", observer, Scalar::Binary64, &[0.0], Names::numbered(1, 0, 1));
        assert_eq!(refused.unwrap_err(), ExportError::ErrorControlled);
    }
}

/// The header says whether inputs are read, and of which sample the estimate is.
#[test]
fn the_header_says_what_a_step_takes() {
    let header = |export: &Export| export.c().unwrap().remove(0).text;
    let of = |inputs| compiled::export(program(3, (2, inputs, 1), false, false), Scalar::Binary64);
    let u = " * @param u      Inputs held from this sample to the next, PLANT_INPUTS entries";
    let filter = of(1).with_update(&dmatrix![0.5; 0.25]).unwrap();
    for (export, end, estimate, about) in [
        (of(1), ".\n", "for the next", "One step, from the sample at t to the estimate at t + period."),
        (of(0), "; not read, may be a null pointer.\n", "for the next", "One step, from the sample at t"),
        (
            filter,
            ".\n",
            "at this",
            "One step: the estimate at this sample, with its measurement, and the prediction for",
        ),
    ] {
        let text = header(&export);
        assert!(text.contains(&format!("{u}{end}")), "{text}");
        assert!(
            text.contains(&format!(" * @param xhat   Estimate {estimate} sample, PLANT_STATES entries;")),
            "{text}"
        );
        assert!(text.contains(about), "{text}");
    }
}

/// `z' = (x2 - x1 + y1^2, u1 - 3 x2 - y2 x1)`: the Jacobian is (-1, 1; -y2, -3).
#[test]
fn the_jacobian_of_a_recorded_observer() {
    let flow = plant(&["x2 - x1 + u2*u2", "u1 - 3*x2 - u3*x1"], &["x1"], 3);
    let rows = Rows { flow, start: plant(&["0"], &["x1", "x1"], 2), jump: None, outputs: 2 };
    let recorded = rows.recorded(&plant(&["-x1"], &["x1", "x1"], 1));
    let found = recorded.jacobian(0.0, &dvector![0.5, 0.25], &dvector![1.0], &dvector![2.0, 7.0]);
    assert_eq!(found, dmatrix![-1.0, 1.0; -7.0, -3.0]);
}

#[test]
fn a_recorded_step_is_that_of_its_sample_or_of_the_next() {
    let step: RecordedStep<f64> = crate::rows::step(&plant(&["0.5*x1 + u2"], &["x1"], 2), 1, 0.1);
    assert!(!step.is_of_sample() && step.clone().of_sample().is_of_sample());
    let export = |step| fuzz::export("plant", ExportableObserver::Step(step), Scalar::Binary64);
    assert!(!export(step.clone()).is_of_sample() && export(step.of_sample()).is_of_sample());
}

/// A state of z with the estimate behind it: 3 and 2 numbers for two states. The step is that of the replay.
#[test]
fn a_numerical_kkl_observer_has_its_sizes() {
    let mut random = Random(5);
    let plant = plant(&["x2 - 0.5*x1", "-0.5*x2"], &["x1"], 0);
    for form in 0..2 {
        let observer = kkl::of_plant(&mut random, &plant, form);
        assert_eq!(observer.is_interpolated(), form == 1);
        let size = SampledObserver::<f64>::dimensions(&observer);
        assert_eq!(size, ObserverDimensions { state: 5, inputs: 0, outputs: 1, estimate: 2 });
        let (first, y) = (dvector![0.1, -0.2], dvector![0.3]);
        let mut state = SampledObserver::<f64>::initial(&observer, 0.0, &first, &dvector![], &y);
        assert_eq!((state.len(), SampledObserver::<f64>::period(&observer)), (5, 0.05));
        SampledObserver::<f64>::step(&observer, 0.0, &mut state, &dvector![], &y);
        let estimate = SampledObserver::<f64>::estimate(&observer, &state);
        let names = Names::numbered(2, 0, 1);
        let export =
            Export::new("plant", ExportableObserver::Kkl(observer), Scalar::Binary64, &[0.1, -0.2], names).unwrap();
        let replayed = golden::replay(&export, &[(vec![], vec![0.3])]).unwrap();
        assert_eq!(replayed[0], estimate.as_slice());
    }
}

/// The state of the static library, and the column that the observer of `observers` has: z with the estimate behind it
/// in recorded observers and those for held inputs.
#[test]
fn the_state_of_a_static_library() {
    let mut random = Random(5);
    let two = plant(&["x2 - 0.5*x1", "-0.5*x2"], &["x1"], 0);
    let plain = ExportableObserver::Kkl(kkl::of_plant(&mut random, &two, 0));
    let held = ExportableObserver::Kkl(kkl::held(&mut random, (2, 1), true));
    let timed = DiscreteNonlinearObserver::new(plant(&["0.5*x1 + t"], &["x1"], 0), dmatrix![0.1], 0.1).unwrap();
    let of = |observer| fuzz::export("plant", observer, Scalar::Binary64);
    let filter = compiled::export(program(3, (2, 1, 1), false, false), Scalar::Binary32);
    let filter = filter.with_update(&dmatrix![0.5; 0.25]).unwrap();
    for (export, fields, column) in [
        (of(operations::recorded(false)), "xhat: [f64; 3],\n    z: [f64; 2],", "SVector<f64, 5>"),
        (of(plain), "xhat: [f64; 2],\n    z: [f64; 3],", "SVector<f64, 3>"),
        (of(held), "xhat: [f64; 2],\n    z: [f64; 3],", "SVector<f64, 5>"),
        (of(program(3, (2, 1, 1), true, false)), "xhat: [f64; 2],", "SVector<f64, 2>"),
        (filter, "xhat: [f32; 2],\n    prediction: [f32; 2],\n    innovation: [f32; 1],", "SVector<f32, 2>"),
        (of(ExportableObserver::Discrete(timed)), "xhat: [f64; 1],\n    sample: u64,", "SVector<f64, 1>"),
    ] {
        let files = export.rust().unwrap();
        let text = &files.iter().find(|file| file.name == "c/src/lib.rs").unwrap().text;
        let state = text.split("pub struct State {").nth(1).unwrap().split('}').next().unwrap();
        assert_eq!(state.trim(), fields);
        assert!(text.contains(&format!("fn load(&self) -> {column} {{")), "{text}");
        let joined = "SVector::from_fn(|i, _| if i < NUMBER { self.z[i] } else { self.xhat[i - NUMBER] })";
        let is_joined = column == "SVector<f64, 5>";
        let order = if fields.contains("z: [f64; 2]") { "2" } else { "3" };
        assert_eq!(text.contains(&joined.replace("NUMBER", order)), is_joined, "{text}");
        let manifest = &files.iter().find(|file| file.name == "c/Cargo.toml").unwrap().text;
        assert!(manifest.contains("name = \"plant-c\"") && manifest.contains("package = \"plant\""), "{manifest}");
    }
}

/// FMI 2.0 has names of its own for common platforms, FMI 3.0 those of the processors; libraries end as the system has
/// it. The compiler is the one of this machine, whatever the platform is called.
#[test]
fn libraries_stand_in_the_folder_of_their_platform() {
    let Some(host) = libraries().into_iter().next() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let export = scalar_observer(Scalar::Binary64);
    for (platform, version, expected) in [
        ("x86_64-linux", Version::Two, "binaries/linux64/plant.so"),
        ("x86_64-linux", Version::Three, "binaries/x86_64-linux/plant.so"),
        ("x86_64-darwin", Version::Two, "binaries/darwin64/plant.dylib"),
        ("aarch64-darwin", Version::Two, "binaries/aarch64-darwin/plant.dylib"),
    ] {
        let mut compiler = host.clone();
        compiler.platform = platform.to_owned();
        let path = export.fmu(version).unwrap().compile(&compiler, &folder("platforms"));
        assert_eq!(path, Ok::<_, ExportError>(expected.to_owned()));
    }
    assert_eq!(
        host.platform,
        format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS.replace("macos", "darwin"))
    );
}
