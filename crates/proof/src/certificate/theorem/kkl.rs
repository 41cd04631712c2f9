//! A bound of the estimation error of a Kazantzis-Kravaris-Luenberger observer over a box.
//!
//! **Hypotheses.** All maps are defined on the box X x U of states and inputs, phi^L also at `phi(x) + e` for errors
//! with `|e_i| <= sqrt(W_ii) start`. There
//! ```text
//! |Dphi f - Lambda phi - B| <= residual              entry by entry
//! Lambda in [Lambda],  P > 0,  Lambda'P + P Lambda + 2 rate P < 0  for all Lambda in [Lambda],  rate > 0
//! [W, I; I, P] >= 0
//! g'Wg <= lipschitz_k^2                               for the derivative g of phi^L_k by xi
//! |z_k(x) - phi^L_k(phi(x), h(x), u)| <= defect_k
//! rate^2 limit^2 >= residual'|P| residual,  limit < start,  eventual_k >= lipschitz_k limit + defect_k
//! ```
//!
//! **Theorem.** Let x, u remain in the box, `xi' = Lambda(u, y) xi + B(u, y)`, `e = xi - phi(x)`, `V = sqrt(e'Pe)`.
//! Then `V(t) <= exp(-rate t) V(0) + (1 - exp(-rate t)) limit` from every xi(0); where `V(t) <= start`,
//! `|z_k - phi^L_k(xi, y, u)| <= lipschitz_k V(t) + defect_k`; and `limsup |z_k - zhat_k| <= eventual_k`.
//!
//! **Proof.** `e' = Lambda e - R` with `R = Dphi f - Lambda phi - B`, so that `V V' <= -rate V^2 + |e|_P |R|_P`, with
//! `|R|_P^2 = R'PR <= residual'|P| residual <= (rate limit)^2`: `V' <= -rate (V - limit)`. This is the first bound, and
//! V(0) <= start implies V(t) <= start. `[W, I; I, P] >= 0` with P > 0 is `W >= P^-1`, hence `|e_i| <= sqrt(W_ii) V`:
//! the segment from phi(x) to xi lies where phi^L is defined, and along it `|g'e| <= sqrt(g'P^-1 g) V <= lipschitz_k
//! V`. The defect is the rest. As `limit < start`, `V(t) <= start` from some time on, from every xi(0).

use super::super::Fault;
use super::super::fields::{Field, Fields};
use super::super::members::{Members, members};
use super::super::sentence::Reading;
use super::super::write::{Out, Written};
use super::{Fact, FileError, KklInjectivity, Names, Statement, Witness};
use crate::definite::positive_semidefinite;
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::polynomial::{ExpressionError, Tree};
use crate::ring::Ring;
use crate::statement::{Axes, Composition, Expressions, decay_rate_within, positive};
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::{at_least, at_most, counted, exact, if_at_most, shortest};

/// The largest number of states, inputs, outputs, entries of xi, and estimates.
pub const LARGEST_KKL: usize = 16;

/// An expression with its text.
#[derive(Debug, Clone, PartialEq)]
struct Expression {
    text: String,
    tree: Tree,
}

/// Which list of maps an expression belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum KklMapName {
    /// The right-hand side of the plant, in x and u.
    F,
    /// The output, in x.
    H,
    /// The transformation, in x.
    Phi,
    /// The matrix Lambda, in u and y.
    Lambda,
    /// The injection, in u and y.
    B,
    /// The left inverse, in xi, u and y.
    LeftInverse,
    /// The quantities that are estimated, in x.
    Estimated,
}

/// The text of an expression that cannot be read, and where it stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{map:?}, entry {}: {error}", entry + 1)]
pub struct KklMapError {
    /// The list.
    pub map: KklMapName,
    /// The entry, from 0.
    pub entry: usize,
    /// The error.
    pub error: ExpressionError,
}

/// The texts of the maps of plant and observer: `"x2^3 - 0.5*sin(x1)"`, in the grammar of `docs/certificates.md`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KklTexts {
    /// f(x, u), n of them.
    pub f: Vec<String>,
    /// h(x).
    pub h: Vec<String>,
    /// phi(x), q of them.
    pub phi: Vec<String>,
    /// Lambda(u, y), q x q, row by row.
    pub lambda: Vec<String>,
    /// B(u, y), q of them.
    pub b: Vec<String>,
    /// phi^L(xi, u, y).
    pub left_inverse: Vec<String>,
    /// z(x), what phi^L estimates.
    pub estimated: Vec<String>,
}

/// Plant and observer as expressions.
#[derive(Debug, Clone, PartialEq)]
pub struct KklMaps {
    inputs: usize,
    f: Vec<Expression>,
    h: Vec<Expression>,
    phi: Vec<Expression>,
    lambda: Vec<Expression>,
    b: Vec<Expression>,
    left_inverse: Vec<Expression>,
    estimated: Vec<Expression>,
}

/// A box of states and inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct KklBox {
    /// Bounds of x.
    pub x: Vec<Interval>,
    /// Bounds of u.
    pub u: Vec<Interval>,
}

/// The numbers that the theorem claims.
#[derive(Debug, Clone, PartialEq)]
pub struct KklClaims {
    /// Bounds of the residual, q of them.
    pub residual: Vec<f64>,
    /// Up to this V the estimate is bounded.
    pub start: f64,
    /// The limit of V.
    pub limit: f64,
    /// Lipschitz constants of phi^L in V.
    pub lipschitz: Vec<f64>,
    /// Bounds of `z - phi^L(phi(x), h(x), u)`.
    pub defect: Vec<f64>,
    /// Bounds of limsup |z - zhat|.
    pub eventual: Vec<f64>,
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct KklErrorBound {
    /// Plant and observer.
    pub maps: KklMaps,
    /// Where x and u remain.
    pub region: KklBox,
    /// Bounds of Lambda, q x q.
    pub lambda: Matrix<Interval>,
    /// P, q x q.
    pub p: Matrix<f64>,
    /// W >= P^-1.
    pub w: Matrix<f64>,
    /// The rate, positive.
    pub rate: f64,
    /// What is claimed.
    pub claims: KklClaims,
    /// The modulus of injectivity, if that is claimed too.
    pub injectivity: Option<KklInjectivity>,
}

impl KklMaps {
    /// The maps of these texts, for a plant with so many inputs.
    ///
    /// # Errors
    /// [`KklMapError`] names the first text that is no expression in the variables that it may have.
    pub fn new(texts: &KklTexts, inputs: usize) -> Result<Self, KklMapError> {
        let (n, p, q) = (texts.f.len(), texts.h.len(), texts.phi.len());
        let read = |map: KklMapName, texts: &[String], names: &[(&'static str, usize)]| {
            let parse = |(entry, text): (usize, &String)| {
                let tree = Tree::parse(text, names).map_err(|error| KklMapError { map, entry, error })?;
                Ok(Expression { text: text.clone(), tree })
            };
            texts.iter().enumerate().map(parse).collect::<Result<Vec<_>, KklMapError>>()
        };
        let (x, u, y) = (("x", n), ("u", inputs), ("y", p));
        Ok(Self {
            inputs,
            f: read(KklMapName::F, &texts.f, &[x, u])?,
            h: read(KklMapName::H, &texts.h, &[x])?,
            phi: read(KklMapName::Phi, &texts.phi, &[x])?,
            lambda: read(KklMapName::Lambda, &texts.lambda, &[u, y])?,
            b: read(KklMapName::B, &texts.b, &[u, y])?,
            left_inverse: read(KklMapName::LeftInverse, &texts.left_inverse, &[("xi", q), u, y])?,
            estimated: read(KklMapName::Estimated, &texts.estimated, &[x])?,
        })
    }

    fn composition(&self) -> Result<Composition, UndecidedReason> {
        fn trees(of: &[Expression]) -> Vec<&Tree> {
            of.iter().map(|expression| &expression.tree).collect()
        }
        let maps = Expressions {
            f: trees(&self.f),
            h: trees(&self.h),
            phi: trees(&self.phi),
            lambda: trees(&self.lambda),
            b: trees(&self.b),
            left_inverse: trees(&self.left_inverse),
            estimated: trees(&self.estimated),
        };
        Ok(Composition::new(&maps, self.inputs)?)
    }

    /// Bounds of phi over a box.
    ///
    /// # Errors
    /// [`UndecidedReason`] where an entry is not bounded.
    pub fn image_over(&self, region: &KklBox) -> Result<Vec<Interval>, UndecidedReason> {
        let axes = Axes { x: &region.x, u: &region.u, e: &[] };
        self.composition()?.image_bounds(&axes)?.ok_or(UndecidedReason::Overflow)
    }

    /// Bounds of `|z - phi^L(phi(x), h(x), u)|` over a box, where all maps are shown to be defined.
    ///
    /// # Errors
    /// [`UndecidedReason`] where a map is not shown to be defined, or a bound is not found.
    pub fn defect_over(&self, region: &KklBox) -> Result<Vec<f64>, UndecidedReason> {
        let mut composition = self.composition()?;
        let e = vec![Interval::zero(); self.phi.len()];
        match composition.is_defined(&Axes { x: &region.x, u: &region.u, e: &e }) {
            Verdict::Undecided { why, .. } => return Err(why),
            Verdict::Refuted { .. } => return Err(UndecidedReason::Overflow),
            Verdict::Proved { .. } => {}
        }
        Ok(composition.defect_bounds(&Axes { x: &region.x, u: &region.u, e: &[] })?)
    }

    /// Bounds of the Jacobian of (phi, h) over a box, (q + p) x n.
    ///
    /// # Errors
    /// [`UndecidedReason`] where an entry is not bounded.
    pub fn jacobian_over(&self, region: &KklBox) -> Result<Matrix<Interval>, UndecidedReason> {
        let axes = Axes { x: &region.x, u: &region.u, e: &[] };
        let bounds = self.composition()?.jacobian_bounds(&axes)?.ok_or(UndecidedReason::Overflow)?;
        let rows = self.phi.len() + self.h.len();
        Matrix::from_row_major(rows, self.f.len(), bounds).map_err(|_| UndecidedReason::Overflow)
    }

    /// Bounds of Lambda over a box, q x q.
    ///
    /// # Errors
    /// [`UndecidedReason`] where an entry is not bounded.
    pub fn lambda_over(&self, region: &KklBox) -> Result<Matrix<Interval>, UndecidedReason> {
        let q = self.phi.len();
        let axes = Axes { x: &region.x, u: &region.u, e: &[] };
        let bounds = self.composition()?.lambda_bounds(&axes)?.ok_or(UndecidedReason::Overflow)?;
        Matrix::from_row_major(q, q, bounds).map_err(|_| UndecidedReason::Overflow)
    }
}

/// `sqrt(W_ii) start`, rounded up.
fn reach(w: &Matrix<f64>, start: f64) -> Vec<Interval> {
    let reach = |i: usize| (w[(i, i)].max(0.0).sqrt().next_up() * start).next_up();
    (0..w.rows()).map(|i| Interval::new(-reach(i), reach(i)).unwrap_or(Interval::UNBOUNDED)).collect()
}

/// `a <= b` with the sum of the products of two vectors, exactly.
fn product(xs: &[f64]) -> Exact {
    xs.iter().fold(Exact::power_of_two(0), |p, x| p.mul(&Exact::from_f64(*x).unwrap_or_else(Exact::zero)))
}

impl KklErrorBound {
    /// The theorem with claims that are computed: the bounds of the residual, of the left inverse and of its defect,
    /// each enlarged by a twentieth, so that a checker with other arithmetic has room. `w` has to be above the inverse
    /// of `p`, and `start` is the V up to which the estimate is to be bounded.
    ///
    /// # Errors
    /// [`UndecidedReason`] where a bound is not found: maps that are not defined over the box.
    pub fn propose(
        maps: KklMaps,
        region: KklBox,
        lambda: Matrix<Interval>,
        (p, w, rate): (Matrix<f64>, Matrix<f64>, f64),
        start: f64,
    ) -> Result<Self, UndecidedReason> {
        let mut composition = maps.composition()?;
        let axes = Axes { x: &region.x, u: &region.u, e: &[] };
        let larger = |x: f64| if x == 0.0 { 0.0 } else { x * 1.05 + f64::MIN_POSITIVE };
        let residual: Vec<f64> = composition.residual_bounds(&axes)?.into_iter().map(larger).collect();
        let defect: Vec<f64> = composition.defect_bounds(&axes)?.into_iter().map(larger).collect();
        let e = reach(&w, start);
        let axes = Axes { e: &e, ..axes };
        let lipschitz: Vec<f64> = composition.slope_bounds(&w, &axes)?.into_iter().map(larger).collect();
        let square: f64 = (0..p.rows())
            .flat_map(|i| (0..p.rows()).map(move |j| (i, j)))
            .map(|(i, j)| p[(i, j)].abs() * residual[i] * residual[j])
            .sum();
        let limit = square.sqrt() / rate * (1.0 + 1e-12);
        let eventual = |(k, d): (&f64, &f64)| (k * limit + d) * (1.0 + 1e-12);
        let eventual = lipschitz.iter().zip(&defect).map(eventual).collect();
        let claims = KklClaims { residual, start, limit, lipschitz, defect, eventual };
        Ok(Self { maps, region, lambda, p, w, rate, claims, injectivity: None })
    }

    /// Shapes and ranges, as reading checks them.
    fn check(&self) -> Result<(), ProofError> {
        let (q, k) = (self.maps.phi.len(), self.maps.left_inverse.len());
        let length = |what: &'static str, found: usize, expected: usize| {
            if found == expected {
                return Ok(());
            }
            Err(ProofError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) })
        };
        for (what, count) in [("f", self.maps.f.len()), ("h", self.maps.h.len()), ("phi", q), ("phi^L", k)] {
            if count == 0 {
                return Err(ProofError::Empty { what });
            }
        }
        length("the bounds of x", self.region.x.len(), self.maps.f.len())?;
        length("the bounds of u", self.region.u.len(), self.maps.inputs)?;
        length("Lambda", self.maps.lambda.len(), q * q)?;
        length("B", self.maps.b.len(), q)?;
        length("z", self.maps.estimated.len(), k)?;
        self.lambda.expect_shape("the bounds of Lambda", (q, q))?;
        self.p.expect_shape("P", (q, q))?;
        self.w.expect_shape("W", (q, q))?;
        let KklClaims { residual, start, limit, lipschitz, defect, eventual } = &self.claims;
        length("the bounds of the residual", residual.len(), q)?;
        length("the Lipschitz constants", lipschitz.len(), k)?;
        length("the defects", defect.len(), k)?;
        length("the eventual bounds", eventual.len(), k)?;
        let bounds = [residual, lipschitz, defect, eventual].into_iter().flatten().chain([limit]);
        for (value, least) in bounds.map(|x| (*x, 0.0)).chain([(*start, 5e-324), (self.rate, 5e-324)]) {
            if !(value >= least && value.is_finite()) {
                return Err(ProofError::Sign { what: "a bound, which should be finite and not negative,", value });
            }
        }
        let mut ranges = self.region.x.iter().chain(&self.region.u).chain(self.lambda.as_slice()).enumerate();
        match ranges.find(|(_, range)| !range.is_bounded()) {
            Some((row, range)) => Err(ProofError::NotFinite { what: "the box", row, column: 0, value: range.width() }),
            None => self.injectivity.as_ref().map_or(Ok(()), |of| of.check((self.maps.f.len(), q, self.maps.h.len()))),
        }
    }

    /// `rate^2 limit^2 >= residual'|P| residual` and `limit < start`.
    fn limit(&self) -> Verdict<Witness> {
        let KklClaims { residual, limit, start, .. } = &self.claims;
        let mut square = Exact::zero();
        for (i, left) in residual.iter().enumerate() {
            for (j, right) in residual.iter().enumerate() {
                square = square.add(&product(&[self.p[(i, j)].abs(), *left, *right]));
            }
        }
        let room = product(&[self.rate, self.rate, *limit, *limit]).sub(&square);
        claimed(room.signum() >= 0 && limit < start, 0, *limit, square.round_up().sqrt() / self.rate)
    }

    fn eventual(&self) -> Verdict<Witness> {
        let KklClaims { limit, lipschitz, defect, eventual, .. } = &self.claims;
        for (k, eventual) in eventual.iter().enumerate() {
            let needed = product(&[lipschitz[k], *limit]).add(&product(&[defect[k]]));
            let verdict = claimed(needed.sub(&product(&[*eventual])).signum() <= 0, k, *eventual, needed.round_up());
            if !verdict.is_proved() {
                return verdict;
            }
        }
        Verdict::Proved { margin: 0.0 }
    }
}

/// A bound that is claimed, and the least one that follows.
fn claimed(holds: bool, entry: usize, claimed: f64, shown: f64) -> Verdict<Witness> {
    if holds {
        return Verdict::Proved { margin: 0.0 };
    }
    Verdict::Undecided { why: UndecidedReason::NotBounded { entry, claimed, shown }, best: claimed - shown }
}

fn list(expressions: &[Expression]) -> String {
    expressions.iter().map(|expression| expression.text.as_str()).collect::<Vec<_>>().join(", ")
}

impl Statement for KklErrorBound {
    const NAME: &'static str = "kkl-error-bound";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let q = self.p.rows();
        let above = Matrix::from_fn(2 * q, 2 * q, |i, j| match (i < q, j < q) {
            (true, true) => self.w[(i, j)],
            (false, false) => self.p[(i - q, j - q)],
            _ => f64::from(u8::from(i.abs_diff(j) == q)),
        });
        let no_output = Matrix::from_fn(1, q, |_, _| Interval::zero());
        let no_gain = Matrix::from_fn(q, 1, |_, _| 0.0);
        let decrease = decay_rate_within(&self.lambda, &no_gain, &no_output, &self.p, self.rate)?;
        let e = reach(&self.w, self.claims.start);
        let whole = Axes { x: &self.region.x, u: &self.region.u, e: &e };
        let axes = Axes { e: &[], ..whole };
        let claims = &self.claims;
        let mut over: [Verdict<Witness>; 6] = match self.maps.composition() {
            Err(why) => std::array::from_fn(|_| Verdict::Undecided { why: why.clone(), best: f64::NAN }),
            Ok(mut maps) => [
                maps.is_defined(&whole),
                maps.lambda_within(&self.lambda, &axes),
                maps.residual_within(&claims.residual, &axes),
                maps.slopes_within(&claims.lipschitz, &self.w, &whole),
                maps.defects_within(&claims.defect, &axes),
                match &self.injectivity {
                    Some(of) => maps.jacobian_within(&of.jacobian, &axes),
                    None => Verdict::Proved { margin: 0.0 },
                },
            ],
        };
        let mut take = |k: usize| core::mem::replace(&mut over[k], Verdict::Proved { margin: 0.0 });
        let mut facts = vec![
            Fact::stated("all maps are defined over the box", take(0)),
            Fact::stated("Lambda lies between its bounds over the box", take(1)),
            Fact::new("P > 0", positive(&self.p)?),
            Fact::new("Lambda'P + P Lambda + 2 rate P < 0", decrease),
            Fact::new("[W, I; I, P] >= 0", positive_semidefinite(&above)?),
            Fact::stated("|Dphi f - Lambda phi - B| <= residual over the box", take(2)),
            Fact::stated("g'Wg <= lipschitz^2 for g = dphi^L/dxi over the box and V <= start", take(3)),
            Fact::stated("|z - phi^L(phi, h, u)| <= defect over the box", take(4)),
            Fact::stated("rate^2 limit^2 >= residual'|P| residual and limit < start", self.limit()),
            Fact::stated("eventual >= lipschitz limit + defect", self.eventual()),
        ];
        if let Some(of) = &self.injectivity {
            facts.push(Fact::stated("the Jacobian of (phi, h) lies between its bounds over the box", take(5)));
            facts.extend(of.facts(&self.p)?);
        }
        Ok(facts)
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let (claims, names) = (&self.claims, reading.states);
        if names.len() != claims.defect.len() {
            return None;
        }
        let sum = |k: usize| match (claims.lipschitz[k], claims.defect[k]) {
            (0.0, defect) => at_most(defect, 3),
            (lipschitz, 0.0) => format!("{} V(t)", at_most(lipschitz, 3)),
            (lipschitz, defect) => format!("{} V(t) + {}", at_most(lipschitz, 3), at_most(defect, 3)),
        };
        let each = |say: &dyn Fn(usize) -> String| {
            names.iter().enumerate().map(|(k, name)| format!("{} for {name}", say(k))).collect::<Vec<_>>().join(", ")
        };
        let limit = if claims.limit == 0.0 { String::new() } else { format!(" + {}", at_most(claims.limit, 3)) };
        let eventually = if claims.eventual.iter().all(|x| *x == 0.0) {
            "the estimation error tends to 0".to_owned()
        } else {
            format!("the estimation error is in the limit at most {}", each(&|k| at_most(claims.eventual[k], 3)))
        };
        // Numbers of the study, which stand for those of binary64.
        let range = |(name, range): (&String, &Interval)| {
            format!("{name} in [{}, {}]", shortest(range.lo()), shortest(range.hi()))
        };
        let named = reading.states.iter().chain(reading.inputs);
        let region: Vec<String> = named.zip(self.region.x.iter().chain(&self.region.u)).map(range).collect();
        Some(format!(
            "As long as x(t) and u(t) stay in the region ({}), with e = xi - phi(x) and V = sqrt(e'Pe): V(t) <= exp(-{} t) V(0){limit}, and while V(t) <= {} the estimation error is at most {}. From every xi(0) {eventually}.",
            region.join(", "),
            at_least(self.rate, 3),
            if_at_most(claims.start, 3),
            each(&sum),
        ))
    }

    fn words(&self) -> String {
        let (maps, claims) = (&self.maps, &self.claims);
        let q = maps.phi.len();
        let rows: Vec<String> = maps.lambda.chunks(q.max(1)).map(list).collect();
        let bounds = |letter: &'static str, ranges: &[Interval]| {
            let range = |(k, range): (usize, &Interval)| {
                format!("{letter}{} in [{}, {}]", k + 1, exact(range.lo()), exact(range.hi()))
            };
            ranges.iter().enumerate().map(range).collect::<Vec<_>>()
        };
        let within = [bounds("x", &self.region.x), bounds("u", &self.region.u)].concat();
        let each = |say: &dyn Fn(usize) -> String| (0..claims.defect.len()).map(say).collect::<Vec<_>>().join(", ");
        let bound = |k: usize| {
            let (lipschitz, defect) = (exact(claims.lipschitz[k]), exact(claims.defect[k]));
            format!("|z{} - zhat{}| <= {lipschitz} V(t) + {defect}", k + 1, k + 1)
        };
        let eventual = |k: usize| format!("limsup |z{} - zhat{}| <= {}", k + 1, k + 1, exact(claims.eventual[k]));
        format!(
            "For the plant x' = f(x, u), y = h(x) with {}, {} and {}, f = ({}), h = ({}), and the observer xi' = Lambda(u, y) xi + B(u, y), zhat = phi^L(xi, u, y) of z = ({}) with Lambda = [{}], B = ({}) and phi^L = ({}): along every solution that remains in the box {}, the error e = xi - phi(x) with phi = ({}) satisfies V(t) <= exp(-rate t) V(0) + (1 - exp(-rate t)) limit from every xi(0), for V = sqrt(e'Pe), rate = {} and limit = {}. Whenever V(t) <= {}, and at all times if V(0) is, {}. From every xi(0), {}.",
            counted(maps.f.len(), "state"),
            counted(maps.inputs, "input"),
            counted(maps.h.len(), "output"),
            list(&maps.f),
            list(&maps.h),
            list(&maps.estimated),
            rows.join("; "),
            list(&maps.b),
            list(&maps.left_inverse),
            within.join(", "),
            list(&maps.phi),
            exact(self.rate),
            exact(claims.limit),
            exact(claims.start),
            each(&bound),
            each(&eventual),
        ) + &self.injectivity.as_ref().map_or_else(String::new, KklInjectivity::words)
    }
}

/// The texts of the maps are read together, and the dimensions follow from them.
impl Members for KklErrorBound {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let whole = file.take("box")?;
        let (x, u) = whole.object(|region| Ok((region.take("x")?, region.take("u")?)))?;
        let region = KklBox { x: read_ranges(&x)?, u: read_ranges(&u)? };
        let plant = file.take("plant")?;
        let (f, h) = plant.object(|plant| {
            let f = read_texts(&plant.take("f")?, None)?;
            if f.len() != region.x.len() {
                return Err(x.error(Fault::Length { expected: f.len(), found: region.x.len() }));
            }
            Ok((f, read_texts(&plant.take("h")?, None)?))
        })?;
        let observer = file.take("observer")?;
        let texts = observer.object(|observer| {
            let phi = read_texts(&observer.take("phi")?, None)?;
            let q = Some(phi.len());
            let lambda = observer.take("Lambda")?.list(phi.len(), |row| read_texts(row, q))?.concat();
            let b = read_texts(&observer.take("B")?, q)?;
            let left_inverse = read_texts(&observer.take("left_inverse")?, None)?;
            let estimated = read_texts(&observer.take("estimated")?, Some(left_inverse.len()))?;
            Ok(KklTexts { f, h, phi, lambda, b, left_inverse, estimated })
        })?;
        let (n, p, q) = (texts.f.len(), texts.h.len(), texts.phi.len());
        let maps = KklMaps::new(&texts, region.u.len()).or_else(|KklMapError { map, entry, error }| {
            let list = match map {
                KklMapName::F => plant.member("f"),
                KklMapName::H => plant.member("h"),
                KklMapName::Phi => observer.member("phi"),
                KklMapName::Lambda => observer.member("Lambda"),
                KklMapName::B => observer.member("B"),
                KklMapName::LeftInverse => observer.member("left_inverse"),
                KklMapName::Estimated => observer.member("estimated"),
            }?;
            Err(list.error(Fault::Expression { entry, error }))
        })?;
        let (lambda, p_matrix, w, rate) = file.object("lyapunov", |lyapunov| {
            Ok((
                lyapunov.take("Lambda")?.matrix_of_intervals((q, q))?,
                lyapunov.take("P")?.symmetric(q)?,
                lyapunov.take("W")?.symmetric(q)?,
                lyapunov.take("rate")?.positive(POSITIVE)?,
            ))
        })?;
        let claims = file.take("bounds")?.part_of((q, texts.left_inverse.len()))?;
        let injectivity = file.optional("injectivity").map(|field| field.part_of((n, q, p))).transpose()?;
        Ok(Self { maps, region, lambda, p: p_matrix, w, rate, claims, injectivity })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let rows = |expressions: &[Expression]| {
            let row = |row: &[Expression]| Out::Line(row.iter().map(Written::out).collect());
            Out::Lines(expressions.chunks(self.maps.phi.len().max(1)).map(row).collect())
        };
        // A range of one number is written as two equal ones.
        let range = |range: &Interval| Out::Line(vec![range.lo().out(), range.hi().out()]);
        let ranges = |ranges: &[Interval]| Out::Line(ranges.iter().map(range).collect());
        let maps = &self.maps;
        let mut members = vec![
            ("plant", Out::Object(vec![("f", maps.f.out()), ("h", maps.h.out())])),
            (
                "observer",
                Out::Object(vec![
                    ("phi", maps.phi.out()),
                    ("Lambda", rows(&maps.lambda)),
                    ("B", maps.b.out()),
                    ("left_inverse", maps.left_inverse.out()),
                    ("estimated", maps.estimated.out()),
                ]),
            ),
            ("box", Out::Object(vec![("x", ranges(&self.region.x)), ("u", ranges(&self.region.u))])),
            (
                "lyapunov",
                Out::Object(vec![
                    ("Lambda", self.lambda.out()),
                    ("P", self.p.out()),
                    ("W", self.w.out()),
                    ("rate", self.rate.out()),
                ]),
            ),
            ("bounds", self.claims.out()),
        ];
        members.extend(self.injectivity.iter().map(|of| ("injectivity", of.out())));
        members
    }
}

const POSITIVE: &str = "this number is positive";
const BOUND: &str = "a bound is 0 or more";

members! { KklClaims, (order, estimates): (usize, usize) { {
    residual = "residual".list(order, |bound| bound.nonnegative(BOUND));
    start = "start".positive(POSITIVE);
    limit = "limit".nonnegative(BOUND);
    lipschitz = "lipschitz".list(estimates, |bound| bound.nonnegative(BOUND));
    defect = "defect".list(estimates, |bound| bound.nonnegative(BOUND));
    eventual = "eventual".list(estimates, |bound| bound.nonnegative(BOUND));
} } }

impl Written for Expression {
    fn out(&self) -> Out {
        self.text.out()
    }
}

fn read_texts(field: &Field<'_>, length: Option<usize>) -> Result<Vec<String>, FileError> {
    let found = field.items()?.len();
    if found == 0 {
        return Err(field.error(Fault::Empty));
    }
    field.bounded_order(found, LARGEST_KKL)?;
    field.list(length.unwrap_or(found), |item| item.text().map(str::to_owned))
}

fn read_ranges(field: &Field<'_>) -> Result<Vec<Interval>, FileError> {
    field.bounded_order(field.items()?.len(), LARGEST_KKL)?;
    field.list_of(Field::interval)
}
