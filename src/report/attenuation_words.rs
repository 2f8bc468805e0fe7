//! What attenuation curves say, in words.

use super::number;
use crate::attenuation::{AttenuationLaw, Fits, Reach, Stop, StopCause};

/// Where and why a curve ends.
pub fn stop_sentence(stop: &Stop) -> String {
    let why = match stop.cause {
        StopCause::Reflection => "a reflection would enter there before the pulse is whole",
        StopCause::Faded => "the pulse has faded before the end of the chain",
        StopCause::Failed => "its run failed",
    };
    format!("stops at {} bodies: {why}", stop.bodies)
}

/// The chosen law with its parameters and their intervals.
pub fn law_sentence(fits: &Fits) -> String {
    let chosen = fits.chosen();
    let parameters = chosen.parameters.iter().map(|p| {
        format!(
            "{} = {} ({} to {})",
            p.name,
            number(p.value),
            number(p.low),
            number(p.high)
        )
    });
    let parameters: Vec<String> = parameters.collect();
    format!("{}: {}", law_name(chosen.law), parameters.join(", "))
}

fn law_name(law: AttenuationLaw) -> &'static str {
    match law {
        AttenuationLaw::Level => "c",
        AttenuationLaw::Exponential => "a exp(-r n)",
        AttenuationLaw::PowerLaw => "a n^-p",
        AttenuationLaw::Plateau => "c + a exp(-r n)",
    }
}

/// The length that reaches a target, or why there is none.
pub fn reach_sentence(reach: &Reach, target: f64) -> String {
    match reach {
        Reach::Within { bodies } => format!("at {target} or below from {bodies} bodies on"),
        Reach::Beyond { law, length } => format!(
            "beyond the curve: {} is at {target} after {} bodies ({} to {})",
            law_name(*law),
            number(length.value),
            number(length.low),
            number(length.high)
        ),
        Reach::Never { law, settles_at } => format!(
            "not at {target} by the law so far: {} settles at {}",
            law_name(*law),
            number(*settles_at)
        ),
        Reach::Unknown => format!(
            "{target} is not reached within the lengths computed, and no law that holds for their last third says where it would be"
        ),
    }
}
