//! The papers, their claims, and the verdicts computed from them
