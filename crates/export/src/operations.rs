//! What a step costs on the target: floating-point operations, and the numbers that are stored.

use luenberger_expression::Routine;
use luenberger_observers::moving_horizon::INTERIOR_POINT_STEPS;
use luenberger_observers::varying_period::DEGREE;
use luenberger_observers::{Horizon, ObserverDimensions, SampledCubicObserver, SampledObserver};
use nalgebra::{DVector, Dyn};

use crate::exportable_observer::{ExportableObserver, Maps};
use crate::moving_horizon::{MovingHorizon, bounds};
use crate::scalar::Scalar;

impl ExportableObserver {
    /// Floating-point operations of one step, calls of functions counted as one each.
    pub(crate) fn operations(&self) -> usize {
        let ObserverDimensions { estimate: n, inputs: m, outputs: p, .. } = self.dimensions();
        let product = |rows: usize, columns: usize| if columns == 0 { 0 } else { rows * (2 * columns - 1) };
        let innovation = product(p, n) + p + self.feedthrough().map_or(0, |_| product(p, m) + p);
        let linear = product(n, n) + product(n, m) + product(n, p) + if m == 0 { n } else { 2 * n };
        let (motion, measurement) =
            self.maps().map_or((0, 0), |maps| (maps.motion.operations(), maps.measurement.operations()));
        // The plant over a period with its Jacobian: stages, Phi and H of each step.
        let classical = |centre: usize| 4 * centre + 6 * n + 6 * n + 5 * n * product(n, n) + 19 * n * n;
        // One step of the Runge-Kutta method for so many entries, without the slopes.
        let combined = |entries: usize| 12 * entries;
        let flow = |observer: &SampledCubicObserver<f64, Dyn, Dyn, Dyn>| match observer.coupling() {
            // Direction, quadratic form, the matrix and its elimination.
            Some(_) => {
                let elimination = p * (p - 1) / 2 + p * (p - 1) * (2 * p - 1) / 3 + 2 * p * (p - 1) + p;
                3 * p + product(p, p) + product(1, p) + 4 + p * p + p + elimination
            }
            // One output: a root and two divisions; what gains and period decide is a number of the program.
            None if p == 1 => 12 + if matches!(self, Self::Varying(_)) { 3 } else { 0 },
            // Direction, quadratic form, two roots, three divisions.
            None => 3 * p + product(p, p) + product(1, p) + 15,
        };
        let (angles, state_angles) = self.angles();
        match self {
            Self::Linear(_) => innovation + linear,
            Self::Cubic(observer) => innovation + linear + flow(observer) + product(n, p) + n,
            Self::Varying(step) => {
                let term = product(n, n) + 3 * n;
                // With the degree of each further term, which is counted as a number.
                let substep = DEGREE * term + DEGREE - 1 + product(n, m) + n;
                let corrected = innovation + flow(step.observer().nominal()) + 2 * product(n, p) + 2 * n;
                step.observer().substeps() * substep + 1 + corrected
            }
            Self::Kalman(filter) => {
                let square = n * product(n, n);
                let factor = p * (p * p + 3 * p + 2) / 3 + n * 2 * p * p;
                let covariances = p * product(n, n) + p * product(p, n) + p * p;
                // The gate has the covariance of the innovation before that of what passes it.
                let gate = if filter.gate().is_some() { covariances + 2 * p } else { 0 };
                let joined = gate + covariances + factor + n * product(n, p) + n * n;
                let update = angles * WRAP
                    + measurement
                    + p
                    + joined
                    + 2 * product(n, p)
                    + 2 * square
                    + (n + p) * product(n, p)
                    + n * n;
                // A further linearisation: the estimate, the innovation there, and the gain.
                let estimate = product(n, p) + n;
                let innovation = angles * WRAP + measurement + n + product(p, n) + 2 * p;
                let update = update + (filter.iterations() - 1) * (estimate + innovation + covariances + factor);
                let symmetry = n * (n - 1);
                // After the update and after the prediction.
                let normalised = self.unit_vectors().map_or(0, |vectors| {
                    let lengths = (1..=vectors.max() as usize)
                        .map(|vector| vectors.iter().filter(|number| **number as usize == vector).count());
                    2 * (lengths.map(|k| 3 * k + 1 + 10 * n * k).sum::<usize>() + symmetry)
                });
                let spread = 2 * square + n * n + symmetry;
                update
                    + spread
                    + normalised
                    + match filter.substeps() {
                        Some(count) => linearised(count, n, classical(motion)),
                        None => motion,
                    }
            }
            Self::Unscented(filter) => {
                // A column added to a factor of this order, and its rotations below the diagonal.
                let column = |order: usize| 6 * order + 3 * order * (order - 1);
                let joint = column(n + p);
                let points = |rows: usize| rows * (8 * n + 5);
                let drawn = 4 * n * n;
                let moved = match filter.substeps() {
                    Some(count) => count * (4 * motion + combined(n)),
                    None => motion,
                };
                let centre = self.maps().and_then(|maps| maps.centre).map_or(0, |centre| centre.operations());
                let noise = filter.substeps().map_or(0, |count| {
                    let products = 2 * n * product(n, n) + 3 * n * n + 2 * n * column(n);
                    count * (classical(centre) + products) + (count - 1) * (n * product(n, n) + n * column(n))
                });
                // The differences of two images to the centre's, and their sums.
                let near = |angles: usize| angles * 2 * n * (WRAP + 2);
                let update = near(angles)
                    + angles * WRAP
                    + (2 * n + 1) * measurement
                    + drawn
                    + points(p)
                    + n * column(p)
                    + (n + 1) * joint
                    + p
                    + p * p
                    + 2 * n * p;
                let predicted = (2 * n + 1) * (moved + column(n)) + drawn + points(n) + noise + near(state_angles);
                if filter.gate().is_some() { 2 * update + predicted } else { update + predicted }
            }
            Self::MovingHorizon(estimator) => FullWindow::new(self, estimator).most(),
            Self::SampledNonlinear(observer) => {
                let slope = motion + measurement + product(p, n) + p + product(n, p) + n;
                observer.substeps() * (4 * slope + combined(n + p))
            }
            Self::Extension(observer) => {
                let z = observer.dimensions().state - n;
                let own = self.extension();
                let of = |routine: Option<&Routine>| routine.map_or(0, Routine::operations);
                let [rate, estimate, jump] = [
                    of(own.as_ref().map(|own| &own.rate)),
                    of(own.as_ref().map(|own| &own.estimate)),
                    of(own.as_ref().and_then(|own| own.jump.as_ref())),
                ];
                let slope = motion + measurement + rate + estimate + product(p, n);
                observer.substeps() * (4 * slope + combined(z + p)) + estimate + jump
            }
            Self::Discrete(_) => motion + measurement + p + product(n, p) + n,
            Self::Step(_) => motion,
            Self::Kkl(observer) => {
                let z = observer.dimensions().state;
                let inverse = observer.trees().first().map_or(0, |(_, inverse)| inverse.operations());
                let slope = motion + measurement + p + product(z, z) + product(z, p) + z;
                // At most: every evaluation that the search may take.
                let search = observer.table(Scalar::Binary64).map_or(0, |table| {
                    let solve = z * (3 + 2 * n + 2 * n * n) + n * n * n + 12 * n + 10;
                    table.weighing() + table.evaluations() * (table.operations() + solve)
                });
                let estimate = z + product(z, z) + z + 2 * observer.held_inputs() + inverse + 2 * n + search;
                measurement + p + observer.substeps() * (4 * slope + combined(z + n)) + estimate
            }
        }
    }

    /// How many outputs and states are angles whose differences a step wraps.
    fn angles(&self) -> (usize, usize) {
        let count = |turns: &DVector<f64>| turns.iter().filter(|turn| **turn > 0.0).count();
        self.turns().map_or((0, 0), |(outputs, states)| (count(&outputs), states.as_ref().map_or(0, count)))
    }

    /// Constants and numbers of tables in the right-hand sides of a nonlinear plant.
    pub(crate) fn constants_of_maps(&self) -> usize {
        self.maps().map_or(0, |maps| maps.routines().flat_map(Routine::constants).count())
    }

    /// Bytes of the state.
    pub(crate) fn state_bytes(&self, scalar: Scalar) -> usize {
        let Self::MovingHorizon(estimator) = self else { return self.state_entries() * scalar.bytes() };
        let ObserverDimensions { estimate: n, inputs: m, outputs: p, .. } = self.dimensions();
        let (bytes, timed) = (scalar.bytes(), usize::from(self.uses_time()));
        // The integers behind the numbers of a sample are padded to their length, and so is the number of samples; that
        // of the next sample has 8 bytes.
        let sample = ((n + m + p + timed) * bytes + 4 * p).next_multiple_of(bytes);
        let end = 2 * (n + n * n) * bytes + estimator.horizon().window * sample + 4;
        if timed == 1 { end.next_multiple_of(8) + 8 } else { end.next_multiple_of(bytes) }
    }

    /// Numbers that the state holds.
    fn state_entries(&self) -> usize {
        match self {
            Self::Kkl(observer) => observer.dimensions().state + observer.dimensions().estimate,
            Self::Extension(observer) => observer.dimensions().state,
            _ => self.dimensions().state,
        }
    }

    /// Numbers of the trees of a KKL observer, and the entries of their comparisons.
    pub(crate) fn numbers_of_trees(&self) -> usize {
        let Self::Kkl(observer) = self else { return 0 };
        let table = observer
            .table(Scalar::Binary64)
            .map_or(0, |table| table.coefficients.len() + table.nodes.iter().map(Vec::len).sum::<usize>());
        table + observer.trees().iter().map(|(_, tree)| 4 * tree.nodes.len() + tree.leaves.len()).sum::<usize>()
    }

    /// Integers among the constants, of a moving-horizon estimator.
    pub(crate) fn integers(&self) -> usize {
        let Self::MovingHorizon(estimator) = self else { return 0 };
        bounds(estimator).len()
    }

    /// The most operations of a step in which no bound is active, where there are bounds.
    pub(crate) fn operations_within_bounds(&self) -> Option<usize> {
        let Self::MovingHorizon(estimator) = self else { return None };
        let window = FullWindow::new(self, estimator);
        (window.bounds > 0).then(|| window.within())
    }

    /// Numbers of the arrays over the window that a step of a moving-horizon estimator has on the stack at once.
    pub(crate) fn numbers_of_window(&self) -> Option<usize> {
        let Self::MovingHorizon(estimator) = self else { return None };
        let window = FullWindow::new(self, estimator);
        let (n, interior) = (window.n, if window.bounds > 0 { 2 * window.bounds + window.n } else { 0 });
        let (outputs, bounds) = (window.p * (2 * n + 1), window.bounds * (n + 1));
        // Stages of the filter, trajectory, solutions, slacks and multipliers.
        Some(window.stages * (2 * n * n + n + outputs + bounds + 2 * n + interior))
    }
}

/// The operations of a difference that is wrapped: quotient, difference, `floor`, product and sum.
const WRAP: usize = 5;

/// The operations of a moving-horizon estimator with a full window.
struct FullWindow {
    n: usize,
    p: usize,
    stages: usize,
    iterations: usize,
    bounds: usize,
    /// Outputs and states that are angles.
    angles: (usize, usize),
    measurement: usize,
    /// Of the plant over a period with its Jacobian and noise.
    linearised: usize,
}

impl FullWindow {
    fn new(observer: &ExportableObserver, estimator: &MovingHorizon<f64>) -> Self {
        let ObserverDimensions { estimate: n, outputs: p, .. } = observer.dimensions();
        let maps = observer.maps();
        let of = |routine: fn(&Maps) -> &Routine| maps.as_ref().map_or(0, |maps| routine(maps).operations());
        let (motion, measurement) = (of(|maps| &maps.motion), of(|maps| &maps.measurement));
        let is_timed = maps.as_ref().is_some_and(|maps| maps.motion.uses_time());
        let classical = 4 * motion + 12 * n + 5 * square(n) + 19 * n * n;
        let linearised = match estimator.substeps() {
            // The time of the four slopes, and of the start of each step.
            Some(substeps) => linearised(substeps, n, classical + if is_timed { 5 } else { 0 }),
            None => motion,
        };
        let Horizon { window, iterations } = estimator.horizon();
        Self {
            n,
            p,
            stages: window,
            iterations,
            bounds: bounds(estimator).len(),
            angles: observer.angles(),
            measurement,
            linearised,
        }
    }

    /// The update by one measurement from the product `P c'` on: gain, mean, and P in Joseph's form by two changes of
    /// rank one.
    fn correction(&self) -> usize {
        let n = self.n;
        2 + n + 2 * n + 2 * n * n + n + 2 * n * (n + 1)
    }

    /// The products with the row of an output: `P c'`, `c P c'` and `A c'`.
    fn products(&self) -> usize {
        2 * self.n * (2 * self.n + 1)
    }

    /// What the way back needs of a measurement: `K' mu + nu/s`, and the change of mu by `states` entries of its row.
    fn adjoint(&self, states: usize) -> usize {
        2 * self.n + 1 + states
    }

    /// The outputs of a sample, decoupled by the factor of V.
    fn measured(&self) -> usize {
        let (n, p) = (self.n, self.p);
        let decoupled = p * (p - 1) * (n + 1) + p * (n + 1);
        let wrapped = (self.angles.0 + p * self.angles.1) * WRAP;
        self.measurement + p + decoupled + p * (3 * n + self.products() + self.correction()) + wrapped
    }

    /// `A P A' + Q`.
    fn spread(&self) -> usize {
        2 * square(self.n) + self.n * self.n + self.n * (self.n - 1)
    }

    /// The mean of the next sample.
    fn drift(&self) -> usize {
        2 * self.n * self.n + self.n + self.angles.1 * WRAP
    }

    fn pass(&self) -> usize {
        let n = self.n;
        let moved = self.linearised + self.drift() + self.spread() + self.p * self.adjoint(2 * n) + 2 * n * n;
        self.stages * (self.measured() + 2 * n * n) + (self.stages - 1) * moved
    }

    /// A step without active bounds: the time, the check of the innovation, the Gauss-Newton steps, the prediction, and
    /// the arrival cost.
    fn within(&self) -> usize {
        let (n, p) = (self.n, self.p);
        let factor: usize = (0..p).map(|j| (p - j) * (2 * j + 1)).sum();
        let definite = self.measurement + (p * n + p * p) * (2 * n - 1) + p * p + factor;
        let forgotten = self.measured() + self.linearised + self.drift() + self.spread();
        1 + definite + self.iterations * self.pass() + self.linearised + self.spread() + forgotten
    }

    /// With the interior-point method.
    fn most(&self) -> usize {
        if self.bounds == 0 {
            return self.within();
        }
        let pairs = self.stages * self.bounds;
        // Value, innovation and variance of a bound; the steps of its slack and multiplier, twice, how far they may go,
        // and the new ones.
        let back = (self.stages - 1) * self.bounds * self.adjoint(1);
        let of_bounds = pairs * (6 + self.correction() + 2 * 8 + 2 * 5 + 6) + back;
        let step = self.pass() + of_bounds + 4 * self.stages * self.n + 3;
        self.within() + 3 * pairs + self.n + INTERIOR_POINT_STEPS * step
    }
}

/// The plant over a period with its Jacobian and noise, by so many steps of which each takes `classical` operations.
fn linearised(substeps: usize, n: usize, classical: usize) -> usize {
    let noise = 4 * square(n) + 4 * n * n + n * (n - 1);
    let then = 3 * square(n) + n * n + n * (n - 1);
    substeps * (classical + noise) + (substeps - 1) * then
}

/// The product of two square matrices.
fn square(n: usize) -> usize {
    n * n * (2 * n - 1)
}
