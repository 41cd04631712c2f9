//! Random studies of every kind of observer, as text.
//!
//! A plant is drawn from a family, then one to three observers that its kind can have. The families contain what has
//! misled designs: stiff and badly scaled plants, unobservable and nearly unobservable ones, chains with disguised
//! rows, Jordan blocks, kinks, jumps, explicit time, inputs that are 0 at first, and outputs that are no state.

use std::fmt::Write;

use luenberger_random::Random;

use super::document::number;

/// A generator of the observers of one kind: a study text.
type Generator = fn(&mut Random) -> String;

/// The generator of each kind.
pub(super) const GENERATORS: &[(&str, Generator)] = &[
    ("luenberger", |random| linear_study(random, "luenberger")),
    ("kalman", |random| linear_study(random, "kalman")),
    ("cubic", |random| linear_study(random, "cubic")),
    ("optimal-cubic", |random| linear_study(random, "optimal-cubic")),
    ("proportional-integral", |random| linear_study(random, "proportional-integral")),
    ("extended-state", |random| linear_study(random, "extended-state")),
    ("unknown-input", |random| linear_study(random, "unknown-input")),
    ("interval", |random| linear_study(random, "interval")),
    ("sliding-mode", sliding_mode),
    ("functional", |random| linear_study(random, "functional")),
    ("reduced-order", |random| linear_study(random, "reduced-order")),
    ("h-infinity", |random| linear_study(random, "h-infinity")),
    ("h2", |random| linear_study(random, "h2")),
    ("sampled-cubic", |random| linear_study(random, "sampled-cubic")),
    ("lpv", |random| expression_study(random, "lpv")),
    ("lipschitz", |random| expression_study(random, "lipschitz")),
    ("mean-value", |random| expression_study(random, "mean-value")),
    ("high-gain", |random| expression_study(random, "high-gain")),
    ("extended-kalman", |random| expression_study(random, "extended-kalman")),
    ("iterated-extended-kalman", |random| expression_study(random, "iterated-extended-kalman")),
    ("error-state-kalman", |random| expression_study(random, "error-state-kalman")),
    ("ukf", |random| expression_study(random, "ukf")),
    ("mhe", |random| expression_study(random, "mhe")),
    ("particle", |random| expression_study(random, "particle")),
    ("imm", |random| expression_study(random, "imm")),
    ("kkl", maps),
    ("pebo", parameters),
    ("kkl-peb", parameters),
    ("immersion-invariance", maps),
    ("kkl-numerical", numerical),
];

/// The study of this number.
///
/// # Panics
/// For a kind without a generator.
pub(super) fn study(kind: &str, random: &mut Random) -> String {
    let Some((_, generate)) = GENERATORS.iter().find(|(name, _)| *name == kind) else {
        panic!("the kind {kind} has no generator in generate.rs");
    };
    generate(random)
}

/// A number with few digits.
fn short(random: &mut Random, low: f64, high: f64) -> f64 {
    let x = random.between(low, high);
    let digits = 10f64.powi(1 - x.abs().max(1e-300).log10().floor() as i32);
    (x * digits).round() / digits
}

/// A number of any usual magnitude.
fn magnitude(random: &mut Random, exponents: i32) -> f64 {
    let of_ten = 10f64.powi(random.integer(-exponents, exponents));
    f64::from(random.integer(1, 9)) * of_ten
}

fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

fn rows(m: &[Vec<f64>]) -> String {
    format!("[{}]", m.iter().map(|row| list(row)).collect::<Vec<_>>().join(", "))
}

fn texts(rows: &[String]) -> String {
    format!("[{}]", rows.iter().map(|row| format!("\"{row}\"")).collect::<Vec<_>>().join(", "))
}

/// A linear plant.
struct Linear {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    d: Option<Vec<Vec<f64>>>,
    dt: Option<f64>,
}

fn filled(random: &mut Random, n: usize, m: usize, sparse: usize) -> Vec<Vec<f64>> {
    let mut entry = || if random.below(10) < sparse { 0.0 } else { short(random, -2.0, 2.0) };
    (0..n).map(|_| (0..m).map(|_| entry()).collect()).collect()
}

impl Linear {
    fn random(random: &mut Random, is_discrete: bool) -> Self {
        let n = 1 + random.below(3);
        let p = if n > 1 && random.once_in(3) { 2 } else { 1 };
        let m = usize::from(!random.once_in(4));
        let mut a = filled(random, n, n, 3);
        let mut c = filled(random, p, n, 4);
        match random.below(9) {
            // A chain of integrators, or Jordan blocks.
            0 => {
                let value = if random.once_in(2) { 0.0 } else { short(random, -2.0, 0.5) };
                for (i, row) in a.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        *entry = if i == j { value } else { f64::from(u8::from(j == i + 1)) };
                    }
                }
            }
            // Stiff.
            1 => {
                let fast = magnitude(random, 9);
                for x in &mut a[n - 1] {
                    *x *= fast;
                }
            }
            // A part that no output sees: stable, unstable, or slow.
            2 | 3 if n > 1 => {
                let rate = match random.below(4) {
                    0 => magnitude(random, 9),
                    1 => 0.0,
                    _ => -magnitude(random, 9),
                };
                for row in &mut a[..n - 1] {
                    row[n - 1] = 0.0;
                }
                a[n - 1][n - 1] = rate;
                for row in &mut c {
                    row[n - 1] = 0.0;
                }
                // Nearly.
                if random.once_in(3) {
                    a[0][n - 1] = 10f64.powi(-random.integer(6, 16));
                }
            }
            _ => {}
        }
        if c.iter().all(|row| row.iter().all(|x| *x == 0.0)) {
            c[0][0] = 1.0;
        }
        if p == 2 && c[0] == c[1] && !random.once_in(4) {
            c[1][n - 1] += 1.0;
        }
        let mut b = filled(random, n, m, 2);
        if is_discrete {
            let size: f64 = a.iter().flatten().fold(0.5, |most: f64, x| most.max(x.abs()));
            for x in a.iter_mut().flatten() {
                *x = (*x / size * 1e3).round() / 1e3;
            }
        }
        // Other units.
        if random.once_in(3) {
            let exponents = if random.once_in(2) { 3 } else { 9 };
            let units: Vec<f64> = (0..n).map(|_| 10f64.powi(random.integer(-exponents, exponents))).collect();
            for i in 0..n {
                for j in 0..n {
                    a[i][j] *= units[i] / units[j];
                }
                for x in &mut b[i] {
                    *x *= units[i];
                }
                for row in &mut c {
                    row[i] /= units[i];
                }
            }
        }
        if random.once_in(4) {
            let scale = magnitude(random, 6);
            for x in &mut c[0] {
                *x *= scale;
            }
        }
        // Time in other units.
        if !is_discrete && random.once_in(6) {
            let scale = 10f64.powi(random.integer(-6, 6));
            for x in a.iter_mut().chain(&mut b).flatten() {
                *x *= scale;
            }
        }
        let d = (m > 0 && random.once_in(12)).then(|| filled(random, p, m, 2));
        Self { a, b, c, d, dt: is_discrete.then(|| [1.0, 0.1, 0.01][random.below(3)]) }
    }

    fn states(&self) -> usize {
        self.a.len()
    }

    fn inputs(&self) -> usize {
        self.b[0].len()
    }

    fn outputs(&self) -> usize {
        self.c.len()
    }

    fn text(&self) -> String {
        let mut text = format!("[plant]\na = {}\n", rows(&self.a));
        if self.inputs() > 0 {
            _ = writeln!(text, "b = {}", rows(&self.b));
        }
        _ = writeln!(text, "c = {}", rows(&self.c));
        if let Some(d) = &self.d {
            _ = writeln!(text, "d = {}", rows(d));
        }
        if let Some(dt) = self.dt {
            _ = writeln!(text, "dt = {}", number(dt));
        }
        text
    }

    /// The magnitude of the motion: poles are a few times that.
    fn speed(&self) -> f64 {
        let largest = self.a.iter().enumerate().map(|(i, row)| row[i].abs());
        largest.fold(0.0, f64::max).clamp(1e-3, 1e6)
    }

    fn poles(&self, random: &mut Random, count: usize) -> String {
        if self.dt.is_some() {
            let poles: Vec<f64> =
                (0..count).map(|k| (random.between(-0.2, 0.9) * 100.0).round() / 100.0 + 0.001 * k as f64).collect();
            return list(&poles);
        }
        let first = self.speed() * f64::from(random.integer(1, 3));
        if count == 2 && random.once_in(3) {
            let (re, im) = (number(-first), number(first));
            return format!("[[{re}, {im}], [{re}, -{im}]]");
        }
        let same = random.once_in(12);
        list(&(0..count).map(|k| -first * if same { 1.0 } else { 1.0 + 0.5 * k as f64 }).collect::<Vec<_>>())
    }

    fn gain(&self, random: &mut Random, count: usize) -> String {
        let p = self.outputs();
        let speed = self.dt.map_or(self.speed(), f64::recip);
        match random.below(8) {
            0 => "lmi = true".to_owned(),
            1 => format!("decay_rate = {}", number(short(random, 0.05, 2.0) * speed)),
            2 => {
                let w: Vec<f64> = (0..count).map(|_| magnitude(random, 2)).collect();
                let v: Vec<f64> = (0..p).map(|_| magnitude(random, 2)).collect();
                format!("kalman = {{ w = {}, v = {} }}", list(&w), list(&v))
            }
            3 => {
                let scale: f64 = self.c.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
                let gain = filled(random, count, p, 2);
                let gain: Vec<Vec<f64>> =
                    gain.iter().map(|row| row.iter().map(|x| x * self.speed() / scale.max(1e-9)).collect()).collect();
                format!("gain = {}", rows(&gain))
            }
            _ => format!("poles = {}", self.poles(random, count)),
        }
    }

    fn bounds(&self, random: &mut Random) -> String {
        let noise: Vec<f64> = (0..self.outputs()).map(|_| magnitude(random, 2)).collect();
        let mut bounds = format!("noise = {}", list(&noise));
        if random.once_in(2) {
            let e = filled(random, self.states(), 1, 3);
            _ = write!(bounds, ", disturbance = [{}], e = {}", number(magnitude(random, 1)), rows(&e));
        }
        format!("{{ {bounds} }}")
    }

    /// The keys of an observer of this kind.
    fn observer(&self, random: &mut Random, kind: &str) -> String {
        let (n, p) = (self.states(), self.outputs());
        let mut text = format!("kind = \"{kind}\"\n");
        match kind {
            "luenberger" => {
                _ = writeln!(text, "{}", self.gain(random, n));
                if random.once_in(4) {
                    _ = writeln!(text, "bounds = {}", self.bounds(random));
                }
            }
            "kalman" => {
                let w: Vec<f64> = (0..n).map(|_| if random.once_in(4) { 0.0 } else { magnitude(random, 3) }).collect();
                let v: Vec<f64> = (0..p).map(|_| magnitude(random, 3)).collect();
                _ = writeln!(text, "w = {}\nv = {}", list(&w), list(&v));
                if self.dt.is_some() && random.once_in(3) {
                    text.push_str("form = \"filter\"\n");
                }
            }
            "cubic" => {
                let exponents = if random.once_in(6) { 9 } else { 2 };
                let strength = magnitude(random, exponents);
                _ = writeln!(text, "{}\ngamma = {}", self.gain(random, n), number(strength));
                if random.once_in(5) {
                    let theta: Vec<f64> = (0..p).map(|_| magnitude(random, 8)).collect();
                    _ = writeln!(text, "theta = {}", list(&theta));
                }
                if random.once_in(4) {
                    _ = writeln!(text, "bounds = {}", self.bounds(random));
                }
            }
            "sampled-cubic" => {
                let period = self.dt.unwrap_or_else(|| [0.01, 0.1, 0.5][random.below(3)]);
                let strength = number(magnitude(random, 2));
                let key = ["gamma", "weighted"][random.below(2)];
                _ = writeln!(text, "{}\n{key} = {strength}\nperiod = {}", self.gain(random, n), number(period));
                if self.dt.is_none() && random.once_in(3) {
                    _ = writeln!(
                        text,
                        "jitter = [{}, {}]\nmisses = {}",
                        number(period * 0.8),
                        number(period * 1.2),
                        random.below(3)
                    );
                }
            }
            "optimal-cubic" => {
                let first: Vec<f64> = (0..n).map(|_| magnitude(random, 1)).collect();
                _ = writeln!(text, "first_errors = {}\nhorizon = 10", list(&first));
                let deviation: Vec<f64> = (0..p).map(|_| magnitude(random, 1)).collect();
                _ = writeln!(text, "noise_deviation = {}\nnoise_period = 0.01", list(&deviation));
            }
            "proportional-integral" | "extended-state" => {
                _ = writeln!(text, "e = {}", rows(&filled(random, n, 1, 3)));
                let order = if kind == "extended-state" && random.once_in(2) { 2 } else { 1 };
                if order == 2 {
                    text.push_str("order = 2\n");
                }
                if kind == "extended-state" && random.once_in(2) {
                    let speed = self.dt.map_or(self.speed() * 2.0, |dt| 0.5 / dt);
                    _ = writeln!(text, "bandwidth = {}", number(speed));
                } else {
                    _ = writeln!(text, "{}", self.gain(random, n + order));
                }
                if kind == "proportional-integral" && self.dt.is_none() && random.once_in(4) {
                    _ = writeln!(text, "gamma = {}", number(magnitude(random, 6)));
                }
                if random.once_in(4) {
                    let noise: Vec<f64> = (0..p).map(|_| magnitude(random, 2)).collect();
                    _ = writeln!(
                        text,
                        "rate = [{}]\nbounds = {{ noise = {} }}",
                        number(magnitude(random, 2)),
                        list(&noise)
                    );
                }
            }
            "unknown-input" => {
                _ = writeln!(text, "e = {}\n{}", rows(&filled(random, n, 1, 3)), self.gain(random, n));
                if random.once_in(3) {
                    _ = writeln!(text, "f = {}", rows(&filled(random, p, 1, 3)));
                }
                if random.once_in(4) {
                    _ = writeln!(text, "gamma = {}", number(magnitude(random, 6)));
                }
            }
            "interval" => {
                let first: Vec<f64> = (0..n).map(|_| magnitude(random, 2)).collect();
                let bounds = self.bounds(random);
                _ = writeln!(text, "initial_bounds = {}\nbounds = {bounds}", list(&first));
                if random.once_in(3) && bounds.contains("disturbance") {
                    text.push_str("least_width = true\n");
                } else {
                    _ = writeln!(text, "{}", self.gain(random, n));
                    if random.once_in(3) {
                        text.push_str("coordinates = \"plant\"\n");
                    }
                }
            }
            "reduced-order" => _ = writeln!(text, "poles = {}", self.poles(random, n.saturating_sub(p))),
            "functional" => {
                let q = 1 + random.below(n);
                if random.once_in(3) {
                    let (k, poles) = (rows(&filled(random, q.min(2), n, 3)), self.poles(random, n));
                    _ = writeln!(text, "k = {k}\npoles = {poles}\norder = \"least\"");
                } else {
                    _ = writeln!(text, "k = {}\npoles = {}", rows(&filled(random, q, n, 3)), self.poles(random, q));
                }
            }
            _ => {
                // h2 and h-infinity: process noise, measurement noise.
                let scale = magnitude(random, 3);
                let mut e = vec![vec![0.0; n + p]; n];
                let mut d = vec![vec![0.0; n + p]; p];
                for (i, row) in e.iter_mut().enumerate() {
                    row[i] = magnitude(random, 2) * scale;
                }
                for (k, row) in d.iter_mut().enumerate() {
                    row[n + k] = magnitude(random, 3) * scale;
                }
                _ = writeln!(text, "e = {}\nd = {}", rows(&e), rows(&d));
                match random.below(4) {
                    0 => _ = writeln!(text, "gamma = {}", number(magnitude(random, 3) * scale)),
                    1 => {
                        let size: f64 = self.c.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
                        let gain = filled(random, n, p, 2);
                        let gain: Vec<Vec<f64>> = gain
                            .iter()
                            .map(|row| row.iter().map(|x| x * self.speed() / size.max(1e-9)).collect())
                            .collect();
                        _ = writeln!(text, "gain = {}", rows(&gain));
                    }
                    _ => {}
                }
            }
        }
        text
    }
}

/// The kinds for linear plants.
const LINEAR: [&str; 13] = [
    "luenberger",
    "kalman",
    "cubic",
    "optimal-cubic",
    "proportional-integral",
    "extended-state",
    "unknown-input",
    "interval",
    "functional",
    "reduced-order",
    "h-infinity",
    "h2",
    "sampled-cubic",
];

/// Those of them for discrete time.
const DISCRETE: [&str; 11] = [
    "luenberger",
    "kalman",
    "proportional-integral",
    "extended-state",
    "interval",
    "h-infinity",
    "h2",
    "sampled-cubic",
    "functional",
    "reduced-order",
    "unknown-input",
];

fn linear_study(random: &mut Random, kind: &str) -> String {
    let is_discrete = DISCRETE.contains(&kind) && random.once_in(4);
    let plant = Linear::random(random, is_discrete);
    let (n, m) = (plant.states(), plant.inputs());
    let mut text = plant.text();
    let x0: Vec<f64> = (0..n).map(|_| magnitude(random, 1)).collect();
    let hold = plant.dt.unwrap_or(0.01);
    if m > 0 && matches!(kind, "luenberger" | "kalman" | "cubic") && random.once_in(4) {
        let k = filled(random, m, n, 2);
        _ = writeln!(text, "[input]\nfeedback = {{ k = {}, observer = \"a\" }}", rows(&k));
    } else if m > 0 && random.once_in(2) {
        let inputs = vec!["0.5*sin(t)".to_owned(); m];
        _ = writeln!(text, "[input]\nexpressions = {}", texts(&inputs));
    }
    if random.once_in(3) {
        let samples = 51;
        _ = writeln!(text, "[simulation]\nx0 = {}\nduration = {}\nsamples = {samples}", list(&x0), number(50.0 * hold));
        if plant.dt.is_none() {
            _ = writeln!(text, "hold = {}", number(hold));
        }
        if random.once_in(3) {
            let amplitude: Vec<f64> = (0..plant.outputs()).map(|_| short(random, 0.001, 0.1)).collect();
            _ = writeln!(
                text,
                "noise = {{ distribution = \"uniform\", amplitude = {}, period = {}, seed = 1 }}",
                list(&amplitude),
                number(hold)
            );
        }
    }
    _ = write!(text, "[[observer]]\nname = \"a\"\n{}", plant.observer(random, kind));
    let others: &[&str] = if is_discrete { &DISCRETE } else { &LINEAR };
    for name in ["b", "c"] {
        if kind != "optimal-cubic" && random.once_in(2) {
            let mut other = others[random.below(others.len())];
            if other == "optimal-cubic" {
                other = "luenberger";
            }
            _ = write!(text, "[[observer]]\nname = \"{name}\"\n{}", plant.observer(random, other));
        }
    }
    text
}

/// A plant in expressions.
struct Rows {
    f: Vec<String>,
    h: Vec<String>,
    inputs: usize,
    /// Bounds of the states, if the plant needs them or the study gives them.
    region: Option<Vec<(f64, f64)>>,
    is_bounded_by_need: bool,
}

/// A term that bends: of `x`, of the size of 1; and whether it needs a bounded region.
fn bent(random: &mut Random, x: &str) -> (String, bool) {
    let c = short(random, 0.1, 2.0);
    let g = number(short(random, 0.2, 2.0));
    match random.below(16) {
        0 => (format!("{g}*sin({x})"), false),
        1 => (format!("{g}*tan({x})"), true),
        2 => (format!("{g}*ln({}+{x}^2)", number(c)), false),
        3 => (format!("{g}*sqrt({}+{x}^2)", number(c)), false),
        4 => (format!("{g}*abs({x})"), false),
        5 => (format!("{g}*sat({x}, -{}, {})", number(c), number(c)), false),
        6 => (format!("{g}*min({x}, {})", number(c)), false),
        7 => (format!("{g}*max({x}, -{})", number(c)), false),
        8 => (format!("{g}*({x} - sat({x}, -{}, {}))", number(c), number(c)), false),
        9 => (format!("{g}*step({x} - {})", number(c)), false),
        10 => (format!("if({x} > {}, {g}, 0)", number(c)), false),
        11 => (format!("{g}*sign({x})"), false),
        12 => (format!("{g}*{x}^3"), true),
        13 => (format!("{g}*tanh({x})"), false),
        14 => (format!("if({x} > {}, {g}*({x} - {}), 0)", number(c), number(c)), false),
        _ => (format!("{g}*{x}/(1+{x}^2)"), false),
    }
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let (mut done, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(from) {
        let before = rest[..at].chars().next_back().or_else(|| done.chars().next_back());
        let after = rest[at + from.len()..].chars().next();
        done.push_str(&rest[..at]);
        let is_word = !before.is_some_and(is_part) && !after.is_some_and(is_part);
        done.push_str(if is_word { to } else { from });
        rest = &rest[at + from.len()..];
    }
    done.push_str(rest);
    done
}

impl Rows {
    fn random(random: &mut Random) -> Self {
        let n = 1 + random.below(3);
        let stiff = if random.once_in(8) { magnitude(random, 10) } else { 1.0 };
        let (mut f, mut needs) = (Vec::new(), false);
        let mut inputs = 0;
        // A chain in which the last state, or each, bends.
        for i in 0..n {
            let own = number(short(random, 0.2, 3.0));
            let mut row = format!("-{own}*x{}", i + 1);
            if i + 1 < n && !random.once_in(6) {
                row = match random.below(6) {
                    0 => format!("x{}", i + 2),
                    1 => format!("{row} + x{}*cos(t)", i + 2),
                    2 => format!("{row} + sat(x{}, -3, 3)", i + 2),
                    _ => format!("{row} + x{}", i + 2),
                };
            }
            if i > 0 && random.once_in(2) {
                _ = write!(row, " - {}*x{i}", number(short(random, 0.1, 2.0)));
            }
            if i + 1 == n || random.once_in(3) {
                let whose = format!("x{}", 1 + random.below(n));
                let (term, bounded) = bent(random, &whose);
                needs |= bounded;
                _ = write!(row, " {} {term}", if random.once_in(2) { "+" } else { "-" });
            }
            match random.below(9) {
                0 => _ = write!(row, " + {}*sin(t)", number(short(random, 0.1, 1.0))),
                1 => {
                    _ = write!(row, " + u1");
                    inputs = 1;
                }
                2 => {
                    _ = write!(row, " + x{}*u1", 1 + random.below(n));
                    inputs = 1;
                }
                3 if n > 1 => _ = write!(row, " + if(t > 5, 0, 0.5)*x{}", 1 + random.below(n)),
                _ => {}
            }
            f.push(row);
        }
        // A state that nothing sees, with a will of its own.
        if n > 1 && random.once_in(6) {
            let name = format!("x{n}");
            let slow = number(magnitude(random, 6));
            f[n - 1] = format!("{slow}*(-{name} + {}*sin({name}))", number(short(random, 0.2, 2.0)));
            for row in &mut f[..n - 1] {
                *row = replaced(row, &name, "0");
            }
        }
        if stiff != 1.0 {
            f[0] = format!("{}*({})", number(stiff), f[0]);
        }
        let measured = format!("x{}", if random.once_in(3) { 1 + random.below(n) } else { 1 });
        let mut h = vec![match random.below(12) {
            0 => format!("{}*{measured}", number(magnitude(random, 6))),
            1 => format!("{measured} + {}*sin(t)", number(short(random, 0.1, 1.0))),
            2 => format!("sat({measured}, -2, 2)"),
            3 if n > 1 => format!("x1 + {}*x2", number(short(random, 0.1, 2.0))),
            4 if inputs > 0 => format!("{measured} + 0.5*u1"),
            _ => measured,
        }];
        if n > 2 && random.once_in(4) {
            h.push("x2".to_owned());
        }
        // Other units: a state is its number times the unit.
        if random.once_in(5) {
            for k in 0..n {
                let unit = 10f64.powi(random.integer(-9, 9));
                let name = format!("x{}", k + 1);
                let scaled = format!("({name}*{})", number(1.0 / unit));
                for row in f.iter_mut().chain(&mut h) {
                    *row = replaced(row, &name, &scaled);
                }
                f[k] = format!("{}*({})", number(unit), f[k]);
            }
            needs = false;
        }
        let wanted = needs || random.once_in(3);
        let region = wanted.then(|| {
            (0..n)
                .map(|_| {
                    let half = if needs { short(random, 0.3, 1.4) } else { short(random, 0.5, 20.0) };
                    (-half, half)
                })
                .collect()
        });
        Self { f, h, inputs, region, is_bounded_by_need: needs }
    }

    fn text(&self) -> String {
        let mut text = format!("[plant]\nf = {}\nh = {}\n", texts(&self.f), texts(&self.h));
        if self.inputs > 0 {
            _ = writeln!(text, "inputs = [\"u1\"]");
        }
        text
    }

    fn region(&self, random: &mut Random) -> Option<String> {
        let states = self.region.as_ref()?;
        let pairs: Vec<Vec<f64>> = states.iter().map(|(low, high)| vec![*low, *high]).collect();
        let inputs =
            if self.inputs > 0 && (self.is_bounded_by_need || random.once_in(2)) { ", inputs = [[-1, 1]]" } else { "" };
        Some(format!("region = {{ states = {}{inputs} }}\n", rows(&pairs)))
    }

    fn observer(&self, random: &mut Random, kind: &str) -> String {
        let (n, p) = (self.f.len(), self.h.len());
        let mut text = format!("kind = \"{kind}\"\n");
        match kind {
            "lpv" | "lipschitz" | "mean-value" => {
                text.extend(self.region(random));
                match random.below(4) {
                    0 => _ = writeln!(text, "decay_rate = {}", number(short(random, 0.01, 1.0))),
                    1 if kind == "lpv" => text.push_str("fastest = 3\n"),
                    2 if kind != "mean-value" => {
                        let gain = filled(random, n, p, 1);
                        let gain: Vec<Vec<f64>> =
                            gain.iter().map(|row| row.iter().map(|x| x.abs() * 3.0).collect()).collect();
                        _ = writeln!(text, "gain = {}", rows(&gain));
                    }
                    _ => {}
                }
                if kind == "mean-value" && random.once_in(8) {
                    text.push_str("as_printed = \"integral\"\n");
                }
            }
            "high-gain" => _ = writeln!(text, "r = {}", number(short(random, 0.02, 0.5))),
            "luenberger" => {
                let poles: Vec<f64> = (0..n).map(|k| -1.0 - 0.7 * k as f64).collect();
                _ = writeln!(text, "poles = {}", list(&poles));
            }
            _ => {
                let (w, v) = (vec![0.1; n], vec![0.01; p]);
                _ = writeln!(text, "w = {}\nv = {}\nperiod = 0.05", list(&w), list(&v));
                if kind == "mhe" {
                    text.push_str("window = 3\n");
                } else if kind == "error-state-kalman" {
                    let last = if n > 2 && random.once_in(2) { ", \"x3\"" } else { "" };
                    let mut initial = vec![0.0; n];
                    initial[1] = 1.0;
                    _ = writeln!(text, "unit_vectors = [[\"x1\", \"x2\"{last}]]\ninitial = {}", list(&initial));
                } else if kind == "imm" {
                    text.push_str("models = [{}, { w = 1 }]\ntransitions = [[0.9, 0.1], [0.2, 0.8]]\n");
                } else if random.once_in(4) {
                    text.push_str("gate = 5\n");
                }
            }
        }
        text
    }
}

fn expression_study(random: &mut Random, kind: &str) -> String {
    let mut plant = Rows::random(random);
    // A unit vector has two entries.
    while kind == "error-state-kalman" && plant.f.len() < 2 {
        plant = Rows::random(random);
    }
    let n = plant.f.len();
    let mut text = plant.text();
    if plant.inputs > 0 {
        // 0 at first.
        let input = ["0.5*sin(t)", "step(t - 1)", "0", "0.3"][random.below(4)];
        _ = writeln!(text, "[input]\nexpressions = [\"{input}\"]");
    }
    let is_discrete = kind == "lpv" && random.once_in(5);
    if is_discrete {
        // One step of Euler's method of the plant, which is a plant as good as any.
        let f: Vec<String> = plant.f.iter().enumerate().map(|(i, row)| format!("x{} + 0.1*({row})", i + 1)).collect();
        text = text.replacen(&texts(&plant.f), &texts(&f), 1).replacen("[plant]\n", "[plant]\ndt = 0.1\n", 1);
    }
    let mut operating = false;
    if !is_discrete && random.once_in(6) {
        let x = vec![0.0; n];
        _ = writeln!(text, "[operating_point]\nx = {}", list(&x));
        if plant.inputs > 0 {
            text.push_str("u = [0]\n");
        }
        operating = true;
    }
    if random.once_in(4) {
        let x0: Vec<f64> = (0..n).map(|_| short(random, -0.3, 0.3)).collect();
        _ = writeln!(text, "[simulation]\nx0 = {}\nduration = 5\nsamples = 51", list(&x0));
        if is_discrete {
            text.push_str("hold = 0.1\n");
        }
    }
    _ = write!(text, "[[observer]]\nname = \"a\"\n{}", plant.observer(random, kind));
    if operating {
        _ = write!(text, "[[observer]]\nname = \"at\"\n{}", plant.observer(random, "luenberger"));
    }
    if !is_discrete && random.once_in(2) {
        let other = ["lpv", "lipschitz", "mean-value", "high-gain"][random.below(4)];
        _ = write!(text, "[[observer]]\nname = \"b\"\n{}", plant.observer(random, other));
    }
    text
}

/// Chains of integrators and what resembles them.
fn sliding_mode(random: &mut Random) -> String {
    let n = 1 + random.below(3);
    let mut f: Vec<String> = (1..n).map(|i| format!("x{}", i + 1)).collect();
    f.push(format!("-x{n} - {}*sin(x1)", number(short(random, 0.1, 1.0))));
    let mut inputs = 0;
    if random.once_in(2) {
        inputs = 1;
        f[n - 1].push_str(" + u1");
    }
    let mut h = "x1".to_owned();
    // A disguised row: as a chain at t = 0, u = 0 and small states.
    match random.below(9) {
        0 if n > 1 => "x2*cos(t)".clone_into(&mut f[0]),
        1 if n > 1 => "sat(x2, -3, 3)".clone_into(&mut f[0]),
        2 if n > 1 => {
            inputs = 1;
            "x2 + x1*u1".clone_into(&mut f[0]);
        }
        3 if n > 1 => "if(t > 2, 0, x2)".clone_into(&mut f[0]),
        4 => "sat(x1, -2, 2)".clone_into(&mut h),
        5 => "x1 + sin(t)".clone_into(&mut h),
        6 if n > 1 => "x2 + max(x1 - 3, 0)".clone_into(&mut f[0]),
        _ => {}
    }
    let mut text = format!("[plant]\nf = {}\nh = [\"{h}\"]\n", texts(&f));
    if inputs > 0 {
        text.push_str("inputs = [\"u1\"]\n[input]\nexpressions = [\"0.5*sin(t)\"]\n");
    }
    let bound = number(f64::from(random.integer(3, 20)));
    _ = writeln!(text, "[[observer]]\nname = \"a\"\nkind = \"sliding-mode\"\nbound = {bound}\nperiod = 0.01");
    if random.once_in(6) {
        text.push_str("discretisation = \"explicit\"\n");
    }
    if n == 2 && random.once_in(3) {
        _ = writeln!(text, "k = [{}, {}]", number(short(random, 1.0, 9.0)), number(short(random, 2.0, 30.0)));
    }
    text
}

/// A plant `x1' = x2 + a(x1), x2' = b(x1) - c x2`, for which z = x2 - k x1 has linear dynamics up to functions of y:
/// maps of KKL and of immersion and invariance. Some are changed.
fn maps(random: &mut Random) -> String {
    let k = f64::from(random.integer(1, 3));
    let damping = f64::from(random.integer(0, 1));
    let (stiffness, cubic) = (f64::from(random.integer(1, 3)), if random.once_in(2) { 0.25 } else { 0.0 });
    let a = if cubic > 0.0 { format!(" - {}*x1^3", number(cubic)) } else { String::new() };
    let input = if random.once_in(3) { " + u1" } else { "" };
    let jump = match random.below(8) {
        0 => " + if(x2 > 0.3, 0.5, 0)",
        1 => " + 0.5*step(x2 - 0.3)",
        2 => " + 0.5*sin(3*t)",
        _ => "",
    };
    let h = match random.below(8) {
        0 => "x1 + 0.5*sin(t)",
        1 => "2*x1",
        _ => "x1",
    };
    let f = [format!("x2{a}"), format!("-{}*x1 - {}*x2{input}{jump}", number(stiffness), number(damping))];
    let mut text = format!("[plant]\nf = {}\nh = [\"{h}\"]\n", texts(&f));
    if !input.is_empty() {
        text.push_str("inputs = [\"u1\"]\n[input]\nexpressions = [\"0.29\"]\n");
    }
    let inputs = if input.is_empty() { "" } else { ", inputs = [[-1, 1]]" };
    let region = format!("region = {{ states = [[-3, 3], [-4, 4]]{inputs} }}");
    let x1 = if h == "2*x1" { "(y1/2)" } else { "y1" };
    // xi = x2 - k x1: xi' = -s x1 - d x2 + u - k x2 + k a x1^3 = -(d + k)(xi + k x1) - s x1 + u + k a x1^3.
    let rate = damping + k;
    let spike = if random.once_in(5) { format!(" + if(abs({x1} - 1.2345) < 0.002, 3, 0)") } else { String::new() };
    let slip = if random.once_in(5) { " + 0.00000001*sin(5*x2)" } else { "" };
    let start = if random.once_in(4) { "start = [\"x2 + 20\"]\n" } else { "" };
    let saturated = random.once_in(4);
    if random.once_in(2) {
        let b = format!("-{}*{x1}{input} + {}*{x1}^3", number(stiffness + rate * k), number(k * cubic));
        _ = writeln!(
            text,
            "[[observer]]\nname = \"a\"\nkind = \"kkl\"\nphi = [\"x2 - {k}*x1{slip}\"]\nlambda = [-{rate}]\nb = [\"{b}\"]\nleft_inverse = [\"{x1}\", \"xi1 + {k}*{x1}{spike}\"]\n{region}"
        );
    } else {
        let inverse = if saturated { "sat(z1, -1, 1)".to_owned() } else { format!("z1{spike}") };
        let region = if saturated { region.replace("[-4, 4]", "[-1, 1]") } else { region };
        _ = writeln!(
            text,
            "[[observer]]\nname = \"a\"\nkind = \"immersion-invariance\"\nbeta = [\"chi1 + {k}*{x1}\"]\nphi = [\"x2\"]\nleft_inverse = [\"{x1}\", \"{inverse}\"]\n{region}\n{start}"
        );
    }
    text
}

/// A state that is the integral of known signals up to a constant.
fn parameters(random: &mut Random) -> String {
    let c = number(short(random, 0.2, 2.0));
    let is_kkl = random.once_in(2);
    let region = "region = { states = [[-3, 3], [-3, 3]], inputs = [[-1, 1]] }";
    let mut text = format!("[plant]\nf = [\"-x1 + x2\", \"-{c}*x1 + u1\"]\nh = [\"x1\"]\ninputs = [\"u1\"]\n");
    text.push_str(
        "[input]\nexpressions = [\"0.3*sin(t)\"]\n[simulation]\nx0 = [0.5, 0.2]\nduration = 10\nsamples = 101\n",
    );
    let lambda = if is_kkl { "lambda = [0]\n" } else { "" };
    let kind = if is_kkl { "kkl-peb" } else { "pebo" };
    let gradient = random.once_in(2);
    let estimator =
        if gradient { "{ kind = \"gradient\", gain = 5 }" } else { "{ kind = \"drem\", gain = 5, forgetting = 1 }" };
    _ = writeln!(
        text,
        "[[observer]]\nname = \"a\"\nkind = \"{kind}\"\nphi = [\"x2\"]\n{lambda}b = [\"-{c}*y1 + u1\"]\nleft_inverse = [\"y1\", \"xi1\"]\ns = [\"y1\"]\ng = [\"-y1 + xi1\"]\nm = [\"1\"]\nalpha = 1\nestimator = {estimator}\n{region}"
    );
    if random.once_in(4) {
        text.push_str("leakage = 0.1\n");
    }
    text
}

/// A plant for a small table.
fn numerical(random: &mut Random) -> String {
    let drive = if random.once_in(2) { " + 0.5*sin(3*t)" } else { "" };
    let output = if random.once_in(4) { "x1 + 0.3*sin(t)" } else { "x1" };
    let c = number(short(random, 0.5, 1.5));
    format!(
        "[plant]\nf = [\"x2\", \"-{c}*x1{drive}\"]\nh = [\"{output}\"]\n[[observer]]\nname = \"a\"\nkind = \"kkl-numerical\"\ndomain = [[-2, 2], [-2, 2]]\ncutoff = 2\npoints = 17\nleaves = 4\nsamples = 500\n"
    )
}
