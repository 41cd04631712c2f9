//! The boards in QEMU, and emitted C on them.

use super::output::{self, Golden};
use super::{Cost, elf};
use crate::step::{Failure, Step, program, root};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A board and its compilers.
pub(super) struct Board {
    /// The target of rustc.
    pub(super) target: &'static str,
    /// The processor, in words.
    pub(super) processor: &'static str,
    emulator: &'static str,
    machine: &'static str,
    /// `2^shift` ns for an instruction.
    shift: &'static str,
    /// Flags of `arm-none-eabi-gcc`; none where emitted C is not compiled.
    c: &'static [&'static str],
}

pub(super) const BOARDS: [Board; 3] = [
    Board {
        target: "thumbv7em-none-eabihf",
        processor: "Cortex-M4F",
        emulator: "qemu-system-arm",
        machine: "mps2-an386",
        shift: "shift=10",
        c: &["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    },
    Board {
        target: "thumbv6m-none-eabi",
        processor: "Cortex-M0",
        emulator: "qemu-system-arm",
        machine: "mps2-an385",
        shift: "shift=10",
        c: &["-mcpu=cortex-m0", "-mfloat-abi=soft"],
    },
    Board {
        target: "riscv32imafc-unknown-none-elf",
        processor: "RV32IMAFC",
        emulator: "qemu-system-riscv32",
        machine: "virt",
        shift: "shift=0",
        c: &[],
    },
];

/// The cross compiler of emitted C.
pub(super) const COMPILER: &str = "arm-none-eabi-gcc";

/// A golden program that runs longer than this has stopped.
const PATIENCE: Duration = Duration::from_secs(300);

impl Board {
    pub(super) fn compiles_c(&self) -> bool {
        !self.c.is_empty()
    }

    /// The cross compiler of emitted C with the flags of the processor, in this folder.
    pub(super) fn c_compiler(&self, folder: &Path) -> Step {
        program(COMPILER).folder(folder).arguments(&["-std=c99", "-mthumb"]).arguments(self.c)
    }

    /// What is not installed, and how to get it.
    pub(super) fn missing(&self) -> Option<String> {
        self.emulator_missing().or_else(|| self.target_missing())
    }

    /// The emulator, if it is not installed.
    pub(super) fn emulator_missing(&self) -> Option<String> {
        if !crate::step::is_installed(self.emulator) {
            let package = if self.emulator.ends_with("arm") { "qemu-system-arm" } else { "qemu-system-misc" };
            return Some(format!("{} is not installed (Debian's package {package})", self.emulator));
        }
        None
    }

    /// The standard library of Rust, if it is not installed.
    pub(super) fn target_missing(&self) -> Option<String> {
        let library = self.rust_library()?;
        (!library.exists()).then(|| format!("no standard library for it: rustup target add {}", self.target))
    }

    /// Rust's routines for doubles, if they are installed; they are correctly rounded.
    pub(super) fn doubles(&self) -> Option<String> {
        let files = fs::read_dir(self.rust_library()?.join("lib")).ok()?.flatten();
        let paths = files.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|end| end == "rlib"));
        let mut paths = paths.map(|path| path.display().to_string());
        paths.find(|path| path.contains("libcompiler_builtins"))
    }

    fn rust_library(&self) -> Option<PathBuf> {
        let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output().ok()?.stdout;
        let sysroot = String::from_utf8_lossy(&sysroot).trim().to_owned();
        Some(Path::new(&sysroot).join("lib/rustlib").join(self.target))
    }

    /// What emitted C needs here and is not installed; for a board without emitted C, nothing.
    pub(super) fn c_missing(&self) -> Option<String> {
        if !self.compiles_c() {
            return None;
        }
        let library = Command::new(COMPILER).args(self.c).args(["-mthumb", "-print-file-name=libm.a"]).output();
        match library {
            Err(_) => Some(format!("{COMPILER} is not installed (Debian's package gcc-arm-none-eabi)")),
            // Only a library that is there is printed with its folder.
            Ok(library) if !String::from_utf8_lossy(&library.stdout).contains('/') => {
                Some("newlib is not installed (Debian's package libnewlib-arm-none-eabi)".to_owned())
            }
            Ok(_) => None,
        }
    }
}

/// Runs a program on the board, and returns what it printed.
pub(super) fn run(board: &Board, image: &Path) -> Result<String, Failure> {
    let printed = image.with_extension("txt");
    let io = |source| Failure::io(&printed, source);
    // Semihosting writes to standard error.
    let file = File::create(&printed).map_err(io)?;
    let mut emulator = Command::new(board.emulator)
        .args(["-M", board.machine, "-nographic", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native", "-icount", board.shift])
        .args(if board.emulator.ends_with("arm") { &[][..] } else { &["-bios", "none"] })
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stdout(file.try_clone().map_err(io)?)
        .stderr(file)
        .spawn()
        .map_err(|source| Failure::io(board.emulator, source))?;
    let began = Instant::now();
    let status = loop {
        match emulator.try_wait().map_err(|source| Failure::io(board.emulator, source))? {
            Some(status) => break status,
            None if began.elapsed() > PATIENCE => {
                _ = emulator.kill();
                _ = emulator.wait();
                return Err(Failure::Firmware(format!("{} did not end on {}", image.display(), board.machine)));
            }
            None => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    let text = fs::read_to_string(&printed).map_err(io)?;
    if status.success() {
        return Ok(text);
    }
    let last = text.lines().rev().take(3).collect::<Vec<_>>().join(" / ");
    Err(Failure::Firmware(format!("{} ended with {status} on {}; last lines: {last}", image.display(), board.machine)))
}

/// Compiles the exports with `arm-none-eabi-gcc -O2`, runs each on the board and compares every step.
pub(super) fn c_on(
    board: &Board,
    exports: &Path,
    names: &[String],
    golden: &[Golden],
) -> Result<Vec<(String, Cost)>, Failure> {
    let mut costs = Vec::new();
    if !board.compiles_c() {
        return Ok(costs);
    }
    let start = root().join("firmware/board/start");
    for name in names {
        let folder = exports.join(name);
        let (object, image) = (format!("{}.o", board.machine), format!("{}.elf", board.machine));
        let compiler = || board.c_compiler(&folder).argument("-O2");
        compiler()
            .arguments(&["-Wall", "-Wextra", "-Wconversion", "-Werror", "-fstack-usage"])
            .arguments(&["-c", &format!("{name}.c"), "-o", &object])
            .quiet_output(name)?;
        let frame = frame(&folder.join(&object), &format!("{name}_step"))?;
        compiler()
            .arguments(&["-nostartfiles", "-I."])
            .argument(format!("-T{}", start.join("arm.ld").display()))
            .argument(start.join("arm.S"))
            .argument(root().join("firmware/host/c/main.c"))
            .arguments(&[&object, "-lm", "-lc", "-lgcc", "-lnosys", "-o", &image])
            .quiet_output(name)?;
        let found = output::read(&run(board, &folder.join(&image))?)?;
        let place = format!("{} as C", board.machine);
        output::of(golden, name)?.compare(&found[0], &place)?;
        let object = elf::Image::read(&folder.join(&object))?;
        // The step, and what it is not compiled into: not the functions that start an observer.
        let code =
            object.code(|function| ![format!("{name}_init"), format!("{name}_reset")].contains(&function.to_owned()));
        costs.push((name.clone(), found[0].cost(code, Some(frame))?));
    }
    eprintln!("── {}: emitted C of {} observers, every step as on the host", board.target, costs.len());
    Ok(costs)
}

/// The frame of a function, which GCC's -fstack-usage writes beside the object: a line `file:line:column:name`, the
/// bytes, and whether they are always as many.
pub(super) fn frame(object: &Path, function: &str) -> Result<u64, Failure> {
    let path = object.with_extension("su");
    let text = fs::read_to_string(&path).map_err(|source| Failure::io(&path, source))?;
    let frame = text.lines().find_map(|line| {
        let mut columns = line.split('\t');
        let is_it = columns.next()?.rsplit(':').next() == Some(function);
        columns.next().filter(|_| is_it)?.parse().ok()
    });
    frame.ok_or_else(|| Failure::Firmware(format!("{} has no frame of {function}", path.display())))
}
