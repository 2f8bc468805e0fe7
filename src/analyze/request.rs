//! The request: every choice of an analysis, as data.

use smart_default::SmartDefault;

use super::dispersion::Dispersion;
use super::display::Show;
use crate::arrays::Precision;
use crate::prepare::{Detrend, Gaps, Preparation, Window};
use crate::transform::{Scaling, Segments};

/// Which results to compute; only the transforms these need are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Results {
    /// `S(f, x)` and the redistribution along x drawn from it.
    pub temporal: bool,
    /// `S(k, t)` and the redistribution along t drawn from it.
    pub spatial: bool,
    /// `S(k, f)` and the share of energy in each direction.
    pub spacetime: bool,
    /// The kinetic flux surrogate `Pi_K(k, t)`.
    pub flux_surrogate: bool,
    /// Short-time spectra of chosen sites and of chosen times.
    pub short_time: bool,
    /// What moved in frequency along x, and in wavenumber in time.
    pub answer: bool,
}

impl Results {
    pub const ALL: Results = Results::each(true);
    pub const NONE: Results = Results::each(false);

    const fn each(is_wanted: bool) -> Results {
        Results {
            temporal: is_wanted,
            spatial: is_wanted,
            spacetime: is_wanted,
            flux_surrogate: is_wanted,
            short_time: is_wanted,
            answer: is_wanted,
        }
    }
}

/// Which part of the record is analyzed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TimeRange {
    #[default]
    All,
    /// Times `from <= t <= to`, in the units of the time axis.
    Interval { from: f64, to: f64 },
    /// From the first time to the last one before `|v|` at the last site first exceeds
    /// `threshold` times the largest `|v|` of the field, so that reflections stay out.
    UntilArrival { threshold: f64 },
}

/// Welch's method: averaged periodograms of overlapping segments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Welch {
    /// Samples a segment.
    pub segment: usize,
    /// Samples that two neighbouring segments share.
    pub overlap: usize,
}

/// Short-time spectra: where, and with which segments.
#[derive(Debug, Clone, PartialEq, SmartDefault)]
pub struct ShortTime {
    /// Sites whose records are followed; empty: the first, the middle and the last one.
    pub sites: Vec<usize>,
    /// Times whose profiles are followed along x, in the units of the time axis; may be empty.
    pub times: Vec<f64>,
    /// Samples a segment along time; `None` chooses a power of two near an eighth of the record.
    pub segment: Option<usize>,
    /// Samples between segments along time; `None`: a quarter of the segment.
    pub hop: Option<usize>,
    /// Sites a segment along x; `None` chooses as for the time.
    pub segment_space: Option<usize>,
    /// Sites between segments along x; `None`: a quarter of the segment.
    pub hop_space: Option<usize>,
    #[default(Window::USUAL)]
    pub window: Window,
}

/// All choices of an analysis. The default removes nothing, tapers nothing, and computes all
/// results.
#[derive(Debug, Clone, PartialEq, SmartDefault)]
pub struct Request {
    #[default(Results::ALL)]
    pub results: Results,
    /// Sites analyzed, the end excluded.
    pub sites: Option<std::ops::Range<usize>>,
    /// Sites of the file that are left out: their spectra are NaN. What needs sites at even distances cannot be
    /// computed then: [`Results::spatial`], [`Results::spacetime`], [`Results::flux_surrogate`], short-time spectra
    /// along x.
    pub without_sites: Vec<usize>,
    pub times: TimeRange,
    pub gaps: Gaps,
    /// Removes the mean over all samples first.
    pub detrend_field_mean: bool,
    /// Removes from each instant's profile; `Mean` removes the common mode.
    pub detrend_space: Detrend,
    /// Removes from each site's record, and again from each segment where Welch is used.
    pub detrend_time: Detrend,
    pub window_time: Window,
    pub window_space: Window,
    pub scaling: Scaling,
    pub welch: Option<Welch>,
    /// Length that each record (or segment) is padded to with zeros.
    pub pad_time: Option<usize>,
    /// Length that each profile is padded to with zeros.
    pub pad_space: Option<usize>,
    /// Site that sets the frequency band edge. `None`: of a simulated run the first body behind the one
    /// that is struck or driven; of a field, the first site with at least a tenth of the largest energy.
    pub reference_site: Option<usize>,
    /// Time that sets the wavenumber band edge. `None`: of a simulated run the time at which the front has
    /// passed ten sites (a quarter of the chain if that is less); of a field, the first time with at
    /// least a tenth of the largest energy.
    pub reference_time: Option<f64>,
    /// Band edge in cycles per time unit; overrides the reference site.
    pub band_edge_frequency: Option<f64>,
    /// Band edge in rad per length unit; overrides the reference time.
    pub band_edge_wavenumber: Option<f64>,
    /// Length, in units of time, of the windows over which shares at the front's passage are taken;
    /// `None`: ten times the width at half maximum of the pulse at the reference site.
    pub front_window: Option<f64>,
    /// Whether the sites are those of a periodic box: the last one is beside the first. All of the motion is inside then.
    pub periodic: bool,
    /// Moved shares below this count as none; `None`: [`TOLERANCE`](crate::moved::TOLERANCE).
    pub least_move: Option<f64>,
    /// Root mean square of the noise in the samples, where it is known: sites and times whose energy
    /// is not at least twice the noise's are undefined.
    pub noise: Option<f64>,
    /// Subtract the noise of each site from its spectrum along time, and from the measures of it; not where
    /// [`Results::spacetime`] is wanted. Front windows and short-time spectra keep it.
    pub subtract_noise: bool,
    /// Frequencies `[from, to]` over which directions are summed; `None`: all.
    pub direction_band: Option<(f64, f64)>,
    /// Dispersion relations that `S(k, f)` is held against; `None`: the one that the field states
    /// ([`Field::dispersion`](crate::Field::dispersion)), if any.
    pub dispersion: Option<Vec<Dispersion>>,
    pub short_time: ShortTime,
    /// Whether arrays are also reduced to [maps](super::Map); without them there are neither figures of
    /// arrays nor heat maps in the report.
    #[default = true]
    pub maps: bool,
    /// Which part of each axis figures and report show at first.
    pub show: Show,
    pub precision: Precision,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Request {
    /// The preparation of the samples before transforms along time in `segments`.
    pub(crate) fn preparation(&self, segments: Segments) -> Preparation<'_> {
        let results = self.results;
        let is_cut = results.temporal || results.spacetime;
        Preparation {
            reached: segments.record - usize::from(is_cut) * segments.left_over(),
            transforms_all: results.spatial || results.flux_surrogate || results.short_time,
            gaps: self.gaps,
            masks_by_mean: false,
            left_out: &self.without_sites,
            precision: self.precision,
            detrend_field_mean: self.detrend_field_mean,
            detrend_space: self.detrend_space,
            detrend_time: self.detrend_time,
        }
    }
}
