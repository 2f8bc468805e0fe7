//! Spectral proper orthogonal decomposition: the motions that are coherent along x, by frequency.

mod null;
mod shapes;
mod sheet;
mod snapshots;

pub use shapes::{ModeShapes, ModeWave};

use ndarray::Array2;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::estimates::SIGNIFICANCE;
use crate::estimates::realisations::{
    Averaging, Independence, Realisations, Shots, Sums, SumsShape, TOGETHER, check_count,
    check_significance, first_of, interval_factors, steadiness_of_sites,
};
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::buffer::Buffer;
use crate::system::check_memory;
use crate::system::threads::in_pool;
use crate::transform::{fold, frequencies};
use null::largest_of_unrelated;
use shapes::ShapeSearch;
use snapshots::{Cell, Eigenvalues, Snapshots, Solved};

/// All choices of [`modes`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModesRequest {
    /// Frequencies whose modes are kept, each taken as the nearest bin; empty: that of the largest
    /// eigenvalue, of those with a coherent motion where there are any.
    pub frequencies: Vec<f64>,
    /// Modes that are kept of each of these frequencies.
    pub modes: usize,
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// The intervals of the eigenvalues hold with probability `1 - alpha`.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Default for ModesRequest {
    fn default() -> Self {
        ModesRequest {
            frequencies: Vec::new(),
            modes: 3,
            averaging: Averaging::default(),
            gaps: Gaps::Refuse,
            alpha: SIGNIFICANCE,
            threads: None,
            memory: None,
        }
    }
}

/// Probability by which unrelated records have a coherent motion at any of the frequencies: one field in a thousand, since who looks for
/// motions has many fields.
const CHANCE: f64 = 1e-3;

/// What [`modes`] finds.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Frequencies in cycles per unit of time.
    pub frequency: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    pub n_sites: usize,
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    pub independence: Independence,
    /// First bin that shares no power with 0 under the window.
    first: usize,
    pub alpha: f64,
    /// `(frequency, mode)`, descending: one-sided power spectral density, integrated over x.
    pub eigenvalues: Array2<f64>,
    /// `(frequency, mode)`, descending: eigenvalues of the coherencies `S_ij / sqrt(S_ii S_jj)`, which sum up to the number of
    /// sites. Those above [`Self::level`] are motions that are coherent along x.
    pub coherencies: Array2<f64>,
    /// How evenly the realisations share the power at each frequency, by which [`Self::level`] has fewer of them.
    evenness: Vec<f64>,
    /// One-sided power spectral density of all sites, integrated over x.
    pub total: Vec<f64>,
    /// The modes of the chosen frequencies.
    pub chosen: Vec<ModeShapes>,
}

impl Modes {
    /// Degrees of freedom of the power at a frequency; `None` where the realisations are too few.
    fn freedom(&self, bin: usize) -> Option<f64> {
        // The transform of real samples is real at 0 and at the Nyquist frequency.
        let is_real = bin == 0 || 2 * bin == self.segment[0];
        Some(self.independence.independent? * if is_real { 1.0 } else { 2.0 })
    }

    /// What an eigenvalue at a frequency is multiplied by for the ends of its interval; `None` where no
    /// interval can be stated.
    pub fn interval(&self, bin: usize) -> Option<[f64; 2]> {
        Some(interval_factors(self.freedom(bin)?, self.alpha))
    }

    /// What the largest of [`Self::coherencies`] at a frequency exceeds if no site is related to another: at any of all
    /// frequencies with probability 0.001. `None` where no interval can be stated.
    pub fn level(&self, bin: usize) -> Option<f64> {
        let independence = &self.independence;
        let all = independence.records * independence.segments * independence.tapers;
        let overlap = (all as f64 / independence.effective - 1.0).max(0.0);
        let chance = CHANCE / self.frequency.len() as f64;
        // Segments that overlap lose the same mean, which makes them alike near 0: every second one counts.
        let counts = if bin < self.first { 0.25 } else { 0.5 };
        let independent = counts * self.evenness[bin] * self.freedom(bin)?;
        let n = self.n_sites;
        Some(largest_of_unrelated(n, independent, overlap, chance))
    }

    /// Coherent motions at a frequency: of [`Self::coherencies`], those above [`Self::level`].
    pub fn above_noise(&self, bin: usize) -> Option<usize> {
        let level = self.level(bin)?;
        let above = self.coherencies.row(bin).into_iter();
        Some(above.take_while(|value| **value > level).count())
    }

    /// Frequencies with a coherent motion, of those that share no power with 0.
    pub fn coherent_frequencies(&self) -> Option<usize> {
        self.level(self.first)?;
        let is_coherent = |bin: &usize| self.above_noise(*bin).is_some_and(|count| count > 0);
        Some(self.inside().filter(is_coherent).count())
    }

    /// Bins below the Nyquist frequency that share no power with 0.
    fn inside(&self) -> std::ops::Range<usize> {
        self.first..self.segment[0].div_ceil(2)
    }

    /// Share of the power of all frequencies that first modes hold; NaN for a field of zeros.
    pub fn leading_share_of_all(&self) -> f64 {
        let first = self.eigenvalues.column(0).sum();
        first / self.total.iter().sum::<f64>()
    }

    /// Positions of the sites.
    pub fn positions(&self) -> Vec<f64> {
        (0..self.n_sites).map(|j| self.space.at(j)).collect()
    }
}

/// Spectral proper orthogonal decomposition (SPOD) of the records of all sites.
///
/// # Equation
/// Of the K realisations `X_k(f, x)`, scaled so that `|X|^2` is a one-sided power spectral density, the
/// cross-spectral density `S(x, x') = <X(x) X*(x')>` has the eigenvalues and modes
///
/// ```text
/// sum_x' S(x, x') phi_n(x') dx = lambda_n phi_n(x),    sum_x |phi_n|^2 dx = 1.
/// ```
///
/// They are found from the K x K matrix `M_kl = sum_x X_k* X_l dx / K` of the realisations, whose eigenvalues
/// they share (method of snapshots), or from S where there are fewer sites than realisations. The eigenvalues
/// of a frequency sum up to the integral of the power spectral density over x.
///
/// Intervals are those of a chi-square variable of 2 K degrees of freedom, K the effective number of
/// realisations, `2 K lambda / chi^2_{1 - alpha/2}` to `2 K lambda / chi^2_{alpha/2}`. They hold for eigenvalues that are
/// well apart; the first is too large on average where it is not.
///
/// Which modes are coherent is judged where all sites have the same level, by the eigenvalues of the coherencies
/// `S_ij / sqrt(S_ii S_jj)`: n of identical records, else as many as motions are shared. Unrelated records have none above
/// [`Modes::level`].
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Eigenvalues: `(frequency, mode)`, as
/// many modes as there are realisations or sites, whichever are fewer.
///
/// # Units
/// Eigenvalues: square of the samples' unit times time times length. Modes: one over the root of length.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, frequencies beyond the Nyquist frequency, segments that do
/// not fit, and fewer than two realisations; [`Error::NonFinite`]; [`Error::Memory`]; [`Error::Cancelled`];
/// [`Error::Failed`].
///
/// # Source
/// A. Towne, O. T. Schmidt, T. Colonius, J. Fluid Mech. 847, 821 (2018); O. T. Schmidt, T. Colonius, AIAA J.
/// 58, 1023 (2020) for the intervals; L. Sirovich, Q. Appl. Math. 45, 561 (1987) for snapshots.
pub fn modes(fields: &[&Field], request: &ModesRequest, observer: &dyn Observer) -> Result<Modes> {
    let first = first_of(fields)?;
    let all = Realisations::new(&request.averaging, first.n_times())?;
    in_pool(request.threads, || {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, all.reached(), observer)?;
        let every: Vec<(usize, usize)> = (0..first.n_sites()).map(|site| (site, 0)).collect();
        let realisations = &shots.keeping(all, &every)?;
        let pass = Pass {
            shots,
            first,
            request,
            realisations,
        };
        pass.run(&pass.chosen()?)
    })
}

struct Pass<'a> {
    shots: Shots<'a>,
    first: &'a Field,
    request: &'a ModesRequest,
    realisations: &'a Realisations,
}

/// What a tile of sites gives.
struct TileSpectra<'s> {
    /// `[bin * realisations + realisation]`, of the bins of a block.
    cells: &'s mut [Cell],
    /// Squares of the samples.
    sums: Sums,
}

impl Pass<'_> {
    /// The bins of the chosen frequencies.
    fn chosen(&self) -> Result<Vec<usize>> {
        let (request, length) = (self.request, self.realisations.segments.length);
        check_count(self.count())?;
        Error::require(request.modes > 0, "modes", "at least one mode", 0)?;
        check_significance(request.alpha)?;
        let largest = frequencies(length, self.first.time.step)[length / 2];
        let bin = |frequency: &f64| {
            let bin = (frequency * length as f64 * self.first.time.step).round();
            let expected = format!("frequencies from 0 to {largest}");
            let is_one = *frequency >= 0.0 && bin <= (length / 2) as f64;
            Error::require(is_one, "frequencies", expected, frequency)?;
            Ok(bin as usize)
        };
        let mut chosen: Vec<usize> = request.frequencies.iter().map(bin).collect::<Result<_>>()?;
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }

    fn run(&self, chosen: &[usize]) -> Result<Modes> {
        let (all, n_sites) = (self.count(), self.first.n_sites());
        let (bins, segments) = (self.realisations.bins(), &self.realisations.segments);
        let (together, block) = self.sizes(chosen.len())?;
        let values = Array2::zeros((bins, all.min(n_sites)));
        let mut found = Modes {
            frequency: frequencies(segments.length, self.first.time.step),
            time: self.first.time.clone(),
            space: self.first.space.clone(),
            n_sites,
            unit: self.first.unit.clone(),
            segment: [segments.length, segments.length - segments.hop],
            independence: self
                .realisations
                .independence(self.shots.count(), None, 1.0),
            first: self.realisations.least_distance(),
            alpha: self.request.alpha,
            eigenvalues: values.clone(),
            coherencies: values,
            evenness: vec![1.0; bins],
            total: vec![0.0; bins],
            chosen: Vec::new(),
        };
        let mut solved: Vec<(usize, Vec<Solved>)> = Vec::new();
        // Whether there is a coherent motion, and the power of the first mode.
        let mut best = (false, 0.0);
        for from in (0..bins).step_by(together) {
            let to = bins.min(from + together);
            let mut room = Buffer::<Cell>::zeros((self.shots.tiles(), (to - from) * all))?;
            let tiles = self.spectra(from, to, block, room.numbers_mut())?;
            if from == 0 {
                found.independence = self.independence(&tiles);
            }
            let snapshots = Snapshots {
                tiles: &tiles.iter().map(|tile| &*tile.cells).collect::<Vec<_>>(),
                n_sites,
                count: all,
            };
            self.shots.observer.stage("eigenvalues", (to - from) as u64);
            let solve = |bin: usize| -> Result<Eigenvalues> {
                self.shots.observer.go_on()?;
                self.shots.observer.advance(1);
                Ok(snapshots.eigenvalues(bin - from))
            };
            let values = (from..to).into_par_iter().map(solve);
            let values: Vec<Eigenvalues> = values.collect::<Result<_>>()?;
            let density = self.first.time.step * self.first.space.step.abs();
            for (bin, values) in (from..).zip(values) {
                let scale = density * fold(bin, segments.length) / all as f64;
                for (n, value) in values.energies.iter().enumerate() {
                    found.eigenvalues[[bin, n]] = value.max(0.0) * scale;
                    found.coherencies[[bin, n]] = values.coherencies[n].max(0.0);
                }
                found.total[bin] = values.trace * scale;
                found.evenness[bin] = values.evenness;
            }
            let mut wanted = chosen.to_vec();
            for bin in found.inside().filter(|_| chosen.is_empty()) {
                let cell = [bin, 0];
                let is_coherent = found.above_noise(bin).is_some_and(|count| count > 0);
                let first = (is_coherent, found.eigenvalues[cell]);
                if first > best {
                    best = first;
                    solved.clear();
                    wanted = vec![bin];
                }
            }
            wanted.retain(|bin| (from..to).contains(bin));
            let of = |bin: &usize| (*bin, snapshots.solve(bin - from, self.request.modes));
            solved.par_extend(wanted.par_iter().map(of));
        }
        let search = ShapeSearch::new(&found, self.realisations);
        let shapes = solved.iter().map(|(bin, modes)| search.shapes(*bin, modes));
        found.chosen = shapes.collect();
        Ok(found)
    }

    fn independence(&self, tiles: &[TileSpectra<'_>]) -> Independence {
        let shots = self.shots.count();
        let of_site = |site: usize| {
            let (sums, lane) = (&tiles[site / TOGETHER].sums, site % TOGETHER);
            let steadiness = sums.steadiness()[lane] / shots as f64;
            (steadiness, sums.plain[0].0[lane])
        };
        let sites = 0..self.first.n_sites();
        let steadiness = steadiness_of_sites(sites.map(of_site).collect());
        self.realisations.independence(shots, None, steadiness)
    }

    /// Realisations of all shots.
    fn count(&self) -> usize {
        self.shots.count() * self.realisations.count()
    }

    /// Bins whose spectra are held together, and sites that are read at once.
    ///
    /// # Errors
    /// [`Error::Memory`].
    fn sizes(&self, chosen: usize) -> Result<(usize, Option<usize>)> {
        let (all, n_sites) = (self.count() as u64, self.first.n_sites() as u64);
        let (bins, samples) = (self.realisations.bins() as u64, self.first.n_times() as u64);
        let (together, rank) = (TOGETHER as u64, all.min(n_sites));
        let tile = together * (8 * samples + 24 * bins) + self.realisations.working_bytes();
        let solver = 32 * all * (n_sites + together) + (32 + 64) * rank * rank;
        let kept =
            16 * bins * (rank + 2) + 16 * (chosen as u64 + 1) * self.request.modes as u64 * n_sites;
        let held = kept + rayon::current_num_threads() as u64 * tile.max(solver);
        let of_a_bin = 16 * all * self.shots.tiles() as u64 * together;
        let allowed = self.shots.memory;
        let needed = held + of_a_bin + 8 * samples * together;
        check_memory(WHAT, needed, Some(allowed))?;
        // Half of what is left holds spectra, half samples.
        let spectra = ((allowed - held) / 2).max(of_a_bin);
        let bins = (spectra / of_a_bin).min(bins);
        let block = self.shots.block(WHAT, held + bins * of_a_bin)?;
        Ok((bins as usize, block))
    }

    /// The spectra of all realisations at the bins `from .. to`, in `cells`, which are 0.
    fn spectra<'c>(
        &self,
        from: usize,
        to: usize,
        block: Option<usize>,
        cells: &'c mut [Cell],
    ) -> Result<Vec<TileSpectra<'c>>> {
        let (all, count) = (self.count(), self.realisations.count());
        let pieces = self.realisations.pieces();
        let tile = |cells| TileSpectra {
            cells,
            sums: Sums::zeros(SumsShape { plain: 1, pieces }),
        };
        let tiles = cells.chunks_exact_mut((to - from) * all);
        let mut tiles: Vec<TileSpectra<'c>> = tiles.map(tile).collect();
        let mut first = 0;
        let portions = self.realisations.whole_records(self.shots.count());
        self.shots.each_portion(block, &portions, |shot| {
            shot.each_tile("spectra", &mut tiles, |scratch, sites, records, out| {
                let width = sites.len();
                if from == 0 {
                    let [_, squares] =
                        records.mean_and_squares(0..records.length(), &mut Vec::new());
                    let energies = out.sums.plain[0].0.iter_mut().zip(squares);
                    energies.for_each(|(sum, square)| *sum += square);
                    let sums = &mut out.sums;
                    self.realisations
                        .add_steadiness(shot, (sites, records), scratch, sums);
                }
                self.realisations.each(records, scratch, |r, spectra| {
                    let rows = spectra[from * width..to * width].chunks_exact(width);
                    let cells = out.cells[first + r..].iter_mut().step_by(all);
                    for (row, [re, im]) in rows.zip(cells) {
                        let parts = re.0.iter_mut().zip(&mut im.0);
                        for (x, (re, im)) in row.iter().zip(parts) {
                            (*re, *im) = (x.re, x.im);
                        }
                    }
                });
            })?;
            first += count;
            Ok(())
        })?;
        Ok(tiles)
    }
}

const WHAT: &str = "the spectra of all realisations at one frequency";
