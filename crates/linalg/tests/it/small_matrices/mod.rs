//! Small random matrices of the kinds that have broken QR iterations, from a seed.

use nalgebra::DMatrix;

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): every seed gives another stream.
pub(crate) struct Seeded(pub(crate) u64);

impl Seeded {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Uniform in [-1, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// An n x n matrix: dense, of the integers -1, 0, 1, a companion matrix, graded by up to 300 decades, sparse, a
    /// permutation with signs, nearly defective, or of rank one.
    pub(crate) fn matrix(&mut self, n: usize) -> DMatrix<f64> {
        match self.below(8) {
            0 => DMatrix::from_fn(n, n, |_, _| self.uniform()),
            1 => DMatrix::from_fn(n, n, |_, _| self.below(3) as f64 - 1.0),
            2 => DMatrix::from_fn(n, n, |i, j| {
                if i == 0 { self.below(7) as f64 - 3.0 } else { f64::from(u8::from(i == j + 1)) }
            }),
            3 => {
                let decades = 300.0 * self.uniform() / (2 * n) as f64;
                DMatrix::from_fn(n, n, |i, j| {
                    self.uniform() * 10.0_f64.powf(decades * (i as f64 + j as f64 - n as f64 + 1.0))
                })
            }
            4 => DMatrix::from_fn(n, n, |_, _| if self.below(3) == 0 { self.uniform() } else { 0.0 }),
            5 => {
                let mut columns: Vec<usize> = (0..n).collect();
                for i in (1..n).rev() {
                    columns.swap(i, self.below(i + 1));
                }
                DMatrix::from_fn(n, n, |i, j| if columns[i] == j { [1.0, -1.0][self.below(2)] } else { 0.0 })
            }
            6 => {
                let (lambda, size) = (self.uniform(), 10.0_f64.powf(-(self.below(20) as f64)));
                DMatrix::from_fn(n, n, |i, j| {
                    let jordan = if i == j { lambda } else { f64::from(u8::from(i + 1 == j)) };
                    jordan + size * self.uniform()
                })
            }
            _ => {
                let (u, v): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (self.uniform(), self.uniform())).unzip();
                DMatrix::from_fn(n, n, |i, j| u[i] * v[j])
            }
        }
    }
}
