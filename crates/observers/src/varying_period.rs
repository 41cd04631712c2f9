//! A sampled observer whose samples arrive at varying periods, or not at all: correction and prediction apart.
//!
//! ```text
//! at a sample        xhat  <- xhat - N i + K r              the cubic part and the correction, r = y - C xhat without it
//! between samples    xhat' =  A xhat + B u                  for the time that really passes, u held
//! ```
//!
//! The prediction is the exponential series, `exp(A tau) = sum (A tau)^k/k!` to degree 18, in a number of substeps that
//! is fixed at construction: `|A| tau <= 1` for the longest time, in the largest row sum, so that the remainder is
//! below rounding in binary64. A call takes the same time whatever passes: `36 n^2` operations for a substep. Longer
//! times than the longest are predicted less accurately.
//!
//! Convergence for all periods between two bounds and a number of samples missed in a row is a theorem of the gains:
//! `VaryingPeriodDesign` of the design crate.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::cubic_sampled::SampledCubicObserver;
use crate::dense::{copy, entry, with_column};
use crate::error::ObserverError;
use crate::feedthrough;

/// Degree of the series.
const DEGREE: usize = 18;

/// The most substeps of a prediction.
const MOST_SUBSTEPS: usize = 4096;

/// An observer with N states, M inputs and P outputs that corrects when a sample arrives, and predicts over any time.
#[derive(Clone, Debug, PartialEq)]
pub struct VaryingPeriodObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    nominal: SampledCubicObserver<T, N, M, P>,
    a: OMatrix<T, N, N>,
    b: OMatrix<T, N, M>,
    k: OMatrix<T, N, P>,
    substeps: usize,
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> VaryingPeriodObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with the correction gain K (n x p), the cubic part of `nominal`, and the plant `x' = A x + B u`
    /// that `nominal` samples; `longest` is the longest time between two calls of [`predict`](Self::predict).
    ///
    /// ```
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, VaryingPeriodObserver};
    /// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2};
    /// // The double integrator, nominally every 0.1 s; K = Ad^-1 Ld.
    /// let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    /// let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    /// let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    /// let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w: 1.0, period: h };
    /// let nominal = SampledCubicObserver::new(gains)?;
    /// let (a, b, k) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Vector2::new(0.7, 2.0));
    /// let observer = VaryingPeriodObserver::new(nominal, a, b, k, 0.3)?;
    ///
    /// let (mut x, mut xhat, u) = (Vector2::new(1.0, -1.0), Vector2::zeros(), Vector1::new(1.0));
    /// for period in [0.08, 0.12, 0.3, 0.1].into_iter().cycle().take(200) {
    ///     observer.correct(&mut xhat, &u, &(c * x), period);
    ///     observer.predict(&mut xhat, &u, period);
    ///     x += Vector2::new(x[1] + period / 2.0, 1.0) * period;
    /// }
    /// assert!((x - xhat).norm() < 1e-9 * x.norm());
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries; [`ObserverError::NotPositive`] for `longest`, also where `|A|
    /// longest` is above 4096.
    pub fn new(
        nominal: SampledCubicObserver<T, N, M, P>,
        a: OMatrix<T, N, N>,
        b: OMatrix<T, N, M>,
        k: OMatrix<T, N, P>,
        longest: T,
    ) -> Result<Self, ObserverError> {
        let plant = LinearPlant::new(a, b, nominal.c().clone())?;
        check_matrix("K", &k, nominal.n().shape())?;
        let refused = |value: T| ObserverError::NotPositive {
            what: "the longest time between samples",
            value: value.to_subset_unchecked(),
        };
        if !(longest.is_finite() && longest > T::zero()) {
            return Err(refused(longest));
        }
        let norm = plant
            .a
            .row_iter()
            .fold(T::zero(), |norm, row| norm.max(row.iter().fold(T::zero(), |sum, entry| sum + entry.abs())));
        let (mut substeps, mut reach) = (1, T::one());
        while reach < norm * longest {
            (substeps, reach) = (substeps + 1, reach + T::one());
            if substeps > MOST_SUBSTEPS {
                return Err(refused(longest));
            }
        }
        Ok(Self { nominal, a: plant.a, b: plant.b, k, substeps })
    }

    /// The gain of the correction, n x p.
    pub fn k(&self) -> &OMatrix<T, N, P> {
        &self.k
    }

    /// A sample: the cubic flow for the time `elapsed`, the period or what has passed since the last correction, then
    /// the correction.
    pub fn correct(&self, xhat: &mut OVector<T, N>, u: &OVector<T, M>, y: &OVector<T, P>, elapsed: T) {
        let n = self.nominal.n();
        let (xhat, outputs) = (xhat.as_mut_slice(), n.shape_generic().1);
        with_column(outputs, |innovation| {
            let c = self.nominal.c();
            feedthrough::innovation(c, self.nominal.d(), (xhat, u.as_slice(), y.as_slice()), innovation);
            with_column(outputs, |impulse| {
                self.nominal.flow(elapsed, innovation, impulse);
                for (i, xhat) in xhat.iter_mut().enumerate() {
                    *xhat = *xhat - entry(n, i, impulse) + entry(&self.k, i, innovation);
                }
            });
        });
    }

    /// The estimate after the time `elapsed` without a sample, u being held.
    pub fn predict(&self, xhat: &mut OVector<T, N>, u: &OVector<T, M>, elapsed: T) {
        let (xhat, states) = (xhat.as_mut_slice(), self.a.shape_generic().0);
        let tau = elapsed / crate::cubic::count(self.substeps);
        with_column(states, |term| {
            with_column(states, |next| {
                for _ in 0..self.substeps {
                    copy(xhat, term);
                    let mut degree = T::zero();
                    for k in 0..DEGREE {
                        degree += T::one();
                        for (i, next) in next.iter_mut().enumerate() {
                            let slope = entry(&self.a, i, term);
                            // The input is in the first derivative only.
                            let slope = if k == 0 { slope + entry(&self.b, i, u.as_slice()) } else { slope };
                            *next = slope * tau / degree;
                        }
                        copy(next, term);
                        for (xhat, term) in xhat.iter_mut().zip(term.iter()) {
                            *xhat += *term;
                        }
                    }
                }
            });
        });
    }
}
