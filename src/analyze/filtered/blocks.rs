//! Fields that do not fit into memory: records to a scratch file of spectra, all sites of some frequencies at a time
//! there and back, records to a scratch file of samples.

use std::ops::Range;

use ndarray::{ArrayViewMut2, s};
use num_complex::Complex;

use super::{Energies, Gaps, READ_BYTES, working_bytes};
use crate::error::{Error, Result};
use crate::field::{Field, ScratchFile, Storage};
use crate::numeric::pieces;
use crate::observer::Observer;
use crate::transform::{Passband, SpaceTimeFilter};

/// Records at once, at least: a cache line.
const TOGETHER: usize = 8;

/// Rows of samples and of complex bins that a row of the spectrum takes: itself and its pieces.
const ROW_COPIES: u64 = 2;

/// The field `(times, sites)`, padded to `shape`, in blocks that `allowed` bytes hold.
///
/// # Errors
/// As [`super::filtered`].
pub(super) fn filtered(
    field: &Field,
    band: &Passband,
    shape: (usize, usize),
    allowed: u64,
    observer: &dyn Observer,
) -> Result<(Storage, Energies)> {
    let blocks = Blocks::fit(shape, field.n_sites(), allowed)?;
    by_blocks(field, band, shape, &blocks, observer)
}

fn by_blocks(
    field: &Field,
    band: &Passband,
    shape: (usize, usize),
    blocks: &Blocks,
    observer: &dyn Observer,
) -> Result<(Storage, Energies)> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let bins = shape.0 / 2 + 1;
    let spectra = Spectra {
        file: ScratchFile::new(16 * bins as u64 * sites as u64)?,
        bins,
        sites,
        width: blocks.width,
    };
    let filter = SpaceTimeFilter::<f64>::new(shape);
    let before = blocks.there(field, (&filter, shape), &spectra, observer)?;

    let steps = (field.time.step, field.space.step);
    observer.stage("filtering", bins as u64);
    let mut rows = zeros::<Complex<f64>>(blocks.rows * shape.1)?;
    let mut room = zeros::<Complex<f64>>(blocks.rows * blocks.width)?;
    for of in pieces(bins, blocks.rows) {
        observer.go_on()?;
        let (from, count) = (of.start, of.len());
        let mut rows = of_shape(&mut rows, (count, shape.1));
        // The padding, which the last block has overwritten.
        rows.fill(Complex::default());
        for stripe in spectra.stripes() {
            let at = spectra.at(&stripe, from);
            let mut piece = of_shape(&mut room, (count, stripe.len()));
            spectra.file.read(at, bytes_of(&mut piece))?;
            rows.slice_mut(s![.., stripe]).assign(&piece);
        }
        let gain = filter.gain(steps, band);
        let done = filter.plan.filter_rows(from, rows.view_mut(), gain);
        done.expect("sites of the plan");
        for stripe in spectra.stripes() {
            let at = spectra.at(&stripe, from);
            let mut piece = of_shape(&mut room, (count, stripe.len()));
            piece.assign(&rows.slice(s![.., stripe]));
            spectra.file.write(at, bytes_of(&mut piece))?;
        }
        observer.advance(count as u64);
    }
    drop((rows, room));

    let out = ScratchFile::new(8 * times as u64 * sites as u64)?;
    let mut after = Vec::with_capacity(sites);
    observer.stage("transforming back", sites as u64);
    let mut bins_of = zeros::<Complex<f64>>(bins * blocks.width)?;
    let mut records = zeros::<f64>(shape.0 * blocks.width)?;
    let mut record = zeros::<f64>(times)?;
    for stripe in spectra.stripes() {
        observer.go_on()?;
        let width = stripe.len();
        let mut bins_of = of_shape(&mut bins_of, (bins, width));
        let at = spectra.at(&stripe, 0);
        spectra.file.read(at, bytes_of(&mut bins_of))?;
        let mut records = of_shape(&mut records, (shape.0, width));
        let done = filter
            .plan
            .columns_of_spectrum(bins_of.view(), records.view_mut());
        done.expect("records of the plan");
        for (site, column) in stripe.zip(records.columns()) {
            let mut energy = 0.0;
            for (to, from) in record.iter_mut().zip(column) {
                *to = *from;
                energy += from * from;
            }
            after.push(energy);
            out.write(8 * (site * times) as u64, bytemuck::cast_slice(&record))?;
        }
        observer.advance(width as u64);
    }
    Ok((out.storage(times, false)?, Energies { before, after }))
}

/// How much is in memory at once.
struct Blocks {
    /// Sites of which all times, and frequencies of which all sites.
    width: usize,
    rows: usize,
}

impl Blocks {
    fn fit(shape: (usize, usize), sites: usize, allowed: u64) -> Result<Blocks> {
        let bins = shape.0 as u64 / 2 + 1;
        // A record, its spectrum, and a copy of the record.
        let of_site = 8 * shape.0 as u64 + 16 * bins;
        let fixed = working_bytes(shape) + READ_BYTES as u64 + 8 * shape.0 as u64;
        let needed = fixed + of_site * TOGETHER as u64;
        let of_row = 16 * ROW_COPIES * shape.1 as u64;
        Error::beyond_memory(
            "the transform of eight records",
            needed.max(of_row),
            allowed,
        )?;
        let width = ((allowed - fixed) / of_site) as usize / TOGETHER * TOGETHER;
        let rows = (allowed.saturating_sub(fixed) / of_row).clamp(1, bins);
        Ok(Blocks {
            width: width.clamp(TOGETHER, sites.max(TOGETHER)),
            rows: rows as usize,
        })
    }

    /// Records to spectra, a stripe of sites at a time; returns the energies of all sites.
    fn there(
        &self,
        field: &Field,
        (filter, shape): (&SpaceTimeFilter<f64>, (usize, usize)),
        spectra: &Spectra,
        observer: &dyn Observer,
    ) -> Result<Vec<f64>> {
        let times = field.n_times();
        let mut energies = Vec::with_capacity(spectra.sites);
        let mut gaps = Gaps::default();
        let mut records = zeros::<f64>(shape.0 * self.width)?;
        let mut bins_of = zeros::<Complex<f64>>(spectra.bins * self.width)?;
        observer.stage("reading", spectra.sites as u64);
        for stripe in spectra.stripes() {
            let width = stripe.len();
            let mut records = of_shape(&mut records, (shape.0, width));
            records.fill(0.0);
            let some = (READ_BYTES / (8 * width)).clamp(1, times);
            for of in pieces(times, some) {
                observer.go_on()?;
                let mut block = records.slice_mut(s![of.clone(), ..]);
                let block = block.as_slice_mut().expect("whole rows");
                field.read_time_major(of, stripe.clone(), block);
                field.release_pages();
            }
            let samples = records.slice(s![..times, ..]);
            gaps.look(samples, stripe.start);
            energies.extend(super::energies(samples));
            let mut bins_of = of_shape(&mut bins_of, (spectra.bins, width));
            let done = filter
                .plan
                .columns_to_spectrum(records.view(), bins_of.view_mut());
            done.expect("records of the plan");
            let at = spectra.at(&stripe, 0);
            spectra.file.write(at, bytes_of(&mut bins_of))?;
            observer.advance(width as u64);
        }
        gaps.check(field)?;
        Ok(energies)
    }
}

/// A scratch file of spectra: stripes of sites one after the other, each frequency by frequency.
struct Spectra {
    file: ScratchFile,
    bins: usize,
    sites: usize,
    width: usize,
}

impl Spectra {
    fn stripes(&self) -> impl Iterator<Item = Range<usize>> {
        pieces(self.sites, self.width)
    }

    /// The byte at which frequency `row` of a stripe begins.
    fn at(&self, stripe: &Range<usize>, row: usize) -> u64 {
        16 * (stripe.start as u64 * self.bins as u64 + row as u64 * stripe.len() as u64)
    }
}

/// The start of `room` as an array.
fn of_shape<T>(room: &mut [T], shape: (usize, usize)) -> ArrayViewMut2<'_, T> {
    let values = &mut room[..shape.0 * shape.1];
    ArrayViewMut2::from_shape(shape, values).expect("as long as its shape")
}

/// Those of an array from [`of_shape`].
fn bytes_of<'a>(values: &'a mut ArrayViewMut2<Complex<f64>>) -> &'a mut [u8] {
    bytemuck::cast_slice_mut(values.as_slice_mut().expect("whole"))
}

fn zeros<T: Copy + Default>(len: usize) -> Result<Vec<T>> {
    super::zeros(len, "a block of the field")
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;
    use crate::observer::Silent;

    /// Primes, powers of two, records longer and shorter than a block; padded, and not.
    #[test]
    fn regress_blocks_do_not_move_a_bit() {
        let mut state = 3u64;
        for (shape, width, rows) in [
            ((64, 40), 8, 5),
            ((61, 37), 16, 31),
            ((1, 30), 8, 1),
            ((250, 1), 8, 7),
        ] {
            let values = Array2::from_shape_simple_fn(shape, || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            });
            let field = Field::from_array(values);
            let band = Passband {
                frequency: Some((0.03, 0.31)),
                ..Passband::default()
            };
            for twice in [1, 2] {
                let padded = (twice * shape.0, twice * shape.1);
                let whole = super::super::at_once(&field, &band, padded, &Silent).unwrap();
                let least = Blocks::fit(padded, shape.1, u64::MAX / 2).unwrap();
                assert!(least.width >= shape.1 && least.rows == padded.0 / 2 + 1);
                let blocks = Blocks { width, rows };
                let found = by_blocks(&field, &band, padded, &blocks, &Silent).unwrap();
                let all = |storage: Storage| {
                    let mut out = vec![0.0; shape.0 * shape.1];
                    Field::of_storage(storage, shape).read_time_major(
                        0..shape.0,
                        0..shape.1,
                        &mut out,
                    );
                    out
                };
                assert_eq!(whole.1.before, found.1.before);
                assert_eq!(whole.1.after, found.1.after);
                assert!(found.1.after.iter().sum::<f64>() > 0.0 || shape.0 == 1);
                assert_eq!(all(whole.0), all(found.0), "{shape:?} {twice}");
            }
        }
    }
}
