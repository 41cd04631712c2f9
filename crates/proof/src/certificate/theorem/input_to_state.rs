//! A bound of the error under bounded disturbances and measurement noise, of the linear and of the cubic observer.
//!
//! **Hypotheses.** For the plant `x' = Ax + Bu + Ew`, `y = Cx + Dw` with `|w_i| <= W_i`, and for the observer with the
//! gains L, N and theta as stored: `P~ > 0`; the block inequality of the linear part at every vertex (A, E) with the
//! multipliers lambda and a rate; for the cubic term `theta >= 0` and two inequalities with the numbers kappa and mu;
//! `2 rate level` is at least the sum of all that the disturbances can add to V'; `limsup_i^2 P~ > level 1_i 1_i'`.
//!
//! **Theorem.** `V = e'P~e` obeys `V(t) <= exp(-2 rate t) V(0) + level` for every e(0) and every such w, and `limsup
//! |e_i| <= limsup_i`.
//!
//! **Proof.** In the head of `statement/input_to_state.rs`.

use super::super::fields::{Field, LARGEST_ORDER};
use super::super::members::members;
use super::super::sentence::{Reading, Represented};
use super::{Fact, FileError, Statement, bounded, counted, data, enclosed, intervals};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::statement::{CubicTerm, DisturbedObserver, ErrorBound, input_to_state};
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

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), ProofError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ProofError::Sign { what, value }) }
}

pub(super) fn not_negative(what: &'static str, value: f64) -> Result<(), ProofError> {
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(ProofError::Sign { what, value }) }
}

/// `|w_1| <= 0.1, |w_2| <= 2`: bounds that are presumed, rounded down.
pub(super) fn bounds_in_words(disturbances: &[f64]) -> String {
    let bounds = disturbances.iter().enumerate();
    bounds.map(|(i, bound)| format!("|w_{}| <= {}", i + 1, if_at_most(*bound, 6))).collect::<Vec<_>>().join(", ")
}

/// `limsup |e_1| <= 0.1`: bounds that are concluded, rounded up.
pub(super) fn limits_in_words(limsup: &[f64]) -> String {
    let limits = limsup.iter().enumerate();
    limits.map(|(i, bound)| format!("limsup |e_{}| <= {}", i + 1, at_most(*bound, 4))).collect::<Vec<_>>().join(", ")
}

impl InputToStateStability {
    fn check(&self) -> Result<(), ProofError> {
        positive("the rate, which should be positive,", self.rate)?;
        positive("the level, which should be positive,", self.level)?;
        for bound in &self.limsup {
            positive("a bound of the error, which should be positive,", *bound)?;
        }
        for bound in &self.disturbances {
            not_negative("the bound of a disturbance, which should be 0 or more,", *bound)?;
        }
        if let Some(term) = &self.cubic {
            not_negative("kappa, which should be 0 or more,", term.kappa)?;
        }
        if self.vertices.is_empty() {
            return Err(ProofError::Empty { what: "the list of vertices" });
        }
        Ok(())
    }

    /// The name of the Lyapunov matrix: P itself, or the matrix near it for which the stored N is exact.
    fn metric(&self) -> &'static str {
        if self.cubic.is_some() { "P~" } else { "P" }
    }

    fn entries(&self) -> impl Iterator<Item = &Matrix<Datum>> {
        self.vertices.iter().flat_map(|vertex| [&vertex.a, &vertex.e]).chain([&self.d])
    }
}

impl Statement for InputToStateStability {
    const NAME: &'static str = "input-to-state-stability";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let vertices: Vec<_> =
            self.vertices.iter().map(|vertex| (intervals(&vertex.a), intervals(&vertex.e))).collect();
        let d = intervals(&self.d);
        let observer = DisturbedObserver { vertices: &vertices, c: &self.c, d: &d, l: &self.l };
        let bound = ErrorBound {
            p: &self.p,
            decay: self.rate,
            lambda: &self.lambda,
            disturbances: &self.disturbances,
            level: self.level,
            limsup: &self.limsup,
        };
        let found = input_to_state(&observer, self.cubic.as_ref(), &bound)?;
        let p = self.metric();
        let mut facts = vec![Fact::new(format!("{p} > 0"), found.positive)];
        let inequality = format!("[(A - LC)'{p} + {p}(A - LC) + 2 rate {p}, {p}(E - LD); *, -diag(lambda)] < 0");
        for (k, verdict) in found.decrease.into_iter().enumerate() {
            facts.push(Fact::at_vertex(&inequality, k, verdict));
        }
        let mut spent = "sum lambda_i w_i^2".to_owned();
        if let Some([weight, dominated, noise]) = found.cubic {
            facts.push(Fact::new("theta >= 0", weight));
            facts.push(Fact::new("kappa (S~ + S~') - 2 theta >= 0", dominated));
            facts.push(Fact::new("[2 diag(mu), 2 D'S~; *, S~ + S~'] >= 0", noise));
            spent.push_str(" + 27/128 kappa (sum mu_i w_i^2)^2");
        }
        facts.push(Fact::new(format!("{spent} <= 2 rate level"), found.level));
        facts.extend(
            found
                .components
                .into_iter()
                .enumerate()
                .map(|(i, verdict)| Fact::new(format!("limsup |e_{}| <= limsup[{i}]", i + 1), verdict)),
        );
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
            reading.errors_at_most(&self.limsup),
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
            bounds_in_words(&self.disturbances),
            self.metric(),
            at_least(self.rate, 4),
            at_most(self.level, 4),
            limits_in_words(&self.limsup),
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
