//! The interval observer in continuous time: bounds of the state that hold at all times, and the width of them.
//!
//! **Hypotheses.** T is invertible, and z = T(x - xhat) has blocks of one or two entries. K is a Metzler matrix whose
//! entries are at least the norms of the blocks of `T(A - LC)T^-1`, on the diagonal the logarithmic norms; g is at
//! least the norms of the blocks of `T(E - LD)w`, H at least those of the rows of T^-1. `s > 0` with `Ks + rate s <=
//! 0`, and `K limit + g <= 0`.
//!
//! **Theorem.** If `|z_k| <= rho_k` for all blocks at the start, this holds at all times, so that `|x_i - xhat_i| <= (H
//! rho)_i`. `rho(t) <= limit + c exp(-rate t) s` for some c, and `limsup (H rho)_i <= widths_i`.
//!
//! **Proof.** `z' = Mz + T(E - LD)w`, so that the norms obey the inequality in the head of
//! `statement/interval_observer.rs`, and K with nonnegative entries off the diagonal preserves the order of solutions:
//! the norms stay below rho. `d = rho - limit` has `d' <= Kd`, and `c exp(-rate t) s` is above every solution of that
//! with `d(0) <= c s`. K is Hurwitz, for `Ks <= -rate s` with s > 0.

use super::super::Fault;
use super::super::fields::Field;
use super::super::members::members;
use super::super::sentence::Reading;
use super::{Fact, FileError, Names, Statement, counted};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::statement::{BlockCoordinates, entries_at_least, product_up};
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::{at_least, at_most, if_at_most};

/// T with its blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalCoordinates {
    /// T, n x n.
    pub t: Matrix<f64>,
    /// The numbers of entries of the blocks, 1 or 2 each.
    pub blocks: Vec<usize>,
}

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalEnclosure {
    /// A, n x n.
    pub a: Matrix<f64>,
    /// C, p x n.
    pub c: Matrix<f64>,
    /// How the disturbances enter the state, n x m.
    pub e: Matrix<f64>,
    /// How they enter the outputs, p x m.
    pub d: Matrix<f64>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// The coordinates.
    pub coordinates: IntervalCoordinates,
    /// K, q x q for q blocks.
    pub k: Matrix<f64>,
    /// g, q numbers.
    pub g: Vec<f64>,
    /// H, n x q.
    pub h: Matrix<f64>,
    /// s, q positive numbers.
    pub s: Vec<f64>,
    /// The rate, positive.
    pub rate: f64,
    /// The bounds of the disturbances, m numbers of 0 or more.
    pub disturbances: Vec<f64>,
    /// The bound of rho in the end, q numbers of 0 or more.
    pub limit: Vec<f64>,
    /// The bounds of the half-widths in the end, n numbers of 0 or more.
    pub widths: Vec<f64>,
}

pub(super) fn column(entries: &[f64]) -> Matrix<f64> {
    Matrix::from_fn(entries.len(), 1, |i, _| entries[i])
}

pub(super) fn regular(coordinates: Option<&BlockCoordinates>) -> Fact {
    let verdict = match coordinates {
        Some(_) => Verdict::Proved { margin: 0.0 },
        None => Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "T" }, best: f64::NAN },
    };
    Fact::new("T is invertible", verdict)
}

/// Whether every entry is at least, or if `strict` above, a number.
fn all_above(entries: impl IntoIterator<Item = f64>, least: f64, strict: bool) -> Verdict<Direction> {
    for (column, claimed) in entries.into_iter().enumerate() {
        let holds = if strict { claimed > least } else { claimed >= least };
        if !holds {
            let why = UndecidedReason::TighterThanProved { row: 0, column, claimed, proved: least };
            return Verdict::Undecided { why, best: claimed };
        }
    }
    Verdict::Proved { margin: 0.0 }
}

pub(super) fn check_numbers(
    shapes: &[(&'static str, usize, &[f64])],
    positive: &[(&'static str, &[f64])],
) -> Result<(), ProofError> {
    for (what, expected, found) in shapes {
        if found.len() != *expected {
            let (expected, found) = ((*expected, 1), (found.len(), 1));
            return Err(ProofError::DimensionMismatch { what, expected, found });
        }
        if let Some(row) = found.iter().position(|x| !x.is_finite()) {
            return Err(ProofError::NotFinite { what, row, column: 0, value: found[row] });
        }
    }
    for (what, entries) in positive {
        if let Some(&value) = entries.iter().find(|x| x.is_nan() || **x < 0.0) {
            return Err(ProofError::Sign { what, value });
        }
    }
    Ok(())
}

impl IntervalEnclosure {
    fn check(&self) -> Result<(), ProofError> {
        let (n, m, q) = (self.a.rows(), self.e.cols(), self.coordinates.blocks.len());
        check_numbers(
            &[
                ("g", q, &self.g),
                ("s", q, &self.s),
                ("limit", q, &self.limit),
                ("widths", n, &self.widths),
                ("w", m, &self.disturbances),
            ],
            &[
                ("the bound of a disturbance, which should be 0 or more,", &self.disturbances),
                ("a bound of rho, which should be 0 or more,", &self.limit),
                ("a width, which should be 0 or more,", &self.widths),
            ],
        )?;
        if !(self.rate > 0.0 && self.rate.is_finite()) {
            return Err(ProofError::Sign { what: "the rate, which should be positive,", value: self.rate });
        }
        self.k.expect_shape("K", (q, q))?;
        self.h.expect_shape("H", (n, q))?;
        self.d.expect_shape("D", (self.c.rows(), m))
    }
}

impl Statement for IntervalEnclosure {
    const NAME: &'static str = "interval-observer";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let q = self.coordinates.blocks.len();
        let embed = |m: &Matrix<f64>, what| Matrix::<Interval>::embed(m, what);
        let (a, c, e) = (embed(&self.a, "A")?, embed(&self.c, "C")?, embed(&self.e, "E")?);
        let (d, l) = (embed(&self.d, "D")?, embed(&self.l, "L")?);
        let flow = a.difference(&l.product(&c)?)?;
        let forcing = e.difference(&l.product(&d)?)?;
        let coordinates = BlockCoordinates::new(&self.coordinates.t, &self.coordinates.blocks)?;
        let unproved = || Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "T" }, best: f64::NAN };
        let [k, g, h] = match &coordinates {
            Some(coordinates) => [
                entries_at_least(&self.k, 1.0, &coordinates.comparison(&flow)?)?,
                entries_at_least(
                    &column(&self.g),
                    1.0,
                    &product_up(&coordinates.column_norms(&forcing)?, &column(&self.disturbances))?,
                )?,
                entries_at_least(&self.h, 1.0, &coordinates.widths())?,
            ],
            None => [unproved(), unproved(), unproved()],
        };
        let off_diagonal = (0..q).flat_map(|i| (0..q).map(move |j| (i, j))).filter(|(i, j)| i != j);
        let shifted = embed(&self.k, "K")?.sum(&Matrix::scalar(q, &Interval::of(self.rate)))?;
        let falls = shifted.product(&embed(&column(&self.s), "s")?)?;
        let held = embed(&self.k, "K")?.product(&embed(&column(&self.limit), "limit")?)?;
        let held = held.sum(&embed(&column(&self.g), "g")?)?;
        let negative = |m: &Matrix<Interval>| all_above(m.as_slice().iter().map(|x| -x.hi()), 0.0, false);
        Ok(vec![
            regular(coordinates.as_ref()),
            Fact::new("K is Metzler", all_above(off_diagonal.map(|place| self.k[place]), 0.0, false)),
            Fact::new("K >= norms of the blocks of T(A - LC)T^-1", k),
            Fact::new("g >= norms of the blocks of T(E - LD)w", g),
            Fact::new("H >= norms of the rows of T^-1", h),
            Fact::new("s > 0", all_above(self.s.iter().copied(), 0.0, true)),
            Fact::new("K s + rate s <= 0", negative(&falls)),
            Fact::new("K limit + g <= 0", negative(&held)),
            Fact::new(
                "H limit <= widths",
                entries_at_least(&column(&self.widths), 1.0, &product_up(&self.h, &column(&self.limit))?)?,
            ),
        ])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        Some(format!(
            "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at all times. The half-widths r approach {}, or less, like exp(-{} t).",
            reading.errors_at_most(&self.widths),
            at_least(self.rate, 4)
        ))
    }

    fn words(&self) -> String {
        let (n, m, p) = (self.a.rows(), self.e.cols(), self.c.rows());
        format!(
            "For the plant x' = Ax + Bu + Ew, y = Cx + Dw with {}, {} and {}, any B and u, all disturbances w with {}, and the interval observer xhat' = A xhat + Bu + L(y - C xhat), rho' = K rho + g, with all matrices exactly as stored, in exact arithmetic: if at the start every block z_k of z = T(x - xhat), of {} entries, has |z_k| <= rho_k, this holds at all times, and |x_i - xhat_i| <= (H rho)_i; K is Metzler and Hurwitz, rho(t) <= limit + c exp(-rate t) s for some c, with rate = {}; and {}.",
            counted(n, "state"),
            counted(m, "disturbance"),
            counted(p, "output"),
            bounds(&self.disturbances, "w"),
            sizes(&self.coordinates.blocks),
            at_least(self.rate, 4),
            limits(&self.widths, "(H rho)"),
        )
    }
}

members! { IntervalEnclosure {
    "plant" {
        a = "A".square();
        c = "C".matrix_with_columns(a.rows());
        e = "E".columns(a.rows());
        d = "D".matrix((c.rows(), e.cols()));
    }
    "observer" { l = "L".matrix((a.rows(), c.rows())); }
    { coordinates: IntervalCoordinates = "coordinates".part_of(a.rows()); }
    "comparison" {
        k = "K".matrix((coordinates.count(), coordinates.count()));
        g = "g".numbers(coordinates.count());
        h = "H".matrix((a.rows(), coordinates.count()));
        s = "s".numbers(coordinates.count());
        rate = "rate".positive("the rate is positive");
    }
    "bounds" {
        disturbances = "w".bounds(e.cols());
        limit = "limit".bounds(coordinates.count());
        widths = "widths".bounds(a.rows());
    }
} }

members! { IntervalCoordinates, order: usize { {
    t = "T".matrix((order, order));
    blocks = "blocks".by(|list| read_blocks(list, order));
} } }

impl IntervalCoordinates {
    /// The number of blocks.
    pub(super) fn count(&self) -> usize {
        self.blocks.len()
    }
}

fn read_blocks(list: &Field<'_>, order: usize) -> Result<Vec<usize>, FileError> {
    let blocks = list.list_of(|item| match item.count()? {
        length @ 1..=2 => Ok(length),
        length => {
            let requirement = "a block has one or two entries";
            Err(item.error(Fault::Range { value: length as f64, requirement }))
        }
    })?;
    match blocks.iter().sum() {
        found if found != order => Err(list.error(Fault::Length { expected: order, found })),
        _ => Ok(blocks),
    }
}

/// `|w_1| <= 2, |w_2| <= 3`.
pub(super) fn bounds(entries: &[f64], name: &str) -> String {
    let one = |(i, bound): (usize, &f64)| format!("|{name}_{}| <= {}", i + 1, if_at_most(*bound, 6));
    entries.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

/// `limsup r_1 <= 2, limsup r_2 <= 3`.
pub(super) fn limits(entries: &[f64], name: &str) -> String {
    let one = |(i, bound): (usize, &f64)| format!("limsup {name}_{} <= {}", i + 1, at_most(*bound, 4));
    entries.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

/// `1, 2, 1`.
pub(super) fn sizes(blocks: &[usize]) -> String {
    blocks.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}
