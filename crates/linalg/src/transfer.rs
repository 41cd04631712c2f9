//! Transfer functions of a linear observer, and of the loop that feeds its estimate back, with margins.
//!
//! For the observer `xhat' = A xhat + B u + L (y - C xhat - D u)` and the feedback `u = -K xhat` (in discrete time
//! `xhat+`, with the estimate before the measurement of its sample; s is z):
//! ```text
//! (y, u) to xhat               (s I - A + L C)^-1 [L, B - L D]
//! v to e = x - xhat           -(s I - A + L C)^-1 L,   y = C x + D u + v
//! plant                    G = C (s I - A)^-1 B + D
//! compensator, y to -u     H = K (s I - A + B K + L C - L D K)^-1 L
//! loop, opened at u            H G,        S = (I + H G)^-1,  T = H G (I + H G)^-1
//! loop, opened at y            G H,        S = (I + G H)^-1,  T = G H (I + G H)^-1
//! state feedback at u          K (s I - A)^-1 B
//! ```
//! The loop of state feedback is what loop transfer recovery brings `H G` to. Of a loop with several channels the
//! margins of each are those of the loop opened there with the others closed; what all channels stand at once follows
//! from the peak `Ms` of S: factors between `Ms/(Ms + 1)` and `Ms/(Ms - 1)`, or angles up to `2 asin(1/(2 Ms))`
//! (Zhou, Doyle and Glover 1996, section 9.6; Skogestad and Postlethwaite 2005, section 2.4.3).

use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned, shaped};
use crate::margins::{peak_if_stable, return_difference};
use crate::{
    HInfinityNorm, Realization, Result, StabilityMargins, discrete_stability_margins, sensitivity, stability_margins,
};

/// Transfer functions of a linear observer.
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverTransfer {
    /// From (y, u) to xhat.
    pub estimate: Realization,
    /// From the measurement noise v to the error `e = x - xhat`.
    pub noise_to_error: Realization,
}

impl ObserverTransfer {
    /// Those of the observer of `plant` with the gain `l`, n x p.
    ///
    /// ```
    /// use luenberger_linalg::{FrequencyResponse, ObserverTransfer, Realization};
    /// use nalgebra::dmatrix;
    /// // Two integrators, poles at -2 and -5: the speed is that of y through 10 s/((s + 2)(s + 5)).
    /// let a = dmatrix![0.0, 1.0; 0.0, 0.0];
    /// let plant = Realization::new(&a, &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.0])?;
    /// let transfer = ObserverTransfer::new(&plant, &dmatrix![7.0; 10.0])?;
    /// let at = FrequencyResponse::continuous(&transfer.estimate)?.at(1.0)[(1, 0)];
    /// assert!((at.norm() - 10.0 / 130f64.sqrt()).abs() < 1e-14);
    /// # Ok::<(), luenberger_linalg::LinalgError>(())
    /// ```
    /// # Errors
    /// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch) and
    /// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite) for L; those of [`Realization::new`].
    pub fn new<'a>(plant: &Realization, l: impl Into<RealMatrixView<'a>>) -> Result<Self> {
        let none = DMatrix::zeros(plant.a.nrows(), plant.c.nrows());
        Self::of(plant, &owned(l), &none)
    }

    /// Those of the filter form in discrete time, whose estimate is `xhat + K (y - C xhat - D u)` with the gain
    /// `update`, n x p, of the measurement update.
    ///
    /// # Errors
    /// As [`new`](Self::new), for K likewise.
    pub fn with_update<'a>(
        plant: &Realization,
        l: impl Into<RealMatrixView<'a>>,
        update: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self> {
        Self::of(plant, &owned(l), &owned(update))
    }

    fn of(plant: &Realization, l: &DMatrix<f64>, k: &DMatrix<f64>) -> Result<Self> {
        plant.check()?;
        let Realization { a, b, c, d } = plant;
        let ((n, m), p) = (b.shape(), c.nrows());
        shaped("L", l, n, p)?;
        shaped("K", k, n, p)?;
        let error = a - l * c;
        let mut from = DMatrix::zeros(n, p + m);
        from.columns_mut(0, p).copy_from(l);
        from.columns_mut(p, m).copy_from(&(b - l * d));
        // xhat + K (y - C xhat - D u), and its error (I - K C) e - K v.
        let seen = DMatrix::identity(n, n) - k * c;
        let mut direct = DMatrix::zeros(n, p + m);
        direct.columns_mut(0, p).copy_from(k);
        direct.columns_mut(p, m).copy_from(&-(k * d));
        Ok(Self {
            estimate: Realization::new(&error, &from, &seen, &direct)?,
            noise_to_error: Realization::new(&error, &-l, &seen, &-k)?,
        })
    }
}

/// Transfer functions of the loop `u = -K xhat`.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopTransfer {
    /// The compensator H, from y to -u.
    pub compensator: Realization,
    /// H G, the loop opened at the inputs of the plant.
    pub at_inputs: Realization,
    /// G H, the loop opened at its outputs.
    pub at_outputs: Realization,
    /// `K (s I - A)^-1 B`, the loop of state feedback.
    pub state_feedback: Realization,
}

impl LoopTransfer {
    /// Those of `plant` with the observer gain `l`, n x p, and the feedback gain `k`, m x n.
    ///
    /// # Errors
    /// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch) and
    /// [`LinalgError::NotFinite`](crate::LinalgError::NotFinite) for L and K; those of [`Realization::new`].
    pub fn new<'a>(
        plant: &Realization,
        l: impl Into<RealMatrixView<'a>>,
        k: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self> {
        plant.check()?;
        let Realization { a, b, c, d } = plant;
        let ((n, m), p) = (b.shape(), c.nrows());
        let (l, k) = (owned(l), owned(k));
        shaped("L", &l, n, p)?;
        shaped("K", &k, m, n)?;
        let inner = a - b * &k - &l * (c - d * &k);
        let plain = |a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>| {
            Realization::new(a, b, c, &DMatrix::zeros(c.nrows(), b.ncols()))
        };
        let stacked = |corner: (usize, usize), coupling: &DMatrix<f64>| {
            let mut both = DMatrix::zeros(2 * n, 2 * n);
            both.view_mut((0, 0), (n, n)).copy_from(a);
            both.view_mut((n, n), (n, n)).copy_from(&inner);
            both.view_mut(corner, (n, n)).copy_from(coupling);
            both
        };
        // u drives the plant and, by D, the compensator.
        let (mut from_u, mut to_u) = (DMatrix::zeros(2 * n, m), DMatrix::zeros(m, 2 * n));
        from_u.view_mut((0, 0), (n, m)).copy_from(b);
        from_u.view_mut((n, 0), (n, m)).copy_from(&(&l * d));
        to_u.view_mut((0, n), (m, n)).copy_from(&k);
        // y drives the compensator, and its -u the plant.
        let (mut from_y, mut to_y) = (DMatrix::zeros(2 * n, p), DMatrix::zeros(p, 2 * n));
        from_y.view_mut((n, 0), (n, p)).copy_from(&l);
        to_y.view_mut((0, 0), (p, n)).copy_from(c);
        to_y.view_mut((0, n), (p, n)).copy_from(&(d * &k));
        Ok(Self {
            compensator: plain(&inner, &l, &k)?,
            at_inputs: plain(&stacked((n, 0), &(&l * c)), &from_u, &to_u)?,
            at_outputs: plain(&stacked((0, n), &(b * &k)), &from_y, &to_y)?,
            state_feedback: plain(a, b, &k)?,
        })
    }
}

/// The margins of a loop with as many inputs as outputs, negative feedback.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopMargins {
    /// Those of each channel, with the others closed.
    pub channels: Vec<StabilityMargins>,
    /// The eigenvalues of the closed loop.
    pub poles: Vec<Complex<f64>>,
    /// The peak of the sensitivity `S = (I + L)^-1`; none if the closed loop is not stable.
    pub sensitivity: Option<HInfinityNorm>,
    /// The peak of the complementary sensitivity `T = L (I + L)^-1`; none if the closed loop is not stable.
    pub complementary: Option<HInfinityNorm>,
}

impl LoopMargins {
    /// The margins of the loop `I + L = 0` in continuous time.
    ///
    /// ```
    /// use luenberger_linalg::{LoopMargins, Realization, lqr};
    /// use nalgebra::{DMatrix, dmatrix};
    /// // A regulator that has the whole state: Ms = 1, and 60 degrees at least (Kalman 1964).
    /// let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    /// let k = lqr(&a, &b, &DMatrix::identity(2, 2), &dmatrix![1.0])?.k;
    /// let margins = LoopMargins::continuous(&Realization::new(&a, &b, &k, &dmatrix![0.0])?)?;
    /// assert!((margins.guaranteed_phase().ok_or("a stable loop")?.to_degrees() - 60.0).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`LinalgError::DimensionMismatch`](crate::LinalgError::DimensionMismatch) for a loop that is not square,
    /// [`LinalgError::Singular`](crate::LinalgError::Singular) where `I + D` is singular; those of
    /// [`stability_margins`].
    pub fn continuous(open: &Realization) -> Result<Self> {
        Self::new(open, false)
    }

    /// The same in discrete time.
    ///
    /// # Errors
    /// As [`continuous`](Self::continuous).
    pub fn discrete(open: &Realization) -> Result<Self> {
        Self::new(open, true)
    }

    fn new(open: &Realization, is_discrete: bool) -> Result<Self> {
        open.check()?;
        let count = open.b.ncols();
        shaped("the loop", &open.d, count, count)?;
        let mut channels = Vec::new();
        for i in 0..count {
            let one = with_others_closed(open, i)?;
            channels.push(if is_discrete { discrete_stability_margins(&one)? } else { stability_margins(&one)? });
        }
        let s = sensitivity(open)?;
        let (poles, sensitivity) = peak_if_stable(&s, is_discrete)?;
        // T = I - S.
        let t = Realization { c: -&s.c, d: DMatrix::identity(count, count) - &s.d, ..s };
        let (_, complementary) = peak_if_stable(&t, is_discrete)?;
        Ok(Self { channels, poles, sensitivity, complementary })
    }

    /// The factors by which all gains may change at once: `Ms/(Ms + 1)`, and `Ms/(Ms - 1)`, infinite for `Ms = 1`.
    pub fn guaranteed_gain(&self) -> Option<(f64, f64)> {
        let peak = self.sensitivity?.norm;
        Some((peak / (peak + 1.0), if peak > 1.0 { peak / (peak - 1.0) } else { f64::INFINITY }))
    }

    /// The angle, in radians, by which all phases may change at once: `2 asin(1/(2 Ms))`.
    pub fn guaranteed_phase(&self) -> Option<f64> {
        self.sensitivity.map(|peak| 2.0 * (0.5 / peak.norm).min(1.0).asin())
    }
}

/// The loop opened at channel i, from 0, with the others closed.
fn with_others_closed(open: &Realization, i: usize) -> Result<Realization> {
    let Realization { a, b, c, d } = open;
    let (others, to_others) = (b.clone().remove_column(i), c.clone().remove_row(i));
    let across = d.clone().remove_column(i).remove_row(i);
    let (from, to) = (d.columns(i, 1).into_owned().remove_row(i), d.rows(i, 1).into_owned().remove_column(i));
    let inverse = return_difference(&across)?;
    let passed = to * &inverse;
    let input = b.columns(i, 1) - &others * &inverse * &from;
    let output = c.rows(i, 1) - &passed * &to_others;
    let rest = a - &others * &inverse * &to_others;
    Realization::new(&rest, &input, &output, &(d.view((i, i), (1, 1)) - passed * from))
}
