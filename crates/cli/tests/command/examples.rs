//! The plants of `examples/studies`, taken through `luenberger run`, and their numbers beside those of other programs.
//!
//! - *Plant*: the state at the end, by scipy 1.17 (`solve_ivp`, DOP853, rtol 1e-12, from one hold of the input to the
//!   next). The Jacobians and right-hand sides are sympy's, from the expressions of the study.
//! - *EKF*: the last estimate of an extended Kalman filter in numpy on the outputs of the run (its CSV file): the mean
//!   and `P' = A P + P A' + W` integrated by scipy with rtol 1e-9 between samples, Joseph's update.
//! - *RMSE*: numpy, of the columns of the same CSV file.
//! - *Gains*: python-control 0.10.2, `lqe` and `place`.

use crate::terminal::{folder, luenberger};
use serde_json::Value;
use std::path::Path;

/// Runs an example; the results as `study.json` has them.
#[track_caller]
fn run(name: &str) -> Value {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/studies").join(format!("{name}.toml"));
    let results = folder(&format!("example-{name}"));
    let text = std::fs::read_to_string(study).unwrap();
    // The numbers of the filters are those before the measurement of a sample.
    let predicted = text.replacen("[simulation]\n", "[simulation]\nestimates = \"predicted\"\n", 1);
    let ran = luenberger(&["run", "-", "-o", results.to_str().unwrap()], &predicted);
    assert_eq!((ran.code, ran.stderr_without_estimate()), (Some(0), String::new()), "{name}: {}", ran.stdout);
    assert!(results.join("report.html").is_file());
    serde_json::from_str(&std::fs::read_to_string(results.join("study.json")).unwrap()).unwrap()
}

#[track_caller]
fn near(what: &str, found: &Value, expected: &[f64], tolerance: f64) {
    let found: Vec<f64> = found.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        let scale = expected.abs().max(1e-3 * size);
        assert!((found - expected).abs() <= tolerance * scale, "{what}: {found}, expected {expected}");
    }
}

fn row<'a>(results: &'a Value, observer: &str) -> &'a Value {
    let rows = results["simulation"]["rows"].as_array().unwrap();
    rows.iter().find(|row| row["observer"] == observer).unwrap()
}

fn rmse(results: &Value, observer: &str) -> Value {
    let states = row(results, observer)["merits"]["states"].as_array().unwrap();
    states.iter().map(|state| state["rmse"].clone()).collect()
}

/// The last row of the estimates of an observer in its CSV file.
fn last_estimate(name: &str, file: &str, states: &[&str]) -> Value {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("example-{name}/trajectories/{file}.csv"));
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let last: Vec<&str> = lines.next_back().unwrap().split(',').collect();
    let column = |state: &&str| head.iter().position(|column| *column == format!("{state}_hat")).unwrap();
    states.iter().map(|state| last[column(state)].parse::<f64>().unwrap()).collect()
}

/// The verdict of an observer's certificate.
fn verdict<'a>(results: &'a Value, observer: &str) -> &'a Value {
    let observers = results["observers"].as_array().unwrap();
    &observers.iter().find(|one| one["name"] == observer).unwrap()["design"]["verdict"]
}

#[test]
fn cart_pole() {
    let results = run("cart-pole");
    assert_eq!(verdict(&results, "one gain"), "proved");
    let states = ["position", "velocity", "phi", "omega"];
    let expected = [0.001_700_727_227_006, -0.018_806_297_365_02, 0.002_866_987_330_865, -0.033_389_966_679_93];
    near("EKF", &last_estimate("cart-pole", "EKF-at-100-Hz", &states), &expected, 1e-8);
    let expected = [0.000_275_869_054_349_9, 0.005_003_738_152_428, 0.005_021_378_636_297, 0.007_515_387_352_885];
    near("RMSE", &rmse(&results, "EKF at 100 Hz"), &expected, 1e-9);
}

#[test]
fn dc_motor() {
    let results = run("dc-motor");
    near("plant", &results["simulation"]["x_end"], &[68.377_840_677_983, 52.388_715_240_36, 5.0], 1e-9);
    let gain = |k: usize| -> Value {
        let rows = results["observers"][k]["design"]["matrices"][0]["rows"].as_array().unwrap();
        rows.iter().map(|row| row[0].clone()).collect()
    };
    near("place", &gain(0), &[150.774_01, 5_670.259_991_48, -1_084.742_400_798], 1e-9);
    near("lqe", &gain(1), &[2_090.629_505_037, 2_185_365.863_686, -666_666.666_664], 1e-9);
}

#[test]
fn stirred_tank_reactor() {
    let results = run("cstr");
    assert_eq!(verdict(&results, "one gain"), "proved");
    near("plant", &results["simulation"]["x_end"], &[318.449_480_461_173, 0.915_777_042_981_43], 1e-9);
    near("EKF", &last_estimate("cstr", "EKF", &["T", "cA"]), &[318.474_765_739_4, 0.915_933_641_791_3], 1e-8);
    near("RMSE", &rmse(&results, "EKF"), &[0.266_427_643_198_7, 0.026_691_412_231_34], 1e-9);
}

#[test]
fn lorenz() {
    let results = run("lorenz");
    assert_eq!(verdict(&results, "one gain"), "proved");
    // Errors grow by exp(0.9 t): a difference of 1e-9 in the tolerances of the integrators is 1e-5 here.
    near("plant", &results["simulation"]["x_end"], &[8.176_101_747, 12.182_215_561, 19.891_261_669], 1e-7);
    let expected = [8.135_492_688_175, 12.136_111_286_13, 19.929_425_309_99];
    near("EKF", &last_estimate("lorenz", "EKF", &["x", "y", "z"]), &expected, 1e-8);
    near("RMSE", &rmse(&results, "EKF"), &[0.263_387_622_072_2, 0.457_852_386_688_9, 1.747_538_412_081], 1e-9);
}

#[test]
fn induction_motor() {
    let results = run("induction-motor");
    assert_eq!(verdict(&results, "one gain"), "proved");
    let warnings: Vec<&str> = results["warnings"].as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
    assert!(warnings.iter().any(|warning| warning.contains("Guarantee not valid outside the design region: one gain")));
    let expected = [98.430_014_662_687, -0.896_225_355_686, -1.764_520_689_98, -1.633_414_220_76, -5.712_506_118_80];
    near("plant", &results["simulation"]["x_end"], &expected, 1e-9);
    let states = ["omega", "psi_a", "psi_b", "i_a", "i_b"];
    let expected = [98.440_339_023_72, -0.893_579_810_066, -1.765_887_858_272, -1.650_289_094_038, -5.735_484_427_846];
    near("EKF", &last_estimate("induction-motor", "EKF", &states), &expected, 1e-8);
}

#[test]
fn bicycle() {
    let results = run("bicycle");
    // Fourteen entries of its Jacobians vary.
    assert_eq!(verdict(&results, "one gain"), "proved");
    let expected = [
        200.822_032_152_9,
        38.731_005_013_76,
        0.233_346_148_314,
        20.410_252_860_9,
        -0.019_233_458_89,
        0.178_664_499_989,
    ];
    near("plant", &results["simulation"]["x_end"], &expected, 1e-9);
    let states = ["X", "Y", "psi", "vx", "vy", "r"];
    let expected = [
        200.834_438_712_7,
        38.680_076_182,
        0.230_898_443_378,
        20.461_334_079_61,
        -0.020_993_617_638_33,
        0.176_969_702_697_9,
    ];
    near("EKF", &last_estimate("bicycle", "EKF-at-100-Hz", &states), &expected, 1e-8);
}

/// A load step that is an event of the simulated plant, and is estimated.
#[test]
fn cuk_converter() {
    let results = run("cuk");
    let expected = [0.483_937_709_749_816, 20.560_401_638_438_64, -0.583_200_609_075_4, -8.856_228_349_239_448, 64.7];
    near("plant", &results["simulation"]["x_end"], &expected, 1e-9);
    let states = ["i1", "v2", "i3", "v4", "load"];
    let expected = [0.485_051_953_194_4, 20.558_068_755_91, -0.583_795_398_950_1, -8.884_130_756_373, 64.573_525_474_5];
    near("EKF", &last_estimate("cuk", "EKF", &states), &expected, 1e-8);
    let expected =
        [0.020_566_683_545_95, 0.118_744_795_853_3, 0.014_858_529_519_77, 0.487_024_200_462_8, 1.909_466_403_029];
    near("RMSE", &rmse(&results, "EKF"), &expected, 1e-9);
}

/// The Monte-Carlo study of a falling body, with the extended filter that is known to be too sure of itself.
#[test]
fn falling_body() {
    let results = run("re-entry");
    near("plant", &results["simulation"]["x_end"], &[26.732_308_387, 0.104_462_224_084, 1.0], 1e-8);
    let states = ["altitude", "velocity", "ballistic"];
    let expected = [26.712_355_273_84, 0.104_724_086_006_3, 0.997_320_877_837_1];
    near("EKF", &last_estimate("re-entry", "EKF", &states), &expected, 1e-8);
    near("RMSE", &rmse(&results, "EKF"), &[0.166_318_231_701_8, 0.114_481_060_246_8, 0.351_497_869_763_9], 1e-9);
    let nees = &results["filters"][0]["nees"];
    assert_eq!(nees["accepted"], Value::from(false), "{nees}");
    let rows = results["sweep"]["rows"].as_array().unwrap();
    assert!(rows.len() == 3 && rows.iter().all(|row| row["finished"] == 50));
}
