//! The class of Proposition 7: two stable blocks in cascade, and a block that is only integrated.
//!
//! ```text
//! x1' = f1(x1, x2, x3, u) + S(x, u)          row k of S is b(x1, x2, x3, u)' x4
//! x2' = A2 x2 + f2(x1, u)
//! x3' = A3 x3 + f3(x1, x2, u)
//! x4' = f4(x1, x2, x3, u)
//! y   = x1
//! ```
//!
//! A2 and A3 Hurwitz, b persistently exciting, bounded trajectories. The observer copies x2 and x3 and estimates the
//! constant `theta = x4 - xi`:
//!
//! ```text
//! x2hat' = A2 x2hat + f2(y, u),  x3hat' = A3 x3hat + f3(y, x2hat, u),  xi' = f4(y, x2hat, x3hat, u)
//! psi = F[b],  Y = W[y_k] - F[f_1k + b' xi],  x4hat = xi + theta_hat
//! ```
//!
//! [`CascadeMap`] makes a [`KklMap`] with a [`Regression`] of the pieces, so that
//! [`KklPebObserver`](crate::kkl_peb::KklPebObserver) runs it, with the gradient estimator of the paper or with DREM.
//! Its extension is (x2hat, x3hat, xi), Lambda = diag(A2, A3, 0), and its estimate (x2hat, x3hat, x4hat). The
//! hypotheses of Proposition 7 are checked by the design.
//!
//! The paper's proof ends with `theta~' = Gamma psi psi' theta~`; it is `-Gamma psi psi' theta~`.

use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1};

use super::estimator::RegressionSize;
use super::regression::Regression;
use crate::error::ObserverError;
use crate::kkl::{KklMap, KklSize};
use crate::observer::{ObserverDimensions, length};

/// Every shape that the observer of a cascade with blocks of `N2`, `N3` and `N4` states forms can be stored. Never
/// implement it yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of the observer of a cascade of these sizes can be stored",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: CascadeSize<N2, N3, N4, M, P>`"
)]
pub trait CascadeSize<N2: Dim, N3: Dim, N4: Dim, M: Dim, P: Dim>:
    Allocator<N2>
    + Allocator<N3>
    + Allocator<N4>
    + Allocator<N2, N2>
    + Allocator<N3, N3>
    + RegressionSize<U1, N4>
    + KklSize<<Self as CascadeSize<N2, N3, N4, M, P>>::Length, M, P, <Self as CascadeSize<N2, N3, N4, M, P>>::Length>
{
    /// Length of the state (x2hat, x3hat, xi), `n2 + n3 + n4`.
    type Length: Dim;
}

impl<N2, N3, N4, M, P> CascadeSize<N2, N3, N4, M, P> for DefaultAllocator
where
    N2: DimAdd<N3>,
    N3: Dim,
    N4: Dim,
    M: Dim,
    P: Dim,
    DimSum<N2, N3>: DimAdd<N4>,
    DefaultAllocator: Allocator<N2>
        + Allocator<N3>
        + Allocator<N4>
        + Allocator<N2, N2>
        + Allocator<N3, N3>
        + RegressionSize<U1, N4>
        + KklSize<DimSum<DimSum<N2, N3>, N4>, M, P, DimSum<DimSum<N2, N3>, N4>>,
{
    type Length = DimSum<DimSum<N2, N3>, N4>;
}

/// The functions and matrices of a plant of the class. x2 and x3 may be empty.
pub trait Cascade<T: RealField + Copy>
where
    DefaultAllocator: CascadeSize<Self::Second, Self::Third, Self::Fourth, Self::Inputs, Self::Outputs>,
{
    /// Length n2 of x2.
    type Second: Dim;
    /// Length n3 of x3.
    type Third: Dim;
    /// Length n4 of x4.
    type Fourth: Dim;
    /// Number of inputs, m.
    type Inputs: Dim;
    /// Number of outputs, n1.
    type Outputs: Dim;

    /// The lengths n2, n3 and n4 of the blocks x2, x3 and x4. Required where one of the types is [`nalgebra::Dyn`].
    fn blocks(&self) -> [usize; 3] {
        [length::<Self::Second>(), length::<Self::Third>(), length::<Self::Fourth>()]
    }

    /// The numbers m of inputs and n1 of outputs. Required where one of the types is [`nalgebra::Dyn`].
    fn inputs_and_outputs(&self) -> (usize, usize) {
        (length::<Self::Inputs>(), length::<Self::Outputs>())
    }

    /// A2, n2 x n2.
    fn a2(&self) -> OMatrix<T, Self::Second, Self::Second>;

    /// A3, n3 x n3.
    fn a3(&self) -> OMatrix<T, Self::Third, Self::Third>;

    /// The row k of x1', from 0, whose term `b'x4` is used to estimate x4.
    fn k(&self) -> usize;

    /// `f_1k(y, x2, x3, u)`.
    fn f1k(
        &self,
        y: &OVector<T, Self::Outputs>,
        x2: &OVector<T, Self::Second>,
        x3: &OVector<T, Self::Third>,
        u: &OVector<T, Self::Inputs>,
    ) -> T;

    /// `f2(y, u)`.
    fn f2(&self, y: &OVector<T, Self::Outputs>, u: &OVector<T, Self::Inputs>) -> OVector<T, Self::Second>;

    /// `f3(y, x2, u)`.
    fn f3(
        &self,
        y: &OVector<T, Self::Outputs>,
        x2: &OVector<T, Self::Second>,
        u: &OVector<T, Self::Inputs>,
    ) -> OVector<T, Self::Third>;

    /// `f4(y, x2, x3, u)`.
    fn f4(
        &self,
        y: &OVector<T, Self::Outputs>,
        x2: &OVector<T, Self::Second>,
        x3: &OVector<T, Self::Third>,
        u: &OVector<T, Self::Inputs>,
    ) -> OVector<T, Self::Fourth>;

    /// `b(y, x2, x3, u)`, of length n4.
    fn b(
        &self,
        y: &OVector<T, Self::Outputs>,
        x2: &OVector<T, Self::Second>,
        x3: &OVector<T, Self::Third>,
        u: &OVector<T, Self::Inputs>,
    ) -> OVector<T, Self::Fourth>;
}

/// The maps of the [KKL+PEB]O of a cascade; see the [module](self).
///
/// The field is private, because the constructor checks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CascadeMap<C> {
    cascade: C,
}

impl<C> CascadeMap<C> {
    /// The maps for `cascade`.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for the shapes and entries of A2 and A3; [`ObserverError::Output`] for a k that is no
    /// output.
    pub fn new<T: RealField + Copy>(cascade: C) -> Result<Self, ObserverError>
    where
        C: Cascade<T>,
        DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
    {
        let [n2, n3, _] = cascade.blocks();
        check_matrix("A2", &cascade.a2(), (n2, n2))?;
        check_matrix("A3", &cascade.a3(), (n3, n3))?;
        let (k, (_, outputs)) = (cascade.k(), cascade.inputs_and_outputs());
        if k >= outputs {
            return Err(ObserverError::Output { output: k, outputs });
        }
        Ok(Self { cascade })
    }

    /// The pieces.
    pub fn cascade(&self) -> &C {
        &self.cascade
    }
}

/// An extension of the cascade `C`.
type Xi<C, T> = OVector<T, LengthOf<C, T>>;

type LengthOf<C, T> = <DefaultAllocator as CascadeSize<
    <C as Cascade<T>>::Second,
    <C as Cascade<T>>::Third,
    <C as Cascade<T>>::Fourth,
    <C as Cascade<T>>::Inputs,
    <C as Cascade<T>>::Outputs,
>>::Length;

/// x2, x3 and x4 or xi out of the extension.
type Blocks<C, T> = (
    OVector<T, <C as Cascade<T>>::Second>,
    OVector<T, <C as Cascade<T>>::Third>,
    OVector<T, <C as Cascade<T>>::Fourth>,
);

fn blocks<T, C>(cascade: &C, xi: &Xi<C, T>) -> Blocks<C, T>
where
    T: RealField + Copy,
    C: Cascade<T>,
    DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
{
    let [n2, n3, n4] = cascade.blocks();
    (
        OVector::from_fn_generic(C::Second::from_usize(n2), U1, |i, _| xi[i]),
        OVector::from_fn_generic(C::Third::from_usize(n3), U1, |i, _| xi[n2 + i]),
        OVector::from_fn_generic(C::Fourth::from_usize(n4), U1, |i, _| xi[n2 + n3 + i]),
    )
}

impl<T, C> KklMap<T> for CascadeMap<C>
where
    T: RealField + Copy,
    C: Cascade<T>,
    DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
{
    type Xi = LengthOf<C, T>;
    type Inputs = C::Inputs;
    type Outputs = C::Outputs;
    type Estimate = LengthOf<C, T>;

    fn dimensions(&self) -> ObserverDimensions {
        let length = self.cascade.blocks().iter().sum();
        let (inputs, outputs) = self.cascade.inputs_and_outputs();
        ObserverDimensions { state: length, inputs, outputs, estimate: length }
    }

    fn lambda(&self, _t: T, _u: &OVector<T, C::Inputs>, _y: &OVector<T, C::Outputs>) -> OMatrix<T, Self::Xi, Self::Xi> {
        let ([n2, n3, n4], a2, a3) = (self.cascade.blocks(), self.cascade.a2(), self.cascade.a3());
        let order = Self::Xi::from_usize(n2 + n3 + n4);
        OMatrix::from_fn_generic(order, order, |i, j| {
            if i < n2 && j < n2 {
                a2[(i, j)]
            } else if (n2..n2 + n3).contains(&i) && (n2..n2 + n3).contains(&j) {
                a3[(i - n2, j - n2)]
            } else {
                T::zero()
            }
        })
    }

    fn injection(&self, _t: T, xi: &Xi<C, T>, u: &OVector<T, C::Inputs>, y: &OVector<T, C::Outputs>) -> Xi<C, T> {
        let (x2, x3, _) = blocks(&self.cascade, xi);
        let (f2, f3, f4) = (self.cascade.f2(y, u), self.cascade.f3(y, &x2, u), self.cascade.f4(y, &x2, &x3, u));
        let mut injection = xi.clone();
        let entries = f2.iter().chain(f3.iter()).chain(f4.iter());
        injection.iter_mut().zip(entries).for_each(|(injection, &entry)| *injection = entry);
        injection
    }

    fn left_inverse(&self, _t: T, xi: &Xi<C, T>, _y: &OVector<T, C::Outputs>) -> Xi<C, T> {
        xi.clone()
    }

    fn image(&self, _t: T, xhat: &Xi<C, T>, _y: &OVector<T, C::Outputs>) -> Xi<C, T> {
        xhat.clone()
    }
}

impl<T, C> Regression<T> for CascadeMap<C>
where
    T: RealField + Copy,
    C: Cascade<T>,
    DefaultAllocator: CascadeSize<C::Second, C::Third, C::Fourth, C::Inputs, C::Outputs>,
{
    type Rows = U1;
    type Parameters = C::Fourth;

    fn rows_and_parameters(&self) -> (usize, usize) {
        (1, self.cascade.blocks()[2])
    }

    fn signal(&self, _t: T, y: &OVector<T, C::Outputs>) -> OVector<T, U1> {
        OVector::<T, U1>::new(y[self.cascade.k()])
    }

    fn known(&self, _t: T, xi: &Xi<C, T>, u: &OVector<T, C::Inputs>, y: &OVector<T, C::Outputs>) -> OVector<T, U1> {
        let (x2, x3, integral) = blocks(&self.cascade, xi);
        let b = self.cascade.b(y, &x2, &x3, u);
        OVector::<T, U1>::new(self.cascade.f1k(y, &x2, &x3, u) + b.dot(&integral))
    }

    fn regressor(
        &self,
        _t: T,
        xi: &Xi<C, T>,
        u: &OVector<T, C::Inputs>,
        y: &OVector<T, C::Outputs>,
    ) -> OMatrix<T, U1, C::Fourth> {
        let (x2, x3, _) = blocks(&self.cascade, xi);
        let b = self.cascade.b(y, &x2, &x3, u);
        OMatrix::from_fn_generic(U1, b.shape_generic().0, |_, j| b[j])
    }

    fn missing(&self, theta: &OVector<T, C::Fourth>) -> Xi<C, T> {
        let [n2, n3, n4] = self.cascade.blocks();
        let length = <LengthOf<C, T> as Dim>::from_usize(n2 + n3 + n4);
        OVector::from_fn_generic(length, U1, |i, _| if i < n2 + n3 { T::zero() } else { theta[i - n2 - n3] })
    }
}
