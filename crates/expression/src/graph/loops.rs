//! A routine as C with loops: columns and sums that repeat an operation are loops over arrays and over the entries of
//! named matrices.
//!
//! The operations and their order within a number are those of the routine, so that the bits are the same. A column of
//! numbers becomes a loop where all of them are the same operation of operands that are loops as well: entries whose
//! indices are affine in those of the loop, or numbers that do not change in it. A sum becomes a loop where its terms
//! are. Everything else is written number by number; numbers that are used once are written where they are used.
//!
//! Source: loops from straight-line code as in S. Larsen and S. Amarasinghe, Exploiting superword level parallelism
//! with multimedia instruction sets, PLDI 2000.

use core::hash::{Hash, Hasher};
use std::collections::hash_map::DefaultHasher;
use std::collections::{HashMap, HashSet};

use super::source::{self, Dialect};
use super::{Id, Node, Routine};
use crate::function::{Binary, Unary};

/// Numbers of a column, and terms of a sum, from which on they are a loop; without matrices there are none.
const FEWEST: usize = 4;

/// Numbers of different operations that are collected in an array for a loop at most.
const MOST_COLLECTED: usize = 16;

/// Characters of an operand from which on it has a name.
const LONGEST: usize = 60;

/// Levels of operands by which terms of a sum are compared.
const DEPTH: usize = 4;

/// The names and lengths of the columns that a routine reads as its inputs, and of those that it writes.
#[derive(Clone, Copy, Debug)]
pub struct Columns<'a> {
    /// The inputs, one column after the other.
    pub inputs: &'a [(&'a str, usize)],
    /// The results; one after another of the same name continues its column.
    pub results: &'a [(&'a str, usize)],
}

/// An index, affine in those of the loops around it.
#[derive(Clone, Debug)]
struct Index {
    offset: usize,
    strides: Vec<usize>,
}

/// What is computed in some nested loops.
#[derive(Clone, Debug)]
enum Form {
    /// A number or a name.
    Atom(String),
    /// An entry of an array or of a matrix.
    Entry(String, Vec<Index>),
    Operation(Node, Vec<Form>),
    /// Terms that are added or subtracted one after the other, in a loop within the others.
    Sum {
        binary: Binary,
        start: Option<Box<Form>>,
        term: Box<Form>,
        count: usize,
    },
}

/// Numbers, one for each pass of some nested loops; that of the last one changes first.
#[derive(Clone, Debug)]
struct Lanes {
    ids: Vec<Id>,
    lengths: Vec<usize>,
}

/// Where a number is stored.
#[derive(Clone, Debug)]
struct Place {
    name: String,
    entry: Option<usize>,
}

/// A sum: what its terms are added to or subtracted from, and the terms.
type Chain = (Binary, Option<Id>, Vec<Id>);

#[derive(Clone, Debug, Default)]
struct Written {
    text: Vec<String>,
    places: HashMap<Id, Place>,
    collected: HashMap<Vec<Id>, String>,
    names: usize,
}

struct Writer<'a> {
    routine: &'a Routine,
    dialect: &'a Dialect<'a>,
    columns: Columns<'a>,
    uses: Vec<usize>,
    /// Numbers of a column, and terms of a sum, from which on they are a loop.
    fewest: usize,
    /// The values of numbers without time, states and inputs.
    fixed: Vec<Option<f64>>,
    written: Written,
}

/// The body of a function of `t`, `x` and the columns.
pub(super) fn body(routine: &Routine, dialect: &Dialect, columns: Columns<'_>) -> String {
    let mut uses = vec![0; routine.code.len()];
    for operand in routine.code.iter().flat_map(|node| node.operands()).chain(routine.results.iter().copied()) {
        uses[operand as usize] += 1;
    }
    let fixed = fixed(routine, dialect.single);
    let fewest = if routine.matrices.is_empty() { usize::MAX } else { FEWEST };
    let mut writer = Writer { routine, dialect, columns, uses, fewest, fixed, written: Written::default() };
    writer.families();
    let (mut first, mut before): (usize, (&str, usize)) = (0, ("", 0));
    for (name, length) in columns.results {
        let ids = routine.results.get(first..first + length).unwrap_or_default().to_vec();
        let from = if before.0 == *name { before.1 } else { 0 };
        (first, before) = (first + length, (*name, from + length));
        let lanes = Lanes { lengths: vec![ids.len()], ids };
        if lanes.ids.len() >= writer.fewest && writer.array(&lanes, Some((*name, from))).is_some() {
            continue;
        }
        for (k, id) in lanes.ids.iter().enumerate() {
            let form = writer.single(*id);
            let (value, _) = writer.line(&form);
            writer.written.text.push(format!("    {name}[{}] = {value};", from + k));
        }
    }
    writer.written.text.iter().fold(String::new(), |text, line| text + line + "\n")
}

/// The values of numbers without time, states and inputs, as the format computes them; a condition is 1 or 0. The
/// result of one operation in binary64, rounded to binary32, is that of binary32.
fn fixed(routine: &Routine, single: bool) -> Vec<Option<f64>> {
    let round = |x: f64| if single { f64::from(x as f32) } else { x };
    let mut values: Vec<Option<f64>> = Vec::with_capacity(routine.code.len());
    for node in &routine.code {
        let of = |id: Id| values[id as usize];
        let value = match *node {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            Node::Epsilon => Some(if single { f32::EPSILON.into() } else { f64::EPSILON }),
            Node::Largest => Some(if single { f32::MAX.into() } else { f64::MAX }),
            Node::Entry(matrix, row, column) => Some(routine.entry(matrix, row, column)),
            Node::Unary(unary @ (Unary::Negate | Unary::Abs | Unary::Sqrt | Unary::Reciprocal), x) => {
                of(x).map(|x| unary.at(x))
            }
            Node::Binary(binary @ (Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide), x, y) => {
                of(x).zip(of(y)).map(|(x, y)| binary.at(x, y))
            }
            Node::Truth(truth) => Some(truth.into()),
            Node::Compare(comparison, x, y) => of(x).zip(of(y)).map(|(x, y)| comparison.at(x, y).into()),
            Node::And(x, y) => of(x).zip(of(y)).map(|(x, y)| x * y),
            Node::Or(x, y) => of(x).zip(of(y)).map(|(x, y)| x.max(y)),
            Node::Not(x) => of(x).map(|x| 1.0 - x),
            Node::Select(condition, x, y) => of(condition).and_then(|holds| of(if holds == 0.0 { y } else { x })),
            _ => None,
        };
        values.push(value.map(round));
    }
    values
}

/// An operation without its operands.
fn kind(node: Node) -> Node {
    node.renumbered(|_| 0)
}

fn is_condition(node: Node) -> bool {
    matches!(node, Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_))
}

fn commutes(node: Node) -> bool {
    matches!(node, Node::Binary(Binary::Add | Binary::Multiply, ..))
}

impl Index {
    /// The index with these values in the lanes, if it is affine and does not fall.
    fn of(values: &[usize], lengths: &[usize]) -> Option<Self> {
        let offset = *values.first()?;
        let steps = steps(lengths);
        let strides: Option<Vec<usize>> =
            steps.iter().map(|step| values.get(*step).map_or(Some(0), |value| value.checked_sub(offset))).collect();
        let strides = strides?;
        let at = |lane: usize| {
            let passes = steps.iter().zip(lengths).map(|(step, length)| lane / step % length);
            offset + passes.zip(&strides).map(|(pass, stride)| pass * stride).sum::<usize>()
        };
        values.iter().enumerate().all(|(lane, value)| *value == at(lane)).then_some(Self { offset, strides })
    }

    fn text(&self, counters: &[&str]) -> String {
        let moving = self.strides.iter().zip(counters).filter(|(stride, counter)| **stride > 0 && **counter != "0");
        let mut terms: Vec<String> = moving
            .map(
                |(stride, counter)| {
                    if *stride == 1 { (*counter).to_owned() } else { format!("({stride} * {counter})") }
                },
            )
            .collect();
        if self.offset > 0 || terms.is_empty() {
            terms.push(self.offset.to_string());
        }
        terms.join(" + ")
    }
}

/// How many lanes one pass of each loop is.
fn steps(lengths: &[usize]) -> Vec<usize> {
    (0..lengths.len()).map(|k| lengths[k + 1..].iter().product()).collect()
}

impl Lanes {
    fn one(id: Id) -> Self {
        Self { ids: vec![id], lengths: Vec::new() }
    }

    /// Without the loops in which the number does not change, and which loops are left.
    fn moving(&self) -> (Self, Vec<bool>) {
        let steps = steps(&self.lengths);
        let pass = |lane: usize, k: usize| lane / steps[k] % self.lengths[k];
        let moves =
            |k: usize| (0..self.ids.len()).any(|lane| self.ids[lane] != self.ids[lane - pass(lane, k) * steps[k]]);
        let kept: Vec<bool> = (0..self.lengths.len()).map(moves).collect();
        let first = |lane: &usize| (0..kept.len()).all(|k| kept[k] || pass(*lane, k) == 0);
        let ids = (0..self.ids.len()).filter(first).map(|lane| self.ids[lane]).collect();
        let lengths = self.lengths.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(length, _)| *length).collect();
        (Self { ids, lengths }, kept)
    }
}

impl Form {
    /// Within more loops, of which those that are kept are its own.
    fn within(self, kept: &[bool]) -> Self {
        let Self::Entry(name, indices) = self else { return self };
        let spread = |index: Index| {
            let mut own = index.strides.into_iter();
            let strides = kept.iter().map(|kept| if *kept { own.next().unwrap_or(0) } else { 0 }).collect();
            Index { offset: index.offset, strides }
        };
        Self::Entry(name, indices.into_iter().map(spread).collect())
    }
}

impl Writer<'_> {
    fn node(&self, id: Id) -> Node {
        self.routine.code[id as usize]
    }

    fn name(&mut self, letter: &str) -> String {
        self.written.names += 1;
        format!("{letter}{}", self.written.names)
    }

    /// The column of an input, and its number in it.
    fn input(&self, k: u32) -> (&str, usize) {
        let mut k = k as usize;
        for (name, length) in self.columns.inputs {
            if k < *length {
                return (name, k);
            }
            k -= length;
        }
        ("u", k)
    }

    /// Numbers that are needed more than once, of which there is one for each entry of a column, in arrays.
    fn families(&mut self) {
        let mut families: Vec<(u64, Vec<Id>)> = Vec::new();
        for id in (0..self.routine.code.len() as Id).filter(|id| self.uses[*id as usize] > 1) {
            if self.fewest < usize::MAX && self.leaf(id).is_none() {
                let class = self.class(id, DEPTH);
                match families.iter_mut().find(|(other, _)| *other == class) {
                    Some((_, family)) => family.push(id),
                    None => families.push((class, vec![id])),
                }
            }
        }
        let fewest = self.fewest;
        for (_, ids) in families.into_iter().filter(|(_, ids)| ids.len() >= fewest) {
            self.array(&Lanes { lengths: vec![ids.len()], ids }, None);
        }
    }

    /// A number that is written where it is used: a leaf, or one that is known.
    fn leaf(&self, id: Id) -> Option<Form> {
        let entry = |name: &str, indices: &[usize]| {
            let indices = indices.iter().map(|offset| Index { offset: *offset, strides: Vec::new() });
            Form::Entry(name.to_owned(), indices.collect())
        };
        Some(match self.node(id) {
            Node::State(k) => entry("x", &[k as usize]),
            Node::Input(k) => {
                let (name, k) = self.input(k);
                entry(name, &[k])
            }
            Node::Entry(matrix, row, column) => entry(self.routine.matrix(matrix), &[row as usize, column as usize]),
            node if node.is_leaf() => Form::Atom(source::operand(self.routine, self.dialect, id)),
            node if is_condition(node) => Form::Atom((self.fixed[id as usize]? != 0.0).to_string()),
            _ => {
                let value = self.fixed[id as usize].filter(|value| value.is_finite())?;
                let literal = self.dialect.literal(value);
                Form::Atom(if literal.starts_with('-') { format!("({literal})") } else { literal })
            }
        })
    }

    /// Where a number is stored.
    fn stored(&self, id: Id) -> Option<Form> {
        let Place { name, entry } = self.written.places.get(&id)?;
        Some(match entry {
            Some(offset) => Form::Entry(name.clone(), vec![Index { offset: *offset, strides: Vec::new() }]),
            None => Form::Atom(name.clone()),
        })
    }

    /// One number, outside of loops.
    fn single(&mut self, id: Id) -> Form {
        if let Some(form) = self.leaf(id).or_else(|| self.stored(id)) {
            return form;
        }
        let form = self.operation(&Lanes::one(id)).unwrap_or_else(|| {
            let operands = self.node(id).operands().map(|operand| self.single(operand)).collect();
            Form::Operation(self.node(id), operands)
        });
        if self.uses[id as usize] == 1 { form } else { self.named(id, &form) }
    }

    /// A number with a name of its own.
    fn named(&mut self, id: Id, form: &Form) -> Form {
        let name = match self.line(form) {
            (name, true) => name,
            (value, false) => {
                let (name, of) = (self.name("v"), self.type_of(self.node(id)));
                self.written.text.push(format!("    const {of} {name} = {value};"));
                name
            }
        };
        self.written.places.insert(id, Place { name: name.clone(), entry: None });
        Form::Atom(name)
    }

    fn type_of(&self, node: Node) -> &'static str {
        if is_condition(node) { "bool" } else { self.dialect.number() }
    }

    /// An operand in the loops.
    fn operand(&mut self, lanes: &Lanes) -> Option<Form> {
        if lanes.lengths.is_empty() {
            return lanes.ids.first().map(|id| self.single(*id));
        }
        let (own, kept) = lanes.moving();
        if own.lengths.is_empty() {
            let id = *own.ids.first()?;
            // It is computed before the loops.
            let form = match self.single(id) {
                form @ (Form::Operation(..) | Form::Sum { .. }) => self.named(id, &form),
                form => form,
            };
            return Some(form.within(&kept));
        }
        if let Some(form) = self.entries(&own) {
            return Some(form.within(&kept));
        }
        let is_used_here = own.lengths.len() == lanes.lengths.len()
            && own.ids.iter().all(|id| self.uses[*id as usize] == 1 && !self.written.places.contains_key(id));
        let before = self.written.clone();
        if is_used_here {
            if let Some(form) = self.operation(&own) {
                return Some(form);
            }
            self.written = before.clone();
        }
        if let Some(form) = self.array(&own, None) {
            return Some(form.within(&kept));
        }
        self.written = before;
        self.collected(&own).map(|form| form.within(&kept))
    }

    /// Entries of a column, of a matrix or of an array.
    fn entries(&self, lanes: &Lanes) -> Option<Form> {
        let mut name: Option<String> = None;
        let mut indices: Vec<Vec<usize>> = Vec::new();
        for id in &lanes.ids {
            let entry = self.stored(*id).or_else(|| self.leaf(*id))?;
            let Form::Entry(of, at) = entry else { return None };
            if name.get_or_insert_with(|| of.clone()) != &of {
                return None;
            }
            indices.resize(at.len(), Vec::new());
            indices.iter_mut().zip(at).for_each(|(all, index)| all.push(index.offset));
        }
        let indices: Option<Vec<Index>> = indices.iter().map(|values| Index::of(values, &lanes.lengths)).collect();
        Some(Form::Entry(name?, indices?))
    }

    /// The same operation in all lanes.
    fn operation(&mut self, lanes: &Lanes) -> Option<Form> {
        let node = self.node(*lanes.ids.first()?);
        if node.is_leaf() || lanes.ids.iter().any(|id| kind(self.node(*id)) != kind(node)) {
            return None;
        }
        if let Some(sum) = self.sum(lanes) {
            return Some(sum);
        }
        let mut columns: Vec<Vec<Id>> = vec![Vec::new(); node.operands().count()];
        for id in &lanes.ids {
            let mut operands: Vec<Id> = self.node(*id).operands().collect();
            // The operands of a sum and of a product are ordered by age.
            if let (true, [first, ..], [x, y]) = (commutes(node), &columns[..], &mut operands[..])
                && let Some(like) = first.first().map(|first| self.class(*first, DEPTH))
                && self.class(*x, DEPTH) != like
                && self.class(*y, DEPTH) == like
            {
                core::mem::swap(x, y);
            }
            columns.iter_mut().zip(operands).for_each(|(column, operand)| column.push(operand));
        }
        let lengths = &lanes.lengths;
        let operands: Option<Vec<Form>> =
            columns.into_iter().map(|ids| self.operand(&Lanes { ids, lengths: lengths.clone() })).collect();
        Some(Form::Operation(node, operands?))
    }

    /// A sum of like terms in all lanes.
    fn sum(&mut self, lanes: &Lanes) -> Option<Form> {
        if lanes.lengths.len() >= COUNTERS.len() {
            return None;
        }
        let chains: Option<Vec<Chain>> = lanes.ids.iter().map(|id| self.chain(*id)).collect();
        let chains = chains?;
        let (binary, start, terms) = chains.first()?;
        let (binary, has_start, count) = (*binary, start.is_some(), terms.len());
        let same = |(other, start, terms): &Chain| (*other, start.is_some(), terms.len()) == (binary, has_start, count);
        if !chains.iter().all(same) {
            return None;
        }
        let lengths = &lanes.lengths;
        let first: Vec<Id> = chains.iter().filter_map(|(_, start, _)| *start).collect();
        let ids = chains.into_iter().flat_map(|(_, _, terms)| terms).collect();
        let terms = Lanes { ids, lengths: lengths.iter().copied().chain([count]).collect() };
        let before = self.written.clone();
        let start = if has_start { Some(self.operand(&Lanes { ids: first, lengths: lengths.clone() })) } else { None };
        let term = self.operand(&terms);
        if let (Some(term), true) = (term, start.as_ref().is_none_or(Option::is_some)) {
            return Some(Form::Sum { binary, start: start.flatten().map(Box::new), term: Box::new(term), count });
        }
        self.written = before;
        None
    }

    /// A number as a sum, if it is one of enough like terms.
    fn chain(&self, id: Id) -> Option<Chain> {
        if self.fewest == usize::MAX {
            return None;
        }
        let Node::Binary(binary, x, y) = self.node(id) else { return None };
        let longest = match binary {
            Binary::Add => {
                let (one, other) = (self.followed(binary, x, y), self.followed(binary, y, x));
                if other.2.len() > one.2.len() { other } else { one }
            }
            Binary::Subtract => self.followed(binary, x, y),
            _ => return None,
        };
        (longest.2.len() >= self.fewest).then_some(longest)
    }

    /// The terms like the last one, and what is before them.
    fn followed(&self, binary: Binary, mut rest: Id, last: Id) -> Chain {
        let class = self.class(last, DEPTH);
        let is_like = |id: Id| self.class(id, DEPTH) == class;
        let mut terms = vec![last];
        while let Node::Binary(other, x, y) = self.node(rest) {
            if other != binary || self.uses[rest as usize] != 1 {
                break;
            }
            // Of the first two terms the older one is the first.
            let next = if is_like(y) && (binary == Binary::Subtract || !is_like(x) || y > x) {
                (x, y)
            } else if binary == Binary::Add && is_like(x) {
                (y, x)
            } else {
                break;
            };
            rest = next.0;
            terms.push(next.1);
        }
        let is_first = binary == Binary::Add && is_like(rest);
        if is_first {
            terms.push(rest);
        }
        terms.reverse();
        (binary, (!is_first).then_some(rest), terms)
    }

    /// What is the same of numbers that differ in indices alone.
    fn class(&self, id: Id, depth: usize) -> u64 {
        let mut hash = DefaultHasher::new();
        match self.node(id) {
            Node::Entry(matrix, ..) => (0, matrix).hash(&mut hash),
            Node::State(_) => 1.hash(&mut hash),
            Node::Input(k) => (2, self.input(k).0).hash(&mut hash),
            node if node.is_leaf() => 3.hash(&mut hash),
            node => {
                kind(node).hash(&mut hash);
                if depth > 0 {
                    let mut operands: Vec<u64> = node.operands().map(|id| self.class(id, depth - 1)).collect();
                    if commutes(node) {
                        operands.sort_unstable();
                    }
                    operands.hash(&mut hash);
                }
            }
        }
        hash.finish()
    }

    /// Numbers in a new array, or in a column of results, by a loop.
    fn array(&mut self, lanes: &Lanes, column: Option<(&str, usize)>) -> Option<Form> {
        if lanes.ids.iter().any(|id| self.written.places.contains_key(id)) || !self.are_independent(&lanes.ids) {
            return None;
        }
        let before = self.written.clone();
        let Some(form) = self.operation(lanes) else {
            self.written = before;
            return None;
        };
        let (name, from) = column.map_or_else(|| (self.name("v"), 0), |(name, from)| (name.to_owned(), from));
        if column.is_none() {
            let of = self.type_of(self.node(*lanes.ids.first()?));
            self.written.text.push(format!("    {of} {name}[{}];", lanes.ids.len()));
        }
        let place = Index { offset: from, strides: steps(&lanes.lengths) };
        let counters: Vec<&str> = COUNTERS.iter().copied().take(lanes.lengths.len()).collect();
        for (depth, (counter, length)) in counters.iter().zip(&lanes.lengths).enumerate() {
            self.written.text.push(format!("{}{}", indent(depth + 1), counted(counter, 0, *length)));
        }
        let depth = lanes.lengths.len() + 1;
        let mut lines = Vec::new();
        let (value, _) = self.text(&form, &counters, depth, &mut lines);
        self.written.text.append(&mut lines);
        self.written.text.push(format!("{}{name}[{}] = {value};", indent(depth), place.text(&counters)));
        for depth in (1..depth).rev() {
            self.written.text.push(format!("{}}}", indent(depth)));
        }
        for (entry, id) in lanes.ids.iter().enumerate() {
            self.written.places.insert(*id, Place { name: name.clone(), entry: Some(from + entry) });
        }
        Some(Form::Entry(name, vec![place]))
    }

    /// Whether none of the numbers is needed for another one.
    fn are_independent(&self, ids: &[Id]) -> bool {
        let oldest = ids.iter().min().copied().unwrap_or_default();
        let mut seen = HashSet::new();
        let mut open: Vec<Id> = ids.iter().flat_map(|id| self.node(*id).operands()).collect();
        while let Some(id) = open.pop() {
            if id >= oldest && seen.insert(id) {
                open.extend(self.node(id).operands());
            }
        }
        ids.iter().all(|id| !seen.contains(id))
    }

    /// Numbers of different operations in an array.
    fn collected(&mut self, lanes: &Lanes) -> Option<Form> {
        if lanes.ids.len() > MOST_COLLECTED {
            return None;
        }
        let place = vec![Index { offset: 0, strides: steps(&lanes.lengths) }];
        if let Some(name) = self.written.collected.get(&lanes.ids) {
            return Some(Form::Entry(name.clone(), place));
        }
        let mut values = Vec::new();
        for id in &lanes.ids {
            let form = self.single(*id);
            values.push(self.line(&form).0);
        }
        let name = self.name("v");
        let of = self.type_of(self.node(*lanes.ids.first()?));
        self.written.text.push(format!("    const {of} {name}[{}] = {{", lanes.ids.len()));
        self.written.text.extend(values.iter().map(|value| format!("        {value},")));
        self.written.text.push("    };".to_owned());
        self.written.collected.insert(lanes.ids.clone(), name.clone());
        Some(Form::Entry(name, place))
    }

    /// The text of a number outside of loops, and whether it is one name.
    fn line(&mut self, form: &Form) -> (String, bool) {
        let mut lines = Vec::new();
        let text = self.text(form, &[], 1, &mut lines);
        self.written.text.append(&mut lines);
        text
    }

    /// The text of a number in the loops, and whether it is one name; what has to be computed before it is in `lines`.
    fn text(&mut self, form: &Form, counters: &[&str], depth: usize, lines: &mut Vec<String>) -> (String, bool) {
        match form {
            Form::Atom(name) => (name.clone(), true),
            Form::Entry(name, indices) => {
                let entry = indices.iter().fold(name.clone(), |entry, index| entry + "[" + &index.text(counters) + "]");
                (entry, true)
            }
            Form::Sum { binary, start, term, count } => {
                let next = COUNTERS.get(counters.len()).copied().unwrap_or_default();
                let first = [counters, &["0"]].concat();
                let (value, from) = match start {
                    Some(start) => (self.text(start, counters, depth, lines).0, 0),
                    None => (self.text(term, &first, depth, lines).0, 1),
                };
                let name = self.name("sum");
                lines.push(format!("{}{} {name} = {value};", indent(depth), self.dialect.number()));
                lines.push(format!("{}{}", indent(depth), counted(next, from, *count)));
                let inner = [counters, &[next]].concat();
                let value = self.atom(term, &inner, depth + 1, lines, LONGEST);
                lines.push(format!("{}{name} = {name} {} {value};", indent(depth + 1), binary.name()));
                lines.push(format!("{}}}", indent(depth)));
                (name, true)
            }
            Form::Operation(node, operands) => {
                let mut texts = Vec::new();
                for (k, operand) in operands.iter().enumerate() {
                    texts.push(match (node, k) {
                        // What is between parentheses in any case.
                        (Node::Select(..), 0) | (Node::Unary(Unary::Sqrt | Unary::Abs, _), _) => {
                            self.text(operand, counters, depth, lines).0
                        }
                        // A checker of MISRA's rules does not see the parentheses of a value that is chosen.
                        (Node::Select(..), _) => self.atom(operand, counters, depth, lines, 0),
                        _ => self.atom(operand, counters, depth, lines, LONGEST),
                    });
                }
                (source::applied(self.dialect, *node, &texts).unwrap_or_default(), false)
            }
        }
    }

    /// The text of an operand, which has a name if it is longer than that.
    fn atom(
        &mut self,
        form: &Form,
        counters: &[&str],
        depth: usize,
        lines: &mut Vec<String>,
        longest: usize,
    ) -> String {
        match (self.text(form, counters, depth, lines), form) {
            ((name, true), _) => name,
            ((text, false), Form::Operation(node, _)) if text.len() > longest => {
                let (name, of) = (self.name("v"), self.type_of(*node));
                lines.push(format!("{}const {of} {name} = {text};", indent(depth)));
                name
            }
            ((text, false), Form::Operation(Node::Unary(Unary::Sqrt | Unary::Abs, _), _)) => text,
            ((text, false), _) => format!("({text})"),
        }
    }
}

/// The counters of nested loops.
const COUNTERS: [&str; 5] = ["i", "j", "k", "l", "m"];

fn indent(depth: usize) -> String {
    "    ".repeat(depth)
}

fn counted(counter: &str, from: usize, to: usize) -> String {
    format!("for (int {counter} = {from}; {counter} < {to}; ++{counter}) {{")
}
