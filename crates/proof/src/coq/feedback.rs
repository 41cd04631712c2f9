//! `feedback-loop`: the cubic observer and `u = -K xhat`.

use super::cubic::{REAL_GAIN, REGION, STORED, Stored, StoredGain, structured_gain};
use super::{Between, CoqError, Out, points};
use crate::certificate::{Fact, FeedbackLoop};
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::statement::{largest_eigenvalue_bound, positive};

/// (25) with a rate of decay.
const DECREASES: &str = "[(A - BK)'P1 + P1(A - BK) + 2 decay P1, P1 B K; *, (A - LC)'P + P(A - LC) + 2 decay P] <= 0";

/// The state with a rate of decay, driven by an error of which V falls like `-q |e|^2`: `rest` is `2 decay upper - q`.
const DRIVEN: &str = "[(A - BK)'P1 + P1(A - BK) + 2 decay P1, P1 B K; *, rest I] <= 0";

/// By how much smaller than P a matrix P1 is tried, as a power of 4.
const SMALLEST: i32 = 12;

/// A rate at which `x'P1 x + e'Pe` falls, near the largest; 0 if there is none.
fn rate(theorem: &FeedbackLoop, p1: &Matrix<f64>, p: &Matrix<f64>) -> Result<f64, CoqError> {
    let (plant, names) = (&theorem.observer.plant, Names::new());
    let names = names.matrix("A", &plant.a).matrix("B", &plant.b).matrix("C", &plant.c).matrix("K", &theorem.k);
    let names = names.matrix("L", &theorem.observer.l).symmetric("P", p).symmetric("P1", p1);
    largest_rate(&plant.a, |decay| Ok(names.clone().number("decay", decay).decide(DECREASES)?.is_proved()))
}

/// A rate near the largest at which an inequality holds; 0 if there is none.
fn largest_rate(a: &Matrix<f64>, holds: impl Fn(f64) -> Result<bool, CoqError>) -> Result<f64, CoqError> {
    let falls = |decay: f64| Ok::<bool, CoqError>(decay.is_finite() && holds(decay)?);
    // The size of the matrices sets the scale; a number that is too large is halved.
    let largest = a.as_slice().iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
    let mut high = largest * 2.0 * a.rows() as f64;
    let mut low = high;
    for _ in 0..60 {
        if falls(low)? {
            break;
        }
        (low, high) = (low / 2.0, low);
    }
    if !falls(low)? {
        return Ok(0.0);
    }
    for _ in 0..8 {
        let middle = f64::midpoint(low, high);
        if falls(middle)? { low = middle } else { high = middle }
    }
    // Some room, so that the kernel need not decide what is nearly singular.
    Ok(low * (1.0 - 1.0 / 1024.0))
}

/// Bounds of the eigenvalues of two matrices.
fn of_both(p1: [f64; 2], p: [f64; 2]) -> Between {
    let (lower, upper) = (p1[0].min(p[0]), p1[1].max(p[1]));
    let overshoot = (upper / lower).next_up().sqrt().next_up();
    Between { lower, upper, overshoot }
}

fn bounds(p: &Matrix<f64>) -> Result<[f64; 2], CoqError> {
    Ok([positive(p)?.margin().unwrap_or(0.0), largest_eigenvalue_bound(p)])
}

/// The loop, with this matrix as N.
fn loop_of(n: usize, outputs: usize, gain: &str) -> [String; 2] {
    [
        format!("solution T {n} x (fun t => A * x t - B * (K * xhat t))%vector"),
        format!(
            "solution T {n} xhat (fun t => let r := (C * x t - C * xhat t)%vector in\n    \
             (A * xhat t - B * (K * xhat t) + L * r - quadratic {outputs} theta r .* apply {outputs} {gain} r)%vector)"
        ),
    ]
}

/// What is said of the solutions that exist.
fn exists_loop(n: usize, outputs: usize, gain: &str) -> String {
    let [plant, observer] = loop_of(n, outputs, gain);
    format!(
        "exists x xhat : R -> vector,\n  \
         (forall i, (i < {n})%nat -> x 0 i = x0 i /\\ xhat 0 i = xhat0 i) /\\ forall T,\n  \
         {plant}\n  /\\ {observer}"
    )
}

impl Out {
    pub(super) fn feedback(
        &mut self,
        theorem: &FeedbackLoop,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let FeedbackLoop { observer, k, p1 } = theorem;
        let Some((of_loop, of_observer)) = facts.split_last_chunk::<2>().map(|(first, last)| (last, first)) else {
            return Ok(());
        };
        let [positive, block] = of_loop;
        let stored = self.cubic(observer, of_observer, claimed)?;
        let (n, inputs, outputs) = (observer.plant.a.rows(), observer.plant.b.cols(), observer.plant.c.rows());
        self.matrix("K", &points(k)?, &format!("The feedback gain, {inputs} x {n}."));
        self.matrix("P1", &points(p1)?, "The matrix of x'P1 x.");
        self.positive(n, "P1", positive, claimed.get(of_observer.len()))?;
        self.block((n, inputs, outputs), block, claimed.get(of_observer.len() + 1))?;
        let Some(stored) = stored.filter(|_| of_loop.iter().all(|fact| fact.verdict.is_proved())) else {
            return Ok(());
        };
        let between = of_both(bounds(p1)?, bounds(&observer.p)?);
        let decay = rate(theorem, p1, &observer.p)?;
        if !(between.lower > 0.0 && decay > 0.0) {
            return Err(CoqError::NoMargin { inequality: block.inequality.clone() });
        }
        self.loop_numbers(&between, decay, "_loop")?;
        let checked = |p1: &str, p: &str, suffix: &str| {
            format!(
                "loop_decays {n} {inputs} {outputs} A B C K L {p1} {p} theta\n  decay{suffix} lower{suffix} upper{suffix} overshoot{suffix}"
            )
        };
        self.lemma("decided_loop", &checked("P1", "P", "_loop"));
        self.closed(
            (n, outputs),
            ["real_gain_loop", REAL_GAIN, &structured_gain(n, outputs), "N0"],
            ["P1", "P", "_loop"],
            "intros N0 structure. ",
            "N0 (structure_dissipates _ _ _ _ _ _ accretive_S structure)",
        );
        let stored = match stored {
            Stored::Everywhere(stored) => stored,
            Stored::Within { q, upper } => return self.closed_within(theorem, q, upper),
        };
        let (p1, between, decay) = near(theorem, &stored)?;
        self.matrix(
            "P1_stored",
            &points(&p1)?,
            "The matrix of x'P1_stored x for the gains as stored: P1, up to a factor.",
        );
        self.loop_numbers(&between, decay, "_stored_loop")?;
        self.lemma("decided_stored_loop", &checked("P1_stored", "P_stored", "_stored_loop"));
        self.closed(
            (n, outputs),
            ["stored_gain_loop", "With the gains K, L and N exactly as stored", "", "(real N)"],
            ["P1_stored", "P_stored", "_stored_loop"],
            "",
            STORED,
        );
        Ok(())
    }

    /// The theorem about the loop with the gains as stored, from errors below the level.
    fn closed_within(&mut self, theorem: &FeedbackLoop, q: f64, upper: f64) -> Result<(), CoqError> {
        let FeedbackLoop { observer, .. } = theorem;
        let (n, inputs, outputs) = (observer.plant.a.rows(), observer.plant.b.cols(), observer.plant.c.rows());
        let (p1, between, decay) = driven(theorem, q, upper)?;
        let what = "The matrix of x'P1_stored x for the gains as stored: P1, up to a factor.";
        self.matrix("P1_stored", &points(&p1)?, what);
        self.loop_numbers(&between, decay, "_stored_loop")?;
        self.lemma(
            "decided_stored_loop",
            &format!(
                "region_loop_decays {n} {inputs} {outputs} A B C K L N P1_stored P theta S\n  {REGION}\n  \
                 decay_stored_loop lower_stored_loop upper_stored_loop overshoot_stored_loop"
            ),
        );
        let [plant, loop_observer] = loop_of(n, outputs, "(real N)");
        let holes = ["_"; 27].join(" ");
        let sum = |at: &str| format!("share * quadratic {n} P1_stored (x {at}) + quadratic {n} P (e {at})");
        self.theorem(
            "stored_gain_loop",
            "With the gains K, L and N exactly as stored: x and e = x - xhat of the plant x' = A x + B u, y = C x with u = -K xhat\n    \
             and the observer xhat' = A xhat + B u + L r - (r'theta r) N r, r = y - C xhat, from every x(0) and every e(0) with\n    \
             e(0)'P e(0) below the level.",
            &format!(
                "forall (T : R) (x xhat : R -> vector),\n  \
                 {plant} ->\n  {loop_observer} ->\n  \
                 let e t := (x t - xhat t)%vector in\n  \
                 quadratic {n} P (e 0) < level ->\n  \
                 let share := 1 - quadratic {n} P (e 0) / level in\n  \
                 0 < share\n  \
                 /\\ (forall s t, 0 <= s -> s <= t -> t < T ->\n    \
                 {}\n      <= exp (- (2 * (decay_stored_loop * share)) * (t - s)) * ({}))\n  \
                 /\\ (forall t, 0 <= t -> t < T ->\n    \
                 norm_of_pair {n} (x t) (e t)\n      \
                 <= overshoot_stored_loop / sqrt share * exp (- (decay_stored_loop * share) * t) * norm_of_pair {n} (x 0) (e 0))",
                sum("t"),
                sum("s")
            ),
            &format!("exact (region_loop_decay {holes} decided_stored_loop)."),
        );
        self.theorem(
            "stored_gain_loops_exist",
            "With the gains as stored, from every x(0) and xhat(0) with e(0)'P e(0) below the level there are such x and xhat,\n    \
             for all times.",
            &format!(
                "forall x0 xhat0 : vector, quadratic {n} P (x0 - xhat0)%vector < level -> {}",
                exists_loop(n, outputs, "(real N)")
            ),
            &format!("exact (region_loops_exist {holes} decided_stored_loop)."),
        );
        Ok(())
    }

    /// Bounds and rate of `x'P1 x + e'Pe`.
    fn loop_numbers(&mut self, between: &Between, decay: f64, suffix: &str) -> Result<(), CoqError> {
        let name = |name: &str| format!("{name}{suffix}");
        self.float(&name("lower"), between.lower, "All eigenvalues of both matrices are at least this.")?;
        self.float(&name("upper"), between.upper, "All eigenvalues of both matrices are at most this.")?;
        self.float(
            &name("overshoot"),
            between.overshoot,
            &format!("At least the square root of upper{suffix} / lower{suffix}."),
        )?;
        self.float(
            &name("decay"),
            decay,
            &format!("The sum of both functions falls at least like exp(-2 decay{suffix} t)."),
        )
    }

    /// (25), proved or refuted.
    fn block(
        &mut self,
        (n, inputs, outputs): (usize, usize, usize),
        fact: &Fact,
        claimed: Option<&Number>,
    ) -> Result<(), CoqError> {
        let flows = "let f := (A * v - B * (K * v) + B * (K * w))%vector in\n  \
                     let g := (A * w - L * (C * w))%vector in\n  ";
        let form = format!(
            "inner {n} f (P1 * v)%vector + inner {n} v (P1 * f)%vector + inner {n} g (P * w)%vector + inner {n} w (P * g)%vector"
        );
        let squares = format!("square {n} v + square {n} w");
        let arguments = format!("{n} {inputs} {outputs} A B C K L P1 P");
        if fact.verdict.is_proved() {
            self.margin("margin_25", fact, claimed)?;
            self.theorem(
                "inequality_25",
                "(25) at (v, w): the form of [He((A - BK)'P1), P1 B K; *, He((A - LC)'P)] is at most minus the margin times\n    \
                 |v|^2 + |w|^2. It is the derivative of x'P1 x + e'Pe along the linear loop, x = v and e = w.",
                &format!("0 < margin_25 /\\ forall v w : vector,\n  {flows}{form}\n    <= - margin_25 * ({squares})"),
                &format!("apply (loop_inequality {arguments} margin_25). vm_cast_no_check (eq_refl true)."),
            );
        } else if self.witness("v_25", fact)? {
            self.theorem(
                "inequality_25_is_false",
                "(25) is false: its form is not negative at some (v, w).",
                &format!("exists v w : vector, 0 < {squares} /\\\n  {flows}0 <= {form}"),
                &format!("apply (no_loop_inequality {arguments} v_25). vm_cast_no_check (eq_refl true)."),
            );
        }
        Ok(())
    }

    /// The theorem about the loop, for one gain.
    fn closed(
        &mut self,
        (n, outputs): (usize, usize),
        [name, what, quantified, gain]: [&str; 4],
        [p1, p, suffix]: [&str; 3],
        proof: &str,
        dissipates: &str,
    ) {
        let [plant, observer] = loop_of(n, outputs, gain);
        self.theorem(
            name,
            &format!(
                "{what}: x and e = x - xhat of the plant x' = A x + B u, y = C x with u = -K xhat\n    \
                 and the observer xhat' = A xhat + B u + L r - (r'theta r) N r, r = y - C xhat, from every x(0) and xhat(0)."
            ),
            &format!(
                "{quantified}forall (T : R) (x xhat : R -> vector),\n  \
                 {plant} ->\n  {observer} ->\n  \
                 let e t := (x t - xhat t)%vector in\n  \
                 (forall s t, 0 <= s -> s <= t -> t < T ->\n    \
                 quadratic {n} {p1} (x t) + quadratic {n} {p} (e t)\n      \
                 <= exp (- (2 * decay{suffix}) * (t - s)) * (quadratic {n} {p1} (x s) + quadratic {n} {p} (e s)))\n  \
                 /\\ (forall t, 0 <= t -> t < T ->\n    \
                 norm_of_pair {n} (x t) (e t) <= overshoot{suffix} * exp (- decay{suffix} * t) * norm_of_pair {n} (x 0) (e 0))"
            ),
            &format!("{proof}exact (loop_decay _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ decided{suffix} {dissipates})."),
        );
        self.theorem(
            &format!("{name}s_exist"),
            &format!("{what}: from every x(0) and xhat(0) there are such x and xhat, for all times."),
            &format!("{quantified}forall x0 xhat0 : vector, {}", exists_loop(n, outputs, gain)),
            &format!(
                "{proof}refine (loops_exist _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ decided{suffix} _ {dissipates}).\n  \
                 vm_cast_no_check (eq_refl true)."
            ),
        );
    }
}

/// For the matrix of the stored gain a multiple of P1 with which (25) holds: it does for every one that is small
/// enough.
fn near(theorem: &FeedbackLoop, stored: &StoredGain) -> Result<(Matrix<f64>, Between, f64), CoqError> {
    let trace = |m: &Matrix<f64>| (0..m.rows()).map(|i| m[(i, i)]).sum::<f64>();
    let factor = trace(&stored.p) / trace(&theorem.observer.p);
    for k in 0..=SMALLEST {
        let scale = factor * 4.0_f64.powi(-k);
        let p1 = theorem.p1.map(|entry| entry * scale);
        let (decay, between) = (rate(theorem, &p1, &stored.p)?, of_both(bounds(&p1)?, [stored.lower, stored.upper]));
        if between.lower > 0.0 && decay > 2.0 * stored.slower {
            return Ok((p1, between, decay - stored.slower));
        }
    }
    Err(CoqError::StoredGain)
}

/// For an observer that converges from an ellipsoid a multiple of P1 with which the state is driven by its error, and a
/// rate: a smaller one leaves more of q to the error, and of two in turn the faster is taken.
fn driven(theorem: &FeedbackLoop, q: f64, upper: f64) -> Result<(Matrix<f64>, Between, f64), CoqError> {
    let plant = &theorem.observer.plant;
    let of_p = bounds(&theorem.observer.p)?;
    let mut best: Option<(Matrix<f64>, Between, f64)> = None;
    for k in 0..=SMALLEST {
        let p1 = theorem.p1.map(|entry| entry * 4.0_f64.powi(-k));
        let names = Names::new().matrix("A", &plant.a).matrix("B", &plant.b).matrix("K", &theorem.k);
        let names = names.symmetric("P1", &p1);
        let decay = largest_rate(&plant.a, |decay| {
            let rest = ((2.0 * decay * upper).next_up() - q).next_up();
            let names = names.clone().number("decay", decay).number("rest", rest);
            Ok(rest.is_finite() && names.decide(DRIVEN)?.is_proved())
        })?;
        let between = of_both(bounds(&p1)?, of_p);
        let is_faster = best.as_ref().is_none_or(|(.., fastest)| decay > *fastest);
        if !is_faster {
            break;
        }
        if between.lower > 0.0 && decay > 0.0 {
            best = Some((p1, between, decay));
        }
    }
    best.ok_or(CoqError::StoredGain)
}
