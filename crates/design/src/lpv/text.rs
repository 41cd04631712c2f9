//! The inequalities of a polytopic design as text.

use core::fmt;

use luenberger_proof::certificate::{Certificate, Fact};
use luenberger_proof::wording::at_least;

use super::error::LpvError;

/// Where the search for a rate ended, if it did, and the inequalities of the certificate: of more than eight vertices
/// the one with the least margin.
pub(super) fn write_inequalities(
    f: &mut fmt::Formatter<'_>,
    stopped: Option<&(f64, Box<LpvError>)>,
    certificate: &Certificate,
    names: &[String],
) -> fmt::Result {
    if let Some((rate, why)) = stopped {
        writeln!(f, "Nothing was proved at the rate {rate:.6}: {why}.")?;
    }
    // Of many vertices, those that matter: what is not proved, and the least margin.
    let least = |fact: &Fact| fact.verdict.margin().unwrap_or(f64::NEG_INFINITY);
    let (vertices, others): (Vec<&Fact>, Vec<&Fact>) = certificate.facts().partition(|fact| fact.vertex.is_some());
    for fact in others {
        writeln!(f, "{:<9}  {fact}", fact.verdict.word())?;
    }
    let mut line = |fact: &Fact| {
        let margin =
            fact.verdict.margin().map_or_else(String::new, |margin| format!(", margin >= {}", at_least(margin, 4)));
        writeln!(f, "{:<9}  {}{margin}", fact.verdict.word(), fact.inequality_naming(names))
    };
    if vertices.len() <= 8 {
        return vertices.into_iter().try_for_each(line);
    }
    let proved = vertices.iter().filter(|fact| fact.verdict.is_proved()).count();
    let least = vertices.iter().min_by(|x, y| least(x).total_cmp(&least(y)));
    least.map_or(Ok(()), |fact| line(fact))?;
    writeln!(f, "This is the least of {} inequalities at the vertices, of which {proved} are proved.", vertices.len())
}
