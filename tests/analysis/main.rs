//! Analyses of fields: spectra, measures, warnings, reports and figures.

mod analyze_stops;
mod bicoherence;
mod coherence;
mod determinism;
mod direct_sums;
mod display;
mod figures_html;
mod figures_layout;
mod figures_plot;
mod hard_cases;
mod headline;
mod increments;
mod lomb;
mod modes;
mod parts;
mod reference_problems;
mod ridges;
mod slope;
mod spacetime;
mod spectra;
mod spectrum;
mod transfer;
mod warnings;
mod windows;
