//! Figures from results; computes nothing.
