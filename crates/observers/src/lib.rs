//! State observers as they run on the target: no_std, no allocation
