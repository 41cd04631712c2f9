//! What the kind of an observer determines: its name, its period, what it estimates.

use nalgebra::DMatrix;

use super::{GainSpec, KklSpec, LinearSpec, ObserverKind, RateSpec};

impl ObserverKind {
    /// Whether the design solves a matrix inequality.
    pub fn poses_inequality(&self) -> bool {
        match self {
            Self::Luenberger(linear)
            | Self::Kalman(linear)
            | Self::Cubic { linear, .. }
            | Self::ProportionalIntegral { linear, .. }
            | Self::UnknownInput { linear, .. }
            | Self::SampledCubic { linear, varying: None, .. } => {
                matches!(linear.gain, GainSpec::DecayRate(_) | GainSpec::Lmi)
            }
            Self::Interval(spec) => {
                spec.gain.as_ref().is_none_or(|linear| matches!(linear.gain, GainSpec::DecayRate(_) | GainSpec::Lmi))
            }
            Self::SampledCubic { varying: Some(_), .. }
            | Self::NormFilter(_)
            | Self::Lpv { .. }
            | Self::Lipschitz { .. }
            | Self::MeanValue { .. } => true,
            Self::OptimalCubic(_)
            | Self::HighGain { .. }
            | Self::SlidingMode(_)
            | Self::ReducedOrder(_)
            | Self::Functional { .. }
            | Self::ExtendedKalman { .. }
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::Kkl(_)
            | Self::Pebo(_)
            | Self::KklPeb(_)
            | Self::ImmersionInvariance(_)
            | Self::KklNumerical(_) => false,
        }
    }

    /// The name of the kind in study files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Luenberger(_) => "luenberger",
            Self::Kalman(_) => "kalman",
            Self::Cubic { .. } => "cubic",
            Self::OptimalCubic(_) => "optimal-cubic",
            Self::ProportionalIntegral { chain: None, .. } => "proportional-integral",
            Self::ProportionalIntegral { chain: Some(_), .. } => "extended-state",
            Self::UnknownInput { .. } => "unknown-input",
            Self::Interval(_) => "interval",
            Self::SlidingMode(_) => "sliding-mode",
            Self::ReducedOrder(_) => "reduced-order",
            Self::Functional { .. } => "functional",
            Self::NormFilter(spec) => match spec.norm {
                luenberger_design::SystemNorm::HInfinity => "h-infinity",
                luenberger_design::SystemNorm::H2 => "h2",
            },
            Self::SampledCubic { .. } => "sampled-cubic",
            Self::Lpv { .. } => "lpv",
            Self::Lipschitz { .. } => "lipschitz",
            Self::MeanValue { .. } => "mean-value",
            Self::HighGain { .. } => "high-gain",
            Self::ExtendedKalman { .. } => "extended-kalman",
            Self::Unscented(_) => "ukf",
            Self::MovingHorizon(_) => "mhe",
            Self::Kkl(_) => "kkl",
            Self::Pebo(_) => "pebo",
            Self::KklPeb(_) => "kkl-peb",
            Self::ImmersionInvariance(_) => "immersion-invariance",
            Self::KklNumerical(_) => "kkl-numerical",
        }
    }

    /// The sampling period; none in continuous time.
    pub fn period(&self) -> Option<f64> {
        match self {
            Self::SampledCubic { period, .. } | Self::ExtendedKalman { period, .. } => Some(*period),
            Self::SlidingMode(spec) => Some(spec.period),
            Self::Unscented(spec) => Some(spec.period),
            Self::MovingHorizon(spec) => Some(spec.period),
            _ => None,
        }
    }

    /// The period of an observer with equidistant samples, between which a simulation holds its estimate; none at
    /// varying periods, where the observer predicts.
    pub fn fixed_period(&self) -> Option<f64> {
        if self.varying_periods().is_some() { None } else { self.period() }
    }

    /// The periods for which convergence is proved, of an observer at varying periods.
    pub fn varying_periods(&self) -> Option<&luenberger_design::Periods> {
        match self {
            Self::SampledCubic { varying, .. } => varying.as_ref(),
            _ => None,
        }
    }

    /// The Runge-Kutta steps per period that a study asks of the exported step.
    pub fn substeps(&self) -> Option<usize> {
        match self {
            Self::ExtendedKalman { substeps, .. } => *substeps,
            Self::Unscented(spec) => spec.substeps,
            Self::MovingHorizon(spec) => spec.substeps,
            _ => None,
        }
    }

    /// Whether it is a filter in samples: an update by each sample, and a prediction.
    pub fn updates(&self) -> bool {
        match self {
            Self::ExtendedKalman { .. } | Self::Unscented(_) | Self::MovingHorizon(_) => true,
            Self::Kalman(spec) => spec.is_filter,
            _ => false,
        }
    }

    /// Whether estimates on a log are smoothed.
    pub fn smooths(&self) -> bool {
        match self {
            Self::ExtendedKalman { smooth, .. } => *smooth,
            Self::Unscented(spec) => spec.smooth,
            _ => false,
        }
    }

    /// The names of the disturbances that are estimated with the state, and of their derivatives: `d1`, `d1_rate`,
    /// `d1_rate2`.
    pub fn estimated_disturbances(&self) -> Vec<String> {
        let Self::ProportionalIntegral { e, chain, .. } = self else { return Vec::new() };
        let suffix = |derivative: usize| match derivative {
            0 => String::new(),
            1 => "_rate".to_owned(),
            k => format!("_rate{k}"),
        };
        let of = |k: usize| (1..=e.ncols()).map(move |j| format!("d{j}{}", suffix(k)));
        (0..chain.unwrap_or(1)).flat_map(of).collect()
    }

    /// K of the functions `z = K x` that are estimated in place of the state, and their names `z1`, `z2`, ..
    pub fn functions(&self) -> Option<(&DMatrix<f64>, Vec<String>)> {
        let Self::Functional { k, .. } = self else { return None };
        Some((k, (1..=k.nrows()).map(|i| format!("z{i}")).collect()))
    }

    /// The region of the design, if it is bounded somewhere.
    pub fn region(&self) -> Option<luenberger_design::Region> {
        let region = match self {
            Self::Lpv { region, .. } | Self::MeanValue { region, .. } | Self::Lipschitz { region, split: None, .. } => {
                region.clone()
            }
            Self::Kkl(kkl) => kkl.region.clone(),
            Self::Pebo(peb) | Self::KklPeb(peb) => peb.region.clone(),
            Self::ImmersionInvariance(spec) => spec.region.clone(),
            Self::KklNumerical(kkl) => luenberger_design::Region::new(&kkl.domain).inputs(&kkl.inputs),
            _ => return None,
        };
        let bounded = |bounds: &(f64, f64)| bounds.0.is_finite() || bounds.1.is_finite();
        let (inputs, time) = (region.input_bounds().unwrap_or_default(), region.time_bounds());
        let bounded = region.states().iter().chain(inputs).chain([&time]).any(bounded);
        bounded.then_some(region)
    }

    /// The same specification with poles and rates scaled by `factor`.
    #[must_use]
    pub fn faster(&self, factor: f64) -> Self {
        let linear = |linear: &LinearSpec| LinearSpec {
            gain: match &linear.gain {
                GainSpec::Poles(poles) => GainSpec::Poles(poles.iter().map(|pole| pole * factor).collect()),
                GainSpec::DecayRate(rate) => GainSpec::DecayRate(rate * factor),
                other => other.clone(),
            },
            weight: linear.weight.clone(),
            is_filter: linear.is_filter,
        };
        let mut kind = self.clone();
        match &mut kind {
            Self::Luenberger(requested)
            | Self::Kalman(requested)
            | Self::Cubic { linear: requested, .. }
            | Self::ProportionalIntegral { linear: requested, .. }
            | Self::UnknownInput { linear: requested, .. }
            | Self::SampledCubic { linear: requested, .. } => *requested = linear(requested),
            Self::Lpv { rate: RateSpec::Rate(rate) | RateSpec::Fastest(rate), .. }
            | Self::Lipschitz { rate, .. }
            | Self::MeanValue { rate, .. } => *rate *= factor,
            Self::ReducedOrder(poles) | Self::Functional { poles, .. } => {
                for pole in poles.iter_mut() {
                    *pole *= factor;
                }
            }
            Self::HighGain { r, .. } => *r /= factor,
            // Gains as for a bound that is factor^n times as large: time in units of 1/factor.
            Self::SlidingMode(spec) => {
                if let Some(gains) = &mut spec.gains {
                    for (i, gain) in gains.iter_mut().enumerate() {
                        *gain *= factor.powi(i32::try_from(i + 1).unwrap_or(i32::MAX));
                    }
                }
            }
            Self::Interval(spec) => {
                if let Some(gain) = &mut spec.gain {
                    *gain = linear(gain);
                }
            }
            Self::KklNumerical(KklSpec { cutoff: Some(cutoff), .. }) => *cutoff *= factor,
            Self::OptimalCubic(_)
            | Self::Lpv { .. }
            | Self::NormFilter(_)
            | Self::ExtendedKalman { .. }
            | Self::Unscented(_)
            | Self::MovingHorizon(_)
            | Self::KklNumerical(_)
            | Self::Kkl(_)
            | Self::Pebo(_)
            | Self::KklPeb(_)
            | Self::ImmersionInvariance(_) => {}
        }
        kind
    }

    /// The same with cubic term of strength `gamma`; none for kinds without one.
    #[must_use]
    pub fn with_gamma(&self, gamma: f64) -> Option<Self> {
        use luenberger_design::CubicGain;
        let mut kind = self.clone();
        match &mut kind {
            Self::Cubic { correction: CubicGain::Gamma(value) | CubicGain::Radial(value), .. }
            | Self::SampledCubic { correction: CubicGain::Gamma(value) | CubicGain::Radial(value), .. } => {
                *value = gamma;
            }
            Self::ProportionalIntegral { cubic: Some((_, value)), .. }
            | Self::UnknownInput { cubic: Some((_, value)), .. } => *value = gamma,
            _ => return None,
        }
        Some(kind)
    }
}
