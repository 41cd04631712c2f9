//! Polynomials with outward rounded coefficients: right-hand sides are collected by monomials, so that terms cancel
//! before the enclosure.
//!
//! The two sides of `Dphi f = Lambda phi + B` are large and their difference is zero: over a box, interval arithmetic
//! ignores that both contain the same `x1^2 + sin x1` and returns twice its width. Here a value is a polynomial in
//! atoms, the variables and functions of polynomials (`sin x1`, `1/(1 + x1^2)`), with outward rounded coefficients.
//! Equal atoms are identified, equal monomials are added, and the remaining difference is evaluated over a box. For a
//! phi that solves the equation, only the rounding of the coefficients remains.
//!
//! An interval coefficient stands for one unknown number in it, and two equal intervals need not stand for the same
//! number. Functions of polynomials with such coefficients are therefore identified only if they were computed by the
//! same operations from the same values.
//!
//! [`SymbolicPolynomial`] is a scalar, so that a map that is generic over the scalar is collected by evaluating it. If
//! that is impossible (a branch, an absolute value, too many terms), this is recorded, and there is no result. A
//! polynomial encloses the function wherever all atoms are defined.
//!
//! The arena of an evaluation is thread-local, and every value carries the number of its arena. A value of another
//! arena (kept from an earlier evaluation) or of none (created on another thread) has no polynomial here: an operation
//! on it leaves the evaluation without a result. If a value is used elsewhere, where a comparison is undecidable, the
//! evaluation it belongs to has no result. Not detected: a map that delegates work to a thread which is itself in
//! another evaluation, if that thread compares constants only.

mod scalar;

use core::cell::RefCell;
use core::ops::{Add, Mul, Sub};
use core::sync::atomic::{AtomicU64, Ordering};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Mutex, MutexGuard, PoisonError};

use luenberger_proof::{Interval, Ring};

/// Most monomials of one polynomial.
const MONOMIALS: usize = 2000;
/// Most values in one arena: 64 MB or so at worst.
const VALUES: usize = 50_000;
/// The largest exponent that is multiplied out.
const POWER: u32 = 32;

/// Below this a product of numbers may have lost digits that its rounding error does not show.
const UNDERFLOW: f64 = 1e-250;

/// What leaves an evaluation without a result when one of its values is used in another arena, or one of another arena
/// on its own.
pub(crate) const ELSEWHERE: &str = "a value of another evaluation or of another thread";

/// A value in an arena: a polynomial in atoms. Plants and maps use it as their scalar `T`.
#[derive(Clone, Copy, Debug)]
pub struct SymbolicPolynomial {
    /// The number of its arena; 0 for a value that was made where there is none.
    arena: u64,
    at: usize,
}

/// Powers of atoms, by the atom; negative ones come from divisions by a single monomial, so that x/x is 1.
pub(crate) type Monomial = Vec<(usize, i32)>;

/// Monomials in order, each once, none with the coefficient 0.
pub(crate) type Polynomial = Vec<(Monomial, Interval)>;

/// The functions that have atoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Recip,
    Exp,
    Ln,
    Sin,
    Cos,
    Sqrt,
    Atan,
    Tanh,
}

impl Function {
    /// -1 for an odd function, 1 for an even one, 0 for others.
    fn parity(self) -> i8 {
        match self {
            Self::Sin | Self::Atan | Self::Tanh => -1,
            Self::Cos => 1,
            Self::Recip | Self::Exp | Self::Ln | Self::Sqrt => 0,
        }
    }

    fn at(self, x: &Interval) -> Option<Interval> {
        match self {
            Self::Recip => reciprocal(x),
            Self::Exp => Some(x.exp()),
            Self::Ln => x.ln(),
            Self::Sin => Some(x.sin()),
            Self::Cos => Some(x.cos()),
            Self::Sqrt => x.sqrt(),
            Self::Atan => Some(x.atan()),
            Self::Tanh => Some(x.tanh()),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Atom {
    Variable(usize),
    Of(Function, Argument),
}

/// The argument of a function, and the value of the arena that it is, if it is one.
#[derive(Clone, Debug)]
struct Argument {
    polynomial: Polynomial,
    value: Option<usize>,
}

impl PartialEq for Argument {
    /// Whether both are the same function for sure.
    fn eq(&self, other: &Self) -> bool {
        let same_value = self.value.is_some() && self.value == other.value;
        same_value || (self.polynomial == other.polynomial && is_exact(&self.polynomial))
    }
}

/// How a value was made: operation and operands.
type Origin = (u8, u64, u64);

/// The polynomials of one evaluation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arena {
    number: u64,
    values: Vec<Polynomial>,
    origins: HashMap<Origin, usize>,
    atoms: Vec<Atom>,
    failed: Option<&'static str>,
    questions: usize,
}

thread_local! {
    static ARENA: RefCell<Option<Arena>> = const { RefCell::new(None) };
}

/// The number of the last arena. None has the number 0.
static LAST: AtomicU64 = AtomicU64::new(0);

/// The arenas being written on all threads, and whether a value of theirs was used elsewhere.
static WRITTEN: Mutex<BTreeMap<u64, bool>> = Mutex::new(BTreeMap::new());

fn written() -> MutexGuard<'static, BTreeMap<u64, bool>> {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An arena being written. It puts the previous one back when it is dropped.
struct Writing {
    number: u64,
    previous: Option<Arena>,
}

impl Writing {
    fn begin() -> Self {
        let number = LAST.fetch_add(1, Ordering::Relaxed) + 1;
        written().insert(number, false);
        let previous = ARENA.with(|cell| cell.replace(Some(Arena { number, ..Arena::default() })));
        Self { number, previous }
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        ARENA.with(|cell| cell.replace(self.previous.take()));
        written().remove(&self.number);
    }
}

/// The result of `f` in its own arena, with the arena; or the operation that has no polynomial.
pub(crate) fn collect<R>(f: impl FnOnce() -> R) -> Result<(R, Arena), &'static str> {
    let writing = Writing::begin();
    let result = f();
    let arena = ARENA.with(|cell| cell.borrow_mut().take()).unwrap_or_default();
    let elsewhere = written().get(&writing.number).is_none_or(|elsewhere| *elsewhere);
    drop(writing);
    match arena.failed {
        Some(what) => Err(what),
        None if elsewhere => Err(ELSEWHERE),
        None => Ok((result, arena)),
    }
}

/// The evaluations that these values belong to have no result, unless they are of the arena `here`.
fn used_elsewhere(values: &[SymbolicPolynomial], here: u64) {
    for value in values.iter().filter(|value| value.arena != here && value.arena != 0) {
        if let Some(elsewhere) = written().get_mut(&value.arena) {
            *elsewhere = true;
        }
    }
}

/// The value of this origin in the current arena, made of `operands`; without an arena (a thread of the map's own) a
/// value of none.
fn in_arena(
    origin: Option<Origin>,
    operands: &[SymbolicPolynomial],
    f: impl FnOnce(&mut Arena) -> Option<Polynomial>,
) -> SymbolicPolynomial {
    ARENA.with(|cell| {
        let mut cell = cell.borrow_mut();
        used_elsewhere(operands, cell.as_ref().map_or(0, |arena| arena.number));
        let Some(arena) = cell.as_mut() else { return SymbolicPolynomial { arena: 0, at: 0 } };
        if operands.iter().any(|operand| operand.arena != arena.number) {
            arena.fail(ELSEWHERE);
        } else if let Some(&at) = origin.as_ref().and_then(|origin| arena.origins.get(origin)) {
            return SymbolicPolynomial { arena: arena.number, at };
        }
        let value = if arena.failed.is_some() { Vec::new() } else { f(arena).unwrap_or_else(|| arena.fail(ELSEWHERE)) };
        let kept = arena.keep(value);
        if let Some(origin) = origin {
            arena.origins.insert(origin, kept.at);
        }
        kept
    })
}

/// Notes what has no polynomial.
pub(crate) fn fail(what: &'static str) -> SymbolicPolynomial {
    in_arena(None, &[], |arena| Some(arena.fail(what)))
}

/// An answer is asked for that these values do not have: a comparison that depends on more than constants, a conversion
/// to a number. The evaluation has no result. Where the answer is a choice it alternates, so that loops end.
pub(crate) fn open_question(what: &'static str, operands: &[SymbolicPolynomial]) -> bool {
    ARENA.with(|cell| {
        let mut cell = cell.borrow_mut();
        used_elsewhere(operands, cell.as_ref().map_or(0, |arena| arena.number));
        let Some(arena) = cell.as_mut() else {
            // Nobody knows which evaluation is being answered.
            written().values_mut().for_each(|elsewhere| *elsewhere = true);
            return false;
        };
        arena.fail(what);
        arena.questions += 1;
        arena.questions % 2 == 0
    })
}

impl SymbolicPolynomial {
    /// A number: the same one wherever the interval is a point, another one each time where it is not.
    pub(crate) fn constant(value: Interval) -> Self {
        let origin = value.is_point().then(|| (0, value.lo().to_bits(), 0));
        in_arena(origin, &[], |_| Some(constant(value)))
    }

    /// A number with a name, which is one number whenever it is asked for.
    pub(crate) fn named(name: u64, value: Interval) -> Self {
        in_arena(Some((1, name, 0)), &[], |_| Some(constant(value)))
    }

    pub(crate) fn variable(k: usize) -> Self {
        in_arena(Some((2, k as u64, 0)), &[], |arena| Some(arena.atom(Atom::Variable(k))))
    }

    pub(crate) fn of(self, function: Function) -> Self {
        in_arena(Some((3, function as u64, self.at as u64)), &[self], |arena| {
            let argument = Argument { polynomial: arena.value(self)?, value: Some(self.at) };
            Some(arena.apply(function, argument))
        })
    }

    /// The number, where it is one.
    pub(crate) fn as_constant(self) -> Option<Interval> {
        ARENA.with(|cell| cell.borrow().as_ref().and_then(|arena| number(&arena.value(self)?)))
    }

    /// The operation with this number.
    fn with(
        self,
        rhs: Self,
        operation: u8,
        f: impl FnOnce(&mut Arena, &Polynomial, &Polynomial) -> Polynomial,
    ) -> Self {
        in_arena(Some((operation, self.at as u64, rhs.at as u64)), &[self, rhs], |arena| {
            let (x, y) = (arena.value(self)?, arena.value(rhs)?);
            Some(f(arena, &x, &y))
        })
    }
}

impl Add for SymbolicPolynomial {
    type Output = Self;

    fn add(self, rhs: Self) -> Self {
        self.with(rhs, 4, |_, x, y| sum(x, y, false))
    }
}

impl Sub for SymbolicPolynomial {
    type Output = Self;

    fn sub(self, rhs: Self) -> Self {
        self.with(rhs, 5, |_, x, y| sum(x, y, true))
    }
}

impl Mul for SymbolicPolynomial {
    type Output = Self;

    fn mul(self, rhs: Self) -> Self {
        self.with(rhs, 6, Arena::product)
    }
}

/// The product, without a rounding where it has none.
fn times(x: &Interval, y: &Interval) -> Interval {
    if x.is_point() && y.is_point() {
        let (x, y) = (x.lo(), y.lo());
        let product = x * y;
        let exact = product.abs() > UNDERFLOW && x.mul_add(y, -product) == 0.0;
        if let Some(product) = Interval::from_f64(product).filter(|_| exact) {
            return product;
        }
    }
    x.mul(y)
}

/// `1/x`, without a rounding where it has none.
fn reciprocal(x: &Interval) -> Option<Interval> {
    if x.is_point() {
        let (x, inverse) = (x.lo(), x.lo().recip());
        if x.mul_add(inverse, -1.0) == 0.0 {
            return Interval::from_f64(inverse);
        }
    }
    x.recip()
}

fn constant(value: Interval) -> Polynomial {
    if value.is_zero() { Vec::new() } else { vec![(Vec::new(), value)] }
}

fn number(p: &Polynomial) -> Option<Interval> {
    match p.as_slice() {
        [] => Some(Interval::zero()),
        [(monomial, coefficient)] if monomial.is_empty() => Some(*coefficient),
        _ => None,
    }
}

/// Whether every coefficient is one number.
pub(crate) fn is_exact(p: &Polynomial) -> bool {
    p.iter().all(|(_, coefficient)| coefficient.is_point())
}

/// `p + q`, or `p - q`.
pub(crate) fn sum(p: &Polynomial, q: &Polynomial, negated: bool) -> Polynomial {
    let mut result = p.clone();
    for (monomial, coefficient) in q {
        let coefficient = if negated { coefficient.neg() } else { *coefficient };
        match result.binary_search_by(|(other, _)| other.cmp(monomial)) {
            Ok(at) => {
                result[at].1 = result[at].1.add(&coefficient);
                if result[at].1.is_zero() {
                    result.remove(at);
                }
            }
            Err(at) => result.insert(at, (monomial.clone(), coefficient)),
        }
    }
    result
}

impl Arena {
    fn keep(&mut self, value: Polynomial) -> SymbolicPolynomial {
        let at = self.values.len();
        if at >= VALUES {
            self.failed.get_or_insert("too many operations");
        } else {
            self.values.push(value);
        }
        SymbolicPolynomial { arena: self.number, at }
    }

    fn fail(&mut self, what: &'static str) -> Polynomial {
        self.failed.get_or_insert(what);
        Vec::new()
    }

    /// The polynomial of a value of this arena; none for a value of another or of no arena.
    pub(crate) fn value(&self, value: SymbolicPolynomial) -> Option<Polynomial> {
        (value.arena == self.number).then(|| self.values.get(value.at).cloned())?
    }

    /// The polynomials of these values.
    ///
    /// # Errors
    /// [`ELSEWHERE`] where one is of another or of no arena.
    pub(crate) fn polynomials(&self, values: &[SymbolicPolynomial]) -> Result<Vec<Polynomial>, &'static str> {
        values.iter().map(|value| self.value(*value)).collect::<Option<_>>().ok_or(ELSEWHERE)
    }

    /// The variables that p depends on, through the arguments of functions too. Of others it does not depend, wherever
    /// the atoms are defined.
    pub(crate) fn variables(&self, p: &Polynomial) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for atom in p.iter().flat_map(|(monomial, _)| monomial.iter().map(|(atom, _)| *atom)) {
            match &self.atoms[atom] {
                Atom::Variable(k) => {
                    found.insert(*k);
                }
                // An argument holds older atoms only, so that this ends.
                Atom::Of(_, argument) => found.append(&mut self.variables(&argument.polynomial)),
            }
        }
        found
    }

    /// Whether every root of the arena that depends on one of these variables is of what is above 0 at these values of
    /// the atoms, so that it has a derivative.
    pub(crate) fn roots_are_smooth(&self, variables: impl Fn(usize) -> bool, atoms: &[Interval]) -> bool {
        self.atoms.iter().all(|atom| match atom {
            Atom::Of(Function::Sqrt, argument) if self.variables(&argument.polynomial).into_iter().any(&variables) => {
                evaluate(&argument.polynomial, atoms).is_some_and(|argument| argument.lo() > 0.0)
            }
            _ => true,
        })
    }

    fn atom(&mut self, atom: Atom) -> Polynomial {
        let at = self.atoms.iter().position(|other| *other == atom).unwrap_or_else(|| {
            self.atoms.push(atom);
            self.atoms.len() - 1
        });
        vec![(vec![(at, 1)], Interval::ONE)]
    }

    fn apply(&mut self, function: Function, argument: Argument) -> Polynomial {
        match number(&argument.polynomial) {
            Some(x) => match function.at(&x) {
                Some(value) => constant(value),
                None => self.fail("a function outside its domain"),
            },
            None if function == Function::Recip && argument.polynomial.len() == 1 => {
                // Kept as an atom too, so that a box on which it is not defined has no result.
                let inverse = argument.polynomial[0].clone();
                self.atom(Atom::Of(function, argument));
                match reciprocal(&inverse.1) {
                    Some(coefficient) => {
                        vec![(inverse.0.into_iter().map(|(atom, power)| (atom, -power)).collect(), coefficient)]
                    }
                    None => self.fail("a division by a constant that may be 0"),
                }
            }
            None => self.function(function, argument),
        }
    }

    /// The atom of a function. That of `-p` is the one of p where the function is odd or even.
    fn function(&mut self, function: Function, argument: Argument) -> Polynomial {
        let parity = function.parity();
        let negative = argument.polynomial.first().is_some_and(|(_, leading)| leading.hi() < 0.0);
        if parity == 0 || !negative || !is_exact(&argument.polynomial) {
            return self.atom(Atom::Of(function, argument));
        }
        let polynomial = sum(&Vec::new(), &argument.polynomial, true);
        let own = self.atom(Atom::Of(function, Argument { polynomial, value: None }));
        sum(&Vec::new(), &own, parity < 0)
    }

    pub(crate) fn product(&mut self, p: &Polynomial, q: &Polynomial) -> Polynomial {
        if p.len() * q.len() > 10 * MONOMIALS {
            return self.fail("too many terms");
        }
        let mut terms: Polynomial = Vec::with_capacity(p.len() * q.len());
        for (left, x) in p {
            for (right, y) in q {
                let mut monomial = left.clone();
                for &(atom, power) in right {
                    match monomial.binary_search_by_key(&atom, |(atom, _)| *atom) {
                        Ok(at) => monomial[at].1 += power,
                        Err(at) => monomial.insert(at, (atom, power)),
                    }
                }
                monomial.retain(|(_, power)| *power != 0);
                if monomial.iter().any(|(_, power)| power.unsigned_abs() > POWER) {
                    return self.fail("a high power");
                }
                terms.push((monomial, times(x, y)));
            }
        }
        terms.sort_by(|x, y| x.0.cmp(&y.0));
        let mut result: Polynomial = Vec::with_capacity(terms.len());
        for (monomial, coefficient) in terms {
            match result.last_mut() {
                Some(last) if last.0 == monomial => last.1 = last.1.add(&coefficient),
                _ => result.push((monomial, coefficient)),
            }
        }
        result.retain(|(_, coefficient)| !coefficient.is_zero());
        if result.len() > MONOMIALS { self.fail("too many terms") } else { result }
    }

    /// The derivative of p along the field whose component at variable k is `field(k)`.
    pub(crate) fn along(&mut self, p: &Polynomial, field: &[Polynomial]) -> Polynomial {
        let mut result = Vec::new();
        let mut atoms: Vec<usize> = p.iter().flat_map(|(monomial, _)| monomial.iter().map(|(atom, _)| *atom)).collect();
        atoms.sort_unstable();
        atoms.dedup();
        for atom in atoms {
            if self.failed.is_some() {
                break;
            }
            let rate = match self.atoms[atom].clone() {
                Atom::Variable(k) => field.get(k).cloned().unwrap_or_default(),
                Atom::Of(function, argument) => {
                    // An argument holds older atoms only, so that this ends.
                    let inner = self.along(&argument.polynomial, field);
                    let outer = self.slope(function, atom, &argument);
                    self.product(&outer, &inner)
                }
            };
            let partial = self.product(&partial(p, atom), &rate);
            result = sum(&result, &partial, false);
        }
        result
    }

    /// The derivative of a function, of which `atom` is the value at `argument`.
    fn slope(&mut self, function: Function, atom: usize, argument: &Argument) -> Polynomial {
        let one = constant(Interval::ONE);
        let own = |power| vec![(vec![(atom, power)], Interval::ONE)];
        let minus = |p: &Polynomial| sum(&Vec::new(), p, true);
        match function {
            Function::Recip => minus(&own(2)),
            Function::Exp => own(1),
            Function::Ln => self.apply(Function::Recip, argument.clone()),
            Function::Sin => self.apply(Function::Cos, argument.clone()),
            Function::Cos => minus(&self.apply(Function::Sin, argument.clone())),
            Function::Sqrt => {
                let polynomial = sum(&own(1), &own(1), false);
                self.apply(Function::Recip, Argument { polynomial, value: None })
            }
            Function::Atan => {
                let square = self.product(&argument.polynomial, &argument.polynomial);
                self.apply(Function::Recip, Argument { polynomial: sum(&one, &square, false), value: None })
            }
            Function::Tanh => sum(&one, &own(2), true),
        }
    }

    /// Whether something had no polynomial.
    pub(crate) fn failed(&self) -> Option<&'static str> {
        self.failed
    }

    /// The atoms over a box of variables, or None where one of them is not defined on the whole box.
    pub(crate) fn atoms_over(&self, variables: &[Interval]) -> Option<Vec<Interval>> {
        let mut values = Vec::with_capacity(self.atoms.len());
        for atom in &self.atoms {
            let value = match atom {
                Atom::Variable(k) => *variables.get(*k)?,
                Atom::Of(function, argument) => function.at(&evaluate(&argument.polynomial, &values)?)?,
            };
            values.push(value);
        }
        Some(values)
    }
}

/// `dp/da`, a being an atom.
fn partial(p: &Polynomial, atom: usize) -> Polynomial {
    let mut result = Vec::new();
    for (monomial, coefficient) in p {
        let Some(at) = monomial.iter().position(|(other, _)| *other == atom) else { continue };
        let mut monomial = monomial.clone();
        let power = monomial[at].1;
        if power == 1 {
            monomial.remove(at);
        } else {
            monomial[at].1 -= 1;
        }
        let factor = Interval::of(f64::from(power));
        result = sum(&result, &vec![(monomial, times(coefficient, &factor))], false);
    }
    result
}

/// A polynomial at these values of the atoms; None for an atom that has no value.
pub(crate) fn evaluate(p: &Polynomial, atoms: &[Interval]) -> Option<Interval> {
    let mut total = Interval::zero();
    for (monomial, coefficient) in p {
        let mut term = *coefficient;
        for (atom, power) in monomial {
            term = times(&term, &atoms.get(*atom)?.powi(*power)?);
        }
        total = total.add(&term);
    }
    Some(total)
}

#[cfg(test)]
mod tests {
    use nalgebra::{ComplexField, RealField, convert};
    use num_traits::{Num, One};

    use super::*;
    use crate::enclosure::IntervalDual;
    use crate::enclosure::paths::explore;

    /// Every function with an atom or made of atoms, of an argument that is not a bare variable.
    fn functions<T: RealField + Copy>(x: T) -> Vec<T> {
        let inner = x * x * convert(0.7) + convert(0.2);
        vec![
            inner.recip(),
            inner.exp(),
            inner.ln(),
            inner.sin(),
            inner.cos(),
            inner.sqrt(),
            inner.atan(),
            inner.tanh(),
            inner.tan(),
            inner.sinh(),
            inner.cosh(),
            inner.ln_1p(),
            inner.exp_m1(),
            inner.exp2(),
            inner.log2(),
            inner.log10(),
            inner.powi(3),
            inner.powi(-2),
            inner.powf(convert(0.3)),
            inner.powf(convert(2.0)),
            inner.hypot(x),
            (inner.sin() * inner.exp()).recip() - inner / (inner + T::pi()),
            inner.mul_add(x, T::two_pi()),
        ]
    }

    /// Derivatives and values against the interval scalar, whose own are held against dual numbers: both enclose one
    /// number, so that they meet, and neither is wide.
    #[test]
    fn derivatives_are_those_of_the_interval_scalar() {
        for at in [0.25, 0.5, 0.875] {
            let x = Interval::from_f64(at).unwrap();
            let dual = explore(|| functions(IntervalDual::new(x, Interval::ONE))).unwrap().remove(0);
            let (values, mut arena) = collect(|| functions(SymbolicPolynomial::variable(0))).unwrap();
            for (k, (value, dual)) in values.into_iter().zip(dual).enumerate() {
                let polynomial = arena.value(value).unwrap();
                let slope = arena.along(&polynomial, &[constant(Interval::ONE)]);
                let atoms = arena.atoms_over(&[x]).unwrap();
                for (found, expected) in [
                    (evaluate(&polynomial, &atoms).unwrap(), dual.value()),
                    (evaluate(&slope, &atoms).unwrap(), dual.slope()),
                ] {
                    assert!(found.intersection(&expected).is_some(), "function {k} at {at}: {found:?}, {expected:?}");
                    // Some tens of operations, each with a rounding or two, on numbers below 100.
                    assert!(found.width() <= 1e-12, "function {k} at {at}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_equal_cancels_and_what_only_looks_equal_does_not() {
        let difference = |f: fn(SymbolicPolynomial) -> SymbolicPolynomial| {
            let (value, arena) = collect(|| f(SymbolicPolynomial::variable(0))).unwrap();
            arena.value(value).unwrap()
        };
        assert!(
            difference(|x| (x + SymbolicPolynomial::one()).powi(2) - x * x - x - x - SymbolicPolynomial::one())
                .is_empty()
        );
        assert!(difference(|x| x.sin() * x.exp() - x.exp() * x.sin()).is_empty());
        assert!(difference(|x| x.exp() * x / (x * x.exp() * convert(0.5)) - convert(2.0)).is_empty());
        // A third, made twice by the same operations, is one number; so is pi.
        assert!(difference(|x| (x / convert(3.0)).sin() - (x / convert(3.0)).sin()).is_empty());
        assert!(difference(|x| (x * SymbolicPolynomial::pi()).sin() - (x * SymbolicPolynomial::pi()).sin()).is_empty());
        // The same bounds, and perhaps another number between them.
        let decimal = |x: SymbolicPolynomial| (x * SymbolicPolynomial::from_str_radix("0.1", 10).unwrap()).sin();
        let (value, arena) =
            collect(|| decimal(SymbolicPolynomial::variable(0)) - decimal(SymbolicPolynomial::variable(0))).unwrap();
        assert_eq!(arena.value(value).unwrap().len(), 2);
        // In the open, an interval coefficient leaves its width.
        let left = difference(|x| x / convert(3.0) - x / convert(3.0));
        assert!(left.len() == 1 && left[0].1.contains(0.0) && left[0].1.width() < 1e-15, "{left:?}");
    }

    #[test]
    fn what_has_no_polynomial_is_said() {
        let failure = |f: fn(SymbolicPolynomial) -> SymbolicPolynomial| {
            collect(|| f(SymbolicPolynomial::variable(0))).unwrap_err()
        };
        assert_eq!(failure(ComplexField::abs), "an absolute value");
        assert_eq!(failure(|x| if x > SymbolicPolynomial::one() { x } else { -x }), "a comparison");
        assert_eq!(failure(|x| x.powi(65)), "a high power");
        assert_eq!(failure(|x| (0..40).fold(x, |product, _| product * x)), "a high power");
        assert_eq!(failure(|x| x * convert(f64::NAN)), "a constant that is not finite");
        // Loops on an open comparison end, whichever way they ask.
        let endless = |f: fn(SymbolicPolynomial)| collect(|| f(SymbolicPolynomial::variable(0))).is_err();
        assert!(
            endless(|x| while x < SymbolicPolynomial::one() {}) && endless(|x| while x >= SymbolicPolynomial::one() {})
        );
        // Too many terms: (x + sin x + cos x + ...)^k.
        let many = |x: SymbolicPolynomial| {
            let sum = (1..12).fold(x, |sum, k| sum + (x * convert(f64::from(k))).sin());
            (0..8).fold(sum, |product, _| product * sum)
        };
        assert_eq!(collect(|| many(SymbolicPolynomial::variable(0))).unwrap_err(), "too many terms");
        // Comparisons of constants are no branches.
        assert!(
            collect(|| if SymbolicPolynomial::pi() > convert(3.0) { SymbolicPolynomial::one() } else { fail("no") })
                .is_ok()
        );
    }

    /// x/x is 1, except at 0.
    #[test]
    fn what_cancels_has_to_be_defined() {
        let (value, arena) = collect(|| SymbolicPolynomial::variable(0) / SymbolicPolynomial::variable(0)).unwrap();
        assert_eq!(number(&arena.value(value).unwrap()), Some(Interval::ONE));
        assert!(arena.atoms_over(&[Interval::new(0.5, 1.0).unwrap()]).is_some());
        assert!(arena.atoms_over(&[Interval::new(-1.0, 1.0).unwrap()]).is_none());
    }

    #[test]
    fn odd_and_even_functions_know_their_sign() {
        let cancels = |f: fn(SymbolicPolynomial) -> SymbolicPolynomial| {
            let (value, arena) = collect(|| f(SymbolicPolynomial::variable(0))).unwrap();
            arena.value(value).unwrap().is_empty()
        };
        assert!(cancels(|x| x.sin() + (-x).sin()) && cancels(|x| x.cos() - (-x).cos()));
        assert!(cancels(|x| (x * x - x).atan() + (x - x * x).atan()) && cancels(|x| x.tanh() + (-x).tanh()));
        assert!(!cancels(|x| x.exp() - (-x).exp()) && !cancels(|x| x.sin() - (-x).sin()));
    }

    #[test]
    fn values_of_other_arenas_and_of_none_are_refused() {
        let stray = SymbolicPolynomial::one() + SymbolicPolynomial::variable(3);
        assert!(stray.as_constant().is_none());
        let (kept, _) = collect(|| SymbolicPolynomial::variable(0)).unwrap();
        for foreign in [stray, kept] {
            assert_eq!(collect(|| SymbolicPolynomial::variable(0) + foreign).unwrap_err(), ELSEWHERE);
            assert_eq!(collect(|| foreign.sin()).unwrap_err(), ELSEWHERE);
            assert!(collect(|| foreign > SymbolicPolynomial::one()).is_err());
            // Handed on without an operation.
            let (value, arena) = collect(|| foreign).unwrap();
            assert!(arena.value(value).is_none() && arena.polynomials(&[value]) == Err(ELSEWHERE));
        }
        // A value of this arena in an operation on another one, or in a thread without one: neither has a result.
        let inner = collect(|| {
            let outer = SymbolicPolynomial::variable(0);
            collect(|| outer + SymbolicPolynomial::one()).unwrap_err()
        });
        assert_eq!(inner.unwrap_err(), ELSEWHERE);
        let thread = collect(|| {
            let x = SymbolicPolynomial::variable(0);
            std::thread::scope(|scope| scope.spawn(move || x + x).join()).is_ok()
        });
        assert_eq!(thread.unwrap_err(), ELSEWHERE);
    }

    #[test]
    fn arenas_nest() {
        let ((outer, inner), arena) = collect(|| {
            let outer = SymbolicPolynomial::variable(0);
            let inner = collect(|| SymbolicPolynomial::variable(1).abs()).is_err();
            (outer + SymbolicPolynomial::one(), inner)
        })
        .unwrap();
        assert!(inner && arena.value(outer).unwrap().len() == 2);
        assert_eq!(arena.atoms_over(&[]), None);
    }
}
