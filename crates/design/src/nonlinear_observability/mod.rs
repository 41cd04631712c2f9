//! Observability of a nonlinear plant along a trajectory: the rank of the derivatives of its output.
//!
//! Around a point `x` the output of `x' = f(t, x, u(t))`, `y = h(t, x, u(t))` is
//! `y(t + s) = y_0 + y_1 s + .. + y_K s^K + ..`, where `k! y_k` is the k-th derivative of the output along the
//! solution: `h`, `L_f h`, `L_f^2 h`, .. for a plant without time and input. If
//! ```text
//!       [ dy_0/dx ]
//! O  =  [ dy_1/dx ]     p (K + 1) x n
//!       [   ..    ]
//!       [ dy_K/dx ]
//! ```
//! has rank n, then no other state near x gives the same output with this input: the plant is locally observable there.
//! For a linear plant `k! y_k = C A^k x + ..` and O is the observability matrix, so that K = n - 1 decides. For a
//! nonlinear plant a rank deficiency *at a point* is inconclusive: a higher order may have full rank (`x1' = x2^3`, `y
//! = x1` at `x2 = 0` needs three derivatives), or none may have (`y = x^3` at 0 is injective all the same). The lowest
//! order at which the rank is full is the observability index of the point.
//!
//! # The input
//! Observability depends on the input. [`Instant::new`] holds no input; [`Instant::constant_input`] takes u as
//! constant, so that the plant may appear less observable than with a varying input; [`Instant::input_series`] takes
//! the Taylor coefficients of a given u(t). Time in f and h is differentiated too.
//!
//! # Units
//! Singular values are those of `O` after a scaling fixed for the whole trajectory: states in multiples of their scales
//! (given, or the largest magnitude along the trajectory), outputs and time such that no derivative of an output is
//! larger than the output itself. So neither ranks nor margins depend on units, and a margin of 1e-3 at one point means
//! one thousandth of the best observability.
//!
//! # Exactness
//! Derivatives are those of a truncated series over dual numbers ([`Jet`]): exact to rounding. Rank decisions are
//! floating point and carry their margins; they are not proofs.
//!
//! Sources: R. Hermann and A. J. Krener, Nonlinear controllability and observability, IEEE TAC 22, 1977; H. Nijmeijer
//! and A. van der Schaft, Nonlinear Dynamical Control Systems, Springer 1990, section 3.2.

use core::fmt;

use luenberger_plants::{Column, Dimensions, Plant};
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use crate::names;
use luenberger_proof::wording::{counted, shortest, significant};
use luenberger_wording::setters;

mod field;
mod jet;
mod linear;
mod words;

pub use jet::{HIGHEST_ORDER, Jet};
pub use linear::InWords;
pub use words::direction_in_words;

/// Why the rank could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ObservabilityError {
    /// No point to look at.
    #[error("a trajectory needs at least one point")]
    NoPoints,
    /// A column of the wrong length.
    #[error("{what} at t = {t} has {found} entries where {expected} are expected")]
    Length {
        /// Which column.
        what: &'static str,
        /// Where.
        t: f64,
        /// The length that fits.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A number that is NaN or infinite.
    #[error("entry {} of {what} at t = {t} is {value}, not a finite number", index + 1)]
    NotFinite {
        /// Of what.
        what: &'static str,
        /// Where.
        t: f64,
        /// Its index, from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A scale that is not positive and finite.
    #[error("the scale of {} is {value}; it must be positive and finite", names::state(*index))]
    Scale {
        /// The state, from 0.
        index: usize,
        /// The scale.
        value: f64,
    },
    /// As many scales as states are needed.
    #[error("{found} scales are given for {expected} states")]
    Scales {
        /// Number of states.
        expected: usize,
        /// Number of scales.
        found: usize,
    },
    /// More derivatives than a [`Jet`] keeps.
    #[error("derivatives up to order {order} are asked for; {highest} is the highest that is kept")]
    Order {
        /// The requested order.
        order: usize,
        /// The highest.
        highest: usize,
    },
    /// A tolerance that is not between 0 and 1.
    #[error("the tolerance of a rank must be between 0 and 1; it is {tolerance}")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// A derivative that does not exist, or overflows.
    #[error("derivative {order} of {} by {} is {value} at t = {t}, x = {x:?}", names::output(*output), names::state(*state))]
    NotDifferentiable {
        /// Order of the derivative by time.
        order: usize,
        /// The output, from 0.
        output: usize,
        /// The state, from 0.
        state: usize,
        /// The value.
        value: f64,
        /// Where.
        t: f64,
        /// Where.
        x: Vec<f64>,
    },
    /// The singular values did not converge.
    #[error("the singular values at t = {t} did not converge in {iterations} iterations")]
    NoConvergence {
        /// Where.
        t: f64,
        /// Iterations allowed.
        iterations: usize,
    },
}

/// A point of a trajectory: time, state, and the input around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    t: f64,
    x: Vec<f64>,
    /// Coefficients of the input, order by order.
    input: Vec<Vec<f64>>,
}

impl Instant {
    /// A point of a plant without inputs.
    pub fn new(t: f64, x: &[f64]) -> Self {
        Self { t, x: x.to_vec(), input: Vec::new() }
    }

    /// The same point, with an input that does not change around it.
    #[must_use]
    pub fn constant_input(self, u: &[f64]) -> Self {
        self.input_series(&[u.to_vec()])
    }

    /// The same point, with `u(t + s) = c_0 + c_1 s + c_2 s^2 + ..` around it: `c_k` is the k-th derivative of u over
    /// k!. What is not given is zero.
    #[must_use]
    pub fn input_series(mut self, coefficients: &[Vec<f64>]) -> Self {
        self.input = coefficients.to_vec();
        self
    }
}

/// Order, scales and tolerance of the rank decisions; [`Default`] chooses them from the trajectory.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LieSettings {
    /// Highest order K of the derivatives (default `2 n - 1`, at most [`HIGHEST_ORDER`]).
    pub order: Option<usize>,
    /// Scale of each state (default: largest magnitude along the trajectory, 1 for a state that stays 0).
    pub scales: Option<Vec<f64>>,
    /// Singular values at or below this share of the largest along the trajectory count as zero (default
    /// `100 n (K + 1) eps`): each coefficient is a sum of at most K + 1 products for each of the operations of f and h,
    /// of which a hundred are allowed for.
    pub tolerance: Option<f64>,
}

impl LieSettings {
    setters! { order: usize, scales: Vec<f64>, tolerance: f64 }
}

/// Observability from the output and its derivatives at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct LiePoint {
    /// The time.
    pub t: f64,
    /// The state.
    pub x: Vec<f64>,
    /// Rank of O.
    pub rank: usize,
    /// The n singular values of O, the largest first, as shares of the largest along the trajectory.
    pub singular_values: Vec<f64>,
    /// The lowest order at which the rank is n; none if it never is.
    pub index: Option<usize>,
    /// Orthonormal in the scaled states, as columns in the original units: the n - rank unobservable directions.
    pub unseen: DMatrix<f64>,
    /// The least observable direction, in the original units.
    pub weakest: DVector<f64>,
}

impl LiePoint {
    /// The smallest singular value: the observability of the least observable direction.
    pub fn margin(&self) -> f64 {
        self.singular_values.last().copied().unwrap_or(0.0)
    }

    /// The largest singular value of this point over the smallest; infinite if that is zero.
    pub fn condition(&self) -> f64 {
        let largest = self.singular_values.first().copied().unwrap_or(1.0);
        if self.margin() > 0.0 { largest / self.margin() } else { f64::INFINITY }
    }

    /// By what factor the rank decision is clear: the smallest singular value that counts over the largest that does
    /// not, or over the tolerance if all count.
    pub fn gap(&self, tolerance: f64) -> f64 {
        let counted = if self.rank == 0 { tolerance } else { self.singular_values[self.rank - 1] };
        counted / self.singular_values.get(self.rank).copied().unwrap_or(tolerance)
    }
}

/// How the input was treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputTreatment {
    /// The plant has none.
    None,
    /// Held constant around each point.
    Constant,
    /// By its Taylor coefficients.
    Series,
}

impl fmt::Display for InputTreatment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no input",
            Self::Constant => "the input held constant around each point",
            Self::Series => "the input by its Taylor coefficients",
        })
    }
}

/// Observability from the output and its derivatives along a trajectory. `Display` gives a summary as text.
#[derive(Debug, Clone, PartialEq)]
pub struct LieObservability {
    /// Every point, in the order given.
    pub points: Vec<LiePoint>,
    /// Sizes of the plant.
    pub size: Dimensions,
    /// Highest order of the derivatives.
    pub order: usize,
    /// Scale of each state.
    pub scales: Vec<f64>,
    /// Scale of time.
    pub time_scale: f64,
    /// Share of the largest singular value below which one counts as zero.
    pub tolerance: f64,
    /// How the input was treated.
    pub input: InputTreatment,
}

impl LieObservability {
    /// Whether the rank is full at every point.
    pub fn is_full_everywhere(&self) -> bool {
        self.points.iter().all(|point| point.rank == self.size.states)
    }

    /// The point with the smallest rank, and of those the one with the smallest margin.
    pub fn worst(&self) -> Option<&LiePoint> {
        self.points.iter().min_by(|a, b| a.rank.cmp(&b.rank).then(a.margin().total_cmp(&b.margin())))
    }

    /// The highest observability index along the trajectory; none if the rank is somewhere deficient.
    pub fn index(&self) -> Option<usize> {
        self.points.iter().map(|point| point.index).try_fold(0, |highest, index| index.map(|index| highest.max(index)))
    }

    /// The report, with names supplied by the user for the states.
    pub fn in_words(&self, names: &[&str]) -> String {
        let n = self.size.states;
        let (order, input, count) = (self.order, self.input, self.points.len());
        let mut lines = vec![format!("rank of d/dx (y, y', .., y^({order})) at {}, {input}", counted(count, "point"))];
        let deficient = self.points.iter().filter(|point| point.rank < n).count();
        lines.push(match self.index() {
            Some(index) => format!("full, {n} of {n}, everywhere; derivatives up to order {index} suffice"),
            None => {
                format!("not full at {deficient} of {count}: up to order {order} the rank is below {n} there")
            }
        });
        let Some(worst) = self.worst() else { return lines.join("\n") };
        lines.push(format!(
            "worst at t = {}: rank {} of {n}, margin {}, condition {}, singular-value gap {}",
            shortest(worst.t),
            worst.rank,
            significant(worst.margin(), 3),
            significant(worst.condition(), 3),
            significant(worst.gap(self.tolerance), 2)
        ));
        if worst.rank == n {
            let weakest = direction_in_words(&self.scaled(worst.weakest.as_slice()), names);
            lines.push(format!("least observable direction there: {weakest}"));
        }
        for direction in linear::echelon(&worst.unseen, &self.scales) {
            lines.push(format!("unobservable there: {}", direction_in_words(&direction, names)));
        }
        lines.join("\n")
    }

    /// In multiples of the scales, in which entries can be compared.
    fn scaled(&self, direction: &[f64]) -> Vec<f64> {
        direction.iter().zip(&self.scales).map(|(entry, scale)| entry / scale).collect()
    }
}

impl fmt::Display for LieObservability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(&[]))
    }
}

/// Rank of the derivatives of the output with respect to the state, at every point of a trajectory.
///
/// See the [module](self) for the equation, the units, and what a deficient rank does not mean. The plant is one
/// written for every scalar, `impl<T: RealField + Copy> Plant<T>`.
///
/// # Errors
/// [`ObservabilityError`]: columns that do not fit the plant, numbers that are not finite, an order beyond
/// [`HIGHEST_ORDER`], a derivative that does not exist at a point.
///
/// # Cost
/// For each point n K evaluations of f over series of 16 terms, and K singular value decompositions of p K x n.
///
/// # Example
/// Van der Pol's oscillator is observable everywhere by y and y'. The reverse Duffing oscillator, x1' = x2^3, needs
/// three derivatives where x2 = 0.
/// ```
/// use luenberger_design::nonlinear_observability::{Instant, LieSettings, lie_observability};
/// use luenberger_plants::{ReverseDuffing, VanDerPol};
///
/// let points: Vec<Instant> = (0..5).map(|k| Instant::new(0.0, &[1.0, 0.5 * f64::from(k)])).collect();
/// assert_eq!(lie_observability(&VanDerPol::default(), &points, &LieSettings::default())?.index(), Some(1));
///
/// let duffing = lie_observability(&ReverseDuffing, &points, &LieSettings::default())?;
/// assert_eq!(duffing.points[0].index, Some(3));
/// let first = LieSettings { order: Some(1), ..LieSettings::default() };
/// let duffing = lie_observability(&ReverseDuffing, &points, &first)?;
/// assert!(duffing.to_string().ends_with("unobservable there: x2"));
/// # Ok::<(), luenberger_design::nonlinear_observability::ObservabilityError>(())
/// ```
pub fn lie_observability<S: Plant<Jet>>(
    plant: &S,
    points: &[Instant],
    settings: &LieSettings,
) -> Result<LieObservability, ObservabilityError> {
    let size = plant.dimensions();
    let n = size.states;
    let order = settings.order.unwrap_or((2 * n).saturating_sub(1).min(HIGHEST_ORDER));
    if order > HIGHEST_ORDER {
        return Err(ObservabilityError::Order { order, highest: HIGHEST_ORDER });
    }
    if points.is_empty() {
        return Err(ObservabilityError::NoPoints);
    }
    for point in points {
        check(point, size)?;
    }
    let scales = scales_of(points, settings, n)?;
    let tolerance = settings.tolerance.unwrap_or(100.0 * (n * (order + 1)) as f64 * f64::EPSILON);
    if !(0.0..1.0).contains(&tolerance) {
        return Err(ObservabilityError::Tolerance { tolerance });
    }
    let mut matrices =
        points.iter().map(|point| derivatives(plant, point, &scales, order)).collect::<Result<Vec<_>, _>>()?;
    let time_scale = balance(&mut matrices, size.outputs, order);

    let mut decomposed = Vec::new();
    for (point, matrix) in points.iter().zip(&matrices) {
        decomposed.push(decompose(matrix, n, point.t)?);
    }
    let largest = decomposed.iter().map(|(values, _)| values.first().copied().unwrap_or(0.0)).fold(0.0, f64::max);
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let mut found = Vec::new();
    for ((point, matrix), (values, directions)) in points.iter().zip(&matrices).zip(decomposed) {
        let singular_values: Vec<f64> = values.iter().map(|value| value / unit).collect();
        let rank = singular_values.iter().filter(|&&value| value > tolerance).count();
        let mut index = None;
        if rank == n {
            for k in 0..=order {
                let head = matrix.rows(0, (k + 1) * size.outputs).into_owned();
                let (values, _) = decompose(&head, n, point.t)?;
                if values.iter().all(|value| value / unit > tolerance) {
                    index = Some(k);
                    break;
                }
            }
        }
        let given = |j: usize| DVector::from_fn(n, |i, _| scales[i] * directions[(i, j)]);
        let unseen: Vec<DVector<f64>> = (rank..n).map(given).collect();
        found.push(LiePoint {
            t: point.t,
            x: point.x.clone(),
            rank,
            singular_values,
            index,
            unseen: DMatrix::from_fn(n, n - rank, |i, j| unseen[j][i]),
            weakest: if n == 0 { DVector::zeros(0) } else { given(n - 1) },
        });
    }
    let input = match points.iter().map(|point| point.input.len()).max() {
        _ if size.inputs == 0 => InputTreatment::None,
        Some(2..) => InputTreatment::Series,
        _ => InputTreatment::Constant,
    };
    Ok(LieObservability { points: found, size, order, scales, time_scale, tolerance, input })
}

fn check(point: &Instant, size: Dimensions) -> Result<(), ObservabilityError> {
    let t = point.t;
    let finite = |what: &'static str, entries: &[f64]| match entries.iter().position(|entry| !entry.is_finite()) {
        Some(index) => Err(ObservabilityError::NotFinite { what, t, index, value: entries[index] }),
        None => Ok(()),
    };
    let fits = |what: &'static str, expected: usize, found: usize| {
        if expected == found { Ok(()) } else { Err(ObservabilityError::Length { what, t, expected, found }) }
    };
    finite("the time", &[t])?;
    fits("the state", size.states, point.x.len())?;
    finite("the state", &point.x)?;
    if point.input.is_empty() {
        fits("the input", size.inputs, 0)?;
    }
    for coefficient in &point.input {
        fits("a coefficient of the input", size.inputs, coefficient.len())?;
        finite("a coefficient of the input", coefficient)?;
    }
    Ok(())
}

fn scales_of(points: &[Instant], settings: &LieSettings, n: usize) -> Result<Vec<f64>, ObservabilityError> {
    let Some(scales) = &settings.scales else {
        let largest = |j: usize| points.iter().fold(0.0f64, |largest, point| largest.max(point.x[j].abs()));
        return Ok((0..n).map(largest).map(|largest| if largest > 0.0 { largest } else { 1.0 }).collect());
    };
    if scales.len() != n {
        return Err(ObservabilityError::Scales { expected: n, found: scales.len() });
    }
    match scales.iter().position(|scale| !(*scale > 0.0 && scale.is_finite())) {
        Some(index) => Err(ObservabilityError::Scale { index, value: scales[index] }),
        None => Ok(scales.clone()),
    }
}

/// O, with its columns in multiples of the scales: row `k p + i` is the derivative of the k-th Taylor coefficient of
/// output i.
fn derivatives<S: Plant<Jet>>(
    plant: &S,
    point: &Instant,
    scales: &[f64],
    order: usize,
) -> Result<DMatrix<f64>, ObservabilityError> {
    let Dimensions { states: n, inputs, outputs: p } = plant.dimensions();
    let t = point.t;
    let mut u = vec![Jet::constant(0.0); inputs];
    for (k, coefficient) in point.input.iter().enumerate().take(HIGHEST_ORDER + 1) {
        for (u, &c) in u.iter_mut().zip(coefficient) {
            u.c[k].value = c;
        }
    }
    let length = |what, expected, found| ObservabilityError::Length { what, t, expected, found };
    let u = S::Input::try_from_slice(&u).ok_or_else(|| length("the input", inputs, u.len()))?;
    let column = |x: &[Jet]| S::State::try_from_slice(x).ok_or_else(|| length("the state", n, x.len()));
    let mut matrix = DMatrix::zeros(p * (order + 1), n);
    for j in 0..n {
        let mut x: Vec<Jet> = point.x.iter().map(|&x| Jet::constant(x)).collect();
        x[j].c[0].slope = scales[j];
        // x_{k+1} = f_k/(k + 1): the k-th coefficient of f needs those of x up to the k-th.
        for k in 0..order {
            let slope = plant.derivative(Jet::time(t), &column(&x)?, &u);
            let slope = slope.as_slice();
            if slope.len() != n {
                return Err(length("the derivative of the state", n, slope.len()));
            }
            for (x, slope) in x.iter_mut().zip(slope) {
                let (value, derivative) = (slope.c[k].value, slope.c[k].slope);
                x.c[k + 1].value = value / (k + 1) as f64;
                x.c[k + 1].slope = derivative / (k + 1) as f64;
            }
        }
        let y = plant.output(Jet::time(t), &column(&x)?, &u);
        let y = y.as_slice();
        if y.len() != p {
            return Err(length("the output", p, y.len()));
        }
        for k in 0..=order {
            for (i, y) in y.iter().enumerate() {
                let (number, value) = (y.c[k].value, y.c[k].slope);
                if !(number.is_finite() && value.is_finite()) {
                    let value = if value.is_finite() { number } else { value };
                    let x = point.x.clone();
                    return Err(ObservabilityError::NotDifferentiable { order: k, output: i, state: j, value, t, x });
                }
                matrix[(k * p + i, j)] = value;
            }
        }
    }
    Ok(matrix)
}

/// Puts outputs and time into units in which no derivative is larger than the first that is there; returns the unit of
/// time.
fn balance(matrices: &mut [DMatrix<f64>], p: usize, order: usize) -> f64 {
    let size = |matrices: &[DMatrix<f64>], i: usize, k: usize| {
        matrices.iter().map(|matrix| matrix.row(k * p + i).norm()).fold(0.0, f64::max)
    };
    let mut rate = 0.0f64;
    for i in 0..p {
        let sizes: Vec<f64> = (0..=order).map(|k| size(matrices, i, k)).collect();
        let Some(first) = sizes.iter().position(|&size| size > 0.0) else { continue };
        for k in first + 1..=order {
            rate = rate.max((sizes[k] / sizes[first]).powf(1.0 / (k - first) as f64));
        }
    }
    let time = if rate > 0.0 && rate.is_finite() { 1.0 / rate } else { 1.0 };
    for matrix in &mut *matrices {
        let mut factor = 1.0;
        for k in 0..=order {
            for i in 0..p {
                matrix.row_mut(k * p + i).scale_mut(factor);
            }
            factor *= time;
        }
    }
    for i in 0..p {
        let largest = (0..=order).map(|k| size(matrices, i, k)).fold(0.0, f64::max);
        if largest > 0.0 {
            for matrix in &mut *matrices {
                for k in 0..=order {
                    matrix.row_mut(k * p + i).unscale_mut(largest);
                }
            }
        }
    }
    time
}

/// The n singular values, the largest first, and the right singular vectors as columns.
fn decompose(matrix: &DMatrix<f64>, n: usize, t: f64) -> Result<(Vec<f64>, DMatrix<f64>), ObservabilityError> {
    // Rows of zeros, so that there are n of each.
    let mut tall = matrix.clone();
    if tall.nrows() < n {
        tall = tall.resize_vertically(n, 0.0);
    }
    if n == 0 {
        return Ok((Vec::new(), DMatrix::zeros(0, 0)));
    }
    // A few per singular value are usual.
    let iterations = 100 * n;
    let svd = tall
        .try_svd(false, true, f64::EPSILON, iterations)
        .ok_or(ObservabilityError::NoConvergence { t, iterations })?;
    let Some(rows) = svd.v_t else { return Err(ObservabilityError::NoConvergence { t, iterations }) };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let values = order.iter().map(|&i| svd.singular_values[i]).collect();
    Ok((values, DMatrix::from_fn(n, n, |i, j| rows[(order[j], i)])))
}
