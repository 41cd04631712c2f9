//! Observers of a part of the state, or of a function `z = K x` of it: fewer states than the plant's.
//!
//! For `x' = A x + B u, y = C x` the observer
//!
//! ```text
//! w' = F w + G y + H u,    zhat = M w + N y                T A - F T = G C,    H = T B,    M T + N C = K
//! ```
//! has `(w - T x)' = F (w - T x)` and `zhat - z = M (w - T x)`: with F stable the error dies out whatever the input
//! (Luenberger, IEEE TAC 11, 1966).
//!
//! - *The whole state*, `K = I`: what the outputs say is taken from them, and only the `n - rank(C)` other states are
//!   estimated: [`reduced_order_observer`].
//! - *A few functions*: [`functional_observer`] has as many states as K has rows, if Darouach's two conditions hold
//!   (IEEE TAC 45, 2000).
//!
//! Outputs enter `zhat` without a filter: measurement noise passes straight through N. That is the price of the smaller
//! order.

use faer::Mat;
use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned, shaped};
use crate::observability::{Seen, check, default_tolerance, seen};
use crate::placement::{place_observer, place_part};
use crate::units::{Units, shift};
use crate::{LinalgError, Placement, Result};

/// `w' = F w + G y + H u, zhat = M w + N y`, in discrete time `w+ = F w + G y + H u`.
#[derive(Debug, Clone, PartialEq)]
pub struct FunctionalObserver {
    /// T, q x n: `w` follows `T x`.
    pub t: DMatrix<f64>,
    /// F, q x q.
    pub f: DMatrix<f64>,
    /// G, q x p.
    pub g: DMatrix<f64>,
    /// `H = T B`, q x m.
    pub h: DMatrix<f64>,
    /// M, r x q.
    pub m: DMatrix<f64>,
    /// N, r x p.
    pub n: DMatrix<f64>,
    /// The placement of the eigenvalues of F: which were reached, how well conditioned. Its gain belongs to the inner
    /// problem.
    pub placement: Placement,
    /// The larger of `|T A - F T - G C| / (|T| |A| + |F| |T| + |G| |C|)` and `|M T + N C - K| / (|M| |T| + |N| |C|)` in
    /// Frobenius norms, in the units chosen.
    pub residual: f64,
}

/// Luenberger's reduced-order observer of the whole state: `n - rank(C)` states, the eigenvalues of F at `poles`.
///
/// `a` is n x n, `b` n x m, `c` p x n, `poles` `n - rank(C)` numbers, real or complex, closed under conjugation. It
/// exists iff the pair is observable: with `C V = [C1 0]`, V orthogonal, F is `A22 - L A12`, and the pair `(A22, A12)`
/// is observable iff `(A, C)` is. M and N have n rows: `zhat` is the state. Outputs that depend on others count once;
/// with rank(C) = n there is no `w` left, and `xhat = N y`.
///
/// # Errors
/// [`LinalgError::Unobservable`] names the mode; [`LinalgError::PoleCount`] (its `order` is `n - rank(C)`) and the
/// other errors of [`place_observer`]; [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`],
/// [`LinalgError::NotFinite`], [`LinalgError::Empty`].
///
/// # Cost
/// The test of observability and a placement of order `n - rank(C)`.
///
/// # Example
/// The double integrator with its position measured: the velocity from one state.
/// ```
/// use luenberger_linalg::reduced_order_observer;
/// use nalgebra::{DMatrix, dmatrix};
///
/// let (a, b, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
/// let observer = reduced_order_observer(&a, &b, &c, &[-4.0])?;
/// let motion = (&observer.t * &a - &observer.f * &observer.t - &observer.g * &c).norm();
/// let whole = (&observer.m * &observer.t + &observer.n * &c - DMatrix::identity(2, 2)).norm();
/// println!("w' = {} w + {} y + {} u, residuals {motion:e} {whole:e}", observer.f, observer.g, observer.h);
/// assert!(motion < 1e-14 && whole < 1e-14 && (observer.f[0] + 4.0).abs() < 1e-14);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Luenberger, IEEE Trans. Military Electronics 8, 1964; Gopinath, Bell System Technical Journal 50, 1971.
pub fn reduced_order_observer<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
) -> Result<FunctionalObserver> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    reduced(&owned(a), &owned(b), &owned(c), &poles)
}

fn reduced(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<FunctionalObserver> {
    check(a, c)?;
    let (n, p) = (a.nrows(), c.nrows());
    shaped("B", b, n, b.ncols())?;
    let units = Units::of(a, c);
    if let Seen::Hidden(mode) = seen(&units, a, c)? {
        let (eigenvalue, direction, margin) = (mode.eigenvalue, mode.direction, mode.margin);
        return Err(LinalgError::Unobservable { eigenvalue, direction, margin });
    }
    let plant = Scaled { a: units.dynamics(a), c: units.outputs(c), units };
    let split = Singular::of(&plant.c.transpose())?;
    let rank = split.rank;
    // y1 = S^-1 V'y = U1'x.
    let (v1, v2) = (split.u.columns(0, rank).into_owned(), split.u.columns(rank, n - rank).into_owned());
    let mut read = DMatrix::from_fn(rank, p, |i, k| split.v[(k, i)] / split.sigma[i]);
    without_blind(&mut read, c);
    let (a11, a12) = (v1.transpose() * &plant.a * &v1, v1.transpose() * &plant.a * &v2);
    let (a21, a22) = (v2.transpose() * &plant.a * &v1, v2.transpose() * &plant.a * &v2);
    // The part inherits its observability, and the rounding of the turn is not to be read as data.
    let size = plant.a.norm();
    let placement = plant.place(&cleaned(&a22, size), &cleaned(&a12, size), poles, place_part)?;
    let l = &placement.gain;
    let f = &a22 - l * &a12;
    let inner = Matrices {
        t: v2.transpose() - l * v1.transpose(),
        g: (&a21 - l * &a11 + &f * l) * &read,
        m: v2.clone(),
        n: (v1 + v2 * l) * read,
        f,
    };
    let residual = inner.residual((&plant.a, &plant.c), &DMatrix::identity(n, n));
    let units = &plant.units;
    // w has no unit of its own, x = D z, y = R y_s.
    let t = DMatrix::from_fn(n - rank, n, |i, j| shift(inner.t[(i, j)], -units.state[j]));
    checked(FunctionalObserver {
        h: &t * b,
        t,
        f: inner.f.map(|x| shift(x, units.time)),
        g: DMatrix::from_fn(n - rank, p, |i, k| shift(inner.g[(i, k)], units.time - units.output[k])),
        m: DMatrix::from_fn(n, n - rank, |i, j| shift(inner.m[(i, j)], units.state[i])),
        n: DMatrix::from_fn(n, p, |i, k| shift(inner.n[(i, k)], units.state[i] - units.output[k])),
        placement,
        residual,
    })
}

/// Observer of `z = K x` with as many states as K has rows, the eigenvalues of F at `poles`.
///
/// `a` is n x n, `b` n x m, `c` p x n, `k` q x n, `poles` q numbers, real or complex, closed under conjugation. M is
/// the identity. One exists for every set of poles iff (Darouach)
///
/// 1. `rank [K A; C A; C; K] = rank [C A; C; K]`: the rate of z follows from z, y and y';
/// 2. `rank [s K - K A; C A; C] = rank [C A; C; K]` for every complex s: no motion of z is hidden (for an observer that
///    merely converges, for `Re s >= 0`).
///
/// Where the first fails, an observer of a larger order may exist, for further functions beside these:
/// [`least_functional_observer`](crate::least_functional_observer). The plant need not be observable.
///
/// # Errors
/// [`LinalgError::NotFunctional`] names the first condition and the row of `K A` that misses most,
/// [`LinalgError::FixedObserverMode`] the second and the s; those of [`place_observer`]; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Empty`] (also for K).
///
/// # Cost
/// A singular value decomposition of order `q + 2p` by n, and a placement of order q.
///
/// # Example
/// ```
/// use luenberger_linalg::functional_observer;
/// use nalgebra::dmatrix;
///
/// // x2 + x3 of a chain of three, the first measured: of order one, although two states are not measured.
/// let a = dmatrix![0.0, 1.0, 1.0; 1.0, -2.0, 1.0; 1.0, 2.0, -1.0];
/// let (b, c, k) = (dmatrix![0.0; 0.0; 1.0], dmatrix![1.0, 0.0, 0.0], dmatrix![0.0, 1.0, 1.0]);
/// let observer = functional_observer(&a, &b, &c, &k, &[-3.0])?;
/// let motion = (&observer.t * &a - &observer.f * &observer.t - &observer.g * &c).norm();
/// let read = (&observer.m * &observer.t + &observer.n * &c - &k).norm();
/// println!("residuals {motion:e} {read:e}");
/// assert!(motion < 1e-13 && read < 1e-14 && (observer.f[0] + 3.0).abs() < 1e-13);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Darouach, IEEE TAC 45, 2000, theorem 2.
pub fn functional_observer<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    k: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
) -> Result<FunctionalObserver> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    functional(&owned(a), &owned(b), &owned(c), &owned(k), &poles)
}

pub(crate) fn functional(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    k: &DMatrix<f64>,
    poles: &[Complex<f64>],
) -> Result<FunctionalObserver> {
    check(a, c)?;
    let (n, p, q) = (a.nrows(), c.nrows(), k.nrows());
    shaped("B", b, n, b.ncols())?;
    shaped("K", k, q, n)?;
    if q == 0 {
        return Err(LinalgError::Empty { what: "K" });
    }
    // One choice of units for what is measured and what is asked for.
    let mut both = DMatrix::zeros(p + q, n);
    both.rows_mut(0, p).copy_from(c);
    both.rows_mut(p, q).copy_from(k);
    let mut units = Units::of(a, &both);
    let fastest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    if a.amax() == 0.0 && fastest > 0.0 {
        // Then only the poles tell the unit of time.
        units.time = fastest.log2().round() as i32;
    }
    let both = units.outputs(&both);
    let asked = units.output.split_off(p);
    let (ks, plant) =
        (both.rows(p, q).into_owned(), Scaled { a: units.dynamics(a), c: both.rows(0, p).into_owned(), units });

    // [F E J] [K; C A; C] = K A.
    let mut known = DMatrix::zeros(q + 2 * p, n);
    known.rows_mut(0, q).copy_from(&ks);
    known.rows_mut(q, p).copy_from(&(&plant.c * &plant.a));
    known.rows_mut(q + p, p).copy_from(&plant.c);
    let split = Singular::of(&known)?;
    let rank = split.rank;
    let rate = &ks * &plant.a;
    let basis = split.v.columns(0, rank);
    let missed = &rate - (&rate * basis) * basis.transpose();
    let floor = default_tolerance(n, q + 2 * p) * (ks.norm() * plant.a.norm());
    let worst = (0..q).map(|i| (i, missed.row(i).norm())).fold((0, 0.0), |w, x| if x.1 > w.1 { x } else { w });
    if worst.1 > floor {
        let scale = rate.row(worst.0).norm();
        return Err(LinalgError::NotFunctional { row: worst.0, residual: worst.1 / scale, allowed: floor / scale });
    }
    let particular = DMatrix::from_fn(q, q + 2 * p, |i, j| {
        (0..rank).map(|s| rate.row(i).dot(&split.v.column(s).transpose()) / split.sigma[s] * split.u[(j, s)]).sum()
    });
    // The freedom left: rows orthogonal to all that is known.
    let free = split.u.columns(rank, q + 2 * p - rank).transpose();
    let (fa, fb) = (
        cleaned(&particular.columns(0, q).into_owned(), plant.a.norm()),
        cleaned(&free.columns(0, q).into_owned(), 1.0),
    );
    let placement = match plant.place(&fa, &fb, poles, |a, c, poles| place_observer(a, c, poles)) {
        Err(LinalgError::Unobservable { eigenvalue, margin, .. }) => {
            return Err(LinalgError::FixedObserverMode { eigenvalue, margin });
        }
        other => other?,
    };
    let all = particular - &placement.gain * free;
    let (f, mut e, mut j) =
        (all.columns(0, q).into_owned(), all.columns(q, p).into_owned(), all.columns(q + p, p).into_owned());
    without_blind(&mut e, c);
    without_blind(&mut j, c);
    let inner = Matrices { t: &ks - &e * &plant.c, g: j + &f * &e, m: DMatrix::identity(q, q), n: e, f };
    inner.in_given_units((&plant.a, &plant.c), &ks, (&plant.units, &asked), (b, placement))
}

/// An output that sees no state has no unit and no part in an observer: rounding would give it one.
fn without_blind(by_output: &mut DMatrix<f64>, c: &DMatrix<f64>) {
    for (mut column, row) in by_output.column_iter_mut().zip(c.row_iter()) {
        if row.amax() == 0.0 {
            column.fill(0.0);
        }
    }
}

/// A pair in its units.
struct Scaled {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    units: Units,
}

impl Scaled {
    /// `place` for poles in the units given; for order zero nothing is placed. The answer's poles are in the units
    /// given, its gain is not.
    fn place(
        &self,
        a: &DMatrix<f64>,
        c: &DMatrix<f64>,
        poles: &[Complex<f64>],
        place: impl Fn(&DMatrix<f64>, &DMatrix<f64>, &[Complex<f64>]) -> Result<Placement>,
    ) -> Result<Placement> {
        let time = self.units.time;
        let scaled = |p: &Complex<f64>, power: i32| Complex::new(shift(p.re, power), shift(p.im, power));
        let none = Placement::nothing(c.nrows());
        if a.nrows() == 0 {
            return if poles.is_empty() {
                Ok(none)
            } else {
                Err(LinalgError::PoleCount { order: 0, found: poles.len() })
            };
        }
        let scaled: Vec<Complex<f64>> = poles.iter().map(|p| scaled(p, -time)).collect();
        place(a, c, &scaled).map(|found| found.in_time(time)).map_err(|error| error.in_time(time))
    }
}

fn checked(observer: FunctionalObserver) -> Result<FunctionalObserver> {
    let all = [&observer.t, &observer.f, &observer.g, &observer.h, &observer.m, &observer.n];
    if all.iter().any(|m| m.iter().any(|x| !x.is_finite())) {
        return Err(LinalgError::Overflow { what: "the observer in the units given" });
    }
    Ok(observer)
}

/// The observer in the plant's units.
pub(crate) struct Matrices {
    pub(crate) t: DMatrix<f64>,
    pub(crate) f: DMatrix<f64>,
    pub(crate) g: DMatrix<f64>,
    pub(crate) m: DMatrix<f64>,
    pub(crate) n: DMatrix<f64>,
}

impl Matrices {
    /// An observer of functions, M the identity, in the units given: `z = R_k z_s`, and its states have the units of z.
    pub(crate) fn in_given_units(
        self,
        (a, c): (&DMatrix<f64>, &DMatrix<f64>),
        functions: &DMatrix<f64>,
        (units, asked): (&Units, &[i32]),
        (b, placement): (&DMatrix<f64>, Placement),
    ) -> Result<FunctionalObserver> {
        let (q, p, n) = (self.t.nrows(), c.nrows(), a.nrows());
        let residual = self.residual((a, c), functions);
        let t = DMatrix::from_fn(q, n, |i, j| shift(self.t[(i, j)], asked[i] - units.state[j]));
        checked(FunctionalObserver {
            h: &t * b,
            t,
            f: DMatrix::from_fn(q, q, |i, j| shift(self.f[(i, j)], asked[i] - asked[j] + units.time)),
            g: DMatrix::from_fn(q, p, |i, k| shift(self.g[(i, k)], asked[i] + units.time - units.output[k])),
            m: self.m,
            n: DMatrix::from_fn(q, p, |i, k| shift(self.n[(i, k)], asked[i] - units.output[k])),
            placement,
            residual,
        })
    }

    fn residual(&self, (a, c): (&DMatrix<f64>, &DMatrix<f64>), asked: &DMatrix<f64>) -> f64 {
        let Self { t, f, g, m, n } = self;
        let relative = |x: f64, terms: f64| if x == 0.0 { 0.0 } else { x / terms };
        let motion = (t * a - f * t - g * c).norm();
        let read = (m * t + n * c - asked).norm();
        let motion = relative(motion, t.norm() * a.norm() + f.norm() * t.norm() + g.norm() * c.norm());
        motion.max(relative(read, m.norm() * t.norm() + n.norm() * c.norm()))
    }
}

/// What is rounding beside `size` is zero: [`place_observer`] reads every entry in units of its own, and would make use
/// of it.
fn cleaned(m: &DMatrix<f64>, size: f64) -> DMatrix<f64> {
    let floor = default_tolerance(m.nrows(), m.ncols()) * size;
    m.map(|x| if x.abs() <= floor { 0.0 } else { x })
}

/// `M = U S V'` with the whole of U and V.
pub(crate) struct Singular {
    pub(crate) u: DMatrix<f64>,
    pub(crate) sigma: Vec<f64>,
    pub(crate) v: DMatrix<f64>,
    pub(crate) rank: usize,
}

impl Singular {
    pub(crate) fn of(m: &DMatrix<f64>) -> Result<Self> {
        let (rows, columns) = m.shape();
        let tolerance = default_tolerance(rows, columns);
        let svd = Mat::from_fn(rows, columns, |i, j| m[(i, j)]).svd().map_err(|_| LinalgError::NotConverged {
            method: "singular values of the outputs",
            iterations: 0,
            remaining: f64::NAN,
            allowed: tolerance,
        })?;
        let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let floor = tolerance * sigma.first().copied().unwrap_or(0.0);
        let rank = sigma.iter().filter(|s| **s > floor).count();
        let (u, v) = (svd.U(), svd.V());
        Ok(Self {
            u: DMatrix::from_fn(rows, rows, |i, j| u[(i, j)]),
            v: DMatrix::from_fn(columns, columns, |i, j| v[(i, j)]),
            sigma,
            rank,
        })
    }
}
