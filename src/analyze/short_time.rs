//! Short-time spectra: along t at chosen sites, along x at chosen times.

use ndarray::{Array2, Array3, ArrayViewMut2};
use rayon::iter::{ParallelBridge, ParallelIterator};

use super::plan::checked_window;
use super::request::Request;
use super::result::ShortTimeSpectra;
use super::stages::Stages;
use crate::error::{Error, Result};
use crate::field::Axis;
use crate::transform::{
    Real, RecordScratch, RecordTransform, Scale, Segments, fold, frequencies, power, wavenumbers,
};

/// Frames that are transformed together.
pub(super) const TOGETHER: usize = 8;

/// Spectra along t of the requested sites, by default the first, the middle and the last.
pub(super) fn along_time<T: Real>(all: &Stages) -> Result<ShortTimeSpectra> {
    let (plan, axes) = (all.plan, &all.plan.axes);
    let sites: Vec<usize> = match plan.request.short_time.sites.as_slice() {
        [] => {
            let present = (0..axes.n_sites).filter(|j| !all.prepared.is_left_out(*j));
            let present: Vec<usize> = present.collect();
            let last = present.len() - 1;
            vec![present[0], present[last / 2], present[last]]
        }
        chosen => chosen.iter().map(|j| j - plan.sites.start).collect(),
    };
    let segments = plan.short_time[0];
    let n = segments.length;
    let scale =
        |weights: &[f64]| Scale::along_time(plan.request.scaling, weights, n, n, axes.time.step);
    let of_sites = ("short-time", sites, &axes.space);
    let bins = frequencies(n, axes.time.step);
    let record = |site| all.record(site);
    spectra::<T>(all, of_sites, (segments, &axes.time), (scale, bins), record)
}

/// Spectra along x of the requested times; `None` if there are none.
pub(super) fn along_space<T: Real>(all: &Stages) -> Result<Option<ShortTimeSpectra>> {
    let (plan, axes) = (all.plan, &all.plan.axes);
    let asked = &plan.request.short_time.times;
    if asked.is_empty() {
        return Ok(None);
    }
    let times = asked.iter().map(|t| axes.row_at(*t)).collect();
    let segments = plan.short_time[1];
    let n = segments.length;
    let scale =
        |weights: &[f64]| Scale::along_space(plan.request.scaling, weights, n, axes.space.step);
    let of_times = ("short-space", times, &axes.time);
    let bins = wavenumbers(n, axes.space.step);
    let profile = |time| {
        let mut profile = vec![0.0; axes.n_sites];
        all.prepared.profiles(time..time + 1, &mut profile);
        profile
    };
    let along = (segments, &axes.space);
    spectra::<T>(all, of_times, along, (scale, bins), profile).map(Some)
}

/// The stage that makes spectra of these rows (sites, or times) of an axis: segments along the other one, which `read` has.
fn spectra<T: Real>(
    all: &Stages,
    (stage, mut rows, across): (&'static str, Vec<usize>, &Axis),
    (segments, axis): (Segments, &Axis),
    (scale, bins): (impl Fn(&[f64]) -> Scale, Vec<f64>),
    read: impl Fn(usize) -> Vec<f64> + Sync,
) -> Result<ShortTimeSpectra> {
    rows.sort_unstable();
    rows.dedup();
    let count = (rows.len() * segments.count()) as u64;
    all.observer.stage(stage, count);
    let (window, n) = (all.plan.request.short_time.window, segments.length);
    let weights = window.samples(n);
    let (factor, transform) = (
        scale(&weights).factor,
        RecordTransform::<T>::new(&weights, n),
    );
    let starts: Vec<usize> = segments.starts().collect();
    let of = |(row, mut values): (&usize, ArrayViewMut2<f64>)| -> Result<()> {
        let (record, mut scratch) = (read(*row), RecordScratch::default());
        for (block, starts) in starts.chunks(TOGETHER).enumerate() {
            all.observer.go_on()?;
            let frames = starts.iter().map(|&start| &record[start..start + n]);
            let mut spectra = Array2::default((bins.len(), starts.len()));
            transform.transform_into(frames, spectra.view_mut(), &mut scratch);
            for ((m, s), &x) in spectra.indexed_iter() {
                let value = power(x) * (factor * fold(m, n)) * all.stored;
                values[[m, block * TOGETHER + s]] = value;
            }
            all.observer.advance(starts.len() as u64);
        }
        Ok(())
    };
    let mut values = Array3::zeros((rows.len(), bins.len(), starts.len()));
    let mut each = rows.iter().zip(values.outer_iter_mut());
    // A field larger than memory is swept once a row, and these are held one at a time.
    match all.plan.streams() {
        true => each.try_for_each(of)?,
        false => each.par_bridge().try_for_each(of)?,
    }
    let half = 0.5 * (n - 1) as f64;
    let centres = starts
        .iter()
        .map(|&s| axis.origin + (s as f64 + half) * axis.step);
    Ok(ShortTimeSpectra {
        frames: centres.collect(),
        segment: n,
        hop: segments.hop,
        window: window.gains(n),
        at: rows.iter().map(|row| across.at(*row)).collect(),
        rows,
        values,
        bins,
    })
}

/// Segments of records of `n_times` and of profiles of `n_sites`.
///
/// # Errors
/// [`crate::Error::Request`] names the option that does not fit.
pub(super) fn segments(request: &Request, n_times: usize, n_sites: usize) -> Result<[Segments; 2]> {
    let asked = &request.short_time;
    let options = ["short-time-segment", "short-time-hop"];
    let time = choose(options, n_times, asked.segment, asked.hop)?;
    let options = ["short-space-segment", "short-space-hop"];
    let space = choose(options, n_sites, asked.segment_space, asked.hop_space)?;
    if request.results.short_time {
        checked_window("short-time-window", asked.window, time.length)?;
        if !asked.times.is_empty() {
            checked_window("short-time-window", asked.window, space.length)?;
        }
    }
    Ok([time, space])
}

/// Segments with a length of a power of two near an eighth of the record, at least 16 samples if
/// the record has them, with a hop of a quarter of the length.
fn choose(
    [length_option, hop_option]: [&'static str; 2],
    record: usize,
    length: Option<usize>,
    hop: Option<usize>,
) -> Result<Segments> {
    let default = (record / 8).max(1).next_power_of_two().max(16).min(record);
    let length = length.unwrap_or(default);
    let is_within = (1..=record).contains(&length);
    let expected = format!("1 to {record} samples");
    Error::require(is_within, length_option, expected, length)?;
    let hop = hop.unwrap_or((length / 4).max(1));
    Error::require(hop > 0, hop_option, "at least 1 sample", hop)?;
    Ok(Segments {
        record,
        length,
        hop,
    })
}
