//! The target `z' = D z + B y`: D Hurwitz, (D, B) controllable.
//!
//! Every output drives its own bank of filters, with the same poles. A filter has static gain 1, so that z has the
//! units of y.
//!
//! Choice of the speed: z - T(x) decays with the slowest pole, which bounds the convergence rate; the faster D is, the
//! shorter its memory, and the closer T comes to the output and its derivatives, which amplifies noise. T is k times
//! differentiable if the slowest pole is faster than k times the expansion rate of the plant *backward* in time.

use luenberger_linalg::{LinalgError, eigenvalues, lyapunov, spectral_abscissa, symmetric_eigenvalues};
use luenberger_plants::error::check_matrix;
use nalgebra::{Complex, DMatrix, SMatrix};

use crate::error::DesignError;
use crate::numerical_kkl::error::NumericalKklError;

/// D (Z x Z) and B (Z x P).
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSystem<const P: usize, const Z: usize> {
    d: SMatrix<f64, Z, Z>,
    b: SMatrix<f64, Z, P>,
}

/// Largest order of a Bessel prototype that is offered.
const BESSEL_ORDERS: usize = 10;

impl<const P: usize, const Z: usize> TargetSystem<P, Z> {
    /// A user-supplied target.
    ///
    /// # Errors
    /// [`DesignError::NotHurwitz`](crate::DesignError::NotHurwitz) with the spectral abscissa,
    /// [`NumericalKklError::Uncontrollable`], [`NumericalKklError::Empty`],
    /// [`DesignError::Matrix`](crate::DesignError::Matrix).
    pub fn new(d: SMatrix<f64, Z, Z>, b: SMatrix<f64, Z, P>) -> Result<Self, NumericalKklError> {
        if Z == 0 || P == 0 {
            return Err(NumericalKklError::Empty { states: 1, outputs: P, targets: Z });
        }
        check_matrix("D", &d, (Z, Z))?;
        check_matrix("B", &b, (Z, P))?;
        let target = Self { d, b };
        let abscissa = spectral_abscissa(&target.dynamics())?;
        if abscissa >= 0.0 {
            return Err(DesignError::NotHurwitz { what: "D", abscissa }.into());
        }
        let injection = DMatrix::from_column_slice(Z, P, b.as_slice());
        let gramian = lyapunov(&target.dynamics().transpose(), &(&injection * injection.transpose()))?.p;
        let spectrum = symmetric_eigenvalues(&gramian)?;
        let (least, most) = spectrum.iter().fold((f64::INFINITY, 0.0f64), |(l, m), &x| (l.min(x), m.max(x)));
        // The Gramian is known to about Z EPSILON of its norm.
        if least <= Z as f64 * f64::EPSILON * most {
            return Err(NumericalKklError::Uncontrollable { ratio: least / most });
        }
        Ok(target)
    }

    /// Filters with these poles for each output: `poles.len() * P == Z`, real or complex, closed under conjugation, in
    /// the open left half plane.
    ///
    /// In real modal form; a pole that is repeated feeds its repetition, as (D, B) is controllable only in this way.
    ///
    /// ```
    /// use luenberger_design::numerical_kkl::TargetSystem;
    /// use nalgebra::Complex;
    /// let poles = [Complex::new(-2.0, 1.0), Complex::new(-2.0, -1.0), Complex::new(-3.0, 0.0)];
    /// let target = TargetSystem::<1, 3>::poles(&poles)?;
    /// let abscissa = luenberger_linalg::spectral_abscissa(&target.dynamics())?;
    /// assert!((abscissa + 2.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::UnstablePole`](crate::DesignError::UnstablePole), [`LinalgError::PoleUnpaired`],
    /// [`LinalgError::PoleNotFinite`], [`NumericalKklError::PoleCount`], and those of [`new`](Self::new).
    pub fn poles(poles: &[impl Into<Complex<f64>> + Copy]) -> Result<Self, NumericalKklError> {
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if Z == 0 || P == 0 {
            return Err(NumericalKklError::Empty { states: 1, outputs: P, targets: Z });
        }
        if poles.len() * P != Z {
            return Err(NumericalKklError::PoleCount { poles: poles.len(), outputs: P, targets: Z });
        }
        if let Some(index) = poles.iter().position(|pole| !(pole.re.is_finite() && pole.im.is_finite())) {
            return Err(LinalgError::PoleNotFinite { index, pole: poles[index] }.into());
        }
        if let Some(&pole) = poles.iter().find(|pole| pole.re >= 0.0) {
            return Err(DesignError::UnstablePole { pole }.into());
        }
        let (bank, injection) = bank(&poles)?;
        let k = poles.len();
        let d = SMatrix::from_fn(|i, j| if i / k == j / k { bank[(i % k, j % k)] } else { 0.0 });
        let b = SMatrix::from_fn(|i, j| if i / k == j { injection[i % k] } else { 0.0 });
        Self::new(d, b)
    }

    /// The poles of the Bessel low-pass filter of order `Z / P`, which halves the power at the angular frequency
    /// `cutoff` (radians per unit of time).
    ///
    /// Bessel's filter delays all frequencies below the cut-off by nearly the same time: one number says how fast the
    /// bank is.
    ///
    /// # Errors
    /// [`DesignError::NotPositive`](crate::DesignError::NotPositive) for the cut-off,
    /// [`NumericalKklError::BesselOrder`], and those of [`poles`](Self::poles).
    pub fn bessel(cutoff: f64) -> Result<Self, NumericalKklError> {
        crate::check::positive("the cut-off", cutoff)?;
        if P == 0 || Z == 0 || !Z.is_multiple_of(P) {
            return Err(NumericalKklError::PoleCount { poles: Z / P.max(1), outputs: P, targets: Z });
        }
        Self::poles(&bessel_poles(Z / P)?.iter().map(|pole| pole * cutoff).collect::<Vec<_>>())
    }

    /// D.
    pub fn d(&self) -> &SMatrix<f64, Z, Z> {
        &self.d
    }

    /// B.
    pub fn b(&self) -> &SMatrix<f64, Z, P> {
        &self.b
    }

    /// D, of dynamic size.
    pub fn dynamics(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(Z, Z, self.d.as_slice())
    }
}

/// One bank in real modal form.
fn bank(poles: &[Complex<f64>]) -> Result<(DMatrix<f64>, Vec<f64>), NumericalKklError> {
    let k = poles.len();
    let (mut d, mut b) = (DMatrix::zeros(k, k), vec![0.0; k]);
    let mut taken = vec![false; k];
    // (pole, first row) of the blocks made so far.
    let mut blocks: Vec<(Complex<f64>, usize)> = Vec::new();
    let mut row = 0;
    for i in 0..k {
        if taken[i] {
            continue;
        }
        taken[i] = true;
        let pole = poles[i];
        // What a root finder meant to be real or conjugate.
        let near = 64.0 * f64::EPSILON * pole.norm();
        let real = pole.im.abs() <= near;
        let pole = if real { Complex::new(pole.re, 0.0) } else { Complex::new(pole.re, pole.im.abs()) };
        let size = if real { 1 } else { 2 };
        if !real {
            let partner = (i + 1..k).find(|&j| !taken[j] && (poles[j].conj() - poles[i]).norm() <= near);
            let Some(j) = partner else { return Err(LinalgError::PoleUnpaired { pole: poles[i] }.into()) };
            taken[j] = true;
        }
        d[(row, row)] = pole.re;
        if !real {
            (d[(row + 1, row + 1)], d[(row, row + 1)], d[(row + 1, row)]) = (pole.re, pole.im, -pole.im);
        }
        match blocks.iter().rev().find(|(other, _)| (other - pole).norm() <= near) {
            Some(&(_, before)) => {
                for s in 0..size {
                    d[(row + s, before + s)] = pole.norm();
                }
            }
            None => b[row] = pole.norm(),
        }
        blocks.push((pole, row));
        row += size;
    }
    Ok((d, b))
}

/// The poles of Bessel's low-pass filter of this order, for the cut-off 1: the zeros of
/// `theta(s) = sum (2k - j)! / (2^(k-j) j! (k-j)!) s^j`, scaled so that `|theta(0) / theta(i)|^2 = 1/2`.
fn bessel_poles(order: usize) -> Result<Vec<Complex<f64>>, NumericalKklError> {
    if order > BESSEL_ORDERS {
        return Err(NumericalKklError::BesselOrder { order, largest: BESSEL_ORDERS });
    }
    // From the leading one down: theta_j / theta_(j+1) = (2k - j) (j + 1) / (2 (k - j)).
    let mut theta = vec![1.0; order + 1];
    for j in (0..order).rev() {
        theta[j] = theta[j + 1] * ((2 * order - j) * (j + 1)) as f64 / (2 * (order - j)) as f64;
    }
    let companion = DMatrix::from_fn(order, order, |i, j| match (i, j) {
        (i, j) if j + 1 == order => -theta[i],
        (i, j) if i == j + 1 => 1.0,
        _ => 0.0,
    });
    let power = |omega: f64| {
        let value = theta.iter().rev().fold(Complex::new(0.0, 0.0), |sum, &c| sum * Complex::new(0.0, omega) + c);
        (theta[0] / value.norm()).powi(2)
    };
    // The power falls; 60 halvings leave one rounding of the frequency.
    let (mut low, mut high) = (0.0, 2.0 * order as f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if power(middle) > 0.5 { low = middle } else { high = middle }
    }
    Ok(eigenvalues(&companion)?.iter().map(|pole| pole / low).collect())
}
