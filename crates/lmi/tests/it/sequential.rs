//! Products, Cholesky factors and eigenvalues of a single thread, for a matrix with closed forms.

use faer::Mat;
use luenberger_lmi::internals::{Cholesky, eigenvalues, product};

/// The second difference of order n has the eigenvalues 2 - 2 cos(k pi / (n + 1)), the determinant n + 1, and the
/// inverse min(i, j) (n + 1 - max(i, j)) / (n + 1).
#[test]
fn the_second_difference_is_factored_inverted_and_has_its_eigenvalues() {
    for n in [1, 2, 7, 40, 150] {
        let m = Mat::from_fn(n, n, |i, j| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)]);
        let cholesky = Cholesky::of(&m).unwrap();
        // Each of these loses the condition of the matrix, 4 (n + 1)^2 / pi^2, times its rounding errors.
        let bound = f64::EPSILON * ((n + 1) * (n + 1)) as f64 * n as f64;
        let back = product(cholesky.l(), cholesky.l().transpose());
        let inverse = cholesky.inverse();
        let mut column = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0)));
        cholesky.solve_in_place(&mut column);
        for i in 0..n {
            for j in 0..n {
                assert!((back[(i, j)] - m[(i, j)]).abs() <= 4.0 * n as f64 * f64::EPSILON);
                let exact = ((i.min(j) + 1) * (n - i.max(j))) as f64 / (n + 1) as f64;
                assert!((inverse[(i, j)] - exact).abs() <= bound * n as f64, "{n}: {i} {j}");
                assert_eq!(inverse[(i, j)].to_bits(), inverse[(j, i)].to_bits());
            }
            assert!((column[(i, 0)] - (n - i) as f64 / (n + 1) as f64).abs() <= bound);
        }
        for (k, value) in eigenvalues(&m).unwrap().into_iter().enumerate() {
            let exact = 2.0 - 2.0 * ((k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            assert!((value - exact).abs() <= 10.0 * n as f64 * f64::EPSILON, "{n}: {value} {exact}");
        }
        let mut indefinite = m;
        indefinite[(n - 1, n - 1)] = -1.0;
        assert!(Cholesky::of(&indefinite).is_none());
    }
}
