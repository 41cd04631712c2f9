//! `Phi = (phi, h)` of a candidate: values, Jacobians, and enclosures of both.

use luenberger_plants::{Dimensions, Plant, Shape};
use luenberger_proof::{Interval, Ring};
use nalgebra::{DMatrix, DVector};

use super::candidate::{Pieces, still};
use crate::enclosure::IntervalDual;
use crate::enclosure::paths::explore;

/// `Phi = (phi, h)` as the outputs of a plant, whose Jacobian the enclosure then is. Its states are the candidate's.
pub(super) struct Images<'a, C> {
    pub(super) candidate: &'a C,
    pub(super) size: Dimensions,
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
    pub(super) fn is_unbranched_over(&self, axes: &[Interval]) -> bool {
        let (x, _, t) = still(axes, Dimensions { inputs: axes.len() - 1 - self.size.states, ..self.size });
        explore(|| self.at(t, &x)).is_ok_and(|ways| ways.len() == 1)
    }

    /// Phi and DPhi at a point, by intervals around single numbers; the numbers in their middles.
    pub(super) fn with_jacobian(&self, t: f64, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let (outputs, n) = (self.size.outputs, self.size.states);
        let (mut value, mut jacobian) = (DVector::zeros(outputs), DMatrix::zeros(outputs, n));
        for (k, column) in jacobian.as_mut_slice().chunks_mut(outputs).enumerate() {
            let image = self.point(t, x, Some(k))?;
            for (i, image) in image.iter().enumerate() {
                (value[i], column[i]) = (image.value().midpoint(), image.slope().midpoint());
            }
        }
        let finite = value.iter().chain(jacobian.iter()).all(|entry| entry.is_finite());
        finite.then_some((value, jacobian))
    }

    /// Phi at a point, enclosed, with its derivative along a coordinate.
    pub(super) fn point(&self, t: f64, x: &DVector<f64>, along: Option<usize>) -> Option<Vec<IntervalDual>> {
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

impl<C: Pieces<IntervalDual>> Shape for Images<'_, C> {
    fn dimensions(&self) -> Dimensions {
        self.size
    }
}

impl<C: Pieces<IntervalDual>> Plant<IntervalDual> for Images<'_, C> {
    type State = DVector<IntervalDual>;
    type Input = DVector<IntervalDual>;
    type Output = DVector<IntervalDual>;

    fn derivative(&self, _t: IntervalDual, x: &Self::State, _u: &Self::Input) -> Self::State {
        x.clone()
    }

    fn output(&self, t: IntervalDual, x: &Self::State, _u: &Self::Input) -> Self::Output {
        DVector::from_vec(self.at(t, x.as_slice()))
    }
}
