//! Linear observers in fixed point: the steps of the observer in integers, and the exports.

use luenberger_export::{FixedPointFormat, FixedPointFormats, Scalar};
use luenberger_golden::linear::{self, Linear};
use luenberger_golden::{EMPTY, Noise, STEPS, fnv};
use nalgebra::DVector;
use std::path::Path;

use crate::export::{self, Exported};

/// Prints the digests of all, and writes the exports.
pub fn programs(folder: &Path) {
    let q = |integer_bits, fraction_bits| FixedPointFormat::new(integer_bits, fraction_bits).expect("a format");
    let two: Linear<f64, 2, 1, 1> = linear::linear().expect("an observer");
    let four: Linear<f64, 4, 1, 2> = linear::linear().expect("an observer");
    let eight: Linear<f64, 8, 2, 3> = linear::linear().expect("an observer");
    program(folder, "fixed_2_q8_8", &two, q(8, 8).into());
    program(folder, "fixed_2_q16_16", &two, q(16, 16).into());
    program(folder, "fixed_4_q12_20", &four, FixedPointFormats { gains: q(4, 28), signals: q(12, 20) });
    program(folder, "fixed_8_q16_16", &eight, q(16, 16).into());
}

fn program(folder: &Path, name: &str, observer: &impl Exported, formats: FixedPointFormats) {
    let design = export::export(observer, name, Scalar::Binary64);
    let export = design.fixed_point(formats).expect("an export");
    // Small numbers, and now and then some of the whole range, of which results saturate.
    let small = (1_u64 << formats.signals.fraction_bits()) as f64;
    let large = 0.5 * f64::from(formats.signals.largest());
    export::files(folder, name, export.c());
    export::case(
        folder,
        name,
        &format!("#define INTEGERS\n#define NUMBER int32_t\n#define SMALL {small:?}\n#define LARGE {large:?}\n"),
    );
    let observer = export.observer();
    let size = observer.dimensions();
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    let mut state = observer.start(export.initial().clone());
    println!("observer {name}");
    for k in 0..STEPS {
        let scale = if k % 16 == 7 { large } else { small };
        let mut column = |length| DVector::from_fn(length, |_, _| (scale * noise.number()) as i32);
        let (u, y) = (column(size.inputs), column(size.outputs));
        observer.step(&mut state, &u, &y);
        let digest = state.xhat.iter().fold(EMPTY, |digest, x| fnv(digest, &x.to_le_bytes()));
        println!("{digest:08x}");
    }
}
