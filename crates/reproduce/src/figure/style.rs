//! Colours, dashes and widths, the same in every rendering.
