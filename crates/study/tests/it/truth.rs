//! Plants that are not the model: the table [truth].

use luenberger_study::{Results, Step};

use crate::studies::executed;

/// level' = -k level + u with u = 1, observed with the gain 0.5 by one who takes k to be 1.
const TANK: &str = r#"
[plant]
f = ["-k*level + u1"]
h = ["level"]
states = ["level"]
parameters = { k = 1 }
[input]
expressions = ["1"]
[simulation]
x0 = [2]
duration = 40
[[observer]]
name = "by hand"
kind = "luenberger"
gain = [[0.5]]
rho = 3
"#;

fn last(results: &Results) -> f64 {
    results.simulation.as_ref().unwrap().rows[0].merits.as_ref().unwrap().states[0].last
}

/// In the end x = 1/k and xhat = (1 + L x)/(1 + L).
#[test]
fn other_parameters_leave_an_error() {
    let results = executed(&format!("{TANK}[truth]\nparameters = {{ k = 2 }}\n"), Step::Compare);
    assert!((last(&results) - ((1.0 + 0.5 * 0.5) / 1.5 - 0.5)).abs() < 1e-8);
    let said = results.simulation.as_ref().unwrap().truth.as_ref().unwrap();
    assert_eq!(said, "The simulated plant is not the model that observers are designed for: k = 2.");
    // The model is what is designed for: the decay rate of the error is 1.5.
    assert_eq!(results.observers[0].design.as_ref().unwrap().poles, [[-1.5, 0.0]]);
    // As a sweep over the truth; with k = 1 there is no error.
    let text = format!("{TANK}[truth]\nparameters = {{ k = 2 }}\n[sweep]\nparameter = \"truth.k\"\nvalues = [1, 4]\n");
    let rows = executed(&text, Step::Sweep).sweep.unwrap().rows;
    assert!(rows[0].states[0].last < 1e-8);
    assert!((rows[1].states[0].last - ((1.0 + 0.5 * 0.25) / 1.5 - 0.25)).abs() < 1e-8);
}

/// A bias b of the sensor leaves L b/(k + L), one of the actuator -b/(k + L).
#[test]
fn biases_leave_an_error() {
    let sensor = executed(&format!("{TANK}[truth]\nsensor = {{ bias = [0.3] }}\n"), Step::Compare);
    assert!((last(&sensor) - 0.5 * 0.3 / 1.5).abs() < 1e-8);
    let actuator = executed(&format!("{TANK}[truth]\nactuator = {{ bias = [0.3], from = 5 }}\n"), Step::Compare);
    assert!((last(&actuator) - 0.3 / 1.5).abs() < 1e-8);
}

/// White noise of intensity W, held over a short period, leaves the variance W / (2 (k + L)) of the error.
#[test]
fn process_noise_leaves_its_variance() {
    let noise = "[truth]\nprocess_noise = { amplitude = [2], period = 0.01 }\n";
    let text = TANK.replace("duration = 40", "duration = 400\nsamples = 2") + noise;
    let results = executed(&text, Step::Compare);
    let found = results.simulation.unwrap().rows[0].merits.as_ref().unwrap().states[0].steady_rmse;
    // W = 2^2 * 0.01. Over 200 of time the variance is an average of some 300 independent values: 10 %.
    let expected = (0.04f64 / 3.0).sqrt();
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
}

/// The same plant with matrices, and of the library with equations: k = 2 as above, in each of their forms.
#[test]
fn a_plant_of_any_form_may_be_another() {
    let expected = (1.0 + 0.5 * 0.5) / 1.5 - 0.5;
    let matrices = TANK.replace("f = [\"-k*level + u1\"]\nh = [\"level\"]", "a = [[-1]]\nb = [[1]]\nc = [[1]]");
    let matrices = matrices.replace("parameters = { k = 1 }\n", "");
    for (plant, truth, said) in [
        (TANK, "f = [\"-2*k*level + u1\"]", "other equations f"),
        (TANK, "f = [\"-r*k*level + u1\"]\nparameters = { r = 2 }", "other equations f; r = 2"),
        (TANK, "h = [\"level\"]\nparameters = { k = 2 }", "other equations h; k = 2"),
        (&matrices, "a = [[-2]]", "another A"),
        (
            &matrices,
            "f = [\"-r*level + u1\"]\nh = [\"level\"]\nparameters = { r = \"1 + 1\" }",
            "other equations f; other equations h; r = 1 + 1",
        ),
    ] {
        let results = executed(&format!("{plant}[truth]\n{truth}\n"), Step::Compare);
        assert!((last(&results) - expected).abs() < 1e-8, "{truth}: {}", last(&results));
        let words = results.simulation.as_ref().unwrap().truth.as_ref().unwrap();
        assert!(words.ends_with(&format!("designed for: {said}.")), "{words}");
    }
    // A plant of the library, and its own equations; with another stiffness the states differ.
    let library = "[plant]\nbuiltin = \"van-der-pol\"\n[simulation]\nx0 = [1, 0]\nduration = 5\n[[observer]]\n\
                   kind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n";
    let end = |truth: &str| executed(&format!("{library}{truth}"), Step::Compare).simulation.unwrap().x_end;
    let own = end("[truth]\nf = [\"x2\", \"(1 - x1^2)*x2 - x1\"]\nh = [\"x1\"]\n");
    let stiffer = end("[truth]\nf = [\"x2\", \"(1 - x1^2)*x2 - 2*x1\"]\nh = [\"x1\"]\n");
    for ((library, own), stiffer) in end("").iter().zip(&own).zip(&stiffer) {
        assert!((library - own).abs() < 1e-7 && (library - stiffer).abs() > 1e-2, "{library} {own} {stiffer}");
    }
}

/// Changes at a time. With the rate 1.5 of the error: a jump of 1 leaves exp(-1.5) of it after 1; two changes of k are
/// as the last, 35 later.
#[test]
fn events_change_the_plant() {
    let results = executed(&format!("{TANK}[[truth.event]]\nat = 39\njump = [1]\n"), Step::Compare);
    assert!((last(&results) - (-1.5f64).exp()).abs() < 1e-7, "{}", last(&results));
    let words = results.simulation.as_ref().unwrap().truth.clone().unwrap();
    assert!(words.ends_with("designed for: events at t = 39."), "{words}");
    let events = "[[truth.event]]\nat = 4\nparameters = { k = 7 }\n[[truth.event]]\nat = 5\nparameters = { k = 2 }\n\
                  [[truth.event]]\nat = 50\njump = [9]\n";
    let results = executed(&format!("{TANK}{events}"), Step::Compare);
    assert!((last(&results) - ((1.0 + 0.5 * 0.5) / 1.5 - 0.5)).abs() < 1e-8);
    // In discrete time, x+ = x/2 + u: 2 in the end, 3/2 + 2 just after the jump of 2 at the last sample but one.
    let discrete = TANK.replace("-k*level + u1", "k*level/2 + u1").replace("parameters", "dt = 1\nparameters");
    let discrete = discrete.replace("gain = [[0.5]]\nrho = 3", "gain = [[0.25]]");
    let results = executed(&format!("{discrete}[[truth.event]]\nat = 38.5\njump = [2]\n"), Step::Compare);
    assert!((results.simulation.unwrap().x_end[0] - (0.5 * (2.0 + 2.0) + 1.0)).abs() < 1e-9);
}

#[test]
fn delays_quantisation_dropouts_and_outliers_are_read() {
    let text = format!(
        "{TANK}[truth]\ninput_delay = 0.2\nmeasurement_delay = 0.1\nquantisation = [0.25]\ndropout = 0.1\n\
         outliers = {{ probability = 0.1, size = [4] }}\nperiod = 0.1\nseed = 7\nsensor = {{ gain = [1] }}\n"
    );
    let results = executed(&text, Step::Compare);
    assert!(last(&results) > 1e-3);
    let said = results.simulation.as_ref().unwrap().truth.clone().unwrap();
    assert!(
        said.ends_with("input delay = 0.2; measurement delay = 0.1; quantisation; dropout = 0.1; outliers; sensor."),
        "{said}"
    );
}

/// x+ = 0.9 x + w, y = x + v, variances 1, every seed the default one. The variance of the predicted estimate solves `P
/// = 0.81 P/(P + 1) + 1`: `P = (0.81 + sqrt(0.81^2 + 4))/2 = 1.4839`, whose root is 1.2182; that of the filtered one is
/// `P/(P + 1) = 0.5974`, with the root 0.7729. Either error is an autoregression with the coefficient `0.9/(P + 1) =
/// 0.3623`, so that the standard error of the mean square of n of them is `P sqrt(2 (1 + 0.3623^2)/(1 - 0.3623^2)/n)`.
/// Innovations of the right filter are white: their normalised mean square is 1, with the standard error `sqrt(2/n)`.
#[test]
fn process_noise_is_independent_of_the_measurement_noise() {
    let text = r#"
[plant]
states = ["x"]
outputs = ["y"]
f = ["0.9*x"]
h = ["x"]
dt = 1
[simulation]
x0 = [0]
duration = 5000
samples = 5001
noise = { amplitude = [1], period = 1MEASURED }
[truth]
process_noise = { amplitude = [1], period = 1PROCESS }
[[observer]]
name = "EKF"
kind = "extended-kalman"
w = 1
v = 1
p0 = 1
period = 1
"#;
    let predicted = f64::midpoint(0.81, (0.81f64.powi(2) + 4.0).sqrt());
    let filtered = predicted / (predicted + 1.0);
    for (seeds, estimates, variance) in [
        ([None; 2], "filtered", filtered),
        ([None; 2], "predicted", predicted),
        ([Some(4); 2], "filtered", filtered),
        ([Some(3), Some(4)], "predicted", predicted),
    ] {
        let [measured, process] =
            seeds.map(|seed| seed.map_or_else(String::new, |seed: u32| format!(", seed = {seed}")));
        let text = text.replace("MEASURED", &measured).replace("PROCESS", &process);
        let text = text.replace("duration = 5000", &format!("duration = 5000\nestimates = \"{estimates}\""));
        let results = executed(&text, Step::Compare);
        let n = 5001.0;
        let rmse = results.simulation.as_ref().unwrap().rows[0].merits.as_ref().unwrap().states[0].rmse;
        let pole = 0.9 / (predicted + 1.0);
        let relative = (2.0 * (1.0 + pole * pole) / (1.0 - pole * pole) / n).sqrt();
        assert!((rmse * rmse / variance - 1.0).abs() < 4.0 * relative, "{seeds:?}, {estimates}: {rmse}");
        let nis = results.filters[0].nis.as_ref().unwrap().mean;
        assert!((nis - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{seeds:?}: {nis}");
    }
}

/// y = v of variance 1, of which three in ten do not arrive: those that do have the variance 1 all the same. The filter
/// takes x for nearly constant, so that its innovations are the noise.
#[test]
fn dropouts_are_independent_of_the_measurement_noise() {
    let text = r#"
[plant]
states = ["x"]
outputs = ["y"]
f = ["0"]
h = ["x"]
[simulation]
x0 = [0]
duration = 1000
samples = 10001
noise = { amplitude = [1], period = 0.1 }
[truth]
dropout = 0.3
[[observer]]
name = "EKF"
kind = "extended-kalman"
w = 1e-6
v = 1
p0 = 1
period = 0.1
"#;
    let results = executed(text, Step::Compare);
    let nis = results.filters[0].nis.as_ref().unwrap();
    let arrived = nis.samples as f64;
    // Seven in ten of 10001, within four standard deviations.
    assert!((arrived - 0.7 * 10_001.0).abs() < 4.0 * (0.21f64 * 10_001.0).sqrt(), "{arrived}");
    assert!((nis.mean - 1.0).abs() < 4.0 * (2.0 / arrived).sqrt(), "{}", nis.mean);
}
