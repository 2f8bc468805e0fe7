//! Chains fitted to records.

mod coverage;
mod errors;
mod known;
mod made;
mod wrong_models;
