//! The options that bound time and memory, and the length of input.

use crate::results;
use crate::terminal::{folder, luenberger};

/// The file of the study of [`results`] with more lines.
fn written(name: &str, more: &str) -> String {
    results::written(name, &format!("{}{more}", results::STUDY)).1
}

#[test]
fn amounts_have_units() {
    let samples = written("limits-memory", "samples = 100000000\n");
    let sweep = written("limits-years", "[sweep]\nparameter = \"initial\"\nvalues = [1]\nensemble = 10000000000\n");
    for (study, limit, written) in [
        (&samples, "memory=4GiB", "(limit 4 GiB)"),
        (&samples, "memory=300MiB", "(limit 300 MiB)"),
        (&samples, "memory=2KiB", "(limit 2 KiB)"),
        (&samples, "memory=500MB", "(limit 480 MiB)"),
        (&samples, "memory=5kB", "(limit 4.9 KiB)"),
        (&samples, "memory=5GB", "(limit 4.7 GiB)"),
        (&samples, "memory=0.001TiB", "(limit 1 GiB)"),
        (&samples, "memory=0.002TB", "(limit 1.9 GiB)"),
        (&sweep, "time=90s", "(limit 90 s)"),
        (&sweep, "time=30min", "(limit 30 min)"),
        (&sweep, "time=1.5h", "(limit 1.5 h)"),
        (&sweep, "time=1day", "(limit 24 h)"),
        (&sweep, "time=2days", "(limit 2 days)"),
        (&sweep, "time=2d", "(limit 2 days)"),
    ] {
        let ran = luenberger(&["run", study, "--limit", limit], "");
        assert!(ran.code == Some(2) && ran.stderr.contains(written), "{limit}: {ran:?}");
    }
    for wrong in ["time", "time=", "time=3", "time=0s", "time=-1s", "time=nans", "memory=4", "memory=4 ", "disk=1GB"] {
        let ran = luenberger(&["run", &sweep, "--limit", wrong], "");
        assert!(ran.code == Some(2) && ran.stderr.contains("expected memory=SIZE or time=TIME"), "{wrong}: {ran:?}");
    }
}

#[test]
fn the_last_limit_counts() {
    let sweep = written("limits-last", "[sweep]\nparameter = \"initial\"\nvalues = [1]\nensemble = 10000000000\n");
    let limits = ["--limit", "time=1s", "--limit", "memory=2GiB,time=3s"];
    let ran = luenberger(&[&["run", sweep.as_str()], &limits[..]].concat(), "");
    assert!(ran.stderr.contains("(limit 3 s)"), "{ran:?}");
    let ran = luenberger(&["run", &sweep], "");
    assert!(ran.stderr.contains("(limit 24 h)"), "{ran:?}");
    let small = written("limits-none", "samples = 11\n");
    let out = format!("{small}-results");
    let run = |limits: &[&str]| luenberger(&[&["run", small.as_str(), "-o", out.as_str()], limits].concat(), "");
    let refused = run(&["--limit", "memory=1kB"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("(limit 1000 B)"), "{refused:?}");
    let ran = run(&["--limit", "memory=1kB", "--limit", "memory=none,time=none"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
}

/// A file of 256 MiB and one byte, which takes no room on the disk.
#[cfg(unix)]
#[test]
fn input_beyond_the_limit_is_refused() {
    let file = folder("limits-input").join("long.json");
    std::fs::File::create(&file).unwrap().set_len((256 << 20) + 1).unwrap();
    let ran = luenberger(&["eig", file.to_str().unwrap()], "");
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.stderr.trim_end().ends_with("long.json is longer than 268435456 bytes"), "{}", ran.stderr);
}
