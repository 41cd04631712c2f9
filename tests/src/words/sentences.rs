//! The sentences that designs, failures and exports print, as forms, and what each of them claims.
//!
//! This table is the one place to change where a text changes. `{#}` is a number, `{}` any text without the end of a
//! sentence. A sentence without a form is a finding: it would be printed without a check.

use luenberger_proof::certificate::NO_USEFUL_BOUND;

/// What a sentence claims. The check of each is in `adversary`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Claim {
    /// Nothing that could be false of this plant: a description.
    Nothing,
    /// A - LC is Hurwitz, and decays at a rate.
    Decay,
    /// A - LC is Schur.
    DiscreteDecay,
    /// The output depends on the input.
    Feedthrough,
    /// A bound of the error in the end under bounded noise.
    Ultimate,
    /// The cubic term does not slow V.
    CubicDecrease,
    /// Convergence of a cubic observer from every error.
    CubicEverywhere,
    /// Or from errors in a ball.
    CubicWithin,
    /// The sampled cubic observer.
    SampledCubic,
    /// At varying periods.
    Varying,
    /// `|e(t)| <= M exp(-r t) |e(0)|`, or `and tends to 0`, under a hypothesis.
    Envelope,
    /// The same in discrete time.
    DiscreteEnvelope,
    /// `M |e(0)|` in discrete time, and convergence.
    DiscreteConverges,
    /// Convergence by sectors.
    Sectors,
    /// The envelope of z = xhat + e.
    MeanValue,
    /// The error of a disturbance and of the state.
    Disturbance,
    /// Every disturbance is decoupled.
    UnknownInput,
    /// The same at samples.
    UnknownInputOfSamples,
    /// Bounds that enclose the state.
    Encloses,
    /// The same at samples.
    EnclosesSampled,
    /// The half-widths in the end.
    Widths,
    /// The error is 0 after a finite time.
    FiniteTime,
    /// What the sampled sliding-mode observer is exact to.
    ExactAtSamples,
    /// A reduced-order observer converges.
    Reduced,
    /// A bound of the H-infinity norm.
    HInfinity,
    /// A bound of the H2 norm.
    H2,
    /// The error tends to 0 without w.
    WithoutW,
    /// A KKL observer converges in a region.
    KklConverges,
    /// Its bound.
    KklGuaranteed,
    /// What its error is at most in the limit.
    KklLimit,
    /// An immersion-and-invariance observer converges in a region.
    ImmersionConverges,
    /// Plant and observer converge in the loop.
    Loop,
    /// z' = D z + B y is stable, and the error that of the left inverse.
    Tables,
    /// The plant is not observable.
    NotObservable,
    /// The plant is observable after all.
    Observable,
    /// The unobservable modes are stable.
    Detectable,
    /// No observer exists.
    NotDetectable,
    /// No gain makes a norm less.
    NoGainOfNorm,
    /// No gain makes the width stable.
    NoGainOfWidth,
    /// A given gain is not stable.
    NotHurwitz,
    /// The same in discrete time.
    NotSchur,
    /// An inequality has no solution.
    Infeasible,
    /// rank(C E) is too small.
    Unmatched,
    /// An invariant zero forbids the observer.
    UnstableZero,
    /// A header that promises exponential convergence of stored gains.
    HeaderStored,
    /// The stored matrices are those of the sampled plant.
    HeaderSame,
    /// A header with the statement of a design under the word "proved".
    HeaderProved,
    /// A bound of rounding and noise.
    HeaderBound,
    /// The loop of a header.
    HeaderLoop,
}

/// A form with its claim.
pub struct Form {
    pub text: &'static str,
    pub claim: Claim,
}

const fn form(text: &'static str, claim: Claim) -> Form {
    Form { text, claim }
}

/// The forms of statements.
pub const STATEMENTS: &[Form] = &[
    form(
        "For the linear system {} with the matrices of the linearisation, x, u and y being the deviations from the operating point:",
        Claim::Nothing,
    ),
    form("Linearised at the operating point {}.", Claim::Nothing),
    form(
        "The plant is affine: up to the rounding of A, B, C and of the operating point this system is the plant.",
        Claim::Nothing,
    ),
    form("The certificate is of the linearisation: nothing is proved of the nonlinear plant.", Claim::Nothing),
    form("Computed: asymptotic rate exp(-{#} t).", Claim::Nothing),
    form("Computed: asymptotic factor {#} at each sample.", Claim::Nothing),
    form("Computed: asymptotic factor of V {#} per sample.", Claim::Nothing),
    form("Convergence is not proved.", Claim::Nothing),
    form(
        "In the loop u = r - K xhat with r = 0: x and xhat tend to 0 exponentially, from every x(0) and xhat(0).",
        Claim::Loop,
    ),
    form(
        "In the loop u = r - K xhat with r = 0: x and xhat tend to 0 exponentially, if they start near 0.",
        Claim::Nothing,
    ),
    form(
        "In the loop u = r - K xhat with the gains as stored and r = 0: x and xhat tend to 0 exponentially, from every x(0) and {}.",
        Claim::Loop,
    ),
    form("The stability of the loop u = r - K xhat is not proved: the {} is {#}.", Claim::Nothing),
    form("The poles of A - B K are {}, besides those of the observer.", Claim::Nothing),
    form("That is of u in continuous time, not held as in the simulation.", Claim::Nothing),
    form(
        "With the gains as stored it converges from every initial error {} with e'Pe < {#}, such as all of norm below {#}.",
        Claim::CubicWithin,
    ),
    form(
        "For {}, with the gains as stored, the errors of x and of d tend to 0, from every initial error{}.",
        Claim::Disturbance,
    ),
    form(
        "With the real matrix -P^-1 C'S in place of N, V = e'Pe decreases at least as fast as without the cubic term{}, for every error.",
        Claim::CubicDecrease,
    ),
    form("So {}; convergence with the gains as stored is not certified.", Claim::Nothing),
    form("For {} the errors of x and of d {}, for all x(0), xhat(0) and d.", Claim::Disturbance),
    form(
        "Sampled every {#}: V = e'Pe decreases from sample to sample and the error tends to 0, for every initial error.",
        Claim::SampledCubic,
    ),
    form(
        "For periods from {#} to {#}, with the correction gain K and a prediction over the time that passes: before each correction V = e'Pe is at most {#} times what it was before the last one and the error tends to 0, for every initial error.",
        Claim::Varying,
    ),
    form(
        "For periods from {#} to {#} with at most {}, with the correction gain K and a prediction over the time that passes: before each correction V = e'Pe is at most {#} times what it was before the last one and the error tends to 0, for every initial error.",
        Claim::Varying,
    ),
    form("{}, |x(t) - z(t)| <= {#} |x(0) - z(0)| {}.", Claim::MeanValue),
    form("z is xhat + e, with the internal error e.", Claim::Nothing),
    form("{}, the error {}.", Claim::Sectors),
    form(
        "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at every sample, the rounding of every operation included ({}).",
        Claim::EnclosesSampled,
    ),
    form("Nothing is said of a sampled observer.", Claim::Nothing),
    form("Of the sampled observer the theory says, beside the certificate: {}.", Claim::ExactAtSamples),
    form(
        "No stability certificate: the quadratic Lyapunov function was not found for these gains and this bound, which does not mean that the observer fails.",
        Claim::Nothing,
    ),
    form(
        "A reset moves theta_hat into xi and the filters with it: the estimates are those without resets.",
        Claim::Nothing,
    ),
    form(
        "A reset moves theta_hat into xi: the estimate is continuous, and the filters begin again, so that the excitation since the last reset is lost.",
        Claim::Nothing,
    ),
    form("Nothing is proved of the nonlinear plant.", Claim::Nothing),
    form("e' = (A - L C) e: for all x(0) and xhat(0) the error {}.", Claim::Decay),
    form("e+ = (A - L C) e: for all x(0) and xhat(0) the error tends to 0.", Claim::DiscreteDecay),
    form(
        "e+ = (A - L C) e: for all x(0) and xhat(0) the error tends to 0, at least as fast as {#}^k.",
        Claim::DiscreteDecay,
    ),
    form(
        "For every disturbance d(t) the error of x {}, for all x(0) and xhat(0), with H and T = I - HC as real matrices.",
        Claim::UnknownInput,
    ),
    form(
        "For every disturbance d(t) the error of x {}, for all x(0) and xhat(0), with H, J and T = I - HC as real matrices.",
        Claim::UnknownInput,
    ),
    form(
        "For every disturbance d(k) the error of x tends to 0, for all x(0) and xhat(0), with H, J and T = I - HC as real matrices.",
        Claim::UnknownInputOfSamples,
    ),
    form("The estimate at a sample has the measurement of that sample, xhat(k) = z(k) + H y(k).", Claim::Nothing),
    form(
        "The estimate is xhat(k|k) = xhat(k|k-1) + N (y(k) - C xhat(k|k-1)); e is the error of the prediction xhat(k|k-1), and w = T xhat(k|k-1) has n - p entries: p of the poles are 0.",
        Claim::Nothing,
    ),
    form("The order is {#}: {}, and {}.", Claim::Nothing),
    form(
        "State of the step: the estimate at the sample, then the state of the observer for the next one.",
        Claim::Nothing,
    ),
    form(
        "w' = F w + G y + H u, xhat = M w + N y with {#} of {#} states: for all x(0) and w(0) the error {}, with M, N, F and G as real matrices.",
        Claim::Reduced,
    ),
    form("Without w the error tends to 0, for all x(0) and xhat(0).", Claim::WithoutW),
    form(
        "Under all noise and disturbances within `bounds`, the error in the end is at most {}, approached like exp(-{#} t).",
        Claim::Ultimate,
    ),
    form(
        "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at every sample, the rounding of every operation in {} included.",
        Claim::EnclosesSampled,
    ),
    form(
        "As long as x(t) and u(t) stay in the region ({}), with e = xi - phi(x) and V = sqrt(e'Pe): V(t) <= {}, and while V(t) <= {#} the estimation error is at most {}.",
        Claim::KklGuaranteed,
    ),
    form("From every xi(0) the estimation error tends to 0.", Claim::KklConverges),
    form("From every xi(0) the estimation error is in the limit at most {}.", Claim::KklLimit),
    form(
        "The observer is made for xi - phi(x) to decay and xhat = phi^L(xi, y) to tend to x while x(t) and u(t) stay in the region ({}).",
        Claim::Nothing,
    ),
    form(
        "The observer is made for a manifold beta(y, chi) = phi(x) that is invariant, with xhat = x on it.",
        Claim::Nothing,
    ),
    form("Its convergence is not proved: check it by simulation.", Claim::Nothing),
    form(
        "As long as x(t) and u(t) stay in the region ({}) and beta(y(t), chi(t)) in the box of phi over it ({}), the distance beta(y, chi) - phi(x) decays exponentially, and xhat = phi^L(beta(y, chi), y) is Lipschitz in it: the estimation error tends to 0.",
        Claim::ImmersionConverges,
    ),
    form(
        "The observer is made for this: as long as x(t) and u(t) stay in the region ({}), {}, and the {} converges as far as the run excites the regression.",
        Claim::Nothing,
    ),
    form(
        "z' = D z + B y is made to tend to T(x) while x(t) stays in the region, where the estimation error is that of the left inverse.",
        Claim::Tables,
    ),
    form(
        "z' = D z + B y is made to tend to T(x, u) while x(t) stays in the region and the input is held at a value of its range, where the estimation error is that of the left inverse.",
        Claim::Tables,
    ),
    form("The errors are measured; nothing is proved of them.", Claim::Nothing),
    form("The coefficients of the chain vary, and the gains are those of the first estimate.", Claim::Nothing),
    form("The output depends on the input: the observer uses y - D u = C x.", Claim::Feedthrough),
    form(
        "Under all noise and disturbances within `bounds` the error in the end is at most {}, approached like exp(-{#} t).",
        Claim::Ultimate,
    ),
    form(
        "Under all noise and disturbances within `bounds`, for every deviation of A and while the states keep theirs, the error in the end is at most {}, approached like exp(-{#} t).",
        Claim::Ultimate,
    ),
    form(
        "Under all noise and disturbances within `bounds`, the error in the end is at most {}, approached like {#}^k.",
        Claim::Ultimate,
    ),
    form("With the gains as stored it converges from every initial error.", Claim::CubicEverywhere),
    form("The cubic term takes a semi-implicit step, which does not increase V at any period.", Claim::Nothing),
    form(
        "The estimate is xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); e is the error of the prediction xhat(k|k-1).",
        Claim::Nothing,
    ),
    form("{}, |x(t) - xhat(t)| <= {#} |x(0) - xhat(0)| {}.", Claim::Envelope),
    form("{}, |x(k) - xhat(k)| <= {#} |x(0) - xhat(0)| q^k with q = {#} at each sample k.", Claim::DiscreteEnvelope),
    form(
        "{}, |x(k) - xhat(k)| <= {#} |x(0) - xhat(0)|, and the error tends to 0 exponentially.",
        Claim::DiscreteConverges,
    ),
    form("{}, the error {}, for every nonlinearity within its sector.", Claim::Sectors),
    form("{}, the error {}, for all {#} nonlinearities within their sectors.", Claim::Sectors),
    form("The sectors enclose the Jacobian over the region.", Claim::Nothing),
    form("The sectors are those of the study; they are not checked.", Claim::Nothing),
    form(
        "{#} entries of the Jacobians vary, too many for a polytope with {} vertices: the norm-bounded form is used, which is more conservative.",
        Claim::Nothing,
    ),
    form("Eq. (3) as printed, with {}.", Claim::Nothing),
    form(
        "The internal error e never grows, as eta > 1/2; x - xhat tends to 0 with it where e(0) = x(0) - xhat(0).",
        Claim::Nothing,
    ),
    form("A copy of the plant with {}, r = {#}.", Claim::Nothing),
    form(
        "If the right-hand side is Lipschitz and r is small enough, the error decays like exp(-c t / r).",
        Claim::Nothing,
    ),
    form("xi' = drift + shape (alpha_i / r^i) (y - head) with the head of each chain, r = {#}.", Claim::Nothing),
    form("The poles are those of the observer at the first estimate.", Claim::Nothing),
    form("One measurement every {#}; {}.", Claim::Nothing),
    form("One measurement every {#} {}; {}.", Claim::Nothing),
    form("The norm of {} is 1 after each update and prediction, and P has no part along it.", Claim::Nothing),
    form("Innovations beyond {#} standard deviations are rejected.", Claim::Nothing),
    form("The estimates at the samples stay within the bounds of the states.", Claim::Nothing),
    form("No bound of the estimation error is certified: {}.", Claim::Nothing),
    form(
        "It is not to be expected that it attracts: the middle of the Jacobians of the distance over the region has an eigenvalue with the real part {#}.",
        Claim::Nothing,
    ),
    form("The {} converges as far as the run excites the regression.", Claim::Nothing),
    form("With leakage this constant moves, and the estimation error does not tend to 0.", Claim::Nothing),
    form(
        "After a jump of the input z - T(x, u) begins anew; while the input varies, the derivative of T by u times u' drives it; an input outside of its range is taken at the nearest end.",
        Claim::Nothing,
    ),
    form(
        "In continuous time the error is 0 after a finite time, for every disturbance up to {#} in {}' (model errors included) and without noise.",
        Claim::FiniteTime,
    ),
    form(
        "No stability certificate for {#} states: convergence in continuous time is a theorem of Levant's, for gains that are large enough.",
        Claim::Nothing,
    ),
    form(
        "The step evaluates the sign at the old estimate (explicit Euler): it chatters, and is meant for comparison.",
        Claim::Nothing,
    ),
    form("The step solves for the sign (implicit Euler): it does not chatter.", Claim::Nothing),
    form(
        "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at all times.",
        Claim::Encloses,
    ),
    form("The half-widths r approach {}, or less, like exp(-{#} t).", Claim::Widths),
    form("A - L C is Metzler.", Claim::Nothing),
    form("A - L C is not Metzler: K is the Metzler matrix above it.", Claim::Nothing),
    form(
        "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at every sample, the rounding of every operation included.",
        Claim::EnclosesSampled,
    ),
    form("While {}, the half-widths r approach {}, or less, by the factor {} at each sample.", Claim::Nothing),
    form("The outputs of the estimate are the measured ones, noise included.", Claim::Nothing),
    form(
        "No stability certificate: T A = F T + G C holds up to rounding, with the relative residual {#}.",
        Claim::Nothing,
    ),
    form(
        "With equality the error of {}, {}, is e' = F e, for all x(0) and w(0): asymptotic rate exp(-{} t).",
        Claim::Nothing,
    ),
    form(
        "With equality the error of {}, {}, is e+ = F e, for all x(0) and w(0): asymptotic factor {} at each sample.",
        Claim::Nothing,
    ),
    form(
        "For every w the integral of |H e|^2 is at most gamma^2 times that of |w|^2 plus e(0)'P e(0), gamma = {#}.",
        Claim::HInfinity,
    ),
    form(
        "For every w the sum of |H e|^2 is at most gamma^2 times that of |w|^2 plus e(0)'P e(0), gamma = {#}.",
        Claim::HInfinity,
    ),
    form(
        "White noise w of unit intensity leaves H e with variances whose sum is below gamma^2 in the end, gamma = {#}.",
        Claim::H2,
    ),
    form(
        "White noise w of unit covariance leaves H e with variances whose sum is below gamma^2 in the end, gamma = {#}.",
        Claim::H2,
    ),
    form("The invariant zeros of (A, E, C) are among the poles, whatever L is: {}.", Claim::Nothing),
    form("Its cost J is {#}, that of the linear optimum {#}: {#} % less.", Claim::Nothing),
    form(
        "The cubic term does not pay: no cubic observer was found whose cost J is less than that of the linear optimum, {#}, by a thousandth.",
        Claim::Nothing,
    ),
    form("This is the linear optimum.", Claim::Nothing),
];

/// The forms of what is said of evidence that is no proof.
pub const EVIDENCE: &[Form] = &[
    form("no certificate: the plant is not detectable, no observer exists", Claim::NotDetectable),
    form("no certificate: {}", Claim::Nothing),
    form("rate {#} is not certified: {}", Claim::Nothing),
    form("errors measured at {#} points that were not used in the fit{}", Claim::Nothing),
    form("errors measured at {#} pairs of state and input that were not used in the fit{}", Claim::Nothing),
    form("that {} is not proved: {}", Claim::Nothing),
    form("that {} is measured at {}: {}", Claim::Nothing),
    form("that {} (A4) is not proved: {}", Claim::Nothing),
    form(
        "along the run of [simulation], int M'M >= {#} I over every window of length {#}, the least after t = {#}; the convergence of the estimator is not proved for other runs",
        Claim::Nothing,
    ),
    form("the excitation of the regression is not checked: it needs a run", Claim::Nothing),
];

/// The forms of the reasons for which there is no design.
pub const REASONS: &[Form] = &[
    form(
        "the plant is not observable, and to working precision its unobservable modes are at {}",
        Claim::NotObservable,
    ),
    form("the plant is not observable: unobservable modes at {}", Claim::NotObservable),
    form("the pair (A, C) is not observable: unobservable eigenvalue {}, PBH margin {#}", Claim::NotObservable),
    form("the pair (A, C) is not detectable: unobservable eigenvalue {}, PBH margin {#}", Claim::NotDetectable),
    form(
        "no gain makes the comparison system of the error stable in the coordinates of the plant",
        Claim::NoGainOfWidth,
    ),
    form(
        "the gain of the least width needs a bound of the noise of every output above 0, and {} has none: no gain is too large for it",
        Claim::Nothing,
    ),
    form("{} is not Hurwitz: its spectral abscissa is {#}", Claim::NotHurwitz),
    form("{} is not Hurwitz, decided exactly: {}", Claim::NotHurwitz),
    form("{} has an eigenvalue that is not inside the unit circle: its spectral radius is {#}", Claim::NotSchur),
    form("{} has an eigenvalue that is not inside the unit circle, decided exactly: {}", Claim::NotSchur),
    form("whether {} is {} is undecided: its {} is {}, up to rounding", Claim::Nothing),
    form("the pair (A, C) is not observable to working precision: {}", Claim::Nothing),
    form("the pair (A, C) is not detectable to working precision: {}", Claim::Nothing),
    form("the plant is not observable to working precision: unobservable modes at {}", Claim::Nothing),
    form(
        "the pair (A, C) is not detectable: unobservable eigenvalue {}, PBH margin {}, decided exactly for the numbers as stored",
        Claim::NotDetectable,
    ),
    form(
        "the pair (A, C) is not detectable at the rate {#}: unobservable eigenvalue {}, PBH margin {}, decided exactly for the numbers as stored",
        Claim::Infeasible,
    ),
    form("no gain makes the {} norm of the error less than {#}: {}", Claim::NoGainOfNorm),
    form(
        "no gain makes the {} norm of the error less than {#} (the best that was found is {#}): {}",
        Claim::NoGainOfNorm,
    ),
    form("not found: a gain{} that makes the {} norm of the error less than {}", Claim::Nothing),
    form(
        "no gain makes the comparison system of the error stable in the coordinates of the plant: {}",
        Claim::NoGainOfWidth,
    ),
    form("no modal coordinates were found in binary64 for the poles of A - LC: {}", Claim::Nothing),
    form("the outputs should be linear in the state, and {}", Claim::Nothing),
    form("{} is infeasible: {}", Claim::Infeasible),
    form("LMI infeasible {}", Claim::Infeasible),
    form("{} is undecided: {}", Claim::Nothing),
    form("rank(C E) is less than the number of unknown inputs, {#}: {}", Claim::Unmatched),
    form(
        "(A, E, C) has the invariant zero {}, which is not in the open left half plane: every observer whose error does not depend on the unknown input has it as a pole",
        Claim::UnstableZero,
    ),
    form(
        "(A, E, C, F) has the invariant zero {}, which is not in the open left half plane: every observer whose error does not depend on the unknown input has it as a pole",
        Claim::UnstableZero,
    ),
    form(
        "(A, E, C) has the invariant zero {}, which is not inside the unit circle: every observer whose error does not depend on the unknown input has it as a pole",
        Claim::UnstableZero,
    ),
    form(
        "(A, E, C, F) has the invariant zero {}, which is not inside the unit circle: every observer whose error does not depend on the unknown input has it as a pole",
        Claim::UnstableZero,
    ),
    form("S = [C E, F1; F, 0] does not have full column rank, {}: {}", Claim::Nothing),
    form("the cubic term of an unknown-input observer is for plants in continuous time {}: {}", Claim::Nothing),
    form(
        "the invariant zeros of (A, E, C) that no gain moves, {}, are among the poles of every unknown-input observer, and the poles specified do not contain them",
        Claim::Nothing,
    ),
    form("C does not have full row rank: {}", Claim::Nothing),
    form("D does not have full row rank for {}", Claim::Nothing),
    form("{} is not positive definite: its smallest eigenvalue is {#}", Claim::Nothing),
    form("{} is not positive semidefinite: its smallest eigenvalue is {#}", Claim::Nothing),
    form("every observer of this order has the eigenvalue {}: {}", Claim::Nothing),
    form("the eigenvectors of A - LC are too close to dependent for modal coordinates: {}", Claim::Nothing),
    form("C N differs from -w I, w = {#}, by {#}; rounding explains at most {#}", Claim::Nothing),
    form("to working precision {}", Claim::Nothing),
    form("no observer of this order to working precision: {}", Claim::Nothing),
    form("the sampled pair (Ad, C) is not {}", Claim::Nothing),
    form("the pair (T A, C) of the decoupled plant is not {}", Claim::Nothing),
    form("the pair (A, C) of {} is not {}", Claim::Nothing),
    form("the pair (A, C) with every nonlinearity in the middle of its sector is not {}", Claim::Nothing),
    form("no stabilizing solution was found: {}", Claim::Nothing),
    form("whether the width of the interval stays bounded is undecided: {}", Claim::Nothing),
    form("no disturbance within these bounds reaches the error, since {}", Claim::Nothing),
    form("{}, is beyond the range of {}", Claim::Nothing),
    form("{}, is no number of {}, which would round it", Claim::Nothing),
    form("the eigenvectors of A - LC, for modal coordinates, were not found in floating point", Claim::Nothing),
    form(
        "no observer of this order: row {#} of K A is not a combination of the rows of [K; C A; C], residual {#} (limit {#}) (Darouach's first condition)",
        Claim::Nothing,
    ),
    form("no output sees the state x = {}", Claim::Nothing),
    form("no output sees the constant disturbance d = {}", Claim::Nothing),
    form("the disturbance d = {}", Claim::Nothing),
    form("the pole {} is repeated {#} times; {}", Claim::Nothing),
    form("the poles of A - LC are not distinct enough for modal coordinates: {}", Claim::Nothing),
    form(
        "the width of the interval would grow: the comparison system of the error has the {} {#}, which is not below {#}",
        Claim::Nothing,
    ),
    form("the observer pole {} is not {}", Claim::Nothing),
    form("{} must be positive and finite; it is {}", Claim::Nothing),
    form(
        "no stabilizing solution: the closed loop keeps the eigenvalue {}, at {#} from the stability boundary",
        Claim::Nothing,
    ),
    form(
        "the process noise W does not excite the eigenvalue {} on the stability boundary, PBH margin of (A, W) {#}",
        Claim::Nothing,
    ),
    form("{} did not converge in {#} iterations: residual {#} (limit {#})", Claim::Nothing),
    form("{} exceeds the range of double precision", Claim::Nothing),
    form("{} outputs of {} states leave no measured or no unmeasured state", Claim::Nothing),
    form("convergence is not proved for {}", Claim::Nothing),
    form("the {} equation {}", Claim::Nothing),
    form("whether the {} equation has a unique solution is undecided in double precision: {}", Claim::Nothing),
    form("{} is singular to working precision (condition {})", Claim::Nothing),
    form("{} has no finite bound at {}", Claim::Nothing),
    form("{}; the derivatives must be bounded over the region", Claim::Nothing),
    form("{} has more than 64 ways through its branches at {}", Claim::Nothing),
    form("it is undecided whether {}", Claim::Nothing),
    form("phi does not solve D phi f = Lambda phi + B: {}", Claim::Nothing),
    form("(phi, h) is not injective on the box: {}", Claim::Nothing),
    form("`left_inverse` {}", Claim::Nothing),
    form("row {#} of `s`, `g` and `m` is no regression: {}", Claim::Nothing),
    form("the regression is not exciting along the run of [simulation]: {}", Claim::Nothing),
    form("D_chi beta does not have the rank {#} (A4): {}", Claim::Nothing),
    form("{} depends on the input: this observer is for y = h(t, x)", Claim::Nothing),
    form("T is not injective on the box: {}", Claim::Nothing),
    form("interpolation error {#} % of the width of T (limit {#} %)", Claim::Nothing),
    form("the plant escapes backward in time: {}", Claim::Nothing),
    form("the integration from {} stopped after {}", Claim::Nothing),
    form("none of {#} designs with cut-off frequencies {}", Claim::Nothing),
    form("M({#}, {#}) is {}", Claim::Nothing),
    form("{} is not Hurwitz at {}: its spectral abscissa is {#}", Claim::Nothing),
    form("{} is not Schur at {}: its spectral radius is {#}", Claim::Nothing),
    form(
        "|A| times the longest time between samples is {#}: the prediction has {#} substeps at most, one for each {#}",
        Claim::Nothing,
    ),
    form("`jitter` and `misses` are for plants in continuous time", Claim::Nothing),
    form("a cubic term, `gamma`, is for plants in continuous time, and this one has dt = {#}", Claim::Nothing),
    form("the decay rate times the period {}", Claim::Nothing),
    form("`rho` and `q` are for plants in continuous time", Claim::Nothing),
    form("the kind {}", Claim::Nothing),
];

/// The forms of the alternatives to a design that there is not, and of hints.
pub const ALTERNATIVES: &[Form] = &[
    form(
        "the plant is not detectable, no observer exists: add an output that depends on this direction",
        Claim::NotDetectable,
    ),
    form(
        "the plant is not detectable, no observer exists: add an output that depends on its unobservable modes, {}",
        Claim::NotDetectable,
    ),
    form("an observer exists, since the plant as stored is observable, and its gain is large: {}", Claim::Observable),
    form("the unobservable modes are stable (the plant is detectable): {}", Claim::Detectable),
    form("{}", Claim::Nothing),
];

/// The forms of headers of exported code; the statement of the design follows some of them.
pub const HEADERS: &[Form] = &[
    form(
        "With the gains as stored in {}, in exact arithmetic, the estimation error of a plant x+ = A x + B u, y = C x with the stored A, B and C tends to 0 exponentially from every initial error.",
        Claim::HeaderStored,
    ),
    form("They are those of the sampled plant.", Claim::HeaderSame),
    form("{} rounds those of the sampled plant: its own error need not tend to 0.", Claim::Nothing),
    form("Proved (certificate.json):", Claim::HeaderProved),
    form("Proved (certificate.json){}:", Claim::HeaderProved),
    form(
        "Proved (certificate-feedback.json, with z = (x, xhat) as its error), for the input held over the period and all numbers as stored in {}, in exact arithmetic:",
        Claim::HeaderLoop,
    ),
    form(
        "Rounding and noise: for inputs held over each period, and while the magnitudes of {} stay within these bounds, the error in the end is at most {}, and no operation leaves the range of {}.",
        Claim::HeaderBound,
    ),
    form(
        "Rounding and noise, and every deviation of A within `bounds`: for inputs held over each period, and while the magnitudes of {} stay within these bounds, the error in the end is at most {}, and no operation leaves the range of {}.",
        Claim::HeaderBound,
    ),
    form(
        "The bounds are 1.2 times the magnitudes in the study's simulation, rounded up, with four standard deviations for Gaussian noise.",
        Claim::Nothing,
    ),
    form("The linearisation at the operating point is sampled with the input held.", Claim::Nothing),
    form("no theorem certifies an extended Kalman filter here.", Claim::Nothing),
    form("Proved (certificate.json), {}:", Claim::HeaderProved),
    form("Rounding to {} on the target is not covered.", Claim::Nothing),
    form("Rounding to {} on the target: no bound is proved{}.", Claim::Nothing),
    form("Without measurement noise it is at most {}.", Claim::Nothing),
    form(
        "No useful bound of {}: along the study's simulation a constant estimate has a smaller error than the bound that is proved.",
        Claim::Nothing,
    ),
    form("It comes from {}.", Claim::Nothing),
    form("What may give one: {}.", Claim::Nothing),
    form(
        "The estimate is that of the filter form, xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); what is proved is about the error of the prediction xhat(k|k-1).",
        Claim::Nothing,
    ),
    form(
        "The gain is that of the {} filter of the sampled plant, disturbances and noise held over the period.",
        Claim::Nothing,
    ),
    form("The bound of the norm is not in the certificate.", Claim::Nothing),
    form("No stability certificate{}.", Claim::Nothing),
    form("In the certificate y is the measured output minus D u.", Claim::Nothing),
    form(
        "The step predicts with the inputs of its call, held over the time dt; rounding to {} on the target is not covered.",
        Claim::Nothing,
    ),
    form(
        "The step in this code solves the implicit equation in closed form; rounding to {} is not covered.",
        Claim::Nothing,
    ),
    form(
        "What this code computes, {} of the Runge-Kutta method per period and an output predicted between samples, approaches that as the period goes to 0; the proof does not cover it, nor rounding to {}.",
        Claim::Nothing,
    ),
    form(
        "Between samples the plant is linear: the prediction is its exact discretisation, with the input held over the period.",
        Claim::Nothing,
    ),
    form(
        "A prediction takes {} of the Runge-Kutta method; along {} of a run without noise its error was measured: at most {} standard deviations.",
        Claim::Nothing,
    ),
    form(
        "A step takes {} of the Runge-Kutta method; along {} of a run without noise its error was measured: at most {} of the largest change of an estimate in a period.",
        Claim::Nothing,
    ),
    form(
        "A step takes {} of the Runge-Kutta method; along {} of a run without noise its error was measured, and is not finite.",
        Claim::Nothing,
    ),
    form(
        "A step takes {} of the Runge-Kutta method; its error was not measured: h is not finite at the start of the run.",
        Claim::Nothing,
    ),
    form("The exported estimate is z.", Claim::Nothing),
    form(
        "Between two samples the disturbance is not seen: it adds an error of the order of the period times the disturbance.",
        Claim::Nothing,
    ),
    form("State of the step: the estimate, then the half-widths r of its bounds, then rho.", Claim::Nothing),
    form("Start from xhat with r and rho of the first state, as written here.", Claim::Nothing),
    form(
        "The bounds hold for the estimates after a measurement; the exported estimate is the prediction for the next sample, which may violate them.",
        Claim::Nothing,
    ),
    form("No stability certificate:", Claim::Nothing),
    form("Measured, not proved:", Claim::Nothing),
    form("The plant of the certificate is that of the study with {}.", Claim::Nothing),
    form("For the error e1' = {} of a super-twisting observer in continuous time with {}: {}", Claim::Nothing),
    form("The left inverse is {}; between samples a copy of the plant predicts the output.", Claim::Nothing),
];

/// A sentence with its form, and the texts of its holes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sentence {
    pub text: String,
    /// None for a sentence of no known form.
    pub claim: Option<Claim>,
    pub holes: Vec<String>,
}

impl Sentence {
    /// The number of a hole.
    pub fn number(&self, hole: usize) -> Option<f64> {
        self.holes.get(hole)?.parse().ok()
    }

    pub fn hole(&self, hole: usize) -> &str {
        self.holes.get(hole).map_or("", String::as_str)
    }
}

/// The sentences of a text, one after the other.
pub fn split(text: &str, forms: &[&[Form]]) -> Vec<Sentence> {
    let (mut all, mut rest) = (Vec::new(), text.trim());
    while !rest.is_empty() {
        let found = forms.iter().copied().flatten().filter_map(|form| {
            let (holes, after) = matched(form.text, rest)?;
            Some((form, holes, after))
        });
        // The longest form has said most; one that begins with a hole may have swallowed a sentence.
        let (claim, holes, after) = match found.max_by_key(|(form, ..)| (!form.text.starts_with('{'), form.text.len()))
        {
            Some((form, holes, after)) => (Some(form.claim), holes, after),
            None => (None, Vec::new(), &rest[end(rest)..]),
        };
        let text = rest[..rest.len() - after.len()].trim().to_owned();
        all.push(Sentence { text, claim, holes });
        rest = after.trim_start();
    }
    all
}

/// Where a sentence ends that has no form.
fn end(text: &str) -> usize {
    let is_end = |at: &usize| text[at + 2..].starts_with(char::is_uppercase);
    text.match_indices(". ").map(|(at, _)| at).find(is_end).map_or(text.len(), |at| at + 1)
}

/// The holes of a form at the beginning of a text, and what follows.
fn matched<'a>(form: &str, text: &'a str) -> Option<(Vec<String>, &'a str)> {
    let Some(at) = form.find('{') else {
        let after = text.strip_prefix(form)?;
        // The end of a form is the end of a sentence.
        return (after.is_empty() || after.starts_with(' ')).then_some((Vec::new(), after));
    };
    let text = text.strip_prefix(&form[..at])?;
    let close = at + form[at..].find('}')?;
    let (is_number, form) = (&form[at..=close] == "{#}", &form[close + 1..]);
    let next: &str = form.split('{').next().unwrap_or("");
    let mut from = 0;
    loop {
        // An empty text behind a hole: the hole takes all.
        let length = if next.is_empty() { text.len() } else { from + text[from..].find(next)? };
        let hole = &text[..length];
        if hole.contains(". ") && !next.is_empty() {
            return None;
        }
        if (!is_number || hole.parse::<f64>().is_ok())
            && let Some((mut holes, after)) = matched(form, &text[length..])
        {
            holes.insert(0, hole.to_owned());
            return Some((holes, after));
        }
        if next.is_empty() || length >= text.len() {
            return None;
        }
        from = length + text[length..].chars().next().map_or(1, char::len_utf8);
    }
}

/// `exp(-2 t)`, `exp(-t)`, `and tends to 0`: the rate.
pub fn rate(decay: &str) -> Option<f64> {
    let Some((_, rest)) = decay.split_once("exp(-") else {
        return decay.contains("tends to 0").then_some(0.0);
    };
    let (rate, _) = rest.split_once("t)")?;
    if rate.trim().is_empty() { Some(1.0) } else { rate.trim().parse().ok() }
}

/// `x1 0.5, x2 2`: the numbers, of units too.
pub fn listed(list: &str) -> Vec<f64> {
    // Where no useful bound is stated, every number is one.
    let number = |one: &str| {
        if one.ends_with(NO_USEFUL_BOUND) {
            Some(f64::INFINITY)
        } else {
            one.split_whitespace().find_map(|word| word.parse().ok())
        }
    };
    list.split(", ").filter_map(number).collect()
}
