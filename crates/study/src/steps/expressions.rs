//! The plant of a study as expressions, which can be printed as source code.

use luenberger_design::OperatingPoint;
use luenberger_expression::{ExpressionPlant, ExpressionPlantError, Parameters};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector};

use crate::model::{Builtin, Model};

impl Model {
    /// The same plant as expressions; a plant of matrices or of the library is equal up to rounding.
    ///
    /// # Errors
    /// [`ExpressionPlantError`] for a plant with more rows than an expression plant may have.
    pub fn expressions(&self) -> Result<ExpressionPlant, ExpressionPlantError> {
        match self {
            Self::Expressions(plant, _) => Ok(plant.clone()),
            Self::Linear(plant) => linear(plant),
            Self::Builtin(builtin) => of_library(builtin),
        }
    }
}

fn of_library(builtin: &Builtin) -> Result<ExpressionPlant, ExpressionPlantError> {
    let joint = |a44: f64, outputs: usize| {
        let last = if a44 == 0.0 { String::new() } else { format!(" + {a44:?}*x4") };
        let f = [
            "x2".to_owned(),
            "-48.6*x1 - 1.25*x2 + 48.6*x3 + 21.6*u1".to_owned(),
            "x4".to_owned(),
            format!("19.5*x1 - 19.5*x3{last} - 3.33*sin(x3)"),
        ];
        plant(&f, &["x1", "x2", "x3"][..outputs], 1)
    };
    match builtin {
        Builtin::DoubleIntegrator(plant) | Builtin::ThirdOrder(plant) => linear(plant),
        Builtin::FlexibleJoint(_) => joint(0.0, 2),
        Builtin::FlexibleJointPrinted(plant) => joint(plant.linear_part()[(3, 3)], 3),
        Builtin::Chaotic(_) => plant(&["ln(0.1 + exp(x2 - x1))", "x1*x3", "0.2 - x1*x2"], &["x1", "x2"], 0),
        Builtin::Cuk(cuk) => {
            let parameters =
                [("L1", cuk.l1), ("C2", cuk.c2), ("L3", cuk.l3), ("C4", cuk.c4), ("G", cuk.g), ("E", cuk.e)];
            let f = ["(E - (1 - u1)*x2)/L1", "((1 - u1)*x1 + u1*x3)/C2", "-(u1*x2 + x4)/L3", "(x3 - G*x4)/C4"];
            let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
            ExpressionPlant::new(&f, &["x2", "x3"], 1, &parameters)
        }
        Builtin::ReverseDuffing(_) => plant(&["x2^3", "-x1"], &["x1"], 0),
        Builtin::VanDerPol(oscillator) => {
            plant(&["x2".to_owned(), format!("{:?}*(1 - x1^2)*x2 - x1", oscillator.mu)], &["x1"], 0)
        }
        Builtin::ExponentialCascade(_) => {
            plant(&["exp(x3) - x1^2*x1", "x1^2 + sin(x1) - x2", "1/(x1^2 + 1) + x1*u1"], &["x1"], 1)
        }
    }
}

fn plant<S: AsRef<str>>(f: &[S], h: &[&str], inputs: usize) -> Result<ExpressionPlant, ExpressionPlantError> {
    let f: Vec<&str> = f.iter().map(AsRef::as_ref).collect();
    ExpressionPlant::new(&f, h, inputs, &Parameters::new())
}

fn linear(plant: &StateSpace) -> Result<ExpressionPlant, ExpressionPlantError> {
    let zero = |length| DVector::zeros(length);
    let (n, m, p) = (plant.a.nrows(), plant.b.ncols(), plant.c.nrows());
    in_deviations(plant, (&zero(n), &zero(m)), (&zero(n), &zero(p)))
}

/// The linearisation at an operating point in discrete time, as a plant of the states themselves:
/// `x+ = x0 + A (x - x0) + B (u - u0)`, `y = y0 + C (x - x0) + D (u - u0)`.
pub(super) fn around(plant: &StateSpace, point: &OperatingPoint) -> Result<ExpressionPlant, ExpressionPlantError> {
    in_deviations(plant, (&point.x, &point.u), (&point.x, &point.y))
}

/// `from + A (x - x0) + B (u - u0)` for both equations.
fn in_deviations(
    plant: &StateSpace,
    (x0, u0): (&DVector<f64>, &DVector<f64>),
    (f0, h0): (&DVector<f64>, &DVector<f64>),
) -> Result<ExpressionPlant, ExpressionPlantError> {
    let inputs = plant.b.ncols();
    let zero = DMatrix::zeros(plant.c.nrows(), inputs);
    let d = plant.d.as_ref().unwrap_or(&zero);
    let rows = |from: &DVector<f64>, a: &DMatrix<f64>, b: &DMatrix<f64>| -> Vec<String> {
        (0..a.nrows())
            .map(|i| {
                let deviation = |name: &str, j: usize, value: f64| match value {
                    0.0 => format!("{name}{}", j + 1),
                    value => format!("({name}{} - ({value:?}))", j + 1),
                };
                let states = (0..a.ncols()).map(|j| (a[(i, j)], deviation("x", j, x0[j])));
                let terms = states.chain((0..inputs).map(|j| (b[(i, j)], deviation("u", j, u0[j]))));
                let terms = terms.filter(|(factor, _)| *factor != 0.0).map(|(factor, of)| match factor {
                    1.0 => of,
                    factor => format!("({factor:?})*{of}"),
                });
                let start = (from[i] != 0.0).then(|| format!("({:?})", from[i]));
                let terms: Vec<String> = start.into_iter().chain(terms).collect();
                if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
            })
            .collect()
    };
    ExpressionPlant::new(&rows(f0, &plant.a, &plant.b), &rows(h0, &plant.c, d), inputs, &Parameters::new())
}
