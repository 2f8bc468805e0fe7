//! Measures along an axis as results: which rows are defined, and their headline.

use super::result::{Moments, Spot};
use crate::diagnostics::SpectrumMoments;

/// The part of the largest row's energy below which a row is undefined.
pub(super) const FLOOR: f64 = 1e-6;

/// The part of the largest row's energy that a row needs to be the reference by default.
pub(super) const REFERENCE: f64 = 0.1;

/// Whether each row has energy to measure: at least 1e-6 of the largest, and where the energy of
/// noise in a row is known, more than that on top of it.
pub(super) fn defined(
    rows: &[SpectrumMoments],
    energies: &[f64],
    noise: impl Fn(usize) -> Option<f64>,
) -> Vec<bool> {
    let largest = rows.iter().fold(0.0, |m: f64, row| m.max(row.total));
    let above = |j: usize, energy: f64| noise(j).is_none_or(|noise| energy - noise > noise);
    let rows = rows.iter().zip(energies).enumerate();
    rows.map(|(j, (row, &energy))| {
        row.total > 0.0 && row.total >= FLOOR * largest && above(j, energy)
    })
    .collect()
}

impl Moments {
    /// Rows gathered into columns, NaN but for the energy in rows that are not `defined`; `measure`
    /// makes a sum over bins an integral, and spectra are of lengths `padded` times those of the samples.
    pub(super) fn gather(
        rows: &[SpectrumMoments],
        defined: &[bool],
        measure: f64,
        padded: f64,
    ) -> Moments {
        let column = |of: &dyn Fn(&SpectrumMoments) -> f64| -> Vec<f64> {
            let rows = rows.iter().zip(defined);
            rows.map(|(row, defined)| if *defined { of(row) } else { f64::NAN })
                .collect()
        };
        Moments {
            centroid: column(&|r| r.centroid),
            bandwidth: column(&|r| r.bandwidth),
            effective_bandwidth: column(&|r| r.effective_bandwidth),
            entropy: column(&|r| r.entropy),
            participation: column(&|r| r.participation),
            zero_share: column(&|r| r.zero / r.total * padded),
            median: column(&|r| r.median),
            quantile_90: column(&|r| r.quantile_90),
            low_share: column(&|r| r.low_share),
            high_share: column(&|r| r.high_share),
            energy: rows.iter().map(|r| r.total * measure).collect(),
            ..Moments::default()
        }
    }
}

/// The headline of a family of spectra: the share of the high band at three rows.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Headline {
    /// The row that sets the band edge, or would; `None` where it is undefined.
    pub reference: Option<Spot>,
    /// Where the share is largest, from the reference on; of sites, where the record's end does not cut
    /// the passage of the front.
    pub largest: Option<Spot>,
    /// The last row with energy.
    pub last: Option<Spot>,
}

impl Headline {
    /// Of the rows that are `defined`, the largest of those that are `whole`; `place` is the index of a row in the file, and its coordinate.
    pub(super) fn of(
        high_share: &[f64],
        defined: &[bool],
        whole: &[bool],
        reference: Option<usize>,
        place: impl Fn(usize) -> (usize, f64),
    ) -> Headline {
        let spot = |row: usize| {
            let (index, at) = place(row);
            let share = high_share[row];
            Spot {
                index,
                at,
                high_share: share.is_finite().then_some(share),
            }
        };
        let from = reference.unwrap_or(0);
        let known = |row: &usize| whole[*row] && !high_share[*row].is_nan();
        let known = (from..high_share.len()).filter(known);
        // The first of equal ones.
        let largest = known.reduce(|a, b| if high_share[b] > high_share[a] { b } else { a });
        let is_defined = |row: &usize| defined.get(*row) == Some(&true);
        let last = (0..high_share.len()).rev().find(is_defined);
        Headline {
            reference: reference.filter(is_defined).map(spot),
            largest: largest.map(spot),
            last: last.map(spot),
        }
    }
}
