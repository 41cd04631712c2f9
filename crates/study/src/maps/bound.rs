//! The guaranteed bound of the estimation error of a KKL observer with given maps: plant and maps as expressions of a
//! certificate.

use luenberger_design::Region;
use luenberger_design::kkl::error_bound;
use luenberger_expression::{Expression, ExpressionPlant, Variable};
use luenberger_proof::Interval;
use luenberger_proof::certificate::{KklBox, KklErrorBound, KklMaps as Exact, KklTexts, Number};

use super::KklMaps;
use crate::model::Model;

/// The theorem with all its data, proved over the region.
///
/// # Errors
/// Why there is none, as a clause.
pub(crate) fn kkl_error_bound(model: &Model, maps: &KklMaps, region: &Region) -> Result<KklErrorBound, String> {
    let plant = model.expressions().map_err(|error| error.to_string())?;
    let texts = texts(&plant, maps, written(plant.f(), |variable| Some(plain(variable)))?)?;
    error_bound(&texts, &bounds(maps, region)?).map_err(|why| why.to_string())
}

/// Bounds of `|x - phi^L(phi(x), h(x))|` over the region, entry by entry, in exact arithmetic.
///
/// # Errors
/// Why there are none, as a clause.
pub(crate) fn left_inverse_defect(model: &Model, maps: &KklMaps, region: &Region) -> Result<Vec<f64>, String> {
    let plant = model.expressions().map_err(|error| error.to_string())?;
    // The right-hand side of the plant is not asked for.
    let texts = texts(&plant, maps, vec!["0".to_owned(); maps.plant.states])?;
    let exact = Exact::new(&texts, maps.plant.inputs).map_err(|error| error.to_string())?;
    exact.defect_over(&bounds(maps, region)?).map_err(|why| why.to_string())
}

fn bounds(maps: &KklMaps, region: &Region) -> Result<KklBox, String> {
    let ranges = |bounds: &[(f64, f64)]| -> Option<Vec<Interval>> {
        bounds.iter().map(|(lo, hi)| Interval::new(*lo, *hi).filter(Interval::is_bounded)).collect()
    };
    let bounded = ranges(region.states()).zip(ranges(region.input_bounds().unwrap_or_default()));
    let (x, u) = bounded.ok_or("the region is not bounded")?;
    if u.len() != maps.plant.inputs {
        return Err("the region has no bounds of the inputs".to_owned());
    }
    Ok(KklBox { x, u })
}

/// Expressions in the notation of certificates.
fn written(of: &[Expression], name: impl Fn(Variable) -> Option<String>) -> Result<Vec<String>, String> {
    let refused = |part: String| format!("a certificate cannot contain `{part}`");
    of.iter().map(|expression| expression.elementary(number, &name).map_err(refused)).collect()
}

/// The names of the variables of f and h.
fn plain(variable: Variable) -> String {
    match variable {
        Variable::State(k) => format!("x{}", k + 1),
        Variable::Input(k) => format!("u{}", k + 1),
    }
}

/// Plant and maps in the notation of certificates, with this f.
fn texts(plant: &ExpressionPlant, maps: &KklMaps, f: Vec<String>) -> Result<KklTexts, String> {
    let inputs = maps.plant.inputs;
    let h = written(plant.h(), |variable| Some(plain(variable)))?;
    // phi is evaluated with x and y = h(x); the others with xi and (u, y).
    let of_state = |variable: Variable| match variable {
        Variable::State(k) => Some(format!("x{}", k + 1)),
        Variable::Input(k) => h.get(k).map(|h| format!("({h})")),
    };
    let known = |k: usize| Some(if k < inputs { format!("u{}", k + 1) } else { format!("y{}", k - inputs + 1) });
    let of_known = |variable: Variable| match variable {
        Variable::State(_) => None,
        Variable::Input(k) => known(k),
    };
    let of_image = |variable: Variable| match variable {
        Variable::State(k) => Some(format!("xi{}", k + 1)),
        Variable::Input(k) => known(k),
    };
    Ok(KklTexts {
        f,
        phi: written(&maps.phi, of_state)?,
        lambda: written(&maps.lambda, of_known)?,
        b: written(&maps.injection, of_known)?,
        left_inverse: written(&maps.left_inverse, of_image)?,
        estimated: (1..=maps.plant.states).map(|k| format!("x{k}")).collect(),
        h,
    })
}

/// A number that is not negative: as a decimal where a short one is exact, else in hexadecimal.
fn number(x: f64) -> String {
    let decimal = x.to_string();
    let exact = format!("{x:.60}");
    let digits = exact.trim_end_matches('0').trim_end_matches('.');
    match Number::from_f64(x) {
        Some(number) if digits != decimal || decimal.len() > 24 => number.to_string(),
        _ => decimal,
    }
}
