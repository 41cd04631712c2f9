//! What is known of linear systems without the tool: exactly by characteristic polynomials over the integers, or by
//! other algorithms than the tool's.

use nalgebra::{Complex, DMatrix};

use crate::falsify::exact::Exact;

type Matrix = DMatrix<f64>;

pub(super) fn exact(m: &Matrix) -> Exact {
    let entries: Vec<f64> = (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| m[(i, j)])).collect();
    Exact::from_f64(m.nrows(), m.ncols(), &entries)
}

fn is_finite(m: &Matrix) -> bool {
    m.iter().all(|x| x.is_finite())
}

/// Whether A - L C, formed exactly, has its eigenvalues to the left of -rate; none for entries that are not finite.
pub(super) fn decays(a: &Matrix, l: &Matrix, c: &Matrix, rate: f64) -> Option<bool> {
    if !(is_finite(a) && is_finite(l) && is_finite(c) && rate.is_finite()) {
        return None;
    }
    let shift = Exact::identity(a.nrows()).scaled(&Exact::number(rate));
    Some(exact(a).minus(&exact(l).times(&exact(c))).plus(&shift).is_hurwitz())
}

/// Whether A - L C has its eigenvalues inside the circle of this radius.
pub(super) fn contracts(a: &Matrix, l: &Matrix, c: &Matrix, radius: f64) -> Option<bool> {
    if !(is_finite(a) && is_finite(l) && is_finite(c) && radius > 0.0) {
        return None;
    }
    let closed = exact(a).minus(&exact(l).times(&exact(c)));
    // M/r has the same eigenvalues as M over r: r is brought to the other side, as the denominator of 1/r.
    let (digits, scale) = split(radius);
    let scaled = closed.scaled(&Exact::rational(1.into(), scale, digits.into()));
    Some(scaled.is_schur())
}

/// `radius = digits 2^-scale`.
fn split(radius: f64) -> (u64, i64) {
    let bits = radius.to_bits();
    let biased = ((bits >> 52) & 0x7ff).cast_signed();
    let fraction = bits & ((1 << 52) - 1);
    let (digits, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    (digits, -exponent)
}

/// The part of A that C does not see.
pub(super) fn unseen(a: &Matrix, c: &Matrix) -> Exact {
    Exact::unseen(&exact(a), &exact(c))
}

/// Whether the unseen part decays: an observer exists exactly then.
pub(super) fn is_detectable(a: &Matrix, c: &Matrix, is_discrete: bool) -> bool {
    let part = unseen(a, c);
    part.rows == 0 || if is_discrete { part.is_schur() } else { part.is_hurwitz() }
}

/// The spectral abscissa, to rounding.
pub(super) fn abscissa(m: &Matrix) -> f64 {
    eigenvalues(m).iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max)
}

pub(super) fn radius(m: &Matrix) -> f64 {
    eigenvalues(m).iter().map(|z| z.norm()).fold(0.0, f64::max)
}

/// The eigenvalues, of the balanced matrix.
pub(super) fn eigenvalues(m: &Matrix) -> Vec<Complex<f64>> {
    if !is_finite(m) || m.is_empty() {
        return Vec::new();
    }
    let (mut m, n) = (m.clone(), m.nrows());
    for _ in 0..20 {
        for i in 0..n {
            let row: f64 = (0..n).filter(|j| *j != i).map(|j| m[(i, j)].abs()).sum();
            let column: f64 = (0..n).filter(|j| *j != i).map(|j| m[(j, i)].abs()).sum();
            if row > 0.0 && column > 0.0 {
                let factor = 2f64.powi((0.5 * (row / column).log2()).round() as i32);
                for j in 0..n {
                    m[(i, j)] /= factor;
                }
                for j in 0..n {
                    m[(j, i)] *= factor;
                }
            }
        }
    }
    m.complex_eigenvalues().iter().copied().collect()
}

/// X with `F X + X F' + W = 0`, or `F X F' - X + W = 0`, by its n^2 equations; none if they are singular or the
/// residual is not small.
pub(super) fn covariance(f: &Matrix, w: &Matrix, is_discrete: bool) -> Option<Matrix> {
    let n = f.nrows();
    let one = Matrix::identity(n, n);
    let operator = if is_discrete {
        f.kronecker(f) - Matrix::identity(n * n, n * n)
    } else {
        one.kronecker(f) + f.kronecker(&one)
    };
    let rhs = -Matrix::from_column_slice(n * n, 1, w.as_slice());
    let x = operator.full_piv_lu().solve(&rhs)?;
    let x = Matrix::from_column_slice(n, n, x.as_slice());
    let residual = if is_discrete { f * &x * f.transpose() - &x + w } else { f * &x + &x * f.transpose() + w };
    (residual.amax() <= 1e-8 * w.amax().max(f64::MIN_POSITIVE)).then_some(x)
}

/// The H2 norm from w to H e of `e' = F e + G w`.
pub(super) fn h2_norm(f: &Matrix, g: &Matrix, h: &Matrix, is_discrete: bool) -> Option<f64> {
    let is_stable = if is_discrete { radius(f) < 1.0 } else { abscissa(f) < 0.0 };
    let x = covariance(f, &(g * g.transpose()), is_discrete).filter(|_| is_stable)?;
    let sum = (h * x * h.transpose()).trace();
    (sum >= 0.0).then(|| sum.sqrt())
}

/// The gain of H(s - F)^-1 G at a point of the complex plane.
fn gain_at(f: &Matrix, g: &Matrix, h: &Matrix, s: Complex<f64>) -> Option<f64> {
    let n = f.nrows();
    let complex = |m: &Matrix| m.map(|x| Complex::new(x, 0.0));
    let shifted = DMatrix::from_fn(n, n, |i, j| if i == j { s - f[(i, j)] } else { Complex::new(-f[(i, j)], 0.0) });
    let response = complex(h) * shifted.full_piv_lu().solve(&complex(g))?;
    if response.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let size = response.svd(false, false).singular_values.max();
    size.is_finite().then_some(size)
}

/// The largest gain over a sweep of frequencies: a lower bound of the H-infinity norm.
pub(super) fn swept_norm(f: &Matrix, g: &Matrix, h: &Matrix, is_discrete: bool, points: usize) -> f64 {
    let at = |omega: f64| {
        let s = if is_discrete { Complex::from_polar(1.0, omega) } else { Complex::new(0.0, omega) };
        gain_at(f, g, h, s).unwrap_or(0.0)
    };
    let own = eigenvalues(f);
    let mut all = vec![0.0];
    if is_discrete {
        all.extend((0..=points).map(|k| std::f64::consts::PI * k as f64 / points as f64));
        all.extend(own.iter().map(|z| z.arg().abs()));
    } else {
        let slow = own.iter().map(|z| z.norm()).fold(f64::INFINITY, f64::min).max(1e-12) * 1e-3;
        let fast = own.iter().map(|z| z.norm()).fold(1e-12, f64::max) * 1e3;
        all.extend((0..=points).map(|k| slow * (fast / slow).powf(k as f64 / points as f64)));
        all.extend(own.iter().map(|z| z.im.abs()));
    }
    all.into_iter().map(at).fold(0.0, f64::max)
}

/// The gain of the filter of least H2 norm for E, D with E D' = 0 or not, by the sign of the Hamiltonian matrix
/// (Roberts 1980); with `gamma` that of the H-infinity filter for this bound.
pub(super) fn filter_gain(a: &Matrix, c: &Matrix, [e, d, h]: [&Matrix; 3], gamma: Option<f64>) -> Option<Matrix> {
    let n = a.nrows();
    let r = (d * d.transpose()).try_inverse()?;
    let cross = e * d.transpose() * &r;
    let flow = a - &cross * c;
    let w = e * (Matrix::identity(e.ncols(), e.ncols()) - d.transpose() * &r * d) * e.transpose();
    let mut seen = c.transpose() * &r * c;
    if let Some(gamma) = gamma {
        seen -= h.transpose() * h / (gamma * gamma);
    }
    // P of flow P + P flow' - P seen P + w = 0 from the stable subspace of [flow' -seen; -w -flow].
    let mut z = Matrix::zeros(2 * n, 2 * n);
    z.view_mut((0, 0), (n, n)).copy_from(&flow.transpose());
    z.view_mut((0, n), (n, n)).copy_from(&-&seen);
    z.view_mut((n, 0), (n, n)).copy_from(&-&w);
    z.view_mut((n, n), (n, n)).copy_from(&-&flow);
    for _ in 0..100 {
        let inverse = z.clone().try_inverse()?;
        let factor = (z.norm() / inverse.norm()).sqrt().recip();
        let next = (&z * factor + inverse / factor) * 0.5;
        let change = (&next - &z).norm();
        z = next;
        if change <= 1e-13 * z.norm() {
            break;
        }
    }
    // (sign + I) [I; P] = 0.
    let (s11, s12) = (z.view((0, 0), (n, n)), z.view((0, n), (n, n)));
    let (s21, s22) = (z.view((n, 0), (n, n)), z.view((n, n), (n, n)));
    let one = Matrix::identity(n, n);
    let mut left = Matrix::zeros(2 * n, n);
    left.view_mut((0, 0), (n, n)).copy_from(&s12);
    left.view_mut((n, 0), (n, n)).copy_from(&(s22 + &one));
    let mut right = Matrix::zeros(2 * n, n);
    right.view_mut((0, 0), (n, n)).copy_from(&-(s11 + &one));
    right.view_mut((n, 0), (n, n)).copy_from(&-s21);
    if !is_finite(&left) || !is_finite(&right) {
        return None;
    }
    let p = left.svd(true, true).solve(&right, 1e-14).ok()?;
    let p = (&p + p.transpose()) * 0.5;
    let gain = &p * c.transpose() * r + cross;
    is_finite(&gain).then_some(gain)
}

/// The integral over all times, or the sum over all steps, of |(exp(F t) G)_ij|: the largest errors that inputs of
/// magnitude 1 cause. Computed from below, to a thousandth.
pub(super) fn peak_gains(f: &Matrix, g: &Matrix, is_discrete: bool) -> Option<Matrix> {
    if is_discrete {
        let steps = (30.0 / (1.0 - radius(f)).max(1e-4)).min(2e4) as usize;
        let (mut at, mut sum) = (g.clone(), g.map(f64::abs));
        for _ in 0..steps {
            at = f * at;
            sum += at.map(f64::abs);
        }
        return is_finite(&sum).then_some(sum);
    }
    let own = eigenvalues(f);
    let slow = own.iter().map(|z| -z.re).fold(f64::INFINITY, f64::min);
    let fast = own.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if slow <= 0.0 || fast > 1e5 * slow {
        return None;
    }
    let h = 0.02 / fast;
    let step = (f * h).exp();
    let count = ((12.0 / slow) / h) as usize;
    if count > 400_000 {
        return None;
    }
    // The trapezium rule of the magnitude: its error is below that of the step squared.
    let (mut at, mut sum) = (g.clone(), g.map(|x| 0.5 * x.abs()));
    for _ in 0..count {
        at = &step * at;
        sum += at.map(f64::abs);
    }
    let sum = sum * h * 0.999;
    is_finite(&sum).then_some(sum)
}
