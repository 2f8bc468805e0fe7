//! What a bicoherence says.

use ndarray::Array2;
use serde_json::json;

use super::Bicoherence;
use crate::estimates::realisations::REALISATIONS;
use crate::measure::cycles_per;
use crate::sheet::{
    BLUE, Chart, Colors, Describe, HeatChart, Level, PlotRow, Role, Series, Sheet, Units,
    VERMILLION, edges_from_zero, number, percent, range,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Bicoherence b²",
        "|⟨X₁X₂X₃*⟩|² / (⟨|X₁X₂|²⟩ ⟨|X₃|²⟩) at the frequencies f₁, f₂ and f₃ = f₁ + f₂, 0 to 1: the share of the \
         power at f₃ whose phase follows the sum of the phases at f₁ and f₂.",
    ],
    [
        "What it does not say",
        "Which of the three frequencies feeds which. A transfer towards high frequency needs its growth along x, \
         an estimate of the transfer between two sites, or a budget.",
    ],
    [
        "Levels",
        "Without coupling one cell exceeds the level of one cell with the stated probability, and any cell of the \
         whole map the level of the map (a family-wise level: corrected for the number of cells by Sidak). The answer \
         names the share of fields of noise whose strongest triple is as strong; frequencies are said to be coupled in less \
         than 1 % of them, and from there to the level of the map that they may be. Repeated pulses of the same shape \
         are coupled at all frequencies.",
    ],
    [
        "Biphase",
        "The phase of ⟨X₁X₂X₃*⟩: 0 or 180 degrees where crests are peaked or flat, ±90 degrees where one flank is steep.",
    ],
    REALISATIONS,
];

/// The probability of a triple below which frequencies are said to be coupled: noise alone had such triples in 0.4 to 0.95 % of
/// some thousand fields. From here to the level of the map they may be.
const SURE: f64 = 0.005;
/// Triples that are printed at most.
const PRINTED: usize = 5;
/// Triples that a summary lists at most.
const LISTED: usize = 20;

impl Describe for Bicoherence {
    /// Variables: `frequency` (nf); of each triple `first`, `second`, `third` (frequencies), `bicoherence`, `biphase`
    /// (triples); `along_site`, `along_position` (n) and `along_largest`, `along_first`, `along_biphase`,
    /// `along_summed`, `along_largest_level`, `along_summed_level` (nf, n), left out if no site was chosen.
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let (site, output) = (self.site, self.output);
        let at = number(self.space.at(site));
        let mut sheet = Sheet {
            name: "bicoherence",
            version: 2,
            title: match site == output {
                true => format!("Bicoherence of site {site}"),
                false => format!("Bicoherence of site {site} with site {output}"),
            },
            about: format!(
                "two frequencies of site {site} at {at} {space_unit} with their sum at site {output}, times in {time_unit}"
            ),
            answer: self.answer(),
            note: match (self.cell_level().map(number), self.map_level().map(number)) {
                (Some(cell), Some(map)) => format!(
                    "With probability {}, by chance: one cell exceeds {cell}, any of the {} cells {map}.",
                    self.alpha,
                    self.cells()
                ),
                _ => "No significance can be stated: too few independent realisations.".into(),
            },
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
            "site": site,
            "position": self.space.at(site),
            "output": output,
            "output_position": self.space.at(output),
        }));
        self.facts(&mut sheet);
        let level = |level: Option<f64>| match level {
            Some(level) => format!("{} at {}", number(level), percent(self.alpha)),
            None => "not stated: fewer than two independent realisations".into(),
        };
        let rows = [
            ("triples of frequencies", self.cells().to_string()),
            ("level of one cell", level(self.cell_level())),
            ("level of the map", level(self.map_level())),
        ];
        self.independence.describe(&mut sheet, self.segment, rows);
        self.warnings(&mut sheet);
        let along = &self.along;
        sheet.numbers(json!({
            "alpha": self.alpha,
            "cells": self.cells(),
            "cell_level": self.cell_level(),
            "above_cell_level": self.cell_level().map(|level| self.above(level)),
            "correction": "Sidak",
            "map_level": self.map_level(),
            "above_map_level": self.map_level().map(|level| self.above(level)),
            "strongest": self.strongest(LISTED),
            "along": {
                "sites": along.sites,
                "positions": self.positions(),
                "above_level": along.coupled_outputs(),
            },
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let mut rows = vec![
            PlotRow::of([self.map_over_pairs()]).high(1.2),
            PlotRow::of([self.chart_by_output()]),
        ];
        rows.extend(self.map_along().map(|map| PlotRow::of([map])));
        rows
    }
}

impl Bicoherence {
    fn frequency_unit(&self) -> String {
        cycles_per(&self.units().0)
    }

    /// Of the sites along x.
    fn positions(&self) -> Vec<f64> {
        let sites = self.along.sites.iter();
        sites.map(|site| self.space.at(*site)).collect()
    }

    /// Which frequencies are coupled, in words.
    fn answer(&self) -> String {
        let independence = &self.independence;
        let (Some(_), Some(map)) = (self.cell_level(), self.map_level()) else {
            return format!("coupling cannot be told: {}", independence.why_none());
        };
        if independence.is_transient() {
            return "coupling cannot be told: pulses of one shape in every record are coupled at all frequencies".into();
        }
        if self.cells() == 0 {
            return "coupling cannot be told: no triple of frequencies has power at all three"
                .into();
        }
        let at = match self.site == self.output {
            true => format!("at site {}", self.site),
            false => format!("of site {} at site {}", self.site, self.output),
        };
        match (self.above(map), self.strongest(1).first()) {
            (0, _) | (_, None) => format!(
                "no frequencies {at} are coupled with their sum above chance (b² below {})",
                number(map)
            ),
            (count, Some(triple)) => {
                let [first, second, third] = triple.frequencies.map(number);
                let others = match count - 1 {
                    0 => String::new(),
                    1 => ", and one more triple".into(),
                    others => format!(", and {others} more triples"),
                };
                let (are, share) = match triple.chance < SURE {
                    true => ("are", "less than 1 %".into()),
                    false => ("may be", percent(triple.chance)),
                };
                format!(
                    "{first} and {second} {are} coupled with {third} {} {at} (b² {}, which noise reaches in {share} of \
                     fields){others}",
                    self.frequency_unit(),
                    number(triple.bicoherence)
                )
            }
        }
    }

    fn facts(&self, sheet: &mut Sheet) {
        if self.cell_level().is_some() {
            sheet.detail("coupling", self.coupling());
        }
        let unit = self.frequency_unit();
        let level = self.map_level().unwrap_or(f64::NAN);
        for (n, triple) in self.strongest(PRINTED).iter().enumerate() {
            let [first, second, third] = triple.frequencies.map(number);
            let degrees = |angle: f64| format!("{:.0}", angle.to_degrees());
            let half = match triple.biphase_interval.is_finite() {
                true => format!(" ± {}", degrees(triple.biphase_interval)),
                false => String::new(),
            };
            let (b, biphase) = (number(triple.bicoherence), degrees(triple.biphase));
            let text = format!(
                "{first} and {second} with {third} {unit}: b² {b}, biphase {biphase}{half} degrees"
            );
            let name = if n == 0 { "strongest" } else { "" };
            match triple.bicoherence > level {
                true => sheet.fact(name, text),
                false => sheet.detail(name, text),
            }
        }
    }

    fn warnings(&self, sheet: &mut Sheet) {
        let independence = &self.independence;
        if let Some(warning) = independence.alone("record") {
            sheet.warnings.push(warning);
        } else if independence.is_transient() {
            sheet.warn(
                "the records are transients: alike in every shot, they have a bicoherence of 1",
                "compare sites along x, or use a budget if the chain is known",
            );
        }
        if let Some(level) = self.map_level().filter(|level| *level > 0.5) {
            let [level, effective] = [level, independence.effective].map(number);
            sheet.warn(
                format!(
                    "coupling below b² {level} is not seen with {effective} effective realisations"
                ),
                "use shorter segments (--segment), a longer record, or several shots",
            );
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, None);
        let cycles = &units.frequency[..];
        sheet.line("frequency", "frequency", cycles, &self.frequency);
        let df = self.frequency[1];
        for (i, name) in ["first", "second", "third"].into_iter().enumerate() {
            let values = self.map.bins.iter().map(|bins| bins[i] as f64 * df);
            sheet.line(name, "triple", cycles, values.collect::<Vec<f64>>());
        }
        sheet.line("bicoherence", "triple", "", &self.map.bicoherence);
        sheet.line("biphase", "triple", "rad", &self.map.biphase);
        let along = &self.along;
        if along.sites.is_empty() {
            return;
        }
        let sites: Vec<f64> = along.sites.iter().map(|j| *j as f64).collect();
        let (at, x) = ("along_site", &units.space);
        sheet.line("along_site", at, "", sites);
        sheet.line("along_position", at, x, self.positions());
        for (name, unit, array) in [
            ("along_largest", "", &along.largest),
            ("along_first", cycles, &along.first),
            ("along_biphase", "rad", &along.biphase),
            ("along_summed", "", &along.summed),
            ("along_largest_level", "", &along.largest_level),
            ("along_summed_level", "", &along.summed_level),
        ] {
            sheet.plane(name, ["frequency", "along_site"], unit, array);
        }
    }

    /// Over the two frequencies that are added.
    fn map_over_pairs(&self) -> HeatChart {
        let bins = &self.map.bins;
        let last = bins.iter().map(|bins| bins[0]).max().unwrap_or(1);
        let cells = bins.iter().zip(&self.map.bicoherence);
        let cells = cells.map(|([first, second, _], b)| ([*first, *second], *b));
        let unit = self.frequency_unit();
        HeatChart {
            title: "bicoherence b²(f₁, f₂)".into(),
            caption: "Which frequencies are coupled with their sum.".into(),
            x_label: label("frequency f₁", &unit),
            label: "bicoherence b²".into(),
            colors: shown(self.map.bicoherence.iter().copied(), self.map_level()),
            ..over_pairs(cells, last, (self.frequency[1], &unit))
        }
    }

    /// The largest at each output frequency along x; `None` for fewer than two sites.
    fn map_along(&self) -> Option<HeatChart> {
        let along = &self.along;
        let positions = self.positions();
        let level = along.largest_level.iter().copied();
        let level = level.filter(|level| level.is_finite()).reduce(f64::max);
        (positions.len() > 1).then(|| HeatChart {
            title: "along x".into(),
            caption: "The largest bicoherence of all pairs with the sum f₃, at each site.".into(),
            x_label: label("position x", &self.units().1),
            y_label: label("frequency f₃ = f₁ + f₂", &self.frequency_unit()),
            label: "largest b² over f₁".into(),
            x: range(&positions),
            y: edges_from_zero(&self.frequency),
            values: along.largest.clone(),
            colors: shown(along.largest.iter().copied(), level),
            roles: Some([Role::Position, Role::Frequency]),
            ..HeatChart::default()
        })
    }

    /// The largest of the map at each output frequency, and the mean over all pairs.
    fn chart_by_output(&self) -> Chart {
        let bins = self.frequency.len();
        let mut largest = vec![f64::NAN; bins];
        let (mut sums, mut counts) = (vec![0.0; bins], vec![0.0; bins]);
        for ([_, _, third], b) in self.map.bins.iter().zip(&self.map.bicoherence) {
            let third = *third as usize;
            if b.is_finite() {
                largest[third] = b.max(largest[third]);
                sums[third] += b;
                counts[third] += 1.0;
            }
        }
        let means: Vec<f64> = sums.iter().zip(&counts).map(|(s, n)| s / n).collect();
        let levels = [
            (self.map_level(), "level of the map"),
            (self.cell_level(), "level of one cell"),
        ];
        let levels = levels.into_iter().filter_map(|(at, name)| {
            let (at, label) = (at?, name.into());
            Some(Level { at, label })
        });
        Chart {
            levels: levels.collect(),
            ..Chart::of(
                "coupling into each frequency",
                label("frequency f₃ = f₁ + f₂", &self.frequency_unit()),
                "bicoherence b²",
                vec![
                    Series::of("largest", VERMILLION, &self.frequency, &largest),
                    Series::of("mean", BLUE, &self.frequency, &means),
                ],
            )
        }
    }
}

/// The map of cells at a bin, from 1 to the last, and the bin of a second frequency.
pub(super) fn over_pairs(
    cells: impl Iterator<Item = ([isize; 2], f64)> + Clone,
    last: isize,
    (df, unit): (f64, &str),
) -> HeatChart {
    let seconds = || cells.clone().map(|([_, second], _)| second);
    let (lowest, highest) = (seconds().min().unwrap_or(-1), seconds().max().unwrap_or(1));
    let shape = ((highest - lowest + 1) as usize, last as usize);
    let mut values = Array2::from_elem(shape, f64::NAN);
    for ([bin, second], value) in cells {
        values[[(second - lowest) as usize, bin as usize - 1]] = value;
    }
    HeatChart {
        y_label: label("frequency f₂", unit),
        x: 0.5 * df..(last as f64 + 0.5) * df,
        y: (lowest as f64 - 0.5) * df..(highest as f64 + 0.5) * df,
        values,
        roles: Some([Role::Frequency; 2]),
        ..HeatChart::default()
    }
}

/// Colours that show what is above the level.
fn shown(values: impl Iterator<Item = f64>, level: Option<f64>) -> Colors {
    let largest = values.filter(|b| b.is_finite()).fold(0.0, f64::max);
    let top = largest.max(1.2 * level.unwrap_or(0.0)).clamp(0.05, 1.0);
    Colors::Between(0.0..top)
}
