//! The large arrays of budgets.

use crate::arrays::LargeArray;

/// Arrays of budgets.
impl LargeArray {
    /// `e_j(t)`, `(time, site)`
    pub const SITE_ENERGY: LargeArray = LargeArray::new("site_energy", ["time", "position"]);
    /// `J_j(t)`, `(time, contact)`
    pub const ENERGY_FLUX: LargeArray =
        LargeArray::new("energy_flux", ["time", "contact_position"]);
    /// `W_j(t)`, `(time, contact)`
    pub const ENERGY_PASSED: LargeArray =
        LargeArray::new("energy_passed", ["time", "contact_position"]);
    /// Energy lost at each site since the first sample, `(time, site)`
    pub const ENERGY_LOST: LargeArray = LargeArray::new("energy_lost", ["time", "position"]);
    /// `E(k, t)`, `(time, wavenumber)`
    pub const ENERGY_SPECTRUM: LargeArray =
        LargeArray::new("energy_spectrum", ["time", "wavenumber"]);
    /// `T(k, t)`, `(time, wavenumber)`
    pub const TRANSFER: LargeArray = LargeArray::new("transfer", ["time", "wavenumber"]);
    /// `L(k, t)`, `(time, wavenumber)`
    pub const LOSS_SPECTRUM: LargeArray = LargeArray::new("loss_spectrum", ["time", "wavenumber"]);
    /// Spectrum of the power put in at a driven end, `(time, wavenumber)`
    pub const INPUT_SPECTRUM: LargeArray =
        LargeArray::new("input_spectrum", ["time", "wavenumber"]);
    /// `Pi(k, t)`, `(time, wavenumber)`
    pub const SPECTRAL_FLUX: LargeArray = LargeArray::new("spectral_flux", ["time", "wavenumber"]);
    /// `Pi(k, t)` integrated since the first sample, `(time, wavenumber)`
    pub const INTEGRATED_SPECTRAL_FLUX: LargeArray =
        LargeArray::new("integrated_spectral_flux", ["time", "wavenumber"]);
    /// Acoustic part of `E(k, t)`, `(time, wavenumber of the cell)`
    pub const ACOUSTIC_SPECTRUM: LargeArray =
        LargeArray::new("acoustic_spectrum", ["time", "cell_wavenumber"]);
    /// Optical part of `E(k, t)`, `(time, wavenumber of the cell)`
    pub const OPTICAL_SPECTRUM: LargeArray =
        LargeArray::new("optical_spectrum", ["time", "cell_wavenumber"]);
    /// `E_k(t)` of the normal modes, `(time, mode)`
    pub const MODE_ENERGY: LargeArray = LargeArray::new("mode_energy", ["time", "mode_frequency"]);
    /// `P_j(f)`, `(frequency, contact)`
    pub const POWER_FLOW: LargeArray =
        LargeArray::new("power_flow", ["frequency", "contact_position"]);
    /// Energy that passed each contact up to a frequency, `(frequency, contact)`
    pub const CUMULATIVE_POWER_FLOW: LargeArray =
        LargeArray::new("cumulative_power_flow", ["frequency", "contact_position"]);
    /// `Pi_l,j(t)` at one scale, `(time, contact)`
    pub const SCALE_FLUX: LargeArray = LargeArray::new("scale_flux", ["time", "contact_position"]);
    /// `Pi_l` summed over contacts, `(time, scale)`
    pub const SCALE_FLUX_IN_TIME: LargeArray =
        LargeArray::new("scale_flux_in_time", ["time", "scale"]);
}
