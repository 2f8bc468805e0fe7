//! Several real records at once, one after the other in memory.

use std::any::TypeId;

use ndarray::ArrayViewMut2;
use num_complex::Complex;

use super::Real;
use super::taper::{Taper, dominant_means};
use crate::numeric::lanes::on_lines;
use crate::system::prefetch::{LINE, prefetch_after};
use column_fft::{Columns, ColumnsMut, RealToComplexColumns};

/// `X_m = sum_n w_n v_n exp(-+ 2 pi i m n / N)`, `m = 0 ..= N / 2`, of several real records of up
/// to N samples each (the rest is zero), which are transformed as one batch.
///
/// Both signs give the same `|X|^2`; the result is that of time. A record's bits do not depend on
/// the others.
#[derive(Debug)]
pub struct RecordTransform<T: Real> {
    plan: RealToComplexColumns<T>,
    taper: Taper,
}

/// Working space of one thread; grows once.
#[derive(Debug, Clone, Default)]
pub struct RecordScratch<T> {
    /// Contiguous records, transposed.
    transposed: Vec<f64>,
    spectra: Vec<Complex<T>>,
    energies: Vec<f64>,
    means: Vec<f64>,
    tapered: Vec<f64>,
    input: Vec<T>,
    columns: Vec<Complex<T>>,
}

impl<T: Real> RecordTransform<T> {
    /// Plans transforms of `window.len()` samples padded to `padded`; all weights 1 mean no taper.
    ///
    /// # Panics
    /// If there are no samples or `padded` is shorter than the window.
    pub fn new(window: &[f64], padded: usize) -> Self {
        assert!(!window.is_empty() && padded >= window.len());
        RecordTransform {
            plan: RealToComplexColumns::new(padded).expect("at least one sample"),
            taper: Taper::new(window, padded),
        }
    }

    /// Largest scratch, in bytes, of a thread that transforms batches of `records` records of
    /// `samples` samples, padded to `padded`.
    pub(crate) fn working_bytes(samples: usize, padded: usize, records: usize) -> u64 {
        let number = size_of::<T>();
        let record = 8 * 2 * samples + number * (padded + 2 * (padded / 2 + 1));
        let columns = RealToComplexColumns::<T>::scratch_len_of(padded, records, records);
        (records * record + columns * size_of::<Complex<T>>()) as u64
    }

    /// Samples of a record.
    pub(crate) fn samples(&self) -> usize {
        self.taper.window.len()
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.plan.len()
    }

    /// Bins of the result, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.plan.bins()
    }

    /// The spectra of `records`, `(bin, record)`, in `spectra`; of each record the energy `sum (w v)^2` of what went in.
    ///
    /// # Panics
    /// If a record is not as long as the window, or the shape is not that of the spectra.
    pub fn transform_into<'a, 's>(
        &self,
        records: impl ExactSizeIterator<Item = &'a [f64]>,
        spectra: ArrayViewMut2<Complex<T>>,
        scratch: &'s mut RecordScratch<T>,
    ) -> &'s [f64] {
        let records: Vec<&[f64]> = records.collect();
        let mut transposed = std::mem::take(&mut scratch.transposed);
        transposed.resize(records.len() * self.taper.window.len(), 0.0);
        interleave(&records, &mut transposed, |v| v);
        self.transform_columns(&transposed, spectra, scratch);
        scratch.transposed = transposed;
        &scratch.energies
    }

    /// The same for interleaved records: one row for each time.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform_columns<'s>(
        &self,
        values: &[f64],
        spectra: ArrayViewMut2<Complex<T>>,
        scratch: &'s mut RecordScratch<T>,
    ) -> &'s [f64] {
        let width = spectra.ncols();
        assert_eq!(values.len(), width * self.taper.window.len());
        let (tapered, energies) = (&mut scratch.tapered, &mut scratch.energies);
        self.taper.energies(values, width, tapered, energies);
        self.run(values, spectra, scratch);
        &scratch.energies
    }

    /// Transforms interleaved records, each less its mean, which is put back.
    fn run(
        &self,
        rows: &[f64],
        mut spectra: ArrayViewMut2<Complex<T>>,
        scratch: &mut RecordScratch<T>,
    ) {
        let (length, width, samples) = (self.padded(), spectra.ncols(), self.taper.window.len());
        dominant_means(rows, width, &mut scratch.means);
        let means = &scratch.means;
        let is_plain =
            !self.taper.is_tapered && length == samples && means.iter().all(|&mean| mean == 0.0);
        let is_double = TypeId::of::<T>() == TypeId::of::<f64>();
        let input = match is_plain && is_double {
            true => bytemuck::cast_slice(rows),
            false => {
                let input = on_lines(&mut scratch.input, width * length);
                let (windowed, padding) = input.split_at_mut(width * samples);
                self.taper.window_rows(rows, means, windowed);
                padding.fill(T::zero());
                &input[..]
            }
        };
        let input = Columns::new(input, length, width, width).expect("the buffer's own shape");
        let output = ColumnsMut::from(spectra.view_mut());
        let columns = &mut scratch.columns;
        let needed = self.plan.scratch_len_for(&input, &output);
        if columns.len() < needed {
            columns.resize(needed, Complex::default());
        }
        let transformed = self.plan.process_with_scratch(input, output, columns);
        transformed.expect("shapes of the plan");
        for (&mean, mut spectrum) in means.iter().zip(spectra.columns_mut()) {
            self.taper.add_mean(mean, spectrum.iter_mut());
        }
    }

    /// The spectra alone of `width` interleaved records, bin by bin, in `scratch`, with the bits of
    /// [`Self::transform_columns`].
    ///
    /// # Panics
    /// If there are fewer samples than in the plan.
    pub fn spectra_of_rows<'s>(
        &self,
        rows: &[f64],
        width: usize,
        scratch: &'s mut RecordScratch<T>,
    ) -> &'s [Complex<T>] {
        let (bins, mut spectra) = (self.bins(), std::mem::take(&mut scratch.spectra));
        let room = on_lines(&mut spectra, width * bins);
        let output = ArrayViewMut2::from_shape((bins, width), room);
        self.run(rows, output.expect("the buffer's own shape"), scratch);
        scratch.spectra = spectra;
        on_lines(&mut scratch.spectra, width * bins)
    }
}

/// Records as long as there are rows in `out`, a row for each time.
///
/// # Panics
/// If a record has another length.
pub(super) fn interleave<A: Copy, B>(records: &[&[A]], out: &mut [B], of: impl Fn(A) -> B) {
    let width = records.len();
    let is_right = |record: &&[A]| record.len() * width == out.len();
    assert!(records.iter().all(is_right));
    match width {
        4 => interleave_together::<A, B, 4>(records, out, of),
        8 => interleave_together::<A, B, 8>(records, out, of),
        _ => {
            for (n, row) in out.chunks_exact_mut(width.max(1)).enumerate() {
                let row = row.iter_mut().zip(records);
                row.for_each(|(to, record)| *to = of(record[n]));
            }
        }
    }
}

/// The same of a number of records that is known to the compiler; the next ones mostly follow these.
fn interleave_together<A: Copy, B, const WIDTH: usize>(
    records: &[&[A]],
    out: &mut [B],
    of: impl Fn(A) -> B,
) {
    let (rows, _) = out.as_chunks_mut::<WIDTH>();
    let records: [&[A]; WIDTH] = std::array::from_fn(|i| &records[i][..rows.len()]);
    let further = WIDTH * rows.len();
    for (n, row) in rows.iter_mut().enumerate() {
        for (to, record) in row.iter_mut().zip(records) {
            *to = of(record[n]);
        }
        if n.is_multiple_of(LINE / size_of::<A>()) {
            let next = records.iter();
            next.for_each(|record| prefetch_after(&record[n], further));
        }
    }
}

/// The least length of at least `samples` with no prime factor above 5.
pub(crate) fn quick(samples: usize) -> usize {
    let is_quick = |n: &usize| {
        let mut rest = *n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (samples..).find(is_quick).unwrap_or(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transform::direct_sums;
    use ndarray::Array2;

    /// Offsets beside records that cross zero, tapered and padded or not, against direct sums; and
    /// the same bits whatever the other records are.
    #[test]
    fn val_direct_sums_of_offsets_beside_waves() {
        let samples = 120;
        let wave = |c: usize, n: usize| (n as f64 * (0.3 + 0.1 * c as f64)).cos();
        let offset = |c: usize| [0.0, 1e6, -40.0, 0.0, 3.0, 0.0, 0.5, 1e9][c];
        let taper: Vec<f64> = (0..samples).map(|n| (n as f64 * 0.02).sin()).collect();
        for (window, padded) in [(vec![1.0; samples], samples), (taper, 150)] {
            let plan = RecordTransform::<f64>::new(&window, padded);
            let bins: Vec<usize> = (0..plan.bins()).collect();
            let mut scratch = RecordScratch::default();
            for width in [8, 3, 1] {
                let value = |n: usize, c: usize| offset(c) + wave(c, n);
                let row = |n: usize| (0..width).map(move |c| value(n, c));
                let values: Vec<f64> = (0..samples).flat_map(row).collect();
                let mut spectra = Array2::default((plan.bins(), width));
                let energies = plan.transform_columns(&values, spectra.view_mut(), &mut scratch);
                let energies = energies.to_vec();
                for c in 0..width {
                    let record: Vec<f64> = (0..samples).map(|n| value(n, c)).collect();
                    let tapered = record.iter().zip(&window).map(|(v, w)| v * w);
                    let mut tapered: Vec<f64> = tapered.collect();
                    assert_eq!(energies[c], crate::numeric::sum_of_squares(&tapered));
                    tapered.resize(padded, 0.0);
                    let direct = direct_sums(&tapered, &bins);
                    let largest = direct.iter().map(|z| z.norm()).fold(0.0, f64::max);
                    for (m, z) in direct.iter().enumerate() {
                        // Only where a taper spreads it does an offset count.
                        let scale = match m == 0 || padded > samples {
                            true => largest,
                            false => (padded as f64).sqrt(),
                        };
                        let error = (spectra[[m, c]] - z).norm() / scale;
                        assert!(error < 4e-15, "{width} {c} {m}: {error:e}");
                    }
                    let alone = plan.spectra_of_rows(&record, 1, &mut scratch);
                    let same = alone.iter().zip(spectra.column(c)).all(|(a, b)| a == b);
                    assert!(same, "{width} {c}");
                }
            }
        }
    }
}
