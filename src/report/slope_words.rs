//! What a slope says, in sentences.

use super::number;
use crate::estimates::{ExponentBasis, FieldAxis, Slope};

/// Name and sentence of each finding: the slope, its breaks, the shock time.
pub fn slope_sentences(found: &Slope) -> Vec<(String, String)> {
    let (time_unit, space_unit) = found.units();
    let unit = match found.axis {
        FieldAxis::Space => format!("rad/{space_unit}"),
        FieldAxis::Time => crate::measure::cycles_per(&time_unit),
    };
    let law = &found.law;
    let basis = match law.basis {
        ExponentBasis::Shots => format!("interval over {} shots", found.shots),
        ExponentBasis::Regression => "interval of the regression".into(),
    };
    let mut sentences = vec![(
        "slope".to_owned(),
        format!(
            "{} ± {} ({basis}) over {} bins from {} to {} {unit}",
            number(law.slope),
            number(law.half),
            law.points,
            number(law.band[0]),
            number(law.band[1])
        ),
    )];
    if let Some(breaks) = &found.breaks {
        let slopes: Vec<String> = breaks.slopes.iter().map(|slope| number(*slope)).collect();
        let at = breaks
            .at
            .iter()
            .zip(&breaks.intervals)
            .map(|(at, [low, high])| {
                format!(
                    "{} ({} to {}) {unit}",
                    number(*at),
                    number(*low),
                    number(*high)
                )
            });
        let at: Vec<String> = at.collect();
        let text = format!("at {}; slopes {}", at.join(" and "), slopes.join(", "));
        sentences.push(("breaks".to_owned(), text));
    }
    if let Some(steep) = &found.steepening {
        let mut text = format!(
            "{} ± {} {time_unit} (interval of the regression of 1/max|∂v/∂x| over {} frames)",
            number(steep.shock_time),
            number(steep.half),
            steep.frames
        );
        text += &match steep.slope_at_shock.is_finite() {
            true => format!(
                "; slope there {} ± {}",
                number(steep.slope_at_shock),
                number(steep.slope_half)
            ),
            false => "; the record ends before it".into(),
        };
        if steep.slope_after.is_finite() {
            text += &format!(
                ", from 1.5 shock times on {} ({} to {})",
                number(steep.slope_after),
                number(steep.slope_after_range[0]),
                number(steep.slope_after_range[1])
            );
        }
        sentences.push(("shock time".to_owned(), text));
    }
    sentences
}
