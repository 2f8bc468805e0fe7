//! Estimates that are averaged over realisations: segments of records, orthogonal tapers, repeated
//! records.
//!
//! A realisation is one transform of one segment, of one record, under one taper. An average over
//! realisations has degrees of freedom, and so intervals and levels of significance. They hold for
//! stationary records and for independent repetitions; the segments of one transient are not
//! independent, and then no significance is stated ([`Independence`]).
//!
//! Source: P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 70 (1967); D. J. Thomson, Proc. IEEE 70,
//! 1055 (1982); J. S. Bendat, A. G. Piersol, "Random Data", 4th ed. (2010), chapters 8, 9 and 11.

mod averaging;
mod coherence;
mod delay;
mod ensemble;
mod phase;
mod shots;

pub use averaging::{Averaging, Tapers};
pub use coherence::{Coherence, CoherenceRequest, coherence};
pub use delay::Delay;
pub use ensemble::Independence;
pub use phase::PhaseSpeed;
