//! The errata: what does not hold as printed, each with the claims that show it.

use crate::paper::Finding;

pub(super) fn findings() -> Vec<Finding> {
    vec![
        Finding {
            title: "Theorem 1 of the mean-value-theorem paper is false",
            statement: "That the internal error e vanishes does not bring x̂ to x. With z = x̂ + e the observer says z' = f(z, u) + [G_m; 0](y - Cz): x - z is injected into the measured rows \
                        only, and nothing makes it vanish. Six plants show it: the fifth is stable, and the gain makes the error grow; in the sixth, that of Example 1, two starts have the same output, so that no observer converges from \
                        everywhere. In coordinates whose unmeasured block contracts the theorem is true.",
            claims: &[
                "mvt.thm1.as-stated",
                "mvt.thm1.counterexample-1",
                "mvt.thm1.counterexample-2",
                "mvt.thm1.counterexample-3",
                "mvt.thm1.counterexample-4",
                "mvt.thm1.counterexample-5",
                "mvt.thm1.counterexample-6",
                "mvt.eq7",
            ],
        },
        Finding {
            title: "The examples work because the observer is told x(0)",
            statement: "e0 = x0 - x̂0 makes x - z = 0 for ever: the observer copies the plant. With e01, 0.3 or 0.5 off in one entry, the error is still there after 10 s in Example 1 and in the \
                        classical plant of Example 2, and grows like e^(3t) in the plant as printed.",
            claims: &[
                "mvt.ex1.e0-is-identity",
                "mvt.ex1.e01-converges",
                "mvt.ex2.classical-e01",
                "mvt.ex2.printed-e01",
                "mvt.fig9",
                "mvt.ex2.from-the-same-information",
            ],
        },
        Finding {
            title: "Raising η slows the convergence down",
            statement: "The internal error falls faster, the real one more slowly: a larger gain holds the measured rows tighter, and less of the unmeasured error shows in them. And η > ½ is enough \
                        for the decrease that the paper proves; (17) drops a factor ½.",
            claims: &["mvt.raising-eta", "mvt.thm1.eta-half"],
        },
        Finding {
            title: "β need not be unique, cannot be continuous, and need not be found",
            statement: "A row that is affine along e leaves β open, and where a row has an inflection in the middle of the segment two roots coexist and β jumps, by any rule. A bracketed \
                        root per row is enough, least squares may even miss it, and the integral mean of the Jacobian needs no β at all.",
            claims: &[
                "mvt.ex1.beta-unique",
                "mvt.ex2.beta-continuous",
                "mvt.beta-must-be-determined",
                "mvt.lsqnonlin-finds-beta",
            ],
        },
        Finding {
            title: "Misprints of the examples",
            statement: "e0 of Example 1 lost its minus, x̂0 of Example 2 gained four, A(4,4) took the 3.33 of the sine, and the entry (4, 2) of the gain of [16] has two decimal points.",
            claims: &["mvt.ex1.e0-sign", "mvt.ex2.xhat0-sign", "mvt.ex2.a44", "mvt.ex2.gain-of-16"],
        },
        Finding {
            title: "What repairs it, and where nothing does",
            statement: "With L (y - Cz) in the place of [G_m; 0](y - Cz), and one L and P for the vertices of the mean Jacobian, the observer of Example 2 converges from every internal error, with a proof. \
                        In Example 1 no constant gain can be proved, because x3 is hidden where x1 passes 0.",
            claims: &[
                "mvt.repair.ex2-classical",
                "mvt.repair.ex2-printed",
                "mvt.repair.coordinates",
                "mvt.repair.ex1",
                "mvt.repair.ex1-proof",
            ],
        },
    ]
}
