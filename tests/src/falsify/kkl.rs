//! Error bounds of KKL observers over a box: random designs, and an adversary that evaluates the expressions of the
//! document at points of the box, by itself, in binary64 with first derivatives.

use luenberger_proof::certificate::{CertificateFile, KklMaps};
use luenberger_random::Random;
use nalgebra::dmatrix;
use serde_json::Value;

use super::adversary::{Found, ensure, margin_of};
use super::document::{binary64, float_matrix, floats, matrix, symmetric};
use super::exact::Exact;
use crate::kkl_maps;

pub(super) fn generate(random: &mut Random) -> Option<CertificateFile> {
    let (maps, region) = match random.below(3) {
        0 => {
            let lambda = [-random.between(1.5, 3.0), -random.between(0.5, 1.4)];
            let wrong = if random.once_in(2) { random.between(0.0, 0.01) } else { 0.0 };
            let side = random.between(0.5, 2.5);
            let sides = [(-side, side), (-side - 0.5, side)];
            (kkl_maps::van_der_pol(random.between(0.2, 2.0), lambda, wrong), kkl_maps::region(&sides, &[]))
        }
        1 => {
            let (low, side) = (-random.between(0.2, 1.2), random.between(0.2, 1.0));
            let region = kkl_maps::region(&[(low, 1.0), (-2.0, 2.0), (-side, side)], &[(-0.5, 0.5)]);
            (kkl_maps::exponential_cascade(random.between(2.0, 4.0)), region)
        }
        _ => {
            let poles = [-random.between(8.0, 12.0), -random.between(14.0, 20.0)];
            let side = random.between(0.2, 0.9);
            (kkl_maps::duffing(poles), kkl_maps::region(&[(-side, side); 2], &[]))
        }
    };
    let coupling = if random.once_in(2) { 0.0 } else { random.between(-0.1, 0.1) };
    let p = dmatrix![1.0, coupling; coupling, random.between(0.5, 2.0)];
    let slowest = KklMaps::new(&maps, region.u.len()).ok()?.lambda_over(&region).ok()?;
    let rate = -slowest[(0, 0)].hi().max(slowest[(1, 1)].hi()) * random.between(0.3, 0.9);
    let bound = if random.once_in(2) {
        kkl_maps::bound(&maps, &region, &p, rate, random.between(0.05, 0.5))?
    } else {
        luenberger_design::kkl::error_bound(&maps, &region).ok()?
    };
    CertificateFile::prove("a KKL observer", bound).ok()
}

/// A number with its derivatives by the variables.
#[derive(Clone, Debug)]
struct Dual(f64, Vec<f64>);

impl Dual {
    fn constant(x: f64, n: usize) -> Self {
        Self(x, vec![0.0; n])
    }

    fn with(&self, other: &Self, value: f64, left: f64, right: f64) -> Self {
        Self(value, self.1.iter().zip(&other.1).map(|(a, b)| left * a + right * b).collect())
    }

    fn map(&self, value: f64, slope: f64) -> Self {
        Self(value, self.1.iter().map(|a| slope * a).collect())
    }
}

/// Reads and evaluates at once, by precedence climbing.
struct Evaluation<'a> {
    rest: &'a str,
    scope: &'a [(String, Dual)],
    variables: usize,
}

impl Evaluation<'_> {
    fn next(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    fn token(&mut self, accepts: impl Fn(char) -> bool) -> &str {
        let end = self.rest.find(|c| !accepts(c)).unwrap_or(self.rest.len());
        let (token, rest) = self.rest.split_at(end);
        self.rest = rest;
        token
    }

    fn expression(&mut self, level: usize) -> Option<Dual> {
        let mut left = self.operand()?;
        while let Some(operator) = self.next().filter(|c| "+-*/^".contains(*c)) {
            let of = ["+-", "*/", "^"].iter().position(|set| set.contains(operator))?;
            if of < level {
                break;
            }
            self.rest = &self.rest[1..];
            if operator == '^' {
                self.next()?;
                let sign = if self.rest.starts_with('-') { -1 } else { 1 };
                self.rest = self.rest.trim_start_matches('-').trim_start();
                let n = sign * self.token(|c| c.is_ascii_digit()).parse::<i32>().ok()?;
                left = left.map(left.0.powi(n), f64::from(n) * left.0.powi(n - 1));
                continue;
            }
            let right = self.expression(of + 1)?;
            let (a, b) = (left.0, right.0);
            left = match operator {
                '+' => left.with(&right, a + b, 1.0, 1.0),
                '-' => left.with(&right, a - b, 1.0, -1.0),
                '*' => left.with(&right, a * b, b, a),
                _ => left.with(&right, a / b, 1.0 / b, -a / (b * b)),
            };
        }
        Some(left)
    }

    fn operand(&mut self) -> Option<Dual> {
        let first = self.next()?;
        if first == '-' {
            self.rest = &self.rest[1..];
            // A power binds closer than the sign.
            let inner = self.expression(2)?;
            return Some(inner.map(-inner.0, -1.0));
        }
        if first == '(' {
            self.rest = &self.rest[1..];
            let inner = self.expression(0)?;
            self.next()?;
            self.rest = self.rest.strip_prefix(')')?;
            return Some(inner);
        }
        let n = self.variables;
        if let Some(hexadecimal) = self.rest.strip_prefix("0x") {
            let (digits, after) = hexadecimal.split_once('p')?;
            let signs = usize::from(after.starts_with(['+', '-']));
            let end = after[signs..].find(|c: char| !c.is_ascii_digit()).map_or(after.len(), |end| end + signs);
            let number = format!("0x{digits}p{}", &after[..end]);
            self.rest = &after[end..];
            return Some(Dual::constant(super::document::float(&number)?, n));
        }
        if first.is_ascii_digit() {
            return Some(Dual::constant(self.token(|c| c.is_ascii_digit() || c == '.').parse().ok()?, n));
        }
        let name = self.token(|c| c.is_ascii_alphanumeric()).to_owned();
        if let Some((_, value)) = self.scope.iter().find(|(known, _)| *known == name) {
            return Some(value.clone());
        }
        let argument = self.operand()?;
        let x = argument.0;
        let (value, slope) = match name.as_str() {
            "sin" => (x.sin(), x.cos()),
            "cos" => (x.cos(), -x.sin()),
            "exp" => (x.exp(), x.exp()),
            "ln" => (x.ln(), 1.0 / x),
            "sqrt" => (x.sqrt(), 0.5 / x.sqrt()),
            "tanh" => (x.tanh(), 1.0 - x.tanh() * x.tanh()),
            "atan" => (x.atan(), 1.0 / (1.0 + x * x)),
            _ => return None,
        };
        Some(argument.map(value, slope))
    }
}

fn values(list: &Value, scope: &[(String, Dual)], variables: usize) -> Option<Vec<Dual>> {
    let one = |text: &Value| Evaluation { rest: text.as_str()?, scope, variables }.expression(0);
    list.as_array()?.iter().map(one).collect()
}

fn named(letter: &str, values: &[Dual]) -> Vec<(String, Dual)> {
    values.iter().enumerate().map(|(k, value)| (format!("{letter}{}", k + 1), value.clone())).collect()
}

fn plain(letter: &str, values: &[f64], n: usize) -> Vec<(String, Dual)> {
    named(letter, &values.iter().map(|x| Dual::constant(*x, n)).collect::<Vec<_>>())
}

/// A point between bounds, most often a corner or near one.
fn point(ranges: &Value, random: &mut Random) -> Vec<f64> {
    let coordinate = |range: &Value| {
        let (lo, hi) = (binary64(&range[0]), binary64(&range[1]));
        match random.below(4) {
            0 => lo,
            1 => hi,
            _ => random.between(lo, hi).clamp(lo, hi),
        }
    };
    ranges.as_array().into_iter().flatten().map(coordinate).collect()
}

/// Beyond, terms that cancel lose more than that.
const LARGEST: f64 = 10.0;

/// What binary64 may lose in the evaluation of these expressions, at coordinates below [`LARGEST`].
const ROUNDING: f64 = 1e-9;

/// Whether it is larger, or not a number.
fn exceeds(x: f64, bound: f64) -> bool {
    x.is_nan() || x > bound
}

/// Everything at one point of the box.
fn at_a_point(document: &Value, random: &mut Random) -> Option<Found> {
    let (plant, observer, claims) = (&document["plant"], &document["observer"], &document["bounds"]);
    let (x, u) = (point(&document["box"]["x"], random), point(&document["box"]["u"], random));
    if x.iter().chain(&u).any(|x| x.abs() > LARGEST) {
        return Some(Ok(()));
    }
    let n = x.len();
    let seeds: Vec<Dual> =
        x.iter().enumerate().map(|(k, x)| Dual(*x, (0..n).map(|j| f64::from(u8::from(j == k))).collect())).collect();
    let x_scope = named("x", &seeds);
    let u_scope = plain("u", &u, n);
    let f = values(&plant["f"], &[x_scope.clone(), u_scope.clone()].concat(), n)?;
    let h = values(&plant["h"], &x_scope, n)?;
    let phi = values(&observer["phi"], &x_scope, n)?;
    let z = values(&observer["estimated"], &x_scope, n)?;
    let q = phi.len();
    let y: Vec<f64> = h.iter().map(|y| y.0).collect();
    let measured = [u_scope, plain("y", &y, n)].concat();
    let b = values(&observer["B"], &measured, n)?;
    let mut gain = Vec::new();
    for row in observer["Lambda"].as_array()? {
        gain.push(values(row, &measured, n)?);
    }
    for (i, row) in gain.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            let bounds = &document["lyapunov"]["Lambda"][i][j];
            let (lo, hi) = match bounds {
                Value::Array(ends) => (binary64(&ends[0]), binary64(&ends[1])),
                _ => (binary64(bounds), binary64(bounds)),
            };
            let room = ROUNDING * (1.0 + entry.0.abs());
            let holds = entry.0 >= lo - room && entry.0 <= hi + room;
            if !holds {
                return Some(ensure(false, || format!("false: Lambda({i}, {j}) = {} at {x:?}, {u:?}", entry.0)));
            }
        }
    }
    let residuals = floats(&claims["residual"]);
    for i in 0..q {
        let (mut sum, mut size) = (-b[i].0, b[i].0.abs());
        for (slope, f) in phi[i].1.iter().zip(&f) {
            sum += slope * f.0;
            size += (slope * f.0).abs();
        }
        for j in 0..q {
            sum -= gain[i][j].0 * phi[j].0;
            size += (gain[i][j].0 * phi[j].0).abs();
        }
        if exceeds(sum.abs(), residuals[i] + ROUNDING * (1.0 + size)) {
            return Some(ensure(false, || format!("false: the residual {i} is {sum} at {x:?}, {u:?}")));
        }
    }
    // Two errors with V <= start, against the Lipschitz constant, and the whole estimate.
    let p = float_matrix(&document["lyapunov"]["P"]);
    // Beyond that the maps of a mutant have no finite value.
    let start = binary64(&claims["start"]).min(1e50);
    let error = |random: &mut Random| {
        let e = nalgebra::DVector::from_vec(random.vector(q));
        let v = (e.dot(&(&p * &e))).sqrt();
        let size = [1.0, 1.0, 0.01, random.between(0.0, 1.0)][random.below(4)];
        e * (size * start / v)
    };
    let errors = [nalgebra::DVector::zeros(q), error(random), error(random)];
    let mut estimates = Vec::new();
    for e in &errors {
        let xi: Vec<f64> = phi.iter().zip(e.iter()).map(|(phi, e)| phi.0 + e).collect();
        estimates.push(values(&observer["left_inverse"], &[plain("xi", &xi, n), measured.clone()].concat(), n)?);
    }
    let (lipschitz, defect) = (floats(&claims["lipschitz"]), floats(&claims["defect"]));
    for k in 0..z.len() {
        let size = 1.0 + z[k].0.abs() + estimates[0][k].0.abs();
        let missed = (z[k].0 - estimates[0][k].0).abs();
        if exceeds(missed, defect[k] + ROUNDING * size) {
            return Some(ensure(false, || format!("false: the defect {k} is {missed} at {x:?}, {u:?}")));
        }
        for (one, other) in [(0, 1), (0, 2), (1, 2)] {
            let e = &errors[one] - &errors[other];
            let allowed = lipschitz[k] * e.dot(&(&p * &e)).sqrt();
            let change = (estimates[one][k].0 - estimates[other][k].0).abs();
            if exceeds(change, allowed + ROUNDING * size) {
                return Some(ensure(false, || format!("false: phi^L_{k} changes by {change} at {x:?}, {u:?}")));
            }
        }
    }
    Some(Ok(()))
}

/// `|M (Phi(x) - Phi(z))| >= modulus |x - z|` for two points of the box.
fn separated(document: &Value, random: &mut Random) -> Option<Found> {
    let image = |x: &[f64]| -> Option<Vec<f64>> {
        let scope = plain("x", x, 0);
        let phi = values(&document["observer"]["phi"], &scope, 0)?;
        let h = values(&document["plant"]["h"], &scope, 0)?;
        Some(phi.iter().chain(&h).map(|value| value.0).collect())
    };
    let (x, z) = (point(&document["box"]["x"], random), point(&document["box"]["x"], random));
    if x.iter().chain(&z).any(|x| x.abs() > LARGEST) {
        return Some(Ok(()));
    }
    let (first, second) = (image(&x)?, image(&z)?);
    let apart = nalgebra::DVector::from_iterator(first.len(), first.iter().zip(&second).map(|(a, b)| a - b));
    let m = float_matrix(&document["injectivity"]["M"]);
    let distance = x.iter().zip(&z).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let size: f64 = first.iter().chain(&second).map(|x| x.abs()).sum::<f64>() * m.norm();
    let found = (m * apart).norm();
    let least = binary64(&document["injectivity"]["modulus"]) * distance;
    Some(ensure(found >= least - ROUNDING * (1.0 + size), || format!("false: the modulus, at {x:?} and {z:?}")))
}

pub(super) fn contradicted(document: &Value, random: &mut Random) -> Found {
    let p = symmetric(&document["lyapunov"]["P"], random);
    let w = symmetric(&document["lyapunov"]["W"], random);
    ensure(p.is_positive(), || "false: P > 0".to_owned())?;
    margin_of(document, 2, &p)?;
    let q = p.rows;
    let number = |value: &Value| Exact::number(binary64(value));
    let rate = number(&document["lyapunov"]["rate"]);
    for _ in 0..12 {
        let shifted = matrix(&document["lyapunov"]["Lambda"], random).plus(&Exact::identity(q).scaled(&rate));
        let decrease = p.times(&shifted).he().negative();
        ensure(decrease.is_positive(), || "false: the decrease".to_owned())?;
        margin_of(document, 3, &decrease)?;
    }
    // W >= P^-1 is P W P >= P.
    ensure(p.times(&w).times(&p).minus(&p).is_semidefinite(), || "false: W >= P^-1".to_owned())?;
    let claims = &document["bounds"];
    let residual: Vec<Exact> = floats(&claims["residual"]).into_iter().map(Exact::number).collect();
    let mut square = Exact::number(0.0);
    for (i, left) in residual.iter().enumerate() {
        for (j, right) in residual.iter().enumerate() {
            let weight = if p.at(i, j).sign() < 0 { p.at(i, j).negative() } else { p.at(i, j) };
            square = square.plus(&weight.times(left).times(right));
        }
    }
    let limit = number(&claims["limit"]);
    let ball = rate.times(&limit);
    ensure(ball.times(&ball).minus(&square).sign() >= 0, || "false: the limit".to_owned())?;
    ensure(number(&claims["start"]).minus(&limit).sign() > 0, || "false: limit < start".to_owned())?;
    for (k, eventual) in floats(&claims["eventual"]).into_iter().enumerate() {
        let of = |name: &str| number(&claims[name][k]);
        let needed = of("lipschitz").times(&limit).plus(&of("defect"));
        ensure(Exact::number(eventual).minus(&needed).sign() >= 0, || format!("false: the eventual bound {k}"))?;
    }
    if document["injectivity"].is_object() {
        let of = &document["injectivity"];
        let (m, modulus) = (matrix(&of["M"], random), number(&of["modulus"]));
        for _ in 0..12 {
            let separation = m.times(&matrix(&of["Jacobian"], random)).he();
            let n = separation.rows;
            let left = separation.minus(&Exact::identity(n).scaled(&modulus.plus(&modulus)));
            ensure(left.is_positive(), || "false: M J + J'M' > 2 modulus I".to_owned())?;
            margin_of(document, 11, &left)?;
        }
        let of_phi = m.view(0, 0, m.rows, q);
        let spread = number(&of["spread"]);
        let left = p.scaled(&spread.times(&spread)).minus(&of_phi.transposed().times(&of_phi));
        ensure(left.is_semidefinite(), || "false: spread^2 P >= M_phi'M_phi".to_owned())?;
        margin_of(document, 12, &left)?;
        for _ in 0..20 {
            separated(document, random).unwrap_or_else(|| Err("false: an expression cannot be read".to_owned()))?;
        }
    }
    for _ in 0..60 {
        match at_a_point(document, random) {
            Some(found) => found?,
            None => return Err("false: an expression that the adversary cannot read".to_owned()),
        }
    }
    Ok(())
}
