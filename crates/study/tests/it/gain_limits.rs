//! Gains within limits, in studies: their keys, their warnings, and Jacobians with too many varying entries.

use std::sync::atomic::AtomicBool;

use luenberger_study::design::design;
use luenberger_study::results::DesignReport;
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::read;

fn designed(text: &str) -> Result<DesignReport, Box<dyn std::error::Error>> {
    let study = read(text)?;
    let outcome = design(&study, &study.observers[0], &AtomicBool::new(false));
    Ok(outcome.map_err(|why| format!("{why:?}"))?.report)
}

const PENDULUM: &str = "[plant]\nf = [\"x2\", \"-sin(x1)\"]\nh = [\"x1\"]\n[[observer]]\nkind = \"lpv\"\n";

#[test]
fn a_bound_and_the_noise_shape_the_gain() -> Result<(), Box<dyn std::error::Error>> {
    let plain = designed(&format!("{PENDULUM}decay_rate = 1"))?;
    let bounded = designed(&format!("{PENDULUM}decay_rate = 1\nmax_gain = 6"))?;
    let quiet = designed(&format!("{PENDULUM}decay_rate = 1\nnoise = [1]"))?;
    let number = |report: &DesignReport, name: &str| report.number(name).ok_or_else(|| name.to_owned());
    assert!(number(&bounded, "norm of L")? <= 6.0);
    assert!(number(&quiet, "noise gain")? < number(&plain, "noise gain")?);
    for report in [&plain, &bounded, &quiet] {
        assert_eq!(report.verdict.word(), "proved");
        assert_eq!(report.number("rate"), Some(1.0));
    }
    let fast = designed(&format!("{PENDULUM}fastest = 50\nmax_gain = 20"))?;
    assert!(number(&fast, "norm of L")? <= 20.0 && number(&fast, "rate")? > 0.5);
    Ok(())
}

#[test]
fn limits_beside_a_given_gain_are_a_mistake() {
    let error = read(&format!("{PENDULUM}gain = [[4], [6]]\nmax_gain = 5")).unwrap_err().to_string();
    assert!(error.contains("`max_gain` conflicts with `gain`, which determines the gain"), "{error}");
    let linear = "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n";
    let error = read(&format!("{linear}noise = [1]")).unwrap_err().to_string();
    assert!(error.contains("`noise` conflicts with `poles`"), "{error}");
}

#[test]
fn more_entries_than_vertices_can_hold_become_sectors() -> Result<(), Box<dyn std::error::Error>> {
    // Fourteen entries of the Jacobian vary: 0.05 cos of each neighbour and of each state.
    let f: Vec<String> = (1..=7).map(|i| format!("\"-x{i} + 0.05*sin(x{i}) + 0.05*sin(x{})\"", i % 7 + 1)).collect();
    let plant = format!("[plant]\nf = [{}]\nh = [\"x1\"]\n[[observer]]\nkind = \"lpv\"\n", f.join(", "));
    for requested in ["decay_rate = 0.5", "fastest = 0.8"] {
        let report = designed(&format!("{plant}{requested}"))?;
        assert_eq!(report.verdict.word(), "proved");
        assert_eq!(report.number("sectors"), Some(14.0));
        assert!(report.statement.contains("14 entries of the Jacobians vary"), "{}", report.statement);
        // The plant alone decays at a rate of at least 1 - 0.1.
        assert!(report.number("rate").ok_or("a rate")? >= 0.5);
    }
    Ok(())
}

#[test]
fn useless_gains_are_warned_of() -> Result<(), Box<dyn std::error::Error>> {
    let text = "[plant]\na = [[0, 1], [-1, -1]]\nc = [[1, 0]]\n\
        [simulation]\nx0 = [1, 1]\nduration = 1\nnoise = { amplitude = [0.1], period = 0.01 }\n\
        [[observer]]\nname = \"moderate\"\nkind = \"luenberger\"\npoles = [-3, -4]\n\
        [[observer]]\nname = \"noisy\"\nkind = \"luenberger\"\npoles = [-50, -60]\n\
        [[observer]]\nname = \"absurd\"\nkind = \"luenberger\"\npoles = [-2e4, -3e4]\n";
    let results = execute(&read(text)?, Step::Design, &RunOptions::default())?;
    let of = |name: &str| results.warnings.iter().filter(|warning| warning.starts_with(name)).collect::<Vec<_>>();
    assert_eq!(of("moderate"), Vec::<&String>::new());
    assert!(
        of("absurd")[0].contains("its fastest pole is 30000 times as fast as the plant's fastest mode"),
        "{:?}",
        of("absurd")
    );
    // 1.8309 by scipy.
    let noisy = "noisy: the measurement noise alone leaves an error of standard deviation 1.83 in x2, more than the initial error 1";
    assert!(of("noisy")[0].starts_with(noisy), "{:?}", of("noisy"));
    // L = [6, 5] for the poles -3 and -4: by scipy's cont2discrete(F, L) and solve_discrete_lyapunov, for noise of
    // variance 0.1^2 held over 0.01.
    let moderate = results.observers[0].design.as_ref().ok_or("a design")?;
    assert!(
        moderate.noise_deviation.iter().zip(EXPECTED).all(|(found, expected)| (found / expected - 1.0).abs() < 1e-9),
        "{:?}",
        moderate.noise_deviation
    );
    Ok(())
}

const EXPECTED: [f64; 2] = [0.018_140_666_165_881_267, 0.014_137_967_442_397_068];
