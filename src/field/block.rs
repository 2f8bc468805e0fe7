//! Copies a block of stored samples, decoded, in the order of the storage or transposed.
//!
//! A block is copied run by run if the output has the order of the storage. Otherwise it is
//! transposed in tiles of 8 x 8, so that each cache line is read once and written whole.

use std::ops::Range;

use crate::system::prefetch::prefetch;

/// Edge of a tile: 8 samples of 8 bytes are one cache line.
const TILE: usize = 8;

/// Rows whose tiles are transposed before the next columns.
const BAND: usize = 64;

/// Prefetch distance in rows for short pieces of rows.
const AHEAD: usize = 96;

/// The part of the storage that is read.
pub(super) struct ReadBlock<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) row_len: usize,
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
    /// Whether the output runs down the columns.
    pub(super) transposed: bool,
}

impl ReadBlock<'_> {
    pub(super) fn read<const N: usize>(
        &self,
        decode: impl Fn([u8; N]) -> f64 + Copy,
        out: &mut [f64],
    ) {
        let (samples, _) = self.bytes.as_chunks::<N>();
        if self.transposed {
            self.read_transposed(samples, decode, out);
        } else if self.columns == (0..self.row_len) {
            let run = self.rows.start * self.row_len..self.rows.end * self.row_len;
            decode_run(&samples[run], decode, out);
        } else {
            let rows_out = out.chunks_exact_mut(self.columns.len());
            for (row, row_out) in self.rows.clone().zip(rows_out) {
                self.ask_for_row(samples, row + AHEAD);
                let run = self.row(samples, row);
                match (
                    <&[_; TILE]>::try_from(run),
                    <&mut [_; TILE]>::try_from(&mut *row_out),
                ) {
                    (Ok(run), Ok(row_out)) => *row_out = run.map(decode),
                    _ => decode_run(run, decode, row_out),
                }
            }
        }
    }

    fn row<'s, const N: usize>(&self, samples: &'s [[u8; N]], row: usize) -> &'s [[u8; N]] {
        &samples[row * self.row_len..][self.columns.clone()]
    }

    /// Prefetches short pieces of rows; long ones are left to the hardware prefetcher.
    fn ask_for_row<const N: usize>(&self, samples: &[[u8; N]], row: usize) {
        if row < self.rows.end && self.columns.len() <= TILE {
            let run = self.row(samples, row);
            run.first().into_iter().chain(run.last()).for_each(prefetch);
        }
    }

    fn read_transposed<const N: usize>(
        &self,
        samples: &[[u8; N]],
        decode: impl Fn([u8; N]) -> f64 + Copy,
        out: &mut [f64],
    ) {
        let (n_rows, n_columns) = (self.rows.len(), self.columns.len());
        for band in (0..n_rows).step_by(BAND) {
            let band_end = n_rows.min(band + BAND);
            for left in (0..n_columns).step_by(TILE) {
                let width = TILE.min(n_columns - left);
                for top in (band..band_end).step_by(TILE) {
                    let height = TILE.min(band_end - top);
                    let first = self.rows.start + top;
                    let rows = (first..first + height).map(|row| {
                        self.ask_for_row(samples, row + AHEAD);
                        &self.row(samples, row)[left..left + width]
                    });
                    let tile = transposed_tile(rows, decode);
                    for (c, column) in tile[..width].iter().enumerate() {
                        let out = &mut out[(left + c) * n_rows + top..][..height];
                        match out.first_chunk_mut() {
                            Some(out) => *out = *column,
                            None => out.copy_from_slice(&column[..height]),
                        }
                    }
                }
            }
        }
    }
}

/// A part of samples that lie at any strides.
pub(super) struct StridedBlock<'a> {
    pub(super) bytes: &'a [u8],
    /// Byte of the sample in row 0 and column 0.
    pub(super) start: usize,
    /// Bytes from row to row and from column to column.
    pub(super) strides: [isize; 2],
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
    /// Whether the output runs down the columns.
    pub(super) transposed: bool,
}

impl StridedBlock<'_> {
    pub(super) fn read<const N: usize>(&self, decode: impl Fn([u8; N]) -> f64, out: &mut [f64]) {
        let (height, width) = (self.rows.len(), self.columns.len());
        let [down, along] = self.strides;
        // A tile of rows at a time, so that a column of the output is written in whole cache lines.
        for top in (0..height).step_by(TILE) {
            for c in 0..width {
                for r in top..height.min(top + TILE) {
                    let by_rows = down * (self.rows.start + r) as isize;
                    let by_columns = along * (self.columns.start + c) as isize;
                    let at = self.start.wrapping_add_signed(by_rows + by_columns);
                    let sample = self.bytes[at..].first_chunk::<N>();
                    let to = match self.transposed {
                        true => c * height + r,
                        false => r * width + c,
                    };
                    out[to] = decode(*sample.expect("a sample within the bytes"));
                }
            }
        }
    }
}

/// Transposes at most 8 rows of at most 8 samples; whole rows have a length known to the compiler.
fn transposed_tile<'s, const N: usize>(
    rows: impl Iterator<Item = &'s [[u8; N]]>,
    decode: impl Fn([u8; N]) -> f64,
) -> [[f64; TILE]; TILE] {
    let mut tile = [[0.0; TILE]; TILE];
    for (r, row) in rows.enumerate() {
        if let Some(row) = row.first_chunk::<TILE>() {
            for (column, &sample) in tile.iter_mut().zip(row) {
                column[r] = decode(sample);
            }
        } else {
            for (column, &sample) in tile.iter_mut().zip(row) {
                column[r] = decode(sample);
            }
        }
    }
    tile
}

fn decode_run<const N: usize>(
    samples: &[[u8; N]],
    decode: impl Fn([u8; N]) -> f64,
    out: &mut [f64],
) {
    for (value, &sample) in out.iter_mut().zip(samples) {
        *value = decode(sample);
    }
}
