//! Writes semidefinite programs made by formula, after the families of SDPLIB, as SDPA's files:
//! `cargo run --release -p luenberger-lmi --example sdpa_families -- FOLDER`.

#[path = "../tests/it/families/mod.rs"]
mod families;

use std::path::PathBuf;
use std::process::ExitCode;

use families::{
    Instance, assignment, control, equal_partition, max_cut, max_cut_cycle, planted, theta, theta_kneser, truss,
    without_dual_point, without_primal_point,
};

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: sdpa_families FOLDER");
        return ExitCode::from(2);
    };
    for instance in families::small().into_iter().chain(large()) {
        let file = folder.join(format!("{}.dat-s", instance.name));
        if let Err(error) = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&file, &instance.text)) {
            eprintln!("{}: {error}", file.display());
            return ExitCode::FAILURE;
        }
        println!("{} {:?}", file.display(), instance.known);
    }
    ExitCode::SUCCESS
}

/// Of the size of SDPLIB's, and larger.
fn large() -> Vec<Instance> {
    vec![
        max_cut(100, 5.0, 1),
        max_cut(250, 10.0, 2),
        max_cut(500, 10.0, 3),
        max_cut(800, 48.0, 4),
        max_cut_cycle(301),
        theta(50, 0.085, 5),
        theta(100, 0.2, 6),
        theta(150, 0.2, 7),
        theta(200, 0.15, 8),
        theta(300, 0.1, 9),
        theta_kneser(10, 3),
        theta_kneser(15, 2),
        equal_partition(100, 10.0, 10),
        equal_partition(250, 10.0, 11),
        equal_partition(500, 10.0, 12),
        equal_partition(801, 40.0, 13),
        assignment(5, 14),
        assignment(7, 15),
        assignment(10, 16),
        control(10, 17),
        control(15, 18),
        control(20, 19),
        control(30, 20),
        control(40, 21),
        control(55, 22),
        truss(18, 118, 33, 23),
        truss(60, 160, 1, 24),
        truss(160, 174, 1, 25),
        truss(80, 200, 2, 26),
        truss(130, 132, 2, 33),
        planted(40, 30, 27),
        planted(100, 200, 28),
        without_primal_point(60, 40, 29),
        without_dual_point(60, 40, 30),
        without_primal_point(150, 200, 31),
        without_dual_point(150, 200, 32),
    ]
}
