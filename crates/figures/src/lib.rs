//! Figures for papers and for the screen, tables of numbers, and HTML reports.
//!
//! A figure is described once and drawn three ways (SVG, PNG, interactive); see [`figure`]. Tables are written with all
//! digits; see [`table`]. A report is one self-contained HTML file; see [`report`]. The same input gives identical
//! bytes.
//!
//! This crate does not depend on control theory.

#![deny(missing_docs)]

pub mod base85;
pub mod figure;
pub mod formula;
pub mod npz;
mod page;
pub mod report;
pub mod table;

pub use figure::{Area, Bar, Dash, Figure, Hue, Mark, Marker, Panel, Series, colours};
pub use formula::Formula;
pub use luenberger_wording::escape;
pub use page::unpacked;
pub use report::{Cell, Grid, Report, Section, Tone};
pub use table::Table;

#[doc(hidden)]
pub mod internals {
    //! For the tests of this crate, no part of its interface.

    pub use crate::figure::packed::{STEP, numbers, step};
    pub use crate::figure::stroke::{Rect, clip, thin};
    pub use crate::figure::style::{CIVIDIS, GREY, Resolved, resolve};
    pub use crate::figure::thinned::{TOLERANCE, kept};
    pub use crate::figure::ticks::{Axis, Ticks};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
