//! Plants of the tests, written for every scalar.

/// `plant!(Name { parameters }, (states, inputs, outputs), |plant, t, x, u| f, h)` with f and h as arrays or vectors,
/// and `plant!(Name { parameters }, states, outputs, |plant, x| f, h)` for one without time and inputs. The parameters
/// are numbers; without braces the plant has none.
macro_rules! plant {
    (@ $name:ident, $n:literal, $p:literal, |$s:ident, $x:ident| $f:expr, $h:expr) => {
        plant!(@ $name, ($n, 0, $p), |$s, _t, $x, _u| $f, $h);
    };
    (@ $name:ident, ($n:literal, $m:literal, $p:literal), |$s:ident, $t:ident, $x:ident, $u:ident| $f:expr, $h:expr) => {
        impl luenberger_plants::ByDual for $name {}

        impl luenberger_plants::Shape for $name {
            fn dimensions(&self) -> luenberger_plants::Dimensions {
                luenberger_plants::Dimensions { states: $n, inputs: $m, outputs: $p }
            }
        }

        #[allow(unused_variables, clippy::useless_conversion)]
        impl<T: nalgebra::RealField + Copy> luenberger_plants::Plant<T> for $name {
            type State = nalgebra::SVector<T, $n>;
            type Input = nalgebra::SVector<T, $m>;
            type Output = nalgebra::SVector<T, $p>;

            fn derivative(&self, $t: T, $x: &Self::State, $u: &Self::Input) -> Self::State {
                let $s = self;
                $f.into()
            }

            fn output(&self, $t: T, $x: &Self::State, $u: &Self::Input) -> Self::Output {
                let $s = self;
                $h.into()
            }
        }
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
