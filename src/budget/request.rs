//! Options of a budget.

use std::ops::Range;

use super::filter::Filter;
use super::motion::Motion;
use super::result::Integration;
use super::units::BudgetUnits;
use crate::error::{Error, Result};

/// Which views of the energy are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Views {
    pub wavenumber: bool,
    pub frequency: bool,
    pub scale: bool,
}

impl Views {
    pub const ALL: Views = Views {
        wavenumber: true,
        frequency: true,
        scale: true,
    };
}

/// The options of a budget. The real-space balance is always computed.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetRequest {
    pub views: Views,
    /// Energy by normal mode, and its entropy.
    pub normal_modes: bool,
    pub filter: Filter,
    /// Coarse-graining scales, in units of length; empty: geometrically spaced from two cells up to
    /// the longest that fits the chain.
    pub scales: Vec<f64>,
    /// The scale whose flux is saved for each contact; `None`: the middle one.
    pub map_scale: Option<f64>,
    /// Distance of neighbouring sites.
    pub pitch: f64,
    pub units: BudgetUnits,
    /// Upper edge of the low band, in cycles per unit of time; `None`: the frequency that bounds 90
    /// % of the energy of the force in the first contact with a nonzero force.
    pub band_edge_frequency: Option<f64>,
    /// Upper edge of the low band, in rad per unit of length; `None`: the wavenumber that bounds 90
    /// % of the energy at the first sample with energy.
    pub band_edge_wavenumber: Option<f64>,
    /// Pairs of contacts whose power flows are compared.
    pub between: Vec<[usize; 2]>,
    /// Samples and sites over which the real-space balance is checked; `None`: all.
    pub window: Option<[Range<usize>; 2]>,
    /// How rates are integrated over time for the balances.
    pub integration: Integration,
    /// Worker threads; `None`: one per core. The results do not depend on it.
    pub threads: Option<usize>,
}

impl Default for BudgetRequest {
    fn default() -> Self {
        BudgetRequest {
            views: Views::ALL,
            normal_modes: false,
            filter: Filter::Gaussian,
            scales: Vec::new(),
            map_scale: None,
            pitch: 1.0,
            units: BudgetUnits::default(),
            band_edge_frequency: None,
            band_edge_wavenumber: None,
            between: Vec::new(),
            window: None,
            integration: Integration::Samples,
            threads: None,
        }
    }
}

impl BudgetRequest {
    /// # Errors
    /// [`Error::Request`] for the option that does not fit the motion.
    pub(super) fn check(&self, motion: &Motion) -> Result<()> {
        let (length, edge) = ("a positive length", "0 or more");
        for (option, value, expected) in [
            ("pitch", Some(self.pitch), length),
            ("map-scale", self.map_scale, length),
            ("band-edge-frequency", self.band_edge_frequency, edge),
            ("band-edge-wavenumber", self.band_edge_wavenumber, edge),
        ] {
            let fits = |value: f64| value > 0.0 || (value == 0.0 && expected == edge);
            if let Some(value) = value.filter(|value| !(value.is_finite() && fits(*value))) {
                return Err(Error::request(option, expected, value));
            }
        }
        let contacts = motion.chain.n_contacts();
        let outside = |pair: &&[usize; 2]| pair.iter().any(|j| *j >= contacts);
        if let Some([a, b]) = self.between.iter().find(outside) {
            let expected = format!("contacts 0 to {}", contacts.saturating_sub(1));
            return Err(Error::request("between", expected, format!("{a}:{b}")));
        }
        let lengths = [motion.samples(), motion.chain.n_sites()];
        for (window, length) in self.window.iter().flatten().zip(lengths) {
            if window.start >= window.end || window.end > length {
                let expected = format!("FIRST:END within 0:{length}");
                let found = format!("{}:{}", window.start, window.end);
                return Err(Error::request("window", expected, found));
            }
        }
        Ok(())
    }
}
