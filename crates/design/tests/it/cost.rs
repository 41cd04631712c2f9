//! The numbers behind the cost J: directions of the first errors.

use luenberger_design::internals::directions;

#[test]
fn the_directions_have_the_second_moments_of_the_sphere() {
    for n in 1..=5 {
        let found = directions(n);
        for i in 0..n {
            for j in 0..n {
                let moment: f64 = found.iter().map(|e| e[i] * e[j]).sum::<f64>() / found.len() as f64;
                let expected = if i == j { 1.0 / n as f64 } else { 0.0 };
                assert!((moment - expected).abs() < 1e-14, "{n} {i} {j}: {moment}");
            }
        }
    }
}
