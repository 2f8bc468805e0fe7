//! The ways to transform tiles, planned.

use super::chirp::Chirp;
use super::choice::Choice;
use super::fast::{Fast, Tile};
use super::kernels::{InstructionSet, Kernels};
use super::other::Other;
use super::rader::Rader;
use crate::Real;

/// The planned transform of one length.
pub enum Way<T: Real> {
    Fast(Fast<T>),
    Chirp(Chirp<T>),
    Rader(Rader<T>),
    Other(Other<T>),
}

impl<T: Real> Way<T> {
    /// As chosen for the length.
    pub fn new(set: InstructionSet, length: usize, choice: Choice) -> Self {
        match choice {
            Choice::Fast((first, second)) => Way::Fast(Fast::new(first, second)),
            Choice::Chirp(halves) => Way::Chirp(Chirp::new(set, length, halves)),
            Choice::Rader(halves) => Way::Rader(Rader::new(set, length, halves)),
            Choice::Other => Way::Other(Other::new(length)),
        }
    }

    /// # Safety
    /// As [`Fast::tile`].
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        // SAFETY: the caller's.
        unsafe {
            match self {
                Way::Fast(fast) => fast.tile(kernels, tile, scratch),
                Way::Chirp(chirp) => chirp.tile(kernels, tile, scratch),
                Way::Rader(rader) => rader.tile(kernels, tile, scratch),
                Way::Other(_) => {}
            }
        }
    }
}
