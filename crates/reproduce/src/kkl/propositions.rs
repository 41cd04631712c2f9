//! Propositions 1 to 4 and the remarks R5, R6, R9: hypotheses checked, and conclusions checked along a run.
//!
//! Proposition 1 on van der Pol's oscillator, which has a KKLO with a constant Lambda in closed form: with
//! `m(y) = mu (y - y^3/3)`, `phi_i(x) = lambda_i x1 + x2 - m(x1)` obeys `phi_i' = lambda_i phi_i + lambda_i m(y) - y -
//! lambda_i^2 y`. Propositions 2 to 4 on the converter of section V.C.

use std::sync::Arc;

use crate::kkl::cuk::{self, Tuning};
use crate::kkl::exponential_cascade::ExponentialCascadeMap;
use luenberger_observers::kkl::{KklMap, KklObserver};
use luenberger_plants::{CukConverter, ExponentialCascade, Plant, VanDerPol};
use luenberger_sim::{Scenario, Trajectory};
use nalgebra::{Matrix2, SVector, U0, U1, U2, Vector1, Vector2, Vector3, Vector4};

use super::converter;
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Evidence, Hypothesis};
use crate::value::{Value, short};

const OSCILLATOR: &str =
    "van der Pol's oscillator, μ = 1, y = x1, from (2, 0); φ_i = λ_i x1 + x2 - μ(x1 - x1³/3), Λ = diag(-1, -2)";
const CONVERTER: &str =
    "the Cuk converter of section V.C with the observer of Table I, corrected; 1.2 s, six set-points";
const LAMBDA: [f64; 2] = [-1.0, -2.0];
const MU: f64 = 1.0;
const END: f64 = 20.0;
/// Sums of up to six terms of size up to 40.
const ROUNDING: f64 = 16.0 * f64::EPSILON * 40.0;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Theorem,
            "kkl.prop1",
            "Proposition 1, (4) to (6)",
            "under A1 the KKLO converges, with ξ - φ(x) = e^(Λt)(ξ(0) - φ(x(0))) (largest difference of the two, and |x̂ - x| at T = 20)",
            &[OSCILLATOR, "the observer from x̂ = (0, 0)"],
            proposition_1,
        )
        .quoting(
            "The KKLO ξ' = Λξ + B(y, u), x̂ = φᴸ(ξ, y) ensures (3). Proof. [..] defining the error signal e := ξ - φ(x) and noting that ė = Λe.",
            "Λ constant and diagonal with negative entries, φᴸ continuous",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.prop2",
            "Proposition 2, (8) to (13)",
            "under A1 with Λ = 0 and A2 the PEBO converges (when both errors are below 1e-6 for good, s)",
            &[CONVERTER],
            |context| estimated(context, "pebo"),
        )
        .quoting(
            "defines a stable, consistent parameter estimator for the regression model (11), that is ζ is bounded and lim |θ̂(t) - θ| = 0. The PEBO (8), (10), (12) verifies (3).",
            "A2 is evaluated along the run: θ = φ(x) - ξ stands still, ζ is bounded, θ̂ goes to θ",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.prop3",
            "Proposition 3, (14), (15)",
            "with Λ = diag(Λ_L, 0) and a consistent estimator of the rest the [KKL+PEB]O converges (when both errors are below 1e-6 for good, s)",
            &[CONVERTER],
            |context| estimated(context, "kkl_peb"),
        )
        .quoting(
            "The [KKL+PEB]O (15) ensures (3) provided the mappings M_P, N_P define a consistent estimator, that is, (13) holds.",
            "as for Proposition 2, for the part without Λ; ξ_L - φ_L(x) decays as e^(Λ_L t)",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.prop4",
            "Proposition 4, (16) to (19)",
            "under A4 and A5 the I&IO converges (when both errors are below 1e-6 for good, s)",
            &[CONVERTER],
            proposition_4,
        )
        .quoting(
            "A4 rank ∇_χ β' = n_z. A5 The system (16) has an asymptotically stable equilibrium d_M = 0. The I&IO (18), (19) verifies (3).",
            "d_M = β(y, χ) - φ(x) starts in the region of attraction, here all of R²",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r5",
            "R5",
            "with ∇φ'f = Aφ + B, A = P'ΛP and P unitary, the observer ξ' = Λξ + PB, x̂ = φᴸ(P'ξ, y) converges (|x̂ - x| at T = 20)",
            &[OSCILLATOR, "P the rotation by 0.7"],
            remark_5,
        )
        .quoting(
            "it is possible to replace the PDE (4) by ∇φ'f(x, u) = Aφ(x) + B(h(x), u), where A is such that there exists a unitary matrix P ensuring A = P'ΛP",
            "x̂ = φᴸ(P'(ξ + (0, θ̂)), y), without parameters here",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r6",
            "R6",
            "for f = F(x) + g(x)u the PDE (4) is the two ∇φ'F = Aφ + B_F(h), ∇φ'g = B_g(h), with B = B_F + B_g u (largest residual of the three)",
            &["the plant of Proposition 6 with φ = (x2, x3): B_F = (y² + sin y, 1/(y² + 1)), B_g = (0, y); 9 points per axis of |x_i| ≤ 2, |u| ≤ 2"],
            remark_6,
        )
        .quoting(
            "In the case of input-affine systems [..] it is possible to decompose the PDE (4) into two",
            "sufficient and, for a B that is affine in u, necessary: (4) at u = 0, and its difference to u = 1",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.r9",
            "R9",
            "the KKLO (6) coincides with the I&IO (18), (19) for β = ξ = χ, Υ = -Λφ + Λχ",
            &[OSCILLATOR, "the right-hand sides at 400 points of |x_i|, |χ_i| ≤ 2"],
            remark_9,
        )
        .quoting(
            "the KKLO (6) coincides with the I&IO (18)-(19) with mappings selecting n_χ = n_z = q, β(y, χ) = ξ = χ, Υ(x, χ, u) = -Λφ(x) + Λχ with any mapping Q(y, χ, u)",
            "χ' of (18) is ξ' of (6) for every y; (18) has B(h(x̂), u) where (6) has B(y, u)",
        ),
    ]
}

fn cubic(y: f64) -> f64 {
    MU * (y - y * y * y / 3.0)
}

/// phi of the oscillator.
fn phi(x: &Vector2<f64>) -> Vector2<f64> {
    Vector2::from(LAMBDA.map(|lambda| lambda * x[0] + x[1] - cubic(x[0])))
}

/// `Dphi(x) v`.
fn phi_along(x: &Vector2<f64>, v: &Vector2<f64>) -> Vector2<f64> {
    let slope = MU * (1.0 - x[0] * x[0]);
    Vector2::from(LAMBDA.map(|lambda| (lambda - slope) * v[0] + v[1]))
}

fn injection(y: f64) -> Vector2<f64> {
    Vector2::from(LAMBDA.map(|lambda| lambda * cubic(y) - y - lambda * lambda * y))
}

/// phi^L, from xi alone.
fn inverse(xi: &Vector2<f64>) -> Vector2<f64> {
    let x1 = (xi[0] - xi[1]) / (LAMBDA[0] - LAMBDA[1]);
    Vector2::new(x1, xi[0] - LAMBDA[0] * x1 + cubic(x1))
}

/// The KKLO of the oscillator, in the coordinates `P xi`: `xi' = Lambda xi + P B`, `xhat = phi^L(P'xi)` for the map
/// `P'phi`, R5; P = I is Proposition 1.
struct Turned {
    p: Matrix2<f64>,
}

impl KklMap<f64> for Turned {
    type Xi = U2;
    type Inputs = U0;
    type Outputs = U1;
    type Estimate = U2;

    fn lambda(&self, _t: f64, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Matrix2<f64> {
        Matrix2::from_diagonal(&Vector2::from(LAMBDA))
    }

    fn injection(&self, _t: f64, _xi: &Vector2<f64>, _u: &SVector<f64, 0>, y: &Vector1<f64>) -> Vector2<f64> {
        // P times the B of P'phi, which is P'B.
        self.p * (self.p.transpose() * injection(y[0]))
    }

    fn left_inverse(&self, _t: f64, xi: &Vector2<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        // The left inverse of P'phi is phi^L(P .).
        inverse(&(self.p * (self.p.transpose() * xi)))
    }

    fn image(&self, _t: f64, xhat: &Vector2<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        phi(xhat)
    }
}

/// Points of |x_i| <= 2, and of as many more numbers.
fn grid() -> impl Iterator<Item = [f64; 4]> {
    (0..9_usize.pow(4))
        .map(|index| std::array::from_fn(|axis| -2.0 + 0.5 * (index / 9_usize.pow(axis as u32) % 9) as f64))
}

fn oscillate(p: Matrix2<f64>) -> Result<Trajectory, CheckError> {
    Ok(Scenario::new(VanDerPol { mu: MU })
        .initial_state(&[2.0, 0.0])
        .observer("kklo", KklObserver::new(Turned { p }), &[0.0, 0.0])
        .tolerances(1e-12, 1e-13)
        .until(END, 401)
        .run()?)
}

/// A1 of Proposition 1 on the oscillator, for the map `P'phi` and `A = P'Lambda P`.
fn assumption_1(p: &Matrix2<f64>) -> Vec<Hypothesis> {
    let plant = VanDerPol { mu: MU };
    let lambda = Matrix2::from_diagonal(&Vector2::from(LAMBDA));
    let (mut residual, mut back) = (0.0_f64, 0.0_f64);
    for point in grid() {
        let x = Vector2::new(point[0], point[1]);
        let rate = p.transpose() * phi_along(&x, &plant.derivative(0.0, &x, &SVector::zeros()));
        let (a, image) = (p.transpose() * lambda * p, p.transpose() * phi(&x));
        residual = residual.max((rate - a * image - p.transpose() * injection(x[0])).amax());
        back = back.max((inverse(&(p * image)) - x).amax());
    }
    vec![
        Hypothesis::computed(
            "(i) the PDE (4)",
            residual <= ROUNDING,
            format!("residual {} on |x_i| ≤ 2", short(residual)),
        ),
        Hypothesis::computed("(ii) φᴸ(φ(x), h(x)) = x", back <= ROUNDING, format!("to {} there", short(back))),
        Hypothesis::computed(
            "λ_i < 0, n_ξ ≥ n - p",
            LAMBDA.iter().all(|lambda| *lambda < 0.0),
            "Λ = diag(-1, -2), 2 ≥ 1",
        ),
    ]
}

fn proposition_1(_: &Context) -> Result<Outcome, CheckError> {
    let run = oscillate(Matrix2::identity())?;
    let found = run.observer("kklo")?;
    let mut apart = 0.0_f64;
    let error = |k: usize| -> Vector2<f64> {
        let x = Vector2::new(run.x[(k, 0)], run.x[(k, 1)]);
        Vector2::new(found.state[(k, 0)], found.state[(k, 1)]) - phi(&x)
    };
    let first = error(0);
    for (k, t) in run.t.iter().enumerate() {
        let expected = Vector2::from_fn(|i, _| first[i] * (LAMBDA[i] * t).exp());
        apart = apart.max((error(k) - expected).amax());
    }
    let left = found.error.row(found.error.nrows() - 1).norm();
    // A thousand times the tolerance of the run; e^-20 of a start of 2, through a left inverse of slope below 10.
    Ok(Outcome::new(Evidence::holds_by(apart <= 1e-9 && left <= 1e-7, [apart, left]))
        .given(assumption_1(&Matrix2::identity())))
}

fn remark_5(_: &Context) -> Result<Outcome, CheckError> {
    let (sin, cos) = 0.7_f64.sin_cos();
    let p = Matrix2::new(cos, -sin, sin, cos);
    let run = oscillate(p)?;
    let error = &run.observer("kklo")?.error;
    let left = error.row(error.nrows() - 1).norm();
    Ok(Outcome::new(Evidence::holds_by(left <= 1e-7, left))
        .note("In the coordinates Pξ nothing changes: e = ξ - Pφ obeys e' = Λe.")
        .given(assumption_1(&p)))
}

/// The largest residual of `d phi/dt = Lambda phi + B` for a map of the converter whose image is linear in the state.
fn residual<K>(map: &K) -> (f64, f64)
where
    K: KklMap<f64, Xi = U2, Inputs = U1, Outputs = U2, Estimate = U2>,
{
    let plant = CukConverter::default();
    let (mut largest, mut back) = (0.0_f64, 0.0_f64);
    for [a, b, c, d] in grid() {
        let u = Vector1::new(0.5 + 0.2 * (a + b - c) / 3.0);
        // Currents and voltages of the size that they have.
        let x = Vector4::new(0.2 * a, 17.0 + 2.0 * b, 0.2 * c, -10.0 + 2.0 * d);
        let f = plant.derivative(0.0, &x, &u);
        let parts = |v: &Vector4<f64>| (Vector2::new(v[0], v[3]), Vector2::new(v[1], v[2]));
        let ((hidden, y), (hidden_rate, y_rate)) = (parts(&x), parts(&f));
        let xi = map.image(0.0, &hidden, &y);
        let rate = map.image(0.0, &hidden_rate, &y_rate);
        let claimed = map.slope(0.0, &xi, &u, &y);
        // Relative to the fastest rate, of which the others are sums.
        largest = largest.max((rate - claimed).amax() / f.amax());
        back = back.max((map.left_inverse(0.0, &xi, &y) - hidden).amax());
    }
    (largest, back)
}

/// Along the run: by how much `phi(x) - xi` of this entry moves, relative to what xi moves.
fn drift(run: &Trajectory, name: &str, entry: usize, image: impl Fn(&Vector4<f64>) -> f64) -> Result<f64, CheckError> {
    let state = &run.observer(name)?.state;
    let at = |k: usize| image(&Vector4::from_fn(|i, _| run.x[(k, i)])) - state[(k, entry)];
    let size = state.column(entry).amax();
    Ok((0..run.t.len()).map(|k| (at(k) - at(0)).abs()).fold(0.0, f64::max) / size)
}

/// Propositions 2 and 3.
fn estimated(context: &Context, name: &str) -> Result<Outcome, CheckError> {
    let run: Arc<Trajectory> = converter::corrected(context)?;
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let ratio = plant.g * plant.l3 / plant.c4;
    let ((pde, back), moved) = if name == "pebo" {
        let first = drift(&run, name, 0, |x| x[0])?;
        let second = drift(&run, name, 1, |x| x[3] - ratio * x[2])?;
        (residual(cuk::pebo(plant, &tuning)?.map()), first.max(second))
    } else {
        (residual(cuk::kkl_pebo(plant, &tuning)?.map()), drift(&run, name, 0, |x| x[0])?)
    };
    let largest = run.observer(name)?.state.amax();
    let gone = converter::gone(&run, name)?;
    // The rounding of ten operations on terms of size 1e5, relative; and the tolerance of the run at each of some 1e5
    // steps.
    let hypotheses = vec![
        Hypothesis::computed(
            "(i) the PDE (4)",
            pde <= 64.0 * f64::EPSILON,
            format!("relative residual {}", short(pde)),
        ),
        Hypothesis::computed(
            "(ii) φᴸ(φ(x), h(x)) = x",
            back <= 64.0 * f64::EPSILON * 20.0,
            format!("to {}", short(back)),
        ),
        Hypothesis::computed(
            "θ = φ(x) - ξ is constant",
            moved <= 1e-6,
            format!("along the run it moves by {} of ξ", short(moved)),
        ),
        Hypothesis::computed(
            "the estimator is bounded",
            largest.is_finite(),
            format!("no entry of its state exceeds {}", short(largest)),
        ),
    ];
    Ok(Outcome::new(Evidence::holds_by(gone.is_finite(), gone))
        .note("x̂ - x is θ̂ - θ in the entries that are estimated as parameters: that the estimator is consistent is what the run shows.")
        .given(hypotheses))
}

/// `d_M' = -diag(g1 w, G/C4 + g2) d_M` on the converter: the slope of the estimate less that of the state.
fn proposition_4(context: &Context) -> Result<Outcome, CheckError> {
    use luenberger_observers::Observer;
    let run = converter::corrected(context)?;
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let observer = cuk::immersion_invariance(plant, &tuning)?;
    let mut largest = 0.0_f64;
    for [a, b, c, d] in grid() {
        let (u, x) =
            (Vector1::new(0.5 + 0.2 * (a + c) / 4.0), Vector4::new(0.2 * a, 17.0 + 2.0 * b, 0.2 * c, -10.0 + 2.0 * d));
        let (y, chi) = (Vector2::new(x[1], x[2]), Vector2::new(0.3 * b, -9.0 + d));
        let (f, slope) = (plant.derivative(0.0, &x, &u), observer.derivative(0.0, &chi, &u, &y));
        let off = observer.estimate(0.0, &chi, &u, &y) - Vector2::new(x[0], x[3]);
        // beta = chi + (C2 g1 y1, -L3 g2 y2).
        let beta = slope + Vector2::new(plant.c2 * tuning.g1 * f[1], -plant.l3 * tuning.g2 * f[2]);
        let rate = beta - Vector2::new(f[0], f[3]);
        let claimed = -Vector2::new(tuning.g1 * (1.0 - u[0]) * off[0], (plant.g / plant.c4 + tuning.g2) * off[1]);
        let size = f.amax() + rate.abs().amax() + claimed.abs().amax() + 1.0;
        largest = largest.max((rate - claimed).amax() / size);
    }
    let gone = converter::gone(&run, "iandi")?;
    Ok(Outcome::new(Evidence::holds_by(gone.is_finite(), gone)).given(vec![
        Hypothesis::computed("A4 rank ∇_χ β' = n_z", true, "β = χ + (C2 γ1 y1, -L3 γ2 y2), whose derivative by χ is I"),
        Hypothesis::computed("φᴸ(φ(x), y) = x", true, "φ = (i1, v4), y = (v2, i3)"),
        Hypothesis::computed(
            "A5 (16) is asymptotically stable",
            largest <= 256.0 * f64::EPSILON,
            format!(
                "(16) is d_M' = -diag(γ1 w, G/C4 + γ2) d_M, to {} of the size of its terms, with 0 < w < 1",
                short(largest)
            ),
        ),
    ]))
}

#[expect(clippy::unnecessary_wraps, reason = "the signature of every check")]
fn remark_6(_: &Context) -> Result<Outcome, CheckError> {
    let mut largest = 0.0_f64;
    for [a, b, c, d] in grid() {
        let (x, u) = (Vector3::new(a, b, c), Vector1::new(d));
        let rate = |u: f64| {
            let f = ExponentialCascade.derivative(0.0, &x, &Vector1::new(u));
            Vector2::new(f[1], f[2])
        };
        let y = x[0];
        let (known, gain) = (Vector2::new(y * y + y.sin(), 1.0 / (y * y + 1.0)), Vector2::new(0.0, y));
        let linear = Vector2::new(-x[1], 0.0);
        let first = rate(0.0) - linear - known;
        let second = rate(1.0) - rate(0.0) - gain;
        let claimed = ExponentialCascadeMap.slope(0.0, &Vector2::new(x[1], x[2]), &u, &Vector1::new(y));
        let whole = linear + known + gain * d - claimed;
        largest = largest.max(first.amax()).max(second.amax()).max(whole.amax());
    }
    // A few operations on terms of at most 6.
    Ok(Evidence::holds_by(largest <= 8.0 * f64::EPSILON * 8.0, largest).into())
}

#[expect(clippy::unnecessary_wraps, reason = "the signature of every check")]
fn remark_9(_: &Context) -> Result<Outcome, CheckError> {
    let plant = VanDerPol { mu: MU };
    let none = SVector::zeros();
    let (mut alone, mut keeping) = (0.0_f64, 0.0_f64);
    for [y, first, second, _] in grid().step_by(16) {
        // (18) with β = χ: χ' = ∇φ'(x̂) f(x̂); its pseudo-inverse is I, and Q falls out.
        let chi = Vector2::new(first, second);
        let slope = |xhat: &Vector2<f64>| phi_along(xhat, &plant.derivative(0.0, xhat, &none));
        let kklo = Vector2::from_fn(|i, _| LAMBDA[i] * chi[i]) + injection(y);
        alone = alone.max((slope(&inverse(&chi)) - kklo).amax());
        // With n_ξ = n - p = 1 the output is taken as it is: x̂ = (y, χ1 - λ1 y + m(y)).
        let xhat = Vector2::new(y, first - LAMBDA[0] * y + cubic(y));
        keeping = keeping.max((slope(&xhat)[0] - kklo[0]).abs());
    }
    Ok(Outcome::new(Evidence::Readings(vec![
        ("φᴸ(ξ, y) keeps the output: h(x̂) = y, here with n_ξ = 1", Value::Truth(keeping <= ROUNDING)),
        ("φᴸ(ξ), from ξ alone, here with n_ξ = 2", Value::Truth(alone <= ROUNDING)),
    ]))
    .note(format!(
        "The right-hand sides differ by {} and {}. For the PEBO the paper adds \"if the measurable output signals are partial states\", and F1 uses it for h(x̂) = y; the KKLO needs as much. On the \
         converter it has it (kkl.cuk.kklo-is-iandi).",
        short(keeping),
        short(alone)
    )))
}
