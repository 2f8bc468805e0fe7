//! The program, as a user runs it.

mod analyze;
mod attenuation;
mod bench;
mod budget;
mod chain;
mod fields;
mod filter;
mod general;
mod inputs;
mod localize;
mod long;
