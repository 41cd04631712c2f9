//! Curves with the points that a screen shows: those without which the polygon would be elsewhere.
//!
//! U. Ramer, "An iterative procedure for the polygonal approximation of plane curves", CGIP 1 (1972); D. Douglas, T.
//! Peucker, Cartographica 10 (1973).

use super::ticks::Axis;
use super::{Panel, Series};

/// The largest distance between a curve and its thinned polygon, in parts of the axes: a fifth of a pixel.
pub const TOLERANCE: f64 = 2e-4;

/// The points of each series of a panel that are drawn. Curves over the same abscissas keep the same points, so that
/// all their values can be read at each of them; points with markers stay.
pub fn kept(panel: &Panel, lines: &[bool], (x, y): (&Axis, &Axis)) -> Vec<Vec<usize>> {
    let mut kept: Vec<Vec<bool>> = panel.series.iter().map(|series| vec![false; series.x.len()]).collect();
    for (series, (keep, line)) in panel.series.iter().zip(kept.iter_mut().zip(lines)) {
        if *line {
            mark(series, (x, y), keep);
        } else {
            keep.fill(true);
        }
    }
    for i in 0..kept.len() {
        for j in 0..i {
            if lines[i] && lines[j] && panel.series[i].x == panel.series[j].x {
                let both: Vec<bool> = kept[i].iter().zip(&kept[j]).map(|(a, b)| *a || *b).collect();
                kept[i].clone_from(&both);
                kept[j] = both;
            }
        }
    }
    // The first of equals has the points of all after the first round, the others after this one.
    for i in 0..kept.len() {
        if let Some(first) = (0..i).find(|j| lines[i] && lines[*j] && panel.series[i].x == panel.series[*j].x) {
            let same = kept[first].clone();
            kept[i] = same;
        }
    }
    let indices = |keep: &Vec<bool>| keep.iter().enumerate().filter(|(_, keep)| **keep).map(|(k, _)| k).collect();
    kept.iter().map(indices).collect()
}

/// Marks the points of a curve that are kept, run by run between points that are not on the axes.
fn mark(series: &Series, (x, y): (&Axis, &Axis), keep: &mut [bool]) {
    let points: Vec<(f64, f64)> = series.x.iter().zip(&series.y).map(|(&a, &b)| (x.place(a), y.place(b))).collect();
    let finite = |k: usize| points[k].0.is_finite() && points[k].1.is_finite();
    let mut start = 0;
    while start < points.len() {
        if !finite(start) {
            keep[start] = true;
            start += 1;
            continue;
        }
        let end = (start..points.len()).find(|k| !finite(*k)).unwrap_or(points.len()) - 1;
        (keep[start], keep[end]) = (true, true);
        let mut open = vec![(start, end)];
        while let Some((first, last)) = open.pop() {
            let farthest = (first + 1..last).map(|k| (k, distance(points[k], points[first], points[last])));
            if let Some((k, far)) = farthest.max_by(|a, b| a.1.total_cmp(&b.1))
                && far > TOLERANCE
            {
                keep[k] = true;
                open.extend([(first, k), (k, last)]);
            }
        }
        start = end + 1;
    }
}

/// The distance of a point from a segment.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    (p.0 - a.0 - along * dx).hypot(p.1 - a.1 - along * dy)
}
