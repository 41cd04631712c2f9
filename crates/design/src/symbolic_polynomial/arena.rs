//! The values and atoms of one evaluation.

use std::collections::{BTreeSet, HashMap};

use luenberger_proof::{Interval, Ring};

use super::polynomial::{Polynomial, constant, evaluate, is_exact, number, partial, reciprocal, sum, times};
use super::{ELSEWHERE, SymbolicPolynomial};

/// Most monomials of one polynomial.
const MONOMIALS: usize = 2000;
/// Most values in one arena: 64 MB or so at worst.
const VALUES: usize = 50_000;
/// The largest exponent that is multiplied out.
const POWER: u32 = 32;

/// The functions that have atoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Recip,
    Exp,
    Ln,
    Sin,
    Cos,
    Sqrt,
    Atan,
    Tanh,
}

impl Function {
    /// -1 for an odd function, 1 for an even one, 0 for others.
    fn parity(self) -> i8 {
        match self {
            Self::Sin | Self::Atan | Self::Tanh => -1,
            Self::Cos => 1,
            Self::Recip | Self::Exp | Self::Ln | Self::Sqrt => 0,
        }
    }

    fn at(self, x: &Interval) -> Option<Interval> {
        match self {
            Self::Recip => reciprocal(x),
            Self::Exp => Some(x.exp()),
            Self::Ln => x.ln(),
            Self::Sin => Some(x.sin()),
            Self::Cos => Some(x.cos()),
            Self::Sqrt => x.sqrt(),
            Self::Atan => Some(x.atan()),
            Self::Tanh => Some(x.tanh()),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Atom {
    Variable(usize),
    Of(Function, Argument),
}

/// The argument of a function, and the value of the arena that it is, if it is one.
#[derive(Clone, Debug)]
pub(super) struct Argument {
    pub(super) polynomial: Polynomial,
    pub(super) value: Option<usize>,
}

impl PartialEq for Argument {
    /// Whether both are the same function for sure.
    fn eq(&self, other: &Self) -> bool {
        let same_value = self.value.is_some() && self.value == other.value;
        same_value || (self.polynomial == other.polynomial && is_exact(&self.polynomial))
    }
}

/// How a value was made: operation and operands.
pub(super) type Origin = (u8, u64, u64);

/// The polynomials of one evaluation.
#[derive(Clone, Debug, Default)]
pub struct Arena {
    pub(super) number: u64,
    values: Vec<Polynomial>,
    pub(super) origins: HashMap<Origin, usize>,
    atoms: Vec<Atom>,
    pub(super) failed: Option<&'static str>,
    pub(super) questions: usize,
}

impl Arena {
    /// An empty arena with this number.
    pub(super) fn numbered(number: u64) -> Self {
        Self { number, ..Self::default() }
    }

    pub(super) fn keep(&mut self, value: Polynomial) -> SymbolicPolynomial {
        let at = self.values.len();
        if at >= VALUES {
            self.failed.get_or_insert("too many operations");
        } else {
            self.values.push(value);
        }
        SymbolicPolynomial { arena: self.number, at }
    }

    pub(super) fn fail(&mut self, what: &'static str) -> Polynomial {
        self.failed.get_or_insert(what);
        Vec::new()
    }

    /// The polynomial of a value of this arena; none for a value of another or of no arena.
    pub fn value(&self, value: SymbolicPolynomial) -> Option<Polynomial> {
        (value.arena == self.number).then(|| self.values.get(value.at).cloned())?
    }

    /// The polynomials of these values.
    ///
    /// # Errors
    /// [`ELSEWHERE`] where one is of another or of no arena.
    pub fn polynomials(&self, values: &[SymbolicPolynomial]) -> Result<Vec<Polynomial>, &'static str> {
        values.iter().map(|value| self.value(*value)).collect::<Option<_>>().ok_or(ELSEWHERE)
    }

    /// The variables that p depends on, through the arguments of functions too. Of others it does not depend, wherever
    /// the atoms are defined.
    pub(crate) fn variables(&self, p: &Polynomial) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for atom in p.iter().flat_map(|(monomial, _)| monomial.iter().map(|(atom, _)| *atom)) {
            match &self.atoms[atom] {
                Atom::Variable(k) => {
                    found.insert(*k);
                }
                // An argument holds older atoms only, so that this ends.
                Atom::Of(_, argument) => found.append(&mut self.variables(&argument.polynomial)),
            }
        }
        found
    }

    /// Whether every root of the arena that depends on one of these variables is of what is above 0 at these values of
    /// the atoms, so that it has a derivative.
    pub(crate) fn roots_are_smooth(&self, variables: impl Fn(usize) -> bool, atoms: &[Interval]) -> bool {
        self.atoms.iter().all(|atom| match atom {
            Atom::Of(Function::Sqrt, argument) if self.variables(&argument.polynomial).into_iter().any(&variables) => {
                evaluate(&argument.polynomial, atoms).is_some_and(|argument| argument.lo() > 0.0)
            }
            _ => true,
        })
    }

    pub(super) fn atom(&mut self, atom: Atom) -> Polynomial {
        let at = self.atoms.iter().position(|other| *other == atom).unwrap_or_else(|| {
            self.atoms.push(atom);
            self.atoms.len() - 1
        });
        vec![(vec![(at, 1)], Interval::ONE)]
    }

    pub(super) fn apply(&mut self, function: Function, argument: Argument) -> Polynomial {
        match number(&argument.polynomial) {
            Some(x) => match function.at(&x) {
                Some(value) => constant(value),
                None => self.fail("a function outside its domain"),
            },
            None if function == Function::Recip && argument.polynomial.len() == 1 => {
                // Kept as an atom too, so that a box on which it is not defined has no result.
                let inverse = argument.polynomial[0].clone();
                self.atom(Atom::Of(function, argument));
                match reciprocal(&inverse.1) {
                    Some(coefficient) => {
                        vec![(inverse.0.into_iter().map(|(atom, power)| (atom, -power)).collect(), coefficient)]
                    }
                    None => self.fail("a division by a constant that may be 0"),
                }
            }
            None => self.function(function, argument),
        }
    }

    /// The atom of a function. That of `-p` is the one of p where the function is odd or even.
    fn function(&mut self, function: Function, argument: Argument) -> Polynomial {
        let parity = function.parity();
        let negative = argument.polynomial.first().is_some_and(|(_, leading)| leading.hi() < 0.0);
        if parity == 0 || !negative || !is_exact(&argument.polynomial) {
            return self.atom(Atom::Of(function, argument));
        }
        let polynomial = sum(&Vec::new(), &argument.polynomial, true);
        let own = self.atom(Atom::Of(function, Argument { polynomial, value: None }));
        sum(&Vec::new(), &own, parity < 0)
    }

    pub(crate) fn product(&mut self, p: &Polynomial, q: &Polynomial) -> Polynomial {
        if p.len() * q.len() > 10 * MONOMIALS {
            return self.fail("too many terms");
        }
        let mut terms: Polynomial = Vec::with_capacity(p.len() * q.len());
        for (left, x) in p {
            for (right, y) in q {
                let mut monomial = left.clone();
                for &(atom, power) in right {
                    match monomial.binary_search_by_key(&atom, |(atom, _)| *atom) {
                        Ok(at) => monomial[at].1 += power,
                        Err(at) => monomial.insert(at, (atom, power)),
                    }
                }
                monomial.retain(|(_, power)| *power != 0);
                if monomial.iter().any(|(_, power)| power.unsigned_abs() > POWER) {
                    return self.fail("a high power");
                }
                terms.push((monomial, times(x, y)));
            }
        }
        terms.sort_by(|x, y| x.0.cmp(&y.0));
        let mut result: Polynomial = Vec::with_capacity(terms.len());
        for (monomial, coefficient) in terms {
            match result.last_mut() {
                Some(last) if last.0 == monomial => last.1 = last.1.add(&coefficient),
                _ => result.push((monomial, coefficient)),
            }
        }
        result.retain(|(_, coefficient)| !coefficient.is_zero());
        if result.len() > MONOMIALS { self.fail("too many terms") } else { result }
    }

    /// The derivative of p along the field whose component at variable k is `field(k)`.
    pub fn along(&mut self, p: &Polynomial, field: &[Polynomial]) -> Polynomial {
        let mut result = Vec::new();
        let mut atoms: Vec<usize> = p.iter().flat_map(|(monomial, _)| monomial.iter().map(|(atom, _)| *atom)).collect();
        atoms.sort_unstable();
        atoms.dedup();
        for atom in atoms {
            if self.failed.is_some() {
                break;
            }
            let rate = match self.atoms[atom].clone() {
                Atom::Variable(k) => field.get(k).cloned().unwrap_or_default(),
                Atom::Of(function, argument) => {
                    // An argument holds older atoms only, so that this ends.
                    let inner = self.along(&argument.polynomial, field);
                    let outer = self.slope(function, atom, &argument);
                    self.product(&outer, &inner)
                }
            };
            let partial = self.product(&partial(p, atom), &rate);
            result = sum(&result, &partial, false);
        }
        result
    }

    /// The derivative of a function, of which `atom` is the value at `argument`.
    fn slope(&mut self, function: Function, atom: usize, argument: &Argument) -> Polynomial {
        let one = constant(Interval::ONE);
        let own = |power| vec![(vec![(atom, power)], Interval::ONE)];
        let minus = |p: &Polynomial| sum(&Vec::new(), p, true);
        match function {
            Function::Recip => minus(&own(2)),
            Function::Exp => own(1),
            Function::Ln => self.apply(Function::Recip, argument.clone()),
            Function::Sin => self.apply(Function::Cos, argument.clone()),
            Function::Cos => minus(&self.apply(Function::Sin, argument.clone())),
            Function::Sqrt => {
                let polynomial = sum(&own(1), &own(1), false);
                self.apply(Function::Recip, Argument { polynomial, value: None })
            }
            Function::Atan => {
                let square = self.product(&argument.polynomial, &argument.polynomial);
                self.apply(Function::Recip, Argument { polynomial: sum(&one, &square, false), value: None })
            }
            Function::Tanh => sum(&one, &own(2), true),
        }
    }

    /// Whether something had no polynomial.
    pub(crate) fn failed(&self) -> Option<&'static str> {
        self.failed
    }

    /// The atoms over a box of variables, or None where one of them is not defined on the whole box.
    pub fn atoms_over(&self, variables: &[Interval]) -> Option<Vec<Interval>> {
        let mut values = Vec::with_capacity(self.atoms.len());
        for atom in &self.atoms {
            let value = match atom {
                Atom::Variable(k) => *variables.get(*k)?,
                Atom::Of(function, argument) => function.at(&evaluate(&argument.polynomial, &values)?)?,
            };
            values.push(value);
        }
        Some(values)
    }
}
