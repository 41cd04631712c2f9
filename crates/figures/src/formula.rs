//! Formulas: MathML, which browsers draw by themselves, with LaTeX beside it for whoever copies them.

use luenberger_wording::escape;
use std::fmt::Write;

/// A formula in two languages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Formula {
    /// The content of a `math` element. It is not escaped.
    pub mathml: String,
    /// LaTeX, for the mathematical mode.
    pub latex: String,
}

impl Formula {
    /// `name = matrix`, with the entries as they are written. An empty name stands for the matrix alone.
    ///
    /// ```
    /// use luenberger_figures::Formula;
    /// let l = Formula::matrix("L", &[vec!["0.5".to_owned()], vec!["-2".to_owned()]]);
    /// assert_eq!(l.latex, "L = \\begin{bmatrix} 0.5 \\\\ -2 \\end{bmatrix}");
    /// // An entry may be approximate.
    /// let l = Formula::matrix("L", &[vec!["≈0".to_owned()]]);
    /// assert_eq!(l.latex, "L = \\begin{bmatrix} \\approx 0 \\end{bmatrix}");
    /// ```
    pub fn matrix(name: &str, rows: &[Vec<String>]) -> Self {
        let (mut mathml, mut latex) = (String::new(), String::new());
        if !name.is_empty() {
            // `P(0)` is a name of several parts.
            let _ = write!(mathml, "<mi>{}</mi><mo>=</mo>", escape(name));
            let _ = write!(latex, "{name} = ");
        }
        mathml.push_str("<mrow><mo>[</mo><mtable columnalign=\"right\">");
        for row in rows {
            mathml.push_str("<mtr>");
            for entry in row {
                let (about, number) = match entry.strip_prefix('≈') {
                    Some(number) => ("<mo>≈</mo>", number),
                    None => ("", entry.as_str()),
                };
                let _ = write!(mathml, "<mtd>{about}<mn>{}</mn></mtd>", escape(&number.replace('-', "−")));
            }
            mathml.push_str("</mtr>");
        }
        mathml.push_str("</mtable><mo>]</mo></mrow>");
        let lines: Vec<String> = rows.iter().map(|row| row.join(" & ").replace('≈', "\\approx ")).collect();
        let _ = write!(latex, "\\begin{{bmatrix}} {} \\end{{bmatrix}}", lines.join(" \\\\ "));
        Self { mathml, latex }
    }

    pub(crate) fn html(&self) -> String {
        let latex = escape(&self.latex);
        format!(
            "<math display=\"block\" alttext=\"{latex}\"><semantics><mrow>{}</mrow>\
             <annotation encoding=\"application/x-tex\">{latex}</annotation></semantics></math>",
            self.mathml
        )
    }
}
