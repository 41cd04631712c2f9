//! Curves on a page, clipped and thinned.

use luenberger_figures::internals::{Rect, clip, thin};

type Point = (f64, f64);

/// The distance of a point from a segment.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let along = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (p.0 - a.0 - along * dx).hypot(p.1 - a.1 - along * dy)
}

const BOX: Rect = Rect { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };

#[test]
fn a_curve_that_leaves_and_returns_is_cut_in_two() {
    let pieces = clip(&[(1.0, 5.0), (5.0, 5.0), (5.0, 15.0), (8.0, 15.0), (8.0, 5.0)], &BOX);
    assert_eq!(pieces, [vec![(1.0, 5.0), (5.0, 5.0), (5.0, 10.0)], vec![(8.0, 10.0), (8.0, 5.0)]]);
    assert!(clip(&[(-5.0, -5.0), (-1.0, 20.0)], &BOX).is_empty());
}

#[test]
fn a_thinned_curve_stays_within_its_tolerance() {
    let curve: Vec<Point> = (0..2000).map(|k| f64::from(k) * 0.25).map(|x| (x, 100.0 * (x / 40.0).sin())).collect();
    let thinned = thin(&curve, 0.05);
    assert!(thinned.len() < 400, "{}", thinned.len());
    assert_eq!((thinned.first(), thinned.last()), (curve.first(), curve.last()));
    for p in &curve {
        let nearest = thinned.windows(2).map(|s| distance(*p, s[0], s[1])).fold(f64::INFINITY, f64::min);
        assert!(nearest <= 0.05 + 1e-12, "{nearest}");
    }
}
