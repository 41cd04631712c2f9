//! Any bytes are a semidefinite program or an error, and a small program is bounded, shown infeasible or left
//! undecided: no panic, no unbounded memory or time.
//!
//! `cargo +nightly fuzz run sdpa`, or, without cargo-fuzz, as `docs/proofs.md` says.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luenberger_lmi::sdpa::{Settings, read, solve};

fuzz_target!(|bytes: &[u8]| {
    let Ok(program) = read(bytes) else { return };
    let rows: usize = program.blocks().iter().map(|block| block.order()).sum();
    if rows <= 24 && program.unknowns() <= 24 {
        let found = solve(&program, &Settings { iterations: 60, memory: 1 << 24, time: None, ..Settings::default() });
        assert!(found.lower <= found.upper || found.lower == f64::INFINITY, "{found:?}");
    }
});
