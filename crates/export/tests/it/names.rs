//! Names as identifiers.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use luenberger_export::names::{check, identifier};

#[test]
fn names_become_identifiers_that_are_accepted() {
    for name in ["EKF at 100 Hz", "2nd", "", "---", "for", "Beobachter für Winkel", "a__b", "x"] {
        let text = identifier(name);
        assert!(check(&text).is_ok(), "{name:?} -> {text:?}");
    }
    // Targets of CMake and of the build, libraries, crates, and files of an FMU.
    for name in ["all", "help", "edit_cache", "m", "nalgebra", "model", "string", "Time", "MATH"] {
        assert!(check(name).is_err() && check(&identifier(name)).is_ok(), "{name:?}");
    }
    for name in ["", "2nd", "a b", "for", "fn", "\u{e4}", &"a".repeat(49)] {
        assert!(check(name).is_err(), "{name:?}");
    }
}

/// No export has the name of a header of the compilers here: in its folder, the file would stand in place of it.
#[test]
fn no_export_has_the_name_of_a_header_of_c() {
    let headers = [
        "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits", "locale", "math",
        "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string", "tgmath", "time",
        "wchar", "wctype",
    ];
    for compiler in ["gcc", "clang", "arm-none-eabi-gcc"] {
        for header in headers {
            let process = Command::new(compiler)
                .args(["-std=gnu11", "-xc", "-M", "-"])
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn();
            let Ok(mut process) = process else { continue };
            writeln!(process.stdin.take().unwrap(), "#include <{header}.h>").unwrap();
            let output = process.wait_with_output().unwrap();
            for path in String::from_utf8_lossy(&output.stdout).split_whitespace().map(Path::new) {
                // Those in folders are included with the folder.
                let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
                if path.extension().is_none_or(|e| e != "h") || !["include", "include-fixed"].contains(&&*folder) {
                    continue;
                }
                let name = path.file_stem().unwrap().to_string_lossy();
                assert!(check(&name).is_err(), "{compiler} includes {}", path.display());
            }
        }
    }
}
