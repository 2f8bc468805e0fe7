//! How many of the realisations are independent.

use std::ops::Range;

use crate::field::Field;
use crate::numeric::sum_of_squares;

/// How many independent realisations an average stands on.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Independence {
    /// Records of each site: shots.
    pub records: usize,
    /// Segments of a record.
    pub segments: usize,
    /// Tapers of a segment.
    pub tapers: usize,
    /// The effective number of a stationary record's realisations, of all records together.
    pub effective: f64,
    /// How evenly the energy of the reference is spread over its record: `(sum e)^2 / (n sum e^2)` of the
    /// energies of `n` parts; 1 for a steady record, `1 / n` for a pulse. NaN where more than a twentieth of the samples were
    /// filled or masked.
    pub steadiness: f64,
    /// The number that significance is stated by: `effective` of steady records, else that of the
    /// records. `None` where it is below 2.
    pub independent: Option<f64>,
    /// Whether records are too short to tell how steady they are; each is one realisation.
    #[serde(skip)]
    pub is_short: bool,
}

/// Parts of a record whose energies are compared.
pub(super) const PARTS: usize = 16;
/// Samples of a record, below which parts of noise have energies as uneven as those of a transient.
pub(super) const SHORT: usize = 2 * PARTS;
/// Narrow-band noise whose parts hold one independent value each has 1/2.
pub(crate) const LEAST_STEADINESS: f64 = 1.0 / 3.0;

impl Independence {
    /// Of records of so many samples.
    pub(crate) fn new(
        [records, segments, tapers]: [usize; 3],
        effective_of_one: f64,
        steadiness: f64,
        samples: usize,
    ) -> Self {
        let effective = records as f64 * effective_of_one;
        let is_short = samples < SHORT;
        let independent = match steadiness >= LEAST_STEADINESS && !is_short {
            true => effective,
            false => records as f64,
        };
        Independence {
            records,
            segments,
            tapers,
            effective,
            steadiness,
            independent: (independent >= 2.0).then_some(independent),
            is_short,
        }
    }

    /// With fewer independent realisations, where they share so unevenly what is averaged that few of them count.
    pub(crate) fn of_uneven(mut self, evenness: f64) -> Self {
        let independent = self.independent.map(|k| k * evenness.min(1.0));
        self.independent = independent.filter(|k| *k >= 2.0);
        self
    }

    /// Whether the reference is one realisation: a transient, whose segments are not independent, or a record of which
    /// too much was filled, or that is too short.
    pub fn is_transient(&self) -> bool {
        self.is_short || self.steadiness.is_nan() || self.steadiness < LEAST_STEADINESS
    }

    /// Why it is one realisation.
    pub fn why(&self) -> &'static str {
        match (self.is_short, self.steadiness.is_nan()) {
            (true, _) => "records of fewer than 32 samples are too short",
            (_, true) => "more than a twentieth of the samples were filled",
            _ => "one transient is one realisation",
        }
    }

    /// The magnitude-squared coherence (or bicoherence) that one cell exceeds by chance with probability
    /// `alpha` where the true one is 0: `1 - alpha^{1/(K-1)}`. Source: Carter, Knapp, Nuttall, IEEE
    /// Trans. Audio Electroacoust. 21, 337 (1973).
    pub fn level(&self, alpha: f64) -> Option<f64> {
        Some(level_of_chance(self.independent?, alpha))
    }
}

/// See [`Independence::level`].
pub(crate) fn level_of_chance(independent: f64, alpha: f64) -> f64 {
    -(alpha.ln() / (independent - 1.0)).exp_m1()
}

/// The same of a record with zeros for the `missing` samples, in ascending order: parts count by the samples they
/// have, and not at all if that is less than half. Where detrending takes offsets away, they are none of what moves.
pub(crate) fn steadiness_without(record: &[f64], missing: &[usize], about_mean: bool) -> f64 {
    let length = (record.len() / PARTS).max(1);
    let count = record.len() - missing.len();
    let mean = match about_mean && count > 0 {
        true => record.iter().sum::<f64>() / count as f64,
        false => 0.0,
    };
    let mut energies = Vec::with_capacity(PARTS);
    for (part, samples) in record.chunks_exact(length).enumerate() {
        let before = |end: usize| missing.partition_point(|n| *n < end);
        let there = length + before(part * length) - before((part + 1) * length);
        if 2 * there >= length {
            let of_all: f64 = samples.iter().map(|v| (v - mean).powi(2)).sum();
            let energy = of_all - (length - there) as f64 * mean * mean;
            energies.push(energy.max(0.0) * length as f64 / there as f64);
        }
    }
    evenness(&energies)
}

/// See [`Independence::steadiness`]; 1 for a record of zeros.
pub(crate) fn steadiness(record: &[f64]) -> f64 {
    steadiness_without(record, &[], false)
}

/// Of sites with their steadiness and energy, that of the one at which half of the energy lies at sites that are
/// less steady: a pulse that passes all sites is a transient at each, though the energy of all of them is steady.
pub(crate) fn steadiness_of_sites(mut sites: Vec<(f64, f64)>) -> f64 {
    // Marked sites may hold the most.
    if sites.iter().any(|(steadiness, _)| steadiness.is_nan()) {
        return f64::NAN;
    }
    sites.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sites.iter().map(|(_, energy)| energy).sum::<f64>();
    let mut below = 0.0;
    for (steadiness, energy) in &sites {
        below += energy;
        if below > half {
            return *steadiness;
        }
    }
    1.0
}

/// The same of the sites of a field in blocks that are read together; NaN where one misses more than a share of its samples.
pub(crate) fn steadiness_of_field(
    field: &Field,
    blocks: impl Iterator<Item = Range<usize>>,
    most_missing: f64,
) -> f64 {
    let times = field.n_times();
    let (mut sites, mut records) = (Vec::new(), Vec::new());
    for block in blocks {
        records.resize(times * block.len(), 0.0);
        field.read_site_major(0..times, block, &mut records);
        for record in records.chunks_exact_mut(times) {
            let missing = (0..times).filter(|n| !record[*n].is_finite());
            let missing: Vec<usize> = missing.collect();
            missing.iter().for_each(|n| record[*n] = 0.0);
            // Squares of squares stay numbers.
            let largest = record.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            let unit = if largest > 0.0 { largest } else { 1.0 };
            record.iter_mut().for_each(|v| *v /= unit);
            let steadiness = match missing.len() as f64 > most_missing * times as f64 {
                true => f64::NAN,
                false => steadiness_without(record, &missing, true),
            };
            sites.push((steadiness, sum_of_squares(record), largest));
        }
    }
    field.release_pages();
    let most = sites
        .iter()
        .fold(f64::MIN_POSITIVE, |m, site| m.max(site.2));
    let relative = |(s, energy, own): (f64, f64, f64)| (s, energy * (own / most).powi(2));
    steadiness_of_sites(sites.into_iter().map(relative).collect())
}

pub(super) fn evenness(energies: &[f64]) -> f64 {
    let all: f64 = energies.iter().sum();
    let squares: f64 = energies.iter().map(|e| e * e).sum();
    match squares > 0.0 || squares.is_nan() {
        true => all * all / (energies.len() as f64 * squares),
        false => 1.0,
    }
}
