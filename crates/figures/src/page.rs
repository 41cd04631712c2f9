//! A self-contained HTML file, which loads no external resource.
//!
//! The plotting library, the style sheet, the script and the data of the figures are embedded in the page; what is long
//! is compressed by gzip, in base 85, and the browser unpacks it. The linked SVG, PNG and CSV files are in the folders
//! beside the page.
//!
//! The plotting library is plotly.js 3.7.0 in its basic bundle (scatter, bar, pie), MIT, as npm has it in
//! plotly.js-basic-dist-min: `assets`, with its licence. Its SHA-256 is tested in `tests/it/report.rs`.

use crate::base85;
use crate::figure::{Figure, FigureError, interactive};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use luenberger_wording::escape;
use serde_json::{Map, Value as Json};
use std::fmt;
use std::io::{Read, Write};
use std::sync::LazyLock;

/// plotly.js with scatter and bar plots, compressed; see the README beside it.
static PLOTTING_LIBRARY: LazyLock<String> =
    LazyLock::new(|| in_base85(include_str!("../assets/plotly-basic-3.7.0.min.js.gz.base64")));

/// Draws every element with a `data-picture`, in the colours of the page, and redraws when the light or dark mode
/// changes.
const DRAW_PICTURES: &str = include_str!("pictures.js");

/// The style of every page, light and dark: headings, prose, figures, and the tones `good`, `bad`, `open` and `failed`
/// of a `badge`.
const STYLE: &str = include_str!("page.css");

/// The letters in base 85 of the bytes that `letters` has in base64, which may be broken into lines. An asset whose
/// letters are not base64 becomes an element without text, which the page reports.
pub(crate) fn in_base85(letters: &str) -> String {
    let letters: String = letters.split_whitespace().collect();
    STANDARD.decode(letters).map(|bytes| base85::encode(&bytes)).unwrap_or_default()
}

/// `bytes` compressed by gzip, in base 85. Writing into memory does not fail.
pub(crate) fn compressed(bytes: &[u8]) -> String {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    packed.map(|packed| base85::encode(&packed)).unwrap_or_default()
}

/// The bytes that the element `id` of a page holds compressed: `pictures` has the data of its figures,
/// `plotting-library` the plotting library.
pub fn unpacked(page: &str, id: &str) -> Option<Vec<u8>> {
    let (_, rest) = page.split_once(&format!("<script type=\"text/plain\" id=\"{id}\">"))?;
    let (letters, _) = rest.split_once("</script>")?;
    let packed = base85::decode(letters)?;
    let mut bytes = Vec::new();
    GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).ok().map(|_| bytes)
}

/// The page; additional `style` and `script` are placed after the default ones.
pub(crate) fn page(title: &str, body: &str, pictures: &Pictures, style: &str, script: &str) -> String {
    let title = escape(title);
    let library = PLOTTING_LIBRARY.as_str();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n\
         <style>\n{STYLE}{style}</style>\n</head>\n<body>\n{body}\n\
         <script type=\"text/plain\" id=\"pictures\">{pictures}</script>\n\
         <script type=\"text/plain\" id=\"plotting-library\">{library}</script>\n<script>\n\"use strict\";\n{DRAW_PICTURES}{script}</script>\n</body>\n</html>\n"
    )
}

/// The figures of a page by their ids, as the JSON that the script reads.
#[derive(Debug, Clone)]
pub(crate) struct Pictures {
    pictures: Map<String, Json>,
    numbers: Vec<String>,
}

impl Pictures {
    /// No figures yet; the data of each are in `data/ID.EXTENSION` for each of the extensions.
    pub(crate) fn with_numbers_as(extensions: &[&str]) -> Self {
        Self { pictures: Map::new(), numbers: extensions.iter().map(|&extension| extension.to_owned()).collect() }
    }

    /// Adds a figure, and returns its HTML element: the figure with its caption and with links to `figures/ID.svg`,
    /// `figures/ID.png` and `data/ID.csv`, or the data in the chosen formats.
    /// # Errors
    /// [`FigureError`] names the part of the figure that cannot be drawn.
    pub(crate) fn add(&mut self, id: &str, figure: &Figure) -> Result<String, FigureError> {
        self.pictures.insert(id.to_owned(), interactive::plotly(figure)?);
        let (id, title) = (escape(id), escape(&figure.title));
        let link = |extension: &String| {
            let extension = escape(extension);
            format!(" <a href=\"data/{id}.{extension}\">{}</a>", extension.to_uppercase())
        };
        let numbers: String = self.numbers.iter().map(link).collect();
        Ok(format!(
            "<figure id=\"{id}\"><h3>{title}</h3><div class=\"plot\" data-picture=\"{id}\" role=\"img\" \
             aria-label=\"{title}\"></div><noscript><img src=\"figures/{id}.svg\" alt=\"{title}\"></noscript>\
             <figcaption>{} <span class=\"files\"><a href=\"figures/{id}.svg\">SVG</a> \
             <a href=\"figures/{id}.png\">PNG</a>{numbers}</span></figcaption></figure>",
            escape(&figure.caption)
        ))
    }
}

/// The JSON, compressed by gzip, in base 85.
impl fmt::Display for Pictures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let json = serde_json::to_vec(&self.pictures).map_err(|_| fmt::Error)?;
        f.write_str(&compressed(&json))
    }
}
