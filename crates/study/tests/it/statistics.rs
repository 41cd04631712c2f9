//! Moments, percentiles and the Pareto front.

use luenberger_study::internals::Percentiles;
use luenberger_study::statistics::{Moments, pareto_front, percentile};

/// By Python's math.fsum: mean and standard deviation of sin(k), k = 0..99.
#[test]
fn moments_of_parts_are_those_of_the_whole() {
    let values: Vec<f64> = (0..100).map(|k| f64::from(k).sin()).collect();
    let whole = Moments::of(&values);
    let (mean, deviation) = (whole.mean().unwrap(), whole.deviation().unwrap());
    assert!((mean - 0.0037919462744933886).abs() < 1e-15, "{mean:e}");
    assert!((deviation - 0.7107439797448485).abs() < 1e-14, "{deviation:e}");
    let extremes = (whole.min().unwrap(), whole.max().unwrap());
    assert_eq!(extremes, (f64::from(11).sin(), f64::from(33).sin()));
    for size in [1, 7, 32, 100] {
        let parts = values.chunks(size).map(Moments::of).fold(Moments::default(), Moments::merge);
        assert_eq!((parts.count(), parts.min(), parts.max()), (100, whole.min(), whole.max()));
        assert!((parts.mean().unwrap() - mean).abs() < 1e-15);
        assert!((parts.deviation().unwrap() - deviation).abs() < 1e-14);
    }
    // Times of runs that do not settle are not among them.
    let one = Moments::of(&[f64::INFINITY, 2.0]);
    assert_eq!((one.count(), one.mean(), one.deviation()), (1, Some(2.0), None));
    let none = Moments::of(&[f64::INFINITY]);
    assert_eq!((none.count(), none.mean(), none.min(), none.max()), (0, None, None, None));
}

#[test]
fn percentiles_are_scores_of_runs() {
    let of = |values: &[f64], percent| percentile(&mut values.to_vec(), percent);
    let values = [4.0, 1.0, 3.0, f64::INFINITY, 2.0];
    assert_eq!([5, 50, 95].map(|percent| of(&values, percent)), [1.0, 3.0, f64::INFINITY].map(Some));
    assert_eq!([0, 100].map(|percent| of(&values, percent)), [1.0, f64::INFINITY].map(Some));
    assert_eq!(of(&[1.0, 2.0], 50), Some(1.0));
    assert_eq!((of(&[], 50), of(&values, 101)), (None, None));
    let values: Vec<f64> = (1..=140).map(f64::from).collect();
    assert_eq!([5, 50, 95].map(|percent| of(&values, percent)), [7.0, 70.0, 133.0].map(Some));
}

fn both(values: &[f64]) -> [f64; 3] {
    let [kept, counted] = [true, false].map(|keeps_values| {
        let mut percentiles = Percentiles::new(keeps_values);
        for _ in 0..Percentiles::passes(keeps_values) {
            for part in values.chunks(7) {
                percentiles.add(part);
            }
            percentiles.end_pass();
        }
        percentiles.finish()
    });
    assert_eq!(kept.map(f64::to_bits), counted.map(f64::to_bits), "{kept:?} {counted:?}");
    kept
}

/// By numpy: percentile(values, q, method="inverted_cdf").
#[test]
fn percentiles_are_those_of_numpy() {
    assert_eq!(both(&[3.0, 1.0, 2.0, 5.0, 4.0, 9.0, 7.0, 8.0, 6.0, 10.0]), [5.0, 1.0, 10.0]);
    let values: Vec<f64> = (0..41).rev().map(f64::from).collect();
    assert_eq!(both(&values), [20.0, 2.0, 38.0]);
    assert_eq!(both(&[f64::INFINITY, 1.0, f64::INFINITY])[0], f64::INFINITY);
    assert_eq!(both(&[7.0]), [7.0; 3]);
    assert!(both(&[]).iter().all(|x| x.is_nan()));
}

#[test]
fn counting_finds_each_bit() {
    let values: Vec<f64> = (0..5000_i32).map(|k| (f64::from(k * k % 4999) - 2500.0).powi(3).sinh() * 1e-9).collect();
    both(&values);
    both(&values.iter().map(|x| x * 1e-300).collect::<Vec<_>>());
    both(&(0..999).map(|k| 1.0 + f64::from(k % 10) * f64::EPSILON).collect::<Vec<_>>());
    both(&[-0.0, 0.0, 0.0, -0.0, 5e-324, -5e-324, f64::MAX, f64::MIN]);
}

#[test]
fn the_front_has_what_nothing_dominates() {
    assert_eq!(pareto_front(&[(1.0, 5.0), (2.0, 2.0), (3.0, 3.0), (0.5, f64::INFINITY), (2.0, 1.0)]), [0, 4]);
    assert_eq!(pareto_front(&[(2.0, 0.5), (1.0, 1.0), (3.0, 0.7), (1.0, 2.0), (4.0, 0.1)]), [0, 1, 4]);
    // Equal points do not dominate each other.
    assert_eq!(pareto_front(&[(1.0, 1.0), (f64::NAN, 0.0), (1.0, 1.0)]), [0, 2]);
    assert_eq!(pareto_front(&[]), [0; 0]);
}
