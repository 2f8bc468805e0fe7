//! From the sums of the pass to the estimate: intervals, jackknife, lines.

use ndarray::Array2;
use rayon::prelude::*;

use super::lines::{LINE_BLOCKS, Line, OFFSETS, line_and_rest};
use super::noise::LeadIn;
use super::pass::{Pass, TileSums};
use super::{LeftOutEach, LineTest, SpectrumEstimate};
use crate::error::Result;
use crate::estimates::FieldAxis;
use crate::estimates::realisations::{FactorTable, Independence, TOGETHER, share_that_counts};
use crate::numeric::lanes::LaneBlock;
use crate::numeric::{fisher_level, fisher_tail, median, student_two_sided};

use crate::transform::{fold, frequencies};

/// Bias that filled samples leave, in standard deviations of a value, from which on no interval is stated: with as much an interval
/// of 95 % holds in 93 %. The smallest value among so many bins on either side tells, as one that is large by chance would not.
const FILLING: (f64, usize) = (0.4, 2);
/// Share of the power of white noise that detrending takes of a bin, from which on no interval is stated.
pub(super) const DETRENDED: f64 = 0.05;

impl Pass<'_> {
    pub fn finish(
        &self,
        mut tiles: Vec<TileSums>,
        left_out: LeftOutEach,
        has_noise: bool,
    ) -> Result<SpectrumEstimate> {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let grid = self.grid;
        let shape = (self.realisations.bins(), grid.sites);
        // Blocks of all tiles are taken out once they are needed, so that their memory is free for the arrays.
        let mut taken = |blocks: fn(&mut TileSums) -> &mut Vec<LaneBlock>| -> Vec<Vec<LaneBlock>> {
            let tiles = tiles.iter_mut();
            tiles.map(|tile| std::mem::take(blocks(tile))).collect()
        };
        let value = |tiles: &[Vec<LaneBlock>], m: usize, j: usize| {
            let block = tiles[j / TOGETHER].get(m);
            block.map_or(f64::NAN, |block| block.0[j % TOGETHER])
        };
        let powers = taken(|tile| &mut tile.spectrum);
        let shapes = taken(|tile| &mut tile.shape);
        let deviations = taken(|tile| &mut tile.deviations);
        let squares = taken(|tile| &mut tile.squares);
        let tiles = &tiles[..];
        let steadiness: Vec<f64> = (0..shape.1).map(|j| self.steadiness(tiles, j)).collect();
        let median = median(steadiness.iter().copied()).unwrap_or(f64::NAN);
        let sites: Vec<Independence> = steadiness.iter().map(|s| self.independence(*s)).collect();
        let density = grid.time.step;
        let records = self.records as f64;
        let segments = records * self.effective_segments;
        let left = tiles.iter().flat_map(|tile| &tile.sums.left);
        let left = self.realisations.segments_left(self.records, left)?;
        // Of a site: records, segments of all of them, effective segments.
        let of_site = |j: usize| match &left {
            None => (self.records, self.count(), segments),
            Some(left) => {
                let pairs = &tiles[j / TOGETHER].sums.left[j % TOGETHER];
                let effective = left.effective[j] / self.weights.tapers() as f64;
                (pairs.records, pairs.segments(), effective)
            }
        };
        let spectrum = Array2::from_shape_fn(shape, |(m, j)| {
            let power = value(&powers, m, j) * density * fold(m, length);
            // No segment is left, or not one sample was there.
            let is_empty = of_site(j).0 == 0 || (power == 0.0 && steadiness[j].is_nan());
            if is_empty { f64::NAN } else { power }
        });
        drop(powers);
        let most = 2.0 * segments.max(records) * self.weights.tapers() as f64;
        let table = FactorTable::new([segments.min(records).min(1.0), most.max(2.0)], alpha);

        let detrended = self.realisations.lost();
        let is_detrended = |m: usize| detrended[m] > DETRENDED;
        let is_known = |[m, j]: [usize; 2], degrees: f64| {
            let [white, _] = self.filled(tiles, j);
            let near = m.saturating_sub(FILLING.1).max(1)..(m + FILLING.1 + 1).min(shape.0);
            let smallest = match white > 0.0 {
                true => near.fold(f64::INFINITY, |least, m| least.min(spectrum[[m, j]])),
                false => spectrum[[m, j]],
            };
            2.0 * density * white / smallest < FILLING.0 * (2.0 / degrees).sqrt()
        };
        let counting = steadiness.par_iter().enumerate().map(|(j, steadiness)| {
            let spectrum = spectrum.column(j).into_iter().skip(1).copied();
            let samples = self.realisations.segments.record;
            share_that_counts(*steadiness, samples, (spectrum, length))
        });
        let counting: Vec<f64> = counting.collect();
        let degrees = Array2::from_shape_fn(shape, |(m, j)| {
            // Transforms at 0 and at the Nyquist frequency are real.
            let one = fold(m, length);
            let (records, _, segments) = of_site(j);
            let degrees = match (sites[j].is_transient(), records) {
                (true, 0..2) => f64::NAN,
                (true, _) => one * records as f64,
                (false, _) => one * (segments * value(&shapes, m, j) * counting[j]).max(1.0),
            };
            match is_known([m, j], degrees) && !(m == 0 && is_detrended(m)) {
                true => degrees,
                false => f64::NAN,
            }
        });
        drop(shapes);
        // Of a site: realisations that are left out one by one, their effective number, and Student's quantile.
        let left_out_of = |j: usize| {
            let (records, count, segments) = of_site(j);
            let tapers = self.weights.tapers() as f64;
            let (all, effective) = match left_out {
                LeftOutEach::Realisation => (count * tapers, segments * tapers),
                LeftOutEach::Record => (records as f64, records as f64),
            };
            let is_possible = self.request.has_jackknife && effective >= 2.0 - 1e-9 && all >= 2.0;
            let quantile = match is_possible {
                true => student_two_sided(alpha, effective - 1.0),
                false => f64::NAN,
            };
            [all, effective, quantile]
        };
        let of_sites: Vec<[f64; 3]> = match left {
            None => vec![left_out_of(0); shape.1],
            Some(_) => (0..shape.1).map(left_out_of).collect(),
        };
        let of_tapers =
            self.realisations.segment_count() == 1 && left_out == LeftOutEach::Realisation;
        let jackknife = Array2::from_shape_fn(shape, |(m, j)| {
            // Realisations of a transient are not independent, its records are.
            let is_known = !sites[j].is_transient() || left_out == LeftOutEach::Record;
            let [all, effective, quantile] = of_sites[j];
            let is_known = is_known && !is_detrended(m);
            if degrees[[m, j]].is_nan() || quantile.is_nan() || !is_known {
                return f64::NAN;
            }
            let (sum, squares) = (value(&deviations, m, j), value(&squares, m, j));
            let variance = (squares - sum * sum / all).max(0.0) * (all - 1.0) / all;
            // Tapers of one segment share its unequal parts.
            let counting = if of_tapers { counting[j] } else { 1.0 };
            quantile * (variance * all / (effective * counting)).sqrt() + self.filled(tiles, j)[1]
        });

        drop((deviations, squares));
        let [mut low, mut high] = table.ends(&spectrum, &degrees);
        for (j, mut high) in high.columns_mut().into_iter().enumerate() {
            let [_, lost] = self.filled(tiles, j);
            high.mapv_inplace(|end| end / (1.0 - lost));
        }
        for m in (0..shape.0).filter(|m| is_detrended(*m)) {
            low.row_mut(m).fill(f64::NAN);
            high.row_mut(m).fill(f64::NAN);
        }
        let frequency = frequencies(length, grid.time.step);
        let has_interval = |j: usize| match of_site(j).0 {
            0 => false,
            records => !sites[j].is_transient() || records > 1,
        };
        let half_bandwidth = self.request.averaging.tapers.half_bandwidth();
        let mut found = SpectrumEstimate {
            noise: None,
            along: FieldAxis::Time,
            mean: None,
            mean_is_removed: self.realisations.about_mean(),
            detrended,
            segment: [length, length - self.realisations.segments.hop],
            half_bandwidth: half_bandwidth.map(|nw| nw / (length as f64 * grid.time.step)),
            independence: self
                .realisations
                .independence(self.records, left.as_ref(), median),
            has_interval: (0..shape.1).map(has_interval).collect(),
            segments_left: left,
            has_jackknife: self.request.has_jackknife,
            time: grid.time.clone(),
            space: grid.space.clone(),
            quantity: grid.quantity,
            unit: grid.unit.clone(),
            line_test: (self.tests_lines()).then(|| self.line_test(tiles, &sites, &frequency)),
            bins: frequency,
            steadiness,
            alpha,
            spectrum,
            degrees,
            low,
            high,
            jackknife,
            left_out,
        };
        if has_noise && self.request.along == FieldAxis::Time {
            let lead_ins = tiles.iter().flat_map(|tile| tile.lead_ins);
            let lead_ins: Vec<LeadIn> = lead_ins.take(shape.1).collect();
            found.find_noise(&lead_ins, 2.0 * density, self.realisations.shared_bins());
            if self.request.subtract_noise {
                found.subtract_noise()?;
            }
        }
        Ok(found)
    }

    fn line_test(&self, tiles: &[TileSums], sites: &[Independence], frequency: &[f64]) -> LineTest {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let shape = (self.realisations.bins(), self.grid.sites);
        let inside = 1..length.div_ceil(2);
        let more = (self.weights.tapers() - 1) as f64;
        let shared = self.realisations.shared_beside_lines();
        let effective = self.realisations.effective_beside_lines(None, &shared);
        let degrees = effective.map(|one| 2.0 * (one * self.records as f64));
        let sums = |m: usize, j: usize, offset: usize| {
            let sums = &tiles[j / TOGETHER].sums.plain;
            let lines = sums[sums.len() - shape.0 * LINE_BLOCKS..].as_chunks().0;
            line_and_rest(&lines[m], offset, j % TOGETHER)
        };
        let f_at = |m: usize, j: usize, offset: usize| {
            let (line, rest) = sums(m, j, offset);
            if inside.contains(&m) {
                more * line / rest
            } else {
                f64::NAN
            }
        };
        let statistic = Array2::from_shape_fn(shape, |(m, j)| f_at(m, j, 0));
        let tested = sites.iter().filter(|site| !site.is_transient()).count();
        let cells = (inside.len() * tested * OFFSETS.len()).max(1) as f64;
        let level_of_all = fisher_level(alpha / cells, degrees);
        // Of a site from which segments are left out: its own degrees of freedom and level of all cells.
        let of_site = |j: usize| match tiles[j / TOGETHER].sums.left.get(j % TOGETHER) {
            None => (degrees, level_of_all),
            Some(left) if left.records == 0 => (degrees, f64::INFINITY),
            left => {
                let effective = self.realisations.effective_beside_lines(left, &shared);
                let own = effective.map(|one| 2.0 * one);
                (own, fisher_level(alpha / cells, own))
            }
        };
        let line = |m: usize, j: usize, offset: usize, degrees: [f64; 2]| {
            let count = self.counts(&tiles[j / TOGETHER])[j % TOGETHER];
            let ((line, rest), gain) = (sums(m, j, offset), self.gains[offset]);
            let f = f_at(m, j, offset);
            let variance = rest / (2.0 * count * more * gain);
            Line {
                column: j,
                at: frequency[m] + OFFSETS[offset] * frequency[1],
                amplitude: 2.0 * (line / (count * gain)).sqrt(),
                amplitude_error: 2.0 * (variance / (0.5 * degrees[0])).sqrt(),
                f,
                probability: fisher_tail(f, degrees),
            }
        };
        let reach = self.request.averaging.tapers.half_bandwidth();
        let reach = reach.map_or(1, |nw| nw.ceil() as usize);
        let mut lines = Vec::new();
        for j in (0..shape.1).filter(|j| !sites[*j].is_transient()) {
            // The offset with the largest F of each bin; F is NaN at the ends and of still sites.
            let best = |m: usize| {
                let offsets = (0..OFFSETS.len()).map(|offset| (f_at(m, j, offset), offset));
                offsets.fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
            };
            let (degrees, level) = of_site(j);
            let best: Vec<(f64, usize)> = (0..shape.0).map(best).collect();
            for m in inside.clone() {
                let (f, offset) = best[m];
                let beside = m.saturating_sub(reach)..(m + reach + 1).min(shape.0);
                if f > level && best[beside].iter().all(|other| other.0 <= f) {
                    lines.push(line(m, j, offset, degrees));
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
}
