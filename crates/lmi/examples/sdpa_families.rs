//! Writes semidefinite programs made by formula, after the families of SDPLIB, as SDPA's files:
//! `cargo run --release -p luenberger-lmi --example sdpa_families -- FOLDER`.

#[path = "../tests/families/mod.rs"]
mod families;

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: sdpa_families FOLDER");
        return ExitCode::from(2);
    };
    for instance in families::small().into_iter().chain(families::large()) {
        let file = folder.join(format!("{}.dat-s", instance.name));
        if let Err(error) = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&file, &instance.text)) {
            eprintln!("{}: {error}", file.display());
            return ExitCode::FAILURE;
        }
        println!("{} {:?}", file.display(), instance.known);
    }
    ExitCode::SUCCESS
}
