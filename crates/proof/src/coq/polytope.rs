//! `polytope-of-plants`, `polytope-of-jacobians` and `discrete-polytope-of-jacobians`.

use std::fmt::Write as _;

use super::bounds::{Data, LEFT, are_bounds};
use super::discrete::{contraction, falls};
use super::{Between, CoqError, Out, points, says, single};
use crate::certificate::{DiscreteJacobianPolytope, Fact, Vertex};
use crate::matrix::Matrix;
use crate::number::Number;

impl Out {
    fn vertices(&mut self, vertices: &[Vertex]) -> Result<(), CoqError> {
        for (k, Vertex { a, c }) in (1..).zip(vertices) {
            self.matrix(&format!("A_{k}"), &single(a, "A of a vertex")?, &format!("The state matrix of vertex {k}."));
            self.matrix(&format!("C_{k}"), &single(c, "C of a vertex")?, &format!("The output matrix of vertex {k}."));
        }
        let pairs: Vec<String> = (1..=vertices.len()).map(|k| format!("(A_{k}, C_{k})")).collect();
        let pairs = pairs.join("; ");
        _ = write!(self.numbers, "\n(** The vertices. *)\nDefinition vertices : list vertex := [{pairs}].\n");
        Ok(())
    }

    pub(super) fn polytope(
        &mut self,
        vertices: &[Vertex],
        [l, p]: [&Matrix<f64>; 2],
        rate: f64,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let Some((positive, decreases)) = facts.split_first() else { return Ok(()) };
        let (n, outputs) = l.shape();
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        let are_boxes = self.boxes_or_vertices(vertices)?;
        self.matrix("L", &points(l)?, "The gain of the observer.");
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        self.float("rate", rate, "The rate in the inequalities.")?;
        let least = |fact: &&Fact| fact.verdict.margin().unwrap_or(0.0);
        if let (true, Some(least)) = (all, decreases.iter().min_by(|x, y| least(x).total_cmp(&least(y)))) {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            self.decay(rate, least, between.upper)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        for ((k, fact), Vertex { a, c }) in (1..).zip(decreases).zip(vertices) {
            let suffix = format!("_{k}");
            if are_boxes {
                self.decrease_within(&Data { a, c, l, p }, rate, fact, claimed.get(k), &suffix)?;
            } else {
                self.decrease((n, outputs), fact, claimed.get(k), &suffix)?;
            }
        }
        if !all {
            return Ok(());
        }
        if are_boxes {
            self.hull_of_boxes(n, outputs, vertices.len());
            return Ok(());
        }
        self.lemma("decided", &format!("polytope_decays {n} {outputs} vertices L P decay lower upper overshoot"));
        let (says, count) = (says(n, ""), vertices.len());
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A(t) - L C(t))e, (A(t), C(t)) the sum of the vertices with any weights w(t)\n    \
             that are not negative and have the sum 1.",
            &format!(
                "forall (T : R) (e : R -> vector) (w : R -> nat -> R),\n  (forall t, convex {count} (w t)) ->\n  \
                 solution T {n} e (fun t => hull_error vertices L (w t) (e t)) ->\n  {says}"
            ),
            "exact (polytope_error_decays _ _ _ _ _ _ _ _ _ decided).",
        );
        Ok(())
    }

    /// The boxes, or where all data are numbers the vertices; which of both.
    fn boxes_or_vertices(&mut self, vertices: &[Vertex]) -> Result<bool, CoqError> {
        let are_boxes = are_bounds(vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.c]));
        if are_boxes {
            self.boxes(vertices);
        } else {
            self.vertices(vertices)?;
        }
        Ok(are_boxes)
    }

    fn boxes(&mut self, vertices: &[Vertex]) {
        for (k, Vertex { a, c }) in (1..).zip(vertices) {
            self.bounds(a, c, &format!("_{k}"));
        }
        let one = |k: usize| format!("Box A_low_{k} A_high_{k} C_low_{k} C_high_{k}");
        let boxes = (1..=vertices.len()).map(one).collect::<Vec<_>>().join(";\n  ");
        _ = write!(self.numbers, "\n(** The boxes. *)\nDefinition boxes : list box := [\n  {boxes}].\n");
    }

    /// The theorem about the hull of boxes.
    fn hull_of_boxes(&mut self, n: usize, outputs: usize, count: usize) {
        self.lemma("decided", &format!("boxes_decay {n} {outputs} boxes L P decay lower upper overshoot"));
        let says = says(n, "");
        self.theorem(
            "every_error",
            "Every differentiable e with e' = (A(t) - L C(t))e, (A(t), C(t)) the sum of a pair of each box with any weights\n    \
             w(t) that are not negative and have the sum 1.",
            &format!(
                "forall (T : R) (e : R -> vector) (w : R -> nat -> R) (A C : R -> nat -> matrix),\n  \
                 (forall t, convex {count} (w t)) ->\n  \
                 (forall t k, (k < {count})%nat -> in_box {n} {outputs} (nth k boxes no_box) (A t k) (C t k)) ->\n  \
                 solution T {n} e (fun t => mixed_error {n} {count} L (w t) (A t) (C t) (e t)) ->\n  {says}"
            ),
            "exact (boxes_error_decays _ _ _ _ _ _ _ _ _ decided).",
        );
    }

    pub(super) fn discrete_polytope(
        &mut self,
        theorem: &DiscreteJacobianPolytope,
        facts: &[Fact],
        claimed: &[Number],
    ) -> Result<(), CoqError> {
        let DiscreteJacobianPolytope { vertices, l, p, factor } = theorem;
        let Some((positive, blocks)) = facts.split_first() else { return Ok(()) };
        let (n, outputs) = l.shape();
        let are_boxes = self.boxes_or_vertices(vertices)?;
        self.matrix("L", &points(l)?, "The gain of the observer.");
        self.matrix("P", &points(p)?, "The matrix of V = e'Pe.");
        self.float("factor", *factor, "The factor of the inequalities.")?;
        let all = facts.iter().all(|fact| fact.verdict.is_proved());
        let least = |fact: &&Fact| fact.verdict.margin().unwrap_or(0.0);
        if let (true, Some(least)) = (all, blocks.iter().min_by(|x, y| least(x).total_cmp(&least(y)))) {
            let between = Between::of(p, positive)?;
            self.between(&between, "")?;
            // At (v, -Fv) the block is v'Pv - v'F'PFv, for the factor 1.
            let slower = |factor: f64| if are_boxes { 1.0 - (1.0 - factor) * LEFT } else { factor };
            let factor = if *factor < 1.0 { *factor } else { slower(contraction(least, 1.0, between.upper)) };
            self.contraction(factor, least)?;
        }
        self.positive(n, "P", positive, claimed.first())?;
        for ((k, fact), Vertex { a, c }) in (1..).zip(blocks).zip(vertices) {
            if are_boxes {
                self.schur_within(&Data { a, c, l, p }, *factor, fact, claimed.get(k), &format!("_{k}"))?;
            } else {
                self.schur((n, outputs), fact, claimed.get(k), k)?;
            }
        }
        if !all {
            return Ok(());
        }
        if are_boxes {
            self.hull_of_discrete_boxes(n, outputs, vertices.len());
            return Ok(());
        }
        self.lemma(
            "decided",
            &format!("polytope_contracts {n} {outputs} vertices L P contraction lower upper overshoot"),
        );
        let (says, count) = (falls(n), vertices.len());
        self.theorem(
            "every_error",
            "Every e with e(k+1) = (A(k) - L C(k))e(k), (A(k), C(k)) the sum of the vertices with any weights w(k) that are\n    \
             not negative and have the sum 1.",
            &format!(
                "forall (e : nat -> vector) (w : nat -> nat -> R),\n  (forall k, convex {count} (w k)) ->\n  \
                 recursion {n} e (fun k => hull_error vertices L (w k) (e k)) ->\n  {says}"
            ),
            "exact (polytope_error_contracts _ _ _ _ _ _ _ _ _ decided).",
        );
        Ok(())
    }

    /// The theorem about the hull of boxes in discrete time.
    fn hull_of_discrete_boxes(&mut self, n: usize, outputs: usize, count: usize) {
        self.lemma("decided", &format!("boxes_contract {n} {outputs} boxes L P contraction lower upper overshoot"));
        let says = falls(n);
        self.theorem(
            "every_error",
            "Every e with e(k+1) = (A(k) - L C(k))e(k), (A(k), C(k)) the sum of a pair of each box with any weights w(k) that\n    \
             are not negative and have the sum 1.",
            &format!(
                "forall (e : nat -> vector) (w : nat -> nat -> R) (A C : nat -> nat -> matrix),\n  \
                 (forall k, convex {count} (w k)) ->\n  \
                 (forall k j, (j < {count})%nat -> in_box {n} {outputs} (nth j boxes no_box) (A k j) (C k j)) ->\n  \
                 recursion {n} e (fun k => mixed_error {n} {count} L (w k) (A k) (C k) (e k)) ->\n  {says}"
            ),
            "exact (boxes_error_contracts _ _ _ _ _ _ _ _ _ decided).",
        );
    }

    /// `[factor^2 P, F'P; *, P] > 0` at a vertex, proved or refuted.
    fn schur(
        &mut self,
        (n, outputs): (usize, usize),
        fact: &Fact,
        claimed: Option<&Number>,
        k: usize,
    ) -> Result<(), CoqError> {
        let [margin, vector] = ["margin_F", "v_F"].map(|name| format!("{name}_{k}"));
        let flow = format!("let f := (A_{k} * v - L * (C_{k} * v))%vector in\n  ");
        let form = format!(
            "factor ^ 2 * quadratic {n} P v + inner {n} f (P * w)%vector + inner {n} w (P * f)%vector + quadratic {n} P w"
        );
        let squares = format!("square {n} v + square {n} w");
        let arguments = format!("{n} {outputs} A_{k} C_{k} L P factor");
        if fact.verdict.is_proved() {
            self.margin(&margin, fact, claimed)?;
            self.theorem(
                &format!("inequality_{k}"),
                &format!("The form of [factor^2 P, F'P; P F, P], F = A_{k} - L C_{k}, is at least the margin times |v|^2 + |w|^2."),
                &format!("0 < {margin} /\\ forall v w : vector, {flow}{margin} * ({squares})\n    <= {form}"),
                &format!("apply (schur_inequality {arguments} {margin}). vm_cast_no_check (eq_refl true)."),
            );
        } else if self.witness(&vector, fact)? {
            self.theorem(
                &format!("inequality_{k}_is_false"),
                &format!("The form of [factor^2 P, F'P; P F, P], F = A_{k} - L C_{k}, is not positive at some (v, w)."),
                &format!("exists v w : vector, 0 < {squares} /\\\n  {flow}{form} <= 0"),
                &format!("apply (no_schur_inequality {arguments} {vector}). vm_cast_no_check (eq_refl true)."),
            );
        }
        Ok(())
    }
}
