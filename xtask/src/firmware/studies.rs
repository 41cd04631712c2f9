//! The observers of every template and example study, exported by the command as a user would: the golden test of each
//! export, unchanged, on a Cortex-M4F. Some run as the static library of the Rust export too.

use super::boards::{self, Board};
use super::{Cost, elf};
use crate::deploy;
use crate::step::{Failure, build_command, built, cargo, root};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// Steps of each golden test.
const STEPS: u32 = 1000;

const FORMATS: [&str; 2] = ["f32", "f64"];

/// Of an observer in continuous time in a study without a period.
const PERIOD: &str = "0.01";

/// That of observers which are too fast for it.
const SHORT_PERIOD: &str = "1e-5";

/// Exports of which the static library runs as well: one of each kind of observer of a nonlinear plant, and blocks.
const STATIC_LIBRARIES: [(&str, &str); 8] = [
    ("flexible-joint", "one gain"),
    ("flexible-joint", "mean value"),
    ("flexible-joint", "filter"),
    ("duffing", "by simulation"),
    ("double-integrator", "sampled"),
    ("loop", "block"),
    ("timed", "timed"),
    ("filtered", "filtered"),
];

/// An observer at varying periods.
const VARYING: &str = r#"
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
time_unit = "s"

[input]
expressions = ["sin(t)"]

[simulation]
x0 = [3, -1]
duration = 8

[[observer]]
name = "varying"
kind = "sampled-cubic"
poles = [-2, -5]
gamma = 10
period = 0.1
jitter = [0.07, 0.14]
misses = 2
"#;

/// An observer of a study.
pub(super) struct Case {
    file: PathBuf,
    pub(super) study: String,
    pub(super) observer: String,
    pub(super) has_feedback: bool,
}

/// What its steps cost, for each format; none where the command refuses it.
pub(super) struct Row {
    pub(super) case: Case,
    pub(super) c: Vec<Option<Cost>>,
    pub(super) rust: Vec<Option<Cost>>,
}

/// The observers on the board. With `rust` the static libraries run too.
pub(super) fn on(board: &Board, folder: &Path, rust: bool) -> Result<Vec<Row>, Failure> {
    build_command()?;
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|source| Failure::io(folder, source))?;
    }
    fs::create_dir_all(folder).map_err(|source| Failure::io(folder, source))?;
    let cases = cases(folder)?;
    let waiting = Mutex::new(cases.into_iter().enumerate().collect::<Vec<_>>());
    let found = Mutex::new(Vec::new());
    let worker = || {
        while let Some((place, case)) = waiting.lock().ok().and_then(|mut waiting| waiting.pop()) {
            let result = c_of(board, folder, place, case);
            let is_error = result.is_err();
            if let Ok(mut found) = found.lock() {
                found.push((place, result));
            }
            if is_error {
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from).min(4) {
            scope.spawn(worker);
        }
    });
    let mut found = found.into_inner().unwrap_or_default();
    found.sort_by_key(|(place, _)| *place);
    let mut rows = found.into_iter().map(|(_, row)| row).collect::<Result<Vec<Row>, Failure>>()?;
    let count: usize = rows.iter().flat_map(|row| &row.c).flatten().count();
    eprintln!(
        "── {}: {count} exports of {} observers of studies as C, every step as designed",
        board.target,
        rows.len()
    );
    if rust {
        let mut count = 0;
        for row in &mut rows {
            if STATIC_LIBRARIES.contains(&(&row.case.study, &row.case.observer)) {
                row.rust = FORMATS
                    .map(|format| rust_of(board, folder, &row.case, format))
                    .into_iter()
                    .collect::<Result<_, _>>()?;
                count += row.rust.iter().flatten().count();
            }
        }
        eprintln!("── {}: {count} static libraries in Rust, every step as designed; nothing can panic", board.target);
    }
    Ok(rows)
}

/// The command that was built.
fn luenberger() -> Command {
    let mut command = Command::new(built("luenberger"));
    command.current_dir(root());
    command
}

/// What the command wrote to its two streams, and whether it succeeded.
fn said(command: &mut Command) -> Result<(bool, String, String), Failure> {
    let output = command.output().map_err(|source| Failure::io("luenberger", source))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok((output.status.success(), text(&output.stdout), text(&output.stderr)))
}

/// The templates, the studies of `deploy` and the example studies.
fn cases(folder: &Path) -> Result<Vec<Case>, Failure> {
    let mut files = Vec::new();
    let (_, list, _) = said(luenberger().args(["new", "--list"]))?;
    for name in list.lines().map_while(|line| line.split_whitespace().next()) {
        let file = folder.join(format!("{name}.toml"));
        let (good, _, error) = said(luenberger().args(["new", "--plant", name, "-o"]).arg(&file))?;
        if !good {
            return Err(Failure::Firmware(format!("luenberger new --plant {name}: {error}")));
        }
        files.push((file, false));
    }
    // The filter in the loop, once more with the other kind.
    let unscented = deploy::TIMED.replace("extended-kalman", "ukf").replace("timed", "unscented");
    let own = [
        ("unscented.toml", unscented.as_str(), true),
        ("varying.toml", VARYING, false),
        ("loop.toml", deploy::LOOP, true),
        ("timed.toml", deploy::TIMED, true),
        ("bounded.toml", deploy::BOUNDED, false),
        ("filtered.toml", deploy::FILTERED, false),
        ("interpolated.toml", deploy::INTERPOLATED, false),
    ];
    for (name, text, has_feedback) in own {
        let file = folder.join(name);
        fs::write(&file, text).map_err(|source| Failure::io(&file, source))?;
        files.push((file, has_feedback));
    }
    let mut folders = vec![root().join("examples/studies")];
    let mut examples = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(|source| Failure::io(&folder, source))? {
            let path = entry.map_err(|source| Failure::io(&folder, source))?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "toml") {
                examples.push((path, false));
            }
        }
    }
    examples.sort();
    files.extend(examples);
    let mut cases = Vec::new();
    for (file, has_feedback) in files {
        let study = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        // The command lists the observers of a study when it is asked for one that is not there.
        let (_, _, error) = said(luenberger().args(["export", "--to", "c", "--observer", "?"]).arg(&file))?;
        let list = error.trim_end().split_once("it has ").map(|(_, list)| list);
        let list = list.ok_or_else(|| Failure::Firmware(format!("the observers of {}: {error}", file.display())))?;
        cases.extend(list.split(", ").map(|observer| Case {
            file: file.clone(),
            study: study.clone(),
            observer: observer.to_owned(),
            has_feedback,
        }));
    }
    Ok(cases)
}

/// Exports the observer; the folder and the identifier, or why the command refuses it.
fn export(case: &Case, to: &str, format: &str, out: &Path) -> Result<Result<String, String>, Failure> {
    let steps = STEPS.to_string();
    let mut arguments = vec!["export", "--to", to, "--unproved", "--format", format, "--test-steps", &steps];
    arguments.extend(["--observer", &case.observer]);
    arguments.extend(case.has_feedback.then_some("--feedback"));
    let run = |more: &[&str]| said(luenberger().args(&arguments).args(more).arg("-o").arg(out).arg(&case.file));
    let mut ran = run(&[])?;
    if ran.2.contains("no period is given") {
        ran = run(&["--period", PERIOD])?;
    }
    if ran.2.contains("is long for the fastest mode of the error") {
        ran = run(&["--period", SHORT_PERIOD])?;
    }
    if !ran.0 {
        return Ok(Err(ran.2.lines().next().unwrap_or_default().to_owned()));
    }
    let header = ran.1.lines().find_map(|line| line.trim().strip_suffix(".h")).map(|name| name.replace("c/", ""));
    header.map(Ok).ok_or_else(|| Failure::Firmware(format!("{}: no header among {}", case.observer, ran.1)))
}

/// The observer as C, in each format.
fn c_of(board: &Board, folder: &Path, place: usize, case: Case) -> Result<Row, Failure> {
    let mut c = Vec::new();
    for format in FORMATS {
        let out = folder.join(format!("{place}-{format}"));
        c.push(match export(&case, "c", format, &out)? {
            Err(why) if format == "f64" => {
                return Err(Failure::Firmware(format!("{}, {}: {why}", case.study, case.observer)));
            }
            Err(why) => {
                eprintln!("── {}, {}: {why}", case.study, case.observer);
                None
            }
            Ok(name) => {
                let object = format!("{name}.o");
                board
                    .c_compiler(&out)
                    .arguments(&["-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-fstack-usage"])
                    .arguments(&["-c", &format!("{name}.c"), "-o", &object])
                    .quiet_output(&name)?;
                match golden(board, &out, &name, &object, None) {
                    Ok(mut cost) => {
                        let image = elf::Image::read(&out.join(&object))?;
                        let starts = [format!("{name}_init"), format!("{name}_reset")];
                        cost.code = image.code(|function| !starts.contains(&function.to_owned()));
                        cost.constants = Some(image.constants);
                        cost.frame = Some(boards::frame(&out.join(&object), &format!("{name}_step"))?);
                        Some(cost)
                    }
                    Err(differs) => {
                        // libgcc's sums of doubles for Thumb-2 lose a bit where exponents differ by 33
                        // (docs/deploy.md); with another library for them, each bit has to be the design's.
                        let Some(doubles) = board.doubles().filter(|_| format == "f64") else { return Err(differs) };
                        golden(board, &out, &name, &object, Some(&doubles)).map_err(|_| differs)?;
                        eprintln!("── {}, {}: as designed in f64, but not with libgcc", case.study, case.observer);
                        None
                    }
                }
            }
        });
    }
    Ok(Row { case, c, rust: Vec::new() })
}

/// The static library of the Rust export.
fn rust_of(board: &Board, folder: &Path, case: &Case, format: &str) -> Result<Option<Cost>, Failure> {
    let out = folder.join(format!("{}-{}-{format}", case.study, case.observer.replace(' ', "-")));
    let Ok(name) = export(case, "rust", format, &out)? else { return Ok(None) };
    let package = out.join("c");
    // The versions of the golden programs, so that nothing else has to be fetched.
    let lock = root().join("firmware/Cargo.lock");
    fs::copy(&lock, package.join("Cargo.lock")).map_err(|source| Failure::io(&lock, source))?;
    let observers = root().join("crates/observers");
    let patch = format!("patch.crates-io.luenberger-observers.path={:?}", observers.display().to_string());
    let built = folder.with_file_name("static-libraries");
    cargo(&["build", "--quiet", "--release", "--target", board.target, "--config", &patch, "--target-dir"])
        .argument(&built)
        .folder(&package)
        .quiet_output(&format!("{name} as a static library"))?;
    let library = built.join(board.target).join(format!("release/lib{name}.a"));
    let mut cost = golden(board, &package, &name, &library.display().to_string(), None)?;
    let image = elf::Image::read(&package.join("board.elf"))?;
    if image.has(|function| function.contains("rust_begin_unwind")) {
        return Err(Failure::Firmware(format!("{name} as a static library can panic")));
    }
    // Functions of Rust have mangled names; those of the compiler are shared with the rest of a program.
    let is_rust = |function: &str| function.starts_with("_R") || function.starts_with("_ZN");
    let step = format!("{name}_step");
    cost.code = image.code(|function| function == step || is_rust(function) && !function.contains("compiler_builtins"));
    Ok(Some(cost))
}

/// Links the golden test in this folder with the observer, and runs it on the board; `doubles` is a library to take
/// instead of libgcc.
fn golden(board: &Board, folder: &Path, name: &str, observer: &str, doubles: Option<&str>) -> Result<Cost, Failure> {
    let firmware = root().join("firmware");
    let (test, image) = (format!("test_{name}.c"), folder.join("board.elf"));
    let header = folder.join(format!("{name}.h"));
    let header = fs::read_to_string(&header).map_err(|source| Failure::io(&header, source))?;
    let time = ["float", "double"].into_iter().find(|number| {
        header.contains(&format!("_step({name}_state *state, const {number} *u, const {number} *y, {number} dt,"))
    });
    let time = time.map(|number| format!("-DDT={number}"));
    board
        .c_compiler(folder)
        .arguments(&["-O1", "-nostartfiles", &format!("-DNAME={name}")])
        .arguments(&time.iter().map(String::as_str).collect::<Vec<_>>())
        .argument(format!("-Wl,--gc-sections,-z,noexecstack,--wrap=main,--wrap={name}_step"))
        .argument(format!("-T{}", firmware.join("board/start/arm.ld").display()))
        .argument(firmware.join("board/start/arm.S"))
        .argument(firmware.join("host/c/golden.c"))
        .arguments(&[&test, observer, "-lm", "-lc"])
        .arguments(doubles.as_slice())
        .arguments(&["-lgcc", "-o"])
        .argument(&image)
        .quiet_output(name)?;
    let printed = boards::run(board, &image)?;
    let all = format!("{name}: {STEPS} of {STEPS} steps agree to the last bit");
    let costs = printed.lines().find_map(|line| line.strip_prefix("costs "));
    let costs: Vec<u32> = costs.unwrap_or_default().split(' ').filter_map(|word| word.parse().ok()).collect();
    match costs[..] {
        [most, mean, stack, STEPS] if printed.lines().any(|line| line == all) => {
            Ok(Cost { mean: f64::from(mean), most, stack, frame: None, code: 0, constants: None })
        }
        _ => Err(Failure::Firmware(format!("{name} in {} printed {printed}", folder.display()))),
    }
}
