//! Plants: the traits a plant implements, and the benchmark plants of the observer literature
