//! A figure, described once and drawn three ways: SVG and PNG for a paper ([`static_figure`]), interactive in the
//! report ([`interactive`]).
//!
//! A figure has panels, a panel has curves or bars. Colours are those of Okabe and Ito (2008), which people with any
//! kind of colour blindness tell apart, and each curve also gets its own dash, so that a figure survives
//! black-and-white print.
//!
//! ```
//! use luenberger_figures::{Figure, Mark, Panel, Series};
//! use luenberger_figures::figure::static_figure;
//!
//! let t: Vec<f64> = (0..=400).map(|k| f64::from(k) / 100.0).collect();
//! let [slow, fast] = [1.0, 2.0].map(|rate| t.iter().map(|t| f64::exp(-rate * t)).collect::<Vec<_>>());
//! let panel = Panel::new("time t (s)", "error e₂ (rad)")
//!     .series(Series::line("linear", &t, &slow))
//!     .series(Series::line("cubic", &t, &fast))
//!     .mark(Mark::horizontal(0.05).label("5 %"));
//! let figure = Figure::new("Decay of the error").caption("The two observers from e(0) = 1.").panel(panel);
//! assert!(static_figure::svg(&figure)?.starts_with("<svg"));
//! # Ok::<(), luenberger_figures::figure::FigureError>(())
//! ```

mod canvas;
pub mod interactive;
pub(crate) mod packed;
pub mod static_figure;
pub(crate) mod stroke;
pub(crate) mod style;
pub(crate) mod thinned;
pub(crate) mod ticks;

pub use style::colours;

use ticks::Axis;

/// Where an inset begins and ends, in parts of the width and of the height of its panel.
const INSET: [[f64; 2]; 2] = [[0.53, 0.98], [0.6, 0.98]];

/// One figure: panels in a grid under one legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// A short title. It stands in the report and in the PNG; the SVG, made for papers, leaves it to the caption.
    pub title: String,
    /// What the figure shows, with the relevant assumptions. Printed below the figure in the report.
    pub caption: String,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels per row.
    pub columns: usize,
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Stands above the axes, where there are several panels to tell apart.
    pub title: Option<String>,
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// Scale of the horizontal axis.
    pub x_scale: Scale,
    /// Scale of the vertical axis.
    pub y_scale: Scale,
    /// Horizontal range; from the data if absent. Curves are clipped to it.
    pub x_range: Option<(f64, f64)>,
    /// Vertical range; from the data if absent.
    pub y_range: Option<(f64, f64)>,
    /// Whether a small frame at the top right has the whole of the curves, where the ranges show a part of them.
    pub inset: bool,
    /// The curves.
    pub series: Vec<Series>,
    /// Shaded areas, below the curves.
    pub areas: Vec<Area>,
    /// Bars, each on its own named line of the vertical axis. A panel with bars has no curves.
    pub bars: Vec<Bar>,
    /// Reference lines, bands and labels.
    pub marks: Vec<Mark>,
}

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; data and range must be positive.
    Log,
}

/// A curve or a cloud of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend. A series without a name has no entry there; series of one name and look share one.
    pub name: String,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Its style; unset parts follow from its position in the panel.
    pub look: Look,
}

/// Style of a series; unset parts follow from the position of the series in its panel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Look {
    /// Colour.
    pub hue: Option<Hue>,
    /// Dash.
    pub dash: Option<Dash>,
    /// Line width, in points of a figure one column (8.8 cm) wide.
    pub width: Option<f64>,
    /// Marker at every point.
    pub marker: Option<Marker>,
    /// No line, markers alone.
    pub points_only: bool,
}

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hue {
    /// Number in the Okabe-Ito palette, without its yellow (unreadable on white): blue, vermilion, green, purple,
    /// sky blue, orange, black; then again from the first.
    Palette(usize),
    /// A point of the cividis colour map between 0 (dark blue) and 1 (yellow), for ordered families of curves.
    Ramp(f64),
    /// Grey, for background series.
    Grey,
}

/// A dash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Long strokes.
    Dashed,
    /// Points.
    Dotted,
    /// Stroke, point.
    DashDotted,
    /// Strokes twice as long.
    LongDashed,
}

/// A marker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Marker {
    /// Filled circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Filled diamond.
    Diamond,
    /// Filled rectangle of this size in units of the axes, for rasters: cells of neighbours touch at every zoom.
    Cell {
        /// Along the horizontal axis.
        width: f64,
        /// Along the vertical axis.
        height: f64,
    },
}

/// A translucent area between two curves over the same abscissas, such as a band of two standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Name in the legend. An area without a name has no entry there; areas of one name and colour share one.
    pub name: String,
    /// Abscissas, increasing.
    pub x: Vec<f64>,
    /// Lower ordinates.
    pub low: Vec<f64>,
    /// Upper ordinates.
    pub high: Vec<f64>,
    /// Colour.
    pub hue: Hue,
}

/// A named interval of the horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Name on the vertical axis.
    pub name: String,
    /// Where it begins; at the left end of the axis if absent.
    pub from: Option<f64>,
    /// Where it ends.
    pub to: f64,
    /// The number as it is written beside the end.
    pub text: String,
    /// Colour.
    pub hue: Hue,
}

/// An annotation.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Type and position.
    pub kind: MarkKind,
    /// Label.
    pub label: Option<String>,
}

/// Type and position of a [`Mark`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MarkKind {
    /// A line at an ordinate.
    Horizontal(f64),
    /// A line at an abscissa.
    Vertical(f64),
    /// A shaded band between two ordinates.
    HorizontalBand(f64, f64),
    /// A point `(x, y)`.
    Point(f64, f64),
}

/// A figure that cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// Nothing to draw.
    #[error("{what} is empty")]
    Empty {
        /// What is empty.
        what: String,
    },
    /// Abscissas and ordinates differ in number.
    #[error("series {series:?} has {x} abscissas and {y} ordinates")]
    Length {
        /// The series.
        series: String,
        /// Abscissas.
        x: usize,
        /// Ordinates.
        y: usize,
    },
    /// A number is not finite.
    #[error("{what}, entry {}: {value} is not a finite number", index + 1)]
    NotFinite {
        /// Where.
        what: String,
        /// Position, counted from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A logarithmic axis meets a number that is not positive.
    #[error("{what}, entry {}: {value} has no place on a logarithmic axis", index + 1)]
    NotPositive {
        /// Where.
        what: String,
        /// Position, counted from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A range is empty or reversed.
    #[error("the {axis} range from {from} to {to} is empty")]
    Range {
        /// The axis.
        axis: &'static str,
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
    /// An axis has no label.
    #[error("the {axis} axis of panel {} has no label", panel + 1)]
    Unlabelled {
        /// The axis.
        axis: &'static str,
        /// The panel, counted from 0.
        panel: usize,
    },
    /// The picture could not be encoded.
    #[error("the picture could not be encoded: {0}")]
    Encoding(String),
}

impl Figure {
    /// A figure without panels.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), caption: String::new(), panels: Vec::new(), columns: 1 }
    }

    /// Sets the caption.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a panel.
    #[must_use]
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Sets the number of panels per row; 1 stacks them, which suits panels that share their abscissa.
    #[must_use]
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns;
        self
    }

    /// Checks that the figure can be drawn.
    /// # Errors
    /// [`FigureError`] names the first series, bar, mark, range or axis that cannot.
    pub fn check(&self) -> Result<(), FigureError> {
        if self.panels.is_empty() || self.columns == 0 {
            return Err(FigureError::Empty { what: "the figure".to_owned() });
        }
        self.panels.iter().enumerate().try_for_each(|(i, panel)| panel.check(i))
    }
}

impl Panel {
    /// A panel with labelled linear axes. Labels carry units: `"time t (s)"`.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            title: None,
            x_label: x_label.into(),
            y_label: y_label.into(),
            x_scale: Scale::Linear,
            y_scale: Scale::Linear,
            x_range: None,
            y_range: None,
            inset: false,
            series: Vec::new(),
            areas: Vec::new(),
            bars: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Sets the title of the panel.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Adds a curve.
    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a shaded area.
    #[must_use]
    pub fn area(mut self, area: Area) -> Self {
        self.areas.push(area);
        self
    }

    /// Adds a bar.
    #[must_use]
    pub fn bar(mut self, bar: Bar) -> Self {
        self.bars.push(bar);
        self
    }

    /// Adds a mark.
    #[must_use]
    pub fn mark(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// Makes the horizontal axis logarithmic.
    #[must_use]
    pub fn log_x(mut self) -> Self {
        self.x_scale = Scale::Log;
        self
    }

    /// Makes the vertical axis logarithmic.
    #[must_use]
    pub fn log_y(mut self) -> Self {
        self.y_scale = Scale::Log;
        self
    }

    /// Sets the horizontal range.
    #[must_use]
    pub fn x_range(mut self, from: f64, to: f64) -> Self {
        self.x_range = Some((from, to));
        self
    }

    /// Sets the vertical range.
    #[must_use]
    pub fn y_range(mut self, from: f64, to: f64) -> Self {
        self.y_range = Some((from, to));
        self
    }

    /// Adds a small frame at the top right, over 45 % of the width and 38 % of the height, with the whole of the
    /// curves: for a panel whose ranges show a part of them, and leave that corner free.
    #[must_use]
    pub fn inset(mut self) -> Self {
        self.inset = true;
        self
    }

    /// The axes of the inset, if there is one.
    fn axes_of_inset(&self) -> Result<Option<(Axis, Axis)>, FigureError> {
        if !self.inset || self.series.is_empty() {
            return Ok(None);
        }
        let whole = Self { x_range: None, y_range: None, areas: Vec::new(), ..self.clone() };
        let x = Axis::horizontal(&whole)?;
        Ok(Some((x, Axis::vertical(&whole, &x)?)))
    }

    fn check(&self, index: usize) -> Result<(), FigureError> {
        if self.x_label.trim().is_empty() {
            return Err(FigureError::Unlabelled { axis: "horizontal", panel: index });
        }
        // The names of the bars are the label.
        if self.y_label.trim().is_empty() && self.bars.is_empty() {
            return Err(FigureError::Unlabelled { axis: "vertical", panel: index });
        }
        if self.series.is_empty() && self.bars.is_empty() {
            return Err(FigureError::Empty { what: format!("panel {}", index + 1) });
        }
        for (axis, range, scale) in
            [("horizontal", self.x_range, self.x_scale), ("vertical", self.y_range, self.y_scale)]
        {
            if let Some((from, to)) = range {
                let positive = scale == Scale::Linear || from > 0.0;
                if !(from.is_finite() && to.is_finite() && from < to && positive) {
                    return Err(FigureError::Range { axis, from, to });
                }
            }
        }
        for series in &self.series {
            let name = &series.name;
            if series.x.len() != series.y.len() {
                return Err(FigureError::Length { series: name.clone(), x: series.x.len(), y: series.y.len() });
            }
            if series.x.is_empty() {
                return Err(FigureError::Empty { what: format!("series {name:?}") });
            }
            check_numbers(&format!("abscissas of {name:?}"), &series.x, self.x_scale)?;
            check_numbers(&format!("ordinates of {name:?}"), &series.y, self.y_scale)?;
        }
        for Area { name, x, low, high, .. } in &self.areas {
            if let Some(y) = [low, high].into_iter().find(|y| y.len() != x.len()) {
                return Err(FigureError::Length { series: name.clone(), x: x.len(), y: y.len() });
            }
            if x.is_empty() {
                return Err(FigureError::Empty { what: format!("area {name:?}") });
            }
            check_numbers(&format!("abscissas of {name:?}"), x, self.x_scale)?;
            check_numbers(&format!("lower ordinates of {name:?}"), low, self.y_scale)?;
            check_numbers(&format!("upper ordinates of {name:?}"), high, self.y_scale)?;
        }
        for bar in &self.bars {
            let ends: Vec<f64> = bar.from.into_iter().chain([bar.to]).collect();
            check_numbers(&format!("bar {:?}", bar.name), &ends, self.x_scale)?;
        }
        for mark in &self.marks {
            let (x, y): (Vec<f64>, Vec<f64>) = match mark.kind {
                MarkKind::Horizontal(y) => (vec![], vec![y]),
                MarkKind::Vertical(x) => (vec![x], vec![]),
                MarkKind::HorizontalBand(a, b) => (vec![], vec![a, b]),
                MarkKind::Point(x, y) => (vec![x], vec![y]),
            };
            check_numbers("abscissa of a mark", &x, self.x_scale)?;
            check_numbers("ordinate of a mark", &y, self.y_scale)?;
        }
        Ok(())
    }
}

fn check_numbers(what: &str, numbers: &[f64], scale: Scale) -> Result<(), FigureError> {
    for (index, &value) in numbers.iter().enumerate() {
        if !value.is_finite() {
            return Err(FigureError::NotFinite { what: what.to_owned(), index, value });
        }
        if scale == Scale::Log && value <= 0.0 {
            return Err(FigureError::NotPositive { what: what.to_owned(), index, value });
        }
    }
    Ok(())
}

impl Series {
    /// A curve through the points `(x[i], y[i])`.
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self { name: name.into(), x: x.to_vec(), y: y.to_vec(), look: Look::default() }
    }

    /// The points alone.
    pub fn points(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        let look = Look { marker: Some(Marker::Circle), points_only: true, ..Look::default() };
        Self { look, ..Self::line(name, x, y) }
    }

    /// Sets colour and dash to those of this number, for a name that has the same in several figures.
    #[must_use]
    pub fn numbered(self, number: usize) -> Self {
        self.hue(Hue::Palette(number)).dash(Dash::numbered(number))
    }

    /// Sets the colour.
    #[must_use]
    pub fn hue(mut self, hue: Hue) -> Self {
        self.look.hue = Some(hue);
        self
    }

    /// Sets the dash.
    #[must_use]
    pub fn dash(mut self, dash: Dash) -> Self {
        self.look.dash = Some(dash);
        self
    }

    /// Sets the line width.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.look.width = Some(width);
        self
    }

    /// Sets a marker at every point.
    #[must_use]
    pub fn marker(mut self, marker: Marker) -> Self {
        self.look.marker = Some(marker);
        self
    }
}

impl Area {
    /// The area between `low` and `high` over the abscissas x.
    pub fn between(name: impl Into<String>, x: &[f64], low: &[f64], high: &[f64]) -> Self {
        Self { name: name.into(), x: x.to_vec(), low: low.to_vec(), high: high.to_vec(), hue: Hue::Grey }
    }

    /// Sets the colour.
    #[must_use]
    pub fn hue(mut self, hue: Hue) -> Self {
        self.hue = hue;
        self
    }

    /// The corners, from left to right above and back below.
    pub(crate) fn corners(&self) -> impl Iterator<Item = (f64, f64)> {
        let above = self.x.iter().copied().zip(self.high.iter().copied());
        above.chain(self.x.iter().copied().zip(self.low.iter().copied()).rev())
    }
}

impl Bar {
    /// A bar from the left end of the axis to `to`, which is written as `text`.
    pub fn to(name: impl Into<String>, to: f64, text: impl Into<String>) -> Self {
        Self { name: name.into(), from: None, to, text: text.into(), hue: Hue::Palette(0) }
    }

    /// Sets where the bar begins.
    #[must_use]
    pub fn from(mut self, from: f64) -> Self {
        self.from = Some(from);
        self
    }

    /// Sets the colour.
    #[must_use]
    pub fn hue(mut self, hue: Hue) -> Self {
        self.hue = hue;
        self
    }
}

impl Mark {
    fn new(kind: MarkKind) -> Self {
        Self { kind, label: None }
    }

    /// A thin horizontal line.
    pub fn horizontal(y: f64) -> Self {
        Self::new(MarkKind::Horizontal(y))
    }

    /// A thin vertical line.
    pub fn vertical(x: f64) -> Self {
        Self::new(MarkKind::Vertical(x))
    }

    /// A shaded band between two ordinates.
    pub fn horizontal_band(from: f64, to: f64) -> Self {
        Self::new(MarkKind::HorizontalBand(from, to))
    }

    /// A ring around a point.
    pub fn point(x: f64, y: f64) -> Self {
        Self::new(MarkKind::Point(x, y))
    }

    /// Words beside the mark.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }
}
