//! SIMD lanes, sums, the logarithm, angles, random numbers, roots.

mod angle;
mod golden;
pub(crate) mod lanes;
mod logarithm;
mod random;
pub(crate) mod root;
mod sums;

pub(crate) use angle::*;
pub(crate) use golden::GoldenSection;
pub(crate) use logarithm::ln_normal;
pub(crate) use random::{Random, split_mix, unit_interval};
pub(crate) use root::between as find_root;
pub(crate) use sums::*;
