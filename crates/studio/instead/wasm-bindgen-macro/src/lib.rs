//! The attribute of the crate `wasm-bindgen` beside it.

use proc_macro::TokenStream;

/// In place of the function of the page that `getrandom` declares: one that fails.
#[proc_macro_attribute]
pub fn wasm_bindgen(_options: TokenStream, _declared: TokenStream) -> TokenStream {
    let failing =
        "fn get_random_values(_: &mut [::core::mem::MaybeUninit<u8>]) -> Result<(), JsValue> { Err(JsValue) }";
    failing.parse().unwrap_or_default()
}
