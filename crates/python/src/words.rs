//! Messages of the command and of studies in the words of Python: options and keys as arguments, tables as functions.

/// The words of a refusal.
pub(crate) struct Words {
    pub(crate) message: fn(&str) -> String,
    pub(crate) advice: fn(&str) -> String,
    pub(crate) instead: &'static str,
}

/// Those for a study of the user.
pub(crate) const OF_STUDY: Words = Words { message: in_python, advice: in_python, instead: "Instead" };

/// Those for a study that this package has written.
pub(crate) const OF_CALL: Words =
    Words { message: of_tables, advice: of_calls, instead: "Instead, of luenberger.observer" };

/// A message of the command with the names that its options have in Python.
pub(crate) fn in_python(message: &str) -> String {
    let names = [
        (" with -o", ""),
        ("--restart", "restart=True"),
        ("--force", "force=True"),
        ("--block-size ", "block_size="),
        ("--unproved", "unproved=True"),
        ("--format f64", "format=\"f64\""),
        ("--format f32", "format=\"f32\""),
        ("--format q16.16", "format=\"q16.16\""),
        ("--libm target", "libm=\"target\""),
        ("--layout ros2", "layout=\"ros2\""),
        ("--to c", "to=\"c\""),
        ("--to fmu", "to=\"fmu\""),
        ("choose one with --observer NAME", "name one"),
        ("--period, or simulation.hold in the study", "dt"),
        ("--period", "dt"),
        ("--substeps", "substeps"),
        ("--feedback", "feedback"),
        ("--layout", "layout"),
        ("--gains", "gains"),
        ("--fmi", "fmi"),
        ("`repeats = \"measured\"`", "repeats=\"measured\""),
        ("`interpolation = \"linear\"` in [log]", "interpolation=\"linear\""),
    ];
    let text = names.iter().fold(message.to_owned(), |text, (option, name)| text.replace(option, name));
    limit(&limit(&text, "memory", &[("GiB", 1_073_741_824.0)]), "time", &[("h", 3600.0)])
}

/// A limit of the command, with its unit, as the argument in bytes or seconds.
fn limit(text: &str, of: &str, units: &[(&str, f64)]) -> String {
    let option = format!("--limit {of}=");
    let Some((before, after)) = text.split_once(&option) else { return text.to_owned() };
    let digits = after.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(after.len());
    let (number, rest) = after.split_at(digits);
    let unit = units.iter().find_map(|(unit, size)| Some((rest.strip_prefix(unit)?, size)));
    match (number.parse::<f64>(), unit) {
        (Ok(number), Some((rest, size))) => format!("{before}{of}_limit={}{rest}", number * size),
        _ => text.to_owned(),
    }
}

/// A message on a study that this package has written: its tables are calls.
pub(crate) fn of_tables(message: &str) -> String {
    let names = [
        ("[[observer]]", "an observer"),
        ("with an [operating_point]", "at an operating point, plant.at(x, u)"),
        ("[operating_point]", "plant.at"),
        ("a [simulation]", "simulate"),
        ("[simulation]", "simulate"),
        ("a table [log]", "replay"),
        ("a [log]", "replay"),
        ("no [log]", "no replay"),
        ("[log]", "replay"),
        ("[input]", "the input u"),
        ("[plant]", "the plant"),
        ("the study has no", "there is no"),
        (" in the study, not", ", not"),
        (", relative to the folder of the study", ""),
    ];
    in_python(&names.iter().fold(message.to_owned(), |text, (table, name)| text.replace(table, name)))
}

/// Advice on such a study, whose keys are arguments as well.
pub(crate) fn of_calls(advice: &str) -> String {
    arguments(&of_tables(advice))
}

/// `lmi = true` as `lmi=True`, and `kalman = { w = 1 }` as `kalman={"w": 1}`: keys with a value of a study as
/// arguments.
fn arguments(text: &str) -> String {
    let mut found = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let name = identifier(rest);
        if name == 0 {
            found.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let (word, after) = rest.split_at(name);
        let is_key = word.starts_with(|c: char| c.is_ascii_lowercase());
        let given = after.strip_prefix(" = ").filter(|_| is_key).and_then(value);
        if let Some((value, after)) = given {
            found.extend([word, "=", &value]);
            rest = after;
        } else {
            found.push_str(word);
            rest = after;
        }
    }
    found
}

/// The length of the name at the beginning.
fn identifier(text: &str) -> usize {
    let is_inside = |c: char| c.is_alphanumeric() || c == '_';
    if text.starts_with(is_inside) { text.find(|c| !is_inside(c)).unwrap_or(text.len()) } else { 0 }
}

/// The value at the beginning, as Python writes it, and the text behind it.
fn value(text: &str) -> Option<(String, &str)> {
    let word = identifier(text);
    match (&text[..word], text.chars().next()?) {
        ("true", _) => Some(("True".to_owned(), &text[word..])),
        ("false", _) => Some(("False".to_owned(), &text[word..])),
        (_, '"') => {
            let end = 2 + text[1..].find('"')?;
            Some((text[..end].to_owned(), &text[end..]))
        }
        (_, '[') => entries(text, ']', value),
        (_, '{') => entries(text, '}', |text| {
            let name = identifier(text);
            let (key, after) = text.split_at(name);
            let (value, after) = value(after.strip_prefix(" = ")?).filter(|_| name > 0)?;
            Some((format!("\"{key}\": {value}"), after))
        }),
        (_, first) if first.is_ascii_digit() || first == '-' || first == '.' => {
            let is_inside = |c: char| c.is_ascii_alphanumeric() || ".-+".contains(c);
            let end = text.find(|c| !is_inside(c)).unwrap_or(text.len());
            // A full stop that ends a sentence is none of a number.
            let number = text[..end].trim_end_matches('.');
            number.parse::<f64>().ok()?;
            Some((number.to_owned(), &text[number.len()..]))
        }
        _ => None,
    }
}

/// Values between brackets.
fn entries(text: &str, close: char, one: impl Fn(&str) -> Option<(String, &str)>) -> Option<(String, &str)> {
    let mut all = Vec::new();
    let mut rest = text[1..].trim_start();
    loop {
        if let Some(after) = rest.strip_prefix(close) {
            return Some((format!("{}{}{close}", &text[..1], all.join(", ")), after));
        }
        if let Some(after) = rest.strip_prefix("..") {
            all.push("..".to_owned());
            rest = after.trim_start();
        } else {
            let (value, after) = one(rest)?;
            all.push(value);
            rest = after.trim_start();
        }
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
}
