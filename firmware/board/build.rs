//! The linker script of the target; for the host this program is not built.

fn main() {
    let target = std::env::var("TARGET").unwrap_or_default();
    let family = if target.starts_with("riscv") { "riscv" } else { "arm" };
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-link-arg-bins=-T{folder}/start/{family}.ld");
    println!("cargo:rerun-if-changed=start");
}
