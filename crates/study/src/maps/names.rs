//! What the variables of the maps are called in expressions: the names of the study, and those of the papers.
//!
//! | map | variables |
//! |---|---|
//! | phi | states, outputs |
//! | Lambda | inputs, outputs |
//! | B | xi, inputs, outputs |
//! | phi^L | xi, outputs |
//! | s | outputs |
//! | g, m | xi, inputs, outputs |
//! | missing | theta |
//! | beta | chi, outputs |
//! | phi^L of an I&IO | z, outputs |
//! | Q, rho | chi, inputs, outputs |
//!
//! States, inputs and outputs have the names of the study, and `x1, ..`, `u1, ..`, `y1, ..`; the observer's own states
//! are `xi1, ..`. All of them may use the parameters of the plant, and all but `missing` and those of an I&IO the
//! time. Every map but phi is evaluated with xi
//! as its states and with (u, y) as its inputs, so that all of them together are a plant with the inputs (u, y).

use luenberger_expression::{ParameterError, Parameters, Scope, Variable};

use crate::model::PlantModel;

/// The names of the maps of an observer of this plant.
#[derive(Debug, Clone)]
pub(crate) struct MapNames<'a> {
    plant: &'a PlantModel,
    /// The number of xi.
    order: usize,
}

impl<'a> MapNames<'a> {
    /// The names with `order` states of the observer.
    pub(crate) fn new(plant: &'a PlantModel, order: usize) -> Self {
        Self { plant, order }
    }

    /// phi(t, x, y): evaluated with x and y.
    pub(crate) fn image(&self) -> Result<Scope, ParameterError> {
        let states = self.family(&self.plant.states, 'x', Variable::State);
        let names = states.chain(self.family(&self.plant.outputs, 'y', Variable::Input));
        self.scope((self.plant.states.len(), self.plant.outputs.len()), names)
    }

    /// Lambda(t, u, y).
    pub(crate) fn dynamics(&self) -> Result<Scope, ParameterError> {
        self.scope(self.counts(), self.inputs().chain(self.outputs()))
    }

    /// B(t, xi, u, y).
    pub(crate) fn injection(&self) -> Result<Scope, ParameterError> {
        self.scope(self.counts(), self.own().chain(self.inputs()).chain(self.outputs()))
    }

    /// phi^L(t, xi, y).
    pub(crate) fn left_inverse(&self) -> Result<Scope, ParameterError> {
        self.scope(self.counts(), self.own().chain(self.outputs()))
    }

    /// s(t, y).
    pub(crate) fn signal(&self) -> Result<Scope, ParameterError> {
        self.scope(self.counts(), self.outputs())
    }

    /// The missing part of xi as a function of `parameters` entries of theta.
    pub(crate) fn missing(&self, parameters: usize) -> Result<Scope, ParameterError> {
        let theta = (0..parameters).map(|k| (format!("theta{}", k + 1), Variable::State(k)));
        self.scope((parameters, 0), theta)
    }

    /// beta(y, chi): evaluated with (chi, y), of `order` states chi.
    pub(crate) fn manifold(&self, order: usize) -> Result<Scope, ParameterError> {
        let outputs = self.family(&self.plant.outputs, 'y', move |k| Variable::State(order + k));
        self.scope((order + self.plant.outputs.len(), 0), chi(order).chain(outputs))
    }

    /// phi(x) without outputs: evaluated with x.
    pub(crate) fn states(&self) -> Result<Scope, ParameterError> {
        let states = self.family(&self.plant.states, 'x', Variable::State);
        self.scope((self.plant.states.len(), 0), states)
    }

    /// Functions of t, the states and the inputs: evaluated with x and u.
    pub(crate) fn plant(&self) -> Result<Scope, ParameterError> {
        let states = self.family(&self.plant.states, 'x', Variable::State);
        self.scope((self.plant.states.len(), self.plant.inputs.len()), states.chain(self.inputs()))
    }

    /// phi^L(z, y): as that of a KKL observer, with z for xi.
    pub(crate) fn off_manifold(&self) -> Result<Scope, ParameterError> {
        let z = (0..self.order).map(|k| (format!("z{}", k + 1), Variable::State(k)));
        self.scope(self.counts(), z.chain(self.outputs()))
    }

    /// Q and rho(y, chi, u).
    pub(crate) fn freedom(&self, order: usize) -> Result<Scope, ParameterError> {
        let known = self.plant.inputs.len() + self.plant.outputs.len();
        self.scope((order, known), chi(order).chain(self.inputs()).chain(self.outputs()))
    }

    fn counts(&self) -> (usize, usize) {
        (self.order, self.plant.inputs.len() + self.plant.outputs.len())
    }

    fn own(&self) -> impl Iterator<Item = (String, Variable)> + use<> {
        (0..self.order).map(|k| (format!("xi{}", k + 1), Variable::State(k)))
    }

    fn inputs(&self) -> impl Iterator<Item = (String, Variable)> {
        self.family(&self.plant.inputs, 'u', Variable::Input)
    }

    fn outputs(&self) -> impl Iterator<Item = (String, Variable)> {
        let before = self.plant.inputs.len();
        self.family(&self.plant.outputs, 'y', move |k| Variable::Input(before + k))
    }

    /// The names of the study, but for those that a parameter has, and the numbered ones.
    fn family(
        &self,
        names: &'a [String],
        letter: char,
        place: impl Fn(usize) -> Variable,
    ) -> impl Iterator<Item = (String, Variable)> {
        let parameters: &Parameters = &self.plant.parameters;
        let own = names.iter().enumerate().filter(|(_, name)| !parameters.contains_key(*name));
        let own: Vec<(String, Variable)> = own.map(|(k, name)| (name.clone(), place(k))).collect();
        let numbered: Vec<(String, Variable)> =
            (0..names.len()).map(|k| (format!("{letter}{}", k + 1), place(k))).collect();
        own.into_iter().chain(numbered)
    }

    fn scope(
        &self,
        (states, inputs): (usize, usize),
        names: impl Iterator<Item = (String, Variable)>,
    ) -> Result<Scope, ParameterError> {
        Scope::variables(states, inputs, names).with(&self.plant.parameters)
    }
}

fn chi(order: usize) -> impl Iterator<Item = (String, Variable)> {
    (0..order).map(|k| (format!("chi{}", k + 1), Variable::State(k)))
}
