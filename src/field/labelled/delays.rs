//! Traces that begin at different times.

use super::super::Sample;
use super::super::align::{Alignment, Apart, Shift};
use super::super::assembly::Assembly;
use super::super::open::Contents;
use super::super::options::Delays;
use super::Arrays;
use crate::error::{Fault, Result};

/// The common part of all traces, if `treated` says that they are aligned.
///
/// # Errors
/// Delays that are not to be aligned, or are no whole numbers of steps where nothing may be resampled.
pub(super) fn aligned(
    arrays: &Arrays,
    mut contents: Contents,
    treated: Delays,
) -> Result<Contents> {
    let source = arrays.source;
    let listed = arrays.container.find("/delay");
    let milliseconds = listed.map(|i| arrays.container.numbers(i)).transpose()?;
    let milliseconds = milliseconds.unwrap_or_default();
    let step = source.stated.dt.and_then(|dt| dt.in_unit("s"));
    let (step, n_times) = (step.or(contents.time.even.step), contents.field.n_times);
    let (Some(step), Delays::Align, true) =
        (step, treated, milliseconds.len() == contents.field.n_sites)
    else {
        let ends = |of: fn(f64, f64) -> f64| milliseconds.iter().copied().reduce(of);
        let [least, most] = [f64::min, f64::max].map(|of| ends(of).unwrap_or(f64::NAN));
        let found = format!("delays from {least} to {most} ms");
        let advice =
            "take the times that all have with `--delays align`, or state `--delays ignore`";
        return Err(Fault::expected("traces that begin at one time", found, advice).into());
    };
    let options = source.options;
    let (jitter, method) = (options.jitter, options.resample.time);
    let mut shifts = Vec::with_capacity(milliseconds.len());
    for (trace, delay) in milliseconds.iter().enumerate() {
        let steps = (delay - milliseconds[0]) / 1e3 / step;
        let shift = Shift::of(steps, jitter, method);
        shifts.push(shift.ok_or_else(|| {
            let expected = "a delay of a whole number of steps against the first trace";
            let advice =
                "interpolate the traces, `--resample cubic`, or allow more, `--jitter 10%`";
            Fault::expected(expected, format!("{steps} of trace {trace}"), advice)
        })?);
    }
    let lengths = vec![n_times; shifts.len()];
    let apart = |Apart { early, late }| {
        let found = format!("trace {early} at its end before trace {late} begins");
        let advice = "leave traces out: save those that overlap as a file of their own";
        Fault::expected("two times that all traces have in common", found, advice)
    };
    let alignment = Alignment::new(shifts, lengths, method).map_err(apart)?;
    let shape = [contents.field.n_sites, alignment.n_times];
    let mut assembly = Assembly::new("the aligned traces", Sample::F64, shape, options)?;
    let mut record = vec![0.0; alignment.n_times];
    for trace in 0..contents.field.n_sites {
        let storage = &contents.field.storage;
        let read = |from: usize, out: &mut [f64]| {
            storage.read(from..from + out.len(), trace..trace + 1, true, out);
        };
        alignment.record(trace, read, &mut record);
        assembly.write(trace, &record)?;
    }
    contents.field.storage = assembly.finish(false)?;
    contents.field.n_times = alignment.n_times;
    contents.time.even.origin = Some(milliseconds[0] / 1e3 + alignment.start as f64 * step);
    contents.field.notes.extend(alignment.note(None));
    Ok(contents)
}
