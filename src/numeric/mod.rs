//! SIMD lanes, sums, integrals, derivatives, the logarithm, angles, bins of bands, random numbers, roots, medians,
//! quantiles, Fresnel integrals, lines through points, small systems of equations, complex least squares, eigenvalues of Hermitian matrices.

use std::ops::Range;

mod angle;
mod bins;
mod fresnel;
mod golden;
pub(crate) mod gram;
pub(crate) mod hermitian;
mod integral;
mod jet;
pub(crate) mod lanes;
mod least_squares;
mod logarithm;
mod order;
mod quantile;
mod random;
pub(crate) mod root;
mod sums;

pub(crate) use angle::*;
pub(crate) use bins::*;
pub(crate) use fresnel::*;
pub(crate) use golden::*;
pub(crate) use integral::*;
pub use jet::{Jet, Real};
pub use least_squares::LineFit;
pub(crate) use least_squares::*;
pub(crate) use logarithm::*;
pub(crate) use order::*;
pub(crate) use quantile::*;
pub(crate) use random::*;
pub(crate) use root::between as find_root;
pub(crate) use sums::*;

/// `0..all` in pieces of `most`; the last may be shorter.
pub(crate) fn pieces(all: usize, most: usize) -> impl Iterator<Item = Range<usize>> {
    let starts = (0..all).step_by(most);
    starts.map(move |from| from..all.min(from + most))
}
