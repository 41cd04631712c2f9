//! The page: one HTML file with the module in it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use luenberger_figures::base85;

/// The module, compressed by LZMA, in base64.
const MODULE: &str = include_str!("../assets/luenberger-studio.wasm.lzma.base64");
/// What decompresses it, itself compressed by gzip, which browsers know.
const UNPACK: &str = include_str!("../assets/luenberger-unpack.wasm.gz.base64");

const PAGE: &str = include_str!("../assets/page.html");
const STYLE: &str = include_str!("../assets/studio.css");
const EDITOR: &str = include_str!("../assets/editor.js");
/// The script of the page, by its subjects.
const STUDIO: &str = concat!(
    "\"use strict\";\n",
    include_str!("../assets/elements.js"),
    include_str!("../assets/bytes.js"),
    include_str!("../assets/toml.js"),
    include_str!("../assets/schema.js"),
    include_str!("../assets/formula.js"),
    include_str!("../assets/text.js"),
    include_str!("../assets/form.js"),
    include_str!("../assets/engine.js"),
    include_str!("../assets/studio.js"),
);
const WORKER: &str = include_str!("../assets/worker.js");

/// The page with the module of this version, which opens from a file and loads nothing.
///
/// ```
/// let page = luenberger_studio::page();
/// assert!(page.starts_with("<!DOCTYPE html>") && page.contains(env!("CARGO_PKG_VERSION")));
/// ```
pub fn page() -> String {
    page_with(&packed())
}

/// The page with a module, which is compressed by LZMA.
pub fn page_with(module: &[u8]) -> String {
    let parts = [
        ("/*STYLE*/", STYLE.to_owned()),
        ("/*EDITOR*/", script(EDITOR)),
        ("/*WORKER*/", script(WORKER)),
        ("/*STUDIO*/", script(STUDIO)),
        ("<!--UNPACK-->", base85::encode(&bytes(UNPACK))),
        ("<!--MODULE-->", base85::encode(module)),
        ("<!--VERSION-->", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    // Each place is looked for in the skeleton alone: a script may have the words of another place in it.
    let mut places: Vec<(usize, &str, &str)> =
        parts.iter().filter_map(|(name, part)| Some((PAGE.find(name)?, *name, part.as_str()))).collect();
    places.sort_unstable();
    let mut page = String::with_capacity(PAGE.len() + parts.iter().map(|(_, part)| part.len()).sum::<usize>());
    let mut from = 0;
    for (at, name, part) in places {
        page.push_str(&PAGE[from..at]);
        page.push_str(part);
        from = at + name.len();
    }
    page.push_str(&PAGE[from..]);
    page
}

/// The module as WebAssembly, compressed by LZMA; empty if its asset is damaged, which a test rules out.
pub fn packed() -> Vec<u8> {
    bytes(MODULE)
}

fn bytes(lines: &str) -> Vec<u8> {
    let letters: String = lines.split_whitespace().collect();
    STANDARD.decode(letters).unwrap_or_default()
}

/// A script within an element, which "</script" in one of its texts would end.
fn script(text: &str) -> String {
    text.replace("</script", "<\\/script").replace("<!--", "<\\!--")
}
