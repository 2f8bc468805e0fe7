//! Chains fitted to records.

mod compare;
mod coverage;
mod errors;
mod known;
mod made;
mod plan;
mod wrong_models;
