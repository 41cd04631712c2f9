//! Description of a nonlinearity: where it acts, its argument, and the sector of its increments.

use luenberger_lmi::{dynamic_matrix, proof_matrix};
use luenberger_proof::certificate::SectorTerm;
use luenberger_proof::{Interval, Matrix, Ring};
use nalgebra::DMatrix;

use crate::check;
use crate::enclosure::JacobianEnclosure;
use crate::error::DesignError;

/// A nonlinearity `G phi(t, H x, u)` whose increments `w = phi(H x) - phi(H z)` satisfy, at all times and for all
/// inputs, `(w - low H e)'(high H e - w) >= 0` with `e = x - z`.
///
/// For a scalar phi that says: slope between `low` and `high`. For `low = -gamma`, `high = gamma` it says
/// `|w| <= gamma |H e|`, for vectors too, and G and H may then have different widths. phi has to satisfy it where x
/// *and* xhat are, which the user must ensure for a plant that is Lipschitz on a region only.
#[derive(Debug, Clone, PartialEq)]
pub struct Sector {
    g: DMatrix<f64>,
    h: DMatrix<f64>,
    low: f64,
    high: f64,
}

impl Sector {
    /// `|phi(x) - phi(z)| <= gamma |x - z|` and nothing more, for n states.
    pub fn unstructured(n: usize, gamma: f64) -> Self {
        Self::structured(DMatrix::identity(n, n), DMatrix::identity(n, n), gamma)
    }

    /// `|phi(H x) - phi(H z)| <= gamma |H (x - z)|`, phi acting through G: G is n x q, H r x n.
    pub fn structured(g: DMatrix<f64>, h: DMatrix<f64>, gamma: f64) -> Self {
        Self { g, h, low: -gamma, high: gamma }
    }

    /// A slope between `low` and `high`: G is n x q, H q x n. For q > 1 phi must satisfy the inequality as a vector, as
    /// gradients of convex functions do; several scalar nonlinearities are several sectors.
    pub fn slope(g: DMatrix<f64>, h: DMatrix<f64>, low: f64, high: f64) -> Self {
        Self { g, h, low, high }
    }

    /// The Lipschitz condition in other units: with `x_i = s_i z_i`, `|phi_z(z) - phi_z(z~)| <= gamma |z - z~|` for
    /// `phi_z(z) = S^-1 phi(S z)`, S the diagonal of `scales`.
    ///
    /// gamma is the constant in the new units. In the units of x this is the sector with `G = S` and `H = S^-1`, so
    /// that the gain and P come out for x: nothing has to be transformed back. Powers of two as scales keep S^-1 exact.
    ///
    /// If phi acts on state i and depends on state j only, with constant c, then `gamma = c s_j / s_i`. The rescaled
    /// condition is then weaker than [`structured`](Self::structured)`(e_i, e_j', c)`: it lets every state act on every
    /// other. Whatever P proves the rescaled inequality with the multiplier tau proves the structured one with
    /// `tau / s_i^2`.
    pub fn rescaled(scales: &[f64], gamma: f64) -> Self {
        let diagonal = |f: fn(f64) -> f64| {
            DMatrix::from_fn(scales.len(), scales.len(), |i, j| if i == j { f(scales[i]) } else { 0.0 })
        };
        Self::structured(diagonal(|s| s), diagonal(f64::recip), gamma)
    }

    /// G, n x q: where the nonlinearity acts.
    pub fn g(&self) -> &DMatrix<f64> {
        &self.g
    }

    /// H, r x n: the argument of the nonlinearity is `H x`.
    pub fn h(&self) -> &DMatrix<f64> {
        &self.h
    }

    /// The lower end.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The upper end.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Whether it is a Lipschitz condition, `low = -high`.
    pub fn is_symmetric(&self) -> bool {
        self.low == -self.high
    }

    /// The sector of the same middle and `factor` times the width. For a Lipschitz condition: `factor` times its
    /// constant.
    #[must_use]
    pub fn widened(&self, factor: f64) -> Self {
        if self.is_symmetric() {
            return Self { low: factor * self.low, high: factor * self.high, ..self.clone() };
        }
        let (middle, radius) = (self.middle(), 0.5 * self.high - 0.5 * self.low);
        Self { low: middle - factor * radius, high: middle + factor * radius, ..self.clone() }
    }

    fn middle(&self) -> f64 {
        0.5 * self.low + 0.5 * self.high
    }

    pub(crate) fn term(&self, tau: f64) -> SectorTerm {
        SectorTerm { g: proof_matrix(&self.g), h: proof_matrix(&self.h), low: self.low, high: self.high, tau }
    }

    fn check(&self, n: usize) -> Result<(), DesignError> {
        check::matrix("G", &self.g, (n, self.g.ncols()))?;
        check::matrix("H", &self.h, (self.h.nrows(), n))?;
        let ends = self.low <= self.high && self.low.is_finite() && self.high.is_finite();
        if !ends || self.g.ncols() == 0 || self.h.nrows() == 0 {
            let (low, high) = (self.low, self.high);
            return Err(DesignError::BadSector { low, high, acts: self.g.ncols(), depends: self.h.nrows() });
        }
        if !self.is_symmetric() {
            check::matrix("H", &self.h, (self.g.ncols(), n))?;
        }
        Ok(())
    }
}

/// The linear part and the sectors of a plant `x' = A x + sum G_k phi_k(t, H_k x, u) + ..`, `y = C x`.
#[derive(Debug, Clone, PartialEq)]
pub struct LipschitzPlant {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    sectors: Vec<Sector>,
    /// A and C of the theorem: `a` and `c`, or intervals around them.
    within: (Matrix<Interval>, Matrix<Interval>),
    /// The bounds of Df and Dh that the theorem has to contain, where the plant is one of an enclosure.
    jacobians: Option<(Matrix<Interval>, Matrix<Interval>)>,
}

/// A sector this many times its width away from 0 is centred, and its middle an entry of A: about 0 the products of its
/// ends would hide its width in rounding.
const DISTANT: f64 = 16.0;

impl LipschitzPlant {
    /// A is n x n, C p x n. Terms that depend on t, u and y alone need not be named: the observer has them too.
    ///
    /// # Errors
    /// [`DesignError::Matrix`] for shapes and entries, [`DesignError::BadSector`].
    pub fn new(a: DMatrix<f64>, c: DMatrix<f64>, sectors: Vec<Sector>) -> Result<Self, DesignError> {
        let exactly = |m: &DMatrix<f64>| proof_matrix(m).map(|x| Interval::of(*x));
        let within = (exactly(&a), exactly(&c));
        let plant = Self { a, c, sectors, within, jacobians: None };
        plant.check(0.0)?;
        Ok(plant)
    }

    /// The plant of an enclosure: each varying entry of Df is a sector of its own. By the mean value theorem, applied
    /// to each component, `f_i(x) - f_i(z) = sum_j a_ij (x_j - z_j)` with every `a_ij` between the bounds of that
    /// entry. Entries that do not vary are coefficients; the theorem of a [`LipschitzDesign`](super::LipschitzDesign)
    /// has the whole interval of each, and is proved only if it contains all Jacobians of the enclosure.
    ///
    /// # Errors
    /// [`DesignError::VaryingOutput`] for an entry of Dh that varies; as [`new`](Self::new).
    pub fn over(enclosure: &JacobianEnclosure) -> Result<Self, DesignError> {
        let n = enclosure.a.rows();
        let mut within = (enclosure.a.clone(), enclosure.c.clone());
        let mut sectors = Vec::new();
        for entry in enclosure.varying() {
            let interval = enclosure.interval(entry);
            if entry.of_output {
                let (low, high) = (interval.lo(), interval.hi());
                return Err(DesignError::VaryingOutput { output: entry.row, state: entry.column, low, high });
            }
            let is_distant =
                !interval.contains(0.0) && interval.lo().abs().min(interval.hi().abs()) > DISTANT * interval.width();
            let middle = Interval::of(if is_distant { interval.midpoint() } else { 0.0 });
            let slopes = interval.sub(&middle);
            let (mut g, mut h) = (DMatrix::zeros(n, 1), DMatrix::zeros(1, n));
            (g[(entry.row, 0)], h[(0, entry.column)]) = (1.0, 1.0);
            sectors.push(Sector::slope(g, h, slopes.lo(), slopes.hi()));
            within.0[(entry.row, entry.column)] = middle;
        }
        let middles = |m: &Matrix<Interval>| dynamic_matrix(&m.map(Interval::midpoint));
        let plant = Self::new(middles(&within.0), middles(&within.1), sectors)?;
        Ok(Self { within, jacobians: Some((enclosure.a.clone(), enclosure.c.clone())), ..plant })
    }

    /// The same outputs with another linear part and other sectors, which no enclosure shows.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_sectors(self, a: DMatrix<f64>, sectors: Vec<Sector>) -> Result<Self, DesignError> {
        let plant = Self::new(a, self.c, sectors)?;
        Ok(Self { within: (plant.within.0.clone(), self.within.1), ..plant })
    }

    /// A and C of the theorem.
    pub(super) fn within(&self) -> &(Matrix<Interval>, Matrix<Interval>) {
        &self.within
    }

    /// The bounds of the Jacobians that the theorem has to contain.
    pub(super) fn jacobians(&self) -> Option<&(Matrix<Interval>, Matrix<Interval>)> {
        self.jacobians.as_ref()
    }

    /// `x' = A x + phi(t, x, u)` with `|phi(x) - phi(z)| <= gamma |x - z|`: all that is used in Rajamani's design.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn unstructured(a: DMatrix<f64>, c: DMatrix<f64>, gamma: f64) -> Result<Self, DesignError> {
        let sector = Sector::unstructured(a.nrows(), gamma);
        Self::new(a, c, vec![sector])
    }

    /// A, n x n.
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// C, p x n.
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// The sectors.
    pub fn sectors(&self) -> &[Sector] {
        &self.sectors
    }

    /// The same plant with every sector [widened](Sector::widened).
    #[must_use]
    pub fn widened(&self, factor: f64) -> Self {
        let sectors = self.sectors.iter().map(|sector| sector.widened(factor)).collect();
        Self { sectors, ..self.clone() }
    }

    /// A with every nonlinearity in the middle of its sector: one of the linear plants that the sectors contain.
    pub fn centre(&self) -> DMatrix<f64> {
        let moved = self.sectors.iter().filter(|sector| !sector.is_symmetric());
        moved.fold(self.a.clone(), |a, sector| a + &sector.g * &sector.h * sector.middle())
    }

    pub(super) fn check(&self, rate: f64) -> Result<(), DesignError> {
        let n = self.a.nrows();
        check::rate(rate)?;
        if n == 0 || self.c.nrows() == 0 {
            return Err(luenberger_plants::PlantError::Empty { states: n, outputs: self.c.nrows() }.into());
        }
        check::matrix("A", &self.a, (n, n))?;
        check::matrix("C", &self.c, (self.c.nrows(), n))?;
        self.sectors.iter().try_for_each(|sector| sector.check(n))
    }
}
