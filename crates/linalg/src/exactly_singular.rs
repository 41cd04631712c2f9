//! Whether a linear matrix equation is singular for its coefficients as stored, decided in integers.
//!
//! The determinant of `X -> A X + X B` is the product of all `lambda_i + mu_j`, that of `X -> A X B - X` the product of
//! all `lambda_i mu_j - 1`. Binary floating-point entries are integers over a power of two, so that the determinant is
//! one as well. It vanishes modulo an odd prime iff `p_A(x)` and `p_B(-x)`, or `p_A(x)` and `x^m p_B(1/x)`, have a
//! common divisor there: two characteristic polynomials (Hessenberg's method, `O(n^3)`) and Euclid's algorithm.
//!
//! A prime that does not divide the determinant proves that the equation is regular. Primes that divide it and whose
//! product exceeds a bound of it prove that it is zero.

use crate::triangular::Equation;
use nalgebra::DMatrix;

/// Multiplications that the decision may cost: below a second.
const WORK: f64 = 1e8;

/// What is certain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regularity {
    /// The determinant is not zero.
    Regular,
    /// It is zero.
    Singular,
    /// The primes that the bound asks for are too many.
    Unknown,
}

/// For finite square coefficients; `symmetric` where B is A or its transpose and X is symmetric.
pub fn regularity(equation: Equation, a: &DMatrix<f64>, b: &DMatrix<f64>, symmetric: bool) -> Regularity {
    let (n, m) = (a.nrows(), b.nrows());
    if n * m == 0 {
        return Regularity::Regular;
    }
    let order = n.max(m) as f64;
    let step = order * order * order + order * (n * m) as f64;
    let primes = needed(equation, a, b, symmetric);
    let affordable = (WORK / step).min(primes);
    let mut prime = 1_u64 << 31;
    let mut tried = 0.0;
    // One prime at least, where one is affordable at all.
    while tried < affordable && step <= WORK {
        prime = prime_below(prime);
        if !vanishes(equation, a, b, prime) {
            return Regularity::Regular;
        }
        tried += 1.0;
    }
    if tried >= primes { Regularity::Singular } else { Regularity::Unknown }
}

/// How many primes above 2^30 have a product above the determinant, for X symmetric above that of the operator on
/// symmetric matrices: it has each pair of eigenvalues once, and vanishes with the other.
fn needed(equation: Equation, a: &DMatrix<f64>, b: &DMatrix<f64>, symmetric: bool) -> f64 {
    let (n, m) = (a.nrows(), b.nrows());
    // `2^e A` is an integer matrix, its spectral radius at most `n max |a_ij|`.
    let radius = |m: &DMatrix<f64>| (m.nrows() as f64).log2() + m.amax().max(f64::MIN_POSITIVE).log2();
    let (below_a, below_b) = (f64::from(places(a)), f64::from(places(b)));
    let factor = match equation {
        Equation::Sylvester => radius(a).max(radius(b)) + below_a.max(below_b) + 1.0,
        Equation::Stein => (radius(a) + radius(b)).max(0.0) + below_a + below_b + 1.0,
    };
    let factors = if symmetric { n * (n + 1) / 2 } else { n * m } as f64;
    // A hundredth of a bit for the rounding of the logarithms.
    (factors * (factor.max(0.0) + 0.01) / 30.0).ceil() + 1.0
}

/// Binary places after the point in the entries of `m`.
fn places(m: &DMatrix<f64>) -> i32 {
    m.iter().map(|&x| parts(x)).filter(|&(_, mantissa, _)| mantissa != 0).map(|(_, _, e)| -e).max().unwrap_or(0).max(0)
}

/// `x = (-1)^sign mantissa 2^exponent`, the mantissa odd or zero.
fn parts(x: f64) -> (bool, u64, i32) {
    let bits = x.to_bits();
    let (biased, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
    (x.is_sign_negative(), mantissa >> zeros, exponent + zeros.cast_signed())
}

/// Whether the determinant is zero modulo the odd prime `p < 2^31`.
fn vanishes(equation: Equation, a: &DMatrix<f64>, b: &DMatrix<f64>, p: u64) -> bool {
    let left = characteristic(a, p);
    let mut right = characteristic(b, p);
    match equation {
        // `p_B(-x)`.
        Equation::Sylvester => right.iter_mut().skip(1).step_by(2).for_each(|c| *c = negative(*c, p)),
        Equation::Stein => right.reverse(),
    }
    have_common_divisor(left, right, p)
}

fn negative(x: u64, p: u64) -> u64 {
    if x == 0 { 0 } else { p - x }
}

/// `x^e` modulo `p`.
pub fn power(mut x: u64, mut e: u64, p: u64) -> u64 {
    let mut found = 1;
    while e > 0 {
        if e & 1 == 1 {
            found = found * x % p;
        }
        x = x * x % p;
        e >>= 1;
    }
    found
}

fn inverse(x: u64, p: u64) -> u64 {
    power(x, p - 2, p)
}

/// `x` modulo the odd prime `p`.
pub fn residue(x: f64, p: u64) -> u64 {
    let (negated, mantissa, exponent) = parts(x);
    let two = if exponent < 0 { p.div_ceil(2) } else { 2 };
    let size = mantissa % p * power(two, u64::from(exponent.unsigned_abs()), p) % p;
    if negated { negative(size, p) } else { size }
}

/// The characteristic polynomial modulo `p`, its constant coefficient first, its leading one (1) last.
pub fn characteristic(m: &DMatrix<f64>, p: u64) -> Vec<u64> {
    characteristic_of(m.map(|x| residue(x, p)), p)
}

/// As [`characteristic`], of a matrix of residues.
pub(crate) fn characteristic_of(mut h: DMatrix<u64>, p: u64) -> Vec<u64> {
    let n = h.nrows();
    // To Hessenberg form by similarity.
    for k in 1..n.max(1) - 1 {
        let Some(pivot) = (k..n).find(|&i| h[(i, k - 1)] != 0) else { continue };
        h.swap_rows(k, pivot);
        h.swap_columns(k, pivot);
        let scale = inverse(h[(k, k - 1)], p);
        for i in k + 1..n {
            let factor = h[(i, k - 1)] * scale % p;
            if factor == 0 {
                continue;
            }
            for j in 0..n {
                h[(i, j)] = (h[(i, j)] + negative(factor, p) * h[(k, j)]) % p;
            }
            for j in 0..n {
                h[(j, k)] = (h[(j, k)] + factor * h[(j, i)]) % p;
            }
        }
    }
    // `p_(k+1) = (x - h_kk) p_k - sum over i < k of h_ik h_(i+1)i .. h_k(k-1) p_i`.
    let mut known: Vec<Vec<u64>> = vec![vec![1]];
    for k in 0..n {
        let mut next = vec![0; k + 2];
        next[1..].copy_from_slice(&known[k]);
        let mut below = 1;
        for i in (0..=k).rev() {
            let factor = negative(h[(i, k)] * below % p, p);
            for (c, &d) in next.iter_mut().zip(&known[i]) {
                *c = (*c + factor * d) % p;
            }
            if i > 0 {
                below = below * h[(i, i - 1)] % p;
            }
        }
        known.push(next);
    }
    known.pop().unwrap_or_default()
}

/// Euclid's algorithm. The zero polynomial has every divisor.
fn have_common_divisor(mut f: Vec<u64>, mut g: Vec<u64>, p: u64) -> bool {
    let trim = |f: &mut Vec<u64>| f.truncate(f.iter().rposition(|&c| c != 0).map_or(0, |k| k + 1));
    trim(&mut f);
    trim(&mut g);
    while !g.is_empty() {
        let scale = inverse(g[g.len() - 1], p);
        while f.len() >= g.len() {
            let shift = f.len() - g.len();
            let factor = negative(f[f.len() - 1] * scale % p, p);
            for (c, &d) in f[shift..].iter_mut().zip(&g) {
                *c = (*c + factor * d) % p;
            }
            trim(&mut f);
        }
        std::mem::swap(&mut f, &mut g);
    }
    f.len() != 1
}

/// The largest prime below `start`, which is above 7 and at most 2^31 (Miller and Rabin; the bases 2, 3, 5 and 7 are
/// enough below 3.2e9: Jaeschke, Math. Comp. 61, 1993).
pub fn prime_below(start: u64) -> u64 {
    let is_prime = |p: u64| {
        let twos = (p - 1).trailing_zeros();
        p % 2 == 1
            && [2, 3, 5, 7].into_iter().all(|base| {
                let mut x = power(base, (p - 1) >> twos, p);
                if x == 1 || x == p - 1 {
                    return true;
                }
                (1..twos).any(|_| {
                    x = x * x % p;
                    x == p - 1
                })
            })
    };
    let mut p = start - 1;
    while !is_prime(p) {
        p -= 1;
    }
    p
}
