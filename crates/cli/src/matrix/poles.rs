//! `luenberger poles`: poles from a settling time and a damping, or of a prototype filter.

use super::json_output;
use crate::answer::Answer;
use crate::arguments::{Pattern, PolesInput};
use crate::failure::Failure;
use crate::numbers;
use luenberger_linalg::{PolePattern, damping_from_overshoot, poles_from};
use nalgebra::Complex;
use serde::Serialize;

#[derive(Serialize)]
struct Answered {
    poles: Vec<[f64; 2]>,
    settling_time: f64,
    band: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    damping: Option<f64>,
    /// The poles in discrete time.
    #[serde(skip_serializing_if = "Option::is_none")]
    discrete: Option<Vec<[f64; 2]>>,
}

/// Poles of a continuous-time response, and with a period those of the sampled one.
pub(crate) fn poles(input: &PolesInput) -> Result<Answer, Failure> {
    let failed = |error| Failure::Matrix { origin: "poles".to_owned(), error };
    let (pattern, damping) = match input.pattern {
        Pattern::Dominant => {
            let damping = match (input.damping, input.overshoot) {
                (Some(damping), _) => damping,
                (None, Some(overshoot)) => damping_from_overshoot(overshoot).map_err(failed)?,
                (None, None) => 1.0,
            };
            (PolePattern::Dominant { damping, ratio: input.ratio }, Some(damping))
        }
        _ if input.damping.is_some() || input.overshoot.is_some() => {
            return Err(Failure::Usage("--damping and --overshoot belong to --pattern dominant"));
        }
        Pattern::Bessel => (PolePattern::Bessel, None),
        Pattern::Butterworth => (PolePattern::Butterworth, None),
        Pattern::Itae => (PolePattern::Itae, None),
    };
    let found = poles_from(pattern, input.order, input.settling, input.band).map_err(failed)?;
    let band = numbers::number(100.0 * input.band);
    let mut text = format!("settling time {} (to {band} %)\n", numbers::number(input.settling));
    if let Some(damping) = damping {
        text.extend(["damping ratio ", &numbers::number(damping), "\n"]);
    }
    text += &numbers::list("poles", &found);
    let mut discrete = None;
    if let Some(period) = input.period {
        let images: Vec<Complex<f64>> = found.iter().map(|pole| (pole * period).exp()).collect();
        text += &numbers::list("poles in discrete time", &images);
        discrete = Some(json_output::pairs(&images));
    }
    let (poles, settling_time) = (json_output::pairs(&found), input.settling);
    Ok(Answer::new(text, &Answered { poles, settling_time, band: input.band, damping, discrete })?)
}
