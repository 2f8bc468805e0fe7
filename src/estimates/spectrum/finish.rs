//! From the sums over all realisations to spectra, intervals and lines.

use ndarray::Array2;

use super::lines::{Line, OFFSETS, line_and_rest};
use super::pass::{Pass, TileSums};
use super::{LeftOutEach, LineTest, SpectrumAxis, SpectrumEstimate};
use crate::estimates::realisations::{FactorTable, Independence, TOGETHER};
use crate::numeric::lanes::LaneBlock;
use crate::numeric::{fisher_level, fisher_tail, student_two_sided};
use crate::prepare::Detrend;
use crate::transform::{fold, frequencies};

impl Pass<'_> {
    fn steadiness(&self, tiles: &[TileSums], site: usize) -> f64 {
        let sum = tiles[site / TOGETHER].steadiness[site % TOGETHER];
        sum / self.records as f64
    }

    fn independence(&self, steadiness: f64) -> Independence {
        Independence::new(
            [
                self.records,
                self.realisations.segments.count(),
                self.weights.tapers(),
            ],
            self.realisations.effective(),
            steadiness,
        )
    }

    pub fn what_is_left_out(&self, tiles: &[TileSums]) -> LeftOutEach {
        let sites = self.grid.sites;
        let is_transient = |j: &usize| self.independence(self.steadiness(tiles, *j)).is_transient();
        match 2 * (0..sites).filter(is_transient).count() > sites {
            true => LeftOutEach::Record,
            false => LeftOutEach::Realisation,
        }
    }

    pub fn finish(
        &self,
        tiles: &[TileSums],
        left_out: LeftOutEach,
        unit: f64,
    ) -> SpectrumEstimate {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let grid = &self.grid;
        let shape = (self.realisations.bins(), grid.sites);
        let value = |blocks: fn(&TileSums) -> &Vec<LaneBlock>, m: usize, j: usize| {
            let blocks = blocks(&tiles[j / TOGETHER]);
            blocks
                .get(m)
                .map_or(f64::NAN, |block| block.0[j % TOGETHER])
        };
        let steadiness: Vec<f64> = (0..shape.1).map(|j| self.steadiness(tiles, j)).collect();
        let sites: Vec<Independence> = steadiness.iter().map(|s| self.independence(*s)).collect();
        let density = grid.time.step * unit * unit;
        let spectrum = Array2::from_shape_fn(shape, |(m, j)| {
            value(|tile| &tile.spectrum, m, j) * density * fold(m, length)
        });

        let records = self.records as f64;
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
        let is_possible = self.request.has_jackknife && effective >= 2.0 - 1e-9 && all >= 2.0;
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
        let frequency = frequencies(length, grid.time.step);
        let test = || self.line_test(tiles, &sites, &frequency, unit);
        let line_test = self.tests_lines().then(test);
        SpectrumEstimate {
            along: SpectrumAxis::Time,
            mean: None,
            mean_is_removed: !has_mean,
            segment: [length, length - self.realisations.segments.hop],
            half_bandwidth: self.half_bandwidth(),
            independence: self.independence(sorted[sorted.len() / 2]),
            has_jackknife: self.request.has_jackknife,
            has_interval: sites
                .iter()
                .map(|site| !site.is_transient() || site.records > 1)
                .collect(),
            time: grid.time.clone(),
            space: grid.space.clone(),
            quantity: grid.quantity,
            unit: grid.unit.clone(),
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

    fn half_bandwidth(&self) -> Option<f64> {
        match self.request.averaging.tapers {
            crate::estimates::Tapers::Slepian { nw, .. } => {
                let duration = self.realisations.segments.length as f64 * self.grid.time.step;
                Some(nw / duration)
            }
            crate::estimates::Tapers::Window(_) => None,
        }
    }

    fn line_test(
        &self,
        tiles: &[TileSums],
        sites: &[Independence],
        frequency: &[f64],
        unit: f64,
    ) -> LineTest {
        let (alpha, length) = (self.request.alpha, self.realisations.segments.length);
        let shape = (self.realisations.bins(), self.grid.sites);
        let inside = 1..length.div_ceil(2);
        let more = (self.weights.tapers() - 1) as f64;
        let effective = self.realisations.effective_beside_lines();
        let [segments, beside] = effective.map(|one| one * self.records as f64);
        let degrees = [2.0 * segments, 2.0 * beside];
        let sums = |m: usize, j: usize, offset: usize| {
            let lines = tiles[j / TOGETHER].lines.as_chunks().0;
            line_and_rest(&lines[m], offset, j % TOGETHER)
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
