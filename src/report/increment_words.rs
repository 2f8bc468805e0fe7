//! What structure functions say, in sentences.

use super::number;
use crate::estimates::{AxisIncrements, ExponentBasis, FieldAxis, Increments};

/// Name and sentence of each finding: flatness, third moment, exponents of each axis.
pub fn increment_sentences(found: &Increments) -> Vec<(String, String)> {
    found
        .axes
        .iter()
        .flat_map(|axis| {
            let name = match axis.axis {
                FieldAxis::Space => "x",
                FieldAxis::Time => "time",
            };
            let mut sentences = vec![
                (format!("flatness, {name}"), flatness(found, axis)),
                (format!("third moment, {name}"), third(found, axis)),
            ];
            sentences.extend(exponents(axis).map(|text| (format!("exponents, {name}"), text)));
            sentences
        })
        .collect()
}

fn unit(found: &Increments, axis: &AxisIncrements) -> String {
    let (time, space) = found.units();
    match axis.axis {
        FieldAxis::Space => space,
        FieldAxis::Time => time,
    }
}

fn with_half(value: f64, half: f64) -> String {
    match half.is_finite() {
        true => format!("{} ± {}", number(value), number(half)),
        false => number(value),
    }
}

fn flatness(found: &Increments, axis: &AxisIncrements) -> String {
    let (Some(first), Some(last)) = (axis.scales.first(), axis.scales.last()) else {
        return "no scale".into();
    };
    let unit = unit(found, axis);
    let at = |m: &crate::estimates::ScaleMoments| {
        let value = with_half(m.flatness, m.flatness_half());
        format!("{value} at {} {unit}", number(m.scale))
    };
    // Intervals apart: no NaN passes.
    let apart = first.flatness - last.flatness > first.flatness_half() + last.flatness_half();
    let verdict = match apart {
        true => "; it grows towards small scales, beyond the intervals",
        false => "",
    };
    match axis.scales.len() {
        1 => at(first),
        _ => format!("{}, {}{verdict}", at(first), at(last)),
    }
}

fn third(found: &Increments, axis: &AxisIncrements) -> String {
    let signs = axis.third_signs(found.alpha);
    let unit = unit(found, axis);
    let count = |of: f64| {
        let scales: Vec<f64> = signs
            .iter()
            .filter(|(_, s)| *s == of)
            .map(|(x, _)| *x)
            .collect();
        let (first, last) = (scales.first()?, scales.last()?);
        Some(format!(
            "at {} of {} scales from {} to {} {unit}",
            scales.len(),
            axis.scales.len(),
            number(*first),
            number(*last)
        ))
    };
    match (count(-1.0), count(1.0)) {
        (None, None) => "its sign is not resolved at any scale".into(),
        (Some(negative), None) => format!("negative {negative}"),
        (None, Some(positive)) => format!("positive {positive}"),
        (Some(negative), Some(positive)) => {
            format!("negative {negative}; positive {positive}")
        }
    }
}

fn exponents(axis: &AxisIncrements) -> Option<String> {
    let fit = axis.exponents.as_ref()?;
    let values = fit.exponents.iter().zip(&fit.half).zip(1..);
    let text: Vec<String> = values
        .map(|((value, half), p)| format!("{p}: {}", with_half(*value, *half)))
        .collect();
    let basis = match fit.basis {
        ExponentBasis::Shots => "intervals over shots",
        ExponentBasis::Regression => "intervals of the regression",
    };
    Some(format!(
        "{}; {} scales from {} to {}, {basis}",
        text.join(", "),
        fit.points,
        number(fit.band[0]),
        number(fit.band[1])
    ))
}
