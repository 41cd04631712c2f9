//! The page of results.

use super::{Cost, Measured};
use std::fmt::Write;

const HEAD: &str = "# What a step costs on a target

`cargo xtask firmware --document` writes this page. The observers of `firmware/golden` run 1000 steps on boards in QEMU;
every step has the bits of the host. The programs link only if nothing can panic.

- **Instructions** of one step, on average and at most, counted by QEMU (`-icount`, read through SysTick or minstret).
  They are instructions, not cycles.
- **Stack** in bytes, with all functions that the step calls: the memory below the stack pointer is painted before the
  step, and looked at after it. In brackets the frame of the step's own function, as the compiler states it.
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

pub(super) fn page(measured: &[Measured]) -> String {
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
                    .map_or_else(|| " | | |".to_owned(), |(_, cost)| cells(cost))
            };
            _ = write!(text, "| {name} | {}", of(rust));
            if !c.is_empty() {
                _ = write!(text, " {}", of(c));
            }
            text.push('\n');
        }
    }
    text
}

fn cells(cost: &Cost) -> String {
    let frame = cost.frame.map_or_else(String::new, |frame| format!(" ({frame})"));
    format!("{:.0} | {} | {}{frame} | {} |", cost.mean, cost.most, cost.stack, cost.code)
}
