//! Observers of uncertain plants: a proved ultimate bound of the error, and the gain that minimises it.
//!
//! `x' = (A + Delta) x + B u + E w`, `y = C x + D w`, where the observer has the nominal A: the error obeys
//! `e' = (A - LC) e + Delta x + ..`, so that it does not tend to 0 unless x does (docs/theory-cubic.md, Robustness).
//! With the bounds `|x_i| <= X_i` of the states, x is a disturbance like any other:
//!
//! - **polytopic**: Delta(t) in the convex hull of deviations `Delta_k`. The disturbances are (x, w), the vertices
//!   `[Delta_k, E]`;
//! - **norm-bounded**: `Delta(t) = M G(t) H`, `|G(t)| <= 1` (spectral norm). `v = G H x` has `|v_i| <= |H x|`, at most
//!   `h = (sum_j (sum_i |H_ji| X_i)^2)^(1/2)`: the disturbances are (v, w), with the one vertex `[M, E]`. For one
//!   column of M this is the S-procedure; for q columns a multiplier for each v_i, of which the bounds are then up to
//!   sqrt(q) too large.
//!
//! The bound is that of [`ErrorBound`]: of least weighted size over P and the rate, for the linear and for the cubic
//! observer, whose cubic term does not enter through x (only noise does).
//!
//! **The optimal gain.** With `Y = PL` the inequalities `[He(PA - YC) + 2 alpha P, P E_k - Y D; *, -diag(lambda)] < 0`,
//! `sum lambda_i W_i^2 <= 2 alpha` are jointly convex in (P, Y, lambda) for a given rate alpha; `trace(T P^-1)` is
//! minimised, and the rate found by a search. Every output needs noise: without noise the bound falls as L grows
//! without end.

use luenberger_linalg::{symmetric_part, zero_order_hold};
use luenberger_lmi::{Problem, block, he, identity, proof_matrix, trace};
use luenberger_observers::LinearObserver;
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector};

use crate::certificate::certified;
use crate::check;
use crate::cubic::CubicDesign;
use crate::error::DesignError;
use crate::error_bound::{DisturbanceBounds, ErrorBound};
use crate::linear::LinearDesign;
use luenberger_proof::certificate::Certificate;
use luenberger_proof::statement::{Deviation, held_plant};
use luenberger_proof::{Interval, Matrix, Ring};

/// How the state matrix of the plant deviates from the nominal one.
#[derive(Debug, Clone, PartialEq)]
pub enum Uncertainty {
    /// By any matrix in the convex hull of these (n x n), perhaps varying in time. The nominal plant need not be among
    /// them.
    Polytope(Vec<DMatrix<f64>>),
    /// By `M G H` with any G of spectral norm 1 at most, M n x q and H r x n.
    NormBounded {
        /// M, n x q.
        m: DMatrix<f64>,
        /// H, r x n.
        h: DMatrix<f64>,
    },
}

impl Uncertainty {
    /// Bounds of `|A(t) - A|`, entry by entry (n x n): of the vertices the largest, of `M G H` the norm of a row of M
    /// times that of a column of H.
    fn entries(&self, n: usize) -> Result<DMatrix<f64>, DesignError> {
        match self {
            Self::Polytope(deviations) => {
                let mut most = DMatrix::zeros(n, n);
                for deviation in deviations {
                    check::matrix("a deviation of A", deviation, (n, n))?;
                    most = most.zip_map(deviation, |most: f64, entry| most.max(entry.abs()));
                }
                Ok(most)
            }
            Self::NormBounded { m, h } => {
                check::matrix("M", m, (n, m.ncols()))?;
                check::matrix("H", h, (h.nrows(), n))?;
                let above = 1.0 + 4.0 * (n + m.ncols() + h.nrows()) as f64 * f64::EPSILON;
                Ok(DMatrix::from_fn(n, n, |i, j| m.row(i).norm() * h.column(j).norm() * above))
            }
        }
    }

    /// How far the plant may be from its sampled form: `x+ = (Ad + dA) x + (Bd + dB) u` for any A(t) within the
    /// uncertainty over each period h, with u held.
    ///
    /// Each term of the series of Peano and Baker of the transition that is not one of `exp(Ah)` has a deviation among
    /// its factors. So `|dA| <= exp((|A| + D)h) - exp(|A|h)`, D the bounds of `|A(t) - A|`, and `|dB|` is at most the
    /// integral of that over the period times |B|. The exponentials are enclosed; the bounds are rounded up, and
    /// contain the rounding of the sampled form itself.
    ///
    /// ```
    /// use luenberger_design::Uncertainty;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x' = -(1 + d) x + u, |d| <= 0.1, every 0.1: exp(-0.11) - exp(-0.1) and more.
    /// let plant = StateSpace::new(dmatrix![-1.0], dmatrix![1.0], dmatrix![1.0])?;
    /// let found = Uncertainty::Polytope(vec![dmatrix![0.1], dmatrix![-0.1]]).sampled(&plant, 0.1)?;
    /// assert!(found.a[(0, 0)] > 0.0091 && found.a[(0, 0)] < 0.0112);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// Shapes that do not fit, a period that is not positive, a plant that grows beyond all numbers within a period.
    pub fn sampled(&self, plant: &StateSpace, h: f64) -> Result<Deviation, DesignError> {
        check::plant(plant)?;
        let n = plant.a.nrows();
        let form = zero_order_hold(&plant.a, &plant.b, h)?;
        let held = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
            let nothing = Matrix::from_fn(n, 0, |_, _| 0.0);
            let held = held_plant((&proof_matrix(a), &proof_matrix(b)), (&nothing, &[]), h)?;
            held.ok_or(DesignError::Exponential { period: h })
        };
        let (a, b) = (plant.a.abs(), plant.b.abs());
        let most = a.zip_map(&self.entries(n)?, |a, most| if most == 0.0 { a } else { (a + most).next_up() });
        let (exact, without, with) = (held(&plant.a, &plant.b)?, held(&a, &b)?, held(&most, &b)?);
        let bound = |[exact, without, with]: [&Matrix<Interval>; 3], form: &DMatrix<f64>| {
            Matrix::from_fn(with.rows(), with.cols(), |i, j| {
                let rounding = Interval::of(exact[(i, j)].sub(&Interval::of(form[(i, j)])).magnitude());
                with[(i, j)].sub(&without[(i, j)]).add(&rounding).hi().max(0.0)
            })
        };
        Ok(Deviation {
            a: bound([&exact.a, &without.a, &with.a], &form.ad),
            b: bound([&exact.b, &without.b, &with.b], &form.bd),
        })
    }
}

/// A bound of the error of an observer of an uncertain plant, with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct UncertainBound {
    /// The bound: `limsup |e_i| <= limsup[i]` while the states keep their bounds.
    pub bound: ErrorBound,
    /// The gain L of the observer, n x p.
    pub l: DMatrix<f64>,
    /// The certificate of the bound.
    pub certificate: Certificate,
}

certified!(UncertainBound);

impl UncertainBound {
    /// The bound of the linear observer, while `|x_i| <= states_i`, under `disturbances` that may be none.
    ///
    /// ```
    /// use luenberger_design::{LinearDesign, Uncertainty, UncertainBound};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{DMatrix, dmatrix};
    ///
    /// // A pendulum whose stiffness is known to 10 %.
    /// let plant = StateSpace::new(dmatrix![0.0, 1.0; -4.0, -0.2], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0])?;
    /// let linear = LinearDesign::with_poles(&plant, &[-4.0, -5.0])?;
    /// let stiffness = Uncertainty::Polytope(vec![dmatrix![0.0, 0.0; -0.4, 0.0], dmatrix![0.0, 0.0; 0.4, 0.0]]);
    /// let found = UncertainBound::linear(&linear, &stiffness, &[1.0, 2.0], None)?;
    /// assert!(found.certificate.is_proved());
    /// // A constant x1 = 1 at the largest deviation leaves 0.4/20 in x1: the bound is not below that.
    /// assert!(found.bound.limsup[0] >= 0.02 && found.bound.limsup[0] < 0.04);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::Matrix`] for shapes that do not fit, [`DesignError::NotPositive`] for bounds that are negative or
    /// all zero, [`DesignError::NoVertices`], and those of [`ErrorBound::polytope`].
    pub fn linear(
        design: &LinearDesign,
        uncertainty: &Uncertainty,
        states: &[f64],
        disturbances: Option<&DisturbanceBounds>,
    ) -> Result<Self, DesignError> {
        let o = &design.observer;
        let forced = Forced::new((&o.a, &o.c), uncertainty, states, disturbances)?;
        Self::of(&forced, (&o.a, &o.l, &o.c), None)
    }

    /// The bound of the cubic observer; otherwise as [`linear`](Self::linear).
    ///
    /// # Errors
    /// As [`linear`](Self::linear).
    pub fn cubic(
        design: &CubicDesign,
        uncertainty: &Uncertainty,
        states: &[f64],
        disturbances: Option<&DisturbanceBounds>,
    ) -> Result<Self, DesignError> {
        let o = &design.observer;
        let forced = Forced::new((&o.a, &o.c), uncertainty, states, disturbances)?;
        Self::of(&forced, (&o.a, &o.l, &o.c), Some((&o.n, &o.theta, &design.p)))
    }

    /// The linear observer with the gain for which the bound is least, in the units of `scale` (n positive numbers).
    ///
    /// Cost: about 15 semidefinite programs of `n(n+1) + np` unknowns, and those of [`linear`](Self::linear).
    /// # Errors
    /// As [`linear`](Self::linear); [`DesignError::NotPositive`] for an output without noise,
    /// [`DesignError::Undecided`] where no program was solved.
    pub fn optimal(
        plant: &StateSpace,
        uncertainty: &Uncertainty,
        states: &[f64],
        disturbances: &DisturbanceBounds,
        scale: &[f64],
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let forced = Forced::new((&plant.a, &plant.c), uncertainty, states, Some(disturbances))?;
        check::matrix("the scale", &DMatrix::from_row_slice(1, scale.len(), scale), (1, plant.a.nrows()))?;
        for unit in scale {
            check::positive("the scale of a state", *unit)?;
        }
        for row in forced.of_all.d.row_iter() {
            let noise: f64 = row.iter().zip(&forced.of_all.bounds).map(|(d, w)| d.abs() * w).sum();
            check::positive("the noise of an output", noise)?;
        }
        let l = forced.best_gain(plant, scale)?;
        Self::of(&forced, (&plant.a, &l, &plant.c), None)
    }

    fn of(
        forced: &Forced,
        (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        cubic: Option<(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)>,
    ) -> Result<Self, DesignError> {
        if let ([e], None) = (&forced.entries[..], cubic) {
            let plant = StateSpace::new(a.clone(), DMatrix::zeros(a.nrows(), 0), c.clone())?;
            let disturbances = DisturbanceBounds { e: e.clone(), ..forced.of_all.clone() };
            let bound = ErrorBound::linear(&LinearObserver::of(plant, l.clone())?, &disturbances)?;
            return Ok(Self { certificate: bound.certificate.clone(), l: l.clone(), bound });
        }
        let vertices: Vec<_> = forced.entries.iter().map(|e| (a.clone(), e.clone())).collect();
        let bound = ErrorBound::polytope(&vertices, (l, c), cubic, &forced.of_all)?;
        Ok(Self { certificate: bound.certificate.clone(), l: l.clone(), bound })
    }
}

/// The uncertain plant as a polytope of disturbed ones.
struct Forced {
    /// `[Delta_k, E]` or `[M, E]`.
    entries: Vec<DMatrix<f64>>,
    /// D and the bounds, those of x or v first.
    of_all: DisturbanceBounds,
}

impl Forced {
    fn new(
        (a, c): (&DMatrix<f64>, &DMatrix<f64>),
        uncertainty: &Uncertainty,
        states: &[f64],
        disturbances: Option<&DisturbanceBounds>,
    ) -> Result<Self, DesignError> {
        let (n, p) = (a.nrows(), c.nrows());
        check::matrix("the bounds of the states", &DMatrix::from_row_slice(1, states.len(), states), (1, n))?;
        if let Some(&value) = states.iter().find(|bound| **bound < 0.0) {
            return Err(DesignError::NotPositive { what: "the bound of a state", value });
        }
        let (forcing, bounds) = match uncertainty {
            Uncertainty::Polytope(deviations) => {
                for deviation in deviations {
                    check::matrix("a deviation of A", deviation, (n, n))?;
                }
                if deviations.is_empty() {
                    return Err(DesignError::NoVertices);
                }
                (deviations.clone(), states.to_vec())
            }
            Uncertainty::NormBounded { m, h } => {
                check::matrix("M", m, (n, m.ncols()))?;
                check::matrix("H", h, (h.nrows(), n))?;
                let largest = (h.abs() * DVector::from_column_slice(states)).norm();
                // Above the exact norm.
                let largest = largest * (1.0 + 4.0 * n as f64 * f64::EPSILON);
                (vec![m.clone()], vec![largest; m.ncols()])
            }
        };
        let none = DisturbanceBounds { e: DMatrix::zeros(n, 0), d: DMatrix::zeros(p, 0), bounds: Vec::new() };
        let disturbances = disturbances.unwrap_or(&none);
        let (first, others) = (bounds.len(), disturbances.bounds.len());
        check::matrix("E", &disturbances.e, (n, others))?;
        check::matrix("D", &disturbances.d, (p, others))?;
        let beside =
            |left: &DMatrix<f64>, right: &DMatrix<f64>| {
                DMatrix::from_fn(left.nrows(), first + others, |i, j| {
                    if j < first { left[(i, j)] } else { right[(i, j - first)] }
                })
            };
        let entries: Vec<_> = forcing.iter().map(|left| beside(left, &disturbances.e)).collect();
        let of_all = DisturbanceBounds {
            e: entries[0].clone(),
            d: beside(&DMatrix::zeros(p, first), &disturbances.d),
            bounds: bounds.iter().chain(&disturbances.bounds).copied().collect(),
        };
        Ok(Self { entries, of_all })
    }

    /// L for the least trace of `P^-1` in the units of `scale`, over P and the rate.
    fn best_gain(&self, plant: &StateSpace, scale: &[f64]) -> Result<DMatrix<f64>, DesignError> {
        let mut best: Option<(f64, DMatrix<f64>)> = None;
        let mut last = None;
        let mut cost = |rate: f64| match self.program(plant, rate, scale) {
            Ok((cost, l)) => {
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, l));
                }
                cost
            }
            Err(error) => {
                last = Some(error);
                f64::INFINITY
            }
        };
        // Rates of the plant's own time scale, each a factor from the next, then around the best.
        let unit = plant.a.norm().max(f64::MIN_POSITIVE);
        let rates: Vec<f64> = (-4..=4).map(|k| unit * 2.0_f64.powi(k)).collect();
        let costs: Vec<f64> = rates.iter().map(|rate| cost(*rate)).collect();
        let at = (0..rates.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
        for share in [0.7, 0.85, 1.2, 1.4] {
            cost(share * rates[at]);
        }
        match (best, last) {
            (Some((_, l)), _) => Ok(l),
            (None, Some(error)) => Err(error),
            (None, None) => Err(DesignError::NoVertices),
        }
    }

    fn program(&self, plant: &StateSpace, rate: f64, scale: &[f64]) -> Result<(f64, DMatrix<f64>), DesignError> {
        let (n, p, m) = (plant.a.nrows(), plant.c.nrows(), self.of_all.bounds.len());
        let scale = DVector::from_column_slice(scale);
        let (units, inverse) = (DMatrix::from_diagonal(&scale), DMatrix::from_diagonal(&scale.map(f64::recip)));
        let weights = DMatrix::from_diagonal(&DVector::from_column_slice(&self.of_all.bounds));
        let (a, c) = (&inverse * &plant.a * &units, &plant.c * &units);
        let mut lmi = Problem::new();
        let (metric, y) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, p));
        let (lambda, z) = (lmi.diagonal("lambda", m), lmi.symmetric("Z", n));
        for (k, e) in self.entries.iter().enumerate() {
            let corner = &metric * (&inverse * e * &weights) - &y * (&self.of_all.d * &weights);
            let first = he(&metric * &a - &y * &c) + (2.0 * rate) * &metric;
            let whole = block![[first, corner.clone()], [corner.transpose(), -&lambda]];
            lmi.constrain(&format!("decrease at vertex {}", k + 1), whole << 0.0);
        }
        lmi.constrain("level", trace(&lambda) << (2.0 * rate));
        lmi.constrain("P^-1 < Z", block![[metric.clone(), identity(n)], [identity(n), z.clone()]] >> 0.0);
        lmi.minimise(trace(&z));
        let solution = lmi.solve()?;
        if !solution.verdict.is_proved() {
            return Err(DesignError::not_proved(WHAT, Some(solution.verdict)));
        }
        let named = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
        let gain = check::solve_definite("P", &symmetric_part(&named("P")), &named("Y"))?;
        Ok((named("Z").trace(), &units * gain))
    }
}

const WHAT: &str = "a gain with a bound of the error, [He(PA - YC) + 2 rate P, PE - YD; *, -diag(lambda)] < 0,";
