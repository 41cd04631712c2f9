//! Matrix exponential, and the exact discretisations built on it.
//!
//! With the input held constant over the period `h`, `x' = A x + B u` becomes `x+ = Ad x + Bd u`, `Ad = e^{Ah}`,
//! `Bd = int_0^h e^{As} ds B`: both are blocks of one exponential, `exp([A B; 0 0] h) = [Ad Bd; 0 I]` (Van Loan, IEEE
//! TAC 23, 1978).
//!
//! Method of the exponential: scaling and squaring with the diagonal Pade approximants of degree 3, 5, 7, 9, 13
//! (Higham, SIAM J. Matrix Anal. Appl. 26, 2005), degree and number of squarings chosen from `|A^k|_1^(1/k)` (Al-Mohy
//! and Higham, SIMAX 31, 2009): the backward error is below the unit roundoff, and a nonnormal `A` (an augmented one,
//! say, with a large `B`) is not scaled more than its spectrum asks.

use nalgebra::DMatrix;

use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::balance::Balance;
use crate::{Balanced, LinalgError, Result, balanced};

/// Matrix exponential `e^A`.
///
/// `a` is n x n, finite. The exponential always exists; it is an error if it overflows a double.
///
/// The relative error in the 1-norm is of the order of the unit roundoff times the condition number of the exponential,
/// which is about `|A|` for normal matrices and can be much larger for others (Higham, Functions of Matrices, 2008,
/// chapter 10).
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`], [`LinalgError::Overflow`].
///
/// # Cost
/// `(12 + 2 s) n^3` flops with `s` squarings, about `log2` of the spectral radius of `a`.
///
/// # Example
/// The exponential of a rotation rate is a rotation.
/// ```
/// use luenberger_linalg::expm;
/// use nalgebra::dmatrix;
///
/// let angle: f64 = 0.7;
/// let rotation = expm(&(dmatrix![0.0, -1.0; 1.0, 0.0] * angle))?;
/// let residual = (rotation - dmatrix![angle.cos(), -angle.sin(); angle.sin(), angle.cos()]).norm();
/// println!("residual {residual:e}");
/// assert!(residual < 4.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn expm<'a>(a: impl Into<RealMatrixView<'a>>) -> Result<DMatrix<f64>> {
    let a = &owned(a);
    square("A", a)?;
    let norm = one_norm(a);
    if a.is_empty() || norm == 0.0 {
        return Ok(DMatrix::identity(a.nrows(), a.nrows()));
    }
    let result = exponential(a, a.nrows());
    if result.iter().all(|x| x.is_finite()) { Ok(result) } else { Err(LinalgError::Overflow { what: "e^A" }) }
}

/// A plant discretised with its input held over each period: `x+ = Ad x + Bd u`.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroOrderHold {
    /// `e^{Ah}`, n x n.
    pub ad: DMatrix<f64>,
    /// `int_0^h e^{As} ds B`, n x m.
    pub bd: DMatrix<f64>,
}

/// Zero-order hold of `x' = A x + B u` at the period `h`: `x+ = Ad x + Bd u`, exact for `u` constant over each period.
///
/// `a` is n x n, `b` n x m (m = 0 is allowed), `h > 0` in the unit of time of `a`. `A` need not be invertible.
///
/// # Errors
/// [`LinalgError::InvalidPeriod`] for `h <= 0`, infinite or NaN; [`LinalgError::DimensionMismatch`],
/// [`LinalgError::NotSquare`], [`LinalgError::NotFinite`]; [`LinalgError::Overflow`] if the plant grows past the range
/// of a double within one period.
///
/// # Cost
/// One exponential of order n + m.
///
/// # Example
/// The double integrator, against the formula of every textbook.
/// ```
/// use luenberger_linalg::zero_order_hold;
/// use nalgebra::dmatrix;
///
/// let h: f64 = 0.1;
/// let sampled = zero_order_hold(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0; 1.0], h)?;
/// let residual = (sampled.ad - dmatrix![1.0, h; 0.0, 1.0]).norm() + (sampled.bd - dmatrix![h * h / 2.0; h]).norm();
/// println!("residual {residual:e}");
/// assert!(residual <= 2.0 * f64::EPSILON);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems, section 4.3; Van Loan, IEEE TAC 23, 1978.
pub fn zero_order_hold<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    h: f64,
) -> Result<ZeroOrderHold> {
    held(&owned(a), &owned(b), h)
}

fn held(a: &DMatrix<f64>, b: &DMatrix<f64>, h: f64) -> Result<ZeroOrderHold> {
    square("A", a)?;
    shaped("B", b, a.nrows(), b.ncols())?;
    let (ad, bd) = hold(a, b, h)?;
    Ok(ZeroOrderHold { ad, bd })
}

/// A linear observer discretised with `u` and `y` held over each period: `xhat+ = Fd xhat + Bd u + Ld y`.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroOrderHoldObserver {
    /// `e^{(A - LC)h}`, n x n.
    pub fd: DMatrix<f64>,
    /// `int_0^h e^{(A-LC)s} ds B`, n x m.
    pub bd: DMatrix<f64>,
    /// `int_0^h e^{(A-LC)s} ds L`, n x p.
    pub ld: DMatrix<f64>,
}

/// Zero-order hold of the Luenberger observer `xhat' = A xhat + B u + L (y - C xhat) = (A - LC) xhat + B u + L y` at
/// the period `h`: `xhat+ = Fd xhat + Bd u + Ld y`, exact for `u` and `y` constant over each period.
///
/// `a` is n x n, `b` n x m, `l` n x p, `c` p x n, `h > 0`. The eigenvalues of `Fd` are `e^{lambda h}` for those of
/// `A - LC`: the sampled observer is stable at every `h` if the continuous one is. Note what it holds: the output of a
/// plant moves within the period, so that the estimate of a moving plant lags by a term of the order of `h` that a gain
/// designed in discrete time does not have.
///
/// # Errors
/// As [`zero_order_hold`].
///
/// # Cost
/// One exponential of order n + m + p.
///
/// # Example
/// An observer at rest in an equilibrium of the plant stays there: `xhat = Fd xhat + Bd u + Ld C xhat` if
/// `A xhat + B u = 0`.
/// ```
/// use luenberger_linalg::zero_order_hold_observer;
/// use nalgebra::{dmatrix, dvector};
///
/// let (a, b, c) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
/// let observer = zero_order_hold_observer(&a, &b, &dmatrix![7.0; 10.0], &c, 0.05)?;
/// let (x, u) = (dvector![1.0, 0.0], dvector![2.0]);
/// let residual = (&observer.fd * &x + &observer.bd * u + &observer.ld * (c * &x) - x).norm();
/// println!("residual {residual:e}");
/// assert!(residual < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn zero_order_hold_observer<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    l: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    h: f64,
) -> Result<ZeroOrderHoldObserver> {
    held_observer(&owned(a), &owned(b), &owned(l), &owned(c), h)
}

fn held_observer(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    l: &DMatrix<f64>,
    c: &DMatrix<f64>,
    h: f64,
) -> Result<ZeroOrderHoldObserver> {
    square("A", a)?;
    let n = a.nrows();
    shaped("B", b, n, b.ncols())?;
    shaped("C", c, c.nrows(), n)?;
    shaped("L", l, n, c.nrows())?;
    let f = a - l * c;
    if f.iter().any(|x| !x.is_finite()) {
        return Err(LinalgError::Overflow { what: "A - LC" });
    }
    let (m, p) = (b.ncols(), l.ncols());
    let inputs = DMatrix::from_fn(n, m + p, |i, j| if j < m { b[(i, j)] } else { l[(i, j - m)] });
    let (fd, both) = hold(&f, &inputs, h)?;
    Ok(ZeroOrderHoldObserver { fd, bd: both.columns(0, m).into_owned(), ld: both.columns(m, p).into_owned() })
}

/// `e^{Ah}` and `int_0^h e^{As} ds B` for shapes that fit.
pub(crate) fn hold(a: &DMatrix<f64>, b: &DMatrix<f64>, h: f64) -> Result<(DMatrix<f64>, DMatrix<f64>)> {
    if !(h > 0.0 && h.is_finite()) {
        return Err(LinalgError::InvalidPeriod { h });
    }
    let (n, m) = b.shape();
    // Bd is linear in B: columns brought to the size of A by powers of two cost no accuracy and save squarings.
    let size = one_norm(a).max(1.0 / h);
    let power = |j: usize| {
        let column = b.column(j).amax();
        if column > 0.0 { (size.log2() - column.log2()).round().clamp(-1000.0, 1000.0) as i32 } else { 0 }
    };
    let powers: Vec<i32> = (0..m).map(power).collect();
    let mut augmented = DMatrix::zeros(n + m, n + m);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(a * h));
    for j in 0..m {
        for i in 0..n {
            augmented[(i, n + j)] = crate::units::shift(b[(i, j)], powers[j]) * h;
        }
    }
    let overflow = LinalgError::Overflow { what: "e^{Ah}" };
    if augmented.iter().any(|x| !x.is_finite()) {
        return Err(overflow);
    }
    let e = exponential(&augmented, n);
    let ad = e.view((0, 0), (n, n)).into_owned();
    let bd = DMatrix::from_fn(n, m, |i, j| crate::units::shift(e[(i, n + j)], -powers[j]));
    if ad.iter().chain(bd.iter()).all(|x| x.is_finite()) { Ok((ad, bd)) } else { Err(overflow) }
}

/// Largest `|A^k|^(1/k)` at which the approximant of degree m has backward error below 2^-53 (Higham 2005, table 2.3;
/// for degree 13 the smaller bound of Al-Mohy and Higham 2009, (5.4), that also keeps the denominator well
/// conditioned).
const THETA: [(usize, f64); 4] =
    [(3, 1.495585217958292e-2), (5, 2.53939833006323e-1), (7, 9.504178996162932e-1), (9, 2.097847961257068)];
const THETA_13: f64 = 4.25;

/// Coefficients of the numerators, constant term first (Higham 2005, (2.3); the denominators alternate the signs).
const PADE_3: [f64; 4] = [120.0, 60.0, 12.0, 1.0];
const PADE_5: [f64; 6] = [30240.0, 15120.0, 3360.0, 420.0, 30.0, 1.0];
const PADE_7: [f64; 8] = [17297280.0, 8648640.0, 1995840.0, 277200.0, 25200.0, 1512.0, 56.0, 1.0];
const PADE_9: [f64; 10] =
    [17643225600.0, 8821612800.0, 2075673600.0, 302702400.0, 30270240.0, 2162160.0, 110880.0, 3960.0, 90.0, 1.0];
const PADE_13: [f64; 14] = [
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
];

/// Finite square nonempty input; the answer may hold infinities or NaN if it does not fit a double. The last states,
/// from `inputs` on, are those of inputs: their rows lead to each other alone, and their units are free.
///
/// In one that takes many squarings, isolated eigenvalues come to the diagonal, where their exponentials are known at
/// each squaring: repeated squaring alone would leave a slow one `2^squarings eps` of its digits.
///
/// Units of the state that are decades apart are balanced first. Where that does not make the matrix smaller, units and
/// entries that are rounding look alike (Watkins, ETNA 23, 2006): then each entry is that of less error, of `eps
/// ||e^A||` in the units given and of `eps ||e^B|| d_i / d_j` in balanced ones, `A = D B D^-1`, unless the norms say
/// that this error is the same for all of them.
pub(crate) fn exponential(a: &DMatrix<f64>, inputs: usize) -> DMatrix<f64> {
    let size = one_norm(a);
    if size <= FEW_SQUARINGS && is_balanced(a, inputs) {
        return scaled_and_squared(a, &[]);
    }
    let Ok(Balanced { permutation: order, active, .. }) = balanced(a) else {
        return DMatrix::from_element(a.nrows(), a.nrows(), f64::NAN);
    };
    let n = a.nrows();
    let isolated: Vec<usize> = (0..n).filter(|k| !active.contains(k)).collect();
    let of = |a: &DMatrix<f64>| {
        let e = scaled_and_squared(&DMatrix::from_fn(n, n, |i, j| a[(order[i], order[j])]), &isolated);
        let mut back = DMatrix::zeros(n, n);
        for j in 0..n {
            for i in 0..n {
                back[(order[i], order[j])] = e[(i, j)];
            }
        }
        back
    };
    let units = Balance::fitted(a);
    if units.ratio() <= NEARBY {
        return of(a);
    }
    let within = units.similar(a);
    let balanced = of(&within);
    let found = units.similar_back(&balanced);
    let (of_found, of_balanced) = (one_norm(&found), one_norm(&balanced));
    if one_norm(&within) * NEARBY <= size || of_balanced * units.ratio() <= FEW_SQUARINGS * of_found {
        return found;
    }
    let given = of(a);
    let of_given = one_norm(&given);
    let ratios = units.similar_back(&DMatrix::from_element(n, n, 1.0));
    DMatrix::from_fn(n, n, |i, j| if of_given < of_balanced * ratios[(i, j)] { given[(i, j)] } else { found[(i, j)] })
}

/// Units whose ratio is less than this cost a digit at most.
const NEARBY: f64 = 16.0;

/// Below this norm the loss by squaring is less than two digits.
const FEW_SQUARINGS: f64 = 64.0;

/// Whether the largest entries of each row and of its column, off the diagonal, are within a factor of 16 (or one of
/// them is zero: there is nothing to balance), for the states before `inputs` and among them.
fn is_balanced(a: &DMatrix<f64>, inputs: usize) -> bool {
    let (n, entries) = (a.nrows(), a.as_slice());
    (0..inputs).all(|i| {
        let (row, column) = (entries[i..].iter().step_by(n), entries[i * n..].iter());
        let (mut of_row, mut of_column) = (0.0_f64, 0.0_f64);
        for (j, (x, y)) in row.zip(column).take(inputs).enumerate() {
            if j != i {
                of_row = if x.abs() > of_row { x.abs() } else { of_row };
                of_column = if y.abs() > of_column { y.abs() } else { of_column };
            }
        }
        of_row == 0.0 || of_column == 0.0 || (of_row <= 16.0 * of_column && of_column <= 16.0 * of_row)
    })
}

/// The rows and columns `isolated` are triangular with respect to each other and to the rest: their eigenvalues are
/// diagonal entries.
fn scaled_and_squared(a: &DMatrix<f64>, isolated: &[usize]) -> DMatrix<f64> {
    let a2 = a * a;
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let root = |m: &DMatrix<f64>, k: i32| one_norm(m).powf(1.0 / f64::from(k));
    let (d4, d6) = (root(&a4, 4), root(&a6, 6));
    let (d8, d10) = (root(&(&a4 * &a4), 8), root(&(&a4 * &a6), 10));
    let eta = [d4.max(d6), d4.max(d6), d6.max(d8), d6.max(d8)];
    for ((degree, theta), eta) in THETA.into_iter().zip(eta) {
        if eta <= theta && more_squarings(a, degree) == 0 {
            let powers = [DMatrix::identity(a.nrows(), a.nrows()), a2.clone(), a4.clone(), a6.clone(), &a4 * &a4];
            return match degree {
                3 => low_degree(a, &powers, &PADE_3),
                5 => low_degree(a, &powers, &PADE_5),
                7 => low_degree(a, &powers, &PADE_7),
                _ => low_degree(a, &powers, &PADE_9),
            };
        }
    }
    // Powers that overflow leave the plain norm, as in Higham 2005.
    let eta = d6.max(d8).min(d8.max(d10));
    let eta = if eta.is_finite() { eta } else { one_norm(a) };
    let mut squarings = (eta / THETA_13).log2().ceil().clamp(0.0, 1100.0) as i32;
    squarings += more_squarings(&(a * 2f64.powi(-squarings)), 13);
    let scaled = a * 2f64.powi(-squarings);
    let mut e = degree_13(&scaled);
    // Al-Mohy and Higham 2009, code fragment 2.1.
    let correct = |e: &mut DMatrix<f64>, power: i32| {
        for &k in isolated {
            e[(k, k)] = (a[(k, k)] * 2f64.powi(-power)).exp();
        }
    };
    correct(&mut e, squarings);
    for k in (0..squarings).rev() {
        e = &e * &e;
        correct(&mut e, k);
    }
    e
}

/// The squarings that nonnormality asks for beyond `|A^k|^(1/k)`: `l_m(A)` of Al-Mohy and Higham 2009, (5.1).
fn more_squarings(a: &DMatrix<f64>, degree: usize) -> i32 {
    // 1/|c_{2m+1}|: first coefficient of the backward error series.
    let reciprocal = match degree {
        3 => 100800.0,
        5 => 10059033600.0,
        7 => 4487938430976000.0,
        9 => 5914384781877411840000.0,
        _ => 113250775606021113483283660800000000.0,
    };
    let (n, norm) = (a.nrows(), one_norm(a));
    if norm == 0.0 || !norm.is_finite() {
        return 0;
    }
    // log2 of | |A|^(2m+1) |_1, normalised on the way so that it cannot overflow.
    let absolute = a.map(|x| x.abs() / norm);
    let mut row = nalgebra::RowDVector::from_element(n, 1.0);
    let mut log = 0.0;
    for _ in 0..=2 * degree {
        row = &row * &absolute;
        let largest = row.amax();
        if largest == 0.0 {
            return 0;
        }
        row /= largest;
        log += largest.log2();
    }
    // alpha = | |A|^(2m+1) | / (|A| / |c|), with the normalisation put back.
    let log_alpha = log + 2.0 * degree as f64 * norm.log2() - f64::log2(reciprocal);
    ((log_alpha + 53.0) / (2.0 * degree as f64)).ceil().clamp(0.0, 1100.0) as i32
}

/// Degrees 3 to 9 from the even powers `I, A^2, A^4, ..`.
fn low_degree(a: &DMatrix<f64>, powers: &[DMatrix<f64>], coefficients: &[f64]) -> DMatrix<f64> {
    let n = a.nrows();
    let (mut odd, mut even) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for (pair, power) in coefficients.chunks(2).zip(powers) {
        even += power * pair[0];
        odd += power * pair[1];
    }
    quotient(&(a * odd), &even)
}

fn degree_13(a: &DMatrix<f64>) -> DMatrix<f64> {
    let b = &PADE_13;
    let one = DMatrix::identity(a.nrows(), a.nrows());
    let a2 = a * a;
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let odd = &a6 * (&a6 * b[13] + &a4 * b[11] + &a2 * b[9]) + &a6 * b[7] + &a4 * b[5] + &a2 * b[3] + &one * b[1];
    let even = &a6 * (&a6 * b[12] + &a4 * b[10] + &a2 * b[8]) + &a6 * b[6] + &a4 * b[4] + &a2 * b[2] + &one * b[0];
    quotient(&(a * odd), &even)
}

/// `(V - U)^-1 (V + U)`, or NaN if `V - U` is singular. It is well conditioned for the norms at which each degree is
/// used.
fn quotient(u: &DMatrix<f64>, v: &DMatrix<f64>) -> DMatrix<f64> {
    let n = u.nrows();
    (v - u).lu().solve(&(v + u)).unwrap_or_else(|| DMatrix::from_element(n, n, f64::NAN))
}

/// The largest sum of the sizes of a column's entries.
pub(crate) fn one_norm(m: &DMatrix<f64>) -> f64 {
    m.column_iter().map(|column| column.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max)
}
