//! Householder reductions to Hessenberg form.

use luenberger_linalg::internals::{Blocked, Reduction, dispatch, reflector};
use nalgebra::DMatrix;

#[test]
fn both_reductions_are_orthogonal_similarities() {
    for (n, blocked) in [(7, false), (7, true), (33, false), (40, true), (300, true)] {
        let a = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.5);
        let (mut h, mut q) = (a.clone(), DMatrix::identity(n, n));
        let mut work = vec![0.0; 3 * n];
        let (h_data, q_data) = (h.as_mut_slice(), q.as_mut_slice());
        if blocked {
            Blocked::default().reduce(h_data, n, q_data);
        } else {
            dispatch(Reduction { h: h_data, n, order: n, q: q_data, fresh: true, work: &mut work });
        }
        let bound = 10.0 * n as f64 * f64::EPSILON;
        assert!((&q * &h * q.transpose() - &a).norm() <= bound * a.norm(), "{n}");
        assert!((q.transpose() * &q - DMatrix::identity(n, n)).norm() <= bound, "{n}");
        for j in 0..n {
            for i in j + 2..n {
                assert_eq!(h[(i, j)], 0.0);
            }
        }
    }
}

#[test]
fn a_part_can_be_reduced() {
    // The leading 5 x 5 block of a 7 x 7 matrix whose last two rows it does not touch.
    let (n, order) = (7, 5);
    let a = DMatrix::from_fn(n, n, |i, j| if i < order { ((i * 7 + j * 3) % 11) as f64 - 4.5 } else { 0.0 });
    let (mut h, mut q) = (a.clone(), DMatrix::identity(n, n));
    let (h_data, q_data) = (h.as_mut_slice(), q.as_mut_slice());
    dispatch(Reduction { h: h_data, n, order, q: q_data, fresh: false, work: &mut vec![0.0; 3 * n] });
    assert!((&q * &h * q.transpose() - &a).norm() <= 10.0 * n as f64 * f64::EPSILON * a.norm());
    assert_eq!(h[(4, 2)], 0.0);
    assert_eq!(q[(6, 6)], 1.0);
}

#[test]
fn a_reflector_survives_the_ends_of_the_range() {
    for scale in [1e-300, 1.0, 1e300] {
        let x = [3.0 * scale, 0.0, -4.0 * scale];
        let mut tail = [x[1], x[2]];
        let (beta, tau) = reflector(x[0], &mut tail);
        assert!((beta.abs() / scale - 5.0).abs() <= 1e-14);
        let v = [1.0, tail[0], tail[1]];
        let s = tau * (0..3).map(|i| v[i] * (x[i] / scale)).sum::<f64>();
        assert!((x[2] / scale - s * v[2]).abs() <= 1e-14);
    }
}
