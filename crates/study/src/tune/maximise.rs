//! The search: BOBYQA (Powell 2009), a trust-region method with bounds that needs no derivatives, as the crate `basin`
//! has it. The likelihood has none that are as exact as it is: its predictions have steps of their own.

use basin::{Bobyqa, BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, Executor, PointState};

use super::coordinate::Coordinate;

/// What is minimised, and within which bounds.
struct Problem<F> {
    cost: F,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

/// The search was interrupted.
#[derive(Debug)]
pub(super) struct Interrupted;

impl<F> Constraints for Problem<F> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl<F: Fn(&[f64]) -> Result<f64, Interrupted>> CostFunction for Problem<F> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Interrupted;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Interrupted> {
        (self.cost)(x)
    }
}

/// Radii of the two passes, from and to, in coordinates: a logarithm's is a ratio.
const PASSES: [(f64, f64); 2] = [(0.7, 1e-3), (0.05, 1e-5)];

/// Evaluations of one pass for each coordinate.
const EVALUATIONS: u64 = 150;

/// The least cost near a start, and where.
pub(super) fn minimised(
    cost: impl Fn(&[f64]) -> Result<f64, Interrupted>,
    coordinates: &[Coordinate],
    start: &[f64],
    passes: &[(f64, f64)],
) -> Result<(Vec<f64>, f64), Interrupted> {
    let mut best = (start.to_vec(), cost(start)?);
    for (from, to) in passes {
        let lower = coordinates.iter().map(|of| of.low).collect();
        let upper = coordinates.iter().map(|of| of.high).collect();
        let problem = Problem { cost: &cost, lower, upper };
        let method = Bobyqa::new().with_initial_radius(*from).with_final_radius(*to);
        let run = Executor::new(problem, method, PointState::new(best.0.clone()))
            .max_cost_evals(EVALUATIONS * (start.len() as u64 + 1))
            .run()
            .map_err(|_| Interrupted)?;
        let clamped: Vec<f64> =
            run.best_param().iter().zip(coordinates).map(|(x, of)| x.clamp(of.low, of.high)).collect();
        let found = cost(&clamped)?;
        if found < best.1 {
            best = (clamped, found);
        }
    }
    Ok(best)
}

/// The same with the radii of a search from afar.
pub(super) fn searched(
    cost: impl Fn(&[f64]) -> Result<f64, Interrupted>,
    coordinates: &[Coordinate],
    start: &[f64],
) -> Result<(Vec<f64>, f64), Interrupted> {
    minimised(cost, coordinates, start, &PASSES)
}
