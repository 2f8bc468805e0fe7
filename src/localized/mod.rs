//! Localized waves: pulses that travel along a dimer chain and leave no energy behind.
//!
//! The unit of time is the travel time over one cell (two contacts), `h = 1/2`, and `psi = F^{1/p}`
//! for the contact force F. A travelling wave of the stiffness dimer solves
//!
//! ```text
//! S''(t)       = P(t+h)^p + P(t-h)^p - 2 S(t)^p         soft contacts
//! eps P''(t)   = S(t+h)^p + S(t-h)^p - 2 P(t)^p         stiff contacts, eps = kappa^{-1/p}
//! ```
//!
//! and one of the mass dimer (masses 1 and mu; `a` and `b` are the contacts before and after the
//! light site)
//!
//! ```text
//! a''(t) = b(t+h)^p + b(t-h)^p / mu - (1 + 1/mu) a(t)^p,    b(t) = a(-t).
//! ```
//!
//! Solutions that decay on both sides exist at isolated ratios only. [`Search::wave`] solves for
//! the wave of a given order, with the ratio as an unknown. [`Family::estimates`] gives asymptotic
//! estimates: a fast oscillation driven by the slow wave. [`LeakScan`] measures the energy loss of
//! a pulse per cell on simulated chains, and its minima and maxima. [`Comparison`] tabulates all of
//! these, with the angles of crossed cylinders. [`Wave::journey`] starts a chain with a wave.
//!
//! Sources: J. M. English, R. L. Pego, *On the solitary wave pulse in a chain of beads*, Proc.
//! AMS 133 (2005) 1763 (the equation as a convolution); K. R. Jayaprakash, Y. Starosvetsky,
//! A. F. Vakakis, *New family of solitary waves in granular dimer chains with no precompression*,
//! Phys. Rev. E 83 (2011) 036606 (slow and fast parts, mass ratios).

mod angle;
mod comparison;
mod direct;
mod equations;
mod family;
mod fast;
mod launch;
mod leak;
mod problem;
mod published;
mod resolve;
mod row;
mod search;
mod series;
mod sheet;
mod slow;
mod vertex;
mod wave;

pub use angle::{Angle, Cylinders};
pub use comparison::{Comparison, LARGEST_ORDER};
pub use direct::{LeakCurve, LeakExtremum};
pub use family::Family;
pub use launch::{Journey, Travel};
pub use leak::{Leak, LeakScan, REACH, minima};
pub use published::{PUBLISHED, Published};
pub use row::{Asymptotic, Differences, Direct, Exact, OrderRow};
pub use search::Search;
pub use series::Series;
pub use sheet::{Orders, Profile};
pub use slow::SlowWave;
pub use wave::{Alternation, Convergence, Ratio, Snapshot, Wave};
