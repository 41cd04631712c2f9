//! The largest admissible constant: how far the sectors can be widened while the inequality remains feasible.
//!
//! Feasibility is monotone in the width, because a wide sector contains the narrow one; bisection on the verdict
//! therefore brackets the threshold.

use luenberger_lmi::{Settings, greatest_parameter};
use nalgebra::DMatrix;

use super::sector::LipschitzPlant;
use super::{LipschitzDesign, Proposal, WHAT, problem};
use crate::check;
use crate::error::{DesignError, Pair};
use crate::gain_options::Checked;

/// The greatest factor by which sectors can be widened, with its design.
#[derive(Debug, Clone)]
pub struct AdmissibleFactor {
    /// The greatest factor proved.
    pub factor: f64,
    /// The least factor tried at which the inequality was refuted by verified multipliers: the supremum lies between
    /// the two. `None` when the limit itself was not refuted.
    pub refuted_at: Option<f64>,
    /// The design that proves it at `factor`.
    pub design: LipschitzDesign,
}

/// The greatest factor up to `limit`, to within `tolerance`, by which the sectors of `plant` may be
/// [widened](LipschitzPlant::widened) for a gain `l` (n x p), or for whatever gain is best. With
/// [`LipschitzPlant::unstructured`]`(a, c, 1.0)` the factor is the greatest Lipschitz constant.
///
/// For a fixed L and the unstructured condition the supremum is `1 / sup_w |(i w I - A + L C)^-1|`, the reciprocal of
/// an H-infinity norm. For a free L it need not be attained: gains grow without bound as the factor approaches it.
///
/// Cost: one SDP for each of `2 + log2(limit / tolerance)` steps, and as many again where the threshold itself stays
/// undecided.
///
/// ```
/// use luenberger_design::lipschitz::{LipschitzPlant, greatest_factor};
/// use nalgebra::dmatrix;
/// // The double integrator, its position measured: min over s >= 0 of |(A - s I) e2| = |(1, -s)| is 1.
/// let plant = LipschitzPlant::unstructured(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0], 1.0)?;
/// let greatest = greatest_factor(&plant, None, 0.0, 4.0, 1e-3)?;
/// assert!(greatest.factor >= 0.998 && greatest.factor < 1.0);
/// assert!(greatest.design.certificate.is_proved());
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// # Errors
/// As [`LipschitzDesign::new`] and [`LipschitzDesign::with_gain`] when not even the middle of the sectors can be
/// proved; [`DesignError::NotPositive`] for the limit and the tolerance.
pub fn greatest_factor(
    plant: &LipschitzPlant,
    l: Option<&DMatrix<f64>>,
    rate: f64,
    limit: f64,
    tolerance: f64,
) -> Result<AdmissibleFactor, DesignError> {
    plant.check(rate)?;
    check::positive("the limit of the factor", limit)?;
    check::positive("the tolerance of the factor", tolerance)?;
    if let Some(l) = l {
        check::matrix("L", l, (plant.a().nrows(), plant.c().nrows()))?;
        check::hurwitz("A - L C at the centre of the sectors", (&plant.centre(), l, plant.c()))?;
    } else {
        check::detectable(&plant.centre(), plant.c(), rate).map_err(|error| error.of_pair(Pair::MiddleOfSectors))?;
    }
    let found = greatest_parameter(0.0, limit, tolerance, |factor| {
        problem(&plant.widened(factor), l, rate, &Checked::default())
    })?;
    let Some((mut factor, solution)) = found.proved else {
        return Err(match found.stopped {
            Some((_, verdict)) => DesignError::not_proved(WHAT, Some(verdict)),
            None => DesignError::NotPositive { what: "the limit of the factor", value: limit },
        });
    };
    let refuted_at = match &found.stopped {
        None => None,
        Some((at, verdict)) if verdict.is_refuted() => Some(*at),
        Some((at, _)) => least_refuted(plant, l, rate, (*at, limit), tolerance)?,
    };
    let widened = plant.widened(factor);
    let mut design = match Proposal::read(&widened, &solution) {
        Some(proposal) => proposal.certified(&widened, l, rate, &Settings::default()),
        None => LipschitzDesign::new(&widened, rate),
    };
    // At the edge the rounding of L can cost the proof: step back, twice as far each time.
    let mut back = tolerance;
    while back < limit && !design.as_ref().is_ok_and(|design| design.certificate.is_proved()) {
        let narrower = (factor - back).max(0.0);
        let widened = plant.widened(narrower);
        design = match l {
            Some(l) => LipschitzDesign::with_gain(&widened, l, rate),
            None => LipschitzDesign::new(&widened, rate),
        };
        (factor, back) = (narrower, 2.0 * back);
    }
    Ok(AdmissibleFactor { factor, refuted_at, design: design? })
}

/// The least refuted factor above one that stayed undecided, to within `tolerance`: rounding leaves a gap at the
/// threshold itself.
fn least_refuted(
    plant: &LipschitzPlant,
    l: Option<&DMatrix<f64>>,
    rate: f64,
    (mut low, mut high): (f64, f64),
    tolerance: f64,
) -> Result<Option<f64>, DesignError> {
    let refuted = |factor: f64| -> Result<bool, DesignError> {
        Ok(problem(&plant.widened(factor), l, rate, &Checked::default()).solve()?.verdict.is_refuted())
    };
    if !refuted(high)? {
        return Ok(None);
    }
    while high - low > tolerance {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if refuted(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Some(high))
}
