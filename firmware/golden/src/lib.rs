//! Golden programs: observers with sizes known at compile time, their inputs, and a digest of every step.
//!
//! The host and the boards run this code; `cargo xtask firmware` compares what they print.
//!
//! | file | subject |
//! |---|---|
//! | `list` | the observers by name |
//! | `linear` | observers of linear plants |
//! | `nonlinear` | observers of a pendulum |
//! | `stepped` | observers in continuous time, by the classical Runge-Kutta method |

#![no_std]

pub mod linear;
mod list;
pub mod nonlinear;
pub mod stepped;

use luenberger_observers::SampledObserver;
use luenberger_plants::Column;
use nalgebra::RealField;

/// Steps of each observer.
pub const STEPS: usize = 1000;

/// A number of the target.
pub trait Number: RealField + Copy {
    /// The nearest number.
    fn of(x: f64) -> Self;

    /// The number itself, which binary64 holds.
    fn value(self) -> f64;

    /// The digest that `digest` becomes with the bits of this number.
    fn digest(self, digest: u32) -> u32;
}

impl Number for f32 {
    fn of(x: f64) -> Self {
        x as f32
    }

    fn value(self) -> f64 {
        f64::from(self)
    }

    fn digest(self, digest: u32) -> u32 {
        fnv(digest, &self.to_le_bytes())
    }
}

impl Number for f64 {
    fn of(x: f64) -> Self {
        x
    }

    fn value(self) -> f64 {
        self
    }

    fn digest(self, digest: u32) -> u32 {
        fnv(digest, &self.to_le_bytes())
    }
}

/// FNV-1a of 32 bits, of Fowler, Noll and Vo; it starts from [`EMPTY`].
pub fn fnv(digest: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(digest, |digest, byte| (digest ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}

/// The digest of nothing.
pub const EMPTY: u32 = 0x811c_9dc5;

/// A run: the observer's state, and the numbers that enter it.
pub struct Run<T, O: SampledObserver<T>> {
    observer: O,
    state: O::State,
    noise: Noise,
    amplitude: f64,
    count: usize,
    digests: core::marker::PhantomData<T>,
}

/// The inputs and outputs of a step.
pub struct Sample<U, Y> {
    /// Inputs.
    pub u: U,
    /// Outputs.
    pub y: Y,
}

impl<T: Number, O: SampledObserver<T>> Run<T, O>
where
    O::Input: Filled<T>,
    O::Output: Filled<T>,
    O::Estimate: Filled<T>,
{
    /// The observer at its first estimate, 0.1 i - 0.3 for the state i counted from 0, and inputs and outputs of
    /// magnitude up to `amplitude`.
    pub fn new(observer: O, amplitude: f64) -> Self {
        let mut entry = 0.0;
        let estimate = O::Estimate::filled(|| {
            let x = 0.1 * entry - 0.3;
            entry += 1.0;
            T::of(x)
        });
        let zero = (O::Input::filled(T::zero), O::Output::filled(T::zero));
        let state = observer.initial(T::zero(), &estimate, &zero.0, &zero.1);
        let noise = Noise(0x9e37_79b9_7f4a_7c15);
        Self { observer, state, noise, amplitude, count: 0, digests: core::marker::PhantomData }
    }

    /// The next inputs and outputs: no motion of a plant, numbers without pattern and now and then large ones, as in
    /// the golden vectors of `luenberger-export`.
    pub fn sample(&mut self) -> Sample<O::Input, O::Output> {
        let is_large = self.amplitude > 1.0 && self.count % 16 == 7;
        let scale = if is_large {
            1e3
        } else if self.amplitude > 1.0 {
            1.0
        } else {
            self.amplitude
        };
        self.count += 1;
        let noise = &mut self.noise;
        let u = O::Input::filled(|| T::of(scale * noise.number()));
        let y = O::Output::filled(|| T::of(scale * noise.number()));
        Sample { u, y }
    }

    /// The parts that a step needs.
    pub fn parts(&mut self) -> (&O, &mut O::State) {
        (&self.observer, &mut self.state)
    }

    /// The digest of the state.
    pub fn digest(&self) -> u32 {
        self.state.as_slice().iter().fold(EMPTY, |digest, x| x.digest(digest))
    }

    /// Whether every entry of the state is finite.
    pub fn is_finite(&self) -> bool {
        self.state.as_slice().iter().all(|x| x.is_finite())
    }

    /// The state.
    pub fn state(&self) -> &O::State {
        &self.state
    }
}

/// A column of fixed length made entry by entry.
pub trait Filled<T>: Column<T> {
    /// The column whose entries are the results of `next`, from the first to the last.
    fn filled(next: impl FnMut() -> T) -> Self;
}

impl<T: Number, const N: usize> Filled<T> for nalgebra::SVector<T, N> {
    fn filled(mut next: impl FnMut() -> T) -> Self {
        Self::from_fn(|_, _| next())
    }
}

/// Numbers in [-2, 2) without pattern: xorshift64*, of Marsaglia and Vigna.
pub struct Noise(pub u64);

impl Noise {
    /// The next number.
    pub fn number(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        bits as f64 * (1.0 / (1u64 << 51) as f64) - 2.0
    }
}
