//! Short-time spectra: along t at chosen sites, along x at chosen times.

use ndarray::Array2;
use ndarray::parallel::prelude::*;

use super::plan::{Plan, check_window};
use super::request::Request;
use super::result::{ShortTimeSpectra, ShortTimeSpectrum};
use crate::error::{Error, Result};
use crate::field::Axis;
use crate::observer::Observer;
use crate::prepare::{Prepared, Window};
use crate::transform::{
    Real, RecordScratch, RecordTransform, Scale, Segments, fold, frequencies, power, wavenumbers,
};

/// Frames that are transformed together.
pub(super) const TOGETHER: usize = 8;

/// Segments of one axis and the bins they are transformed to.
struct Frames<'a, T: Real> {
    segments: Segments,
    transform: &'a RecordTransform<T>,
    scratch: RecordScratch<T>,
    scale: Scale,
}

impl<T: Real> Frames<'_, T> {
    /// `(bin, frame)` of one record.
    fn spectra(
        &mut self,
        record: &[f64],
        stored: f64,
        observer: &dyn Observer,
    ) -> Result<Array2<f64>> {
        let n = self.segments.length;
        let starts: Vec<usize> = self.segments.starts().collect();
        let mut values = Array2::zeros((self.transform.bins(), starts.len()));
        for (block, starts) in starts.chunks(TOGETHER).enumerate() {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let frames = starts.iter().map(|&start| &record[start..start + n]);
            let (spectra, _) = self.transform.transform(frames, &mut self.scratch);
            for (m, row) in spectra.chunks_exact(starts.len()).enumerate() {
                for (s, &x) in row.iter().enumerate() {
                    values[[m, block * TOGETHER + s]] =
                        power(x) * (self.scale.factor * fold(m, n)) * stored;
                }
            }
            observer.advance(starts.len() as u64);
        }
        Ok(values)
    }
}

/// Spectra along t of the requested sites, by default the first, the middle and the last.
pub(super) fn along_time<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    stored: f64,
    observer: &dyn Observer,
) -> Result<ShortTimeSpectra> {
    let asked = &plan.request.short_time;
    let (nt, nx) = (plan.axes.n_times, plan.axes.n_sites);
    let segments = plan.short_time.time;
    let weights = asked.window.samples(segments.length);
    let scaling = plan.request.scaling;
    let dt = plan.axes.time.step;
    let transform = RecordTransform::<T>::new(&weights, segments.length);
    let scale = Scale::along_time(scaling, &weights, segments.length, segments.length, dt);
    let mut sites: Vec<usize> = match asked.sites.as_slice() {
        [] => {
            let present: Vec<usize> = (0..nx).filter(|j| !prepared.is_left_out(*j)).collect();
            let last = present.len() - 1;
            vec![present[0], present[last / 2], present[last]]
        }
        chosen => chosen.iter().map(|j| j - plan.sites.start).collect(),
    };
    sites.sort_unstable();
    sites.dedup();
    observer.stage("short-time", (sites.len() * segments.count()) as u64);
    let of = |index: usize| {
        let mut record = vec![0.0; nt];
        prepared.record(index, &mut record);
        let mut frames = Frames::<T> {
            segments,
            transform: &transform,
            scratch: RecordScratch::default(),
            scale,
        };
        Ok(ShortTimeSpectrum {
            index,
            at: plan.axes.space.at(index),
            values: frames.spectra(&record, stored, observer)?,
        })
    };
    // A field larger than memory is swept once a site, and its records are held one at a time.
    let spectra: Result<Vec<ShortTimeSpectrum>> = match plan.tiles.ahead {
        Some(_) => sites.into_iter().map(of).collect(),
        None => sites.into_par_iter().map(of).collect(),
    };
    Ok(ShortTimeSpectra {
        bins: frequencies(segments.length, dt),
        ..describe(&plan.axes.time, segments, asked.window, spectra?)
    })
}

/// Spectra along x of the requested times; `None` if there are none.
pub(super) fn along_space<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    stored: f64,
    observer: &dyn Observer,
) -> Result<Option<ShortTimeSpectra>> {
    let asked = &plan.request.short_time;
    if asked.times.is_empty() {
        return Ok(None);
    }
    let nx = plan.axes.n_sites;
    let segments = plan.short_time.space;
    let weights = asked.window.samples(segments.length);
    let dx = plan.axes.space.step;
    let transform = RecordTransform::<T>::new(&weights, segments.length);
    let mut frames = Frames::<T> {
        segments,
        transform: &transform,
        scratch: RecordScratch::default(),
        scale: Scale::along_space(plan.request.scaling, &weights, segments.length, dx),
    };
    let nearest = |&t: &f64| super::nearest(&plan.axes.time, t, plan.axes.n_times);
    let mut times: Vec<usize> = asked.times.iter().map(nearest).collect();
    times.sort_unstable();
    times.dedup();
    let mut profile = vec![0.0; nx];
    observer.stage("short-space", (times.len() * segments.count()) as u64);
    let spectra: Result<Vec<ShortTimeSpectrum>> = times
        .into_iter()
        .map(|index| {
            prepared.profiles(index..index + 1, &mut profile);
            Ok(ShortTimeSpectrum {
                index,
                at: plan.axes.time.at(index),
                values: frames.spectra(&profile, stored, observer)?,
            })
        })
        .collect();
    Ok(Some(ShortTimeSpectra {
        bins: wavenumbers(segments.length, dx),
        ..describe(&plan.axes.space, segments, asked.window, spectra?)
    }))
}

fn describe(
    axis: &Axis,
    segments: Segments,
    window: Window,
    spectra: Vec<ShortTimeSpectrum>,
) -> ShortTimeSpectra {
    let half = 0.5 * (segments.length - 1) as f64;
    ShortTimeSpectra {
        bins: Vec::new(),
        frames: segments
            .starts()
            .map(|s| axis.origin + (s as f64 + half) * axis.step)
            .collect(),
        segment: segments.length,
        hop: segments.hop,
        window: window.gains(segments.length),
        spectra,
    }
}

/// The segments of short-time spectra, settled before the run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShortTimeSegments {
    pub(in crate::analyze) time: Segments,
    pub(in crate::analyze) space: Segments,
}

impl ShortTimeSegments {
    /// Segments of records of `n_times` and of profiles of `n_sites`.
    ///
    /// # Errors
    /// [`Error::Request`] names the option that does not fit.
    pub(super) fn settle(request: &Request, n_times: usize, n_sites: usize) -> Result<Self> {
        let asked = &request.short_time;
        let time = choose(
            ["short-time-segment", "short-time-hop"],
            n_times,
            asked.segment,
            asked.hop,
        )?;
        let space = choose(
            ["short-space-segment", "short-space-hop"],
            n_sites,
            asked.segment_space,
            asked.hop_space,
        )?;
        if request.results.short_time {
            check_window("short-time-window", asked.window, time.length)?;
            if !asked.times.is_empty() {
                check_window("short-time-window", asked.window, space.length)?;
            }
        }
        Ok(ShortTimeSegments { time, space })
    }
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
    if length == 0 || length > record {
        return Err(Error::Request {
            option: length_option,
            expected: format!("1 to {record} samples"),
            found: length.to_string(),
        });
    }
    let hop = hop.unwrap_or((length / 4).max(1));
    if hop == 0 {
        return Err(Error::Request {
            option: hop_option,
            expected: "at least 1 sample".into(),
            found: "0".into(),
        });
    }
    Ok(Segments {
        record,
        length,
        hop,
    })
}
