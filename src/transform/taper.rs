//! What becomes of samples before a transform: weights, and a mean that would cost digits.

use std::any::TypeId;

use column_fft::rows;
use num_complex::Complex;

use super::Real;
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};
use crate::numeric::{interleaved_sums_of_squares, sum};

/// The window of a transform, and what becomes of a record's mean.
#[derive(Debug)]
pub(super) struct Taper {
    /// `None`: no taper.
    window: Option<Vec<f64>>,
    pub(super) samples: usize,
    /// Transform of the window itself, for records that are split into mean and rest.
    mean_response: Vec<Complex<f64>>,
}

impl Taper {
    pub(super) fn new(window: &[f64], padded: usize) -> Self {
        let tapered = window.iter().any(|&w| w != 1.0);
        let mut mean_response = vec![Complex::default(); padded / 2 + 1];
        if !tapered && padded == window.len() {
            mean_response[0].re = padded as f64;
        } else {
            let mut samples = window.to_vec();
            samples.resize(padded, 0.0);
            // The lengths are the plan's own, so this cannot fail.
            let _ = rows::plan_fft_forward::<f64>(padded).process(&mut samples, &mut mean_response);
        }
        Taper {
            window: tapered.then(|| window.to_vec()),
            samples: window.len(),
            mean_response,
        }
    }

    /// Of each of `width` interleaved records, the mean that is split off (mostly 0), and the energy `sum (w v)^2`.
    pub(super) fn look_across(
        &self,
        values: &[f64],
        width: usize,
        tapered: &mut Vec<f64>,
        (means, energies): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        match &self.window {
            None => interleaved_sums_of_squares(values, width, energies),
            Some(window) => {
                tapered.clear();
                for (row, w) in values.chunks_exact(width).zip(window) {
                    tapered.extend(row.iter().map(|v| v * w));
                }
                interleaved_sums_of_squares(tapered, width, energies);
            }
        }
        self.means_across(values, width, means);
    }

    /// The means alone.
    pub(super) fn means_across(&self, values: &[f64], width: usize, means: &mut Vec<f64>) {
        means.clear();
        if width == 1 {
            means.push(dominant_mean(values));
            return;
        }
        means.resize(width, 0.0);
        for c in one_sided(values, width) {
            let record: Vec<f64> = values.iter().skip(c).step_by(width).copied().collect();
            means[c] = dominant_mean(&record);
        }
    }

    /// Each sample of interleaved records less the record's mean, times its weight, to `out`.
    pub(super) fn window_rows<T: Real>(&self, values: &[f64], means: &[f64], out: &mut [T]) {
        let ones;
        let window = match &self.window {
            Some(window) => window,
            None => {
                ones = vec![1.0; self.samples];
                &ones
            }
        };
        let is_double = TypeId::of::<T>() == TypeId::of::<f64>();
        if let (true, Ok(means)) = (is_double, means.try_into()) {
            let rows = values.as_chunks().0;
            let out = bytemuck::cast_slice_mut::<T, f64>(out).as_chunks_mut().0;
            widest(WindowRows {
                rows,
                means,
                window,
                out,
            });
            return;
        }
        let width = means.len();
        let rows = values.chunks_exact(width).zip(out.chunks_exact_mut(width));
        for ((row, out), weight) in rows.zip(window) {
            for ((v, mean), out) in row.iter().zip(means).zip(out) {
                *out = T::rounded((v - mean) * weight);
            }
        }
    }

    /// Whether records go into the transform as they are.
    pub(super) fn is_plain(&self) -> bool {
        self.window.is_none()
    }

    /// Puts back the mean that was split off.
    pub(super) fn add_mean<'a, T: Real>(
        &self,
        mean: f64,
        spectrum: impl Iterator<Item = &'a mut Complex<T>>,
    ) {
        if mean == 0.0 {
            return;
        }
        for (x, response) in spectrum.zip(&self.mean_response) {
            x.re = T::rounded(x.re.to_f64() + mean * response.re);
            x.im = T::rounded(x.im.to_f64() + mean * response.im);
        }
    }
}

/// The mean of a record that lies within a quarter of it, else 0.
///
/// Then every `v - mean` is exact (Sterbenz' lemma: the two are within a factor 2).
fn dominant_mean(record: &[f64]) -> f64 {
    if crosses_zero(record.iter().copied()) {
        return 0.0;
    }
    let mean = sum(record) / record.len() as f64;
    let apart = record.iter().map(|v| (v - mean).abs());
    let apart = apart.fold(0.0, f64::max);
    if apart < 0.25 * mean.abs() { mean } else { 0.0 }
}

/// Those of `width` interleaved records that do not cross zero; the others have no dominant mean.
fn one_sided(values: &[f64], width: usize) -> Vec<usize> {
    let (mut low, mut high) = (vec![f64::INFINITY; width], vec![f64::NEG_INFINITY; width]);
    let sided = |low: &[f64], high: &[f64]| -> Vec<usize> {
        let is_sided = |c: &usize| low[*c] > 0.0 || high[*c] < 0.0;
        (0..width).filter(is_sided).collect()
    };
    for stretch in values.chunks(64 * width) {
        widen(stretch, &mut low, &mut high);
        if sided(&low, &high).is_empty() {
            break;
        }
    }
    sided(&low, &high)
}

/// Updates the least and the largest sample of interleaved records by `stretch`.
fn widen(stretch: &[f64], low: &mut [f64], high: &mut [f64]) {
    if low.len() == WIDTH
        && let (Some(low), Some(high)) = (low.first_chunk_mut(), high.first_chunk_mut())
    {
        let (rows, _) = stretch.as_chunks();
        widest(Widen { rows, low, high });
        return;
    }
    for row in stretch.chunks_exact(low.len()) {
        for ((&v, low), high) in row.iter().zip(&mut *low).zip(&mut *high) {
            *low = if v < *low { v } else { *low };
            *high = if v > *high { v } else { *high };
        }
    }
}

/// The same of eight records.
struct Widen<'a> {
    rows: &'a [[f64; WIDTH]],
    low: &'a mut [f64; WIDTH],
    high: &'a mut [f64; WIDTH],
}

impl SimdKernel for Widen<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (mut low, mut high) = (L::read(self.low), L::read(self.high));
        for row in self.rows {
            let v = L::read(row);
            low = v.least(low);
            high = v.largest(high);
        }
        low.write(self.low);
        high.write(self.high);
    }
}

/// See [`Taper::window_rows`].
struct WindowRows<'a> {
    rows: &'a [[f64; WIDTH]],
    means: &'a [f64; WIDTH],
    window: &'a [f64],
    out: &'a mut [[f64; WIDTH]],
}

impl SimdKernel for WindowRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let means = L::read(self.means);
        for ((row, out), weight) in self.rows.iter().zip(self.out).zip(self.window) {
            ((L::read(row) - means) * L::splat(*weight)).write(out);
        }
    }
}

/// Most records vary about zero, which their first samples show.
fn crosses_zero(samples: impl Iterator<Item = f64>) -> bool {
    let (mut below, mut above) = (false, false);
    for v in samples.take(64) {
        below |= v <= 0.0;
        above |= v >= 0.0;
    }
    below && above
}
