//! Short-time spectra: along t at chosen sites, along x at chosen times.

use ndarray::Array2;
use ndarray::parallel::prelude::*;

use super::plan::check_window;
use super::request::Request;
use super::result::{ShortTimeSpectra, ShortTimeSpectrum};
use super::stages::Stages;
use crate::error::{Error, Result};
use crate::field::Axis;
use crate::transform::{
    Real, RecordScratch, RecordTransform, Scale, Scaling, Segments, fold, frequencies, power,
    wavenumbers,
};

/// Frames that are transformed together.
pub(super) const TOGETHER: usize = 8;

/// Segments of one axis and the bins they are transformed to.
struct Frames<'a, T: Real> {
    all: &'a Stages<'a>,
    segments: Segments,
    transform: RecordTransform<T>,
    scale: Scale,
}

impl<'a, T: Real> Frames<'a, T> {
    fn new(
        all: &'a Stages<'a>,
        segments: Segments,
        scale: impl Fn(Scaling, &[f64]) -> Scale,
    ) -> Self {
        let request = &all.plan.request;
        let weights = request.short_time.window.samples(segments.length);
        Frames {
            all,
            segments,
            transform: RecordTransform::new(&weights, segments.length),
            scale: scale(request.scaling, &weights),
        }
    }

    /// `(bin, frame)` of the record (or profile) with this index and coordinate.
    fn spectrum(
        &self,
        (index, at): (usize, f64),
        record: &[f64],
        scratch: &mut RecordScratch<T>,
    ) -> Result<ShortTimeSpectrum> {
        let (n, observer) = (self.segments.length, self.all.observer);
        let starts: Vec<usize> = self.segments.starts().collect();
        let mut values = Array2::zeros((self.transform.bins(), starts.len()));
        for (block, starts) in starts.chunks(TOGETHER).enumerate() {
            observer.go_on()?;
            let frames = starts.iter().map(|&start| &record[start..start + n]);
            let (spectra, _) = self.transform.transform(frames, scratch);
            for (m, row) in spectra.chunks_exact(starts.len()).enumerate() {
                for (s, &x) in row.iter().enumerate() {
                    values[[m, block * TOGETHER + s]] =
                        power(x) * (self.scale.factor * fold(m, n)) * self.all.stored;
                }
            }
            observer.advance(starts.len() as u64);
        }
        Ok(ShortTimeSpectrum { index, at, values })
    }

    /// Sorts the rows whose spectra are made in this stage.
    fn begin(&self, stage: &'static str, mut rows: Vec<usize>) -> Vec<usize> {
        rows.sort_unstable();
        rows.dedup();
        let count = (rows.len() * self.segments.count()) as u64;
        self.all.observer.stage(stage, count);
        rows
    }

    /// Spectra along `axis`.
    fn along(
        &self,
        axis: &Axis,
        bins: fn(usize, f64) -> Vec<f64>,
        spectra: Vec<ShortTimeSpectrum>,
    ) -> ShortTimeSpectra {
        let Segments { length, hop, .. } = self.segments;
        let half = 0.5 * (length - 1) as f64;
        let centres = self.segments.starts();
        let centres = centres.map(|s| axis.origin + (s as f64 + half) * axis.step);
        ShortTimeSpectra {
            bins: bins(length, axis.step),
            frames: centres.collect(),
            segment: length,
            hop,
            window: self.all.plan.request.short_time.window.gains(length),
            spectra,
        }
    }
}

/// Spectra along t of the requested sites, by default the first, the middle and the last.
pub(super) fn along_time<T: Real>(all: &Stages) -> Result<ShortTimeSpectra> {
    let (plan, axes) = (all.plan, &all.plan.axes);
    let frames = Frames::<T>::new(all, plan.short_time.time, |scaling, weights| {
        let length = weights.len();
        Scale::along_time(scaling, weights, length, length, axes.time.step)
    });
    let sites: Vec<usize> = match plan.request.short_time.sites.as_slice() {
        [] => {
            let present = (0..axes.n_sites).filter(|j| !all.prepared.is_left_out(*j));
            let present: Vec<usize> = present.collect();
            let last = present.len() - 1;
            vec![present[0], present[last / 2], present[last]]
        }
        chosen => chosen.iter().map(|j| j - plan.sites.start).collect(),
    };
    let sites = frames.begin("short-time", sites);
    let of = |site: usize| {
        let place = (site, axes.space.at(site));
        frames.spectrum(place, &all.record(site), &mut RecordScratch::default())
    };
    // A field larger than memory is swept once a site, and its records are held one at a time.
    let spectra: Result<Vec<ShortTimeSpectrum>> = match plan.tiles.ahead {
        Some(_) => sites.into_iter().map(of).collect(),
        None => sites.into_par_iter().map(of).collect(),
    };
    Ok(frames.along(&axes.time, frequencies, spectra?))
}

/// Spectra along x of the requested times; `None` if there are none.
pub(super) fn along_space<T: Real>(all: &Stages) -> Result<Option<ShortTimeSpectra>> {
    let (plan, axes) = (all.plan, &all.plan.axes);
    let asked = &plan.request.short_time.times;
    if asked.is_empty() {
        return Ok(None);
    }
    let frames = Frames::<T>::new(all, plan.short_time.space, |scaling, weights| {
        Scale::along_space(scaling, weights, weights.len(), axes.space.step)
    });
    let nearest = |&t: &f64| super::nearest(&axes.time, t, axes.n_times);
    let times = frames.begin("short-space", asked.iter().map(nearest).collect());
    let (mut profile, mut scratch) = (vec![0.0; axes.n_sites], RecordScratch::default());
    let spectra: Result<Vec<ShortTimeSpectrum>> = times
        .into_iter()
        .map(|time| {
            all.prepared.profiles(time..time + 1, &mut profile);
            frames.spectrum((time, axes.time.at(time)), &profile, &mut scratch)
        })
        .collect();
    Ok(Some(frames.along(&axes.space, wavenumbers, spectra?)))
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
        let options = ["short-time-segment", "short-time-hop"];
        let time = choose(options, n_times, asked.segment, asked.hop)?;
        let options = ["short-space-segment", "short-space-hop"];
        let space = choose(options, n_sites, asked.segment_space, asked.hop_space)?;
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
        let expected = format!("1 to {record} samples");
        return Err(Error::request(length_option, expected, length.to_string()));
    }
    let hop = hop.unwrap_or((length / 4).max(1));
    if hop == 0 {
        return Err(Error::request(hop_option, "at least 1 sample", "0"));
    }
    Ok(Segments {
        record,
        length,
        hop,
    })
}
