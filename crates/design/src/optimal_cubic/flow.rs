//! The error `e' = F e + w - L v + (r'theta r) N r`, `r = C e + v`, integrated by Runge and Kutta's method with steps
//! as short as the cubic term is stiff, without allocation.
//!
//! Several errors are integrated side by side, because a step of one waits for its own operations most of the time.
//! Each has its own steps, and no operation joins two of them.

// At the optimisation of tests, adapters of iterators are calls: here they take as long as the arithmetic.
#![allow(clippy::needless_range_loop)]
#![allow(
    clippy::inline_always,
    reason = "what is not inlined has not the instructions of the machine, see `Scaled::cubic`"
)]

use nalgebra::DMatrix;

/// Rates times steps: the error of a step of the fourth order is about their fifth power over 120.
const STEP: f64 = 0.25;
/// Longest integration of a first error.
const MOST_STEPS: usize = 40_000;

/// Errors that are integrated side by side.
pub(super) const LANES: usize = 8;

/// A number of each of them.
pub(super) type Lanes = [f64; LANES];

/// A cubic observer in the units of the problem.
pub(super) struct Gains {
    pub(super) l: DMatrix<f64>,
    pub(super) n: DMatrix<f64>,
    pub(super) theta: DMatrix<f64>,
}

/// A column, of numbers or of lanes: an array, for whose length the loops are unrolled, or a vector of any length.
pub(super) trait Column<X>: Clone + AsRef<[X]> + AsMut<[X]> {
    /// A column of numbers of the same length.
    type Row: Column<f64>;

    /// So many times the same.
    fn filled(length: usize, value: X) -> Self;
}

impl<X: Copy, const LENGTH: usize> Column<X> for [X; LENGTH] {
    type Row = [f64; LENGTH];

    fn filled(_length: usize, value: X) -> Self {
        [value; LENGTH]
    }
}

impl<X: Copy> Column<X> for Vec<X> {
    type Row = Vec<f64>;

    fn filled(length: usize, value: X) -> Self {
        vec![value; length]
    }
}

/// The error equation, with errors `E` and residuals `R`; matrices row by row.
pub(super) struct ErrorFlow<E: Column<Lanes>, R: Column<Lanes>> {
    f: Vec<E::Row>,
    c: Vec<E::Row>,
    l: Vec<R::Row>,
    gain: Vec<R::Row>,
    theta: Vec<R::Row>,
    weight: Vec<E::Row>,
    /// The largest modulus of an eigenvalue of F.
    fastest: f64,
    /// `|C N|`.
    output_gain: f64,
    work: Work<E, R>,
}

/// What follows where the error is linear.
pub(super) struct Rest<E: Column<Lanes>> {
    /// M, of the integral `e'Me`.
    pub(super) tail: Vec<E::Row>,
    /// B: `3 r'theta r <= e'Be` on the way of the linear observer; r itself passes 0 while the error is large.
    pub(super) ahead: Vec<E::Row>,
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

/// The rows of a matrix.
pub(super) fn rows<X: Column<f64>>(m: &DMatrix<f64>) -> Vec<X> {
    let rows = m.row_iter().map(|row| {
        let mut entries = X::filled(m.ncols(), 0.0);
        entries.as_mut().iter_mut().zip(row.iter()).for_each(|(to, from)| *to = *from);
        entries
    });
    rows.collect()
}

/// Of each lane.
#[inline(always)]
pub(super) fn lanes(value: impl Fn(usize) -> f64) -> Lanes {
    let mut lanes = [0.0; LANES];
    for k in 0..LANES {
        lanes[k] = value(k);
    }
    lanes
}

/// A row of a matrix times a column.
#[inline(always)]
pub(super) fn dot<Row: AsRef<[f64]>>(row: &Row, x: &[Lanes]) -> Lanes {
    let row = row.as_ref();
    let mut sum = [0.0; LANES];
    for k in 0..x.len().min(row.len()) {
        for lane in 0..LANES {
            sum[lane] += row[k] * x[k][lane];
        }
    }
    sum
}

/// The product of two columns.
#[inline(always)]
fn product(x: &[Lanes], y: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for k in 0..x.len().min(y.len()) {
        for lane in 0..LANES {
            sum[lane] += x[k][lane] * y[k][lane];
        }
    }
    sum
}

/// `e'Te`, with the rows of T.
#[inline(always)]
pub(super) fn square<Row: AsRef<[f64]>>(weight: &[Row], e: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for i in 0..e.len().min(weight.len()) {
        let weighted = dot(&weight[i], e);
        for lane in 0..LANES {
            sum[lane] += e[i][lane] * weighted[lane];
        }
    }
    sum
}

impl<E: Column<Lanes>, R: Column<Lanes>> ErrorFlow<E, R> {
    pub(super) fn new(f: &DMatrix<f64>, c: &DMatrix<f64>, gains: &Gains, weight: &DMatrix<f64>, fastest: f64) -> Self {
        let zero = [0.0; LANES];
        let (e, r) = (E::filled(f.nrows(), zero), R::filled(c.nrows(), zero));
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
    #[inline(always)]
    pub(super) fn square(&self, e: &E) -> Lanes {
        square(&self.weight, e.as_ref())
    }

    /// Bounds of the eigenvalues of the Jacobian of the cubic term.
    #[inline(always)]
    fn stiffness(&mut self, e: &E) -> Lanes {
        let residual = &mut self.work.residual;
        let q = residual.at(&self.c, &self.theta, e.as_ref());
        let (r, theta_r) = (residual.r.as_ref(), residual.theta_r.as_ref());
        let (length, weighted) = (product(r, r), product(theta_r, theta_r));
        lanes(|lane| self.output_gain * (q[lane] + 2.0 * (length[lane] * weighted[lane]).sqrt()))
    }

    /// Steps of the lengths h, of which 0 leaves an error as it is; with `cost`, the integral of `e'Te` over them is
    /// added there.
    #[inline(always)]
    fn step(&mut self, e: &mut E, h: &Lanes, cost: Option<&mut Lanes>) {
        let Work { residual, forcing, at, slopes } = &mut self.work;
        let mut sum = [0.0; LANES];
        for stage in 0..4 {
            let (share, weight) = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)][stage];
            at.clone_from(e);
            if stage > 0 {
                let (at, before) = (at.as_mut(), slopes[stage - 1].as_ref());
                for i in 0..at.len() {
                    for lane in 0..LANES {
                        at[i][lane] += share * h[lane] * before[i][lane];
                    }
                }
            }
            let at = at.as_ref();
            if cost.is_some() {
                let square = square(&self.weight, at);
                for lane in 0..LANES {
                    sum[lane] += weight * square[lane];
                }
            }
            let q = residual.at(&self.c, &self.theta, at);
            let (slope, forcing) = (slopes[stage].as_mut(), forcing.as_ref());
            for i in 0..slope.len() {
                let (linear, cubic) = (dot(&self.f[i], at), dot(&self.gain[i], residual.r.as_ref()));
                for lane in 0..LANES {
                    slope[i][lane] = linear[lane] + forcing[i][lane] + q[lane] * cubic[lane];
                }
            }
        }
        if let Some(cost) = cost {
            for lane in 0..LANES {
                cost[lane] += sum[lane] * h[lane] / 6.0;
            }
        }
        let [a, b, c, d] = slopes;
        let (a, b, c, d, e) = (a.as_ref(), b.as_ref(), c.as_ref(), d.as_ref(), e.as_mut());
        for i in 0..e.len() {
            for lane in 0..LANES {
                let slopes = a[i][lane] + 2.0 * b[i][lane] + 2.0 * c[i][lane] + d[i][lane];
                e[i][lane] += h[lane] / 6.0 * slopes;
            }
        }
    }

    /// `int_0^inf e'Te dt` from at most as many first errors as there are lanes, without noise; none once their sum is
    /// above `most`. Where the cubic term stays below a thousandth of the slowest mode, the rest is that of the linear
    /// observer, `e'Me`.
    #[inline(always)]
    pub(super) fn transients(&mut self, firsts: &[Vec<f64>], slowest: f64, rest: &Rest<E>, most: f64) -> Option<Lanes> {
        self.work.forcing.as_mut().fill([0.0; LANES]);
        self.work.residual.v.as_mut().fill([0.0; LANES]);
        let mut e = E::filled(rest.tail.len(), [0.0; LANES]);
        for (lane, first) in firsts.iter().enumerate().take(LANES) {
            for (entry, first) in e.as_mut().iter_mut().zip(first) {
                entry[lane] = *first;
            }
        }
        let mut sum = [0.0; LANES];
        for _ in 0..MOST_STEPS {
            let stiffness = self.stiffness(&e);
            let ahead = square(&rest.ahead, e.as_ref());
            let is_linear = |lane: usize| self.output_gain * ahead[lane] <= 1e-3 * slowest;
            if (0..LANES).all(is_linear) {
                let rest = square(&rest.tail, e.as_ref());
                let all = lanes(|lane| sum[lane] + rest[lane]);
                return all.iter().all(|sum| sum.is_finite()).then_some(all);
            }
            let h = lanes(|lane| if is_linear(lane) { 0.0 } else { STEP / (self.fastest + stiffness[lane]) });
            self.step(&mut e, &h, Some(&mut sum));
            let so_far: f64 = sum.iter().sum();
            if so_far > most || so_far.is_nan() {
                break;
            }
        }
        None
    }

    /// The errors after a period with noise (w, v) that is held, by at most so many steps.
    #[inline(always)]
    pub(super) fn held(&mut self, e: &mut E, (w, v): (&[Lanes], &[Lanes]), period: f64, most: f64) -> Option<()> {
        self.work.residual.v.as_mut().copy_from_slice(v);
        let forcing = self.work.forcing.as_mut();
        for i in 0..forcing.len() {
            let injected = dot(&self.l[i], v);
            forcing[i] = lanes(|lane| w[i][lane] - injected[lane]);
        }
        let stiffness = self.stiffness(e);
        let steps = lanes(|lane| (period * (self.fastest + stiffness[lane]) / (2.0 * STEP)).ceil().max(1.0));
        if steps.iter().zip(&stiffness).any(|(steps, stiffness)| stiffness.is_nan() || *steps > most) {
            return None;
        }
        let count = steps.iter().fold(0.0, |most: f64, steps| most.max(*steps));
        for k in 0..count as usize {
            let h = lanes(|lane| if (k as f64) < steps[lane] { period / steps[lane] } else { 0.0 });
            self.step(e, &h, None);
        }
        Some(())
    }
}

impl<R: Column<Lanes>> Residual<R> {
    /// r and theta r at the errors e; returns `r'theta r`.
    #[inline(always)]
    fn at<Row: AsRef<[f64]>, Weight: AsRef<[f64]>>(&mut self, c: &[Row], theta: &[Weight], e: &[Lanes]) -> Lanes {
        let (r, v) = (self.r.as_mut(), self.v.as_ref());
        for i in 0..r.len() {
            let seen = dot(&c[i], e);
            r[i] = lanes(|lane| seen[lane] + v[i][lane]);
        }
        let theta_r = self.theta_r.as_mut();
        for i in 0..theta_r.len() {
            theta_r[i] = dot(&theta[i], self.r.as_ref());
        }
        product(self.theta_r.as_ref(), self.r.as_ref())
    }
}
