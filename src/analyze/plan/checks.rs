//! What a request must satisfy, held against the field.

use std::ops::Range;

use crate::analyze::display::{self, Show};
use crate::analyze::request::{Request, TimeRange};
use crate::analyze::result::Axes;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::in_band;
use crate::prepare::{Gaps, Window};
use crate::transform::Segments;

/// More threads than any machine has cores are a slip of the hand.
const MOST_THREADS: usize = 1024;

pub(super) fn site_range(field: &Field, request: &Request) -> Result<Range<usize>> {
    let all = 0..field.n_sites();
    let range = request.sites.clone().unwrap_or(all.clone());
    if range.is_empty() || range.end > all.end {
        return Err(Error::Request {
            option: "sites",
            expected: format!("a range of sites within 0:{}", all.end),
            found: format!("{}:{}", range.start, range.end),
        });
    }
    Ok(range)
}

pub(super) fn time_range(
    field: &Field,
    request: &Request,
    sites: &Range<usize>,
) -> Result<Range<usize>> {
    let n = field.n_times();
    let axis = &field.time;
    match request.times {
        TimeRange::All if n > 0 => Ok(0..n),
        TimeRange::All => Err(Error::Request {
            option: "field",
            expected: "at least one time".into(),
            found: "none".into(),
        }),
        TimeRange::Interval { from, to } => {
            // Ends of the interval that fall on a sample up to rounding belong to it.
            let farthest = axis.origin.abs().max(axis.at(n).abs());
            let slack = 1e-9 * axis.step + 4.0 * f64::EPSILON * farthest;
            let first = ((from - axis.origin - slack) / axis.step).ceil().max(0.0);
            let last = ((to - axis.origin + slack) / axis.step).floor();
            let last = last.min(n as f64 - 1.0);
            if !(last >= 0.0 && first <= last) {
                return Err(Error::Request {
                    option: "times",
                    expected: format!(
                        "an interval that holds times from {} to {}, {} apart",
                        rounded(axis.origin),
                        rounded(axis.at(n.saturating_sub(1))),
                        axis.step
                    ),
                    found: format!("{from}:{to}"),
                });
            }
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
    if !(threshold > 0.0 && threshold < 1.0) {
        return Err(Error::Request {
            option: "arrival-threshold",
            expected: "a share of the largest amplitude between 0 and 1".into(),
            found: threshold.to_string(),
        });
    }
    let n = field.n_times();
    let last = sites.len() - 1;
    let mut largest = 0.0f64;
    let mut at_last = Vec::with_capacity(n);
    let mut block = Vec::new();
    let times = ((1 << 20) / sites.len()).max(1);
    for start in (0..n).step_by(times) {
        let piece = start..(start + times).min(n);
        block.resize(piece.len() * sites.len(), 0.0);
        field.read_time_major(piece, sites.clone(), &mut block);
        field.release_pages();
        let finite = block.iter().filter(|v| v.is_finite());
        largest = finite.fold(largest, |m, v| m.max(v.abs()));
        at_last.extend(
            block
                .chunks_exact(sites.len())
                .map(|profile| profile[last].abs()),
        );
    }
    let arrival = at_last.iter().position(|&v| v > threshold * largest);
    match arrival {
        Some(0) => Err(Error::Request {
            option: "until-arrival",
            expected: "a last site that is quiet at the first time".into(),
            found: format!("|v| = {:.3e} there at once", at_last[0]),
        }),
        Some(end) => {
            let before = &mut at_last[..end];
            let before = *before.select_nth_unstable_by(end / 2, f64::total_cmp).1;
            if before > QUIET * threshold * largest {
                return Err(Error::Request {
                    option: "until-arrival",
                    expected: format!(
                        "a last site that is quiet until |v| exceeds {threshold} of its largest value; state a larger \
                         `--arrival-threshold`, above the noise"
                    ),
                    found: format!(
                        "a median |v| of {before:.3e} before, and more than that after {end} samples"
                    ),
                });
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
    if welch.segment == 0 || welch.segment > n_times {
        return Err(Error::Request {
            option: "segment",
            expected: format!("1 to {n_times} samples (the record)"),
            found: welch.segment.to_string(),
        });
    }
    if welch.overlap >= welch.segment {
        return Err(Error::Request {
            option: "overlap",
            expected: format!("fewer samples than a segment of {}", welch.segment),
            found: welch.overlap.to_string(),
        });
    }
    Ok(Segments {
        record: n_times,
        length: welch.segment,
        hop: welch.segment - welch.overlap,
    })
}

pub(super) fn padded(option: &'static str, asked: Option<usize>, samples: usize) -> Result<usize> {
    match asked {
        Some(length) if length < samples => Err(Error::Request {
            option,
            expected: format!("at least the {samples} samples to be transformed"),
            found: length.to_string(),
        }),
        Some(length) => Ok(length),
        None => Ok(samples),
    }
}

pub(super) fn check_references(
    field: &Field,
    request: &Request,
    times: &Range<usize>,
    sites: &Range<usize>,
) -> Result<()> {
    let inside = |option, sites: &Range<usize>, site: usize| {
        if sites.contains(&site) {
            return Ok(());
        }
        Err(Error::Request {
            option,
            expected: format!("a site of the range {}:{}", sites.start, sites.end),
            found: site.to_string(),
        })
    };
    if request.gaps == Gaps::LeaveOut {
        return Err(Error::Request {
            option: "gaps",
            expected: "refuse, interpolate or mask: segments are left out of averages over them, which have \
                       intervals"
                .into(),
            found: "leave-out".into(),
        });
    }
    if request.subtract_noise {
        let refuse = |expected: &str, found: &str| {
            Err(Error::Request {
                option: "subtract-noise",
                expected: expected.into(),
                found: found.into(),
            })
        };
        if request.results.spacetime {
            let expected = "spectra along time without space-time spectra, which keep the noise";
            return refuse(expected, "space-time spectra");
        }
        if !request.results.temporal {
            return refuse("spectra along time", "none");
        }
        if request.noise.is_some() {
            return refuse("noise that is found in the field", "noise that is stated");
        }
    }
    check_left_out(request, sites)?;
    let present = |option, site: usize| match request.without_sites.contains(&site) {
        false => Ok(()),
        true => Err(Error::Request {
            option,
            expected: "a site that is not left out".into(),
            found: site.to_string(),
        }),
    };
    if let Some(site) = request.reference_site {
        inside("reference-site", sites, site)?;
        present("reference-site", site)?;
    }
    for &site in &request.short_time.sites {
        inside("short-time-sites", sites, site)?;
        present("short-time-sites", site)?;
    }
    let (from, to) = (field.time.at(times.start), field.time.at(times.end - 1));
    let asked = request.reference_time.map(|t| ("reference-time", t));
    let followed = request.short_time.times.iter();
    for (option, t) in asked
        .into_iter()
        .chain(followed.map(|&t| ("short-time-times", t)))
    {
        let slack = 0.5 * field.time.step;
        if !(t >= from - slack && t <= to + slack) {
            return Err(Error::Request {
                option,
                expected: format!("a time from {} to {}", rounded(from), rounded(to)),
                found: t.to_string(),
            });
        }
    }
    let ends = [
        0.5 / field.time.step.abs(),
        std::f64::consts::PI / field.space.step.abs(),
    ];
    for ((option, edge), end) in [
        ("band-edge-frequency", request.band_edge_frequency),
        ("band-edge-wavenumber", request.band_edge_wavenumber),
    ]
    .into_iter()
    .zip(ends)
    {
        // Of a single site there is no other wavenumber than 0.
        if edge.is_some_and(|e| !(e >= 0.0 && e <= end)) {
            return Err(Error::Request {
                option,
                expected: format!("a number from 0 to {}, where the axis ends", rounded(end)),
                found: edge.unwrap_or_default().to_string(),
            });
        }
    }
    for (option, given) in [
        ("front-window", request.front_window),
        ("noise", request.noise),
    ] {
        if let Some(found) = given.filter(|x| !(*x > 0.0 && x.is_finite())) {
            return Err(Error::Request {
                option,
                expected: "a number above 0".into(),
                found: found.to_string(),
            });
        }
    }
    if let Some(threads) = request.threads.filter(|n| !(1..=MOST_THREADS).contains(n)) {
        return Err(Error::Request {
            option: "threads",
            expected: format!("1 to {MOST_THREADS}"),
            found: threads.to_string(),
        });
    }
    Ok(())
}

/// That sites which are left out are there, leave others, and that nothing is wanted that needs all.
fn check_left_out(request: &Request, sites: &Range<usize>) -> Result<()> {
    let refuse = |expected: String, found: String| {
        Err(Error::Request {
            option: "without-sites",
            expected,
            found,
        })
    };
    let left_out = &request.without_sites;
    if left_out.is_empty() {
        return Ok(());
    }
    if let Some(site) = left_out.iter().find(|site| !sites.contains(site)) {
        let expected = format!("sites of the range {}:{}", sites.start, sites.end);
        return refuse(expected, site.to_string());
    }
    if sites.clone().all(|site| left_out.contains(&site)) {
        return refuse("sites that remain".into(), "all sites".into());
    }
    let results = request.results;
    let along_space = [
        (results.spatial, "spatial spectra"),
        (results.spacetime, "space-time spectra"),
        (results.flux_surrogate, "the flux surrogate"),
        (
            results.short_time && !request.short_time.times.is_empty(),
            "short-time spectra along space",
        ),
    ];
    match along_space.into_iter().find(|(is_wanted, _)| *is_wanted) {
        None => Ok(()),
        Some((_, what)) => refuse(
            "spectra along time alone, since spectra along space need sites at even distances"
                .into(),
            what.into(),
        ),
    }
}

/// Checks the window's parameter for its number of samples.
pub(in crate::analyze) fn check_window(
    option: &'static str,
    window: Window,
    samples: usize,
) -> Result<()> {
    window.validate(samples).map_err(|error| Error::Request {
        option,
        expected: format!("{} for {samples} samples", error.expected),
        found: error.found,
    })
}

/// That the axes of padded spectra can be held, before they are.
pub(super) fn check_axes(padded_time: usize, padded_space: usize, allowed: u64) -> Result<()> {
    let needed = (padded_space as u64)
        .saturating_mul(2)
        .saturating_add(padded_time as u64)
        .saturating_mul(8);
    if needed > allowed {
        return Err(Error::Memory {
            what: "holding the axes of the spectra",
            needed,
            allowed,
        });
    }
    Ok(())
}

/// `x` to 12 digits, for a message: without the rounding of `origin + n step`.
fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// The band over which directions are summed: as requested, within the axis, with at least one bin.
/// That the display limits lie on the axes, and that there is a picture to show.
pub(super) fn show_fits(request: &Request, axes: &Axes) -> Result<()> {
    if !request.maps && request.show != Show::default() {
        return Err(Error::Request {
            option: "show",
            expected: "maps, which the display limits are for".into(),
            found: "none".into(),
        });
    }
    display::check(&request.show, axes)
}

pub(super) fn direction_band(asked: Option<(f64, f64)>, frequencies: &[f64]) -> Result<(f64, f64)> {
    let highest = frequencies[frequencies.len() - 1];
    let (from, to) = asked.unwrap_or((0.0, highest));
    let band = (from.max(0.0), to.min(highest));
    if frequencies.iter().any(|&f| in_band(f, band)) {
        return Ok(band);
    }
    Err(Error::Request {
        option: "direction-band",
        expected: format!(
            "two frequencies with a bin between them, up to {}",
            rounded(highest)
        ),
        found: format!("{from}:{to}"),
    })
}
