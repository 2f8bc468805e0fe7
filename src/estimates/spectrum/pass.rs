//! The pass over the records of [`super::spectrum()`].

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;
use rayon::prelude::*;

use super::adaptive::{Average, LeftOut, Weights, WithoutOne};
use super::lines::{Line, LineSums, OFFSETS, TaperSums};
use super::{LeftOutEach, LineTest, SpectrumAxis, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::estimates::realisations::{
    FactorTable, Independence, Realisations, SegmentScratch, Shot, Shots, TOGETHER, steadiness,
};
use crate::field::Field;
use crate::numeric::lanes::{LaneBlock, widest};
use crate::numeric::{fisher_level, fisher_tail, student_two_sided};
use crate::prepare::{Detrend, Trend};
use crate::transform::{RecordTransform, fold, frequencies};

/// Bytes of a cell of a site in the sums and in the results.
const HELD: u64 = 8 * (4 + 5 + 7);

pub(super) struct Pass<'a> {
    shots: Shots<'a>,
    request: &'a SpectrumRequest,
    realisations: &'a Realisations,
    weights: Weights,
    /// Transforms of the tapers at the offsets of lines, and the sums of their squares.
    taper_transforms: Vec<[Complex<f64>; OFFSETS.len()]>,
    gains: [f64; OFFSETS.len()],
    /// Effective realisations of one record over the number of tapers.
    effective_segments: f64,
}

/// Sums of a few sites; a block a bin, and a site a lane.
#[derive(Default)]
struct TileSums {
    /// Over segments and records, `[bin * tapers + taper]`; dropped once the average is known.
    energies: Vec<LaneBlock>,
    lines: Vec<LineSums>,
    steadiness: [f64; TOGETHER],
    variance: [f64; TOGETHER],
    spectrum: Vec<LaneBlock>,
    shape: Vec<LaneBlock>,
    /// Of the jackknife: deviations of the logarithms, and their squares.
    deviations: Vec<LaneBlock>,
    squares: Vec<LaneBlock>,
}

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    record: Vec<f64>,
    trend: Vec<f64>,
    tapers: Vec<TaperSums>,
    left: Vec<LaneBlock>,
}

impl<'a> Pass<'a> {
    pub fn new(
        shots: Shots<'a>,
        request: &'a SpectrumRequest,
        realisations: &'a Realisations,
    ) -> Self {
        let taper_transforms = realisations.taper_transforms(&OFFSETS);
        let gain = |d: usize| -> f64 { taper_transforms.iter().map(|u| u[d].norm_sqr()).sum() };
        Pass {
            gains: std::array::from_fn(gain),
            shots,
            request,
            realisations,
            weights: Weights::new(&realisations.concentrations, request.is_adaptive),
            taper_transforms,
            effective_segments: realisations.effective() / realisations.tapers() as f64,
        }
    }

    pub fn run(&self, first: &Field) -> Result<SpectrumEstimate> {
        let block = self
            .shots
            .block("the spectra of this field", self.held(first))?;
        let mut tiles = Vec::new();
        tiles.resize_with(self.shots.tiles(), TileSums::default);
        let mut left_out = LeftOutEach::Realisation;
        let unit = if self.shots.count() == 1 {
            self.shots.each(block, |shot| {
                let visit = |scratch: &mut Scratch,
                             sites: Range<usize>,
                             samples: &[f64],
                             tile: &mut TileSums| {
                    self.add(scratch, sites.len(), samples, shot.scale, tile);
                    self.average(tile);
                    self.leave_out(scratch, sites.len(), samples, shot.scale, left_out, tile);
                    tile.energies = Vec::new();
                };
                shot.each_tile("spectra", &mut tiles, visit)
            })?
        } else {
            let unit = self
                .shots
                .each(block, |shot| self.add_shot(shot, &mut tiles))?;
            tiles.par_iter_mut().for_each(|tile| self.average(tile));
            left_out = self.what_is_left_out(&tiles);
            self.shots.each(block, |shot| {
                let visit = |scratch: &mut Scratch,
                             sites: Range<usize>,
                             samples: &[f64],
                             tile: &mut TileSums| {
                    self.leave_out(scratch, sites.len(), samples, shot.scale, left_out, tile);
                };
                shot.each_tile("jackknife", &mut tiles, visit)
            })?;
            unit
        };
        Ok(self.finish(first, &tiles, left_out, unit))
    }

    /// Bytes that are needed beside the samples.
    fn held(&self, field: &Field) -> u64 {
        let (samples, bins) = (field.n_times() as u64, self.realisations.bins() as u64);
        let sites = field.n_sites().next_multiple_of(TOGETHER) as u64;
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let together = TOGETHER as u64;
        let transform = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let energies = 8 * bins * self.weights.tapers() as u64;
        let scratch = together * (16 * samples + 2 * energies + 48 * bins) + transform;
        let kept = if self.shots.count() > 1 { energies } else { 0 };
        sites * (bins * HELD + kept) + threads * scratch
    }

    fn add_shot(&self, shot: &Shot<'_>, tiles: &mut [TileSums]) -> Result<()> {
        let visit =
            |scratch: &mut Scratch, sites: Range<usize>, samples: &[f64], tile: &mut TileSums| {
                self.add(scratch, sites.len(), samples, shot.scale, tile);
            };
        shot.each_tile("spectra", tiles, visit)
    }

    /// Whether there is a test for lines.
    fn tests_lines(&self) -> bool {
        self.weights.tapers() > 1
    }

    /// Realisations of each taper.
    fn count(&self) -> f64 {
        (self.realisations.segments.count() * self.shots.count()) as f64
    }

    /// Adds the realisations of a shot.
    fn add(
        &self,
        scratch: &mut Scratch,
        width: usize,
        samples: &[f64],
        scale: f64,
        tile: &mut TileSums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        if tile.energies.is_empty() {
            tile.energies = vec![LaneBlock::default(); bins * tapers];
            let lines = if self.tests_lines() { bins } else { 0 };
            tile.lines = vec![LineSums::default(); lines];
        }
        let length = samples.len() / width;
        for (record, sum) in samples.chunks_exact(length).zip(&mut tile.steadiness) {
            scratch.record.clear();
            scratch.record.extend_from_slice(record);
            // An offset is not what moves.
            if self.request.averaging.detrend != Detrend::None {
                Trend::remove_from(
                    &mut scratch.record,
                    Detrend::Mean,
                    |_| true,
                    &mut scratch.trend,
                );
            }
            *sum += steadiness(&scratch.record);
        }
        let squared = scale * scale;
        scratch.tapers.clear();
        scratch
            .tapers
            .resize(tile.lines.len(), TaperSums::default());
        let within = &mut scratch.tapers;
        self.realisations
            .each(samples, &mut scratch.segments, |r, spectra| {
                let taper = r % tapers;
                let rows = spectra.chunks_exact(width);
                let sums = tile.energies.chunks_exact_mut(tapers);
                for (row, sums) in rows.clone().zip(sums) {
                    for (x, sum) in row.iter().zip(&mut sums[taper].0) {
                        *sum += squared * x.norm_sqr();
                    }
                }
                for (row, sums) in rows.zip(within.iter_mut()) {
                    sums.add(&self.taper_transforms[taper], row);
                }
                if taper + 1 == tapers {
                    for (within, sums) in within.iter_mut().zip(&mut tile.lines) {
                        within.take_into(sums, &self.gains, squared);
                    }
                }
            });
    }

    /// The average of all realisations.
    fn average(&self, tile: &mut TileSums) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        tile.variance = self.variance(&tile.energies);
        tile.spectrum = vec![LaneBlock::default(); bins];
        tile.shape = vec![LaneBlock::default(); bins];
        debug_assert_eq!(tile.energies.len(), bins * tapers);
        widest(Average {
            weights: &self.weights,
            energies: &tile.energies,
            count: self.count(),
            variance: tile.variance,
            spectrum: &mut tile.spectrum,
            shape: &mut tile.shape,
        });
    }

    /// Mean square of the tapered samples, tapers weighted by the squares of their concentrations; 1 for
    /// still sites.
    fn variance(&self, energies: &[LaneBlock]) -> [f64; TOGETHER] {
        let length = self.realisations.segments.length;
        let concentrations = &self.realisations.concentrations;
        let mut sums = [0.0; TOGETHER];
        for (m, energies) in energies.chunks_exact(concentrations.len()).enumerate() {
            for (energy, concentration) in energies.iter().zip(concentrations) {
                let weight = fold(m, length) * concentration * concentration;
                for (sum, energy) in sums.iter_mut().zip(energy.0) {
                    *sum += weight * energy;
                }
            }
        }
        let weights: f64 = concentrations.iter().map(|c| c * c).sum();
        let all = weights * length as f64 * self.count();
        sums.map(|sum| if sum > 0.0 { sum / all } else { 1.0 })
    }

    /// Adds what each of a shot's realisations, or the shot, changes if it is left out.
    fn leave_out(
        &self,
        scratch: &mut Scratch,
        width: usize,
        samples: &[f64],
        scale: f64,
        left_out: LeftOutEach,
        tile: &mut TileSums,
    ) {
        let count = self.count();
        if count * self.weights.tapers() as f64 <= 1.0 {
            return;
        }
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        if tile.deviations.is_empty() {
            tile.deviations = vec![LaneBlock::default(); bins];
            tile.squares = vec![LaneBlock::default(); bins];
        }
        let squared = scale * scale;
        let Scratch { segments, left, .. } = scratch;
        let (energies, spectrum, variance) = (&tile.energies, &tile.spectrum, tile.variance);
        let (deviations, squares) = (&mut tile.deviations, &mut tile.squares);
        let mut without = |left_out: LeftOut<'_>| {
            widest(WithoutOne {
                average: &self.weights,
                energies,
                count,
                variance,
                spectrum,
                left_out,
                sum: deviations,
                squares,
            });
        };
        left.clear();
        match left_out {
            LeftOutEach::Realisation => {
                left.resize(bins, LaneBlock::default());
                self.realisations.each(samples, segments, |r, spectra| {
                    for (row, left) in spectra.chunks_exact(width).zip(left.iter_mut()) {
                        for (x, left) in row.iter().zip(&mut left.0) {
                            *left = squared * x.norm_sqr();
                        }
                    }
                    without(LeftOut::Realisation(r % tapers, left));
                });
            }
            LeftOutEach::Record => {
                left.resize(bins * tapers, LaneBlock::default());
                self.realisations.each(samples, segments, |r, spectra| {
                    let rows = spectra.chunks_exact(width);
                    for (row, left) in rows.zip(left.chunks_exact_mut(tapers)) {
                        for (x, left) in row.iter().zip(&mut left[r % tapers].0) {
                            *left += squared * x.norm_sqr();
                        }
                    }
                });
                let count = self.realisations.segments.count() as f64;
                without(LeftOut::Record(count, left));
            }
        }
    }

    fn steadiness(&self, tiles: &[TileSums], site: usize) -> f64 {
        let sum = tiles[site / TOGETHER].steadiness[site % TOGETHER];
        sum / self.shots.count() as f64
    }

    fn independence(&self, steadiness: f64) -> Independence {
        Independence::new(
            [
                self.shots.count(),
                self.realisations.segments.count(),
                self.weights.tapers(),
            ],
            self.realisations.effective(),
            steadiness,
        )
    }

    fn what_is_left_out(&self, tiles: &[TileSums]) -> LeftOutEach {
        let sites = tiles.len() * TOGETHER;
        let sites = sites.min(self.shots.sites(tiles.len() - 1).end);
        let is_transient = |j: &usize| self.independence(self.steadiness(tiles, *j)).is_transient();
        match 2 * (0..sites).filter(is_transient).count() > sites {
            true => LeftOutEach::Record,
            false => LeftOutEach::Realisation,
        }
    }

    fn finish(
        &self,
        field: &Field,
        tiles: &[TileSums],
        left_out: LeftOutEach,
        unit: f64,
    ) -> SpectrumEstimate {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let shape = (self.realisations.bins(), field.n_sites());
        let value = |blocks: fn(&TileSums) -> &Vec<LaneBlock>, m: usize, j: usize| {
            let blocks = blocks(&tiles[j / TOGETHER]);
            blocks
                .get(m)
                .map_or(f64::NAN, |block| block.0[j % TOGETHER])
        };
        let steadiness: Vec<f64> = (0..shape.1).map(|j| self.steadiness(tiles, j)).collect();
        let sites: Vec<Independence> = steadiness.iter().map(|s| self.independence(*s)).collect();
        let density = field.time.step * unit * unit;
        let spectrum = Array2::from_shape_fn(shape, |(m, j)| {
            value(|tile| &tile.spectrum, m, j) * density * fold(m, length)
        });

        let records = self.shots.count() as f64;
        let segments = records * self.effective_segments;
        let most = 2.0 * segments.max(records) * self.weights.tapers() as f64;
        let table = FactorTable::new([segments.min(records).min(1.0), most.max(2.0)], alpha);
        let has_mean = self.request.averaging.detrend == Detrend::None;
        let degrees = Array2::from_shape_fn(shape, |(m, j)| {
            // Transforms at 0 and at the Nyquist frequency are real.
            let one = fold(m, length);
            if (m == 0 && !has_mean) || spectrum[[m, j]] <= 0.0 {
                return f64::NAN;
            }
            match (sites[j].is_transient(), sites[j].records) {
                (true, 0..2) => f64::NAN,
                (true, _) => one * records,
                (false, _) => one * segments * value(|tile| &tile.shape, m, j),
            }
        });
        let mut low = degrees.clone();
        let mut high = spectrum.clone();
        for (low, high) in low.iter_mut().zip(&mut high) {
            let factors = table.at(*low);
            *low = *high * factors[0];
            *high *= factors[1];
        }

        let (all, effective) = match left_out {
            LeftOutEach::Realisation => {
                let all = self.count() * self.weights.tapers() as f64;
                (all, records * self.realisations.effective())
            }
            LeftOutEach::Record => (records, records),
        };
        let is_possible = effective >= 2.0 - 1e-9 && all >= 2.0;
        let quantile = match is_possible {
            true => student_two_sided(alpha, effective - 1.0),
            false => f64::NAN,
        };
        let jackknife = Array2::from_shape_fn(shape, |(m, j)| {
            // Realisations of a transient are not independent, its records are.
            let is_known = !sites[j].is_transient() || left_out == LeftOutEach::Record;
            if degrees[[m, j]].is_nan() || !is_possible || !is_known {
                return f64::NAN;
            }
            let sum = value(|tile| &tile.deviations, m, j);
            let squares = value(|tile| &tile.squares, m, j);
            let variance = (squares - sum * sum / all).max(0.0) * (all - 1.0) / all;
            quantile * (variance * all / effective).sqrt()
        });

        let mut sorted = steadiness.clone();
        sorted.sort_by(f64::total_cmp);
        let frequency = frequencies(length, field.time.step);
        let test = || self.line_test(field, tiles, &sites, &frequency, unit);
        let line_test = self.tests_lines().then(test);
        SpectrumEstimate {
            along: SpectrumAxis::Time,
            mean: None,
            mean_is_removed: !has_mean,
            segment: [length, length - self.realisations.segments.hop],
            half_bandwidth: self.half_bandwidth(field),
            independence: self.independence(sorted[sorted.len() / 2]),
            has_interval: sites
                .iter()
                .map(|site| !site.is_transient() || site.records > 1)
                .collect(),
            time: field.time.clone(),
            space: field.space.clone(),
            quantity: field.quantity,
            unit: field.unit.clone(),
            bins: frequency,
            steadiness,
            alpha,
            spectrum,
            degrees,
            low,
            high,
            jackknife,
            left_out,
            line_test,
        }
    }

    fn half_bandwidth(&self, field: &Field) -> Option<f64> {
        match self.request.averaging.tapers {
            crate::estimates::Tapers::Slepian { nw, .. } => {
                let duration = self.realisations.segments.length as f64 * field.time.step;
                Some(nw / duration)
            }
            crate::estimates::Tapers::Window(_) => None,
        }
    }

    fn line_test(
        &self,
        field: &Field,
        tiles: &[TileSums],
        sites: &[Independence],
        frequency: &[f64],
        unit: f64,
    ) -> LineTest {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let shape = (self.realisations.bins(), field.n_sites());
        let inside = 1..length.div_ceil(2);
        let more = (self.weights.tapers() - 1) as f64;
        let effective = self.realisations.effective_beside_lines();
        let [segments, beside] = effective.map(|one| one * self.shots.count() as f64);
        let degrees = [2.0 * segments, 2.0 * beside];
        let sums = |m: usize, j: usize, offset: usize| {
            tiles[j / TOGETHER].lines[m].at(offset, j % TOGETHER)
        };
        let f_at = |m: usize, j: usize, offset: usize| match inside.contains(&m) {
            true => {
                let (line, rest) = sums(m, j, offset);
                more * line / rest
            }
            false => f64::NAN,
        };
        let statistic = Array2::from_shape_fn(shape, |(m, j)| f_at(m, j, 0));
        let tested = sites.iter().filter(|site| !site.is_transient()).count();
        let cells = (inside.len() * tested * OFFSETS.len()).max(1) as f64;
        let level_of_all = fisher_level(alpha / cells, degrees);
        let line = |m: usize, j: usize, offset: usize| {
            let ((line, rest), gain) = (sums(m, j, offset), self.gains[offset]);
            let f = f_at(m, j, offset);
            let variance = rest / (2.0 * self.count() * more * gain);
            Line {
                column: j,
                at: frequency[m] + OFFSETS[offset] * frequency[1],
                amplitude: 2.0 * unit * (line / (self.count() * gain)).sqrt(),
                amplitude_error: 2.0 * unit * (variance / segments).sqrt(),
                f,
                probability: fisher_tail(f, degrees),
            }
        };
        let reach = self.half_bandwidth_bins();
        let mut lines = Vec::new();
        for j in (0..shape.1).filter(|j| !sites[*j].is_transient()) {
            // The offset with the largest F of each bin; F is NaN at the ends and of still sites.
            let best = |m: usize| {
                let offsets = (0..OFFSETS.len()).map(|offset| (f_at(m, j, offset), offset));
                offsets.fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
            };
            let best: Vec<(f64, usize)> = (0..shape.0).map(best).collect();
            for m in inside.clone() {
                let (f, offset) = best[m];
                let beside = m.saturating_sub(reach)..(m + reach + 1).min(shape.0);
                if f > level_of_all && best[beside].iter().all(|other| other.0 <= f) {
                    lines.push(line(m, j, offset));
                }
            }
        }
        lines.sort_by(|a, b| b.f.total_cmp(&a.f));
        LineTest {
            statistic,
            degrees,
            level: fisher_level(alpha, degrees),
            level_of_all,
            lines,
        }
    }

    fn half_bandwidth_bins(&self) -> usize {
        match self.request.averaging.tapers {
            crate::estimates::Tapers::Slepian { nw, .. } => nw.ceil() as usize,
            crate::estimates::Tapers::Window(_) => 1,
        }
    }
}
