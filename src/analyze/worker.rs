//! Records of a few sites to their mean power spectra: by one thread, with its own buffers.

use std::ops::Range;

use ndarray::{Array2, ArrayView2, ArrayViewMut2, s};
use num_complex::Complex;

use super::columns::AlongTime;
use super::stages::Stages;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};
use crate::prepare::Trend;
use crate::system::prefetch::{LINE, prefetch_after};
use crate::transform::{Real, RecordScratch, fold, power};

/// Records of a few sites to spectra, with the thread's own buffers.
#[derive(Default)]
pub(super) struct Worker<T> {
    scratch: RecordScratch<T>,
    /// Segments without their trends, one a record.
    segments: Vec<f64>,
    fit: Vec<f64>,
    /// Transforms of one segment, where they are not kept.
    passing: Array2<Complex<T>>,
    /// Mean power spectra of the segments, of each site a lane.
    pub power: Vec<LaneBlock>,
    /// `sum (w v)^2` over the segments of each record.
    pub energies: Vec<f64>,
}

impl<T: Real> Worker<T> {
    /// Spectra and energies of `samples`, interleaved or, if segments are detrended one by one, record after record, of `width` sites from `first` on.
    ///
    /// `kept`, `(bin x segment, site)`, gets the transforms.
    pub fn spectra(
        &mut self,
        of: &AlongTime<T>,
        sites: Range<usize>,
        samples: &[f64],
        mut kept: Option<ArrayViewMut2<Complex<T>>>,
    ) {
        let segments = of.stages.plan.segments;
        let (bins, width) = (of.transform.bins(), sites.len());
        // Unused lanes are not read.
        self.power.resize(bins, LaneBlock::default());
        self.energies.clear();
        self.energies.resize(width, 0.0);
        let n = of.transform.padded();
        let mean = of.stages.plan.time_scale.factor / segments.count() as f64;
        let mut passing = std::mem::take(&mut self.passing);
        if kept.is_none() && passing.dim() != (bins, width) {
            passing = Array2::default((bins, width));
        }
        for (s, start) in segments.starts().enumerate() {
            let mut spectra = match &mut kept {
                Some(kept) => kept.slice_mut(s![s..;segments.count(), ..]),
                None => passing.view_mut(),
            };
            let span = start..start + segments.length;
            self.segment(of, &sites, samples, span, spectra.view_mut());
            let (is_first, is_last) = (s == 0, s + 1 == segments.count());
            widest(AddPowers {
                spectra: spectra.view(),
                sums: &mut self.power,
                is_first,
                factor: |m| if is_last { mean * fold(m, n) } else { 1.0 },
            });
        }
        self.passing = passing;
    }

    /// Transforms of the times `span`; adds their energies.
    fn segment(
        &mut self,
        of: &AlongTime<T>,
        sites: &Range<usize>,
        samples: &[f64],
        span: Range<usize>,
        spectra: ArrayViewMut2<Complex<T>>,
    ) {
        let (plan, transform) = (of.stages.plan, &of.transform);
        let energies = match plan.request.welch {
            None => {
                let values = &samples[span.start * sites.len()..span.end * sites.len()];
                transform.transform_columns(values, spectra, &mut self.scratch)
            }
            Some(welch) => {
                self.detrended(of.stages, sites.start, samples, span);
                let pieces = self.segments.chunks_exact(welch.segment);
                transform.transform_into(pieces, spectra, &mut self.scratch)
            }
        };
        for (sum, energy) in self.energies.iter_mut().zip(energies) {
            *sum += energy;
        }
    }

    /// The times `span` of all records to `segments`, each without its own trend; masked samples
    /// have no weight.
    fn detrended(&mut self, all: &Stages, first: usize, records: &[f64], span: Range<usize>) {
        let kind = all.plan.request.detrend_time;
        let records = records.chunks_exact(all.plan.axes.n_times);
        self.segments.clear();
        for (c, record) in records.enumerate() {
            let begin = self.segments.len();
            self.segments.extend_from_slice(&record[span.clone()]);
            let segment = &mut self.segments[begin..];
            let masked = all.prepared.masked(first + c);
            let from = masked.partition_point(|gap| gap.time < span.start);
            let masked = masked[from..].iter().take_while(|gap| gap.time < span.end);
            let is_masked = |i: usize| masked.clone().any(|gap| gap.time == span.start + i);
            Trend::remove_from(segment, kind, |i| !is_masked(i), &mut self.fit);
            for gap in masked.clone() {
                segment[gap.time - span.start] = 0.0;
            }
        }
    }
}

/// Prefetch distance in rows of spectra.
const AHEAD: usize = 48;

/// `|X|^2` of one segment of a few sites, added to the sums of those before and times a factor of the
/// bin.
pub(super) struct AddPowers<'a, T, F> {
    pub spectra: ArrayView2<'a, Complex<T>>,
    pub sums: &'a mut [LaneBlock],
    pub is_first: bool,
    pub factor: F,
}

impl<T: Real, F: Fn(usize) -> f64> SimdKernel for AddPowers<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let further = AHEAD * self.spectra.strides()[0].unsigned_abs();
        for (m, (sums, spectra)) in self
            .sums
            .iter_mut()
            .zip(self.spectra.outer_iter())
            .enumerate()
        {
            let whole = spectra.to_slice().and_then(|s| s.first_chunk::<WIDTH>());
            if let Some(spectra) = whole {
                for line in spectra.chunks(LINE / size_of::<Complex<T>>()) {
                    prefetch_after(&line[0], further);
                }
            }
            // Whole blocks have a length that the compiler knows.
            let powers = match whole {
                Some(spectra) => spectra.map(power),
                None => std::array::from_fn(|l| spectra.get(l).map_or(0.0, |&x| power(x))),
            };
            let powers = L::read(&powers);
            let sum = match self.is_first {
                true => powers,
                false => L::load(sums) + powers,
            };
            (sum * L::splat((self.factor)(m))).store(sums);
        }
    }
}
