//! Analyses of fields: spectra, measures, warnings, reports and figures.

mod analyze_stops;
mod bicoherence;
mod channels;
mod coherence;
mod determinism;
mod direct_sums;
mod display;
mod figures_html;
mod figures_layout;
mod figures_plot;
mod gaps;
mod hard_cases;
mod headline;
mod increments;
mod lomb;
mod modes;
mod noise;
mod reference_problems;
mod ridges;
mod slope;
mod spectra;
mod spectrum;
mod transfer;
mod warnings;
mod windows;
