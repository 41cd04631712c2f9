//! The points of curves that are drawn.

use luenberger_figures::figure::Scale;
use luenberger_figures::internals::{Axis, TOLERANCE, kept};
use luenberger_figures::{Panel, Series};

/// The distance of a point from a segment.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let along = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (p.0 - a.0 - along * dx).hypot(p.1 - a.1 - along * dy)
}

fn axis(from: f64, to: f64, scale: Scale) -> Axis {
    Axis { from, to, scale }
}

#[test]
fn the_polygon_stays_within_the_tolerance() {
    let t: Vec<f64> = (0..=2000).map(|k| f64::from(k) / 200.0).collect();
    let decay: Vec<f64> = t.iter().map(|t| (-t).exp()).collect();
    let wave: Vec<f64> = t.iter().map(|t| 0.5 * (7.0 * t).sin()).collect();
    let series = [Series::line("decay", &t, &decay), Series::line("wave", &t, &wave)];
    let panel = series.into_iter().fold(Panel::new("t", "x"), Panel::series);
    let (x, y) = (axis(0.0, 10.0, Scale::Linear), axis(-1.0, 1.0, Scale::Linear));
    let kept = kept(&panel, &[true, true], (&x, &y));
    assert_eq!(kept[0], kept[1]);
    assert!(kept[0].len() < 700 && kept[0].len() > 50, "{}", kept[0].len());
    for values in [&decay, &wave] {
        let at = |k: usize| (x.place(t[k]), y.place(values[k]));
        for pair in kept[0].windows(2) {
            for k in pair[0]..=pair[1] {
                assert!(distance(at(k), at(pair[0]), at(pair[1])) <= TOLERANCE);
            }
        }
    }
}

#[test]
fn straight_lines_gaps_and_markers() {
    let t: Vec<f64> = (0..100).map(f64::from).collect();
    let mut y: Vec<f64> = t.iter().map(|t| (-t / 10.0).exp()).collect();
    y[50] = f64::NAN;
    let series = [Series::line("exponential", &t, &y), Series::line("points", &t, &y)];
    let panel = series.into_iter().fold(Panel::new("t", "x"), Panel::series);
    let axes = (axis(0.0, 99.0, Scale::Linear), axis(1e-5, 1.0, Scale::Log));
    let kept = kept(&panel, &[true, false], (&axes.0, &axes.1));
    // An exponential is a line on a logarithmic axis.
    assert_eq!(kept[0], [0, 49, 50, 51, 99]);
    assert_eq!(kept[1].len(), 100);
}
