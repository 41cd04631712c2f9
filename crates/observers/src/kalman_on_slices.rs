//! The step of the extended Kalman filter on slices, for plants whose sizes are known at run time only.
//!
//! Up to eight states and four outputs the step is compiled for these sizes and takes no memory. It is the same
//! arithmetic in the same order as for any size, and gives the same bits. A module for web pages has to be downloaded:
//! it has those up to four states and two outputs.

use nalgebra::{RealField, SMatrix, SVector, convert};

use crate::dense::{are_finite, times, times_transpose};
use crate::gaussian::corrected;
use crate::transition::{Motion, Prediction};

/// Where a step is: time, input, measurement, and which outputs were measured.
#[derive(Clone, Copy)]
pub(crate) struct Sample<'s, T> {
    pub(crate) t: T,
    pub(crate) u: &'s [T],
    pub(crate) y: &'s [T],
    pub(crate) measured: &'s [bool],
}

/// f or h and its Jacobian at time, state and input, on slices; false if their lengths do not fit.
pub(crate) type WithJacobian<'f, T> = dyn Fn(T, &[T], &[T], &mut [T], &mut [T]) -> bool + 'f;

/// The filter that steps: f and h of the plant, noises W and V by columns, gate, period, and how it predicts. Without
/// the type of the plant: the sizes are many already.
pub(crate) struct StepOnSlices<'f, T> {
    pub(crate) motion: &'f WithJacobian<'f, T>,
    pub(crate) measurement: &'f WithJacobian<'f, T>,
    /// Whether f is linear between samples.
    pub(crate) is_linear: bool,
    pub(crate) w: &'f [T],
    pub(crate) v: &'f [T],
    pub(crate) gate: Option<T>,
    /// How often an update linearises.
    pub(crate) iterations: usize,
    pub(crate) h: T,
    pub(crate) prediction: Prediction,
    /// The parts of the step that are taken: the update, and the prediction.
    pub(crate) parts: [bool; 2],
}

impl<T: RealField + Copy> StepOnSlices<'_, T> {
    /// Update and prediction of the estimate and the covariance by columns in `estimate`; false if the sizes have no
    /// step of their own, and nothing is done.
    pub(crate) fn step(&self, estimate: &mut [T], sample: Sample<'_, T>) -> bool {
        let (n, p) = (self.w.len().isqrt(), self.v.len().isqrt());
        if estimate.len() != n * (n + 1) || self.parts[0] && sample.y.len() != p {
            return false;
        }
        match n {
            1 => self.of_states::<1>(estimate, sample),
            2 => self.of_states::<2>(estimate, sample),
            3 => self.of_states::<3>(estimate, sample),
            4 => self.of_states::<4>(estimate, sample),
            #[cfg(not(target_arch = "wasm32"))]
            5 => self.of_states::<5>(estimate, sample),
            #[cfg(not(target_arch = "wasm32"))]
            6 => self.of_states::<6>(estimate, sample),
            #[cfg(not(target_arch = "wasm32"))]
            7 => self.of_states::<7>(estimate, sample),
            #[cfg(not(target_arch = "wasm32"))]
            8 => self.of_states::<8>(estimate, sample),
            _ => false,
        }
    }

    fn of_states<const K: usize>(&self, estimate: &mut [T], sample: Sample<'_, T>) -> bool {
        let (head, tail) = estimate.split_at_mut(K);
        let mut xhat = SVector::<T, K>::from_column_slice(head);
        let mut p = SMatrix::<T, K, K>::from_column_slice(tail);
        let Sample { t, u, measured, .. } = sample;
        let [updates, predicts] = self.parts;
        if updates && (measured.is_empty() || measured.contains(&true)) {
            match sample.y.len() {
                1 => self.update_of_size::<K, 1>(&mut xhat, &mut p, sample),
                2 => self.update_of_size::<K, 2>(&mut xhat, &mut p, sample),
                #[cfg(not(target_arch = "wasm32"))]
                3 => self.update_of_size::<K, 3>(&mut xhat, &mut p, sample),
                #[cfg(not(target_arch = "wasm32"))]
                4 => self.update_of_size::<K, 4>(&mut xhat, &mut p, sample),
                _ => return false,
            }
        }
        if predicts {
            match self.predict_of_size(t, &xhat, &p, u) {
                Some((next, after)) => (xhat, p) = (next, after),
                None => xhat = SVector::repeat(convert(f64::NAN)),
            }
        }
        head.copy_from_slice(xhat.as_slice());
        tail.copy_from_slice(p.as_slice());
        true
    }

    fn update_of_size<const K: usize, const Q: usize>(
        &self,
        xhat: &mut SVector<T, K>,
        p: &mut SMatrix<T, K, K>,
        Sample { t, u, y, measured }: Sample<'_, T>,
    ) {
        let linearised = |x: &SVector<T, K>| {
            let (mut value, mut h) = (SVector::<T, Q>::zeros(), SMatrix::<T, Q, K>::zeros());
            if !(self.measurement)(t, x.as_slice(), u, value.as_mut_slice(), h.as_mut_slice()) {
                value.fill(convert(f64::NAN));
            }
            (h, SVector::<T, Q>::from_column_slice(y) - value)
        };
        let (h, innovation) = linearised(xhat);
        let v = SMatrix::<T, Q, Q>::from_column_slice(self.v);
        let gate = self.gate.map(|gate| (gate * gate, times_transpose(&times(&h, p), &h) + v));
        let accepted = |i: usize| {
            let within = gate.as_ref().is_none_or(|(gate, s)| innovation[i] * innovation[i] <= *gate * s[(i, i)]);
            measured.get(i).copied().unwrap_or(true) && within
        };
        let again = (self.iterations, linearised);
        if let Some((estimate, covariance, _)) = corrected(xhat, p, (h, innovation), v, accepted, again) {
            (*xhat, *p) = (estimate, covariance);
        }
    }

    #[cfg(not(all(target_arch = "wasm32", feature = "alloc")))]
    fn predict_of_size<const K: usize>(
        &self,
        t: T,
        xhat: &SVector<T, K>,
        p: &SMatrix<T, K, K>,
        u: &[T],
    ) -> Option<(SVector<T, K>, SMatrix<T, K, K>)> {
        let w = SMatrix::<T, K, K>::from_column_slice(self.w);
        let field = |t: T, xhat: &SVector<T, K>| {
            let (mut f, mut df) = (SVector::<T, K>::zeros(), SMatrix::<T, K, K>::zeros());
            if !(self.motion)(t, xhat.as_slice(), u, f.as_mut_slice(), df.as_mut_slice()) {
                f.fill(convert(f64::NAN));
            }
            (f, df)
        };
        let motion = Motion { field, is_linear: self.is_linear, w: &w, with_covariance: true };
        let found = motion.over(self.prediction, (t, self.h, self.h), xhat, p)?;
        let after = found.spread(p);
        are_finite(after.as_slice()).then_some((found.next, after))
    }
    /// The same bits by matrices whose size is known at run time, of which a module for web pages has one copy.
    #[cfg(all(target_arch = "wasm32", feature = "alloc"))]
    fn predict_of_size<const K: usize>(
        &self,
        t: T,
        xhat: &SVector<T, K>,
        p: &SMatrix<T, K, K>,
        u: &[T],
    ) -> Option<(SVector<T, K>, SMatrix<T, K, K>)> {
        let (next, after) = self.predict(t, xhat.as_slice(), p.as_slice(), u)?;
        Some((SVector::from_column_slice(next.as_slice()), SMatrix::from_column_slice(after.as_slice())))
    }

    #[cfg(all(target_arch = "wasm32", feature = "alloc"))]
    fn predict(&self, t: T, xhat: &[T], p: &[T], u: &[T]) -> Option<(nalgebra::DVector<T>, nalgebra::DMatrix<T>)> {
        use nalgebra::{DMatrix, DVector};
        let n = xhat.len();
        let (w, p) = (DMatrix::from_column_slice(n, n, self.w), DMatrix::from_column_slice(n, n, p));
        let field = |t: T, xhat: &DVector<T>| {
            let (mut f, mut df) = (DVector::<T>::zeros(n), DMatrix::<T>::zeros(n, n));
            if !(self.motion)(t, xhat.as_slice(), u, f.as_mut_slice(), df.as_mut_slice()) {
                f.fill(convert(f64::NAN));
            }
            (f, df)
        };
        let motion = Motion { field, is_linear: self.is_linear, w: &w, with_covariance: true };
        let found = motion.over(self.prediction, (t, self.h, self.h), &DVector::from_column_slice(xhat), &p)?;
        let after = found.spread(&p);
        are_finite(after.as_slice()).then_some((found.next, after))
    }
}
