//! From a plant and a wish to an observer with its certificate
