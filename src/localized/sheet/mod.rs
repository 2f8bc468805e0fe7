//! Localized waves as results that describe themselves: the table of orders, one wave, its travel.

mod journey;
mod orders;
mod wave;

pub use orders::Orders;
pub use wave::Profile;

use super::{Alternation, Ratio};

/// Digits of a ratio after the point.
const DIGITS: usize = 12;

const LOCALIZED: [&str; 2] = [
    "localized wave",
    "A pulse that travels along a dimer chain and leaves no energy behind. It exists at isolated ratios, which its order \
     counts from the homogeneous chain on.",
];
const TIME: [&str; 2] = [
    "time in cells",
    "The unit of time is what the wave takes over a cell of two contacts.",
];
const PSI: [&str; 2] = [
    "ψ",
    "psi in archives: F^(1/p), with F the force of a contact and p the exponent of its law.",
];

impl Alternation {
    /// The two contacts of a cell.
    fn contacts(self) -> [&'static str; 2] {
        match self {
            Alternation::Stiffness => ["soft contact", "stiff contact"],
            Alternation::Mass => ["before the light site", "behind it"],
        }
    }
}

impl Ratio {
    fn name(self) -> &'static str {
        match self {
            Ratio::Kappa(_) => "stiffness ratio",
            Ratio::MassRatio(_) => "mass ratio",
        }
    }
}
