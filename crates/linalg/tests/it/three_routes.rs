//! One equation, three independent routes: the solvers of the crate, Gaussian elimination on the Kronecker product in
//! double-double arithmetic, and the matrix sign function (in discrete time, the sum of a series). What the second
//! finds is exact for our purposes; the bounds reported by the first must cover the difference.

use luenberger_linalg::{care, dare, discrete_sylvester, generalized_stein, lyapunov, stein, sylvester};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// An unevaluated sum of two doubles, 106 bits.
#[derive(Debug, Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn normal(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self(sum, low - (sum - high))
    }

    fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let rounded = (self.0 - (sum - part)) + (other.0 - part);
        Self::normal(sum, rounded + self.1 + other.1)
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self(-other.0, -other.1))
    }

    fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let left_out = self.0.mul_add(other.0, -product);
        Self::normal(product, left_out + (self.0 * other.1 + self.1 * other.0))
    }

    fn over(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self.minus(other.times(Self(first, 0.0)));
        let second = rest.0 / other.0;
        let rest = rest.minus(other.times(Self(second, 0.0)));
        Self::normal(first, second).plus(Self(rest.0 / other.0, 0.0))
    }
}

/// A matrix of such numbers.
#[derive(Debug, Clone)]
struct Precise {
    rows: usize,
    cols: usize,
    data: Vec<Double>,
}

impl Precise {
    fn build(rows: usize, cols: usize, entry: impl Fn(usize, usize) -> Double) -> Self {
        let data = (0..rows * cols).map(|k| entry(k / cols, k % cols)).collect();
        Self { rows, cols, data }
    }

    fn of(m: &DMatrix<f64>) -> Self {
        Self::build(m.nrows(), m.ncols(), |i, j| Double(m[(i, j)], 0.0))
    }

    fn at(&self, i: usize, j: usize) -> Double {
        self.data[i * self.cols + j]
    }

    fn transpose(&self) -> Self {
        Self::build(self.cols, self.rows, |i, j| self.at(j, i))
    }

    fn times(&self, other: &Self) -> Self {
        Self::build(self.rows, other.cols, |i, j| {
            (0..self.cols).fold(Double(0.0, 0.0), |sum, k| sum.plus(self.at(i, k).times(other.at(k, j))))
        })
    }

    fn plus(&self, other: &Self) -> Self {
        Self::build(self.rows, self.cols, |i, j| self.at(i, j).plus(other.at(i, j)))
    }

    fn minus(&self, other: &Self) -> Self {
        Self::build(self.rows, self.cols, |i, j| self.at(i, j).minus(other.at(i, j)))
    }

    /// `self^-1 right` by elimination with partial pivoting.
    fn solve(&self, right: &Self) -> Self {
        let (n, m) = (self.rows, right.cols);
        let mut rows: Vec<Vec<Double>> =
            (0..n).map(|i| (0..n).map(|j| self.at(i, j)).chain((0..m).map(|j| right.at(i, j))).collect()).collect();
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| rows[i][k].0.abs().total_cmp(&rows[j][k].0.abs())).unwrap();
            rows.swap(k, pivot);
            let top = rows[k].clone();
            for row in &mut rows[k + 1..] {
                let factor = row[k].over(top[k]);
                for (entry, &above) in row.iter_mut().zip(&top).skip(k) {
                    *entry = entry.minus(factor.times(above));
                }
            }
        }
        for k in (0..n).rev() {
            for j in n..n + m {
                let known = (k + 1..n).fold(rows[k][j], |sum, l| sum.minus(rows[k][l].times(rows[l][j])));
                rows[k][j] = known.over(rows[k][k]);
            }
        }
        Self::build(n, m, |i, j| rows[i][n + j])
    }

    fn rounded(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows, self.cols, |i, j| self.at(i, j).0)
    }
}

/// The X whose sum of `L X R` over the pairs (L, R) is C.
fn kronecker(terms: &[(&Precise, &Precise)], c: &Precise) -> Precise {
    let (n, m) = (c.rows, c.cols);
    // vec by rows: (L X R)_ij = sum L_ik R_lj X_kl.
    let operator = Precise::build(n * m, n * m, |r, s| {
        let (i, j, k, l) = (r / m, r % m, s / m, s % m);
        terms.iter().fold(Double(0.0, 0.0), |sum, (left, right)| sum.plus(left.at(i, k).times(right.at(l, j))))
    });
    let x = operator.solve(&Precise { rows: n * m, cols: 1, data: c.data.clone() });
    Precise { rows: n, cols: m, data: x.data }
}

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

fn negative(m: &Precise) -> Precise {
    Precise::build(m.rows, m.cols, |i, j| Double(-m.at(i, j).0, -m.at(i, j).1))
}

fn relative_error(found: &DMatrix<f64>, exact: &Precise) -> f64 {
    let exact = exact.rounded();
    (found - &exact).norm() / exact.norm()
}

/// `I - 2 v v'/v'v` applied from both sides to an upper triangular matrix with the given diagonal and couplings up to
/// `size`.
fn similar(diagonal: &[f64], couplings: &[f64], v: &[f64], size: f64) -> DMatrix<f64> {
    let n = diagonal.len();
    let t = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Equal => diagonal[i],
        std::cmp::Ordering::Less => couplings[i * n + j] * size,
        std::cmp::Ordering::Greater => 0.0,
    });
    let v = DVector::from_column_slice(v);
    let h = identity(n) - &v * v.transpose() * (2.0 / v.norm_squared());
    &h * t * &h
}

/// Diagonal given by `spectrum`, couplings up to 10^decades: conditions from 1 to 1e10, short of where rounding
/// decides.
fn plant(n: usize, spectrum: fn(usize, f64) -> f64, decades: f64) -> impl Strategy<Value = DMatrix<f64>> {
    (
        prop::collection::vec(0.0..1.0_f64, n),
        prop::collection::vec(-1.0..1.0_f64, n * n),
        prop::collection::vec(0.1..1.0_f64, n),
        -1.0..decades,
    )
        .prop_map(move |(d, couplings, v, size)| {
            let diagonal: Vec<f64> = d.iter().enumerate().map(|(i, &x)| spectrum(i, x)).collect();
            similar(&diagonal, &couplings, &v, 10.0_f64.powf(size))
        })
}

fn stable(_: usize, x: f64) -> f64 {
    -0.2 - 3.0 * x
}

/// Of both signs, sums of two never nearer to zero than 0.5: even places in -3.0..-2.0, odd in 1.0..1.5.
fn mixed(i: usize, x: f64) -> f64 {
    if i.is_multiple_of(2) { -2.0 - x } else { 1.0 + 0.5 * x }
}

fn contraction(i: usize, x: f64) -> f64 {
    0.8 * x * if i.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Inside and outside the unit circle, products never within 0.28 of one.
fn mixed_discrete(i: usize, x: f64) -> f64 {
    if i.is_multiple_of(2) { 0.3 * x } else { 1.2 + 1.2 * x }
}

fn symmetric(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * n).prop_map(move |data| {
        let m = DMatrix::from_vec(n, n, data);
        &m + m.transpose()
    })
}

fn rectangle(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |data| DMatrix::from_vec(n, m, data))
}

/// `A'P + PA + Q = 0` for Hurwitz A by Newton's iteration for the sign of `[A' Q; 0 -A]`, which is `[-I 2P; 0 I]`
/// (Roberts, Int. J. Control 32, 1980).
fn lyapunov_by_sign(a: &DMatrix<f64>, q: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut a, mut q) = (a.clone(), q.clone());
    for _ in 0..60 {
        let inverse = a.clone().try_inverse().unwrap();
        let scale = (inverse.norm() / a.norm()).sqrt();
        q = (&q * scale + inverse.transpose() * &q * &inverse / scale) * 0.5;
        a = (&a * scale + inverse / scale) * 0.5;
        if (&a + identity(a.nrows())).norm() <= 1e-15 {
            break;
        }
    }
    q * 0.5
}

/// The sum of `A^k C B^k` by doubling its length (Smith, SIAM J. Appl. Math. 16, 1968).
fn discrete_sylvester_by_series(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut a, mut b, mut x) = (a.clone(), b.clone(), c.clone());
    // Radii below 0.8: 0.64^(2^20) is nothing, whatever the couplings.
    for _ in 0..20 {
        x += &a * &x * &b;
        a = &a * &a;
        b = &b * &b;
    }
    x
}

/// The stabilizing X from the sign of the Hamiltonian matrix: `(sign + I) [I; X] = 0`.
fn care_by_sign(a: &DMatrix<f64>, g: &DMatrix<f64>, q: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let mut h = DMatrix::zeros(2 * n, 2 * n);
    h.view_mut((0, 0), (n, n)).copy_from(a);
    h.view_mut((0, n), (n, n)).copy_from(&-g);
    h.view_mut((n, 0), (n, n)).copy_from(&-q);
    h.view_mut((n, n), (n, n)).copy_from(&-a.transpose());
    for _ in 0..60 {
        let inverse = h.clone().try_inverse().unwrap();
        let scale = (inverse.norm() / h.norm()).sqrt();
        let next = (&h * scale + inverse / scale) * 0.5;
        let change = (&next - &h).norm();
        h = next;
        if change <= 1e-14 * h.norm() {
            break;
        }
    }
    let shifted = h + identity(2 * n);
    shifted.columns(n, n).into_owned().svd(true, true).solve(&-shifted.columns(0, n), 0.0).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lyapunov_stable((a, q) in (1..=6_usize).prop_flat_map(|n| (plant(n, stable, 0.5), symmetric(n)))) {
        let found = lyapunov(&a, &q).unwrap();
        let (at, one) = (Precise::of(&a).transpose(), Precise::of(&identity(a.nrows())));
        let exact = kronecker(&[(&at, &one), (&one, &at.transpose())], &negative(&Precise::of(&q)));
        let error = relative_error(&found.p, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.condition);
        // The third route has no bound of its own: rounding of each of its steps meets the condition of the equation
        // once more.
        let sign = lyapunov_by_sign(&a, &q);
        let allowed = 100.0 * found.forward_error();
        prop_assert!(relative_error(&sign, &exact) <= allowed, "{:e} > {allowed:e}", relative_error(&sign, &exact));
    }

    #[test]
    fn lyapunov_unstable((a, q) in (1..=6_usize).prop_flat_map(|n| (plant(n, mixed, 0.5), symmetric(n)))) {
        let found = lyapunov(&a, &q).unwrap();
        let (at, one) = (Precise::of(&a).transpose(), Precise::of(&identity(a.nrows())));
        let exact = kronecker(&[(&at, &one), (&one, &at.transpose())], &negative(&Precise::of(&q)));
        let error = relative_error(&found.p, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.condition);
    }

    #[test]
    fn stein_inside_and_outside((a, q) in (1..=6_usize, any::<bool>()).prop_flat_map(|(n, inside)| {
        (plant(n, if inside { contraction } else { mixed_discrete }, 0.3), symmetric(n))
    })) {
        let found = stein(&a, &q).unwrap();
        let n = a.nrows();
        let (at, one) = (Precise::of(&a).transpose(), Precise::of(&identity(n)));
        let exact = kronecker(&[(&at, &at.transpose()), (&negative(&one), &one)], &negative(&Precise::of(&q)));
        let error = relative_error(&found.p, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.condition);
    }

    #[test]
    fn sylvester_of_any_shape((a, b, c) in (1..=6_usize, 1..=6_usize).prop_flat_map(|(n, m)| {
        (plant(n, stable, 0.5), plant(m, stable, 0.5), rectangle(n, m))
    })) {
        let found = sylvester(&a, &b, &c).unwrap();
        let (left, right) = (Precise::of(&identity(a.nrows())), Precise::of(&identity(b.nrows())));
        let exact = kronecker(&[(&Precise::of(&a), &right), (&left, &Precise::of(&b))], &Precise::of(&c));
        let error = relative_error(&found.x, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.condition);
    }

    #[test]
    fn discrete_sylvester_of_any_shape((a, b, c, inside) in (1..=6_usize, 1..=6_usize, any::<bool>()).prop_flat_map(|(n, m, inside)| {
        // Products of eigenvalues outside are at least 1.44, and those of one inside and one outside at most 0.72.
        let spectrum = if inside { contraction } else { mixed_discrete };
        (plant(n, spectrum, 0.3), plant(m, spectrum, 0.3), rectangle(n, m), Just(inside))
    })) {
        let found = discrete_sylvester(&a, &b, &c).unwrap();
        let (n, m) = c.shape();
        let (pa, pb, left, right) = (Precise::of(&a), Precise::of(&b), Precise::of(&identity(n)), Precise::of(&identity(m)));
        let exact = kronecker(&[(&pa, &pb), (&negative(&left), &right)], &negative(&Precise::of(&c)));
        let error = relative_error(&found.x, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.condition);
        if inside {
            // It has no bound of its own: rounding of each of its steps meets the condition of the equation once more.
            let (series, allowed) = (discrete_sylvester_by_series(&a, &b, &c), 100.0 * found.forward_error());
            prop_assert!(relative_error(&series, &exact) <= allowed, "{:e} > {allowed:e}", relative_error(&series, &exact));
        }
    }

    #[test]
    fn generalized_stein_inside_and_outside((a, e, q) in (1..=5_usize, any::<bool>()).prop_flat_map(|(n, inside)| {
        (plant(n, if inside { contraction } else { mixed_discrete }, 0.0), plant(n, stable, 0.0), symmetric(n))
    })) {
        // The pencil of A E and E has the eigenvalues of A but for the rounding of the product; all three are data
        // then.
        let a = &a * &e;
        let found = generalized_stein(&a, &e, &q).unwrap();
        let (at, et) = (Precise::of(&a).transpose(), Precise::of(&e).transpose());
        let exact = kronecker(&[(&at, &at.transpose()), (&negative(&et), &et.transpose())], &negative(&Precise::of(&q)));
        let error = relative_error(&found.p, &exact);
        prop_assert!(error <= found.forward_error(), "{error:e} > {:e}, condition {:e}", found.forward_error(), found.standard.condition);
    }

    /// Newton's iteration in double-double from our X, which converges to the exact solution, and the sign function.
    #[test]
    fn care_of_unstable_plants((a, b, c) in (1..=5_usize, 1..=2_usize).prop_flat_map(|(n, m)| {
        (rectangle(n, n), rectangle(n, m), rectangle(2, n))
    })) {
        let n = a.nrows();
        // The input moves every state, some of them little: stabilizable by construction.
        let b = DMatrix::from_fn(n, n + b.ncols(), |i, j| if j < n { f64::from(u8::from(i == j)) * 0.1 } else { b[(i, j - n)] });
        let q = c.tr_mul(&c) + identity(n) * 0.1;
        let found = care(&a, &b, &q, &identity(b.ncols())).unwrap();
        let (pa, pb, pq, one) = (Precise::of(&a), Precise::of(&b), Precise::of(&q), Precise::of(&identity(n)));
        let g = pb.times(&pb.transpose());
        let newton = |start: &DMatrix<f64>| (0..4).fold(Precise::of(start), |x, _| {
            let f = pa.minus(&g.times(&x));
            let defect = pa.transpose().times(&x).plus(&x.times(&pa)).minus(&x.times(&g).times(&x)).plus(&pq);
            x.plus(&kronecker(&[(&f.transpose(), &one), (&one, &f)], &negative(&defect)))
        });
        let x = newton(&found.x);
        let error = relative_error(&found.x, &x);
        prop_assert!(found.forward_error <= 1e-6, "of these plants a bound is known: {:e}", found.forward_error);
        prop_assert!(error <= found.forward_error, "{error:e} > {:e}", found.forward_error);
        let sign = care_by_sign(&a, &(&b * b.transpose()), &q);
        // It has no bound of its own (its steps meet the condition of the sign); Newton's iteration from it ends at the
        // same matrix, to the last bit but one.
        prop_assert!(relative_error(&sign, &x) <= 1e-5, "{:e}", relative_error(&sign, &x));
        let polished = newton(&sign).rounded();
        prop_assert!(relative_error(&polished, &x) <= 2.0 * f64::EPSILON, "{:e}", relative_error(&polished, &x));
    }

    #[test]
    fn dare_of_unstable_plants((a, b, c) in (1..=5_usize, 1..=2_usize).prop_flat_map(|(n, m)| {
        (rectangle(n, n), rectangle(n, m), rectangle(2, n))
    })) {
        let n = a.nrows();
        let b = DMatrix::from_fn(n, n + b.ncols(), |i, j| if j < n { f64::from(u8::from(i == j)) * 0.1 } else { b[(i, j - n)] });
        let (a, q, r) = (a * 1.5, c.tr_mul(&c) + identity(n) * 0.1, identity(b.ncols()));
        let found = dare(&a, &b, &q, &r).unwrap();
        let (pa, pb, pq, one) = (Precise::of(&a), Precise::of(&b), Precise::of(&q), Precise::of(&identity(n)));
        let mut x = Precise::of(&found.x);
        for _ in 0..4 {
            let bx = pb.transpose().times(&x);
            let k = Precise::of(&r).plus(&bx.times(&pb)).solve(&bx.times(&pa));
            let f = pa.minus(&pb.times(&k));
            let ax = pa.transpose().times(&x);
            let defect = ax.times(&pa).minus(&x).minus(&ax.times(&pb).times(&k)).plus(&pq);
            x = x.plus(&kronecker(&[(&f.transpose(), &f), (&negative(&one), &one)], &negative(&defect)));
        }
        let error = relative_error(&found.x, &x);
        prop_assert!(found.forward_error <= 1e-6, "of these plants a bound is known: {:e}", found.forward_error);
        prop_assert!(error <= found.forward_error, "{error:e} > {:e}", found.forward_error);
    }
}

/// The arithmetic of the second route, against numbers known otherwise.
#[test]
fn double_double_keeps_thirty_digits() {
    let third = Double(1.0, 0.0).over(Double(3.0, 0.0));
    let back = third.times(Double(3.0, 0.0)).minus(Double(1.0, 0.0));
    assert!(back.0.abs() <= 1e-31, "{back:?}");
    // Hilbert's matrix of order 6, condition 1.5e7, with its inverse in integers: entry (1, 1) is 36.
    let hilbert = Precise::build(6, 6, |i, j| Double(1.0, 0.0).over(Double((i + j + 1) as f64, 0.0)));
    let inverse = hilbert.solve(&Precise::of(&identity(6)));
    let corner = inverse.at(0, 0).minus(Double(36.0, 0.0));
    assert!(corner.0.abs() <= 1e-22, "{corner:?}");
}
