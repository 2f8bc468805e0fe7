//! The varied parameters of a sweep and their values.

use crate::{Error, Result};

/// More members than this are a slip of the keyboard.
const MOST_VALUES: usize = 1_000_000;

/// One varied key of a scene and its values, each as it would be written in the scene.
///
/// Written `KEY=VALUES`, where VALUES is one of
///
/// ```text
/// 1:120:400log   400 values from 1 to 120, both included, in equal ratios
/// 1:10:19        19 values from 1 to 10, both included, in equal steps
/// 5mm:20mm:4     the same with a unit, one for both ends
/// 1:100          the whole numbers from 1 to 100
/// 2,4,8          these values
/// wall,free      these words
/// ```
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweptKey {
    pub key: String,
    pub values: Vec<String>,
}

impl SweptKey {
    /// Reads `KEY=VALUES`. Values of an integer key are rounded, and repeated ones dropped.
    ///
    /// # Errors
    /// [`Error::Request`] that quotes the invalid part.
    pub fn parse(text: &str, is_whole: impl Fn(&str) -> bool) -> Result<SweptKey> {
        let refuse = |expected: &str| refuse(expected, text);
        let Some((key, values)) = text.split_once('=') else {
            return Err(refuse("KEY=VALUES, such as stiffness_ratio=1:120:400log"));
        };
        let key = key.trim().replace('-', "_");
        let values = values.trim();
        if key.is_empty() || values.is_empty() {
            return Err(refuse("KEY=VALUES, such as stiffness_ratio=1:120:400log"));
        }
        let whole = is_whole(&key);
        let values: Vec<String> = match values.split(':').collect::<Vec<_>>()[..] {
            [_] => values.split(',').map(|v| v.trim().to_owned()).collect(),
            [from, to] => {
                let (from, to) = (integer(from), integer(to));
                let (Some(from), Some(to)) = (from, to) else {
                    return Err(refuse("whole numbers FROM:TO, or FROM:TO:COUNT"));
                };
                if from > to || to.abs_diff(from) as usize >= MOST_VALUES {
                    return Err(refuse("FROM:TO, the lower one first, a million at most"));
                }
                (from..=to).map(|v| v.to_string()).collect()
            }
            [from, to, count] => {
                let spacing = Spacing::parse(from, to, count).map_err(|e| refuse(&e))?;
                let unit = &spacing.unit;
                let literal = |v: f64| match whole {
                    true => format!("{:.0}", v.round()),
                    false => format!("{v:?}{unit}"),
                };
                let mut values: Vec<String> = spacing.values().map(literal).collect();
                values.dedup();
                values
            }
            _ => return Err(refuse("FROM:TO:COUNT with two colons at most")),
        };
        if let Some(at) = values.iter().position(|v| v.is_empty()) {
            return Err(refuse(&format!("a value in place {}", at + 1)));
        }
        // 1 and 1.0 are one value, and so are 5 mm and 5.0mm.
        let plain = |value: &String| match quantity(value) {
            Some((number, unit)) => format!("{number:?}{unit}"),
            None => value.clone(),
        };
        let mut sorted: Vec<String> = values.iter().map(plain).collect();
        sorted.sort();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(refuse(&format!("each value once, not {} twice", pair[0])));
        }
        Ok(SweptKey { key, values })
    }
}

/// Equal steps or equal ratios between two ends.
struct Spacing {
    from: f64,
    to: f64,
    count: usize,
    ratios: bool,
    unit: String,
}

impl Spacing {
    fn parse(from: &str, to: &str, count: &str) -> std::result::Result<Spacing, String> {
        let number = |t: &str| {
            let (number, unit) = quantity(t)?;
            number.is_finite().then(|| (number, unit.to_owned()))
        };
        let (Some((from, unit)), Some((to, other))) = (number(from), number(to)) else {
            return Err("finite numbers FROM and TO, or numbers with a unit".into());
        };
        if unit != other {
            return Err("one unit at both ends, such as radius=5mm:20mm:4".into());
        }
        let count = count.trim();
        let (digits, ratios) = match count.strip_suffix("log") {
            Some(digits) => (digits, true),
            None => (count, false),
        };
        let count = digits.parse::<usize>().ok();
        let Some(count) = count.filter(|n| (2..=MOST_VALUES).contains(n)) else {
            return Err("a COUNT of 2 to a million, with `log` behind it for equal ratios".into());
        };
        if ratios && !(from > 0.0 && to > 0.0) {
            return Err("positive FROM and TO for equal ratios".into());
        }
        Ok(Spacing {
            from,
            to,
            count,
            ratios,
            unit,
        })
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let &Spacing {
            from,
            to,
            count,
            ratios,
            ..
        } = self;
        let last = count - 1;
        (0..count).map(move |i| {
            let share = i as f64 / last as f64;
            match i {
                0 => from,
                i if i == last => to,
                _ if ratios => from * (to / from).powf(share),
                _ => from + (to - from) * share,
            }
        })
    }
}

/// The longest number that a text begins with, and the unit behind it, which may be empty.
pub(crate) fn quantity(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let ends = (1..=text.len())
        .rev()
        .filter(|end| text.is_char_boundary(*end));
    ends.map(|end| text.split_at(end))
        .find_map(|(number, unit)| Some((number.trim().parse().ok()?, unit.trim())))
}

fn integer(text: &str) -> Option<i64> {
    text.trim().parse().ok()
}

fn refuse(expected: &str, found: &str) -> Error {
    Error::Request {
        option: "vary",
        expected: expected.to_owned(),
        found: format!("`{found}`"),
    }
}

/// The values of one member, one an axis, in the order of the axes.
pub(super) fn member(axes: &[SweptKey], index: usize) -> Vec<&str> {
    let mut rest = index;
    let mut values: Vec<&str> = axes
        .iter()
        .rev()
        .map(|axis| {
            let value = &axis.values[rest % axis.values.len()];
            rest /= axis.values.len();
            value.as_str()
        })
        .collect();
    values.reverse();
    values
}

/// How many members the product of the axes has.
///
/// # Errors
/// [`Error::Request`] for none or too many, or a key that two axes vary.
pub(super) fn count(axes: &[SweptKey]) -> Result<usize> {
    let mut keys: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
    keys.sort_unstable();
    if let Some(pair) = keys.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(refuse("each key once", pair[0]));
    }
    let count = axes
        .iter()
        .try_fold(1usize, |n, axis| n.checked_mul(axis.values.len()))
        .filter(|n| *n <= MOST_VALUES);
    match count {
        Some(n) if !axes.is_empty() => Ok(n),
        Some(_) => Err(refuse("at least one key to vary", "none")),
        None => Err(refuse("a million members at most", "more")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        SweptKey::parse(text, |key| key == "sites").unwrap().values
    }

    #[test]
    fn values_of_each_form() {
        assert_eq!(values("kappa=1:100:3log"), ["1.0", "10.0", "100.0"]);
        assert_eq!(values("kappa=1:2:5"), ["1.0", "1.25", "1.5", "1.75", "2.0"]);
        assert_eq!(values("seed=-1:2"), ["-1", "0", "1", "2"]);
        assert_eq!(values("sites=10:1000:3log"), ["10", "100", "1000"]);
        assert_eq!(values("sites=1:3:9"), ["1", "2", "3"]);
        assert_eq!(values("ends=wall, free"), ["wall", "free"]);
        let radii = ["5.0mm", "10.0mm", "15.0mm", "20.0mm"];
        assert_eq!(values("radius=5mm:20 mm:4"), radii);
        assert_eq!(
            values("radius=1mm:100mm:3log"),
            ["1.0mm", "10.0mm", "100.0mm"]
        );
        let axis = SweptKey::parse("stiffness-ratio=2,3", |_| false).unwrap();
        assert_eq!(axis.key, "stiffness_ratio");
        // The ends are exact to the last bit, whatever the rounding of powers.
        let many = values("kappa=0.3:120.7:400log");
        assert_eq!((many[0].as_str(), many[399].as_str()), ("0.3", "120.7"));
        assert_eq!(many.len(), 400);
    }

    #[test]
    fn what_cannot_be_read_is_refused() {
        for text in [
            "kappa",
            "=1,2",
            "kappa=",
            "kappa=1:2:1",
            "kappa=1:2:0",
            "kappa=1:2:x",
            "kappa=0:2:5log",
            "kappa=nan:2:5",
            "kappa=1:inf:5",
            "kappa=1.5:3",
            "kappa=5:1",
            "kappa=1:2:3:4",
            "kappa=1,,2",
            "kappa=1,1",
            "radius=5mm,5.0 mm",
            "radius=5mm:20:4",
            "radius=5:20mm:4",
            "radius=5mm:2cm:4",
            "seed=1:99999999999",
            "kappa=1:2:99999999999",
            "kappa=1:2:-5",
        ] {
            let error = SweptKey::parse(text, |_| false).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(text),
                "{error}"
            );
        }
    }

    #[test]
    fn members_are_the_product_the_last_key_fastest() {
        let axes = [
            SweptKey::parse("a=1,2", |_| false).unwrap(),
            SweptKey::parse("b=x,y,z", |_| false).unwrap(),
        ];
        assert_eq!(count(&axes).unwrap(), 6);
        assert_eq!(member(&axes, 0), ["1", "x"]);
        assert_eq!(member(&axes, 2), ["1", "z"]);
        assert_eq!(member(&axes, 3), ["2", "x"]);
        let twice = [axes[0].clone(), axes[0].clone()];
        assert!(count(&twice).is_err() && count(&[]).is_err());
    }
}
