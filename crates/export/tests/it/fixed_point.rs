//! Emitted C in fixed point, compiled and compared with the Rust observer bit by bit. Without a C compiler these tests
//! say so and pass.

use luenberger_export::{Export, FixedPointFormat, FixedPointFormats, Names, Scalar};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::process::Command;

use crate::compiled::{SANITISERS, can_sanitise, compilers, folder, has_haswell, is_complete, program};

fn export(seed: u64, sizes: (usize, usize, usize), fed: bool) -> Export {
    let program = program(seed, sizes, false, fed);
    let size = program.dimensions();
    let initial: Vec<f64> = (0..size.state).map(|i| 0.1 * i as f64 - 0.3).collect();
    let names = Names::numbered(size.state, size.inputs, size.outputs);
    Export::new("plant", program, Scalar::Binary64, &initial, names).unwrap()
}

fn q(integer_bits: u32, fraction_bits: u32) -> FixedPointFormat {
    FixedPointFormat::new(integer_bits, fraction_bits).unwrap()
}

/// Compiles the files with these flags and runs the golden test.
#[track_caller]
fn agrees(export: &Export, formats: FixedPointFormats, folder: &std::path::Path, compiler: &str, flags: &[&str]) {
    for file in export.fixed_point(formats).unwrap().c() {
        std::fs::write(folder.join(file.name), file.text).unwrap();
    }
    let built = Command::new(compiler)
        .current_dir(folder)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"])
        .args(flags)
        .args(["plant.c", "test_plant.c", "-o", "test"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(folder.join("test")).output().unwrap();
    let text = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{compiler} {flags:?}: {text}{}", String::from_utf8_lossy(&ran.stderr));
    assert!(text.contains("64 of 64 steps agree to the last bit"), "{text}");
}

/// A signal beyond the range of the format is its end, on either side.
#[test]
fn a_replay_saturates_signals_at_the_ends_of_their_range() {
    let export = export(3, (2, 1, 1), false);
    let export = export.fixed_point(q(4, 12).into()).unwrap();
    let after = |u: f64, y: f64| export.replay(&[(vec![u], vec![y])]);
    // Q4.12 reaches from -8 to 8 - 2^-12.
    let (low, high) = (-8.0, 8.0 - 2f64.powi(-12));
    assert_eq!((after(0.0, -1e9), after(0.0, 1e9)), (after(0.0, low), after(0.0, high)));
    assert_eq!((after(-1e9, 0.0), after(1e9, 0.0)), (after(low, 0.0), after(high, 0.0)));
    assert_ne!(after(0.0, low), after(0.0, high));
}

#[test]
fn optimised_and_sanitised_builds_give_the_same_bits() {
    let folder = folder("fixed-flags");
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    for compiler in compilers {
        let sanitised = can_sanitise(compiler);
        for (sizes, fed, formats) in [
            ((2, 1, 1), false, q(16, 16).into()),
            ((3, 2, 2), true, FixedPointFormats { gains: q(3, 29), signals: q(8, 8) }),
            ((2, 0, 1), false, q(4, 12).into()),
            // Integers for signals, and the widest range: every end of int32_t.
            ((1, 1, 1), true, FixedPointFormats { gains: q(3, 29), signals: q(32, 0) }),
            ((1, 1, 1), false, FixedPointFormats { gains: q(8, 0), signals: q(1, 31) }),
        ] {
            let export = export(3, sizes, fed);
            for flags in [&["-O0"][..], &["-Os"], &["-O2"], &["-O3", "-march=haswell"]] {
                if has_haswell() || !flags.contains(&"-march=haswell") {
                    agrees(&export, formats, &folder, compiler, flags);
                }
            }
            if sanitised {
                agrees(&export, formats, &folder, compiler, &SANITISERS);
            }
        }
    }
}

#[test]
fn random_observers_in_random_formats_agree() {
    let compilers = compilers();
    let Some(compiler) = compilers.first() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = folder("fixed-random");
    let cases =
        (any::<u64>(), (1..=6_usize, 0..=3_usize, 1..=3_usize), any::<bool>(), 2..=16_u32, 0..=16_u32, 4..=29_u32);
    let mut runner = TestRunner::new(Config {
        cases: if is_complete() { 40 } else { 10 },
        failure_persistence: None,
        ..Config::default()
    });
    runner
        .run(&cases, |(seed, sizes, fed, integer, fraction, part)| {
            let formats = FixedPointFormats { gains: q(3, part), signals: q(integer, fraction) };
            agrees(&export(seed, sizes, fed), formats, &folder, compiler, &["-O1"]);
            Ok(())
        })
        .unwrap();
}

#[test]
fn the_golden_vectors_saturate_and_the_header_says_what_that_means() {
    let export = export(3, (2, 1, 1), false);
    let files = export.fixed_point(q(4, 12).into()).unwrap().c();
    let text = |name: &str| files.iter().find(|file| file.name == name).unwrap().text.clone();
    let header = text("plant.h");
    for said in [
        "int32_t, Q4.12",
        "x 2^12, rounded",
        "an error of at most 2^-13",
        "from -2^3",
        "uint32_t saturations;",
        "#define PLANT_FRACTION_BITS 12",
    ] {
        assert!(header.replace("\n * ", " ").contains(said), "{said}: {header}");
    }
    let test = text("test_plant.c");
    let counts = test.split("saturations[64] = {").nth(1).unwrap().split('}').next().unwrap();
    assert!(counts.trim_start().starts_with("0u,") && !counts.trim_end().ends_with(" 0u"), "{counts}");
}

/// An entry that is expected to be twice as large is named with both values, in both kinds of numbers.
#[test]
fn the_golden_test_names_the_entry_that_differs() {
    let Some(compiler) = compilers().first().copied() else {
        eprintln!("no C compiler: skipped");
        return;
    };
    let export = export(3, (2, 1, 1), false);
    let kinds = [("double", export.c().unwrap()), ("int32_t", export.fixed_point(q(8, 16).into()).unwrap().c())];
    for (number, files) in kinds {
        let folder = folder(&format!("differs-{number}"));
        let mut first = String::new();
        for mut file in files {
            if file.name == "test_plant.c" {
                let (before, table) = file.text.split_once("expected[64][2] = {").unwrap();
                let start = table.find(|c: char| c.is_ascii_digit() || c == '-').unwrap();
                first = table[start..].split([',', ' ']).next().unwrap().to_owned();
                let rest = &table[start + first.len()..];
                file.text = format!("{before}expected[64][2] = {{{}2 * {first}{rest}", &table[..start]);
            }
            std::fs::write(folder.join(file.name), file.text).unwrap();
        }
        let build = Command::new(compiler)
            .current_dir(&folder)
            .args(["-std=c99", "plant.c", "test_plant.c", "-o", "test", "-lm"])
            .status();
        assert!(build.unwrap().success(), "{number}");
        let ran = Command::new(folder.join("test")).output().unwrap();
        let text = String::from_utf8_lossy(&ran.stdout);
        assert_eq!(ran.status.code(), Some(1), "{number}: {text}");
        assert!(text.starts_with("step 0, xhat[0]: "), "{number}: {text}");
        if let Ok(first) = first.parse::<i32>() {
            assert!(text.contains(&format!("xhat[0]: {first}, expected {}\n", 2 * first)), "{text}");
        }
        assert!(text.contains("63 of 64 steps agree to the last bit\n"), "{number}: {text}");
        assert!(text.ends_with("plant: largest relative difference 0.5\n"), "{number}: {text}");
    }
}

#[test]
fn what_has_no_fixed_point_is_an_error() {
    let cubic = program(3, (2, 1, 1), true, false);
    let export = Export::new("plant", cubic, Scalar::Binary64, &[0.0; 2], Names::numbered(2, 1, 1)).unwrap();
    let error = export.fixed_point(q(16, 16).into()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "fixed point is for linear observers and Kalman filters with a constant gain, not for the sampled cubic observer"
    );
    let linear = program(3, (2, 1, 1), false, false);
    let export = Export::new("plant", linear, Scalar::Binary64, &[0.0, 40.0], Names::numbered(2, 1, 1)).unwrap();
    let error = export.fixed_point(q(4, 12).into()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "in Q4.12: the first estimate(2, 1) = 40 is beyond the range of Q4.12: it needs 7 bits before the point"
    );
    // C and D have rows whose magnitudes, with the 1 of y, add up to more than 4.
    let error = self::export(3, (3, 2, 2), true)
        .fixed_point(FixedPointFormats { gains: q(2, 30), signals: q(8, 8) })
        .unwrap_err();
    assert!(error.to_string().starts_with("in Q2.30: row 1 of y - C xhat - D u could overflow 64 bits"), "{error}");
}
