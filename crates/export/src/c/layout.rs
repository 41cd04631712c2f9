//! The files of a C99 project as the build systems of boards and robots expect them, with a skeleton of the program
//! around the step.

use std::fmt::Write;

use super::{Call, harmless};
use crate::error::ExportError;
use crate::{Export, File};

/// How the files of an export in C lie in their folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// A library for the Arduino IDE and for PlatformIO.
    Arduino,
    /// A module of Zephyr.
    Zephyr,
    /// A component of ESP-IDF.
    EspIdf,
    /// A package of ROS 2.
    Ros2,
}

impl std::str::FromStr for Layout {
    type Err = String;

    /// `arduino`, `zephyr`, `esp-idf`, `ros2`.
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "arduino" => Ok(Self::Arduino),
            "zephyr" => Ok(Self::Zephyr),
            "esp-idf" => Ok(Self::EspIdf),
            "ros2" => Ok(Self::Ros2),
            _ => Err("arduino, zephyr, esp-idf or ros2 is expected".to_owned()),
        }
    }
}

/// The longest period in microseconds: a time that is further ahead than half the range of a counter of 32 bits, 2^31,
/// would count as past.
const LONGEST: f64 = 2e9;

/// By how much of itself a period may be rounded to microseconds: crystals are not more accurate than that.
const ROUNDING: f64 = 5e-5;

/// What the files say of an export.
struct About<'a> {
    name: &'a str,
    upper: String,
    /// The type of the numbers.
    number: &'a str,
    /// One sentence.
    says: String,
    /// The period in microseconds.
    microseconds: u64,
    call: Call,
    /// Of an observer at varying periods.
    varying: Option<Varying>,
    /// Names of states, inputs and outputs.
    columns: [Vec<String>; 3],
}

/// The time that an observer at varying periods takes.
struct Varying {
    /// The name of its unit.
    unit: String,
    /// The unit in seconds.
    seconds: f64,
    /// The longest time that is predicted with full accuracy, in seconds.
    longest: f64,
}

/// A clock of a board.
struct Clock {
    /// The type of its count, whose differences are right also where it starts again.
    count: &'static str,
    /// The expression that reads it.
    now: &'static str,
    /// An expression of the units of time in one count.
    tick: String,
}

/// What a node of ROS 2 does with the time.
struct Timed {
    /// Member functions.
    functions: String,
    /// Member variables.
    members: &'static str,
    /// Further headers.
    include: &'static str,
    /// What a sample does to the observer.
    sample: String,
    /// What comes before another input.
    change: &'static str,
}

impl Timed {
    /// At a constant period nothing but the step.
    fn constant(step: &str) -> Self {
        let estimate = format!("        {step}\n");
        Self { functions: String::new(), members: "", include: "", sample: estimate, change: "" }
    }
}

impl Varying {
    /// The node of an observer at varying periods: a prediction at each change of the input, and the correction with
    /// the time since the last sample.
    fn of_node(&self, name: &str, number: &str, known: &str) -> Timed {
        let Self { unit, seconds, .. } = self;
        let time = if *seconds == 1.0 { String::new() } else { format!(" / {seconds:?}") };
        let functions = format!(
            "    // The time between two instants in {unit}. They are those at which messages are taken; where a message has
    // the time of its measurement, that is better.
    static {number} between(const rclcpp::Time &first, const rclcpp::Time &second)
    {{
        // A clock of a simulation may be set back.
        return static_cast<{number}>(std::max(0.0, (second - first).seconds()){time});
    }}

    // To this instant, with the input that was applied until then. The first estimate is that of the first sample.
    void predict(const rclcpp::Time &time)
    {{
        if (has_sample_) {{
            {name}_predict(&state_, {known}, between(predicted_, time));
        }}
        predicted_ = time;
    }}

"
        );
        let sample = format!(
            "        const rclcpp::Time time = now();
        predict(time);
        {name}_update(&state_, {known}, y.data(), has_sample_ ? between(sampled_, time) : {number}{{0}});
        std::copy(std::begin(state_.xhat), std::end(state_.xhat), xhat.begin());
        sampled_ = time;
        has_sample_ = true;
"
        );
        Timed {
            functions,
            members: "    rclcpp::Time predicted_;\n    rclcpp::Time sampled_;\n    bool has_sample_ = false;\n",
            include: "#include <iterator>\n",
            sample,
            change: "                predict(now());\n",
        }
    }
}

impl Layout {
    /// The files of the export in this layout. `number` is the type of its signals.
    ///
    /// # Errors
    /// [`ExportError::TimeUnit`] if the unit of time is not known; on a board [`ExportError::Period`] for a period of
    /// less than a microsecond or more than [`LONGEST`], [`ExportError::FractionalPeriod`] for one that is no whole
    /// number of microseconds.
    pub(crate) fn place(self, export: &Export, files: Vec<File>, number: &str) -> Result<Vec<File>, ExportError> {
        let seconds = export.period_in_seconds()?;
        let microseconds = (1e6 * seconds).round();
        // A node takes a step for each message; the boards have timers.
        let has_timer = self != Self::Ros2;
        if has_timer && !(1.0..=LONGEST).contains(&microseconds) {
            return Err(ExportError::Period { seconds });
        }
        if has_timer && !export.observer.takes_time() && (1e6 * seconds - microseconds).abs() > ROUNDING * microseconds
        {
            return Err(ExportError::FractionalPeriod { seconds, microseconds: microseconds as u64 });
        }
        let name = export.identifier.as_str();
        let longest = export.observer.scalars().iter().find(|(name, _)| *name == "LONGEST").map(|(_, x)| *x);
        let unit = export.time_unit_in_seconds()?;
        let varying = longest.map(|longest| Varying {
            unit: if export.names.time_unit.is_empty() { "s".to_owned() } else { harmless(&export.names.time_unit) },
            seconds: unit,
            longest: longest * unit,
        });
        let column = |names: &[String]| names.iter().map(|name| harmless(name)).collect();
        let about = About {
            name,
            upper: name.to_uppercase(),
            number,
            says: format!(
                "{}, one step every {seconds} s{}",
                export.kind(),
                if varying.is_some() { ", nominally" } else { "" }
            ),
            microseconds: microseconds as u64,
            call: Call::of(export),
            varying,
            columns: [column(&export.names.states), column(&export.names.inputs), column(&export.names.outputs)],
        };
        Ok(match self {
            Self::Arduino => about.arduino(files),
            Self::Zephyr => about.zephyr(files),
            Self::EspIdf => about.esp_idf(files),
            Self::Ros2 => about.ros2(files),
        })
    }
}

fn file(name: impl Into<String>, text: impl Into<String>) -> File {
    File { name: name.into(), text: text.into() }
}

/// Appends to the README.
fn explain(files: &mut [File], text: &str) {
    if let Some(readme) = files.iter_mut().find(|file| file.name == "README.md") {
        readme.text.push('\n');
        readme.text.push_str(text);
    }
}

impl About<'_> {
    /// The functions that connect the step with the plant, to be filled in.
    fn connections(&self) -> String {
        let Self { number, columns: [_, inputs, outputs], call, .. } = self;
        let mut text = String::new();
        let scaled =
            if *number == "int32_t" { format!(", times 2^{}_FRACTION_BITS", self.upper) } else { String::new() };
        let mut function = |name: &str, about: &str, argument: &str, column: &[String]| {
            _ = writeln!(text, "/* {about}{scaled}: fill in. */\nstatic void {name}({number} *{argument})\n{{");
            for (i, name) in column.iter().enumerate() {
                _ = writeln!(text, "    {argument}[{i}] = 0; /* {name} */");
            }
            text.push_str("}\n\n");
        };
        function("measure", "The outputs, measured now", "y", outputs);
        if call.is_fed {
            function("reference", "The references", "r", inputs);
        } else if !inputs.is_empty() {
            function("applied", "The inputs, held until the next sample", "u", inputs);
        }
        text
    }

    /// The time since the last sample, by a clock of the board; empty at a constant period.
    fn elapsed(&self, clock: impl FnOnce(&Varying) -> Clock) -> String {
        let Some(varying) = &self.varying else { return String::new() };
        let (number, unit) = (self.number, &varying.unit);
        let Clock { count, now, tick } = clock(varying);
        format!(
            "/* The time since the last call in {unit}; 0 at the first one, which the first estimate is of. */
static {number} elapsed(void)
{{
    static {count} last;
    static int has_last = 0;
    const {count} now = ({count}){now};
    const {number} dt = (has_last != 0) ? ({number})({count})(now - last) * {tick} : {zero};

    last = now;
    has_last = 1;
    return dt;
}}

",
            zero = self.literal(0.0),
        )
    }

    /// A literal of the type of the numbers.
    fn literal(&self, x: f64) -> String {
        format!("{x:?}{}", if self.number == "float" { "f" } else { "" })
    }

    /// One sample: declarations, what is read, the step. At varying periods the input is the one that was held since
    /// the last sample.
    fn sample(&self, indent: &str) -> String {
        let Self { name, upper, number, columns: [_, inputs, _], call, .. } = self;
        let has_inputs = !inputs.is_empty();
        let is_varying = self.varying.is_some();
        let mut lines = vec![format!("{number} xhat[{upper}_STATES];"), format!("{number} y[{upper}_OUTPUTS];")];
        if call.is_fed {
            lines.push(format!("{number} r[{upper}_INPUTS];"));
        }
        if has_inputs && is_varying {
            lines.push(format!("static {number} u[{upper}_INPUTS]; /* Held since the last sample. */"));
        } else if has_inputs {
            lines.push(format!("{number} u[{upper}_INPUTS];"));
        }
        if is_varying {
            lines.push(format!("const {number} dt = elapsed();"));
        }
        lines.extend([String::new(), "measure(y);".to_owned()]);
        if call.is_fed {
            lines.push("reference(r);".to_owned());
        } else if has_inputs && !is_varying {
            lines.push("applied(u);".to_owned());
        }
        lines.push(format!("{name}_step(&observer, {}, y, {}{}xhat);", call.known, call.applied, call.elapsed));
        if call.is_fed {
            lines.push("/* Apply u to the plant. */".to_owned());
        } else if has_inputs && is_varying {
            lines.push("applied(u);".to_owned());
        }
        lines.iter().fold(
            String::new(),
            |text, line| {
                if line.is_empty() { text + "\n" } else { text + indent + line + "\n" }
            },
        )
    }

    fn arduino(&self, files: Vec<File>) -> Vec<File> {
        let Self { name, says, microseconds, upper, .. } = self;
        let mut placed = Vec::new();
        for mut file in files {
            match file.name.as_str() {
                "CMakeLists.txt" => continue,
                "README.md" => {
                    let command = format!("{name}.c test_{name}.c");
                    file.text = file.text.replace(&command, &format!("-Isrc src/{name}.c extras/test_{name}.c"));
                }
                test if test.starts_with("test_") => file.name = format!("extras/{test}"),
                source => file.name = format!("src/{source}"),
            }
            placed.push(file);
        }
        placed.push(self::file(
            "library.properties",
            format!(
                "name={name}\nversion=1.0.0\nauthor=luenberger\nmaintainer=luenberger\nsentence={says}.\nparagraph=An observer: the state of a plant from its measured outputs.\ncategory=Data Processing\nurl=https://example.org/{name}\narchitectures=*\nincludes={name}.h\n"
            ),
        ));
        placed.push(self::file(
            "library.json",
            format!(
                "{{\n  \"name\": \"{name}\",\n  \"version\": \"1.0.0\",\n  \"description\": \"{says}.\",\n  \"build\": {{ \"flags\": \"-ffp-contract=off\" }}\n}}\n"
            ),
        ));
        placed.push(self::file(
            format!("examples/{name}/{name}.ino"),
            format!(
                "/* {says}. */
#include <{name}.h>

/* A line of numbers takes milliseconds: one in so many steps. */
#ifndef PRINT_EVERY
#define PRINT_EVERY {every}
#endif

static {name}_state observer;
static uint32_t due;
static unsigned long steps;

{connections}{elapsed}void setup()
{{
    Serial.begin(115200);
    {name}_reset(&observer);
    due = (uint32_t)micros();
}}

void loop()
{{
    /* The difference is right also where the counter starts again. */
    if ((int32_t)((uint32_t)micros() - due) < 0) {{
        return;
    }}
{due}

{sample}
    if (++steps < PRINT_EVERY) {{
        return;
    }}
    steps = 0;
    for (int i = 0; i < {upper}_STATES; ++i) {{
        Serial.print(xhat[i]{digits});
        Serial.print((i + 1 < {upper}_STATES) ? ' ' : '\\n');
    }}
}}
",
                due = if self.varying.is_some() {
                    format!("    due = (uint32_t)micros() + {microseconds}UL;")
                } else {
                    format!("    due += {microseconds}UL;")
                },
                // Ten lines a second at the most.
                every = (100_000 / microseconds).max(1),
                digits = if self.number == "int32_t" { "" } else { ", 6" },
                connections = self.connections(),
                elapsed = self.elapsed(|varying| Clock {
                    count: "uint32_t",
                    now: "micros()",
                    tick: self.literal(1e-6 / varying.seconds),
                }),
                sample = self.sample("    "),
            ),
        ));
        let double = if self.number == "double" {
            "\nOn 8-bit AVR boards `double` has 32 bits, and the source refuses to compile: export with `--format f32` or in\nfixed point.\n"
        } else {
            ""
        };
        let late = if self.varying.is_some() {
            "The step takes the time\nsince the last one by `micros()`: after a pause of the sketch it predicts over the pause."
        } else {
            "After a pause the\nsketch takes the steps it has missed one after the other, with what it measures then."
        };
        explain(
            &mut placed,
            &format!(
                "## Arduino and PlatformIO

The folder is a library: copy it into `libraries` of the sketchbook (or *Sketch > Include Library > Add .ZIP Library*),
or into `lib` of a PlatformIO project. `examples/{name}/{name}.ino` is a sketch to be filled in: it steps the observer
every {microseconds} us and prints the estimate, not more than ten times a second. {late}
{double}"
            ),
        );
        placed
    }

    fn zephyr(&self, mut files: Vec<File>) -> Vec<File> {
        let Self { name, upper, says, microseconds, .. } = self;
        files.push(file(
            "zephyr/module.yml",
            format!("name: {name}\nbuild:\n  cmake: zephyr\n  kconfig: zephyr/Kconfig\n"),
        ));
        files.push(file(
            "zephyr/CMakeLists.txt",
            format!(
                "if(CONFIG_{upper})
  zephyr_library_named({name})
  zephyr_library_sources(${{CMAKE_CURRENT_LIST_DIR}}/../{name}.c)
  # Operations are rounded one by one, as in the design.
  zephyr_library_compile_options(-ffp-contract=off)
  zephyr_include_directories(${{CMAKE_CURRENT_LIST_DIR}}/..)
endif()
"
            ),
        ));
        files.push(file("zephyr/Kconfig", format!("config {upper}\n\tbool \"{says}\"\n")));
        files.push(file(
            "sample/CMakeLists.txt",
            format!(
                "cmake_minimum_required(VERSION 3.20.0)
list(APPEND ZEPHYR_EXTRA_MODULES ${{CMAKE_CURRENT_LIST_DIR}}/..)
find_package(Zephyr REQUIRED HINTS $ENV{{ZEPHYR_BASE}})
project({name}_sample)
target_sources(app PRIVATE src/main.c)
"
            ),
        ));
        let floats = if self.number == "int32_t" { "" } else { "CONFIG_FPU=y\n" };
        files.push(file("sample/prj.conf", format!("CONFIG_{upper}=y\n{floats}")));
        files.push(file(
            "sample/src/main.c",
            format!(
                "/* {says}. */
#include <{name}.h>
#include <zephyr/kernel.h>

static {name}_state observer;

{connections}{elapsed}int main(void)
{{
    struct k_timer timer;

    {name}_reset(&observer);
    k_timer_init(&timer, NULL, NULL);
    k_timer_start(&timer, K_USEC({microseconds}), K_USEC({microseconds}));
    for (;;) {{
{sample}
        k_timer_status_sync(&timer);
    }}
}}
",
                connections = self.connections(),
                elapsed = self.elapsed(|varying| {
                    // A counter of cycles starts again after some seconds; a tick may be as long as a short period.
                    let (count, now, rate) = if varying.longest <= 1.0 {
                        ("uint32_t", "k_cycle_get_32()", "sys_clock_hw_cycles_per_sec()")
                    } else {
                        ("int64_t", "k_uptime_ticks()", "CONFIG_SYS_CLOCK_TICKS_PER_SEC")
                    };
                    let tick = format!("({} / ({}){rate})", self.literal(1.0 / varying.seconds), self.number);
                    Clock { count, now, tick }
                }),
                sample = self.sample("        "),
            ),
        ));
        let accuracy = match &self.varying {
            Some(varying) if varying.longest > 1.0 => "The program measures the time between samples in these ticks.",
            Some(_) => "The program measures the time between samples in cycles.",
            None => "Set a rate of which the period is a multiple.",
        };
        explain(
            &mut files,
            &format!(
                "## Zephyr

The folder is a module: name it in `ZEPHYR_EXTRA_MODULES` (or in `west.yml`) and set `CONFIG_{upper}=y`.
`sample` is an application to be filled in, which steps the observer every {microseconds} us:

```console
$ west build -b BOARD sample
```

Zephyr rounds a period up to a whole number of ticks: at a `CONFIG_SYS_CLOCK_TICKS_PER_SEC` of 32768, 100 us become
122 us. {accuracy}

A board without a floating-point unit takes `CONFIG_FPU=y` out of `sample/prj.conf`.
"
            ),
        );
        files
    }

    fn esp_idf(&self, mut files: Vec<File>) -> Vec<File> {
        let Self { name, says, microseconds, .. } = self;
        if let Some(cmake) = files.iter_mut().find(|file| file.name == "CMakeLists.txt") {
            cmake.text = format!(
                "if(ESP_PLATFORM)
  idf_component_register(SRCS {name}.c INCLUDE_DIRS .)
  # Operations are rounded one by one, as in the design.
  target_compile_options(${{COMPONENT_LIB}} PRIVATE -ffp-contract=off)
  return()
endif()

{}",
                cmake.text
            );
        }
        files.push(file("idf_component.yml", format!("version: \"1.0.0\"\ndescription: \"{says}\"\n")));
        files.push(file(
            "example/CMakeLists.txt",
            format!(
                "cmake_minimum_required(VERSION 3.16)
set(EXTRA_COMPONENT_DIRS ${{CMAKE_CURRENT_LIST_DIR}}/..)
set(COMPONENTS main)
include($ENV{{IDF_PATH}}/tools/cmake/project.cmake)
project({name}_example)
"
            ),
        ));
        files.push(file(
            "example/main/CMakeLists.txt",
            format!("idf_component_register(SRCS main.c PRIV_REQUIRES {name} esp_timer)\n"),
        ));
        files.push(file(
            "example/main/main.c",
            format!(
                "/* {says}. */
#include <esp_err.h>
#include <esp_timer.h>
#include <{name}.h>

static {name}_state observer;

{connections}{elapsed}static void sample(void *unused)
{{
{sample}
    (void)unused;
}}

void app_main(void)
{{
    const esp_timer_create_args_t every = {{ .callback = sample, .name = \"{name}\" }};
    esp_timer_handle_t timer;

    {name}_reset(&observer);
    ESP_ERROR_CHECK(esp_timer_create(&every, &timer));
    ESP_ERROR_CHECK(esp_timer_start_periodic(timer, {microseconds}));
}}
",
                connections = self.connections(),
                elapsed = self.elapsed(|varying| Clock {
                    count: "int64_t",
                    now: "esp_timer_get_time()",
                    tick: self.literal(1e-6 / varying.seconds),
                }),
                sample = self.sample("    "),
            ),
        ));
        explain(
            &mut files,
            &format!(
                "## ESP-IDF

The folder is a component, which has to keep the name `{name}`: put it into `components` of a project, or name its parent in
`EXTRA_COMPONENT_DIRS`. `example` is a project to be filled in, which steps the observer every {microseconds} us:

```console
$ cd example && idf.py set-target esp32s3 build
```
"
            ),
        );
        files
    }

    fn ros2(&self, mut files: Vec<File>) -> Vec<File> {
        let Self { name, upper, says, number, call, columns: [states, inputs, outputs], .. } = self;
        if let Some(cmake) = files.iter_mut().find(|file| file.name == "CMakeLists.txt") {
            cmake.text = format!(
                "cmake_minimum_required(VERSION 3.10)
project({name} C CXX)

find_package(ament_cmake REQUIRED)
find_package(rclcpp REQUIRED)
find_package(std_msgs REQUIRED)

add_executable({name}_node src/{name}_node.cpp {name}.c)
target_include_directories({name}_node PRIVATE ${{CMAKE_CURRENT_SOURCE_DIR}})
# Operations are rounded one by one, as in the design.
target_compile_options({name}_node PRIVATE -ffp-contract=off)
target_compile_features({name}_node PRIVATE c_std_99 cxx_std_17)
ament_target_dependencies({name}_node rclcpp std_msgs)
install(TARGETS {name}_node DESTINATION lib/${{PROJECT_NAME}})
ament_package()
"
            );
        }
        files.push(file(
            "package.xml",
            format!(
                "<?xml version=\"1.0\"?>
<package format=\"3\">
  <name>{name}</name>
  <version>1.0.0</version>
  <description>{says}</description>
  <maintainer email=\"nobody@example.org\">nobody</maintainer>
  <license>Proprietary</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <depend>rclcpp</depend>
  <depend>std_msgs</depend>
  <export><build_type>ament_cmake</build_type></export>
</package>
"
            ),
        ));
        let topic = if call.is_fed { "r" } else { "u" };
        let has_inputs = !inputs.is_empty();
        let known = if has_inputs { format!("{topic}_.data()") } else { "nullptr".to_owned() };
        let timed = self.varying.as_ref().map(|varying| varying.of_node(name, number, &known));
        let applied = if call.is_fed { "u.data(), " } else { "" };
        let step = format!("{name}_step(&state_, {known}, y.data(), {applied}xhat.data());");
        let Timed { functions, members: times, include, sample, change } =
            timed.unwrap_or_else(|| Timed::constant(&step));
        let given = if has_inputs {
            format!(
                "        {topic}_subscription_ = create_subscription<Column>(\"{topic}\", 1, [this](const Column &message) {{
            if (message.data.size() == {topic}_.size()) {{
{change}                std::copy(message.data.begin(), message.data.end(), {topic}_.begin());
            }}
        }});
"
            )
        } else {
            String::new()
        };
        let members = if has_inputs {
            format!(
                "    std::array<{number}, {upper}_INPUTS> {topic}_{{}};\n    rclcpp::Subscription<Column>::SharedPtr {topic}_subscription_;\n"
            )
        } else {
            String::new()
        };
        let (declared, sent) = if call.is_fed {
            (
                format!("        std::array<{number}, {upper}_INPUTS> u;\n"),
                "        Column input;\n        input.data.assign(u.begin(), u.end());\n        u_publisher_->publish(input);\n",
            )
        } else {
            (String::new(), "")
        };
        let (publisher, made) = if call.is_fed {
            (
                "    rclcpp::Publisher<Column>::SharedPtr u_publisher_;\n",
                "        u_publisher_ = create_publisher<Column>(\"u\", 1);\n",
            )
        } else {
            ("", "")
        };
        let list = |column: &[String]| column.join(", ");
        files.push(file(
            format!("src/{name}_node.cpp"),
            format!(
                "// {says}.
//
// A message on y ({outputs}) is a sample: one step, whose estimate goes to xhat ({states}).{about}
#include <algorithm>
#include <array>
{include}#include <memory>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>

#include \"{name}.h\"

using Column = std_msgs::msg::Float64MultiArray;

class Observer : public rclcpp::Node {{
public:
    Observer() : Node(\"{name}\")
    {{
        {name}_reset(&state_);
        publisher_ = create_publisher<Column>(\"xhat\", 1);
{made}{given}        subscription_ = create_subscription<Column>(\"y\", 10, [this](const Column &message) {{ step(message); }});
    }}

private:
{functions}    void step(const Column &message)
    {{
        std::array<{number}, {upper}_OUTPUTS> y;
        std::array<{number}, {upper}_STATES> xhat;
{declared}        if (message.data.size() != y.size()) {{
            RCLCPP_WARN(get_logger(), \"y has %zu entries\", message.data.size());
            return;
        }}
        std::copy(message.data.begin(), message.data.end(), y.begin());
{sample}        Column estimate;
        estimate.data.assign(xhat.begin(), xhat.end());
        publisher_->publish(estimate);
{sent}    }}

    {name}_state state_;
{times}{members}{publisher}    rclcpp::Publisher<Column>::SharedPtr publisher_;
    rclcpp::Subscription<Column>::SharedPtr subscription_;
}};

int main(int argc, char **argv)
{{
    rclcpp::init(argc, argv);
    rclcpp::spin(std::make_shared<Observer>());
    rclcpp::shutdown();
    return 0;
}}
",
                outputs = list(outputs),
                states = list(states),
                about = match (has_inputs, self.varying.is_some()) {
                    (true, false) => {
                        format!(" The last {topic} ({}) is held; it is 0 before the first one.", list(inputs))
                    }
                    (true, true) => format!(
                        "
// A message on u ({}) is an input that was applied when it arrives, and held until the next one; it is 0 before the
// first one.",
                        list(inputs)
                    ),
                    (false, _) => String::new(),
                },
            ),
        ));
        let about = if self.varying.is_some() {
            "The node takes one step for each message on `y` (`std_msgs/Float64MultiArray`), with the time since the last one by the
clock of the node, and publishes the estimate on `xhat`. It predicts to each change of the input."
        } else {
            "The node takes one step for each message on `y` (`std_msgs/Float64MultiArray`), which has to arrive once a period, and
publishes the estimate on `xhat`."
        };
        explain(
            &mut files,
            &format!(
                "## ROS 2

The folder is a package: put it into `src` of a workspace, name maintainer and license in `package.xml`, and

```console
$ colcon build --packages-select {name}
$ ros2 run {name} {name}_node
```

{about}
"
            ),
        );
        files
    }
}
