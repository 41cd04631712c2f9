//! The plain C interface of WebAssembly: buffers of bytes, whose addresses and lengths the page passes.
#![allow(unsafe_code)]

use std::cell::RefCell;

use crate::experiment::{Experiment, Sliders};

thread_local! {
    static EXPERIMENT: RefCell<Option<Experiment>> = const { RefCell::new(None) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// A buffer of `length` bytes for the page to write to; [`luenberger_load`] frees it.
#[unsafe(no_mangle)]
pub extern "C" fn luenberger_buffer(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; length].into_boxed_slice()).cast()
}

/// Reads the experiment in the buffer, as JSON; 0 if it can be read, else the length of the error as text at
/// [`luenberger_answer`].
///
/// # Safety
/// `buffer` and `length` are those of a call of [`luenberger_buffer`], whose buffer was not loaded before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn luenberger_load(buffer: *mut u8, length: usize) -> usize {
    // SAFETY: the caller passes a whole buffer of `luenberger_buffer` once.
    let bytes = unsafe { Box::from_raw(core::ptr::slice_from_raw_parts_mut(buffer, length)) };
    let read = serde_json::from_slice::<Experiment>(&bytes);
    let error = read.as_ref().err().map(ToString::to_string).unwrap_or_default();
    EXPERIMENT.set(read.ok());
    answer(error.into_bytes())
}

/// Runs the experiment; the length of the answer, an [`Outcome`](crate::Outcome) as JSON at [`luenberger_answer`]. 0 if
/// no experiment is loaded.
#[unsafe(no_mangle)]
pub extern "C" fn luenberger_run(gain: f64, cubic: f64, noise: f64, error: f64, period: f64) -> usize {
    let sliders = Sliders { gain, cubic, noise, error, period };
    with_experiment(|experiment| serde_json::to_vec(&crate::run(experiment, &sliders)))
}

/// The verdicts at these positions of the sliders; the length of the answer, a list with a
/// [`GainVerdict`](crate::GainVerdict) or null for each observer, as JSON. 0 if no experiment is loaded.
#[unsafe(no_mangle)]
pub extern "C" fn luenberger_verify(gain: f64, cubic: f64, noise: f64, error: f64, period: f64) -> usize {
    let sliders = Sliders { gain, cubic, noise, error, period };
    with_experiment(|experiment| serde_json::to_vec(&crate::verify(experiment, &sliders)))
}

/// Where the last answer is, until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn luenberger_answer() -> *const u8 {
    ANSWER.with_borrow(Vec::as_ptr)
}

fn with_experiment(work: impl FnOnce(&Experiment) -> serde_json::Result<Vec<u8>>) -> usize {
    let found = EXPERIMENT.with_borrow(|experiment| experiment.as_ref().and_then(|experiment| work(experiment).ok()));
    answer(found.unwrap_or_default())
}

fn answer(bytes: Vec<u8>) -> usize {
    let length = bytes.len();
    ANSWER.set(bytes);
    length
}
