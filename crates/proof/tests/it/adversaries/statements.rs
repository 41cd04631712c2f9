//! The inequalities of Lyapunov, Stein and of feedback by an observer, on data for which they hold by much, by nothing,
//! or not at all.

use std::cmp::Ordering;

use luenberger_proof::label::Names;
use luenberger_proof::{Matrix, Verdict, statement};
use rand::RngExt;
use rand_chacha::ChaCha8Rng as Random;

use super::oracle::Integers;
use super::trial::{Judged, Sense, Tally};

fn integer(random: &mut Random, size: i64) -> f64 {
    random.random_range(-size..=size) as f64
}

fn matrix(random: &mut Random, rows: usize, cols: usize, size: i64) -> Matrix<f64> {
    Matrix::from_fn(rows, cols, |_, _| integer(random, size))
}

fn product(a: &Matrix<f64>, b: &Matrix<f64>) -> Matrix<f64> {
    Matrix::from_fn(a.rows(), b.cols(), |i, j| (0..a.cols()).map(|k| a[(i, k)] * b[(k, j)]).sum())
}

/// Lower triangular with ones on the diagonal, and its inverse, both of integers.
fn unimodular(random: &mut Random, n: usize) -> (Matrix<f64>, Matrix<f64>) {
    let l = Matrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        Ordering::Equal => 1.0,
        Ordering::Greater => integer(random, 2),
        Ordering::Less => 0.0,
    });
    let mut inverse = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    for i in 0..n {
        for j in 0..i {
            inverse[(i, j)] = -(j..i).map(|k| l[(i, k)] * inverse[(k, j)]).sum::<f64>();
        }
    }
    (l, inverse)
}

/// `X X'` of integers, with this rank or less.
fn gram(random: &mut Random, n: usize, rank: usize) -> Matrix<f64> {
    let x = matrix(random, n, rank, 3);
    product(&x, &x.transpose())
}

/// P and F of integers with `F'P + PF = -2 Q` for a positive semidefinite Q, singular more often than not:
/// `F = P^-1 (S - Q)` with S skew. P is `L D L'` with signs D, all positive unless `any_sign`.
fn flow(random: &mut Random, n: usize, any_sign: bool) -> (Matrix<f64>, Matrix<f64>) {
    let (l, inverse) = unimodular(random, n);
    let signs: Vec<f64> = (0..n).map(|_| if any_sign && random.random_bool(0.5) { -1.0 } else { 1.0 }).collect();
    let signed = |m: &Matrix<f64>| Matrix::from_fn(n, n, |i, j| signs[i] * m[(i, j)]);
    let (p, p_inverse) = (product(&l, &signed(&l.transpose())), product(&inverse.transpose(), &signed(&inverse)));
    let rank = random.random_range(0..=n);
    let q = gram(random, n, rank);
    let k = matrix(random, n, n, 3);
    let right = Matrix::from_fn(n, n, |i, j| k[(i, j)] - k[(j, i)] - q[(i, j)]);
    (p, product(&p_inverse, &right))
}

/// As P and F, for `F'PF - P <= 0`: F is similar to a permutation with signs, some rows of which are halved or zero.
fn step(random: &mut Random, n: usize) -> (Matrix<f64>, Matrix<f64>) {
    let (l, inverse) = unimodular(random, n);
    // P = L L', F = L^-T D L' with a contraction D: F'PF - P = L (D'D - I) L'.
    let shift = random.random_range(0..n);
    let sizes: Vec<f64> = (0..n).map(|_| [1.0, -1.0, 0.5, 0.0, 1.0][random.random_range(0..5)]).collect();
    let d = Matrix::from_fn(n, n, |i, j| if (i + shift) % n == j { sizes[i] } else { 0.0 });
    (product(&l, &l.transpose()), product(&product(&inverse.transpose(), &d), &l.transpose()))
}

/// Now and then an entry is off by a float, or all are by a little.
fn disturbed(random: &mut Random, m: &Matrix<f64>, symmetric: bool) -> Matrix<f64> {
    let mut m = m.clone();
    match random.random_range(0..4) {
        0 => {
            let (i, j) = (random.random_range(0..m.rows()), random.random_range(0..m.cols()));
            let x = m[(i, j)];
            let x = if random.random_bool(0.5) { x.next_up() } else { x.next_down() };
            m[(i, j)] = x;
            if symmetric {
                m[(j, i)] = x;
            }
            m
        }
        1 => {
            let size = 10.0_f64.powi(random.random_range(-17..=0));
            let noise: Vec<f64> = m.as_slice().iter().map(|_| size * (random.random::<f64>() - 0.5)).collect();
            let cols = m.cols();
            Matrix::from_fn(m.rows(), cols, |i, j| {
                let k = if symmetric { i.max(j) * cols + i.min(j) } else { i * cols + j };
                m[(i, j)] + noise[k]
            })
        }
        _ => m,
    }
}

/// A plant `A = F + LC` around the flow or step F.
struct Observed {
    a: Matrix<f64>,
    l: Matrix<f64>,
    c: Matrix<f64>,
    p: Matrix<f64>,
}

fn observed(random: &mut Random, (p, f): (Matrix<f64>, Matrix<f64>)) -> Observed {
    let n = f.rows();
    let outputs = random.random_range(1..=2);
    let (l, c) = (matrix(random, n, outputs, 3), matrix(random, outputs, n, 3));
    let lc = product(&l, &c);
    let a = Matrix::from_fn(n, n, |i, j| f[(i, j)] + lc[(i, j)]);
    Observed {
        a: disturbed(random, &a, false),
        l: disturbed(random, &l, false),
        c: disturbed(random, &c, false),
        p: disturbed(random, &p, true),
    }
}

/// `A - LC`, exactly.
fn error_matrix(o: &Observed) -> Integers {
    Integers::of(&o.a).minus(&Integers::of(&o.l).times(&Integers::of(&o.c)))
}

pub(crate) fn lyapunov(random: &mut Random) -> Tally {
    let n = random.random_range(1..=5);
    let data = flow(random, n, false);
    let o = observed(random, data);
    let alpha = [0.0, 0.0, 0.25, -1e-16, 1e-3][random.random_range(0..5)];
    let verdict = statement::decay_rate(&o.a, &o.l, &o.c, &o.p, alpha).expect("well-posed");
    let (p, f) = (Integers::of(&o.p), error_matrix(&o).plus(&Integers::scalar(n, alpha)));
    let truth = Judged::of(p.times(&f).twice_symmetric());
    counted(&verdict, &truth, (&o.a, &o.l, &o.c, &o.p, alpha))
}

pub(crate) fn stein(random: &mut Random) -> Tally {
    let n = random.random_range(1..=5);
    let data = step(random, n);
    let o = observed(random, data);
    let verdict = statement::stein_decrease(&o.a, &o.l, &o.c, &o.p).expect("well-posed");
    let (p, f) = (Integers::of(&o.p), error_matrix(&o));
    let truth = Judged::of(f.transpose().times(&p).times(&f).minus(&p));
    counted(&verdict, &truth, (&o.a, &o.l, &o.c, &o.p))
}

pub(crate) fn feedback(random: &mut Random) -> Tally {
    let n = random.random_range(1..=3);
    let data = flow(random, n, false);
    let mut o = observed(random, data);
    let inputs = random.random_range(1..=2);
    let (b, k) = (matrix(random, n, inputs, 1), matrix(random, inputs, n, 1));
    // The plant under its own feedback decreases with P1 = I in units of the rest.
    let unit = [1.0, 0.125, 1e-3][random.random_range(0..3)];
    let rank = random.random_range(0..=n);
    let q = gram(random, n, rank);
    let (skew, bk) = (matrix(random, n, n, 2), product(&b, &k));
    let closed = Matrix::from_fn(n, n, |i, j| skew[(i, j)] - skew[(j, i)] - q[(i, j)] + bk[(i, j)]);
    let p1 = Matrix::from_fn(n, n, |i, j| if i == j { unit } else { 0.0 });
    // Both inequalities are about one plant: the observer's gain makes up for the difference, with all states measured.
    let f = Matrix::from_fn(n, n, |i, j| o.a[(i, j)] - (0..o.c.rows()).map(|r| o.l[(i, r)] * o.c[(r, j)]).sum::<f64>());
    o.l = Matrix::from_fn(n, n, |i, j| closed[(i, j)] - f[(i, j)]);
    o.c = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    o.a = closed;
    let p1 = disturbed(random, &p1, true);
    let names = Names::new().matrix("A", &o.a).matrix("B", &b).matrix("C", &o.c).matrix("K", &k).matrix("L", &o.l);
    let names = names.symmetric("P1", &p1).symmetric("P", &o.p);
    let verdict =
        names.decide("[(A - BK)'P1 + P1(A - BK), P1 B K; *, (A - LC)'P + P(A - LC)] < 0").expect("well-posed");
    let exact_bk = Integers::of(&b).times(&Integers::of(&k));
    let (p, p1_exact) = (Integers::of(&o.p), Integers::of(&p1));
    let plant = p1_exact.times(&Integers::of(&o.a).minus(&exact_bk)).twice_symmetric();
    let error = p.times(&error_matrix(&o)).twice_symmetric();
    let corner = p1_exact.times(&exact_bk);
    let truth = Judged::of(Integers::blocks(&plant, &corner, &corner.transpose(), &error));
    counted(&verdict, &truth, (&o.a, &b, &k, &o.l, &o.c, &p1, &o.p))
}

/// The margin of [`statement::hurwitz`] is a rate: `A'P + PA + 2 margin P <= 0`.
pub(crate) fn hurwitz(random: &mut Random) -> Tally {
    let n = random.random_range(1..=5);
    let any_sign = random.random_bool(0.4);
    let (p, a) = flow(random, n, any_sign);
    let (a, p) = (disturbed(random, &a, false), disturbed(random, &p, true));
    let verdict = statement::hurwitz(&a, &p).expect("well-posed");
    let (exact_p, exact_a) = (Integers::of(&p), Integers::of(&a));
    let decrease = exact_p.times(&exact_a).twice_symmetric();
    let (slope, size) = (Judged::of(decrease.clone()), Judged::of(exact_p.clone()));
    let decreases = Sense::NegativeDefinite.is_true(slope.inertia);
    let positive = Sense::PositiveDefinite.is_true(size.inertia);
    let fault = match &verdict {
        Verdict::Proved { .. } if !(decreases && positive) => Some("wrongly proved"),
        Verdict::Proved { margin } => {
            let rate = exact_p.times(&Integers::scalar(n, 2.0 * margin));
            let at_rate = Judged::of(decrease.plus(&rate));
            (*margin < 0.0 || !Sense::NegativeSemidefinite.is_true(at_rate.inertia))
                .then_some("a margin above the truth")
        }
        Verdict::Refuted { .. } if !decreases || positive => Some("wrongly refuted"),
        Verdict::Refuted { witness } => {
            (!super::trial::refutes(&exact_p, witness, Sense::PositiveDefinite)).then_some("a witness of nothing")
        }
        Verdict::Undecided { .. } => None,
    };
    let mut tally = Tally { cases: 1, ..Tally::default() };
    tally.count(&verdict, decreases, (&a, &p), fault);
    tally
}

fn counted(verdict: &Verdict<luenberger_proof::Direction>, truth: &Judged, data: impl std::fmt::Debug) -> Tally {
    let mut tally = Tally { cases: 1, ..Tally::default() };
    tally.count(verdict, true, data, truth.fault(verdict, Sense::NegativeDefinite));
    tally
}
