//! The examples in the pages of `docs/commands`, in the other pages listed here and in the READMEs are run, and their
//! output is compared with the pages.

use crate::terminal::{folder, luenberger, run, without_estimate};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Keys whose values depend on the machine.
const ANYTHING: &str = "[..]";

/// Residuals are rounding errors: any two below this count as equal.
const ZERO: f64 = 1e-12;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

fn pages() -> Vec<PathBuf> {
    let commands = std::fs::read_dir(docs().join("commands")).unwrap().map(|entry| entry.unwrap().path());
    let others = [
        "from-matlab.md",
        "expressions.md",
        "deploy.md",
        "guide.md",
        "kkl-studies.md",
        "log.md",
        "../README.md",
        "../crates/cli/README.md",
    ];
    let mut pages: Vec<_> = commands.chain(others.map(|page| docs().join(page))).collect();
    pages.sort();
    pages
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
    for page in pages() {
        let name = page.file_stem().unwrap().to_string_lossy().into_owned();
        let above = page.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        let here = folder(&format!("page-{above}-{name}"));
        // The pages name the example of a battery as from the root of the repository.
        let battery = Path::new("examples/studies/battery");
        std::fs::create_dir_all(here.join(battery)).unwrap();
        for file in ["battery.toml", "log.csv"] {
            std::fs::copy(docs().join("..").join(battery).join(file), here.join(battery).join(file)).unwrap();
        }
        let path = std::env::join_paths(
            [binary.clone()].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
        );
        for (command, expected) in examples(&std::fs::read_to_string(&page).unwrap()) {
            count += 1;
            let mut shell = Command::new("sh");
            shell
                .arg("-c")
                .arg(format!("{{ {command}\n}} 2>&1"))
                .current_dir(&here)
                .env("PATH", path.as_ref().unwrap());
            let ran = run(&mut shell, b"");
            let found: Vec<&str> = without_estimate(&ran.stdout).collect();
            if !is_output(&found, &expected) {
                let (found, expected) = (&ran.stdout, expected.join("\n"));
                let pieces =
                    [&name, ".md\n$ ", &command, "\nprints\n", found, "\nand the page says\n", &expected, "\n\n"];
                wrong.extend(pieces);
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
    assert!(count > 20, "{count} examples");
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
    let overview = std::fs::read_to_string(docs().join("commands/index.md")).unwrap();
    for command in commands() {
        let page = std::fs::read_to_string(docs().join(format!("commands/{command}.md")));
        let page = page.unwrap_or_else(|error| panic!("docs/commands/{command}.md: {error}"));
        let has_example = examples(&page).iter().any(|(line, _)| line.contains(&format!("luenberger {command}")));
        assert!(has_example, "docs/commands/{command}.md has no example");
        assert!(
            overview.contains(&format!("`{command}`")) && overview.contains(&format!("[{command}.md]")),
            "{command}"
        );
    }
}

/// The examples of `--help` are those of the pages, where [`every_example_does_what_its_page_says`] runs them. A page may
/// write to a file what `--help` lets appear on the screen.
#[test]
fn the_examples_of_help_are_in_the_pages() {
    let files = std::fs::read_dir(docs().join("commands")).unwrap().map(|entry| entry.unwrap().path());
    let known: Vec<_> = files.flat_map(|page| examples(&std::fs::read_to_string(page).unwrap())).collect();
    for command in commands() {
        let help = luenberger(&[&command, "--help"], "").stdout;
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
