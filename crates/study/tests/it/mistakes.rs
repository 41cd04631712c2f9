//! Mistakes in a study: each is reported at its line, with the expectation.

use std::path::Path;

use luenberger_study::diagnostic::Located;
use luenberger_study::{Format, RunOptions, Step, Study, StudyError, execute};

use crate::messages;
use crate::studies;

const STUDY: &str = r#"title = "t"
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, 1]
duration = 2
noise = { amplitude = [0.1], period = 0.1 }
[[observer]]
name = "one"
kind = "luenberger"
poles = [-2, -5]
[[observer]]
name = "two"
kind = "cubic"
poles = [-2, -5]
gamma = 2
[plot]
show = ["states"]
[sweep]
parameter = "gamma"
values = [1, 2]
"#;

const NONLINEAR: &str = r#"[plant]
f = ["x2", "-k*sin(x1) + u1"]
h = ["x1"]
parameters = { k = 2.0 }
[simulation]
x0 = [1, 1]
duration = 2
[[observer]]
kind = "lpv"
decay_rate = 1
"#;

fn read(text: &str, format: Format) -> Result<Study, StudyError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates");
    Study::from_text("study.toml", text, format, &folder)
}

#[track_caller]
fn mistakes(text: &str) -> Vec<Located> {
    studies::mistakes_of(text, read(text, Format::Toml))
}

/// Each edit gives one mistake, on that line, whose message and expectation contain these words.
fn one(text: &str, edits: &[(&str, &str, usize, &str, &str)]) {
    assert!(read(text, Format::Toml).is_ok(), "{}", read(text, Format::Toml).unwrap_err());
    for (from, to, line, message, expected) in edits {
        let edited = text.replacen(from, to, 1);
        assert_ne!(edited, text, "{from} is not in the study");
        let found = mistakes(&edited);
        assert_eq!(found.len(), 1, "{to}: {found:#?}");
        let found = &found[0];
        let place = edited.lines().nth(found.line - 1).unwrap_or("");
        assert_eq!(found.line, *line, "{to}: {found:?} stands at {place}");
        assert!(found.column >= 1 && found.column <= place.chars().count() + 1, "{to}: {found:?}");
        assert!(found.message.contains(message), "{to}: {:?} does not say {message:?}", found.message);
        let said = format!("{} {}", found.expected, found.help.as_deref().unwrap_or(""));
        assert!(said.contains(expected), "{to}: {said:?} does not say {expected:?}");
    }
}

#[test]
pub(crate) fn keys() {
    one(
        STUDY,
        &[
            (
                "poles =",
                "pols =",
                15,
                "`pols` is not a key of [[observer]] of the kind luenberger",
                "the nearest key is `poles`",
            ),
            ("duration = 2", "duraton = 2\nduration = 2", 10, "`duraton` is not a key of [simulation]", "`duration`"),
            ("[plot]", "[plott]", 21, "`plott` is not a key of the study", "`plot`"),
            (
                "poles = [-2, -5]\n[[",
                "poles = [-2, -5]\ntemperature = 3\n[[",
                16,
                "`temperature` is not a key",
                "expected one of name",
            ),
            (
                "poles = [-2, -5]\n[[",
                "poles = [-2, -5]\ngamma = 3\n[[",
                16,
                "`gamma` is not a key",
                "kinds cubic, proportional-integral, unknown-input, h-infinity, h2, sampled-cubic",
            ),
            ("duration = 2\n", "", 8, "[simulation] has no `duration`", "a positive finite number"),
            ("kind = \"luenberger\"\n", "", 12, "[[observer]] has no `kind`", "\"luenberger\""),
            (
                "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n",
                "",
                1,
                "the study has no `plant`",
                "[plant]",
            ),
        ],
    );
}

#[test]
pub(crate) fn kinds_of_values() {
    one(
        STUDY,
        &[
            ("duration = 2", "duration = \"two\"", 10, "`duration` is the text \"two\"", "a positive finite number"),
            ("duration = 2", "duration = -2", 10, "`duration` is -2", "a positive finite number"),
            ("duration = 2", "duration = nan", 10, "`duration` is NaN", "a positive finite number"),
            ("duration = 2", "duration = inf", 10, "`duration` is inf", "a positive finite number"),
            ("duration = 2", "duration = 2020-01-01", 10, "`duration` is a date", "a positive finite number"),
            ("duration = 2", "duration = 1e999", 10, "`duration` is", "a positive finite number"),
            ("x0 = [1, 1]", "x0 = [1, nan]", 9, "entry 2 of `x0` is NaN", "finite number"),
            ("x0 = [1, 1]", "x0 = []", 9, "`x0` is an empty list", "a list of numbers"),
            ("x0 = [1, 1]", "x0 = 1", 9, "`x0` is 1", "a list of numbers"),
            (
                "kind = \"luenberger\"",
                "kind = \"luenburger\"",
                14,
                "no [[observer]] of the kind \"luenburger\"",
                "`luenberger`",
            ),
            ("kind = \"luenberger\"", "kind = 3", 14, "`kind` is a number", "\"luenberger\""),
            ("title = \"t\"", "title = \" \"", 1, "`title` is empty", "a text"),
            ("show = [\"states\"]", "show = [\"stats\"]", 22, "\"stats\"", "the nearest is `states`"),
            (
                "[[0, 1], [0, 0]]",
                "[[0, 1], [0]]",
                3,
                "row 2 of `a` has length 1, row 1 has length 2",
                "expected length 2",
            ),
            ("[[0, 1], [0, 0]]", "[[0, 1], 3]", 3, "row 2 of `a` is 3", "a matrix as a list of rows"),
            ("[[0, 1], [0, 0]]", "[[0, 1], []]", 3, "row 2 of `a` is empty", "rows"),
            ("[[0, 1], [0, 0]]", "[[0, 1], [0, inf]]", 3, "entry (2, 2) of `a` is inf", "finite number"),
            ("poles = [-2, -5]", "poles = [[-2, 1, 3], -5]", 15, "pole 1 of `poles` has 3 parts", "[re, im]"),
            ("poles = [-2, -5]", "lmi = 1", 15, "`lmi` is 1", "true or false"),
            ("duration = 2", "duration = 2\nsamples = 1", 11, "`samples` is 1", "at least 2"),
            ("duration = 2", "duration = 2\nsamples = 2.5", 11, "`samples` is 2.5", "a whole number"),
            ("title = \"t\"\n", "title = \"t\"\nlog = 3\n", 2, "[log] is a number", "expected a table"),
        ],
    );
}

#[test]
pub(crate) fn dimensions() {
    one(
        STUDY,
        &[
            ("a = [[0, 1], [0, 0]]", "a = [[0, 1]]", 3, "`a` is 1 x 2", "a square matrix"),
            ("b = [[0], [1]]", "b = [[0]]", 4, "`b` is 1 x 1", "expected 2 x 1: `a` is 2 x 2"),
            ("c = [[1, 0]]", "c = [[1]]", 5, "`c` is 1 x 1", "expected 1 x 2: `a` is 2 x 2"),
            ("x0 = [1, 1]", "x0 = [1]", 9, "`x0` has length 1, and the plant has 2 states", "expected length 2"),
            ("[\"sin(t)\"]", "[\"0\", \"0\"]", 7, "length 2, and the plant has 1 input", "expected 1 expression"),
            (
                "amplitude = [0.1]",
                "amplitude = [0.1, 1]",
                11,
                "length 2, and the plant has 1 output",
                "expected length 1",
            ),
            (
                "poles = [-2, -5]",
                "poles = [-2]",
                15,
                "`poles` has length 1, and the plant has 2 states",
                "expected 2 poles",
            ),
            (
                "poles = [-2, -5]",
                "gain = [[1, 2]]",
                15,
                "`gain` is 1 x 2",
                "expected 2 x 1: the plant has 2 states and 1 output",
            ),
            ("poles = [-2, -5]", "poles = [-2, -5]\nq = [[1]]", 16, "`q` is 1 x 1", "expected 2 x 2"),
            ("gamma = 2", "gamma = 2\ntheta = [1, 2]", 21, "the diagonal `theta` has length 2", "expected length 1"),
            ("name = \"one\"", "name = \"one\"\ninitial = [0]", 14, "`initial` has length 1", "expected length 2"),
            (
                "c = [[1, 0]]",
                "c = [[1, 0]]\nstates = [\"p\"]",
                6,
                "`states` has 1 name, and the plant has 2 states",
                "expected 2",
            ),
            ("c = [[1, 0]]", "c = [[1, 0]]\nstates = [\"p\", \"p\"]", 6, "\"p\" occurs twice", "different"),
            (
                "c = [[1, 0]]",
                "c = [[1, 0]]\nunits = [\"m\"]",
                6,
                "`units` has length 1, and the plant has 2 states",
                "expected length 2",
            ),
            (
                "c = [[1, 0]]",
                "c = [[1, 0]]\nstates = [\"angle\", \"speed\"]\nunits = { sped = \"rad/s\" }",
                7,
                "the plant has no state, input, output or parameter `sped`",
                "expected one of angle, speed, u1, y1",
            ),
            (
                "c = [[1, 0]]",
                "c = [[1, 0]]\nunits = { x3 = \"m\" }",
                6,
                "the plant has no state, input, output or parameter `x3`",
                "the nearest is `x1`",
            ),
            ("c = [[1, 0]]", "c = [[1, 0]]\n[plant.units]\nt = \"s\"", 7, "parameter `t`", "`time_unit` in [plant]"),
            ("c = [[1, 0]]", "c = [[1, 0]]\nunits = { x1 = 1 }", 6, "the unit of `x1` is 1", "expected a text"),
            ("c = [[1, 0]]", "c = [[1, 0]]\nunits = { x1 = \" \" }", 6, "the unit of `x1` is empty", "expected a text"),
            ("c = [[1, 0]]", "c = [[1, 0]]\nunits = 1", 6, "`units` is 1", "a table from names to units"),
        ],
    );
}

#[test]
pub(crate) fn what_joins_keys() {
    one(
        STUDY,
        &[
            ("c = [[1, 0]]\n", "", 2, "but no `c`", "p x n"),
            ("c = [[1, 0]]", "c = [[1, 0]]\nf = [\"x1\"]", 6, "`f` conflicts with `a`", "expected only a, b, c"),
            (
                "a = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]",
                "states = [\"p\"]",
                2,
                "does not define a plant",
                "builtin",
            ),
            (
                "poles = [-2, -5]",
                "poles = [-2, -5]\ndecay_rate = 1",
                16,
                "`decay_rate` conflicts with `poles`",
                "expected one of poles",
            ),
            ("poles = [-2, -5]\n[[", "[[", 12, "has no gain specification", "expected one of poles"),
            ("poles = [-2, -5]", "lmi = false", 15, "`lmi` is false", "true"),
            ("gamma = 2", "gamma = 2\nradial = 1", 21, "`radial` conflicts with `gamma`", "expected one of gamma"),
            (
                "poles = [-2, -5]",
                "poles = [2, -5]",
                15,
                "the pole 2 is not in the open left half plane",
                "negative real part",
            ),
            ("poles = [-2, -5]", "poles = [[-2, 1], -5]", 15, "the pole [-2, 1] has no conjugate", "[-2, -1]"),
            ("name = \"two\"", "name = \"one\"", 17, "two observers are named \"one\"", "different names"),
            ("name = \"two\"", "name = \"?!\"", 17, "\"?!\" cannot be part of a file name", "a letter"),
            ("name = \"two\"", "name = \"con\"", 17, "Windows reserves it for a device", "another name"),
            ("name = \"two\"", "name = \"LPT3\"", 17, "Windows reserves it for a device", "another name"),
            ("name = \"two\"", "name = \"One\"", 17, "give the same file names", "case and punctuation"),
            ("name = \"two\"", "name = \"/one\"", 17, "give the same file names", "case and punctuation"),
            ("name = \"two\"", "name = \"a\\u0000b\"", 17, "`name` has the control character U+0000", "without"),
            ("b = [[0], [1]]\n", "", 5, "[input], but the plant has no inputs", "no [input]"),
            ("expressions = [\"sin(t)\"]\n", "", 6, "[input] is empty", "`expressions`"),
            (
                "expressions = [\"sin(t)\"]",
                "interpolation = \"hold\"\nexpressions = [\"0\"]",
                7,
                "`interpolation` without a `table`",
                "`table`",
            ),
            (
                "expressions = [\"sin(t)\"]",
                "expressions = [\"0\"]\ntable = \"x.csv\"",
                8,
                "`table` conflicts with `expressions`",
                "one of them",
            ),
            (
                "expressions = [\"sin(t)\"]",
                "feedback = { k = [[1, 1]], observer = \"onee\" }",
                7,
                "no observer named \"onee\"",
                "the nearest is \"one\"",
            ),
            (
                "expressions = [\"sin(t)\"]",
                "feedback = { k = [[1]], observer = \"one\" }",
                7,
                "`k` is 1 x 1",
                "expected 1 x 2",
            ),
            ("show = [\"states\"]", "states = [\"x3\"]", 22, "no state named \"x3\"", "x1, x2"),
            ("show = [\"states\"]", "from = 2\nto = 1", 23, "from 2 to 1", "from < to"),
            ("values = [1, 2]\n", "", 23, "[sweep] has no values", "`from` and `to`"),
            ("values = [1, 2]", "from = 2\nto = 1", 26, "from 2 to 1", "from < to"),
            (
                "values = [1, 2]",
                "values = [1]\nfrom = 2\nto = 3",
                25,
                "`values` conflicts with `from`",
                "one of the two",
            ),
            ("values = [1, 2]", "values = [1, 2]\nobservers = [\"one\"]", 24, "none of the observers has one", "cubic"),
            ("values = [1, 2]", "values = [0]", 25, "entry 1 of `values` is 0", "positive"),
        ],
    );
    let without_noise =
        STUDY.replace("noise = { amplitude = [0.1], period = 0.1 }\n", "").replace("\"gamma\"", "\"noise\"");
    assert!(mistakes(&without_noise)[0].message.contains("noise, and [simulation] has none"));
    let start = STUDY.find("[simulation]").unwrap();
    let end = STUDY.find("[[observer]]").unwrap();
    let found = mistakes(&[&STUDY[..start], &STUDY[end..]].concat());
    assert!(found.iter().any(|mistake| mistake.message == "[sweep] without a [simulation]"), "{found:?}");
}

/// User-supplied names of states and inputs, in expressions and messages.
const NAMED: &str = r#"[plant]
f = ["speed", "-k*sin(angle) + torque"]
h = ["angle"]
states = ["angle", "speed"]
inputs = ["torque"]
parameters = { k = 2.0 }
[simulation]
x0 = [1, 1]
duration = 2
[[observer]]
kind = "lpv"
region = { states = [[-1, 1], [-inf, inf]] }
decay_rate = 1
"#;

#[test]
pub(crate) fn names_in_expressions() {
    let states = "states = [\"angle\", \"speed\"]";
    let called = |first: &str| format!("states = [\"{first}\", \"speed\"]");
    one(
        NAMED,
        &[
            ("sin(angle)", "sin(angel)", 2, "there is no `angel`; did you mean `angle`?", "cannot be read"),
            ("sin(angle)", "sin(q)", 2, "known are angle, speed, torque, x1 to x2, u1, t, pi, e, k", "cannot be read"),
            ("h = [\"angle\"]", "h = [\"torqe\"]", 3, "there is no `torqe`; did you mean `torque`?", "cannot be read"),
            (states, &called("sin"), 4, "`sin` cannot be the name of a state: it is a function", "no other meaning"),
            (states, &called("t"), 4, "`t` cannot be the name of a state: it is the time", "no other meaning"),
            (states, &called("e"), 4, "`e` cannot be the name of a state: it is 2.71828...", "no other meaning"),
            (states, &called("x2"), 4, "`x2` cannot be the name of a state: it is a state", "no other meaning"),
            (states, &called("u1"), 4, "`u1` cannot be the name of a state: it is an input", "no other meaning"),
            (states, &called("speed"), 4, "the name \"speed\" occurs twice", "different names"),
            (states, "states = [\"angle\"]", 4, "`states` has 1 name, and the plant has 2 states", "2 names"),
            (
                "[\"torque\"]",
                "[\"angle\"]",
                5,
                "`angle` cannot be the name of an input: it is a state",
                "no other meaning",
            ),
            ("{ k = 2.0 }", "{ k = 2.0, speed = 1.0 }", 6, "the name of a parameter: it is a state", "another name"),
            (
                "[simulation]",
                "[input]\nexpressions = [\"speed\"]\n[simulation]",
                8,
                "`speed` may not be used here: this is a function of the time t alone",
                "cannot be read",
            ),
        ],
    );
    let found = mistakes(&NAMED.replace("\"speed\"]\ninputs", "\"cos\"]\ninputs"));
    assert_eq!((found.len(), found[0].line, found[0].column), (1, 4, 20), "the name itself: {found:?}");
    // The numbered names are allowed too; a name that is not an identifier appears in figures and tables only.
    let mixed = NAMED.replace("\"speed\"]\ninputs", "\"top speed\"]\ninputs").replace("[\"speed\", ", "[\"x2\", ");
    assert!(read(&mixed, Format::Toml).is_ok());
}

/// The design uses indices of states and inputs; messages use the user's names.
#[test]
pub(crate) fn designs_are_told_in_the_names_of_the_study() {
    let study = read(NAMED, Format::Toml).unwrap();
    let results = execute(&study, Step::Design, &RunOptions::default()).unwrap();
    assert_eq!(results.plant.equations, ["angle' = speed", "speed' = -k*sin(angle) + torque", "y1 = angle"]);
    let design = results.observers[0].design.as_ref().unwrap();
    assert!(
        design.statement.starts_with("As long as x(t) and xhat(t) stay in the box (angle in [-1, 1]),"),
        "{design:?}"
    );
    // Between -2 and -2 cos(1).
    assert!(design.facts[1].statement.ends_with("< 0 at vertex 1 (d(speed')/d(angle) = -2)"), "{design:?}");
    let undefined = NAMED.replace("-k*sin(angle)", "-k*sqrt(angle)");
    let results = execute(&read(&undefined, Format::Toml).unwrap(), Step::Design, &RunOptions::default()).unwrap();
    let failure = results.observers[0].failure.as_ref().unwrap();
    assert!(failure.hypothesis.contains("d(speed')/d(angle) has no finite bound at angle = 0; "), "{failure:?}");
}

#[test]
pub(crate) fn expressions() {
    one(
        NONLINEAR,
        &[
            ("sin(x1)", "sinn(x1)", 2, "there is no function `sinn`; did you mean", "cannot be read"),
            ("sin(x1)", "sin(x3)", 2, "there is no `x3`: there are 2 states", "cannot be read"),
            ("k*sin", "kk*sin", 2, "there is no `kk`; did you mean `k`?", "cannot be read"),
            ("sin(x1)", "sin(x1", 2, "expected", "cannot be read"),
            ("h = [\"x1\"]", "h = [\"x1 + x3\"]", 3, "there is no `x3`: there are 2 states", "cannot be read"),
            ("h = [\"x1\"]", "h = [\" \"]", 3, "entry 1 of `h` is empty", "a text"),
            ("h = [\"x1\"]", "h = [3]", 3, "entry 1 of `h` is 3", "a text"),
            ("h = [\"x1\"]\n", "", 1, "but no `h`", "one expression for each output"),
            ("k = 2.0", "k = 2.0, x1 = 3", 4, "`x1` cannot be the name of a parameter: it is a state", "another name"),
            ("k = 2.0", "k = nan", 4, "the parameter `k` is NaN", "finite"),
            ("\"x2\"", "\"1/(x2 - 1)\"", 6, "the plant is not defined at x0", "finite"),
            ("\"x2\"", "\"ln(x2 - 1)\"", 6, "the plant is not defined at x0", "finite"),
            (
                "decay_rate = 1",
                "region = { states = [[0, 1]] }",
                10,
                "`states` has 1 pair, and the plant has 2 states",
                "expected 2",
            ),
            ("decay_rate = 1", "region = { states = [[0, 1], [1, 0]] }", 10, "from 1 to 0", "lower <= upper"),
            ("decay_rate = 1", "region = { states = [[0, 1], [1]] }", 10, "pair 2 of `states`", "[lower, upper]"),
            (
                "decay_rate = 1",
                "decay_rate = 1\nfastest = 2",
                11,
                "`fastest` conflicts with `decay_rate`",
                "expected one of",
            ),
        ],
    );
    let deep = NONLINEAR.replace("sin(x1)", &format!("{}x1{}", "(".repeat(500), ")".repeat(500)));
    assert!(mistakes(&deep)[0].message.contains("nested too deeply"));
    // The markers are under the wrong part of the expression, not under the whole text.
    let error = read(&NONLINEAR.replace("sin(x1)", "sinn(x1)"), Format::Toml).unwrap_err().to_string();
    assert!(error.contains("f = [\"x2\", \"-k*sinn(x1) + u1\"]\n  |                ^^^^ this"), "{error}");
    let undefined = "[plant]\nf = [\"u1\"]\nh = [\"x1\"]\n[input]\nexpressions = [\"1/(t - 1)\"]\n[simulation]\nx0 = [0]\nduration = 2\n";
    assert!(mistakes(undefined)[0].message.contains("at t = 1"), "{:?}", mistakes(undefined));
}

#[test]
pub(crate) fn kinds_of_observers() {
    let with = |observer: &str| NONLINEAR.replace("kind = \"lpv\"\ndecay_rate = 1", observer);
    for (observer, message, expected) in [
        ("kind = \"lipschitz\"\na = [[0, 1], [0, 0]]", "`a` alone", "both, or neither"),
        ("kind = \"lipschitz\"\na = [[0, 1], [0, 0]]\nsectors = []", "`sectors` is an empty list", "tables"),
        (
            "kind = \"lipschitz\"\na = [[0, 1], [0, 0]]\nsectors = [{ g = [[0], [1]], h = [[1, 0]], low = 2, high = 1 }]",
            "the sector goes from 2 to 1",
            "low <= high",
        ),
        ("kind = \"mean-value\"\ninternal_error = [1]", "`internal_error` has length 1", "expected length 2"),
        (
            "kind = \"mean-value\"\nas_printed = \"root\"\ndecay_rate = 1",
            "`decay_rate` has no effect: the observer as printed has no gain to be designed",
            "without `as_printed`",
        ),
        ("kind = \"mean-value\"\nas_printed = \"roots\"", "`as_printed` is the text \"roots\"", "least-squares"),
        ("kind = \"high-gain\"\nr = 0.1\nchains = [1]", "`chains` is [1], and the plant has 2 states", "add to 2"),
        ("kind = \"high-gain\"\nr = 0.1\nalpha = [1]", "`alpha` has length 1", "expected length 2"),
        ("kind = \"high-gain\"", "has no `r`", "positive"),
        (
            "kind = \"extended-kalman\"\nw = 1\nv = [1, 2]\nperiod = 0.1",
            "the diagonal `v` has length 2",
            "expected length 1: the plant has 1 output",
        ),
        ("kind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0", "`period` is 0", "positive"),
        (
            "kind = \"kkl-numerical\"\ncutoff = 1\ndomain = [[0, 1], [0, inf]]",
            "pair 2 of `domain` is from 0 to inf",
            "finite ends",
        ),
    ] {
        let found = mistakes(&with(observer));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].message.contains(message), "{found:?}");
        assert!(format!("{} {:?}", found[0].expected, found[0].help).contains(expected), "{found:?}");
    }
}

#[test]
pub(crate) fn files_that_a_study_names() {
    let log = |file: &str, more: &str| {
        format!(
            "[plant]\na = [[0]]\nb = [[1]]\nc = [[1]]\ninputs = [\"voltage\"]\noutputs = [\"angle\"]\n[log]\nfile = \"{file}\"\n{more}"
        )
    };
    assert!(read(&log("measured-log.csv", ""), Format::Toml).is_ok());
    let said = |text: &str| mistakes(text)[0].message.clone();
    assert!(said(&log("absent.csv", "")).contains("absent.csv cannot be read"));
    assert!(said(&log("measured-log.csv", "time = \"time\"")).contains("there is no column `time`"));
    assert!(said(&log("measured-log.csv", "outputs = [\"angel\"]")).contains("did you mean `angle`?"));
    assert!(
        said(&log("measured-log.csv", "inputs = [\"voltage\", \"t\"]"))
            .contains("2 columns, and the plant has 1 input")
    );
    assert!(said(&log("double-integrator.toml", "")).contains("double-integrator.toml: "));
    let states = |states: &str| said(&log("measured-log.csv", &format!("states = {states}")));
    assert!(states("[\"-\", \"-\"]").contains("`states` has 2 columns, and the plant has 1 state"));
    assert!(states("[\"sped\"]").contains("there is no column `sped`; the columns are t, voltage, angle"));
    assert!(read(&log("measured-log.csv", "states = [\"angle\"]"), Format::Toml).is_ok());
    assert!(
        said(&log("measured-log.csv", "interpolation = \"cubic\"")).contains("`interpolation` is the text \"cubic\"")
    );
}

#[test]
pub(crate) fn grammar() {
    for (text, line, message) in [
        ("[plant\na = 1\n", 1, ""),
        ("[plant]\na = [[0, 1], [0, 0]\nc = [[1, 0]]\n", 3, ""),
        ("[plant]\na = 1\na = 2\n", 3, "duplicate key"),
        ("title = \"a", 1, ""),
    ] {
        let found = mistakes(text);
        assert!(
            found.iter().any(|mistake| mistake.line == line && mistake.message.contains(message)),
            "{text}: {found:?}"
        );
    }
    let json = |text: &str| match read(text, Format::Json) {
        Err(StudyError::File(diagnostics)) => diagnostics.located(),
        other => panic!("{other:?}"),
    };
    assert_eq!(json("{\n  \"plant\": {\n    \"a\": [[0],]\n  }\n}")[0].line, 3);
    assert!(json("").iter().any(|mistake| mistake.message.contains("empty")));
    let twice = json("{\"plant\": {\"builtin\": \"chaotic\", \"builtin\": \"cuk\"}}");
    assert!(twice[0].message.contains("a second time"), "{twice:?}");
    assert!(json("{\"plant\": null}")[0].message.contains("[plant] is null"));
    assert!(json("[1]")[0].message.contains("the study is a list"));
    assert_eq!(json("{\"plant\": {\n\"bultin\": \"cuk\"}}")[0].help.as_deref(), Some("the nearest key is `builtin`"));
}

#[test]
pub(crate) fn json_says_the_same_as_toml() {
    let text = r#"{"plant": {"f": ["x2", "-k*sin(x1) + u1"], "h": ["x1"], "parameters": {"k": 2.0}},
        "simulation": {"x0": [1, 1], "duration": 2}, "observer": [{"kind": "lpv", "decay_rate": 1, "region": {"states": [["-inf", "inf"], [-1, 1]]}}]}"#;
    let (json, toml) = (read(text, Format::Json).unwrap(), read(NONLINEAR, Format::Toml).unwrap());
    assert_eq!(json.simulation, toml.simulation);
    assert_eq!(json.observers[0].name, toml.observers[0].name);
    assert_eq!(json.plant.inputs, toml.plant.inputs);
}

/// Names that file systems refuse, or labels cannot show.
#[test]
pub(crate) fn long_names() {
    let long = "n".repeat(300);
    let edits = [
        ("name = \"one\"", format!("name = \"{long}\""), 13, "`name` has 300 characters"),
        ("c = [[1, 0]]", format!("c = [[1, 0]]\nstates = [\"a\", \"{long}\"]"), 6, "entry 2 of `states` has 300"),
        ("c = [[1, 0]]", format!("c = [[1, 0]]\noutputs = [\"{long}\"]"), 6, "entry 1 of `outputs` has 300"),
        ("c = [[1, 0]]", format!("c = [[1, 0]]\ntime_unit = \"{long}\""), 6, "`time_unit` has 300 characters"),
    ];
    for (from, to, line, message) in edits {
        one(STUDY, &[(from, &to, line, message, "expected a name of at most 100 characters")]);
    }
    let parameter = NONLINEAR.replace("k = 2.0", &format!("k = 2.0, {long} = 1"));
    assert!(mistakes(&parameter)[0].message.contains("the name of a parameter has 300 characters"));
    // 100 characters, and characters that no file name can have, are no mistake.
    for name in ["n".repeat(100), "a/b\\\\c: \u{e9}".to_owned()] {
        assert!(read(&STUDY.replace("name = \"one\"", &format!("name = \"{name}\"")), Format::Toml).is_ok());
    }
    // The log of one observer and the simulation of another would be written to one file.
    let both = STUDY.replace("name = \"two\"", "name = \"log-one\"") + "[log]\nfile = \"measured-log.csv\"\n";
    let both = both.replace("b = [[0], [1]]", "b = [[0], [1]]\ninputs = [\"voltage\"]\noutputs = [\"angle\"]");
    assert!(mistakes(&both)[0].message.contains("\"one\" and \"log-one\" give the same file names"));
}

#[test]
pub(crate) fn several_mistakes_at_once_in_the_order_of_the_file() {
    let text =
        STUDY.replace("duration = 2", "duration = 0").replace("poles =", "pols =").replace("x0 = [1, 1]", "x0 = [1]");
    let lines: Vec<usize> = mistakes(&text).iter().map(|mistake| mistake.line).collect();
    assert_eq!(lines.iter().filter(|line| [9, 10, 15, 19].contains(line)).count(), lines.len());
    assert!(lines.is_sorted() && lines.len() >= 4, "{lines:?}");
}

#[test]
pub(crate) fn a_step_says_what_it_needs() {
    let study = read("[plant]\nbuiltin = \"double-integrator\"\n", Format::Toml).unwrap();
    for (step, needs) in
        [(Step::Design, "an [[observer]]"), (Step::Simulate, "an [[observer]]"), (Step::Sweep, "an [[observer]]")]
    {
        let error = execute(&study, step, &RunOptions::default()).unwrap_err().to_string();
        assert_eq!(error, format!("{} needs {needs}, and the study has none", step.name()));
    }
    let designed = read(
        "[plant]\nbuiltin = \"double-integrator\"\n[[observer]]\nkind = \"luenberger\"\nlmi = true\n",
        Format::Toml,
    )
    .unwrap();
    for (step, needs) in [
        (Step::Simulate, "a [simulation] or a [log]"),
        (Step::Compare, "a [simulation] or a [log]"),
        (Step::Sweep, "a [sweep]"),
    ] {
        let error = execute(&designed, step, &RunOptions::default()).unwrap_err().to_string();
        assert_eq!(error, format!("{} needs {needs}, and the study has none", step.name()));
    }
    assert!(execute(&designed, Step::Run, &RunOptions::default()).unwrap().failures().is_empty());
    let absent = Study::from_path(Path::new("absent.toml")).unwrap_err();
    assert!(absent.to_string().starts_with("absent.toml: "));
    let hint = luenberger_study::template::template("duffin").unwrap_err().to_string();
    assert!(hint.contains("the nearest is \"duffing\""), "{hint}");
}

/// The failure of the observer of a study: hypothesis, then alternatives.
fn refusal(text: &str) -> (String, String) {
    let study = read(text, Format::Toml).unwrap_or_else(|error| panic!("{error}"));
    let results = execute(&study, Step::Design, &messages::all_alternatives()).unwrap();
    assert_eq!(results.failures().len(), 1);
    let failure = results.observers[0].failure.clone().unwrap_or_else(|| panic!("{:?} fits", results.observers[0]));
    messages::refusal(&failure);
    (failure.hypothesis.clone(), failure.advice().join("; "))
}

#[test]
pub(crate) fn an_observer_that_does_not_fit_says_which_hypothesis_fails_and_what_would_fit() {
    let nonlinear = |observer: &str| NONLINEAR.replace("kind = \"lpv\"\ndecay_rate = 1", observer);
    let linear = |plant: &str, observer: &str| format!("[plant]\n{plant}\n[[observer]]\n{observer}\n");
    for (text, hypothesis, alternative) in [
        (
            nonlinear("kind = \"cubic\"\npoles = [-1, -2]\ngamma = 1"),
            "needs a linear plant, x' = A x + B u and y = C x + D u, and this one is nonlinear: `sin(x1)` in f2",
            "lpv",
        ),
        (
            linear("builtin = \"chaotic\"", "kind = \"kalman\"\nw = 1\nv = 1"),
            "`chaotic` is nonlinear",
            "extended-kalman",
        ),
        (linear("f = [\"1 - x1\"]\nh = [\"x1\"]", "kind = \"luenberger\"\nlmi = true"), "a constant term", ""),
        // The second state is neutrally stable and unobservable.
        (
            linear(
                "a = [[-1, 0], [0, 0]]\nc = [[1, 0]]\nstates = [\"seen\", \"bias\"]",
                "kind = \"luenberger\"\npoles = [-1, -2]",
            ),
            "unobservable modes at 0 along bias",
            "no observer exists",
        ),
        // A gain of one's own for such a plant.
        (
            linear("a = [[-1, 0], [0, 2]]\nc = [[1, 0]]", "kind = \"luenberger\"\ngain = [[3], [0]]"),
            "is not Hurwitz",
            "no observer exists: add an output that depends on its unobservable modes, 2 along x2 (margin 0)",
        ),
        (
            linear("a = [[-1, 0], [0, -3]]\nc = [[1, 0]]", "kind = \"luenberger\"\npoles = [-1, -2]"),
            "unobservable modes at -3 along x2",
            "the plant is detectable",
        ),
        (
            linear("a = [[0, 1], [0, 0]]\nc = [[1, 0]]", "kind = \"luenberger\"\ngain = [[-1], [0]]"),
            "is not Hurwitz",
            "lmi = true in place of gain",
        ),
        (
            nonlinear("kind = \"kkl-numerical\"\ncutoff = 1\ndomain = [[-1, 1], [-1, 1]]"),
            "this plant has 1 input",
            "lpv",
        ),
        (
            linear(
                "builtin = \"chaotic\"",
                "kind = \"kkl-numerical\"\ncutoff = 1\ndomain = [[-1, 1], [-1, 1], [-1, 1]]",
            ),
            "this plant has 2 outputs",
            "extended-kalman",
        ),
        (
            linear("f = [\"x2\", \"-x1^3\"]\nh = [\"x2\"]", "kind = \"mean-value\"\ndecay_rate = 1"),
            "outputs that are the first states",
            "extended-kalman",
        ),
        (
            linear("f = [\"x2\", \"-x1^3\"]\nh = [\"x1\", \"x2\"]", "kind = \"mean-value\"\ndecay_rate = 1"),
            "this plant measures 2 of 2",
            "extended-kalman",
        ),
        (
            linear("f = [\"x2 + x3\", \"x3\", \"-x1^3\"]\nh = [\"x1\"]", "kind = \"high-gain\"\nr = 0.1"),
            "x1' depends on x3",
            "extended-kalman",
        ),
        (
            linear("f = [\"x1^2\", \"-x1^3\"]\nh = [\"x1\"]", "kind = \"high-gain\"\nr = 0.1"),
            "x1' does not depend on x2",
            "extended-kalman",
        ),
        (
            linear("f = [\"x2\", \"-x1^3\"]\nh = [\"x2\"]", "kind = \"high-gain\"\nr = 0.1"),
            "chains that begin at the outputs",
            "",
        ),
        (
            linear("f = [\"x2\", \"-x1^3\"]\nh = [\"x1\"]", "kind = \"lpv\"\ndecay_rate = 1"),
            "bounded over the region",
            "`region`",
        ),
        (
            linear("f = [\"x2\", \"-sin(x1)\"]\nh = [\"sin(x1)\"]", "kind = \"lipschitz\"\ndecay_rate = 1"),
            "outputs that are linear in the state",
            "extended-kalman",
        ),
        (
            linear(
                "f = [\"x1*x1\", \"-x2\"]\nh = [\"x2\"]",
                "kind = \"lpv\"\nregion = { states = [[1, 2], [-1, 1]] }\ndecay_rate = 1",
            ),
            "x1",
            "extended-kalman",
        ),
    ] {
        let (said, fits) = refusal(&text);
        assert!(said.contains(hypothesis), "{text}\n{said}");
        assert!(fits.contains(alternative), "{text}\n{fits}");
    }
}

/// Scores: a scale fits the states, and there are instants at which all observers can be scored.
#[test]
pub(crate) fn scores() {
    let sampled = STUDY.replace("duration = 2\n", "duration = 2\nscale = [1, 2]\nscore_period = 0.1\n")
        + "[[observer]]\nname = \"three\"\nkind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.1\n";
    one(
        &sampled,
        &[
            (
                "scale = [1, 2]",
                "scale = [1]",
                11,
                "`scale` has length 1, and the plant has 2 states",
                "expected length 2",
            ),
            ("scale = [1, 2]", "scale = [1, 0]", 11, "entry 2 of `scale` is 0", "positive"),
            (
                "score_period = 0.1",
                "score_period = 0.03",
                12,
                "finer than the samples of an observer, every 0.1",
                "at least 0.1",
            ),
            ("score_period = 0.1", "score_period = 0", 12, "`score_period` is 0", "positive"),
        ],
    );
    let two = sampled.replace("score_period = 0.1\n", "")
        + "[[observer]]\nname = \"four\"\nkind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.1\n";
    let edit = (
        "name = \"four\"\nkind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.1",
        "name = \"four\"\nkind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.07",
    );
    one(
        &two,
        &[(edit.0, edit.1, 8, "the sampling periods 0.1 and 0.07 have no common multiple", "expected `score_period`")],
    );
}

/// Numbers of a study that a sweep varies: their names, and values with which the study is no study.
#[test]
pub(crate) fn swept_numbers() {
    let text = format!("{NONLINEAR}[sweep]\nparameter = \"plant.k\"\nvalues = [1, 2]\n");
    one(
        &text,
        &[
            (
                "plant.k",
                "plant.kk",
                12,
                "`parameter` is \"plant.kk\", which is no number of the study",
                "the nearest is \"plant.k\"",
            ),
            ("plant.k", "observer.lpv.rate", 12, "which is no number", "observer.lpv.decay_rate"),
            (
                "\"plant.k\"\nvalues = [1, 2]",
                "\"simulation.duration\"\nvalues = [1, -2]",
                13,
                "with simulation.duration = -2: `duration` is -2",
                "positive",
            ),
            (
                "\"plant.k\"\nvalues = [1, 2]",
                "\"plant.k\"\nfrom = -1\nto = 2",
                13,
                "`from` is -1",
                "spacing = \"linear\"",
            ),
            (
                "\"plant.k\"\nvalues = [1, 2]",
                "\"initial\"\nvalues = [1, 0]",
                13,
                "entry 2 of `values` is 0",
                "positive",
            ),
        ],
    );
}

#[test]
pub(crate) fn other_plants() {
    let text = format!("{NONLINEAR}[truth]\nparameters = {{ k = 3 }}\n[[truth.event]]\nat = 1\njump = [1, 0]\n");
    one(
        &text,
        &[
            ("parameters = { k = 3 }", "a = [[1]]", 12, "`a` is a matrix, and the plant has no matrices", "`f` or `h`"),
            ("parameters = { k = 3 }", "f = [\"x2\"]", 12, "`f` has length 1", "each state, 2"),
            ("parameters = { k = 3 }", "f = [\"x2\", \"x3\"]", 12, "with `f` of the simulated plant: ", ""),
            (
                "parameters = { k = 3 }",
                "parameters = { k = \"x1\" }",
                12,
                "with `parameters` of the simulated plant: ",
                "",
            ),
            ("at = 1\n", "", 13, "[[truth.event]] has no `at`", ""),
            ("at = 1", "at = -1", 14, "`at` is -1", "positive"),
            ("jump = [1, 0]", "", 13, "the event changes nothing", "expected `jump`, or another plant"),
            ("jump = [1, 0]", "jump = [1]", 15, "`jump` has length 1, and the plant has 2 states", "length 2"),
            (
                "at = 1",
                "at = 1\njump = [1, 1]\n[[truth.event]]\nat = 0.5",
                17,
                "the event at t = 0.5 follows that at t = 1",
                "in the order of their times",
            ),
        ],
    );
    let linear = STUDY.replace("[plot]", "[truth]\nb = [[0], [2]]\n[plot]");
    one(
        &linear,
        &[
            (
                "b = [[0], [2]]",
                "b = [[0, 1], [2, 0]]",
                22,
                "the plant has 2 states, 2 inputs and 1 output with `b`",
                "1 input and",
            ),
            ("b = [[0], [2]]", "b = [[0]]", 22, "with `b` of the simulated plant: `b` is 1 x 1", ""),
            (
                "b = [[0], [2]]",
                "parameters = { m = 1 }",
                22,
                "the plant has no parameter `m`",
                "a plant of matrices has no parameters",
            ),
            ("b = [[0], [2]]", "f = [\"x2\", \"u1\"]", 22, "`f` without `h`", "expected both"),
            (
                "b = [[0], [2]]",
                "a = [[1]]\nf = [\"x2\", \"u1\"]",
                23,
                "`f` conflicts with `a`",
                "expected matrices, or",
            ),
        ],
    );
    let library = "[plant]\nbuiltin = \"van-der-pol\"\n[simulation]\nx0 = [1, 0]\nduration = 1\n[truth]\ndropout = 0\nperiod = 1\n";
    one(
        library,
        &[
            (
                "dropout = 0",
                "parameters = { m = 1 }",
                7,
                "the plant has no parameter `m`",
                "a plant of the library has fixed constants",
            ),
            ("dropout = 0", "h = [\"x2\"]", 7, "`h` without `f`", "expected both `f` and `h`"),
        ],
    );
}

#[test]
pub(crate) fn truth() {
    let text = format!(
        "{NONLINEAR}[truth]\nparameters = {{ k = 3 }}\ndropout = 0.1\nperiod = 0.1\nsensor = {{ bias = [1] }}\n"
    );
    one(
        &text,
        &[
            ("{ k = 3 }", "{ kk = 3 }", 12, "the plant has no parameter `kk`", "expected one of k"),
            ("dropout = 0.1", "dropout = 1.1", 13, "`dropout` is 1.1", "a probability from 0 to 1"),
            ("period = 0.1\n", "", 11, "`dropout` and `outliers` are drawn every period", "simulation.noise"),
            ("bias = [1]", "bias = [1, 2]", 15, "`bias` has length 2, and the plant has 1 output", "expected length 1"),
            ("dropout = 0.1", "input_delay = -1", 13, "`input_delay` is -1", "not negative"),
            (
                "dropout = 0.1",
                "process_noise = { amplitude = [1], period = 1 }",
                13,
                "`amplitude` has length 1, and the plant has 2 states",
                "expected length 2",
            ),
        ],
    );
}
