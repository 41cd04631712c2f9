//! Programs of named matrices as C with loops: the bits of the body over numbers, for bodies of which some are loops,
//! some are nearly, and some are none. Without a C compiler nothing is compared.

use std::fmt::Write as _;
use std::process::Command;

use luenberger_export::{Scalar, number};
use luenberger_expression::{Columns, Dialect, Language, Routine, record};
use luenberger_random::Random;
use nalgebra::{DMatrix, RealField, convert};

use crate::compiled;

const N: usize = 6;

fn times<T: RealField + Copy>(m: &DMatrix<T>, x: &[T]) -> Vec<T> {
    (0..N).map(|i| (1..N).fold(m[(i, 0)] * x[0], |sum, k| sum + m[(i, k)] * x[k])).collect()
}

fn products<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let (first, second) = (times(m, x), times(m, u));
    first.iter().zip(&second).map(|(first, second)| *first + *second - *first * x[1]).collect()
}

/// Each entry needs the one before it.
fn recurrence<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let mut before = x[0];
    let step = |k: usize| {
        before = before * m[(k, 0)] + u[k];
        before
    };
    (0..N).map(step).collect()
}

/// Indices that fall, and that no loop has.
fn permuted<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    (0..N).map(|i| m[(i, (i * i) % N)] * x[N - 1 - i] + u[(2 * i) % N] * x[i]).collect()
}

/// One row is another operation than the others.
fn nearly<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let rows = times(m, x);
    (0..N).map(|i| if i == 3 { rows[i] - u[i] } else { rows[i] + u[i] }).collect()
}

fn symmetric<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let half: T = convert(0.5);
    let entry = |i: usize, j: usize| (m[(i, j)] * x[i] * u[j] + m[(j, i)] * x[j] * u[i]) * half;
    let sums: Vec<T> = (0..N).map(|i| (1..N).fold(entry(i, 0), |sum, j| sum + entry(i, j))).collect();
    (0..N).map(|i| sums[i] * entry(i, (i + 1) % N)).collect()
}

/// As in a factorisation: what is before it is subtracted from each entry.
fn subtracted<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let mut done: Vec<T> = Vec::new();
    for i in 0..N {
        let rest = (0..i).fold(u[i] * x[i], |rest, k| rest - m[(i, k)] * done[k]);
        done.push(rest / m[(i, i)]);
    }
    done
}

fn chosen<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let choose = |a: T, b: T| a.zip_map_lanes(b, |a, b| if a > b { a } else { b });
    let largest = (1..N).fold(x[0].abs(), |largest, k| choose(x[k].abs(), largest));
    let scaled: Vec<T> = x.iter().map(|x| *x / largest).collect();
    let rows = times(m, &scaled);
    (0..N).map(|i| choose(rows[i], u[i]) - choose(scaled[i], T::zero()) * rows[N - 1 - i]).collect()
}

/// Terms that are equal, and the first of a sum behind others.
fn repeated<T: RealField + Copy>(m: &DMatrix<T>, x: &[T], u: &[T]) -> Vec<T> {
    let term = |k: usize| m[(k, k)] * x[k];
    let sum = term(5) + term(1) + term(2) + term(1) + term(0) + term(4) + u[0];
    (0..N).map(|i| sum * u[i] + term(i) + term((i + 1) % N) + term(2) + term(i)).collect()
}

macro_rules! compared {
    ($($body:ident),*) => {
        [$((
            stringify!($body),
            (|m: &DMatrix<f64>| {
                let known = (N, N);
                let program = |recording: &mut luenberger_expression::Recording| {
                    let m = recording.matrix("M", m);
                    recording.program(known, |_, x, u| $body(&m, x, u))
                };
                record(program).unwrap()
            }) as fn(&DMatrix<f64>) -> Routine,
            $body::<f64> as fn(&DMatrix<f64>, &[f64], &[f64]) -> Vec<f64>,
            $body::<f32> as fn(&DMatrix<f32>, &[f32], &[f32]) -> Vec<f32>,
        )),*]
    };
}

fn dialect(single: bool) -> Dialect<'static> {
    let literal = |x: f64, single: bool| number::c(x, if single { Scalar::Binary32 } else { Scalar::Binary64 });
    Dialect { language: Language::C, single, prefix: "", of_target: false, literal }
}

/// Numbers without pattern, with some that are large, small, and none.
fn inputs(random: &mut Random, count: usize) -> Vec<[f64; 2 * N]> {
    let hostile = [1e30, -1e30, 1e-40, -0.0, 0.0, f64::INFINITY, f64::NAN, 1e13];
    (0..count)
        .map(|k| {
            let mut all = [0.0; 2 * N];
            for x in &mut all {
                *x = f64::from(random.between(-2.0, 2.0) as f32);
            }
            if k % 2 == 1 {
                all[k % (2 * N)] = hostile[k / 2 % hostile.len()];
            }
            all
        })
        .collect()
}

#[test]
fn loops_have_the_bits_of_the_body() {
    let bodies = compared!(products, recurrence, permuted, nearly, symmetric, subtracted, chosen, repeated);
    let mut random = Random(23);
    let m = DMatrix::from_fn(N, N, |_, _| f64::from(random.between(-1.5, 1.5) as f32));
    let samples = inputs(&mut random, 64);
    let folder = compiled::folder("loops");
    for single in [false, true] {
        let number = if single { "float" } else { "double" };
        let mut source = String::from("#include <math.h>\n#include <stdbool.h>\n#include <stdio.h>\n");
        _ = writeln!(source, "static const {number} M[{N}][{N}] = {{");
        let scalar = if single { Scalar::Binary32 } else { Scalar::Binary64 };
        for row in m.row_iter() {
            let row: Vec<String> = row.iter().map(|x| number::c(*x, scalar)).collect();
            _ = writeln!(source, "    {{ {} }},", row.join(", "));
        }
        source.push_str("};\n");
        let mut calls = String::new();
        for (name, program, ..) in &bodies {
            let columns = Columns { inputs: &[("u", N)], results: &[("next", N)] };
            let body = program(&m).loops(&dialect(single), columns);
            _ = writeln!(
                source,
                "static void {name}(const {number} *x, const {number} *u, {number} *next)\n{{\n{body}}}"
            );
            _ = writeln!(calls, "        {name}(in, in + {N}, out);\n        fwrite(out, sizeof out, 1, stdout);");
        }
        _ = writeln!(
            source,
            "int main(void)\n{{\n    {number} in[{}];\n    {number} out[{N}];\n    while (fread(in, sizeof in, 1, stdin) == 1) {{\n{calls}    }}\n    return 0;\n}}",
            2 * N
        );
        std::fs::write(folder.join("loops.c"), &source).unwrap();
        let bytes: Vec<u8> = samples
            .iter()
            .flatten()
            .flat_map(|x| if single { (*x as f32).to_le_bytes().to_vec() } else { x.to_le_bytes().to_vec() })
            .collect();
        std::fs::write(folder.join("in"), bytes).unwrap();
        for compiler in compiled::compilers() {
            let built = Command::new(compiler)
                .current_dir(&folder)
                .args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off"])
                .args(["loops.c", "-o", "loops", "-lm"])
                .output()
                .unwrap();
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            let ran = Command::new(folder.join("loops"))
                .stdin(std::fs::File::open(folder.join("in")).unwrap())
                .output()
                .unwrap()
                .stdout;
            let width = if single { 4 } else { 8 };
            let mut answers = ran.chunks_exact(width);
            for sample in &samples {
                let (x, u) = sample.split_at(N);
                for (name, _, double, of_single) in &bodies {
                    let expected: Vec<f64> = if single {
                        let cast = |column: &[f64]| column.iter().map(|x| *x as f32).collect::<Vec<f32>>();
                        of_single(&m.map(|x| x as f32), &cast(x), &cast(u)).iter().map(|x| f64::from(*x)).collect()
                    } else {
                        double(&m, x, u)
                    };
                    for expected in expected {
                        let answer = answers.next().unwrap();
                        let found = if single {
                            f64::from(f32::from_le_bytes(answer.try_into().unwrap()))
                        } else {
                            f64::from_le_bytes(answer.try_into().unwrap())
                        };
                        let same = found.to_bits() == expected.to_bits() || (found.is_nan() && expected.is_nan());
                        assert!(same, "{name} {number} {sample:?}: {found:e} {expected:e}\n{source}");
                    }
                }
            }
        }
    }
}

/// A product is two loops, and so are the columns that share it.
#[test]
fn a_product_is_written_as_loops() {
    let m = DMatrix::from_element(N, N, 0.5);
    let routine = record(|recording| {
        let m = recording.matrix("M", &m);
        recording.program((N, 0), |_, x, _| times(&m, x))
    });
    let text = routine.unwrap().loops(&dialect(false), Columns { inputs: &[], results: &[("next", N)] });
    let expected = "    for (int i = 0; i < 6; ++i) {
        double sum1 = M[i][0] * x[0];
        for (int j = 1; j < 6; ++j) {
            sum1 = sum1 + (M[i][j] * x[j]);
        }
        next[i] = sum1;
    }
";
    assert_eq!(text, expected);
}
