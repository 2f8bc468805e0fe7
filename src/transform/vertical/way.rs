//! How columns of a length are transformed.

use super::chirp::Chirp;
use super::choice;
use super::fast::{Fast, Tile};
use super::kernels::{InstructionSet, Kernels};
use super::other::Other;
use super::rader::Rader;
use crate::transform::Real;

/// The planned transform of one length.
pub enum Way<T: Real> {
    Fast(Fast<T>),
    Chirp(Chirp<T>),
    Rader(Rader<T>),
    Other(Other<T>),
}

/// How a length is transformed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Method {
    /// In two halves, each by passes of these radices.
    TwoHalves {
        first: Vec<usize>,
        second: Vec<usize>,
    },
    /// By a convolution of so many points, Bluestein's.
    Convolution { points: usize },
    /// A prime length by a convolution of so many points, Rader's.
    PrimeConvolution { points: usize },
    /// Column by column, by `realfft`: the shortest.
    ByColumn,
}

impl<T: Real> Way<T> {
    /// For a length of at least 1.
    pub fn new(set: InstructionSet, length: usize) -> Self {
        match choice::halves(length) {
            Some((first, second)) => Way::Fast(Fast::new(first, second)),
            None if length <= 8 => Way::Other(Other::new(length)),
            None if choice::is_odd_prime(length) => {
                let points = choice::convolution(Rader::<T>::least_points(length));
                Way::Rader(Rader::new(set, length, points))
            }
            None => {
                let points = choice::convolution(length + length / 2);
                Way::Chirp(Chirp::new(set, length, points))
            }
        }
    }

    pub fn method(&self) -> Method {
        match self {
            Way::Fast(fast) => {
                let [first, second] = fast.radices();
                Method::TwoHalves {
                    first: first.to_vec(),
                    second: second.to_vec(),
                }
            }
            Way::Chirp(Chirp { cyclic, .. }) => Method::Convolution {
                points: cyclic.points(),
            },
            Way::Rader(Rader { cyclic, .. }) => Method::PrimeConvolution {
                points: cyclic.points(),
            },
            Way::Other(_) => Method::ByColumn,
        }
    }

    /// Root mean square error of white noise's bins over `EPSILON sqrt(log2 N)` of them all.
    pub fn rounding(&self) -> f64 {
        match self {
            Way::Fast(_) => 0.35,
            Way::Chirp(_) | Way::Rader(_) => 0.6,
            Way::Other(_) => 1.0,
        }
    }

    /// Numbers of scratch for a tile.
    pub fn scratch_len(&self, width: usize) -> usize {
        match self {
            Way::Fast(fast) => fast.scratch_len(width),
            Way::Chirp(Chirp { cyclic, .. }) | Way::Rader(Rader { cyclic, .. }) => {
                cyclic.scratch_len(width)
            }
            Way::Other(_) => 0,
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
