//! The module and the page of the studio: built, packed, its files compared in node with those of the command, and the page
//! used in a browser.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::live::{browser, chromium};
use crate::step::{Failure, build_command, is_installed, luenberger, program, root, target};
use crate::wasm;

const ASSET: &str = "crates/studio/assets/luenberger-studio.wasm.gz.base64";
const README: &str = "crates/studio/assets/README.md";

/// The stack of the module: that of the first thread of a program, where WebAssembly has an eighth.
const STACK: &str = "-Clink-arg=-zstack-size=8388608";

/// The most bytes of the module, compressed.
const LARGEST: usize = 4_000_000;

/// A crate with fewer bytes is counted with the others.
const SMALL: usize = 50_000;

/// Builds the module, and tries it over these templates, or all.
pub(crate) fn run(check: bool, only: &[String]) -> Result<(), Failure> {
    let Some(named) = wasm::module("luenberger-studio", "studio", &["--no-default-features"], &[STACK])? else {
        eprintln!("── NOT RUN: the module of the studio (rustup target add {})", wasm::TARGET);
        return Ok(());
    };
    let module = wasm::stripped(&named);
    let folder = target().join("studio");
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    let at = folder.join("luenberger_studio.wasm");
    fs::write(&at, &module).map_err(|source| Failure::io(&at, source))?;
    let packed = wasm::pack(&module)?;
    let bytes = STANDARD.decode(packed.replace('\n', "")).map_or(0, |bytes| bytes.len());
    report(&named, module.len(), bytes);
    if bytes > LARGEST {
        return Err(Failure::Live(format!("the module has {bytes} bytes, compressed: more than {LARGEST}")));
    }
    if !check && fs::read_to_string(root().join(ASSET)).unwrap_or_default() != packed {
        fs::write(root().join(ASSET), &packed).map_err(|source| Failure::io(ASSET, source))?;
        wasm::digest(README, &module)?;
    }
    build_command()?;
    if is_installed("node") {
        compare(&folder, &at, only)?;
        package(&at)?;
    } else {
        eprintln!("── NOT RUN: the module over the templates (node is needed)");
    }
    page(&folder)
}

/// What the module is made of.
fn report(named: &[u8], bytes: usize, packed: usize) {
    eprintln!("── the module: {bytes} bytes, {packed} compressed");
    let mut others = 0;
    for (name, size) in wasm::sizes(named) {
        if size < SMALL {
            others += size;
        } else {
            eprintln!("── {size:>9}  {name}");
        }
    }
    eprintln!("── {others:>9}  others");
}

/// Runs templates by the command and by the module, and compares the files.
fn compare(folder: &Path, module: &Path, only: &[String]) -> Result<(), Failure> {
    let failed = |what: String| Failure::Live(format!("the studio: {what}"));
    let listed = luenberger(&["new", "--list", "--json"]).quiet_output("new")?;
    let listed: Value = serde_json::from_str(&listed).map_err(|error| failed(error.to_string()))?;
    let names = listed["plants"].as_array().into_iter().flatten().filter_map(|plant| plant["name"].as_str());
    let names: Vec<&str> = names.filter(|name| only.is_empty() || only.iter().any(|one| one == name)).collect();
    let out = folder.join("module");
    _ = fs::remove_dir_all(&out);
    let mut node = program("node").argument(root().join("xtask/src/studio-node.mjs")).argument(module).argument(&out);
    for name in &names {
        let own = folder.join(name);
        fs::create_dir_all(&own).map_err(|source| Failure::io(&own, source))?;
        let study = own.join("study.toml");
        luenberger(&["new", "--force", "--plant", name, "-o"]).argument(&study).quiet_output("new")?;
        let results = own.join("results");
        // An observer that does not apply is a result; the module says so too.
        _ = luenberger(&["run", "--force", "-q", "-o"]).argument(&results).argument(&study).quiet_output("run");
        node = node.argument(&study);
    }
    let printed = node.output("module over the templates")?;
    let mut differ = Vec::new();
    for line in printed.lines() {
        let line: Value = serde_json::from_str(line).map_err(|error| failed(error.to_string()))?;
        let name = line["name"].as_str().unwrap_or_default();
        let seconds = line["seconds"].as_f64().unwrap_or(f64::NAN);
        let memory = line["memory"].as_f64().unwrap_or(f64::NAN) / f64::from(1 << 20);
        if let Some(error) = line["error"].as_str() {
            eprintln!("── {name}: {error}");
            differ.push(name.to_owned());
            continue;
        }
        let (theirs, ours) = (files(&folder.join(name).join("results"))?, files(&out.join(name))?);
        let every: std::collections::BTreeSet<&String> = theirs.keys().chain(ours.keys()).collect();
        let other: Vec<&str> =
            every.iter().filter(|file| theirs.get(**file) != ours.get(**file)).map(|file| file.as_str()).collect();
        let (all, same) = (every.len(), every.len() - other.len());
        eprintln!("── {name}: {same} of {all} files the same, {seconds:.1} s, {memory:.0} MiB");
        if !other.is_empty() {
            eprintln!("──   others: {}", other.join(" "));
            differ.push(name.to_owned());
        }
    }
    if differ.is_empty() { Ok(()) } else { Err(failed(format!("other files of {}", differ.join(", ")))) }
}

/// The files below a folder, but for hidden ones.
fn files(root: &Path) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
    let mut found = BTreeMap::new();
    let mut open: Vec<PathBuf> = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        let failed = |source| Failure::io(&folder, source);
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            if path.is_dir() {
                open.push(path);
            } else if !name.starts_with('.') {
                let bytes = fs::read(&path).map_err(|source| Failure::io(&path, source))?;
                found.insert(name, bytes);
            }
        }
    }
    Ok(found)
}

/// The test of the JavaScript package, with this module.
fn package(module: &Path) -> Result<(), Failure> {
    let test = root().join("crates/studio/npm/test.mjs");
    program("node").argument(test).argument(module).step("npm package")
}

/// Uses the page in a browser, at several widths, in light and dark.
fn page(folder: &Path) -> Result<(), Failure> {
    let Some(browser) = browser("the page of the studio in a browser") else { return Ok(()) };
    let failed = |what: String| Failure::Live(format!("the page of the studio: {what}"));
    let written = folder.join("studio.html");
    luenberger(&["studio", "--force", "-o"]).argument(&written).quiet_output("studio")?;
    let html = fs::read_to_string(&written).map_err(|source| Failure::io(&written, source))?;
    let script = format!("<script>{}</script></body>", include_str!("studio.js"));
    let test = folder.join("test.html");
    let at = html.rfind("</body>").ok_or_else(|| failed("it has no end".to_owned()))?;
    fs::write(&test, format!("{}{script}{}", &html[..at], &html[at + "</body>".len()..]))
        .map_err(|source| Failure::io(&test, source))?;
    for (width, dark) in [(800, false), (1400, true)] {
        let size = format!("--window-size={width},1000");
        let scheme = format!("--blink-settings=preferredColorScheme={}", u8::from(!dark));
        let dom = chromium(browser, &["--dump-dom", &size, &scheme], &test)?;
        let found = dom.split_once("id=\"test-result\">").and_then(|(_, rest)| rest.split_once("</pre>"));
        let found = found.map_or("nothing", |(found, _)| found);
        let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
        let found: Value = serde_json::from_str(&found).map_err(|_| failed(format!("it says: {found}")))?;
        for what in ["errors", "requests", "wide", "wrong"] {
            if found[what].as_array().is_none_or(|list| !list.is_empty()) {
                return Err(failed(format!("{width} px, {what}: {}", found[what])));
            }
        }
        eprintln!("── the page at {width} px, {}: as it should be", if dark { "dark" } else { "light" });
    }
    Ok(())
}
