//! A chain that starts with a wave: how the wave travels.

use serde_json::json;

use super::super::{Journey, Travel};
use super::LOCALIZED;
use crate::sheet::{
    BLUE, Chart, Column, Describe, PlotRow, Series, Sheet, VERMILLION, error_size, number,
};

const TRAVEL: [Column<Travel>; 4] = [
    ("cells", "", |travel| travel.cells as f64),
    ("shape_change", "", |travel| travel.shape_change),
    ("leak", "", |travel| travel.leak),
    ("energy_drift", "", |travel| travel.energy_drift),
];

impl Describe for Journey {
    /// Arrays: `velocity` (2, sites), at the start and at the end; `cells`, `shape_change`, `leak`, `energy_drift` after
    /// each cell.
    fn describe(&self) -> Sheet<'_> {
        let (name, ratio) = (self.ratio.name(), self.ratio.value());
        let (cells, leak) = (self.arrived.cells, error_size(self.arrived.leak));
        let travels = format!("the wave travels {cells} cells at ratio {}", number(ratio));
        let title = format!("Launched wave of order {}", self.order);
        let mut sheet = Sheet {
            about: format!("A chain of {name} {ratio} that starts with the wave"),
            answer: format!("{travels} and sheds {leak} of its energy a cell"),
            definitions: vec![LOCALIZED],
            ..Sheet::of("launch", &title, "")
        };
        sheet.fact("ratio", ratio.to_string());
        let [fine, coarse] = [1.0, 10.0].map(|factor| error_size(factor * self.local_error));
        let [change, off] = [self.arrived.shape_change, self.stepping_error].map(error_size);
        let runs = format!("runs of local errors {fine} and {coarse} differ by {off}");
        sheet.fact(
            "shape change",
            format!("{change} of the largest velocity; {runs}"),
        );
        sheet.fact("energy drift", error_size(self.arrived.energy_drift));
        sheet.numbers(json!({ "launch": self }));
        let dimensions = [("end", 2), ("site", self.velocity[0].len())];
        sheet.variable("velocity", &dimensions, "", self.velocity.concat());
        sheet.columns("cells", &self.travels, &TRAVEL);
        sheet
    }

    /// Velocities at the start and at the end, in cells from the first one that the wave could be felt in, and how the
    /// shape and the energy kept on the way.
    fn pictures(&self) -> Vec<PlotRow> {
        let [start, end] = &self.velocity;
        let moved = 2 * self.arrived.cells;
        let cell: Vec<f64> = (0..start.len() - moved).map(|j| 0.5 * j as f64).collect();
        let velocities = vec![
            Series::of("at the start", BLUE, &cell, start),
            Series::of("at the end, moved back", VERMILLION, &cell, &end[moved..]),
        ];
        // Zeros are drawn as rounding.
        let along = |label: &str, colour, value: fn(&Travel) -> f64| {
            let point = |t: &Travel| (t.cells as f64, value(t).abs().max(1e-17));
            Series::line(label, colour, self.travels.iter().map(point).collect())
        };
        let changes = vec![
            along("shape change", BLUE, |t| t.shape_change),
            along("energy drift", VERMILLION, |t| t.energy_drift),
        ];
        let velocities = Chart {
            x: 0.0..0.5 * cell.len() as f64,
            ..Chart::of("velocity", "cell", "velocity", velocities)
        };
        let title = "what changes on the way";
        let changes = Chart {
            x: 0.0..self.arrived.cells as f64,
            y: 3e-18..1.0,
            log_y: true,
            ..Chart::of(title, "cells travelled", "relative change", changes)
        };
        PlotRow::grid(2, [velocities, changes])
    }
}
