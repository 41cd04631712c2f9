//! The interpolated left inverse of a numerical KKL observer: T by splines, and the search of the state. With held
//! inputs there is a table for each combination of their nodes; `share` has the weights of the tables at an input.

use std::fmt::Write;

use luenberger_observers::numerical_kkl::Search;
use luenberger_observers::numerical_kkl::least_squares::RESTARTS;

use super::{is_finite, magnitude, root, scalar};
use crate::kkl::TableOf;
use crate::scalar::Scalar;
use crate::{Export, number};

/// The table, its evaluation and the search, as functions. `between` is there already.
pub(super) fn functions(text: &mut String, export: &Export, table: &TableOf) {
    let number = scalar(export);
    let order = if table.ranks.is_empty() { "the last axis fastest" } else { "axis by axis, a matrix for each" };
    _ = writeln!(text, "\n/* Coefficients of the splines, {order}. */");
    _ = writeln!(text, "static const {number} TABLE[{}] = {{", table.coefficients.len());
    for line in table.coefficients.chunks(6) {
        let line: Vec<String> = line.iter().map(|x| number::c(export.scalar.round(*x), export.scalar)).collect();
        _ = writeln!(text, "    {},", line.join(", "));
    }
    text.push_str("};\n");
    let list = |of: &dyn Fn(usize) -> usize| {
        table.points.iter().map(|count| of(*count).to_string()).collect::<Vec<_>>().join(", ")
    };
    let n = table.points.len();
    _ = writeln!(text, "static const int CELLS[{n}] = {{ {} }};", list(&|count| count - 1));
    if table.ranks.is_empty() {
        _ = writeln!(text, "static const int STRIDE[{n}] = {{ {} }};", list(&|count| count + 2));
    } else {
        let ranks: Vec<String> = table.ranks.iter().chain([&1]).map(usize::to_string).collect();
        _ = writeln!(text, "/* Rows of the matrices of each axis, and the columns of the last. */");
        _ = writeln!(text, "static const int RANK[{}] = {{ {} }};", n + 1, ranks.join(", "));
        let ends = (0..n).scan(0, |end, axis| {
            *end += (table.points[axis] + 2) * table.ranks[axis] * table.columns(axis);
            Some(end.to_string())
        });
        let starts: Vec<String> = [String::from("0")].into_iter().chain(ends).take(n).collect();
        _ = writeln!(text, "static const int CORE[{n}] = {{ {} }};", starts.join(", "));
    }
    if let Some(Search { fallback: count @ 1.., .. }) = table.search {
        let share = |k: usize| export.scalar.round((k as f64 + 0.5) / count as f64);
        let shares: Vec<String> = (0..count).map(|k| number::c(share(k), export.scalar)).collect();
        _ = writeln!(text, "static const {number} SHARE[{count}] = {{ {} }};", shares.join(", "));
    }
    if !table.nodes.is_empty() {
        shares_of_input(text, export, table);
    }
    evaluation(text, export, table);
    if let Some(search) = &table.search {
        nearest(text, export, (table, search));
        if search.fallback > 0 {
            restart(text, export, (table, search));
        }
    }
}

/// The variable with the weights of the tables, where there are several.
pub(super) fn shares(export: &Export, table: &TableOf) -> String {
    if table.nodes.is_empty() { String::new() } else { format!("    {} shares[{}];\n", scalar(export), table.tables()) }
}

/// Their weights as a parameter of a function, and as an argument of a call.
fn passed(export: &Export, table: &TableOf) -> (String, &'static str) {
    if table.nodes.is_empty() {
        (String::new(), "")
    } else {
        (format!("const {} *shares, ", scalar(export)), "shares, ")
    }
}

/// Lagrange's polynomials at an input.
fn shares_of_input(text: &mut String, export: &Export, table: &TableOf) {
    let (number, m, count) = (scalar(export), table.nodes.len(), table.nodes[0].len());
    let one = number::c(1.0, export.scalar);
    _ = writeln!(text, "\n/* The values of each input with a table. */");
    _ = writeln!(text, "static const {number} NODES[{m}][{count}] = {{");
    for nodes in &table.nodes {
        let row: Vec<String> = nodes.iter().map(|x| number::c(export.scalar.round(*x), export.scalar)).collect();
        _ = writeln!(text, "    {{ {} }},", row.join(", "));
    }
    text.push_str("};\n");
    _ = write!(
        text,
        "
/* The weights of the tables at an input of the family: products of Lagrange's polynomials. */
static void share(const {number} *u, {number} *shares)
{{
    int of;
    int i;
    int j;

    for (of = 0; of < {tables}; ++of) {{
        int rest = of;
        shares[of] = {one};
        for (i = {last}; i >= 0; --i) {{
            const int own = rest % {count};
            rest = rest / {count};
            for (j = 0; j < {count}; ++j) {{
                if (j != own) {{
                    shares[of] = shares[of] * ((u[i] - NODES[i][j]) / (NODES[i][own] - NODES[i][j]));
                }}
            }}
        }}
    }}
}}
",
        tables = table.tables(),
        last = m - 1,
    );
}

/// The call of the search, for the target state `w` in its coordinates, the guess in `xhat` and the held inputs `u`.
pub(super) fn call(table: &TableOf, u: &str) -> String {
    let (weighed, shares) =
        if table.nodes.is_empty() { (String::new(), "") } else { (format!("    share({u}, shares);\n"), "shares, ") };
    match table.search {
        None => String::new(),
        Some(Search { fallback: 0, .. }) => format!("{weighed}    (void)nearest({shares}w, xhat);\n"),
        Some(_) => format!("{weighed}    search({shares}w, xhat);\n"),
    }
}

/// The value `w` at the state `x` and the held inputs `u`.
pub(super) fn start(table: &TableOf) -> String {
    if table.nodes.is_empty() {
        "    table(x, w, jacobian);\n".to_owned()
    } else {
        "    share(u, shares);\n    table(shares, x, w, jacobian);\n".to_owned()
    }
}

fn evaluation(text: &mut String, export: &Export, table: &TableOf) {
    let (number, n, z) = (scalar(export), table.points.len(), table.outputs);
    let literal = |x: f64| number::c(export.scalar.round(x), export.scalar);
    let (parameter, _) = passed(export, table);
    let sum = if table.ranks.is_empty() {
        sum_of_table(table, number, &literal(1.0))
    } else {
        product_of_train(table, number, &literal(0.0), &literal(1.0))
    };
    let sum = if table.nodes.is_empty() { sum } else { sum_of_tables(table, number, &literal(0.0), &sum) };
    let several = if table.nodes.is_empty() { "" } else { "    int of;\n" };
    let (corner, cleared) = if table.ranks.is_empty() {
        let zero = literal(0.0);
        let cleared = format!(
            "    for (i = 0; i < {z}; ++i) {{
        value[i] = {zero};
        for (j = 0; j < {n}; ++j) {{
            jacobian[(i * {n}) + j] = {zero};
        }}
    }}
"
        );
        ("    int corner;\n", cleared)
    } else {
        ("", String::new())
    };
    _ = write!(
        text,
        "
/* T in its coordinates at the point of the box nearest to x, and its Jacobian, row by row: cubic B-splines. */
static void table({parameter}const {number} *x, {number} *value, {number} *jacobian)
{{
    {number} weights[{n}][4];
    {number} slopes[{n}][4];
    int first[{n}];
{several}{corner}    int i;
    int j;

    for (i = 0; i < {n}; ++i) {{
        const {number} scale = ({number})CELLS[i] / (UPPER[i][0] - LOWER[i][0]);
        const {number} position = (between(x[i], LOWER[i][0], UPPER[i][0]) - LOWER[i][0]) * scale;
        {number} s;
        {number} r;
        first[i] = (int)position;
        if (first[i] > (CELLS[i] - 1)) {{
            first[i] = CELLS[i] - 1;
        }}
        s = position - ({number})first[i];
        r = {one} - s;
        weights[i][0] = ((r * r) * r) * {sixth};
        weights[i][1] = {thirds} - ((s * s) * ({one} - ({half} * s)));
        weights[i][2] = {thirds} - ((r * r) * ({one} - ({half} * r)));
        weights[i][3] = ((s * s) * s) * {sixth};
        slopes[i][0] = ((-{half} * r) * r) * scale;
        slopes[i][1] = (s * (({more} * s) - {two})) * scale;
        slopes[i][2] = (-r * (({more} * r) - {two})) * scale;
        slopes[i][3] = (({half} * s) * s) * scale;
    }}
{cleared}{sum}}}
",
        one = literal(1.0),
        two = literal(2.0),
        half = literal(0.5),
        more = literal(1.5),
        sixth = literal(1.0 / 6.0),
        thirds = literal(2.0 / 3.0),
    );
}

/// The sum over the coefficients near a point, of one table: `value` and `jacobian` grow. Along the last axis first,
/// where the coefficients stand one after the other.
fn sum_of_table(table: &TableOf, number: &str, one: &str) -> String {
    let (n, z) = (table.points.len(), table.outputs);
    let last = n - 1;
    let corners = 4_usize.pow(last as u32);
    // The weight of a line: the product over the axes before.
    let product = |slope_of: &str| {
        let factor = |i: usize| match slope_of {
            "" => format!("weights[{i}][k[{i}]]"),
            axis => format!("(({axis} == {i}) ? slopes[{i}][k[{i}]] : weights[{i}][k[{i}]])"),
        };
        (0..last).map(factor).reduce(|product, factor| format!("({product}) * {factor}")).unwrap_or(one.to_owned())
    };
    let along = |of: &str| {
        let term = |k: usize| {
            format!("({of}[{last}][{k}] * row[{}])", if k == 0 { "i".to_owned() } else { format!("{} + i", k * z) })
        };
        format!("(({} + {}) + {}) + {}", term(0), term(1), term(2), term(3))
    };
    let digits = match last.checked_sub(1) {
        None => String::new(),
        Some(before) => format!(
            "        int rest = corner;
        for (i = {before}; i >= 0; --i) {{
            k[i] = rest % 4;
            rest = rest / 4;
        }}
"
        ),
    };
    let others = if last == 0 {
        String::new()
    } else {
        format!(
            "        for (j = 0; j < {last}; ++j) {{
            weight = {};
            for (i = 0; i < {z}; ++i) {{
                jacobian[(i * {n}) + j] = jacobian[(i * {n}) + j] + (weight * line[i]);
            }}
        }}
",
            product("j")
        )
    };
    format!(
        "    for (corner = 0; corner < {corners}; ++corner) {{
        const {number} *row;
        {number} line[{z}];
        {number} rise[{z}];
        {number} weight;
        int k[{n}];
        int index = 0;
{digits}        k[{last}] = 0;
        for (i = 0; i < {n}; ++i) {{
            index = (index * STRIDE[i]) + first[i] + k[i];
        }}
        row = &TABLE[index * {z}];
        for (i = 0; i < {z}; ++i) {{
            line[i] = {value};
            rise[i] = {slope};
        }}
        weight = {plain};
        for (i = 0; i < {z}; ++i) {{
            value[i] = value[i] + (weight * line[i]);
            jacobian[(i * {n}) + {last}] = jacobian[(i * {n}) + {last}] + (weight * rise[i]);
        }}
{others}    }}
",
        value = along("weights"),
        slope = along("slopes"),
        plain = product(""),
    )
}

/// The product of the matrices of a table of low rank, from the last axis to the first, with its derivatives by the
/// axes that it has passed.
fn product_of_train(table: &TableOf, number: &str, zero: &str, one: &str) -> String {
    let (n, z) = (table.points.len(), table.outputs);
    let most = table.ranks.iter().copied().max().unwrap_or(1);
    format!(
        "    {{
        {number} product[{most}];
        {number} next[{most}];
        {number} gradient[{n}][{most}];
        {number} turned[{n}][{most}];
        int axis;
        int passed;
        product[0] = {one};
        for (axis = {last}; axis >= 0; --axis) {{
            const int size = RANK[axis] * RANK[axis + 1];
            const {number} *near = &TABLE[CORE[axis] + (first[axis] * size)];
            const {number} *w = weights[axis];
            const {number} *v = slopes[axis];
            for (i = 0; i < RANK[axis]; ++i) {{
                next[i] = {zero};
                for (passed = axis; passed < {n}; ++passed) {{
                    turned[passed][i] = {zero};
                }}
                for (j = 0; j < RANK[axis + 1]; ++j) {{
                    const {number} *c = &near[(i * RANK[axis + 1]) + j];
                    const {number} entry = (((w[0] * c[0]) + (w[1] * c[size])) + (w[2] * c[2 * size])) + (w[3] * c[3 * size]);
                    const {number} rate = (((v[0] * c[0]) + (v[1] * c[size])) + (v[2] * c[2 * size])) + (v[3] * c[3 * size]);
                    next[i] = next[i] + (entry * product[j]);
                    turned[axis][i] = turned[axis][i] + (rate * product[j]);
                    for (passed = axis + 1; passed < {n}; ++passed) {{
                        turned[passed][i] = turned[passed][i] + (entry * gradient[passed][j]);
                    }}
                }}
            }}
            for (i = 0; i < RANK[axis]; ++i) {{
                product[i] = next[i];
                for (passed = axis; passed < {n}; ++passed) {{
                    gradient[passed][i] = turned[passed][i];
                }}
            }}
        }}
        for (i = 0; i < {z}; ++i) {{
            value[i] = product[i];
            for (j = 0; j < {n}; ++j) {{
                jacobian[(i * {n}) + j] = gradient[j][i];
            }}
        }}
    }}
",
        last = n - 1,
    )
}

/// The sum over the tables, weighed; at a node all weights but one are zero.
fn sum_of_tables(table: &TableOf, number: &str, zero: &str, one: &str) -> String {
    let (n, z) = (table.points.len(), table.outputs);
    let size: usize = table.points.iter().map(|count| count + 2).product::<usize>() * z;
    let own = one.replace("TABLE[", "part[").replace("value[", "own[").replace("jacobian[", "slope[");
    let own: String = own.lines().flat_map(|line| ["        ", line, "\n"]).collect();
    format!(
        "    for (of = 0; of < {tables}; ++of) {{
        if (shares[of] != {zero}) {{
            const {number} *part = &TABLE[of * {size}];
            {number} own[{z}];
            {number} slope[{all}];
            for (i = 0; i < {z}; ++i) {{
                own[i] = {zero};
                for (j = 0; j < {n}; ++j) {{
                    slope[(i * {n}) + j] = {zero};
                }}
            }}
{own}            for (i = 0; i < {z}; ++i) {{
                value[i] = value[i] + (own[i] * shares[of]);
            }}
            for (i = 0; i < {all}; ++i) {{
                jacobian[i] = jacobian[i] + (slope[i] * shares[of]);
            }}
        }}
    }}
",
        tables = table.tables(),
        all = n * z,
    )
}

/// The projected Levenberg-Marquardt iteration.
fn nearest(text: &mut String, export: &Export, (table, search): (&TableOf, &Search<f64>)) {
    let (parameter, argument) = passed(export, table);
    let (number, n, z) = (scalar(export), table.points.len(), table.outputs);
    let literal = |x: f64| number::c(export.scalar.round(x), export.scalar);
    let (root, magnitude) = (root(export), magnitude(export));
    let epsilon = match export.scalar {
        Scalar::Binary32 => f64::from(f32::EPSILON),
        Scalar::Binary64 => f64::EPSILON,
    };
    _ = write!(
        text,
        "
/* The point of the box nearest to x; 0 in place of what is not finite. */
static void inside({number} *x)
{{
    int i;
    for (i = 0; i < {n}; ++i) {{
        x[i] = between(({finite}) ? x[i] : {zero}, LOWER[i][0], UPPER[i][0]);
    }}
}}

/* The residual w - T(x) and the square of its length; the Jacobian of T is left in the last argument. */
static {number} residual_at({parameter}const {number} *w, const {number} *x, {number} *residual, {number} *jacobian)
{{
    {number} sum;
    int i;

    table({argument}x, residual, jacobian);
    for (i = 0; i < {z}; ++i) {{
        residual[i] = w[i] - residual[i];
    }}
    sum = residual[0] * residual[0];
    for (i = 1; i < {z}; ++i) {{
        sum = sum + (residual[i] * residual[i]);
    }}
    return sum;
}}

/* The step of (J'J + damping I) step = J'r, by Cholesky's factorisation; 0 where a pivot is not positive. */
static void solve({number} g[{n}][{n}], {number} *right)
{{
    int definite = 1;
    int i;
    int j;
    int k;

    for (j = 0; j < {n}; ++j) {{
        for (i = j; i < {n}; ++i) {{
            {number} entry = g[i][j];
            for (k = 0; k < j; ++k) {{
                entry = entry - (g[i][k] * g[j][k]);
            }}
            if (i > j) {{
                g[i][j] = entry / g[j][j];
            }} else if ((definite != 0) && (entry > {zero})) {{
                g[j][j] = {root}(entry);
            }} else {{
                g[j][j] = {one};
                definite = 0;
            }}
        }}
    }}
    for (i = 0; i < {n}; ++i) {{
        for (k = 0; k < i; ++k) {{
            right[i] = right[i] - (g[i][k] * right[k]);
        }}
        right[i] = right[i] / g[i][i];
    }}
    for (i = {last}; i >= 0; --i) {{
        for (k = i + 1; k < {n}; ++k) {{
            right[i] = right[i] - (g[k][i] * right[k]);
        }}
        right[i] = right[i] / g[i][i];
    }}
    for (i = 0; (i < {n}) && (definite == 0); ++i) {{
        right[i] = {zero};
    }}
}}

/* Moves x to a point of the box whose image is nearest to w, and returns the distance. */
static {number} nearest({parameter}const {number} *w, {number} *x)
{{
    {number} residual[{z}];
    {number} jacobian[{all}];
    {number} damping = {zero};
    {number} cost;
    int done = 0;
    int evaluations;
    int i;
    int j;
    int k;

    inside(x);
    cost = residual_at({argument}w, x, residual, jacobian);
    for (evaluations = 1; (evaluations < {most}) && (done == 0); ++evaluations) {{
        {number} trial[{z}];
        {number} slope[{all}];
        {number} gram[{n}][{n}];
        {number} step[{n}];
        {number} next[{n}];
        {number} trace;
        {number} moved = {zero};
        {number} trial_cost;
        for (i = 0; i < {n}; ++i) {{
            step[i] = jacobian[i] * residual[0];
            for (k = 1; k < {z}; ++k) {{
                step[i] = step[i] + (jacobian[(k * {n}) + i] * residual[k]);
            }}
            for (j = 0; j < {n}; ++j) {{
                gram[i][j] = jacobian[i] * jacobian[j];
                for (k = 1; k < {z}; ++k) {{
                    gram[i][j] = gram[i][j] + (jacobian[(k * {n}) + i] * jacobian[(k * {n}) + j]);
                }}
            }}
        }}
        trace = gram[0][0];
        for (i = 1; i < {n}; ++i) {{
            trace = trace + gram[i][i];
        }}
        for (i = 0; i < {n}; ++i) {{
            /* At a face of the box, with the descent pointing out of it, a coordinate stands still. */
            if (((x[i] <= LOWER[i][0]) && (step[i] < {zero})) || ((x[i] >= UPPER[i][0]) && (step[i] > {zero}))) {{
                for (j = 0; j < {n}; ++j) {{
                    gram[i][j] = {zero};
                    gram[j][i] = {zero};
                }}
                gram[i][i] = {one};
                step[i] = {zero};
            }} else {{
                gram[i][i] = gram[i][i] + (damping + (trace * {epsilon}));
            }}
        }}
        solve(gram, step);
        for (i = 0; i < {n}; ++i) {{
            next[i] = x[i] + step[i];
        }}
        inside(next);
        for (i = 0; i < {n}; ++i) {{
            const {number} part = {magnitude}((next[i] - x[i]) / (UPPER[i][0] - LOWER[i][0]));
            moved = (moved > part) ? moved : part;
        }}
        if (moved <= {resolution}) {{
            done = 1;
        }} else {{
            trial_cost = residual_at({argument}w, next, trial, slope);
            if (trial_cost < cost) {{
                if ((cost - trial_cost) <= ({resolution} * cost)) {{
                    done = 1;
                }}
                for (i = 0; i < {n}; ++i) {{
                    x[i] = next[i];
                }}
                for (i = 0; i < {z}; ++i) {{
                    residual[i] = trial[i];
                }}
                for (i = 0; i < {all}; ++i) {{
                    jacobian[i] = slope[i];
                }}
                cost = trial_cost;
                damping = damping * {tenth};
                if (damping < (trace * {small})) {{
                    damping = {zero};
                }}
            }} else {{
                const {number} more = damping * {eight};
                const {number} least = trace * {start};
                damping = (more > least) ? more : least;
            }}
        }}
    }}
    return {root}(cost);
}}
",
        all = n * z,
        most = search.max_evaluations,
        last = n - 1,
        zero = literal(0.0),
        one = literal(1.0),
        tenth = literal(0.1),
        eight = literal(8.0),
        small = literal(1e-6),
        start = literal(1e-4),
        epsilon = literal(epsilon),
        resolution = literal(4.0 * epsilon),
        finite = is_finite(export, "x[i]"),
    );
}

/// The search from other starts where the first one ends with a residual that the table does not explain.
fn restart(text: &mut String, export: &Export, (table, search): (&TableOf, &Search<f64>)) {
    let (parameter, argument) = passed(export, table);
    let (number, n, z, count) = (scalar(export), table.points.len(), table.outputs, search.fallback);
    let literal = |x: f64| number::c(export.scalar.round(x), export.scalar);
    _ = write!(
        text,
        "
/* Moves x to the point of the box whose image is nearest to w: from x, and if the accuracy of the table does not explain
 * the distance, from the best points of a coarse grid. */
static void search({parameter}const {number} *w, {number} *x)
{{
    {number} distance = nearest({argument}w, x);
    if (distance > {tolerance}) {{
        {number} costs[{RESTARTS}];
        {number} seeds[{RESTARTS}][{n}];
        int filled = 0;
        int cell;
        int i;
        int place;
        for (cell = 0; cell < {cells}; ++cell) {{
            {number} residual[{z}];
            {number} jacobian[{all}];
            {number} seed[{n}];
            {number} cost;
            int rest = cell;
            int waiting = 1;
            for (i = 0; i < {n}; ++i) {{
                seed[i] = LOWER[i][0] + ((UPPER[i][0] - LOWER[i][0]) * SHARE[rest % {count}]);
                rest = rest / {count};
            }}
            cost = residual_at({argument}w, seed, residual, jacobian);
            for (place = 0; (place < {RESTARTS}) && (waiting != 0); ++place) {{
                if (place == filled) {{
                    ++filled;
                    waiting = 0;
                    costs[place] = cost;
                    for (i = 0; i < {n}; ++i) {{
                        seeds[place][i] = seed[i];
                    }}
                }} else if (cost < costs[place]) {{
                    const {number} other = costs[place];
                    costs[place] = cost;
                    cost = other;
                    for (i = 0; i < {n}; ++i) {{
                        const {number} entry = seeds[place][i];
                        seeds[place][i] = seed[i];
                        seed[i] = entry;
                    }}
                }} else {{
                    /* The next place. */
                }}
            }}
        }}
        for (place = 0; place < filled; ++place) {{
            if (distance <= {tolerance}) {{
                break;
            }}
            const {number} found = nearest({argument}w, seeds[place]);
            if (found < distance) {{
                distance = found;
                for (i = 0; i < {n}; ++i) {{
                    x[i] = seeds[place][i];
                }}
            }}
        }}
    }}
}}
",
        all = n * z,
        cells = count.pow(n as u32),
        tolerance = literal(search.tolerance),
    );
}
