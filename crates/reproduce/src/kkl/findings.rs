//! The errata: printed statements that are false, each with the claims that show it.

use crate::paper::Finding;

pub(super) fn findings() -> Vec<Finding> {
    [converter(), examples()].concat()
}

/// Section V.C.
fn converter() -> Vec<Finding> {
    vec![
        Finding {
            title: "Four of the six observers of Table I do not converge as printed",
            statement: "PEBO: M has -1/L3 without its filter and Y has G L3 y2/C4 inside its filter, where G y2/C4 has to stand. [KKL+PEB]O: ξ2 in Y for ξ1. \
                        I&IO: + γ1 u y2 for - γ1 u y2, and x̂2 = ξ2 + L3 γ2 y2 for the minus of its own ξ2'. HGO with linear error dynamics: r1 for r2, and rates of the plant that \
                        belong one equation higher. (The correction of ξ4 in the other HGO has the wrong sign too, which it survives.) Corrected, all converge.",
            claims: &[
                "kkl.cuk.pebo-as-printed",
                "kkl.cuk.kkl-peb-as-printed",
                "kkl.cuk.iandi-as-printed",
                "kkl.cuk.hgo-linear-as-printed",
            ],
        },
        Finding {
            title: "The KKLO of the converter is an I&IO",
            statement: "With g1 = 1/L1 and g2 = 0 the two are one observer, as R9 says that they are. That one is linear and the other is not cannot be why one of them is better under noise.",
            claims: &["kkl.cuk.kklo-is-iandi"],
        },
        Finding {
            title: "Which observer of the converter is best under noise depends on what is asked",
            statement: "Over the switching run the KKLO has the smallest error of i1 among the six, and ties in v4. Between the jumps of the set-point the linear high-gain observer has the \
                        smaller error of i1, and an exact high-gain observer, which is not in the paper, beats the KKLO everywhere. High gain is not what makes an observer noisy here: \
                        the error of the I&IO falls until its gain is some ten times the printed one.",
            claims: &["kkl.cuk.noise-ranking", "kkl.cuk.hgo-worst"],
        },
    ]
}

/// Propositions 4 to 7.
fn examples() -> Vec<Finding> {
    vec![
        Finding {
            title: "Proposition 5 leaves out the rate of the parameter",
            statement: "(18) makes β(y, χ) move as φ(x̂) does, whereas an observer whose parameter is still being estimated moves by dθ̂/dt besides. With (21) to (23) \
                        the error of the PEB part stays what it was at the start. With ρ = (0, dθ̂/dt) inside the term of the pseudo-inverse, and Q (a column, not a matrix) \
                        the right-hand side of the [KKL+PEB]O, the two observers are one; of (30) only KKLO ⊂ I&IO is proved as printed.",
            claims: &["kkl.prop5.as-printed", "kkl.prop5.repaired", "kkl.set-relation"],
        },
        Finding {
            title: "The plant of Proposition 6 has a KKLO",
            statement: "F3 is true of the constant Λ of Proposition 1. The KKLO of Table I has a Λ that depends on u, and with a Λ that depends on y and u \
                        the plant has one as well: in e^x3 it is linear.",
            claims: &["kkl.prop6.f3"],
        },
        Finding {
            title: "ψ(0) > 0 is not needed, and slows the estimate down",
            statement: "The proof of F4 names ψ(0) > 0 as what makes ψ not square integrable, which suffices. It follows from ξ2 being bounded already; from ψ(0) = 0 (and w(0) = y(0)) the \
                        regression is exact. What is needed and not said is that Θ̂ stays positive, and which u keeps the plant bounded.",
            claims: &["kkl.prop6.psi-zero", "kkl.prop6.theta-positive", "kkl.prop6.boundedness"],
        },
        Finding {
            title: "The error equation of Proposition 7 lacks a minus sign",
            statement: "θ̃' = -Γ ψ ψ' θ̃.",
            claims: &["kkl.prop7.error-equation"],
        },
    ]
}
