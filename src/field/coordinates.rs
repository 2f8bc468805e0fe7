//! An axis from coordinates that a file lists.

use wavecascade_formats::Sample;

use super::interpolate::{Interpolant, Interpolation};
use super::note::resampled;
use super::resample::Resample;
use super::{Axis, Note};
use crate::error::{Fault, InputFault};
use crate::measure::{self, Dimension, Measure};
use crate::numeric::median;

/// Deviation from even spacing that is taken for rounding, relative to the length of the axis.
const EVENNESS: f64 = 1e-9;

/// Fewer values may be even by chance where their rounding is not small.
const FEW: usize = 8;

/// An axis as stated by a file; missing parts come from the sidecar or options, else the axis
/// counts indices.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Coordinates {
    pub(crate) origin: Option<f64>,
    pub(crate) step: Option<f64>,
    pub(crate) unit: Option<String>,
}

/// The step before `index` that spoils an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Uneven {
    pub(crate) index: usize,
    pub(crate) expected: f64,
    pub(crate) found: f64,
    /// Whether it is a gap that is too long to be bridged.
    pub(crate) is_gap: bool,
}

impl Uneven {
    /// As a fault of `axis`; `place` names the coordinate at which the step ends.
    pub(crate) fn fault(self, axis: &'static str) -> InputFault {
        let (index, expected, found) = (self.index, self.expected, self.found);
        match self.is_gap {
            true => {
                let limit = Resample::LONGEST_STEP;
                let steps =
                    format!("{axis} steps of at most {limit} medians of {expected} to resample");
                let found = format!("{found} before {axis} index {index}");
                let advice =
                    "fill in missing samples as `nan`, or save both sides as fields of their own";
                Fault::expected(steps, found, advice).into()
            }
            false => InputFault::UnevenAxis {
                axis,
                index,
                expected,
                found,
            },
        }
    }
}

/// What makes coordinates even.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evenness {
    /// Deviation that is jitter, as a share of a step.
    pub(crate) jitter: f64,
    /// How samples at others are resampled, if they may be.
    pub(crate) method: Option<Interpolation>,
}

/// Coordinates that a file lists, as an even axis.
#[derive(Debug, Default)]
pub(crate) struct Listed {
    pub(crate) even: Coordinates,
    /// What they deviate by.
    pub(crate) note: Option<Note>,
    /// By what the samples come to the even axis, if they are not there.
    pub(crate) resampling: Option<Interpolant>,
}

impl Listed {
    /// Coordinates that are even.
    pub(super) fn of(even: Coordinates) -> Listed {
        Listed {
            even,
            ..Listed::default()
        }
    }
}

/// The largest deviation of coordinates from even ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jitter {
    /// In steps.
    pub share: f64,
    /// Where it is.
    pub index: usize,
}

impl Coordinates {
    /// Origin and step of increasing, evenly spaced `values`, each exact to `rounding`.
    ///
    /// Even is what leaves `origin + index * step` by at most `rounding` plus `1e-9` of the
    /// length of the axis, and in no case by more than a twentieth of a step; or what leaves the line of
    /// least squares by no more than about half of `rounding`, of which a step has at least four.
    pub(crate) fn fit(values: &[f64], rounding: f64) -> Result<Coordinates, Uneven> {
        Coordinates::fit_within(values, rounding, 0.0).map(|(even, _)| even)
    }

    /// As [`Coordinates::fit`], with the largest deviation where the rounding of the values is more than a
    /// twentieth of a step; values that are not exact but deviate from the line through the first and
    /// the last by at most `share` of a step are even with a jitter.
    pub(crate) fn fit_within(
        values: &[f64],
        rounding: f64,
        share: f64,
    ) -> Result<(Coordinates, Option<Jitter>), Uneven> {
        let (&[first, .., last], n) = (values, values.len()) else {
            return Ok((Coordinates::from_first(values), None));
        };
        let step = (last - first) / (n - 1) as f64;
        if !(step > 0.0 && step.is_finite()) {
            return Err(worst_step(values, false));
        }
        let tolerance = (EVENNESS * (last - first) + rounding).min(step / 20.0);
        let apart = |i: usize| values[i] - (first + i as f64 * step);
        let even = |step: f64| Coordinates::even(values, step);
        let (of_line, deviation) = line(values);
        let mut coarse = None;
        if !(0..n).all(|i| apart(i).abs() <= tolerance) {
            let index = largest(n, |i| deviation(i).abs());
            let deviation = deviation(index);
            // Half of the rounding from the line that was meant, which this one is near. Numbers of many
            // printed digits are rounded once more.
            let roundings = [rounding, Sample::F64.spacing(values)];
            let explains =
                |rounding: f64| step >= 4.0 * rounding && deviation.abs() <= 0.9 * rounding;
            let is_rounding = n >= FEW && roundings.into_iter().any(explains);
            if !is_rounding || !values.is_sorted_by(|a, b| a < b) {
                let index = largest(n, |i| apart(i).abs());
                let jitter = Jitter {
                    share: apart(index) / step,
                    index,
                };
                return match jitter.share.abs() <= share {
                    true => Ok((even(step), Some(jitter))),
                    false => Err(worst_step(values, false)),
                };
            }
            let share = deviation / of_line;
            coarse = Some(Jitter { share, index });
        }
        let rounding = rounding.max(Sample::F64.spacing(values));
        // Where each value is exact, so are the first and the last.
        let found = match rounding < 1e-6 * step {
            true => step,
            false => of_line,
        };
        let found = meant(found, 1.5 * rounding / (n - 1) as f64);
        Ok((even(found), coarse))
    }

    /// As [`Coordinates::fit_within`]; other values that increase are resampled if `rules` has a method. Values that a
    /// stated `step` gives have that step: from the values alone, it is known only up to rounding. Without rules, the
    /// step is stated elsewhere.
    pub(crate) fn listed(
        axis: &'static str,
        values: &[f64],
        (rounding, step): (f64, Option<f64>),
        rules: Option<Evenness>,
    ) -> Result<Listed, Uneven> {
        let even = |step: f64| Coordinates::even(values, step);
        let Some(rules) = rules else {
            return Ok(Listed::of(Coordinates::beside_stated(values)));
        };
        let is_step = |step: &f64| {
            let (Some(first), Some(last)) = (values.first(), values.last()) else {
                return false;
            };
            let tolerance = rounding + 1e-6 * (last - first).abs();
            let mut places = (0u32..).zip(values);
            *step > 0.0 && places.all(|(i, v)| (v - first - f64::from(i) * step).abs() <= tolerance)
        };
        if let Some(step) = step.filter(|step| step.is_finite()).filter(is_step) {
            return Ok(Listed::of(even(step)));
        }
        let uneven = match Coordinates::fit_within(values, rounding, rules.jitter) {
            Ok((even, jitter)) => {
                // More than is taken for jitter was explained by rounding.
                let is_rounding = |jitter: Jitter| jitter.share.abs() > rules.jitter;
                let note = jitter.map(|jitter| Note::jitter(axis, jitter, is_rounding(jitter)));
                let listed = Listed::of(even);
                return Ok(Listed { note, ..listed });
            }
            Err(uneven) => uneven,
        };
        let (Some(method), &[first, .., last]) = (rules.method, values) else {
            return Err(uneven);
        };
        let is_rising = |pair: &[f64]| pair[1] > pair[0];
        if !(values.windows(2).all(is_rising) && (last - first).is_finite()) {
            return Err(uneven);
        }
        // The worst step is the longest or the shortest one.
        let longest = worst_step(values, true);
        if longest.found > Resample::LONGEST_STEP * longest.expected {
            return Err(longest);
        }
        let step = (last - first) / (values.len() - 1) as f64;
        let place = |i: usize| (first + i as f64 * step).min(last);
        let shift = |i: usize| (values[i] - place(i)) / step;
        let index = largest(values.len(), |i| shift(i).abs());
        let places = (0..values.len()).map(place);
        let resampling = Interpolant::new(method, values.to_vec(), places);
        let share = shift(index);
        let note = resampled(axis, method, Jitter { share, index }, resampling.error());
        Ok(Listed {
            even: even(step),
            note: Some(note),
            resampling: Some(resampling),
        })
    }

    fn even(values: &[f64], step: f64) -> Coordinates {
        Coordinates {
            origin: values.first().copied(),
            step: Some(step),
            unit: None,
        }
    }

    /// Of values whose step is stated elsewhere: their first, and the step that they have if they are even.
    fn beside_stated(values: &[f64]) -> Coordinates {
        /// Share of a step that values of few digits deviate by.
        const NEARLY: f64 = 1e-3;
        let even = Coordinates::fit_within(values, 0.0, NEARLY);
        Coordinates {
            step: even.ok().and_then(|(even, _)| even.step),
            ..Coordinates::from_first(values)
        }
    }

    /// The origin alone.
    pub(crate) fn from_first(values: &[f64]) -> Coordinates {
        Coordinates {
            origin: values.first().copied().filter(|first| first.is_finite()),
            ..Coordinates::default()
        }
    }

    /// The axis; a stated origin, step and unit override those of the file.
    ///
    /// Units are written as symbols. A step or origin with a unit is converted to the unit of the
    /// axis: the stated one, else that of the file, else the first of its dimension. The numbers of
    /// the file are in the unit of the axis.
    pub(crate) fn axis<D: Dimension>(
        self,
        [origin, step]: [Option<Measure<D>>; 2],
        unit: Option<String>,
    ) -> Result<Axis, Fault> {
        let unit = unit
            .or(self.unit)
            .map(|unit| measure::symbol_or::<D>(&unit));
        let typed = |measure: &Option<Measure<D>>| measure.as_ref().is_some_and(|one| one.has_unit);
        let is_typed = typed(&origin) || typed(&step);
        let unit = unit.or_else(|| is_typed.then(|| D::UNITS[0].0.to_owned()));
        let convert = |measure: Measure<D>| {
            let found = unit.clone().unwrap_or_default();
            let converted = measure.in_unit(&found);
            converted.ok_or_else(|| {
                let units = measure::units::<D>();
                let expected = "an axis in a unit that a step or an origin with a unit can be converted to";
                let advice = "state numbers without a unit, or the axis's with `--time-unit` or `--space-unit`";
                Fault::expected(format!("{expected} ({units})"), format!("{found:?}"), advice)
            })
        };
        let origin = origin.map(convert).transpose()?;
        let step = step.map(convert).transpose()?;
        let counted = Axis::index();
        Ok(Axis {
            origin: origin.or(self.origin).unwrap_or(counted.origin),
            step: step.or(self.step).unwrap_or(counted.step),
            unit,
        })
    }
}

/// The step of the line of least squares through at least two values by their index, and by what they deviate from it.
fn line(values: &[f64]) -> (f64, impl Fn(usize) -> f64 + '_) {
    // All count from the first: no digits go to what they have in common.
    let (first, n) = (values[0], values.len() as f64);
    let centre = (n - 1.0) / 2.0;
    let apart = values.iter().map(move |value| value - first);
    let middle = apart.clone().sum::<f64>() / n;
    let places = (0u32..).map(f64::from).zip(apart);
    let moment: f64 = places
        .map(|(i, apart)| (i - centre) * (apart - middle))
        .sum();
    let step = moment / (n * (n * n - 1.0) / 12.0);
    let on_line = move |i: usize| middle + (i as f64 - centre) * step;
    (step, move |i| (values[i] - first) - on_line(i))
}

/// The last index below `n` of the largest value.
fn largest(n: usize, of: impl Fn(usize) -> f64) -> usize {
    let largest = (0..n).max_by(|&a, &b| of(a).total_cmp(&of(b)));
    largest.unwrap_or(0)
}

/// The step that was meant where `step` was found: of `0, 1e-5, ..` in single precision 1e-5, not
/// 9.99999974e-6.
///
/// Within `rounding`, a number, or a number of steps per unit, of so few digits that one is found there by chance
/// in at most a fifth of all cases; within what sums in double precision leave, a number of at most twelve digits.
fn meant(step: f64, rounding: f64) -> f64 {
    let shortest = |value: f64, tolerance: f64| {
        let near = measure::shortest(value, tolerance);
        let text = format!("{near:e}");
        let (digits, exponent) = text.split_once('e')?;
        let decimals = digits.trim_start_matches('-').len().saturating_sub(2) as i32;
        let unit = 10f64.powi(exponent.parse::<i32>().ok()? - decimals);
        (tolerance <= unit / 10.0).then_some(near)
    };
    let rate = || shortest(1.0 / step, rounding / (step * step)).map(|rate| 1.0 / rate);
    let few_digits = || {
        let short = measure::shortest(step, 16.0 * f64::EPSILON * step);
        (format!("{short:.11e}").parse() == Ok(short)).then_some(short)
    };
    let meant = shortest(step, rounding).or_else(rate).or_else(few_digits);
    meant.unwrap_or(step)
}

/// The longest step of values that increase, if they have a gap; else the first step that does not increase, or the one
/// farthest from the median step.
fn worst_step(values: &[f64], is_gap: bool) -> Uneven {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let expected = median(steps.iter().copied()).unwrap_or(0.0).abs();
    let increases = |step: f64| step > 0.0 && step < f64::INFINITY;
    let at = steps.iter().position(|&step| !increases(step));
    let at = at.unwrap_or_else(|| match is_gap {
        true => largest(steps.len(), |i| steps[i]),
        false => largest(steps.len(), |i| (steps[i] - expected).abs()),
    });
    Uneven {
        index: at + 1,
        expected,
        found: steps[at],
        is_gap,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_not_unevenness() {
        let mut time = 0.3;
        let summed: Vec<f64> = (0..100_000)
            .map(|_| {
                time += 0.1;
                time
            })
            .collect();
        let fitted = Coordinates::fit(&summed, 0.0).unwrap();
        assert!((fitted.step.unwrap() / 0.1 - 1.0).abs() < 1e-9);

        let thirds = [0.0, 0.333, 0.667, 1.0];
        assert!(Coordinates::fit(&thirds, 0.0).is_err());
        assert!(Coordinates::fit(&thirds, 0.001).is_ok());
    }

    /// Seconds since 1970 in double precision are multiples of 2^-22.
    #[test]
    fn val_definition_clocks_as_even_as_their_type() {
        let clock = |rate: f64, n: u32| -> Vec<f64> {
            (0..n)
                .map(|i| 1_764_158_400.0 + f64::from(i) / rate)
                .collect()
        };
        let spacing = 2f64.powi(-22);
        // A rate of more digits is known to the rounding alone.
        for (rate, error) in [(3e5, 1e-9), (5e5, 1e-9), (1e6, 1e-9), (9.5e5, 1e-3)] {
            for rounding in [spacing, 1e-6] {
                let even = Coordinates::fit(&clock(rate, 64), rounding).unwrap();
                let found = even.step.unwrap() * rate - 1.0;
                assert!(found.abs() < error, "{rate} {rounding}: {found}");
            }
        }
        // One sample less, and a rate that the type cannot tell.
        let mut gap = clock(1e6, 64);
        gap.remove(30);
        assert!(Coordinates::fit(&gap, spacing).is_err());
        assert!(Coordinates::fit(&clock(3e6, 64), spacing).is_err());
    }

    /// Minutes as hours in single precision: the number of fewest digits, 0.01667, is 2e-4 off.
    #[test]
    fn val_definition_a_step_is_that_of_all_values() {
        for (rate, n) in [(60.0, 100), (60.0, 1000), (70.0, 300), (59.97, 500)] {
            let values: Vec<f64> = (0..n)
                .map(|i| f64::from((8000.0 + f64::from(i) / rate) as f32))
                .collect();
            let even = Coordinates::fit(&values, 2f64.powi(-11)).unwrap();
            let error = even.step.unwrap() * rate - 1.0;
            assert!(error.abs() < 1e-5, "{rate} {n}: {error}");
        }
    }

    #[test]
    fn a_missing_row_is_found_where_it_is() {
        for missing in 1..9 {
            let values: Vec<f64> = (0..10).filter(|&n| n != missing).map(f64::from).collect();
            let uneven = Coordinates::fit(&values, 1.0).unwrap_err();
            let found = (uneven.index, uneven.expected, uneven.found, uneven.is_gap);
            assert_eq!(found, (missing as usize, 1.0, 2.0, false));
        }
    }
}
