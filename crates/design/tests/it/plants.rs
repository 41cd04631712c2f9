//! Plants of the tests, written for every scalar.

/// `plant!(Name { parameters }, (states, inputs, outputs), |plant, t, x, u| f, h)` with f and h as arrays or vectors,
/// and `plant!(Name { parameters }, states, outputs, |plant, x| f, h)` for one without time and inputs. The parameters
/// are numbers; without braces the plant has none.
macro_rules! plant {
    (@ $name:ident, $n:literal, $p:literal, |$s:ident, $x:ident| $f:expr, $h:expr) => {
        luenberger_plants::plant!($name, ($n, 0, $p), |$s, t, $x, u| $f, $h);
    };
    (@ $name:ident, $($equations:tt)*) => {
        luenberger_plants::plant!($name, $($equations)*);
    };
    ($(#[$about:meta])* $name:ident { $($field:ident),* }, $($equations:tt)*) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, Default)]
        struct $name { $($field: f64),* }
        plant!(@ $name, $($equations)*);
    };
    ($(#[$about:meta])* $name:ident, $($equations:tt)*) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy)]
        struct $name;
        plant!(@ $name, $($equations)*);
    };
}
