//! From the variables of a file to a plant.

use super::ImportError;
use super::variable::{Columns, NONE, UNREAD, Value, Variable, is_known, names_of};
use nalgebra::DMatrix;

/// A plant `x' = A x + B u`, `y = C x + D u`, every entry finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// A, n x n, n at least 1.
    pub a: DMatrix<f64>,
    /// B, n x m; m may be 0.
    pub b: DMatrix<f64>,
    /// C, p x n, p at least 1.
    pub c: DMatrix<f64>,
    /// D, p x m; `None` where it is zero or absent.
    pub d: Option<DMatrix<f64>>,
    /// The condition number of E, in units in which its rows and columns have entries of about one, if the file has an
    /// E that is not the identity: A and B are then `E^-1 A` and `E^-1 B`.
    pub descriptor: Option<f64>,
    /// The period of a model in discrete time; none in continuous time. True, a period left open, counts samples: 1.
    pub dt: Option<f64>,
    /// The names of the states; none if the file has none, or none that can be used.
    pub states: Option<Vec<String>>,
    /// The names of the inputs, likewise.
    pub inputs: Option<Vec<String>>,
    /// The names of the outputs, likewise.
    pub outputs: Option<Vec<String>>,
    /// The names of the other variables in the file.
    pub ignored: Vec<String>,
}

impl Model {
    /// Selects the matrices among the variables, and checks them.
    pub(super) fn new(variables: Vec<Variable>) -> Result<Self, ImportError> {
        let mut ignored = Vec::new();
        let variables = chosen(variables, &mut ignored)?;
        let names: Vec<String> = variables.iter().map(Variable::described).chain(ignored.clone()).collect();
        let mut take = Take { variables };
        let missing = |name| ImportError::Missing { name, found: names.clone() };
        let mut a = take.matrix("A")?.ok_or_else(|| missing("A"))?;
        let n = a.nrows();
        if n == 0 || a.ncols() != n {
            return Err(shape("A", &a, "square, of order 1 at least".to_owned()));
        }
        let c = take.matrix("C")?.ok_or_else(|| missing("C"))?;
        if c.ncols() != n || c.nrows() == 0 {
            return Err(shape("C", &c, format!("p x {n} (A is {n} x {n})")));
        }
        // MATLAB and numpy may write a matrix without columns as 0 x 0.
        let mut b = take.matrix("B")?.filter(|b| !b.is_empty()).unwrap_or_else(|| DMatrix::zeros(n, 0));
        if b.nrows() != n {
            return Err(shape("B", &b, format!("{n} x m (A is {n} x {n})")));
        }
        let d = match take.matrix("D")?.filter(|d| !d.is_empty()) {
            Some(d) => feedthrough(d, c.nrows(), b.ncols())?,
            None => None,
        };
        let mut descriptor = None;
        if let Some(e) = take.matrix("E")?.filter(|e| !e.is_empty() && *e != DMatrix::identity(n, n)) {
            if e.shape() != (n, n) {
                return Err(shape("E", &e, format!("{n} x {n}")));
            }
            let found = luenberger_linalg::standard_form(&e, &a, &b).map_err(ImportError::Descriptor)?;
            (a, b, descriptor) = (found.a, found.b, Some(found.condition));
        }
        let dt = match take.sampling_time("dt")? {
            Some(dt) => Some(dt),
            None => take.sampling_time("Ts")?,
        };
        let states = take.names(Columns::States, n);
        let inputs = take.names(Columns::Inputs, b.ncols());
        let outputs = take.names(Columns::Outputs, c.nrows());
        ignored.extend(take.variables.into_iter().map(|variable| variable.name));
        ignored.sort();
        Ok(Self { a, b, c, d, descriptor, dt, states, inputs, outputs, ignored })
    }
}

/// The variables themselves, if A is among them, otherwise the fields of the one structure that has an A.
fn chosen(variables: Vec<Variable>, ignored: &mut Vec<String>) -> Result<Vec<Variable>, ImportError> {
    let has_a = |list: &[Variable]| list.iter().any(|variable| variable.name.eq_ignore_ascii_case("a"));
    if has_a(&variables) {
        return Ok(variables);
    }
    let mut model: Option<(String, Vec<Variable>)> = None;
    let mut rest = Vec::new();
    for variable in variables {
        match variable {
            Variable { name, value: Value::Structure(fields) } if has_a(&fields) => {
                if let Some((first, _)) = model {
                    return Err(ImportError::Ambiguous { first, second: name });
                }
                model = Some((name, fields));
            }
            other => rest.push(other),
        }
    }
    match model {
        Some((_, fields)) => {
            ignored.extend(rest.into_iter().map(|variable| variable.name));
            Ok(fields)
        }
        // No model found: the names are for the error message.
        None => Ok(rest),
    }
}

struct Take {
    variables: Vec<Variable>,
}

impl Take {
    /// Removes and returns the variable of this name, in upper or lower case.
    fn variable(&mut self, name: &str) -> Result<Option<Variable>, ImportError> {
        let of = |list: &[Variable]| list.iter().position(|variable| variable.name.eq_ignore_ascii_case(name));
        let Some(place) = of(&self.variables) else { return Ok(None) };
        let found = self.variables.remove(place);
        match of(&self.variables) {
            Some(other) => {
                Err(ImportError::Ambiguous { first: found.name, second: self.variables[other].name.clone() })
            }
            None => Ok(Some(found)),
        }
    }

    fn matrix(&mut self, name: &'static str) -> Result<Option<DMatrix<f64>>, ImportError> {
        let Some(Variable { name: given, value }) = self.variable(name)? else { return Ok(None) };
        let m = match value {
            Value::Matrix(m) => m,
            Value::Structure(_) => return Err(ImportError::NotReal { name: given, found: "a structure".to_owned() }),
            Value::Names(_) => return Err(ImportError::NotReal { name: given, found: "a list of texts".to_owned() }),
            Value::Other(found) => return Err(ImportError::NotReal { name: given, found }),
        };
        for column in 0..m.ncols() {
            for row in 0..m.nrows() {
                let value = m[(row, column)];
                if !value.is_finite() {
                    return Err(ImportError::NotFinite { name, row, column, value });
                }
            }
        }
        Ok(Some(m))
    }

    /// The names of these columns: as many as there are, distinct, and fit for a study. Others stay among the
    /// variables.
    fn names(&mut self, columns: Columns, count: usize) -> Option<Vec<String>> {
        let usable = |names: &Vec<String>| {
            let fits = |(k, name): (usize, &String)| {
                let length = name.chars().count();
                (1..=100).contains(&length) && !name.contains(char::is_control) && !names[..k].contains(name)
            };
            names.len() == count && count > 0 && names.iter().enumerate().all(fits)
        };
        let place = self.variables.iter().position(|variable| {
            let named = names_of(&variable.name) == Some(columns);
            named && matches!(&variable.value, Value::Names(names) if usable(names))
        })?;
        match self.variables.remove(place).value {
            Value::Names(names) => Some(names),
            _ => None,
        }
    }

    /// The sampling time; 0, false, an empty matrix and `None` mean continuous time.
    fn sampling_time(&mut self, name: &str) -> Result<Option<f64>, ImportError> {
        let Some(Variable { name, value }) = self.variable(name)? else { return Ok(None) };
        let value = match value {
            Value::Matrix(m) if m.iter().all(|x| *x == 0.0) => return Ok(None),
            Value::Matrix(m) if m.len() == 1 && m[(0, 0)] > 0.0 && m[(0, 0)].is_finite() => return Ok(Some(m[(0, 0)])),
            Value::Matrix(m) => m[(0, 0)].to_string(),
            Value::Other(found) if found == NONE => return Ok(None),
            Value::Other(found) => found,
            Value::Structure(_) => "a structure".to_owned(),
            Value::Names(_) => "a list of texts".to_owned(),
        };
        Err(ImportError::Discrete { name, value })
    }
}

fn shape(name: &'static str, m: &DMatrix<f64>, expected: String) -> ImportError {
    ImportError::Shape { name, found: m.shape(), expected }
}

fn feedthrough(d: DMatrix<f64>, outputs: usize, inputs: usize) -> Result<Option<DMatrix<f64>>, ImportError> {
    let is_zero = d.iter().all(|entry| *entry == 0.0);
    // In python-control and MATLAB a scalar zero stands for a zero matrix.
    if d.shape() != (outputs, inputs) && !(is_zero && d.len() == 1) {
        return Err(shape("D", &d, format!("{outputs} x {inputs} (C is {outputs} x n, B is n x {inputs})")));
    }
    Ok(Some(d).filter(|_| !is_zero))
}

/// Whether a variable may be skipped: its name is not one of a model.
pub(super) fn unread(name: String) -> Variable {
    assert!(!is_known(&name));
    Variable { name, value: Value::Other(UNREAD.to_owned()) }
}
