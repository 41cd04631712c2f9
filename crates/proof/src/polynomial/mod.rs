//! Functions of several variables as polynomials in atoms, over the rationals, with bounds over a box.
//!
//! An atom is a variable, an elementary function of a polynomial, or the reciprocal of one: `x1`, `sin(x1 + x2)`,
//! `1/(x1^2 + 1)`. Sums and products of such functions are polynomials again. Equal terms on the two sides of an
//! equation therefore cancel exactly before anything is enclosed, and an identity gives the polynomial 0. Products are
//! reduced by the relations `cos^2 = 1 - sin^2`, `sqrt(p)^2 = p` and `(1/p) p = 1`.
//!
//! The module `bound` computes bounds: natural interval extension and mean-value form on the parts of a bisection, the
//! part with the largest bound first.

mod bound;
mod rational;
mod text;

use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap};

use crate::interval::Interval;

pub(crate) use bound::Extremum;
use bound::PARTS;
pub(crate) use rational::Rational;
pub use text::{DEEPEST_EXPRESSION, ExpressionError, LONGEST_EXPRESSION};
pub(crate) use text::{Scope, Tree};

/// Maximum number of terms computed for all polynomials of one theorem; terms with long coefficients count more.
const WORK: usize = 1 << 18;

/// Maximum number of terms of one polynomial.
const TERMS: usize = 1 << 12;

/// Maximum number of terms evaluated for all bounds of one theorem.
const EVALUATIONS: usize = 1 << 28;

/// Maximum number of atoms of one theorem, variables included.
const ATOMS: usize = 512;

/// Maximum length of a coefficient, in bits.
const BITS: usize = 1 << 14;

/// Maximum degree of one monomial in its atoms.
const DEGREE: u32 = 512;

/// Why a polynomial cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoPolynomial {
    /// More terms, atoms, bits or powers than the limits allow.
    TooLarge,
    /// A denominator is identically 0.
    DivisionByZero,
}

/// An elementary function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sin,
    Cos,
    Exp,
    Ln,
    Sqrt,
    Tanh,
    Atan,
}

impl Function {
    pub(crate) const NAMES: [(&'static str, Self); 7] = [
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("sqrt", Self::Sqrt),
        ("tanh", Self::Tanh),
        ("atan", Self::Atan),
    ];

    /// Values over an interval; `None` unless it lies in the domain. For the square root the domain is open, because
    /// the derivative must exist.
    fn over(self, x: &Interval) -> Option<Interval> {
        match self {
            Self::Sin => Some(x.sin()),
            Self::Cos => Some(x.cos()),
            Self::Exp => Some(x.exp()),
            Self::Ln => x.ln(),
            Self::Sqrt => (x.lo() > 0.0).then(|| x.sqrt()).flatten(),
            Self::Tanh => Some(x.tanh()),
            Self::Atan => Some(x.atan()),
        }
    }
}

/// A product of atoms: pairs of atom index and power.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
struct Monomial(Vec<(usize, u32)>);

impl Monomial {
    fn degree(&self) -> u32 {
        self.0.iter().fold(0, |sum, (_, power)| sum.saturating_add(*power))
    }

    fn times(&self, other: &Self) -> Self {
        let mut factors = Vec::with_capacity(self.0.len() + other.0.len());
        let (mut left, mut right) = (self.0.iter().peekable(), other.0.iter().peekable());
        while let (Some(&&(a, p)), Some(&&(b, q))) = (left.peek(), right.peek()) {
            match a.cmp(&b) {
                Ordering::Less => factors.extend(left.next()),
                Ordering::Greater => factors.extend(right.next()),
                Ordering::Equal => {
                    factors.push((a, p.saturating_add(q)));
                    left.next();
                    right.next();
                }
            }
        }
        factors.extend(left);
        factors.extend(right);
        Self(factors)
    }

    /// `self / other`, if the quotient is a monomial.
    fn over(&self, other: &Self) -> Option<Self> {
        let mut factors = self.0.clone();
        for (atom, power) in &other.0 {
            let found = factors.iter_mut().find(|(a, _)| a == atom)?;
            found.1 = found.1.checked_sub(*power)?;
        }
        factors.retain(|(_, power)| *power > 0);
        Some(Self(factors))
    }

    /// Graded order: by degree, then by the powers of the atoms from the last one on.
    fn graded(&self, other: &Self) -> Ordering {
        self.degree().cmp(&other.degree()).then_with(|| self.0.iter().rev().cmp(other.0.iter().rev()))
    }
}

/// A polynomial in the atoms of an [`Arena`].
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub(crate) struct Polynomial {
    terms: BTreeMap<Monomial, Rational>,
}

impl Polynomial {
    pub(crate) fn zero() -> Self {
        Self::default()
    }

    pub(crate) fn constant(x: Rational) -> Self {
        Self::term(Monomial::default(), x)
    }

    fn term(monomial: Monomial, x: Rational) -> Self {
        let mut terms = BTreeMap::new();
        if !x.is_zero() {
            terms.insert(monomial, x);
        }
        Self { terms }
    }

    /// The atom number k.
    fn atom(k: usize) -> Self {
        Self::term(Monomial(vec![(k, 1)]), Rational::integer(1))
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    fn add_term(&mut self, monomial: Monomial, x: &Rational) {
        if x.is_zero() {
            return;
        }
        let sum = self.terms.get(&monomial).map_or_else(|| x.clone(), |y| y.plus(x));
        if sum.is_zero() {
            self.terms.remove(&monomial);
        } else {
            self.terms.insert(monomial, sum);
        }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        for (monomial, x) in &other.terms {
            sum.add_term(monomial.clone(), x);
        }
        sum
    }

    pub(crate) fn scaled(&self, x: &Rational) -> Self {
        if x.is_zero() {
            return Self::zero();
        }
        Self { terms: self.terms.iter().map(|(monomial, y)| (monomial.clone(), y.times(x))).collect() }
    }

    pub(crate) fn negative(&self) -> Self {
        Self { terms: self.terms.iter().map(|(monomial, x)| (monomial.clone(), x.negative())).collect() }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negative())
    }

    /// The largest term in the graded order.
    fn leading(&self) -> Option<(&Monomial, &Rational)> {
        self.terms.iter().max_by(|a, b| a.0.graded(b.0))
    }
}

/// Definition of an atom. Its polynomials contain atoms of smaller index only.
#[derive(Clone, Debug, PartialEq)]
enum Atom {
    Variable,
    Function(Function, Polynomial),
    Reciprocal(Polynomial),
}

/// The atoms of a theorem; the first ones are its variables.
#[derive(Clone, Debug)]
pub(crate) struct Arena {
    atoms: Vec<Atom>,
    variables: usize,
    derivatives: HashMap<(usize, usize), Polynomial>,
    work: usize,
    evaluations: usize,
}

type Computed = Result<Polynomial, NoPolynomial>;

impl Arena {
    pub(crate) fn new(variables: usize) -> Self {
        Self { atoms: vec![Atom::Variable; variables], variables, derivatives: HashMap::new(), work: 0, evaluations: 0 }
    }

    pub(crate) fn variables(&self) -> usize {
        self.variables
    }

    pub(crate) fn variable(k: usize) -> Polynomial {
        Polynomial::atom(k)
    }

    /// Counts the terms of a result and checks the limits.
    fn counted(&mut self, p: Polynomial) -> Computed {
        for (monomial, x) in &p.terms {
            self.work += 1 + x.bits() / 256;
            if x.bits() > BITS || monomial.degree() > DEGREE {
                return Err(NoPolynomial::TooLarge);
            }
        }
        if self.work > WORK || p.terms.len() > TERMS { Err(NoPolynomial::TooLarge) } else { Ok(p) }
    }

    fn atom_of(&mut self, atom: Atom) -> Computed {
        let found = self.atoms.iter().position(|other| *other == atom);
        let k = found.unwrap_or(self.atoms.len());
        if found.is_none() {
            if k >= ATOMS {
                return Err(NoPolynomial::TooLarge);
            }
            self.atoms.push(atom);
        }
        Ok(Polynomial::atom(k))
    }

    pub(crate) fn function(&mut self, function: Function, argument: Polynomial) -> Computed {
        if argument.is_zero() {
            match function {
                Function::Sin | Function::Tanh | Function::Atan => return Ok(Polynomial::zero()),
                Function::Cos | Function::Exp => return Ok(Polynomial::constant(Rational::integer(1))),
                Function::Ln | Function::Sqrt => {}
            }
        }
        if function == Function::Cos {
            // The sine is needed for cos^2 = 1 - sin^2.
            self.atom_of(Atom::Function(Function::Sin, argument.clone()))?;
        }
        // ln exp p = p; also exp ln p = p, where ln p stays an atom and so must be defined.
        if let [(Monomial(factors), x)] = argument.terms.iter().collect::<Vec<_>>()[..]
            && let [(atom, 1)] = factors[..]
            && *x == Rational::integer(1)
            && let Some(Atom::Function(inner, p)) = self.atoms.get(atom)
            && matches!((function, inner), (Function::Ln, Function::Exp) | (Function::Exp, Function::Ln))
        {
            return Ok(p.clone());
        }
        self.atom_of(Atom::Function(function, argument))
    }

    /// `1/p`, with p scaled to the leading coefficient 1; for a monomial, the product of the reciprocals of its atoms.
    pub(crate) fn reciprocal(&mut self, p: &Polynomial) -> Computed {
        let Some((leading, x)) = p.leading() else { return Err(NoPolynomial::DivisionByZero) };
        let scale = x.inverse().ok_or(NoPolynomial::DivisionByZero)?;
        if p.terms.len() > 1 {
            let atom = self.atom_of(Atom::Reciprocal(p.scaled(&scale)))?;
            return Ok(atom.scaled(&scale));
        }
        let mut product = Polynomial::constant(scale);
        for (atom, power) in leading.0.clone() {
            let factor = match self.atoms.get(atom) {
                // 1/(1/p) = p: both are defined where p != 0, and the reciprocal stays an atom.
                Some(Atom::Reciprocal(p)) => p.clone(),
                _ => self.atom_of(Atom::Reciprocal(Polynomial::atom(atom)))?,
            };
            let factor = self.power(&factor, power)?;
            product = self.product(&product, &factor)?;
        }
        Ok(product)
    }

    pub(crate) fn product(&mut self, p: &Polynomial, q: &Polynomial) -> Computed {
        let mut product = Polynomial::zero();
        for (left, x) in &p.terms {
            self.work += q.terms.len();
            if self.work > WORK {
                return Err(NoPolynomial::TooLarge);
            }
            for (right, y) in &q.terms {
                product.add_term(left.times(right), &x.times(y));
            }
        }
        let reduced = self.reduced(product)?;
        self.counted(reduced)
    }

    pub(crate) fn power(&mut self, p: &Polynomial, n: u32) -> Computed {
        let mut power = Polynomial::constant(Rational::integer(1));
        for _ in 0..n {
            power = self.product(&power, p)?;
        }
        Ok(power)
    }

    /// Reduction of a monomial by a relation of one of its atoms: the remaining factor, and the polynomial that
    /// replaces the rest.
    fn relation(&self, monomial: &Monomial) -> Option<(Monomial, Polynomial)> {
        let one = || Polynomial::constant(Rational::integer(1));
        monomial.0.iter().find_map(|&(k, power)| match self.atoms.get(k)? {
            Atom::Function(Function::Cos, argument) if power >= 2 => {
                let sine = Atom::Function(Function::Sin, argument.clone());
                let sine = self.atoms.iter().position(|atom| *atom == sine)?;
                let square = Polynomial::term(Monomial(vec![(sine, 2)]), Rational::integer(-1));
                Some((Monomial(vec![(k, 2)]), one().plus(&square)))
            }
            Atom::Function(Function::Sqrt, argument) if power >= 2 => Some((Monomial(vec![(k, 2)]), argument.clone())),
            Atom::Reciprocal(p) => {
                let (leading, _) = p.leading()?;
                let factor = leading.times(&Monomial(vec![(k, 1)]));
                monomial.over(&factor)?;
                let mut others = p.negative();
                others.terms.remove(leading);
                let times = |(m, x): (&Monomial, &Rational)| (m.times(&Monomial(vec![(k, 1)])), x.clone());
                Some((factor, one().plus(&Polynomial { terms: others.terms.iter().map(times).collect() })))
            }
            _ => None,
        })
    }

    fn reduced(&mut self, mut p: Polynomial) -> Computed {
        loop {
            let found = p.terms.keys().find_map(|m| self.relation(m).map(|relation| (m.clone(), relation)));
            let Some((monomial, (factor, replacement))) = found else { return Ok(p) };
            let Some((x, rest)) = p.terms.remove(&monomial).zip(monomial.over(&factor)) else { return Ok(p) };
            self.work += p.terms.len() + replacement.terms.len();
            if self.work > WORK {
                return Err(NoPolynomial::TooLarge);
            }
            for (m, y) in &replacement.terms {
                p.add_term(m.times(&rest), &x.times(y));
            }
        }
    }

    /// The partial derivative with respect to a variable.
    pub(crate) fn derivative(&mut self, p: &Polynomial, variable: usize) -> Computed {
        let mut sum = Polynomial::zero();
        let terms: Vec<_> = p.terms.iter().map(|(m, x)| (m.clone(), x.clone())).collect();
        for (monomial, x) in terms {
            for &(atom, power) in &monomial.0 {
                let inner = self.derivative_of_atom(atom, variable)?;
                if inner.is_zero() {
                    continue;
                }
                let Some(rest) = monomial.over(&Monomial(vec![(atom, 1)])) else { continue };
                let outer = Polynomial::term(rest, x.times(&Rational::integer(i64::from(power))));
                for (m, y) in &self.product(&outer, &inner)?.terms {
                    sum.add_term(m.clone(), y);
                }
            }
        }
        self.counted(sum)
    }

    fn derivative_of_atom(&mut self, k: usize, variable: usize) -> Computed {
        if let Some(known) = self.derivatives.get(&(k, variable)) {
            return Ok(known.clone());
        }
        let computed = match self.atoms.get(k).cloned() {
            None | Some(Atom::Variable) => Polynomial::constant(Rational::integer(i64::from(k == variable))),
            Some(Atom::Reciprocal(p)) => {
                let inner = self.derivative(&p, variable)?;
                let square = Polynomial::term(Monomial(vec![(k, 2)]), Rational::integer(-1));
                self.product(&square, &inner)?
            }
            Some(Atom::Function(function, argument)) => {
                let inner = self.derivative(&argument, variable)?;
                if inner.is_zero() { inner } else { self.outer(function, &argument, k, &inner)? }
            }
        };
        self.derivatives.insert((k, variable), computed.clone());
        Ok(computed)
    }

    /// The derivative of atom k, a function of `argument`, times `inner`.
    fn outer(&mut self, function: Function, argument: &Polynomial, k: usize, inner: &Polynomial) -> Computed {
        let one = Polynomial::constant(Rational::integer(1));
        let atom = Polynomial::atom(k);
        let outer = match function {
            Function::Sin => self.function(Function::Cos, argument.clone())?,
            Function::Cos => self.function(Function::Sin, argument.clone())?.negative(),
            Function::Exp => atom,
            Function::Ln => self.reciprocal(argument)?,
            Function::Sqrt => {
                let half = Rational::integer(2).inverse().ok_or(NoPolynomial::DivisionByZero)?;
                self.reciprocal(&atom)?.scaled(&half)
            }
            Function::Tanh => one.minus(&self.product(&atom, &atom)?),
            Function::Atan => {
                let square = self.product(argument, argument)?;
                self.reciprocal(&one.plus(&square))?
            }
        };
        self.product(&outer, inner)
    }

    /// For each variable, whether the polynomial depends on it.
    pub(crate) fn depends_on(&self, p: &Polynomial) -> Vec<bool> {
        let mut used = vec![false; self.atoms.len()];
        let mark = |used: &mut Vec<bool>, p: &Polynomial| {
            for (atom, _) in p.terms.keys().flat_map(|m| &m.0) {
                used[*atom] = true;
            }
        };
        mark(&mut used, p);
        for k in (0..self.atoms.len()).rev() {
            if used[k]
                && let Atom::Function(_, p) | Atom::Reciprocal(p) = &self.atoms[k]
            {
                mark(&mut used, p);
            }
        }
        used.truncate(self.variables);
        used
    }

    /// Number of parts allowed for a bound that evaluates `terms` terms per part, from the remaining evaluations.
    fn allowed_parts(&self, terms: usize) -> usize {
        ((EVALUATIONS - self.evaluations.min(EVALUATIONS)) / (2 * terms.max(1))).min(PARTS)
    }

    /// Conditions under which all atoms so far are defined: each polynomial is positive, or not 0.
    pub(crate) fn domains(&self) -> Vec<(Polynomial, Domain)> {
        let domain = |atom: &Atom| match atom {
            Atom::Function(Function::Ln | Function::Sqrt, p) => Some((p.clone(), Domain::Positive)),
            Atom::Reciprocal(p) => Some((p.clone(), Domain::NotZero)),
            _ => None,
        };
        self.atoms.iter().filter_map(domain).collect()
    }
}

/// A condition on the argument of an atom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    Positive,
    NotZero,
}
