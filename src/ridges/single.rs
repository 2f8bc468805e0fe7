//! Fields that are one realisation, such as a transient: nothing read off them has an error.

use super::Ridges;
use crate::estimates::realisations::{FILLED, TOGETHER, steadiness_of_sites, steadiness_without};
use crate::field::Field;

/// Steadiness below which a field is a transient, whose waves come and go: half, as of narrow-band noise at the least.
const STEADY: f64 = 0.5;

/// How steady the fields are; see [`crate::estimates::Independence::steadiness`].
pub(super) fn steadiness(fields: &[&Field]) -> f64 {
    let of = |field: &&Field| {
        let times = field.n_times();
        let mut sites = Vec::with_capacity(field.n_sites());
        let mut most = 0.0f64;
        let mut records = vec![0.0; times * TOGETHER];
        for from in (0..field.n_sites()).step_by(TOGETHER) {
            let some = from..field.n_sites().min(from + TOGETHER);
            let records = &mut records[..times * some.len()];
            field.read_site_major(0..times, some, records);
            for record in records.chunks_exact_mut(times) {
                let missing = (0..times).filter(|n| !record[*n].is_finite());
                let missing: Vec<usize> = missing.collect();
                missing.iter().for_each(|n| record[*n] = 0.0);
                // Squares of squares stay numbers.
                let largest = record.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                if largest > 0.0 {
                    record.iter_mut().for_each(|v| *v /= largest);
                }
                let steadiness = match missing.len() as f64 > FILLED * times as f64 {
                    true => f64::NAN,
                    false => steadiness_without(record, &missing, true),
                };
                most = most.max(largest);
                sites.push((steadiness, crate::numeric::sum_of_squares(record), largest));
            }
        }
        let relative = |(s, energy, own): (f64, f64, f64)| (s, energy * (own / most).powi(2));
        steadiness_of_sites(sites.into_iter().map(relative).collect())
    };
    fields.iter().map(of).sum::<f64>() / fields.len() as f64
}

impl Ridges {
    /// Whether the fields are one realisation, such as a transient: then nothing has an error.
    pub fn is_single(&self) -> bool {
        let steadiness = self.independence.steadiness;
        self.records < 2 && (steadiness.is_nan() || steadiness < STEADY)
    }

    /// Errors by noise and spread are none of a single transient's, which is as it is.
    pub(super) fn strike_errors(&mut self) {
        for point in self.ridges.iter_mut().flat_map(|ridge| &mut ridge.points) {
            point.frequency_error = f64::NAN;
            point.wavenumber_error = f64::NAN;
            point.phase_velocity_error = f64::NAN;
            point.group_velocity_error = f64::NAN;
        }
        for fit in &mut self.fits {
            fit.reduced = f64::NAN;
            fit.parameters.iter_mut().for_each(|p| p.error = f64::NAN);
        }
    }
}
