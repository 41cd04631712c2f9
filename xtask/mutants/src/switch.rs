//! Mutants behind switches, in the text of a file.
//!
//! An expression E with the mutants E1, E2 becomes `(if off { (E) } else if on(1) { (E1) } else { (E2) })`. One mutant
//! is active at a time, so E alone has switches inside: E1 and E2 are unchanged but for their mutation, and the text
//! grows by the depth of the nesting only. A function begins with `if on(1) { return V; }`, and an arm of a `match`
//! gets a guard. What the compiler evaluates (constants, `const fn`, lengths of arrays) cannot read a switch.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::ops::Range;

use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};

use crate::Failure;
use crate::found::{Genre, Mutant};

/// The text of a file with switches in it.
#[derive(Debug, Default)]
pub(crate) struct Switched {
    pub(crate) text: String,
    /// Number of a mutant, and where its own text is.
    pub(crate) mutants: Vec<(u32, Range<usize>)>,
    /// Numbers of mutants, and the expression or function that has their switches.
    pub(crate) around: Vec<(Vec<u32>, Range<usize>)>,
    /// The first of the mutants that are reached together with each.
    pub(crate) group: HashMap<u32, u32>,
    /// Mutants without a switch, with the reason.
    pub(crate) without: Vec<(u32, &'static str)>,
}

/// Puts the mutants of one file into its text: pairs of numbers, ascending, and mutants.
pub(crate) fn switched(source: &str, mutants: &[(u32, &Mutant)]) -> Result<Switched, Failure> {
    let file = syn::parse_file(source).map_err(|error| Failure(format!("{error}")))?;
    let lines: Vec<usize> =
        std::iter::once(0).chain(source.match_indices('\n').map(|(position, _)| position + 1)).collect();
    let byte = |(line, column): (usize, usize)| {
        let start = lines[line - 1];
        source[start..].char_indices().nth(column - 1).map_or(source.len(), |(position, _)| start + position)
    };
    let placed: Vec<_> =
        mutants.iter().map(|&(id, mutant)| Placed { id, mutant, at: byte(mutant.start)..byte(mutant.end) }).collect();
    let mut finder =
        Finder { source, placed: &placed, edits: Vec::new(), constant: 0, closed: true, said: HashMap::new() };
    finder.visit_file(&file);
    let Finder { mut edits, mut said, .. } = finder;
    // The innermost function has a value's mutant.
    let mut owner: HashMap<u32, usize> = HashMap::new();
    for (k, edit) in edits.iter().enumerate().filter(|(_, edit)| edit.value) {
        for (id, _) in &edit.mutants {
            let inner = owner.entry(*id).or_insert(k);
            if edit.at.len() <= edits[*inner].at.len() {
                *inner = k;
            }
        }
    }
    for (k, edit) in edits.iter_mut().enumerate().filter(|(_, edit)| edit.value) {
        edit.mutants.retain(|(id, _)| owner[id] == k);
    }
    edits.retain(|edit| !edit.mutants.is_empty());
    let mut done = Switched::default();
    let known: Vec<u32> = edits.iter().flat_map(|edit| edit.mutants.iter().map(|(id, _)| *id)).collect();
    for (id, _) in mutants.iter().filter(|(id, _)| !known.contains(id)) {
        done.without.push((*id, said.remove(id).unwrap_or("its place in the syntax tree was not found")));
    }
    // Outer ones first; of those at the same place, the one that was found first.
    edits.sort_by_key(|edit| (edit.at.start, usize::MAX - edit.at.end));
    let mut edits = edits.into_iter().peekable();
    let mut from = 0;
    while let Some(edit) = edits.next() {
        done.text.push_str(&source[from..edit.at.start]);
        from = edit.at.end;
        done.render(source, &edit, &mut edits);
    }
    done.text.push_str(&source[from..]);
    Ok(done)
}

impl Switched {
    fn render(&mut self, source: &str, edit: &Edit, rest: &mut std::iter::Peekable<std::vec::IntoIter<Edit>>) {
        let begin = self.text.len();
        let ids: Vec<u32> = edit.mutants.iter().map(|(id, _)| *id).collect();
        // Consecutive numbers: those of one place are listed one after the other.
        let (first, count) = (ids[0], ids[ids.len() - 1] - ids[0] + 1);
        self.group.extend(ids.iter().map(|id| (*id, first)));
        self.text += &edit.before.replace("OFF", &format!("crate::luenberger_mutants::off({first}, {count})"));
        if edit.value {
            let _ = write!(self.text, "{{ if !crate::luenberger_mutants::off({first}, {count}) {{ ");
            for (id, text) in &edit.mutants {
                let _ = write!(self.text, "if crate::luenberger_mutants::on({id}) {{ return ");
                self.mutant(*id, text);
                self.text += "; } ";
            }
            self.text += "} ";
        }
        // The braces of a function are written by its switch.
        let inner = if edit.value { edit.at.start + 1..edit.at.end } else { edit.at.clone() };
        let mut from = inner.start;
        while let Some(next) = rest.next_if(|next| next.at.end <= inner.end && next.at.start >= inner.start) {
            self.text.push_str(&source[from..next.at.start]);
            from = next.at.end;
            self.render(source, &next, rest);
        }
        self.text.push_str(&source[from..inner.end]);
        self.text += &edit.after;
        if edit.branches {
            for (k, (id, text)) in edit.mutants.iter().enumerate() {
                let condition = format!("if crate::luenberger_mutants::on({id}) ");
                self.text += " else ";
                self.text += if k + 1 < edit.mutants.len() { &condition } else { "" };
                self.text += "{ ";
                self.mutant(*id, text);
                self.text += " }";
            }
            self.text += ")";
        }
        self.around.push((ids, begin..self.text.len()));
    }

    fn mutant(&mut self, id: u32, text: &str) {
        let begin = self.text.len();
        self.text += text;
        self.mutants.push((id, begin..self.text.len()));
    }
}

struct Placed<'a> {
    id: u32,
    mutant: &'a Mutant,
    at: Range<usize>,
}

/// A place that gets a switch.
struct Edit {
    at: Range<usize>,
    mutants: Vec<(u32, String)>,
    before: String,
    after: String,
    /// The body of a function.
    value: bool,
    /// An expression.
    branches: bool,
}

struct Finder<'a> {
    source: &'a str,
    placed: &'a [Placed<'a>],
    edits: Vec<Edit>,
    /// How many constants are around.
    constant: usize,
    /// The `match` whose arm comes next has one for the rest.
    closed: bool,
    said: HashMap<u32, &'static str>,
}

impl<'a> Finder<'a> {
    fn at(&self, genre: Genre, place: impl Fn(&Range<usize>) -> bool) -> Vec<&'a Placed<'a>> {
        self.placed.iter().filter(|placed| placed.mutant.genre == genre && place(&placed.at)).collect()
    }

    /// Whether there is something to do; says why not.
    fn possible(&mut self, found: &[&Placed], other: Option<&'static str>) -> bool {
        let constant = (self.constant > 0).then_some("the compiler evaluates it");
        if let Some(reason) = constant.or(other) {
            self.said.extend(found.iter().map(|placed| (placed.id, reason)));
            return false;
        }
        !found.is_empty()
    }

    fn expression(&mut self, at: Range<usize>, found: &[&Placed], other: Option<&'static str>) {
        if !self.possible(found, other) {
            return;
        }
        let text = |placed: &Placed| {
            let (before, after) = (&self.source[at.start..placed.at.start], &self.source[placed.at.end..at.end]);
            (placed.id, format!("({before}{}{after})", placed.mutant.replacement))
        };
        let mutants = found.iter().map(|placed| text(placed)).collect();
        let (before, after) = ("(if OFF { (".to_owned(), ") }".to_owned());
        self.edits.push(Edit { at, mutants, before, after, value: false, branches: true });
    }

    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let at = block.span().byte_range();
        let found = self.at(Genre::Value, |place| at.start < place.start && place.end < at.end);
        let output = signature.output.span().byte_range();
        let opaque = self.source[output].split(|c: char| !c.is_alphanumeric()).any(|word| word == "impl");
        let opaque = opaque.then_some("it returns `impl`");
        let reason = signature.asyncness.map(|_| "it is `async`").or(opaque);
        let outer = self.constant;
        self.constant += usize::from(signature.constness.is_some());
        if self.possible(&found, reason) {
            let value = |placed: &&Placed| {
                let text = &placed.mutant.replacement;
                (placed.id, if text.is_empty() { "()".to_owned() } else { text.clone() })
            };
            let mutants = found.iter().map(value).collect();
            let (before, after) = Default::default();
            self.edits.push(Edit { at, mutants, before, after, value: true, branches: false });
        }
        self.visit_block(block);
        self.constant = outer;
    }

    fn constant(&mut self, inside: impl FnOnce(&mut Self)) {
        self.constant += 1;
        inside(self);
        self.constant -= 1;
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.function(&item.sig, &item.block);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.function(&item.sig, block);
        }
    }

    fn visit_expr_binary(&mut self, expression: &'ast syn::ExprBinary) {
        let operator = expression.op.span().byte_range();
        let found = self.at(Genre::Operator, |place| place.start == operator.start);
        let is_let = |side: &syn::Expr| has_let(side);
        let chain = is_let(&expression.left) || is_let(&expression.right);
        self.expression(expression.span().byte_range(), &found, chain.then_some("a `let` is in its condition"));
        visit::visit_expr_binary(self, expression);
    }

    fn visit_expr_unary(&mut self, expression: &'ast syn::ExprUnary) {
        let operator = expression.op.span().byte_range();
        let found = self.at(Genre::Operator, |place| place.start == operator.start);
        self.expression(expression.span().byte_range(), &found, None);
        visit::visit_expr_unary(self, expression);
    }

    fn visit_expr_struct(&mut self, expression: &'ast syn::ExprStruct) {
        let fields: Vec<_> = expression.fields.iter().map(|field| field.span().byte_range().start).collect();
        let found = self.at(Genre::Field, |place| fields.contains(&place.start));
        self.expression(expression.span().byte_range(), &found, None);
        visit::visit_expr_struct(self, expression);
    }

    fn visit_expr_match(&mut self, expression: &'ast syn::ExprMatch) {
        self.visit_expr(&expression.expr);
        // cargo-mutants takes `_ if ..` for an arm that takes the rest.
        let rest = |arm: &syn::Arm| matches!(arm.pat, syn::Pat::Wild(_)) && arm.guard.is_none();
        for arm in &expression.arms {
            self.closed = expression.arms.iter().any(rest);
            self.visit_arm(arm);
        }
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let at = arm.span().byte_range();
        let found = self.at(Genre::Arm, |place| place.start == at.start);
        let open = (!self.closed).then_some("does not compile: E0004");
        if self.possible(&found, open) {
            let end = arm.pat.span().byte_range().end;
            let mutants = found.iter().map(|placed| (placed.id, String::new())).collect();
            let before = " if OFF".to_owned();
            let after = String::new();
            self.edits.push(Edit { at: end..end, mutants, before, after, value: false, branches: false });
        }
        if let Some((_, guard)) = &arm.guard {
            let at = guard.span().byte_range();
            let found = self.at(Genre::Guard, |place| place.start == at.start);
            self.expression(at, &found, has_let(guard).then_some("a `let` is in its condition"));
        }
        visit::visit_arm(self, arm);
    }

    fn visit_pat(&mut self, _: &'ast syn::Pat) {}

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.constant(|inside| visit::visit_item_const(inside, item));
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.constant(|inside| visit::visit_item_static(inside, item));
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.constant(|inside| visit::visit_impl_item_const(inside, item));
    }

    fn visit_trait_item_const(&mut self, item: &'ast syn::TraitItemConst) {
        self.constant(|inside| visit::visit_trait_item_const(inside, item));
    }

    fn visit_variant(&mut self, variant: &'ast syn::Variant) {
        self.constant(|inside| visit::visit_variant(inside, variant));
    }

    fn visit_expr_const(&mut self, expression: &'ast syn::ExprConst) {
        self.constant(|inside| visit::visit_expr_const(inside, expression));
    }

    fn visit_type(&mut self, kind: &'ast syn::Type) {
        self.constant(|inside| visit::visit_type(inside, kind));
    }

    fn visit_generic_argument(&mut self, argument: &'ast syn::GenericArgument) {
        self.constant(|inside| visit::visit_generic_argument(inside, argument));
    }

    fn visit_expr_repeat(&mut self, expression: &'ast syn::ExprRepeat) {
        self.visit_expr(&expression.expr);
        self.constant(|inside| inside.visit_expr(&expression.len));
    }
}

/// Whether the condition binds names.
fn has_let(condition: &syn::Expr) -> bool {
    match condition {
        syn::Expr::Let(_) => true,
        syn::Expr::Binary(both) => has_let(&both.left) || has_let(&both.right),
        _ => false,
    }
}
