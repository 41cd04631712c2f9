//! Sentences claim no more than their theorems: regions, inputs, rounding.
