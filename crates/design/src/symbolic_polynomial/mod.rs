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

mod arena;
pub(crate) mod polynomial;
mod scalar;

use core::cell::RefCell;
use core::ops::{Add, Mul, Sub};
use core::sync::atomic::{AtomicU64, Ordering};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use luenberger_proof::Interval;

pub use arena::Arena;
pub(crate) use arena::Function;
use arena::{Argument, Atom, Origin};
pub(crate) use polynomial::{Monomial, Polynomial, evaluate, is_exact, sum};
use polynomial::{constant, number};

/// What leaves an evaluation without a result when one of its values is used in another arena, or one of another arena
/// on its own.
pub const ELSEWHERE: &str = "a value of another evaluation or of another thread";

/// A value of a symbolic evaluation: a polynomial in atoms. Plants and maps use it as their scalar `T`.
#[derive(Clone, Copy, Debug)]
pub struct SymbolicPolynomial {
    /// The number of its arena; 0 for a value that was made where there is none.
    arena: u64,
    at: usize,
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
        let previous = ARENA.with(|cell| cell.replace(Some(Arena::numbered(number))));
        Self { number, previous }
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        ARENA.with(|cell| cell.replace(self.previous.take()));
        written().remove(&self.number);
    }
}

/// The result of `f` in its own arena, with the arena.
///
/// # Errors
/// The operation that has no polynomial.
pub fn collect<R>(f: impl FnOnce() -> R) -> Result<(R, Arena), &'static str> {
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
pub fn fail(what: &'static str) -> SymbolicPolynomial {
    in_arena(None, &[], |arena| Some(arena.fail(what)))
}

/// An answer is asked for that these values do not have: a comparison that depends on more than constants, a conversion
/// to a number. The evaluation has no result. Where the answer is a choice it alternates, so that loops end.
pub(crate) fn open_question(what: &'static str, operands: &[SymbolicPolynomial]) -> bool {
    ARENA.with(|cell| {
        let mut cell = cell.borrow_mut();
        used_elsewhere(operands, cell.as_ref().map_or(0, |arena| arena.number));
        let Some(arena) = cell.as_mut() else {
            // It is unknown which evaluation this belongs to.
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

    /// The k-th variable of the evaluation.
    pub fn variable(k: usize) -> Self {
        in_arena(Some((2, k as u64, 0)), &[], |arena| Some(arena.atom(Atom::Variable(k))))
    }

    pub(crate) fn of(self, function: Function) -> Self {
        in_arena(Some((3, function as u64, self.at as u64)), &[self], |arena| {
            let argument = Argument { polynomial: arena.value(self)?, value: Some(self.at) };
            Some(arena.apply(function, argument))
        })
    }

    /// The number, where it is one.
    pub fn as_constant(self) -> Option<Interval> {
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
