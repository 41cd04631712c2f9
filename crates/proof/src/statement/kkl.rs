//! Inequalities of a Kazantzis-Kravaris-Luenberger observer over a box, decided for its maps.
//!
//! The variables are x, u, and e, the error of xi. y = h(x), and the left inverse is evaluated at xi = phi(x) + e.
//! Every function is a [`Polynomial`] in atoms; bounds over the box are found by bisection (`polynomial`).

use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::polynomial::{Arena, Domain, Extremum, NoPolynomial, Polynomial, Rational, Scope, Tree};
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};
use crate::witness::Witness;

/// Expressions of plant and observer.
pub(crate) struct Expressions<'a> {
    pub(crate) f: Vec<&'a Tree>,
    pub(crate) h: Vec<&'a Tree>,
    pub(crate) phi: Vec<&'a Tree>,
    pub(crate) lambda: Vec<&'a Tree>,
    pub(crate) b: Vec<&'a Tree>,
    pub(crate) left_inverse: Vec<&'a Tree>,
    pub(crate) estimated: Vec<&'a Tree>,
}

/// The functions to be bounded, in the variables (x, u, e).
pub(crate) struct Composition {
    arena: Arena,
    states: usize,
    inputs: usize,
    /// Residual `Dphi f - Lambda phi - B`.
    residual: Vec<Polynomial>,
    lambda: Vec<Polynomial>,
    phi: Vec<Polynomial>,
    /// The Jacobian of (phi, h), row by row.
    jacobian: Vec<Polynomial>,
    /// Derivative of each entry of the left inverse with respect to xi, at `(phi(x) + e, h(x), u)`.
    slopes: Vec<Vec<Polynomial>>,
    /// Defect `z - phi^L(phi(x), h(x), u)` of the left inverse.
    defects: Vec<Polynomial>,
}

/// The box of x, u and e; e is 0 where it has no influence.
pub(crate) struct Axes<'a> {
    pub(crate) x: &'a [Interval],
    pub(crate) u: &'a [Interval],
    pub(crate) e: &'a [Interval],
}

type Composed<T> = Result<T, NoPolynomial>;

impl Composition {
    pub(crate) fn new(maps: &Expressions<'_>, inputs: usize) -> Composed<Self> {
        let (n, q) = (maps.f.len(), maps.phi.len());
        let mut arena = Arena::new(n + inputs + q);
        let variables: Vec<Polynomial> = (0..n + inputs + q).map(Arena::variable).collect();
        let (x, rest) = variables.split_at(n);
        let (u, e) = rest.split_at(inputs);
        let mut all = |trees: &[&Tree], scope: &Scope<'_>| -> Composed<Vec<Polynomial>> {
            trees.iter().map(|tree| tree.value(&mut arena, scope)).collect()
        };
        let f = all(&maps.f, &[("x", x), ("u", u)])?;
        let h = all(&maps.h, &[("x", x)])?;
        let phi = all(&maps.phi, &[("x", x)])?;
        let lambda = all(&maps.lambda, &[("u", u), ("y", &h)])?;
        let b = all(&maps.b, &[("u", u), ("y", &h)])?;
        let xi: Vec<Polynomial> = phi.iter().zip(e).map(|(phi, e)| phi.plus(e)).collect();
        let estimate = all(&maps.left_inverse, &[("xi", &xi), ("u", u), ("y", &h)])?;
        let exact = all(&maps.left_inverse, &[("xi", &phi), ("u", u), ("y", &h)])?;
        let z = all(&maps.estimated, &[("x", x)])?;
        let mut residual = Vec::with_capacity(q);
        for (i, (phi_i, b_i)) in phi.iter().zip(&b).enumerate() {
            let mut sum = b_i.negative();
            for (j, f_j) in f.iter().enumerate() {
                let slope = arena.derivative(phi_i, j)?;
                sum = sum.plus(&arena.product(&slope, f_j)?);
            }
            for (j, phi_j) in phi.iter().enumerate() {
                sum = sum.minus(&arena.product(&lambda[i * q + j], phi_j)?);
            }
            residual.push(sum);
        }
        let mut jacobian = Vec::with_capacity((q + h.len()) * n);
        for row in phi.iter().chain(&h) {
            for j in 0..n {
                jacobian.push(arena.derivative(row, j)?);
            }
        }
        let mut slopes = Vec::with_capacity(estimate.len());
        for estimate in &estimate {
            // At fixed y and u the derivative with respect to xi is that with respect to e.
            let slope = (0..q).map(|j| arena.derivative(estimate, n + inputs + j));
            slopes.push(slope.collect::<Composed<Vec<_>>>()?);
        }
        let defects = z.iter().zip(&exact).map(|(z, exact)| z.minus(exact)).collect();
        Ok(Self { arena, states: n, inputs, residual, lambda, phi, jacobian, slopes, defects })
    }

    fn axes(&self, of: &Axes<'_>) -> Vec<Interval> {
        let mut axes = [of.x, of.u, of.e].concat();
        axes.resize(self.arena.variables(), Interval::zero());
        axes
    }

    /// Whether all maps have values and derivatives on the box.
    pub(crate) fn is_defined(&mut self, of: &Axes<'_>) -> Verdict<Witness> {
        let axes = self.axes(of);
        for (k, (p, domain)) in self.arena.domains().into_iter().enumerate() {
            // The polynomial must be positive, or for a reciprocal of one sign.
            let below = self.supremum(&p.negative(), &axes, Some(-f64::MIN_POSITIVE));
            let is_positive = below.as_ref().is_ok_and(|found| found.upper < 0.0);
            let mut is_negative = || {
                let above = self.supremum(&p, &axes, Some(-f64::MIN_POSITIVE));
                above.is_ok_and(|found| found.upper < 0.0)
            };
            if !(is_positive || domain == Domain::NotZero && is_negative()) {
                let why = match below {
                    Err(reason) => reason.into(),
                    Ok(found) => UndecidedReason::Undefined { argument: k + 1, least: -found.upper },
                };
                return Verdict::Undecided { why, best: f64::NAN };
            }
        }
        Verdict::Proved { margin: 0.0 }
    }

    fn supremum(&mut self, p: &Polynomial, axes: &[Interval], goal: Option<f64>) -> Composed<Extremum> {
        self.arena.supremum(p, axes, goal)
    }

    /// Whether `p <= bound` on the box; `entry` is the index of p in its list.
    fn at_most(&mut self, p: &Polynomial, bound: f64, axes: &[Interval], entry: usize) -> Verdict<Witness> {
        match self.supremum(p, axes, Some(bound)) {
            Err(reason) => Verdict::Undecided { why: reason.into(), best: f64::NAN },
            Ok(found) if found.upper <= bound => Verdict::Proved { margin: 0.0 },
            Ok(found) if found.lower > bound => {
                let at = found.at[..self.states + self.inputs].to_vec();
                Verdict::Refuted { witness: Witness::Point { entry, at, value: found.lower, bound } }
            }
            Ok(found) => {
                let why = UndecidedReason::NotBounded { entry, claimed: bound, shown: found.upper };
                Verdict::Undecided { why, best: bound - found.lower }
            }
        }
    }

    fn between(&mut self, p: &Polynomial, of: Interval, axes: &[Interval], entry: usize) -> Verdict<Witness> {
        match self.at_most(p, of.hi(), axes, entry) {
            Verdict::Proved { .. } => self.at_most(&p.negative(), -of.lo(), axes, entry),
            other => other,
        }
    }

    /// Whether Lambda lies within `bounds`.
    pub(crate) fn lambda_within(&mut self, bounds: &Matrix<Interval>, of: &Axes<'_>) -> Verdict<Witness> {
        let entries = self.lambda.clone();
        self.within(&entries, bounds, of)
    }

    /// Whether the Jacobian of (phi, h) lies within `bounds`.
    pub(crate) fn jacobian_within(&mut self, bounds: &Matrix<Interval>, of: &Axes<'_>) -> Verdict<Witness> {
        let entries = self.jacobian.clone();
        self.within(&entries, bounds, of)
    }

    fn within(&mut self, entries: &[Polynomial], bounds: &Matrix<Interval>, of: &Axes<'_>) -> Verdict<Witness> {
        let axes = self.axes(of);
        let entries: Vec<_> = entries.iter().zip(bounds.as_slice().iter().copied()).collect();
        all(entries.iter().enumerate().map(|(k, (p, bounds))| self.between(p, *bounds, &axes, k)))
    }

    /// Whether `|residual_i| <= bounds_i`.
    pub(crate) fn residual_within(&mut self, bounds: &[f64], of: &Axes<'_>) -> Verdict<Witness> {
        let residual = self.residual.clone();
        self.magnitudes(&residual, bounds, of)
    }

    /// Whether `|z_k - phi^L_k(phi(x), h(x), u)| <= bounds_k`.
    pub(crate) fn defects_within(&mut self, bounds: &[f64], of: &Axes<'_>) -> Verdict<Witness> {
        let defects = self.defects.clone();
        self.magnitudes(&defects, bounds, of)
    }

    fn magnitudes(&mut self, entries: &[Polynomial], bounds: &[f64], of: &Axes<'_>) -> Verdict<Witness> {
        let axes = self.axes(of);
        all(entries.iter().zip(bounds).enumerate().map(|(k, (p, bound))| {
            let range = Interval::new(-bound, *bound).unwrap_or(Interval::zero());
            self.between(p, range, &axes, k)
        }))
    }

    /// `g'Wg` for the gradient g of an entry of the left inverse.
    fn slope_squared(&mut self, slope: &[Polynomial], w: &Matrix<f64>) -> Composed<Polynomial> {
        let mut sum = Polynomial::zero();
        for (i, left) in slope.iter().enumerate() {
            for (j, right) in slope.iter().enumerate() {
                let weight = Rational::from_f64(w[(i, j)]).unwrap_or(Rational::integer(0));
                sum = sum.plus(&self.arena.product(left, right)?.scaled(&weight));
            }
        }
        Ok(sum)
    }

    /// Whether `g'Wg <= lipschitz_k^2`.
    pub(crate) fn slopes_within(&mut self, lipschitz: &[f64], w: &Matrix<f64>, of: &Axes<'_>) -> Verdict<Witness> {
        let axes = self.axes(of);
        let slopes = self.slopes.clone();
        all(slopes.iter().zip(lipschitz).enumerate().map(|(k, (slope, bound))| {
            match self.slope_squared(slope, w) {
                Err(reason) => Verdict::Undecided { why: reason.into(), best: f64::NAN },
                // Rounded down, because bound^2 may not be a binary64 number.
                Ok(p) => self.at_most(&p, (bound * bound).next_down().max(0.0), &axes, k),
            }
        }))
    }

    /// Bounds of Lambda, entry by entry; `None` if an entry is unbounded.
    pub(crate) fn lambda_bounds(&mut self, of: &Axes<'_>) -> Composed<Option<Vec<Interval>>> {
        let entries = self.lambda.clone();
        self.ranges(&entries, of)
    }

    /// Bounds of the Jacobian of (phi, h), entry by entry; `None` if an entry is unbounded.
    pub(crate) fn jacobian_bounds(&mut self, of: &Axes<'_>) -> Composed<Option<Vec<Interval>>> {
        let entries = self.jacobian.clone();
        self.ranges(&entries, of)
    }

    /// Bounds of phi, entry by entry; `None` if an entry is unbounded.
    pub(crate) fn image_bounds(&mut self, of: &Axes<'_>) -> Composed<Option<Vec<Interval>>> {
        let entries = self.phi.clone();
        self.ranges(&entries, of)
    }

    fn ranges(&mut self, entries: &[Polynomial], of: &Axes<'_>) -> Composed<Option<Vec<Interval>>> {
        let axes = self.axes(of);
        let mut bounds = Vec::with_capacity(entries.len());
        for p in entries {
            let upper = self.supremum(p, &axes, None)?.upper;
            let lower = -self.supremum(&p.negative(), &axes, None)?.upper;
            let Some(range) = Interval::new(lower, upper).filter(Interval::is_bounded) else { return Ok(None) };
            bounds.push(range);
        }
        Ok(Some(bounds))
    }

    /// Upper bounds of the magnitudes of the residual.
    pub(crate) fn residual_bounds(&mut self, of: &Axes<'_>) -> Composed<Vec<f64>> {
        let residual = self.residual.clone();
        self.magnitude_bounds(&residual, of)
    }

    /// Upper bounds of the magnitudes of the defects.
    pub(crate) fn defect_bounds(&mut self, of: &Axes<'_>) -> Composed<Vec<f64>> {
        let defects = self.defects.clone();
        self.magnitude_bounds(&defects, of)
    }

    fn magnitude_bounds(&mut self, entries: &[Polynomial], of: &Axes<'_>) -> Composed<Vec<f64>> {
        let axes = self.axes(of);
        let bound = |p: &Polynomial| {
            let upper = self.supremum(p, &axes, None)?.upper;
            Ok(upper.max(self.supremum(&p.negative(), &axes, None)?.upper))
        };
        entries.iter().map(bound).collect()
    }

    /// Lipschitz constants of the left inverse in the norm of W.
    pub(crate) fn slope_bounds(&mut self, w: &Matrix<f64>, of: &Axes<'_>) -> Composed<Vec<f64>> {
        let axes = self.axes(of);
        let slopes = self.slopes.clone();
        let mut bounds = Vec::with_capacity(slopes.len());
        for slope in &slopes {
            let square = self.slope_squared(slope, w)?;
            bounds.push(self.supremum(&square, &axes, None)?.upper.max(0.0).sqrt());
        }
        Ok(bounds)
    }
}

/// The first verdict that is not `Proved`.
fn all(verdicts: impl Iterator<Item = Verdict<Witness>>) -> Verdict<Witness> {
    let mut verdicts = verdicts;
    verdicts.find(|verdict| !verdict.is_proved()).unwrap_or(Verdict::Proved { margin: 0.0 })
}

impl From<NoPolynomial> for UndecidedReason {
    fn from(reason: NoPolynomial) -> Self {
        match reason {
            NoPolynomial::TooLarge => Self::ExpressionTooLarge,
            NoPolynomial::DivisionByZero => Self::DivisionByZero,
        }
    }
}
