//! The flux of energy of waves in a linear waveguide, and what they lose on the way.
//!
//! Of one wave half of the energy is kinetic, and its group velocity carries all of it. From velocities, a mass per length and
//! the dispersion that the same records show follows how much power passes each site, both ways, at each frequency.

mod band;
mod search;
mod sheet;

use crate::analyze::Dispersion;
use crate::error::{Error, Result};
use crate::estimates::{SIGNIFICANCE, check_significance, first_of};
use crate::field::{Field, Quantity};
use crate::measure::{LinearDensity, Measure};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::ridges::{Ridges, RidgesRequest, ridges};
use crate::system::threads::in_pool;
use crate::transform::Travelling;
use search::Search;

/// All choices of [`flux`].
#[derive(Debug, Clone, PartialEq)]
pub struct FluxRequest {
    /// Mass of a unit of length, in SI units where the field has units, at each site of a unit cell: of one for a uniform line, of two
    /// for a dimer. Empty: the flux is that of one unit of mass per length.
    pub mass_per_length: Vec<Measure<LinearDensity>>,
    /// In units of length over units of time; `None`: the slope of the wavenumbers that the waves have.
    pub group_velocity: Option<f64>,
    /// The relation that wavenumbers, and group velocities if they are not stated, follow; `None`: that of the waves.
    pub dispersion: Option<Dispersion>,
    /// Waves that there are: [`Travelling::Anywhere`] for both ways.
    pub towards: Travelling,
    /// Parts with a number each of the frequencies at which waves are found, at most.
    pub bands: usize,
    pub gaps: Gaps,
    /// Intervals hold with probability `1 - alpha`.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Default for FluxRequest {
    fn default() -> Self {
        FluxRequest {
            mass_per_length: Vec::new(),
            group_velocity: None,
            dispersion: None,
            towards: Travelling::Anywhere,
            bands: 24,
            gaps: Gaps::Refuse,
            alpha: SIGNIFICANCE,
            threads: None,
            memory: None,
        }
    }
}

/// Why no flux is stated of a band.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoFlux {
    /// Nothing stands above what one wave each way leaves, noise or another motion.
    NoWave,
    /// At an end of the array the power is not that of the waves.
    Ends,
    /// There is not one wave each way, or none of the stated relation.
    SeveralWaves,
    /// The wave decays within its length.
    Evanescent,
    /// At a frequency both directions look the same: the array is too short, or half a wavelength is the distance of sites.
    Directions,
    /// The wavenumbers do not tell the group velocity.
    Velocity,
}

/// A number with half of its interval; NaN where none is stated.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Known {
    pub value: f64,
    pub half: f64,
}

/// What a band of frequencies says.
#[derive(Debug, Clone, serde::Serialize)]
pub struct FluxBand {
    /// Ends, and the mean by power, in cycles.
    pub from: f64,
    pub to: f64,
    pub frequency: f64,
    pub reason: Option<NoFlux>,
    /// In rad; its sign is that of the wave whose energy goes towards +x.
    pub wavenumber: Known,
    pub group_velocity: Known,
    /// Loss of amplitude in Np per unit of length.
    pub attenuation: Known,
    pub loss_factor: Known,
    /// `[towards +x, towards -x, net]` of each site: power (energy).
    #[serde(skip)]
    pub flux: [Vec<Known>; 3],
}

/// What [`flux`] finds.
#[derive(Debug, Clone)]
pub struct Flux {
    /// The waves that were found, from which the search of each band starts.
    pub scan: Ridges,
    /// Unit of power, or of the energy of a transient.
    pub power_unit: String,
    pub alpha: f64,
    /// Positions of the sites of whole cells.
    pub positions: Vec<f64>,
    pub bands: Vec<FluxBand>,
    /// The same of all bands that are stated.
    pub total: [Vec<Known>; 3],
    /// Decibels per unit of length by which the larger of both totals falls.
    pub loss: Known,
    /// Share of the power of all samples, less their mean, that lies in bands with a flux.
    pub stated: f64,
}

impl Flux {
    /// The way that more goes: 0 towards +x, 1 towards -x; the site at which it enters, and the last one.
    fn larger(&self) -> (usize, [usize; 2]) {
        let largest = |way: usize| self.total[way].iter().fold(0.0, |m: f64, p| m.max(p.value));
        let last = self.positions.len() - 1;
        let way = usize::from(largest(1) > largest(0));
        (way, [[0, last], [last, 0]][way])
    }
}

/// Flux of energy of the waves of one branch, and their loss.
///
/// # Equation
/// In a band of frequencies the spectra of each record are those of two waves and of noise,
///
/// ```text
/// X(f, x) = A(f) exp(-(a + i k(f)) x) + B(f) exp(+(a + i k(f)) x),
/// ```
///
/// with one loss `a` and a wavenumber `k` that is a parabola in f, by least squares over all frequencies of the band, in which
/// the amplitudes of each are free. Then
///
/// ```text
/// v_g = 2 pi df/dk,    P(f, x) = m v_g |A|^2 exp(-2 a x) towards +x, and with B towards -x,
/// loss factor = a v_g / (pi f) = 1 / Q,
/// ```
///
/// `|A|^2` as a one-sided power (energy) spectral density of velocity, without what noise adds. The cross terms of both waves, a share
/// `a / k` of the larger flux, change sign within half a wavelength and are left out.
///
/// Of unit cells of several sites each site has amplitudes of its own with the same `a` and `k` per cell, and P is the mean over the sites. Of a
/// strain rate, `|A|^2 / k^2` is the square of the velocity.
///
/// Intervals are by the jackknife over groups of sites (noise, gains) and of frequencies or shots (noise, random powers), each of which
/// counts half in turn; the larger one of both.
///
/// # Shapes and units
/// Each field is one record of every site (a shot). P in W per cycle, J of a transient, where mass and field have units; else
/// in those of the samples' square times a velocity.
///
/// # Errors
/// [`Error::Request`] for samples that are neither velocities nor strain rates, fewer than 8 cells, and choices that do not fit; those of
/// [`ridges`].
///
/// # Source
/// L. Cremer, M. Heckl, B. Petersson, "Structure-Borne Sound" (2005), for the flux of waves and loss factors; G. H. Golub,
/// V. Pereyra, SIAM J. Numer. Anal. 10, 413 (1973), for the elimination of amplitudes; B. Efron, "The Jackknife" (1982).
pub fn flux(fields: &[&Field], request: &FluxRequest, observer: &dyn Observer) -> Result<Flux> {
    check_significance(request.alpha)?;
    Error::require(request.bands > 0, "bands", "at least one", 0)?;
    let cell = request.mass_per_length.len().max(1);
    let cells = first_of(fields)?.n_sites() / cell;
    let expected = "masses of a unit cell, of which the field has at least 8";
    Error::require(cell == 1 || cells >= 8, "mass-per-length", expected, cells)?;
    let quantity = fields[0].quantity;
    let is_known = matches!(quantity, Quantity::Velocity | Quantity::StrainRate);
    let expected = "velocities or strain rates";
    Error::require(is_known, "quantity", expected, quantity.in_words())?;
    let scan = |segment| {
        let request = RidgesRequest {
            segment,
            gaps: request.gaps,
            threads: request.threads,
            memory: request.memory,
            ..RidgesRequest::default()
        };
        ridges(fields, &request, observer)
    };
    let mut found = scan(None)?;
    // A transient is seen best whole.
    if found.independence.is_transient() {
        found = scan(Some(fields[0].n_times()))?;
    }
    let law = request.dispersion.as_ref();
    let law = law.map(|law| law.on(&found.analysis.axes)).transpose()?;
    in_pool(request.threads, || {
        Ok(Search::new(fields, request, &found, law, observer)?.run())
    })
}

impl Known {
    const NONE: Known = Known {
        value: f64::NAN,
        half: f64::NAN,
    };

    fn times(self, factor: f64) -> Known {
        Known {
            value: factor * self.value,
            half: factor.abs() * self.half,
        }
    }
}
