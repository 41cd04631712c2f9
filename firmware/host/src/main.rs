//! The golden programs on the host: prints a digest of every step of every observer, those in fixed point last. The
//! exported ones are written as C to the folder that is given, each with a header for `main.c`.

mod export;
mod fixed_point;

use luenberger_golden::{Number, Run, STEPS};
use luenberger_observers::SampledObserver;
use std::path::PathBuf;

macro_rules! programs {
    ($($name:ident, $number:ty, $observer:ty, $new:expr, $amplitude:expr, $export:ident;)*) => {
        fn main() {
            let folder = PathBuf::from(std::env::args_os().nth(1).expect("a folder for the exports"));
            $({
                let observer: $observer = $new.expect(stringify!($name));
                exported!($export, &observer, &folder, stringify!($name), stringify!($number), $amplitude);
                let mut run = Run::<$number, $observer>::new(observer, $amplitude);
                println!("observer {}", stringify!($name));
                for k in 0..STEPS {
                    let sample = run.sample();
                    let (observer, state) = run.parts();
                    observer.step(<$number as Number>::of(0.0), state, &sample.u, &sample.y);
                    assert!(run.is_finite(), "{}: step {k} is not finite", stringify!($name));
                    println!("{:08x}", run.digest());
                }
            })*
            fixed_point::programs(&folder);
        }
    };
}

macro_rules! exported {
    (exported, $observer:expr, $folder:expr, $name:expr, $number:expr, $amplitude:expr) => {
        export::write($observer, $folder, $name, $number, $amplitude);
    };
    (rust, $observer:expr, $folder:expr, $name:expr, $number:expr, $amplitude:expr) => {};
}

luenberger_golden::observers!(programs);
