//! What the paper comes to: what holds, what is a slip of the pen, what is wrong, each with the claims that show it.

use crate::paper::{Finding, Kind};

pub(super) fn findings() -> Vec<Finding> {
    [holds(), slips(), wrong(), open(), beyond()].concat()
}

fn holds() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Holds, title, statement, claims };
    vec![
        finding(
            "The internal error decreases",
            "V = e'e/2 of the e that the observer integrates falls wherever an α_k is not 0, with η ≥ 1 and already with η > ½; (17) drops a factor ½.",
            &["mvt.thm1.internal-decrease", "mvt.thm1.eta-half"],
        ),
        finding(
            "Given x(0) exactly the observer follows the plant",
            "e0 = x0 - x̂0 makes x - x̂ - e = 0 for ever: the observer is given x(0) and copies the plant.",
            &["mvt.ex1.e0-is-identity", "mvt.ex2.e0"],
        ),
        finding(
            "β exists at every moment",
            "X_i depends on β_i alone and has the mean 0: one bracketed root per row.",
            &["mvt.ex1.beta-in-unit-interval", "mvt.ex2.beta-in-unit-interval"],
        ),
        finding(
            "Lipschitz designs fail for 3.33, and the mean value theorem gives a gain",
            "With the unstructured constant no gain exists, with the two vertices of the mean Jacobian one does: both with proofs.",
            &["mvt.ex2.unstructured-lipschitz", "mvt.ex2.polytopic"],
        ),
        finding(
            "In Example 2 x̂ settles beside its peers, given less than they are or as much",
            "|x - x̂| is within 5 % after 3.4 s from e01 and after 8 s from nothing.",
            &["mvt.fig9", "mvt.ex2.from-the-same-information"],
        ),
    ]
}

fn slips() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Slip, title, statement, claims };
    vec![
        finding(
            "Example 1: e0 = (-1, -.5, .5), for the printed (1, ..)",
            "The 1 lost its minus.",
            &["mvt.ex1.e0-sign"],
        ),
        finding(
            "Example 2: x̂0 = (1, 2, .5, 1), for the printed minus signs",
            "e0 = x0 - x̂0 is printed twice, once with (2, 1, 2.5, 2), and e01 differs from it in the last entry \
             alone. Taken both as printed the observer converges too, at the same pace.",
            &["mvt.ex2.xhat0-sign", "mvt.ex2.both-as-printed"],
        ),
        finding(
            "Example 2: A(4,4) = 0, for the printed 3.33",
            "It is the 3.33 of the sine; with it the plant is unstable.",
            &["mvt.ex2.a44"],
        ),
        finding(
            "[16]: l42 = 8.4967, for the printed 8.49.67",
            "The reading with four decimals, and the best damped.",
            &["mvt.ex2.gain-of-16"],
        ),
        finding("(18): e'De < e'Ge, for the printed e'Ge < e'Ge", "D and G have one name from (16) on.", &["mvt.eq18"]),
        finding(
            "Abstract: without a linear term, and nonlinear, as in the introduction",
            "“With a linear term” and “a linear system” are the abstract's.",
            &["mvt.linear-term"],
        ),
        finding(
            "Conclusion: without unknown inputs, as in the introduction",
            "The observer needs u.",
            &["mvt.unknown-inputs"],
        ),
        finding("Figures are cited one too high", "Fig. 4 is cited as fig. 5, and so on.", &["mvt.figure-numbers"]),
    ]
}

fn wrong() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Wrong, title, statement, claims };
    vec![
        finding(
            "Theorem 1: that e vanishes does not bring x̂ to x",
            "With z = x̂ + e the observer says z' = f(z, u) + [G_m; 0](y - Cz): x - z is injected into the measured rows only, and nothing makes it vanish. (10) is false of x - x̂. Five plants show it, \
             with every hypothesis evaluated: one is stable, and the gain makes its error grow; on that of Example 1 two starts have the same output, so that no observer converges from everywhere.",
            &["mvt.thm1.as-stated", "mvt.eq7"],
        ),
        finding(
            "(4) is not necessary either",
            "On x' = x - x³ the estimate passes 1/√3, where (4) reads 0 < 0, and arrives.",
            &["mvt.necessary"],
        ),
        finding(
            "β is not continuous",
            "Where a row has an inflection in the middle of the segment two roots coexist and β jumps, by any rule. The gradient does not, so the observer does not notice.",
            &["mvt.ex2.beta-continuous"],
        ),
    ]
}

fn open() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Open, title, statement, claims };
    vec![finding(
        "From e01 the observer converges within 100 s and not within 10, and no horizon is printed",
        "The internal error is gone within a second or two, and the real one follows at the pace of what the observer was not given. That depends on what is measured: with the classical outputs \
         y = (x1, x2) a swing of the link remains, and with a44 = 3.33 as printed the error grows like e^(3t).",
        &["mvt.ex1.e01-converges", "mvt.fig5", "mvt.ex2.e01", "mvt.ex2.classical-e01", "mvt.ex2.printed-e01"],
    )]
}

fn beyond() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Beyond, title, statement, claims };
    vec![
        finding(
            "Raising η slows the convergence down",
            "The internal error falls faster, the real one more slowly: a larger gain holds the measured rows tighter, and less of the unmeasured error shows in them.",
            &["mvt.raising-eta"],
        ),
        finding(
            "β need not be found, and is not unique",
            "A row that is affine along e leaves β open. The integral mean of the Jacobian needs no β at all; least squares may stop short of it.",
            &["mvt.ex1.beta-unique", "mvt.beta-must-be-determined", "mvt.lsqnonlin-finds-beta"],
        ),
        finding(
            "With output injection, or in other coordinates, it converges with a proof",
            "With L (y - Cz) in the place of [G_m; 0](y - Cz), and one L and P for the vertices of the mean Jacobian, the observer of Example 2 converges from every internal error. \
             In Example 1 no constant gain can be proved, because x3 is hidden where x1 passes 0.",
            &[
                "mvt.repair.ex2",
                "mvt.repair.ex2-classical",
                "mvt.repair.ex2-printed",
                "mvt.repair.coordinates",
                "mvt.repair.ex1",
                "mvt.repair.ex1-proof",
            ],
        ),
    ]
}
