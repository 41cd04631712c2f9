//! Whether (phi, h) tells the states of the box apart: measured over pairs, refuted by two states with one image, proved by one matrix.
//!
//! The proof: over a box of states, which is convex, `Phi(x) - Phi(x') = J (x - x')` with J, the mean of Jacobians over the segment, in the enclosure of DPhi over the box. If for one matrix M
//! `M J + J'M' > 0` for every J of the enclosure, `(x - x')'M (Phi(x) - Phi(x')) > 0` for all x, x' of the box that differ, and their images differ too.
//! M is the pseudo-inverse of the middle of the enclosure, with states in half-widths of the box; it is not the only matrix that could do it. It is asked for only where Phi is known to be
//! continuous: where it has a collected form, or leaves no comparison open on the box.
//!
//! The refutation: [`common_image`](super::common_image). Two images that are only close refute nothing, and are reported as a near collision.

use core::fmt;

use luenberger_plants::{Dimensions, Plant};
use luenberger_proof::{Interval, Matrix, Ring, UndecidedReason, Verdict, positive_definite};
use nalgebra::{DMatrix, DVector};

use super::collected::Collected;
use super::common_image::{CommonImage, Form, by_box, by_symmetry};
use super::pieces::Pieces;
use super::{KklError, still};
use crate::enclosure::paths::explore;
use crate::enclosure::{IntervalDual, Region, enclose};
use crate::error::DesignError;
use crate::separation::{DISTANT, Ratios, ratios, second_preimage};

/// Two states whose images under (phi, h) are close. This is no proof that any two are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoStates {
    /// One.
    pub first: Vec<f64>,
    /// The other.
    pub second: Vec<f64>,
    /// `|x - x'|`.
    pub distance: f64,
    /// `|Phi(x) - Phi(x')|` is at most this: proved.
    pub gap: f64,
}

impl fmt::Display for TwoStates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, second, distance, gap } = self;
        write!(f, "{first:?} and {second:?}, {distance:.3e} apart, have images at most {gap:.1e} apart")
    }
}

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
    /// Two states, a quarter of a half-width apart or more, whose images are apart less than `sqrt(EPSILON)` of the largest ratio times their distance: no left inverse
    /// computed in binary64 tells them apart well. The closest that were found; none where none were.
    pub near_collision: Option<TwoStates>,
    /// Whether phi and h are known to be continuous on the box: they have a collected form, or leave no comparison open.
    pub continuous: bool,
    /// Proved, at every time of the region: the smallest eigenvalue of `M J + J'M'` is at least twice the margin for every J of the enclosure, with M J = I in the middle, so that a
    /// margin of 1 is that of an affine Phi. Refuted: two states have one image, verified.
    pub verdict: Verdict<CommonImage>,
}

/// `Phi = (phi, h)` as the outputs of a plant, whose Jacobian the enclosure then is. Its states are the candidate's.
pub(super) struct Images<'a, C> {
    candidate: &'a C,
    size: Dimensions,
}

impl<C: Pieces<IntervalDual>> Images<'_, C> {
    /// Rows of Phi.
    pub(super) fn rows(&self) -> usize {
        self.size.outputs
    }

    /// Phi over a box at a time, with its derivative along a coordinate; none where a comparison is left open.
    pub(super) fn over(&self, t: f64, x: &[Interval], along: Option<usize>) -> Option<Vec<IntervalDual>> {
        let moving = |k| if Some(k) == along { Interval::ONE } else { Interval::zero() };
        let x: Vec<IntervalDual> = x.iter().enumerate().map(|(k, x)| IntervalDual::new(*x, moving(k))).collect();
        let t = IntervalDual::new(Interval::from_f64(t)?, Interval::zero());
        let mut ways = explore(|| self.at(t, &x)).ok()?;
        let way = ways.pop().filter(|way| way.len() == self.size.outputs);
        if ways.is_empty() { way } else { None }
    }

    fn at(&self, t: IntervalDual, x: &[IntervalDual]) -> Vec<IntervalDual> {
        let y = self.candidate.output(t, x);
        let mut image = self.candidate.image(t, x, &y);
        image.extend_from_slice(&y);
        image
    }

    /// Whether no comparison is left open over the whole box (states, inputs, time), so that Phi is continuous there.
    fn is_unbranched_over(&self, axes: &[Interval]) -> bool {
        let (x, _, t) = still(axes, Dimensions { inputs: axes.len() - 1 - self.size.states, ..self.size });
        explore(|| self.at(t, &x)).is_ok_and(|ways| ways.len() == 1)
    }

    /// Phi and DPhi at a point, by intervals around single numbers; the numbers in their middles.
    fn with_jacobian(&self, t: f64, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let (outputs, n) = (self.size.outputs, self.size.states);
        let middle = |x: Interval| x.midpoint_radius().map_or(f64::NAN, |(middle, _)| middle);
        let (mut value, mut jacobian) = (DVector::zeros(outputs), DMatrix::zeros(outputs, n));
        for (k, column) in jacobian.as_mut_slice().chunks_mut(outputs).enumerate() {
            let image = self.point(t, x, Some(k))?;
            for (i, image) in image.iter().enumerate() {
                (value[i], column[i]) = (middle(image.value()), middle(image.slope()));
            }
        }
        let finite = value.iter().chain(jacobian.iter()).all(|entry| entry.is_finite());
        finite.then_some((value, jacobian))
    }

    /// Phi at a point, enclosed, with its derivative along a coordinate.
    fn point(&self, t: f64, x: &DVector<f64>, along: Option<usize>) -> Option<Vec<IntervalDual>> {
        let number = |x: f64| Interval::from_f64(x);
        let x: Option<Vec<IntervalDual>> = x
            .iter()
            .enumerate()
            .map(|(i, x)| {
                Some(IntervalDual::new(number(*x)?, if Some(i) == along { Interval::ONE } else { Interval::zero() }))
            })
            .collect();
        let (x, t) = (x?, IntervalDual::new(number(t)?, Interval::zero()));
        let ways = explore(|| self.at(t, &x)).ok()?;
        // At a place of change either branch has the value.
        ways.into_iter().next().filter(|way| way.len() == self.size.outputs)
    }
}

impl<C: Pieces<IntervalDual>> Plant<IntervalDual> for Images<'_, C> {
    type State = DVector<IntervalDual>;
    type Input = DVector<IntervalDual>;
    type Output = DVector<IntervalDual>;

    fn dimensions(&self) -> Dimensions {
        self.size
    }

    fn derivative(&self, _t: IntervalDual, x: &Self::State, _u: &Self::Input) -> Self::State {
        x.clone()
    }

    fn output(&self, t: IntervalDual, x: &Self::State) -> Self::Output {
        DVector::from_vec(self.at(t, x.as_slice()))
    }
}

/// The numbers over `points`, and the verdict over the box `axes` (states, inputs, time).
pub(super) fn injectivity<C: Pieces<IntervalDual> + Pieces<Collected>>(
    candidate: &C,
    order: usize,
    (points, axes): (&[Vec<Interval>], &[Interval]),
    subdivisions: usize,
) -> Result<Injectivity, DesignError> {
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
) -> Result<Verdict<CommonImage>, DesignError> {
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
    let middle = DMatrix::from_fn(rows, varying.len(), |i, j| {
        scaled[(i, j)].midpoint_radius().map_or(f64::NAN, |(middle, _)| middle)
    });
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
