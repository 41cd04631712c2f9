//! From Fortran's arguments to faer's views: the only place where pointers become references.

use std::ffi::{c_char, c_int};
use std::ptr::NonNull;

use faer::{MatMut, MatRef};

/// Which triangle of a symmetric matrix is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Triangle {
    Lower,
    Upper,
}

/// A letter argument in upper case.
///
/// # Safety
/// `letter` points to a readable character.
pub(crate) unsafe fn letter(letter: *const c_char) -> u8 {
    // SAFETY: the caller's promise.
    let raw = unsafe { *letter };
    // c_char is signed on some targets; the letters are ASCII on all.
    u8::try_from(raw).unwrap_or(0).to_ascii_uppercase()
}

/// An `uplo` argument.
///
/// # Safety
/// As [`letter`].
pub(crate) unsafe fn triangle(uplo: *const c_char) -> Option<Triangle> {
    // SAFETY: the caller's promise.
    match unsafe { letter(uplo) } {
        b'L' => Some(Triangle::Lower),
        b'U' => Some(Triangle::Upper),
        _ => None,
    }
}

/// A `trans` argument: whether to transpose. Conjugation means nothing to real numbers.
///
/// # Safety
/// As [`letter`].
pub(crate) unsafe fn transposed(trans: *const c_char) -> Option<bool> {
    // SAFETY: the caller's promise.
    match unsafe { letter(trans) } {
        b'N' => Some(false),
        b'T' | b'C' => Some(true),
        _ => None,
    }
}

/// A size argument; none if it is negative.
///
/// # Safety
/// `size` points to a readable integer.
pub(crate) unsafe fn size(size: *const c_int) -> Option<usize> {
    // SAFETY: the caller's promise.
    usize::try_from(unsafe { *size }).ok()
}

/// A leading dimension: at least 1 and at least the number of rows, else none.
///
/// # Safety
/// As [`size`].
pub(crate) unsafe fn leading(lda: *const c_int, rows: usize) -> Option<usize> {
    // SAFETY: the caller's promise.
    unsafe { size(lda) }.filter(|&lda| lda >= rows.max(1))
}

/// A column-major matrix to read.
///
/// # Safety
/// `columns` columns of `rows` readable entries each start `lda` entries apart at `a`, none of which is written while
/// the view lives. An empty matrix may have any pointer.
pub(crate) unsafe fn matrix<'a, T>(a: *const T, rows: usize, columns: usize, lda: usize) -> MatRef<'a, T> {
    let a = if rows == 0 || columns == 0 { NonNull::dangling().as_ptr() } else { a.cast_mut() };
    // SAFETY: the caller's promise; strides of 1 and lda stay within it, and no entry is reached through a dangling
    // pointer.
    unsafe { MatRef::from_raw_parts(a, rows, columns, 1, lda.cast_signed()) }
}

/// A column-major matrix to write.
///
/// # Safety
/// As [`matrix`], and nothing else reads or writes these entries while the view lives. Since `lda >= rows`, no entry is
/// reached twice.
pub(crate) unsafe fn matrix_mut<'a, T>(a: *mut T, rows: usize, columns: usize, lda: usize) -> MatMut<'a, T> {
    let a = if rows == 0 || columns == 0 { NonNull::dangling().as_ptr() } else { a };
    // SAFETY: the caller's promise; strides of 1 and lda stay within it, and no entry is reached through a dangling
    // pointer.
    unsafe { MatMut::from_raw_parts_mut(a, rows, columns, 1, lda.cast_signed()) }
}

/// The address of a vector's first logical entry: with a negative increment BLAS starts at the far end.
fn first_entry<T>(x: *const T, entries: usize, increment: isize) -> *const T {
    if increment < 0 && entries > 0 { x.wrapping_offset((entries.cast_signed() - 1) * -increment) } else { x }
}

/// A strided vector, copied out.
///
/// # Safety
/// `entries` readable entries lie `|increment|` apart from `x` on.
pub(crate) unsafe fn vector<T: Copy>(x: *const T, entries: usize, increment: c_int) -> Vec<T> {
    let increment = increment as isize;
    let first = first_entry(x, entries, increment);
    // SAFETY: index k is `|increment| * k` or `|increment| * (entries - 1 - k)` entries from x, both within the
    // caller's promise.
    (0..entries.cast_signed()).map(|k| unsafe { *first.wrapping_offset(k * increment) }).collect()
}

/// Writes a strided vector.
///
/// # Safety
/// `values.len()` writable entries lie `|increment|` apart from `y` on.
pub(crate) unsafe fn store<T: Copy>(y: *mut T, values: &[T], increment: c_int) {
    let increment = increment as isize;
    let first = first_entry(y, values.len(), increment).cast_mut();
    for (k, &value) in values.iter().enumerate() {
        // SAFETY: as in `vector`.
        unsafe { *first.wrapping_offset(k.cast_signed() * increment) = value };
    }
}

/// Clears the upper halves of the vector registers when it goes out of scope.
///
/// faer's AVX kernels leave them dirty, and on several x86-64 generations every SSE instruction of the caller then pays
/// for merging with them: scalar code after a product ran at half its speed. Compilers emit `vzeroupper` at the end of
/// functions compiled for AVX, not at the end of those that call such functions through a pointer chosen at run time.
pub(crate) struct CleanRegisters;

impl Drop for CleanRegisters {
    fn drop(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx") {
            // SAFETY: the processor has AVX, as just asked.
            unsafe { clear_upper_halves() };
        }
    }
}

/// # Safety
/// The processor has AVX.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
unsafe fn clear_upper_halves() {
    std::arch::x86_64::_mm256_zeroupper();
}
