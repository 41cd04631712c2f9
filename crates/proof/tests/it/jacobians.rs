//! Whether a theorem contains every Jacobian of an enclosure: hulls against plane geometry, sectors against their own
//! bounds, and the slightest change of either.

use luenberger_proof::certificate::{
    Certificate, DiscreteJacobianPolytope, JacobianPolytope, SectorConvergence, SectorTerm, Theorem, Vertex,
};
use luenberger_proof::{Interval, Matrix};
use proptest::prelude::*;

use crate::sectors::sector_decrease_within;

fn between(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// Points, intervals of a few units in the last place, and wide ones.
fn interval() -> impl Strategy<Value = Interval> {
    (-8.0f64..8.0, 0.0f64..4.0, 0u32..3).prop_map(|(x, width, kind)| match kind {
        0 => between(x, x),
        1 => between(x, x.next_up().next_up()),
        _ => between(x, (x + width).max(x)),
    })
}

fn enclosure(rows: usize, cols: usize) -> impl Strategy<Value = Matrix<Interval>> {
    prop::collection::vec(interval(), rows * cols)
        .prop_map(move |entries| Matrix::from_row_major(rows, cols, entries).unwrap())
}

/// Theorems in continuous and in discrete time, of these boxes.
fn hulls(boxes: &[(Matrix<Interval>, Matrix<Interval>)]) -> [Theorem; 2] {
    let vertices: Vec<Vertex> = boxes.iter().map(|(a, c)| Vertex::within(a, c).unwrap()).collect();
    let (n, p) = (boxes[0].0.rows(), boxes[0].1.rows());
    let l = Matrix::from_fn(n, p, |_, _| 0.0);
    let identity = Matrix::from_fn(n, n, |i, j| f64::from(i == j));
    [
        JacobianPolytope { vertices: vertices.clone(), l: l.clone(), p: identity.clone(), rate: 0.0 }.into(),
        DiscreteJacobianPolytope { vertices, l, p: identity, factor: 1.0 }.into(),
    ]
}

/// The boxes that have one end of each of the `chosen` entries and the whole interval of the others.
fn corners(
    a: &Matrix<Interval>,
    c: &Matrix<Interval>,
    chosen: &[(usize, usize)],
) -> Vec<(Matrix<Interval>, Matrix<Interval>)> {
    (0..1usize << chosen.len())
        .map(|which| {
            let mut corner = a.clone();
            for (bit, &(i, j)) in chosen.iter().enumerate() {
                let end = if which >> bit & 1 == 1 { a[(i, j)].hi() } else { a[(i, j)].lo() };
                corner[(i, j)] = between(end, end);
            }
            (corner, c.clone())
        })
        .collect()
}

/// Twice the area of the triangle, positive where it turns left.
fn turn(o: (i64, i64), a: (i64, i64), b: (i64, i64)) -> i64 {
    (a.0 - o.0) * (b.1 - o.1) - (a.1 - o.1) * (b.0 - o.0)
}

/// Whether the point is in the convex hull: it lies on the inner side of each edge, and between the least and the
/// largest in the order of coordinates, which matters where all points are on one line.
fn is_in_hull(points: &[(i64, i64)], x: (i64, i64)) -> bool {
    let is_edge = |a: (i64, i64), b: (i64, i64)| points.iter().all(|&p| turn(a, b, p) >= 0);
    let inside = |a, b| !is_edge(a, b) || turn(a, b, x) >= 0;
    points.iter().all(|&a| points.iter().all(|&b| inside(a, b)))
        && points.iter().any(|p| *p <= x)
        && points.iter().any(|p| *p >= x)
}

fn rectangle() -> impl Strategy<Value = [(i32, i32); 2]> {
    let side = || (-3i32..=3, 0i32..=3).prop_map(|(low, width)| (low, low + width));
    [side(), side()]
}

/// The entries of a sector theorem with these ends of A; one sector for each entry, about the middle that `a` has.
fn sectors(a: &Matrix<f64>, c: &Matrix<Interval>, slopes: &Matrix<(f64, f64)>) -> SectorConvergence {
    let n = a.rows();
    let mut terms = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (low, high) = slopes[(i, j)];
            let g = Matrix::from_fn(n, 1, |k, _| f64::from(k == i));
            let h = Matrix::from_fn(1, n, |_, k| f64::from(k == j));
            terms.push(SectorTerm { g, h, low, high, tau: 1.0 });
        }
    }
    let a = a.map(|x| between(*x, *x));
    let Vertex { a, c } = Vertex::within(&a, c).unwrap();
    let (p, l) = (Matrix::from_fn(n, n, |i, j| f64::from(i == j)), Matrix::from_fn(n, c.rows(), |_, _| 0.0));
    SectorConvergence { a, c, terms, l, p, rate: 0.0 }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// The corners of some entries with the whole interval of the others contain the enclosure. Without one of them, or
    /// with an end moved inwards by one unit in the last place, they do not.
    #[test]
    fn a_hull_contains_the_enclosure_of_its_corners_and_nothing_less_does(
        a in enclosure(2, 2), c in enclosure(1, 2), mask in 0u32..16, pick in any::<prop::sample::Index>(),
        entry in (0usize..3, 0usize..2), upper in any::<bool>(),
    ) {
        let all = [(0, 0), (0, 1), (1, 0), (1, 1)];
        let chosen: Vec<_> = (0..4).filter(|k| mask >> k & 1 == 1).map(|k| all[k]).collect();
        let boxes = corners(&a, &c, &chosen);
        for theorem in hulls(&boxes) {
            prop_assert!(theorem.contains_jacobians(&a, &c));
        }
        let k = pick.index(boxes.len());
        let distinct = chosen.iter().all(|&(i, j)| !a[(i, j)].is_point());
        if distinct && boxes.len() > 1 {
            let mut fewer = boxes.clone();
            fewer.remove(k);
            for theorem in hulls(&fewer) {
                prop_assert!(!theorem.contains_jacobians(&a, &c), "without box {k}");
            }
        }
        if distinct {
            let mut narrower = boxes;
            let (i, j) = entry;
            let target = if i < 2 { &mut narrower[k].0[(i, j)] } else { &mut narrower[k].1[(0, j)] };
            let (lo, hi) = (target.lo(), target.hi());
            // A point is moved, an interval loses an end.
            *target = match (lo == hi, upper) {
                (true, true) => between(lo.next_up(), lo.next_up()),
                (true, false) => between(lo.next_down(), lo.next_down()),
                (false, true) => between(lo, hi.next_down()),
                (false, false) => between(lo.next_up(), hi),
            };
            // Outwards is no loss where the other corner keeps the point inside.
            let outwards = i < 2 && chosen.contains(&(i, j)) && (upper == (hi == a[(i, j)].hi()));
            if !outwards {
                for theorem in hulls(&narrower) {
                    prop_assert!(!theorem.contains_jacobians(&a, &c), "box {k}, entry {entry:?}");
                }
            }
        }
    }

    /// In the plane of one entry of A and one of C, the four corners of an enclosure that is contained are in the hull.
    #[test]
    fn what_is_contained_is_in_the_hull(
        boxes in prop::collection::vec(rectangle(), 1..6), [a, c] in rectangle(),
    ) {
        let one = |(low, high): (i32, i32)| Matrix::from_rows([[between(f64::from(low), f64::from(high))]]);
        let pairs: Vec<_> = boxes.iter().map(|[a, c]| (one(*a), one(*c))).collect();
        let of = |[a, c]: [(i32, i32); 2]| {
            [(a.0, c.0), (a.0, c.1), (a.1, c.0), (a.1, c.1)].map(|(x, y)| (i64::from(x), i64::from(y)))
        };
        let points: Vec<_> = boxes.iter().flat_map(|sides| of(*sides)).collect();
        for theorem in hulls(&pairs) {
            if theorem.contains_jacobians(&one(a), &one(c)) {
                for corner in of([a, c]) {
                    prop_assert!(is_in_hull(&points, corner), "{corner:?} and {points:?}");
                }
            }
        }
    }

    /// A with its sectors contains exactly the sums of its entries and the slopes: integers, so that sums are exact.
    #[test]
    fn sectors_contain_their_slopes_about_a_and_nothing_more(
        middles in prop::collection::vec(-9i32..=9, 4),
        ends in prop::collection::vec((-4i32..=4, 0i32..=4), 4),
        c in enclosure(1, 2), entry in (0usize..2, 0usize..2), upper in any::<bool>(),
    ) {
        let a = Matrix::from_fn(2, 2, |i, j| f64::from(middles[2 * i + j]));
        let slopes = Matrix::from_fn(2, 2, |i, j| {
            let (low, width) = ends[2 * i + j];
            (f64::from(low), f64::from(low + width))
        });
        let jacobians = Matrix::from_fn(2, 2, |i, j| {
            let (low, high) = slopes[(i, j)];
            between(a[(i, j)] + low, a[(i, j)] + high)
        });
        let theorem = |slopes: &Matrix<(f64, f64)>, c: &Matrix<Interval>| Theorem::from(sectors(&a, c, slopes));
        prop_assert!(theorem(&slopes, &c).contains_jacobians(&jacobians, &c));
        // One unit in the last place less of a sector.
        let mut narrower = slopes.clone();
        let (low, high) = narrower[entry];
        narrower[entry] = if upper {
            (low.min(high.next_down()), high.next_down())
        } else {
            (low.next_up(), high.max(low.next_up()))
        };
        prop_assert!(!theorem(&narrower, &c).contains_jacobians(&jacobians, &c));
        // An output that is not a point, replaced by its middle.
        let middle = c.map(|x| between(x.midpoint(), x.midpoint()));
        prop_assert_eq!(
            theorem(&slopes, &middle).contains_jacobians(&jacobians, &c),
            c.as_slice().iter().all(Interval::is_point)
        );
        // Another theorem, and other shapes.
        prop_assert!(!theorem(&slopes, &c).contains_jacobians(&jacobians, &Matrix::from_rows([[between(0.0, 0.0)]])));
    }

    /// What is proved between bounds is proved for the pairs between them.
    #[test]
    fn a_sector_inequality_between_bounds_holds_for_all_pairs_between(
        a in prop::collection::vec((-4.0f64..4.0, 0.0f64..0.5), 4), c in prop::collection::vec((-2.0f64..2.0, 0.0f64..0.2), 2),
        l in prop::collection::vec(-4.0f64..4.0, 2), damping in 0.0f64..12.0, radius in 0.0f64..1.0,
        shares in prop::collection::vec(0.0f64..=1.0, 6),
    ) {
        let a = Matrix::from_fn(2, 2, |i, j| {
            let (x, width) = a[2 * i + j];
            let x = if i == j { x - damping } else { x };
            between(x, (x + width).max(x))
        });
        let c = Matrix::from_fn(1, 2, |_, j| between(c[j].0, (c[j].0 + c[j].1).max(c[j].0)));
        let l = Matrix::from_fn(2, 1, |i, _| l[i]);
        let p = Matrix::from_rows([[1.0, 0.25], [0.25, 1.0]]);
        let term = SectorTerm {
            g: Matrix::from_rows([[0.0], [1.0]]),
            h: Matrix::from_rows([[1.0, 0.0]]),
            low: -radius,
            high: radius,
            tau: 1.5,
        };
        let terms = [term];
        let decided = |vertex: Vertex| sector_decrease_within(vertex, &l, &p, 0.125, &terms).unwrap();
        if decided(Vertex::within(&a, &c).unwrap()).is_proved() {
            let at = |x: &Interval, share: f64| (x.lo() + share * (x.hi() - x.lo())).clamp(x.lo(), x.hi());
            let inside = Matrix::from_fn(2, 2, |i, j| at(&a[(i, j)], shares[2 * i + j]));
            let output = Matrix::from_fn(1, 2, |_, j| at(&c[(0, j)], shares[4 + j]));
            prop_assert!(decided(Vertex::exactly(&inside, &output).unwrap()).is_proved());
        }
    }
}

/// The plant x' = a x with a in [-2, -1], whose theorem has one vertex too few: its inequalities are proved, and it
/// says nothing of the plant.
#[test]
fn a_theorem_that_misses_a_jacobian_is_not_proved_of_the_plant() {
    let (a, c) = (Matrix::from_rows([[between(-2.0, -1.0)]]), Matrix::from_rows([[between(1.0, 1.0)]]));
    let point = |x: f64| (Matrix::from_rows([[between(x, x)]]), c.clone());
    let [whole, _] = hulls(&[point(-2.0), point(-1.0)]);
    let [part, _] = hulls(&[point(-2.0)]);
    assert!(Certificate::of([part.clone()]).unwrap().is_proved());
    let proved = Certificate::of_jacobians(whole, &a, &c).unwrap();
    assert!(proved.is_proved() && proved.file("whole").is_ok());
    let missed = Certificate::of_jacobians(part, &a, &c).unwrap();
    assert!(!missed.is_proved() && missed.theorems().is_empty() && missed.file("part").is_err());
    assert!(missed.to_string().contains("Undecided  every Jacobian between the bounds is one of the theorem"));
}

/// G and H with factors, two sectors of one entry, and sectors of several entries.
#[test]
fn the_slope_of_a_sector_is_that_of_its_one_entry() {
    let c = Matrix::from_rows([[between(1.0, 1.0), between(0.0, 0.0)]]);
    let none = Matrix::from_fn(2, 2, |_, _| (0.0, 0.0));
    let mut theorem = sectors(&Matrix::from_fn(2, 2, |_, _| 0.0), &c, &none);
    let jacobians = |lo: f64, hi: f64| {
        Matrix::from_fn(2, 2, |i, j| if (i, j) == (1, 0) { between(lo, hi) } else { between(0.0, 0.0) })
    };
    let contains =
        |theorem: &SectorConvergence, lo, hi| Theorem::from(theorem.clone()).contains_jacobians(&jacobians(lo, hi), &c);
    let term = |g: [f64; 2], h: [f64; 2], low, high| SectorTerm {
        g: Matrix::from_fn(2, 1, |i, _| g[i]),
        h: Matrix::from_fn(1, 2, |_, j| h[j]),
        low,
        high,
        tau: 1.0,
    };
    // -2 * 0.5 * [1, 3] and [0, 1].
    theorem.terms.push(term([0.0, -2.0], [0.5, 0.0], 1.0, 3.0));
    assert!(contains(&theorem, -3.0, -1.0) && !contains(&theorem, -3.0, -0.5));
    theorem.terms.push(term([0.0, 1.0], [1.0, 0.0], 0.0, 1.0));
    assert!(contains(&theorem, -3.0, 0.0) && !contains(&theorem, -3.0, 0.5));
    // A sector of several entries may be 0, and adds nothing that is certain; one that may not be 0 leaves nothing.
    theorem.terms.push(term([1.0, 1.0], [1.0, 0.0], -1.0, 1.0));
    assert!(contains(&theorem, -3.0, 0.0) && !contains(&theorem, -3.0, 0.5));
    theorem.terms.push(term([1.0, 1.0], [1.0, 0.0], 0.5, 1.0));
    assert!(!contains(&theorem, -3.0, 0.0));
    // An entry that is no number of binary64 is enclosed from inside.
    let third = between(1.0 / 3.0, (1.0 / 3.0f64).next_up());
    assert!(contains(&sectors(&Matrix::from_fn(2, 2, |_, _| 0.0), &c, &none), 0.0, 0.0));
    let wide = Matrix::from_fn(2, 2, |i, j| if (i, j) == (1, 0) { third } else { between(0.0, 0.0) });
    let Vertex { a, .. } = Vertex::within(&wide, &c).unwrap();
    let within = SectorConvergence { a, ..sectors(&Matrix::from_fn(2, 2, |_, _| 0.0), &c, &none) };
    assert!(contains(&within, third.lo(), third.hi()) && !contains(&within, third.lo(), third.hi().next_up()));
    assert!(Theorem::from(within).words().contains("Entries given by two bounds"));
}
