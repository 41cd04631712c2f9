//! The flow of the cubic part.

use std::fmt::Write;

use super::{product, scalar};
use crate::program::Scalar;
use crate::{Export, number};

/// The exact flow of the cubic part over one period: the innovation after it, and the impulse on the estimate.
pub(super) fn flow(text: &mut String, export: &Export) {
    let (number, upper) = (scalar(export), export.identifier.to_uppercase());
    let p = format!("{upper}_OUTPUTS");
    let (suffix, root, magnitude, epsilon, largest) = match export.scalar {
        Scalar::Binary32 => ("f", "sqrtf", "fabsf", f64::from(f32::EPSILON), f64::from(f32::MAX.sqrt())),
        Scalar::Binary64 => ("", "sqrt", "fabs", f64::EPSILON, f64::MAX.sqrt()),
    };
    let literal = |x: f64| number::c(x, export.scalar);
    let value = |wanted: &str| export.scalars().iter().find(|(name, _)| *name == wanted).map_or(0.0, |(_, x)| *x);
    let (w, period) = (literal(value("W")), literal(value("PERIOD")));
    let (large, bound) = (literal(1.0 / epsilon), literal(largest));
    _ = write!(
        text,
        "
/* The cubic part for one period in closed form: y~ becomes y~/sqrt(1 + 2 w h y~'theta y~). Squares are not formed, so
 * that nothing overflows. */
static void flow({number} *innovation, {number} *impulse)
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
