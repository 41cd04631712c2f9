//! The report in a browser: no error on the console, and every figure drawn.

use std::path::Path;
use std::process::{Command, Stdio};

use luenberger_study::{RunOptions, Study, run};

use crate::studies::scratch;

/// A headless Chromium, if there is one.
fn browser() -> Option<&'static str> {
    let starts = |name: &&str| {
        let started = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        started.is_ok_and(|status| status.success())
    };
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(starts)
}

fn every_figure_is_drawn(template: &str) {
    let Some(browser) = browser() else {
        println!("no Chromium is installed: the report of {template} was not opened in a browser");
        return;
    };
    let folder = scratch(&format!("browser/{template}"));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates").join(format!("{template}.toml"));
    let study = Study::from_path(&file).unwrap_or_else(|error| panic!("{error}"));
    run(&study, &RunOptions { output: Some(folder.clone().into()), ..RunOptions::default() }).unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        // Virtual time of the page, so that timers finish at once.
        .args(["--virtual-time-budget=20000", "--window-size=1400,3000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", folder.join("report.html").display()))
        .output()
        .unwrap();
    // The browser's own messages appear there as well; those of the page have its source.
    let log = String::from_utf8_lossy(&output.stderr);
    let said: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(said.is_empty(), "{template}: the page said {said:#?}");
    let page = String::from_utf8_lossy(&output.stdout);
    let places: Vec<&str> = page.split("data-picture=\"").skip(1).collect();
    assert!(!places.is_empty(), "{template}: the page declares no figure");
    for place in places {
        let name = place.split('"').next().unwrap_or_default();
        assert!(place.contains("class=\"main-svg\""), "{template}: the figure `{name}` is not drawn");
    }
}

#[test]
fn the_double_integrator_is_drawn() {
    every_figure_is_drawn("double-integrator");
}

#[test]
fn the_motor_on_the_bench_is_drawn() {
    every_figure_is_drawn("measured-log");
}
