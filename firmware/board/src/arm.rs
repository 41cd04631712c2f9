//! Cortex-M on the boards mps2-an385 and mps2-an386: semihosting, SysTick, stack.

use core::arch::{asm, global_asm};

global_asm!(include_str!("../start/arm.S"));

/// SysTick: control, reload, current value.
const SYSTICK: *mut u32 = 0xE000_E010 as *mut u32;

/// Bytes below the stack pointer that are painted.
const DEPTH: u32 = 16 * 1024;

const PAINT: u32 = 0xA5C3_96E1;

/// Starts the counter.
pub fn start() {
    // SAFETY: the registers of SysTick, which every Cortex-M of these boards has.
    unsafe {
        SYSTICK.add(1).write_volatile(0x00FF_FFFF);
        SYSTICK.add(2).write_volatile(0);
        SYSTICK.write_volatile(5);
    }
}

/// The counter.
#[inline(always)]
pub fn count() -> u32 {
    // SAFETY: as above.
    unsafe { SYSTICK.add(2).read_volatile() }
}

/// Instructions from one reading to the next: QEMU takes 1024 ns for each (`-icount shift=10`), and SysTick counts down
/// every 40 ns.
#[inline(always)]
pub fn instructions(before: u32, after: u32) -> u32 {
    ((before.wrapping_sub(after) & 0x00FF_FFFF) * 40 + 512) / 1024
}

/// Paints the memory below the stack pointer.
#[inline(always)]
pub fn paint() {
    // SAFETY: the boards have 4 MiB of stack, and nothing is stored below the stack pointer.
    unsafe {
        asm!(
            "mov {at}, sp",
            "2:",
            "subs {at}, #4",
            "str {paint}, [{at}]",
            "subs {left}, #4",
            "bne 2b",
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
            "mov {at}, sp",
            "subs {at}, {at}, {left}",
            "2:",
            "ldr {word}, [{at}]",
            "cmp {word}, {paint}",
            "bne 3f",
            "adds {at}, #4",
            "subs {left}, #4",
            "bne 2b",
            "3:",
            at = out(reg) _, word = out(reg) _, paint = in(reg) PAINT, left = inout(reg) DEPTH => left,
        );
    }
    left
}

#[inline(never)]
fn call(number: u32, argument: u32) {
    // SAFETY: a semihosting call; the argument is what its number asks for.
    unsafe { asm!("bkpt 0xAB", inout("r0") number => _, in("r1") argument) }
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
