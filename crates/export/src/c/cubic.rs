//! The flow of the cubic part.

use std::fmt::Write;

use luenberger_observers::SampledCubicObserver;
use luenberger_observers::semi_implicit::reach;
use nalgebra::DMatrix;

use super::{magnitude, product, root, scalar};
use crate::exportable_observer::ExportableObserver;
use crate::scalar::Scalar;
use crate::{Export, number};

/// The flow of the cubic part over one period, exact or in a semi-implicit step: the innovation after it, and the
/// impulse on the estimate.
pub(super) fn flow(text: &mut String, export: &Export) {
    let observer = match &export.observer {
        ExportableObserver::Cubic(observer) => Some(observer),
        ExportableObserver::Varying(step) => Some(step.observer().nominal()),
        _ => None,
    };
    if let Some(coupling) = observer.and_then(SampledCubicObserver::coupling) {
        semi_implicit(text, export, coupling);
    } else {
        closed_form(text, export);
    }
}

/// The parameter of the flow for its time, and that time: the period, unless it varies.
fn time(export: &Export) -> (String, String) {
    if export.observer.takes_time() {
        return (format!(", {} dt", scalar(export)), "dt".to_owned());
    }
    let period = export.scalar.round(export.observer.period());
    (String::new(), number::c(period, export.scalar))
}

/// One semi-implicit step, with the operations of `luenberger_observers::semi_implicit` in their order.
fn semi_implicit(text: &mut String, export: &Export, coupling: &DMatrix<f64>) {
    let (number, upper) = (scalar(export), export.identifier.to_uppercase());
    let p = format!("{upper}_OUTPUTS");
    let (suffix, largest) = match export.scalar {
        Scalar::Binary32 => ("f", f64::from(reach(&coupling.map(|x| x as f32)))),
        Scalar::Binary64 => ("", reach(coupling)),
    };
    let magnitude = magnitude(export);
    let largest = number::c(largest, export.scalar);
    let (time, period) = time(export);
    _ = write!(
        text,
        "
/* The cubic part for one period in a semi-implicit step: (I + s G) r = y~ with s = h y~'theta y~ and G = -C N, by
 * elimination with row exchanges; y~ becomes r, the impulse is s r. s is bounded, so that nothing overflows. */
static void flow({number} *innovation, {number} *impulse{time})
{{
    {number} matrix[{p}][{p}];
    {number} weighted[{p}];
    {number} size = 0.0{suffix};
    {number} q;
    {number} s;
    int solved = 1;
    int i;
    int j;
    int k;

    for (i = 0; i < {p}; ++i) {{
        const {number} entry = {magnitude}(innovation[i]);
        size = (entry > size) ? entry : size;
        impulse[i] = innovation[i];
    }}
    if (size > 0.0{suffix}) {{
        for (i = 0; i < {p}; ++i) {{
            impulse[i] = impulse[i] / size;
        }}
    }}
"
    );
    product(text, number, ("THETA", &p, &p), "impulse", "weighted[i] = sum;");
    _ = write!(
        text,
        "    q = impulse[0] * weighted[0];
    for (i = 1; i < {p}; ++i) {{
        q = q + (impulse[i] * weighted[i]);
    }}
    q = (q > 0.0{suffix}) ? q : 0.0{suffix};
    s = q * {period} * size * size;
    s = (s < {largest}) ? s : {largest};
    for (i = 0; i < {p}; ++i) {{
        impulse[i] = innovation[i];
        for (j = 0; j < {p}; ++j) {{
            const {number} entry = s * G[i][j];
            matrix[i][j] = (i == j) ? (1.0{suffix} + entry) : entry;
        }}
    }}
    for (k = 0; (k < {p}) && (solved == 1); ++k) {{
        int best = k;
        for (i = k + 1; i < {p}; ++i) {{
            if ({magnitude}(matrix[i][k]) > {magnitude}(matrix[best][k])) {{
                best = i;
            }}
        }}
        solved = ({magnitude}(matrix[best][k]) > 0.0{suffix}) ? 1 : 0;
        if ((solved == 1) && (best != k)) {{
            const {number} entry = impulse[best];
            impulse[best] = impulse[k];
            impulse[k] = entry;
            for (j = k; j < {p}; ++j) {{
                const {number} other = matrix[best][j];
                matrix[best][j] = matrix[k][j];
                matrix[k][j] = other;
            }}
        }}
        for (i = k + 1; (i < {p}) && (solved == 1); ++i) {{
            const {number} factor = matrix[i][k] / matrix[k][k];
            for (j = k + 1; j < {p}; ++j) {{
                matrix[i][j] = matrix[i][j] - (factor * matrix[k][j]);
            }}
            impulse[i] = impulse[i] - (factor * impulse[k]);
        }}
    }}
    for (i = {p} - 1; (i >= 0) && (solved == 1); --i) {{
        {number} rest = impulse[i];
        for (j = i + 1; j < {p}; ++j) {{
            rest = rest - (matrix[i][j] * impulse[j]);
        }}
        impulse[i] = rest / matrix[i][i];
    }}
    for (i = 0; i < {p}; ++i) {{
        if (solved == 1) {{
            innovation[i] = impulse[i];
            impulse[i] = impulse[i] * s;
        }} else {{
            impulse[i] = 0.0{suffix};
        }}
    }}
}}
"
    );
}

/// The exact flow.
fn closed_form(text: &mut String, export: &Export) {
    let (number, upper) = (scalar(export), export.identifier.to_uppercase());
    let p = format!("{upper}_OUTPUTS");
    let (suffix, epsilon, largest) = match export.scalar {
        Scalar::Binary32 => ("f", f64::from(f32::EPSILON), f64::from(f32::MAX.sqrt())),
        Scalar::Binary64 => ("", f64::EPSILON, f64::MAX.sqrt()),
    };
    let (root, magnitude) = (root(export), magnitude(export));
    let literal = |x: f64| number::c(x, export.scalar);
    let value = |wanted: &str| export.scalars().iter().find(|(name, _)| *name == wanted).map_or(0.0, |(_, x)| *x);
    let w = literal(value("W"));
    let (time, period) = time(export);
    let (large, bound) = (literal(1.0 / epsilon), literal(largest));
    _ = write!(
        text,
        "
/* The cubic part for one period in closed form: y~ becomes y~/sqrt(1 + 2 w h y~'theta y~). Squares are not formed, so
 * that nothing overflows. */
static void flow({number} *innovation, {number} *impulse{time})
{{
    {number} size = 0.0{suffix};
    int i;

    for (i = 0; i < {p}; ++i) {{
        const {number} entry = {magnitude}(innovation[i]);
        size = (entry > size) ? entry : size;
    }}
    if (size <= 0.0{suffix}) {{
        for (i = 0; i < {p}; ++i) {{
            impulse[i] = innovation[i];
        }}
    }} else {{
"
    );
    let mut rest = format!(
        "    {number} direction[{p}];
    {number} weighted[{p}];
    {number} q;
    {number} drive;
    {number} radical;
    {number} reach;
    {number} left;
    {number} right;
    {number} pull;
    int j;

    for (i = 0; i < {p}; ++i) {{
        direction[i] = innovation[i] / size;
    }}
"
    );
    product(&mut rest, number, ("THETA", &p, &p), "direction", "weighted[i] = sum;");
    _ = write!(
        rest,
        "    q = direction[0] * weighted[0];
    for (i = 1; i < {p}; ++i) {{
        q = q + (direction[i] * weighted[i]);
    }}
    q = (q > 0.0{suffix}) ? q : 0.0{suffix};
    drive = 2.0{suffix} * q * {period};
    radical = ({w} > 0.0{suffix}) ? {root}({w} * drive) : 0.0{suffix};
    reach = radical * size;
    if (reach <= {large}) {{
        const {number} hypotenuse = {root}(1.0{suffix} + (reach * reach));
        left = size / hypotenuse;
        right = size / (1.0{suffix} + hypotenuse);
    }} else {{
        left = 1.0{suffix} / radical;
        right = 1.0{suffix} / radical;
    }}
    pull = drive * left * right * size;
    pull = (pull < {bound}) ? pull : {bound};
    for (i = 0; i < {p}; ++i) {{
        innovation[i] = direction[i] * left;
        impulse[i] = direction[i] * pull;
    }}
"
    );
    for line in rest.lines() {
        _ = writeln!(text, "{}{line}", if line.is_empty() { "" } else { "    " });
    }
    text.push_str("    }\n}\n");
}
