//! Streams: their numbers are those of the cipher, and no two of them have anything in common.

use luenberger_random::{Purpose, Stream};

/// Draws of a stream, the first of each k.
const DRAWS: u64 = 100_000;

/// The numbers of a stream in units of their standard deviation, the root of 1/12.
fn numbers(stream: Stream) -> Vec<f64> {
    (0..DRAWS).map(|k| 12f64.sqrt() * (stream.draws(k).uniform() - 0.5)).collect()
}

/// Asserts that the correlation of any two is within four standard errors, each of which is `1 / sqrt(n)`.
fn assert_uncorrelated(streams: &[(String, Stream)]) {
    let drawn: Vec<Vec<f64>> = streams.iter().map(|(_, stream)| numbers(*stream)).collect();
    let bound = 4.0 / (DRAWS as f64).sqrt();
    for i in 0..streams.len() {
        for j in 0..i {
            let correlation = drawn[i].iter().zip(&drawn[j]).map(|(a, b)| a * b).sum::<f64>() / DRAWS as f64;
            assert!(correlation.abs() < bound, "{} and {}: {correlation}", streams[i].0, streams[j].0);
        }
    }
}

/// The first two words of blocks of `ChaCha8` by an implementation in Python, written from the definition of the cipher
/// and tested with the published blocks of `ChaCha20` and `ChaCha8` for the key and the nonce 0.
#[test]
fn the_numbers_are_those_of_the_cipher() {
    let first = |stream: Stream, k| {
        let mut draws = stream.draws(k);
        [draws.bits(), draws.bits()]
    };
    let all_zero = Stream::new(0, Purpose::MeasurementNoise, 0);
    assert_eq!(first(all_zero, 0), [0x8a50_a844_f7bf_3e6a, 0xebed_6f59_72ce_0ebf]);
    let all_set = Stream::new((1 << 63) + 5, Purpose::Dropout, 2).member(3);
    assert_eq!(first(all_set, 1_000_000_000_000), [0xce06_d48e_c167_7cc2, 0x17b8_0ba3_43cd_7b75]);
}

#[test]
fn purposes_are_independent_with_default_and_with_equal_seeds() {
    for seed in [0, 7] {
        let of = |purpose: &Purpose| (format!("{purpose:?}, seed {seed}"), Stream::new(seed, *purpose, 0));
        assert_uncorrelated(&Purpose::ALL.iter().map(of).collect::<Vec<_>>());
    }
}

/// What sums and other mixtures of the parts of the key would have in common.
#[test]
fn neighbouring_seeds_members_and_indices_are_independent() {
    let mut streams = Vec::new();
    for seed in 0..2 {
        for member in 0..2 {
            for index in 0..2 {
                for purpose in [Purpose::MeasurementNoise, Purpose::SensorNoise] {
                    let name = format!("{purpose:?}, seed {seed}, member {member}, index {index}");
                    streams.push((name, Stream::new(seed, purpose, index).member(member)));
                }
            }
        }
    }
    assert_uncorrelated(&streams);
}

/// Mean, variance and excess of the normal numbers, and those of the uniform ones, each within four standard errors.
#[test]
fn the_moments_are_those_of_the_distributions() {
    let n = DRAWS as f64;
    for purpose in Purpose::ALL {
        let stream = Stream::new(1, *purpose, 0);
        let normal: Vec<f64> = (0..DRAWS).map(|k| stream.draws(k).normal()).collect();
        let moment = |of: &[f64], order: i32| of.iter().map(|x| x.powi(order)).sum::<f64>() / n;
        // The variances of x, x^2 and x^4 are 1, 2 and 96; with x^2 uniform ones have variances 1, 4/5 and 144/25 (of
        // x^4, whose mean is 9/5, and of x^8, whose mean is 9).
        for (numbers, expected) in [
            (normal, [(1, 0.0, 1.0), (2, 1.0, 2.0), (4, 3.0, 96.0)]),
            (numbers(stream), [(1, 0.0, 1.0), (2, 1.0, 0.8), (4, 1.8, 5.76)]),
        ] {
            for (order, mean, variance) in expected {
                let error = moment(&numbers, order) - mean;
                assert!(error.abs() < 4.0 * (variance / n).sqrt(), "{purpose:?}, moment {order}: {error}");
            }
        }
    }
}
