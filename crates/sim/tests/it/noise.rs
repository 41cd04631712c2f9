//! The moments of the noise, its seed, and the independence of all that a run draws.

use luenberger_plants::LinearPlant;
use luenberger_sim::{Disturbances, MeasurementLoss, Noise, Purpose, Scenario, Sensor};
use nalgebra::{DMatrix, dmatrix};

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
fn what_was_given_is_kept() {
    let (gaussian, uniform) = (Noise::gaussian(&[0.1, 0.2], 0.5, 7), Noise::uniform(&[0.3], 0.25, 9));
    assert_eq!((gaussian.amplitude(), gaussian.period()), (&[0.1, 0.2][..], 0.5));
    assert_eq!((uniform.amplitude(), uniform.period()), (&[0.3][..], 0.25));
    assert!(gaussian.is_gaussian() && !uniform.is_gaussian());
    // The variance of a uniform number within +-a is a^2/3.
    assert_eq!(Noise::gaussian(&[3.0, 0.5], 0.5, 7).variances(), [9.0, 0.25]);
    assert_eq!(Noise::uniform(&[3.0, 6.0], 0.5, 7).variances(), [3.0, 12.0]);
}

#[test]
fn the_seed_decides() {
    let [a, b] = [1, 2].map(|seed| Noise::uniform(&[1.0], 0.1, seed));
    let sample = |noise: &Noise, k| noise.sample(Purpose::MeasurementNoise, k);
    assert_ne!(sample(&a, 0), sample(&b, 0));
    assert_ne!(sample(&a, 0), sample(&a, 1));
}

/// What a run of `x+ = w` with the outputs x, of which the second has a sensor of its own, draws at 20 000 instants:
/// each noise in units of its standard deviation, each event as 1 or -1 with mean 0, by name. All seeds are the same.
fn drawn(seed: u64, member: u64) -> Vec<(String, Vec<f64>)> {
    const COUNT: usize = 20_000;
    const SIZE: f64 = 1e3;
    let run = |dropout: f64, outlier: f64| {
        let channel = MeasurementLoss { dropout, outlier, outlier_size: vec![SIZE; 2], period: 1.0, seed };
        let disturbances = Disturbances {
            process_noise: Some(Noise::gaussian(&[1.0], 1.0, seed)),
            channel: Some(channel),
            ..Disturbances::default()
        };
        let plant = LinearPlant::new(dmatrix![0.0], DMatrix::zeros(1, 0), dmatrix![1.0; 1.0]).unwrap();
        Scenario::new(plant)
            .discrete_time(1.0)
            .noise(Noise::gaussian(&[1.0, 1.0], 1.0, seed))
            .sensor(Sensor::new(1, 1.0).gaussian(1.0, seed))
            .disturbances(disturbances)
            .member(member)
            .until(COUNT as f64, COUNT + 1)
            .run()
            .unwrap()
    };
    let (lossy, wild) = (run(0.5, 0.0), run(0.0, 0.5));
    let instants = || 0..COUNT;
    let mut found: Vec<(String, Vec<f64>)> =
        vec![("process".to_owned(), instants().map(|k| wild.x[(k + 1, 0)]).collect())];
    for output in 0..2 {
        let off = |k: usize| wild.measured[(k, output)] - wild.y[(k, output)];
        let outlier = |k: usize| (off(k) / SIZE).round();
        found.push((format!("noise of {output}"), instants().map(|k| off(k) - SIZE * outlier(k)).collect()));
        found.push((format!("outlier of {output}"), instants().map(|k| 2.0 * outlier(k).abs() - 1.0).collect()));
        // With mean square 1: every second one is 0.
        found.push((format!("sign of {output}"), instants().map(|k| 2f64.sqrt() * outlier(k)).collect()));
        let arrives = |k: usize| if lossy.is_measured(output, k as f64) { 1.0 } else { -1.0 };
        found.push((format!("arrival at {output}"), instants().map(arrives).collect()));
    }
    // A dropout of the largest noises correlates with these. The mean of |v| is sqrt(2/pi).
    let noises = found.iter().filter(|(name, _)| name.starts_with("noise") || name == "process");
    let sizes: Vec<_> = noises
        .map(|(name, values)| {
            let mean = 2.0 / std::f64::consts::TAU.sqrt();
            let size = |v: &f64| (v.abs() - mean) / (1.0 - mean * mean).sqrt();
            (format!("size of the {name}"), values.iter().map(size).collect::<Vec<f64>>())
        })
        .collect();
    found.extend(sizes);
    found.into_iter().map(|(name, values)| (format!("{name}, seed {seed}, member {member}"), values)).collect()
}

/// No two quantities of one run are correlated, nor those of two members, nor those of a member and of another seed.
#[test]
fn all_that_is_drawn_is_independent() {
    let series: Vec<_> = [(0, 0), (0, 1), (1, 0)].into_iter().flat_map(|(seed, member)| drawn(seed, member)).collect();
    let mean_product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
    for (i, (one, a)) in series.iter().enumerate() {
        let bound = 4.0 / (a.len() as f64).sqrt();
        let square = mean_product(a, a);
        // The variance of a square is at most 2.9, that of a size.
        assert!((square - 1.0).abs() < 2.9f64.sqrt() * bound, "{one}: {square}");
        for (other, b) in &series[..i] {
            let correlation = mean_product(a, b);
            assert!(correlation.abs() < bound, "{one} and {other}: {correlation}");
        }
    }
}
