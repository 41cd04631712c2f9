//! The numbers behind the cost J: directions of the first errors, and values of the noise.

use luenberger_design::internals::{Generator, directions};

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

#[test]
fn the_noise_has_variance_one() {
    let mut generator = Generator::new(3);
    for uniform in [false, true] {
        let draw = |g: &mut Generator| if uniform { g.uniform() } else { g.normal() };
        let values: Vec<f64> = (0..40_000).map(|_| draw(&mut generator)).collect();
        let variance = values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64;
        // Three standard deviations of the mean of squares, sqrt(2/40000) for the normal ones.
        assert!((variance - 1.0).abs() < 0.022, "{variance}");
    }
}
