//! Data between bounds: inequalities that hold for all A and C between them, or matrices for which they are false.
//!
//! An inequality for `F = A - LC` is proved for all data at once. Where it is not, matrices between the bounds and a
//! vector are sought at which its form has the wrong sign: for a vector the form is linear in A and C, so that the
//! worst matrices have all entries at a bound; for these the worst vector is an eigenvector; and so on by turns. What
//! is found is decided exactly, and by Coq again.

use super::{CoqError, Out, margin};
use crate::certificate::{Fact, Theorem, Vertex};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::{Datum, Number};
use crate::verdict::Verdict;
use crate::witness::Witness;

/// Turns between the worst matrices and the worst vector.
const TURNS: usize = 8;

/// Steps towards the eigenvector of the largest eigenvalue.
const STEPS: usize = 300;

/// What is left of a margin of `[factor^2 P, F'P; P F, P]` in Coq, which adds up what deviations take with weights,
/// where the checker bounds it by a factorisation.
pub(super) const LEFT: f64 = 1.0 - 1.0 / 1024.0;

/// Whether data are more than one number.
pub(super) fn are_bounds<'a>(data: impl IntoIterator<Item = &'a Matrix<Datum>>) -> bool {
    data.into_iter().flat_map(Matrix::as_slice).any(|datum| !datum.is_point())
}

/// Whether A or C of the theorem are.
pub(super) fn has_bounds(theorem: &Theorem) -> bool {
    let of = |vertices: &[Vertex]| are_bounds(vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.c]));
    match theorem {
        Theorem::LinearConvergence(linear) => are_bounds([&linear.plant.a, &linear.plant.b, &linear.plant.c]),
        Theorem::PlantPolytope(plants) => of(&plants.vertices),
        Theorem::JacobianPolytope(jacobians) => of(&jacobians.vertices),
        Theorem::DiscreteJacobianPolytope(jacobians) => of(&jacobians.vertices),
        _ => false,
    }
}

/// The lower and the upper ends of data.
fn ends(datum: &Datum) -> [Number; 2] {
    match datum {
        Datum::Number(number) => [number.clone(), number.clone()],
        Datum::Between(low, high) => [low.clone(), high.clone()],
    }
}

/// What is assumed of A and C.
pub(super) fn between_bounds((n, outputs): (usize, usize), suffix: &str) -> String {
    format!("{} -> {} ->", within("A", (n, n), suffix), within("C", (outputs, n), suffix))
}

fn within(name: &str, (rows, columns): (usize, usize), suffix: &str) -> String {
    format!("within {rows} {columns} {name}_low{suffix} {name}_high{suffix} {name}")
}

/// An inequality that data enter by `F = A - LC` alone.
#[derive(Debug, Clone, Copy)]
pub(super) enum Inequality {
    /// `F'P + PF + 2 rate P < 0`.
    Lyapunov { rate: f64 },
    /// `[factor^2 P, F'P; P F, P] > 0`.
    Schur { factor: f64 },
}

/// The data of an inequality.
#[derive(Debug, Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) a: &'a Matrix<Datum>,
    pub(super) c: &'a Matrix<Datum>,
    pub(super) l: &'a Matrix<f64>,
    pub(super) p: &'a Matrix<f64>,
}

/// Matrices between the bounds, and a direction in which the form has the wrong sign.
struct Counterexample {
    a: Matrix<Number>,
    c: Matrix<Number>,
    direction: Direction,
}

fn times(m: &Matrix<f64>, v: &[f64]) -> Vec<f64> {
    (0..m.rows()).map(|i| m.row(i).iter().zip(v).map(|(x, y)| x * y).sum()).collect()
}

/// `x + c y`
fn plus(x: &[f64], c: f64, y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x + c * y).collect()
}

/// A vector without structure.
fn generic(order: usize) -> Vec<f64> {
    (1..=order).map(|k| (k as f64 * k as f64).sin()).collect()
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Data<'_> {
    /// The product of v and the matrix that should be negative definite.
    fn form(&self, inequality: Inequality, [a, c]: [&Matrix<f64>; 2], v: &[f64]) -> Vec<f64> {
        let (p, n) = (self.p, self.p.rows());
        let flow = |x: &[f64]| plus(&times(a, x), -1.0, &times(self.l, &times(c, x)));
        let adjoint = |x: &[f64]| {
            let injected = times(&c.transpose(), &times(&self.l.transpose(), x));
            plus(&times(&a.transpose(), x), -1.0, &injected)
        };
        match inequality {
            Inequality::Lyapunov { rate } => {
                let pv = times(p, v);
                plus(&plus(&adjoint(&pv), 1.0, &times(p, &flow(v))), 2.0 * rate, &pv)
            }
            Inequality::Schur { factor } => {
                let (x, y) = v.split_at(n);
                let py = times(p, y);
                let first = plus(&adjoint(&py), factor * factor, &times(p, x));
                let second = plus(&py, 1.0, &times(p, &flow(x)));
                first.into_iter().chain(second).map(|entry| -entry).collect()
            }
        }
    }

    /// For a vector, `(u, x)`: the form grows with `u'(A - LC)x`.
    fn sides(&self, inequality: Inequality, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match inequality {
            Inequality::Lyapunov { .. } => (times(self.p, v), v.to_vec()),
            Inequality::Schur { .. } => {
                let (x, y) = v.split_at(self.p.rows());
                (times(self.p, y).iter().map(|entry| -entry).collect(), x.to_vec())
            }
        }
    }

    /// The matrices between the bounds for which `u'(A - LC)x` is largest.
    fn worst(&self, u: &[f64], x: &[f64]) -> [Matrix<Number>; 2] {
        let chosen = |data: &Matrix<Datum>, u: &[f64], sign: f64| {
            Matrix::from_fn(data.rows(), data.cols(), |i, j| {
                let [low, high] = ends(&data[(i, j)]);
                if sign * u[i] * x[j] > 0.0 { high } else { low }
            })
        };
        let injected = times(&self.l.transpose(), u);
        [chosen(self.a, u, 1.0), chosen(self.c, &injected, -1.0)]
    }

    /// An approximate eigenvector of the largest eigenvalue, from v, and the eigenvalue over the norm of the matrix.
    fn eigenvector(&self, inequality: Inequality, [a, c]: [&Matrix<f64>; 2], v: &[f64]) -> (Vec<f64>, f64) {
        let order = v.len();
        let unit = |k: usize| (0..order).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..order).map(|k| self.form(inequality, [a, c], &unit(k))).collect();
        let matrix = Matrix::from_fn(order, order, |i, j| columns[j][i]);
        let size = length(matrix.as_slice()).max(f64::MIN_POSITIVE);
        // A little of every direction, where v is an eigenvector of another eigenvalue.
        let mut v = plus(v, 1e-3, &generic(order));
        let mut product = times(&matrix, &v);
        for _ in 0..STEPS {
            let next = plus(&product, size, &v);
            let norm = length(&next);
            if !(norm > 0.0 && norm.is_finite()) {
                break;
            }
            v = next.iter().map(|entry| entry / norm).collect();
            product = times(&matrix, &v);
        }
        let value = v.iter().zip(&product).map(|(x, y)| x * y).sum::<f64>() / size;
        (v, value)
    }

    fn decided(&self, inequality: Inequality, [a, c]: [&Matrix<Number>; 2]) -> Result<Verdict<Direction>, ProofError> {
        let names = Names::new().within("A", &a.map(Number::enclosure)).within("C", &c.map(Number::enclosure));
        let names = names.matrix("L", self.l).symmetric("P", self.p);
        match inequality {
            Inequality::Lyapunov { rate } => names.number("rate", rate).decide("(A - LC)'P + P(A - LC) + 2 rate P < 0"),
            Inequality::Schur { factor } => names.number("factor", factor).decide("[factor^2 P, (A - LC)'P; *, P] > 0"),
        }
    }

    fn counterexample(&self, inequality: Inequality) -> Result<Option<Counterexample>, ProofError> {
        let middle = |m: &Matrix<Number>| m.map(|x: &Number| x.enclosure().midpoint());
        let order = match inequality {
            Inequality::Lyapunov { .. } => self.p.rows(),
            Inequality::Schur { .. } => 2 * self.p.rows(),
        };
        let [a, c] = [self.a, self.c].map(|data| data.map(|datum: &Datum| datum.interval().midpoint()));
        let units = (0..order).map(|k| (0..order).map(|i| if i == k { 1.0 } else { 0.0 }).collect());
        let starts = [self.eigenvector(inequality, [&a, &c], &generic(order)).0, generic(order)];
        for mut v in starts.into_iter().chain(units) {
            for _ in 0..TURNS {
                let (u, x) = self.sides(inequality, &v);
                let [a, c] = self.worst(&u, &x);
                let (next, value) = self.eigenvector(inequality, [&middle(&a), &middle(&c)], &v);
                // Of the size of rounding, or positive.
                if value > -1e-9
                    && let Verdict::Refuted { witness: direction } = self.decided(inequality, [&a, &c])?
                {
                    return Ok(Some(Counterexample { a, c, direction }));
                }
                v = next;
            }
        }
        Ok(None)
    }
}

impl Out {
    /// The bounds of A and C.
    pub(super) fn bounds(&mut self, a: &Matrix<Datum>, c: &Matrix<Datum>, suffix: &str) {
        for (name, what, data) in [("A", "state", a), ("C", "output", c)] {
            let [low, high] = [0, 1].map(|end| data.map(|datum: &Datum| ends(datum)[end].clone()));
            self.matrix(&format!("{name}_low{suffix}"), &low, &format!("Lower bounds of the {what} matrix."));
            self.matrix(&format!("{name}_high{suffix}"), &high, &format!("Upper bounds of the {what} matrix."));
        }
    }

    /// Matrices and a vector for which an inequality is false, as `A_false`, `C_false` and this vector; none where none
    /// is found.
    fn false_within(
        &mut self,
        data: &Data<'_>,
        inequality: Inequality,
        fact: &Fact,
        vector: &str,
        suffix: &str,
    ) -> Result<bool, CoqError> {
        let Some(Counterexample { a, c, direction }) = data.counterexample(inequality)? else { return Ok(false) };
        let what = |name: &str| format!("A matrix {name} between the bounds for which {} is false.", fact.inequality);
        self.matrix(&format!("A_false{suffix}"), &a, &what("A"));
        self.matrix(&format!("C_false{suffix}"), &c, &what("C"));
        let refuted = Fact { verdict: Verdict::Refuted { witness: Witness::Direction(direction) }, ..fact.clone() };
        self.witness(vector, &refuted)
    }

    /// (12), for all A and C between the bounds with this suffix.
    pub(super) fn decrease_within(
        &mut self,
        data: &Data<'_>,
        rate: f64,
        fact: &Fact,
        claimed: Option<&Number>,
        suffix: &str,
    ) -> Result<(), CoqError> {
        let (outputs, n) = data.c.shape();
        let form = format!("inner {n} w (P * v)%vector + inner {n} v (P * w)%vector + 2 * rate * quadratic {n} P v");
        let flow = format!("let w := (apply {n} A v - L * apply {n} C v)%vector in");
        let arguments = format!("{n} {outputs} A_low{suffix} A_high{suffix} C_low{suffix} C_high{suffix} L P\n  rate");
        if fact.verdict.is_proved() {
            let margin = format!("margin_12{suffix}");
            self.margin(&margin, fact, claimed)?;
            self.theorem(
                &format!("inequality_12{suffix}"),
                "For all A and C between the bounds v'(F'P + PF + 2 rate P)v is at most minus the margin times |v|^2,\n    \
                 F = A - L C: (12).",
                &format!(
                    "0 < {margin} /\\ forall A C : matrix, {}\n  forall v : vector, {flow}\n  {form}\n    \
                     <= - {margin} * square {n} v",
                    between_bounds((n, outputs), suffix)
                ),
                &format!("refine (lyapunov_inequality_within {arguments} {margin} _). vm_cast_no_check (eq_refl true)."),
            );
            return Ok(());
        }
        let vector = format!("v_12{suffix}");
        if self.false_within(data, Inequality::Lyapunov { rate }, fact, &vector, suffix)? {
            self.theorem(
                &format!("inequality_12{suffix}_is_false"),
                "(12) is false for some A and C between the bounds: v'(F'P + PF + 2 rate P)v is not negative, F = A - L C.",
                &format!(
                    "{}\n  exists v : vector, 0 < square {n} v /\\\n    {flow}\n    0 <= {form}",
                    exist_between((n, outputs), suffix)
                ),
                &refutation("no_lyapunov_inequality_within", &arguments, suffix, &vector),
            );
        }
        Ok(())
    }

    /// `[factor^2 P, F'P; P F, P] > 0`, for all A and C between the bounds with this suffix.
    pub(super) fn schur_within(
        &mut self,
        data: &Data<'_>,
        factor: f64,
        fact: &Fact,
        claimed: Option<&Number>,
        suffix: &str,
    ) -> Result<(), CoqError> {
        let (outputs, n) = data.c.shape();
        let form = format!(
            "factor ^ 2 * quadratic {n} P v + inner {n} f (P * w)%vector + inner {n} w (P * f)%vector + quadratic {n} P w"
        );
        let (flow, squares) =
            (format!("let f := (apply {n} A v - L * apply {n} C v)%vector in"), format!("square {n} v + square {n} w"));
        let arguments =
            format!("{n} {outputs} A_low{suffix} A_high{suffix} C_low{suffix} C_high{suffix} L P\n  factor");
        if fact.verdict.is_proved() {
            let (margin, whole) = (format!("margin_F{suffix}"), margin(fact, claimed)?);
            let what = format!("The margin of {}, less a 1024th.", fact.inequality);
            self.float(&margin, whole.enclosure().lo() * LEFT, &what)?;
            self.theorem(
                &format!("inequality{suffix}"),
                "For all A and C between the bounds the form of [factor^2 P, F'P; P F, P], F = A - L C, is at least the margin\n    \
                 times |v|^2 + |w|^2.",
                &format!(
                    "0 < {margin} /\\ forall A C : matrix, {}\n  forall v w : vector, {flow}\n  \
                     {margin} * ({squares})\n    <= {form}",
                    between_bounds((n, outputs), suffix)
                ),
                &format!("refine (schur_inequality_within {arguments} {margin} _). vm_cast_no_check (eq_refl true)."),
            );
            return Ok(());
        }
        let vector = format!("v_F{suffix}");
        if self.false_within(data, Inequality::Schur { factor }, fact, &vector, suffix)? {
            self.theorem(
                &format!("inequality{suffix}_is_false"),
                "The form of [factor^2 P, F'P; P F, P], F = A - L C, is not positive at some (v, w) for some A and C between\n    \
                 the bounds.",
                &format!(
                    "{}\n  exists v w : vector, 0 < {squares} /\\\n    {flow}\n    {form} <= 0",
                    exist_between((n, outputs), suffix)
                ),
                &refutation("no_schur_inequality_within", &arguments, suffix, &vector),
            );
        }
        Ok(())
    }
}

/// That there are A and C between the bounds with this suffix.
fn exist_between((n, outputs): (usize, usize), suffix: &str) -> String {
    let [a, c] = [within("A", (n, n), suffix), within("C", (outputs, n), suffix)];
    format!("exists A C : matrix, {a} /\\ {c} /\\")
}

fn refutation(theorem: &str, arguments: &str, suffix: &str, vector: &str) -> String {
    format!(
        "refine ({theorem} {arguments}\n  A_false{suffix} C_false{suffix} {vector} _). vm_cast_no_check (eq_refl true)."
    )
}
