//! The moments of the noise, and its seed.

use luenberger_sim::{Noise, Purpose};

#[test]
fn moments_are_those_of_the_distribution() {
    let count = 20_000;
    for (noise, variance) in [(Noise::uniform(&[3.0, 1.0], 0.1, 1), 3.0), (Noise::gaussian(&[2.0, 1.0], 0.1, 1), 4.0)] {
        let samples: Vec<_> = (0..count).map(|k| noise.sample(Purpose::MeasurementNoise, k)).collect();
        let mean = |f: &dyn Fn(&[f64]) -> f64| samples.iter().map(|s| f(s)).sum::<f64>() / count as f64;
        // Five standard deviations of the means of 20000 values.
        let bound = 5.0 / (count as f64).sqrt();
        assert!(mean(&|s| s[0]).abs() < bound * f64::sqrt(variance));
        assert!((mean(&|s| s[0] * s[0]) / variance - 1.0).abs() < bound * 2f64.sqrt());
        assert!(mean(&|s| s[0] * s[1]).abs() < bound * f64::sqrt(variance));
    }
}

#[test]
fn the_seed_decides() {
    let [a, b] = [1, 2].map(|seed| Noise::uniform(&[1.0], 0.1, seed));
    let sample = |noise: &Noise, k| noise.sample(Purpose::MeasurementNoise, k);
    assert_ne!(sample(&a, 0), sample(&b, 0));
    assert_ne!(sample(&a, 0), sample(&a, 1));
}
