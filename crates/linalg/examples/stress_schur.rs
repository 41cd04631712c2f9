//! Schur forms of a million small random matrices, orders one to eight: the worst backward error and loss of
//! orthogonality in units of `n eps`, and how many are beyond 50. Arguments: how many, and the seed.
//!
//! `cargo run --release -p luenberger-linalg --example stress_schur`

#[path = "../tests/it/small_matrices/mod.rs"]
mod small_matrices;

use luenberger_linalg::{LinalgError, Schur, SchurWorkspace, schur_into};
use luenberger_random::Random;
use nalgebra::DMatrix;

fn main() -> Result<(), LinalgError> {
    let mut arguments = std::env::args().skip(1).map(|s| s.parse::<u64>().ok());
    let count = arguments.next().flatten().unwrap_or(1_000_000);
    let seed = arguments.next().flatten().unwrap_or(1);
    let mut random = Random(seed);
    let (mut found, mut workspace) = (Schur::default(), SchurWorkspace::new());
    let (mut worst, mut failures) = ([0.0_f64; 2], 0);
    for _ in 0..count {
        let n = 1 + random.below(8);
        let a = small_matrices::matrix(&mut random, n);
        let scale = a.amax();
        if scale == 0.0 {
            continue;
        }
        schur_into(&a, &mut found, &mut workspace)?;
        // In units of the largest entry, so that the norms neither overflow nor underflow.
        let (a, t) = (&a / scale, &found.t / scale);
        let units = n as f64 * f64::EPSILON;
        let backward = (&found.q * t * found.q.transpose() - &a).norm() / (units * a.norm());
        let orthogonality = (found.q.transpose() * &found.q - DMatrix::identity(n, n)).norm() / units;
        if !(backward <= 50.0 && orthogonality <= 50.0) {
            failures += 1;
            println!("{backward:.1} {orthogonality:.1}: {a:?}");
        }
        worst = [worst[0].max(backward), worst[1].max(orthogonality)];
    }
    println!("{count} matrices from seed {seed}: {failures} beyond 50 n eps");
    println!("worst backward error {:.2} n eps, worst loss of orthogonality {:.2} n eps", worst[0], worst[1]);
    if failures > 0 {
        std::process::exit(1);
    }
    Ok(())
}
