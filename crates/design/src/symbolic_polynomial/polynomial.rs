//! Polynomials in atoms with outward rounded coefficients.

use luenberger_proof::{Interval, Ring};

/// Below this a product of numbers may have lost digits that its rounding error does not show.
const UNDERFLOW: f64 = 1e-250;

/// Powers of atoms, by the atom; negative ones come from divisions by a single monomial, so that x/x is 1.
pub(crate) type Monomial = Vec<(usize, i32)>;

/// Monomials in order, each once, none with the coefficient 0.
pub(crate) type Polynomial = Vec<(Monomial, Interval)>;

/// The product, without a rounding where it has none.
pub(super) fn times(x: &Interval, y: &Interval) -> Interval {
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
pub(super) fn reciprocal(x: &Interval) -> Option<Interval> {
    if x.is_point() {
        let (x, inverse) = (x.lo(), x.lo().recip());
        if x.mul_add(inverse, -1.0) == 0.0 {
            return Interval::from_f64(inverse);
        }
    }
    x.recip()
}

/// The polynomial that is this number.
pub fn constant(value: Interval) -> Polynomial {
    if value.is_zero() { Vec::new() } else { vec![(Vec::new(), value)] }
}

/// The number that this polynomial is, if it is one.
pub fn number(p: &Polynomial) -> Option<Interval> {
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

/// `dp/da`, a being an atom.
pub(super) fn partial(p: &Polynomial, atom: usize) -> Polynomial {
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
pub fn evaluate(p: &Polynomial, atoms: &[Interval]) -> Option<Interval> {
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
