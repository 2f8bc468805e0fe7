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

mod adaptive;
mod averaging;
mod bicoherence;
mod bicoherence_along;
mod breaks;
mod coherence;
mod delay;
mod ensemble;
mod gram;
mod hermitian;
mod increment_result;
mod increment_sums;
mod increments;
mod interval;
mod least_squares;
mod lines;
mod lomb;
mod mean_spectrum;
mod mode_shapes;
mod modes;
mod moments;
mod phase;
mod shots;
mod slope;
mod slope_frames;
mod snapshots;
mod spectra;
mod spectrum;
mod spectrum_pass;
mod steepening;
mod transfer;
mod transfer_fit;
mod transfer_found;
mod triples;

pub use averaging::{Averaging, Tapers};
pub use bicoherence::{
    Bicoherence, BicoherenceMap, BicoherenceRequest, CoupledTriple, bicoherence,
};
pub use bicoherence_along::BicoherenceAlong;
pub use breaks::BreakFit;
pub use coherence::{Coherence, CoherenceRequest, coherence};
pub use delay::Delay;
pub use ensemble::Independence;
pub use increment_result::{
    AxisIncrements, ExponentBasis, IncrementHistogram, Increments, IncrementsRequest,
    IntervalBasis, ScaleMoments, ScalingExponents,
};
pub use increment_sums::FieldAxis;
pub use increments::increments;
pub use interval::{SpectrumInterval, interval_factors};
pub use least_squares::LineFit;
pub use lines::Line;
pub use lomb::{Lomb, LombAxis, LombRequest, lomb};
pub use mean_spectrum::MeanSpectrum;
pub use mode_shapes::{ModeShapes, ModeWave};
pub use modes::{Modes, ModesRequest, modes};
pub use phase::PhaseSpeed;
pub(crate) use shots::first_of;
pub use slope::{PowerLaw, Slope, SlopeRequest, slope};
pub use slope_frames::SlopeFrames;
pub use spectrum::{
    LeftOutEach, LineTest, SpectrumAxis, SpectrumEstimate, SpectrumRequest, spectrum,
};
pub use steepening::Steepening;
pub use transfer::{TransferRequest, transfer};
pub use transfer_found::{OutputTransfer, PairTransfer, Transfer, TransferShares};
