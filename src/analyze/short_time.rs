//! Short-time spectra: along t at chosen sites, along x at chosen times.

use ndarray::Array2;

use super::plan::Plan;
use super::result::{ShortTimeSpectra, ShortTimeSpectrum};
use crate::error::{Error, Result};
use crate::field::Axis;
use crate::prepare::{Prepared, Window};
use crate::transform::{
    Real, RealTransform, Scale, Scratch, Segments, fold, frequencies, power, wavenumbers,
};

/// Segments of one axis and the bins they are transformed to.
struct Frames<T: Real> {
    segments: Segments,
    transform: RealTransform<T>,
    scale: Scale,
    scratch: Scratch<T>,
}

impl<T: Real> Frames<T> {
    /// `(bin, frame)` of one record.
    fn spectra(&mut self, record: &[f64], stored: f64) -> Array2<f64> {
        let n = self.transform.padded();
        let mut values = Array2::zeros((self.transform.bins(), self.segments.count()));
        for (s, start) in self.segments.starts().enumerate() {
            let piece = &record[start..start + self.segments.length];
            let (spectrum, _) = self.transform.transform(piece, &mut self.scratch);
            for (m, &x) in spectrum.iter().enumerate() {
                values[[m, s]] = power(x) * (self.scale.factor * fold(m, n)) * stored;
            }
        }
        values
    }
}

/// Spectra along t of the sites asked for, by default the first, the middle and the last.
pub(super) fn along_time<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    stored: f64,
) -> Result<ShortTimeSpectra> {
    let asked = &plan.request.short_time;
    let (nt, nx) = (plan.axes.n_times, plan.axes.n_sites);
    let segments = choose("short-time-segment", nt, asked.segment, asked.hop)?;
    let weights = asked.window.samples(segments.length);
    let scaling = plan.request.scaling;
    let dt = plan.axes.time.step;
    let mut frames = Frames::<T> {
        segments,
        transform: RealTransform::new(&weights, segments.length),
        scale: Scale::along_time(scaling, &weights, segments.length, segments.length, dt),
        scratch: Scratch::default(),
    };
    let mut sites: Vec<usize> = match asked.sites.as_slice() {
        [] => vec![0, (nx - 1) / 2, nx - 1],
        chosen => chosen.iter().map(|j| j - plan.sites.start).collect(),
    };
    sites.sort_unstable();
    sites.dedup();
    let mut record = vec![0.0; nt];
    let spectra = sites
        .into_iter()
        .map(|index| {
            prepared.record(index, &mut record);
            ShortTimeSpectrum {
                index,
                at: plan.axes.space.at(index),
                values: frames.spectra(&record, stored),
            }
        })
        .collect();
    Ok(ShortTimeSpectra {
        bins: frequencies(segments.length, dt),
        ..describe(&plan.axes.time, segments, asked.window, spectra)
    })
}

/// Spectra along x of the times asked for; `None` where none are.
pub(super) fn along_space<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    stored: f64,
) -> Result<Option<ShortTimeSpectra>> {
    let asked = &plan.request.short_time;
    if asked.times.is_empty() {
        return Ok(None);
    }
    let nx = plan.axes.n_sites;
    let (length, hop) = (asked.segment_space, asked.hop_space);
    let segments = choose("short-space-segment", nx, length, hop)?;
    let weights = asked.window.samples(segments.length);
    let dx = plan.axes.space.step;
    let mut frames = Frames::<T> {
        segments,
        transform: RealTransform::new(&weights, segments.length),
        scale: Scale::along_space(plan.request.scaling, &weights, segments.length, dx),
        scratch: Scratch::default(),
    };
    let nearest = |&t: &f64| super::nearest(&plan.axes.time, t, plan.axes.n_times);
    let mut times: Vec<usize> = asked.times.iter().map(nearest).collect();
    times.sort_unstable();
    times.dedup();
    let mut profile = vec![0.0; nx];
    let spectra = times
        .into_iter()
        .map(|index| {
            prepared.profiles(index..index + 1, &mut profile);
            ShortTimeSpectrum {
                index,
                at: plan.axes.time.at(index),
                values: frames.spectra(&profile, stored),
            }
        })
        .collect();
    Ok(Some(ShortTimeSpectra {
        bins: wavenumbers(segments.length, dx),
        ..describe(&plan.axes.space, segments, asked.window, spectra)
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

/// A power of two near an eighth of the record, at least 16 samples where there are so many, a
/// quarter of it apart.
fn choose(
    option: &'static str,
    record: usize,
    length: Option<usize>,
    hop: Option<usize>,
) -> Result<Segments> {
    let default = (record / 8).max(1).next_power_of_two().max(16).min(record);
    let length = length.unwrap_or(default);
    if length == 0 || length > record {
        return Err(Error::Request {
            option,
            expected: format!("1 to {record} samples"),
            found: length.to_string(),
        });
    }
    let hop = hop.unwrap_or((length / 4).max(1));
    if hop == 0 {
        return Err(Error::Request {
            option: "short-time-hop",
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
