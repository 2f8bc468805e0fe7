//! Values that clap has no parser for.

use std::ops::Range;
use std::str::FromStr;
use std::time::Duration;

use wavecascade::estimates;
use wavecascade::field::{At, Interpolation, Label, Resample, Selection};
use wavecascade::measure::{Dimension, Measure, units};
use wavecascade::sweep::Part;

/// What was read, else what was expected.
trait Read<T> {
    fn else_expected(self, what: &str) -> Result<T, String>;
}

impl<T> Read<T> for Option<T> {
    fn else_expected(self, what: &str) -> Result<T, String> {
        self.ok_or_else(|| format!("expected {what}"))
    }
}

/// What stands on both sides of a mark.
fn two<A: FromStr, B: FromStr>(text: &str, mark: char) -> Option<(A, B)> {
    let (a, b) = text.split_once(mark)?;
    Some((a.trim().parse().ok()?, b.trim().parse().ok()?))
}

/// A number of this kind.
fn number(text: &str, is_one: impl Fn(&f64) -> bool) -> Option<f64> {
    text.trim().parse().ok().filter(is_one)
}

/// `A:B` as sites `A .. B`.
pub fn site_range(text: &str) -> Result<Range<usize>, String> {
    let ends = two(text, ':').filter(|(first, end): &(usize, usize)| first < end);
    let range = ends.map(|(first, end)| first..end);
    range.else_expected("FIRST:END, two site indices, the end excluded and above the first")
}

/// `A:B` as an interval; an end left out is infinite.
pub fn interval(text: &str) -> Result<(f64, f64), String> {
    let end = |text: &str, open: f64| match text.trim() {
        "" => Some(open),
        text => text.parse::<f64>().ok(),
    };
    let ends = text.split_once(':');
    let ends = ends.and_then(|(a, b)| Some((end(a, f64::NEG_INFINITY)?, end(b, f64::INFINITY)?)));
    let expected = "FROM:TO, two numbers of which one may be left out, the lower one first";
    ends.filter(|(from, to)| from <= to).else_expected(expected)
}

/// `NAME=VALUE` as a place on a dimension.
pub fn at(text: &str) -> Result<At, String> {
    let place = text.split_once('=').and_then(|(name, label)| {
        Some(At {
            dimension: name.trim().to_owned(),
            label: Label::parse(label)?,
        })
    });
    place.else_expected("NAME=VALUE, such as y=0.3, y=3mm or y=#2")
}

/// `NAME=FROM:TO` as a part of an axis.
pub fn selection(text: &str) -> Result<Selection, String> {
    let end = |text: &str| match text.trim() {
        "" => Some(None),
        text => Label::parse(text).map(Some),
    };
    let read = || {
        let (name, range) = text.split_once('=')?;
        let (from, to) = range.split_once(':')?;
        Some(Selection {
            dimension: name.trim().to_owned(),
            from: end(from)?,
            to: end(to)?,
        })
    };
    read().else_expected("AXIS=FROM:TO, such as time=0.1:0.4, of which one end may be left out")
}

/// A method for both axes, or `time=METHOD,space=METHOD`.
pub fn resample(text: &str) -> Result<Resample, String> {
    let expected = "nearest, linear or cubic, of one axis as in time=cubic,space=linear";
    let method = |name: &str| {
        let mut all = Interpolation::ALL.into_iter();
        all.find(|method| method.name() == name.trim())
    };
    if let Some(method) = method(text) {
        return Ok(Resample::both(method));
    }
    let mut chosen = Resample::default();
    for part in text.split(',') {
        let (axis, name) = part.split_once('=').else_expected(expected)?;
        let axis = match axis.trim() {
            "time" | "t" => &mut chosen.time,
            "space" | "x" => &mut chosen.space,
            _ => return None::<Resample>.else_expected(expected),
        };
        if axis
            .replace(method(name).else_expected(expected)?)
            .is_some()
        {
            return Err(format!("expected {expected}, found an axis twice"));
        }
    }
    Ok(chosen)
}

/// A number of bytes: `500000000`, `500MB`, `2GiB`, `2G` (binary).
pub fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim().to_ascii_lowercase();
    let (text, base) = match (text.strip_suffix("ib"), text.strip_suffix('b')) {
        (Some(text), _) => (text, 1024.0),
        (None, Some(text)) => (text, 1000.0),
        (None, None) => (&*text, 1024f64),
    };
    let prefix = "kmgt".find(|prefix: char| text.ends_with(prefix));
    let size = number(
        text.strip_suffix(['k', 'm', 'g', 't']).unwrap_or(text),
        |_| true,
    );
    let size = size.map(|size| size * base.powi(prefix.map_or(0, |at| at as i32 + 1)));
    let size = size.filter(|size| (1.0..u64::MAX as f64).contains(size));
    size.map(|size| size as u64)
        .else_expected("a size such as 500MB or 2GiB")
}

/// A time of at least a millisecond, in seconds or with its unit: `90`, `1.5s`, `20min`, `2h`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let (value, factor) = [("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("s", 1.0)]
        .into_iter()
        .find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))
        .unwrap_or((text, 1.0));
    let value = number(value, |_| true);
    let time = value.and_then(|value| Duration::try_from_secs_f64(value * factor).ok());
    let time = time.filter(|time| *time >= Duration::from_millis(1));
    time.else_expected("a time such as 90, 90s, 20min or 2h")
}

/// `K/N`, the K-th of N parts.
pub fn part(text: &str) -> Result<Part, String> {
    let part = two(text, '/').and_then(|(k, n)| Part::new(k, n).ok());
    part.else_expected("K/N with K from 1 to N, such as 2/4")
}

/// The same of the segments of records, of which there are 64 parts at most.
pub fn part_of_segments(text: &str) -> Result<estimates::Part, String> {
    let part = two(text, '/').and_then(|(k, n)| estimates::Part::new(k, n).ok());
    part.else_expected("a part and their number, such as 3/64: from 1/64 to 64/64")
}

/// How much of a segment its neighbour shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Overlap {
    Samples(usize),
    Share(f64),
}

impl Overlap {
    pub fn of(self, segment: usize) -> usize {
        match self {
            Overlap::Samples(n) => n,
            Overlap::Share(share) => (share * segment as f64) as usize,
        }
    }
}

/// Samples that neighbouring segments of a stated length have in common.
pub fn overlap_of(overlap: Option<Overlap>, segment: Option<usize>) -> Option<usize> {
    Some(overlap?.of(segment?))
}

/// A whole number of samples, or a share between 0 and 1 (also `50%`).
pub fn overlap(text: &str) -> Result<Overlap, String> {
    let samples = text.parse().map(Overlap::Samples);
    let read = samples.or_else(|_| share(text).map(Overlap::Share));
    read.ok()
        .else_expected("a number of samples, or a share between 0 and 1 such as 0.5 or 50%")
}

/// `NW,K`: a time-bandwidth product and a number of tapers.
pub fn multitaper(text: &str) -> Result<(f64, usize), String> {
    let tapers = two(text, ',').filter(|(nw, _): &(f64, usize)| nw.is_finite());
    tapers.else_expected("NW,K: a time-bandwidth product and a number of tapers, such as 4,7")
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    number(text, |x| x.is_finite()).else_expected("a finite number")
}

/// A number with a unit of its dimension, or without in the first of them.
pub fn measure<D: Dimension>(text: &str) -> Result<f64, String> {
    Measure::<D>::read(text).map(|measure| measure.value)
}

/// A number in the unit of its axis, or with its own.
pub fn origin<D: Dimension>(text: &str) -> Result<Measure<D>, String> {
    let expected = format!("a finite number, or one with its unit ({})", units::<D>());
    Measure::read(text).ok().else_expected(&expected)
}

/// A measure above 0.
pub fn step<D: Dimension>(text: &str) -> Result<Measure<D>, String> {
    let step = Measure::read(text).ok().filter(|step| step.value > 0.0);
    let expected = format!(
        "a finite number above 0, or one with its unit ({})",
        units::<D>()
    );
    step.else_expected(&expected)
}

/// A share of 0 or more, below 1: `0.01` or `1%`.
pub fn share(text: &str) -> Result<f64, String> {
    let share = match text.trim().strip_suffix('%') {
        Some(percent) => number(percent, |_| true).map(|percent| percent / 100.0),
        None => number(text, |_| true),
    };
    let share = share.filter(|share| (0.0..1.0).contains(share));
    share.else_expected("a share of 0 or more, below 1, as 0.01 or 1%")
}

/// A finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text, |x| x.is_finite() && *x > 0.0).else_expected("a finite number above 0")
}

/// `A:B`, two indices.
pub fn pair(text: &str) -> Result<[usize; 2], String> {
    let pair = two(text, ':').map(|(a, b)| [a, b]);
    pair.else_expected(&format!("A:B, two contacts by index, found {text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_binary_and_decimal_units() {
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5k"), Ok(1536));
        assert_eq!(bytes("500 MB"), Ok(500_000_000));
        for wrong in ["", "GiB", "0", "-1", "2 parsecs", "nan"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn overlaps_are_samples_or_shares() {
        assert_eq!(overlap("256").map(|o| o.of(512)), Ok(256));
        assert_eq!(overlap("0.5").map(|o| o.of(513)), Ok(256));
        assert_eq!(overlap("75%").map(|o| o.of(512)), Ok(384));
        for wrong in ["1.5", "-3", "100%", "half"] {
            assert!(overlap(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn ranges_state_both_ends_or_leave_one_open() {
        assert_eq!(site_range("3:7"), Ok(3..7));
        assert!(site_range("7:3").is_err() && site_range("3").is_err());
        assert_eq!(interval("0.5:"), Ok((0.5, f64::INFINITY)));
        assert!(interval("2:1").is_err() && interval("nan:1").is_err());
    }
}
