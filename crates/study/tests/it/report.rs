//! Numbers and figures in reports.

use luenberger_proof::certificate::ProvedSentence;
use luenberger_study::results::leading;
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{scratch, study};

/// The report of a study.
fn report(name: &str, text: &str) -> String {
    let folder = scratch(&format!("report/{name}"));
    let options = RunOptions { output: Some(folder.clone()), ..RunOptions::default() };
    execute(&study(text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
    std::fs::read_to_string(folder.join("report.html")).unwrap().replace("&amp;", "&")
}

/// A small entry beside large ones is rounding; one in a row or a column of small units is not.
#[test]
fn rounding_errors_are_not_shown_as_digits() {
    let shown = [
        ("a = [[2, 3e-16], [0, 1]]\nc = [[1e-16, 5]]\n", r"A = \begin{bmatrix} 2 & \approx 0 \\ 0 & 1 \end{bmatrix}"),
        ("a = [[2, 3e-16], [0, 1]]\nc = [[1e-16, 5]]\n", r"C = \begin{bmatrix} \approx 0 & 5 \end{bmatrix}"),
        (
            "a = [[1e6, 1e-10], [1e-10, 1e-24]]\nc = [[1, 0]]\n",
            r"A = \begin{bmatrix} 1000000 & 1e-10 \\ 1e-10 & 1e-24 \end{bmatrix}",
        ),
        (
            "a = [[0, 1], [0, 0]]\nb = [[1e-16], [5]]\nc = [[1, 0]]\n",
            r"B = \begin{bmatrix} \approx 0 \\ 5 \end{bmatrix}",
        ),
        ("a = [[-1]]\nc = [[1e-16]]\n", r"C = \begin{bmatrix} 1e-16 \end{bmatrix}"),
    ];
    for (number, (plant, matrix)) in shown.into_iter().enumerate() {
        let page = report(&format!("matrices-{number}"), &format!("[plant]\n{plant}"));
        assert!(page.contains(matrix), "{matrix}");
        assert_eq!(page.contains("not more than the rounding errors"), page.contains(r"\approx"), "{matrix}");
    }
}

#[test]
fn a_direction_of_many_states_is_told_by_its_leading_terms() {
    assert_eq!(leading("x2"), "x2");
    assert_eq!(leading("a - 0.9 b + 0.8 c - 0.7 d + 0.6 e - 0.5 f"), "a - 0.9 b + 0.8 c - 0.7 d + 0.6 e - 0.5 f");
    assert_eq!(
        leading("a - 0.9 b + 0.8 c - 0.7 d + 0.6 e - 0.5 f + 0.4 g - 0.3 h"),
        "a - 0.9 b + 0.8 c - 0.7 d + 0.6 e - 0.5 f and 2 smaller terms"
    );
}

/// The summary says what is proved, of up to three observers; what of more stands in their sections alone.
#[test]
fn the_summary_says_what_is_proved_of_a_few_observers() {
    let plant = "[plant]\na = [[-1]]\nc = [[1]]\n";
    for (count, is_said) in [(1, true), (3, true), (4, false)] {
        let one = |k: usize| format!("[[observer]]\nname = \"number {k}\"\nkind = \"luenberger\"\npoles = [-{k}]\n");
        let text = plant.to_owned() + &(2..2 + count).map(one).collect::<String>();
        let page = crate::page::body(&report(&format!("summary-{count}"), &text));
        let page = page.replace("&gt;", ">").replace("&lt;", "<").replace("&quot;", "\"");
        let results = execute(&study(&text), Step::Run, &RunOptions::default()).unwrap();
        for observer in &results.observers {
            let statement = &observer.design.as_ref().unwrap().statement;
            let proved: Vec<&str> = statement.proved_sentences().map(ProvedSentence::as_str).collect();
            assert!(!proved.is_empty());
            let sentence = format!("{}: {}", observer.name, proved.join(" "));
            assert_eq!(page.contains(&sentence), is_said, "{sentence} in {page}");
        }
    }
}

/// Of more than six facts five are shown, with the number of the others. Each of the three entries of the Jacobian that
/// vary has two bounds: eight vertices.
#[test]
fn the_facts_that_are_folded_are_counted() {
    let text = r#"
[plant]
f = ["x2 - 0.1*sin(x1)", "x3 - 0.1*sin(x2)", "-x1 - 3*x2 - 3*x3 - 0.1*sin(x3)"]
h = ["x1"]
[[observer]]
name = "lpv"
kind = "lpv"
region = { states = [[-1, 1], [-1, 1], [-1, 1]] }
decay_rate = 0.1
"#;
    let results = execute(&study(text), Step::Design, &RunOptions::default()).unwrap();
    let design = results.observers[0].design.as_ref().unwrap_or_else(|| panic!("{:?}", results.failures()));
    assert_eq!(design.verdict.word(), "proved");
    let (shown, folded) = design.leading_facts();
    assert!(design.facts.len() > 8, "{}", design.facts.len());
    assert_eq!((shown, folded), (&design.facts[..5], design.facts.len() - 5));
}

/// e+ = (1/2 - L) e - L v: one step and L v for L = 1/2, three steps and about L v for L = 1/4, and for L = 0 an error
/// that vanishes, which a logarithmic axis does not have.
#[test]
fn the_front_is_drawn_through_errors_above_zero() {
    let observer =
        |name: &str, gain: f64| format!("[[observer]]\nname = \"{name}\"\nkind = \"luenberger\"\ngain = [[{gain}]]\n");
    let (fast, calm, exact) = (observer("fast", 0.5), observer("calm", 0.25), observer("exact", 0.0));
    let drawn = |name: &str, observers: &[&str]| {
        let text = format!(
            "[plant]\na = [[0.5]]\nc = [[1]]\ndt = 1\n{}[simulation]\nx0 = [1]\nduration = 4000\n\
             noise = {{ amplitude = [0.01], period = 1 }}\n",
            observers.concat()
        );
        report(name, &text);
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report").join(name);
        std::fs::read_to_string(folder.join("figures/pareto.svg")).unwrap()
    };
    let (two, three) = (drawn("two", &[&fast, &calm]), drawn("three", &[&fast, &calm, &exact]));
    // The line is grey, in the legend and in the panel.
    let heights = |svg: &str| {
        let grey: Vec<&str> = svg.split("<path d=\"M").filter(|path| path.contains("stroke=\"#8c8c8c\"")).collect();
        let [_, front] = grey[..] else { panic!("{svg}") };
        let points = front.split('"').next().unwrap().split('L');
        points.map(|point| point.split_once(' ').unwrap().1.parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((heights(&two).len(), heights(&three)), (2, heights(&two)));
    assert!(three.contains(">fast<") && three.contains(">calm<") && !three.contains(">exact<"), "{three}");
}

/// A covariance in metres and pascals, and rounding beside it: what is zero depends on the row and the column.
#[test]
fn small_units_are_no_rounding() {
    use luenberger_study::results::is_about_zero;
    let covariance = [vec![2.25e-11, -0.033, 1e-26], vec![-0.033, 1.3e8, 1.0], vec![1e-26, 1.0, 1e-3]];
    let found = is_about_zero(&covariance);
    assert_eq!(found, [vec![false, false, true], vec![false; 3], vec![true, false, false]]);
    assert_eq!(is_about_zero(&[vec![1.0, 1e-17, 0.0]]), [vec![false, true, false]]);
}

/// The second observer of a study has one colour and one dash in all figures, drawn beside the first or alone: those of
/// the second place of the palette.
#[test]
fn an_observer_looks_the_same_in_all_figures() {
    let text = r#"
[plant]
a = [[0, 1], [-2, -3]]
c = [[1, 0]]
[simulation]
x0 = [1, 0]
duration = 3
samples = 31
scale = [1, 1]
[[observer]]
name = "first"
kind = "luenberger"
poles = [-4, -5]
[[observer]]
name = "second"
kind = "luenberger"
poles = [-6, -7]
[plot]
show = ["states", "errors", "error-norm", "innovations"]
"#;
    let blue = "#0072b2";
    let vermilion = "#d55e00";
    // The vermilion curves of a figure, with what is said of their dashes.
    let looks = |folder: &std::path::Path, figure: &str| -> std::collections::BTreeSet<String> {
        let svg = std::fs::read_to_string(folder.join(format!("figures/{figure}.svg"))).unwrap();
        let element = |part: &&str| part.contains(vermilion);
        let dash = |part: &str| {
            part.split("stroke-dasharray=\"").nth(1).and_then(|rest| rest.split('"').next()).map(str::to_owned)
        };
        svg.split('<').filter(element).map(|part| dash(part).unwrap_or_default()).collect()
    };
    let run = |name: &str, text: &str| {
        let folder = scratch(&format!("report/looks-{name}"));
        let options = RunOptions { output: Some(folder.clone()), ..RunOptions::default() };
        execute(&study(text), Step::Run, &options).unwrap_or_else(|error| panic!("{error}"));
        folder
    };
    let both = run("both", text);
    let alone = run("alone", &format!("{text}observers = [\"second\"]\n"));
    let expected = looks(&both, "states");
    assert_eq!(expected.len(), 1, "{expected:?}");
    for figure in ["states", "errors", "error-norm", "innovations"] {
        assert_eq!(looks(&both, figure), expected, "{figure}");
        assert_eq!(looks(&alone, figure), expected, "{figure}, alone");
        let svg = std::fs::read_to_string(alone.join(format!("figures/{figure}.svg"))).unwrap();
        assert!(!svg.contains(blue), "{figure}: the colour of the first");
    }
}
