//! Unknown-input observers: an estimate that does not depend on an unknown, arbitrary disturbance.
//!
//! `x' = A x + B u + E d`, `y = C x`. If `rank(CE) = rank(E) = q`, then `H = E((CE)'CE)^-1(CE)'` and `T = I - HC` give
//! `TE = 0`, and a linear or a cubic observer of the pair (TA, C) has the error equation of [`UnknownInputObserver`].
//! The pair is detectable iff all invariant zeros of (A, E, C) are in the open left half plane (strong detectability;
//! M. Darouach, M. Zasadzinski and S. J. Xu, IEEE Transactions on Automatic Control 39, 1994). The rank condition is
//! decided without rounding, and convergence is proved for the real T:
//! `proof/src/certificate/theorem/unknown_input.rs`.
//!
//! If d enters the outputs as well, `y = C x + F d`, or the plant is in discrete time, the observer is
//! `z' = T A xhat + T B u + J (y - C xhat)`, or z+, with `H F = 0` and `T E = J F`. With `S = [C E, F1; F, 0]`, F1 the
//! columns of F that are not 0, `[H G] = [E - L F, 0] S^+` and `J = L + G` satisfy both for every L, and the error has
//! the matrix `A0 - L C0`, `A0 = A - [E 0] S^+ [C A; C]`, `C0 = C - [F 0] S^+ [C A; C]`: L is a gain of the pair
//! (A0, C0), which is detectable iff (A, E, C, F) is strongly detectable
//! (`proof/src/certificate/theorem/decoupling.rs`).

use luenberger_linalg::{RealMatrixView, invariant_zeros, kalman_decomposition, place_observer, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{CubicObserver, LinearObserver, UnknownInputObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::Matrix;
use luenberger_proof::certificate::{Certificate, DecouplingConvergence, StoredCubicTerm, UnknownInputConvergence};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant};
use crate::check;
use crate::cubic::{CubicDesign, radial_s};
use crate::discrete::DiscreteDesign;
use crate::error::{DesignError, Pair};
use crate::linear::{LinearDesign, LyapunovWeight};
use crate::lyapunov_choice::proved_or_first;

/// z, H and the observer of the reduced pair, of which xhat = z + H y.
type DecouplingObserver = UnknownInputObserver<LinearObserver<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn>;
use crate::proportional_integral::{exact_product, has_full_column_rank, least_seen};

/// The plant that remains when the unknown input is decoupled: (TA, TB, C), with the H of the estimate.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct DecoupledPlant {
    /// The plant itself.
    pub plant: StateSpace,
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// F, p x q: d enters the outputs as `y = C x + D u + F d`.
    pub f: DMatrix<f64>,
    /// The time of the plant.
    pub time: TimeDomain,
    /// H, n x p, rounded; with F that for L = 0.
    pub h: DMatrix<f64>,
    /// (TA, TB, C), with F (A0, TB, C0), rounded: the plant for which L and N are designed.
    pub reduced: StateSpace,
    /// The invariant zeros of (A, E, C, F), which every unknown-input observer has among its poles.
    pub zeros: Vec<Complex<f64>>,
    /// `S^+` where F is not 0, (q + f) x 2p.
    inverse: Option<DMatrix<f64>>,
}

impl DecoupledPlant {
    /// Decouples `d` of `x' = A x + B u + E d`.
    ///
    /// # Errors
    /// [`DesignError::UnmatchedDisturbance`] where `rank(CE) < rank(E)`, or E has dependent columns, with the
    /// direction; [`DesignError::UnstableZero`] where (A, E, C) is not strongly detectable.
    pub fn new<'a>(of: &StateSpace, e: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        let e = check::owned(e);
        let f = DMatrix::zeros(of.c.nrows(), e.ncols());
        Self::of(of, e, f, TimeDomain::Continuous)
    }

    /// Decouples `d` of `x' = A x + B u + E d`, `y = C x + D u + F d`, or of `x+ = ..` in discrete time.
    ///
    /// F is p x q; its columns that are not 0 have to be independent. It may be 0.
    ///
    /// ```
    /// use luenberger_design::{DecoupledPlant, LinearDesign, TimeDomain, UnknownInputDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x' = a x + d, y = x + d: x' = (a - 1) x + y, and a - 1 is the zero of (A, E, C, F).
    /// let (b, one) = (dmatrix![0.0], dmatrix![1.0]);
    /// let plant = |a: f64| StateSpace::new(dmatrix![a], b.clone(), one.clone());
    /// assert!(DecoupledPlant::of_outputs(&plant(2.0)?, &one, &one, TimeDomain::Continuous).is_err());
    /// let decoupled = DecoupledPlant::of_outputs(&plant(-1.0)?, &one, &one, TimeDomain::Continuous)?;
    /// assert!((decoupled.zeros[0] + 2.0).norm() < 1e-14);
    /// let design = UnknownInputDesign::linear(&decoupled, &LinearDesign::lmi(&decoupled.reduced)?)?;
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new); [`DesignError::UnmatchedInOutputs`] where S does not have full column rank, which for
    /// independent columns of F is `rank [C E, F; F, 0] < q + rank(F)`.
    pub fn of_outputs<'a>(
        of: &StateSpace,
        e: impl Into<RealMatrixView<'a>>,
        f: impl Into<RealMatrixView<'a>>,
        time: TimeDomain,
    ) -> Result<Self, DesignError> {
        Self::of(of, check::owned(e), check::owned(f), time)
    }

    fn of(of: &StateSpace, e: DMatrix<f64>, f: DMatrix<f64>, time: TimeDomain) -> Result<Self, DesignError> {
        check::plant(of)?;
        let (n, p, q) = (of.a.nrows(), of.c.nrows(), e.ncols());
        check::matrix("E", &e, (n, q))?;
        check::matrix("F", &f, (p, q))?;
        let is_fed = f.amax() > 0.0;
        let (h, inverse) = if is_fed {
            let inverse = with_outputs(&of.c, &e, &f)?;
            (&e * inverse.view((0, 0), (q, p)), Some(inverse))
        } else {
            (of_states(&of.c, &e)?, None)
        };
        let found = invariant_zeros(&of.a, &e, &of.c, &f)?;
        let excess = |zero: &Complex<f64>| match time {
            TimeDomain::Continuous => zero.re,
            TimeDomain::Discrete => zero.norm() - 1.0,
        };
        let worst = found.zeros.iter().filter(|zero| excess(zero) >= 0.0);
        if let Some(zero) = worst.max_by(|a, b| excess(a).total_cmp(&excess(b))) {
            return Err(DesignError::UnstableZero { zero: *zero, time, is_fed });
        }
        let t = DMatrix::identity(n, n) - &h * &of.c;
        // Where T removes a state, what is left of its row is rounding, and no unit for a gain.
        let size = DMatrix::identity(n, n) + h.abs() * of.c.abs();
        let rounding = 16.0 * n as f64 * f64::EPSILON;
        let cleaned = |m: DMatrix<f64>, scale: DMatrix<f64>| {
            m.zip_map(&scale, |x, scale| if x.abs() <= rounding * scale { 0.0 } else { x })
        };
        let product = |m: &DMatrix<f64>| cleaned(&t * m, &size * m.abs());
        let (a, c) = match &inverse {
            None => (product(&of.a), of.c.clone()),
            Some(inverse) => {
                let rates = stacked(&(&of.c * &of.a), &of.c);
                let known = inverse.rows(0, q) * &rates;
                let scale = inverse.rows(0, q).abs() * stacked(&(of.c.abs() * of.a.abs()), &of.c.abs());
                let without =
                    |m: &DMatrix<f64>, by: &DMatrix<f64>| cleaned(m - by * &known, m.abs() + by.abs() * &scale);
                (without(&of.a, &e), without(&of.c, &f))
            }
        };
        let reduced = StateSpace::new(a, product(&of.b), c)?;
        let reduced = match &of.d {
            Some(d) => reduced.with_feedthrough(d.clone())?,
            None => reduced,
        };
        Ok(Self { plant: of.clone(), e, f, time, h, reduced, zeros: found.zeros, inverse })
    }

    /// L without the part that acts on no output of the pair that is left: of it a program knows no size, and in J it
    /// cancels. `l'(I - S S^+) = 0` in the rows of the outputs iff `l'W l = 0` for the block W of the projector there.
    fn acting(&self, l: &DMatrix<f64>) -> DMatrix<f64> {
        let Some(inverse) = &self.inverse else { return l.clone() };
        let (p, q) = self.f.shape();
        let w = DMatrix::identity(p, p) - &self.f * inverse.view((0, p), (q, p));
        let eigen = symmetric_part(&w).symmetric_eigen();
        let floor = 16.0 * p as f64 * f64::EPSILON * (1.0 + self.f.norm() * inverse.norm());
        let kept = DMatrix::from_diagonal(&eigen.eigenvalues.map(|x| if x > floor { 1.0 } else { 0.0 }));
        l * (&eigen.eigenvectors * kept * eigen.eigenvectors.transpose())
    }

    /// `[H J]` for this L, n x 2p.
    fn injections(&self, l: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let (p, q) = (self.plant.c.nrows(), self.e.ncols());
        match &self.inverse {
            None => (self.h.clone(), l.clone()),
            Some(inverse) => {
                let both = (&self.e - l * &self.f) * inverse.rows(0, q);
                (both.columns(0, p).into_owned(), l + both.columns(p, p))
            }
        }
    }

    /// The observer of the plant with this L: the equations in both times.
    fn observer(&self, l: &DMatrix<f64>) -> Result<DecouplingObserver, DesignError> {
        let (h, j) = self.injections(l);
        let StateSpace { a, b, c, d } = &self.plant;
        let n = a.nrows();
        let (a, b) = if self.inverse.is_none() {
            (self.reduced.a.clone(), self.reduced.b.clone())
        } else {
            let t = DMatrix::identity(n, n) - &h * c;
            (&t * a, &t * b)
        };
        let inner = LinearObserver { a, b, c: c.clone(), d: d.clone(), l: j };
        Ok(UnknownInputObserver::new(inner, h, d.clone())?)
    }

    /// The linear design with these poles for the reduced plant: n of them, real or complex, closed under conjugation.
    ///
    /// The invariant zeros of (A, E, C) that no gain moves have to be among them, each to 1e-6 of the largest of all
    /// poles and zeros; the others are placed in the observable part of (TA, C).
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
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(gain) = self.gain_with(poles.clone())? {
            return LinearDesign::with_gain_and_weight(&self.reduced, &gain, weight);
        }
        let design = LinearDesign::with_poles_and_weight(&self.reduced, &poles, weight);
        design.map_err(|error| error.of_pair(Pair::Decoupled))
    }

    /// The same in discrete time, for the sampling period.
    ///
    /// # Errors
    /// As [`with_poles`](Self::with_poles) and [`DiscreteDesign::with_poles`].
    pub fn with_poles_in_discrete_time(
        &self,
        period: f64,
        poles: &[impl Into<Complex<f64>> + Copy],
    ) -> Result<DiscreteDesign, DesignError> {
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(gain) = self.gain_with(poles.clone())? {
            return DiscreteDesign::with_gain(&self.reduced, period, &gain);
        }
        let design = DiscreteDesign::with_poles(&self.reduced, period, &poles);
        design.map_err(|error| error.of_pair(Pair::Decoupled))
    }

    /// The gain with these poles, where zeros are fixed among them.
    fn gain_with(&self, mut poles: Vec<Complex<f64>>) -> Result<Option<DMatrix<f64>>, DesignError> {
        let StateSpace { a, c, .. } = &self.reduced;
        let n = a.nrows();
        let parts = kalman_decomposition(a, &DMatrix::identity(n, n), c)?;
        let fixed = &parts.controllable_unobservable.eigenvalues;
        if fixed.is_empty() || poles.len() != n {
            return Ok(None);
        }
        // In units of the poles and zeros themselves, whatever the unit of time is.
        let size = poles.iter().chain(fixed).map(|pole| pole.norm()).fold(0.0, f64::max);
        for zero in fixed {
            let nearest = (0..poles.len())
                .min_by(|i, j| (poles[*i] - zero).norm().total_cmp(&(poles[*j] - zero).norm()))
                .filter(|k| (poles[*k] - zero).norm() <= 1e-6 * size);
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
        Ok(Some(&parts.transformation * gain))
    }

    /// The theorem for these gains and this Lyapunov matrix, with the real T.
    fn theorem(
        &self,
        (l, p, rate): (&DMatrix<f64>, &DMatrix<f64>, f64),
        cubic: Option<StoredCubicTerm>,
    ) -> Result<Certificate, DesignError> {
        let StateSpace { a, b, c, .. } = &self.plant;
        let (plant, e, l, p) = (plant((a, b, c)), proof_matrix(&self.e), proof_matrix(l), proof_matrix(p));
        if self.inverse.is_some() || self.time == TimeDomain::Discrete {
            let f = proof_matrix(&self.f);
            return Ok(Certificate::of([DecouplingConvergence { time: self.time, plant, e, f, l, p }])?);
        }
        Ok(Certificate::of([UnknownInputConvergence { plant, e, l, cubic, p, rate }])?)
    }

    /// The observer with the gain L of the reduced plant, and its certificate with P or one that is proved.
    fn certified(
        &self,
        (l, p, rate): (&DMatrix<f64>, &DMatrix<f64>, f64),
    ) -> Result<UnknownInputDesign<LinearObserver<f64, Dyn, Dyn, Dyn>>, DesignError> {
        let l = &self.acting(l);
        let observer = self.observer(l)?;
        // The design proves its P for the T in double precision.
        let f = check::closed_loop((&self.reduced.a, l, &self.reduced.c))?;
        let (_, certificate) = proved_or_first(self.time, &f, Ok(p.clone()), |p| self.theorem((l, p, rate), None))?;
        Ok(UnknownInputDesign { observer, gain: l.clone(), certificate })
    }
}

/// `H = E((CE)'CE)^-1(CE)'`, for which C E has to have full column rank, decided exactly.
fn of_states(c: &DMatrix<f64>, e: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    let (image, outputs) = (c * e, c.nrows());
    if has_full_column_rank(&exact_product(c, e)?)? == Some(false) {
        let (d, _) = least_seen(&image);
        let column = nalgebra::DVector::from_column_slice(&d);
        let (seen, acting) = ((&image * &column).norm(), (e * &column).norm());
        return Err(DesignError::UnmatchedDisturbance { d, seen, acting, outputs });
    }
    let gram = symmetric_part(&(image.transpose() * &image));
    Ok(e * check::solve_definite("(CE)'CE", &gram, &image.transpose())?)
}

/// `S^+` of `S = [C E, F1; F, 0]`, whose full column rank is decided exactly.
fn with_outputs(c: &DMatrix<f64>, e: &DMatrix<f64>, f: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    let (p, q) = f.shape();
    let fed: Vec<usize> = (0..q).filter(|j| f.column(*j).amax() > 0.0).collect();
    let columns = q + fed.len();
    let seen = exact_product(c, e)?;
    let zero = exact_product(&DMatrix::zeros(1, 1), &DMatrix::zeros(1, 1))?;
    let given = exact_product(&DMatrix::identity(p, p), f)?;
    let exact = Matrix::from_fn(2 * p, columns, |i, j| match (i < p, j < q) {
        (true, true) => seen[(i, j)].clone(),
        (true, false) => given[(i, fed[j - q])].clone(),
        (false, true) => given[(i - p, j)].clone(),
        (false, false) => zero[(0, 0)].clone(),
    });
    let image = c * e;
    let s = DMatrix::from_fn(2 * p, columns, |i, j| match (i < p, j < q) {
        (true, true) => image[(i, j)],
        (true, false) => f[(i, fed[j - q])],
        (false, true) => f[(i - p, j)],
        (false, false) => 0.0,
    });
    let found = if has_full_column_rank(&exact)? == Some(false) { None } else { left_inverse(&s) };
    found.ok_or_else(|| {
        let (mut d, sigma_min) = least_seen(&s);
        d.truncate(q);
        DesignError::UnmatchedInOutputs { d, fed: fed.len(), sigma_min }
    })
}

/// A left inverse `S^+ S = I`, for S of full column rank whose rows have units of their own, so that in some of them
/// S'S is singular to working precision; none where R is. Householder reflections with the larger rows first and
/// pivoted columns have errors that are small in each row (A. J. Cox and N. J. Higham, Stability of Householder QR
/// factorization for weighted least squares problems, 1998).
pub fn left_inverse(s: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut order: Vec<usize> = (0..s.nrows()).collect();
    order.sort_by(|i, j| s.row(*j).amax().total_cmp(&s.row(*i).amax()));
    let (q, r, columns) = s.select_rows(&order).col_piv_qr().unpack();
    let mut sorted = r.solve_upper_triangular(&q.transpose())?;
    columns.inv_permute_rows(&mut sorted);
    let mut inverse = DMatrix::zeros(s.ncols(), s.nrows());
    for (k, &row) in order.iter().enumerate() {
        inverse.set_column(row, &sorted.column(k));
    }
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

/// One matrix above the other.
fn stacked(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let rows = above.nrows();
    DMatrix::from_fn(
        rows + below.nrows(),
        above.ncols(),
        |i, j| {
            if i < rows { above[(i, j)] } else { below[(i - rows, j)] }
        },
    )
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
    /// The gain L of the reduced plant, n x p, that of the certificate.
    pub gain: DMatrix<f64>,
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
        of.certified((design.l(), &design.p, design.rate))
    }

    /// The same of a plant in discrete time: the equations of the observer have z+ in the place of z'.
    ///
    /// ```
    /// use luenberger_design::{DecoupledPlant, DiscreteDesign, TimeDomain, UnknownInputDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x1+ = x2 + d, x2+ = x2/2, y = x1: the zero of (A, E, C) is 1/2, the other pole is free.
    /// let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.5], dmatrix![0.0; 0.0], dmatrix![1.0, 0.0])?;
    /// let (e, f) = (dmatrix![1.0; 0.0], dmatrix![0.0]);
    /// let decoupled = DecoupledPlant::of_outputs(&plant, &e, &f, TimeDomain::Discrete)?;
    /// let design = decoupled.with_poles_in_discrete_time(0.1, &[0.5, 0.25])?;
    /// assert!(UnknownInputDesign::discrete(&decoupled, &design)?.certificate.is_proved());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`linear`](Self::linear).
    pub fn discrete(of: &DecoupledPlant, design: &DiscreteDesign) -> Result<Self, DesignError> {
        of.certified((design.l(), &design.p, 0.0))
    }

    /// J, n x p: the observer gain L of the reduced plant where the unknown input does not enter the outputs.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.inner().l()
    }
}

impl UnknownInputDesign<CubicObserver<f64, Dyn, Dyn, Dyn>> {
    /// The observer with the gains of a cubic design for the [`reduced`](DecoupledPlant::reduced) plant, in continuous
    /// time, of an unknown input that does not enter the outputs.
    ///
    /// # Errors
    /// As [`linear`](UnknownInputDesign::linear); [`DesignError::CubicOfOutputs`] for another one.
    pub fn cubic(of: &DecoupledPlant, design: &CubicDesign) -> Result<Self, DesignError> {
        if of.inverse.is_some() || of.time == TimeDomain::Discrete {
            return Err(DesignError::CubicOfOutputs);
        }
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
        Ok(Self { observer, gain: o.l.clone(), certificate })
    }

    /// The observer gain L of the reduced plant, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.inner().l()
    }
}
