//! Numbers in sentences.

/// Four digits; in powers of ten where they would be long.
pub fn number(x: f64) -> String {
    if x.is_nan() {
        return "undefined".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    if (1e-3..1e5).contains(&x.abs()) {
        let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.3e}")
    }
}

/// A number with its unit, if it has one.
pub(crate) fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value)).trim().to_owned()
}

/// Up to six significant digits, without zeros at the end.
pub(crate) fn six_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded}")
}

/// Up to three significant digits.
pub(crate) fn three_digits(value: f64) -> String {
    crate::measure::digits(format!("{value:.2e}").parse().unwrap_or(value))
}

/// Two digits in powers of ten: sizes of errors.
pub fn error_size(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        _ => format!("{x:.1e}"),
    }
}

/// A share as a percentage, in powers of ten where two decimals would be 0.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() {
        _ if share.is_nan() => "undefined".into(),
        size if (1e-12..0.005).contains(&size) => format!("{percent:.1e} %"),
        _ => format!("{percent:.2} %"),
    }
}

/// `95 %`, by which an interval of this significance holds.
pub fn confidence(alpha: f64) -> String {
    format!("{} %", 100.0 * ((1.0 - alpha) * 1e4).round() / 1e4)
}

/// A number with half of its interval, to two digits of it, and their unit: `25.0006 ± 0.0017 m/s`.
pub fn with_half(value: f64, half: f64, unit: &str) -> String {
    let with_unit = |text: String| match unit {
        "" => text,
        unit => format!("{text} {unit}"),
    };
    if !(half.is_finite() && half > 0.0 && value.is_finite()) {
        return with_unit(number(value));
    }
    let power = half.log10().floor() as i32;
    let largest = value.abs().max(half).log10().floor() as i32;
    // Exact to rounding.
    let power = power.max(largest - 12);
    if (-4..5).contains(&largest) {
        let digits = (1 - power).max(0) as usize;
        let shown = 10f64.powi(-(digits as i32));
        let half = half.max(0.5 * shown);
        return with_unit(format!("{value:.digits$} ± {half:.digits$}"));
    }
    let digits = (largest - power + 1).max(0) as usize;
    let scale = 10f64.powi(largest);
    with_unit(format!(
        "({:.digits$} ± {:.digits$})e{largest}",
        value / scale,
        half / scale
    ))
}

/// A number with its range, where it has one: `28.52`, `11.75 (9.669 to 14.00)`.
pub fn with_range(least: f64, middle: f64, most: f64) -> String {
    match most - least < 1e-3 * middle {
        true => number(middle),
        false => format!("{} ({} to {})", number(middle), number(least), number(most)),
    }
}

/// The name that a choice has in JSON, as it is typed.
pub fn name_of(choice: &impl serde::Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

/// `a, b and c`.
pub fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_interval() {
        assert_eq!(with_half(25.00056, 0.00167, "m/s"), "25.0006 ± 0.0017 m/s");
        assert_eq!(with_half(3.0003e-5, 1.21e-8, "s"), "(3.0003 ± 0.0012)e-5 s");
        assert_eq!(with_half(1234.6, 37.0, "m"), "1235 ± 37 m");
    }
}
