//! Commented example studies as a starting point.

use luenberger_expression::nearest;

use crate::error::StudyError;

/// An example study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Template {
    /// Its name, equal to that of the plant.
    pub name: &'static str,
    /// A one-line description.
    pub about: &'static str,
    /// The study, in TOML with comments.
    pub text: &'static str,
    /// The files it reads, by name.
    pub files: &'static [(&'static str, &'static str)],
}

impl Template {
    /// The study for a file of this name, which its first comment tells to run.
    ///
    /// ```
    /// let template = luenberger_study::template::template("two-tanks")?;
    /// assert!(template.text_of("a.toml").contains("luenberger run a.toml"));
    /// # Ok::<(), luenberger_study::StudyError>(())
    /// ```
    pub fn text_of(&self, file: &str) -> String {
        // A line break would end the comment.
        let file = file.replace(|c: char| c.is_control(), " ");
        self.text.replacen(&format!("luenberger run {}.toml", self.name), &format!("luenberger run {file}"), 1)
    }
}

/// All of them.
pub const TEMPLATES: &[Template] = &[
    Template {
        name: "double-integrator",
        about: "position is measured, velocity is wanted: linear, cubic and sampled observers side by side",
        text: include_str!("../../templates/double-integrator.toml"),
        files: &[],
    },
    Template {
        name: "flexible-joint",
        about: "a robot link with a flexible joint: one gain with a proof, the mean-value-theorem observer, a Kalman filter",
        text: include_str!("../../templates/flexible-joint.toml"),
        files: &[],
    },
    Template {
        name: "cuk",
        about: "the Cuk converter in expressions: one gain for all duty cycles",
        text: include_str!("../../templates/cuk.toml"),
        files: &[],
    },
    Template {
        name: "cuk-observers",
        about: "the same converter: KKL, PEB, KKL+PEB, immersion-and-invariance and high-gain observers side by side",
        text: include_str!("../../templates/cuk-observers.toml"),
        files: &[],
    },
    Template {
        name: "cuk-table-1",
        about: "the six observers of Table I of Yi, Ortega and Zhang in the run of their figure, beside a controller",
        text: include_str!("../../templates/cuk-table-1.toml"),
        files: &[],
    },
    Template {
        name: "exponential-cascade",
        about: "a cascade with an exponential: an unknown constant is estimated, or a KKL observer with a varying Lambda",
        text: include_str!("../../templates/exponential-cascade.toml"),
        files: &[],
    },
    Template {
        name: "van-der-pol",
        about: "van der Pol's oscillator: a KKL observer in closed form, and one computed by simulation",
        text: include_str!("../../templates/van-der-pol.toml"),
        files: &[],
    },
    Template {
        name: "chaotic",
        about: "a chaotic flow in expressions: a gain on a box, and a sweep of the first error",
        text: include_str!("../../templates/chaotic.toml"),
        files: &[],
    },
    Template {
        name: "duffing",
        about: "the reverse Duffing oscillator: an observer computed by simulation",
        text: include_str!("../../templates/duffing.toml"),
        files: &[],
    },
    Template {
        name: "heat-rod",
        about: "twenty temperatures, three of them measured: Kalman gain and a cubic term",
        text: include_str!("../../templates/heat-rod.toml"),
        files: &[],
    },
    Template {
        name: "mimo",
        about: "two inputs, two outputs, repeated poles, feedback from the estimate, an ensemble",
        text: include_str!("../../templates/mimo.toml"),
        files: &[],
    },
    Template {
        name: "load-torque",
        about: "a motor with an unknown load: proportional-integral and unknown-input observers, bounds of the error",
        text: include_str!("../../templates/load-torque.toml"),
        files: &[],
    },
    Template {
        name: "two-tanks",
        about: "two tanks with an inflow of which a bound is known: interval observers, which enclose the levels",
        text: include_str!("../../templates/two-tanks.toml"),
        files: &[],
    },
    Template {
        name: "servo",
        about: "a motor with an encoder and a load of which a bound is known: super-twisting and extended-state observers",
        text: include_str!("../../templates/servo.toml"),
        files: &[],
    },
    Template {
        name: "optimal-cubic",
        about: "a cart that is pushed: the cubic observer of least cost beside the linear optimum",
        text: include_str!("../../templates/optimal-cubic.toml"),
        files: &[],
    },
    Template {
        name: "resonance",
        about: "a structure with little damping: Kalman, H2 and H-infinity filters",
        text: include_str!("../../templates/resonance.toml"),
        files: &[],
    },
    Template {
        name: "attitude",
        about: "a quaternion and the biases of gyroscopes: the error-state Kalman filter beside an extended one",
        text: include_str!("../../templates/attitude.toml"),
        files: &[],
    },
    Template {
        name: "measured-log",
        about: "a motor on the bench: observers on measured data",
        text: include_str!("../../templates/measured-log.toml"),
        files: &[("measured-log.csv", include_str!("../../templates/measured-log.csv"))],
    },
];

/// The template of that name.
///
/// # Errors
/// [`StudyError::Template`] with the nearest name.
pub fn template(name: &str) -> Result<&'static Template, StudyError> {
    let names = || TEMPLATES.iter().map(|template| template.name);
    TEMPLATES.iter().find(|template| template.name == name).ok_or_else(|| {
        let hint = match nearest(name, names()) {
            Some(near) => format!("the nearest is {near:?}"),
            None => format!("there are {}", names().collect::<Vec<_>>().join(", ")),
        };
        StudyError::Template { name: name.to_owned(), hint }
    })
}

/// The text of the template of that name.
pub fn text(name: &str) -> Option<&'static str> {
    TEMPLATES.iter().find(|template| template.name == name).map(|template| template.text)
}
