//! Spectral proper orthogonal decomposition: the motions that are coherent along x, by frequency.

mod shapes;
mod sheet;
mod snapshots;

pub use shapes::{ModeShapes, ModeWave};

use ndarray::Array2;
use num_complex::Complex;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::estimates::SIGNIFICANCE;
use crate::estimates::realisations::{
    Averaging, Independence, Realisations, SegmentScratch, Shots, TOGETHER, check_squares,
    first_of, interval_factors, steadiness, steadiness_of_sites,
};
use crate::field::{Axis, Field};
use crate::numeric::chi_square_level;
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::buffer::Buffer;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use crate::transform::{RecordTransform, fold, frequencies};
use shapes::ShapeSearch;
use snapshots::{Cell, Snapshots};

/// All choices of [`modes`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModesRequest {
    /// Frequencies whose modes are kept, each taken as the nearest bin; empty: that of the largest
    /// eigenvalue.
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

/// Probability by which noise has a mode at any of the frequencies.
const CHANCE: f64 = SIGNIFICANCE;

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
    pub alpha: f64,
    /// `(frequency, mode)`, descending: one-sided power spectral density, integrated over x.
    pub eigenvalues: Array2<f64>,
    /// One-sided power spectral density of all sites, integrated over x.
    pub total: Vec<f64>,
    /// The modes of the chosen frequencies.
    pub chosen: Vec<ModeShapes>,
}

impl Modes {
    /// What an eigenvalue at a frequency is multiplied by for the ends of its interval; `None` where no
    /// interval can be stated.
    pub fn interval(&self, bin: usize) -> Option<[f64; 2]> {
        let independent = self.independence.independent?;
        // The transform of real samples is real at 0 and at the Nyquist frequency.
        let is_real = bin == 0 || 2 * bin == self.segment[0];
        let freedom = if is_real {
            independent
        } else {
            2.0 * independent
        };
        Some(interval_factors(freedom, self.alpha))
    }

    /// Share of the power at a frequency that the first mode holds; NaN where there is none.
    pub fn leading_share(&self, bin: usize) -> f64 {
        self.eigenvalues[[bin, 0]] / self.total[bin]
    }

    /// Modes at a frequency whose eigenvalues are above the largest of noise that is not correlated along x, as loud as what
    /// modes before them leave, at 95 % for all frequencies together. `None` where no interval can be stated.
    ///
    /// # Equation
    /// Of n sites and K realisations the largest eigenvalue over the mean of all is
    ///
    /// ```text
    /// (sqrt K + sqrt n)^2 / K + s (sqrt K + sqrt n) (1 / sqrt K + 1 / sqrt n)^(1/3) / K
    /// ```
    ///
    /// with s of the distribution of Tracy and Widom for complex entries.
    ///
    /// # Source
    /// C. A. Tracy, H. Widom, Commun. Math. Phys. 159, 151 (1994); I. M. Johnstone, Ann. Stat. 29, 295 (2001).
    pub fn above_noise(&self, bin: usize) -> Option<usize> {
        let independent = self.independence.independent?;
        let chance = CHANCE / self.frequency.len() as f64;
        let Independence {
            records,
            segments,
            tapers,
            ..
        } = self.independence;
        // Neighbours that share power by a correlation r count 1 / (1 + 2 r^2) each in a mean, and 1 / (1 + 2 r) in the largest
        // eigenvalue, since noise of both is alike in phase.
        let excess = (records * segments * tapers) as f64 / independent - 1.0;
        let realisations = match excess > 0.0 && excess < 0.5 {
            true => independent * (1.0 + excess) / (1.0 + (2.0 * excess).sqrt()),
            false => independent,
        };
        let mut left = self.total[bin];
        let mut count = 0;
        for eigenvalue in self.eigenvalues.row(bin) {
            let others = (self.n_sites - count) as f64;
            // Of the last mode nothing tells it from noise.
            if others < 2.0
                || *eigenvalue <= largest_of_noise(others, realisations, chance) * left / others
            {
                break;
            }
            left -= eigenvalue;
            count += 1;
        }
        Some(count)
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

    /// Words for the units of time and of length.
    pub fn units(&self) -> (String, String) {
        (self.time.time_unit(), self.space.space_unit())
    }
}

/// What the largest eigenvalue of noise, over the mean of all, exceeds with probability `chance`. The distribution of Tracy
/// and Widom is that of Gamma, shifted (M. Chiani, J. Multivar. Anal. 129, 69 (2014)).
fn largest_of_noise(sites: f64, realisations: f64, chance: f64) -> f64 {
    const SHAPE: f64 = 79.6595;
    const SCALE: f64 = 0.101037;
    const SHIFT: f64 = 9.81961;
    let s = 0.5 * SCALE * chi_square_level(chance, 2.0 * SHAPE) - SHIFT;
    let (n, k) = (sites.sqrt(), realisations.sqrt());
    let width = (n + k) * (1.0 / n + 1.0 / k).cbrt();
    ((n + k).powi(2) + s * width) / realisations
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
/// [`Error::Threads`].
///
/// # Source
/// A. Towne, O. T. Schmidt, T. Colonius, J. Fluid Mech. 847, 821 (2018); O. T. Schmidt, T. Colonius, AIAA J. 58,
/// 1023 (2020) for the intervals; L. Sirovich, Q. Appl. Math. 45, 561 (1987) for snapshots.
pub fn modes(fields: &[&Field], request: &ModesRequest, observer: &dyn Observer) -> Result<Modes> {
    let first = first_of(fields)?;
    let all = Realisations::new(&request.averaging, first.n_times())?;
    in_pool(request.threads, || {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, all.reached(), observer)?;
        let every: Vec<(usize, usize)> = (0..first.n_sites()).map(|site| (site, 0)).collect();
        let realisations = match shots.whole_segments(all.segments, &every)? {
            Some(kept) => all.keeping(kept)?,
            None => all,
        };
        let chosen = check(first, request, &realisations, fields.len())?;
        let pass = Pass {
            shots,
            first,
            request,
            realisations: &realisations,
            chosen: &chosen,
            observer,
        };
        pass.run()
    })
}

/// The bins of the chosen frequencies.
fn check(
    first: &Field,
    request: &ModesRequest,
    realisations: &Realisations,
    shots: usize,
) -> Result<Vec<usize>> {
    let refuse = |option, expected: String, found: String| {
        Err(Error::Request {
            option,
            expected,
            found,
        })
    };
    if shots * realisations.count() < 2 {
        let expected =
            "at least two realisations: shorter segments, several tapers, or several fields";
        let found = "one segment of one field under one taper";
        return refuse("segment", expected.into(), found.into());
    }
    if request.modes == 0 {
        return refuse("modes", "at least one mode".into(), "0".into());
    }
    if !(request.alpha > 0.0 && request.alpha < 1.0) {
        let expected = "a probability between 0 and 1".to_owned();
        return refuse("significance", expected, request.alpha.to_string());
    }
    let length = realisations.segments.length;
    let bin = 1.0 / (length as f64 * first.time.step);
    let largest = frequencies(length, first.time.step)[length / 2];
    let mut chosen = Vec::new();
    for frequency in &request.frequencies {
        if !(*frequency >= 0.0 && *frequency < largest + 0.5 * bin) {
            let expected = format!("frequencies from 0 to {largest}");
            return refuse("frequencies", expected, frequency.to_string());
        }
        chosen.push(((frequency / bin).round() as usize).min(length / 2));
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

struct Pass<'a> {
    shots: Shots<'a>,
    first: &'a Field,
    request: &'a ModesRequest,
    realisations: &'a Realisations,
    chosen: &'a [usize],
    observer: &'a dyn Observer,
}

/// What a tile of sites gives.
struct TileSpectra<'s> {
    /// `[bin * realisations + realisation]`, of the bins of a block.
    cells: &'s mut [Cell],
    /// Energies of the parts of each record.
    parts: [[f64; TOGETHER]; PARTS],
}

/// Parts of a record whose energies are compared.
const PARTS: usize = 16;

/// Sizes of the work.
struct Sizes {
    /// Bins whose spectra are held together.
    bins: usize,
    /// Sites that are read at once.
    block: Option<usize>,
}

impl Pass<'_> {
    fn run(&self) -> Result<Modes> {
        let (all, n_sites) = (self.count(), self.first.n_sites());
        let bins = self.realisations.bins();
        let length = self.realisations.segments.length;
        let sizes = self.sizes()?;
        let mut eigenvalues = Array2::zeros((bins, all.min(n_sites)));
        let mut total = vec![0.0; bins];
        let mut chosen: Vec<ModeShapes> = Vec::new();
        let mut sites = Vec::new();
        let mut best = 0.0;
        for from in (0..bins).step_by(sizes.bins) {
            let to = bins.min(from + sizes.bins);
            let mut room = Buffer::<Cell>::zeros((self.shots.tiles(), (to - from) * all))?;
            let (tiles, unit) = self.spectra(from, to, sizes.block, room.numbers_mut())?;
            if from == 0 {
                let energies = |site: usize| {
                    tiles[site / TOGETHER]
                        .parts
                        .map(|part| part[site % TOGETHER])
                };
                let of_site = |site: usize| {
                    let energies: [f64; PARTS] = energies(site);
                    let energy: f64 = energies.iter().sum();
                    (steadiness(&energies.map(f64::sqrt)), energy)
                };
                sites = (0..n_sites).map(of_site).collect();
            }
            check_squares(unit)?;
            let density = self.first.time.step * unit * unit * self.first.space.step.abs();
            let snapshots = Snapshots {
                tiles: &tiles.iter().map(|tile| &*tile.cells).collect::<Vec<_>>(),
                n_sites,
                count: all,
            };
            self.observer.stage("eigenvalues", (to - from) as u64);
            let starts: Vec<usize> = (from..to).step_by(WIDTH).collect();
            let solve = |first: &usize| -> Result<Vec<(Vec<f64>, f64)>> {
                if self.observer.cancelled() {
                    return Err(Error::Cancelled);
                }
                let end = to.min(first + WIDTH);
                self.observer.advance((end - first) as u64);
                Ok(snapshots.eigenvalues(first - from..end - from))
            };
            let solved: Vec<Vec<(Vec<f64>, f64)>> =
                starts.par_iter().map(solve).collect::<Result<_>>()?;
            for (bin, (values, trace)) in (from..).zip(solved.into_iter().flatten()) {
                let scale = density * fold(bin, length) / all as f64;
                let row = eigenvalues.row_mut(bin);
                for (value, found) in row.into_iter().zip(values) {
                    *value = found.max(0.0) * scale;
                }
                total[bin] = trace * scale;
            }
            let search = ShapeSearch::new(&self.first.space, n_sites);
            let shapes = |bin: &usize| {
                let solved = snapshots.solve(bin - from, self.request.modes);
                search.shapes(*bin, self.frequency()[*bin], solved)
            };
            if self.chosen.is_empty() {
                let inside = from.max(1)..to.min(length.div_ceil(2));
                let leading = inside.max_by(|a, b| {
                    eigenvalues[[*a, 0]]
                        .total_cmp(&eigenvalues[[*b, 0]])
                        .then(b.cmp(a))
                });
                if let Some(bin) = leading.filter(|bin| eigenvalues[[*bin, 0]] > best) {
                    best = eigenvalues[[bin, 0]];
                    chosen = vec![shapes(&bin)];
                }
            } else {
                let inside: Vec<usize> = self
                    .chosen
                    .iter()
                    .copied()
                    .filter(|bin| (from..to).contains(bin))
                    .collect();
                chosen.extend(inside.par_iter().map(shapes).collect::<Vec<_>>());
            }
        }
        Ok(Modes {
            frequency: self.frequency(),
            time: self.first.time.clone(),
            space: self.first.space.clone(),
            n_sites,
            unit: self.first.unit.clone(),
            segment: [length, length - self.realisations.segments.hop],
            independence: Independence::new(
                [
                    self.shots.count(),
                    self.realisations.segment_count(),
                    self.realisations.tapers(),
                ],
                self.realisations.effective(),
                steadiness_of_sites(sites),
            ),
            alpha: self.request.alpha,
            eigenvalues,
            total,
            chosen,
        })
    }

    fn frequency(&self) -> Vec<f64> {
        frequencies(self.realisations.segments.length, self.first.time.step)
    }

    /// Realisations of all shots.
    fn count(&self) -> usize {
        self.shots.count() * self.realisations.count()
    }

    /// # Errors
    /// [`Error::Memory`].
    fn sizes(&self) -> Result<Sizes> {
        let (all, n_sites) = (self.count() as u64, self.first.n_sites() as u64);
        let (bins, samples) = (self.realisations.bins() as u64, self.first.n_times() as u64);
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let together = TOGETHER as u64;
        let rank = all.min(n_sites);
        let tile = together * (8 * samples + 24 * bins)
            + RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let solver = 32 * all * (n_sites + together) + (16 * WIDTH as u64 + 64) * rank * rank;
        let kept = 8 * bins * (rank + 3)
            + 16 * (self.chosen.len() as u64 + 1) * self.request.modes as u64 * n_sites;
        let held = kept + threads * tile.max(solver);
        let of_a_bin = 16 * all * self.shots.tiles() as u64 * together;
        let allowed = self.request.memory.unwrap_or_else(half_of_free_memory);
        let least = held + of_a_bin + 8 * samples * together;
        if least > allowed {
            return Err(Error::Memory {
                what: WHAT,
                needed: least,
                allowed,
            });
        }
        // Half of what is left holds spectra, half samples.
        let spectra = ((allowed - held) / 2).max(of_a_bin);
        let bins = (spectra / of_a_bin).min(bins);
        Ok(Sizes {
            bins: bins as usize,
            block: self.shots.block(WHAT, held + bins * of_a_bin)?,
        })
    }

    /// The spectra of all realisations at the bins `from .. to`, in `cells`, which are 0, and the unit of the
    /// samples.
    fn spectra<'c>(
        &self,
        from: usize,
        to: usize,
        block: Option<usize>,
        cells: &'c mut [Cell],
    ) -> Result<(Vec<TileSpectra<'c>>, f64)> {
        let (all, count) = (self.count(), self.realisations.count());
        let mut tiles: Vec<TileSpectra<'c>> = cells
            .chunks_exact_mut((to - from) * all)
            .map(|cells| TileSpectra {
                cells,
                parts: [[0.0; TOGETHER]; PARTS],
            })
            .collect();
        let mut shot_number = 0;
        let unit = self.shots.each(block, |shot| {
            let first = shot_number * count;
            let scale = shot.scale;
            shot.each_tile(
                "spectra",
                &mut tiles,
                |scratch: &mut SegmentScratch, sites, records, out| {
                    let (width, mut room) = (sites.len(), Vec::new());
                    let mark = shot.mark(sites);
                    let part = (records.length() / PARTS).max(1);
                    let parts = PARTS.min(records.length() / part);
                    for (p, sums) in out.parts.iter_mut().enumerate().take(parts) {
                        let squares = records.squares(p * part..(p + 1) * part, &mut room);
                        let squares = squares[..width].iter().zip(&mark);
                        for (sum, (square, mark)) in sums.iter_mut().zip(squares) {
                            *sum += square + mark;
                        }
                    }
                    self.realisations.each(records, scratch, |r, spectra| {
                        let rows = &spectra[from * width..to * width];
                        let cells = &mut out.cells[first + r..];
                        if let (TOGETHER, (rows, [])) = (width, rows.as_chunks()) {
                            return widest(Scattered {
                                rows,
                                scale,
                                every: all,
                                cells,
                            });
                        }
                        let cells = cells.iter_mut().step_by(all);
                        for (row, [re, im]) in rows.chunks_exact(width).zip(cells) {
                            let parts = re.0.iter_mut().zip(&mut im.0);
                            for (x, (re, im)) in row.iter().zip(parts) {
                                (*re, *im) = (x.re * scale, x.im * scale);
                            }
                        }
                    });
                },
            )?;
            shot_number += 1;
            Ok(())
        })?;
        Ok((tiles, unit))
    }
}

/// Puts eight records' spectra at every so many cells.
struct Scattered<'a> {
    rows: &'a [[Complex<f64>; TOGETHER]],
    scale: f64,
    every: usize,
    cells: &'a mut [Cell],
}

impl SimdKernel for Scattered<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let scale = L::splat(self.scale);
        let cells = self.cells.iter_mut().step_by(self.every);
        for (row, [re, im]) in self.rows.iter().zip(cells) {
            let [x_re, x_im] = L::parts(row);
            (x_re * scale).store(re);
            (x_im * scale).store(im);
        }
    }
}

const WHAT: &str = "the spectra of all realisations at one frequency";
