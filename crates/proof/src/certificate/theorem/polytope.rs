//! One gain and one P for a convex hull of matrices: of linear plants, or of the Jacobians of a nonlinear one.
//!
//! **Hypotheses.** `P > 0` and `(A_k - L C_k)'P + P(A_k - L C_k) + 2 rate P < 0` at every vertex k, of which there is
//! at least one.
//!
//! **Theorem.** `V = e'Pe` falls faster than `exp(-2 rate t)` along `e' = (A(t) - L C(t))e` for every pair (A(t), C(t))
//! in the convex hull of the vertices, fixed or varying in time.
//!
//! **Proof.** The inequality is linear in (A, C), so that it holds on the hull.
//!
//! For a polytope of plants (Theorem 4 of the cubic paper) this e is the error of an observer that uses the same A and
//! C as the plant; one that uses a nominal A has the forcing `(A(t) - A)x` in addition, which is not covered. For `x' =
//! f(t, x, u)`, `y = h(t, x)` and the copy with the gain L, `e' = (Fbar - L Hbar)e` with the mean Jacobians over the
//! segment from xhat to x. *That* they lie in the hull must be shown separately, as `design::enclosure` does: a
//! certificate is about matrices only.

use super::super::fields::Field;
use super::super::members::members;
use super::super::sentence::{Reading, Represented, decay as decay_of, envelope};
use super::super::write::Written;
use super::{Fact, FileError, Statement, are_points, bounded, check_rate, counted, data, decay, rate_term};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::wording::capital;

/// A corner of the hull: one pair, or a box of pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Vertex {
    /// A, n x n.
    pub a: Matrix<Datum>,
    /// C, p x n.
    pub c: Matrix<Datum>,
}

impl Vertex {
    /// One pair of matrices.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`].
    pub fn exactly(a: &Matrix<f64>, c: &Matrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { a: data(a, "A")?, c: data(c, "C")? })
    }

    /// A box of pairs.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`] for a bound that is infinite.
    pub fn within(a: &Matrix<Interval>, c: &Matrix<Interval>) -> Result<Self, ProofError> {
        Ok(Self { a: bounded(a, "A")?, c: bounded(c, "C")? })
    }
}

members! { Vertex { {
    a = "A".square_data();
    c = "C".data_with_columns(a.rows());
} } }

impl Vertex {
    pub(super) fn read_list(list: &Field<'_>) -> Result<Vec<Self>, FileError> {
        let vertices: Vec<Self> = list.some_of(Field::part)?;
        for (item, Self { a, c }) in list.items()?.iter().zip(&vertices) {
            item.member("A")?.same_shape(&vertices[0].a, a)?;
            item.member("C")?.same_shape(&vertices[0].c, c)?;
        }
        Ok(vertices)
    }

    /// `n x p`: the shape of the gain.
    pub(super) fn gain(vertices: &[Self]) -> (usize, usize) {
        vertices.first().map_or((0, 0), |first| (first.a.rows(), first.c.rows()))
    }
}

/// The first label, and the others at each vertex, with the names that `more` adds.
pub(super) fn at_vertices<'a, V: Written>(
    theorem: &'a impl Written,
    names: &Names<'a>,
    positive: &str,
    vertices: &'a [V],
    labels: &[&str],
    more: impl Fn(Names<'a>) -> Names<'a>,
) -> Result<Vec<Fact>, ProofError> {
    if vertices.is_empty() {
        return Err(ProofError::Empty { what: "the list of vertices" });
    }
    let mut facts = more(names.clone().of(theorem)).facts([positive])?;
    for (k, vertex) in vertices.iter().enumerate() {
        // Where shapes do not fit, the vertex is right.
        let names = more(names.clone().of(vertex).of(theorem));
        for label in labels {
            facts.push(Fact::at_vertex(label, k, names.decide(label)?));
        }
    }
    Ok(facts)
}

pub(super) fn hull(vertices: &[Vertex]) -> String {
    let (n, p) = Vertex::gain(vertices);
    let what = if are_points(vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.c])) {
        if vertices.len() == 1 { "pair (A, C)" } else { "pairs (A_k, C_k)" }
    } else if vertices.len() == 1 {
        "box of pairs (A, C)"
    } else {
        "boxes of pairs (A_k, C_k)"
    };
    format!(
        "the convex hull of the {} {what} with {} and {}",
        vertices.len(),
        counted(n, "state"),
        counted(p, "output")
    )
}

macro_rules! polytope {
    ($(#[$doc:meta])* $name:ident, $file:literal, $words:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            /// The corners, pairs of the same shapes.
            pub vertices: Vec<Vertex>,
            /// The gain L, n x p, as stored.
            pub l: Matrix<f64>,
            /// P, n x n.
            pub p: Matrix<f64>,
            /// The rate, 0 or more.
            pub rate: f64,
        }

        impl Statement for $name {
            const NAME: &'static str = $file;

            fn sentence(&self, reading: &Reading<'_>, margin: f64) -> Option<String> {
                let Represented::Jacobians { hypothesis, estimate, .. } = reading.plant else { return None };
                let envelope = envelope(&self.p, estimate, "t")?;
                let decays = match decay_of(self.rate, &self.p, margin) {
                    None => " and the error tends to 0".to_owned(),
                    Some(decay) => format!(" {decay}"),
                };
                Some(format!("{}, {envelope}{decays}.", capital(hypothesis)))
            }

            fn words(&self) -> String {
                let words: fn(&str, &str) -> String = $words;
                words(&hull(&self.vertices), &decay("e'Pe", "e", self.rate))
            }

            fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
                check_rate(self.rate)?;
                let decrease = format!("(A - LC)'P + P(A - LC){} < 0", rate_term(self.rate, "P"));
                at_vertices(self, &names, "P > 0", &self.vertices, &[&decrease], |names| names)
            }
        }

        members! { $name {
            { vertices = "vertices".by(Vertex::read_list); }
            "observer" { l = "L".matrix(Vertex::gain(&vertices)); }
            "lyapunov" { p = "P".symmetric(l.rows()); rate = "rate".rate(); }
        } }
    };
}

polytope! {
    /// One gain for a polytope of linear plants; the head of the file has statement and proof.
        PlantPolytope, "polytope-of-plants", |hull, decrease| format!(
        "For every plant x' = A(t)x + Bu, y = C(t)x whose pair (A(t), C(t)) lies in {hull} at all times, and every solution of e' = (A(t) - L C(t))e, {decrease}. This e is the error of the observer with the same A(t) and C(t) and the gain L; the forcing (A(t) - A)x of an observer that runs another A is not covered."
    )
}

polytope! {
    /// One gain for a polytope of Jacobians; the head of the file has statement and proof.
        JacobianPolytope, "polytope-of-jacobians", |hull, decrease| format!(
        "For all matrices (A(t), C(t)) in {hull}, and every solution of e' = (A(t) - L C(t))e, {decrease}. Hence for a plant x' = f(t, x, u), y = h(t, x) and the observer xhat' = f(t, xhat, u) + L(y - h(t, xhat)), as long as the mean Jacobians of f and h between xhat and x lie in this hull: that they do is a hypothesis, of which this certificate says nothing."
    )
}
