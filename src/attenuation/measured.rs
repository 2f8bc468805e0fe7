//! Measured curves and fields, for comparison with computed ones.

use std::path::Path;

use serde::Serialize;

use super::pulse::Located;
use crate::error::{Error, Fault, Result};
use crate::field::Field;
use crate::numeric::{deviation, median};

/// A measured value at an abscissa.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasuredPoint {
    pub at: f64,
    pub value: f64,
    /// Standard error, where it is known.
    pub error: Option<f64>,
}

/// A measured point and the computed value at the same abscissa.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Compared {
    pub measured: MeasuredPoint,
    pub computed: f64,
    /// Measured minus computed.
    pub difference: f64,
    /// The same in standard errors, where these are known.
    pub in_errors: Option<f64>,
}

impl MeasuredPoint {
    pub fn compared_with(self, computed: f64) -> Compared {
        let difference = self.value - computed;
        Compared {
            measured: self,
            computed,
            difference,
            in_errors: self.error.filter(|e| *e > 0.0).map(|e| difference / e),
        }
    }
}

/// Reads a measured curve from a text table: abscissa, value and, optionally, standard error. A
/// first row without numbers is a heading; empty rows and rows that begin with `#` are skipped.
///
/// # Errors
/// [`Error::Read`]; [`Error::Input`] with the number of an invalid line.
pub fn read_curve(path: &Path) -> Result<Vec<MeasuredPoint>> {
    let bytes = std::fs::read(path).map_err(Error::read("read", path))?;
    let fault = |line: usize, expected: &str, found: String| {
        let advice = "write one row a point: abscissa, value, standard error if known";
        let said = format!("line {line}: expected {expected}, found {found}");
        Error::input(path)(Fault::new(said, advice))
    };
    let text = String::from_utf8(bytes).map_err(|_| {
        let expected = "a text table; a velocity field cannot be read as a curve";
        fault(1, expected, "bytes that are not text (UTF-8)".into())
    })?;
    let mut points: Vec<MeasuredPoint> = Vec::new();
    let mut headed = false;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        let numbers: Option<Vec<f64>> = cells
            .iter()
            .map(|cell| cell.parse().ok().filter(|v: &f64| v.is_finite()))
            .collect();
        match numbers.as_deref() {
            Some(&[at, value, ref error @ ..])
                if error.len() < 2 && error.iter().all(|error| *error >= 0.0) =>
            {
                points.push(MeasuredPoint {
                    at,
                    value,
                    error: error.first().copied(),
                });
            }
            None if points.is_empty() && !headed => {
                if let Some(unit) = cells.get(1).and_then(|cell| unit_of(cell)) {
                    let expected =
                        "forces relative to those of the homogeneous chain, without a unit";
                    let found = format!("`{}` in `{unit}`", cells[1]);
                    return Err(fault(number + 1, expected, found));
                }
                headed = true;
            }
            _ => {
                let expected =
                    "two or three finite numbers: abscissa, value, standard error of 0 or more";
                return Err(fault(number + 1, expected, format!("`{line}`")));
            }
        }
    }
    if points.is_empty() {
        return Err(fault(1, "at least one row of numbers", "none".into()));
    }
    Ok(points)
}

/// The unit in brackets that a heading states; `None` for numbers.
fn unit_of(heading: &str) -> Option<&str> {
    let open = heading.find(['(', '['])?;
    let unit = heading[open + 1..].trim_end_matches([')', ']']).trim();
    let is_number = matches!(unit, "" | "1" | "-" | "relative" | "rel." | "ratio");
    (!is_number && unit.len() <= 4).then_some(unit)
}

/// The pulse at one site of a measured velocity field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasuredPeak {
    pub site: usize,
    /// Peak velocity, interpolated between samples, and its time, with standard errors.
    pub velocity: Located,
    pub time: Located,
    /// Arrival: the last time before the peak at which the velocity is half of the peak; `None`
    /// where the record begins too late.
    pub arrival: Option<Located>,
    /// Standard deviation of the samples before the pulse; where these are few, the median of other sites. `None`
    /// if it is known at no site: then errors are those of interpolation alone.
    pub noise: Option<f64>,
}

impl MeasuredPeak {
    /// The peak velocity and, if known, the arrival as points of curves at the abscissa `at`.
    pub fn points(&self, at: f64) -> (MeasuredPoint, Option<MeasuredPoint>) {
        let point = |of: Located| MeasuredPoint {
            at,
            value: of.value,
            error: self.noise.map(|_| of.error),
        };
        (point(self.velocity), self.arrival.map(point))
    }
}

/// Samples on either side of the largest one that the interpolating quartic uses.
const REACH: usize = 2;

/// A site is quiet until its velocity first exceeds this fraction of its largest sample.
const QUIET: f64 = 0.2;

/// Fewest quiet samples for a noise estimate.
const ENOUGH: usize = 16;

/// The peak velocity of every site of a field, interpolated by the quartic through the five samples
/// around the largest one. Times are those of the field's axis. The error combines two parts: the
/// noise of the samples before the pulse, propagated to the maximum of the quartic; and the
/// distance to the vertex of the parabola through three samples, which bounds the interpolation
/// error. Left out are sites whose largest sample is among the first or last two, and sites without
/// a positive sample.
pub fn measured_peaks(field: &Field) -> Vec<MeasuredPeak> {
    let times = field.n_times();
    let mut record = vec![0.0; times];
    let noises = (0..field.n_sites()).map(|site| {
        field.read_site_major(0..times, site..site + 1, &mut record);
        noise_of(&record)
    });
    let noises: Vec<Option<f64>> = noises.collect();
    let common = median(noises.iter().flatten().copied());
    let timed = |samples: Located| Located {
        value: field.time.origin + samples.value * field.time.step,
        error: samples.error * field.time.step,
    };
    let peaks = (0..field.n_sites()).filter_map(|site| {
        field.read_site_major(0..times, site..site + 1, &mut record);
        let peak = peak_of(&record, noises[site].or(common))?;
        Some(MeasuredPeak {
            site,
            time: timed(peak.time),
            arrival: peak.arrival.map(timed),
            ..peak
        })
    });
    peaks.collect()
}

/// The first of the largest finite samples.
fn largest(record: &[f64]) -> Option<usize> {
    let known = (0..record.len()).filter(|i| record[*i].is_finite());
    known.max_by(|a, b| record[*a].total_cmp(&record[*b]))
}

/// Standard deviation of the samples before the pulse; `None` where they are few.
fn noise_of(record: &[f64]) -> Option<f64> {
    let top = record[largest(record)?];
    let quiet = record.iter().position(|v| v.abs() > QUIET * top)?;
    let quiet = &record[..quiet / 2];
    (quiet.len() >= ENOUGH).then(|| deviation(quiet))
}

/// The peak of one site's record; times are in samples.
fn peak_of(record: &[f64], noise: Option<f64>) -> Option<MeasuredPeak> {
    let top = largest(record)?;
    if record[top] <= 0.0 || top < REACH || top + REACH >= record.len() {
        return None;
    }
    let v: [f64; 5] = std::array::from_fn(|i| record[top + i - REACH]);
    if v.iter().any(|v| !v.is_finite()) {
        return None;
    }
    // Derivatives of the quartic at the middle sample, by finite differences.
    let slope = (v[0] - 8.0 * v[1] + 8.0 * v[3] - v[4]) / 12.0;
    let bend = (-v[0] + 16.0 * v[1] - 30.0 * v[2] + 16.0 * v[3] - v[4]) / 12.0;
    let third = (-v[0] + 2.0 * v[1] - 2.0 * v[3] + v[4]) / 2.0;
    let fourth = v[0] - 4.0 * v[1] + 6.0 * v[2] - 4.0 * v[3] + v[4];
    let quartic =
        |x: f64| v[2] + x * (slope + x * (bend / 2.0 + x * (third / 6.0 + x * fourth / 24.0)));
    let (at, value) = crate::chain::largest(-1.0, 1.0, quartic);
    // The vertex of the parabola through the three middle samples.
    let (rise, curve) = (0.5 * (v[3] - v[1]), v[1] - 2.0 * v[2] + v[3]);
    let (coarse_at, coarse) = match curve < 0.0 {
        true => (-rise / curve, v[2] - 0.5 * rise * rise / curve),
        false => (0.0, v[2]),
    };
    // The Lagrange weight of sample i at x, and its derivative.
    let weight = |i: usize, x: f64| {
        let node = |k: usize| k as f64 - REACH as f64;
        let others = (0..5).filter(|k| *k != i);
        let factors = others.map(|k| (x - node(k)) / (node(i) - node(k)));
        factors.product::<f64>()
    };
    let change = |i: usize| (weight(i, at + 1e-4) - weight(i, at - 1e-4)) / 2e-4;
    let gain = (0..5).map(|i| weight(i, at).powi(2)).sum::<f64>().sqrt();
    let slope_gain = (0..5).map(|i| change(i).powi(2)).sum::<f64>().sqrt();
    let bend_there = bend + at * (third + 0.5 * at * fourth);
    let sigma = noise.unwrap_or(0.0);
    let velocity_error = (gain * sigma).hypot(value - coarse);
    let time_error = slope_gain * sigma / bend_there.abs().max(f64::MIN_POSITIVE);
    let located = |value, error| Located { value, error };
    Some(MeasuredPeak {
        site: 0,
        velocity: located(value, velocity_error),
        time: located(top as f64 + at, time_error.hypot(at - coarse_at)),
        arrival: rise_of(record, top, 0.5 * value, sigma.hypot(0.5 * velocity_error)),
        noise,
    })
}

/// The last time (in samples) before the largest sample at which a record rises through a level, by
/// the cubic through the two samples on either side. The error combines the error of the level,
/// divided by the slope, and the distance to linear interpolation. `None` with fewer than two
/// samples before the crossing, or for samples that are not finite.
fn rise_of(record: &[f64], top: usize, level: f64, level_error: f64) -> Option<Located> {
    let below = record[..top].iter().rposition(|v| *v < level)?;
    let nodes = record.get(below.checked_sub(1)?..below + 3)?;
    if nodes.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let v: [f64; 4] = std::array::from_fn(|i| nodes[i]);
    // Newton's form on the nodes -1, 0, 1, 2; the crossing lies between 0 and 1.
    let steps = [v[1] - v[0], v[2] - v[1], v[3] - v[2]];
    let bend = (steps[1] - steps[0]) / 2.0;
    let twist = (steps[2] - 2.0 * steps[1] + steps[0]) / 6.0;
    let cubic = |x: f64| v[0] + (x + 1.0) * (steps[0] + x * (bend + (x - 1.0) * twist));
    let at = crate::numeric::find_root(0.0, 1.0, |x| cubic(x) - level);
    let line = (level - v[1]) / steps[1];
    let slope = (cubic(at + 1e-4) - cubic(at - 1e-4)) / 2e-4;
    let off = level_error / slope.abs().max(f64::MIN_POSITIVE);
    Some(Located {
        value: below as f64 + at,
        error: off.hypot(at - line),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A coarsely sampled Gaussian pulse with its peak between samples: the stated error bounds the
    /// true one and is not many times larger.
    #[test]
    fn val_a_gaussian_pulse_is_found_within_the_error_stated() {
        for (width, at) in [(2.0, 50.37), (4.0, 60.5), (8.0, 71.02)] {
            let record: Vec<f64> = (0..128)
                .map(|i| 3.0 * (-0.5 * ((f64::from(i) - at) / width).powi(2)).exp())
                .collect();
            let peak = peak_of(&record, noise_of(&record)).unwrap();
            let arrival = peak.arrival.unwrap();
            let rise = at - width * (2.0 * 2f64.ln()).sqrt();
            for (off, error, most) in [
                (
                    peak.velocity.value - 3.0,
                    peak.velocity.error,
                    0.06 * (2.0f64 / width).powi(4),
                ),
                (arrival.value - rise, arrival.error, 0.1),
                (peak.time.value - at, peak.time.error.max(1e-3), 1.0),
            ] {
                assert!(
                    off.abs() <= error && error < most,
                    "{width}: {off:e} {peak:?}"
                );
            }
        }
    }

    /// With noise, about two thirds of the peaks are within one standard error.
    #[test]
    fn val_errors_cover_as_often_as_a_standard_error_does() {
        let (mut random, mut held, n) = (crate::numeric::Random::new(3), [0; 3], 500);
        for trial in 0..n {
            let at = 60.0 + f64::from(trial) / f64::from(n);
            let record: Vec<f64> = (0..128)
                .map(|i| (-0.5 * ((f64::from(i) - at) / 6.0).powi(2)).exp())
                .map(|pulse| pulse + 0.003 * random.normal())
                .collect();
            let peak = peak_of(&record, noise_of(&record)).unwrap();
            held[0] += i32::from((peak.velocity.value - 1.0).abs() <= peak.velocity.error);
            held[1] += i32::from((peak.time.value - at).abs() <= peak.time.error);
            let arrival = peak.arrival.unwrap();
            let rise = at - 6.0 * (2.0 * 2f64.ln()).sqrt();
            held[2] += i32::from((arrival.value - rise).abs() <= arrival.error);
        }
        let shares = held.map(|h| f64::from(h) / f64::from(n));
        assert!(shares.iter().all(|s| (0.6..0.8).contains(s)), "{shares:?}");
    }

    /// A record that begins during the rise has a peak and no arrival.
    #[test]
    fn what_began_before_the_record_has_no_arrival() {
        let record: Vec<f64> = (0..32)
            .map(|i| (-0.5 * ((f64::from(i) - 4.0) / 6.0).powi(2)).exp())
            .collect();
        let peak = peak_of(&record, noise_of(&record)).unwrap();
        assert!((peak.velocity.value - 1.0).abs() < 1e-6 && peak.arrival.is_none());
        assert!(peak.points(3.0).1.is_none());
    }
}
