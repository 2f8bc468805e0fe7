//! Names of what figures show, with units; those of axes are the analysis' own.

use std::f64::consts::PI;

pub(super) use crate::analyze::labels::{frequency, position, time, wavenumber};
use crate::analyze::{Analysis, Axes, Extent};
use crate::sheet::{Role, three_digits};

/// The second reading of a wavenumber axis: `k a / π` with the site spacing a.
pub(super) fn wavenumber_reading(axes: &Axes) -> Option<(String, f64)> {
    let factor = axes.space.step / PI;
    (factor.is_finite() && factor > 0.0).then(|| ("k a / π  (a: site spacing)".into(), factor))
}

/// An axis of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Time,
    Space,
    Frequency,
    Wavenumber,
    /// Of both signs.
    SignedWavenumber,
}

impl Side {
    /// What figures show of this axis.
    pub fn extent(self, analysis: &Analysis) -> &Extent {
        let display = &analysis.display;
        match self {
            Side::Time => &display.time,
            Side::Space => &display.space,
            Side::Frequency => &display.frequency,
            Side::Wavenumber => &display.wavenumber,
            Side::SignedWavenumber => &display.wavenumber_signed,
        }
    }

    pub fn label(self, axes: &Axes) -> String {
        match self {
            Side::Time => time(axes),
            Side::Space => position(axes),
            Side::Frequency => frequency(axes),
            Side::Wavenumber | Side::SignedWavenumber => wavenumber(axes),
        }
    }

    pub fn role(self) -> Role {
        match self {
            Side::Time => Role::Time,
            Side::Space => Role::Position,
            Side::Frequency => Role::Frequency,
            Side::Wavenumber | Side::SignedWavenumber => Role::Wavenumber,
        }
    }

    /// The words before a lower and an upper limit, and the unit.
    fn words(self, axes: &Axes) -> ([&'static str; 2], String) {
        match self {
            Side::Time => (["before", "after"], axes.time_unit().to_owned()),
            Side::Space => (["before", "beyond"], axes.space_unit().to_owned()),
            Side::Frequency => (["below", "above"], axes.frequency_unit()),
            Side::Wavenumber | Side::SignedWavenumber => {
                (["below", "above"], axes.wavenumber_unit())
            }
        }
    }
}

/// What a figure over these axes does not show, with its share of the energy; `None` where it shows
/// all. `shares` are left out where they are those of another spectrum.
pub(super) fn not_shown(analysis: &Analysis, sides: &[Side], shares: bool) -> Option<String> {
    let mut parts = Vec::new();
    for &side in sides {
        let extent = side.extent(analysis);
        let ([before, after], unit) = side.words(&analysis.axes);
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
