//! The examples do what they say: each is run, and its assertions hold.

/// Each example as a module, and a test that runs it.
macro_rules! examples {
    ($($file:literal $name:ident)*) => {
        $(
            #[path = $file]
            mod $name;
        )*

        mod runs {
            $(
                #[test]
                fn $name() {
                    super::$name::main().unwrap();
                }
            )*
        }

        const RUN: &[&str] = &[$(stringify!($name)),*];
    };
}

examples! {
    "../examples/certificate.rs" certificate
    "../examples/compare.rs" compare
    "../examples/cubic.rs" cubic
    "../examples/extended_kalman.rs" extended_kalman
    "../examples/high_gain.rs" high_gain
    "../examples/immersion_invariance.rs" immersion_invariance
    "../examples/interval.rs" interval
    "../examples/kkl.rs" kkl
    "../examples/kkl_peb.rs" kkl_peb
    "../examples/linear.rs" linear
    "../examples/lipschitz.rs" lipschitz
    "../examples/lpv.rs" lpv
    "../examples/mean_value.rs" mean_value
    "../examples/measured_data.rs" measured_data
    "../examples/moving_horizon.rs" moving_horizon
    "../examples/numerical_kkl.rs" numerical_kkl
    "../examples/on_the_target.rs" on_the_target
    "../examples/pebo.rs" pebo
    "../examples/sliding_mode.rs" sliding_mode
    "../examples/unscented_kalman.rs" unscented_kalman
}

/// The tables of `docs/numerical-kkl.md` take minutes without optimisation; `numerical_kkl` runs the same calls on a
/// small one.
const TOO_LONG: &[&str] = &["numerical_kkl_table"];

/// No example is forgotten, here or in the README.
#[test]
fn every_example_is_run_and_listed() {
    let home = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(home.join("../../README.md")).unwrap();
    let mut found: Vec<String> = std::fs::read_dir(home.join("examples"))
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    found.sort();
    let mut expected: Vec<&str> = RUN.iter().chain(TOO_LONG).copied().collect();
    expected.sort_unstable();
    assert_eq!(found, expected);
    for name in RUN {
        assert!(readme.contains(&format!("`{name}`")), "{name} in README.md");
    }
}
