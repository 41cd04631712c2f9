//! A bound of the error under bounded disturbances and measurement noise, of the linear and of the cubic observer.
//!
//! Plant `x' = A x + B u + E w`, `y = C x + D w`; w contains the disturbances and the measurement noise,
//! `|w_i| <= W_i`. Observer `xhat' = A xhat + B u + L r - (r'theta r) N r`, `r = y - C xhat` (the sign of N is that of
//! the error equation below). With `F = A - LC`, `G = E - LD`, `q = r'theta r`, the error `e = x - xhat` obeys
//! ```text
//! e' = F e + G w + q N r,    r = C e + D w.
//! ```
//! **Hypotheses.** `P > 0`, `P N = -C'S`, and numbers `lambda`, `mu` (one for each w_i), `kappa >= 0`, a positive rate
//! and a positive level U satisfy, at every vertex (A, E) of a polytope,
//! ```text
//! [F'P + PF + 2 rate P, PG; *, -diag(lambda)] < 0,                                                        (linear)
//! theta >= 0,    theta <= kappa (S + S')/2,    [diag(mu), D'S; *, (S + S')/2] >= 0,                        (cubic)
//! 2 rate U >= beta = sum lambda_i W_i^2 + 27/128 kappa (sum mu_i W_i^2)^2,    limsup_i^2 P > U 1_i 1_i'.
//! ```
//! **Theorem.** `V = e'Pe` obeys `V(t) <= exp(-2 rate t) V(0) + U` for every e(0) and every such w, and `limsup
//! |e_i| <= limsup_i`.
//!
//! **Proof.** The linear part adds at most `-2 rate V + sum lambda_i w_i^2` to `V'`. The cubic part adds `2 q e'P N r =
//! -2 q (r - Dw)'S r = -2 q a^2 + 2 q (Dw)'S r` with `a^2 = r'Sr`. The last block inequality is the Cauchy-Schwarz
//! inequality `|w'D'S r| <= s a` with `s^2 = sum mu_i w_i^2`, so that the cubic part is at most `2 q a (s - a)`:
//! negative where a > s, else at most `2 kappa a^3 (s - a) <= 27/128 kappa s^4`, attained at `a = 3s/4`. Hence `V' <=
//! -2 rate V + beta`, and `limsup_i^2 >= U (P^-1)_ii` (1_i is the i-th unit vector). The linear inequality is affine in
//! (A, E): proved at the vertices it holds on the convex hull, also for time-varying A and E.
//!
//! A stored N is a rounding of `-P^-1 C'S`. The matrix `P~ = C'XC + (I - T)(P - C'XC)(I - T)` in the head of
//! `statement/deployed_cubic.rs` has `P~ N = -C'S~` with `S~ = -X C N` **exactly**: all inequalities are decided for
//! P~, which is enclosed, and S~. Without a cubic term P~ is P.

use super::super::fields::{Field, LARGEST_ORDER};
use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::polytope::at_vertices;
use super::{Fact, FileError, Statement, bounded, counted, data, enclosed};
use crate::definite::Sense;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::label::Names;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::ring::Ring;
use crate::statement::{Expression, number, structured_for};
use crate::wording::{at_least, at_most, if_at_most};

/// State and disturbance matrix of a plant `x' = Ax + Bu + Ew`, or a box of such pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct DisturbedPlant {
    /// A, n x n.
    pub a: Matrix<Datum>,
    /// E, n x m.
    pub e: Matrix<Datum>,
}

impl DisturbedPlant {
    /// One pair of matrices.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`].
    pub fn exactly(a: &Matrix<f64>, e: &Matrix<f64>) -> Result<Self, ProofError> {
        Ok(Self { a: data(a, "A")?, e: data(e, "E")? })
    }

    /// A box of pairs.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`] for a bound that is infinite.
    pub fn within(a: &Matrix<Interval>, e: &Matrix<Interval>) -> Result<Self, ProofError> {
        Ok(Self { a: bounded(a, "A")?, e: bounded(e, "E")? })
    }
}

/// A cubic term with the constants of its bound.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicTerm {
    /// N, n x p, as stored, of full column rank.
    pub n: Matrix<f64>,
    /// theta, p x p, symmetric.
    pub theta: Matrix<f64>,
    /// X of P~, p x p, symmetric.
    pub x: Matrix<f64>,
    /// kappa >= 0.
    pub kappa: f64,
    /// mu, one number for each disturbance.
    pub mu: Vec<f64>,
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct InputToStateStability {
    /// The plant, or the vertices of a polytope of plants: pairs of the same shapes.
    pub vertices: Vec<DisturbedPlant>,
    /// The output matrix, p x n.
    pub c: Matrix<f64>,
    /// How the disturbances enter the outputs, p x m.
    pub d: Matrix<Datum>,
    /// The linear gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The cubic term; none for the linear observer.
    pub cubic: Option<CubicTerm>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The rate, positive.
    pub rate: f64,
    /// The multipliers of the disturbances.
    pub lambda: Vec<f64>,
    /// The bounds of the disturbances, 0 or more.
    pub disturbances: Vec<f64>,
    /// The bound of V in the limit, positive.
    pub level: f64,
    /// The bounds of the components of the error in the limit, positive.
    pub limsup: Vec<f64>,
}

const POSITIVE: &str = "a rate, a level and the bound of an error are positive";

/// The numbers of both theorems, in continuous and in discrete time.
pub(super) struct Bounds<'a> {
    /// The multipliers lambda of the disturbances.
    pub(super) lambda: &'a [f64],
    /// The bounds W of the disturbances.
    pub(super) disturbances: &'a [f64],
    /// The bound of V in the limit.
    pub(super) level: f64,
    /// The bounds of the components of the error in the limit.
    pub(super) limsup: &'a [f64],
}

impl Bounds<'_> {
    pub(super) fn check(&self, order: usize) -> Result<(), ProofError> {
        positive("the level, which should be positive,", self.level)?;
        for bound in self.limsup {
            positive("a bound of the error, which should be positive,", *bound)?;
        }
        for bound in self.disturbances {
            not_negative("the bound of a disturbance, which should be 0 or more,", *bound)?;
        }
        has_length("lambda", self.lambda, self.disturbances.len())?;
        has_length("the bounds", self.limsup, order)
    }

    /// `sum weights_i W_i^2`.
    pub(super) fn weighted<R: Ring>(&self, weights: &[f64]) -> Result<R, ProofError> {
        let mut sum = R::zero();
        for (weight, w) in weights.iter().zip(self.disturbances) {
            let w = number::<R>(*w, "the level")?;
            sum = sum.add(&number::<R>(*weight, "the level")?.mul(&w.mul(&w)));
        }
        Ok(sum)
    }

    /// `limsup_i^2 P > level 1_i 1_i'` for each i, P by its name among the names.
    pub(super) fn components(&self, names: &Names<'_>, p: &str) -> Result<Vec<Fact>, ProofError> {
        let order = self.limsup.len();
        let component = |(i, &limsup): (usize, &f64)| {
            let unit =
                Matrix::from_fn(order, order, |row, column| if (row, column) == (i, i) { self.level } else { 0.0 });
            let names = names.clone().number("b", limsup).matrix("U", &unit);
            let verdict = names.decide(&format!("b^2 {p} - U > 0"))?;
            Ok(Fact::new(format!("limsup |e_{}| <= limsup[{i}]", i + 1), verdict))
        };
        self.limsup.iter().enumerate().map(component).collect()
    }

    /// `|w_1| <= 0.1, |w_2| <= 2`: bounds that are presumed, rounded down.
    pub(super) fn presumed(&self) -> String {
        let bounds = self.disturbances.iter().enumerate();
        bounds.map(|(i, bound)| format!("|w_{}| <= {}", i + 1, if_at_most(*bound, 6))).collect::<Vec<_>>().join(", ")
    }

    /// `limsup |e_1| <= 0.1`: bounds that are concluded, rounded up.
    pub(super) fn concluded(&self) -> String {
        let limits = self.limsup.iter().enumerate();
        let limits = limits.map(|(i, bound)| format!("limsup |e_{}| <= {}", i + 1, at_most(*bound, 4)));
        limits.collect::<Vec<_>>().join(", ")
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), ProofError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ProofError::Sign { what, value }) }
}

fn not_negative(what: &'static str, value: f64) -> Result<(), ProofError> {
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(ProofError::Sign { what, value }) }
}

fn has_length(what: &'static str, list: &[f64], expected: usize) -> Result<(), ProofError> {
    if list.len() == expected {
        return Ok(());
    }
    Err(ProofError::DimensionMismatch { what, expected: (expected, 1), found: (list.len(), 1) })
}

impl InputToStateStability {
    fn check(&self) -> Result<(), ProofError> {
        positive("the rate, which should be positive,", self.rate)?;
        if let Some(term) = &self.cubic {
            not_negative("kappa, which should be 0 or more,", term.kappa)?;
            has_length("mu", &term.mu, self.disturbances.len())?;
        }
        self.d.expect_shape("D", (self.c.rows(), self.disturbances.len()))?;
        self.bounds().check(self.p.rows())
    }

    fn bounds(&self) -> Bounds<'_> {
        let Self { lambda, disturbances, level, limsup, .. } = self;
        Bounds { lambda, disturbances, level: *level, limsup }
    }

    /// The name of the Lyapunov matrix: P itself, or the matrix near it for which the stored N is exact.
    fn metric(&self) -> &'static str {
        if self.cubic.is_some() { "P~" } else { "P" }
    }

    fn entries(&self) -> impl Iterator<Item = &Matrix<Datum>> {
        self.vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.e]).chain([&self.d])
    }
}

/// `256 rate level - 128 sum lambda_i W_i^2 - 27 kappa (sum mu_i W_i^2)^2`, 1 x 1.
struct Level<'a>(&'a InputToStateStability);

impl Expression for Level<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        let InputToStateStability { lambda, cubic, rate, level, .. } = self.0;
        let (bounds, number) = (self.0.bounds(), |x: f64| number::<R>(x, "the level"));
        let reached = number(256.0)?.mul(&number(*rate)?.mul(&number(*level)?));
        let mut spent = number(128.0)?.mul(&bounds.weighted(lambda)?);
        if let Some(term) = cubic {
            let square = bounds.weighted::<R>(&term.mu)?;
            spent = spent.add(&number(27.0)?.mul(&number(term.kappa)?.mul(&square.mul(&square))));
        }
        Matrix::from_row_major(1, 1, vec![reached.sub(&spent)])
    }
}

impl Statement for InputToStateStability {
    const NAME: &'static str = "input-to-state-stability";

    fn facts(&self, names: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let p = self.metric();
        let metric = match &self.cubic {
            Some(term) => structured_for(&self.p, &self.c, &term.x, &term.n)?,
            None => None,
        };
        let decrease = format!("[(A - LC)'{p} + {p}(A - LC) + 2 rate {p}, {p}(E - LD); *, -diag(lambda)] < 0");
        let mut facts = at_vertices(self, &names, &format!("{p} > 0"), &self.vertices, &[&decrease], |names| {
            if self.cubic.is_some() { names.enclosed(p, metric.as_ref(), true) } else { names }
        })?;
        let mut names = names.of(self);
        let mut spent = "sum lambda_i w_i^2".to_owned();
        if self.cubic.is_some() {
            names = names.enclosed(p, metric.as_ref(), true).define("S~", "-XCN")?;
            facts.extend(names.facts([
                "theta >= 0",
                "kappa (S~ + S~') - 2 theta >= 0",
                "[2 diag(mu), 2 D'S~; *, S~ + S~'] >= 0",
            ])?);
            spent.push_str(" + 27/128 kappa (sum mu_i w_i^2)^2");
        }
        facts.push(Fact::new(format!("{spent} <= 2 rate level"), Level(self).decide(Sense::PositiveSemidefinite)?));
        facts.extend(self.bounds().components(&names, p)?);
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let uncertain = if self.vertices.len() > 1 || matches!(reading.plant, Represented::Uncertain) {
            ", for every deviation of A and while the states keep theirs"
        } else {
            ""
        };
        Some(format!(
            "Under all noise and disturbances within `bounds`{uncertain}, the error in the end is at most {}, approached like exp(-{} t).",
            reading.useful_bounds(&self.limsup, 4),
            at_least(self.rate, 4)
        ))
    }

    fn words(&self) -> String {
        let (n, m, p) = (self.p.rows(), self.disturbances.len(), self.c.rows());
        let sizes = format!("{}, {} and {}", counted(n, "state"), counted(m, "disturbance"), counted(p, "output"));
        let (plant, a) = match self.vertices.len() {
            1 => (format!("the plant x' = Ax + Bu + Ew, y = Cx + Dw with {sizes}, any B and u"), "A"),
            count => (
                format!(
                    "every plant x' = A(t)x + Bu + E(t)w, y = Cx + Dw with {sizes}, any B and u, whose pair (A(t), E(t)) lies in the convex hull of the {count} pairs (A_k, E_k) at all times"
                ),
                "A(t)",
            ),
        };
        let (term, flow, metric) = if self.cubic.is_some() {
            (
                " - (r'theta r) N r",
                " + (r'theta r) N r",
                ", P~ = C'XC + (I - T)(P - C'XC)(I - T) with the orthogonal projector T on the range of N,",
            )
        } else {
            ("", "", "")
        };
        let e = if self.vertices.len() == 1 { "E" } else { "E(t)" };
        format!(
            "For {plant}, all disturbances w with {}, and the observer xhat' = {a} xhat + Bu + L r{term}, r = y - C xhat, with the gains exactly as stored, the error e = x - xhat obeys e' = ({a} - LC)e + ({e} - LD)w{flow}; V = e'{}e{metric} satisfies V(t) <= exp(-2 rate t) V(0) + level with rate = {} and level = {}, from every e(0); and {}.{}",
            self.bounds().presumed(),
            self.metric(),
            at_least(self.rate, 4),
            at_most(self.level, 4),
            self.bounds().concluded(),
            enclosed(self.entries(), ""),
        )
    }
}

members! { InputToStateStability {
    "plant" {
        vertices = "vertices".by(DisturbedPlant::read_list);
        c = "C".matrix_with_columns(DisturbedPlant::sizes(&vertices).0);
        d = "D".data((c.rows(), DisturbedPlant::sizes(&vertices).1));
    }
    "observer" { l = "L".matrix((c.cols(), c.rows())); }
    { cubic = optional "cubic".part_of((c.cols(), c.rows(), d.cols())); }
    "lyapunov" { p = "P".symmetric(c.cols()); rate = "rate".positive(POSITIVE); lambda = "lambda".numbers(d.cols()); }
    "bounds" {
        disturbances = "w".bounds(d.cols());
        level = "level".positive(POSITIVE);
        limsup = "limsup".list(c.cols(), |bound| bound.positive(POSITIVE));
    }
} }

members! { CubicTerm, (order, outputs, disturbances): (usize, usize, usize) { {
    n = "N".matrix((order, outputs));
    theta = "theta".symmetric(outputs);
    x = "X".symmetric(outputs);
    kappa = "kappa".nonnegative("kappa is 0 or more");
    mu = "mu".numbers(disturbances);
} } }

members! { DisturbedPlant, first: Option<(usize, usize)> { {
    a = "A".square_data_of(first.map(|(order, _)| order));
    e = "E".by(|e| disturbed(e, a.rows(), first));
} } }

impl DisturbedPlant {
    pub(super) fn read_list(list: &Field<'_>) -> Result<Vec<Self>, FileError> {
        let mut first = None;
        list.some_of(|item| {
            let plant: Self = item.part_of(first)?;
            first.get_or_insert(plant.e.shape());
            Ok(plant)
        })
    }

    pub(super) fn sizes(vertices: &[Self]) -> (usize, usize) {
        vertices.first().map_or((0, 0), |first| first.e.shape())
    }
}

fn disturbed(field: &Field<'_>, order: usize, first: Option<(usize, usize)>) -> Result<Matrix<Datum>, FileError> {
    let e = field.data_with_rows(order)?;
    let shape = first.unwrap_or(e.shape());
    let e = field.not_without_columns(field.of_shape(e, shape)?)?;
    // The block inequality has a row for each state and each disturbance.
    field.bounded_order(order + e.cols(), LARGEST_ORDER)?;
    Ok(e)
}
