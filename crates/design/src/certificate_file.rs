//! Designs as certificate files: the theorem that a design proves, with the numbers that run.
//!
//! Each design has one method, `certificate_file`. The file is proved as it is written, by `luenberger-proof` from what a reader of it will have; `luenberger-verify` needs
//! neither this crate nor a solver to prove it again. What a file says and what it does not: `docs/certificates.md`.

use luenberger_observers::SampledObserver;
use luenberger_plants::{DynamicPlant, Plant, Size};
use luenberger_proof::certificate::{
    self, CertificateFile, ClaimedBall, CubicTheorem1, DeployedObserver, DiscreteObserver, Equation, FeedbackLoop,
    Hurwitz, JacobianPolytope, LinearObserver, PlantPolytope, PlantWithin, Region, SampledCubicObserver,
    SectorObserver, SolutionWithin, StructuredCubicObserver, Theorem, Vertex,
};
use luenberger_proof::statement::{DeployedCubic, Formats, Operation, Reach, Step};
use luenberger_proof::{Matrix, ProofError};
use nalgebra::{DMatrix, DefaultAllocator, Dim, OVector};

use crate::certificate::exact;
use crate::error::DesignError;
use crate::exact_solution::{lyapunov_proposal, points, stein_proposal};
use crate::kkl::{Stability, stability::forgets};
use crate::robust::{GainCertificate, PolytopicDesign};
use crate::{
    ContractingCoordinates, CubicDesign, DeployedLinear, FeedbackDesign, LinearDesign, LipschitzDesign, LpvDesign,
    RepairedDesign, SampledCubicDesign, Theorem1,
};

fn plant((a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)) -> Result<certificate::Plant, ProofError> {
    Ok(certificate::Plant { a: exact(a)?, b: exact(b)?, c: exact(c)? })
}

/// From which errors the observer is proved to converge with its gains as stored, if from any.
fn region(deployed: Option<&DeployedCubic>) -> Option<Region> {
    match &deployed?.reach {
        Reach::Everywhere { .. } => Some(Region::Everywhere),
        Reach::Within(ellipsoid) => Some(Region::Within(ellipsoid.level)),
        Reach::Unproved => None,
    }
}

fn prove(title: &str, theorem: impl Into<Theorem>) -> Result<CertificateFile, DesignError> {
    Ok(CertificateFile::prove(title, theorem)?)
}

impl LinearDesign {
    /// The certificate file of the design: `P > 0` and (12), with the [rate](Self::rate).
    ///
    /// ```
    /// use luenberger_design::{Decrease, LinearDesign, Wish};
    /// use luenberger_proof::certificate::verify;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = LinearDesign::new(&plant, &Wish::poles(&[-2.0, -5.0]), &Decrease::Scaled(10.0))?;
    /// let file = design.certificate_file("a double integrator")?.to_json();
    /// let proved = verify(file.as_bytes())?;
    /// // The margin of (12), which is Q = 10 I up to rounding; a margin is found to about 1e-9 of the matrix.
    /// let margin = proved.facts[1].verdict.margin().unwrap();
    /// assert!(margin <= 10.0 + 1e-12 && margin > 10.0 - 1e-8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let o = &self.observer;
        let plant = PlantWithin::exactly(&exact(&o.a)?, &exact(&o.b)?, &exact(&o.c)?)?;
        prove(title, LinearObserver { plant, l: exact(&o.l)?, p: exact(&self.p)?, rate: self.rate })
    }
}

impl CubicDesign {
    fn theorem(&self, region: Region) -> Result<certificate::CubicObserver, ProofError> {
        let o = &self.observer;
        Ok(certificate::CubicObserver {
            plant: plant((&o.a, &o.b, &o.c))?,
            l: exact(&o.l)?,
            n: exact(&o.n)?,
            theta: exact(&o.theta)?,
            p: exact(&self.p)?,
            s: exact(&self.s)?,
            rate: self.rate,
            region,
        })
    }

    /// The certificate file of the observer with its gains as stored (Theorems 1 and 2), from every error or from those of an ellipsoid. Where neither is proved, that of the real
    /// gain `N = -P^-1 C'S`.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        if let Some(region) = region(self.certificate.deployed.as_ref()) {
            return prove(title, self.theorem(region)?);
        }
        let o = &self.observer;
        let theorem = StructuredCubicObserver {
            plant: plant((&o.a, &o.b, &o.c))?,
            l: exact(&o.l)?,
            theta: exact(&o.theta)?,
            p: exact(&self.p)?,
            s: exact(&self.s)?,
            rate: self.rate,
        };
        prove(title, theorem)
    }
}

impl FeedbackDesign {
    /// The certificate file of the loop around `observer`, the design that this one was made for (Theorem 6, Corollary 1).
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved, and [`DesignError::Proof`] shapes that do not fit.
    pub fn certificate_file(&self, title: &str, observer: &CubicDesign) -> Result<CertificateFile, DesignError> {
        // Where nothing is proved of the stored gain, the claim that it converges everywhere is what fails.
        let region = region(observer.certificate.deployed.as_ref()).unwrap_or(Region::Everywhere);
        let observer = observer.theorem(region)?;
        prove(title, FeedbackLoop { observer, k: exact(&self.k)?, p1: exact(&self.p1)? })
    }
}

impl SampledCubicDesign {
    /// The certificate file of the sampled observer with the real gain `N = -P^-1 C'S`.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let o = &self.observer;
        let theorem = SampledCubicObserver {
            plant: plant((o.ad(), o.bd(), o.c()))?,
            l: exact(o.ld())?,
            theta: exact(o.theta())?,
            period: SampledObserver::period(o),
            p: exact(&self.p)?,
            s: exact(&self.s)?,
        };
        prove(title, theorem)
    }

    /// The certificate file of this observer stored and run in `formats`, as [`deployed`](Self::deployed) proves it: with the ball of the running error where there is one.
    ///
    /// ```
    /// use luenberger_design::{Decrease, LinearDesign, SampledCubicDesign, Wish};
    /// use luenberger_proof::certificate::verify;
    /// use luenberger_proof::statement::{Format, Operation};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::new(&plant, &Wish::poles(&[-2.0, -5.0]), &Decrease::Scaled(10.0))?;
    /// let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, 0.1)?;
    /// let meets = Operation { state: vec![1.0, 2.0], input: vec![5.0], noise: vec![0.0], error: vec![10.0, 10.0] };
    /// let file = design.deployed_certificate_file("in f32", Format::Binary32.into(), &meets)?.to_json();
    /// assert!(verify(file.as_bytes())?.statement.contains("stored in binary32"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved; those of [`deployed`](Self::deployed).
    pub fn deployed_certificate_file(
        &self,
        title: &str,
        formats: Formats,
        operation: &Operation,
    ) -> Result<CertificateFile, DesignError> {
        let deployed = self.deployed(formats, operation)?;
        let theorem = DeployedObserver {
            plant: self.sampled_plant()?,
            ball: deployed.ball().map(ClaimedBall::from),
            stored: deployed.stored,
            step: Step::Innovation,
            formats,
            operation: operation.clone(),
            p: exact(&self.p)?,
        };
        prove(title, theorem)
    }

    /// The certificate file of its linear part alone.
    ///
    /// # Errors
    /// As [`certificate_file`](Self::certificate_file).
    pub fn linear_certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let o = &self.observer;
        prove(title, DiscreteObserver { plant: plant((o.ad(), o.bd(), o.c()))?, l: exact(o.ld())?, p: exact(&self.p)? })
    }
}

impl DeployedLinear {
    /// The certificate file of the stored numbers, and of the ball of the running error where there is one.
    ///
    /// ```
    /// use luenberger_design::deployed_linear;
    /// use luenberger_proof::certificate::verify;
    /// use luenberger_proof::statement::{Format, Operation, Step};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::DynamicPlant::new(dmatrix![1.0, 0.01; 0.0, 1.0], dmatrix![5e-5; 0.01], dmatrix![1.0, 0.0])?;
    /// let meets = Operation { state: vec![1.0, 2.0], input: vec![5.0], noise: vec![0.0], error: vec![1.0, 2.0] };
    /// let found = deployed_linear(&plant, &dmatrix![0.3; 2.0], Step::Innovation, Format::Binary32.into(), &meets)?;
    /// let file = found.certificate_file("a position estimated in f32")?.to_json();
    /// let proved = verify(file.as_bytes())?;
    /// assert_eq!(proved.facts.last().unwrap().inequality, "limsup |e_2| <= running.limsup[1]");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let theorem = DeployedObserver {
            plant: self.plant.clone(),
            stored: self.deployed.stored.clone(),
            step: self.step,
            formats: self.formats,
            operation: self.operation.clone(),
            p: exact(&self.p)?,
            ball: self.deployed.ball().map(ClaimedBall::from),
        };
        prove(title, theorem)
    }
}

impl Stability {
    /// The certificate file of the part of Lambda that is to forget: one P for every matrix in its enclosure over the box, so that `xi' = Lambda(t) xi` decays however Lambda moves
    /// there. It does not say that the enclosure is that of the design's Lambda.
    ///
    /// # Errors
    /// [`KklError::NotHurwitz`](crate::kkl::KklError::NotHurwitz) and [`KklError::HurwitzUndecided`](crate::kkl::KklError::HurwitzUndecided) where there is no such proof;
    /// [`DesignError::CertificateFile`].
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        forgets("Lambda", &self.eigenvalues, &self.facts)?;
        // Where the facts are proved there is a P.
        let p = self.p.clone().unwrap_or_default();
        prove(title, Hurwitz::within(&self.rest(), &exact(&p)?)?)
    }
}

/// The certificate file of the exact P of `A'P + PA + Q = 0`: that it is the only one, and lies in the intervals of [`enclosed_lyapunov`](crate::enclosed_lyapunov).
///
/// ```
/// use luenberger_design::lyapunov_certificate_file;
/// use luenberger_proof::certificate::verify;
/// use nalgebra::dmatrix;
///
/// let (a, q) = (dmatrix![0.0, 1.0; -2.0, -3.0], dmatrix![1.0, 0.0; 0.0, 1.0]);
/// let file = lyapunov_certificate_file("a damped oscillator", &a, &q)?.to_json();
/// assert_eq!(verify(file.as_bytes())?.facts[0].inequality, "A'P + PA + Q = 0 has one solution, and it lies in P");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`DesignError::CertificateFile`] where uniqueness could not be proved; those of [`enclosed_lyapunov`](crate::enclosed_lyapunov).
pub fn lyapunov_certificate_file(
    title: &str,
    a: &DMatrix<f64>,
    q: &DMatrix<f64>,
) -> Result<CertificateFile, DesignError> {
    let (parts, w) = lyapunov_proposal(a, q)?;
    prove(title, SolutionWithin::derive(Equation::Lyapunov, &points(a)?, &points(q)?, &parts, Some(&w))?)
}

/// The certificate file of the exact P of `A'PA - P + Q = 0`, as [`lyapunov_certificate_file`].
///
/// # Errors
/// As [`lyapunov_certificate_file`].
pub fn stein_certificate_file(title: &str, a: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<CertificateFile, DesignError> {
    let (parts, w) = stein_proposal(a, q)?;
    prove(title, SolutionWithin::derive(Equation::Stein, &points(a)?, &points(q)?, &parts, Some(&w))?)
}

impl Theorem1 {
    /// The certificate file of Theorem 1 for gains of any origin, with the arguments of [`examine`](Self::examine). A gain N that was rounded misses (13'), and has no such file.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the condition that is not proved, or the matrix that does not fit.
    pub fn certificate_file(
        title: &str,
        plant_model: &DynamicPlant,
        (l, n, theta): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
        p: &DMatrix<f64>,
    ) -> Result<CertificateFile, DesignError> {
        let plant = plant((&plant_model.a, &plant_model.b, &plant_model.c))?;
        let theorem = CubicTheorem1 { plant, l: exact(l)?, n: exact(n)?, theta: exact(theta)?, p: exact(p)? };
        prove(title, theorem)
    }
}

impl GainCertificate {
    /// The certificate file of the given gains with the P and S found, for `theta = I`.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let outputs = self.plant.c.nrows();
        let theorem = certificate::CubicObserver {
            plant: plant((&self.plant.a, &self.plant.b, &self.plant.c))?,
            l: exact(&self.l)?,
            n: exact(&self.n)?,
            theta: exact(&DMatrix::identity(outputs, outputs))?,
            p: exact(&self.p)?,
            s: exact(&self.s)?,
            rate: 0.0,
            region: region(self.certificate.deployed.as_ref()).unwrap_or(Region::Everywhere),
        };
        prove(title, theorem)
    }
}

impl PolytopicDesign {
    /// The certificate file of one gain for the nominal plant, which is the first vertex, and all others (Theorem 4).
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the vertex whose inequality is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let o = &self.nominal.observer;
        let c = exact(&o.c)?;
        let all = std::iter::once(&o.a).chain(&self.vertices);
        let vertices = all.map(|a| Vertex::exactly(&exact(a)?, &c)).collect::<Result<_, ProofError>>()?;
        prove(title, PlantPolytope { vertices, l: exact(&o.l)?, p: exact(&self.nominal.p)?, rate: self.nominal.rate })
    }
}

impl RepairedDesign {
    /// The certificate file of L and P for all Jacobians in the hull of the vertices.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the vertex whose inequality is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let (n, outputs) = self.l.shape();
        let c = exact(&DMatrix::identity(outputs, n))?;
        let vertices =
            self.vertices.iter().map(|a| Vertex::exactly(&exact(a)?, &c)).collect::<Result<_, ProofError>>()?;
        prove(title, JacobianPolytope { vertices, l: exact(&self.l)?, p: exact(&self.p)?, rate: self.rate })
    }
}

impl ContractingCoordinates {
    /// The certificate file of K, Q and the injection for all Jacobians in the hull of the vertices.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let theorem = certificate::ContractingCoordinates {
            vertices: self.vertices.iter().map(exact).collect::<Result<_, _>>()?,
            k: exact(&self.k)?,
            q: exact(&self.q)?,
            injection: self.injection,
            rate: self.rate,
        };
        prove(title, theorem)
    }
}

impl LipschitzDesign {
    /// The certificate file of L, P and the multipliers for every nonlinearity in the sectors.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let terms = self.plant.sectors().iter().zip(&self.tau).map(|(sector, &tau)| sector.term(tau));
        let theorem = SectorObserver {
            a: exact(self.plant.a())?,
            c: exact(self.plant.c())?,
            terms: terms.collect::<Result<_, _>>()?,
            l: exact(&self.l)?,
            p: exact(&self.p)?,
            rate: self.rate,
        };
        prove(title, theorem)
    }
}

impl<S, N: Dim, M: Dim, P: Dim> LpvDesign<S, N, M, P>
where
    S: Plant<f64, State = OVector<f64, N>, Input = OVector<f64, M>, Output = OVector<f64, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The certificate file of L and P for all matrices in the hull of the boxes around the vertices. It does not say that the Jacobians of the plant lie there, which is
    /// the work of the [enclosure](crate::enclosure) and needs the plant itself.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the vertex whose inequality is not proved.
    pub fn certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let vertices = (0..self.polytope.vertices.len()).map(|k| {
            let (a, c) = self.polytope.around(k);
            Vertex::within(&a, &c)
        });
        let gain = self.observer.l();
        let l = Matrix::from_fn(gain.nrows(), gain.ncols(), |i, j| gain[(i, j)]);
        let vertices = vertices.collect::<Result<_, ProofError>>()?;
        prove(title, JacobianPolytope { vertices, l, p: exact(&self.p)?, rate: self.rate })
    }
}
