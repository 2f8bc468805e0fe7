//! Chains fitted to records.

mod coverage;
mod errors;
mod known;
mod made;
mod plan;
mod wrong_models;
