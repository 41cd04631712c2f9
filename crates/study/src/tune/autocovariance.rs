//! Autocovariance least squares: W and V of a linear time-invariant plant from the autocovariances of the innovations
//! of a stationary filter, beside the likelihood and independent of it.
//!
//! With the stable gain L and F = A - L C the innovations of `xhat+ = A xhat + B u + L nu` have, with the noises w and
//! v,
//!
//! ```text
//! P = F P F' + W + L V L',    E nu_k nu_k' = C P C' + V,    E nu_(k+j) nu_k' = C F^j P C' - C F^(j-1) L V
//! ```
//!
//! which is linear in W and V: the autocovariances of the record up to a lag give them by linear least squares over
//! numbers that are not negative, without a search. The standard errors are those of autocovariances of a Gaussian
//! process (Bartlett), through the same least squares.
//!
//! Sources: B. J. Odelson, M. R. Rajamani and J. B. Rawlings, A new autocovariance least-squares method for estimating
//! noise covariances, Automatica 42, 2006; nonnegative least squares: C. L. Lawson and R. J. Hanson, Solving Least
//! Squares Problems, 1974, chapter 23; covariances of autocovariances: P. J. Brockwell and R. A. Davis, Time Series:
//! Theory and Methods, 1991, section 7.2.

use luenberger_linalg::{
    SteinEquation, discrete_kalman_gain, discrete_process_noise, spectral_radius, zero_order_hold,
};
use nalgebra::{DMatrix, DVector};

use super::criterion::Criterion;
use crate::study::{GainSpec, ObserverSpec, Tunable};

/// Lags of the autocovariances, beside lag 0.
const LAGS: usize = 15;

/// The lag beyond which autocovariances count as 0 in Bartlett's formula.
const FAR: i32 = 60;

/// What is left of the first error when the innovations count as stationary.
const SETTLED: f64 = 1e-3;

/// Singular values below this share of the largest say that the autocovariances do not determine the noises.
const SINGULAR: f64 = 1e-8;

/// A parameter that is a variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Variance {
    /// Which of the parameters.
    pub(super) parameter: usize,
    pub(super) value: f64,
    /// The standard error; none at 0.
    pub(super) deviation: Option<f64>,
}

/// W and V.
#[derive(Debug, Clone)]
struct Noises {
    w: DMatrix<f64>,
    v: DMatrix<f64>,
}

impl Noises {
    fn plus(&self, other: &Self, factor: f64) -> Self {
        Self { w: &self.w + &other.w * factor, v: &self.v + &other.v * factor }
    }

    fn size(&self) -> f64 {
        self.w.amax().max(self.v.amax())
    }
}

/// The noises of a filter, W for a step of the plant and V for a sample.
fn noises(of: &ObserverSpec, step: Option<(&DMatrix<f64>, f64)>) -> Option<Noises> {
    let given = match of.kind.whole_gain().map(|linear| &linear.gain) {
        Some(GainSpec::Kalman(noise)) if noise.g.is_none() && noise.s.is_none() => Some([&noise.w, &noise.v]),
        Some(_) => None,
        None => of.kind.noises(),
    };
    let [w, v] = given?;
    let w = match step {
        Some((a, h)) => discrete_process_noise(a, w, h).ok()?,
        None => w.clone(),
    };
    Some(Noises { w, v: v.clone() })
}

/// The variances among the parameters, of the plant and the sensors with these values and the gain of the filter; none
/// where the method does not apply: it needs a linear plant without delays and angles, constant noises whose
/// correlations are 0, and logs in which every output is measured in equally spaced rows.
pub(super) fn variances(criterion: &Criterion<'_>, values: &[f64]) -> Option<Vec<Variance>> {
    let spec = criterion.spec;
    let at = |values: &[f64]| criterion.editable.study(&criterion.edits(values, false).ok()?, false).ok();
    let study = at(values)?;
    let plant = &study.plant;
    let angles = plant.turns_of(&plant.states).is_some() || plant.turns_of(&plant.outputs).is_some();
    let linear = plant.model.linear().filter(|_| !angles && !criterion.has_delays() && study.estimated.is_empty())?;
    let h = criterion.data.iter().map(super::criterion::Data::equal_period).collect::<Option<Vec<f64>>>()?;
    let h = h.first().copied().filter(|first| h.iter().all(|other| (other / first - 1.0).abs() < 1e-6))?;
    let (a, b) = match plant.dt {
        Some(_) => (linear.a.clone(), linear.b.clone()),
        None => zero_order_hold(&linear.a, &linear.b, h).map(|held| (held.ad, held.bd)).ok()?,
    };
    let step = plant.dt.is_none().then_some((&linear.a, h));
    let with = |values: &[f64]| noises(at(values)?.observer(&spec.observer)?, step);
    let own = with(values)?;

    // W and V are what they are without the parameters, and what each adds; correlations would not be linear.
    let all: Vec<usize> =
        (0..values.len()).filter(|k| matches!(spec.parameters[*k].what, Tunable::W(_) | Tunable::V(_))).collect();
    let twice = |which: &[usize]| {
        let mut other = values.to_vec();
        for k in which {
            other[*k] *= 2.0;
        }
        with(&other)
    };
    let part = |k: &usize| {
        let Noises { w, v } = twice(&[*k])?.plus(&own, -1.0);
        Some(Noises { w: w / values[*k], v: v / values[*k] })
    };
    let parts: Vec<Noises> = all.iter().map(part).collect::<Option<_>>()?;
    let known = all.iter().zip(&parts).fold(own.clone(), |sum, (k, part)| sum.plus(part, -values[*k]));
    let sum = all.iter().zip(&parts).fold(known.clone(), |sum, (k, part)| sum.plus(part, 2.0 * values[*k]));
    if all.is_empty() || sum.plus(&twice(&all)?, -1.0).size() > 1e-9 * own.size() {
        return None;
    }

    let l = discrete_kalman_gain(&a, &linear.c, &own.w, &own.v).ok()?.l;
    let model = Model { f: &a - &l * &linear.c, c: linear.c.clone(), l };
    let radius = spectral_radius(&model.f).ok()?;
    let settled = if radius > 0.0 { (SETTLED.ln() / radius.ln()).ceil() as usize } else { 1 };
    let mut records = Vec::new();
    for data in &criterion.data {
        let (inputs, outputs) = data.recorded(&criterion.biases(values))?;
        let mut x = DVector::from_column_slice(&study.observer(&spec.observer)?.initial);
        let mut nu = DMatrix::zeros(outputs.nrows(), outputs.ncols());
        for k in 0..outputs.nrows() {
            let u = inputs.row(k).transpose();
            let mut error = outputs.row(k).transpose() - &linear.c * &x;
            if let Some(d) = &linear.d {
                error -= d * &u;
            }
            x = &a * x + &b * u + &model.l * &error;
            nu.set_row(k, &error.transpose());
        }
        // What is left has to have many times the lags.
        let rows = nu.nrows().checked_sub(settled).filter(|rows| *rows >= 10 * LAGS)?;
        records.push(nu.rows(settled, rows).into_owned());
    }
    let (found, deviations) = fitted(&model, (&known, &parts), &records)?;
    let variance = |((k, value), deviation): ((&usize, f64), Option<f64>)| Variance { parameter: *k, value, deviation };
    Some(all.iter().zip(found).zip(deviations).map(variance).collect())
}

/// A stationary filter.
struct Model {
    f: DMatrix<f64>,
    c: DMatrix<f64>,
    l: DMatrix<f64>,
}

impl Model {
    /// The autocovariances of the innovations for these noises, from lag 0 on.
    fn autocovariances(&self, equation: &mut SteinEquation, noises: &Noises, lags: usize) -> Option<Vec<DMatrix<f64>>> {
        let driving = &noises.w + &self.l * &noises.v * self.l.transpose();
        let p = equation.solve(&((&driving + driving.transpose()) * 0.5)).ok()?.p;
        let mut all = vec![&self.c * &p * self.c.transpose() + &noises.v];
        let mut cross = &self.f * &p * self.c.transpose() - &self.l * &noises.v;
        for _ in 0..lags {
            all.push(&self.c * &cross);
            cross = &self.f * cross;
        }
        Some(all)
    }
}

/// The numbers that fit the autocovariances of the records best, and their standard errors.
fn fitted(
    model: &Model,
    (known, parts): (&Noises, &[Noises]),
    records: &[DMatrix<f64>],
) -> Option<(Vec<f64>, Vec<Option<f64>>)> {
    let p = model.c.nrows();
    let count = |lag: usize| records.iter().map(|nu| (nu.nrows() - lag) as f64).sum::<f64>();
    let sample = |lag: usize| {
        let one = |nu: &DMatrix<f64>| {
            let rows = nu.nrows() - lag;
            nu.rows(lag, rows).transpose() * nu.rows(0, rows)
        };
        records.iter().map(one).fold(DMatrix::zeros(p, p), |sum, one| sum + one) / count(lag)
    };
    let samples: Vec<DMatrix<f64>> = (0..=LAGS).map(sample).collect();
    // In units of the innovations; lag 0 is symmetric.
    let unit: Vec<f64> = (0..p).map(|i| samples[0][(i, i)].sqrt()).collect();
    let entries: Vec<(usize, usize, usize)> = (0..=LAGS)
        .flat_map(|lag| (0..p).flat_map(move |i| (0..p).map(move |j| (lag, i, j))))
        .filter(|(lag, i, j)| *lag > 0 || i <= j)
        .collect();
    let column = |all: &[DMatrix<f64>]| {
        let entry = |(lag, i, j): &(usize, usize, usize)| all[*lag][(*i, *j)] / (unit[*i] * unit[*j]);
        DVector::from_iterator(entries.len(), entries.iter().map(entry))
    };
    let mut equation = SteinEquation::new(&model.f.transpose()).ok()?;
    let rest = column(&samples) - column(&model.autocovariances(&mut equation, known, LAGS)?);
    let mut columns = Vec::new();
    for part in parts {
        columns.push(column(&model.autocovariances(&mut equation, part, LAGS)?));
    }
    let columns = DMatrix::from_columns(&columns);
    let found = nonnegative(&columns, &rest)?;
    let positive: Vec<usize> = (0..found.len()).filter(|k| found[*k] > 0.0).collect();
    let noises = parts.iter().zip(found.iter()).fold(known.clone(), |sum, (part, x)| sum.plus(part, *x));

    // Bartlett's formula, with the autocovariances of what was found.
    let true_ones = model.autocovariances(&mut equation, &noises, FAR as usize)?;
    let at = |lag: i32, i: usize, j: usize| {
        let of = true_ones.get(lag.unsigned_abs() as usize);
        of.map_or(0.0, |of| if lag < 0 { of[(j, i)] } else { of[(i, j)] })
    };
    let covariance = DMatrix::from_fn(entries.len(), entries.len(), |row, other| {
        let ((i, a, b), (j, c, d)) = (entries[row], entries[other]);
        let [lag, other_lag] = [i, j].map(|lag| i32::try_from(lag).unwrap_or(FAR));
        let term = |m: i32| at(m + lag - other_lag, a, c) * at(m, b, d) + at(m + lag, a, d) * at(m - other_lag, b, c);
        let sum: f64 = (-FAR..=FAR).map(term).sum();
        sum / (count(i.min(j)) * unit[a] * unit[b] * unit[c] * unit[d])
    });
    let inverse = columns.select_columns(&positive).pseudo_inverse(SINGULAR).ok()?;
    let of_found = &inverse * covariance * inverse.transpose();
    let mut deviations = vec![None; found.len()];
    for (k, place) in positive.iter().enumerate() {
        deviations[*place] = Some(of_found[(k, k)].max(0.0).sqrt());
    }
    Some((found.iter().copied().collect(), deviations))
}

/// `min |A x - b|` over `x >= 0`, by the active sets of Lawson and Hanson; none if the columns that are used are
/// dependent, or the iterations do not end.
fn nonnegative(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let n = a.ncols();
    let size: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    if size.contains(&0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(a.nrows(), n, |i, j| a[(i, j)] / size[j]);
    let solved = |set: &[usize]| -> Option<DVector<f64>> {
        let svd = scaled.select_columns(set).svd(true, true);
        let singular = svd.singular_values.min() < SINGULAR * svd.singular_values.max();
        if singular { None } else { svd.solve(b, 0.0).ok() }
    };
    let mut x = DVector::zeros(n);
    let mut set: Vec<usize> = Vec::new();
    let small = 1e-12 * b.norm();
    for _ in 0..10 * (n + 1) {
        let slope = scaled.transpose() * (b - &scaled * &x);
        let next = (0..n).filter(|k| !set.contains(k)).max_by(|i, j| slope[*i].total_cmp(&slope[*j]));
        let Some(next) = next.filter(|k| slope[*k] > small) else {
            return Some(DVector::from_fn(n, |k, _| x[k] / size[k]));
        };
        set.push(next);
        loop {
            let to = solved(&set)?;
            if to.iter().all(|x| *x > 0.0) {
                x.fill(0.0);
                set.iter().zip(to.iter()).for_each(|(k, value)| x[*k] = *value);
                break;
            }
            // As far as all stay positive; what becomes 0 leaves the set.
            let blocked = set.iter().zip(to.iter()).filter(|(_, to)| **to <= 0.0);
            let share = blocked.map(|(k, to)| x[*k] / (x[*k] - to)).fold(1.0, f64::min);
            for (k, to) in set.iter().zip(to.iter()) {
                x[*k] += share * (to - x[*k]);
            }
            set.retain(|k| x[*k] > 1e-14 * b.norm());
            if set.is_empty() {
                break;
            }
        }
    }
    None
}
