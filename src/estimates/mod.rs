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

mod coherence;
mod coupling;
mod increments;
mod modes;
mod parts;
pub(crate) mod realisations;
mod slope;
mod spacetime;
mod spectrum;

pub use crate::numeric::LineFit;
pub use coherence::{Coherence, CoherenceRequest, Delay, PhaseSpeed, WaveVelocity, coherence};
pub use coupling::{
    Bicoherence, BicoherenceAlong, BicoherenceMap, BicoherenceRequest, CoupledTriple,
    OutputTransfer, PairTransfer, Transfer, TransferRequest, TransferShares, bicoherence, transfer,
};
pub use increments::{
    AxisIncrements, IncrementHistogram, Increments, IncrementsRequest, IntervalBasis, ScaleMoments,
    ScalingExponents, increments,
};
pub use modes::{ModeShapes, ModeWave, Modes, ModesRequest, modes};
pub use parts::{
    BlockPlace, Combination, Combined, DividedRequest, Outline, Partial, PartialAbout, combine,
    join, outline, partial, partial_of_block,
};
pub use realisations::{
    Averaging, Grid, Independence, Part, SIGNIFICANCE, SegmentsLeft, SpectrumInterval, Tapers,
    interval_factors,
};
pub(crate) use realisations::{check_significance, first_of};
pub use slope::{BreakFit, PowerLaw, Slope, SlopeFrames, SlopeRequest, Steepening, slope};
pub use spacetime::{SpaceTimeEstimate, SpaceTimeRequest, spacetime};
pub(crate) use spectrum::no_noise;
pub use spectrum::{
    LeftOutEach, Line, LineTest, MeanSpectrum, NoiseFloor, NoiseSource, Peak, SiteNoise,
    SpectrumEstimate, SpectrumRequest, SubtractedNoise, spectrum,
};

/// The axis of a field along which something is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FieldAxis {
    /// Of snapshots: over wavenumbers, or separations.
    Space,
    /// Of the records of sites: over frequencies, or lags.
    #[default]
    Time,
}

impl FieldAxis {
    /// The one of this axis, of one along x and one in time.
    pub(crate) fn of<T>(self, [space, time]: [T; 2]) -> T {
        match self {
            FieldAxis::Space => space,
            FieldAxis::Time => time,
        }
    }
}
