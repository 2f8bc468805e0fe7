//! Bicoherence: coupling of three frequencies, at a site, between two sites and along x.

use super::along::BicoherenceAlong;
use super::pass::Pass;
use super::spectra::last_bin;
use crate::error::{Error, Result};
use crate::estimates::SIGNIFICANCE;
use crate::estimates::realisations::{
    Averaging, Grid, Independence, Realisations, Shots, Tapers, a_site, check_count,
    check_significance, first_of, phase_spread,
};
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;

/// All choices of [`bicoherence`].
#[derive(Debug, Clone, PartialEq, smart_default::SmartDefault)]
pub struct BicoherenceRequest {
    /// Index of the site of the two frequencies whose sum or difference is taken.
    pub site: usize,
    /// Index of the site of the third; `None`: the same.
    pub output: Option<usize>,
    /// Sites whose own bicoherence is taken along x, in ascending order.
    pub along: Vec<usize>,
    /// One window; `segment: None` is the power of two at or below a 32nd of the record.
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// Probability by which a level is exceeded by chance.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// What [`bicoherence`] finds.
#[derive(Debug, Clone)]
pub struct Bicoherence {
    /// Frequencies of all bins in cycles per unit of time.
    pub frequency: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    /// Indices of the sites of the pair and of the third frequency.
    pub site: usize,
    pub output: usize,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    pub independence: Independence,
    pub alpha: f64,
    pub map: BicoherenceMap,
    /// Own bicoherence of the sites chosen.
    pub along: BicoherenceAlong,
}

/// Bicoherence of all triples, a cell each.
#[derive(Debug, Clone, PartialEq)]
pub struct BicoherenceMap {
    /// Bins of `f1`, `f2` and `f3 = f1 + f2`. `f2` is at most `f1` in size; negative, where the third
    /// frequency is of another site, for differences. Bins that share power under the window are kept apart.
    pub bins: Vec<[isize; 3]>,
    /// `|<X1 X2 X3*>|^2 / (<|X1 X2|^2> <|X3|^2>)`, 0 to 1; NaN where there is no power.
    pub bicoherence: Vec<f64>,
    /// Phase of `<X1 X2 X3*>` in rad.
    pub biphase: Vec<f64>,
}

/// Three frequencies that are coupled.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct CoupledTriple {
    /// `f1`, `f2` and `f3 = f1 + f2`.
    pub frequencies: [f64; 3],
    pub bicoherence: f64,
    /// In rad.
    pub biphase: f64,
    /// Half of the interval of the biphase at `1 - alpha`.
    pub biphase_interval: f64,
    /// As [`Bicoherence::chance`].
    pub chance: f64,
}

impl Bicoherence {
    /// The bicoherence that one cell exceeds by chance with probability `alpha`; `None` where no
    /// significance can be stated.
    pub fn cell_level(&self) -> Option<f64> {
        self.independence.level(self.alpha)
    }

    /// The bicoherence that any cell of the map exceeds by chance with probability `alpha` (correction by
    /// Sidak).
    pub fn map_level(&self) -> Option<f64> {
        self.independence.level(sidak(self.alpha, self.cells()))
    }

    /// The probability that without coupling any cell of the map is as large as this:
    /// `1 - (1 - p)^n` of n cells, each of them with `p = (1 - b^2)^{K - 1}`; NaN where no significance can be stated.
    pub fn chance(&self, bicoherence: f64) -> f64 {
        let independent = self.independence.independent.unwrap_or(f64::NAN);
        let one = (1.0 - bicoherence.min(1.0)).powf(independent - 1.0);
        -(self.cells() as f64 * (-one).ln_1p()).exp_m1()
    }

    /// Cells of the map that have a value.
    pub fn cells(&self) -> usize {
        let known = self.map.bicoherence.iter().filter(|b| b.is_finite());
        known.count()
    }

    /// Cells above a level.
    pub fn above(&self, level: f64) -> usize {
        let above = self.map.bicoherence.iter().filter(|b| **b > level);
        above.count()
    }

    /// The triples above the level of the map with the largest bicoherence, at most `count`.
    pub fn strongest(&self, count: usize) -> Vec<CoupledTriple> {
        let (Some(level), Some(independent)) = (self.map_level(), self.independence.independent)
        else {
            return Vec::new();
        };
        let map = &self.map;
        let above = |cell: &usize| map.bicoherence[*cell] > level;
        let mut cells: Vec<usize> = (0..map.bins.len()).filter(above).collect();
        cells.sort_by(|a, b| map.bicoherence[*b].total_cmp(&map.bicoherence[*a]));
        let spread = phase_spread(self.alpha, independent);
        let df = self.frequency[1];
        let triples = cells.into_iter().take(count).map(|cell| {
            let b = map.bicoherence[cell];
            CoupledTriple {
                frequencies: map.bins[cell].map(|bin| bin as f64 * df),
                bicoherence: b,
                biphase: map.biphase[cell],
                biphase_interval: (spread * (1.0 - b) / b).sqrt().min(1.0).asin(),
                chance: self.chance(b),
            }
        });
        triples.collect()
    }
}

/// What each of `count` independent cells may exceed by chance, so that any of them does with probability
/// `alpha`: `1 - (1 - alpha)^{1 / count}`. Conservative where cells are positively dependent. Source: Z. Sidak,
/// J. Am. Stat. Assoc. 62, 626 (1967).
pub(super) fn sidak(alpha: f64, count: usize) -> f64 {
    -((-alpha).ln_1p() / count.max(1) as f64).exp_m1()
}

/// Bicoherence of one site, between two, and along x.
///
/// # Equation
/// With `X` the transforms of the realisations at the frequencies `f1`, `f2`, `f3 = f1 + f2`, and means over
/// realisations,
///
/// ```text
/// b^2(f1, f2) = |<X1 X2 X3*>|^2 / (<|X1 X2|^2> <|X3|^2>),    biphase = arg <X1 X2 X3*>.
/// ```
///
/// By the inequality of Cauchy and Schwarz `b^2` is at most 1. Of K independent realisations of records
/// without coupling it has the mean `1 / K` and exceeds `1 - alpha^{1/(K-1)}` with probability alpha. It shows
/// that phases are coupled, not which frequency feeds which.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. The map is a list of triples:
/// `f1 >= f2 > 0` of one site, which others repeat; between two sites also `f2 < 0`. Without f = 0, below the
/// Nyquist frequency, and without triples whose `f1` and `f3` (in differences also `|f2|` and `f3`) share power
/// under the window, which raises `b^2` without coupling. Along x: `(frequency f3, site)`.
///
/// # Units
/// Bicoherence has none; biphase in rad.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, sites that are none, segments that do not fit, several
/// tapers (the third moment of those of odd order vanishes), and fewer than two realisations;
/// [`Error::NonFinite`]; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Failed`].
///
/// # Source
/// Y. C. Kim, E. J. Powers, IEEE Trans. Plasma Sci. 7, 120 (1979), with this normalisation; S. Elgar, R. T.
/// Guza, IEEE Trans. Acoust. Speech Signal Process. 36, 1667 (1988), for the distribution without coupling.
pub fn bicoherence(
    fields: &[&Field],
    request: &BicoherenceRequest,
    observer: &dyn Observer,
) -> Result<Bicoherence> {
    let first = first_of(fields)?;
    let grid = Grid::of(first);
    let all = request.realisations(&grid)?;
    let (memory, reached) = (request.memory, all.reached());
    let shots = Shots::new(fields, request.gaps, memory, reached, observer)?;
    let needed = [request.site, request.output()];
    let needed = needed.iter().chain(&request.along);
    let needed: Vec<(usize, usize)> = needed.map(|site| (*site, 0)).collect();
    let realisations = shots.keeping(all, &needed)?;
    check_count(fields.len() * realisations.count())?;
    in_pool(request.threads, || {
        Pass::new(request, &grid, &realisations, fields.len()).run(&shots)
    })
}

/// Part of the record at or below which a segment is by default.
const PART: usize = 32;

impl BicoherenceRequest {
    /// Index of the site of the third frequency.
    pub fn output(&self) -> usize {
        self.output.unwrap_or(self.site)
    }

    /// The realisations of a record, of which a triple can be made.
    fn realisations(&self, grid: &Grid) -> Result<Realisations> {
        let two = [("site", self.site), ("output", self.output())];
        let along = self.along.iter().map(|site| ("along", *site));
        for (option, site) in two.into_iter().chain(along) {
            Error::require(site < grid.sites, option, a_site(grid.sites), site)?;
        }
        let ascend = self.along.is_sorted_by(|a, b| a < b);
        Error::require(ascend, "along", "sites in ascending order", "others")?;
        check_significance(self.alpha)?;
        only_one_window(&self.averaging)?;
        let averaging = self.averaging.with_segment(match grid.times / PART {
            0..8 => grid.times.min(8),
            part => 1 << part.ilog2(),
        });
        let all = Realisations::new(&averaging, grid.times)?;
        let length = all.segments.length;
        let is_enough = last_bin(length) >= 2 * all.least_distance();
        let expected = "more samples, for one triple of frequencies";
        Error::require(is_enough, "segment", expected, length)?;
        Ok(all)
    }
}

/// # Errors
/// [`Error::Request`] for several tapers.
pub(super) fn only_one_window(averaging: &Averaging) -> Result<()> {
    let is_one = matches!(averaging.tapers, Tapers::Window(_));
    let expected = "one window: products of three transforms vanish under tapers of odd order";
    Error::require(is_one, "multitaper", expected, "several tapers")
}
