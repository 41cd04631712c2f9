//! Static figure for a paper, as SVG and as PNG.
//!
//! One column of a journal is 8.8 cm, drawn here as 520 pixels, so that 17 pixels are 8 points; the PNG has three times
//! as many. The legend stands above the axes, where it cannot cover data, and is shared by the panels. Panels stacked
//! in one column that share their horizontal axis show its labels once. Nothing is drawn but plain strokes, areas and
//! upright words, so that both forms are the same picture.

use super::canvas::{Anchor, Canvas, Point};
use super::stroke::{Rect, clip, thin};
use super::style::{BAND, OPACITY, Resolved, Rgb, resolve};
use super::ticks::{Axis, Ticks};
use super::{Figure, FigureError, INSET, Mark, MarkKind, Marker, Panel, Scale, Series};

const COLUMN: f64 = 520.0;
/// Pixels per point of a figure one column wide.
const POINT: f64 = COLUMN / (8.8 / 2.54 * 72.0);
const LABEL: f64 = 18.0;
const NUMBER: f64 = 16.0;
const SMALL: f64 = 13.0;
const INK: Rgb = [30, 30, 30];
const GRID: Rgb = [226, 229, 233];
const TICK: f64 = 5.0;

/// The figure as SVG.
/// # Errors
/// [`FigureError`] names the part of the figure that cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String, FigureError> {
    Ok(page(figure, false)?.svg())
}

/// The figure as PNG, 1560 pixels wide per column, under its title.
/// # Errors
/// [`FigureError`] names the part of the figure that cannot be drawn.
pub fn png(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    page(figure, true)?.png()
}

/// A panel with its axes and ticks, before it has a place on the page.
struct Prepared<'a> {
    panel: &'a Panel,
    looks: &'a [Resolved],
    x: Axis,
    y: Axis,
    x_ticks: Ticks,
    y_ticks: Ticks,
    height: f64,
    /// From the left end of the page to the axis: the numbers stand there.
    left: f64,
    /// Another panel just below has the same horizontal axis and shows its labels.
    shares_x: bool,
    /// The axes of its inset.
    inset: Option<(Axis, Axis)>,
}

fn page(figure: &Figure, titled: bool) -> Result<Canvas, FigureError> {
    figure.check()?;
    let looks = resolve(figure);
    let columns = figure.columns.min(figure.panels.len());
    let width = COLUMN * columns as f64;
    let mut page = Page { canvas: Canvas::new(width)? };
    let mut panels = Vec::new();
    for (i, panel) in figure.panels.iter().enumerate() {
        panels.push(prepare(panel, &looks[i], figure, i, columns, &page.canvas)?);
    }

    let mut top = if titled { page.title(&figure.title, width) } else { 0.0 };
    top += page.legend(&panels, width, top);
    for row in 0..panels.len().div_ceil(columns) {
        let here = row * columns..((row + 1) * columns).min(panels.len());
        let head = panels[here.clone()].iter().map(Prepared::head).fold(0.0, f64::max);
        let body = panels[here.clone()].iter().map(|p| p.height).fold(0.0, f64::max);
        let foot = panels[here.clone()].iter().map(Prepared::foot).fold(0.0, f64::max);
        for k in here {
            let column = k % columns;
            // Panels of one column are aligned, so that their common abscissa lines up.
            let left = panels.iter().skip(column).step_by(columns).map(|p| p.left).fold(0.0, f64::max);
            let origin = COLUMN * column as f64;
            let frame =
                Rect { left: origin + left, top: top + head, right: origin + COLUMN - 20.0, bottom: top + head + body };
            page.panel(&panels[k], &frame, origin);
        }
        top += head + body + foot;
    }
    page.canvas.height = (top + 6.0).ceil();
    Ok(page.canvas)
}

fn prepare<'a>(
    panel: &'a Panel,
    looks: &'a [Resolved],
    figure: &Figure,
    index: usize,
    columns: usize,
    canvas: &Canvas,
) -> Result<Prepared<'a>, FigureError> {
    let x = Axis::horizontal(panel)?;
    let stacked = columns == 1 && figure.panels.len() > 1;
    let (y, y_ticks, height) = if panel.bars.is_empty() {
        let y = Axis::vertical(panel, &x)?;
        let height = if stacked { 200.0 } else { 290.0 };
        (y, y.ticks(if stacked { 4 } else { 5 }), height)
    } else {
        // The first bar on top, one unit of the axis each.
        let count = panel.bars.len() as f64;
        // Words of marks stand above the first.
        let top = if panel.marks.iter().any(|mark| mark.label.is_some()) { -0.45 } else { 0.0 };
        (Axis { from: count, to: top, scale: Scale::Linear }, Ticks::default(), 52.0 * (count - top) + 8.0)
    };
    let below = if stacked { figure.panels.get(index + 1) } else { None };
    let shares_x = match below {
        Some(below) => below.x_label == panel.x_label && Axis::horizontal(below)? == x,
        None => false,
    };
    let numbers = y_ticks.major.iter().map(|(_, label)| canvas.width(label, NUMBER)).fold(0.0, f64::max);
    let left = (numbers + TICK + 10.0).max(24.0);
    let inset = panel.axes_of_inset()?;
    Ok(Prepared { panel, looks, x, y, x_ticks: x.ticks(5), y_ticks, height, left, shares_x, inset })
}

impl Prepared<'_> {
    fn head(&self) -> f64 {
        let label = if self.panel.y_label.is_empty() { 10.0 } else { 30.0 };
        let title = if self.panel.title.is_some() { 28.0 } else { 0.0 };
        label + title
    }

    fn foot(&self) -> f64 {
        if self.shares_x { 8.0 } else { 58.0 }
    }
}

/// What stands before a name in the legend.
#[derive(Clone, Copy, PartialEq)]
enum Key {
    Line(Resolved),
    Area(Rgb),
}

struct Page {
    canvas: Canvas,
}

impl Page {
    /// Writes the title in lines as wide as the figure, and returns their height.
    fn title(&mut self, title: &str, width: f64) -> f64 {
        let (left, line) = (8.0, 26.0);
        let mut lines: Vec<String> = Vec::new();
        for word in title.split_whitespace() {
            match lines.last_mut() {
                Some(last) if self.canvas.width(&format!("{last} {word}"), LABEL) <= width - 2.0 * left => {
                    last.push(' ');
                    last.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        for (k, words) in lines.iter().enumerate() {
            self.text((left, 22.0 + line * k as f64), words, LABEL, Anchor::Start);
        }
        line * lines.len() as f64 + if lines.is_empty() { 0.0 } else { 10.0 }
    }

    /// Draws the legend from `top` on and returns its height: one entry for each name, in rows as wide as the figure.
    fn legend(&mut self, panels: &[Prepared], width: f64, top: f64) -> f64 {
        let mut entries: Vec<(&str, Key)> = Vec::new();
        let mut add = |name, key| {
            let entry: (&str, Key) = (name, key);
            if !entry.0.is_empty() && !entries.contains(&entry) {
                entries.push(entry);
            }
        };
        for panel in panels {
            for (series, look) in panel.panel.series.iter().zip(panel.looks) {
                add(&series.name, Key::Line(*look));
            }
            for area in &panel.panel.areas {
                add(&area.name, Key::Area(area.hue.rgb()));
            }
        }
        // A single curve is named by its axis.
        if entries.len() < 2 {
            return 0.0;
        }
        let (key, gap, row) = (40.0, 20.0, 27.0);
        let left = panels.first().map_or(0.0, |p| p.left);
        let widths: Vec<f64> =
            entries.iter().map(|(name, _)| key + 8.0 + self.canvas.width(name, NUMBER) + gap).collect();
        let room = width - left - 20.0 + gap;
        // Columns as wide as their widest entry, in as few rows as fit, and these equally full.
        let columns = |per_row: usize| -> Vec<f64> {
            (0..per_row).map(|c| widths.iter().skip(c).step_by(per_row).copied().fold(0.0, f64::max)).collect()
        };
        let per_row = (1..=entries.len())
            .map(|rows| entries.len().div_ceil(rows))
            .find(|&per_row| columns(per_row).iter().sum::<f64>() <= room)
            .unwrap_or(1);
        let columns = columns(per_row);
        for (i, (name, look)) in entries.iter().enumerate() {
            let (r, c) = (i / per_row, i % per_row);
            let x = left + columns[..c].iter().sum::<f64>();
            let y = top + 18.0 + r as f64 * row;
            match look {
                Key::Line(look) => {
                    if look.line {
                        self.curve(&[(x, y), (x + key, y)], look);
                    }
                    if let Some(marker) = look.marker {
                        self.marker((x + key / 2.0, y), marker, look);
                    }
                }
                Key::Area(rgb) => {
                    let (top, bottom) = (y - 7.0, y + 7.0);
                    self.canvas.shade(&[(x, top), (x + key, top), (x + key, bottom), (x, bottom)], *rgb, OPACITY);
                }
            }
            self.text((x + key + 8.0, y + 5.5), name, NUMBER, Anchor::Start);
        }
        row * entries.len().div_ceil(per_row) as f64 + 6.0
    }

    fn panel(&mut self, p: &Prepared, frame: &Rect, origin: f64) {
        let at = |x: f64, y: f64| -> Point {
            (
                frame.left + p.x.place(x) * (frame.right - frame.left),
                frame.bottom - p.y.place(y) * (frame.bottom - frame.top),
            )
        };
        for mark in &p.panel.marks {
            self.band(mark, frame, at);
        }
        for &(x, _) in &p.x_ticks.major {
            let (x, _) = at(x, p.y.from);
            self.line((x, frame.top), (x, frame.bottom), GRID, 1.0);
        }
        for &(y, _) in &p.y_ticks.major {
            let (_, y) = at(p.x.from, y);
            self.line((frame.left, y), (frame.right, y), GRID, 1.0);
        }
        for mark in &p.panel.marks {
            self.reference(mark, frame, at);
        }
        for area in &p.panel.areas {
            let within = |(x, y): Point| (x.clamp(frame.left, frame.right), y.clamp(frame.top, frame.bottom));
            let corners: Vec<Point> = area.corners().map(|(x, y)| within(at(x, y))).collect();
            self.canvas.shade(&corners, area.hue.rgb(), OPACITY);
        }
        for (series, look) in p.panel.series.iter().zip(p.looks) {
            let points: Vec<Point> = series.x.iter().zip(&series.y).map(|(&x, &y)| at(x, y)).collect();
            if look.line {
                for piece in clip(&points, frame) {
                    self.curve(&thin(&piece, 0.08), look);
                }
            }
            if let Some(Marker::Cell { width, height }) = look.marker {
                self.cells(series, (width, height), look.rgb, frame, at);
            } else if let Some(marker) = look.marker {
                for &point in points.iter().filter(|&&point| frame.contains(point)) {
                    self.marker(point, marker, look);
                }
            }
        }
        self.bars(p, frame, at);
        for mark in &p.panel.marks {
            self.words(mark, frame, at);
        }
        self.axes(p, frame, origin, at);
        if let Some(axes) = &p.inset {
            self.inset(p, axes, frame);
        }
    }

    /// The whole of the curves in the corner of a panel, with few numbers.
    fn inset(&mut self, p: &Prepared, (x, y): &(Axis, Axis), frame: &Rect) {
        let (width, height) = (frame.right - frame.left, frame.bottom - frame.top);
        let [[left, right], [bottom, top]] = INSET;
        let ticks = [x.ticks(3), y.ticks(2)];
        let numbers = ticks[1].major.iter().map(|(_, label)| self.canvas.width(label, SMALL)).fold(0.0, f64::max);
        let outer = Rect {
            left: frame.left + left * width,
            top: frame.bottom - top * height,
            right: frame.left + right * width,
            bottom: frame.bottom - bottom * height,
        };
        self.rectangle(outer, [255; 3]);
        let inner = Rect { left: outer.left + numbers + 12.0, bottom: outer.bottom - 20.0, ..outer };
        let at = |a: f64, b: f64| -> Point {
            (
                inner.left + x.place(a) * (inner.right - inner.left),
                inner.bottom - y.place(b) * (inner.bottom - inner.top),
            )
        };
        for (series, look) in p.panel.series.iter().zip(p.looks).filter(|(_, look)| look.line) {
            let points: Vec<Point> = series.x.iter().zip(&series.y).map(|(&a, &b)| at(a, b)).collect();
            for piece in clip(&points, &inner) {
                self.curve(&thin(&piece, 0.08), look);
            }
        }
        for (a, b) in [
            ((inner.left, inner.top), (inner.left, inner.bottom)),
            ((inner.left, inner.bottom), (inner.right, inner.bottom)),
        ] {
            self.line(a, b, INK, 1.0);
        }
        for (a, label) in &ticks[0].major {
            self.text((at(*a, y.from).0, inner.bottom + 16.0), label, SMALL, Anchor::Middle);
        }
        for (b, label) in &ticks[1].major {
            self.text((inner.left - 5.0, at(x.from, *b).1 + 4.5), label, SMALL, Anchor::End);
        }
        if !ticks[1].factor.is_empty() {
            self.text((inner.left + 5.0, inner.top + 11.0), &ticks[1].factor, SMALL, Anchor::Start);
        }
    }

    fn cells(
        &mut self,
        series: &Series,
        (width, height): (f64, f64),
        rgb: Rgb,
        frame: &Rect,
        at: impl Fn(f64, f64) -> Point,
    ) {
        // Wider by a part of a pixel, so that no seam is left between neighbours.
        let seam = 0.2;
        for (&x, &y) in series.x.iter().zip(&series.y) {
            let (left, bottom) = at(x - width / 2.0, y - height / 2.0);
            let (right, top) = at(x + width / 2.0, y + height / 2.0);
            let (left, right) = ((left - seam).max(frame.left), (right + seam).min(frame.right));
            let (top, bottom) = ((top - seam).max(frame.top), (bottom + seam).min(frame.bottom));
            if left < right && top < bottom {
                self.rectangle(Rect { left, top, right, bottom }, rgb);
            }
        }
    }

    fn axes(&mut self, p: &Prepared, frame: &Rect, origin: f64, at: impl Fn(f64, f64) -> Point) {
        self.line((frame.left, frame.bottom), (frame.right, frame.bottom), INK, 1.4);
        if p.panel.bars.is_empty() {
            self.line((frame.left, frame.top), (frame.left, frame.bottom), INK, 1.4);
        }
        for &x in &p.x_ticks.minor {
            let (x, _) = at(x, p.y.from);
            self.line((x, frame.bottom), (x, frame.bottom + TICK * 0.6), INK, 1.0);
        }
        for &y in &p.y_ticks.minor {
            let (_, y) = at(p.x.from, y);
            self.line((frame.left - TICK * 0.6, y), (frame.left, y), INK, 1.0);
        }
        for (x, label) in &p.x_ticks.major {
            let (x, _) = at(*x, p.y.from);
            self.line((x, frame.bottom), (x, frame.bottom + TICK), INK, 1.4);
            if !p.shares_x {
                self.text((x, frame.bottom + TICK + 17.0), label, NUMBER, Anchor::Middle);
            }
        }
        for (y, label) in &p.y_ticks.major {
            let (_, y) = at(p.x.from, *y);
            self.line((frame.left - TICK, y), (frame.left, y), INK, 1.4);
            self.text((frame.left - TICK - 4.0, y + 5.5), label, NUMBER, Anchor::End);
        }
        let middle = f64::midpoint(frame.left, frame.right);
        if let Some(title) = &p.panel.title {
            let above = if p.panel.y_label.is_empty() { 10.0 } else { 40.0 };
            self.text((middle, frame.top - above), title, LABEL, Anchor::Middle);
        }
        if !p.shares_x {
            let label = with_factor(&p.panel.x_label, &p.x_ticks.factor);
            self.text((middle, frame.bottom + TICK + 43.0), &label, LABEL, Anchor::Middle);
        }
        // The label is above the axis, where it is horizontal and takes no width from the data.
        let label = with_factor(&p.panel.y_label, &p.y_ticks.factor);
        self.text((origin + 8.0, frame.top - 12.0), &label, LABEL, Anchor::Start);
    }

    fn bars(&mut self, p: &Prepared, frame: &Rect, at: impl Fn(f64, f64) -> Point) {
        for (i, bar) in p.panel.bars.iter().enumerate() {
            let row = i as f64;
            let begin = bar.from.unwrap_or(if p.x.scale == Scale::Log { p.x.from } else { p.x.from.max(0.0) });
            let within = |x: f64| x.clamp(frame.left, frame.right);
            let (x0, y) = at(begin, row + 0.72);
            let (x1, _) = at(bar.to, row + 0.72);
            let (left, right) = (within(x0.min(x1)), within(x0.max(x1)));
            self.rectangle(Rect { left, top: y - 9.0, right, bottom: y + 9.0 }, bar.hue.rgb());
            let (_, name) = at(begin, row + 0.42);
            let end = frame.left + 6.0 + self.canvas.width(&bar.name, NUMBER);
            self.rectangle(Rect { left: frame.left + 2.0, top: name - 14.0, right: end, bottom: name + 4.0 }, [255; 3]);
            self.text((frame.left + 4.0, name), &bar.name, NUMBER, Anchor::Start);
            let value = bar.text.replace('-', "−");
            // Beside the bar if there is room, else in it.
            if right + self.canvas.width(&value, NUMBER) + 10.0 < frame.right {
                self.text((right + 7.0, y + 5.5), &value, NUMBER, Anchor::Start);
            } else {
                // Perceived brightness (ITU-R BT.601) decides between dark and white digits.
                let [r, g, b] = bar.hue.rgb().map(f64::from);
                let ink = if 0.299 * r + 0.587 * g + 0.114 * b > 140.0 { INK } else { [255; 3] };
                self.canvas.words((right - 7.0, y + 5.5), &value, NUMBER, Anchor::End, ink);
            }
        }
    }

    fn band(&mut self, mark: &Mark, frame: &Rect, at: impl Fn(f64, f64) -> Point) {
        let MarkKind::HorizontalBand(a, b) = mark.kind else { return };
        let (a, b) = (at(0.0, a).1, at(0.0, b).1);
        let y = |v: f64| v.clamp(frame.top, frame.bottom);
        self.rectangle(Rect { top: y(a.min(b)), bottom: y(a.max(b)), ..*frame }, BAND);
    }

    fn reference(&mut self, mark: &Mark, frame: &Rect, at: impl Fn(f64, f64) -> Point) {
        let (a, b) = match mark.kind {
            MarkKind::Horizontal(y) => ((frame.left, at(0.0, y).1), (frame.right, at(0.0, y).1)),
            MarkKind::Vertical(x) => ((at(x, 0.0).0, frame.top), (at(x, 0.0).0, frame.bottom)),
            _ => return,
        };
        if frame.contains(a) && frame.contains(b) {
            self.line(a, b, [110, 110, 110], 1.3);
        }
    }

    /// The words of a mark and its ring, above the data.
    fn words(&mut self, mark: &Mark, frame: &Rect, at: impl Fn(f64, f64) -> Point) {
        if let MarkKind::Point(x, y) = mark.kind {
            let (x, y) = at(x, y);
            if frame.contains((x, y)) {
                self.canvas.ring((x, y), 5.0, 1.8, INK);
            }
        }
        let Some(label) = &mark.label else { return };
        let width = self.canvas.width(label, NUMBER);
        let (x, y) = match mark.kind {
            MarkKind::Horizontal(y) => (frame.right - width - 6.0, at(0.0, y).1 - 6.0),
            MarkKind::HorizontalBand(a, b) => {
                (frame.right - width - 6.0, f64::midpoint(at(0.0, a).1, at(0.0, b).1) + 5.5)
            }
            MarkKind::Vertical(x) => (at(x, 0.0).0 + 6.0, frame.top + 16.0),
            MarkKind::Point(x, y) => {
                let (x, y) = at(x, y);
                // Above the ring, or below it where the axes end.
                (x + 9.0, if y - 24.0 < frame.top { y + 20.0 } else { y - 8.0 })
            }
        };
        // Words of a mark beyond the range would name nothing; words that begin within it are pushed in whole.
        if x + width < frame.left || x > frame.right || y + 12.0 < frame.top || y - 12.0 > frame.bottom {
            return;
        }
        let x = x.min(frame.right - width - 4.0).max(frame.left + 4.0);
        let y = y.clamp(frame.top + 15.0, frame.bottom - 4.0);
        self.text((x, y), label, NUMBER, Anchor::Start);
    }

    fn curve(&mut self, points: &[Point], look: &Resolved) {
        let width = look.width * POINT;
        let pattern: Vec<f64> = look.dash.pattern().iter().map(|part| part * width).collect();
        self.canvas.stroke(points, width, &pattern, look.rgb);
    }

    fn marker(&mut self, (x, y): Point, marker: Marker, look: &Resolved) {
        let r = 4.6;
        let corners: &[Point] = match marker {
            Marker::Circle => return self.canvas.disc((x, y), r, look.rgb),
            Marker::Square | Marker::Cell { .. } => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)],
            Marker::Diamond => &[(0.0, -1.3), (1.0, 0.0), (0.0, 1.3), (-1.0, 0.0)],
        };
        let corners: Vec<Point> = corners.iter().map(|(dx, dy)| (x + r * dx, y + r * dy)).collect();
        self.canvas.area(&corners, look.rgb);
    }

    fn rectangle(&mut self, Rect { left, top, right, bottom }: Rect, fill: Rgb) {
        self.canvas.area(&[(left, top), (right, top), (right, bottom), (left, bottom)], fill);
    }

    fn line(&mut self, from: Point, to: Point, stroke: Rgb, width: f64) {
        self.canvas.stroke(&[from, to], width, &[], stroke);
    }

    fn text(&mut self, at: Point, content: &str, size: f64, anchor: Anchor) {
        self.canvas.words(at, content, size, anchor, INK);
    }
}

/// `J (rad²·s) ×10⁵`: the numbers on the axis are to be multiplied by the factor.
fn with_factor(label: &str, factor: &str) -> String {
    if factor.is_empty() { label.to_owned() } else { format!("{label}\u{2003}{factor}") }
}
