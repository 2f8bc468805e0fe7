//! The second half of the space-time transform: along space at each frequency.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, Axis, s};

use super::between::Between;
use super::plan::Plan;
use super::sink::{LargeArray, Sink};
use crate::analyze::Observer;
use crate::diagnostics::MapBuilder;
use crate::error::{Error, Result};
use crate::sum::sum;
use crate::transform::{ComplexTransform, Real, Scratch, fold, power};

/// Energy of one frequency, by direction (sums over bins, one-sided in f).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ByDirection {
    pub toward_plus_x: f64,
    pub toward_minus_x: f64,
    pub undirected: f64,
}

impl ByDirection {
    /// Splits the ascending row of frequency bin `m` of a transform of length `n`.
    fn of(row: &[f64], m: usize, n: usize) -> Self {
        if m == 0 || 2 * m == n {
            return ByDirection {
                undirected: sum(row),
                ..Self::default()
            };
        }
        let zero = row.len() / 2;
        // For an even number of bins the lowest wavenumber is the Nyquist line.
        let lowest = usize::from(row.len().is_multiple_of(2));
        let nyquist = sum(&row[..lowest]);
        ByDirection {
            toward_minus_x: sum(&row[lowest..zero]),
            toward_plus_x: sum(&row[zero + 1..]),
            undirected: nyquist + row[zero],
        }
    }

    pub fn total(&self) -> f64 {
        self.toward_plus_x + self.toward_minus_x + self.undirected
    }
}

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct Frequencies {
    /// One entry a frequency.
    pub directions: Vec<ByDirection>,
    pub map: MapBuilder,
    /// Of the spectra along time, which lie here by rows; see [`transform_frequencies`].
    pub temporal_map: MapBuilder,
}

/// Transforms all frequencies; the spectrum goes to `sink`.
///
/// So do the spectra along time where they are wanted: `between` holds their transforms, row by
/// row, as the array is written.
pub(super) fn transform_frequencies<T: Real>(
    plan: &Plan,
    between: &Between<T>,
    stored: f64,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Frequencies> {
    let (nf, nk) = (plan.axes.frequency.len(), plan.axes.wavenumber_signed.len());
    let nx = plan.axes.n_sites;
    observer.stage("space-time", nf as u64);
    let transform = ComplexTransform::<T>::new(&plan.window_space, plan.conventions.padded_space);
    let segments = plan.segments.count();
    let time_factor = plan.time_scale.factor / segments as f64;
    let factor = plan.time_scale.factor * plan.space_scale.factor / segments as f64;
    let n = plan.conventions.padded_time;
    let temporal = plan.request.results.temporal;
    let mut done = Frequencies {
        directions: Vec::with_capacity(nf),
        map: MapBuilder::largest((nf, nk), super::MAP_LIMIT),
        temporal_map: MapBuilder::largest((nf, nx), super::MAP_LIMIT),
    };
    let mut all_powers = Array2::<f64>::zeros((plan.blocks.frequencies, nk));
    let width = if temporal { nx } else { 0 };
    let mut all_records = Array2::<f64>::zeros((plan.blocks.frequencies, width));
    for from in (0..nf).step_by(plan.blocks.frequencies) {
        let count = plan.blocks.frequencies.min(nf - from);
        let mut powers = all_powers.slice_mut(s![..count, ..]);
        let mut records = all_records.slice_mut(s![..count, ..]);
        let seen = between.with_rows(from * segments, count * segments, |rows| {
            powers
                .axis_iter_mut(Axis(0))
                .into_par_iter()
                .zip(records.axis_iter_mut(Axis(0)))
                .enumerate()
                .map_init(Scratch::default, |scratch, (i, (powers, record))| {
                    if observer.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let (Some(powers), Some(record)) = (powers.into_slice(), record.into_slice())
                    else {
                        return Ok(ByDirection::default());
                    };
                    powers.fill(0.0);
                    record.fill(0.0);
                    for s in 0..segments {
                        if let Some(profile) = rows.row(i * segments + s).to_slice() {
                            transform.add_power(profile, scratch, powers);
                            for (sum, &x) in record.iter_mut().zip(profile) {
                                *sum += power(x);
                            }
                        }
                    }
                    let fold = fold(from + i, n);
                    powers.iter_mut().for_each(|p| *p *= factor * fold);
                    let directions = ByDirection::of(powers, from + i, n);
                    powers.iter_mut().for_each(|p| *p *= stored);
                    let time_scale = time_factor * fold;
                    record
                        .iter_mut()
                        .for_each(|p| *p = *p * time_scale * stored);
                    observer.advance(1);
                    Ok(directions)
                })
                .collect::<Result<Vec<_>>>()
        })?;
        done.directions.extend(seen?);
        done.map.add(from, 0, powers.view());
        sink.put(LargeArray::SpacetimeSpectrum, from, 0, powers.view())?;
        if temporal {
            done.temporal_map.add(from, 0, records.view());
            sink.put(LargeArray::TemporalSpectrum, from, 0, records.view())?;
        }
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_nyquist_lines_have_no_direction() {
        let even = ByDirection::of(&[1.0, 2.0, 4.0, 8.0], 1, 10);
        assert_eq!(even.undirected, 1.0 + 4.0);
        assert_eq!((even.toward_minus_x, even.toward_plus_x), (2.0, 8.0));
        let odd = ByDirection::of(&[1.0, 2.0, 4.0], 5, 11);
        assert_eq!(odd.undirected, 2.0);
        assert_eq!((odd.toward_minus_x, odd.toward_plus_x), (1.0, 4.0));
        assert_eq!(ByDirection::of(&[1.0, 2.0, 4.0], 5, 10).undirected, 7.0);
        assert_eq!(ByDirection::of(&[3.0], 1, 10).undirected, 3.0);
    }
}
