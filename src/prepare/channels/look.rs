//! A look at every record, for what single channels have.

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;

use crate::error::Result;
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::scan::{ChannelScan, fill};
use crate::prepare::{Gaps, Window};
use crate::transform::{RecordScratch, RecordTransform};

/// Samples of a stretch of the record at most, and stretches, evenly spread.
const LENGTH: usize = 1024;
const STRETCHES: usize = 16;
/// Samples of a stretch, below which the whole record is one.
const SHORT: usize = 64;
/// Bands of the frequency axis whose levels are compared.
pub(super) const BANDS: usize = 8;
/// Sites that a thread reads together.
const TILE: usize = 8;
/// Samples that are looked at, at most: fewer of each record where there are many.
const SAMPLES: usize = 1 << 20;
/// Records that are constant where they are looked at, of which the rest is read, at most.
const READ: usize = 16;
/// Power of a band over that of the strongest, below which it holds only rounding.
const ROUNDING: f64 = 1e-20;

/// One record; by default one that is left out.
#[derive(Debug, Clone, Default)]
pub(super) struct Record {
    pub scan: ChannelScan,
    /// Root mean square of the motion; powers over that of all bins: of the top tenth of the axis, and of bands.
    pub level: f64,
    pub top: f64,
    pub bands: [f64; BANDS],
    /// Cross-spectrum with the next record, both of unit power; empty without motion.
    pub next: Vec<Complex<f64>>,
}

/// What a part of each record holds.
pub(super) struct Look<'a> {
    pub field: &'a Field,
    pub sites: Range<usize>,
    pub records: Vec<Record>,
    /// What was read of each record, before the rest of constant ones.
    stretches: Vec<Range<usize>>,
    /// Samples of a stretch; and of those of a record that are looked at for gaps.
    pub length: usize,
    pub samples: usize,
}

impl<'a> Look<'a> {
    pub fn new(
        field: &'a Field,
        times: Range<usize>,
        sites: Range<usize>,
        (left_out, known): (&[usize], Option<&[ChannelScan]>),
        observer: &dyn Observer,
    ) -> Result<Look<'a>> {
        let n = times.len();
        let most = (SAMPLES / sites.len()).clamp(1, LENGTH * STRETCHES);
        // Of a record that is looked at as a whole they overlap by half: a pulse lies in one of them.
        let is_whole = n <= most;
        let length = match (is_whole, n / 8) {
            (true, ..SHORT) => n,
            (true, eighth) => eighth,
            (false, _) => (most / STRETCHES).max(SHORT.min(most)).min(n),
        };
        let (stretches, hop) = match is_whole {
            true => (vec![times.clone()], length.div_ceil(2)),
            false => {
                let count = (most / length).clamp(1, STRETCHES);
                let start = |s: usize| times.start + s * (n - length) / (count - 1).max(1);
                let ranges = (0..count).map(|s| start(s)..start(s) + length);
                (ranges.collect(), length)
            }
        };
        let mut look = Look {
            field,
            sites,
            records: Vec::new(),
            length,
            samples: stretches.iter().map(Range::len).sum(),
            stretches,
        };
        let transform = RecordTransform::<f64>::new(&Window::Hann.samples(length), length);
        observer.stage("channels", look.sites.len() as u64);
        field.release_pages();
        let of_tile = |first: usize| -> Result<Vec<Record>> {
            observer.go_on()?;
            let own = first..look.sites.end.min(first + TILE);
            // The first of the next tile, too.
            let with_next = first..look.sites.end.min(own.end + 1);
            let records = with_next.clone().zip(look.read(with_next));
            let found = records.map(|(j, record)| match left_out.contains(&j) {
                true => Default::default(),
                false => Record::of(record, &transform, hop),
            });
            let (mut found, spectra): (Vec<Record>, Vec<_>) = found.unzip();
            for (record, pair) in found.iter_mut().zip(spectra.windows(2)) {
                record.next = cross_spectrum(&pair[0], &pair[1], transform.bins());
            }
            found.truncate(own.len());
            observer.advance(own.len() as u64);
            Ok(found)
        };
        let firsts: Vec<usize> = look.sites.clone().step_by(TILE).collect();
        let tiles: Result<Vec<Vec<Record>>> = firsts.into_par_iter().map(of_tile).collect();
        look.records = tiles?.into_iter().flatten().collect();
        if let Some(known) = known {
            look.samples = n;
            let records = look.records.iter_mut().zip(known);
            records.for_each(|(record, scan)| record.scan = *scan);
        } else if !is_whole {
            // What is constant in the stretches may move between them.
            let constant = look.sites.clone().zip(&mut look.records);
            let constant: Vec<_> = constant.filter(|(_, r)| r.scan.constant).collect();
            let are_read = constant.len() <= READ;
            for (site, record) in constant {
                record.scan.constant = false;
                if are_read {
                    let mut whole = vec![0.0; n];
                    field.read_site_major(times.clone(), site..site + 1, &mut whole);
                    record.scan = ChannelScan::of(&whole);
                    field.release_pages();
                }
            }
        }
        Ok(look)
    }

    /// The stretches of each of these sites of the field, one after the other.
    fn read(&self, sites: Range<usize>) -> Vec<Vec<f64>> {
        let mut records = vec![Vec::new(); sites.len()];
        let mut block = Vec::new();
        for times in &self.stretches {
            block.resize(sites.len() * times.len(), 0.0);
            self.field
                .read_site_major(times.clone(), sites.clone(), &mut block);
            // Pages that are mapped count as memory, and a fault maps many.
            self.field.release_pages();
            for (record, samples) in records.iter_mut().zip(block.chunks_exact(times.len())) {
                record.extend_from_slice(samples);
            }
        }
        records
    }

    /// Motion of a row about its mean over what was read of it; none at gaps.
    pub fn motion(&self, row: usize) -> Vec<f64> {
        let site = self.sites.start + row;
        let mut record = self.read(site..site + 1).concat();
        let finite = || record.iter().copied().filter(|v| v.is_finite());
        let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
        for v in &mut record {
            *v = if v.is_finite() { *v - mean } else { 0.0 };
        }
        record
    }
}

impl Record {
    /// Of these samples, and the spectra of its stretches over the root of the power of all; empty without motion.
    fn of(
        mut record: Vec<f64>,
        transform: &RecordTransform<f64>,
        hop: usize,
    ) -> (Record, Vec<Complex<f64>>) {
        let scan = ChannelScan::of(&record);
        let mut found = Record {
            scan,
            ..Record::default()
        };
        let mut spectra = Vec::new();
        if scan.constant || scan.largest == 0.0 {
            return (found, spectra);
        }
        // Lines across gaps leak less than zeros into what is held against the neighbours.
        let gaps = fill(&record, 0, Gaps::Interpolate);
        gaps.iter().for_each(|gap| record[gap.time] = gap.value);
        record.iter_mut().for_each(|v| *v /= scan.largest);
        let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len() as f64;
        let middle = mean(&record);
        let squares: Vec<f64> = record.iter().map(|v| (v - middle).powi(2)).collect();
        found.level = scan.largest * mean(&squares).sqrt();
        let (bins, length) = (transform.bins(), transform.padded());
        let mut powers = vec![0.0; bins];
        let mut scratch = RecordScratch::default();
        for start in (0..=record.len() - length).step_by(hop) {
            let stretch = &record[start..start + length];
            let middle = mean(stretch);
            let moving: Vec<f64> = stretch.iter().map(|v| v - middle).collect();
            let own = transform.spectra_of_rows(&moving, 1, &mut scratch);
            for (power, x) in powers.iter_mut().zip(own) {
                *power += x.norm_sqr();
            }
            spectra.extend_from_slice(own);
        }
        let total: f64 = powers.iter().sum();
        if total == 0.0 {
            return (found, Vec::new());
        }
        spectra.iter_mut().for_each(|x| *x /= total.sqrt());
        let share = |bins: Range<usize>| powers[bins].iter().sum::<f64>() / total;
        let edge = |band: usize| band * bins / BANDS;
        found.top = share(9 * bins / 10..bins);
        found.bands = std::array::from_fn(|band| share(edge(band)..edge(band + 1)));
        (found, spectra)
    }

    pub fn top_power(&self) -> f64 {
        self.top * self.level * self.level
    }

    /// Half of the logarithm of the power in a band, that of an amplitude.
    pub fn log_power(&self, band: usize) -> f64 {
        let most = self.bands.iter().fold(0.0, |m: f64, b| m.max(*b));
        self.level.ln() + 0.5 * self.bands[band].max(ROUNDING * most).ln()
    }
}

/// `<conj(X) Y> / sqrt(<|X|^2> <|Y|^2>)` over all bins, so that magnitudes sum to 1 of records that follow each other; empty
/// without motion.
fn cross_spectrum(x: &[Complex<f64>], y: &[Complex<f64>], bins: usize) -> Vec<Complex<f64>> {
    let is_empty = x.is_empty() || y.is_empty();
    let mut sums = vec![Complex::default(); if is_empty { 0 } else { bins }];
    for (x, y) in x.chunks(bins).zip(y.chunks(bins)) {
        let products = x.iter().zip(y).map(|(x, y)| x.conj() * y);
        sums.iter_mut().zip(products).for_each(|(sum, z)| *sum += z);
    }
    sums
}
