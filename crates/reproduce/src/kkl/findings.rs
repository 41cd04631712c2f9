//! The errata: what does not hold as printed, each with the claims that show it.

use crate::paper::Finding;

pub(super) fn findings() -> Vec<Finding> {
    [converter(), examples()].concat()
}

/// Section V.C.
fn converter() -> Vec<Finding> {
    Vec::new()
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
            statement: "The proof of F4 takes ψ(0) > 0 for the reason why ψ is not square integrable. The reason is that ξ2 is bounded; from ψ(0) = 0 (and w(0) = y(0)) the \
                        regression is exact. What is needed and not said is that Θ̂ stays positive, and which u keeps the plant bounded.",
            claims: &["kkl.prop6.psi-start", "kkl.prop6.theta-positive", "kkl.prop6.boundedness"],
        },
        Finding {
            title: "The error equation of Proposition 7 lacks a minus sign",
            statement: "θ̃' = -Γ ψ ψ' θ̃.",
            claims: &["kkl.prop7.error-equation"],
        },
    ]
}
