//! Budgets of simulated and of measured chains.

mod balance;
mod equipartition;
mod identities;
mod known;
mod measured;
mod measured_spectra;
mod passage;
mod triads;
