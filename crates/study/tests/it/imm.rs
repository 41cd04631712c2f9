//! `imm`: the models of a study, their probabilities in the results, and mistakes in the keys.

use luenberger_observers::{ExtendedKalmanFilter, InteractingMultipleModel, NoiseModel, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_study::{RunOptions, Step, execute};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

use crate::studies::{designed, executed, mistakes, scratch, study, study_in};

/// A tank whose valve opens at 20, as a parameter and as a matrix.
fn tank(plant: &str, change: &str, models: &str) -> String {
    format!(
        "[plant]\n{plant}\ndt = 1\n[simulation]\nx0 = [1]\nduration = 40\nsamples = 41\n\
         noise = {{ amplitude = [0.01], period = 1, seed = 3 }}\n[[truth.event]]\nat = 20\n{change}\n\
         [[observer]]\nname = \"valve\"\nkind = \"imm\"\nw = 1e-6\nv = 1e-4\np0 = 0.01\nperiod = 1\ninitial = [1]\n\
         models = [{models}]\ntransitions = [[0.98, 0.02], [0.02, 0.98]]\n"
    )
}

const PARAMETER: &str = "f = [\"k*x1 + 0.1\"]\nh = [\"x1\"]\nparameters = { k = 0.9 }";

fn studies() -> [String; 2] {
    [
        tank(
            PARAMETER,
            "parameters = { k = 0.5 }",
            "{ name = \"shut\" }, { name = \"open\", parameters = { k = 0.5 } }",
        ),
        tank(
            "a = [[0.9]]\nb = [[1]]\nc = [[1]]",
            "a = [[0.5]]",
            "{ name = \"shut\" }, { name = \"open\", a = [[0.5]], w = 1e-6, v = 1e-4 }",
        ) + "[input]\nexpressions = [\"0.1\"]\n",
    ]
}

#[test]
fn a_change_of_the_plant_is_found() {
    for text in studies() {
        let results = executed(&text, Step::Simulate);
        assert_eq!(results.failures(), Vec::<String>::new());
        let [shut, open] = &results.models[..] else { panic!("{:?}", results.models) };
        assert_eq!([shut.model.as_str(), open.model.as_str()], ["shut", "open"]);
        assert!((shut.mean + open.mean - 1.0).abs() < 1e-12 && shut.observer == "valve");
        assert!(open.last > 0.9 && (0.4..0.6).contains(&open.most_probable), "{:?}", results.models);
        let text = results.text(true);
        assert!(text.contains("Probabilities of the models"), "{text}");
        // The estimate follows, which one model alone does not.
        let scores = &results.simulation.as_ref().unwrap().rows[0].merits.as_ref().unwrap().states[0];
        assert!(scores.last.abs() < 0.05, "{scores:?}");
    }
}

/// The observer of the study is that of its numbers: the same step as one that is made of them here.
#[test]
fn the_models_are_those_of_the_study() {
    let study = study(&studies()[1]);
    let of_study = designed(&study).unwrap().runnable;
    let model = |a: f64| {
        let plant = StateSpace::new(dmatrix![a], dmatrix![1.0], dmatrix![1.0]).unwrap();
        let noises = NoiseModel { w: dmatrix![1e-6], v: dmatrix![1e-4], p0: dmatrix![0.01] };
        ExtendedKalmanFilter::discrete(plant, noises, 1.0).unwrap()
    };
    let transitions = dmatrix![0.98, 0.02; 0.02, 0.98];
    let filter = InteractingMultipleModel::new(vec![model(0.9), model(0.5)], transitions, dvector![0.5, 0.5]).unwrap();
    let (u, y) = (dvector![0.1], dvector![0.7]);
    let mut state = filter.initial(0.0, &dvector![1.0], &u, &y);
    assert_eq!(of_study.initial(0.0, &[1.0], &[0.1], &[0.7]).unwrap(), state.as_slice());
    let next = of_study.motion(0.0, state.as_slice(), &[0.1], &[0.7]).unwrap();
    filter.step(0.0, &mut state, &u, &y);
    assert!((DVector::from_vec(next.clone()) - &state).amax() < 1e-15);
    let modes = of_study.modes(&DMatrix::from_row_slice(1, next.len(), &next)).unwrap();
    assert!((modes.transpose() - filter.probabilities(&state).unwrap()).amax() < 1e-15);
}

#[test]
fn figure_and_table_of_the_probabilities() {
    let folder = scratch("imm");
    let options = RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() };
    let results = execute(&study_in(&folder, &studies()[0]), Step::Run, &options).unwrap();
    assert!(results.files.iter().any(|file| file == "figures/modes.svg"), "{:?}", results.files);
    let table = std::fs::read_to_string(folder.join("out/trajectories/valve.csv")).unwrap();
    assert!(table.lines().next().unwrap().ends_with("shut_probability,open_probability"), "{table}");
    let json = std::fs::read_to_string(folder.join("out/study.json")).unwrap();
    assert!(json.contains("\"most_probable\""));
}

/// In continuous time with samples, and for a model with other equations.
#[test]
fn in_continuous_time() {
    let text = "[plant]\nf = [\"x2\", \"-x1\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1, 0]\nduration = 10\n\
                noise = { amplitude = [0.01], period = 0.1, seed = 1 }\n\
                [[observer]]\nkind = \"imm\"\nw = 1e-6\nv = 1e-4\nperiod = 0.1\n\
                models = [{ f = [\"x2\", \"-4*x1\"], h = [\"x1\"] }, {}]\ntransitions = [[1, 0], [0, 1]]\nprobabilities = [0.9, 0.1]\n";
    let results = executed(text, Step::Simulate);
    let [wrong, right] = &results.models[..] else { panic!("{:?}", results.models) };
    assert_eq!([wrong.model.as_str(), right.model.as_str()], ["model 1", "model 2"]);
    assert!(right.last > 0.999, "{:?}", results.models);
}

#[test]
fn mistakes_of_the_keys() {
    let two = "{}, { parameters = { k = 0.5 } }";
    let base = tank(PARAMETER, "parameters = { k = 0.5 }", two);
    let with = |from: &str, to: &str| base.replace(from, to);
    for (text, expected) in [
        (with(two, "{}"), "`models` has 1 model"),
        (with(two, "{ parameters = { g = 1 } }, {}"), "the plant has no parameter `g`"),
        (with(two, "{ a = [[1]] }, {}"), "`a` is a matrix, and the plant has no matrices"),
        (with(two, "{ w = [1, 2] }, {}"), "the diagonal `w` has length 2"),
        (with(two, "{ name = \"one\" }, { name = \"one\" }"), "two models are named \"one\""),
        (
            with("[0.02, 0.98]]", "[0.02, 0.9]]"),
            "row 2 of `transitions` does not consist of probabilities that sum to 1",
        ),
        (with("[[0.98, 0.02]", "[[1.02, -0.02]"), "row 1 of `transitions`"),
        (with("[[0.98, 0.02], [0.02, 0.98]]", "[[1]]"), "`transitions` is 1 x 1"),
        (
            with("transitions", "probabilities = [1]\ntransitions"),
            "`probabilities` has length 1, and `models` has 2 models",
        ),
        (with("transitions", "probabilities = [0.5, 0.4]\ntransitions"), "`probabilities` do not sum to 1"),
    ] {
        let found = mistakes(&text).iter().fold(String::new(), |all, one| all + &one.message + "\n");
        assert!(found.contains(expected), "{text}\n{found}");
    }
}
