//! Enclosed solutions of Lyapunov and Stein equations against exact elimination in integers, and the bounds of spectra.

use dashu_int::IBig;
use luenberger_proof::statement::{
    Enclosure, hurwitz, lyapunov_solution, schur_stable, spectral_abscissa, spectral_radius, stein_solution,
};
use luenberger_proof::{Exact, Interval, Matrix, ProofError, Ring};
use luenberger_random::Random;
use proptest::prelude::*;

/// Which equation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Lyapunov,
    Stein,
}

/// The solution of an equation, each entry `numerator / denominator`.
struct Rational {
    numerators: Vec<IBig>,
    denominator: IBig,
    n: usize,
}

/// All n^2 unknowns, A and Q in multiples of 2^-scale: Gauss and Jordan without fractions (Bareiss). `None` where the
/// equation is singular.
fn rational(kind: Kind, a: &Matrix<f64>, q: &Matrix<f64>, scale: i64) -> Option<Rational> {
    let n = a.rows();
    let order = n * n;
    let integer = |x: f64| {
        let x = Exact::from_f64(x).expect("finite").shifted(scale);
        assert!(x.exponent() >= 0, "the data are multiples of 2^-{scale}");
        x.mantissa() << usize::try_from(x.exponent()).expect("not negative")
    };
    let a = a.map(|&x| integer(x));
    let mut m: Vec<Vec<IBig>> = vec![vec![IBig::ZERO; order + 1]; order];
    for i in 0..n {
        for j in 0..n {
            let row = &mut m[i * n + j];
            for k in 0..n {
                match kind {
                    Kind::Lyapunov => {
                        row[k * n + j] += &a[(k, i)];
                        row[i * n + k] += &a[(k, j)];
                    }
                    Kind::Stein => {
                        for l in 0..n {
                            row[k * n + l] += &a[(k, i)] * &a[(l, j)];
                        }
                    }
                }
            }
            let q = integer(q[(i, j)]);
            match kind {
                Kind::Lyapunov => row[order] = -q,
                // All of the equation times 2^(2 scale).
                Kind::Stein => {
                    row[i * n + j] -= IBig::ONE << (2 * scale as usize);
                    row[order] = -(q << scale as usize);
                }
            }
        }
    }
    let mut previous = IBig::ONE;
    for k in 0..order {
        let pivot = (k..order).find(|&i| m[i][k] != IBig::ZERO)?;
        m.swap(k, pivot);
        let row = m[k].clone();
        for i in (0..order).filter(|&i| i != k) {
            let factor = m[i][k].clone();
            for j in 0..=order {
                m[i][j] = (&row[k] * &m[i][j] - &factor * &row[j]) / &previous;
            }
        }
        previous.clone_from(&row[k]);
    }
    let (mut numerators, mut denominator) = (m.iter().map(|row| row[order].clone()).collect::<Vec<_>>(), previous);
    if denominator < IBig::ZERO {
        denominator = -denominator;
        numerators = numerators.into_iter().map(|x| -x).collect();
    }
    Some(Rational { numerators, denominator, n })
}

impl Rational {
    /// The part of the solution that binary64 holds, after the parts given have been taken from it; symmetric.
    fn rounded_rest(&self, parts: &[Matrix<f64>]) -> Matrix<f64> {
        Matrix::from_fn(self.n, self.n, |i, j| {
            let (i, j) = (i.min(j), i.max(j));
            // numerator/denominator to 300 bits, and the parts in the same fixed point.
            let value = (&self.numerators[i * self.n + j] << 600) / &self.denominator;
            let taken =
                parts.iter().fold(Exact::zero(), |sum, part| sum.add(&Exact::from_f64(part[(i, j)]).expect("finite")));
            Exact::new(value, -600).sub(&taken).round_down()
        })
    }

    fn lies_in(&self, p: &Matrix<Interval>) -> bool {
        let below = |x: f64, k: usize| {
            // x <= numerator / denominator.
            let scaled = Exact::from_f64(x).expect("finite").mul(&Exact::new(self.denominator.clone(), 0));
            Exact::new(self.numerators[k].clone(), 0).sub(&scaled).signum()
        };
        p.as_slice().iter().enumerate().all(|(k, x)| below(x.lo(), k) >= 0 && below(x.hi(), k) <= 0)
    }
}

fn points(m: &Matrix<f64>) -> Matrix<Interval> {
    Matrix::embed(m, "a matrix of the test").expect("finite")
}

fn identity(n: usize) -> Matrix<f64> {
    Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 })
}

fn solve(
    kind: Kind,
    a: &Matrix<f64>,
    q: &Matrix<f64>,
    near: &[Matrix<f64>],
    w: Option<&Matrix<f64>>,
) -> Result<Enclosure, ProofError> {
    match kind {
        Kind::Lyapunov => lyapunov_solution(&points(a), &points(q), near, w),
        Kind::Stein => stein_solution(&points(a), &points(q), near, w),
    }
}

fn largest(m: &Matrix<f64>) -> f64 {
    m.as_slice().iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

/// A and Q in multiples of 1/64, of order up to 4, and factors of a perturbation.
fn equation() -> impl Strategy<Value = (usize, Vec<i32>, Vec<i32>, Vec<f64>)> {
    (1..=4_usize).prop_flat_map(|n| {
        let entries = || prop::collection::vec(-64..=64_i32, n * n);
        (Just(n), entries(), entries(), prop::collection::vec(-1.0..1.0_f64, n * n))
    })
}

fn symmetric(n: usize, entries: &[i32]) -> Matrix<f64> {
    Matrix::from_fn(n, n, |i, j| f64::from(entries[i.min(j) * n + i.max(j)]) / 64.0)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// A stable by diagonal dominance: the comparison with the solution for Q = I encloses the exact solution, and the
    /// distance it proves is at most the condition of the equation times the true one.
    #[test]
    fn the_comparison_encloses_the_exact_solution((n, a, q, noise) in equation(), size in -14..-2_i32, stein in any::<bool>()) {
        let kind = if stein { Kind::Stein } else { Kind::Lyapunov };
        let a = Matrix::from_fn(n, n, |i, j| {
            let entry = f64::from(a[i * n + j]) / 64.0;
            // Row sums below n: the matrix moved left by more, or divided by a power of two above.
            match kind {
                Kind::Lyapunov => entry - if i == j { n as f64 + 0.125 } else { 0.0 },
                Kind::Stein => entry / 8.0,
            }
        });
        let q = symmetric(n, &q);
        let exact = rational(kind, &a, &q, 9).expect("stable");
        let w = rational(kind, &a, &identity(n), 9).expect("stable").rounded_rest(&[]);
        let p = exact.rounded_rest(&[]);
        let perturbation = largest(&p) * 10.0_f64.powi(size);
        let off = Matrix::from_fn(n, n, |i, j| p[(i, j)] + perturbation * noise[i.min(j) * n + i.max(j)]);
        let found = solve(kind, &a, &q, std::slice::from_ref(&off), Some(&w)).expect("shapes agree");
        let enclosed = found.enclosed().expect("W proves it");
        prop_assert!(exact.lies_in(&enclosed.p), "{enclosed:?}");
        // |R| <= |T| |X| and |X|_ij <= r W, r <= 1.2 |R|_F: with |X|_F <= n max|X| and |T| <= 2 |A|_F (1 + |A|_F^2).
        let norm = a.as_slice().iter().map(|x| x * x).sum::<f64>().sqrt();
        let operator = if stein { 1.0 + norm * norm } else { 2.0 * norm };
        let error = largest(&exact.rounded_rest(std::slice::from_ref(&off)));
        prop_assert!(
            enclosed.distance <= 1.21 * operator * n as f64 * error * largest(&w) * (1.0 + 1e-9) + f64::MIN_POSITIVE,
            "{} for {error}", enclosed.distance
        );
        // A second part: as narrow as the numbers are, and as the rounding of this part allows, by the same bound.
        let left = 2.42 * operator * n as f64 * f64::EPSILON * error * largest(&w);
        let rest = exact.rounded_rest(std::slice::from_ref(&off));
        let found = solve(kind, &a, &q, &[off, rest], Some(&w)).expect("shapes agree");
        let enclosed = found.enclosed().expect("W proves it");
        prop_assert!(exact.lies_in(&enclosed.p));
        for (x, y) in enclosed.p.as_slice().iter().zip(p.as_slice()) {
            prop_assert!(x.width() <= 4.0 * (y.abs().next_up() - y.abs()) + 1e-25 * largest(&p) + left, "{x:?} around {y}");
        }
    }

    /// Any A, stable or not: what is enclosed is the exact solution, and what is singular is not enclosed.
    #[test]
    fn elimination_encloses_the_exact_solution_of_any_equation((n, a, q, noise) in equation(), size in -14..0_i32, stein in any::<bool>()) {
        let kind = if stein { Kind::Stein } else { Kind::Lyapunov };
        let a = Matrix::from_fn(n, n, |i, j| f64::from(a[i * n + j]) / 64.0);
        let q = symmetric(n, &q);
        let Some(exact) = rational(kind, &a, &q, 6) else {
            let found = solve(kind, &a, &q, &[symmetric(n, &vec![0; n * n])], None).expect("shapes agree");
            prop_assert!(found.enclosed().is_none());
            return Ok(());
        };
        let p = exact.rounded_rest(&[]);
        let off = Matrix::from_fn(n, n, |i, j| p[(i, j)] * (1.0 + 10.0_f64.powi(size) * noise[i.min(j) * n + i.max(j)]));
        let found = solve(kind, &a, &q, std::slice::from_ref(&off), None).expect("shapes agree");
        if let Some(enclosed) = found.enclosed() {
            prop_assert!(exact.lies_in(&enclosed.p), "{enclosed:?}");
        }
    }

    /// The eigenvalues of a triangular matrix are known; whatever the P, the bounds enclose the largest.
    #[test]
    fn the_bounds_of_the_spectrum_enclose_it(n in 1..6_usize, entries in prop::collection::vec(-1.0..1.0_f64, 25), slope in 0.1..10.0_f64) {
        let a = Matrix::from_fn(n, n, |i, j| if i <= j { entries[i * 5 + j] } else { 0.0 });
        let p = Matrix::from_fn(n, n, |i, j| if i == j { slope.powf(i as f64) } else { 0.0 });
        let diagonal = || (0..n).map(|i| a[(i, i)]);
        let abscissa = spectral_abscissa(&a, &p).expect("shapes agree").expect("P > 0");
        prop_assert!(abscissa.contains(diagonal().fold(f64::NEG_INFINITY, f64::max)), "{abscissa:?}");
        let radius = spectral_radius(&a, &p).expect("shapes agree").expect("P > 0");
        let modulus = diagonal().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        prop_assert!(radius.contains(modulus), "{radius:?}");
        let stable = schur_stable(&a, &p).expect("shapes agree");
        prop_assert!(!stable.is_refuted(), "a triangular matrix within the unit circle");
        if let Some(margin) = stable.margin() {
            prop_assert!(margin <= 1.0 - modulus);
            // The two proofs of one fact: r^2 <= 1 - x.
            prop_assert!(radius.hi() < 1.0);
        }
    }
}

#[test]
fn many_unstable_equations_are_enclosed_and_none_in_vain() {
    // The property above is not vacuous: of 200 equations with random entries, elimination decides all
    // that are not singular.
    let mut random = Random(12345);
    let mut enclosed = 0;
    for _ in 0..200 {
        let a = Matrix::from_fn(3, 3, |_, _| random.below(129) as f64 / 64.0 - 1.0);
        let exact = rational(Kind::Lyapunov, &a, &identity(3), 6).expect("generic");
        let p = exact.rounded_rest(&[]);
        let found = solve(Kind::Lyapunov, &a, &identity(3), &[p], None).expect("shapes agree");
        enclosed += usize::from(found.enclosed().is_some_and(|found| exact.lies_in(&found.p)));
    }
    assert_eq!(enclosed, 200);
}

#[test]
fn the_enclosure_holds_over_the_range_of_conditions() {
    // Eigenvalues -2^-k and -1, far from normal: the condition of the equation is about 4^k, and the comparison is as
    // good as its W.
    for k in 0..24 {
        let small = 2.0_f64.powi(-k);
        let a = Matrix::from_rows([[-small, 1.0], [0.0, -1.0]]);
        let exact = rational(Kind::Lyapunov, &a, &identity(2), 30).expect("stable");
        let p = exact.rounded_rest(&[]);
        let rest = exact.rounded_rest(std::slice::from_ref(&p));
        for w in [Some(&p), None] {
            let one = solve(Kind::Lyapunov, &a, &identity(2), std::slice::from_ref(&p), w).expect("shapes agree");
            let two = solve(Kind::Lyapunov, &a, &identity(2), &[p.clone(), rest.clone()], w).expect("shapes agree");
            let (one, two) = (one.enclosed().expect("k < 24"), two.enclosed().expect("k < 24"));
            assert!(exact.lies_in(&one.p) && exact.lies_in(&two.p), "k = {k}");
            for (x, y) in two.p.as_slice().iter().zip(p.as_slice()) {
                assert!(x.width() <= 4.0 * (y.next_up() - y), "k = {k}: {x:?}");
            }
        }
    }
}

#[test]
fn interval_data_stand_for_every_equation_within() {
    let a = Matrix::from_rows([[-2.0, 1.0], [0.5, -3.0]]);
    let radius = 1.0 / 64.0;
    let wide = |m: &Matrix<f64>| m.map(|x| Interval::new(x - radius, x + radius).expect("in order"));
    let q = identity(2);
    let p = rational(Kind::Lyapunov, &a, &q, 6).expect("stable").rounded_rest(&[]);
    let mut narrowest = f64::INFINITY;
    for w in [Some(&p), None] {
        let found = lyapunov_solution(&wide(&a), &wide(&q), std::slice::from_ref(&p), w).expect("shapes agree");
        let enclosed = found.enclosed().expect("still stable");
        for corner in 0..64_u32 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { radius } else { -radius };
            let a = Matrix::from_fn(2, 2, |i, j| a[(i, j)] + sign((2 * i + j) as u32));
            let q = Matrix::from_fn(2, 2, |i, j| q[(i, j)] + sign(4 + u32::from(i != j)));
            let exact = rational(Kind::Lyapunov, &a, &q, 6).expect("stable");
            assert!(exact.lies_in(&enclosed.p), "corner {corner}");
        }
        narrowest = narrowest.min(enclosed.distance);
    }
    // The perturbation itself moves P by |P| times 2 radius |T^-1|, about 0.006.
    assert!(narrowest < 0.05, "{narrowest}");
    // Wide enough to contain an unstable matrix: nothing is claimed.
    let vast = a.map(|x| Interval::new(x - 3.0, x + 3.0).expect("in order"));
    assert!(
        lyapunov_solution(&vast, &wide(&q), std::slice::from_ref(&p), Some(&p)).expect("fits").enclosed().is_none()
    );
}

#[test]
fn an_antistable_matrix_is_compared_with_minus_w() {
    let a = Matrix::from_fn(30, 30, |i, j| if i == j { 1.0 + i as f64 } else { 0.0 });
    let w = Matrix::from_fn(30, 30, |i, j| if i == j { -0.5 / (1.0 + i as f64) } else { 0.0 });
    // Order 30 is beyond elimination.
    let found = solve(Kind::Lyapunov, &a, &identity(30), std::slice::from_ref(&w), Some(&w)).expect("shapes agree");
    assert!(found.enclosed().expect("-A is stable").p[(2, 2)].contains(-1.0 / 6.0));
    assert!(solve(Kind::Lyapunov, &a, &identity(30), &[w], None).expect("shapes agree").enclosed().is_none());
}

#[test]
fn scales_do_not_change_what_can_be_enclosed() {
    // States in units 1e12 apart.
    let d = [1.0, 2.0_f64.powi(40)];
    let a = Matrix::from_fn(2, 2, |i, j| [[-2.0, 1.0], [0.5, -3.0]][i][j] * d[j] / d[i]);
    let q = Matrix::from_fn(2, 2, |i, j| [[1.0, 0.0], [0.0, 1.0]][i][j] * d[i] * d[j]);
    let exact = rational(Kind::Lyapunov, &a, &q, 50).expect("stable");
    let p = exact.rounded_rest(&[]);
    for w in [Some(&p), None] {
        let found = solve(Kind::Lyapunov, &a, &q, std::slice::from_ref(&p), w).expect("shapes agree");
        let enclosed = found.enclosed().expect("stable in any units");
        assert!(exact.lies_in(&enclosed.p));
        for (x, y) in enclosed.p.as_slice().iter().zip(p.as_slice()) {
            assert!(x.width() <= 1e-13 * y.abs(), "{x:?} around {y}");
        }
    }
}

#[test]
fn schur_stability_is_proved_refuted_or_left() {
    let a = Matrix::from_rows([[0.5, 0.25], [-0.25, 0.5]]);
    let margin = schur_stable(&a, &identity(2)).expect("fits").margin().expect("stable");
    assert!((margin - (1.0 - 0.3125_f64.sqrt())).abs() < 1e-9 && margin <= 1.0 - 0.3125_f64.sqrt());
    // The inverse is unstable, and -I shows it.
    let unstable = Matrix::from_rows([[1.6, -0.8], [0.8, 1.6]]);
    assert!(schur_stable(&unstable, &identity(2).map(|x| -x)).expect("fits").is_refuted());
    let undecided = schur_stable(&unstable, &identity(2)).expect("fits");
    assert!(!undecided.is_proved() && !undecided.is_refuted());
    // On the circle itself.
    assert!(!schur_stable(&Matrix::from_rows([[1.0]]), &Matrix::from_rows([[1.0]])).expect("fits").is_proved());
    let empty = Matrix::from_fn(0, 0, |_, _| 0.0);
    assert!(schur_stable(&empty, &empty).expect("fits").is_proved());
    assert_eq!(spectral_radius(&empty, &empty), Ok(None));
    // Both bounds refuse a P that is not definite, and hurwitz agrees with the abscissa.
    assert_eq!(spectral_abscissa(&a, &identity(2).map(|x| -x)), Ok(None));
    let hurwitzian = Matrix::from_rows([[-1.0, 2.0], [0.0, -3.0]]);
    let p = Matrix::from_rows([[1.0, 1.0], [1.0, 2.0]]);
    assert!(hurwitz(&hurwitzian, &p).expect("fits").is_proved());
    assert!(spectral_abscissa(&hurwitzian, &p).expect("fits").expect("P > 0").hi() < 0.0);
}

#[test]
fn what_is_no_equation_is_an_error_with_its_numbers() {
    let number = |x: f64| Matrix::from_rows([[Interval::from_f64(x).expect("finite")]]);
    let one = Matrix::from_rows([[1.0]]);
    let unbounded = Matrix::from_rows([[Interval::UNBOUNDED]]);
    assert!(matches!(
        lyapunov_solution(&unbounded, &number(1.0), &[], None),
        Err(ProofError::NotFinite { what: "A", .. })
    ));
    assert!(matches!(
        lyapunov_solution(&number(1.0), &unbounded, &[], None),
        Err(ProofError::NotFinite { what: "Q", .. })
    ));
    let nan = Matrix::from_rows([[f64::NAN]]);
    assert!(matches!(lyapunov_solution(&number(1.0), &number(1.0), &[nan], None), Err(ProofError::NotFinite { .. })));
    let wide = Matrix::from_rows([[1.0, 0.0]]);
    assert!(matches!(
        lyapunov_solution(&number(1.0), &number(1.0), &[wide], None),
        Err(ProofError::DimensionMismatch { found: (1, 2), .. })
    ));
    let skew = Matrix::from_rows([[0.0, 1.0], [-1.0, 0.0]]);
    assert!(matches!(
        stein_solution(&points(&identity(2)), &points(&skew), &[], None),
        Err(ProofError::NotSymmetric { what: "Q", .. })
    ));
    // No approximation at all is the approximation 0; huge numbers are undecided, not wrong.
    let from_nothing = stein_solution(&number(0.5), &number(3.0), &[], Some(&one)).expect("fits");
    assert!(from_nothing.enclosed().expect("stable").p[(0, 0)].contains(4.0));
    let huge = lyapunov_solution(&number(-1e300), &number(1e300), &[Matrix::from_rows([[1e300]])], Some(&one));
    assert!(huge.expect("fits").enclosed().is_none_or(|found| found.p[(0, 0)].contains(0.5)));
    let empty: Matrix<Interval> = Matrix::from_fn(0, 0, |_, _| Interval::ONE);
    assert!(lyapunov_solution(&empty, &empty, &[], None).expect("fits").enclosed().is_some());
}
