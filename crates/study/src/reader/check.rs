//! Check of a tree against the description of the tables: unknown keys, missing keys, values of the wrong type.
//!
//! Conditions on a single key are checked here; those on several keys (dimensions, alternatives) when the study is
//! built.

use luenberger_expression::nearest;
use luenberger_proof::wording::is_invisible;

use super::tree::{Node, Value};
use crate::diagnostic::Diagnostic;
use crate::keys::{Key, Range, Table, Type};

/// Appends the mistakes of `node` as a table of this description.
pub(crate) fn table(node: &Node, table: &Table, mistakes: &mut Vec<Diagnostic>) {
    let Value::Table(entries) = &node.value else {
        let message = format!("{} is {}", table.name, node.kind());
        mistakes.push(Diagnostic::new(node.span.clone(), message, "expected a table"));
        return;
    };
    let mut keys: Vec<&Key> = table.keys.iter().collect();
    let mut of = table.name.to_owned();
    let mut tag = None;
    if let Some(variants) = &table.variants {
        tag = Some(variants.tag);
        let known = (variants.of)();
        let names = || known.iter().map(|variant| variant.name);
        let expected =
            || format!("expected one of {}", names().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", "));
        match node.get(variants.tag).map(|value| (value, value.text())) {
            Some((_, Some(name))) if table.variant(name).is_some() => {
                if let Some(variant) = table.variant(name) {
                    keys.extend(variant.keys());
                    of = format!("{} of the kind {name}", table.name);
                }
            }
            Some((value, Some(name))) => {
                let message = format!("there is no {} of the kind \"{name}\"", table.name);
                mistakes.push(near(Diagnostic::new(value.span.clone(), message, expected()), name, names()));
                return;
            }
            Some((value, None)) => {
                let message = format!("`{}` is {}", variants.tag, value.kind());
                mistakes.push(Diagnostic::new(value.span.clone(), message, expected()));
                return;
            }
            None => {
                let message = format!("{} has no `{}`", table.name, variants.tag);
                mistakes.push(Diagnostic::new(head(node), message, expected()));
                return;
            }
        }
    }
    for entry in entries.iter().filter(|entry| Some(entry.key.as_str()) != tag) {
        match keys.iter().find(|key| key.name == entry.key) {
            Some(key) => value(&entry.node, key, mistakes),
            None => mistakes.push(unknown(&entry.key, entry.span.clone(), table, &of, &keys)),
        }
    }
    for key in keys.iter().filter(|key| key.required && node.get(key.name).is_none()) {
        let message = format!("{of} has no `{}`", key.name);
        let expected = format!("expected `{}`: {}", key.name, key.value.words());
        mistakes.push(Diagnostic::new(head(node), message, expected).help(key.about).absence());
    }
}

/// The first bytes of a table: its header, or its opening brace.
pub(crate) fn head(node: &Node) -> std::ops::Range<usize> {
    match node.entries().first() {
        Some(first) if first.span.start <= node.span.start => first.span.clone(),
        _ => node.span.clone(),
    }
}

fn near<'a>(diagnostic: Diagnostic, name: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    match nearest(name, known) {
        Some(near) => diagnostic.help(format!("the nearest is `{near}`")),
        None => diagnostic,
    }
}

fn unknown(name: &str, span: std::ops::Range<usize>, table: &Table, of: &str, keys: &[&Key]) -> Diagnostic {
    let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
    let expected = format!("expected one of {}", names.join(", "));
    let message = format!("`{name}` is not a key of {of}");
    let diagnostic = Diagnostic::new(span, message, expected);
    if let Some(near) = nearest(name, names.iter().copied()) {
        return diagnostic.help(format!("the nearest key is `{near}`"));
    }
    let others = table.variants.iter().flat_map(|variants| (variants.of)());
    let having = others.filter(|variant| variant.keys().any(|key| key.name == name)).map(|variant| variant.name);
    let having: Vec<&str> = having.collect();
    if having.is_empty() {
        return diagnostic;
    }
    diagnostic.help(format!("it is a key of the kinds {}", having.join(", ")))
}

fn value(node: &Node, key: &Key, mistakes: &mut Vec<Diagnostic>) {
    let name = key.name;
    let mut wrong = |node: &Node, message: String, expected: String| {
        mistakes.push(Diagnostic::new(node.span.clone(), message, format!("expected {expected}")).help(key.about));
    };
    let expected = || key.value.words();
    let other = |node: &Node| format!("`{name}` is {}", shown(node));
    match &key.value {
        Type::Text => match node.text() {
            Some(text) if text.trim().is_empty() => wrong(node, format!("`{name}` is empty"), expected()),
            Some(_) => {}
            None => wrong(node, other(node), expected()),
        },
        Type::Name => match node.text() {
            Some(text) => named(node, &format!("`{name}`"), text, mistakes),
            None => wrong(node, other(node), expected()),
        },
        Type::Units if matches!(node.value, Value::Table(_)) => {
            for entry in node.entries() {
                a_name(&entry.node, &format!("the unit of `{}`", entry.key), mistakes);
            }
        }
        Type::Columns | Type::Names(0) if node.list().is_some_and(<[Node]>::is_empty) => {}
        Type::Names(_) | Type::Units => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
            a_name(x, &format!("entry {} of `{name}`", i + 1), mistakes);
        }),
        Type::NameLists(least) => list(node, name, &expected(), mistakes, |(i, inner), mistakes| {
            let what = format!("list {} of `{name}`", i + 1);
            match inner.list() {
                Some(names) if names.len() >= *least => {
                    for (k, x) in names.iter().enumerate() {
                        a_name(x, &format!("entry {} of {what}", k + 1), mistakes);
                    }
                }
                _ => {
                    let message = format!("{what} is {}", shown(inner));
                    mistakes.push(Diagnostic::new(inner.span.clone(), message, format!("expected {}", expected())));
                }
            }
        }),
        Type::Choice(choices) => choice(node, name, choices, mistakes),
        Type::Switch => {
            if node.truth().is_none() {
                wrong(node, other(node), expected());
            }
        }
        Type::Number(range) => number(node, &format!("`{name}`"), *range, mistakes),
        Type::Count(least) => match node.count() {
            Some(count) if count >= *least => {}
            _ => wrong(node, other(node), expected()),
        },
        Type::Numbers(range) => {
            let each = |(i, x): (usize, &Node), mistakes: &mut Vec<Diagnostic>| {
                number(x, &format!("entry {} of `{name}`", i + 1), *range, mistakes);
            };
            list(node, name, &expected(), mistakes, each);
        }
        Type::Texts | Type::Columns => list(node, name, &expected(), mistakes, |(i, x), mistakes| match x.text() {
            Some(text) if !text.trim().is_empty() => {}
            Some(_) => mistakes.push(Diagnostic::new(
                x.span.clone(),
                format!("entry {} of `{name}` is empty", i + 1),
                "expected a text",
            )),
            None => {
                let message = format!("entry {} of `{name}` is {}", i + 1, shown(x));
                mistakes.push(Diagnostic::new(x.span.clone(), message, "expected a text"));
            }
        }),
        Type::Covariance if node.list().is_some_and(|list| list.iter().any(|entry| entry.text().is_some())) => {
            value(node, &Key { value: Type::Expressions, ..*key }, mistakes);
        }
        Type::Covariance => value(node, &Key { value: Type::Weight, ..*key }, mistakes),
        Type::Expressions => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
            expression(x, &format!("entry {} of `{name}`", i + 1), mistakes);
        }),
        Type::ExpressionRows => match node.list() {
            Some(entries) if entries.iter().any(|entry| entry.list().is_some()) => {
                grid(node, name, &expected(), mistakes, expression);
            }
            _ => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
                expression(x, &format!("entry {} of `{name}`", i + 1), mistakes);
            }),
        },
        Type::Choices(choices) => {
            list(node, name, &expected(), mistakes, |(_, x), mistakes| choice(x, name, choices, mistakes));
        }
        Type::Rows => rows(node, name, &expected(), mistakes),
        Type::Weight => match &node.value {
            Value::Number(..) => number(node, &format!("`{name}`"), Range::Any, mistakes),
            Value::List(entries) if entries.iter().any(|entry| entry.list().is_some()) => {
                rows(node, name, &expected(), mistakes);
            }
            _ => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
                number(x, &format!("entry {} of `{name}`", i + 1), Range::Any, mistakes);
            }),
        },
        Type::Poles => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
            let what = format!("pole {} of `{name}`", i + 1);
            match x.list() {
                None => number(x, &what, Range::Any, mistakes),
                Some([re, im]) => [re, im].into_iter().for_each(|part| number(part, &what, Range::Any, mistakes)),
                Some(parts) => mistakes.push(Diagnostic::new(
                    x.span.clone(),
                    format!("{what} has {} parts", parts.len()),
                    "expected a number or a pair [re, im]",
                )),
            }
        }),
        Type::Bounds => list(node, name, &expected(), mistakes, |(i, x), mistakes| {
            bound(x, &format!("pair {} of `{name}`", i + 1), mistakes);
        }),
        Type::Bound => bound(node, &format!("`{name}`"), mistakes),
        Type::NamedBounds => match &node.value {
            Value::Table(entries) => {
                for entry in entries {
                    bound(&entry.node, &format!("`{}`", entry.key), mistakes);
                }
            }
            _ => wrong(node, other(node), expected()),
        },
        Type::Named => match &node.value {
            Value::Table(entries) => {
                for entry in entries {
                    if entry.key.chars().count() > LONGEST {
                        let message = format!("the name of a parameter has {} characters", entry.key.chars().count());
                        let expected = format!("expected at most {LONGEST}");
                        mistakes.push(Diagnostic::new(entry.span.clone(), message, expected));
                    }
                    let is_infinite = entry.node.number().is_some_and(f64::is_infinite);
                    match entry.node.text() {
                        Some(text) if !is_infinite && !text.trim().is_empty() => {}
                        _ => number(&entry.node, &format!("the parameter `{}`", entry.key), Range::Any, mistakes),
                    }
                }
            }
            _ => wrong(node, other(node), expected()),
        },
        Type::NamedTables(inner) => match &node.value {
            Value::Table(entries) => entries.iter().for_each(|entry| table(&entry.node, inner, mistakes)),
            _ => wrong(node, other(node), expected()),
        },
        Type::Table(inner) => table(node, inner, mistakes),
        Type::Tables(inner) => {
            list(node, name, &expected(), mistakes, |(_, x), mistakes| table(x, inner, mistakes));
        }
    }
}

/// The largest number of characters of a name: it becomes part of file names, columns and labels.
const LONGEST: usize = 100;

/// A text that is a name.
fn a_name(node: &Node, what: &str, mistakes: &mut Vec<Diagnostic>) {
    if let Some(text) = node.text() {
        named(node, what, text, mistakes);
    } else {
        mistakes.push(Diagnostic::new(node.span.clone(), format!("{what} is {}", shown(node)), "expected a text"));
    }
}

/// A name: not empty, not too long, without line breaks and other invisible characters.
fn named(node: &Node, what: &str, text: &str, mistakes: &mut Vec<Diagnostic>) {
    let count = text.chars().count();
    let (message, expected) = if text.trim().is_empty() {
        (format!("{what} is empty"), "expected a text".to_owned())
    } else if count > LONGEST {
        (format!("{what} has {count} characters"), format!("expected a name of at most {LONGEST} characters"))
    } else if let Some(hidden) = text.chars().find(|c| is_invisible(*c)) {
        let kind = if hidden.is_control() { "control" } else { "invisible" };
        let message = format!("{what} has the {kind} character U+{:04X}", u32::from(hidden));
        (message, format!("expected a name without {kind} characters"))
    } else {
        return;
    };
    mistakes.push(Diagnostic::new(node.span.clone(), message, expected));
}

/// The value, if it is short enough to be quoted, otherwise its type.
fn shown(node: &Node) -> String {
    match &node.value {
        Value::Number(x, _) => x.to_string(),
        Value::Text(text) if text.chars().count() <= 30 => format!("the text {text:?}"),
        Value::Truth(truth) => truth.to_string(),
        _ => node.kind().to_owned(),
    }
}

fn choice(node: &Node, name: &str, choices: &'static [(&'static str, &'static str)], mistakes: &mut Vec<Diagnostic>) {
    let names = || choices.iter().map(|(name, _)| *name);
    if node.text().is_some_and(|text| names().any(|name| name == text)) {
        return;
    }
    let expected = format!("expected {}", Type::Choice(choices).words());
    let diagnostic = Diagnostic::new(node.span.clone(), format!("`{name}` is {}", shown(node)), expected);
    mistakes.push(near(diagnostic, node.text().unwrap_or(""), names()));
}

fn number(node: &Node, what: &str, range: Range, mistakes: &mut Vec<Diagnostic>) {
    match node.number() {
        Some(x) if range.holds(x) => {}
        _ => {
            let expected = format!("expected a {}", range.words());
            mistakes.push(Diagnostic::new(node.span.clone(), format!("{what} is {}", shown(node)), expected));
        }
    }
}

fn list(
    node: &Node,
    name: &str,
    expected: &str,
    mistakes: &mut Vec<Diagnostic>,
    each: impl Fn((usize, &Node), &mut Vec<Diagnostic>),
) {
    let expected = || format!("expected {expected}");
    match node.list() {
        Some([]) => mistakes.push(Diagnostic::new(node.span.clone(), format!("`{name}` is an empty list"), expected())),
        Some(entries) => entries.iter().enumerate().for_each(|entry| each(entry, mistakes)),
        None => mistakes.push(Diagnostic::new(node.span.clone(), format!("`{name}` is {}", shown(node)), expected())),
    }
}

/// A text that is not empty, or a finite number.
fn expression(node: &Node, what: &str, mistakes: &mut Vec<Diagnostic>) {
    let found = match node.text() {
        Some(text) if !text.trim().is_empty() => return,
        Some(_) => "empty".to_owned(),
        None if node.number().is_some_and(f64::is_finite) => return,
        None => shown(node),
    };
    let mistake =
        Diagnostic::new(node.span.clone(), format!("{what} is {found}"), "expected an expression or a number");
    mistakes.push(mistake);
}

fn rows(node: &Node, name: &str, expected: &str, mistakes: &mut Vec<Diagnostic>) {
    grid(node, name, expected, mistakes, |x, what, mistakes| number(x, what, Range::Any, mistakes));
}

/// Rows of one length, each entry checked by `each`.
fn grid(
    node: &Node,
    name: &str,
    expected: &str,
    mistakes: &mut Vec<Diagnostic>,
    each: impl Fn(&Node, &str, &mut Vec<Diagnostic>),
) {
    let mut width = None;
    let Some(entries) = node.list().filter(|entries| !entries.is_empty()) else {
        list(node, name, expected, mistakes, |_, _| {});
        return;
    };
    for (i, row) in entries.iter().enumerate() {
        let Some(numbers) = row.list() else {
            let message = format!("row {} of `{name}` is {}", i + 1, shown(row));
            mistakes.push(Diagnostic::new(row.span.clone(), message, format!("expected {expected}")));
            continue;
        };
        for (j, x) in numbers.iter().enumerate() {
            each(x, &format!("entry ({}, {}) of `{name}`", i + 1, j + 1), mistakes);
        }
        let first = *width.get_or_insert(numbers.len());
        if numbers.is_empty() {
            let message = format!("row {} of `{name}` is empty", i + 1);
            mistakes.push(Diagnostic::new(row.span.clone(), message, format!("expected {expected}")));
        } else if numbers.len() != first {
            let message = format!("row {} of `{name}` has length {}, row 1 has length {first}", i + 1, numbers.len());
            mistakes.push(Diagnostic::new(row.span.clone(), message, format!("expected length {first}")));
        }
    }
}

fn bound(node: &Node, what: &str, mistakes: &mut Vec<Diagnostic>) {
    let ends = node.list().map(|ends| ends.iter().map(Node::number).collect::<Vec<_>>());
    match ends.as_deref() {
        Some([Some(lower), Some(upper)]) if lower <= upper => {}
        Some([Some(lower), Some(upper)]) => mistakes.push(Diagnostic::new(
            node.span.clone(),
            format!("{what} goes from {lower} to {upper}"),
            "expected lower <= upper",
        )),
        _ => mistakes.push(Diagnostic::new(
            node.span.clone(),
            format!("{what} is {}", shown(node)),
            "expected a pair [lower, upper]",
        )),
    }
}
