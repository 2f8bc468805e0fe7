//! Whether noise explains what the best chain leaves of the records, and where it does not.
//!
//! Noise is stationary along each record and knows nothing of the signal. Two families of tests ask of the whitened
//! residual whether it is: with regressors made of the signal (its size, delay, width and decay, of each record and of
//! all), by Fisher's F beside the fitted unknowns; and by its variance in cells of time and site, and where the signal
//! is against where it is not. Each family is wrong in 2 % of fits to noise alone.

use serde::Serialize;

use super::model::Model;
use super::noise::Noise;
use super::records::Records;
use super::solver::{Beside, Minimum, dot};
use crate::numeric::fisher_tail;

/// Share of fits to noise alone that a family of tests calls a misfit.
const ALPHA: f64 = 0.02;

/// Parts of time, and fewest samples of one.
const PARTS: usize = 8;
const LEAST: usize = 12;

/// Regressors of which less than this share is left beside the unknowns say nothing.
const LEFT: f64 = 1e-3;

/// Share of a record's largest value below which there is no signal.
const QUIET: f64 = 0.01;

/// Share of the residual's power beyond the ends of its band, on both sides together.
const BEYOND: f64 = 0.1;

/// What noise does not explain, and where.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Misfit {
    /// Bodies whose records are missed; all, where most are.
    pub bodies: Vec<usize>,
    pub is_everywhere: bool,
    /// First and last time of the parts of time with too large a residual; `None` where it is no matter of time.
    pub times: Option<[f64; 2]>,
    /// Frequencies, in cycles, that nine tenths of the residual's power at these bodies lie between.
    pub frequencies: [f64; 2],
    /// The smallest probability of a test by noise alone, over the level of its family.
    pub level: f64,
}

/// What is judged.
struct Judged<'a> {
    records: &'a Records,
    /// Without missing samples, which are 0.
    residual: &'a [f64],
    known: &'a [bool],
    predicted: &'a [f64],
    columns: &'a [Vec<f64>],
    noise: &'a Noise,
}

/// What noise does not explain of what is left at a minimum; `None` for nothing.
pub(super) fn misfit(
    model: &Model,
    found: &Minimum,
    predicted: &[f64],
    noise: &Noise,
) -> Option<Misfit> {
    let known = &model.records.is_known()[..];
    let judged = Judged {
        records: model.records,
        residual: &found.residual[..known.len()],
        known,
        predicted,
        columns: &found.columns,
        noise,
    };
    judged.misfit()
}

/// Whitened numbers at the samples where they are known.
struct White {
    error: Vec<f64>,
    beside: Beside,
    /// Where in the records each is.
    places: Vec<usize>,
    degrees: f64,
    variance: f64,
}

impl Judged<'_> {
    fn times(&self) -> usize {
        self.records.times.len()
    }

    fn white(&self, grid: &[f64]) -> Vec<f64> {
        let white = self.noise.whitened(grid, self.known, self.times());
        white.into_iter().flatten().collect()
    }

    fn whitened(&self) -> Option<White> {
        let n = self.residual.len();
        let columns = self.columns.iter().map(|column| self.white(&column[..n]));
        // Unknowns that the records do not tell are no regressors.
        let beside = Beside::of(&columns.collect::<Vec<_>>(), 1e-9);
        let places = self.noise.whitened(self.residual, self.known, self.times());
        let places = places.iter().enumerate();
        let places: Vec<usize> = places.filter_map(|(at, white)| white.map(|_| at)).collect();
        let error = beside.rest(&self.white(self.residual));
        let degrees = (error.len() - beside.count()) as f64;
        let variance = dot(&error, &error) / degrees;
        (degrees > LEAST as f64 && variance > 0.0).then_some(White {
            error,
            beside,
            places,
            degrees,
            variance,
        })
    }

    fn misfit(&self) -> Option<Misfit> {
        let white = self.whitened()?;
        let (sites, times) = (self.records.bodies.len(), self.times());
        let mut by_site = vec![f64::INFINITY; sites];
        let shapes: Vec<Vec<Vec<f64>>> = (0..sites).map(|site| self.shapes(site)).collect();
        let tests = (sites + 1) as f64;
        for (site, level) in by_site.iter_mut().enumerate() {
            let alone = |shape: &Vec<f64>| self.white(&self.placed(site, shape));
            let regressors: Vec<Vec<f64>> = shapes[site].iter().take(4).map(alone).collect();
            *level = white.probability(regressors) * tests / ALPHA;
        }
        let together = (0..shapes[0].len()).map(|s| {
            let grid: Vec<f64> = shapes.iter().flat_map(|of| of[s].iter().copied()).collect();
            self.white(&grid)
        });
        let pooled = white.probability(together.collect()) * tests / ALPHA;
        let parts = self.parts();
        let part_of = |place: usize| parts.partition_point(|start| *start <= place % times) - 1;
        let cells = white.probabilities(sites * parts.len(), |place| {
            (place / times) * parts.len() + part_of(place)
        });
        let spans = white.probabilities(parts.len(), part_of);
        let loud = white.probabilities(2, |place| usize::from(self.is_quiet(place)));
        let tests = (cells.len() + spans.len() + 1) as f64;
        let level = |p: &f64| p * tests / ALPHA;
        let cells: Vec<f64> = cells.iter().map(level).collect();
        let spans: Vec<f64> = spans.iter().map(level).collect();
        for (cell, level) in cells.iter().enumerate() {
            by_site[cell / parts.len()] = by_site[cell / parts.len()].min(*level);
        }
        let least = |levels: &[f64]| levels.iter().copied().fold(f64::INFINITY, f64::min);
        let all = [least(&by_site), pooled, least(&spans), level(&loud[0])];
        let level = least(&all);
        (level < 1.0).then(|| {
            let late = |part: &usize| {
                spans[*part] < 1.0 || (0..sites).any(|s| cells[s * parts.len() + part] < 1.0)
            };
            let flagged: Vec<usize> = (0..parts.len()).filter(late).collect();
            self.place(level, &by_site, (&parts, &flagged))
        })
    }

    fn place(&self, level: f64, by_site: &[f64], (parts, flagged): (&[usize], &[usize])) -> Misfit {
        let times = self.times();
        let sites = by_site.len();
        let missed: Vec<usize> = (0..sites).filter(|site| by_site[*site] < 1.0).collect();
        let is_everywhere = missed.is_empty() || 4 * missed.len() >= 3 * sites.max(2);
        let shown = match is_everywhere {
            true => (0..sites).collect(),
            false => missed,
        };
        let is_part = 2 * flagged.len() <= parts.len();
        let ends = flagged.first().zip(flagged.last()).filter(|_| is_part);
        let span = ends.map(|(first, last)| {
            let end = parts.get(last + 1).copied().unwrap_or(times);
            [parts[*first], end - 1].map(|at| self.records.times[at])
        });
        let bodies = shown.iter().map(|site| self.records.bodies[*site]);
        Misfit {
            bodies: bodies.collect(),
            is_everywhere,
            times: span,
            frequencies: self.band(&shown),
            level,
        }
    }

    /// First sample of each part of time.
    fn parts(&self) -> Vec<usize> {
        let times = self.times();
        let count = PARTS.min(times / LEAST).max(1);
        (0..count).map(|part| part * times / count).collect()
    }

    fn is_quiet(&self, place: usize) -> bool {
        let times = self.times();
        let site = place / times;
        let record = &self.predicted[times * site..times * (site + 1)];
        let largest = record.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        self.predicted[place].abs() < QUIET * largest
    }

    fn placed(&self, site: usize, record: &[f64]) -> Vec<f64> {
        let mut grid = vec![0.0; self.residual.len()];
        let times = self.times();
        grid[times * site..times * (site + 1)].copy_from_slice(record);
        grid
    }

    /// Of a record: the signal, its rate, its curvature, the signal times the time; and for all together both times the
    /// place.
    fn shapes(&self, site: usize) -> Vec<Vec<f64>> {
        let times = self.times();
        let signal = self.predicted[times * site..times * (site + 1)].to_vec();
        let slope = |of: &[f64]| -> Vec<f64> {
            let around = (0..times).map(|i| (i.saturating_sub(1), (i + 1).min(times - 1)));
            let slope = |(a, b): (usize, usize)| (of[b] - of[a]) / (b - a).max(1) as f64;
            around.map(slope).collect()
        };
        let rate = slope(&signal);
        let bend = slope(&rate);
        let weighted = |of: &[f64], weight: &dyn Fn(usize) -> f64| -> Vec<f64> {
            of.iter().enumerate().map(|(i, v)| v * weight(i)).collect()
        };
        let energy = dot(&signal, &signal).max(f64::MIN_POSITIVE);
        let moments = signal.iter().enumerate();
        let centre: f64 = moments.map(|(i, v)| i as f64 * v * v / energy).sum();
        let late = |i: usize| (i as f64 - centre) / times as f64;
        let place = |_: usize| site as f64 / self.records.bodies.len() as f64 - 0.5;
        vec![
            weighted(&signal, &|_| 1.0),
            rate.clone(),
            bend,
            weighted(&signal, &late),
            weighted(&rate, &late),
            weighted(&signal, &place),
            weighted(&rate, &place),
        ]
    }

    /// The band of the residual at sites.
    fn band(&self, sites: &[usize]) -> [f64; 2] {
        let spectrum = self.records.spectrum(self.residual, sites);
        let total: f64 = spectrum.iter().sum();
        let step = 1.0 / (self.records.step() * 2.0 * (spectrum.len().max(2) - 1) as f64);
        let upto = |share: f64| {
            let mut sum = 0.0;
            let at = spectrum.iter().position(|power| {
                sum += power;
                sum >= share * total
            });
            at.unwrap_or(0) as f64 * step
        };
        [upto(0.5 * BEYOND), upto(1.0 - 0.5 * BEYOND)]
    }
}

impl White {
    /// The probability that noise is explained as well by the regressors, beside the unknowns.
    fn probability(&self, regressors: Vec<Vec<f64>>) -> f64 {
        let mut beside = self.beside.clone();
        let mut explained = 0.0;
        for regressor in &regressors {
            // Nothing is told by those that little is left of.
            if let Some(own) = beside.add(regressor, LEFT) {
                explained += dot(own, &self.error).powi(2);
            }
        }
        let count = (beside.count() - self.beside.count()) as f64;
        let rest = (self.variance * self.degrees - explained) / (self.degrees - count);
        match count > 0.0 && rest > 0.0 {
            true => fisher_tail(explained / count / rest, [count, self.degrees - count]),
            false => 1.0,
        }
    }

    /// The probability that noise is as large in a cell, against the others, of each cell.
    fn probabilities(&self, cells: usize, cell_of: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); cells];
        for (error, place) in self.error.iter().zip(&self.places) {
            let (squares, count) = &mut sums[cell_of(*place)];
            *squares += error * error;
            *count += 1.0;
        }
        let total = self.variance * self.degrees;
        let probability = |(squares, count): &(f64, f64)| {
            let others = self.degrees - count;
            let ratio = squares / count / ((total - squares) / others);
            match *count >= LEAST as f64 && others >= LEAST as f64 && total > *squares {
                true => fisher_tail(ratio, [*count, others]),
                false => 1.0,
            }
        };
        sums.iter().map(probability).collect()
    }
}
