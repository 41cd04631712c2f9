//! `luenberger tune` with outputs that are measured late.

use std::fmt::Write;
use std::path::Path;

use luenberger_random::Random;
use luenberger_study::tune::{TuneOptions, TuneReport, tune};
use luenberger_study::{Format, Study};

use crate::studies::{mistakes_of, scratch, study_in};

#[track_caller]
fn tuned(folder: &Path, text: &str) -> TuneReport {
    tune(&study_in(folder, text), &TuneOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn study(plant: &str, log: &str, tune: &str) -> String {
    format!(
        "[plant]\nstates = [\"position\", \"speed\"]\ninputs = [\"force\"]\noutputs = [\"fix\", \"gyro\"]\nf = [\"speed\", \"force - 0.4*speed - position\"]\nh = [\"position\", \"speed\"]\n{plant}\n[log]\n{log}\n[[observer]]\nname = \"filter\"\nkind = \"extended-kalman\"\ninitial = [0, 0]\np0 = [0.1, 0.1]\nw = [1e-6, 0.02]\nv = [4e-4, 0.04]\nperiod = 0.1\n[tune]\nobserver = \"filter\"\n{tune}\n"
    )
}

/// One row every 0.1: the force, the true state, and the position at a time `delay` before.
fn rows(count: usize, delay: f64, seed: u64) -> Vec<(f64, f64, f64, f64, [f64; 2])> {
    let mut random = Random(seed);
    // Fine steps of 0.001, so that the past is known at any multiple of them.
    let (mut x, mut past, mut rows) = ([0.0f64, 0.0], Vec::new(), Vec::new());
    for k in 0..count {
        let t = 0.1 * k as f64;
        let force = if (k / 15).is_multiple_of(2) { 1.0 } else { -1.0 };
        past.push(x[0]);
        let back = (delay / 0.001).round() as usize;
        let seen = past.get((past.len() - 1).wrapping_sub(back)).copied().unwrap_or(0.0);
        let ([a, b], [push, _]) = (random.normal_pair(), random.normal_pair());
        rows.push((t, force, seen + 0.02 * a, x[1] + 0.2 * b, x));
        for step in 0..100 {
            let slope = |x: [f64; 2]| [x[1], force + 0.447 * push - 0.4 * x[1] - x[0]];
            let half = slope([x[0] + 5e-4 * slope(x)[0], x[1] + 5e-4 * slope(x)[1]]);
            x = [x[0] + 1e-3 * half[0], x[1] + 1e-3 * half[1]];
            if step < 99 {
                past.push(x[0]);
            }
        }
    }
    rows
}

/// The delay that the log was made with is found, with its error, from a start that is far off.
#[test]
fn a_delay_is_found() {
    let folder = scratch("tune-delay");
    let mut text = "t,force,fix,gyro,position,speed\n".to_owned();
    for (t, force, fix, gyro, x) in rows(900, 0.23, 3) {
        writeln!(text, "{t},{force},{fix},{gyro},{},{}", x[0], x[1]).unwrap();
    }
    std::fs::write(folder.join("log.csv"), text).unwrap();
    let fit = study(
        "delays = { fix = 0.05 }",
        "file = \"log.csv\"\nstates = [\"position\", \"speed\"]",
        "parameters = [\"delay[fix]\", \"v\"]\nbounds = { \"delay[fix]\" = [0, 0.6] }\nstarts = 2\nprofile = 3",
    );
    let report = tuned(&folder, &fit);
    let delay = &report.parameters[0];
    assert_eq!((delay.name.as_str(), report.agreeing), ("delay[fix]", 2));
    let error = delay.standard_error.unwrap();
    assert!((delay.after - 0.23).abs() < 3.0 * error && error < 0.01, "{delay:?}");
    let Some([Some(low), Some(high)]) = delay.profile_interval else { panic!("{delay:?}") };
    assert!(low < 0.23 && 0.23 < high, "{delay:?}");
    assert!(report.study.contains(&format!("delays = {{ fix = {} }}", delay.after)), "{}", report.study);
    assert!(report.study.contains("# luenberger tune: delay[fix] = "), "{}", report.study);
    // The errors on what is held out are those of the filter that gets the fix late: they are less for the right delay.
    let held = report.held_out.unwrap();
    assert_eq!(held.after.errors[0].samples, 270);
    assert!(held.after.errors[0].rms < 0.7 * held.before.errors[0].rms, "{held:?}");
    assert!(held.after.nis.as_ref().unwrap().mean < 1.3, "{held:?}");
}

/// Of late outputs the likelihood is that of the log in which they stand at their times, in continuous and in discrete
/// time; what arrives within the delay after the first row is left out.
#[test]
fn the_likelihood_is_that_of_the_log_in_order() {
    let folder = scratch("tune-delay-order");
    for (delay, dt) in [(0.25, None), (0.2, Some(0.1))] {
        let all = rows(120, delay, 5);
        let (mut late, mut cells) = ("t,force,fix,gyro\n".to_owned(), Vec::new());
        for (k, (t, force, fix, gyro, _)) in all.iter().enumerate() {
            writeln!(late, "{t},{force},{fix},{gyro}").unwrap();
            cells.push((*t, *force, None, Some(*gyro)));
            if *t > delay - 1e-9 {
                let held = all[((t - delay) / 0.1 + 1e-6) as usize].1;
                cells.push((t - delay, held, Some(*fix), None));
            }
            assert!(k < 120);
        }
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        cells.dedup_by(|b, a| {
            let is_one = (a.0 - b.0).abs() < 1e-9;
            if is_one {
                (a.2, a.3) = (a.2.or(b.2), a.3.or(b.3));
            }
            is_one
        });
        let mut ordered = "t,force,fix,gyro\n".to_owned();
        for (t, force, fix, gyro) in cells {
            let cell = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            writeln!(ordered, "{t},{force},{},{}", cell(fix), cell(gyro)).unwrap();
        }
        std::fs::write(folder.join("late.csv"), late).unwrap();
        std::fs::write(folder.join("ordered.csv"), ordered).unwrap();
        let likelihood = |plant: &str, file: &str| {
            let discrete = "dt = 0.1\n".to_owned() + plant;
            let text = study(
                if dt.is_some() { &discrete } else { plant },
                &format!("file = \"{file}\""),
                "parameters = [\"v\"]\nheld_out = 0\nstarts = 1\nprofile = 0",
            );
            let map = "f = [\"position + 0.1*speed\", \"speed + 0.1*(force - 0.4*speed - position)\"]";
            let text = match dt {
                Some(_) => text.replace("f = [\"speed\", \"force - 0.4*speed - position\"]", map),
                None => text,
            };
            let report = tuned(&folder, &text);
            [report.log_likelihood_before, report.log_likelihood]
        };
        let found = likelihood(&format!("delays = {{ fix = {delay} }}"), "late.csv");
        let expected = likelihood("", "ordered.csv");
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{delay}: {found} {expected}");
        }
        let ignored = likelihood("", "late.csv");
        assert!(ignored[1] < found[1] - 1.0, "{ignored:?} {found:?}");
    }
}

#[test]
fn delays_that_cannot_be_fitted_are_refused() {
    let folder = scratch("tune-delay-refused");
    let mut text = "t,force,fix,gyro\n".to_owned();
    for (t, force, fix, gyro, _) in rows(60, 0.2, 3) {
        writeln!(text, "{t},{force},{fix},{gyro}").unwrap();
    }
    std::fs::write(folder.join("log.csv"), text).unwrap();
    let said = |plant: &str, tune: &str| {
        let text = study(plant, "file = \"log.csv\"", tune);
        let read = Study::from_text("study.toml", &text, Format::Toml, &folder);
        let found = &mistakes_of(&text, read)[0];
        format!("{} | {} | {}", found.message, found.expected, found.help.clone().unwrap_or_default())
    };
    let one = "parameters = [\"delay[fix]\"]";
    let bounded = "parameters = [\"delay[fix]\"]\nbounds = { \"delay[fix]\" = [-0.1, 0.5] }";
    let unbounded = said("delays = { fix = 0.2 }", one);
    assert!(unbounded.contains("delay[fix] has no bounds") && unbounded.contains("in `bounds`"), "{unbounded}");
    assert!(said("delays = { fix = 0.2 }", bounded).contains("the lower bound of delay[fix] is -0.1"));
    assert!(said("", one).contains("a delay is fitted where `delays` in [plant] has one"));
    let discrete = said("dt = 0.1\ndelays = { fix = 0.2 }", one);
    assert!(discrete.contains("a multiple of `dt`, which no search varies"), "{discrete}");
}
