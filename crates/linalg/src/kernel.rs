//! Inner loops for the instructions that this machine has: plain Rust, compiled for each instruction set by `pulp`.
//!
//! Everything a kernel calls has to be inlined into it, or it is compiled without them.

/// Work that is compiled for the instruction sets of today and of yesterday; `FMA` tells whether fused multiply-add is
/// one instruction.
pub trait Kernel {
    type Output;
    fn run<const FMA: bool>(self) -> Self::Output;
}

struct Op<K>(K);

impl<K: Kernel> pulp::WithSimd for Op<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> K::Output {
        if const { S::F64_LANES > 1 && !cfg!(target_family = "wasm") } {
            self.0.run::<true>()
        } else {
            self.0.run::<false>()
        }
    }
}

/// Runs the kernel with the best instructions that this machine has.
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(Op(kernel))
}

/// `a b + c`.
#[inline(always)]
pub(crate) fn fma<const FMA: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}
