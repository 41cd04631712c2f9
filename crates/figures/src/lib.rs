//! Figures for papers and for the screen, tables of numbers, and the page that holds them.
//!
//! A figure is described once and drawn three ways (SVG, PNG, interactive); see [`figure`]. A table of numbers is
//! written with every digit; see [`table`]. A page is one HTML file that needs nothing else and loads nothing from
//! anywhere; see [`report`]. The same input gives the same bytes.
//!
//! This crate knows nothing of control.

#![deny(missing_docs)]

pub mod figure;
mod page;
pub mod report;
pub mod table;

pub use figure::{Bar, Dash, Figure, Hue, Mark, Marker, Panel, Series};
pub use page::escape;
pub use report::{Cell, Grid, Report, Section, Tone};
pub use table::Table;

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
