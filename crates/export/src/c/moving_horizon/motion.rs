//! The plant over a period: the next state, its Jacobian, and the covariance of the noise.

use super::Writer;
use crate::c::plant::Arguments;
use crate::c::transition::Transition;

impl Writer<'_> {
    /// A call of `linearise` for a sample of the window.
    pub(super) fn linearise(&self, sample: &str, x: &str, z: &str) -> String {
        let arguments = Arguments::of(self.maps, false);
        let time = if arguments.time { format!("{sample}.t, ") } else { String::new() };
        let inputs = if arguments.inputs.is_some() { format!("{sample}.u, ") } else { String::new() };
        format!("linearise({time}{inputs}{x}, {z});")
    }

    fn transition(&self) -> Transition<'_> {
        let arguments = Arguments::of(self.maps, false);
        Transition::new(self.export, ("motion", &self.maps.motion), arguments, &self.n)
    }

    /// An entry of A in the motion z = (F(x), Q, A) of `linearise`.
    pub(super) fn forward(&self, row: &str, column: &str) -> String {
        self.transition().phi(row, column)
    }

    /// The length of z.
    pub(super) fn motion(&self) -> String {
        self.transition().length()
    }

    /// F, its Jacobian and the noise over a period.
    pub(super) fn linearised(&self, text: &mut String) {
        let transition = self.transition();
        match self.estimator.substeps() {
            Some(substeps) => transition.linearise(text, substeps),
            None => transition.linearise_discrete(text),
        }
        transition.spread(text);
    }
}
