//! RV32IMAFC on the board virt: semihosting, minstret, stack.

use core::arch::{asm, global_asm};

global_asm!(include_str!("../start/riscv.S"));

/// Bytes below the stack pointer that are painted.
const DEPTH: u32 = 16 * 1024;

const PAINT: u32 = 0xA5C3_96E1;

/// Starts the counter, which runs already.
pub fn start() {}

/// The counter.
#[inline(always)]
pub fn count() -> u32 {
    let count: u32;
    // SAFETY: reads a counter.
    unsafe { asm!("csrr {count}, minstret", count = out(reg) count) }
    count
}

/// Instructions from one reading to the next.
#[inline(always)]
pub fn instructions(before: u32, after: u32) -> u32 {
    after.wrapping_sub(before)
}

/// Paints the memory below the stack pointer.
#[inline(always)]
pub fn paint() {
    // SAFETY: the stack has 4 MiB, and nothing is stored below the stack pointer.
    unsafe {
        asm!(
            "mv {at}, sp",
            "2:",
            "addi {at}, {at}, -4",
            "sw {paint}, 0({at})",
            "addi {left}, {left}, -4",
            "bnez {left}, 2b",
            at = out(reg) _, paint = in(reg) PAINT, left = inout(reg) DEPTH => _,
        );
    }
}

/// Bytes below the stack pointer down to the deepest one that is not painted any more.
#[inline(always)]
pub fn painted() -> u32 {
    let left: u32;
    // SAFETY: as above; this only reads.
    unsafe {
        asm!(
            "sub {at}, sp, {left}",
            "2:",
            "lw {word}, 0({at})",
            "bne {word}, {paint}, 3f",
            "addi {at}, {at}, 4",
            "addi {left}, {left}, -4",
            "bnez {left}, 2b",
            "3:",
            at = out(reg) _, word = out(reg) _, paint = in(reg) PAINT, left = inout(reg) DEPTH => left,
        );
    }
    left
}

#[inline(never)]
fn call(number: u32, argument: u32) {
    // SAFETY: a semihosting call; the argument is what its number asks for.
    unsafe {
        asm!(
            ".option push",
            ".option norvc",
            ".balign 16",
            "slli x0, x0, 0x1f",
            "ebreak",
            "srai x0, x0, 7",
            ".option pop",
            inout("a0") number => _, in("a1") argument,
        );
    }
}

/// Writes text that ends with a zero.
pub fn write(text: &[u8]) {
    call(0x04, text.as_ptr() as u32);
}

/// Ends the program.
pub fn exit(is_good: bool) -> ! {
    call(0x18, if is_good { 0x2_0026 } else { 0x2_0023 });
    loop {}
}
