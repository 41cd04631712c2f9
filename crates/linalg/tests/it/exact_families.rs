//! Linear matrix equations with solutions known exactly, over the range of their conditioning: the families of CTLEX
//! and DTLEX (Kressner, Mehrmann and Penzl, SLICOT Working Notes 1999-6 and 1999-7), built in integers. The data are
//! exactly what binary64 holds, so that the error of a solution is a number and not an estimate.

use luenberger_linalg::{
    DiscreteSylvesterEquation, LinalgError, LyapunovEquation, SteinEquation, SylvesterEquation, discrete_sylvester,
    generalized_lyapunov, generalized_stein, lyapunov, stein, sylvester,
};
use nalgebra::{DMatrix, dmatrix};

type Integers = DMatrix<i128>;

/// The matrix times a power of two, if binary64 holds it exactly.
fn exact(m: &Integers, exponent: i32) -> Option<DMatrix<f64>> {
    let held = m.iter().all(|&v| v == v as f64 as i128);
    held.then(|| m.map(|v| v as f64 * 2.0_f64.powi(exponent)))
}

/// `T = H2 S H1` and its inverse times `2^bits`: reflections in `(1, 1, ..)` and `(1, -1, ..)` around
/// `S = diag(1, s, .., s^(n-1))`, whose condition is that of T. `n` and `s` are powers of two.
struct Similarity {
    t: Integers,
    inverse: Integers,
    bits: i32,
}

impl Similarity {
    fn new(n: usize, s: i128) -> Self {
        let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 2 } else { -2 };
        let order = n as i128;
        let h1 = Integers::from_fn(n, n, |i, j| order * i128::from(i == j) - 2);
        let h2 = Integers::from_fn(n, n, |i, j| order * i128::from(i == j) - sign(i, j));
        let power = |k: usize| s.pow(k as u32);
        let diagonal = |f: &dyn Fn(usize) -> i128| Integers::from_fn(n, n, |i, j| if i == j { f(i) } else { 0 });
        let t = &h2 * diagonal(&power) * &h1;
        let inverse = h1 * diagonal(&|i| power(n - 1 - i)) * h2;
        let bits = (order.pow(4) * power(n - 1)).ilog2().cast_signed();
        Self { t, inverse, bits }
    }

    /// `T L T^-1 2^bits` and `T^-T P T^-1`.
    fn apply(&self, l: &Integers, p: &Integers) -> (Integers, Integers) {
        (&self.t * l * &self.inverse, self.inverse.transpose() * p * &self.inverse)
    }
}

/// A, Q and P with `A'P + PA + Q = 0` or `A'PA - P + Q = 0`, to the last bit.
struct Known {
    name: String,
    a: DMatrix<f64>,
    q: DMatrix<f64>,
    p: DMatrix<f64>,
}

impl Known {
    /// `A = a 2^-bits`; `None` if the data do not fit binary64.
    fn new(discrete: bool, name: String, a: &Integers, bits: i32, p: &Integers) -> Option<Self> {
        let (q, exponent) = if discrete {
            // P - A'P A over the common denominator.
            (p * (1_i128 << (2 * bits)) - a.transpose() * p * a, -2 * bits)
        } else {
            (-(a.transpose() * p + p * a), -bits)
        };
        Some(Self { name, a: exact(a, -bits)?, q: exact(&q, exponent)?, p: exact(p, 0)? })
    }

    fn error(&self, p: &DMatrix<f64>) -> f64 {
        (p - &self.p).norm() / self.p.norm()
    }
}

fn tridiagonal(n: usize) -> Integers {
    Integers::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 3 + i as i128,
        1 => -1,
        _ => 0,
    })
}

/// CTLEX 4.1 (eigenvalues -1, -r, .., -r^(n-1)) and 4.2 (a Jordan block at -1/r); DTLEX 4.1 (eigenvalues 1 - 1/r^i) and
/// 4.2 (a Jordan block at 1 - 1/r).
fn families(discrete: bool) -> Vec<Known> {
    let mut found = Vec::new();
    for (n, s, r) in [2_usize, 4, 8]
        .into_iter()
        .flat_map(|n| [1_i128, 2, 4, 8, 16, 64].map(|s| (n, s)))
        .flat_map(|(n, s)| [2_i128, 4, 16, 64].map(|r| (n, s, r)))
    {
        let similarity = Similarity::new(n, s);
        let bits_of_r = r.ilog2().cast_signed();
        let diagonal = Integers::from_fn(n, n, |i, j| match (i == j, discrete) {
            (false, _) => 0,
            (true, false) => -r.pow(i as u32),
            (true, true) => r.pow(n as u32) - r.pow((n - i) as u32),
        });
        let jordan = Integers::from_fn(n, n, |i, j| match (i == j, j == i + 1) {
            (true, _) => {
                if discrete {
                    r - 1
                } else {
                    -1
                }
            }
            (_, true) => r,
            _ => 0,
        });
        let scales = [if discrete { bits_of_r * i32::try_from(n).unwrap() } else { 0 }, bits_of_r];
        for (what, l, scale) in [("eigenvalues", diagonal, scales[0]), ("Jordan block", jordan, scales[1])] {
            // All products have to fit 127 bits.
            let size = l.iter().map(|v| v.unsigned_abs()).max().map_or(0, |v| v.ilog2().cast_signed() + 1);
            let bits = similarity.bits + scale;
            let largest = if discrete { 2 * size.max(scale) + 4 * similarity.bits } else { size + 3 * similarity.bits };
            if largest > 110 {
                continue;
            }
            let (a, p) = similarity.apply(&l, &tridiagonal(n));
            let name = format!("{what}, n = {n}, s = {s}, r = {r}");
            found.extend(Known::new(discrete, name, &a, bits, &p));
        }
    }
    found
}

/// The bound holds everywhere, and refinement brings the solution to its last bits where there is one to refine.
#[test]
fn lyapunov_errors_are_bounded_and_refined_away() {
    let families = families(false);
    assert!(families.len() >= 40, "{}", families.len());
    let (mut worst, mut solved, mut refined) = (0.0_f64, 0, 0);
    for known in &families {
        let Ok(mut equation) = LyapunovEquation::new(&known.a) else { continue };
        let found = match equation.solve(&known.q) {
            Err(LinalgError::UndecidedEquation { regular: true, .. }) => continue,
            found => found.unwrap(),
        };
        let error = known.error(&found.p);
        assert!(error <= found.forward_error(), "{}: {error:e} > {:e}", known.name, found.forward_error());
        solved += 1;
        // Each step contracts by about condition n eps.
        if found.condition <= 1e11 {
            let mut p = found.p;
            let first = equation.refine(&known.q, &mut p).unwrap();
            // The correction is the error, but for the square of the contraction.
            assert!((first - error).abs() <= 0.1 * error + 2.0 * f64::EPSILON, "{}: {first:e} {error:e}", known.name);
            equation.refine(&known.q, &mut p).unwrap();
            let after = known.error(&p);
            assert!(after <= f64::EPSILON, "{}: {error:e} -> {after:e}", known.name);
            worst = worst.max(error);
            refined += 1;
        }
    }
    // There was something to gain: seven digits somewhere.
    assert!(solved >= 40 && refined >= 30 && worst >= 1e-9, "{solved} {refined} {worst:e}");
}

#[test]
fn stein_errors_are_bounded_and_refined_away() {
    let families = families(true);
    assert!(families.len() >= 20, "{}", families.len());
    let (mut worst, mut refined) = (0.0_f64, 0);
    for known in &families {
        let Ok(mut equation) = SteinEquation::new(&known.a) else { continue };
        let found = match equation.solve(&known.q) {
            Err(LinalgError::UndecidedEquation { regular: true, .. }) => continue,
            found => found.unwrap(),
        };
        let error = known.error(&found.p);
        assert!(error <= found.forward_error(), "{}: {error:e} > {:e}", known.name, found.forward_error());
        if found.condition <= 1e11 {
            let mut p = found.p;
            equation.refine(&known.q, &mut p).unwrap();
            equation.refine(&known.q, &mut p).unwrap();
            let after = known.error(&p);
            assert!(after <= f64::EPSILON, "{}: {error:e} -> {after:e}", known.name);
            worst = worst.max(error);
            refined += 1;
        }
    }
    assert!(refined >= 15 && worst >= 1e-11, "{refined} {worst:e}");
}

/// `A X + X B = C` with the coefficients of two members of the family, of unequal order.
#[test]
fn sylvester_errors_are_bounded_and_refined_away() {
    let (mut worst, mut refined) = (0.0_f64, 0);
    for (s, r) in [1_i128, 2, 4, 8, 16].into_iter().flat_map(|s| [2_i128, 4, 16].map(|r| (s, r))) {
        let (left, right) = (Similarity::new(4, s), Similarity::new(2, s));
        let powers = |n: usize| Integers::from_fn(n, n, |i, j| if i == j { -r.pow(i as u32) } else { 0 });
        let a = &left.t * powers(4) * &left.inverse;
        let b = &right.t * powers(2) * &right.inverse;
        let x = Integers::from_fn(4, 2, |i, j| 1 + (3 * i + 5 * j) as i128);
        // A = a 2^-left.bits and so on: the smaller denominator is brought to the larger.
        let c = &a * &x + &x * &b * (1_i128 << (left.bits - right.bits));
        let (Some(a), Some(b), Some(c), Some(x)) =
            (exact(&a, -left.bits), exact(&b, -right.bits), exact(&c, -left.bits), exact(&x, 0))
        else {
            continue;
        };
        let Ok(mut equation) = SylvesterEquation::new(&a, &b) else { continue };
        let found = equation.solve(&c).unwrap();
        let error = (&found.x - &x).norm() / x.norm();
        assert!(error <= found.forward_error(), "s = {s}, r = {r}: {error:e} > {:e}", found.forward_error());
        if found.condition <= 1e11 {
            let mut better = found.x;
            equation.refine(&c, &mut better).unwrap();
            equation.refine(&c, &mut better).unwrap();
            let after = (&better - &x).norm() / x.norm();
            assert!(after <= f64::EPSILON, "s = {s}, r = {r}: {error:e} -> {after:e}");
            worst = worst.max(error);
            refined += 1;
        }
    }
    assert!(refined >= 8 && worst >= 1e-13, "{refined} {worst:e}");
}

/// `A X B - X + C = 0` with the coefficients of two members of DTLEX 4.1 (eigenvalues 1 - 1/r^i), of unequal order; A
/// grows and B shrinks, which changes nothing.
#[test]
fn discrete_sylvester_errors_are_bounded_and_refined_away() {
    let (mut worst, mut refined) = (0.0_f64, 0);
    for (s, r) in [1_i128, 2, 4, 8].into_iter().flat_map(|s| [2_i128, 4, 16].map(|r| (s, r))) {
        let (left, right) = (Similarity::new(4, s), Similarity::new(2, s));
        let powers =
            |n: usize| Integers::from_fn(n, n, |i, j| if i == j { r.pow(n as u32) - r.pow((n - i) as u32) } else { 0 });
        let bits_of = |similarity: &Similarity, n: i32| similarity.bits + n * r.ilog2().cast_signed();
        let (a, b) = (&left.t * powers(4) * &left.inverse, &right.t * powers(2) * &right.inverse);
        let (bits_a, bits_b) = (bits_of(&left, 4), bits_of(&right, 2));
        let x = Integers::from_fn(4, 2, |i, j| 1 + (3 * i + 5 * j) as i128);
        let c = &x * (1_i128 << (bits_a + bits_b)) - &a * &x * &b;
        let (Some(a), Some(b), Some(c), Some(x)) =
            (exact(&a, 100 - bits_a), exact(&b, -100 - bits_b), exact(&c, -bits_a - bits_b), exact(&x, 0))
        else {
            continue;
        };
        let Ok(mut equation) = DiscreteSylvesterEquation::new(&a, &b) else { continue };
        let found = equation.solve(&c).unwrap();
        let error = (&found.x - &x).norm() / x.norm();
        assert!(error <= found.forward_error(), "s = {s}, r = {r}: {error:e} > {:e}", found.forward_error());
        assert!(equation.separation_estimate() <= 3.0 * found.separation, "s = {s}, r = {r}");
        if found.condition <= 1e11 {
            let mut better = found.x;
            equation.refine(&c, &mut better).unwrap();
            equation.refine(&c, &mut better).unwrap();
            let after = (&better - &x).norm() / x.norm();
            assert!(after <= f64::EPSILON, "s = {s}, r = {r}: {error:e} -> {after:e}");
            worst = worst.max(error);
            refined += 1;
        }
    }
    assert!(refined >= 6 && worst >= 1e-13, "{refined} {worst:e}");
}

/// CTLEX 4.3: `A = (2^-t - 1) I + diag(1, .., n) + U'`, `E = I + 2^-t U`, all entries of the solution one. Antistable.
#[test]
fn the_generalised_family_has_the_matrix_of_ones() {
    for (n, t) in [1_usize, 2, 5, 10].into_iter().flat_map(|n| [0, 1, 3, 10, 20].map(|t| (n, t))) {
        let small = 2.0_f64.powi(-t);
        let a = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => small + i as f64,
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Less => 0.0,
        });
        let e = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { small * f64::from(u8::from(i < j)) });
        let p = DMatrix::from_element(n, n, 1.0);
        // Multiples of 4^-t below n^2: exact.
        let half = a.transpose() * &p * &e;
        let found = generalized_lyapunov(&a, &e, &-(&half + half.transpose())).unwrap();
        let error = (&found.p - &p).norm() / p.norm();
        assert!(error <= found.forward_error(), "n = {n}, t = {t}: {error:e} > {:e}", found.forward_error());
    }
}

/// DTLEX 4.3: `A = 2^-t I + diag(1, .., n) + U`, `E = I + 2^-t U'`, U the ones above the diagonal, all entries of the
/// solution one. Eigenvalues from about one on.
#[test]
fn the_discrete_generalised_family_has_the_matrix_of_ones() {
    let (mut bounded, mut solved) = (0, 0);
    for (n, t) in [1_usize, 2, 5, 10].into_iter().flat_map(|n| [0, 1, 3, 10, 20].map(|t| (n, t))) {
        let small = 2.0_f64.powi(-t);
        let a = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => small + (i + 1) as f64,
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Greater => 0.0,
        });
        let e = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { small * f64::from(u8::from(i > j)) });
        let p = DMatrix::from_element(n, n, 1.0);
        // A sum of column j of A is 2j - 1 + 2^-t, one of E is 1 + (n - j) 2^-t: multiples of 4^-t below 2^10, exact,
        // and what the collection prints.
        let q = e.transpose() * &p * &e - a.transpose() * &p * &a;
        let printed = DMatrix::from_fn(n, n, |i, j| {
            let (i, j, n) = ((i + 1) as f64, (j + 1) as f64, n as f64);
            small * small * (1.0 - (n - i) * (n - j)) + small * (3.0 * (i + j) - 2.0 * (n + 1.0)) + 4.0 * i * j
                - 2.0 * (i + j)
        });
        assert_eq!(q, -printed);
        match generalized_stein(&a, &e, &q) {
            Ok(found) => {
                let error = (&found.p - &p).norm() / p.norm();
                assert!(error <= found.forward_error(), "n = {n}, t = {t}: {error:e} > {:e}", found.forward_error());
                (solved, bounded) = (solved + 1, bounded + usize::from(found.forward_error() <= 1e-3));
            }
            // The smallest eigenvalues approach one, and their product with themselves.
            Err(LinalgError::UndecidedEquation { gap, .. }) => {
                assert!(gap <= 1e-3, "{n} {t} {gap:e}");
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(solved >= 10 && bounded >= 8, "{solved} {bounded}");
}

/// After DTLEX 4.4: `E = V W`, `A = V diag(D1, .., Dq) W` with V and W of zeros and ones, each D with an eigenvalue and
/// a pair of modulus `1 - t^-i`. The collection's pairs stand at 135 degrees, where no binary fraction is, and its
/// solution is not known; here they are the zeros of `x^2 - 3/2 m x + m^2`, and the solution is an integer matrix.
#[test]
fn pencils_with_pairs_near_the_unit_circle() {
    let mut solved = 0;
    for (q, t) in [1_usize, 2, 3].into_iter().flat_map(|q| [2_i128, 4, 16, 64].map(|t| (q, t))) {
        let n = 3 * q;
        let v = Integers::from_fn(n, n, |i, j| i128::from(i >= j));
        let w = Integers::from_fn(n, n, |i, j| i128::from(i + j < n));
        // Times 2 t^q.
        let power = |k: usize| t.pow(k as u32);
        let blocks = Integers::from_fn(n, n, |i, j| {
            let modulus = power(q) - power(q - 1 - i / 3);
            match (i / 3 == j / 3, i % 3, j % 3) {
                (true, 0, 0) | (true, 2, 1) => 2 * modulus,
                (true, 1, 2) => -2 * modulus,
                (true, 2, 2) => 3 * modulus,
                _ => 0,
            }
        });
        let bits = 1 + power(q).ilog2().cast_signed();
        let (e, a, p) = (&v * &w, &v * blocks * &w, tridiagonal(n));
        let weight = e.transpose() * &p * &e * (1_i128 << (2 * bits)) - a.transpose() * &p * &a;
        let (Some(a), Some(e), Some(weight), Some(p)) =
            (exact(&a, -bits), exact(&e, 0), exact(&weight, -2 * bits), exact(&p, 0))
        else {
            continue;
        };
        let found = generalized_stein(&a, &e, &weight).unwrap();
        let radius = 1.0 - 1.0 / power(q) as f64;
        assert!(
            (luenberger_linalg::spectral_radius(&(&a * e.clone().try_inverse().unwrap())).unwrap() - radius).abs()
                <= 1e-9
        );
        let error = (&found.p - &p).norm() / p.norm();
        assert!(error <= found.forward_error(), "q = {q}, t = {t}: {error:e} > {:e}", found.forward_error());
        solved += 1;
    }
    assert!(solved >= 8, "{solved}");
}

/// CTLEX 4.4: blocks of order three, with an eigenvalue `-t^i` and a pair `-t^i (1 +- i)` each, time constants from 1
/// to `t^-q`.
#[test]
fn blocks_with_pairs_over_many_time_constants() {
    for (q, t) in [1_usize, 2, 4].into_iter().flat_map(|q| [1_i128, 2, 4, 16].map(|t| (q, t))) {
        let n = 3 * q;
        let block = Integers::from_fn(n, n, |i, j| {
            let size = t.pow((i / 3) as u32);
            match (i / 3 == j / 3, i % 3, j % 3) {
                (true, 0, 0) | (true, 1, 1) | (true, 2, 2 | 1) => -size,
                (true, 1, 2) => size,
                _ => 0,
            }
        });
        // Unit triangular, its inverse an integer matrix too.
        let l = Integers::from_fn(n, n, |i, j| i128::from(i >= j));
        let inverse = Integers::from_fn(n, n, |i, j| i128::from(i == j) - i128::from(i == j + 1));
        let (a, p) = (&l * block * &inverse, inverse.transpose() * tridiagonal(n) * &inverse);
        let known = Known::new(false, format!("q = {q}, t = {t}"), &a, 0, &p).unwrap();
        let found = lyapunov(&known.a, &known.q).unwrap();
        let error = known.error(&found.p);
        assert!(error <= found.forward_error(), "{}: {error:e} > {:e}", known.name, found.forward_error());
    }
}

/// The companion matrix of `(x + 1)(x + 2) .. (x + n)`.
fn wilkinson(n: usize) -> Integers {
    let mut coefficients = vec![1_i128];
    for root in 1..=n as i128 {
        let shifted = coefficients.iter().chain([&0]).copied().collect::<Vec<_>>();
        let scaled = [0].iter().chain(&coefficients).map(|c| c * root).collect::<Vec<_>>();
        coefficients = shifted.iter().zip(scaled).map(|(x, y)| x + y).collect();
    }
    Integers::from_fn(n, n, |i, j| match (i, i == j + 1) {
        (0, _) => -coefficients[j + 1],
        (_, true) => 1,
        _ => 0,
    })
}

#[test]
fn companions_of_wilkinsons_polynomial() {
    for n in [2, 4, 6, 8, 10, 12, 14, 16] {
        // Sums of neighbouring coefficients have to fit, too.
        let coupled = n <= 12;
        let p = Integers::from_fn(n, n, |i, j| i128::from(i == j) + i128::from(coupled && i.abs_diff(j) == 1));
        let known = Known::new(false, format!("n = {n}"), &wilkinson(n), 0, &p).unwrap();
        // Where it has no digits left, the equation is refused, with a separation that says so.
        match lyapunov(&known.a, &known.q) {
            Ok(found) => {
                let error = known.error(&found.p);
                let bound = found.forward_error();
                assert!(error <= bound, "{}: {error:e} > {bound:e}, condition {:e}", known.name, found.condition);
                assert!(n > 6 || bound.is_finite(), "{}", known.name);
            }
            Err(LinalgError::UndecidedEquation { regular: true, separation, .. }) => {
                assert!(n >= 8 && separation <= n as f64 * f64::EPSILON * known.a.norm(), "{n} {separation:e}");
            }
            Err(other) => panic!("{other}"),
        }
    }
    // The coefficients of order 20 leave 53 bits, and the solution is only that of the matrix as stored.
    if let Ok(found) = lyapunov(&wilkinson(20).map(|v| v as f64), &DMatrix::identity(20, 20)) {
        assert!(found.residual <= 600.0 * f64::EPSILON && found.forward_error() > 0.0);
    }
}

#[test]
fn companions_of_powers_and_cycles() {
    for n in [1, 2, 8, 33, 64] {
        // x^n: nilpotent. P = diag(1, .., n) or (n, .., 1), sums of n ones.
        let shift = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j + 1)));
        let found = stein(&shift, &DMatrix::identity(n, n)).unwrap();
        let p = DMatrix::from_fn(n, n, |i, j| if i == j { (n - i) as f64 } else { 0.0 });
        assert!((&found.p - &p).norm() <= found.forward_error() * p.norm(), "{n}");
        assert!(lyapunov(&shift, &DMatrix::identity(n, n)).is_err(), "every sum of eigenvalues is zero");
        // Cyclic permutation C, eigenvalues on a circle: A = C - 2I has P (4 I - C - C') = I.
        let cycle = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
        let a = &cycle - DMatrix::identity(n, n) * 2.0;
        let found = lyapunov(&a, &DMatrix::identity(n, n)).unwrap();
        let inverse = (-&a - a.transpose()).try_inverse().unwrap();
        assert!((&found.p - &inverse).norm() <= found.forward_error() * inverse.norm(), "{n}");
        // Half of it: P = 4/3 I.
        let found = stein(&(cycle * 0.5), &DMatrix::identity(n, n)).unwrap();
        let p = DMatrix::identity(n, n) * (4.0 / 3.0);
        assert!((&found.p - &p).norm() <= found.forward_error() * p.norm(), "{n}");
    }
}

/// What refinement is for: entries decades below the largest. The coupling 128 gives a condition of 1e9, and P has
/// entries of 1 beside 1e6.
#[test]
fn small_entries_come_back_by_refinement() {
    let l = dmatrix![1.0, 0.0, 0.0; 1.0, 1.0, 0.0; 1.0, 1.0, 1.0];
    let inverse = dmatrix![1.0, 0.0, 0.0; -1.0, 1.0, 0.0; 0.0, -1.0, 1.0];
    let a = l * dmatrix![-1.0, 128.0, 0.0; 0.0, -2.0, 128.0; 0.0, 0.0, -3.0] * inverse;
    let p = dmatrix![1.0, 3.0, -7.0; 3.0, 1048576.0, 5.0; -7.0, 5.0, 9.0];
    let q = -(a.transpose() * &p + &p * &a);
    let mut equation = LyapunovEquation::new(&a).unwrap();
    let mut found = equation.solve(&q).unwrap().p;
    let worst = |found: &DMatrix<f64>| found.zip_map(&p, |x, y| (x - y).abs() / y.abs()).amax();
    let before = worst(&found);
    for _ in 0..3 {
        equation.refine(&q, &mut found).unwrap();
    }
    // Entry by entry: the next correction is computed relative to what is left, not to the norm.
    assert!(before >= 1e-13 && worst(&found) <= f64::EPSILON, "{before:e} -> {:e}", worst(&found));
}

/// A sylvester equation solved twice, in order and with A and B exchanged, is the same equation.
#[test]
fn sylvester_and_its_transpose_agree_within_both_bounds() {
    let entry = |i: usize, j: usize| ((3 + 7 * i + 11 * j * j + i * j) as f64).sin();
    for (n, m) in [(5, 9), (17, 4), (40, 23)] {
        let a = DMatrix::from_fn(n, n, |i, j| entry(i, j) + if i == j { 6.0 } else { 0.0 });
        let b = DMatrix::from_fn(m, m, |i, j| entry(i + 1, j));
        let c = DMatrix::from_fn(n, m, |i, j| entry(j, i));
        let found = sylvester(&a, &b, &c).unwrap();
        let other = sylvester(&b.transpose(), &a.transpose(), &c.transpose()).unwrap();
        let allowed = (found.forward_error() + other.forward_error()) * found.x.norm();
        assert!((&found.x - other.x.transpose()).norm() <= allowed);
        // `A X B - X` transposed is `B'X'A' - X'`.
        let (a, b) = (a * 0.125, b * 0.25);
        let found = discrete_sylvester(&a, &b, &c).unwrap();
        let other = discrete_sylvester(&b.transpose(), &a.transpose(), &c.transpose()).unwrap();
        let allowed = (found.forward_error() + other.forward_error()) * found.x.norm();
        assert!((&found.x - other.x.transpose()).norm() <= allowed);
    }
}
