//! Alternatives to an observer that is refused: each, applied as it is printed, has a design.

use luenberger_study::results::NoObserver;

use crate::studies::{designed, read};

/// Plants, each with the number of its states, outputs and inputs.
const PLANTS: &[(&str, &str, [usize; 3])] = &[
    ("linear", "a = [[0, 1], [-2, -3]]\nb = [[0], [1]]\nc = [[1, 0]]", [2, 1, 1]),
    ("double integrator", "a = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]", [2, 1, 1]),
    ("with feedthrough", "a = [[0, 1], [-2, -3]]\nb = [[0], [1]]\nc = [[1, 0]]\nd = [[0.5]]", [2, 1, 1]),
    ("detectable", "a = [[-1, 0], [3, -2]]\nc = [[1, 0]]", [2, 1, 0]),
    ("in SI units", "a = [[-1e6, 0], [0, -1e-3]]\nb = [[1e6], [0]]\nc = [[1, 0]]", [2, 1, 1]),
    ("not detectable", "a = [[-1, 0], [0, 2]]\nc = [[1, 0]]", [2, 1, 0]),
    ("with a fixed eigenvalue", "a = [[1, 1, 0], [0, -2, 0], [0, 1, -5]]\nc = [[1, 0, 0]]", [3, 1, 0]),
    ("discrete", "a = [[0.9, 0.1], [0, 0.8]]\nb = [[0], [1]]\nc = [[1, 0]]\ndt = 0.1", [2, 1, 1]),
    ("discrete and detectable", "a = [[0.9, 0], [0.1, 0.8]]\nc = [[1, 0]]\ndt = 0.1", [2, 1, 0]),
    (
        "discrete with feedthrough",
        "a = [[0.9, 0.1], [0, 0.8]]\nb = [[0], [1]]\nc = [[1, 0]]\nd = [[1]]\ndt = 0.1",
        [2, 1, 1],
    ),
    ("pendulum", "f = [\"x2\", \"-sin(x1) - 0.1*x2 + u1\"]\nh = [\"x1\"]\ninputs = [\"u1\"]", [2, 1, 1]),
    ("cubic spring", "f = [\"x2\", \"-x1^3\"]\nh = [\"x1\"]", [2, 1, 0]),
    ("nonlinear output", "f = [\"x2\", \"-sin(x1)\"]\nh = [\"sin(x1)\"]", [2, 1, 0]),
    ("second state measured", "f = [\"x2\", \"-x1 - x2^3\"]\nh = [\"x2\"]", [2, 1, 0]),
    ("in time", "f = [\"x2\", \"-x1 + 0.5*sin(3*t)\"]\nh = [\"x1\"]", [2, 1, 0]),
    ("with a constant term", "f = [\"1 - x1\"]\nh = [\"x1\"]", [1, 1, 0]),
    ("nonlinear with feedthrough", "f = [\"x2\", \"-sin(x1) + u1\"]\nh = [\"x1 + 0.1*u1\"]", [2, 1, 1]),
    ("discrete pendulum", "f = [\"x1 + 0.1*x2\", \"x2 - 0.1*sin(x1)\"]\nh = [\"x1\"]\ndt = 0.1", [2, 1, 0]),
];

/// Observers of every kind, most of them with some hypothesis that a plant can violate, for n states and p outputs.
fn observers([n, p, m]: [usize; 3], is_discrete: bool) -> Vec<String> {
    let poles = |count: usize, first: f64| {
        let of = |i: usize| if is_discrete { 0.1 + 0.1 * i as f64 } else { -first * (1.0 + 0.5 * i as f64) };
        format!("poles = [{}]", (0..count).map(|i| of(i).to_string()).collect::<Vec<_>>().join(", "))
    };
    let rows = |rows: usize, columns: usize, one: usize| {
        let row = |i: usize| {
            let entries: Vec<&str> =
                (0..columns).map(|j| if i == one && j == columns - 1 { "1" } else { "0" }).collect();
            format!("[{}]", entries.join(", "))
        };
        format!("[{}]", (0..rows).map(row).collect::<Vec<_>>().join(", "))
    };
    let (all, e) = (poles(n, 2.0), rows(n, 1, n - 1));
    let with_e = |kind: &str, rest: &str| format!("kind = \"{kind}\"\ne = {e}\n{rest}");
    let pairs = |count: usize| format!("[{}]", vec!["[-1, 1]"; count].join(", "));
    let region = format!("region = {{ states = {} }}", pairs(n));
    let norm = |kind: &str, rest: &str| {
        let d = rows(p, n + p, 0);
        let identity: Vec<String> = (0..n)
            .map(|i| format!("[{}]", (0..n + p).map(|j| if i == j { "1" } else { "0" }).collect::<Vec<_>>().join(", ")))
            .collect();
        format!("kind = \"{kind}\"\ne = [{}]\nd = {d}\n{rest}", identity.join(", "))
    };
    let mut observers = vec![
        format!("kind = \"luenberger\"\n{all}"),
        "kind = \"luenberger\"\nlmi = true".to_owned(),
        "kind = \"luenberger\"\ndecay_rate = 100\nmax_gain = 1".to_owned(),
        format!("kind = \"luenberger\"\ngain = {}", rows(n, p, n)),
        format!("kind = \"luenberger\"\n{all}\nbounds = {{ noise = [0] }}"),
        "kind = \"kalman\"\nw = 1\nv = 1".to_owned(),
        "kind = \"kalman\"\nw = 0\nv = 1".to_owned(),
        format!("kind = \"cubic\"\n{all}\ngamma = 1"),
        format!("kind = \"cubic\"\ngain = {}\ngamma = 1", rows(n, p, n)),
        format!("kind = \"sampled-cubic\"\n{all}\ngamma = 1\nperiod = 0.05"),
        format!("kind = \"sampled-cubic\"\n{all}\ngamma = 1\nperiod = 0.1\njitter = [0.02, 3]\nmisses = 1"),
        format!("kind = \"functional\"\nk = {}\n{}", rows(1, n, 0), poles(1, 3.0)),
        format!("kind = \"functional\"\nk = {}\n{}", rows(1, n, 0), poles(1, 5.0)),
        with_e("proportional-integral", &poles(n + 1, 2.0)),
        with_e("extended-state", "bandwidth = 5"),
        with_e("extended-state", &poles(n + 1, 1.0)),
        with_e("unknown-input", &all),
        with_e("unknown-input", "lmi = true"),
        norm("h-infinity", ""),
        norm("h-infinity", "gamma = 1e-3"),
        norm("h2", "gamma = 1e-3"),
        norm("h2", "gamma = 1e-3\nmax_gain = 0.1"),
        format!("kind = \"interval\"\n{all}\nwidth = {}", "1"),
        "kind = \"lpv\"\ndecay_rate = 0.3".to_owned(),
        format!("kind = \"lpv\"\ndecay_rate = 100\nmax_gain = 1\n{region}"),
        format!("kind = \"lpv\"\ngain = {}\n{region}", rows(n, p, n)),
        "kind = \"lipschitz\"\ndecay_rate = 0.3".to_owned(),
        format!("kind = \"lipschitz\"\n{region}\ngain = {}", rows(n, p, n)),
        format!("kind = \"mean-value\"\ndecay_rate = 100\nmax_gain = 1\n{region}"),
        "kind = \"mean-value\"".to_owned(),
        "kind = \"high-gain\"\nr = 0.1".to_owned(),
        "kind = \"sliding-mode\"\nbound = 1\nperiod = 0.01".to_owned(),
        "kind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.05".to_owned(),
        "kind = \"ukf\"\nw = 1\nv = 1\nperiod = 0.05".to_owned(),
        "kind = \"mhe\"\nw = 1\nv = 1\nperiod = 0.05".to_owned(),
    ];
    if n > p {
        observers.push(format!("kind = \"reduced-order\"\n{}", poles(n - p, 4.0)));
    }
    if m > 0 {
        observers.push(format!("kind = \"kkl-numerical\"\ndomain = {}\npoints = 5\ncutoff = 1", pairs(n)));
    }
    observers
}

/// The text with an alternative, `KEYS in place of NAMES and [operating_point] with KEYS: WHY`.
fn applied(plant: &str, observer: &str, alternative: &str) -> String {
    let (head, _) = alternative.rsplit_once(": ").unwrap();
    let (head, point) = match head.split_once("[operating_point] with ") {
        Some((head, point)) => (head.trim_end().trim_end_matches(" and"), format!("operating_point = {{ {point} }}\n")),
        None => (head, String::new()),
    };
    let (keys, replaced) = match head.split_once(" in place of ") {
        Some(parts) => parts,
        None => head.strip_prefix("without ").map_or((head, ""), |replaced| ("", replaced)),
    };
    let mut lines: Vec<&str> = if keys.starts_with("kind = ") { Vec::new() } else { observer.lines().collect() };
    lines.retain(|line| !replaced.split(", ").any(|key| line.starts_with(&format!("{key} = "))));
    lines.extend(Some(keys).filter(|keys| !keys.is_empty()));
    format!("{point}observer = [{{ {} }}]\n[plant]\n{plant}\n", lines.join(", "))
}

fn refusal(text: &str) -> Option<NoObserver> {
    designed(&read(text).unwrap_or_else(|error| panic!("{text}\n{error}"))).err()
}

#[test]
fn every_alternative_that_is_printed_has_a_design() {
    let (mut refused, mut applied_ones) = (0, 0);
    for (title, plant, size) in PLANTS {
        for observer in observers(*size, plant.contains("dt = ")) {
            // Some are mistakes of the file: a kind for another class of plants, or a list of another length.
            let Ok(study) = read(&format!("[plant]\n{plant}\n[[observer]]\n{observer}\n")) else { continue };
            let Err(failure) = designed(&study) else { continue };
            refused += 1;
            for alternative in &failure.alternatives {
                applied_ones += 1;
                let text = applied(plant, &observer, alternative.words());
                let again = refusal(&text);
                assert!(again.is_none(), "{title}: {observer}\n{}\n{again:?}", alternative.words());
            }
            let is_open = *title != "not detectable" || failure.alternatives.is_empty();
            assert!(
                is_open || failure.alternatives.iter().all(|other| !other.words().contains("kalman")),
                "{observer}"
            );
        }
    }
    println!("{refused} refused, {applied_ones} alternatives");
    assert!(refused > 100 && applied_ones > 150, "{refused} refused, {applied_ones} alternatives");
}

/// The words of the alternatives of an observer that is refused.
fn words(plant: &str, observer: &str) -> Vec<String> {
    let failure = refusal(&format!("[plant]\n{plant}\n[[observer]]\n{observer}\n")).unwrap();
    failure.alternatives.iter().map(|alternative| alternative.words().to_owned()).collect()
}

#[test]
fn a_linear_plant_is_offered_kinds_for_linear_plants() {
    let linear = ["kind = \"kalman\", w = 1, v = 1: ", "kind = \"luenberger\", lmi = true: "];
    let with_feedthrough = PLANTS[2].1;
    for observer in
        ["kind = \"high-gain\"\nr = 0.1", "kind = \"kkl-numerical\"\ndomain = [[-2, 2], [-2, 2]]\ncutoff = 1"]
    {
        let found = words(with_feedthrough, observer);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found.iter().zip(linear).all(|(found, start)| found.starts_with(start)), "{found:?}");
    }
    // A hidden mode among the poles is no remedy: such poles are refused.
    let found = words("a = [[-1, 0], [3, -2]]\nc = [[1, 0]]", "kind = \"luenberger\"\npoles = [-4, -2]");
    assert!(found[0].starts_with("lmi = true in place of poles: "), "{found:?}");
    assert!(found.iter().all(|words| !words.contains("poles = ")), "{found:?}");
}

#[test]
fn a_discrete_plant_is_offered_kinds_for_discrete_time() {
    // L = 0 leaves the poles of the plant; -1 moves one of them beyond 1.
    let found = words(PLANTS[7].1, "kind = \"luenberger\"\ngain = [[-1], [0]]");
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("lmi = true in place of gain: "), "{found:?}");
    assert!(found[1].starts_with("kalman = { w = 1, v = 1 } in place of gain: "), "{found:?}");
    let found = words(PLANTS[7].1, "kind = \"cubic\"\npoles = [0.1, 0.2]\ngamma = 1");
    assert!(found.iter().any(|words| words.starts_with("kind = \"luenberger\", lmi = true: ")), "{found:?}");
}

#[test]
fn an_operating_point_is_offered_where_there_is_none_and_one_exists() {
    let pendulum = "f = [\"x2\", \"-sin(x1) + u1\"]\nh = [\"x1\"]\ninputs = [\"u1\"]";
    let at = "[operating_point] with x = [0, 0], u = [0]: ";
    let extended = "kind = \"extended-state\"\ne = [[0], [1]]\nbandwidth = 5";
    assert!(words(pendulum, extended).iter().any(|words| words.contains(at)));
    assert!(words(pendulum, "kind = \"luenberger\"\npoles = [-1, -2]").iter().any(|words| words.starts_with(at)));
    let named = words(&format!("{pendulum}\n[operating_point]"), extended);
    assert!(named.iter().all(|words| !words.contains(at)), "{named:?}");
    assert!(named.iter().any(|words| words.starts_with("kind = \"kalman\"")), "{named:?}");
    // x1' = 1 + x1^2 has no point of rest.
    let none = words("f = [\"1 + x1^2\"]\nh = [\"x1\"]", "kind = \"luenberger\"\npoles = [-1]");
    assert!(none.iter().all(|words| !words.contains("[operating_point]")), "{none:?}");
}

/// What takes long is not tried, and said so; without a text of the observer its keys cannot be changed.
#[test]
fn what_was_not_tried_is_a_hint() {
    let rows: Vec<String> = (0..21)
        .map(|i| format!("[{}]", (0..21).map(|j| if i == j { "-1" } else { "0" }).collect::<Vec<_>>().join(", ")))
        .collect();
    let c = format!("[1{}]", ", 0".repeat(20));
    let large = format!(
        "[plant]\na = [{}]\nc = [{c}]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1{}]\n",
        rows.join(", "),
        ", -1".repeat(20)
    );
    let failure = refusal(&large).unwrap();
    assert!(failure.hints.iter().any(|hint| hint.contains("not tried") && hint.contains("lmi = true")), "{failure:?}");
    assert!(failure.alternatives.iter().any(|other| other.words().contains("kalman")), "{failure:?}");
    let mut study =
        read("[plant]\na = [[-1, 0], [3, -2]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-4, -2]\n")
            .unwrap();
    study.observers[0].name = "made in a program".to_owned();
    let Err(failure) = designed(&study) else { panic!("refused") };
    assert!(failure.alternatives.iter().all(|other| other.words().starts_with("kind = ")), "{failure:?}");
    assert_eq!(failure.alternatives.len(), 2);
}
