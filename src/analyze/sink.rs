//! Where the large arrays go, block by block.

use std::sync::Mutex;

use ndarray::{Array2, ArrayView2, s};

use crate::error::Result;

/// An array too large to be held twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LargeArray {
    /// `(frequency, site)`
    TemporalSpectrum,
    /// `(time, wavenumber)`
    SpatialSpectrum,
    /// `(frequency, signed wavenumber)`
    SpacetimeSpectrum,
    /// `(time, wavenumber)`
    KineticFluxSurrogate,
}

impl LargeArray {
    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            LargeArray::TemporalSpectrum => "temporal_spectrum",
            LargeArray::SpatialSpectrum => "spatial_spectrum",
            LargeArray::SpacetimeSpectrum => "spacetime_spectrum",
            LargeArray::KineticFluxSurrogate => "kinetic_flux_surrogate",
        }
    }
}

/// Takes the large arrays in blocks: memory ([`Spectra`]) or a file ([`crate::report::Archive`]).
pub trait Sink: Sync {
    /// Announces an array and its shape, before its first block.
    ///
    /// # Errors
    /// If there is no room for it.
    fn reserve(&self, array: LargeArray, shape: (usize, usize)) -> Result<()>;

    /// Takes the block whose first element is `(row, column)`.
    ///
    /// # Errors
    /// If it cannot be written.
    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()>;
}

/// The large arrays in memory; `None` where not asked for.
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
    fn slot(&mut self, array: LargeArray) -> &mut Option<Array2<f64>> {
        match array {
            LargeArray::TemporalSpectrum => &mut self.temporal,
            LargeArray::SpatialSpectrum => &mut self.spatial,
            LargeArray::SpacetimeSpectrum => &mut self.spacetime,
            LargeArray::KineticFluxSurrogate => &mut self.flux_surrogate,
        }
    }
}

/// Collects [`Spectra`].
#[derive(Debug, Default)]
pub(crate) struct Collect(Mutex<Spectra>);

impl Collect {
    pub fn into_spectra(self) -> Spectra {
        self.0
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Spectra> {
        self.0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Sink for Collect {
    fn reserve(&self, array: LargeArray, shape: (usize, usize)) -> Result<()> {
        *self.lock().slot(array) = Some(Array2::zeros(shape));
        Ok(())
    }

    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()> {
        if let Some(whole) = self.lock().slot(array) {
            let (rows, columns) = block.dim();
            whole
                .slice_mut(s![row..row + rows, column..column + columns])
                .assign(&block);
        }
        Ok(())
    }
}
