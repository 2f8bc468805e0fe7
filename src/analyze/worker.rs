//! Records of a few sites, or profiles of a few times, to their power spectra: by one thread, with its own buffers.

use std::ops::Range;

use ndarray::{ArrayView2, ArrayViewMut2, s};
use num_complex::Complex;

use super::columns::AlongTime;
use super::stages::Stages;
use crate::diagnostics::{Bins, SpectrumMoments, interleaved_moments};
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, on_lines, widest};
use crate::prepare::{Detrend, Trend};
use crate::system::prefetch::{LINE, prefetch_after};
use crate::transform::{Real, RecordScratch, fold, power};

/// Up to eight records to spectra, with the thread's own buffers.
#[derive(Default)]
pub(super) struct Worker<T> {
    scratch: RecordScratch<T>,
    /// Segments without their trends, interleaved, and one of them.
    segments: Vec<f64>,
    segment: Vec<f64>,
    fit: Vec<f64>,
    /// Transforms, where they are not kept.
    passing: Vec<Complex<T>>,
    /// Power spectra, each a lane; unused lanes mean nothing.
    pub power: Vec<LaneBlock>,
    /// `sum (w v)^2` of each record, over all that was added.
    pub energies: Vec<f64>,
}

impl<T: Real> Worker<T> {
    /// Mean power spectra of the segments of interleaved records, and their energies.
    ///
    /// `kept`, `(bin x segment, site)`, gets the transforms.
    pub fn spectra(
        &mut self,
        of: &AlongTime<T>,
        sites: Range<usize>,
        samples: &[f64],
        mut kept: Option<ArrayViewMut2<Complex<T>>>,
    ) {
        let (plan, transform) = (of.stages.plan, &of.transform);
        let (segments, width) = (plan.segments, sites.len());
        let (n, shape) = (transform.padded(), (transform.bins(), width));
        let mean = plan.time_scale.factor / segments.count() as f64;
        let has_trends = plan.request.welch.is_some() && plan.request.detrend_time != Detrend::None;
        for (s, start) in segments.starts().enumerate() {
            let step = segments.count();
            let kept = kept.as_mut().map(|kept| kept.slice_mut(s![s..;step, ..]));
            let span = start..start + segments.length;
            let mut detrended = std::mem::take(&mut self.segments);
            let mut values = &samples[span.start * width..span.end * width];
            if has_trends {
                self.detrended(of.stages, &sites, (span, values), &mut detrended);
                values = &detrended;
            }
            let (is_first, is_last) = (s == 0, s + 1 == step);
            let factor = |m| if is_last { mean * fold(m, n) } else { 1.0 };
            self.add(shape, kept, (is_first, factor), |spectra, scratch| {
                transform.transform_columns(values, spectra, scratch)
            });
            self.segments = detrended;
        }
    }

    /// Adds the powers of what `transform` makes, `(bin, record)`, to those of segments before; sums are multiplied by the
    /// `factor` of a bin. `kept` gets the transforms.
    pub fn add(
        &mut self,
        (bins, width): (usize, usize),
        kept: Option<ArrayViewMut2<Complex<T>>>,
        (is_first, factor): (bool, impl Fn(usize) -> f64),
        transform: impl for<'s> FnOnce(ArrayViewMut2<Complex<T>>, &'s mut RecordScratch<T>) -> &'s [f64],
    ) {
        let passing = &mut self.passing;
        let mut spectra = kept.unwrap_or_else(|| {
            let room = on_lines(passing, bins * width);
            ArrayViewMut2::from_shape((bins, width), room).expect("as long as its shape")
        });
        if is_first {
            self.energies.clear();
            self.energies.resize(width, 0.0);
            self.power.resize(bins, LaneBlock::default());
        }
        let energies = transform(spectra.view_mut(), &mut self.scratch);
        for (sum, energy) in self.energies.iter_mut().zip(energies) {
            *sum += energy;
        }
        widest(AddPowers {
            spectra: spectra.view(),
            sums: &mut self.power,
            is_first,
            factor,
        });
    }

    /// Measures of each spectrum, with the energy of its record.
    pub fn measured(&self, bins: &Bins, edge: f64) -> Vec<(SpectrumMoments, f64)> {
        let rows = interleaved_moments(&self.power, bins, edge).into_iter();
        rows.zip(self.energies.iter().copied()).collect()
    }

    /// The power spectrum of the first record.
    pub fn first(&self) -> Vec<f64> {
        self.power.iter().map(|lanes| lanes.0[0]).collect()
    }

    /// The segments of these times to `out`, each without its own trend; masked samples have no weight.
    fn detrended(
        &mut self,
        all: &Stages,
        sites: &Range<usize>,
        (span, values): (Range<usize>, &[f64]),
        out: &mut Vec<f64>,
    ) {
        let (kind, width) = (all.plan.request.detrend_time, sites.len());
        out.resize(values.len(), 0.0);
        for (lane, site) in sites.clone().enumerate() {
            self.segment.clear();
            self.segment.extend(values.iter().skip(lane).step_by(width));
            let masked = all.prepared.masked(site);
            let from = masked.partition_point(|gap| gap.time < span.start);
            let masked = masked[from..].iter().take_while(|gap| gap.time < span.end);
            let is_masked = |i: usize| masked.clone().any(|gap| gap.time == span.start + i);
            Trend::remove_from(&mut self.segment, kind, |i| !is_masked(i), &mut self.fit);
            for gap in masked.clone() {
                self.segment[gap.time - span.start] = 0.0;
            }
            let column = out.iter_mut().skip(lane).step_by(width);
            column.zip(&self.segment).for_each(|(to, v)| *to = *v);
        }
    }
}

/// Prefetch distance in rows of spectra.
const AHEAD: usize = 48;

/// `|X|^2` of one segment of a few sites, added to the sums of those before and times a factor of the
/// bin.
struct AddPowers<'a, T, F> {
    spectra: ArrayView2<'a, Complex<T>>,
    sums: &'a mut [LaneBlock],
    is_first: bool,
    factor: F,
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
