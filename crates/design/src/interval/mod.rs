//! Interval observers: bounds that enclose the state of a linear plant under bounded disturbances and noise.
//!
//! `x' = A x + B u + E w`, `y = C x + D w`, `|w_j| <= W_j`, and x(0) in a box. The estimate is that of a linear
//! observer; the bounds are those of its error in coordinates `z = T e`: the theorem is at the head of
//! `proof/src/statement/interval_observer.rs`, and here its numbers are chosen.
//!
//! | coordinates | T | blocks |
//! |---|---|---|
//! | modal | the inverse of the real eigenvectors of A - LC | one entry for a real pole, two for a complex pair |
//! | of the plant | the identity | one entry each: K is A - LC where that is Metzler, else the matrix above it |
//!
//! Modal coordinates exist for distinct poles, and then K is diagonal up to rounding. In those of the plant the gain
//! can be chosen for the least width, by a linear program: see [`least_width_gain`].

mod gain;
mod sampled;

pub use gain::least_width_gain;
pub use sampled::{IntervalRequirements, SampledIntervalDesign};

use luenberger_linalg::spectral_abscissa;
use luenberger_lmi::{dynamic_matrix, proof_matrix};
use luenberger_observers::{ComparisonSystem, IntervalObserver, LinearObserver};
use luenberger_proof::certificate::{Certificate, IntervalCoordinates, IntervalEnclosure};
use luenberger_proof::statement::{BlockCoordinates, TimeDomain};
use luenberger_proof::{Interval, Matrix, Ring};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;
use crate::error_bound::DisturbanceBounds;
use crate::lyapunov_choice::coordinates;
use crate::modal;

/// Coordinates in which the error is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCoordinates {
    /// Those of the eigenvectors of A - LC, which needs distinct poles.
    Modal,
    /// The states themselves.
    Plant,
}

certified!(IntervalDesign);

/// An interval observer in continuous time with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct IntervalDesign {
    /// The observer, ready to run.
    pub observer: IntervalObserver<LinearObserver<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn>,
    /// T, n x n.
    pub t: DMatrix<f64>,
    /// The numbers of entries of its blocks.
    pub blocks: Vec<usize>,
    /// The rate at which rho approaches its limit.
    pub rate: f64,
    /// The half-widths of the bounds for t to infinity, n entries.
    pub widths: Vec<f64>,
    /// The certificate.
    pub certificate: Certificate,
}

impl IntervalDesign {
    /// The interval observer with the gain of `observer`, for disturbances within their bounds and `|x_i(0) -
    /// xhat_i(0)| <= first_i`.
    ///
    /// ```
    /// use luenberger_design::{Certified, DisturbanceBounds, ErrorCoordinates, IntervalDesign, LinearDesign};
    /// use nalgebra::dmatrix;
    /// // A double integrator with an unknown force up to 0.1 and noise up to 0.01.
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles(&plant, &[-2.0, -3.0])?;
    /// let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.1], &[0.01]);
    /// let design = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Modal, &[1.0, 1.0])?;
    /// assert!(design.certificate.is_proved());
    /// // By hand: rho ends at 0.14/2 and 0.19/3 for T = [-2 1; 3 -1], the bounds at 2/15 and 0.21 + 2 0.19/3.
    /// assert!((design.widths[0] - 0.13333).abs() < 1e-5 && (design.widths[1] - 0.33667).abs() < 1e-5);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::NoModalCoordinates`] for poles that are not distinct, [`DesignError::DependentModes`],
    /// [`DesignError::WidthGrows`] where the comparison system is not stable, and errors of shapes.
    pub fn new(
        observer: &LinearObserver<f64, Dyn, Dyn, Dyn>,
        disturbances: &DisturbanceBounds,
        coordinates: ErrorCoordinates,
        first: &[f64],
    ) -> Result<Self, DesignError> {
        let (n, p) = (observer.a.nrows(), observer.c.nrows());
        disturbances.check((n, p))?;
        check::matrix("the vector of half-widths of x(0)", &DMatrix::from_row_slice(first.len(), 1, first), (n, 1))?;
        check::not_negative("a half-width of x(0)", first)?;
        let flow = &observer.a - &observer.l * &observer.c;
        let (t, blocks) = chosen(TimeDomain::Continuous, &flow, coordinates)?;
        let Some(known) = BlockCoordinates::new(&proof_matrix(&t), &blocks)? else {
            return Err(modal::dependent(&t));
        };
        let (l, c) = (enclosed(&observer.l), enclosed(&observer.c));
        let f = enclosed(&observer.a).difference(&l.product(&c)?)?;
        let forcing = enclosed(&disturbances.e).difference(&l.product(&enclosed(&disturbances.d))?)?;
        let k = dynamic_matrix(&known.comparison(&f)?);
        let g = times_up(&dynamic_matrix(&known.column_norms(&forcing)?), &disturbances.bounds);
        let h = dynamic_matrix(&known.widths());
        let abscissa = spectral_abscissa(&k)?;
        if abscissa >= 0.0 && coordinates == ErrorCoordinates::Modal {
            // But for rounding it is diagonal, with the real parts of the poles.
            return Err(modal::dependent(&t));
        }
        if abscissa >= 0.0 {
            return Err(DesignError::WidthGrows {
                size: abscissa,
                limit: 0.0,
                plant: coordinates == ErrorCoordinates::Plant,
            });
        }
        let rate = -0.99 * abscissa;
        let s = positive_solution(&-(&k + DMatrix::identity(k.nrows(), k.nrows()) * rate))?;
        let limit = limit_of(&-&k, &g, &s)?;
        let widths = times_up(&h, &limit);
        let start = times_up(&dynamic_matrix(&known.state_norms()), first);
        let column = |entries: &[f64]| DVector::from_column_slice(entries);
        let theorem = IntervalEnclosure {
            a: proof_matrix(&observer.a),
            c: proof_matrix(&observer.c),
            e: proof_matrix(&disturbances.e),
            d: proof_matrix(&disturbances.d),
            l: proof_matrix(&observer.l),
            coordinates: IntervalCoordinates { t: proof_matrix(&t), blocks: blocks.clone() },
            k: proof_matrix(&k),
            g: g.clone(),
            h: proof_matrix(&h),
            s,
            rate,
            disturbances: disturbances.bounds.clone(),
            limit,
            widths: widths.clone(),
        };
        let comparison = ComparisonSystem { k, g: column(&g), h, start: column(&start) };
        let observer = IntervalObserver::new(observer.clone(), comparison)?;
        Ok(Self { observer, t, blocks, rate, widths, certificate: Certificate::of([theorem])? })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.inner().l()
    }

    /// The gain and the coordinates of the least width; see [`least_width_gain`].
    ///
    /// # Errors
    /// As [`least_width_gain`] and [`new`](Self::new).
    pub fn least_width(
        plant: &luenberger_plants::StateSpace,
        disturbances: &DisturbanceBounds,
        first: &[f64],
    ) -> Result<Self, DesignError> {
        let l = least_width_gain(&plant.a, &plant.c, disturbances, TimeDomain::Continuous)?;
        Self::new(&LinearObserver::of(plant.clone(), l)?, disturbances, ErrorCoordinates::Plant, first)
    }
}

/// Modal coordinates, T and its blocks, found in balanced units, or where these do not serve in those given.
///
/// # Errors
/// [`DesignError::NoModalCoordinates`] for poles that are not distinct, [`DesignError::DependentModes`] for
/// eigenvectors that are nearly dependent.
fn modal_coordinates(time: TimeDomain, f: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<usize>), DesignError> {
    for units in coordinates(time, f) {
        // With x = D z, z being modal in T~ z: T = T~ D^-1.
        if let Ok((t, blocks)) = modal::in_units(&units.similar(f)) {
            return Ok((units.outputs_back(&t), blocks));
        }
    }
    modal::in_units(f)
}

/// T and its blocks for `A - LC`.
fn chosen(
    time: TimeDomain,
    flow: &DMatrix<f64>,
    choice: ErrorCoordinates,
) -> Result<(DMatrix<f64>, Vec<usize>), DesignError> {
    match choice {
        ErrorCoordinates::Modal => modal_coordinates(time, flow),
        ErrorCoordinates::Plant => Ok((DMatrix::identity(flow.nrows(), flow.nrows()), vec![1; flow.nrows()])),
    }
}

/// A matrix as points in intervals.
fn enclosed(m: &DMatrix<f64>) -> Matrix<Interval> {
    proof_matrix(m).map(|x| Interval::of(*x))
}

/// `M v` rounded up.
fn times_up(m: &DMatrix<f64>, v: &[f64]) -> Vec<f64> {
    (0..m.nrows())
        .map(|i| {
            let terms = v.iter().enumerate().map(|(j, v)| Interval::of(m[(i, j)]).mul(&Interval::of(*v)));
            terms.fold(Interval::of(0.0), |sum, term| sum.add(&term)).hi()
        })
        .collect()
}

/// A positive s with `M s = 1`, up to rounding, for the negative of a Hurwitz Metzler matrix M: `M s > 0` with room.
fn positive_solution(m: &DMatrix<f64>) -> Result<Vec<f64>, DesignError> {
    let n = m.nrows();
    let solved = m.clone().lu().solve(&DVector::repeat(n, 1.0));
    let found: Vec<f64> = solved.map(|s| s.as_slice().to_vec()).unwrap_or_default();
    if found.len() == n && found.iter().all(|x| *x > 0.0 && x.is_finite()) {
        return Ok(found);
    }
    Err(DesignError::ComparisonUndecided)
}

/// An l of 0 or more with `M l >= g` in spite of rounding, `M s > 0`.
fn limit_of(m: &DMatrix<f64>, g: &[f64], s: &[f64]) -> Result<Vec<f64>, DesignError> {
    let solved = m.clone().lu().solve(&DVector::from_column_slice(g));
    let Some(found) = solved.filter(|found| found.iter().all(|x| x.is_finite())) else {
        return Err(DesignError::ComparisonUndecided);
    };
    let largest = found.iter().zip(s).fold(0.0_f64, |largest, (x, s)| largest.max(x / s));
    let room = 1e-9 * largest + f64::MIN_POSITIVE;
    Ok(found.iter().zip(s).map(|(x, s)| x.max(0.0) * (1.0 + 1e-12) + room * s).collect())
}
