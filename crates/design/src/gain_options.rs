//! Requirements on a gain designed by linear matrix inequality, beside the decay rate.
//!
//! An inequality for a decay rate alone often has solutions with impractically large gains, which amplify noise and
//! let the error overshoot. Two remedies, both linear in (P, Y = P L):
//! ```text
//! |L| <= g                [ g^2 s I  Y' ]
//!                         [ Y        P  ] > 0,   P > s I            as L'L < L'P L/s = Y'P^-1 Y/s < g^2 I     (1)
//!
//! least noise gain        [ A'P + PA - YC - C'Y'   Y     ]          [ Z  I ]
//!                         [ Y'                     -V^-1 ] < 0,     [ I  P ] > 0,    minimise trace Z         (2)
//! ```
//! The first inequality of (2) is `F P^-1 + P^-1 F' + L V L' < 0` for `F = A - L C`: measurement noise of intensity V
//! leaves the error with a covariance of at most `P^-1 < Z`, at every vertex and for every motion between them. For one
//! plant and no decay rate this bound is attained. (1) is sufficient: a gain between the bound found and g may exist
//! where the inequality has no solution. In discrete time the first of (2) is
//! ```text
//! [ P          (PA - YC)'   0    ]
//! [ PA - YC    P            Y    ] > 0,          as F P^-1 F' + L V L' < P^-1,                                (3)
//! [ 0          Y'           V^-1 ]
//! ```
//! with the covariance V of the noise at a sample.
//!
//! Source: S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and Control Theory,
//! SIAM 1994, sections 6.3 and 7.3.

use luenberger_linalg::state_units;
use luenberger_lmi::{Expression, Problem, Settings, Variable, block, he, identity, trace, zeros};
use nalgebra::{DMatrix, DVector};

use crate::check;
use crate::error::DesignError;
use crate::powers::{Powers, shift};

/// Solver, bound of the gain and noise of a design by linear matrix inequality.
///
/// ```
/// use luenberger_design::{GainOptions, LinearDesign};
/// use nalgebra::dmatrix;
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let quiet = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().noise(dmatrix![1.0]))?;
/// let bounded = LinearDesign::lmi_with(&plant, 1.0, &GainOptions::default().max_gain(10.0))?;
/// // Every error decays at least like exp(-t) in both; the quiet one has the least noise gain.
/// assert!(quiet.rate == 1.0 && quiet.l().norm() < 4.0);
/// assert!(bounded.l().norm() < 10.0);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GainOptions {
    /// Solver and limits.
    pub settings: Settings,
    /// An upper bound of the spectral norm of L, (1).
    pub max_gain: Option<f64>,
    /// The intensity V of the measurement noise, p x p, in discrete time its covariance at a sample: among the gains
    /// with the rate, the one with the least bound `trace P^-1` of the error's variance, (2) or (3).
    pub noise: Option<DMatrix<f64>>,
}

impl From<Settings> for GainOptions {
    fn from(settings: Settings) -> Self {
        Self { settings, ..Self::default() }
    }
}

impl GainOptions {
    /// Solver and its limits.
    #[must_use]
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// Requires `|L| <= bound` (spectral norm), bound > 0.
    #[must_use]
    pub fn max_gain(mut self, bound: f64) -> Self {
        self.max_gain = Some(bound);
        self
    }

    /// Minimises the noise gain for measurement noise of the intensity `v`, p x p, positive definite.
    #[must_use]
    pub fn noise(mut self, v: DMatrix<f64>) -> Self {
        self.noise = Some(v);
        self
    }

    /// Whether nothing but a rate is asked for.
    pub(crate) fn only_rate(&self) -> bool {
        self.max_gain.is_none() && self.noise.is_none()
    }

    /// The inverse of V.
    pub(crate) fn check(&self, outputs: usize) -> Result<Checked, DesignError> {
        if let Some(bound) = self.max_gain {
            check::positive("the bound of the gain", bound)?;
        }
        let precision = match &self.noise {
            Some(v) => {
                let v = check::positive_definite("V", v, outputs)?;
                let identity = DMatrix::identity(outputs, outputs);
                Some(check::solve_definite("V", &v, &identity)?)
            }
            None => None,
        };
        Ok(Checked { max_gain: self.max_gain, precision, back: None })
    }
}

/// Options whose numbers have been checked, with `V^-1`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Checked {
    max_gain: Option<f64>,
    precision: Option<DMatrix<f64>>,
    /// From the units of the program, if it has its own: see [`NoiseUnits::back`].
    back: Option<(DVector<f64>, DMatrix<f64>)>,
}

impl Checked {
    /// The same for a program in these units.
    pub(crate) fn within(&self, units: &NoiseUnits) -> Self {
        let precision = self.precision.as_ref().map(|v| DMatrix::identity(v.nrows(), v.ncols()));
        Self { max_gain: self.max_gain, back: precision.is_some().then(|| units.back()), precision }
    }

    /// The square of the largest unit of a state as part of each: one in the units given.
    fn weights(&self, n: usize) -> DMatrix<f64> {
        self.back.as_ref().map_or_else(|| DMatrix::identity(n, n), |(weights, _)| DMatrix::from_diagonal(weights))
    }

    /// The constraints on P and Y alone, once in a problem.
    pub(crate) fn constrain(&self, lmi: &mut Problem, p: &Variable, y: &Variable, n: usize, outputs: usize) {
        if let Some(bound) = self.max_gain {
            let s = lmi.scalar("s");
            lmi.constrain("P > s", (p - s.identity(n) * self.weights(n)) >> 0.0);
            let scaled = (bound * bound) * s.identity(outputs);
            let y = self.back.as_ref().map_or_else(|| Expression::from(y), |(_, back)| y * back);
            lmi.constrain("|L| < max_gain", block![[scaled, y.transpose()], [y, p]] >> 0.0);
        }
        if self.precision.is_some() {
            let z = lmi.symmetric("Z", n);
            lmi.constrain("P^-1 < Z", block![[&z, identity(n)], [identity(n), p]] >> 0.0);
            lmi.minimise(trace(self.weights(n) * &z));
        }
    }

    /// The bound of the covariance at one vertex, where `half` is `P A - Y C`.
    pub(crate) fn constrain_vertex(&self, lmi: &mut Problem, name: &str, half: Expression, y: &Variable) {
        if let Some(precision) = &self.precision {
            let rows = block![[he(half), y], [y.transpose(), -precision]];
            lmi.constrain(&format!("covariance, {name}"), rows << 0.0);
        }
    }

    /// The same in discrete time, (3), where `corner` is `P A - Y C`.
    pub(crate) fn constrain_vertex_in_steps(
        &self,
        lmi: &mut Problem,
        name: &str,
        corner: Expression,
        (p, y): (&Variable, &Variable),
        (n, outputs): (usize, usize),
    ) {
        if let Some(precision) = &self.precision {
            let rows = block![
                [p, corner.transpose(), zeros(n, outputs)],
                [corner, p, y],
                [zeros(outputs, n), y.transpose(), precision]
            ];
            lmi.constrain(&format!("covariance, {name}"), rows >> 0.0);
        }
    }

    /// `V^-1`, if noise is considered.
    pub(crate) fn precision(&self) -> Option<&DMatrix<f64>> {
        self.precision.as_ref()
    }

    /// `Y V Y'`, which the noise adds to the decrease; none without noise.
    pub(crate) fn covariance_term(&self, y: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        Some(y * self.precision.clone()?.cholesky()?.solve(&y.transpose()))
    }
}

/// Units of the states, `x = D z`, of time and of the outputs, in which noise has the intensity one and A and C have
/// norms of about one: the program with (2) is not homogeneous. With `V = S S'`, `C^ = S^-1 C D / k`
/// and `A^ = D^-1 A D / t` it is solved by `P^ = D P D t / k^2` and `L^ = D^-1 L S k / t`.
pub(crate) struct NoiseUnits {
    states: Powers,
    pub(crate) time: f64,
    output: f64,
    /// `S^-1 / k`.
    whitening: DMatrix<f64>,
}

impl NoiseUnits {
    /// Those given, if there is no noise.
    pub(crate) fn of(limits: &Checked, vertices: &[DMatrix<f64>], c: &DMatrix<f64>) -> Self {
        let (n, p) = (c.ncols(), c.nrows());
        let given = Self { states: Powers::given(n), time: 1.0, output: 1.0, whitening: DMatrix::identity(p, p) };
        // V^-1 = R'R, and R is S^-1 for S = R^-1.
        let Some(root) = limits.precision().and_then(|precision| precision.clone().cholesky()) else { return given };
        let Some(Ok(states)) = vertices.first().map(state_units) else { return given };
        let (states, white) = (Powers(states), root.l().transpose());
        let power =
            |size: f64| if size > 0.0 && size.is_finite() { 2f64.powi(size.log2().round() as i32) } else { 1.0 };
        let output = power(states.columns(&(&white * c)).norm());
        let time = power(vertices.iter().map(|a| states.similar(a).norm()).fold(0.0, f64::max));
        let whitening = white / output;
        if whitening.iter().all(|x| x.is_finite()) { Self { states, time, output, whitening } } else { given }
    }

    /// The same in discrete time, where the step is the unit of time.
    pub(crate) fn in_steps(self) -> Self {
        Self { time: 1.0, ..self }
    }

    /// `D^-1 A D / t`.
    pub(crate) fn dynamics(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        self.states.similar(a) / self.time
    }

    /// `S^-1 C D / k`.
    pub(crate) fn outputs(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        self.states.columns(&(&self.whitening * c))
    }

    /// L from L^.
    pub(crate) fn gain_back(&self, l: &DMatrix<f64>) -> DMatrix<f64> {
        self.states.rows_back(&(l * &self.whitening * self.time))
    }

    /// P from P^.
    pub(crate) fn lyapunov_back(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        self.states.form_back(p) * (self.output * self.output / self.time)
    }

    /// The weights `d_i^2` of the variances of z in the sum of those of x, and M with `|L| <= |L^ M|` for `|x| <= |z|`:
    /// the largest weight is one.
    fn back(&self) -> (DVector<f64>, DMatrix<f64>) {
        let largest = self.states.0.iter().copied().max().unwrap_or(0);
        let weights = self.states.0.iter().map(|power| shift(1.0, 2 * (power - largest)));
        (DVector::from_iterator(self.states.0.len(), weights), &self.whitening * self.time * shift(1.0, largest))
    }
}
