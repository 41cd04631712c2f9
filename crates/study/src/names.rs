//! Sentences of the design, which number states, inputs and outputs, with the names that the study gives them.

use crate::model::PlantModel;

/// `text` with `x2` as the name of the second state, `u1` and `y1` likewise, and `df1/dx2` as `d(NAME')/d(NAME)`. What stands between backticks is quoted from
/// the study, and stays.
pub(crate) fn in_names(plant: &PlantModel, text: &str) -> String {
    let mut told = String::with_capacity(text.len());
    for (number, part) in text.split('`').enumerate() {
        if number > 0 {
            told.push('`');
        }
        if number % 2 == 1 { told.push_str(part) } else { words(plant, part, &mut told) }
    }
    told
}

fn words(plant: &PlantModel, text: &str, told: &mut String) {
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = text;
    while let Some(start) = rest.find(is_letter) {
        told.push_str(&rest[..start]);
        let word_and_more = &rest[start..];
        let end = word_and_more.find(|c| !is_letter(c)).unwrap_or(word_and_more.len());
        let (word, more) = word_and_more.split_at(end);
        let divisor = more.strip_prefix('/').map(|more| &more[..more.find(|c| !is_letter(c)).unwrap_or(more.len())]);
        if let Some((derivative, divisor)) =
            divisor.and_then(|divisor| Some((derivative(plant, word, divisor)?, divisor)))
        {
            told.push_str(&derivative);
            rest = &more[1 + divisor.len()..];
        } else {
            told.push_str(name(plant, word).unwrap_or(word));
            rest = more;
        }
    }
    told.push_str(rest);
}

/// The name of `x2`, `u1`, `y1`.
fn name<'p>(plant: &'p PlantModel, word: &str) -> Option<&'p str> {
    let lists = [('x', &plant.states), ('u', &plant.inputs), ('y', &plant.outputs)];
    lists.into_iter().find_map(|(letter, names)| nth(names, word.strip_prefix(letter)?))
}

/// The entry that `digits` counts to, from 1.
fn nth<'p>(names: &'p [String], digits: &str) -> Option<&'p str> {
    let index = digits.parse::<usize>().ok()?.checked_sub(1)?;
    names.get(index).map(String::as_str)
}

/// `df1` over `dx2`; none where the states have no other names than numbers.
fn derivative(plant: &PlantModel, above: &str, below: &str) -> Option<String> {
    let numbered = |names: &[String], letter: char| {
        names.iter().enumerate().all(|(k, name)| *name == format!("{letter}{}", k + 1))
    };
    if numbered(&plant.states, 'x') && numbered(&plant.outputs, 'y') {
        return None;
    }
    let state = nth(&plant.states, below.strip_prefix("dx")?)?;
    let row = above.strip_prefix("df").and_then(|k| Some(format!("{}'", nth(&plant.states, k)?)));
    let row = row.or_else(|| above.strip_prefix("dh").and_then(|k| nth(&plant.outputs, k)).map(str::to_owned))?;
    Some(format!("d({row})/d({state})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Builtin, Model};
    use luenberger_plants::double_integrator;

    fn plant(states: [&str; 2]) -> PlantModel {
        PlantModel {
            model: Model::Builtin(Builtin::DoubleIntegrator(double_integrator().to_dynamic())),
            states: states.map(str::to_owned).to_vec(),
            inputs: vec!["force".to_owned()],
            outputs: vec!["measured".to_owned()],
            units: Vec::new(),
            parameters: crate::expression::Parameters::new(),
            time_unit: None,
        }
    }

    #[test]
    fn numbers_become_names_and_quotations_stay() {
        let named = plant(["position", "top speed"]);
        let text = "x1 in [0, 2], x2 <= 1e3, u1 = 0: `x1 + u1` and (x(t), x3, xx1, exp(-2 t)); df1/dx2 = 1, dh1/dx1, df3/dx1 at x = y1/x2";
        assert_eq!(
            in_names(&named, text),
            "position in [0, 2], top speed <= 1e3, force = 0: `x1 + u1` and (x(t), x3, xx1, exp(-2 t)); \
             d(position')/d(top speed) = 1, d(measured)/d(position), df3/dx1 at x = measured/top speed"
        );
    }

    #[test]
    fn a_plant_without_names_keeps_its_numbers() {
        let mut plain = plant(["x1", "x2"]);
        plain.outputs = vec!["y1".to_owned()];
        let text = "x1 in [0, 2]: df1/dx2 = 1; y1";
        assert_eq!(in_names(&plain, text), text);
    }
}
