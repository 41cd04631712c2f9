//! Symmetric matrices made to deceive: where rounding, underflow or overflow decides, or nothing but exact arithmetic
//! can.

use luenberger_proof::Matrix;
use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng as Random;

/// A way to make symmetric matrices.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) make: fn(&mut Random) -> Matrix<f64>,
}

pub(crate) const FAMILIES: [Family; 20] = [
    Family { name: "small integers", make: small_integers },
    Family { name: "integers, singular", make: integers_singular },
    Family { name: "Gram, exactly of rank n - 1", make: gram_of_rank_one_less },
    Family { name: "Gram, rounded, any rank", make: gram_rounded },
    Family { name: "singular but for one ulp", make: singular_but_for_one_ulp },
    Family { name: "v'v I - vv', by an ulp or none", make: projector },
    Family { name: "Laplacians of graphs", make: laplacian },
    Family { name: "Pascal, singular, by an ulp or none", make: pascal },
    Family { name: "nearly equal rows", make: nearly_equal_rows },
    Family { name: "condition 1e16", make: condition_1e16 },
    Family { name: "any spectrum", make: any_spectrum },
    Family { name: "graded by 1e+-12", make: graded },
    Family { name: "scales over the whole range", make: whole_range },
    Family { name: "denormals", make: denormals },
    Family { name: "denormals beside ones", make: denormals_beside_ones },
    Family { name: "near overflow", make: near_overflow },
    Family { name: "any bits", make: any_bits },
    Family { name: "zero rows and diagonals", make: zeros },
    Family { name: "minus its least eigenvalue", make: minus_least_eigenvalue },
    Family { name: "larger, n = 13 to 20", make: larger },
];

/// Mostly small.
fn order(random: &mut Random, largest: usize) -> usize {
    let n = match random.random_range(0..20) {
        0 => 1,
        1..=4 => 2,
        5..=9 => 3,
        10..=13 => 4,
        14..=15 => 5,
        16..=17 => 6,
        _ => random.random_range(7..=12),
    };
    n.min(largest)
}

fn symmetric(n: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Matrix<f64> {
    let mut m = Matrix::from_fn(n, n, |_, _| 0.0);
    for i in 0..n {
        for j in i..n {
            let x = entry(i, j);
            m[(i, j)] = x;
            m[(j, i)] = x;
        }
    }
    m
}

fn integer(random: &mut Random, size: i64) -> f64 {
    random.random_range(-size..=size) as f64
}

fn unit(random: &mut Random) -> f64 {
    2.0 * random.random::<f64>() - 1.0
}

/// `X X'`, in floating point; exact if the numbers are small integers.
fn gram(x: &Matrix<f64>) -> Matrix<f64> {
    symmetric(x.rows(), |i, j| x.row(i).iter().zip(x.row(j)).map(|(a, b)| a * b).sum())
}

/// One entry moved by one float.
fn nudged(random: &mut Random, mut m: Matrix<f64>) -> Matrix<f64> {
    let (i, j) = (random.random_range(0..m.rows()), random.random_range(0..m.rows()));
    let up = random.random_bool(0.5);
    let x = m[(i, j)];
    let moved = if up { x.next_up() } else { x.next_down() };
    if moved.is_finite() {
        m[(i, j)] = moved;
        m[(j, i)] = moved;
    }
    m
}

fn perhaps_nudged(random: &mut Random, m: Matrix<f64>) -> Matrix<f64> {
    if random.random_bool(0.5) { nudged(random, m) } else { m }
}

/// Rows and columns times powers of two: exact but for what leaves the range, which makes another matrix and no wrong
/// one.
fn scaled(m: &Matrix<f64>, exponents: &[i32]) -> Matrix<f64> {
    symmetric(m.rows(), |i, j| {
        let x = (m[(i, j)] * 2.0_f64.powi(exponents[i])) * 2.0_f64.powi(exponents[j]);
        if x.is_finite() { x } else { f64::MAX.copysign(x) }
    })
}

fn exponents(random: &mut Random, n: usize, most: i32) -> Vec<i32> {
    (0..n).map(|_| random.random_range(-most..=most)).collect()
}

fn small_integers(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    symmetric(n, |i, j| if i == j { f64::from(random.random_range(-1..=7_i32)) } else { integer(random, 3) })
}

fn integers_singular(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let rank = random.random_range(0..n.max(1));
    gram(&Matrix::from_fn(n, rank, |_, _| integer(random, 9)))
}

fn gram_of_rank_one_less(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12).max(2);
    // Sums of a dozen products of 24 bits are exact.
    let bits = random.random_range(3..=23);
    gram(&Matrix::from_fn(n, n - 1, |_, _| integer(random, 1 << bits)))
}

fn gram_rounded(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let rank = random.random_range(1..=n);
    gram(&Matrix::from_fn(n, rank, |_, _| unit(random)))
}

fn singular_but_for_one_ulp(random: &mut Random) -> Matrix<f64> {
    let m = if random.random_bool(0.5) { integers_singular(random) } else { gram_of_rank_one_less(random) };
    let m = nudged(random, m);
    let most = if random.random_bool(0.5) { 0 } else { 30 };
    let k = exponents(random, m.rows(), most);
    scaled(&m, &k)
}

fn projector(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let v: Vec<f64> = (0..n).map(|_| integer(random, 1 << 20)).collect();
    let square: f64 = v.iter().map(|x| x * x).sum();
    let m = symmetric(n, |i, j| if i == j { square } else { 0.0 } - v[i] * v[j]);
    perhaps_nudged(random, m)
}

fn laplacian(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let mut m = symmetric(n, |i, j| if i == j || random.random_bool(0.4) { 0.0 } else { -random.random::<f64>() });
    for i in 0..n {
        let degree: f64 = m.row(i).iter().sum();
        m[(i, i)] = -degree;
    }
    perhaps_nudged(random, m)
}

fn pascal(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let mut m = Matrix::from_fn(n, n, |_, _| 1.0);
    for i in 1..n {
        for j in 1..n {
            m[(i, j)] = m[(i - 1, j)] + m[(i, j - 1)];
        }
    }
    // The determinant is 1, and so is that without the last row: one less there makes it singular.
    m[(n - 1, n - 1)] -= 1.0;
    let k = exponents(random, n, 3);
    let m = scaled(&m, &k);
    perhaps_nudged(random, m)
}

fn nearly_equal_rows(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12).max(2);
    let mut m = gram(&Matrix::from_fn(n, n, |_, _| unit(random)));
    for _ in 0..random.random_range(1..=2) {
        let (from, to) = (random.random_range(0..n), random.random_range(0..n));
        let ulps = random.random_range(0..=2);
        let moved = |x: f64| (0..ulps).fold(x, |x, _| x.next_up());
        let (row, corner) = (m.row(from).to_vec(), m[(from, from)]);
        for (j, &x) in row.iter().enumerate() {
            let x = if j == to { moved(corner) } else { moved(x) };
            m[(to, j)] = x;
            m[(j, to)] = x;
        }
    }
    m
}

/// `Q diag(spectrum) Q'` in floating point, with a few random reflections.
fn with_spectrum(random: &mut Random, spectrum: &[f64]) -> Matrix<f64> {
    let n = spectrum.len();
    let mut m = symmetric(n, |i, j| if i == j { spectrum[i] } else { 0.0 });
    for _ in 0..2 {
        let v: Vec<f64> = (0..n).map(|_| unit(random)).collect();
        let square: f64 = v.iter().map(|x| x * x).sum();
        let h = symmetric(n, |i, j| if i == j { 1.0 } else { 0.0 } - 2.0 * v[i] * v[j] / square);
        let product = |a: &Matrix<f64>, b: &Matrix<f64>| {
            Matrix::from_fn(n, n, |i, j| (0..n).map(|k| a[(i, k)] * b[(k, j)]).sum::<f64>())
        };
        let both = product(&product(&h, &m), &h);
        m = symmetric(n, |i, j| f64::midpoint(both[(i, j)], both[(j, i)]));
    }
    m
}

fn condition_1e16(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let least = 10.0_f64.powf(random.random_range(-17.5..=-14.5)) * if random.random_bool(0.5) { -1.0 } else { 1.0 };
    let spectrum: Vec<f64> = (0..n).map(|k| if k == 0 { least } else { random.random::<f64>() }).collect();
    with_spectrum(random, &spectrum)
}

fn any_spectrum(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let negative = random.random_bool(0.3);
    let spectrum: Vec<f64> = (0..n)
        .map(|k| 10.0_f64.powf(random.random_range(-12.0..=2.0)) * if k == 0 && negative { -1.0 } else { 1.0 })
        .collect();
    with_spectrum(random, &spectrum)
}

fn graded(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 10);
    let rank = random.random_range(n.saturating_sub(1).max(1)..=n);
    let m = gram(&Matrix::from_fn(n, rank, |_, _| unit(random)));
    let k = exponents(random, n, 40);
    let m = scaled(&m, &k);
    perhaps_nudged(random, m)
}

fn whole_range(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 5);
    let rank = random.random_range(1..=n);
    let m = gram(&Matrix::from_fn(n, rank, |_, _| integer(random, 9)));
    let k = exponents(random, n, 500);
    let m = scaled(&m, &k);
    perhaps_nudged(random, m)
}

fn denormals(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 8);
    let most = 1_u64 << random.random_range(2..=12);
    symmetric(n, |i, j| {
        let x = f64::from_bits(random.random_range(0..most));
        if i == j || random.random_bool(0.5) { x } else { -x }
    })
}

fn denormals_beside_ones(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 6);
    let large = random.random_range(0..n);
    let exponent = random.random_range(-1060..=0);
    symmetric(n, |i, j| {
        if i == large && j == large {
            2.0_f64.powi(exponent)
        } else {
            let x = f64::from_bits(random.random_range(0..200));
            if i == j || random.random_bool(0.5) { x } else { -x }
        }
    })
}

fn near_overflow(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 6);
    let rank = random.random_range(1..=n);
    let m = gram(&Matrix::from_fn(n, rank, |_, _| integer(random, 3)));
    let largest = m.as_slice().iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let m = m.map(|x| (x * (f64::MAX / largest)).clamp(-f64::MAX, f64::MAX));
    perhaps_nudged(random, m)
}

fn any_bits(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 4);
    let near = random.random_bool(0.5);
    symmetric(n, |i, j| {
        let mut x = f64::from_bits(random.random());
        if near {
            // All exponents within a few of each other, and the diagonal favoured.
            x = f64::from_bits((x.to_bits() & !(0x7ff << 52)) | (random.random_range(1000..1006) << 52));
            x = if i == j { 8.0 * x.abs() } else { x };
        }
        if x.is_finite() { x } else { 1.0 }
    })
}

fn zeros(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 12);
    let m = gram(&Matrix::from_fn(n, n, |_, _| integer(random, 2)));
    let cleared: Vec<bool> = (0..n).map(|_| random.random_bool(0.3)).collect();
    let mut m = symmetric(n, |i, j| if cleared[i] || cleared[j] { -0.0 } else { m[(i, j)] });
    if random.random_bool(0.3) {
        let i = random.random_range(0..n);
        m[(i, i)] = 0.0;
    }
    perhaps_nudged(random, m)
}

fn minus_least_eigenvalue(random: &mut Random) -> Matrix<f64> {
    let n = order(random, 8);
    let mut m = gram(&Matrix::from_fn(n, n + 1, |_, _| unit(random)));
    // The least eigenvalue by bisection with floating-point factorisations: to the last digits.
    let is_definite = |m: &Matrix<f64>, c: f64| {
        let mut a = m.clone();
        (0..n).all(|k| {
            let pivot = a[(k, k)] - c;
            for i in k + 1..n {
                for j in k + 1..n {
                    let change = a[(i, k)] * a[(k, j)] / pivot;
                    a[(i, j)] -= change;
                }
            }
            pivot > 0.0
        })
    };
    let (mut below, mut above) = (0.0, m[(0, 0)]);
    for _ in 0..64 {
        let middle = f64::midpoint(below, above);
        if is_definite(&m, middle) { below = middle } else { above = middle }
    }
    for i in 0..n {
        m[(i, i)] -= below;
    }
    perhaps_nudged(random, m)
}

fn larger(random: &mut Random) -> Matrix<f64> {
    let n = random.random_range(13..=20);
    match random.random_range(0..4) {
        0 => gram(&Matrix::from_fn(n, n - 1, |_, _| integer(random, 9))),
        1 => {
            let m = gram(&Matrix::from_fn(n, n - 1, |_, _| integer(random, 9)));
            nudged(random, m)
        }
        2 => {
            let rank = random.random_range(1..=n);
            gram(&Matrix::from_fn(n, rank, |_, _| unit(random)))
        }
        _ => {
            let least = (random.random::<f64>() - 0.5) * 1e-15;
            let spectrum: Vec<f64> = (0..n).map(|k| if k == 0 { least } else { random.random::<f64>() }).collect();
            with_spectrum(random, &spectrum)
        }
    }
}

/// The order of rows and the sign are no one's business: shuffled, and negative now and then.
pub(crate) fn disguised(random: &mut Random, m: &Matrix<f64>) -> Matrix<f64> {
    let n = m.rows();
    let mut places: Vec<usize> = (0..n).collect();
    if random.random_bool(0.5) {
        places.shuffle(random);
    }
    let sign = if random.random_bool(0.25) { -1.0 } else { 1.0 };
    Matrix::from_fn(n, n, |i, j| sign * m[(places[i], places[j])])
}
