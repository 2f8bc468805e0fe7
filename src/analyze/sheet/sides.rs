//! What figures show of axes, and what they leave out.

use std::f64::consts::PI;

use crate::analyze::axes::Side;
use crate::analyze::{Analysis, Axes};
use crate::sheet::three_digits;

/// The second reading of a wavenumber axis: `k a / π` with the site spacing a.
pub(super) fn wavenumber_reading(axes: &Axes) -> Option<(String, f64)> {
    let factor = axes.space.step / PI;
    (factor.is_finite() && factor > 0.0).then(|| ("k a / π  (a: site spacing)".into(), factor))
}

/// The words before a lower and an upper limit.
fn words(side: Side) -> [&'static str; 2] {
    match side {
        Side::Time => ["before", "after"],
        Side::Space => ["before", "beyond"],
        _ => ["below", "above"],
    }
}

/// What a figure over these axes does not show, with its share of the energy; `None` where it shows
/// all. `shares` are left out where they are those of another spectrum.
pub(super) fn not_shown(analysis: &Analysis, sides: &[Side], shares: bool) -> Option<String> {
    let mut parts = Vec::new();
    for &side in sides {
        let extent = analysis.display.part(side);
        let ([before, after], unit) = (words(side), side.unit(&analysis.axes));
        let digits = |limit: f64| three_digits(limit).replace('-', "−");
        let mut add = |share: f64, words: &str, limit: f64| {
            let limit = match &*unit {
                "site" | "sample" => format!("{words}{unit} {}", digits(limit)),
                _ => format!("{words}{} {unit}", digits(limit)),
            };
            let known = shares && share.is_finite();
            parts.push(match (known, parts.is_empty()) {
                (false, _) => limit,
                (true, true) => format!("{} of the energy {limit}", percent(share)),
                (true, false) => format!("{} {limit}", percent(share)),
            });
        };
        if side == Side::SignedWavenumber && !extent.is_whole() && extent.low < 0.0 {
            let is_even = (extent.low + extent.high).abs() < 1e-6 * extent.high;
            if is_even {
                add(extent.below + extent.above, "beyond ±", extent.high);
                continue;
            }
        }
        if extent.bins.start > 0 {
            add(extent.below, &format!("{before} "), extent.low);
        }
        if extent.bins.end < extent.count {
            add(extent.above, &format!("{after} "), extent.high);
        }
    }
    (!parts.is_empty()).then(|| format!("not shown: {}", parts.join(", ")))
}

/// Two digits of a share, as percent.
fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "none".into(),
        percent if percent < 1e-4 => "less than 0.0001 %".into(),
        percent => {
            let rounded: f64 = format!("{percent:.1e}").parse().unwrap_or(percent);
            format!("{rounded} %")
        }
    }
}
