//! The page of results.

use super::studies::Row;
use super::{Cost, Measured};
use std::fmt::Write;

const HEAD: &str = "# What a step costs on a target

`cargo xtask firmware --document` writes this page. The observers of `firmware/golden` run 1000 steps on boards in QEMU;
every step has the bits of the host. The programs link only if nothing can panic.

- **Instructions** of one step, on average and at most, counted by QEMU (`-icount`, read through SysTick, a timer or
  minstret). They are instructions, not cycles.
- **Stack** in bytes, with all functions that the step calls: the memory below the stack pointer is painted before the
  step, and looked at after it. In brackets the frame of the step's own function, as the compiler states it, which stands
  in place of a smaller number: what is reserved and not written stays painted.
- **Code** in bytes: the step without its constants, and without the routines of the compiler and of the C library that
  it shares with the rest of a program (arithmetic in software, square root, sine).

Rust is `luenberger-observers` with sizes known at compile time, `opt-level = 2` and fat link-time optimisation. C
is what `luenberger export` writes, compiled by `arm-none-eabi-gcc -std=c99 -O2`. An observer's name has its number
of states and its numbers; `fixed` are linear observers in integers. Cortex-M4F and RV32IMAFC compute in f32 by
hardware and in f64 by software, Cortex-M0 both by software. Square roots, which the cubic observers and the Kalman
filters take, are those of the crate `libm` in Rust, in software; the C compiler uses the instruction of the
Cortex-M4F in f32. Both round correctly, so that the bits are the same.

The boards are mps2-an386 (Cortex-M4F), mps2-an385 (Cortex-M3, which runs the code for Cortex-M0) and virt (RISC-V).
";

const STUDIES: &str = "
## Observers of the templates and examples: Cortex-M4F

Every observer of a template (`luenberger new --list`) and of `examples/studies`, three with their feedback (one of them
an unscented Kalman filter), one in filter form, one at varying periods, a moving-horizon estimator of three samples with
a bound of a state, and the numerical KKL observer with its interpolated left inverse, as
`luenberger export --to c --test-steps 1000` writes them. The golden test of the export runs unchanged on mps2-an386:
all 1000 estimates have the bits of the design, in f32 and in f64. Where the cells of f64 are empty, they have them with
Rust's routines for doubles, but [libgcc misrounds a sum](deploy.md#on-a-board). Observers in continuous time without a
period in the study take a step every 0.01.

**Code** has the elementary functions that the file needs; **constants** are matrices and tables, in bytes as well.

| study | observer | f32: instructions | at most | stack | code | constants | f64: instructions | at most | stack | code | constants |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

const LIBRARIES: &str = "
Some of them as the static library of `luenberger export --to rust`, with the same test. It links only functions that
cannot panic.

| study | observer | f32: instructions | at most | stack | code | f64: instructions | at most | stack | code |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|
";

pub(super) fn page(measured: &[Measured], studies: &[Row]) -> String {
    let mut text = HEAD.to_owned();
    for Measured { board, rust, c } in measured {
        _ = write!(text, "\n## {}: `{}`\n\n", board.processor, board.target);
        text.push_str(if c.is_empty() {
            "| observer | instructions | at most | stack | code |\n|---|---:|---:|---:|---:|\n"
        } else {
            concat!(
                "| observer | instructions | at most | stack | code | C: instructions | at most | stack | code |\n",
                "|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
            )
        });
        let mut names: Vec<&String> = rust.iter().chain(c).map(|(name, _)| name).collect();
        let mut seen = std::collections::BTreeSet::new();
        names.retain(|name| seen.insert(name.as_str()));
        for name in names {
            let of = |costs: &[(String, Cost)]| {
                costs
                    .iter()
                    .find(|(other, _)| other == name)
                    .map_or_else(|| " | | | |".to_owned(), |(_, cost)| cells(cost))
            };
            _ = write!(text, "| {name} | {}", of(rust));
            if !c.is_empty() {
                _ = write!(text, " {}", of(c));
            }
            text.push('\n');
        }
    }
    if !studies.is_empty() {
        text.push_str(STUDIES);
        rows(&mut text, studies, |row| &row.c);
    }
    if studies.iter().any(|row| !row.rust.is_empty()) {
        text.push_str(LIBRARIES);
        rows(&mut text, studies, |row| &row.rust);
    }
    text
}

/// The rows of observers of studies; an empty cell is a format that the command refuses or that libgcc misrounds.
fn rows(text: &mut String, studies: &[Row], costs: fn(&Row) -> &Vec<Option<Cost>>) {
    for row in studies.iter().filter(|row| !costs(row).is_empty()) {
        let feedback = if row.case.has_feedback { ", with feedback" } else { "" };
        _ = write!(text, "| {} | {}{feedback} |", row.case.study, row.case.observer);
        let all = costs(row);
        let has_constants = all.iter().flatten().any(|cost| cost.constants.is_some());
        for cost in all {
            let cost = cost.as_ref();
            let constants = cost.and_then(|cost| cost.constants).map_or_else(String::new, |bytes| bytes.to_string());
            _ = match cost {
                Some(cost) => write!(text, " {}", cells(cost)),
                None => write!(text, " | | | |"),
            };
            if has_constants {
                _ = write!(text, " {constants} |");
            }
        }
        text.push('\n');
    }
}

fn cells(cost: &Cost) -> String {
    let frame = cost.frame.map_or_else(String::new, |frame| format!(" ({frame})"));
    format!("{:.0} | {} | {}{frame} | {} |", cost.mean, cost.most, cost.reserved(), cost.code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_reserved_and_not_written_counts() {
        let cost = |stack, frame| Cost { mean: 91.0, most: 91, stack, frame, code: 500, constants: None };
        assert_eq!(cells(&cost(36, Some(56))), "91 | 91 | 56 (56) | 500 |");
        assert_eq!(cells(&cost(136, Some(88))), "91 | 91 | 136 (88) | 500 |");
        assert_eq!(cells(&cost(36, None)), "91 | 91 | 36 | 500 |");
    }
}
