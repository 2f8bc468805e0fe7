//! Coherence, phase and delay of all sites against a reference.

mod delay;
mod pass;
mod phase;
mod products;
mod sheet;
mod significance;
mod velocity;

pub use delay::Delay;
pub use phase::PhaseSpeed;
pub use velocity::WaveVelocity;

use std::ops::Range;

use ndarray::Array2;

use crate::error::Result;
use crate::estimates::SIGNIFICANCE;

use crate::estimates::realisations::{
    Averaging, Grid, Independence, Realisations, SegmentsLeft, Shots, check_count, first_of,
    level_of_chance, phase_spread,
};
use crate::field::{Axis, Field};
use crate::numeric::median;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;
use delay::DelaySearch;

use phase::{Phases, least_coherence};
use significance::is_own;
use velocity::Slowness;

/// Error of the distance between a bin and the frequency whose power it has, as a share of it.
const OF_LEAKAGE: f64 = 0.25;

/// Energy of the waves one way less that of those the other way, over both, from which on they are said to go one way: three quarters of it do.
const ONE_WAY: f64 = 0.5;

/// All choices of [`coherence`].
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CoherenceRequest {
    /// Index of the site that all others are compared with.
    pub reference: usize,
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// Probability by which the level of significance is exceeded by chance.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    #[serde(skip)]
    pub memory: Option<u64>,
}

impl Default for CoherenceRequest {
    fn default() -> Self {
        CoherenceRequest {
            reference: 0,
            averaging: Averaging::default(),
            gaps: Gaps::Refuse,
            alpha: SIGNIFICANCE,
            threads: None,
            memory: None,
        }
    }
}

/// What [`coherence`] finds. Arrays are `(frequency, site)`.
#[derive(Debug, Clone)]
pub struct Coherence {
    /// Frequencies in cycles per unit of time.
    pub frequency: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Index of the reference.
    pub reference: usize,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    /// Of the site with the median number of segments, where segments with missing samples are left out.
    pub independence: Independence,
    /// What is left of each site with the reference, where segments in which either misses samples are left out;
    /// `None` with other [`CoherenceRequest::gaps`].
    pub segments_left: Option<SegmentsLeft>,
    pub alpha: f64,
    /// Bands of frequencies, and the independent realisations of each site with the reference there: fewer than those of
    /// [`Self::independence`] where a few realisations hold the power of both. NaN where no significance can be stated.
    bands: Vec<Range<usize>>,
    independent: Array2<f64>,
    /// Magnitude-squared coherence `|S_rj|^2 / (S_rr S_jj)`, 0 to 1; NaN where a spectrum is 0.
    pub coherence: Array2<f64>,
    /// Phase of `S_rj = <conj(X_r) X_j>`, in rad: `-k (x_j - x_r)` of a wave `exp(i (k x - omega t))`.
    pub phase: Array2<f64>,
    /// Half of the interval of the phase at `1 - alpha`; NaN where the coherence is not above the level.
    pub phase_interval: Array2<f64>,
    /// One-sided power spectral density of each site, in the square of the samples' unit over frequency.
    pub spectrum: Array2<f64>,
    /// Whether the coherence of each site with the reference is above chance over all frequencies: of all sites
    /// together, one is by chance with probability alpha.
    pub is_coherent: Vec<bool>,
    /// Whether waves run both ways past most of the sites whose bands tell: then there are neither delays nor velocities.
    pub is_both_ways: bool,
    /// Delay of each site behind the reference; `None` where it is not coherent, or no delay is more likely than
    /// others.
    pub delays: Vec<Option<Delay>>,
    /// Wavenumber and phase velocity, for frequencies at which enough sites are coherent and their phases are those of
    /// a plane wave.
    pub speeds: Vec<PhaseSpeed>,
    /// The velocity of the waves, from the delays or, where a narrow band is coherent, from the phases.
    pub velocity: Option<WaveVelocity>,
}

impl Coherence {
    /// The coherence that one cell exceeds by chance with probability `alpha`, of the mean site; `None` where no
    /// significance can be stated.
    pub fn level(&self) -> Option<f64> {
        let others = (0..self.is_coherent.len()).filter(|j| *j != self.reference);
        let of_others: Vec<f64> = others.map(|j| self.independent_of(j)).collect();
        let mean = of_others.iter().sum::<f64>() / of_others.len() as f64;
        Some(level_of_chance(mean, self.alpha)).filter(|level| !level.is_nan())
    }

    /// The [level](Self::level) of a site; NaN where no significance can be stated.
    pub fn level_at(&self, site: usize) -> f64 {
        level_of_chance(self.independent_of(site), self.alpha)
    }

    /// The independent realisations of a site with the reference, the mean of all bands but that of the mean.
    fn independent_of(&self, site: usize) -> f64 {
        let bands = self.independent.slice(ndarray::s![1.., site]);
        bands.mean().unwrap_or(f64::NAN)
    }

    /// The same at each frequency and site.
    fn independent_cells(&self) -> Array2<f64> {
        let mut cells = Array2::zeros(self.coherence.dim());
        for (band, independent) in self.bands.iter().zip(self.independent.rows()) {
            let mut rows = cells.slice_mut(ndarray::s![band.clone(), ..]);
            rows.assign(&independent);
        }
        cells
    }

    /// Share of the cells above the level, of those away from the reference, from 0 and from the Nyquist
    /// frequency; `None` where no significance can be stated.
    pub fn above_level(&self) -> Option<f64> {
        self.level()?;
        let independent = self.independent_cells();
        let inside = 1..self.segment[0].div_ceil(2);
        let rows = self.coherence.slice(ndarray::s![inside.clone(), ..]);
        let independent = independent.slice(ndarray::s![inside, ..]);
        let cells = rows.indexed_iter().zip(&independent);
        let cells =
            cells.filter(|(((_, j), g), k)| *j != self.reference && g.is_finite() && !k.is_nan());
        let (count, above) = cells.fold((0u64, 0u64), |(count, above), ((_, g), k)| {
            let is_above = *g > level_of_chance(*k, self.alpha);
            (count + 1, above + u64::from(is_above))
        });
        (count > 0).then(|| above as f64 / count as f64)
    }

    /// Positions of the sites.
    pub fn positions(&self) -> Vec<f64> {
        let sites = 0..self.coherence.ncols();
        sites.map(|j| self.space.at(j)).collect()
    }
}

/// Coherence, phase and delay of every site against a reference.
///
/// # Equation
/// With `X` the transforms of the realisations, `S_ij = <conj(X_i) X_j>` their mean,
///
/// ```text
/// g_j(f) = |S_rj|^2 / (S_rr S_jj),    phase_j(f) = arg S_rj(f).
/// ```
///
/// Of K independent realisations of records without a common part, `g` has the mean `1 / K` and exceeds
/// `1 - alpha^{1/(K-1)}` with probability alpha. The phase deviates by less than
///
/// ```text
/// asin sqrt(t^2 / (2 K - 2) (1 - u) / u),    u = (K g - 1) / (K - 1),
/// ```
///
/// with probability `1 - alpha`, `t` the two-sided quantile of Student's distribution with `2 K - 2` degrees of freedom, u
/// the coherence less what chance adds to it. It is stated where `g` is above the level, and the root below 1. Those above it by
/// chance have no phase: of a site whose coherence is above the level at a share r of the frequencies, alpha is `r alpha` (the rate of
/// false statements among those that are made).
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Results: `(frequency, site)`.
///
/// # Units
/// Phases in rad, delays in units of time, wavenumbers in rad per unit of length.
///
/// # Errors
/// [`crate::Error::Request`] for fields with different axes, a reference that is no site, segments that do not fit, and
/// fewer than two realisations, with which the coherence is 1 whatever the data are;
/// [`crate::Error::NonFinite`]; [`crate::Error::Memory`]; [`crate::Error::Cancelled`]; [`crate::Error::Failed`].
///
/// # Source
/// J. S. Bendat, A. G. Piersol, "Random Data", 4th ed. (2010), sections 9.2 and 11.2; G. C. Carter, C. H.
/// Knapp, A. H. Nuttall (1973) for the level; L. H. Koopmans, "The Spectral Analysis of Time Series" (1974),
/// section 8.4, for the interval of the phase; Y. Benjamini, D. Yekutieli, J. Am. Stat. Assoc. 100, 71 (2005) for its alpha.
pub fn coherence(
    fields: &[&Field],
    request: &CoherenceRequest,
    observer: &dyn Observer,
) -> Result<Coherence> {
    let grid = Grid::of(first_of(fields)?);
    let realisations = request.plan(&grid)?;
    check_count(fields.len() * realisations.count())?;
    let run = |realisations: &Realisations| {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        request.pass(realisations, &grid, fields.len()).run(&shots)
    };
    in_pool(request.threads, || {
        let found = run(&realisations)?;
        let whole = request.averaging.of_whole_shots(grid.times);
        let is_cut = fields.len() > 1 && realisations.segments.count() > 1;
        match whole.filter(|_| is_cut && found.independence.is_transient()) {
            Some(whole) => run(&Realisations::new(&whole, grid.times)?),
            None => Ok(found),
        }
    })
}

/// `u / (1 - u)` of a coherence of so many realisations, less what chance adds to it.
fn odds(coherence: f64, independent: f64) -> f64 {
    (independent * coherence - 1.0) / (independent * (1.0 - coherence))
}

impl Coherence {
    /// Intervals, delays and speeds, where the coherence is above the level.
    fn judge(&mut self, realisations: &Realisations) {
        // NaN, where no significance can be stated, is no number to be above.
        let independent = self.independent_cells();
        if independent.iter().all(|k| k.is_nan()) {
            return;
        }
        let end = self.segment[0].div_ceil(2);
        let levels = independent.mapv(|k| level_of_chance(k, self.alpha));
        // Of a site the probability that one of the intervals which are stated does not hold.
        let chance = |j: usize| {
            let above = (1..end).filter(|m| self.coherence[[*m, j]] > levels[[*m, j]]);
            self.alpha * above.count().max(1) as f64 / (end - 1).max(1) as f64
        };
        let chances: Vec<f64> = (0..levels.ncols()).map(chance).collect();
        // Not a number where the sine is none.
        let interval = |((m, j), g): ((usize, usize), &f64)| match *g > levels[[m, j]] {
            true => {
                let k = independent[[m, j]];
                let spread = phase_spread(chances[j], k);
                (spread * odds(*g, k).recip()).sqrt().asin()
            }
            false => f64::NAN,
        };
        let cells = self.coherence.indexed_iter().map(interval);
        let cells = self.phase_interval.iter_mut().zip(cells);
        cells.for_each(|(to, interval)| *to = interval);
        let follows = DelaySearch::new(realisations, self).find(&independent);
        let independent: Vec<f64> = (0..levels.ncols())
            .map(|j| self.independent_of(j))
            .collect();
        self.is_coherent = follows.iter().map(|site| site.is_coherent).collect();
        let ways = median(follows.iter().filter_map(|site| site.one_way));
        self.is_both_ways = ways.is_some_and(|ways| ways < ONE_WAY);
        if self.is_both_ways {
            return;
        }
        self.delays = follows.iter().map(|site| site.delay).collect();
        let slowness = Slowness::of_delays(self);
        let spread = |independent: &f64| phase_spread(self.alpha, *independent);
        let least = independent.iter().map(|k| least_coherence(spread(k)));
        let least: Vec<f64> = least.collect();
        let power = self.spectrum.column(self.reference);
        let is_own = is_own(power);
        let leakage = delay::leakage(realisations);
        let speeds = (1..end).filter(|m| is_own[*m]).filter_map(|m| {
            let [below, above] = [(m - 1).max(1), (m + 1).min(end - 1)];
            let growth = (power[above] / power[below]).ln() / (above - below).max(1) as f64;
            let leaks = (leakage * growth).clamp(-delay::FURTHEST, delay::FURTHEST);
            let phases = Phases {
                at: self.frequency[m] + leaks * self.frequency[1],
                at_error: OF_LEAKAGE * leaks.abs() * self.frequency[1],
                found: self,
                bin: m,
                least: &least,
                independent: &independent,
                slowness: slowness.map(|found| found.slowness),
            };
            phases.speed()
        });
        self.speeds = speeds.collect();
        let bins = realisations.shared_bins();
        let mean = velocity::of_frequencies(&self.speeds, bins, self.alpha);
        self.velocity = match slowness {
            Some(slowness) if !mean.is_some_and(|mean| mean.is_dispersive) => slowness.velocity(),
            _ => mean,
        };
    }

    /// Sites beside the reference that are coherent with it.
    pub fn coherent_sites(&self) -> impl Iterator<Item = usize> {
        let sites = self.is_coherent.iter().enumerate();
        sites.filter_map(|(j, is_coherent)| (*is_coherent && j != self.reference).then_some(j))
    }
}
