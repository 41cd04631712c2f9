//! A bound of the error under bounded disturbances and measurement noise, of the linear observer in discrete time.
//!
//! **Hypotheses.** For the plant `x+ = Ax + Bu + Ew`, `y = Cx + Dw` with `|w_i| <= W_i`, and for the observer with the
//! gain L as stored: `0 < factor < 1`, `P > 0`; with the multipliers lambda at every vertex (A, E)
//! ```text
//! [ factor^2 P    0               F'P ]
//! [ 0             diag(lambda)    G'P ] > 0,     F = A - LC,  G = E - LD;
//! [ P F           P G             P   ]
//! ```
//! `(1 - factor^2) level` is at least `sum lambda_i W_i^2`; `limsup_i^2 P > level 1_i 1_i'`.
//!
//! **Theorem.** `V = e'Pe` obeys `V(k) <= factor^(2k) V(0) + level` for every e(0) and every such w, and `limsup |e_i|
//! <= limsup_i`.
//!
//! **Proof.** The inequality is linear in (A, E), so that it holds on the convex hull of the vertices. There, by the
//! Schur complement, `V(Fe + Gw) <= factor^2 V(e) + sum lambda_i w_i^2`, at most `factor^2 V(e) + (1 - factor^2)
//! level`: the part of V above the level falls by the factor `factor^2`. `e_i^2 <= (P^-1)_ii V`, and `(P^-1)_ii level`
//! is at most `limsup_i^2`.

use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::input_to_state::Bounds;
use super::polytope::at_vertices;
use super::{DisturbedPlant, Fact, Names, Statement, counted, enclosed};
use crate::definite::Sense;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::ring::Ring;
use crate::statement::{Expression, number};
use crate::wording::at_most;

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteInputToStateStability {
    /// The plant, or the vertices of a polytope of plants: pairs of the same shapes.
    pub vertices: Vec<DisturbedPlant>,
    /// The output matrix, p x n.
    pub c: Matrix<f64>,
    /// How the disturbances enter the outputs, p x m.
    pub d: Matrix<Datum>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The factor by which `sqrt V` falls at each step without disturbances, above 0 and below 1.
    pub factor: f64,
    /// The multipliers of the disturbances.
    pub lambda: Vec<f64>,
    /// The bounds of the disturbances, 0 or more.
    pub disturbances: Vec<f64>,
    /// The bound of V in the limit, positive.
    pub level: f64,
    /// The bounds of the components of the error in the limit, positive.
    pub limsup: Vec<f64>,
}

const POSITIVE: &str = "a level and the bound of an error are positive";

fn is_factor(factor: f64) -> bool {
    factor > 0.0 && factor < 1.0
}

impl DiscreteInputToStateStability {
    fn bounds(&self) -> Bounds<'_> {
        let Self { lambda, disturbances, level, limsup, .. } = self;
        Bounds { lambda, disturbances, level: *level, limsup }
    }
}

/// `(1 - factor^2) level - sum lambda_i W_i^2`, 1 x 1.
struct Level<'a>(&'a DiscreteInputToStateStability);

impl Expression for Level<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let number = |x: f64| number::<R>(x, "the level");
        let factor = number(self.0.factor)?;
        let reached = number(1.0)?.sub(&factor.mul(&factor)).mul(&number(self.0.level)?);
        let spent = self.0.bounds().weighted(&self.0.lambda)?;
        Matrix::from_row_major(1, 1, vec![reached.sub(&spent)])
    }
}

impl Statement for DiscreteInputToStateStability {
    const NAME: &'static str = "discrete-input-to-state-stability";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        if !is_factor(self.factor) {
            return Err(ProofError::Sign {
                what: "a factor, which should be above 0 and below 1,",
                value: self.factor,
            });
        }
        self.d.expect_shape("D", (self.c.rows(), self.disturbances.len()))?;
        self.bounds().check(self.p.rows())?;
        let falls = "[factor^2 P, 0, (A - LC)'P; *, diag(lambda), (E - LD)'P; *, *, P] > 0";
        let mut facts = at_vertices(self, &names, "P > 0", &self.vertices, &[falls], |names| names)?;
        let level = Level(self).decide(Sense::PositiveSemidefinite)?;
        facts.push(Fact::new("sum lambda_i w_i^2 <= (1 - factor^2) level", level));
        facts.extend(self.bounds().components(&names.of(self), "P")?);
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let uncertain = if self.vertices.len() > 1 || matches!(reading.plant, Represented::Uncertain) {
            ", for every deviation of A and while the states keep theirs"
        } else {
            ""
        };
        Some(format!(
            "Under all noise and disturbances within `bounds`{uncertain}, the error in the end is at most {}, approached like {}^k.",
            reading.useful_bounds(&self.limsup, 4),
            at_most(self.factor, 4)
        ))
    }

    fn words(&self) -> String {
        let (n, m, p) = (self.p.rows(), self.disturbances.len(), self.c.rows());
        let sizes = format!("{}, {} and {}", counted(n, "state"), counted(m, "disturbance"), counted(p, "output"));
        let (plant, a, e) = match self.vertices.len() {
            1 => {
                let plant = format!("the discrete-time plant x+ = Ax + Bu + Ew, y = Cx + Dw with {sizes}, any B and u");
                (plant, "A", "E")
            }
            count => (
                format!(
                    "every discrete-time plant x+ = A(k)x + Bu + E(k)w, y = Cx + Dw with {sizes}, any B and u, whose pair (A(k), E(k)) lies in the convex hull of the {count} pairs (A_j, E_j) at every step k"
                ),
                "A(k)",
                "E(k)",
            ),
        };
        format!(
            "For {plant}, all disturbances w with {}, and the observer xhat+ = {a} xhat + Bu + L r, r = y - C xhat, with the gain exactly as stored, the error e = x - xhat obeys e+ = ({a} - LC)e + ({e} - LD)w; V = e'Pe satisfies V(k) <= factor^(2k) V(0) + level with factor = {} and level = {}, from every e(0); and {}.{}",
            self.bounds().presumed(),
            at_most(self.factor, 4),
            at_most(self.level, 4),
            self.bounds().concluded(),
            enclosed(self.vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.e]).chain([&self.d]), ""),
        )
    }
}

members! { DiscreteInputToStateStability {
    "plant" {
        vertices = "vertices".by(DisturbedPlant::read_list);
        c = "C".matrix_with_columns(DisturbedPlant::sizes(&vertices).0);
        d = "D".data((c.rows(), DisturbedPlant::sizes(&vertices).1));
    }
    "observer" { l = "L".matrix((c.cols(), c.rows())); }
    "lyapunov" {
        p = "P".symmetric(c.cols());
        factor = "factor".number(is_factor, "a factor is above 0 and below 1");
        lambda = "lambda".numbers(d.cols());
    }
    "bounds" {
        disturbances = "w".bounds(d.cols());
        level = "level".positive(POSITIVE);
        limsup = "limsup".list(c.cols(), |bound| bound.positive(POSITIVE));
    }
} }
