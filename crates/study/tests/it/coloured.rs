//! `[estimate.noises]`: coloured noises as states of the plant.

use std::fmt::Write as _;

use luenberger_random::Random;
use luenberger_study::tune::{TuneOptions, tune};
use luenberger_study::{Format, Results, RunOptions, Step, Study};

use crate::studies::{executed, filters, mistakes, scratch, study, study_in};

/// A speed with friction on which a gust acts, measured by a sensor that drifts.
const CART: &str = "[plant]\nstates = [\"speed\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [\"u - 0.5*speed + gust\"]\nh = [\"speed + drift\"]\nparameters = { gust = 0, drift = 0 }\n";
const NOISES: &str = "[estimate.noises]\ngust = { tau = 5, deviation = 0.3 }\ndrift = { tau = 40, deviation = 0.05 }\n";
const INPUT: &str = "[input]\nexpressions = [\"sin(t)\"]\n";

fn simulation(x0: &str, duration: f64, period: f64) -> String {
    format!(
        "[simulation]\nx0 = [{x0}]\nduration = {duration}\nhold = {period}\nnoise = {{ amplitude = [0.2], period = {period}, seed = 4 }}\n"
    )
}

fn observers(kinds: &[&str], keys: &str) -> String {
    kinds.iter().fold(String::new(), |mut text, kind| {
        _ = write!(text, "[[observer]]\nkind = \"{kind}\"\n{keys}\n");
        text
    })
}

fn numbers(results: &Results) -> (Vec<serde_json::Value>, serde_json::Value) {
    let simulation = results.simulation.as_ref().unwrap();
    let rows = simulation.rows.iter().map(|row| serde_json::to_value(&row.merits).unwrap()).collect();
    (rows, serde_json::to_value(&results.filters).unwrap())
}

/// All scores, NIS and NEES are those of the plant with shaping states that are written by hand, to the last bit, with
/// the noises in the simulated plant; in discrete time too, and about means that are not 0.
#[test]
fn noises_are_the_shaping_states_that_one_writes_by_hand() {
    let keys = |w: &str, p0: &str, initial: &str, period: f64| {
        observers(&filters(), &format!("w = [{w}]\np0 = [{p0}]\ninitial = [{initial}]\nv = 0.04\nperiod = {period}"))
    };
    let (gust, drift): (f64, f64) = (2.0 * (0.3 * 0.3) / 5.0, 2.0 * (0.05 * 0.05) / 40.0);
    let p0 = format!("1, {}, {}", 0.3 * 0.3, 0.05 * 0.05);
    let truth = |amplitude: &str, rest: &str| {
        format!("[truth]\nprocess_noise = {{ amplitude = [{amplitude}], period = 0.1, seed = 3{rest} }}\n")
    };
    // s/tau sqrt(coth(h/(2 tau))), in single steps.
    let held = |deviation: f64, tau: f64| deviation / tau / (0.5 * 0.1 / tau).tanh().sqrt();
    let named = format!(
        "{CART}{INPUT}{NOISES}{}{}{}",
        simulation("1", 20.0, 0.1),
        truth("0.3", ", noises = true"),
        keys("1e-3", "1", "0", 0.1)
    );
    let plant = "[plant]\nstates = [\"speed\", \"gust\", \"drift\"]\ninputs = [\"u\"]\noutputs = [\"y\"]\nf = [\"u - 0.5*speed + gust\", \"-gust/5\", \"-drift/40\"]\nh = [\"speed + drift\"]\n";
    let by_hand = format!(
        "{plant}{INPUT}{}{}{}",
        simulation("1, 0, 0", 20.0, 0.1),
        truth(&format!("0.3, {}, {}", held(0.3, 5.0), held(0.05, 40.0)), ""),
        keys(&format!("1e-3, {gust}, {drift}"), &p0, "0, 0, 0", 0.1)
    );
    let (named, by_hand) = (executed(&named, Step::Simulate), executed(&by_hand, Step::Simulate));
    assert_eq!(named.simulation.as_ref().unwrap().rows.len(), filters().len());
    assert_eq!(numbers(&named), numbers(&by_hand));
    let end = &named.simulation.as_ref().unwrap().x_end;
    assert!(end[1] != 0.0 && end[1].abs() < 1.5 && end[2] != 0.0 && end[2].abs() < 0.25, "{end:?}");

    // In discrete time, with a mean and an own first variance; a = exp(-0.5/2).
    let a = (-0.5_f64 / 2.0).exp();
    let driving = -(0.4 * 0.4) * (-2.0 * 0.5_f64 / 2.0).exp_m1();
    let named = format!(
        "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\nf = [\"0.8*x + n\"]\nh = [\"x^2\"]\nparameters = {{ n = 0.25 }}\ndt = 0.5\n[estimate.noises]\nn = {{ tau = 2, deviation = 0.4, p0 = 0.01 }}\n{}[truth]\nprocess_noise = {{ amplitude = [0], period = 0.5, seed = 3, noises = true }}\n{}",
        simulation("1", 20.0, 0.5),
        keys("1e-3", "0.1", "1.2", 0.5)
    );
    let by_hand = format!(
        "[plant]\nstates = [\"x\", \"n\"]\noutputs = [\"y\"]\nf = [\"0.8*x + n\", \"0.25 + {a}*(n - 0.25)\"]\nh = [\"x^2\"]\ndt = 0.5\n{}[truth]\nprocess_noise = {{ amplitude = [0, {}], period = 0.5, seed = 3 }}\n{}",
        simulation("1, 0.25", 20.0, 0.5),
        driving.sqrt(),
        keys(&format!("1e-3, {driving}"), "0.1, 0.01", "1.2, 0.25", 0.5)
    );
    assert_eq!(numbers(&executed(&named, Step::Simulate)), numbers(&executed(&by_hand, Step::Simulate)));
}

/// Standard deviations and gains in the steady state are those of the Riccati equation of the plant with shaping
/// states: `scipy.linalg.solve_discrete_are` and `solve_continuous_are`, scipy 1.17.1, of the exact discretisation
/// (Van Loan, `scipy.linalg.expm`) with the period 0.5 of
/// `A = [-0.5 1 0; 0 -1/5 0; 0 0 -1/40]`, `W = diag(0.01, 2 0.3^2/5, 2 0.05^2/40)`, `C = (1 0 1)`, `V = 0.04`, and in
/// discrete time of `A = [0.8 1 0; 0 e^(-0.1) 0; 0 0 e^(-0.0125)]`,
/// `W = diag(0.005, 0.3^2 (1 - e^(-0.2)), 0.05^2 (1 - e^(-0.025)))`.
#[test]
fn stationary_variances_solve_the_riccati_equation() {
    let sampled = [0.140_813_200_386_286_95, 0.183_751_756_599_275_45, 0.049_560_389_354_658_36];
    let of_continuous_time = [0.862_554_368_425_970_7, 0.683_212_161_042_464_7, 0.007_290_686_362_988_134];
    let discrete = [0.166_970_936_483_958_6, 0.169_190_842_574_164_15, 0.049_924_876_962_735_01];
    let of_discrete_time = [0.826_403_442_435_686_2, 0.287_403_770_339_008_6, 0.001_280_330_302_340_070_2];
    let text = |plant: &str, w: f64, period: f64| {
        format!(
            "{plant}{INPUT}{NOISES}{}{}{}",
            simulation("1", 600.0, period),
            observers(&["extended-kalman", "ukf"], &format!("w = {w}\nv = 0.04\np0 = 1\nperiod = {period}")),
            observers(&["kalman"], &format!("w = {w}\nv = 0.04")),
        )
    };
    let in_discrete_time = CART.replace("u - 0.5*speed", "u + 0.8*speed").replace("[plant]", "[plant]\ndt = 0.5");
    for (plant, w, deviations, gain) in
        [(CART, 0.01, sampled, of_continuous_time), (&in_discrete_time, 0.005, discrete, of_discrete_time)]
    {
        let results = executed(&text(plant, w, 0.5), Step::Simulate);
        for run in results.runs.iter().filter(|run| run.observer != "kalman") {
            let own = run.deviation.as_ref().unwrap();
            // Between samples it is larger; the least of the last ones is that after a measurement.
            for (i, expected) in deviations.into_iter().enumerate() {
                let least = own.column(i).rows(own.nrows() - 20, 20).min();
                assert!((least / expected - 1.0).abs() < 1e-9, "{}, {i}: {least} {expected}", run.observer);
            }
        }
        let kalman = results.observers.iter().find(|one| one.name == "kalman").unwrap();
        let design = kalman.design.as_ref().unwrap_or_else(|| panic!("{kalman:?}"));
        assert!(design.verdict.is_proved(), "{design:?}");
        let l = &design.matrices.iter().find(|matrix| matrix.name == "L").unwrap().rows;
        for (row, expected) in l.iter().zip(gain) {
            assert!((row[0] / expected - 1.0).abs() < 1e-9, "{l:?}");
        }
    }
}

/// The noises of the simulated plant have their deviations and correlation times, and the filter that knows them is
/// consistent where the one that does not is overconfident.
#[test]
fn a_filter_that_knows_the_colour_is_consistent() {
    let text = |table: &str, noises: &str, keys: &str| {
        format!(
            "{CART}{INPUT}{table}{}[truth]\nprocess_noise = {{ amplitude = [0.1], period = 0.5, seed = 3{noises} }}\n{}",
            simulation("0", 4000.0, 0.5).replace("noise = {", "samples = 8001\nnoise = {"),
            observers(&["extended-kalman"], keys)
        )
    };
    let keys = "w = 0.005\nv = 0.04\np0 = 0.01\nperiod = 0.5";
    let results = executed(&text(NOISES, ", noises = true", keys), Step::Simulate);
    let run = results.runs.iter().find(|run| run.observer == "extended-kalman").unwrap();
    // 4000 time units are 400 independent values of gust, about, and 50 of drift.
    for (state, deviation, lag, tau, tolerance) in [(1, 0.3, 10, 5.0, 0.15), (2, 0.05, 80, 40.0, 0.4)] {
        let n: Vec<f64> = run.x.column(state).iter().copied().collect();
        let mean = |products: &mut dyn Iterator<Item = f64>, count: usize| products.sum::<f64>() / count as f64;
        let variance = mean(&mut n.iter().map(|x| x * x), n.len());
        assert!((variance / (deviation * deviation) - 1.0).abs() < tolerance, "{state}: {variance}");
        let later = mean(&mut n.iter().zip(&n[lag..]).map(|(x, y)| x * y), n.len() - lag) / variance;
        let expected = (-0.5 * lag as f64 / tau).exp();
        assert!((later - expected).abs() < tolerance, "{state}: {later} {expected}");
    }
    let filter = &results.filters[0];
    assert!(filter.nis.as_ref().unwrap().accepted, "{filter:?}");
    let nees = filter.nees.as_ref().unwrap();
    assert!((nees.mean / nees.expected - 1.0).abs() < 0.1, "{nees:?}");
    // The same record for a filter whose gust is hardly there.
    let small = NOISES.replace("deviation = 0.3", "deviation = 0.003");
    let other = text(&small, ", noises = true", keys).replace(
        "[truth]\nprocess_noise = { amplitude = [0.1], period = 0.5, seed = 3, noises = true }",
        "[truth]\nprocess_noise = { amplitude = [0.3], period = 0.5, seed = 3 }",
    );
    let filter = &executed(&other, Step::Simulate).filters[0];
    assert!(!filter.nis.as_ref().unwrap().accepted, "{filter:?}");
}

/// `tune` fits deviation and correlation time of a noise, and writes them where they are.
#[test]
fn noises_are_tuned() {
    let folder = scratch("coloured/tuned");
    // y = x + n + v, x constant; n(k+1) = a n(k) + sqrt(1 - a^2) 0.5 w with tau = 4.
    let mut random = Random(3);
    let (a, mut n, mut csv) = ((-0.25_f64).exp(), 0.0, "t,y\n".to_owned());
    for k in 0..1500 {
        let [first, second] = random.normal_pair();
        _ = writeln!(csv, "{k},{}", 2.0 + n + 0.1 * first);
        n = a * n + 0.5 * (1.0 - a * a).sqrt() * second;
    }
    std::fs::write(folder.join("log.csv"), csv).unwrap();
    let text = "[plant]\nstates = [\"x\"]\noutputs = [\"y\"]\nf = [\"x\"]\nh = [\"x + n\"]\nparameters = { n = 0 }\nunits = { n = \"m\" }\ntime_unit = \"s\"\ndt = 1\n[estimate]\nnoises = { n = { tau = 1, deviation = 0.1 } } # a guess\n[log]\nfile = \"log.csv\"\n[[observer]]\nkind = \"extended-kalman\"\nw = 0\np0 = 4\nv = 0.01\nperiod = 1\n[tune]\nobserver = \"extended-kalman\"\nparameters = [\"deviation[n]\", \"tau[n]\"]\nstarts = 1\nprofile = 0\nheld_out = 0.2\n";
    let options = TuneOptions {
        run: RunOptions { output: Some(folder.join("out").into()), ..RunOptions::default() },
        ..TuneOptions::default()
    };
    let found = tune(&study_in(&folder, text), &options).unwrap_or_else(|error| panic!("{error}"));
    let [deviation, tau] = &found.parameters[..] else { panic!("{:?}", found.parameters) };
    assert_eq!([&deviation.name, &tau.name], ["deviation[n]", "tau[n]"]);
    assert_eq!([&deviation.unit, &tau.unit], [&Some("m".to_owned()), &Some("s".to_owned())]);
    assert!((deviation.after / 0.5 - 1.0).abs() < 0.15, "{deviation:?}");
    assert!((tau.after / 4.0 - 1.0).abs() < 0.3, "{tau:?}");
    let line = found.study.lines().find(|line| line.starts_with("noises")).unwrap();
    assert!(line.ends_with("# a guess"), "{line}");
    let tuned = Study::from_text("tuned.toml", &found.study, Format::Toml, &folder).unwrap();
    let noise = tuned.estimated[0].noise.unwrap();
    assert_eq!([noise.deviation.to_bits(), noise.tau.to_bits()], [deviation.after.to_bits(), tau.after.to_bits()]);
    // W and the first variance of a noise are no numbers of their own.
    let wrong = text.replace("\"deviation[n]\", \"tau[n]\"", "\"w[n]\"");
    let read = Study::from_text("study.toml", &wrong, Format::Toml, &folder);
    assert_eq!(
        crate::studies::mistakes_of(&wrong, read)[0].message,
        "`parameters` has \"w[n]\", which cannot be fitted"
    );
}

/// A noise is a state with its name, its unit and its rows, behind the parameters.
#[test]
fn noises_are_states_with_names() {
    let text = format!(
        "{}[estimate]\nparameters = [\"c\"]\np0 = [1]\n{NOISES}",
        CART.replace("0.5*speed", "c*speed").replace("gust = 0, ", "gust = 0, c = 0.5, ")
            + "units = { gust = \"m/s2\" }\n"
    );
    let study = study(&text);
    assert_eq!(study.plant.states, ["speed", "c", "gust", "drift"]);
    assert_eq!(study.plant.unit("gust").map(String::as_str), Some("m/s2"));
    assert_eq!(study.estimated.iter().map(|one| one.p0).collect::<Vec<_>>(), [1.0, 0.3 * 0.3, 0.05 * 0.05]);
}

#[test]
fn mistakes_of_noises_are_named() {
    let all = |table: &str, rest: &str| {
        let text = format!("{CART}{table}{rest}");
        mistakes(&text).iter().map(|mistake| mistake.message.clone()).collect::<Vec<_>>().join("; ")
    };
    let said = |noise: &str| all(&format!("[estimate.noises]\ngust = {{ {noise} }}\n"), "");
    assert_eq!(said("tau = 0, deviation = 1"), "`tau` is 0");
    assert_eq!(said("tau = nan, deviation = 1"), "`tau` is NaN");
    assert_eq!(said("tau = inf, deviation = 1"), "`tau` is inf");
    assert_eq!(said("tau = 1, deviation = -0.3"), "`deviation` is -0.3");
    assert_eq!(said("tau = 1"), "[estimate.noises.NAME] has no `deviation`");
    assert_eq!(said("tau = 1e-300, deviation = 1e10"), "tau = 1e-300 and deviation = 1e10 give w the intensity inf");
    let unknown = mistakes(&format!("{CART}[estimate.noises]\ngusts = {{ tau = 1, deviation = 1 }}\n")).swap_remove(0);
    assert_eq!(unknown.message, "the noise \"gusts\" is no parameter of the plant");
    assert_eq!((unknown.line, unknown.help.as_deref()), (9, Some("the nearest parameter is \"gust\"")));
    let twice = all(&format!("[estimate]\nparameters = [\"gust\"]\np0 = [1]\n{NOISES}"), "");
    assert_eq!(twice, "`gust` is named twice, in `parameters` and in `noises`");
    assert_eq!(all("[estimate]\n", ""), "[estimate] names nothing");
    assert_eq!(all("[estimate]\nparameters = [\"gust\"]\n", ""), "[estimate] has `parameters` and no `p0`");
    let other = all(&format!("[estimate]\np0 = [1]\n{NOISES}"), "");
    assert_eq!(other, "`p0` is of `parameters`, of which there are none");
    // A parameter of a product makes the plant nonlinear, and kalman has no place for it.
    let kalman = "[[observer]]\nkind = \"kalman\"\nw = 1\nv = 1\n";
    let refused = all("[estimate]\nparameters = [\"gust\"]\np0 = [1]\n", kalman);
    assert_eq!(refused, "the kind kalman does not estimate the parameters of [estimate]: gust");
    let truth = |rest: &str| format!("[simulation]\nx0 = [1]\nduration = 1\n[truth]\nprocess_noise = {{ {rest} }}\n");
    let without = all("", &truth("amplitude = [1], period = 0.1, noises = true"));
    assert_eq!(without, "`noises` without [estimate.noises]");
    let in_discrete_time = format!(
        "{}{NOISES}{}",
        CART.replace("[plant]", "[plant]\ndt = 0.5"),
        truth("amplitude = [1], period = 1, noises = true")
    );
    assert_eq!(
        mistakes(&in_discrete_time).swap_remove(0).message,
        "`noises` with the period 1 of a plant whose period is 0.5"
    );
}
