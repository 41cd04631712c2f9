//! `luenberger-verify FILE...`: verifies certificate files; all claims are derived again from their data.
//!
//! Depends on `luenberger-proof` alone: no solver, no linear-algebra library, no parser of arguments.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::process::ExitCode;

use luenberger_proof::Verdict;
use luenberger_proof::certificate::{LARGEST_FILE, Number, Proved, Rejection, Theorem, digest, verify};
use luenberger_proof::wording::{is_invisible, visible};

const HELP: &str = "\
luenberger-verify: check certificate files of observers, matrix inequalities and semidefinite programs.

Usage: luenberger-verify [--json] FILE...
       luenberger-verify --digest FILE

Every inequality is evaluated again from the plant's data, without rounding errors, and the statement is derived again in words.
No statement or bound in a file is accepted unchecked. `-` is the standard input.

Options:
  --json     One JSON object per file, each on a line: file, outcome, and title, statement, facts, or why
  --digest   Print the sha256 that the content of FILE should carry, and check nothing
  --help     This text
  --version  The version

Exit status: 0 if every file is proved; 1 if one is rejected; 2 if one cannot be read as JSON, or the arguments make no sense.

Example:
  $ luenberger certify cart.toml -o results > output.txt
  $ luenberger-verify results/certificates/linear.json
  results/certificates/linear.json: Proved
    For the plant x' = Ax + Bu, y = Cx with 2 states, 1 input and 1 output and the observer ...
    P > 0, margin >= 0.7621183
    (A - LC)'P + P(A - LC) < 0 (12), margin >= 9.999999
";

/// What became of one file.
enum Outcome {
    Proved(Box<Proved>),
    Rejected(Box<Rejection>),
    Unreadable(String),
}

impl Outcome {
    fn of(path: &str) -> Self {
        let bytes = match read(path) {
            Ok(bytes) => bytes,
            Err(error) => return Self::Unreadable(error.to_string()),
        };
        match verify(&bytes) {
            Ok(proved) => Self::Proved(Box::new(proved)),
            Err(Rejection::File(error)) if error.is_unreadable() => Self::Unreadable(error.to_string()),
            Err(rejection) => Self::Rejected(Box::new(rejection)),
        }
    }

    fn status(&self) -> u8 {
        match self {
            Self::Proved(_) => 0,
            Self::Rejected(_) => 1,
            Self::Unreadable(_) => 2,
        }
    }

    fn text(&self, path: &str) -> String {
        let path = visible(path);
        match self {
            Self::Proved(proved) => format!("{path}: Proved\n  {}\n", proved.to_string().replace('\n', "\n  ")),
            Self::Rejected(why) => format!("{path}: Rejected\n  {why}\n"),
            Self::Unreadable(why) => format!("{path}: Unreadable\n  {why}\n"),
        }
    }

    fn json(&self, path: &str) -> String {
        let members = match self {
            Self::Proved(proved) => {
                let facts: Vec<String> = proved
                    .facts
                    .iter()
                    .map(|fact| {
                        let margin = match fact.verdict {
                            Verdict::Proved { margin } => Number::from_f64(margin),
                            _ => None,
                        };
                        let margin = margin.map_or_else(|| "null".to_owned(), |margin| quoted(&margin.to_string()));
                        format!("{{\"inequality\":{},\"margin\":{margin}}}", quoted(&fact.inequality))
                    })
                    .collect();
                format!(
                    "\"outcome\":\"proved\",\"title\":{},\"statement\":{},\"facts\":[{}]",
                    quoted(&proved.title),
                    quoted(&proved.statement),
                    facts.join(",")
                )
            }
            Self::Rejected(why) => format!("\"outcome\":\"rejected\",\"why\":{}", quoted(&why.to_string())),
            Self::Unreadable(why) => format!("\"outcome\":\"unreadable\",\"why\":{}", quoted(why)),
        };
        format!("{{\"file\":{},{members}}}\n", quoted(path))
    }
}

/// One byte more than the maximal length of a certificate, to detect longer input.
fn read(path: &str) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let limit = LARGEST_FILE as u64 + 1;
    if path == "-" {
        io::stdin().lock().take(limit).read_to_end(&mut bytes)?;
    } else {
        std::fs::File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

/// A JSON string; characters that are not visible are escaped.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if is_invisible(c) => {
                for half in c.encode_utf16(&mut [0; 2]) {
                    _ = write!(quoted, "\\u{half:04x}");
                }
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// Prints. A reader that has gone is no error; a full disk is, and ends the program.
fn print(text: &str) {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "luenberger-verify: standard output cannot be written: {error}");
            std::process::exit(1);
        }
        _ => {}
    }
}

fn usage(problem: &str) -> ExitCode {
    let _ = writeln!(io::stderr(), "luenberger-verify: {problem}; see luenberger-verify --help");
    ExitCode::from(2)
}

fn print_digests(files: &[String]) -> ExitCode {
    let mut status = 0;
    for path in files {
        match read(path).map_err(|error| error.to_string()).and_then(|bytes| digest(&bytes).map_err(|e| e.to_string()))
        {
            Ok(digest) => print(&format!("{digest}  {path}\n")),
            Err(why) => {
                print(&format!("{path}: Unreadable\n  {why}\n"));
                status = 2;
            }
        }
    }
    ExitCode::from(status)
}

fn main() -> ExitCode {
    let (mut files, mut json, mut digests, mut options) = (Vec::new(), false, false, true);
    for argument in std::env::args_os().skip(1) {
        let Ok(argument) = argument.into_string() else { return usage("a file name that is not UTF-8") };
        match argument.as_str() {
            "--help" | "-h" if options => {
                print(HELP);
                print(&format!("\nTheorems: {}.\n", Theorem::NAMES.join(", ")));
                return ExitCode::SUCCESS;
            }
            "--version" if options => {
                print(concat!("luenberger-verify ", env!("CARGO_PKG_VERSION"), "\n"));
                return ExitCode::SUCCESS;
            }
            "--json" if options => json = true,
            "--digest" if options => digests = true,
            "--" if options => options = false,
            other if options && other.len() > 1 && other.starts_with('-') => {
                return usage(&format!("unknown option {other}"));
            }
            _ => files.push(argument),
        }
    }
    if files.is_empty() {
        return usage("no file given");
    }
    if digests {
        return print_digests(&files);
    }
    let mut status = 0;
    for path in &files {
        let outcome = Outcome::of(path);
        print(&if json { outcome.json(path) } else { outcome.text(path) });
        status = status.max(outcome.status());
    }
    ExitCode::from(status)
}
