//! Injectivity of (phi, h) on the box: measured over pairs, refuted by two states with one image, proved by one matrix.
//!
//! The proof: over a box of states, which is convex, `Phi(x) - Phi(x') = J (x - x')` with J, the mean of Jacobians over
//! the segment, in the enclosure of DPhi over the box. If for one matrix M `M J + J'M' > 0` for every J of the
//! enclosure, `(x - x')'M (Phi(x) - Phi(x')) > 0` for all x, x' of the box that differ, and their images differ too. M
//! is the pseudo-inverse of the middle of the enclosure, with states in half-widths of the box; it is not the only
//! matrix that could do it. It is asked for only where Phi is known to be continuous: where it has a collected form, or
//! leaves no comparison open on the box.
//!
//! The refutation: [`common_image`](super::common_image). Two images that are only close are not a refutation, and are
//! reported as a near collision.

use luenberger_plants::Dimensions;
use luenberger_proof::{Interval, Matrix, Ring, UndecidedReason, Verdict, positive_definite};
use nalgebra::{DMatrix, DVector};

use super::candidate::Pieces;
use super::common_image::{Form, by_box, by_symmetry};
use super::error::KklError;
use super::images::Images;
use super::witness::{CommonImage, TwoStates};
use crate::enclosure::{IntervalDual, Region, enclose};
use crate::separation::{DISTANT, Ratios, ratios, second_preimage};
use crate::symbolic_polynomial::SymbolicPolynomial;

/// How well (phi, h) separates the states of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Injectivity {
    /// The smallest `|Phi(x) - Phi(x')| / |x - x'|` over the pairs of samples.
    pub smallest_ratio: f64,
    /// The pair that has it.
    pub pair: (Vec<f64>, Vec<f64>),
    /// The largest such ratio.
    pub largest_ratio: f64,
    /// The smallest singular value of DPhi at the samples: over one of it, noise in xi and y is amplified.
    pub smallest_singular_value: f64,
    /// Where.
    pub flattest: Vec<f64>,
    /// Samples.
    pub points: usize,
    /// Two states, a quarter of a half-width apart or more, whose images are apart less than `sqrt(EPSILON)` of the
    /// largest ratio times their distance: no left inverse computed in binary64 tells them apart well. The closest that
    /// were found; none where none were.
    pub near_collision: Option<TwoStates>,
    /// Whether phi and h are known to be continuous on the box: they have a collected form, or leave no comparison
    /// open.
    pub continuous: bool,
    /// Proved, at every time of the region: the smallest eigenvalue of `M J + J'M'` is at least twice the margin for
    /// every J of the enclosure, with M J = I in the middle, so that a margin of 1 is that of an affine Phi. Refuted:
    /// two states have one image, verified.
    pub verdict: Verdict<CommonImage>,
}

/// The numbers over `points`, and the verdict over the box `axes` (states, inputs, time).
pub(super) fn injectivity<C: Pieces<IntervalDual> + Pieces<SymbolicPolynomial>>(
    candidate: &C,
    order: usize,
    (points, axes): (&[Vec<Interval>], &[Interval]),
    subdivisions: usize,
) -> Result<Injectivity, KklError> {
    let size = Pieces::<IntervalDual>::plant_dimensions(candidate);
    let n = size.states;
    let images = Images { candidate, size: Dimensions { states: n, inputs: 0, outputs: order + size.outputs } };
    let bound = |bound: fn(&Interval) -> f64| DVector::from_iterator(n, axes[..n].iter().map(bound));
    let (lower, upper) = (bound(Interval::lo), bound(Interval::hi));
    // A coordinate that is one number separates nothing and needs no separation.
    let half = (&upper - &lower).map(|width| if width > 0.0 { 0.5 * width } else { 1.0 });
    let varying: Vec<usize> = (0..n).filter(|&k| upper[k] > lower[k]).collect();
    let undefined = |x: &DVector<f64>| KklError::Undefined {
        operation: "(phi, h) or its derivative",
        state: x.iter().copied().collect(),
        input: Vec::new(),
    };
    let (mut smallest_singular_value, mut flattest) = (f64::INFINITY, Vec::new());
    let mut samples = Vec::with_capacity(points.len());
    let time = points.first().map_or(0.0, |point| point[n + size.inputs].lo());
    for point in points {
        let x = DVector::from_iterator(n, point[..n].iter().map(Interval::lo));
        if samples.iter().any(|(other, _): &(DVector<f64>, DVector<f64>)| *other == x) {
            continue;
        }
        let (image, jacobian) = images.with_jacobian(time, &x).ok_or_else(|| undefined(&x))?;
        let jacobian = jacobian.select_columns(&varying);
        let sigma = if varying.is_empty() {
            f64::INFINITY
        } else if jacobian.nrows() < jacobian.ncols() {
            0.0
        } else {
            jacobian.singular_values().min()
        };
        if sigma < smallest_singular_value || flattest.is_empty() {
            (smallest_singular_value, flattest) = (sigma, x.iter().copied().collect());
        }
        samples.push((x, image));
    }
    let Ratios { smallest: (smallest_ratio, i, j), largest: largest_ratio, suspects } = ratios(&samples, &half);
    let of = |k: usize| samples.get(k).map_or_else(Vec::new, |(x, _)| x.iter().copied().collect());
    let limit = f64::EPSILON.sqrt() * largest_ratio;
    let mut near_collision: Option<TwoStates> = None;
    let mut pairs = Vec::with_capacity(suspects.len());
    for (_, i, j) in suspects {
        let (x, z) = &samples[i];
        let map = |x: &DVector<f64>| images.with_jacobian(time, x).ok_or_else(|| undefined(x));
        let (second, _) = second_preimage(map, z, samples[j].0.clone(), (&lower, &upper))?;
        let apart = &second - x;
        if apart.component_div(&half).norm() < DISTANT {
            continue;
        }
        let Some(gap) = images.point(time, x, None).zip(images.point(time, &second, None)).and_then(|(x, second)| {
            let mut squares = x.iter().zip(&second).map(|(x, second)| x.value().sub(&second.value()).powi(2));
            squares.try_fold(Interval::zero(), |sum, square| Some(sum.add(&square?)))?.sqrt()
        }) else {
            continue;
        };
        let distance = apart.norm();
        let closer = |other: &TwoStates| gap.hi() / distance < other.gap / other.distance;
        if gap.hi() <= limit * distance && near_collision.as_ref().is_none_or(closer) {
            let state = |x: &DVector<f64>| x.iter().copied().collect();
            near_collision = Some(TwoStates { first: state(x), second: state(&second), distance, gap: gap.hi() });
        }
        pairs.push((x.clone(), second));
    }
    let form = Form::of(candidate);
    let continuous = form.is_some() || images.is_unbranched_over(axes);
    let unknown =
        Verdict::Undecided { why: UndecidedReason::DataTooUncertain { width: f64::INFINITY }, best: f64::NAN };
    let mut verdict = if continuous { proof(&images, &varying, &half, axes, subdivisions)? } else { unknown };
    if !verdict.is_proved() {
        // On the border of the box a solution has no box around it: the same pairs, nearer to the middle, too.
        let centre = (&lower + &upper) * 0.5;
        let shrunk = |x: &DVector<f64>| &centre + (x - &centre) * 0.875;
        let inner: Vec<_> = pairs.iter().map(|(x, z)| (shrunk(x), shrunk(z))).collect();
        let solved =
            || pairs.iter().chain(&inner).find_map(|(x, z)| by_box(&images, form.as_ref(), (x, z), (time, axes)));
        if let Some(witness) = by_symmetry(candidate, (points, axes)).or_else(solved) {
            verdict = Verdict::Refuted { witness };
        }
    }
    Ok(Injectivity {
        smallest_ratio,
        pair: (of(i), of(j)),
        largest_ratio,
        smallest_singular_value,
        flattest,
        points: samples.len(),
        near_collision,
        continuous,
        verdict,
    })
}

/// `M J + J'M' > 0` over the box.
fn proof<C: Pieces<IntervalDual>>(
    images: &Images<'_, C>,
    varying: &[usize],
    half: &DVector<f64>,
    axes: &[Interval],
    subdivisions: usize,
) -> Result<Verdict<CommonImage>, KklError> {
    let n = images.size.states;
    let unknown =
        Verdict::Undecided { why: UndecidedReason::DataTooUncertain { width: f64::INFINITY }, best: f64::NAN };
    let states: Vec<(f64, f64)> = axes[..n].iter().map(|axis| (axis.lo(), axis.hi())).collect();
    let time = axes.last().copied().unwrap_or(Interval::UNBOUNDED);
    let region = Region::new(&states).time(time.lo(), time.hi()).subdivisions(subdivisions);
    // What has no derivative somewhere is not refuted by that.
    let Ok(enclosure) = enclose(images, &region) else { return Ok(unknown) };
    let rows = enclosure.c.rows();
    let scaled = Matrix::from_fn(rows, varying.len(), |i, j| {
        Interval::from_f64(half[varying[j]]).map_or(Interval::UNBOUNDED, |half| enclosure.c[(i, varying[j])].mul(&half))
    });
    let middle = DMatrix::from_fn(rows, varying.len(), |i, j| scaled[(i, j)].midpoint());
    if varying.is_empty() {
        return Ok(Verdict::Proved { margin: f64::INFINITY });
    }
    if !middle.iter().all(|entry| entry.is_finite()) {
        return Ok(unknown);
    }
    // Rows of one size, lest the units of an output decide.
    let size: Vec<f64> = (0..rows).map(|i| scaled.row(i).iter().map(Interval::magnitude).fold(0.0, f64::max)).collect();
    let weight = |i: usize| if size[i] > 0.0 { 1.0 / size[i] } else { 1.0 };
    let weighted = DMatrix::from_fn(rows, varying.len(), |i, j| middle[(i, j)] * weight(i));
    let Ok(inverse) = weighted.pseudo_inverse(1e-12) else { return Ok(unknown) };
    let m = Matrix::from_fn(varying.len(), rows, |i, j| inverse[(i, j)] * weight(j));
    let m = Matrix::<Interval>::embed(&m, "M")?;
    let width = scaled.as_slice().iter().map(Interval::width).fold(0.0, f64::max);
    Ok(match positive_definite(&m.product(&scaled)?.plus_transpose()?)? {
        Verdict::Proved { margin } => Verdict::Proved { margin: 0.5 * margin },
        // One direction for one J: nothing is refuted of Phi.
        Verdict::Refuted { .. } => {
            Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "M" }, best: f64::NAN }
        }
        Verdict::Undecided { best, .. } => {
            Verdict::Undecided { why: UndecidedReason::DataTooUncertain { width }, best: 0.5 * best }
        }
    })
}
