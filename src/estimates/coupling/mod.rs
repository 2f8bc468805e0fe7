//! Quadratic coupling between frequencies: bicoherence, and linear and quadratic transfer between two sites.

mod along;
mod bicoherence;
mod fit;
mod found;
mod pass;
mod products;
mod sheet;
mod spectra;
mod transfer;
mod transfer_sheet;
mod triples;

pub use along::BicoherenceAlong;
pub use bicoherence::{
    Bicoherence, BicoherenceMap, BicoherenceRequest, CoupledTriple, bicoherence,
};
pub use found::{OutputTransfer, PairTransfer, Transfer, TransferShares};
pub use transfer::{TransferRequest, transfer};
