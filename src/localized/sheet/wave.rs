//! One wave: its ratio, its properties, its profile.

use serde_json::json;

use super::super::{Alternation, Exact, Snapshot, Wave};
use super::{DIGITS, LOCALIZED, PSI, TIME};
use crate::sheet::{
    BLUE, Chart, Describe, PlotRow, Series, Sheet, VERMILLION, error_size, name_of, number,
};

/// A wave with its profile.
#[derive(Debug, Clone)]
pub struct Profile {
    pub wave: Wave,
    pub snapshot: Snapshot,
}

impl Profile {
    /// With so many times on each side of the centre.
    pub fn of(wave: Wave, half: usize) -> Profile {
        Profile {
            snapshot: wave.profile(half),
            wave,
        }
    }
}

impl Describe for Profile {
    /// Arrays: `time` (nt), in units of the wave's travel time over one cell; `overlap`, `psi`, `force`, `velocity`
    /// (2, nt), of the soft and the stiff contact (or those before and behind the light site) and the sites before them;
    /// `slow`, `fast` (nt); `ratio`, `exponent`, `order` (1).
    fn describe(&self) -> Sheet<'_> {
        let Profile { wave, snapshot } = self;
        let (exact, exponent) = (Exact::of(wave), wave.exponent);
        let (name, ratio) = (exact.ratio.name(), wave.ratio);
        let width = format!("{} sites", number(exact.width));
        let of = name_of(&wave.alternation);
        let title = format!("Localized wave of order {}", wave.order);
        let mut sheet = Sheet {
            about: format!("A dimer whose {of} alternates, exponent {exponent}"),
            answer: format!("a localized wave at {name} {}, {width} wide", number(ratio)),
            definitions: vec![LOCALIZED, TIME, PSI],
            ..Sheet::of("wave", &title, "")
        };
        let error = error_size(exact.error);
        sheet.fact("ratio", format!("{ratio:.DIGITS$}, error {error} of it"));
        let power = 0.5 * (exponent - 1.0) / exponent;
        let speed = format!(
            "{} F^{power:.4} sites per unit of time",
            number(exact.speed_coefficient)
        );
        sheet.fact(
            "speed",
            format!("{speed}, F the peak force in the first contact"),
        );
        sheet.fact("width", width);
        sheet.fact("energy", number(exact.energy));
        sheet.fact("momentum", number(exact.momentum));
        let found = exact.convergence;
        let [residual, tail] = [found.residual, found.tail].map(error_size);
        let text = format!(
            "{residual} of the largest overlap, after {} iterations",
            found.iterations
        );
        sheet.detail("residual", format!("{text}; tail {tail}"));
        sheet.numbers(json!({
            "family": { "alternation": wave.alternation, "exponent": exponent },
            "order": wave.order,
            "exact": exact,
        }));
        sheet.line("time", "time", "", &snapshot.time);
        let dimensions = [("contact", 2), ("time", snapshot.time.len())];
        for (name, values) in [
            ("overlap", &snapshot.overlap),
            ("psi", &snapshot.psi),
            ("force", &snapshot.force),
            ("velocity", &snapshot.velocity),
        ] {
            sheet.variable(name, &dimensions, "", values.concat());
        }
        sheet.line("slow", "time", "", &snapshot.slow);
        sheet.line("fast", "time", "", &snapshot.fast);
        sheet.line("ratio", "wave", "", vec![ratio]);
        sheet.line("exponent", "wave", "", vec![exponent]);
        sheet.line("order", "wave", "", vec![wave.order as f64]);
        sheet
    }

    /// Overlaps as psi = F^(1/p), forces, velocities, slow and fast part.
    fn pictures(&self) -> Vec<PlotRow> {
        let profile = &self.snapshot;
        let contacts = self.wave.alternation.contacts();
        let sites = match self.wave.alternation {
            Alternation::Stiffness => ["before the soft contact", "behind it"],
            Alternation::Mass => ["heavy site", "light site"],
        };
        let end = 0.55 * profile.time[profile.time.len() - 1];
        let chart = |name: &str, y_label: &str, labels: [&str; 2], values: [&Vec<f64>; 2]| {
            let all = labels.into_iter().zip([BLUE, VERMILLION]).zip(values);
            let series = all.map(|((label, colour), values)| {
                let mut series = Series::of(label, colour, &profile.time, values);
                series.points.retain(|point| point.0.abs() <= end);
                series
            });
            Chart {
                x: -end..end,
                ..Chart::of(name, "time (cells)", y_label, series.collect())
            }
        };
        let psi = "ψ = F^(1/p)";
        let Snapshot { slow, fast, .. } = profile;
        let parts = ["slow part", "fast part"];
        PlotRow::grid(
            2,
            [
                chart("overlap", psi, contacts, profile.psi.each_ref()),
                chart("force", "force", contacts, profile.force.each_ref()),
                chart("velocity", "velocity", sites, profile.velocity.each_ref()),
                chart("parts", psi, parts, [slow, fast]),
            ],
        )
    }
}
