//! Families of semidefinite programs after those of SDPLIB (B. Borchers, Optimization Methods and Software 11, 1999),
//! made by formula, as SDPA's files.
//!
//! What is known of each without solving it: the optimum, where there is a closed form; that (P) or (D) has no
//! interior; that it has no feasible point.

use std::f64::consts::PI;
use std::fmt::Write as _;

use luenberger_proof::semidefinite::Block;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What has to come out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Known {
    /// Both programs have an interior: finite bounds, around this optimum if there is a closed form.
    Bounded(Option<f64>),
    /// (D) has no interior: the upper bound is finite, and nothing is known to be on the wrong side.
    AboveOnly(Option<f64>),
    /// (P) has no feasible point, and a ray shows it.
    PrimalInfeasible,
    /// (D) has none.
    DualInfeasible,
}

/// A program and what is known of it.
#[derive(Debug, Clone)]
pub(crate) struct Instance {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) known: Known,
}

/// An SDPA file in the making.
struct File {
    blocks: Vec<Block>,
    costs: Vec<f64>,
    entries: String,
}

impl File {
    fn new(blocks: &[Block], costs: Vec<f64>) -> Self {
        Self { blocks: blocks.to_vec(), costs, entries: String::new() }
    }

    /// An entry of matrix k, numbers from 1 as in the file; zeros are left out.
    fn put(&mut self, k: usize, block: usize, i: usize, j: usize, value: f64) {
        if value != 0.0 {
            let _ = writeln!(self.entries, "{k} {block} {} {} {value:e}", i.min(j), i.max(j));
        }
    }

    fn finish(self, name: String, known: Known) -> Instance {
        let list = |numbers: Vec<String>| numbers.join(" ");
        let text = format!(
            "\"{name}\n{}\n{}\n{}\n{}\n{}",
            self.costs.len(),
            self.blocks.len(),
            list(
                self.blocks
                    .iter()
                    .map(|block| match block {
                        Block::Dense(n) => n.to_string(),
                        Block::Diagonal(n) => format!("-{n}"),
                    })
                    .collect()
            ),
            list(self.costs.iter().map(|c| format!("{c:e}")).collect()),
            self.entries
        );
        Instance { name, text, known }
    }
}

/// The edges of a random graph in which every pair is joined with this probability.
fn graph(n: usize, probability: f64, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
    let mut edges = Vec::new();
    for i in 1..=n {
        for j in i + 1..=n {
            if rng.random_bool(probability) {
                edges.push((i, j));
            }
        }
    }
    edges
}

fn laplacian(n: usize, edges: &[(usize, usize)], mut put: impl FnMut(usize, usize, f64)) {
    let mut degree = vec![0.0; n + 1];
    for &(i, j) in edges {
        degree[i] += 1.0;
        degree[j] += 1.0;
        put(i, j, -1.0);
    }
    for (i, degree) in degree.iter().enumerate().skip(1) {
        put(i, i, *degree);
    }
}

fn max_cut_of(name: String, n: usize, edges: &[(usize, usize)], optimum: Option<f64>) -> Instance {
    let mut file = File::new(&[Block::Dense(n)], vec![1.0; n]);
    laplacian(n, edges, |i, j, x| file.put(0, 1, i, j, 0.25 * x));
    for i in 1..=n {
        file.put(i, 1, i, i, 1.0);
    }
    file.finish(name, Known::Bounded(optimum))
}

/// mcp, maxG: maximise tr(L Y)/4 with Y_ii = 1, of a random graph.
pub(crate) fn max_cut(n: usize, degree: f64, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let edges = graph(n, (degree / n as f64).min(1.0), &mut rng);
    max_cut_of(format!("mcp-{n}-{seed}"), n, &edges, None)
}

/// The same of a cycle: Y_ij = cos(2 pi k (i - j)/n) with the k nearest n/2 is optimal, `n (1 - cos(2 pi k/n))/2`.
pub(crate) fn max_cut_cycle(n: usize) -> Instance {
    let edges: Vec<_> = (1..n).map(|i| (i, i + 1)).chain([(1, n)]).collect();
    let angle = 2.0 * PI * (n / 2) as f64 / n as f64;
    max_cut_of(format!("mcp-cycle-{n}"), n, &edges, Some(0.5 * n as f64 * (1.0 - angle.cos())))
}

fn theta_of(name: String, n: usize, edges: &[(usize, usize)], optimum: Option<f64>) -> Instance {
    let mut costs = vec![0.0; edges.len() + 1];
    costs[0] = 1.0;
    let mut file = File::new(&[Block::Dense(n)], costs);
    for i in 1..=n {
        for j in i..=n {
            file.put(0, 1, i, j, 1.0);
        }
        file.put(1, 1, i, i, 1.0);
    }
    for (k, &(i, j)) in edges.iter().enumerate() {
        file.put(k + 2, 1, i, j, 1.0);
    }
    file.finish(name, Known::Bounded(optimum))
}

/// theta: the Lovasz number of a random graph.
pub(crate) fn theta(n: usize, probability: f64, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let edges = graph(n, probability, &mut rng);
    theta_of(format!("theta-{n}-{seed}"), n, &edges, None)
}

/// hamming: the Lovasz number of the Kneser graph of the k-subsets of n, `C(n - 1, k - 1)` (L. Lovasz, On the Shannon
/// capacity of a graph, IEEE Transactions on Information Theory 25, 1979).
pub(crate) fn theta_kneser(n: u32, k: u32) -> Instance {
    let subsets: Vec<u32> = (0..1_u32 << n).filter(|s| s.count_ones() == k).collect();
    let mut edges = Vec::new();
    for (i, a) in subsets.iter().enumerate() {
        edges.extend(subsets.iter().enumerate().skip(i + 1).filter(|(_, b)| a & *b == 0).map(|(j, _)| (i + 1, j + 1)));
    }
    let optimum = (1..k).fold(1.0, |c, i| c * f64::from(n - i) / f64::from(i));
    theta_of(format!("theta-kneser-{n}-{k}"), subsets.len(), &edges, Some(optimum))
}

/// gpp, equalG: minimise tr(L Y) with Y_ii = 1 and `tr(e e' Y) = 0`: e is in the kernel of every such Y.
pub(crate) fn equal_partition(n: usize, degree: f64, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let edges = graph(n, (degree / n as f64).min(1.0), &mut rng);
    let mut costs = vec![1.0; n];
    costs.push(0.0);
    let mut file = File::new(&[Block::Dense(n)], costs);
    laplacian(n, &edges, |i, j, x| file.put(0, 1, i, j, -x));
    for i in 1..=n {
        file.put(i, 1, i, i, 1.0);
        for j in i..=n {
            file.put(n + 1, 1, i, j, 1.0);
        }
    }
    file.finish(format!("gpp-{n}-{seed}"), Known::AboveOnly(None))
}

/// qap: a quadratic assignment of q places, relaxed with Y = [1 x'; x X], X_ii = x_i, X_ij = 0 for two places of one
/// thing, and the sums of x squared and added: no interior.
pub(crate) fn assignment(q: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = q * q + 1;
    let at = |i: usize, p: usize| 2 + i * q + p;
    let mut rows = vec![(1.0, vec![(1, 1, 1.0)])];
    rows.extend((2..=n).map(|i| (0.0, vec![(i, i, 1.0), (1, i, -0.5)])));
    for i in 0..q {
        for p in 0..q {
            for r in p + 1..q {
                rows.push((0.0, vec![(at(i, p), at(i, r), 1.0)]));
                rows.push((0.0, vec![(at(p, i), at(r, i), 1.0)]));
            }
        }
    }
    // sum over the 2 q sums of (1 - sum)^2, homogeneous.
    let mut square = std::collections::BTreeMap::new();
    for k in 0..2 * q {
        let members: Vec<usize> = (0..q).map(|p| if k < q { at(k, p) } else { at(p, k - q) }).collect();
        let vector: Vec<(usize, f64)> =
            std::iter::once((1, -1.0)).chain(members.into_iter().map(|i| (i, 1.0))).collect();
        for &(i, x) in &vector {
            for &(j, y) in vector.iter().filter(|(j, _)| *j >= i) {
                *square.entry((i, j)).or_insert(0.0) += x * y;
            }
        }
    }
    rows.push((0.0, square.into_iter().map(|((i, j), x)| (i, j, x)).collect()));
    let mut file = File::new(&[Block::Dense(n)], rows.iter().map(|row| row.0).collect());
    let table =
        |rng: &mut ChaCha8Rng| -> Vec<f64> { (0..q * q).map(|_| f64::from(rng.random_range(0..10_i32))).collect() };
    let (flow, distance) = (table(&mut rng), table(&mut rng));
    for i in 0..q {
        for j in i + 1..q {
            for p in 0..q {
                for r in (0..q).filter(|r| *r != p) {
                    file.put(0, 1, at(i, p), at(j, r), -flow[i * q + j] * distance[p.min(r) * q + p.max(r)]);
                }
            }
        }
    }
    for (k, (_, entries)) in rows.iter().enumerate() {
        for &(i, j, x) in entries {
            file.put(k + 1, 1, i, j, x);
        }
    }
    file.finish(format!("qap-{q}-{seed}"), Known::AboveOnly(None))
}

/// control: the largest s with `[-(A'P + PA) - C'DC, -PB; -B'P, D] >= s I`, `P <= I`, `0 <= D` diagonal, of a random
/// stable system: two blocks, 2n and n.
pub(crate) fn control(n: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut matrix = |size: f64| DMatrix::from_fn(n, n, |_, _| size * (rng.random_range(0.0..2.0_f64) - 1.0));
    let (a, b, c) = (matrix(1.0), matrix(0.5), matrix(0.5));
    let a = a - DMatrix::identity(n, n) * (1.5 * (n as f64).sqrt());
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).collect();
    let m = pairs.len() + n + 1;
    let mut costs = vec![0.0; m];
    costs[m - 1] = -1.0;
    let mut file = File::new(&[Block::Dense(2 * n), Block::Dense(n), Block::Diagonal(n)], costs);
    for (k, &(p, q)) in pairs.iter().enumerate() {
        // P = E: E(p, q) = E(q, p) = 1.
        let e = |i: usize, j: usize| f64::from(u8::from((i, j) == (p, q) || (j, i) == (p, q)));
        let product = |m: &DMatrix<f64>, i: usize, j: usize| -> f64 {
            let mut sum = 0.0;
            if i == p {
                sum += m[(q, j)];
            }
            if i == q && p != q {
                sum += m[(p, j)];
            }
            sum
        };
        for i in 0..n {
            for j in 0..n {
                if i <= j {
                    file.put(k + 1, 1, i + 1, j + 1, -product(&a, i, j) - product(&a, j, i));
                    file.put(k + 1, 2, i + 1, j + 1, -e(i, j));
                }
                file.put(k + 1, 1, i + 1, n + j + 1, -product(&b, i, j));
            }
        }
    }
    for d in 0..n {
        let k = pairs.len() + d + 1;
        for i in 0..n {
            for j in i..n {
                file.put(k, 1, i + 1, j + 1, -c[(d, i)] * c[(d, j)]);
            }
        }
        file.put(k, 1, n + d + 1, n + d + 1, 1.0);
        file.put(k, 3, d + 1, d + 1, 1.0);
    }
    for i in 1..=2 * n {
        file.put(m, 1, i, i, -1.0);
    }
    for i in 1..=n {
        file.put(0, 2, i, i, -1.0);
    }
    file.finish(format!("control-{n}-{seed}"), Known::Bounded(None))
}

/// truss, arch: the least compliance of bars with volumes `t_i >= 0`, `sum t_i <= 1`, under several loads f: minimise g
/// subject to `[g f'; f sum t_i b_i b_i'] >= 0` for each.
pub(crate) fn truss(order: usize, bars: usize, loads: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut costs = vec![0.0; bars + 1];
    costs[bars] = 1.0;
    let mut blocks = vec![Block::Dense(order + 1); loads];
    blocks.push(Block::Diagonal(bars + 1));
    let mut file = File::new(&blocks, costs);
    for t in 1..=bars {
        // A bar touches four coordinates.
        let mut places: Vec<usize> = (0..4).map(|k| 2 + (t + k * k * (1 + t % 3)) % order).collect();
        places.sort_unstable();
        places.dedup();
        let b: Vec<f64> = places.iter().map(|_| rng.random_range(0.0..2.0_f64) - 1.0).collect();
        for load in 1..=loads {
            for (k, i) in places.iter().enumerate() {
                for l in k..places.len() {
                    file.put(t, load, *i, places[l], b[k] * b[l]);
                }
            }
        }
        file.put(t, loads + 1, t, t, 1.0);
        file.put(t, loads + 1, bars + 1, bars + 1, -1.0);
    }
    file.put(0, loads + 1, bars + 1, bars + 1, -1.0);
    for load in 1..=loads {
        file.put(bars + 1, load, 1, 1, 1.0);
        for i in 2..=order + 1 {
            let f = if rng.random_bool(0.3) { f64::from(rng.random_range(-3..=3_i32)) } else { 0.0 };
            file.put(0, load, 1, i, -f);
        }
    }
    file.finish(format!("truss-{order}-{bars}-{seed}"), Known::Bounded(None))
}

/// The entries of a random symmetric matrix of integers.
fn integers(n: usize, rng: &mut ChaCha8Rng) -> DMatrix<f64> {
    let mut m = DMatrix::from_fn(n, n, |_, _| f64::from(rng.random_range(-5..=5_i32)));
    m.fill_lower_triangle_with_upper_triangle();
    m
}

/// Random integers with a known pair of optimal points: `Y = v v'` and `X = |v|^2 I - v v'` are complementary; F_1 = I,
/// so that (P) has an interior; (D) has none that is known.
pub(crate) fn planted(n: usize, m: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let v = DVector::from_fn(n, |_, _| f64::from(rng.random_range(1..=3_i32)));
    let x: Vec<f64> = (0..m).map(|_| f64::from(rng.random_range(-4..=4_i32))).collect();
    let matrices: Vec<_> =
        std::iter::once(DMatrix::identity(n, n)).chain((1..m).map(|_| integers(n, &mut rng))).collect();
    let costs: Vec<f64> = matrices.iter().map(|f| v.dot(&(f * &v))).collect();
    let square = v.norm_squared();
    let optimum = costs.iter().zip(&x).map(|(c, x)| c * x).sum();
    let mut file = File::new(&[Block::Dense(n)], costs);
    for i in 0..n {
        for j in i..n {
            let slack = if i == j { square } else { 0.0 } - v[i] * v[j];
            file.put(0, 1, i + 1, j + 1, matrices.iter().zip(&x).map(|(f, x)| f[(i, j)] * x).sum::<f64>() - slack);
            for (k, f) in matrices.iter().enumerate() {
                file.put(k + 1, 1, i + 1, j + 1, f[(i, j)]);
            }
        }
    }
    file.finish(format!("planted-{n}-{m}-{seed}"), Known::AboveOnly(Some(optimum)))
}

/// infp: every F_i is orthogonal to I, and F_0 has a positive trace.
pub(crate) fn without_primal_point(n: usize, m: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let costs = (0..m).map(|_| f64::from(rng.random_range(-5..=5_i32))).collect();
    let mut file = File::new(&[Block::Dense(n)], costs);
    for k in 0..=m {
        let mut f = integers(n, &mut rng);
        let trace = f.trace();
        f[(n - 1, n - 1)] -= if k == 0 { trace - 3.0 } else { trace };
        for i in 0..n {
            for j in i..n {
                file.put(k, 1, i + 1, j + 1, f[(i, j)]);
            }
        }
    }
    file.finish(format!("infp-{n}-{m}-{seed}"), Known::PrimalInfeasible)
}

/// infd: F_1 = I, and its cost is negative.
pub(crate) fn without_dual_point(n: usize, m: usize, seed: u64) -> Instance {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let costs = (0..m).map(|k| if k == 0 { -2.0 } else { f64::from(rng.random_range(-5..=5_i32)) }).collect();
    let mut file = File::new(&[Block::Dense(n)], costs);
    for k in 0..=m {
        let f = integers(n, &mut rng);
        for i in 0..n {
            for j in i..n {
                let x = if k == 1 { f64::from(u8::from(i == j)) } else { f[(i, j)] };
                file.put(k, 1, i + 1, j + 1, x);
            }
        }
    }
    file.finish(format!("infd-{n}-{m}-{seed}"), Known::DualInfeasible)
}

/// Small ones, for a suite of tests.
pub(crate) fn small() -> Vec<Instance> {
    vec![
        max_cut(24, 5.0, 1),
        max_cut_cycle(15),
        max_cut_cycle(20),
        theta(14, 0.4, 2),
        theta_kneser(5, 2),
        theta_kneser(6, 2),
        equal_partition(16, 5.0, 3),
        assignment(3, 4),
        control(4, 5),
        control(5, 6),
        truss(9, 20, 3, 7),
        truss(12, 30, 1, 8),
        planted(8, 6, 9),
        planted(5, 9, 10),
        without_primal_point(9, 7, 11),
        without_dual_point(9, 7, 12),
    ]
}
