//! Matrices of a command: in a file, or on the command line, `"0 1; -2 -3" --c "1 0" --poles -2,-5`.

use super::Source;
use crate::failure::Failure;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use serde_json::{Map, Value, json};
use std::ffi::OsString;
use std::fmt;
use std::marker::PhantomData;

/// The data of a command that solves a matrix problem.
pub(crate) trait Problem {
    /// The keys of its matrices in a file, each an option in place of it.
    const MATRICES: &'static [&'static str];
    /// Whether it has poles.
    const POLES: bool = false;
    /// Whether it can do without any of them.
    const OPTIONAL: bool = false;
}

/// The problems with the keys of their matrices.
macro_rules! problems {
    ($($problem:ident: [$($key:literal),+] $(, $constant:ident)?;)+) => {$(
        #[derive(Clone, Copy)]
        pub(crate) struct $problem;

        impl $problem {
            /// The keys of the matrices.
            pub(crate) const KEYS: [&'static str; [$($key),+].len()] = [$($key),+];
        }

        impl Problem for $problem {
            const MATRICES: &'static [&'static str] = &Self::KEYS;
            $(const $constant: bool = true;)?
        }
    )+};
}

problems! {
    Lyapunov: ["a", "q", "e"];
    Sylvester: ["a", "b", "q"];
    RiccatiProblem: ["a", "b", "q", "r", "s", "e", "c", "w", "v", "g"];
    PolePlacement: ["a", "b", "c", "pattern"], POLES;
    Pair: ["a", "c"];
    Square: ["a"];
    StateSpace: ["a", "b", "c", "d"];
    LoopProblem: ["a", "c", "b", "d", "l", "k"];
    NoiseModel: ["a", "w", "qd", "r", "v"], OPTIONAL;
}

/// Where matrices are.
#[derive(Debug, Clone)]
pub(crate) enum Given {
    /// In a file with a JSON object, or on standard input.
    In(Source),
    /// The JSON object, from the command line.
    Here(Map<String, Value>),
}

impl fmt::Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::In(source) => source.fmt(f),
            Self::Here(_) => write!(f, "command line"),
        }
    }
}

impl Given {
    /// The JSON object as text.
    pub(super) fn text(&self) -> Result<String, Failure> {
        match self {
            Self::In(source) => source.text(),
            Self::Here(object) => Ok(serde_json::to_string(object)?),
        }
    }
}

/// The data of a problem.
#[derive(Debug, Clone)]
pub(crate) struct Data<P> {
    /// Where they are; none only for an [optional](Problem::OPTIONAL) one.
    pub(crate) given: Option<Given>,
    problem: PhantomData<P>,
}

impl<P> Data<P> {
    /// Where they are.
    pub(crate) fn given(&self) -> &Given {
        // clap requires one where none is not allowed.
        self.given.as_ref().unwrap_or(&Given::In(Source::Standard))
    }
}

const FILE: &str = "file";
const HEADING: &str = "In place of FILE";

fn keys<P: Problem>() -> impl Iterator<Item = &'static str> {
    P::MATRICES.iter().copied().chain(P::POLES.then_some("poles"))
}

impl<P: Problem> Args for Data<P> {
    fn augment_args(command: Command) -> Command {
        let file = Arg::new(FILE)
            .value_name("FILE")
            .value_parser(clap::value_parser!(Source))
            .allow_negative_numbers(true)
            .help("JSON file, or - for standard input; a matrix is a list of its rows. Or A itself, \"0 1; -2 -3\"");
        let file = if P::OPTIONAL { file } else { file.required_unless_present_any(keys::<P>()) };
        let matrix = |key: &'static str| {
            let option = Arg::new(key).long(key).action(ArgAction::Set).allow_hyphen_values(true);
            let option = option.help_heading(HEADING).hide_short_help(true);
            if key == "poles" {
                let help = "The poles, such as -2,-5 or -1+2i,-1-2i";
                option.value_name("LIST").value_parser(poles).help(help)
            } else {
                let help = format!("The matrix \"{key}\", its rows separated by semicolons");
                option.value_name("ROWS").value_parser(rows).help(help)
            }
        };
        command.arg(file).args(keys::<P>().map(matrix))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<P: Problem> FromArgMatches for Data<P> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let options = keys::<P>().filter_map(|key| Some((key.to_owned(), matches.get_one::<Value>(key)?.clone())));
        let mut object: Map<String, Value> = options.collect();
        let conflict = |what: &str| Err(clap::Error::raw(ErrorKind::ArgumentConflict, format!("{what}\n")));
        let given = match matches.get_one::<Source>(FILE) {
            Some(source) => match in_place(source).transpose() {
                Ok(Some(_)) if object.contains_key("a") => return conflict("the matrix A is given twice"),
                Ok(Some(a)) => {
                    object.insert("a".to_owned(), a);
                    Some(Given::Here(object))
                }
                Ok(None) if object.is_empty() => Some(Given::In(source.clone())),
                Ok(None) => return conflict(&beside_matrices(source)),
                Err(what) => return conflict(&what),
            },
            None => (!object.is_empty()).then_some(Given::Here(object)),
        };
        Ok(Self { given, problem: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The text of what stands where a file could, if no file has this name.
fn no_file(source: &Source) -> Option<&str> {
    let Source::File(path) = source else { return None };
    path.to_str().filter(|_| !path.exists())
}

/// The matrix that stands where a file could: no file has this name, and it consists of numbers, finite or not.
fn in_place(source: &Source) -> Option<Result<Value, String>> {
    let text = no_file(source)?;
    let has_digits = text.contains(|c: char| c.is_ascii_digit());
    let is_matrix = is_of_digits(text)
        || text.split(';').flat_map(|row| words(without_brackets(row))).all(|word| word.parse::<f64>().is_ok());
    (has_digits && is_matrix).then(|| rows(text).map_err(|what| format!("the matrix {text:?}: {what}")))
}

/// Whether a text has only what numbers and matrices of them are written with.
fn is_of_digits(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_digit() || " \t\n+-.,;eE[]".contains(c))
}

/// Why what is no matrix does not stand beside matrices on the command line.
fn beside_matrices(source: &Source) -> String {
    match no_file(source).map(|text| (text, rows(text))) {
        Some((text, Err(what))) => format!("there is no file {text:?}, and it is no matrix: {what}"),
        _ => "FILE and matrices on the command line exclude each other".to_owned(),
    }
}

/// A matrix of several entries that begins with a minus sign, in the brackets that matrices may have: without them it
/// would be an option. Every other word is as it was.
pub(crate) fn bracketed(word: OsString) -> OsString {
    let is_matrix = |text: &&str| {
        let rest = text.strip_prefix('-').unwrap_or_default();
        rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') && rest.contains([' ', ';']) && is_of_digits(rest)
    };
    word.to_str().filter(is_matrix).map(|text| format!("[{text}]").into()).unwrap_or(word)
}

/// A finite number.
fn number(word: &str) -> Result<f64, String> {
    word.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| format!("{word:?} is not a finite number"))
}

/// Words between commas or spaces; brackets around all of them are those of MATLAB, and may be left out.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty())
}

fn without_brackets(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(text)
}

/// The rows of a matrix in text.
fn rows(text: &str) -> Result<Value, String> {
    let rows = without_brackets(text).split(';').map(|row| words(row).map(number).collect());
    let rows: Vec<Vec<f64>> = rows.collect::<Result<_, _>>()?;
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 {
        return Err("a matrix is expected, its rows separated by semicolons: \"0 1; -2 -3\"".to_owned());
    }
    match rows.iter().position(|row| row.len() != columns) {
        Some(i) if rows[i].len() == 1 => Err(format!("row {} has 1 entry, row 1 has {columns}", i + 1)),
        Some(i) => Err(format!("row {} has {} entries, row 1 has {columns}", i + 1, rows[i].len())),
        None => Ok(json!(rows)),
    }
}

/// Poles in text.
fn poles(text: &str) -> Result<Value, String> {
    let poles: Vec<Value> = words(without_brackets(text)).map(pole).collect::<Result<_, _>>()?;
    if poles.is_empty() {
        return Err("poles are expected, such as -2,-5 or -1+2i,-1-2i".to_owned());
    }
    Ok(json!(poles))
}

/// A number, or `[re, im]` of a complex one such as `-1+2i`.
fn pole(word: &str) -> Result<Value, String> {
    let Some(complex) = word.strip_suffix(['i', 'j']) else { return number(word).map(|x| json!(x)) };
    // The sign between the parts: not the first one, and not that of an exponent.
    let bytes = complex.as_bytes();
    let sign =
        (1..bytes.len()).rev().find(|&k| matches!(bytes[k], b'+' | b'-') && !matches!(bytes[k - 1], b'e' | b'E'));
    let (re, im) = complex.split_at(sign.unwrap_or(0));
    let re = if re.is_empty() { 0.0 } else { number(re)? };
    let im = match im {
        "" | "+" => 1.0,
        "-" => -1.0,
        im => number(im)?,
    };
    Ok(json!([re, im]))
}
