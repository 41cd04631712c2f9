//! Falsification of linear matrix inequalities and semidefinite programs: points and multipliers are evaluated exactly,
//! and feasible points are searched that would contradict infeasibility or a bound.

use luenberger_random::Random;
use nalgebra::{DMatrix, SymmetricEigen};
use serde_json::Value;

use super::adversary::{Found, ensure, margin_of};
use super::document::{binary64, drawn, floats, number};
use super::exact::Exact;

fn items(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().expect("a count")).expect("a count of this machine")
}

fn single(value: &Value) -> Exact {
    number(value.as_str().expect("a number")).expect("a number")
}

/// `F_0, ..., F_m` of a constraint.
fn matrices(constraint: &Value, unknowns: usize) -> Vec<Exact> {
    let order = index(&constraint["order"]);
    let mut entries = vec![vec![Exact::number(0.0); order * order]; unknowns + 1];
    for entry in items(&constraint["entries"]) {
        let (k, i, j, value) = (index(&entry[0]), index(&entry[1]), index(&entry[2]), single(&entry[3]));
        for at in if i == j { vec![i * order + j] } else { vec![i * order + j, j * order + i] } {
            entries[k][at] = entries[k][at].plus(&value);
        }
    }
    entries.iter().map(|entries| Exact::from_numbers(order, order, entries)).collect()
}

fn combined(matrices: &[Exact], x: &[Exact]) -> Exact {
    matrices.iter().skip(1).zip(x).fold(matrices[0].clone(), |sum, (m, x)| sum.plus(&m.scaled(x)))
}

fn is_satisfied(m: &Exact, strict: bool) -> bool {
    if strict { m.is_positive() } else { m.is_semidefinite() }
}

pub(super) fn holds(document: &Value, _: &mut Random) -> Found {
    let inequalities = &document["inequalities"];
    let (unknowns, strict) = (index(&inequalities["unknowns"]), inequalities["relation"] == ">");
    let x: Vec<Exact> = items(&document["x"]).iter().map(single).collect();
    ensure(x.len() == unknowns, || format!("{} values of {unknowns} unknowns", x.len()))?;
    for (k, constraint) in items(&inequalities["constraints"]).iter().enumerate() {
        let m = combined(&matrices(constraint, unknowns), &x);
        ensure(is_satisfied(&m, strict), || format!("the constraint {} is false", constraint["name"]))?;
        margin_of(document, k, &m)?;
    }
    Ok(())
}

pub(super) fn refuted(document: &Value, random: &mut Random) -> Found {
    let inequalities = &document["inequalities"];
    let (unknowns, strict) = (index(&inequalities["unknowns"]), inequalities["relation"] == ">");
    let constraints: Vec<Vec<Exact>> =
        items(&inequalities["constraints"]).iter().map(|constraint| matrices(constraint, unknowns)).collect();
    // Points of all sizes: none may satisfy the constraints.
    for _ in 0..12 {
        let size = 2.0_f64.powi(random.integer(-20, 20));
        let x: Vec<Exact> = (0..unknowns)
            .map(|_| {
                Exact::number(
                    size * [random.unit(), random.sign(), 0.0, f64::from(random.integer(-3, 3))][random.below(4)],
                )
            })
            .collect();
        let feasible = constraints.iter().all(|matrices| is_satisfied(&combined(matrices, &x), strict));
        ensure(!feasible, || format!("a feasible point: {x:?}"))?;
    }
    // The dual equations.
    let multipliers = items(&document["multipliers"]);
    ensure(multipliers.len() == constraints.len(), || "a multiplier for each constraint".to_owned())?;
    let mut sums = vec![Exact::number(0.0); unknowns + 1];
    let mut zero = true;
    for (z, matrices) in multipliers.iter().zip(&constraints) {
        let n = matrices[0].rows;
        let entries: Vec<Exact> = items(z).iter().flat_map(items).map(single).collect();
        let z = Exact::from_numbers(n, n, &entries);
        ensure(z.is_semidefinite(), || "a multiplier is indefinite".to_owned())?;
        zero &= z.is_zero();
        for (sum, m) in sums.iter_mut().zip(matrices) {
            let product = m.times(&z);
            *sum = (0..n).fold(sum.clone(), |sum, i| sum.plus(&product.at(i, i)));
        }
    }
    let constant = sums[0].sign();
    ensure(sums.iter().skip(1).all(Exact::is_zero), || "a dual equation is false".to_owned())?;
    ensure(!zero && (constant < 0 || (strict && constant == 0)), || "the multipliers refute nothing".to_owned())
}

/// A number to be guided by.
fn approximate(value: &Value) -> f64 {
    binary64(items(value).first().unwrap_or(value))
}

/// A semidefinite program with numbers drawn from between its bounds; blocks that are diagonal are so by their entries.
struct Program {
    orders: Vec<usize>,
    costs: Vec<Exact>,
    /// For each block, `F_0, ..., F_m`.
    blocks: Vec<Vec<Exact>>,
    guides: Vec<Vec<DMatrix<f64>>>,
    guide_costs: Vec<f64>,
}

impl Program {
    fn of(program: &Value, random: &mut Random) -> Self {
        let orders: Vec<usize> = items(&program["blocks"])
            .iter()
            .map(|block| index(block.get("dense").or_else(|| block.get("diagonal")).expect("a block")))
            .collect();
        let costs: Vec<Exact> = items(&program["costs"]).iter().map(|cost| drawn(cost, random)).collect();
        let mut blocks: Vec<Vec<Vec<Exact>>> =
            orders.iter().map(|n| vec![vec![Exact::number(0.0); n * n]; costs.len() + 1]).collect();
        let mut guides: Vec<Vec<DMatrix<f64>>> =
            orders.iter().map(|&n| vec![DMatrix::zeros(n, n); costs.len() + 1]).collect();
        for entry in items(&program["entries"]) {
            let [k, block, i, j] = [0, 1, 2, 3].map(|part| index(&entry[part]));
            let (value, guide) = (drawn(&entry[4], random), approximate(&entry[4]));
            let n = orders[block];
            for (i, j) in if i == j { vec![(i, j)] } else { vec![(i, j), (j, i)] } {
                blocks[block][k][i * n + j] = blocks[block][k][i * n + j].plus(&value);
                guides[block][k][(i, j)] += guide;
            }
        }
        let blocks = blocks
            .iter()
            .zip(&orders)
            .map(|(matrices, &n)| matrices.iter().map(|entries| Exact::from_numbers(n, n, entries)).collect())
            .collect();
        let guide_costs = items(&program["costs"]).iter().map(approximate).collect();
        Self { orders, costs, blocks, guides, guide_costs }
    }

    /// `x_1 F_1 + ... - F_0 >= 0`, or without F_0.
    fn is_feasible(&self, x: &[Exact], constant: bool) -> bool {
        self.blocks.iter().zip(&self.orders).all(|(matrices, &n)| {
            let start = if constant { matrices[0].negative() } else { Exact::zeros(n, n) };
            matrices.iter().skip(1).zip(x).fold(start, |sum, (m, x)| sum.plus(&m.scaled(x))).is_semidefinite()
        })
    }

    fn cost(&self, x: &[Exact]) -> Exact {
        self.costs.iter().zip(x).fold(Exact::number(0.0), |sum, (c, x)| sum.plus(&c.times(x)))
    }

    /// The least eigenvalue, in floating point.
    fn slack(&self, x: &[f64]) -> f64 {
        let least = |matrices: &Vec<DMatrix<f64>>| {
            let m = matrices.iter().skip(1).zip(x).fold(-&matrices[0], |sum, (m, x)| sum + m * *x);
            if m.iter().all(|x| x.is_finite()) { SymmetricEigen::new(m).eigenvalues.min() } else { f64::NEG_INFINITY }
        };
        self.guides.iter().map(least).fold(f64::INFINITY, f64::min)
    }

    fn guide_cost(&self, x: &[f64]) -> f64 {
        self.guide_costs.iter().zip(x).map(|(c, x)| c * x).sum()
    }

    /// A feasible point, and from it downhill along random directions as far as it is feasible.
    fn search(&self, starts: Vec<Vec<f64>>, random: &mut Random) -> Vec<f64> {
        let unknowns = self.costs.len();
        let mut best = vec![0.0; unknowns];
        for x in starts {
            if self.slack(&x) > self.slack(&best)
                || (self.slack(&x) >= 0.0 && self.guide_cost(&x) < self.guide_cost(&best))
            {
                best = x;
            }
        }
        for _ in 0..24 {
            let direction = random.vector(unknowns);
            let size = best.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
            for exponent in [4, 1, 0, -2, -4, -8, -14, -22, -30] {
                let step = size * 2.0_f64.powi(exponent);
                let x: Vec<f64> = best.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
                let (here, there) = (self.slack(&best), self.slack(&x));
                let better = if here < 0.0 {
                    there > here
                } else {
                    there >= 0.0 && self.guide_cost(&x) < self.guide_cost(&best)
                };
                if better {
                    best = x;
                }
            }
        }
        best
    }
}

fn exactly(x: &[f64]) -> Option<Vec<Exact>> {
    x.iter().all(|x| x.is_finite()).then(|| x.iter().map(|x| Exact::number(*x)).collect())
}

pub(super) fn semidefinite(document: &Value, random: &mut Random) -> Found {
    let program = Program::of(&document["program"], random);
    let unknowns = program.costs.len();
    let read = |value: &Value| -> Vec<Exact> { items(value).iter().map(single).collect() };
    let mut starts: Vec<Vec<f64>> =
        (-2..12).map(|k| (0..unknowns).map(|i| if i == 0 { 4.0_f64.powi(k) } else { 0.0 }).collect()).collect();
    match document["claim"].as_str().unwrap_or_default() {
        "bounds" => {
            if let Some(upper) = document.get("upper") {
                let x = read(&upper["x"]);
                ensure(x.len() == unknowns && program.is_feasible(&x, true), || {
                    "the point of the upper bound is not feasible".to_owned()
                })?;
                let excess = program.cost(&x).minus(&single(&upper["bound"]));
                ensure(excess.sign() <= 0, || "the upper bound is below the value of its point".to_owned())?;
                starts.push(floats(&upper["x"]));
            }
            if let Some(lower) = document.get("lower")
                && random.once_in(4)
                && let Some(x) = exactly(&program.search(starts, random))
                && program.is_feasible(&x, true)
            {
                let left = program.cost(&x).minus(&single(&lower["bound"]));
                ensure(left.sign() >= 0, || format!("a feasible point below the lower bound: {x:?}"))?;
            }
            if let (Some(lower), Some(upper)) = (document.get("lower"), document.get("upper")) {
                let width = program.cost(&read(&upper["x"])).minus(&single(&lower["bound"]));
                ensure(width.sign() >= 0, || "the feasible point lies below the lower bound".to_owned())?;
            }
            Ok(())
        }
        "primal infeasible" => {
            let x = exactly(&program.search(starts, random));
            ensure(x.is_none_or(|x| !program.is_feasible(&x, true)), || "a feasible point of (P)".to_owned())
        }
        _ => {
            let x = read(&document["x"]);
            ensure(program.is_feasible(&x, false), || "x is no ray of (P)".to_owned())?;
            ensure(program.cost(&x).sign() < 0, || "c'x is not negative".to_owned())
        }
    }
}
