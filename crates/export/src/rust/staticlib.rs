//! The observer as a static library with the interface of the emitted C: the crate in `c/`.

use std::fmt::Write;

use luenberger_observers::ObserverDimensions;

use crate::exportable_observer::ExportableObserver;
use crate::golden::Step;
use crate::{Export, File, c, number};

/// Manifest, source, header and test: the header and the test are those of the emitted C.
pub(super) fn files(export: &Export, steps: &[Step]) -> Vec<File> {
    let name = &export.identifier;
    let file = |name: &str, text: String| File { name: format!("c/{name}"), text };
    vec![
        file("Cargo.toml", manifest(name)),
        file("src/lib.rs", library(export)),
        file(&format!("{name}.h"), c::header(export)),
        file(&format!("test_{name}.c"), c::test(export, steps)),
    ]
}

/// The name of the package.
pub(super) fn package(name: &str) -> String {
    name.replace('_', "-")
}

fn manifest(name: &str) -> String {
    format!(
        "[package]
name = \"{package}-c\"
version = \"0.1.0\"
edition = \"2024\"
publish = false

[lib]
name = \"{name}\"
crate-type = [\"staticlib\"]
test = false

[dependencies]
design = {{ path = \"..\", package = \"{package}\" }}

[profile.dev]
panic = \"abort\"

[profile.release]
panic = \"abort\"
lto = \"fat\"
codegen-units = 1

[workspace]
",
        package = package(name)
    )
}

/// The functions of the header.
fn library(export: &Export) -> String {
    let (name, number) = (&export.identifier, export.scalar.name());
    let size = export.observer.dimensions();
    let (n, zero) = (size.estimate, number::rust(0.0, export.scalar));
    let (is_filter, is_timed, is_fed) = (
        matches!(export.observer, ExportableObserver::Kalman(_)),
        export.observer.uses_time(),
        export.feedback.is_some(),
    );
    let (mut fields, mut start, mut tick, mut imports) = (String::new(), String::new(), "", ["", "SVector"]);
    let inner = if is_fed { "block.observer()" } else { "block" };
    let mut estimate = String::new();
    let stored: String;
    let mut sample = String::new();
    let input_at_start = super::input_at_start(export, "design");
    let joined = |order: usize| {
        (
            format!("SVector::from_fn(|i, _| if i < {order} {{ self.z[i] }} else {{ self.xhat[i - {order}] }})"),
            format!(
                "        self.z = core::array::from_fn(|i| z[i]);\n        self.xhat = core::array::from_fn(|i| z[{order} + i]);\n"
            ),
        )
    };
    let (state, load, store) = if let ExportableObserver::Kkl(observer) = &export.observer
        && observer.held_inputs() > 0
    {
        let targets = observer.dimensions().state;
        _ = writeln!(fields, "    z: [{number}; {targets}],");
        _ = writeln!(start, "            z: [{zero}; {targets}],");
        let (load, store) = joined(targets);
        stored = store;
        (format!("SVector<{number}, {}>", targets + n), load, stored.as_str())
    } else if let ExportableObserver::Kkl(observer) = &export.observer {
        let targets = observer.dimensions().state;
        _ = writeln!(fields, "    z: [{number}; {targets}],");
        _ = writeln!(start, "            z: [{zero}; {targets}],");
        _ = writeln!(estimate, "        (*state).xhat = {inner}.estimate(&z).into();");
        let load = "SVector::from(self.z)".to_owned();
        (format!("SVector<{number}, {targets}>"), load, "        self.z = (*z).into();\n")
    } else if let ExportableObserver::Extension(observer) = &export.observer {
        let all = luenberger_observers::SampledObserver::<f64>::dimensions(observer).state;
        let order = all - n;
        _ = writeln!(fields, "    z: [{number}; {order}],");
        _ = writeln!(start, "            z: [{zero}; {order}],");
        let (load, store) = joined(order);
        stored = store;
        (format!("SVector<{number}, {all}>"), load, stored.as_str())
    } else if is_filter {
        imports = ["GaussianEstimate, ", "{Const, SMatrix, SVector}"];
        _ = writeln!(fields, "    p: [[{number}; {n}]; {n}],");
        _ = writeln!(start, "            p: [[{zero}; {n}]; {n}],");
        (
            format!("GaussianEstimate<{number}, Const<{n}>>"),
            format!(
                "GaussianEstimate::new(&SVector::from(self.xhat), &SMatrix::<{number}, {n}, {n}>::from(self.p).transpose())"
            ),
            "        self.xhat = z.estimate().into();\n        self.p = z.covariance().transpose().into();\n",
        )
    } else if matches!(export.observer, ExportableObserver::Unscented(_)) {
        imports = ["SquareRootEstimate, ", "{Const, SMatrix, SVector}"];
        _ = writeln!(fields, "    s: [[{number}; {n}]; {n}],");
        _ = writeln!(start, "            s: [[{zero}; {n}]; {n}],");
        (
            format!("SquareRootEstimate<{number}, Const<{n}>>"),
            format!(
                "SquareRootEstimate::new(&SVector::from(self.xhat), &SMatrix::<{number}, {n}, {n}>::from(self.s).transpose())"
            ),
            "        self.xhat = z.estimate().into();\n        self.s = z.factor().transpose().into();\n",
        )
    } else if let ExportableObserver::MovingHorizon(_) = &export.observer {
        let window = Window::new(export);
        _ = writeln!(fields, "{}", window.fields);
        _ = writeln!(start, "{}", window.start);
        sample = window.sample;
        stored = window.store;
        (format!("SVector<{number}, {}>", size.state), window.load, stored.as_str())
    } else if export.is_filter() {
        let outputs = size.outputs;
        _ = writeln!(fields, "    prediction: [{number}; {n}],\n    innovation: [{number}; {outputs}],");
        _ = writeln!(start, "            prediction: [{zero}; {n}],\n            innovation: [{zero}; {outputs}],");
        let load = "SVector::from(self.prediction)".to_owned();
        (format!("SVector<{number}, {n}>"), load, "        self.prediction = (*z).into();\n")
    } else {
        (format!("SVector<{number}, {n}>"), "SVector::from(self.xhat)".to_owned(), "        self.xhat = (*z).into();\n")
    };
    if is_timed {
        fields += "    sample: u64,\n";
        start += "            sample: 0,\n";
        tick = "        (*state).sample = (*state).sample.wrapping_add(1);\n";
    }
    let time = if is_timed { format!("(*state).sample as {number} * {inner}.period()") } else { zero.clone() };
    let (known, more, step, input) = if is_fed {
        let input = format!(
            "
/// The input to apply from this sample to the next.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_input(state: *const State, r: *const {number}, u: *mut {number}) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{ give(block.input(&(*state).load(), &SVector::from(column(r))).as_slice(), u) }}
}}
"
        );
        let step = format!(
            "        let applied = block.step({time}, &mut z, &SVector::from(column(r)), &SVector::from(column(y)));
        give(applied.as_slice(), u);
"
        );
        ("r", format!("u: *mut {number}, "), step, input)
    } else {
        let step =
            format!("        block.step({time}, &mut z, &SVector::from(column(u)), &SVector::from(column(y)));\n");
        let halves = if export.has_halves() { halves(export, &time, tick) } else { String::new() };
        if export.observer.takes_time() { varying(export) } else { ("u", String::new(), step, halves) }
    };
    let body = if export.has_halves() && export.observer.takes_time() {
        format!("        {name}_predict(state, u, dt);\n        {name}_update(state, u, y, dt);\n")
    } else if export.has_halves() {
        format!("        {name}_update(state, u, y);\n        {name}_predict(state, u);\n")
    } else {
        format!("        let mut z = (*state).load();\n{step}        (*state).store(&z);\n{estimate}{tick}")
    };
    let made = if export.has_halves() { "" } else { "    let Ok(block) = design::observer() else { return };\n" };
    format!(
        "//! The functions of `{name}.h` for programs in C: the observer of the crate above, as a static library.
#![no_std]

use design::luenberger_observers::nalgebra::{};
use design::luenberger_observers::{{{}SampledObserver}};

{sample}/// State of the observer, as in the header.
#[repr(C)]
pub struct State {{
    xhat: [{number}; {n}],
{fields}}}

impl State {{
    fn load(&self) -> {state} {{
        {load}
    }}

    fn store(&mut self, z: &{state}) {{
{store}    }}
}}

/// Nothing here panics; a static library without the standard library has to say what would happen.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {{
    loop {{}}
}}

/// # Safety
/// `from` points to N numbers.
unsafe fn column<const N: usize>(from: *const {number}) -> [{number}; N] {{
    // SAFETY: as the caller promises.
    core::array::from_fn(|i| unsafe {{ *from.add(i) }})
}}

/// # Safety
/// `to` is null or points to as many numbers.
unsafe fn give(values: &[{number}], to: *mut {number}) {{
    if !to.is_null() {{
        for (i, x) in values.iter().enumerate() {{
            // SAFETY: as the caller promises.
            unsafe {{ *to.add(i) = *x }}
        }}
    }}
}}

/// Starts from a given estimate.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_init(state: *mut State, xhat: *const {number}) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{
        let xhat = column(xhat);
        let z = {inner}.initial({zero}, &SVector::from(xhat), &{input_at_start}, &SVector::zeros());
        state.write(State {{
            xhat,
{start}        }});
        (*state).store(&z);
{estimate}    }}
}}

/// Starts from the first estimate of the design.
///
/// # Safety
/// The pointer is that of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_reset(state: *mut State) {{
    // SAFETY: as the caller promises.
    unsafe {{ {name}_init(state, design::initial().as_ptr()) }}
}}
{input}
/// One step.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_step(
    state: *mut State,
    {known}: *const {number},
    y: *const {number},
    {more}xhat: *mut {number},
) {{
{made}    // SAFETY: as the caller promises.
    unsafe {{
{body}        give(&(*state).xhat, xhat);
    }}
}}
",
        imports[1], imports[0]
    )
}

/// The state of a moving-horizon estimator in C and as the column of numbers that the Rust one has.
struct Window {
    sample: String,
    fields: String,
    start: String,
    load: String,
    store: String,
}

impl Window {
    fn new(export: &Export) -> Self {
        let number = export.scalar.name();
        let ObserverDimensions { estimate: n, inputs: m, outputs: p, .. } = export.observer.dimensions();
        let (window, zero) = (export.observer.window(), number::rust(0.0, export.scalar));
        let (one, half) = (number::rust(1.0, export.scalar), number::rust(0.5, export.scalar));
        let period = number::rust(export.scalar.round(export.observer.period()), export.scalar);
        let timed = export.observer.uses_time();
        let only = |has: bool, text: String| if has { text } else { String::new() };
        let sample = format!(
            "/// A sample of the window, as in the header.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Sample {{
    x: [{number}; {n}],
{}    y: [{number}; {p}],
{}    measured: [i32; {p}],
}}

",
            only(m > 0, format!("    u: [{number}; {m}],\n")),
            only(timed, format!("    t: {number},\n")),
        );
        let zeros = format!(
            "Sample {{ x: [{zero}; {n}], {}y: [{zero}; {p}], {}measured: [0; {p}] }}",
            only(m > 0, format!("u: [{zero}; {m}], ")),
            only(timed, format!("t: {zero}, ")),
        );
        let fields = format!(
            "    p: [[{number}; {n}]; {n}],
    prior: [{number}; {n}],
    prior_p: [[{number}; {n}]; {n}],
    samples: [Sample; {window}],
    count: i32,"
        );
        let start = format!(
            "            p: [[{zero}; {n}]; {n}],
            prior: [{zero}; {n}],
            prior_p: [[{zero}; {n}]; {n}],
            samples: [{zeros}; {window}],
            count: 1,"
        );
        // The covariances are symmetric, so that rows are columns.
        let load = format!(
            "let head = self.xhat.iter().chain(self.p.iter().flatten()).copied().chain([self.count as {number}]);
        let prior = self.prior.iter().chain(self.prior_p.iter().flatten()).copied();
        let samples = self.samples.iter().flat_map(|at| {{
            let flags = at.measured.map(|flag| if flag == 0 {{ {zero} }} else {{ {one} }});
            at.x.into_iter(){}.chain(at.y).chain(flags).chain([{}, {period}])
        }});
        let mut all = head.chain(prior).chain(samples);
        SVector::from_fn(|_, _| all.next().unwrap_or({zero}))",
            only(m > 0, ".chain(at.u)".to_owned()),
            if timed { "at.t" } else { &zero },
        );
        let store = format!(
            "        let mut all = z.iter().copied();
        let mut next = || all.next().unwrap_or({zero});
        self.xhat = core::array::from_fn(|_| next());
        self.p = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        self.count = next() as i32;
        self.prior = core::array::from_fn(|_| next());
        self.prior_p = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        for at in &mut self.samples {{
            at.x = core::array::from_fn(|_| next());
{}            at.y = core::array::from_fn(|_| next());
            at.measured = core::array::from_fn(|_| i32::from(next() > {half}));
            {}next();
            next();
        }}
",
            only(m > 0, "            at.u = core::array::from_fn(|_| next());\n".to_owned()),
            only(timed, "at.t = ".to_owned()),
        );
        Self { sample, fields, start, load, store }
    }
}

/// The inputs, further parameters and body of the step of an observer at varying periods, and its prediction.
fn varying(export: &Export) -> (&'static str, String, String, String) {
    let (name, number) = (&export.identifier, export.scalar.name());
    let (inputs, estimate) = (export.observer.plant_inputs(), export.observer.dimensions().estimate);
    let known = format!("known::<{inputs}, {}>(u, dt)", inputs + 1);
    let prediction = format!(
        "
/// (u, dt), the time being the last input.
///
/// # Safety
/// `u` points to M numbers, or M is 0.
unsafe fn known<const M: usize, const ALL: usize>(u: *const {number}, dt: {number}) -> SVector<{number}, ALL> {{
    // SAFETY: as the caller promises.
    let u: [{number}; M] = unsafe {{ column(u) }};
    SVector::from_fn(|i, _| u.get(i).copied().unwrap_or(dt))
}}

/// A prediction alone.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_predict(state: *mut State, u: *const {number}, dt: {number}) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{
        let mut z: SVector<{number}, {estimate}> = (*state).load();
        block.observer().predict(&mut z, &{known}, dt);
        (*state).store(&z);
    }}
}}

/// The correction alone.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_update(
    state: *mut State,
    u: *const {number},
    y: *const {number},
    dt: {number},
) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{
        let mut z: SVector<{number}, {estimate}> = (*state).load();
        block.observer().correct(&mut z, &{known}, &SVector::from(column(y)), dt);
        (*state).store(&z);
    }}
}}
"
    );
    ("u", format!("dt: {number}, "), String::new(), prediction)
}

/// Update and prediction of a filter.
fn halves(export: &Export, time: &str, tick: &str) -> String {
    let (name, number) = (&export.identifier, export.scalar.name());
    let zero = number::rust(0.0, export.scalar);
    let outputs = export.observer.dimensions().outputs;
    let (update, predict) = if export.is_filter() {
        (
            "        let state = &mut *state;
        let (z, before) = (state.load(), SVector::from(state.innovation));
        let found = block.joined_innovation(&before, &z, &SVector::from(column(u)), &SVector::from(column(y)));
        state.innovation = found.into();
        state.xhat = block.update(&z, &found).into();
"
            .to_owned(),
            format!(
                "        let mut z = (*state).load();
        block.predict(&mut z, &SVector::from(column(u)), &SVector::from((*state).innovation));
        (*state).store(&z);
        (*state).innovation = [{zero}; {outputs}];
"
            ),
        )
    } else {
        (
            format!(
                "        let mut z = (*state).load();
        _ = block.update({time}, &mut z, &SVector::from(column(u)), &SVector::from(column(y)));
        (*state).store(&z);
"
            ),
            format!(
                "        let mut z = (*state).load();
        block.finish({time}, &mut z, &SVector::from(column(u)));
        (*state).store(&z);
{tick}"
            ),
        )
    };
    format!(
        "
/// The update alone.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_update(state: *mut State, u: *const {number}, y: *const {number}) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{
{update}    }}
}}

/// The prediction alone.
///
/// # Safety
/// The pointers are those of the header.
#[unsafe(no_mangle)]
pub unsafe extern \"C\" fn {name}_predict(state: *mut State, u: *const {number}) {{
    let Ok(block) = design::observer() else {{ return }};
    // SAFETY: as the caller promises.
    unsafe {{
{predict}    }}
}}
"
    )
}
