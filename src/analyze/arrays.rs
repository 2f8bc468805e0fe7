//! The large arrays of an analysis.

use ndarray::Array2;

use crate::arrays::{Arrays, LargeArray};

/// Arrays of an analysis.
impl LargeArray {
    /// `(frequency, site)`
    pub const TEMPORAL_SPECTRUM: LargeArray =
        LargeArray::new("temporal_spectrum", ["frequency", "position"]);
    /// `(time, wavenumber)`
    pub const SPATIAL_SPECTRUM: LargeArray =
        LargeArray::new("spatial_spectrum", ["time", "wavenumber"]);
    /// `(frequency, signed wavenumber)`
    pub const SPACETIME_SPECTRUM: LargeArray =
        LargeArray::new("spacetime_spectrum", ["frequency", "wavenumber_signed"]);
    /// `(time, wavenumber)`
    pub const KINETIC_FLUX_SURROGATE: LargeArray =
        LargeArray::new("kinetic_flux_surrogate", ["time", "wavenumber"]);
}

/// The large arrays in memory; `None` if not requested.
#[derive(Debug, Clone, Default)]
pub struct Spectra {
    /// `S(f, x)`, `(frequency, site)`, one-sided.
    pub temporal: Option<Array2<f64>>,
    /// `S(k, t)`, `(time, wavenumber)`, one-sided.
    pub spatial: Option<Array2<f64>>,
    /// `S(k, f)`, `(frequency, signed wavenumber)`, one-sided in f.
    pub spacetime: Option<Array2<f64>>,
    /// `Pi_K(k, t)`, `(time, wavenumber)`.
    pub flux_surrogate: Option<Array2<f64>>,
}

impl Spectra {
    pub(crate) fn from(mut arrays: Arrays) -> Spectra {
        Spectra {
            temporal: arrays.remove(&LargeArray::TEMPORAL_SPECTRUM),
            spatial: arrays.remove(&LargeArray::SPATIAL_SPECTRUM),
            spacetime: arrays.remove(&LargeArray::SPACETIME_SPECTRUM),
            flux_surrogate: arrays.remove(&LargeArray::KINETIC_FLUX_SURROGATE),
        }
    }
}
