//! Symbolic polynomials: derivatives against dual numbers, cancellation, and values of other arenas.

use luenberger_design::SymbolicPolynomial;
use luenberger_design::enclosure::IntervalDual;
use luenberger_design::internals::{ELSEWHERE, collect, constant, evaluate, explore, fail, number};
use luenberger_proof::{Interval, Ring};
use nalgebra::{ComplexField, RealField, convert};
use num_traits::{Num, One};

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
        difference(|x| (x + SymbolicPolynomial::one()).powi(2) - x * x - x - x - SymbolicPolynomial::one()).is_empty()
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
    let failure =
        |f: fn(SymbolicPolynomial) -> SymbolicPolynomial| collect(|| f(SymbolicPolynomial::variable(0))).unwrap_err();
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
