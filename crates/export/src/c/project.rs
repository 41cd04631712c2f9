//! Build file and README.

use super::{Call, scalar};
use crate::Export;

pub(super) fn cmake(name: &str) -> String {
    format!(
        "cmake_minimum_required(VERSION 3.10)
project({name} C)

add_library({name} STATIC {name}.c)
add_library({name}::{name} ALIAS {name})
target_include_directories({name} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
set_target_properties({name} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
if(CMAKE_C_COMPILER_ID MATCHES \"GNU|Clang\")
  # Operations are rounded one by one, as in the design.
  target_compile_options({name} PRIVATE -ffp-contract=off)
endif()
if(NOT MSVC)
  target_link_libraries({name} PUBLIC m)
endif()

# The test, unless this is part of another project or built for a target that cannot run it here.
if(CMAKE_SOURCE_DIR STREQUAL CMAKE_CURRENT_SOURCE_DIR AND (NOT CMAKE_CROSSCOMPILING OR CMAKE_CROSSCOMPILING_EMULATOR))
  enable_testing()
  add_executable(test_{name} test_{name}.c)
  target_link_libraries(test_{name} PRIVATE {name})
  add_test(NAME {name} COMMAND test_{name})
endif()
"
    )
}

pub(super) fn readme(export: &Export, count: usize) -> String {
    let (name, number) = (&export.identifier, scalar(export));
    let statement = export.statement.join("\n");
    let Call { is_fed, known, applied, elapsed } = Call::of(export);
    let about = match (known, elapsed) {
        ("r", _) => "the references r; the plant gets u = r - K xhat until the next sample",
        ("u", "") => "the inputs u held until the next sample",
        ("u", _) => "the inputs u held since the last one, the time dt before",
        (_, "") => "no inputs",
        _ => "the time dt since the last one",
    };
    let declared = if is_fed { format!("{number} u[{}_INPUTS];\n", name.to_uppercase()) } else { String::new() };
    format!(
        "# {name}

{}, one step per sample; {most}{} operations, {} bytes of constants and state, no allocation, no global state.

{statement}

```c
#include \"{name}.h\"

{name}_state state;
{name}_reset(&state);
/* every {period} {unit}, with the measured outputs y and {about} */
{declared}{number} xhat[{upper}_STATES];
{name}_step(&state, {known}, y, {applied}{elapsed}xhat);
```

The test compares {count} steps with the design, {agreement}:

```console
$ cc -std=c99 -O2 {name}.c test_{name}.c -lm -o test_{name} && ./test_{name}
```

Compilers must not contract or reorder floating-point operations: `-std=c99` or `-ffp-contract=off`, not `-ffast-math`.
",
        export.kind(),
        export.operations(),
        export.bytes(),
        most = if export.stack_of_window().is_some() { "at most " } else { "" },
        agreement = if export.calls_target() { "to half of the digits" } else { "bit by bit" },
        period = export.observer.period(),
        unit = if export.names.time_unit.is_empty() { "time units" } else { &export.names.time_unit },
        upper = name.to_uppercase(),
    )
}
