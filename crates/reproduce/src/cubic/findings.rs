//! What the paper comes to: what holds, what is a slip of the pen, what is wrong, each with the claims that show it.

use crate::paper::{Finding, Kind};

pub(super) fn findings() -> Vec<Finding> {
    [holds(), slips(), wrong(), open(), beyond()].concat()
}

fn holds() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Holds, title, statement, claims };
    vec![
        finding(
            "Theorem 1, with ≤ in (13), and more: global exponential stability",
            "(12) and P N C + C'N'P ≤ 0 give V' ≤ -e'Qe, and (11) follows. Every admissible gain is N = -P⁻¹C'S with S + S' ≥ 0, of which (14) is one.",
            &["cubic.thm1.nonstrict", "cubic.thm2"],
        ),
        finding(
            "Theorem 3 and the sentence after it, as inequalities of V'",
            "At equal norms, and where the error of the cubic observer is the larger one, its V decreases at least as fast. They compare derivatives of V, not errors.",
            &["cubic.thm3", "cubic.thm3.larger", "cubic.remark3"],
        ),
        finding(
            "Theorem 6 and Corollary 1: the observer in the loop",
            "With (13) read as ≤ the loop is stable if the linear one is; P1 only has to be scaled.",
            &["cubic.thm6", "cubic.thm6.lmi", "cubic.cor1"],
        ),
        finding(
            "Theorem 5 for linear observers, its footnote, and that its bound is conservative",
            "Below (23) V decreases with N = 0 as well. In Example 2 the same gains tolerate an ε three thousand times as large, with another P.",
            &["cubic.thm5.linear", "cubic.thm5.footnote", "cubic.ex2.epsilon-margin"],
        ),
        finding(
            "The numbers of Examples 1 to 3, but for those below",
            "Gains, P, the largest eigenvalue, the bound, and the advantages that Figs 1 to 4, 8 and 9 show.",
            &[
                "cubic.ex1.gain",
                "cubic.ex1.lyapunov",
                "cubic.ex1.cubic-gain",
                "cubic.ex2.lyapunov",
                "cubic.ex2.lambda-max",
                "cubic.ex2.cubic-gain",
                "cubic.ex2.epsilon-bound",
                "cubic.fig4",
                "cubic.fig8",
                "cubic.fig9",
            ],
        ),
    ]
}

fn slips() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Slip, title, statement, claims };
    vec![
        finding(
            "Example 3: N = -10 L, for the printed +10 L",
            "With +10 L no P > 0 satisfies (13'), a second equilibrium exists and the loop blows up after 47 microseconds. With -10 L a P is found, and the cost of Fig. 9 is the lower one, as the paper says.",
            &["cubic.ex3.sign-of-n"],
        ),
        finding(
            "Example 2: L for the poles -30, -10, -5; the printed one places -30, -5, -5",
            "The printed P, its largest eigenvalue and N belong to the stated poles.",
            &["cubic.ex2.gain"],
        ),
        finding(
            "(18): ⇒, for the printed ⇔",
            "The right side does not give the left. With the P of (9), which the proof has, both sides always hold.",
            &["cubic.thm2.arrow"],
        ),
        finding(
            "(23): <, for the printed ≤, as in the last line of the proof",
            "With equality and a singular θ ≥ 0 an error that θ does not weigh stands still, though every hypothesis holds.",
            &["cubic.thm5.equality"],
        ),
        finding("Lemma 1: for v ≠ 0", "At v = 0 the form is 0, not less.", &["cubic.lemma1"]),
    ]
}

fn wrong() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Wrong, title, statement, claims };
    vec![finding(
        "(13) as a strict inequality, which Theorem 2 says (14) fulfils",
        "With fewer outputs than states the form vanishes on the kernel of C, whatever N is. With ≤ the theorems are \
         true.",
        &["cubic.thm2.strict"],
    )]
}

fn open() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Open, title, statement, claims };
    vec![
        finding(
            "“Faster in the beginning”, “a much larger step towards the actual state”: in V, and not in the norm of \
             the error",
            "V is below that of the linear observer at once. The error is larger after 1 ms from 39 % of all \
             directions of Example 1, and settles later from most: from e(0) = (3, -3) d|e|²/dt is +2704, and +36 \
             with the linear observer.",
            &["cubic.thm3.faster", "cubic.remark3.step", "cubic.ex1.faster-from-every-direction"],
        ),
        finding(
            "Theorems 4 and 5 leave out the forcing",
            "An observer that runs the nominal A on a plant with A(ε) has the additional term (A(ε) - A) x in its error, which does not vanish unless x does. Only input-to-state stability holds, with the \
             gain of the linear observer.",
            &["cubic.thm4", "cubic.thm5"],
        ),
        finding(
            "The confidence margin is one where the outputs see the error",
            "V_2' does not depend on the uncertainty, and is 0 for errors in the kernel of C, however large.",
            &["cubic.thm4.margin"],
        ),
        finding(
            "Which γ is best depends on the initial error, which is not printed",
            "γ = 0.1 wins in J3 of Example 2 from the size of e(0) behind the figures; from smaller errors a larger γ wins, from larger ones a smaller. By J of all states γ = 1 wins.",
            &["cubic.fig6", "cubic.fig7"],
        ),
        finding(
            "θ weighs the outputs, and their shares only mostly",
            "A larger r_i makes the error of output i smaller in every case tried; that its share becomes smaller than the other's would be is not always so.",
            &["cubic.remark1"],
        ),
    ]
}

fn beyond() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Beyond, title, statement, claims };
    vec![
        finding(
            "The accumulated error is never larger than the linear one's",
            "For Q = ρI and every e(0); the proof stands in docs/theory-cubic.md.",
            &["cubic.thm3.cost"],
        ),
        finding(
            "(23) is tight for its P; at equality θ > 0 saves the theorem",
            "With (A, C) observable, θ > 0 and S + S' > 0 the error tends to 0 at equality too, like 1/√t.",
            &["cubic.thm5.tight", "cubic.thm5.equality-observable"],
        ),
        finding(
            "Noise adds at most 27/128 γ (v'θv)² to V', whatever the error is",
            "Small noise costs nothing, large noise does.",
            &["cubic.noise.bound", "cubic.noise.example1"],
        ),
        finding(
            "A first error of known covariance is a case for the Kalman filter, an unknown push for the cubic term",
            "With P0 the time-varying filter costs 2 to 12 times less than the best cubic observer found; after a push that it does not expect it costs more, with any process noise tried.",
            &["cubic.kalman.first-error", "cubic.kalman.push"],
        ),
    ]
}
