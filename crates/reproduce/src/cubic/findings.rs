//! The errata: printed statements that are false, each with the claims that show it.

use crate::paper::Finding;

pub(super) fn findings() -> Vec<Finding> {
    vec![
        Finding {
            title: "Condition (13) cannot hold strictly",
            statement: "Theorem 1 asks for P N C + C'N'P < 0. With fewer outputs than states the form vanishes on the kernel of C. \
                        With ≤ the theorem is true and gives global exponential stability; every admissible gain is \
                        N = -P⁻¹ C'S with S + S' ≥ 0.",
            claims: &["cubic.thm1.strict"],
        },
        Finding {
            title: "Example 3 has the sign of N wrong",
            statement: "With N = +10 L no P > 0 satisfies (13'), a second equilibrium exists and the loop blows up after 47 microseconds. \
                        With N = -10 L a P is found and the cost of Fig. 9 is the lower one, as the paper says.",
            claims: &["cubic.ex3.sign-of-n", "cubic.cor1.hypotheses"],
        },
        Finding {
            title: "The L printed in Example 2 belongs to other poles",
            statement: "It places -30, -5, -5. The printed P, its largest eigenvalue and N belong to the stated poles -30, -10, -5.",
            claims: &["cubic.ex2.gain"],
        },
        Finding {
            title: "(23) must be strict, or θ definite",
            statement: "With equality in (23) and a singular θ ≥ 0 an error that θ does not weigh stands still, though every hypothesis holds. With (A, C) observable, θ > 0 and S + S' > 0 the \
                        error tends to 0 at equality too, like 1/√t. For its P the bound is the exact supremum.",
            claims: &["cubic.thm5.equality", "cubic.thm5.equality-observable", "cubic.thm5.tight"],
        },
        Finding {
            title: "Theorems 4 and 5 leave out the forcing",
            statement: "An observer that runs the nominal A on a plant with A(ε) has the additional term (A(ε) - A) x in its error, \
                        which does not vanish unless x does. Only input-to-state stability holds, with the gain of the linear observer.",
            claims: &["cubic.thm4", "cubic.thm5"],
        },
        Finding {
            title: "Which γ is best depends on the initial error",
            statement: "γ = 0.1 wins in Example 2 from the size of e(0) behind the figures; from smaller errors a larger γ wins, \
                        from larger ones a smaller.",
            claims: &["cubic.ex2.gamma-best"],
        },
        Finding {
            title: "(18) is an implication",
            statement: "The right side does not give the left. The proof of Theorem 2 uses the other direction, which is true.",
            claims: &["cubic.thm2.arrow"],
        },
        Finding {
            title: "Misprints",
            statement: "Lemma 1 means v ≠ 0. The footnote on the settling time says \"first\", and the printed 1.7 s and 2.3 s are those of the last crossing. The peak of the linear observer \
                        is 1.19, which a plot with steps of 0.1 s may show as 1.18. 0.00135 is rounded to 0.0014, past the bound that it is. Corollary 1 does not repeat (11)-(13).",
            claims: &[
                "cubic.lemma1",
                "cubic.ex1.settling-first-crossing",
                "cubic.ex1.peak-linear",
                "cubic.ex2.epsilon-bound-holds",
                "cubic.cor1.hypotheses",
            ],
        },
    ]
}
