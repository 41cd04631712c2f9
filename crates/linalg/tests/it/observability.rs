//! What is hidden is found, named and pointed at; what is seen is not called hidden, in any units.

use approx::assert_relative_eq;
use luenberger_linalg::{
    LinalgError, Mode, StabilityRegion, detectability, discrete_detectability, observability, observability_within,
};
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use proptest::prelude::*;

fn complex(m: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    m.map(Complex::from)
}

/// `|A v - lambda v|` and `|C v|` of a unit vector, states in the units given.
fn hidden_residual(a: &DMatrix<f64>, c: &DMatrix<f64>, mode: &Mode) -> f64 {
    let v = &mode.direction;
    (complex(a) * v - v * mode.eigenvalue).norm().hypot((complex(c) * v).norm())
}

/// The same row by row in units `2^d`: each row relative to the terms that a vector of this size has in it.
fn residual_by_rows(a: &DMatrix<f64>, c: &DMatrix<f64>, mode: &Mode, d: &[i32]) -> f64 {
    let v = &mode.direction;
    let sizes = in_units(&v.map(Complex::norm), d);
    let (motion, trace) = (complex(a) * v - v * mode.eigenvalue, complex(c) * v);
    let (terms_a, terms_c) = (a.abs() * &sizes + &sizes * mode.eigenvalue.norm(), c.abs() * &sizes);
    let ratios = motion.iter().zip(terms_a.iter()).chain(trace.iter().zip(terms_c.iter()));
    ratios.map(|(x, size)| if *size > 0.0 { x.norm() / size } else { x.norm() }).fold(0.0, f64::max)
}

/// The vector all of whose entries are, in units `2^d`, as large as the largest of `v`.
fn in_units(v: &DVector<f64>, d: &[i32]) -> DVector<f64> {
    let unit = |j: usize| 2f64.powi(d[j]);
    let largest = (0..v.len()).map(|j| v[j].abs() / unit(j)).fold(0.0, f64::max);
    DVector::from_fn(v.len(), |j, _| largest * unit(j))
}

#[test]
fn the_double_integrator_from_either_state() {
    let a = dmatrix![0.0, 1.0; 0.0, 0.0];
    assert!(observability(&a, &dmatrix![1.0, 0.0]).unwrap().is_observable());
    let blind = observability(&a, &dmatrix![0.0, 1.0]).unwrap();
    assert_eq!((blind.rank, blind.unobservable.len()), (1, 1));
    assert_eq!(blind.unobservable[0].eigenvalue, Complex::from(0.0));
    assert!(
        (&blind.unobservable[0].direction - DVector::from_vec(vec![Complex::from(1.0), Complex::from(0.0)])).norm()
            < 1e-15
    );
    assert!((blind.subspace.map(f64::abs) - dmatrix![1.0; 0.0]).norm() < 1e-15);
    assert!(!detectability(&a, &dmatrix![0.0, 1.0]).unwrap().is_detectable());
}

/// A Jordan block seen through its last coordinate only hides the chain in front of it, all of it at one eigenvalue.
/// `[A - 0 I; C]` of the double integrator has the columns (0, 0, 1) and (1, 0, 0): both directions are alike. With two
/// different oscillators one output sees each mode in one direction alone; the same one twice, seen by two outputs, in
/// two.
#[test]
fn directions_that_are_alike_are_counted() {
    let seen = observability(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![1.0, 0.0]).unwrap();
    assert!(seen.modes.iter().all(|mode| mode.directions == 2), "{:?}", seen.modes);
    let two = |stiffness: f64| dmatrix![0.0, 1.0, 0.0, 0.0; -1.0, 0.0, 0.0, 0.0; 0.0, 0.0, 0.0, 1.0; 0.0, 0.0, -stiffness, 0.0];
    let (one, both) = (dmatrix![1.0, 0.0, 1.0, 0.0], dmatrix![1.0, 0.0, 0.0, 0.0; 0.0, 0.0, 1.0, 0.0]);
    let counts = |a: &DMatrix<f64>, c: &DMatrix<f64>| {
        observability(a, c).unwrap().modes.iter().map(|mode| mode.directions).collect::<Vec<_>>()
    };
    assert_eq!(counts(&two(4.0), &one), [1; 4]);
    assert_eq!(counts(&two(1.0), &both), [2; 4]);
}

#[test]
fn a_defective_hidden_part() {
    let a = dmatrix![-1.0, 1.0, 0.0; 0.0, -1.0, 1.0; 0.0, 0.0, -1.0];
    let seen = observability(&a, &dmatrix![0.0, 0.0, 1.0]).unwrap();
    assert_eq!(seen.rank, 1);
    for mode in &seen.unobservable {
        assert!((mode.eigenvalue + 1.0).norm() < 1e-7, "{}", mode.eigenvalue);
        assert!(hidden_residual(&a, &dmatrix![0.0, 0.0, 1.0], mode) < 1e-7);
    }
    assert!(detectability(&a, &dmatrix![0.0, 0.0, 1.0]).unwrap().is_detectable());
}

/// Derogatory: two copies of one eigenvalue need two outputs.
#[test]
fn a_derogatory_plant_needs_as_many_outputs_as_copies() {
    let a = DMatrix::identity(2, 2) * -3.0;
    let one = observability(&a, &dmatrix![1.0, 2.0]).unwrap();
    assert_eq!(one.rank, 1);
    assert!(hidden_residual(&a, &dmatrix![1.0, 2.0], &one.unobservable[0]) < 1e-15);
    assert!(observability(&a, &dmatrix![1.0, 2.0; 1.0, -1.0]).unwrap().is_observable());
}

#[test]
fn margins_of_a_symmetric_pair_by_hand() {
    // Time is read in halves, A = diag(0.5, 1): the columns of [A - lambda I; C] are orthogonal, the shortest of length
    // one.
    let seen = observability(&dmatrix![1.0, 0.0; 0.0, 2.0], &dmatrix![1.0, 0.0; 0.0, 1.0]).unwrap();
    let expected = 1.0 / (0.25f64 + 1.0 + 1.0 + 1.0).sqrt();
    for mode in &seen.modes {
        // The two singular values are 1 and 1.118: the iteration stops when the margin rests, to six digits.
        assert_relative_eq!(mode.margin, expected, max_relative = 1e-5);
    }
}

#[test]
fn no_outputs_and_zero_plants() {
    let a = dmatrix![-1.0, 2.0; 0.0, -3.0];
    let blind = observability(&a, &DMatrix::zeros(0, 2)).unwrap();
    assert_eq!((blind.rank, blind.unobservable.len(), blind.subspace.shape()), (0, 2, (2, 2)));
    assert!(detectability(&a, &DMatrix::zeros(0, 2)).unwrap().is_detectable());
    assert!(!discrete_detectability(&a, &DMatrix::zeros(1, 2)).unwrap().is_detectable());
    let zero = observability(&DMatrix::zeros(2, 2), &DMatrix::zeros(1, 2)).unwrap();
    assert_eq!(zero.rank, 0);
    assert!(observability(&DMatrix::zeros(2, 2), &DMatrix::identity(2, 2)).unwrap().is_observable());
    assert!(observability(&dmatrix![5.0], &dmatrix![1e-200]).unwrap().is_observable());
}

#[test]
fn bad_input_is_named() {
    let (a, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0]);
    assert_eq!(
        observability(&a, &dmatrix![1.0, 0.0, 0.0]).unwrap_err(),
        LinalgError::DimensionMismatch { what: "C", expected: (1, 2), found: (1, 3) }
    );
    assert!(matches!(observability(&c, &c), Err(LinalgError::NotSquare { what: "A", rows: 1, cols: 2 })));
    let nan = observability(&a, &dmatrix![1.0, f64::NAN]);
    assert!(matches!(nan, Err(LinalgError::NotFinite { what: "C", row: 0, col: 1, .. })));
    assert_eq!(
        detectability(&DMatrix::zeros(0, 0), &DMatrix::zeros(1, 0)).unwrap_err(),
        LinalgError::Empty { what: "A" }
    );
    assert_eq!(observability_within(&a, &c, -1.0).unwrap_err(), LinalgError::InvalidTolerance { tolerance: -1.0 });
}

#[test]
fn the_boundary_counts_as_not_decaying() {
    let oscillator = dmatrix![0.0, 3.0, 0.0; -3.0, 0.0, 0.0; 0.0, 0.0, -1.0];
    let c = dmatrix![0.0, 0.0, 1.0];
    let d = detectability(&oscillator, &c).unwrap();
    assert_eq!((d.region, d.undetectable_modes.len(), d.rank), (StabilityRegion::LeftHalfPlane, 2, 1));
    let rotation = dmatrix![0.6, 0.8, 0.0; -0.8, 0.6, 0.0; 0.0, 0.0, 2.0];
    assert_eq!(discrete_detectability(&rotation, &c).unwrap().undetectable_modes.len(), 2);
    assert!(discrete_detectability(&(rotation * 0.49), &c).unwrap().is_detectable());
}

/// A chain of integrators in units 24 decades apart, as in a plant of volts and nanometres.
#[test]
fn a_chain_in_extreme_units_is_observable() {
    let a = dmatrix![0.0, 1e12, 0.0; 0.0, 0.0, 1e-12; 0.0, 0.0, 0.0];
    let seen = observability(&a, &dmatrix![1e-9, 0.0, 0.0]).unwrap();
    assert!(seen.is_observable());
    assert!(seen.weakest().unwrap().margin > 0.01, "{seen:?}");
}

/// Modal coordinates as an eigenvalue routine returns them: what should be zero is 1e-16, more often than not, and must
/// not count.
#[test]
fn rounding_noise_in_modal_coordinates_is_no_output() {
    let a = dmatrix![-1.0, 1e-16, -2e-16; 3e-16, -2.0, 1e-16; -1e-16, 2e-16, -3.0];
    let seen = observability(&a, &dmatrix![1.0, 2.0, 1e-16]).unwrap();
    assert_eq!(seen.rank, 2);
    assert!((seen.unobservable[0].eigenvalue + 3.0).norm() < 1e-14);
    assert!(observability(&a, &dmatrix![1.0, 2.0, 0.5]).unwrap().is_observable());
}

/// Time in nanoseconds or years.
#[test]
fn the_unit_of_time_does_not_matter() {
    let (a, c) = (dmatrix![-1.0, 0.3, 0.2; 0.5, -0.1, 2.0; 1.0, -0.7, 0.4], dmatrix![1.0, -0.5, 0.3]);
    let hidden = (dmatrix![-1.0, 0.0; 0.7, 2.0], dmatrix![3.0, 0.0]);
    let margin = observability(&a, &c).unwrap().weakest().unwrap().margin;
    for power in [-40, -7, 7, 40] {
        let unit = 2f64.powi(power);
        let seen = observability(&(&a * unit), &c).unwrap();
        assert!(seen.is_observable());
        assert!((seen.weakest().unwrap().margin - margin).abs() < 1e-12, "{power}");
        let found = detectability(&(&hidden.0 * unit), &hidden.1).unwrap();
        assert_eq!(found.undetectable_modes.len(), 1);
        assert!((found.undetectable_modes[0].eigenvalue - 2.0 * unit).norm() < 1e-14 * unit);
    }
}

/// Almost hidden: the margin follows the coupling, down to the tolerance and not below.
#[test]
fn the_margin_measures_the_coupling() {
    // Modes -1, -2 in coordinates turned by 45 degrees, the second seen with strength delta only.
    for exponent in 1..=16 {
        let delta = 10f64.powi(-exponent);
        let (a, c) = (dmatrix![-1.5, 0.5; 0.5, -1.5], dmatrix![1.0 + delta, 1.0 - delta]);
        let seen = observability(&a, &c).unwrap();
        if exponent <= 13 {
            let margin = seen.weakest().unwrap().margin;
            assert!(seen.is_observable() && margin > 0.05 * delta && margin < delta, "{delta:e}: {margin:e}");
        }
        if exponent == 16 {
            assert_eq!(seen.rank, 1);
        }
    }
    let (a, c) = (dmatrix![-1.5, 0.5; 0.5, -1.5], dmatrix![1.0001, 0.9999]);
    assert_eq!(observability_within(&a, &c, 1e-3).unwrap().rank, 1);
}

/// Orthogonal from any vectors: a product of reflections.
fn orthogonal(n: usize, seeds: &[f64]) -> DMatrix<f64> {
    let mut q = DMatrix::identity(n, n);
    for chunk in seeds.chunks_exact(n) {
        let v = DVector::from_fn(n, |i, _| chunk[i] + if i == 0 { 1.5 } else { 0.0 });
        q -= (&q * &v) * v.transpose() * (2.0 / v.norm_squared());
    }
    q
}

#[derive(Debug, Clone)]
struct Pair {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    /// Powers of two: units of the states and outputs.
    states: Vec<i32>,
    outputs: Vec<i32>,
}

impl Pair {
    fn in_units(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let power = |e: i32| 2f64.powi(e);
        let (s, o) = (&self.states, &self.outputs);
        (
            DMatrix::from_fn(self.a.nrows(), self.a.ncols(), |i, j| self.a[(i, j)] * power(s[j] - s[i])),
            DMatrix::from_fn(self.c.nrows(), self.c.ncols(), |i, j| self.c[(i, j)] * power(s[j] - o[i])),
        )
    }
}

impl Pair {
    /// `A -> D^-1 A D` takes v to `D^-1 v`.
    fn in_units_of_v(&self) -> Vec<i32> {
        self.states.iter().map(|e| -e).collect()
    }
}

/// Observable by construction, in coordinates that do not show it: the first output sees the first state, each state
/// drives the one before it. With `hidden` states more that drive nothing, their block given.
fn pair(hidden: Option<DMatrix<f64>>) -> impl Strategy<Value = Pair> {
    let h = hidden.as_ref().map_or(0, DMatrix::nrows);
    (1usize..=5, 1usize..=3).prop_flat_map(move |(seen, p)| {
        let (n, hidden) = (seen + h, hidden.clone());
        let unit = || -1.0..1.0f64;
        (
            prop::collection::vec(unit(), n * n),
            prop::collection::vec(unit(), p * n),
            prop::collection::vec(unit(), 2 * n),
            prop::collection::vec(-40i32..=40, n),
            prop::collection::vec(-40i32..=40, p),
        )
            .prop_map(move |(x, y, q, states, outputs)| {
                let a = DMatrix::from_fn(n, n, |i, j| {
                    let free = x[i * n + j];
                    match (i < seen, j < seen) {
                        (true, true) if j == i + 1 => free.signum() * (1.0 + free.abs()),
                        (true, true) if j > i + 1 => 0.0,
                        (_, true) => free,
                        (true, false) => 0.0,
                        (false, false) => hidden.as_ref().map_or(0.0, |b| b[(i - seen, j - seen)]),
                    }
                });
                let c = DMatrix::from_fn(p, n, |i, j| match (i, j) {
                    (_, j) if j >= seen => 0.0,
                    (0, 0) => 1.0,
                    (0, _) => 0.0,
                    _ => y[i * n + j],
                });
                let q = orthogonal(n, &q);
                Pair { a: &q * a * q.transpose(), c: c * q.transpose(), states, outputs }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Observable pairs are observable, in all units up to 2^40 (12 decades) either way.
    #[test]
    fn an_observable_pair_is_observable_in_all_units(pair in pair(None)) {
        prop_assert!(observability(&pair.a, &pair.c).unwrap().is_observable());
        let (a, c) = pair.in_units();
        let seen = observability(&a, &c).unwrap();
        prop_assert!(seen.is_observable(), "rank {} in units {:?}", seen.rank, seen.units);
        prop_assert_eq!(seen.modes.len(), a.nrows());
        prop_assert_eq!(seen.subspace.ncols(), 0);
    }

    /// A hidden pair of modes is found with its eigenvalues and directions, in all units; theorem of Popov, Belevitch,
    /// Hautus.
    #[test]
    fn hidden_modes_are_named_in_all_units(
        (pair, re, im) in (-2.0..1.0f64, 0.1..2.0f64).prop_flat_map(|(re, im)| {
            (pair(Some(dmatrix![re, im; -im, re])), Just(re), Just(im))
        })
    ) {
        let plain = vec![0; pair.states.len()];
        for ((a, c), units) in [((pair.a.clone(), pair.c.clone()), &plain), (pair.in_units(), &pair.in_units_of_v())] {
            let seen = observability(&a, &c).unwrap();
            prop_assert_eq!(seen.rank, seen.order - 2);
            for (mode, sign) in seen.unobservable.iter().zip([1.0, -1.0]) {
                let sign = sign * seen.unobservable[0].eigenvalue.im.signum();
                prop_assert!((mode.eigenvalue - Complex::new(re, sign * im)).norm() < 1e-12);
                prop_assert!((mode.direction.norm() - 1.0).abs() < 1e-14);
                let residual = residual_by_rows(&a, &c, mode, units);
                prop_assert!(residual < 1e-11, "{} along {}: {residual:e}", mode.eigenvalue, mode.direction);
                prop_assert!(mode.margin < seen.tolerance);
            }
            let d = detectability(&a, &c).unwrap();
            prop_assert_eq!(d.is_detectable(), re < -d.boundary);
            let d = discrete_detectability(&a, &c).unwrap();
            prop_assert_eq!(d.is_detectable(), re.hypot(im) < 1.0 - d.boundary);
        }
    }

    /// The subspace is orthonormal, invariant and invisible.
    #[test]
    fn the_unobservable_subspace_is_invariant_and_invisible(
        pair in prop::collection::vec(-1.0..1.0f64, 9).prop_flat_map(|b| pair(Some(DMatrix::from_vec(3, 3, b))))
    ) {
        let seen = observability(&pair.a, &pair.c).unwrap();
        let v = &seen.subspace;
        prop_assert_eq!(v.ncols(), 3);
        prop_assert!((v.transpose() * v - DMatrix::identity(3, 3)).norm() < 1e-13);
        prop_assert!((&pair.c * v).norm() < 1e-12);
        let image = &pair.a * v;
        prop_assert!((&image - v * (v.transpose() * &image)).norm() < 1e-12);
        // In extreme units: the same space, read row by row.
        let (a, c) = pair.in_units();
        let v = observability(&a, &c).unwrap().subspace;
        prop_assert_eq!(v.ncols(), 3);
        for column in v.column_iter() {
            let column = column.into_owned();
            let (visible, terms) = (&c * &column, c.abs() * in_units(&column, &pair.in_units_of_v()));
            prop_assert!(visible.iter().zip(terms.iter()).all(|(x, t)| x.abs() <= 1e-10 * t), "{visible} of {terms}");
        }
    }

    /// The margin is the smallest singular value it is said to be: no larger than at the direction given, and no
    /// smaller than what the other directions allow (a lower bound from the normal matrix).
    #[test]
    fn the_margins_are_smallest_singular_values(pair in pair(None)) {
        let seen = observability(&pair.a, &pair.c).unwrap();
        let n = seen.order;
        let exponents: Vec<i32> = seen.units.iter().map(|d| d.log2() as i32).collect();
        // Only pairs read in the units given can be checked against the pair given.
        if exponents.iter().any(|e| *e != exponents[0]) {
            return Ok(());
        }
        // Time and outputs are read in the powers of two nearest to their largest entries.
        let unit = |size: f64| if size > 0.0 { 2f64.powf(size.log2().round()) } else { 1.0 };
        let time = unit(pair.a.amax());
        for mode in &seen.modes {
            let stacked = DMatrix::from_fn(n + pair.c.nrows(), n, |i, j| {
                if i < n {
                    (Complex::from(pair.a[(i, j)]) - if i == j { mode.eigenvalue } else { Complex::from(0.0) }) / time
                } else {
                    Complex::from(pair.c[(i - n, j)] / unit(pair.c.row(i - n).amax()))
                }
            });
            let attained = (&stacked * &mode.direction).norm();
            let gram = stacked.adjoint() * &stacked;
            let least = gram.symmetric_eigenvalues().min().max(0.0).sqrt();
            prop_assert!(attained <= 1.01 * least + 1e-6, "{attained:e} where {least:e} is possible");
        }
    }
}
