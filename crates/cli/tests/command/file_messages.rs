//! What the command says of files: models to import, certificates, semidefinite programs, observers to export.

use crate::terminal::{folder, luenberger};
use luenberger_proof::certificate::{CertificateFile, digest};
use serde_json::{Value, json};
use std::fmt::Write;

/// Models, each with the name of its file.
const MODELS: &[(&str, &[u8])] = &[
    ("empty.json", b""),
    ("list.json", b"[1, 2]"),
    ("cut.json", br#"{"A": [[1]"#),
    ("twice.json", br#"{"A": [[1]], "A": [[2]], "C": [[1]]}"#),
    ("text.json", br#"{"A": "fast", "C": [[1]]}"#),
    ("ragged.json", br#"{"A": [[1, 2], [3]], "C": [[1]]}"#),
    ("nan.json", br#"{"A": [[NaN]], "C": [[1]]}"#),
    ("large.json", br#"{"A": [[1e999]], "C": [[1]]}"#),
    ("complex.json", br#"{"A": [[[1, 2]]], "C": [[1]]}"#),
    ("no-a.json", br#"{"B": [[1]], "C": [[1]], "Q": [[1]]}"#),
    ("no-c.json", br#"{"A": [[1]]}"#),
    ("nothing.json", b"{}"),
    ("case.json", br#"{"A": [[1]], "a": [[1]], "C": [[1]]}"#),
    ("two.json", br#"{"one": {"A": [[1]], "C": [[1]]}, "two": {"A": [[1]], "C": [[1]]}}"#),
    ("shape-a.json", br#"{"A": [[1, 2]], "C": [[1]]}"#),
    ("shape-b.json", br#"{"A": [[1]], "B": [[1], [2]], "C": [[1]]}"#),
    ("shape-c.json", br#"{"A": [[1]], "C": [[1, 2]]}"#),
    ("shape-d.json", br#"{"A": [[1]], "B": [[1]], "C": [[1]], "D": [[1, 2]]}"#),
    ("e.json", br#"{"A": [[1]], "C": [[1]], "E": [[0]]}"#),
    ("names.json", br#"{"A": [[1]], "C": [[1]], "StateName": ["x", "y"]}"#),
    ("ts-text.json", br#"{"A": [[1]], "C": [[1]], "Ts": "fast"}"#),
    ("ts-unknown.json", br#"{"A": [[1]], "C": [[1]], "dt": "fast"}"#),
    ("ts-minus.json", br#"{"A": [[1]], "C": [[1]], "Ts": -1}"#),
    ("unknown.bin", b"\x00\x01\x02\x03"),
    ("hdf5.mat", b"\x89HDF\r\n\x1a\n and so on"),
    ("one.npy", b"\x93NUMPY\x01\x00 and so on"),
    ("archive.npz", b"PK\x03\x04 and so on"),
    ("short.mat", b"MATLAB 5.0 MAT-file"),
];

/// Changes of a certificate whose digest agrees again, unless the name says otherwise.
fn certificates() -> Vec<(&'static str, String)> {
    let study = "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nname = \"one\"\nkind = \"luenberger\"\npoles = [-2, -5]\n";
    let folder = folder("messages-certify");
    let out = folder.to_str().unwrap();
    assert_eq!(luenberger(&["certify", "-", "-o", out], study).code, Some(0));
    let text = std::fs::read_to_string(folder.join("certificates/one.json")).unwrap();
    let whole: Value = serde_json::from_str(&text).unwrap();
    let sealed = |mut file: Value| {
        if let Ok(digest) = digest(file.to_string().as_bytes()) {
            file["sha256"] = digest.into();
        }
        serde_json::to_string_pretty(&file).unwrap()
    };
    let changed = |pointer: &str, value: Value| {
        let mut file = whole.clone();
        *file.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer} of {text}")) = value;
        sealed(file)
    };
    // With the words that its data say.
    let reworded = |pointer: &str, value: Value| {
        let mut file: Value = serde_json::from_str(&changed(pointer, value)).unwrap();
        file["statement"] = CertificateFile::read(file.to_string().as_bytes()).unwrap().theorem().words().into();
        sealed(file)
    };
    let with = |key: &str, value: Value| {
        let mut file = whole.clone();
        file[key] = value;
        sealed(file)
    };
    let without = |key: &str| {
        let mut file = whole.clone();
        file.as_object_mut().unwrap().remove(key);
        sealed(file)
    };
    vec![
        ("the certificate", text.clone()),
        ("empty", String::new()),
        ("cut", text[..text.len() / 2].to_owned()),
        ("not-json", text.replacen("\"0x", "0x", 1)),
        ("deep", "[".repeat(200)),
        ("another-digest", text.replacen("\"sha256\": \"", "\"sha256\": \"0", 1)),
        ("another-format", with("format", "zip".into())),
        ("another-version", with("version", 1.into())),
        ("another-theorem", with("theorem", "fermat".into())),
        ("another-field", with("note", "also true".into())),
        ("no-statement", without("statement")),
        ("no-lyapunov", without("lyapunov")),
        ("other-words", with("statement", "For every plant.".into())),
        ("another-inequality", changed("/margins/0/inequality", "1 > 0".into())),
        ("too-much-claimed", changed("/margins/0/margin", "0x1p40".into())),
        ("fewer-claims", with("margins", json!([]))),
        ("no-number", changed("/lyapunov/P/0/0", "one".into())),
        ("not-symmetric", changed("/lyapunov/P/0/1", "0x1p3".into())),
        ("ragged", changed("/lyapunov/P/0", json!(["0x1p0"]))),
        ("another-shape", changed("/observer/L", json!([["0x1p0"]]))),
        ("an-object", changed("/observer/L", json!({}))),
        ("false", reworded("/observer/L", json!([["-0x1p0"], ["0x1p0"]]))),
    ]
}

/// Semidefinite programs in SDPA's format.
const PROGRAMS: &[&[u8]] = &[
    b"",
    b"one\n",
    b"0\n",
    b"1\n1\n",
    b"1\n1\n2\n1.0\n0 1 1 3 -1.0\n",
    b"1\n1\n2\n1.0\n0 1 2 1 x\n",
    b"1\n1\n2\n1.0\n2 1 1 1 1.0\n",
    b"1\n1\n2\nnan\n",
    b"1\n1\n2\n\xff\n",
    b"1\n1\n2\n1.0\n0 1 1 1 1.0\n1 1 1 1 1.0\n1 1 1 1 2.0\n",
    b"1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n",
];

const PLANT: &str = "[plant]\na = [[0, 1], [0, 0]]\nb = [[0], [1]]\nc = [[1, 0]]\n";
const MAP: &str = "[plant]\nf = [\"x1 + 0.1*x2\", \"x2 - 0.1*sin(x1)\"]\nh = [\"x1\"]\ndt = 0.1\n";

/// Exports that fail, or that have something to say: options, plant, and observers.
const EXPORTS: &[(&[&str], &str, &str)] = &[
    (&[], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (&["--period", "-1"], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (&["--period", "0.1", "--observer", "two"], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (
        &["--period", "0.1"],
        PLANT,
        "name = \"one\"\nkind = \"luenberger\"\npoles = [-2, -5]\n[[observer]]\nname = \"two\"\nkind = \"luenberger\"\npoles = [-2, -5]\n",
    ),
    (&["--period", "0.1"], PLANT, "kind = \"sampled-cubic\"\npoles = [-2, -5]\ngamma = 1\nperiod = 0.2\n"),
    (&["--period", "0.1", "--feedback"], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (&["--period", "0.1", "--fmi", "3"], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (&["--period", "0.1", "--to", "ada"], PLANT, "kind = \"luenberger\"\npoles = [-2, -5]\n"),
    (&[], MAP, "kind = \"lpv\"\ndecay_rate = 1\n"),
    (&[], PLANT, "kind = \"mean-value\"\nregion = { states = [[-1, 1], [-1, 1]] }\n"),
    (&["--period", "0.1"], "[plant]\na = [[1e300]]\nc = [[1e300]]\n", "kind = \"luenberger\"\npoles = [-1]\n"),
];

/// All of it, without the paths of this machine.
pub(crate) fn all() -> String {
    let folder = folder("messages-files");
    let mut text = String::new();
    let here = format!("{}/", folder.display());
    let mut say = |title: &str, arguments: &[&str], input: &[u8]| {
        let ran = luenberger(arguments, input);
        _ = write!(text, "\n$ {title}\n{}{}", ran.stdout.replace(&here, ""), ran.stderr.replace(&here, ""));
    };
    for (name, bytes) in MODELS {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        say(&format!("luenberger import {name}"), &["import", path.to_str().unwrap(), "-o", "-"], b"");
    }
    let absent = folder.join("absent.mat");
    say("luenberger import absent.mat", &["import", absent.to_str().unwrap(), "-o", "-"], b"");
    for (name, certificate) in certificates() {
        say(&format!("luenberger verify - ({name})"), &["verify", "-"], certificate.as_bytes());
    }
    for program in PROGRAMS {
        let shown = String::from_utf8_lossy(program).replace('\n', "; ");
        say(&format!("luenberger sdp - ({})", shown.trim_end()), &["sdp", "-"], program);
    }
    for (options, plant, observers) in EXPORTS {
        let out = folder.join("out");
        let mut arguments = vec!["export", "-", "-o", out.to_str().unwrap(), "--force"];
        if !options.contains(&"--to") {
            arguments.extend(["--to", "c"]);
        }
        arguments.extend(*options);
        let title = format!("luenberger export - {} ({})", options.join(" "), observers.replace('\n', "; "));
        say(&title, &arguments, format!("{plant}[[observer]]\n{observers}").as_bytes());
    }
    text
}
