//! A chain that starts with a wave: how the wave travels.

use serde_json::json;

use super::super::{Journey, Travel};
use super::LOCALIZED;
use crate::sheet::{BLUE, Chart, Describe, PlotRow, Series, Sheet, VERMILLION, error_size, number};

impl Describe for Journey {
    /// Arrays: `velocity` (2, sites), at the start and at the end; `cells`, `shape_change`, `leak`, `energy_drift` after
    /// each cell.
    fn describe(&self) -> Sheet<'_> {
        let arrived = &self.arrived;
        let ratio = self.ratio.value();
        let mut sheet = Sheet {
            name: "launch",
            version: 1,
            title: format!("Launched wave of order {}", self.order),
            about: format!(
                "A chain of {} {ratio} that starts with the wave",
                self.ratio.name()
            ),
            answer: format!(
                "the wave travels {} cells at ratio {} and sheds {} of its energy a cell",
                arrived.cells,
                number(ratio),
                error_size(arrived.leak)
            ),
            definitions: vec![LOCALIZED],
            ..Sheet::default()
        };
        sheet.fact("ratio", ratio.to_string());
        let text = format!(
            "{} of the largest velocity; runs of local errors {} and {} differ by {}",
            error_size(arrived.shape_change),
            error_size(self.local_error),
            error_size(10.0 * self.local_error),
            error_size(self.stepping_error)
        );
        sheet.fact("shape change", text);
        sheet.fact("energy drift", error_size(arrived.energy_drift));
        sheet.numbers(json!({ "launch": self }));
        let sites = self.velocity[0].len();
        sheet.variable(
            "velocity",
            &[("end", 2), ("site", sites)],
            "",
            self.velocity.concat(),
        );
        sheet.columns(
            "cells",
            &self.travels,
            &[
                ("cells", "", |t: &Travel| t.cells as f64),
                ("shape_change", "", |t| t.shape_change),
                ("leak", "", |t| t.leak),
                ("energy_drift", "", |t| t.energy_drift),
            ],
        );
        sheet
    }

    /// Velocities at the start and at the end, in cells from the first one that the wave could be felt in, and how the
    /// shape and the energy kept on the way.
    fn pictures(&self) -> Vec<PlotRow> {
        let [start, end] = &self.velocity;
        let moved = 2 * self.arrived.cells;
        let length = start.len() - moved;
        let curve = |label: &str, colour, values: &[f64]| {
            let points = values.iter().enumerate();
            let points = points.map(|(j, v)| (0.5 * j as f64, *v));
            Series::line(label, colour, points.collect())
        };
        let velocities = vec![
            curve("at the start", BLUE, &start[..length]),
            curve("at the end, moved back", VERMILLION, &end[moved..]),
        ];
        // Zeros are drawn as rounding.
        let along = |label: &str, colour, value: fn(&Travel) -> f64| {
            let points = self.travels.iter();
            let points = points.map(|t| (t.cells as f64, value(t).abs().max(1e-17)));
            Series::line(label, colour, points.collect())
        };
        let changes = vec![
            along("shape change", BLUE, |t| t.shape_change),
            along("energy drift", VERMILLION, |t| t.energy_drift),
        ];
        PlotRow::grid(
            2,
            [
                Chart {
                    x: 0.0..0.5 * length as f64,
                    ..Chart::of("velocity", "cell", "velocity", velocities)
                },
                Chart {
                    x: 0.0..self.arrived.cells as f64,
                    y: 3e-18..1.0,
                    log_y: true,
                    ..Chart::of(
                        "what changes on the way",
                        "cells travelled",
                        "relative change",
                        changes,
                    )
                },
            ],
        )
    }
}
