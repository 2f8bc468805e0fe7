//! The varied parameters of a sweep and their values.

use crate::chain::scene::{Kind, properties};
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
    /// [`Error::Request`] that quotes the invalid part, or a key that scenes do not have.
    pub fn parse(text: &str) -> Result<SweptKey> {
        let refuse = |expected: &str| refuse(expected, text);
        let (key, values) = text.split_once('=').unwrap_or_default();
        let key = key.trim().replace('-', "_");
        let values = values.trim();
        if key.is_empty() || values.is_empty() {
            return Err(refuse("KEY=VALUES, such as stiffness_ratio=1:120:400log"));
        }
        let Some(property) = properties().iter().find(|p| p.name == key) else {
            let expected = "a key of scenes (`cascade scene` prints them)";
            return Err(Error::request("vary", expected, format!("`{key}`")));
        };
        let whole = matches!(property.kind, Kind::Whole);
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
                let (numbers, unit) = spaced(from, to, count).map_err(refuse)?;
                let literal = |v: f64| match whole {
                    true => format!("{:.0}", v.round()),
                    false => format!("{v:?}{unit}"),
                };
                let mut values: Vec<String> = numbers.into_iter().map(literal).collect();
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

/// The numbers of FROM:TO:COUNT, in equal steps or equal ratios, and their unit; the error says what is expected.
fn spaced<'t>(
    from: &'t str,
    to: &'t str,
    count: &str,
) -> Result<(Vec<f64>, &'t str), &'static str> {
    let number = |text: &'t str| quantity(text).filter(|(number, _)| number.is_finite());
    let (Some((from, unit)), Some((to, other))) = (number(from), number(to)) else {
        return Err("finite numbers FROM and TO, or numbers with a unit");
    };
    if unit != other {
        return Err("one unit at both ends, such as radius=5mm:20mm:4");
    }
    let count = count.trim();
    let (digits, ratios) = match count.strip_suffix("log") {
        Some(digits) => (digits, true),
        None => (count, false),
    };
    let count = digits.parse().ok();
    let Some(count) = count.filter(|n| (2..=MOST_VALUES).contains(n)) else {
        return Err("a COUNT of 2 to a million, with `log` behind it for equal ratios");
    };
    if ratios && !(from > 0.0 && to > 0.0) {
        return Err("positive FROM and TO for equal ratios");
    }
    let value = |i: usize| {
        let share = i as f64 / (count - 1) as f64;
        match share {
            0.0 => from,
            1.0 => to,
            _ if ratios => from * (to / from).powf(share),
            _ => from + (to - from) * share,
        }
    };
    Ok(((0..count).map(value).collect(), unit))
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
    Error::request("vary", expected, format!("`{found}`"))
}

/// The values of one member, one an axis, in the order of the axes.
pub(super) fn member(axes: &[SweptKey], index: usize) -> Vec<&str> {
    let mut rest = index;
    let mut values = vec![""; axes.len()];
    for (value, axis) in values.iter_mut().zip(axes).rev() {
        *value = &axis.values[rest % axis.values.len()];
        rest /= axis.values.len();
    }
    values
}

/// All combinations of the values of axes, as keys with values, the last axis fastest; of no axes,
/// one without any.
pub(crate) fn combinations(axes: &[SweptKey]) -> Result<Vec<Vec<(String, String)>>> {
    if axes.is_empty() {
        return Ok(vec![Vec::new()]);
    }
    let of = |index| {
        let pairs = axes.iter().zip(member(axes, index));
        pairs
            .map(|(axis, value)| (axis.key.clone(), value.to_owned()))
            .collect()
    };
    Ok((0..count(axes)?).map(of).collect())
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
    let mut all = axes.iter();
    let count = all.try_fold(1usize, |n, axis| n.checked_mul(axis.values.len()));
    match count.filter(|n| *n <= MOST_VALUES) {
        Some(n) if !axes.is_empty() => Ok(n),
        Some(_) => Err(refuse("at least one key to vary", "none")),
        None => Err(refuse("a million members at most", "more")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_each_form() {
        for (text, expected) in [
            ("stiffness_ratio=1:100:3log", "1.0 10.0 100.0"),
            ("stiffness_ratio=1:2:5", "1.0 1.25 1.5 1.75 2.0"),
            ("stiffness-ratio=2,3", "2 3"),
            ("seed=-1:2", "-1 0 1 2"),
            ("sites=10:1000:3log", "10 100 1000"),
            ("sites=1:3:9", "1 2 3"),
            ("ends=wall, free", "wall free"),
            ("radius=5mm:20 mm:4", "5.0mm 10.0mm 15.0mm 20.0mm"),
            ("radius=1mm:100mm:3log", "1.0mm 10.0mm 100.0mm"),
        ] {
            let axis = SweptKey::parse(text).unwrap();
            assert_eq!(axis.values.join(" "), expected, "{text}");
            assert!(text.replace('-', "_").starts_with(&axis.key), "{text}");
        }
        // The ends are exact to the last bit, whatever the rounding of powers.
        let many = SweptKey::parse("stiffness_ratio=0.3:120.7:400log").unwrap();
        assert_eq!([&many.values[0], &many.values[399]], ["0.3", "120.7"]);
    }

    #[test]
    fn what_cannot_be_read_is_refused() {
        let texts = "stifness_ratio=1 stiffness_ratio =1,2 stiffness_ratio= stiffness_ratio=1:2:1 \
            stiffness_ratio=1:2:0 stiffness_ratio=1:2:x stiffness_ratio=0:2:5log \
            stiffness_ratio=nan:2:5 stiffness_ratio=1:inf:5 stiffness_ratio=1.5:3 \
            stiffness_ratio=5:1 stiffness_ratio=1:2:3:4 stiffness_ratio=1,,2 \
            stiffness_ratio=1,1 radius=5mm,5.0mm radius=5mm:20:4 radius=5:20mm:4 \
            radius=5mm:2cm:4 seed=1:99999999999 stiffness_ratio=1:2:99999999999 \
            stiffness_ratio=1:2:-5";
        for text in texts.split(' ') {
            let error = SweptKey::parse(text).unwrap_err();
            let named = error.to_string().contains(text.split('=').next().unwrap());
            assert!(error.is_usage() && named, "{error}");
        }
    }

    #[test]
    fn members_are_the_product_the_last_key_fastest() {
        let axes = ["sites=1,2", "ends=x,y,z"].map(|text| SweptKey::parse(text).unwrap());
        let members: Vec<String> = (0..6).map(|i| member(&axes, i).concat()).collect();
        assert_eq!(members.join(" "), "1x 1y 1z 2x 2y 2z");
        let twice = [axes[0].clone(), axes[0].clone()];
        assert!(count(&twice).is_err() && count(&[]).is_err());
    }
}
