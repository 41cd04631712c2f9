//! Names of an observer as identifiers, and of its columns in comments.

use crate::error::ExportError;

/// Names and units of the columns, for comments.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Units of the states, an empty text for one without; empty if unknown.
    pub units: Vec<String>,
    /// Units of the inputs, likewise.
    pub input_units: Vec<String>,
    /// Units of the outputs, likewise.
    pub output_units: Vec<String>,
    /// The unit of the time; empty if unknown.
    pub time_unit: String,
}

impl Names {
    /// x1, x2, ..., u1, ..., y1, ...
    pub fn numbered(states: usize, inputs: usize, outputs: usize) -> Self {
        let list = |letter: &str, count: usize| (1..=count).map(|i| format!("{letter}{i}")).collect();
        let (states, inputs, outputs) = (list("x", states), list("u", inputs), list("y", outputs));
        Self { states, inputs, outputs, ..Self::default() }
    }
}

/// The identifier derived from a name: letters, digits and underscores, in lower case, not beginning with a digit.
///
/// ```
/// use luenberger_export::names::identifier;
/// assert_eq!(identifier("EKF at 100 Hz"), "ekf_at_100_hz");
/// assert_eq!(identifier("2nd"), "observer_2nd");
/// ```
pub fn identifier(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_alphanumeric() {
            text.push(letter.to_ascii_lowercase());
        } else if !text.ends_with('_') && !text.is_empty() {
            text.push('_');
        }
    }
    let text = text.trim_end_matches('_').to_owned();
    if text.is_empty() || text.starts_with(|letter: char| letter.is_ascii_digit()) || is_reserved(&text) {
        format!("observer_{text}").trim_end_matches('_').to_owned()
    } else {
        text
    }
}

/// Whether a name can be an identifier of C and of Rust.
///
/// # Errors
/// [`ExportError::Identifier`].
pub fn check(name: &str) -> Result<(), ExportError> {
    let refuse = |why| Err(ExportError::Identifier { name: name.to_owned(), why });
    if name.is_empty() || name.len() > 48 {
        return refuse("it must have 1 to 48 characters");
    }
    if !name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_') {
        return refuse("only letters, digits and underscores are allowed");
    }
    if !name.starts_with(|letter: char| letter.is_ascii_alphabetic()) {
        return refuse("it must begin with a letter");
    }
    if is_reserved(name) {
        return refuse("it is a reserved word, or the name of a header, target or crate that the files need");
    }
    Ok(())
}

/// The keywords of C11 and of Rust, and the names that the emitted files use themselves.
fn is_reserved(name: &str) -> bool {
    const WORDS: &[&str] = &[
        "abstract", "as", "async", "auto", "await", "become", "bool", "box", "break", "case", "char", "const",
        "continue", "crate", "default", "do", "double", "dyn", "else", "enum", "extern", "false", "final", "float",
        "fn", "for", "gen", "goto", "if", "impl", "in", "inline", "int", "let", "long", "loop", "macro", "main",
        "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "register", "restrict", "return", "self",
        "short", "signed", "sizeof", "static", "std", "struct", "super", "switch", "test", "trait", "true", "try",
        "type", "typedef", "typeof", "union", "unsafe", "unsigned", "unsized", "use", "virtual", "void", "volatile",
        "where", "while", "yield", "core", "math",
    ];
    // A file NAME.h would stand in place of one of the C library, or of those that these include; a target NAME of
    // CMake in place of a target or library; a crate NAME in place of one that it needs. Some file systems know no
    // case.
    const FILES: &[&str] = &[
        "alloc",
        "alloca",
        "all",
        "arduino",
        "assert",
        "clean",
        "complex",
        "ctype",
        "depend",
        "edit_cache",
        "endian",
        "errno",
        "esp_err",
        "esp_timer",
        "features",
        "fenv",
        "float",
        "fmi2",
        "fmi3",
        "getopt",
        "help",
        "ieeefp",
        "install",
        "instance",
        "inttypes",
        "iso646",
        "limits",
        "locale",
        "luenberger_observers",
        "m",
        "malloc",
        "math",
        "memory",
        "model",
        "nalgebra",
        "newlib",
        "package",
        "package_source",
        "preinstall",
        "proc_macro",
        "pthread",
        "rebuild_cache",
        "reent",
        "sched",
        "setjmp",
        "signal",
        "stdalign",
        "stdarg",
        "stdatomic",
        "stdbit",
        "stdbool",
        "stdckdint",
        "stddef",
        "stdint",
        "stdio",
        "stdlib",
        "stdnoreturn",
        "string",
        "strings",
        "syslimits",
        "test",
        "tgmath",
        "threads",
        "time",
        "uchar",
        "uninstall",
        "unistd",
        "wchar",
        "wctype",
        "xlocale",
    ];
    WORDS.contains(&name) || FILES.contains(&name.to_ascii_lowercase().as_str())
}
