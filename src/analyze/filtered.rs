//! A field filtered in frequency and wavenumber.

use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::intermediate::SpillFile;
use super::request::Request;
use crate::error::{Error, Result};
use crate::field::{Field, ScratchFile, Storage};
use crate::numeric::pieces;
use crate::observer::Observer;
use crate::prepare::{Prepared, Tiles};
use crate::system::memory::{available_memory, try_filled};
use crate::transform::{Passband, Segments, space_time_filter, space_time_filter_bytes};

/// Bytes of a field that are read at once.
const READ_BYTES: usize = 8 << 20;

/// Records at once, at least: a cache line.
const TOGETHER: usize = 8;

/// A field that has passed a filter.
#[derive(Debug, Clone)]
pub struct Filtered {
    pub field: Field,
    /// `sum v^2` of the samples before and after.
    pub energy_before: f64,
    pub energy_after: f64,
}

/// The part of a field that passes a filter, and the share of its energy.
///
/// `v` is multiplied by a gain of 1 or 0 in (k, f) ([`Passband`]); with `pad`, the field is
/// first padded with zeros to twice its length along both axes, so that the periodic extension does
/// not wrap waves around.
///
/// A field whose transform does not fit into `memory` is filtered in blocks through two scratch files, each as long
/// as the padded field, with the same bits.
///
/// # Errors
/// [`Error::Request`] for bands with edges in the wrong order; [`Error::NonFinite`] for samples
/// that are not numbers; [`Error::Memory`] for memory that does not hold eight records, and
/// [`Error::Refused`] where the system has less memory than was allowed; [`Error::Cancelled`], which is noticed
/// between blocks.
pub fn filtered(
    field: &Field,
    band: &Passband,
    pad: bool,
    memory: Option<u64>,
    observer: &dyn Observer,
) -> Result<Filtered> {
    band.check()?;
    let (times, sites) = (field.n_times(), field.n_sites());
    let twice = if pad { 2 } else { 1 };
    let shape = (twice * times, twice * sites);
    let allowed = memory.unwrap_or_else(available_memory);
    let blocks = blocks(shape, sites, allowed)?;
    let (samples, energies) = by_blocks(field, band, shape, blocks, observer)?;
    let mut found = Field::of_storage(samples, (times, sites));
    found.time = field.time.clone();
    found.space = field.space.clone();
    found.quantity = field.quantity;
    found.unit = field.unit.clone();
    found.dispersion = field.dispersion.clone();
    found.name = format!("{}, filtered", field.name);
    let [energy_before, energy_after] = energies.map(|of| of.iter().sum());
    Ok(Filtered {
        field: found,
        energy_before,
        energy_after,
    })
}

/// How much is in memory at once: sites of which all times, frequencies of which all sites; and whether the whole spectrum is.
type Blocks = (usize, usize, bool);

fn blocks(shape: (usize, usize), sites: usize, allowed: u64) -> Result<Blocks> {
    let bins = shape.0 / 2 + 1;
    if bytes_at_once(shape, sites) <= allowed {
        return Ok((sites, bins, true));
    }
    // A record and its spectrum, and a row of the spectrum.
    let [record, spectrum, row] = [8 * shape.0, 16 * bins, 16 * shape.1].map(|n| n as u64);
    let fixed = working_bytes(shape) + READ_BYTES as u64 + record;
    let together = TOGETHER as u64;
    let needed = fixed + together * spectrum + row.max(together * record);
    Error::beyond_memory("the transform of eight records", needed, allowed)?;
    let free = allowed - fixed;
    let width = (free / (record + spectrum)).min((free - row) / spectrum);
    let width = width as usize / TOGETHER * TOGETHER;
    let width = width.clamp(TOGETHER, sites.max(TOGETHER));
    let rows = (free - width as u64 * spectrum) / row;
    Ok((width, rows.clamp(1, bins as u64) as usize, false))
}

/// Samples, their spectrum, and scratch of each thread.
fn bytes_at_once((times, sites): (usize, usize), records: usize) -> u64 {
    let samples = (times as u64).saturating_mul(8 * records as u64);
    let spectrum = (times as u64 / 2 + 1).saturating_mul(16 * sites as u64);
    let arrays = samples.saturating_add(spectrum);
    arrays.saturating_add(working_bytes((times, sites)))
}

/// Scratch of all threads.
fn working_bytes(shape: (usize, usize)) -> u64 {
    rayon::current_num_threads() as u64 * space_time_filter_bytes(shape)
}

/// The field padded to `shape`: records to spectra, rows of these there and back, spectra to records, which go to a scratch
/// file where the spectrum does. With the samples `sum v^2` of each site, before and after.
fn by_blocks(
    field: &Field,
    band: &Passband,
    shape: (usize, usize),
    (width, rows_at_once, is_whole): Blocks,
    observer: &dyn Observer,
) -> Result<(Storage, [Vec<f64>; 2])> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let (bins, width) = (shape.0 / 2 + 1, width.min(sites));
    let stripes = || pieces(sites, width);
    let plan = space_time_filter(shape);
    let file = (!is_whole).then(|| SpillFile::<f64>::new((bins, sites), width));
    let file = file.transpose()?;
    // The whole spectrum, or a stripe of it.
    let mut rows = zeros(if is_whole { bins * shape.1 } else { 0 })?;
    let mut stripe = zeros(if is_whole { 0 } else { bins * width })?;

    observer.stage("reading", sites as u64);
    let mut records = zeros(shape.0 * width)?;
    let mut before = Vec::with_capacity(sites);
    for of in stripes() {
        let mut records = of_shape(&mut records, (shape.0, of.len()));
        records.slice_mut(s![times.., ..]).fill(0.0);
        for some in pieces(times, (READ_BYTES / (8 * of.len())).clamp(1, times)) {
            observer.go_on()?;
            let mut block = records.slice_mut(s![some.clone(), ..]);
            let block = block.as_slice_mut().expect("whole rows");
            field.read_time_major(some, of.clone(), block);
            field.release_pages();
        }
        let samples = records.slice(s![..times, ..]);
        before.extend(energies(samples));
        let mut spectra = match &file {
            None => of_shape(&mut rows, (bins, shape.1)).slice_move(s![.., of.clone()]),
            Some(_) => of_shape(&mut stripe, (bins, of.len())),
        };
        let done = plan.columns_to_spectrum(records.view(), spectra.view_mut());
        done.expect("records of the plan");
        if let Some(file) = &file {
            file.write((0, of.start), &stripe[..bins * of.len()])?;
        }
        observer.advance(of.len() as u64);
    }
    drop(records);
    if !before.iter().all(|energy| energy.is_finite()) {
        refuse_gaps(field, observer)?;
    }

    observer.stage("filtering", bins as u64);
    if file.is_some() {
        rows = zeros(rows_at_once * shape.1)?;
    }
    for of in pieces(bins, rows_at_once) {
        observer.go_on()?;
        let mut rows = of_shape(&mut rows, (of.len(), shape.1));
        if let Some(file) = &file {
            // The padding, which the last block has overwritten.
            rows.fill(Complex::default());
            for sites in stripes() {
                let mut piece = of_shape(&mut stripe, (of.len(), sites.len()));
                file.read((of.start, sites.start), whole(&mut piece))?;
                rows.slice_mut(s![.., sites]).assign(&piece);
            }
        }
        let gain = band.gain(shape, (field.time.step, field.space.step));
        let done = plan.filter_rows(of.start, rows.view_mut(), gain);
        done.expect("sites of the plan");
        if let Some(file) = &file {
            for sites in stripes() {
                let mut piece = of_shape(&mut stripe, (of.len(), sites.len()));
                piece.assign(&rows.slice(s![.., sites.clone()]));
                file.write((of.start, sites.start), whole(&mut piece))?;
            }
        }
        observer.advance(of.len() as u64);
    }
    if file.is_some() {
        rows = Vec::new();
    }

    observer.stage("transforming back", sites as u64);
    let out = (!is_whole).then(|| ScratchFile::new(8 * times as u64 * sites as u64));
    let out = out.transpose()?;
    let mut records = zeros(shape.0 * width)?;
    let mut after = Vec::with_capacity(sites);
    for of in stripes() {
        observer.go_on()?;
        let spectra = match &file {
            None => of_shape(&mut rows, (bins, shape.1)).slice_move(s![.., of.clone()]),
            Some(file) => {
                let mut spectra = of_shape(&mut stripe, (bins, of.len()));
                file.read((0, of.start), whole(&mut spectra))?;
                spectra
            }
        };
        let mut records = of_shape(&mut records, (shape.0, of.len()));
        let done = plan.columns_of_spectrum(spectra.view(), records.view_mut());
        done.expect("records of the plan");
        let records = records.slice(s![..times, ..]);
        after.extend(energies(records));
        if let Some(out) = &out {
            for (site, record) in of.clone().zip(records.columns()) {
                let at = 8 * (site * times) as u64;
                out.write(at, bytemuck::cast_slice(&record.to_vec()))?;
            }
        }
        observer.advance(of.len() as u64);
    }
    let storage = match out {
        Some(out) => out.storage(times, false)?,
        None => {
            records.truncate(times * sites);
            records.shrink_to_fit();
            Storage::from_values(records, sites, true)
        }
    };
    Ok((storage, [before, after]))
}

/// The error of a field with samples that are no numbers, if it has any.
fn refuse_gaps(field: &Field, observer: &dyn Observer) -> Result<()> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let request = Request::default();
    let preparation = request.preparation(Segments::whole(times));
    let tiles = Tiles {
        sites: TOGETHER,
        times: TOGETHER,
        ahead: Some(TOGETHER),
        memory: READ_BYTES as u64,
    };
    Prepared::new(field, 0..times, 0..sites, preparation, tiles, observer).map(|_| ())
}

/// The start of `room` as an array.
fn of_shape<T>(room: &mut [T], shape: (usize, usize)) -> ArrayViewMut2<'_, T> {
    let values = &mut room[..shape.0 * shape.1];
    ArrayViewMut2::from_shape(shape, values).expect("as long as its shape")
}

/// The numbers of an array from [`of_shape`].
fn whole<'a, T>(values: &'a mut ArrayViewMut2<T>) -> &'a mut [T] {
    values.as_slice_mut().expect("whole")
}

/// `sum v^2` of each site, in the order of time.
fn energies(values: ArrayView2<f64>) -> Vec<f64> {
    let sums = values.fold_axis(Axis(0), 0.0, |sum, v| sum + v * v);
    sums.to_vec()
}

fn zeros<T: Copy + Default>(len: usize) -> Result<Vec<T>> {
    try_filled(len, T::default()).map_err(|_| Error::Refused {
        what: "a block of the field",
        needed: (len * size_of::<T>()) as u64,
    })
}
