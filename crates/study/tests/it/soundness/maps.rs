//! Observers with maps of a study: KKL, and immersion and invariance.
