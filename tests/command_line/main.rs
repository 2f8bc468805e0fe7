//! The program, as a user runs it.

mod analyze;
mod attenuation;
mod chain;
mod convert;
mod dispersion;
mod estimates;
mod faults;
mod files;
mod general;
mod leftovers;
mod limits;
mod localize;
mod long;
mod present;
mod refusals;
mod same;
mod sessions;
mod sweep;
mod terminal;
