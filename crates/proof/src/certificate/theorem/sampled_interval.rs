//! The sampled interval observer as it runs on a target, the rounding of every operation included.
//!
//! **Hypotheses.** T is invertible, and z = T(x - xhat) has blocks of one or two entries. The entries of N, g, Q, U and
//! H are those of the step or larger that the head of `statement/interval_observer.rs` derives, for every A and B
//! between their bounds, with `eps = 4 c u`, u the unit roundoff of the format and `c = 2(n + m + p) + q + 8`, and
//! `outward >= eps`. The products of small numbers do not vanish in H rho: `eps H g >= 2 c eta`, eta the smallest
//! number of the format. `s > 0` with `(1 + eps) N s <= factor s`, factor < 1, and `(1 + eps)(N limit + g + Q x + U u)
//! + least <= limit`, least a number far above eta.
//!
//! **Theorem.** If `rho >= g` and `|z_k| <= rho_k` for all blocks at the start, then at every step, and the state is
//! between the computed numbers `xhat - r` and `xhat + r`, `r = H rho + outward |xhat|`. While xhat and u keep their
//! bounds, `rho(k) <= limit + c factor^k s` for some c, and `limsup r_i <= widths_i`.
//!
//! **Proof.** `x+ - xhat+ = (A - LC)e + (A - F) xhat + (B - G) u + E w - L v - delta` with the error delta of the
//! computed step, bounded in the head of `statement/interval_observer.rs`. In the norms of the blocks this is at most
//! `(1 - eps)(N rho + g + Q|xhat| + U|u|)`, which the computed sum of nonnegative terms is not below: products that
//! vanish are less than the last term of g. `xhat - r` is rounded by at most `u(|xhat| + r)`, less than `eps(|xhat| + H
//! rho)/2`. In the other direction the computed sums are at most `1 + eps` times their values, and a small number;
//! monotony of `rho -> N rho` gives the rest.

use super::super::members::members;
use super::super::sentence::Reading;
use super::interval_observer::{IntervalCoordinates, bounds, check_numbers, column, limits, regular, sizes};
use super::{Fact, Names, Statement, bounded, counted, enclosed, intervals};
use crate::definite::Direction;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::number::Datum;
use crate::ring::Ring;
use crate::statement::{BlockCoordinates, Format, SampledIntervals, entries_at_least, rounding, units};
use crate::verdict::{UndecidedReason, Verdict};
use crate::wording::{at_most, exact, if_at_most};

/// The data of the theorem; the head of the file has statement and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledIntervalEnclosure {
    /// A, n x n.
    pub a: Matrix<Datum>,
    /// B, n x m.
    pub b: Matrix<Datum>,
    /// C, p x n.
    pub c: Matrix<f64>,
    /// How the disturbances enter the state, n x d.
    pub e: Matrix<f64>,
    /// F of the step, n x n.
    pub f: Matrix<f64>,
    /// G of the step, n x m.
    pub input: Matrix<f64>,
    /// L of the step, n x p.
    pub l: Matrix<f64>,
    /// The coordinates.
    pub coordinates: IntervalCoordinates,
    /// The format of the step, binary32 or binary64.
    pub format: Format,
    /// N, q x q for q blocks.
    pub n: Matrix<f64>,
    /// g, q numbers.
    pub g: Vec<f64>,
    /// Q, q x n.
    pub q: Matrix<f64>,
    /// U, q x m.
    pub u: Matrix<f64>,
    /// H, n x q.
    pub h: Matrix<f64>,
    /// The factor of |xhat| in a half-width.
    pub outward: f64,
    /// s, q positive numbers.
    pub s: Vec<f64>,
    /// The factor, above 0 and below 1.
    pub factor: f64,
    /// The bounds of the disturbances, d numbers of 0 or more.
    pub disturbances: Vec<f64>,
    /// The bounds of the noise, p numbers of 0 or more.
    pub noise: Vec<f64>,
    /// The bounds of |xhat| for the widths in the end, n numbers of 0 or more.
    pub estimates: Vec<f64>,
    /// The bounds of |u| for them, m numbers of 0 or more.
    pub inputs: Vec<f64>,
    /// The bound of rho in the end, q numbers of 0 or more.
    pub limit: Vec<f64>,
    /// The bounds of the half-widths in the end, n numbers of 0 or more.
    pub widths: Vec<f64>,
}

impl SampledIntervalEnclosure {
    /// A and B between bounds, as the file stores them.
    ///
    /// # Errors
    /// [`ProofError::NotFinite`] for a bound that is infinite.
    pub fn plant(a: &Matrix<Interval>, b: &Matrix<Interval>) -> Result<(Matrix<Datum>, Matrix<Datum>), ProofError> {
        Ok((bounded(a, "A")?, bounded(b, "B")?))
    }

    fn check(&self) -> Result<(), ProofError> {
        let (n, m, q) = (self.a.rows(), self.b.cols(), self.coordinates.blocks.len());
        check_numbers(
            &[
                ("g", q, &self.g),
                ("s", q, &self.s),
                ("limit", q, &self.limit),
                ("widths", n, &self.widths),
                ("w", self.e.cols(), &self.disturbances),
                ("v", self.c.rows(), &self.noise),
                ("xhat", n, &self.estimates),
                ("u", m, &self.inputs),
            ],
            &[
                ("the bound of a disturbance, which should be 0 or more,", &self.disturbances),
                ("the bound of the noise, which should be 0 or more,", &self.noise),
                ("the bound of an estimate, which should be 0 or more,", &self.estimates),
                ("the bound of an input, which should be 0 or more,", &self.inputs),
                ("a bound of rho, which should be 0 or more,", &self.limit),
                ("a width, which should be 0 or more,", &self.widths),
            ],
        )?;
        if !(self.factor > 0.0 && self.factor < 1.0) {
            return Err(ProofError::Sign {
                what: "a factor, which should be above 0 and below 1,",
                value: self.factor,
            });
        }
        if !(self.outward >= 0.0 && self.outward < 1.0) {
            return Err(ProofError::Sign {
                what: "outward, which should be 0 or more and below 1,",
                value: self.outward,
            });
        }
        self.n.expect_shape("N", (q, q))?;
        self.q.expect_shape("Q", (q, n))?;
        self.u.expect_shape("U", (q, m))?;
        self.h.expect_shape("H", (n, q))
    }

    /// Whether the target stores these numbers as they are.
    fn stored(&self) -> Verdict<Direction> {
        let matrices = [&self.f, &self.input, &self.c, &self.l, &self.n, &self.q, &self.u, &self.h];
        let all = matrices.iter().flat_map(|m| m.as_slice()).chain(&self.g).chain([&self.outward]);
        match all.into_iter().find(|x| self.format.round(**x) != Some(**x)) {
            None => Verdict::Proved { margin: 0.0 },
            Some(x) => {
                let why = UndecidedReason::NotBounded { entry: 0, claimed: *x, shown: f64::NAN };
                Verdict::Undecided { why, best: f64::NAN }
            }
        }
    }

    /// `(1 + eps)(N limit + g + Q x + U u) + least <= limit`, and `(1 + eps)(H limit + 2 outward x) + least <= widths`.
    fn in_the_end(&self, eps: f64, least: f64) -> Result<[Verdict<Direction>; 2], ProofError> {
        let embed = |m: &Matrix<f64>, what| Matrix::<Interval>::embed(m, what);
        let (limit, x) = (embed(&column(&self.limit), "limit")?, embed(&column(&self.estimates), "xhat")?);
        let inputs = embed(&column(&self.inputs), "u")?;
        let rho = embed(&self.n, "N")?
            .product(&limit)?
            .sum(&embed(&column(&self.g), "g")?)?
            .sum(&embed(&self.q, "Q")?.product(&x)?)?
            .sum(&embed(&self.u, "U")?.product(&inputs)?)?;
        let outward = Interval::of(self.outward);
        let widths = embed(&self.h, "H")?.product(&limit)?.sum(&x.scaled(&outward.add(&outward)))?;
        let above = |m: &Matrix<Interval>| {
            let grown = Interval::of(1.0).add(&Interval::of(eps));
            m.map(|x| x.mul(&grown).add(&Interval::of(least)).hi())
        };
        Ok([
            entries_at_least(&column(&self.limit), 1.0, &above(&rho))?,
            entries_at_least(&column(&self.widths), 1.0, &above(&widths))?,
        ])
    }
}

impl Statement for SampledIntervalEnclosure {
    const NAME: &'static str = "sampled-interval-observer";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        self.check()?;
        let (a, b) = (intervals(&self.a), intervals(&self.b));
        let q = self.coordinates.blocks.len();
        let Some((unit, smallest, least)) = units(self.format) else {
            return Err(ProofError::Format { integer_bits: 0, fraction_bits: 0 });
        };
        let (eps, count) = rounding((a.rows(), b.cols(), self.c.rows(), q), unit);
        let coordinates = BlockCoordinates::new(&self.coordinates.t, &self.coordinates.blocks)?;
        let step = SampledIntervals {
            a: &a,
            b: &b,
            c: &self.c,
            e: &self.e,
            f: &self.f,
            g: &self.input,
            l: &self.l,
            disturbances: &self.disturbances,
            noise: &self.noise,
            format: self.format,
        };
        let unproved = || Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "T" }, best: f64::NAN };
        let entries = match &coordinates {
            Some(coordinates) => {
                let found = step.bounds(coordinates)?;
                [
                    entries_at_least(&self.n, 1.0 - eps, &found.n)?,
                    entries_at_least(&column(&self.g), 1.0 - eps, &found.g)?,
                    entries_at_least(&self.q, 1.0 - eps, &found.q)?,
                    entries_at_least(&self.u, 1.0 - eps, &found.u)?,
                    entries_at_least(&self.h, 1.0 - eps, &found.h)?,
                ]
            }
            None => [unproved(), unproved(), unproved(), unproved(), unproved()],
        };
        let [n, g, of_estimate, of_input, h] = entries;
        let embed = |m: &Matrix<f64>, what| Matrix::<Interval>::embed(m, what);
        let small = embed(&self.h, "H")?.product(&embed(&column(&self.g), "g")?)?.map(|x| x.lo() * eps);
        let needed = (2.0 * count as f64 * smallest).next_up();
        let small = entries_at_least(&small, 1.0, &small.map(|_| needed))?;
        let outward = entries_at_least(&column(&[self.outward]), 1.0, &column(&[eps]))?;
        let s = embed(&column(&self.s), "s")?;
        let grown = Interval::of(1.0).add(&Interval::of(eps));
        let next = embed(&self.n, "N")?.product(&s)?.map(|x| x.mul(&grown).hi());
        let positive = match self.s.iter().position(|x| x.is_nan() || *x <= 0.0) {
            None => Verdict::Proved { margin: 0.0 },
            Some(row) => {
                let why = UndecidedReason::TighterThanProved { row, column: 0, claimed: self.s[row], proved: 0.0 };
                Verdict::Undecided { why, best: self.s[row] }
            }
        };
        let [limit, widths] = self.in_the_end(eps, least)?;
        Ok(vec![
            Fact::new("the numbers of the step are those of the format", self.stored()),
            regular(coordinates.as_ref()),
            Fact::new("(1 - eps) N >= norms of the blocks of T(A - LC)T^-1, rounding included", n),
            Fact::new("(1 - eps) g >= norms of the blocks of T(Ew - Lv), rounding included", g),
            Fact::new("(1 - eps) Q >= errors of F and rounding", of_estimate),
            Fact::new("(1 - eps) U >= errors of G and rounding", of_input),
            Fact::new("(1 - eps) H >= norms of the rows of T^-1", h),
            Fact::new("eps H g >= 2 c eta", small),
            Fact::new("outward >= eps", outward),
            Fact::new("s > 0", positive),
            Fact::new("(1 + eps) N s <= factor s", entries_at_least(&column(&self.s), self.factor, &next)?),
            Fact::new("(1 + eps)(N limit + g + Q xhat + U u) + least <= limit", limit),
            Fact::new("(1 + eps)(H limit + 2 outward xhat) + least <= widths", widths),
        ])
    }

    fn sentence(&self, reading: &Reading<'_>, _margin: f64) -> Option<String> {
        let within = |name: &str, bounds: &[f64]| {
            let listed: Vec<String> = bounds.iter().map(|bound| if_at_most(*bound, 4)).collect();
            (!listed.is_empty()).then(|| format!("|{name}| <= ({})", listed.join(", ")))
        };
        let kept: Vec<String> =
            [within("xhat", &self.estimates), within("u", &self.inputs)].into_iter().flatten().collect();
        Some(format!(
            "Under all noise and disturbances within `bounds`, and for x(0) within `initial_bounds` of the first estimate, the state is between xhat - r and xhat + r at every sample, the rounding of every operation included ({}). While {}, the half-widths r approach {}, or less, by the factor {} at each sample.",
            self.format,
            kept.join(" and "),
            reading.errors_at_most(&self.widths),
            at_most(self.factor, 6)
        ))
    }

    fn words(&self) -> String {
        let (n, m, p) = (self.a.rows(), self.b.cols(), self.c.rows());
        let kept: Vec<String> = [bounds(&self.estimates, "xhat"), bounds(&self.inputs, "u")]
            .into_iter()
            .filter(|list| !list.is_empty())
            .collect();
        let disturbed: Vec<String> = [bounds(&self.disturbances, "w"), bounds(&self.noise, "v")]
            .into_iter()
            .filter(|list| !list.is_empty())
            .collect();
        format!(
            "For the sampled plant x+ = Ax + Bu + Ew, y = Cx + v with {}, {}, {} and {}, all w and v with {}, y and u being numbers of {format}, and the interval observer xhat+ = F xhat + Gu + L(y - C xhat), rho+ = N rho + g + Q|xhat| + U|u|, r = H rho + outward |xhat|, its numbers exactly as stored, each operation rounded to nearest in {format}, sums in any order, with or without fused multiply-adds, and no result beyond its range: if at the start rho >= g and every block z_k of z = T(x - xhat), of {} entries, has |z_k| <= rho_k, the latter holds at each step, and every x_i lies between the computed xhat_i - r_i and xhat_i + r_i. While {}, rho(k) <= limit + c factor^k s for some c, with factor = {}, and {}.{}",
            counted(n, "state"),
            counted(m, "input"),
            counted(self.e.cols(), "disturbance"),
            counted(p, "output"),
            disturbed.join(", "),
            sizes(&self.coordinates.blocks),
            kept.join(", "),
            exact(self.factor),
            limits(&self.widths, "r"),
            enclosed([&self.a, &self.b], ""),
            format = self.format,
        )
    }
}

members! { SampledIntervalEnclosure {
    "plant" {
        a = "A".square_data();
        b = "B".data_with_rows(a.rows());
        c = "C".matrix_with_columns(a.rows());
        e = "E".matrix_with_rows(a.rows());
    }
    "observer" {
        f = "F".matrix((a.rows(), a.rows()));
        input = "G".matrix((a.rows(), b.cols()));
        l = "L".matrix((a.rows(), c.rows()));
    }
    { coordinates: IntervalCoordinates = "coordinates".part_of(a.rows()); }
    "step" {
        format = "format".word(&[("binary32", Format::Binary32), ("binary64", Format::Binary64)]);
        n = "N".matrix((coordinates.count(), coordinates.count()));
        g = "g".numbers(coordinates.count());
        q = "Q".matrix((coordinates.count(), a.rows()));
        u = "U".matrix((coordinates.count(), b.cols()));
        h = "H".matrix((a.rows(), coordinates.count()));
        outward = "outward".number(|x| (0.0..1.0).contains(&x), "outward is 0 or more and below 1");
    }
    "comparison" {
        s = "s".numbers(coordinates.count());
        factor = "factor".number(|x| x > 0.0 && x < 1.0, "the factor is above 0 and below 1");
    }
    "bounds" {
        disturbances = "w".bounds(e.cols());
        noise = "v".bounds(c.rows());
        estimates = "xhat".bounds(a.rows());
        inputs = "u".bounds(b.cols());
        limit = "limit".bounds(coordinates.count());
        widths = "widths".bounds(a.rows());
    }
} }
