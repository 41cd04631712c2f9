//! Numbers and figures in reports.

use luenberger_proof::certificate::ProvedSentence;
use luenberger_study::results::{
    DesignReport, DesignVerdict, FactReport, ModeReport, NamedNumber, ObservabilityAt, ObservabilityReport, Quantity,
    Rounding, UnseenModes, leading,
};
use luenberger_study::{RunOptions, Step, execute};

use crate::studies::{scratch, study};

/// The report of a study.
fn report(name: &str, text: &str) -> String {
    let folder = scratch(&format!("report/{name}"));
    let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
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

/// The first sentences of the summary: sizes with up to six names, and what can be seen of the state.
#[test]
fn the_summary_says_what_was_studied() {
    let diagonal = |entries: &[f64]| {
        let row = |i: usize| {
            format!("{:?}", (0..entries.len()).map(|j| if i == j { entries[i] } else { 0.0 }).collect::<Vec<_>>())
        };
        format!("a = [{}]\n", (0..entries.len()).map(row).collect::<Vec<_>>().join(","))
    };
    let chain = "a = [[0, 1], [0, 0]]\n";
    let pendulum = "f = [\"x2\", \"-sin(x1)\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1, 0]\nduration = 1\n";
    let cases = [
        (
            format!("{chain}b = [[0], [1]]\nc = [[1, 0]]\n"),
            "The plant has 2 states (x1, x2), 1 input (u1) and 1 output (y1). It is observable.",
        ),
        (
            "a = [[1, 1], [0, 1]]\nc = [[0, 1]]\ndt = 0.1\n".to_owned(),
            "The plant has 2 states (x1, x2), no input and 1 output (y1), in discrete time. It is not detectable: rank 1 of 2.",
        ),
        (
            format!("{}c = [[1, 0]]\n", diagonal(&[-1.0, -2.0])),
            "The plant has 2 states (x1, x2), no input and 1 output (y1). It is detectable, not observable: rank 1 of 2.",
        ),
        (
            format!("{}c = [{:?}]\n", diagonal(&[-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]), [1.0; 6]),
            "The plant has 6 states (x1, x2, x3, x4, x5, x6), no input and 1 output (y1). It is observable.",
        ),
        (
            format!("{}c = [{:?}]\n", diagonal(&[-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0]), [1.0; 7]),
            "The plant has 7 states, no input and 1 output (y1). It is observable.",
        ),
        (
            pendulum.to_owned(),
            "The plant has 2 states (x1, x2), no input and 1 output (y1). Its linearisations are observable at every point of the trajectory.",
        ),
    ];
    for (number, (plant, sentence)) in cases.into_iter().enumerate() {
        let page = report(&format!("studied-{number}"), &format!("[plant]\n{plant}"));
        assert!(crate::page::body(&page).contains(sentence), "{sentence}");
    }
}

/// What qualifies the results is counted: an observer without a design, and one whose poles are far beyond the plant.
#[test]
fn the_summary_counts_what_qualifies_it() {
    let plant = "[plant]\na = [[-1]]\nc = [[1]]\n";
    let one = |name: &str, keys: &str| format!("[[observer]]\nname = \"{name}\"\nkind = \"luenberger\"\n{keys}\n");
    let (calm, fast, faster) =
        (one("calm", "poles = [-2]"), one("fast", "poles = [-1e5]"), one("faster", "poles = [-1e6]"));
    let unstable = one("unstable", "gain = [[-3]]");
    let qualified = |name: &str, observers: &[&str]| {
        let page = crate::page::body(&report(name, &format!("{plant}{}", observers.concat())));
        let said = |sentence: &str| page.contains(sentence);
        (
            said("1 observer ended early or did not run."),
            said("One warning qualifies these results."),
            said("2 warnings qualify these results."),
        )
    };
    assert_eq!(qualified("qualified-0", &[&calm]), (false, false, false));
    assert_eq!(qualified("qualified-1", &[&calm, &fast]), (false, true, false));
    assert_eq!(qualified("qualified-2", &[&calm, &fast, &faster]), (false, false, true));
    assert!(qualified("qualified-3", &[&calm, &unstable]).0);
}

/// Of up to six facts all are shown; of more, those that are not proved and five others.
#[test]
fn facts_that_are_not_proved_are_never_folded() {
    let results = crate::studies::executed(
        "[plant]\na = [[-1]]\nc = [[1]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-2]\n",
        Step::Design,
    );
    let mut design = results.observers[0].design.clone().unwrap();
    let proved = design.facts.iter().find(|fact| fact.verdict.is_proved()).unwrap().clone();
    let open = FactReport { verdict: DesignVerdict::NONE, ..proved.clone() };
    for (open_count, proved_count, shown) in [(0, 6, 6), (0, 7, 5), (2, 4, 6), (2, 5, 7), (2, 7, 7), (9, 0, 9)] {
        design.facts = vec![open.clone(); open_count];
        design.facts.extend(vec![proved.clone(); proved_count]);
        let (found, folded) = design.leading_facts();
        assert_eq!((found.len(), folded), (shown, open_count + proved_count - shown), "{open_count}, {proved_count}");
    }
    // What is not proved is a failure, with the observer.
    let mut failing = results.clone();
    design.facts = vec![FactReport { statement: "F is Hurwitz".to_owned(), words: "undecided".to_owned(), ..open }];
    failing.observers[0].design = Some(design);
    assert_eq!(
        (results.failures(), failing.failures()),
        (vec![], vec!["luenberger: F is Hurwitz: undecided".to_owned()])
    );
}

/// Numbers are rounded to the side that is stated.
#[test]
fn numbers_are_rounded_to_their_side() {
    let of = |value, rounding| NamedNumber { name: "rate".to_owned(), quantity: Some(Quantity::Rate), value, rounding };
    for (value, rounding, text) in [
        (0.123_456_7, Rounding::Nearest, "0.123457"),
        (0.123_456_7, Rounding::Down, "0.123456"),
        (0.123_456_2, Rounding::Up, "0.123457"),
        (0.123_456_2, Rounding::Nearest, "0.123456"),
        (0.5, Rounding::Up, "0.5"),
        (0.5, Rounding::Down, "0.5"),
    ] {
        assert_eq!(of(Some(value), rounding).text(), text);
    }
    assert_eq!(of(None, Rounding::Up).text(), "infinite");
    let other = NamedNumber { name: "overshoot".to_owned(), quantity: None, value: Some(3.0), rounding: Rounding::Up };
    let design = DesignReport { numbers: vec![other, of(Some(2.0), Rounding::Down)], ..DesignReport::default() };
    assert_eq!((design.quantity(Quantity::Rate), design.quantity(Quantity::Overshoot)), (Some(2.0), None));
    assert_eq!(
        (design.number("overshoot"), design.number("rate"), design.number("else")),
        (Some(3.0), Some(2.0), None)
    );
}

#[test]
fn columns_stand_with_their_units() {
    let text = "[plant]\na = [[-1, 0], [0, -2]]\nb = [[1], [1]]\nc = [[1, 1]]\nunits = { x1 = \"m\", u1 = \"N\", y1 = \"V\" }\n";
    let plant = crate::studies::executed(text, Step::Observe).plant;
    let units: Vec<Option<&str>> =
        ["x1", "x2", "u1", "y1", "z"].map(|name| plant.unit(name).map(String::as_str)).into();
    assert_eq!(units, [Some("m"), None, Some("N"), Some("V"), None]);
    assert_eq!((plant.labelled("u1"), plant.labelled("x2")), ("u1 (N)".to_owned(), "x2".to_owned()));
    let listed = plant.listed(&plant.states, ["1", "2"].map(str::to_owned));
    assert_eq!(listed, "x1 = 1 m, x2 = 2");
}

/// What is said of modes that no output sees, with the largest of their margins.
#[test]
fn modes_that_are_not_seen_in_words() {
    let mode = |margin| ModeReport { eigenvalue: [0.0, 0.0], margin, direction: vec![1.0], words: "x1".to_owned() };
    let at = |unseen| ObservabilityAt {
        t: None,
        x: None,
        rank: 1,
        tolerance: 1e-12,
        modes: Vec::new(),
        hidden: vec![mode(1.26e-16), mode(3.14e-15), mode(0.0)],
        unseen,
    };
    for (unseen, words, decided) in [
        (UnseenModes::Decay, "They are stable: the plant is detectable.", true),
        (UnseenModes::Remain, "the plant is not detectable, and no observer exists.", true),
        (
            UnseenModes::None,
            "to working precision (margin at most 3.1e-15), while the plant as stored is observable",
            false,
        ),
        (UnseenModes::Undecided, "(margin at most 3.1e-15). Whether an observer exists is not decided.", false),
    ] {
        let said = at(unseen).unseen_in_words("These modes");
        assert!(said.starts_with("These modes are unobservable") && said.contains(words), "{said}");
        let report = |points| ObservabilityReport { points, order: 2, rank: 1, nonlinear: None };
        assert_eq!(report(vec![at(UnseenModes::Undecided), at(unseen)]).is_decided(), decided);
    }
}

/// The section on observability says what is decided of the plant as stored, and to working precision only what is not.
/// A small eigenvalue of a mode that is decided to decay is a number, one beside a large one of others is rounding.
#[test]
fn the_section_on_observability_says_what_is_decided() {
    let said = |name: &str, plant: &str| {
        crate::page::body(&report(&format!("observability-{name}"), &format!("[plant]\n{plant}")))
    };
    let all = said("all", "a = [[0, 1], [0, 0]]\nc = [[1, 0]]\n");
    assert!(all.contains("The plant is observable: rank 2 of 2."), "{all}");
    let decays = said("decays", "a = [[-1, 0], [0, -1e-17]]\nc = [[1, 0]]\n");
    assert!(decays.contains("The plant is not observable: rank 1 of 2.") && decays.contains("-1e-17"), "{decays}");
    let hidden = said("precision", "a = [[-1, 0], [0, -1.0000000000000002]]\nc = [[1, 1]]\n");
    assert!(hidden.contains("The plant has the rank 1 of 2 to working precision."), "{hidden}");
}

/// The equations of a linear plant have the matrices that it has.
#[test]
fn the_equations_of_a_linear_plant_have_its_matrices() {
    let latex = |name: &str, plant: &str| {
        report(&format!("equations-{name}"), &format!("[plant]\na = [[-1]]\nc = [[1]]\n{plant}"))
    };
    for (name, plant, equations) in [
        ("alone", "", ["= A x", "y = C x"]),
        ("input", "b = [[1]]\n", ["= A x + B u", "y = C x"]),
        ("both", "b = [[1]]\nd = [[2]]\n", ["= A x + B u", "y = C x + D u"]),
    ] {
        let page = latex(name, plant);
        for equation in equations {
            let at = page.find(equation).unwrap_or_else(|| panic!("{name}: {equation}"));
            let rest = page[at + equation.len()..].trim_start();
            assert!(!rest.starts_with('+'), "{name}: {equation} {}", &rest[..20]);
        }
    }
}

/// An equation of an output that has the name of the state that it measures has the name `y1`: `v = v` would say
/// nothing. Text for a terminal is the same text with colours.
#[test]
fn equations_and_colours_of_the_text() {
    let plant = |output: &str| {
        format!(
            "[plant]\nstates = [\"v\"]\noutputs = [\"{output}\"]\nf = [\"-v\"]\nh = [\"v\"]\n[[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 1\n"
        )
    };
    for (output, equation) in [("v", "y1 = v"), ("speed", "speed = v")] {
        let results = crate::studies::executed(&plant(output), luenberger_study::Step::Design);
        assert_eq!(results.plant.equations[..2], ["v' = -v", equation]);
        let coloured = results.coloured_text(true);
        let mut plain = String::new();
        let mut rest = coloured.as_str();
        while let Some((before, after)) = rest.split_once('\u{1b}') {
            plain += before;
            rest = after.split_once('m').unwrap().1;
        }
        assert_eq!(plain + rest, results.text(true));
    }
}

/// What a proof needs is folded, of every kind; what the observer runs with, and covariances, stand open: S of a filter
/// is the covariance of two noises, and S of the cubic observer a matrix of its proof.
#[test]
fn matrices_of_proofs_are_folded() {
    let plant = "[plant]\na = [[-1]]\nc = [[1]]\n";
    let discrete = "[plant]\na = [[0.9]]\nc = [[1]]\ndt = 0.1\n";
    let of = |kind: &str, keys: &str| format!("[[observer]]\nname = \"one\"\nkind = \"{kind}\"\n{keys}");
    let noise = "w = [[1.0]]\nv = [[2.0]]\n";
    for (name, plant, observer, open, folded) in [
        ("kalman", plant, of("kalman", noise), "P (stationary", "<mi>Lyapunov"),
        ("kalman-discrete", discrete, of("kalman", noise), "P (stationary", "<mi>Lyapunov matrix"),
        ("luenberger", plant, of("luenberger", "poles = [-3]\n"), "<mi>L</mi>", "<mi>P</mi>"),
        ("cubic", plant, of("cubic", "poles = [-3]\ngamma = 0.1\n"), "<mi>L</mi>", "<mi>S</mi>"),
        ("filter", discrete, of("extended-kalman", &format!("{noise}s = [[0.5]]\nperiod = 0.1\n")), "<mi>S</mi>", ""),
    ] {
        let page = crate::page::body(&report(&format!("folded-{name}"), &(plant.to_owned() + &observer)));
        let section = page.split("<h3").find(|part| part.contains("one (")).unwrap();
        let (before, inside) = section.split_once("The matrices of the certificate").unwrap_or((section, ""));
        assert!(before.contains(open), "{name}: {open} in {before}");
        assert!(folded.is_empty() || !before.contains(folded), "{name}: {folded} in {before}");
        assert!(inside.contains(folded), "{name}: {inside}");
    }
}

/// What the bands are is said of those that there are: of filters with a covariance, of stationary ones, of intervals.
#[test]
fn the_bands_of_a_figure_are_named() {
    let words = [
        "two standard deviations of a filter to either side, by its covariance P",
        "two standard deviations of a stationary Kalman filter",
        "from the lower to the upper bound of an interval observer",
    ];
    let plant = "[plant]\na = [[0.9]]\nc = [[1]]\ndt = 1\n[simulation]\nx0 = [1]\nduration = 20\n\
                 noise = { amplitude = [0.1], period = 1 }\n";
    for (name, observer, expected) in [
        ("gain", "kind = \"luenberger\"\npoles = [0.5]\n", [false, false, false]),
        ("stationary", "kind = \"kalman\"\nw = 0.1\nv = 0.01\n", [false, true, false]),
        ("filter", "kind = \"extended-kalman\"\nw = 0.1\nv = 0.01\nperiod = 1\n", [true, false, false]),
        (
            "interval",
            "kind = \"interval\"\npoles = [0.5]\ninitial_bounds = [1]\nbounds = { noise = [0.1] }\n",
            [false, false, true],
        ),
    ] {
        let page = report(&format!("bands-{name}"), &format!("{plant}[[observer]]\n{observer}"));
        assert_eq!(words.map(|words| page.contains(words)), expected, "{name}");
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
        let options = RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() };
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
