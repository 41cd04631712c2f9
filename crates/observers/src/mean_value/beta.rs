//! The mean value theorem row by row: `f_i(xhat + e) - f_i(xhat) = Df_i(xhat + beta_i e) e` with beta_i in [0, 1].
//!
//! The paper solves its eq. (11) for all beta at once by bounded nonlinear least squares, (12). But equation i contains
//! beta_i alone: with `phi_i(s) = f_i(xhat + s e)` it is `X_i(s) = phi_i(1) - phi_i(0) - phi_i'(s) = 0`, n scalar
//! equations. The integral of X_i over [0, 1] is zero, so that X_i vanishes identically or changes its sign: a bracket
//! is all that is needed.
//!
//! The root need not be unique, and it jumps when xhat and e move. Taken is the one whose bracket is nearest to 1/2,
//! which is the limit for small e, and 1/2 itself where `X_i(1/2)` is zero to rounding: rows that are affine or
//! quadratic along e.

use luenberger_plants::{Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use crate::mean_value::{Mean, MeanJacobian};

/// Cells on either side of 1/2 that are searched for a change of sign.
const CELLS: usize = 8;

/// Steps of refinement; every third one halves the bracket, 1/16 wide, so that these leave less than the spacing of
/// f64.
const STEPS: usize = 150;

/// As the paper: row i of D is the gradient of f_i at `xhat + beta_i e`, with beta_i bracketed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Beta;

impl<S, T, N, M, P> Mean<S, T, N, M, P> for Beta
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    fn mean(&self, plant: &S, t: T, xhat: &OVector<T, N>, u: &OVector<T, M>, e: &OVector<T, N>) -> MeanJacobian<T, N> {
        let jacobian = mean_value(plant, t, xhat, u, e).jacobian;
        let forward = &jacobian * e;
        MeanJacobian { jacobian, forward }
    }
}

/// The mean value theorem along one segment.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanValue<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// beta_i in [0, 1].
    pub beta: OVector<T, N>,
    /// `X_i(beta_i)`: rounding, unless no change of sign was found in row i.
    pub residual: OVector<T, N>,
    /// Row i is the gradient of f_i at `xhat + beta_i e`.
    pub jacobian: OMatrix<T, N, N>,
}

/// beta, residual and Jacobian for the segment from `xhat` to `xhat + e`.
///
/// Per row: a search for the change of sign of X_i outward from 1/2 on a grid of spacing 1/16, then false position
/// (Illinois) with a bisection at every third step, until X_i is rounding or the bracket cannot be divided, at most 150
/// steps. Where no change of sign is found (two roots in one cell, or an f that is not finite) beta_i is the grid point
/// of least `|X_i|`, the ends 0 and 1 among them, and the residual says so.
///
/// `X_i(1/2)` counts as zero below the rounding of f at a rounded point, `|Df| |x|` times a few epsilon: so close to e
/// = 0 the sign of X_i is noise.
///
/// Costs 17 derivatives along e for the grid at most, about 10 per row for its root, and n for the Jacobian at 1/2 and
/// at each other beta.
///
/// ```
/// use luenberger_observers::mean_value::beta::mean_value;
/// use luenberger_plants::Chaotic;
/// use nalgebra::{SVector, Vector3};
/// let (xhat, e) = (Vector3::new(-1.0, -0.5, -1.5), Vector3::new(-1.0, -0.5, 0.5));
/// let mean = mean_value(&Chaotic, 0.0, &xhat, &SVector::zeros(), &e);
/// // The products x1 x3 and x1 x2 are quadratic along the segment, the logarithm is not.
/// assert!(mean.beta[0] > 0.4 && mean.beta[0] < 0.6 && mean.beta[0] != 0.5);
/// assert_eq!((mean.beta[1], mean.beta[2]), (0.5, 0.5));
/// assert!(mean.residual.amax() <= 16.0 * f64::EPSILON);
/// ```
///
/// Source: eq. (1) and (11) of the paper; M. Dowell and P. Jarratt, BIT 11, 1971, for the Illinois step.
pub fn mean_value<S, T, N, M, P>(
    plant: &S,
    t: T,
    xhat: &OVector<T, N>,
    u: &OVector<T, M>,
    e: &OVector<T, N>,
) -> MeanValue<T, N>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    let (order, n) = (xhat.shape_generic().0, xhat.nrows());
    let (start, end) = (plant.derivative(t, xhat, u), plant.derivative(t, &(xhat + e), u));
    let rise = &end - &start;
    let residual_at = |s: T| &rise - plant.directional(t, &(xhat + e * s), u, e).1;

    let half: T = convert(0.5);
    let middle = residual_at(half);
    // Rounding of the two values of f and of the slope, a few operations each.
    let four_epsilon = T::default_epsilon() * convert(4.0);
    let rounding = OVector::from_fn_generic(order, U1, |i, _| {
        (start[i].abs() + end[i].abs() + (rise[i] - middle[i]).abs()) * four_epsilon
    });

    // The ends of the segment are rounded themselves, and with them every term of f: |Df| |x| says how much that is,
    // also where the terms cancel. Below it the sign of X(1/2) is undetermined.
    let centre = plant.state_jacobian(t, &(xhat + e * half), u);
    let negligible = OVector::from_fn_generic(order, U1, |i, _| {
        (0..n).fold(rounding[i], |sum, j| sum + centre[(i, j)].abs() * (xhat[j].abs() + e[j].abs()) * four_epsilon)
    });
    let settled = |i: usize, residual: T| middle[i].abs() <= negligible[i] || residual.abs() <= rounding[i];

    let mut beta = OVector::repeat_generic(order, U1, half);
    let mut residual = middle.clone();
    // The bracket of a row: (s, X_i(s)) on both sides.
    let mut brackets = OVector::<Option<Bracket<T>>, N>::repeat_generic(order, U1, None);
    let (mut left, mut right) = (Side::new(half, middle.clone()), Side::new(half, middle.clone()));
    for k in 1..=CELLS {
        if (0..n).all(|i| brackets[i].is_some() || settled(i, residual[i])) {
            break;
        }
        let distance = convert::<f64, T>(k as f64 / (2 * CELLS) as f64);
        for (side, s) in [(&mut right, half + distance), (&mut left, half - distance)] {
            let value = residual_at(s);
            for i in 0..n {
                if brackets[i].is_none() && !settled(i, residual[i]) {
                    if (side.value[i] < T::zero()) != (value[i] < T::zero()) {
                        brackets[i] = Some(Bracket { a: side.s, fa: side.value[i], b: s, fb: value[i] });
                    }
                    if value[i].abs() < residual[i].abs() {
                        (beta[i], residual[i]) = (s, value[i]);
                    }
                }
            }
            *side = Side::new(s, value);
        }
    }
    for i in 0..n {
        if let Some(bracket) = brackets[i] {
            (beta[i], residual[i]) = refine(bracket, rounding[i], |s| residual_at(s)[i]);
        }
    }

    let mut jacobian = OMatrix::zeros_generic(order, order);
    let mut at = Some((half, centre));
    for i in 0..n {
        let here = match at.take() {
            Some((s, here)) if s == beta[i] => here,
            _ => plant.state_jacobian(t, &(xhat + e * beta[i]), u),
        };
        jacobian.set_row(i, &here.row(i));
        at = Some((beta[i], here));
    }
    MeanValue { beta, residual, jacobian }
}

/// The last point searched on one side of 1/2.
struct Side<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N>,
{
    s: T,
    value: OVector<T, N>,
}

impl<T: RealField + Copy, N: Dim> Side<T, N>
where
    DefaultAllocator: Allocator<N>,
{
    fn new(s: T, value: OVector<T, N>) -> Self {
        Self { s, value }
    }
}

/// Two points between which a function changes its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bracket<T> {
    a: T,
    fa: T,
    b: T,
    fb: T,
}

/// The root in the bracket, and the function there: the better end where the bracket cannot be divided any further.
fn refine<T: RealField + Copy>(bracket: Bracket<T>, rounding: T, f: impl Fn(T) -> T) -> (T, T) {
    let Bracket { mut a, mut fa, mut b, mut fb } = bracket;
    let half: T = convert(0.5);
    // Weights of the Illinois step: an end that stays twice counts half.
    let (mut wa, mut wb) = (T::one(), T::one());
    let mut replaced_a = None;
    let mut best = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
    for step in 0..STEPS {
        if best.1.abs() <= rounding {
            break;
        }
        let midpoint = (a + b) * half;
        let secant = (a * fb * wb - b * fa * wa) / (fb * wb - fa * wa);
        let inside = secant > a.min(b) && secant < a.max(b);
        let s = if step % 3 == 2 || !inside { midpoint } else { secant };
        if s == a || s == b {
            break;
        }
        let value = f(s);
        if value.abs() < best.1.abs() {
            best = (s, value);
        }
        if (value < T::zero()) == (fa < T::zero()) {
            (a, fa, wa) = (s, value, T::one());
            wb = if replaced_a == Some(true) { wb * half } else { wb };
            replaced_a = Some(true);
        } else {
            (b, fb, wb) = (s, value, T::one());
            wa = if replaced_a == Some(false) { wa * half } else { wa };
            replaced_a = Some(false);
        }
    }
    best
}
