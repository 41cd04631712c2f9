//! Interactive figure for the report: the `data` and `layout` objects of plotly's JavaScript.
//!
//! Curves have the points and the resolution that a screen shows; the CSV file of the figure has all. Their numbers are
//! stored as in `packed.rs`, and the script of the page, `pictures.js`, restores them. The colours of text and grid are
//! set by the page, depending on the light or dark mode.

use super::packed::{digits, numbers};
use super::style::{OPACITY, Resolved, hex, resolve};
use super::thinned;
use super::ticks::Axis;
use super::{Area, Figure, FigureError, INSET, Mark, MarkKind, Marker, Panel, Scale};
use serde_json::{Map, Value as Json, json};

/// `{ data, layout }` for `Plotly.newPlot`, with `height` in the layout. The numbers x and y of a curve are
/// `{ of, by, log }`, multiples of the step `of` with the differences `by` of their counts, decimal logarithms if
/// `log`, or an array; instead of an x there may be the index of the first curve that has the same.
/// # Errors
/// [`FigureError`] names the part of the figure that cannot be drawn.
pub fn plotly(figure: &Figure) -> Result<Json, FigureError> {
    figure.check()?;
    let looks = resolve(figure);
    let columns = figure.columns.min(figure.panels.len());
    let rows = figure.panels.len().div_ceil(columns);
    let mut data: Vec<Json> = Vec::new();
    let mut layout = Map::new();
    let (mut shapes, mut annotations) = (Vec::new(), Vec::new());
    let mut named: Vec<&str> = Vec::new();
    let stacked = rows > 1;
    let row_height = figure
        .panels
        .iter()
        .map(|panel| match panel.bars.len() {
            0 if stacked => 230.0,
            0 => 330.0,
            count => 40.0 + 52.0 * count as f64,
        })
        .fold(0.0, f64::max);
    // Between rows: the numbers and the label of the axis above, the title of the panel below.
    let row_gap = 95.0;
    let inner = row_height * rows as f64 + row_gap * (rows - 1) as f64;
    let titled = figure.panels.iter().any(|panel| panel.title.is_some());
    let (above, below) = (if titled { 70.0 } else { 48.0 }, 60.0);
    for (i, panel) in figure.panels.iter().enumerate() {
        let (row, column) = (i / columns, i % columns);
        let n = if i == 0 { String::new() } else { (i + 1).to_string() };
        let x = Axis::horizontal(panel)?;
        let (x_domain, y_domain) = (part(column, columns, 0.11), part(rows - 1 - row, rows, row_gap / inner));
        let mut x_axis = axis(&panel.x_label, x.scale, Some((x.from, x.to)), &x_domain, &format!("y{n}"));
        let first = figure.panels.iter().position(|other| other.x_label == panel.x_label).unwrap_or(i);
        // Zooming one of the stacked panels zooms all panels with the same abscissa.
        if columns == 1 && first < i && Axis::horizontal(&figure.panels[first])? == x {
            x_axis["matches"] = json!(if first == 0 { "x".to_owned() } else { format!("x{}", first + 1) });
        }
        let y_axis = if panel.bars.is_empty() {
            let y = Axis::vertical(panel, &x)?;
            axis(&panel.y_label, y.scale, Some((y.from, y.to)), &y_domain, &format!("x{n}"))
        } else {
            let mut y = axis(&panel.y_label, Scale::Linear, None, &y_domain, &format!("x{n}"));
            y["autorange"] = json!("reversed");
            y["tickvals"] = json!((0..panel.bars.len()).collect::<Vec<_>>());
            y["ticktext"] = json!(panel.bars.iter().map(|bar| wrapped(&bar.name)).collect::<Vec<_>>());
            y
        };
        layout.insert(format!("xaxis{n}"), x_axis);
        layout.insert(format!("yaxis{n}"), y_axis);
        let y = if panel.bars.is_empty() { Axis::vertical(panel, &x)? } else { x };
        for area in &panel.areas {
            let is_new = !area.name.is_empty() && !named.contains(&area.name.as_str());
            if is_new {
                named.push(&area.name);
            }
            data.push(shaded(area, (&x, &y), &n, is_new));
        }
        let lines: Vec<bool> = looks[i].iter().map(|look| look.line && look.marker.is_none()).collect();
        let kept = thinned::kept(panel, &lines, (&x, &y));
        for ((series, look), kept) in panel.series.iter().zip(&looks[i]).zip(&kept) {
            let is_new = !series.name.is_empty() && !named.contains(&series.name.as_str());
            if is_new {
                named.push(&series.name);
            }
            data.push(trace(series, look, kept, (&x, &y), &n, is_new));
        }
        bars(panel, &x, &n, &mut data);
        for mark in &panel.marks {
            add_mark(mark, panel, &n, &mut shapes, &mut annotations);
        }
        if let Some(title) = &panel.title {
            annotations.push(json!({
                "text": title, "showarrow": false, "font": { "size": 14 },
                "xref": format!("x{n} domain"), "yref": format!("y{n} domain"),
                "x": 0.5, "y": 1.0, "xanchor": "center", "yanchor": "bottom", "yshift": 4,
            }));
        }
    }
    let insets = insets(figure, &looks, &mut layout, &mut data)?;
    if !insets.is_empty() {
        // Where the page stacks the panels, they move with theirs.
        layout.insert("meta".to_owned(), json!({ "insets": insets }));
    }
    share_abscissas(&mut data);
    let many = figure.panels.iter().any(|p| p.series.len() > 8 || !p.bars.is_empty());
    layout.insert("height".to_owned(), json!(inner + above + below));
    layout.insert("shapes".to_owned(), json!(shapes));
    layout.insert("annotations".to_owned(), json!(annotations));
    layout.insert("hovermode".to_owned(), json!(if many { "closest" } else { "x unified" }));
    layout.insert("showlegend".to_owned(), json!(named.len() > 1));
    layout.insert(
        "legend".to_owned(),
        json!({ "orientation": "h", "x": 0, "xanchor": "left", "y": 1.0 + (above - 34.0) / inner, "yanchor": "bottom" }),
    );
    layout.insert("margin".to_owned(), json!({ "l": 72, "r": 20, "t": above, "b": below }));
    Ok(json!({ "data": data, "layout": layout }))
}

/// Axes and curves of the insets, whose numbers follow those of the panels; pairs of these numbers.
fn insets(
    figure: &Figure,
    looks: &[Vec<Resolved>],
    layout: &mut Map<String, Json>,
    data: &mut Vec<Json>,
) -> Result<Vec<[String; 2]>, FigureError> {
    let mut pairs = Vec::new();
    for (i, panel) in figure.panels.iter().enumerate() {
        let Some((x, y)) = panel.axes_of_inset()? else { continue };
        let of = if i == 0 { String::new() } else { (i + 1).to_string() };
        let n = (figure.panels.len() + pairs.len() + 1).to_string();
        let domain = |axis: &str, [from, to]: [f64; 2]| {
            let of = &layout[&format!("{axis}{of}")]["domain"];
            let [low, high] = [0, 1].map(|k| of[k].as_f64().unwrap_or_default());
            [low + from * (high - low), low + to * (high - low)]
        };
        let domains = [domain("xaxis", INSET[0]), domain("yaxis", INSET[1])];
        for (name, axis_of, [from, to], other, ticks) in
            [("xaxis", &x, domains[0], "y", 3), ("yaxis", &y, domains[1], "x", 2)]
        {
            let mut axis =
                axis("", axis_of.scale, Some((axis_of.from, axis_of.to)), &[from, to], &format!("{other}{n}"));
            axis["nticks"] = json!(ticks + 1);
            axis["tickfont"] = json!({ "size": 11 });
            axis["automargin"] = json!(false);
            axis["showgrid"] = json!(false);
            layout.insert(format!("{name}{n}"), axis);
        }
        let lines: Vec<bool> = looks[i].iter().map(|look| look.line && look.marker.is_none()).collect();
        let kept = thinned::kept(panel, &lines, (&x, &y));
        for ((series, look), kept) in panel.series.iter().zip(&looks[i]).zip(&kept).filter(|((_, look), _)| look.line) {
            let mut trace = trace(series, look, kept, (&x, &y), &n, false);
            trace["hoverinfo"] = json!("skip");
            trace["hovertemplate"] = json!(null);
            data.push(trace);
        }
        pairs.push([n, of]);
    }
    Ok(pairs)
}

/// Replaces abscissas that an earlier curve has by its index.
fn share_abscissas(data: &mut [Json]) {
    for i in 1..data.len() {
        let (before, rest) = data.split_at_mut(i);
        let x = &mut rest[0]["x"];
        if let Some(first) = before.iter().position(|other| other["x"].is_object() && other["x"] == *x) {
            *x = json!(first);
        }
    }
}

/// The `k`-th of `count` equal parts of [0, 1] with `gap` between them.
fn part(k: usize, count: usize, gap: f64) -> [f64; 2] {
    let gap = if count > 1 { gap } else { 0.0 };
    let width = (1.0 - gap * (count - 1) as f64) / count as f64;
    let from = k as f64 * (width + gap);
    [from, (from + width).min(1.0)]
}

fn axis(label: &str, scale: Scale, range: Option<(f64, f64)>, domain: &[f64; 2], anchor: &str) -> Json {
    let mut axis = json!({
        "title": { "text": label, "standoff": 8 }, "domain": domain, "anchor": anchor, "automargin": true,
        "zeroline": false, "showline": true, "ticks": "outside", "ticklen": 4, "exponentformat": "power",
    });
    if let Some((from, to)) = range {
        // The range of a logarithmic axis is given by its exponents.
        axis["range"] = match scale {
            Scale::Linear => json!([digits(from), digits(to)]),
            Scale::Log => json!([from.log10(), to.log10()]),
        };
    }
    if scale == Scale::Log {
        axis["type"] = json!("log");
        // Powers of ten; a shorter range has plotly's own ticks.
        let decades = range.map_or(1.0, |(from, to)| (to / from).log10());
        if decades >= 1.0 {
            axis["dtick"] = json!((decades / 6.0).ceil().max(1.0));
        }
    }
    axis
}

fn trace(
    series: &super::Series,
    look: &Resolved,
    kept: &[usize],
    (x, y): (&Axis, &Axis),
    n: &str,
    in_legend: bool,
) -> Json {
    if let Some(Marker::Cell { width, height }) = look.marker {
        return cells(series, look, (width, height), (x, y), n, in_legend);
    }
    let of = |values: &[f64], axis: &Axis| numbers(kept.iter().map(|&k| Some(values[k])), axis);
    // As many digits as the resolution of the page has.
    let shown = |axis: &Axis| if axis.scale == Scale::Log { ".3g" } else { ".6g" };
    let (x_shown, y_shown) = (shown(x), shown(y));
    let mode = match (look.line, look.marker) {
        (true, None) => "lines",
        (true, Some(_)) => "lines+markers",
        (false, _) => "markers",
    };
    json!({
        "type": "scatter", "mode": mode, "name": series.name, "legendgroup": series.name, "showlegend": in_legend,
        "xaxis": format!("x{n}"), "yaxis": format!("y{n}"),
        "x": of(&series.x, x),
        "y": of(&series.y, y),
        "line": { "color": hex(look.rgb), "width": 1.6 * look.width, "dash": look.dash.plotly() },
        "marker": { "color": hex(look.rgb), "size": 6, "symbol": look.marker.map_or("circle", Marker::plotly) },
        "hovertemplate": match series.name.as_str() {
            "" => format!("(%{{x:{x_shown}}}, %{{y:{y_shown}}})<extra></extra>"),
            _ => format!("%{{y:{y_shown}}}"),
        },
    })
}

/// The cells of a series as closed outlines of one filled path.
fn cells(
    series: &super::Series,
    look: &Resolved,
    (width, height): (f64, f64),
    (x, y): (&Axis, &Axis),
    n: &str,
    in_legend: bool,
) -> Json {
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)];
    let outline = |values: &[f64], size: f64, side: fn(&(f64, f64)) -> f64, axis: &Axis| {
        let around = |&value: &f64| corners.iter().map(move |corner| Some(value + size * side(corner)));
        numbers(values.iter().flat_map(|value| around(value).chain([None])), axis)
    };
    json!({
        "type": "scatter", "mode": "lines", "name": series.name, "legendgroup": series.name, "showlegend": in_legend,
        "xaxis": format!("x{n}"), "yaxis": format!("y{n}"),
        "x": outline(&series.x, width, |corner| corner.0, x),
        "y": outline(&series.y, height, |corner| corner.1, y),
        "line": { "color": hex(look.rgb), "width": 0 }, "fill": "toself", "fillcolor": hex(look.rgb),
        "hoverinfo": "skip",
    })
}

fn shaded(area: &Area, (x, y): (&Axis, &Axis), n: &str, in_legend: bool) -> Json {
    let [r, g, b] = area.hue.rgb();
    let x = numbers(area.corners().map(|corner| Some(corner.0)), x);
    let y = numbers(area.corners().map(|corner| Some(corner.1)), y);
    json!({
        "type": "scatter", "mode": "lines", "name": area.name, "legendgroup": area.name, "showlegend": in_legend,
        "xaxis": format!("x{n}"), "yaxis": format!("y{n}"), "x": x, "y": y, "hoverinfo": "skip",
        "line": { "color": hex(area.hue.rgb()), "width": 0 }, "fill": "toself",
        "fillcolor": format!("rgba({r},{g},{b},{OPACITY})"),
    })
}

fn bars(panel: &Panel, x: &Axis, n: &str, data: &mut Vec<Json>) {
    for (i, bar) in panel.bars.iter().enumerate() {
        let begin = bar.from.unwrap_or(if x.scale == Scale::Log { x.from } else { 0.0 });
        data.push(json!({
            "type": "bar", "orientation": "h", "showlegend": false, "width": 0.5,
            "xaxis": format!("x{n}"), "yaxis": format!("y{n}"),
            "y": [i], "x": [bar.to - begin], "base": [begin],
            "marker": { "color": hex(bar.hue.rgb()) },
            "text": [bar.text], "textposition": "outside", "cliponaxis": false,
            "name": bar.name, "hovertemplate": format!("{}<extra></extra>", bar.to),
        }));
    }
}

fn add_mark(mark: &Mark, panel: &Panel, n: &str, shapes: &mut Vec<Json>, annotations: &mut Vec<Json>) {
    let (x_axis, y_axis) = (format!("x{n}"), format!("y{n}"));
    let (x_span, y_span) = (format!("x{n} domain"), format!("y{n} domain"));
    let line = json!({ "color": "#6e6e6e", "width": 1 });
    let none = json!({ "width": 0 });
    let shape = |kind: &str, xref: &str, yref: &str, [x0, y0, x1, y1]: [f64; 4], line: &Json, fill: &str| {
        json!({ "type": kind, "xref": xref, "yref": yref, "x0": x0, "y0": y0, "x1": x1, "y1": y1,
                "line": line, "fillcolor": fill, "layer": "below" })
    };
    let shade = "rgba(128,140,160,0.18)";
    // Shapes take the numbers themselves on a logarithmic axis, annotations take their exponents.
    let on_x = |x: f64| if panel.x_scale == Scale::Log { x.log10() } else { x };
    let on_y = |y: f64| if panel.y_scale == Scale::Log { y.log10() } else { y };
    let (shape, place) = match mark.kind {
        MarkKind::Horizontal(y) => (
            Some(shape("line", &x_span, &y_axis, [0.0, y, 1.0, y], &line, "")),
            (json!(1.0), json!(on_y(y)), &x_span, &y_axis, "right", "bottom"),
        ),
        MarkKind::Vertical(x) => (
            Some(shape("line", &x_axis, &y_span, [x, 0.0, x, 1.0], &line, "")),
            (json!(on_x(x)), json!(1.0), &x_axis, &y_span, "left", "top"),
        ),
        MarkKind::HorizontalBand(a, b) => (
            Some(shape("rect", &x_span, &y_axis, [0.0, a, 1.0, b], &none, shade)),
            (json!(1.0), json!(f64::midpoint(on_y(a), on_y(b))), &x_span, &y_axis, "right", "middle"),
        ),
        MarkKind::Point(x, y) => (None, (json!(on_x(x)), json!(on_y(y)), &x_axis, &y_axis, "left", "bottom")),
    };
    shapes.extend(shape);
    let (x, y, xref, yref, xanchor, yanchor) = place;
    if matches!(mark.kind, MarkKind::Point(..)) {
        annotations.push(json!({ "text": "○", "showarrow": false, "font": { "size": 17 },
            "x": x, "y": y, "xref": xref, "yref": yref, "xanchor": "center", "yanchor": "middle" }));
    }
    if let Some(label) = &mark.label {
        annotations.push(json!({ "text": label, "showarrow": false, "xshift": if xanchor == "left" { 5 } else { 0 },
            "x": x, "y": y, "xref": xref, "yref": yref, "xanchor": xanchor, "yanchor": yanchor }));
    }
}

/// Long names on the vertical axis of bars, broken near the middle.
fn wrapped(name: &str) -> String {
    let middle = name.len() / 2;
    let spaces = name.match_indices(' ').map(|(i, _)| i);
    match spaces.min_by_key(|i| i.abs_diff(middle)) {
        Some(i) if name.chars().count() > 24 => format!("{}<br>{}", &name[..i], &name[i + 1..]),
        _ => name.to_owned(),
    }
}
