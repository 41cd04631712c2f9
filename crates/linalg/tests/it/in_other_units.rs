//! Every routine in other units of states, inputs, outputs, disturbances, time and cost: see `tests/scaling`.
//!
//! What has no place here depends on units by its definition: `schur`, `balanced`, `distance_to_unobservability` (a
//! distance in the norm of the units given), eigenvalues and definiteness of a symmetric matrix as a form.

#[path = "../scaling/mod.rs"]
mod scaling;

use luenberger_linalg::*;
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use scaling::Axis::{Equation, Input, One, Output, State};
use scaling::{Answer, Unit, Units, difference, unit};

/// Powers of two change no bit of what is computed in balanced units.
const EXACT: f64 = 0.0;
/// Units up to 2^10 apart are left as they are: an error of rounding relative to a norm grows by that much for the row
/// and for the column of an entry.
const LEFT: f64 = 1024.0 * 1024.0 * f64::EPSILON;
/// The same for plants of order five with entries of about one, whose conditions are below a hundred as a rule.
const ACCURATE: f64 = 100.0 * LEFT;

const A: Unit = unit((State, 1), (State, -1), -1);
const B: Unit = unit((State, 1), (Input, -1), -1);
const C: Unit = unit((Output, 1), (State, -1), 0);
const D: Unit = unit((Output, 1), (Input, -1), 0);
const E: Unit = unit((Equation, 1), (State, -1), 0);
/// Intensities of noise: their integral over time is a covariance.
const W: Unit = unit((State, 1), (State, 1), -1);
const V: Unit = unit((Output, 1), (Output, 1), 1);
const P: Unit = unit((State, 1), (State, 1), 0);
/// Cost per time, and the cost of a state.
const Q: Unit = unit((State, -1), (State, -1), -1).cost(1);
const R: Unit = unit((Input, -1), (Input, -1), -1).cost(1);
const S: Unit = unit((State, -1), (Input, -1), -1).cost(1);
const X: Unit = unit((State, -1), (State, -1), 0).cost(1);
const K: Unit = unit((Input, 1), (State, -1), 0);
const L: Unit = unit((State, 1), (Output, -1), -1);

/// A plant with its weights, in some units.
#[derive(Debug, Clone)]
struct Plant {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    e: DMatrix<f64>,
    w: DMatrix<f64>,
    v: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    s: DMatrix<f64>,
    l: DMatrix<f64>,
    /// Functional of the state, one row.
    k: DMatrix<f64>,
    poles: Vec<Complex<f64>>,
    h: f64,
}

impl Plant {
    fn within(&self, units: &Units) -> Self {
        let to = |m: &DMatrix<f64>, unit: Unit| units.apply(m, unit, 1);
        Self {
            a: to(&self.a, A),
            b: to(&self.b, B),
            c: to(&self.c, C),
            d: to(&self.d, D),
            e: to(&self.e, E),
            w: to(&self.w, W),
            v: to(&self.v, V),
            q: to(&self.q, Q),
            r: to(&self.r, R),
            s: to(&self.s, S),
            l: to(&self.l, L),
            k: to(&self.k, unit((One, 1), (State, -1), 0)),
            poles: self.poles.iter().map(|z| units.frequency(*z, 1)).collect(),
            h: units.duration(self.h),
        }
    }

    /// All poles left of the imaginary axis by 0.2 at least.
    fn stable(mut self) -> Self {
        let shift = spectral_abscissa(&self.a).unwrap().max(-0.2) + 0.2;
        self.a -= DMatrix::identity(self.a.nrows(), self.a.nrows()) * shift;
        self
    }

    /// All poles within the circle of radius 0.8.
    fn contracting(mut self) -> Self {
        let radius = spectral_radius(&self.a).unwrap();
        self.a *= 0.8 / radius.max(0.8);
        self.poles = self.poles.iter().map(|z| z * 0.1).collect();
        self
    }

    /// Diagonal, with rates from 1 to 1e-9, and outputs that do not see some of the modes.
    fn slow(mut self) -> Self {
        let n = self.a.nrows();
        self.a = DMatrix::from_fn(n, n, |i, j| if i == j { -(10f64.powf(-9.0 * self.a[(i, i)].abs())) } else { 0.0 });
        for j in 0..n {
            if self.c[(0, j)] < 0.0 {
                self.c.column_mut(j).fill(0.0);
            }
        }
        self
    }

    /// Fewer outputs than states, but for one of each.
    fn partly_seen(mut self) -> Self {
        if self.a.nrows() <= self.c.nrows() {
            self.c = self.c.rows(0, 1).into_owned();
        }
        self
    }

    /// The last state unseen, or moved by no input.
    fn hidden(mut self) -> Self {
        let n = self.a.nrows();
        for j in 0..n - 1 {
            self.a[(j, n - 1)] = 0.0;
        }
        self.c.column_mut(n - 1).fill(0.0);
        self
    }
}

fn plant() -> impl Strategy<Value = Plant> {
    let entry = prop_oneof![1 => Just(0.0), 5 => 0.1..1.0f64, 5 => -1.0..-0.1f64];
    (1usize..=5, 1usize..=2, 1usize..=2, prop::collection::vec(entry, 200)).prop_map(|(n, m, p, entries)| {
        let mut entries = entries.into_iter();
        let mut matrix = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| entries.next().unwrap());
        let a = matrix(n, n);
        let (b, c, d) = (matrix(n, m), matrix(p, n), matrix(p, m));
        let e = matrix(n, n) + DMatrix::identity(n, n) * 3.0;
        let gram = |m: DMatrix<f64>| &m * m.transpose();
        let plus = |m: DMatrix<f64>| {
            let k = m.nrows();
            gram(m) + DMatrix::identity(k, k) * 0.5
        };
        let (w, v, q, r) = (plus(matrix(n, n)), plus(matrix(p, p)), plus(matrix(n, n)), plus(matrix(m, m)));
        let (s, l, k) = (matrix(n, m) * 0.1, matrix(n, p), matrix(1, n).add_scalar(1.5));
        let poles = (0..n).map(|k| Complex::from(-1.0 - 0.75 * k as f64)).collect();
        Plant { a, b, c, d, e, w, v, q, r, s, l, k, poles, h: 0.3 }
    })
}

/// The inputs twice, the second ones a tenth as strong and with a negative weight.
fn opposed(plant: &Plant) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, m) = plant.b.shape();
    let (mut b, mut r) = (DMatrix::zeros(n, 2 * m), DMatrix::zeros(2 * m, 2 * m));
    b.columns_mut(0, m).copy_from(&plant.b);
    b.columns_mut(m, m).copy_from(&(&plant.b * -0.125));
    r.view_mut((0, 0), (m, m)).copy_from(&plant.r);
    r.view_mut((m, m), (m, m)).copy_from(&-&plant.r);
    (b, r)
}

fn units() -> impl Strategy<Value = Units> {
    prop::collection::vec(-1.0..1.0f64, 30).prop_map(|numbers| Units::drawn(&numbers))
}

/// Whether a routine gives the same answer in `units`.
fn unchanged(plant: &Plant, units: &Units, routine: impl Fn(&Plant) -> Result<Answer>) -> Result<(), TestCaseError> {
    let ask = |plant: &Plant| routine(plant).unwrap_or_else(|error| Answer::refused(&error));
    let found = difference(&ask(plant), &ask(&plant.within(units)), units);
    prop_assert!(found.is_none(), "{}", found.unwrap_or_default());
    Ok(())
}

/// What the routine claims: the bound of the error in the plant's first units, and its condition times the rounding in
/// the second ones.
fn claimed(condition: f64, forward_error: f64) -> f64 {
    let rounding = LEFT * condition.max(1.0);
    if forward_error.is_finite() && rounding.is_finite() { rounding.max(forward_error) } else { 1.0 }
}

macro_rules! properties {
    ($($(#[$doc:meta])* $name:ident($plant:ident = $prepared:expr, $units:ident = $of:expr): $routine:expr;)*) => {
        proptest! {
            #![proptest_config(ProptestConfig::with_cases(48))]
            $($(#[$doc])* #[test] fn $name(drawn in plant(), units in units()) {
                let $plant = drawn;
                let prepared = $prepared;
                let $units = units;
                unchanged(&prepared, &$of, $routine)?;
            })*
        }
    };
}

properties! {
    spectra(x = x, u = u): |x| {
        // Defective eigenvalues move by roots of a rounding, their characteristic polynomial does not.
        let values = eigenvalues(&x.a)?;
        let product = values.iter().map(|z| z + 9.0 * rate(x)).product::<Complex<f64>>();
        let scale = rate(x).powi(i32::try_from(values.len()).unwrap_or(0));
        Ok(Answer::verdict("").value(
            &DMatrix::from_element(1, 1, product.re / scale),
            unit((One, 0), (One, 0), 0),
            ACCURATE,
        ))
    };
    observabilities(x = x, u = u): |x| {
        let found = observability(&x.a, &x.c)?;
        let margins = DMatrix::from_iterator(1, found.modes.len(), found.modes.iter().map(|mode| mode.margin));
        Ok(Answer::verdict(format!("{}", found.rank)).value(&margins, unit((One, 0), (One, 0), 0), EXACT))
    };
    observabilities_of_hidden_modes(x = x.hidden(), u = u): |x| {
        let found = observability(&x.a, &x.c)?;
        let hidden: Vec<_> = found.unobservable.iter().map(|mode| mode.eigenvalue).collect();
        Ok(Answer::verdict(format!("{}", found.rank)).spectrum(&hidden, EXACT))
    };
    detectabilities(x = x.hidden(), u = u): |x| {
        let found = detectability(&x.a, &x.c)?;
        Ok(Answer::verdict(format!("{} {}", found.rank, found.is_detectable())))
    };
    discrete_detectabilities(x = x.hidden(), u = u.discrete()): |x| {
        let found = discrete_detectability(&x.a, &x.c)?;
        Ok(Answer::verdict(format!("{} {}", found.rank, found.is_detectable())))
    };
    decompositions(x = x.hidden(), u = u): |x| {
        let found = kalman_decomposition(&x.a, &x.b, &x.c)?;
        Ok(Answer::verdict(format!("{:?}", found.parts().map(|part| part.order))))
    };
    zeros_of_plants(x = x, u = u): |x| {
        let found = invariant_zeros(&x.a, &x.b, &x.c, &DMatrix::zeros(x.c.nrows(), x.b.ncols()))?;
        Ok(Answer::verdict(format!("{} {}", found.normal_rank, found.zeros.len())).spectrum(&beside(&found.zeros, x), ACCURATE))
    };
    zeros_with_feedthrough(x = x, u = u): |x| {
        let found = invariant_zeros(&x.a, &x.b, &x.c, &x.d)?;
        Ok(Answer::verdict(format!("{} {}", found.normal_rank, found.zeros.len())).spectrum(&beside(&found.zeros, x), ACCURATE))
    };
    placements(x = Plant { b: x.b.columns(0, 1).into_owned(), ..x }, u = u): |x| {
        let found = place(&x.a, &x.b, &x.poles)?;
        Ok(Answer::verdict("").value(&found.gain, K, EXACT).spectrum(&found.poles, reached(&found)))
    };
    placements_of_observers(x = Plant { c: x.c.rows(0, 1).into_owned(), ..x }, u = u): |x| {
        let found = place_observer(&x.a, &x.c, &x.poles)?;
        Ok(Answer::verdict("").value(&found.gain, L, EXACT).spectrum(&found.poles, reached(&found)))
    };
    placements_by_several_inputs(x = x, u = u): |x| {
        // The condition that is made small is that in the units given, if these are near to balanced ones.
        let found = place(&x.a, &x.b, &x.poles)?;
        Ok(Answer::verdict("").spectrum(&found.poles, reached(&found)))
    };
    deadbeat_observers(x = x.partly_seen(), u = u): |x| {
        let found = place_observer(&x.a, &x.c, &vec![0.0; x.a.nrows()])?;
        Ok(Answer::verdict("").value(&found.gain, L, EXACT))
    };
    reduced_observers(x = x, u = u): |x| {
        let rank = x.c.nrows().min(x.a.nrows());
        let found = reduced_order_observer(&x.a, &x.b, &x.c, &x.poles[..x.a.nrows() - rank])?;
        // The states of the observer have units of their own.
        Ok(Answer::verdict("")
            .value(&(&found.m * &found.g), unit((State, 1), (Output, -1), -1), EXACT)
            .value(&found.n, unit((State, 1), (Output, -1), 0), EXACT)
            .spectrum(&found.placement.poles, EXACT))
    };
    functional_observers(x = x, u = u): |x| {
        let found = functional_observer(&x.a, &x.b, &x.c, &x.k, &x.poles[..1])?;
        Ok(Answer::verdict("")
            .value(&found.t, unit((One, 1), (State, -1), 0), EXACT)
            .spectrum(&found.placement.poles, EXACT))
    };
    functional_observers_of_least_order(x = x, u = u): |x| {
        let found = least_functional_observer(&x.a, &x.b, &x.c, &x.k, &x.poles)?;
        let order = format!("order {}, {}", found.functions.nrows(), found.is_least);
        Ok(Answer::verdict(order).spectrum(&found.observer.placement.poles, EXACT))
    };
    lyapunov_equations(x = x.stable(), u = u): |x| {
        let found = lyapunov(&x.a.transpose(), &x.w)?;
        Ok(Answer::verdict("").value(&found.p, P, claimed(found.condition, found.forward_error())))
    };
    lyapunov_factors(x = x.stable(), u = Units { output: vec![0; 3], ..u }): |x| {
        let found = lyapunov_factor(&x.a, &x.c)?;
        Ok(Answer::verdict("").value(&found.p(), unit((State, -1), (State, -1), 1), ACCURATE))
    };
    stein_factors(x = x.contracting(), u = Units { output: vec![0; 3], ..u.discrete() }): |x| {
        let found = stein_factor(&x.a, &x.c)?;
        Ok(Answer::verdict("").value(&found.p(), unit((State, -1), (State, -1), 0), ACCURATE))
    };
    stein_equations(x = x.contracting(), u = u.discrete()): |x| {
        let found = stein(&x.a.transpose(), &x.w)?;
        Ok(Answer::verdict("").value(&found.p, P, claimed(found.condition, found.forward_error())))
    };
    generalized_lyapunov_equations(x = x.stable(), u = u): |x| {
        let a = &x.e * &x.a;
        let found = generalized_lyapunov(&a, &x.e, &x.q)?;
        Ok(Answer::verdict("")
            .value(&found.p, unit((Equation, -1), (Equation, -1), 0).cost(1), claimed(found.standard.condition, found.forward_error())))
    };
    generalized_stein_equations(x = x.contracting(), u = u.discrete()): |x| {
        let found = generalized_stein(&(&x.e * &x.a), &x.e, &x.q)?;
        Ok(Answer::verdict("")
            .value(&found.p, unit((Equation, -1), (Equation, -1), 0).cost(1), claimed(found.standard.condition, found.forward_error())))
    };
    sylvester_equations(x = x, u = u): |x| {
        // `A X + X F = B` with F of the inputs' order in units of the inputs.
        let found = sylvester(&x.a, &(x.r.clone() * 0.0 + DMatrix::identity(x.b.ncols(), x.b.ncols()) * rate(x)), &x.b)?;
        Ok(Answer::verdict("").value(&found.x, unit((State, 1), (Input, -1), 0), claimed(found.condition, found.forward_error())))
    };
    regulators(x = x, u = u): |x| {
        let found = care(&x.a, &x.b, &x.q, &x.r)?;
        Ok(Answer::verdict("")
            .value(&found.x, X, claimed(found.condition, found.forward_error))
            .value(&found.k, K, claimed(found.condition, found.forward_error))
            .spectrum(&found.poles, claimed(found.condition, found.forward_error)))
    };
    discrete_regulators(x = x, u = u.discrete()): |x| {
        let found = dare(&x.a, &x.b, &x.q, &x.r)?;
        Ok(Answer::verdict("")
            .value(&found.x, X, claimed(found.condition, found.forward_error))
            .value(&found.k, K, claimed(found.condition, found.forward_error)))
    };
    regulators_of_indefinite_weight(x = x, u = u): |x| {
        let (b, r) = opposed(x);
        let found = care(&x.a, &b, &x.q, &r)?;
        let claimed = claimed(found.condition, found.forward_error);
        Ok(Answer::verdict("")
            .value(&found.x, X, claimed)
            .value(&found.k.rows(0, x.b.ncols()).into_owned(), K, claimed)
            .spectrum(&found.poles, claimed))
    };
    discrete_regulators_of_indefinite_weight(x = x, u = u.discrete()): |x| {
        let (b, r) = opposed(x);
        let found = dare(&x.a, &b, &x.q, &r)?;
        let claimed = claimed(found.condition, found.forward_error);
        Ok(Answer::verdict("").value(&found.x, X, claimed).value(&found.k.rows(0, x.b.ncols()).into_owned(), K, claimed))
    };
    filters(x = x, u = u): |x| {
        let found = kalman_gain(&x.a, &x.c, &x.w, &x.v)?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    filters_of_hidden_modes(x = x.hidden(), u = u): |x| {
        let found = kalman_gain(&x.a, &x.c, &x.w, &x.v)?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    discrete_filters(x = x, u = u.discrete()): |x| {
        let found = discrete_kalman_gain(&x.a, &x.c, &x.w, &x.v)?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    /// Modes of time constants up to 1e9, those hidden where the output has a negative entry, with a full W: only the
    /// weights tie a hidden mode to the others.
    filters_of_slow_hidden_modes(x = x.slow(), u = u): |x| {
        let found = kalman_gain(&x.a, &x.c, &x.w, &x.v)?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    correlated_filters(x = x, u = u): |x| {
        let found = correlated_kalman_gain(&x.a, &x.c, &x.w, &x.v, &cross(x))?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    discrete_correlated_filters(x = x, u = u.discrete()): |x| {
        let found = discrete_correlated_kalman_gain(&x.a, &x.c, &x.w, &x.v, &cross(x))?;
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, claimed(found.condition, found.forward_error)))
    };
    discrete_regulators_without_a_minimum(x = x.contracting(), u = u.discrete()): |x| {
        // For one input and X = -40 Q or so: with a small A, `R + B'X B < 0` where B is not small.
        let found = dare(&(&x.a * 0.1), &x.b.columns(0, 1).into_owned(), &(&x.q * -40.0), &x.r.view((0, 0), (1, 1)).into_owned())?;
        Ok(Answer::verdict("")
            .value(&found.x, X, claimed(found.condition, found.forward_error))
            .value(&found.k, unit((Input, 1), (State, -1), 0), claimed(found.condition, found.forward_error)))
    };
    discrete_filters_without_noise(x = x, u = u.discrete()): |x| {
        let found = discrete_kalman_gain(&x.a, &x.c, &x.w, &(&x.v * 0.0))?;
        // The gain has the condition of C P C' too.
        Ok(Answer::verdict("")
            .value(&found.p, P, claimed(found.condition, found.forward_error))
            .value(&found.l, L, 100.0 * claimed(found.condition, found.forward_error)))
    };
    generalized_regulators(x = x, u = u): |x| {
        let found = generalized_care(&(&x.e * &x.a), &(&x.e * &x.b), &x.q, &x.r, &x.s, &x.e)?;
        Ok(Answer::verdict("")
            .value(&found.x, unit((Equation, -1), (Equation, -1), 0).cost(1), claimed(found.condition, found.forward_error))
            .value(&found.k, K, claimed(found.condition, found.forward_error)))
    };
    generalized_discrete_regulators(x = x, u = u.discrete()): |x| {
        let found = generalized_dare(&(&x.e * &x.a), &(&x.e * &x.b), &x.q, &x.r, &x.s, &x.e)?;
        Ok(Answer::verdict("")
            .value(&found.x, unit((Equation, -1), (Equation, -1), 0).cost(1), claimed(found.condition, found.forward_error))
            .value(&found.k, K, claimed(found.condition, found.forward_error)))
    };
    exponentials(x = x, u = u): |x| {
        let found = zero_order_hold(&x.a, &x.b, x.h)?;
        Ok(Answer::verdict("")
            .value(&found.ad, unit((State, 1), (State, -1), 0), ACCURATE)
            .value(&found.bd, unit((State, 1), (Input, -1), 0), ACCURATE))
    };
    exponentials_of_fast_plants(x = Plant { h: 100.0, ..x.stable() }, u = u): |x| {
        Ok(Answer::verdict("").value(&expm(&(&x.a * x.h))?, unit((State, 1), (State, -1), 0), ACCURATE))
    };
    held_observers(x = x, u = u): |x| {
        let found = zero_order_hold_observer(&x.a, &x.b, &x.l, &x.c, x.h)?;
        Ok(Answer::verdict("")
            .value(&found.fd, unit((State, 1), (State, -1), 0), ACCURATE)
            .value(&found.bd, unit((State, 1), (Input, -1), 0), ACCURATE)
            .value(&found.ld, unit((State, 1), (Output, -1), 0), ACCURATE))
    };
    noise_of_a_period(x = x, u = u): |x| {
        let qd = discrete_process_noise(&x.a, &x.w, x.h)?;
        let back = continuous_process_noise(&x.a, &qd, x.h)?;
        Ok(Answer::verdict("").value(&qd, P, ACCURATE).value(&back, W, 1e-8))
    };
    matched_conversions(x = Plant { b: x.b.columns(0, 1).into_owned(), c: x.c.rows(0, 1).into_owned(),
        d: x.d.view((0, 0), (1, 1)).into_owned(), ..x }, u = u):
        |x| {
            let found = c2d_matched(&Realization::new(&x.a, &x.b, &x.c, &x.d)?, x.h)?;
            // The multiset of images has no unit: its product tells.
            let all = |list: &[Complex<f64>]| list.iter().map(|z| z + 2.0).product::<Complex<f64>>().re;
            Ok(Answer::verdict(format!("{} {}", found.zeros.len(), found.poles.len()))
                .value(&DMatrix::from_element(1, 1, found.gain), D, ACCURATE)
                .value(&DMatrix::from_row_slice(1, 2, &[all(&found.zeros), all(&found.poles)]), unit((One, 0), (One, 0), 0), ACCURATE))
        };
    norms(x = x.stable(), u = u.common()): |x| {
        let (two, infinite) = (h2_norm(&x.a, &x.b, &x.c)?, h_infinity_norm(&x.a, &x.b, &x.c, &x.d)?);
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        Ok(Answer::verdict(format!("{}", infinite.frequency.is_finite()))
            .value(&one(two * two), unit((Output, 2), (Input, -2), -1), ACCURATE)
            .value(&one(infinite.norm), D, 2e-9))
    };
    discrete_norms(x = x.contracting(), u = u.common().discrete()): |x| {
        let (two, infinite) =
            (discrete_h2_norm(&x.a, &x.b, &x.c)?, discrete_h_infinity_norm(&x.a, &x.b, &x.c, &x.d)?);
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        Ok(Answer::verdict("").value(&one(two), D, ACCURATE).value(&one(infinite.norm), D, 2e-9))
    };
}

/// A cross-intensity of the noises, `L V/10`, small enough beside W.
fn cross(plant: &Plant) -> DMatrix<f64> {
    &plant.l * &plant.v * 0.1
}

/// Frequencies beside one of the size of the plant: a zero at 0 is computed as rounding of that.
fn beside(zeros: &[Complex<f64>], plant: &Plant) -> Vec<Complex<f64>> {
    zeros.iter().copied().chain([Complex::from(rate(plant))]).collect()
}

/// The accuracy of the poles of a placement.
fn reached(found: &Placement) -> f64 {
    let largest = |list: &mut dyn Iterator<Item = f64>| list.fold(0.0, f64::max);
    let size = largest(&mut found.poles.iter().map(|pole| pole.norm()));
    10.0 * largest(&mut found.errors.iter().copied()) / size + 1e-14
}

/// A rate in the plant's unit of time.
fn rate(plant: &Plant) -> f64 {
    0.3 / plant.h
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Past inputs and outputs as states: the response to a pulse, sample by sample.
    #[test]
    fn delayed_conversions(x in plant(), units in units()) {
        let routine = |x: &Plant| {
            let system = Realization::new(&x.a, &x.b, &x.c, &x.d)?;
            let late = |count: usize, first: f64| (0..count).map(|k| (first + 0.5 * k as f64) * x.h).collect::<Vec<_>>();
            let model = c2d_delayed(&system, x.h, &late(x.b.ncols(), 1.25), &late(x.c.nrows(), 0.5))?;
            let mut answer = Answer::verdict(format!("{}", model.a.nrows())).value(&model.d, D, ACCURATE);
            let mut driven = model.b.clone();
            for _ in 0..6 {
                // Beside the response of the plant itself, since one that is not yet there is zero.
                let size = &x.c * zero_order_hold(&x.a, &x.b, x.h)?.bd + &x.d;
                answer = answer.value(&(&model.c * &driven + size), D, ACCURATE);
                driven = &model.a * driven;
            }
            Ok(answer)
        };
        unchanged(&x, &units, routine)?;
    }

    /// All methods, there and back.
    #[test]
    fn conversions(x in plant(), units in units()) {
        for method in [
            Discretization::ZeroOrderHold,
            Discretization::FirstOrderHold,
            Discretization::Impulse,
            Discretization::Tustin,
        ] {
            let routine = |x: &Plant| {
                let sampled = c2d(&Realization::new(&x.a, &x.b, &x.c, &x.d)?, x.h, method)?;
                // The states of the trapezoidal rule have their own convention: h is in B, not in C.
                let held = unit((State, 1), (State, -1), 0);
                let back = d2c(&sampled, x.h, method)?;
                Ok(Answer::verdict("")
                    .value(&sampled.a, held, ACCURATE)
                    .value(&sampled.b, unit((State, 1), (Input, -1), 0), ACCURATE)
                    .value(&sampled.d, D, ACCURATE)
                    .value(&back.a, A, 1e-8)
                    .value(&back.b, B, 1e-8))
            };
            unchanged(&x, &units, routine)?;
        }
    }
}
