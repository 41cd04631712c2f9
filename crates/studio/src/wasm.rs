//! The plain C interface of WebAssembly: buffers of bytes, whose addresses and lengths the page passes.
//!
//! The page imports nothing but three functions, calls [`allocate`], writes a request there, and passes it to [`call`].
#![allow(unsafe_code)]

use std::alloc::{Layout, alloc, dealloc, handle_alloc_error};
use std::sync::Once;

use crate::Host;

/// Bytes in front of an answer: its length.
const HEAD: usize = 4;

/// Buffers are aligned as the addresses of the page are.
const ALIGNMENT: usize = 8;

#[link(wasm_import_module = "luenberger")]
unsafe extern "C" {
    /// Milliseconds since the page was opened.
    safe fn now() -> f64;
    /// Takes progress, JSON in UTF-8.
    fn progress(text: *const u8, length: usize);
    /// Takes the message of a panic, in UTF-8, before the module ends.
    fn panicked(text: *const u8, length: usize);
}

/// The page.
struct Page;

impl Host for Page {
    fn progress(&self, json: &str) {
        // SAFETY: the page reads the text before it returns.
        unsafe { progress(json.as_ptr(), json.len()) }
    }
}

/// A buffer of `length` bytes for the page to write a request to; [`call`] frees it. The module ends if there is no
/// memory for it.
#[unsafe(no_mangle)]
pub extern "C" fn allocate(length: usize) -> *mut u8 {
    let layout = Layout::from_size_align(length.max(1), ALIGNMENT).unwrap_or(Layout::new::<u64>());
    // SAFETY: the size is not zero.
    let buffer = unsafe { alloc(layout) };
    if buffer.is_null() || layout.size() < length {
        handle_alloc_error(layout);
    }
    buffer
}

/// The address of the answer to the request in a buffer, which is freed: the length of the answer as four bytes, the
/// least significant first, and the answer. [`release`] frees it.
///
/// # Safety
/// `request` and `length` are those of a call of [`allocate`], whose buffer was not passed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn call(request: *mut u8, length: usize) -> *mut u8 {
    static START: Once = Once::new();
    START.call_once(|| {
        luenberger_clock::set_clock(|| now());
        std::panic::set_hook(Box::new(|about| {
            let text = about.to_string();
            // SAFETY: the page reads the text before it returns.
            unsafe { panicked(text.as_ptr(), text.len()) }
        }));
    });
    // SAFETY: the caller passes a whole buffer of `allocate`, which is freed afterwards.
    let answer = unsafe { crate::answer(std::slice::from_raw_parts(request, length), &Page) };
    // SAFETY: as above; the layout is that of `allocate`.
    unsafe { free(request, length) };
    let buffer = allocate(HEAD + answer.len());
    // SAFETY: the buffer has room for the length and the answer.
    unsafe {
        buffer.copy_from_nonoverlapping((answer.len() as u32).to_le_bytes().as_ptr(), HEAD);
        buffer.add(HEAD).copy_from_nonoverlapping(answer.as_ptr(), answer.len());
    }
    buffer
}

/// Frees an answer.
///
/// # Safety
/// `answer` is what [`call`] gave, not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn release(answer: *mut u8) {
    let mut length = [0; HEAD];
    // SAFETY: the answer begins with its length, with which it was allocated.
    unsafe {
        answer.copy_to_nonoverlapping(length.as_mut_ptr(), HEAD);
        free(answer, HEAD + u32::from_le_bytes(length) as usize);
    }
}

/// Frees a buffer of [`allocate`].
///
/// # Safety
/// As [`call`].
unsafe fn free(buffer: *mut u8, length: usize) {
    if let Ok(layout) = Layout::from_size_align(length.max(1), ALIGNMENT) {
        // SAFETY: the buffer was allocated with this layout.
        unsafe { dealloc(buffer, layout) }
    }
}
