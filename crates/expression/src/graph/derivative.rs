//! Partial derivatives of the nodes of a graph.
//!
//! At a kink the derivative is that of the side whose value is taken; of a jump, and of a constant, it is none.

use super::{Graph, Id, Node};
use crate::function::{Binary, Comparison, Unary};

impl Graph {
    /// The derivatives of some nodes by n states, node by node.
    pub(crate) fn jacobian(&mut self, of: &[Id], n: usize) -> Vec<Id> {
        let columns: Vec<Vec<Id>> = (0..n).map(|j| self.derivatives(of, j)).collect();
        (0..of.len()).flat_map(|i| columns.iter().map(move |column| column[i])).collect()
    }

    /// The derivatives of some nodes by a state.
    fn derivatives(&mut self, of: &[Id], by: usize) -> Vec<Id> {
        let last = of.iter().copied().max().map_or(0, |last| last as usize + 1);
        let needed = self.needed(of);
        // None where the derivative vanishes identically.
        let mut slopes: Vec<Option<Id>> = vec![None; last];
        for id in 0..last {
            if needed[id] {
                slopes[id] = self.slope(id as Id, by, &slopes);
            }
        }
        let zero = self.constant(0.0);
        of.iter().map(|id| slopes[*id as usize].unwrap_or(zero)).collect()
    }

    /// Whether each node is needed for one of these.
    pub(super) fn needed(&self, of: &[Id]) -> Vec<bool> {
        let mut needed = vec![false; self.nodes.len()];
        for id in of {
            needed[*id as usize] = true;
        }
        for id in (0..self.nodes.len()).rev() {
            if needed[id] {
                for operand in self.nodes[id].operands() {
                    needed[operand as usize] = true;
                }
            }
        }
        needed
    }

    fn slope(&mut self, id: Id, by: usize, slopes: &[Option<Id>]) -> Option<Id> {
        let of = |x: Id| slopes[x as usize];
        match self.node(id) {
            Node::State(k) if k as usize == by => Some(self.constant(1.0)),
            Node::Unary(unary, x) => {
                let dx = of(x)?;
                self.slope_of(unary, id, x, dx)
            }
            Node::Binary(binary, x, y) => self.slope_of_two(binary, id, (x, of(x)), (y, of(y))),
            Node::Table(table, x) => {
                let dx = of(x)?;
                let slope = self.push(Node::Slope(table, x));
                Some(self.multiply(slope, dx))
            }
            Node::Select(condition, x, y) => self.chosen(condition, of(x), of(y)),
            _ => None,
        }
    }

    /// The derivative of a choice.
    fn chosen(&mut self, condition: Id, dx: Option<Id>, dy: Option<Id>) -> Option<Id> {
        if dx.is_none() && dy.is_none() {
            return None;
        }
        let zero = self.constant(0.0);
        Some(self.select(condition, dx.unwrap_or(zero), dy.unwrap_or(zero)))
    }

    fn slope_of(&mut self, unary: Unary, value: Id, x: Id, dx: Id) -> Option<Id> {
        let one = self.constant(1.0);
        let square = self.multiply(x, x);
        Some(match unary {
            Unary::Negate => self.negate(dx),
            Unary::Reciprocal => {
                let square = self.multiply(value, value);
                let product = self.multiply(square, dx);
                self.negate(product)
            }
            Unary::Abs => {
                let zero = self.constant(0.0);
                let below = self.compare(Comparison::Less, x, zero);
                let other = self.negate(dx);
                self.select(below, other, dx)
            }
            Unary::Sign | Unary::Step | Unary::Floor => return None,
            Unary::Sqrt => {
                let twice = self.add(value, value);
                self.divide(dx, twice)
            }
            Unary::Exp => self.multiply(value, dx),
            Unary::Ln => self.divide(dx, x),
            Unary::Log10 => {
                let base = self.constant(core::f64::consts::LN_10);
                let scaled = self.multiply(base, x);
                self.divide(dx, scaled)
            }
            Unary::Sin => {
                let cosine = self.unary(Unary::Cos, x);
                self.multiply(cosine, dx)
            }
            Unary::Cos => {
                let sine = self.unary(Unary::Sin, x);
                let product = self.multiply(sine, dx);
                self.negate(product)
            }
            Unary::Tan => {
                let square = self.multiply(value, value);
                let factor = self.add(one, square);
                self.multiply(factor, dx)
            }
            Unary::Asin | Unary::Acos => {
                // 1 - x^2 as a product, which keeps its digits near 1.
                let (less, more) = (self.subtract(one, x), self.add(one, x));
                let rest = self.multiply(less, more);
                let root = self.unary(Unary::Sqrt, rest);
                let slope = self.divide(dx, root);
                if unary == Unary::Asin { slope } else { self.negate(slope) }
            }
            Unary::Atan => {
                let sum = self.add(one, square);
                self.divide(dx, sum)
            }
            Unary::Sinh => {
                let cosine = self.unary(Unary::Cosh, x);
                self.multiply(cosine, dx)
            }
            Unary::Cosh => {
                let sine = self.unary(Unary::Sinh, x);
                self.multiply(sine, dx)
            }
            Unary::Tanh => {
                let (less, more) = (self.subtract(one, value), self.add(one, value));
                let factor = self.multiply(less, more);
                self.multiply(factor, dx)
            }
            Unary::Asinh => {
                let sum = self.add(one, square);
                let root = self.unary(Unary::Sqrt, sum);
                self.divide(dx, root)
            }
            Unary::Acosh => {
                let (less, more) = (self.subtract(x, one), self.add(x, one));
                let rest = self.multiply(less, more);
                let root = self.unary(Unary::Sqrt, rest);
                self.divide(dx, root)
            }
            Unary::Atanh => {
                let (less, more) = (self.subtract(one, x), self.add(one, x));
                let rest = self.multiply(less, more);
                self.divide(dx, rest)
            }
        })
    }

    fn slope_of_two(
        &mut self,
        binary: Binary,
        value: Id,
        (x, dx): (Id, Option<Id>),
        (y, dy): (Id, Option<Id>),
    ) -> Option<Id> {
        if dx.is_none() && dy.is_none() {
            return None;
        }
        match binary {
            Binary::Add => self.terms(dx, dy),
            Binary::Subtract => {
                let dy = dy.map(|dy| self.negate(dy));
                self.terms(dx, dy)
            }
            Binary::Multiply => {
                let first = dx.map(|dx| self.multiply(dx, y));
                let second = dy.map(|dy| self.multiply(x, dy));
                self.terms(first, second)
            }
            Binary::Divide => {
                // (x/y)' = (x' - (x/y) y')/y.
                let Some(dy) = dy else { return dx.map(|dx| self.divide(dx, y)) };
                let drag = self.multiply(value, dy);
                let numerator = match dx {
                    Some(dx) => self.subtract(dx, drag),
                    None => self.negate(drag),
                };
                Some(self.divide(numerator, y))
            }
            Binary::Power => self.slope_of_power(value, (x, dx), (y, dy)),
            Binary::Atan2 => {
                // atan2(x, y): (y x' - x y')/(x^2 + y^2).
                let first = dx.map(|dx| self.multiply(y, dx));
                let second = dy.map(|dy| self.multiply(x, dy));
                let second = second.map(|second| self.negate(second));
                let numerator = self.terms(first, second)?;
                let (squares, other) = (self.multiply(x, x), self.multiply(y, y));
                let sum = self.add(squares, other);
                Some(self.divide(numerator, sum))
            }
            Binary::Min | Binary::Max => {
                let second = if binary == Binary::Max { Comparison::Greater } else { Comparison::Less };
                let taken = self.compare(second, y, x);
                self.chosen(taken, dy, dx)
            }
            // Of x - y floor(x/y), and of x + y floor(1/2 - x/y).
            Binary::Modulo | Binary::Wrap => {
                let quotient = self.divide(x, y);
                let turns = if binary == Binary::Wrap {
                    let half = self.constant(0.5);
                    let rest = self.subtract(half, quotient);
                    self.unary(Unary::Floor, rest)
                } else {
                    let turns = self.unary(Unary::Floor, quotient);
                    self.negate(turns)
                };
                let second = dy.map(|dy| self.multiply(turns, dy));
                self.terms(dx, second)
            }
            Binary::LnPlusExp => self.slope_of_ln_plus_exp((x, dx), (y, dy)),
            Binary::LnExpPlus => self.slope_of_ln_plus_exp((y, dy), (x, dx)),
        }
    }

    fn terms(&mut self, first: Option<Id>, second: Option<Id>) -> Option<Id> {
        match (first, second) {
            (Some(first), Some(second)) => Some(self.add(first, second)),
            (first, second) => first.or(second),
        }
    }

    /// `x^n`: `n x^(n-1) x' + x^n ln(x) n'`, and 0 at x = 0 with n > 1.
    fn slope_of_power(&mut self, value: Id, (x, dx): (Id, Option<Id>), (n, dn): (Id, Option<Id>)) -> Option<Id> {
        let (zero, one) = (self.constant(0.0), self.constant(1.0));
        let first = dx.map(|dx| {
            let less = self.subtract(n, one);
            let power = self.raised(x, less);
            let factor = self.multiply(n, power);
            self.multiply(factor, dx)
        });
        let second = dn.map(|dn| {
            let logarithm = self.unary(Unary::Ln, x);
            let factor = self.multiply(value, logarithm);
            self.multiply(factor, dn)
        });
        let sum = self.terms(first, second)?;
        let at_zero = self.compare(Comparison::Equal, x, zero);
        let smooth = self.compare(Comparison::Greater, n, one);
        let flat = self.and(at_zero, smooth);
        Some(self.select(flat, zero, sum))
    }

    /// `ln(a + exp(z))`: for z < 1 `(a' + e z')/(a + e)` with `e = exp(z)`, else `(a' e + z')/(1 + a e)` with
    /// `e = exp(-z)`.
    fn slope_of_ln_plus_exp(&mut self, (a, da): (Id, Option<Id>), (z, dz): (Id, Option<Id>)) -> Option<Id> {
        let one = self.constant(1.0);
        let small = self.compare(Comparison::Less, z, one);
        let other = self.negate(z);
        let exponent = self.select(small, z, other);
        let e = self.unary(Unary::Exp, exponent);
        let (shrunk, grown) = (da.map(|da| self.multiply(da, e)), dz.map(|dz| self.multiply(e, dz)));
        let (near, far) = (self.terms(da, grown)?, self.terms(shrunk, dz)?);
        let share = self.multiply(a, e);
        let (below, above) = (self.add(a, e), self.add(one, share));
        let (numerator, denominator) = (self.select(small, near, far), self.select(small, below, above));
        Some(self.divide(numerator, denominator))
    }
}
