//! Axes: range of the data, tick positions, and the mapping from values to positions.

use super::{FigureError, MarkKind, Panel, Scale};

/// One axis with its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Its beginning.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// Its scale.
    pub scale: Scale,
}

/// Ticks with their labels. Where the numbers are large or small, the labels carry a common power of ten.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ticks {
    /// Those with labels.
    pub major: Vec<(f64, String)>,
    /// Those without.
    pub minor: Vec<f64>,
    /// `×10⁵` or nothing.
    pub factor: String,
}

/// Areas may extend the curves' range by so many times its length to either side; the rest of them is cut off, so that
/// a wide band does not flatten the curves.
const ROOM_OF_AREAS: f64 = 2.0;

/// How far areas extend the axis of these ordinates of curves.
fn bounds_of_areas(curves: &[f64], scale: Scale) -> (f64, f64) {
    let low = curves.iter().copied().fold(f64::INFINITY, f64::min);
    let high = curves.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let room = ROOM_OF_AREAS * (high - low);
    let is_bounded = scale == Scale::Linear && room > 0.0 && room.is_finite();
    if is_bounded { (low - room, high + room) } else { (f64::NEG_INFINITY, f64::INFINITY) }
}

impl Axis {
    /// Where `value` lies: 0 at the beginning of the axis, 1 at its end.
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.from) / (self.to - self.from),
            Scale::Log => (value / self.from).log10() / (self.to / self.from).log10(),
        }
    }

    /// The horizontal axis of a panel: the range of the data, extended only for bars.
    pub(crate) fn horizontal(panel: &Panel) -> Result<Self, FigureError> {
        let mut values: Vec<f64> = panel.series.iter().flat_map(|s| s.x.iter().copied()).collect();
        values.extend(panel.bars.iter().flat_map(|bar| bar.from.into_iter().chain([bar.to])));
        values.extend(panel.marks.iter().filter_map(|mark| match mark.kind {
            MarkKind::Vertical(x) if !panel.bars.is_empty() => Some(x),
            _ => None,
        }));
        let only_points = !panel.series.is_empty() && panel.series.iter().all(|s| s.look.points_only);
        let room = if panel.bars.is_empty() && !only_points { 0.0 } else { 0.06 };
        let axis = Self::around(&values, panel.x_scale, room, panel.x_range, "horizontal")?;
        // Bars show lengths, so the axis starts at zero.
        let from_zero = !panel.bars.is_empty() && panel.x_range.is_none() && panel.x_scale == Scale::Linear;
        Ok(if from_zero { Self { from: axis.from.min(0.0), ..axis } } else { axis })
    }

    /// The vertical axis of a panel, with a little room above and below what is drawn within the horizontal range.
    pub(crate) fn vertical(panel: &Panel, x: &Self) -> Result<Self, FigureError> {
        let within = |v: f64| v >= x.from && v <= x.to;
        let mut values: Vec<f64> = panel
            .series
            .iter()
            .flat_map(|s| s.x.iter().zip(&s.y))
            .filter_map(|(&x, &y)| within(x).then_some(y))
            .collect();
        let bounds = bounds_of_areas(&values, panel.y_scale);
        for area in &panel.areas {
            let ends = area.x.iter().zip(area.low.iter().zip(&area.high)).filter(|(x, _)| within(**x));
            values.extend(ends.flat_map(|(_, (low, high))| [*low, *high]).map(|y| y.clamp(bounds.0, bounds.1)));
        }
        if values.is_empty() {
            values = panel.series.iter().flat_map(|s| s.y.iter().copied()).collect();
        }
        Self::around(&values, panel.y_scale, 0.05, panel.y_range, "vertical")
    }

    fn around(
        values: &[f64],
        scale: Scale,
        room: f64,
        given: Option<(f64, f64)>,
        axis: &'static str,
    ) -> Result<Self, FigureError> {
        if let Some((from, to)) = given {
            return Ok(Self { from, to, scale });
        }
        let from = values.iter().copied().fold(f64::INFINITY, f64::min);
        let to = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = match scale {
            Scale::Linear if from == to => {
                let half = if from == 0.0 { 1.0 } else { from.abs() / 2.0 };
                (from - half, to + half)
            }
            // Data that begin or end at zero sit on the axis.
            Scale::Linear => (
                if from == 0.0 { 0.0 } else { from - room * (to - from) },
                if to == 0.0 { 0.0 } else { to + room * (to - from) },
            ),
            Scale::Log if from == to => (from / 10.0, to * 10.0),
            Scale::Log => {
                let grow = (to / from).powf(room);
                (from / grow, to * grow)
            }
        };
        // Beyond this range the differences overflow or underflow.
        let sound = low.is_finite() && high.is_finite() && low < high && (high - low).is_finite();
        if sound { Ok(Self { from: low, to: high, scale }) } else { Err(FigureError::Range { axis, from, to }) }
    }

    /// About `count` round numbers.
    pub fn ticks(&self, count: usize) -> Ticks {
        match self.scale {
            Scale::Linear => self.linear_ticks(count),
            Scale::Log => self.log_ticks(count),
        }
    }

    fn linear_ticks(&self, count: usize) -> Ticks {
        let span = self.to - self.from;
        let rough = span / count.max(1) as f64;
        let exponent = rough.log10().floor() as i32;
        let (factor, parts) = match rough / power(exponent) {
            r if r < 1.5 => (1.0, 5),
            r if r < 3.5 => (2.0, 4),
            r if r < 7.5 => (5.0, 5),
            _ => (10.0, 5),
        };
        let step = factor * power(exponent);
        let slack = 1e-9 * span;
        let values = |step: f64| {
            let first = ((self.from - slack) / step).ceil() as i64;
            let last = ((self.to + slack) / step).floor() as i64;
            (first..=last.min(first + 200)).map(move |k| k as f64 * step).collect::<Vec<_>>()
        };
        let majors = values(step);
        let largest = majors.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let shift = match largest.log10().floor() {
            e if largest > 0.0 && !(-2.0..4.0).contains(&e) => e as i32,
            _ => 0,
        };
        let digits = (shift - step.log10().floor() as i32).max(0);
        let label = |x: f64| {
            let text = format!("{:.*}", digits as usize, x / power(shift));
            if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".to_owned() } else { text }
        };
        Ticks {
            major: majors.iter().map(|&x| (x, label(x).replace('-', "−"))).collect(),
            minor: values(step / f64::from(parts)),
            factor: if shift == 0 { String::new() } else { format!("×10{}", superscript(shift)) },
        }
    }

    fn log_ticks(&self, count: usize) -> Ticks {
        let (from, to) = (self.from.log10() - 1e-9, self.to.log10() + 1e-9);
        let (first, last) = (from.ceil() as i32, to.floor() as i32);
        let plain = first >= -3 && last <= 3;
        let name = |m: i32, e: i32| {
            let value = f64::from(m) * power(e);
            let text = match (plain, m) {
                (true, _) => format!("{:.*}", (-e).max(0) as usize, value),
                (false, 1) => format!("10{}", superscript(e)),
                _ => format!("{m}·10{}", superscript(e)),
            };
            (value, text)
        };
        let decades = (last - first + 1).max(0);
        // At most 632 decades are between the ends of binary64.
        let stride = (f64::from(decades) / count.max(2) as f64).ceil().max(1.0) as i32;
        let within = |x: f64| x.log10() >= from && x.log10() <= to;
        let mut major: Vec<(f64, String)> =
            (first..=last).filter(|e| e.rem_euclid(stride) == 0).map(|e| name(1, e)).collect();
        if decades < 2 {
            // Less than two decades: powers of ten alone would give too few ticks.
            for e in first - 1..=last {
                major.extend([2, 5].map(|m| name(m, e)).into_iter().filter(|(x, _)| within(*x)));
            }
            major.sort_by(|a, b| a.0.total_cmp(&b.0));
            if major.len() < 3 {
                // Within a factor of a few the axis is nearly linear.
                return self.linear_ticks(count);
            }
        }
        let multiples = if decades <= 6 { 2..=9 } else { 1..=1 };
        let minor = (first - 1..=last)
            .flat_map(|e| multiples.clone().map(move |m| f64::from(m) * power(e)))
            .filter(|&x| within(x))
            .collect();
        Ticks { major, minor, factor: String::new() }
    }
}

/// `10^e`, rounded once.
fn power(e: i32) -> f64 {
    // A decimal literal is correctly rounded, where `powi` accumulates; and it always parses.
    format!("1e{e}").parse().unwrap_or(f64::NAN)
}

fn superscript(e: i32) -> String {
    e.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            d => char::from_u32(0x2070 + d.to_digit(10).unwrap_or(0)).unwrap_or(d),
        })
        .collect()
}
