//! The bootstrap particle filter.

use luenberger_export::extension::RecordedObserver;
use luenberger_expression::Recording;
use luenberger_observers::{NoiseModel, ParticleFilter, Prediction};
use luenberger_proof::wording::counted;
use luenberger_sim::{Replay, SeededParticles};
use nalgebra::DMatrix;

use super::declaration::{Declaration, Tuning};
use super::filter::{STAGES, extended};
use super::keys::{PERIOD, V, W};
use super::{Kind, as_kind};
use crate::designed::{self, Running, StepOf};
use crate::model::{Model, PlantModel};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::study::{Estimated, NUMBER, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, matrix, number, without_certificate};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "particle",
    about: "Bootstrap particle filter with systematic resampling, for errors that are not Gaussian, for a plant in continuous time with sampled measurements, or in discrete time. Its random numbers are seeded.",
    source: "Gordon, Salmond and Smith 1993; Kitagawa 1996",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[ParticleSpec::KEYS],
    kind: as_kind::<ParticleSpec>,
    read: |given, reader| Some(ParticleSpec::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::OfStudy(
        "how many particles are enough depends on the plant: one run says nothing of the next, and the study specifies no such observer",
    ),
};

crate::keys! { |size|
    /// A particle filter.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ParticleSpec {
        /// W, n x n.
        w: DMatrix<f64>[n, n] as &W,
        /// V, p x p.
        v: DMatrix<f64>[p, p] as &V,
        /// Covariance of the initial error, n x n (default: the identity).
        p0: DMatrix<f64>[n, n] as Weight = DMatrix::identity(size.states, size.states),
        /// The sampling period.
        period: f64 as &PERIOD,
        /// Number of particles (default 500). The error that it leaves falls with its root.
        particles: usize as Count(2) = 500,
        /// Seed of the random numbers of the particles, none of which anything else draws (default 0).
        seed: usize as Count(0) = 0,
    }
}

impl ParticleSpec {
    /// The filter of 500 particles for noise of intensity W and covariance V, with P(0) = I.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        Self { p0: DMatrix::identity(w.nrows(), w.nrows()), w, v, period, particles: 500, seed: 0 }
    }
}

impl Specification for ParticleSpec {
    declared!();

    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    fn noises(&self) -> Option<[&DMatrix<f64>; 2]> {
        Some([&self.w, &self.v])
    }

    fn with_parameters(&self, parameters: &[Estimated]) -> Option<ObserverKind> {
        let [w, p0] = extended([&self.w, &self.p0], parameters);
        Some(Self { w, p0, ..self.clone() }.into())
    }

    fn updates(&self, _dt: Option<f64>) -> bool {
        true
    }

    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let n = self.w.nrows() as f64;
        duration / self.period * self.particles as f64 * (STAGES * n + 20.0) * n * 8e-9
    }

    // Each sample of a run keeps the particles.
    fn memory(&self, study: &Study) -> (f64, &'static str) {
        let (n, samples) = (study.plant.states.len() as f64, study.simulation.as_ref());
        let samples = samples.map_or(1.0, |simulation| simulation.duration / self.period);
        (samples * (n + 1.0) * self.particles as f64 * NUMBER, "the particles at each sample (reduce their number)")
    }
}

impl Kind for ParticleSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        self.designed(&plan.study.plant, Prediction::ErrorControlled)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        plan.has_period_of_plant(self.period, dt)?;
        self.designed(&plan.study.plant, Prediction::Discrete)
    }
}

impl ParticleSpec {
    /// The filter of a plant in continuous or in discrete time.
    fn designed(&self, plant: &PlantModel, prediction: Prediction) -> Result<Designed, NoObserver> {
        let Self { w, v, p0, period, particles, seed } = self;
        let random = SeededParticles::new(*seed as u64);
        let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
        let filter = ParticleFilter::new(plant.model.clone(), noises, (*period, prediction), *particles, random)?;
        let report = DesignReport {
            statement: Statement::of(format!(
                "One measurement every {}; the distribution of the state by {} with weights, resampled where fewer than half of them count.",
                plant.time_in_words(*period),
                counted(*particles, "particle")
            )),
            matrices: vec![matrix("W", w), matrix("V", v), matrix("P(0)", p0)],
            numbers: vec![
                number(Quantity::Period, *period),
                number("particles", *particles as f64),
                number("seed", *seed as f64),
            ],
            ..without_certificate(plant, "no theorem of stability")
        };
        Ok(Designed::new(filter.into(), report, None))
    }
}

impl Running for ParticleFilter<Model, SeededParticles> {
    runs!(sampled);

    // As a filter it also records its covariance.
    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        replay.filter(name, self.clone(), initial)
    }

    fn filter(&self) -> Option<&dyn designed::Filter> {
        Some(self)
    }

    fn record(&self, _of: &StepOf<'_>, _recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        Err(NoObserver::new(
            "a particle filter draws random numbers at every step, for which an export has no generator",
        ))
    }
}
