//! Slips of the paper's text: a formula, words of the abstract and of the conclusion, and the numbers of the figures.

use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::{Beta, EstimateAndError, MeanValueObserver, Observer, ObserverDimensions};
use luenberger_plants::{Chaotic, Differentiable, flexible_joint};
use luenberger_random::Draws;
use luenberger_sim::{Scenario, Signal};
use nalgebra::{Const, DMatrix, SVector, Vector1, Vector3, Vector4};

use super::example2::{PLANT, XHAT0};
use super::runs::{OBSERVER, System, norms, real};
use super::theorem1::cases;
use crate::claim::{CheckError, Claim, Class, Outcome, Quote};
use crate::context::Context;
use crate::evidence::{Evidence, Tolerance};
use crate::value::{Printed, short};

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Misprint,
            "mvt.eq18",
            "Section 3.3, (18)",
            "e'Ge < e'Ge for all (e, x̂) (the largest difference of the two sides)",
            &["600 random segments of three plants, η = 1"],
            equation_18,
        )
        .quoting(
            "we can conclude that for all (e, x̂) ∈ Rⁿ, we find: eᵀG_{x̂,u,e}e < eᵀG_{x̂,u,e}e (18)",
            "a number less than itself; (15) to (17) give eᵀD_x(f)(c_i)e < eᵀG e, D and G having got one name in (16)",
        ),
        Claim::holds(
            Class::Misprint,
            "mvt.linear-term",
            "Abstract",
            "Example 1 has a linear term, and Example 2 is a linear system (entries of Df that are constant and not 0 in Example 1, and that vary in Example 2)",
            &["Df at 50 random states"],
            linear_term,
        )
        .quoting(
            "The first studies a chaotic system with a linear term (ẋ = f(x, u)) and the second deals with a linear system (ẋ = Ax + f(x, u)).",
            "the introduction has \"without a linear term\" and \"a nonlinear system with a linear term\", as the examples are",
        ),
        Claim::holds(
            Class::Misprint,
            "mvt.unknown-inputs",
            "Section 5",
            "the observer reconstructs the state with an unknown input (largest |x - x̂| in the last of 20 s, with u and without)",
            &[XHAT0, PLANT, "Example 2 from e0, η = 1; without u the observer has u = 0"],
            unknown_inputs,
        )
        .quoting(
            "A full order nonlinear observer was proposed for a large class of nonlinear systems with unknown inputs.",
            "the introduction has \"a new nonlinear observer design without unknown inputs\", and (3) has u in it",
        ),
        Claim {
            id: "mvt.figure-numbers",
            class: Class::Misprint,
            place: "Sections 3.2.1, 4",
            statement: "the figures are cited by their numbers (the numbers cited, in the order of the captions that they are for)",
            printed: Printed::Decimals("2 3 4 5 6 7 8 9"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["a citation is for the figure whose caption has its subject"],
            quote: Some(Quote {
                text: "the functions X(βi) ≃ 0 (figure 4) at each moment of the simulation for the βi (figure 3) parameters",
                reading: "Figure 3 is captioned \"Evolution of X(βi)\" and Figure 2 \"Evolution of βi parameters\": every citation is one too high",
            }),
            proof: None,
            check: figure_numbers,
        },
    ]
}

/// The captions of the paper, and the subjects for which its text cites figures, in the order of the numbers cited.
const CAPTIONS: [&str; 9] = [
    "Determination of βi parameters",
    "Example 1: evolution of βi parameters",
    "Example 1: evolution of X(βi)",
    "Example 1: evolution of observer's error and real error",
    "Example 1: evolution of the state x3",
    "Example 2: evolution of βi parameters",
    "Example 2: evolution of X(βi)",
    "Example 2: evolution of observer's error and real error",
    "Example 2: evolution of the state x4",
];
const CITED: [&str; 8] = [
    "Determination of βi parameters",
    "Example 1: evolution of βi parameters",
    "Example 1: evolution of X(βi)",
    "Example 1: evolution of observer's error and real error",
    "Example 1: evolution of the state x3",
    "Example 2: evolution of βi parameters",
    "Example 2: evolution of X(βi)",
    "Example 2: evolution of observer's error and real error",
];

fn figure_numbers(_: &Context) -> Result<Outcome, CheckError> {
    let number = |subject: &str| CAPTIONS.iter().position(|caption| *caption == subject).map(|k| (k + 1) as f64);
    let found: Option<Vec<f64>> = CITED.iter().map(|subject| number(subject)).collect();
    Ok(Outcome::new(Evidence::value(found.ok_or("a subject without a caption")?))
        .note("Computed are the numbers of the captions. Fig. 9 is cited as \"the following figure\"."))
}

/// `e'De` and `e'Ge` at random segments of a plant, η = 1.
fn forms<S, const N: usize, const M: usize, const P: usize>(plant: &S, random: &mut Draws) -> Vec<[f64; 2]>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let form = |_| {
        let xhat = SVector::<f64, N>::from_fn(|_, _| 3.0 * random.unit());
        let e = SVector::<f64, N>::from_fn(|_, _| 3.0 * random.unit());
        let d = mean_value(plant, 0.0, &xhat, &SVector::zeros(), &e).jacobian;
        let alpha = |k: usize| d.row(k).abs().sum() + d.column(k).abs().sum();
        [e.dot(&(d * e)), (0..N).map(|k| alpha(k) * e[k] * e[k]).sum()]
    };
    (0..200).map(form).collect()
}

fn equation_18(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = cases();
    let all = [
        forms(&Chaotic, &mut random),
        forms(&flexible_joint::corrected(), &mut random),
        forms(&flexible_joint::printed(), &mut random),
    ]
    .concat();
    if let Some([d, g]) = all.iter().find(|[d, g]| d >= g) {
        return Err(format!("e'De = {d} is not below e'Ge = {g}: (18) is no slip").into());
    }
    let difference = |[left, right]: [f64; 2]| left - right;
    let printed = all.iter().map(|&[_, g]| difference([g, g])).fold(f64::NEG_INFINITY, f64::max);
    Ok(Outcome::new(Evidence::holds_by(printed < 0.0, printed))
        .note("With D on the left it holds in each of the 600 cases."))
}

/// For each entry of Df at random states: its range.
fn ranges<S, const N: usize, const M: usize, const P: usize>(plant: &S, random: &mut Draws) -> Vec<(f64, f64)>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let mut found = vec![(f64::INFINITY, f64::NEG_INFINITY); N * N];
    for _ in 0..50 {
        let x = SVector::<f64, N>::from_fn(|_, _| 3.0 * random.unit());
        let df = plant.state_jacobian(0.0, &x, &SVector::zeros());
        for (range, &entry) in found.iter_mut().zip(df.iter()) {
            *range = (range.0.min(entry), range.1.max(entry));
        }
    }
    found
}

#[expect(clippy::unnecessary_wraps, reason = "the signature of every check")]
fn linear_term(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = cases();
    let (first, second) = (ranges(&Chaotic, &mut random), ranges(&flexible_joint::corrected(), &mut random));
    let constant = |(low, high): &(f64, f64)| high - low <= 16.0 * f64::EPSILON * high.abs().max(1.0);
    let linear_in_first = first.iter().filter(|range| constant(range) && range.1 != 0.0).count();
    let nonlinear_in_second = second.iter().filter(|range| !constant(range)).count();
    Ok(Outcome::new(Evidence::holds_by(
        linear_in_first > 0 && nonlinear_in_second == 0,
        [linear_in_first as f64, nonlinear_in_second as f64],
    ))
    .note("No state enters Example 1 linearly, and the sine of Example 2 makes the entry (4, 3) of Df vary."))
}

type Joint =
    MeanValueObserver<luenberger_plants::flexible_joint::FlexibleJoint<3>, Beta, f64, Const<4>, Const<1>, Const<3>>;

/// The observer of Example 2 that does not see its input.
struct WithoutInput(Joint);

impl Observer<f64> for WithoutInput {
    type State = EstimateAndError<f64, Const<4>>;
    type Input = Vector1<f64>;
    type Output = Vector3<f64>;
    type Estimate = Vector4<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        self.0.dimensions()
    }

    fn derivative(&self, t: f64, state: &Self::State, _u: &Vector1<f64>, y: &Vector3<f64>) -> Self::State {
        self.0.derivative(t, state, &Vector1::zeros(), y)
    }

    fn estimate(&self, t: f64, state: &Self::State, _u: &Vector1<f64>, y: &Vector3<f64>) -> Vector4<f64> {
        self.0.estimate(t, state, &Vector1::zeros(), y)
    }

    fn initial(&self, t: f64, estimate: &Vector4<f64>, _u: &Vector1<f64>, y: &Vector3<f64>) -> Self::State {
        self.0.initial(t, estimate, &Vector1::zeros(), y)
    }
}

fn unknown_inputs(_: &Context) -> Result<Outcome, CheckError> {
    let (start, plant) = (System::Corrected.start(), flexible_joint::corrected());
    let observer = || MeanValueObserver::new(plant, 1.0, Beta, Vector4::from_column_slice(start.e0));
    let late = |error: &DMatrix<f64>| norms(error)[1900..].iter().fold(0.0, |largest: f64, e| largest.max(*e));
    let scenario = || Scenario::new(plant).initial_state(start.x).input(Signal::scalar(f64::sin)).until(20.0, 2001);
    let with = scenario().observer(OBSERVER, observer()?, start.xhat).run()?;
    let without = scenario().observer(OBSERVER, WithoutInput(observer()?), start.xhat).run()?;
    let [with, without] = [late(real(&with)?), late(real(&without)?)];
    // Both start at 3.5.
    Ok(Outcome::new(Evidence::holds_by(without <= 1e-6 && with <= 1e-6, [with, without])).note(format!(
        "Given x(0) and u the error stays at rounding, {}. An input that it does not know keeps the error at {}.",
        short(with),
        short(without)
    )))
}
