//! Parser of expressions; the grammar is in the head of the crate.
//!
//! Binding powers are passed to the Pratt parser of `winnow`; its state is the tree built so far and the remaining
//! depth.

use core::ops::Range;

use winnow::ascii::{digit1, multispace0};
use winnow::combinator::{Infix, Prefix, alt, expression, opt};
use winnow::error::{ErrMode, ParserError};
use winnow::prelude::*;
use winnow::stream::{LocatingSlice, Location, Stateful, Stream};
use winnow::token::{any, one_of, take_while};

use crate::LIMITS;
use crate::error::{ExpressionError, ExpressionErrorKind, Found};
use crate::function::{self, Binary, Comparison, Function, Unary};
use crate::nearest::nearest;
use crate::scope::{Scope, Symbol, begins_word, continues_word};
use crate::surface::LookupTable;
use crate::tree::{Node, Tree};

/// The expected start of an operand.
const OPERAND: &str = "a number, a name, `(` or `-`";

/// The tree built so far, and the nesting depth.
#[derive(Debug)]
struct Growth<'s> {
    text: &'s str,
    scope: &'s Scope,
    tree: Tree,
    /// Operations that wait for an operand.
    waiting: usize,
}

type Input<'s> = Stateful<LocatingSlice<&'s str>, Growth<'s>>;

type Parsed<O> = Result<O, ErrMode<Failure>>;

/// The error and its position; without a kind if another rule may still match.
#[derive(Debug)]
struct Failure(Option<(Range<usize>, ExpressionErrorKind)>);

impl<'s> ParserError<Input<'s>> for Failure {
    type Inner = Self;

    fn from_input(_: &Input<'s>) -> Self {
        Self(None)
    }

    fn into_inner(self) -> Result<Self::Inner, Self> {
        Ok(self)
    }
}

fn wrong<O>(span: Range<usize>, kind: ExpressionErrorKind) -> Parsed<O> {
    Err(ErrMode::Cut(Failure(Some((span, kind)))))
}

/// The tree of a number.
pub(crate) fn parse(text: &str, scope: &Scope) -> Result<Tree, ExpressionError> {
    parse_root(text, scope, |input, root| number_at(input, root).map(drop))
}

/// The tree of the difference that is not positive where an inequality holds: of `a <= b` that of `a - b`.
pub(crate) fn parse_inequality(text: &str, scope: &Scope) -> Result<Tree, ExpressionError> {
    parse_root(text, scope, |input, root| {
        let tree = &mut input.state.tree;
        let span = tree.span(root);
        if let Some((comparison, x, y)) = tree.unmake_comparison() {
            let difference = tree.push(Node::Binary(Binary::Subtract, x, y), span.clone());
            match comparison {
                Comparison::Less | Comparison::LessOrEqual => return Ok(()),
                Comparison::Greater | Comparison::GreaterOrEqual => {
                    tree.push(Node::Unary(Unary::Negate, difference), span);
                    return Ok(());
                }
                Comparison::Equal | Comparison::NotEqual => {}
            }
        }
        let part = text.get(span.clone()).unwrap_or("").to_owned();
        wrong(span, ExpressionErrorKind::NotAnInequality { part })
    })
}

fn parse_root(
    text: &str,
    scope: &Scope,
    complete: impl Fn(&mut Input<'_>, usize) -> Parsed<()>,
) -> Result<Tree, ExpressionError> {
    let error = |span, kind| Err(ExpressionError::new(text, span, kind));
    if text.len() > LIMITS.length {
        return error(0..0, ExpressionErrorKind::TooLong { length: text.len(), longest: LIMITS.length });
    }
    if text.trim().is_empty() {
        return error(0..text.len(), ExpressionErrorKind::Empty { expected: OPERAND });
    }
    let state = Growth { text, scope, tree: Tree::default(), waiting: 0 };
    let mut input = Stateful { input: LocatingSlice::new(text), state };
    let whole = |input: &mut Input<'_>| {
        let root = sum(input)?;
        end(input, "an operator or the end of the expression")?;
        complete(input, root)
    };
    match whole(&mut input) {
        Ok(()) => Ok(input.state.tree),
        Err(ErrMode::Cut(Failure(Some((span, kind)))) | ErrMode::Backtrack(Failure(Some((span, kind))))) => {
            error(span, kind)
        }
        // Every rule that fails for good has said why; this is what is left to say of any other.
        Err(_) => {
            let (span, found) = found(&input);
            error(span, ExpressionErrorKind::Unexpected { expected: OPERAND, found })
        }
    }
}

/// The word, the number or the character that comes next.
fn found(input: &Input<'_>) -> (Range<usize>, Found) {
    let text = input.state.text;
    let rest = text.get(input.current_token_start()..).unwrap_or("").trim_start();
    let start = text.len() - rest.len();
    let length = match rest.chars().next() {
        None => return (start..start, Found::End),
        Some(first) if first.is_ascii_digit() || begins_word(first) => {
            rest.find(|c| !continues_word(c) && c != '.').unwrap_or(rest.len())
        }
        Some(first) => first.len_utf8(),
    };
    (start..start + length, Found::Text(rest[..length].to_owned()))
}

fn unexpected<O>(input: &Input<'_>, expected: &'static str) -> Parsed<O> {
    let (span, found) = found(input);
    wrong(span, ExpressionErrorKind::Unexpected { expected, found })
}

fn end(input: &mut Input<'_>, expected: &'static str) -> Parsed<()> {
    space(input)?;
    if input.is_empty() { Ok(()) } else { unexpected(input, expected) }
}

fn space(input: &mut Input<'_>) -> Parsed<()> {
    multispace0.void().parse_next(input)
}

/// One more operation waits for an operand.
fn wait(input: &mut Input<'_>, at: usize) -> Parsed<()> {
    input.state.waiting += 1;
    if input.state.waiting > LIMITS.depth {
        return wrong(at..at + 1, ExpressionErrorKind::TooDeep);
    }
    Ok(())
}

fn sum(input: &mut Input<'_>) -> Parsed<usize> {
    expression(operand).prefix(sign).infix(operator).parse_next(input)
}

/// `-` or `+` before an operand: it is called where no operand begins.
fn sign<'s>(input: &mut Input<'s>) -> Parsed<Prefix<Input<'s>, usize, ErrMode<Failure>>> {
    space(input)?;
    let at = input.current_token_start();
    let Some(sign) = opt(one_of(('-', '+', '!'))).parse_next(input)? else { return unexpected(input, OPERAND) };
    wait(input, at)?;
    Ok(match sign {
        '-' => Prefix(8, |input, x| {
            let x = number_at(input, x)?;
            Ok(prefixed(input, Node::Unary(Unary::Negate, x), x))
        }),
        '!' => Prefix(8, |input, x| {
            let x = condition_at(input, x)?;
            Ok(prefixed(input, Node::Not(x), x))
        }),
        _ => Prefix(8, |input, x| {
            input.state.waiting -= 1;
            number_at(input, x)
        }),
    })
}

/// The node of a sign before x.
fn prefixed(input: &mut Input<'_>, node: Node, x: usize) -> usize {
    input.state.waiting -= 1;
    let span = input.state.tree.span(x);
    let before = input.state.text.get(..span.start).unwrap_or("").trim_end();
    input.state.tree.push(node, before.len().saturating_sub(1)..span.end)
}

/// x, if it is a number.
fn number_at(input: &mut Input<'_>, x: usize) -> Parsed<usize> {
    let Growth { text, tree, .. } = &input.state;
    if !tree.is_condition(x) {
        return Ok(x);
    }
    let span = tree.span(x);
    let part = text.get(span.clone()).unwrap_or("").to_owned();
    wrong(span, ExpressionErrorKind::NotANumber { part })
}

/// x, if it is a condition.
fn condition_at(input: &mut Input<'_>, x: usize) -> Parsed<usize> {
    let Growth { text, tree, .. } = &input.state;
    if tree.is_condition(x) {
        return Ok(x);
    }
    let span = tree.span(x);
    let part = text.get(span.clone()).unwrap_or("").to_owned();
    wrong(span, ExpressionErrorKind::NotACondition { part })
}

/// An operator between operands.
fn operator<'s>(input: &mut Input<'s>) -> Parsed<Infix<Input<'s>, usize, ErrMode<Failure>>> {
    space(input)?;
    let at = input.current_token_start();
    let sign = alt((alt(("**", "+", "-", "*", "/", "^")), alt(("<=", "<", ">=", ">", "==", "!=", "&&", "||"))))
        .parse_next(input)?;
    Ok(match sign {
        "||" => Infix::Left(1, |input, x, y| joined(input, Node::Or, x, y)),
        "&&" => Infix::Left(2, |input, x, y| joined(input, Node::And, x, y)),
        "<" => Infix::Left(3, |input, x, y| compared(input, Comparison::Less, x, y)),
        "<=" => Infix::Left(3, |input, x, y| compared(input, Comparison::LessOrEqual, x, y)),
        ">" => Infix::Left(3, |input, x, y| compared(input, Comparison::Greater, x, y)),
        ">=" => Infix::Left(3, |input, x, y| compared(input, Comparison::GreaterOrEqual, x, y)),
        "==" => Infix::Left(3, |input, x, y| compared(input, Comparison::Equal, x, y)),
        "!=" => Infix::Left(3, |input, x, y| compared(input, Comparison::NotEqual, x, y)),
        "+" => Infix::Left(5, |input, x, y| binary(input, Binary::Add, x, y)),
        "-" => Infix::Left(5, |input, x, y| binary(input, Binary::Subtract, x, y)),
        "*" => Infix::Left(7, |input, x, y| binary(input, Binary::Multiply, x, y)),
        "/" => Infix::Left(7, |input, x, y| binary(input, Binary::Divide, x, y)),
        _ => {
            // A chain of powers nests to the right. Nothing binds more tightly, so that this operator is never given
            // back.
            wait(input, at)?;
            Infix::Right(9, |input, x, y| {
                input.state.waiting -= 1;
                binary(input, Binary::Power, x, y)
            })
        }
    })
}

fn binary(input: &mut Input<'_>, operation: Binary, x: usize, y: usize) -> Parsed<usize> {
    let (x, y) = (number_at(input, x)?, number_at(input, y)?);
    Ok(between(input, Node::Binary(operation, x, y), x, y))
}

fn compared(input: &mut Input<'_>, comparison: Comparison, x: usize, y: usize) -> Parsed<usize> {
    let (x, y) = (number_at(input, x)?, number_at(input, y)?);
    Ok(between(input, Node::Compare(comparison, x, y), x, y))
}

fn joined(input: &mut Input<'_>, node: fn(usize, usize) -> Node, x: usize, y: usize) -> Parsed<usize> {
    let (x, y) = (condition_at(input, x)?, condition_at(input, y)?);
    Ok(between(input, node(x, y), x, y))
}

/// The node of a sign between x and y.
fn between(input: &mut Input<'_>, node: Node, x: usize, y: usize) -> usize {
    let tree = &mut input.state.tree;
    let span = tree.span(x).start..tree.span(y).end;
    tree.push(node, span)
}

fn operand(input: &mut Input<'_>) -> Parsed<usize> {
    space(input)?;
    match input.peek_token() {
        Some('(') => group(input),
        Some(c) if c.is_ascii_digit() || c == '.' => number(input),
        Some(c) if begins_word(c) => word(input),
        // Perhaps a sign.
        _ => Err(ErrMode::Backtrack(Failure(None))),
    }
}

/// `(a)`.
fn group(input: &mut Input<'_>) -> Parsed<usize> {
    let start = input.current_token_start();
    any.void().parse_next(input)?;
    wait(input, start)?;
    let inside = sum(input)?;
    closed(input, "an operator or `)`")?;
    let end = input.current_token_start();
    input.state.tree.widen(inside, start..end);
    Ok(inside)
}

fn closed(input: &mut Input<'_>, expected: &'static str) -> Parsed<()> {
    space(input)?;
    if opt(')').parse_next(input)?.is_none() {
        return unexpected(input, expected);
    }
    input.state.waiting -= 1;
    Ok(())
}

/// Digits with a point and an exponent: `1`, `.5`, `2.`, `1e-3`.
fn number(input: &mut Input<'_>) -> Parsed<usize> {
    let start = input.current_token_start();
    let exponent = |input: &mut Input<'_>| -> Parsed<()> {
        (one_of(('e', 'E')), opt(one_of(('+', '-'))), digit1).void().parse_next(input)
    };
    let mantissa = |input: &mut Input<'_>| -> Parsed<()> {
        alt(((digit1, opt(('.', opt(digit1)))).void(), ('.', digit1).void())).parse_next(input)
    };
    let checkpoint = input.checkpoint();
    let Ok(text) = (mantissa, opt(exponent)).take().parse_next(input) else {
        // A point alone.
        input.reset(&checkpoint);
        return unexpected(input, OPERAND);
    };
    let span = start..start + text.len();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(input.state.tree.push(Node::Number(number), span)),
        _ => wrong(span, ExpressionErrorKind::Number { text: text.to_owned() }),
    }
}

/// A name, with arguments if it is a function.
fn word(input: &mut Input<'_>) -> Parsed<usize> {
    let start = input.current_token_start();
    let name: &str = take_while(1.., continues_word).parse_next(input)?;
    let span = start..start + name.len();
    let checkpoint = input.checkpoint();
    space(input)?;
    let open = input.current_token_start();
    if opt('(').parse_next(input)?.is_some() {
        wait(input, open)?;
        return call(input, name, span);
    }
    input.reset(&checkpoint);
    let scope = input.state.scope;
    match (scope.resolve(name), function::function(name)) {
        (Ok(symbol), _) => Ok(input.state.tree.push(Node::Symbol(symbol, name.to_owned()), span)),
        (Err(_), Some(_)) => wrong(span, ExpressionErrorKind::WithoutArguments { name: name.to_owned() }),
        (Err(_), None) if scope.table(name).is_some() => {
            wrong(span, ExpressionErrorKind::WithoutArguments { name: name.to_owned() })
        }
        (Err(kind), None) => wrong(span, kind),
    }
}

/// The arguments of a function, after the parenthesis.
fn call(input: &mut Input<'_>, name: &str, span: Range<usize>) -> Parsed<usize> {
    if let Some(table) = input.state.scope.table(name) {
        let (takes, given) = (table.arguments(), arguments(input, None)?);
        let (whole, name) = (span.start..input.current_token_start(), name.to_owned());
        let node = match (table, &given[..]) {
            (LookupTable::Curve(table), &[x]) => Node::Table(table, name, x),
            (LookupTable::Surface(surface), &[x, y]) => Node::Surface(surface, name, x, y),
            _ => return wrong(whole, ExpressionErrorKind::TableArguments { table: name, arguments: takes }),
        };
        return Ok(input.state.tree.push(node, whole));
    }
    let Some((name, function)) = function::function(name) else {
        let name = name.to_owned();
        if input.state.scope.resolve(&name).is_ok() {
            return wrong(span, ExpressionErrorKind::NotAFunction { name });
        }
        let known: Vec<String> = function::names().map(str::to_owned).chain(input.state.scope.table_names()).collect();
        let near = function::elsewhere(&name).or_else(|| nearest(&name, known.iter().map(String::as_str)));
        let (near, known) = (near.map(str::to_owned), known.join(", "));
        return wrong(span, ExpressionErrorKind::UnknownFunction { name, nearest: near, known });
    };
    let arguments = arguments(input, Some(function))?;
    let whole = span.start..input.current_token_start();
    let (takes, fits) = function.takes(arguments.len());
    let tree = &mut input.state.tree;
    match (function, arguments.as_slice()) {
        (Function::Unary(unary), &[x]) => Ok(tree.push(Node::Unary(unary, x), whole)),
        (Function::Binary(binary), &[x, y]) => Ok(tree.push(Node::Binary(binary, x, y), whole)),
        // From the last to the first, as a stack finds them.
        (Function::Fold(binary), [first @ .., last]) if fits => {
            Ok(first.iter().rev().fold(*last, |y, x| tree.push(Node::Binary(binary, *x, y), whole.clone())))
        }
        (Function::If, &[condition, x, y]) => Ok(tree.push(Node::If(condition, x, y), whole)),
        (Function::Wrap, &[x, turn]) => Ok(tree.push(Node::Binary(Binary::Wrap, x, turn), whole)),
        (Function::Wrap, &[x]) => {
            let two = tree.push(Node::Number(2.0), whole.clone());
            let pi = tree.push(Node::Symbol(Symbol::Pi, "pi".to_owned()), whole.clone());
            let turn = tree.push(Node::Binary(Binary::Multiply, two, pi), whole.clone());
            Ok(tree.push(Node::Binary(Binary::Wrap, x, turn), whole))
        }
        (Function::Saturate, &[x, low, high]) => Ok(tree.push(Node::Saturate(x, low, high), whole)),
        (Function::Saturate, &[x]) => {
            let one = tree.push(Node::Number(1.0), whole.clone());
            let low = tree.push(Node::Unary(Unary::Negate, one), whole.clone());
            let high = tree.push(Node::Number(1.0), whole.clone());
            Ok(tree.push(Node::Saturate(x, low, high), whole))
        }
        _ => wrong(whole, ExpressionErrorKind::Arguments { function: name, expected: takes, found: arguments.len() }),
    }
}

/// The arguments after the parenthesis, and the closing one.
fn arguments(input: &mut Input<'_>, function: Option<Function>) -> Parsed<Vec<usize>> {
    let mut arguments = Vec::new();
    space(input)?;
    if input.peek_token() != Some(')') {
        loop {
            let start = input.current_token_start();
            let argument = sum(input)?;
            let is_if = function == Some(Function::If);
            arguments.push(if is_if && arguments.is_empty() {
                condition_at(input, argument)?
            } else {
                number_at(input, argument)?
            });
            match arguments.len() {
                1 if is_if => _ = input.state.tree.push(Node::Then, start..start),
                2 if is_if => _ = input.state.tree.push(Node::Else, start..start),
                _ => {}
            }
            space(input)?;
            if opt(',').parse_next(input)?.is_none() {
                break;
            }
        }
    }
    closed(input, "an operator, `,` or `)`")?;
    Ok(arguments)
}
