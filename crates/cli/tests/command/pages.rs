//! The examples in the pages of `docs` and in the READMEs are run, and their output is compared with the pages. Every
//! block of code is run or read by a test, or listed in [`ELSEWHERE`] with the reason why not. `UPDATE=1` writes
//! outputs that differ into the pages, but for those with `[..]`; read the difference.

use crate::terminal::{folder, luenberger, run, without_estimate};
use luenberger_study::{Format, Study};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Keys whose values depend on the machine.
const ANYTHING: &str = "[..]";

/// Residuals are rounding errors: any two below this count as equal.
const ZERO: f64 = 1e-12;

/// The first lines of a study, which a block without a name continues: the plant that its page has in mind.
const SECOND_ORDER: &str = "[plant]\na = [[-1, 2], [-3, -1]]\nb = [[1], [0]]\nc = [[1, 0]]\n\
                            [simulation]\nx0 = [1, 0]\nduration = 1\n";

const BATTERY: &str = "[plant]\nstates = [\"soc\", \"v1\", \"v2\", \"temp\"]\noutputs = [\"voltage\", \"temperature\"]\n\
                       f = [\"-soc\", \"-v1\", \"-v2\", \"-temp\"]\nh = [\"soc\", \"temp\"]\n\
                       [log]\nfile = \"log.csv\"\n";

const TANKS: &str = "[plant]\nstates = [\"upper\", \"lower\"]\ninputs = [\"pump\"]\noutputs = [\"level\"]\n\
                     f = [\"pump - upper\", \"upper - lower\"]\nh = [\"lower\"]\n\
                     [[observer]]\nkind = \"extended-kalman\"\nw = 1\nv = 1\nperiod = 0.1\n";

const ONE_STATE: &str = "[plant]\nstates = [\"i1\"]\ninputs = [\"duty\"]\nf = [\"duty - i1\"]\nh = [\"i1\"]\n\
                         [simulation]\nx0 = [1]\nduration = 2\n";

const LIMITED_GAIN: &str = "[plant]\na = [[-1, 2], [-3, -1]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\n";

const PEBO: &str = "[plant]\nstates = [\"x1\", \"x2\"]\nf = [\"x2\", \"-x1\"]\nh = [\"x1\"]\n\
                    [simulation]\nx0 = [1, 0]\nduration = 20\n\
                    [[observer]]\nkind = \"pebo\"\nphi = [\"x2\"]\nb = [\"-y1\"]\nleft_inverse = [\"y1\", \"xi1\"]\n\
                    region = { states = [[-2, 2], [-2, 2]] }\ns = [\"y1\"]\ng = [\"xi1\"]\nm = [[1]]\nalpha = 1\n\
                    estimator = { kind = \"gradient\", gain = 1 }\n";

/// The plant of the template `attitude`, without a simulation.
const GYROSCOPES: &str = "[plant]\nstates = [\"q0\", \"q1\", \"q2\", \"q3\", \"b1\", \"b2\", \"b3\"]\nf = [\"0\", \"0\", \"0\", \"0\", \"0\", \"0\", \"0\"]\nh = [\"q0\", \"q1\", \"q2\", \"q3\", \"b1\", \"b2\"]\n";

/// Blocks of TOML without a name are parts of studies. Each is found by its page and a line, and is read behind the
/// lines of the third column.
const PARTS: [(&str, &str, &str); 22] = [
    ("attitude.md", "kind = \"error-state-kalman\"", GYROSCOPES),
    ("commands/design.md", "max_gain = 50", LIMITED_GAIN),
    ("cubic-or-linear.md", "kind = \"optimal-cubic\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"cubic\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"h-infinity\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"luenberger\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"proportional-integral\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"extended-state\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"unknown-input\"", SECOND_ORDER),
    ("disturbances.md", "kind = \"interval\"", SECOND_ORDER),
    (
        "expressions.md",
        "[plant.tables.voltage]",
        "[plant]\nstates = [\"soc\", \"temp\"]\nf = [\"0\", \"0\"]\nh = [\"voltage(soc, temp)\"]\n",
    ),
    ("feedback.md", "[input]", SECOND_ORDER),
    ("filters.md", "kind = \"ukf\"", SECOND_ORDER),
    ("filters.md", "kind = \"extended-kalman\"", BATTERY),
    ("filters.md", "kind = \"iterated-extended-kalman\"", SECOND_ORDER),
    ("filters.md", "kind = \"mhe\"", SECOND_ORDER),
    ("guide.md", "file = \"monday.csv\"", TANKS),
    ("kkl-studies.md", "reset = { period = 10 }", PEBO),
    ("kkl-studies.md", "[input]", ONE_STATE),
    ("log.md", "name = \"EKF\"", ""),
    ("reduced-order.md", "kind = \"reduced-order\"", SECOND_ORDER),
    ("reduced-order.md", "kind = \"functional\"", ""),
];

/// Blocks that no test of this file runs, by their page and first line, with the reason.
const ELSEWHERE: [(&str, &str, &str); 27] = [
    ("../README.md", "import control", "crates/python/tests/test_pages.py runs it"),
    ("../README.md", "cargo xtask reproduce", "continuous integration runs it; a test of xtask reads the arguments"),
    ("certificates.md", "cargo run --example certificate ", "builds programs that the tests of luenberger-proof run"),
    ("certificates.md", "cargo run --release -p luenberger-lmi", "builds programs that the tests of their crates run"),
    ("certificates.md", "{", "the tests of luenberger-proof compare it with a file that they write"),
    ("commands/index.md", "cargo install --locked", "builds the program under test"),
    (
        "commands/stream.md",
        "stty -F /dev/ttyUSB0",
        "needs a serial port and another machine; the tests of `stream` pipe rows",
    ),
    ("commands/sweep.md", "import glob, numpy as np", "needs numpy; the tests of `sweep` read the same arrays"),
    ("cubic-or-linear.md", "cargo run --release -p luenberger-study", "computes the figure of the page, in minutes"),
    ("deploy.md", "cd tanks-c", "`cargo xtask deploy` does the same, with several compilers"),
    ("deploy.md", "cmake -S . -B build", "`cargo xtask deploy` does the same"),
    ("deploy.md", "cd tanks-fmu", "needs fmpy from the network: `cargo xtask deploy` does the same"),
    ("deploy.md", "cargo test --config", "builds a crate: `cargo xtask deploy` does the same"),
    ("deploy.md", "#include \"one_gain.h\"", "a part of a program for a board"),
    ("deploy.md", "void link_step(", "declarations, which the tests of luenberger-export compile"),
    ("deploy.md", "block_input(&state, r, u);", "two lines of a program"),
    ("deploy.md", "void when_the_gps_has_arrived(", "a part of a program; the golden tests of exports call the halves"),
    ("guide.md", "cargo install --locked", "builds the program under test"),
    ("log.md", "nc -l 9000", "needs another machine; the tests of `stream` pipe rows"),
    ("proofs.md", "RUSTC_BOOTSTRAP=1", "builds a fuzzer, a workspace of its own"),
    ("python.md", "$ pip install ./crates/python", "`cargo xtask python` installs the package"),
    ("python.md", "import control", "crates/python/tests/test_pages.py runs it"),
    ("python.md", "from distributed import Client", "the tests of crates/python run sweeps on a cluster of Dask"),
    ("python.md", "study = luenberger.Study", "crates/python/tests/test_pages.py runs it"),
    ("python.md", "tuned = study.tune()", "crates/python/tests/test_pages.py runs it"),
    ("python.md", "car = luenberger.plant(", "crates/python/tests/test_pages.py runs it"),
    ("python.md", "try:", "crates/python/tests/test_pages.py runs it"),
];

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// The pages of `docs` and the READMEs with examples, by their paths from `docs`.
fn pages() -> BTreeMap<String, String> {
    let names = |folder: &str| {
        let entries = std::fs::read_dir(docs().join(folder)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names
            .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "md"))
            .map(|name| format!("{folder}{name}"))
            .collect::<Vec<_>>()
    };
    let readmes = ["../README.md", "../crates/cli/README.md"].map(str::to_owned);
    let names = names("").into_iter().chain(names("commands/")).chain(readmes);
    names.map(|name| (name.clone(), std::fs::read_to_string(docs().join(name)).unwrap())).collect()
}

/// A block of code: what follows its first backticks, and its lines.
struct Block {
    info: String,
    lines: Vec<String>,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open = None;
    for line in page.lines() {
        match (line.trim_start().strip_prefix("```"), &mut open) {
            (Some(info), None) => open = Some(Block { info: info.to_owned(), lines: Vec::new() }),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.lines.push(line.to_owned()),
            (None, None) => {}
        }
    }
    blocks
}

/// The commands of a page, each with the lines that follow it. The lines of a block "```toml NAME" are appended to the
/// file of that name. In a block "```sh" the commands `luenberger` are run and must succeed.
fn examples(page: &str) -> Vec<(String, Vec<String>)> {
    let mut examples: Vec<(String, Vec<String>)> = Vec::new();
    let (mut is_inside, mut is_file, mut is_shell) = (false, false, false);
    for line in page.lines() {
        if line.starts_with("```") {
            if is_file {
                examples.last_mut().expect("a file that was begun").0 += "END";
            }
            is_inside = line == "```console";
            is_shell = line == "```sh";
            is_file = line.starts_with("```toml ");
            if let Some(name) = line.strip_prefix("```toml ") {
                examples.push((format!("cat >> {name} << 'END'\n"), Vec::new()));
            }
        } else if is_file {
            let file = &mut examples.last_mut().expect("a file that was begun").0;
            file.extend([line, "\n"]);
        } else if is_shell && line.starts_with("luenberger ") {
            examples.push((format!("{{ {line}\n}} > out 2>&1 || cat out"), Vec::new()));
        } else if let (true, Some(command)) = (is_inside, line.strip_prefix("$ ")) {
            examples.push((command.to_owned(), Vec::new()));
        } else if is_inside {
            examples.last_mut().expect("a command before its output").1.push(line.to_owned());
        }
    }
    examples
}

/// A line as words and numbers, without the spaces between them.
#[derive(Debug, PartialEq)]
enum Token {
    Text(char),
    Number(f64),
}

fn tokens(line: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut rest = line.trim();
    let mut before = ' ';
    while let Some(first) = rest.chars().next() {
        let is_number = first.is_ascii_digit() || (first == '-' && rest[1..].starts_with(|c: char| c.is_ascii_digit()));
        // A digit within a word, such as x1, belongs to the word.
        if is_number && !before.is_alphanumeric() {
            let bytes = rest.as_bytes();
            let is_part = |i: usize, c: char| {
                c.is_ascii_digit() || c == '.' || c == 'e' || (c == '-' && (i == 0 || bytes[i - 1] == b'e'))
            };
            let end = rest.char_indices().find(|(i, c)| !is_part(*i, *c)).map_or(rest.len(), |(i, _)| i);
            if let Ok(number) = rest[..end].parse() {
                tokens.push(Token::Number(number));
                rest = &rest[end..];
                before = '0';
                continue;
            }
        }
        if !first.is_whitespace() {
            tokens.push(Token::Text(first));
        }
        before = first;
        rest = &rest[first.len_utf8()..];
    }
    tokens
}

fn is_same(found: &Token, expected: &Token) -> bool {
    match (found, expected) {
        (Token::Number(x), Token::Number(y)) => {
            (x - y).abs() <= 1e-5 * x.abs().max(y.abs()) || (x.abs() < ZERO && y.abs() < ZERO)
        }
        _ => found == expected,
    }
}

fn is_line(found: &str, expected: &str) -> bool {
    match expected.split_once(ANYTHING) {
        None => {
            let (found, expected) = (tokens(found), tokens(expected));
            found.len() == expected.len() && found.iter().zip(&expected).all(|(x, y)| is_same(x, y))
        }
        Some((head, tail)) => {
            let (tokens, head) = (tokens(found), tokens(head));
            let is_begun = tokens.len() >= head.len() && tokens.iter().zip(&head).all(|(x, y)| is_same(x, y));
            is_begun && found.trim_end().ends_with(tail.trim_end())
        }
    }
}

/// A line `[..]` stands for any number of lines.
fn is_output(found: &[&str], expected: &[String]) -> bool {
    match (found, expected) {
        ([], []) => true,
        (_, [any, rest @ ..]) if any == ANYTHING => (0..=found.len()).any(|skip| is_output(&found[skip..], rest)),
        ([line, found @ ..], [pattern, expected @ ..]) => is_line(line, pattern) && is_output(found, expected),
        _ => false,
    }
}

#[test]
fn every_example_does_what_its_page_says() {
    let binary = Path::new(env!("CARGO_BIN_EXE_luenberger")).parent().unwrap().to_owned();
    let (mut count, mut wrong) = (0, String::new());
    let update = std::env::var_os("UPDATE").is_some();
    for (name, mut page) in pages() {
        let examples = examples(&page);
        // What pip installs is tested by `cargo xtask python`.
        if examples.is_empty() || name == "python.md" {
            continue;
        }
        let here = folder(&format!("page-{}", name.replace(['/', '.'], "-")));
        // The pages name the example of a battery as from the root of the repository.
        let battery = Path::new("examples/studies/battery");
        std::fs::create_dir_all(here.join(battery)).unwrap();
        for file in ["battery.toml", "log.csv", "raw.csv"] {
            std::fs::copy(docs().join("..").join(battery).join(file), here.join(battery).join(file)).unwrap();
        }
        let path = std::env::join_paths(
            [binary.clone()].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
        );
        for (command, expected) in examples {
            count += 1;
            let mut shell = Command::new("sh");
            shell
                .arg("-c")
                .arg(format!("{{ {command}\n}} 2>&1"))
                .current_dir(&here)
                .env("PATH", path.as_ref().unwrap());
            let ran = run(&mut shell, b"");
            let found: Vec<&str> = without_estimate(&ran.stdout).collect();
            let is_output = is_output(&found, &expected);
            if !is_output && update && !expected.iter().any(|line| line.contains(ANYTHING)) {
                let shown = |lines: &str| format!("$ {command}\n{lines}\n");
                page = page.replace(&shown(&expected.join("\n")), &shown(&found.join("\n")));
                std::fs::write(docs().join(&name), &page).unwrap();
            } else if !is_output {
                let (found, expected) = (&ran.stdout, expected.join("\n"));
                let pieces = [&name, "\n$ ", &command, "\nprints\n", found, "\nand the page says\n", &expected, "\n\n"];
                wrong.extend(pieces);
            }
        }
        for file in blocks(&page).iter().filter_map(|block| block.info.strip_prefix("toml ")) {
            if let Err(error) = Study::from_path(&here.join(file)) {
                wrong.extend([&name, ": ", file, ": ", &error.to_string(), "\n"]);
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
    assert!(count > 20, "{count} examples");
}

/// A study that the lines of a block complete is read without a mistake. No observer is designed.
#[test]
fn every_part_of_a_study_in_the_pages_is_read() {
    let here = folder("page-parts");
    std::fs::copy(docs().join("../examples/studies/battery/log.csv"), here.join("log.csv")).unwrap();
    std::fs::write(here.join("monday.csv"), "t,pump,level\n0,1,0.5\n0.1,1,0.6\n0.2,1,0.7\n").unwrap();
    let (mut used, mut wrong) = (BTreeSet::new(), Vec::new());
    for (name, page) in pages() {
        for block in blocks(&page).iter().filter(|block| block.info == "toml") {
            let is_this = |line: &str| block.lines.iter().any(|found| found.split(" #").next().unwrap().trim() == line);
            let rows: Vec<_> = PARTS.iter().filter(|(page, line, _)| *page == name && is_this(line)).collect();
            let [(_, line, before)] = rows[..] else {
                wrong.push(format!("{name}: {} rows of PARTS for the block\n{}", rows.len(), block.lines.join("\n")));
                continue;
            };
            used.insert((name.clone(), *line));
            let study = format!("{before}{}\n", block.lines.join("\n"));
            if let Err(error) = Study::from_text(&name, &study, Format::Toml, &here) {
                wrong.push(format!("{error}\n{study}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(used.len(), PARTS.len(), "rows of PARTS without a block: {used:?}");
}

/// A block of a language is run or read by one of the tests here, compiled with the documentation of
/// `tests/src/lib.rs`, or a row of [`ELSEWHERE`].
#[test]
fn every_block_of_the_pages_is_tested() {
    let compiled = include_str!("../../../../tests/src/lib.rs");
    let (mut used, mut untested) = (BTreeSet::new(), Vec::new());
    for (name, page) in pages() {
        for block in blocks(&page) {
            let first = block.lines.iter().find(|line| !line.is_empty()).map_or("", String::as_str);
            let row = ELSEWHERE.iter().position(|(page, start, _)| *page == name && first.starts_with(start));
            used.extend(row);
            let language = block.info.split([' ', ',']).next().unwrap();
            let is_tested = row.is_some()
                || match language {
                    // Formulas and excerpts of output.
                    "" | "text" | "console" | "toml" => true,
                    "sh" => block.lines.iter().any(|line| line.starts_with("luenberger ")),
                    "rust" => compiled.contains(&format!("docs/{name}\")").replace("docs/../", "")),
                    _ => false,
                };
            if !is_tested {
                untested.push(format!("{name}: ```{}\n{first}", block.info));
            }
        }
    }
    assert!(untested.is_empty(), "neither tested nor in ELSEWHERE:\n{}", untested.join("\n"));
    for (row, (page, first, reason)) in ELSEWHERE.iter().enumerate() {
        assert!(used.contains(&row) && !reason.is_empty(), "{page}: no block begins with {first}");
    }
}

/// The words of a line, without the signs around them.
fn words(line: &str) -> impl Iterator<Item = &str> {
    let parts = line.split(|c: char| c.is_whitespace() || "()[]{},;=".contains(c));
    parts.map(|word| word.trim_end_matches(['.', ':', '*']))
}

/// What the guide says of the outputs that it shows: each number of its sentences with a decimal point, or with three
/// digits or more, stands in one of its blocks.
#[test]
fn the_numbers_of_the_guide_are_printed_ones() {
    let page = &pages()["guide.md"];
    let is_number = |word: &&str| {
        let (digits, others): (String, String) = word.chars().partition(char::is_ascii_digit);
        matches!((others.as_str(), digits.trim_matches('0').len()), (".", 1..) | ("", 3..))
    };
    let printed: Vec<String> = blocks(page).into_iter().flat_map(|block| block.lines).collect();
    let printed: BTreeSet<&str> = printed.iter().flat_map(|line| words(line)).collect();
    let mut is_inside = false;
    let mut found = Vec::new();
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            is_inside = !is_inside;
        } else if !is_inside {
            // Code and the targets of links are no sentences.
            let sentences: String = line.split('`').step_by(2).collect();
            found.extend(words(&sentences).filter(is_number).map(str::to_owned));
        }
    }
    assert!(found.len() > 3, "{found:?}");
    let other: Vec<_> = found.iter().filter(|number| !printed.contains(number.as_str())).collect();
    assert!(other.is_empty(), "numbers that no output of the guide has: {other:?}");
}

/// Each crate says how it becomes a dependency, and of which other crates its example is made.
#[test]
fn the_readmes_of_the_crates_say_how_to_add_them() {
    let crates = docs().join("../crates");
    let mut count = 0;
    for entry in std::fs::read_dir(&crates).unwrap() {
        let folder = entry.unwrap().file_name().into_string().unwrap();
        let Ok(readme) = std::fs::read_to_string(crates.join(&folder).join("README.md")) else { continue };
        // The package of Python, and the command.
        let ways = match folder.as_str() {
            "python" => "pip install ./crates/python".to_owned(),
            "cli" => "cargo install --locked --path crates/cli".to_owned(),
            "luenberger" => "cargo add luenberger --path ../luenberger/crates/luenberger".to_owned(),
            _ => format!("cargo add luenberger-{folder} --path ../luenberger/crates/{folder}"),
        };
        assert!(readme.contains(&format!("`{ways}`")), "crates/{folder}/README.md lacks `{ways}`");
        let own = format!("luenberger_{folder}");
        for block in blocks(&readme).iter().filter(|block| block.info == "rust") {
            let code = block.lines.join("\n");
            assert!(!code.contains("use nalgebra::"), "crates/{folder}/README.md: nalgebra of an own version");
            let names = code.split(|c: char| !c.is_alphanumeric() && c != '_');
            for name in names.filter(|name| name.starts_with("luenberger_") && *name != own) {
                let package = name.replace('_', "-");
                assert!(readme.contains(&format!("`{package}`")), "crates/{folder}/README.md does not name {package}");
            }
        }
        count += 1;
    }
    assert!(count > 15, "{count}");
}

/// The commands that `luenberger --help` lists.
fn commands() -> Vec<String> {
    let help = luenberger(&["--help"], "").stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.filter_map(|line| line.split_whitespace().next()).filter(|command| *command != "help");
    names.map(str::to_owned).collect()
}

/// Every command has a page, and the overview names it.
#[test]
fn each_command_has_a_page_with_an_example() {
    let pages = pages();
    let overview = &pages["commands/index.md"];
    for command in commands() {
        let page = &pages[&format!("commands/{command}.md")];
        let has_example = examples(page).iter().any(|(line, _)| line.contains(&format!("luenberger {command}")));
        assert!(has_example, "docs/commands/{command}.md has no example");
        assert!(
            overview.contains(&format!("`{command}`")) && overview.contains(&format!("[{command}.md]")),
            "{command}"
        );
    }
}

/// The examples of `--help` are those of the pages, where [`every_example_does_what_its_page_says`] runs them. A page
/// may write to a file what `--help` lets appear on the screen.
#[test]
fn the_examples_of_help_are_in_the_pages() {
    let files = std::fs::read_dir(docs().join("commands")).unwrap().map(|entry| entry.unwrap().path());
    let known: Vec<_> = files.flat_map(|page| examples(&std::fs::read_to_string(page).unwrap())).collect();
    let below = ["status", "reduce", "script"].map(|command| format!("sweep {command}"));
    for command in commands().into_iter().chain(below) {
        let arguments: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        let help = luenberger(&arguments, "").stdout;
        let lines = help.lines().skip_while(|line| !line.starts_with("Example")).skip(1);
        let block: Vec<&str> = lines.filter_map(|line| line.strip_prefix("  ")).collect();
        let shown = examples(&format!("```console\n{}\n```", block.join("\n")));
        assert!(shown.iter().any(|(line, _)| line.contains(&format!("luenberger {command} "))), "{help}");
        for (line, output) in shown {
            let is_shown = |(known, whole): &(String, Vec<String>)| {
                let whole: Vec<&str> = whole.iter().map(String::as_str).collect();
                *known.trim_end_matches(" > output.txt") == line && (output.is_empty() || is_output(&whole, &output))
            };
            assert!(known.iter().any(is_shown), "luenberger {command} --help\n$ {line}\n{}", output.join("\n"));
        }
    }
}

#[test]
fn the_comparison_sees_what_differs() {
    assert!(is_line("residual 8.6e-17 (relative)", "residual 0 (relative)"));
    assert!(is_line("  -0.333333  1", "-0.3333334   1"));
    assert!(!is_line("-0.3333", "-0.33333"));
    assert!(!is_line("x1 = 2", "x2 = 2") && !is_line("rank 1", "rank 2") && !is_line("[1.0]", "[1.0, 2.0]"));
    assert!(is_line("after 0.1 s (1 run)", "after [..]") && !is_line("before 0.1 s", "after [..]"));
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    assert!(is_output(&["a", "b", "c"], &lines("a\n[..]")) && is_output(&["a"], &lines("a\n[..]")));
    assert!(!is_output(&["a", "b"], &lines("a")) && !is_output(&["a"], &lines("a\nb")));
}
