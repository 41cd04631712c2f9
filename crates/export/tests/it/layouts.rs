//! Exports in the layouts of boards and robots: their programs are compiled against the part of the system that they
//! use (`layouts/`), and run. Without a C compiler these tests say so and pass.

use std::path::{Path, PathBuf};
use std::process::Command;

use luenberger_export::{Export, ExportableObserver, File, FixedPointFormat, Layout, Names, Scalar, golden};

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
    vec![
        ("inputs", export(1, Scalar::Binary64)),
        ("none", export(0, Scalar::Binary32)),
        ("fed", with_feedback(export(1, Scalar::Binary64))),
        ("varying", of(varying(&program(3, (2, 1, 1), true, false)), 1, Scalar::Binary64)),
    ]
}

/// The estimates of three steps with zeros for outputs, and inputs or references.
fn expected(name: &str, export: &Export) -> Vec<Vec<f64>> {
    let size = export.observer().dimensions();
    let mut stepper = golden::Stepper::new(export).unwrap();
    let mut step = || {
        let mut u = vec![0.0; size.inputs];
        match name {
            "varying" => *u.last_mut().unwrap() = export.observer().period(),
            // The gain of `with_feedback`: u = 0 - K xhat.
            "fed" => u[0] -= 0.03 * stepper.estimate()[0] + (0.03 - 0.01) * stepper.estimate()[1],
            _ => {}
        }
        stepper.step(&u, &vec![0.0; size.outputs])
    };
    (0..3).map(|_| step()).collect()
}

#[track_caller]
fn assert_agree(name: &str, export: &Export, found: &[Vec<f64>]) {
    let expected = expected(name, export);
    assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), expected.iter().map(Vec::len).collect::<Vec<_>>());
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    // The feedback is summed by hand.
    assert!(
        pairs.clone().all(|(a, b)| a == b || name == "fed" && (a - b).abs() < 1e-15),
        "{name}: {found:?} {expected:?}"
    );
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_sketch_takes_a_step_each_period() {
    let Some(compiler) = compilers().first().copied().filter(|_| is_there("g++")) else { return };
    for (name, export) in all_calls() {
        let folder = folder(&format!("arduino-{name}"));
        let files = export.c_in(Layout::Arduino).unwrap();
        write(&files, &folder);
        // The loop is called more often than a sample is due, across the end of the counter.
        std::fs::write(
            folder.join("main.cpp"),
            "#include \"Arduino.h\"\n#include \"examples/plant/plant.ino\"\nint main() { setup(); for (int k = 0; k < 3; ++k) { loop(); loop(); now += PERIOD; } }\n",
        )
        .unwrap();
        let sketch = &files.iter().find(|file| file.name == SKETCH).unwrap().text;
        let period = sketch.split("due += ").nth(1).unwrap().split("UL").next().unwrap();
        run(Command::new(compiler).current_dir(&folder).args(["-std=gnu11", "-O2", "-c", "src/plant.c"]));
        run(Command::new("g++")
            .current_dir(&folder)
            .args(STRICT)
            .args(["-std=c++11", "-Isrc", "-I."])
            .arg(format!("-DPERIOD={period}UL"))
            .arg(format!("-I{}", stubs().display()))
            .args(["main.cpp", "plant.o", "-lm", "-o", "sketch"]));
        let text = run(&mut Command::new(folder.join("sketch")));
        let found: Vec<Vec<f64>> = text.lines().map(numbers).collect();
        assert_agree(name, &export, &found);
    }
}

/// The options of a sketch allow a product and a sum to become one operation; the source does not.
#[test]
fn the_library_of_arduino_keeps_the_bits_under_its_options() {
    let Some(compiler) = compilers().first().copied().filter(|_| has_haswell()) else { return };
    let folder = folder("arduino-bits");
    write(&export(1, Scalar::Binary64).c_in(Layout::Arduino).unwrap(), &folder);
    let build =
        ["-std=gnu11", "-O2", "-march=haswell", "-Isrc", "src/plant.c", "extras/test_plant.c", "-lm", "-o", "test"];
    run(Command::new(compiler).current_dir(&folder).args(build));
    assert!(run(&mut Command::new(folder.join("test"))).contains("64 of 64 steps agree"));
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
            let include = format!("-I{}", stubs().display());
            let build = ["-std=c99", "-I.", &include, main, "plant.c", "-lm", "-o", "main"];
            run(Command::new(compiler).current_dir(&folder).args(STRICT).args(["-Wno-unused-function"]).args(build));
            let text = run(&mut Command::new(folder.join("main")));
            let period = (1e3 * export.observer().period()).round();
            assert_eq!(text, format!("{period} us\n").repeat(3), "{name} {layout:?}");
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
            .arg(format!("-I{}", stubs().display()))
            .args(["src/plant_node.cpp", "plant.o", "-lm", "-o", "node"]));
        let text = run(&mut Command::new(folder.join("node")));
        assert!(text.starts_with(&format!("plant\ny has {} entries\n", size.outputs + 1)), "{text}");
        let estimates: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("xhat")).map(numbers).collect();
        assert_agree(name, &export, &estimates);
        assert_eq!(text.lines().filter(|line| line.starts_with("u ")).count(), if name == "fed" { 3 } else { 0 });
        let package = &files.iter().find(|file| file.name == "package.xml").unwrap().text;
        assert!(package.contains("<name>plant</name>") && package.contains("<depend>std_msgs</depend>"), "{package}");
    }
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
    std::fs::write(folder.join("main.cpp"), main).unwrap();
    run(Command::new(compiler).current_dir(&folder).args(["-std=gnu11", "-c", "src/plant.c"]));
    let include = format!("-I{}", stubs().display());
    run(Command::new("g++")
        .current_dir(&folder)
        .args(["-Isrc", "-I.", &include, "main.cpp", "plant.o", "-o", "sketch"]));
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
            (_, true) => "double y[9] = {0}, u[9] = {0}, dt = 0.1; (void)u;",
            _ => "double y[9] = {0}, u[9] = {0};",
        };
        assert_eq!(body.contains("dt, "), name == "varying", "{readme}");
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
