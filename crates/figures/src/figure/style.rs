//! Colours, dashes and line widths, the same in every rendering, and their assignment to series.
//!
//! Colours: M. Okabe, K. Ito, "Color Universal Design", 2008, without the yellow, which vanishes on white; cividis:
//! J. Nunez, C. Anderton, R. Renslow, PLoS ONE 13(7), 2018.

use super::{Dash, Figure, Hue, Marker, Series};

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

const PALETTE: [Rgb; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0], [0, 0, 0]];
/// The default colours of series, in CSS: `#0072b2`.
pub fn colours() -> Vec<String> {
    PALETTE.iter().map(|colour| hex(*colour)).collect()
}

const DASHES: [Dash; 5] = [Dash::Solid, Dash::Dashed, Dash::DashDotted, Dash::Dotted, Dash::LongDashed];
/// Cividis at 0, 1/8, ..., 1.
pub const CIVIDIS: [Rgb; 9] = [
    [0, 34, 78],
    [32, 56, 111],
    [68, 78, 108],
    [97, 100, 111],
    [124, 123, 120],
    [155, 147, 119],
    [187, 172, 109],
    [221, 200, 88],
    [254, 232, 56],
];
/// Of what has no name.
pub const GREY: Rgb = [140, 140, 140];
pub(crate) const BAND: Rgb = [236, 239, 243];
/// Of areas, through which curves and other areas are seen.
pub(crate) const OPACITY: f64 = 0.18;

impl Hue {
    pub(crate) fn rgb(self) -> Rgb {
        match self {
            Self::Palette(k) => PALETTE[k % PALETTE.len()],
            Self::Grey => GREY,
            Self::Ramp(s) => {
                let s = s.clamp(0.0, 1.0) * (CIVIDIS.len() - 1) as f64;
                let k = (s.floor() as usize).min(CIVIDIS.len() - 2);
                let part = s - k as f64;
                std::array::from_fn(|i| {
                    let (a, b) = (f64::from(CIVIDIS[k][i]), f64::from(CIVIDIS[k + 1][i]));
                    (a + part * (b - a)).round() as u8
                })
            }
        }
    }
}

/// `#rrggbb`.
pub(crate) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Dash {
    /// The dash of this number; from the sixth on they repeat.
    pub fn numbered(number: usize) -> Self {
        DASHES[number % DASHES.len()]
    }

    /// Strokes and gaps in multiples of the line width.
    pub(crate) fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[4.5, 2.6],
            Self::Dotted => &[1.0, 1.9],
            Self::DashDotted => &[6.0, 2.2, 1.0, 2.2],
            Self::LongDashed => &[9.0, 3.0],
        }
    }

    /// Plotly's name.
    pub(crate) fn plotly(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dashed => "dash",
            Self::Dotted => "dot",
            Self::DashDotted => "dashdot",
            Self::LongDashed => "longdash",
        }
    }
}

impl Marker {
    /// Plotly's name.
    pub(crate) fn plotly(self) -> &'static str {
        match self {
            Self::Circle => "circle",
            Self::Square | Self::Cell { .. } => "square",
            Self::Triangle => "triangle-up",
            Self::Diamond => "diamond",
        }
    }
}

/// A style with all parts set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolved {
    /// Red, green, blue.
    pub rgb: Rgb,
    /// The dash.
    pub dash: Dash,
    /// The width of the line.
    pub width: f64,
    /// The marker, if there is one.
    pub marker: Option<Marker>,
    /// Whether there is a line.
    pub line: bool,
}

/// The styles of all series, panel by panel. A name has one style in the whole figure: by default the next free colour
/// and dash. Series without a name are grey and solid by default.
pub fn resolve(figure: &Figure) -> Vec<Vec<Resolved>> {
    let mut names: Vec<&str> = Vec::new();
    let mut looks = Vec::with_capacity(figure.panels.len());
    for panel in &figure.panels {
        looks.push(panel.series.iter().map(|series| resolve_one(series, &mut names)).collect());
    }
    looks
}

fn resolve_one<'a>(series: &'a Series, names: &mut Vec<&'a str>) -> Resolved {
    // Series with an explicit style also take a place, so that no two names share a style by accident.
    let place = (!series.name.is_empty()).then(|| {
        names.iter().position(|name| *name == series.name).unwrap_or_else(|| {
            names.push(&series.name);
            names.len() - 1
        })
    });
    Resolved {
        rgb: series.look.hue.unwrap_or_else(|| place.map_or(Hue::Grey, Hue::Palette)).rgb(),
        dash: series.look.dash.unwrap_or_else(|| place.map_or(Dash::Solid, Dash::numbered)),
        width: series.look.width.unwrap_or(if place.is_some() { 1.2 } else { 0.7 }),
        marker: series.look.marker,
        line: !series.look.points_only,
    }
}
