//! `luenberger advise`: which kinds run, with what tuning, and in which order.

use luenberger_study::advise::{Advice, AdviseOptions, Criteria, NotApplicable, advise};
use luenberger_study::{Format, Limits, RunOptions, Step, Study, StudyError, execute};

use crate::studies::{read, scratch, study, study_in};

/// The tanks of the guide, without observers.
const TANKS: &str = r#"
[plant]
states = ["upper", "lower"]
inputs = ["pump"]
outputs = ["level"]
f = ["(pump - k1*sqrt(upper + d))/A", "(k1*sqrt(upper + d) - k2*sqrt(lower + d))/A"]
h = ["lower"]
parameters = { A = 0.5, k1 = 0.2, k2 = 0.15, d = 0.05 }

[input]
expressions = ["0.15 + 0.03*sin(0.3*t)"]

[simulation]
x0 = [0.2, 0.6]
duration = 30
hold = 0.1
noise = { distribution = "gaussian", amplitude = [0.005], period = 0.1, seed = 1 }

[advise]
initial = [1, 0.6]
region = { states = [[0, 2], [0, 2]] }
settling = 20
ensemble = 3
"#;

const INTEGRATOR: &str = "
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[simulation]
x0 = [1, -1]
duration = 10
noise = { distribution = \"gaussian\", amplitude = [0.01], period = 0.1 }
[advise]
ensemble = 3
settling = 3
w = [0, 0.01]
";

#[track_caller]
fn advice(text: &str, options: &AdviseOptions<'_>) -> Advice {
    advise(&study(text), options).unwrap().0
}

fn by(criteria: &str) -> AdviseOptions<'static> {
    AdviseOptions { criteria: Some(criteria.parse().unwrap()), budget: 600.0, ..AdviseOptions::default() }
}

fn names(advice: &Advice) -> Vec<&str> {
    advice.ranking.iter().map(|one| one.name.as_str()).collect()
}

#[test]
fn what_applies_to_a_nonlinear_plant_is_run_and_the_rest_has_its_hypothesis() {
    let advice = advice(TANKS, &by("error"));
    for name in ["lpv", "lipschitz", "extended-kalman"] {
        assert!(names(&advice).contains(&name), "{name} in {:?}", names(&advice));
    }
    let why = |name: &str| {
        let found = advice.not_applicable.iter().find(|kind| kind.name == name);
        found.unwrap_or_else(|| panic!("{name}")).hypothesis.as_str()
    };
    assert!(why("kalman").contains("d(lower')/d(upper) alone goes from 0.143 to 0.516"), "{}", why("kalman"));
    assert!(why("mean-value").contains("level measures lower, not upper"));
    assert_eq!(why("iterated-extended-kalman"), "the outputs are linear in the state: it is extended-kalman");
    assert!(why("kkl-numerical").contains("this plant has 1 input"));
    assert!(
        why("sliding-mode").contains("for a chain of integrators")
            && why("sliding-mode").contains("level is not upper")
    );
    for name in ["interval", "optimal-cubic"] {
        assert_eq!(why(name), why("kalman"));
    }
    assert!(why("unknown-input").contains("0 columns of E"));
    assert!(why("kkl").contains("derived by hand"));
    assert_eq!((advice.runs, advice.ensemble, advice.not_reached.len()), (3, 3, 0));
    // Every number of the information says where it is from.
    assert!(advice.information.iter().all(|item| !item.from.is_empty() && !item.value.is_empty()));
    let settling = advice.information.iter().find(|item| item.what == "settling time").unwrap();
    assert_eq!((settling.value.as_str(), settling.from.as_str()), ("20 to 5 %, decay rate 0.1498", "advise.settling"));
}

/// No gain of 1e-3 moves the double integrator that fast, and without the input of the loop there is no run.
#[test]
fn the_observer_in_the_loop_has_to_have_a_design() {
    let text = format!(
        "{INTEGRATOR}[input]\nfeedback = {{ k = [[4, 4]], observer = \"block\" }}\n\
         [[observer]]\nname = \"block\"\nkind = \"luenberger\"\ndecay_rate = 5\nmax_gain = 1e-3\n"
    );
    let error = advise(&study(&text), &by("error")).unwrap_err();
    assert!(matches!(error, StudyError::Missing { .. }), "{error:?}");
    assert!(error.to_string().contains("a design of the observer in the feedback loop"), "{error}");
}

/// The study that is written is the one that was run: its scores in run 0 are those of `compare`.
#[test]
fn the_written_study_has_the_observers_that_were_run() {
    let folder = scratch("advise-written");
    // Advice has a budget; the limits of a run are none of it.
    let limits = Limits { seconds: 1e-9, ..Limits::default() };
    let run = RunOptions { output: Some(folder.clone().into()), limits, ..RunOptions::default() };
    let advice = advice(TANKS, &AdviseOptions { run, ..by("error") });
    assert!(!advice.recommended.is_empty());
    let whole = advice.ranking.iter().filter(|one| one.finished == advice.runs);
    let peaks: Vec<_> = whole.filter_map(|one| Some((one, one.medians.peak?, one.medians.rms?))).collect();
    let front: Vec<String> = peaks
        .iter()
        .filter(|(_, a, b)| !peaks.iter().any(|(_, c, d)| c <= a && d <= b && (c < a || d < b)))
        .map(|(one, ..)| one.name.clone())
        .collect();
    assert!(!front.is_empty());
    assert_eq!(advice.pareto_peak, front);
    let written = Study::from_path(&folder.join("study.toml")).unwrap();
    let results = execute(&written, Step::Compare, &RunOptions::default()).unwrap();
    let runs = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    for name in &advice.recommended {
        let row = results.simulation.as_ref().unwrap().rows.iter().find(|row| row.observer == *name).unwrap();
        // The norm of `compare` is in units of the region too, where a design has one.
        let states = &row.merits.as_ref().unwrap().states;
        let rms = states.iter().map(|state| (state.rmse / 2.0).powi(2)).sum::<f64>().sqrt();
        let line = runs.lines().find(|line| line.starts_with(&format!("\"{name}\",0,"))).unwrap();
        let own: f64 = line.split(',').nth(2).unwrap().parse().unwrap();
        assert!((own - rms).abs() <= 1e-9 * rms, "{name}: {own}, {rms}");
    }
    for file in ["advice.json", "runs.csv", "study.toml", "figures/advise-pareto.svg", "manifest.json"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
}

/// scipy 1.17 and numpy on the noise of run 0, which is that of a ChaCha8 in Python: plant, mean and covariance of the
/// extended Kalman filter by `solve_ivp` (DOP853, rtol 1e-12) from one sample to the next, Joseph's update; norm in
/// units of 2 m, scored at the 301 samples before their measurement is used. rms 0.0334512211, settling time 0.8,
/// second half 0.000489402349. The filter takes four Runge-Kutta steps for each sample, which explains the tolerance:
/// with them numpy has 0.03345128411366, 0.8 and 0.00048940389917.
#[test]
fn the_scores_of_a_filter_are_those_of_scipy() {
    let folder = scratch("advise-scipy");
    let run = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let text = format!(
        "{}w = [8e-7, 8e-7]\n",
        TANKS.replace("ensemble = 3", "ensemble = 1").replace("hold = 0.1", "hold = 0.1\nestimates = \"predicted\"")
    );
    advice(&text, &AdviseOptions { run, ..by("error") });
    let runs = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    let line = runs.lines().find(|line| line.starts_with("\"extended-kalman\",0,")).unwrap();
    let scores: Vec<f64> = line.split(',').skip(2).take(4).map(|cell| cell.parse().unwrap()).collect();
    for (score, expected) in scores.iter().zip([0.033_451_221_1, 0.8, 1.0, 0.000_489_402_349]) {
        assert!((score - expected).abs() <= 5e-6 * expected, "{score}, expected {expected}");
    }
}

/// scipy 1.17: the Kalman gain of the double integrator with W = diag(0, 0.01) and the intensity V = 0.01^2 0.1 = 1e-5
/// of the held noise is [7.952707, 31.622777] (`solve_continuous_are`), and the noise gain sqrt(trace X) of F X + X F'
/// + L L' = 0 is 8.2967585 (`solve_continuous_lyapunov`).
#[test]
fn a_linear_plant_gets_the_gains_of_the_textbook() {
    let advice = advice(INTEGRATOR, &by("error"));
    for name in [
        "luenberger",
        "luenberger-lmi",
        "kalman",
        "cubic",
        "optimal-cubic",
        "interval",
        "sliding-mode",
        "sampled-cubic",
        "high-gain",
        "extended-kalman",
    ] {
        assert!(names(&advice).contains(&name), "{name} in {:?}", names(&advice));
    }
    let kalman = advice.ranking.iter().find(|one| one.name == "kalman").unwrap();
    // Without a bound of its gain the H2 filter is the Kalman filter: one filter in two rows, which say so.
    let same = |name: &str| advice.ranking.iter().find(|one| one.name == name).unwrap().same_as.as_deref();
    assert_eq!((same("kalman"), same("h2"), same("luenberger")), (None, Some("kalman"), None));
    let said = advice.explanation.iter().filter(|text| text.contains("is the same observer as")).count();
    let explained = advice.ranking.iter().take(6).filter(|one| ["kalman", "h2"].contains(&one.name.as_str())).count();
    assert_eq!(said, usize::from(explained == 2), "{:?}", advice.explanation);
    let gain = kalman.noise_gain.unwrap();
    assert!((gain - 8.296_758_5).abs() < 1e-6, "{gain}");
    assert_eq!(advice.observability, None);
}

#[test]
fn the_order_is_that_of_the_criterion() {
    for (criterion, of) in [
        ("error", (|one| one.medians.rms) as fn(&luenberger_study::advise::RankedObserver) -> Option<f64>),
        ("noise", |one| one.medians.steady_rms),
        ("cost", |one| one.operations.map(|count| count as f64)),
        ("peak", |one| one.medians.peak),
    ] {
        let advice = advice(PENDULUM, &by(criterion));
        let values: Vec<f64> = advice.ranking.iter().map(|one| of(one).unwrap_or(f64::INFINITY)).collect();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-9)), "{criterion}: {values:?}");
        assert!(advice.explanation[0].starts_with(&format!("1. {}", advice.ranking[0].name)));
    }
    let advice = advice(PENDULUM, &by("proved"));
    let verdicts: Vec<bool> = advice.ranking.iter().map(|one| one.verdict.word() == "proved").collect();
    assert!(verdicts[0] && verdicts.windows(2).all(|pair| pair[0] >= pair[1]), "{verdicts:?}");
    let best = format!("1. {} has a proof, and the least rms |e| of those that have one.", advice.ranking[0].name);
    assert!(advice.explanation[0].starts_with(&best), "{}", advice.explanation[0]);
}

/// The scores of the runs of an observer in `runs.csv`: rms and that of the second half.
fn runs(text: &str, observer: &str) -> (Vec<f64>, Vec<f64>) {
    let lines = text.lines().filter(|line| line.starts_with(&format!("\"{observer}\",")));
    let cells = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[2].parse::<f64>().unwrap(), cells[5].parse::<f64>().unwrap())
    });
    cells.unzip()
}

/// What is said of runs, computed anew from the table of the runs: 5th and 95th percentile by nearest rank, which of 21
/// are the second and the last but one, and the root mean squares of both halves. The mean square of a run is the mean
/// of those of its halves.
#[test]
fn what_is_said_of_the_runs_is_in_their_table() {
    let folder = scratch("advise-runs");
    let run = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
    let text = "[plant]\na = [[-1]]\nc = [[1]]\n[simulation]\nx0 = [1]\nduration = 2\n\
                noise = { distribution = \"gaussian\", amplitude = [0.1], period = 0.1 }\n\
                [advise]\ninitial = [0.5]\nw = 0.01\nensemble = 21\nregion = { states = [[-2, 2]] }\n";
    let advice = advice(text, &AdviseOptions { run, ..by("error") });
    let table = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    let rms = |squares: &[f64]| (squares.iter().map(|x| x * x).sum::<f64>() / squares.len() as f64).sqrt();
    let halves = |name: &str| {
        let (all, late) = runs(&table, name);
        ((2.0 * rms(&all).powi(2) - rms(&late).powi(2)).sqrt(), rms(&late))
    };
    for one in &advice.ranking {
        let (mut all, _) = runs(&table, &one.name);
        all.sort_by(f64::total_cmp);
        assert_eq!(all.len(), 21, "{}", one.name);
        assert_eq!(one.medians.rms_range, [Some(all[1]), Some(all[19])], "{}", one.name);
        assert_eq!(one.medians.rms, Some(all[10]), "{}", one.name);
    }
    let best = &advice.ranking[0].name;
    let (early, late) = halves(best);
    let mut compared = 0;
    for (rank, other) in advice.ranking.iter().enumerate().skip(1) {
        let start = format!("{}. {}: ", rank + 1, other.name);
        let Some(said) = advice.explanation.iter().find(|sentence| sentence.starts_with(&start)) else { continue };
        let (before, rest) = said.split_once(&format!(" times that of {best} in the first half of the run, ")).unwrap();
        let of = |text: &str, at: usize| text.split(' ').nth(at).unwrap().parse::<f64>().unwrap();
        let found = [before.rsplit(' ').next().unwrap().parse::<f64>().unwrap(), of(rest, 0)];
        let (first, second) = halves(&other.name);
        for (found, expected) in found.into_iter().zip([first / early, second / late]) {
            // Three digits.
            assert!((found - expected).abs() <= 5.1e-3 * expected, "{found}, expected {expected} in {said}");
        }
        compared += 1;
    }
    assert!(compared >= 3, "{:?}", advice.explanation);
}

/// The score that is said is the product of the ratios that are said with it, raised to their weights; an observer
/// without a proof counts ten times. Settling times are those of the medians.
#[test]
fn what_is_said_of_scores_is_the_ranking() {
    let text = SCALAR.replace("dt = 0.5\n", "dt = 0.5\ntime_unit = \"s\"\n");
    let advice = advice(&text, &by("error=2,cost=1,proved=1"));
    let whole = || advice.ranking.iter().filter(|one| one.finished == advice.runs);
    let least = whole().filter_map(|one| one.medians.rms).fold(f64::INFINITY, f64::min);
    let fewest = whole().filter_map(|one| one.operations).min().unwrap() as f64;
    let mut said = 0;
    for (rank, one) in advice.ranking.iter().enumerate() {
        let start = format!("{}. {}", rank + 1, one.name);
        let Some(text) = advice.explanation.iter().find(|text| text.starts_with(&start) && text.contains("(error "))
        else {
            continue;
        };
        let of = |name: &str| {
            let (_, rest) = text.split_once(&format!("({name} ")).unwrap_or_else(|| panic!("{name}: {text}"));
            let (ratio, power) = rest.split_once(")^").unwrap();
            let power: String = power.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
            (ratio.parse::<f64>().unwrap(), power.trim_end_matches('.').parse::<f64>().unwrap())
        };
        let ratios = [("error", 0.5), ("cost", 0.25), ("proved", 0.25)].map(|(name, power)| (of(name).0, power));
        let proof = if one.verdict.word() == "proved" { 1.0 } else { 10.0 };
        let expected = [one.medians.rms.unwrap() / least, one.operations.unwrap() as f64 / fewest, proof];
        for ((found, _), expected) in ratios.iter().zip(expected) {
            assert!((found - expected).abs() <= 5.1e-3 * expected, "{found}, expected {expected}: {text}");
        }
        let product: f64 = expected.iter().zip([0.5, 0.25, 0.25]).map(|(ratio, power)| ratio.powf(power)).product();
        let score = one.score.unwrap();
        assert!((score - product).abs() <= 1e-9 * product, "{score}, {product}: {text}");
        assert!(of("error").1 == 0.5 && of("cost").1 == 0.25, "{text}");
        if rank > 0 {
            let settles = |time: Option<f64>| match time {
                Some(time) => format!("settles in {} s", luenberger_proof::wording::significant(time, 3)),
                None => "does not settle in most runs".to_owned(),
            };
            let (own, best) = (settles(one.medians.settling), settles(advice.ranking[0].medians.settling));
            let expected = format!(" It {own}; {} {best}.", advice.ranking[0].name);
            assert!(text.contains(&expected), "{expected} in {text}");
        }
        said += 1;
    }
    assert!(said >= 3, "{:?}", advice.explanation);
    // The proof of the first, or the first that has one.
    let first = &advice.ranking[0];
    let proof = format!("{} is proved: {}.", first.name, first.statement.trim_end_matches('.'));
    assert_eq!(first.verdict.word(), "proved");
    assert!(advice.explanation.contains(&proof), "{proof} in {:?}", advice.explanation);
}

/// A proof as the criterion: the first has one and the least error of those that have one, and of each other it is said
/// whether it has one, with its error. Six are explained. The cost of a step is said of the first, and of the cheapest.
#[test]
fn proofs_and_costs_are_said_in_words() {
    let significant = |x: f64| luenberger_proof::wording::significant(x, 3);
    for criteria in ["proved", "error", "cost"] {
        let advice = advice(SCALAR, &by(criteria));
        let (first, all) = (&advice.ranking[0], &advice.explanation);
        let said = |rank: usize, name: &str| {
            all.iter()
                .find(|text| text.starts_with(&format!("{}. {name}", rank + 1)))
                .unwrap_or_else(|| panic!("{all:?}"))
        };
        let numbered = |text: &&String| text.split_once(". ").is_some_and(|(rank, _)| rank.parse::<usize>().is_ok());
        assert_eq!(all.iter().filter(numbered).count(), 6.min(advice.ranking.len()));
        if criteria == "proved" {
            let start = format!("1. {} has a proof, and the least rms |e| of those that have one. ", first.name);
            assert!(said(0, &first.name).starts_with(&start), "{all:?}");
            for (rank, other) in advice.ranking.iter().enumerate().take(6).skip(1) {
                if said(rank, &other.name).contains("is the same observer as") {
                    continue;
                }
                let of = significant(other.medians.rms.unwrap() / first.medians.rms.unwrap());
                let expected = if other.verdict.word() == "proved" {
                    format!("{} has a proof too, and {of} times the rms |e| of {}.", other.name, first.name)
                } else {
                    format!("{} has no proof.", other.name)
                };
                assert!(said(rank, &other.name).contains(&expected), "{expected} in {all:?}");
            }
        }
        let complete = || advice.ranking.iter().filter(|one| one.finished == advice.runs && one.operations.is_some());
        let least = complete().filter_map(|one| one.operations).min().unwrap();
        let cheapest = complete().find(|one| one.operations == Some(least)).unwrap();
        let rest = if cheapest.name == first.name {
            ", the fewest of all".to_owned()
        } else {
            let price = significant(cheapest.medians.rms.unwrap() / first.medians.rms.unwrap());
            format!("; the fewest are {least}, of {}, with {price} times the rms |e|", cheapest.name)
        };
        let cost = format!("{} floating-point operations on the target{rest}.", first.operations.unwrap());
        assert!(
            all.iter()
                .any(|text| text.starts_with(&format!("A step of {} takes ", first.name)) && text.ends_with(&cost)),
            "{cost} in {all:?}"
        );
    }
}

/// A kind without a rule is ranked where the study has an observer of it, and is named with the reason where not.
#[test]
fn kinds_without_a_rule_are_ranked_if_the_study_has_one() {
    let particle =
        "[[observer]]\nname = \"own\"\nkind = \"particle\"\nw = 0.1\nv = 0.01\nperiod = 0.5\nparticles = 50\n";
    let unfit =
        |advice: &Advice| -> Vec<String> { advice.not_applicable.iter().map(|kind| kind.name.clone()).collect() };
    let without = advice(SCALAR, &by("error"));
    let with = advice(&(SCALAR.to_owned() + particle), &by("error"));
    assert!(unfit(&without).contains(&"particle".to_owned()) && unfit(&without).contains(&"imm".to_owned()));
    assert!(!unfit(&with).contains(&"particle".to_owned()) && unfit(&with).contains(&"imm".to_owned()));
    assert!(names(&with).contains(&"own"), "{:?}", names(&with));
}

/// An observer of the study that has the name of a rule is not confused with it.
#[test]
fn a_rule_and_an_observer_of_one_name_are_told_apart() {
    let own = "[[observer]]\nname = \"luenberger\"\nkind = \"luenberger\"\ngain = [[-100]]\n";
    let advice = advice(&(SCALAR.to_owned() + own), &by("error"));
    let unfit: Vec<&str> = advice.not_applicable.iter().map(|kind| kind.name.as_str()).collect();
    assert!(unfit.contains(&"luenberger of the study") && !unfit.contains(&"luenberger"), "{unfit:?}");
}

/// Gains that differ by less than a thousandth, entry by entry, are one observer; the later names the first.
#[test]
fn gains_of_three_equal_digits_are_one_observer() {
    let own =
        |name: &str, gain: f64| format!("[[observer]]\nname = \"{name}\"\nkind = \"luenberger\"\ngain = [[{gain}]]\n");
    let observers = own("first", 0.5) + &own("near", 0.5004) + &own("far", 0.5006) + &own("other", 0.51);
    let advice = advice(&(SCALAR.to_owned() + &observers), &by("error"));
    let same: Vec<_> = ["first", "near", "far", "other"]
        .iter()
        .map(|name| advice.ranking.iter().find(|one| one.name == *name).unwrap().same_as.as_deref())
        .collect();
    assert_eq!(same, [None, Some("first"), None, None]);
}

/// An interruption after the first run leaves the ranking of that run, and says so.
#[test]
fn an_interruption_leaves_the_runs_that_all_have() {
    let cancel = std::sync::atomic::AtomicBool::new(false);
    let progress = |progress: luenberger_study::Progress<'_>| {
        if progress.stage == "simulate" {
            cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    };
    let run = RunOptions { cancel: &cancel, progress: &progress, ..RunOptions::default() };
    let text = SCALAR.replace("ensemble = 1", "ensemble = 3");
    let (advice, interrupted) = advise(&study(&text), &AdviseOptions { run, ..by("error") }).unwrap();
    assert!(matches!(interrupted, Some(StudyError::Interrupted)));
    assert_eq!((advice.runs, advice.ensemble), (1, 3));
    assert!(advice.ranking.iter().any(|one| one.finished == 1));
    let open = "runs 2 to 3 of 3: the ranking is of the first 1 run";
    assert!(advice.not_reached.iter().any(|left| left == open), "{:?}", advice.not_reached);
}

/// The first two are called as good as each other where their scores differ by less than 5 %, and only there.
#[test]
fn a_tie_is_a_difference_below_five_percent() {
    let mut found = [0, 0, 0];
    for criteria in ["error", "error=4,cost=1"] {
        let advice = advice(SCALAR, &by(criteria));
        let scores: Vec<f64> = advice.ranking.iter().map(|one| one.score.unwrap()).take(2).collect();
        let said = advice.explanation.iter().any(|sentence| sentence.contains("differ by less than 5 %"));
        let ratio = scores[1] / scores[0];
        assert_eq!(said, ratio < 1.05, "{criteria}: {scores:?} {:?}", advice.explanation);
        found[if ratio < 1.05 {
            0
        } else if ratio < 1.5 {
            1
        } else {
            2
        }] += 1;
    }
    assert!(found[0] > 0 && found[1] > 0, "{found:?}");
}

/// x+ = 0.9 x + w, every half of a unit.
const SCALAR: &str = "
[plant]
a = [[0.9]]
c = [[1]]
dt = 0.5
[simulation]
x0 = [1]
duration = 10
noise = { distribution = \"gaussian\", amplitude = [0.1], period = 0.5 }
[advise]
w = 0.2
ensemble = 1
";

/// The numbers of a key of an observer in the study that is written.
fn written(advice: &Advice, observer: &str, key: &str) -> Vec<f64> {
    let block = advice.study.split("[[observer]]").find(|block| block.contains(&format!("name = \"{observer}\"")));
    let block = block.unwrap_or_else(|| panic!("{observer} in {}", advice.study));
    let value = block.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = ")).unwrap();
    value.trim_matches(['[', ']']).split(", ").map(|x| x.parse().unwrap()).collect()
}

/// The normalised cubic term of one state adds `gamma y~'theta y~` to L = a - pole. At an output error of one standard
/// deviation, 0.1, the product with theta is 1, and gamma is an eighth of L.
#[test]
fn the_cubic_term_adds_an_eighth_at_one_standard_deviation() {
    let advice = advice(SCALAR, &by("error"));
    let number = |key: &str| written(&advice, "sampled-cubic", key)[0];
    assert!((number("theta") * 0.1 * 0.1 - 1.0).abs() < 1e-3);
    let share = number("gamma") / (0.9 - number("poles"));
    // Numbers are written with four digits.
    assert!((share - 0.125).abs() < 1e-4, "{share}");
}

/// The covariance of the process noise of a sample is the intensity 0.2 times the period 0.5.
#[test]
fn the_process_noise_of_a_sample_is_intensity_times_period() {
    let advice = advice(SCALAR, &by("error"));
    assert_eq!(written(&advice, "extended-kalman", "w"), [0.1]);
}

/// Where an output has a curvature, an iterated filter has the covariances of the extended one: of noise with the
/// deviation 0.05, and of a first error of a quarter of the region.
#[test]
fn an_iterated_filter_is_for_outputs_that_are_not_linear() {
    let ranged = "[plant]\nf = [\"-0.1*x1\"]\nh = [\"sqrt(1 + x1^2)\"]\n[simulation]\nx0 = [2]\nduration = 2\n\
                  noise = { amplitude = [0.05], period = 0.1 }\n[advise]\ninitial = [1]\nensemble = 1\n";
    let advice = advice(ranged, &by("error"));
    for (key, expected) in [("v", 0.05 * 0.05), ("p0", 0.25)] {
        assert!((written(&advice, "iterated-extended-kalman", key)[0] - expected).abs() < 1e-12, "{key}");
    }
    let rms = |name: &str| advice.ranking.iter().find(|one| one.name == name).unwrap().medians.rms.unwrap();
    assert!(rms("iterated-extended-kalman") < rms("extended-kalman"), "{}", advice.study);
}

/// A pendulum whose acceleration differs by at most 2 9.81 + 0.2 24 = 24.42 over its region, under one torque.
const PENDULUM: &str = r#"
[plant]
f = ["x2", "-9.81*sin(x1) - 0.2*x2 + u1"]
h = ["x1"]
inputs = ["u1"]
[input]
expressions = ["2*sin(0.7*t)"]
[simulation]
x0 = [1, 0]
duration = 3
noise = { amplitude = [0.001], period = 0.01 }
[advise]
region = { states = [[-4, 4], [-12, 12]] }
ensemble = 1
"#;

/// The bound D of a sliding-mode observer, as its statement has it.
fn bound(text: &str) -> f64 {
    let advice = advice(text, &by("error"));
    let statement = &advice.ranking.iter().find(|one| one.kind == "sliding-mode").unwrap().statement;
    statement.split_once("for every disturbance up to ").unwrap().1.split(' ').next().unwrap().parse().unwrap()
}

/// What f differs by over the region, what a disturbance adds, or what the settling time asks for.
#[test]
fn the_bound_of_a_sliding_mode_is_that_of_region_disturbance_and_settling_time() {
    let of_region = bound(PENDULUM);
    assert!((24.3..=24.42).contains(&of_region), "{of_region}");
    let with = bound(&format!("{PENDULUM}e = [[0], [2]]\ndisturbance = [1.5]\n"));
    assert!((with - of_region - 3.0).abs() < 1e-3, "{with}");
    // The standard deviation 24/4 of the first speed, in a tenth of a second.
    assert!((bound(&format!("{PENDULUM}settling = 0.1\n")) - 60.0).abs() < 1e-9);
    // Without gravity at the start: at t = 1.5 it is 0.9975 of all.
    let later = bound(&PENDULUM.replace("sin(x1)", "sin(t)*sin(x1)"));
    assert!((24.3..=24.42).contains(&later), "{later}");
}

/// Half-widths in the end under noise of four standard deviations and a bounded inflow, numpy 2.4: the poles are those
/// of the Bessel filter of order 2 that settles in 2.5, -1.311 +- 0.757i, and with the eigenvectors V of F = A - L C
/// the half-widths are |V| (-diag(Re lambda))^-1 (|V^-1 E| 0.01 + |V^-1 L| 0.02) = (0.27201, 0.040456).
#[test]
fn an_interval_observer_is_told_the_bounds() {
    let text = "
[plant]
a = [[-0.2, 0], [0.2, -0.2]]
c = [[0, 1]]
[simulation]
x0 = [0.1, 0]
duration = 10
noise = { distribution = \"gaussian\", amplitude = [0.005], period = 0.1 }
[advise]
ensemble = 1
e = [[2], [0]]
disturbance = [0.01]
";
    let advice = advice(text, &by("error"));
    let item = advice.information.iter().find(|item| item.what == "bounds of the disturbance").unwrap();
    assert_eq!((item.value.as_str(), item.from.as_str()), ("|w| <= (0.01)", "advise.disturbance"));
    let interval = advice.ranking.iter().find(|one| one.kind == "interval").unwrap();
    assert_eq!(interval.verdict.word(), "proved");
    assert!(names(&advice).contains(&"optimal-cubic"), "{:?}", names(&advice));
    assert!(interval.statement.contains("approach x1 0.272, x2 0.04046,"), "{}", interval.statement);
}

/// Results depend neither on the number of threads nor on the machine's load.
#[test]
fn the_same_study_gives_the_same_ranking() {
    let with = |threads| {
        let run = RunOptions { threads: Some(threads), ..RunOptions::default() };
        advice(PENDULUM, &AdviseOptions { run, ..by("error=2,cost=1") })
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn what_the_budget_does_not_reach_is_listed() {
    let advice = advice(TANKS, &AdviseOptions { budget: 1e-9, ..by("error") });
    assert!(advice.ranking.is_empty() && advice.explanation.is_empty());
    assert!(!advice.not_reached.is_empty());
}

/// A single design of twenty states takes minutes: it is stopped, and so is the design of a sampled step.
#[test]
fn a_single_design_stops_at_the_budget() {
    let rod = luenberger_study::template::text("heat-rod").unwrap();
    let start = std::time::Instant::now();
    let advice = advice(rod, &AdviseOptions { budget: 5.0, ..by("error") });
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 60.0, "{seconds} s");
    let late: Vec<&str> = advice.not_reached.iter().map(String::as_str).collect();
    assert!(late.iter().any(|open| open.ends_with("within half of the budget")), "{late:?}");
}

#[test]
fn without_noise_or_simulation_there_is_no_comparison() {
    let needs = |text: &str| match advise(&study(text), &AdviseOptions::default()).unwrap_err() {
        StudyError::Missing { step, needs } => (step, needs),
        other => panic!("{other}"),
    };
    let quiet: String = TANKS.lines().filter(|line| !line.starts_with("noise")).flat_map(|line| [line, "\n"]).collect();
    assert!(needs(&quiet).1.starts_with("measurement noise"));
    let (step, why) = needs("[plant]\na = [[-1]]\nc = [[1]]\n");
    assert!(step == "advise" && why.starts_with("a [simulation]"), "{why}");
}

/// Where the observers run, or what is missing, for each simulation (none, without noise, with it), log (none, without
/// true states, with them) and criteria. Where they run is told by the criterion that holds where none is given, and
/// by true states, which a log needs to rank by error.
#[test]
fn a_criterion_needs_the_simulation_or_the_log_that_it_is_of() {
    let folder = scratch("advise-ground");
    let rows: Vec<String> = (0..100).map(|k| format!("{k},{0},{0}\n", (-0.1 * f64::from(k)).exp())).collect();
    std::fs::write(folder.join("log.csv"), format!("t,y,x\n{}", rows.concat())).unwrap();
    let plant = "[plant]\na = [[-1]]\nc = [[1]]\n[advise]\nensemble = 1\nregion = { states = [[-2, 2]] }\n";
    let quiet = "[simulation]\nx0 = [1]\nduration = 3\n";
    let noisy = &format!("{quiet}noise = {{ distribution = \"gaussian\", amplitude = [0.01], period = 0.1 }}\n");
    let log = "[log]\nfile = \"log.csv\"\noutputs = [\"y\"]\n";
    let truth = &format!("{log}states = [\"x\"]\n");
    let grounds = |simulation: &str, log: &str, criteria: &str| {
        let study = study_in(&folder, &format!("{plant}{simulation}{log}"));
        let criteria = (!criteria.is_empty()).then(|| criteria.parse().unwrap());
        match advise(&study, &AdviseOptions { criteria, budget: 1e-9, ..AdviseOptions::default() }) {
            Ok((advice, _)) => advice.criteria.0.iter().map(|(criterion, _)| criterion.name()).collect(),
            Err(StudyError::Missing { needs, .. }) => needs.to_owned(),
            Err(other) => panic!("{other}"),
        }
    };
    let states = "columns of true states (`states` in [log]) to rank by error";
    let true_state = "a [simulation] to rank by noise, peak or settling, which need the true state";
    let noise = "measurement noise (simulation.noise, or sensors with an amplitude), without which the fastest observer is the best";
    let one_kind = "criteria of one kind (noise, peak and settling are those of a simulation, innovations and likelihood of a log)";
    for (simulation, log, criteria, expected) in [
        ("", "", "", "a [simulation] with measurement noise, or a [log]"),
        ("", "", "innovations", "a [simulation] with measurement noise, or a [log]"),
        ("", log, "", "innovations"),
        ("", log, "error", states),
        ("", truth, "error", "error"),
        ("", log, "settling", true_state),
        ("", truth, "innovations=1,peak=1", true_state),
        (quiet, "", "", noise),
        (quiet, "", "likelihood", "a [log] to rank by innovations or likelihood"),
        (quiet, log, "", "innovations"),
        (quiet, log, "error", states),
        (quiet, truth, "error", "error"),
        (quiet, truth, "noise", noise),
        (quiet, truth, "likelihood", "likelihood"),
        (quiet, truth, "likelihood=1,noise=1", one_kind),
        (noisy, "", "", "error"),
        (noisy, "", "innovations", "a [log] to rank by innovations or likelihood"),
        (noisy, log, "", "error"),
        (noisy, log, "error", "error"),
        (noisy, log, "peak", "peak"),
        (noisy, log, "innovations", "innovations"),
        (noisy, log, "innovations=1,error=1", states),
        (noisy, log, "innovations=1,peak=1", one_kind),
    ] {
        let found = grounds(simulation, log, criteria);
        assert_eq!(found, expected, "{simulation:?}, {log:?}, {criteria:?}");
    }
}

#[test]
fn no_observer_of_an_undetectable_plant_is_tried() {
    let advice = advice(&INTEGRATOR.replace("c = [[1, 0]]", "c = [[0, 1]]"), &by("error"));
    assert!(advice.ranking.is_empty());
    let why = advice.observability.unwrap();
    assert!(
        why.starts_with("rank 1 of 2, unobservable modes at 0 along x1:") && why.contains("not detectable"),
        "{why}"
    );
    // Each mode with its direction.
    let two = "[plant]\na = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]\nc = [[0, 0, 1]]\n";
    let (_, rest) = INTEGRATOR.split_once("[simulation]\nx0 = [1, -1]").unwrap();
    let text = format!("{two}[simulation]\nx0 = [1, -1, 0]{}", rest.replace("w = [0, 0.01]", "w = [0, 0, 0.01]"));
    let why = self::advice(&text, &by("error")).observability.unwrap();
    let [one, other] = ["1 along x1", "2 along x2"];
    let (a, b) = (
        format!("rank 1 of 3, unobservable modes at {one}, {other}:"),
        format!("rank 1 of 3, unobservable modes at {other}, {one}:"),
    );
    assert!(why.starts_with(&a) || why.starts_with(&b), "{why}");
}

#[test]
fn a_hidden_mode_that_decays_is_named() {
    let above = TANKS.replace("h = [\"lower\"]", "h = [\"upper\"]");
    let advice = advice(&above, &by("error"));
    let why = advice.observability.unwrap();
    assert!(why.contains("along lower") && why.contains("whatever the observer"), "{why}");
    assert!(!advice.ranking.is_empty());
}

#[test]
fn bad_values_of_the_table_are_reported_at_their_lines() {
    let wrong = |line: &str, message: &str| {
        let text = format!("{INTEGRATOR}{line}\n");
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(message), "{line}: {error}");
    };
    wrong("initial = [1]", "`initial` has length 1");
    wrong("period = 0", "`period` is 0");
    wrong("e = [[1]]", "`e` is 1 x 1");
    wrong("disturbance = [1]", "`disturbance` without `e`");
    wrong("e = [[0], [1]]\ndisturbance = [1, 2]", "`disturbance` has length 2, and `e` has 1 column");
    wrong("e = [[0], [1]]\ndisturbance = [-1]", "`disturbance` ");
    wrong("region = { states = [[0, 1]] }", "`states` has 1 pair");
    wrong("region = { states = [[2, 3], [-2, 2]] }", "x0 is 1");
    wrong("region = { states = [[-inf, 3], [-2, 2]] }", "x1 from -inf to 3");
    wrong("setling = 3", "the nearest key is `settling`");
    assert!("error,speed".parse::<Criteria>().unwrap_err().contains("\"speed\""));
}

/// What is recommended stands behind the observers of the study, however they are written.
#[test]
fn observers_are_added_to_every_form_of_study() {
    let rest = "[plant]\na = [[-1]]\nc = [[1]]\n[simulation]\nx0 = [1]\nduration = 2\n\
                noise = { amplitude = [0.01], period = 0.1 }\n[advise]\ninitial = [0.5]\nensemble = 1\n";
    let own = "name = \"my \\\"own\\\"\", kind = \"luenberger\", poles = [-2]";
    let json = r#"{"plant": {"a": [[-1]], "c": [[1]]}, "simulation": {"x0": [1], "duration": 2,
        "noise": {"amplitude": [0.01], "period": 0.1}}, "advise": {"initial": [0.5], "ensemble": 1}}"#;
    let with_own = json.replacen('{', r#"{"observer": [{"kind": "luenberger", "poles": [-2]}], "#, 1);
    let studies = [
        (rest.to_owned(), Format::Toml, 0),
        (format!("{rest}\n[[observer]]\n{}\n", own.replace(", ", "\n")), Format::Toml, 1),
        (format!("observer = [ {{ {own} }}, # the first\n]\n{rest}"), Format::Toml, 1),
        (format!("observer = [{{ {own} }}]\n{rest}"), Format::Toml, 1),
        (json.to_owned(), Format::Json, 0),
        (with_own, Format::Json, 1),
    ];
    for (text, format, own) in studies {
        let read = |text: &str| Study::from_text("s", text, format, ".".as_ref());
        let (advice, _) = advise(&read(&text).unwrap(), &AdviseOptions { own_tuning: false, ..by("error") }).unwrap();
        let more = read(&advice.study).unwrap_or_else(|error| panic!("{}\n{error}", advice.study));
        assert!(!advice.recommended.is_empty());
        assert_eq!(more.observers.len(), own + advice.recommended.len(), "{}", advice.study);
        for name in &advice.recommended {
            let ranked = advice.ranking.iter().find(|one| one.name == *name).unwrap();
            let added = more.observer(name).unwrap();
            assert_eq!((added.kind.name(), added.initial.as_slice()), (ranked.kind.as_str(), [0.5].as_slice()));
        }
    }
}

/// The document of an advice has every number of the ranking in its table, the best of each column marked, and says
/// what is compared.
#[test]
fn an_advice_is_a_document() {
    use luenberger_proof::wording::significant;
    let mut advice = advice(&INTEGRATOR.replace("ensemble = 3", "ensemble = 1"), &by("error=2,proved=1"));
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let digits = |x: Option<f64>, missing: &str| x.map_or_else(|| missing.to_owned(), |x| significant(x, 4));
    let markdown = advice.markdown("10 min");
    let least = advice.ranking.iter().filter(|one| one.finished == 1).filter_map(|one| one.medians.rms);
    let least = least.fold(f64::INFINITY, f64::min);
    for one in &advice.ranking {
        let rows = || markdown.lines().filter(|line| line.starts_with(&format!("| {} |", one.name)));
        let row = rows().find(|line| line.contains(" of 1 |")).unwrap_or_else(|| panic!("{}: {markdown}", one.name));
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let expected = [
            one.name.clone(),
            digits(one.score, "-"),
            digits(one.medians.rms, "-"),
            digits(one.medians.settling, "never"),
            digits(one.medians.peak, "-"),
            digits(one.medians.steady_rms, "-"),
            digits(one.noise_gain, "-"),
            one.operations.map_or_else(|| "-".to_owned(), |count| count.to_string()),
            one.verdict.word().to_owned(),
            format!("{} of 1", one.finished),
        ];
        assert_eq!(cells.iter().map(|cell| cell.trim_matches('*')).collect::<Vec<_>>(), expected);
        assert_eq!(cells[2].contains("**"), one.medians.rms == Some(least) && one.finished == 1, "{row}");
    }
    let text = plain(&advice.text("10 min"));
    assert!(text.contains("Ranking by error=2,proved=1: one run"), "{text}");
    let all = "The best values are marked. The score is the weighted geometric mean of the values relative to the best \
               ones. A missing proof counts as a factor of 10.";
    assert!(text.contains(all), "{text}");
    assert!(advice.explanation.iter().all(|sentence| text.contains(&plain(sentence))), "{text}");
    // What other advice would say.
    (advice.runs, advice.criteria) = (3, "error".parse().unwrap());
    (advice.pareto_cost, advice.pareto_peak) = (vec!["a".to_owned(), "b".to_owned()], vec!["c".to_owned()]);
    advice.not_reached = vec!["what is left".to_owned()];
    let not = |name: &str, why: &str| NotApplicable { name: name.to_owned(), hypothesis: why.to_owned() };
    advice.not_applicable = vec![not("d", "first"), not("e", "second"), not("f", "first")];
    let text = plain(&advice.text("10 min"));
    for part in [
        "Ranking by error: medians of 3 runs",
        "The best values are marked.",
        "No other is better in both rms |e| and operations than a, b.",
        "d, f: first",
        "e: second",
        "Not reached within the budget of 10 min",
        "what is left",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("peak |e| than c") && !text.contains("The score is") && !text.contains("A missing proof"));
    // A single criterion has no score beside its values.
    let head = advice
        .markdown("10 min")
        .lines()
        .find(|line| line.starts_with("| observer | ") && line.contains("rms"))
        .unwrap()
        .to_owned();
    assert!(head.starts_with("| observer | rms "), "{head}");
}
