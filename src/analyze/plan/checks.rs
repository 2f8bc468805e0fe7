//! What a request must satisfy, held against the field.

use std::ops::Range;

use crate::analyze::request::{Request, TimeRange};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::{in_band, pieces, sum_of_squares};
use crate::prepare::{Gaps, Window};
use crate::transform::Segments;

/// More threads than any machine has cores are a slip of the hand.
const MOST_THREADS: usize = 1024;

pub(super) fn site_range(field: &Field, request: &Request) -> Result<Range<usize>> {
    let all = field.n_sites();
    let range = request.sites.clone().unwrap_or(0..all);
    let is_inside = !range.is_empty() && range.end <= all;
    let expected = format!("a range of sites within 0:{all}");
    let found = format!("{}:{}", range.start, range.end);
    Error::require(is_inside, "sites", expected, found)?;
    Ok(range)
}

pub(super) fn time_range(
    field: &Field,
    request: &Request,
    sites: &Range<usize>,
) -> Result<Range<usize>> {
    let (n, axis) = (field.n_times(), &field.time);
    match request.times {
        TimeRange::All => {
            Error::require(n > 0, "field", "at least one time", "none")?;
            Ok(0..n)
        }
        TimeRange::Interval { from, to } => {
            // Ends of the interval that fall on a sample up to rounding belong to it.
            let farthest = axis.origin.abs().max(axis.at(n).abs());
            let slack = 1e-9 * axis.step + 4.0 * f64::EPSILON * farthest;
            let first = ((from - axis.origin - slack) / axis.step).ceil().max(0.0);
            let last = ((to - axis.origin + slack) / axis.step).floor();
            let last = last.min(n as f64 - 1.0);
            let [begin, end] = [axis.origin, axis.at(n.saturating_sub(1))].map(rounded);
            let expected = format!(
                "an interval that holds times from {begin} to {end}, {} apart",
                axis.step
            );
            let holds = last >= 0.0 && first <= last;
            Error::require(holds, "times", expected, format!("{from}:{to}"))?;
            Ok(first as usize..last as usize + 1)
        }
        TimeRange::UntilArrival { threshold } => until_arrival(field, sites, threshold),
    }
}

/// Median of `|v|` before the arrival, relative to what tells it, above which noise may have told it: normal
/// noise exceeds eight times this median once in 1e7 samples.
const QUIET: f64 = 0.125;

/// Times before `|v|` at the last site exceeds `threshold` of the field's largest `|v|`.
fn until_arrival(field: &Field, sites: &Range<usize>, threshold: f64) -> Result<Range<usize>> {
    let expected = "a share of the largest amplitude between 0 and 1";
    let is_share = threshold > 0.0 && threshold < 1.0;
    Error::require(is_share, "arrival-threshold", expected, threshold)?;
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
    let Some(end) = at_last.iter().position(|&v| v > threshold * largest) else {
        return Ok(0..n);
    };
    let option = "until-arrival";
    let expected = "a last site that is quiet at the first time";
    let found = format!("|v| = {:.3e} there at once", at_last[0]);
    Error::require(end > 0, option, expected, found)?;
    let before = &mut at_last[..end];
    let before = *before.select_nth_unstable_by(end / 2, f64::total_cmp).1;
    let expected = format!(
        "a last site that is quiet until |v| exceeds {threshold} of its largest value; state a larger \
         `--arrival-threshold`, above the noise"
    );
    let found =
        format!("a median |v| of {before:.3e} before, and more than that after {end} samples");
    Error::require(
        before <= QUIET * threshold * largest,
        option,
        expected,
        found,
    )?;
    Ok(0..end)
}

pub(super) fn segments(request: &Request, n_times: usize) -> Result<Segments> {
    let Some(welch) = request.welch else {
        return Ok(Segments::whole(n_times));
    };
    let expected = format!("1 to {n_times} samples (the record)");
    let is_within = (1..=n_times).contains(&welch.segment);
    Error::require(is_within, "segment", expected, welch.segment)?;
    let expected = format!("fewer samples than a segment of {}", welch.segment);
    let advances = welch.overlap < welch.segment;
    Error::require(advances, "overlap", expected, welch.overlap)?;
    Ok(Segments {
        record: n_times,
        length: welch.segment,
        hop: welch.segment - welch.overlap,
    })
}

pub(super) fn padded(option: &'static str, asked: Option<usize>, samples: usize) -> Result<usize> {
    let length = asked.unwrap_or(samples);
    let expected = format!("at least the {samples} samples to be transformed");
    Error::require(length >= samples, option, expected, length)?;
    Ok(length)
}

pub(super) fn check_references(
    field: &Field,
    request: &Request,
    times: &Range<usize>,
    sites: &Range<usize>,
) -> Result<()> {
    let expected = "refuse, interpolate or mask: segments are left out of averages over them, which have \
                    intervals";
    Error::require(
        request.gaps != Gaps::LeaveOut,
        "gaps",
        expected,
        "leave-out",
    )?;
    if request.subtract_noise {
        let option = "subtract-noise";
        let expected = "spectra along time without space-time spectra, which keep the noise";
        let without = !request.results.spacetime;
        Error::require(without, option, expected, "space-time spectra")?;
        let expected = "spectra along time";
        Error::require(request.results.temporal, option, expected, "none")?;
        let expected = "noise that is found in the field";
        let is_found = request.noise.is_none();
        Error::require(is_found, option, expected, "noise that is stated")?;
    }
    check_left_out(request, sites)?;
    let followed = request.short_time.sites.iter();
    let followed = followed.map(|site| ("short-time-sites", site));
    let asked = request.reference_site.iter();
    for (option, site) in asked.map(|site| ("reference-site", site)).chain(followed) {
        let expected = format!("a site of the range {}:{}", sites.start, sites.end);
        Error::require(sites.contains(site), option, expected, site)?;
        let is_there = !request.without_sites.contains(site);
        Error::require(is_there, option, "a site that is not left out", site)?;
    }
    let (from, to) = (field.time.at(times.start), field.time.at(times.end - 1));
    let slack = 0.5 * field.time.step;
    let followed = request.short_time.times.iter();
    let followed = followed.map(|t| ("short-time-times", t));
    let asked = request.reference_time.iter();
    for (option, t) in asked.map(|t| ("reference-time", t)).chain(followed) {
        let expected = format!("a time from {} to {}", rounded(from), rounded(to));
        let is_inside = (from - slack..=to + slack).contains(t);
        Error::require(is_inside, option, expected, t)?;
    }
    let highest = 0.5 / field.time.step.abs();
    // Of a single site there is no other wavenumber than 0.
    let largest = std::f64::consts::PI / field.space.step.abs();
    let (frequency, wavenumber) = (request.band_edge_frequency, request.band_edge_wavenumber);
    for (option, edge, end) in [
        ("band-edge-frequency", frequency, highest),
        ("band-edge-wavenumber", wavenumber, largest),
    ] {
        let edge = edge.unwrap_or(0.0);
        let expected = format!("a number from 0 to {}, where the axis ends", rounded(end));
        Error::require((0.0..=end).contains(&edge), option, expected, edge)?;
    }
    let (window, noise) = (request.front_window, request.noise);
    for (option, given) in [("front-window", window), ("noise", noise)] {
        let given = given.unwrap_or(1.0);
        let is_above = given > 0.0 && given.is_finite();
        Error::require(is_above, option, "a number above 0", given)?;
    }
    let threads = request.threads.unwrap_or(1);
    let is_possible = (1..=MOST_THREADS).contains(&threads);
    Error::require(
        is_possible,
        "threads",
        format!("1 to {MOST_THREADS}"),
        threads,
    )
}

/// That sites which are left out are there, leave others, and that nothing is wanted that needs all.
fn check_left_out(request: &Request, sites: &Range<usize>) -> Result<()> {
    let (left_out, results) = (&request.without_sites, request.results);
    if left_out.is_empty() {
        return Ok(());
    }
    let option = "without-sites";
    for site in left_out {
        let expected = format!("sites of the range {}:{}", sites.start, sites.end);
        Error::require(sites.contains(site), option, expected, site)?;
    }
    let remain = sites.clone().any(|site| !left_out.contains(&site));
    Error::require(remain, option, "sites that remain", "all sites")?;
    let short_space = results.short_time && !request.short_time.times.is_empty();
    let expected =
        "spectra along time alone, since spectra along space need sites at even distances";
    for (is_wanted, what) in [
        (results.spatial, "spatial spectra"),
        (results.spacetime, "space-time spectra"),
        (results.flux_surrogate, "the flux surrogate"),
        (short_space, "short-time spectra along space"),
    ] {
        Error::require(!is_wanted, option, expected, what)?;
    }
    Ok(())
}

/// The weights of a window over this number of samples, which its parameter fits.
pub(in crate::analyze) fn checked_window(
    option: &'static str,
    window: Window,
    samples: usize,
) -> Result<Vec<f64>> {
    window.validate(samples).map_err(|error| {
        let expected = format!("{} for {samples} samples", error.expected);
        Error::request(option, expected, error.found)
    })?;
    let weights = window.samples(samples);
    let leaves_some = sum_of_squares(&weights) > 0.0;
    let found = format!("{window} over {samples} samples, all zero");
    Error::require(
        leaves_some,
        option,
        "a window that leaves some samples",
        found,
    )?;
    Ok(weights)
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
    let holds = frequencies.iter().any(|&f| in_band(f, band));
    let highest = rounded(highest);
    let expected = format!("two frequencies with a bin between them, up to {highest}");
    Error::require(holds, "direction-band", expected, format!("{from}:{to}"))?;
    Ok(band)
}
