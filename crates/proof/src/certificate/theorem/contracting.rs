//! Coordinates in which the unmeasured states contract, so that an injection into the measured rows is enough.
//!
//! **Hypotheses.** `Q > 0`, and at every vertex J, with `T = [I 0; K I]` and `P = [I 0; 0 Q]`,
//! `He(Q(J_uu - K J_mu)) + 2 rate Q < 0` and `He(P(T^-1 J T - [g I 0; 0 0])) + 2 rate P < 0`, `He(X) = X + X'`.
//!
//! **Theorem.** For every J(t) in the convex hull of the vertices and every diagonal `G_m(t) >= g I`,
//! `V = |d_m|^2 + d_w'Q d_w` falls along `d' = (T^-1 J T - [G_m 0; 0 0])d` faster than `exp(-2 rate t)`.
//!
//! **Proof.** The second inequality is linear in J, so that it holds on the hull; the injection enters `V'` as
//! `-2 d_m'G_m d_m <= -2 g |d_m|^2`. The first inequality is its diagonal block of the unmeasured states, to which no
//! injection contributes.

use super::super::fields::Fields;
use super::super::members::Members;
use super::super::write::{Out, Written};
use super::{Fact, FileError, Statement, check_rate, counted, decay, rate_term};
use crate::error::ProofError;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::wording::exact;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct ContractionInCoordinates {
    /// The Jacobians J at the vertices, n x n, measured states first.
    pub vertices: Vec<Matrix<f64>>,
    /// K, (n - p) x p.
    pub k: Matrix<f64>,
    /// Q, of order n - p.
    pub q: Matrix<f64>,
    /// The injection g into the measured rows.
    pub injection: f64,
    /// The rate, 0 or more.
    pub rate: f64,
}

impl Statement for ContractionInCoordinates {
    const NAME: &'static str = "contracting-coordinates";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        check_rate(self.rate)?;
        if self.vertices.is_empty() {
            return Err(ProofError::Empty { what: "the list of vertices" });
        }
        let (unmeasured, measured) = self.k.shape();
        let n = measured + unmeasured;
        self.q.expect_shape("Q", (unmeasured, unmeasured))?;
        // [upper I, 0; lower K, corner].
        let blocks = |upper: f64, lower: f64, corner: &dyn Fn(usize, usize) -> f64| {
            Matrix::from_fn(n, n, |row, column| match (row < measured, column < measured) {
                (true, _) if row == column => upper,
                (true, _) => 0.0,
                (false, true) => lower * self.k[(row - measured, column)],
                (false, false) => corner(row - measured, column - measured),
            })
        };
        let one = |row: usize, column: usize| if row == column { 1.0 } else { 0.0 };
        let (there, back) = (blocks(1.0, 1.0, &one), blocks(1.0, -1.0, &one));
        let (p, g) = (blocks(1.0, 0.0, &|i, j| self.q[(i, j)]), blocks(self.injection, 0.0, &|_, _| 0.0));
        let names = names.matrix("K", &self.k).symmetric("Q", &self.q).number("rate", self.rate).symmetric("P", &p);
        let names = names.matrix("T", &there).matrix("T^-1", &back).matrix("[g I 0; 0 0]", &g);
        let mut facts = names.facts(["Q > 0"])?;
        let labels = [
            format!("He(Q(J_uu - K J_mu)){} < 0", rate_term(self.rate, "Q")),
            format!("He(P(T^-1 J T - [g I 0; 0 0])){} < 0", rate_term(self.rate, "P")),
        ];
        for (number, j) in self.vertices.iter().enumerate() {
            j.expect_shape("J", (n, n))?;
            let block = |row: usize, rows: usize| Matrix::from_fn(rows, unmeasured, |i, k| j[(row + i, measured + k)]);
            let (uu, mu) = (block(measured, unmeasured), block(0, measured));
            let names = names.clone().matrix("J", j).matrix("J_uu", &uu).matrix("J_mu", &mu);
            for label in &labels {
                facts.push(Fact::at_vertex(label, number, names.decide(label)?));
            }
        }
        Ok(facts)
    }

    fn words(&self) -> String {
        let (unmeasured, measured) = self.k.shape();
        format!(
            "For all matrices J(t) in the convex hull of the {} given, with {} and {}, in the coordinates (d_m, d_w) = T^-1 d with T = [I 0; K I], every solution of d' = (T^-1 J(t) T - [G_m 0; 0 0])d with a diagonal G_m(t) >= g I, g = {}, obeys: {}, from every d(0). That the mean Jacobians of a plant lie in this hull is a hypothesis, of which this certificate says nothing.",
            self.vertices.len(),
            counted(measured, "measured state"),
            counted(unmeasured, "unmeasured state"),
            exact(self.injection),
            decay("|d_m|^2 + d_w'Q d_w", "d", self.rate)
        )
    }
}

/// K, which stands behind the vertices, has their order.
impl Members for ContractionInCoordinates {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let k = file.object("coordinates", |coordinates| coordinates.take("K")?.any_matrix())?;
        let (unmeasured, measured) = k.shape();
        let n = unmeasured + measured;
        let vertices = file.take("vertices")?.some_of(|j| j.matrix((n, n)))?;
        let injection = file.object("observer", |observer| observer.take("injection")?.binary64())?;
        let (q, rate) = file.object("lyapunov", |lyapunov| {
            Ok((lyapunov.take("Q")?.symmetric(unmeasured)?, lyapunov.take("rate")?.rate()?))
        })?;
        Ok(Self { vertices, k, q, injection, rate })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        vec![
            ("vertices", self.vertices.out()),
            ("coordinates", Out::Object(vec![("K", self.k.out())])),
            ("observer", Out::Object(vec![("injection", self.injection.out())])),
            ("lyapunov", Out::Object(vec![("Q", self.q.out()), ("rate", self.rate.out())])),
        ]
    }
}
