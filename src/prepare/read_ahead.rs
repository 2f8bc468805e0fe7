//! Records of a field larger than memory, read in one go along the file.

use std::ops::Range;

use rayon::prelude::*;

use super::prepared::within;
use crate::field::Field;
use crate::numeric::pieces;

/// Bytes of a field larger than memory that each of `threads` threads has mapped at a time.
pub(crate) fn piece_bytes(threads: usize) -> usize {
    ((16 << 20) / threads.max(1)).clamp(1 << 20, 8 << 20)
}

/// Times that are transposed at once: samples of a stripe that stay in L1.
const TURNED: usize = 256;

/// Raw records of neighbouring sites: `(piece of times, stripe of sites, time, site)`.
///
/// A stripe holds the sites that are transformed together, usually a cache line, and is copied
/// unchanged from the rows of the field. The memory is reused for the next sites, since new pages
/// cost as much as the copy.
#[derive(Debug, Default)]
pub(crate) struct ReadAhead {
    /// Of the field.
    sites: Range<usize>,
    /// Sites a stripe; the last may be narrower.
    stripe: usize,
    n_times: usize,
    /// Times a piece; the last may be shorter.
    piece: usize,
    values: Vec<f64>,
}

impl ReadAhead {
    /// Reads `sites` at `times`, both of the `field`.
    pub(super) fn read(
        &mut self,
        field: &Field,
        times: Range<usize>,
        sites: Range<usize>,
        stripe: usize,
    ) {
        let bytes = piece_bytes(rayon::current_num_threads());
        let (n_times, is_time_major) = (times.len(), field.is_time_major());
        let length = n_times * sites.len();
        if self.values.len() < length {
            self.values = Vec::new();
            self.values = vec![0.0; length];
        }
        self.values.truncate(length);
        let row = if is_time_major {
            field.n_sites()
        } else {
            stripe
        };
        let piece = (bytes / (8 * row)).max(1);
        let split = |all: &Range<usize>, most: usize| -> Vec<Range<usize>> {
            let parts = pieces(all.len(), most).map(|part| within(all, &part));
            parts.collect()
        };
        let (pieces, stripes) = (split(&times, piece), split(&sites, stripe));
        let read = |times: &Range<usize>, stripe: &Range<usize>, values: &mut &mut [f64]| {
            let part = values.split_off_mut(..times.len() * stripe.len());
            let part = part.expect("memory for all");
            field.read_time_major(times.clone(), stripe.clone(), part);
        };
        if is_time_major {
            let values = self.values.par_chunks_mut(piece * sites.len());
            values.zip(&pieces).for_each(|(mut values, times)| {
                stripes.iter().for_each(|of| read(times, of, &mut values));
                field.release_block(times.clone(), sites.clone());
            });
        } else {
            let values = self.values.par_chunks_mut(n_times * stripe);
            values.zip(&stripes).for_each(|(mut values, stripe)| {
                for times in &pieces {
                    read(times, stripe, &mut values);
                    field.release_block(times.clone(), stripe.clone());
                }
            });
        }
        self.n_times = n_times;
        self.stripe = stripe;
        self.piece = if is_time_major { piece } else { n_times };
        self.sites = sites;
    }

    /// The records of one stripe, interleaved.
    pub(super) fn columns(&self, sites: Range<usize>, out: &mut [f64]) {
        let pieces = out.chunks_mut(self.piece * sites.len());
        for (piece, out) in self.pieces(sites).zip(pieces) {
            out.copy_from_slice(piece);
        }
    }

    /// The records of one stripe one after the other.
    pub(super) fn records(&self, sites: Range<usize>, out: &mut [f64]) {
        let width = sites.len();
        let mut from = 0;
        for piece in self.pieces(sites) {
            for rows in piece.chunks(TURNED * width) {
                let times = from..from + rows.len() / width;
                for (j, record) in out.chunks_exact_mut(self.n_times).enumerate() {
                    let samples = rows.iter().skip(j).step_by(width);
                    let place = record[times.clone()].iter_mut();
                    place.zip(samples).for_each(|(to, &v)| *to = v);
                }
                from = times.end;
            }
        }
    }

    /// What there is of a stripe.
    fn pieces(&self, sites: Range<usize>) -> impl Iterator<Item = &[f64]> {
        let first = sites.start - self.sites.start;
        let whole = first.is_multiple_of(self.stripe) && sites.len() <= self.stripe;
        assert!(whole && sites.end <= self.sites.end, "one stripe");
        let pieces = self.values.chunks(self.piece * self.sites.len());
        pieces.map(move |piece| {
            let times = piece.len() / self.sites.len();
            &piece[first * times..][..sites.len() * times]
        })
    }
}
