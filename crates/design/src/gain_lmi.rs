//! Gain by linear matrix inequality: one L and one P for one or several state matrices.
//!
//! `P > 0`, `A_k'P + P A_k - YC - C'Y' + 2 rate P < 0` for every k, `L = P^-1 Y`. Homogeneous in (P, Y): the solver
//! normalises them together.

use luenberger_linalg::state_units;
use luenberger_lmi::{Problem, Solution, he};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector};

use crate::check;
use crate::error::{DesignError, Pair};
use crate::gain_options::{Checked, GainOptions};
use crate::powers::{Powers, shift};

/// A gain with the Lyapunov matrix that came with it.
pub(crate) struct Gain {
    pub(crate) l: DMatrix<f64>,
    pub(crate) p: DMatrix<f64>,
}

/// L and P alone.
pub(crate) fn gain_by_lmi(plant: &StateSpace, rate: f64, options: &GainOptions) -> Result<Gain, DesignError> {
    Ok(solve(plant, std::slice::from_ref(&plant.a), rate, Problem::new(), options)?.0)
}

/// One L and one P for every state matrix in `vertices`, in addition to the constraints already in `lmi`.
pub(crate) fn solve(
    plant: &StateSpace,
    vertices: &[DMatrix<f64>],
    rate: f64,
    mut lmi: Problem,
    options: &GainOptions,
) -> Result<(Gain, Solution), DesignError> {
    check::plant(plant)?;
    check::rate(rate)?;
    let limits = options.check(plant.c.nrows())?;
    let units = NoiseUnits::of(&limits, vertices, &plant.c);
    let mut nearly = None;
    for (k, a) in vertices.iter().enumerate() {
        let seen = check::detectable(a, &plant.c, rate);
        nearly = match vertices {
            [_] => seen?,
            _ => seen.map_err(|error| error.of_pair(Pair::Vertex(k)))?.or(nearly),
        };
    }
    let scaled: Vec<DMatrix<f64>> = vertices.iter().map(|a| units.states.similar(a) / units.time).collect();
    let (seen, limits) = (units.states.columns(&(&units.whitening * &plant.c)), limits.within(&units));
    pose(&mut lmi, scaled.iter().enumerate().map(|(k, a)| (k, a, &seen)), rate / units.time, &limits);
    let solution = lmi.solve_with(&options.settings)?;
    if solution.verdict.is_proved() {
        Ok((units.gain_back(&gain_of(&solution)?), solution))
    } else {
        let what = if options.only_rate() { WHAT } else { WHAT_WITHIN_LIMITS };
        Err(DesignError::not_proved(what, Some(solution.verdict)).with_seen(nearly))
    }
}

/// Units of the states, `x = D z`, of time and of the outputs, in which noise has the intensity one and A and C have
/// norms of about one: the program with (2) of `gain_options` is not homogeneous. With `V = S S'`, `C^ = S^-1 C D / k`
/// and `A^ = D^-1 A D / t` it is solved by `P^ = D P D t / k^2` and `L^ = D^-1 L S k / t`.
pub(crate) struct NoiseUnits {
    states: Powers,
    time: f64,
    output: f64,
    /// `S^-1 / k`.
    whitening: DMatrix<f64>,
}

impl NoiseUnits {
    /// Those given, if there is no noise.
    fn of(limits: &Checked, vertices: &[DMatrix<f64>], c: &DMatrix<f64>) -> Self {
        let (n, p) = (c.ncols(), c.nrows());
        let given = Self { states: Powers::given(n), time: 1.0, output: 1.0, whitening: DMatrix::identity(p, p) };
        // V^-1 = R'R, and R is S^-1 for S = R^-1.
        let Some(root) = limits.precision().and_then(|precision| precision.clone().cholesky()) else { return given };
        let Some(Ok(states)) = vertices.first().map(state_units) else { return given };
        let (states, white) = (Powers(states), root.l().transpose());
        let power =
            |size: f64| if size > 0.0 && size.is_finite() { 2f64.powi(size.log2().round() as i32) } else { 1.0 };
        let output = power(states.columns(&(&white * c)).norm());
        let time = power(vertices.iter().map(|a| states.similar(a).norm()).fold(0.0, f64::max));
        let whitening = white / output;
        if whitening.iter().all(|x| x.is_finite()) { Self { states, time, output, whitening } } else { given }
    }

    fn gain_back(&self, Gain { l, p }: &Gain) -> Gain {
        let l = self.states.rows_back(&(l * &self.whitening * self.time));
        Gain { l, p: self.states.form_back(p) * (self.output * self.output / self.time) }
    }

    /// The weights `d_i^2` of the variances of z in the sum of those of x, and M with `|L| <= |L^ M|` for `|x| <= |z|`:
    /// the largest weight is one.
    pub(crate) fn back(&self) -> (DVector<f64>, DMatrix<f64>) {
        let largest = self.states.0.iter().copied().max().unwrap_or(0);
        let weights = self.states.0.iter().map(|power| shift(1.0, 2 * (power - largest)));
        (DVector::from_iterator(self.states.0.len(), weights), &self.whitening * self.time * shift(1.0, largest))
    }
}

/// Asks `lmi` for one P and one Y for all pairs `(A_k, C_k)`, each given with the number k (from 0) of its vertex, at
/// least one, within `limits`.
pub(crate) fn pose<'a>(
    lmi: &mut Problem,
    vertices: impl Iterator<Item = (usize, &'a DMatrix<f64>, &'a DMatrix<f64>)>,
    rate: f64,
    limits: &Checked,
) {
    let mut unknowns = None;
    for (k, a, c) in vertices {
        let (p, y) = unknowns.get_or_insert_with(|| {
            let p = lmi.symmetric("P", a.nrows());
            let y = lmi.rectangular("Y", a.nrows(), c.nrows());
            lmi.constrain("P > 0", &p >> 0.0);
            limits.constrain(lmi, &p, &y, a.nrows(), c.nrows());
            (p, y)
        });
        let half = &*p * a - &*y * c;
        lmi.constrain(&decrease_at(k), (he(half.clone()) + (2.0 * rate) * &*p) << 0.0);
        limits.constrain_vertex(lmi, &decrease_at(k), half, y);
    }
}

/// The name of the inequality of vertex k (from 0).
pub(crate) fn decrease_at(k: usize) -> String {
    format!("decrease at vertex {}", k + 1)
}

/// `L = P^-1 Y` and P from a solution of what [`pose`] asks.
pub(crate) fn gain_of(solution: &Solution) -> Result<Gain, DesignError> {
    let value = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
    let p: DMatrix<f64> = value("P");
    let l = check::solve_definite("P", &p, &value("Y"))?;
    Ok(Gain { l, p })
}

pub(crate) const WHAT_WITHIN_LIMITS: &str =
    "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0 with the bound of the gain and the noise asked for";

pub(crate) const WHAT: &str = "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0";
