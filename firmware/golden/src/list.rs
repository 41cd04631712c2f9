//! The observers by name.

/// Calls the macro `$visit` with a list of observers: name, number, type, constructor, amplitude of inputs and outputs
/// (1000 now and then where it is above 1), and whether it is exported.
#[macro_export]
macro_rules! observers {
    ($visit:ident) => {
        $visit! {
            linear_2_f32, f32, $crate::linear::Linear<f32, 2, 1, 1>, $crate::linear::linear(), 2.0, exported;
            linear_2_f64, f64, $crate::linear::Linear<f64, 2, 1, 1>, $crate::linear::linear(), 2.0, exported;
            linear_4_f32, f32, $crate::linear::Linear<f32, 4, 1, 2>, $crate::linear::linear(), 2.0, exported;
            linear_4_f64, f64, $crate::linear::Linear<f64, 4, 1, 2>, $crate::linear::linear(), 2.0, exported;
            linear_8_f32, f32, $crate::linear::Linear<f32, 8, 2, 3>, $crate::linear::linear(), 2.0, exported;
            linear_8_f64, f64, $crate::linear::Linear<f64, 8, 2, 3>, $crate::linear::linear(), 2.0, exported;
            cubic_1_f32, f32, $crate::linear::Cubic<f32, 1, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_1_f64, f64, $crate::linear::Cubic<f64, 1, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_2_f32, f32, $crate::linear::Cubic<f32, 2, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_2_f64, f64, $crate::linear::Cubic<f64, 2, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_3_f32, f32, $crate::linear::Cubic<f32, 3, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_3_f64, f64, $crate::linear::Cubic<f64, 3, 1, 1>, $crate::linear::cubic(), 2.0, exported;
            cubic_4_f32, f32, $crate::linear::Cubic<f32, 4, 1, 2>, $crate::linear::cubic(), 2.0, exported;
            cubic_4_f64, f64, $crate::linear::Cubic<f64, 4, 1, 2>, $crate::linear::cubic(), 2.0, exported;
            kalman_2_f32, f32, $crate::linear::Kalman<f32, 2, 1, 1>, $crate::linear::kalman(), 2.0, rust;
            kalman_2_f64, f64, $crate::linear::Kalman<f64, 2, 1, 1>, $crate::linear::kalman(), 2.0, rust;
            kalman_4_f32, f32, $crate::linear::Kalman<f32, 4, 1, 2>, $crate::linear::kalman(), 2.0, rust;
            kalman_4_f64, f64, $crate::linear::Kalman<f64, 4, 1, 2>, $crate::linear::kalman(), 2.0, rust;
            extended_kalman_2_f32, f32,
                $crate::nonlinear::ExtendedKalman<f32>, $crate::nonlinear::extended_kalman(), 0.5, rust;
            extended_kalman_2_f64, f64,
                $crate::nonlinear::ExtendedKalman<f64>, $crate::nonlinear::extended_kalman(), 0.5, rust;
            iterated_kalman_2_f32, f32,
                $crate::nonlinear::ExtendedKalman<f32>, $crate::nonlinear::iterated_kalman(), 0.5, rust;
            iterated_kalman_2_f64, f64,
                $crate::nonlinear::ExtendedKalman<f64>, $crate::nonlinear::iterated_kalman(), 0.5, rust;
            nonlinear_luenberger_2_f32, f32,
                $crate::nonlinear::Luenberger<f32>, $crate::nonlinear::luenberger(), 0.5, rust;
            nonlinear_luenberger_2_f64, f64,
                $crate::nonlinear::Luenberger<f64>, $crate::nonlinear::luenberger(), 0.5, rust;
            high_gain_2_f32, f32, $crate::nonlinear::HighGain<f32>, $crate::nonlinear::high_gain(), 0.5, rust;
            high_gain_2_f64, f64, $crate::nonlinear::HighGain<f64>, $crate::nonlinear::high_gain(), 0.5, rust;
        }
    };
}
