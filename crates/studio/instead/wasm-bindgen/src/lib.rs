//! What `getrandom` needs to be compiled for a page that gives no random numbers.

#![no_std]

/// A value of the page, of which there are none.
#[derive(Debug)]
pub struct JsValue;

/// What is imported by users of the crate of this name.
pub mod prelude {
    pub use luenberger_studio_no_bindings::wasm_bindgen;
}
