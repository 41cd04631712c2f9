//! Disturbance of the error in one step of a deployed observer: differences between stored and exact matrices,
//! measurement noise, and all rounding errors.

use super::{CubicGains, Deviation, Format, Operation, SampledPlant, Step, Stored};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::statement::EXACT_ORDER;
use crate::statement::lyapunov::error_matrix;

/// Number of roundings in the impulse of the cubic flow and in its resulting innovation, as counted in the head of the
/// module.
const IMPULSE_ROUNDINGS: usize = 17;
const INNOVATION_ROUNDINGS: usize = 5;

/// Bounds of absolute values, affine in `|e|`: each row acts on `(1, |e_1|, ..., |e_n|)`.
type Bound = Matrix<Interval>;

/// The error dynamics of the deployed observer.
pub(super) struct Disturbance<'a> {
    pub(super) plant: &'a SampledPlant,
    pub(super) stored: &'a Stored,
    pub(super) step: Step,
    pub(super) format: Format,
    pub(super) operation: &'a Operation,
}

/// An intermediate result that must lie in the range of the format, with its bound.
pub(super) struct Stage {
    pub(super) what: &'static str,
    pub(super) size: Bound,
    pub(super) limit: f64,
}

/// Bounds of one step for `|e_i|` within the given reach.
pub(super) struct StepBound {
    /// `|e+ - M e| <= D (1, |e|)`.
    pub(super) added: Bound,
    /// `|M e - F e|`: difference between the maps of the cubic observer and the first map F; zero without a cubic part.
    pub(super) bend: Bound,
    pub(super) stages: Vec<Stage>,
}

fn sizes(m: &Matrix<Interval>) -> Matrix<Interval> {
    m.map(|x| Interval::of(x.magnitude()))
}

fn points(m: &Matrix<f64>, what: &'static str) -> Result<Matrix<Interval>, ProofError> {
    Matrix::embed(m, what)
}

impl Disturbance<'_> {
    pub(super) fn order(&self) -> usize {
        self.plant.a.rows()
    }

    /// Error maps of one step: F alone, or for the cubic observer the two ends of the segment M(g).
    pub(super) fn maps(&self) -> Result<Vec<Matrix<Interval>>, ProofError> {
        let Stored { a, c, l, cubic, .. } = self.stored;
        let first = match self.step {
            Step::Joined => points(a, "F")?,
            Step::Innovation | Step::Accumulated => error_matrix::<Interval>(a, l, c)?,
        };
        let Some(cubic) = cubic else { return Ok(vec![first]) };
        // w > 0 was checked before, so the fallback is not reached.
        let inverse = Interval::of(cubic.w).recip().unwrap_or(Interval::UNBOUNDED);
        let turned = Matrix::scalar(self.order(), &Interval::ONE)
            .sum(&points(&cubic.n, "N")?.product(&points(c, "C")?)?.scaled(&inverse))?;
        Ok(vec![first, points(a, "A")?.product(&turned)?])
    }

    /// A bound that does not depend on the error.
    fn constant(&self, column: &Matrix<Interval>) -> Bound {
        Matrix::from_fn(column.rows(), self.order() + 1, |i, j| if j == 0 { column[(i, 0)] } else { Interval::zero() })
    }

    fn promised(&self, list: &[f64]) -> Bound {
        self.constant(&Matrix::from_fn(list.len(), 1, |i, _| Interval::of(list[i])))
    }

    fn same(&self, rows: usize, x: f64) -> Bound {
        self.constant(&Matrix::from_fn(rows, 1, |_, _| Interval::of(x)))
    }

    /// Rounding error of a sum of `products` products and `addends` other terms; `terms` bounds the sum of the absolute
    /// values of all terms.
    fn sum_error(&self, products: usize, addends: usize, terms: &Bound) -> Result<Bound, ProofError> {
        let k = products + addends;
        let (lost, gamma) = match self.format {
            Format::Fixed { .. } if self.step == Step::Accumulated => (Interval::ONE, Interval::zero()),
            Format::Fixed { .. } => (Interval::of(products as f64), Interval::zero()),
            _ => (Interval::of(2.0 * k as f64).mul(&Interval::ONE.add(&self.format.gamma(k))), self.format.gamma(k)),
        };
        let absolute = lost.mul(&Interval::of(self.format.absolute()));
        terms.scaled(&gamma).sum(&self.constant(&Matrix::from_fn(terms.rows(), 1, |_, _| absolute)))
    }

    /// `|dA| |x| + |dB| |u|`: effect of the deviation of the plant from the given A and B.
    fn deviation(&self, x: &Bound, u: &Bound) -> Result<Bound, ProofError> {
        match &self.operation.deviation {
            Some(Deviation { a, b }) => points(a, "dA")?.product(x)?.sum(&points(b, "dB")?.product(u)?),
            None => Ok(Matrix::zeros(self.order(), self.order() + 1)),
        }
    }

    /// `|B - B~|`, or the same for another matrix, entry by entry.
    fn mismatch(real: &Matrix<f64>, stored: &Matrix<f64>) -> Result<Matrix<Interval>, ProofError> {
        Ok(sizes(&points(real, "the plant")?.difference(&points(stored, "what is stored")?)?))
    }

    /// `|A - F - L~ C|`, in exact arithmetic up to a limited order, because the terms cancel.
    fn joined_mismatch(&self) -> Result<Matrix<Interval>, ProofError> {
        fn difference<R: Ring>(plant: &SampledPlant, stored: &Stored) -> Result<Matrix<R>, ProofError> {
            let lc = Matrix::<R>::embed(&stored.l, "L")?.product(&Matrix::embed(&plant.c, "C")?)?;
            Matrix::<R>::embed(&plant.a, "A")?.difference(&Matrix::embed(&stored.a, "F")?)?.difference(&lc)
        }
        let enclosed = if self.order() <= EXACT_ORDER {
            difference::<Exact>(self.plant, self.stored)?.map(Exact::enclosure)
        } else {
            difference::<Interval>(self.plant, self.stored)?
        };
        Ok(sizes(&enclosed))
    }

    /// Bounds of one step from any error with `|e_i| <= reach_i`.
    pub(super) fn step_bound(&self, reach: &[f64]) -> Result<StepBound, ProofError> {
        let Stored { a, b, c, l, cubic } = self.stored;
        let (n, m, outputs) = (self.order(), b.cols(), c.rows());
        let largest = self.format.largest();
        let stage = |what, size: &Bound| Stage { what, size: size.clone(), limit: largest };

        let x = self.promised(&self.operation.state);
        let u = self.promised(&self.operation.input);
        let xhat = Matrix::from_fn(n, n + 1, |i, j| match j {
            0 => x[(i, 0)],
            _ if j == i + 1 => Interval::ONE,
            _ => Interval::zero(),
        });
        let [a_size, b_size, c_size, l_size] =
            [sizes(&points(a, "A")?), sizes(&points(b, "B")?), sizes(&points(c, "C")?), sizes(&points(l, "L")?)];

        // The measurement, rounded into the format.
        let noise = self.promised(&self.operation.noise);
        let y = sizes(&points(&self.plant.c, "C")?).product(&x)?.sum(&noise)?;
        let converted = y.scaled(&Interval::of(self.format.unit())).sum(&self.same(outputs, self.format.absolute()))?;
        let measured = y.sum(&converted)?;
        let mut stages = vec![stage("y", &measured), stage("u", &u), stage("xhat", &xhat)];
        if !matches!(self.format, Format::Fixed { .. }) {
            // A linear algebra library may multiply by 1, so stored numbers count as results; fixed-point coefficients
            // may have a separate format.
            stages.push(stage("a stored number", &self.same(1, self.stored.largest())));
        }
        let input = b_size.product(&u)?;
        let input_mismatch = Self::mismatch(&self.plant.b, b)?.product(&u)?.sum(&self.deviation(&x, &u)?)?;

        if self.step == Step::Joined {
            let terms = a_size.product(&xhat)?.sum(&input)?.sum(&l_size.product(&measured)?)?;
            let rounding = self.sum_error(n + m + outputs, 0, &terms)?;
            stages.push(stage("F xhat + B u + L y", &terms.sum(&rounding)?));
            let added = self
                .joined_mismatch()?
                .product(&x)?
                .sum(&input_mismatch)?
                .sum(&l_size.product(&noise.sum(&converted)?)?)?
                .sum(&rounding)?;
            return Ok(StepBound { added, bend: Matrix::zeros(n, n + 1), stages });
        }

        // z = y - C xhat as computed, and its difference from C e.
        let terms = measured.sum(&c_size.product(&xhat)?)?;
        let rounding = self.sum_error(n, 1, &terms)?;
        stages.push(stage("y - C xhat", &terms.sum(&rounding)?));
        let zeta = Self::mismatch(&self.plant.c, c)?.product(&x)?.sum(&noise)?.sum(&converted)?.sum(&rounding)?;
        let errors = Matrix::from_fn(n, n + 1, |i, j| if j == i + 1 { Interval::ONE } else { Interval::zero() });
        let z = c_size.product(&errors)?.sum(&zeta)?;

        let mut added = Self::mismatch(&self.plant.a, a)?.product(&x)?.sum(&input_mismatch)?;
        let mut bend = Matrix::zeros(n, n + 1);
        let (moved, injected) = if let Some(cubic) = cubic {
            let turned = points(a, "A")?.product(&points(&cubic.n, "N")?)?;
            let part = self.flow(cubic, &z, reach)?;
            let inverse = Interval::of(cubic.w).recip().unwrap_or(Interval::UNBOUNDED);
            let slope = turned.sum(&points(l, "L")?.scaled(&Interval::of(cubic.w)))?.product(&points(c, "C")?)?;
            bend = sizes(&slope).product(&errors)?.scaled(&part.strength);
            let turned = sizes(&turned);
            // Bound of |g A N - r L| for 0 <= g <= 1/w, 0 <= r <= 1.
            let ends = turned.scaled(&inverse);
            let gain = Matrix::from_fn(n, outputs, |i, j| {
                Interval::of(ends[(i, j)].magnitude().max(l_size[(i, j)].magnitude()))
            });
            let n_size = sizes(&points(&cubic.n, "N")?);
            let terms = xhat.sum(&n_size.product(&part.impulse)?)?;
            let rounding = self.sum_error(outputs, 1, &terms)?;
            let moved = terms.sum(&rounding)?;
            stages.push(stage("xhat - N i", &moved));
            stages.extend(part.stages);
            added = added
                .sum(&gain.product(&zeta)?)?
                .sum(&turned.product(&part.impulse_error)?)?
                .sum(&l_size.product(&part.innovation_error)?)?
                .sum(&a_size.product(&rounding)?)?;
            (moved, part.innovation)
        } else {
            added = added.sum(&l_size.product(&zeta)?)?;
            (xhat, z)
        };
        let terms = a_size.product(&moved)?.sum(&input)?.sum(&l_size.product(&injected)?)?;
        let rounding = self.sum_error(n + m + outputs, 0, &terms)?;
        stages.push(stage("A xhat + B u + L z", &terms.sum(&rounding)?));
        Ok(StepBound { added: added.sum(&rounding)?, bend, stages })
    }

    /// The cubic flow applied to the computed innovation; `z` bounds the entries of the innovation.
    fn flow(&self, cubic: &CubicGains, z: &Bound, reach: &[f64]) -> Result<CubicPart, ProofError> {
        let outputs = z.rows();
        let at_reach =
            Matrix::from_fn(reach.len() + 1, 1, |i, _| if i == 0 { Interval::ONE } else { Interval::of(reach[i - 1]) });
        let size = z.product(&at_reach)?.as_slice().iter().fold(0.0_f64, |size, x| size.max(x.hi()));
        let size = Interval::of(size);
        let (w, h, tiny) = (Interval::of(cubic.w), Interval::of(cubic.h), Interval::of(self.format.absolute()));
        let inverse = w.recip().unwrap_or(Interval::UNBOUNDED);
        let bulk = Interval::ONE.add(&size);
        let underflow = Interval::of(4.0).mul(&tiny);
        let impulse_lost = underflow.mul(&Interval::ONE.add(&w)).mul(&bulk.mul(&bulk).mul(&bulk));
        let error =
            |roundings, lost: Interval| z.scaled(&self.format.gamma(roundings)).sum(&self.same(outputs, lost.hi()));
        let impulse_error = error(IMPULSE_ROUNDINGS, impulse_lost)?;
        let innovation_error = error(INNOVATION_ROUNDINGS, underflow.mul(&bulk))?;

        // The intermediate results in execution order. Rounding to nearest is monotone: a value of at most x is at most
        // `rounded(x)` after rounding.
        let one_more = Interval::ONE.add(&Interval::of(self.format.unit()));
        let rounded = |x: Interval| x.mul(&one_more).add(&tiny);
        let product = |x: &Interval, y: &Interval| rounded(x.mul(y));
        let root = |x: &Interval| x.sqrt().unwrap_or(Interval::UNBOUNDED);
        // A sum of `outputs` products of magnitude at most x, in any order.
        let count = Interval::of(outputs as f64);
        let gamma = Interval::ONE.add(&self.format.gamma(outputs));
        let sum = |x: &Interval| count.mul(&gamma).mul(&x.add(&tiny).add(&tiny));
        let theta = Interval::of(cubic.theta.as_slice().iter().fold(0.0_f64, |largest, x| largest.max(x.abs())));
        let weighted = sum(&theta);
        let form = sum(&weighted);
        let twice = form.add(&form);
        let drive = product(&twice, &h);
        let driven = product(&w, &drive);
        let b = rounded(root(&driven));
        let c = product(&b, &size);
        let epsilon = Interval::of(2.0 * self.format.unit());
        let large = epsilon.recip().unwrap_or(Interval::UNBOUNDED);
        // The square is computed only if c does not exceed 1/epsilon.
        let squared = Interval::of(c.hi().min(large.hi()));
        let squared = rounded(Interval::ONE.add(&product(&squared, &squared)));
        let a = rounded(root(&squared));
        let pulled = product(&drive, &size);
        // w k (s/a) (s/(1 + a)) <= 1, up to roundings (covered by a factor of 2) and underflow.
        let saturated = |x: Interval, y: Interval| Interval::of(x.hi().min(y.hi()));
        let underflow = Interval::ONE.add(&tiny.mul(&size).mul(&size));
        let pulled_twice = saturated(
            product(&pulled, &size),
            Interval::of(2.0).mul(&inverse).mul(&underflow).add(&Interval::of(64.0).mul(&tiny)),
        );
        let pull = product(&pulled_twice, &size);
        // g = (1 - r)/w <= c^2/(2w), and c^2 = w k |z|^2 up to 6 roundings (a factor below 2) and underflow.
        let square = size.mul(&size);
        let strength = drive.mul(&square).add(&tiny.mul(&inverse).mul(&Interval::ONE.add(&square)));
        let strength = Interval::of(strength.hi().min(inverse.hi()));

        let largest = self.format.largest();
        let stage = |what, x: Interval, limit: f64| Stage { what, size: self.same(1, x.magnitude()), limit };
        let stages = vec![
            stage("d = z/s", Interval::ONE, largest),
            stage("theta d", weighted, largest),
            stage("d'theta d", form, largest),
            stage("2q", twice, largest),
            stage("k = 2q h", drive, largest),
            stage("w k", driven, largest),
            stage("b = sqrt(w k)", b, largest),
            stage("c = b s", c, largest),
            stage("1 + c c", squared, largest),
            stage("1 + a", rounded(Interval::ONE.add(&a)), largest),
            stage("p = s/a", size, largest),
            stage("k p", pulled, largest),
            stage("k p (s/(1 + a))", pulled_twice, largest),
            // The code limits this by the square root of the largest number; the limit must not be reached.
            stage("k p (s/(1 + a)) s", pull, (largest.sqrt() / 2.0).next_down()),
        ];
        Ok(CubicPart {
            impulse: z.sum(&impulse_error)?.scaled(&inverse),
            impulse_error: impulse_error.scaled(&inverse),
            innovation: z.sum(&innovation_error)?,
            innovation_error,
            strength,
            stages,
        })
    }
}

/// The two results of the flow, and their differences from the exact flow of the same innovation.
pub(super) struct CubicPart {
    impulse: Bound,
    impulse_error: Bound,
    innovation: Bound,
    innovation_error: Bound,
    /// Upper bound of g.
    strength: Interval,
    stages: Vec<Stage>,
}
