//! A page of lines, areas and horizontal text, as SVG and, rendered by tiny-skia, as PNG.
//!
//! Both forms have butt caps, round joins and the same dashes; the text of the PNG is set in DejaVu Sans, which is also
//! the first font family of the SVG.

use super::FigureError;
use super::style::{Rgb, hex};
use core::fmt::Write;
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};
use ttf_parser::{Face, OutlineBuilder};

/// A point of the page, in its pixels.
pub(crate) type Point = (f64, f64);

const FAMILY: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";

/// Pixels of the PNG per pixel of the page.
const SCALE: f32 = 3.0;

#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

enum Outline {
    Lines { points: Vec<Point>, closed: bool },
    Circle { centre: Point, radius: f64 },
    Words { at: Point, text: String, size: f64, anchor: Anchor },
}

/// Outlines with a pen are stroked, others are filled.
struct Pen {
    width: f64,
    /// Strokes and gaps; unbroken if empty.
    dash: Vec<f64>,
}

pub(crate) struct Canvas {
    pub(crate) width: f64,
    pub(crate) height: f64,
    letters: Face<'static>,
    shapes: Vec<(Outline, Rgb, Option<Pen>)>,
    /// Those of the shapes that are translucent, with their opacity.
    opacity: Vec<(usize, f64)>,
}

impl Canvas {
    pub(crate) fn new(width: f64) -> Result<Self, FigureError> {
        let letters = Face::parse(dejavu::sans::regular(), 0).map_err(|why| FigureError::Encoding(why.to_string()))?;
        Ok(Self { width, height: 0.0, letters, shapes: Vec::new(), opacity: Vec::new() })
    }

    pub(crate) fn stroke(&mut self, points: &[Point], width: f64, dash: &[f64], color: Rgb) {
        let outline = Outline::Lines { points: points.iter().copied().map(rounded).collect(), closed: false };
        self.shapes.push((outline, color, Some(Pen { width, dash: dash.to_vec() })));
    }

    pub(crate) fn area(&mut self, corners: &[Point], color: Rgb) {
        let outline = Outline::Lines { points: corners.iter().copied().map(rounded).collect(), closed: true };
        self.shapes.push((outline, color, None));
    }

    /// An area through which what is below is seen.
    pub(crate) fn shade(&mut self, corners: &[Point], color: Rgb, opacity: f64) {
        self.opacity.push((self.shapes.len(), opacity));
        self.area(corners, color);
    }

    fn opacity_of(&self, shape: usize) -> Option<f64> {
        self.opacity.iter().find(|(index, _)| *index == shape).map(|(_, opacity)| *opacity)
    }

    pub(crate) fn disc(&mut self, centre: Point, radius: f64, color: Rgb) {
        self.shapes.push((Outline::Circle { centre: rounded(centre), radius }, color, None));
    }

    pub(crate) fn ring(&mut self, centre: Point, radius: f64, width: f64, color: Rgb) {
        let pen = Pen { width, dash: Vec::new() };
        self.shapes.push((Outline::Circle { centre: rounded(centre), radius }, color, Some(pen)));
    }

    pub(crate) fn words(&mut self, at: Point, text: &str, size: f64, anchor: Anchor, color: Rgb) {
        self.shapes.push((Outline::Words { at: rounded(at), text: text.to_owned(), size, anchor }, color, None));
    }

    /// The width of a line of text.
    pub(crate) fn width(&self, text: &str, size: f64) -> f64 {
        let advances = text.chars().map(|c| f64::from(self.letters.glyph_hor_advance(self.glyph(c)).unwrap_or(0)));
        advances.sum::<f64>() * size / f64::from(self.letters.units_per_em())
    }

    /// Glyph 0 stands for a letter that the face does not have.
    fn glyph(&self, letter: char) -> ttf_parser::GlyphId {
        self.letters.glyph_index(letter).unwrap_or_default()
    }

    pub(crate) fn svg(&self) -> String {
        let (width, height) = (self.width, self.height);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"{FAMILY}\" \
             stroke-linejoin=\"round\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>"
        );
        for (index, (outline, color, pen)) in self.shapes.iter().enumerate() {
            // Writing into a String cannot fail.
            let _ = match outline {
                Outline::Lines { points, closed } => {
                    let steps = points.iter().map(|(x, y)| format!("{x} {y}")).collect::<Vec<_>>().join("L");
                    write!(svg, "<path d=\"M{steps}{}\"", if *closed { "Z" } else { "" })
                }
                Outline::Circle { centre: (x, y), radius } => {
                    write!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"")
                }
                Outline::Words { at: (x, y), size, anchor, .. } => {
                    let anchor = match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    };
                    write!(svg, "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\"")
                }
            };
            let color = hex(*color);
            let _ = match pen {
                None => write!(svg, " fill=\"{color}\""),
                Some(Pen { width, .. }) => {
                    write!(svg, " fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\"", hundredths(*width))
                }
            };
            if let Some(opacity) = self.opacity_of(index) {
                let _ = write!(svg, " fill-opacity=\"{opacity}\"");
            }
            if let Some(Pen { dash, .. }) = pen.as_ref().filter(|pen| !pen.dash.is_empty()) {
                let dash: Vec<String> = dash.iter().map(|part| hundredths(*part).to_string()).collect();
                let _ = write!(svg, " stroke-dasharray=\"{}\"", dash.join(" "));
            }
            match outline {
                Outline::Words { text, .. } => {
                    let _ = write!(svg, ">{}</text>", luenberger_wording::escape(text));
                }
                _ => svg.push_str("/>"),
            }
        }
        svg + "</svg>"
    }

    pub(crate) fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (width, height) = (self.width * f64::from(SCALE), self.height * f64::from(SCALE));
        let beyond = || FigureError::Encoding(format!("{width} x {height} pixels"));
        let mut pixels = Pixmap::new(width as u32, height as u32).ok_or_else(beyond)?;
        pixels.fill(tiny_skia::Color::WHITE);
        let scale = Transform::from_scale(SCALE, SCALE);
        for (index, (outline, [r, g, b], pen)) in self.shapes.iter().enumerate() {
            // Nothing is drawn of an outline without extent.
            let Some(path) = self.path(outline) else { continue };
            let mut paint = Paint::default();
            let alpha = self.opacity_of(index).map_or(255, |opacity| (255.0 * opacity).round() as u8);
            paint.set_color_rgba8(*r, *g, *b, alpha);
            match pen {
                None => pixels.fill_path(&path, &paint, FillRule::Winding, scale, None),
                Some(Pen { width, dash }) => {
                    let dash = StrokeDash::new(dash.iter().map(|part| *part as f32).collect(), 0.0);
                    let stroke = Stroke { width: *width as f32, line_join: LineJoin::Round, dash, ..Stroke::default() };
                    pixels.stroke_path(&path, &paint, &stroke, scale, None);
                }
            }
        }
        encoded(&pixels).map_err(|why| FigureError::Encoding(why.to_string()))
    }

    fn path(&self, outline: &Outline) -> Option<Path> {
        match outline {
            Outline::Lines { points, closed } => {
                let mut path = PathBuilder::new();
                for (k, (x, y)) in points.iter().enumerate() {
                    if k == 0 { path.move_to(*x as f32, *y as f32) } else { path.line_to(*x as f32, *y as f32) }
                }
                if *closed {
                    path.close();
                }
                path.finish()
            }
            Outline::Circle { centre: (x, y), radius } => {
                PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32)
            }
            Outline::Words { at: (x, y), text, size, anchor } => {
                let before = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => self.width(text, *size) / 2.0,
                    Anchor::End => self.width(text, *size),
                };
                let scale = *size as f32 / f32::from(self.letters.units_per_em());
                let (mut line, mut x) = (PathBuilder::new(), (x - before) as f32);
                for glyph in text.chars().map(|letter| self.glyph(letter)) {
                    let mut letter = Letter(PathBuilder::new());
                    // A space has no outline. A font's ordinates point upwards.
                    if self.letters.outline_glyph(glyph, &mut letter).is_some() {
                        let place = Transform::from_row(scale, 0.0, 0.0, -scale, x, *y as f32);
                        line.push_path(&letter.0.finish()?.transform(place)?);
                    }
                    x += scale * f32::from(self.letters.glyph_hor_advance(glyph).unwrap_or(0));
                }
                line.finish()
            }
        }
    }
}

/// The page, which is opaque, as a PNG. Paeth's filter alone: to try all of them takes as long as the compression and
/// saves 3 %.
fn encoded(pixels: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut opaque = Vec::with_capacity(pixels.data().len() / 4 * 3);
    for pixel in pixels.data().chunks_exact(4) {
        opaque.extend_from_slice(&pixel[..3]);
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_filter(png::Filter::Paeth);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&opaque)?;
    writer.finish()?;
    Ok(file)
}

struct Letter(PathBuilder);

impl OutlineBuilder for Letter {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

/// Hundredths of a pixel: finer is not seen, and the digits would be most of the file.
fn hundredths(length: f64) -> f64 {
    (length * 100.0).round() / 100.0
}

fn rounded((x, y): Point) -> Point {
    (hundredths(x), hundredths(y))
}
