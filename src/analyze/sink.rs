//! Where the large arrays go, block by block.

use std::collections::BTreeMap;
use std::sync::Mutex;

use ndarray::{Array2, ArrayView2, s};

use crate::error::Result;

/// An array too large to be held twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LargeArray {
    /// `(frequency, site)`
    TemporalSpectrum,
    /// `(time, wavenumber)`
    SpatialSpectrum,
    /// `(frequency, signed wavenumber)`
    SpacetimeSpectrum,
    /// `(time, wavenumber)`
    KineticFluxSurrogate,
    /// `e_j(t)`, `(time, site)`
    SiteEnergy,
    /// `J_j(t)`, `(time, contact)`
    EnergyFlux,
    /// `W_j(t)`, `(time, contact)`
    EnergyPassed,
    /// Energy lost at each site since the first sample, `(time, site)`
    EnergyLost,
    /// `E(k, t)`, `(time, wavenumber)`
    EnergySpectrum,
    /// `T(k, t)`, `(time, wavenumber)`
    Transfer,
    /// `L(k, t)`, `(time, wavenumber)`
    LossSpectrum,
    /// Spectrum of the power put in at a driven end, `(time, wavenumber)`
    InputSpectrum,
    /// `Pi(k, t)`, `(time, wavenumber)`
    SpectralFlux,
    /// `Pi(k, t)` integrated since the first sample, `(time, wavenumber)`
    IntegratedSpectralFlux,
    /// Acoustic part of `E(k, t)`, `(time, wavenumber of the cell)`
    AcousticSpectrum,
    /// Optical part of `E(k, t)`, `(time, wavenumber of the cell)`
    OpticalSpectrum,
    /// `P_j(f)`, `(frequency, contact)`
    PowerFlow,
    /// Energy that passed each contact up to a frequency, `(frequency, contact)`
    CumulativePowerFlow,
    /// `Pi_l,j(t)` at one scale, `(time, contact)`
    ScaleFlux,
    /// `Pi_l` summed over contacts, `(time, scale)`
    ScaleFluxInTime,
}

impl LargeArray {
    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            LargeArray::TemporalSpectrum => "temporal_spectrum",
            LargeArray::SpatialSpectrum => "spatial_spectrum",
            LargeArray::SpacetimeSpectrum => "spacetime_spectrum",
            LargeArray::KineticFluxSurrogate => "kinetic_flux_surrogate",
            LargeArray::SiteEnergy => "site_energy",
            LargeArray::EnergyFlux => "energy_flux",
            LargeArray::EnergyPassed => "energy_passed",
            LargeArray::EnergyLost => "energy_lost",
            LargeArray::EnergySpectrum => "energy_spectrum",
            LargeArray::Transfer => "transfer",
            LargeArray::LossSpectrum => "loss_spectrum",
            LargeArray::InputSpectrum => "input_spectrum",
            LargeArray::SpectralFlux => "spectral_flux",
            LargeArray::IntegratedSpectralFlux => "integrated_spectral_flux",
            LargeArray::AcousticSpectrum => "acoustic_spectrum",
            LargeArray::OpticalSpectrum => "optical_spectrum",
            LargeArray::PowerFlow => "power_flow",
            LargeArray::CumulativePowerFlow => "cumulative_power_flow",
            LargeArray::ScaleFlux => "scale_flux",
            LargeArray::ScaleFluxInTime => "scale_flux_in_time",
        }
    }

    /// What its rows and columns count.
    pub fn axes(self) -> [&'static str; 2] {
        match self {
            LargeArray::TemporalSpectrum => ["frequency", "site"],
            LargeArray::SpatialSpectrum
            | LargeArray::KineticFluxSurrogate
            | LargeArray::EnergySpectrum
            | LargeArray::Transfer
            | LargeArray::LossSpectrum
            | LargeArray::InputSpectrum
            | LargeArray::SpectralFlux
            | LargeArray::IntegratedSpectralFlux => ["time", "wavenumber"],
            LargeArray::SpacetimeSpectrum => ["frequency", "wavenumber"],
            LargeArray::SiteEnergy | LargeArray::EnergyLost => ["time", "site"],
            LargeArray::EnergyFlux | LargeArray::EnergyPassed | LargeArray::ScaleFlux => {
                ["time", "contact"]
            }
            LargeArray::AcousticSpectrum | LargeArray::OpticalSpectrum => {
                ["time", "wavenumber of the cell"]
            }
            LargeArray::PowerFlow | LargeArray::CumulativePowerFlow => ["frequency", "contact"],
            LargeArray::ScaleFluxInTime => ["time", "scale"],
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
    pub(crate) fn from(mut arrays: Arrays) -> Spectra {
        Spectra {
            temporal: arrays.remove(&LargeArray::TemporalSpectrum),
            spatial: arrays.remove(&LargeArray::SpatialSpectrum),
            spacetime: arrays.remove(&LargeArray::SpacetimeSpectrum),
            flux_surrogate: arrays.remove(&LargeArray::KineticFluxSurrogate),
        }
    }
}

/// Large arrays in memory.
pub type Arrays = BTreeMap<LargeArray, Array2<f64>>;

/// Collects [`Arrays`].
#[derive(Debug, Default)]
pub(crate) struct Collect(Mutex<Arrays>);

impl Collect {
    pub fn into_arrays(self) -> Arrays {
        self.0
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Arrays> {
        self.0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Sink for Collect {
    fn reserve(&self, array: LargeArray, shape: (usize, usize)) -> Result<()> {
        self.lock().insert(array, Array2::zeros(shape));
        Ok(())
    }

    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()> {
        if let Some(whole) = self.lock().get_mut(&array) {
            let (rows, columns) = block.dim();
            whole
                .slice_mut(s![row..row + rows, column..column + columns])
                .assign(&block);
        }
        Ok(())
    }
}

/// A sink that keeps nothing, for results without their large arrays.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nowhere;

impl Sink for Nowhere {
    fn reserve(&self, _: LargeArray, _: (usize, usize)) -> Result<()> {
        Ok(())
    }

    fn put(&self, _: LargeArray, _: usize, _: usize, _: ArrayView2<f64>) -> Result<()> {
        Ok(())
    }
}
