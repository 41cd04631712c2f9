//! Small random matrices of the kinds that have broken QR iterations, from a seed.

use luenberger_random::Random;
use nalgebra::DMatrix;

/// An n x n matrix: dense, of the integers -1, 0, 1, a companion matrix, graded by up to 300 decades, sparse, a
/// permutation with signs, nearly defective, or of rank one.
pub(crate) fn matrix(random: &mut Random, n: usize) -> DMatrix<f64> {
    match random.below(8) {
        0 => DMatrix::from_fn(n, n, |_, _| random.unit()),
        1 => DMatrix::from_fn(n, n, |_, _| random.below(3) as f64 - 1.0),
        2 => {
            DMatrix::from_fn(
                n,
                n,
                |i, j| {
                    if i == 0 { random.below(7) as f64 - 3.0 } else { f64::from(u8::from(i == j + 1)) }
                },
            )
        }
        3 => {
            let decades = 300.0 * random.unit() / (2 * n) as f64;
            DMatrix::from_fn(n, n, |i, j| {
                random.unit() * 10.0_f64.powf(decades * (i as f64 + j as f64 - n as f64 + 1.0))
            })
        }
        4 => DMatrix::from_fn(n, n, |_, _| if random.below(3) == 0 { random.unit() } else { 0.0 }),
        5 => {
            let mut columns: Vec<usize> = (0..n).collect();
            for i in (1..n).rev() {
                columns.swap(i, random.below(i + 1));
            }
            DMatrix::from_fn(n, n, |i, j| if columns[i] == j { [1.0, -1.0][random.below(2)] } else { 0.0 })
        }
        6 => {
            let (lambda, size) = (random.unit(), 10.0_f64.powf(-(random.below(20) as f64)));
            DMatrix::from_fn(n, n, |i, j| {
                let jordan = if i == j { lambda } else { f64::from(u8::from(i + 1 == j)) };
                jordan + size * random.unit()
            })
        }
        _ => {
            let (u, v): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (random.unit(), random.unit())).unzip();
            DMatrix::from_fn(n, n, |i, j| u[i] * v[j])
        }
    }
}
