//! The WebAssembly module of reports: built, packed, and compared in a browser with the results of this machine.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::step::{Failure, build, build_command, built, is_installed, luenberger, reproduction, root, target};
use crate::wasm;

// The file needs no other, and the crate would be a long build.
#[path = "../../crates/figures/src/base85.rs"]
#[allow(dead_code, unreachable_pub, reason = "it is the module of another crate")]
mod base85;

const ASSET: &str = "crates/live/assets/luenberger-live.wasm.gz.base64";
const README: &str = "crates/live/assets/README.md";
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Templates whose reports are opened, and the positions of the sliders that are tried in each: gain, cubic, noise,
/// error, period.
const REPORTS: [&str; 7] = ["double-integrator", "duffing", "chaotic", "cuk", "mimo", "servo", "two-tanks"];
const POSITIONS: [[f64; 5]; 7] = [
    [1.0, 1.0, 1.0, 1.0, 1.0],
    [2.0, 1.0, 1.0, 1.0, 1.0],
    [0.5, 0.0, 2.0, 3.0, 1.0],
    [1.0, 4.0, 0.0, 0.25, 2.0],
    [8.0, 16.0, 5.0, 5.0, 0.125],
    // Beyond the bounds of a certificate that supposes some.
    [1.0, 1.0, 5.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, 5.0, 1.0],
];

/// A plant in discrete time that is not the model, with dropouts, a change and a law of a filter's estimate.
const DISCRETE: &str = r#"
title = "A drive in discrete time"
[plant]
states = ["angle", "speed"]
inputs = ["voltage"]
outputs = ["encoder"]
a = [[1, 0.0906], [0, 0.8187]]
b = [[0.0234], [0.4532]]
c = [[1, 0]]
dt = 0.1
units = { angle = "rad", speed = "rad/s", voltage = "V", encoder = "rad" }
time_unit = "s"
[input]
expressions = ["0.5"]
feedback = { k = [[0.5, 0.2]], observer = "filter" }
[simulation]
x0 = [1, -1]
duration = 20
scale = [1, 1]
noise = { amplitude = [0.02], period = 0.1, seed = 2 }
[truth]
a = [[1, 0.09], [0, 0.8]]
dropout = 0.1
[[truth.event]]
at = 10
jump = [0.5, 0]
[[observer]]
name = "Luenberger"
kind = "luenberger"
poles = [0.4, 0.6]
[[observer]]
name = "filter"
kind = "kalman"
form = "filter"
w = 0.001
v = 0.0004
[[observer]]
name = "EKF"
kind = "extended-kalman"
w = 0.001
v = 0.0004
period = 0.1
"#;

/// The most bytes of a report. The module with which it verifies itself is two fifths of that; it has the evaluator of
/// labels since facts are decided as they read, and the extended Kalman filter of unit vectors, which is that of all.
const LARGEST: usize = 1_560_000;

/// Builds the module. With `check` the committed one stays, and both have to give the results of this machine.
pub(crate) fn run(check: bool) -> Result<(), Failure> {
    let Some(module) = wasm::module("luenberger-live", "live", &["--no-default-features"], &[])? else {
        eprintln!("── NOT RUN: the module of reports (rustup target add {})", wasm::TARGET);
        return Ok(());
    };
    let packed = wasm::lines(&wasm::gzip(&module)?);
    let at = root().join(ASSET);
    let committed = fs::read_to_string(&at).unwrap_or_default();
    if !check && packed != committed {
        fs::write(&at, &packed).map_err(|source| Failure::io(&at, source))?;
        wasm::digest(README, &module)?;
        eprintln!("── {ASSET}: {} bytes, {} packed", module.len(), packed.len());
    }
    let Some(browser) = browser("the module in a browser") else { return Ok(()) };
    build_command()?;
    build("luenberger-live", "--example", "native")?;
    let both = [("built", packed.as_str()), ("committed", committed.as_str())];
    let modules = if check { &both[..] } else { &both[..1] };
    for name in REPORTS {
        compare(browser, name, &of_template(name)?, modules)?;
    }
    compare(browser, "discrete", &of_text("discrete", DISCRETE)?, modules)?;
    let papers = target().join("live/papers");
    reproduction(&papers)?.quiet_output("papers")?;
    compare(browser, "papers", &papers.join("report.html"), modules)
}

/// A browser, if one is installed; otherwise says `what` is not run.
pub(crate) fn browser(what: &str) -> Option<&'static str> {
    let found = BROWSERS.into_iter().find(|name| is_installed(name));
    if found.is_none() {
        eprintln!("── NOT RUN: {what} (one of {} is needed)", BROWSERS.join(", "));
    }
    found
}

/// The report of a template.
pub(crate) fn of_template(name: &str) -> Result<PathBuf, Failure> {
    let folder = folder(name)?;
    let new = luenberger(&["new", "--force", "--plant", name, "-o"]);
    new.argument(folder.join("study.toml")).quiet_output("new")?;
    report(&folder)
}

/// The report of a study in text.
fn of_text(name: &str, text: &str) -> Result<PathBuf, Failure> {
    let folder = folder(name)?;
    let study = folder.join("study.toml");
    fs::write(&study, text).map_err(|source| Failure::io(&study, source))?;
    report(&folder)
}

fn folder(name: &str) -> Result<PathBuf, Failure> {
    let folder = target().join("live").join(name);
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    Ok(folder)
}

/// The report of the study in a folder.
fn report(folder: &Path) -> Result<PathBuf, Failure> {
    let results = folder.join("results");
    let run = luenberger(&["run", "--force", "-o"]).argument(&results).argument(folder.join("study.toml"));
    run.quiet_output("run")?;
    Ok(results.join("report.html"))
}

/// Opens a report with each module and compares what its page computes with this machine's results.
fn compare(browser: &str, name: &str, page: &Path, modules: &[(&str, &str)]) -> Result<(), Failure> {
    let failed = |what: String| Failure::Live(format!("{name}: {what}"));
    let html = fs::read_to_string(page).map_err(|source| Failure::io(page, source))?;
    let mut expected: Vec<Vec<Value>> = Vec::new();
    // The experiments of the page, in its order.
    for part in html.split("<script type=\"application/json\" id=\"live").skip(1) {
        let data = part.split_once("-data\">").and_then(|(_, rest)| rest.split_once("</script>"));
        let (data, _) = data.ok_or_else(|| failed("a block without data".to_owned()))?;
        let data: Value = serde_json::from_str(data).map_err(|error| failed(error.to_string()))?;
        expected.push(native(&data["experiment"])?);
    }
    // The letters that a page has are in base 85.
    let embedded = html.split_once("id=\"live-module\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let (embedded, _) = embedded.ok_or_else(|| failed("no module".to_owned()))?;
    let script = format!("<script>{}</script></body>", SCRIPT.replace("POSITIONS", &json!(POSITIONS).to_string()));
    for (which, module) in modules {
        let page = page.with_file_name(format!("test-{which}.html"));
        let module = STANDARD.decode(module.replace('\n', "")).map_err(|error| failed(error.to_string()))?;
        let test = html.replace(embedded, &base85::encode(&module)).replace("</body>", &script);
        fs::write(&page, test).map_err(|source| Failure::io(&page, source))?;
        for (width, dark) in [(800, false), (1400, true)] {
            let found = browse(browser, &page, width, dark)?;
            let found: Value = serde_json::from_str(&found).map_err(|_| failed(format!("the page says: {found}")))?;
            for (what, wanted) in [
                ("errors", json!([])),
                ("wide", json!([])),
                ("dark", json!(dark)),
                ("moved", json!(true)),
                ("badges", json!([])),
            ] {
                if found[what] != wanted {
                    return Err(failed(format!("{which} module, {width} px, {what}: {}", found[what])));
                }
            }
            let results = found["results"].as_array().map_or(&[][..], Vec::as_slice);
            if results.len() != expected.len() {
                return Err(failed(format!("{} of {} blocks ran", results.len(), expected.len())));
            }
            for (k, (found, expected)) in results.iter().zip(&expected).enumerate() {
                let found = found.as_array().map_or(&[][..], Vec::as_slice);
                let other = POSITIONS.iter().enumerate().find(|(i, _)| found.get(*i) != expected.get(*i));
                if let Some((_, position)) = other {
                    let what = format!("block {}: other results at {position:?}, {which} module", k + 1);
                    return Err(failed(what));
                }
            }
        }
    }
    let pdf = page.with_extension("pdf");
    let to = format!("--print-to-pdf={}", pdf.display());
    chromium(browser, &[&to], page)?;
    let printed = fs::metadata(&pdf).map_or(0, |file| file.len());
    if printed < 20_000 {
        return Err(failed(format!("printed, the report has {printed} bytes")));
    }
    if html.len() > LARGEST {
        return Err(failed(format!("the report has {} bytes, more than {LARGEST}", html.len())));
    }
    eprintln!(
        "── {name}: {} x {} positions of the sliders, the same bits; page of {} bytes",
        expected.len(),
        POSITIONS.len(),
        html.len()
    );
    Ok(())
}

/// What this machine computes.
fn native(experiment: &Value) -> Result<Vec<Value>, Failure> {
    let sliders: Vec<Value> = POSITIONS
        .iter()
        .map(|[gain, cubic, noise, error, period]| {
            json!({ "gain": gain, "cubic": cubic, "noise": noise, "error": error, "period": period })
        })
        .collect();
    let at = built("examples/native");
    let io = |source| Failure::io(&at, source);
    let mut child = Command::new(&at).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(io)?;
    let request = json!({ "experiment": experiment, "sliders": sliders }).to_string();
    if let Some(mut input) = child.stdin.take() {
        input.write_all(request.as_bytes()).map_err(io)?;
    }
    let output = child.wait_with_output().map_err(io)?;
    serde_json::from_slice(&output.stdout).map_err(|error| Failure::Live(format!("results of this machine: {error}")))
}

/// The page with its scripts run, as the browser has it.
pub(crate) fn chromium(browser: &str, arguments: &[&str], page: &Path) -> Result<String, Failure> {
    let url = format!("file://{}", page.display());
    let quiet = ["--headless=new", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=120000", "--timeout=120000"];
    let mut command = Command::new(browser);
    let output = command.args(quiet).args(arguments).arg(url).stderr(Stdio::null()).output();
    let output = output.map_err(|source| Failure::io(browser, source))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What the script of the test left in the page.
fn browse(browser: &str, page: &Path, width: u32, dark: bool) -> Result<String, Failure> {
    let size = format!("--window-size={width},1000");
    // 0 is dark.
    let scheme = format!("--blink-settings=preferredColorScheme={}", u8::from(!dark));
    let dom = chromium(browser, &["--dump-dom", &size, &scheme], page)?;
    let found = dom.split_once("id=\"test-result\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let found = found.map_or("nothing", |(found, _)| found);
    Ok(found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
}

/// Runs the positions of the sliders in the page and writes what it found into it.
const SCRIPT: &str = include_str!("live.js");
