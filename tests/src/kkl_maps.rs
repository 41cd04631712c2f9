//! KKL observers in closed form as expressions of certificate files, and one with a truncated series for phi.
//!
//! With y = h(x) each pair of maps solves `Dphi f = Lambda phi + B` exactly, except for the Duffing oscillator.

use luenberger_proof::certificate::{KklBox, KklErrorBound, KklMaps, KklTexts};
use luenberger_proof::{Interval, Matrix};
use nalgebra::DMatrix;

/// A binary64 number in an expression.
fn text(x: f64) -> String {
    let written = luenberger_proof::certificate::Number::from_f64(x.abs()).map_or_else(String::new, |x| x.to_string());
    if x < 0.0 { format!("(-{written})") } else { written }
}

fn copied<S: AsRef<str>>(of: &[S]) -> Vec<String> {
    of.iter().map(|text| text.as_ref().to_owned()).collect()
}

/// The box with these bounds of states and inputs.
///
/// # Panics
/// For bounds that are not in order.
pub fn region(x: &[(f64, f64)], u: &[(f64, f64)]) -> KklBox {
    let range = |(lo, hi): &(f64, f64)| Interval::new(*lo, *hi).expect("bounds in order");
    KklBox { x: x.iter().map(range).collect(), u: u.iter().map(range).collect() }
}

/// Van der Pol's oscillator, y = x1: `phi_i = lambda_i x1 + x2 - m(x1)` with `m(y) = mu (y - y^3/3)`, and
/// `wrong sin(y)` too much in B, which leaves a residual. z = (x2, x1).
pub fn van_der_pol(mu: f64, lambda: [f64; 2], wrong: f64) -> KklTexts {
    let [fast, slow] = lambda.map(text);
    let m = |x: &str| format!("{}*({x} - {x}^3/3)", text(mu));
    let phi = |l: &String| format!("{l}*x1 + x2 - {}", m("x1"));
    let b = |l: &String| format!("-y1 - {l}*({l}*y1 - {})", m("y1"));
    let residual = if wrong == 0.0 { String::new() } else { format!(" + {}*sin(y1)", text(wrong)) };
    KklTexts {
        f: copied(&["x2".to_owned(), format!("{}*(1 - x1^2)*x2 - x1", text(mu))]),
        h: copied(&["x1"]),
        phi: copied(&[phi(&fast), phi(&slow)]),
        lambda: copied(&[fast.as_str(), "0", "0", &slow]),
        b: copied(&[b(&fast) + &residual, b(&slow)]),
        left_inverse: copied(&[format!("xi1 - {fast}*y1 + {}", m("y1")), format!("(xi1 - xi2)/({fast} - {slow})")]),
        estimated: copied(&["x2", "x1"]),
    }
}

/// Proposition 6's plant with the observer in `exp(x3) - c y - y^3`. z = (x2, x3).
pub fn exponential_cascade(c: f64) -> KklTexts {
    let c = text(c);
    let rate = format!("(1/(y1^2 + 1) + y1*u1 - 3*y1^2 - {c})");
    KklTexts {
        f: copied(&["-x1^3 + exp(x3)", "-x2 + x1^2 + sin(x1)", "1/(x1^2 + 1) + x1*u1"]),
        h: copied(&["x1"]),
        phi: copied(&["x2".to_owned(), format!("exp(x3) - {c}*x1 - x1^3")]),
        lambda: copied(&["-1", "0", "0", &rate]),
        b: copied(&["y1^2 + sin(y1)".to_owned(), format!("{rate}*({c}*y1 + y1^3) + ({c} + 3*y1^2)*y1^3")]),
        left_inverse: copied(&["xi1".to_owned(), format!("ln(xi2 + {c}*y1 + y1^3)")]),
        estimated: copied(&["x2", "x3"]),
    }
}

/// The reverse Duffing oscillator, `phi_i = -(h/d_i + x2^3/d_i^2 - 3 x1 x2^2/d_i^3)`: three terms of the series of
/// `phi' = d phi + y`. z = x2^3.
pub fn duffing([one, two]: [f64; 2]) -> KklTexts {
    let term = |d: f64| {
        let d = text(d);
        format!("-(x1/{d} + x2^3/{d}^2 - 3*x1*x2^2/{d}^3)")
    };
    // d^2 phi + d y = -x2^3 + 3 x1 x2^2/d; the weights cancel the last.
    let share = two / (two - one);
    let part = |k: usize, d: f64, weight: f64| format!("({}^2*xi{k} + {}*y1)*{}", text(d), text(d), text(weight));
    KklTexts {
        f: copied(&["x2^3", "-x1"]),
        h: copied(&["x1"]),
        phi: copied(&[term(one), term(two)]),
        lambda: copied(&[text(one), "0".to_owned(), "0".to_owned(), text(two)]),
        b: copied(&["y1", "y1"]),
        left_inverse: copied(&[format!("{} + {}", part(1, one, share - 1.0), part(2, two, -share))]),
        estimated: copied(&["x2^3"]),
    }
}

/// The Cuk converter with the KKLO of Table I, x = (i1, v2, i3, v4), y = (v2, i3): phi = (v4, L1 i1 - C2 v2). z = (i1,
/// v4).
pub fn converter(plant: &luenberger_plants::CukConverter) -> KklTexts {
    let [l1, c2, l3, c4, g, e] = [plant.l1, plant.c2, plant.l3, plant.c4, plant.g, plant.e].map(text);
    KklTexts {
        f: copied(&[
            format!("({e} - (1 - u1)*x2)/{l1}"),
            format!("((1 - u1)*x1 + u1*x3)/{c2}"),
            format!("-(u1*x2 + x4)/{l3}"),
            format!("(x3 - {g}*x4)/{c4}"),
        ]),
        h: copied(&["x2", "x3"]),
        phi: copied(&["x4".to_owned(), format!("{l1}*x1 - {c2}*x2")]),
        lambda: copied(&[format!("-{g}/{c4}"), "0".to_owned(), "0".to_owned(), format!("-(1 - u1)/{l1}")]),
        b: copied(&[format!("y2/{c4}"), format!("-(1 + {c2}/{l1})*(1 - u1)*y1 + {e} - u1*y2")]),
        left_inverse: copied(&[format!("(xi2 + {c2}*y1)/{l1}"), "xi1".to_owned()]),
        estimated: copied(&["x1", "x4"]),
    }
}

/// The theorem of these maps with this P and rate, up to this V; `None` where a bound is not found.
pub fn bound(texts: &KklTexts, region: &KklBox, p: &DMatrix<f64>, rate: f64, start: f64) -> Option<KklErrorBound> {
    let maps = KklMaps::new(texts, region.u.len()).ok()?;
    let lambda = maps.lambda_over(region).ok()?;
    let w = p.clone().try_inverse()? * 1.01;
    let proof = |m: &DMatrix<f64>| Matrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i.min(j), i.max(j))]);
    KklErrorBound::propose(maps, region.clone(), lambda, (proof(p), proof(&w), rate), start).ok()
}
