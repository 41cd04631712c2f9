//! A study with other values of what is tuned: read anew from its tree, so that everything that depends on a number
//! follows, and where the numbers are in its text.

use std::collections::BTreeSet;
use std::ops::Range;

use nalgebra::DMatrix;

use super::tune::weight;
use super::{assemble, json, own, toml};
use crate::diagnostic::Diagnostic;
use crate::reader::Reader;
use crate::reader::tree::{Entry, Node, Step, Value};
use crate::study::{Format, Part, Study, Tunable, Tuned};
use crate::tuning::Value as Keyed;

/// The place of an observer among its tree.
pub(super) fn place_of(root: &Node, name: &str) -> Option<Vec<Step>> {
    let named = |node: &Node| node.get("name").or_else(|| node.get("kind")).and_then(Node::text) == Some(name);
    let k = root.get("observer")?.list()?.iter().position(named)?;
    Some(vec![Step::Key("observer".to_owned()), Step::Entry(k)])
}

/// W, V, G or P(0) of an observer: its own key, or that of its table `kalman`.
pub(super) fn noise_node<'a>(own: &'a Node, key: &str) -> Option<&'a Node> {
    own.get(key).or_else(|| own.get("kalman")?.get(key))
}

/// The order of W, V or P(0) of an observer of n states and p outputs: W has that of the noise where it enters by G.
pub(super) fn order_of(own: &Node, key: &str, (n, p): (usize, usize)) -> usize {
    let columns =
        |g: &Node| Some(g.list()?.first()?.list().map_or_else(|| g.list().map_or(0, <[Node]>::len), <[Node]>::len));
    let entering = || noise_node(own, "g").and_then(columns).unwrap_or(n);
    match key {
        "v" => p,
        "w" => entering(),
        _ => n,
    }
}

/// A new value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NewValue {
    Keyed(Keyed),
    Texts(Vec<String>),
}

impl NewValue {
    fn node(&self) -> Node {
        fn of(value: &Keyed) -> Value {
            match value {
                Keyed::Number(x) => Value::Number(*x, false),
                Keyed::List(list) => Value::List(list.iter().map(|one| Node { span: 0..0, value: of(one) }).collect()),
                Keyed::Table(_) => Value::Table(Vec::new()),
            }
        }
        let value = match self {
            Self::Keyed(value) => of(value),
            Self::Texts(texts) => {
                Value::List(texts.iter().map(|text| Node { span: 0..0, value: Value::Text(text.clone()) }).collect())
            }
        };
        Node { span: 0..0, value }
    }

    /// As text, the same in TOML and in JSON.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Keyed(value) => value.toml(),
            Self::Texts(texts) => serde_json::Value::from(texts.clone()).to_string().replace("\",\"", "\", \""),
        }
    }
}

/// A value that is changed, or a key that is added.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edit {
    /// The table.
    parent: Vec<Step>,
    /// Its key.
    pub(crate) key: String,
    /// The key in front of which it is added if it is not there.
    before: &'static str,
    pub(crate) value: NewValue,
    /// Which of the parameters it has.
    pub(crate) of: Vec<usize>,
}

impl Edit {
    fn place(&self) -> Vec<Step> {
        self.parent.iter().cloned().chain([Step::Key(self.key.clone())]).collect()
    }
}

/// The tree of a study, of which numbers are changed.
#[derive(Debug)]
pub(crate) struct Editable<'a> {
    study: &'a Study,
    root: Node,
    /// The plant and the observer alone.
    plain: Node,
    observer: Vec<Step>,
}

/// The tables that the design of an observer depends on.
const KEPT: [&str; 5] = ["plant", "operating_point", "estimate", "solver", "observer"];

impl<'a> Editable<'a> {
    /// None if the text does not have the observer.
    pub(crate) fn new(study: &'a Study, observer: &str) -> Option<Self> {
        let text = study.source.text();
        let (root, _) = match study.format {
            Format::Toml => toml::tree(text),
            Format::Json => json::tree(text),
        };
        let place = place_of(&root, observer)?;
        let mut plain = root.clone();
        let own = root.at(&place)?.clone();
        if let Value::Table(entries) = &mut plain.value {
            entries.retain(|entry| KEPT.contains(&entry.key.as_str()));
            for entry in entries.iter_mut().filter(|entry| entry.key == "observer") {
                entry.node.value = Value::List(vec![own.clone()]);
            }
        }
        Some(Self { study, root, plain, observer: place })
    }

    /// The changes for these values; of a bias only where `is_written`, since otherwise the data are changed.
    pub(crate) fn edits(&self, parameters: &[Tuned], values: &[f64], is_written: bool) -> Option<Vec<Edit>> {
        let own = self.root.at(&self.observer)?;
        let mut edits = Vec::new();
        let n = self.study.order();
        for key in ["w", "v", "p0"] {
            let index = |what: &Tunable| match what {
                Tunable::W(i) if key == "w" => Some(*i),
                Tunable::V(i) if key == "v" => Some(*i),
                Tunable::P0(i) if key == "p0" => Some(*i),
                _ => None,
            };
            let order = order_of(own, key, (n, self.study.plant.outputs.len()));
            let all = (0..parameters.len()).filter(|k| index(&parameters[*k].what).is_some());
            // What is behind the noise of the plant is of the parameters that are estimated.
            let (of, of_parameters): (Vec<usize>, Vec<usize>) =
                all.partition(|k| index(&parameters[*k].what) < Some(order));
            let new = |k: usize| Some((index(&parameters[k].what)? - order, values[k]));
            edits.extend(self.of_parameters(key, &of_parameters, new));
            if of.is_empty() {
                continue;
            }
            let node = noise_node(own, key);
            let matrix = node.map_or_else(|| Some(DMatrix::identity(order, order)), |node| weight(node, order))?;
            // Correlations stay as they are.
            let mut factor = vec![1.0; order];
            for &k in &of {
                let i = index(&parameters[k].what)?;
                factor[i] = (values[k] / matrix[(i, i)]).sqrt();
            }
            let mut scaled = DMatrix::from_fn(order, order, |i, j| matrix[(i, j)] * factor[i] * factor[j]);
            for &k in &of {
                let i = index(&parameters[k].what)?;
                scaled[(i, i)] = values[k];
            }
            let is_inner = own.get(key).is_none() && node.is_some();
            let inner = is_inner.then(|| Step::Key("kalman".to_owned()));
            let parent = self.observer.iter().cloned().chain(inner).collect();
            edits.push(Edit {
                parent,
                key: key.to_owned(),
                before: "w",
                value: NewValue::Keyed(Keyed::weight(&scaled)),
                of,
            });
        }
        let top = |key: &str| Step::Key(key.to_owned());
        for (k, one) in parameters.iter().enumerate() {
            let of_noise = |name: &str| vec![top("estimate"), top("noises"), top(name)];
            let (parent, key) = match &one.what {
                Tunable::Parameter(name) => (vec![top("plant"), top("parameters")], name.as_str()),
                Tunable::Deviation(name) => (of_noise(name), "deviation"),
                Tunable::CorrelationTime(name) => (of_noise(name), "tau"),
                _ => continue,
            };
            let value = NewValue::Keyed(Keyed::Number(values[k]));
            edits.push(Edit { parent, key: key.to_owned(), before: "", value, of: vec![k] });
        }
        for (k, one) in parameters.iter().enumerate() {
            if let Tunable::Delay(j) = one.what {
                let parent = vec![top("plant"), top("delays")];
                let value = NewValue::Keyed(Keyed::Number(values[k]));
                edits.push(Edit { parent, key: self.study.plant.outputs[j].clone(), before: "", value, of: vec![k] });
            }
        }
        let keys: BTreeSet<&String> = parameters.iter().filter_map(|one| own_key(&one.what)).map(|of| of.0).collect();
        for key in keys {
            let part = |k: usize| own_key(&parameters[k].what).filter(|of| of.0 == key).map(|of| of.1);
            let of: Vec<usize> = (0..parameters.len()).filter(|k| part(*k).is_some()).collect();
            let new: Vec<(Part, f64)> = of.iter().filter_map(|k| Some((part(*k)?, values[*k]))).collect();
            let value = own::changed(key, own.get(key)?, self.study.plant.dt, &new)?;
            let parent = self.observer.clone();
            edits.push(Edit { parent, key: key.clone(), before: "", value: NewValue::Keyed(value), of });
        }
        let biased: Vec<usize> =
            (0..parameters.len()).filter(|k| matches!(parameters[*k].what, Tunable::Bias(_))).collect();
        if is_written && !biased.is_empty() {
            let given = self.root.get("log")?.get("outputs").and_then(Node::texts);
            let mut outputs: Vec<String> = given.map_or_else(
                || self.study.plant.outputs.clone(),
                |texts| texts.into_iter().map(str::to_owned).collect(),
            );
            for &k in &biased {
                if let Tunable::Bias(j) = parameters[k].what {
                    outputs[j] = less(&outputs[j], values[k]);
                }
            }
            let value = NewValue::Texts(outputs);
            edits.push(Edit { parent: vec![top("log")], key: "outputs".to_owned(), before: "file", value, of: biased });
        }
        Some(edits)
    }

    /// The change of `w` or `p0` of the parameters that are estimated.
    fn of_parameters(&self, key: &str, of: &[usize], new: impl Fn(usize) -> Option<(usize, f64)>) -> Option<Edit> {
        let named = self.study.estimated.iter().filter(|one| one.noise.is_none());
        let mut values: Vec<f64> = named.map(|one| if key == "w" { one.w } else { one.p0 }).collect();
        for (k, value) in of.iter().filter_map(|k| new(*k)) {
            values[k] = value;
        }
        let value = NewValue::Keyed(Keyed::List(values.into_iter().map(Keyed::Number).collect()));
        let parent = vec![Step::Key("estimate".to_owned())];
        let edit = Edit { parent, key: key.to_owned(), before: "parameters", value, of: of.to_vec() };
        (!of.is_empty()).then_some(edit)
    }

    /// The study with these changes, of its plant and the observer alone; where measurements stand at their times, its
    /// plant has no delays.
    ///
    /// # Errors
    /// Why it is no study.
    pub(crate) fn study(&self, edits: &[Edit], is_on_time: bool) -> Result<Study, String> {
        let mut tree = self.plain.clone();
        let plant = [Step::Key("plant".to_owned())];
        if let Some(Value::Table(entries)) = tree.at_mut(&plant).map(|node| &mut node.value).filter(|_| is_on_time) {
            entries.retain(|entry| entry.key != "delays");
        }
        let own = [Step::Key("observer".to_owned()), Step::Entry(0)];
        // A gate rejects what does not fit, and a likelihood without it grows with what is rejected.
        if let Some(Value::Table(entries)) = tree.at_mut(&own).map(|node| &mut node.value) {
            entries.retain(|entry| entry.key != "gate");
        }
        let is_delay = |edit: &&Edit| edit.parent.last() == Some(&Step::Key("delays".to_owned()));
        for edit in edits.iter().filter(|edit| !(is_on_time && is_delay(edit))) {
            let mut parent = edit.parent.clone();
            if let Some(step) = parent.get_mut(1).filter(|_| edit.parent.starts_with(&self.observer)) {
                *step = Step::Entry(0);
            }
            let Some(Value::Table(entries)) = tree.at_mut(&parent).map(|node| &mut node.value) else {
                return Err(format!("the study has no place for {}", edit.key));
            };
            match entries.iter_mut().find(|entry| entry.key == edit.key) {
                Some(entry) => entry.node = edit.value.node(),
                None => entries.push(Entry { key: edit.key.clone(), span: 0..0, node: edit.value.node() }),
            }
        }
        let mut reader = Reader::new(&self.study.data);
        let study = assemble(&tree, &self.study.source, &mut reader);
        let mistake = reader.mistakes.into_iter().chain(reader.absences).next();
        match (study, mistake) {
            (Some(study), None) => Ok(study),
            (_, mistake) => {
                Err(mistake.map_or_else(|| "it is no study".to_owned(), |Diagnostic { message, .. }| message))
            }
        }
    }

    /// What an edit does to the text: the bytes that it replaces, and by what. None if the text has no place for it.
    pub(crate) fn replacement(&self, edit: &Edit) -> Option<(Range<usize>, String)> {
        if let Some(node) = self.root.at(&edit.place()) {
            return Some((node.span.clone(), edit.value.text()));
        }
        let (text, before) = (self.study.source.text(), self.root.at(&edit.parent)?.entry(edit.before)?);
        let (start, value) = (before.span.start, edit.value.text());
        let line = text[..start].rfind('\n').map_or(0, |k| k + 1);
        let added = match self.study.format {
            Format::Json => format!("{:?}: {value}, ", edit.key),
            Format::Toml if text[line..start].trim().is_empty() => {
                format!("{} = {value}\n{}", edit.key, &text[line..start])
            }
            Format::Toml => format!("{} = {value}, ", edit.key),
        };
        Some((start..start, added))
    }
}

/// The key of the observer that has a number, and which of its numbers it is.
fn own_key(what: &Tunable) -> Option<(&String, Part)> {
    match what {
        Tunable::Own(key, part) => Some((key, *part)),
        _ => None,
    }
}

/// An output of a log less a bias.
fn less(output: &str, bias: f64) -> String {
    let is_name = output.chars().all(|c| c.is_alphanumeric() || c == '_');
    let column = if is_name { output.to_owned() } else { format!("({output})") };
    let sign = if bias < 0.0 { '+' } else { '-' };
    format!("{column} {sign} {}", Keyed::Number(bias.abs()).toml())
}
