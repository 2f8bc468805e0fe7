//! Records of a field larger than memory, read in one go along the file.

use std::ops::Range;

use rayon::prelude::*;

use crate::field::Field;

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
        self.n_times = times.len();
        self.stripe = stripe;
        let length = times.len() * sites.len();
        if self.values.len() < length {
            self.values = Vec::new();
            self.values = vec![0.0; length];
        }
        self.values.truncate(length);
        if field.is_time_major() {
            self.piece = (bytes / (8 * field.n_sites())).max(1);
            let pieces = self.values.par_chunks_mut(self.piece * sites.len());
            pieces.enumerate().for_each(|(i, mut values)| {
                let times = part(&times, i, self.piece);
                for stripe in parts(sites.clone(), stripe) {
                    let part = values.split_off_mut(..times.len() * stripe.len());
                    field.read_time_major(times.clone(), stripe, part.expect("room for all"));
                }
                field.release_block(times, sites.clone());
            });
        } else {
            self.piece = times.len();
            let length = (bytes / (8 * stripe)).max(1);
            let stripes = self.values.par_chunks_mut(times.len() * stripe);
            stripes.enumerate().for_each(|(i, mut values)| {
                let stripe = part(&sites, i, stripe);
                for times in parts(times.clone(), length) {
                    let part = values.split_off_mut(..times.len() * stripe.len());
                    let part = part.expect("room for all");
                    field.read_time_major(times.clone(), stripe.clone(), part);
                    field.release_block(times, stripe.clone());
                }
            });
        }
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

/// One after the other, `length` each but for the last.
pub(super) fn parts(all: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..all.len().div_ceil(length)).map(move |i| part(&all, i, length))
}

fn part(all: &Range<usize>, i: usize, length: usize) -> Range<usize> {
    let from = all.start + i * length;
    from..all.end.min(from + length)
}
