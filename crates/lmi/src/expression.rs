//! Affine matrix expressions in the usual notation: `a.transpose() * &p + &p * &a - &y * &c`.
//!
//! An expression is stored as its syntax tree, with the user's constants. It is not expanded in floating point: the
//! same tree is evaluated in binary64 for the solver and in exact or interval arithmetic for the proof, so that the
//! proof concerns the expression as written.
//!
//! Incompatible shapes and constants that are not finite are stored in the expression and reported, with the name of
//! the constraint, when the problem is solved.

use std::ops::{Add, Mul, Neg, Sub};
use std::sync::Arc;

use nalgebra::DMatrix;

use crate::error::Fault;
use crate::variable::{Structure, Variable};

/// A node of an expression. Shapes were checked when it was built.
#[derive(Debug)]
pub(crate) enum Node {
    /// A matrix of numbers.
    Constant(DMatrix<f64>),
    /// An unknown matrix.
    Variable(Variable),
    /// Sum of two of equal shape.
    Sum(Expression, Expression),
    /// Minus one.
    Negation(Expression),
    /// A number times one.
    Multiple(f64, Expression),
    /// A constant times one.
    LeftProduct(DMatrix<f64>, Expression),
    /// One times a constant.
    RightProduct(Expression, DMatrix<f64>),
    /// A 1x1 expression times a constant of any shape.
    Scaling(Expression, DMatrix<f64>),
    /// Its transpose.
    Transpose(Expression),
    /// The sum of its diagonal.
    Trace(Expression),
    /// Blocks, row by row; heights agree within a row and the widths of the rows agree.
    Blocks(Vec<Vec<Expression>>),
}

/// A matrix that depends affinely on the unknowns. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Expression {
    node: Arc<Node>,
    rows: usize,
    columns: usize,
    fault: Option<Fault>,
}

impl Expression {
    fn new(node: Node, rows: usize, columns: usize, fault: Option<Fault>) -> Self {
        Self { node: Arc::new(node), rows, columns, fault }
    }

    /// Rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// Its error, if any.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    pub(crate) fn node(&self) -> &Node {
        &self.node
    }

    /// The constant matrix `m`.
    pub fn constant(m: DMatrix<f64>) -> Self {
        let fault = first_not_finite(&m);
        let (rows, columns) = m.shape();
        Self::new(Node::Constant(m), rows, columns, fault)
    }

    /// The transpose.
    #[must_use]
    pub fn transpose(&self) -> Self {
        Self::new(Node::Transpose(self.clone()), self.columns, self.rows, self.fault)
    }

    /// The sum of the diagonal, a 1x1 expression. The matrix must be square.
    #[must_use]
    pub fn trace(&self) -> Self {
        let square = self.require_square("trace");
        Self::new(Node::Trace(self.clone()), 1, 1, self.fault.or(square))
    }

    /// `self + self'`, twice the symmetric part, which the literature writes He(X). The matrix must be square.
    #[must_use]
    pub fn he(&self) -> Self {
        let mut sum = plus(self.clone(), self.transpose());
        sum.fault = self.fault.or_else(|| self.require_square("He")).or(sum.fault);
        sum
    }

    /// Assembles blocks, given row by row. The blocks of a row have the same height, and all rows the same width.
    ///
    /// The macro [`block!`](crate::block) reads better.
    pub fn blocks(rows: Vec<Vec<Expression>>) -> Self {
        let mut fault = None;
        let (mut height, mut width) = (0, 0);
        for (index, row) in rows.iter().enumerate() {
            let row_height = row.first().map_or(0, |e| e.rows);
            let mut row_width = 0;
            for e in row {
                if e.rows != row_height {
                    let (left, right) = ((row_height, row_width), e.shape());
                    fault = fault.or(Some(Fault::ShapeMismatch { operation: "row of blocks", left, right }));
                }
                row_width += e.columns;
                fault = fault.or(e.fault);
            }
            if index == 0 {
                width = row_width;
            } else if row_width != width {
                let (left, right) = ((height, width), (row_height, row_width));
                fault = fault.or(Some(Fault::ShapeMismatch { operation: "column of blocks", left, right }));
            }
            height += row_height;
        }
        Self::new(Node::Blocks(rows), height, width, fault)
    }

    fn require_square(&self, operation: &'static str) -> Option<Fault> {
        (self.rows != self.columns).then_some(Fault::NotSquare { operation, rows: self.rows, columns: self.columns })
    }
}

/// The first entry that is NaN or infinite.
pub(crate) fn first_not_finite(m: &DMatrix<f64>) -> Option<Fault> {
    let rows = m.nrows();
    m.iter().enumerate().find(|(_, value)| !value.is_finite()).map(|(k, &value)| Fault::NotFinite {
        row: k % rows,
        column: k / rows,
        value,
    })
}

fn plus(left: Expression, right: Expression) -> Expression {
    let mismatch = (left.shape() != right.shape()).then_some(Fault::ShapeMismatch {
        operation: "sum",
        left: left.shape(),
        right: right.shape(),
    });
    let (rows, columns) = left.shape();
    let fault = left.fault.or(right.fault).or(mismatch);
    Expression::new(Node::Sum(left, right), rows, columns, fault)
}

pub(crate) fn minus(left: Expression, right: Expression) -> Expression {
    // A mismatch is a difference to the user, not a sum.
    let mismatch = (left.shape() != right.shape()).then_some(Fault::ShapeMismatch {
        operation: "difference",
        left: left.shape(),
        right: right.shape(),
    });
    let fault = left.fault.or(right.fault).or(mismatch);
    let mut difference = plus(left, negative(right));
    difference.fault = fault;
    difference
}

fn negative(e: Expression) -> Expression {
    let ((rows, columns), fault) = (e.shape(), e.fault);
    Expression::new(Node::Negation(e), rows, columns, fault)
}

fn multiple(factor: f64, e: Expression) -> Expression {
    let (rows, columns) = e.shape();
    let bad = (!factor.is_finite()).then_some(Fault::NotFinite { row: 0, column: 0, value: factor });
    let fault = e.fault.or(bad);
    Expression::new(Node::Multiple(factor, e), rows, columns, fault)
}

fn left_product(m: DMatrix<f64>, e: Expression) -> Expression {
    if e.shape() == (1, 1) && m.ncols() != 1 {
        return scaling(e, m);
    }
    let mismatch = (m.ncols() != e.rows).then_some(Fault::ShapeMismatch {
        operation: "product",
        left: m.shape(),
        right: e.shape(),
    });
    let fault = first_not_finite(&m).or(e.fault).or(mismatch);
    let (rows, columns) = (m.nrows(), e.columns);
    Expression::new(Node::LeftProduct(m, e), rows, columns, fault)
}

fn right_product(e: Expression, m: DMatrix<f64>) -> Expression {
    if e.shape() == (1, 1) && m.nrows() != 1 {
        return scaling(e, m);
    }
    let mismatch = (e.columns != m.nrows()).then_some(Fault::ShapeMismatch {
        operation: "product",
        left: e.shape(),
        right: m.shape(),
    });
    let fault = e.fault.or_else(|| first_not_finite(&m)).or(mismatch);
    let (rows, columns) = (e.rows, m.ncols());
    Expression::new(Node::RightProduct(e, m), rows, columns, fault)
}

fn scaling(e: Expression, m: DMatrix<f64>) -> Expression {
    let fault = e.fault.or_else(|| first_not_finite(&m));
    let (rows, columns) = m.shape();
    Expression::new(Node::Scaling(e, m), rows, columns, fault)
}

impl From<&Variable> for Expression {
    fn from(v: &Variable) -> Self {
        let (rows, columns) = v.shape();
        Self::new(Node::Variable(v.clone()), rows, columns, None)
    }
}

impl From<Variable> for Expression {
    fn from(v: Variable) -> Self {
        Self::from(&v)
    }
}

impl From<&Expression> for Expression {
    fn from(e: &Expression) -> Self {
        e.clone()
    }
}

impl From<DMatrix<f64>> for Expression {
    fn from(m: DMatrix<f64>) -> Self {
        Self::constant(m)
    }
}

impl From<&DMatrix<f64>> for Expression {
    fn from(m: &DMatrix<f64>) -> Self {
        Self::constant(m.clone())
    }
}

impl Variable {
    /// The transpose, as an expression.
    pub fn transpose(&self) -> Expression {
        Expression::from(self).transpose()
    }

    /// The sum of the diagonal, as a 1x1 expression.
    pub fn trace(&self) -> Expression {
        Expression::from(self).trace()
    }

    /// The identity of order `n` times this unknown, which must be [`Structure::Scalar`]; `gamma.identity(n)` is gamma
    /// I.
    pub fn identity(&self, n: usize) -> Expression {
        let e = Expression::from(self);
        if self.structure() == Structure::Scalar {
            scaling(e, DMatrix::identity(n, n))
        } else {
            left_product(DMatrix::identity(n, n), e)
        }
    }
}

/// He(X) = X + X', twice the symmetric part: `he(&p * &a)` is `PA + A'P` when P is symmetric.
pub fn he(e: impl Into<Expression>) -> Expression {
    e.into().he()
}

/// The trace of a square expression, a 1x1 expression.
pub fn trace(e: impl Into<Expression>) -> Expression {
    e.into().trace()
}

/// The constant zero matrix, for [`block!`](crate::block).
pub fn zeros(rows: usize, columns: usize) -> Expression {
    Expression::constant(DMatrix::zeros(rows, columns))
}

/// The constant identity, for [`block!`](crate::block).
pub fn identity(n: usize) -> Expression {
    Expression::constant(DMatrix::identity(n, n))
}

/// Assembles a matrix from blocks: `block![[&p, &p * &b], [b.transpose() * &p, identity(m)]]`.
///
/// A block is an unknown, an expression or a constant matrix.
///
/// ```
/// use luenberger_lmi::{Problem, block, identity};
/// let mut lmi = Problem::new();
/// let x = lmi.rectangular("X", 2, 3);
/// let ball = block![[identity(2), &x], [x.transpose(), identity(3)]];
/// assert_eq!(ball.shape(), (5, 5));
/// ```
#[macro_export]
macro_rules! block {
    ($([$($entry:expr),+ $(,)?]),+ $(,)?) => {
        $crate::Expression::blocks(vec![$(vec![$($crate::Expression::from($entry)),+]),+])
    };
}

/// Sums and differences: every pair of types in which at least one is defined here.
macro_rules! sums {
    ($($left:ty, $right:ty;)*) => {$(
        impl Add<$right> for $left {
            type Output = Expression;
            fn add(self, right: $right) -> Expression {
                plus(self.into(), right.into())
            }
        }
        impl Sub<$right> for $left {
            type Output = Expression;
            fn sub(self, right: $right) -> Expression {
                minus(self.into(), right.into())
            }
        }
    )*};
}

sums! {
    Expression, Expression; Expression, &Expression; &Expression, Expression; &Expression, &Expression;
    Expression, &Variable; &Variable, Expression; &Expression, &Variable; &Variable, &Expression; &Variable, &Variable;
    Expression, DMatrix<f64>; Expression, &DMatrix<f64>; DMatrix<f64>, Expression; &DMatrix<f64>, Expression;
    &Expression, DMatrix<f64>; &Expression, &DMatrix<f64>; DMatrix<f64>, &Expression; &DMatrix<f64>, &Expression;
    &Variable, DMatrix<f64>; &Variable, &DMatrix<f64>; DMatrix<f64>, &Variable; &DMatrix<f64>, &Variable;
}

/// Products with a constant matrix or a number, and the sign.
macro_rules! products {
    ($($operand:ty;)*) => {$(
        impl Mul<$operand> for f64 {
            type Output = Expression;
            fn mul(self, right: $operand) -> Expression {
                multiple(self, right.into())
            }
        }
        impl Mul<f64> for $operand {
            type Output = Expression;
            fn mul(self, right: f64) -> Expression {
                multiple(right, self.into())
            }
        }
        impl Mul<$operand> for DMatrix<f64> {
            type Output = Expression;
            fn mul(self, right: $operand) -> Expression {
                left_product(self, right.into())
            }
        }
        impl Mul<$operand> for &DMatrix<f64> {
            type Output = Expression;
            fn mul(self, right: $operand) -> Expression {
                left_product(self.clone(), right.into())
            }
        }
        impl Mul<DMatrix<f64>> for $operand {
            type Output = Expression;
            fn mul(self, right: DMatrix<f64>) -> Expression {
                right_product(self.into(), right)
            }
        }
        impl Mul<&DMatrix<f64>> for $operand {
            type Output = Expression;
            fn mul(self, right: &DMatrix<f64>) -> Expression {
                right_product(self.into(), right.clone())
            }
        }
        impl Neg for $operand {
            type Output = Expression;
            fn neg(self) -> Expression {
                negative(self.into())
            }
        }
    )*};
}

products! { Expression; &Expression; &Variable; }
