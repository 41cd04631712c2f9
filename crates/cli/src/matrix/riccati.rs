//! `luenberger care` and `luenberger dare`: the regulator in the form of MATLAB and scipy, with S, E or both where they
//! are given, and the Kalman filter from `a`, `c` and the noise.

use super::{from, json_output};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::given::{Given, RiccatiProblem};
use crate::input::json::{self, Form};
use crate::numbers;
use luenberger_linalg::{
    Kalman, LinalgError, MeasurementUpdate, Riccati, measurement_update, positive_semidefinite, symmetric_part,
};
use nalgebra::DMatrix;
use serde::Serialize;

#[derive(Serialize)]
struct Regulator {
    x: Vec<Vec<f64>>,
    k: Vec<Vec<f64>>,
    poles: Vec<[f64; 2]>,
    residual: f64,
    /// None where nothing is known of it.
    condition: Option<f64>,
    /// Bound of the relative error of x; none if no digit is certain.
    forward_error: Option<f64>,
    /// Where the solution is no minimum of the cost.
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<&'static str>,
}

#[derive(Serialize)]
struct Estimation {
    p: Vec<Vec<f64>>,
    l: Vec<Vec<f64>>,
    /// In discrete time: gain of the measurement update, and the covariance after it.
    #[serde(skip_serializing_if = "Option::is_none")]
    filter_gain: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    filter_covariance: Option<Vec<Vec<f64>>>,
    poles: Vec<[f64; 2]>,
    residual: f64,
    /// None where nothing is known of it.
    condition: Option<f64>,
    /// Bound of the relative error of p; none if no digit is certain.
    forward_error: Option<f64>,
}

/// The three problems of a command, and their equations.
struct Problems {
    plain: (Plain, &'static str),
    general: (General, &'static str),
    filter: (Estimator, &'static str),
    /// With a cross-covariance of the noises.
    correlated: (Correlated, &'static str),
    /// Whether the filter has a measurement update.
    is_discrete: bool,
}

type Plain = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<Riccati, LinalgError>;
type Estimator = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<Kalman, LinalgError>;
type Correlated = fn([&DMatrix<f64>; 5]) -> Result<Kalman, LinalgError>;
type General = fn([&DMatrix<f64>; 6]) -> Result<Riccati, LinalgError>;

/// `A'X + X A - X B R^-1 B'X + Q = 0`, `K = R^-1 B'X`; `A P + P A' - P C'V^-1 C P + W = 0`, `L = P C'V^-1`.
pub(crate) fn care(source: &Given) -> Result<Answer, Failure> {
    solve(
        source,
        &Problems {
            plain: (|a, b, q, r| luenberger_linalg::care(a, b, q, r), "A'X + X A - X B R^-1 B'X + Q = 0, K = R^-1 B'X"),
            general: (
                |[a, b, q, r, s, e]| luenberger_linalg::generalized_care(a, b, q, r, s, e),
                "A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0, K = R^-1 (B'X E + S')",
            ),
            filter: (
                |a, c, w, v| luenberger_linalg::kalman_gain(a, c, w, v),
                "A P + P A' - P C'V^-1 C P + W = 0, L = P C'V^-1",
            ),
            correlated: (
                |[a, c, w, v, s]| luenberger_linalg::correlated_kalman_gain(a, c, w, v, s),
                "A P + P A' - (P C' + S) V^-1 (C P + S') + W = 0, L = (P C' + S) V^-1",
            ),
            is_discrete: false,
        },
    )
}

/// `A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0`, `K = (R + B'X B)^-1 B'X A`;
/// `A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0`, `L = A P C'(V + C P C')^-1`.
pub(crate) fn dare(source: &Given) -> Result<Answer, Failure> {
    solve(
        source,
        &Problems {
            plain: (
                |a, b, q, r| luenberger_linalg::dare(a, b, q, r),
                "A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, K = (R + B'X B)^-1 B'X A",
            ),
            general: (
                |[a, b, q, r, s, e]| luenberger_linalg::generalized_dare(a, b, q, r, s, e),
                "A'X A - E'X E - (A'X B + S) (R + B'X B)^-1 (B'X A + S') + Q = 0, K = (R + B'X B)^-1 (B'X A + S')",
            ),
            filter: (
                |a, c, w, v| luenberger_linalg::discrete_kalman_gain(a, c, w, v),
                "A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0, L = A P C'(V + C P C')^-1",
            ),
            correlated: (
                |[a, c, w, v, s]| luenberger_linalg::discrete_correlated_kalman_gain(a, c, w, v, s),
                "A P A' - P - (A P C' + S)(V + C P C')^-1 (C P A' + S') + W = 0, L = (A P C' + S)(V + C P C')^-1",
            ),
            is_discrete: true,
        },
    )
}

fn solve(source: &Given, problems: &Problems) -> Result<Answer, Failure> {
    let forms = [
        Form { keys: &["a", "b", "q", "r", "s", "e"], required: 4 },
        Form { keys: &["a", "c", "w", "v", "g", "s"], required: 4 },
    ];
    let [a, b, q, r, s, e, c, w, v, g] = json::either(source, RiccatiProblem::KEYS, &forms)?;
    let a = a.unwrap_or_default();
    if let Some(c) = c {
        let (w, v) = (w.unwrap_or_default(), v.unwrap_or_default());
        return estimate(problems, [&a, &c, &v], w, g, s).map_err(from(source)).and_then(|found| filter(&found));
    }
    let [b, q, r] = [b, q, r].map(Option::unwrap_or_default);
    if s.is_none() && e.is_none() {
        let (plain, equation) = problems.plain;
        let found = plain(&a, &b, &q, &r).map_err(from(source))?;
        return regulator(equation, "poles of A - B K", &found, problems.warning(&found, &b, &r));
    }
    let s = s.unwrap_or_else(|| DMatrix::zeros(b.nrows(), b.ncols()));
    let e = e.unwrap_or_else(|| DMatrix::identity(a.nrows(), a.nrows()));
    let (general, equation) = problems.general;
    let found = general([&a, &b, &q, &r, &s, &e]).map_err(from(source))?;
    regulator(equation, "poles of (A - B K, E)", &found, problems.warning(&found, &b, &r))
}

impl Problems {
    /// In discrete time with a weight of a cost: whether `R + B'X B` is definite.
    fn warning(&self, found: &Riccati, b: &DMatrix<f64>, r: &DMatrix<f64>) -> Option<&'static str> {
        let weight = symmetric_part(&(r + b.transpose() * &found.x * b));
        let is_minimum = !self.is_discrete
            || positive_semidefinite("R", r).is_err()
            || positive_semidefinite("R + B'X B", &weight).is_ok();
        (!is_minimum).then_some("R + B'X B is not positive definite: X and K are no minimum of the cost")
    }
}

fn regulator(equation: &str, poles: &str, found: &Riccati, warning: Option<&'static str>) -> Result<Answer, Failure> {
    let condition = known(found.condition);
    let (error, forward_error) = numbers::forward_error(found.forward_error);
    let text = format!(
        "{equation}\n{}{}{}{}, {error}\n{}",
        numbers::matrix("X", &found.x),
        numbers::matrix("K", &found.k),
        numbers::list(poles, &found.poles),
        accuracy(found.residual, condition),
        warning.map(|text| format!("warning: {text}\n")).unwrap_or_default()
    );
    let regulator = Regulator {
        x: json_output::rows(&found.x),
        k: json_output::rows(&found.k),
        poles: json_output::pairs(&found.poles),
        residual: found.residual,
        condition,
        forward_error,
        warning,
    };
    Ok(Answer::new(text, &regulator)?)
}

/// A Kalman filter and the equation it solves.
struct Estimate {
    equation: String,
    kalman: Kalman,
    update: Option<MeasurementUpdate>,
}

/// With g the noise enters as G w: `G W G'` is its covariance, and `G S` that of it and v.
fn estimate(
    problems: &Problems,
    [a, c, v]: [&DMatrix<f64>; 3],
    mut w: DMatrix<f64>,
    g: Option<DMatrix<f64>>,
    mut s: Option<DMatrix<f64>>,
) -> Result<Estimate, LinalgError> {
    let mut equation = (if s.is_some() { problems.correlated.1 } else { problems.filter.1 }).to_owned();
    if let Some(g) = g {
        let (n, q) = (a.nrows(), w.nrows());
        let shaped = |what, m: &DMatrix<f64>, expected| match m.shape() {
            found if found == expected => Ok(()),
            found => Err(LinalgError::DimensionMismatch { what, expected, found }),
        };
        let checked = positive_semidefinite("W", &w)?;
        shaped("G", &g, (n, q))?;
        w = symmetric_part(&(&g * checked * g.transpose()));
        equation.push_str(", G W G' in place of W");
        if let Some(cross) = &s {
            shaped("S", cross, (q, c.nrows()))?;
            s = Some(&g * cross);
            equation.push_str(", G S of S");
        }
    }
    let kalman = match &s {
        Some(s) => (problems.correlated.0)([a, c, &w, v, s])?,
        None => (problems.filter.0)(a, c, &w, v)?,
    };
    let update = if problems.is_discrete { Some(measurement_update(&kalman.p, c, v)?) } else { None };
    Ok(Estimate { equation, kalman, update })
}

fn filter(Estimate { equation, kalman: found, update }: &Estimate) -> Result<Answer, Failure> {
    let condition = known(found.condition);
    let (error, forward_error) = numbers::forward_error(found.forward_error);
    let updated = update.as_ref().map(|update| {
        numbers::matrix("M = P C'(V + C P C')^-1, gain of the measurement update", &update.gain)
            + &numbers::matrix("P - M C P, covariance after it", &update.p)
    });
    let text = format!(
        "{equation}\n{}{}{}{}{}, {error}\n",
        numbers::matrix("P", &found.p),
        numbers::matrix("L", &found.l),
        updated.unwrap_or_default(),
        numbers::list("poles of A - L C", &found.poles),
        accuracy(found.residual, condition)
    );
    let filter = Estimation {
        p: json_output::rows(&found.p),
        l: json_output::rows(&found.l),
        filter_gain: update.as_ref().map(|update| json_output::rows(&update.gain)),
        filter_covariance: update.as_ref().map(|update| json_output::rows(&update.p)),
        poles: json_output::pairs(&found.poles),
        residual: found.residual,
        condition,
        forward_error,
    };
    Ok(Answer::new(text, &filter)?)
}

fn known(condition: f64) -> Option<f64> {
    Some(condition).filter(|condition| condition.is_finite())
}

fn accuracy(residual: f64, condition: Option<f64>) -> String {
    let condition = condition.map_or("unknown".to_owned(), numbers::size);
    format!("residual {} (relative), condition {condition}", numbers::size(residual))
}
