//! The plants of an experiment: the model, the plant as it is simulated, and what it becomes.

use luenberger_expression::{
    Expression, ExpressionPlant, Extrapolation, Interpolation, LookupTable, Scope, Surface, Table, Tables, Variable,
};
use luenberger_plants::StateSpace;

use crate::any_plant::AnyPlant;
use crate::experiment::{Experiment, Lookup};
use crate::plant::StoredPlant;
use crate::rows::matrix;

pub(crate) type Result<T> = core::result::Result<T, String>;

pub(crate) fn text(error: impl core::fmt::Display) -> String {
    error.to_string()
}

/// A plant that can be simulated.
pub(crate) enum Built {
    Expressions(ExpressionPlant),
    Linear(StateSpace),
}

impl Built {
    pub(crate) fn new(plant: &StoredPlant, experiment: &Experiment) -> Result<Self> {
        Ok(match plant {
            StoredPlant::Expressions { states, inputs, f, h, parameters } => {
                let parameters = parameters.as_ref().unwrap_or(&experiment.parameters);
                let scope = Scope::plant(states.len(), inputs.len()).named(states, inputs).map_err(text)?;
                let scope = scope.with(parameters).map_err(text)?.tables(&tables(experiment)?).map_err(text)?;
                Self::Expressions(ExpressionPlant::within(f, h, &scope).map_err(text)?)
            }
            StoredPlant::Linear { a, b, c, d } => {
                let plant = StateSpace::new(matrix(a), matrix(b), matrix(c)).map_err(text)?;
                Self::Linear(match d {
                    Some(d) => plant.with_feedthrough(matrix(d)).map_err(text)?,
                    None => plant,
                })
            }
        })
    }

    pub(crate) fn any(&self) -> AnyPlant<'_> {
        match self {
            Self::Expressions(plant) => AnyPlant(plant),
            Self::Linear(plant) => AnyPlant(plant),
        }
    }
}

fn tables(experiment: &Experiment) -> Result<Tables> {
    let built = |lookup: &Lookup| {
        let between = if lookup.cubic { Interpolation::MonotoneCubic } else { Interpolation::Linear };
        let beyond = if lookup.extrapolates { Extrapolation::Linear } else { Extrapolation::Hold };
        if lookup.z.is_empty() {
            Table::new(&lookup.x, &lookup.y, between, beyond).map(LookupTable::from).map_err(text)
        } else {
            Surface::new(&lookup.x, &lookup.y, &lookup.z, beyond).map(LookupTable::from).map_err(text)
        }
    };
    experiment.tables.iter().map(|(name, lookup)| Ok((name.clone(), built(lookup)?))).collect()
}

/// The plants of an experiment.
pub(crate) struct Plants {
    /// What the observers are designed for.
    pub(crate) model: Built,
    /// The plant from the start, if it is another one.
    pub(crate) truth: Option<Built>,
    /// The plant after each event that changes it.
    pub(crate) later: Vec<Option<Built>>,
}

impl Plants {
    pub(crate) fn new(experiment: &Experiment) -> Result<Self> {
        let built = |plant: &StoredPlant| Built::new(plant, experiment);
        let truth = experiment.truth.as_ref();
        let later = truth.map_or(&[][..], |truth| &truth.events).iter().map(|event| &event.plant);
        Ok(Self {
            model: built(&experiment.plant)?,
            truth: truth.and_then(|truth| truth.plant.as_ref()).map(built).transpose()?,
            later: later.map(|plant| plant.as_ref().map(built).transpose()).collect::<Result<_>>()?,
        })
    }
}

/// The rows of a law of the time and the states, which are named as in the experiment and x1, x2, ..
pub(crate) fn law(experiment: &Experiment, rows: &[String]) -> Result<Vec<Expression>> {
    let own = experiment.states.iter().enumerate().filter(|(_, name)| !experiment.parameters.contains_key(*name));
    let own = own.map(|(k, name)| (name.clone(), Variable::State(k)));
    let count = experiment.states.len();
    let numbered = (0..count).map(|k| (format!("x{}", k + 1), Variable::State(k)));
    let scope = Scope::variables(count, 0, own.chain(numbered)).with(&experiment.parameters).map_err(text)?;
    rows.iter().map(|row| Expression::parse(row, &scope).map_err(text)).collect()
}
