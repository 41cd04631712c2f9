//! Unknown-input observers: an estimate that does not depend on an unknown, arbitrary disturbance.
//!
//! `x' = A x + B u + E d`, `y = C x`. If `rank(CE) = rank(E) = q`, then `H = E((CE)'CE)^-1(CE)'` and `T = I - HC` give
//! `TE = 0`, and a linear or a cubic observer of the pair (TA, C) has the error equation of [`UnknownInputObserver`].
//! The pair is detectable iff all invariant zeros of (A, E, C) are in the open left half plane (strong detectability;
//! M. Darouach, M. Zasadzinski and S. J. Xu, IEEE Transactions on Automatic Control 39, 1994). The rank condition is
//! decided without rounding, and convergence is proved for the real T:
//! `proof/src/certificate/theorem/unknown_input.rs`.

use luenberger_linalg::{RealMatrixView, invariant_zeros, kalman_decomposition, place_observer, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{CubicObserver, LinearObserver, UnknownInputObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Certificate, StoredCubicTerm, UnknownInputConvergence};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant};
use crate::check;
use crate::cubic::{CubicDesign, radial_s};
use crate::error::{DesignError, Pair};
use crate::linear::{LinearDesign, LyapunovWeight};
use crate::lyapunov_choice::proved_or_first;
use crate::proportional_integral::{exact_product, has_full_column_rank, least_seen};

/// The plant that remains when the unknown input is decoupled: (TA, TB, C), with the H of the estimate.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct DecoupledPlant {
    /// The plant itself.
    pub plant: StateSpace,
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// H, n x p, rounded.
    pub h: DMatrix<f64>,
    /// (TA, TB, C), rounded: the plant for which L and N are designed.
    pub reduced: StateSpace,
    /// The invariant zeros of (A, E, C), which every unknown-input observer has among its poles.
    pub zeros: Vec<Complex<f64>>,
}

impl DecoupledPlant {
    /// Decouples `d` of `x' = A x + B u + E d`.
    ///
    /// # Errors
    /// [`DesignError::UnmatchedDisturbance`] where `rank(CE) < rank(E)`, or E has dependent columns, with the
    /// direction; [`DesignError::UnstableZero`] where (A, E, C) is not strongly detectable.
    pub fn new<'a>(of: &StateSpace, e: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        Self::of(of, check::owned(e))
    }

    fn of(of: &StateSpace, e: DMatrix<f64>) -> Result<Self, DesignError> {
        check::plant(of)?;
        let (n, p, q) = (of.a.nrows(), of.c.nrows(), e.ncols());
        check::matrix("E", &e, (n, q))?;
        let image = &of.c * &e;
        if has_full_column_rank(&exact_product(&of.c, &e)?)? == Some(false) {
            let (d, _) = least_seen(&image);
            let column = nalgebra::DVector::from_column_slice(&d);
            let (seen, acting) = ((&image * &column).norm(), (&e * &column).norm());
            return Err(DesignError::UnmatchedDisturbance { d, seen, acting, outputs: p });
        }
        let gram = symmetric_part(&(image.transpose() * &image));
        let h = &e * check::solve_definite("(CE)'CE", &gram, &image.transpose())?;
        let found = invariant_zeros(&of.a, &e, &of.c, &DMatrix::zeros(p, q))?;
        if let Some(zero) = found.zeros.iter().filter(|zero| zero.re >= 0.0).max_by(|a, b| a.re.total_cmp(&b.re)) {
            return Err(DesignError::UnstableZero { zero: *zero });
        }
        let t = DMatrix::identity(n, n) - &h * &of.c;
        // Where T removes a state, what is left of its row is rounding, and no unit for a gain.
        let size = DMatrix::identity(n, n) + h.abs() * of.c.abs();
        let product = |m: &DMatrix<f64>| {
            let (product, scale) = (&t * m, &size * m.abs());
            let rounding = 16.0 * n as f64 * f64::EPSILON;
            product.zip_map(&scale, |x, scale| if x.abs() <= rounding * scale { 0.0 } else { x })
        };
        let reduced = StateSpace::new(product(&of.a), product(&of.b), of.c.clone())?;
        let reduced = match &of.d {
            Some(d) => reduced.with_feedthrough(d.clone())?,
            None => reduced,
        };
        Ok(Self { plant: of.clone(), e, h, reduced, zeros: found.zeros })
    }

    /// The linear design with these poles for the reduced plant: n of them, real or complex, closed under conjugation.
    ///
    /// The invariant zeros of (A, E, C) that no gain moves have to be among them, each to six digits; the others are
    /// placed in the observable part of (TA, C).
    ///
    /// ```
    /// use luenberger_design::DecoupledPlant;
    /// use luenberger_linalg::eigenvalues;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    ///
    /// let plant = StateSpace::new(dmatrix![0.0, 1.0; -1.0, -2.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    /// let decoupled = DecoupledPlant::new(&plant, &dmatrix![1.0; 0.0])?;
    /// // The zero -2 of (A, E, C) stays; the other pole is free.
    /// let design = decoupled.with_poles(&[-2.0, -5.0])?;
    /// let poles = eigenvalues(&(&decoupled.reduced.a - design.l() * &decoupled.reduced.c))?;
    /// let residual = poles.iter().map(|pole| ((pole + 2.0) * (pole + 5.0)).norm()).fold(0.0, f64::max);
    /// assert!(residual < 1e-13);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::FixedPoles`] with the zeros, if one of them is not among the poles; the errors of
    /// [`LinearDesign::with_poles`].
    pub fn with_poles(&self, poles: &[impl Into<Complex<f64>> + Copy]) -> Result<LinearDesign, DesignError> {
        self.with_poles_and_weight(poles, LyapunovWeight::FirstProved)
    }

    /// The same, certified by the Lyapunov equation with this right-hand side.
    ///
    /// # Errors
    /// As [`with_poles`](Self::with_poles) and [`LinearDesign::with_poles_and_weight`].
    pub fn with_poles_and_weight(
        &self,
        poles: &[impl Into<Complex<f64>> + Copy],
        weight: LyapunovWeight,
    ) -> Result<LinearDesign, DesignError> {
        let mut poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        let StateSpace { a, c, .. } = &self.reduced;
        let n = a.nrows();
        let parts = kalman_decomposition(a, &DMatrix::identity(n, n), c)?;
        let fixed = &parts.controllable_unobservable.eigenvalues;
        if fixed.is_empty() || poles.len() != n {
            let design = LinearDesign::with_poles_and_weight(&self.reduced, &poles, weight);
            return design.map_err(|error| error.of_pair(Pair::Decoupled));
        }
        for zero in fixed {
            let nearest = (0..poles.len())
                .min_by(|i, j| (poles[*i] - zero).norm().total_cmp(&(poles[*j] - zero).norm()))
                .filter(|k| (poles[*k] - zero).norm() <= 1e-6 * (1.0 + zero.norm()));
            let Some(nearest) = nearest else { return Err(DesignError::FixedPoles { zeros: fixed.clone() }) };
            poles.swap_remove(nearest);
        }
        let k = parts.controllable_observable.order;
        let mut gain = DMatrix::zeros(n, c.nrows());
        if k > 0 {
            let (seen, outputs) = (parts.a.view((0, 0), (k, k)).into_owned(), parts.c.columns(0, k).into_owned());
            let placed = place_observer(&seen, &outputs, &poles).map_err(DesignError::from);
            gain.rows_mut(0, k).copy_from(&placed.map_err(|error| error.of_pair(Pair::Decoupled))?.gain);
        }
        LinearDesign::with_gain_and_weight(&self.reduced, &(&parts.transformation * gain), weight)
    }

    /// The theorem for these gains and this Lyapunov matrix, with the real T.
    fn theorem(
        &self,
        (l, p, rate): (&DMatrix<f64>, &DMatrix<f64>, f64),
        cubic: Option<StoredCubicTerm>,
    ) -> Result<Certificate, DesignError> {
        let StateSpace { a, b, c, .. } = &self.plant;
        let theorem = UnknownInputConvergence {
            plant: plant((a, b, c)),
            e: proof_matrix(&self.e),
            l: proof_matrix(l),
            cubic,
            p: proof_matrix(p),
            rate,
        };
        Ok(Certificate::of([theorem])?)
    }
}

certified!(
    UnknownInputDesign<LinearObserver<f64, Dyn, Dyn, Dyn>>,
    UnknownInputDesign<CubicObserver<f64, Dyn, Dyn, Dyn>>
);

/// An unknown-input observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct UnknownInputDesign<O> {
    /// The observer, ready to run.
    pub observer: UnknownInputObserver<O, f64, Dyn, Dyn, Dyn>,
    /// The certificate.
    pub certificate: Certificate,
}

impl UnknownInputDesign<LinearObserver<f64, Dyn, Dyn, Dyn>> {
    /// The observer with the gain of a linear design for the [`reduced`](DecoupledPlant::reduced) plant.
    ///
    /// ```
    /// use luenberger_design::{Certified, DecoupledPlant, LinearDesign, UnknownInputDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x1' = x2 + d, x2' = -x1 - 2 x2, y = x1: the zero of (A, E, C) is -2.
    /// let plant = StateSpace::new(dmatrix![0.0, 1.0; -1.0, -2.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    /// let decoupled = DecoupledPlant::new(&plant, &dmatrix![1.0; 0.0])?;
    /// let linear = LinearDesign::lmi(&decoupled.reduced)?;
    /// assert!(UnknownInputDesign::linear(&decoupled, &linear)?.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::Observer`] and [`DesignError::Proof`] for a design of another plant.
    pub fn linear(of: &DecoupledPlant, design: &LinearDesign) -> Result<Self, DesignError> {
        let observer = UnknownInputObserver::new(design.observer.clone(), of.h.clone(), of.plant.d.clone())?;
        // The design proves its P for the T in double precision.
        let f = check::closed_loop((&of.reduced.a, design.l(), &of.reduced.c))?;
        let (_, certificate) = proved_or_first(TimeDomain::Continuous, &f, Ok(design.p.clone()), |p| {
            of.theorem((design.l(), p, design.rate), None)
        })?;
        Ok(Self { observer, certificate })
    }

    /// The observer gain L of the reduced plant, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.inner().l()
    }
}

impl UnknownInputDesign<CubicObserver<f64, Dyn, Dyn, Dyn>> {
    /// The observer with the gains of a cubic design for the [`reduced`](DecoupledPlant::reduced) plant.
    ///
    /// # Errors
    /// As [`linear`](UnknownInputDesign::linear).
    pub fn cubic(of: &DecoupledPlant, design: &CubicDesign) -> Result<Self, DesignError> {
        let o = &design.observer;
        let observer = UnknownInputObserver::new(o.clone(), of.h.clone(), of.plant.d.clone())?;
        let p_inverse_ct = check::solve_definite("P", &design.p, &o.c.transpose())?;
        let x = radial_s(&o.c, &p_inverse_ct, 1.0)?;
        let term = StoredCubicTerm {
            n: proof_matrix(&o.n),
            theta: proof_matrix(&o.theta),
            x: proof_matrix(&symmetric_part(&x)),
        };
        let certificate = of.theorem((&o.l, &design.p, design.rate), Some(term))?;
        Ok(Self { observer, certificate })
    }

    /// The observer gain L of the reduced plant, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.inner().l()
    }
}
