//! The adversaries of interval observers: errors at the ends of their bounds, in rational directions, and short runs of
//! the sampled step in the arithmetic of its format beside the plant in rational numbers.

use dashu_int::IBig;
use luenberger_random::Random;
use serde_json::Value;

use super::adversary::{Found, ensure, single};
use super::document::{binary64, float_matrix, floats, matrix, matrix_with_columns};
use super::exact::Exact;

fn said(what: &'static str) -> impl FnOnce() -> String {
    move || format!("false: {what}")
}

/// First entries and lengths of the blocks.
fn blocks(document: &Value) -> Vec<(usize, usize)> {
    let mut first = 0;
    let sizes = document["coordinates"]["blocks"].as_array().into_iter().flatten();
    sizes
        .map(|size| {
            let length = size.as_u64().and_then(|size| usize::try_from(size).ok()).unwrap_or(0);
            first += length;
            (first - length, length)
        })
        .collect()
}

/// Vectors of length 1 with so many entries.
fn units(length: usize) -> Vec<Vec<Exact>> {
    let share = |a: i64, b: i64| Exact::rational(IBig::from(a), 0, IBig::from(b));
    if length == 1 {
        return vec![vec![share(1, 1)], vec![share(-1, 1)]];
    }
    let triples = [(1, 0, 1), (3, 4, 5), (5, 12, 13), (15, 8, 17), (20, 21, 29), (7, 24, 25)];
    let mut found = Vec::new();
    for (a, b, c) in triples {
        for (a, b) in [(a, b), (b, a), (-a, b), (-b, a), (a, -b), (b, -a), (-a, -b), (-b, -a)] {
            found.push(vec![share(a, c), share(b, c)]);
        }
    }
    found
}

/// `u'M v` for rows and columns of a block.
fn bilinear(m: &Exact, (row, u): (usize, &[Exact]), (column, v): (usize, &[Exact])) -> Exact {
    let mut sum = Exact::zeros(1, 1);
    for (i, u) in u.iter().enumerate() {
        for (j, v) in v.iter().enumerate() {
            sum = sum.plus(&m.at(row + i, column + j).times(u).times(v));
        }
    }
    sum
}

fn at_least(x: &Exact, y: &Exact) -> bool {
    x.minus(y).sign() >= 0
}

fn magnitude(x: &Exact) -> Exact {
    if x.sign() < 0 { x.negative() } else { x.clone() }
}

/// Every block of M in every rational direction: what a matrix of norms is not below. On the diagonal with the
/// direction itself, for the logarithmic norm.
fn above_blocks(claimed: &Exact, m: &Exact, blocks: &[(usize, usize)], logarithmic: bool) -> bool {
    blocks.iter().enumerate().all(|(k, &(row, rows))| {
        blocks.iter().enumerate().all(|(j, &(column, columns))| {
            let bound = claimed.at(k, j);
            units(rows).iter().all(|u| {
                if logarithmic && j == k {
                    return at_least(&bound, &bilinear(m, (row, u), (row, u)));
                }
                units(columns).iter().all(|v| at_least(&bound, &bilinear(m, (row, u), (column, v))))
            })
        })
    })
}

/// `sum_j |u'(T G)_kj| W_j` in every rational direction.
fn above_forcing(claimed: &Exact, forced: &[(Exact, Vec<Exact>)], blocks: &[(usize, usize)]) -> bool {
    blocks.iter().enumerate().all(|(k, &(row, rows))| {
        units(rows).iter().all(|u| {
            let mut sum = Exact::zeros(1, 1);
            for (m, bounds) in forced {
                for (j, bound) in bounds.iter().enumerate() {
                    let one = [Exact::number(1.0)];
                    sum = sum.plus(&magnitude(&bilinear(m, (row, u), (j, &one))).times(bound));
                }
            }
            at_least(&claimed.at(k, 0), &sum)
        })
    })
}

fn column(value: &Value) -> Exact {
    let entries: Vec<Exact> = value.as_array().into_iter().flatten().map(single).collect();
    Exact::from_numbers(entries.len(), 1, &entries)
}

fn list(value: &Value) -> Vec<Exact> {
    value.as_array().into_iter().flatten().map(single).collect()
}

fn all(m: &Exact, holds: impl Fn(&Exact) -> bool) -> bool {
    (0..m.rows).all(|i| (0..m.cols).all(|j| holds(&m.at(i, j))))
}

/// Rows of T^-1 in every rational direction.
fn above_rows(claimed: &Exact, inverse: &Exact, blocks: &[(usize, usize)]) -> bool {
    let one = [Exact::number(1.0)];
    (0..inverse.rows).all(|i| {
        blocks.iter().enumerate().all(|(k, &(first, length))| {
            units(length).iter().all(|v| at_least(&claimed.at(i, k), &bilinear(inverse, (i, &one), (first, v))))
        })
    })
}

pub(super) fn continuous(document: &Value, random: &mut Random) -> Found {
    let (plant, comparison, bounds) = (&document["plant"], &document["comparison"], &document["bounds"]);
    let [a, c, e, d] = ["A", "C", "E", "D"].map(|name| matrix(&plant[name], random));
    let l = matrix(&document["observer"]["L"], random);
    let t = matrix(&document["coordinates"]["T"], random);
    let blocks = blocks(document);
    let Some(inverse) = t.solve(&Exact::identity(t.rows)) else { return Err("false: T is invertible".to_owned()) };
    let [k, h] = ["K", "H"].map(|name| matrix(&comparison[name], random));
    let (g, s, rate) = (column(&comparison["g"]), column(&comparison["s"]), single(&comparison["rate"]));
    let (limit, widths) = (column(&bounds["limit"]), column(&bounds["widths"]));
    let m = t.times(&a.minus(&l.times(&c))).times(&inverse);
    ensure(above_blocks(&k, &m, &blocks, true), said("no error leaves rho through its state"))?;
    let forced = [(t.times(&e.minus(&l.times(&d))), list(&bounds["w"]))];
    ensure(above_forcing(&g, &forced, &blocks), said("no disturbance drives an error out of rho"))?;
    ensure(above_rows(&h, &inverse, &blocks), said("|x - xhat| <= H rho"))?;
    ensure(k.is_hurwitz(), said("K is Hurwitz"))?;
    ensure(
        k.plus(&Exact::identity(k.rows).scaled(&rate)).is_hurwitz() || {
            // At the rate itself the matrix is singular.
            let less = rate.scaled(&Exact::number(1.0_f64.next_down()));
            k.plus(&Exact::identity(k.rows).scaled(&less)).is_hurwitz()
        },
        said("rho falls at the rate"),
    )?;
    let Some(rest) = k.solve(&g.negative()) else { return Err("false: K is regular".to_owned()) };
    ensure(all(&limit.minus(&rest), |x| x.sign() >= 0), said("rho ends below its limit"))?;
    ensure(all(&s, |x| x.sign() > 0), said("s > 0"))?;
    ensure(all(&widths.minus(&h.times(&rest)), |x| x.sign() >= 0), said("H rho ends below the widths"))
}

/// A number of the format.
fn rounded(x: f64, single: bool) -> f64 {
    if single { f64::from(x as f32) } else { x }
}

/// `sum a_i b_i` from left to right, each operation rounded.
fn sum(terms: impl Iterator<Item = (f64, f64)>, single: bool) -> f64 {
    let mut products = terms.map(|(a, b)| rounded(a * b, single));
    let first = products.next().unwrap_or(0.0);
    products.fold(first, |sum, x| rounded(sum + x, single))
}

pub(super) fn sampled(document: &Value, random: &mut Random) -> Found {
    let (plant, observer, step) = (&document["plant"], &document["observer"], &document["step"]);
    let bounds = &document["bounds"];
    let m = bounds["u"].as_array().map_or(0, Vec::len);
    let w = list(&bounds["w"]);
    let (a, c, f, l) = (
        matrix(&plant["A"], random),
        matrix(&plant["C"], random),
        matrix(&observer["F"], random),
        matrix(&observer["L"], random),
    );
    let b = matrix_with_columns(&plant["B"], m, random);
    let e = matrix_with_columns(&plant["E"], w.len(), random);
    let t = matrix(&document["coordinates"]["T"], random);
    let places = blocks(document);
    let Some(inverse) = t.solve(&Exact::identity(t.rows)) else { return Err("false: T is invertible".to_owned()) };
    let [n, q, h] = ["N", "Q", "H"].map(|name| matrix(&step[name], random));
    let g = column(&step["g"]);
    let flow = t.times(&a.minus(&l.times(&c))).times(&inverse);
    ensure(above_blocks(&n, &flow, &places, false), said("no error leaves rho through its state"))?;
    let forced = [(t.times(&e), w), (t.times(&l), list(&bounds["v"]))];
    ensure(above_forcing(&g, &forced, &places), said("no disturbance drives an error out of rho"))?;
    ensure(above_rows(&h, &inverse, &places), said("|x - xhat| <= H rho"))?;
    let moved = t.times(&a.minus(&f));
    let one = [Exact::number(1.0)];
    let covered = (0..moved.cols).all(|j| {
        places.iter().enumerate().all(|(k, &(row, rows))| {
            units(rows).iter().all(|u| at_least(&q.at(k, j), &bilinear(&moved, (row, u), (j, &one))))
        })
    });
    ensure(covered, said("Q covers what F differs from A by"))?;
    ensure(n.is_schur(), said("N is Schur"))?;
    let at = Exact::identity(n.rows).minus(&n).solve(&g);
    let Some(rest) = at else { return Err("false: I - N is regular".to_owned()) };
    ensure(all(&column(&bounds["limit"]).minus(&rest), |x| x.sign() >= 0), said("rho ends below its limit"))?;
    let ends = column(&bounds["widths"]).minus(&h.times(&rest));
    ensure(all(&ends, |x| x.sign() >= 0), said("r ends below the widths"))?;
    run(document, (&a, &b, &c, &e), random)
}

/// A short run in the format, from a corner of the enclosure at the start, with disturbances and noise at theirs.
fn run(document: &Value, (a, b, c, e): (&Exact, &Exact, &Exact, &Exact), random: &mut Random) -> Found {
    let (observer, step, bounds) = (&document["observer"], &document["step"], &document["bounds"]);
    let is_single = step["format"].as_str() == Some("binary32");
    let [f, input, l] = ["F", "G", "L"].map(|name| float_matrix(&observer[name]));
    let [n, q, u, h] = ["N", "Q", "U", "H"].map(|name| float_matrix(&step[name]));
    let output = float_matrix(&document["plant"]["C"]);
    let (g, outward) = (floats(&step["g"]), binary64(&step["outward"]));
    let (w, v, inputs) = (floats(&bounds["w"]), floats(&bounds["v"]), floats(&bounds["u"]));
    let (order, count) = (f.nrows(), g.len());
    let t = float_matrix(&document["coordinates"]["T"]);
    // The plant starts at 0 and the estimate within rho: |T xhat| is at most the sum of all magnitudes in its rows.
    let size = 2.0_f64.powi(random.integer(-6, 6));
    let xhat: Vec<f64> = (0..order).map(|_| rounded(size * random.unit(), is_single)).collect();
    let reach = t.abs().row_sum().iter().sum::<f64>();
    let start = g.iter().fold(2.0 * reach * size, |start, g| start.max(*g)) * 1.001;
    let (mut xhat, mut rho) = (xhat, vec![rounded(start * 1.000_001, is_single); count]);
    let mut x = Exact::zeros(order, 1);
    let mut near = vec![0.0; order];
    let entry = |m: &nalgebra::DMatrix<f64>, i: usize, v: &[f64]| {
        sum(v.iter().enumerate().map(|(j, v)| (m[(i, j)], *v)), is_single)
    };
    let signed = |bound: f64, random: &mut Random| {
        if random.once_in(3) {
            bound * random.unit()
        } else if random.once_in(2) {
            bound
        } else {
            -bound
        }
    };
    for _ in 0..6 {
        for (i, xhat) in xhat.iter().enumerate() {
            let half = rounded(entry(&h, i, &rho) + rounded(outward * xhat.abs(), is_single), is_single);
            let (low, high) = (rounded(xhat - half, is_single), rounded(xhat + half, is_single));
            if !(low.is_finite() && high.is_finite()) {
                return Ok(());
            }
            let inside = at_least(&x.at(i, 0), &Exact::number(low)) && at_least(&Exact::number(high), &x.at(i, 0));
            ensure(inside, said("the state is between the computed bounds in a run"))?;
        }
        let known: Vec<f64> = inputs.iter().map(|bound| rounded(signed(*bound, random), is_single)).collect();
        let pushed: Vec<f64> = w.iter().map(|bound| signed(*bound, random)).collect();
        let truth = c.times(&x);
        let mut y = Vec::with_capacity(v.len());
        for (i, bound) in v.iter().enumerate() {
            let ideal: f64 = (0..order).map(|j| output[(i, j)] * near[j]).sum();
            let measured = rounded(ideal + 0.999 * signed(*bound, random), is_single);
            let noise = magnitude(&Exact::number(measured).minus(&truth.at(i, 0)));
            // Noise below the rounding of y cannot be had.
            if !at_least(&Exact::number(*bound), &noise) {
                return Ok(());
            }
            y.push(measured);
        }
        let z: Vec<f64> = y.iter().enumerate().map(|(i, y)| rounded(y - entry(&output, i, &xhat), is_single)).collect();
        let magnitudes = |v: &[f64]| v.iter().map(|x| x.abs()).collect::<Vec<_>>();
        let (sizes, fed) = (magnitudes(&xhat), magnitudes(&known));
        let plus = |x: f64, y: f64| rounded(x + y, is_single);
        rho = (0..count)
            .map(|k| {
                let grown = plus(plus(entry(&n, k, &rho), g[k]), entry(&q, k, &sizes));
                if fed.is_empty() { grown } else { plus(grown, entry(&u, k, &fed)) }
            })
            .collect();
        xhat = (0..order)
            .map(|i| {
                let moved = entry(&f, i, &xhat);
                let moved = if known.is_empty() { moved } else { plus(moved, entry(&input, i, &known)) };
                plus(moved, entry(&l, i, &z))
            })
            .collect();
        if xhat.iter().chain(&rho).any(|x| !x.is_finite()) {
            return Ok(());
        }
        let vector = |entries: &[f64]| Exact::from_f64(entries.len(), 1, entries);
        let mut next = a.times(&x);
        if !known.is_empty() {
            next = next.plus(&b.times(&vector(&known)));
        }
        if !pushed.is_empty() {
            next = next.plus(&e.times(&vector(&pushed)));
        }
        x = next;
        near = (0..order).map(|i| x.at(i, 0).near()).collect();
    }
    Ok(())
}
