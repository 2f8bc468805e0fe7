//! Spectra along space, and their mean over time.

use std::f64::consts::TAU;

use super::{SpectrumEstimate, found::DETRENDED};
use crate::estimates::FieldAxis;
use crate::estimates::realisations::{LEAST_STEADINESS, steadiness};
use crate::numeric::{jackknife, student_two_sided};

/// Parts of the record whose means are compared.
const PARTS: usize = 16;

/// The mean of the spectra of all times, one value a wavenumber.
///
/// Neighbouring snapshots are alike, so that their number says nothing. The record is divided into 16 parts of
/// equal length; their means are taken as independent, which holds if a part is longer than the motion
/// remembers. The jackknife over the parts gives the deviation `s` of `ln S`, whose interval is `t s` with
/// Student's t of 15 degrees of freedom, and the number of snapshots that independent ones would need for the
/// same variance of the mean.
///
/// Source: batch means, C. J. Geyer, Statist. Sci. 7, 473 (1992), section 3.1; the jackknife of
/// [`spectrum`](super::spectrum()).
#[derive(Debug, Clone)]
pub struct MeanSpectrum {
    pub spectrum: Vec<f64>,
    /// Ends of the interval; NaN where the energy of the snapshots is a transient in time, or there are fewer
    /// than 32.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Variance of the snapshots' values over that of the mean; NaN where there is no interval.
    pub effective_snapshots: Vec<f64>,
    /// How evenly the energy is spread over time.
    pub steadiness: f64,
}

impl SpectrumEstimate {
    /// What was found of a field with exchanged axes: the axes put back, wavenumbers in rad, the mean over time.
    pub(super) fn along_space(mut self) -> Self {
        self.along = FieldAxis::Space;
        std::mem::swap(&mut self.time, &mut self.space);
        self.bins.iter_mut().for_each(|bin| *bin *= TAU);
        self.half_bandwidth = self.half_bandwidth.map(|half| half * TAU);
        for array in [&mut self.spectrum, &mut self.low, &mut self.high] {
            array.mapv_inplace(|s| s / TAU);
        }
        if let Some(test) = &mut self.line_test {
            test.lines.iter_mut().for_each(|line| line.at *= TAU);
        }
        self.mean = Some(self.mean_over_time());
        self
    }

    fn mean_over_time(&self) -> MeanSpectrum {
        let bins = self.spectrum.nrows();
        // Snapshots of which nothing is left do not count.
        let amplitudes = self.spectrum.columns().into_iter().map(|s| s.sum().sqrt());
        let amplitudes: Vec<f64> = amplitudes.filter(|a| !a.is_nan()).collect();
        let times = amplitudes.len();
        let steadiness = steadiness(&amplitudes);
        let is_known = steadiness >= LEAST_STEADINESS && times >= 2 * PARTS;
        let mut found = MeanSpectrum {
            spectrum: Vec::with_capacity(bins),
            low: vec![f64::NAN; bins],
            high: vec![f64::NAN; bins],
            effective_snapshots: vec![f64::NAN; bins],
            steadiness,
        };
        let quantile = student_two_sided(self.alpha, (PARTS - 1) as f64);
        let parts = PARTS as f64;
        for (m, row) in self.spectrum.rows().into_iter().enumerate() {
            let row: Vec<f64> = row.iter().copied().filter(|s| !s.is_nan()).collect();
            let mean = crate::numeric::sum(&row) / times as f64;
            found.spectrum.push(mean);
            if !is_known || mean <= 0.0 || self.detrended[m] > DETRENDED {
                continue;
            }
            // Parts of equal length; the last samples that fill none are left out.
            let length = times / PARTS;
            let of_part = |part: &[f64]| crate::numeric::sum(part) / length as f64;
            let means: Vec<f64> = row.chunks_exact(length).take(PARTS).map(of_part).collect();
            let all: f64 = means.iter().sum();
            let without = means.iter().map(|one| ((all - one) / (parts - 1.0)).ln());
            let deviation = jackknife(&without.collect::<Vec<f64>>());
            found.low[m] = mean * (-quantile * deviation).exp();
            found.high[m] = mean * (quantile * deviation).exp();
            let single: f64 = row.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / times as f64;
            found.effective_snapshots[m] = single / (mean * deviation).powi(2);
        }
        found
    }
}
