//! The program, as a user runs it.

mod analyze;
mod attenuation;
mod bench;
mod budget;
mod chain;
mod coherence;
mod convert;
mod dispersion;
mod faults;
mod fields;
mod files;
mod filter;
mod general;
mod inputs;
mod inspect;
mod leftovers;
mod limits;
mod localize;
mod long;
mod scans;
mod settings;
mod several;
mod spectrum;
mod terminal;
