//! Exports in the layouts of boards and robots: their programs are compiled against the part of the system that they
//! use (`layouts/`), and run. Without a C compiler these tests say so and pass.

use std::path::{Path, PathBuf};
use std::process::Command;

use luenberger_export::{Export, ExportableObserver, File, FixedPointFormat, Layout, Names, Scalar, golden};
use luenberger_observers::{DiscreteLinearObserver, SampledObserver, VaryingPeriodStep};
use luenberger_plants::StateSpace;
use nalgebra::{DVector, Dyn, dmatrix};

use crate::compiled::{compilers, folder, has_haswell, program, varying, with_feedback};

fn export(inputs: usize, scalar: Scalar) -> Export {
    of(program(5, (2, inputs, 1), false, false), inputs, scalar)
}

fn of(program: ExportableObserver, inputs: usize, scalar: Scalar) -> Export {
    let names = Names { time_unit: "ms".to_owned(), ..Names::numbered(2, inputs, 1) };
    Export::new("plant", program, scalar, &[0.5, -1.25], names).unwrap()
}

fn write(files: &[File], folder: &Path) {
    for file in files {
        let path = folder.join(&file.name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, &file.text).unwrap();
    }
}

fn stubs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/layouts")
}

/// Runs the command; its standard output.
#[track_caller]
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command:?}: {text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

fn is_there(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        eprintln!("no {program}: skipped");
    }
    there
}

const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"];

const SKETCH: &str = "examples/plant/plant.ino";

/// The exports whose steps have different arguments.
fn all_calls() -> Vec<(&'static str, Export)> {
    let varying = || of(varying(&program(3, (2, 1, 1), true, false)), 1, Scalar::Binary64);
    vec![
        ("inputs", export(1, Scalar::Binary64)),
        ("none", export(0, Scalar::Binary32)),
        ("fed", with_feedback(export(1, Scalar::Binary64))),
        ("varying", varying()),
        ("varying-f32", of(self::varying(&program(3, (2, 1, 1), true, false)), 1, Scalar::Binary32)),
        ("varying-slow", in_unit("min", &varying())),
        ("varying-alone", of(self::varying(&program(3, (2, 0, 1), true, false)), 0, Scalar::Binary64)),
    ]
}

/// The same export with another unit of time.
fn in_unit(unit: &str, export: &Export) -> Export {
    let names = Names { time_unit: unit.to_owned(), ..Names::numbered(2, export.observer().plant_inputs(), 1) };
    Export::new("plant", export.observer().clone(), export.scalar(), &[0.5, -1.25], names).unwrap()
}

fn is_slow(name: &str) -> bool {
    name == "varying-slow"
}

fn is_varying(name: &str) -> bool {
    name.starts_with("varying")
}

/// The period in microseconds: 0.05 ms or min.
fn period(name: &str) -> i64 {
    if is_slow(name) { 3_000_000 } else { 50 }
}

/// How late the program is at sample k in microseconds, and the signals: those of `layouts/clock.h`.
fn late(name: &str, k: i64) -> i64 {
    29 * k % 17 * (period(name) / 50)
}

fn measured(k: i64) -> f64 {
    ((37 * k + 11) % 64) as f64 / 32.0 - 1.0
}

fn input(k: i64) -> f64 {
    ((53 * k + 5) % 64) as f64 / 32.0 - 1.0
}

const STEPS: i64 = 12;

/// Seconds in the unit of time.
fn unit(name: &str) -> f64 {
    if is_slow(name) { 60.0 } else { 1e-3 }
}

/// `count` of a clock in the unit of time, in the format of the export.
fn time(export: &Export, count: i64, tick: f64) -> f64 {
    match export.scalar() {
        Scalar::Binary32 => f64::from(count as f32 * tick as f32),
        Scalar::Binary64 => count as f64 * tick,
    }
}

/// The estimates of the Rust observer: a sample takes the input that is held until the next one; at varying periods the
/// one that was held since the last one, and the time since then, which is 0 at first.
fn expected(export: &Export, elapsed: impl Fn(i64) -> f64) -> Vec<Vec<f64>> {
    let size = export.observer().dimensions();
    let mut stepper = golden::Stepper::new(export).unwrap();
    let mut step = |k: i64| {
        let mut u = vec![0.0; size.inputs];
        if export.observer().takes_time() {
            let (dt, given) = u.split_last_mut().unwrap();
            *dt = if k == 0 { 0.0 } else { elapsed(k) };
            given.fill(if k == 0 { 0.0 } else { input(k - 1) });
        } else {
            u.fill(input(k));
        }
        if export.has_feedback() {
            // The gain of `with_feedback`, summed as the kernel sums: u = r - K xhat.
            u[0] -= 0.03 * stepper.estimate()[0] + (0.03 - 0.01) * stepper.estimate()[1];
        }
        stepper.step(&u, &vec![measured(k); size.outputs])
    };
    (0..STEPS).map(&mut step).collect()
}

#[track_caller]
fn assert_agree(name: &str, found: &[Vec<f64>], expected: &[Vec<f64>]) {
    assert!(found == expected, "{name}: {found:?} {expected:?}");
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Fills in the connections of a program, and has each step reported.
fn fill_in(folder: &Path, program: &str) {
    let path = folder.join(program);
    let text = std::fs::read_to_string(&path).unwrap();
    let mut filled = String::new();
    for line in text.lines() {
        let line = if line.contains("y[0] = 0;") {
            line.replace("= 0;", "= measured();")
        } else if line.contains("u[0] = 0;") || line.contains("r[0] = 0;") {
            line.replace("= 0;", "= input();")
        } else if line.contains("plant_step(&observer") {
            format!("{line} REPORT(xhat);")
        } else {
            line.to_owned()
        };
        filled.push_str(&line);
        filled.push('\n');
    }
    std::fs::write(path, filled).unwrap();
}

/// The times and the estimates that a program reports.
fn reported(text: &str) -> (Vec<i64>, Vec<Vec<f64>>) {
    let lines = text.lines().map(|line| line.split_once(' ').unwrap());
    lines.map(|(time, estimate)| (time.parse::<i64>().unwrap(), numbers(estimate))).unzip()
}

#[test]
fn a_sketch_takes_a_step_each_period() {
    let Some(compiler) = compilers().first().copied().filter(|_| is_there("g++")) else { return };
    for (name, export) in all_calls() {
        let folder = folder(&format!("arduino-{name}"));
        let files = export.c_in(Layout::Arduino).unwrap();
        write(&files, &folder);
        fill_in(&folder, SKETCH);
        // The loop is called more often than a sample is due, across the end of the counter; at varying periods it is
        // late.
        let wait = if is_varying(name) { "1 + late(k + 1)" } else { "1" };
        let main = format!(
            "#define PRINT_EVERY 1000\n#include \"Arduino.h\"\n#include \"examples/plant/plant.ino\"\nint main() {{ setup(); for (int k = 0; k < STEPS; ++k) {{ loop(); loop(); clock_us += PERIOD - 1; loop(); clock_us += {wait}; }} }}\n"
        );
        std::fs::write(folder.join("main.cpp"), main).unwrap();
        run(Command::new(compiler).current_dir(&folder).args(["-std=gnu11", "-O2", "-c", "src/plant.c"]));
        run(Command::new("g++")
            .current_dir(&folder)
            .args(STRICT)
            .args(["-std=c++11", "-Isrc", "-I."])
            .arg(format!("-DPERIOD={}", period(name)))
            .arg(format!("-I{}", stubs().display()))
            .args(["main.cpp", "plant.o", "-lm", "-o", "sketch"]));
        let (times, found) = reported(&run(&mut Command::new(folder.join("sketch"))));
        let between = |k: i64| period(name) + if is_varying(name) { late(name, k) } else { 0 };
        assert_eq!(times, (0..STEPS).map(|k| (1..=k).map(between).sum()).collect::<Vec<i64>>(), "{name}");
        let expected = expected(&export, |k| time(&export, between(k), 1e-6 / unit(name)));
        assert_agree(name, &found, &expected);
    }
}

/// A sketch prints ten times a second at the most, more digits than two, and integers as they are.
#[test]
fn a_sketch_prints_some_of_its_steps() {
    if compilers().is_empty() || !is_there("g++") {
        return;
    }
    let folder = folder("arduino-print");
    write(&export(1, Scalar::Binary64).c_in(Layout::Arduino).unwrap(), &folder);
    // A period of 50 us.
    std::fs::write(
        folder.join("main.cpp"),
        "#include \"Arduino.h\"\n#include \"examples/plant/plant.ino\"\nint main() { setup(); for (int k = 0; k < 5999; ++k) { loop(); clock_us += 50; } }\n",
    )
    .unwrap();
    run(Command::new("gcc").current_dir(&folder).args(["-std=gnu11", "-c", "src/plant.c"]));
    let include = format!("-I{}", stubs().display());
    run(Command::new("g++").current_dir(&folder).args([
        "-DPERIOD=50",
        "-Isrc",
        "-I.",
        &include,
        "main.cpp",
        "plant.o",
        "-o",
        "sketch",
    ]));
    let text = run(&mut Command::new(folder.join("sketch")));
    assert_eq!(text.lines().map(|line| numbers(line).len()).collect::<Vec<_>>(), [2, 2], "{text}");
    let sketch = std::fs::read_to_string(folder.join(SKETCH)).unwrap();
    assert!(sketch.contains("Serial.print(xhat[i], 6);"), "{sketch}");
}

/// Where `float` and `double` are rounded to their type the source compiles: by a method of 16 as well, which is that
/// of compilers with `_Float16` under -std=gnu11. Where they are not, and under -ffast-math, it does not.
#[test]
fn the_source_compiles_where_operations_are_rounded_to_their_type() {
    let Some(compiler) = compilers().first().copied() else { return };
    let folder = folder("methods");
    std::fs::create_dir_all(folder.join("other")).unwrap();
    for (scalar, exact) in [(Scalar::Binary32, &[0, 16, 32][..]), (Scalar::Binary64, &[0, 1, 16, 32, 64])] {
        write(&export(1, scalar).c().unwrap(), &folder);
        let compile = |options: &[&str]| {
            let output = Command::new(compiler).current_dir(&folder).args(options).args(["-c", "plant.c"]).output();
            let output = output.unwrap();
            (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        for method in [-1, 0, 1, 2, 16, 32, 33, 64] {
            let text = format!(
                "#define FLT_MANT_DIG 24\n#define DBL_MANT_DIG 53\n#define FLT_EVAL_METHOD {method}\n#define FLT_MAX 0x1.fffffep+127f\n#define DBL_MAX 0x1.fffffffffffffp+1023\n"
            );
            std::fs::write(folder.join("other/float.h"), text).unwrap();
            let (compiles, said) = compile(&["-Iother"]);
            assert_eq!(compiles, exact.contains(&method), "{scalar:?} {method}: {said}");
            assert!(compiles || said.contains("have to be rounded to their type"), "{said}");
        }
        assert!(compile(&["-std=gnu11", "-Wall", "-Wextra", "-Werror"]).0);
        let (compiles, said) = compile(&["-ffast-math"]);
        assert!(!compiles && said.contains("-ffast-math reorders"), "{said}");
    }
}

/// The period is a number of the format: to pass it converts nothing.
#[test]
fn the_period_is_a_number_of_the_format() {
    let Some(compiler) = compilers().first().copied() else { return };
    for (scalar, name, value) in [(Scalar::Binary32, "float", "0.05f"), (Scalar::Binary64, "double", "0.05")] {
        let folder = folder(&format!("period-{name}"));
        let files = export(1, scalar).c().unwrap();
        assert!(files[0].text.contains(&format!("#define PLANT_PERIOD {value}\n")), "{}", files[0].text);
        write(&files, &folder);
        let user =
            format!("#include \"plant.h\"\n{name} period(void);\n{name} period(void) {{ return PLANT_PERIOD; }}\n");
        std::fs::write(folder.join("user.c"), user).unwrap();
        let strict =
            ["-std=c99", "-Wconversion", "-Wfloat-conversion", "-Wdouble-promotion", "-Werror", "-c", "user.c"];
        run(Command::new(compiler).current_dir(&folder).args(strict));
    }
}

/// The options of a sketch, and of a compiler without any, allow a product and a sum to become one operation; the
/// source does not.
#[test]
fn the_library_of_arduino_keeps_the_bits_under_its_options() {
    let Some(compiler) = compilers().first().copied().filter(|_| has_haswell()) else { return };
    let folder = folder("arduino-bits");
    write(&export(1, Scalar::Binary64).c_in(Layout::Arduino).unwrap(), &folder);
    let build =
        ["-std=gnu11", "-O2", "-march=haswell", "-Isrc", "src/plant.c", "extras/test_plant.c", "-lm", "-o", "test"];
    run(Command::new(compiler).current_dir(&folder).args(build));
    assert!(run(&mut Command::new(folder.join("test"))).contains("64 of 64 steps agree"));
    let plain = self::folder("plain-bits");
    write(&export(1, Scalar::Binary64).c().unwrap(), &plain);
    let build = ["-std=gnu11", "-O2", "-march=haswell", "plant.c", "test_plant.c", "-lm", "-o", "test"];
    run(Command::new(compiler).current_dir(&plain).args(build));
    assert!(run(&mut Command::new(plain.join("test"))).contains("64 of 64 steps agree"));
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    assert!(readme.contains("-Isrc src/plant.c extras/test_plant.c"), "{readme}");
}

#[test]
fn a_module_of_zephyr_and_a_component_of_esp_idf_take_a_step_each_period() {
    let Some(compiler) = compilers().first().copied() else { return };
    for (name, export) in all_calls() {
        for (layout, main) in [(Layout::Zephyr, "sample/src/main.c"), (Layout::EspIdf, "example/main/main.c")] {
            let folder = folder(&format!("{layout:?}-{name}"));
            write(&export.c_in(layout).unwrap(), &folder);
            fill_in(&folder, main);
            let include = format!("-I{}", stubs().display());
            let defined = format!("-DPERIOD={}", period(name));
            let build =
                ["-std=c99", "-ffp-contract=off", "-I.", &include, &defined, main, "plant.c", "-lm", "-o", "main"];
            run(Command::new(compiler).current_dir(&folder).args(STRICT).args(["-Wno-unused-function"]).args(build));
            let (times, found) = reported(&run(&mut Command::new(folder.join("main"))));
            // Zephyr's program takes a sample at its start, ESP-IDF's timer one after the first period.
            let first = i64::from(layout != Layout::Zephyr);
            let due: Vec<i64> = (0..STEPS).map(|k| (k + first) * period(name) + late(name, k)).collect();
            assert_eq!(times, due, "{name} {layout:?}");
            let elapsed = |k: i64| {
                let between = |scale: fn(i64) -> i64| scale(due[k as usize]) - scale(due[k as usize - 1]);
                match (layout, is_slow(name)) {
                    (Layout::Zephyr, false) => time(&export, between(|us| 64 * us), 1.0 / unit(name) / 64e6),
                    (Layout::Zephyr, true) => time(&export, between(|us| us / 100), 1.0 / unit(name) / 1e4),
                    _ => time(&export, between(|us| us), 1e-6 / unit(name)),
                }
            };
            assert_agree(name, &found, &expected(&export, elapsed));
        }
    }
}

/// The lists of CMake, with the functions of either system as they are documented.
#[test]
fn the_build_files_of_zephyr_and_esp_idf_build_the_library() {
    if compilers().is_empty() || !is_there("cmake") {
        return;
    }
    let zephyr = "
set(CONFIG_PLANT y)
macro(zephyr_library_named name)
  add_library(${name} STATIC)
  set(current ${name})
endmacro()
macro(zephyr_library_sources)
  target_sources(${current} PRIVATE ${ARGN})
endmacro()
macro(zephyr_library_compile_options)
  target_compile_options(${current} PRIVATE ${ARGN})
endmacro()
macro(zephyr_include_directories)
  include_directories(${ARGN})
endmacro()
add_subdirectory(module/zephyr)
";
    let esp_idf = "
set(ESP_PLATFORM 1)
macro(idf_component_register)
  cmake_parse_arguments(of \"\" \"\" \"SRCS;INCLUDE_DIRS\" ${ARGN})
  set(COMPONENT_LIB plant)
  add_library(plant STATIC ${of_SRCS})
  target_include_directories(plant PUBLIC ${of_INCLUDE_DIRS})
endmacro()
add_subdirectory(module)
";
    for (layout, functions) in [(Layout::Zephyr, zephyr), (Layout::EspIdf, esp_idf)] {
        let folder = folder(&format!("cmake-{layout:?}"));
        write(&export(1, Scalar::Binary64).c_in(layout).unwrap(), &folder.join("module"));
        let use_it = "add_executable(user user.c)\ntarget_include_directories(user PRIVATE module)\ntarget_link_libraries(user plant m)\n";
        let text = format!("cmake_minimum_required(VERSION 3.13)\nproject(all C)\n{functions}{use_it}");
        std::fs::write(folder.join("CMakeLists.txt"), text).unwrap();
        let user = "#include <plant.h>\nint main(void) { plant_state state; plant_reset(&state); return 0; }\n";
        std::fs::write(folder.join("user.c"), user).unwrap();
        run(Command::new("cmake").current_dir(&folder).args(["-S", ".", "-B", "build"]));
        run(Command::new("cmake").current_dir(&folder).args(["--build", "build"]));
        run(&mut Command::new(folder.join("build/user")));
        let commands =
            run(Command::new("cmake").current_dir(&folder).args(["--build", "build", "--clean-first", "-v"]));
        assert!(
            commands.lines().any(|line| line.contains("-ffp-contract=off") && line.contains("plant.c")),
            "{commands}"
        );
    }
}

#[test]
fn a_node_of_ros_2_takes_a_step_for_each_message() {
    if compilers().is_empty() || !is_there("g++") {
        return;
    }
    for (name, export) in all_calls() {
        let folder = folder(&format!("ros2-{name}"));
        let files = export.c_in(Layout::Ros2).unwrap();
        write(&files, &folder);
        run(Command::new("gcc").current_dir(&folder).args(["-std=c99", "-ffp-contract=off", "-c", "plant.c"]));
        let size = export.observer().dimensions();
        run(Command::new("g++")
            .current_dir(&folder)
            .args(STRICT)
            .args(["-std=c++17", "-I."])
            .arg(format!("-DOUTPUTS={}", size.outputs))
            .arg(format!("-DINPUTS={}", export.observer().plant_inputs()))
            .arg(format!("-DPERIOD={}", period(name)))
            .arg(format!("-DIS_VARYING={}", i32::from(is_varying(name))))
            .arg(format!("-I{}", stubs().display()))
            .args(["src/plant_node.cpp", "plant.o", "-lm", "-o", "node"]));
        let text = run(&mut Command::new(folder.join("node")));
        assert!(text.starts_with(&format!("plant\ny has {} entries\n", size.outputs + 1)), "{text}");
        let estimates: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("xhat")).map(numbers).collect();
        let expected = match export.observer() {
            ExportableObserver::Varying(step) if export.scalar() == Scalar::Binary64 => of_node(name, step),
            // The estimates in binary32 are those of the Rust crate; here the program compiles.
            ExportableObserver::Varying(_) => continue,
            _ => expected(&export, |_| 0.0),
        };
        assert_agree(name, &estimates, &expected);
        let sent = if export.has_feedback() { STEPS as usize } else { 0 };
        assert_eq!(text.lines().filter(|line| line.starts_with("u ")).count(), sent);
        let package = &files.iter().find(|file| file.name == "package.xml").unwrap().text;
        assert!(package.contains("<name>plant</name>") && package.contains("<depend>std_msgs</depend>"), "{package}");
    }
}

/// The estimates of a node at varying periods: the input changes at each sample, after it, and between two samples.
fn of_node(name: &str, step: &VaryingPeriodStep<f64, Dyn, Dyn, Dyn>) -> Vec<Vec<f64>> {
    let has_input = step.dimensions().inputs > 1;
    let column = |u: f64, dt: f64| DVector::from_vec(if has_input { vec![u, dt] } else { vec![dt] });
    let at = |k: i64| (k + 1) * period(name) + late(name, k);
    let time = |us: i64| (1000 * us) as f64 / 1e9 / unit(name);
    let mut xhat = DVector::from_vec(vec![0.5, -1.25]);
    let sample = |k: i64| {
        let mut dt = 0.0;
        if k > 0 {
            let part = period(name) / 3;
            dt = time(at(k) - at(k - 1));
            let rest = at(k) - at(k - 1) - part;
            let parts = [(time(part), input(2 * k - 2)), (time(rest), input(2 * k - 1))];
            if has_input {
                for (time, u) in parts {
                    step.observer().predict(&mut xhat, &column(u, time), time);
                }
            } else {
                step.observer().predict(&mut xhat, &column(0.0, dt), dt);
            }
        }
        let u = if k > 0 { input(2 * k - 1) } else { 0.0 };
        step.observer().correct(&mut xhat, &column(u, dt), &DVector::from_element(1, measured(k)), dt);
        xhat.as_slice().to_vec()
    };
    (0..STEPS).map(sample).collect()
}

/// A sketch in integers says by which power of two they are scaled.
#[test]
fn a_sketch_in_fixed_point() {
    let Some(compiler) = compilers().first().copied().filter(|_| is_there("g++")) else { return };
    let export = export(1, Scalar::Binary64);
    let formats = FixedPointFormat::new(8, 16).unwrap().into();
    let files = export.fixed_point(formats).unwrap().c_in(Layout::Arduino).unwrap();
    let folder = folder("arduino-fixed");
    write(&files, &folder);
    let sketch = &files.iter().find(|file| file.name == SKETCH).unwrap().text;
    assert!(sketch.contains("The outputs, measured now, times 2^PLANT_FRACTION_BITS: fill in."), "{sketch}");
    let main = "#include \"Arduino.h\"\n#include \"examples/plant/plant.ino\"\nint main() { setup(); loop(); }\n";
    let main = format!("#define PRINT_EVERY 1\n{main}");
    std::fs::write(folder.join("main.cpp"), main).unwrap();
    run(Command::new(compiler).current_dir(&folder).args(["-std=gnu11", "-c", "src/plant.c"]));
    let include = format!("-I{}", stubs().display());
    run(Command::new("g++").current_dir(&folder).args([
        "-DPERIOD=50",
        "-Isrc",
        "-I.",
        &include,
        "main.cpp",
        "plant.o",
        "-o",
        "sketch",
    ]));
    let found = numbers(&run(&mut Command::new(folder.join("sketch"))));
    let first = export.fixed_point(formats).unwrap().replay(&[(vec![0.0], vec![0.0])]);
    let scaled: Vec<f64> = first[0].iter().map(|x| x * 65536.0).collect();
    assert_eq!(found, scaled);
}

#[test]
fn periods_without_a_timer_are_refused() {
    let error = |unit: &str| {
        let names = Names { time_unit: unit.to_owned(), ..Names::numbered(2, 1, 1) };
        let export = Export::new("plant", program(5, (2, 1, 1), false, false), Scalar::Binary64, &[0.0; 2], names);
        export.unwrap().c_in(Layout::Arduino).unwrap_err().to_string()
    };
    assert!(error("ns").contains("1e-6 to 2000 s are"), "{}", error("ns"));
    // 0.05 d, more than 2^31 us: a counter of 32 bits does not know whether that is ahead.
    assert!(error("d").contains("a period of 4320 s"), "{}", error("d"));
    assert!(error("fortnight").contains("\"fortnight\" cannot be converted to seconds"), "{}", error("fortnight"));
}

/// A timer of whole microseconds would step every 2 us in place of 1.5: by far not the design. A part of 5e-5 is that
/// of a crystal; a program at varying periods measures the time; a node has no timer.
#[test]
fn periods_that_a_timer_rounds_are_refused() {
    let at = |period: f64, layout: Layout| {
        let plant = StateSpace::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0]).unwrap();
        let observer = DiscreteLinearObserver::new(plant, dmatrix![0.25], period).unwrap();
        let names = Names::numbered(1, 1, 1);
        let export = Export::new("plant", ExportableObserver::Linear(observer), Scalar::Binary64, &[0.0], names);
        export.unwrap().c_in(layout)
    };
    for layout in [Layout::Arduino, Layout::Zephyr, Layout::EspIdf] {
        let error = at(1.5e-6, layout).unwrap_err().to_string();
        assert_eq!(
            error,
            "a period of 0.0000015 s is no whole number of microseconds, the unit of the timers of boards; 2e-6 s is"
        );
        assert!(at(3.3333e-5, layout).unwrap_err().to_string().ends_with("33e-6 s is"));
        assert!(at(1.0 / 60.0, layout).is_ok());
        // The sum of decimals is no decimal.
        assert!(at(0.1 + 0.2, layout).is_ok());
    }
    assert!(at(1.5e-6, Layout::Ros2).is_ok() && at(1e6, Layout::Ros2).is_ok());
}

/// The call that a README shows compiles.
#[test]
fn the_call_of_the_readme_compiles() {
    let Some(compiler) = compilers().first().copied() else { return };
    for (name, export) in all_calls() {
        let folder = folder(&format!("readme-{name}"));
        let files = export.c().unwrap();
        write(&files, &folder);
        let readme = &files.iter().find(|file| file.name == "README.md").unwrap().text;
        let code = readme.split("```c\n").nth(1).unwrap().split("```").next().unwrap();
        let (include, body) = code.split_once('\n').unwrap();
        let known = match (name, body.contains("dt, ")) {
            ("fed", _) => "double y[9] = {0}, r[9] = {0};",
            ("none", _) => "float y[9] = {0};",
            ("varying-f32", _) => "float y[9] = {0}, u[9] = {0}, dt = 0.1f;",
            (_, true) => "double y[9] = {0}, u[9] = {0}, dt = 0.1; (void)u;",
            _ => "double y[9] = {0}, u[9] = {0};",
        };
        assert_eq!(body.contains("dt, "), is_varying(name), "{readme}");
        let text = format!("{include}\nint main(void)\n{{\n{known}\n{body}\nreturn 0;\n}}\n");
        std::fs::write(folder.join("user.c"), text).unwrap();
        run(Command::new(compiler)
            .current_dir(&folder)
            .args(["-std=c99", "-Werror", "user.c", "plant.c", "-lm", "-o", "user"]));
        run(&mut Command::new(folder.join("user")));
    }
}

/// A compiler whose `double` has fewer bits than the design's, as that of 8-bit boards, does not compile the source.
#[test]
fn another_double_is_refused() {
    let Some(compiler) = compilers().first().copied() else { return };
    let folder = folder("double");
    write(&export(1, Scalar::Binary64).c().unwrap(), &folder);
    std::fs::create_dir_all(folder.join("other")).unwrap();
    std::fs::write(folder.join("other/float.h"), "#define FLT_MANT_DIG 24\n#define DBL_MANT_DIG 24\n").unwrap();
    let output = Command::new(compiler).current_dir(&folder).args(["-Iother", "-c", "plant.c"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && text.contains("double is not the format of the design"), "{text}");
}
