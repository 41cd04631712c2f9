//! Reasons why there is no common gain: an unobservable direction, or vertices that exclude each other.

use luenberger_linalg::{detectability, observability};
use luenberger_lmi::{Infeasibility, Problem, Settings, proof_matrix};
use luenberger_proof::statement::{HiddenMotion, hidden_motion};
use luenberger_proof::{Exact, Matrix, Verdict};
use nalgebra::{Complex, DMatrix, DVector};

use super::error::{Conflict, HiddenMode, LpvError};
use super::polytope::Polytope;
use crate::enclosure::Entry;
use crate::error::{DesignError, NearlyHidden};
use crate::gain_lmi::{self, decrease_at};
use crate::gain_options::Checked;
use crate::number::short;

/// How many pairs of vertices are examined for one that is infeasible by itself.
const PAIRS: usize = 200;

/// The error if no gain was proved for the polytope at this rate. A hidden mode is unobservable in exact arithmetic; a
/// mode that is unobservable only in floating point is reported with an undecided verdict.
pub(super) fn explain(
    polytope: &Polytope,
    rate: f64,
    verdict: Verdict<Infeasibility>,
    settings: &Settings,
) -> LpvError {
    let candidates = |weights: Option<&[f64]>| -> Seen {
        let vertices = polytope.vertices.iter().map(|v| (v.to_string(), v.a.clone(), v.c.clone()));
        let inside = |(a, c): (DMatrix<f64>, DMatrix<f64>)| {
            let at = |entry: &Entry| {
                let matrix = if entry.of_output { &c } else { &a };
                format!("{entry} = {}", short(matrix[(entry.row, entry.column)]))
            };
            let entries: Vec<String> = polytope.varying.0.iter().map(at).collect();
            (format!("the interior point {}", entries.join(", ")), a, c)
        };
        let mut pairs: Vec<_> = vertices.collect();
        pairs.push(inside(polytope.inner(false)));
        pairs.push(inside(polytope.inner(true)));
        pairs.extend(weights.map(|w| inside(mean(polytope, w))));
        let mut nearly = None;
        for (place, a, c) in pairs {
            match hidden_mode(place, a, c, rate) {
                Seen::Nothing => {}
                Seen::Nearly(mode) => nearly = nearly.or(Some(mode)),
                hidden @ Seen::Hidden(_) => return hidden,
            }
        }
        nearly.map_or(Seen::Nothing, Seen::Nearly)
    };
    match verdict {
        Verdict::Refuted { witness } => {
            let weights: Vec<f64> = (0..polytope.vertices.len())
                .map(|k| {
                    witness.multipliers.iter().find(|m| m.constraint == decrease_at(k)).map_or(0.0, |m| m.z.trace())
                })
                .collect();
            match candidates(Some(&weights)) {
                Seen::Hidden(mode) => LpvError::HiddenMode(mode),
                _ => LpvError::Conflict(Box::new(conflict(polytope, rate, witness, &weights, settings))),
            }
        }
        Verdict::Undecided { why, best } => {
            let seen = match candidates(None) {
                Seen::Hidden(mode) => return LpvError::HiddenMode(mode),
                Seen::Nearly(mode) => Some(Box::new(mode)),
                Seen::Nothing => None,
            };
            DesignError::Undecided { what: gain_lmi::WHAT, why, best, seen }.into()
        }
        proved @ Verdict::Proved { .. } => DesignError::not_proved(gain_lmi::WHAT, Some(proved)).into(),
    }
}

/// The mean of the vertices with these weights. An entry that is a millionth of its range away from 0 is set to 0, if
/// that is within: the weights come from a solver, and detectability makes a difference between 0 and almost 0.
fn mean(polytope: &Polytope, weights: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
    let (mut a, mut c) = polytope.inner(false);
    let total: f64 = weights.iter().sum();
    for (which, entry) in polytope.varying.0.iter().enumerate() {
        let ends = polytope.vertices.iter().map(|vertex| vertex.at[which].1);
        let (lo, hi) = ends.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let mean = ends.zip(weights).map(|(x, w)| x * w).sum::<f64>() / total;
        let vanishes = lo <= 0.0 && hi >= 0.0 && mean.abs() <= 1e-6 * (hi - lo);
        let matrix = if entry.of_output { &mut c } else { &mut a };
        if mean.is_finite() {
            matrix[(entry.row, entry.column)] = if vanishes { 0.0 } else { mean.clamp(lo, hi) };
        }
    }
    (a, c)
}

/// The unobservable modes of a pair, at the specified rate.
enum Seen {
    Nothing,
    /// In floating point only.
    Nearly(NearlyHidden),
    /// In exact arithmetic.
    Hidden(Box<HiddenMode>),
}

/// Candidates come from floating point; exact arithmetic decides.
fn hidden_mode(place: String, a: DMatrix<f64>, c: DMatrix<f64>, rate: f64) -> Seen {
    let n = a.nrows();
    let Ok(pair) = detectability(&(&a + DMatrix::identity(n, n) * rate), &c) else { return Seen::Nothing };
    let Some(mode) = pair.undetectable_modes.into_iter().next() else { return Seen::Nothing };
    let motion = hidden_motion(&proof_matrix(&a), &proof_matrix(&c)).ok().flatten();
    let motion = motion.filter(|motion| motion.decays_at(rate) == Some(false));
    if let Some(((eigenvalue, direction), witness)) = motion.and_then(|witness| Some((slowest(&witness)?, witness))) {
        return Seen::Hidden(Box::new(HiddenMode { rate, place, a, c, eigenvalue, direction, witness }));
    }
    let (eigenvalue, margin) = (mode.eigenvalue - Complex::new(rate, 0.0), mode.margin);
    Seen::Nearly(NearlyHidden { place: Some(place), eigenvalue, margin })
}

/// The eigenvalue of the largest real part of a hidden motion, with its direction, the largest component of which is
/// made positive. In floating point.
fn slowest(hidden: &HiddenMotion) -> Option<(Complex<f64>, DVector<Complex<f64>>)> {
    let over_divisor =
        |m: &Matrix<Exact>| DMatrix::from_fn(m.rows(), m.cols(), |i, j| ratio(&m[(i, j)], &hidden.divisor));
    let (motion, basis) = (over_divisor(&hidden.motion), over_divisor(&hidden.basis));
    // All its modes are hidden from an output that is 0.
    let all = observability(&motion, &DMatrix::zeros(1, motion.nrows())).ok()?.unobservable;
    let mode = all.into_iter().max_by(|x, y| x.eigenvalue.re.total_cmp(&y.eigenvalue.re))?;
    let direction = basis.map(Complex::from) * mode.direction;
    let largest = direction.iter().copied().max_by(|x, y| x.norm().total_cmp(&y.norm()))?;
    let factor = largest.conj() / (largest.norm() * direction.norm());
    factor.is_finite().then(|| (mode.eigenvalue, direction * factor))
}

/// `x / d` to rounding, of numbers of any size.
fn ratio(x: &Exact, d: &Exact) -> f64 {
    match (x.magnitude_exponent(), d.magnitude_exponent()) {
        (Some(e), Some(f)) => {
            let power = i32::try_from((e - f).clamp(-2000, 2000)).unwrap_or(0);
            x.shifted(-e).round_down() / d.shifted(-f).round_down() * 2f64.powi(power)
        }
        _ => 0.0,
    }
}

impl Conflict {
    /// All vertices whose inequalities take part in the contradiction.
    pub(super) fn of(polytope: &Polytope, rate: f64, witness: Infeasibility) -> Self {
        let takes_part = |k: &usize| witness.multipliers.iter().any(|m| m.constraint == decrease_at(*k));
        let vertices: Vec<usize> = (0..polytope.vertices.len()).filter(takes_part).collect();
        let places = vertices.iter().map(|k| polytope.vertices[*k].to_string()).collect();
        Self { rate, is_pair: vertices.len() == 2, vertices, places, witness }
    }
}

/// Two of the vertices that take part, if two are infeasible by themselves; else all of them.
fn conflict(polytope: &Polytope, rate: f64, witness: Infeasibility, weights: &[f64], settings: &Settings) -> Conflict {
    let mut involved: Vec<usize> = (0..weights.len()).filter(|k| weights[*k] > 0.0).collect();
    // The heaviest first: they carry the contradiction.
    involved.sort_by(|i, j| weights[*j].total_cmp(&weights[*i]));
    let pairs = (1..involved.len()).flat_map(|j| (0..j).map(move |i| (i, j))).take(PAIRS);
    let pair = pairs.map(|(i, j)| [involved[i], involved[j]]).find_map(|pair| {
        let mut lmi = Problem::new();
        gain_lmi::pose(
            &mut lmi,
            pair.iter().map(|&k| (k, &polytope.vertices[k].a, &polytope.vertices[k].c)),
            rate,
            &Checked::default(),
        );
        match lmi.solve_with(settings).ok()?.verdict {
            Verdict::Refuted { witness } => Some((pair.to_vec(), witness)),
            _ => None,
        }
    });
    let Some((mut vertices, witness)) = pair else { return Conflict::of(polytope, rate, witness) };
    vertices.sort_unstable();
    let places = vertices.iter().map(|k| polytope.vertices[*k].to_string()).collect();
    Conflict { rate, vertices, places, is_pair: true, witness }
}
