//! What the paper comes to: what holds, what is a slip of the pen, what is wrong, each with the claims that show it.

use crate::paper::{Finding, Kind};

pub(super) fn findings() -> Vec<Finding> {
    [holds(), slips(), wrong(), open(), beyond()].concat()
}

fn holds() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Holds, title, statement, claims };
    vec![
        finding(
            "Propositions 1 to 3 and R1, R5, R6, R8, on every instance tried",
            "The KKLO, the PEBO and their combination converge where the PDE is solved and the estimator is consistent.",
            &["kkl.prop1", "kkl.prop2", "kkl.prop3", "kkl.r1", "kkl.r5", "kkl.r5.imaginary", "kkl.r6", "kkl.r8"],
        ),
        finding(
            "Proposition 6: F3 and F4",
            "The plant has neither a KKLO nor a PEBO, by a separation of terms, and the [KKL+PEB]O finds x2 and x3.",
            &[
                "kkl.prop6.f3",
                "kkl.prop6.pde-residual",
                "kkl.prop6.x2-converges",
                "kkl.prop6.x3-converges",
                "kkl.prop6.psi-start",
            ],
        ),
        finding(
            "The extensions after Proposition 7",
            "More blocks, several rows of S, a monotonic map of x4: on the plants tried.",
            &["kkl.prop7.blocks", "kkl.prop7.rows", "kkl.prop7.monotonic"],
        ),
        finding(
            "Of Table I the KKLO as printed, and the other high-gain observer in spite of a sign",
            "The correction of ξ4 in the time-varying HGO has the wrong sign, which it survives.",
            &[
                "kkl.cuk.kklo-as-printed",
                "kkl.cuk.hgo-varying-as-printed",
                "kkl.cuk.hgo-varying-oscillates",
                "kkl.cuk.hgo-linear-at-jumps",
            ],
        ),
    ]
}

fn slips() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Slip, title, statement, claims };
    vec![
        finding(
            "Table I, PEBO: M = diag(F[w]/C2, -F[1]/L3), and G y2/C4 outside the L3 in Y2",
            "Printed are -1/L3 without its filter and G L3 y2/C4 inside the filter.",
            &["kkl.cuk.pebo-as-printed"],
        ),
        finding(
            "Table I, [KKL+PEB]O: ξ1 in Y, for the printed ξ2",
            "ξ2 is a voltage.",
            &["kkl.cuk.kkl-peb-as-printed"],
        ),
        finding(
            "Table I, I&IO: - γ1 u y2 and x̂2 = ξ2 - L3 γ2 y2, for the printed +",
            "Its own ξ2' has the minus.",
            &["kkl.cuk.iandi-as-printed"],
        ),
        finding(
            "Table I, linear HGO: r2 for r1, and no rates of the plant in ξ2', ξ4'",
            "They belong one equation higher.",
            &["kkl.cuk.hgo-linear-as-printed"],
        ),
        finding(
            "Proposition 7: θ̃' = -Γψψ'θ̃, for the printed +",
            "As printed no error could decrease.",
            &["kkl.prop7.error-equation"],
        ),
        finding(
            "A1: n_ξ ≥ n - p, for the n_ξ ≥ n before it",
            "The paper's own observers have n_ξ = n - p < n.",
            &["kkl.a1.dimension"],
        ),
        finding(
            "Proposition 4: Q is a column of length n_χ, for the printed matrix",
            "It is added to χ'.",
            &["kkl.prop4.shape-of-q"],
        ),
    ]
}

fn wrong() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Wrong, title, statement, claims };
    vec![
        finding(
            "Proposition 7: (42) is asked of b, and the estimator sees F[b]",
            "With b = sin t² every hypothesis holds, F[b] is square integrable, and x̂4 stays where ∫ψ² leaves it. With b' bounded, or (42) for F[b], the proposition holds.",
            &["kkl.prop7.gradient", "kkl.prop7.filtered"],
        ),
        finding(
            "Proposition 5 and R9 on the PEBO leave out the rate of the parameter",
            "(18) makes β(y, χ) move as φ(x̂) does, whereas an observer whose parameter is still being estimated moves by dθ̂/dt besides. With (21) to (23) the error of the PEB part stays what it was at the start. \
             With ρ = (0, dθ̂/dt) inside the term of the pseudo-inverse, and Q (a column) the right-hand side of the [KKL+PEB]O, the two observers are one; of (30) only KKLO ⊂ I&IO is left as printed, with the \
             condition below.",
            &["kkl.prop5.as-printed", "kkl.r9.pebo", "kkl.prop5.repaired", "kkl.set-relation"],
        ),
        finding(
            "R9: a KKLO is that I&IO only where φᴸ keeps the output",
            "Elsewhere (18) with β = χ is a copy of the plant that never sees y. The second statement of R9 has the condition, the first has not.",
            &["kkl.r9"],
        ),
        finding(
            "R10: a change of coordinates does not always make the outputs states",
            "y = x² shows two states alike. Where the outputs have full rank it does, locally.",
            &["kkl.r10"],
        ),
        finding(
            "The I&IO of the converter is linear, as the KKLO is",
            "With g1 = 1/L1 and g2 = 0 the two are one observer. That one is linear and the other is not cannot be why one of them is better under noise.",
            &["kkl.cuk.iandi-nonlinear", "kkl.cuk.kklo-is-iandi"],
        ),
    ]
}

fn open() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Open, title, statement, claims };
    vec![
        finding(
            "Proposition 4: from the region of attraction, which A5 does not mention",
            "Asymptotic stability is local: a plant with x2' = -x2 + x2³ has an I&IO that escapes.",
            &["kkl.prop4"],
        ),
        finding(
            "“Superior performance”: without noise, and not with it",
            "Without noise PEBO and [KKL+PEB]O are rid of their errors first. Under noise the KKLO and the I&IO have a fraction of its error of i1, which the paper says too.",
            &["kkl.cuk.superior", "kkl.cuk.noise-ranking", "kkl.cuk.hgo-worst"],
        ),
        finding(
            "The filters from y(0), or from 0 as printed",
            "From 0 the PEBO and the [KKL+PEB]O keep 4 mA and 11 mV at 0.19 s, which a figure cannot show.",
            &["kkl.cuk.pebo", "kkl.cuk.kkl-peb"],
        ),
        finding(
            "The law of u: x2 - x1 is i3 - i1, and v4 - i1 by the paper's x",
            "With the second v4 misses its set-point by 80 mV.",
            &["kkl.cuk.controller"],
        ),
        finding(
            "Convergence without (42), speeds, limits of speed, Υ_0: each by one reading",
            "DREM converges for some inputs that violate (42), and for others not. The speeds are comparable in units of the own largest error. A high-gain observer is ten times as fast with r1 = 0.005; what that costs under noise is in the row.",
            &["kkl.prop7.drem", "kkl.cuk.speeds", "kkl.cuk.speed-limited", "kkl.r7"],
        ),
        finding(
            "Proposition 6: Θ̂ > 0 and a bounded u are not said",
            "ln Θ̂ needs Θ̂ > 0, which an exact regression keeps and a transient need not; with u = 0 the plant is not bounded.",
            &["kkl.prop6.theta-positive", "kkl.prop6.boundedness"],
        ),
    ]
}

fn beyond() -> Vec<Finding> {
    let finding = |title, statement, claims| Finding { kind: Kind::Beyond, title, statement, claims };
    vec![
        finding(
            "With a Λ that depends on y and u the plant of Proposition 6 has a KKLO",
            "In e^x3 it is linear. The KKLO of Table I has a Λ that depends on u.",
            &["kkl.prop6.kklo-varying"],
        ),
        finding(
            "ψ(0) = 0 will do, and is faster",
            "From ψ(0) = 0 and w(0) = y(0) the regression is exact.",
            &["kkl.prop6.psi-zero"],
        ),
        finding(
            "φ(x, u) gives the KKLO of the converter a pole of choice; the [KKL+PEB]O works in the loop",
            "From the paper's outlook.",
            &["kkl.phi-of-the-input", "kkl.cuk.output-feedback"],
        ),
    ]
}
