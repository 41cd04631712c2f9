//! Adversaries of the statements on families of plants: polytopes, sectors and contracting coordinates.

use luenberger_random::Random;
use serde_json::Value;

use super::adversary::{Found, decays, decrease, ensure, margin_of, rate, said, single};
use super::document::matrix;
use super::exact::Exact;

/// Weights of a point of the hull, in sixteenths: often a vertex.
fn weights(count: usize, random: &mut Random) -> Vec<Exact> {
    let mut weights = vec![0; count];
    let vertex = random.once_in(2);
    let first = random.below(count);
    for _ in 0..16 {
        weights[if vertex { first } else { random.below(count) }] += 1;
    }
    weights.into_iter().map(|k| Exact::dyadic(k, 4)).collect()
}

fn mixed(matrices: &[Exact], weights: &[Exact]) -> Exact {
    let first = Exact::zeros(matrices[0].rows, matrices[0].cols);
    matrices.iter().zip(weights).fold(first, |sum, (m, weight)| sum.plus(&m.scaled(weight)))
}

pub(super) fn polytope(document: &Value, random: &mut Random) -> Found {
    let vertices = document["vertices"].as_array().ok_or("no vertices")?;
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    for k in 0..vertices.len() + 6 {
        let a: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["A"], random)).collect();
        let c: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["C"], random)).collect();
        if k < vertices.len() {
            margin_of(document, k + 1, &decays(&a[k].minus(&l.times(&c[k])), &p, &rate(document))?)?;
        } else {
            let weights = weights(vertices.len(), random);
            decays(&mixed(&a, &weights).minus(&l.times(&mixed(&c, &weights))), &p, &rate(document))?;
        }
    }
    Ok(())
}

/// `factor^2 P - F'PF > 0`, and F/factor inside the unit circle; the block of the certificate.
fn contracts(f: &Exact, p: &Exact, factor: &Exact) -> Result<Exact, String> {
    let scaled = p.scaled(&factor.times(factor));
    ensure(scaled.minus(&f.congruent(p)).is_positive(), said("F'PF < factor^2 P"))?;
    ensure(f.is_schur(), said("eigenvalues inside the unit circle"))?;
    let corner = p.times(f);
    Ok(Exact::blocks(&[vec![scaled, corner.transposed()], vec![corner, p.clone()]]))
}

pub(super) fn discrete_polytope(document: &Value, random: &mut Random) -> Found {
    let vertices = document["vertices"].as_array().ok_or("no vertices")?;
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    let factor = single(&document["lyapunov"]["factor"]);
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let mut product = Exact::identity(p.rows);
    for k in 0..vertices.len() + 6 {
        let a: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["A"], random)).collect();
        let c: Vec<Exact> = vertices.iter().map(|vertex| matrix(&vertex["C"], random)).collect();
        let f = if k < vertices.len() {
            let f = a[k].minus(&l.times(&c[k]));
            margin_of(document, k + 1, &contracts(&f, &p, &factor)?)?;
            f
        } else {
            let weights = weights(vertices.len(), random);
            let f = mixed(&a, &weights).minus(&l.times(&mixed(&c, &weights)));
            contracts(&f, &p, &factor)?;
            f
        };
        // However the pairs follow one another: V(k) <= factor^(2k) V(0) for all e(0).
        if k < 3 {
            product = f.times(&product);
            let mut bound = p.clone();
            (0..=k).for_each(|_| bound = bound.scaled(&factor.times(&factor)));
            ensure(bound.minus(&product.congruent(&p)).is_positive(), said("V(k) <= factor^(2k) V(0)"))?;
        }
    }
    Ok(())
}

pub(super) fn contracting(document: &Value, random: &mut Random) -> Found {
    let k = matrix(&document["coordinates"]["K"], random);
    let (unmeasured, measured) = (k.rows, k.cols);
    let n = unmeasured + measured;
    let q = matrix(&document["lyapunov"]["Q"], random);
    ensure(q.is_positive(), said("Q > 0"))?;
    margin_of(document, 0, &q)?;
    let injection = single(&document["observer"]["injection"]);
    let vertices: Vec<Exact> =
        document["vertices"].as_array().into_iter().flatten().map(|vertex| matrix(vertex, random)).collect();
    ensure(!vertices.is_empty(), said("there is a vertex"))?;
    let (one, zero) = (Exact::identity, Exact::zeros);
    let turn = Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![k.clone(), one(unmeasured)]]);
    let back = Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![k.negative(), one(unmeasured)]]);
    let p =
        Exact::blocks(&[vec![one(measured), zero(measured, unmeasured)], vec![zero(unmeasured, measured), q.clone()]]);
    for number in 0..vertices.len() + 6 {
        let at_vertex = number < vertices.len();
        let j = if at_vertex { vertices[number].clone() } else { mixed(&vertices, &weights(vertices.len(), random)) };
        // Diagonal injections of g or more.
        let more: Vec<f64> = (0..n * n)
            .map(|k| if k / n == k % n && k / n < measured && !at_vertex { random.between(0.0, 4.0) } else { 0.0 })
            .collect();
        let least = Exact::blocks(&[
            vec![one(measured).scaled(&injection), zero(measured, unmeasured)],
            vec![zero(unmeasured, measured), zero(unmeasured, unmeasured)],
        ]);
        let f = back.times(&j).times(&turn).minus(&least).minus(&Exact::from_f64(n, n, &more));
        let m = decays(&f, &p, &rate(document))?;
        if at_vertex {
            margin_of(document, 2 * number + 2, &m)?;
            margin_of(document, 2 * number + 1, &m.view(measured, measured, unmeasured, unmeasured))?;
        }
    }
    Ok(())
}

/// A signed permutation, or a part of one: its norm is at most 1.
fn isometry(rows: usize, cols: usize, random: &mut Random) -> Exact {
    let turn = random.below(rows.max(cols));
    let entries: Vec<f64> = (0..rows * cols)
        .map(|k| if (k / cols + turn) % rows.max(cols) == k % cols { random.sign() } else { 0.0 })
        .collect();
    Exact::from_f64(rows, cols, &entries)
}

pub(super) fn sector(document: &Value, random: &mut Random) -> Found {
    let plant = &document["plant"];
    let (a, c) = (matrix(&plant["A"], random), matrix(&plant["C"], random));
    let (l, p) = (matrix(&document["observer"]["L"], random), matrix(&document["lyapunov"]["P"], random));
    ensure(p.is_positive(), said("P > 0"))?;
    margin_of(document, 0, &p)?;
    let f = a.minus(&l.times(&c));
    let terms = plant["sectors"].as_array().ok_or("no sectors")?;
    let half = Exact::dyadic(1, 1);
    let mut parts = Vec::new();
    for term in terms {
        let (g, h) = (matrix(&term["G"], random), matrix(&term["H"], random));
        let (low, high, tau) = (single(&term["low"]), single(&term["high"]), single(&term["tau"]));
        ensure(high.minus(&low).sign() >= 0, said("low <= high"))?;
        let (middle, radius) = (low.plus(&high).scaled(&half), high.minus(&low).scaled(&half));
        parts.push((g, h, low, high, tau, middle, radius));
    }
    // w = middle He + radius R He with |R| <= 1 satisfies the sector.
    for _ in 0..8 {
        let mut worst = f.clone();
        for (g, h, _, _, _, middle, radius) in &parts {
            let mut map = isometry(g.cols, h.rows, random).scaled(radius);
            if g.cols == h.rows {
                map = map.plus(&Exact::identity(h.rows).scaled(middle));
            }
            worst = worst.plus(&g.times(&map).times(h));
        }
        decays(&worst, &p, &rate(document))?;
    }
    // The matrix of the S-procedure, as it is written.
    let rate = rate(document);
    let mut corner = decrease(&f, &p, &rate).negative();
    let mut rows: Vec<Vec<Exact>> = Vec::new();
    let mut first = Vec::new();
    for (k, (g, h, low, high, tau, middle, _)) in parts.iter().enumerate() {
        corner = corner.minus(&h.transposed().times(h).scaled(&low.times(high).times(tau)));
        let mut off = p.times(g);
        if g.cols == h.rows {
            off = off.plus(&h.transposed().scaled(&middle.times(tau)));
        }
        let mut row = vec![off.transposed()];
        row.extend(parts.iter().enumerate().map(|(j, other)| {
            if j == k { Exact::identity(g.cols).scaled(tau).negative() } else { Exact::zeros(g.cols, other.0.cols) }
        }));
        rows.push(row);
        first.push(off);
    }
    first.insert(0, corner);
    rows.insert(0, first);
    margin_of(document, 1, &Exact::blocks(&rows).negative())
}
