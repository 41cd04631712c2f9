//! The error `e' = F e + w - L v + (r'theta r) N r`, `r = C e + v`, integrated by Runge and Kutta's method with steps
//! as short as the cubic term is stiff, without allocation.

// At the optimisation of tests, adapters of iterators are calls: here they take as long as the arithmetic.
#![allow(clippy::needless_range_loop)]

use nalgebra::DMatrix;

/// Rates times steps: the error of a step of the fourth order is about their fifth power over 120.
const STEP: f64 = 0.25;
/// Longest integration of a first error.
const MOST_STEPS: usize = 40_000;

/// A cubic observer in the units of the problem.
pub(super) struct Gains {
    pub(super) l: DMatrix<f64>,
    pub(super) n: DMatrix<f64>,
    pub(super) theta: DMatrix<f64>,
}

/// A column: an array, for whose length the loops are unrolled, or a vector of any length.
pub(super) trait Column: Clone + AsRef<[f64]> + AsMut<[f64]> {
    fn zeros(length: usize) -> Self;
}

impl<const LENGTH: usize> Column for [f64; LENGTH] {
    fn zeros(_length: usize) -> Self {
        [0.0; LENGTH]
    }
}

impl Column for Vec<f64> {
    fn zeros(length: usize) -> Self {
        vec![0.0; length]
    }
}

/// The error equation, with errors `E` and residuals `R`; matrices row by row.
pub(super) struct ErrorFlow<E, R> {
    f: Vec<E>,
    c: Vec<E>,
    l: Vec<R>,
    gain: Vec<R>,
    theta: Vec<R>,
    weight: Vec<E>,
    /// The largest modulus of an eigenvalue of F.
    fastest: f64,
    /// `|C N|`.
    output_gain: f64,
    work: Work<E, R>,
}

/// Columns that a step needs.
struct Work<E, R> {
    residual: Residual<R>,
    forcing: E,
    at: E,
    slopes: [E; 4],
}

/// `r = C e + v` and theta r.
struct Residual<R> {
    v: R,
    r: R,
    theta_r: R,
}

fn rows<X: Column>(m: &DMatrix<f64>) -> Vec<X> {
    let rows = m.row_iter().map(|row| {
        let mut entries = X::zeros(m.ncols());
        entries.as_mut().iter_mut().zip(row.iter()).for_each(|(to, from)| *to = *from);
        entries
    });
    rows.collect()
}

#[inline]
fn dot<X: Column>(row: &X, x: &X) -> f64 {
    let (row, x) = (row.as_ref(), x.as_ref());
    let mut sum = 0.0;
    for k in 0..x.len().min(row.len()) {
        sum += row[k] * x[k];
    }
    sum
}

impl<E: Column, R: Column> ErrorFlow<E, R> {
    pub(super) fn new(f: &DMatrix<f64>, c: &DMatrix<f64>, gains: &Gains, weight: &DMatrix<f64>, fastest: f64) -> Self {
        let (e, r) = (E::zeros(f.nrows()), R::zeros(c.nrows()));
        Self {
            f: rows(f),
            c: rows(c),
            l: rows(&gains.l),
            gain: rows(&gains.n),
            theta: rows(&gains.theta),
            weight: rows(weight),
            fastest,
            output_gain: (c * &gains.n).norm(),
            work: Work {
                residual: Residual { v: r.clone(), r: r.clone(), theta_r: r },
                forcing: e.clone(),
                at: e.clone(),
                slopes: [e.clone(), e.clone(), e.clone(), e],
            },
        }
    }

    /// `e'Te`.
    pub(super) fn square(&self, e: &E) -> f64 {
        square(&self.weight, e)
    }

    /// A bound of the eigenvalues of the Jacobian of the cubic term.
    fn stiffness(&mut self, e: &E) -> f64 {
        let residual = &mut self.work.residual;
        let q = residual.at(&self.c, &self.theta, e);
        let (length, weighted) = (dot(&residual.r, &residual.r), dot(&residual.theta_r, &residual.theta_r));
        self.output_gain * (q + 2.0 * (length * weighted).sqrt())
    }

    /// A step of length h; with `cost`, the integral of `e'Te` over it is added there.
    fn step(&mut self, e: &mut E, h: f64, cost: Option<&mut f64>) {
        let Work { residual, forcing, at, slopes } = &mut self.work;
        let mut sum = 0.0;
        for stage in 0..4 {
            let (share, weight) = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)][stage];
            at.clone_from(e);
            if stage > 0 {
                let (at, before) = (at.as_mut(), slopes[stage - 1].as_ref());
                for i in 0..at.len() {
                    at[i] += share * h * before[i];
                }
            }
            if cost.is_some() {
                sum += weight * square(&self.weight, at);
            }
            let q = residual.at(&self.c, &self.theta, at);
            let (slope, forcing) = (slopes[stage].as_mut(), forcing.as_ref());
            for i in 0..slope.len() {
                slope[i] = dot(&self.f[i], at) + forcing[i] + q * dot(&self.gain[i], &residual.r);
            }
        }
        if let Some(cost) = cost {
            *cost += sum * h / 6.0;
        }
        let [a, b, c, d] = slopes;
        let (a, b, c, d, e) = (a.as_ref(), b.as_ref(), c.as_ref(), d.as_ref(), e.as_mut());
        for i in 0..e.len() {
            e[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }

    /// `int_0^inf e'Te dt` from a first error, without noise; none once it is above `most`. Where the cubic term is a
    /// thousandth of the slowest mode, the rest is that of the linear observer, `e'Me`.
    pub(super) fn transient(&mut self, first: &[f64], slowest: f64, tail: &DMatrix<f64>, most: f64) -> Option<f64> {
        self.work.forcing.as_mut().fill(0.0);
        self.work.residual.v.as_mut().fill(0.0);
        let mut e = E::zeros(first.len());
        e.as_mut().copy_from_slice(first);
        let mut sum = 0.0;
        for _ in 0..MOST_STEPS {
            let stiffness = self.stiffness(&e);
            if stiffness <= 1e-3 * slowest {
                let e = e.as_ref();
                let row = |i: usize| (0..e.len()).map(|j| tail[(i, j)] * e[j]).sum::<f64>();
                let rest: f64 = (0..e.len()).map(|i| e[i] * row(i)).sum();
                return (sum + rest).is_finite().then_some(sum + rest);
            }
            self.step(&mut e, STEP / (self.fastest + stiffness), Some(&mut sum));
            if sum > most {
                break;
            }
        }
        None
    }

    /// The error after a period with noise (w, v) that is held, by at most so many steps.
    pub(super) fn held(&mut self, e: &mut E, (w, v): (&[f64], &[f64]), period: f64, most: f64) -> Option<()> {
        self.work.residual.v.as_mut().copy_from_slice(v);
        let (forcing, v) = (self.work.forcing.as_mut(), &self.work.residual.v);
        for i in 0..forcing.len() {
            forcing[i] = w[i] - dot(&self.l[i], v);
        }
        let stiffness = self.stiffness(e);
        let steps = (period * (self.fastest + stiffness) / (2.0 * STEP)).ceil().max(1.0);
        if steps.is_nan() || steps > most {
            return None;
        }
        for _ in 0..steps as usize {
            self.step(e, period / steps, None);
        }
        Some(())
    }
}

impl<R: Column> Residual<R> {
    /// r and theta r at the error e; returns `r'theta r`.
    #[inline]
    fn at<E: Column>(&mut self, c: &[E], theta: &[R], e: &E) -> f64 {
        let (r, v) = (self.r.as_mut(), self.v.as_ref());
        for i in 0..r.len() {
            r[i] = dot(&c[i], e) + v[i];
        }
        let theta_r = self.theta_r.as_mut();
        for i in 0..theta_r.len() {
            theta_r[i] = dot(&theta[i], &self.r);
        }
        dot(&self.theta_r, &self.r)
    }
}

/// `e'Te`, with the rows of T.
#[inline]
fn square<E: Column>(weight: &[E], e: &E) -> f64 {
    let entries = e.as_ref();
    let mut sum = 0.0;
    for i in 0..entries.len() {
        sum += entries[i] * dot(&weight[i], e);
    }
    sum
}
