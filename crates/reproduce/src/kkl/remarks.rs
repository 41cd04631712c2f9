//! The remarks R1, R5 (footnote 3), R7, R8, R9 and R10, Assumption A1 and the shape of Q: small statements, each
//! computed on a plant small enough to be read.
//!
//! On van der Pol's oscillator with y = x1: the KKLO of Proposition 1 (`phi_i = lambda_i x1 + x2 - m(x1)`) and the PEBO
//! of R2 (`phi = x2 - m(x1)`, `phi' = -y`), `m(y) = mu (y - y^3/3)`.

use luenberger_observers::immersion_invariance::{Immersion, ImmersionInvarianceObserver};
use luenberger_observers::pseudo_inverse::pseudo_inverse;
use luenberger_observers::{KklMap, KklObserver, Observer, ObserverDimensions};
use luenberger_plants::{CukConverter, Plant, VanDerPol, plant};
use luenberger_random::{Draws, Purpose, Stream};
use luenberger_sim::{Scenario, SimError, Trajectory};
use nalgebra::{Matrix2, Matrix3, RealField, SVector, U0, U1, U2, U5, Vector1, Vector2, Vector4, convert};

use super::propositions::{LAMBDA, MU, Turned, assumption_1, injection, inverse, phi, phi_along};
use super::safety_nets::{self, Integration};
use crate::claim::{CheckError, Claim, Class, Outcome, Quote};
use crate::context::Context;
use crate::evidence::{Counterexample, Evidence, Hypothesis, Tolerance};
use crate::kkl::cuk::{self, Embedding, Tuning};
use crate::value::{Printed, Value, short};

const OSCILLATOR: &str = "van der Pol's oscillator, μ = 1, y = x1, from (2, 0)";
const END: f64 = 20.0;
const SAMPLES: usize = 401;
const SEED: u64 = 2018;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "kkl.a1.dimension",
            class: Class::Misprint,
            place: "Proposition 1, A1",
            statement: "n_ξ ≥ n (n_ξ of the KKLO of Table I, of its PEBO and of Proposition 6, beside n - p and n: each an observer of the paper)",
            printed: Printed::Holds(true),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["as the observers are defined here, which converge"],
            quote: Some(Quote {
                text: "There exist n_ξ negative real numbers λ_i, i = 1, 2, ..., n_ξ, with n_ξ ≥ n, and mappings [..] with n_ξ ≥ n - p, satisfying the following.",
                reading: "two bounds in one assumption: the second is what the paper's own observers fulfil, since φᴸ has y too",
            }),
            proof: None,
            check: dimension,
        },
        Claim::holds(
            Class::Theorem,
            "kkl.r1",
            "R1",
            "the KKLO has the attractive invariant manifold ξ = φ(x), and the PEBO the invariant foliation φ(x) - ξ = const (how far a start on the manifold leaves it, what is left of one beside it at \
             T = 20, and by how much φ - ξ of the PEBO moves, from three starts)",
            &[OSCILLATOR, "the KKLO of kkl.prop1, the PEBO of kkl.r2 without nets"],
            manifolds,
        )
        .quoting(
            "the KKLO (6), together with the dynamics of the system (1), admits an attractive and invariant manifold S := {ξ = φ(x)} [..] the PEBO generates an invariant foliation S_θ := {ξ = φ(x) + θ}",
            "the leaves are those of all constants θ, so that the sign, which (9) has the other way, does not matter",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r5.imaginary",
            "R5, footnote 3",
            "with a slight modification A may have purely imaginary eigenvalues (|x̂ - x| at T = 40 as it is, and with e^(At)θ estimated in the place of a constant)",
            &["x' = (x2, -x1), y = x1, φ = x, A = [0 1; -1 0], B = 0; from x(0) = (2, -1), ξ(0) = 0, θ̂(0) = 0, Γ = I"],
            imaginary,
        )
        .quoting(
            "With a slight modification it is also possible to consider the case of A with purely imaginary eigenvalues.",
            "the modification is not given; tried is φ(x) - ξ = e^{At}θ, whose θ is constant, with the regression y - Cξ = C e^{At}θ",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r7",
            "R7",
            "the manifold β(h(x), χ) = φ(x) of an I&IO is invariant, and its off-the-manifold dynamics depend on χ through d_M alone",
            &[
                "the [KKL+PEB]O of the converter written as an I&IO (β does not depend on y): pairs of χ with one β, and starts on the manifold",
                "x1' = x2, x2' = -x2, y = x1, φ = x2, β = χ1 + χ2 y: pairs of χ with one d_M",
            ],
            off_the_manifold,
        )
        .quoting(
            "the zero equilibrium of the dynamics of the off-the-manifold coordinate (16), which may be written as ḋ_M = Υ(x, χ, u) =: Υ_0(x, d_M, u) has an asymptotically stable equilibrium at the origin.",
            "(16) is a function of x, d_M and u: so it is where ∇_y β does not depend on χ, and n_χ > n_z admits others",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r8",
            "R8",
            "for n_χ = n_z the pseudo-inverse of (18) is the inverse, and Q falls out; the manifolds of the PEBO and the [KKL+PEB]O have fewer dimensions than their extensions (largest defect of the two)",
            &["200 random ∇_χβ, 3 x 3 and regular; the dimensions of Table I: n_z = 2, n_χ = 12 and 6"],
            square,
        )
        .quoting(
            "In the I&IO proposed in [11], [2] we fix n_χ = n_z ≤ n. In this case, (18) reduces to [..] and A4 is equivalent to requiring that ∇_χ β is a non-singular square matrix. For PEBO and [KKL+PEB]O, \
             the dimensions of their corresponding invariant manifolds are less than the dimensions of dynamic extensions.",
            "[∇_χβᵀ]† = [∇_χβᵀ]⁻¹, and I - [∇_χβᵀ]†∇_χβᵀ = 0",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r9",
            "R9, first statement",
            "the KKLO (6) coincides with the I&IO (18), (19) for β = ξ = χ, Υ = -Λφ + Λχ (their errors at T = 20)",
            &[OSCILLATOR, "both from x̂ = (0.5, 0.5)"],
            kklo_as_immersion,
        )
        .quoting(
            "the KKLO (6) coincides with the I&IO (18)-(19) with mappings selecting n_χ = n_z = q, β(y, χ) = ξ = χ, Υ(x, χ, u) = -Λφ(x) + Λχ with any mapping Q(y, χ, u)",
            "for every KKLO, also one whose φᴸ(ξ, y) does not keep the output; the second statement, on the PEBO, asks for outputs that are partial states, and this one does not. (18) has B(h(x̂), u) where (6) \
             has B(y, u)",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r9.pebo",
            "R9, second statement",
            "where the outputs are partial states the PEBO coincides with the I&IO with β = ξ + N(ζ, ξ, y) and Q = 0 (their errors of x2 at T = 20)",
            &[OSCILLATOR, "the PEBO of kkl.r2, α = 5, Γ = 2, from x̂2 = 1"],
            pebo_as_immersion,
        )
        .quoting(
            "If the measurable output signals are partial states, the PEBO coincides with the I&IO with mappings χ = col(ξ, ζ), β = ξ + N(ζ, ξ, y), [..] and Q = 0",
            "they give the same estimates from the same start",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r10",
            "R10",
            "a change of coordinates makes the outputs partial states, always",
            &["x' = -x, y = x²: smooth, with bounded trajectories, n = p = 1"],
            coordinates,
        )
        .quoting(
            "Notice that the condition that \"the measurable output signals are partial states\" in Proposition 5 is done without loss of generality because it is always possible to do a change of coordinates to verify it.",
            "for every plant (1) on its state space; locally it is possible where ∇h has full rank",
        ),
        Claim {
            id: "kkl.prop4.shape-of-q",
            class: Class::Misprint,
            place: "Proposition 4",
            statement: "Q(y, χ, u) is a matrix of n_χ x n_χ (rows and columns of what (18) adds to χ', for the I&IO of the converter that is a [KKL+PEB]O)",
            printed: Printed::Decimals("6 6"),
            tolerance: Tolerance::AsPrinted,
            assumptions: &["n_χ = 6"],
            quote: Some(Quote {
                text: "Q : R^p × R^{n_χ} × R^m → R^{n_χ × n_χ} an arbitrary mapping",
                reading: "(18) adds (I - [∇_χβᵀ]†∇_χβᵀ)Q to the column χ̇",
            }),
            proof: None,
            check: shape_of_q,
        },
    ]
}

fn draws() -> Draws {
    Stream::new(SEED, Purpose::RandomCase, 1).draws(0)
}

fn dimension(_: &Context) -> Result<Outcome, CheckError> {
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let length = |map: usize| map as f64;
    let kklo = Observer::<f64>::dimensions(&cuk::kklo(plant)?).state;
    let pebo = cuk::pebo(plant, &tuning)?;
    let xi_of_pebo = pebo.map().lambda(0.0, &Vector1::new(0.5), &Vector2::new(17.0, 0.2)).nrows();
    let sixth = crate::kkl::exponential_cascade::observer(1.0, 5.0)?;
    let xi_of_sixth = sixth.map().lambda(0.0, &Vector1::new(0.0), &Vector1::new(0.5)).nrows();
    // n_ξ, n - p, n.
    let rows = [(kklo, 2, 4), (xi_of_pebo, 2, 4), (xi_of_sixth, 2, 3)];
    if let Some((found, least, _)) = rows.iter().find(|(found, least, _)| found < least) {
        return Err(format!("n_ξ = {found} is below n - p = {least}: the second bound is no correction").into());
    }
    let numbers: Vec<f64> = rows.iter().flat_map(|&(found, least, n)| [found, least, n].map(length)).collect();
    Ok(Outcome::new(Evidence::holds_by(rows.iter().all(|(found, _, n)| found >= n), numbers))
        .note("Every observer of the paper has n_ξ = n - p, less than n."))
}

/// The KKLO from this ξ(0) and the PEBO from this x̂2.
fn beside(start: Option<[f64; 2]>, speed: f64) -> Result<Trajectory, CheckError> {
    let on = phi(&Vector2::new(2.0, 0.0));
    let estimate = start.map_or(inverse(&on), Vector2::from);
    Ok(Scenario::new(VanDerPol { mu: MU })
        .initial_state(&[2.0, 0.0])
        .observer("kklo", KklObserver::new(Turned::straight()), estimate.as_slice())
        .partial_observer("pebo", safety_nets::observer(Integration::open())?, &[speed], &[1])
        .tolerances(1e-12, 1e-13)
        .until(END, SAMPLES)
        .run()?)
}

fn manifolds(_: &Context) -> Result<Outcome, CheckError> {
    let (mut leaves, mut left, mut moved) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (start, speed) in [(None, 1.0), (Some([0.0, 0.0]), -3.0), (Some([-1.0, 2.0]), 0.5)] {
        let run = beside(start, speed)?;
        let states = [&run.observer("kklo")?.state, &run.observer("pebo")?.state];
        let x = |k: usize| Vector2::new(run.x[(k, 0)], run.x[(k, 1)]);
        let off = |k: usize| Vector2::new(states[0][(k, 0)], states[0][(k, 1)]) - phi(&x(k));
        let leaf = |k: usize| x(k)[1] - super::propositions::cubic(x(k)[0]) - states[1][(k, 0)];
        if start.is_none() {
            leaves = leaves.max((0..SAMPLES).map(|k| off(k).amax()).fold(0.0, f64::max));
        } else {
            left = left.max(off(SAMPLES - 1).amax());
        }
        moved = moved.max((0..SAMPLES).map(|k| (leaf(k) - leaf(0)).abs()).fold(0.0, f64::max));
    }
    // A thousand times the tolerance of the runs; e^-20 of a start of 6.
    let holds = leaves <= 1e-9 && left <= 1e-7 && moved <= 1e-9;
    Ok(Outcome::new(Evidence::holds_by(holds, [leaves, left, moved]))
        .instances(3)
        .given(assumption_1(&Matrix2::identity())))
}

plant!(Rotation, (2, 0, 1), |plant, t, x, u| [x[1], -x[0]], [x[0]]);

/// The plant `x' = (x2, -x1)`, y = x1.
#[derive(Clone, Copy)]
struct Rotation;

/// ξ' = Aξ with or without `x̂ = ξ + e^(At)θ̂`; the state is (ξ, θ̂).
struct Rotating {
    estimates: bool,
}

impl Observer<f64> for Rotating {
    type State = Vector4<f64>;
    type Input = SVector<f64, 0>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 4, inputs: 0, outputs: 1, estimate: 2 }
    }

    fn derivative(&self, t: f64, state: &Vector4<f64>, u: &SVector<f64, 0>, y: &Vector1<f64>) -> Vector4<f64> {
        let row = Vector2::new(t.cos(), t.sin());
        let miss = y[0] - self.estimate(t, state, u, y)[0];
        let rate = if self.estimates { row * miss } else { Vector2::zeros() };
        Vector4::new(state[1], -state[0], rate[0], rate[1])
    }

    fn estimate(&self, t: f64, state: &Vector4<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector2<f64> {
        let (sin, cos) = t.sin_cos();
        Vector2::new(state[0], state[1]) + Matrix2::new(cos, sin, -sin, cos) * Vector2::new(state[2], state[3])
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector4<f64> {
        Vector4::new(estimate[0], estimate[1], 0.0, 0.0)
    }
}

fn imaginary(_: &Context) -> Result<Outcome, CheckError> {
    let run = Scenario::new(Rotation)
        .initial_state(&[2.0, -1.0])
        .observer("as it is", Rotating { estimates: false }, &[0.0, 0.0])
        .observer("modified", Rotating { estimates: true }, &[0.0, 0.0])
        .tolerances(1e-11, 1e-12)
        .until(40.0, 401)
        .run()?;
    let size = |name, k: usize| run.observer(name).map(|found| found.error.row(k).norm());
    let (first, stays, left) = (size("as it is", 0)?, size("as it is", 400)?, size("modified", 400)?);
    // θ~' = -r r'θ~ with the mean of rr' over a turn I/2: e^-20 of the start, and the constant of averaging.
    let holds = left <= 1e-7 * first && (stays / first - 1.0).abs() < 1e-6;
    Ok(Outcome::new(Evidence::holds_by(holds, [stays, left])).note(
        "As it is, ξ - φ turns for ever, and keeps its length. With θ of e^(At)θ as the parameter the observer is a PEBO with a regressor that turns.",
    ))
}

plant!(Driven, (2, 0, 1), |plant, t, x, u| [x[1], -x[1]], [x[0]]);

/// The plant `x1' = x2`, `x2' = -x2`, y = x1.
#[derive(Clone, Copy)]
struct Driven;

fn off_the_manifold(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = draws();
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let immersed = cuk::kkl_pebo_immersed(plant, &tuning, Embedding::Printed)?;
    let (mut apart, mut leaves, mut size) = (0.0_f64, 0.0_f64, 1.0_f64);
    let (mut other, mut cases) = (0.0_f64, 0);
    for _ in 0..100 {
        let mut unit = || random.unit();
        let x = Vector4::new(0.2 * unit(), 17.0 + 2.0 * unit(), 0.2 * unit(), -10.0 + 2.0 * unit());
        let u = Vector1::new(0.5 + 0.3 * unit());
        let f = plant.derivative(0.0, &x, &u);
        let y = Vector2::new(x[1], x[2]);
        // β = (χ1 + χ6, χ2).
        let (first, second, shift) = (0.3 * unit(), -9.0 + unit(), unit());
        let chi = |share: f64, rest: f64| {
            SVector::<f64, 6>::from([first - share, second, 17.0 * rest, rest, 100.0 * rest, share])
        };
        let rate = |chi: SVector<f64, 6>| {
            let slope = immersed.derivative(0.0, &chi, &u, &y);
            Vector2::new(slope[0] + slope[5] - f[0], slope[1] - f[3])
        };
        let (one, two) = (rate(chi(0.0, 1.0)), rate(chi(shift, 0.5)));
        apart = apart.max((one - two).amax());
        let on = SVector::<f64, 6>::from([x[0] - shift, x[3], 17.0, 0.0, 100.0, shift]);
        leaves = leaves.max(rate(on).amax());
        size = size.max(f.amax());
        // β = χ1 + χ2 y: d_M' = χ2 (x2 - x̂2) - (x̂2 - x2), by (16).
        let (state, d) = (Vector2::new(unit(), unit()), unit());
        let slope = |x: &Vector2<f64>| Driven.derivative(0.0, x, &SVector::zeros());
        let upsilon = |chi2: f64| {
            let estimate = Vector2::new(state[0], state[1] + d);
            let (at, there) = (slope(&state), slope(&estimate));
            chi2 * (at[0] - there[0]) - at[1] + there[1]
        };
        other = other.max((upsilon(0.0) - upsilon(1.0)).abs());
        cases += 1;
    }
    let rounding = 256.0 * f64::EPSILON * size;
    Ok(Outcome::new(Evidence::Readings(vec![
        ("∇_y β does not depend on χ, as in the observers of the paper", Value::Truth(apart <= rounding && leaves <= rounding)),
        ("any β of Proposition 4, such as χ1 + χ2 y", Value::Truth(leaves <= rounding && other <= rounding)),
    ]))
    .instances(cases)
    .note(format!(
        "On the manifold β - φ stands still, to {} of rates up to {}, and for pairs of χ with one β it moves alike, to {}. With β = χ1 + χ2 y (16) is -(1 + χ2) d_M, which differs by up to {} between \
         two χ of one d_M.",
        short(leaves),
        short(size),
        short(apart),
        short(other)
    )))
}

fn square(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = draws();
    let mut defect = 0.0_f64;
    for _ in 0..200 {
        let m = Matrix3::from_fn(|i, j| random.unit() + if i == j { 2.0 } else { 0.0 });
        let inverse = m.try_inverse().ok_or("a random matrix is singular")?;
        let found = pseudo_inverse(&m).inverse;
        // Relative to the condition number.
        let condition = m.norm() * inverse.norm();
        defect = defect.max((found - inverse).norm() / (inverse.norm() * condition));
        defect = defect.max((Matrix3::identity() - found * m).norm() / condition);
    }
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let extensions = [cuk::pebo(plant, &tuning)?.dimensions().state, cuk::kkl_pebo(plant, &tuning)?.dimensions().state];
    let smaller = extensions.iter().all(|&extension| 2 < extension);
    Ok(Outcome::new(Evidence::holds_by(smaller && defect <= 64.0 * f64::EPSILON, defect)).instances(200))
}

/// `beta = chi = xi` and `phi` of Proposition 1, with `phi^L` from xi alone.
#[derive(Clone, Copy)]
struct KkloImmersion;

impl luenberger_plants::ByDual for KkloImmersion {}

/// `m(y)` over any scalar.
fn cubic_over<T: RealField + Copy>(y: T) -> T {
    (y - y * y * y * convert(1.0 / 3.0)) * convert(MU)
}

impl<T: RealField + Copy> Immersion<T> for KkloImmersion {
    type States = U2;
    type Inputs = U0;
    type Outputs = U1;
    type Manifold = U2;
    type Extension = U2;
    type Estimate = U2;

    fn beta(&self, _y: &Vector1<T>, chi: &Vector2<T>) -> Vector2<T> {
        *chi
    }

    fn phi(&self, x: &Vector2<T>) -> Vector2<T> {
        Vector2::from(LAMBDA.map(|lambda| x[0] * convert(lambda) + x[1] - cubic_over(x[0])))
    }

    fn left_inverse(&self, z: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        let x1 = (z[0] - z[1]) * convert(1.0 / (LAMBDA[0] - LAMBDA[1]));
        Vector2::new(x1, z[0] - x1 * convert(LAMBDA[0]) + cubic_over(x1))
    }

    fn estimate(&self, xhat: &Vector2<T>) -> Vector2<T> {
        *xhat
    }

    fn start(&self, estimate: &Vector2<T>, _y: &Vector1<T>) -> Vector2<T> {
        self.phi(estimate)
    }
}

fn kklo_as_immersion(_: &Context) -> Result<Outcome, CheckError> {
    let plant = VanDerPol { mu: MU };
    let start = [0.5, 0.5];
    let run = Scenario::new(plant)
        .initial_state(&[2.0, 0.0])
        .observer("kklo", KklObserver::new(Turned::straight()), &start)
        .observer("iandi", ImmersionInvarianceObserver::new(plant, KkloImmersion), &start)
        .tolerances(1e-11, 1e-12)
        .until(END, SAMPLES)
        .run()?;
    let left = |name| run.observer(name).map(|found| found.error.row(SAMPLES - 1).norm());
    let (kklo, iandi) = (left("kklo")?, left("iandi")?);
    let (mut alone, mut keeping) = (0.0_f64, 0.0_f64);
    for [y, first, second, _] in super::propositions::grid().step_by(16) {
        // (18) with β = χ: χ' = ∇φ'(x̂) f(x̂); its pseudo-inverse is I, and Q falls out.
        let chi = Vector2::new(first, second);
        let slope = |xhat: &Vector2<f64>| phi_along(xhat, &plant.derivative(0.0, xhat, &SVector::zeros()));
        let kklo = Vector2::from_fn(|i, _| LAMBDA[i] * chi[i]) + injection(y);
        alone = alone.max((slope(&inverse(&chi)) - kklo).amax());
        // With n_ξ = n - p = 1 the output is taken as it is: x̂ = (y, χ1 - λ1 y + m(y)).
        let xhat = Vector2::new(y, first - LAMBDA[0] * y + super::propositions::cubic(y));
        keeping = keeping.max((slope(&xhat)[0] - kklo[0]).abs());
    }
    let mut hypotheses = assumption_1(&Matrix2::identity());
    hypotheses.push(Hypothesis::computed(
        "the KKLO converges",
        kklo <= 1e-7,
        format!("|x̂ - x| is {} at T = 20", short(kklo)),
    ));
    Ok(Outcome::new(Evidence::Counterexamples(vec![Counterexample {
        case: String::new(),
        what: "|x̂ - x| of the I&IO at T = 20, less that of the KKLO from the same start".to_owned(),
        // A thousand times the tolerance of the run.
        violation: iandi - kklo - 1e-8,
        witness: Some(Value::from([kklo, iandi])),
        hypotheses,
    }]))
    .note(format!(
        "(18) with β = χ is χ' = ∇φ'(x̂) f(x̂): a copy of the plant, which never sees y, and keeps its phase. The right-hand sides differ by up to {} on |y|, |χ_i| ≤ 2. Where φᴸ keeps the output, \
         h(x̂) = y (here with n_ξ = 1), they are equal to {}; on the converter it does (kkl.cuk.kklo-is-iandi).",
        short(alone),
        short(keeping)
    )))
}

/// `beta = xi + theta_hat` and `phi = x2 - m(x1)`; chi is (xi, w, F[g], F[m], theta_hat).
#[derive(Clone, Copy)]
struct PeboImmersion;

impl luenberger_plants::ByDual for PeboImmersion {}

impl<T: RealField + Copy> Immersion<T> for PeboImmersion {
    type States = U2;
    type Inputs = U0;
    type Outputs = U1;
    type Manifold = U1;
    type Extension = U5;
    type Estimate = U1;

    fn beta(&self, _y: &Vector1<T>, chi: &SVector<T, 5>) -> Vector1<T> {
        Vector1::new(chi[0] + chi[4])
    }

    fn phi(&self, x: &Vector2<T>) -> Vector1<T> {
        Vector1::new(x[1] - cubic_over(x[0]))
    }

    fn left_inverse(&self, z: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
        Vector2::new(y[0], z[0] + cubic_over(y[0]))
    }

    fn estimate(&self, xhat: &Vector2<T>) -> Vector1<T> {
        Vector1::new(xhat[1])
    }

    fn start(&self, estimate: &Vector1<T>, y: &Vector1<T>) -> SVector<T, 5> {
        let zero = T::zero();
        SVector::from([estimate[0] - cubic_over(y[0]), y[0], zero, zero, zero])
    }
}

fn pebo_as_immersion(_: &Context) -> Result<Outcome, CheckError> {
    let plant = VanDerPol { mu: MU };
    let run = Scenario::new(plant)
        .initial_state(&[2.0, 0.0])
        .partial_observer("pebo", safety_nets::observer(Integration::open())?, &[1.0], &[1])
        .partial_observer("iandi", ImmersionInvarianceObserver::new(plant, PeboImmersion), &[1.0], &[1])
        .tolerances(1e-11, 1e-12)
        .until(END, SAMPLES)
        .run()?;
    let at = |name, k: usize| -> Result<f64, SimError> { Ok(run.observer(name)?.error[(k, 0)].abs()) };
    let last = SAMPLES - 1;
    let (start, pebo, iandi) = (at("pebo", 0)?, at("pebo", last)?, at("iandi", last)?);
    let (mut residual, mut output) = (0.0_f64, 0.0_f64);
    for [a, b, _, _] in super::propositions::grid().step_by(81) {
        let x = Vector2::new(a, b);
        let f = plant.derivative(0.0, &x, &SVector::zeros());
        // phi' = x2' - m'(x1) x1', and B = -y.
        residual = residual.max((f[1] - MU * (1.0 - a * a) * f[0] + a).abs());
        output = output.max((plant.output(0.0, &x, &SVector::zeros())[0] - a).abs());
    }
    Ok(Outcome::new(Evidence::Counterexamples(vec![Counterexample {
        case: String::new(),
        what: "the error of x2 of the I&IO at T = 20, less that of the PEBO".to_owned(),
        violation: iandi - pebo - 1e-8,
        witness: Some(Value::from([pebo, iandi])),
        hypotheses: vec![
            Hypothesis::computed("A1 with Λ = 0", residual <= 64.0 * f64::EPSILON * 8.0, format!("residual {}", short(residual))),
            Hypothesis::computed("the outputs are partial states", output == 0.0, "y = x1 on the grid"),
            Hypothesis::computed(
                "A2, the estimator is consistent",
                pebo <= 1e-6 * start,
                format!("the error of the PEBO goes from {} to {}", short(start), short(pebo)),
            ),
        ],
    }]))
    .note(format!(
        "As in Proposition 5: (18) makes β follow φ(x̂), so that the error stays what it was ({}), where θ̂ of the PEBO moves besides.",
        short(start)
    )))
}

plant!(Squared, (1, 0, 1), |plant, t, x, u| [-x[0]], [x[0] * x[0]]);

/// The plant `x' = -x`, `y = x^2`.
#[derive(Clone, Copy)]
struct Squared;

#[expect(clippy::unnecessary_wraps, reason = "the signature of every check")]
fn coordinates(_: &Context) -> Result<Outcome, CheckError> {
    let output = |x: f64| Squared.output(0.0, &Vector1::new(x), &SVector::zeros())[0];
    let (one, other) = (1.0, -1.0);
    let step = 1e-6;
    let slope = (output(step) - output(-step)) / (2.0 * step);
    let decays =
        [one, other].iter().all(|&x| x * Squared.derivative(0.0, &Vector1::new(x), &SVector::zeros())[0] < 0.0);
    // The PDE (4) for φ = x, Λ = -1, B = 0.
    let admits =
        [one, other].iter().all(|&x| Squared.derivative(0.0, &Vector1::new(x), &SVector::zeros())[0] + x == 0.0);
    Ok(Outcome::new(Evidence::Counterexamples(vec![Counterexample {
        case: String::new(),
        what: "two states, as far apart, with one output: with n = p = 1 the output would be the whole new state, which a change of coordinates makes injective".to_owned(),
        violation: if output(one) == output(other) { one - other } else { -1.0 },
        witness: Some(Value::from([one, other])),
        hypotheses: vec![
            Hypothesis::computed("trajectories are bounded", decays, "x x' < 0 at both"),
            Hypothesis::computed("h is smooth", true, "a polynomial"),
            Hypothesis::computed(
                "Proposition 5: the plant admits a [KKL+PEB]O, with its rank",
                admits,
                "φ = x, Λ = -1, B = 0, q = n_ξ = 1, N = 0: ξ' = -ξ, x̂ = ξ",
            ),
        ],
    }]))
    .note(format!(
        "Nor is it possible locally, at 0: there h' = {}, and a coordinate has a gradient. With outputs of full rank it is.",
        short(slope)
    )))
}

fn shape_of_q(_: &Context) -> Result<Outcome, CheckError> {
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let immersed = cuk::kkl_pebo_immersed(plant, &tuning, Embedding::Free)?;
    let chi = SVector::<f64, 6>::from([0.1, -9.0, 17.0, 0.0, 100.0, 0.1]);
    let rate = immersed.derivative(0.0, &chi, &Vector1::new(0.5), &Vector2::new(17.0, -0.2));
    Ok(Outcome::new(Evidence::value([rate.nrows() as f64, rate.ncols() as f64]))
        .note("A column; with one the I&IO is defined, and with a matrix the sum in (18) is not."))
}
