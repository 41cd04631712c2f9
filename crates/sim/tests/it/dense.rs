//! The polynomials that a run is kept as.

use luenberger_sim::dense::{NODE, NODES, enclosure};
use luenberger_sim::{Dense, SimError};

#[test]
fn the_nodes_are_chebyshev_points() {
    for (i, node) in NODE.iter().enumerate() {
        let cosine = (std::f64::consts::PI * i as f64 / (NODES - 1) as f64).cos();
        assert!((node - (1.0 - cosine) / 2.0).abs() <= f64::EPSILON / 2.0, "{i}");
    }
}

/// The worst signs of the values are those for which all terms of the barycentric formula add up at some point.
#[test]
fn the_enclosure_holds_for_all_signs() {
    let signs =
        |which: usize| -> [f64; NODES] { core::array::from_fn(|i| if which >> i & 1 == 1 { 1.0 } else { -1.0 }) };
    let all: Vec<[f64; NODES]> = (0..1 << NODES).map(signs).collect();
    let mut dense = Dense::new(all.len());
    let values: Vec<f64> = (0..NODES).flat_map(|i| all.iter().map(move |nodes| nodes[i])).collect();
    dense.push(0.0, 1.0, &[], &values);
    for k in 0..=1000 {
        let row = dense.at(f64::from(k) / 1000.0).unwrap();
        for (nodes, value) in all.iter().zip(row) {
            let (low, high) = enclosure(nodes).unwrap();
            assert!((low..=high).contains(&value), "{nodes:?}: {value} at {k}");
        }
    }
    assert_eq!(enclosure(&[2.5; NODES]), Some((2.5, 2.5)));
    assert_eq!(enclosure(&[f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), None);
}

#[test]
fn constant_components_are_stored_once_per_step() {
    let mut dense = Dense::of(&[false, true, false]);
    let values: Vec<f64> = NODE.iter().flat_map(|node| [2.0 * node, 1.0 - node]).collect();
    dense.push(0.0, 1.0, &[0.1], &values);
    assert_eq!((dense.width(), dense.stored()), (3, 17));
    let row = dense.at(0.3).unwrap();
    assert!((row[0] - 0.6).abs() < 1e-15 && row[1] == 0.1 && (row[2] - 0.7).abs() < 1e-15, "{row:?}");
    assert_eq!((dense.nodes(0, 1), dense.nodes(0, 2)[7]), ([0.1; NODES], 0.0));
    assert_eq!((dense.varying(1), dense.constant(0)), (2, 1));
    let mut points = Vec::new();
    dense.visit(&[1, 2], |t, row| points.push((t, row.to_vec())));
    assert_eq!((points.len(), &points[0], &points[7]), (8, &(0.0, vec![0.1, 1.0]), &(1.0, vec![0.1, 0.0])));
}

/// A step from 1 to 3, whose nodes are at 1 + 2 s; and two components that are constant, around one that is not.
#[test]
fn every_kept_point_has_its_time() {
    let mut dense = Dense::of(&[true, false, true]);
    let values: Vec<f64> = NODE.iter().map(|node| 5.0 * node).collect();
    dense.push(1.0, 3.0, &[7.0, 8.0], &values);
    assert_eq!([dense.constant(0), dense.constant(1), dense.varying(0)], [0, 2, 1]);
    let mut points = Vec::new();
    dense.visit(&[2, 1, 0], |t, row| points.push((t, row.to_vec())));
    let expected: Vec<_> = NODE.iter().map(|node| (1.0 + 2.0 * node, vec![8.0, 5.0 * node, 7.0])).collect();
    assert_eq!(points, expected);
}

#[test]
fn polynomials_of_degree_seven_are_kept_to_rounding() {
    let polynomial = |t: f64| [t.powi(7) - 3.0 * t.powi(4) + 1.0, 2.0 - t];
    let mut dense = Dense::new(2);
    for k in 0..4 {
        let (start, end) = (f64::from(k) * 0.5, f64::from(k + 1) * 0.5);
        let values: Vec<f64> = NODE.iter().flat_map(|node| polynomial(start + node * (end - start))).collect();
        dense.push(start, end, &[], &values);
    }
    for k in 0..=100 {
        let t = 0.02 * f64::from(k);
        let (value, wished) = (dense.at(t).unwrap(), polynomial(t));
        // Largest value is 2^7; the Lebesgue constant of eight Chebyshev points is below 3.
        assert!((value[0] - wished[0]).abs() <= 1e-13 && (value[1] - wished[1]).abs() <= 1e-14, "{t}: {value:?}");
    }
    assert_eq!(dense.at(2.1), Err(SimError::Outside { time: 2.1, start: 0.0, end: 2.0 }));
    assert!(dense.at(f64::NAN).is_err());
}
