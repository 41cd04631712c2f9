//! `luenberger noise`: noise in continuous and in discrete time.

use super::json_output;
use crate::answer::Answer;
use crate::arguments::NoiseInput;
use crate::failure::Failure;
use crate::input::given::NoiseModel;
use crate::input::json;
use crate::numbers;
use luenberger_linalg::{
    continuous_process_noise, discrete_process_noise, measurement_intensity, positive_semidefinite,
    sampled_measurement_covariance,
};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

#[derive(Default, Serialize)]
struct Noise {
    period: f64,
    /// Covariance of a sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    r: Option<Vec<Vec<f64>>>,
    /// Intensity of the measurement noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    v: Option<Vec<Vec<f64>>>,
    /// Standard deviations of the samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma: Option<Vec<f64>>,
    /// Intensity of the process noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    w: Option<Vec<Vec<f64>>>,
    /// Covariance of the process noise of one period.
    #[serde(skip_serializing_if = "Option::is_none")]
    qd: Option<Vec<Vec<f64>>>,
}

/// Measurement noise and process noise, whichever are given, in the other domain.
pub(crate) fn noise(input: &NoiseInput) -> Result<Answer, Failure> {
    let h = input.period;
    // Without a file all data are options.
    let origin = input.data.given.as_ref().map_or_else(|| "noise".to_owned(), ToString::to_string);
    let failed = |error| Failure::Matrix { origin: origin.clone(), error };
    let [a, w, qd, mut r, v] = match &input.data.given {
        Some(file) => json::some_matrices(file, NoiseModel::KEYS, 0)?,
        None => [const { None }; 5],
    };
    if let Some(sigma) = &input.sigma {
        if !sigma.iter().all(|sigma| *sigma >= 0.0 && sigma.is_finite()) {
            return Err(Failure::Usage("--sigma: a standard deviation is a finite number, not negative"));
        }
        r = Some(DMatrix::from_diagonal(&DVector::from_iterator(sigma.len(), sigma.iter().map(|s| s * s))));
    }
    for (what, m) in
        [("the covariance R", &r), ("the intensity V", &v), ("the intensity W", &w), ("the covariance Qd", &qd)]
    {
        if let Some(m) = m {
            positive_semidefinite(what, m).map_err(failed)?;
        }
    }
    let mut text = format!("period {}\n", numbers::number(h));
    let mut answer = Noise { period: h, ..Noise::default() };
    let measured = match (r, v) {
        (Some(_), Some(_)) => return Err(Failure::Usage("give r (or --sigma) or v, not both")),
        (Some(r), None) => Some((measurement_intensity(&r, h).map_err(failed)?, r)),
        (None, Some(v)) => {
            let r = sampled_measurement_covariance(&v, h).map_err(failed)?;
            Some((v, r))
        }
        (None, None) => None,
    };
    if let Some((v, r)) = measured {
        let sigma: Vec<f64> = r.diagonal().iter().map(|x| x.sqrt()).collect();
        text += &numbers::matrix("V = R h, intensity of the measurement noise", &v);
        text += &numbers::matrix("R, covariance of a sample", &r);
        let listed: Vec<String> = sigma.iter().map(|s| numbers::number(*s)).collect();
        text.extend(["standard deviations of the samples: ", &listed.join(", "), "\n"]);
        answer = Noise { r: Some(json_output::rows(&r)), v: Some(json_output::rows(&v)), sigma: Some(sigma), ..answer };
    }
    let process = match (a, w, qd) {
        (_, Some(_), Some(_)) => return Err(Failure::Usage("give w or qd, not both")),
        (Some(a), Some(w), None) => Some((discrete_process_noise(&a, &w, h).map_err(failed)?, w)),
        (Some(a), None, Some(qd)) => {
            let w = continuous_process_noise(&a, &qd, h).map_err(failed)?;
            Some((qd, w))
        }
        (None, Some(_), None) | (None, None, Some(_)) => {
            return Err(Failure::Usage("process noise needs a, the matrix of x' = A x + w"));
        }
        (Some(_), None, None) => return Err(Failure::Usage("a without w or qd")),
        (None, None, None) => None,
    };
    if let Some((qd, w)) = process {
        text += &numbers::matrix("Qd, covariance of the process noise in one period", &qd);
        text += &numbers::matrix("W, intensity of the process noise", &w);
        answer = Noise { w: Some(json_output::rows(&w)), qd: Some(json_output::rows(&qd)), ..answer };
    }
    if answer.v.is_none() && answer.w.is_none() {
        return Err(Failure::Usage("give --sigma, or a file with r, v, a and w, or a and qd"));
    }
    Ok(Answer::new(text, &answer)?)
}
