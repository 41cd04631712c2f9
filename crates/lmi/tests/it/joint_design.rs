//! The joint design of the cubic observer in (P, Y = P L, Z = P N) on random plants.

use luenberger_lmi::{Problem, Solution, Variable, he};
use luenberger_proof::Verdict;
use luenberger_random::Random;
use nalgebra::DMatrix;
use proptest::prelude::*;

fn plant(n: usize, p: usize, seed: u64) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut random = Random(seed);
    (random.matrix(n, n), random.matrix(p, n))
}

/// P > 0, P < I, A'P + PA - YC - C'Y' < 0, and Z = -C'S with S + S' > 0, which is what `Z C + C'Z' <= 0` means for C of
/// full row rank.
fn design(a: &DMatrix<f64>, c: &DMatrix<f64>) -> (Problem, Variable, Variable, Variable) {
    let (n, m) = (a.nrows(), c.nrows());
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", n);
    let y = lmi.rectangular("Y", n, m);
    let s = lmi.rectangular("S", m, m);
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("P < I", &p << 1.0);
    lmi.constrain("decrease", he(&p * a - &y * c) << 0.0);
    lmi.constrain("accretive", he(&s) >> 0.0);
    (lmi, p, y, s)
}

fn check(a: &DMatrix<f64>, c: &DMatrix<f64>, solution: &Solution, p: &Variable, y: &Variable) -> Result<(), String> {
    let Verdict::Proved { margin } = solution.verdict else {
        return Err(format!("{:?} {:?}", solution.verdict, solution.effort));
    };
    let (p, y) = (solution.value(p), solution.value(y));
    let decrease = p.clone() * a - y * c;
    let decrease = -(&decrease + decrease.transpose());
    let n = a.nrows() as f64;
    // The proved margin is below what another eigenvalue routine computes, whose error is n eps times the norm.
    let slack = 100.0 * n * f64::EPSILON * decrease.norm();
    let seen = decrease.symmetric_eigenvalues().min().min(p.symmetric_eigenvalues().min());
    if margin <= seen + slack { Ok(()) } else { Err(format!("margin {margin} seen {seen}")) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// A random pair is observable, so the joint inequality is feasible, and the layer proves it.
    #[test]
    fn the_joint_design_is_proved(seed: u64, n in 2usize..=8, m in 1usize..=3) {
        let m = m.min(n);
        let (a, c) = plant(n, m, seed);
        let (lmi, p, y, _) = design(&a, &c);
        let solution = lmi.solve().unwrap();
        prop_assert_eq!(check(&a, &c, &solution, &p, &y), Ok(()));
    }

    /// Strictly, `Z C + C'Z' < 0` is impossible as soon as C has a kernel: v in ker C gives v'(..)v = 0. The witness
    /// lives there.
    #[test]
    fn the_strict_form_is_refuted(seed: u64, n in 2usize..=5, m in 1usize..=2) {
        let m = m.min(n - 1);
        let (a, c) = plant(n, m, seed);
        let (mut lmi, ..) = design(&a, &c);
        let z = lmi.rectangular("Z", n, m);
        lmi.constrain("strict", he(&z * &c) << 0.0);
        let solution = lmi.solve().unwrap();
        let Verdict::Refuted { witness } = solution.verdict else {
            return Err(TestCaseError::fail(format!("{:?}", solution.verdict)));
        };
        prop_assert!(lmi.is_refuted_by(&witness));
        prop_assert_eq!(witness.multipliers.len(), 1);
        prop_assert_eq!(&witness.multipliers[0].constraint, "strict");
        let along = &c * &witness.multipliers[0].z;
        prop_assert!(along.amax() < 1e-12, "the multiplier lies in the kernel of C: {}", along);
    }

    /// An unstable unobservable mode: no P, Y exist, whatever the rest of the plant. Here A is block triangular.
    #[test]
    fn an_undetectable_plant_is_refuted(seed: u64, n in 1usize..=4, rate in 0.0f64..2.0) {
        let (a, c) = plant(n, 1, seed);
        let hidden = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)],
            (false, false) => rate,
            (false, true) => a[(i.min(n - 1), j)],
            (true, false) => 0.0,
        });
        let c = DMatrix::from_fn(1, n + 1, |_, j| if j < n { c[(0, j)] } else { 0.0 });
        let (lmi, ..) = design(&hidden, &c);
        let solution = lmi.solve().unwrap();
        let Verdict::Refuted { witness } = &solution.verdict else {
            return Err(TestCaseError::fail(format!("{:?} {:?}", solution.verdict, solution.effort)));
        };
        prop_assert!(lmi.is_refuted_by(witness));
    }
}

/// The size at which cvxpy with the same solver gives up.
#[test]
fn twenty_states_and_three_outputs_are_proved() {
    let (a, c) = plant(20, 3, 2024);
    let (lmi, p, y, _) = design(&a, &c);
    let solution = lmi.solve().unwrap();
    assert_eq!(check(&a, &c, &solution, &p, &y), Ok(()));
}

/// Volts, microamperes and megapascals: a random plant whose states are measured in units from 1e-6 to 1e6.
#[test]
fn a_badly_scaled_plant_is_proved() {
    for seed in 0..4 {
        let (a, c) = plant(4, 1, seed);
        let unit = |i: usize| [1e-6, 1e3, 1.0, 1e6][i];
        let a = DMatrix::from_fn(4, 4, |i, j| a[(i, j)] * unit(j) / unit(i));
        let c = DMatrix::from_fn(1, 4, |_, j| c[(0, j)] * unit(j));
        for normalised in [false, true] {
            let mut lmi = Problem::new();
            let p = lmi.symmetric("P", 4);
            let y = lmi.rectangular("Y", 4, 1);
            lmi.constrain("P > 0", &p >> 0.0);
            lmi.constrain("decrease", he(&p * &a - &y * &c) << 0.0);
            if normalised {
                lmi.constrain("P < I", &p << 1.0);
            }
            let solution = lmi.solve().unwrap();
            assert!(solution.verdict.is_proved(), "seed {seed}: {:?} {:?}", solution.verdict, solution.margins);
        }
    }
}
