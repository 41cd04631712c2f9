//! Theorem 1: what its proof shows, and five plants as counterexamples to its statement, each with every hypothesis
//! evaluated.

use luenberger_design::enclosure::enclose;
use luenberger_design::mean_value::LeastSquares;
use luenberger_design::{IntervalDual, Region};
use luenberger_observers::mean_value::beta::mean_value;
use luenberger_observers::{Beta, EstimateAndError, MeanValueObserver, Observer};
use luenberger_plants::counterexamples::{self, Bistable, Dimple};
use luenberger_plants::{Chaotic, Differentiable, LinearPlant, Plant, StaticPlant, double_integrator, flexible_joint};
use luenberger_proof::{Interval, Matrix};
use luenberger_random::{Draws, Purpose, Stream};
use nalgebra::{Const, Matrix1, SVector, Vector1};

use super::runs::{
    Experiment, Given, OBSERVER, Run, System, Theorem, along, beta_solves, internal, last, norms, real, run,
};
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Counterexample, Evidence, Hypothesis};
use crate::hypotheses::{self, condition_4};
use crate::value::{Value, short};

const SEED: u64 = 2018;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Theorem,
            "mvt.thm1.as-stated",
            "Theorem 1",
            "with (4), η ≥ 1 and G by (5), x̂ converges to x",
            &["η = 1; β by a bracketed root for each row; five plants, each with a start from which x̂ must converge"],
            as_stated,
        )
        .quoting(
            "If there exist positive constants η ≥ 1 such that: D_x(f)(c_i) - G < 0 (4), G is matrix which have to be designed such that x̂ asymptotically converges to x, c_i = x̂ + β_i e",
            "(4) and (5) are sufficient for x̂ → x (\"we can give a sufficient condition under which the observer given by (3) is indeed a nonlinear observer\"), from every x̂(0) and e(0): \
             the paper runs e(0) ≠ x(0) - x̂(0) too; (4) is asked for where the observer runs, as a quadratic form",
        ),
        Claim::holds(
            Class::Theorem,
            "mvt.thm1.internal-decrease",
            "Section 3.3, (21)",
            "V = e'e/2 of the internal error decreases when η ≥ 1 (random x̂ and e, three plants)",
            &["200 segments for each plant, η = 1 and 2"],
            internal_decrease,
        )
        .proved_in(
            "theory-mvt.md",
            "## Decrease of the internal error",
            "tests/tests/it/theorems_mvt.rs",
            "the_internal_error_stays_below_its_envelope",
        ),
        Claim::holds(
            Class::Theorem,
            "mvt.necessary",
            "Section 3.1",
            "(4) is necessary for the observer: where x̂ goes to x, (4) holds along the run",
            &["x' = x - x³, y = x, from x(0) = 1.2, x̂(0) = 0.5, e(0) = 0, η = 1"],
            necessary,
        )
        .quoting(
            "In this section, we will first present the structure and necessary and sufficient condition for existence of the proposed nonlinear observer.",
            "necessary is: x̂ → x only if (4) holds where the observer runs; the theorem itself says \"sufficient\"",
        ),
        Claim::holds(
            Class::Ours,
            "mvt.thm1.eta-half",
            "beyond the paper: Theorem 1; (17), (21)",
            "η > ½ suffices for the decrease, and x' = x needs it (the smallest η with which V decreases, over 600 segments of three plants and for x' = x)",
            &["the paper's η ≥ 1 is sufficient too, and it claims no more"],
            eta_half,
        ),
        Claim::holds(
            Class::Ours,
            "mvt.lsqnonlin-finds-beta",
            "beyond the paper: Section 3.2.1, (12)",
            "bounded least squares for (12) finds the root of X from 0.1 or 0.9, and stops at ½, a stationary point (|X| where it stops, from ½ and from five starts)",
            &["the trust-region-reflective method of lsqnonlin; the paper does not say where it starts"],
            least_squares,
        ),
        Claim::holds(
            Class::Theorem,
            "mvt.eq7",
            "Section 3.2, (7), (10)",
            "the estimation error x - x̂ obeys (10), ė = (D - G) e, whatever e(0) the observer has",
            &["both examples from e01, η = 1; the residual of (10) from 1 s on, when the internal error is gone", "D between x̂ and x, as (8) has it; G the observer's own"],
            equation_7,
        )
        .quoting(
            "ė(t) = ẋ(t) - x̂̇(t) = f_{x,u} - (f_{x̂,u} + G e_1(t)) (7) [..] ė(t) = (D_x(f)(c_i) - G)e(t) (10)",
            "the e of (7), (8) and (10) is x - x̂ (\"c_i = x̂ + β_i(x - x̂) = x̂ + β_i e\"), for every e(0) of (3b), the e01 of the examples included",
        ),
    ]
}

/// A plant with a start from which x̂ ought to go to x, and how far it is from there at the end.
struct Missed {
    case: &'static str,
    what: &'static str,
    /// The error below which x̂ would count as x.
    small: f64,
}

/// The samples of a run; the hypotheses are evaluated at them, and on the box that holds them.
const SAMPLES: u32 = 200;

/// The observer as printed, η = 1, on any plant, to `end`.
fn fly<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    x: [f64; N],
    xhat: [f64; N],
    e0: [f64; N],
    end: f64,
) -> Result<Run, CheckError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Clone + Send + Sync,
{
    let times = (0..=SAMPLES).map(|k| end * f64::from(k) / f64::from(SAMPLES)).collect();
    let run = Experiment { eta: 1.0, e0: &e0, mean: Theorem::Beta, l: None, times, rtol: 1e-11 }.from(
        plant.clone(),
        &x,
        &xhat,
    )?;
    along(plant, run)
}

/// The hypotheses that do not need the Jacobian: the outputs, η and β.
fn common<S, const N: usize, const M: usize, const P: usize>(plant: &S, run: &Run) -> Vec<Hypothesis>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
{
    let unit = |j: usize| SVector::<f64, N>::from_fn(|i, _| f64::from(u8::from(i == j)));
    let first = (0..N).all(|j| {
        let y = plant.output(0.0, &unit(j), &SVector::zeros());
        (0..P).all(|i| y[i].total_cmp(&f64::from(u8::from(i == j))).is_eq())
    });
    let (solved, residual) = beta_solves(run);
    vec![
        Hypothesis::computed("C = [I_m 0], rank C = m", first, "by its columns, without rounding"),
        Hypothesis::computed(
            "η ≥ 1, G by (5), (6)",
            true,
            "η = 1; G is formed from D by (5), (6), in the observer and for (4)",
        ),
        Hypothesis::computed(
            "β_i in [0, 1] with X(β) = 0 (11)",
            solved,
            format!("at every sample of the run, where |X| is at most {}", short(residual)),
        ),
    ]
}

impl Missed {
    fn of(self, run: &Run, hypotheses: Vec<Hypothesis>) -> Result<Counterexample, CheckError> {
        let error = real(&run.trajectory)?;
        let error: Vec<f64> = error.row(error.nrows() - 1).iter().copied().collect();
        let left = error.iter().fold(0.0, |sum: f64, e| sum.hypot(*e));
        let internal = last(&norms(&internal(&run.trajectory)?));
        Ok(Counterexample {
            case: self.case.to_owned(),
            what: format!("{} (the internal error is {} by then)", self.what, short(internal)),
            violation: left - self.small,
            witness: Some(Value::from(error)),
            hypotheses,
        })
    }

    /// On a linear plant, whose D is A everywhere.
    fn linear<const N: usize, const M: usize, const P: usize>(
        self,
        plant: &StaticPlant<f64, N, M, P>,
        run: &Run,
    ) -> Result<Counterexample, CheckError>
    where
        StaticPlant<f64, N, M, P>: Differentiable<f64, Const<N>, Const<M>, Const<P>>,
    {
        let a = Matrix::from_fn(N, N, |i, j| Interval::of(plant.a[(i, j)]));
        let mut hypotheses = common(plant, run);
        hypotheses.push(Hypothesis::computed("f is continuously differentiable", true, "it is linear"));
        hypotheses.push(Hypothesis::proof(CONDITION_4, &condition_4(&a, 1.0)?).only("everywhere"));
        self.of(run, hypotheses)
    }

    /// On any plant, for every D on the box that holds the segments of the run.
    fn nonlinear<S, const N: usize, const M: usize, const P: usize>(
        self,
        plant: &S,
        run: &Run,
    ) -> Result<Counterexample, CheckError>
    where
        S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Plant<IntervalDual>,
    {
        let region = Region::new(&segments::<N>(run, 0..run.trajectory.t.len())?);
        let mut hypotheses = common(plant, run);
        hypotheses.push(hypotheses::differentiable(plant, &region));
        let found = condition_4(&enclose(plant, &region)?.a, 1.0)?;
        hypotheses.push(Hypothesis::proof(CONDITION_4, &found).only(&format!(
                "along the run only: for every D on the box {} that holds its segments",
                region
                    .states()
                    .iter()
                    .map(|(low, high)| format!("[{}, {}]", short(*low), short(*high)))
                    .collect::<Vec<_>>()
                    .join(" x ")
            )));
        self.of(run, hypotheses)
    }
}

const CONDITION_4: &str = "(4), as D + D' - 2G < 0";

/// The box that holds x̂ and x̂ + e at these samples.
fn segments<const N: usize>(run: &Run, samples: std::ops::Range<usize>) -> Result<Vec<(f64, f64)>, CheckError> {
    let state = &run.trajectory.observer(OBSERVER)?.state;
    let ends = |i: usize| samples.clone().flat_map(move |k| [state[(k, i)], state[(k, i)] + state[(k, N + i)]]);
    Ok((0..N)
        .map(|i| ends(i).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x))))
        .collect())
}

fn as_stated(_: &Context) -> Result<Outcome, CheckError> {
    let cases = vec![tenth_of_the_speed()?, unstable()?, bistable()?, stable()?, indistinguishable()?];
    Ok(Outcome::new(Evidence::Counterexamples(cases)).note(
        "The proof takes e for x - x̂, (7). With z = x̂ + e the observer says z' = f(z, u) + [G_m; 0](y - Cz): the difference x - z, which decides whether x̂ goes to x, is \
         injected into the measured rows only, whatever that does to it. (4) follows from (5) wherever no alpha_k is 0. x' = u, y = x is no counterexample: D = G = 0, and (4) reads 0 < 0.",
    ))
}

/// alpha = (1, 1): d2' = 0, d1' = d2 - d1.
fn tenth_of_the_speed() -> Result<Counterexample, CheckError> {
    let plant = double_integrator();
    let run = fly(&plant, [2.0, -3.0], [0.0, 0.0], [1.8, -2.7], 60.0)?;
    Missed {
        case: "the double integrator, e(0) = 0.9 (x(0) - x̂(0))",
        what: "x - x̂ after 60 s, less a hundredth of what was not given: a tenth of the speed's error stays for ever",
        small: 0.003,
    }
    .linear(&plant, &run)
}

/// d2' = d2/2.
fn unstable() -> Result<Counterexample, CheckError> {
    let (plant, share) = (counterexamples::unstable(), 1.0 - 1e-6);
    let run = fly(&plant, [1.0, 1.0], [0.0, 0.0], [share, share], 30.0)?;
    Missed {
        case: "x1' = x2, x2' = x2/2, y = x1, e(0) all but a millionth of x(0) - x̂(0)",
        what: "x - x̂ after 30 s, less 1: of the millionth that was not given, as e^(t/2)",
        small: 1.0,
    }
    .linear(&plant, &run)
}

/// G = 2 |1 - 3 xhat^2| vanishes at -1/sqrt 3: from -1 the estimate of x = 1 stops before that, at (-1 - sqrt 57)/14.
fn bistable() -> Result<Counterexample, CheckError> {
    let run = fly(&Bistable, [1.0], [-1.0], [0.0], 40.0)?;
    Missed {
        case: "x' = x - x³, y = x, e(0) = 0",
        what: "x - x̂ after 40 s, less a hundredth of its start: from x̂(0) = -1 the estimate of the measured x = 1 stops at (-1 - √57)/14, where G is too small",
        small: 0.02,
    }
    .nonlinear(&Bistable, &run)
}

/// x1 = 0, x2 = ln 0.9 and any x3: x1' = ln(0.1 + 0.9) = 0, x2' = 0 x3, x3' = 0.2. The output is the same for all of
/// them.
fn indistinguishable() -> Result<Counterexample, CheckError> {
    let x2 = 0.9_f64.ln();
    let run = fly(&Chaotic, [0.0, x2, -1.0], [0.0, x2, -2.0], [0.0, 0.0, 0.5], 5.0)?;
    Missed {
        case: "the plant of Example 1 from x(0) = (0, ln 0.9, -1)",
        what: "x - x̂ after 5 s, less a hundredth of its start: every x3(0) gives the same output, x1 = 0 and x2 = ln 0.9, so that no observer of this plant can converge from everywhere",
        small: 0.01,
    }
    .nonlinear(&Chaotic, &run)
}

/// alpha_1 = 10: d' = [-13 2; -2 1] d, whose determinant is negative, although both poles of the plant are at -1.
fn stable() -> Result<Counterexample, CheckError> {
    let plant = counterexamples::stable();
    let run = fly(&plant, [1.0, 1.0], [0.0, 0.0], [0.0, 0.0], 10.0)?;
    Missed {
        case: "x1' = -3x1 + 2x2, x2' = -2x1 + x2, y = x1, a stable plant, e(0) = 0",
        what: "x - x̂ after 10 s, less 1: a copy of the plant that looks at no output converges, and the gain makes it diverge",
        small: 1.0,
    }
    .linear(&plant, &run)
}

/// (4) sample by sample, on the boxes of single segments: the worst of the verdicts.
fn along_the_run<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    run: &Run,
) -> Result<Hypothesis, CheckError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Plant<IntervalDual>,
{
    let mut verdicts = Vec::new();
    for k in (0..run.trajectory.t.len()).step_by(10) {
        let jacobians = enclose(plant, &Region::new(&segments::<N>(run, k..k + 1)?))?;
        verdicts.push(condition_4(&jacobians.a, 1.0)?);
    }
    Ok(hypotheses::in_each(CONDITION_4, &verdicts).only("the segments of the run, every tenth sample"))
}

/// The residual of (10) for `e = x - x̂` along a run, from 1 s on, and the size of its left side there, both at the
/// largest.
fn residual_of_10<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    run: &Run,
) -> Result<[f64; 2], CheckError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Clone + Send + Sync,
{
    let trajectory = &run.trajectory;
    let state = &trajectory.observer(OBSERVER)?.state;
    let observer = MeanValueObserver::new(plant.clone(), 1.0, Beta, SVector::<f64, N>::zeros())?;
    let (mut residual, mut size) = (0.0_f64, 0.0_f64);
    for (k, &t) in trajectory.t.iter().enumerate().filter(|(_, t)| **t >= 1.0) {
        let (x, u) = (
            SVector::<f64, N>::from_fn(|i, _| trajectory.x[(k, i)]),
            SVector::<f64, M>::from_fn(|i, _| trajectory.u[(k, i)]),
        );
        let xhat = SVector::<f64, N>::from_fn(|i, _| state[(k, i)]);
        let internal = SVector::<f64, N>::from_fn(|i, _| state[(k, N + i)]);
        let y = plant.output(t, &x, &u);
        let rate = observer.derivative(t, &EstimateAndError::new(&xhat, &internal), &u, &y).estimate();
        let (error, left) = (x - xhat, plant.derivative(t, &x, &u) - rate);
        let own = mean_value(plant, t, &xhat, &u, &internal).jacobian;
        let alpha = SVector::<f64, N>::from_fn(|k, _| own.row(k).abs().sum() + own.column(k).abs().sum());
        let between = mean_value(plant, t, &xhat, &u, &error).jacobian;
        residual = residual.max((left - between * error + alpha.component_mul(&error)).norm());
        size = size.max(left.norm());
    }
    Ok([residual, size])
}

fn equation_7(context: &Context) -> Result<Outcome, CheckError> {
    let (first, second) =
        (run(context, System::Chaotic, 1.0, Given::E01)?, run(context, System::Corrected, 1.0, Given::E01)?);
    let joint = flexible_joint::corrected();
    let case = |name: &str, [residual, size]: [f64; 2], mut found: Vec<Hypothesis>, condition: Hypothesis| {
        found.push(condition);
        Counterexample {
            case: name.to_owned(),
            what: format!("the largest residual of (10) from 1 s on, where ẋ - x̂' is at most {}", short(size)),
            // Terms of size up to 200, good to 1e-9.
            violation: residual - 1e-6,
            witness: Some(Value::Number(residual)),
            hypotheses: found,
        }
    };
    Ok(Outcome::new(Evidence::Counterexamples(vec![
        case("Example 1", residual_of_10(&Chaotic, &first)?, common(&Chaotic, &first), along_the_run(&Chaotic, &first)?),
        case("Example 2", residual_of_10(&joint, &second)?, common(&joint, &second), along_the_run(&joint, &second)?),
    ]))
    .note(
        "x - x̂ obeys (7) with e1 in it. In the measured rows e1 is x - x̂, in the others the internal e: the residual is G (x - x̂ - e) in those rows. (10) holds for the internal e alone, and for x - x̂ \
         where the two are equal, as from e0.",
    ))
}

/// From x̂(0) = 0.5 the estimate passes 1/√3, where D and with it G are 0.
fn necessary(_: &Context) -> Result<Outcome, CheckError> {
    let run = fly(&Bistable, [1.2], [0.5], [0.0], 40.0)?;
    let state = &run.trajectory.observer(OBSERVER)?.state;
    // e stays 0, and D is Df at x̂.
    let slope = |k: usize| {
        mean_value(&Bistable, 0.0, &Vector1::new(state[(k, 0)]), &SVector::zeros(), &Vector1::new(state[(k, 1)]))
            .jacobian[0]
    };
    let last = run.trajectory.t.len() - 1;
    let (before, after) = (slope(0), slope(last));
    let left = real(&run.trajectory)?[(last, 0)].abs();
    let internal = internal(&run.trajectory)?.amax();
    let crossing = (0..last).find(|&k| slope(k) > 0.0 && slope(k + 1) <= 0.0).ok_or("D does not change its sign")?;
    let mut hypotheses = common(&Bistable, &run);
    hypotheses.push(Hypothesis::computed("x̂ → x", left <= 1e-9, format!("|x - x̂| is {} at 40 s", short(left))));
    Ok(Outcome::new(Evidence::counterexample(
        format!(
            "D goes from {} to {}, and is 0 on the way, at a time between {} and {} s: (4) reads 0 < 0 there",
            short(before),
            short(after),
            short(run.trajectory.t[crossing]),
            short(run.trajectory.t[crossing + 1])
        ),
        if internal == 0.0 { before.min(-after) } else { -internal },
        Some(Value::from([state[(crossing, 0)], state[(crossing + 1, 0)]])),
        hypotheses,
    ))
    .note("With D = 1 - 3 x̂² also G = 2 |D| is 0 at x̂ = 1/√3; f alone moves the estimate on, and it arrives."))
}

pub(super) fn cases() -> Draws {
    Stream::new(SEED, Purpose::RandomCase, 0).draws(0)
}

/// `e'e'` (the second a derivative) along (3b) at random segments, with η = 1 and 2, and the size of its terms.
fn slopes<S, const N: usize, const M: usize, const P: usize>(
    plant: &S,
    random: &mut Draws,
) -> Result<Vec<[f64; 3]>, CheckError>
where
    S: Differentiable<f64, Const<N>, Const<M>, Const<P>> + Clone + Send + Sync,
{
    (0..200)
        .map(|_| {
            let xhat = SVector::<f64, N>::from_fn(|_, _| 3.0 * random.unit());
            let e = SVector::<f64, N>::from_fn(|_, _| 3.0 * random.unit());
            let (u, y) = (SVector::<f64, M>::zeros(), SVector::<f64, P>::zeros());
            let mut found = [0.0; 3];
            for (slot, eta) in [1.0, 2.0].into_iter().enumerate() {
                let observer = MeanValueObserver::new(plant.clone(), eta, Beta, e)?;
                let state = EstimateAndError::new(&xhat, &e);
                let slope = observer.derivative(0.0, &state, &u, &y).error();
                found[slot] = e.dot(&slope);
                found[2] = e.norm() * slope.norm();
            }
            Ok(found)
        })
        .collect()
}

fn every_slope() -> Result<Vec<[f64; 3]>, CheckError> {
    let mut random = cases();
    Ok([
        slopes(&Chaotic, &mut random)?,
        slopes(&flexible_joint::corrected(), &mut random)?,
        slopes(&flexible_joint::printed(), &mut random)?,
    ]
    .concat())
}

fn internal_decrease(_: &Context) -> Result<Outcome, CheckError> {
    let truths: Vec<_> = every_slope()?.iter().map(|[one, two, _]| Some(*one < 0.0 && *two < 0.0)).collect();
    Ok(Outcome::new(Evidence::cases(truths)).note(format!(
        "Proof: e'De ≤ Σ |D_ij| (e_i² + e_j²)/2 = Σ α_k e_k²/2, hence V' ≤ -(η - ½) Σ α_k e_k². It is the internal error that decreases. Seed {SEED}."
    )))
}

/// `V' = a - eta b` is affine in η: two values give a and b, and V' < 0 for η > a/b.
fn eta_half(_: &Context) -> Result<Outcome, CheckError> {
    let needed = |[one, two, _]: &[f64; 3]| (2.0 * one - two) / (one - two);
    let sampled = every_slope()?.iter().map(needed).fold(f64::NEG_INFINITY, f64::max);
    let scalar = LinearPlant { a: Matrix1::new(1.0), b: Matrix1::new(1.0), c: Matrix1::new(1.0), d: None };
    let mut random = cases();
    let attained = slopes(&scalar, &mut random)?.iter().map(needed).fold(f64::NEG_INFINITY, f64::max);
    // The first bound to the rounding of a quotient of differences, the second attained.
    let holds = sampled <= 0.5 + 1e-9 && (attained - 0.5).abs() <= 1e-9;
    Ok(Outcome::new(Evidence::holds_by(holds, [sampled, attained])).note(format!(
        "|e_i e_j| ≤ (e_i² + e_j²)/2 has a factor ½ that (17) drops, and hence V' ≤ -(η - ½) Σ α_k e_k². Seed {SEED}."
    )))
}

fn least_squares(_: &Context) -> Result<Outcome, CheckError> {
    let (xhat, e, u) = (Vector1::new(0.0), Vector1::new(1.0), SVector::<f64, 0>::zeros());
    let middle = LeastSquares::new().solve(&Dimple, 0.0, &xhat, &u, &e)?;
    let several = LeastSquares::new().with_starts(5).solve(&Dimple, 0.0, &xhat, &u, &e)?;
    let bracketed = mean_value(&Dimple, 0.0, &xhat, &u, &e);
    let (stops, finds) = (middle.residual.amax(), several.residual.amax());
    Ok(Outcome::new(Evidence::holds_by(stops > 1e-3 && finds < 1e-9, [stops, finds])).note(format!(
        "x' = d³/3 - 2d⁵ with d = x - ½, from x̂ = 0 to x̂ + e = 1. From ½ it stops at β = {} with X = {}, a local minimum of X²; of the starts 0.1, 0.3, .., 0.9 the best ends at {}. A \
         bracket finds β = {} with X = {}. In the examples of the paper X has no such minimum on the runs.",
        short(middle.beta[0]),
        short(middle.residual[0]),
        short(several.beta[0]),
        short(bracketed.beta[0]),
        short(bracketed.residual[0])
    )))
}
