//! The golden programs on a board: prints a digest of every step, and what the steps cost.
//!
//! The panic handler calls a function that does not exist: this program links only if nothing can panic.

#![no_std]
#![no_main]

#[cfg_attr(target_arch = "arm", path = "arm.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
mod machine;

use core::hint::black_box;

use luenberger_golden::{Filled, Number, Run, STEPS};
use luenberger_observers::{ObserverError, SampledObserver};

unsafe extern "C" {
    fn something_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it does not exist, so that no program calls it.
    unsafe { something_can_panic() }
}

/// A line of hexadecimal digits.
fn line(word: u32) {
    let mut text = *b"........\n\0";
    for (i, letter) in text.iter_mut().take(8).enumerate() {
        let digit = (word >> (28 - 4 * i)) as u8 & 15;
        *letter = if digit < 10 { b'0' + digit } else { b'a' - 10 + digit };
    }
    machine::write(&text);
}

type Step<T, O> = fn(
    &O,
    &mut <O as SampledObserver<T>>::State,
    &<O as SampledObserver<T>>::Input,
    &<O as SampledObserver<T>>::Output,
);

/// A step that does nothing: what calling and counting cost.
fn idle<T, O: SampledObserver<T>>(_: &O, _: &mut O::State, _: &O::Input, _: &O::Output) {}

/// Steps of which the stack is measured.
const PAINTED: usize = 40;

#[inline(never)]
fn run<T: Number, O: SampledObserver<T>>(
    name: &[u8],
    observer: Result<O, ObserverError>,
    amplitude: f64,
    step: Step<T, O>,
) where
    O::Input: Filled<T>,
    O::Output: Filled<T>,
    O::Estimate: Filled<T>,
{
    machine::write(name);
    let Ok(observer) = observer else { machine::exit(false) };
    let mut run = Run::<T, O>::new(observer, amplitude);
    let (mut most, mut total, mut stack) = (0, 0, 0);
    // Called through pointers that the optimiser does not see through.
    let (step, idle): (Step<T, O>, Step<T, O>) = black_box((step, idle));
    let mut overhead = u32::MAX;
    for k in 0..STEPS {
        let sample = run.sample();
        let (observer, state) = run.parts();
        let before = machine::count();
        idle(observer, state, &sample.u, &sample.y);
        overhead = overhead.min(machine::instructions(before, machine::count()));
        if k < PAINTED {
            machine::paint();
        }
        let before = machine::count();
        step(observer, state, &sample.u, &sample.y);
        let instructions = machine::instructions(before, machine::count());
        if k < PAINTED {
            stack = machine::painted().max(stack);
        }
        most = instructions.max(most);
        total += instructions;
        line(run.digest());
    }
    machine::write(b"overhead, most, total, stack\n\0");
    for number in [overhead, most, total, stack] {
        line(number);
    }
}

macro_rules! programs {
    ($($name:ident, $number:ty, $observer:ty, $new:expr, $amplitude:expr, $export:ident;)*) => {
        #[unsafe(no_mangle)]
        extern "C" fn main() -> ! {
            machine::start();
            $($name::main();)*
            machine::exit(true)
        }

        $(mod $name {
            use super::*;

            /// The step by itself, so that the table of symbols has its size.
            #[unsafe(export_name = concat!("step_", stringify!($name)))]
            #[inline(never)]
            fn step(
                observer: &$observer,
                state: &mut <$observer as SampledObserver<$number>>::State,
                u: &<$observer as SampledObserver<$number>>::Input,
                y: &<$observer as SampledObserver<$number>>::Output,
            ) {
                observer.step(<$number as Number>::of(0.0), state, u, y);
            }

            #[inline(never)]
            pub(super) fn main() {
                run(concat!("observer ", stringify!($name), "\n\0").as_bytes(), $new, $amplitude, step);
            }
        })*
    };
}

luenberger_golden::observers!(programs);
