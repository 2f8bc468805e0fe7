//! What a request must satisfy, held against the field.

use std::ops::Range;

use crate::analyze::request::{Request, TimeRange};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::{in_band, pieces};
use crate::prepare::{Gaps, Window};
use crate::transform::Segments;

/// More threads than any machine has cores are a slip of the hand.
const MOST_THREADS: usize = 1024;

pub(super) fn site_range(field: &Field, request: &Request) -> Result<Range<usize>> {
    let all = field.n_sites();
    let range = request.sites.clone().unwrap_or(0..all);
    if range.is_empty() || range.end > all {
        let expected = format!("a range of sites within 0:{all}");
        let found = format!("{}:{}", range.start, range.end);
        return Err(Error::request("sites", expected, found));
    }
    Ok(range)
}

pub(super) fn time_range(
    field: &Field,
    request: &Request,
    sites: &Range<usize>,
) -> Result<Range<usize>> {
    let (n, axis) = (field.n_times(), &field.time);
    match request.times {
        TimeRange::All if n > 0 => Ok(0..n),
        TimeRange::All => Err(Error::request("field", "at least one time", "none")),
        TimeRange::Interval { from, to } => {
            // Ends of the interval that fall on a sample up to rounding belong to it.
            let farthest = axis.origin.abs().max(axis.at(n).abs());
            let slack = 1e-9 * axis.step + 4.0 * f64::EPSILON * farthest;
            let first = ((from - axis.origin - slack) / axis.step).ceil().max(0.0);
            let last = ((to - axis.origin + slack) / axis.step).floor();
            let last = last.min(n as f64 - 1.0);
            if last >= 0.0 && first <= last {
                return Ok(first as usize..last as usize + 1);
            }
            let [begin, end] = [axis.origin, axis.at(n.saturating_sub(1))].map(rounded);
            let expected = format!(
                "an interval that holds times from {begin} to {end}, {} apart",
                axis.step
            );
            Err(Error::request("times", expected, format!("{from}:{to}")))
        }
        TimeRange::UntilArrival { threshold } => until_arrival(field, sites, threshold),
    }
}

/// Median of `|v|` before the arrival, relative to what tells it, above which noise may have told it: normal
/// noise exceeds eight times this median once in 1e7 samples.
const QUIET: f64 = 0.125;

/// Times before `|v|` at the last site exceeds `threshold` of the field's largest `|v|`.
fn until_arrival(field: &Field, sites: &Range<usize>, threshold: f64) -> Result<Range<usize>> {
    if !(threshold > 0.0 && threshold < 1.0) {
        let expected = "a share of the largest amplitude between 0 and 1";
        let found = threshold.to_string();
        return Err(Error::request("arrival-threshold", expected, found));
    }
    let (n, width) = (field.n_times(), sites.len());
    let mut largest = 0.0f64;
    let mut at_last = Vec::with_capacity(n);
    let mut block = Vec::new();
    let times = ((1 << 20) / width).max(1);
    for piece in pieces(n, times) {
        block.resize(piece.len() * width, 0.0);
        field.read_time_major(piece, sites.clone(), &mut block);
        field.release_pages();
        let finite = block.iter().filter(|v| v.is_finite());
        largest = finite.fold(largest, |m, v| m.max(v.abs()));
        at_last.extend(block.chunks_exact(width).map(|row| row[width - 1].abs()));
    }
    let refuse = |expected: String, found| Err(Error::request("until-arrival", expected, found));
    match at_last.iter().position(|&v| v > threshold * largest) {
        Some(0) => {
            let expected = "a last site that is quiet at the first time".into();
            refuse(expected, format!("|v| = {:.3e} there at once", at_last[0]))
        }
        Some(end) => {
            let before = &mut at_last[..end];
            let before = *before.select_nth_unstable_by(end / 2, f64::total_cmp).1;
            if before > QUIET * threshold * largest {
                let expected = format!(
                    "a last site that is quiet until |v| exceeds {threshold} of its largest value; state a larger \
                     `--arrival-threshold`, above the noise"
                );
                let found = format!(
                    "a median |v| of {before:.3e} before, and more than that after {end} samples"
                );
                return refuse(expected, found);
            }
            Ok(0..end)
        }
        None => Ok(0..n),
    }
}

pub(super) fn segments(request: &Request, n_times: usize) -> Result<Segments> {
    let Some(welch) = request.welch else {
        return Ok(Segments::whole(n_times));
    };
    if !(1..=n_times).contains(&welch.segment) {
        let expected = format!("1 to {n_times} samples (the record)");
        let found = welch.segment.to_string();
        return Err(Error::request("segment", expected, found));
    }
    if welch.overlap >= welch.segment {
        let expected = format!("fewer samples than a segment of {}", welch.segment);
        let found = welch.overlap.to_string();
        return Err(Error::request("overlap", expected, found));
    }
    Ok(Segments {
        record: n_times,
        length: welch.segment,
        hop: welch.segment - welch.overlap,
    })
}

pub(super) fn padded(option: &'static str, asked: Option<usize>, samples: usize) -> Result<usize> {
    let length = asked.unwrap_or(samples);
    if length < samples {
        let expected = format!("at least the {samples} samples to be transformed");
        return Err(Error::request(option, expected, length.to_string()));
    }
    Ok(length)
}

pub(super) fn check_references(
    field: &Field,
    request: &Request,
    times: &Range<usize>,
    sites: &Range<usize>,
) -> Result<()> {
    if request.gaps == Gaps::LeaveOut {
        let expected = "refuse, interpolate or mask: segments are left out of averages over them, which have \
                        intervals";
        return Err(Error::request("gaps", expected, "leave-out"));
    }
    if request.subtract_noise {
        let refused = if request.results.spacetime {
            let expected = "spectra along time without space-time spectra, which keep the noise";
            Some((expected, "space-time spectra"))
        } else if !request.results.temporal {
            Some(("spectra along time", "none"))
        } else {
            let stated = ("noise that is found in the field", "noise that is stated");
            request.noise.map(|_| stated)
        };
        if let Some((expected, found)) = refused {
            return Err(Error::request("subtract-noise", expected, found));
        }
    }
    check_left_out(request, sites)?;
    let asked = request.reference_site.iter();
    let followed = request.short_time.sites.iter();
    let asked = asked.map(|site| ("reference-site", site));
    for (option, site) in asked.chain(followed.map(|site| ("short-time-sites", site))) {
        let refuse = |expected: String| Err(Error::request(option, expected, site.to_string()));
        if !sites.contains(site) {
            return refuse(format!("a site of the range {}:{}", sites.start, sites.end));
        }
        if request.without_sites.contains(site) {
            return refuse("a site that is not left out".into());
        }
    }
    let (from, to) = (field.time.at(times.start), field.time.at(times.end - 1));
    let slack = 0.5 * field.time.step;
    let asked = request.reference_time.iter();
    let asked = asked.map(|t| ("reference-time", t));
    let followed = request.short_time.times.iter();
    for (option, t) in asked.chain(followed.map(|t| ("short-time-times", t))) {
        if !(*t >= from - slack && *t <= to + slack) {
            let expected = format!("a time from {} to {}", rounded(from), rounded(to));
            return Err(Error::request(option, expected, t.to_string()));
        }
    }
    let highest = 0.5 / field.time.step.abs();
    // Of a single site there is no other wavenumber than 0.
    let largest = std::f64::consts::PI / field.space.step.abs();
    for (option, edge, end) in [
        ("band-edge-frequency", request.band_edge_frequency, highest),
        (
            "band-edge-wavenumber",
            request.band_edge_wavenumber,
            largest,
        ),
    ] {
        if let Some(edge) = edge.filter(|e| !(*e >= 0.0 && *e <= end)) {
            let expected = format!("a number from 0 to {}, where the axis ends", rounded(end));
            return Err(Error::request(option, expected, edge.to_string()));
        }
    }
    for (option, given) in [
        ("front-window", request.front_window),
        ("noise", request.noise),
    ] {
        if let Some(found) = given.filter(|x| !(*x > 0.0 && x.is_finite())) {
            return Err(Error::request(
                option,
                "a number above 0",
                found.to_string(),
            ));
        }
    }
    if let Some(threads) = request.threads.filter(|n| !(1..=MOST_THREADS).contains(n)) {
        let expected = format!("1 to {MOST_THREADS}");
        return Err(Error::request("threads", expected, threads.to_string()));
    }
    Ok(())
}

/// That sites which are left out are there, leave others, and that nothing is wanted that needs all.
fn check_left_out(request: &Request, sites: &Range<usize>) -> Result<()> {
    let (left_out, results) = (&request.without_sites, request.results);
    if left_out.is_empty() {
        return Ok(());
    }
    let refuse =
        |expected: &str, found: &str| Err(Error::request("without-sites", expected, found));
    if let Some(site) = left_out.iter().find(|site| !sites.contains(site)) {
        let expected = format!("sites of the range {}:{}", sites.start, sites.end);
        return refuse(&expected, &site.to_string());
    }
    if sites.clone().all(|site| left_out.contains(&site)) {
        return refuse("sites that remain", "all sites");
    }
    let short_space = results.short_time && !request.short_time.times.is_empty();
    let along_space = [
        (results.spatial, "spatial spectra"),
        (results.spacetime, "space-time spectra"),
        (results.flux_surrogate, "the flux surrogate"),
        (short_space, "short-time spectra along space"),
    ];
    let expected =
        "spectra along time alone, since spectra along space need sites at even distances";
    let found = along_space.into_iter().find(|(is_wanted, _)| *is_wanted);
    found.map_or(Ok(()), |(_, what)| refuse(expected, what))
}

/// Checks the window's parameter for its number of samples.
pub(in crate::analyze) fn check_window(
    option: &'static str,
    window: Window,
    samples: usize,
) -> Result<()> {
    window.validate(samples).map_err(|error| {
        let expected = format!("{} for {samples} samples", error.expected);
        Error::request(option, expected, error.found)
    })
}

/// That the axes of padded spectra can be held, before they are.
pub(super) fn check_axes(padded_time: usize, padded_space: usize, allowed: u64) -> Result<()> {
    let needed = (padded_space as u64)
        .saturating_mul(2)
        .saturating_add(padded_time as u64)
        .saturating_mul(8);
    Error::beyond_memory("holding the axes of the spectra", needed, allowed)
}

/// `x` to 12 digits, for a message: without the rounding of `origin + n step`.
fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// The band over which directions are summed: as requested, within the axis, with at least one bin.
pub(super) fn direction_band(asked: Option<(f64, f64)>, frequencies: &[f64]) -> Result<(f64, f64)> {
    let highest = frequencies[frequencies.len() - 1];
    let (from, to) = asked.unwrap_or((0.0, highest));
    let band = (from.max(0.0), to.min(highest));
    if frequencies.iter().any(|&f| in_band(f, band)) {
        return Ok(band);
    }
    let highest = rounded(highest);
    let expected = format!("two frequencies with a bin between them, up to {highest}");
    let found = format!("{from}:{to}");
    Err(Error::request("direction-band", expected, found))
}
