//! Modules of WebAssembly: built, packed, and taken apart by crate.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use lzma_rust2::{LzmaOptions, LzmaWriter};
use sha2::{Digest, Sha256};

use crate::step::{Failure, Step, cargo, program, root, target};

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";

/// The module of a package; none without the target.
pub(crate) fn module(
    package: &str,
    profile: &str,
    features: &[&str],
    more_flags: &[&str],
) -> Result<Option<Vec<u8>>, Failure> {
    let library = program("rustc").arguments(&["--print", "target-libdir", "--target", TARGET]);
    let library = library.quiet_output("rustc")?;
    if !Path::new(library.trim()).is_dir() {
        return Ok(None);
    }
    let arguments = ["rustc", "--package", package, "--lib", "--crate-type", "cdylib", "--profile", profile];
    built(cargo(&arguments).arguments(features), package, profile, more_flags).map(Some)
}

/// The module of a package with a workspace of its own, in its release profile.
pub(crate) fn module_apart(package: &str, manifest: &str) -> Result<Vec<u8>, Failure> {
    built(cargo(&["build", "--locked", "--release", "--manifest-path", manifest]), package, "release", &[])
}

fn built(build: Step, package: &str, profile: &str, more_flags: &[&str]) -> Result<Vec<u8>, Failure> {
    // Panics name the files of the source: without the folders of this machine.
    let mut flags = vec![format!("--remap-path-prefix={}=luenberger", root().display())];
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".cargo")));
    for registry in home.iter().filter_map(|home| fs::read_dir(home.join("registry/src")).ok()).flatten().flatten() {
        flags.push(format!("--remap-path-prefix={}=crates", registry.path().display()));
    }
    flags.extend(more_flags.iter().map(|flag| (*flag).to_owned()));
    let build = build.arguments(&["--target", TARGET, "--target-dir"]).argument(target());
    build.variable("CARGO_ENCODED_RUSTFLAGS", &flags.join("\u{1f}")).step("module")?;
    let file = target().join(TARGET).join(profile).join(format!("{}.wasm", package.replace('-', "_")));
    fs::read(&file).map_err(|source| Failure::io(file, source))
}

/// gzip, which browsers decompress.
pub(crate) fn gzip(module: &[u8]) -> Result<Vec<u8>, Failure> {
    let mut packed = Vec::new();
    let packing = zopfli::compress(zopfli::Options::default(), zopfli::Format::Gzip, module, &mut packed);
    packing.map_err(|source| Failure::io("module", source))?;
    Ok(packed)
}

/// LZMA, a quarter smaller, which a browser decompresses by a module of its own.
pub(crate) fn lzma(module: &[u8]) -> Result<Vec<u8>, Failure> {
    // Instructions have no alignment, and the dictionary need not be larger than the module.
    let options = LzmaOptions { dict_size: 1 << 24, pb: 0, ..LzmaOptions::with_preset(9) };
    let packing = LzmaWriter::new_use_header(Vec::new(), &options, Some(module.len() as u64));
    let packing = packing.and_then(|mut packing| packing.write_all(module).and_then(|()| packing.finish()));
    packing.map_err(|source| Failure::io("module", source))
}

/// base64, in lines of 120 letters.
pub(crate) fn lines(packed: &[u8]) -> String {
    let letters = STANDARD.encode(packed);
    let lines: Vec<&str> =
        (0..letters.len()).step_by(120).map(|at| &letters[at..letters.len().min(at + 120)]).collect();
    lines.join("\n") + "\n"
}

/// Writes the digest of a module into the page beside it.
pub(crate) fn digest(page: &str, module: &[u8]) -> Result<(), Failure> {
    let at = root().join(page);
    let text = fs::read_to_string(&at).map_err(|source| Failure::io(&at, source))?;
    let new = format!("{:x}", Sha256::digest(module));
    let is_digest = |word: &&str| word.len() == 64 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let old = text.split(|c: char| !c.is_ascii_alphanumeric()).find(is_digest).unwrap_or_default();
    let text = if old.is_empty() { text } else { text.replace(old, &new) };
    fs::write(&at, text).map_err(|source| Failure::io(at, source))
}

/// The sections of a module, each with its number.
fn sections(module: &[u8]) -> Vec<(u8, &[u8])> {
    let mut rest = module.get(8..).unwrap_or_default();
    let mut found = Vec::new();
    while let Some((&number, after)) = rest.split_first() {
        let Some((length, after)) = number_of(after) else { break };
        let Some((content, after)) = after.split_at_checked(length) else { break };
        found.push((number, content));
        rest = after;
    }
    found
}

/// A number in LEB128, and what follows it.
fn number_of(bytes: &[u8]) -> Option<(usize, &[u8])> {
    let mut number = 0;
    for (place, byte) in bytes.iter().enumerate().take(5) {
        number |= usize::from(byte & 127) << (7 * place);
        if byte & 128 == 0 {
            return Some((number, &bytes[place + 1..]));
        }
    }
    None
}

/// A text with its length in front, and what follows it.
fn text_of(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = number_of(bytes)?;
    rest.split_at_checked(length)
}

/// The module without the names of its functions and other sections that do not run.
pub(crate) fn stripped(module: &[u8]) -> Vec<u8> {
    let mut bytes = module.get(..8).unwrap_or_default().to_vec();
    for (number, content) in sections(module).into_iter().filter(|(number, _)| *number != 0) {
        bytes.push(number);
        let mut length = content.len();
        while length >= 128 {
            bytes.push(length as u8 | 128);
            length >>= 7;
        }
        bytes.push(length as u8);
        bytes.extend(content);
    }
    bytes
}

/// Bytes of the functions of each crate, by the names of a module that is not stripped, and of its data; the largest
/// first.
pub(crate) fn sizes(module: &[u8]) -> Vec<(String, usize)> {
    let sections = sections(module);
    let of = |wanted: u8| sections.iter().find(|(number, _)| *number == wanted).map(|(_, content)| *content);
    let imported = of(2).and_then(number_of).map_or(0, |(count, _)| count);
    let names = sections.iter().find_map(|(number, content)| {
        let (name, rest) = text_of(content).filter(|_| *number == 0)?;
        (name == b"name").then(|| function_names(rest))
    });
    let names = names.unwrap_or_default();
    let mut sizes: BTreeMap<String, usize> = BTreeMap::new();
    let mut bodies = of(10).and_then(number_of).map(|(_, rest)| rest).unwrap_or_default();
    let mut index = imported;
    while let Some((body, rest)) = text_of(bodies) {
        let name = names.get(&index).map_or("", String::as_str);
        *sizes.entry(crate_of(name)).or_default() += body.len();
        (bodies, index) = (rest, index + 1);
    }
    sizes.insert("data".to_owned(), of(11).map_or(0, <[u8]>::len));
    let mut sizes: Vec<(String, usize)> = sizes.into_iter().collect();
    sizes.sort_by_key(|(_, size)| std::cmp::Reverse(*size));
    sizes
}

/// The names of functions in the section of names.
fn function_names(mut rest: &[u8]) -> BTreeMap<usize, String> {
    let mut names = BTreeMap::new();
    while let Some((&kind, after)) = rest.split_first() {
        let Some((content, after)) = text_of(after) else { break };
        rest = after;
        if kind != 1 {
            continue;
        }
        let Some((count, mut entries)) = number_of(content) else { break };
        for _ in 0..count {
            let Some((index, after)) = number_of(entries) else { break };
            let Some((name, after)) = text_of(after) else { break };
            names.insert(index, String::from_utf8_lossy(name).into_owned());
            entries = after;
        }
    }
    names
}

/// The crate that a function is of: of a generic one the first crate in its name that is not of the standard library.
fn crate_of(name: &str) -> String {
    let path = path_of(name);
    let words = path.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != ':');
    let crates = words.filter_map(|word| word.split_once("::")).map(|(first, _)| first.trim_start_matches('_'));
    let own = crates.filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase()));
    let mut first = None;
    for word in own {
        if !["core", "alloc", "std"].contains(&word) {
            return word.to_owned();
        }
        first.get_or_insert(word);
    }
    first.unwrap_or("other").to_owned()
}

/// The path in the name of a symbol, each of whose parts has its length in front: `_ZN3std2io..E`.
fn path_of(name: &str) -> String {
    let Some(mut rest) = name.strip_prefix("_ZN") else { return name.to_owned() };
    let mut parts = Vec::new();
    while let Some(end) = rest.find(|c: char| !c.is_ascii_digit()).filter(|end| *end > 0) {
        let (length, after) = rest.split_at(end);
        let Some((part, after)) = length.parse().ok().and_then(|length| after.split_at_checked(length)) else { break };
        parts.push(part);
        rest = after;
    }
    let escapes = [("$LT$", "<"), ("$GT$", ">"), ("$u20$", " "), ("$C$", ","), ("$RF$", "&"), ("..", "::")];
    escapes.iter().fold(parts.join("::"), |path, (escape, letter)| path.replace(escape, letter))
}
