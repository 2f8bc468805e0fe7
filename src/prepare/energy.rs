//! Energies of all records and snapshots, in one pass over the samples.

use rayon::prelude::*;

use super::Prepared;
use crate::error::{Error, Result};
use crate::numeric::sum_of_squares;
use crate::observer::Observer;

/// Parts of the time axis whose sums are added; a fixed number, so that bits do not depend on threads.
const PARTS: usize = 8;

impl Prepared<'_> {
    /// `sum_n v^2` of each site and `sum_j v^2` of each time, of the samples as prepared.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn energies(&self, observer: &dyn Observer) -> Result<(Vec<f64>, Vec<f64>)> {
        let (nt, nx) = (self.n_times(), self.n_sites());
        observer.stage("finding the reference", nt as u64);
        let starts: Vec<usize> = (0..nt).step_by(nt.div_ceil(PARTS)).collect();
        let parts: Result<Vec<(Vec<f64>, Vec<f64>)>> = starts
            .into_par_iter()
            .map(|start| {
                let end = (start + nt.div_ceil(PARTS)).min(nt);
                let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(end - start));
                let mut room = Vec::new();
                for from in (start..end).step_by(self.tiles.times) {
                    if observer.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let to = (from + self.tiles.times).min(end);
                    let profiles = match self.stored_profiles(from..to) {
                        Some(stored) => stored,
                        None => {
                            room.resize((to - from) * nx, 0.0);
                            self.profiles(from..to, &mut room);
                            &room
                        }
                    };
                    for profile in profiles.chunks_exact(nx) {
                        let squares = sites.iter_mut().zip(profile);
                        squares.for_each(|(sum, v)| *sum += v * v);
                        times.push(sum_of_squares(profile));
                    }
                    self.release_times(from..to);
                    observer.advance((to - from) as u64);
                }
                Ok((sites, times))
            })
            .collect();
        let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(nt));
        for (part, energies) in parts? {
            sites.iter_mut().zip(part).for_each(|(sum, v)| *sum += v);
            times.extend(energies);
        }
        self.release_pages();
        Ok((sites, times))
    }
}
