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
    pub(super) window: Vec<f64>,
    /// Whether a weight is not 1.
    pub(super) is_tapered: bool,
    /// Transform of the window itself, for records that are split into mean and rest.
    mean_response: Vec<Complex<f64>>,
}

impl Taper {
    pub(super) fn new(window: &[f64], padded: usize) -> Self {
        let is_tapered = window.iter().any(|&w| w != 1.0);
        let mut mean_response = vec![Complex::default(); padded / 2 + 1];
        if !is_tapered && padded == window.len() {
            mean_response[0].re = padded as f64;
        } else {
            let mut samples = window.to_vec();
            samples.resize(padded, 0.0);
            // The lengths are the plan's own, so this cannot fail.
            let _ = rows::plan_fft_forward::<f64>(padded).process(&mut samples, &mut mean_response);
        }
        Taper {
            window: window.to_vec(),
            is_tapered,
            mean_response,
        }
    }

    /// The energy `sum (w v)^2` of each of `width` interleaved records.
    pub(super) fn energies(
        &self,
        values: &[f64],
        width: usize,
        tapered: &mut Vec<f64>,
        energies: &mut Vec<f64>,
    ) {
        if !self.is_tapered {
            return interleaved_sums_of_squares(values, width, energies);
        }
        tapered.clear();
        for (row, w) in values.chunks_exact(width).zip(&self.window) {
            tapered.extend(row.iter().map(|v| v * w));
        }
        interleaved_sums_of_squares(tapered, width, energies);
    }

    /// Each sample of interleaved records less the record's mean, times its weight, to `out`.
    pub(super) fn window_rows<T: Real>(&self, values: &[f64], means: &[f64], out: &mut [T]) {
        let is_double = TypeId::of::<T>() == TypeId::of::<f64>();
        if let (true, Ok(means)) = (is_double, means.try_into()) {
            let out = bytemuck::cast_slice_mut::<T, f64>(out).as_chunks_mut().0;
            let weights = self.window.iter().copied();
            return less_means(values.as_chunks().0, [means, [0.0; WIDTH]], weights, out);
        }
        let width = means.len();
        let rows = values.chunks_exact(width).zip(out.chunks_exact_mut(width));
        for ((row, out), weight) in rows.zip(&self.window) {
            for ((v, mean), out) in row.iter().zip(means).zip(out) {
                *out = T::rounded((v - mean) * weight);
            }
        }
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

/// Times after which records that cross zero are looked for.
const STRETCH: usize = 16;

/// Of each of `width` interleaved records its mean, if all samples lie within a quarter of it, else 0.
///
/// Then every `v - mean` is exact (Sterbenz' lemma: the two are within a factor 2). Most records vary about zero, which
/// their first samples show.
pub(super) fn dominant_means(values: &[f64], width: usize, means: &mut Vec<f64>) {
    means.clear();
    means.resize(width, 0.0);
    let (mut low, mut high) = (vec![f64::INFINITY; width], vec![f64::NEG_INFINITY; width]);
    for stretch in values.chunks(STRETCH * width) {
        for row in stretch.chunks_exact(width) {
            for ((&v, low), high) in row.iter().zip(&mut low).zip(&mut high) {
                *low = if v < *low { v } else { *low };
                *high = if v > *high { v } else { *high };
            }
        }
        if (0..width).all(|c| low[c] <= 0.0 && high[c] >= 0.0) {
            return;
        }
    }
    for c in (0..width).filter(|&c| low[c] > 0.0 || high[c] < 0.0) {
        let record: Vec<f64> = values.iter().skip(c).step_by(width).copied().collect();
        let mean = sum(&record) / record.len() as f64;
        if (high[c] - mean).max(mean - low[c]) < 0.25 * mean.abs() {
            means[c] = mean;
        }
    }
}

/// `((row - high) - low) * weight` of each row, each operation rounded.
pub(crate) fn less_means(
    rows: &[[f64; WIDTH]],
    means: [[f64; WIDTH]; 2],
    weights: impl Iterator<Item = f64>,
    out: &mut [[f64; WIDTH]],
) {
    widest(LessMeans(rows, means, weights, out));
}

struct LessMeans<'a, W>(
    &'a [[f64; WIDTH]],
    [[f64; WIDTH]; 2],
    W,
    &'a mut [[f64; WIDTH]],
);

impl<W: Iterator<Item = f64>> SimdKernel for LessMeans<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [high, low] = self.1.map(|mean| L::read(&mean));
        for ((row, out), weight) in self.0.iter().zip(self.3).zip(self.2) {
            (((L::read(row) - high) - low) * L::splat(weight)).write(out);
        }
    }
}
