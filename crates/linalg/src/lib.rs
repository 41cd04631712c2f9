//! Matrix equations, spectra, placement and observability for control
