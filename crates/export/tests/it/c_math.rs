//! The elementary functions in C against those of the observers: the crate libm, through the traits of nalgebra, and in
//! binary32 the four of `luenberger_plants::binary32`; and these against binary64.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::process::Command;

use luenberger_export::Scalar;
use luenberger_export::c_math::{self, INCLUDES, call, source};
use luenberger_expression::MathFunction;
use luenberger_plants::binary32;
use luenberger_random::Random;
use nalgebra::RealField;

use crate::compiled::{SANITISERS, can_sanitise, compilers, folder, has_haswell, is_complete};

fn reference<T: Bits>(function: MathFunction, x: T, y: T) -> T {
    T::own(function, x).unwrap_or_else(|| of_libm(function, x, y))
}

fn of_libm<T: RealField + Copy>(function: MathFunction, x: T, y: T) -> T {
    match function {
        MathFunction::Exp => x.exp(),
        MathFunction::Expm1 => x.exp_m1(),
        MathFunction::Log => x.ln(),
        MathFunction::Log1p => x.ln_1p(),
        MathFunction::Log10 => x.log10(),
        MathFunction::Sin => x.sin(),
        MathFunction::Cos => x.cos(),
        MathFunction::Tan => x.tan(),
        MathFunction::Asin => x.asin(),
        MathFunction::Acos => x.acos(),
        MathFunction::Atan => x.atan(),
        MathFunction::Atan2 => x.atan2(y),
        MathFunction::Sinh => x.sinh(),
        MathFunction::Cosh => x.cosh(),
        MathFunction::Tanh => x.tanh(),
        MathFunction::Asinh => x.asinh(),
        MathFunction::Acosh => x.acosh(),
        MathFunction::Atanh => x.atanh(),
        MathFunction::Pow => x.powf(y),
    }
}

/// A format by its bits.
trait Bits: RealField + Copy {
    const SCALAR: Scalar;
    const C: &'static str;
    fn of(bits: u64) -> Self;
    fn bits(self) -> u64;
    /// The nearest number.
    fn near(x: f64) -> Self;
    /// The function at x, where the format has its own in place of libm's.
    fn own(function: MathFunction, x: Self) -> Option<Self>;
}

impl Bits for f64 {
    const SCALAR: Scalar = Scalar::Binary64;
    const C: &'static str = "double";
    fn of(bits: u64) -> Self {
        f64::from_bits(bits)
    }
    fn bits(self) -> u64 {
        self.to_bits()
    }
    fn near(x: f64) -> Self {
        x
    }
    fn own(_: MathFunction, _: Self) -> Option<Self> {
        None
    }
}

impl Bits for f32 {
    const SCALAR: Scalar = Scalar::Binary32;
    const C: &'static str = "float";
    fn of(bits: u64) -> Self {
        f32::from_bits((bits >> 32) as u32)
    }
    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }
    fn near(x: f64) -> Self {
        x as f32
    }
    fn own(function: MathFunction, x: Self) -> Option<Self> {
        match function {
            MathFunction::Sin => Some(binary32::sin(x)),
            MathFunction::Cos => Some(binary32::cos(x)),
            MathFunction::Tan => Some(binary32::tan(x)),
            MathFunction::Asin => Some(binary32::asin(x)),
            _ => None,
        }
    }
}

fn is_nan<T: PartialOrd>(x: &T) -> bool {
    x.partial_cmp(x).is_none()
}

/// The number of arguments without pattern.
fn random() -> usize {
    if is_complete() { 15_000 } else { 3000 }
}

/// Special values and their neighbours, multiples of pi/4 and of ln 2 with neighbours, and numbers without pattern: of
/// all exponents, and of the sizes at which the functions have their branches.
fn arguments<T: Bits>() -> Vec<T> {
    let mut numbers = Random(0x1234_5678_9abc_def1);
    let mut near: Vec<f64> =
        vec![0.0, 1.0, f64::MAX, f64::MIN_POSITIVE, f64::from(f32::MAX), 709.8, 745.2, 88.73, 104.0];
    near.extend([
        0.5, 0.975, 0.4375, 0.6744, 1.1875, 2.4375, 0.6875, 0.5493, 0.2554, 20.0, 10.0, 22.0, 2.0, 3.0, 0.41421356,
    ]);
    near.extend((-1074..=1023).map(|e| 2f64.powi(e)));
    near.extend((1..2000).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4));
    near.extend(
        (10..1000)
            .step_by(7)
            .map(|e| (2f64.powi(e) * std::f64::consts::FRAC_2_PI).round() * std::f64::consts::FRAC_PI_2),
    );
    near.extend((1..1500).map(|k| f64::from(k) * std::f64::consts::LN_2 / 2.0));
    let mut all = vec![T::near(f64::NAN), T::near(f64::INFINITY), T::near(f64::NEG_INFINITY), T::of(1), T::of(1 << 32)];
    // The number nearest to an integer times pi/2 among those of binary64.
    near.push(6381956970095103.0 * 2f64.powi(797));
    for x in near {
        let (x, unit) = (T::near(x), T::of(1 << if T::C == "float" { 32 } else { 0 }).bits());
        for d in 0..=4u64 {
            for bits in [x.bits().wrapping_add(d * unit), x.bits().wrapping_sub(d * unit)] {
                let shifted = if T::C == "float" { bits << 32 } else { bits };
                all.extend([T::of(shifted), -T::of(shifted)]);
            }
        }
    }
    for _ in 0..random() {
        let bits = numbers.bits();
        all.push(T::of(bits));
        for size in [1.0, 2.0, 30.0, 800.0, 1e6] {
            all.push(T::near(size * numbers.unit()));
        }
        let small = 2f64.powi(-((numbers.bits() % 60) as i32));
        all.extend([T::near(1.0 + small * numbers.unit()), T::near(small * numbers.unit())]);
    }
    all
}

/// Pairs: special values with one another, and numbers whose power or quotient is in range.
fn pairs<T: Bits>() -> Vec<(T, T)> {
    let mut numbers = Random(0xfeed_beef_1234_5677);
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        -0.5,
        2.0,
        -2.0,
        3.0,
        -3.0,
        1.5,
        -1.5,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
        1e-310,
        -1e-310,
        1e-40,
        -1e-40,
        f64::MAX,
        f64::MIN,
        1e300,
        1e30,
        -1e30,
        4503599627370497.0,
        9007199254740993.0,
        8388609.0,
        16777217.0,
        1.0000001,
        0.9999999,
        -1.0000001,
        1e19,
        1e10,
        -1e10,
        1.0 + f64::EPSILON,
        1.0 - f64::EPSILON,
        7.0,
        8.0,
        1023.0,
        1024.0,
        -1074.0,
        -1075.0,
        128.0,
        -149.0,
        -150.0,
    ];
    let mut all: Vec<(T, T)> =
        special.iter().flat_map(|x| special.iter().map(|y| (T::near(*x), T::near(*y)))).collect();
    for _ in 0..random() {
        let (x, y) = (T::of(numbers.bits()), T::of(numbers.bits()));
        all.push((x, y));
        let positive = x.abs();
        // Results of all exponents, those beyond the range too.
        let exponent = T::near(800.0 * numbers.unit()) / positive.ln();
        all.extend([(positive, exponent), (x, exponent.round())]);
        let near_one = T::near(1.0 + 2f64.powi(-((numbers.bits() % 50) as i32)) * numbers.unit());
        all.extend([(near_one, T::near(800.0 * numbers.unit()) / near_one.ln()), (near_one, y)]);
        let (a, b) = (T::near(10.0 * numbers.unit()), T::near(10.0 * numbers.unit()));
        all.extend([(a, b), (a, b.round()), (a, T::near((8.0 * numbers.unit()).round() / 2.0))]);
    }
    all
}

/// A program that reads arguments from one file and writes results to another.
fn driver<T: Bits>() -> String {
    let number = T::C;
    let mut text = INCLUDES.to_owned() + "#include <stdio.h>\n#include <stdlib.h>\n\n";
    text += &source("plant", T::SCALAR, MathFunction::ALL);
    _ = write!(
        text,
        "
int main(int count, char **names)
{{
    FILE *in;
    FILE *out;
    {number} x[2];
    int which;

    if (count != 4) {{
        return 1;
    }}
    which = atoi(names[1]);
    in = fopen(names[2], \"rb\");
    out = fopen(names[3], \"wb\");
    if ((in == NULL) || (out == NULL)) {{
        return 1;
    }}
    while (fread(x, sizeof x[0], 2, in) == 2) {{
        {number} result;
        switch (which) {{
"
    );
    for (k, function) in MathFunction::ALL.into_iter().enumerate() {
        let call = call(function, "plant", T::SCALAR);
        let arguments = if function.arguments() == 2 { "x[0], x[1]" } else { "x[0]" };
        _ = writeln!(text, "        case {k}:\n            result = {call}({arguments});\n            break;");
    }
    text += "        default:
            return 1;
        }
        (void)fwrite(&result, sizeof result, 1, out);
    }
    (void)fclose(in);
    return (fclose(out) == 0) ? 0 : 1;
}
";
    text
}

fn compare<T: Bits>(compiler: &str) {
    let folder = folder(&format!("math-{}", T::C));
    std::fs::write(folder.join("math.c"), driver::<T>()).unwrap();
    let mut builds: Vec<Vec<&str>> = vec![vec!["-O2"]];
    if is_complete() {
        builds.extend([vec!["-O0"], vec!["-O3"]]);
    }
    if has_haswell() {
        builds.push(vec!["-O2", "-march=haswell"]);
    }
    if can_sanitise(compiler) {
        builds.push(SANITISERS.to_vec());
    } else {
        eprintln!("SKIPPED: {compiler} has no sanitizers here");
    }
    for (k, flags) in builds.iter().enumerate() {
        let built = Command::new(compiler)
            .current_dir(&folder)
            .args(["-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion"])
            .args(["-Werror", "-pedantic"])
            .args(flags)
            .args(["math.c", "-o", &format!("math{k}"), "-lm"])
            .output()
            .unwrap();
        assert!(built.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&built.stderr));
    }
    let bytes = |x: T| x.bits().to_le_bytes()[..T::SCALAR.bytes()].to_vec();
    let singles: Vec<(T, T)> = arguments().into_iter().map(|x| (x, T::zero())).collect();
    let doubles = pairs();
    for (which, function) in MathFunction::ALL.into_iter().enumerate() {
        let cases = if function.arguments() == 2 { &doubles } else { &singles };
        let input: Vec<u8> = cases.iter().flat_map(|(x, y)| [bytes(*x), bytes(*y)].concat()).collect();
        std::fs::write(folder.join("in"), input).unwrap();
        let expected: Vec<u64> = cases.iter().map(|(x, y)| reference(function, *x, *y).bits()).collect();
        for (k, flags) in builds.iter().enumerate() {
            let ran = Command::new(folder.join(format!("math{k}")))
                .current_dir(&folder)
                .args([&which.to_string(), "in", "out"])
                .output()
                .unwrap();
            assert!(ran.status.success(), "{function:?} {flags:?}: {}", String::from_utf8_lossy(&ran.stderr));
            let found = std::fs::read(folder.join("out")).unwrap();
            assert_eq!(found.len(), cases.len() * T::SCALAR.bytes());
            for ((found, expected), (x, y)) in found.chunks(T::SCALAR.bytes()).zip(&expected).zip(cases) {
                let mut word = [0; 8];
                word[..found.len()].copy_from_slice(found);
                let found = u64::from_le_bytes(word);
                let value = |bits: u64| T::of(if T::C == "float" { bits << 32 } else { bits });
                let same = found == *expected || (is_nan(&value(found)) && is_nan(&value(*expected)));
                assert!(
                    same,
                    "{function:?}({x:?}, {y:?}) {flags:?}: {:?}, expected {:?}",
                    value(found),
                    value(*expected)
                );
            }
        }
    }
}

#[test]
fn functions_in_c_give_the_bits_of_rust() {
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    for compiler in compilers {
        compare::<f64>(compiler);
        compare::<f32>(compiler);
    }
}

/// |found - expected| in units in the last place of the format at the expected value.
fn units(found: f32, expected: f64) -> f64 {
    let exponent = expected.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor();
    (f64::from(found) - expected).abs() / (exponent - 23.0).exp2()
}

/// The stated errors in binary32, by the functions of binary64, whose own error is 2^-29 of a unit: on every
/// k-th number of all, and on the special ones.
#[test]
fn errors_in_binary32_are_as_stated() {
    for function in MathFunction::ALL {
        let (mut worst, mut place) = (0.0, (0.0, 0.0));
        let mut check = |x: f32, y: f32| {
            // Below -1 libm's is a number, in both formats.
            if function == MathFunction::Acosh && x < 1.0 {
                return;
            }
            let found = reference(function, x, y);
            let expected = of_libm(function, f64::from(x), f64::from(y));
            let as_single = expected as f32;
            if as_single.is_nan() || as_single.is_infinite() || found.is_infinite() {
                assert!(found.is_nan() == as_single.is_nan(), "{function:?}({x:?}, {y:?}): {found:?}");
                let largest = f64::from(f32::MAX);
                assert!(found.is_nan() || expected.abs() >= largest * (1.0 - 2e-7), "{function:?}({x:?}, {y:?})");
                return;
            }
            assert!(found.is_sign_negative() == expected.is_sign_negative(), "{function:?}({x:?}, {y:?}): {found:?}");
            let units = units(found, expected);
            if units > worst {
                (worst, place) = (units, (x, y));
            }
        };
        if function.arguments() == 2 {
            for (x, y) in pairs() {
                check(x, y);
            }
        } else {
            let step = if is_complete() { 67 } else { 4093 };
            let everywhere = (0..=u32::MAX).step_by(step).map(f32::from_bits);
            for x in arguments().into_iter().chain(everywhere) {
                check(x, 0.0);
            }
        }
        let stated = c_math::units(function);
        assert!(worst <= stated, "{function:?}{place:?}: {worst:.4} units, stated {stated}");
        assert!(worst >= 0.3 * stated, "{function:?}: {worst:.4} units at most, stated {stated}");
    }
}

#[test]
fn only_what_is_needed_is_written() {
    assert_eq!(source("a", Scalar::Binary64, []), "");
    let text = source("a", Scalar::Binary32, [MathFunction::Sin]);
    for (name, there) in [("a_sinf(", true), ("a_k_cosf(", true), ("a_rem_pio2_largef(", true), ("a_cosf(", false)] {
        assert_eq!(text.contains(name), there, "{name}");
    }
    assert!(text.starts_with("/* Elementary functions") && text.contains("Sun Microsystems") && !text.contains("lm_"));
}

/// The names that begin with `lm_` in the code of a paragraph; the first is the one that it defines.
fn names(paragraph: &str) -> impl Iterator<Item = &str> {
    paragraph
        .split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_')
        .filter(|word| word.starts_with("lm_"))
}

/// Of all functions together, in both formats; every paragraph of the files in `src/c_math` is in one of the texts.
#[test]
fn every_reference_is_defined_before_it_and_every_definition_is_used() {
    let texts = [Scalar::Binary32, Scalar::Binary64].map(|scalar| source("lm", scalar, MathFunction::ALL));
    for text in &texts {
        let mut defined = BTreeSet::new();
        for paragraph in text.trim_end().split("\n\n").filter(|paragraph| names(paragraph).next().is_some()) {
            let mut names = names(paragraph);
            let name = names.next().unwrap();
            assert!(paragraph.contains(&format!("{name}(")) || paragraph.contains(&format!("{name}[")), "{name}");
            for other in names.filter(|other| *other != name) {
                assert!(defined.contains(other), "{name} refers to {other}");
            }
            assert!(defined.insert(name), "{name} twice");
        }
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/c_math");
    let mut defined = BTreeSet::new();
    for file in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if file.extension().is_none_or(|extension| extension != "c") || file.ends_with("notice.c") {
            continue;
        }
        for paragraph in fs::read_to_string(&file).unwrap().trim_end().split("\n\n") {
            let name = names(paragraph).next().unwrap().to_owned();
            assert!(texts.iter().any(|text| text.contains(paragraph)), "{name} is not used");
            assert!(defined.insert(name.clone()), "{name} twice");
        }
    }
    assert!(defined.len() > 2 * MathFunction::ALL.len(), "{}", defined.len());
}
