//! The module and the page of the studio: built, packed, its files compared in node with those of the command, and the
//! page used in a browser.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::live::{browser, chromium};
use crate::step::{Failure, build_command, is_installed, luenberger, program, root, target};
use crate::wasm;

const ASSET: &str = "crates/studio/assets/luenberger-studio.wasm.lzma.base64";
/// What decompresses it in the page.
const UNPACK: &str = "crates/studio/assets/luenberger-unpack.wasm.gz.base64";
const README: &str = "crates/studio/assets/README.md";

/// The stack of the module: that of the first thread of a program, where WebAssembly has an eighth.
const STACK: &str = "-Clink-arg=-zstack-size=8388608";

/// The most bytes of the module, compressed: code of study, observers, design and proof, the plotting library and the
/// module of reports, and a font.
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
    let packed = wasm::lzma(&module)?;
    report(&named, module.len(), packed.len());
    if packed.len() > LARGEST {
        return Err(Failure::Live(format!("the module has {} bytes, compressed: more than {LARGEST}", packed.len())));
    }
    let unpack = wasm::module_apart("luenberger-unpack", "crates/studio/unpack/Cargo.toml")?;
    for (asset, packed) in [(UNPACK, wasm::gzip(&unpack)?), (ASSET, packed)] {
        let text = wasm::lines(&packed);
        if !check && fs::read_to_string(root().join(asset)).unwrap_or_default() != text {
            fs::write(root().join(asset), &text).map_err(|source| Failure::io(asset, source))?;
        }
    }
    if !check {
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

/// Runs templates by the command and by the module, and compares what they write.
///
/// The same files, the same words and verdicts, the same shapes; numbers up to rounding. The kernels of matrices of
/// this machine add in an order of their own, with instructions that WebAssembly does not have, so that designs differ
/// in their last digits, as they do between machines. Certificates of the module are verified by this machine.
fn compare(folder: &Path, module: &Path, only: &[String]) -> Result<(), Failure> {
    let listed = luenberger(&["new", "--list", "--json"]).quiet_output("new")?;
    let listed: Value = serde_json::from_str(&listed).map_err(failed)?;
    let names = listed["plants"].as_array().into_iter().flatten().filter_map(|plant| plant["name"].as_str());
    let is_wanted = |name: &&str| only.is_empty() || only.iter().any(|one| one == name) || IN_PAGE.contains(name);
    let names: Vec<&str> = names.filter(is_wanted).collect();
    let out = folder.join("module");
    _ = fs::remove_dir_all(&out);
    let mut node = program("node").argument(root().join("xtask/src/studio-node.mjs")).argument(module).argument(&out);
    for name in &names {
        let own = folder.join(name);
        fs::create_dir_all(&own).map_err(|source| Failure::io(&own, source))?;
        let study = own.join("study.toml");
        luenberger(&["new", "--force", "--plant", name, "-o"]).argument(&study).quiet_output("new")?;
        let results = own.join("results");
        luenberger(&["run", "--force", "-q", "-o"]).argument(&results).argument(&study).quiet_output("run")?;
        node = node.argument(&study);
    }
    let printed = node.output("module over the templates")?;
    let mut wrong = Vec::new();
    for line in printed.lines() {
        let line: Value = serde_json::from_str(line).map_err(failed)?;
        let name = line["name"].as_str().unwrap_or_default();
        if let Some(error) = line["error"].as_str() {
            wrong.push(format!("{name}: {error}"));
            continue;
        }
        let (theirs, ours) = (files(&folder.join(name).join("results"))?, files(&out.join(name))?);
        let differences = differences(name, &theirs, &ours);
        wrong.extend(differences.wrong);
        let seconds = line["seconds"].as_f64().unwrap_or(f64::NAN);
        let memory = line["memory"].as_f64().unwrap_or(f64::NAN) / f64::from(1 << 20);
        let (all, same, largest) = (theirs.len(), differences.same, differences.largest);
        eprintln!(
            "── {name}: {same} of {all} files are the same bytes, numbers of the others within {largest:.0e}; \
             {seconds:.1} s, {memory:.0} MiB"
        );
        for file in ours.keys().filter(|file| file.starts_with("certificates/")) {
            luenberger(&["verify"]).argument(out.join(name).join(file)).quiet_output("verify")?;
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(failed(wrong.join("; "))) }
}

fn failed(what: impl std::fmt::Display) -> Failure {
    Failure::Live(format!("the studio: {what}"))
}

/// Numbers may differ by this part of the largest number beside them.
const ROUNDING: f64 = 1e-4;

/// Numbers below are rounding errors of zero.
const ZERO: f64 = 1e-12;

/// How two results folders differ.
#[derive(Default)]
struct Differences {
    /// What is more than rounding.
    wrong: Vec<String>,
    /// Files with the same bytes.
    same: usize,
    /// The largest difference of numbers, relative to the largest number beside them.
    largest: f64,
}

fn differences(name: &str, theirs: &BTreeMap<String, Vec<u8>>, ours: &BTreeMap<String, Vec<u8>>) -> Differences {
    let mut found = Differences::default();
    if !theirs.keys().eq(ours.keys()) {
        found.wrong.push(format!("{name} has other files"));
    }
    for (file, bytes) in theirs {
        let Some(own) = ours.get(file) else { continue };
        if own == bytes {
            found.same += 1;
            continue;
        }
        let read = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).ok();
        // Digests of files that differ do so themselves; certificates have their numbers as texts.
        if let (Some(one), Some(other), true) = (read(bytes), read(own), file == "study.json") {
            found.compare(&format!("{name}: {file}"), &one, &other, size(&one));
        }
    }
    found
}

/// The largest number of a list of numbers, or of a list of such lists.
fn size(value: &Value) -> f64 {
    match value {
        Value::Number(number) => number.as_f64().unwrap_or(0.0).abs(),
        Value::Array(list) => list.iter().map(size).fold(0.0, f64::max),
        _ => 0.0,
    }
}

impl Differences {
    fn compare(&mut self, at: &str, one: &Value, other: &Value, scale: f64) {
        match (one, other) {
            (Value::Number(x), Value::Number(y)) => {
                let (x, y) = (x.as_f64().unwrap_or(f64::NAN), y.as_f64().unwrap_or(f64::NAN));
                let difference = if x == y { 0.0 } else { (x - y).abs() / scale.max(x.abs()).max(y.abs()) };
                // What is zero but for rounding has no digits to compare.
                if x.abs().max(y.abs()) < ZERO {
                    return;
                }
                self.largest = self.largest.max(difference);
                if difference.is_nan() || difference > ROUNDING {
                    self.wrong.push(format!("{at}: {x} and {y}"));
                }
            }
            (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
                let scale = scale.max(one.iter().map(size).fold(0.0, f64::max));
                for (k, (one, other)) in one.iter().zip(other).enumerate() {
                    self.compare(&format!("{at}/{k}"), one, other, if one.is_object() { 0.0 } else { scale });
                }
            }
            (Value::Object(one), Value::Object(other)) if one.keys().eq(other.keys()) => {
                for ((key, one), other) in one.iter().zip(other.values()) {
                    self.compare(&format!("{at}/{key}"), one, other, 0.0);
                }
            }
            _ if one == other => {}
            _ => self.wrong.push(format!("{at}: {one} and {other}")),
        }
    }
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

/// What a script of the test left in an element of the page.
fn left(dom: &str, id: &str) -> Result<Value, Failure> {
    let found = dom.split_once(&format!("id=\"{id}\">")).and_then(|(_, rest)| rest.split_once("</pre>"));
    let found = found.map_or("nothing", |(found, _)| found);
    let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&found).map_err(|_| failed(format!("{id} has {found}")))
}

/// Whether a file of a study's folder is data beside it.
fn is_table(file: &str) -> bool {
    !file.contains('/') && Path::new(file).extension().is_some_and(|extension| extension == "csv")
}

/// Templates that the page runs too.
const IN_PAGE: [&str; 2] = ["double-integrator", "measured-log"];

/// Whether the page computed the bits that node did: of trajectories and certificates, which do not depend on the
/// options of the run.
fn same_bits(name: &str, digests: &Value, files: &BTreeMap<String, Vec<u8>>) -> Result<(), Failure> {
    let is_compared = |file: &str| file.starts_with("trajectories/") || file.starts_with("certificates/");
    for (file, bytes) in files.iter().filter(|(file, _)| is_compared(file)) {
        if digests[file] != format!("{:x}", Sha256::digest(bytes)) {
            return Err(failed(format!("{name}: {file} has other bits in the page than in node")));
        }
    }
    Ok(())
}

/// The test of the JavaScript package, with this module.
fn package(module: &Path) -> Result<(), Failure> {
    let test = root().join("crates/studio/npm/test.mjs");
    program("node").argument(test).argument(module).step("npm package")
}

/// Uses the page in a browser, at several widths, in light and dark.
fn page(folder: &Path) -> Result<(), Failure> {
    let Some(browser) = browser("the page of the studio in a browser") else { return Ok(()) };
    let written = folder.join("studio.html");
    luenberger(&["studio", "--force", "-o"]).argument(&written).quiet_output("studio")?;
    let html = fs::read_to_string(&written).map_err(|source| Failure::io(&written, source))?;
    let mut studies = Vec::new();
    for name in IN_PAGE {
        let own = folder.join(name);
        let text = fs::read_to_string(own.join("study.toml")).map_err(|source| Failure::io(&own, source))?;
        let data = files(&own)?.into_iter().filter(|(file, _)| is_table(file));
        let data: BTreeMap<String, String> =
            data.map(|(file, bytes)| (file, String::from_utf8_lossy(&bytes).into_owned())).collect();
        studies.push(json!({ "name": name, "text": text, "files": data }));
    }
    let studies = json!(studies).to_string().replace("</", "<\\/");
    let script = format!(
        "<script>{}</script><script>const STUDIES = {studies};\n{}</script></body>",
        include_str!("studio.js"),
        include_str!("studio-bits.js")
    );
    let test = folder.join("test.html");
    let at = html.rfind("</body>").ok_or_else(|| failed("it has no end"))?;
    fs::write(&test, format!("{}{script}{}", &html[..at], &html[at + "</body>".len()..]))
        .map_err(|source| Failure::io(&test, source))?;
    for (width, dark) in [(800, false), (1400, true)] {
        let size = format!("--window-size={width},1000");
        let scheme = format!("--blink-settings=preferredColorScheme={}", u8::from(!dark));
        let dom = chromium(browser, &["--dump-dom", &size, &scheme], &test)?;
        let (found, bits) = (left(&dom, "test-result")?, left(&dom, "test-bits")?);
        for what in ["errors", "requests", "wide", "wrong"] {
            if found[what].as_array().is_none_or(|list| !list.is_empty()) {
                return Err(failed(format!("{width} px, {what}: {}", found[what])));
            }
        }
        for name in IN_PAGE {
            same_bits(name, &bits[name], &files(&folder.join("module").join(name))?)?;
        }
        eprintln!("── the page at {width} px, {}: as it should be", if dark { "dark" } else { "light" });
    }
    Ok(())
}
