//! The errata: what does not hold as printed, each with the claims that show it.

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
            title: "The cubic observer is not faster from everywhere",
            statement: "Theorem 3 and Remark 3 compare derivatives at equal errors. From about three quarters of all directions of \
                        e(0) the error of Example 1 settles later than the linear one. What holds is that the accumulated squared \
                        error over an infinite time is never larger, for Q = ρ I.",
            claims: &["cubic.ex1.faster-from-every-direction", "cubic.thm3.faster"],
        },
        Finding {
            title: "Example 3 has the sign of N wrong",
            statement: "With N = +10 L no P > 0 satisfies (13'), a second equilibrium exists and the loop blows up after 47 microseconds. \
                        With N = -10 L a P is found and the cost of Fig. 9 is the lower one, as the paper says.",
            claims: &["cubic.ex3.sign-of-n", "cubic.ex3.equilibrium", "cubic.ex3.blow-up-time", "cubic.cor1"],
        },
        Finding {
            title: "The L printed in Example 2 belongs to other poles",
            statement: "It places -30, -5, -5. The printed P, its largest eigenvalue and N belong to the stated poles -30, -10, -5.",
            claims: &["cubic.ex2.gain", "cubic.ex2.gain-poles"],
        },
        Finding {
            title: "The bound of Theorem 5 is rounded the wrong way",
            statement: "(23) gives 0.00135; the printed 0.0014 lies beyond it, and (23) itself must be strict. For its P the bound is the exact supremum, and for the gains \
                        themselves it is three thousand times too small.",
            claims: &["cubic.ex2.epsilon-bound-holds", "cubic.thm5.tight", "cubic.thm5.equality"],
        },
        Finding {
            title: "Theorems 4 and 5 leave out the forcing",
            statement: "An observer that runs the nominal A on a plant with A(ε) has the additional term (A(ε) - A) x in its error, \
                        which does not vanish unless x does. Only input-to-state stability holds, with the gain of the linear observer.",
            claims: &["cubic.thm4", "cubic.thm5"],
        },
        Finding {
            title: "Settling is not the first crossing",
            statement: "The footnote defines the settling time by the first time the error is below 0.05; the printed 1.7 s and 2.3 s are \
                        those of the last crossing.",
            claims: &["cubic.ex1.settling-first-crossing"],
        },
        Finding {
            title: "The peak of the linear observer is misprinted",
            statement: "The overshoot of e2 in Example 1 is 1.19, not 1.18.",
            claims: &["cubic.ex1.peak-linear"],
        },
        Finding {
            title: "Which γ is best depends on the initial error",
            statement: "γ = 0.1 wins in Example 2 from the size of e(0) behind the figures; from smaller errors a larger γ wins, \
                        from larger ones a smaller.",
            claims: &["cubic.ex2.gamma-best"],
        },
        Finding {
            title: "Smaller slips",
            statement: "Lemma 1 holds for v ≠ 0; (18) is an implication, not an equivalence; (9) has a solution P > 0 for every Q > 0 iff A - LC \
                        is Hurwitz, for which observability only provides an L.",
            claims: &["cubic.lemma1", "cubic.thm2.arrow", "cubic.eq9"],
        },
    ]
}
