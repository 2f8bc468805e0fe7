//! The program, as a user runs it.

mod analyze;
mod attenuation;
mod chain;
mod convert;
mod dispersion;
mod estimates;
mod faults;
mod files;
mod fit;
mod gaps;
mod general;
mod leftovers;
mod limits;
mod localize;
mod long;
mod parts;
mod present;
mod refusals;
mod same;
mod scans;
mod sessions;
mod sweep;
mod terminal;
