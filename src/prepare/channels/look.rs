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

/// One record.
#[derive(Debug, Clone)]
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
    pub left_out: &'a [usize],
    pub records: Vec<Record>,
    /// What was read of each record, before the rest of constant ones.
    pub stretches: Vec<Range<usize>>,
    /// Samples of a stretch; and of those of a record that are looked at for gaps.
    pub length: usize,
    pub samples: usize,
    /// Whether these are all samples.
    pub is_whole: bool,
}

impl<'a> Look<'a> {
    pub fn new(
        field: &'a Field,
        times: Range<usize>,
        sites: Range<usize>,
        (left_out, known): (&'a [usize], Option<&[ChannelScan]>),
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
        let (read, hop) = match is_whole {
            true => (vec![times.clone()], length.div_ceil(2)),
            false => {
                let count = (most / length).clamp(1, STRETCHES);
                let start = |s: usize| times.start + s * (n - length) / (count - 1).max(1);
                let ranges = (0..count).map(|s| start(s)..start(s) + length);
                (ranges.collect(), length)
            }
        };
        let samples: usize = read.iter().map(Range::len).sum();
        let transform = RecordTransform::<f64>::new(&Window::Hann.samples(length), length);
        observer.stage("channels", sites.len() as u64);
        field.release_pages();
        let of_tile = |first: usize| -> Result<Vec<Record>> {
            observer.go_on()?;
            let own = first..sites.end.min(first + TILE);
            // The first of the next tile, too.
            let with_next = first..sites.end.min(own.end + 1);
            let mut records = vec![Vec::with_capacity(samples); with_next.len()];
            let mut block = Vec::new();
            for times in &read {
                block.resize(with_next.len() * times.len(), 0.0);
                field.read_site_major(times.clone(), with_next.clone(), &mut block);
                // Pages that are mapped count as memory, and a fault maps many.
                field.release_pages();
                for (record, samples) in records.iter_mut().zip(block.chunks_exact(times.len())) {
                    record.extend_from_slice(samples);
                }
            }
            let spectra: Vec<_> = records
                .iter_mut()
                .map(|record| Spectra::of(record, &transform, hop))
                .collect();
            observer.advance(own.len() as u64);
            let next = |i: usize| spectra.get(i + 1).map(|next| spectra[i].with(next));
            let found = (0..own.len()).map(|i| spectra[i].record(next(i).unwrap_or_default()));
            Ok(found.collect())
        };
        let firsts: Vec<usize> = sites.clone().step_by(TILE).collect();
        let tiles: Result<Vec<Vec<Record>>> = firsts.into_par_iter().map(of_tile).collect();
        let mut look = Look {
            field,
            sites,
            left_out,
            records: tiles?.concat(),
            length,
            samples: if known.is_some() { n } else { samples },
            is_whole: is_whole || known.is_some(),
            stretches: read,
        };
        for j in left_out.iter().filter(|j| look.sites.contains(j)) {
            let row = j - look.sites.start;
            look.records[row] = Record::NOTHING;
            if let Some(before) = row.checked_sub(1) {
                look.records[before].next.clear();
            }
        }
        if let Some(known) = known {
            let records = look.records.iter_mut().zip(known);
            records.for_each(|(record, scan)| record.scan = *scan);
        } else if !is_whole {
            // What is constant in the stretches may move between them.
            let rows = 0..look.records.len();
            let constant = rows.filter(|row| look.records[*row].scan.constant);
            let constant: Vec<usize> = constant.collect();
            for row in &constant {
                let scan = &mut look.records[*row].scan;
                scan.constant = constant.len() <= READ;
                if scan.constant {
                    let mut whole = vec![0.0; n];
                    let site = look.sites.start + row;
                    field.read_site_major(times.clone(), site..site + 1, &mut whole);
                    *scan = ChannelScan::of(&whole);
                    field.release_pages();
                }
            }
        }
        Ok(look)
    }

    /// Motion of a row about its mean over what was read of it; none at gaps.
    pub fn read(&self, row: usize) -> Vec<f64> {
        let site = self.sites.start + row;
        let read = |times: &Range<usize>| {
            let mut record = vec![0.0; times.len()];
            let own = site..site + 1;
            self.field.read_site_major(times.clone(), own, &mut record);
            record
        };
        let mut record: Vec<f64> = self.stretches.iter().flat_map(read).collect();
        let finite = || record.iter().copied().filter(|v| v.is_finite());
        let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
        for v in &mut record {
            *v = if v.is_finite() { *v - mean } else { 0.0 };
        }
        record
    }
}

impl Record {
    /// Of a site that is left out.
    const NOTHING: Record = Record {
        scan: ChannelScan::NOTHING,
        level: 0.0,
        top: 0.0,
        bands: [0.0; BANDS],
        next: Vec::new(),
    };

    pub fn top_power(&self) -> f64 {
        self.top * self.level * self.level
    }

    /// Half of the logarithm of the power in a band, that of an amplitude.
    pub fn log_power(&self, band: usize) -> f64 {
        let most = self.bands.iter().fold(0.0, |m: f64, b| m.max(*b));
        self.level.ln() + 0.5 * self.bands[band].max(ROUNDING * most).ln()
    }
}

/// The transforms of the stretches of a record over its largest magnitude.
struct Spectra {
    scan: ChannelScan,
    /// `[stretch * bins + bin]`; empty without motion.
    spectra: Vec<Complex<f64>>,
    /// Sum over the stretches, of each bin.
    powers: Vec<f64>,
    /// Root mean square from the mean, over the largest magnitude.
    level: f64,
}

impl Spectra {
    fn of(record: &mut [f64], transform: &RecordTransform<f64>, hop: usize) -> Spectra {
        let scan = ChannelScan::of(record);
        let (bins, length) = (transform.bins(), transform.padded());
        let (mut spectra, mut powers, mut level) = (Vec::new(), vec![0.0; bins], 0.0);
        if !scan.constant && scan.largest > 0.0 {
            // Lines across gaps leak less than zeros into what is held against the neighbours.
            let mut gaps = Vec::new();
            if scan.gaps > 0 {
                fill(record, 0, Gaps::Interpolate, &mut gaps);
                gaps.iter().for_each(|gap| record[gap.time] = gap.value);
            }
            let count = record.len() as f64;
            let mean = record.iter().map(|v| v / scan.largest).sum::<f64>() / count;
            let squares = record.iter().map(|v| (v / scan.largest - mean).powi(2));
            level = (squares.sum::<f64>() / count).sqrt();
            let mut scratch = RecordScratch::default();
            for start in (0..=record.len() - length).step_by(hop) {
                let stretch = &record[start..start + length];
                let mean = stretch.iter().sum::<f64>() / length as f64;
                let moving = stretch.iter().map(|v| (v - mean) / scan.largest);
                let moving: Vec<f64> = moving.collect();
                let (found, _) = transform.transform(std::iter::once(&*moving), &mut scratch);
                let own = powers.iter_mut().zip(found);
                own.for_each(|(power, x)| *power += x.norm_sqr());
                spectra.extend_from_slice(found);
            }
        }
        Spectra {
            scan,
            level,
            spectra,
            powers,
        }
    }

    /// `<conj(X) Y> / sqrt(<|X|^2> <|Y|^2>)` over all bins, so that magnitudes sum to 1 of records that follow each other.
    fn with(&self, next: &Spectra) -> Vec<Complex<f64>> {
        let total = |spectra: &Spectra| spectra.powers.iter().sum::<f64>();
        let scale = (total(self) * total(next)).sqrt();
        if self.spectra.is_empty() || next.spectra.is_empty() || scale == 0.0 {
            return Vec::new();
        }
        let mut sums = vec![Complex::default(); self.powers.len()];
        let stretches = self.spectra.chunks_exact(sums.len());
        for (x, y) in stretches.zip(next.spectra.chunks_exact(sums.len())) {
            let products = x.iter().zip(y).map(|(x, y)| x.conj() * y / scale);
            sums.iter_mut().zip(products).for_each(|(sum, z)| *sum += z);
        }
        sums
    }

    fn record(&self, next: Vec<Complex<f64>>) -> Record {
        let bins = self.powers.len();
        let total: f64 = self.powers.iter().sum();
        let share = |bins: Range<usize>| match total > 0.0 {
            true => self.powers[bins].iter().sum::<f64>() / total,
            false => 0.0,
        };
        let edge = |band: usize| band * bins / BANDS;
        Record {
            scan: self.scan,
            level: self.scan.largest * self.level,
            top: share(9 * bins / 10..bins),
            bands: std::array::from_fn(|band| share(edge(band)..edge(band + 1))),
            next,
        }
    }
}
