//! The planned transform of tiles.

use super::algorithm::Decomposition;
use super::bluestein::Bluestein;
use super::fallback::Fallback;
use super::kernels::{InstructionSet, Kernels};
use super::mixed_radix::{MixedRadix, Tile};
use crate::Real;

/// The planned transform of one length.
pub enum TilePlan<T: Real> {
    MixedRadix(MixedRadix<T>),
    Bluestein(Bluestein<T>),
    Fallback(Fallback<T>),
}

impl<T: Real> TilePlan<T> {
    /// Plans the algorithm of a length.
    pub fn new(set: InstructionSet, length: usize, decomposition: Decomposition) -> Self {
        match decomposition {
            Decomposition::MixedRadix((first, second)) => {
                TilePlan::MixedRadix(MixedRadix::new(first, second))
            }
            Decomposition::Bluestein(halves) => {
                TilePlan::Bluestein(Bluestein::new(set, length, halves))
            }
            Decomposition::Fallback => TilePlan::Fallback(Fallback::new(length)),
        }
    }

    /// # Safety
    /// As [`MixedRadix::tile`].
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        // SAFETY: the caller's.
        unsafe {
            match self {
                TilePlan::MixedRadix(plan) => plan.tile(kernels, tile, scratch),
                TilePlan::Bluestein(plan) => plan.tile(kernels, tile, scratch),
                TilePlan::Fallback(_) => {}
            }
        }
    }
}
