//! The kernels of exports as C files of their own: strict compilers accept them in both formats and with every option.
//! Without a C compiler this test says so and passes.

use std::path::Path;
use std::process::Command;

use crate::compiled::compilers;

/// The options that the file mentions in a condition.
fn options(text: &str) -> Vec<&str> {
    let mut all: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("#if "))
        .map(|condition| condition.trim_start_matches('!'))
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

#[test]
fn every_kernel_compiles_on_its_own() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/c/kernels");
    let compilers = compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    let mut kernels: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "c"))
        .collect();
    kernels.sort_unstable();
    assert!(!kernels.is_empty());
    for kernel in &kernels {
        let text = std::fs::read_to_string(kernel).unwrap();
        let options = options(&text);
        // None, each alone, and all of them.
        let alone = options.iter().map(|option| vec![*option]);
        let choices = [Vec::new()].into_iter().chain(alone).chain([options.clone()]);
        for chosen in choices {
            for format in ["-DBINARY32=0", "-DBINARY32=1"] {
                for compiler in &compilers {
                    let built = Command::new(compiler)
                        .current_dir(&folder)
                        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wundef", "-pedantic", "-Werror"])
                        // A kernel is used by others.
                        .args(["-Wno-unused-function", "-fsyntax-only", format])
                        .args(chosen.iter().map(|option| format!("-D{option}=1")))
                        .arg(kernel)
                        .output()
                        .unwrap();
                    let said = String::from_utf8_lossy(&built.stderr);
                    assert!(built.status.success(), "{compiler} {format} {chosen:?}: {said}");
                }
            }
        }
    }
}

/// docs/adding-an-observer.md names each kernel in its table of bodies that stand twice, and nothing else there.
#[test]
fn every_kernel_is_listed_beside_its_body() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("../../docs/adding-an-observer.md")).unwrap();
    let (_, table) = page.split_once("| kernels | the body, in `crates/observers/src` |").unwrap();
    let rows = table.trim_start().lines().skip(1).take_while(|row| row.starts_with('|'));
    let mut listed: Vec<String> = rows
        .filter_map(|row| row.split('|').nth(1))
        .flat_map(|cell| cell.split(',').map(|name| format!("{}.c", name.trim().trim_matches('`'))).collect::<Vec<_>>())
        .collect();
    listed.sort_unstable();
    let mut kernels: Vec<String> = std::fs::read_dir(root.join("src/c/kernels"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "c"))
        .collect();
    kernels.sort_unstable();
    assert_eq!(listed, kernels);
}
